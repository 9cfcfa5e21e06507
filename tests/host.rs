//! The library never harms its host: what is the model's is left as it was, and what goes wrong is a status.
//!
//! Programs in C that do what models do, one for each of the things that could be harmed; what they cannot have here
//! (a file system that is full, another user) is skipped with a line that says so.

use icoray_tests::native::{checked, command, compile, compile_c, is_there, succeeded, text};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A directory in memory where there is one: thousands of small pictures are no test of the disk.
fn directory() -> TempDir {
    let memory = Path::new("/dev/shm");
    let made = if memory.is_dir() { TempDir::new_in(memory) } else { TempDir::new() };
    made.or_else(|_| TempDir::new()).unwrap()
}

/// A program in a directory of its own, which may run things as another user.
struct Program {
    name: &'static str,
    directory: TempDir,
    path: PathBuf,
}

impl Program {
    fn new(name: &'static str) -> Self {
        let directory = directory();
        let path = compile_c(&[name, "host_common", "check"], directory.path());
        Program { name, directory, path }
    }

    fn at(&self) -> &Path {
        self.directory.path()
    }

    /// The program, to be run under `wrapper`, given its directory first.
    fn under(&self, wrapper: &[&str]) -> Command {
        let mut command = match wrapper {
            [] => command(&self.path, self.at()),
            [first, rest @ ..] => {
                let mut command = command(first, self.at());
                command.args(rest).arg(&self.path);
                command
            }
        };
        command.arg(self.at());
        command
    }

    /// Runs it, with `arguments` behind its directory.
    fn checks(&self, arguments: &[&str], least: u32) -> Vec<String> {
        checked(self.under(&[]).args(arguments), self.name, least)
    }
}

#[test]
fn floating_point_is_left_as_it_is() {
    Program::new("host_floats").checks(&[], 1000);
}

#[test]
fn signals_are_the_hosts() {
    Program::new("host_signals").checks(&[], 100);
}

#[test]
fn the_process_is_left_as_it_is() {
    let program = Program::new("host_process");
    // Nothing on either stream, with a backtrace asked for: checked() sees to that.
    checked(program.under(&[]).env("RUST_BACKTRACE", "full"), program.name, 100);
}

#[test]
fn only_log_stderr_prints() {
    let program = Program::new("host_process");
    let output = succeeded(program.under(&[]).arg("loud"));
    let stderr = text(&output.stderr);
    assert!(stderr.starts_with("icoray: warning: bad scene: ") && stderr.lines().count() == 1, "{stderr}");
    assert_eq!(text(&output.stdout), "host_process: 3 checks, 0 failed\n");
}

#[test]
fn forked_processes_get_answers() {
    Program::new("host_fork").checks(&[], 60);
}

#[test]
fn threads_and_the_log_keep_apart() {
    Program::new("host_threads").checks(&[], 400);
}
