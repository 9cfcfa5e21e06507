//! The ways of several rays through their columns, a gap each at a time: [`ColumnTraversal`] in the machine's vectors,
//! with the numbers that it has.

use super::Shell;
use crate::walk::packet::{HALF, LANES, Lanes, PacketColumns, lanes};
use fearless_simd::{Simd, f64x8, mask64x8, prelude::*, u32x16};
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;

/// Rays that go up or down through their columns.
pub(crate) struct PacketTraversal<'c, T> {
    columns: &'c PacketColumns,
    /// The gap that each is in, and that in which it leaves its column.
    pub gap: Lanes<u32>,
    out: Lanes<u32>,
    /// Bits of those that rise.
    rising: u32,
    /// Whether they have come through a layer.
    is_on_layer: bool,
    /// Where they have entered the gap, as [`super::RayPoint`].
    u: Lanes<f64>,
    tau: Lanes<T>,
    rho: Lanes<f64>,
    curvature: Lanes<f64>,
}

/// The ways of rays through a gap each: where they enter and leave it, between the edge points and between the layers;
/// the relative change of height; the length.
pub(crate) struct GapCrossings<T> {
    pub tau: [Lanes<T>; 2],
    pub place: [Lanes<T>; 2],
    pub eps: Lanes<T>,
    pub length: Lanes<T>,
}

impl<'c, T: Real> PacketTraversal<'c, T> {
    /// Into columns, each from its gap to the gap `out`.
    #[inline(always)]
    pub fn new<V: Simd>(simd: V, columns: &'c PacketColumns, gap: &Lanes<u32>, out: &Lanes<u32>) -> Self {
        let (entry, exit) = (&columns.entry.rho, &columns.exit.rho);
        let load = |row: &Lanes<f64>, half: usize| f64x8::from_slice(simd, &row[half..half + HALF]);
        let rises = |half| load(exit, half).simd_ge(load(entry, half)).to_bitmask() as u32;
        PacketTraversal {
            columns,
            gap: *gap,
            out: *out,
            rising: rises(0) | rises(HALF) << HALF,
            is_on_layer: false,
            u: [0.0; LANES],
            tau: [T::zero(); LANES],
            rho: *entry,
            curvature: columns.curvature,
        }
    }

    /// Whether a ray rises.
    #[inline(always)]
    pub fn rises(&self, lane: usize) -> bool {
        self.rising >> lane & 1 != 0
    }

    /// The fraction of its column's length at which a ray has entered its gap.
    #[inline(always)]
    pub fn u(&self, lane: usize) -> f64 {
        self.u[lane]
    }

    /// Bits of the rays that leave their gaps through a layer.
    #[inline(always)]
    pub fn passing<V: Simd>(&self, simd: V) -> u32 {
        let [gap, out] = [&self.gap, &self.out].map_inline(|row| u32x16::from_slice(simd, row));
        gap.simd_ne(out).to_bitmask() as u32
    }

    /// Crosses the gaps of the rays whose bits are set. Ways of others mean nothing.
    #[inline(always)]
    pub fn cross<V: Simd>(&mut self, simd: V, shell: &Shell<T>, active: u32) -> GapCrossings<T> {
        let passing = self.passing(simd);
        let (mut low, mut high) = ([0.0; LANES], [1.0; LANES]);
        for lane in lanes(active) {
            // Below and above all layers one of the two is none.
            let gap = self.gap[lane] as usize;
            low[lane] = shell.radius.get(gap.wrapping_sub(1)).copied().unwrap_or(0.0);
            high[lane] = shell.radius.get(gap).copied().unwrap_or(f64::INFINITY);
        }
        // In f64: u, tau and eps at the gap's end, length, heights of both ends above the layer below, 1 / thickness.
        let mut wide = [[0.0; LANES]; 6];
        for half in [0, HALF] {
            self.cross_half(simd, half, passing, [&low, &high], &mut wide);
        }
        let [tau, eps, length, above_a, above_b, inverse] = &wide;
        let (before, is_on_layer) = (self.tau, self.is_on_layer);
        let zero = [T::zero(); LANES];
        let mut ways = GapCrossings { tau: [before, zero], place: [zero; 2], eps: zero, length: zero };
        for i in 0..LANES {
            ways.tau[1][i] = T::of(tau[i]);
            ways.eps[i] = T::of(eps[i]).max(T::of(T::ROUNDING - 1.0));
            ways.length[i] = T::of(length[i]);
        }
        for i in 0..LANES {
            let (rises, passes) = (self.rising >> i & 1 != 0, passing >> i & 1 != 0);
            let place = |above: f64| {
                let w = (T::of(above) * T::of(inverse[i])).max(T::zero()).min(T::one());
                if rises { w } else { T::one() - w }
            };
            let (a, b) = (place(above_a[i]), place(above_b[i]));
            ways.place[0][i] = if is_on_layer { T::zero() } else { a };
            ways.place[1][i] = if passes { T::one() } else { b };
        }
        (self.tau, self.is_on_layer) = (ways.tau[1], true);
        ways
    }

    #[inline(always)]
    fn cross_half<V: Simd>(
        &mut self,
        simd: V,
        half: usize,
        passing: u32,
        [low, high]: [&Lanes<f64>; 2],
        wide: &mut [Lanes<f64>; 6],
    ) {
        let of = half..half + HALF;
        let load = |row: &Lanes<f64>| f64x8::from_slice(simd, &row[of.clone()]);
        let mask = |bits: u32| mask64x8::from_bitmask(simd, u64::from(bits >> half & 0xff));
        let (zero, one) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, 1.0));
        let clamp = |f: f64x8<V>| {
            let f = f.simd_lt(zero).select(zero, f);
            f.simd_gt(one).select(one, f)
        };
        let PacketColumns { entry, exit, scale, .. } = self.columns;
        let (low, high) = (load(low), load(high));
        let (entry_rho, exit_rho) = (load(&entry.rho), load(&exit.rho));
        let (passing, rising) = (mask(passing), mask(self.rising));
        let radius = rising.select(high, low);
        let curvature = one / radius;
        let u = clamp((radius - entry_rho) * load(scale));
        let tau = clamp(u * exit_rho * curvature);
        let (u, tau) = (passing.select(u, one), passing.select(tau, one));
        let rho = passing.select(radius, exit_rho);
        let before = load(&self.rho);
        let length = (load(&exit.t) - load(&entry.t)) * (u - load(&self.u));
        let eps = (rho - before) * load(&self.curvature);
        let numbers = [tau, eps, length, before - low, rho - low, one / (high - low)];
        for (numbers, row) in numbers.into_iter().zip(wide) {
            numbers.store_slice(&mut row[of.clone()]);
        }
        u.store_slice(&mut self.u[of.clone()]);
        rho.store_slice(&mut self.rho[of.clone()]);
        curvature.store_slice(&mut self.curvature[of]);
    }

    /// Into the next gaps.
    #[inline(always)]
    pub fn pass(&mut self) {
        for i in 0..LANES {
            let gap = self.gap[i];
            self.gap[i] = if self.rises(i) { gap.wrapping_add(1) } else { gap.wrapping_sub(1) };
        }
    }
}
