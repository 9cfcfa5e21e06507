//! Fields of the host as arrays of the context.

use crate::blueprint::BlueprintField;
use crate::conduit::Array;
use crate::context::{Context, error};
use crate::grid::HostGrid;
use crate::order::{Layout, Order};
use icoray::{Error, ErrorKind, OwnedReals, Reals, Result, Shape};
use icoray_context::types::icoray_array;
use serde::{Deserialize, Serialize};

/// What a rank without elements must know of a field of other ranks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FieldKind {
    pub is_at_elements: bool,
    pub is_f64: bool,
}

/// A field that was copied, until the context has executed.
pub struct CopiedField {
    /// Column by column.
    pub values: OwnedReals,
    /// Why the host's values cannot be read in place.
    pub reason: &'static str,
}

/// Sets a field in place, or as a copy if `may_copy`, which is returned.
pub fn set(
    context: &Context,
    name: &str,
    field: &BlueprintField,
    on: &HostGrid,
    may_copy: bool,
) -> Result<Option<CopiedField>> {
    let BlueprintField { kind, values, .. } = field;
    let columns = on.columns_of(kind.is_at_elements);
    let layout = &columns.layout;
    let what = if kind.is_at_elements { "elements" } else { "points" };
    if values.len() != layout.elements {
        let message = format!("{} values, expected one for each of the {} {what}", values.len(), layout.elements);
        return Err(Error::new(ErrorKind::Field, message));
    }
    let reason = match in_place(values, layout) {
        Ok((first, shape)) => {
            given(context, name, &columns.values(kind.is_f64, first, &shape))?;
            return Ok(None);
        }
        Err(reason) => reason,
    };
    if !may_copy {
        return Err(Error::new(ErrorKind::Field, format!("its values {reason}, and the scene does not name it")));
    }
    let all = (0..layout.columns).flat_map(|column| (0..layout.layers).map(move |layer| (column, layer)));
    let all = all.map(|(column, layer)| values.real(layout.at(column, layer) as usize));
    let copy = match kind.is_f64 {
        true => OwnedReals::F64(all.collect()),
        false => OwnedReals::F32(all.map(|value| value as f32).collect()),
    };
    let data = match copy.as_reals() {
        Reals::F32(values) => values.as_ptr().cast(),
        Reals::F64(values) => values.as_ptr().cast(),
    };
    given(context, name, &columns.values(kind.is_f64, data, &Shape::level_fastest(layout.columns, layout.layers)))?;
    Ok(Some(CopiedField { values: copy, reason }))
}

/// Sets a field that other ranks have on a rank that has no elements.
pub fn set_empty(context: &Context, name: &str, kind: &FieldKind, on: &HostGrid) -> Result<()> {
    let columns = on.columns_of(kind.is_at_elements);
    let shape = Shape::level_fastest(0, columns.layout.layers);
    given(context, name, &columns.values(kind.is_f64, std::ptr::dangling(), &shape))
}

fn given(context: &Context, name: &str, values: &icoray_array) -> Result<()> {
    // SAFETY: values that the host and the adaptor keep until the context has executed.
    unsafe { context.set_field(name, values) }.map_err(error)
}

/// The first one of values that can be read where they are, and their shape from there, or why they cannot.
fn in_place(values: &Array, layout: &Layout) -> std::result::Result<(*const u8, Shape), &'static str> {
    let Order::InPlace(shape) = layout.order else { return Err("are in no order of columns") };
    let bytes = values.kind().bytes();
    let apart = values.stride() / bytes as isize;
    if values.kind().is_integer() {
        return Err("are integers");
    }
    let first = if values.is_empty() { std::ptr::dangling() } else { values.address(shape.offset) };
    if !first.addr().is_multiple_of(bytes) && !values.is_empty() || apart * bytes as isize != values.stride() {
        return Err("are not at multiples of their size in memory");
    }
    let [column_stride, layer_stride, block_stride] =
        [shape.column_stride, shape.layer_stride, shape.block_stride].map(|elements| elements * apart);
    Ok((first, Shape { offset: 0, column_stride, layer_stride, block_stride, ..shape }))
}
