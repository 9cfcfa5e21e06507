//! Layers of one radius each, and the values on them along a ray.
//!
//! In a column the height ρ is linear in t, so all layers between its ends are crossed in one direction, each after
//! the fraction `u = (R - ρ1)/(ρ2 - ρ1)` of the way, at the place `τ = u ρ2/R` between the two edge points. On a layer
//! the value is linear between the edge points (barycentric on the facet, §3.3), and between layers linear in ρ. Along
//! a segment from a to b, with G the difference between the edge points' values at its ends, that makes the bend
//! `κ = (τb - τa)(Ga - Gb + ε Ga)` of `segment.rs`.

use super::lit::FrustumInterpolant;
use icoray_grid::real::{Real, lerp};

/// The layer radii of a shell.
#[derive(Debug, Clone)]
pub struct Shell {
    /// The radii between two bounds that no height reaches: gap k lies between elements k and k + 1.
    bounds: Vec<f64>,
    /// Buckets of equal height from the innermost layer on; `below` has the number of layers below each.
    drawers_per_height: f64,
    below: Vec<u32>,
}

/// Buckets per layer.
const BUCKETS: usize = 4;
/// A height that no ray reaches.
const BEYOND: f64 = 1e30;

impl Shell {
    /// `radius` in planet radii, rising.
    #[inline]
    pub fn new(radius: &[f64]) -> Self {
        let drawers = BUCKETS * radius.len();
        let height = radius[radius.len() - 1] - radius[0];
        let drawers_per_height = if height > 0.0 { drawers as f64 / height } else { 0.0 };
        let drawer_of = |r: f64| ((r - radius[0]) * drawers_per_height) as usize;
        let below = |drawer| radius.partition_point(|r| drawer_of(*r) < drawer) as u32;
        let below = (0..=drawers).map(below).collect();
        let bounds = [&[-BEYOND], radius, &[BEYOND]].concat();
        Shell { bounds, drawers_per_height, below }
    }

    /// The outermost radius.
    #[inline]
    pub fn outer(&self) -> f64 {
        self.bounds[self.layers()]
    }

    /// The innermost radius, of the core.
    #[inline]
    pub fn inner(&self) -> f64 {
        self.bounds[1]
    }

    /// The radius of each layer, rising.
    #[inline]
    pub fn radii(&self) -> &[f64] {
        &self.bounds[1..=self.layers()]
    }

    /// Number of layers.
    #[inline]
    pub fn layers(&self) -> usize {
        self.bounds.len() - 2
    }

    /// The gap that contains height `rho`: 0 below all layers, k between layers k-1 and k, [`Self::layers`] above all.
    #[inline(always)]
    pub fn gap(&self, rho: f64) -> usize {
        let drawer = ((rho - self.inner()) * self.drawers_per_height) as usize;
        let mut gap = self.below[drawer.min(self.below.len() - 1)] as usize;
        // A bucket seldom has more than one layer, and the last bound is above all heights.
        while self.bounds[gap + 1] <= rho {
            gap += 1;
        }
        gap
    }

    /// Buckets per height, from the innermost layer on.
    #[inline]
    pub(crate) fn buckets_per_height(&self) -> f64 {
        self.drawers_per_height
    }

    /// The number of layers below each bucket.
    #[inline]
    pub(crate) fn below(&self) -> &[u32] {
        &self.below
    }

    /// The radii of all layers between two bounds that no height reaches: gap k lies between elements k and k + 1.
    #[inline]
    pub(crate) fn bounds(&self) -> &[f64] {
        &self.bounds
    }
}

/// Values that are interpolated together: the value alone (N = 1), or value and gradient (N = 4) if the scene is lit.
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

    /// The chord at `w` between this one and `other`; exactly that at 0 and 1.
    #[inline(always)]
    pub fn mix(self, other: Self, w: T) -> Self {
        if w == T::one() {
            return other;
        }
        Chord { entry: mix(&self.entry, &other.entry, w), exit: mix(&self.exit, &other.exit, w) }
    }

    /// Values along a path from the chord `self` to `other`, entered and left at `tau`.
    #[inline(always)]
    pub fn interpolant(&self, other: &Self, tau: [T; 2], eps: T) -> FrustumInterpolant<T, N> {
        let mut interpolant =
            FrustumInterpolant { from: self.at(tau[0]), to: other.at(tau[1]), kappa: [T::zero(); N], eps };
        for k in 0..N {
            let (slope_a, slope_b) = (self.exit[k] - self.entry[k], other.exit[k] - other.entry[k]);
            interpolant.kappa[k] = (tau[1] - tau[0]) * ((slope_a - slope_b) + eps * slope_a);
        }
        interpolant
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

/// Whether a ray continues or ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    On,
    Stop,
}
