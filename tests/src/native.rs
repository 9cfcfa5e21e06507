//! Compiles and runs programs in C that link the library as a model does.

use crate::programs::Program;
use icoray_test_support::{Need, runs, skip};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Options with which all programs in C are compiled: warnings are errors. Struct initialisers name or begin with a few
/// members; the others are zero.
pub(crate) const C_OPTIONS: [&str; 6] =
    ["-Wall", "-Wextra", "-Werror", "-pedantic", "-Wno-missing-field-initializers", "-O1"];

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A shared library that cargo has built beside this test program, as a dependency of this package.
fn beside_tests(name: &str) -> PathBuf {
    let library = format!("{}{name}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let path = std::env::current_exe().unwrap().with_file_name(library);
    assert!(path.is_file(), "{} is missing: cargo builds it with this package's tests", path.display());
    path
}

/// The shared library.
pub fn library() -> PathBuf {
    beside_tests("icoray_test")
}

/// The shared library with MPI, which the feature `mpi` builds.
pub fn mpi_library() -> PathBuf {
    beside_tests("icoray_mpi_test")
}

/// The implementation of Catalyst with MPI, which the feature `mpi` builds.
pub fn catalyst_library() -> PathBuf {
    beside_tests("catalyst_icoray")
}

/// The shared library for MPICH where `mpicc` is another MPI's: the one that ICORAY_MPICH_LIBRARY names.
pub fn mpich_library() -> PathBuf {
    let named = std::env::var_os("ICORAY_MPICH_LIBRARY");
    named.expect("ICORAY_MPICH_LIBRARY names the library for MPICH; `cargo xtask test --all` builds it").into()
}

/// What a program printed.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs a command that must be there and succeed.
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

/// All that a command printed, which must succeed.
pub fn log_of(command: &mut Command) -> String {
    let output = succeeded(command);
    text(&output.stdout) + &text(&output.stderr)
}

/// All that a host of `tests/c` printed, which must end well on all of its ranks.
pub fn ended_well(ranks: usize, host: &mut Command) -> String {
    let log = log_of(host);
    assert_eq!(log.matches("the host ended well").count(), ranks, "{log}");
    log
}

/// Compiles a program of `tests/c`, named as the first of its sources, with warnings as errors.
pub fn compile(compiler: &str, options: &[&str], sources: &[&str]) -> PathBuf {
    Program { library: &library(), compiler, options, sources }.path()
}

/// [`compile`] in C99.
pub fn compile_c(sources: &[&str]) -> PathBuf {
    compile("cc", &["-std=c99"], sources)
}

/// Compiles a program or shared library in C99, as [`compile`] does, to `to`; it links icoray with MPI behind `libraries`.
pub fn compile_to(to: &Path, compiler: &str, options: &[&str], sources: &[&str], libraries: &[&str]) {
    let options = &[&["-std=c99"], options].concat();
    Program { library: &mpi_library(), compiler, options, sources }.compile_to(to, libraries);
}

/// A command in `directory` that compiles icoray's module and further sources in standard Fortran without a warning; the
/// sources and the output are to be added.
pub fn fortran(compiler: &str, directory: &Path, options: &[&str]) -> Command {
    let mut command = command(compiler, directory);
    command.args(["-std=f2018", "-Wall", "-Wextra", "-Werror", "-J"]).arg(directory).args(options);
    command.arg(root().join("include/icoray.f90"));
    command
}

/// Options for programs in which an assignment allocates arrays: of every one gfortran 12 warns.
pub const ALLOCATES: [&str; 2] = ["-Wno-uninitialized", "-Wno-maybe-uninitialized"];

/// A new directory in another one.
pub fn new_directory(within: &Path, name: &str) -> PathBuf {
    let to = within.join(name);
    std::fs::create_dir(&to).unwrap();
    to
}

/// Arguments with which a compiler links a shared library, and programs find it where it is.
pub fn linked(library: impl AsRef<Path>) -> [OsString; 2] {
    let library = library.as_ref();
    let mut rpath = OsString::from("-Wl,-rpath,");
    rpath.push(library.parent().unwrap());
    [library.into(), rpath]
}

/// A command in `directory`, without the search path that Cargo gives to tests: it would come before the program's
/// own, and has other builds of the library.
pub fn command(program: impl AsRef<OsStr>, directory: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(directory).env_remove("LD_LIBRARY_PATH");
    command
}

/// A command that runs a program in `directory` under valgrind, and fails for each misuse and loss of memory.
pub fn valgrind(directory: &Path) -> Command {
    let mut command = command("valgrind", directory);
    command.args(["--quiet", "--error-exitcode=99", "--leak-check=full"]);
    command.args(["--show-leak-kinds=definite", "--errors-for-leak-kinds=definite"]);
    command
}

/// A command that runs `inner` with a small file system at `place`, of `bytes` in mount's notation, in a mount
/// namespace that ends with the command. Skips the test where the user may mount none.
pub fn with_small_disk(inner: &Command, bytes: &str, place: &str) -> Option<Command> {
    let directory = inner.get_current_dir().unwrap_or(Path::new("."));
    let script = format!("mount -t tmpfs -o size={bytes} none {place} && exec \"$@\"");
    let outer = |option: &str| {
        let mut outer = command("unshare", directory);
        outer.args([option, "-m", "sh", "-c", &script, "sh"]);
        outer
    };
    // As a user, then as the root of a namespace.
    let Some(option) = ["-m", "-r"].into_iter().find(|option| runs(outer(option).arg("true"))) else {
        skip(Need::Mount);
        return None;
    };
    let mut outer = outer(option);
    outer.arg(inner.get_program()).args(inner.get_args());
    outer.envs(inner.get_envs().filter_map(|(name, value)| Some((name, value?))));
    Some(outer)
}

/// Runs a program that checks, and sees that neither it nor the library had anything else to say. `least` is how many
/// checks it must have made. Lines of the program's that begin with `note: ` are passed on and returned.
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
    assert!(count.is_some_and(|c| c >= least), "{command:?}: less than {least} checks or more said:\n{stdout}");
    notes
}
