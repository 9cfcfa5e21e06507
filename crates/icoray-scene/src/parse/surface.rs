//! Coloured layers and isosurfaces, of which a section may have several values, and their colours.

use super::MAX_SECTIONS;
use super::place::{HEIGHT_M, RawLayer, level};
use super::text::Text;
use super::transfer::{self, Gives, RawTransfer, transfer_function};
use crate::keys::{Kind, keys, layer, number, of, section, word};
use crate::scenery::{Isosurface, Level, Paint, Surface};
use crate::values::SQUARED;
use icoray_grid::Result;
use serde::Deserialize;
use std::ops::Range;
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

keys! {
    pub(super) struct RawIsosurface {
        /// Field.
        field: Option<Spanned<String>> = of(Kind::Text).or_else("the scene's first"),
        /// Its value.
        value: Option<Spanned<f64>> = of(Kind::Number).or_else("required, or `values`").note(SQUARED.text),
        /// Several values.
        values: Option<Spanned<Vec<Spanned<f64>>>> =
            of(Kind::List(&Kind::Number)).or_else("required, or `value`").count(1, MAX_SECTIONS).note("as `value`"),
        /// One colour for all values.
        color: Option<Spanned<String>> = of(Kind::Color(&[])),
        /// A colour for each value.
        colors: Option<Spanned<Vec<Spanned<String>>>> =
            of(Kind::List(&Kind::Color(&[]))).note("as many as `values`"),
        /// Field that colours the surfaces, with `transfer`.
        color_by: Option<Spanned<String>> = of(Kind::Text).or_else("the surface's `field`"),
        /// As `[transfer]`, of colours only.
        transfer: Option<Spanned<RawTransfer>> = section(transfer::KEYS).or_else("a map with all defaults"),
        /// Part of the light that a surface absorbs.
        opacity: Option<Spanned<f64>> = number(0.0..=1.0).above(0.0).or(1.0),
    }
}

/// One for each value.
pub(super) fn isosurfaces(source: &Text, raw: &Spanned<RawIsosurface>) -> Result<Vec<Isosurface>> {
    let (span, raw) = (raw.span(), raw.get_ref());
    let field = source.name_or_first(raw.field.as_ref(), "field")?;
    let values = values(source, raw, span.clone())?;
    let paints = paints(source, raw, span, &field, values.len())?;
    let opacity = source.number(raw.opacity.as_ref(), "opacity")?;
    let isosurface = |(value, paint)| Isosurface { field: field.clone(), value, paint, opacity };
    Ok(values.into_iter().zip(paints).map(isosurface).collect())
}

fn values(source: &Text, raw: &RawIsosurface, span: Range<usize>) -> Result<Vec<f64>> {
    match (&raw.value, &raw.values) {
        (Some(value), None) => Ok(vec![source.value(value, "value", &SQUARED)?]),
        (None, Some(values)) => {
            source.expect_count(values.get_ref().len(), values.span(), "values")?;
            values.get_ref().iter().map(|value| source.value(value, "values", &SQUARED)).collect()
        }
        _ => Err(source.bad(span, "value", "expected either value or values")),
    }
}

/// As many as there are values.
fn paints(source: &Text, raw: &RawIsosurface, span: Range<usize>, field: &str, count: usize) -> Result<Vec<Paint>> {
    let Some(colors) = &raw.colors else {
        let keys = PaintKeys {
            color: raw.color.as_ref(),
            field_key: "color_by",
            field: raw.color_by.as_ref(),
            default_field: field,
            transfer: raw.transfer.as_ref(),
            by_cell: false,
        };
        return Ok(vec![paint(source, span, &keys)?; count]);
    };
    if raw.color.is_some() || raw.color_by.is_some() || raw.transfer.is_some() {
        let what = "expected one of color, colors and color_by";
        return Err(source.bad(colors.span(), "colors", what));
    }
    let found = colors.get_ref().len();
    if found != count {
        let what = format!("{found} colours, expected {count}, one for each of the values");
        return Err(source.bad(colors.span(), "colors", what));
    }
    colors.get_ref().iter().map(|color| Ok(Paint::Plain(source.color(color, "colors")?))).collect()
}

/// The keys of a paint, where they are given.
struct PaintKeys<'r> {
    color: Option<&'r Spanned<String>>,
    /// The name of the field's key.
    field_key: &'static str,
    field: Option<&'r Spanned<String>>,
    /// The field where that key is absent; "" is the scene's first one.
    default_field: &'r str,
    transfer: Option<&'r Spanned<RawTransfer>>,
    by_cell: bool,
}

/// The paint of a section that stands at `span`: of a colour, or of a field's values.
fn paint(source: &Text, span: Range<usize>, keys: &PaintKeys) -> Result<Paint> {
    let (key, field) = (keys.field_key, keys.field);
    match keys.color {
        Some(color) if field.is_none() && keys.transfer.is_none() => Ok(Paint::Plain(source.color(color, "color")?)),
        Some(color) => {
            let what = format!("expected either color, or {key} and transfer, not both");
            Err(source.bad(color.span(), "color", what))
        }
        None => {
            let gives = Gives::Colors("a surface has an opacity of its own");
            let absent = Spanned::new(span, RawTransfer::default());
            let (transfer, coloring) = transfer_function(source, keys.transfer.unwrap_or(&absent), gives)?;
            let field = field.map_or(Ok(keys.default_field.to_owned()), |field| source.name(field, key))?;
            Ok(Paint::Field { field, transfer, coloring, by_cell: keys.by_cell })
        }
    }
}
