//! A field as the model holds it: a borrowed array, read in place through its [`Shape`], whatever the layout.
//!
//! `shape.rs` lists the layouts and who uses them. Readers ask for a column's base once and go from layer to layer by one
//! stride: only the base knows of blocks. A field at corners is the one thing that is made anew, at the centres.

use crate::error::{Error, ErrorKind, Result};
use crate::grid::{Grid, Reals};
use crate::kernel::sample::Sample;
use crate::ranks::{Part, Ranks};
use crate::shape::{Elements, Shape};
use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use std::slice;
use std::sync::atomic::{AtomicU64, Ordering};

/// Where a field's values live on the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Location {
    /// At the cell centres.
    Center,
    /// At the cell corners, which are the dual triangles (MPAS vorticity); averaged to centres before rendering.
    Corner,
}

/// A scalar field over a borrowed array.
///
/// Values that are NaN, infinite or equal to `fill` are missing: a frustum with a missing value is empty.
///
/// ```
/// use icoray::{Field, Location, Shape};
///
/// // Two columns of three layers; -999 marks a missing value.
/// let values = [1.0, 2.0, 3.0, 4.0, -999.0, 6.0f32];
/// let shape = Shape::level_fastest(2, 3);
/// let field = Field::new(values.as_slice().into(), shape, Location::Center, Some(-999.0))?;
/// assert_eq!(field.value(1, 2), 6.0);
/// assert_eq!(field.range(), (Some([1.0, 6.0]), 1));
/// # Ok::<(), icoray::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    samples: Reals<'a>,
    shape: Shape,
    elements: Elements,
    location: Location,
    fill: Option<f64>,
    number: u64,
}

impl<'a> Field<'a> {
    /// Wraps `samples`; every element that `shape` reaches must lie inside. There may be no column: a rank without cells has
    /// such a field.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when the shape has no layer or reaches outside the array, or when 32 bits cannot number its
    /// blocked columns.
    pub fn new(samples: Reals<'a>, shape: Shape, location: Location, fill: Option<f64>) -> Result<Self> {
        let number = next_number();
        let bad = |context| Err(Error::new(ErrorKind::Field, context));
        if shape.columns == 0 && shape.layers > 0 {
            let shape = Shape::level_fastest(0, shape.layers);
            let elements = Elements::new(&shape).expect("nothing is in blocks");
            return Ok(Field { samples, shape, elements, location, fill, number });
        }
        let Some((low, high)) = shape.extent() else {
            return bad(format!(
                "{} columns of {} layers, expected layers and strides that 64 bits can hold",
                shape.columns, shape.layers
            ));
        };
        if low < 0 || high >= samples.len() as i128 {
            return bad(format!(
                "the strides reach elements {low} to {high}, expected 0 to {}",
                samples.len() as i128 - 1
            ));
        }
        let Some(elements) = Elements::new(&shape) else {
            return bad(format!("{} columns in blocks, expected at most 2^32", shape.columns));
        };
        Ok(Field { samples, shape, elements, location, fill, number })
    }

    /// The array as given.
    pub fn samples(&self) -> Reals<'a> {
        self.samples
    }

    /// Copies of this field have the same number and no other field of the process has it. The array is borrowed, and so what
    /// was made of a field of this number holds for all of them: nobody could write to it in between.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// How the array is read.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Where the values live.
    pub fn location(&self) -> Location {
        self.location
    }

    /// The value that marks a missing sample, if any.
    pub fn fill(&self) -> Option<f64> {
        self.fill
    }

    /// Value of `column` at `layer`, NaN where it is missing.
    ///
    /// # Panics
    /// When the indices are out of range.
    #[inline]
    pub fn value(&self, column: usize, layer: usize) -> f64 {
        self.known(self.samples.get(self.elements.at(self.elements.base(column), layer)))
    }

    /// The value, or NaN where it marks a missing one.
    #[inline]
    fn known(&self, value: f64) -> f64 {
        if Some(value) == self.fill || !value.is_finite() { f64::NAN } else { value }
    }

    /// How elements are found.
    pub(crate) fn elements(&self) -> &Elements {
        &self.elements
    }

    /// Least and greatest value that is there, and how many are missing; `None` for the range where all are missing.
    pub fn range(&self) -> (Option<[f64; 2]>, u64) {
        self.range_over(None)
    }

    /// The same over those columns that `counts` is true for.
    pub(crate) fn range_over(
        &self,
        counts: Option<&(dyn Fn(usize) -> bool + Sync)>,
    ) -> (Option<[f64; 2]>, u64) {
        let (low, high, missing) = match self.samples {
            Reals::F32(samples) => self.range_in(samples, counts),
            Reals::F64(samples) => self.range_in(samples, counts),
        };
        ((low <= high).then_some([low, high]), missing)
    }

    fn range_in<S: Sample>(
        &self,
        samples: &[S],
        counts: Option<&(dyn Fn(usize) -> bool + Sync)>,
    ) -> Extremes {
        let fill = self.fill.and_then(S::exact);
        let level = Level::new();
        let range = |values: &[S]| dispatch!(level, _simd => range_of(values, fill));
        if let (None, Some((low, high))) = (counts, self.shape.packed()) {
            let pieces = samples[low..=high].par_chunks(1 << 15);
            return pieces.map(range).reduce(nothing, either);
        }
        let columns = (0..self.shape.columns).into_par_iter().with_min_len(256);
        let counted = columns.filter(|column| counts.is_none_or(|counts| counts(*column)));
        let of_column = |column: usize| {
            let base = self.elements.base(column);
            if self.shape.layer_stride == 1 {
                let start = self.elements.at(base, 0);
                return range(&samples[start..start + self.shape.layers]);
            }
            let values = (0..self.shape.layers).map(|layer| &samples[self.elements.at(base, layer)]);
            values.map(|value| range_of(slice::from_ref(value), fill)).fold(nothing(), either)
        };
        counted.map(of_column).reduce(nothing, either)
    }
}

/// A number that no field has had.
fn next_number() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// Least and greatest value, and how many are missing.
type Extremes = (f64, f64, u64);

fn nothing() -> Extremes {
    (f64::INFINITY, f64::NEG_INFINITY, 0)
}

fn either(a: Extremes, b: Extremes) -> Extremes {
    (a.0.min(b.0), a.1.max(b.1), a.2 + b.2)
}

/// Least and greatest of values that lie side by side, and how many are missing: in loops of fixed size, which become vectors.
#[inline(always)]
fn range_of<S: Sample>(values: &[S], fill: Option<S>) -> Extremes {
    const SIDE: usize = 32;
    let [least, greatest] = [f64::NEG_INFINITY, f64::INFINITY].map(S::near);
    // Without a mark, one that is missing anyway.
    let fill = fill.unwrap_or(greatest.next_up());
    let (sides, rest) = values.as_chunks::<SIDE>();
    let mut last = [fill; SIDE];
    last[..rest.len()].copy_from_slice(rest);
    let (mut low, mut high, mut there) = ([greatest; SIDE], [least; SIDE], [0u32; SIDE]);
    for n in 0..=sides.len() {
        let side = sides.get(n).unwrap_or(&last);
        for i in 0..SIDE {
            let value = side[i];
            let is_there = (value >= least) & (value <= greatest) & (value != fill);
            let [lower, higher] = if is_there { [value; 2] } else { [greatest, least] };
            low[i] = if lower < low[i] { lower } else { low[i] };
            high[i] = if higher > high[i] { higher } else { high[i] };
            there[i] += u32::from(is_there);
        }
    }
    let there: u32 = there.iter().sum();
    let missing = (values.len() - there as usize) as u64;
    if there == 0 {
        return (f64::INFINITY, f64::NEG_INFINITY, missing);
    }
    let low = low.iter().fold(f64::INFINITY, |low, v| low.min(v.wide()));
    (low, high.iter().fold(f64::NEG_INFINITY, |high, v| high.max(v.wide())), missing)
}

mod moved;

/// A field at centres that icoray made from one at corners, or on other layers.
#[derive(Debug, Clone)]
pub struct CenterField {
    values: CenterValues,
    shape: Shape,
    /// That of the field that it is: the same as long as no value changes.
    number: u64,
}

#[derive(Debug, Clone)]
enum CenterValues {
    F32(Vec<f32>),
    F64(Vec<f64>),
}

impl CenterField {
    /// Averages a field at corners to the cell centres, one parallel pass: the plain mean over a cell's corners whose
    /// value is there; NaN where none is. Same precision as `field`, level-fastest.
    ///
    /// # Errors
    /// [`ErrorKind::Field`] when `field` is not at corners or has not one column per corner of `grid`.
    pub fn average(grid: &Grid, field: &Field) -> Result<Self> {
        Self::average_in(grid, field, None)
    }

    /// [`Self::average`] in the memory of another average, which the next frame of a run has.
    pub(crate) fn average_in(grid: &Grid, field: &Field, memory: Option<Self>) -> Result<Self> {
        let shape = field.shape();
        if field.location() != Location::Corner || shape.columns != grid.triangles() {
            return Err(Error::new(
                ErrorKind::Field,
                format!(
                    "{} columns at {:?}, expected {} at Corner",
                    shape.columns,
                    field.location(),
                    grid.triangles()
                ),
            ));
        }
        let values = match CenterValues::room_for(field, memory) {
            CenterValues::F32(memory) => CenterValues::F32(average(grid, field, memory, |v| v as f32)),
            CenterValues::F64(memory) => CenterValues::F64(average(grid, field, memory, |v| v)),
        };
        let shape = Shape::level_fastest(grid.cells(), shape.layers);
        Ok(CenterField { values, shape, number: next_number() })
    }

    /// The averaged field, borrowed.
    pub fn field(&self) -> Field<'_> {
        let samples = match &self.values {
            CenterValues::F32(v) => v.as_slice().into(),
            CenterValues::F64(v) => v.as_slice().into(),
        };
        let field = Field::new(samples, self.shape, Location::Center, None);
        Field { number: self.number, ..field.expect("the values were made for this shape") }
    }

    /// Takes the averages of halo cells, some of whose corners are not here, from the ranks that own them. Collective.
    pub(crate) fn fill_halo(&mut self, ranks: &mut Ranks, part: &Part) -> Result<()> {
        let layers = self.shape.layers;
        self.number = next_number();
        let row = |cell: u32| cell as usize * layers..(cell as usize + 1) * layers;
        match &mut self.values {
            CenterValues::F32(values) => part.fill_halo(ranks, values, |values, cell| &mut values[row(cell)]),
            CenterValues::F64(values) => part.fill_halo(ranks, values, |values, cell| &mut values[row(cell)]),
        }
    }

    /// Bytes that the average takes.
    pub fn bytes(&self) -> usize {
        match &self.values {
            CenterValues::F32(v) => size_of_val(v.as_slice()),
            CenterValues::F64(v) => size_of_val(v.as_slice()),
        }
    }
}

impl CenterValues {
    /// As precise as `field`, in memory if that is.
    fn room_for(field: &Field, memory: Option<CenterField>) -> Self {
        match (field.samples(), memory.map(|made| made.values)) {
            (Reals::F32(_), Some(CenterValues::F32(memory))) => CenterValues::F32(memory),
            (Reals::F64(_), Some(CenterValues::F64(memory))) => CenterValues::F64(memory),
            (Reals::F32(_), _) => CenterValues::F32(Vec::new()),
            (Reals::F64(_), _) => CenterValues::F64(Vec::new()),
        }
    }
}

/// `count` values in this memory, with whatever stood there.
fn resized<S: Copy + Default>(mut memory: Vec<S>, count: usize) -> Vec<S> {
    memory.reserve_exact(count.saturating_sub(memory.len()));
    memory.resize(count, S::default());
    memory
}

fn average<S: Copy + Default + Send>(
    grid: &Grid,
    field: &Field,
    memory: Vec<S>,
    narrow: impl Fn(f64) -> S + Sync,
) -> Vec<S> {
    let layers = field.shape().layers;
    let elements = field.elements();
    let mut values = resized(memory, grid.cells() * layers);
    let columns = values.par_chunks_exact_mut(layers).with_min_len(256).enumerate();
    columns.for_each_init(Vec::new, |around, (cell, column)| {
        // Corners and blocks are looked up once per cell, not once per value.
        around.clear();
        around.extend(grid.corners_of(cell as u32).map(|c| elements.base(c as usize)));
        for (layer, value) in column.iter_mut().enumerate() {
            let all = around.iter().map(|&base| field.known(field.samples.get(elements.at(base, layer))));
            let there = all.filter(|v| !v.is_nan());
            let (sum, count) = there.fold((0.0, 0u32), |(sum, count), v| (sum + v, count + 1));
            *value = narrow(if count == 0 { f64::NAN } else { sum / f64::from(count) });
        }
    });
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::IcosahedralMesh;

    #[test]
    fn strides_reach_the_same_values_in_every_layout() {
        let (cells, layers) = (3, 2);
        let level: Vec<f64> = (0..6).map(f64::from).collect();
        let cell: Vec<f64> = [0.0, 2.0, 4.0, 1.0, 3.0, 5.0].to_vec();
        let a =
            Field::new(level.as_slice().into(), Shape::level_fastest(cells, layers), Location::Center, None)
                .unwrap();
        let b =
            Field::new(cell.as_slice().into(), Shape::cell_fastest(cells, layers), Location::Center, None)
                .unwrap();
        for c in 0..cells {
            for l in 0..layers {
                assert_eq!(a.value(c, l), b.value(c, l));
            }
        }
        let upside_down = Shape { offset: 1, layer_stride: -1, ..Shape::level_fastest(cells, layers) };
        let flipped = Field::new(level.as_slice().into(), upside_down, Location::Center, None).unwrap();
        assert_eq!(flipped.value(2, 0), 5.0);
    }

    #[test]
    fn a_shape_that_leaves_the_array_is_refused() {
        let v = [0.0f32; 6];
        for shape in [
            Shape::level_fastest(3, 3),
            Shape { layer_stride: -1, ..Shape::level_fastest(3, 2) },
            Shape { column_stride: isize::MAX, ..Shape::level_fastest(3, 2) },
            Shape::level_fastest(2, 0),
        ] {
            let error = Field::new(v.as_slice().into(), shape, Location::Center, None).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Field, "{shape:?}");
        }
    }

    #[test]
    fn range_leaves_missing_values_out() {
        let v = [1.0f32, -9e33, f32::NAN, 4.0, f32::INFINITY, 2.0];
        let fill = Some(f64::from(-9e33f32));
        let field =
            Field::new(v.as_slice().into(), Shape::level_fastest(3, 2), Location::Center, fill).unwrap();
        assert_eq!(field.range(), (Some([1.0, 4.0]), 3));
    }

    #[test]
    fn corner_average_counts_each_corner_once() {
        let mesh = IcosahedralMesh::new(1).unwrap();
        let grid = Grid::new(mesh.tables()).unwrap();
        // Pentagons repeat a corner in the table; a plain sum over six entries would be wrong there.
        let v: Vec<f64> = (0..grid.triangles()).map(|c| c as f64).collect();
        let field = Field::new(v.as_slice().into(), Shape::level_fastest(v.len(), 1), Location::Corner, None)
            .unwrap();
        let center = CenterField::average(&grid, &field).unwrap();
        for cell in 0..grid.cells() as u32 {
            let around: Vec<u32> =
                (0..grid.triangles() as u32).filter(|&t| grid.triangle(t).contains(&cell)).collect();
            let mean = around.iter().map(|&t| f64::from(t)).sum::<f64>() / around.len() as f64;
            assert!((center.field().value(cell as usize, 0) - mean).abs() < 1e-12);
        }
    }
}
