//! A pinhole camera.

use glam::{DQuat, DVec2, DVec3};

/// A perspective camera; lengths in planet radii, z through the north pole, x through longitude 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    half_height: f64,
    /// The arguments of [`Camera::above`] for this eye.
    place: [f64; 4],
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with `up` upwards in the picture and a full vertical field of view of
    /// `fov_deg` degrees. `None` when eye and target coincide, `up` points along the view, or a number is not finite.
    pub fn look_at(eye: [f64; 3], target: [f64; 3], up: [f64; 3], fov_deg: f64) -> Option<Self> {
        let [eye, target, up] = [eye, target, up].map(DVec3::from_array);
        let forward = (target - eye).try_normalize()?;
        let right = forward.cross(up.try_normalize()?);
        // Nearly parallel vectors would leave the roll to rounding.
        let right = (right.length() > 1e-9).then(|| right.normalize())?;
        let half_height = (0.5 * fov_deg.to_radians()).tan();
        let fine = eye.is_finite() && right.is_finite() && half_height.is_finite() && half_height > 0.0;
        let (lon, distance) = (eye.y.atan2(eye.x), eye.length());
        let lat = if distance > 0.0 { (eye.z / distance).clamp(-1.0, 1.0).asin() } else { 0.0 };
        let place = [lon.to_degrees(), lat.to_degrees(), distance, fov_deg];
        fine.then(|| Camera { eye, forward, right, up: right.cross(forward), half_height, place })
    }

    /// A camera above a place at `distance` from the planet's centre that looks at the centre, north up.
    pub fn above(lon_deg: f64, lat_deg: f64, distance: f64, fov_deg: f64) -> Option<Self> {
        let (lon, lat) = (lon_deg.to_radians(), lat_deg.to_radians());
        let outward = icoray_grid::grid::unit_vector(lon, lat);
        // The tangent towards north exists at the poles too: there it is the meridian of `lon`.
        let north = DVec3::new(-lat.sin() * lon.cos(), -lat.sin() * lon.sin(), lat.cos());
        let camera = Self::look_at((outward * distance).to_array(), [0.0; 3], north.to_array(), fov_deg)?;
        Some(Camera { place: [lon_deg, lat_deg, distance, fov_deg], ..camera })
    }

    /// Longitude and latitude below the camera in degrees, its distance from the planet's centre, and its field of view
    /// in degrees: what [`Camera::above`] takes, or took.
    pub fn place(&self) -> [f64; 4] {
        self.place
    }

    /// The same camera, turned eastwards about the planet's axis.
    pub(crate) fn turned_east(&self, deg: f64) -> Self {
        let turn = DQuat::from_rotation_z(deg.to_radians());
        let [eye, forward, right, up] = [self.eye, self.forward, self.right, self.up].map(|v| turn * v);
        let [lon, lat, distance, fov] = self.place;
        Camera { eye, forward, right, up, place: [lon + deg, lat, distance, fov], ..*self }
    }

    /// Where the camera is.
    pub fn eye(&self) -> [f64; 3] {
        self.eye.to_array()
    }

    /// Unit vectors forwards, to the right and upwards, and half the picture's height at distance 1.
    pub fn frame(&self) -> ([[f64; 3]; 3], f64) {
        ([self.forward, self.right, self.up].map(|axis| axis.to_array()), self.half_height)
    }

    /// Inward unit normals of the four planes through the eye that enclose a picture of `width` × `height` square
    /// pixels: its left and right, lower and upper sides.
    pub fn sides(&self, width: u32, height: u32) -> [DVec3; 4] {
        let half_width = self.half_height * f64::from(width) / f64::from(height);
        let side = |inwards: DVec3, half: f64| (half * self.forward + inwards).normalize();
        [
            side(self.right, half_width),
            side(-self.right, half_width),
            side(self.up, self.half_height),
            side(-self.up, self.half_height),
        ]
    }

    /// Unit vector through the middle of pixel (`x`, `y`), counted from the upper left, of a picture of
    /// `width` × `height` square pixels.
    pub fn direction(&self, x: u32, y: u32, width: u32, height: u32) -> [f64; 3] {
        self.direction_at([x, y].map(|at| f64::from(at) + 0.5), width, height)
    }

    /// [`Self::direction`] through the place so many pixels to the right and downwards from the picture's upper left
    /// corner.
    pub fn direction_at(&self, [x, y]: [f64; 2], width: u32, height: u32) -> [f64; 3] {
        let scale = self.pixel_width(height);
        let across = (x - 0.5 * f64::from(width)) * scale;
        let upwards = (0.5 * f64::from(height) - y) * scale;
        (self.forward + across * self.right + upwards * self.up).normalize().to_array()
    }

    /// Width of a pixel of a picture of `height` rows at distance 1 in the middle of the picture, where it is widest.
    pub fn pixel_width(&self, height: u32) -> f64 {
        2.0 * self.half_height / f64::from(height)
    }

    /// How a picture of `height` rows shows small steps from `point` on: pixels to the right and upwards per length.
    /// `None` where the point is not in front of the camera.
    pub fn moves<const N: usize>(&self, point: DVec3, steps: [DVec3; N], height: u32) -> Option<[DVec2; N]> {
        let seen = |v: DVec3| (DVec2::new(v.dot(self.right), v.dot(self.up)), v.dot(self.forward));
        let (place, depth) = seen(point - self.eye);
        // Pixels per length at the point's depth.
        let scale = 0.5 * f64::from(height) / (self.half_height * depth);
        let shown = |step: DVec3| {
            let (aside, farther) = seen(step);
            scale * (aside - place * (farther / depth))
        };
        (depth > 0.0).then(|| steps.map(shown))
    }

    /// Eye and view direction in words, for a picture's text.
    pub fn describe(&self) -> String {
        format!("eye {:?}, forward {:?}, up {:?}", self.eye(), self.forward.to_array(), self.up.to_array())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn north_is_up_and_east_is_right() {
        let camera = Camera::above(0.0, 0.0, 3.0, 40.0).unwrap();
        assert_eq!(camera.eye(), [3.0, 0.0, 0.0]);
        let at = |x, y| DVec3::from_array(camera.direction(x, y, 100, 100));
        assert!(at(50, 10).z > 0.1, "up is north");
        assert!(at(90, 50).y > 0.1, "right is east");
        assert!((at(49, 49) + at(50, 50)).normalize().distance(DVec3::NEG_X) < 1e-12);
        // The upper edge of the picture is at half the field of view.
        let edge = DVec3::from_array(camera.direction(0, 0, 1, 1_000_000));
        assert!((edge.z.asin().to_degrees() - 20.0).abs() < 1e-3);
    }

    #[test]
    fn a_camera_over_a_pole_has_its_meridian_upwards() {
        for (lon, lat) in [(0.0, 90.0), (77.0, -90.0), (180.0, 90.0)] {
            Camera::above(lon, lat, 2.0, 30.0).unwrap();
        }
        assert!(Camera::look_at([0.0; 3], [0.0; 3], [0.0, 0.0, 1.0], 30.0).is_none());
        assert!(Camera::look_at([0.0, 0.0, 2.0], [0.0; 3], [0.0, 0.0, 1.0], 30.0).is_none());
    }
}
