//! One ray, whole: Algorithm 1 of the paper.

use super::column::{Chord, Flow, Shell, Station, Values, Visit, cross};
use super::doubt::{Cut, Doubt, Medium};
use super::leap::Visible;
use super::lit::{Course, Lit};
use super::piece::{Allowance, Light, Method, integrate};
use super::plane::RayLine;
use super::real::{Real, lerp};
use super::sample::AnySamples;
use super::segment::Segment;
use super::shade::{RayShading, Shading};
use super::transfer::Spans;
use super::walk::{Column, Walk};
use crate::array::{MapInline, partition_point};
use crate::gradient::Gradients;
use crate::grid::Grid;
use crate::ground::{Ground, Sight};
use batch::{Batch, Known};
use fearless_simd::Level;
use glam::DVec3;
use queue::Queue;

#[allow(clippy::needless_range_loop, reason = "rows side by side are indexed alike")]
mod abreast;
#[allow(clippy::needless_range_loop, reason = "rows side by side are indexed alike")]
mod batch;
mod casts;
mod counts;
mod fragment;
mod queue;
pub(crate) use abreast::packets;
pub(crate) use casts::Casts;
pub use counts::Counts;
pub use fragment::Fragment;
pub(crate) use fragment::Runs;

/// How a ray may spend the scene's tolerance: one half on the colour of pieces, one on what an early end leaves out. Where
/// colour and shade of a piece have errors of their own, nine tenths are for these two.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Budget {
    /// Error of the colour per absorbed light.
    pub share: f64,
    /// A ray ends once its transmittance is down to this.
    pub rest: f64,
    /// The most that a channel can hold behind a ray's end.
    pub brightest: f64,
}

impl Budget {
    /// For a picture in which no channel can be brighter than `brightest`. `lit` is the most of the light that
    /// falls on a colour, where colours and shades of pieces have errors of their own.
    #[inline]
    pub fn new(tolerance: f64, brightest: f64, lit: Option<f64>) -> Self {
        // A little is left for the parts of pieces that are so small that they need not be near.
        let [share, rest] = lit.map_or([0.5; 2], |lit| [0.88 / (1.0 + lit), 0.1]);
        Budget { share: share * tolerance, rest: rest * tolerance / brightest, brightest }
    }

    /// Whether a surface behind what has absorbed so much light is seen: whether or not a ray ends before it, the picture has the
    /// same edges.
    #[inline]
    pub fn sees_behind(&self, absorbed: f64) -> bool {
        1.0 - absorbed > 2.0 * self.share
    }
}

/// A ray to be traced.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    /// What its light is told with.
    pub number: usize,
    pub eye: DVec3,
    pub dir: DVec3,
    /// Whether it begins a row, and is searched for from the row before.
    pub begins_row: bool,
}

/// Everything that is the same for all rays of a frame. N = 1 renders unlit, N = 4 carries gradients along.
pub(crate) struct Caster<'f, T, const N: usize> {
    pub grid: &'f Grid<'f>,
    pub shell: &'f Shell<T>,
    pub spans: &'f Spans<T>,
    pub samples: AnySamples<'f>,
    /// Where something can be seen.
    pub visible: &'f Visible,
    /// From where inwards something can be seen.
    pub outer: f64,
    /// Gradients at the vertices, level-fastest; none when N = 1.
    pub gradients: &'f Gradients,
    pub method: Method,
    pub budget: Budget,
    pub shading: Option<Shading>,
    /// When set, light is not cut where the gradient turns.
    pub is_coarse: bool,
    /// The machine's vector instructions, where rays are traced in packets.
    pub level: Option<Level>,
    /// Whether frusta that were gathered are integrated: not where the walk alone is measured.
    pub integrates: bool,
    /// Linear RGB of the opaque core; `None` lets rays through the hollow core.
    pub core: Option<[f64; 3]>,
    /// What the core looks like where it has more than one colour.
    pub ground: Option<&'f Ground>,
}

impl<'f, T: Real, const N: usize> Caster<'f, T, N> {
    /// Traces rays, in any order, and tells the light of each, premultiplied; `None` where it misses the shell.
    #[inline]
    pub fn trace_all<'r>(
        &'r self,
        rays: &mut dyn Iterator<Item = Start>,
        counts: &mut Counts,
        tell: &mut dyn FnMut(usize, Option<Light<T>>),
    ) where
        'f: 'r,
    {
        if T::HAS_PACKETS
            && let Some(level) = self.level
        {
            return self.trace_abreast(level, rays, counts, tell);
        }
        let mut queue = Queue::new(self, rays);
        while let Some((start, line, walk)) = queue.next(|number| tell(number, None)) {
            let mut ray = self.ray(line, start.dir);
            ray.pass(walk);
            *counts += ray.counts;
            tell(start.number, Some(ray.light));
        }
    }

    /// A ray that has met nothing yet.
    #[inline]
    fn ray<'r>(&'r self, line: RayLine, dir: DVec3) -> Ray<'r, 'f, T, N> {
        // Less than the last digit cannot be asked for.
        let share = self.budget.share.max(T::ROUNDING);
        Ray {
            caster: self,
            line,
            shading: self.shading.map(|s| s.along::<T>(dir, share)),
            share: T::of(share),
            rest: T::of(self.budget.rest),
            span: None,
            light: Light::none(),
            counts: Counts { rays: 1, ..Counts::default() },
        }
    }

    /// Value, and gradient where there is light, at one vertex, of which the value is known.
    #[inline(always)]
    fn vertex(&self, cell: u32, value: T, layer: usize) -> Values<T, N> {
        let mut values = [T::zero(); N];
        values[0] = value;
        if N == 4 {
            let gradient = self.gradients.at(cell as usize * self.shell.layers() + layer);
            for k in 0..3 {
                values[1 + k] = T::of(f64::from(gradient[k]));
            }
        }
        values
    }
}

struct Ray<'r, 'f, T, const N: usize> {
    caster: &'r Caster<'f, T, N>,
    line: RayLine,
    shading: Option<RayShading<T>>,
    share: T,
    rest: T,
    /// The span of the transfer function that the ray is in; `None` at its start and behind a void.
    span: Option<usize>,
    light: Light<T>,
    counts: Counts,
}

/// A ray inside one column.
struct Pass<'p, 'r, 'f, T, const N: usize> {
    ray: &'p mut Ray<'r, 'f, T, N>,
    column: &'p Column,
    /// The blocks in which something can be seen.
    blocks: u32,
    /// Where each vertex's samples begin.
    base: [isize; 3],
    /// Weights of the second and third vertex at the column's entry and exit.
    weight: [[T; 2]; 2],
    length: f64,
}

impl<T: Real, const N: usize> Visit<T, N> for Pass<'_, '_, '_, T, N> {
    #[inline(always)]
    fn chord(&self, layer: usize) -> Chord<T, N> {
        let (caster, cells, base) = (self.ray.caster, &self.column.cells, &self.base);
        let vertex = |k: usize| caster.vertex(cells[k], caster.samples.get(base[k], layer), layer);
        Chord::over([vertex(0), vertex(1), vertex(2)], &self.weight)
    }

    #[inline(always)]
    fn frustum(
        &mut self,
        _: usize,
        [a, b]: [&Station<T>; 2],
        [at_a, at_b]: [&Chord<T, N>; 2],
        eps: T,
    ) -> Flow {
        let course = at_a.course(at_b, [a.tau, b.tau], eps);
        self.ray.frustum(&course, T::of(self.length * (b.u - a.u)))
    }

    #[inline(always)]
    fn leaps(&mut self, gap: usize) -> bool {
        let leaps = !self.ray.caster.visible.shows(self.blocks, gap);
        if leaps {
            self.ray.span = None;
        }
        leaps
    }

    #[inline]
    fn core(&mut self, a: &Station<T>) -> Flow {
        self.ray.core(lerp(self.column.entry.t, self.column.exit.t, a.u))
    }
}

// Columns and their frusta are inlined by force: where two loops meet them, the compiler would call them instead, which
// costs a frame 5 to 15 %.
impl<T: Real, const N: usize> Ray<'_, '_, T, N> {
    /// Walks over all columns, until the ray ends.
    #[inline]
    fn pass(&mut self, mut walk: Walk) {
        let mut gap = None;
        let has_void = self.caster.grid.void_triangles() > 0;
        loop {
            // Asked once, so that whole spheres pay for a flag only.
            let is_void = has_void && walk.is_void();
            let blocks = self.caster.visible.over(walk.triangle());
            let Some(column) = walk.next_column() else { return };
            let (next, flow) = if is_void {
                (None, self.void_column(&column))
            } else {
                let start = gap.unwrap_or_else(|| self.caster.shell.gap(column.entry.rho));
                let (next, flow) = self.column(&column, start, blocks);
                (Some(next), flow)
            };
            if flow == Flow::Stop {
                return;
            }
            gap = next;
        }
    }

    /// Adds the light of frustum number `n` of a batch.
    #[inline(always)]
    fn meet(&mut self, batch: &Batch<T, N>, n: usize) -> Flow {
        if batch.is_fresh(n) {
            self.span = None;
        }
        let (known, span) = batch.known(n);
        if known == Known::Odd || known == Known::Halves && self.ends_between(batch.front(n)) {
            return self.odd(batch, n);
        }
        self.counts.frusta += 1;
        self.span = Some(span);
        if known != Known::Clear {
            self.add(&batch.light(n));
        }
        self.passed(&batch.segment(n))
    }

    /// Whether no light comes through the front half of a frustum.
    #[inline(always)]
    fn ends_between(&self, front: T) -> bool {
        (T::one() - front) * (T::one() - self.light.absorbed) <= self.rest
    }

    #[inline(never)]
    fn odd(&mut self, batch: &Batch<T, N>, n: usize) -> Flow {
        let (course, length) = batch.course(n, self.caster);
        self.frustum(&course, length)
    }

    #[inline(always)]
    fn column(&mut self, column: &Column, gap: usize, blocks: u32) -> (usize, Flow) {
        self.counts.columns += 1;
        let (entry, exit) = (&column.entry, &column.exit);
        let base = self.caster.samples.bases(column.cells);
        let weight = [entry, exit].map_inline(|end| [T::of(end.weight[0]), T::of(end.weight[1])]);
        let shell = self.caster.shell;
        let mut pass = Pass { ray: self, column, blocks, base, weight, length: exit.t - entry.t };
        cross(shell, column, gap, &mut pass)
    }

    /// Over a void triangle nothing is read, and the core is round: facets are those of data.
    #[cold]
    #[inline(never)]
    fn void_column(&mut self, column: &Column) -> Flow {
        self.counts.columns += 1;
        self.span = None;
        let met = self.line.first_inside(self.caster.shell.inner(), [column.entry.t, column.exit.t]);
        met.map_or(Flow::On, |t| self.core(t))
    }

    /// An opaque core ends the ray, a hollow one lets it pass.
    #[inline]
    fn core(&mut self, t: f64) -> Flow {
        let Some(mut color) = self.caster.core else { return Flow::On };
        if let Some(ground) = self.caster.ground {
            color = self.ground(ground, t);
        }
        let body = match &self.shading {
            Some(shading) => shading.solid(self.line.position(t).normalize_or_zero()),
            None => T::one(),
        };
        self.light.over(&Light::plain(color.map_inline(|c| T::of(c) * body), T::one()));
        Flow::Stop
    }

    #[cold]
    #[inline(never)]
    fn ground(&self, ground: &Ground, t: f64) -> [f64; 3] {
        ground.color(&Sight::round(self.line.position(t)), None)
    }

    /// Adds the light of one frustum, of which the ray passes `length`.
    #[inline(always)]
    fn frustum(&mut self, course: &Course<T, N>, length: T) -> Flow {
        self.counts.frusta += 1;
        let segment =
            Segment { f0: course.from[0], f1: course.to[0], kappa: course.kappa[0], eps: course.eps, length };
        match self.enter(&segment) {
            Some(k) => self.whole(&segment, k, course),
            None => Flow::On,
        }
    }

    /// The span that the value of a frustum begins in; `None` where it is void.
    #[inline(always)]
    fn enter(&mut self, segment: &Segment<T>) -> Option<usize> {
        if segment.is_void() {
            self.counts.void_frusta += 1;
            self.span = None;
            return None;
        }
        let spans = self.caster.spans;
        // A constant lies where its value lies, not where the ray came from.
        let known = self.span.filter(|_| !segment.is_constant());
        Some(known.map_or_else(|| spans.find(segment.f0), |k| spans.follow(k, segment.f0)))
    }

    /// The light of a whole frustum whose value begins in span `k`.
    #[inline(always)]
    fn whole(&mut self, segment: &Segment<T>, mut k: usize, course: &Course<T, N>) -> Flow {
        let spans = self.caster.spans;
        let whole = [T::zero(), T::one()];
        let reach = segment.reach();
        if self.caster.method == Method::Exact {
            k = spans.holding(k, segment);
        }
        if self.caster.method == Method::Exact && spans.span(k).holds(segment) {
            self.piece(segment, k, course, whole, reach);
        } else {
            k = match segment.extremum() {
                None => self.monotone(segment, k, course, whole),
                Some(turn) => {
                    let (start, end) = ((whole[0], segment.f0), (whole[1], segment.f1));
                    let k = self.monotone(&segment.part(start, turn), k, course, [start.0, turn.0]);
                    self.monotone(&segment.part(turn, end), k, course, [turn.0, end.0])
                }
            };
        }
        self.span = Some(k);
        self.passed(segment)
    }

    /// Behind a frustum: whether the ray ends there.
    #[inline(always)]
    fn passed(&mut self, segment: &Segment<T>) -> Flow {
        if !self.caster.spans.steps().is_empty() {
            self.near_steps(segment);
        }
        // A piece that ended early knows its transmittance to the last digit only.
        let through = T::one() - self.light.absorbed;
        if through > self.rest * T::of(1.001) + T::of(2.0 * T::ROUNDING) {
            return Flow::On;
        }
        self.light.error = self.light.error + through * T::of(self.caster.budget.brightest);
        Flow::Stop
    }

    /// Splits a monotone segment, `range` of the whole course, at the transfer function's knots, from span `k` to the
    /// one that is returned. The span is carried from piece to piece: which side of a knot a piece lies on is known
    /// from where it came, never asked of a rounded value.
    #[inline]
    fn monotone(
        &mut self,
        segment: &Segment<T>,
        mut k: usize,
        course: &Course<T, N>,
        range: [T; 2],
    ) -> usize {
        let spans = self.caster.spans;
        let (f0, f1) = (segment.f0, segment.f1);
        if f0.min(f1) >= spans.span(k).low && f0.max(f1) <= spans.span(k).high {
            self.piece(segment, k, course, range, segment.reach());
            return k;
        }
        let mut doubt = Doubt::new(segment, Medium::at(spans.span(k), f0));
        let (zero, one) = (T::zero(), T::one());
        let rising = f1 >= f0;
        // Each knot is sought in what is left: a narrow piece found from the start would be a difference of two u.
        let mut rest = *segment;
        let mut from = range[0];
        loop {
            let span = spans.span(k);
            let knot = if rising { span.high } else { span.low };
            let is_last = if rising { f1 <= knot } else { f1 >= knot };
            let end = if is_last { (one, f1) } else { (rest.solve(knot), knot) };
            let to = lerp(from, range[1], end.0);
            if end.0 > zero {
                let (before, f) = (self.light.absorbed, [rest.f0, end.1]);
                let part = if is_last { rest } else { rest.part((zero, f[0]), end) };
                let is_between = rest.f0 != f0 && !is_last;
                let reach = if is_between { between(&f) } else { segment.reach() };
                self.piece(&part, k, course, [from, to], reach);
                let mean = Medium::at(span, T::of(0.5) * (f[0] + f[1]));
                let change = span.steepest() * (f[1] - f[0]).abs();
                doubt.cut(
                    &mut self.light,
                    before,
                    Cut { value: f[0], length: part.length, mean, change, is_narrow: span.is_narrow() },
                );
            }
            if is_last {
                doubt.shift(&mut self.light, &Medium::at(span, f1));
                return k;
            }
            rest = rest.part(end, (one, f1));
            from = to;
            k = if rising { k + 1 } else { k - 1 };
        }
    }

    /// Adds the light of a piece that stays in span `k`.
    #[inline]
    fn piece(&mut self, piece: &Segment<T>, k: usize, course: &Course<T, N>, range: [T; 2], reach: T) {
        let span = self.caster.spans.span(k);
        if span.is_clear_in(piece) {
            return;
        }
        let through = T::one() - self.light.absorbed;
        if through <= self.rest {
            return;
        }
        let allowance = Allowance { share: self.share, rest: self.rest, through, reach };
        let light = match &self.shading {
            Some(shading) if N == 4 => {
                let lit = Lit { method: self.caster.method, allowance: &allowance, shading, span, course };
                let cuts = if self.caster.is_coarse { 0 } else { Lit::<T, N>::MOST_CUTS };
                lit.light(piece, range, cuts)
            }
            _ => integrate(self.caster.method, piece, span, &allowance),
        };
        self.add(&light);
    }

    #[inline(always)]
    fn add(&mut self, light: &Light<T>) {
        self.light.over(light);
        // The sum is rounded to its own last digit.
        let off = T::of(0.5 * T::ROUNDING) * self.light.absorbed;
        self.light.variance = self.light.variance + off * off;
    }

    /// A segment that ends or turns as close to a step as rounding reaches may lie beyond it there.
    #[inline]
    fn near_steps(&mut self, segment: &Segment<T>) {
        let steep = (segment.f1 - segment.f0).abs() + segment.kappa.abs();
        if steep == T::zero() {
            return;
        }
        let reach = T::of(8.0) * segment.reach();
        // Where f turns it lies beyond for the root of what rounding reaches, at an end as its slope there goes.
        let root = (reach / (reach + steep)).sqrt();
        let rise = segment.f1 - segment.f0;
        let slopes = [rise + segment.kappa, rise - segment.kappa / (T::one() + segment.eps)];
        let at_end = |slope: T| (reach / (reach + slope.abs())).min(root);
        let ends = [(segment.f0, at_end(slopes[0])), (segment.f1, at_end(slopes[1]))];
        let turn = segment.extremum().map(|(_, f)| (f, root));
        let steps = self.caster.spans.steps();
        for (extreme, part) in ends.into_iter().chain(turn) {
            let first = partition_point(steps, |step| step.value < extreme - reach);
            for step in steps[first..].iter().take_while(|step| step.value <= extreme + reach) {
                let through = T::one() - self.light.absorbed;
                let beyond = (segment.length * part * step.extinction).absorbed_by();
                self.light.error = self.light.error + through * beyond;
            }
        }
    }
}

/// How far rounding may have put two knots, against each other: as their own last digits go.
#[inline]
fn between<T: Real>(knots: &[T; 2]) -> T {
    T::of(0.5 * T::ROUNDING) * (knots[0].abs() + knots[1].abs())
}
