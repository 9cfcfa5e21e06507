//! What the subcommands need beyond the Rust toolchain: finding it, and installing what lacks.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use crate::error::Error;
use crate::libclang;
use crate::step::Step;
use crate::workspace::cargo;

/// Something that must be on the machine.
pub struct Requirement {
    /// The name of the package or component that provides it.
    pub package: &'static str,
    /// What the package is for, in words that follow its name.
    pub purpose: &'static str,
    /// Where the package comes from.
    pub source: Source,
    /// Whether it is there, by whatever means it came.
    pub present: fn() -> bool,
}

/// Where a package comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// Debian's archive.
    Apt,
    /// The Rust toolchain's components.
    Rustup,
}

static C_COMPILER: Requirement = Requirement {
    package: "gcc",
    purpose: "C compiler: builds the example model",
    source: Source::Apt,
    present: || succeeds("cc", ["--version"]),
};

// A row of its own because the compiler's package only recommends the headers, and recommended
// packages are not installed.
static C_HEADERS: Requirement = Requirement {
    package: "libc6-dev",
    purpose: "C library headers: builds the example model",
    source: Source::Apt,
    present: || {
        let include = ["-fsyntax-only", "-include", "stdio.h", "-x", "c", "/dev/null"];
        succeeds("cc", include)
    },
};

static NETCDF: Requirement = Requirement {
    package: "libnetcdf-dev",
    purpose: "NetCDF library: reads model files",
    source: Source::Apt,
    present: || {
        let config = match netcdf_dir() {
            Some(dir) => dir.join("bin/nc-config"),
            None => "nc-config".into(),
        };
        let includes = output(&config, ["--includedir"])
            .map(PathBuf::from)
            .or_else(|| Some(netcdf_dir()?.join("include")));
        includes.is_some_and(|includes| includes.join("netcdf_meta.h").is_file())
    },
};

static PKG_CONFIG: Requirement = Requirement {
    package: "pkg-config",
    purpose: "finds HDF5 beneath NetCDF, and icoray where it is installed",
    source: Source::Apt,
    present: || succeeds("pkg-config", ["--version"]),
};

static CPP_COMPILER: Requirement = Requirement {
    package: "g++",
    purpose: "C++ compiler: the header is for C++ too",
    source: Source::Apt,
    present: || succeeds("c++", ["--version"]),
};

static FORTRAN_COMPILER: Requirement = Requirement {
    package: "gfortran",
    purpose: "Fortran compiler: builds the Fortran module and its programs",
    source: Source::Apt,
    present: || succeeds("gfortran", ["--version"]),
};

static MAKE: Requirement = Requirement {
    package: "make",
    purpose: "builds programs against the installed library",
    source: Source::Apt,
    present: || succeeds("make", ["--version"]),
};

static CMAKE: Requirement = Requirement {
    package: "cmake",
    purpose: "builds programs against the installed library",
    source: Source::Apt,
    present: || succeeds("cmake", ["--version"]),
};

static VALGRIND: Requirement = Requirement {
    package: "valgrind",
    purpose: "finds wrong uses of memory in programs that link the library",
    source: Source::Apt,
    present: || succeeds("valgrind", ["--version"]),
};

// Any driver will do, a GPU's own too; this package has one that runs on the processor.
static VULKAN: Requirement = Requirement {
    package: "mesa-vulkan-drivers",
    purpose: "a Vulkan driver: runs the GPU's tests on the processor",
    source: Source::Apt,
    present: || {
        let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
        folders.iter().any(|folder| fs::read_dir(folder).is_ok_and(|mut files| files.next().is_some()))
    },
};

static MPI: Requirement = Requirement {
    package: "libopenmpi-dev",
    purpose: "MPI library: pictures of several ranks",
    source: Source::Apt,
    present: || succeeds(env::var_os("MPICC").unwrap_or("mpicc".into()), ["--version"]),
};

static MPI_RUN: Requirement = Requirement {
    package: "openmpi-bin",
    purpose: "runs programs on several ranks",
    source: Source::Apt,
    present: || succeeds("mpirun", ["--version"]),
};

static CLANG: Requirement = Requirement {
    package: "libclang-dev",
    purpose: "reads MPI's header for Rust",
    source: Source::Apt,
    present: libclang::is_there,
};

static RUSTFMT: Requirement = Requirement {
    package: "rustfmt",
    purpose: "checks the formatting",
    source: Source::Rustup,
    present: || succeeds(cargo(), ["fmt", "--version"]),
};

static CLIPPY: Requirement = Requirement {
    package: "clippy",
    purpose: "lints",
    source: Source::Rustup,
    present: || succeeds(cargo(), ["clippy", "--version"]),
};

/// What the demo needs: its library reads no files, so a C compiler is enough.
pub static FOR_DEMO: &[&Requirement] = &[&C_COMPILER, &C_HEADERS];

/// What installing needs: the compiler's package brings the tools that take the static library apart.
pub static FOR_INSTALL: &[&Requirement] = &[&C_COMPILER, &C_HEADERS];

/// The same with MPI.
pub static FOR_INSTALL_MPI: &[&Requirement] = &[&C_COMPILER, &C_HEADERS, &MPI, &CLANG];

/// What the checks need: they build the whole workspace, and programs as users of the installed library would.
pub static FOR_TEST: &[&Requirement] = &[
    &C_COMPILER,
    &C_HEADERS,
    &CPP_COMPILER,
    &FORTRAN_COMPILER,
    &MAKE,
    &CMAKE,
    &PKG_CONFIG,
    &VALGRIND,
    &VULKAN,
    &NETCDF,
    &MPI,
    &MPI_RUN,
    &CLANG,
    &RUSTFMT,
    &CLIPPY,
];

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
            root: output("id", ["-u"]).is_some_and(|id| id == "0"),
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

fn netcdf_dir() -> Option<PathBuf> {
    env::var_os("NETCDF_DIR").map(PathBuf::from)
}

fn command(words: &[String]) -> Command {
    let mut words = words.iter();
    // Every command line made here starts with a program.
    let mut command = Command::new(words.next().map_or("", String::as_str));
    command.args(words);
    command
}

fn succeeds<'a>(program: impl AsRef<OsStr>, arguments: impl IntoIterator<Item = &'a str>) -> bool {
    output(program, arguments).is_some()
}

/// The trimmed standard output of a program, if it is there and succeeds.
fn output<'a>(program: impl AsRef<OsStr>, arguments: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout);
    output.status.success().then(|| text.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

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
