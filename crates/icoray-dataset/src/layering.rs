//! The layers of a dataset's fields that are read and drawn.

use crate::dataset::Dataset;
use crate::field::FieldInfo;
use crate::heights::LayerHeights;
use icoray::{Error, ErrorKind, Heights, Layers, Level, Result, Scene, Volume};
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// A range of layers, counted from 0 and without the last, whose ends may be left out: `0..20`, `5..`, `..`.
///
/// ```
/// use icoray_dataset::LayerSelection;
///
/// assert!("..".parse::<LayerSelection>().unwrap().is_all());
/// assert_eq!("5..".parse::<LayerSelection>().unwrap().to_string(), "5..");
/// assert!("5".parse::<LayerSelection>().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LayerSelection {
    from: usize,
    to: Option<usize>,
}

impl FromStr for LayerSelection {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let ends = text.split_once("..").and_then(|(from, to)| {
            let from = if from.is_empty() { 0 } else { from.parse().ok()? };
            let to = if to.is_empty() { None } else { Some(to.parse().ok()?) };
            Some(LayerSelection { from, to })
        });
        ends.ok_or_else(|| "expected a range of layers such as 0..20 or 5..".to_owned())
    }
}

impl fmt::Display for LayerSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.from, self.to.map_or_else(String::new, |to| to.to_string()))
    }
}

impl LayerSelection {
    /// The selected layers of a field; of a 2D field those of the shell that shows it.
    ///
    /// # Errors
    /// [`ErrorKind::Argument`] if some layers of a 2D field are selected, fewer than 2, or any that the field does not
    /// have.
    pub fn of(&self, info: &FieldInfo) -> Result<Range<usize>> {
        if self.is_all() {
            return Ok(info.all_layers());
        }
        if info.is_2d() {
            let context = format!("layers {self}: {} is a 2D field, expected a field with layers", info.name);
            return Err(Error::new(ErrorKind::Argument, context));
        }
        let range = self.from..self.to.unwrap_or(info.layers);
        if range.len() < 2 || range.end > info.layers {
            let context = format!("layers {self}: expected at least 2 of the {} layers of {}", info.layers, info.name);
            return Err(Error::new(ErrorKind::Argument, context));
        }
        Ok(range)
    }

    /// Whether all layers are selected.
    pub fn is_all(&self) -> bool {
        *self == LayerSelection::default()
    }
}

/// The layers of a scene: those of its first field with layers; fields on interfaces or between them are interpolated
/// to these. A 2D field has equal values on all layers; a scene of 2D fields only has the layers of a thin shell.
#[derive(Clone, Copy)]
pub struct Layering<'a> {
    layers_wanted: &'a LayerSelection,
    /// The model's field that defines the layers: the first one with layers, or the first that it is derived from.
    first_field: &'a FieldInfo,
    /// The field that defines the heights: one on interfaces if the first lies between them.
    height_field: &'a FieldInfo,
    /// Whether the scene shows layers only as surfaces, which may lie anywhere.
    is_flat: bool,
}

impl<'a> Layering<'a> {
    /// The layering of a scene.
    ///
    /// # Errors
    /// As [`Dataset::field_info`].
    pub fn of(dataset: &'a Dataset, scene: &Scene, layers_wanted: &'a LayerSelection) -> Result<Self> {
        let infos: Vec<&FieldInfo> =
            scene.model_fields().into_iter().map(|name| dataset.field_info(name)).collect::<Result<_>>()?;
        let first_field = infos.iter().find(|info| !info.is_2d()).or(infos.first()).copied();
        let first_field = first_field.map_or_else(|| dataset.field_info(scene.field()), Ok)?;
        let height_field = infos.into_iter().find(|info| info.layers == first_field.layers + 1).unwrap_or(first_field);
        Ok(Layering { layers_wanted, first_field, height_field, is_flat: is_flat(scene) })
    }

    /// The names that identify the layering.
    pub fn key(&self) -> [&'a str; 2] {
        [&self.first_field.name, &self.height_field.name]
    }

    /// The field that defines the heights.
    pub fn height_field(&self) -> &'a FieldInfo {
        self.height_field
    }

    /// Whether a field is interpolated to the layers of the first.
    pub fn moves(&self, info: &FieldInfo) -> bool {
        info.layers != self.first_field.layers && !info.is_2d()
    }

    /// The layers of a field that are read and rendered: for a field on interfaces those around the layers of the first
    /// field, for one between interfaces those between them, for a 2D field as many as for the first.
    ///
    /// # Errors
    /// As [`LayerSelection::of`]; [`ErrorKind::Argument`] if fewer than 2 remain, or the field's layers are not the
    /// first one's.
    pub fn range(&self, info: &FieldInfo) -> Result<Range<usize>> {
        if self.layers_wanted.is_all() {
            return Ok(if info.is_2d() { self.first_field.all_layers() } else { info.all_layers() });
        }
        let Range { start, end } = self.layers_wanted.of(self.first_field)?;
        let bad = |what: String| {
            let first_field = &self.first_field.name;
            let context = format!("layers: {start}..{end} are layers of {first_field}; {}{what}", info.name);
            Err(Error::new(ErrorKind::Argument, context))
        };
        match (info.layers, self.first_field.layers) {
            (own, first) if own == first || info.is_2d() => Ok(start..end),
            (own, first) if own == first + 1 => Ok(start..end + 1),
            (own, first) if own + 1 == first && start + 3 <= end => Ok(start..end - 1),
            (own, first) if own + 1 == first => bad(" has 1 between them, expected at least 2".into()),
            (own, first) => bad(format!(" has {own} of its own, expected {first}, one more or one fewer")),
        }
    }

    /// The heights of the layers.
    ///
    /// # Errors
    /// As [`Dataset::layer_heights`], unless the scene shows layers only as surfaces.
    pub fn heights(&self, dataset: &Dataset) -> Result<LayerHeights> {
        dataset.heights_of(&self.height_field.name, self.is_flat)
    }

    /// The radii on which the first field lies, or between which it does.
    ///
    /// # Errors
    /// As [`Layering::range`] and [`LayerHeights::layers_over`].
    pub fn layers(&self, heights: &LayerHeights) -> Result<Layers> {
        heights.layers_over(self.height_field, self.range(self.height_field)?)
    }
}

/// Whether a scene does not depend on heights: it shows no volume, and names layers by their numbers.
fn is_flat(scene: &Scene) -> bool {
    let scenery = &scene.scenery;
    let is_clear = |volume: &Volume| volume.transfer.knots.iter().all(|knot| knot.extinction == 0.0);
    let levels = scenery.surfaces.iter().map(|surface| surface.at).chain(scenery.lines.iter().map(|lines| lines.on));
    scene.volumes.iter().all(|volume| volume.opacity.is_none() && is_clear(volume))
        && levels.into_iter().all(|level| !matches!(level, Level::Height(_)))
        && scenery.isosurfaces.is_empty()
        && scenery.derived.is_empty()
        && scenery.clips.iter().all(|clip| clip.height_m.is_none() && clip.half_space.is_none())
        && scenery.heights == Heights::Mean
}
