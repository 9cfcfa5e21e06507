//! Builds and runs the models that draw themselves: the tracer of `examples/c`, and the shallow-water model of
//! `examples/fortran` over ranks of MPI.

use std::path::PathBuf;
use std::{fs, thread};

use icoray_test_support::mpi_variables;
use xshell::{Cmd, cmd};

use crate::error::Error;
use crate::libclang;
use crate::mpi::Mpi;
use crate::step::Step;
use crate::workspace::Workspace;

/// The tracer's files, in `examples/c`.
const TRACER: [&str; 6] = ["tracer.c", "mesh.c", "options.c", "ranks.c", "transport.c", "winds.c"];
const SHALLOW_WATER: &str = "examples/fortran/shallow_water";
/// The package of the C library with MPI: the sources of icoray-capi under another name, so that neither library
/// overwrites the other and cargo compiles the crates below them once.
pub const MPI_PACKAGE: &str = "icoray-capi-mpi";
const MPI_LIBRARY: &str = "icoray_mpi_test";

/// The command that compiles the tracer model, linked with the shared library of a build profile. Warnings are errors:
/// the header must be clean in the strictest builds.
pub fn compile_tracer<'a>(workspace: &'a Workspace, profile: &str) -> Cmd<'a> {
    let products = workspace.products(profile);
    let (program, sources) = (products.join("tracer"), TRACER.map(|source| format!("examples/c/{source}")));
    let sh = &workspace.shell;
    cmd!(
        sh,
        "cc -std=c99 -O2 -Wall -Wextra -Werror -pedantic -Iinclude {sources...} -o {program}
         -L{products} -licoray -lm -Wl,-rpath,{products}"
    )
}

/// The shallow-water model, linked with the library of a build profile.
pub struct ShallowWater<'a> {
    workspace: &'a Workspace,
    mpi: &'a Mpi,
    /// Cargo's name of the profile.
    profile: &'a str,
    products: PathBuf,
}

impl<'a> ShallowWater<'a> {
    pub fn new(workspace: &'a Workspace, profile: &'a str, mpi: &'a Mpi) -> Self {
        Self { workspace, mpi, profile, products: workspace.products(profile) }
    }

    fn folder(&self) -> PathBuf {
        self.products.join("shallow_water")
    }

    /// The command that builds its library, with GPUs or without; [`ShallowWater::with_mpi`] adds the MPI.
    pub fn library(&self, gpu: bool) -> Cmd<'a> {
        let features = if gpu { "mpi,live,gpu" } else { "mpi,live" };
        let cargo = self.workspace.cargo(["build", "--profile", self.profile, "--package", MPI_PACKAGE]);
        cargo.args(["--no-default-features", "--features", features])
    }

    /// A cargo command that builds with this MPI.
    pub fn with_mpi<'c>(&self, cargo: Cmd<'c>) -> Cmd<'c> {
        // rsmpi prefers these to MPICC.
        let cargo = cargo.env_remove("MPI_PKG_CONFIG").env_remove("CRAY_MPICH_DIR").env("MPICC", &self.mpi.cc);
        cargo.envs(libclang::variable())
    }

    /// Removes builds with another MPI, which neither cargo nor make notice.
    pub fn remove_other_mpi(&self, step: &mut Step) -> Result<(), Error> {
        let record = self.products.join("shallow_water.mpi");
        let current = self.mpi.identity();
        if fs::read_to_string(&record).is_ok_and(|built| built == current) {
            return Ok(());
        }
        step.quiet(self.workspace.cargo(["clean", "--package", "mpi-sys", "--profile", self.profile]))?;
        self.workspace.shell.remove_path(self.folder())?;
        Ok(self.workspace.shell.write_file(&record, current)?)
    }

    /// The command that compiles it, with the Fortran module of the source tree.
    pub fn compile(&self) -> Cmd<'a> {
        let (folder, products, fortran) = (self.folder(), &self.products, &self.mpi.fortran);
        let module = self.workspace.root.join("include/icoray.f90");
        let sh = &self.workspace.shell;
        let make = cmd!(
            sh,
            "make -j2 -C {SHALLOW_WATER} MPI=1 FC={fortran} BUILD={folder} ICORAY_SOURCE={module}
             'ICORAY_LIB=-L'{products}' -l'{MPI_LIBRARY}' -Wl,-rpath,'{products}"
        );
        make.env_remove("MAKEFLAGS")
    }

    /// The command that runs it on so many ranks, each with its part of the mesh; its arguments are to be added.
    pub fn run(&self, ranks: usize) -> Result<Cmd<'a>, Error> {
        let processors = thread::available_parallelism().map_or(1, usize::from);
        let threads = (processors / ranks).max(1).to_string();
        let run = self.workspace.linked(&self.mpi.run, &self.products)?;
        let run = run.args(["-n", &ranks.to_string()]).envs(mpi_variables(&self.folder()));
        Ok(run.arg(self.folder().join("shallow_water")).args(["--threads", &threads]))
    }
}
