//! The folders in which the commands of the pages run.

use std::env;
use std::fs;
use std::io;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use xshell::cmd;

use super::needs;
use crate::error::Error;
use crate::files;
use crate::workspace::Workspace;

/// Their parent, below the workspace's root, so that cargo finds the workspace and its aliases.
const PLACE: &str = "out/docs";

/// The folder of all pages.
pub struct Scratch<'w> {
    workspace: &'w Workspace,
    root: PathBuf,
}

impl<'w> Scratch<'w> {
    /// An empty folder.
    pub fn new(workspace: &'w Workspace) -> Result<Self, Error> {
        let root = workspace.root.join(PLACE);
        workspace.shell.remove_path(&root)?;
        workspace.shell.create_dir(&root)?;
        Ok(Self { workspace, root })
    }

    /// The folder of a page, with the files that its commands use: the examples, the data files, the builds.
    pub fn page(&self, path: &Path) -> Result<PathBuf, Error> {
        let sh = &self.workspace.shell;
        let folder = sh.create_dir(self.root.join(path.with_extension("").file_name().unwrap_or_default()))?;
        sh.create_dir(home(&folder))?;
        cmd!(sh, "cp -R examples {folder}").quiet().run()?;
        self.link(&folder).map_err(Error::while_doing(folder.display()))?;
        Ok(folder)
    }

    fn link(&self, folder: &Path) -> io::Result<()> {
        symlink(self.workspace.products(""), folder.join("target"))?;
        let data = files::fitting(&self.workspace.data(), "*");
        for file in &data {
            symlink(fs::canonicalize(file)?, folder.join(files::name(file)))?;
        }
        if data.is_empty() { Ok(()) } else { symlink(needs::FILE, folder.join("FILE.nc")) }
    }

    /// A shell that runs a script in a page's folder, with the programs that the tests have built.
    pub fn bash(&self, folder: &Path, script: &str) -> Command {
        let mut command = Command::from(self.workspace.shell.cmd("bash").arg(script));
        command.current_dir(folder);
        // Programs of the pages must find libraries by themselves; cargo adds its own directories to this variable.
        command.env_remove("LD_LIBRARY_PATH");
        let users = env::var_os("HOME").map(PathBuf::from).unwrap_or_default();
        for (name, place) in [("CARGO_HOME", ".cargo"), ("RUSTUP_HOME", ".rustup")] {
            let place = env::var_os(name).map_or_else(|| users.join(place), PathBuf::from);
            command.env(name, place);
        }
        command.env("HOME", home(folder));
        let inherited = env::var_os("PATH").unwrap_or_default();
        let programs = self.workspace.products("dev");
        // Pages put target/release first, where a test has left a program with fewer features.
        command.env("PROGRAMS", &programs);
        let built = [programs].into_iter();
        if let Ok(path) = env::join_paths(built.chain(env::split_paths(&inherited))) {
            command.env("PATH", path);
        }
        // Without these, Open MPI refuses to run as root, or more ranks than cores.
        command.envs([
            ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
            ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
            ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
        ]);
        command
    }
}

/// The home of a page: hidden, since commands of the pages list and watch the folder.
fn home(folder: &Path) -> PathBuf {
    folder.join(".home")
}
