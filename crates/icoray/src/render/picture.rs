//! Draws the picture of prepared rays: distributes tiles over ranks, traces and gathers them.

use super::Rendered;
use super::context::FrameContext;
use super::device::OnDevice;
use super::prepare::FieldSummary;
use super::round::Rounds;
use super::work::{Work, certainty};
use crate::cells_per_pixel::cells_per_pixel;
use crate::ranks::{FrameSummary, Ranks};
use crate::raster::Raster;
use crate::sampling::Sampled;
use icoray_grid::Result;
use icoray_kernel::Counts;
use icoray_output::{ErrorSummary, Frame, FrameReport, Legend, RanksReport, SamplingReport, Timing};
use icoray_scene::name::Stamp;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::time::Instant;

/// Draws the picture of `work`. Collective. The caller sets the report's `bytes_derived`.
pub(super) fn draw(
    work: &Work,
    ranks: &mut Ranks,
    field_summary: &FieldSummary,
    mut on_device: OnDevice,
) -> Result<Rendered> {
    let FrameContext { renderer, scene, plan, grid, part, start, .. } = *work.context;
    let FieldSummary { quality, deadline, .. } = field_summary;
    let (value_range, missing_values) = field_summary.first();
    let prepare_s = start.elapsed().as_secs_f64();
    let start = Instant::now();
    // With the same data on all ranks, only rank 0 measures.
    let deadline = deadline.filter(|_| part.is_some() || ranks.is_root());
    let mut picked = ranks.attempt(|| renderer.run(|| Ok(work.pick(*quality, deadline, &mut on_device))));
    if part.is_some() {
        picked = ranks.agree_on_cheapest(picked);
    }
    // Tiles of ranks with different data would not fit each other.
    let facts = || match part {
        Some(part) => vec![("has a part of a grid of cells", part.cells().to_string())],
        None => vec![
            ("has a grid of cells and corners", format!("{} and {}", grid.cells(), grid.triangles())),
            ("has a field of range and missing values", format!("{value_range:?} and {missing_values}")),
        ],
    };
    let assignment = ranks.assign(picked, work.raster(), facts)?;
    let quality = assignment.quality;
    let raster = Raster { step: quality.pixel_step, ..work.raster() };
    let picked_s = start.elapsed().as_secs_f64();
    let between_ranks = RanksReport::default();
    let mut rounds =
        Rounds { work, on_device: &mut on_device, raster, quality, deadline, render_s: 0.0, between_ranks };
    let progress = renderer.progress.as_ref();
    let drawn = rounds.trace(ranks, &raster, &assignment, progress, |tiles| raster.assemble(tiles))?;
    let drawn = rounds.refined(ranks, drawn)?;
    let sampled = rounds.samples(ranks, drawn)?;
    let Rounds { render_s, between_ranks, .. } = rounds;
    let mut picture = None;
    let summary = ranks.attempt(|| {
        let RanksReport { gather_s, balance, bytes_received, .. } = between_ranks;
        let mut summary = FrameSummary { gather_s, balance, bytes_received, ..FrameSummary::default() };
        let Some(Sampled { drawn: (drawn, counts), edge_pixels, rays_per_pixel, error: off, summary: reported }) =
            sampled
        else {
            return Ok(summary);
        };
        let error: Vec<f32> = renderer.run(|| drawn.par_iter().map(|p| p.error).collect());
        let summarize = || ErrorSummary::of(&error, certainty(scene, &quality), quality.tolerance);
        let colors = || drawn.par_iter().map(|p| p.color).collect();
        let pixels: Vec<_>;
        (summary.error, pixels) = renderer.run(|| rayon::join(summarize, colors));
        (summary.counts, summary.edge_pixels) = (counts.numbers(), edge_pixels);
        let cells_per_pixel = cells_per_pixel(scene, grid, part, work.radius);
        summary.sampling = SamplingReport { samples: scene.samples, rays_per_pixel, error: reported, cells_per_pixel };
        picture = Some((pixels, error, off));
        Ok(summary)
    });
    let summary = ranks.hear_root(summary)?;
    let mut report = FrameReport {
        error: summary.error,
        timing: Timing { prepare_s, render_s: picked_s + render_s, ..Timing::default() },
        counts: Counts::of_numbers(summary.counts),
        value_range,
        missing_values,
        quality,
        left_out: plan.left_out().to_vec(),
        sampling: summary.sampling,
        edge_pixels: summary.edge_pixels,
        ranks: RanksReport {
            tiles: assignment.tiles_of(ranks.rank()).len(),
            compose_s: between_ranks.compose_s,
            gather_s: summary.gather_s,
            balance: summary.balance,
            bytes_received: summary.bytes_received,
            ..RanksReport::default()
        },
        ..FrameReport::default()
    };
    on_device.report_to(&mut report);
    let Some((pixels, error, sampling_error)) = picture else {
        return Ok(Rendered::AtRoot(report));
    };
    let [low, high] = scene.volumes[0].transfer.range();
    let notes = vec![
        ("transfer range", format!("{low} to {high}")),
        ("camera", scene.camera.describe()),
        ("exaggeration", scene.exaggeration.to_string()),
    ];
    Ok(Rendered::Here(Frame {
        width: scene.width,
        height: scene.height,
        pixels,
        error,
        sampling_error,
        field: scene.field().to_owned(),
        descriptions: BTreeMap::new(),
        legend: Legend::of(scene, &plan.radius),
        notes,
        stamp: Stamp::default(),
        report,
    }))
}
