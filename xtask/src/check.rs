//! `cargo xtask test`: everything that must hold before a change goes in.

use crate::error::Error;
use crate::link;
use crate::options::{Size, TestOptions};
use crate::pictures::{Pictures, check_picture};
use crate::requirements;
use crate::step::{Step, Steps, complain, say};
use crate::system;
use crate::tracer::{self, Linkage, Tracer};
use crate::workspace::Workspace;

/// Something to check.
struct Check {
    title: &'static str,
    /// Whether it is left out of a fast run.
    slow: bool,
    run: fn(&Workspace, &mut Step) -> Result<(), Error>,
}

static CHECKS: &[Check] = &[
    Check { title: "formatting", slow: false, run: formatting },
    Check { title: "lints", slow: false, run: lints },
    Check { title: "tests", slow: false, run: tests },
    Check { title: "documentation", slow: true, run: documentation },
    Check { title: "C example, shared library", slow: true, run: shared_example },
    Check { title: "C example, static library", slow: true, run: static_example },
    Check { title: "install and link", slow: true, run: link::check },
];

/// Runs the checks, all of them even if some fail: one run is to show everything that is wrong.
pub fn run(workspace: &Workspace, options: &TestOptions) -> Result<(), Error> {
    let checks: Vec<_> = CHECKS.iter().filter(|check| !(options.fast && check.slow)).collect();
    let total = checks.len() + 1;
    let mut steps = Steps::new(total);
    // Without its packages nothing builds, and each of the steps would say so at length.
    steps.run("looking for system packages", |step| {
        system::provide(requirements::FOR_TEST, options.install, step)
    })?;
    let mut failed = Vec::new();
    for check in checks {
        if let Err(error) = steps.run(check.title, |step| (check.run)(workspace, step)) {
            complain(&error.to_string());
            failed.push(check.title);
        }
    }
    if failed.is_empty() {
        say(&format!("all {total} steps passed in {:.0} s", steps.seconds()));
        return Ok(());
    }
    let list = failed.join("\n  ");
    Err(Error::Failed(format!("{} of {total} steps failed:\n  {list}", failed.len())))
}

fn formatting(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    step.quiet(&mut workspace.cargo(["fmt", "--all", "--check"]))
}

fn lints(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    let arguments = ["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"];
    step.quiet(&mut workspace.cargo(arguments))
}

fn tests(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    let all = step.streamed(&mut workspace.cargo(["test", "--workspace", "--no-fail-fast"]));
    // The whole workspace again, so that nothing but the command is built anew.
    let ranks = ["test", "--workspace", "--features", "icoray-cli/mpi", "--test", "cli", "--", "ranks"];
    all.and(step.streamed(&mut workspace.cargo(ranks)))
}

fn documentation(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    let mut cargo = workspace.cargo(["doc", "--workspace", "--no-deps"]);
    step.quiet(cargo.env("RUSTDOCFLAGS", "-D warnings"))
}

fn shared_example(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    example(workspace, Linkage::Shared, step)
}

fn static_example(workspace: &Workspace, step: &mut Step) -> Result<(), Error> {
    example(workspace, Linkage::Static, step)
}

/// Builds and runs a small C example; with the dev profile, which the tests have built already.
fn example(workspace: &Workspace, linkage: Linkage, step: &mut Step) -> Result<(), Error> {
    let model = Tracer::new(workspace, "debug", linkage);
    let out = workspace.products("tmp").join(match linkage {
        Linkage::Shared => "tracer-shared",
        Linkage::Static => "tracer-static",
    });
    step.quiet(&mut workspace.cargo(["build", "--package", "icoray-capi"]))?;
    step.quiet(&mut model.compile())?;
    let pictures = Pictures::new(out, tracer::PREFIX);
    pictures.prepare()?;
    let size = Size { level: 3, layers: 8, days: 1.0 };
    step.quiet(&mut model.run(size, &workspace.root().join(tracer::SCENE), pictures.folder())?)?;
    for picture in &pictures.taken()? {
        check_picture(picture)?;
    }
    if pictures.frames()?.errors.is_none() {
        return Err(Error::Failed(format!(
            "{} does not say how far the pictures may be off",
            pictures.report().display()
        )));
    }
    Ok(())
}
