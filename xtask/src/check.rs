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
    /// It counts its tests and those that it skips itself.
    Counted(fn(&Suite, &mut Step, &mut Record) -> Result<(), Error>),
    /// The same, beside the checks that follow it, as it leaves processors idle.
    Beside(&'static Run),
    /// The same, once those that run beside others have ended.
    Alone(&'static Run),
}
use Run::{Alone, Beside, Counted, Whole};

impl Run {
    fn run(&self, suite: &Suite, step: &mut Step, record: &mut Record) -> Result<(), Error> {
        match self {
            Whole(run) => run(suite, step).inspect(|()| record.tally.add_whole(true)),
            Counted(run) => run(suite, step, record),
            Beside(run) | Alone(run) => run.run(suite, step, record),
        }
    }
}

/// The results of the checks that have run.
#[derive(Default)]
pub struct Record {
    tally: Tally,
    times: Times,
    /// The titles of those that failed.
    failed: Vec<&'static str>,
}

impl Record {
    /// Prints and counts the failure of a check, before which `failed_before` tests had failed.
    fn end(&mut self, title: &'static str, outcome: Result<(), Error>, failed_before: usize) {
        let Err(error) = outcome else { return };
        // Tests that do not compile have none that failed.
        if self.tally.failed() == failed_before {
            self.tally.add_whole(false);
        }
        print_error(&error.to_string());
        self.failed.push(title);
    }

    /// Adds the results of a check that ran beside others.
    fn join(&mut self, title: &'static str, ended: Ended, steps: &mut Steps) {
        let Ended { mut record, outcome, step, seconds } = ended;
        steps.end(step, title, (outcome.is_ok(), seconds));
        record.end(title, outcome, 0);
        self.tally.add(&record.tally);
        self.times.join(record.times);
        self.failed.extend(record.failed);
    }
}

/// A check that ran beside others.
struct Ended {
    record: Record,
    outcome: Result<(), Error>,
    step: Step,
    seconds: f64,
}

/// The title of a check, the runs that include it, and how it is run.
type Check = (&'static str, When, Run);

/// All checks, in the order in which they begin.
static CHECKS: &[Check] = &[
    ("formatting", Always, Whole(|suite, step| step.quiet(suite.workspace.cargo(["fmt", "--all", "--check"])))),
    ("lints", Always, Whole(suite::lints)),
    ("tests", Always, Counted(suite::tests)),
    // Its link takes minutes on one processor.
    ("install and link", WithAll, Beside(&Whole(|suite, step| link::check(suite.workspace, step)))),
    ("examples in the documentation", Always, Counted(suite::examples)),
    ("tests of the command over ranks", WithAll, Counted(suite::rank_tests)),
    // After the command is built for the last time, which it uses.
    ("Python package", WithAll, Beside(&Counted(python::tests))),
    ("features", WithAll, Whole(features::check)),
    ("documentation", Always, Whole(suite::documentation)),
    ("crates as they are published", WithAll, Whole(suite::published)),
    ("links of the pages", Always, Whole(|suite, step| book::check_links(suite.workspace, step))),
    // They install the library, too.
    ("commands of the pages", Always, Alone(&Counted(commands))),
    ("the book", WithAll, Counted(the_book)),
];

/// What `--all` adds to the default run.
const ADDED: &str = "GPU and MPI with their tests, pictures against references, valgrind, long counts of rays, \
                     damaged grids and frames, the Python package, each feature alone, programs linked with the \
                     installed library, slow commands of the pages, the book (about 30 minutes on 2 cores)";

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
    let mut record = Record { times: Times::read(workspace), ..Record::default() };
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
    run_checks(&checks, &Suite { workspace, all, reads_files }, &mut steps, &mut record);
    let failed = &record.failed;
    if !failed.is_empty() {
        print_error(&format!("steps that failed:\n  {}", failed.join("\n  ")));
    }
    for (title, seconds) in &steps.times {
        record.times.add(&format!("step: {title}"), *seconds);
    }
    record.times.write()?;
    print_line(&format!("\nlongest, of {} s:", steps.started.elapsed().as_secs()));
    record.times.lines().iter().chain(&record.tally.lines()).for_each(|line| print_line(line));
    Ok(if record.failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs the checks in their order; those that run beside others are waited for at the end.
fn run_checks(checks: &[&Check], suite: &Suite, steps: &mut Steps, record: &mut Record) {
    let &Suite { all, reads_files, .. } = suite;
    thread::scope(|scope| {
        let mut beside = Vec::new();
        for (title, _, run) in checks {
            if let Beside(_) = run {
                let mut step = steps.begin(title).stand_aside();
                let work = move || {
                    let mut record = Record::default();
                    // A shell is one thread's.
                    let outcome = Workspace::find().and_then(|workspace| {
                        run.run(&Suite { workspace: &workspace, all, reads_files }, &mut step, &mut record)
                    });
                    let seconds = step.seconds();
                    Ended { record, outcome, step, seconds }
                };
                beside.push((*title, scope.spawn(work)));
                continue;
            }
            let is_alone = matches!(run, Alone(_));
            for (title, work) in beside.extract_if(.., |(_, work)| is_alone || work.is_finished()) {
                record.join(title, ended(work), steps);
            }
            let failed_before = record.tally.failed();
            let outcome = steps.run(title, |step| run.run(suite, step, record));
            record.end(title, outcome, failed_before);
        }
        for (title, work) in beside {
            record.join(title, ended(work), steps);
        }
    });
}

/// Waits for a check that runs beside others.
fn ended(work: ScopedJoinHandle<Ended>) -> Ended {
    work.join().unwrap_or_else(|panic| panic::resume_unwind(panic))
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;

    #[test]
    fn a_check_runs_beside_those_that_follow_and_is_counted() {
        static BOTH: Barrier = Barrier::new(2);
        fn aside(_: &Suite, _: &mut Step, record: &mut Record) -> Result<(), Error> {
            BOTH.wait();
            record.tally.add_skipped("no data", 2);
            record.times.add("aside", 7.0);
            Err(Error::Failed("aside".into()))
        }
        let meets = |_: &Suite, _: &mut Step| {
            BOTH.wait();
            Ok(())
        };
        fn alone(_: &Suite, _: &mut Step, record: &mut Record) -> Result<(), Error> {
            assert_eq!(record.failed, ["beside"]);
            Ok(())
        }
        let checks: [Check; 4] = [
            ("beside", Always, Beside(&Counted(aside))),
            ("first", Always, Whole(|_, _| Ok(()))),
            ("second", Always, Whole(meets)),
            ("alone", Always, Alone(&Counted(alone))),
        ];
        let workspace = Workspace::find().unwrap();
        let suite = Suite { workspace: &workspace, all: false, reads_files: false };
        let (mut steps, mut record) = (Steps::new(4), Record::default());
        run_checks(&checks.each_ref(), &suite, &mut steps, &mut record);
        assert_eq!(record.failed, ["beside"]);
        assert_eq!(record.tally.lines(), ["2 skipped: no data", "2 passed, 1 failed, 2 skipped"]);
        assert_eq!(record.times.lines(), ["    7.0 s  aside"]);
        assert_eq!(steps.times.len(), 4);
    }
}
