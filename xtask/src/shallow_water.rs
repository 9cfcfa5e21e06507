//! The shallow-water model of `examples/fortran` over ranks of MPI: building it and running it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use crate::error::Error;
use crate::host::Host;
use crate::libclang;
use crate::mpi::Mpi;
use crate::step::Step;
use crate::workspace::Workspace;

/// The package of the C library with MPI: the sources of icoray-capi under another name, so that neither library overwrites the
/// other and cargo compiles the crates below them once.
pub const LIBRARY_PACKAGE: &str = "icoray-capi-mpi";
const LIBRARY: &str = "icoray_mpi_test";
const FOLDER: &str = "examples/fortran/shallow_water";

/// Its scene, below the workspace's root.
pub const SCENE: &str = "examples/scenes/shallow_water.toml";

/// How the names of its pictures begin.
pub const PREFIX: &str = "vorticity_";

/// Half a minute or so on two cores: few layers, and 270 steps to the day, each of which has its picture.
pub const SIZE: [&str; 10] =
    ["--level", "5", "--layers", "4", "--days", "5", "--dt", "320", "--every", "270"];

/// A shallow-water model that was or is to be built.
pub struct ShallowWater<'a> {
    workspace: &'a Workspace,
    mpi: &'a Mpi,
    /// Cargo's name of the profile.
    profile: &'a str,
    products: PathBuf,
}

impl<'a> ShallowWater<'a> {
    /// The model linked with the library of a build profile.
    pub fn new(workspace: &'a Workspace, profile: &'a str, mpi: &'a Mpi) -> Self {
        let products = workspace.products(if profile == "dev" { "debug" } else { profile });
        Self { workspace, mpi, profile, products }
    }

    fn folder(&self) -> PathBuf {
        self.products.join("shallow_water")
    }

    /// The command that builds its library, with GPUs or without; what it takes to find MPI is left to [`ShallowWater::tell`].
    pub fn library(&self, gpu: bool) -> Command {
        let mut cargo = self.workspace.cargo(["build", "--profile", self.profile]);
        cargo.args(["--package", LIBRARY_PACKAGE, "--no-default-features", "--features"]);
        cargo.arg(if gpu { "mpi,gpu" } else { "mpi" });
        cargo
    }

    /// Lets a command of cargo's build for this MPI.
    pub fn tell(&self, cargo: &mut Command, host: &Host) -> Result<(), Error> {
        // rsmpi prefers these to MPICC.
        cargo.env_remove("MPI_PKG_CONFIG").env_remove("CRAY_MPICH_DIR").env("MPICC", &self.mpi.cc);
        libclang::tell(cargo, host)
    }

    /// Removes what was built for another MPI, which neither cargo nor make notice.
    pub fn forget_other_mpi(&self, step: &mut Step) -> Result<(), Error> {
        let record = self.products.join("shallow_water.mpi");
        let current = format!("{}\n{}\n", self.mpi.cc.display(), self.mpi.library);
        if fs::read_to_string(&record).is_ok_and(|built| built == current) {
            return Ok(());
        }
        step.quiet(&mut self.workspace.cargo(["clean", "--package", "mpi-sys", "--profile", self.profile]))?;
        if self.folder().exists() {
            fs::remove_dir_all(self.folder()).map_err(Error::while_doing(self.folder().display()))?;
        }
        fs::write(&record, current).map_err(Error::while_doing(record.display()))
    }

    /// The command that compiles it, against the source tree.
    pub fn compile(&self) -> Command {
        let setting = |name: &str, value: String| format!("{name}={value}");
        let products = self.products.display();
        let mut make = self.workspace.command("make");
        make.args(["-j2", "-C", FOLDER, "MPI=1"]).env_remove("MAKEFLAGS");
        make.arg(setting("FC", self.mpi.fortran.display().to_string()));
        make.arg(setting("BUILD", self.folder().display().to_string()));
        let module = self.workspace.root().join("include/icoray.f90");
        make.arg(setting("ICORAY_SOURCE", module.display().to_string()));
        make.arg(setting("ICORAY_LIB", format!("-L{products} -l{LIBRARY} -Wl,-rpath,{products}")));
        make
    }

    /// The command that runs it on so many ranks, each with its part of the mesh.
    pub fn run(&self, ranks: usize, scene: &Path, out: &Path) -> Result<Command, Error> {
        let mut run = self.workspace.linked(&self.mpi.run, &self.products)?;
        run.args(["-n", &ranks.to_string()]).args(&self.mpi.options);
        run.arg(self.folder().join("shallow_water")).args(SIZE);
        let processors = thread::available_parallelism().map_or(1, usize::from);
        run.args(["--threads", &(processors / ranks).max(1).to_string()]);
        run.arg("--scene").arg(scene).arg("--out").arg(out);
        Ok(run)
    }
}
