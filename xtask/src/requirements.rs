//! What the subcommands need beyond the Rust toolchain, and how it is found.

use std::env;
use std::fs;
use std::path::PathBuf;

use crate::libclang;
use crate::system::{output, succeeds};
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

pub static NETCDF: Requirement = Requirement {
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

// Not just any: what is built is for GNU's Fortran, whose module files no other compiler reads.
static MPI_FORTRAN: Requirement = Requirement {
    package: "libopenmpi-dev",
    purpose: "MPI library for Fortran: a model over several ranks",
    source: Source::Apt,
    present: || {
        let compiler = output("mpifort", ["--version"]);
        succeeds("mpicc", ["--version"]) && compiler.is_some_and(|told| told.contains("GNU Fortran"))
    },
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

pub static CLIPPY: Requirement = Requirement {
    package: "clippy",
    purpose: "lints",
    source: Source::Rustup,
    present: || succeeds(cargo(), ["clippy", "--version"]),
};

/// What the demo needs: its library reads no files, so a C compiler is enough.
pub static FOR_DEMO: &[&Requirement] = &[&C_COMPILER, &C_HEADERS];

/// What its part over MPI needs besides.
pub static FOR_DEMO_MPI: &[&Requirement] = &[&FORTRAN_COMPILER, &MAKE, &MPI_FORTRAN, &MPI_RUN, &CLANG];

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

fn netcdf_dir() -> Option<PathBuf> {
    env::var_os("NETCDF_DIR").map(PathBuf::from)
}
