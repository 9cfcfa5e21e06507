//! One ray, whole: Algorithm 1 of the paper.

use super::Real;
use super::column::{Chord, Crossing, Flow, Shell, Values, cross, mix};
use super::piece::{Light, Method, integrate};
use super::plane::RayLine;
use super::sample::{Sample, Samples};
use super::segment::Segment;
use super::shade::{RayShading, Shading};
use super::transfer::Spans;
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

    #[inline]
    fn vertex(&self, cell: u32, layer: usize) -> Values<T, N> {
        let mut values = [T::zero(); N];
        values[0] = self.samples.get(cell, layer);
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

impl<T: Real, S: Sample, const N: usize> Ray<'_, '_, T, S, N> {
    #[inline]
    fn column(&mut self, column: &Column, gap: usize) -> (usize, Flow) {
        self.counts.columns += 1;
        let caster = self.caster;
        let (entry, exit, [a, b, c]) = (&column.entry.weight, &column.exit.weight, column.cells);
        let weight = [[T::of(entry[0]), T::of(entry[1])], [T::of(exit[0]), T::of(exit[1])]];
        let chord_on = |layer: usize| {
            Chord::over([caster.vertex(a, layer), caster.vertex(b, layer), caster.vertex(c, layer)], &weight)
        };
        cross(caster.shell, column, gap, chord_on, |crossing| self.frustum(column, crossing))
    }

    #[inline]
    fn frustum(&mut self, column: &Column, crossing: &Crossing<T, N>) -> Flow {
        let Crossing { gap, a, b, chord } = crossing;
        if *gap == 0 {
            return self.core(column, a.u);
        }
        let Some((chord_a, chord_b)) = chord else {
            return Flow::On;
        };
        self.counts.frusta += 1;
        let (from, to) = (chord_a.at(a.tau), chord_b.at(b.tau));
        let eps = T::of(b.rho - a.rho) / T::of(a.rho);
        let (slope_a, slope_b) = (chord_a.exit[0] - chord_a.entry[0], chord_b.exit[0] - chord_b.entry[0]);
        let kappa = (b.tau - a.tau) * ((slope_a - slope_b) + eps * slope_a);
        let length = T::of(column.exit.t - column.entry.t) * (b.u - a.u);
        let segment = Segment { f0: from[0], f1: to[0], kappa, eps, length };
        if !(segment.f0 + segment.f1 + kappa).is_finite() {
            self.counts.void_frusta += 1;
            self.span = None;
            return Flow::On;
        }
        match segment.extremum() {
            None => self.monotone(&segment, &from, &to),
            Some(turn) => {
                let middle = mix(&from, &to, turn.0);
                self.monotone(&segment.part((T::zero(), segment.f0), turn), &from, &middle);
                self.monotone(&segment.part(turn, (T::one(), segment.f1)), &middle, &to);
            }
        }
        if T::one() - self.light.absorbed < T::of(T::OPAQUE) { Flow::Stop } else { Flow::On }
    }

    /// Splits a monotone segment at the transfer function's knots. The span is carried from piece to piece: which side
    /// of a knot a piece lies on is known from where it came, never asked of a rounded value.
    #[inline]
    fn monotone(&mut self, segment: &Segment<T>, from: &Values<T, N>, to: &Values<T, N>) {
        let spans = self.caster.spans;
        let (f0, f1) = (segment.f0, segment.f1);
        let mut k = match self.span {
            Some(k) => spans.follow(k, f0),
            None => spans.find(f0),
        };
        let rising = f1 >= f0;
        let mut at = (T::zero(), f0);
        if f0.min(f1) >= spans.span(k).low && f0.max(f1) <= spans.span(k).high {
            self.light_of(segment, k, from, to, T::of(0.5));
            self.span = Some(k);
            return;
        }
        loop {
            let knot = if rising { spans.span(k).high } else { spans.span(k).low };
            if if rising { f1 <= knot } else { f1 >= knot } {
                break;
            }
            let next = (segment.solve(knot).max(at.0), knot);
            self.piece(segment, at, next, k, from, to);
            at = next;
            k = if rising { k + 1 } else { k - 1 };
        }
        self.piece(segment, at, (T::one(), f1), k, from, to);
        self.span = Some(k);
    }

    #[inline]
    fn piece(
        &mut self,
        segment: &Segment<T>,
        a: (T, T),
        b: (T, T),
        k: usize,
        from: &Values<T, N>,
        to: &Values<T, N>,
    ) {
        if b.0 > a.0 && !self.caster.spans.span(k).is_clear {
            self.light_of(&segment.part(a, b), k, from, to, T::of(0.5) * (a.0 + b.0));
        }
    }

    /// Adds the light of a piece that stays in span `k`, shaded by the gradient at `middle` between `from` and `to`.
    #[inline]
    fn light_of(&mut self, piece: &Segment<T>, k: usize, from: &Values<T, N>, to: &Values<T, N>, middle: T) {
        let span = self.caster.spans.span(k);
        if span.is_clear {
            return;
        }
        let mut light = integrate(self.caster.method, piece, span);
        if N == 4
            && let Some(shading) = &self.shading
        {
            let middle = mix(from, to, middle);
            let shade = shading.shade([1, 2, 3].map(|k: usize| middle[k.min(N - 1)]));
            light.color = light.color.map(|c| c * shade.body + light.absorbed * shade.highlight);
        }
        self.light.over(&light);
    }

    /// The ray is below the innermost layer: an opaque core ends it, a hollow one lets it pass.
    fn core(&mut self, column: &Column, u: T) -> Flow {
        let Some(color) = self.caster.core else {
            return Flow::On;
        };
        let t = column.entry.t + u.wide() * (column.exit.t - column.entry.t);
        let body = match &self.shading {
            Some(shading) => shading.solid(self.line.position(t).normalize_or_zero()),
            None => T::one(),
        };
        self.light.over(&Light { color: color.map(|c| T::of(c) * body), absorbed: T::one() });
        Flow::Stop
    }
}
