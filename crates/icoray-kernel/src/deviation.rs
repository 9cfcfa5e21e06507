//! The effect on a ray's light of drawing a coarser grid than the model's.
//!
//! Let κ and c be extinction and colour on the coarser grid, κ′ and c′ on the finer one, T the transmittance on the
//! coarser one and B the light that arrives from behind on the finer one. The light along a ray then differs by
//! `∫ T ((κ - κ′)(c′ - B) + κ (c - c′))`. Colours are 0 to 1, so that a frustum in which κ differs by at most K and the
//! colour by at most C adds no more than T times K times its length, and C times what it absorbs.

use crate::transfer::KernelKnot;
use fearless_simd::{Level, dispatch};
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::array::{MapInline, partition_point};
use icoray_grid::deviation::{GapFinder, GapRange, GridPair};
use icoray_grid::occupancy::OccupancyMask;
use rayon::prelude::*;

/// K and C in each gap over each triangle of a coarser grid.
#[derive(Debug)]
pub struct Deviations {
    /// Gaps over a triangle.
    pub(crate) gaps: usize,
    /// The upper halves of K and C in single precision, rounded up, K in the upper half of the word; 0 where neither
    /// grid shows anything.
    pub(crate) words: Vec<u32>,
    /// [`GridPair::lift`].
    lift: f64,
    /// For the innermost and the outermost layer the radii between which facets of the finer and of the coarser grid
    /// lie, and the greatest extinction there.
    ends: [([[f64; 2]; 2], f64); 2],
}

impl Deviations {
    /// The deviations of a field that is shown through these knots.
    pub fn new(pair: &GridPair, knots: &[KernelKnot]) -> Self {
        let gaps = pair.radius.len().saturating_sub(1);
        let mut words = vec![0; gaps * pair.coarse.triangles()];
        let ends = pair.ends();
        let function = LinearPart::all(knots);
        let over = |finder: &mut GapFinder, (triangle, words): (usize, &mut [u32])| {
            let mut densest = [0.0f64; 2];
            let ranges = finder.gaps(triangle as u32);
            dispatch!(Level::new(), _simd => for (gap, (word, range)) in words.iter_mut().zip(ranges).enumerate() {
                let effect = Effect::of(&function, &range);
                *word = effect.word();
                for (densest, _) in densest.iter_mut().zip(&ends).filter(|(_, end)| end.contains(&gap)) {
                    *densest = densest.max(effect.densest);
                }
            });
            densest
        };
        let all = words.par_chunks_mut(gaps).enumerate().map_init(|| GapFinder::new(*pair), over);
        let [inner, outer] = all.reduce(|| [0.0; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        let [first, last] = [pair.radius[0], pair.radius[gaps]];
        let around = |radius: f64| pair.facets().map(|grid| grid.map(|facet| facet * radius));
        Deviations { gaps, words, lift: pair.lift(), ends: [(around(first), inner), (around(last), outer)] }
    }

    /// The factor by which the radii of the coarser grid's layers are larger.
    pub fn lift(&self) -> f64 {
        self.lift
    }

    /// The error of a ray from `eye` along a unit vector where facets of one grid lie outside of the other's, at the
    /// outermost layer and at the innermost one, below which there is an opaque core or nothing. The shell of the
    /// coarser grid is thicker by the factor by which it is lifted, and so is the unit of the opacity: a depth x
    /// changes by at most that part of it, and e^-x by less. A ray that misses both shells has no error.
    pub fn error_at_ends(&self, eye: DVec3, dir: DVec3, has_core: bool) -> f64 {
        let nearest = eye.cross(dir).length();
        let outermost = self.ends[1].0.into_iter().flatten().fold(0.0, f64::max);
        if nearest >= outermost || eye.length() > outermost && eye.dot(dir) > 0.0 {
            return 0.0;
        }
        let half = |radius: f64| (radius * radius - nearest * nearest).max(0.0).sqrt();
        let [inner, outer] = self.ends.map(|([fine, coarse], extinction)| {
            let (low, high) = (fine[0].min(coarse[0]), fine[1].max(coarse[1]));
            let is_behind = eye.length() > high && eye.dot(dir) > 0.0;
            // Where it crosses the facets of one grid before those of the other.
            let crossing = (half(coarse[1]) - half(fine[0])).max(half(fine[1]) - half(coarse[0]));
            let grazes = nearest >= low && nearest < high && !is_behind;
            let length = match grazes {
                _ if is_behind => 0.0,
                true => half(high),
                false => crossing,
            };
            let starts_between = (low..high).contains(&eye.length());
            (length * extinction, grazes || starts_between, nearest < low)
        });
        // A ray crosses both layers twice, unless it ends at the core. A grazing one may meet that of one grid only, and
        // so may one that begins below the facets of one grid.
        let ends = has_core && inner.2;
        let at_core = if has_core && inner.1 { 1.0 } else { inner.0 };
        let times = if ends { 1.0 } else { 2.0 };
        (times * (at_core + outer.0) + self.lift - 1.0).min(1.0)
    }

    /// The gaps in which either grid shows anything, between this number of layers.
    pub fn visible(&self, grid: &Grid, layers: usize) -> OccupancyMask<'static> {
        let mut visible = OccupancyMask::none(grid.triangles(), layers);
        for (blocks, words) in visible.blocks.to_mut().iter_mut().zip(self.words.chunks(self.gaps)) {
            for gap in (1..layers).filter(|gap| words[gap - 1] != 0) {
                *blocks |= 1 << ((gap - 1) >> visible.shift);
                visible.top = visible.top.max(gap);
            }
        }
        visible
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        size_of_val(self.words.as_slice())
    }
}

/// The most by which extinction and colour of two grids differ.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Effect {
    extinction: f64,
    color: f64,
    /// The greatest extinction of either grid.
    densest: f64,
}

impl Effect {
    /// That on values of a range through a transfer function.
    #[inline(always)]
    fn of(function: &[LinearPart], &GapRange { low, high, deviation }: &GapRange) -> Self {
        if low > high {
            return Effect { extinction: 0.0, color: 0.0, densest: 0.0 };
        }
        if deviation == f64::INFINITY {
            // One grid may show nothing where the other does.
            let densest = function.iter().fold(0.0, |most: f64, part| most.max(part.channels[3]));
            return Effect { extinction: densest, color: 1.0, densest };
        }
        let [low, high] = [low - deviation, high + deviation];
        let first = partition_point(&function[1..], |part| part.value < low);
        let mut part = &function[first];
        let mut least = part.channels_at(low);
        let (mut most, mut steepest) = (least, part.slopes.map_inline(f64::abs));
        for next in function[first + 1..].iter().take_while(|next| next.value <= high) {
            part = next;
            (least, most) = (each(least, part.channels, f64::min), each(most, part.channels, f64::max));
            steepest = each(steepest, part.slopes.map_inline(f64::abs), f64::max);
        }
        let end = part.channels_at(high);
        (least, most) = (each(least, end, f64::min), each(most, end, f64::max));
        // A step's slope is infinite, and nothing deviates by 0 there.
        let [r, g, b, extinction] = [0, 1, 2, 3].map_inline(|k| match deviation {
            0.0 => 0.0,
            deviation => (steepest[k] * deviation).min(most[k] - least[k]),
        });
        Effect { extinction, color: r.max(g).max(b), densest: most[3] }
    }

    fn word(self) -> u32 {
        if self.densest == 0.0 {
            return 0;
        }
        // More than the number in single precision, of which rounding may have made less.
        let half = |number: f64| ((number.min(1e30) as f32).to_bits() >> 16) + 1;
        half(self.extinction) << 16 | half(self.color)
    }
}

/// A function of each channel.
#[inline(always)]
fn each(a: [f64; 4], b: [f64; 4], of: impl Fn(f64, f64) -> f64) -> [f64; 4] {
    [0, 1, 2, 3].map_inline(|k| of(a[k], b[k]))
}

/// A part of a transfer function in which colour and extinction are linear.
struct LinearPart {
    /// Value of the knot at which the part begins; of the first knot for the part below it.
    value: f64,
    /// Colour and extinction at the knot.
    channels: [f64; 4],
    /// Their change per unit of value; infinite at a step.
    slopes: [f64; 4],
}

impl LinearPart {
    /// The part below all knots, and the one above each knot.
    fn all(knots: &[KernelKnot]) -> Vec<Self> {
        let ends = [knots[..1].iter(), knots.iter(), knots[knots.len() - 1..].iter()];
        let all: Vec<&KernelKnot> = ends.into_iter().flatten().collect();
        let part = |pair: &[&KernelKnot]| {
            let [from, to] = [pair[0].channels(), pair[1].channels()];
            let width = pair[1].value - pair[0].value;
            let slope = |from: f64, to: f64| if from == to { 0.0 } else { (to - from) / width };
            LinearPart { value: pair[0].value, channels: from, slopes: each(from, to, slope) }
        };
        all.windows(2).map(part).collect()
    }

    #[inline(always)]
    fn channels_at(&self, value: f64) -> [f64; 4] {
        each(self.channels, self.slopes, |channel, slope| channel + (value - self.value) * slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use icoray_test_support::Random;

    /// Colour and extinction at a value, on the side of the spans below where it is a step.
    fn channels(knots: &[KernelKnot], value: f64) -> [f64; 4] {
        let above = knots.partition_point(|knot| knot.value < value);
        let Some(to) = knots.get(above) else { return knots[knots.len() - 1].channels() };
        let Some(from) = above.checked_sub(1).map(|below| &knots[below]) else { return to.channels() };
        let part = (value - from.value) / (to.value - from.value);
        let (from, to) = (from.channels(), to.channels());
        [0, 1, 2, 3].map(|k| from[k] + part * (to[k] - from[k]))
    }

    /// The effect of all knots and of all pairs of neighbouring knots in a range.
    fn effect_of(knots: &[KernelKnot], &GapRange { low, high, deviation }: &GapRange) -> Effect {
        let [low, high] = [low - deviation, high + deviation];
        let inner = knots.iter().filter(|knot| low <= knot.value && knot.value <= high).map(KernelKnot::channels);
        let all: Vec<[f64; 4]> = inner.chain([channels(knots, low), channels(knots, high)]).collect();
        let most = |k: usize| all.iter().fold(0.0, |most: f64, at| most.max(at[k]));
        let slope = |pair: &[KernelKnot], k: usize| {
            (pair[1].channels()[k] - pair[0].channels()[k]).abs() / (pair[1].value - pair[0].value)
        };
        let change = |k: usize| {
            let within = knots.windows(2).filter(|pair| pair[0].value <= high && pair[1].value >= low);
            // A maximum ignores the slope 0/0 of a step in other channels.
            let steepest = within.map(|pair| slope(pair, k)).fold(0.0, f64::max);
            (steepest * deviation).min(most(k) - all.iter().fold(f64::INFINITY, |least, at| least.min(at[k])))
        };
        Effect { extinction: change(3), color: [0, 1, 2].map(change).into_iter().fold(0.0, f64::max), densest: most(3) }
    }

    /// Extinction and colour of random functions with steps, at random values and others near them.
    #[test]
    fn no_value_within_the_deviation_has_a_larger_effect() {
        let mut random = Random::new(3);
        let mut visible = 0;
        for _ in 0..300 {
            let mut value = 0.0;
            let mut knot = |random: &mut Random| {
                // Every third knot is at the value of the one before: a step.
                value += if random.below(3) == 0 { 0.0 } else { random.unit() };
                let color = [(); 3].map(|()| random.unit());
                KernelKnot { value, color, extinction: if random.below(2) == 0 { 0.0 } else { 50.0 * random.unit() } }
            };
            let knots: Vec<KernelKnot> = (0..2 + random.below(6)).map(|_| knot(&mut random)).collect();
            let low = 5.0 * random.unit() - 1.0;
            let range = GapRange { low, high: low + 0.5 * random.unit(), deviation: 0.3 * random.unit() };
            let effect = Effect::of(&LinearPart::all(&knots), &range);
            let expected = effect_of(&knots, &range);
            let parts = |effect: Effect| [effect.extinction, effect.color, effect.densest];
            let off = parts(effect).iter().zip(parts(expected)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{effect:?}, expected {expected:?}: {knots:?}, {range:?}");
            let word = effect.word();
            assert_eq!(word == 0, effect.densest == 0.0);
            visible += u32::from(word != 0);
            let [k, c] = [word & 0xffff_0000, word << 16].map(|bits| f64::from(f32::from_bits(bits)));
            for _ in 0..200 {
                let near = range.low + (range.high - range.low) * random.unit();
                let other = near + range.deviation * (2.0 * random.unit() - 1.0);
                let (a, b) = (channels(&knots, near), channels(&knots, other));
                assert!((a[3] - b[3]).abs() <= k, "{} and {} of {k}: {knots:?}, {range:?}", a[3], b[3]);
                if word != 0 {
                    assert!((0..3).all(|i| (a[i] - b[i]).abs() <= c), "{a:?} and {b:?} of {c}: {knots:?}, {range:?}");
                }
                assert!(a[3].max(b[3]) <= effect.densest);
            }
            assert!(k <= 1.01 * effect.extinction + 1e-30 && c <= 1.01 * effect.color + 1e-30, "{effect:?}, {k}, {c}");
        }
        assert!(visible > 100, "{visible} visible");
    }

    /// The chord between two spheres, at the top and at the core.
    #[test]
    fn rays_at_the_ends_cross_both_surfaces() {
        let ends = [([[0.999, 1.0], [0.998, 1.002]], 2.0), ([[1.199, 1.2], [1.198, 1.202]], 3.0)];
        let deviations = Deviations { gaps: 1, words: vec![], lift: 1.001, ends };
        let error = |y: f64, has_core| deviations.error_at_ends(DVec3::new(-3.0, y, 0.0), DVec3::X, has_core);
        let through = (1.002 - 0.999) * 2.0 + (1.202 - 1.199) * 3.0;
        assert!((error(0.0, true) - through - 0.001).abs() < 1e-12);
        assert!((error(0.0, false) - 2.0 * through - 0.001).abs() < 1e-12);
        assert_eq!((error(1.0, true), error(1.21, true)), (1.0, 0.0), "a grazing ray, and one that passes by");
        assert!(error(1.2, true) > 0.1 && error(1.2, true) < 1.0);
        let between = deviations.error_at_ends(DVec3::X * 1.001, DVec3::NEG_X, true);
        assert_eq!(between, 1.0, "a ray that begins below the facets of one grid");
        let away = deviations.error_at_ends(DVec3::X * 3.0, DVec3::X, true);
        assert_eq!(away, 0.0);
    }
}
