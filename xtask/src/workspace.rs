//! Paths of the sources, the build products and the user, and commands that run there.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

use xshell::{Cmd, Shell};

use crate::error::Error;

/// The paths that the subcommands work with; all are absolute.
pub struct Workspace {
    /// The directory that holds the workspace's `Cargo.toml`.
    pub root: PathBuf,
    pub shell: Shell,
    /// Holds a directory per build profile.
    products: PathBuf,
    here: PathBuf,
}

impl Workspace {
    /// Finds the workspace that this program was built from.
    pub fn find() -> Result<Self, Error> {
        let shell = Shell::new()?;
        let here = shell.current_dir();
        // `cargo run` sets the variable; a program that was started without cargo takes the path known at compile time.
        let crate_dir = env::var_os("CARGO_MANIFEST_DIR").unwrap_or(env!("CARGO_MANIFEST_DIR").into());
        let root = Path::new(&crate_dir).parent().filter(|root| root.join("Cargo.toml").is_file());
        let root = root.ok_or_else(|| Error(format!("no workspace above {}", crate_dir.display())))?;
        // The directory of this program is that of all builds, whether a variable, a configuration file or a target
        // triple has set it.
        let program = env::current_exe().map_err(Error::while_doing("this program's path"))?;
        let products = program.ancestors().nth(2);
        let no_products = || Error(format!("no build directory: {}", program.display()));
        let products = products.ok_or_else(no_products)?.to_path_buf();
        shell.change_dir(root);
        // Cargo would take a relative target directory as relative to the root.
        for name in ["CARGO_TARGET_DIR", "CARGO_BUILD_TARGET_DIR"] {
            if let Some(target) = variable(name) {
                shell.set_var(name, here.join(target));
            }
        }
        Ok(Self { root: root.to_path_buf(), shell, products, here })
    }

    /// The directory where cargo puts what it builds: `release`, or `debug` for the dev profile.
    pub fn products(&self, profile: &str) -> PathBuf {
        self.products.join(if profile == "dev" { "debug" } else { profile })
    }

    /// The absolute path of a path that the user gave.
    pub fn given(&self, path: impl AsRef<Path>) -> PathBuf {
        self.here.join(path)
    }

    /// A path as the user would write it: relative to the user's directory where it is below that.
    pub fn shown(&self, path: &Path) -> String {
        path.strip_prefix(&self.here).unwrap_or(path).display().to_string()
    }

    /// The directory of the data files: that of `ICORAY_TEST_DATA`, or `../shared/data`.
    pub fn data(&self) -> PathBuf {
        variable("ICORAY_TEST_DATA").map_or_else(|| self.root.join("../shared/data"), |path| self.given(path))
    }

    /// A command that runs a program linked with a library of `products`.
    ///
    /// Cargo puts its own directories first on this program's library search path, and a library left there by the
    /// tests would be found before that of `products`.
    pub fn linked(&self, program: impl AsRef<Path>, products: &Path) -> Result<Cmd<'_>, Error> {
        Ok(self.shell.cmd(program).env("LD_LIBRARY_PATH", library_path([products.to_path_buf()])?))
    }

    /// A cargo command on this workspace.
    pub fn cargo<'a>(&self, arguments: impl IntoIterator<Item = &'a str>) -> Cmd<'_> {
        self.shell.cmd(cargo()).args(arguments)
    }
}

/// The library search path with these directories first.
pub fn library_path(first: impl IntoIterator<Item = PathBuf>) -> Result<OsString, Error> {
    let inherited = env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let paths = first.into_iter().chain(env::split_paths(&inherited));
    env::join_paths(paths).map_err(Error::while_doing("LD_LIBRARY_PATH"))
}

/// The cargo that runs this program, or else the one on the path.
pub fn cargo() -> OsString {
    env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// The value of an environment variable that is set and not empty.
pub fn variable(name: &str) -> Option<OsString> {
    env::var_os(name).filter(|value| !value.is_empty())
}

/// Fails if `ICORAY_REQUIRE` names a thing that the machine lacks, or all.
pub fn may_lack(name: &str) -> Result<(), Error> {
    let required = env::var("ICORAY_REQUIRE").unwrap_or_default();
    if required.split(',').any(|word| word == name || word == "all") {
        return Err(Error(format!("ICORAY_REQUIRE names {name}, and the machine lacks it")));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_taken_and_shown_as_the_user_writes_them() {
        let mut workspace = Workspace::find().unwrap();
        assert!(workspace.root.join("xtask/Cargo.toml").is_file());
        workspace.here = "/src".into();
        assert_eq!(workspace.given("out"), Path::new("/src/out"));
        assert_eq!(workspace.given("/elsewhere/out"), Path::new("/elsewhere/out"));
        assert_eq!(workspace.shown(Path::new("/src/icoray/out")), "icoray/out");
        assert_eq!(workspace.shown(Path::new("/elsewhere/out")), "/elsewhere/out");
        workspace.products = "/src/icoray/target".into();
        assert_eq!(workspace.products("dev"), Path::new("/src/icoray/target/debug"));
        assert_eq!(workspace.products("release"), Path::new("/src/icoray/target/release"));
    }
}
