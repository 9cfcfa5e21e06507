//! Installs the packages that a subcommand needs and the machine lacks.

use std::ffi::OsStr;
use std::process::{Command, Stdio};

use crate::error::Error;
use crate::requirements::Package;
use crate::step::Step;

/// The arguments of apt-get before the packages. It waits for another program that holds its lock.
const INSTALL: [&str; 5] = ["install", "-y", "--no-install-recommends", "-o", "DPkg::Lock::Timeout=60"];
/// The arguments with which a failed download of the package lists is an error.
const UPDATE: [&str; 3] = ["update", "-o", "APT::Update::Error-Mode=any"];

/// A package that is needed, and the reason why it counts as missing.
struct Missing<'a> {
    package: &'a Package,
    reason: String,
}

/// Installs the packages of `needed` that the machine lacks; unless `install`, fails with the command that does.
pub fn provide(needed: &[&Package], install: bool, step: &mut Step) -> Result<(), Error> {
    let missing = missing(needed);
    if missing.is_empty() {
        return Ok(());
    }
    if !install {
        return Err(refusal(&missing, "missing, and --no-install forbids installing"));
    }
    missing.iter().for_each(|missing| step.note(&format!("installing {}", described(missing.package))));
    let failed = |error: Error| Error(format!("{}\n{error}", refusal(&missing, "missing, and not installed")));
    apt_get(&names(&missing), step).map_err(failed)?;
    let left = self::missing(needed);
    if left.is_empty() { Ok(()) } else { Err(refusal(&left, "not found, although installed")) }
}

fn missing<'a>(needed: &[&'a Package]) -> Vec<Missing<'a>> {
    let lacking = |package: &&'a Package| package.check().err().map(|reason| Missing { package, reason });
    needed.iter().filter_map(lacking).collect()
}

fn names(missing: &[Missing]) -> Vec<&'static str> {
    missing.iter().map(|missing| missing.package.to_install()).collect()
}

fn described(package: &Package) -> String {
    format!("{} ({})", package.to_install(), package.purpose)
}

/// An error that says what is missing, why it is not installed, what to type, and the reason per package.
fn refusal(missing: &[Missing], why: &str) -> Error {
    let (list, words) = (names(missing).join(", "), names(missing).join(" "));
    let sentence = format!("{why}: {list}; run `sudo apt-get install -y --no-install-recommends {words}`");
    let reason = |missing: &Missing| format!("  {}: {}", described(missing.package), missing.reason);
    Error::with(&missing.iter().map(reason).collect::<Vec<_>>())(sentence)
}

/// Installs packages, as root or by sudo, which may ask for a password; updates the package lists where that fails, as
/// they may be absent or out of date.
fn apt_get(packages: &[&str], step: &mut Step) -> Result<(), Error> {
    let is_root = output("id", ["-u"]).is_some_and(|id| id == "0");
    let mut run = |arguments: &[&str]| {
        // `env` because sudo passes no variables on.
        let mut command = Command::new(if is_root { "env" } else { "sudo" });
        command.args((!is_root).then_some("env")).args(["DEBIAN_FRONTEND=noninteractive", "apt-get"]).args(arguments);
        step.quiet(command)
    };
    let install = [&INSTALL, packages].concat();
    run(&install).or_else(|_| run(&UPDATE).and_then(|()| run(&install)))
}

/// The trimmed standard output of a program, if it exists and succeeds.
pub fn output<'a>(program: impl AsRef<OsStr>, arguments: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    output.status.success().then(|| text.trim().to_owned())
}
