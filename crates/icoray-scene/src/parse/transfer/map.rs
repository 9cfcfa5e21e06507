//! A colour map, its scale, its range and its opacities.

use super::{Gives, RawTransfer, stops};
use crate::color::{ColorMap, color_maps};
use crate::coloring::{ColorRange, Coloring, MEANINGLESS, Scale, default_extinction};
use crate::keys::{self, Key, Kind, keys, of};
use crate::parse::hint;
use crate::parse::text::{Text, shown};
use crate::values::ALONE;
use icoray_grid::{Result, numbers};
use std::ops::Range;
use toml::{Spanned, Value};

/// The map where none is named, for people of any sight: the second where values lie about a centre.
const DEFAULT_MAPS: [&str; 2] = ["viridis", "vik"];
/// The percentiles of the first frame that are the ends of a range where none is given.
const PERCENTILES: [f64; 2] = [1.0, 99.0];

/// The key `range`.
pub(super) const RANGE: Key = Key {
    parts: &[keys! {
        /// Percentiles of the first frame that has values.
        percentile = of(ENDS).within(0.0..=100.0),
        /// Percentiles of all frames so far.
        union = of(ENDS).within(0.0..=100.0),
        /// With `union`: part of the range by which an end moves further than a frame needs.
        hysteresis = keys::number(0.0..=10.0).or(0.1),
    }],
    ..of(Kind::Either(&ENDS, &Kind::Table)).or_toml("{ percentile = [1, 99] }").note("low < high")
};
const ENDS: Kind = Kind::Vector(&["low", "high"]);

pub(super) fn coloring(
    source: &Text,
    raw: &RawTransfer,
    span: Range<usize>,
    unit_length: Option<f64>,
    gives: Gives,
) -> Result<Coloring> {
    let at = raw.map.as_ref().map_or(span.clone(), Spanned::span);
    let default = DEFAULT_MAPS[usize::from(raw.center.is_some())];
    let name = raw.map.as_ref().map_or(default, |map| map.get_ref());
    let map = ColorMap::named(name).ok_or_else(|| {
        source.bad(
            at,
            "transfer.map",
            format!(
                "{name:?}{}, expected one of {}, or one with _r behind it",
                hint::did_you_mean(name, color_maps().split(", ")),
                color_maps()
            ),
        )
    })?;
    let scale = scale(source, raw)?;
    let range = match &raw.range {
        Some(ends) => range(source, ends, scale)?,
        None => ColorRange::Percentile(PERCENTILES),
    };
    let center = center(source, raw, scale)?;
    let (is_relative, extinction) = match (&raw.opacity, gives) {
        (Some(opacity), _) => {
            let is_relative = is_relative(source, raw, range)?;
            let extinction = stops(source, opacity, "transfer.opacity")?;
            if !is_relative && let Some(pair) = opacity.get_ref().iter().find(|p| !scale.admits(p.get_ref()[0])) {
                let value = numbers::text(pair.get_ref()[0]);
                let what = format!("value {value}, expected a positive one on a log scale");
                return Err(source.bad(pair.span(), "transfer.opacity", what));
            }
            (is_relative, extinction)
        }
        (None, _) if raw.opacity_in.is_some() => {
            let span = raw.opacity_in.as_ref().map_or(span, Spanned::span);
            return Err(source.bad(span, "transfer.opacity_in", "is valid only with opacity"));
        }
        (None, Gives::All) => (true, default_extinction(center.is_some())),
        (None, Gives::Colors(_)) => (true, vec![(0.0, MEANINGLESS)]),
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
    let linear = Spanned::new(0..0, "linear".to_owned());
    let (word, key) = (raw.scale.as_ref().unwrap_or(&linear), "transfer.threshold");
    match (word.get_ref().as_str(), &raw.threshold) {
        ("symlog", Some(threshold)) => Ok(Scale::SymLog { threshold: source.number(Some(threshold), key)? }),
        ("symlog", None) => {
            let what = "\"symlog\" needs threshold, the value on either side of 0 up to which it is linear";
            Err(source.bad(word.span(), "transfer.scale", what))
        }
        (_, Some(stray)) => Err(source.bad(stray.span(), key, "is valid only with scale = \"symlog\"")),
        ("linear", None) => Ok(Scale::Linear),
        ("log", None) => Ok(Scale::Log),
        _ => Err(source.unknown_word(word, "transfer.scale")),
    }
}

fn center(source: &Text, raw: &RawTransfer, scale: Scale) -> Result<Option<f64>> {
    let Some(center) = &raw.center else { return Ok(None) };
    let value = source.value(center, "transfer.center", &ALONE)?;
    if scale.admits(value) {
        return Ok(Some(value));
    }
    Err(source.bad(
        center.span(),
        "transfer.center",
        format!("{}, expected a positive one on a log scale", numbers::text(value)),
    ))
}

/// Whether opacities are given along the range: as the scene says, and else where that follows the data.
fn is_relative(source: &Text, raw: &RawTransfer, range: ColorRange) -> Result<bool> {
    let Some(word) = &raw.opacity_in else { return Ok(!matches!(range, ColorRange::Fixed(_))) };
    match word.get_ref().as_str() {
        "values" => Ok(false),
        "range" => Ok(true),
        _ => Err(source.unknown_word(word, "transfer.opacity_in")),
    }
}

/// Two numbers, or what of the data they come from.
fn range(source: &Text, raw: &Spanned<Value>, scale: Scale) -> Result<ColorRange> {
    let key = "transfer.range";
    let bad = |what: String| source.bad(raw.span(), key, what);
    let Value::Table(table) = raw.get_ref() else {
        let ends = pair(raw.get_ref()).filter(|[low, high]| low < high);
        let wish = "expected two finite numbers, the lower first, { percentile = [1, 99] } or { union = [1, 99] }";
        let ends = ends.ok_or_else(|| bad(format!("{}, {wish}", shown(raw.get_ref()))))?;
        for end in ends {
            source.in_magnitudes(end, raw.span(), key, &ALONE)?;
        }
        if scale == Scale::Log && ends[0] <= 0.0 {
            let wish = "expected two positive numbers on a log scale, the lower first";
            return Err(bad(format!("{}, {wish}", numbers::list(&ends))));
        }
        return Ok(ColorRange::Fixed(ends));
    };
    let part = |key: &str| source.schema(&format!("transfer.range.{key}"));
    let percentile = |key: &str| {
        let (value, schema) = (table.get(key), part(key));
        let ends =
            value.and_then(pair).filter(|[low, high]| schema.contains(*low) && low < high && schema.contains(*high));
        let found = value.map_or_else(String::new, |value| format!("{key} = {}, ", shown(value)));
        let wish = format!("expected two percentiles {}, the lower first", schema.bounds_text());
        ends.ok_or_else(|| bad(format!("{found}{wish}")))
    };
    let mut given: Vec<&str> = table.keys().map(String::as_str).collect();
    given.sort_unstable();
    match given[..] {
        ["percentile"] => Ok(ColorRange::Percentile(percentile("percentile")?)),
        ["union"] | ["hysteresis", "union"] => {
            let given = table.get("hysteresis").map(|value| {
                let valid = number(value).filter(|value| part("hysteresis").contains(*value));
                let wish = || format!("expected {}", part("hysteresis").bounds_text());
                valid.ok_or_else(|| bad(format!("hysteresis = {}, {}", shown(value), wish())))
            });
            let hysteresis = given.transpose()?.unwrap_or_else(|| part("hysteresis").default_number());
            Ok(ColorRange::Union { percentile: percentile("union")?, hysteresis })
        }
        _ => {
            let wish = "expected percentile, or union with or without hysteresis";
            Err(bad(format!("keys {}: {wish}", given.join(", "))))
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
