//! Answers to questions of the live view from a file's data.

use crate::input::LayerSelection;
use crate::render::{Drawing, Key, NativeHeightCache};
use icoray::output::printed_units;
use icoray::{Field, Frame, Ranks, Renderer, Result, Scene};
use icoray_live::{Histogram, Probe};
use icoray_netcdf::{FieldInfo, ModelFile};
use std::collections::BTreeMap;

/// The units of a field, as print has them.
pub fn units(info: &FieldInfo) -> Option<String> {
    info.description.units.as_deref().and_then(printed_units)
}

/// The histogram of a field at a time; it is read where `read` lacks it.
pub fn histogram(
    name: &str,
    (file, time): (&ModelFile, usize),
    layers_wanted: &LayerSelection,
    read: &BTreeMap<Key, Field>,
    renderer: &Renderer,
) -> Result<Histogram> {
    let info = file.field_info(name)?;
    let counted = |field: &Field| renderer.histogram(&mut Ranks::alone(), field, None, Histogram::FINE_BINS);
    let found = match read.iter().find(|((known, _), _)| known == name) {
        Some((_, field)) => counted(field)?,
        None => counted(&file.read_layers(name, time, layers_wanted.of(info)?)?.field()?)?,
    };
    Ok(Histogram::new(name, units(info), found))
}

/// What a ray of a scene's picture shows at a place; `shown` is that picture.
pub fn probe(
    (scene, at): (&Scene, [f64; 2]),
    file: &ModelFile,
    drawing: &Drawing,
    (fields, heights): (&BTreeMap<Key, Field>, &NativeHeightCache),
    shown: Option<&Frame>,
) -> Result<Option<Probe>> {
    let layers = drawing.scene_fields.layers(scene)?;
    let given = drawing.fields(scene, fields, heights)?;
    let found = drawing.renderer.probe(scene, drawing.grid, layers, given, at)?;
    let field = scene.field().to_owned();
    let units = file.field_info(&field).ok().and_then(units);
    Ok(found.map(|found| Probe::new(found, (field, units), at, shown)))
}
