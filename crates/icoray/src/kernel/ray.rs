//! One ray, whole: Algorithm 1 of the paper.

use super::column::{Chord, Flow, Shell, Station, Values, Visit, cross};
use super::piece::{Light, Method, integrate};
use super::plane::RayLine;
use super::real::{Real, lerp};
use super::sample::{Sample, Samples};
use super::segment::Segment;
use super::shade::{RayShading, Shading};
use super::transfer::{Span, Spans};
use super::walk::{Column, Walk};
use crate::grid::Grid;
use glam::DVec3;

/// What rays met, added up over a tile or a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays that met the shell.
    pub rays: u64,
    /// Columns that they walked over.
    pub columns: u64,
    /// Frusta that they crossed.
    pub frusta: u64,
    /// Frusta among these that a missing value made void.
    pub void_frusta: u64,
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.columns += other.columns;
        self.frusta += other.frusta;
        self.void_frusta += other.void_frusta;
    }
}

/// Everything that is the same for all rays of a frame. N = 1 renders unlit, N = 4 carries gradients along.
pub(crate) struct Caster<'f, T, S, const N: usize> {
    pub grid: &'f Grid<'f>,
    pub shell: &'f Shell<T>,
    pub spans: &'f Spans<T>,
    pub samples: Samples<'f, S>,
    /// Gradients at the vertices, level-fastest; empty when N = 1.
    pub gradients: &'f [[f32; 3]],
    pub method: Method,
    pub shading: Option<Shading>,
    /// Linear RGB of the opaque core; `None` lets rays through the hollow core.
    pub core: Option<[f64; 3]>,
}

impl<T: Real, S: Sample, const N: usize> Caster<'_, T, S, N> {
    /// Light that comes along the ray from `eye` towards the unit vector `dir`, premultiplied.
    ///
    /// `hint` is a triangle to search the first column from, and becomes that column's triangle.
    pub fn trace(&self, eye: DVec3, dir: DVec3, hint: &mut u32, counts: &mut Counts) -> Light<T> {
        let mut light = Light::none();
        let Some(line) = RayLine::new(eye, dir, self.shell.outer()) else {
            return light;
        };
        counts.rays += 1;
        let mut walk = Walk::new(self.grid, line, *hint);
        *hint = walk.triangle();
        let shading = self.shading.map(|s| s.along::<T>(dir));
        let mut ray = Ray { caster: self, line, shading, span: None, light: &mut light, counts };
        let mut gap = None;
        while let Some(column) = walk.next_column() {
            let start = gap.unwrap_or_else(|| self.shell.gap(column.entry.rho));
            let (next, flow) = ray.column(&column, start);
            if flow == Flow::Stop {
                break;
            }
            gap = Some(next);
        }
        light
    }

    #[inline(always)]
    fn vertex(&self, cell: u32, base: isize, layer: usize) -> Values<T, N> {
        let mut values = [T::zero(); N];
        values[0] = self.samples.get(base, layer);
        if N == 4 {
            let gradient = self.gradients[cell as usize * self.shell.layers() + layer];
            for k in 0..3 {
                values[1 + k] = T::of(f64::from(gradient[k]));
            }
        }
        values
    }
}

struct Ray<'r, 'f, T, S, const N: usize> {
    caster: &'r Caster<'f, T, S, N>,
    line: RayLine,
    shading: Option<RayShading<T>>,
    /// The span of the transfer function that the ray is in; `None` at its start and behind a void.
    span: Option<usize>,
    light: &'r mut Light<T>,
    counts: &'r mut Counts,
}

/// A ray inside one column.
struct Pass<'p, 'r, 'f, T, S, const N: usize> {
    ray: &'p mut Ray<'r, 'f, T, S, N>,
    column: &'p Column,
    /// Where each vertex's samples begin.
    base: [isize; 3],
    /// Weights of the second and third vertex at the column's entry and exit.
    weight: [[T; 2]; 2],
    length: T,
}

impl<T: Real, S: Sample, const N: usize> Visit<T, N> for Pass<'_, '_, '_, T, S, N> {
    #[inline(always)]
    fn chord(&self, layer: usize) -> Chord<T, N> {
        let (caster, cells, base) = (self.ray.caster, &self.column.cells, &self.base);
        let vertex = |k: usize| caster.vertex(cells[k], base[k], layer);
        Chord::over([vertex(0), vertex(1), vertex(2)], &self.weight)
    }

    #[inline(always)]
    fn frustum(&mut self, a: &Station<T>, b: &Station<T>, at_a: &Chord<T, N>, at_b: &Chord<T, N>) -> Flow {
        let eps = T::of(b.rho - a.rho) / T::of(a.rho);
        let mut course = Course { from: at_a.at(a.tau), to: at_b.at(b.tau), kappa: [T::zero(); N], eps };
        for k in 0..N {
            let (slope_a, slope_b) = (at_a.exit[k] - at_a.entry[k], at_b.exit[k] - at_b.entry[k]);
            course.kappa[k] = (b.tau - a.tau) * ((slope_a - slope_b) + eps * slope_a);
        }
        self.ray.frustum(&course, self.length * (b.u - a.u))
    }

    /// An opaque core ends the ray, a hollow one lets it pass.
    fn core(&mut self, a: &Station<T>) -> Flow {
        let Some(color) = self.ray.caster.core else { return Flow::On };
        let (entry, exit) = (&self.column.entry, &self.column.exit);
        let t = entry.t + a.u.wide() * (exit.t - entry.t);
        let body = match &self.ray.shading {
            Some(shading) => shading.solid(self.ray.line.position(t).normalize_or_zero()),
            None => T::one(),
        };
        self.ray.light.over(&Light { color: color.map(|c| T::of(c) * body), absorbed: T::one() });
        Flow::Stop
    }
}

impl<T: Real, S: Sample, const N: usize> Ray<'_, '_, T, S, N> {
    #[inline]
    fn column(&mut self, column: &Column, gap: usize) -> (usize, Flow) {
        self.counts.columns += 1;
        let (entry, exit, [a, b, c]) = (&column.entry, &column.exit, column.cells);
        let samples = &self.caster.samples;
        let base = [samples.base(a), samples.base(b), samples.base(c)];
        let weight = [entry, exit].map(|end| [T::of(end.weight[0]), T::of(end.weight[1])]);
        let shell = self.caster.shell;
        let mut pass = Pass { ray: self, column, base, weight, length: T::of(exit.t - entry.t) };
        cross(shell, column, gap, &mut pass)
    }

    /// Adds the light of one frustum, of which the ray passes `length`.
    #[inline]
    fn frustum(&mut self, course: &Course<T, N>, length: T) -> Flow {
        self.counts.frusta += 1;
        let segment =
            Segment { f0: course.from[0], f1: course.to[0], kappa: course.kappa[0], eps: course.eps, length };
        if !(segment.f0 + segment.f1 + segment.kappa).is_finite() {
            self.counts.void_frusta += 1;
            self.span = None;
            return Flow::On;
        }
        let (zero, one) = (T::zero(), T::one());
        match segment.extremum() {
            None => self.monotone(&segment, course, [zero, one]),
            Some(turn) => {
                self.monotone(&segment.part((zero, segment.f0), turn), course, [zero, turn.0]);
                self.monotone(&segment.part(turn, (one, segment.f1)), course, [turn.0, one]);
            }
        }
        if one - self.light.absorbed < T::of(T::OPAQUE) { Flow::Stop } else { Flow::On }
    }

    /// Splits a monotone segment, `range` of the whole course, at the transfer function's knots. The span is carried
    /// from piece to piece: which side of a knot a piece lies on is known from where it came, never asked of a
    /// rounded value.
    #[inline]
    fn monotone(&mut self, segment: &Segment<T>, course: &Course<T, N>, range: [T; 2]) {
        let spans = self.caster.spans;
        let (f0, f1) = (segment.f0, segment.f1);
        let mut k = match self.span {
            Some(k) => spans.follow(k, f0),
            None => spans.find(f0),
        };
        let mut at = (T::zero(), f0);
        if f0.min(f1) >= spans.span(k).low && f0.max(f1) <= spans.span(k).high {
            self.piece(segment, k, course, range);
            self.span = Some(k);
            return;
        }
        let rising = f1 >= f0;
        let whole = |u: T| range[0] + u * (range[1] - range[0]);
        loop {
            let knot = if rising { spans.span(k).high } else { spans.span(k).low };
            let is_last = if rising { f1 <= knot } else { f1 >= knot };
            let next = if is_last { (T::one(), f1) } else { (segment.solve(knot).max(at.0), knot) };
            if next.0 > at.0 && !spans.span(k).is_clear {
                self.piece(&segment.part(at, next), k, course, [whole(at.0), whole(next.0)]);
            }
            if is_last {
                break;
            }
            at = next;
            k = if rising { k + 1 } else { k - 1 };
        }
        self.span = Some(k);
    }

    /// Adds the light of a monotone piece that stays in span `k`.
    #[inline]
    fn piece(&mut self, piece: &Segment<T>, k: usize, course: &Course<T, N>, range: [T; 2]) {
        let span = self.caster.spans.span(k);
        if span.is_clear {
            return;
        }
        let light = match &self.shading {
            Some(shading) if N == 4 => shaded(self.caster.method, shading, piece, span, course, range),
            _ => integrate(self.caster.method, piece, span),
        };
        self.light.over(&light);
    }
}

/// Value and gradient along a whole frustum: each component runs as a [`Segment`]'s value does.
struct Course<T, const N: usize> {
    from: Values<T, N>,
    to: Values<T, N>,
    kappa: Values<T, N>,
    eps: T,
}

impl<T: Real, const N: usize> Course<T, N> {
    /// The gradient at `u`.
    #[inline]
    fn gradient(&self, u: T) -> [T; 3] {
        let bent = u * (T::one() - u) / (T::one() + self.eps * u);
        let at = |k: usize| lerp(self.from[k % N], self.to[k % N], u) + bent * self.kappa[k % N];
        [at(1), at(2), at(3)]
    }
}

/// A piece under light: cut into parts over which the gradient turns little, each shaded by the gradient at its middle.
#[inline]
fn shaded<T: Real, const N: usize>(
    method: Method,
    shading: &RayShading<T>,
    piece: &Segment<T>,
    span: &Span<T>,
    course: &Course<T, N>,
    range: [T; 2],
) -> Light<T> {
    let middle = course.gradient(T::of(0.5) * (range[0] + range[1]));
    let count = shading.parts(&course.gradient(range[0]), &middle, &course.gradient(range[1]));
    let mut light = Light::none();
    let mut start = (T::zero(), piece.f0);
    for i in 0..count {
        let fraction = |steps: usize| T::of(steps as f64 / (2 * count) as f64);
        let u = fraction(2 * i + 2);
        let end = if i + 1 == count { (T::one(), piece.f1) } else { (u, piece.value(u)) };
        let part = if count == 1 { *piece } else { piece.part(start, end) };
        let mut own = integrate(method, &part, span);
        let gradient =
            if count == 1 { middle } else { course.gradient(lerp(range[0], range[1], fraction(2 * i + 1))) };
        let shade = shading.shade(gradient);
        for channel in &mut own.color {
            *channel = *channel * shade.body + own.absorbed * shade.highlight;
        }
        light.over(&own);
        start = end;
    }
    light
}
