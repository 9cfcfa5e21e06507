//! The linear map from directions around a place on a surface to pixels.
//!
//! A direction from the planet's centre is given by its gnomonic coordinates around the place: its intersection with
//! the plane that touches the unit sphere there, east and north. Great circles are straight in them, and near the place
//! a linear map takes them to pixels, for any orientation of the surface. That map is used for the whole surroundings:
//! it is correct to first order within a line's width of the place, which is all that lines need.

use glam::{DVec2, DVec3};
use icoray_scene::{Camera, Scene};

/// The camera, with the height of its picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View {
    camera: Camera,
    height: u32,
}

/// A visible point of a surface.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceHit {
    /// Its position from the planet's centre, planet radii.
    pub position: DVec3,
    /// Normal of the surface, outwards or inwards, of any length.
    pub normal: DVec3,
}

/// A hit and the linear map around it.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScreenJacobian {
    up: DVec3,
    east: DVec3,
    north: DVec3,
    /// Longitude and latitude, radians.
    pub place: [f64; 2],
    /// Pixels per radian eastwards and northwards.
    moves: [DVec2; 2],
    det: f64,
}

impl View {
    /// A camera that takes pictures of `height` rows.
    pub fn new(camera: Camera, height: u32) -> Self {
        View { camera, height }
    }

    pub fn of(scene: &Scene) -> Self {
        View::new(scene.camera, scene.height)
    }

    /// Width of a pixel where the planet is nearest to the camera, planet radii.
    pub fn least_pixel(&self) -> f64 {
        self.camera.pixel_width(self.height) * (DVec3::from(self.camera.eye()).length() - 1.0).max(0.0)
    }
}

impl SurfaceHit {
    /// A point of a sphere around the planet's centre.
    #[inline]
    pub fn round(position: DVec3) -> Self {
        SurfaceHit { position, normal: position }
    }
}

impl ScreenJacobian {
    /// The map around `hit`; `None` if it is not in front of the eye, or if the surface is seen edge-on or vertical to
    /// the last digit.
    pub fn new(eye: &View, hit: &SurfaceHit) -> Option<Self> {
        let radius = hit.position.length();
        let up = hit.position.try_normalize()?;
        let normal = hit.normal.try_normalize()?;
        let slope = normal.dot(up);
        // At a pole any meridian serves; this takes longitude 0.
        let (lon, lat) = (up.y.atan2(up.x), up.z.atan2(up.x.hypot(up.y)));
        let east = DVec3::new(-lon.sin(), lon.cos(), 0.0);
        let north = up.cross(east);
        // On the surface, a step sideways also leads up or down the slope.
        let step = |aside: DVec3| radius * (aside - up * (normal.dot(aside) / slope));
        let moves = eye.camera.moves(hit.position, [step(east), step(north)], eye.height)?;
        let det = moves[0].perp_dot(moves[1]);
        (det != 0.0 && det.is_finite()).then_some(ScreenJacobian { up, east, north, place: [lon, lat], moves, det })
    }

    pub fn lon_deg(&self) -> f64 {
        self.place[0].to_degrees()
    }

    pub fn lat_deg(&self) -> f64 {
        self.place[1].to_degrees()
    }

    /// Pixels per radian from one parallel to another.
    pub fn stretch_of_latitude(&self) -> f64 {
        self.det.abs() / self.moves[0].length()
    }

    /// Pixels per radian of distance from one meridian to another.
    pub fn stretch_across_meridians(&self) -> f64 {
        self.det.abs() / self.moves[1].length()
    }

    /// Pixels per radian in the direction of the strongest foreshortening.
    pub fn min_stretch(&self) -> f64 {
        let half = 0.5 * (self.moves[0].length_squared() + self.moves[1].length_squared());
        let most = (half + (half * half - self.det * self.det).max(0.0).sqrt()).sqrt();
        self.det.abs() / most
    }

    /// Position of a direction, in pixels from the place.
    pub fn pixels(&self, direction: DVec3) -> DVec2 {
        let over = 1.0 / direction.dot(self.up);
        direction.dot(self.east) * over * self.moves[0] + direction.dot(self.north) * over * self.moves[1]
    }

    /// Pixels to the arc of the great circle between two directions; infinite if it lies beyond the horizon of the
    /// plane.
    pub fn distance(&self, from: DVec3, to: DVec3) -> f64 {
        /// Cosine of the largest angle from the place of directions that are used.
        const FARTHEST: f64 = 0.05;
        let heights = [from, to].map(|direction| direction.dot(self.up) - FARTHEST);
        let cut = from.lerp(to, heights[0] / (heights[0] - heights[1]));
        let [from, to] = match heights.map(|height| height > 0.0) {
            [true, true] => [from, to],
            [true, false] => [from, cut],
            [false, true] => [cut, to],
            [false, false] => return f64::INFINITY,
        };
        distance(self.pixels(from), self.pixels(to))
    }
}

/// Distance from the origin to the nearest point between `from` and `to`.
pub(super) fn distance(from: DVec2, to: DVec2) -> f64 {
    let along = to - from;
    let part = -from.dot(along) / along.length_squared();
    // Without a length both ends are equally near: a part that is NaN is one of them.
    (from + along * if part > 0.0 { part.min(1.0) } else { 0.0 }).length()
}
