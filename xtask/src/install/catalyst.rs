//! Builds the implementation of Catalyst 2.

use std::path::PathBuf;

use xshell::cmd;

use crate::error::Error;
use crate::libclang;
use crate::step::Step;
use crate::workspace::{Workspace, variable};

/// The file name that libcatalyst looks for.
pub const LIBRARY: &str = "libcatalyst-icoray.so";
/// Its directory below that of libraries: the one where libcatalyst looks if it is installed beside.
pub const DIRECTORY: &str = "catalyst";

const EXPORTS: &str = "crates/icoray-catalyst/exports.map";

/// Builds it as the library for C is built, with MPI or without, and with GPUs or without.
///
/// It is linked here and not by cargo, which would export the functions of the C interface too, that it has inside.
pub fn build(workspace: &Workspace, profile: &str, mpi: bool, gpu: bool, step: &mut Step) -> Result<PathBuf, Error> {
    let options = ["rustc", "--package", "icoray-catalyst", "--lib", "--crate-type", "staticlib", "--profile", profile];
    let cargo = workspace.cargo(options).args(["--no-default-features", "--features=live"]);
    let cargo = cargo.args(gpu.then_some("--features=gpu")).args(mpi.then_some("--features=mpi"));
    step.quiet(cargo.envs(libclang::variable()))?;
    let archive = workspace.products(profile).join("libcatalyst_icoray.a");
    let library = archive.with_file_name(LIBRARY);
    let compiler = if mpi { variable("MPICC").unwrap_or_else(|| "mpicc".into()) } else { "cc".into() };
    let sh = &workspace.shell;
    step.quiet(cmd!(
        sh,
        "{compiler} -shared -s -o {library} -Wl,-soname,{LIBRARY} -Wl,--version-script={EXPORTS}
         -Wl,--gc-sections,-z,relro,-z,now,-u,catalyst_api_impl {archive} -lgcc_s -lpthread -lm -ldl -lc"
    ))?;
    let check = super::library(workspace, "shared", &library).args([LIBRARY, super::linkage(mpi), "catalyst_api_impl"]);
    step.quiet(check).map(|()| library)
}
