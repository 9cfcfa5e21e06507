//! What is known of the fields of a script before the first picture.

use super::due::Key;
use crate::input::Wanted;
use crate::layering::Layering;
use icoray::{Heights, Layers, Location, Result, Scene, Script, View};
use icoray_netcdf::{FieldInfo, LayerHeights, ModelFile, NativeInfo};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;

/// Layers and notes of the scenes of a script.
pub struct Subjects<'a> {
    file: &'a ModelFile,
    wanted: &'a Wanted,
    cells: usize,
    /// By [`Layering::key`].
    grounds: HashMap<[&'a str; 2], Ground>,
}

/// Where the layers of a scene lie.
struct Ground {
    layers: Layers,
    /// What the heights of each column are, where there are any.
    native: Option<NativeInfo>,
    /// How far columns deviate from mean heights.
    mean: Option<String>,
    notes: Vec<String>,
}

/// A field of a scene.
#[derive(Clone)]
pub struct Subject<'a> {
    pub info: &'a FieldInfo,
    /// Its layers that are read and drawn.
    pub range: Range<usize>,
}

impl Subject<'_> {
    /// What it is read by.
    pub fn key(&self) -> Key {
        (self.info.name.clone(), [self.range.start, self.range.end])
    }
}

impl<'a> Subjects<'a> {
    /// Reads the layers of all scenes of the script, for a grid of `cells`.
    pub fn new(file: &'a ModelFile, script: &Script, wanted: &'a Wanted, cells: usize) -> Result<Self> {
        let mut subjects = Subjects { file, wanted, cells, grounds: HashMap::new() };
        for scene in script.views().iter().flat_map(|view| view.scenes()) {
            let layering = subjects.layering(&scene)?;
            if let Entry::Vacant(place) = subjects.grounds.entry(layering.key()) {
                place.insert(Ground::read(file, &layering)?);
            }
            subjects.of(&scene)?;
            if scene.scenery.heights == Heights::Native {
                file.native_info(&layering.bearer().name)?;
            }
        }
        Ok(subjects)
    }

    /// The layering of a scene.
    pub fn layering(&self, scene: &Scene) -> Result<Layering<'a>> {
        Layering::of(self.file, scene, self.wanted)
    }

    fn ground(&self, scene: &Scene) -> Result<&Ground> {
        Ok(&self.grounds[&self.layering(scene)?.key()])
    }

    /// The layers of a scene.
    pub fn layers(&self, scene: &Scene) -> Result<&Layers> {
        Ok(&self.ground(scene)?.layers)
    }

    /// What the heights of each column are, where the scene shows these.
    pub fn native(&self, scene: &Scene) -> Result<Option<&NativeInfo>> {
        let is_shown = scene.scenery.heights == Heights::Native;
        Ok(self.ground(scene)?.native.as_ref().filter(|_| is_shown))
    }

    /// The model's fields that a scene needs, that of its layers first.
    pub fn of(&self, scene: &Scene) -> Result<Vec<Subject<'a>>> {
        let layering = self.layering(scene)?;
        let names = scene.model_fields().into_iter();
        names
            .map(|name| {
                let info = self.file.field_info(name)?;
                Ok(Subject { info, range: layering.range(info)? })
            })
            .collect()
    }

    /// A field that a view's condition asks for, on the layers of the view's.
    pub fn of_condition(&self, view: &View, field: &str) -> Result<Subject<'a>> {
        let info = self.file.field_info(field)?;
        let range = match view.scenes().next() {
            Some(scene) => self.layering(&scene)?.range(info)?,
            None => self.wanted.of(info)?,
        };
        Ok(Subject { info, range })
    }

    /// What is not drawn as the file has it.
    pub fn notes(&self, scene: &Scene) -> Result<Vec<String>> {
        let (layering, ground) = (self.layering(scene)?, self.ground(scene)?);
        let [lead, _] = layering.key();
        let mut notes = Vec::new();
        for Subject { info, range } in self.of(scene)? {
            let (name, bytes) = (&info.name, self.cells * range.len() * info.precision.bytes());
            if info.location == Location::Corner {
                notes.push(format!(
                    "{name} lives on corners: averaged to cell centres (derived, {bytes} bytes)"
                ));
            }
            if layering.moves(info) {
                notes.push(format!(
                    "{name} lies on other layers than {lead}: interpolated to these in height"
                ));
            }
        }
        notes.extend(ground.mean.iter().filter(|_| scene.scenery.heights == Heights::Mean).cloned());
        notes.extend(ground.notes.iter().cloned());
        Ok(notes)
    }

    /// The notes of all scenes, each once.
    pub fn all_notes(&self, script: &Script) -> Result<Vec<String>> {
        let mut all = Vec::new();
        for scene in script.views().iter().flat_map(|view| view.scenes()) {
            for note in self.notes(&scene)? {
                if !all.contains(&note) {
                    all.push(note);
                }
            }
        }
        Ok(all)
    }
}

impl Ground {
    fn read(file: &ModelFile, layering: &Layering) -> Result<Self> {
        let name = &layering.bearer().name;
        let heights = file.layer_heights(name)?;
        let native = match file.native_heights_in_words(name)? {
            Some(_) => Some(file.native_info(name)?),
            None => None,
        };
        let mean = mean_note(&heights, native.is_some());
        let mut notes = Vec::new();
        if heights.is_of_pressure {
            let name = &heights.variable;
            notes.push(format!("{name} gives pressures: rendered at the heights of the standard atmosphere"));
        }
        Ok(Ground { layers: layering.layers(&heights)?, native, mean, notes })
    }
}

fn mean_note(heights: &LayerHeights, has_native: bool) -> Option<String> {
    let deviation_m = heights.deviation_m.filter(|deviation| *deviation > 0.0)?;
    let hint = if has_native { " (heights = \"native\" in the scene shows each column's own)" } else { "" };
    Some(format!("concentric mean heights are rendered; columns deviate by up to {deviation_m:.1} m{hint}"))
}
