//! `cargo xtask test`: the checks that a change must pass.

mod features;
mod programs;
mod python;
mod suite;
mod tally;
mod times;

use crate::book;
use crate::error::Error;
use crate::link;
use crate::requirements;
use crate::step::{Step, Steps, print_error, print_line};
use crate::system;
use crate::workspace::{Workspace, is_required};
use std::panic;
use std::process::ExitCode;
use std::thread::{self, ScopedJoinHandle};
use suite::Suite;
use tally::Tally;
use times::Times;

/// The runs that include a check.
#[derive(Clone, Copy, PartialEq)]
enum When {
    Always,
    WithAll,
}
use When::{Always, WithAll};

/// How a check is run, and counted at the end.
enum Run {
    /// It passes or fails as a whole.
    Whole(fn(&Suite, &mut Step) -> Result<(), Error>),
    /// The same, beside the check that follows it: either leaves processors idle.
    Beside(fn(&Workspace, &mut Step) -> Result<(), Error>),
    /// It counts its tests and those that it skips itself.
    Counted(fn(&Suite, &mut Step, &mut Record) -> Result<(), Error>),
}
use Run::{Beside, Counted, Whole};

/// What comes of a check that runs beside another, and its seconds.
type Aside = (Result<(), Error>, Step, f64);

/// The results of the checks that have run.
pub struct Record {
    tally: Tally,
    times: Times,
}

impl Record {
    /// The title of a check that has failed, which is counted and printed.
    fn failure(
        &mut self,
        title: &'static str,
        outcome: Result<(), Error>,
        failed_before: usize,
    ) -> Option<&'static str> {
        let error = outcome.err()?;
        // Tests that do not compile have none that failed.
        if self.tally.failed() == failed_before {
            self.tally.add_whole(false);
        }
        print_error(&error.to_string());
        Some(title)
    }

    /// Waits for a check that runs beside others; its title if it has failed.
    fn joined(
        &mut self,
        title: &'static str,
        work: ScopedJoinHandle<Aside>,
        steps: &mut Steps,
    ) -> Option<&'static str> {
        let (outcome, step, seconds) = work.join().unwrap_or_else(|panic| panic::resume_unwind(panic));
        steps.end(step, title, (outcome.is_ok(), seconds));
        let outcome = outcome.inspect(|()| self.tally.add_whole(true));
        self.failure(title, outcome, self.tally.failed())
    }
}

/// The titles of the checks, the runs that include them, and how they are run.
static CHECKS: &[(&str, When, Run)] = &[
    ("formatting", Always, Whole(|suite, step| step.quiet(suite.workspace.cargo(["fmt", "--all", "--check"])))),
    ("lints", Always, Whole(suite::lints)),
    ("tests", Always, Counted(suite::tests)),
    ("examples in the documentation", Always, Counted(suite::examples)),
    ("tests of the command over ranks", WithAll, Counted(suite::rank_tests)),
    ("features", WithAll, Whole(features::check)),
    ("install and link", WithAll, Beside(link::check)),
    ("Python package", WithAll, Counted(python::tests)),
    ("documentation", WithAll, Whole(suite::documentation)),
    ("crates as they are published", WithAll, Whole(suite::published)),
    ("links of the pages", Always, Whole(|suite, step| book::check_links(suite.workspace, step))),
    ("commands of the pages", Always, Counted(commands)),
    ("the book", WithAll, Counted(the_book)),
];

/// What `--all` adds to the default run.
const ADDED: &str = "GPU and MPI with their tests, pictures against references, valgrind, long counts of rays, \
                     damaged grids and frames, the Python package, each feature alone, documentation, programs linked \
                     with the installed library, slow commands of the pages, the book (about 30 minutes on 2 cores)";

/// Runs all checks, even if some fail, so that one run shows all faults. The last line is `N passed, N failed, N
/// skipped`; the exit code says whether all passed.
pub fn run(workspace: &Workspace, all: bool, only: &str, install: bool) -> Result<ExitCode, Error> {
    let checks: Vec<_> =
        CHECKS.iter().filter(|(title, when, _)| (all || *when == Always) && title.contains(only)).collect();
    if checks.is_empty() {
        return Err(Error::Failed(format!("no check has {only:?} in its title; they are: {}", titles(all))));
    }
    print_line(&if all { format!("--all adds {ADDED}") } else { format!("only with --all: {ADDED}") });
    let mut steps = Steps::new(checks.len() + 1);
    let mut record = Record { tally: Tally::default(), times: Times::read(workspace) };
    // A missing package ends the run here: nothing builds without it, and every step would print long errors.
    let reads_files = steps.run("looking for system packages", |step| {
        let needed = if all { requirements::FOR_TEST_ALL } else { requirements::FOR_TEST };
        system::provide(needed, install, step)?;
        let found = system::provide(requirements::FOR_FILES, install, step);
        if let Err(error) = &found {
            step.note(&format!("what reads files is left out: {}", error.brief()));
            record.tally.add_skipped("no NetCDF library", suite::READING_FILES.len());
        }
        Ok(found.is_ok())
    })?;
    let suite = Suite { workspace, all, reads_files };
    let mut failed = Vec::new();
    thread::scope(|scope| {
        let mut beside = None;
        for (title, _, run) in checks {
            let failed_before = record.tally.failed();
            let outcome = match run {
                Beside(run) => {
                    let mut step = steps.begin(title).stand_aside();
                    // A shell is one thread's.
                    let work = move || {
                        let outcome = Workspace::find().and_then(|workspace| run(&workspace, &mut step));
                        let seconds = step.seconds();
                        (outcome, step, seconds)
                    };
                    beside = Some((*title, scope.spawn(work)));
                    continue;
                }
                Counted(run) => steps.run(title, |step| run(&suite, step, &mut record)),
                Whole(run) => steps.run(title, |step| run(&suite, step).inspect(|()| record.tally.add_whole(true))),
            };
            failed.extend(record.failure(title, outcome, failed_before));
            if let Some((title, work)) = beside.take() {
                failed.extend(record.joined(title, work, &mut steps));
            }
        }
        if let Some((title, work)) = beside {
            failed.extend(record.joined(title, work, &mut steps));
        }
    });
    if !failed.is_empty() {
        print_error(&format!("steps that failed:\n  {}", failed.join("\n  ")));
    }
    for (title, seconds) in &steps.times {
        record.times.add(&format!("step: {title}"), *seconds);
    }
    record.times.write()?;
    print_line(&format!("\nlongest, of {} s:", steps.started.elapsed().as_secs()));
    record.times.lines().iter().chain(&record.tally.lines()).for_each(|line| print_line(line));
    Ok(if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The titles of the checks of a run.
fn titles(all: bool) -> String {
    let checks = CHECKS.iter().filter(|(_, when, _)| all || *when == Always);
    checks.map(|(title, ..)| *title).collect::<Vec<_>>().join(", ")
}

/// The commands of the pages: counted as one check, and each skipped block as one.
fn commands(suite: &Suite, step: &mut Step, record: &mut Record) -> Result<(), Error> {
    let skip = |need: &str, count: usize| record.tally.add_skipped(&format!("no {need}"), count);
    let took = |page: &str, seconds: f64| record.times.add(&format!("commands of {page}"), seconds);
    let outcome = book::run_commands(suite.workspace, step, suite.all, skip, took);
    record.tally.add_whole(outcome.is_ok());
    outcome
}

/// The book, where there is mdBook to build it.
fn the_book(suite: &Suite, step: &mut Step, record: &mut Record) -> Result<(), Error> {
    if !system::succeeds("mdbook", ["--version"]) {
        if is_required("mdbook") {
            return Err(Error::Failed("ICORAY_REQUIRE names mdbook, and the machine lacks it".into()));
        }
        record.tally.add_skipped("no mdbook", 1);
        return Ok(());
    }
    let outcome = book::build(suite.workspace, step);
    record.tally.add_whole(outcome.is_ok());
    outcome
}
