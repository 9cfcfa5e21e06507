//! Which layers of which columns hold values that are not clear, read as fast as memory gives them.

use super::{Sample, Samples};
use crate::kernel::real::Real;
use fearless_simd::{Level, dispatch};

/// Columns that are read side by side where layers lie apart.
const SIDE: usize = 1024;

/// Values of the array's own type, from the least to the greatest of them.
pub(crate) type Stored<S> = [S; 2];

impl<S: Sample> Samples<'_, S> {
    /// For each of `ranges` and each of the `cells.len()` columns from `first` on: the `bits` of all layers whose value is
    /// missing or outside, joined.
    pub fn outside<const R: usize>(
        &self,
        level: Level,
        ranges: &[Stored<S>; R],
        bits: &[u32],
        first: usize,
        cells: &mut [[u32; R]],
    ) {
        dispatch!(level, _simd => self.outside_of(ranges, bits, first, cells));
    }

    #[inline(always)]
    fn outside_of<const R: usize>(
        &self,
        ranges: &[Stored<S>; R],
        bits: &[u32],
        first: usize,
        cells: &mut [[u32; R]],
    ) {
        let tests = ranges.map(|range| Test { range, fill: self.fill_beside(range) });
        let stride = self.elements.layer_stride();
        if stride.unsigned_abs() == 1 {
            // In the array's own order.
            let turned: Vec<u32> = bits.iter().rev().copied().collect();
            let bits = if stride > 0 { bits } else { &turned };
            for (i, cell) in cells.iter_mut().enumerate() {
                let base = self.elements.base(first + i);
                let start = self.elements.at(base, if stride > 0 { 0 } else { bits.len() - 1 });
                *cell = joined(&self.data[start..start + bits.len()], bits, &tests);
            }
            return;
        }
        let mut done = 0;
        while done < cells.len() {
            let (base, count) = self.run(first + done, (cells.len() - done).min(SIDE));
            let mut all = [[0u32; SIDE]; R];
            for (layer, bit) in bits.iter().enumerate() {
                let start = self.elements.at(base, layer);
                let values = &self.data[start..start + count];
                for (all, test) in all.iter_mut().zip(&tests) {
                    all.iter_mut().zip(values).for_each(|(all, value)| *all |= test.bit(*value, *bit));
                }
            }
            let cells = cells[done..][..count].iter_mut().enumerate();
            cells.for_each(|(i, cell)| *cell = all.each_ref().map(|all| all[i]));
            done += count;
        }
    }

    /// Where the values over column `first` begin, and how many columns, of no more than `most`, lie side by side there.
    fn run(&self, first: usize, most: usize) -> (isize, usize) {
        let base = self.elements.base(first);
        let apart = |i: &usize| self.elements.base(first + i) != base + *i as isize;
        (base, (1..most).find(apart).unwrap_or(most))
    }

    /// The mark of missing values as the array has it, or a number outside the range where it has none.
    fn fill_beside(&self, [low, _]: Stored<S>) -> S {
        S::exact(self.fill).filter(|_| self.has_fill).unwrap_or(low.next_down())
    }

    /// The values that normalise to inside `range`, ends not counted; `None` where there are none.
    pub fn stored(&self, [low, high]: [f64; 2]) -> Option<Stored<S>> {
        // Rounding puts it off by a few numbers at most.
        let first = std::iter::successors(Some(self.raw(low)), |v| Some(v.next_up())).take(16);
        let last = std::iter::successors(Some(self.raw(high)), |v| Some(v.next_down())).take(16);
        let low = first.into_iter().find(|v| self.normal(*v) > low)?;
        let high = last.into_iter().find(|v| self.normal(*v) < high)?;
        Some([low, high])
    }

    /// The value that the kernel has as `value`, alone.
    pub fn stored_at<T: Real>(&self, value: T) -> Option<Stored<S>> {
        let raw = self.raw(value.wide());
        [raw.next_down(), raw, raw.next_up()]
            .into_iter()
            .find(|v| T::of(self.normal(*v)) == value)
            .map(|v| [v; 2])
    }

    fn normal(&self, value: S) -> f64 {
        (value.wide() - self.shift) * self.scale
    }

    fn raw(&self, normal: f64) -> S {
        S::near(normal / self.scale + self.shift)
    }
}

/// What tells values that are clear.
#[derive(Debug, Clone, Copy)]
struct Test<S> {
    range: Stored<S>,
    fill: S,
}

impl<S: Sample> Test<S> {
    /// `bit` unless the value is clear.
    #[inline(always)]
    fn bit(&self, value: S, bit: u32) -> u32 {
        let [low, high] = self.range;
        let is_clear = (value >= low) & (value <= high) & (value != self.fill);
        if is_clear { 0 } else { bit }
    }
}

/// The bits of all layers of a column that fail each test.
#[inline(always)]
fn joined<S: Sample, const R: usize>(column: &[S], bits: &[u32], tests: &[Test<S>; R]) -> [u32; R] {
    tests.each_ref().map(|test| match column.len() {
        0..4 => column.iter().zip(bits).fold(0, |all, (value, bit)| all | test.bit(*value, *bit)),
        4..16 => joined_by::<S, 4>(column, bits, test),
        _ => joined_by::<S, 16>(column, bits, test),
    })
}

/// The same in loops of fixed size, which become vectors. The last one may look at some layers again.
#[inline(always)]
fn joined_by<S: Sample, const LANES: usize>(column: &[S], bits: &[u32], test: &Test<S>) -> u32 {
    let mut all = [0u32; LANES];
    let mut take = |values: &[S; LANES], bits: &[u32; LANES]| {
        for i in 0..LANES {
            all[i] |= test.bit(values[i], bits[i]);
        }
    };
    let (values, bits_of) = (column.as_chunks::<LANES>().0, bits.as_chunks::<LANES>().0);
    values.iter().zip(bits_of).for_each(|(values, bits)| take(values, bits));
    if let (Some(values), Some(bits)) = (column.last_chunk::<LANES>(), bits.last_chunk::<LANES>()) {
        take(values, bits);
    }
    all.iter().fold(0, |joined, bits| joined | bits)
}
