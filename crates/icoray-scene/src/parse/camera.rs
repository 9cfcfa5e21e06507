//! The camera, by a place above which it is or by where it stands and looks.

use super::text::Text;
use crate::camera::Camera;
use icoray_grid::Result;
use serde::Deserialize;
use toml::Spanned;

/// Longitude and latitude below the camera, degrees, where they are not given.
pub(super) const PLACE_DEG: [f64; 2] = [0.0, 25.0];
/// Field of view where none is given, degrees.
pub(super) const FOV_DEG: f64 = 30.0;
/// Radius of what is seen from the default distance, planet radii: the planet and a shell.
const SEEN: f64 = 1.1;
/// Part of the picture's height that this fills.
const FILLED: f64 = 0.86;

/// The distance from the planet's centre, planet radii, from which all of it is seen.
pub(super) fn whole_planet(fov_deg: f64) -> f64 {
    SEEN / (0.5 * FILLED * fov_deg.to_radians()).sin()
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCamera {
    lon: Option<Spanned<f64>>,
    lat: Option<Spanned<f64>>,
    distance: Option<Spanned<f64>>,
    altitude: Option<Spanned<f64>>,
    eye: Option<Spanned<[f64; 3]>>,
    target: Option<Spanned<[f64; 3]>>,
    up: Option<Spanned<[f64; 3]>>,
    fov: Option<Spanned<f64>>,
}

pub(super) fn camera(source: &Text, raw: Option<&Spanned<RawCamera>>) -> Result<Camera> {
    let absent = RawCamera::default();
    let (span, raw) = raw.map_or((0..0, &absent), |raw| (raw.span(), raw.get_ref()));
    let fov = source.number(raw.fov.as_ref(), "camera.fov", 1e-3, 179.0, FOV_DEG)?;
    let camera = match &raw.eye {
        Some(eye) => from_eye(source, raw, *eye.get_ref(), fov)?,
        None => above(source, raw, fov)?,
    };
    camera.ok_or_else(|| {
        let what = "eye and target coincide, up points along the view, or a number is not finite";
        source.bad(span, "camera", what)
    })
}

fn from_eye(source: &Text, raw: &RawCamera, eye: [f64; 3], fov: f64) -> Result<Option<Camera>> {
    let strays = [&raw.lon, &raw.lat, &raw.distance, &raw.altitude];
    if let Some(stray) = strays.into_iter().flatten().next() {
        let what = "lon, lat, distance and altitude are valid only without eye";
        return Err(source.bad(stray.span(), "camera", what));
    }
    let target = raw.target.as_ref().map_or([0.0; 3], |t| *t.get_ref());
    let up = raw.up.as_ref().map_or([0.0, 0.0, 1.0], |u| *u.get_ref());
    Ok(Camera::look_at(eye, target, up, fov))
}

fn above(source: &Text, raw: &RawCamera, fov: f64) -> Result<Option<Camera>> {
    if let Some(stray) = raw.target.as_ref().or(raw.up.as_ref()) {
        return Err(source.bad(stray.span(), "camera", "target and up are valid only with eye"));
    }
    let [lon, lat] = PLACE_DEG;
    let lon = source.number(raw.lon.as_ref(), "camera.lon", -360.0, 360.0, lon)?;
    let lat = source.number(raw.lat.as_ref(), "camera.lat", -90.0, 90.0, lat)?;
    let distance = match (&raw.distance, &raw.altitude) {
        (Some(_), Some(altitude)) => {
            return Err(source.bad(altitude.span(), "camera", "expected either distance or altitude"));
        }
        (None, Some(a)) => 1.0 + source.number(Some(a), "camera.altitude", -0.999_999, 1e6, 0.0)?,
        (d, None) => source.number(d.as_ref(), "camera.distance", 1e-6, 1e6, whole_planet(fov))?,
    };
    Ok(Camera::above(lon, lat, distance, fov))
}
