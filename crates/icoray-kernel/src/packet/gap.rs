//! Traverses the gaps in the columns of a packet if each layer has one radius: `general/cross.rs` in vectors.

use super::frame::PacketFrame;
use super::lanes::Lanes;
use super::layers::{Crossing, Layers, next_shown};
use super::medium::number;
use super::part::all;
use super::read::ConcentricWay;
use crate::column::{Chord, Shell, Values};
use crate::lit::FrustumInterpolant;
use fearless_simd::prelude::*;
use icoray_grid::array::MapInline;
use icoray_simd::{Floats, Machine, Mask, Numbers, Pairs, Table, Wide, wide_mask};

/// Layers of one radius each; `SCENE` is [`Layers::HAS_SCENE`].
#[derive(Clone, Copy)]
pub(super) struct Concentric<'t, const SCENE: bool> {
    shell: &'t Shell,
    /// [`Shell::bounds`].
    bounds: Pairs<'t, f64>,
}

/// The points at which lanes leave their gaps.
#[derive(Clone, Copy)]
pub(super) struct ConcentricEnd<V: Machine> {
    tau: Floats<V>,
    height: Wide<V>,
    place: Floats<V>,
}

impl<'t, const SCENE: bool> Concentric<'t, SCENE> {
    /// The layers of a shell; `None` if they are too many for gathers.
    #[inline]
    pub fn new(shell: &'t Shell) -> Option<Self> {
        Some(Concentric { shell, bounds: Pairs::new(shell.bounds())? })
    }
}

impl<const SCENE: bool> Layers for Concentric<'_, SCENE> {
    const HAS_HEIGHTS: bool = false;
    const HAS_SCENE: bool = SCENE;
    type End<V: Machine> = ConcentricEnd<V>;
    type Way<V: Machine> = ConcentricWay<V>;

    #[inline(always)]
    fn bases<V: Machine>(&self, _: V, cells: Numbers<V>, _: u32) -> Numbers<V> {
        cells
    }

    #[inline(always)]
    fn base(&self, cell: u32) -> u32 {
        cell
    }

    #[inline]
    fn locate<V: Machine>(&self, lanes: &mut Lanes<V>, lane: usize, height: f64) {
        let gap = self.shell.gap(height);
        lanes.gap[lane] = gap as u32;
        let [low, high] = [self.shell.bounds()[gap], self.shell.bounds()[gap + 1]];
        // Rounded as in `cross`.
        lanes.place[lane] = ((height - low) as f32 / (high - low) as f32).clamp(0.0, 1.0);
    }

    #[inline(always)]
    fn enter<V: Machine>(&self, _: V, _: &mut Lanes<V>, _: u32) {}

    #[inline(always)]
    fn cross<V: Machine>(&self, simd: V, lanes: &Lanes<V>) -> Crossing<V, ConcentricEnd<V>> {
        let [low, high] = simd.gather_f64_pair(self.bounds, lanes.gap);
        let (rising, one) = (wide_mask::<V>(lanes.rising), Wide::splat(simd, 1.0));
        let ahead = high.over(rising, low);
        // Rising rays pass a layer if it is at most at the height of their column's exit, falling ones if it is above
        // it.
        let passes = lanes.rising.simd_eq(ahead.le(lanes.rho[1]).narrow());
        let wide = wide_mask::<V>(passes);
        let u = ((ahead - lanes.rho[0]) * lanes.scale).fraction(simd);
        let (none, whole) = (all(simd, 0.0), all(simd, 1.0));
        let tau = (u.narrow() * lanes.rho[1].narrow() / ahead.narrow()).max(none).min(whole);
        let (u, height) = (u.over(wide, one), ahead.over(wide, lanes.rho[1]));
        let place = ((height - low).narrow() / (high - low).narrow()).max(none).min(whole);
        let eps = (height - lanes.height).narrow() / lanes.height.narrow();
        Crossing {
            passes,
            u,
            // With an almost vanishing core radius it would round to -1.
            eps: eps.max(all(simd, 0.5 * f32::EPSILON - 1.0)),
            length: ((lanes.t[1] - lanes.t[0]) * (u - lanes.u)).narrow(),
            end: ConcentricEnd {
                tau: passes.select(tau, whole),
                height,
                place: passes.select(lanes.rising.select(whole, none), place),
            },
        }
    }

    #[inline(always)]
    fn rising<V: Machine>(lanes: &Lanes<V>, _: &Crossing<V, ConcentricEnd<V>>) -> Mask<V> {
        lanes.rising
    }

    #[inline(always)]
    fn way<V: Machine>(lanes: &Lanes<V>, crossing: &Crossing<V, ConcentricEnd<V>>) -> ConcentricWay<V> {
        ConcentricWay {
            weights: lanes.weights,
            place: [lanes.place, crossing.end.place],
            tau: [lanes.tau, crossing.end.tau],
            eps: crossing.eps,
        }
    }

    #[inline(always)]
    fn pass<V: Machine>(
        &self,
        simd: V,
        lanes: &mut Lanes<V>,
        crossing: &Crossing<V, ConcentricEnd<V>>,
        passing: Mask<V>,
        leaving: Mask<V>,
    ) {
        let end = &crossing.end;
        let (one, none) = (number(simd, 1), number(simd, 0));
        let up = (passing & lanes.rising).select(one, none);
        let down = (passing & !lanes.rising).select(one, none);
        lanes.gap = lanes.gap + up - down;
        let wide = wide_mask::<V>(passing);
        lanes.u = crossing.u.over(wide, lanes.u);
        lanes.height = end.height.over(wide, lanes.height);
        lanes.tau = passing.select(end.tau, lanes.tau);
        // Behind a layer begins the other side of the next gap.
        let place = lanes.rising.select(all(simd, 0.0), all(simd, 1.0));
        lanes.place = passing.select(place, leaving.select(end.place, lanes.place));
    }

    /// As [`Shell::gap`], searched from the gaps of the lanes.
    #[inline(always)]
    fn exits<V: Machine>(&self, simd: V, lanes: &Lanes<V>, _: Mask<V>) -> (Numbers<V>, Option<Floats<V>>) {
        let (Concentric { shell, bounds }, height) = (*self, lanes.rho[1]);
        let (one, none) = (number(simd, 1), number(simd, 0));
        let (first, per_height) = (Wide::splat(simd, shell.inner()), Wide::splat(simd, shell.buckets_per_height()));
        let bucket = ((height - first) * per_height).narrow().max(all(simd, 0.0)).to_int::<Numbers<V>>();
        let mut gap = match Table::new(shell.below()) {
            Some(below) => simd.gather_u32(below, bucket),
            None => lanes.gap,
        };
        loop {
            let [low, high] = simd.gather_f64_pair(bounds, gap);
            let (is_above, is_below) = (high.le(height).narrow(), height.lt(low).narrow());
            if (is_above | is_below).all_false() {
                let place = (height - low).narrow() / (high - low).narrow();
                return (gap, Some(place.max(all(simd, 0.0)).min(all(simd, 1.0))));
            }
            gap = gap + is_above.select(one, none) - is_below.select(one, none);
        }
    }

    #[inline(never)]
    fn skip<V: Machine>(&self, lanes: &mut Lanes<V>, lane: usize, blocks: u32, shift: u32) -> bool {
        let [entry, exit] = [0, 1].map_inline(|k: usize| lanes.rho[k].get(lane));
        let is_rising = lanes.rising.test(lane);
        let (gap, layer) = next_shown(blocks, shift, lanes.gap[lane], is_rising, self.shell.layers());
        let radius = self.shell.bounds()[layer + 1];
        if (radius <= exit) != is_rising {
            self.locate(lanes, lane, exit);
            return true;
        }
        let u = ((radius - entry) * lanes.scale.get(lane)).clamp(0.0, 1.0);
        lanes.gap[lane] = gap as u32;
        lanes.u.set(lane, u);
        // Rounded as in `cross`.
        lanes.tau[lane] = (u as f32 * exit as f32 / radius as f32).clamp(0.0, 1.0);
        lanes.height.set(lane, radius);
        lanes.place[lane] = if is_rising { 0.0 } else { 1.0 };
        false
    }

    fn interpolant<V: Machine, const N: usize>(
        lanes: &Lanes<V>,
        lane: usize,
        frame: &PacketFrame<'_>,
        crossing: &Crossing<V, ConcentricEnd<V>>,
    ) -> Option<FrustumInterpolant<f32, N>> {
        if SCENE {
            return None;
        }
        let weights = lanes.weights.map(|end| end.map(|row| row[lane]));
        let (upper, layers) = (lanes.gap[lane] as usize, frame.packets.shell.layers());
        let [low, high] = [upper - 1, upper].map(|layer| {
            let vertex = |cell: u32| {
                let mut values: Values<f32, N> = [0.0; N];
                values[0] = frame.packets.source.value(cell, layer);
                if N == 4 {
                    values[1..].copy_from_slice(&frame.gradients.at(cell as usize * layers + layer));
                }
                values
            };
            Chord::over(lanes.cells.map(|row| vertex(row[lane])), &weights)
        });
        let [from, to] = [lanes.place[lane], crossing.end.place[lane]].map(|place| low.mix(high, place));
        Some(from.interpolant(&to, [lanes.tau[lane], crossing.end.tau[lane]], crossing.eps[lane]))
    }
}
