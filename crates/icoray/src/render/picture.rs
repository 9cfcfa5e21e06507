//! A picture of rays that are ready to be traced: shared out among ranks, traced, gathered.

use super::device::OnDevice;
use super::prepare::Known;
use super::round::{Cost, Rounds};
use super::work::{Work, certainty, notes};
use super::{Rendered, Setting};
use crate::description::Description;
use crate::error::Result;
use crate::frame::{ErrorSummary, Frame, FrameReport};
use crate::label::Legend;
use crate::output::Stamp;
use crate::ranks::{Ranks, Told};
use crate::raster::Raster;
use std::time::Instant;

/// Draws the picture of `work`. Collective. The report's `derived_bytes` are left to whoever knows them.
pub(super) fn draw(
    setting: &Setting,
    ranks: &mut Ranks,
    known: &Known,
    work: &Work,
    mut on_device: OnDevice,
) -> Result<Rendered> {
    let Setting { renderer, scene, plan, grid, part, start, .. } = *setting;
    let Known { value_range, missing_values, quality, deadline } = known;
    let prepare_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    // What others would measure of the same data is not asked for.
    let deadline = deadline.filter(|_| part.is_some() || ranks.is_root());
    let mut picked = ranks.attempt(|| renderer.run(|| Ok(work.pick(*quality, deadline, &mut on_device))));
    if part.is_some() {
        picked = ranks.agree_on_cheapest(picked);
    }
    // Ranks that have different data draw tiles that do not fit each other.
    let facts = || match part {
        Some(part) => vec![("has a part of a grid of cells", part.cells().to_string())],
        None => vec![
            ("has a grid of cells and corners", format!("{} and {}", grid.cells(), grid.triangles())),
            ("has a field of range and missing values", format!("{value_range:?} and {missing_values}")),
        ],
    };
    let share = ranks.deal(picked, work.raster(), facts)?;
    let quality = share.quality;
    let raster = Raster { step: quality.pixel_step, ..work.raster() };
    let picked_s = start.elapsed().as_secs_f64();
    let mut rounds = Rounds { setting, work, on_device: &mut on_device, cost: Cost::default() };
    let drawn = rounds.whole(ranks, raster, &share)?;
    let (edge_pixels, drawn) = rounds.edges(ranks, raster, quality, deadline, drawn)?;
    let cost = rounds.cost;
    let mut picture = None;
    let told = drawn.map(|drawn| {
        let Cost { gather_s, balance, bytes_received, .. } = cost;
        let mut told = Told { gather_s, balance, bytes_received, ..Told::default() };
        if let Some((drawn, counts)) = drawn {
            let error: Vec<f32> = drawn.iter().map(|p| p.error).collect();
            told.error = ErrorSummary::of(&error, certainty(scene, &quality), quality.tolerance);
            told.counts = counts;
            picture = Some((drawn, error));
        }
        told
    });
    let told = ranks.conclude(told)?;
    let mut report = FrameReport {
        error: told.error,
        prepare_s,
        render_s: picked_s + cost.render_s,
        counts: told.counts,
        value_range: *value_range,
        missing_values: *missing_values,
        quality,
        left_out: plan.left_out().to_vec(),
        tiles: share.tiles_of(ranks.rank()).len(),
        edge_pixels,
        compose_s: cost.compose_s,
        gather_s: told.gather_s,
        balance: told.balance,
        bytes_received: told.bytes_received,
        ..FrameReport::default()
    };
    on_device.tell(&mut report);
    let Some((drawn, error)) = picture else {
        return Ok(Rendered::AtRoot(report));
    };
    Ok(Rendered::Here(Frame {
        width: scene.width,
        height: scene.height,
        pixels: drawn.iter().map(|p| p.color).collect(),
        error,
        field: scene.field.clone(),
        description: Description::default(),
        descriptions: Vec::new(),
        legend: Legend::of(scene, &plan.radius),
        notes: notes(scene),
        stamp: Stamp::default(),
        report,
    }))
}
