//! Coloured layers.

use super::paint::{PaintKeys, paint};
use super::place::{RawLayer, level};
use super::text::Text;
use super::transfer::RawTransfer;
use crate::scenery::{Level, Surface};
use icoray_grid::Result;
use serde::Deserialize;
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawSurface {
    layer: Option<Spanned<RawLayer>>,
    height_m: Option<Spanned<f64>>,
    color: Option<Spanned<String>>,
    field: Option<Spanned<String>>,
    transfer: Option<Spanned<RawTransfer>>,
    shading: Option<Spanned<Shading>>,
    opacity: Option<Spanned<f64>>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Shading {
    Smooth,
    Cells,
}

pub(super) fn surface(source: &Text, raw: &Spanned<RawSurface>) -> Result<Surface> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let at = level(source, ("layer", raw.layer.as_ref()), raw.height_m.as_ref())?.unwrap_or(Level::Layer(0));
    if let (Some(shading), Some(_)) = (&raw.shading, &raw.color) {
        return Err(source.bad(shading.span(), "shading", "is valid only with field, not with color"));
    }
    let keys = PaintKeys {
        color: raw.color.as_ref(),
        field: ("field", raw.field.as_ref()),
        default_field: "",
        transfer: raw.transfer.as_ref(),
        by_cell: raw.shading.as_ref().is_some_and(|shading| *shading.get_ref() == Shading::Cells),
    };
    Ok(Surface { at, paint: paint(source, span, &keys)?, opacity: source.opacity(raw.opacity.as_ref())? })
}
