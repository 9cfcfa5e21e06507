//! Programs in C of `tests/c`, each compiled once by a process.

use crate::native::{C_OPTIONS, linked, root, succeeded};
use std::collections::BTreeMap;
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// A program to compile, named as the first of its sources.
pub struct Program<'a> {
    /// The shared library that it links.
    pub library: &'a Path,
    /// The compiler's name.
    pub compiler: &'a str,
    /// The standard, and options behind those of all.
    pub options: &'a [&'a str],
    /// Paths from `tests/c`, or absolute ones, without `.c`.
    pub sources: &'a [&'a str],
}

/// Programs of this process: tests that need the same one at the same time wait for each other.
static COMPILED: Mutex<BTreeMap<PathBuf, Arc<OnceLock<()>>>> = Mutex::new(BTreeMap::new());

impl Program<'_> {
    /// The path of the program, compiled if need be.
    pub fn path(&self) -> PathBuf {
        let mut command = self.command(&[]);
        let mut hasher = DefaultHasher::new();
        format!("{command:?}").hash(&mut hasher);
        let directory = target().join("tmp/programs").join(format!("{:016x}", hasher.finish()));
        let program = directory.join(Path::new(self.sources[0]).file_name().unwrap());
        let mut compiled = COMPILED.lock().unwrap_or_else(PoisonError::into_inner);
        let once = compiled.entry(program.clone()).or_default().clone();
        drop(compiled);
        once.get_or_init(|| {
            fs::create_dir_all(&directory).unwrap();
            // Under another name first: another process may be running the old one, or compile it too.
            let new = directory.join(format!("new-{}", std::process::id()));
            succeeded(command.arg("-o").arg(&new));
            fs::rename(&new, &program).unwrap();
        });
        program
    }

    /// Compiles the program, or a shared library, to `to`; it links icoray behind `libraries`.
    pub fn compile_to(&self, to: &Path, libraries: &[&str]) {
        succeeded(self.command(libraries).arg("-o").arg(to));
    }

    /// The compiler's command but for its output.
    fn command(&self, libraries: &[&str]) -> Command {
        let mut command = Command::new(self.compiler);
        command.env_remove("LD_LIBRARY_PATH").args(C_OPTIONS).args(self.options);
        let sources = self.sources.iter().map(|source| root().join("tests/c").join(source).with_extension("c"));
        command.arg("-I").arg(root().join("include")).args(sources);
        // After the sources, so that -x does not make it a source too.
        command.args(["-x", "none"]).args(libraries).args(linked(self.library)).args(["-lm", "-lpthread", "-ldl"]);
        command
    }
}

/// Cargo's directory of build products.
fn target() -> PathBuf {
    let exe = std::env::current_exe().unwrap();
    // TARGET/PROFILE/deps/PROGRAM
    exe.ancestors().nth(3).expect("tests run where cargo has built them").to_owned()
}
