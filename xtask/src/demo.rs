//! `cargo xtask demo`: a simulation that takes its own pictures.

use std::fs;

use crate::error::Error;
use crate::options::DemoOptions;
use crate::report::{Frames, Summary};
use crate::step::{Steps, say};
use crate::system;
use crate::tracer::{self, CONTACT_SHEET, Linkage, REPORT, Tracer};
use crate::workspace::Workspace;

/// As many pictures as are listed one by one; of more, the first and the last.
const LISTED: usize = 30;

/// Runs the demo.
pub fn run(workspace: &Workspace, options: &DemoOptions) -> Result<(), Error> {
    let out = match &options.out {
        Some(out) => workspace.given(out),
        None => workspace.root().join("out/demo"),
    };
    let scene = options.scene.as_ref().map(|scene| workspace.given(scene));
    // Found out now rather than after the build.
    if let Some(scene) = scene.as_ref().filter(|scene| !scene.is_file()) {
        return Err(Error::Failed(format!("no scene file: {}", scene.display())));
    }
    let model = Tracer::new(workspace, "release", Linkage::Shared);
    let sheet = out.join(CONTACT_SHEET);
    let report = out.join(REPORT);

    let mut steps = Steps::new(5);
    steps.run("looking for system packages", |step| {
        system::provide(system::FOR_DEMO, options.install, step)
    })?;
    steps.run("building the library", |step| step.quiet(&mut tracer::build_library(workspace, true)))?;
    steps.run("building the tracer model", |step| step.quiet(&mut model.compile()))?;
    let lines = steps.run("running the tracer model", |step| {
        tracer::prepare(&out)?;
        step.echoed(&mut model.run(options.size, scene.as_deref(), &out)?)
    })?;
    let pictures = tracer::pictures(&out)?;
    if pictures.is_empty() {
        return Err(Error::Failed(format!("the tracer model left no pictures in {}", out.display())));
    }
    steps.run("making the contact sheet", |step| {
        let mut command =
            workspace.cargo(["run", "--release", "--package", "icoray", "--example", "contact_sheet", "--"]);
        step.quiet(command.arg(&out).arg(&sheet))
    })?;

    let csv = fs::read_to_string(&report).map_err(Error::while_doing(report.display()))?;
    let frames = Frames::read(&csv);
    let summary = Summary::find(&lines).or_from(&frames);
    say(&format!("\npictures ({}):", pictures.len()));
    if let [first, .., last] = pictures.as_slice()
        && pictures.len() > LISTED
    {
        say(&format!("  {}", workspace.shown(first)));
        say("  ...");
        say(&format!("  {}", workspace.shown(last)));
    } else {
        for picture in &pictures {
            say(&format!("  {}", workspace.shown(picture)));
        }
    }
    say(&format!("contact sheet:\n  {}", workspace.shown(&sheet)));
    say(&format!("report, a line per picture:\n  {}", workspace.shown(&report)));
    say(&format!("\n{}", summary.table()));
    if let Some(errors) = frames.errors {
        say(&format!("\n{}", errors.sentence()));
    }
    Ok(())
}
