//! `cargo xtask test`: the checks that a change must pass.

mod features;
mod programs;
mod python;
mod suite;
mod tally;

use crate::error::Error;
use crate::step::{Step, Steps, print_error, print_line};
use crate::workspace::{Workspace, may_lack};
use crate::{book, link, requirements, system};
use std::panic;
use std::process::ExitCode;
use std::thread::{self, ScopedJoinHandle};
pub use suite::Suite;
use tally::Tally;

/// The runs that include a check.
#[derive(Clone, Copy, PartialEq)]
enum When {
    Always,
    WithAll,
}
use When::{Always, WithAll};

/// When a check is run, seen from the others.
#[derive(Clone, Copy, PartialEq)]
enum Turn {
    Ordered,
    /// Beside the checks that follow it, as it leaves processors idle.
    Beside,
    /// The same, once those that began beside others before it have ended.
    BesideNext,
}
use Turn::{Beside, BesideNext, Ordered};

#[derive(Default)]
pub struct Record {
    pub tally: Tally,
    /// The seconds of parts, such as test programs.
    pub times: Vec<(String, f64)>,
    failed: Vec<&'static str>,
}

impl Record {
    /// Ends a check's step, prints its error, and adds its results.
    fn end(&mut self, ended: Ended, steps: &mut Steps) {
        let Ended { title, mut record, outcome, step, seconds } = ended;
        steps.end(step, title, outcome.is_ok(), seconds);
        // One that counts nothing is one test, as are tests that do not compile.
        if if outcome.is_ok() { record.tally == Tally::default() } else { record.tally.failed() == 0 } {
            record.tally.add_whole(outcome.is_ok());
        }
        if let Err(error) = outcome {
            print_error(&error.to_string());
            self.failed.push(title);
        }
        self.tally.add(&record.tally);
        self.times.extend(record.times);
    }
}

struct Check {
    title: &'static str,
    when: When,
    turn: Turn,
    run: Run,
}

type Run = fn(&Suite, &mut Step, &mut Record) -> Result<(), Error>;

const fn check(title: &'static str, when: When, turn: Turn, run: Run) -> Check {
    Check { title, when, turn, run }
}

struct Ended {
    title: &'static str,
    record: Record,
    outcome: Result<(), Error>,
    step: Step,
    seconds: f64,
}

impl Ended {
    fn of(&Check { title, run, .. }: &Check, suite: &Suite, mut step: Step) -> Self {
        let mut record = Record::default();
        let outcome = run(suite, &mut step, &mut record);
        let seconds = step.seconds();
        Self { title, record, outcome, step, seconds }
    }
}

static CHECKS: &[Check] = &[
    check("formatting", Always, Ordered, |suite, step, _| {
        step.quiet(suite.workspace.cargo(["fmt", "--all", "--check"]))
    }),
    check("lints", Always, Ordered, |suite, step, _| suite::lints(suite, step)),
    check("tests", Always, Ordered, suite::tests),
    // Its link takes minutes on one processor.
    check("install and link", WithAll, Beside, |suite, step, record| link::check(suite.workspace, step, record)),
    // Cargo compiles those of one package after the other.
    check("examples in the documentation", Always, Beside, suite::examples),
    check("tests of the command over ranks", WithAll, Ordered, suite::rank_tests),
    check("documentation", Always, Ordered, |suite, step, _| suite::documentation(suite, step)),
    // After the command is built for the last time, which it uses.
    check("Python package", WithAll, Beside, python::tests),
    // They install the library, too. Its links leave processors to what follows.
    check("commands of the pages", Always, BesideNext, book::run_commands),
    check("features", WithAll, Ordered, |suite, step, _| features::check(suite, step)),
    check("crates as they are published", WithAll, Ordered, |suite, step, _| suite::published(suite, step)),
    check("links of the pages", Always, Ordered, |suite, step, _| book::check_links(suite.workspace, step)),
    check("the book", WithAll, Ordered, the_book),
];

/// Checks that `--all` adds to the default run.
const ADDED: &str = "GPU and MPI with their tests, pictures against references, valgrind, long counts of rays, \
                     damaged grids and frames, the Python package, each feature alone, programs linked with the \
                     installed library, slow commands of the pages, the book (about 30 minutes on 2 cores)";

/// Number of parts whose seconds are printed.
const LISTED: usize = 12;

/// Runs all checks, even if some fail, so that one run shows all faults. The last line is `N passed, N failed, N
/// skipped`; the exit code says whether all passed.
pub fn run(workspace: &Workspace, all: bool, only: &str, install: bool) -> Result<ExitCode, Error> {
    let mut checks: Vec<_> = CHECKS.iter().filter(|check| all || check.when == Always).collect();
    let titles = checks.iter().map(|check| check.title).collect::<Vec<_>>().join(", ");
    checks.retain(|check| check.title.contains(only));
    if checks.is_empty() {
        return Err(Error(format!("no check has {only:?} in its title; they are: {titles}")));
    }
    print_line(&if all { format!("--all adds {ADDED}") } else { format!("only with --all: {ADDED}") });
    let mut steps = Steps::new(checks.len() + 1);
    let mut record = Record::default();
    // A missing package ends the run here: nothing builds without it, and every step would print long errors.
    let reads_files = steps.run("looking for system packages", |step| {
        let needed = if all { requirements::FOR_TEST_ALL } else { requirements::FOR_C };
        system::provide(needed, install, step)?;
        let found = system::provide(requirements::FOR_FILES, install, step);
        if let Err(error) = &found {
            step.note(&format!("what reads files is left out: {}", error.brief()));
            record.tally.add_skipped("no NetCDF library", suite::READING_FILES.len());
        }
        Ok(found.is_ok())
    })?;
    run_checks(&checks, &Suite { workspace, all, reads_files }, &mut steps, &mut record)?;
    let Record { tally, mut times, failed } = record;
    if !failed.is_empty() {
        print_error(&format!("steps that failed:\n  {}", failed.join("\n  ")));
    }
    times.extend(steps.times.iter().map(|(title, seconds)| (format!("step: {title}"), *seconds)));
    print_line(&format!("\nlongest, of {} s:", steps.started.elapsed().as_secs()));
    times.sort_by(|(_, one), (_, other)| other.total_cmp(one));
    times.iter().take(LISTED).for_each(|(what, seconds)| print_line(&format!("{seconds:7.1} s  {what}")));
    tally.lines().iter().for_each(|line| print_line(line));
    Ok(if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs the checks in their order; those that run beside others are waited for at the end.
fn run_checks(checks: &[&Check], suite: &Suite, steps: &mut Steps, record: &mut Record) -> Result<(), Error> {
    let &Suite { all, reads_files, .. } = suite;
    let joined = |work: ScopedJoinHandle<_>| work.join().unwrap_or_else(|panic| panic::resume_unwind(panic));
    thread::scope(|scope| {
        let mut beside: Vec<ScopedJoinHandle<Ended>> = Vec::new();
        for &check in checks {
            let &Check { title, turn, .. } = check;
            for work in beside.extract_if(.., |work| turn == BesideNext || work.is_finished()) {
                record.end(joined(work), steps);
            }
            if turn != Ordered {
                // A shell is one thread's.
                let (workspace, step) = (Workspace::find()?, steps.beside(title));
                let work = move || Ended::of(check, &Suite { workspace: &workspace, all, reads_files }, step);
                beside.push(scope.spawn(work));
                continue;
            }
            let step = steps.begin(title);
            record.end(Ended::of(check, suite, step), steps);
        }
        beside.into_iter().for_each(|work| record.end(joined(work), steps));
        Ok(())
    })
}

/// The book, where there is mdBook to build it.
fn the_book(suite: &Suite, step: &mut Step, record: &mut Record) -> Result<(), Error> {
    if !has_program("mdbook", record)? {
        return Ok(());
    }
    step.quiet(suite.workspace.shell.cmd("bash").arg("docs/build.sh"))
}

/// Whether the machine has a program. If not, counts a skipped test; fails if `ICORAY_REQUIRE` names it.
pub fn has_program(name: &str, record: &mut Record) -> Result<bool, Error> {
    if system::output(name, ["--version"]).is_some() {
        return Ok(true);
    }
    may_lack(name)?;
    record.tally.add_skipped(&format!("no {name}"), 1);
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;
    use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

    #[test]
    fn a_check_runs_beside_those_that_follow_and_is_counted() {
        static ASIDE: Barrier = Barrier::new(2);
        static NEXT: Barrier = Barrier::new(2);
        static HAS_NEXT_BEGUN: AtomicBool = AtomicBool::new(false);
        fn has_next_begun() -> bool {
            thread::yield_now();
            HAS_NEXT_BEGUN.load(Relaxed)
        }
        let checks: [Check; 5] = [
            check("beside", Always, Beside, |_, _, record| {
                ASIDE.wait();
                record.tally.add_skipped("no data", 2);
                record.times.push(("aside".into(), 7.0));
                // So often that another thread has begun meanwhile.
                assert!(!(0..1_000).any(|_| has_next_begun()), "a check began too early");
                Err(Error("aside".into()))
            }),
            check("first", Always, Ordered, |_, _, _| Ok(())),
            check("second", Always, Ordered, |_, _, _| {
                ASIDE.wait();
                Ok(())
            }),
            check("next", Always, BesideNext, |_, _, _| {
                HAS_NEXT_BEGUN.store(true, Relaxed);
                NEXT.wait();
                Ok(())
            }),
            check("last", Always, Ordered, |_, _, _| {
                NEXT.wait();
                Ok(())
            }),
        ];
        let workspace = Workspace::find().unwrap();
        let suite = Suite { workspace: &workspace, all: false, reads_files: false };
        let (mut steps, mut record) = (Steps::new(5), Record::default());
        run_checks(&checks.each_ref(), &suite, &mut steps, &mut record).unwrap();
        assert_eq!(record.failed, ["beside"]);
        assert_eq!(record.tally.lines(), ["2 skipped: no data", "4 passed, 1 failed, 2 skipped"]);
        assert_eq!(record.times, [("aside".to_owned(), 7.0)]);
        assert_eq!(steps.times.len(), 5);
    }
}
