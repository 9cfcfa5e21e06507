//! Where things lie: the sources, the build products, and the user.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::error::Error;

/// The places that the subcommands work with; all paths are absolute.
pub struct Workspace {
    root: PathBuf,
    /// Holds a directory per build profile.
    products: PathBuf,
    here: PathBuf,
}

impl Workspace {
    /// Finds the workspace that this program was built from.
    pub fn find() -> Result<Self, Error> {
        let here = env::current_dir().map_err(Error::while_doing("the current directory"))?;
        // Cargo sets the variable for `cargo run`; the path from the build serves a program that
        // was started by hand.
        let crate_dir = env::var_os("CARGO_MANIFEST_DIR")
            .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
        let root = crate_dir
            .parent()
            .filter(|root| root.join("Cargo.toml").is_file())
            .ok_or_else(|| Error::Failed(format!("no workspace above {}", crate_dir.display())))?
            .to_path_buf();
        // Cargo puts this program where it puts everything else, whatever moved that place: a
        // variable, a configuration file, a target triple.
        let program = env::current_exe().map_err(Error::while_doing("this program's path"))?;
        let products = program
            .ancestors()
            .nth(2)
            .ok_or_else(|| Error::Failed(format!("no build directory: {}", program.display())))?
            .to_path_buf();
        Ok(Self { root, products, here })
    }

    /// The directory that holds the workspace's `Cargo.toml`.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Where cargo puts what it builds: `release`, or `debug` for the dev profile.
    pub fn products(&self, profile: &str) -> PathBuf {
        self.products.join(profile)
    }

    /// A path the user gave, which is relative to where the user is.
    pub fn given(&self, path: &Path) -> PathBuf {
        self.here.join(path)
    }

    /// A path as the user would write it.
    pub fn shown(&self, path: &Path) -> String {
        path.strip_prefix(&self.here).unwrap_or(path).display().to_string()
    }

    /// A command that runs in the workspace's root.
    pub fn command(&self, program: impl Into<OsString>) -> Command {
        let mut command = Command::new(program.into());
        command.current_dir(&self.root);
        // A relative target directory means one below where the user is, not below the root.
        for name in ["CARGO_TARGET_DIR", "CARGO_BUILD_TARGET_DIR"] {
            if let Some(target) = env::var_os(name).filter(|target| !target.is_empty()) {
                command.env(name, self.here.join(target));
            }
        }
        command
    }

    /// A command that runs a program which is linked with a library of `products`.
    pub fn linked(&self, program: impl Into<OsString>, products: &Path) -> Result<Command, Error> {
        let mut command = self.command(program);
        // Cargo runs this program with its own directories on the search path, which comes before the program's: without
        // this, it would take a library left there by the tests.
        let inherited = env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
        let paths = [products.to_path_buf()].into_iter().chain(env::split_paths(&inherited));
        let paths = env::join_paths(paths).map_err(Error::while_doing("LD_LIBRARY_PATH"))?;
        command.env("LD_LIBRARY_PATH", paths);
        Ok(command)
    }

    /// A cargo command on this workspace.
    pub fn cargo<'a>(&self, arguments: impl IntoIterator<Item = &'a str>) -> Command {
        let mut command = self.command(cargo());
        command.args(arguments);
        command
    }
}

/// The cargo that runs this program, or else the one on the path.
pub fn cargo() -> OsString {
    env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_taken_and_shown_as_the_user_writes_them() {
        let workspace = Workspace {
            root: "/src/icoray".into(),
            products: "/src/icoray/target".into(),
            here: "/src".into(),
        };
        assert_eq!(workspace.given(Path::new("out")), Path::new("/src/out"));
        assert_eq!(workspace.given(Path::new("/elsewhere/out")), Path::new("/elsewhere/out"));
        assert_eq!(workspace.shown(Path::new("/src/icoray/out")), "icoray/out");
        assert_eq!(workspace.shown(Path::new("/elsewhere/out")), "/elsewhere/out");
        assert_eq!(workspace.products("debug"), Path::new("/src/icoray/target/debug"));
    }

    #[test]
    fn the_workspace_is_found() {
        let workspace = Workspace::find().unwrap();
        assert!(workspace.root().join("xtask/Cargo.toml").is_file());
    }
}
