//! A picture's rays, prepared for a device.

use super::{Allowed, ENDLESS, Span};
use crate::field::Field;
use crate::grid::{Grid, Reals};
use crate::kernel::Real;
use crate::kernel::ray::Budget;
use crate::kernel::sample::{Sample, Samples};
use crate::kernel::transfer;
use crate::plan::Plan;
use crate::quality::Quality;
use crate::raster::Raster;
use crate::render::brightest;
use crate::scene::Scene;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is to be traced: some tiles of a picture.
#[derive(Debug)]
pub struct Job<'f> {
    number: u64,
    scene: &'f Scene,
    pub(super) plan: &'f Plan,
    grid: &'f Grid<'f>,
    field: &'f Field<'f>,
    gradients: &'f [[f32; 3]],
    spans: transfer::Spans<f32>,
    quality: Quality,
    raster: Raster,
    tiles: Vec<u32>,
}

/// A rectangle of traced pixels: from the first to before the last in each direction, counted in steps of
/// [`Quality::pixel_step`] pixels. The last one of a picture's row or column may come after a shorter step: node `i` of a side
/// is its pixel `min(i · step, side - 1)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rect {
    /// First column.
    pub left: u32,
    /// First row.
    pub top: u32,
    /// How many columns.
    pub width: u32,
    /// How many rows.
    pub height: u32,
}

impl Rect {
    /// How many pixels.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }
}

impl<'f> Job<'f> {
    /// A job without tiles, with a number of its own.
    pub(crate) fn new(
        scene: &'f Scene,
        plan: &'f Plan,
        grid: &'f Grid<'f>,
        field: &'f Field<'f>,
        gradients: &'f [[f32; 3]],
        quality: Quality,
    ) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let spans = transfer::Spans::new(&plan.knots);
        let raster = Raster { width: scene.width, height: scene.height, step: 1 };
        Job { number, scene, plan, grid, field, gradients, spans, quality, raster, tiles: Vec::new() }
    }

    /// The same picture's tiles `tiles`, in a quality.
    pub(crate) fn ask(&mut self, quality: &Quality, raster: Raster, tiles: &[u32]) {
        self.quality = Quality { pixel_step: raster.step, ..*quality };
        self.raster = raster;
        self.tiles.clear();
        self.tiles.extend_from_slice(tiles);
    }

    /// The picture's: jobs of the same number have the same scene, grid, field and gradients, and no other job of the process
    /// has it. Quality and tiles may differ.
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

    /// Gradients at the vertices, level-fastest, from the innermost layer outwards; empty where the picture is drawn without
    /// light.
    pub fn gradients(&self) -> &'f [[f32; 3]] {
        self.gradients
    }

    /// What rays are traced with.
    pub fn quality(&self) -> &Quality {
        &self.quality
    }

    /// What is to be traced.
    pub fn tiles(&self) -> impl ExactSizeIterator<Item = Rect> + '_ {
        self.tiles.iter().map(|tile| self.raster.rect(*tile))
    }

    /// Numbers of [`Self::tiles`] in the raster.
    pub(crate) fn numbers(&self) -> &[u32] {
        &self.tiles
    }

    /// Radii of the layers, planet radii, rising.
    pub fn radius(&self) -> &[f64] {
        &self.plan.radius
    }

    /// The transfer function, in rising order.
    pub fn spans(&self) -> Vec<Span> {
        self.spans.all().iter().map(Span::of).collect()
    }

    /// Where it jumps: normalised value, and the larger extinction of the two sides. In rising order.
    pub fn steps(&self) -> Vec<[f32; 2]> {
        self.spans.steps().iter().map(|step| [step.value, step.extinction]).collect()
    }

    /// What rays may spend.
    pub fn allowed(&self) -> Allowed {
        let budget = Budget::new(self.quality.tolerance, brightest(self.scene));
        let share = budget.share.max(f32::ROUNDING) as f32;
        Allowed { share, rest: budget.rest as f32, brightest: budget.brightest as f32 }
    }

    /// The field's values packed, in the order that its array has: a column's layers side by side, or a layer's columns.
    /// Columns, layers, and whether it is the former.
    pub fn order(&self) -> (usize, usize, bool) {
        let shape = self.field.shape();
        let is_level_fastest = shape.layer_stride.unsigned_abs() <= shape.column_stride.unsigned_abs();
        (shape.columns, shape.layers, is_level_fastest)
    }

    /// Normalised values from number `first` on in the order of [`Self::order`], from the innermost layer outwards; missing
    /// ones are [`ENDLESS`].
    pub fn values(&self, first: usize, values: &mut [f32]) {
        match self.field.samples() {
            Reals::F32(data) => self.read(data, first, values),
            Reals::F64(data) => self.read(data, first, values),
        }
    }

    fn read<S: Sample>(&self, data: &[S], first: usize, values: &mut [f32]) {
        const PIECE: usize = 4096;
        let samples = Samples::new(data, self.field, self.plan.falling, self.spans.range());
        let (columns, layers, is_level_fastest) = self.order();
        let row = if is_level_fastest { layers } else { columns };
        values.par_chunks_mut(PIECE).enumerate().for_each(|(i, piece)| {
            let start = first + i * PIECE;
            let (mut slow, mut fast) = (start / row, start % row);
            for value in piece {
                let (column, layer) = if is_level_fastest { (slow, fast) } else { (fast, slow) };
                let known: f32 = samples.get(samples.base(column as u32), layer);
                *value = if known.is_nan() { ENDLESS } else { known };
                fast += 1;
                if fast == row {
                    (slow, fast) = (slow + 1, 0);
                }
            }
        });
    }
}
