//! Computes range, visible blocks and gradients of a field before the first ray.

use super::context::FrameContext;
use super::frame_cache::{GradientKey, OccupancyKey};
use super::lazy::Lazy;
use super::work::requested_quality;
use crate::plan::{Circumstances, OccupancyTest, clear_values};
use crate::ranks::{Part, Ranks};
use crate::time_budget::Deadline;
use icoray_grid::Result;
use icoray_grid::gradient;
use icoray_grid::gradient::{GradientOptions, Gradients, PartialGradients, PreparedSample};
use icoray_grid::occupancy::OccupancyMask;
use icoray_grid::samples::{Samples, SearchedSample};
use icoray_kernel::transfer::Spans;
use icoray_scene::{Lights, Quality};

/// Range, missing values, quality and deadline of the first field.
pub(super) struct FieldSummary {
    pub value_range: Option<[f64; 2]>,
    pub missing_values: u64,
    /// The scene's quality, without light if there is no time for gradients.
    pub quality: Quality,
    pub deadline: Option<Deadline>,
}

impl FieldSummary {
    /// The summary of the first field. Collective.
    pub fn of<S: PreparedSample>(context: &FrameContext, ranks: &mut Ranks, samples: &Samples<S>) -> Result<Self> {
        let FrameContext { renderer, scene, plan, grid, part, start, .. } = *context;
        let range = ranks.attempt(|| {
            renderer.run(|| {
                check_memory(context)?;
                Ok(match part {
                    Some(part) => context.fields[0].field().range_over(Some(&|cell| part.counts(cell))),
                    None => context.range(0),
                })
            })
        });
        let mut range = ranks.collective(range)?;
        if part.is_some() {
            range = Part::whole_range(ranks, range)?;
        }
        let (value_range, missing_values) = range;
        // Ranks that share a part divide its rays; those with other parts trace the same rays.
        let sharers = part.map_or(ranks.size(), |part| part.mates().len());
        let deadline = Deadline::of(scene, start, sharers);
        let mut quality = requested_quality(scene);
        if let (Some(deadline), true) = (deadline, plan.shading.is_some()) {
            let some = || {
                let single = plan.allows_single_gradients(scene);
                let wanted = GradientOptions { visible: None, packed: false, single };
                let cells = 0..grid.cells().div_ceil(64);
                // A sample: if there is no memory for it, the frame itself reports that.
                drop(gradient::gradients(grid, &plan.radius, samples, cells, wanted, Gradients::none()));
            };
            let has_time = || !context.needs_gradients() || deadline.has_time_for_gradients(1.0 / 64.0, some);
            let is_root = ranks.is_root();
            let has_time = ranks.attempt(|| renderer.run(|| Ok(!is_root || has_time())));
            let mine = has_time.map(|has_time| match has_time {
                true => quality,
                false => Quality { lights: Lights::Off, ..quality },
            });
            quality = ranks.agree_on_quality(mine)?;
        }
        Ok(FieldSummary { value_range, missing_values, quality, deadline })
    }

    pub fn is_lit(&self) -> bool {
        self.quality.lights != Lights::Off
    }
}

/// The visible blocks of the field, with their cache key.
pub(super) fn occupancy<'f, S: SearchedSample>(
    context: &'f FrameContext,
    field_summary: &FieldSummary,
    spans: &Spans<f32>,
    samples: Samples<'f, S>,
) -> (OccupancyKey, Lazy<'f, OccupancyMask>) {
    let FrameContext { renderer, plan, grid, .. } = *context;
    let empty_space = renderer.savings.empty_space;
    let clear = if empty_space { clear_values(spans, &samples, field_summary.value_range) } else { Vec::new() };
    let bits = clear.iter().map(|range| range.map(|value| value.wide().to_bits()));
    let leaps = context.device.is_err() && context.part.is_none();
    let key =
        OccupancyKey { source: context.fields[0].source(grid), falling: plan.falling, clear: bits.collect(), leaps };
    let occupancy = OccupancyTest { grid, samples, layers: plan.radius.len(), clear, leaps };
    let asked = key.clone();
    let find = move || {
        let cached = renderer.frame_cache.visible.take(&asked);
        cached.unwrap_or_else(|memory| occupancy.visible(memory.unwrap_or_default()))
    };
    (key, Lazy::of(find))
}

/// The gradients for lighting, with their cache key; `None` without light.
///
/// They are computed in visible blocks only, over cells that rays can pass, and may be packed, unless other ranks need
/// those of halo cells or the picture is drawn by a device, which may leave any tile to the CPU.
pub(super) fn gradients<'f, S: PreparedSample>(
    context: &'f FrameContext,
    field_summary: &FieldSummary,
    samples: Samples<'f, S>,
    range: [f64; 2],
    (occupancy, visible): (&OccupancyKey, &'f Lazy<OccupancyMask>),
) -> (Option<GradientKey>, Lazy<'f, PartialGradients>) {
    let FrameContext { renderer, scene, plan, grid, part, .. } = *context;
    let is_own = context.device.is_err() && part.is_none();
    let savings = renderer.savings;
    let single = plan.allows_single_gradients(scene);
    let packed = is_own && savings.packing && single;
    let visible = (is_own && savings.gradients).then_some(visible);
    let key = GradientKey {
        source: context.fields[0].source(grid),
        falling: plan.falling,
        range,
        radius: plan.radius.clone(),
        packed,
        single,
        occupancy: visible.map(|_| occupancy.clone()),
        heights: None,
    };
    if !field_summary.is_lit() {
        return (None, Lazy::of(|| Gradients::none().into()));
    }
    let asked = key.clone();
    let compute = move || {
        let wanted = GradientOptions { visible: visible.map(Lazy::get), packed, single };
        let seen = visible.map(|_| plan.visible_cells(scene, grid));
        let known = renderer.frame_cache.known_gradients(&asked);
        known.with_cells(grid, &plan.radius, &samples, wanted, seen.as_ref())
    };
    (Some(key), Lazy::try_of(compute))
}

/// Checks that the memory of the frame is within the limit.
fn check_memory(context: &FrameContext) -> Result<()> {
    let FrameContext { renderer, scene, plan, grid, part, .. } = *context;
    if !context.needs_gradients() {
        return Ok(());
    }
    let with = Circumstances {
        is_lit: scene.lighting.is_some(),
        is_part: part.is_some(),
        has_packets: renderer.vectors().is_some(),
        savings: renderer.savings,
    };
    let fits = |counts_cells: bool| {
        let all = plan.memory_with(scene, grid, with, counts_cells);
        renderer.frame_cache.missing(all, grid).require(renderer.memory_limit)
    };
    // Counts cells only if gradients at all of them do not fit.
    fits(false).or_else(|_| fits(true))
}

/// Computes all that the CPU needs in any case, and receives gradients of halo cells from other ranks. Collective.
pub(super) fn complete(
    context: &FrameContext,
    ranks: &mut Ranks,
    visible: &Lazy<OccupancyMask>,
    gradients: &mut Lazy<PartialGradients>,
    is_lit: bool,
) -> Result<()> {
    let computed = ranks.attempt(|| {
        context.renderer.run(|| {
            if context.device.is_err() {
                visible.try_get()?;
                context.grid.make_half_edges()?;
            }
            if context.needs_gradients() {
                gradients.try_get()?;
            }
            Ok(())
        })
    });
    ranks.collective(computed)?;
    if let (Some(part), true) = (context.part, is_lit) {
        let layers = context.plan.radius.len();
        let all = gradients.get_mut().values_mut().whole_mut();
        part.fill_halo(ranks, all, |all, cell| &mut all[cell as usize * layers..][..layers])?;
    }
    Ok(())
}
