//! Answers to questions of the live view from a dataset.

use crate::dataset::Dataset;
use crate::drawing::Drawing;
use crate::field::FieldInfo;
use crate::layer_selection::LayerSelection;
use crate::native_height_cache::NativeHeightCache;
use crate::scene_fields::Key;
use icoray::output::printed_units;
use icoray::{Field, Frame, Ranks, Renderer, Result, Scene};
use icoray_live::{Histogram, Probe};
use std::collections::BTreeMap;

/// The typeset units of a field.
pub fn units(info: &FieldInfo) -> Option<String> {
    info.description.units.as_deref().and_then(printed_units)
}

/// The histogram of a field at a time; the field is read unless `read` contains it.
///
/// # Errors
/// As [`Dataset::read_layers`] and [`Renderer::histogram`].
pub fn histogram(
    name: &str,
    (dataset, time): (&Dataset, usize),
    layers_wanted: &LayerSelection,
    read: &BTreeMap<Key, Field>,
    renderer: &Renderer,
) -> Result<Histogram> {
    let info = dataset.field_info(name)?;
    let counted = |field: &Field| renderer.histogram(&mut Ranks::alone(), field, None, Histogram::FINE_BINS);
    let found = match read.iter().find(|((known, _), _)| known == name) {
        Some((_, field)) => counted(field)?,
        None => counted(&dataset.read_layers(name, time, layers_wanted.of(info)?)?.field()?)?,
    };
    Ok(Histogram::new(name, units(info), found))
}

/// The probe of a ray of a scene's picture at a place; `shown` is that picture.
///
/// # Errors
/// As [`Drawing::fields`] and [`Renderer::probe`].
pub fn probe(
    (scene, at): (&Scene, [f64; 2]),
    dataset: &Dataset,
    drawing: &Drawing,
    (fields, heights): (&BTreeMap<Key, Field>, &NativeHeightCache),
    shown: Option<&Frame>,
) -> Result<Option<Probe>> {
    let layers = drawing.scene_fields.layers(scene)?;
    let given = drawing.fields(scene, fields, heights)?;
    let found = drawing.renderer.probe(scene, drawing.grid, layers, given, at)?;
    Ok(found.map(|found| {
        let units = dataset.field_info(&found.field).ok().and_then(units);
        Probe::new(found, units, at, shown)
    }))
}
