//! Suggests a first scene for a field, from its values and layers.
//!
//! [`scene`] returns the commented text of a scene file. A caller parses this text like any other scene, so that the
//! picture drawn at once and that of the saved text are equal.
//!
//! The values decide how the field is shown:
//!
//! - **Both signs** (the 1st and the 99th percentile have different signs and similar magnitudes): a diverging colour
//!   map about 0, opaque in the tails of the magnitude, clear around 0.
//! - **Stratified** (layer means explain most of the variance, as of potential temperature or density): two thin
//!   shells, at values that the lowest layer has too, so that the edges of the shells are visible. If the lowest layer
//!   has about one value, the field minus the mean of each layer is shown instead; if no layer has values other than
//!   its mean, all layers, behind a cut.
//! - **Otherwise**: the longer end of the distribution, in no more than a third of the columns. Positive values over
//!   many decades have a logarithmic scale.
//! - **On a surface**: all values.
//!
//! Each value has the same weight, so layers count most where the model has many of them. The camera faces the side on
//! which most of the field is visible, at a distance that shows the whole planet, or the region that the mesh covers.
//!
//! Colours stand out from dark ground, which is grey, so that it adds no hue to them.
//!
//! ```
//! use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Scene, suggest};
//!
//! let mesh = IcosahedralMesh::new(3)?;
//! let grid = Grid::new(mesh.tables())?;
//! let layers = Layers::from_heights(&[0.0, 5e3, 10e3], 6.371e6)?;
//! let values: Vec<f32> = (0..grid.cells() * 3).map(|i| (0.37 * i as f32).sin()).collect();
//! let field = Field::level_fastest(&values, 3, Location::Center)?;
//! let options = suggest::Options { size: Some((320, 240)), ..Default::default() };
//! let text = suggest::scene("w", &grid, &layers, &field, &options)?;
//! let scene = Scene::parse(&text)?;
//! assert_eq!((scene.field(), scene.width), ("w", 320));
//! # Ok::<(), icoray::Error>(())
//! ```

mod aim;
mod completed;
mod decomposed;
mod look;
mod numbers;
mod sample;
mod shells;
mod survey;
#[cfg(test)]
mod tests;
mod text;

use aim::{Aim, Region};
pub use completed::{Completion, Suggest, completed, open_views};
use icoray_grid::{Error, ErrorKind, Field, Grid, Layers, Result};
use icoray_scene::{Adapter, Backend, Level, LightSource};
use look::{Kind, Look};
use sample::Sample;
use serde::{Deserialize, Serialize};
use survey::Survey;

/// Approximate thickness of the exaggerated shell, as a fraction of the planet's radius.
const THICKNESS: f64 = 0.1;
/// Full vertical angle of the camera, degrees.
const FOV_DEG: f64 = 30.0;
/// Fraction of the picture's height or width that the planet or the region fills.
const FILLED: f64 = 0.97;
/// Thickness of a region's shell, as a fraction of its width.
const REGION_THICKNESS: f64 = 0.15;

/// Choices of the caller; those that are `None` are suggested.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Longitude below the camera, degrees, -360 to 360.
    pub lon_deg: Option<f64>,
    /// Latitude below the camera, degrees, -90 to 90.
    pub lat_deg: Option<f64>,
    /// Distance of the camera from the planet's centre, planet radii.
    pub distance: Option<f64>,
    /// Factor on heights.
    pub exaggeration: Option<f64>,
    /// Name of the colour map.
    pub color_map: Option<String>,
    /// Values at the ends of the colour map, the lower first.
    pub range: Option<[f64; 2]>,
    /// Shows the values on this level as an opaque surface instead of a volume.
    pub surface: Option<Level>,
    /// Shows the surface on which the field has this value instead of a volume.
    pub isosurface: Option<f64>,
    /// A CSS colour, or `transparent`.
    pub background: Option<String>,
    /// Source of light; the inner `None` is no light.
    pub light: Option<Option<LightSource>>,
    /// Draws the borders between countries, on an Earth.
    pub has_borders: bool,
    /// Omits title and colour bar.
    pub is_unlabelled: bool,
    /// Width and height of the picture, pixels.
    pub size: Option<(u32, u32)>,
    /// Largest error of a channel ([`Scene::tolerance`](icoray_scene::Scene::tolerance)).
    pub tolerance: Option<f64>,
    /// Maximum number of rays per pixel ([`Scene::samples`](icoray_scene::Scene::samples)).
    pub samples: Option<u32>,
    /// The processor that traces rays.
    pub backend: Option<Backend>,
    /// The choice among several GPUs.
    pub device: Option<Adapter>,
    /// Whether the field is never shown minus the mean of each layer.
    pub is_underived: bool,
    /// Omits the time from the title, as the data have none.
    pub is_timeless: bool,
    /// Whether values are heights, depths or other lengths, which have a linear scale. Amounts of precipitation are none.
    pub is_length: bool,
    /// Lines for the comment at the top of the text, such as the command that draws it.
    pub head: Vec<String>,
}

/// The text of a scene file that shows `field`, which a scene calls `name`.
///
/// # Errors
/// [`ErrorKind::Field`] if all values are missing, or columns or layers do not fit `grid` and `layers`;
/// [`ErrorKind::Argument`] for an option that is out of range, or an unknown colour map.
pub fn scene(name: &str, grid: &Grid, layers: &Layers, field: &Field, options: &Options) -> Result<String> {
    options.check()?;
    let suggestion = of_sample(name, layers, &Sample::of_whole(name, grid, field)?, options)?;
    let missing = || Error::new(ErrorKind::Field, format!("{name}: all values are missing, expected some to draw"));
    suggestion.map(|suggestion| suggestion.text).ok_or_else(missing)
}

/// The suggestion for a field's values; `None` where all are missing.
fn of_sample(name: &str, layers: &Layers, sample: &Sample, options: &Options) -> Result<Option<Suggestion>> {
    let layers = &layers.for_field(sample.layers)?;
    let shown = options.surface.map(|level| nearest_layer(layers, level)).transpose()?;
    let Some(survey) = Survey::new(layers, sample, shown) else { return Ok(None) };
    let region = Region::of(sample);
    let thickness = region.map_or(THICKNESS, |region| THICKNESS.min(REGION_THICKNESS * region.across));
    let exaggeration = options.exaggeration.unwrap_or_else(|| exaggeration(layers, thickness));
    let look = Look::new(&survey, exaggeration, options);
    let anomaly = if look.is_of_anomaly { survey.anomaly() } else { None };
    let aim = Aim::new(anomaly.as_ref().unwrap_or(&survey), &look, exaggeration);
    let is_provisional = matches!(look.kind, Kind::Constant | Kind::Layered);
    let text = text::Suggested { name, sample, layers, exaggeration, look, aim, region, options }.text();
    Ok(Some(Suggestion { text, is_provisional }))
}

/// A scene for the current values of a field.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Suggestion {
    /// The text of a scene file.
    pub text: String,
    /// Whether all values are equal, or all of each layer: later values that differ may need another scene.
    pub is_provisional: bool,
}

impl Options {
    /// Adapts the scene to a 2D field, which is shown as a surface, without exaggeration unless the options have one.
    #[must_use]
    pub fn for_2d(self) -> Self {
        Options { surface: Some(Level::Layer(0)), exaggeration: self.exaggeration.or(Some(1.0)), ..self }
    }

    fn check(&self) -> Result<()> {
        let bad = |what: String| Err(Error::new(ErrorKind::Argument, what));
        if let Some(map) = &self.color_map {
            check_color_map(map)?;
        }
        let schema = icoray_scene::keys::find("exaggeration").expect("a key of scenes");
        if let Some(factor) = self.exaggeration.filter(|factor| !schema.contains(*factor)) {
            return bad(format!("exaggeration {factor}, expected a number {}", schema.bounds_text()));
        }
        match self.range {
            Some([low, high]) if !(low < high && low.is_finite() && high.is_finite()) => {
                bad(format!("range {low} to {high}, expected two finite numbers, the lower first"))
            }
            _ => Ok(()),
        }
    }
}

/// Checks that a colour map has this name.
///
/// # Errors
/// [`ErrorKind::Argument`] with the names of all colour maps.
pub fn check_color_map(name: &str) -> Result<()> {
    if icoray_scene::is_color_map(name) {
        return Ok(());
    }
    let maps = icoray_scene::color_maps();
    let hint = icoray_scene::did_you_mean(name, maps.split(", "));
    let context = format!("colour map {name:?}{hint}, expected one of {maps}, or one with _r behind it");
    Err(Error::new(ErrorKind::Argument, context))
}

/// A number that makes the shell about `thickness` planet radii thick.
fn exaggeration(layers: &Layers, thickness: f64) -> f64 {
    let radius = layers.radius_m();
    let true_thickness = (radius[0] - radius[radius.len() - 1]).abs() / layers.planet_radius_m();
    numbers::round(thickness / true_thickness).max(1.0)
}

/// The number of the field's layer at or nearest to a level, in the field's order.
fn nearest_layer(layers: &Layers, level: Level) -> Result<usize> {
    let count = layers.count();
    let from_inside = match level {
        Level::Ground => 0,
        Level::Top => count - 1,
        Level::Layer(number) if number < count => number,
        Level::Layer(number) => {
            let context = format!("surface on layer {number}, expected 0 to {}, the outermost", count - 1);
            return Err(Error::new(ErrorKind::Argument, context));
        }
        Level::Height(height_m) => {
            let off = |layer: usize| (layers.radius_m()[layer] - layers.planet_radius_m() - height_m).abs();
            let nearest = (0..count).min_by(|a, b| off(*a).total_cmp(&off(*b)));
            return Ok(nearest.unwrap_or(0));
        }
    };
    Ok(if layers.is_falling() { count - 1 - from_inside } else { from_inside })
}
