//! What a renderer on another device needs of the core, as plain numbers: the tables of a grid, a scene, the field's
//! values and gradients as the kernel reads them; and back, a frame made of what rays met there.
//!
//! Whatever a device does not do itself stays here, where the CPU renderer has it too: the plan, ranges, means of fields at
//! corners, what a pixel shows and how far it may be off. Everything is for `f32` kernels.

mod light;
pub mod mirror;

use crate::error::Result;
use crate::field::{CenterField, Field};
use crate::frame::{Counts, ErrorSummary, Frame, FrameReport};
use crate::grid::{Grid, Reals};
use crate::kernel::Real;
use crate::kernel::piece::Light;
use crate::kernel::ray::Budget;
use crate::kernel::sample::{Sample, Samples};
use crate::kernel::{transfer, walk};
use crate::layers::Layers;
use crate::plan::Plan;
use crate::render::{Renderer, asked, brightest, certainty, notes, shown};
use crate::scene::Scene;
use glam::DVec3;
use rayon::prelude::*;
use std::time::Instant;

pub use light::Shading;

/// Stands for a value that is missing, and for the ends of the outer spans: beyond all normalised values, which are held
/// within 1e15. A shader has no reliable NaN or infinity.
pub const ENDLESS: f32 = 3e38;

/// What a grid has beside the model's own tables ([`Grid::tables`]).
#[derive(Debug)]
pub struct Tables<'g> {
    /// Unit vectors of cells, and of synthetic points behind them.
    pub directions: &'g [[f64; 3]],
    /// A byte per row of `corner_cell`: two bits per vertex with the `corner_edge` column of the side opposite it, or 3 on the
    /// rim of a hole; bit 6 where the row winds clockwise; bit 7 where it is no triangle.
    pub seats: Vec<u8>,
    /// Void triangles: three vertices, and the triangles beyond the sides opposite them.
    pub void: Vec<[u32; 6]>,
    /// Sides on the rims of holes: triangle, vertex opposite, void triangle beyond. Sorted.
    pub rim: Vec<[u32; 3]>,
    /// A triangle that is there.
    pub start: u32,
}

impl<'g> Tables<'g> {
    /// Those of `grid`.
    pub fn of(grid: &'g Grid) -> Self {
        let (void, rim) = grid.closure_numbers();
        let seats = grid.seats().iter().map(|seats| seats.bits()).collect();
        Tables { directions: grid.directions(), seats, void, rim, start: grid.standing(0) }
    }
}

/// The triangle that holds the direction `target`, found from the triangle `from`; the nearer, the faster.
pub fn locate(grid: &Grid, from: u32, target: [f64; 3]) -> u32 {
    walk::locate(grid, from, DVec3::from_array(target))
}

/// Between two knots of the transfer function extinction and colour are linear in the normalised value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Values of the span, `low <= high`; infinite at the outer ends.
    pub low: f32,
    /// See `low`.
    pub high: f32,
    /// The value that slopes are measured from.
    pub anchor: f32,
    /// Per planet radius, at the anchor.
    pub extinction: f32,
    /// Its slope in the value.
    pub extinction_slope: f32,
    /// Linear RGB at the anchor.
    pub color: [f32; 3],
    /// Its slopes in the value.
    pub color_slope: [f32; 3],
    /// The largest of the slopes' sizes.
    pub steepest: f32,
    /// The largest channel at the span's ends.
    pub brightest: f32,
    /// Extinction is zero throughout.
    pub is_clear: bool,
}

/// What a ray may spend: `share` is the error of the colour per absorbed light, `rest` the transmittance at which a ray ends,
/// `brightest` the most that a channel can hold behind that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowed {
    /// See above.
    pub share: f32,
    /// See above.
    pub rest: f32,
    /// See above.
    pub brightest: f32,
}

/// What a ray met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Traced {
    /// Premultiplied linear RGB.
    pub color: [f32; 3],
    /// The part of what lies behind that is absorbed.
    pub absorbed: f32,
    /// How far a channel may be off, rounding apart.
    pub error: f32,
    /// Variance of rounding.
    pub variance: f32,
    /// Columns, frusta and void frusta.
    pub counts: [u32; 3],
}

/// A scene that is to be drawn of a grid and a field, prepared.
#[derive(Debug)]
pub struct Job<'f> {
    scene: &'f Scene,
    plan: Plan,
    field: Field<'f>,
    center: Option<CenterField>,
    spans: transfer::Spans<f32>,
    value_range: (Option<[f64; 2]>, u64),
    start: Instant,
}

impl<'f> Job<'f> {
    /// Plans `scene`; what is computed of the field is computed on the threads of `renderer`.
    ///
    /// # Errors
    /// As [`Plan::new`].
    pub fn new(
        renderer: &Renderer,
        scene: &'f Scene,
        grid: &Grid,
        layers: &Layers,
        field: &Field<'f>,
    ) -> Result<Self> {
        let start = Instant::now();
        let plan = Plan::new(scene, grid, layers, field)?;
        let average = || plan.from_corners.then(|| CenterField::average(grid, field)).transpose();
        let center = renderer.run(average)?;
        let value_range =
            renderer.run(|| center.as_ref().map_or_else(|| field.range(), |c| c.field().range()));
        let spans = transfer::Spans::new(&plan.knots);
        Ok(Job { scene, plan, field: *field, center, spans, value_range, start })
    }

    fn field(&self) -> Field<'_> {
        self.center.as_ref().map_or(self.field, CenterField::field)
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
        let budget = Budget::new(self.scene.tolerance, brightest(self.scene));
        let share = budget.share.max(f32::ROUNDING) as f32;
        Allowed { share, rest: budget.rest as f32, brightest: budget.brightest as f32 }
    }

    /// The field's values packed, in the order that its array has: a column's layers side by side, or a layer's columns.
    /// Columns, layers, and whether it is the former.
    pub fn order(&self) -> (usize, usize, bool) {
        let field = self.field();
        let shape = field.shape();
        let is_level_fastest = shape.layer_stride.unsigned_abs() <= shape.column_stride.unsigned_abs();
        (shape.columns, shape.layers, is_level_fastest)
    }

    /// Normalised values from number `first` on in the order of [`Self::order`], from the innermost layer outwards; missing
    /// ones are [`ENDLESS`].
    pub fn values(&self, first: usize, values: &mut [f32]) {
        match self.field().samples() {
            Reals::F32(data) => self.read(data, first, values),
            Reals::F64(data) => self.read(data, first, values),
        }
    }

    fn read<S: Sample>(&self, data: &[S], first: usize, values: &mut [f32]) {
        const PIECE: usize = 4096;
        let field = self.field();
        let samples = Samples::new(data, &field, self.plan.falling, self.spans.range());
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

    /// Seconds since the job was begun.
    pub fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// The frame of what the rays of all pixels met, row by row from the top; `None` where a ray missed the shell. Rays were
    /// begun `prepare_s` seconds after the job.
    ///
    /// # Panics
    /// When there are not as many as pixels.
    pub fn frame(self, traced: &[Option<Traced>], prepare_s: f64) -> Frame {
        let scene = self.scene;
        assert_eq!(traced.len(), scene.width as usize * scene.height as usize, "one ray per pixel");
        let mut counts = Counts::default();
        for met in traced.iter().flatten() {
            let [columns, frusta, void_frusta] = met.counts.map(u64::from);
            counts += Counts { rays: 1, columns, frusta, void_frusta, ..Counts::default() };
        }
        let brightest = brightest(scene);
        let light = |met: &Traced| Light {
            color: met.color,
            absorbed: met.absorbed,
            error: met.error,
            variance: met.variance,
        };
        let (pixels, error): (Vec<_>, Vec<_>) = traced
            .iter()
            .map(|met| shown(scene, brightest, met.as_ref().map(light)))
            .map(|pixel| (pixel.color, pixel.error))
            .unzip();
        let quality = asked(scene);
        let report = FrameReport {
            error: ErrorSummary::of(&error, certainty(scene, &quality)),
            prepare_s,
            render_s: self.seconds() - prepare_s,
            counts,
            value_range: self.value_range.0,
            missing_values: self.value_range.1,
            quality,
            derived_bytes: self.center.as_ref().map_or(0, CenterField::bytes),
            left_out: self.plan.left_out().to_vec(),
            ranks: 1,
            ..FrameReport::default()
        };
        Frame {
            width: scene.width,
            height: scene.height,
            pixels,
            error,
            field: scene.field.clone(),
            notes: notes(scene),
            stamp: Default::default(),
            report,
        }
    }
}
