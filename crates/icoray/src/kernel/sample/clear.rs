//! Which layers of which columns hold values inside a range, read as fast as memory gives them.

use super::{Sample, Samples};

/// Columns that are read side by side where layers lie apart.
const SIDE: usize = 64;

impl<S: Sample> Samples<'_, S> {
    /// For each of the `cells.len()` columns from `first` on: the `bits` of all layers whose value is missing or outside
    /// `range` of normalised values, joined.
    pub fn outside(&self, range: [f64; 2], bits: &[u32], first: usize, cells: &mut [u32]) {
        let Some([low, high]) = self.stored(range) else {
            return cells.fill(bits.iter().fold(0, |all, bit| all | bit));
        };
        let fill = self.fill;
        let beyond = |value: S, bit: u32| {
            let inside = value >= low && value <= high && value.wide() != fill;
            if inside { 0 } else { bit }
        };
        let stride = self.elements.layer_stride();
        if stride.unsigned_abs() == 1 {
            // In the array's own order.
            let turned: Vec<u32> = bits.iter().rev().copied().collect();
            let bits = if stride > 0 { bits } else { &turned };
            for (i, cell) in cells.iter_mut().enumerate() {
                let base = self.elements.base(first + i);
                let start = self.elements.at(base, if stride > 0 { 0 } else { bits.len() - 1 });
                let column = &self.data[start..start + bits.len()];
                *cell = column.iter().zip(bits).fold(0, |all, (value, bit)| all | beyond(*value, *bit));
            }
            return;
        }
        for (n, side) in cells.chunks_mut(SIDE).enumerate() {
            let mut bases = [0isize; SIDE];
            bases
                .iter_mut()
                .zip(0..side.len())
                .for_each(|(b, i)| *b = self.elements.base(first + n * SIDE + i));
            side.fill(0);
            for (layer, bit) in bits.iter().enumerate() {
                for (cell, base) in side.iter_mut().zip(&bases) {
                    *cell |= beyond(self.data[self.elements.at(*base, layer)], *bit);
                }
            }
        }
    }

    /// The least and greatest value of the array's type that normalise to inside `range`, ends not counted.
    fn stored(&self, [low, high]: [f64; 2]) -> Option<[S; 2]> {
        let normal = |value: S| (value.wide() - self.shift) * self.scale;
        let raw = |value: f64| S::near(value / self.scale + self.shift);
        // Rounding puts it off by a few numbers at most.
        let first = std::iter::successors(Some(raw(low)), |v| Some(v.next_up())).take(16);
        let last = std::iter::successors(Some(raw(high)), |v| Some(v.next_down())).take(16);
        let low = first.into_iter().find(|v| normal(*v) > low)?;
        let high = last.into_iter().find(|v| normal(*v) < high)?;
        Some([low, high])
    }
}
