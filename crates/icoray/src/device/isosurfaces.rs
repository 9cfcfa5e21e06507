//! Isosurfaces for a device.

use super::fields::{FieldTable, Normal};
use super::{FieldId, Span};
use icoray_grid::array::MapInline;
use icoray_kernel::general;
use icoray_kernel::transfer::Spans;

/// A surface on which a field has one value.
#[derive(Debug, Clone, PartialEq)]
pub struct Isosurface {
    /// The field.
    pub field: FieldId,
    /// The value, normalised as the field.
    pub value: f32,
    /// The part of the light behind that is absorbed.
    pub opacity: f32,
    /// The colours.
    pub paint: IsosurfacePaint,
}

/// Colours of an isosurface.
#[derive(Debug, Clone, PartialEq)]
pub enum IsosurfacePaint {
    /// One colour, linear RGB.
    Plain([f32; 3]),
    /// The colours of a field's values.
    Field(ColorByField),
}

/// Colours of a field's values.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorByField {
    /// The field.
    pub field: FieldId,
    /// The transfer function, of which only the colours are used.
    pub spans: Vec<Span>,
    /// From the field's normalised value to that of the spans: factor and summand.
    pub to_spans: [f32; 2],
}

impl ColorByField {
    /// The colours of a transfer function.
    pub(super) fn new(
        map: &general::TransferMap,
        fields: &mut FieldTable,
        range: &impl Fn(usize) -> Option<[f64; 2]>,
    ) -> Self {
        let field = fields.of_source(map.source, range);
        let Normal { low, width, .. } = *fields.normal(field);
        let to_spans = [(width * map.scale()) as f32, map.normal(low) as f32];
        ColorByField { field, spans: Spans::new(map.knots()).all().to_vec(), to_spans }
    }
}

impl Isosurface {
    /// An isosurface of the kernel's scene; `range` returns the least and the greatest value of each field.
    pub(super) fn new(
        surface: &general::Isosurface,
        fields: &mut FieldTable,
        range: &impl Fn(usize) -> Option<[f64; 2]>,
    ) -> Self {
        let field = fields.of_source(surface.source, range);
        let value = fields.normal(field).of(surface.value) as f32;
        let paint = match &surface.material {
            general::Material::Plain(color) => IsosurfacePaint::Plain(color.map_inline(|c| c as f32)),
            general::Material::By { map, .. } => IsosurfacePaint::Field(ColorByField::new(map, fields, range)),
        };
        Isosurface { field, value, opacity: surface.opacity as f32, paint }
    }
}
