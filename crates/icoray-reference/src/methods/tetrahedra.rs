//! Each frustum as three tetrahedra, cut on the fly, linear in each (Weiler et al. 2003,
//! doi:10.1109/VISUAL.2003.1250390, which the paper compares with in §4.2).
//!
//! With the cells in the order of their numbers, L the lower and U the upper layer's vertices, the three are
//! L0 L1 L2 U2, L0 L1 U1 U2 and L0 U0 U1 U2: each side face has its diagonal from the lower vertex of the smaller
//! number, so that neighbours agree. The point is `Σ α_k V_k`, and a linear map takes it to α: in α the six vertices
//! lie on the axes, and the planes between the tetrahedra follow from these.

use super::march::Interpolant;
use super::transfer::Transfer;
use crate::job::PreparedJob;
use icoray::Frustum;

pub(crate) struct Tetrahedra<'s, 'a>(pub &'s PreparedJob<'a>);

/// The ray's way through a frustum's tetrahedra: where each ends, as distance from the eye, and the value on its way.
pub(crate) struct Passage {
    end: [f64; 2],
    /// Value at the frustum's entry and its rise up to the exit, as if the frustum were all one tetrahedron.
    line: [[f32; 2]; 3],
}

/// A frustum in α, cells in the order of their numbers.
struct Prism {
    /// Radii of the lower and upper layer.
    radius: [f64; 2],
    values: [[f64; 3]; 2],
}

impl Prism {
    /// Less than 1 in the first tetrahedron, more beyond the plane L0 L1 U2; and the same for the plane L0 U1 U2.
    fn planes(&self, a: &[f64; 3]) -> [f64; 2] {
        let [low, high] = self.radius;
        [(a[0] + a[1]) / low + a[2] / high, a[0] / low + (a[1] + a[2]) / high]
    }

    /// The linear function of the tetrahedron that has both vertices of column `both`: those before have their lower
    /// vertex in it, those behind their upper one.
    fn linear(&self, both: usize, a: &[f64; 3]) -> f64 {
        let [low, high] = self.radius;
        let (mut rest, mut value) = (1.0, 0.0);
        for k in (0..3).filter(|&k| k != both) {
            let layer = usize::from(k > both);
            let weight = a[k] / self.radius[layer];
            rest -= weight;
            value += weight * self.values[layer][k];
        }
        let upper = (a[both] - rest * low) / (high - low);
        value + (rest - upper) * self.values[0][both] + upper * self.values[1][both]
    }
}

impl Interpolant for Tetrahedra<'_, '_> {
    type Cell = Passage;

    fn cell(&self, transfer: &Transfer, frustum: &Frustum) -> Option<Passage> {
        let values = self.0.vertices(frustum)?;
        let mut order = [0, 1, 2];
        order.sort_unstable_by_key(|&k| frustum.cells[k]);
        let radius = [0, 1].map(|i| self.0.radius[frustum.layer + i]);
        let prism = Prism { radius, values: values.map(|on| order.map(|k| on[k])) };
        let alpha = frustum.alpha.map(|a| order.map(|k| a[k]));
        let [from, to] = alpha.map(|a| prism.planes(&a));
        // Where the ray meets each of the two planes, 0 to 1; outside, it does not.
        let meets = [0, 1].map(|i| (1.0 - from[i]) / (to[i] - from[i]));
        let mut cuts = meets.map(|u| if u > 0.0 && u < 1.0 { u } else { 1.0 });
        cuts.sort_unstable_by(f64::total_cmp);
        let line = |[from_u, to_u]: [f64; 2]| {
            let u = 0.5 * (from_u + to_u);
            let middle = [0, 1, 2].map(|k| alpha[0][k] + u * (alpha[1][k] - alpha[0][k]));
            let planes = prism.planes(&middle);
            let both = match planes {
                [first, _] if first < 1.0 => 2,
                [_, second] if second < 1.0 => 1,
                _ => 0,
            };
            let [a, b] = [0, 1].map(|i| transfer.normalised(prism.linear(both, &alpha[i])));
            [a, b - a]
        };
        let ends = cuts.map(|u| frustum.t[0] + u * (frustum.t[1] - frustum.t[0]));
        Some(Passage { end: ends, line: [line([0.0, cuts[0]]), line([cuts[0], cuts[1]]), line([cuts[1], 1.0])] })
    }

    #[inline]
    fn value(&self, passage: &Passage, frustum: &Frustum, t: f64) -> f32 {
        let part = usize::from(t > passage.end[0]) + usize::from(t > passage.end[1]);
        let length = frustum.t[1] - frustum.t[0];
        let u = if length > 0.0 { ((t - frustum.t[0]) / length).clamp(0.0, 1.0) } else { 0.0 };
        let [start, rise] = passage.line[part];
        start + rise * u as f32
    }
}
