//! The camera, by a place above which it is or by where it stands and looks.

use super::text::Text;
use crate::camera::Camera;
use crate::keys::{Key, Kind, keys, number, of};
use icoray_grid::Result;
use toml::Spanned;

/// Radius of what is seen from the default distance, planet radii: the planet and a shell.
const SEEN: f64 = 1.1;
/// Part of the picture's height that this fills.
const FILLED: f64 = 0.86;

/// The distance from the planet's centre, planet radii, from which all of it is seen.
pub(super) fn whole_planet(fov_deg: f64) -> f64 {
    SEEN / (0.5 * FILLED * fov_deg.to_radians()).sin()
}

keys! {
    pub(super) struct RawCamera {
        /// Longitude below the camera, degrees east.
        lon: Option<Spanned<f64>> = number(-360.0..=360.0).or(0.0),
        /// Latitude below the camera, degrees north.
        lat: Option<Spanned<f64>> = number(-90.0..=90.0).or(25.0),
        /// Distance from the planet's centre, planet radii. The default shows the whole planet with a shell of a tenth
        /// of its radius: 4.93 for `fov = 30`.
        distance: Option<Spanned<f64>> = number(1e-6..=1e6).or_else("1.1 / sin(0.43 `fov`)"),
        /// Distance from the surface, planet radii: `distance` less 1.
        altitude: Option<Spanned<f64>> = number(-0.999_999..=1e6),
        /// Position of the camera, planet radii.
        eye: Option<Spanned<[f64; 3]>> = POSITION.note("finite"),
        /// The point at which the camera looks.
        target: Option<Spanned<[f64; 3]>> = POSITION.or_toml("[0, 0, 0]").note("not `eye`"),
        /// The direction that is up in the picture.
        up: Option<Spanned<[f64; 3]>> = POSITION.or_toml("[0, 0, 1]").note("not along the view"),
        /// Full vertical field of view, degrees.
        fov: Option<Spanned<f64>> = number(1e-3..=179.0).or(30.0),
    }
}

const POSITION: Key = of(Kind::Vector(&["x", "y", "z"]));

pub(super) fn camera(source: &Text, raw: Option<&Spanned<RawCamera>>) -> Result<Camera> {
    let source = &source.within("camera");
    let absent = RawCamera::default();
    let (span, raw) = raw.map_or((0..0, &absent), |raw| (raw.span(), raw.get_ref()));
    let fov = source.number(raw.fov.as_ref(), "fov")?;
    let camera = match &raw.eye {
        Some(eye) => from_eye(source, raw, *eye.get_ref(), fov)?,
        None => above(source, raw, fov)?,
    };
    camera.ok_or_else(|| {
        let what = "eye and target coincide, up points along the view, or a number is not finite";
        source.bad(span, "", what)
    })
}

fn from_eye(source: &Text, raw: &RawCamera, eye: [f64; 3], fov: f64) -> Result<Option<Camera>> {
    let strays = [&raw.lon, &raw.lat, &raw.distance, &raw.altitude];
    if let Some(stray) = strays.into_iter().flatten().next() {
        let what = "lon, lat, distance and altitude are valid only without eye";
        return Err(source.bad(stray.span(), "", what));
    }
    let target = raw.target.as_ref().map_or([0.0; 3], |t| *t.get_ref());
    let up = raw.up.as_ref().map_or([0.0, 0.0, 1.0], |u| *u.get_ref());
    Ok(Camera::look_at(eye, target, up, fov))
}

fn above(source: &Text, raw: &RawCamera, fov: f64) -> Result<Option<Camera>> {
    if let Some(stray) = raw.target.as_ref().or(raw.up.as_ref()) {
        return Err(source.bad(stray.span(), "", "target and up are valid only with eye"));
    }
    let lon = source.number(raw.lon.as_ref(), "lon")?;
    let lat = source.number(raw.lat.as_ref(), "lat")?;
    if let (Some(_), Some(altitude)) = (&raw.distance, &raw.altitude) {
        return Err(source.bad(altitude.span(), "", "expected either distance or altitude"));
    }
    let distance = distance(source, raw.distance.as_ref(), raw.altitude.as_ref())?;
    Ok(Camera::above(lon, lat, distance.unwrap_or_else(|| whole_planet(fov)), fov))
}

/// The distance from the planet's centre by either key of the source's section; `None` where neither is given.
pub(super) fn distance(
    source: &Text,
    distance: Option<&Spanned<f64>>,
    altitude: Option<&Spanned<f64>>,
) -> Result<Option<f64>> {
    let altitude = source.optional_number(altitude, "altitude")?;
    Ok(source.optional_number(distance, "distance")?.or(altitude.map(|altitude| 1.0 + altitude)))
}
