//! A colour map, its scale, its range and its opacities.

use super::{Gives, MEANINGLESS, RawTransfer, Text, stops};
use crate::error::Result;
use crate::scene::color::{ColorMap, MAPS};
use crate::scene::{ColorRange, Coloring, Scale};
use std::ops::Range;
use toml::{Spanned, Value};

/// The map where none is named, for people of any sight: the second where values lie about a centre.
const DEFAULT_MAPS: [&str; 2] = ["viridis", "vik"];
/// The hysteresis of a union that names none.
const HYSTERESIS: f64 = 0.1;

/// What a map needs beside it.
pub(super) fn needs(gives: Gives) -> &'static str {
    if gives == Gives::All { "range and opacity" } else { "range" }
}

pub(super) fn coloring(
    source: &Text,
    raw: &RawTransfer,
    span: Range<usize>,
    unit_length: Option<f64>,
    gives: Gives,
) -> Result<Coloring> {
    let at = raw.map.as_ref().map_or(span.clone(), Spanned::span);
    let (Some(ends), true) = (&raw.range, raw.opacity.is_some() || gives != Gives::All) else {
        let needs = needs(gives);
        let what = match raw.map {
            Some(_) => format!("expected {needs} beside map"),
            None => format!("expected either knots, or map with {needs}"),
        };
        return Err(source.bad(at, if raw.map.is_some() { "transfer.map" } else { "transfer" }, what));
    };
    let default = DEFAULT_MAPS[usize::from(raw.center.is_some())];
    let name = raw.map.as_ref().map_or(default, |map| map.get_ref());
    let map = ColorMap::named(name).ok_or_else(|| {
        source.bad(
            at,
            "transfer.map",
            format!("{name:?}, expected one of {}, or one with _r behind it", *MAPS),
        )
    })?;
    let scale = scale(source, raw)?;
    let range = range(source, ends)?;
    if let (ColorRange::Fixed(fixed), Scale::Log) = (range, scale)
        && fixed[0] <= 0.0
    {
        let what = format!("{fixed:?}, expected two positive numbers on a log scale, the lower first");
        return Err(source.bad(ends.span(), "transfer.range", what));
    }
    let center = center(source, raw, scale)?;
    let (is_relative, extinction) = match &raw.opacity {
        Some(opacity) => {
            let is_relative = is_relative(source, raw, range)?;
            let extinction = stops(source, opacity, "transfer.opacity")?;
            if !is_relative
                && let Some(pair) = opacity.get_ref().iter().find(|p| !scale.admits(p.get_ref()[0]))
            {
                let what = format!("value {}, expected a positive one on a log scale", pair.get_ref()[0]);
                return Err(source.bad(pair.span(), "transfer.opacity", what));
            }
            (is_relative, extinction)
        }
        None => (true, vec![(0.0, MEANINGLESS)]),
    };
    let (map, name) = match raw.reverse {
        false => (map, name.to_owned()),
        true => (map.reversed(), turned(name)),
    };
    Ok(Coloring { map, name, scale, range, center, extinction, is_relative, unit_length })
}

/// The name of a map turned round.
fn turned(name: &str) -> String {
    name.strip_suffix("_r").or(name.strip_suffix("_R")).map_or_else(|| format!("{name}_r"), str::to_owned)
}

fn scale(source: &Text, raw: &RawTransfer) -> Result<Scale> {
    let (word, key) = (raw.scale.as_ref().map(|s| s.get_ref().as_str()), "transfer.threshold");
    match (word, &raw.threshold) {
        (Some("symlog"), threshold) => {
            let Some(threshold) = threshold else {
                let span = raw.scale.as_ref().map_or(0..0, Spanned::span);
                let what =
                    "\"symlog\" needs threshold, the value on either side of 0 up to which it is linear";
                return Err(source.bad(span, "transfer.scale", what));
            };
            Ok(Scale::SymLog { threshold: source.number(Some(threshold), key, 1e-300, 1e300, 0.0)? })
        }
        (_, Some(stray)) => Err(source.bad(stray.span(), key, "is valid only with scale = \"symlog\"")),
        (None | Some("linear"), None) => Ok(Scale::Linear),
        (Some("log"), None) => Ok(Scale::Log),
        (Some(other), None) => {
            let span = raw.scale.as_ref().map_or(0..0, Spanned::span);
            let what = format!("{other:?}, expected \"linear\", \"log\" or \"symlog\"");
            Err(source.bad(span, "transfer.scale", what))
        }
    }
}

fn center(source: &Text, raw: &RawTransfer, scale: Scale) -> Result<Option<f64>> {
    let Some(center) = &raw.center else { return Ok(None) };
    let value = source.number(Some(center), "transfer.center", -1e300, 1e300, 0.0)?;
    if scale.admits(value) {
        return Ok(Some(value));
    }
    Err(source.bad(
        center.span(),
        "transfer.center",
        format!("{value}, expected a positive one on a log scale"),
    ))
}

/// Whether opacities are given along the range: as the scene says, and else where that follows the data.
fn is_relative(source: &Text, raw: &RawTransfer, range: ColorRange) -> Result<bool> {
    let Some(word) = &raw.opacity_in else { return Ok(!matches!(range, ColorRange::Fixed(_))) };
    match word.get_ref().as_str() {
        "values" => Ok(false),
        "range" => Ok(true),
        other => {
            let what = format!("{other:?}, expected \"values\" or \"range\"");
            Err(source.bad(word.span(), "transfer.opacity_in", what))
        }
    }
}

/// Two numbers, or what of the data they come from.
fn range(source: &Text, raw: &Spanned<Value>) -> Result<ColorRange> {
    let key = "transfer.range";
    let bad = |what: String| source.bad(raw.span(), key, what);
    let Value::Table(table) = raw.get_ref() else {
        let ends = pair(raw.get_ref()).filter(|[low, high]| low < high);
        let wish =
            "expected two finite numbers, the lower first, { percentile = [1, 99] } or { union = [1, 99] }";
        return ends.map(ColorRange::Fixed).ok_or_else(|| bad(format!("{}, {wish}", raw.get_ref())));
    };
    let percentile = |key: &str| {
        let value = table.get(key);
        let ends = value.and_then(pair).filter(|[low, high]| 0.0 <= *low && low < high && *high <= 100.0);
        let found = value.map_or_else(String::new, |value| format!("{key} = {value}, "));
        ends.ok_or_else(|| bad(format!("{found}expected two percentiles from 0 to 100, the lower first")))
    };
    let mut keys: Vec<&str> = table.keys().map(String::as_str).collect();
    keys.sort_unstable();
    match keys[..] {
        ["percentile"] => Ok(ColorRange::Percentile(percentile("percentile")?)),
        ["union"] => Ok(ColorRange::Union { percentile: percentile("union")?, hysteresis: HYSTERESIS }),
        ["hysteresis", "union"] => {
            let part = number(&table["hysteresis"]).filter(|part| (0.0..=10.0).contains(part));
            let wrong = || bad(format!("hysteresis = {}, expected 0 to 10", table["hysteresis"]));
            let hysteresis = part.ok_or_else(wrong)?;
            Ok(ColorRange::Union { percentile: percentile("union")?, hysteresis })
        }
        _ => {
            let wish = "expected percentile, or union with or without hysteresis";
            Err(bad(format!("keys {}: {wish}", keys.join(", "))))
        }
    }
}

/// Two finite numbers.
fn pair(value: &Value) -> Option<[f64; 2]> {
    let [low, high] = value.as_array()?.as_slice() else { return None };
    Some([number(low)?, number(high)?])
}

fn number(value: &Value) -> Option<f64> {
    let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    number.filter(|number| number.is_finite())
}
