//! One frustum of a ray: cuts its interpolant at the knots of the transfer function, and integrates the pieces.

use crate::column::Flow;
use crate::general::RaySettings;
use crate::lit::{FrustumInterpolant, Lit};
use crate::piece::{ErrorBudget, Radiance, integrate};
use crate::roundoff::{KnotCrossing, MediumSample, Roundoff};
use crate::segment::Segment;
use crate::shade::RayShading;
use crate::transfer::Spans;
use glam::DVec3;
use icoray_grid::array::partition_point;
use icoray_grid::real::{Real, lerp};
use icoray_scene::Method;

/// The light of a volume along one ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VolumeRay<'v, T> {
    spans: &'v Spans<T>,
    method: Method,
    is_coarse: bool,
    brightest: T,
    pub shading: Option<RayShading<T>>,
    /// Error of the colour that is allowed per absorbed light.
    color_tolerance: T,
    /// Transmittance at which the ray ends.
    pub min_transmittance: T,
    /// The span of the transfer function that the ray is in; `None` at the start and behind a void.
    pub span: Option<usize>,
    /// The largest magnitude of values at the vertices of the frustum that the ray is in, where it is needed
    /// ([`Spans::needs_sizes`]); else 1.
    pub size: T,
    /// The largest component of the gradients at the vertices, where it is known; else 0.
    pub gradient_size: T,
    pub light: Radiance<T>,
}

impl<'v, T: Real> VolumeRay<'v, T> {
    /// No light yet, of a ray along `dir` through a volume of this transfer function.
    #[inline]
    pub fn new(spans: &'v Spans<T>, rays: &RaySettings, dir: DVec3) -> Self {
        let RaySettings { method, is_coarse, ref budget, ref shading, .. } = *rays;
        VolumeRay {
            spans,
            method,
            is_coarse,
            brightest: T::of(budget.brightest),
            shading: shading.map(|shading| shading.along::<T>(dir)),
            color_tolerance: T::of(budget.color_tolerance_in::<T>(shading.as_ref())),
            min_transmittance: T::of(budget.min_transmittance),
            span: None,
            size: T::one(),
            gradient_size: T::zero(),
            light: Radiance::none(),
        }
    }

    /// Adds the light of a segment, which is `range` of the interpolant and has all its values.
    #[inline(always)]
    pub fn segment<const N: usize>(
        &mut self,
        segment: &Segment<T>,
        interpolant: &FrustumInterpolant<T, N>,
        range: [T; 2],
    ) -> Flow {
        let spans = self.spans;
        // A constant lies where its value lies, not where the ray came from.
        let known = self.span.filter(|_| !segment.is_constant());
        let mut k = known.map_or_else(|| spans.find(segment.f0), |k| spans.follow(k, segment.f0));
        let reach = segment.reach(self.size);
        if self.method == Method::Exact {
            k = spans.holding(k, segment);
        }
        if self.method == Method::Exact && spans.span(k).holds(segment) {
            self.piece(segment, k, interpolant, range, reach);
        } else {
            k = match segment.extremum() {
                None => self.monotone(segment, k, interpolant, range),
                Some(turn) => {
                    let (start, end) = ((T::zero(), segment.f0), (T::one(), segment.f1));
                    let at = lerp(range[0], range[1], turn.0);
                    let k = self.monotone(&segment.part(start, turn), k, interpolant, [range[0], at]);
                    self.monotone(&segment.part(turn, end), k, interpolant, [at, range[1]])
                }
            };
        }
        self.span = Some(k);
        self.passed(segment)
    }

    /// Whether the ray ends behind a frustum.
    #[inline(always)]
    fn passed(&mut self, segment: &Segment<T>) -> Flow {
        if !self.spans.steps().is_empty() {
            self.near_steps(segment);
        }
        if self.light.ends(self.rest(), self.brightest) { Flow::Stop } else { Flow::On }
    }

    /// Transmittance at which the ray has ended: that of a piece that ended early is accurate to the last digit only.
    #[inline(always)]
    fn rest(&self) -> T {
        self.min_transmittance * T::of(1.001) + T::of(2.0 * T::ROUNDING)
    }

    /// Splits a monotone segment, `range` of the whole interpolant, at the transfer function's knots, from span `k` to
    /// the returned one. The span is carried from piece to piece: the side of a knot follows from the previous piece,
    /// never from a rounded value.
    #[inline]
    fn monotone<const N: usize>(
        &mut self,
        segment: &Segment<T>,
        mut k: usize,
        interpolant: &FrustumInterpolant<T, N>,
        range: [T; 2],
    ) -> usize {
        let spans = self.spans;
        let (f0, f1) = (segment.f0, segment.f1);
        if f0.min(f1) >= spans.span(k).low && f0.max(f1) <= spans.span(k).high {
            self.piece(segment, k, interpolant, range, segment.reach(self.size));
            return k;
        }
        let segment_reach = segment.reach(self.size);
        let mut error_bound = Roundoff::new(segment, segment_reach, MediumSample::at(spans.span(k), f0));
        let (zero, one) = (T::zero(), T::one());
        let rising = f1 >= f0;
        // Each knot is searched in the remainder: a narrow piece searched from the start would be a difference of two
        // u.
        let mut rest = *segment;
        let (mut from, mut at) = (range[0], zero);
        loop {
            let span = spans.span(k);
            let knot = if rising { span.high } else { span.low };
            let is_last = if rising { f1 <= knot } else { f1 >= knot };
            let end = if is_last { (one, f1) } else { (rest.solve(knot), knot) };
            let to = lerp(from, range[1], end.0);
            if end.0 > zero {
                let (before, f) = (self.light.alpha, [rest.f0, end.1]);
                let part = if is_last { rest } else { rest.part((zero, f[0]), end) };
                let is_between = rest.f0 != f0 && !is_last;
                // The difference of two knots has the rounding error of their own last digits.
                let between = T::of(0.5 * T::ROUNDING) * (f[0].abs() + f[1].abs());
                let reach = if is_between { between } else { segment_reach };
                self.piece(&part, k, interpolant, [from, to], reach);
                let mean = MediumSample::at(span, T::of(0.5) * (f[0] + f[1]));
                let change = span.steepest * (f[1] - f[0]).abs();
                let (slope, length, is_narrow) = (segment.slope(at), part.length, span.is_narrow());
                let crossing = KnotCrossing { values: f, slope, length, mean, change, is_narrow };
                error_bound.cut(&mut self.light, before, crossing);
            }
            if is_last {
                error_bound.shift(&mut self.light, &MediumSample::at(span, f1));
                return k;
            }
            error_bound.absorbed_before.get_or_insert(self.light.alpha);
            rest = rest.part(end, (one, f1));
            (from, at) = (to, lerp(at, one, end.0));
            k = if rising { k + 1 } else { k - 1 };
        }
    }

    /// Adds the light of a piece that stays in span `k`.
    #[inline]
    pub fn piece<const N: usize>(
        &mut self,
        piece: &Segment<T>,
        k: usize,
        interpolant: &FrustumInterpolant<T, N>,
        range: [T; 2],
        reach: T,
    ) {
        let span = self.spans.span(k);
        if span.is_clear_in(piece) {
            return;
        }
        let through = self.light.transmittance();
        if through <= self.rest() {
            return;
        }
        let allowance = ErrorBudget {
            color_tolerance: self.color_tolerance,
            min_transmittance: self.min_transmittance,
            transmittance: through,
            reach,
        };
        let light = match &self.shading {
            Some(shading) if N == 4 => {
                let lit = Lit {
                    method: self.method,
                    allowance: &allowance,
                    shading,
                    span,
                    interpolant,
                    gradient_size: self.gradient_size,
                };
                let cuts = if self.is_coarse { 0 } else { Lit::<T, N>::MAX_CUTS };
                lit.light(piece, range, cuts, &self.light)
            }
            _ => integrate(self.method, piece, span, &allowance),
        };
        self.light.over(&light);
        // The sum is rounded to its own last digit.
        let off = T::of(0.5 * T::ROUNDING) * self.light.alpha;
        self.light.variance = self.light.variance + off * off;
    }

    /// Accounts for a segment that ends or turns within rounding of a step, and may lie beyond it there.
    #[inline]
    fn near_steps(&mut self, segment: &Segment<T>) {
        let steep = (segment.f1 - segment.f0).abs() + segment.kappa.abs();
        if steep == T::zero() {
            return;
        }
        let reach = T::of(8.0) * segment.reach(self.size);
        // At an extremum of f the length beyond is the root of the reach of rounding, at an end it follows from the
        // slope there.
        let root = (reach / (reach + steep)).sqrt();
        let rise = segment.f1 - segment.f0;
        let slopes = [rise + segment.kappa, rise - segment.kappa / (T::one() + segment.eps)];
        let at_end = |slope: T| (reach / (reach + slope.abs())).min(root);
        let ends = [(segment.f0, at_end(slopes[0])), (segment.f1, at_end(slopes[1]))];
        let turn = segment.extremum().map(|(_, f)| (f, root));
        let steps = self.spans.steps();
        for (extreme, part) in ends.into_iter().chain(turn) {
            let first = partition_point(steps, |step| step.value < extreme - reach);
            for step in steps[first..].iter().take_while(|step| step.value <= extreme + reach) {
                let through = self.light.transmittance();
                let beyond = (segment.length * part * step.extinction_within(reach)).absorbed_by();
                self.light.error = self.light.error + through * beyond;
            }
        }
    }
}

/// The size of values at vertices, for [`VolumeRay::size`]: far beyond the transfer function's range, the roundings that
/// count are those of a column's weights, which all of its frusta share, and a size counts twice.
#[inline(always)]
pub(crate) fn correlated<T: Real>(size: T) -> T {
    size.max(size + size - T::one())
}
