//! Frusta of a batch under light: gradients along them, three shades of each, and what [`Lit::light`] makes of these
//! where it would cut once at most.
//!
//! [`Lit::light`]: crate::lit::Lit::light

use super::rows::{Directions, Rows, no_interpolants, no_lights, no_segments, no_shades};
use super::{All, Batch, LaneStatus, PASSES, all};
use crate::lit::{FrustumInterpolant, LightSpread, Shades, error_bound};
use crate::piece::{Radiance, ThinPiece};
use crate::segment::Segment;
use crate::shade::{RayShading, Shade};
use crate::single_volume::SingleVolumeTracer;
use crate::transfer::{Media, Span};
use crate::walk::packet::{LANES, Lanes, lanes};
use fearless_simd::Simd;
use icoray_grid::array::MapInline;
use icoray_grid::real::Real;

/// The lighting of each ray: the same for all but for the directions.
#[derive(Debug)]
pub(super) struct Lights<T> {
    common: RayShading<T>,
    /// Ray direction of each lane; rows are twice as long for [`Real::look_up`].
    directions: Directions<[T; 32]>,
    /// The gradient along each frustum that is usual and not clear.
    interpolants: [FrustumInterpolant<Lanes<T>, 3>; PASSES],
    /// The part of the light that the front half of each halved frustum absorbs.
    front: All<T>,
}

impl<T: Real> Lights<T> {
    /// The directions of the ray of each frustum of a pass, by its lane.
    #[inline(always)]
    fn of<V: Simd>(&self, simd: V, lanes: &Lanes<u8>) -> Directions<Lanes<T>> {
        let mut numbers = [0; LANES];
        for i in 0..LANES {
            numbers[i] = u32::from(lanes[i]);
        }
        let zero = [[T::zero(); LANES]; 3];
        let mut directions = Directions { light: zero, halfway: zero };
        for k in 0..3 {
            directions.light[k] = T::look_up(simd, &self.directions.light[k], &numbers);
            directions.halfway[k] = T::look_up(simd, &self.directions.halfway[k], &numbers);
        }
        directions
    }
}

/// A gradient of each frustum.
type Vectors<T> = [Lanes<T>; 3];

impl<T: Real, const N: usize> Batch<T, N> {
    /// Sets the lighting of the ray in a lane, before its first frustum.
    #[inline]
    pub fn light_lane(&mut self, lane: usize, shading: &RayShading<T>) {
        let none = || {
            let zero = [[T::zero(); 32]; 3];
            Box::new(Lights {
                common: *shading,
                directions: Directions { light: zero, halfway: zero },
                interpolants: [no_interpolants(); PASSES],
                front: all(T::zero()),
            })
        };
        let directions = &mut self.lights.get_or_insert_with(none).directions;
        directions.light.iter_mut().zip(&shading.light).for_each(|(row, x)| row[lane] = *x);
        directions.halfway.iter_mut().zip(&shading.halfway).for_each(|(row, x)| row[lane] = *x);
    }

    /// Value, and gradient with lighting, along frustum `i` of a pass, which is usual and not clear.
    #[inline]
    pub fn complete_interpolant(&self, pass: usize, i: usize) -> FrustumInterpolant<T, N> {
        let piece = self.segments[pass].at(i);
        let interpolants = self.lights.as_ref().map(|lights| &lights.interpolants[pass]);
        let of = |value: T, gradient: Option<&Vectors<T>>| {
            let mut values = [value; N];
            if let Some(gradient) = gradient {
                for (k, value) in values.iter_mut().enumerate().skip(1) {
                    *value = gradient[(k - 1) % 3][i];
                }
            }
            values
        };
        FrustumInterpolant {
            from: of(piece.f0, interpolants.map(|interpolants| &interpolants.from)),
            to: of(piece.f1, interpolants.map(|interpolants| &interpolants.to)),
            kappa: of(piece.kappa, interpolants.map(|interpolants| &interpolants.kappa)),
            eps: piece.eps,
        }
    }

    /// The part of the light that the front half of frustum number `n` absorbs; the frustum was integrated in halves.
    #[inline(always)]
    pub fn front(&self, n: usize) -> T {
        self.lights.as_ref().map_or(T::zero(), |lights| lights.front[n / LANES][n % LANES])
    }

    /// Shades the light of a pass, and stores the gradients. Gives the bits of the frusta for which three shades are
    /// not near enough.
    #[inline(always)]
    pub(super) fn shade<V: Simd>(
        &mut self,
        simd: V,
        pass: usize,
        tracer: &SingleVolumeTracer<'_, T>,
        media: &Media<T>,
    ) -> u32 {
        let interpolants = self.interpolants(pass, &self.gradients(pass, tracer));
        let Some(lights) = &mut self.lights else { return 0 };
        lights.interpolants[pass] = interpolants;
        let common = lights.common;
        let directions = lights.of(simd, &self.lane[pass]);
        let mut shades = [no_shades(); 3];
        for k in 0..3 {
            shades[k] = shades_at(T::of(0.5 * k as f64), &interpolants, &common, &directions);
        }
        let mut lit = no_lights();
        let mut is_near = [false; LANES];
        for i in 0..LANES {
            let (piece, span) = (self.segments[pass].at(i), media.span(i));
            let shades = [&shades[0].at(i), &shades[1].at(i), &shades[2].at(i)];
            let spread = LightSpread::of(&piece, &span);
            let off = error_bound(&lit_along(&common, &directions, i), shades, &span, &spread);
            let mean = RayShading::mean(shades[0], shades[1], shades[2], spread.centre);
            lit.set(i, &common.apply(self.light[pass].at(i), mean, off));
            is_near[i] = off <= self.color_tolerance;
        }
        self.light[pass] = lit;
        let mut left = 0;
        for i in 0..LANES {
            let is_left = (self.known[pass][i] == LaneStatus::Light) & !(is_near[i] | tracer.is_coarse);
            self.known[pass][i] = if is_left { LaneStatus::Scalar } else { self.known[pass][i] };
            left |= u32::from(is_left) << i;
        }
        left
    }

    /// Integrates frusta in halves, as [`Lit`] does next, those whose bits are set.
    ///
    /// [`Lit`]: crate::lit::Lit
    #[inline(always)]
    pub(super) fn bisect<V: Simd>(&mut self, simd: V, tracer: &SingleVolumeTracer<'_, T>, left: &[u32; PASSES]) {
        let (mut some, mut count) = ([0; LANES], 0);
        for (pass, bits) in left.iter().enumerate() {
            for i in lanes(*bits) {
                some[count % LANES] = pass * LANES + i;
                count += 1;
                if count == LANES {
                    self.halve_some(simd, tracer, &some, LANES);
                    count = 0;
                }
            }
        }
        if count > 0 {
            self.halve_some(simd, tracer, &some, count);
        }
    }

    /// The first `count` of the frusta `some`.
    #[inline(always)]
    fn halve_some<V: Simd>(
        &mut self,
        simd: V,
        tracer: &SingleVolumeTracer<'_, T>,
        some: &[usize; LANES],
        count: usize,
    ) {
        let Some(lights) = &mut self.lights else { return };
        let (mut interpolants, mut pieces) = (no_interpolants(), no_segments());
        let (mut lane, mut span) = ([0; LANES], [0; LANES]);
        for j in 0..count {
            let (pass, i) = (some[j] / LANES % PASSES, some[j] % LANES);
            interpolants.set(j, &lights.interpolants[pass].at(i));
            pieces.set(j, &self.segments[pass].at(i));
            (lane[j], span[j]) = (self.lane[pass][i], self.span[pass][i]);
        }
        let common = lights.common;
        let directions = lights.of(simd, &lane);
        let media = tracer.spans.media(simd, &span);
        let mut shades = [no_shades(); 5];
        for k in 0..5 {
            shades[k] = shades_at(T::of(0.25 * k as f64), &interpolants, &common, &directions);
        }
        let mut lit = no_lights();
        let mut front = [T::zero(); LANES];
        let mut is_near = [false; LANES];
        for j in 0..LANES {
            let (piece, span) = (pieces.at(j), media.span(j));
            let [a, b, c, d, e] = &shades;
            let (a, b, c) = (&a.at(j), &b.at(j), &c.at(j));
            let (d, e) = (&d.at(j), &e.at(j));
            let shading = lit_along(&common, &directions, j);
            let halves = BisectedPiece::new(&piece, &span, &shading, self.color_tolerance);
            let (mut light, front_near) = halves.light(false, [a, b, c]);
            let (behind, back_near) = halves.light(true, [c, d, e]);
            front[j] = light.alpha;
            light.over(&behind);
            lit.set(j, &light);
            is_near[j] = front_near & back_near & (halves.depth <= T::one());
        }
        for j in 0..count {
            let (pass, i) = (some[j] / LANES % PASSES, some[j] % LANES);
            self.light[pass].set(i, &lit.at(j));
            lights.front[pass][i] = front[j];
            self.known[pass][i] = if is_near[j] { LaneStatus::Bisected } else { LaneStatus::Scalar };
        }
    }

    /// The gradients at the six vertices, of the frusta that are usual and not clear.
    #[inline(always)]
    fn gradients(&self, pass: usize, tracer: &SingleVolumeTracer<'_, T>) -> [Vectors<T>; 6] {
        let layers = tracer.shell.layers();
        let mut gradients = [[[T::zero(); LANES]; 3]; 6];
        for i in 0..LANES {
            let is_read = self.is_usual[pass][i] & (self.known[pass][i] != LaneStatus::Clear);
            if !is_read | (pass * LANES + i >= self.count) {
                continue;
            }
            let (cells, [behind, ahead]) = (self.cells[pass][i], self.layers[pass][i]);
            for k in 0..6 {
                let layer = if k < 3 { behind } else { ahead };
                let gradient = tracer.gradients.at(cells[k % 3] as usize * layers + layer as usize);
                for (rows, x) in gradients[k].iter_mut().zip(gradient) {
                    rows[i] = T::of(f64::from(x));
                }
            }
        }
        gradients
    }

    /// The gradient along each frustum of a pass.
    #[inline(always)]
    fn interpolants(&self, pass: usize, gradients: &[Vectors<T>; 6]) -> FrustumInterpolant<Lanes<T>, 3> {
        let crossings = self.crossing.map(|rows| &rows[pass]);
        let mut interpolants = no_interpolants();
        for k in 0..3 {
            for i in 0..LANES {
                let at = |vertex: usize| [gradients[vertex][k][i]];
                let interpolant = crossings.map(|row| row[i]).interpolant([at(0), at(1), at(2)], [at(3), at(4), at(5)]);
                interpolants.from[k][i] = interpolant.from[0];
                interpolants.to[k][i] = interpolant.to[0];
                interpolants.kappa[k][i] = interpolant.kappa[0];
            }
        }
        interpolants.eps = *crossings.eps;
        interpolants
    }
}

/// A piece in two halves.
struct BisectedPiece<'h, T> {
    parts: [Segment<T>; 2],
    span: &'h Span<T>,
    shading: &'h RayShading<T>,
    color_tolerance: T,
    /// Bound of the rounding error of the whole piece's values.
    reach: T,
    /// Upper bound of the whole piece's optical depth.
    depth: T,
    /// Change of a half's light below which it is not cut again.
    enough: T,
}

impl<'h, T: Real> BisectedPiece<'h, T> {
    #[inline(always)]
    fn new(piece: &Segment<T>, span: &'h Span<T>, shading: &'h RayShading<T>, color_tolerance: T) -> Self {
        let half = T::of(0.5);
        let depth = max_depth(piece, span);
        let cut = (half, piece.value(half));
        let parts = [piece.part((T::zero(), piece.f0), cut), piece.part(cut, (T::one(), piece.f1))];
        let enough = T::of(0.03) * color_tolerance * (half * depth).absorbed_by_thin();
        BisectedPiece { parts, span, shading, color_tolerance, reach: piece.reach(), depth, enough }
    }

    /// The light of the front or back half, and whether it is near enough.
    #[inline(always)]
    fn light(&self, is_back: bool, shades: Shades<'_, T>) -> (Radiance<T>, bool) {
        let part = if is_back { &self.parts[1] } else { &self.parts[0] };
        let spread = LightSpread::of(part, self.span);
        let off = error_bound(self.shading, shades, self.span, &spread);
        let thin = ThinPiece::new(part, self.span);
        let mean = RayShading::mean(shades[0], shades[1], shades[2], spread.centre);
        let light = self.shading.apply(thin.light(self.reach), mean, off);
        let is_near = (off <= self.color_tolerance) | (off * max_depth(part, self.span) <= self.enough);
        (light, is_near & ThinPiece::applies_to(part) & thin.is_near(self.color_tolerance))
    }
}

/// The most that the optical depth of a piece without a bend can be.
#[inline(always)]
fn max_depth<T: Real>(piece: &Segment<T>, span: &Span<T>) -> T {
    piece.length * span.extinction(piece.f0).max(span.extinction(piece.f1))
}

/// The shade of each frustum at `u`.
#[inline(always)]
fn shades_at<T: Real>(
    u: T,
    interpolants: &FrustumInterpolant<Lanes<T>, 3>,
    common: &RayShading<T>,
    directions: &Directions<Lanes<T>>,
) -> Shade<Lanes<T>> {
    let mut shades = no_shades();
    for i in 0..LANES {
        let of = |rows: &Vectors<T>| [T::zero(), rows[0][i], rows[1][i], rows[2][i]];
        let FrustumInterpolant { from, to, kappa, eps } = interpolants;
        let interpolant = FrustumInterpolant { from: of(from), to: of(to), kappa: of(kappa), eps: eps[i] };
        shades.set(i, &lit_along(common, directions, i).shade(interpolant.gradient(u)));
    }
    shades
}

/// The lighting of the ray of frustum `i`.
#[inline(always)]
fn lit_along<T: Real>(common: &RayShading<T>, directions: &Directions<Lanes<T>>, i: usize) -> RayShading<T> {
    let [light, halfway] =
        [&directions.light, &directions.halfway].map_inline(|rows| rows.each_ref().map_inline(|row| row[i]));
    RayShading { light, halfway, ..*common }
}
