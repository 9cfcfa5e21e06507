//! What is known of the fields of a script before the first picture.

use crate::input::Wanted;
use icoray::{Error, ErrorKind, Grid, Heights, Layers, Location, Result, Scene, Script};
use icoray_netcdf::{FieldInfo, LayerHeights, ModelFile};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// The layers of a field.
struct Stack {
    /// Heights have one more where the field's values lie between them.
    layers: Layers,
    /// How many the field has.
    count: usize,
    notes: Vec<String>,
}

/// Layers and notes of the scenes of a script.
pub struct Subjects<'a> {
    file: &'a ModelFile,
    /// By the name of the field whose layers they are, and whether columns have heights of their own.
    layers: HashMap<(String, bool), Stack>,
    /// What is done to fields, by their names.
    notes: HashMap<String, String>,
}

/// The model's field whose layers a scene is drawn on: the first one, or the first of which that is made.
pub fn lead(scene: &Scene) -> String {
    scene.model_fields().first().map_or_else(|| scene.field.clone(), |name| (*name).to_owned())
}

/// Whether columns have heights of their own.
pub fn is_native(scene: &Scene) -> bool {
    scene.scenery.heights == Heights::Native
}

/// What the layers of a scene are known by.
fn key(scene: &Scene) -> (String, bool) {
    (lead(scene), is_native(scene))
}

impl<'a> Subjects<'a> {
    /// Reads the layers of all scenes of the script.
    pub fn new(file: &'a ModelFile, script: &Script, wanted: &Wanted, grid: &Grid) -> Result<Self> {
        let mut subjects = Subjects { file, layers: HashMap::new(), notes: HashMap::new() };
        for name in script.views().iter().flat_map(|view| view.model_fields()) {
            let info = file.field_info(&name)?;
            if info.location == Location::Corner {
                let bytes = grid.cells() * wanted.of(info)?.len() * info.precision.bytes();
                let note =
                    format!("{name} lives on corners: averaged to cell centres (derived, {bytes} bytes)");
                subjects.notes.insert(name, note);
            }
        }
        for scene in script.views().iter().flat_map(|view| view.scenes()) {
            if let Entry::Vacant(place) = subjects.layers.entry(key(&scene)) {
                let info = file.field_info(&place.key().0)?;
                let heights = file.layer_heights(&info.name)?;
                let wanted_layers = wanted.of(info)?;
                let count = wanted_layers.len();
                place.insert(if is_native(&scene) {
                    let note = format!("columns have heights of their own: {}", native(file, info)?);
                    Stack { layers: heights.layers_over(info, wanted_layers)?, count, notes: vec![note] }
                } else {
                    Stack { layers: wanted.radii(&heights, info)?, count, notes: notes(&heights) }
                });
            }
        }
        Ok(subjects)
    }

    /// The layers of a scene.
    pub fn layers(&self, scene: &Scene) -> &Layers {
        &self.layers[&key(scene)].layers
    }

    /// How many layers its fields have.
    pub fn count(&self, scene: &Scene) -> usize {
        self.layers[&key(scene)].count
    }

    /// What is known of a scene's fields, that of its layers first.
    pub fn infos(&self, scene: &Scene) -> Result<Vec<&'a FieldInfo>> {
        scene.model_fields().into_iter().map(|name| self.file.field_info(name)).collect()
    }

    /// What is not drawn as the file has it.
    pub fn notes(&self, scene: &Scene) -> impl Iterator<Item = &String> {
        let of_fields = scene.model_fields().into_iter().filter_map(|name| self.notes.get(name));
        of_fields.chain(&self.layers[&key(scene)].notes)
    }

    /// The notes of all scenes, each once.
    pub fn all_notes(&self, script: &Script) -> Vec<&String> {
        let mut all: Vec<&String> = Vec::new();
        for scene in script.views().iter().flat_map(|view| view.scenes()) {
            for note in self.notes(&scene) {
                if !all.contains(&note) {
                    all.push(note);
                }
            }
        }
        all
    }
}

/// What heights of its own each column has.
fn native(file: &ModelFile, info: &FieldInfo) -> Result<String> {
    file.native_heights_in_words(&info.name)?.ok_or_else(|| {
        let context = format!(
            "heights = \"native\": the file has no heights of the columns of {}, expected zgrid, layerThickness or heights over \
             its layers and cells",
            info.name
        );
        Error::new(ErrorKind::Layers, context)
    })
}

fn notes(heights: &LayerHeights) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(deviation_m) = heights.deviation_m.filter(|deviation| *deviation > 0.0) {
        notes.push(format!(
            "concentric mean heights are rendered; columns deviate by up to {deviation_m:.1} m"
        ));
    }
    if heights.is_of_pressure {
        let name = &heights.variable;
        notes.push(format!("{name} gives pressures: rendered at the heights of the standard atmosphere"));
    }
    notes
}
