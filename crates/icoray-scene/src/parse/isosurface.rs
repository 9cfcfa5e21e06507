//! Surfaces on which a field has one value: a section may have several values.

use super::MAX_SECTIONS;
use super::paint::{PaintKeys, paint};
use super::text::Text;
use super::transfer::{self, RawTransfer};
use crate::keys::{Kind, keys, number, of, section};
use crate::scenery::{Isosurface, Paint};
use crate::values::SQUARED;
use icoray_grid::Result;
use std::ops::Range;
use toml::Spanned;

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
