//! From TOML to a checked [`Scene`]: every error names the line and the key.

mod output;

use super::{Camera, Knot, Lighting, Precision, Scene, Source, TransferFunction, color, transfer};
use crate::error::{Error, ErrorKind, Result};
use crate::kernel::piece::Method;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScene {
    field: Spanned<String>,
    every: Option<Spanned<i64>>,
    exaggeration: Option<Spanned<f64>>,
    background: Option<Spanned<String>>,
    core: Option<Spanned<String>>,
    #[serde(default)]
    method: Method,
    tolerance: Option<Spanned<f64>>,
    time_budget_ms: Option<Spanned<f64>>,
    #[serde(default)]
    precision: Precision,
    image: Option<RawImage>,
    camera: Spanned<RawCamera>,
    transfer: Spanned<RawTransfer>,
    light: Option<Spanned<RawLight>>,
    output: Option<output::RawOutput>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawImage {
    width: Spanned<i64>,
    height: Spanned<i64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawCamera {
    lon: Option<Spanned<f64>>,
    lat: Option<Spanned<f64>>,
    distance: Option<Spanned<f64>>,
    altitude: Option<Spanned<f64>>,
    eye: Option<Spanned<[f64; 3]>>,
    target: Option<Spanned<[f64; 3]>>,
    up: Option<Spanned<[f64; 3]>>,
    fov: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTransfer {
    unit_length: Option<Spanned<f64>>,
    knots: Option<Spanned<Vec<Spanned<RawKnot>>>>,
    map: Option<Spanned<String>>,
    #[serde(default)]
    reverse: bool,
    range: Option<Spanned<[f64; 2]>>,
    opacity: Option<Spanned<Vec<Spanned<[f64; 2]>>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawKnot {
    value: f64,
    color: Spanned<String>,
    opacity: Option<Spanned<f64>>,
    extinction: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawLight {
    kind: Spanned<String>,
    lon: Option<Spanned<f64>>,
    lat: Option<Spanned<f64>>,
    ambient: Option<Spanned<f64>>,
    diffuse: Option<Spanned<f64>>,
    specular: Option<Spanned<f64>>,
    shininess: Option<Spanned<f64>>,
}

/// The text of a scene file, for saying where in it something stands.
struct Text<'t> {
    text: &'t str,
}

impl Text<'_> {
    fn line(&self, span: &Range<usize>) -> usize {
        1 + self.text[..span.start.min(self.text.len())].bytes().filter(|b| *b == b'\n').count()
    }

    fn bad(&self, span: Range<usize>, key: &str, what: impl std::fmt::Display) -> Error {
        Error::new(ErrorKind::Scene, format!("line {}, key {key}: {what}", self.line(&span)))
    }

    /// A number between `low` and `high`, or `default` where the key is absent.
    fn number(
        &self,
        raw: Option<&Spanned<f64>>,
        key: &str,
        low: f64,
        high: f64,
        default: f64,
    ) -> Result<f64> {
        let Some(raw) = raw else { return Ok(default) };
        let value = *raw.get_ref();
        if value >= low && value <= high {
            return Ok(value);
        }
        Err(self.bad(raw.span(), key, format!("{value}, expected a number from {low} to {high}")))
    }

    fn color(&self, raw: &Spanned<String>, key: &str) -> Result<[f64; 3]> {
        color::css(raw.get_ref()).ok_or_else(|| {
            self.bad(
                raw.span(),
                key,
                format!("{:?}, expected an opaque CSS colour such as \"#ff8800\"", raw.get_ref()),
            )
        })
    }

    /// A colour, or `None` for the word "transparent".
    fn color_or_none(
        &self,
        raw: Option<&Spanned<String>>,
        key: &str,
        default: Option<[f64; 3]>,
    ) -> Result<Option<[f64; 3]>> {
        match raw {
            None => Ok(default),
            Some(raw) if raw.get_ref() == "transparent" => Ok(None),
            Some(raw) => self.color(raw, key).map(Some),
        }
    }
}

/// Parses and checks a scene.
pub(super) fn scene(text: &str) -> Result<Scene> {
    let source = Text { text };
    let raw: RawScene = toml::from_str(text).map_err(|e| {
        let line = e.span().map_or_else(String::new, |span| {
            let line = source.line(&span);
            format!("line {line} ({}): ", text.lines().nth(line - 1).unwrap_or("").trim())
        });
        Error::new(ErrorKind::Scene, format!("{line}{}", e.message()))
    })?;
    let count = |raw: Option<&Spanned<i64>>, key: &str, most: u32, what: &str, default: u32| match raw {
        None => Ok(default),
        Some(raw) => match u32::try_from(*raw.get_ref()) {
            Ok(count) if (1..=most).contains(&count) => Ok(count),
            _ => Err(source.bad(raw.span(), key, format!("{}, expected 1 to {most}{what}", raw.get_ref()))),
        },
    };
    let side = |raw, key: &str| count(raw, key, 16384, " pixels", 512);
    if raw.field.get_ref().is_empty() {
        return Err(source.bad(raw.field.span(), "field", "an empty name"));
    }
    let [tolerance_min, tolerance_max] = [*Scene::TOLERANCE.start(), *Scene::TOLERANCE.end()];
    Ok(Scene {
        every: count(raw.every.as_ref(), "every", 1_000_000_000, "", 1)?,
        width: side(raw.image.as_ref().map(|i| &i.width), "image.width")?,
        height: side(raw.image.as_ref().map(|i| &i.height), "image.height")?,
        background: source.color_or_none(raw.background.as_ref(), "background", Some([0.0; 3]))?,
        exaggeration: source.number(raw.exaggeration.as_ref(), "exaggeration", 1e-6, 1e6, 1.0)?,
        core: source.color_or_none(raw.core.as_ref(), "core", Some([0.0225, 0.0225, 0.0225]))?,
        camera: camera(&source, &raw.camera)?,
        transfer: transfer_function(&source, &raw.transfer)?,
        lighting: raw.light.as_ref().map(|light| lighting(&source, light)).transpose()?.flatten(),
        method: raw.method,
        tolerance: source.number(
            raw.tolerance.as_ref(),
            "tolerance",
            tolerance_min,
            tolerance_max,
            Scene::DEFAULT_TOLERANCE,
        )?,
        time_budget_ms: raw
            .time_budget_ms
            .as_ref()
            .map(|ms| source.number(Some(ms), "time_budget_ms", 1.0, 1e9, 0.0))
            .transpose()?,
        precision: raw.precision,
        output: output::output(&source, raw.output.as_ref())?,
        field: raw.field.into_inner(),
    })
}

fn camera(source: &Text, raw: &Spanned<RawCamera>) -> Result<Camera> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let fov = source.number(raw.fov.as_ref(), "camera.fov", 1e-3, 179.0, 30.0)?;
    let camera = match (&raw.eye, &raw.lon, &raw.lat) {
        (Some(eye), None, None) => {
            if let Some(stray) = raw.distance.as_ref().or(raw.altitude.as_ref()) {
                return Err(source.bad(
                    stray.span(),
                    "camera",
                    "distance and altitude go with lon and lat, not with eye",
                ));
            }
            let target = raw.target.as_ref().map_or([0.0; 3], |t| *t.get_ref());
            let up = raw.up.as_ref().map_or([0.0, 0.0, 1.0], |u| *u.get_ref());
            Camera::look_at(*eye.get_ref(), target, up, fov)
        }
        (None, Some(lon), Some(lat)) => {
            let lon = source.number(Some(lon), "camera.lon", -360.0, 360.0, 0.0)?;
            let lat = source.number(Some(lat), "camera.lat", -90.0, 90.0, 0.0)?;
            if let Some(stray) = raw.target.as_ref().or(raw.up.as_ref()) {
                return Err(source.bad(
                    stray.span(),
                    "camera",
                    "target and up go with eye, not with lon and lat",
                ));
            }
            let distance = match (&raw.distance, &raw.altitude) {
                (Some(d), None) => source.number(Some(d), "camera.distance", 1e-6, 1e6, 0.0)?,
                (None, Some(a)) => 1.0 + source.number(Some(a), "camera.altitude", -0.999_999, 1e6, 0.0)?,
                _ => {
                    return Err(source.bad(
                        span,
                        "camera",
                        "expected either distance or altitude beside lon and lat",
                    ));
                }
            };
            Camera::above(lon, lat, distance, fov)
        }
        _ => {
            return Err(source.bad(
                span,
                "camera",
                "expected lon, lat and distance (or altitude), or eye, target and up",
            ));
        }
    };
    camera.ok_or_else(|| {
        source.bad(
            span,
            "camera",
            "eye and target coincide, up points along the view, or a number is not finite",
        )
    })
}

fn transfer_function(source: &Text, raw: &Spanned<RawTransfer>) -> Result<TransferFunction> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let unit_length = raw
        .unit_length
        .as_ref()
        .map(|u| source.number(Some(u), "transfer.unit_length", 1e-12, 1e6, 0.0))
        .transpose()?;
    match (&raw.knots, &raw.map) {
        (Some(knots), None) => {
            if raw.range.is_some() || raw.opacity.is_some() || raw.reverse {
                return Err(source.bad(
                    span,
                    "transfer",
                    "range, opacity and reverse go with map, not with knots",
                ));
            }
            let spans = knots.get_ref().iter().map(|k| (k.get_ref().value, k.span()));
            check_rising(source, spans, knots.span(), "transfer.knots")?;
            let knots = knots.get_ref().iter().map(|k| knot(source, k)).collect::<Result<Vec<Knot>>>()?;
            Ok(TransferFunction { knots, unit_length })
        }
        (None, Some(map)) => {
            let (Some(range), Some(opacity)) = (&raw.range, &raw.opacity) else {
                return Err(source.bad(map.span(), "transfer.map", "expected range and opacity beside map"));
            };
            let ends = *range.get_ref();
            if !(ends[0] < ends[1] && ends.iter().all(|v| v.is_finite())) {
                return Err(source.bad(
                    range.span(),
                    "transfer.range",
                    format!("{ends:?}, expected two finite numbers, the lower first"),
                ));
            }
            let spans = opacity.get_ref().iter().map(|o| (o.get_ref()[0], o.span()));
            check_rising(source, spans, opacity.span(), "transfer.opacity")?;
            let mut extinction = Vec::new();
            for pair in opacity.get_ref() {
                let [value, opacity] = *pair.get_ref();
                extinction
                    .push((value, opacity_to_extinction(source, opacity, pair.span(), "transfer.opacity")?));
            }
            TransferFunction::from_map(map.get_ref(), raw.reverse, ends, &extinction, unit_length).ok_or_else(
                || {
                    let names = color::MAPS.join(", ");
                    source.bad(
                        map.span(),
                        "transfer.map",
                        format!("{:?}, expected one of {names}", map.get_ref()),
                    )
                },
            )
        }
        _ => Err(source.bad(span, "transfer", "expected either knots, or map with range and opacity")),
    }
}

fn check_rising(
    source: &Text,
    values: impl Iterator<Item = (f64, Range<usize>)>,
    whole: Range<usize>,
    key: &str,
) -> Result<()> {
    let values: Vec<_> = values.collect();
    if values.is_empty() || values.len() > 4096 {
        return Err(source.bad(whole, key, format!("{} knots, expected 1 to 4096", values.len())));
    }
    if let Some((v, span)) = values.iter().find(|(v, _)| !v.is_finite()) {
        return Err(source.bad(span.clone(), key, format!("value {v}, expected a finite number")));
    }
    for (i, pair) in values.windows(2).enumerate() {
        let falls = pair[1].0 < pair[0].0;
        let third = pair[1].0 == pair[0].0 && i > 0 && values[i - 1].0 == pair[0].0;
        if falls || third {
            let wish = if third { "at most two knots on one value" } else { "values that rise" };
            return Err(source.bad(
                pair[1].1.clone(),
                key,
                format!("{} after {}, expected {wish}", pair[1].0, pair[0].0),
            ));
        }
    }
    Ok(())
}

fn knot(source: &Text, raw: &Spanned<RawKnot>) -> Result<Knot> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let extinction = match (&raw.opacity, &raw.extinction) {
        (Some(opacity), None) => {
            opacity_to_extinction(source, *opacity.get_ref(), opacity.span(), "transfer.knots.opacity")?
        }
        (None, Some(e)) => source.number(Some(e), "transfer.knots.extinction", 0.0, 1e12, 0.0)?,
        _ => {
            return Err(source.bad(
                span,
                "transfer.knots",
                "expected either opacity or extinction in each knot",
            ));
        }
    };
    Ok(Knot { value: raw.value, color: source.color(&raw.color, "transfer.knots.color")?, extinction })
}

fn opacity_to_extinction(source: &Text, opacity: f64, span: Range<usize>, key: &str) -> Result<f64> {
    if (0.0..1.0).contains(&opacity) {
        return Ok(transfer::extinction_of(opacity));
    }
    let wish =
        "expected 0 or more and less than 1 (1 would need endless extinction; knots take extinction instead)";
    Err(source.bad(span, key, format!("opacity {opacity}, {wish}")))
}

fn lighting(source: &Text, raw: &Spanned<RawLight>) -> Result<Option<Lighting>> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let place = match (&raw.lon, &raw.lat) {
        (Some(lon), Some(lat)) => Some((
            source.number(Some(lon), "light.lon", -360.0, 360.0, 0.0)?,
            source.number(Some(lat), "light.lat", -90.0, 90.0, 0.0)?,
        )),
        (None, None) => None,
        _ => return Err(source.bad(span, "light", "expected both lon and lat, or neither")),
    };
    let kind = match (raw.kind.get_ref().as_str(), place) {
        ("none", None) => return Ok(None),
        ("headlight", None) => Source::Headlight,
        ("sun", Some((lon_deg, lat_deg))) => Source::Sun { lon_deg, lat_deg },
        ("sun", None) => {
            return Err(source.bad(raw.kind.span(), "light.kind", "a sun needs lon and lat"));
        }
        ("none" | "headlight", Some(_)) => {
            return Err(source.bad(span, "light", "lon and lat go with kind = \"sun\""));
        }
        (other, _) => {
            let wish = "expected \"headlight\", \"sun\" or \"none\"";
            return Err(source.bad(raw.kind.span(), "light.kind", format!("{other:?}, {wish}")));
        }
    };
    Ok(Some(Lighting {
        source: kind,
        ambient: source.number(raw.ambient.as_ref(), "light.ambient", 0.0, 1.0, 0.35)?,
        diffuse: source.number(raw.diffuse.as_ref(), "light.diffuse", 0.0, 1.0, 0.65)?,
        specular: source.number(raw.specular.as_ref(), "light.specular", 0.0, 1.0, 0.2)?,
        shininess: source.number(raw.shininess.as_ref(), "light.shininess", 1.0, 1000.0, 32.0)?,
    }))
}

#[cfg(test)]
mod tests;
