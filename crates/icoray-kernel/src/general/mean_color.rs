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
use icoray_grid::array::MapInline;

/// The media at a place of a panel.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mixture {
    /// Extinction per planet radius, and its slope along the frustum, from 0 to 1.
    pub rate: [f64; 2],
    /// Colour times extinction, and its slope.
    pub color: [[f64; 3]; 2],
}

impl Mixture {
    /// Colour, and its slope. Without absorption the colour is that of the medium that begins to absorb there; `None`
    /// if there is none.
    #[inline]
    fn own_color(&self) -> Option<[[f64; 3]; 2]> {
        let ([rate, rise], [color, tint]) = (self.rate, self.color);
        if rate > 0.0 {
            let own = color.map_inline(|c| c / rate);
            return Some([own, [0, 1, 2].map_inline(|k| (tint[k] - own[k] * rise) / rate)]);
        }
        (rise != 0.0).then(|| [tint.map_inline(|c| c / rise), [0.0; 3]])
    }
}

/// A panel of a frustum, with the media at its start, middle and end.
#[derive(Debug)]
pub(super) struct Panel<'n> {
    pub at: [&'n Mixture; 3],
    /// Optical depth from the start to each place.
    pub depth: [f64; 3],
    /// Its fraction of the frustum.
    pub width: f64,
    /// Its length, planet radii.
    pub length: f64,
    /// Relative change of height along it.
    pub eps: f64,
}

impl Panel<'_> {
    /// Factors by which coefficients two to four degrees higher come.
    #[inline]
    pub fn growth(&self) -> [f64; 3] {
        let Panel { at, depth, length, eps, .. } = *self;
        let [s0, s1, s2] = at.map_inline(|place| place.rate[0]);
        let straight = 0.5 * depth[2];
        let tilt = 0.25 * length * (s1 - s0).abs().max((s2 - s1).abs());
        let uneven = eps / (2.0 + eps);
        let bent = length * (s0 - 2.0 * s1 + s2).abs() / 12.0;
        let e2 = 0.2 * straight * straight + tilt + 3.0 * uneven * uneven;
        let e3 = bent + e2 * e2.sqrt();
        let e4 = bent * (0.5 * straight + 2.0 * uneven.abs()) + e2 * e2;
        [e2, e3, e4]
    }

    /// How light fades along it.
    #[inline]
    pub fn fading(&self) -> Fading {
        let Panel { at, depth, width, length, .. } = *self;
        let through = depth.map_inline(|depth| (-depth).exp());
        Fading { through, rates: [at[0], at[2]].map_inline(|place| length * place.rate[0]), width }
    }
}

/// The light that passes a panel.
pub(super) struct Fading {
    /// Transmittance from the start to each place.
    through: [f64; 3],
    /// Extinction of all media at the start and end, times the length.
    rates: [f64; 2],
    width: f64,
}

impl Fading {
    /// A function with these values and slopes along the frustum at the three places, weighted by the transmittance.
    #[inline]
    pub fn nodes(&self, of: [[f64; 2]; 3]) -> Nodes {
        let Fading { through, rates, width } = *self;
        let slope = |end: usize| (width * of[2 * end][1] - rates[end] * of[2 * end][0]) * through[2 * end];
        Nodes { values: [0, 1, 2].map_inline(|i| of[i][0] * through[i]), slopes: [slope(0), slope(1)] }
    }
}

/// The mean colour of the light that a panel absorbs.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeanColor {
    pub color: [f64; 3],
    /// Its error.
    pub off: f64,
    /// Difference of the colours within the panel.
    pub spread: f64,
}

/// A function at the three places, and its slopes over the panel at the ends.
#[derive(Clone, Copy)]
pub(super) struct Nodes {
    pub values: [f64; 3],
    slopes: [f64; 2],
}

impl Nodes {
    /// Its mean, exact to the fifth degree.
    #[inline]
    pub fn mean(&self) -> f64 {
        let [a, m, b] = self.values;
        (7.0 * (a + b) + 16.0 * m) / 30.0 + (self.slopes[0] - self.slopes[1]) / 60.0
    }

    /// The distribution of light that is absorbed like this on a panel of this [growth](Panel::growth); `unseen` is the
    /// relative error of the mean absorption of all media.
    #[inline]
    pub fn spread(&self, [e2, e3, e4]: [f64; 3], unseen: f64) -> LightSpread<f64> {
        let ([a, m, b], [from, to]) = (self.values, self.slopes);
        let inverse = 1.0 / self.mean().max(f64::MIN_POSITIVE);
        let first = (b - a) / 10.0 - (from + to) / 120.0;
        let second = m * 2.0 / 105.0 + (a + b) * 9.0 / 280.0 + (from - to) / 560.0;
        let [a1, a2, a3, a4] = self.coefficients();
        let missed = e2 * (a4 + a3 + m * e3) + a2 * e3 + a1 * e4;
        let error_bound = (3.0 * 4.0 / 105.0 * missed + 0.02 * (a - 2.0 * m + b).abs()) * inverse + 0.5 * unseen;
        LightSpread {
            centre: (first * inverse).clamp(-0.5, 0.5),
            second: (second * inverse).clamp(0.0, 0.25),
            error_bound: error_bound.min(0.5),
            extent: 1.0,
        }
    }

    #[inline]
    fn less(&self, factor: f64, other: &Self) -> Self {
        Nodes {
            values: [0, 1, 2].map_inline(|i| self.values[i] - factor * other.values[i]),
            slopes: [0, 1].map_inline(|i| self.slopes[i] - factor * other.slopes[i]),
        }
    }

    /// The sizes of its coefficients of x, x², x³ and x⁴, for x from -1 to 1.
    #[inline]
    fn coefficients(&self) -> [f64; 4] {
        let ([a, m, b], [from, to]) = (self.values, self.slopes);
        let (rise, bend) = (b - a, a - 2.0 * m + b);
        let [cubic, quartic] = [(rise - 0.5 * (from + to)) / 4.0, (bend - 0.25 * (to - from)) / 2.0];
        [rise / 2.0, bend / 2.0, cubic, quartic].map_inline(f64::abs)
    }
}

impl MeanColor {
    /// The mean colour of a panel that absorbs this part of the light.
    #[inline]
    pub fn of(panel: &Panel, absorbed: f64) -> Self {
        let Panel { at, width, length, .. } = *panel;
        let fading = panel.fading();
        let weighted = |of: &dyn Fn(&Mixture) -> [f64; 2]| fading.nodes(at.map_inline(of));
        let rates = weighted(&|place| place.rate);
        let channels = [0, 1, 2].map_inline(|k| weighted(&|place| place.color.map_inline(|color| color[k])));
        let whole = rates.mean();
        let color = channels.map_inline(|channel| channel.mean() / whole);
        let mut sizes = [0.0f64; 4];
        for (channel, mean) in channels.iter().zip(color) {
            let found = channel.less(mean, &rates).coefficients();
            sizes = [0, 1, 2, 3].map_inline(|i| sizes[i].max(found[i]));
        }
        let [a1, a2, a3, a4] = sizes;
        let [e2, e3, e4] = panel.growth();
        let missed = a4 * e2 + a3 * e3 + a2 * e4 + a1 * e2 * e3;
        let spread = spread(&at, width);
        let off = 3.0 * 8.0 / 105.0 * missed * length / absorbed + spread * (length * whole / absorbed - 1.0).abs();
        if whole > 0.0 && off <= spread {
            return MeanColor { color, off, spread };
        }
        // Simpson's rule: a mean of the colours at the places. The light absorbed at the start may leave none in the
        // middle and at the end.
        let simpson = |[a, m, b]: [f64; 3]| a + 4.0 * m + b;
        let whole = simpson(rates.values);
        let first = || at.iter().find_map(|place| place.own_color()).map_or([0.0; 3], |[color, _]| color);
        let color = if whole > 0.0 { channels.map_inline(|channel| simpson(channel.values) / whole) } else { first() };
        MeanColor { color, off: spread, spread }
    }
}

/// Difference of the colours on a panel, from those at the places and from their slopes.
#[inline]
fn spread(at: &[&Mixture; 3], width: f64) -> f64 {
    let (mut low, mut high, mut steepest) = ([f64::MAX; 3], [f64::MIN; 3], 0.0f64);
    for [color, slope] in at.iter().filter_map(|place| place.own_color()) {
        low = [0, 1, 2].map_inline(|k| low[k].min(color[k]));
        high = [0, 1, 2].map_inline(|k| high[k].max(color[k]));
        steepest = slope.iter().fold(steepest, |most, slope| most.max(slope.abs()));
    }
    let [r, g, b] = [0, 1, 2].map_inline(|k| high[k] - low[k]);
    r.max(g).max(b).max(0.0) + 0.25 * width * steepest
}
