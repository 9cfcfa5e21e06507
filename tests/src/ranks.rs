//! Programs on several ranks of MPI.

use crate::native::{mpi_library, mpich_library, succeeded, text};
use crate::programs::Program;
use icoray_test_support::{Need, has_tool, runs_long, skip};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// An MPI: its compiler, how its programs are run, and the library that was built for it.
pub struct Mpi {
    compiler: &'static str,
    run: &'static str,
    /// What a test lacks where it is not there.
    need: Need,
    /// That library.
    pub library: fn() -> PathBuf,
}

/// The one that is found first.
pub static FIRST: Mpi = Mpi { compiler: "mpicc", run: "mpirun", need: Need::Mpi, library: mpi_library };
/// Debian's other one, beside Open MPI.
pub static MPICH: Mpi = Mpi { compiler: "mpicc.mpich", run: "mpirun.mpich", need: Need::Mpich, library: mpich_library };

impl Mpi {
    /// Whether it is installed and this package was built for it. If not, skips the test. MPICH is for the long run.
    pub fn is_there(&self) -> bool {
        if !cfg!(feature = "mpi") {
            skip(Need::Long);
            return false;
        }
        let is_asked_for = self.need != Need::Mpich || runs_long();
        is_asked_for && has_tool(self.need, self.run) && has_tool(self.need, self.compiler)
    }

    /// A directory for a test with this MPI. If [it is not there](Self::is_there), skips the test.
    pub fn directory(&self) -> Option<TempDir> {
        self.is_there().then(|| TempDir::new().unwrap())
    }

    /// A program of `tests/c` with what the others share, compiled against `library`.
    pub fn compile(&self, library: impl AsRef<Path>, name: &str) -> PathBuf {
        let sources = &[name, "mpi_common", "mpi_cut", "host_common", "check"];
        let options = &["-std=c99", "-Wno-long-long"];
        Program { library: library.as_ref(), compiler: self.compiler, options, sources }.path()
    }

    /// A program on so many ranks, more than there are processors if need be, stopped where it hangs.
    pub fn on_ranks(&self, ranks: usize, program: &Path, directory: &Path) -> Command {
        let mut command = icoray_test_support::on_ranks(self.run, ranks, directory);
        command.env_remove("LD_LIBRARY_PATH").arg(program);
        command
    }

    /// Whether it is Open MPI.
    pub fn is_open_mpi(&self) -> bool {
        let version = text(&succeeded(Command::new(self.run).arg("--version")).stdout);
        version.contains("Open MPI") || version.contains("OpenRTE")
    }
}
