//! Installs what the subcommands need and the machine lacks.

use std::ffi::OsStr;
use std::io::{self, IsTerminal};
use std::process::{Command, Stdio};

use crate::apt;
use crate::error::Error;
use crate::host::Host;
use crate::requirements::{Requirement, Source};
use crate::step::Step;

/// Installs what of `needed` does not work, if `install` allows it.
///
/// # Errors
/// What is missing and what to type, if it cannot be installed; what still does not work after its package was
/// installed.
pub fn provide(needed: &[&Requirement], install: bool, step: &mut Step) -> Result<(), Error> {
    let host = Host::here()?;
    let mut tried = Vec::new();
    loop {
        let missing = missing(needed, &host);
        if missing.is_empty() {
            return Ok(());
        }
        // A package that was just installed may need another one.
        if packages(&missing).iter().all(|package| tried.contains(package)) {
            let names = listed(&packages(&missing));
            let sentence = format!("{names} cannot be used although installed, for the reasons below");
            return Err(Error::Detailed { sentence, details: reasons(&missing) });
        }
        let machine = Machine::examine();
        if !install || !machine.can_install(&missing) {
            return Err(refusal(&missing, &machine, install));
        }
        for package in packages(&missing) {
            let first = missing.iter().find(|missing| missing.package == package);
            first.inspect(|missing| step.note(&format!("installing {}", missing.described())));
        }
        let apt = packages_from(Source::Apt, &missing);
        if !apt.is_empty() {
            machine.unlock(&missing, step)?;
            apt::install(&apt, machine.root, step)?;
        }
        let components = packages_from(Source::Rustup, &missing);
        if !components.is_empty() {
            let mut rustup = Command::new("rustup");
            rustup.args(["component", "add"]).args(&components);
            step.quiet(rustup)?;
        }
        tried.extend(packages(&missing));
    }
}

/// Something that is needed and not there.
#[derive(Debug)]
struct Missing<'a> {
    requirement: &'a Requirement,
    /// The package to install.
    package: &'static str,
    why: String,
}

impl Missing<'_> {
    fn described(&self) -> String {
        format!("{} ({})", self.package, self.requirement.purpose)
    }
}

/// Those of `needed` that do not work.
fn missing<'a>(needed: &[&'a Requirement], host: &Host) -> Vec<Missing<'a>> {
    let check = |requirement: &&'a Requirement| {
        let lack = requirement.check(host).err()?;
        let package = lack.package.unwrap_or(requirement.package);
        Some(Missing { requirement, package, why: lack.why })
    };
    needed.iter().filter_map(check).collect()
}

/// The packages of `missing`, each once.
fn packages(missing: &[Missing]) -> Vec<&'static str> {
    let mut packages = Vec::new();
    for Missing { package, .. } in missing {
        if !packages.contains(package) {
            packages.push(*package);
        }
    }
    packages
}

fn packages_from(source: Source, missing: &[Missing]) -> Vec<&'static str> {
    let is_from = |package: &&str| missing.iter().any(|m| m.package == *package && m.requirement.source == source);
    packages(missing).into_iter().filter(is_from).collect()
}

/// The means of installing packages.
#[derive(Debug, Clone, Copy)]
struct Machine {
    root: bool,
    sudo: Sudo,
    apt: bool,
    rustup: bool,
}

/// Whether sudo works for this user.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Sudo {
    /// It asks for no password.
    Free,
    /// It asks for a password, and there is a terminal to ask on.
    Asks,
    /// It is not there, or asks for a password and there is no terminal.
    No,
}

impl Machine {
    fn examine() -> Self {
        Self {
            root: output("id", ["-u"]).is_some_and(|id| id == "0"),
            sudo: if succeeds("sudo", ["-n", "true"]) {
                Sudo::Free
            } else if io::stdin().is_terminal() && succeeds("sudo", ["-V"]) {
                Sudo::Asks
            } else {
                Sudo::No
            },
            apt: succeeds("apt-get", ["--version"]),
            rustup: succeeds("rustup", ["--version"]),
        }
    }

    fn can_install(&self, missing: &[Missing]) -> bool {
        missing.iter().all(|missing| match missing.requirement.source {
            Source::Apt => self.apt && (self.root || self.sudo != Sudo::No),
            Source::Rustup => self.rustup,
        })
    }

    /// Lets sudo ask for the password if it needs one.
    fn unlock(&self, missing: &[Missing], step: &mut Step) -> Result<(), Error> {
        if self.root || self.sudo != Sudo::Asks {
            return Ok(());
        }
        step.note("sudo may ask for your password, to install these packages:");
        step.interactive(Command::new("sudo").arg("-v"))
            .map_err(|_| refusal(missing, &Self { sudo: Sudo::No, ..*self }, true))
    }
}

/// An error that says what is missing, why it is not installed, and what to type; with a reason per requirement.
fn refusal(missing: &[Missing], machine: &Machine, install: bool) -> Error {
    let names = listed(&packages(missing));
    let apt = packages_from(Source::Apt, missing);
    let components = packages_from(Source::Rustup, missing);
    let why = if !install {
        " missing, and --no-install forbids installing"
    } else if !apt.is_empty() && !machine.apt {
        " missing, and there is no apt-get to install them with"
    } else if !apt.is_empty() && !machine.root && machine.sudo == Sudo::No {
        " missing, and installing takes root's rights"
    } else {
        " missing, and there is no rustup to install them with"
    };
    let mut commands = Vec::new();
    if !apt.is_empty() {
        let start = match (machine.apt, machine.root) {
            (true, true) => "run `apt-get install -y --no-install-recommends ",
            (true, false) => "run `sudo apt-get install -y --no-install-recommends ",
            (false, _) => "install this system's counterparts of Debian's packages `",
        };
        commands.push(format!("{start}{}`", apt.join(" ")));
    }
    if !components.is_empty() {
        commands.push(format!("run `rustup component add {}`", components.join(" ")));
    }
    let verb = if packages(missing).len() == 1 { "is" } else { "are" };
    Error::Detailed { sentence: format!("{names} {verb}{why}: {}", commands.join(" and ")), details: reasons(missing) }
}

/// A line for each requirement.
fn reasons(missing: &[Missing]) -> String {
    let line = |missing: &Missing| format!("  {}: {}", missing.described(), missing.why);
    missing.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// `a`, `a and b`, `a, b and c`.
fn listed(names: &[&str]) -> String {
    match names {
        [] => String::new(),
        [name] => (*name).into(),
        [names @ .., last] => format!("{} and {last}", names.join(", ")),
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::fake;
    use crate::requirements::{CLIPPY, FOR_DEMO, FOR_DEMO_MPI, FOR_FILES, FOR_PYTHON, FOR_TEST, FOR_TEST_ALL, NETCDF};

    const ROOT: Machine = Machine { root: true, sudo: Sudo::No, apt: true, rustup: true };
    const USER: Machine = Machine { root: false, ..ROOT };

    /// All of `needed`, which a bare machine lacks.
    fn on_a_bare_machine<'a>(needed: &[&'a Requirement]) -> Vec<Missing<'a>> {
        let machine = fake::Machine::bare();
        let host = machine.host();
        let absent = |requirement: &&'a Requirement| match requirement.source {
            Source::Apt => missing(&[*requirement], &host).remove(0),
            // Their checks run this machine's cargo.
            Source::Rustup => Missing { requirement, package: requirement.package, why: "no such command".into() },
        };
        needed.iter().map(absent).collect()
    }

    #[test]
    fn packages_are_told_apart_by_source_and_named_once() {
        let all = on_a_bare_machine(FOR_TEST_ALL);
        assert_eq!(
            packages_from(Source::Apt, &all).join(" "),
            "gcc libc6-dev g++ gfortran make cmake pkg-config valgrind chromium chromium-driver mesa-vulkan-drivers \
             libnetcdf-dev libopenmpi-dev libmpich-dev mpich libclang-dev python3-venv"
        );
        assert_eq!(packages_from(Source::Rustup, &all), ["rustfmt", "clippy"]);
        let by_default = packages_from(Source::Apt, &on_a_bare_machine(FOR_TEST));
        assert_eq!(by_default, ["gcc", "libc6-dev"]);
        assert_eq!(packages(&on_a_bare_machine(FOR_FILES)), ["pkg-config", "libnetcdf-dev"]);
        assert_eq!(packages(&on_a_bare_machine(FOR_PYTHON)), ["python3-venv"]);
        assert_eq!(packages(&on_a_bare_machine(FOR_DEMO)), ["gcc", "libc6-dev"]);
        let over_mpi = packages(&on_a_bare_machine(FOR_DEMO_MPI));
        assert_eq!(over_mpi, ["gfortran", "make", "libopenmpi-dev", "libclang-dev"]);
    }

    #[test]
    fn installing_takes_the_means_of_each_source() {
        let all = on_a_bare_machine(FOR_TEST);
        assert!(ROOT.can_install(&all));
        assert!(Machine { sudo: Sudo::Free, ..USER }.can_install(&all));
        assert!(Machine { sudo: Sudo::Asks, ..USER }.can_install(&all));
        assert!(!USER.can_install(&all));
        assert!(!Machine { apt: false, ..ROOT }.can_install(&all));
        let without_rustup = Machine { rustup: false, ..ROOT };
        assert!(!without_rustup.can_install(&all));
        assert!(without_rustup.can_install(&on_a_bare_machine(FOR_DEMO)));
    }

    #[test]
    fn a_refusal_says_what_is_missing_why_and_what_to_type() {
        let sentence = |needed: &[&Requirement], machine: Machine, install| {
            refusal(&on_a_bare_machine(needed), &machine, install).brief().lines().next().unwrap().to_owned()
        };
        let error = refusal(&on_a_bare_machine(&[&NETCDF, &CLIPPY]), &USER, false);
        assert_eq!(
            error.to_string(),
            "libnetcdf-dev and clippy are missing, and --no-install forbids installing: \
             run `sudo apt-get install -y --no-install-recommends libnetcdf-dev` and run `rustup component add clippy`\n  \
             libnetcdf-dev (NetCDF library: reads model files): no program nc-config\n  \
             clippy (lints): no such command"
        );
        assert_eq!(
            sentence(&[&NETCDF], USER, true),
            "libnetcdf-dev is missing, and installing takes root's rights: \
             run `sudo apt-get install -y --no-install-recommends libnetcdf-dev`"
        );
        let other_system = sentence(&[&NETCDF], Machine { apt: false, ..ROOT }, true);
        assert!(other_system.contains("no apt-get"), "{other_system}");
        assert!(other_system.ends_with("counterparts of Debian's packages `libnetcdf-dev`"), "{other_system}");
        let no_rustup = sentence(&[&CLIPPY], Machine { rustup: false, ..ROOT }, true);
        assert!(no_rustup.contains("no rustup"), "{no_rustup}");
    }

    #[test]
    fn probing_survives_absent_programs() {
        assert!(!succeeds("/nonexistent/program", ["--version"]));
        assert_eq!(output("echo", [" 0 "]), Some("0".into()));
    }
}
