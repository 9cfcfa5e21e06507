//! Gradients as a stencil over a cell and its ring, in single precision, 16 layers of a column at a time.
//!
//! With the ring's weights w and the radial vector e (`ring.rs`), the gradient at radius R is `Σ w (g - gA)/R + s e`,
//! where s is the radial slope. The values are subtracted first, in their stored precision: a difference has an error
//! of at most half its own last digit, for values of any size. So each gradient differs from that in double precision
//! by a few roundings of the largest of its terms.
//!
//! A vector is *rejected* if a sample in it is missing, or a sum exceeds the range of a float. That makes the gradient
//! NaN, infinite or longer than [`LONGEST`], unless the mark of missing values is a number, with which samples are
//! compared. Layers beside a missing value are evaluated again in double precision. The rejected layers, and so all
//! gradients, depend on the samples alone, not on the wanted layers.

use super::LONGEST;
use super::ring::{MAX_NEIGHBORS, RingWeights};
use super::storage::GradientFormat;
use crate::array::MapInline;
use crate::grid::Grid;
use crate::sample::{Sample, VECTOR};
use crate::samples::Samples;
use fearless_simd::{Simd, f32x16, mask32x16, prelude::*};
use icoray_simd::Table;
use std::ops::Range;

/// Number of neighbours of almost all cells of a geodesic grid.
const USUAL_NEIGHBORS: usize = 6;

/// The stencil of a field's gradients. Layers are counted in the order of the array: from the outermost one inwards if
/// the field's layers fall.
pub(super) struct Stencil<'a, S> {
    samples: &'a Samples<'a, S>,
    layers: usize,
    is_falling: bool,
    /// Whether columns are read in place instead of copied.
    is_contiguous: bool,
    fill: Option<S>,
    /// Factors of the ring's weights, and of differences that are not single.
    scale: [f64; 2],
    inverse_radius: Vec<f32>,
    /// Factors of the differences to the layers before and behind in the radial slope.
    before: Vec<f32>,
    behind: Vec<f32>,
}

/// Memory of a thread, and the layers that a cell's stencil left out.
#[derive(Default)]
pub(super) struct Scratch<S> {
    columns: Vec<S>,
    /// The range that contains all rejected layers; empty if there is none.
    pub rejected: Range<usize>,
    is_rejected: Vec<bool>,
}

impl<S> Scratch<S> {
    /// Whether the gradient at `layer` is to be evaluated in double precision.
    pub fn is_rejected(&self, layer: usize) -> bool {
        self.is_rejected[layer]
    }

    fn reject(&mut self, layer: usize, layers: usize) {
        if self.rejected.is_empty() {
            self.is_rejected.clear();
            self.is_rejected.resize(layers, false);
            self.rejected = layer..layer + 1;
        }
        self.is_rejected[layer] = true;
        self.rejected = self.rejected.start.min(layer)..self.rejected.end.max(layer + 1);
    }
}

impl<'a, S: Sample> Stencil<'a, S> {
    /// `None` if the field's range is too narrow or too wide for gradients in single precision.
    pub fn new(samples: &'a Samples<S>, radius: &[f64]) -> Option<Self> {
        const WIDEST: f64 = 1e25;
        let scale = samples.mapping.scale;
        if !(1.0 / WIDEST..WIDEST).contains(&scale.abs()) {
            return None;
        }
        let layers = radius.len();
        let stride = samples.mapping.elements.layer_stride();
        let is_contiguous = stride.unsigned_abs() == 1 && layers >= VECTOR;
        let is_falling = is_contiguous && stride < 0;
        let scale = if S::IS_SINGLE { [scale, 1.0] } else { [1.0, scale] };
        // The slope between two layers counts half, except beside the innermost and the outermost one.
        let gap = |low: usize| 1.0 / (radius[low + 1] - radius[low]);
        let share = |layer: usize| if layer == 0 || layer + 1 == layers { 1.0 } else { 0.5 };
        let below = |layer: usize| if layer > 0 { share(layer) * gap(layer - 1) } else { 0.0 };
        let above = |layer: usize| if layer + 1 < layers { share(layer) * gap(layer) } else { 0.0 };
        let in_order = |of: &dyn Fn(usize) -> f64| {
            let layer = |k: usize| if is_falling { layers - 1 - k } else { k };
            let mut all: Vec<f32> = (0..layers).map(|k| of(layer(k)) as f32).collect();
            all.resize(layers.max(VECTOR), 0.0);
            all
        };
        let negative_above = |layer: usize| -above(layer);
        let negative_below = |layer: usize| -below(layer);
        let [before, behind] = if is_falling {
            [in_order(&negative_above), in_order(&negative_below)]
        } else {
            [in_order(&below), in_order(&above)]
        };
        Some(Stencil {
            samples,
            layers,
            is_falling,
            is_contiguous,
            fill: samples.mapping.fill(),
            scale,
            inverse_radius: in_order(&|layer| 1.0 / radius[layer]),
            before,
            behind,
        })
    }

    /// The weights of a cell's ring; `None` if the stencil does not apply to it.
    #[inline(always)]
    pub fn ring(&self, grid: &Grid, cell: u32) -> Option<RingWeights> {
        RingWeights::of(grid, cell, self.scale[0])
    }

    /// Starts to fetch the samples of a ring on layers `wanted` into the cache: their columns are apart in memory.
    #[inline(always)]
    pub fn prefetch(&self, ring: &RingWeights, wanted: &Range<usize>) {
        const CACHE_LINE: usize = 64;
        if !self.is_contiguous {
            return;
        }
        let Range { start, end } = *wanted;
        let elements = if self.is_falling { self.layers - end..self.layers - start } else { start..end };
        for cell in &ring.neighbours[..ring.count] {
            if let Some(column) = Table::new(self.samples.column(*cell, self.layers)) {
                for element in elements.clone().step_by(CACHE_LINE / size_of::<S>()) {
                    column.prefetch(element as u32);
                }
            }
        }
    }

    /// Computes the gradients on layers `wanted`, not empty, over a cell with its ring, in its `row`, except those that
    /// `scratch` marks as rejected.
    #[inline(always)]
    pub fn fill<V: Simd, F: GradientFormat>(
        &self,
        simd: V,
        scratch: &mut Scratch<S>,
        cell: u32,
        weights: &RingWeights,
        wanted: Range<usize>,
        row: &mut [F],
    ) {
        scratch.rejected = 0..0;
        let mut columns = std::mem::take(&mut scratch.columns);
        let own = [cell];
        let cells = own.iter().chain(&weights.neighbours[..weights.count]);
        if !self.is_contiguous {
            self.copy(cells.copied(), &mut columns);
        }
        let column = |number: usize, cell: u32| -> &[S] {
            if self.is_contiguous {
                self.samples.column(cell, self.layers)
            } else {
                let size = self.inverse_radius.len();
                &columns[number * size..][..size]
            }
        };
        let own = column(0, cell);
        let mut around = [own; MAX_NEIGHBORS];
        for (k, (around, neighbour)) in around.iter_mut().zip(weights.neighbours).take(weights.count).enumerate() {
            *around = column(k + 1, neighbour);
        }
        let pass = Pass { stencil: self, weights, own, wanted };
        match (self.fill, weights.count <= USUAL_NEIGHBORS) {
            (None, true) => pass.fill::<V, F, USUAL_NEIGHBORS, false>(simd, &around, scratch, row),
            (None, false) => pass.fill::<V, F, MAX_NEIGHBORS, false>(simd, &around, scratch, row),
            (Some(_), true) => pass.fill::<V, F, USUAL_NEIGHBORS, true>(simd, &around, scratch, row),
            (Some(_), false) => pass.fill::<V, F, MAX_NEIGHBORS, true>(simd, &around, scratch, row),
        }
        scratch.columns = columns;
    }

    /// Copies the columns of cells one behind the other, from the innermost layer outwards, each followed by zeros up to
    /// a whole vector.
    #[inline(never)]
    fn copy(&self, cells: impl Iterator<Item = u32>, columns: &mut Vec<S>) {
        columns.clear();
        for cell in cells {
            let base = self.samples.base(cell);
            columns.extend((0..self.layers).map(|layer| self.samples.sample(base, layer)));
            columns.resize(columns.len() + self.inverse_radius.len() - self.layers, S::default());
        }
    }
}

/// A cell's stencil.
struct Pass<'p, 's, S> {
    stencil: &'p Stencil<'s, S>,
    weights: &'p RingWeights,
    own: &'p [S],
    wanted: Range<usize>,
}

impl<S: Sample> Pass<'_, '_, S> {
    /// Processes all vectors that cover the wanted layers and one more at either end, in which a missing value would
    /// count.
    #[inline(always)]
    fn fill<V: Simd, F: GradientFormat, const N: usize, const HAS_FILL: bool>(
        &self,
        simd: V,
        around: &[&[S]; MAX_NEIGHBORS],
        scratch: &mut Scratch<S>,
        row: &mut [F],
    ) {
        let (layers, size) = (self.stencil.layers, self.own.len());
        let read = self.wanted.start.saturating_sub(1)..(self.wanted.end + 1).min(layers);
        let read = if self.stencil.is_falling { layers - read.end..layers - read.start } else { read };
        let last = read.end.max(VECTOR) - VECTOR;
        let mut first = read.start.min(last);
        loop {
            let (gradients, is_rejected) = self.vector::<V, N, HAS_FILL>(simd, around, first);
            self.store(simd, gradients, first, row);
            if is_rejected.any_true() {
                self.reject(is_rejected.to_bitmask() as u32, first, scratch);
            }
            if first == last {
                break;
            }
            first = (first + VECTOR).min(last);
        }
        assert!(last + VECTOR <= size);
    }

    /// The gradients on 16 layers from `first` on, and a mask of the rejected ones.
    #[inline(always)]
    fn vector<V: Simd, const N: usize, const HAS_FILL: bool>(
        &self,
        simd: V,
        around: &[&[S]; MAX_NEIGHBORS],
        first: usize,
    ) -> ([f32x16<V>; 3], mask32x16<V>) {
        let Stencil { fill, scale: [_, scale], ref inverse_radius, ref before, ref behind, .. } = *self.stencil;
        let factors = |of: &[f32]| f32x16::load_array_ref(simd, vector_at(of, first));
        let own = S::load(simd, vector_at(self.own, first));
        let preceding = match first.checked_sub(1) {
            Some(first) => S::load(simd, vector_at(self.own, first)),
            None => S::preceding(simd, own),
        };
        let following = match first + VECTOR < self.own.len() {
            true => S::load(simd, vector_at(self.own, first + 1)),
            false => S::following(simd, own),
        };
        let slope = S::difference(simd, own, preceding, scale) * factors(before);
        let slope = S::difference(simd, following, own, scale).mul_add(factors(behind), slope);
        let zero = f32x16::splat(simd, 0.0);
        let mut along = [zero; 3];
        let mut is_missing = match (HAS_FILL, fill) {
            (true, Some(fill)) => S::equals(simd, own, fill),
            _ => mask32x16::splat(simd, false),
        };
        for (column, weights) in around.iter().zip(&self.weights.along).take(N) {
            let neighbour = S::load(simd, vector_at(column, first));
            let difference = S::difference(simd, neighbour, own, scale);
            for (sum, weight) in along.iter_mut().zip(*weights) {
                *sum = difference.mul_add(weight, *sum);
            }
            if let (true, Some(fill)) = (HAS_FILL, fill) {
                is_missing |= S::equals(simd, neighbour, fill);
            }
        }
        let inverse_radius = factors(inverse_radius);
        let mut gradients = [zero; 3];
        for k in 0..3 {
            gradients[k] = slope.mul_add(self.weights.radial[k], along[k] * inverse_radius);
        }
        let [x, y, z] = gradients;
        let is_short = (x.abs() + y.abs() + z.abs()).simd_le(LONGEST as f32);
        (gradients, is_missing | !is_short)
    }

    /// Stores the wanted ones of 16 gradients, the innermost first.
    #[inline(always)]
    fn store<V: Simd, F: GradientFormat>(&self, simd: V, gradients: [f32x16<V>; 3], first: usize, row: &mut [F]) {
        let Stencil { layers, is_falling, .. } = *self.stencil;
        let (gradients, first) = match is_falling {
            true => (
                gradients.map_inline(
                    #[inline(always)]
                    |component| component.reverse(),
                ),
                layers - first - VECTOR,
            ),
            false => (gradients, first),
        };
        let wanted = self.wanted.start.max(first)..self.wanted.end.min(first + VECTOR);
        if wanted.len() == VECTOR
            && let Some(row) = row[first..].first_chunk_mut()
        {
            F::store(simd, gradients, row);
        } else if !wanted.is_empty() {
            let mut stored = [F::default(); VECTOR];
            F::store(simd, gradients, &mut stored);
            row[wanted.clone()].copy_from_slice(&stored[wanted.start - first..wanted.end - first]);
        }
    }

    #[cold]
    fn reject(&self, bits: u32, first: usize, scratch: &mut Scratch<S>) {
        let Stencil { layers, is_falling, .. } = *self.stencil;
        for layer in (0..VECTOR).filter(|k| bits >> k & 1 != 0).map(|k| first + k).filter(|layer| *layer < layers) {
            scratch.reject(if is_falling { layers - 1 - layer } else { layer }, layers);
        }
    }
}

/// The 16 elements from `first` on.
#[inline(always)]
fn vector_at<X>(all: &[X], first: usize) -> &[X; VECTOR] {
    all[first..].first_chunk().expect("columns are as long as a vector or longer")
}
