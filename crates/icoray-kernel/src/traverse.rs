//! The frusta along a ray, for callers that integrate other quantities along it.

use crate::column::Flow;
use crate::general::{ColumnVisitor, Facet, FacetSide, Levels, Wedge, cross};
use crate::plane::RayLine;
use crate::walk::Walk;
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::array::MapInline;
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
    levels: Levels<'g>,
    /// Radii of the innermost and the outermost layer.
    radius: [f64; 2],
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
        Ok(Traversal { grid, levels: Levels::concentric(radius), radius: [radius[0], radius[radius.len() - 1]] })
    }

    /// The outermost radius, planet radii.
    pub fn outer(&self) -> f64 {
        self.radius[1]
    }

    /// Calls `visit` for each stretch of the ray from `eye` along the unit vector `dir`, in order, until it breaks. In
    /// holes of the mesh, only the core is reported.
    ///
    /// The first triangle is searched from `hint`, which may be any triangle; `hint` becomes that triangle.
    pub fn ray(&self, eye: DVec3, dir: DVec3, hint: &mut u32, visit: impl FnMut(&Stretch) -> ControlFlow<()>) {
        let [inner, outer] = self.radius;
        let Some(line) = RayLine::new(eye, dir, outer) else { return };
        let mut walk = Walk::new(self.grid, line, *hint);
        *hint = walk.triangle();
        let mut visitor = StretchVisitor { along: eye.dot(dir), visit };
        let mut gap = 0;
        loop {
            let (is_void, triangle) = (walk.is_void(), walk.triangle());
            let Some(column) = walk.next_column() else { return };
            let flow = if is_void {
                let core = line.first_inside(inner, [column.entry.t, column.exit.t]);
                core.map_or(Flow::On, |t| visitor.core_at(t))
            } else {
                let (next, flow) = cross(&Wedge::new(&column, triangle), &self.levels, gap, &mut visitor);
                gap = next;
                flow
            };
            if flow == Flow::Stop {
                return;
            }
        }
    }
}

/// Reports the stretches of a ray to a visitor.
struct StretchVisitor<V> {
    along: f64,
    visit: V,
}

impl<V: FnMut(&Stretch) -> ControlFlow<()>> StretchVisitor<V> {
    fn report(&mut self, stretch: &Stretch) -> Flow {
        if (self.visit)(stretch).is_break() { Flow::Stop } else { Flow::On }
    }

    fn core_at(&mut self, t: f64) -> Flow {
        self.report(&Stretch::Core { t: t - self.along })
    }
}

impl<V: FnMut(&Stretch) -> ControlFlow<()>> ColumnVisitor for StretchVisitor<V> {
    #[inline]
    fn gap(&mut self, wedge: &Wedge, [lower, _]: [&Facet; 2], ends: [(f64, FacetSide); 2]) -> Flow {
        let (t, alpha) =
            (ends.map_inline(|(u, _)| wedge.distance(u) - self.along), ends.map_inline(|(u, _)| wedge.alpha(u)));
        self.report(&Stretch::Frustum(Frustum { cells: wedge.cells, layer: lower.layer, t, alpha }))
    }

    fn core(&mut self, wedge: &Wedge, _lowest: &Facet, u: f64) -> Flow {
        self.core_at(wedge.distance(u))
    }
}
