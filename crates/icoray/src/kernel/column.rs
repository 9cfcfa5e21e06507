//! From layer to layer inside one column: Algorithm 2's top and bottom faces.
//!
//! In a column the height ρ is linear in t, so all layers between its ends are crossed in one direction, each after
//! the fraction `u = (R - ρ1)/(ρ2 - ρ1)` of the way, at the place `τ = u ρ2/R` between the two edge points. On a layer the
//! value is linear between the edge points (barycentric on the facet, §3.3), and between layers linear in ρ. Along a
//! segment from a to b, with G the difference between the edge points' values at its ends, that makes the bend
//! `κ = (τb - τa)(Ga - Gb + ε Ga)` of `segment.rs`.

use super::real::{Real, lerp};
use super::walk::Column;

/// The layer radii of a shell.
#[derive(Debug, Clone)]
pub(crate) struct Shell<T> {
    radius: Vec<f64>,
    /// 1 / radius of each layer.
    curvature: Vec<f64>,
    /// 1 / thickness of the gap above each layer but the last.
    inverse: Vec<T>,
}

impl<T: Real> Shell<T> {
    /// `radius` in planet radii, rising.
    pub fn new(radius: &[f64]) -> Self {
        let inverse = radius.windows(2).map(|w| T::of(1.0 / (w[1] - w[0]))).collect();
        let curvature = radius.iter().map(|r| 1.0 / r).collect();
        Shell { radius: radius.to_vec(), curvature, inverse }
    }

    /// The outermost radius.
    pub fn outer(&self) -> f64 {
        self.radius[self.radius.len() - 1]
    }

    /// The innermost radius, of the core.
    pub fn inner(&self) -> f64 {
        self.radius[0]
    }

    /// Number of layers.
    pub fn layers(&self) -> usize {
        self.radius.len()
    }

    /// The gap that holds height `rho`: 0 below all layers, k between layers k-1 and k, [`Self::layers`] above all.
    pub fn gap(&self, rho: f64) -> usize {
        self.radius.partition_point(|&r| r <= rho)
    }

    /// [`Self::gap`], searched from the gap `near`.
    #[inline(always)]
    pub fn gap_near(&self, near: usize, rho: f64) -> usize {
        let mut gap = near;
        while gap < self.layers() && self.radius[gap] <= rho {
            gap += 1;
        }
        while gap > 0 && self.radius[gap - 1] > rho {
            gap -= 1;
        }
        gap
    }

    /// How far from layer `gap - 1` to layer `gap` the height `rho` is.
    #[inline]
    fn fraction(&self, gap: usize, rho: f64) -> T {
        let above = T::of(rho - self.radius[gap - 1]);
        (above * self.inverse[gap - 1]).max(T::zero()).min(T::one())
    }
}

/// What is interpolated together: the value alone (N = 1), or value and gradient (N = 4) where the scene is lit.
pub(crate) type Values<T, const N: usize> = [T; N];

/// Values at a column's two edge points, at one height.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chord<T, const N: usize> {
    pub entry: Values<T, N>,
    pub exit: Values<T, N>,
}

impl<T: Real, const N: usize> Chord<T, N> {
    /// Interpolates the three vertices' values to the edge points. Equal values stay exactly equal.
    #[inline(always)]
    pub fn over([a, b, c]: [Values<T, N>; 3], [entry, exit]: &[[T; 2]; 2]) -> Self {
        let mut chord = Chord { entry: a, exit: a };
        for k in 0..N {
            let (ab, ac) = (b[k] - a[k], c[k] - a[k]);
            chord.entry[k] = a[k] + (entry[0] * ab + entry[1] * ac);
            chord.exit[k] = a[k] + (exit[0] * ab + exit[1] * ac);
        }
        chord
    }

    #[inline(always)]
    fn mix(self, other: Self, w: T) -> Self {
        Chord { entry: mix(&self.entry, &other.entry, w), exit: mix(&self.exit, &other.exit, w) }
    }

    /// The values at `tau` between the edge points.
    #[inline(always)]
    pub fn at(&self, tau: T) -> Values<T, N> {
        mix(&self.entry, &self.exit, tau)
    }
}

#[inline(always)]
pub(crate) fn mix<T: Real, const N: usize>(a: &Values<T, N>, b: &Values<T, N>, w: T) -> Values<T, N> {
    let mut mixed = *a;
    for k in 0..N {
        mixed[k] = lerp(a[k], b[k], w);
    }
    mixed
}

/// A point of the ray inside a column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Station<T> {
    /// Fraction of the column's length, in f64: a frustum's length is the difference of two.
    pub u: f64,
    /// Place between the edge points.
    pub tau: T,
    /// Height.
    pub rho: f64,
    /// 1 / height.
    pub curvature: f64,
}

/// What the visitor of [`cross`] says: go on, or the ray ends here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    On,
    Stop,
}

/// What happens on the way through a column.
pub(crate) trait Visit<T, const N: usize> {
    /// Reads a layer at the column's two edge points.
    fn chord(&self, layer: usize) -> Chord<T, N>;
    /// The ray crosses the frustum above layer `lower` from `a` to `b`; the chords are those at the heights of `a` and `b`.
    fn frustum(&mut self, lower: usize, ends: [&Station<T>; 2], chords: [&Chord<T, N>; 2]) -> Flow;
    /// Whether the gap can be passed without reading anything; told once for each.
    #[inline(always)]
    fn leaps(&mut self, _gap: usize) -> bool {
        false
    }
    /// The ray is below the innermost layer, from `a` on.
    fn core(&mut self, a: &Station<T>) -> Flow;
}

/// Visits the gaps that the ray passes in `column`, in order, starting in `gap`; gives the gap at the column's end.
/// Each layer is read at most once.
#[inline(always)]
pub(crate) fn cross<T: Real, const N: usize>(
    shell: &Shell<T>,
    column: &Column,
    mut gap: usize,
    visitor: &mut impl Visit<T, N>,
) -> (usize, Flow) {
    let (entry, exit) = (&column.entry, &column.exit);
    let top = shell.layers();
    let rising = exit.rho >= entry.rho;
    let scale = 1.0 / (exit.rho - entry.rho);
    let mut a = Station { u: 0.0, tau: T::zero(), rho: entry.rho, curvature: 1.0 / entry.rho };
    // The chord on the layer that the ray came through.
    let mut near = None;
    // Whether it came over that layer without reading it.
    let mut leapt = false;
    loop {
        let (behind, ahead) = if rising { (gap.wrapping_sub(1), gap) } else { (gap, gap.wrapping_sub(1)) };
        let passes = ahead < top
            && if rising { shell.radius[ahead] <= exit.rho } else { shell.radius[ahead] > exit.rho };
        let b = if passes {
            let radius = shell.radius[ahead];
            let u = ((radius - entry.rho) * scale).clamp(0.0, 1.0);
            let curvature = shell.curvature[ahead];
            let tau = (u * exit.rho * curvature).clamp(0.0, 1.0);
            Station { u, tau: T::of(tau), rho: radius, curvature }
        } else {
            Station { u: 1.0, tau: T::one(), rho: exit.rho, curvature: 0.0 }
        };
        if gap > 0 && gap < top && visitor.leaps(gap) {
            (near, leapt) = (None, true);
        } else if gap > 0 && gap < top {
            let first = near.unwrap_or_else(|| visitor.chord(behind));
            let second = visitor.chord(ahead);
            let between = |rho: f64| {
                let w = shell.fraction(gap, rho);
                first.mix(second, if rising { w } else { T::one() - w })
            };
            let at_a = if near.is_some() || leapt { first } else { between(a.rho) };
            let at_b = if passes { second } else { between(b.rho) };
            if visitor.frustum(gap - 1, [&a, &b], [&at_a, &at_b]) == Flow::Stop {
                return (gap, Flow::Stop);
            }
            (near, leapt) = (Some(second), false);
        } else {
            if gap == 0 && visitor.core(&a) == Flow::Stop {
                return (gap, Flow::Stop);
            }
            (near, leapt) = (None, false);
        }
        if !passes {
            return (gap, Flow::On);
        }
        gap = if rising { gap + 1 } else { gap - 1 };
        a = b;
    }
}
