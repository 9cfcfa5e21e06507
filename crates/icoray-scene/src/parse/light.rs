//! The light.

use super::text::Text;
use crate::scene::{Lighting, Source};
use icoray_grid::Result;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLight {
    kind: Option<Spanned<String>>,
    lon: Option<Spanned<f64>>,
    lat: Option<Spanned<f64>>,
    ambient: Option<Spanned<f64>>,
    diffuse: Option<Spanned<f64>>,
    specular: Option<Spanned<f64>>,
    shininess: Option<Spanned<f64>>,
}

pub(super) fn lighting(source: &Text, raw: &Spanned<RawLight>) -> Result<Option<Lighting>> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let place = match (&raw.lon, &raw.lat) {
        (Some(lon), Some(lat)) => Some((
            source.number(Some(lon), "light.lon", -360.0, 360.0, 0.0)?,
            source.number(Some(lat), "light.lat", -90.0, 90.0, 0.0)?,
        )),
        (None, None) => None,
        _ => return Err(source.bad(span, "light", "expected both lon and lat, or neither")),
    };
    let headlight = Spanned::new(span.clone(), "headlight".to_owned());
    let word = raw.kind.as_ref().unwrap_or(&headlight);
    let kind = match (word.get_ref().as_str(), place) {
        ("none", None) => return Ok(None),
        ("headlight", None) => Source::Headlight,
        ("sun", Some((lon_deg, lat_deg))) => Source::Sun { lon_deg, lat_deg },
        ("sun", None) => {
            return Err(source.bad(word.span(), "light.kind", "a sun needs lon and lat"));
        }
        ("none" | "headlight", Some(_)) => {
            return Err(source.bad(span, "light", "lon and lat go with kind = \"sun\""));
        }
        _ => return Err(source.unknown_word(word, "light.kind", &["headlight", "sun", "none"])),
    };
    Ok(Some(Lighting {
        source: kind,
        ambient: source.number(raw.ambient.as_ref(), "light.ambient", 0.0, 1.0, 0.35)?,
        diffuse: source.number(raw.diffuse.as_ref(), "light.diffuse", 0.0, 1.0, 0.65)?,
        specular: source.number(raw.specular.as_ref(), "light.specular", 0.0, 1.0, 0.2)?,
        shininess: source.number(raw.shininess.as_ref(), "light.shininess", 1.0, 1000.0, 32.0)?,
    }))
}
