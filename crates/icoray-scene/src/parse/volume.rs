//! Volumes: the short form of one of them, and the list of several.

use super::text::Text;
use super::transfer::{self, Gives, OPACITIES, RawTransfer, UNIT_LENGTH, stops, transfer_function};
use super::{RawScene, each};
use crate::keys::{Kind, keys, of, section};
use crate::scenery::{Opacity, Scenery, Volume};
use crate::transfer::{Knot, TransferFunction};
use icoray_grid::Result;
use std::ops::Range;
use toml::Spanned;

keys! {
    pub(super) struct RawVolume {
        /// Field of the volume.
        field: Option<Spanned<String>> = of(Kind::Text).or_else("the first volume's; of that the first field"),
        /// As `[transfer]`.
        transfer: Option<Spanned<RawTransfer>> = section(transfer::KEYS).or_else("a map with all defaults"),
        /// As `[opacity]`.
        opacity: Option<Spanned<RawOpacity>> = section(&[RawOpacity::KEYS]),
    }
}

keys! {
    pub(super) struct RawOpacity {
        /// Field of the opacity.
        field: Option<Spanned<String>> = of(Kind::Text).or_else("the volume's"),
        /// Opacity at values of that field.
        values: Option<Spanned<Vec<Spanned<[f64; 2]>>>> = OPACITIES.required(),
        /// As in `[transfer]`.
        unit_length: Option<Spanned<f64>> = UNIT_LENGTH,
    }
}

/// The volumes, in the scene's order; there may be none.
pub(super) fn volumes(source: &Text, raw: &RawScene) -> Result<Vec<Volume>> {
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
    each(source, "volumes", &raw.volumes, |source, raw| {
        let RawVolume { field, transfer, opacity } = raw.get_ref();
        volume(source, raw.span(), field.as_ref(), transfer.as_ref(), opacity.as_ref())
    })
}

/// The volume of a scene that has one: by its keys, or because nothing else is shown.
fn short(source: &Text, raw: &RawScene) -> Result<Vec<Volume>> {
    let has_more =
        !(raw.surfaces.is_empty() && raw.isosurfaces.is_empty() && raw.lines.is_empty()) || raw.ground.is_some();
    if raw.transfer.is_none() && raw.opacity.is_none() && has_more {
        return Ok(Vec::new());
    }
    Ok(vec![volume(source, 0..0, raw.field.as_ref(), raw.transfer.as_ref(), raw.opacity.as_ref())?])
}

fn volume(
    source: &Text,
    span: Range<usize>,
    field: Option<&Spanned<String>>,
    transfer: Option<&Spanned<RawTransfer>>,
    opacity: Option<&Spanned<RawOpacity>>,
) -> Result<Volume> {
    let field = source.name_or_first(field, "field")?;
    let gives = opacity.map_or(Gives::All, |_| Gives::Colors("the opacity is that of another field"));
    let absent = Spanned::new(span, RawTransfer::default());
    let (transfer, coloring) = transfer_function(source, transfer.unwrap_or(&absent), gives)?;
    let opacity = opacity.map(|raw| self::opacity(source, raw, &field)).transpose()?;
    Ok(Volume { field, transfer, coloring, opacity })
}

/// The opacity of a volume of `field`, which is the opacity's too where it names none.
fn opacity(source: &Text, raw: &Spanned<RawOpacity>, field: &str) -> Result<Opacity> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let unit_length = source.optional_number(raw.unit_length.as_ref(), "opacity.unit_length")?;
    let Some(values) = &raw.values else {
        return Err(source.bad(span, "opacity.values", "is absent, expected pairs [value, opacity]"));
    };
    let stops = stops(source, values, "opacity.values")?;
    let knots = stops.into_iter().map(|(value, extinction)| Knot { value, color: [0.0; 3], extinction });
    let transfer = TransferFunction { knots: knots.collect(), unit_length };
    let named = raw.field.as_ref().map(|field| source.name(field, "opacity.field")).transpose()?;
    Ok(Opacity { field: named.unwrap_or_else(|| field.to_owned()), transfer })
}

/// The volume of a scene that shows none: of the scene's field or the first that is shown, transparent.
pub(super) fn none(source: &Text, raw: &RawScene, scenery: &Scenery) -> Result<Volume> {
    let named = raw.field.as_ref().map(|field| source.name(field, "field")).transpose()?;
    let first_shown = || scenery.shown_fields().find(|field| !field.is_empty()).map(str::to_owned);
    Ok(Volume::clear(named.or_else(first_shown).unwrap_or_default()))
}
