//! The triangles of a grid that belong to a rank.

use super::plane::RayLine;
use glam::DVec3;
use icoray_grid::Grid;
use icoray_grid::marks::Marks;

/// The triangles over whose columns a rank traces rays, and bounds of the position of these columns.
#[derive(Debug, Clone)]
pub struct OwnedRegion<'m> {
    triangles: Marks<'m>,
    /// Axis of the cap around the triangles, and the cosine of the angle to the farthest of their vertices.
    cap: Option<(DVec3, f64)>,
    lowest_facet: f64,
}

impl<'m> OwnedRegion<'m> {
    /// The region of the triangles that are marked, by number. Its lowest facet is that of the unit sphere until
    /// [`Self::lower_facet`] is called.
    pub fn new(grid: &Grid, triangles: Marks<'m>) -> Self {
        let cap = cap(grid, &triangles);
        OwnedRegion { triangles, cap, lowest_facet: 1.0 }
    }

    /// Marks of all triangles.
    pub fn triangles(&self) -> &Marks<'m> {
        &self.triangles
    }

    /// Whether a triangle is in the region; false for numbers out of range.
    #[inline]
    pub fn has(&self, triangle: u32) -> bool {
        self.triangles.has(triangle as usize)
    }

    /// Smallest distance from the centre of any rank's facets, if layers are a unit sphere.
    pub fn lowest_facet(&self) -> f64 {
        self.lowest_facet
    }

    /// Lowers the lowest facet to `height` if that is lower.
    pub fn lower_facet(&mut self, height: f64) {
        self.lowest_facet = self.lowest_facet.min(height);
    }

    /// Whether a line may cross columns of the region between the radii `inner` and `outer`.
    pub fn is_near(&self, line: &RayLine, inner: f64, outer: f64) -> bool {
        let (middle, reach) = self.ball(inner, outer);
        let (x, q) = (middle.dot(line.plane.x) - line.b, middle.dot(line.plane.q));
        x * x + q * q <= reach
    }

    /// A ball that contains the region's columns between the radii `inner` and `outer`: its centre, and the square of
    /// its radius, which is negative for an empty region.
    pub fn ball(&self, inner: f64, outer: f64) -> (DVec3, f64) {
        let Some((axis, cos)) = self.cap else { return (DVec3::ZERO, -1.0) };
        if cos <= 0.1 {
            return (DVec3::ZERO, f64::INFINITY);
        }
        // Columns extend down to the facets below the inner radius, at worst to the chord of the cap.
        let low = inner * cos;
        // A ball around the rim's disc at the outer radius contains the cap, and the rim of its bottom.
        let middle = outer * cos * axis;
        let reach = |r: f64| r * r - 2.0 * r * outer * cos * cos + outer * outer * cos * cos;
        (middle, reach(low).max(reach(outer)) * (1.0 + 1e-9))
    }
}

/// The cap around own triangles.
fn cap(grid: &Grid, triangles: &Marks) -> Option<(DVec3, f64)> {
    let own = || (0..grid.triangles() as u32).filter(|triangle| triangles.has(*triangle as usize));
    let vertices = || own().flat_map(|t| grid.triangle(t)).map(|cell| grid.direction(cell));
    let axis = vertices().sum::<DVec3>().try_normalize();
    let axis = axis.or_else(|| vertices().next())?;
    Some((axis, vertices().fold(1.0, |least: f64, v| least.min(v.dot(axis)))))
}
