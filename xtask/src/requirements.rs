//! What the subcommands need beyond the Rust toolchain, and how it is found: as the tools that use it find it, mostly by compiling
//! and running a small program of `probes`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::host::{Host, Probe};
use crate::workspace::cargo;
use crate::{libclang, mpi};

/// Something that must be on the machine.
#[derive(Debug)]
pub struct Requirement {
    /// The name of the package or component that provides it.
    pub package: &'static str,
    /// What the package is for, in words that follow its name.
    pub purpose: &'static str,
    /// Where the package comes from.
    pub source: Source,
    /// Whether it works, by whatever means it came.
    pub check: fn(&Host) -> Result<(), Lack>,
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
    /// A lack for this reason.
    pub fn of(why: impl Into<String>) -> Self {
        Self { why: why.into(), package: None }
    }

    /// The same with a package that would help.
    pub fn from(self, package: &'static str) -> Self {
        Self { package: Some(package), ..self }
    }
}

impl From<String> for Lack {
    fn from(why: String) -> Self {
        Lack::of(why)
    }
}

static C: Probe = Probe { name: "probe.c", text: include_str!("probes/c.c") };
static CPP: Probe = Probe { name: "probe.cpp", text: include_str!("probes/cpp.cpp") };
static FORTRAN: Probe = Probe { name: "probe.f90", text: include_str!("probes/fortran.f90") };
static NETCDF_USER: Probe = Probe { name: "netcdf.c", text: include_str!("probes/netcdf.c") };
static VULKAN_USER: Probe = Probe { name: "vulkan.c", text: include_str!("probes/vulkan.c") };

static C_COMPILER: Requirement = Requirement {
    package: "gcc",
    purpose: "C compiler: builds the example model",
    source: Source::Apt,
    check: |host| runs(host, "cc"),
};

// A row of its own because the compiler's package only recommends the headers, and recommended
// packages are not installed.
static C_HEADERS: Requirement = Requirement {
    package: "libc6-dev",
    purpose: "C library headers: builds the example model",
    source: Source::Apt,
    check: |host| compiles(host, "cc", &C, &["-std=c99", "-lm"]),
};

pub static NETCDF: Requirement = Requirement {
    package: "libnetcdf-dev",
    purpose: "NetCDF library: reads model files",
    source: Source::Apt,
    check: netcdf,
};

static PKG_CONFIG: Requirement = Requirement {
    package: "pkg-config",
    purpose: "finds HDF5 beneath NetCDF, and icoray where it is installed",
    source: Source::Apt,
    check: |host| runs(host, "pkg-config"),
};

static CPP_COMPILER: Requirement = Requirement {
    package: "g++",
    purpose: "C++ compiler: the header is for C++ too",
    source: Source::Apt,
    check: |host| compiles(host, "c++", &CPP, &["-std=c++11"]),
};

static FORTRAN_COMPILER: Requirement = Requirement {
    package: "gfortran",
    purpose: "Fortran compiler: builds the Fortran module and its programs",
    source: Source::Apt,
    check: |host| compiles(host, "gfortran", &FORTRAN, &["-std=f2018"]),
};

static MAKE: Requirement = Requirement {
    package: "make",
    purpose: "builds programs against the installed library",
    source: Source::Apt,
    check: |host| runs(host, "make"),
};

static CMAKE: Requirement = Requirement {
    package: "cmake",
    purpose: "builds programs against the installed library",
    source: Source::Apt,
    check: |host| runs(host, "cmake"),
};

static VALGRIND: Requirement = Requirement {
    package: "valgrind",
    purpose: "finds wrong uses of memory in programs that link the library",
    source: Source::Apt,
    check: |host| runs(host, "valgrind"),
};

// Any driver will do, a GPU's own too; this package has one that runs on the processor.
static VULKAN: Requirement = Requirement {
    package: "mesa-vulkan-drivers",
    purpose: "a Vulkan driver: runs the GPU's tests on the processor",
    source: Source::Apt,
    check: |host| compiles(host, "cc", &VULKAN_USER, &["-ldl"]),
};

static MPI: Requirement = Requirement {
    package: "libopenmpi-dev",
    purpose: "MPI library: pictures of several ranks",
    source: Source::Apt,
    check: mpi::check_c,
};

static MPI_FORTRAN: Requirement = Requirement {
    package: "libopenmpi-dev",
    purpose: "MPI library for Fortran: a model over several ranks",
    source: Source::Apt,
    check: mpi::check_fortran,
};

static MPI_RUN: Requirement = Requirement {
    package: "openmpi-bin",
    purpose: "runs programs on several ranks",
    source: Source::Apt,
    check: mpi::check_run,
};

static MPICH: Requirement = Requirement {
    package: "libmpich-dev",
    purpose: "another MPI: libraries of one MPI refuse programs of the other",
    source: Source::Apt,
    check: |host| runs(host, "mpicc.mpich"),
};

static MPICH_RUN: Requirement = Requirement {
    package: "mpich",
    purpose: "runs programs of that MPI on several ranks",
    source: Source::Apt,
    check: |host| runs(host, "mpirun.mpich"),
};

static CLANG: Requirement = Requirement {
    package: "libclang-dev",
    purpose: "reads MPI's header for Rust",
    source: Source::Apt,
    check: |host| Ok(libclang::find(host).map(drop)?),
};

static RUSTFMT: Requirement = Requirement {
    package: "rustfmt",
    purpose: "checks the formatting",
    source: Source::Rustup,
    check: |host| cargo_has(host, "fmt"),
};

pub static CLIPPY: Requirement = Requirement {
    package: "clippy",
    purpose: "lints",
    source: Source::Rustup,
    check: |host| cargo_has(host, "clippy"),
};

/// What the demo needs: its library reads no files, so a C compiler is enough.
pub static FOR_DEMO: &[&Requirement] = &[&C_COMPILER, &C_HEADERS];

/// What its part over MPI needs besides.
pub static FOR_DEMO_MPI: &[&Requirement] = &[&FORTRAN_COMPILER, &MAKE, &MPI_FORTRAN, &MPI_RUN, &CLANG];

/// What installing needs: the compiler's package brings the tools that take the static library apart.
pub static FOR_INSTALL: &[&Requirement] = &[&C_COMPILER, &C_HEADERS];

/// The same with MPI.
pub static FOR_INSTALL_MPI: &[&Requirement] = &[&C_COMPILER, &C_HEADERS, &MPI, &CLANG];

/// What the default checks need: they build everything but GPU and MPI, and programs in C.
pub static FOR_TEST: &[&Requirement] = &[&C_COMPILER, &C_HEADERS, &RUSTFMT, &CLIPPY];

/// What reading files of models needs; without it the default checks leave out what reads files.
pub static FOR_FILES: &[&Requirement] = &[&PKG_CONFIG, &NETCDF];

/// What all checks need: they build the whole workspace, and programs as users of the installed library would.
pub static FOR_TEST_ALL: &[&Requirement] = &[
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
    &MPICH,
    &MPICH_RUN,
    &CLANG,
    &RUSTFMT,
    &CLIPPY,
];

/// Whether a program starts.
fn runs(host: &Host, program: &str) -> Result<(), Lack> {
    host.run(program, ["--version"])?;
    Ok(())
}

/// Whether a compiler makes a program that runs.
fn compiles(host: &Host, compiler: &str, source: &Probe, options: &[&str]) -> Result<(), Lack> {
    let program = host.build(compiler, source, options)?;
    host.run(program, [""; 0])?;
    Ok(())
}

fn cargo_has(host: &Host, component: &str) -> Result<(), Lack> {
    host.run(cargo(), [component, "--version"])?;
    Ok(())
}

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
            let told = |option: &str| host.run(&config, [option]).map(|path| PathBuf::from(path.trim()));
            (told("--includedir")?, told("--libdir")?)
        }
    };
    let options =
        [flag("-I", &include), flag("-L", &library), "-lnetcdf".into(), flag("-Wl,-rpath,", &library)];
    host.run(host.build("cc", &NETCDF_USER, options)?, [""; 0])?;
    hdf5(host)
}

/// The headers of HDF5: below HDF5_DIR, where pkg-config says, or where Debian and Fedora have them.
fn hdf5(host: &Host) -> Result<(), Lack> {
    let has_headers = |directory: &PathBuf| {
        ["H5pubconf.h", "H5pubconf-64.h"].iter().any(|name| directory.join(name).is_file())
    };
    let places = match host.variable("HDF5_DIR") {
        Some(directory) => vec![Path::new(directory).join("include")],
        None => {
            let flags = host.run("pkg-config", ["--cflags-only-I", "hdf5"]).unwrap_or_default();
            let told = flags.split_whitespace().filter_map(|flag| flag.strip_prefix("-I")).map(PathBuf::from);
            let usual = ["/usr/include/hdf5/serial", "/usr/include"].map(|place| host.file(place));
            told.chain(usual).collect()
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
        (requirement.check)(&machine.host()).err().map(|lack| lack.why)
    }

    #[test]
    fn a_bare_machine_lacks_all() {
        let machine = Machine::bare("requirements");
        for requirement in FOR_TEST_ALL.iter().filter(|requirement| requirement.source == Source::Apt) {
            assert!(why(requirement, &machine).is_some(), "{}", requirement.package);
        }
    }

    #[test]
    fn a_c_compiler_must_compile() {
        let machine = Machine::bare("compiler");
        assert_eq!(why(&C_COMPILER, &machine), Some("no program cc".into()));
        machine.program(
            "cc",
            "[ $1 = --version ] || { echo 'fatal error: stdio.h: No such file' >&2; exit 1; }",
        );
        assert_eq!(why(&C_COMPILER, &machine), None);
        assert_eq!(why(&C_HEADERS, &machine), Some("cc: fatal error: stdio.h: No such file".into()));
        machine.own_program("cc");
        assert_eq!(why(&C_HEADERS, &machine), None);
    }

    #[test]
    fn a_fortran_compiler_must_link() {
        let machine = Machine::bare("fortran");
        machine.program("gfortran", "echo 'ld: error: cannot find -lgfortran' >&2; exit 1");
        assert_eq!(
            why(&FORTRAN_COMPILER, &machine),
            Some("gfortran: ld: error: cannot find -lgfortran".into())
        );
    }

    #[test]
    fn netcdf_is_what_nc_config_and_netcdf_dir_name() {
        let mut machine = Machine::bare("netcdf");
        machine.own_program("cc");
        assert_eq!(why(&NETCDF, &machine), Some("no program nc-config".into()));
        let root = machine.root.join("opt/netcdf");
        for (name, text) in
            [("netcdf.h", "const char *nc_inq_libvers(void);\n"), ("netcdf_meta.h", "#define NC_HAS_NC4 1\n")]
        {
            std::fs::write(machine.add(&format!("/opt/netcdf/include/{name}")), text).unwrap();
        }
        let library =
            Probe { name: "netcdf.c", text: "const char *nc_inq_libvers(void) { return \"4\"; }\n" };
        let host = machine.host();
        let built = host.build("cc", &library, ["-shared", "-fPIC"]).unwrap();
        std::fs::copy(built, machine.add("/opt/netcdf/lib/libnetcdf.so")).unwrap();
        machine.program(
            "nc-config",
            &format!(
                "case $1 in --includedir) echo {0}/include;; --libdir) echo {0}/lib;; esac",
                root.display()
            ),
        );
        let lack = (NETCDF.check)(&machine.host()).unwrap_err();
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
