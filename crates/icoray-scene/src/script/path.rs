//! Camera paths through keys: smooth, passing through each key, at rest at both ends.
//!
//! Between keys the direction from the planet's centre follows a cubic Bézier curve on the sphere, by de Casteljau's
//! construction with great arcs in place of straight lines (Shoemake 1985, *Animating rotation with quaternion
//! curves*). Each key's velocity is the mean of those of the arcs beside it, weighted as a parabola through three
//! points has it, at most twice the slower one's, so that a long rest does not make it swing out; it is 0 at the ends.
//! Distance and field of view follow monotone cubics, which pass no key's value between two keys.

use super::motion::Clock;
use crate::camera::Camera;
use crate::name::Stamp;
use glam::DVec3;

/// The camera at some step or time: above a place, looking at the planet's centre, north up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PathKey {
    /// Step or seconds.
    pub at: f64,
    pub lon_deg: f64,
    pub lat_deg: f64,
    /// Distance from the planet's centre, in planet radii.
    pub distance: f64,
    pub fov_deg: f64,
}

/// Keys in order of time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Path {
    clock: Clock,
    keys: Vec<PathKey>,
    directions: Vec<DVec3>,
    /// Velocities of directions, tangent to the sphere, per step or second.
    velocities: Vec<DVec3>,
    /// Slopes of the distance's logarithm and of the field of view.
    slopes: [Vec<f64>; 2],
}

/// The tangent at `from` that leads to `to` along a great arc, as long as the arc.
fn arc(from: DVec3, to: DVec3) -> DVec3 {
    let across = to - from * from.dot(to);
    across.normalize_or_zero() * from.cross(to).length().atan2(from.dot(to))
}

/// The point to which the tangent `along` leads from `from`.
fn end_of(from: DVec3, along: DVec3) -> DVec3 {
    let angle = along.length();
    (from * angle.cos() + along.normalize_or_zero() * angle.sin()).normalize()
}

fn between(from: DVec3, to: DVec3, part: f64) -> DVec3 {
    end_of(from, part * arc(from, to))
}

/// Slopes of a monotone cubic at its keys, 0 at both ends: harmonic means of the secants beside, 0 where they turn
/// (Fritsch and Butland 1984).
fn slopes(at: &[f64], values: &[f64]) -> Vec<f64> {
    let mut slopes = vec![0.0; values.len()];
    for i in 1..values.len() - 1 {
        let [before, after] = [at[i] - at[i - 1], at[i + 1] - at[i]];
        let [left, right] = [(values[i] - values[i - 1]) / before, (values[i + 1] - values[i]) / after];
        if left * right > 0.0 {
            let [a, b] = [before + 2.0 * after, 2.0 * before + after];
            slopes[i] = (a + b) / (a / right + b / left);
        }
    }
    slopes
}

/// A cubic from its values and slopes at the ends of a stretch of length `width`, at a part of it.
fn hermite(values: [f64; 2], slopes: [f64; 2], width: f64, part: f64) -> f64 {
    let rest = 1.0 - part;
    let ends = values[0] * (1.0 + 2.0 * part) * rest * rest + values[1] * (3.0 - 2.0 * part) * part * part;
    ends + width * part * rest * (slopes[0] * rest - slopes[1] * part)
}

/// Why keys make no path.
#[derive(Debug)]
pub(crate) struct PathError {
    /// The number of the key.
    pub key: usize,
    pub message: String,
}

impl Path {
    /// The path along keys, if they make one.
    pub fn new(clock: Clock, keys: Vec<PathKey>) -> Result<Self, PathError> {
        let error = |key: usize, message: String| Err(PathError { key, message });
        if keys.len() < 2 {
            return error(0, format!("{} keys, expected at least 2", keys.len()));
        }
        for (i, pair) in keys.windows(2).enumerate() {
            if pair[0].at >= pair[1].at {
                return error(i + 1, format!("{} after {}, expected keys in order", pair[1].at, pair[0].at));
            }
            let [from, to] = [pair[0].direction(), pair[1].direction()];
            if from.dot(to) < -1.0 + 1e-9 {
                let message = "opposite to the key before, so that no way is the shortest; expected a key between";
                return error(i + 1, message.into());
            }
        }
        let at: Vec<f64> = keys.iter().map(|key| key.at).collect();
        let directions: Vec<DVec3> = keys.iter().map(PathKey::direction).collect();
        let mut velocities = vec![DVec3::ZERO; keys.len()];
        for i in 1..keys.len() - 1 {
            let [before, after] = [at[i] - at[i - 1], at[i + 1] - at[i]];
            let came = -arc(directions[i], directions[i - 1]) / before;
            let goes = arc(directions[i], directions[i + 1]) / after;
            let mean = (after * came + before * goes) / (before + after);
            velocities[i] = mean.clamp_length_max(2.0 * came.length().min(goes.length()));
        }
        let slopes_of = |value: fn(&PathKey) -> f64| slopes(&at, &keys.iter().map(value).collect::<Vec<f64>>());
        let slopes = [slopes_of(|key| key.distance.ln()), slopes_of(|key| key.fov_deg)];
        Ok(Path { clock, keys, directions, velocities, slopes })
    }

    /// The camera at a step; that of the first or last key before or after it.
    pub fn camera(&self, now: &Stamp) -> Camera {
        self.key(self.clock.read(now)).camera()
    }

    fn key(&self, at: f64) -> PathKey {
        let next = self.keys.partition_point(|key| key.at <= at);
        let i = next.saturating_sub(1);
        let from = self.keys[i];
        if next == 0 || next == self.keys.len() || from.at == at {
            return from;
        }
        let to = self.keys[next];
        let width = to.at - from.at;
        let part = (at - from.at) / width;
        let blend = |values, slopes: &[f64]| hermite(values, [slopes[i], slopes[next]], width, part);
        let direction = self.direction(i, width, part);
        PathKey {
            at,
            lon_deg: direction.y.atan2(direction.x).to_degrees(),
            lat_deg: direction.z.clamp(-1.0, 1.0).asin().to_degrees(),
            distance: blend([from.distance.ln(), to.distance.ln()], &self.slopes[0]).exp(),
            fov_deg: blend([from.fov_deg, to.fov_deg], &self.slopes[1]),
        }
    }

    fn direction(&self, i: usize, width: f64, part: f64) -> DVec3 {
        let [from, to] = [self.directions[i], self.directions[i + 1]];
        let third = width / 3.0;
        let leaves = end_of(from, third * self.velocities[i]);
        let arrives = end_of(to, -third * self.velocities[i + 1]);
        let [a, b, c] = [(from, leaves), (leaves, arrives), (arrives, to)].map(|(a, b)| between(a, b, part));
        between(between(a, b, part), between(b, c, part), part)
    }
}

impl PathKey {
    fn direction(&self) -> DVec3 {
        icoray_grid::grid::unit_vector(self.lon_deg.to_radians(), self.lat_deg.to_radians())
    }

    fn camera(&self) -> Camera {
        let camera = Camera::above(self.lon_deg, self.lat_deg, self.distance, self.fov_deg);
        camera.expect("a key's numbers are finite and in range")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(at: f64, lon_deg: f64, lat_deg: f64, distance: f64, fov_deg: f64) -> PathKey {
        PathKey { at, lon_deg, lat_deg, distance, fov_deg }
    }

    fn path(keys: &[PathKey]) -> Path {
        Path::new(Clock::Time, keys.into()).unwrap()
    }

    fn winding() -> Path {
        path(&[
            key(0.0, 170.0, 10.0, 4.0, 30.0),
            key(10.0, -150.0, 50.0, 1.5, 30.0),
            key(12.0, -100.0, 60.0, 1.4, 45.0),
            key(40.0, -90.0, -30.0, 6.0, 20.0),
        ])
    }

    #[test]
    fn it_passes_each_key_and_rests_beyond_the_ends() {
        let path = winding();
        for key in path.keys.clone() {
            assert_eq!(path.key(key.at), key);
            // Just beside it too: nothing jumps.
            for at in [key.at - 1e-9, key.at + 1e-9] {
                let beside = path.key(at);
                assert!(beside.direction().distance(key.direction()) < 1e-8);
                assert!((beside.distance - key.distance).abs() + (beside.fov_deg - key.fov_deg).abs() < 1e-6);
            }
        }
        assert_eq!(path.key(-1e9), path.keys[0]);
        assert_eq!(path.key(1e9), path.keys[3]);
        let stamp = Stamp { step: 3, time_s: 10.0, date: None };
        assert_eq!(path.camera(&stamp), Camera::above(-150.0, 50.0, 1.5, 30.0).unwrap());
        let by_step = Path { clock: Clock::Step, ..path };
        assert_eq!(by_step.camera(&stamp), by_step.key(3.0).camera());
    }

    /// Differences of velocities over steps that shrink, at keys and elsewhere.
    #[test]
    fn its_velocity_is_continuous_and_0_at_the_ends() {
        let path = winding();
        let h = 1e-5;
        let place = |at: f64| path.key(at).direction() * path.key(at).distance;
        let velocity = |at: f64| (place(at + h) - place(at - h)) / (2.0 * h);
        let jump = |at: f64| velocity(at + 2.0 * h).distance(velocity(at - 2.0 * h));
        for at in [0.0, 5.0, 10.0, 12.0, 30.0, 40.0] {
            assert!(jump(at) < 1e-3, "{at}: {}", jump(at));
        }
        for end in [0.0, 40.0] {
            assert!(velocity(end).length() < 1e-4);
        }
        // It does not stop in between, as arcs that are eased one by one do.
        for at in [10.0, 12.0] {
            assert!(velocity(at).length() > 0.05, "{at}: {}", velocity(at).length());
        }
    }

    #[test]
    fn two_keys_are_joined_by_the_great_arc_and_values_stay_between_them() {
        let middle = path(&[key(0.0, 10.0, 0.0, 2.0, 30.0), key(8.0, 100.0, 0.0, 8.0, 30.0)]).key(4.0);
        assert!((middle.lon_deg - 55.0).abs() < 1e-9 && middle.lat_deg.abs() < 1e-9);
        assert!((middle.distance - 4.0).abs() < 1e-9, "halfway between 2 and 8 by factors");
        let winding = winding();
        for i in 0..=400 {
            let key = winding.key(f64::from(i) / 10.0);
            assert!((1.4 - 1e-12..=6.0 + 1e-12).contains(&key.distance), "{key:?}");
            assert!((20.0 - 1e-9..=45.0 + 1e-9).contains(&key.fov_deg), "{key:?}");
            assert!((winding.key(key.at).direction().length() - 1.0).abs() < 1e-12);
        }
        // A quick move, then a slow one: it goes on, and does not swing out.
        let slow =
            path(&[key(0.0, 0.0, 0.0, 3.0, 30.0), key(0.1, 60.0, 0.0, 3.0, 30.0), key(99.0, 65.0, 0.0, 3.0, 30.0)]);
        let lons: Vec<f64> = (0..=990).map(|i| slow.key(f64::from(i) / 10.0).lon_deg).collect();
        assert!(lons.is_sorted() && lons[990] == 65.0, "{lons:?}");
        // Keys of equal values stay at these.
        let rests = path(&[key(0.0, 5.0, 5.0, 3.0, 40.0), key(1.0, 5.0, 5.0, 3.0, 40.0)]);
        let at = rests.key(0.3);
        let moved = at.direction().distance(rests.keys[0].direction());
        assert!(moved < 1e-15 && (at.distance - 3.0).abs() < 1e-14, "{moved} {at:?}");
    }

    #[test]
    fn keys_that_make_no_path_are_refused() {
        let one = key(0.0, 0.0, 0.0, 3.0, 30.0);
        for (keys, number, part) in [
            (vec![one], 0, "1 keys, expected at least 2"),
            (vec![one, key(0.0, 1.0, 0.0, 3.0, 30.0)], 1, "0 after 0, expected keys in order"),
            (vec![one, key(1.0, 180.0, 0.0, 3.0, 30.0)], 1, "opposite to the key before"),
        ] {
            let error = Path::new(Clock::Step, keys).unwrap_err();
            assert!(error.key == number && error.message.contains(part), "{error:?}");
        }
    }
}
