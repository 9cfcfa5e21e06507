//! The packages that the subcommands need beyond the Rust toolchain, which `rust-toolchain.toml` describes to rustup: a
//! table, and a list for each need.

use std::process::{Command, Stdio};

use crate::error::last_lines;
use crate::{libclang, mpi};

/// A package, and how it is seen that the machine has what it provides.
#[derive(Debug)]
pub struct Package {
    /// Its name in Debian.
    pub name: &'static str,
    /// Its purpose, as text in brackets after its name.
    pub purpose: &'static str,
    seen: Seen,
}

/// How the presence of a package is seen. Software that was not installed by the package counts as well.
#[derive(Debug)]
enum Seen {
    /// A command of the shell succeeds.
    Shell(&'static str),
    /// A function finds it; otherwise it returns the reason.
    By(fn() -> Result<(), String>),
}
use Seen::{By, Shell};

impl Package {
    /// The name of the package to install: that of the MPI of which the machine has a part.
    pub fn to_install(&self) -> &'static str {
        match self.name {
            "libopenmpi-dev" if mpi::is_other() => MPICH.name,
            "openmpi-bin" if mpi::is_other() => MPICH_RUN.name,
            name => name,
        }
    }

    /// Fails with a line of the reason if the machine lacks it.
    pub fn check(&self) -> Result<(), String> {
        match self.seen {
            By(find) => find(),
            Shell(command) => {
                let mut shell = Command::new("/bin/sh");
                shell.args(["-c", command]).stdin(Stdio::null()).env("LC_ALL", "C");
                let output = shell.output().map_err(|cause| cause.to_string())?;
                let errors = String::from_utf8_lossy(&output.stderr);
                let reason = || last_lines(&errors, 1).first().map_or(command, |line| line.trim()).to_owned();
                if output.status.success() { Ok(()) } else { Err(reason()) }
            }
        }
    }
}

const fn debian(name: &'static str, purpose: &'static str, seen: Seen) -> Package {
    Package { name, purpose, seen }
}

static CC: Package = debian("gcc", "C compiler", Shell("cc --version"));
// Separate because the compiler's package only recommends the headers, and recommended packages are not installed.
static C_HEADERS: Package = debian("libc6-dev", "C library headers", Shell(COMPILE));
const COMPILE: &str = "echo 'int main(void) { return 0; }' | cc -include stdio.h -x c - -o /dev/null -lm";
static CPP: Package =
    debian("g++", "C++ compiler: unpacks Zarr stores; the header is for C++ too", Shell("c++ --version"));
static FORTRAN: Package = debian("gfortran", "Fortran compiler: builds Fortran models", Shell("gfortran --version"));
static MAKE: Package = debian("make", "builds Fortran models", Shell("make --version"));
static CMAKE: Package = debian("cmake", "builds programs with the installed library", Shell("cmake --version"));
static PKG_CONFIG: Package = debian("pkg-config", "finds HDF5, and icoray", Shell("pkg-config --version"));
static VALGRIND: Package = debian("valgrind", "finds wrong uses of memory", Shell("valgrind --version"));
static CHROMIUM: Package = debian("chromium", "browser: tests the page of `icoray view`", Shell("chromium --version"));
static CHROMEDRIVER: Package = debian("chromium-driver", "steers that browser", Shell("chromedriver --version"));
// Any driver will do, a GPU's too; this package has one that runs on the processor.
static VULKAN: Package = debian("mesa-vulkan-drivers", "a Vulkan driver: runs the GPU's tests", Shell(FIND_DRIVER));
const FIND_DRIVER: &str = "cat /etc/vulkan/icd.d/*.json || cat /usr/share/vulkan/icd.d/*.json";
static NETCDF: Package = debian("libnetcdf-dev", "NetCDF library: reads model files", Shell(FIND_NETCDF));
// As netcdf-sys finds it.
const FIND_NETCDF: &str = "[ \"$NETCDF_DIR$NetCDF_DIR\" ] || nc-config --version";
static MPI_C: Package = debian("libopenmpi-dev", "MPI: pictures of several ranks", By(|| mpi::cc().map(drop)));
static MPI: Package = debian("libopenmpi-dev", "MPI: pictures of several ranks", By(mpi::check_compilers));
static MPI_RUN: Package = debian("openmpi-bin", "runs programs on several ranks", By(mpi::check_launcher));
// Libraries of one MPI refuse programs of the other.
static MPICH: Package = debian("libmpich-dev", "another MPI", Shell("mpicc.mpich --version"));
static MPICH_RUN: Package = debian("mpich", "runs programs of that MPI", Shell("mpirun.mpich --version"));
static CLANG: Package = debian("libclang-dev", "reads MPI's header for Rust", By(libclang::check));
static PYTHON: Package = debian("python3-venv", "Python 3.10 with environments of its own", Shell(FIND_PYTHON));
const FIND_PYTHON: &str = "python3 -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 10))'";

/// For the library in C, and for the default checks: what reads no files and has no MPI. The compiler's package depends on
/// the binutils that reduce the static library.
pub static FOR_C: &[&Package] = &[&CC, &C_HEADERS];
/// For the demo's model over MPI.
pub static FOR_DEMO_MPI: &[&Package] = &[&FORTRAN, &MAKE, &MPI, &MPI_RUN, &CLANG];
/// For `install --mpi`.
pub static FOR_INSTALL_MPI: &[&Package] = &[&CC, &C_HEADERS, &MPI_C, &CLANG];
/// For reading files of models; without it the default checks leave out the packages that read files.
pub static FOR_FILES: &[&Package] = &[&CPP, &PKG_CONFIG, &NETCDF];
/// For `test --all`: it builds the whole workspace, and programs as users of the installed library do.
#[rustfmt::skip]
pub static FOR_TEST_ALL: &[&Package] = &[
    &CC, &C_HEADERS, &CPP, &FORTRAN, &MAKE, &CMAKE, &PKG_CONFIG, &VALGRIND, &CHROMIUM, &CHROMEDRIVER, &VULKAN, &NETCDF,
    &MPI, &MPI_RUN, &MPICH, &MPICH_RUN, &CLANG, &PYTHON,
];

/// The packages of Debian for the default checks, or for all; each once.
pub fn listed(all: bool) -> Vec<&'static str> {
    let packages = if all { FOR_TEST_ALL.to_vec() } else { [FOR_C, FOR_FILES].concat() };
    packages.into_iter().map(|package| package.name).collect()
}

/// Whether the machine has the packages of these names.
pub fn has(names: &[&str]) -> bool {
    FOR_TEST_ALL.iter().filter(|package| names.contains(&package.name)).all(|package| package.check().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_container_has_the_packages_of_the_table() {
        let file = include_str!("../../.devcontainer/Dockerfile");
        let lines = file.lines().skip_while(|line| !line.contains("apt-get install")).skip(1);
        let container: Vec<_> = lines.map_while(|line| line.strip_prefix("        ")?.strip_suffix(" \\")).collect();
        assert_eq!(
            container,
            listed(true),
            "`cargo xtask requirements --all` prints the list for .devcontainer/Dockerfile"
        );
        // The long run has all that the others have.
        let needs = [FOR_C, FOR_DEMO_MPI, FOR_INSTALL_MPI, FOR_FILES].concat();
        let names: Vec<_> = FOR_TEST_ALL.iter().map(|package| package.name).collect();
        assert!(needs.iter().all(|package| names.contains(&package.name)));
    }

    #[test]
    fn missing_packages_are_reported_in_the_words_of_the_tools() {
        let lacking = debian("x", "nothing", Shell("no-such-program --version"));
        assert!(lacking.check().unwrap_err().contains("no-such-program: not found"));
        assert_eq!(debian("x", "nothing", Shell("false")).check(), Err("false".into()));
        assert_eq!(CC.check().and_then(|()| C_HEADERS.check()), Ok(()));
        assert!(debian("x", "nothing", Shell("cc -include no-such.h -E -x c /dev/null")).check().is_err());
    }
}
