//! Motion of a camera from step to step.

use super::Path;
use crate::camera::Camera;
use crate::name::Stamp;

/// Motion of a camera while a model runs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Motion {
    /// No motion.
    Still,
    /// Rotation about the planet's axis.
    Orbit(Orbit),
    /// A path through keys.
    Path(Path),
}

/// The quantity that a motion depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Clock {
    /// The step's number.
    Step,
    /// Seconds of the model.
    Time,
}

impl Clock {
    pub fn read(self, now: &Stamp) -> f64 {
        match self {
            Clock::Step => now.step as f64,
            Clock::Time => now.time_s,
        }
    }
}

/// A turn about the planet's axis, eastwards where positive; nothing has turned yet at step or time 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Orbit {
    pub clock: Clock,
    /// Degrees of rotation ...
    pub turn_deg: f64,
    /// ... in this number of steps or seconds.
    pub period: f64,
}

impl Motion {
    /// The camera at a step; `still` is the camera without motion.
    pub fn camera(&self, still: &Camera, now: &Stamp) -> Camera {
        match self {
            Motion::Still => *still,
            Motion::Orbit(Orbit { clock, turn_deg, period }) => {
                // Multiplied first, so that whole degrees stay whole.
                still.turned_east((clock.read(now) * turn_deg / period).rem_euclid(360.0))
            }
            Motion::Path(path) => path.camera(now),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn at(step: i64, time_s: f64) -> Stamp {
        Stamp { step, time_s, date: None }
    }

    fn apart(a: &Camera, b: &Camera) -> f64 {
        let vectors = |c: &Camera| {
            let (axes, half_height) = c.frame();
            let [f, r, u] = axes.map(DVec3::from_array);
            ([DVec3::from_array(c.eye()), f, r, u], half_height)
        };
        let ((a, half_a), (b, half_b)) = (vectors(a), vectors(b));
        a.iter().zip(b).map(|(a, b)| a.distance(b)).fold((half_a - half_b).abs(), f64::max)
    }

    #[test]
    fn an_orbit_goes_east_about_the_axis() {
        let still = Camera::above(20.0, 35.0, 3.0, 40.0).unwrap();
        let orbit = |clock, turn_deg, period| Motion::Orbit(Orbit { clock, turn_deg, period });
        for (motion, now, lon) in [
            (orbit(Clock::Step, 2.0, 1.0), at(0, 9e9), 20.0),
            (orbit(Clock::Step, 2.0, 1.0), at(45, 0.0), 110.0),
            (orbit(Clock::Step, 360.0, 180.0), at(180 * 1_000_003, 0.0), 20.0),
            (orbit(Clock::Step, 360.0, 7.0), at(7_000_000_001, 0.0), 20.0 + 360.0 / 7.0),
            (orbit(Clock::Step, -90.0, 3.0), at(1, 0.0), -10.0),
            (orbit(Clock::Time, 360.0, 86_400.0), at(5, 21_600.0), 110.0),
            (orbit(Clock::Step, 2.0, 1.0), at(-5, 0.0), 10.0),
        ] {
            let expected = Camera::above(lon, 35.0, 3.0, 40.0).unwrap();
            let deviation = apart(&motion.camera(&still, &now), &expected);
            assert!(deviation < 1e-6, "{motion:?} at {}: {deviation}", now.step);
        }
        // A camera that looks at a place on the ground rotates with it.
        let close = Camera::look_at([1.5, 0.0, 0.5], [1.0, 0.0, 0.2], [0.0, 0.0, 1.0], 30.0).unwrap();
        let turned = orbit(Clock::Step, 90.0, 1.0).camera(&close, &at(1, 0.0));
        let expected = Camera::look_at([0.0, 1.5, 0.5], [0.0, 1.0, 0.2], [0.0, 0.0, 1.0], 30.0).unwrap();
        assert!(apart(&turned, &expected) < 1e-12);
        assert_eq!(Motion::Still.camera(&close, &at(7, 7.0)), close);
    }
}
