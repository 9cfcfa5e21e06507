//! Cameras and exaggerations that a caller sets instead of a script's own.

use super::{Axis, Motion, Script};
use crate::camera::Camera;
use icoray_grid::{Error, ErrorKind, Result};

impl Script {
    /// Puts the camera of each view above a place, looking at the planet's centre with north up; what is `None` stays
    /// where the view has it. Nothing changes where all are `None`.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] for a view whose camera is given by a path or a sweep, and for numbers that no camera has.
    pub fn set_camera(&mut self, lon_deg: Option<f64>, lat_deg: Option<f64>, distance: Option<f64>) -> Result<()> {
        if [lon_deg, lat_deg, distance].iter().all(Option::is_none) {
            return Ok(());
        }
        for view in &mut self.views {
            let is_swept = view.sweep.axes.iter().any(Axis::is_of_camera);
            if is_swept || matches!(view.motion, Motion::Path(_)) {
                let key = if is_swept { "sweep" } else { "camera.path" };
                let context = format!(
                    "{key}{} places the camera: it cannot be placed otherwise, expected a scene with a fixed camera",
                    of_view(view.name.as_deref())
                );
                return Err(Error::new(ErrorKind::Scene, context));
            }
            let [lon, lat, far, fov] = view.scene.camera.place();
            let (lon, lat, far) = (lon_deg.unwrap_or(lon), lat_deg.unwrap_or(lat), distance.unwrap_or(far));
            view.scene.camera = Camera::above(lon, lat, far, fov).ok_or_else(|| {
                let context = format!(
                    "a camera above {lon}, {lat} at distance {far}, expected finite numbers and a distance above 0"
                );
                Error::new(ErrorKind::Scene, context)
            })?;
        }
        Ok(())
    }

    /// Sets the factor on heights of all views.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`] for a view that sweeps it.
    pub fn set_exaggeration(&mut self, exaggeration: f64) -> Result<()> {
        for view in &mut self.views {
            if view.sweep.has("exaggeration") {
                let of = of_view(view.name.as_deref());
                let context = format!("sweep{of} has exaggerations: expected a scene that does not sweep them");
                return Err(Error::new(ErrorKind::Scene, context));
            }
            view.scene.exaggeration = exaggeration;
        }
        Ok(())
    }
}

/// ` of view "name"`, where it has a name.
fn of_view(name: Option<&str>) -> String {
    name.map_or_else(String::new, |name| format!(" of view {name:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "field = \"q\"\nexaggeration = 2\n[camera]\nlon = 20\nlat = 35\ndistance = 3\nfov = 40\n\
                         [transfer]\nrange = [0, 1]\nopacity = [[0, 0.5]]\n";

    fn near(a: [f64; 4], b: [f64; 4]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    #[test]
    fn settings_without_an_option_stay() {
        let mut script = Script::parse(SCENE).unwrap();
        script.set_camera(None, None, None).unwrap();
        assert_eq!(script, Script::parse(SCENE).unwrap());
        script.set_camera(Some(-100.0), None, None).unwrap();
        assert!(near(script.views[0].scene.camera.place(), [-100.0, 35.0, 3.0, 40.0]));
        script.set_camera(None, Some(-90.0), Some(5.0)).unwrap();
        assert!(near(script.views[0].scene.camera.place(), [-100.0, -90.0, 5.0, 40.0]));
        script.set_exaggeration(7.0).unwrap();
        assert_eq!(script.views[0].scene.exaggeration, 7.0);
    }

    #[test]
    fn moving_and_swept_keys_are_not_set() {
        let text = format!("{SCENE}[sweep]\nlon = [0, 10]\nexaggeration = [1, 2]\n");
        let mut script = Script::parse(&text).unwrap();
        for error in [script.set_camera(Some(0.0), None, None), script.set_exaggeration(2.0)] {
            assert!(error.unwrap_err().context().starts_with("sweep"), "of the sweep");
        }
        let mut still = Script::parse(SCENE).unwrap();
        assert!(still.set_camera(None, None, Some(0.0)).unwrap_err().context().contains("at distance 0"));
    }
}
