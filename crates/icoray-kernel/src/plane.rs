//! The plane through a ray and the sphere's centre, and points of the mesh in its coordinates.
//!
//! In the plane the ray is the vertical line `(b, t)`, b its distance from the centre and t measured from its closest
//! point; its shadow on the sphere is a great circle, walked counter-clockwise from `(0, -1)` over `(1, 0)` to
//! `(0, 1)`. The walk needs only the side of a vertex V: the sign of V·q.

use glam::DVec3;

/// An orthonormal frame: the great circle runs from `x` towards `y`, with `q` on its left.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// Unit vector at which the great circle starts.
    pub x: DVec3,
    /// Unit vector a quarter turn on.
    pub y: DVec3,
    /// Unit normal of the plane.
    pub q: DVec3,
}

/// A vertex of the mesh seen in a plane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlaneVertex {
    pub cell: u32,
    pub x: f64,
    pub y: f64,
    pub q: f64,
}

/// A point of the plane.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// Component along the plane's `x`.
    pub x: f64,
    /// Component along the plane's `y`.
    pub y: f64,
}

impl Point {
    /// The point of these components.
    #[inline]
    pub fn new(x: f64, y: f64) -> Self {
        Point { x, y }
    }

    /// Positive if `other` lies counter-clockwise of `self`, by less than half a turn.
    #[inline]
    pub fn cross(self, other: Point) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// The scalar product.
    #[inline]
    pub fn dot(self, other: Point) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// The point at the fraction `w` of the way to `other`.
    #[inline]
    pub fn lerp(self, other: Point, w: f64) -> Point {
        Point::new(self.x + w * (other.x - self.x), self.y + w * (other.y - self.y))
    }
}

impl PlaneVertex {
    /// The side of the great circle on which the vertex lies. A vertex on the circle counts as left: the result depends
    /// on the vertex alone, so each triangle has two or no sides that the circle crosses, for any rounding.
    #[inline]
    pub fn is_left(&self) -> bool {
        self.q >= 0.0
    }
}

impl Plane {
    /// The plane of the great circle from `from` towards `to` (unit vectors, neither equal nor opposite).
    #[inline]
    pub fn through(from: DVec3, to: DVec3) -> Option<Self> {
        let q = from.cross(to).try_normalize()?;
        Some(Plane { x: from, y: q.cross(from).normalize(), q })
    }

    /// A vertex of the mesh seen in the plane.
    #[inline]
    pub(crate) fn project(&self, cell: u32, direction: DVec3) -> PlaneVertex {
        PlaneVertex { cell, x: direction.dot(self.x), y: direction.dot(self.y), q: direction.dot(self.q) }
    }

    /// The projection of a vector onto the plane.
    #[inline]
    pub fn point(&self, direction: DVec3) -> Point {
        Point::new(direction.dot(self.x), direction.dot(self.y))
    }
}

/// A length that is negligible on any planet and whose square does not underflow.
const TINY: f64 = 1e-100;

/// The least distance from the centre of a line that passes it, planet radii: more than the rounding of directions. With
/// less, a vertex below the eye could be taken for one beyond the opposite end.
const LEAST_B: f64 = 1e-14;

/// A ray clipped to the sphere around the outermost layer, in its plane.
#[derive(Debug, Clone, Copy)]
pub struct RayLine {
    /// The plane through the line and the sphere's centre.
    pub plane: Plane,
    /// Distance of the line from the sphere's centre.
    pub b: f64,
    /// Distance at which the line enters the sphere, or of the eye if that lies inside; from the closest point.
    pub start: f64,
    /// Distance at which the line leaves the sphere.
    pub end: f64,
}

impl RayLine {
    /// The part of the ray from `eye` along the unit vector `dir` inside the sphere of radius `outer`, if any.
    ///
    /// A line through the centre has no plane of its own; any plane through it gives the same values. The line is moved
    /// aside by 1e-14 planet radii.
    #[inline]
    pub fn new(eye: DVec3, dir: DVec3, outer: f64) -> Option<Self> {
        let along = eye.dot(dir);
        let closest = eye - along * dir;
        let b = closest.length();
        let half = (outer - b) * (outer + b);
        if half <= 0.0 {
            return None;
        }
        let end = half.sqrt();
        let start = along.max(-end);
        // At the very centre the start has no direction; moving it slightly along the ray gives it the ray's.
        let start = if b.max(start.abs()) < TINY { TINY } else { start };
        if start >= end {
            return None;
        }
        // Close to the centre `closest` is rounding and may point along the ray: straightened twice, it cannot.
        let upright = |x: DVec3| (x - x.dot(dir) * dir).try_normalize();
        let x = (b > 0.0).then(|| upright(closest / b)).flatten().and_then(upright);
        let x = x.unwrap_or_else(|| dir.any_orthonormal_vector());
        let b = if start < 0.0 { b.max(LEAST_B) } else { b };
        Some(RayLine { plane: Plane { x, y: dir, q: x.cross(dir) }, b, start, end })
    }

    /// The point of the line at distance `t` from its closest point, in the plane.
    #[inline]
    pub fn at(&self, t: f64) -> Point {
        Point::new(self.b, t)
    }

    /// The distance between `from` and `to` at which the line is first inside the sphere of `radius`, if it is.
    ///
    /// A part without length has no place inside.
    #[inline]
    pub fn first_inside(&self, radius: f64, [from, to]: [f64; 2]) -> Option<f64> {
        let half = (radius - self.b) * (radius + self.b);
        let half = (half > 0.0).then(|| half.sqrt())?;
        let first = from.max(-half);
        (first < to.min(half)).then_some(first)
    }

    /// The point of [`Self::at`] in space.
    #[inline]
    pub fn position(&self, t: f64) -> DVec3 {
        self.b * self.plane.x + t * self.plane.y
    }
}
