//! What the checks build with cargo: packages and features of the default run and of `--all`.
//!
//! All commands of a run select the same packages and features. With another selection cargo may give a dependency other
//! features, and then compiles it and everything above it once more.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

use super::tally::Tally;
use crate::error::Error;
use crate::step::{Step, say};
use crate::system::succeeds;
use crate::workspace::Workspace;

/// The packages of the default run: everything but GPU and MPI.
const DEFAULT: [&str; 6] =
    ["icoray", "icoray-capi", "icoray-progress", "icoray-test-support", "xtask", "contact-sheet"];

/// Those of them that read files of models, which needs NetCDF's library.
pub const READING_FILES: [&str; 4] = ["icoray-netcdf", "icoray-study", "icoray-cli", "icoray-tests"];

/// What the checks are run on.
pub struct Suite<'a> {
    pub workspace: &'a Workspace,
    /// Whether NetCDF's library is there.
    pub reads_files: bool,
}

/// The features of `--all` besides the packages' own.
const FEATURES: &str = "icoray-tests/mpi";
/// The same with the command over ranks, which takes the place of the plain one.
const FEATURES_OF_RANKS: &str = "icoray-tests/mpi,icoray-cli/mpi";

/// A cargo command on the packages of the default run.
fn of_default(suite: &Suite, subcommand: &str) -> Command {
    let mut cargo = suite.workspace.cargo([subcommand, "--no-default-features"]);
    let reading_files = READING_FILES.iter().filter(|_| suite.reads_files);
    cargo.args(DEFAULT.iter().chain(reading_files).flat_map(|package| ["--package", package]));
    cargo
}

/// A cargo command on all packages.
fn of_all(workspace: &Workspace, subcommand: &str, features: &str) -> Command {
    workspace.cargo([subcommand, "--workspace", "--features", features])
}

pub fn default_lints(suite: &Suite, step: &mut Step) -> Result<(), Error> {
    lints(of_default(suite, "clippy"), step)
}

pub fn all_lints(suite: &Suite, step: &mut Step) -> Result<(), Error> {
    lints(of_all(suite.workspace, "clippy", FEATURES_OF_RANKS), step)
}

fn lints(mut clippy: Command, step: &mut Step) -> Result<(), Error> {
    step.quiet(clippy.args(["--all-targets", "--", "-D", "warnings"]))
}

pub fn documentation(suite: &Suite, step: &mut Step) -> Result<(), Error> {
    let mut cargo = of_all(suite.workspace, "doc", FEATURES);
    step.quiet(cargo.arg("--no-deps").env("RUSTDOCFLAGS", "-D warnings"))
}

pub fn default_tests(suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    let mut cargo = of_default(suite, "test");
    tests(suite.workspace, cargo.arg("--no-fail-fast"), step, tally)
}

pub fn all_tests(suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    let mpich = mpich_library(suite.workspace, step)?;
    let mut cargo = of_all(suite.workspace, "test", FEATURES);
    cargo.arg("--no-fail-fast").env("ICORAY_TESTS", "all");
    cargo.envs(mpich.map(|library| ("ICORAY_MPICH_LIBRARY", library)));
    tests(suite.workspace, &mut cargo, step, tally)
}

/// The tests of `icoray render` over ranks: only the command is compiled anew.
pub fn rank_tests(suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    let mut cargo = of_all(suite.workspace, "test", FEATURES_OF_RANKS);
    cargo.args(["--test", "cli", "--", "ranks"]).env("ICORAY_TESTS", "all");
    tests(suite.workspace, &mut cargo, step, tally)
}

/// Runs tests and counts them. Skipped ones list themselves in a file.
fn tests(
    workspace: &Workspace,
    cargo: &mut Command,
    step: &mut Step,
    tally: &mut Tally,
) -> Result<(), Error> {
    let folder = workspace.products("tmp");
    fs::create_dir_all(&folder).map_err(Error::while_doing(folder.display()))?;
    let list = folder.join("skipped-tests");
    fs::write(&list, "").map_err(Error::while_doing(list.display()))?;
    step.note("");
    let (lines, has_succeeded) = printed(cargo.env("ICORAY_SKIPPED", &list))?;
    let skips = fs::read_to_string(&list).map_err(Error::while_doing(list.display()))?;
    tally.add_tests(&lines, &skips, has_succeeded);
    if has_succeeded { Ok(()) } else { Err(Error::Failed("cargo test failed".into())) }
}

/// Runs a command, prints the lines of its standard output as they come, and returns them with whether it succeeded.
fn printed(command: &mut Command) -> Result<(Vec<String>, bool), Error> {
    let mut child = command.stdout(Stdio::piped()).spawn().map_err(Error::while_doing("cargo"))?;
    let mut lines = Vec::new();
    for line in child.stdout.take().into_iter().flat_map(|stdout| BufReader::new(stdout).split(b'\n')) {
        let line = line.map_err(Error::while_doing("the output of cargo"))?;
        let line = String::from_utf8_lossy(&line).into_owned();
        say(&line);
        lines.push(line);
    }
    let status = child.wait().map_err(Error::while_doing("cargo"))?;
    Ok((lines, status.success()))
}

/// The C library built for MPICH, where that is installed beside another MPI.
///
/// mpi-sys does not see that MPICC names another compiler. A profile of its own has it built apart from the other one, together
/// with what depends on it, and nothing else.
fn mpich_library(workspace: &Workspace, step: &mut Step) -> Result<Option<PathBuf>, Error> {
    const MPICC: &str = "mpicc.mpich";
    if !succeeds(MPICC, ["--version"]) {
        return Ok(None);
    }
    let mut cargo = of_all(workspace, "test", FEATURES);
    cargo.args(["--config", "profile.dev.package.mpi-sys.debug=1", "--test", "allocation", "--no-run"]);
    step.quiet(cargo.env("MPICC", MPICC))?;
    // The tests' own build will take its place.
    let name = "libicoray_mpi_test.so";
    let (built, kept) =
        (workspace.products("debug").join("deps").join(name), workspace.products("tmp").join("mpich"));
    fs::create_dir_all(&kept).map_err(Error::while_doing(kept.display()))?;
    fs::copy(&built, kept.join(name)).map_err(Error::while_doing(built.display()))?;
    Ok(Some(kept.join(name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_reads_files_is_left_out_without_their_library() {
        let workspace = Workspace::find().unwrap();
        let packages = |reads_files: bool| {
            let command = of_default(&Suite { workspace: &workspace, reads_files }, "test");
            command.get_args().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>()
        };
        let (with, without) = (packages(true), packages(false));
        assert!(READING_FILES.iter().all(|package| with.iter().any(|word| word == package)));
        assert!(!READING_FILES.iter().any(|package| without.iter().any(|word| word == package)));
        assert!(without.iter().any(|word| word == "icoray-capi"));
    }
}
