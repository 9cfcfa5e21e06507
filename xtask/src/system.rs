//! Installs what the subcommands need and the machine lacks.

use std::ffi::OsStr;
use std::fs;
use std::process::{Command, Stdio};

use crate::error::Error;
use crate::requirements::{Requirement, Source};
use crate::step::Step;

/// Sees to it that everything in `needed` is there, installing what is not if `install` allows.
pub fn provide(needed: &[&Requirement], install: bool, step: &mut Step) -> Result<(), Error> {
    let lacking = missing(needed, |requirement| (requirement.present)());
    if lacking.is_empty() {
        return Ok(());
    }
    let machine = Machine::examine();
    if !install || !machine.can_install(&lacking) {
        return Err(Error::Failed(refusal(&lacking, &machine, install)));
    }
    for requirement in &lacking {
        step.note(&format!("installing: {}", requirement.described()));
    }
    let packages = packages_from(Source::Apt, &lacking);
    if !packages.is_empty() {
        apt_install(&packages, &machine, step)?;
    }
    let components = packages_from(Source::Rustup, &lacking);
    if !components.is_empty() {
        step.streamed(&mut command(&rustup_add(&components)))?;
    }
    let lacking = missing(&lacking, |requirement| (requirement.present)());
    if lacking.is_empty() {
        return Ok(());
    }
    let list = described(&lacking);
    Err(Error::Failed(format!("installed, but still not usable:\n{list}")))
}

/// As [`provide`], for what can be done without: where it is not to be had, says so in a line and is false.
pub fn provide_for(what: &str, needed: &[&Requirement], install: bool, step: &mut Step) -> bool {
    // What went wrong shows in what is missing afterwards.
    let _ = provide(needed, install, step);
    let lacking = missing(needed, |requirement| (requirement.present)());
    if !lacking.is_empty() {
        let packages = packages_from(Source::Apt, &lacking).join(", ");
        step.note(&format!("left out: {what}, for want of {packages}"));
    }
    lacking.is_empty()
}

/// Whether root runs this.
pub fn is_root() -> bool {
    output("id", ["-u"]).is_some_and(|id| id == "0")
}

/// Those of `needed` that `present` does not find.
fn missing<'a>(needed: &[&'a Requirement], present: impl Fn(&Requirement) -> bool) -> Vec<&'a Requirement> {
    needed.iter().copied().filter(|requirement| !present(requirement)).collect()
}

impl Requirement {
    fn described(&self) -> String {
        format!("{} ({})", self.package, self.purpose)
    }
}

fn described(requirements: &[&Requirement]) -> String {
    let lines: Vec<_> = requirements.iter().map(|r| format!("  {}", r.described())).collect();
    lines.join("\n")
}

fn packages_from(source: Source, requirements: &[&Requirement]) -> Vec<&'static str> {
    requirements.iter().filter(|r| r.source == source).map(|r| r.package).collect()
}

/// What installing can make use of.
#[derive(Debug, Clone, Copy)]
struct Machine {
    root: bool,
    sudo: bool,
    apt: bool,
    rustup: bool,
}

impl Machine {
    fn examine() -> Self {
        Self {
            root: is_root(),
            sudo: succeeds("sudo", ["-V"]),
            apt: succeeds("apt-get", ["--version"]),
            rustup: succeeds("rustup", ["--version"]),
        }
    }

    fn can_install(&self, lacking: &[&Requirement]) -> bool {
        lacking.iter().all(|requirement| match requirement.source {
            Source::Apt => self.apt && (self.root || self.sudo),
            Source::Rustup => self.rustup,
        })
    }

    /// An apt-get command; without a user at hand to ask, and with the rights it takes.
    fn apt_get(&self, arguments: &[&str]) -> Vec<String> {
        let sudo: &[&str] = if self.root { &[] } else { &["sudo"] };
        // `env` because sudo hands on no variables.
        let start = ["env", "DEBIAN_FRONTEND=noninteractive", "apt-get"];
        sudo.iter().chain(&start).chain(arguments).map(|&word| word.to_owned()).collect()
    }
}

fn apt_install(packages: &[&str], machine: &Machine, step: &mut Step) -> Result<(), Error> {
    let install: Vec<_> =
        ["install", "-y", "--no-install-recommends"].iter().chain(packages).copied().collect();
    let install = machine.apt_get(&install);
    if have_package_lists() && step.streamed(&mut command(&install)).is_ok() {
        return Ok(());
    }
    step.note("updating the package lists, which are absent or out of date");
    step.streamed(&mut command(&machine.apt_get(&["update"])))?;
    step.streamed(&mut command(&install))
}

/// Whether apt-get was ever updated here; images of Debian come without the lists.
fn have_package_lists() -> bool {
    let Ok(entries) = fs::read_dir("/var/lib/apt/lists") else {
        return false;
    };
    entries.flatten().any(|entry| entry.file_name().to_string_lossy().contains("_Packages"))
}

fn rustup_add(components: &[&str]) -> Vec<String> {
    ["rustup", "component", "add"].iter().chain(components).map(|&word| word.to_owned()).collect()
}

/// Says what lacks, why it is not being installed, and what to type instead.
fn refusal(lacking: &[&Requirement], machine: &Machine, install: bool) -> String {
    let mut text = format!("missing on this machine:\n{}", described(lacking));
    let packages = packages_from(Source::Apt, lacking);
    let components = packages_from(Source::Rustup, lacking);
    if install {
        if !packages.is_empty() && !machine.apt {
            text += "\nnot installed, for want of apt-get";
        } else if !packages.is_empty() && !machine.root && !machine.sudo {
            text += "\nnot installed, for want of root's rights and of sudo";
        }
        if !components.is_empty() && !machine.rustup {
            text += "\nnot installed, for want of rustup";
        }
    } else {
        text += "\nnot installed, because of --no-install";
    }
    text += "\nto install:";
    if !packages.is_empty() {
        let packages = packages.join(" ");
        text += match (machine.apt, machine.root, machine.sudo) {
            (true, false, true) => "\n  sudo apt-get install -y --no-install-recommends ",
            (true, true, _) => "\n  apt-get install -y --no-install-recommends ",
            (true, false, false) => "\n  (as root) apt-get install -y --no-install-recommends ",
            (false, ..) => "\n  this system's counterparts of Debian's packages ",
        };
        text += &packages;
    }
    if !components.is_empty() {
        text += "\n  ";
        text += &rustup_add(&components).join(" ");
    }
    text
}

fn command(words: &[String]) -> Command {
    let mut words = words.iter();
    // Every command line made here starts with a program.
    let mut command = Command::new(words.next().map_or("", String::as_str));
    command.args(words);
    command
}

/// Whether a program is there and succeeds.
pub fn succeeds<'a>(program: impl AsRef<OsStr>, arguments: impl IntoIterator<Item = &'a str>) -> bool {
    output(program, arguments).is_some()
}

/// The trimmed standard output of a program, if it is there and succeeds.
pub fn output<'a>(
    program: impl AsRef<OsStr>,
    arguments: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    output.status.success().then(|| text.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::requirements::{CLIPPY, FOR_DEMO, FOR_DEMO_MPI, FOR_TEST, NETCDF};

    const ROOT: Machine = Machine { root: true, sudo: false, apt: true, rustup: true };

    fn names(requirements: &[&Requirement]) -> Vec<&'static str> {
        requirements.iter().map(|requirement| requirement.package).collect()
    }

    #[test]
    fn only_what_is_not_found_is_missing() {
        let bare = missing(FOR_TEST, |_| false);
        assert_eq!(names(&bare), names(FOR_TEST));
        assert!(missing(FOR_TEST, |_| true).is_empty());
        let some = missing(FOR_TEST, |requirement| requirement.package != "libnetcdf-dev");
        assert_eq!(names(&some), ["libnetcdf-dev"]);
    }

    #[test]
    fn packages_are_told_apart_by_source() {
        let packages = [
            "gcc",
            "libc6-dev",
            "g++",
            "gfortran",
            "make",
            "cmake",
            "pkg-config",
            "valgrind",
            "mesa-vulkan-drivers",
            "libnetcdf-dev",
            "libopenmpi-dev",
            "openmpi-bin",
            "libclang-dev",
        ];
        assert_eq!(packages_from(Source::Apt, FOR_TEST), packages);
        assert_eq!(packages_from(Source::Rustup, FOR_TEST), ["rustfmt", "clippy"]);
        assert!(packages_from(Source::Rustup, FOR_DEMO).is_empty());
        // No package twice: apt-get is told of each, and so is whoever reads what was left out.
        let over_mpi = packages_from(Source::Apt, FOR_DEMO_MPI);
        assert_eq!(over_mpi, ["gfortran", "make", "libopenmpi-dev", "openmpi-bin", "libclang-dev"]);
    }

    #[test]
    fn installing_takes_the_means_of_each_source() {
        assert!(ROOT.can_install(FOR_TEST));
        assert!(Machine { root: false, sudo: true, ..ROOT }.can_install(FOR_TEST));
        assert!(!Machine { root: false, ..ROOT }.can_install(FOR_TEST));
        assert!(!Machine { apt: false, ..ROOT }.can_install(FOR_TEST));
        let without_rustup = Machine { rustup: false, ..ROOT };
        assert!(!without_rustup.can_install(FOR_TEST));
        assert!(without_rustup.can_install(FOR_DEMO));
    }

    #[test]
    fn apt_get_goes_through_sudo_where_not_root() {
        let expected = "env DEBIAN_FRONTEND=noninteractive apt-get update";
        assert_eq!(ROOT.apt_get(&["update"]).join(" "), expected);
        let user = Machine { root: false, sudo: true, ..ROOT };
        assert_eq!(user.apt_get(&["update"]).join(" "), format!("sudo {expected}"));
    }

    #[test]
    fn a_refusal_says_what_lacks_why_and_what_to_type() {
        let user = Machine { root: false, sudo: true, ..ROOT };
        assert_eq!(
            refusal(&[&NETCDF, &CLIPPY], &user, false),
            "missing on this machine:\n  \
             libnetcdf-dev (NetCDF library: reads model files)\n  \
             clippy (lints)\n\
             not installed, because of --no-install\n\
             to install:\n  \
             sudo apt-get install -y --no-install-recommends libnetcdf-dev\n  \
             rustup component add clippy"
        );
        let without_sudo = refusal(&[&NETCDF], &Machine { root: false, ..ROOT }, true);
        assert!(without_sudo.contains("root's rights and of sudo"), "{without_sudo}");
        assert!(without_sudo.contains("(as root) apt-get install"), "{without_sudo}");
        let other_system = refusal(&[&NETCDF], &Machine { apt: false, ..ROOT }, true);
        assert!(other_system.contains("for want of apt-get"), "{other_system}");
        assert!(other_system.contains("counterparts of Debian's packages libnetcdf-dev"));
    }

    #[test]
    fn probing_survives_absent_programs() {
        assert!(!succeeds("/nonexistent/program", ["--version"]));
        assert_eq!(output("echo", [" 0 "]), Some("0".into()));
    }
}
