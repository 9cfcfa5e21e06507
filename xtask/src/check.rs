//! `cargo xtask test`: everything that must hold before a change goes in.

mod suite;
mod tally;

use crate::book;
use crate::error::Error;
use crate::link;
use crate::options::TestOptions;
use crate::requirements;
use crate::step::{Step, Steps, complain, say};
use crate::system;
use crate::workspace::Workspace;
use std::process::ExitCode;
use suite::Suite;
use tally::Tally;

/// Something to check.
struct Check {
    title: &'static str,
    when: When,
    run: Run,
}

/// Which runs have a check.
#[derive(Clone, Copy, PartialEq)]
enum When {
    Always,
    /// Without `--all`, which has a larger one in its place.
    ByDefault,
    WithAll,
}

/// How a check is run, and counted at the end.
enum Run {
    /// It passes or fails as a whole.
    Whole(fn(&Workspace, &mut Step) -> Result<(), Error>),
    /// The same with packages that depend on what the machine has.
    Packages(fn(&Suite, &mut Step) -> Result<(), Error>),
    /// It runs tests or commands, and counts them, or those that it skips, itself.
    Tests(fn(&Suite, &mut Step, &mut Tally) -> Result<(), Error>),
}

static CHECKS: &[Check] = &[
    Check { title: "formatting", when: When::Always, run: Run::Whole(formatting) },
    Check { title: "lints", when: When::ByDefault, run: Run::Packages(suite::default_lints) },
    Check { title: "tests", when: When::ByDefault, run: Run::Tests(suite::default_tests) },
    Check { title: "lints, all packages", when: When::WithAll, run: Run::Packages(suite::all_lints) },
    Check { title: "tests, all packages", when: When::WithAll, run: Run::Tests(suite::all_tests) },
    Check {
        title: "tests of the command over ranks",
        when: When::WithAll,
        run: Run::Tests(suite::rank_tests),
    },
    Check { title: "documentation", when: When::WithAll, run: Run::Packages(suite::documentation) },
    Check { title: "install and link", when: When::WithAll, run: Run::Whole(link::check) },
    Check { title: "links of the pages", when: When::Always, run: Run::Whole(book::check_links) },
    Check {
        title: "commands of the pages",
        when: When::ByDefault,
        run: Run::Tests(|suite, step, tally| commands(suite, step, tally, false)),
    },
    Check {
        title: "all commands of the pages",
        when: When::WithAll,
        run: Run::Tests(|suite, step, tally| commands(suite, step, tally, true)),
    },
    Check { title: "the book", when: When::WithAll, run: Run::Whole(book::build) },
];

/// What `--all` adds to the default run.
const ADDED: &str = "GPU and MPI with their tests, valgrind, long counts of rays, damaged grids and frames, \
                     documentation, programs linked with the installed library, slow commands of the pages, the book";

/// Runs the checks, all of them even if some fail: one run is to show everything that is wrong. The last line is
/// `N passed, N failed, N skipped`; the exit code says whether all passed.
pub fn run(workspace: &Workspace, options: &TestOptions) -> Result<ExitCode, Error> {
    let other = if options.all { When::ByDefault } else { When::WithAll };
    let checks: Vec<_> = CHECKS.iter().filter(|check| check.when != other).collect();
    say(&if options.all { format!("--all adds {ADDED}") } else { format!("only with --all: {ADDED}") });
    let mut steps = Steps::new(checks.len() + 1);
    let mut tally = Tally::default();
    // Without its packages nothing builds, and each of the steps would say so at length.
    let reads_files = steps.run("looking for system packages", |step| {
        if options.all {
            return system::provide(requirements::FOR_TEST_ALL, options.install, step).map(|()| true);
        }
        system::provide(requirements::FOR_TEST, options.install, step)?;
        let found = system::provide(requirements::FOR_FILES, options.install, step);
        if let Err(error) = &found {
            step.note(&format!("what reads files is left out: {}", error.brief()));
            tally.add_skipped("no NetCDF library", suite::READING_FILES.len());
        }
        Ok(found.is_ok())
    })?;
    let suite = Suite { workspace, reads_files };
    let mut failed = Vec::new();
    for check in checks {
        let outcome = steps.run(check.title, |step| check.run(&suite, step, &mut tally));
        if let Err(error) = outcome {
            complain(&error.to_string());
            failed.push(check.title);
        }
    }
    if !failed.is_empty() {
        complain(&format!("steps that failed:\n  {}", failed.join("\n  ")));
    }
    say(&format!("took {:.0} s", steps.seconds()));
    tally.lines().iter().for_each(|line| say(line));
    Ok(if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl Check {
    fn run(&self, suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
        let outcome = match self.run {
            Run::Tests(run) => return run(suite, step, tally),
            Run::Packages(run) => run(suite, step),
            Run::Whole(run) => run(suite.workspace, step),
        };
        tally.add_whole(outcome.is_ok());
        outcome
    }
}

/// The commands of the pages: one check, but for the blocks that are skipped.
fn commands(suite: &Suite, step: &mut Step, tally: &mut Tally, all: bool) -> Result<(), Error> {
    let skip = |need: &str, count: usize| tally.add_skipped(&format!("no {need}"), count);
    let outcome = book::run_commands(suite.workspace, step, all, skip);
    tally.add_whole(outcome.is_ok());
    outcome
}

fn formatting(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    step.quiet(&mut workspace.cargo(["fmt", "--all", "--check"]))
}
