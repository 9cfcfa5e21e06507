//! The folders in which commands of the pages run.

use std::env;
use std::fs;
use std::io;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::needs;
use crate::error::Error;
use crate::workspace::Workspace;

/// Where the folders are, below the workspace's root: there cargo finds the workspace and its aliases.
const PLACE: &str = "out/docs";

/// The folder of all pages.
pub struct Scratch<'w> {
    workspace: &'w Workspace,
    root: PathBuf,
}

impl<'w> Scratch<'w> {
    /// An empty folder.
    pub fn new(workspace: &'w Workspace) -> Result<Self, Error> {
        let root = workspace.root().join(PLACE);
        let emptied = match fs::remove_dir_all(&root) {
            Err(cause) if cause.kind() != io::ErrorKind::NotFound => Err(cause),
            _ => fs::create_dir_all(root.join("home")),
        };
        emptied.map_err(Error::while_doing(root.display()))?;
        Ok(Self { workspace, root })
    }

    /// The folder of a page, with what its commands refer to: the examples, the data files, the builds.
    pub fn page(&self, path: &Path) -> Result<PathBuf, Error> {
        let folder = self.root.join(path.with_extension("").file_name().unwrap_or_default());
        self.fill(&folder).map_err(Error::while_doing(folder.display()))?;
        Ok(folder)
    }

    fn fill(&self, folder: &Path) -> io::Result<()> {
        fs::create_dir_all(folder)?;
        copy(&self.workspace.root().join("examples"), &folder.join("examples"))?;
        symlink(self.workspace.products(""), folder.join("target"))?;
        let data = needs::data(self.workspace);
        if let Ok(files) = fs::read_dir(&data) {
            for file in files {
                let name = file?.file_name();
                symlink(fs::canonicalize(data.join(&name))?, folder.join(&name))?;
            }
            symlink(needs::FILE, folder.join("FILE.nc"))?;
        }
        Ok(())
    }

    /// A shell in a page's folder. The long run builds the command `icoray`; otherwise it is the one of the tests.
    pub fn bash(&self, folder: &Path, all: bool) -> Command {
        let mut command = self.workspace.command("bash");
        command.current_dir(folder);
        // Programs of the pages must find libraries by themselves; cargo adds its own folders to this variable.
        command.env_remove("LD_LIBRARY_PATH");
        let home = env::var_os("HOME").map(PathBuf::from).unwrap_or_default();
        for (name, place) in [("CARGO_HOME", ".cargo"), ("RUSTUP_HOME", ".rustup")] {
            let place = env::var_os(name).map_or_else(|| home.join(place), PathBuf::from);
            command.env(name, place);
        }
        command.env("HOME", self.root.join("home"));
        let profiles: &[&str] = if all { &["release", "debug"] } else { &["debug"] };
        let built = profiles.iter().map(|profile| self.workspace.products(profile));
        let inherited = env::var_os("PATH").unwrap_or_default();
        if let Ok(path) = env::join_paths(built.chain(env::split_paths(&inherited))) {
            command.env("PATH", path);
        }
        // Open MPI refuses to run as root, and more ranks than cores, unless it is told that this is meant.
        command.envs([
            ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
            ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
            ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
        ]);
        command
    }
}

/// Copies a folder.
fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() { copy(&from, &to)? } else { fs::copy(&from, &to).map(drop)? }
    }
    Ok(())
}
