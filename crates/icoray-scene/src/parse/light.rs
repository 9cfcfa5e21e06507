//! The light.

use super::text::Text;
use crate::keys::{keys, number, word};
use crate::scene::{LightSource, Lighting};
use icoray_grid::Result;
use toml::Spanned;

keys! {
    pub(super) struct RawLight {
        /// From the camera, from infinity above a place, or no light.
        kind: Option<Spanned<String>> = word(&["headlight", "sun", "none"]).or_word("headlight"),
        /// Longitude below the sun.
        lon: Option<Spanned<f64>> = number(-360.0..=360.0).or_else("required with `\"sun\"`"),
        /// Latitude below the sun.
        lat: Option<Spanned<f64>> = number(-90.0..=90.0).or_else("required with `\"sun\"`"),
        /// Part of the colour that needs no light.
        ambient: Option<Spanned<f64>> = number(0.0..=1.0).or(0.35),
        /// Part of the colour that depends on the angle to the light.
        diffuse: Option<Spanned<f64>> = number(0.0..=1.0).or(0.65),
        /// Strength of the white highlight.
        specular: Option<Spanned<f64>> = number(0.0..=1.0).or(0.2),
        /// Exponent of the highlight; larger is smaller and sharper.
        shininess: Option<Spanned<f64>> = number(1.0..=1000.0).or(32.0),
    }
}

pub(super) fn lighting(source: &Text, raw: &Spanned<RawLight>) -> Result<Option<Lighting>> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let lon = source.optional_number(raw.lon.as_ref(), "light.lon")?;
    let place = match (lon, source.optional_number(raw.lat.as_ref(), "light.lat")?) {
        (Some(lon), Some(lat)) => Some((lon, lat)),
        (None, None) => None,
        _ => return Err(source.bad(span, "light", "expected both lon and lat, or neither")),
    };
    let headlight = Spanned::new(span.clone(), "headlight".to_owned());
    let word = raw.kind.as_ref().unwrap_or(&headlight);
    let kind = match (word.get_ref().as_str(), place) {
        ("none", None) => return Ok(None),
        ("headlight", None) => LightSource::Headlight,
        ("sun", Some((lon_deg, lat_deg))) => LightSource::Sun { lon_deg, lat_deg },
        ("sun", None) => {
            return Err(source.bad(word.span(), "light.kind", "a sun needs lon and lat"));
        }
        ("none" | "headlight", Some(_)) => {
            return Err(source.bad(span, "light", "lon and lat go with kind = \"sun\""));
        }
        _ => return Err(source.unknown_word(word, "light.kind")),
    };
    Ok(Some(Lighting {
        source: kind,
        ambient: source.number(raw.ambient.as_ref(), "light.ambient")?,
        diffuse: source.number(raw.diffuse.as_ref(), "light.diffuse")?,
        specular: source.number(raw.specular.as_ref(), "light.specular")?,
        shininess: source.number(raw.shininess.as_ref(), "light.shininess")?,
    }))
}
