//! The library never harms its host: the model's state is unchanged after each call, and failures are statuses.
//!
//! Programs in C make the calls of models, one program for each state that could be harmed; checks that need a missing
//! resource (a small file system, another user) are skipped.

use icoray_test_support::{Need, count, runs, skip};
use icoray_tests::native::{checked, command, compile, compile_c, new_directory, succeeded, text, with_small_disk};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// A directory in memory where there is one: thousands of small pictures are no test of the disk.
fn directory() -> TempDir {
    let memory = Path::new("/dev/shm");
    let made = if memory.is_dir() { TempDir::new_in(memory) } else { TempDir::new() };
    made.or_else(|_| TempDir::new()).unwrap()
}

/// A program in a directory of its own.
struct Program {
    name: &'static str,
    directory: TempDir,
    path: PathBuf,
}

impl Program {
    fn new(name: &'static str) -> Self {
        let directory = directory();
        let path = compile_c(&[name, "host_common", "check"]);
        Program { name, directory, path }
    }

    fn at(&self) -> &Path {
        self.directory.path()
    }

    /// The program, given its directory.
    fn command(&self) -> Command {
        let mut command = command(&self.path, self.at());
        command.arg(self.at());
        command
    }

    /// Runs it, with `arguments` behind its directory.
    fn checks(&self, arguments: &[&str], least: u32) -> Vec<String> {
        checked(self.command().args(arguments), self.name, least)
    }
}

/// Tests that run a program with arguments behind its directory, and expect so many checks at least.
macro_rules! programs {
    ($($(#[$doc:meta])* $test:ident: $program:literal $arguments:tt, $least:literal;)*) => {$(
        $(#[$doc])*
        #[test]
        fn $test() {
            Program::new($program).checks(&$arguments, $least);
        }
    )*};
}

programs! {
    floating_point_is_left_as_it_is: "host_floats" [], 1000;
    signals_are_the_hosts: "host_signals" [], 100;
    forked_processes_get_answers: "host_fork" [], 60;
    threads_and_the_log_keep_apart: "host_threads" [], 400;
    a_slow_writer_drops_what_it_may_drop: "host_writer" ["slow"], 100;
    a_picture_is_never_seen_in_part: "host_writer" ["watched"], 100;
    /// Ten thousand frames in the long run.
    many_frames_take_no_more_memory: "host_steps" [count("1000", "10000")], 50;
}

#[test]
fn the_process_is_left_as_it_is() {
    let program = Program::new("host_process");
    // Nothing on either stream, with a backtrace asked for: checked() sees to that.
    checked(program.command().env("RUST_BACKTRACE", "full"), program.name, 100);
}

#[test]
fn only_log_stderr_prints() {
    let program = Program::new("host_process");
    let output = succeeded(program.command().arg("loud"));
    let stderr = text(&output.stderr);
    assert!(stderr.starts_with("icoray: warning: bad scene: ") && stderr.lines().count() == 1, "{stderr}");
    assert_eq!(text(&output.stdout), "host_process: 3 checks, 0 failed\n");
}

#[test]
fn a_full_disk_costs_the_pictures_that_it_has_no_room_for() {
    let program = Program::new("host_writer");
    new_directory(program.at(), "disk");
    let mut inner = command(&program.path, program.at());
    let Some(mut run) = with_small_disk(inner.args(["disk", "full"]), "200k", "disk") else { return };
    checked(&mut run, program.name, 30);
}

#[test]
fn a_directory_that_cannot_be_written_to_or_is_gone_is_a_status() {
    let program = Program::new("host_writer");
    program.checks(&["gone"], 50);
    program.checks(&["denied"], 5);
}

#[test]
fn a_frame_allocates_no_more_for_larger_fields() {
    if !cfg!(all(target_os = "linux", target_env = "gnu")) {
        return skip(Need::Glibc);
    }
    Program::new("host_memory").checks(&[], 500);
}

/// The host's memory as the compiler's sanitizers see it; what goes wrong ends the program.
///
/// The library itself can be built with AddressSanitizer too, which takes minutes and is done by hand:
/// `RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Zsanitizer=address cargo build --target x86_64-unknown-linux-gnu --target-dir
/// target/asan -p icoray-capi`, then a program of `tests/c` compiled with `-fsanitize=address` against that library.
#[test]
fn sanitizers_find_nothing() {
    let options = ["-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let directory = directory();
    std::fs::write(directory.path().join("probe.c"), "int main(void) { return 0; }\n").unwrap();
    let mut probe = command("cc", directory.path());
    probe.args(options).args(["probe.c", "-o", "probe"]);
    if !runs(&mut probe) || !runs(&mut command("./probe", directory.path())) {
        return skip(Need::Sanitizers);
    }
    let sanitized = |name: &'static str, arguments: &[&str]| {
        let program = compile("cc", &options, &[name, "host_common", "check"]);
        let output_dir = new_directory(directory.path(), &format!("{name} {}", arguments.concat()));
        let mut command = command(program, directory.path());
        command.arg(&output_dir).args(arguments).env("ASAN_OPTIONS", "detect_leaks=1:exitcode=99");
        // What drivers leave behind is theirs.
        command.env("VK_DRIVER_FILES", "/none.json").env("VK_ICD_FILENAMES", "/none.json");
        command
    };
    checked(&mut sanitized("host_process", &[]), "host_process", 100);
    checked(&mut sanitized("host_floats", &[]), "host_floats", 1000);
    checked(&mut sanitized("host_threads", &[]), "host_threads", 400);
    checked(&mut sanitized("host_writer", &["gone"]), "host_writer", 50);
    checked(&mut sanitized("host_writer", &["watched"]), "host_writer", 100);
    // They can fail: a mesh that is not freed is found.
    let lost = sanitized("host_leak", &[]).output().unwrap();
    let said = text(&lost.stderr);
    assert!(!lost.status.success() && said.contains("LeakSanitizer"), "{said}");
}
