//! Support for icoray's tests: skips that are counted, test data, short and long counts, random numbers, a client of the
//! live page. It has no dependencies.
//!
//! Environment variables; `cargo xtask test` sets the first two:
//!
//! | variable | meaning |
//! |---|---|
//! | `ICORAY_TESTS` | `all`: long counts, and the tests that only `cargo xtask test --all` runs |
//! | `ICORAY_SKIPPED` | file to which each skip appends the line `BINARY TEST CAUSE`, separated by tabs |
//! | `ICORAY_REQUIRE` | comma-separated [names](Need::name), or `all`: a skip for want of one of these fails its test |
//! | `ICORAY_TEST_DATA` | folder of the data files; `../shared/data` beside the repository if unset |

mod need;
mod page;
mod random;

pub use need::Need;
pub use page::{PageAnswer, PageClient};
pub use random::Random;

use std::ffi::OsStr;
use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// How long a test waits for an event that always comes before it takes it for a hang. No slow machine needs as long: a
/// test never measures by it.
pub const PATIENCE: Duration = Duration::from_secs(900);

/// Reports that the calling test, or the rest of it, does not run because `need` is not met. The test then returns.
/// Fails where `ICORAY_REQUIRE` names the need.
pub fn skip(need: Need) {
    skip_because(need, "");
}

/// [`skip`] with details, such as the message of the library that looked for a device.
pub fn skip_because(need: Need, details: impl Display) {
    let details = details.to_string();
    let gap = if details.is_empty() { "" } else { ": " };
    let cause = need.cause();
    let list = std::env::var("ICORAY_REQUIRE").unwrap_or_default();
    let required = need::required(&list).unwrap_or_else(|error| panic!("ICORAY_REQUIRE: {error}"));
    assert!(!required.contains(&need), "{cause}{gap}{details}, and ICORAY_REQUIRE has `{}`", need.name());
    println!("skipped: {cause}{gap}{details}");
    if let Some(list) = std::env::var_os("ICORAY_SKIPPED") {
        append(Path::new(&list), cause);
    }
}

/// Appends a skip of the running test to the list, in one write: tests of several threads share it.
fn append(list: &Path, cause: &str) {
    let binary = std::env::current_exe().ok();
    let binary = binary.as_deref().and_then(Path::file_stem).unwrap_or_default();
    // The test harness names each test's thread after the test.
    let thread = std::thread::current();
    let line = format!("{}\t{}\t{cause}\n", binary.display(), thread.name().unwrap_or("unknown"));
    let file = OpenOptions::new().create(true).append(true).open(list);
    let written = file.and_then(|mut file| file.write_all(line.as_bytes()));
    written.unwrap_or_else(|error| panic!("{}: {error}", list.display()));
}

/// Whether the program `tool` is installed, that is, `tool --version` succeeds. If not, skips for `need`.
pub fn has_tool(need: Need, tool: &str) -> bool {
    let is_there = runs(Command::new(tool).arg("--version"));
    if !is_there {
        skip_because(need, format_args!("`{tool} --version` fails"));
    }
    is_there
}

/// Whether a command can be run and succeeds; its output is dropped.
pub fn runs(command: &mut Command) -> bool {
    command.output().is_ok_and(|output| output.status.success())
}

/// A command that runs a program on so many ranks by the launcher `mpirun`, in a directory that no other run uses at the
/// time, and that stops it where it hangs. The program and its arguments are to be added.
pub fn on_ranks(mpirun: &str, ranks: usize, directory: &Path) -> Command {
    let mut run = Command::new("timeout");
    run.args(["--kill-after=5", &PATIENCE.as_secs().to_string(), mpirun, "-n", &ranks.to_string()]);
    run.current_dir(directory).envs(mpi_variables(directory));
    run
}

/// Variables with which Open MPI's launcher starts any number of ranks on any machine: more ranks than processors, of
/// which those that wait leave theirs to others, without copies that containers forbid, and as root. Its own files lie
/// below the directory, as launchers with one place for them remove it while others start. Other MPIs do not read these.
pub fn mpi_variables(directory: &Path) -> [(&'static str, &OsStr); 7] {
    [
        ("OMPI_MCA_rmaps_base_oversubscribe", "1".as_ref()),
        ("OMPI_MCA_hwloc_base_binding_policy", "none".as_ref()),
        ("OMPI_MCA_mpi_yield_when_idle", "1".as_ref()),
        ("OMPI_MCA_btl_vader_single_copy_mechanism", "none".as_ref()),
        ("OMPI_MCA_orte_tmpdir_base", directory.as_os_str()),
        ("OMPI_ALLOW_RUN_AS_ROOT", "1".as_ref()),
        ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1".as_ref()),
    ]
}

/// The path of the data file `name`. If it is not there, skips for [`Need::Data`].
pub fn data_file(name: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let path = std::env::var_os("ICORAY_TEST_DATA").map_or_else(beside, PathBuf::from).join(name);
    if path.is_file() {
        return Some(path);
    }
    skip_because(Need::Data, path.display());
    None
}

/// Whether this is the long run, `cargo xtask test --all`.
pub fn is_long() -> bool {
    match std::env::var("ICORAY_TESTS").as_deref() {
        Err(_) | Ok("") => false,
        Ok("all") => true,
        Ok(other) => panic!("ICORAY_TESTS is {other:?}; known is `all`"),
    }
}

/// `long` in the long run, else `short`: how many rays, files or frames a test takes.
pub fn count<T>(short: T, long: T) -> T {
    if is_long() { long } else { short }
}

/// Whether this is the long run. If not, skips for [`Need::Long`].
pub fn runs_long() -> bool {
    let is_long = is_long();
    if !is_long {
        skip(Need::Long);
    }
    is_long
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Stdio;

    const CHILD: &str = "ICORAY_TEST_SUPPORT_CHILD";

    /// What the child does that [`CHILD`] names.
    fn do_as_child(what: &str) {
        match what {
            "skip" => skip_because(Need::Gpu, "no driver"),
            "tool" => println!("there {}", has_tool(Need::Valgrind, "icoray-no-such-tool")),
            "count" => println!("count {}", count(1, 100)),
            "file" => println!("file {:?}", data_file("Cargo.toml")),
            _ => {
                let _random = Random::new(35);
                panic!("a failure");
            }
        }
    }

    #[test]
    fn tests_do_as_their_environment_says() {
        if let Ok(what) = std::env::var(CHILD) {
            return do_as_child(&what);
        }
        let list = std::env::temp_dir().join(format!("icoray-skips-{}", std::process::id()));
        let required = "no Vulkan adapter: no driver, and ICORAY_REQUIRE has `gpu`";
        // What the child does, a variable of ours, whether it succeeds, and what it says.
        for (what, variable, value, succeeds, expected) in [
            ("skip", "ICORAY_SKIPPED", list.to_str().unwrap(), true, "skipped: no Vulkan adapter: no driver\n"),
            ("skip", "ICORAY_SKIPPED", list.to_str().unwrap(), true, "skipped: no Vulkan adapter: no driver\n"),
            ("skip", "ICORAY_REQUIRE", "mpi,data", true, "skipped: no Vulkan adapter: no driver\n"),
            ("skip", "ICORAY_REQUIRE", "mpi,gpu", false, required),
            ("skip", "ICORAY_REQUIRE", "all", false, required),
            ("skip", "ICORAY_REQUIRE", "vulkan", false, "ICORAY_REQUIRE: unknown name `vulkan`; known are "),
            ("tool", "ICORAY_TESTS", "", true, "skipped: no valgrind: `icoray-no-such-tool --version` fails\n"),
            ("tool", "ICORAY_TESTS", "", true, "there false"),
            ("count", "ICORAY_TESTS", "", true, "count 1\n"),
            ("count", "ICORAY_TESTS", "all", true, "count 100\n"),
            ("count", "ICORAY_TESTS", "long", false, "ICORAY_TESTS is \"long\""),
            ("file", "ICORAY_TEST_DATA", env!("CARGO_MANIFEST_DIR"), true, "Cargo.toml\")"),
            ("file", "ICORAY_TEST_DATA", "/nowhere", true, "skipped: no test data: /nowhere/Cargo.toml\nfile None\n"),
            ("failure", "ICORAY_TESTS", "", false, "random numbers of seed 35\n"),
        ] {
            let mut child = Command::new(std::env::current_exe().unwrap());
            for other in ["ICORAY_TESTS", "ICORAY_SKIPPED", "ICORAY_REQUIRE", "ICORAY_TEST_DATA"] {
                child.env_remove(other);
            }
            child.args(["--exact", "tests::tests_do_as_their_environment_says", "--nocapture"]).stdin(Stdio::null());
            let output = child.env(CHILD, what).env(variable, value).output().unwrap();
            let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
            assert_eq!(output.status.success(), succeeds, "{what} {variable}={value}: {said}");
            assert!(said.contains(expected), "{what} {variable}={value}: {said}");
        }
        let listed = std::fs::read_to_string(&list).unwrap();
        std::fs::remove_file(&list).unwrap();
        let lines: Vec<Vec<&str>> = listed.lines().map(|line| line.split('\t').collect()).collect();
        assert_eq!(lines.len(), 2, "{listed}");
        for line in lines {
            assert!(line[0].starts_with("icoray_test_support-"), "{listed}");
            assert_eq!(line[1..], ["tests::tests_do_as_their_environment_says", "no Vulkan adapter"]);
        }
    }
}
