//! Where things lie: levels, and boxes in longitude and latitude.

use super::text::Text;
use crate::keys::{Key, Kind, keys, number, of};
use crate::scenery::{Level, LonLatBox};
use icoray_grid::{Result, numbers};
use serde::Deserialize;
use toml::Spanned;

/// A height above the planet's surface, metres.
pub(super) const HEIGHT_M: Key = number(-1e9..=1e9);
/// The ends of a box.
pub(super) const LONGITUDES: Key =
    of(Kind::Vector(&["west", "east"])).within(-360.0..=720.0).or_else("all").note("at most 360 apart");
pub(super) const LATITUDES: Key = of(Kind::Vector(&["south", "north"])).within(-90.0..=90.0).or_else("all");

/// A layer, by its number or a word.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum RawLayer {
    Number(i64),
    Word(String),
}

/// A level by a key whose value is a layer, or by its height; `None` where neither is given.
pub(super) fn level(
    source: &Text,
    key: &str,
    layer: Option<&Spanned<RawLayer>>,
    height_m: Option<&Spanned<f64>>,
) -> Result<Option<Level>> {
    match (layer, height_m) {
        (None, height_m) => Ok(source.optional_number(height_m, "height_m")?.map(Level::Height)),
        (Some(layer), Some(_)) => Err(source.bad(layer.span(), key, format!("expected either {key} or height_m"))),
        (Some(layer), None) => self::layer(source, key, layer).map(Some),
    }
}

fn layer(source: &Text, key: &str, raw: &Spanned<RawLayer>) -> Result<Level> {
    let has_ground = key == "on";
    let found = match raw.get_ref() {
        RawLayer::Number(number) => match usize::try_from(*number) {
            Ok(number) => return Ok(Level::Layer(number)),
            Err(_) => number.to_string(),
        },
        RawLayer::Word(word) => match word.as_str() {
            "top" => return Ok(Level::Top),
            "bottom" => return Ok(Level::Layer(0)),
            "ground" if has_ground => return Ok(Level::Ground),
            _ => format!("{word:?}"),
        },
    };
    let ground = if has_ground { "\"ground\", " } else { "" };
    let what = format!("{found}, expected {ground}\"top\", \"bottom\" or a number from 0, the innermost layer");
    Err(source.bad(raw.span(), key, what))
}

/// From layer to layer, both included.
pub(super) fn layers(source: &Text, raw: &Spanned<[i64; 2]>, key: &str) -> Result<[usize; 2]> {
    let [from, to] = *raw.get_ref();
    match (usize::try_from(from), usize::try_from(to)) {
        (Ok(from), Ok(to)) if from <= to => Ok([from, to]),
        _ => {
            let what = format!("[{from}, {to}], expected two numbers from 0, the innermost layer, the lower first");
            Err(source.bad(raw.span(), key, what))
        }
    }
}

keys! {
    pub(super) struct RawRegion {
        /// `[170, -170]` crosses the date line.
        lon: Option<Spanned<[f64; 2]>> = LONGITUDES,
        /// Southern end first.
        lat: Option<Spanned<[f64; 2]>> = LATITUDES,
    }
}

pub(super) fn region(source: &Text, raw: &Spanned<RawRegion>) -> Result<LonLatBox> {
    let RawRegion { lon, lat } = raw.get_ref();
    let found = lon_lat_box(source, "region.", lon.as_ref(), lat.as_ref())?;
    found.ok_or_else(|| source.bad(raw.span(), "region", "expected lon, lat or both"))
}

/// The box of the ranges `lon` and `lat` of a table, of which one alone leaves the other whole; `None` where none is
/// given.
pub(super) fn lon_lat_box(
    source: &Text,
    table: &str,
    lon: Option<&Spanned<[f64; 2]>>,
    lat: Option<&Spanned<[f64; 2]>>,
) -> Result<Option<LonLatBox>> {
    if lon.is_none() && lat.is_none() {
        return Ok(None);
    }
    let lon_deg = lon.map_or(Ok([-180.0, 180.0]), |raw| {
        // [170, -170] goes over the date line, as [170, 190] does.
        let [west, east] = *raw.get_ref();
        let turns = if east < west { ((west - east) / 360.0).floor() + 1.0 } else { 0.0 };
        ends(source, raw, &format!("{table}lon"), "western and eastern", east + 360.0 * turns)
    })?;
    let lat_deg = lat.map_or(Ok([-90.0, 90.0]), |raw| {
        ends(source, raw, &format!("{table}lat"), "southern and northern", raw.get_ref()[1])
    })?;
    Ok(Some(LonLatBox { lon_deg, lat_deg }))
}

/// The first of two numbers within the key's bounds, and the larger end that stands for the second; `words` name both.
fn ends(source: &Text, raw: &Spanned<[f64; 2]>, key: &str, words: &str, end: f64) -> Result<[f64; 2]> {
    let ([first, second], schema) = (*raw.get_ref(), source.schema(key));
    if schema.contains(first) && schema.contains(second) && first < end && end - first <= 360.0 {
        return Ok([first, end]);
    }
    let what = format!("{}, expected {words} end, {}", numbers::list(&[first, second]), schema.range_text());
    Err(source.bad(raw.span(), key, what))
}
