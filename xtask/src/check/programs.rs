//! Test programs: built by one cargo command, and run side by side, as many at a time as there are processors, but for one
//! that runs alone.
//!
//! `cargo test` runs one program after the other: processors idle while the last tests of a program run, or wait for
//! ranks, for a browser or for files.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use serde_json::Value;
use xshell::Cmd;

use super::Record;
use super::tally::results;
use crate::error::Error;
use crate::side_by_side::side_by_side;
use crate::step::{Step, lines_of, print_error};
use crate::workspace::{Workspace, library_path};

/// The program whose ranks of MPI wait by polling, as many as eight at a time: beside another program they take its
/// processors from it, and both last longer than one after the other.
const ALONE: &str = "icoray-tests ranks";

/// The programs that take longest, in this order: they start first, so that none of them runs alone at the end.
const LONGEST: [&str; 7] = [
    "icoray-gpu suite",
    "icoray-tests accuracy",
    "icoray-tests interface",
    "icoray ranks",
    "icoray suite",
    "icoray-tests models",
    "icoray-cli browser",
];

/// A test program that cargo has built.
#[derive(Debug, Clone, PartialEq)]
struct Program {
    /// The names of the package and of the target, such as `icoray suite`.
    name: String,
    file: PathBuf,
    /// The package's directory, in which cargo would run the program.
    directory: PathBuf,
}

/// How test programs are run.
pub struct Run<'a> {
    pub variables: Vec<(&'a str, OsString)>,
    /// Part of the names of the tests to run; all if it is empty.
    pub filter: &'a str,
}

/// Builds the test programs of a `cargo test` command and runs them. Prints a line for each, and all that one printed if
/// it fails.
pub fn run<'a>(
    workspace: &Workspace,
    cargo: impl Fn() -> Cmd<'a>,
    run: &Run,
    step: &mut Step,
    record: &mut Record,
) -> Result<(), Error> {
    let started = Instant::now();
    step.quiet(cargo().arg("--no-run"))?;
    let messages = cargo().args(["--no-run", "--message-format=json"]).quiet().ignore_stderr().read()?;
    step.note(&format!("  built, {:.1} s", started.elapsed().as_secs_f64()));
    let mut programs = listed(&messages);
    let rank = |name: &str| LONGEST.iter().position(|long| *long == name).unwrap_or(LONGEST.len());
    programs.sort_by_key(|program| rank(&program.name));
    // As cargo sets it.
    let products = workspace.products("dev");
    let libraries = library_path([products.join("deps"), products])?;
    let work = |program: Program| {
        let mut command = Command::new(&program.file);
        command.current_dir(&program.directory).env("CARGO_MANIFEST_DIR", &program.directory);
        command.env("LD_LIBRARY_PATH", &libraries).envs(run.variables.iter().cloned());
        command.args(Some(run.filter).filter(|filter| !filter.is_empty()));
        let started = Instant::now();
        let (lines, outcome) = lines_of(command, |_| {});
        (program.name, started.elapsed().as_secs_f64(), lines.join("\n"), outcome)
    };
    let (mut failed, mut count) = (Vec::new(), 0);
    let (alone, programs): (Vec<_>, Vec<_>) = programs.into_iter().partition(|program| program.name == ALONE);
    let mut take = |(name, seconds, output, outcome): (String, f64, String, Result<(), String>)| {
        let [passed, failures, _] = results(&output);
        record.tally.add_tests(&output, outcome.is_ok());
        count += passed + failures;
        step.note(&format!("  {name}: {passed} passed, {failures} failed, {seconds:.1} s"));
        record.times.push((name.clone(), seconds));
        if let Err(sentence) = outcome {
            print_error(&format!("{output}\n{sentence}"));
            failed.push(name);
        }
    };
    alone.into_iter().for_each(|program| take(work(program)));
    side_by_side(programs, work, take);
    if !failed.is_empty() {
        return Err(Error(format!("tests failed: {}", failed.join(", "))));
    }
    // Messages that cannot be read, or a filter that fits no test, would pass otherwise.
    if count == 0 { Err(Error("no test was run".into())) } else { Ok(()) }
}

/// The test programs in the messages of cargo, a JSON object in each line.
fn listed(messages: &str) -> Vec<Program> {
    let program = |line: &str| {
        let message: Value = serde_json::from_str(line).ok()?;
        let directory = Path::new(message["manifest_path"].as_str()?).parent()?;
        let file = message["executable"].as_str().filter(|_| message["profile"]["test"] == true)?;
        // `path+file:///DIRECTORY#NAME@VERSION`, without NAME where the directory has the package's name.
        let (place, rest) = message["package_id"].as_str()?.rsplit_once('#')?;
        let package = rest.split_once('@').map_or(place.rsplit('/').next()?, |(name, _)| name);
        let name = format!("{package} {}", message["target"]["name"].as_str()?);
        Some(Program { name, file: file.into(), directory: directory.to_path_buf() })
    };
    messages.lines().filter_map(program).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_are_named_by_package_and_target() {
        let artifact = |id: &str, target: &str, executable: &str, is_test: bool| {
            format!(
                r#"{{"reason":"compiler-artifact","package_id":"path+file:///w/{id}","manifest_path":"/w/x/Cargo.toml",
                "target":{{"name":"{target}"}},"profile":{{"test":{is_test}}},"executable":{executable}}}"#
            )
            .replace('\n', "")
        };
        let messages = [
            artifact("crates/icoray#0.1.0", "suite", "\"/t/suite-1\"", true),
            artifact("tests#icoray-tests@0.1.0", "ranks", "\"/t/ranks-2\"", true),
            artifact("crates/icoray-cli#0.1.0", "icoray", "\"/t/icoray\"", false),
            artifact("crates/icoray#0.1.0", "icoray", "null", true),
            r#"{"reason":"build-finished","success":true}"#.into(),
        ];
        let program =
            |name: &str, file: &str| Program { name: name.into(), file: file.into(), directory: "/w/x".into() };
        let expected = [program("icoray suite", "/t/suite-1"), program("icoray-tests ranks", "/t/ranks-2")];
        assert_eq!(listed(&messages.join("\n")), expected);
    }
}
