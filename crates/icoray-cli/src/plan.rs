//! `icoray plan`: what a scene leaves out.

use crate::failure::Failure;
use crate::gpu;
use crate::input::{self, Input, Wanted};
use icoray::{Plan, Sharing};
use std::io::Write;
use std::path::PathBuf;

/// What `icoray plan` is told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    input: Input,
    /// What to draw and how
    #[arg(long, value_name = "SCENE.toml")]
    scene: PathBuf,
    #[command(flatten)]
    wanted: Wanted,
    #[command(flatten)]
    who: gpu::Who,
}

/// Prints, a line each, what is not computed or read for the scene.
pub fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let mut scene = input::scene(&args.scene)?;
    args.who.apply(&mut scene);
    let file = args.input.open()?;
    let grid = file.mesh().grid()?;
    let info = file.field_info(&scene.field)?;
    let layers = args.wanted.radii(&file.layer_heights(&info.name)?, info)?;
    let owned = args.wanted.read(&file, info, 0)?;
    // Nothing is drawn.
    let renderer = gpu::renderer(1)?;
    let plan = Plan::new(&scene, &grid, &layers, &owned.field()?)?;
    if plan.left_out().is_empty() {
        writeln!(out, "nothing is left out")?;
    }
    for part in plan.left_out() {
        writeln!(out, "left out: {part}")?;
    }
    writeln!(out, "drawn on {}", gpu::would_draw(&renderer, &scene))?;
    writeln!(out, "several ranks would draw {}", Sharing::new(&scene, None)?)?;
    Ok(())
}
