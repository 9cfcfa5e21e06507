//! The tracer model of `examples/c`: building it, running it, and what it leaves behind.

use std::env;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::error::Error;
use crate::options::Size;
use crate::workspace::Workspace;

/// How a model is linked with the library.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Linkage {
    /// With the shared library, which is found again where it was built.
    Shared,
    /// With the static library and what Rust's standard library needs.
    Static,
}

/// The model's files.
const SOURCES: [&str; 5] = [
    "examples/c/tracer.c",
    "examples/c/mesh.c",
    "examples/c/options.c",
    "examples/c/transport.c",
    "examples/c/winds.c",
];

/// The file in the output directory that has a line per frame.
pub const REPORT: &str = "report.csv";
/// The picture of all pictures.
pub const CONTACT_SHEET: &str = "contact_sheet.png";

/// A tracer model that was or is to be built.
pub struct Tracer<'a> {
    workspace: &'a Workspace,
    products: PathBuf,
    linkage: Linkage,
}

impl<'a> Tracer<'a> {
    /// The tracer linked with the library of a build profile.
    pub fn new(workspace: &'a Workspace, profile: &str, linkage: Linkage) -> Self {
        Self { workspace, products: workspace.products(profile), linkage }
    }

    fn program(&self) -> PathBuf {
        self.products.join(match self.linkage {
            Linkage::Shared => "tracer",
            Linkage::Static => "tracer-static",
        })
    }

    /// The command that compiles it.
    pub fn compile(&self) -> Command {
        let mut cc = self.workspace.command("cc");
        // Warnings are errors: the header must be clean in the strictest of users' builds.
        cc.args(["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-Iinclude"]);
        cc.args(SOURCES).arg("-o").arg(self.program());
        match self.linkage {
            Linkage::Shared => {
                let mut search = std::ffi::OsString::from("-L");
                search.push(&self.products);
                let mut rpath = std::ffi::OsString::from("-Wl,-rpath,");
                rpath.push(&self.products);
                cc.arg(search).args(["-licoray", "-lm"]).arg(rpath);
            }
            Linkage::Static => {
                cc.arg(self.products.join("libicoray.a"));
                cc.args(["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl", "-lc"]);
            }
        }
        cc
    }

    /// The command that runs it.
    pub fn run(&self, size: Size, scene: Option<&Path>, out: &Path) -> Result<Command, Error> {
        let mut tracer = self.workspace.command(self.program());
        tracer.args(["--level", &size.level.to_string()]);
        tracer.args(["--layers", &size.layers.to_string()]);
        tracer.args(["--days", &size.days.to_string()]);
        tracer.arg("--scene").arg(scene.unwrap_or(Path::new("examples/scenes/tracer.toml")));
        tracer.arg("--out").arg(out);
        // Cargo runs this program with its own directories on the search path, which comes before
        // the program's: without this, the demo would take a library left there by the tests.
        let inherited = env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
        let paths = [self.products.clone()].into_iter().chain(env::split_paths(&inherited));
        let paths = env::join_paths(paths).map_err(Error::while_doing("LD_LIBRARY_PATH"))?;
        tracer.env("LD_LIBRARY_PATH", paths);
        Ok(tracer)
    }
}

/// The command that builds the library in both forms.
pub fn build_library(workspace: &Workspace, release: bool) -> Command {
    let profile = if release { "release" } else { "dev" };
    workspace.cargo(["build", "--package", "icoray-capi", "--profile", profile])
}

/// Makes the output directory, and removes what an earlier run left in it, which would pass for
/// this run's. Files of other names are the user's and stay.
pub fn prepare(out: &Path) -> Result<(), Error> {
    let failed = |what: &Path, cause: io::Error| Error::Failed(format!("{}: {cause}", what.display()));
    fs::create_dir_all(out).map_err(|cause| failed(out, cause))?;
    let mut stale = pictures(out)?;
    stale.extend([out.join(REPORT), out.join(CONTACT_SHEET)]);
    for file in stale {
        match fs::remove_file(&file) {
            Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
                return Err(failed(&file, cause));
            }
            _ => {}
        }
    }
    Ok(())
}

/// The tracer's pictures in a directory, in order.
pub fn pictures(out: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = fs::read_dir(out).map_err(Error::while_doing(out.display()))?;
    let mut pictures = Vec::new();
    for entry in entries {
        let path = entry.map_err(Error::while_doing(out.display()))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("tracer_") && name.ends_with(".png") {
            pictures.push(path);
        }
    }
    pictures.sort();
    Ok(pictures)
}

/// Fails unless the file is a PNG that was written to its end.
pub fn check_picture(path: &Path) -> Result<(), Error> {
    let bytes = fs::read(path).map_err(Error::while_doing(path.display()))?;
    if is_png(&bytes) { Ok(()) } else { Err(Error::Failed(format!("{} is not a whole PNG", path.display()))) }
}

fn is_png(bytes: &[u8]) -> bool {
    // The last chunk is the same in every file: empty, its name, its checksum.
    const END: &[u8] = b"\0\0\0\0IEND\xae\x42\x60\x82";
    bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(END)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory of its own for a test, removed at the end.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            let path = env::temp_dir().join(format!("icoray-xtask-{name}-{}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn only_the_tracers_own_files_are_removed() {
        let scratch = Scratch::new("prepare");
        let out = scratch.0.join("a/b");
        prepare(&out).unwrap();
        let files = ["tracer_0001.png", "tracer_0000.png", "report.csv", "contact_sheet.png", "mine.png"];
        for name in files {
            fs::write(out.join(name), "").unwrap();
        }
        let found = pictures(&out).unwrap();
        assert_eq!(found, [out.join("tracer_0000.png"), out.join("tracer_0001.png")]);
        prepare(&out).unwrap();
        let left: Vec<_> = fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["mine.png"]);
    }

    #[test]
    fn a_picture_must_be_whole() {
        let whole = b"\x89PNG\r\n\x1a\n...\0\0\0\0IEND\xae\x42\x60\x82";
        assert!(is_png(whole));
        assert!(!is_png(&whole[..whole.len() - 1]));
        assert!(!is_png(b"GIF89a"));
        assert!(!is_png(b""));
    }
}
