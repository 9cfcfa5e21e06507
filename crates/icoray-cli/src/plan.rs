//! `icoray plan`: prints what a scene reads and leaves out.

use crate::failure::CommandResult;
use crate::render::Args;
use crate::selection::Opened;
use crate::suggested::Scenes;
use crate::{gpu, input};
use icoray::memory::{available, readable};
use icoray::{Condition, Grid, Heights, Plan, Renderer, SamplingReport, Scene, Shot, View};
use icoray_dataset::{Dataset, Layering};
use icoray_progress::Progress;
use std::collections::HashSet;
use std::io::Write;

/// Prints for each view what is read and left out at the first time; of a sweep, for the first picture of each field.
pub fn run(args: &Args, out: &mut impl Write) -> CommandResult {
    let progress = Progress::new();
    let Some(opened) = args.selection.open(&progress)? else {
        return Ok(writeln!(out, "{}", args.selection.nothing())?);
    };
    let Opened { renderer, file, .. } = &opened;
    let Scenes { script, grid, suggested } = opened.scenes(&args.selection, &progress)?;
    let (series, target) = args.output_options.choose(&script, &opened)?;
    progress.stage("looking at fields");
    progress.suspend(|| args.save_scene(suggested.as_ref(), out))?;
    let time = series.times[0];
    let stamp = series.stamp(time);
    for view in script.views() {
        let mut fields = HashSet::new();
        for Shot { name, scene } in view.shots(&stamp) {
            if !fields.insert(scene.field().to_owned()) {
                continue;
            }
            let layering = Layering::of(file, &scene, &args.selection.layer_option.layers)?;
            let mut text = Vec::new();
            let swept = view.scenes().nth(1).map(|_| format!("field {}", scene.field()));
            let title: Vec<String> =
                (!name.is_empty()).then(|| format!("view {name}")).into_iter().chain(swept).collect();
            if !title.is_empty() {
                writeln!(text, "{}:", title.join(", "))?;
            }
            read(file, view, &scene, &layering, &mut text)?;
            left_out(renderer, file, &grid, &scene, &layering, time, &mut text)?;
            writeln!(text, "drawn on {}", gpu::would_draw(renderer, &scene))?;
            writeln!(text, "several ranks would draw {}", Plan::sharing(&scene, false)?)?;
            let path = target.path(&scene.output, &stamp, scene.field())?;
            writeln!(text, "picture: {} ({} x {}), time {time}", path.display(), scene.width, scene.height)?;
            progress.suspend(|| out.write_all(&text))?;
        }
    }
    Ok(())
}

/// Prints the variables that are read, with their sizes.
fn read(file: &Dataset, view: &View, scene: &Scene, layering: &Layering, out: &mut impl Write) -> CommandResult {
    let drawn = scene.model_fields();
    let conditions = view.conditions().iter().map(Condition::field);
    let mut known = HashSet::new();
    for name in drawn.iter().copied().chain(conditions).filter(|name| known.insert(*name)) {
        let info = file.field_info(name)?;
        // A 2D field is read once for all layers.
        let layers = if info.is_2d() { 1 } else { layering.range(info)?.len() };
        let place = input::place(info);
        let bytes = info.columns * layers * info.precision.bytes();
        let when = if drawn.contains(&name) { "" } else { ", for when" };
        writeln!(out, "read: {name} at {place}, {layers} layers ({bytes} bytes each time{when})")?;
    }
    if scene.scenery.heights == Heights::Native {
        let own = file.native_info(&layering.height_field().name)?;
        let each = if own.time_dependent { "each time" } else { "once" };
        writeln!(out, "read: {} ({} bytes {each})", own.description, own.bytes)?;
    }
    Ok(())
}

/// Prints what is left out and what a frame takes of memory, after checking that the fields fit the layers.
fn left_out(
    renderer: &Renderer,
    file: &Dataset,
    grid: &Grid,
    scene: &Scene,
    layering: &Layering,
    time: usize,
    out: &mut impl Write,
) -> CommandResult {
    let layers = layering.layers(&layering.heights(file)?)?;
    for name in scene.model_fields() {
        let count = layering.range(file.field_info(name)?)?.len();
        layers.for_field(count).map_err(|e| e.within(format!("{name:?}")))?;
    }
    // For a derived field this is the first field of the file that it is computed from.
    let [first, _] = layering.key();
    let owned = file.read_layers(first, time, layering.range(file.field_info(first)?)?)?;
    let plan = Plan::new(scene, grid, &layers, &owned.field()?)?;
    if plan.left_out().is_empty() {
        writeln!(out, "nothing is left out")?;
    }
    for part in plan.left_out() {
        writeln!(out, "left out: {part}")?;
    }
    let memory = renderer.run(|| plan.memory(scene, grid));
    let available = available().map_or_else(String::new, |bytes| format!("; {} are available", readable(bytes)));
    writeln!(out, "memory: {} at most, beside the model's arrays: {memory}{available}", readable(memory.total()))?;
    let cells_per_pixel = plan.cells_per_pixel(scene, grid);
    writeln!(out, "cells per pixel: {cells_per_pixel}")?;
    let hint = SamplingReport { samples: scene.samples, cells_per_pixel, ..SamplingReport::default() }.hint();
    if let Some(hint) = hint {
        writeln!(out, "hint: {hint}")?;
    }
    Ok(())
}
