//! The cargo commands of the checks, with the packages and features of the default run and of `--all`.
//!
//! All commands of a run select the same packages and features. Another selection may change the features of a
//! dependency, and cargo then compiles it and everything above it again.

use std::ffi::OsString;
use std::path::PathBuf;

use xshell::Cmd;

use super::Record;
use super::programs::{self, Run};
use crate::error::Error;
use crate::step::Step;
use crate::system::output;
use crate::workspace::Workspace;

/// The packages of the default run: everything but GPU, MPI, references and the study.
const DEFAULT: [&str; 15] = [
    "icoray-grid",
    "icoray-scene",
    "icoray-simd",
    "icoray-kernel",
    "icoray-output",
    "icoray",
    "icoray-capi",
    "icoray-live",
    "icoray-dataset",
    "icoray-progress",
    "icoray-shared-memory",
    "first-picture",
    "icoray-test-support",
    "xtask",
    "contact-sheet",
];

/// Further packages of the default run, which read model files and need the NetCDF library.
pub const READING_FILES: [&str; 3] = ["icoray-netcdf", "icoray-cli", "icoray-tests"];

/// Of `--all`: long counts, and valgrind, take longer in `icoray` without optimisation than its compilation with some.
const OPTIMISED: &str = "profile.dev.package.icoray.opt-level=1";

/// Libraries with the sources of `icoray-capi`, whose documentation is its header. `--lib` would select them.
const UNDOCUMENTED: [&str; 4] = ["icoray-capi", "icoray-context", "icoray-capi-test", "icoray-capi-mpi"];

/// The features of `--all` besides the default ones.
const FEATURES: &str = "icoray-tests/mpi";
/// The same with the command `icoray` over ranks, which replaces the plain one.
const FEATURES_OF_RANKS: &str = "icoray-tests/mpi,icoray-cli/mpi";

pub struct Suite<'a> {
    pub workspace: &'a Workspace,
    /// Whether the run has the long checks.
    pub all: bool,
    /// Whether the NetCDF library works.
    pub reads_files: bool,
}

impl Suite<'_> {
    /// A cargo command on the packages of the default run.
    fn cargo_default(&self, subcommand: &str) -> Cmd<'_> {
        let reading_files = READING_FILES.iter().filter(|_| self.reads_files);
        let packages = DEFAULT.iter().chain(reading_files);
        let packages = packages.filter(|name| subcommand != "doc" || !UNDOCUMENTED.contains(name));
        let packages = packages.flat_map(|package| ["--package", package]);
        self.workspace.cargo([subcommand, "--no-default-features"]).args(packages)
    }

    fn cargo_all(&self, subcommand: &str, features: &str) -> Cmd<'_> {
        self.workspace.cargo([subcommand, "--workspace", "--features", features, "--config", OPTIMISED])
    }

    /// A cargo command on the packages of this run, those of `--all` with these features.
    fn cargo(&self, subcommand: &str, features: &str) -> Cmd<'_> {
        if self.all { self.cargo_all(subcommand, features) } else { self.cargo_default(subcommand) }
    }

    /// The variables of this run's tests: its counts, the file in which they list those that they skip, and lavapipe
    /// without optimisations, as its compiler takes most of the GPU tests' time.
    fn variables(&self) -> Vec<(&'static str, OsString)> {
        let counts = self.all.then(|| ("ICORAY_TESTS", "all".into()));
        let always = [("ICORAY_SKIPPED", self.skips().into()), ("GALLIVM_PERF", "nopt".into())];
        always.into_iter().chain(counts).collect()
    }

    fn skips(&self) -> PathBuf {
        self.workspace.products("tmp").join("skipped-tests")
    }
}

pub fn lints(suite: &Suite, step: &mut Step) -> Result<(), Error> {
    step.quiet(suite.cargo("clippy", FEATURES_OF_RANKS).args(["--all-targets", "--", "-D", "warnings"]))
}

pub fn documentation(suite: &Suite, step: &mut Step) -> Result<(), Error> {
    // With the features of the lints, which have compiled the dependencies.
    let excluded = UNDOCUMENTED.iter().filter(|_| suite.all).flat_map(|package| ["--exclude", package]);
    let cargo = suite.cargo("doc", FEATURES_OF_RANKS).args(excluded).arg("--no-deps");
    // Those features include dev-dependencies', which cargo selects only where it selects examples, tests or benches.
    let cargo = cargo.args(["--lib", "--bin", "xtask", "--examples"]);
    step.quiet(cargo.env("RUSTDOCFLAGS", "-D warnings"))
}

/// Packages the crates that are to be published, and compiles each from its own files.
pub fn published(suite: &Suite, step: &mut Step) -> Result<(), Error> {
    step.quiet(suite.workspace.shell.cmd("bash").arg(".ci/packages"))
}

pub fn tests(suite: &Suite, step: &mut Step, record: &mut Record) -> Result<(), Error> {
    let mut variables = suite.variables();
    if suite.all {
        let library = mpich_library(suite, step)?;
        variables.extend(library.map(|library| ("ICORAY_MPICH_LIBRARY", library.into_os_string())));
    }
    let run = Run { variables, filter: "" };
    counted(suite, record, |record| {
        programs::run(suite.workspace, || suite.cargo("test", FEATURES), &run, step, record)
    })
}

/// The tests of `icoray render` over ranks: only the command is compiled again.
pub fn rank_tests(suite: &Suite, step: &mut Step, record: &mut Record) -> Result<(), Error> {
    let cargo = || suite.cargo_all("test", FEATURES_OF_RANKS).args(["--test", "cli"]);
    let run = Run { variables: suite.variables(), filter: "ranks" };
    counted(suite, record, |record| programs::run(suite.workspace, cargo, &run, step, record))
}

/// The examples in the documentation of the code.
pub fn examples(suite: &Suite, step: &mut Step, record: &mut Record) -> Result<(), Error> {
    let cargo = suite.cargo("test", FEATURES).args(["--doc", "--no-fail-fast"]).envs(suite.variables());
    let (lines, outcome) = step.echoed(cargo, || {});
    record.tally.add_tests(&lines.join("\n"), outcome.is_ok());
    outcome
}

/// Runs tests, and counts those that skipped themselves: they are listed in a file.
fn counted(
    suite: &Suite,
    record: &mut Record,
    run: impl FnOnce(&mut Record) -> Result<(), Error>,
) -> Result<(), Error> {
    let sh = &suite.workspace.shell;
    sh.write_file(suite.skips(), "")?;
    let outcome = run(record);
    record.tally.add_skips(&sh.read_file(suite.skips())?);
    outcome
}

/// The C library built for MPICH, where that is installed beside another MPI.
///
/// mpi-sys does not notice that MPICC names another compiler. A profile of its own makes cargo build it, and what
/// depends on it, apart from the build for the other MPI.
fn mpich_library(suite: &Suite, step: &mut Step) -> Result<Option<PathBuf>, Error> {
    const MPICC: &str = "mpicc.mpich";
    if output(MPICC, ["--version"]).is_none() {
        return Ok(None);
    }
    let profile = ["--config", "profile.dev.package.mpi-sys.debug=1"];
    let cargo = suite.cargo_all("test", FEATURES).args(profile).args(["--test", "allocation", "--no-run"]);
    step.quiet(cargo.env("MPICC", MPICC))?;
    // The build of the tests overwrites it.
    let name = "libicoray_mpi_test.so";
    let sh = &suite.workspace.shell;
    let copy = sh.create_dir(suite.workspace.products("tmp").join("mpich"))?.join(name);
    sh.copy_file(suite.workspace.products("debug").join("deps").join(name), &copy)?;
    Ok(Some(copy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn packages_that_read_files_are_left_out_without_their_library() {
        let workspace = Workspace::find().unwrap();
        let packages = |reads_files: bool| {
            let command: Command =
                Suite { workspace: &workspace, all: false, reads_files }.cargo_default("test").into();
            command.get_args().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>()
        };
        let (with, without) = (packages(true), packages(false));
        assert!(READING_FILES.iter().all(|package| with.iter().any(|word| word == package)));
        assert!(!READING_FILES.iter().any(|package| without.iter().any(|word| word == package)));
        assert!(without.iter().any(|word| word == "icoray-capi"));
    }
}
