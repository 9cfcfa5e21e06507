//! Builds and runs the tracer model of `examples/c`.

use std::path::PathBuf;

use xshell::{Cmd, cmd};

use crate::error::Error;
use crate::workspace::Workspace;

/// The model's files, in `examples/c`.
const SOURCES: [&str; 6] = ["tracer.c", "mesh.c", "options.c", "ranks.c", "transport.c", "winds.c"];

/// The model's scene, below the workspace's root.
pub const SCENE: &str = "examples/scenes/tracer.toml";

/// The start of the names of its pictures.
pub const PREFIX: &str = "tracer_";

/// The model, linked with the shared library of a build profile.
pub struct Tracer<'a> {
    workspace: &'a Workspace,
    products: PathBuf,
}

impl<'a> Tracer<'a> {
    pub fn new(workspace: &'a Workspace, profile: &str) -> Self {
        Self { workspace, products: workspace.products(profile) }
    }

    fn program(&self) -> PathBuf {
        self.products.join("tracer")
    }

    /// The command that compiles it. Warnings are errors: the header must be clean in the strictest builds.
    pub fn compile(&self) -> Cmd<'a> {
        let (program, products) = (self.program(), &self.products);
        let sources = SOURCES.map(|source| format!("examples/c/{source}"));
        let sh = &self.workspace.shell;
        cmd!(
            sh,
            "cc -std=c99 -O2 -Wall -Wextra -Werror -pedantic -Iinclude {sources...} -o {program}
             -L{products} -licoray -lm -Wl,-rpath,{products}"
        )
    }

    /// The command that runs it; its arguments are to be added.
    pub fn run(&self) -> Result<Cmd<'a>, Error> {
        self.workspace.linked(self.program(), &self.products)
    }
}
