//! The Python package: its wheel, built and installed into an empty environment, and its tests there.

use std::path::Path;

use super::suite::{Suite, printed};
use super::tally::Tally;
use crate::error::Error;
use crate::files;
use crate::step::Step;

/// The package, below the workspace's root.
const PACKAGE: &str = "crates/icoray-python";

/// Builds the wheel in cargo's dev profile, as the other tests are, and runs pytest with what the tests need from PyPI.
pub fn tests(suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    let (workspace, sh) = (suite.workspace, &suite.workspace.shell);
    let scratch = workspace.products("tmp").join("python");
    sh.remove_path(&scratch)?;
    let wheels = sh.create_dir(scratch.join("wheels"))?;
    let environment = scratch.join("environment");
    step.quiet(sh.cmd("python3").args(["-m", "venv"]).arg(&environment))?;
    let python = environment.join("bin/python");
    let pip = |subcommand: &str| {
        sh.cmd(&python).args(["-m", "pip", "--disable-pip-version-check", subcommand]).env("CARGO_INCREMENTAL", "0")
    };
    step.note("building the wheel");
    let profile = ("MATURIN_PEP517_ARGS", "--profile dev");
    step.quiet(pip("wheel").env(profile.0, profile.1).args(["--no-deps", "--wheel-dir"]).arg(&wheels).arg(PACKAGE))?;
    let wheel = files::fitting(&wheels, "*.whl").pop().ok_or_else(|| Error::Failed("pip has built no wheel".into()))?;
    step.note("installing it, with xarray, uxarray and what else the tests need");
    step.quiet(pip("install").arg(with_extra(&wheel, "test")))?;
    let command = workspace.products("debug").join("icoray");
    let command = command.is_file().then_some(("ICORAY_COMMAND", command));
    // Outside of the sources, where Python would find the package without its compiled half.
    let pytest = sh.cmd(&python).args(["-m", "pytest", "-q", "-rs", "--color=no", "-p", "no:cacheprovider"]);
    let pytest = pytest.arg(workspace.root.join(PACKAGE).join("tests")).env("ICORAY_TEST_DATA", workspace.data());
    let (lines, has_succeeded) = printed(pytest.envs(command))?;
    tally.add_pytest(&lines, has_succeeded);
    if has_succeeded { Ok(()) } else { Err(Error::Failed("pytest failed".into())) }
}

/// A requirement of a wheel with one of its extras.
fn with_extra(wheel: &Path, extra: &str) -> String {
    format!("{}[{extra}]", wheel.display())
}
