//! Columns of values at corners, and their averages at cells.

use super::Field;
use crate::error::{Error, ErrorKind, Result};
use crate::grid::Grid;
use crate::reals::{OwnedReals, Reals, resized};
use crate::sample::Sample;
use crate::shape::ElementIndexer;
use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

/// The column of each corner of a grid: that of one field or, for corners whose values other ranks have, a row of
/// another one.
#[derive(Debug, Clone, Copy)]
pub struct CornerColumns<'f> {
    field: Field<'f>,
    /// The row of each corner in the other field, or [`CornerColumns::OWN`].
    halo: Option<(&'f [u32], Field<'f>)>,
}

/// The column of a corner in an array.
#[derive(Clone, Copy)]
struct Column<'a, S> {
    samples: &'a [S],
    /// The element of layer 0.
    first: usize,
    layer_stride: isize,
}

impl<'a, S: Sample> Column<'a, S> {
    fn new(samples: &'a [S], elements: &ElementIndexer, column: u32) -> Self {
        let first = elements.at(elements.base(column as usize), 0);
        Column { samples, first, layer_stride: elements.layer_stride() }
    }
}

/// Minimum number of cells per parallel task.
const CELLS: usize = 256;

/// Layers that are averaged at once.
const LAYERS: usize = 64;

impl<'f> CornerColumns<'f> {
    /// Replaces a row of the halo: the column is one of the field itself.
    pub const OWN: u32 = u32::MAX;

    /// The columns of `field`, one per corner.
    pub fn new(field: Field<'f>) -> Self {
        CornerColumns { field, halo: None }
    }

    /// The columns of `field`, except for the corners that have a row of `halo` in `rows`, which has an entry per
    /// corner.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] if the two fields differ in layers, precision or the mark of missing values.
    pub fn with_halo(field: Field<'f>, rows: &'f [u32], halo: Field<'f>) -> Result<Self> {
        let facts = |field: &Field| {
            (field.shape().layers, matches!(field.samples, Reals::F64(_)), field.fill.map(f64::to_bits))
        };
        if facts(&field) != facts(&halo) {
            return Err(Error::new(ErrorKind::Field, "the halo has other layers or values than the field"));
        }
        Ok(CornerColumns { field, halo: Some((rows, halo)) })
    }

    /// Averages the columns at the corners of each of `cells`, in parallel: the plain mean over those corners that have
    /// a value, NaN if none has one. Level-fastest in the order of `cells`, in the precision of the field and in
    /// `memory` if that has the same.
    pub fn averages(
        &self,
        grid: &Grid,
        cells: impl IndexedParallelIterator<Item = u32>,
        memory: Option<OwnedReals>,
    ) -> OwnedReals {
        let halo = self.halo.map_or(self.field.samples, |(_, halo)| halo.samples);
        match (self.field.samples, halo, OwnedReals::buffer(self.field.samples, memory)) {
            (Reals::F32(own), Reals::F32(halo), OwnedReals::F32(memory)) => {
                OwnedReals::F32(self.averages_of(grid, cells, [own, halo], memory))
            }
            (Reals::F64(own), Reals::F64(halo), OwnedReals::F64(memory)) => {
                OwnedReals::F64(self.averages_of(grid, cells, [own, halo], memory))
            }
            _ => unreachable!("the halo and the buffer have the precision of the field"),
        }
    }

    fn averages_of<S: Sample>(
        &self,
        grid: &Grid,
        cells: impl IndexedParallelIterator<Item = u32>,
        [own, halo]: [&[S]; 2],
        values: Vec<S>,
    ) -> Vec<S> {
        let layers = self.field.shape.layers;
        let column_of = |corner: u32| match self.halo.as_ref().map(|(rows, field)| (rows[corner as usize], field)) {
            Some((row, field)) if row != Self::OWN => Column::new(halo, &field.elements, row),
            _ => Column::new(own, &self.field.elements, corner),
        };
        let mut values = resized(values, cells.len() * layers);
        let (level, fill) = (Level::new(), self.field.fill.unwrap_or(f64::NAN));
        let columns = values.par_chunks_exact_mut(layers).zip(cells).with_min_len(CELLS);
        // Few cells have more corners.
        let room = || Vec::with_capacity(8);
        columns.for_each_init(room, |around, (to, cell)| {
            // Corners and blocks are looked up once per cell, not once per value.
            around.clear();
            around.extend(grid.corners_of(cell).map(column_of));
            dispatch!(level, _simd => average(around, fill, to));
        });
        values
    }
}

/// Averages columns, many layers at once.
#[inline(always)]
fn average<S: Sample>(columns: &[Column<S>], fill: f64, to: &mut [S]) {
    for (n, to) in to.chunks_mut(LAYERS).enumerate() {
        let (mut sums, mut counts) = ([0.0; LAYERS], [0.0; LAYERS]);
        for Column { samples, first, layer_stride } in columns {
            let mut at = first.wrapping_add_signed((n * LAYERS) as isize * layer_stride);
            let sums = sums.iter_mut().zip(counts.iter_mut());
            if *layer_stride == 1 {
                for ((sum, count), sample) in sums.zip(&samples[at..][..to.len()]) {
                    add(sample.wide(), fill, sum, count);
                }
            } else {
                for (sum, count) in sums.take(to.len()) {
                    add(samples[at].wide(), fill, sum, count);
                    at = at.wrapping_add_signed(*layer_stride);
                }
            }
        }
        for ((to, sum), count) in to.iter_mut().zip(&sums).zip(&counts) {
            *to = S::near(if *count == 0.0 { f64::NAN } else { sum / count });
        }
    }
}

/// Adds a value unless it is missing.
#[inline(always)]
fn add(value: f64, fill: f64, sum: &mut f64, count: &mut f64) {
    let is_there = (value.abs() <= f64::MAX) & (value != fill);
    *sum += if is_there { value } else { 0.0 };
    *count += if is_there { 1.0 } else { 0.0 };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{ComputedField, Location};
    use crate::grid::icosahedral_grid;
    use crate::shape::Shape;

    /// More than are averaged at once.
    const COUNT: usize = LAYERS + 3;

    fn field(values: &[f32], shape: Shape) -> Field<'_> {
        Field::new(values.into(), shape, Location::Corner, Some(5.0)).unwrap()
    }

    /// Averages do not depend on the set of corners in the halo, or on values in their own columns.
    #[test]
    fn averages_with_a_halo_have_the_bits_of_whole_fields() {
        let grid = icosahedral_grid(2);
        let corners = grid.triangles();
        let sample = |corner: usize, layer: usize| (corner as f32 + 3.1 * layer as f32).sin();
        let value = |corner, layer| if corner % 7 == layer % 7 { 5.0 } else { sample(corner, layer) };
        let whole: Vec<f32> = (0..corners).flat_map(|c| (0..COUNT).map(move |l| value(c, l))).collect();
        let expected = ComputedField::average(&grid, &field(&whole, Shape::level_fastest(corners, COUNT))).unwrap();
        let cells: Vec<u32> = (0..grid.cells() as u32).rev().step_by(2).collect();
        for every in [1, 2, 5, usize::MAX] {
            // Blocks of 32 columns, layer by layer.
            let shape = Shape::blocked(corners, COUNT, 32);
            let mut own = vec![f32::MAX; corners.div_ceil(32) * 32 * COUNT];
            let (mut rows, mut halo) = (vec![CornerColumns::OWN; corners], Vec::new());
            for corner in 0..corners {
                if corner % every == 0 {
                    rows[corner] = (halo.len() / COUNT) as u32;
                    halo.extend_from_slice(&whole[corner * COUNT..][..COUNT]);
                    continue;
                }
                for layer in 0..COUNT {
                    own[corner / 32 * 32 * COUNT + layer * 32 + corner % 32] = value(corner, layer);
                }
            }
            let halo = field(&halo, Shape::level_fastest(halo.len() / COUNT, COUNT));
            let columns = CornerColumns::with_halo(field(&own, shape), &rows, halo).unwrap();
            let OwnedReals::F32(averages) = columns.averages(&grid, cells.par_iter().copied(), None) else { panic!() };
            for (cell, averages) in cells.iter().zip(averages.chunks_exact(COUNT)) {
                for (layer, average) in averages.iter().enumerate() {
                    let expected = expected.field().value(*cell as usize, layer) as f32;
                    assert_eq!(average.to_bits(), expected.to_bits(), "cell {cell}, every {every}");
                }
            }
        }
    }

    #[test]
    fn a_halo_of_another_form_is_refused() {
        let values = [0.0f32; 6];
        let one = field(&values, Shape::level_fastest(2, 3));
        let rows = [CornerColumns::OWN; 2];
        assert!(CornerColumns::with_halo(one, &rows, field(&values, Shape::level_fastest(1, 3))).is_ok());
        assert!(CornerColumns::with_halo(one, &rows, field(&values, Shape::level_fastest(1, 2))).is_err());
        let wide = [0.0f64; 3];
        let wide = Field::new(wide[..].into(), Shape::level_fastest(1, 3), Location::Corner, Some(5.0)).unwrap();
        assert!(CornerColumns::with_halo(one, &rows, wide).is_err());
    }
}
