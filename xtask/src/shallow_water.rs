//! The shallow-water model of `examples/fortran` over ranks of MPI: building it and running it.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use crate::error::Error;
use crate::system;
use crate::workspace::Workspace;

/// The package of the C library with MPI: the sources of icoray-capi under another name, so that it has what both depend on
/// in common with the tracer's library and does not take its place.
pub const LIBRARY_PACKAGE: &str = "icoray-capi-mpi";
const LIBRARY: &str = "icoray_mpi_test";
const FOLDER: &str = "examples/fortran/shallow_water";

/// What its pictures show, below the workspace's root.
pub const SCENE: &str = "examples/scenes/shallow_water.toml";

/// How the names of its pictures begin.
pub const PREFIX: &str = "vorticity_";

/// Half a minute or so on two cores: few layers, and 270 steps to the day, each of which has its picture.
pub const SIZE: [&str; 10] =
    ["--level", "5", "--layers", "4", "--days", "5", "--dt", "320", "--every", "270"];

/// A shallow-water model that was or is to be built.
pub struct ShallowWater<'a> {
    workspace: &'a Workspace,
    products: PathBuf,
}

impl<'a> ShallowWater<'a> {
    /// The model linked with the library of a build profile.
    pub fn new(workspace: &'a Workspace, profile: &str) -> Self {
        Self { workspace, products: workspace.products(profile) }
    }

    fn folder(&self) -> PathBuf {
        self.products.join("shallow_water")
    }

    /// The command that compiles it, against the source tree.
    pub fn compile(&self) -> Command {
        let setting = |name: &str, value: String| format!("{name}={value}");
        let products = self.products.display();
        let mut make = self.workspace.command("make");
        make.args(["-j2", "-C", FOLDER, "MPI=1"]).env_remove("MAKEFLAGS");
        make.arg(setting("BUILD", self.folder().display().to_string()));
        let module = self.workspace.root().join("include/icoray.f90");
        make.arg(setting("ICORAY_SOURCE", module.display().to_string()));
        make.arg(setting("ICORAY_LIB", format!("-L{products} -l{LIBRARY} -Wl,-rpath,{products}")));
        make
    }

    /// The command that runs it on so many ranks, each with its part of the mesh.
    pub fn run(&self, ranks: usize, scene: &Path, out: &Path) -> Result<Command, Error> {
        let mut run = self.workspace.linked("mpirun", &self.products)?;
        run.args(["-n", &ranks.to_string()]).args(mpirun_options());
        run.arg(self.folder().join("shallow_water")).args(SIZE);
        let processors = thread::available_parallelism().map_or(1, usize::from);
        run.args(["--threads", &(processors / ranks).max(1).to_string()]);
        run.arg("--scene").arg(scene).arg("--out").arg(out);
        Ok(run)
    }
}

/// What Open MPI must be told for any number of ranks to run anywhere; other MPIs do so anyway.
fn mpirun_options() -> Vec<&'static str> {
    let version = system::output("mpirun", ["--version"]).unwrap_or_default();
    if !version.contains("Open MPI") && !version.contains("OpenRTE") {
        return Vec::new();
    }
    let mut options = vec!["--oversubscribe", "--bind-to", "none"];
    // A rank that waits lets others work, on a machine that may have less processors than ranks.
    options.extend(["--mca", "mpi_yield_when_idle", "1"]);
    // In containers ranks may not read each other's memory, and each would say so.
    options.extend(["--mca", "btl_vader_single_copy_mechanism", "none"]);
    if system::is_root() {
        options.push("--allow-run-as-root");
    }
    options
}
