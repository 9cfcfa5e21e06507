//! `icoray view`: serves a page that shows a file, turns the globe and edits colours.

use crate::failure::CommandResult;
use crate::selection::{Opened, Selection};
use crate::suggested::{self, Suggested};
use icoray::Result;
use icoray_dataset::view::{self, Viewer};
use icoray_live::{LiveView, Options, PictureSize};
use icoray_progress::Progress;
use std::io::Write;

/// Arguments of `icoray view`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  icoray view history.nc\n  icoray view history.nc --mesh init.nc --scene scene.toml"
)]
pub struct Args {
    #[command(flatten)]
    pub selection: Selection,
    /// Port on this machine's loopback address; another one if it is taken [default: 8750 or the next that is free]
    #[arg(long, value_name = "PORT", value_parser = clap::value_parser!(u16).range(1..))]
    port: Option<u16>,
}

/// Serves the page until the command is interrupted.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let progress = Progress::new();
    let selection = &args.selection;
    let Some(mut opened) = selection.open(&progress)? else {
        writeln!(out, "{}", selection.nothing())?;
        return Ok(());
    };
    let text = text(selection, &opened, &progress)?;
    progress.stage("checking the grid");
    let grid = opened.renderer.run(|| opened.file.mesh().grid())?;
    progress.finish();
    let time = opened.times[opened.times.len() - 1];
    let reader = view::reader(&opened.file);
    let size = match (&opened.given, selection.overrides.size) {
        (Some(text), _) => PictureSize::of(text),
        (None, Some(_)) => PictureSize::SceneOrViewer,
        (None, None) => PictureSize::Viewer,
    };
    let description = view::describe(&opened.file, suggested::command(selection, None));
    let options = Options { port: args.port, size, is_framed: false };
    let live = LiveView::open(&options, description, text, time, reader)?;
    opened.renderer = opened.renderer.with_levels().with_stop(live.stop());
    writeln!(out, "view      {}\n          ends with Ctrl-C", live.address())?;
    out.flush()?;
    Viewer::new(&opened.file, &grid, &opened.renderer, &selection.layer_option.layers, &live).run();
    Ok(())
}

/// The text of the scene that is shown first: that of the scene file, or a suggested one.
fn text(selection: &Selection, opened: &Opened, progress: &Progress) -> Result<String> {
    let Some(given) = &opened.given else {
        let (suggested, _) = Suggested::new(selection, opened, progress)?;
        return Ok(view::without_head(&suggested.text).to_owned());
    };
    selection.overrides.expect_none()?;
    Ok(opened.completed(given, selection, progress)?.0)
}
