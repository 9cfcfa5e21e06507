//! Builds and runs the tracer model of `examples/c`.

use std::path::{Path, PathBuf};

use xshell::{Cmd, cmd};

use crate::error::Error;
use crate::options::Size;
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

    /// The command that runs it.
    pub fn run(&self, size: Size, scene: &Path, out: &Path) -> Result<Cmd<'a>, Error> {
        let [level, layers, days] = [size.level.to_string(), size.layers.to_string(), size.days.to_string()];
        let tracer = self.workspace.linked(self.program(), &self.products)?;
        let tracer = tracer.args(["--level", &level, "--layers", &layers, "--days", &days, "--scene"]);
        Ok(tracer.arg(scene).arg("--out").arg(out))
    }
}
