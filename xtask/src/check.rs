//! `cargo xtask test`: the checks that a change must pass.

mod python;
mod suite;
mod tally;

use crate::book;
use crate::error::Error;
use crate::link;
use crate::requirements;
use crate::step::{Step, Steps, print_error, print_line};
use crate::system;
use crate::workspace::{Workspace, is_required};
use std::process::ExitCode;
use suite::Suite;
use tally::Tally;

/// The runs that include a check.
#[derive(Clone, Copy, PartialEq)]
enum When {
    Always,
    /// Without `--all`, which has a larger check instead.
    ByDefault,
    WithAll,
}

/// How a check is run, and counted at the end.
enum Run {
    /// It passes or fails as a whole.
    Whole(fn(&Suite, &mut Step) -> Result<(), Error>),
    /// It counts its tests and those that it skips itself.
    Counted(fn(&Suite, &mut Step, &mut Tally) -> Result<(), Error>),
}
use Run::{Counted, Whole};

/// The titles of the checks, the runs that include them, and how they are run.
static CHECKS: &[(&str, When, Run)] = &[
    ("formatting", When::Always, Whole(|suite, step| step.quiet(suite.workspace.cargo(["fmt", "--all", "--check"])))),
    ("lints", When::ByDefault, Whole(suite::lints)),
    ("tests", When::ByDefault, Counted(suite::default_tests)),
    ("lints, all packages", When::WithAll, Whole(suite::lints)),
    ("tests, all packages", When::WithAll, Counted(suite::all_tests)),
    ("tests of the command over ranks", When::WithAll, Counted(suite::rank_tests)),
    ("tests of the Python package", When::Always, Counted(python_tests)),
    ("documentation", When::WithAll, Whole(suite::documentation)),
    ("install and link", When::WithAll, Whole(|suite, step| link::check(suite.workspace, step))),
    ("links of the pages", When::Always, Whole(|suite, step| book::check_links(suite.workspace, step))),
    ("commands of the pages", When::ByDefault, Counted(commands)),
    ("all commands of the pages", When::WithAll, Counted(commands)),
    ("the book", When::WithAll, Whole(|suite, step| book::build(suite.workspace, step))),
];

/// What `--all` adds to the default run.
const ADDED: &str = "GPU and MPI with their tests, valgrind, long counts of rays, damaged grids and frames, \
                     documentation, programs linked with the installed library, slow commands of the pages, the book";

/// Runs all checks, even if some fail, so that one run shows all faults. The last line is `N passed, N failed, N
/// skipped`; the exit code says whether all passed.
pub fn run(workspace: &Workspace, all: bool, install: bool) -> Result<ExitCode, Error> {
    let other = if all { When::ByDefault } else { When::WithAll };
    let checks: Vec<_> = CHECKS.iter().filter(|(_, when, _)| *when != other).collect();
    print_line(&if all { format!("--all adds {ADDED}") } else { format!("only with --all: {ADDED}") });
    let mut steps = Steps::new(checks.len() + 1);
    let mut tally = Tally::default();
    // A missing package ends the run here: nothing builds without it, and every step would print long errors.
    let (reads_files, has_python) = steps.run("looking for system packages", |step| {
        if all {
            return system::provide(requirements::FOR_TEST_ALL, install, step).map(|()| (true, true));
        }
        system::provide(requirements::FOR_TEST, install, step)?;
        let found = system::provide(requirements::FOR_FILES, install, step);
        if let Err(error) = &found {
            step.note(&format!("what reads files is left out: {}", error.brief()));
            tally.add_skipped("no NetCDF library", suite::READING_FILES.len());
        }
        let python = system::provide(requirements::FOR_PYTHON, install, step);
        if let Err(error) = &python {
            step.note(&format!("the Python package is left out: {}", error.brief()));
        }
        Ok((found.is_ok(), python.is_ok()))
    })?;
    let suite = Suite { workspace, all, reads_files, has_python };
    let mut failed = Vec::new();
    for (title, _, run) in checks {
        let outcome = steps.run(title, |step| match run {
            Counted(run) => run(&suite, step, &mut tally),
            Whole(run) => {
                let outcome = run(&suite, step);
                tally.add_whole(outcome.is_ok());
                outcome
            }
        });
        if let Err(error) = outcome {
            print_error(&error.to_string());
            failed.push(*title);
        }
    }
    if !failed.is_empty() {
        print_error(&format!("steps that failed:\n  {}", failed.join("\n  ")));
    }
    print_line(&format!("took {:.0} s", steps.started.elapsed().as_secs_f64()));
    tally.lines().iter().for_each(|line| print_line(line));
    Ok(if failed.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The tests of the Python package, or one that is skipped where there is no Python.
fn python_tests(suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    if suite.has_python {
        return python::tests(suite, step, tally);
    }
    if is_required("python") {
        return Err(Error::Failed("ICORAY_REQUIRE names python, and the machine lacks it".into()));
    }
    tally.add_skipped("no Python", 1);
    Ok(())
}

/// The commands of the pages: counted as one check, and each skipped block as one.
fn commands(suite: &Suite, step: &mut Step, tally: &mut Tally) -> Result<(), Error> {
    let skip = |need: &str, count: usize| tally.add_skipped(&format!("no {need}"), count);
    let outcome = book::run_commands(suite.workspace, step, suite.all, skip);
    tally.add_whole(outcome.is_ok());
    outcome
}
