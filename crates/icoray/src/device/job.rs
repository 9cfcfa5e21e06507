//! A picture's rays, prepared for a device.

use super::{BudgetTable, ENDLESS, NativeLayers, Scenery, Shading, Span, Step};
use crate::plan::Plan;
use crate::plan::budget::allowed;
use crate::raster::{Raster, Rect};
use icoray_grid::gradient::Gradients;
use icoray_grid::real::Real;
use icoray_grid::sample::Sample;
use icoray_grid::samples::Samples;
use icoray_grid::{Field, Grid, Reals};
use icoray_kernel::FAINTEST;
use icoray_kernel::transfer::{self, KernelKnot};
use icoray_scene::{Lights, Quality, Scene};
use std::fmt;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// The gradients of a job's field, computed on the first call.
pub(crate) trait GradientSource: fmt::Debug + Sync {
    fn gradients(&self) -> &Gradients<'_>;
}

/// A set of a picture's tiles to be traced.
#[derive(Debug)]
pub struct Job<'f> {
    number: u64,
    scene: &'f Scene,
    plan: &'f Plan,
    grid: &'f Grid<'f>,
    field: &'f Field<'f>,
    gradients: &'f dyn GradientSource,
    is_part: bool,
    has_ground: bool,
    scenery: Option<Scenery>,
    spans: transfer::Spans<f32>,
    quality: Quality,
    raster: Raster,
    tiles: Vec<u32>,
}

/// Identifies the values of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Content {
    field: u64,
    range: [u64; 2],
    falling: bool,
    is_bounded: bool,
}

impl<'f> Job<'f> {
    /// A job without tiles, with a new number.
    pub(crate) fn new(
        scene: &'f Scene,
        plan: &'f Plan,
        grid: &'f Grid<'f>,
        field: &'f Field<'f>,
        gradients: &'f dyn GradientSource,
        quality: Quality,
        is_part: bool,
    ) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let spans = transfer::Spans::new(&KernelKnot::of(&scene.volumes[0].transfer, plan.thickness()));
        let raster = Raster { width: scene.width, height: scene.height, step: 1 };
        let (has_ground, scenery, tiles) = (false, None, Vec::new());
        Job { number, scene, plan, grid, field, gradients, is_part, has_ground, scenery, spans, quality, raster, tiles }
    }

    /// This job for a scene of more than one volume, or with a ground of several colours.
    pub(crate) fn with(self, scenery: Option<Scenery>, has_ground: bool) -> Self {
        Job { scenery, has_ground, ..self }
    }

    /// Sets the quality and the tiles to trace of the same picture.
    pub(crate) fn ask(&mut self, quality: &Quality, raster: Raster, tiles: &[u32]) {
        self.quality = Quality { pixel_step: raster.step, ..*quality };
        self.raster = raster;
        self.tiles.clear();
        self.tiles.extend_from_slice(tiles);
    }

    /// The picture's number: jobs with the same number have the same scene, grid, field and gradients, and no other job
    /// of the process has it. Quality and tiles may differ.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// The scene. Its tolerance and light are those of [`Self::quality`].
    pub fn scene(&self) -> &'f Scene {
        self.scene
    }

    /// The grid.
    pub fn grid(&self) -> &'f Grid<'f> {
        self.grid
    }

    /// Gradients at the vertices, level-fastest, from the innermost layer outwards; empty if the picture is drawn
    /// without light. Computed on the first call.
    pub fn gradients(&self) -> &'f [[f32; 3]] {
        self.gradients.gradients().whole()
    }

    /// Whether the grid is a rank's part of a larger one. Gradients at the cells of its halo are then those of other
    /// ranks: a device cannot compute them, and takes [`Self::gradients`].
    pub fn is_part(&self) -> bool {
        self.is_part
    }

    /// Whether a device takes [`Self::gradients`]: it computes only those of whole grids with concentric layers.
    pub fn has_gradients(&self) -> bool {
        self.is_part || self.native().is_some()
    }

    fn native(&self) -> Option<&NativeLayers> {
        self.scenery.as_ref().and_then(|scenery| scenery.native.as_ref())
    }

    /// Least and greatest radius of the visible space, planet radii.
    pub fn extent(&self) -> [f64; 2] {
        let radius = self.radius();
        self.native().map_or([radius[0], radius[radius.len() - 1]], |native| [native.core_radius[0], native.outer])
    }

    /// Whether the light of the core is computed by the host.
    pub fn has_ground(&self) -> bool {
        self.has_ground
    }

    /// Whether the host computes the light of the core or of lines on layers: then rays are traced as fragments, in
    /// [`Device::fragments`](super::Device::fragments).
    pub fn is_painted(&self) -> bool {
        let mut layers = self.scenery.iter().flat_map(|scenery| &scenery.surface_layers);
        self.has_ground || layers.any(|layer| layer.is_painted)
    }

    /// The parts of the scene beside the volume and the core; `None` if there are none.
    pub fn scenery(&self) -> Option<&Scenery> {
        self.scenery.as_ref()
    }

    /// Transmittance above which a surface behind counts in a ray's signature ([`BoundarySignature`]).
    ///
    /// [`BoundarySignature`]: super::BoundarySignature
    pub fn sees_above(&self) -> f32 {
        FAINTEST as f32
    }

    /// Tolerance and method of the frame.
    pub fn quality(&self) -> &Quality {
        &self.quality
    }

    /// The pixels to trace.
    pub fn tiles(&self) -> impl ExactSizeIterator<Item = Rect> + '_ {
        self.tiles.iter().map(|tile| self.raster.rect(*tile))
    }

    /// The raster of [`Self::tiles`].
    pub(crate) fn raster(&self) -> &Raster {
        &self.raster
    }

    /// Numbers of [`Self::tiles`] in the raster.
    pub(crate) fn numbers(&self) -> &[u32] {
        &self.tiles
    }

    /// Radii of the layers, planet radii, rising; mean ones if the scene has native heights.
    pub fn radius(&self) -> &[f64] {
        &self.plan.radius
    }

    /// The transfer function, in rising order.
    pub fn spans(&self) -> Vec<Span> {
        self.spans.all().to_vec()
    }

    /// The discontinuities of the transfer function, in rising order.
    pub fn steps(&self) -> &[Step] {
        self.spans.steps()
    }

    /// The shading, if rays are traced with light.
    pub fn shading(&self) -> Option<Shading> {
        self.plan.shading.filter(|_| self.quality.lights != Lights::Off)
    }

    /// Division of the tolerance along a ray.
    pub fn allowed(&self) -> BudgetTable {
        let budget = allowed(self.scene, &self.quality);
        BudgetTable {
            color_tolerance: budget.color_tolerance_in::<f32>(self.shading().as_ref()) as f32,
            min_transmittance: budget.min_transmittance as f32,
            brightest: budget.brightest as f32,
        }
    }

    /// Columns and layers of the field, and whether its array is level-fastest (`true`) or cell-fastest.
    pub fn order(&self) -> (usize, usize, bool) {
        let shape = self.field.shape();
        let is_level_fastest = shape.layer_stride.unsigned_abs() <= shape.column_stride.unsigned_abs();
        (shape.columns, shape.layers, is_level_fastest)
    }

    /// Identifies the result of [`Self::values`]: equal for jobs with equal values.
    pub fn content(&self) -> Content {
        let range = self.spans.range().map(f64::to_bits);
        Content { field: self.field.number(), range, falling: self.plan.falling, is_bounded: self.is_bounded() }
    }

    /// Writes normalised values over some columns on some layers, counted from the innermost, packed in the order of
    /// [`Self::order`], from number `first` on. Missing ones are [`ENDLESS`].
    ///
    /// # Panics
    /// If there is no such column, layer or number.
    pub fn values(&self, columns: &[u32], layers: Range<usize>, first: usize, values: &mut [f32]) {
        let is_bounded = self.is_bounded();
        let is_missing = |value: f64| value.is_nan() || (is_bounded && value.is_infinite());
        let narrow = |value: f64| if is_missing(value) { ENDLESS } else { narrowed(value) };
        match self.field.samples() {
            Reals::F32(data) => self.read(data, columns, layers, first, values, narrow),
            Reals::F64(data) => self.read(data, columns, layers, first, values, narrow),
        }
    }

    /// Whether infinite values count as missing, as in scenes of several volumes.
    fn is_bounded(&self) -> bool {
        self.scenery.as_ref().is_some_and(|scenery| !scenery.volumes.is_empty())
    }

    /// The rounding residuals of [`Self::values`], for devices that compute differences of values: 32,767 stands for
    /// 2^-24 of the value.
    ///
    /// # Panics
    /// As [`Self::values`].
    pub fn residuals(&self, columns: &[u32], layers: Range<usize>, first: usize, residuals: &mut [i16]) {
        let residual = |value: f64| {
            let rounded = f64::from(narrowed(value));
            let part = (value - rounded) / (f32::ROUNDING * rounded.abs());
            // Clamped and missing values have no residual.
            if part.abs() <= 1.0 { (part * f64::from(i16::MAX)).round() as i16 } else { 0 }
        };
        match self.field.samples() {
            Reals::F32(data) => self.read(data, columns, layers, first, residuals, residual),
            Reals::F64(data) => self.read(data, columns, layers, first, residuals, residual),
        }
    }

    fn read<S: Sample, V>(
        &self,
        data: &[S],
        columns: &[u32],
        layers: Range<usize>,
        first: usize,
        values: &mut [V],
        of: impl Fn(f64) -> V,
    ) {
        let samples = Samples::new(data, self.field, self.plan.falling, self.spans.range());
        let (_, _, is_level_fastest) = self.order();
        let row = if is_level_fastest { layers.len() } else { columns.len() };
        let (mut slow, mut fast, mut rest) = (first / row.max(1), first % row.max(1), values);
        while !rest.is_empty() {
            let (run, others) = rest.split_at_mut(rest.len().min(row - fast));
            if is_level_fastest {
                let base = samples.base(columns[slow]);
                let run = run.iter_mut().zip(layers.start + fast..);
                run.for_each(|(value, layer)| *value = of(samples.get(base, layer)));
            } else {
                let layer = layers.start + slow;
                let run = run.iter_mut().zip(&columns[fast..]);
                run.for_each(|(value, column)| *value = of(samples.get(samples.base(*column), layer)));
            }
            (slow, fast, rest) = (slow + 1, 0, others);
        }
    }
}

/// A normalised value as f32 kernels store it: clamped.
fn narrowed(value: f64) -> f32 {
    value.clamp(-f32::LARGEST, f32::LARGEST) as f32
}
