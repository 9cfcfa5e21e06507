//! `cargo xtask demo`: simulations that take their own pictures.
//!
//! The first model is in C and needs nothing but a C compiler. The second is in Fortran, on ranks of MPI; whatever it lacks, it is
//! left out, and the demo has succeeded with the pictures of the first.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::disk;
use crate::error::Error;
use crate::host::Host;
use crate::mpi::Mpi;
use crate::options::DemoOptions;
use crate::pictures::{Pictures, SHEET_PACKAGE};
use crate::report::Summary;
use crate::requirements;
use crate::shallow_water::{self, ShallowWater};
use crate::step::{Step, Steps, say};
use crate::system;
use crate::tracer::{self, Tracer};
use crate::workspace::Workspace;

/// As many pictures as are listed one by one; of more, the first and the last.
const LISTED: usize = 30;
const PROFILE: &str = "release";
/// Steps of each model.
const STEPS: usize = 5;
const RANKS: usize = 2;
/// Megabytes that the build takes.
const SPACE: u64 = 600;

/// Runs the demo.
pub fn run(workspace: &Workspace, options: &DemoOptions) -> Result<(), Error> {
    let demo = Demo::new(workspace, options)?;
    let mut steps = Steps::new(2 * STEPS);
    demo.tracer(&mut steps)?;
    say("");
    if let Err(error) = demo.shallow_water(&mut steps) {
        say(&left_out(&error));
    }
    Ok(())
}

/// The sentence about the second model, with the last lines of the cause.
fn left_out(error: &Error) -> String {
    format!("\nleft out: the shallow-water model on {RANKS} ranks of MPI, because {}", error.brief())
}

struct Demo<'a> {
    workspace: &'a Workspace,
    options: &'a DemoOptions,
    out: PathBuf,
    /// The tracer's scene.
    scene: PathBuf,
    /// Whether the library is built with GPUs, which takes a minute longer.
    gpu: bool,
}

impl<'a> Demo<'a> {
    /// Finds out before the build what would stop it.
    fn new(workspace: &'a Workspace, options: &'a DemoOptions) -> Result<Self, Error> {
        let out = match &options.out {
            Some(out) => workspace.given(out),
            None => workspace.root().join("out/demo"),
        };
        let scene = match &options.scene {
            Some(scene) => workspace.given(scene),
            None => workspace.root().join(tracer::SCENE),
        };
        let text = fs::read_to_string(&scene)
            .map_err(Error::while_doing(format!("cannot read the scene file {}", scene.display())))?;
        let gpu = wants_gpu(options.backend, &text);
        let products = workspace.products(PROFILE);
        disk::writable(&out, "--out DIR takes another directory for the pictures")?;
        disk::writable(&products, "let CARGO_TARGET_DIR name a directory that can be written")?;
        disk::has_space(
            &products,
            SPACE,
            "free some, or let CARGO_TARGET_DIR name a directory on another disk",
        )?;
        Ok(Self { workspace, options, out, scene, gpu })
    }

    /// The first model.
    fn tracer(&self, steps: &mut Steps) -> Result<(), Error> {
        let workspace = self.workspace;
        let (model, pictures) =
            (Tracer::new(workspace, PROFILE), Pictures::new(self.out.clone(), tracer::PREFIX));
        steps.run("looking for a C compiler", |step| {
            system::provide(requirements::FOR_DEMO, self.options.install, step)
        })?;
        steps.run("building the library", |step| step.quiet(&mut self.library()))?;
        steps.run("building the tracer model", |step| step.quiet(&mut model.compile()))?;
        let start = steps.started();
        let lines = steps.run("running the tracer model", |step| {
            let scene = self.with_backend(&self.scene)?;
            pictures.prepare()?;
            let mut run = model.run(self.options.size, &scene, &self.out)?;
            let mut told = false;
            step.echoed(&mut run, || {
                if let Some(first) = pictures.first().filter(|_| !told) {
                    let seconds = start.elapsed().as_secs_f64();
                    say(&format!("first picture after {seconds:.1} s: {}", workspace.shown(&first)));
                    told = true;
                }
            })
        })?;
        show(workspace, steps, &pictures, &lines)
    }

    /// The second model, with all that it needs.
    fn shallow_water(&self, steps: &mut Steps) -> Result<(), Error> {
        let workspace = self.workspace;
        let title = format!("looking for Fortran and MPI, for a model on {RANKS} ranks");
        let (host, mpi) = steps.run(&title, |step| self.provide_mpi(step))?;
        let model = ShallowWater::new(workspace, PROFILE, &mpi);
        let pictures = Pictures::new(self.out.join("shallow_water"), shallow_water::PREFIX);
        steps.run("building the library with MPI", |step| {
            model.forget_other_mpi(step)?;
            let mut cargo = model.library(self.gpu);
            model.tell(&mut cargo, &host)?;
            step.quiet(&mut cargo)
        })?;
        steps.run("building the shallow-water model", |step| step.quiet(&mut model.compile()))?;
        let title = format!("running the shallow-water model on {RANKS} ranks of MPI");
        let lines = steps.run(&title, |step| {
            let scene = self.with_backend(&workspace.root().join(shallow_water::SCENE))?;
            pictures.prepare()?;
            step.echoed(&mut model.run(RANKS, &scene, pictures.folder())?, || {})
        })?;
        show(workspace, steps, &pictures, &lines)
    }

    fn provide_mpi(&self, step: &mut Step) -> Result<(Host, Mpi), Error> {
        system::provide(requirements::FOR_DEMO_MPI, self.options.install, step)?;
        let host = Host::here()?;
        let mpi = Mpi::find(&host).map_err(|lack| Error::Failed(lack.why))?;
        Ok((host, mpi))
    }

    /// The C library, and the program that makes contact sheets.
    ///
    /// The second model's library shares the core with this one. Cargo compiles it once if all that it depends on has the same
    /// features in both calls; see `contact_sheet/Cargo.toml` and the test below.
    fn library(&self) -> Command {
        let mut cargo = self.workspace.cargo(["build", "--profile", PROFILE]);
        cargo.args(["--package", "icoray-capi", "--package", SHEET_PACKAGE]);
        cargo.args((!self.gpu).then_some("--no-default-features"));
        cargo
    }

    /// A scene, or a copy of it with the backend of the options.
    fn with_backend(&self, scene: &Path) -> Result<PathBuf, Error> {
        let (Some(backend), Some(name)) = (self.options.backend, scene.file_name()) else {
            return Ok(scene.to_owned());
        };
        let copy = self.workspace.products(PROFILE).join(name);
        let text = fs::read_to_string(scene).map_err(Error::while_doing(scene.display()))?;
        fs::write(&copy, replaced(&text, backend)).map_err(Error::while_doing(copy.display()))?;
        Ok(copy)
    }
}

/// Whether a line of a scene sets the backend.
fn sets_backend(line: &str) -> bool {
    line.split_once('=').is_some_and(|(key, _)| key.trim() == "backend")
}

/// Whether a scene is to be drawn on a GPU: because the options say so, or else the scene itself.
fn wants_gpu(backend: Option<&str>, scene: &str) -> bool {
    match backend {
        Some(backend) => backend != "cpu",
        None => scene.lines().any(|line| sets_backend(line) && line.contains("\"gpu\"")),
    }
}

/// The scene with `backend`, in place of its own.
fn replaced(scene: &str, backend: &str) -> String {
    let rest: Vec<&str> = scene.lines().filter(|line| !sets_backend(line)).collect();
    format!("backend = \"{backend}\"\n{}\n", rest.join("\n"))
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

    #[test]
    fn gpus_are_built_only_for_scenes_that_ask_for_them() {
        assert!(!wants_gpu(None, "# backend = \"gpu\"\nfield = \"q\""));
        assert!(!wants_gpu(None, "backend = \"auto\""));
        assert!(wants_gpu(None, "backend = \"gpu\" # any"));
        assert!(wants_gpu(Some("auto"), "") && wants_gpu(Some("gpu"), ""));
        assert!(!wants_gpu(Some("cpu"), "backend = \"gpu\""));
    }

    #[test]
    fn what_is_left_out_is_told_with_its_cause() {
        let details = (1..=20).map(|i| format!("line {i}\n")).collect();
        let error = Error::Detailed { sentence: "`cargo build` ended with exit status: 101".into(), details };
        let told = left_out(&error);
        assert_eq!(told.trim_start().lines().count(), 6, "{told}");
        assert!(
            told.contains("2 ranks of MPI, because `cargo build` ended with")
                && told.ends_with("    line 20"),
            "{told}"
        );
    }

    /// What a cargo command would build of the core and of all below it: packages with their features.
    fn core_with_features(command: &Command) -> Vec<String> {
        let mut tree = Command::new(crate::workspace::cargo());
        tree.args(["tree", "--locked", "--edges", "normal,build", "--prefix", "depth", "--no-dedupe"]);
        tree.args(["--format", " {p} {f}"]).current_dir(env!("CARGO_MANIFEST_DIR"));
        let mut words = command.get_args().skip(1);
        while let Some(word) = words.next() {
            // There is no profile to a tree.
            if word == "--profile" {
                words.next();
            } else {
                tree.arg(word);
            }
        }
        let output = tree.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = String::from_utf8(output.stdout).unwrap();
        let lines: Vec<_> = text.lines().filter_map(|line| line.split_once(' ')).collect();
        let depth = |line: &(&str, &str)| line.0.parse::<usize>().unwrap();
        let core = lines.iter().position(|line| line.1.starts_with("icoray v")).unwrap();
        let below = lines[core + 1..].iter().take_while(|line| depth(line) > depth(&lines[core]));
        let mut found: Vec<_> = below.map(|line| line.1.to_owned()).collect();
        found.sort();
        found.dedup();
        found
    }

    #[test]
    fn both_libraries_are_built_with_one_core() {
        let workspace = Workspace::find().unwrap();
        let (cc, fortran, run) = ("mpicc".into(), "mpifort".into(), "mpirun".into());
        let mpi = Mpi { cc, fortran, run, options: Vec::new(), library: String::new() };
        for gpu in [false, true] {
            let size = crate::options::Size { level: 3, layers: 2, days: 1.0 };
            let options = DemoOptions { out: None, scene: None, backend: None, size, install: false };
            let demo =
                Demo { workspace: &workspace, options: &options, out: "".into(), scene: "".into(), gpu };
            let first = core_with_features(&demo.library());
            let second = core_with_features(&ShallowWater::new(&workspace, PROFILE, &mpi).library(gpu));
            assert!(first.len() > 50 && first.iter().any(|line| line.starts_with("syn v2")), "{first:#?}");
            assert_eq!(first, second);
        }
    }
}
