//! What the subcommands need beyond the Rust toolchain, and how it is found: as the tools that use it find it, mostly
//! by compiling and running a small program of `probes`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::host::{Host, Probe};
use crate::workspace::cargo;
use crate::{libclang, mpi};

/// Something that must be on the machine.
#[derive(Debug)]
pub struct Requirement {
    /// The name of the package or component that provides it.
    pub package: &'static str,
    /// The purpose of the package, as text in brackets after its name.
    pub purpose: &'static str,
    /// Where the package comes from.
    pub source: Source,
    check: Check,
}

/// How to find out whether a requirement is met, from a package or not.
#[derive(Debug)]
enum Check {
    /// The program starts.
    Runs(&'static str),
    /// The compiler makes a program of the source with these options, and the program runs.
    Compiles(&'static str, &'static Probe, &'static [&'static str]),
    /// Cargo has the subcommand.
    Cargo(&'static str),
    Function(fn(&Host) -> Result<(), Lack>),
}
use Check::{Cargo, Compiles, Function, Runs};

impl Requirement {
    /// Fails if the requirement is not met.
    pub fn check(&self, host: &Host) -> Result<(), Lack> {
        match self.check {
            Runs(program) => drop(host.run(program, ["--version"])?),
            Compiles(compiler, source, options) => {
                drop(host.run(host.build(compiler, source, options)?, [""; 0])?);
            }
            Cargo(subcommand) => drop(host.run(cargo(), [subcommand, "--version"])?),
            Function(check) => check(host)?,
        }
        Ok(())
    }
}

/// Where a package comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// Debian's archive.
    Apt,
    /// The Rust toolchain's components.
    Rustup,
}

/// Why a requirement is not met.
#[derive(Debug, PartialEq)]
pub struct Lack {
    /// The reason, in a line.
    pub why: String,
    /// The package to install, if it is not the requirement's own.
    pub package: Option<&'static str>,
}

impl Lack {
    /// A lack that the requirement's own package ends.
    pub fn of(why: impl Into<String>) -> Self {
        Self { why: why.into(), package: None }
    }

    /// The same with another package to install.
    pub fn from(self, package: &'static str) -> Self {
        Self { package: Some(package), ..self }
    }
}

impl From<String> for Lack {
    fn from(why: String) -> Self {
        Lack::of(why)
    }
}

impl From<Lack> for Error {
    fn from(lack: Lack) -> Self {
        Error::Failed(lack.why)
    }
}

static C: Probe = Probe { name: "probe.c", text: include_str!("probes/c.c") };
static CPP: Probe = Probe { name: "probe.cpp", text: include_str!("probes/cpp.cpp") };
static FORTRAN: Probe = Probe { name: "probe.f90", text: include_str!("probes/fortran.f90") };
static NETCDF_USER: Probe = Probe { name: "netcdf.c", text: include_str!("probes/netcdf.c") };
static VULKAN_USER: Probe = Probe { name: "vulkan.c", text: include_str!("probes/vulkan.c") };

static C_COMPILER: Requirement = apt("gcc", "C compiler: builds the example model", Runs("cc"));
// Separate because the compiler's package only recommends the headers, and recommended packages are not installed.
static C_HEADERS: Requirement =
    apt("libc6-dev", "C library headers: builds the example model", Compiles("cc", &C, &["-std=c99", "-lm"]));
pub static NETCDF: Requirement = apt("libnetcdf-dev", "NetCDF library: reads model files", Function(netcdf));
static PKG_CONFIG: Requirement =
    apt("pkg-config", "finds HDF5 beneath NetCDF, and icoray where it is installed", Runs("pkg-config"));
static CPP_COMPILER: Requirement =
    apt("g++", "C++ compiler: the header is for C++ too", Compiles("c++", &CPP, &["-std=c++11"]));
static FORTRAN_COMPILER: Requirement = apt(
    "gfortran",
    "Fortran compiler: builds the Fortran module and its programs",
    Compiles("gfortran", &FORTRAN, &["-std=f2018"]),
);
static MAKE: Requirement = apt("make", "builds programs against the installed library", Runs("make"));
static CMAKE: Requirement = apt("cmake", "builds programs against the installed library", Runs("cmake"));
static VALGRIND: Requirement =
    apt("valgrind", "finds wrong uses of memory in programs that link the library", Runs("valgrind"));
static CHROMIUM: Requirement = apt("chromium", "browser: tests the page of `icoray view`", Runs("chromium"));
static CHROMEDRIVER: Requirement = apt("chromium-driver", "steers that browser", Runs("chromedriver"));
// Met by any driver, a GPU's too; this package has one that runs on the processor.
static VULKAN: Requirement = apt(
    "mesa-vulkan-drivers",
    "a Vulkan driver: runs the GPU's tests on the processor",
    Compiles("cc", &VULKAN_USER, &["-ldl"]),
);
static MPI: Requirement = apt("libopenmpi-dev", "MPI library: pictures of several ranks", Function(mpi::check_c));
static MPI_FORTRAN: Requirement = apt(
    "libopenmpi-dev",
    "MPI library for Fortran: a model over several ranks",
    Function(|host| mpi::fortran(host).map(drop)),
);
static MPI_RUN: Requirement =
    apt("openmpi-bin", "runs programs on several ranks", Function(|host| mpi::launcher(host).map(drop)));
static MPICH: Requirement =
    apt("libmpich-dev", "another MPI: libraries of one MPI refuse programs of the other", Runs("mpicc.mpich"));
static MPICH_RUN: Requirement = apt("mpich", "runs programs of that MPI on several ranks", Runs("mpirun.mpich"));
static CLANG: Requirement =
    apt("libclang-dev", "reads MPI's header for Rust", Function(|host| Ok(libclang::find(host).map(drop)?)));
static PYTHON: Requirement = apt(
    "python3-venv",
    "Python 3.10 with environments of its own: tests the Python package",
    Function(|host| {
        let program = "import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 10))";
        Ok(host.run("python3", ["-c", program]).map(drop)?)
    }),
);
static RUSTFMT: Requirement = rustup("rustfmt", "checks the formatting", Cargo("fmt"));
pub static CLIPPY: Requirement = rustup("clippy", "lints", Cargo("clippy"));

const fn apt(package: &'static str, purpose: &'static str, check: Check) -> Requirement {
    Requirement { package, purpose, source: Source::Apt, check }
}

const fn rustup(package: &'static str, purpose: &'static str, check: Check) -> Requirement {
    Requirement { package, purpose, source: Source::Rustup, check }
}

/// For the demo: its library reads no files, so a C compiler is enough.
pub static FOR_DEMO: &[&Requirement] = &[&C_COMPILER, &C_HEADERS];

/// For the demo's model over MPI.
pub static FOR_DEMO_MPI: &[&Requirement] = &[&FORTRAN_COMPILER, &MAKE, &MPI_FORTRAN, &MPI_RUN, &CLANG];

/// For `install`: the compiler's package depends on the binutils that reduce the static library.
pub static FOR_INSTALL: &[&Requirement] = &[&C_COMPILER, &C_HEADERS];

/// For `install --mpi`.
pub static FOR_INSTALL_MPI: &[&Requirement] = &[&C_COMPILER, &C_HEADERS, &MPI, &CLANG];

/// For the default checks: they build everything but GPU and MPI, and programs in C.
pub static FOR_TEST: &[&Requirement] = &[&C_COMPILER, &C_HEADERS, &RUSTFMT, &CLIPPY];

/// For reading files of models; without it the default checks leave out the packages that read files.
pub static FOR_FILES: &[&Requirement] = &[&PKG_CONFIG, &NETCDF];

/// For the tests of the Python package; without it the default checks leave them out.
pub static FOR_PYTHON: &[&Requirement] = &[&PYTHON];

/// For `test --all`: it builds the whole workspace, and programs as users of the installed library do.
#[rustfmt::skip]
pub static FOR_TEST_ALL: &[&Requirement] = &[
    &C_COMPILER, &C_HEADERS, &CPP_COMPILER, &FORTRAN_COMPILER, &MAKE, &CMAKE, &PKG_CONFIG, &VALGRIND, &CHROMIUM,
    &CHROMEDRIVER, &VULKAN, &NETCDF, &MPI, &MPI_RUN, &MPICH, &MPICH_RUN, &CLANG, &PYTHON, &RUSTFMT, &CLIPPY,
];

/// NetCDF as netcdf-sys finds it, by nc-config or below NETCDF_DIR, and HDF5 as hdf5-metno-sys does.
fn netcdf(host: &Host) -> Result<(), Lack> {
    let directory = host.variable("NETCDF_DIR").or_else(|| host.variable("NetCDF_DIR")).map(PathBuf::from);
    let own_config = directory.as_ref().and_then(|directory| host.program(directory.join("bin/nc-config")));
    let (include, library) = match &directory {
        Some(directory) if own_config.is_none() && directory.join("include").is_dir() => {
            (directory.join("include"), directory.join("lib"))
        }
        _ => {
            let config = own_config.unwrap_or_else(|| "nc-config".into());
            let path = |option: &str| host.run(&config, [option]).map(|path| PathBuf::from(path.trim()));
            (path("--includedir")?, path("--libdir")?)
        }
    };
    let options = [flag("-I", &include), flag("-L", &library), "-lnetcdf".into(), flag("-Wl,-rpath,", &library)];
    host.run(host.build("cc", &NETCDF_USER, options)?, [""; 0])?;
    hdf5(host)
}

/// The headers of HDF5: below HDF5_DIR, where pkg-config says, or where Debian and Fedora have them.
fn hdf5(host: &Host) -> Result<(), Lack> {
    let has_headers =
        |directory: &PathBuf| ["H5pubconf.h", "H5pubconf-64.h"].iter().any(|name| directory.join(name).is_file());
    let places = match host.variable("HDF5_DIR") {
        Some(directory) => vec![Path::new(directory).join("include")],
        None => {
            let flags = host.run("pkg-config", ["--cflags-only-I", "hdf5"]).unwrap_or_default();
            let named = flags.split_whitespace().filter_map(|flag| flag.strip_prefix("-I")).map(PathBuf::from);
            let usual = ["/usr/include/hdf5/serial", "/usr/include"].map(|place| host.file(place));
            named.chain(usual).collect()
        }
    };
    if places.iter().any(has_headers) {
        return Ok(());
    }
    Err(Lack::of("no headers of HDF5 (H5pubconf.h) were found").from("libhdf5-dev"))
}

fn flag(name: &str, path: &Path) -> OsString {
    let mut flag = OsString::from(name);
    flag.push(path);
    flag
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::fake::Machine;

    fn why(requirement: &Requirement, machine: &Machine) -> Option<String> {
        requirement.check(&machine.host()).err().map(|lack| lack.why)
    }

    #[test]
    fn compilers_must_compile_and_link() {
        let machine = Machine::bare();
        assert_eq!(why(&C_COMPILER, &machine), Some("no program cc".into()));
        machine.program("cc", "[ $1 = --version ] || { echo 'fatal error: stdio.h: No such file' >&2; exit 1; }");
        assert_eq!(why(&C_COMPILER, &machine), None);
        assert_eq!(why(&C_HEADERS, &machine), Some("cc: fatal error: stdio.h: No such file".into()));
        machine.own_program("cc");
        assert_eq!(why(&C_HEADERS, &machine), None);
        machine.program("gfortran", "echo 'ld: error: cannot find -lgfortran' >&2; exit 1");
        let no_library = "gfortran: ld: error: cannot find -lgfortran";
        assert_eq!(why(&FORTRAN_COMPILER, &machine), Some(no_library.into()));
    }

    #[test]
    fn netcdf_is_what_nc_config_and_netcdf_dir_name() {
        let mut machine = Machine::bare();
        machine.own_program("cc");
        assert_eq!(why(&NETCDF, &machine), Some("no program nc-config".into()));
        let root = machine.root.join("opt/netcdf");
        for (name, text) in
            [("netcdf.h", "const char *nc_inq_libvers(void);\n"), ("netcdf_meta.h", "#define NC_HAS_NC4 1\n")]
        {
            std::fs::write(machine.add(&format!("/opt/netcdf/include/{name}")), text).unwrap();
        }
        let library = Probe { name: "netcdf.c", text: "const char *nc_inq_libvers(void) { return \"4\"; }\n" };
        let host = machine.host();
        let built = host.build("cc", &library, ["-shared", "-fPIC"]).unwrap();
        std::fs::copy(built, machine.add("/opt/netcdf/lib/libnetcdf.so")).unwrap();
        machine.program(
            "nc-config",
            &format!("case $1 in --includedir) echo {0}/include;; --libdir) echo {0}/lib;; esac", root.display()),
        );
        let lack = NETCDF.check(&machine.host()).unwrap_err();
        assert_eq!(lack.package, Some("libhdf5-dev"), "{lack:?}");
        machine.add("/usr/include/hdf5/serial/H5pubconf.h");
        assert_eq!(why(&NETCDF, &machine), None);
        std::fs::remove_file(machine.root.join("usr/bin/nc-config")).unwrap();
        machine.variables.insert("NETCDF_DIR".into(), root.into());
        assert_eq!(why(&NETCDF, &machine), None);
        machine.variables.insert("NETCDF_DIR".into(), "/nonexistent".into());
        assert!(why(&NETCDF, &machine).is_some());
    }
}
