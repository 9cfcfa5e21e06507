//! Layers, fields and notes of the scenes of a script.

use crate::dataset::Dataset;
use crate::field::FieldInfo;
use crate::heights::native::NativeInfo;
use crate::layering::{LayerSelection, Layering};
use crate::source::Kind;
use crate::values::AssumedMark;
use icoray::{Heights, Layers, Location, Result, Scene, Script, View};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;

/// Layers and notes of the scenes of a script.
pub struct SceneFields<'a> {
    pub(crate) dataset: &'a Dataset,
    pub(crate) layers_wanted: &'a LayerSelection,
    /// The layers and heights by [`Layering::key`].
    layer_infos: HashMap<[&'a str; 2], LayerInfo>,
}

/// Layers and heights of a scene.
struct LayerInfo {
    layers: Layers,
    /// The heights of each column, if there are any.
    native: Option<NativeInfo>,
    /// Note on the deviation of columns from mean heights.
    mean: Option<String>,
    notes: Vec<String>,
}

/// Name of a field and the ends of its layers.
pub type Key = (String, [usize; 2]);

/// A field of a scene.
#[derive(Clone)]
pub struct SceneField<'a> {
    /// The field.
    pub info: &'a FieldInfo,
    /// The layers that are read and rendered.
    pub range: Range<usize>,
}

impl SceneField<'_> {
    /// The key under which the field is cached.
    pub fn key(&self) -> Key {
        (self.info.name.clone(), [self.range.start, self.range.end])
    }
}

impl<'a> SceneFields<'a> {
    /// Reads the layers of all scenes of the script.
    ///
    /// # Errors
    /// As [`Layering::of`], [`Layering::range`], [`Dataset::layer_heights`] and, of scenes on native heights,
    /// [`Dataset::native_info`].
    pub fn new(dataset: &'a Dataset, script: &Script, layers_wanted: &'a LayerSelection) -> Result<Self> {
        let mut scene_fields = SceneFields { dataset, layers_wanted, layer_infos: HashMap::new() };
        for scene in script.views().iter().flat_map(|view| view.scenes()) {
            let layering = scene_fields.layering(&scene)?;
            if let Entry::Vacant(place) = scene_fields.layer_infos.entry(layering.key()) {
                place.insert(LayerInfo::read(dataset, &layering)?);
            }
            scene_fields.of(&scene)?;
            if scene.scenery.heights == Heights::Native {
                dataset.native_info(&layering.height_field().name)?;
            }
        }
        Ok(scene_fields)
    }

    /// The layering of a scene.
    ///
    /// # Errors
    /// As [`Layering::of`].
    pub fn layering(&self, scene: &Scene) -> Result<Layering<'a>> {
        Layering::of(self.dataset, scene, self.layers_wanted)
    }

    fn layer_info(&self, scene: &Scene) -> Result<&LayerInfo> {
        Ok(&self.layer_infos[&self.layering(scene)?.key()])
    }

    /// The layers of a scene.
    ///
    /// # Errors
    /// As [`Layering::of`].
    pub fn layers(&self, scene: &Scene) -> Result<&Layers> {
        Ok(&self.layer_info(scene)?.layers)
    }

    /// The heights of each column, if the scene shows native heights.
    ///
    /// # Errors
    /// As [`Layering::of`].
    pub fn native(&self, scene: &Scene) -> Result<Option<&NativeInfo>> {
        let is_shown = scene.scenery.heights == Heights::Native;
        Ok(self.layer_info(scene)?.native.as_ref().filter(|_| is_shown))
    }

    /// The model's fields that a scene needs, the one that defines the layers first.
    ///
    /// # Errors
    /// As [`Dataset::field_info`] and [`Layering::range`].
    pub fn of(&self, scene: &Scene) -> Result<Vec<SceneField<'a>>> {
        let layering = self.layering(scene)?;
        let names = scene.model_fields().into_iter();
        names
            .map(|name| {
                let info = self.dataset.field_info(name)?;
                Ok(SceneField { info, range: layering.range(info)? })
            })
            .collect()
    }

    /// The field of a view's condition, on the layers of the view.
    ///
    /// # Errors
    /// As [`SceneFields::of`].
    pub fn of_condition(&self, view: &View, field: &str) -> Result<SceneField<'a>> {
        let info = self.dataset.field_info(field)?;
        let range = match view.scenes().next() {
            Some(scene) => self.layering(&scene)?.range(info)?,
            None => self.layers_wanted.of(info)?,
        };
        Ok(SceneField { info, range })
    }

    /// Notes on data that are not rendered as stored in the dataset.
    ///
    /// # Errors
    /// As [`SceneFields::of`].
    pub fn notes(&self, scene: &Scene) -> Result<Vec<String>> {
        let (layering, layer_info) = (self.layering(scene)?, self.layer_info(scene)?);
        let [first_field, _] = layering.key();
        let mut notes: Vec<String> =
            self.dataset.mesh().made_in_words().map(|made| format!("mesh: {made}")).into_iter().collect();
        for SceneField { info, range } in self.of(scene)? {
            let (name, bytes) = (&info.name, self.dataset.mesh().cells() * range.len() * info.precision.bytes());
            if info.location == Location::Corner {
                notes.push(format!("{name} is at corners: averaged to cell centres (derived, {bytes} bytes)"));
            }
            if let Some(part) = info.part {
                notes.push(format!("{} is at edges: {name} is {} (derived)", info.variable, part.in_words()));
            }
            for AssumedMark { value, count } in self.dataset.assumed_marks(name) {
                // In the field's precision, not as the nearest number of double precision.
                let mark = match info.precision {
                    Kind::F32 => format!("{:e}", value as f32),
                    _ => format!("{value:e}"),
                };
                notes.push(format!(
                    "{count} values of {name} are {mark}, which no attribute explains: taken for missing (`missing` says what \
                     marks missing values)"
                ));
            }
            if layering.moves(info) {
                notes.push(format!("{name} lies on other layers than {first_field}: interpolated to these in height"));
            }
        }
        notes.extend(layer_info.mean.iter().filter(|_| scene.scenery.heights == Heights::Mean).cloned());
        notes.extend(layer_info.notes.iter().cloned());
        Ok(notes)
    }

    /// The notes of all scenes, each once.
    ///
    /// # Errors
    /// As [`SceneFields::of`].
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

impl LayerInfo {
    fn read(dataset: &Dataset, layering: &Layering) -> Result<Self> {
        let name = &layering.height_field().name;
        let heights = layering.heights(dataset)?;
        let native = dataset.find_native_info(name)?;
        let hint = native.as_ref().map_or("", |_| " (heights = \"native\" in the scene shows each column's own)");
        let deviation_m = heights.deviation_m.filter(|deviation| *deviation > 0.0);
        let mean = deviation_m.map(|deviation_m| {
            format!("concentric mean heights are rendered; columns deviate by up to {deviation_m:.1} m{hint}")
        });
        let mut notes = Vec::new();
        let name = &heights.variable;
        if heights.is_of_pressure {
            notes.push(format!("{name} gives pressures: rendered at the heights of the standard atmosphere"));
        }
        if heights.is_counted {
            notes.push(format!("{name} only numbers the layers: shown evenly spaced (`heights` sets their heights)"));
        }
        if heights.layers.planet_radius_m() != dataset.sphere_radius_m() {
            let radius_m = heights.layers.planet_radius_m();
            notes.push(format!(
                "sphere_radius is 1, but heights are in metres: shown on the Earth's radius, {radius_m} m (`radius` has another)"
            ));
        }
        if heights.are_of_shell() && !layering.height_field().is_2d() {
            let inner = if heights.layers.is_falling() { "last" } else { "first" };
            notes.push(format!("no heights of the layers: shown on the sphere, the {inner} as the innermost"));
        }
        Ok(LayerInfo { layers: layering.layers(&heights)?, native, mean, notes })
    }
}
