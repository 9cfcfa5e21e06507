//! The transfer function, by its knots or by a colour map with opacities.

use super::text::Text;
use crate::coloring::{Coloring, MEANINGLESS};
use crate::keys::{Key, Kind, flag, keys, number, of, sections_of, word};
use crate::transfer::{self, Knot, TransferFunction};
use crate::values::ALONE;
use icoray_grid::{Result, numbers};
use std::ops::Range;
use toml::Spanned;

mod map;

keys! {
    pub(super) struct RawTransfer {
        /// Path length, planet radii after exaggeration, that has the opacities stated.
        unit_length: Option<Spanned<f64>> = UNIT_LENGTH,
        /// Colour and opacity at values, linear in between; see [knots](#knots).
        knots: Option<Spanned<Vec<Spanned<RawKnot>>>> = sections_of(&[RawKnot::KEYS]).count(1, 4096),
        /// Colour map, any case; `_r` at the end reverses it.
        map: Option<Spanned<String>> =
            of(Kind::Text).or_else("`\"viridis\"`; `\"vik\"` with `center`").note("108 names"),
        /// Reverses the map.
        reverse: bool = flag(false),
        /// Values at the ends of the map, or a table of how they follow the data.
        range: Option<Spanned<toml::Value>> = map::RANGE,
        /// Scale along which the map runs.
        scale: Option<Spanned<String>> = word(&["linear", "log", "symlog"]).or_word("linear"),
        /// The value on either side of 0 up to which the scale is linear.
        threshold: Option<Spanned<f64>> = number(ALONE.range).or_else("required with `\"symlog\"`"),
        /// The value at the map's middle; the range is widened to be even about it.
        center: Option<Spanned<f64>> = of(Kind::Number).note("positive with `\"log\"`"),
        /// Opacity at values, linear in extinction in between.
        opacity: Option<Spanned<Vec<Spanned<[f64; 2]>>>> = OPACITIES
            .or_else("`[[0, 0], [1, 0.9]]`, with `center` `[[0, 0.9], [0.5, 0], [1, 0.9]]`, in parts of the range"),
        /// Whether the first number of each pair of `opacity` is a value or a part of the range, 0 to 1.
        opacity_in: Option<Spanned<String>> =
            word(&["values", "range"]).or_else("`\"values\"` for a fixed range, else `\"range\"`"),
    }
}

keys! {
    struct RawKnot {
        /// Value of the field; two knots may have the same, which makes a step.
        value: Option<Spanned<f64>> = of(Kind::Number).required().note("rising"),
        /// Colour.
        color: Option<Spanned<String>> = of(Kind::Color(&[])).required(),
        /// Opacity of a `unit_length`; either this or `extinction`.
        opacity: Option<Spanned<f64>> = number(0.0..=1.0).below(1.0),
        /// Extinction per `unit_length`.
        extinction: Option<Spanned<f64>> = number(0.0..=1e12),
    }
}

/// The keys of a transfer function.
pub(super) const KEYS: &[&[Key]] = &[RawTransfer::KEYS];
pub(super) const UNIT_LENGTH: Key = number(1e-12..=1e6).or_else("the shell's thickness");
pub(super) const OPACITIES: Key = of(Kind::List(&Kind::Vector(&["value", "opacity"])))
    .count(1, 4096)
    .note("values rising, opacities from 0 to below 1");

/// The properties that a transfer function defines.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Gives {
    /// Colours and opacities.
    All,
    /// Colours alone; the text says where the opacity is defined.
    Colors(&'static str),
}

/// The transfer function, and what it is made of where that is a map.
pub(super) fn transfer_function(
    source: &Text,
    raw: &Spanned<RawTransfer>,
    gives: Gives,
) -> Result<(TransferFunction, Option<Coloring>)> {
    let (span, raw) = (raw.span(), raw.get_ref());
    if let Gives::Colors(elsewhere) = gives {
        refuse_opacity(source, raw, elsewhere)?;
    }
    let unit_length = source.optional_number(raw.unit_length.as_ref(), "transfer.unit_length")?;
    let Some(knots) = &raw.knots else {
        let coloring = map::coloring(source, raw, span, unit_length, gives)?;
        // Over a placeholder range until a renderer resolves it.
        let transfer = coloring.transfer(coloring.fixed().unwrap_or_else(|| coloring.unknown()));
        return Ok((transfer, Some(coloring)));
    };
    if raw.map.is_some() {
        return Err(source.bad(span, "transfer", "expected either knots or map, not both"));
    }
    let has_more = [&raw.scale, &raw.opacity_in].iter().any(|key| key.is_some())
        || [&raw.threshold, &raw.center].iter().any(|key| key.is_some());
    if raw.range.is_some() || raw.opacity.is_some() || raw.reverse || has_more {
        let what = "range, scale, center, opacity and reverse are valid only with map, not with knots";
        return Err(source.bad(span, "transfer", what));
    }
    let span = knots.span();
    let raw = knots.get_ref();
    let knots = raw.iter().map(|k| knot(source, k, gives)).collect::<Result<Vec<Knot>>>()?;
    let values = knots.iter().zip(raw).map(|(knot, raw)| (knot.value, raw.span()));
    check_rising(source, values, span, "transfer.knots")?;
    Ok((TransferFunction { knots, unit_length }, None))
}

/// Refuses the keys of opacity where it is defined elsewhere.
fn refuse_opacity(source: &Text, raw: &RawTransfer, elsewhere: &str) -> Result<()> {
    let refused = [
        ("transfer.opacity", raw.opacity.as_ref().map(Spanned::span)),
        ("transfer.opacity_in", raw.opacity_in.as_ref().map(Spanned::span)),
        ("transfer.unit_length", raw.unit_length.as_ref().map(Spanned::span)),
    ];
    let knots = raw.knots.iter().flat_map(|knots| knots.get_ref()).map(Spanned::get_ref);
    let of_knots = knots.filter_map(|knot| {
        let opacity = knot.opacity.as_ref().map(|opacity| ("transfer.knots.opacity", Some(opacity.span())));
        opacity.or(knot.extinction.as_ref().map(|e| ("transfer.knots.extinction", Some(e.span()))))
    });
    match refused.into_iter().chain(of_knots).find_map(|(key, span)| Some((key, span?))) {
        Some((key, span)) => Err(source.bad(span, key, format!("expected colours alone, as {elsewhere}"))),
        None => Ok(()),
    }
}

/// Extinctions by values or places.
pub(super) fn stops(source: &Text, raw: &Spanned<Vec<Spanned<[f64; 2]>>>, key: &str) -> Result<Vec<(f64, f64)>> {
    let spans = raw.get_ref().iter().map(|pair| (pair.get_ref()[0], pair.span()));
    check_rising(source, spans, raw.span(), key)?;
    let stop = |pair: &Spanned<[f64; 2]>| {
        let [place, opacity] = *pair.get_ref();
        Ok((place, opacity_to_extinction(source, opacity, pair.span(), key)?))
    };
    raw.get_ref().iter().map(stop).collect()
}

fn check_rising(
    source: &Text,
    values: impl Iterator<Item = (f64, Range<usize>)>,
    whole: Range<usize>,
    key: &str,
) -> Result<()> {
    let values: Vec<_> = values.collect();
    source.expect_count(values.len(), whole, key)?;
    if let Some((v, span)) = values.iter().find(|(v, _)| !v.is_finite()) {
        return Err(source.bad(span.clone(), key, format!("value {}, expected a finite number", numbers::text(*v))));
    }
    for (value, span) in &values {
        source.in_magnitudes(*value, span.clone(), key, &ALONE)?;
    }
    for (i, pair) in values.windows(2).enumerate() {
        let falls = pair[1].0 < pair[0].0;
        let third = pair[1].0 == pair[0].0 && i > 0 && values[i - 1].0 == pair[0].0;
        if falls || third {
            let wish = if third { "at most two knots on one value" } else { "values that rise" };
            return Err(source.bad(
                pair[1].1.clone(),
                key,
                format!("{} after {}, expected {wish}", numbers::text(pair[1].0), numbers::text(pair[0].0)),
            ));
        }
    }
    Ok(())
}

fn knot(source: &Text, raw: &Spanned<RawKnot>, gives: Gives) -> Result<Knot> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let (Some(value), Some(color)) = (&raw.value, &raw.color) else {
        return Err(source.bad(span, "transfer.knots", "expected value and color in each knot"));
    };
    let extinction = match (&raw.opacity, &raw.extinction) {
        (Some(opacity), None) => {
            opacity_to_extinction(source, *opacity.get_ref(), opacity.span(), "transfer.knots.opacity")?
        }
        (None, Some(e)) => source.number(Some(e), "transfer.knots.extinction")?,
        (None, None) if gives != Gives::All => MEANINGLESS,
        _ => {
            return Err(source.bad(span, "transfer.knots", "expected either opacity or extinction in each knot"));
        }
    };
    Ok(Knot { value: *value.get_ref(), color: source.color(color, "transfer.knots.color")?, extinction })
}

fn opacity_to_extinction(source: &Text, opacity: f64, span: Range<usize>, key: &str) -> Result<f64> {
    let schema = source.schema("transfer.knots.opacity");
    if schema.contains(opacity) {
        return Ok(transfer::extinction_of(opacity));
    }
    let why = "1 would need endless extinction; knots take extinction instead";
    let what = format!("opacity {}, expected a number {} ({why})", numbers::text(opacity), schema.bounds_text());
    Err(source.bad(span, key, what))
}
