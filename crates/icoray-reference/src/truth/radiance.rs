//! Emission and absorption along a piece of a ray in double-double: Gauss quadrature in steps of little optical depth.

use crate::double_double::Dd;
use crate::gauss::Gauss;
use icoray::Scene;

/// Nodes of a step.
pub const NODES: usize = 12;

/// The scalar along a ray in one frustum: `start + s(2·bend(1 - s) + end·s)/height`, s from 0 to 1.
///
/// Value times height is quadratic in s; differences are taken from the value at s = 0, so a constant is exactly that.
#[derive(Debug, Clone, Copy)]
pub struct FrustumInterpolant {
    /// Value at s = 0.
    start: Dd,
    bend: Dd,
    end: Dd,
    height: Dd,
    rise: Dd,
}

impl FrustumInterpolant {
    /// From the values at the start, in the middle and at the end, and the heights at both ends.
    pub fn new([first, middle, last]: [Dd; 3], [low, high]: [Dd; 2]) -> Self {
        let half = Dd::from(0.5);
        let end = (last - first) * high;
        let bend = (middle - first) * (low + high) - half * end;
        FrustumInterpolant { start: first, bend, end, height: low, rise: high - low }
    }

    fn height(&self, s: Dd) -> Dd {
        self.height + s * self.rise
    }

    pub fn value(&self, s: Dd) -> Dd {
        let two = Dd::from(2.0);
        self.start + s * (two * self.bend * (Dd::ONE - s) + self.end * s) / self.height(s)
    }

    /// Least and greatest value, perhaps too wide: the ends of the control polygon.
    pub fn hull(&self) -> [Dd; 2] {
        let middle = self.start + Dd::from(2.0) * self.bend / (self.height + self.height(Dd::ONE));
        let last = self.value(Dd::ONE);
        [self.start.min(middle).min(last), self.start.max(middle).max(last)]
    }

    /// Where in (0, 1) the value is `v`, unless it is so throughout.
    pub fn solve(&self, v: Dd, found: &mut Vec<Dd>) {
        let above = self.start - v;
        let two = Dd::from(2.0);
        let (a, b, c) = (self.end - two * self.bend, two * self.bend + above * self.rise, above * self.height);
        let root = b * b - Dd::from(4.0) * a * c;
        if root < Dd::ZERO {
            return;
        }
        let root = if b < Dd::ZERO { -root.sqrt() } else { root.sqrt() };
        let q = -(b + root) / 2.0;
        for (over, under) in [(q, a), (c, q)] {
            // Only a quotient between 0 and 1 counts, so nothing can overflow.
            if over.abs() < under.abs() && over / under > Dd::ZERO {
                found.push(over / under);
            }
        }
    }
}

/// A stretch of the transfer function between neighbouring knots: colour and extinction are linear in the value.
#[derive(Debug, Clone, Copy)]
struct Band {
    anchor: Dd,
    /// Red, green, blue, extinction per planet radius at the anchor, and their slopes.
    level: [Dd; 4],
    slope: [Dd; 4],
}

/// The transfer function, over values that run from 0 at the first knot to 1 at the last.
#[derive(Debug, Clone)]
pub struct Transfer {
    origin: f64,
    width: Dd,
    knot: Vec<Dd>,
    /// `bands[k]` lies below knot k, the last above all.
    bands: Vec<Band>,
}

impl Transfer {
    /// The scene's transfer function in a shell of the given radii.
    pub fn new(scene: &Scene, radius: &[f64]) -> Self {
        let knots = &scene.volumes[0].transfer.knots;
        let (first, last) = (&knots[0], &knots[knots.len() - 1]);
        let width = Dd::from(last.value) - Dd::from(first.value);
        let width = if width > Dd::ZERO { width } else { Dd::ONE };
        let thickness = Dd::from(radius[radius.len() - 1]) - Dd::from(radius[0]);
        let unit = scene.volumes[0].transfer.unit_length.map_or(thickness, Dd::from);
        let mut transfer = Transfer { origin: first.value, width, knot: Vec::new(), bands: Vec::new() };
        transfer.knot = knots.iter().map(|k| transfer.normalise(k.value)).collect();
        let level = |k: usize| {
            let [r, g, b] = knots[k].color.map(Dd::from);
            [r, g, b, Dd::from(knots[k].extinction) / unit]
        };
        let flat = |k: usize| Band { anchor: transfer.knot[k], level: level(k), slope: [Dd::ZERO; 4] };
        let mut bands = vec![flat(0)];
        for k in 1..knots.len() {
            let (mut band, next) = (flat(k - 1), level(k));
            let width = transfer.knot[k] - transfer.knot[k - 1];
            if width > Dd::ZERO {
                band.slope = [0, 1, 2, 3].map(|i| (next[i] - band.level[i]) / width);
            }
            bands.push(band);
        }
        bands.push(flat(knots.len() - 1));
        transfer.bands = bands;
        transfer
    }

    /// A value on the scale of the knots.
    pub fn normalise(&self, value: f64) -> Dd {
        (Dd::from(value) - Dd::from(self.origin)) / self.width
    }

    /// The places in (0, 1) at which the value is a knot's, in order, between 0 and 1.
    fn cuts(&self, interpolant: &FrustumInterpolant) -> Vec<Dd> {
        let [low, high] = interpolant.hull();
        let mut cuts = vec![Dd::ZERO, Dd::ONE];
        let first = self.knot.partition_point(|v| *v < low);
        for v in self.knot[first..].iter().take_while(|v| **v <= high) {
            interpolant.solve(*v, &mut cuts);
        }
        cuts.sort_by(|a, b| a.partial_cmp(b).expect("cuts are numbers"));
        cuts
    }

    /// The band of a value; one exactly on a knot belongs to the band above.
    fn band(&self, value: Dd) -> &Band {
        &self.bands[self.knot.partition_point(|v| *v <= value)]
    }
}

/// Accumulated light along a ray.
#[derive(Debug, Clone, Copy)]
pub struct Radiance {
    pub color: [Dd; 3],
    pub transmittance: Dd,
}

/// Transmittance below which a ray is opaque.
const NOTHING: f64 = 1e-24;
/// Largest optical depth of one step: e^-τ is then a polynomial of degree 11 to 1e-20.
const STEP_DEPTH: f64 = 0.5;
/// Largest relative change of height in one step: the pole of the value at height 0 is then 33 half-steps away.
const STEP_RISE: f64 = 1.0 / 16.0;

impl Radiance {
    /// No light yet.
    pub fn none() -> Self {
        Radiance { color: [Dd::ZERO; 3], transmittance: Dd::ONE }
    }

    /// Whether the transmittance is negligible.
    pub fn is_opaque(&self) -> bool {
        self.transmittance.to_f64() < NOTHING
    }

    /// Adds an opaque surface.
    pub fn hit(&mut self, color: [f64; 3]) {
        for (sum, own) in self.color.iter_mut().zip(color) {
            *sum += self.transmittance * Dd::from(own);
        }
        self.transmittance = Dd::ZERO;
    }

    /// Adds a frustum in which the ray has the given length.
    pub fn pass(&mut self, rule: &Gauss<NODES>, transfer: &Transfer, interpolant: &FrustumInterpolant, length: Dd) {
        for pair in transfer.cuts(interpolant).windows(2) {
            if pair[1] > pair[0] && !self.is_opaque() {
                let middle = interpolant.value((pair[0] + pair[1]) / 2.0);
                self.piece(rule, transfer.band(middle), interpolant, [pair[0], pair[1]], length);
            }
        }
    }

    fn piece(
        &mut self,
        rule: &Gauss<NODES>,
        band: &Band,
        interpolant: &FrustumInterpolant,
        [from, to]: [Dd; 2],
        length: Dd,
    ) {
        if band.level[3] == Dd::ZERO && band.slope[3] == Dd::ZERO {
            return;
        }
        let relative = (interpolant.rise.abs() / interpolant.height.min(interpolant.height(Dd::ONE))).to_f64();
        let longest = Dd::from((STEP_RISE / relative.max(STEP_RISE)).min(1.0));
        let (mut at, mut step) = (from, longest);
        while at < to && !self.is_opaque() {
            step = step.min(to - at);
            let checks = rule.node.map(|x| interpolant.value(at + step * x) - band.anchor);
            let dim = |i: usize| length * step * (band.level[3] + band.slope[3] * checks[i]).max(Dd::ZERO);
            let depths: [Dd; NODES] = std::array::from_fn(dim);
            let whole = dot(&rule.weight, &depths);
            if whole.to_f64() > STEP_DEPTH {
                // Depth may fall with the square of the step: never so short that little is left of the step.
                step = step * Dd::from((0.8 * STEP_DEPTH / whole.to_f64()).max(0.01));
                continue;
            }
            self.step(rule, band, &checks, &depths, whole);
            (at, step) = (at + step, longest.min(step * Dd::from(2.0)));
        }
    }

    /// One step: optical depth up to each node by the rule's partial weights, then emission over all.
    fn step(&mut self, rule: &Gauss<NODES>, band: &Band, checks: &[Dd; NODES], depths: &[Dd; NODES], whole: Dd) {
        for i in 0..NODES {
            let before = dot(&rule.partial[i], depths);
            let emission = self.transmittance * rule.weight[i] * depths[i] * (Dd::ONE - before.alpha());
            for k in 0..3 {
                self.color[k] += emission * (band.level[k] + band.slope[k] * checks[i]);
            }
        }
        self.transmittance = self.transmittance * (Dd::ONE - whole.alpha());
    }
}

fn dot(a: &[Dd; NODES], b: &[Dd; NODES]) -> Dd {
    a.iter().zip(b).fold(Dd::ZERO, |sum, (x, y)| sum + *x * *y)
}
