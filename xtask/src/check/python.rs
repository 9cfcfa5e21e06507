//! The Python package: its wheel, built and installed into an environment of its own, and its tests there.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;

use super::Record;
use super::suite::Suite;
use crate::error::Error;
use crate::files;
use crate::step::Step;

/// The package, below the workspace's root.
const PACKAGE: &str = "crates/icoray-python";
/// The file whose text has what the tests need from PyPI.
const REQUIREMENTS: &str = "crates/icoray-python/pyproject.toml";

/// Builds the wheel in cargo's dev profile, as the other tests are, and runs pytest with what the tests need from PyPI.
pub fn tests(suite: &Suite, step: &mut Step, record: &mut Record) -> Result<(), Error> {
    let (workspace, sh) = (suite.workspace, &suite.workspace.shell);
    let environment = environment(suite)?;
    // Written last.
    let mark = environment.join("complete");
    let is_complete = mark.is_file();
    let wheels = workspace.products("tmp").join("python/wheels");
    sh.remove_path(&wheels)?;
    sh.create_dir(&wheels)?;
    if !is_complete {
        sh.remove_path(&environment)?;
        step.quiet(sh.cmd("python3").args(["-m", "venv"]).arg(&environment))?;
    }
    let python = environment.join("bin/python");
    let pip = |subcommand: &str| {
        sh.cmd(&python).args(["-m", "pip", "--disable-pip-version-check", subcommand]).env("CARGO_INCREMENTAL", "0")
    };
    step.note("building the wheel");
    let profile = ("MATURIN_PEP517_ARGS", "--profile dev");
    step.quiet(pip("wheel").env(profile.0, profile.1).args(["--no-deps", "--wheel-dir"]).arg(&wheels).arg(PACKAGE))?;
    let wheel = files::fitting(&wheels, "*.whl").pop().ok_or_else(|| Error("pip has built no wheel".into()))?;
    if is_complete {
        step.quiet(pip("install").args(["--no-deps", "--force-reinstall"]).arg(&wheel))?;
    } else {
        step.note("installing it, with xarray, uxarray and what else the tests need");
        step.quiet(pip("install").arg(format!("{}[test]", wheel.display())))?;
        sh.write_file(mark, "")?;
    }
    let command = workspace.products("debug").join("icoray");
    let command = command.is_file().then_some(("ICORAY_COMMAND", command));
    // Outside of the sources, where Python would find the package without its compiled half.
    let pytest =
        sh.cmd(&python).args(["-m", "pytest", "-q", "-rs", "--color=no", "--durations=5", "-p", "no:cacheprovider"]);
    let pytest = pytest.arg(workspace.root.join(PACKAGE).join("tests")).env("ICORAY_TEST_DATA", workspace.data());
    let (lines, outcome) = step.echoed(pytest.envs(command), || {});
    record.tally.add_pytest(&lines, outcome.is_ok());
    outcome
}

/// The environment with what the tests need, named by a hash of it: it is kept until that, or Python, changes.
fn environment(suite: &Suite) -> Result<PathBuf, Error> {
    let sh = &suite.workspace.shell;
    let version = sh.cmd("python3").arg("--version").quiet().read()?;
    let mut hasher = DefaultHasher::new();
    (sh.read_file(REQUIREMENTS)?, version).hash(&mut hasher);
    let name = format!("environment-{:016x}", hasher.finish());
    Ok(suite.workspace.products("tmp").join("python").join(name))
}
