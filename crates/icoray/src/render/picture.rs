//! A picture of rays that are ready to be traced: shared out among ranks, traced, gathered.

use super::device::OnDevice;
use super::prepare::Known;
use super::progress::reported;
use super::work::{Work, certainty, notes};
use super::{Rendered, Setting};
use crate::description::Description;
use crate::error::Result;
use crate::frame::{ErrorSummary, Frame, FrameReport};
use crate::label::Legend;
use crate::output::Stamp;
use crate::ranks::{Ranks, Told};
use crate::raster::{Raster, Tile};
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
    let exchanged = part.map(|part| work.exchange(ranks, part, &share, &mut on_device)).transpose()?;
    let mine = share.tiles_of(ranks.rank());
    let fragments = exchanged.as_ref().map(|e| ranks.together(e.tiles(raster, &mine))).transpose()?;
    let trace = |give: &(dyn Fn(Tile) + Sync)| {
        reported(renderer.progress.as_ref(), mine.len(), give, |give| match &fragments {
            Some(fragments) => work.put_together(&quality, raster, fragments, give),
            None => work.trace(&quality, raster, &mine, &mut on_device, give),
        });
    };
    let traced_s = exchanged.as_ref().map_or(0.0, |exchanged| exchanged.traced_s);
    let ready_s = start.elapsed().as_secs_f64();
    let gathered = ranks.gather(&renderer.threads, raster, traced_s, trace);
    let is_root = ranks.is_root();
    let (mut picture, mut drawn_s) = (None, 0.0);
    let told = gathered.and_then(|gathered| {
        drawn_s = gathered.drawn_s;
        let (gather_s, balance, bytes_received) =
            (gathered.gather_s, gathered.balance, gathered.bytes_received);
        let mut told = Told { gather_s, balance, bytes_received, ..Told::default() };
        if is_root {
            let (drawn, counts) = ranks.attempt(|| renderer.run(|| Ok(raster.assemble(&gathered.tiles))))?;
            let error: Vec<f32> = drawn.iter().map(|p| p.error).collect();
            told.error = ErrorSummary::of(&error, certainty(scene, &quality));
            told.counts = counts;
            picture = Some((drawn, error));
        }
        Ok(told)
    });
    let told = ranks.conclude(told)?;
    let mut report = FrameReport {
        error: told.error,
        prepare_s,
        render_s: ready_s + drawn_s - traced_s,
        counts: told.counts,
        value_range: *value_range,
        missing_values: *missing_values,
        quality,
        left_out: plan.left_out().to_vec(),
        tiles: mine.len(),
        compose_s: if part.is_some() { drawn_s - traced_s } else { 0.0 },
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
