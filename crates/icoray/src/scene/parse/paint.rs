//! Colours of surfaces: one, or by a field's values.

use super::Text;
use super::transfer::{Gives, RawTransfer, transfer_function};
use crate::error::Result;
use crate::scene::Paint;
use std::ops::Range;
use toml::Spanned;

/// The keys of a paint, where they are given.
pub(super) struct Keys<'r> {
    pub color: Option<&'r Spanned<String>>,
    /// The field, and what its key is called.
    pub field: (&'static str, Option<&'r Spanned<String>>),
    pub transfer: Option<&'r Spanned<RawTransfer>>,
    pub by_cell: bool,
}

/// The paint of a section that stands at `span`.
pub(super) fn paint(source: &Text, span: Range<usize>, keys: &Keys) -> Result<Paint> {
    match (keys.color, keys.field, keys.transfer) {
        (Some(color), (_, None), None) => Ok(Paint::Plain(source.color(color, "color")?)),
        (None, (key, Some(field)), Some(transfer)) => {
            let gives = Gives::Colors("a surface has an opacity of its own");
            let (transfer, coloring) = transfer_function(source, transfer, gives)?;
            let field = source.name(field, key)?;
            Ok(Paint::Field { field, transfer, coloring, by_cell: keys.by_cell })
        }
        (color, (key, _), _) => {
            let what = format!("expected either color, or {key} and a table transfer");
            Err(source.bad(color.map_or(span, Spanned::span), "color", what))
        }
    }
}
