//! Finds the layers of columns with values that are not clear, at the speed of memory.

use super::Samples;
use crate::real::Real;
use crate::sample::{Sample, VECTOR};
use fearless_simd::{Level, Simd, dispatch, prelude::*, u32x16};

/// Columns that are read side by side if layers lie apart.
const SIDE: usize = 1024;

/// Values of the array's own type, from the least to the greatest of them.
pub type Stored<S> = [S; 2];

/// A search for the layers whose values are missing or outside of ranges.
pub struct Outside<'o, S> {
    /// The processor's vectors.
    pub level: Level,
    /// 1 to 3 ranges.
    pub ranges: &'o [Stored<S>],
    /// The bits of each layer.
    pub bits: &'o [u32],
    /// The first column.
    pub first: usize,
    /// For each column from the first on and each range: the joined bits of all layers found.
    pub found: &'o mut [u32],
}

impl<S: Sample> Samples<'_, S> {
    pub(crate) fn find(&self, Outside { level, ranges, bits, first, found }: Outside<S>) {
        match *ranges {
            [a] => dispatch!(level, simd => self.outside_of(simd, &[a], bits, first, found.as_chunks_mut().0)),
            [a, b] => dispatch!(level, simd => self.outside_of(simd, &[a, b], bits, first, found.as_chunks_mut().0)),
            [a, b, c] => {
                dispatch!(level, simd => self.outside_of(simd, &[a, b, c], bits, first, found.as_chunks_mut().0));
            }
            _ => unreachable!("{} ranges, expected 1 to 3", ranges.len()),
        }
    }

    #[inline(always)]
    fn outside_of<V: Simd, const R: usize>(
        &self,
        simd: V,
        ranges: &[Stored<S>; R],
        bits: &[u32],
        first: usize,
        cells: &mut [[u32; R]],
    ) {
        // Without a mark of missing values, a number outside the range.
        let tests = ranges.map(|range| ClearTest { range, fill: self.mapping.fill().unwrap_or(range[0].next_down()) });
        let stride = self.mapping.elements.layer_stride();
        if stride.unsigned_abs() == 1 {
            // In the array's own order.
            let turned: Vec<u32> = bits.iter().rev().copied().collect();
            let bits = if stride > 0 { bits } else { &turned };
            for (i, cell) in cells.iter_mut().enumerate() {
                let base = self.mapping.elements.base(first + i);
                let start = self.mapping.elements.at(base, if stride > 0 { 0 } else { bits.len() - 1 });
                let column = &self.data[start..start + bits.len()];
                for (cell, test) in cell.iter_mut().zip(&tests) {
                    *cell = test.joined(simd, column, bits);
                }
            }
            return;
        }
        let mut done = 0;
        while done < cells.len() {
            let (base, count) = self.run(first + done, (cells.len() - done).min(SIDE));
            let mut all = [[0u32; SIDE]; R];
            for (layer, bit) in bits.iter().enumerate() {
                let start = self.mapping.elements.at(base, layer);
                let values = &self.data[start..start + count];
                for (all, test) in all.iter_mut().zip(&tests) {
                    for (all, value) in all.iter_mut().zip(values) {
                        *all |= test.bit(*value, *bit);
                    }
                }
            }
            for (i, cell) in cells[done..][..count].iter_mut().enumerate() {
                for (cell, all) in cell.iter_mut().zip(&all) {
                    *cell = all[i];
                }
            }
            done += count;
        }
    }

    /// The offset of the values over column `first`, and the number of columns, at most `max`, that lie side by side
    /// there.
    #[inline]
    fn run(&self, first: usize, max: usize) -> (isize, usize) {
        let base = self.mapping.elements.base(first);
        let apart = |i: &usize| self.mapping.elements.base(first + i) != base + *i as isize;
        (base, (1..max).find(apart).unwrap_or(max))
    }

    /// The values whose normalised values lie inside `range`, ends excluded; `None` if there are none.
    #[inline]
    pub fn stored(&self, [low, high]: [f64; 2]) -> Option<Stored<S>> {
        // Rounding shifts it by at most a few numbers.
        let first = std::iter::successors(Some(self.raw(low)), |v| Some(v.next_up())).take(16);
        let last = std::iter::successors(Some(self.raw(high)), |v| Some(v.next_down())).take(16);
        let low = first.into_iter().find(|v| self.normalised(*v) > low)?;
        let high = last.into_iter().find(|v| self.normalised(*v) < high)?;
        Some([low, high])
    }

    /// The range of the single value that the kernel reads as `value`.
    #[inline]
    pub fn stored_at<T: Real>(&self, value: T) -> Option<Stored<S>> {
        let raw = self.raw(value.wide());
        [raw.next_down(), raw, raw.next_up()].into_iter().find(|v| T::of(self.normalised(*v)) == value).map(|v| [v; 2])
    }

    #[inline]
    fn normalised(&self, value: S) -> f64 {
        (value.wide() - self.mapping.shift) * self.mapping.scale
    }

    #[inline]
    fn raw(&self, normal: f64) -> S {
        S::near(normal / self.mapping.scale + self.mapping.shift)
    }
}

/// Test of whether a value is clear.
#[derive(Debug, Clone, Copy)]
struct ClearTest<S> {
    range: Stored<S>,
    fill: S,
}

impl<S: Sample> ClearTest<S> {
    /// `bit` unless the value is clear.
    #[inline(always)]
    fn bit(&self, value: S, bit: u32) -> u32 {
        let [low, high] = self.range;
        let is_clear = (value >= low) & (value <= high) & (value != self.fill);
        if is_clear { 0 } else { bit }
    }

    /// The `bits` of all values of a column that are not clear, joined.
    #[inline(always)]
    fn joined<V: Simd>(&self, simd: V, column: &[S], bits: &[u32]) -> u32 {
        if column.len() < VECTOR {
            return column.iter().zip(bits).fold(0, |all, (value, bit)| all | self.bit(*value, *bit));
        }
        let mut all = u32x16::splat(simd, 0);
        for (values, bits) in column.as_chunks().0.iter().zip(bits.as_chunks().0) {
            all |= self.bits(simd, values, bits);
        }
        // The last vector may repeat some layers.
        if !column.len().is_multiple_of(VECTOR)
            && let (Some(values), Some(bits)) = (column.last_chunk(), bits.last_chunk())
        {
            all |= self.bits(simd, values, bits);
        }
        let mut joined = 0;
        for bits in all.as_slice() {
            joined |= bits;
        }
        joined
    }

    /// The bits of the values that are not clear; 0 for the others.
    #[inline(always)]
    fn bits<V: Simd>(&self, simd: V, values: &[S; VECTOR], bits: &[u32; VECTOR]) -> u32x16<V> {
        let values = S::load(simd, values);
        let is_clear = S::within(simd, values, self.range) & !S::equals(simd, values, self.fill);
        is_clear.select(u32x16::splat(simd, 0), u32x16::load_array_ref(simd, bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Field, Location};
    use crate::reals::Reals;
    use crate::shape::Shape;
    use icoray_test_support::Random;

    const COLUMNS: usize = 2500;

    /// Arrays as models have them: layers or columns side by side, in blocks, with gaps, turned round.
    fn shapes(layers: usize) -> Vec<Shape> {
        let (level, cell) = (Shape::level_fastest(COLUMNS, layers), Shape::cell_fastest(COLUMNS, layers));
        let padded = Shape { column_stride: layers as isize + 3, offset: 2, ..level };
        let apart = Shape { column_stride: 3 * layers as isize, layer_stride: 3, ..level };
        let turned = Shape { layer_stride: -1, offset: layers - 1, ..level };
        let backwards = Shape { column_stride: -1, offset: COLUMNS - 1, ..cell };
        let blocks = [Shape::blocked(COLUMNS, layers, 16), Shape::blocked(COLUMNS, layers, 2000)];
        [vec![level, cell, padded, apart, turned, backwards], blocks.to_vec()].concat()
    }

    fn check<S: Sample>(values: &[S], reals: Reals, layers: usize, fill: Option<f64>) {
        let bits: Vec<u32> = (0..layers).map(|l| 1 << (l / 2) | 1 << (l / 3)).collect();
        for (shape, falling) in shapes(layers).into_iter().flat_map(|shape| [(shape, false), (shape, true)]) {
            let field = Field::new(reals, shape, Location::Center, fill).unwrap();
            let samples = Samples::new(values, &field, falling, [-1.0, 3.0]);
            let ranges = [[0.1, 0.45], [f64::NEG_INFINITY, 0.2]];
            let stored = ranges.map(|range| samples.stored(range).unwrap());
            let mut found = vec![9; 2 * (COLUMNS - 7)];
            let level = Level::new();
            samples.find(Outside { level, ranges: &stored, bits: &bits, first: 7, found: &mut found });
            for (column, &found) in (7..).zip(found.as_chunks().0) {
                let expected = ranges.map(|[low, high]| {
                    let base = samples.base(column as u32);
                    let is_clear =
                        |l: &usize| (low..high).contains(&samples.get(base, *l)) && samples.get::<f64>(base, *l) != low;
                    (0..layers).filter(|l| !is_clear(l)).fold(0, |all, l| all | bits[l])
                });
                assert_eq!(found, expected, "column {column} of {shape:?}, {falling}");
            }
        }
    }

    #[test]
    fn blocks_are_those_of_values_outside() {
        for layers in [2, 5, 26, 37] {
            let value = |i: usize| match i % 101 {
                50 => f64::NAN,
                51 => -1e30,
                52 => f64::INFINITY,
                _ => ((i * i) as f64 * 1e-3).sin(),
            };
            let wide: Vec<f64> = (0..3 * COLUMNS * layers + 9).map(value).collect();
            let single: Vec<f32> = wide.iter().map(|v| *v as f32).collect();
            for fill in [None, Some(-1e30), Some(f64::from(-1e30f32))] {
                check(&wide, wide.as_slice().into(), layers, fill);
                check(&single, single.as_slice().into(), layers, fill);
            }
        }
    }

    /// Rows of all lengths, with values at the ends of the range, missing ones, NaN and zeros of both signs.
    #[test]
    fn vectors_find_the_same_layers_as_single_values() {
        fn compare<S: Sample>(special: &[S], test: ClearTest<S>) {
            let mut random = Random::new(1);
            for length in (0..80).cycle().take(4000) {
                let value = |number: usize| match number % 5 {
                    // Long stretches of clear values, so that a single other one is found.
                    0 => special[number / 5 % special.len()],
                    _ => S::near(0.5),
                };
                let row: Vec<S> = (0..length).map(|_| value(random.bits() as usize)).collect();
                let bits: Vec<u32> = (0..length).map(|_| 1 << random.below(32) | 1 << random.below(32)).collect();
                let expected = row.iter().zip(&bits).fold(0, |all, (value, bit)| all | test.bit(*value, *bit));
                for level in [Level::new(), Level::baseline()] {
                    let found = dispatch!(level, simd => test.joined(simd, &row, &bits));
                    assert_eq!(found, expected, "{length} values");
                }
            }
        }
        let special = [0.0f32, -0.0, f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.7, 0.2, -1e30, f32::MAX];
        let ends = [0.2f32, 0.7].map(|end| [end.next_down(), end.next_up()]);
        let special: Vec<f32> = [&special, ends.as_flattened()].concat();
        let wide: Vec<f64> = special.iter().map(|value| (*value).into()).collect();
        for range in [[0.2, 0.7], [-0.0, 0.7], [0.5, 0.5], [0.7, 0.2], [f32::MIN, f32::MAX]] {
            for fill in [0.7, -1e30, 0.0, 0.5, f32::INFINITY, range[0].next_down()] {
                compare(&special, ClearTest { range, fill });
                compare(&wide, ClearTest { range: range.map(f64::from), fill: fill.into() });
            }
        }
    }

    /// Exactly one of adjacent values is the knot's, and no range reaches its ends.
    #[test]
    fn ranges_contain_the_values_that_normalise_to_inside() {
        let values = [0.25f32; 4];
        let field = Field::level_fastest(&values[..], 2, Location::Center).unwrap();
        let samples = Samples::new(&values, &field, false, [0.1, 0.7]);
        for knot in [0.25f32, 1.0 / 3.0, 0.7, 1.0] {
            let [value, same] = samples.stored_at(knot).unwrap();
            assert!(value == same && (samples.normalised(value) as f32 == knot), "{knot}: {value}");
        }
        assert!(samples.stored_at(0.0f32).is_none(), "no float is 0.1");
        let [low, high] = samples.stored([0.25, 0.5]).unwrap();
        let normal = |value: f32| samples.normalised(value);
        assert!(normal(low) > 0.25 && normal(Sample::next_down(low)) <= 0.25);
        assert!(normal(high) < 0.5 && normal(Sample::next_up(high)) >= 0.5);
        assert!(samples.stored([0.25, 0.25]).is_none_or(|[low, high]| low > high));
    }
}
