//! Colours of surfaces: one, or by a field's values.

use super::text::Text;
use super::transfer::{Gives, RawTransfer, transfer_function};
use crate::scenery::Paint;
use icoray_grid::Result;
use std::ops::Range;
use toml::Spanned;

/// The keys of a paint, where they are given.
pub(super) struct PaintKeys<'r> {
    pub color: Option<&'r Spanned<String>>,
    /// The name of the field's key.
    pub field_key: &'static str,
    pub field: Option<&'r Spanned<String>>,
    /// The field where that key is absent; "" is the scene's first one.
    pub default_field: &'r str,
    pub transfer: Option<&'r Spanned<RawTransfer>>,
    pub by_cell: bool,
}

/// The paint of a section that stands at `span`: of a colour, or of a field's values.
pub(super) fn paint(source: &Text, span: Range<usize>, keys: &PaintKeys) -> Result<Paint> {
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
