//! The frusta along a ray, for callers that integrate other quantities along it.

use crate::column::{Chord, ColumnVisitor, Flow, RayPoint, Shell, cross};
use crate::plane::RayLine;
use crate::walk::{Column, Walk};
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::array::MapInline;
use icoray_grid::real::lerp;
use icoray_grid::{Error, ErrorKind, Result};
use std::ops::ControlFlow;

/// A grid with layers, through which rays are traced. The walk is the renderer's: no ray is lost, no frustum is visited
/// twice, and the stretches of a ray join without a gap.
///
/// ```
/// use glam::DVec3;
/// use icoray_grid::{Grid, IcosahedralMesh};
/// use icoray_kernel::{Stretch, Traversal};
/// use std::ops::ControlFlow;
///
/// let mesh = IcosahedralMesh::new(3)?;
/// let grid = Grid::new(mesh.tables())?;
/// let traversal = Traversal::new(&grid, &[1.0, 1.1, 1.2])?;
/// // The length of a ray's way through the shell, down to the core.
/// let (mut hint, mut length) = (0, 0.0);
/// let eye = DVec3::new(3.0, 0.1, 0.2);
/// traversal.ray(eye, -eye.normalize(), &mut hint, |stretch| match stretch {
///     Stretch::Frustum(frustum) => {
///         length += frustum.t[1] - frustum.t[0];
///         ControlFlow::Continue(())
///     }
///     Stretch::Core { .. } => ControlFlow::Break(()),
/// });
/// // Facets lie a little below the spheres.
/// assert!((length - 0.2).abs() < 0.01, "{length}");
/// # Ok::<(), icoray_grid::Error>(())
/// ```
#[derive(Debug)]
pub struct Traversal<'g> {
    grid: &'g Grid<'g>,
    shell: Shell<f64>,
}

/// A part of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stretch {
    /// A frustum between two layers.
    Frustum(Frustum),
    /// The space below the innermost layer, from distance `t` on; reported again for each triangle, data or void, under
    /// which the ray crosses it. It is a sphere under void triangles, and has the facets of the layer under others.
    Core {
        /// Distance from the ray's eye, planet radii.
        t: f64,
    },
}

/// A ray's stretch inside one frustum: a triangle of three cells between `layer` and `layer + 1`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    /// The triangle's cells; their order has no meaning.
    pub cells: [u32; 3],
    /// The lower layer, counted from the innermost.
    pub layer: usize,
    /// Distances from the ray's eye at which it enters and leaves, planet radii.
    pub t: [f64; 2],
    /// The point of entry and of exit as `Σ alpha[k]·V[k]` over the cells' unit vectors V. Linear in t between the
    /// two; the sum is the height ρ, which is the layer's radius on its facet, and `alpha/ρ` are barycentric on
    /// facets.
    pub alpha: [[f64; 3]; 2],
}

impl<'g> Traversal<'g> {
    /// `radius` are the layers' radii in planet radii, strictly rising.
    ///
    /// # Errors
    /// [`ErrorKind::Layers`] when there are fewer than two, or one is not positive, not finite or not above the last.
    pub fn new(grid: &'g Grid<'g>, radius: &[f64]) -> Result<Self> {
        let rises = radius.windows(2).all(|w| w[0] < w[1]);
        if radius.len() < 2 || !rises || radius[0] <= 0.0 || !radius[radius.len() - 1].is_finite() {
            let message = format!("{radius:?}: expected at least two positive radii that rise");
            return Err(Error::new(ErrorKind::Layers, message));
        }
        Ok(Traversal { grid, shell: Shell::new(radius) })
    }

    /// The outermost radius, planet radii.
    pub fn outer(&self) -> f64 {
        self.shell.outer()
    }

    /// Calls `visit` for each stretch of the ray from `eye` along the unit vector `dir`, in order, until it breaks. In
    /// holes of the mesh, only the core is reported.
    ///
    /// The first triangle is searched from `hint`, which may be any triangle; `hint` becomes that triangle.
    pub fn ray(&self, eye: DVec3, dir: DVec3, hint: &mut u32, visit: impl FnMut(&Stretch) -> ControlFlow<()>) {
        let Some(line) = RayLine::new(eye, dir, self.shell.outer()) else { return };
        let mut walk = Walk::new(self.grid, line, *hint);
        *hint = walk.triangle();
        let along = eye.dot(dir);
        let mut gap = None;
        let mut visit = visit;
        loop {
            let is_void = walk.is_void();
            let Some(column) = walk.next_column() else { return };
            if is_void {
                gap = None;
                let core = line.first_inside(self.shell.inner(), [column.entry.t, column.exit.t]);
                if core.is_some_and(|t| visit(&Stretch::Core { t: t - along }).is_break()) {
                    return;
                }
                continue;
            }
            let start = gap.unwrap_or_else(|| self.shell.gap(column.entry.rho));
            let mut teller = StretchVisitor { column: &column, along, visit: &mut visit };
            let (next, flow) = cross(&self.shell, &column, start, &mut teller);
            if flow == Flow::Stop {
                return;
            }
            gap = Some(next);
        }
    }
}

/// Reports the stretches of a column to a visitor.
struct StretchVisitor<'t, V> {
    column: &'t Column,
    along: f64,
    visit: &'t mut V,
}

impl<V: FnMut(&Stretch) -> ControlFlow<()>> StretchVisitor<'_, V> {
    fn distance(&self, at: &RayPoint<f64>) -> f64 {
        lerp(self.column.entry.t, self.column.exit.t, at.u) - self.along
    }

    fn alpha(&self, at: &RayPoint<f64>) -> [f64; 3] {
        let (entry, exit) = (&self.column.entry.weight, &self.column.exit.weight);
        let [b, c] = [0, 1].map_inline(|k| at.rho * lerp(entry[k], exit[k], at.tau));
        [at.rho - b - c, b, c]
    }

    fn tell(&mut self, stretch: &Stretch) -> Flow {
        if (self.visit)(stretch).is_break() { Flow::Stop } else { Flow::On }
    }
}

impl<V: FnMut(&Stretch) -> ControlFlow<()>> ColumnVisitor<f64, 0> for StretchVisitor<'_, V> {
    #[inline]
    fn chord(&self, _layer: usize) -> Chord<f64, 0> {
        Chord { entry: [], exit: [] }
    }

    #[inline]
    fn frustum(&mut self, layer: usize, ends: [&RayPoint<f64>; 2], _: [&Chord<f64, 0>; 2], _: f64) -> Flow {
        let (t, alpha) = (ends.map_inline(|s| self.distance(s)), ends.map_inline(|s| self.alpha(s)));
        self.tell(&Stretch::Frustum(Frustum { cells: self.column.cells, layer, t, alpha }))
    }

    fn core(&mut self, a: &RayPoint<f64>) -> Flow {
        let t = self.distance(a);
        self.tell(&Stretch::Core { t })
    }
}
