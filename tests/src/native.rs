//! Programs in C against the library as a model has it: built, compiled and run.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Tests run after Cargo has let go of its lock, so it can be run again from here.
static LIBRARY: LazyLock<PathBuf> = LazyLock::new(|| built("icoray-capi", "icoray", |_| ()));

/// The library with MPI, under another name: one of the same name would be built in the other's place by turns.
static MPI_LIBRARY: LazyLock<PathBuf> = LazyLock::new(|| built("icoray-capi-mpi", "icoray_mpi_test", |_| ()));

/// The same for MPICH where `mpicc` is another MPI's. Cargo does not see that the compiler is another one, so all of it is
/// built in a directory of its own.
static MPICH_LIBRARY: LazyLock<PathBuf> = LazyLock::new(|| {
    built("icoray-capi-mpi", "icoray_mpi_test", |build| {
        // Where this test itself was built, in a subdirectory.
        let target = std::env::current_exe().ok().and_then(|exe| Some(exe.ancestors().nth(3)?.join("mpich")));
        build.env("MPICC", "mpicc.mpich").arg("--target-dir").arg(target.unwrap_or("target/mpich".into()));
    })
});

/// Builds a package, as `how` says more of it; the path of its shared library.
fn built(package: &str, library: &str, how: impl FnOnce(&mut Command)) -> PathBuf {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| env!("CARGO").into());
    let mut build = Command::new(cargo);
    build.args(["build", "--quiet", "--package", package, "--message-format=json-render-diagnostics"]);
    if !cfg!(debug_assertions) {
        build.arg("--release");
    }
    how(&mut build);
    let output = succeeded(build.current_dir(root()));
    let name = format!("/{}{library}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let messages = text(&output.stdout);
    let built = messages.split('"').find(|word| word.ends_with(&name));
    PathBuf::from(built.unwrap_or_else(|| panic!("cargo built no {name}:\n{messages}")))
}

/// The shared library, built.
///
/// # Panics
/// When it cannot be built.
pub fn library() -> &'static Path {
    &LIBRARY
}

/// The shared library with MPI, built.
///
/// # Panics
/// When it cannot be built.
pub fn mpi_library() -> &'static Path {
    &MPI_LIBRARY
}

/// The shared library for MPICH, built.
///
/// # Panics
/// When it cannot be built.
pub fn mpich_library() -> &'static Path {
    &MPICH_LIBRARY
}

/// What a program printed.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs a command that must be there and succeed.
///
/// # Panics
/// When it does not.
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

/// Compiles a program of `tests/c`, named as the first of its sources, into `directory`, with warnings as errors.
///
/// # Panics
/// When it does not compile.
pub fn compile(compiler: &str, options: &[&str], sources: &[&str], directory: &Path) -> PathBuf {
    compile_with(library(), compiler, options, sources, directory)
}

/// [`compile`] with a certain build of the library.
///
/// # Panics
/// When it does not compile.
pub fn compile_with(
    library: &Path,
    compiler: &str,
    options: &[&str],
    sources: &[&str],
    directory: &Path,
) -> PathBuf {
    let to = directory.join(sources[0]);
    let mut rpath = OsString::from("-Wl,-rpath,");
    rpath.push(library.parent().unwrap_or(Path::new(".")));
    let mut command = Command::new(compiler);
    command.args(options).args(["-O1", "-Wall", "-Wextra", "-Werror", "-pedantic"]);
    command.arg("-I").arg(root().join("include"));
    command.args(sources.iter().map(|source| root().join("tests/c").join(source).with_extension("c")));
    // After the sources, so that -x does not make it a source too.
    command.args(["-x", "none"]).arg(library).arg(rpath).args(["-lm", "-lpthread", "-ldl", "-o"]).arg(&to);
    succeeded(&mut command);
    to
}

/// [`compile`] in C99.
///
/// # Panics
/// When it does not compile.
pub fn compile_c(sources: &[&str], directory: &Path) -> PathBuf {
    compile("cc", &["-std=c99"], sources, directory)
}

/// A command in `directory`, without the search path that Cargo gives to tests: it would come before the program's
/// own, and has other builds of the library.
pub fn command(program: impl AsRef<OsStr>, directory: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(directory).env_remove("LD_LIBRARY_PATH");
    command
}

/// Runs a program that checks, and sees that neither it nor the library had anything else to say. `least` is how many
/// checks it must have made. Lines of the program's that begin with `note: ` are passed on and returned.
///
/// # Panics
/// When it failed, was stopped, or printed something else.
pub fn checked(command: &mut Command, program: &str, least: u32) -> Vec<String> {
    let output = succeeded(command);
    assert_eq!(text(&output.stderr), "", "{command:?}");
    let stdout = text(&output.stdout);
    let is_note = |line: &&str| line.starts_with("note: ");
    let notes: Vec<String> = stdout.lines().filter(is_note).map(str::to_owned).collect();
    let rest: Vec<&str> = stdout.lines().filter(|line| !is_note(line)).collect();
    for note in &notes {
        println!("{program}: {note}");
    }
    let verdict = if rest.len() == 1 { rest[0].strip_prefix(&format!("{program}: ")) } else { None };
    let count = verdict.and_then(|v| v.strip_suffix(" checks, 0 failed"));
    let count = count.and_then(|c| c.parse::<u32>().ok());
    assert!(
        count.is_some_and(|c| c >= least),
        "{command:?}: less than {least} checks or more said:\n{stdout}"
    );
    notes
}
