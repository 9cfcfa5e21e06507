//! Installs the packages that a subcommand needs and the machine lacks.

use std::ffi::OsStr;
use std::io::{self, IsTerminal};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::error::Error;
use crate::files;
use crate::requirements::Package;
use crate::step::Step;

/// The arguments of apt-get before the packages. It waits for another program that holds its lock.
const INSTALL: [&str; 5] = ["install", "-y", "--no-install-recommends", "-o", "DPkg::Lock::Timeout=60"];

/// A package that is needed, and the reason why it counts as missing.
struct Missing<'a> {
    package: &'a Package,
    reason: String,
}

/// Installs the packages of `needed` that the machine lacks, if `install` allows it.
///
/// # Errors
/// What is missing and what to type, if it cannot be installed; what is still missing after it was installed.
pub fn provide(needed: &[&Package], install: bool, step: &mut Step) -> Result<(), Error> {
    let missing = missing(needed);
    if missing.is_empty() {
        return Ok(());
    }
    let (packages, components) = (names(&missing, false), names(&missing, true));
    if !install {
        return Err(refusal(&missing, "missing, and --no-install forbids installing"));
    }
    missing.iter().for_each(|missing| step.note(&format!("installing {}", described(missing.package))));
    if !packages.is_empty() {
        if !succeeds("apt-get", ["--version"]) {
            return Err(refusal(&missing, "missing, and there is no apt-get to install Debian's packages with"));
        }
        let sudo = sudo(step).ok_or_else(|| refusal(&missing, "missing, and installing takes root's rights"))?;
        apt_get(sudo, &packages, step)?;
    }
    if !components.is_empty() {
        let mut rustup = Command::new("rustup");
        rustup.args(["component", "add"]).args(&components);
        step.quiet(rustup)?;
    }
    let left = self::missing(needed);
    if left.is_empty() { Ok(()) } else { Err(refusal(&left, "not found, although installed")) }
}

fn missing<'a>(needed: &[&'a Package]) -> Vec<Missing<'a>> {
    let lacking = |package: &&'a Package| package.check().err().map(|reason| Missing { package, reason });
    needed.iter().filter_map(lacking).collect()
}

fn names(missing: &[Missing], components: bool) -> Vec<&'static str> {
    let chosen = missing.iter().filter(|missing| missing.package.is_component == components);
    chosen.map(|missing| missing.package.to_install()).collect()
}

fn described(package: &Package) -> String {
    format!("{} ({})", package.to_install(), package.purpose)
}

/// An error that says what is missing, why it is not installed, what to type, and the reason per package.
fn refusal(missing: &[Missing], why: &str) -> Error {
    let (packages, components) = (names(missing, false).join(" "), names(missing, true).join(" "));
    let mut commands = Vec::new();
    if !packages.is_empty() {
        commands.push(format!("`sudo apt-get install -y --no-install-recommends {packages}`"));
    }
    if !components.is_empty() {
        commands.push(format!("`rustup component add {components}`"));
    }
    let all = missing.iter().map(|missing| missing.package.to_install()).collect::<Vec<_>>().join(", ");
    let sentence = format!("{why}: {all}; run {}", commands.join(" and "));
    let reason = |missing: &Missing| format!("  {}: {}", described(missing.package), missing.reason);
    Error::Detailed { sentence, details: missing.iter().map(reason).collect::<Vec<_>>().join("\n") }
}

/// The words before a command that needs root's rights; `None` where there are none to be had. On a terminal, sudo may
/// ask for the password.
fn sudo(step: &mut Step) -> Option<&'static [&'static str]> {
    if output("id", ["-u"]).is_some_and(|id| id == "0") {
        return Some(&[]);
    }
    let asked = |step: &mut Step| {
        step.note("sudo may ask for your password, to install these packages:");
        Command::new("sudo").arg("-v").status().is_ok_and(|status| status.success())
    };
    let may = succeeds("sudo", ["-n", "true"]) || (io::stdin().is_terminal() && asked(step));
    may.then_some(&["sudo", "-n"])
}

/// Installs packages; updates the package lists first where they are absent, or where the installation fails.
fn apt_get(sudo: &[&str], packages: &[&str], step: &mut Step) -> Result<(), Error> {
    let run = |arguments: &[&str], step: &mut Step| {
        // `env` because sudo passes no variables on.
        let words = [sudo, &["env", "DEBIAN_FRONTEND=noninteractive", "apt-get"], arguments].concat();
        let mut command = Command::new(words[0]);
        command.args(&words[1..]);
        step.quiet(command)
    };
    let install = [&INSTALL, packages].concat();
    let have_lists = !files::fitting(Path::new("/var/lib/apt/lists"), "*_Packages*").is_empty();
    if have_lists && run(&install, step).is_ok() {
        return Ok(());
    }
    step.note("updating the package lists, which are absent or out of date");
    // Without the option a failed download of the lists is a warning.
    run(&["update", "-o", "APT::Update::Error-Mode=any"], step)?;
    run(&install, step)
}

/// Whether a program exists and succeeds.
pub fn succeeds<'a>(program: impl AsRef<OsStr>, arguments: impl IntoIterator<Item = &'a str>) -> bool {
    output(program, arguments).is_some()
}

/// The trimmed standard output of a program, if it exists and succeeds.
pub fn output<'a>(program: impl AsRef<OsStr>, arguments: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    output.status.success().then(|| text.trim().to_owned())
}
