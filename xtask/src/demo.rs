//! `cargo xtask demo`: simulations that render themselves.
//!
//! The first model is in C and needs only a C compiler. The second is in Fortran, on ranks of MPI; if it cannot be
//! built or run, it is left out, and the demo still succeeds.

use std::path::{Path, PathBuf};

use xshell::Cmd;

use crate::error::Error;
use crate::models::{self, ShallowWater};
use crate::mpi::Mpi;
use crate::options::DemoOptions;
use crate::step::{Steps, print_line};
use crate::workspace::Workspace;
use crate::{files, requirements, system};

/// Steps of each model.
const STEPS: usize = 5;
const RANKS: usize = 2;
/// The tracer's grid.
const TRACER: [&str; 4] = ["--level", "5", "--layers", "30"];
/// A run of the shallow-water model of about half a minute on two cores: few layers, and a picture after each day of
/// 270 steps.
const SHALLOW_WATER: [&str; 10] = ["--level", "5", "--layers", "4", "--days", "5", "--dt", "320", "--every", "270"];
/// The scenes of both, below the workspace's root.
const TRACER_SCENE: &str = "examples/scenes/tracer.toml";
const SHALLOW_WATER_SCENE: &str = "examples/scenes/shallow_water.toml";

pub fn run(workspace: &Workspace, options: &DemoOptions, install: bool) -> Result<(), Error> {
    let out = options.out.as_ref().map_or_else(|| workspace.root.join("out/demo"), |path| workspace.given(path));
    let gpu = options.backend.as_ref().is_some_and(|backend| backend != "cpu");
    let demo = Demo { workspace, options, install, out, gpu };
    let mut steps = Steps::new(2 * STEPS);
    demo.tracer(&mut steps)?;
    print_line("");
    if let Err(error) = demo.shallow_water(&mut steps) {
        let cause = error.brief();
        print_line(&format!("\nleft out: the shallow-water model on {RANKS} ranks of MPI, because {cause}"));
    }
    Ok(())
}

struct Demo<'a> {
    workspace: &'a Workspace,
    options: &'a DemoOptions,
    /// Whether missing packages may be installed.
    install: bool,
    out: PathBuf,
    /// Whether the library is built with GPUs, which takes a minute longer.
    gpu: bool,
}

impl<'a> Demo<'a> {
    fn tracer(&self, steps: &mut Steps) -> Result<(), Error> {
        let (workspace, profile) = (self.workspace, &self.options.profile);
        let pictures = Pictures { workspace, folder: self.out.clone(), prefix: "tracer_" };
        // Before the build, which takes minutes.
        pictures.prepare()?;
        steps.run("looking for a C compiler", |step| system::provide(requirements::FOR_C, self.install, step))?;
        let title = format!("building the library (about {} minutes)", if self.gpu { 4 } else { 2 });
        steps.run(&title, |step| step.quiet(self.library()))?;
        steps.run("building the tracer model", |step| step.quiet(models::compile_tracer(workspace, profile)))?;
        let start = steps.started;
        steps.run("running the tracer model (about half a minute)", |step| {
            let scene = self.with_backend(TRACER_SCENE)?;
            let mut is_first = true;
            let products = workspace.products(profile);
            let run = workspace
                .linked(products.join("tracer"), &products)?
                .args(TRACER)
                .arg("--days")
                .arg(self.options.days.to_string());
            let run = run.arg("--scene").arg(scene).arg("--out").arg(&self.out);
            let poll = || {
                if is_first && let Some(picture) = pictures.existing().first() {
                    let seconds = start.elapsed().as_secs_f64();
                    print_line(&format!("first picture after {seconds:.1} s: {}", workspace.shown(picture)));
                    is_first = false;
                }
            };
            step.echoed(run, poll).1
        })?;
        self.show(steps, &pictures)
    }

    /// The second model, from its packages on.
    fn shallow_water(&self, steps: &mut Steps) -> Result<(), Error> {
        let (workspace, profile) = (self.workspace, &self.options.profile);
        let title = format!("looking for Fortran and MPI, for a model on {RANKS} ranks");
        let mpi = steps.run(&title, |step| {
            system::provide(requirements::FOR_DEMO_MPI, self.install, step)?;
            Mpi::find().map_err(Error)
        })?;
        let model = ShallowWater::new(workspace, profile, &mpi);
        let pictures = Pictures { workspace, folder: self.out.join("shallow_water"), prefix: "vorticity_" };
        steps.run("building the library with MPI", |step| {
            model.remove_other_mpi(step)?;
            step.quiet(model.with_mpi(model.library(self.gpu)))
        })?;
        steps.run("building the shallow-water model", |step| step.quiet(model.compile()))?;
        let title = format!("running the shallow-water model on {RANKS} ranks of MPI (about half a minute)");
        steps.run(&title, |step| {
            let scene = self.with_backend(SHALLOW_WATER_SCENE)?;
            pictures.prepare()?;
            let run = model.run(RANKS)?.args(SHALLOW_WATER).arg("--scene").arg(scene);
            step.echoed(run.arg("--out").arg(&pictures.folder), || {}).1
        })?;
        self.show(steps, &pictures)
    }

    /// Makes the contact sheet; prints where it, the pictures and their report are.
    fn show(&self, steps: &mut Steps, pictures: &Pictures) -> Result<(), Error> {
        let taken = pictures.existing();
        let none = || Error(format!("no pictures in {}", pictures.folder.display()));
        let last = taken.last().ok_or_else(none)?;
        steps.run("making the contact sheet", |step| step.quiet(pictures.make_sheet(&self.options.profile)))?;
        let shown = |file: &Path| self.workspace.shown(file);
        print_line(&format!("\npictures ({}), the last one:\n  {}", taken.len(), shown(last)));
        print_line(&format!("contact sheet:\n  {}", shown(&pictures.sheet())));
        print_line(&format!("report with errors and seconds, a line per picture:\n  {}", shown(&pictures.report())));
        Ok(())
    }

    /// The C library, and the program that makes contact sheets.
    ///
    /// The second model's library shares the core with this one. Cargo compiles the core once if its dependencies have
    /// the same features in both calls; see `contact_sheet/Cargo.toml` and the test below.
    fn library(&self) -> Cmd<'a> {
        let cargo = self.workspace.cargo(["build", "--profile", &self.options.profile, "--package", "icoray-capi"]);
        let features = if self.gpu { "icoray-capi/live,icoray-capi/gpu" } else { "icoray-capi/live" };
        cargo.args(["--package", SHEET_PACKAGE, "--no-default-features", "--features", features])
    }

    /// A scene of the workspace, or a copy of it with the backend of the options.
    fn with_backend(&self, scene: &str) -> Result<PathBuf, Error> {
        let (sh, scene) = (&self.workspace.shell, self.workspace.root.join(scene));
        let Some(backend) = &self.options.backend else { return Ok(scene) };
        let copy = self.workspace.products(&self.options.profile).join(files::name(&scene));
        sh.write_file(&copy, format!("backend = \"{backend}\"\n{}", sh.read_file(scene)?))?;
        Ok(copy)
    }
}

/// The package that makes contact sheets.
const SHEET_PACKAGE: &str = "contact-sheet";

/// The pictures of a model in a directory.
struct Pictures<'a> {
    workspace: &'a Workspace,
    folder: PathBuf,
    /// The start of their names.
    prefix: &'static str,
}

impl<'a> Pictures<'a> {
    fn report(&self) -> PathBuf {
        self.folder.join("report.csv")
    }

    fn sheet(&self) -> PathBuf {
        self.folder.join("contact_sheet.png")
    }

    /// Makes the directory, and removes the files that an earlier run left in it. Files of other names are the user's.
    fn prepare(&self) -> Result<(), Error> {
        let sh = &self.workspace.shell;
        sh.create_dir(&self.folder)?;
        let files = self.existing().into_iter().chain([self.report(), self.sheet()]);
        Ok(files.into_iter().try_for_each(|file| sh.remove_path(file))?)
    }

    /// The pictures so far, in order. They are complete when they appear under their names.
    fn existing(&self) -> Vec<PathBuf> {
        files::fitting(&self.folder, &format!("{}*.png", self.prefix))
    }

    /// The command that makes the contact sheet, by the program of [`SHEET_PACKAGE`] in a profile's products.
    fn make_sheet(&self, profile: &str) -> Cmd<'a> {
        let program = self.workspace.shell.cmd(self.workspace.products(profile).join("contact_sheet"));
        program.arg(&self.folder).arg(self.prefix).arg(self.sheet())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::process::Command;

    /// The packages that a cargo command builds, with their features.
    fn packages(command: &Command) -> BTreeSet<String> {
        let mut tree = Command::new(crate::workspace::cargo());
        tree.args(["tree", "--locked", "--edges", "normal", "--prefix", "none", "--format", "{p} {f}"]);
        // `cargo tree` has no profiles.
        let words: Vec<_> =
            command.get_args().skip(1).filter(|word| *word != "--profile" && *word != "release").collect();
        let output = tree.args(words).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        text.lines().map(|line| line.trim_end_matches(" (*)").trim().to_owned()).collect()
    }

    #[test]
    fn both_libraries_are_built_with_one_core() {
        let workspace = Workspace::find().unwrap();
        let profile = "release".to_owned();
        let options = DemoOptions { out: None, backend: None, days: 12.0, profile };
        let mut demo = Demo { workspace: &workspace, options: &options, install: false, out: "".into(), gpu: false };
        let (cc, fortran, run) = ("mpicc".into(), "mpifort".into(), "mpirun".into());
        let mpi = Mpi { cc, fortran, run };
        for gpu in [false, true] {
            demo.gpu = gpu;
            let first = packages(&demo.library().into());
            let second = packages(&ShallowWater::new(&workspace, "release", &mpi).library(gpu).into());
            let name = |line: &str| line.split_once(' ').map(|(name, _)| name.to_owned());
            let names: BTreeSet<_> = first.iter().map(|line| name(line)).collect();
            let both: BTreeSet<_> = second.into_iter().filter(|line| names.contains(&name(line))).collect();
            assert!(both.len() > 50 && both.iter().any(|line| line.starts_with("icoray v")), "{both:#?}");
            let other: Vec<_> = both.difference(&first).collect();
            assert!(other.is_empty(), "compiled again for the second library: {other:#?}");
        }
    }

    #[test]
    fn only_the_models_own_files_are_removed() {
        let workspace = Workspace::find().unwrap();
        let scratch = workspace.shell.create_temp_dir().unwrap();
        let out = scratch.path().join("a/b");
        let pictures = Pictures { workspace: &workspace, folder: out.clone(), prefix: "tracer_" };
        pictures.prepare().unwrap();
        for name in ["tracer_0001.png", "tracer_0000.png", "report.csv", "contact_sheet.png", "mine.png"] {
            workspace.shell.write_file(out.join(name), "").unwrap();
        }
        assert_eq!(pictures.existing(), [out.join("tracer_0000.png"), out.join("tracer_0001.png")]);
        pictures.prepare().unwrap();
        assert_eq!(files::fitting(&out, "*"), [out.join("mine.png")]);
    }
}
