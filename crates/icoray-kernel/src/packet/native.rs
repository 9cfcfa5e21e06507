//! Traverses the gaps in the columns of a packet if layers have separate heights over each cell: the facets of
//! [`general::wedge`](crate::general) in vectors.
//!
//! With ψ of the layers below and above a gap (`ψ = Σ α/R`, linear along the ray, 1 on a layer's facet), a ray is in
//! the gap where `ψ' < 1 <= ψ`. The gap in which it leaves a column follows from the ψ at the exit alone, which depend
//! on the two vertices of that side and decrease from layer to layer for any rounding. All layers between the gap at
//! the entry and that gap are crossed in one direction, so that a ray crosses no layer twice and stays in no gap for
//! ever.
//!
//! With `x = (ψ - 1)/(ψ - ψ')` the value is `(1 - x) N + x N'`, where `N = Σ (α/R)·g` of the values g on the lower layer
//! and N' on the upper one are linear along the ray: [`NativeWay`].

use super::heights::{Corners, HeightTable};
use super::lanes::{Lanes, lanes_of};
use super::layers::{Crossing, Layers, next_shown};
use super::medium::number;
use super::native_way::NativeWay;
use super::part::all;
use fearless_simd::prelude::*;
use icoray_grid::array::MapInline;
use icoray_grid::heights::Heights;
use icoray_simd::{Floats, Machine, Mask, Numbers, Wide, wide_mask};

/// The layers for packets.
#[derive(Clone, Copy)]
pub(super) struct Native<'t> {
    table: HeightTable<'t>,
}

/// The points at which lanes leave their gaps.
#[derive(Clone, Copy)]
pub(super) struct NativeEnd<V: Machine> {
    rising: Mask<V>,
    way: NativeWay<V>,
}

/// The gap of a lane that is still to be searched when it enters its next column.
const SOUGHT: u32 = u32::MAX;

/// The place of a lane that is on no layer.
const BETWEEN: f32 = 0.5;

/// ψ at the entry and the exit of each lane's column, and the contributions of the second and the third vertex to it.
struct Facet<V: Machine> {
    psi: [Wide<V>; 2],
    parts: [[Wide<V>; 2]; 2],
}

impl<V: Machine> Facet<V> {
    #[inline(always)]
    fn of(lanes: &Lanes<V>, weights: &[Corners<V>; 2], inverse: &Corners<V>) -> Self {
        let [[entry, b0, c0], [exit, b1, c1]] =
            [Self::end(lanes.rho[0], &weights[0], inverse), Self::end(lanes.rho[1], &weights[1], inverse)];
        Facet { psi: [entry, exit], parts: [[b0, c0], [b1, c1]] }
    }

    /// ψ at one end, and the contributions to it.
    #[inline(always)]
    fn end(rho: Wide<V>, [a, b, c]: &Corners<V>, inverse: &Corners<V>) -> [Wide<V>; 3] {
        let (second, third) = (*b * inverse[1], *c * inverse[2]);
        // A sum of positive numbers: it decreases where they decrease, for any rounding.
        [rho * (*a * inverse[0] + (second + third)), rho * second, rho * third]
    }

    /// ψ at `u`.
    #[inline(always)]
    fn at(&self, u: Wide<V>) -> Wide<V> {
        self.psi[0] + u * (self.psi[1] - self.psi[0])
    }

    /// The contributions of the second and the third vertex.
    #[inline(always)]
    fn weights(&self) -> [[Floats<V>; 2]; 2] {
        let [[b0, c0], [b1, c1]] = self.parts;
        [[b0.narrow(), c0.narrow()], [b1.narrow(), c1.narrow()]]
    }
}

/// Weights of the three vertices at the ends of each lane's column.
#[inline(always)]
fn weights<V: Machine>(simd: V, lanes: &Lanes<V>) -> [Corners<V>; 2] {
    let [[b0, c0], [b1, c1]] = lanes.wide_weights;
    let (zero, one) = (Wide::splat(simd, 0.0), Wide::splat(simd, 1.0));
    [[(one - b0 - c0).max(zero), b0, c0], [(one - b1 - c1).max(zero), b1, c1]]
}

/// The fraction of `depth` = ψ - ψ' by which ψ exceeds 1.
#[inline(always)]
fn place<V: Machine>(simd: V, psi: Wide<V>, depth: Floats<V>) -> Floats<V> {
    let (zero, one) = (all(simd, 0.0), all(simd, 1.0));
    let place = ((psi - Wide::splat(simd, 1.0)).narrow() / depth).max(zero).min(one);
    // Facets that meet have no space in between.
    depth.simd_gt(zero).select(place, all(simd, 0.5))
}

impl<'t> Native<'t> {
    /// The layers at `heights`; `None` if they are too many for gathers.
    #[inline]
    pub fn new(heights: &'t Heights<'_>) -> Option<Self> {
        Some(Native { table: HeightTable::new(heights)? })
    }

    /// ψ of a layer at the entry (0) or exit (1) of a lane's column, rounded as in vectors.
    #[inline]
    fn psi<V: Machine>(&self, lanes: &Lanes<V>, lane: usize, end: usize, layer: usize) -> f64 {
        let [b, c] = lanes.wide_weights[end].map_inline(|row| row.get(lane));
        let inverse = self.table.inverses_at(lanes.cells.map_inline(|row| row[lane]), layer);
        lanes.rho[end].get(lane) * ((1.0 - b - c).max(0.0) * inverse[0] + (b * inverse[1] + c * inverse[2]))
    }

    /// The gap that contains the entry or exit of a lane's column.
    #[inline(never)]
    fn gap_at<V: Machine>(&self, lanes: &Lanes<V>, lane: usize, end: usize) -> u32 {
        let (mut low, mut high) = (0, self.table.layers());
        // Rays from outside enter above all layers.
        if self.psi(lanes, lane, end, high - 1) >= 1.0 {
            return high as u32;
        }
        while low < high {
            let middle = (low + high) / 2;
            if self.psi(lanes, lane, end, middle) >= 1.0 { low = middle + 1 } else { high = middle }
        }
        low as u32
    }

    /// Lanes whose rays are above the layer above their gap at their columns' exits, and those whose rays are below the
    /// layer below it.
    #[inline(always)]
    fn moves<V: Machine>(&self, simd: V, gap: Numbers<V>, [below, above]: [Wide<V>; 2]) -> [Mask<V>; 2] {
        let one = Wide::splat(simd, 1.0);
        let up = above.ge(one).narrow() & gap.simd_lt(self.table.layers() as u32);
        let down = below.lt(one).narrow() & gap.simd_gt(0);
        [up, down & !up]
    }
}

impl Layers for Native<'_> {
    const HAS_HEIGHTS: bool = true;
    const HAS_SCENE: bool = true;
    type End<V: Machine> = NativeEnd<V>;
    type Way<V: Machine> = NativeWay<V>;

    #[inline(always)]
    fn bases<V: Machine>(&self, simd: V, cells: Numbers<V>, bits: u32) -> Numbers<V> {
        self.table.bases(simd, cells, bits)
    }

    #[inline]
    fn base(&self, cell: u32) -> u32 {
        self.table.base(cell)
    }

    #[inline]
    fn locate<V: Machine>(&self, lanes: &mut Lanes<V>, lane: usize, _: f64) {
        lanes.gap[lane] = SOUGHT;
    }

    #[inline(always)]
    fn enter<V: Machine>(&self, simd: V, lanes: &mut Lanes<V>, entered: u32) {
        lanes.place = super::mask::<V>(simd, entered).select(all(simd, BETWEEN), lanes.place);
        let sought = lanes.gap.simd_eq(SOUGHT).to_bitmask() as u32 & entered;
        for lane in lanes_of(sought) {
            lanes.gap[lane] = self.gap_at(lanes, lane, 0);
        }
    }

    #[inline(always)]
    fn cross<V: Machine>(&self, simd: V, lanes: &Lanes<V>) -> Crossing<V, NativeEnd<V>> {
        let weights = weights(simd, lanes);
        let inverses = self.table.inverses(simd, lanes, lanes.gap);
        let (low, high) = (Facet::of(lanes, &weights, &inverses[0]), Facet::of(lanes, &weights, &inverses[1]));
        let [up, down] = self.moves(simd, lanes.gap, [low.psi[1], high.psi[1]]);
        let (passes, wide_up) = (up | down, wide_mask::<V>(up));
        let (from, to) = (high.psi[0].over(wide_up, low.psi[0]), high.psi[1].over(wide_up, low.psi[1]));
        let one = Wide::splat(simd, 1.0);
        let root = ((one - from) / (to - from)).fraction(simd).max(lanes.u);
        // Two columns each find the ψ of the side between them to a rounding: a ray may be beyond its layer at once.
        let is_beyond = from.ge(one).narrow().simd_eq(up);
        let root = lanes.u.over(wide_mask::<V>(is_beyond), root);
        let u = root.over(wide_mask::<V>(passes), one);
        let (above, lower) = ([high.at(lanes.u), high.at(u)], [low.at(lanes.u), low.at(u)]);
        let (start, end) = (lower[0] - above[0], lower[1] - above[1]);
        let (zero, whole) = (all(simd, 0.0), all(simd, 1.0));
        let (first, last) = (start.narrow(), end.narrow());
        let is_on = lanes.place.simd_eq(0.0) | lanes.place.simd_eq(1.0);
        let places = [
            is_on.select(lanes.place, place(simd, lower[0], first)),
            passes.select(up.select(whole, zero), place(simd, lower[1], last)),
        ];
        // There the value has no limit either; it is taken as linear.
        let eps = (end - start).narrow() / first;
        let eps = (first.simd_gt(zero) & eps.simd_le(MOST_EPS)).select(eps, zero);
        let eps = eps.max(all(simd, 0.5 * f32::EPSILON - 1.0));
        let way = NativeWay {
            weights: [low.weights(), high.weights()],
            above: [above[0].narrow(), above[1].narrow()],
            u: [lanes.u.narrow(), u.narrow()],
            place: places,
            eps,
        };
        let length = ((lanes.t[1] - lanes.t[0]) * (u - lanes.u)).narrow();
        Crossing { passes, u, eps, length, end: NativeEnd { rising: up, way } }
    }

    #[inline(always)]
    fn rising<V: Machine>(_: &Lanes<V>, crossing: &Crossing<V, NativeEnd<V>>) -> Mask<V> {
        crossing.end.rising
    }

    #[inline(always)]
    fn way<V: Machine>(_: &Lanes<V>, crossing: &Crossing<V, NativeEnd<V>>) -> NativeWay<V> {
        crossing.end.way
    }

    #[inline(always)]
    fn pass<V: Machine>(
        &self,
        simd: V,
        lanes: &mut Lanes<V>,
        crossing: &Crossing<V, NativeEnd<V>>,
        passing: Mask<V>,
        _: Mask<V>,
    ) {
        let rising = crossing.end.rising;
        let (one, none) = (number(simd, 1), number(simd, 0));
        let (up, down) = ((passing & rising).select(one, none), (passing & !rising).select(one, none));
        lanes.gap = lanes.gap + up - down;
        lanes.u = crossing.u.over(wide_mask::<V>(passing), lanes.u);
        // Behind a layer begins the other side of the next gap.
        lanes.place = passing.select(rising.select(all(simd, 0.0), all(simd, 1.0)), lanes.place);
    }

    #[inline(always)]
    fn exits<V: Machine>(&self, simd: V, lanes: &Lanes<V>, active: Mask<V>) -> (Numbers<V>, Option<Floats<V>>) {
        let weights = weights(simd, lanes);
        let (one, none) = (number(simd, 1), number(simd, 0));
        let mut gap = lanes.gap;
        loop {
            let [low, high] = self.table.inverses(simd, lanes, gap);
            let [below, ..] = Facet::end(lanes.rho[1], &weights[1], &low);
            let [above, ..] = Facet::end(lanes.rho[1], &weights[1], &high);
            let [up, down] = self.moves(simd, gap, [below, above]);
            let (up, down) = (up & active, down & active);
            if (up | down).all_false() {
                return (gap, None);
            }
            gap = gap + up.select(one, none) - down.select(one, none);
        }
    }

    #[inline(never)]
    fn skip<V: Machine>(&self, lanes: &mut Lanes<V>, lane: usize, blocks: u32, shift: u32) -> bool {
        let gap = lanes.gap[lane];
        let is_rising = self.psi(lanes, lane, 1, gap as usize) >= 1.0;
        let (next, layer) = next_shown(blocks, shift, gap, is_rising, self.table.layers());
        let [from, to] = [0, 1].map(|end: usize| self.psi(lanes, lane, end, layer));
        if (to >= 1.0) != is_rising {
            lanes.gap[lane] = self.gap_at(lanes, lane, 1);
            return true;
        }
        let is_beyond = (from >= 1.0) == is_rising;
        let reached = lanes.u.get(lane);
        let u = if is_beyond { reached } else { ((1.0 - from) / (to - from)).clamp(0.0, 1.0).max(reached) };
        lanes.gap[lane] = next as u32;
        lanes.u.set(lane, u);
        lanes.place[lane] = if is_rising { 0.0 } else { 1.0 };
        false
    }
}

/// Relative change beyond which a value is taken as linear.
const MOST_EPS: f32 = 1e9;
