//! One ray from column to column, carrying `N` values.

use crate::column::{Chord, ColumnVisitor, Flow, RayPoint, cross};
use crate::column_ray::ColumnRay;
use crate::counts::Counts;
use crate::piece::Radiance;
use crate::plane::RayLine;
use crate::shade::RayShading;
use crate::signature::BoundarySignature;
use crate::single_volume::SingleVolumeTracer;
use crate::walk::Column;
use glam::DVec3;
use icoray_grid::array::MapInline;
use icoray_grid::real::{Real, lerp};

/// A ray between two columns.
pub(crate) struct Ray<'r, 'f, T, const N: usize> {
    pub tracer: &'r SingleVolumeTracer<'f, T>,
    line: RayLine,
    pub shading: Option<RayShading<T>>,
    /// Allowed error of the colour per absorbed light.
    pub color_tolerance: T,
    /// Transmittance at which the ray ends.
    pub min_transmittance: T,
    /// The gap at the exit of the last column; `None` at the start and behind a void.
    gap: Option<usize>,
    /// The span of the transfer function at the ray's position; `None` at the start and behind a void.
    pub span: Option<usize>,
    /// The largest magnitude of values at the vertices of the current frustum, if needed
    /// ([`Spans::needs_sizes`](crate::transfer::Spans::needs_sizes)); else 1.
    pub size: T,
    /// The largest component of the gradients at the vertices, if known; else 0.
    pub gradient_size: T,
    pub light: Radiance<T>,
    pub counts: Counts,
}

/// A ray inside one column.
struct Pass<'p, 'r, 'f, T, const N: usize> {
    ray: &'p mut Ray<'r, 'f, T, N>,
    column: &'p Column,
    /// Bits of the visible blocks of gaps.
    blocks: u32,
    /// Offsets of the samples of each vertex.
    base: [isize; 3],
    /// Weights of the second and third vertex at the column's entry and exit.
    weight: [[T; 2]; 2],
    length: f64,
}

impl<T: Real, const N: usize> ColumnVisitor<T, N> for Pass<'_, '_, '_, T, N> {
    #[inline(always)]
    fn chord(&self, layer: usize) -> Chord<T, N> {
        let (tracer, cells, base) = (self.ray.tracer, &self.column.cells, &self.base);
        let vertex = |k: usize| tracer.vertex(cells[k], tracer.samples.get(base[k], layer), layer);
        Chord::over([vertex(0), vertex(1), vertex(2)], &self.weight)
    }

    #[inline(always)]
    fn frustum(&mut self, lower: usize, [a, b]: [&RayPoint<T>; 2], [at_a, at_b]: [&Chord<T, N>; 2], eps: T) -> Flow {
        let interpolant = at_a.interpolant(at_b, [a.tau, b.tau], eps);
        if self.ray.tracer.needs_sizes {
            self.ray.size = self.size(lower);
        }
        self.ray.frustum(&interpolant, T::of(self.length * (b.u - a.u)))
    }

    #[inline(always)]
    fn skips(&mut self, gap: usize) -> bool {
        let skips = !self.ray.tracer.visible.is_occupied(self.blocks, gap);
        if skips {
            self.ray.span = None;
        }
        skips
    }

    #[inline]
    fn core(&mut self, a: &RayPoint<T>) -> Flow {
        self.ray.core(lerp(self.column.entry.t, self.column.exit.t, a.u))
    }
}

impl<T: Real, const N: usize> Pass<'_, '_, '_, T, N> {
    /// The largest magnitude of the values at the vertices of the gap above layer `lower`.
    #[inline]
    fn size(&self, lower: usize) -> T {
        let at = |base: isize, layer: usize| self.ray.tracer.samples.get::<T>(base, layer).abs();
        let over = |base: &isize| at(*base, lower).max(at(*base, lower + 1));
        correlated(self.base.iter().map(over).fold(T::zero(), T::max))
    }
}

/// Far beyond the transfer function's range, the roundings that matter are those of a column's weights, which all of
/// its frusta share: a size counts twice there.
#[inline(always)]
fn correlated<T: Real>(size: T) -> T {
    size.max(size + size - T::one())
}

// Columns and their frusta are always inlined: two loops call them (`trace.rs`, `fragment.rs`), and the compiler would
// not inline them by itself, which costs a frame 5 to 15 %.
impl<T: Real, const N: usize> ColumnRay for Ray<'_, '_, T, N> {
    type Real = T;

    #[inline(always)]
    fn blocks(&self, triangle: u32) -> u32 {
        self.tracer.visible.blocks_over(triangle)
    }

    #[inline(always)]
    fn column(&mut self, column: &Column, _: u32, blocks: u32) -> Flow {
        self.counts.columns += 1;
        let (entry, exit) = (&column.entry, &column.exit);
        let shell = self.tracer.shell;
        let gap = self.gap.unwrap_or_else(|| shell.gap(entry.rho));
        let base = self.tracer.samples.bases(column.cells);
        let weight = [entry, exit].map_inline(|end| [T::of(end.weight[0]), T::of(end.weight[1])]);
        let mut pass = Pass { ray: self, column, blocks, base, weight, length: exit.t - entry.t };
        let (gap, flow) = cross(shell, column, gap, &mut pass);
        self.gap = Some(gap);
        flow
    }

    #[cold]
    #[inline(never)]
    fn void_column(&mut self, column: &Column) -> Flow {
        self.counts.columns += 1;
        (self.span, self.gap) = (None, None);
        let met = self.line.first_inside(self.tracer.shell.inner(), [column.entry.t, column.exit.t]);
        met.map_or(Flow::On, |t| self.core(t))
    }

    #[inline]
    fn counts(&mut self) -> &mut Counts {
        &mut self.counts
    }

    #[inline]
    fn met(&self) -> (&Radiance<T>, BoundarySignature) {
        (&self.light, BoundarySignature::default())
    }

    #[inline]
    fn restart(&mut self) {
        self.min_transmittance = self.min_transmittance / self.light.transmittance();
        (self.light, self.span, self.gap) = (Radiance::none(), None, None);
    }
}

impl<'r, 'f, T: Real, const N: usize> Ray<'r, 'f, T, N> {
    /// A ray along `dir` at its start; `line` is the same ray in its plane.
    #[inline]
    pub fn new(tracer: &'r SingleVolumeTracer<'f, T>, line: RayLine, dir: DVec3) -> Self {
        let color_tolerance = tracer.color_tolerance();
        Ray {
            tracer,
            line,
            shading: tracer.shading.map(|s| s.along::<T>(dir)),
            color_tolerance: T::of(color_tolerance),
            min_transmittance: T::of(tracer.budget.min_transmittance),
            gap: None,
            span: None,
            size: T::one(),
            gradient_size: T::zero(),
            light: Radiance::none(),
            counts: Counts { rays: 1, ..Counts::default() },
        }
    }

    /// Ends the ray at an opaque core, or passes a hollow one.
    #[inline]
    pub fn core(&mut self, t: f64) -> Flow {
        let Some(core) = &self.tracer.core else { return Flow::On };
        self.light.over(&core.round_light(self.line.position(t), self.shading.as_ref()));
        Flow::Stop
    }
}
