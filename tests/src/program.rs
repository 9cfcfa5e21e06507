//! The programs of other languages that the tests compile and run against the shared library.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// The repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The shared library, built. Tests run after Cargo has let go of its lock, so it can be run again from here.
pub static LIBRARY: LazyLock<PathBuf> = LazyLock::new(|| {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| env!("CARGO").into());
    let mut build = Command::new(cargo);
    build.args(["build", "--quiet", "--package", "icoray-capi", "--message-format=json-render-diagnostics"]);
    if !cfg!(debug_assertions) {
        build.arg("--release");
    }
    let output = succeeded(build.current_dir(root()));
    let name = format!("/{}icoray{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let messages = text(&output.stdout);
    let built = messages.split('"').find(|word| word.ends_with(&name));
    PathBuf::from(built.unwrap_or_else(|| panic!("cargo built no {name}:\n{messages}")))
});

/// What a program printed.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs a command that must be there and succeed.
///
/// # Panics
/// Where it is not or does not.
pub fn succeeded(command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|e| panic!("cannot run {command:?}: {e}"));
    assert!(
        output.status.success(),
        "{command:?}: {}\n{}{}",
        output.status,
        text(&output.stdout),
        text(&output.stderr)
    );
    output
}

/// Whether a tool is installed that a test can do without; says so where it is not.
pub fn is_there(tool: &str) -> bool {
    let there = Command::new(tool).arg("--version").output().is_ok_and(|o| o.status.success());
    if !there {
        println!("skipped: no {tool}");
    }
    there
}

/// A command in `directory`, without the search path that Cargo gives to tests: it would come before the program's
/// own, and has other builds of the library.
pub fn command(program: impl AsRef<OsStr>, directory: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(directory).env_remove("LD_LIBRARY_PATH");
    command
}

/// Runs a program that checks, and sees that neither it nor the library had anything else to say.
///
/// # Panics
/// Where they had, or where a check failed.
pub fn checked(command: &mut Command, program: &str) {
    let output = succeeded(command);
    assert_eq!(text(&output.stderr), "", "{command:?}");
    let stdout = text(&output.stdout);
    let verdict = stdout.strip_prefix(&format!("{program}: "));
    let count = verdict.and_then(|v| v.strip_suffix(" checks, 0 failed\n"));
    let count = count.and_then(|c| c.parse::<u32>().ok());
    assert!(count.is_some_and(|c| c > 100), "{command:?} printed more than its verdict:\n{stdout}");
}
