//! The transfer function, by its knots or by a colour map with opacities.

use super::Text;
use crate::error::Result;
use crate::scene::{Coloring, Knot, TransferFunction, transfer};
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

mod map;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTransfer {
    unit_length: Option<Spanned<f64>>,
    knots: Option<Spanned<Vec<Spanned<RawKnot>>>>,
    map: Option<Spanned<String>>,
    #[serde(default)]
    reverse: bool,
    range: Option<Spanned<toml::Value>>,
    scale: Option<Spanned<String>>,
    threshold: Option<Spanned<f64>>,
    center: Option<Spanned<f64>>,
    opacity: Option<Spanned<Vec<Spanned<[f64; 2]>>>>,
    opacity_in: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawKnot {
    value: f64,
    color: Spanned<String>,
    opacity: Option<Spanned<f64>>,
    extinction: Option<Spanned<f64>>,
}

/// The transfer function, and what it is made of where that is a map.
pub(super) fn transfer_function(
    source: &Text,
    raw: &Spanned<RawTransfer>,
) -> Result<(TransferFunction, Option<Coloring>)> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let unit_length = raw
        .unit_length
        .as_ref()
        .map(|u| source.number(Some(u), "transfer.unit_length", 1e-12, 1e6, 0.0))
        .transpose()?;
    let Some(knots) = &raw.knots else {
        let coloring = map::coloring(source, raw, span, unit_length)?;
        // Of a range that is not known yet, until a renderer knows it.
        let transfer = coloring.transfer(coloring.fixed().unwrap_or_else(|| coloring.unknown()));
        return Ok((transfer, Some(coloring)));
    };
    if raw.map.is_some() {
        return Err(source.bad(span, "transfer", "expected either knots, or map with range and opacity"));
    }
    let has_more = [&raw.scale, &raw.opacity_in].iter().any(|key| key.is_some())
        || [&raw.threshold, &raw.center].iter().any(|key| key.is_some());
    if raw.range.is_some() || raw.opacity.is_some() || raw.reverse || has_more {
        let what = "range, scale, center, opacity and reverse go with map, not with knots";
        return Err(source.bad(span, "transfer", what));
    }
    let spans = knots.get_ref().iter().map(|k| (k.get_ref().value, k.span()));
    check_rising(source, spans, knots.span(), "transfer.knots")?;
    let knots = knots.get_ref().iter().map(|k| knot(source, k)).collect::<Result<Vec<Knot>>>()?;
    Ok((TransferFunction { knots, unit_length }, None))
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
