//! From gap to gap in the columns of a packet: [`ColumnTraversal`](crate::column::ColumnTraversal) in vectors.

use super::lanes::Lanes;
use super::medium::number;
use super::part::all;
use crate::column::Shell;
use fearless_simd::prelude::*;
use icoray_grid::occupancy::OccupancyMask;
use icoray_simd::{Floats, Machine, Mask, Numbers, Table, Wide, wide_mask};

/// Where the lanes' rays leave their gaps.
pub(super) struct Crossing<V: Machine> {
    /// Whether they leave through a layer; the others leave their columns.
    pub passes: Mask<V>,
    pub u: Wide<V>,
    pub tau: Floats<V>,
    pub height: Wide<V>,
    pub place: Floats<V>,
    /// Relative change of height, and length.
    pub eps: Floats<V>,
    pub length: Floats<V>,
}

impl<V: Machine> Lanes<V> {
    /// The ways through the gaps; `bounds` are [`Shell::bounds`].
    #[inline(always)]
    pub fn cross(&self, simd: V, bounds: Table<'_, f64>) -> Crossing<V> {
        let [low, high] = simd.gather_f64_pair(bounds, self.gap);
        let (rising, one) = (wide_mask::<V>(self.rising), Wide::splat(simd, 1.0));
        let ahead = high.over(rising, low);
        // Rising rays pass a layer up to their column's exit, falling ones one above it.
        let passes = self.rising.simd_eq(ahead.le(self.rho[1]).narrow());
        let wide = wide_mask::<V>(passes);
        let u = ((ahead - self.rho[0]) * self.scale).fraction(simd);
        let (none, whole) = (all(simd, 0.0), all(simd, 1.0));
        let tau = (u.narrow() * self.rho[1].narrow() / ahead.narrow()).max(none).min(whole);
        let (u, height) = (u.over(wide, one), ahead.over(wide, self.rho[1]));
        let place = ((height - low).narrow() / (high - low).narrow()).max(none).min(whole);
        let eps = (height - self.height).narrow() / self.height.narrow();
        Crossing {
            passes,
            u,
            tau: passes.select(tau, whole),
            height,
            place: passes.select(self.rising.select(whole, none), place),
            // A core of next to no radius would round it to -1.
            eps: eps.max(all(simd, 0.5 * f32::EPSILON - 1.0)),
            length: ((self.t[1] - self.t[0]) * (u - self.u)).narrow(),
        }
    }

    /// Takes the lanes of `passing` into the gaps ahead, and those of `leaving` to the exits of their columns.
    #[inline(always)]
    pub fn pass(&mut self, simd: V, crossing: &Crossing<V>, passing: Mask<V>, leaving: Mask<V>) {
        let (one, none) = (number(simd, 1), number(simd, 0));
        let up = (passing & self.rising).select(one, none);
        let down = (passing & !self.rising).select(one, none);
        self.gap = self.gap + up - down;
        let wide = wide_mask::<V>(passing);
        self.u = crossing.u.over(wide, self.u);
        self.height = crossing.height.over(wide, self.height);
        self.tau = passing.select(crossing.tau, self.tau);
        // Behind a layer lies the other side of the next gap.
        let place = self.rising.select(all(simd, 0.0), all(simd, 1.0));
        self.place = passing.select(place, leaving.select(crossing.place, self.place));
    }

    /// The gaps that hold these heights, as [`Shell::gap`], searched from those of the lanes, and the fractions of the
    /// way from the layers below to those above.
    #[inline(always)]
    fn gaps_at(&self, simd: V, shell: &Shell<f32>, bounds: Table<'_, f64>, height: Wide<V>) -> (Numbers<V>, Floats<V>) {
        let (one, none) = (number(simd, 1), number(simd, 0));
        let (first, per_height) = (Wide::splat(simd, shell.inner()), Wide::splat(simd, shell.buckets_per_height()));
        let bucket = ((height - first) * per_height).narrow().max(all(simd, 0.0)).to_int::<Numbers<V>>();
        let mut gap = match Table::new(shell.below()) {
            Some(below) => simd.gather_u32(below, bucket),
            None => self.gap,
        };
        loop {
            let [low, high] = simd.gather_f64_pair(bounds, gap);
            let (is_above, is_below) = (high.le(height).narrow(), height.lt(low).narrow());
            if (is_above | is_below).all_false() {
                let place = (height - low).narrow() / (high - low).narrow();
                return (gap, place.max(all(simd, 0.0)).min(all(simd, 1.0)));
            }
            gap = gap + is_above.select(one, none) - is_below.select(one, none);
        }
    }

    /// Takes those lanes of `entered` in whose columns nothing shows to their columns' exits; returns their bits. Columns
    /// that reach to the core or above all layers are not left out.
    #[inline(always)]
    pub fn skip_columns(
        &mut self,
        simd: V,
        shell: &Shell<f32>,
        bounds: Table<'_, f64>,
        visible: &OccupancyMask,
        entered: Mask<V>,
    ) -> u32 {
        let Some(blocks) = Table::new(&visible.blocks) else { return 0 };
        let blocks = simd.gather_u32(blocks, self.triangles);
        let (exit, place) = self.gaps_at(simd, shell, bounds, self.rho[1]);
        let (low, high) = (self.gap.min(exit), self.gap.max(exit));
        let most = number(simd, u32::MAX);
        let (first, last) = (((low - 1) >> visible.shift).min(31), ((high - 1) >> visible.shift).min(31));
        let between = (most << first) & (most >> (number(simd, 31) - last));
        let shows = (blocks & between).simd_ne(0);
        let ends = low.simd_eq(0) | high.simd_eq(shell.layers() as u32);
        let skipped = entered & !(shows | ends);
        self.gap = skipped.select(exit, self.gap);
        self.place = skipped.select(place, self.place);
        skipped.to_bitmask() as u32
    }

    /// Sets the gap of a lane by the height at which it is.
    #[inline]
    pub fn locate(&mut self, lane: usize, shell: &Shell<f32>, height: f64) {
        let gap = shell.gap(height);
        self.gap[lane] = gap as u32;
        let [low, high] = [shell.bounds()[gap], shell.bounds()[gap + 1]];
        // Rounded as in `cross`.
        self.place[lane] = ((height - low) as f32 / (high - low) as f32).clamp(0.0, 1.0);
    }

    /// Takes a lane from a gap in which nothing shows to the next one in its column in which something shows, to the
    /// space below or above all layers, or to the column's exit: then it returns true.
    #[inline(never)]
    pub fn skip(&mut self, lane: usize, shell: &Shell<f32>, visible: &OccupancyMask) -> bool {
        let blocks = visible.blocks_over(self.triangles[lane]);
        let block = (self.gap[lane] - 1) >> visible.shift;
        let [entry, exit] = [0, 1].map(|k: usize| self.rho[k].get(lane));
        let is_rising = self.rising.test(lane);
        let (gap, layer) = if is_rising {
            let above = blocks & u32::MAX.checked_shl(block + 1).unwrap_or(0);
            let gap =
                if above == 0 { shell.layers() } else { ((above.trailing_zeros() << visible.shift) + 1) as usize };
            (gap.min(shell.layers()), gap.min(shell.layers()) - 1)
        } else {
            let below = blocks & ((1 << block) - 1);
            let gap = (u32::BITS - below.leading_zeros()) << visible.shift;
            (gap as usize, gap as usize)
        };
        let radius = shell.bounds()[layer + 1];
        if (radius <= exit) != is_rising {
            self.locate(lane, shell, exit);
            return true;
        }
        let u = ((radius - entry) * self.scale.get(lane)).clamp(0.0, 1.0);
        self.gap[lane] = gap as u32;
        self.u.set(lane, u);
        // Rounded as in `cross`.
        self.tau[lane] = (u as f32 * exit as f32 / radius as f32).clamp(0.0, 1.0);
        self.height.set(lane, radius);
        self.place[lane] = if is_rising { 0.0 } else { 1.0 };
        false
    }
}
