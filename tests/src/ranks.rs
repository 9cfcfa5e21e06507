//! Programs on several ranks of MPI.

use crate::native::{command, compile_with, is_there, mpi_library, mpich_library, succeeded, text};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Seconds after which a run counts as one that hangs.
const HANGS: &str = "150";

/// An MPI: its compiler, how its programs are run, and the library that was built for it.
pub struct Mpi {
    compiler: &'static str,
    run: &'static str,
    /// Builds that library.
    pub library: fn() -> &'static Path,
}

/// The one that is found first.
pub static FIRST: Mpi = Mpi { compiler: "mpicc", run: "mpirun", library: mpi_library };
/// Debian's other one, beside Open MPI.
pub static MPICH: Mpi = Mpi { compiler: "mpicc.mpich", run: "mpirun.mpich", library: mpich_library };

impl Mpi {
    /// Whether it is installed; says so where it is not.
    pub fn is_there(&self) -> bool {
        is_there(self.run) && is_there(self.compiler)
    }

    /// A program of `tests/c` with what the others share, compiled against `library`.
    ///
    /// # Panics
    /// When it does not compile.
    pub fn compile(&self, library: &Path, name: &str, directory: &Path) -> PathBuf {
        let sources = [name, "mpi_common", "mpi_cut", "host_common", "check"];
        compile_with(library, self.compiler, &["-std=c99", "-Wno-long-long"], &sources, directory)
    }

    /// A program on so many ranks, more than there are processors if need be, stopped where it hangs.
    ///
    /// # Panics
    /// When MPI is not there.
    pub fn on_ranks(&self, ranks: usize, program: &Path, directory: &Path) -> Command {
        let mut command = command("timeout", directory);
        command.args(["--kill-after=5", HANGS, self.run, "-n", &ranks.to_string()]);
        if self.is_open_mpi() {
            let options = "--oversubscribe --bind-to none --mca btl_vader_single_copy_mechanism none";
            command.args(options.split(' '));
            if text(&succeeded(Command::new("id").arg("-u")).stdout).trim() == "0" {
                command.arg("--allow-run-as-root");
            }
        }
        command.arg(program);
        command
    }

    /// Whether it is Open MPI.
    ///
    /// # Panics
    /// When it is not there.
    pub fn is_open_mpi(&self) -> bool {
        let version = text(&succeeded(Command::new(self.run).arg("--version")).stdout);
        version.contains("Open MPI") || version.contains("OpenRTE")
    }
}
