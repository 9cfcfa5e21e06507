//! The cargo commands of the checks, with the packages and features of the default run and of `--all`.
//!
//! All commands of a run select the same packages and features. Another selection may change the features of a
//! dependency, and cargo then compiles it and everything above it again.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use xshell::Cmd;

use super::tally::Tally;
use crate::error::Error;
use crate::step::{Step, print_line};
use crate::system::succeeds;
use crate::workspace::Workspace;

/// The packages of the default run: everything but GPU and MPI.
const DEFAULT: [&str; 10] = [
    "icoray-grid",
    "icoray-scene",
    "icoray-kernel",
    "icoray-output",
    "icoray",
    "icoray-capi",
    "icoray-progress",
    "icoray-test-support",
    "xtask",
    "contact-sheet",
];

/// Further packages of the default run, which read model files and need the NetCDF library.
pub const READING_FILES: [&str; 4] = ["icoray-netcdf", "icoray-study", "icoray-cli", "icoray-tests"];

/// The features of `--all` besides the default ones.
const FEATURES: &str = "icoray-tests/mpi";
/// The same with the command `icoray` over ranks, which replaces the plain one.
const FEATURES_OF_RANKS: &str = "icoray-tests/mpi,icoray-cli/mpi";

/// The subject of the checks.
pub struct Suite<'a> {
    pub workspace: &'a Workspace,
    pub all: bool,
    /// Whether the NetCDF library works.
    pub reads_files: bool,
    /// Whether Python works.
    pub has_python: bool,
}

impl Suite<'_> {
    /// A cargo command on the packages of the default run.
    fn cargo_default(&self, subcommand: &str) -> Cmd<'_> {
        let reading_files = READING_FILES.iter().filter(|_| self.reads_files);
        let packages = DEFAULT.iter().chain(reading_files).flat_map(|package| ["--package", package]);
        self.workspace.cargo([subcommand, "--no-default-features"]).args(packages)
    }

    /// A cargo command on all packages.
    fn cargo_all(&self, subcommand: &str, features: &str) -> Cmd<'_> {
        self.workspace.cargo([subcommand, "--workspace", "--features", features])
    }
}

pub fn lints(suite: &Suite, step: &mut Step) -> Result<(), Error> {
    let clippy = if suite.all { suite.cargo_all("clippy", FEATURES_OF_RANKS) } else { suite.cargo_default("clippy") };
    step.quiet(clippy.args(["--all-targets", "--", "-D", "warnings"]))
}

pub fn documentation(suite: &Suite, step: &mut Step) -> Result<(), Error> {
    step.quiet(suite.cargo_all("doc", FEATURES).arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))
}

pub fn default_tests(suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    tests(suite.workspace, suite.cargo_default("test").arg("--no-fail-fast"), step, tally)
}

pub fn all_tests(suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    let mpich = mpich_library(suite, step)?.map(|library| ("ICORAY_MPICH_LIBRARY", library));
    let cargo = suite.cargo_all("test", FEATURES).arg("--no-fail-fast");
    tests(suite.workspace, cargo.env("ICORAY_TESTS", "all").envs(mpich), step, tally)
}

/// The tests of `icoray render` over ranks: only the command is compiled again.
pub fn rank_tests(suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    let cargo = suite.cargo_all("test", FEATURES_OF_RANKS).args(["--test", "cli", "--", "ranks"]);
    tests(suite.workspace, cargo.env("ICORAY_TESTS", "all"), step, tally)
}

/// Runs tests and counts them. Skipped tests write their names to a file.
fn tests(workspace: &Workspace, cargo: Cmd, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    let list = workspace.products("tmp").join("skipped-tests");
    workspace.shell.write_file(&list, "")?;
    step.note("");
    let (lines, has_succeeded) = printed(cargo.env("ICORAY_SKIPPED", &list))?;
    tally.add_tests(&lines, &workspace.shell.read_file(&list)?, has_succeeded);
    if has_succeeded { Ok(()) } else { Err(Error::Failed("cargo test failed".into())) }
}

/// Runs a command, prints the lines of its standard output as they come, and returns them with whether it succeeded.
pub fn printed(command: impl Into<Command>) -> Result<(Vec<String>, bool), Error> {
    let mut child = command.into().stdout(Stdio::piped()).spawn().map_err(Error::while_doing("cargo"))?;
    let mut lines = Vec::new();
    for line in child.stdout.take().into_iter().flat_map(|stdout| BufReader::new(stdout).split(b'\n')) {
        let line = line.map_err(Error::while_doing("the output of cargo"))?;
        let line = String::from_utf8_lossy(&line).into_owned();
        print_line(&line);
        lines.push(line);
    }
    let status = child.wait().map_err(Error::while_doing("cargo"))?;
    Ok((lines, status.success()))
}

/// The C library built for MPICH, where that is installed beside another MPI.
///
/// mpi-sys does not notice that MPICC names another compiler. A profile of its own makes cargo build it, and what
/// depends on it, apart from the build for the other MPI.
fn mpich_library(suite: &Suite, step: &mut Step) -> Result<Option<PathBuf>, Error> {
    const MPICC: &str = "mpicc.mpich";
    if !succeeds(MPICC, ["--version"]) {
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

    #[test]
    fn packages_that_read_files_are_left_out_without_their_library() {
        let workspace = Workspace::find().unwrap();
        let packages = |reads_files: bool| {
            let command: Command = Suite { workspace: &workspace, all: false, reads_files, has_python: false }
                .cargo_default("test")
                .into();
            command.get_args().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>()
        };
        let (with, without) = (packages(true), packages(false));
        assert!(READING_FILES.iter().all(|package| with.iter().any(|word| word == package)));
        assert!(!READING_FILES.iter().any(|package| without.iter().any(|word| word == package)));
        assert!(without.iter().any(|word| word == "icoray-capi"));
    }
}
