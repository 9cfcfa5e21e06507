//! Levels of detail: pictures of values that were drawn before are traced on coarser grids, if the error that this adds
//! ([`Deviations`]) permits it, or if there is no time for the finest one.
//!
//! Levels are made for the second picture of the same values and transfer function without a time budget, for which no
//! picture with a budget waits, and only by renderers of pages and the like
//! ([`Renderer::with_levels`](super::Renderer::with_levels)): the first levels of a grid take as long as several
//! pictures.

use super::context::FrameContext;
use super::frame_cache::{FrameCache, SourceKey};
use super::prepared_field::PreparedField;
use super::work::Work;
use crate::plan::Plan;
use glam::DVec3;
use icoray_grid::deviation::GridPair;
use icoray_grid::{CellsOver, CoarseGrid, Field, Grid, Location, OwnedReals, Reals};
use icoray_kernel::transfer::KernelKnot;
use icoray_kernel::{Deviations, Tracer};
use icoray_scene::{Lights, Method, Precision, Quality};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// The level on which pictures are traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LevelChoice {
    /// The grid itself.
    Finest,
    /// The fastest one within the tolerance, or within the time budget.
    WithinTolerance,
    /// The one of this number, or the coarsest, whatever its error.
    Fixed(u32),
}

impl LevelChoice {
    /// Minimum number of cells of a level; a grid that has levels has eight times as many, as the level of a quarter of
    /// the cells is left out.
    fn min_cells(self) -> usize {
        if matches!(self, LevelChoice::Fixed(_)) { 100 } else { 8_000 }
    }
}

/// Level of a grid: a coarser grid.
#[derive(Debug)]
struct LevelGrid {
    coarse: CoarseGrid,
    over: CellsOver,
}

/// Values on a level.
#[derive(Debug)]
pub(super) struct Level {
    grid: Arc<LevelGrid>,
    values: OwnedReals,
    /// The number of the field.
    number: u64,
    layers: usize,
    deviations: Deviations,
    cache: FrameCache,
}

/// What the values of levels depend on.
#[derive(Debug, Clone, PartialEq)]
struct LevelKey {
    source: SourceKey,
    falling: bool,
    radius: Vec<f64>,
    knots: Vec<KernelKnot>,
}

/// Levels of the last grid and values.
#[derive(Debug, Default)]
pub(super) struct LevelCache(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    /// What levels for the last picture without a time budget would depend on.
    last: Option<LevelKey>,
    grid: Weak<()>,
    grids: Vec<Arc<LevelGrid>>,
    levels: Option<(LevelKey, Arc<[Level]>)>,
}

impl LevelCache {
    /// The levels of a picture's values, the finest first; none if the picture does not use them.
    pub fn levels(&self, context: &FrameContext, is_alone: bool) -> Arc<[Level]> {
        let FrameContext { scene, plan, grid, .. } = *context;
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if known.grid.strong_count() == 0 {
            (known.grids, known.levels) = (Vec::new(), None);
        }
        if !is_alone || !is_supported(context) {
            return Arc::default();
        }
        let source = context.fields[0].source(grid);
        let knots = KernelKnot::of(&scene.volumes[0].transfer, plan.thickness());
        let key = LevelKey { source, falling: plan.falling, radius: plan.radius.clone(), knots };
        let has_budget = scene.time_budget_ms.is_some();
        let was_drawn = !has_budget && known.last.replace(key.clone()).as_ref() == Some(&key);
        let choice = context.renderer.level_choice;
        match &known.levels {
            Some((of, levels)) if *of == key => return levels.clone(),
            _ if !was_drawn && choice == LevelChoice::WithinTolerance => return Arc::default(),
            _ => {}
        }
        if !known.grid.ptr_eq(&grid.lifetime_token()) {
            (known.grid, known.grids) = (grid.lifetime_token(), grids(grid, choice.min_cells()));
        }
        let levels: Arc<[Level]> = known.grids.iter().map(|of| Level::new(context, of.clone(), &key)).collect();
        known.levels = Some((key, levels.clone()));
        levels
    }
}

/// Whether a picture may be traced on levels: of one volume, in packets on the CPU.
fn is_supported(context: &FrameContext) -> bool {
    let FrameContext { renderer, scene, plan, grid, part, .. } = *context;
    let is_packed = renderer.vectors().is_some() && scene.method == Method::Exact && scene.precision == Precision::F32;
    let is_alone = scene.has_single_volume() && scene.volumes.len() == 1 && scene.volumes[0].opacity.is_none();
    renderer.level_choice != LevelChoice::Finest
        && renderer.memory_limit.is_none()
        && renderer.savings.reuse
        && context.device.is_err()
        && part.is_none()
        && context.heights.is_none()
        && is_packed
        && is_alone
        && scene.samples <= 1
        && plan.radius.len() > 1
        && grid.cells() > 8 * renderer.level_choice.min_cells()
}

/// The levels of a grid, of at least this number of cells, the finest first; fewer where no coarser mesh is found or
/// fits, and where most cells are at rims of holes, which stay.
fn grids(grid: &Grid, min_cells: usize) -> Vec<Arc<LevelGrid>> {
    let mut found: Vec<Arc<LevelGrid>> = Vec::new();
    let Ok(first) = CoarseGrid::new(grid) else { return found };
    loop {
        let below = found.last().map_or(&first, |level| &level.coarse);
        match CoarseGrid::new(below.grid()).map(|next| next.over(below.cells())) {
            Ok(coarse) if (min_cells..=below.grid().cells() / 2).contains(&coarse.grid().cells()) => {
                let over = CellsOver::new(grid, coarse.grid());
                found.push(Arc::new(LevelGrid { coarse, over }));
            }
            _ => return found,
        }
    }
}

impl Level {
    /// Copies the values of a picture's field at the cells of a level, and finds how far all others are from these.
    fn new(context: &FrameContext, grid: Arc<LevelGrid>, key: &LevelKey) -> Self {
        let field = context.fields[0].field();
        let (cells, layers) = (grid.coarse.cells(), key.radius.len());
        let mut values = vec![0.0; cells.len() * layers];
        let columns = values.par_chunks_exact_mut(layers).zip(cells);
        columns.for_each(|(column, cell)| field.read_column(*cell as usize, column));
        let values = match field.samples() {
            Reals::F32(_) => OwnedReals::F32(values.into_iter().map(|value| value as f32).collect()),
            Reals::F64(_) => OwnedReals::F64(values),
        };
        let pair = GridPair {
            fine: context.grid,
            field: if key.falling { field.upside_down() } else { field },
            radius: &key.radius,
            coarse: grid.coarse.grid(),
            cells,
            over: &grid.over,
        };
        let deviations = Deviations::new(&pair, &key.knots);
        Level { grid, values, number: field.number(), layers, deviations, cache: FrameCache::default() }
    }

    /// The plan of a picture on the level, and the values of the field of this name there.
    pub fn inputs(&self, fine: &Plan, name: &str) -> (Plan, PreparedField<'_>) {
        let field = Field::level_fastest(self.values.as_reals(), self.layers, Location::Center);
        let field = field.expect("the values were made for these layers").numbered(self.number);
        (fine.lifted(self.deviations.lift()), PreparedField::at_centers(name, field))
    }

    /// The context of a picture on the level, from its [inputs](Self::inputs).
    pub fn context<'f>(
        &'f self,
        fine: &FrameContext<'f>,
        (plan, field): &'f (Plan, PreparedField<'f>),
    ) -> FrameContext<'f> {
        FrameContext {
            plan,
            grid: self.grid.coarse.grid(),
            fields: std::slice::from_ref(field),
            deviations: Some(&self.deviations),
            cache: &self.cache,
            bytes_derived: self.bytes(),
            device: Err(None),
            ..*fine
        }
    }

    fn bytes(&self) -> usize {
        let LevelGrid { coarse, over } = &*self.grid;
        coarse.bytes() + over.bytes() + self.values.bytes() + self.deviations.bytes()
    }
}

/// The rays of a picture on a level.
pub(super) trait LevelRays: Sync {
    fn tracer(&self, quality: &Quality) -> Box<dyn Tracer + '_>;

    /// The error of a ray besides that of the tracer.
    fn error(&self, quality: &Quality, eye: DVec3, dir: DVec3) -> f64;
}

impl LevelRays for Work<'_, '_> {
    fn tracer(&self, quality: &Quality) -> Box<dyn Tracer + '_> {
        Work::tracer(self, quality)
    }

    /// What shades and lines on the ground differ by is not known.
    fn error(&self, quality: &Quality, eye: DVec3, dir: DVec3) -> f64 {
        let FrameContext { scene, deviations, .. } = *self.context;
        match deviations {
            _ if quality.lights != Lights::Off || self.ground.is_some() => f64::INFINITY,
            Some(deviations) => deviations.error_at_ends(eye, dir, scene.core.is_some()),
            None => 0.0,
        }
    }
}
