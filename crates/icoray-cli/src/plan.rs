//! `icoray plan`: what a scene reads and leaves out.

use crate::failure::Failure;
use crate::gpu;
use crate::input::{self, Input, Wanted};
use crate::layering::Layering;
use icoray::output::Stamp;
use icoray::{Condition, Grid, Heights, Plan, Scene, Sharing, Shot, View};
use icoray_netcdf::ModelFile;
use std::collections::HashSet;
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

/// Prints for each view, a line each, what is read and what is not computed or read at the first time; of a sweep for the
/// first picture of each field.
pub fn run(args: &Args, out: &mut impl Write) -> Result<(), Failure> {
    let mut script = input::script(&args.scene)?;
    script.scenes_mut().for_each(|scene| args.who.apply(scene));
    let file = args.input.open()?;
    let grid = file.mesh().grid()?;
    // Nothing is drawn.
    let renderer = gpu::renderer(1)?;
    for view in script.views() {
        let mut fields = HashSet::new();
        for Shot { name, scene } in view.shots(&Stamp::default()) {
            if !fields.insert(scene.field.clone()) {
                continue;
            }
            let swept = view.scenes().nth(1).map(|_| format!("field {}", scene.field));
            let title: Vec<String> =
                (!name.is_empty()).then(|| format!("view {name}")).into_iter().chain(swept).collect();
            if !title.is_empty() {
                writeln!(out, "{}:", title.join(", "))?;
            }
            let layering = Layering::of(&file, &scene, &args.wanted)?;
            read(&file, view, &scene, &layering, out)?;
            left_out(&file, &grid, &scene, &layering, out)?;
            writeln!(out, "drawn on {}", gpu::would_draw(&renderer, &scene))?;
            writeln!(out, "several ranks would draw {}", Sharing::new(&scene, None)?)?;
        }
    }
    Ok(())
}

/// Says which variables are read, and how much of them.
fn read(
    file: &ModelFile,
    view: &View,
    scene: &Scene,
    layering: &Layering,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let drawn = scene.model_fields();
    let asked = view.conditions().iter().map(Condition::field);
    let mut known = HashSet::new();
    for name in drawn.iter().copied().chain(asked).filter(|name| known.insert(*name)) {
        let info = file.field_info(name)?;
        let (place, layers) = (input::place(info.location), layering.range(info)?.len());
        let bytes = info.columns * layers * info.precision.bytes();
        let when = if drawn.contains(&name) { "" } else { ", for when" };
        writeln!(out, "read: {name} at {place}, {layers} layers ({bytes} bytes each time{when})")?;
    }
    if scene.scenery.heights == Heights::Native {
        let own = file.native_info(&layering.bearer().name)?;
        let each = if own.time_dependent { "each time" } else { "once" };
        writeln!(out, "read: {} ({} bytes {each})", own.description, own.bytes)?;
    }
    Ok(())
}

/// Says what is left out, and checks that the scene's fields fit its layers.
fn left_out(
    file: &ModelFile,
    grid: &Grid,
    scene: &Scene,
    layering: &Layering,
    out: &mut impl Write,
) -> Result<(), Failure> {
    let layers = layering.layers(&file.layer_heights(&layering.bearer().name)?)?;
    for name in scene.model_fields() {
        let count = layering.range(file.field_info(name)?)?.len();
        layers.for_field(count).map_err(|e| e.within(format!("{name:?}")))?;
    }
    // Of a derived field it is what that is made of that the file has.
    let [first, _] = layering.key();
    let owned = file.read_layers(first, 0, layering.range(file.field_info(first)?)?)?;
    let plan = Plan::new(scene, grid, &layers, &owned.field()?)?;
    if plan.left_out().is_empty() {
        writeln!(out, "nothing is left out")?;
    }
    for part in plan.left_out() {
        writeln!(out, "left out: {part}")?;
    }
    Ok(())
}
