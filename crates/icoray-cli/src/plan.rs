//! `icoray plan`: what a scene leaves out.

use crate::failure::Failure;
use crate::gpu;
use crate::input::{self, Input, Wanted};
use crate::layering::Layering;
use icoray::output::Stamp;
use icoray::{Grid, Plan, Renderer, Scene, Sharing, Shot};
use icoray_netcdf::ModelFile;
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

/// Prints, a line each, what is not computed or read for each view at the first time; of a sweep for its first picture.
pub fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let mut script = input::script(&args.scene)?;
    script.scenes_mut().for_each(|scene| args.who.apply(scene));
    let file = args.input.open()?;
    let grid = file.mesh().grid()?;
    // Nothing is drawn.
    let renderer = gpu::renderer(1)?;
    for view in script.views() {
        let Some(Shot { name, scene }) = view.shots(&Stamp::default()).next() else { continue };
        if !name.is_empty() {
            writeln!(out, "view {name}:")?;
        }
        say(args, &file, &grid, &renderer, &scene, out)?;
    }
    Ok(())
}

fn say(
    args: &Args,
    file: &ModelFile,
    grid: &Grid,
    renderer: &Renderer,
    scene: &Scene,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let layering = Layering::of(file, scene, &args.wanted)?;
    let layers = layering.layers(&file.layer_heights(&layering.bearer().name)?)?;
    let [lead, _] = layering.key();
    let first = file.field_info(lead)?;
    let owned = file.read_layers(lead, 0, layering.range(first)?)?;
    let plan = Plan::new(scene, grid, &layers, &owned.field()?)?;
    if plan.left_out().is_empty() {
        writeln!(out, "nothing is left out")?;
    }
    for part in plan.left_out() {
        writeln!(out, "left out: {part}")?;
    }
    writeln!(out, "drawn on {}", gpu::would_draw(renderer, scene))?;
    writeln!(out, "several ranks would draw {}", Sharing::new(scene, None)?)?;
    Ok(())
}
