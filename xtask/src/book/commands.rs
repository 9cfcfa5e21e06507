//! Runs the commands of the README and the book, from the text of their `sh` blocks.
//!
//! The blocks of a page are one script of bash, in a folder of its own, which [`PRELUDE`] fills. The folder is inside
//! the workspace, so that cargo finds the workspace and its builds from there. Pages run side by side, but for those
//! that install the library: these run one after the other. Words behind `sh` say when a block is run: `slow` in the
//! long run only, `needs=a,b` where the machine has a and b.

use std::collections::BTreeMap;
use std::process::Command;
use std::time::Instant;

use icoray_test_support::mpi_variables;

use super::markdown::{Fence, Page};
use crate::check::{Record, Suite};
use crate::error::Error;
use crate::requirements;
use crate::side_by_side::side_by_side;
use crate::step::{Step, lines_of};
use crate::workspace::{Workspace, may_lack};

/// Names behind `needs=`, and the Debian packages that they stand for. `data` is the data files and what reads them.
const NEEDS: [(&str, &[&str]); 5] = [
    ("data", &["g++", "libnetcdf-dev", "pkg-config"]),
    ("fortran", &["gfortran"]),
    ("gpu", &["mesa-vulkan-drivers"]),
    ("mpi", &["libopenmpi-dev", "openmpi-bin", "libclang-dev"]),
    ("pkg-config", &["pkg-config"]),
];

/// The data file that `FILE.nc` in a page stands for.
const FILE: &str = "mpas_jw_10242.nc";

/// The word of blocks that are run in the long run only.
const SLOW: &str = "slow";

/// Command of pages that build and install the library.
const INSTALLING: &str = "cargo xtask install";

/// The start of the command by which a block writes its own data file.
const SAMPLING: &str = "icoray sample ";

/// The parent of the folders of pages, below the workspace's root.
const PLACE: &str = "out/docs";

/// The script of a page, in the page's folder.
const SCRIPT: &str = "commands.sh";

/// The start of every script.
const PRELUDE: &str = include_str!("prelude.sh");

/// The command that runs a script as those of pages, in a new folder of this name, with the programs of a profile.
pub fn scripted(workspace: &Workspace, name: &str, profile: &str, script: &str) -> Result<Command, Error> {
    let sh = &workspace.shell;
    let folder = workspace.root.join(PLACE).join(name);
    sh.remove_path(&folder)?;
    sh.write_file(folder.join(SCRIPT), format!("{PRELUDE}{script}"))?;
    let command = sh.cmd("bash").arg(SCRIPT).env("ROOT", &workspace.root).env("DATA", workspace.data());
    let command = command.env("PROGRAMS", workspace.products(profile)).env("FILE", FILE).envs(mpi_variables(&folder));
    let mut command = Command::from(command);
    command.current_dir(folder);
    Ok(command)
}

/// A fault of the words behind `sh`: an unknown word, or a missing word that the commands need.
pub fn attribute_fault(fence: &Fence) -> Option<String> {
    let fault = |word: &String| match word.split_once('=') {
        None if word == SLOW => None,
        Some(("needs", list)) => {
            let known = NEEDS.map(|(name, _)| name);
            let unknown = list.split(',').find(|need| !known.contains(need))?;
            Some(format!("needs={unknown}, expected one of {}", known.join(", ")))
        }
        _ => Some(format!("{word}, expected slow or needs=...")),
    };
    let unknown = fence.attributes.iter().find_map(fault);
    let is_slow = || fence.attributes.iter().any(|word| word == SLOW);
    let missing = if fence.text.contains("cargo ") && !is_slow() {
        Some("it calls cargo, which may build for minutes; expected ```sh slow")
    } else if fence.text.contains(".nc ")
        && !fence.text.contains(SAMPLING)
        && !needs_of(fence).any(|need| need == "data")
    {
        Some("it reads a data file; expected ```sh needs=data")
    } else {
        None
    };
    unknown.or_else(|| missing.map(str::to_owned))
}

/// Runs the commands: all of them, or those that are not marked as slow. Counts them as one check, and each block whose
/// needs are not met as skipped; keeps the seconds of each page. Fails with the failures of all pages.
pub fn run(suite: &Suite, step: &mut Step, record: &mut Record) -> Result<(), Error> {
    let workspace = suite.workspace;
    let mut counts = BlockCounts::default();
    let mut scripts = Vec::new();
    for page in &super::book(&workspace.root)? {
        scripts.extend(script(page, &mut counts, suite.all, |need| is_met(workspace, need)));
    }
    counts.lacking.keys().try_for_each(|need| may_lack(need))?;
    counts.lacking.iter().for_each(|(need, count)| record.tally.add_skipped(&format!("no {need}"), *count));
    // The tests, which run before, have built the command; another selection of features would compile it again.
    for (program, package) in [("icoray", "icoray-cli"), ("icoray-study", "icoray-study")] {
        let is_used = scripts.iter().any(|(_, script)| script.contains(&format!("{program} ")));
        if is_used && !workspace.products("dev").join(program).is_file() {
            step.quiet(workspace.cargo(["build", "--package", package, "--no-default-features"]))?;
        }
    }
    // Those that install come first, as they take longest: each builds other libraries in the same place.
    let mut turns = vec![Vec::new()];
    for (path, script) in scripts {
        let name = path.trim_end_matches(".md").rsplit('/').next().unwrap_or(&path);
        let page = (scripted(workspace, name, "dev", &script)?, path);
        if script.contains(INSTALLING) { turns[0].push(page) } else { turns.push(vec![page]) }
    }
    let run = |(command, path): (Command, String)| {
        let started = Instant::now();
        let (lines, outcome) = lines_of(command, |_| {});
        let seconds = started.elapsed().as_secs_f64();
        // A run that is cut off shows which pages had ended.
        step.note(&format!("{path} {seconds:.1} s"));
        (path, seconds, outcome.map_err(Error::with(&lines)))
    };
    let mut failures = Vec::new();
    let work = |pages: Vec<_>| pages.into_iter().map(run).collect::<Vec<_>>();
    side_by_side(turns, work, |ended| {
        for (path, seconds, outcome) in ended {
            record.times.push((format!("commands of {path}"), seconds));
            failures.extend(outcome.err().map(|failure| format!("{path}: {failure}")));
        }
    });
    step.note(&counts.summary());
    record.tally.add_whole(failures.is_empty());
    if failures.is_empty() { Ok(()) } else { Err(Error(failures.join("\n"))) }
}

/// Whether the machine has what a need stands for.
fn is_met(workspace: &Workspace, need: &str) -> bool {
    let has_file = need != "data" || workspace.data().join(FILE).is_file();
    has_file && NEEDS.iter().any(|(name, packages)| *name == need && requirements::has(packages))
}

/// Numbers of blocks that are run, and of those that are not.
#[derive(Default)]
struct BlockCounts {
    run: usize,
    slow: usize,
    lacking: BTreeMap<String, usize>,
}

impl BlockCounts {
    fn summary(&self) -> String {
        let skipped: usize = self.lacking.values().sum();
        let lacking = self.lacking.iter().map(|(need, count)| format!(", {count} without {need}")).collect::<String>();
        let slow = if self.slow > 0 { format!("; {} more with --all", self.slow) } else { String::new() };
        format!("{} blocks of commands run, {skipped} skipped{lacking}{slow}", self.run)
    }
}

/// The script of a page's blocks, with the page's path; `None` where there is nothing to run.
fn script(page: &Page, counts: &mut BlockCounts, all: bool, has: impl Fn(&str) -> bool) -> Option<(String, String)> {
    let mut script = String::new();
    for fence in page.fences.iter().filter(|fence| fence.language == "sh") {
        if !all && fence.attributes.iter().any(|word| word == SLOW) {
            counts.slow += 1;
        } else if let Some(lacking) = needs_of(fence).find(|need| !has(need)) {
            *counts.lacking.entry(lacking.to_owned()).or_default() += 1;
        } else {
            counts.run += 1;
            script += &format!("block={}:{}\n{}", page.path, fence.line, fence.text);
        }
    }
    (!script.is_empty()).then(|| (page.path.clone(), script))
}

fn needs_of(fence: &Fence) -> impl Iterator<Item = &str> {
    let lists = fence.attributes.iter().filter_map(|word| word.strip_prefix("needs="));
    lists.flat_map(|list| list.split(','))
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str =
        "```sh\necho 1\n```\n```text\nrm -r /\n```\n```sh slow\necho 2\n```\n```sh needs=mpi\necho 3\n```\n";

    fn written(all: bool, has: bool) -> (String, String) {
        let mut counts = BlockCounts::default();
        let script = script(&Page::parse("p.md", PAGE), &mut counts, all, |_| has);
        (script.unwrap().1, counts.summary())
    }

    #[test]
    fn blocks_run_in_order_if_their_requirements_are_met() {
        let (script, summary) = written(true, true);
        assert_eq!(script, "block=p.md:1\necho 1\nblock=p.md:7\necho 2\nblock=p.md:10\necho 3\n");
        assert_eq!(summary, "3 blocks of commands run, 0 skipped");
        let (script, summary) = written(false, false);
        assert_eq!(script, "block=p.md:1\necho 1\n");
        assert_eq!(summary, "1 blocks of commands run, 1 skipped, 1 without mpi; 1 more with --all");
    }

    #[test]
    fn a_failing_command_is_named_by_its_block() {
        let workspace = Workspace::find().unwrap();
        let script =
            "block=p.md:7\n[ -d examples ] && [ \"$HOME\" = \"$PWD/.home\" ]\nfalse | true\necho not reached\n";
        let output = scripted(&workspace, "a failing command", "dev", script).unwrap().output().unwrap();
        assert!(!output.status.success() && output.stdout.is_empty(), "{output:?}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("p.md:7"), "{output:?}");
    }
}
