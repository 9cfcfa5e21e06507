//! Coloured layers.

use super::paint::{PaintKeys, paint};
use super::place::{HEIGHT_M, RawLayer, level};
use super::text::Text;
use super::transfer::{self, RawTransfer};
use crate::keys::{Kind, keys, layer, number, of, section, word};
use crate::scenery::{Level, Surface};
use icoray_grid::Result;
use serde::Deserialize;
use toml::Spanned;

keys! {
    pub(super) struct RawSurface {
        /// The layer; either this or `height_m`.
        layer: Option<Spanned<RawLayer>> = layer(&["top", "bottom"]).or_word("bottom"),
        /// Height above the planet's surface, metres; shown inside the shell only.
        height_m: Option<Spanned<f64>> = HEIGHT_M,
        /// One colour.
        color: Option<Spanned<String>> = of(Kind::Color(&[])),
        /// Field that colours the surface.
        field: Option<Spanned<String>> = of(Kind::Text).or_else("the scene's first"),
        /// As `[transfer]`, of colours only.
        transfer: Option<Spanned<RawTransfer>> = section(transfer::KEYS).or_else("a map with all defaults"),
        /// With `field`: interpolated, or one colour for each cell.
        shading: Option<Spanned<Shading>> = word(&["smooth", "cells"]).or_word("smooth"),
        /// Part of the light that the surface absorbs.
        opacity: Option<Spanned<f64>> = number(0.0..=1.0).above(0.0).or(1.0),
    }
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Shading {
    Smooth,
    Cells,
}

pub(super) fn surface(source: &Text, raw: &Spanned<RawSurface>) -> Result<Surface> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let at = level(source, "layer", raw.layer.as_ref(), raw.height_m.as_ref())?.unwrap_or(Level::Layer(0));
    if let (Some(shading), Some(_)) = (&raw.shading, &raw.color) {
        return Err(source.bad(shading.span(), "shading", "is valid only with field, not with color"));
    }
    let keys = PaintKeys {
        color: raw.color.as_ref(),
        field_key: "field",
        field: raw.field.as_ref(),
        default_field: "",
        transfer: raw.transfer.as_ref(),
        by_cell: raw.shading.as_ref().is_some_and(|shading| *shading.get_ref() == Shading::Cells),
    };
    Ok(Surface { at, paint: paint(source, span, &keys)?, opacity: source.number(raw.opacity.as_ref(), "opacity")? })
}
