//! Volumes: the short form of one of them, and the list of several.

use super::transfer::{Gives, RawTransfer, stops, transfer_function};
use super::{RawScene, Text};
use crate::error::Result;
use crate::scene::{Ground, Knot, Opacity, Scenery, TransferFunction, Volume};
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawVolume {
    field: Spanned<String>,
    transfer: Spanned<RawTransfer>,
    opacity: Option<Spanned<RawOpacity>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawOpacity {
    field: Spanned<String>,
    values: Spanned<Vec<Spanned<[f64; 2]>>>,
    unit_length: Option<Spanned<f64>>,
}

/// The volumes, in the scene's order; there may be none.
pub(super) fn volumes(source: Text, raw: &RawScene) -> Result<Vec<Volume>> {
    if raw.volumes.is_empty() {
        return short(source, raw);
    }
    let strays: [(&str, Option<Range<usize>>); 3] = [
        ("field", raw.field.as_ref().map(Spanned::span)),
        ("transfer", raw.transfer.as_ref().map(Spanned::span)),
        ("opacity", raw.opacity.as_ref().map(Spanned::span)),
    ];
    if let Some((key, span)) = strays.into_iter().find_map(|(key, span)| Some((key, span?))) {
        let what = "expected either field and [transfer] of one volume, or [[volumes]], not both";
        return Err(source.bad(span, key, what));
    }
    let source = source.within("volumes.");
    let volume = |raw: &Spanned<RawVolume>| {
        let RawVolume { field, transfer, opacity } = raw.get_ref();
        volume(&source, field, transfer, opacity.as_ref())
    };
    raw.volumes.iter().map(volume).collect()
}

/// The volume of a scene that has one.
fn short(source: Text, raw: &RawScene) -> Result<Vec<Volume>> {
    match (&raw.field, &raw.transfer, &raw.opacity) {
        (Some(field), Some(transfer), opacity) => {
            Ok(vec![volume(&source, field, transfer, opacity.as_ref())?])
        }
        (None, Some(transfer), _) => Err(source.bad(transfer.span(), "transfer", "expected field beside it")),
        (_, None, Some(opacity)) => {
            Err(source.bad(opacity.span(), "opacity", "expected field and [transfer] beside it"))
        }
        (_, None, None) => Ok(Vec::new()),
    }
}

fn volume(
    source: &Text,
    field: &Spanned<String>,
    transfer: &Spanned<RawTransfer>,
    opacity: Option<&Spanned<RawOpacity>>,
) -> Result<Volume> {
    let field = source.name(field, "field")?;
    let gives = opacity.map_or(Gives::All, |_| Gives::Colors("the opacity is that of another field"));
    let (transfer, coloring) = transfer_function(source, transfer, gives)?;
    let opacity = opacity.map(|raw| self::opacity(source, raw.get_ref())).transpose()?;
    Ok(Volume { field, transfer, coloring, opacity })
}

fn opacity(source: &Text, raw: &RawOpacity) -> Result<Opacity> {
    let unit_length = raw.unit_length.as_ref();
    let unit_length =
        unit_length.map(|u| source.number(Some(u), "opacity.unit_length", 1e-12, 1e6, 0.0)).transpose()?;
    let stops = stops(source, &raw.values, "opacity.values")?;
    let knots = stops.into_iter().map(|(value, extinction)| Knot { value, color: [0.0; 3], extinction });
    let transfer = TransferFunction { knots: knots.collect(), unit_length };
    Ok(Opacity { field: source.name(&raw.field, "opacity.field")?, transfer })
}

/// What stands for the first volume where there is none: the first field that is shown, clear.
pub(super) fn none(source: Text, raw: &RawScene, scenery: &Scenery) -> Result<Volume> {
    let shows = !(scenery.surfaces.is_empty() && scenery.isosurfaces.is_empty() && scenery.lines.is_empty())
        || scenery.ground != Ground::default();
    let field = match &raw.field {
        Some(field) if shows => source.name(field, "field")?,
        Some(field) => {
            let what =
                "expected [transfer] beside it, or [[surfaces]], [[isosurfaces]], [[lines]] or [ground]";
            return Err(source.bad(field.span(), "field", what));
        }
        None => first_shown(scenery).ok_or_else(|| {
            let what = match shows {
                true => "expected field, whose layers count where no field is shown",
                false => "expected field and [transfer], or [[volumes]], [[surfaces]] or [[isosurfaces]]",
            };
            source.bad(0..0, "field", what)
        })?,
    };
    let clear = Knot { value: 0.0, color: [0.0; 3], extinction: 0.0 };
    let transfer = TransferFunction { knots: vec![clear], unit_length: None };
    Ok(Volume { field, transfer, coloring: None, opacity: None })
}

fn first_shown(scenery: &Scenery) -> Option<String> {
    let mut first = None;
    scenery.shown_fields(&mut |field| first = first.or(Some(field)));
    first.map(str::to_owned)
}
