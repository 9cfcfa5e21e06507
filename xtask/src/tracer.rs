//! The tracer model of `examples/c`: building it and running it.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::error::Error;
use crate::options::Size;
use crate::workspace::Workspace;

/// The model's files.
const SOURCES: [&str; 6] = [
    "examples/c/tracer.c",
    "examples/c/mesh.c",
    "examples/c/options.c",
    "examples/c/ranks.c",
    "examples/c/transport.c",
    "examples/c/winds.c",
];

/// Its scene, below the workspace's root.
pub const SCENE: &str = "examples/scenes/tracer.toml";

/// How the names of its pictures begin.
pub const PREFIX: &str = "tracer_";

/// A tracer model that was or is to be built.
pub struct Tracer<'a> {
    workspace: &'a Workspace,
    products: PathBuf,
}

impl<'a> Tracer<'a> {
    /// The tracer linked with the shared library of a build profile, which is found again where it was built.
    pub fn new(workspace: &'a Workspace, profile: &str) -> Self {
        Self { workspace, products: workspace.products(profile) }
    }

    fn program(&self) -> PathBuf {
        self.products.join("tracer")
    }

    /// The command that compiles it.
    pub fn compile(&self) -> Command {
        let mut cc = self.workspace.command("cc");
        // Warnings are errors: the header must be clean in the strictest of users' builds.
        cc.args(["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Iinclude"]);
        cc.args(SOURCES).arg("-o").arg(self.program());
        let mut search = std::ffi::OsString::from("-L");
        search.push(&self.products);
        let mut rpath = std::ffi::OsString::from("-Wl,-rpath,");
        rpath.push(&self.products);
        cc.arg(search).args(["-licoray", "-lm"]).arg(rpath);
        cc
    }

    /// The command that runs it.
    pub fn run(&self, size: Size, scene: &Path, out: &Path) -> Result<Command, Error> {
        let mut tracer = self.workspace.linked(self.program(), &self.products)?;
        tracer.args(["--level", &size.level.to_string()]);
        tracer.args(["--layers", &size.layers.to_string()]);
        tracer.args(["--days", &size.days.to_string()]);
        tracer.arg("--scene").arg(scene).arg("--out").arg(out);
        Ok(tracer)
    }
}
