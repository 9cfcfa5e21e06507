//! Builds the implementation of Catalyst 2.

use std::path::PathBuf;

use crate::elf::{self, Shared};
use crate::error::Error;
use crate::host::Host;
use crate::libclang;
use crate::step::Step;
use crate::workspace::Workspace;

/// The file name that libcatalyst looks for.
pub const LIBRARY: &str = "libcatalyst-icoray.so";
/// Its directory below that of libraries: the one where libcatalyst looks if it is installed beside.
pub const DIRECTORY: &str = "catalyst";

/// Builds it as the library for C is built, with MPI or without, and with GPUs or without.
pub fn build(workspace: &Workspace, profile: &str, mpi: bool, gpu: bool, step: &mut Step) -> Result<PathBuf, Error> {
    let options = ["rustc", "--package", "icoray-catalyst", "--lib", "--crate-type", "cdylib", "--profile", profile];
    let mut cargo = workspace.cargo(options).args(["--no-default-features", "--features=live"]);
    cargo = cargo.args(gpu.then_some("--features=gpu")).args(mpi.then_some("--features=mpi"));
    if mpi {
        cargo = cargo.envs(libclang::variable(&Host::here()?)?);
    }
    step.quiet(cargo)?;
    let library = workspace.products(profile).join("libcatalyst_icoray.so");
    let expected = ["catalyst_api_impl".to_owned()];
    elf::same_names("the implementation of Catalyst exports", &elf::defined(&library, &["-D"])?, &expected)?;
    let complaints = Shared::read(&library)?.complaints(LIBRARY, mpi);
    if complaints.is_empty() {
        Ok(library)
    } else {
        Err(Error::Failed(format!("{LIBRARY}: {}", complaints.join("; "))))
    }
}
