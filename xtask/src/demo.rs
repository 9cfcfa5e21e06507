//! `cargo xtask demo`: simulations that take their own pictures.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::error::Error;
use crate::options::DemoOptions;
use crate::pictures::Pictures;
use crate::report::Summary;
use crate::requirements;
use crate::shallow_water::{self, ShallowWater};
use crate::step::{Steps, say};
use crate::system;
use crate::tracer::{self, Linkage, Tracer};
use crate::workspace::Workspace;

/// As many pictures as are listed one by one; of more, the first and the last.
const LISTED: usize = 30;
const PROFILE: &str = "release";
/// Steps of the model over MPI.
const MPI_STEPS: usize = 3;
const RANKS: usize = 2;

/// Runs the demo: a model in C, and then one in Fortran over MPI, where there is what it needs.
pub fn run(workspace: &Workspace, options: &DemoOptions) -> Result<(), Error> {
    let out = match &options.out {
        Some(out) => workspace.given(out),
        None => workspace.root().join("out/demo"),
    };
    let scene = options.scene.as_ref().map(|scene| workspace.given(scene));
    // Found out now rather than after the build.
    if let Some(scene) = scene.as_ref().filter(|scene| !scene.is_file()) {
        return Err(Error::Failed(format!("no scene file: {}", scene.display())));
    }
    let scene = scene.unwrap_or_else(|| workspace.root().join(tracer::SCENE));
    let scene = with_backend(workspace, &scene, options.backend)?;
    let mut steps = Steps::new(5 + MPI_STEPS);
    let with_mpi = steps.run("looking for system packages", |step| {
        system::provide(requirements::FOR_DEMO, options.install, step)?;
        let what = "the shallow-water model over MPI";
        Ok(system::provide_for(what, requirements::FOR_DEMO_MPI, options.install, step))
    })?;
    if !with_mpi {
        steps.leave_out(MPI_STEPS);
    }
    steps.run("building the library", |step| step.quiet(&mut build(workspace, with_mpi)))?;

    let model = Tracer::new(workspace, PROFILE, Linkage::Shared);
    let pictures = Pictures::new(out.clone(), tracer::PREFIX);
    steps.run("building the tracer model", |step| step.quiet(&mut model.compile()))?;
    let lines = steps.run("running the tracer model", |step| {
        pictures.prepare()?;
        step.echoed(&mut model.run(options.size, &scene, &out)?)
    })?;
    show(workspace, &mut steps, &pictures, &lines)?;
    if !with_mpi {
        return Ok(());
    }

    let model = ShallowWater::new(workspace, PROFILE);
    let pictures = Pictures::new(out.join("shallow_water"), shallow_water::PREFIX);
    say("");
    steps.run("building the shallow-water model", |step| step.quiet(&mut model.compile()))?;
    let scene = with_backend(workspace, &workspace.root().join(shallow_water::SCENE), options.backend)?;
    let title = format!("running the shallow-water model on {RANKS} ranks of MPI");
    let lines = steps.run(&title, |step| {
        pictures.prepare()?;
        step.echoed(&mut model.run(RANKS, &scene, pictures.folder())?)
    })?;
    show(workspace, &mut steps, &pictures, &lines)
}

/// A scene, or a copy of it with another backend.
fn with_backend(workspace: &Workspace, scene: &Path, backend: Option<&str>) -> Result<PathBuf, Error> {
    let (Some(backend), Some(name)) = (backend, scene.file_name()) else {
        return Ok(scene.to_owned());
    };
    let copy = workspace.products(PROFILE).join(name);
    let text = fs::read_to_string(scene).map_err(Error::while_doing(scene.display()))?;
    fs::create_dir_all(workspace.products(PROFILE)).map_err(Error::while_doing(copy.display()))?;
    fs::write(&copy, replaced(&text, backend)).map_err(Error::while_doing(copy.display()))?;
    Ok(copy)
}

/// The scene with `backend`, in place of its own.
fn replaced(scene: &str, backend: &str) -> String {
    let is_other = |line: &&str| {
        let key = line.split_once('=').map(|(key, _)| key.trim());
        key != Some("backend")
    };
    let rest: Vec<&str> = scene.lines().filter(is_other).collect();
    format!("backend = \"{backend}\"\n{}\n", rest.join("\n"))
}

/// All that is written in Rust, in one go: apart from each other, packages ask for other features of what they have in common,
/// and the core would be built anew for each.
fn build(workspace: &Workspace, with_mpi: bool) -> Command {
    let mut cargo = workspace.cargo(["build", "--profile", PROFILE, "--lib", "--example", "contact_sheet"]);
    cargo.args(["--package", "icoray", "--package", "icoray-capi"]);
    if with_mpi {
        // Its own compiler is the one that Fortran's programs are linked with and `mpirun` starts.
        cargo.args(["--package", shallow_water::LIBRARY_PACKAGE]).env_remove("MPICC");
    }
    cargo
}

/// Makes the contact sheet, and says where the pictures are, what they cost, and how far they may be off.
fn show(
    workspace: &Workspace,
    steps: &mut Steps,
    pictures: &Pictures,
    lines: &[String],
) -> Result<(), Error> {
    let taken = pictures.taken()?;
    steps.run("making the contact sheet", |step| step.quiet(&mut pictures.make_sheet(workspace, PROFILE)))?;
    let frames = pictures.frames()?;
    let summary = Summary::find(lines).or_from(&frames);
    say(&format!("\npictures ({}):", taken.len()));
    if let [first, .., last] = taken.as_slice()
        && taken.len() > LISTED
    {
        say(&format!("  {}", workspace.shown(first)));
        say("  ...");
        say(&format!("  {}", workspace.shown(last)));
    } else {
        for picture in &taken {
            say(&format!("  {}", workspace.shown(picture)));
        }
    }
    say(&format!("contact sheet:\n  {}", workspace.shown(&pictures.sheet())));
    say(&format!("report, a line per picture:\n  {}", workspace.shown(&pictures.report())));
    say(&format!("\n{}", summary.table()));
    if let Some(errors) = frames.errors {
        say(&format!("\n{}", errors.sentence()));
    }
    if let Some(ranks) = frames.ranks.filter(|ranks| ranks.count > 1) {
        say(&ranks.sentence());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_backend_takes_the_place_of_the_scenes() {
        let rest = "field = \"q\"\n[camera]\nlon = 0";
        let expected = format!("backend = \"gpu\"\n{rest}\n");
        assert_eq!(replaced(rest, "gpu"), expected);
        assert_eq!(replaced(&format!("  backend= \"cpu\" # so far\n{rest}\n"), "gpu"), expected);
    }
}
