//! Cameras that move: `camera.orbit` and `camera.path`.

use super::{section, take};
use crate::keys::{Key, Kind, keys, number, of, section as table, sections_of};
use crate::parse::camera::{distance, whole_planet};
use crate::parse::text::Text;
use crate::script::{Clock, Motion, Orbit, Path, PathError, PathKey};
use icoray_grid::Result;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Keys of the camera, beside those that it has in a scene.
pub const KEYS: &[Key] = keys! {
    /// Moves the camera around the axis: see [moving cameras](#moving-cameras).
    orbit = table(&[RawOrbit::KEYS]),
    /// Moves the camera along places: see [moving cameras](#moving-cameras).
    path = sections_of(&[RawKey::KEYS]),
};

keys! {
    struct RawOrbit {
        /// Degrees per step.
        degrees_per_step: Option<Spanned<f64>> = number(-1e9..=1e9),
        /// Degrees per period.
        turn: Option<Spanned<f64>> = number(-1e9..=1e9),
        /// Period in steps.
        steps: Option<Spanned<f64>> = number(1e-9..=1e12),
        /// Period in seconds of model time.
        seconds: Option<Spanned<f64>> = number(1e-9..=1e12),
    }
}

keys! {
    struct RawKey {
        /// Step of the place; either all places have steps or all have times.
        step: Option<Spanned<i64>> = of(Kind::Integer).note("rising"),
        /// Model time of the place, seconds.
        time: Option<Spanned<f64>> = number(-1e15..=1e15).note("rising"),
        /// Longitude.
        lon: Option<Spanned<f64>> = number(-360.0..=360.0).or(0.0),
        /// Latitude.
        lat: Option<Spanned<f64>> = number(-90.0..=90.0).or(25.0),
        /// Distance from the planet's centre, planet radii.
        distance: Option<Spanned<f64>> = number(1e-6..=1e6).or_else("the camera's"),
        /// Distance from the surface, planet radii.
        altitude: Option<Spanned<f64>> = number(-0.999_999..=1e6),
        /// Full vertical field of view, degrees.
        fov: Option<Spanned<f64>> = number(1e-3..=179.0).or_else("the camera's"),
    }
}

/// How the camera moves. A path gives the scene's own camera its first key's place.
pub fn motion(source: &Text, root: &mut DeTable) -> Result<Motion> {
    let Some(camera) = section(root, "camera") else { return Ok(Motion::Still) };
    let orbit = take::<RawOrbit>(source, camera, "orbit")?;
    match (orbit, camera.get("path").map(Spanned::span)) {
        (None, None) => Ok(Motion::Still),
        (Some(orbit), None) => Ok(Motion::Orbit(self::orbit(source, &orbit)?)),
        (None, Some(span)) => path(source, camera, span).map(Motion::Path),
        (Some(_), Some(span)) => {
            Err(source.bad(span, "camera.path", "is not valid with camera.orbit, expected one of them"))
        }
    }
}

fn orbit(source: &Text, raw: &Spanned<RawOrbit>) -> Result<Orbit> {
    let (source, span, raw) = (source.within("camera.orbit"), raw.span(), raw.get_ref());
    let per_step = source.optional_number(raw.degrees_per_step.as_ref(), "degrees_per_step")?;
    let turn = source.optional_number(raw.turn.as_ref(), "turn")?;
    let steps = source.optional_number(raw.steps.as_ref(), "steps")?;
    let seconds = source.optional_number(raw.seconds.as_ref(), "seconds")?;
    let (clock, turn_deg, period) = match (per_step, turn, steps, seconds) {
        (Some(turn), None, None, None) => (Clock::Step, turn, 1.0),
        (None, Some(turn), Some(steps), None) => (Clock::Step, turn, steps),
        (None, Some(turn), None, Some(seconds)) => (Clock::Time, turn, seconds),
        _ => {
            let wish = "expected degrees_per_step, or turn and steps, or turn and seconds";
            return Err(source.bad(span, "", wish));
        }
    };
    Ok(Orbit { clock, turn_deg, period })
}

/// Defaults of path keys.
struct KeyDefaults {
    distance: Option<f64>,
    fov_deg: f64,
}

fn path(source: &Text, camera: &mut DeTable, span: Range<usize>) -> Result<Path> {
    const KEY: &str = "camera.path";
    if let Some(stray) = ["lon", "lat", "eye", "target", "up"].iter().find_map(|key| camera.get(*key)) {
        return Err(source.bad(stray.span(), KEY, "its keys have the places, expected no other one"));
    }
    let first = camera.get("path").and_then(|path| path.get_ref().get(0)).map(Spanned::get_ref).cloned();
    let of_camera = &source.within("camera");
    let number = |camera: &DeTable, key: &str| take::<f64>(of_camera, &mut camera.clone(), key);
    let defaults = KeyDefaults {
        distance: distance(of_camera, number(camera, "distance")?.as_ref(), number(camera, "altitude")?.as_ref())?,
        fov_deg: of_camera.number(number(camera, "fov")?.as_ref(), "fov")?,
    };
    let raw = take::<Vec<Spanned<RawKey>>>(source, camera, "path")?.map(Spanned::into_inner).unwrap_or_default();
    let clock = raw.first().map_or(Clock::Step, |key| match key.get_ref().time {
        Some(_) => Clock::Time,
        None => Clock::Step,
    });
    let keys = raw.iter().map(|raw| key(source, raw, clock, &defaults)).collect::<Result<Vec<PathKey>>>()?;
    let path = Path::new(clock, keys).map_err(|PathError { key, message }| {
        let span = raw.get(key).map_or(span, Spanned::span);
        source.bad(span, KEY, message)
    })?;
    if let Some(DeValue::Table(first)) = first {
        let has_distance = camera.contains_key("distance") || camera.contains_key("altitude");
        let of_place = first.into_iter().filter(|(key, _)| match key.get_ref().as_ref() {
            "lon" | "lat" => true,
            "distance" | "altitude" => !has_distance,
            _ => false,
        });
        camera.extend(of_place);
    }
    Ok(path)
}

fn key(source: &Text, raw: &Spanned<RawKey>, clock: Clock, defaults: &KeyDefaults) -> Result<PathKey> {
    let (source, span, raw) = (&source.within("camera.path"), raw.span(), raw.get_ref());
    let bad = |what: &str| source.bad(span.clone(), "", what);
    let at = match (clock, &raw.step, &raw.time) {
        (Clock::Step, Some(step), None) => *step.get_ref() as f64,
        (Clock::Time, None, Some(time)) => source.number(Some(time), "time")?,
        _ => return Err(bad("expected each key to have a step, or each a time in seconds")),
    };
    if raw.distance.is_some() && raw.altitude.is_some() {
        return Err(bad("expected either distance or altitude"));
    }
    let fov_deg = source.optional_number(raw.fov.as_ref(), "fov")?.unwrap_or(defaults.fov_deg);
    let own = distance(source, raw.distance.as_ref(), raw.altitude.as_ref())?;
    Ok(PathKey {
        at,
        lon_deg: source.number(raw.lon.as_ref(), "lon")?,
        lat_deg: source.number(raw.lat.as_ref(), "lat")?,
        distance: own.or(defaults.distance).unwrap_or_else(|| whole_planet(fov_deg)),
        fov_deg,
    })
}
