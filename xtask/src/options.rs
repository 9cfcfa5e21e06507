//! The command line.

use std::path::{Component, PathBuf};

use clap::{Args, Parser};

/// Builds, shows, tests and installs icoray
///
/// All subcommands but package install missing Debian packages with apt-get (as root or by sudo), and print which.
#[derive(Debug, Parser)]
#[command(bin_name = "cargo xtask", disable_help_subcommand = true)]
pub struct CommandLine {
    #[command(subcommand)]
    pub subcommand: Subcommand,
    /// Install no packages; say what is missing instead
    #[arg(long, global = true)]
    pub no_install: bool,
}

/// A subcommand with its options.
#[derive(Debug, clap::Subcommand)]
pub enum Subcommand {
    /// Run two models that draw themselves, and print where the pictures are and what they cost
    ///
    /// Builds the C library and the tracer model of examples/c, which needs a C compiler alone. Then the same with the
    /// shallow-water model of examples/fortran on two ranks of MPI; if that cannot be built or run, it is left out with
    /// the reason, and the demo still succeeds.
    Demo(DemoOptions),
    /// Draw the example scenes into examples/gallery, and write the numbers of its page
    ///
    /// Pictures whose file is missing are kept.
    #[command(
        after_help = "Environment:\n  ICORAY_TEST_DATA=DIR  Where the files of models are [default: ../shared/data]"
    )]
    Gallery,
    /// Check formatting, lints and tests
    ///
    /// Without --all, everything but GPU and MPI. Fails at the end if any check failed. The last lines say how many
    /// tests were skipped, by cause, and: N passed, N failed, N skipped.
    #[command(after_help = TEST_ENVIRONMENT)]
    Test {
        /// Also GPU and MPI, valgrind, long counts (10,000,000 rays, 60,000 damaged grids, 10,000 frames), the Python
        /// package, each feature alone, and programs in C, C++ and Fortran that link the installed library
        #[arg(long)]
        all: bool,
        /// Only the checks with this in their titles, such as "lints" or "install and link"
        #[arg(long, value_name = "PART", default_value = "", hide_default_value = true)]
        only: String,
    },
    /// Build the C library and install it
    ///
    /// Shared and static library, header, Fortran module's source, files for pkg-config and CMake. Nothing is replaced
    /// before all is built; running programs keep the files that they opened. The installed tree may be moved as a
    /// whole.
    #[command(after_help = INSTALL_ENVIRONMENT)]
    Install(InstallOptions),
    /// Write the source archive of the commit HEAD, and the recipes of Spack and conda with its checksum
    ///
    /// They are in target/package. Needs git, tar, gzip.
    Package,
    /// List the Debian packages that the checks need
    Requirements {
        /// The packages of `test --all`
        #[arg(long)]
        all: bool,
    },
}

const TEST_ENVIRONMENT: &str = "\
Environment:
  ICORAY_REQUIRE=LIST   Fail tests that would be skipped for want of these, separated by commas: all, or some of
                        long, gpu, mpi, mpich, fortran, c++, make, binutils, sanitizers, valgrind, chromium, python,
                        mdbook, counters, mount, glibc, memory, terminal, comin, catalyst, zarr, data
  ICORAY_TEST_DATA=DIR  Where the files of models are [default: ../shared/data]
  ICORAY_COMIN=DIR      Where ICON's ComIn is installed
  ICORAY_CATALYST=DIR   Where Kitware's libcatalyst is installed";

const INSTALL_ENVIRONMENT: &str = "\
Environment:
  MPICC=PROGRAM  The MPI compiler of --mpi [default: mpicc]
  DESTDIR=DIR    Put everything below DIR, for packagers";

/// Options of `demo`.
#[derive(Debug, Args)]
pub struct DemoOptions {
    /// Directory of the pictures [default: out/demo in the workspace]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Device that renders; auto takes a GPU if there is one. With auto or gpu the library is built with GPUs
    #[arg(long, value_name = "WHO", value_parser = ["auto", "cpu", "gpu"])]
    pub backend: Option<String>,
    /// Simulated days of the tracer model
    #[arg(long, value_name = "X", default_value_t = 12.0)]
    pub days: f64,
    /// Cargo's profile
    #[arg(long, value_name = "NAME", default_value = "release", value_parser = ["release", "dev"])]
    pub profile: String,
}

/// Options of `install`.
#[derive(Debug, Args)]
pub struct InstallOptions {
    /// Where to install
    #[arg(long, value_name = "DIR", default_value = "/usr/local")]
    pub prefix: PathBuf,
    /// The libraries' directory below the prefix, such as lib64
    #[arg(long, value_name = "DIR", default_value = "lib", value_parser = below_prefix)]
    pub libdir: PathBuf,
    /// With icoray_open over several ranks, for the MPI of `mpicc`
    #[arg(long)]
    pub mpi: bool,
    /// Without GPUs, for a smaller library
    #[arg(long)]
    pub no_gpu: bool,
    /// With the plugin for ICON, for the ComIn that is installed in DIR; turns on --mpi
    #[arg(long, value_name = "DIR")]
    pub comin: Option<PathBuf>,
    /// With the command icoray, its completions for bash, zsh and fish, and its manual pages
    #[arg(long)]
    pub command: bool,
    /// With the implementation of Catalyst 2 for hosts that link Kitware's libcatalyst
    #[arg(long)]
    pub catalyst: bool,
}

/// A relative path: installed files refer to each other by relative paths.
fn below_prefix(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_below = !text.is_empty() && path.components().all(|part| matches!(part, Component::Normal(_)));
    if is_below { Ok(path) } else { Err("expected a path below the prefix".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn parse(line: &str) -> Result<CommandLine, clap::Error> {
        CommandLine::try_parse_from(["xtask"].into_iter().chain(line.split_whitespace()))
    }

    #[test]
    fn lines_are_taken_or_refused() {
        CommandLine::command().debug_assert();
        for line in [
            "demo --profile dev",
            "gallery",
            "test --all --no-install",
            "install --libdir lib/x --comin icon --command",
        ] {
            assert!(parse(line).is_ok(), "{line}");
        }
        for (line, code, message) in [
            ("--help", 0, "requirements"),
            ("test --help", 0, "ICORAY_REQUIRE"),
            ("install -h", 0, "DESTDIR"),
            ("demo --all", 2, "unexpected argument '--all'"),
            ("demo --days many", 2, "invalid value 'many'"),
            ("demo --out=", 2, "a value is required"),
            ("demo --backend vulkan", 2, "[possible values: auto, cpu, gpu]"),
            ("install --libdir /usr/lib", 2, "expected a path below the prefix"),
            ("install --libdir ../lib", 2, "expected a path below the prefix"),
        ] {
            let error = parse(line).unwrap_err();
            assert!(error.exit_code() == code && error.to_string().contains(message), "{line}: {error}");
        }
    }
}
