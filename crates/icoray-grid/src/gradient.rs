//! Gradients at the vertices: the mean over the frusta around each (§3.5 of the paper).
//!
//! At vertex A of a frustum three slopes determine the interpolant's gradient G: along A, the change to the next layer;
//! along B - A and C - A, the changes to the neighbours on the same layer. With the dual basis e of these three
//! vectors, `G = s·eA + ((gB - gA)·eB + (gC - gA)·eC)/R`. The frusta above and below share the triangle, so the mean
//! over 12 frusta (10 at a pentagon, half of that on the innermost and outermost layer) is the mean over the triangles
//! with the mean of the two radial slopes. Frusta with a missing value are left out of the mean, and beside a hole
//! there are fewer of them.
//!
//! The mean is linear in the values: `stencil.rs` evaluates it in single precision, 16 layers at a time. `exact.rs`
//! evaluates it in double precision, also if frusta are left out.

use crate::error::Result;
use crate::grid::Grid;
use crate::occupancy::OccupancyMask;
use crate::sample::Sample;
use crate::samples::{Outside, Samples};
use crate::vectors::packets;
use crate::visible_cells::VisibleCells;
use fearless_simd::{Simd, dispatch};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

mod exact;
pub mod native;
mod partial;
mod ring;
mod stencil;
mod storage;
use exact::{NeighborColumns, Ring};
pub use partial::PartialGradients;
use stencil::{Scratch, Stencil};
use storage::GradientFormat;
pub use storage::Gradients;

/// Selects the gradients to compute, and the method.
#[derive(Debug, Clone, Copy, Default)]
pub struct GradientOptions<'w> {
    /// Computes only the gradients in visible blocks; all of them if it is `None`.
    pub visible: Option<&'w OccupancyMask<'w>>,
    /// Computes only those of cells that rays can pass; all of them if it is `None`.
    pub seen: Option<&'w VisibleCells>,
    /// Stores a gradient in 8 bytes instead of 12.
    pub packed: bool,
    /// Computes in single precision if no value is missing: several times as fast, with errors of a few roundings of
    /// the largest term of each mean.
    pub single: bool,
}

/// Cells per parallel task.
const BLOCK: usize = 64;

/// Cells between that whose gradients are computed and that whose columns start to be fetched.
const AHEAD: usize = 2;

/// Gradients of the normalised field at the vertices over `cells` (§3.5 of the paper), per planet radius,
/// level-fastest: `cells.len() * radius.len()` of them. `radius` are the layers' radii in planet radii, rising. A
/// gradient is zero if no frustum around its vertex has all its values. The result reuses `memory`, whose old values
/// remain at gradients that are not `wanted`. Parallel.
///
/// # Errors
/// [`ErrorKind::Memory`](crate::error::ErrorKind::Memory) if they do not fit.
pub fn gradients<S: PreparedSample>(
    grid: &Grid,
    radius: &[f64],
    samples: &Samples<S>,
    cells: Range<usize>,
    wanted: GradientOptions,
    memory: Gradients<'static>,
) -> Result<Gradients<'static>> {
    let mut gradients = memory.with_room(cells.len() * radius.len(), wanted.packed)?;
    S::fill_gradients(&GradientInput::new(grid, radius, samples, cells, wanted), &mut gradients, None);
    Ok(gradients)
}

/// A type of samples that are prepared for rays. As functions of the type these passes are compiled in this crate, and
/// not again, with other optimisations, in crates that use fields.
pub trait PreparedSample: Sample {
    /// Finds the layers with values outside of ranges.
    fn find_outside(samples: &Samples<Self>, outside: Outside<Self>);

    /// Computes gradients of memory of its own, but for those of cells that are marked as computed, and marks the cells.
    fn fill_gradients(input: &GradientInput<Self>, gradients: &mut Gradients, is_computed: Option<&mut [bool]>);
}

impl PreparedSample for f32 {
    fn find_outside(samples: &Samples<Self>, outside: Outside<Self>) {
        samples.find(outside);
    }

    fn fill_gradients(input: &GradientInput<Self>, gradients: &mut Gradients, is_computed: Option<&mut [bool]>) {
        input.fill_all(gradients, is_computed);
    }
}

impl PreparedSample for f64 {
    fn find_outside(samples: &Samples<Self>, outside: Outside<Self>) {
        samples.find(outside);
    }

    fn fill_gradients(input: &GradientInput<Self>, gradients: &mut Gradients, is_computed: Option<&mut [bool]>) {
        input.fill_all(gradients, is_computed);
    }
}

/// The inputs of gradients.
pub struct GradientInput<'a, S> {
    grid: &'a Grid<'a>,
    radius: &'a [f64],
    samples: &'a Samples<'a, S>,
    /// The first cell, and the number of consecutive cells.
    first: usize,
    cells: usize,
    visible: Option<&'a OccupancyMask<'a>>,
    seen: Option<&'a VisibleCells>,
    /// The pass in single precision, if requested and applicable to the field.
    stencil: Option<Stencil<'a, S>>,
}

/// The layers on which gradients are computed, for each cell of a block.
type WantedLayers = [Range<usize>; BLOCK];

impl<'a, S: Sample> GradientInput<'a, S> {
    fn new(
        grid: &'a Grid,
        radius: &'a [f64],
        samples: &'a Samples<S>,
        cells: Range<usize>,
        wanted: GradientOptions<'a>,
    ) -> Self {
        let stencil = wanted.single.then(|| Stencil::new(samples, radius)).flatten();
        let (first, cells) = (cells.start, cells.len());
        let GradientOptions { visible, seen, .. } = wanted;
        GradientInput { grid, radius, samples, first, cells, visible, seen, stencil }
    }

    fn fill_all(&self, gradients: &mut Gradients, is_computed: Option<&mut [bool]>) {
        match gradients {
            Gradients::Whole(all) => self.fill(all.to_mut(), is_computed),
            Gradients::Packed(all) => self.fill(all.to_mut(), is_computed),
        }
    }

    fn fill<F: GradientFormat>(&self, gradients: &mut [F], is_computed: Option<&mut [bool]>) {
        let blocks = gradients.par_chunks_mut(self.radius.len() * BLOCK).enumerate();
        let scratch = || (Scratch::default(), ExactColumns::new(self));
        let is_seen = |cell: u32| self.seen.is_none_or(|seen| seen.contains(self.grid.direction(cell)));
        match is_computed {
            None => blocks.for_each_init(scratch, |scratch, (block, rows)| {
                let wanted = self.wanted_layers(block, is_seen);
                self.fill_block(scratch, block, &wanted, rows);
            }),
            Some(is_computed) => {
                let blocks = blocks.zip(is_computed.par_chunks_mut(BLOCK));
                blocks.for_each_init(scratch, |scratch, ((block, rows), is_computed)| {
                    let first = self.first_of(block);
                    let wanted = self.wanted_layers(block, |cell| {
                        let is_computed = &mut is_computed[(cell - first) as usize];
                        let is_missing = !*is_computed && is_seen(cell);
                        *is_computed |= is_missing;
                        is_missing
                    });
                    self.fill_block(scratch, block, &wanted, rows);
                });
            }
        }
    }

    /// The first cell of a block.
    fn first_of(&self, block: usize) -> u32 {
        (self.first + block * BLOCK) as u32
    }

    /// The layers over each wanted cell of a block.
    #[inline(always)]
    fn wanted_layers(&self, block: usize, mut is_wanted: impl FnMut(u32) -> bool) -> WantedLayers {
        let mut wanted = [const { 0..0 }; BLOCK];
        let first = self.first_of(block);
        let cells = first..((first as usize + BLOCK).min(self.first + self.cells)) as u32;
        for (cell, wanted) in cells.zip(&mut wanted) {
            if is_wanted(cell) {
                *wanted = self.layers_over(cell);
            }
        }
        wanted
    }

    fn fill_block<F: GradientFormat>(
        &self,
        (scratch, exact): &mut (Scratch<S>, ExactColumns<S>),
        block: usize,
        wanted: &WantedLayers,
        rows: &mut [F],
    ) {
        let first = self.first_of(block);
        if let (Some(stencil), Some(level)) = (&self.stencil, packets()) {
            dispatch!(level, simd => self.fill_by_stencil(simd, stencil, scratch, exact, first, wanted, rows));
            return;
        }
        for ((cell, row), wanted) in (first..).zip(rows.chunks_exact_mut(self.radius.len())).zip(wanted) {
            exact.fill(cell, wanted.clone(), row, |_| true);
        }
    }

    /// The layers over a cell whose gradients are computed.
    #[inline(always)]
    fn layers_over(&self, cell: u32) -> Range<usize> {
        let layers = self.radius.len();
        self.visible.map_or(0..layers, |visible| visible.layers_over(self.grid, cell, layers))
    }

    /// Computes the cells of a block from `first` on, by the stencil if it applies.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "one call in one place")]
    fn fill_by_stencil<V: Simd, F: GradientFormat>(
        &self,
        simd: V,
        stencil: &Stencil<S>,
        scratch: &mut Scratch<S>,
        exact: &mut ExactColumns<S>,
        first: u32,
        wanted: &WantedLayers,
        rows: &mut [F],
    ) {
        // The rings of all cells first: their look-ups wait for memory independently.
        let mut rings = [const { None }; BLOCK];
        for ((cell, ring), wanted) in (first..).zip(&mut rings).zip(wanted) {
            if !wanted.is_empty() {
                *ring = stencil.ring(self.grid, cell);
            }
        }
        let rows = rows.chunks_exact_mut(self.radius.len());
        for (i, ((cell, row), layers)) in (first..).zip(rows).zip(wanted).enumerate() {
            if let Some(Some(ring)) = rings.get(i + AHEAD) {
                stencil.prefetch(ring, &wanted[i + AHEAD]);
            }
            if layers.is_empty() {
                continue;
            }
            let Some(ring) = &rings[i] else {
                exact.fill(cell, layers.clone(), row, |_| true);
                continue;
            };
            stencil.fill(simd, scratch, cell, ring, layers.clone(), row);
            if !scratch.rejected.is_empty() {
                // A missing value counts on the layers beside it too.
                let Range { start, end } = scratch.rejected;
                let beside = start.saturating_sub(1).max(layers.start)..(end + 1).min(layers.end);
                exact.fill(cell, beside, row, |layer| scratch.is_rejected(layer));
            }
        }
    }
}

/// Computes gradients in double precision; its memory is allocated on the first use.
struct ExactColumns<'a, S> {
    input: &'a GradientInput<'a, S>,
    memory: Option<(Ring, NeighborColumns<'a>)>,
}

impl<'a, S: Sample> ExactColumns<'a, S> {
    fn new(input: &'a GradientInput<'a, S>) -> Self {
        ExactColumns { input, memory: None }
    }

    /// Computes the gradients on layers `wanted` over a cell, at missing values and on layers that are `is_open`.
    #[inline(never)]
    fn fill<F: GradientFormat>(
        &mut self,
        cell: u32,
        wanted: Range<usize>,
        row: &mut [F],
        is_open: impl Fn(usize) -> bool,
    ) {
        if wanted.is_empty() {
            return;
        }
        let GradientInput { grid, radius, samples, .. } = *self.input;
        let new = || (Ring::default(), NeighborColumns::new(radius, samples.mapping.scale));
        let (ring, columns) = self.memory.get_or_insert_with(new);
        ring.read(grid, cell);
        columns.read(samples, cell, &ring.neighbours, &wanted);
        columns.means(ring, &wanted);
        for layer in wanted {
            if !columns.is_whole(layer) {
                row[layer] = F::of(narrowed(columns.mean_of_complete(ring, layer)));
            } else if is_open(layer) {
                row[layer] = F::of(narrowed(columns.mean(layer)));
            }
        }
    }
}

/// The longest gradient: sums of a few of these fit into a float.
const LONGEST: f64 = 1e30;

/// Converts to single precision. Light uses only directions, so too long a gradient is shortened: with infinite ones at
/// vertices the change of light would be unknown, and rays would be cut as finely as possible. Zero if even doubles
/// overflow.
fn narrowed(mean: DVec3) -> [f32; 3] {
    let largest = mean.abs().max_element();
    if !mean.is_finite() {
        return [0.0; 3];
    }
    (mean * (LONGEST / largest).min(1.0)).as_vec3().to_array()
}

#[cfg(test)]
mod stencil_tests;
#[cfg(test)]
mod tests;
