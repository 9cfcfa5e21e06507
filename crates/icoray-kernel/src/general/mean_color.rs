//! The mean colour of the light that several media absorb on a panel of a ray, from three places.
//!
//! With t the optical depth from the panel's start it is `∫ Σσc e^-t / ∫ Σσ e^-t`, a quotient, so that a constant colour
//! is exact. Both integrals are taken by `(7 F0 + 16 F½ + 7 F1)/30 + (F'0 - F'1)/60`, which is exact to the fifth
//! degree: the slopes at the ends cost less than further places, whose optical depths are closed forms with a logarithm
//! and an exponential each.
//!
//! **Its error** is that of ∫q, where `q = Σσ(c - C) e^-t`, relative to the absorbed light. Over x from -1 to 1 the
//! rule misses 8/105 of the coefficient of x⁶, and less regular parts of the higher ones. The three places determine
//! the coefficients a1 to a4 of q; the higher ones come from e^-t and from the fields' denominators, by factors e2 to
//! e4 of x² to x⁴ that follow from extinctions and ε. So the error is taken as three times
//! `8/105 (a4 e2 + a3 e3 + a2 e4 + a1 e2 e3)`, which does not vanish by accident, as a difference of two rules does.
//! The absorption is known without the rule: the rule's deviation from it may mix different colours wrongly by as much.
//! The sum is no bound, but none of 50,000 panels of random media exceeded it, and it was 26 times the true error in
//! the median (`blend/tests.rs`). If optical depth is large and colours differ, it exceeds the difference of the
//! colours, which then replaces it.
//!
//! **The distribution of the absorbed light**, for its shade, follows from the same five numbers: its centre, exact to
//! the fourth degree, and its mean square, exact to the fifth. Of a5 the centre misses 4/105.

use crate::lit::LightSpread;
use crate::number::Number;
use icoray_grid::array::MapInline;

/// A function at the start, in the middle and at the end of a panel, and its slopes over the panel at the ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nodes<T> {
    pub values: [T; 3],
    pub slopes: [T; 2],
}

/// A panel of a frustum, with its media.
#[derive(Debug)]
pub(crate) struct Panel<T> {
    /// Extinction per planet radius.
    pub rate: Nodes<T>,
    /// Colour times extinction.
    pub color: [Nodes<T>; 3],
    /// Optical depth.
    pub depth: T,
    /// Transmittance from the start to the middle and to the end.
    pub through: [T; 2],
    /// Its length, planet radii.
    pub length: T,
    /// Relative change of height along it.
    pub eps: T,
}

impl<T: Number> Panel<T> {
    /// Factors by which coefficients two to four degrees higher come.
    #[inline(always)]
    pub fn growth(&self) -> [T; 3] {
        let Panel { depth, length, eps, .. } = *self;
        let number = |value: f64| eps.like(value);
        let [s0, s1, s2] = self.rate.values;
        let tilt = length * number(0.25) * (s1 - s0).abs().max((s2 - s1).abs());
        let uneven = (eps / (eps + number(2.0))).abs();
        let bent = length * (s0 - s1 - s1 + s2).abs() * number(1.0 / 12.0);
        let e2 = (depth * depth).mul_add(number(0.05), tilt) + uneven * uneven * number(3.0);
        let e4 = e2.mul_add(e2, bent * depth.mul_add(number(0.25), uneven + uneven));
        [e2, e2.mul_add(e2.sqrt(), bent), e4]
    }

    /// A function on the panel, weighted by the transmittance.
    #[inline(always)]
    pub fn faded(&self, of: &Nodes<T>) -> Nodes<T> {
        let ([a, m, b], [first, last]) = (of.values, self.through);
        let fades = |end: usize| of.slopes[end] - self.length * self.rate.values[2 * end] * of.values[2 * end];
        Nodes { values: [a, m * first, b * last], slopes: [fades(0), fades(1) * last] }
    }
}

/// The mean colour of the light that a panel absorbs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeanColor<T> {
    pub color: [T; 3],
    /// Its error.
    pub off: T,
    /// Difference of the colours within the panel.
    pub spread: T,
}

impl<T: Number> Nodes<T> {
    /// Its mean, exact to the fifth degree.
    #[inline(always)]
    pub fn mean(&self) -> T {
        let [a, m, b] = self.values;
        let ends = (a + b).mul_add(a.like(7.0 / 30.0), m * a.like(16.0 / 30.0));
        (self.slopes[0] - self.slopes[1]).mul_add(a.like(1.0 / 60.0), ends)
    }

    /// Simpson's mean.
    #[inline(always)]
    pub fn simpson(&self) -> T {
        let [a, m, b] = self.values;
        (m.mul_add(a.like(4.0), a) + b) * a.like(1.0 / 6.0)
    }

    /// The distribution of light that is absorbed like this on a panel of this [growth](Panel::growth); `unseen` is the
    /// relative error of the mean absorption of all media.
    #[inline(always)]
    pub fn spread(&self, [e2, e3, e4]: [T; 3], unseen: T) -> LightSpread<T> {
        let number = |value: f64| unseen.like(value);
        let ([a, m, b], [from, to]) = (self.values, self.slopes);
        let inverse = number(1.0) / self.mean().max(unseen.least());
        let first = (b - a).mul_add(number(0.1), (from + to) * number(-1.0 / 120.0));
        let second = m.mul_add(number(2.0 / 105.0), (a + b) * number(9.0 / 280.0)) + (from - to) * number(1.0 / 560.0);
        let [a1, a2, a3, a4] = self.coefficients();
        let missed = e2 * m.mul_add(e3, a4 + a3) + a2 * e3 + a1 * e4;
        let bent = (a - m - m + b).abs();
        let missed = missed.mul_add(number(12.0 / 105.0), bent * number(0.02));
        LightSpread {
            centre: (first * inverse).max(number(-0.5)).min(number(0.5)),
            second: (second * inverse).max(number(0.0)).min(number(0.25)),
            error_bound: missed.mul_add(inverse, unseen * number(0.5)).min(number(0.5)),
            extent: number(1.0),
        }
    }

    #[inline(always)]
    fn less(&self, factor: T, other: &Self) -> Self {
        Nodes {
            values: [0, 1, 2].map_inline(|i: usize| self.values[i] - factor * other.values[i]),
            slopes: [0, 1].map_inline(|i: usize| self.slopes[i] - factor * other.slopes[i]),
        }
    }

    /// The sizes of its coefficients of x, x², x³ and x⁴, for x from -1 to 1.
    #[inline(always)]
    fn coefficients(&self) -> [T; 4] {
        let ([a, m, b], [from, to]) = (self.values, self.slopes);
        let [half, quarter] = [0.5, 0.25].map_inline(|x| a.like(x));
        let (rise, bend) = (b - a, a - m - m + b);
        let [cubic, quartic] = [(rise - (from + to) * half) * quarter, (bend + (from - to) * quarter) * half];
        [(rise * half).abs(), (bend * half).abs(), cubic.abs(), quartic.abs()]
    }
}

impl<T: Number> MeanColor<T> {
    /// The mean colour of a panel that absorbs this part of the light.
    #[inline(always)]
    pub fn of(panel: &Panel<T>, absorbed: T) -> Self {
        let number = |value: f64| absorbed.like(value);
        let (zero, least) = (number(0.0), absorbed.least());
        let rates = panel.faded(&panel.rate);
        let whole = rates.mean();
        let inverse = number(1.0) / whole;
        let (mut color, mut sizes) = ([zero; 3], [zero; 4]);
        for (mean, channel) in color.iter_mut().zip(&panel.color) {
            let channel = panel.faded(channel);
            *mean = channel.mean() * inverse;
            let found = channel.less(*mean, &rates).coefficients();
            sizes = [0, 1, 2, 3].map_inline(|i: usize| sizes[i].max(found[i]));
        }
        let [a1, a2, a3, a4] = sizes;
        let [e2, e3, e4] = panel.growth();
        let missed = e2 * a1.mul_add(e3, a4) + a3 * e3 + a2 * e4;
        let (spread, first) = panel.spread();
        let longer = panel.length / absorbed.max(least);
        let off = missed * longer * number(24.0 / 105.0) + spread * (longer * whole - number(1.0)).abs();
        // With one colour both are zero.
        let is_near = whole.exceeds(zero) & (spread + least).exceeds(off);
        if T::is_any(!is_near) {
            // Simpson's rule: a mean of the colours at the places. The light absorbed at the start may leave none in
            // the middle and at the end.
            let whole = rates.simpson();
            for (k, mean) in color.iter_mut().enumerate() {
                let simpson = panel.faded(&panel.color[k]).simpson() / whole;
                *mean = mean.where_else(is_near, simpson.where_else(whole.exceeds(least), first[k]));
            }
        }
        MeanColor { color, off: off.where_else(is_near, spread), spread }
    }
}

impl<T: Number> Panel<T> {
    /// The difference of the colours, from those at the places and from their slopes at the ends, and the first of them.
    /// Without absorption the colour is that of the medium that begins to absorb there.
    #[inline(always)]
    fn spread(&self) -> (T, [T; 3]) {
        let number = |value: f64| self.length.like(value);
        let [zero, one, most] = [0.0, 1.0, f64::from(f32::MAX)].map_inline(number);
        let Nodes { values: rates, slopes: rises } = self.rate;
        let has = rates.map_inline(|rate| rate.exceeds(zero));
        let inverse = rates.map_inline(|rate| one / rate);
        let begins = rises.map_inline(|rise| one / rise);
        let [enters, leaves] = rises.map_inline(|rise| rise.abs().exceeds(zero));
        let is_there = [has[0] | enters, has[1], has[2] | leaves];
        let (mut spread, mut steepest, mut first) = (zero, zero, [zero; 3]);
        for (first, Nodes { values, slopes }) in first.iter_mut().zip(self.color) {
            let (mut low, mut high) = (most, zero - most);
            let mut here = [0, 1, 2].map_inline(|place: usize| values[place] * inverse[place]);
            for (end, place) in [0, 2].into_iter().enumerate() {
                let slope = (slopes[end] - here[place] * rises[end]) * inverse[place];
                steepest = steepest.max(slope.abs()).where_else(has[place], steepest);
                here[place] = here[place].where_else(has[place], slopes[end] * begins[end]);
            }
            for place in 0..3 {
                low = low.min(here[place]).where_else(is_there[place], low);
                high = high.max(here[place]).where_else(is_there[place], high);
            }
            spread = spread.max(high - low);
            *first = here[0].where_else(is_there[0], here[1].where_else(is_there[1], here[2]));
        }
        (steepest.mul_add(number(0.25), spread), first)
    }
}
