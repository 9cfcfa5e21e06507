//! Traverses the layers inside one column: Algorithm 2's top and bottom faces.
//!
//! In a column the height ρ is linear in t, so all layers between its ends are crossed in one direction, each after
//! the fraction `u = (R - ρ1)/(ρ2 - ρ1)` of the way, at the place `τ = u ρ2/R` between the two edge points. On a layer
//! the value is linear between the edge points (barycentric on the facet, §3.3), and between layers linear in ρ. Along
//! a segment from a to b, with G the difference between the edge points' values at its ends, that makes the bend
//! `κ = (τb - τa)(Ga - Gb + ε Ga)` of `segment.rs`.

use super::lit::FrustumInterpolant;
use super::walk::Column;
use icoray_grid::array::MapInline;
use icoray_grid::real::{Real, lerp};

/// The layer radii of a shell.
#[derive(Debug, Clone)]
pub struct Shell<T> {
    radius: Vec<f64>,
    /// The radii between two bounds that no height reaches: gap k lies between elements k and k + 1.
    bounds: Vec<f64>,
    /// 1 / radius of each layer.
    curvature: Vec<f64>,
    /// 1 / thickness of the gap above each layer but the last.
    inverse: Vec<T>,
    /// Buckets of equal height from the innermost layer on; `below` has the number of layers below each.
    drawers_per_height: f64,
    below: Vec<u32>,
}

/// Buckets per layer.
const BUCKETS: usize = 4;
/// A height that no ray reaches.
const BEYOND: f64 = 1e30;

impl<T: Real> Shell<T> {
    /// `radius` in planet radii, rising.
    #[inline]
    pub fn new(radius: &[f64]) -> Self {
        let inverse = radius.windows(2).map(|w| T::of(1.0 / (w[1] - w[0]))).collect();
        let curvature = radius.iter().map(|r| 1.0 / r).collect();
        let drawers = BUCKETS * radius.len();
        let height = radius[radius.len() - 1] - radius[0];
        let drawers_per_height = if height > 0.0 { drawers as f64 / height } else { 0.0 };
        let drawer_of = |r: f64| ((r - radius[0]) * drawers_per_height) as usize;
        let below = |drawer| radius.partition_point(|r| drawer_of(*r) < drawer) as u32;
        let below = (0..=drawers).map(below).collect();
        let bounds = [&[-BEYOND], radius, &[BEYOND]].concat();
        Shell { radius: radius.to_vec(), bounds, curvature, inverse, drawers_per_height, below }
    }

    /// The outermost radius.
    #[inline]
    pub fn outer(&self) -> f64 {
        self.radius[self.radius.len() - 1]
    }

    /// The innermost radius, of the core.
    #[inline]
    pub fn inner(&self) -> f64 {
        self.radius[0]
    }

    /// The radius of each layer, rising.
    #[inline]
    pub fn radii(&self) -> &[f64] {
        &self.radius
    }

    /// Number of layers.
    #[inline]
    pub fn layers(&self) -> usize {
        self.radius.len()
    }

    /// The gap that contains height `rho`: 0 below all layers, k between layers k-1 and k, [`Self::layers`] above all.
    #[inline(always)]
    pub fn gap(&self, rho: f64) -> usize {
        let drawer = ((rho - self.radius[0]) * self.drawers_per_height) as usize;
        let mut gap = self.below[drawer.min(self.below.len() - 1)] as usize;
        let is_above = |gap: usize| self.radius.get(gap).is_some_and(|radius| *radius <= rho);
        // A bucket seldom has more than one layer.
        gap += usize::from(is_above(gap));
        while is_above(gap) {
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

    /// The fraction of the way from layer `gap - 1` to layer `gap` at which the height `rho` lies.
    #[inline]
    fn fraction(&self, gap: usize, rho: f64) -> T {
        let above = T::of(rho - self.radius[gap - 1]);
        (above * self.inverse[gap - 1]).max(T::zero()).min(T::one())
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

/// A point of the ray inside a column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayPoint<T> {
    /// Fraction of the column's length, in f64: a frustum's length is the difference of two.
    pub u: f64,
    /// Place between the edge points.
    pub tau: T,
    /// Height.
    pub rho: f64,
    /// 1 / height.
    pub curvature: f64,
}

/// Whether a ray continues or ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flow {
    On,
    Stop,
}

/// The visitor of [`cross`], called for each gap of a column.
pub(crate) trait ColumnVisitor<T, const N: usize> {
    /// Returns a layer's values at the column's two edge points.
    fn chord(&self, layer: usize) -> Chord<T, N>;
    /// The ray crosses the frustum above layer `lower` from `a` to `b`; the chords are those at the heights of `a` and
    /// `b`. `eps` is the relative change of height.
    fn frustum(&mut self, lower: usize, ends: [&RayPoint<T>; 2], chords: [&Chord<T, N>; 2], eps: T) -> Flow;
    /// Whether the gap can be skipped without reading; called once per gap.
    #[inline(always)]
    fn skips(&mut self, _gap: usize) -> bool {
        false
    }
    /// Called when the ray is below the innermost layer, from `a` on.
    fn core(&mut self, a: &RayPoint<T>) -> Flow;
}

/// A ray's path up or down through a column, gap by gap.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ColumnTraversal<T> {
    /// The gap that contains the ray, see [`Shell::gap`], and the point at which the ray entered it.
    pub gap: usize,
    pub a: RayPoint<T>,
    /// Whether it entered through a layer.
    is_on_layer: bool,
    rising: bool,
    /// Heights at the column's ends, and the inverse of their difference.
    entry: f64,
    exit: f64,
    scale: f64,
}

/// A ray's path through one gap of a column.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GapCrossing<T> {
    /// The layers behind and ahead of the ray; below and above all layers one of them does not exist.
    pub behind: usize,
    pub ahead: usize,
    /// The point at which it leaves the gap, and whether it leaves through the layer ahead.
    pub b: RayPoint<T>,
    pub passes: bool,
}

impl<T: Real> ColumnTraversal<T> {
    /// The start of `column`, whose entry lies in `gap`.
    #[inline(always)]
    pub fn new(column: &Column, gap: usize) -> Self {
        let (entry, exit) = (column.entry.rho, column.exit.rho);
        let a = RayPoint { u: 0.0, tau: T::zero(), rho: entry, curvature: column.curvature };
        let (rising, scale) = (exit >= entry, column.scale);
        ColumnTraversal { gap, a, is_on_layer: false, rising, entry, exit, scale }
    }

    /// The path through the current gap.
    #[inline(always)]
    pub fn crossed(&self, shell: &Shell<T>) -> GapCrossing<T> {
        let ColumnTraversal { gap, rising, entry, exit, scale, .. } = *self;
        let (behind, ahead) = if rising { (gap.wrapping_sub(1), gap) } else { (gap, gap.wrapping_sub(1)) };
        let radius = shell.radius.get(ahead).copied();
        let radius = radius.filter(|r| if rising { *r <= exit } else { *r > exit });
        let b = match radius {
            Some(radius) => {
                let u = ((radius - entry) * scale).clamp(0.0, 1.0);
                let curvature = shell.curvature[ahead];
                let tau = (u * exit * curvature).clamp(0.0, 1.0);
                RayPoint { u, tau: T::of(tau), rho: radius, curvature }
            }
            None => RayPoint { u: 1.0, tau: T::one(), rho: exit, curvature: 0.0 },
        };
        GapCrossing { behind, ahead, b, passes: radius.is_some() }
    }

    /// Passes through the layer ahead.
    #[inline(always)]
    pub fn pass(&mut self, crossed: &GapCrossing<T>) {
        self.gap = if self.rising { self.gap + 1 } else { self.gap - 1 };
        (self.a, self.is_on_layer) = (crossed.b, true);
    }

    /// The fractions of the way from the layer behind to the layer ahead at which the ray enters and leaves the gap; 0
    /// and 1 on the layers.
    #[inline(always)]
    pub fn places(&self, shell: &Shell<T>, crossed: &GapCrossing<T>) -> [T; 2] {
        let place = |rho: f64| {
            let w = shell.fraction(self.gap, rho);
            if self.rising { w } else { T::one() - w }
        };
        [
            if self.is_on_layer { T::zero() } else { place(self.a.rho) },
            if crossed.passes { T::one() } else { place(crossed.b.rho) },
        ]
    }

    /// The change of height in the gap, relative to the height at which the ray enters it.
    #[inline(always)]
    pub fn eps(&self, crossed: &GapCrossing<T>) -> T {
        // With an almost vanishing core radius it would round to -1.
        T::of((crossed.b.rho - self.a.rho) * self.a.curvature).max(T::of(T::ROUNDING - 1.0))
    }
}

/// Visits the gaps that the ray passes in `column`, in order, starting in `gap`; returns the gap at the column's end.
/// Reads each layer at most once.
#[inline(always)]
pub(crate) fn cross<T: Real, const N: usize>(
    shell: &Shell<T>,
    column: &Column,
    gap: usize,
    visitor: &mut impl ColumnVisitor<T, N>,
) -> (usize, Flow) {
    let top = shell.layers();
    let mut passage = ColumnTraversal::new(column, gap);
    // The chord on the layer through which the ray came.
    let mut near = None;
    loop {
        let (gap, crossed) = (passage.gap, passage.crossed(shell));
        if gap > 0 && gap < top && !visitor.skips(gap) {
            let first = near.unwrap_or_else(|| visitor.chord(crossed.behind));
            let second = visitor.chord(crossed.ahead);
            let [at_a, at_b] = passage.places(shell, &crossed).map_inline(|w| first.mix(second, w));
            let eps = passage.eps(&crossed);
            if visitor.frustum(gap - 1, [&passage.a, &crossed.b], [&at_a, &at_b], eps) == Flow::Stop {
                return (gap, Flow::Stop);
            }
            near = Some(second);
        } else {
            if gap == 0 && visitor.core(&passage.a) == Flow::Stop {
                return (gap, Flow::Stop);
            }
            near = None;
        }
        if !crossed.passes {
            return (gap, Flow::On);
        }
        passage.pass(&crossed);
    }
}
