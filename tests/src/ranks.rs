//! Programs on several ranks of MPI.

use crate::native::{command, is_there, succeeded, text};
use std::path::Path;
use std::process::Command;

/// Seconds after which a run counts as one that hangs.
const HANGS: &str = "150";

/// Whether MPI is installed; says so where it is not.
pub fn has_mpi() -> bool {
    is_there("mpirun") && is_there("mpicc")
}

/// A program on so many ranks, more than there are processors if need be, stopped where it hangs.
///
/// # Panics
/// When there is no MPI.
pub fn on_ranks(ranks: usize, program: &Path, directory: &Path) -> Command {
    let mut command = command("timeout", directory);
    command.args(["--kill-after=5", HANGS, "mpirun", "-n", &ranks.to_string()]);
    let version = text(&succeeded(Command::new("mpirun").arg("--version")).stdout);
    if version.contains("Open MPI") || version.contains("OpenRTE") {
        command.args([
            "--oversubscribe",
            "--bind-to",
            "none",
            "--mca",
            "btl_vader_single_copy_mechanism",
            "none",
        ]);
        if text(&succeeded(Command::new("id").arg("-u")).stdout).trim() == "0" {
            command.arg("--allow-run-as-root");
        }
    }
    command.arg(program);
    command
}
