//! Finds range and quality of a picture's first field before the first ray.

use super::context::FrameContext;
use super::prepared_field::PreparedField;
use super::work::requested_quality;
use crate::plan::FrameMemory;
use crate::ranges::{RangeAndMissing, both_ranges, reduce_parts};
use crate::ranks::{CountedColumns, Ranks};
use crate::time_budget::Deadline;
use icoray_grid::gradient::{self, GradientOptions, Gradients, PreparedSample};
use icoray_grid::samples::Samples;
use icoray_grid::{Location, Reals, Result};
use icoray_scene::{Lights, Quality};

/// Range, missing values, quality and deadline of the first field.
pub(super) struct FieldSummary {
    /// The ranges of the first fields, at least of one.
    ranges: Vec<RangeAndMissing>,
    /// The scene's quality, without light if there is no time for gradients.
    pub quality: Quality,
    pub deadline: Option<Deadline>,
}

impl FieldSummary {
    /// The summary of the first field. Collective.
    pub fn of(context: &FrameContext, ranks: &mut Ranks) -> Result<Self> {
        let FrameContext { renderer, scene, plan, part, start, .. } = *context;
        let (processes, mates) = (ranks.node_size(), context.mates.map_or(1, |mates| mates.mates().len()));
        let counted = CountedColumns::new(part, context.mates);
        let own_range =
            |field: &PreparedField| field.field().range_over(Some(&|cell| counted.has(Location::Center, cell)));
        let own_ranges = || {
            check_memory(context, processes, mates)?;
            Ok(match (part, context.mates) {
                (None, None) => vec![context.range(0)],
                (Some(_), None) => vec![own_range(&context.fields[0])],
                (_, Some(_)) => context.fields.iter().map(own_range).collect(),
            })
        };
        let ranges = reduce_parts(
            ranks,
            counted,
            || renderer.run(own_ranges),
            |a, b| a.into_iter().zip(b).map(|(a, b)| both_ranges(a, b)).collect(),
        )?;
        // Ranks that share a part divide its rays; those with other parts trace the same rays.
        let sharers = part.map_or(ranks.size(), |part| part.node().mates().len());
        let deadline = Deadline::of(scene, start, sharers);
        let mut quality = requested_quality(scene);
        if let (Some(deadline), true) = (deadline, plan.shading.is_some()) {
            let some = || match context.fields[0].field().samples() {
                Reals::F32(data) => some_gradients(context, data),
                Reals::F64(data) => some_gradients(context, data),
            };
            let has_time = || !context.needs_scene() || deadline.has_time_for_gradients(mates as f64 / 64.0, some);
            let is_root = ranks.is_root();
            let has_time = ranks.attempt(|| renderer.run(|| Ok(!is_root || has_time())));
            let mine = has_time.map(|has_time| match has_time {
                true => quality,
                false => Quality { lights: Lights::Off, ..quality },
            });
            quality = ranks.agree_on(mine, Vec::new())?;
        }
        Ok(FieldSummary { ranges, quality, deadline })
    }

    /// The range of the first field's values, of all ranks, and the number of missing ones.
    pub fn first(&self) -> RangeAndMissing {
        self.ranges[0]
    }

    /// The range of a field's values.
    pub fn range(&self, context: &FrameContext, number: usize) -> Option<[f64; 2]> {
        self.ranges.get(number).map_or_else(|| context.range(number), |range| *range).0
    }

    pub fn is_lit(&self) -> bool {
        self.quality.lights != Lights::Off
    }
}

/// Computes gradients over a 64th of the cells, whose time is measured. If there is no memory for them, the frame
/// itself reports that.
fn some_gradients<S: PreparedSample>(context: &FrameContext, data: &[S]) {
    let FrameContext { scene, plan, grid, .. } = *context;
    let samples = &Samples::new(data, &context.fields[0].field(), plan.falling, [0.0, 1.0]);
    let wanted = GradientOptions { single: plan.allows_single_gradients(scene), ..GradientOptions::default() };
    let cells = 0..grid.cells().div_ceil(64);
    drop(gradient::gradients(grid, &plan.radius, samples, cells, wanted, Gradients::none()));
}

/// Checks that the memory of the frame, in each of a node's `processes`, is within the limit, where gradients and visible
/// blocks are once in `mates` of them.
pub(super) fn check_memory(context: &FrameContext, processes: usize, mates: usize) -> Result<()> {
    let FrameContext { renderer, scene, plan, grid, part, .. } = *context;
    if !context.needs_scene() {
        return Ok(());
    }
    let fits = |counts_cells: bool| {
        let all = plan.memory_with(scene, grid, part.is_some(), renderer.savings, counts_cells);
        let missing = renderer.frame_cache.missing(all);
        let [gradients, occupancy] = [missing.gradients, missing.occupancy].map(|bytes| bytes.div_ceil(mates as u64));
        let missing = FrameMemory { gradients, occupancy, ..missing };
        missing.require(renderer.memory_limit, processes)
    };
    // Counts cells only if gradients at all of them do not fit.
    fits(false).or_else(|_| fits(true))
}
