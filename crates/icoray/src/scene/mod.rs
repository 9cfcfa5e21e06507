//! What to draw and how: the contents of a scene file.
//!
//! A scene is TOML; `examples/scenes/` has annotated ones. Lengths are in planet radii, angles in degrees, colours are
//! CSS colours (`"#ff8800"`, `"steelblue"`) in sRGB. Unknown keys and bad values are errors with line and key.

mod backend;
mod camera;
mod color;
mod coloring;
mod parse;
mod scale;
mod scenery;
mod transfer;

pub use backend::{Adapter, Backend};
pub use camera::Camera;
pub use coloring::{ColorRange, Coloring};
pub use scale::Scale;
pub use scenery::{
    Clip, Derivation, Ground, HalfSpace, Heights, How, Isosurface, Level, Lines, LonLatBox, Opacity, Paint,
    Pattern, Scenery, Surface, Volume,
};
pub use transfer::{Knot, TransferFunction};

pub(crate) use parse::views::script as parse_script;

use crate::error::Result;
use crate::kernel::piece::Method;
use crate::label::Labels;
use crate::output::Output;
use std::ops::RangeInclusive;

/// Floating-point precision of the kernel's inner loop. Positions are in f64 either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Precision {
    /// Single: errors around 1e-6 of a pixel's range.
    #[default]
    F32,
    /// Double: for references.
    F64,
}

/// How several ranks share out a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scheme {
    /// Fragments where ranks have parts of the grid, else tiles.
    #[default]
    Auto,
    /// Sort-first: each rank draws some tiles of the picture, whole.
    Tiles,
    /// Sort-last: each rank draws its own cells in all tiles, and rays are put together of what ranks send each other.
    Fragments,
}

/// Where light comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// From the eye.
    Headlight,
    /// From infinity, above the given place.
    Sun {
        /// Longitude below the sun, degrees.
        lon_deg: f64,
        /// Latitude below the sun, degrees.
        lat_deg: f64,
    },
}

/// Blinn-Phong lighting; the field's gradient is the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lighting {
    /// Where the light comes from.
    pub source: Source,
    /// Part of the colour that is there without light, 0 to 1.
    pub ambient: f64,
    /// Part of the colour that needs light, 0 to 1.
    pub diffuse: f64,
    /// Strength of the white highlight, 0 to 1.
    pub specular: f64,
    /// Exponent of the highlight: larger is smaller and sharper.
    pub shininess: f64,
}

/// A whole scene, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Name of the field that is rendered: of the first volume or, where there is none, of the first thing that is shown.
    pub field: String,
    /// Of the steps that a running model offers, those that are multiples of this are drawn; at least 1. See
    /// [`Scene::is_due`]. The renderer itself draws what it is told to; `icoray render` takes the times of a file for steps.
    pub every: u32,
    /// Picture width in pixels.
    pub width: u32,
    /// Picture height in pixels.
    pub height: u32,
    /// Linear RGB behind everything; `None` leaves the picture transparent.
    pub background: Option<[f64; 3]>,
    /// Factor on heights above the planet's surface, 1 is true to scale.
    pub exaggeration: f64,
    /// Linear RGB of the opaque planet below the innermost layer; `None` is hollow, and rays go on on the far side.
    pub core: Option<[f64; 3]>,
    /// The camera.
    pub camera: Camera,
    /// From values to colour and extinction. Where the range follows the data it is a stand-in over 0 to 1 (1 to 10 on a log
    /// scale); a renderer draws with the range that it finds, as [`Scene::over`] makes it.
    pub transfer: TransferFunction,
    /// What the transfer function is made of; `None` where its knots are given.
    pub coloring: Option<Coloring>,
    /// What is shown beside the first volume, and what is cut away.
    pub scenery: Scenery,
    /// The light; `None` shows the transfer function's colours as they are.
    pub lighting: Option<Lighting>,
    /// How pieces are integrated.
    pub method: Method,
    /// Largest error allowed in a channel of a premultiplied pixel, 0 to 1; [`Method::Exact`] spends no more than it needs.
    pub tolerance: f64,
    /// Milliseconds that a frame may take, from the field's pointers to its pixels; `None` is as long as it takes.
    ///
    /// Within it the renderer picks, from what a few rays are measured to cost: first a looser tolerance (up to 1e-2), then
    /// light that is not cut where the gradient turns, then fewer traced pixels; where gradients alone would take half of
    /// the time, no light. [`Quality`](crate::Quality) says what it was.
    pub time_budget_ms: Option<f64>,
    /// Precision of the inner loop.
    pub precision: Precision,
    /// How several ranks share out the picture.
    pub ranks: Scheme,
    /// Who traces rays.
    pub backend: Backend,
    /// Which of several GPUs; `None` is one of the fastest kind, another for each rank on a node.
    pub device: Option<Adapter>,
    /// What is written into the picture; `None` is nothing.
    pub labels: Option<Labels>,
    /// Names of the pictures, and of the maps of their errors.
    pub output: Output,
}

impl Scene {
    /// What [`Scene::tolerance`] may be.
    pub const TOLERANCE: RangeInclusive<f64> = 1e-12..=0.5;
    /// The tolerance of a scene that names none.
    pub const DEFAULT_TOLERANCE: f64 = 1e-3;

    /// Reads a scene from the text of a scene file.
    ///
    /// # Errors
    /// [`ErrorKind::Scene`](crate::ErrorKind::Scene) with the line, the key, the value and what was expected.
    pub fn parse(text: &str) -> Result<Self> {
        parse::scene(text)
    }

    /// As [`Scene::parse`], with `None` for a text of nothing but blanks and comments: nothing is to be drawn.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn parse_optional(text: &str) -> Result<Option<Self>> {
        let is_empty = toml::from_str::<toml::Table>(text).is_ok_and(|table| table.is_empty());
        if is_empty { Ok(None) } else { Self::parse(text).map(Some) }
    }

    /// The scene with its colour map over a range, whose ends the map's scale admits, the lower first; the same scene where
    /// knots are given.
    #[must_use]
    pub fn over(&self, range: [f64; 2]) -> Self {
        let mut scene = self.clone();
        if let Some(coloring) = &mut scene.coloring {
            scene.transfer = coloring.transfer(range);
            coloring.range = ColorRange::Fixed(range);
            coloring.center = None;
        }
        scene
    }

    /// The names of the fields that are shown, each once, the first one first; some may be derived.
    pub fn shown_fields(&self) -> Vec<&str> {
        let mut names = vec![self.field.as_str()];
        self.scenery.shown_fields(&mut |name| {
            if !names.contains(&name) {
                names.push(name);
            }
        });
        names
    }

    /// The names of the model's fields that the scene needs, each once: those that are shown, and those of which derived
    /// ones are made.
    pub fn model_fields(&self) -> Vec<&str> {
        let mut names = Vec::new();
        let mut todo = self.shown_fields();
        todo.reverse();
        while let Some(name) = todo.pop() {
            match self.scenery.derived.iter().find(|derived| derived.name == name) {
                // Of those before it only, so that none is made of itself.
                Some(derived) => todo.extend(derived.how.fields().into_iter().rev()),
                None if !names.contains(&name) => names.push(name),
                None => (),
            }
        }
        names
    }

    /// Whether the step is one to draw: a multiple of [`Scene::every`], 0 and negative ones included. An `every` of 0,
    /// which no scene file can have, counts as 1.
    pub fn is_due(&self, step: i64) -> bool {
        step % i64::from(self.every.max(1)) == 0
    }
}
