//! What to draw and how: the contents of a scene file.
//!
//! A scene is TOML; `examples/scenes/` has annotated ones. Lengths are in planet radii, heights that end in `_m` in metres,
//! angles in degrees, colours are CSS colours (`"#ff8800"`, `"steelblue"`) in sRGB. Unknown keys and bad values are errors with
//! line and key.
//!
//! A plain scene shows one volume, by `field` and `[transfer]`. All else that a scene may show is below; each list may have
//! any number of entries, and what is left out costs nothing.
//!
//! ```toml
//! heights = "mean"                # layers are spheres; "native": each column has its own heights
//!
//! [camera]
//! lon = 20
//! lat = 40
//! distance = 3
//!
//! # In place of field and [transfer]: several volumes. Extinctions add up, colours mix by extinction.
//! [[volumes]]
//! field = "vorticity"
//! [volumes.transfer]              # as [transfer]: knots, or map, range and opacity
//! map = "vik"
//! range = { percentile = [1, 99] }
//! center = 0
//! opacity = [[0, 0.9], [0.4, 0], [0.6, 0], [1, 0.9]]
//!
//! [[volumes]]
//! field = "temperature"
//! [volumes.transfer]              # colours alone, as
//! map = "rdylbu_r"
//! range = [220, 300]
//! [volumes.opacity]               # the opacity is that of another field; [opacity] beside field and [transfer]
//! field = "cloud"
//! values = [[0, 0.0], [1e-4, 0.5]]
//! unit_length = 0.02              # planet radii that have the opacity said; else the whole shell
//!
//! [[surfaces]]
//! layer = 3                       # from 0, the innermost; or "top", "bottom"; or height_m = 5000
//! field = "temperature"           # with transfer, of colours alone; or color = "grey"
//! transfer = { map = "rdylbu_r", range = [220, 300] }
//! shading = "cells"               # one colour for each cell; "smooth" by itself
//! opacity = 0.8                   # of the surface, above 0; 1 by itself
//!
//! [[isosurfaces]]
//! field = "vorticity"
//! values = [1e-4, 2e-4]           # or value
//! colors = ["gold", "crimson"]    # one for each; or color; or color_by = "temperature" with transfer
//! opacity = 0.5
//!
//! [[lines]]
//! pattern = "graticule"           # "cells", "triangles", "coast"
//! spacing = 15                    # of a graticule; 30 by itself
//! on = "ground"                   # by itself; or as layer above; or height_m
//! color = "white"                 # by itself
//! width = 1.5                     # pixels, 0.1 to 50; 1 by itself
//! opacity = 0.6
//! region = { lon = [170, -170], lat = [-30, 30] }     # from west to east, over the date line; either may be left out
//!
//! [ground]                        # of the opaque core
//! land = "#5a6b4a"
//! ocean = "#22344c"
//!
//! [[clip]]
//! cut = "inside"                  # or "outside": of where all of the following hold, of which one is enough
//! lon = [0, 90]
//! lat = [0, 90]
//! layers = [2, 10]
//! height_m = [1000, 12000]
//! half_space = { towards = [45, 45], distance = 0.2 }     # beyond a plane so far from the centre; 0 by itself
//!
//! [[derive]]                      # fields made of the model's, or of those above
//! name = "wind"
//! magnitude = ["u", "v"]          # of two or three
//! [[derive]]
//! name = "shear"
//! sum = { u = 1, v = -1 }
//! [[derive]]
//! name = "anomaly"
//! anomaly = "wind"
//! from = "zonal mean"             # over bands of latitude; or "first", the first step that is drawn
//! band = 5                        # degrees; 2 by itself
//! ```
//!
//! A scene may do without a volume. Its layers are then those of the first field that it shows, or of `field`.

mod backend;
mod camera;
mod color;
mod coloring;
mod painting;
mod parse;
mod scale;
mod scenery;
mod transfer;
mod values;

pub use backend::{Adapter, Backend};
pub use camera::Camera;
pub use coloring::{ColorRange, Coloring};
pub(crate) use painting::{OpacityOf, Painting};
pub use scale::Scale;
pub use scenery::{
    Clip, Derivation, Ground, HalfSpace, Heights, How, Isosurface, Level, Lines, LonLatBox, Opacity, Paint,
    Pattern, Scenery, Surface, Volume,
};
pub use transfer::{Knot, TransferFunction};

pub(crate) use parse::views::script as parse_script;

/// Whether there is a colour map of this name.
pub(crate) fn is_color_map(name: &str) -> bool {
    color::ColorMap::named(name).is_some()
}

/// Names of the colour maps.
pub(crate) fn color_maps() -> &'static str {
    &color::MAPS
}

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
    /// Empty where the scene names none, for the first of the fields that a renderer is given ([`Scene::name_first_field`]).
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
    /// How pieces are integrated. Scenes that show more than one volume between concentric layers, or cut it
    /// ([`Scenery::is_plain`]), are integrated to the tolerance whatever it is, and say so ([`Plan::left_out`](crate::Plan::left_out)).
    pub method: Method,
    /// Largest error allowed in a channel of a premultiplied pixel, 0 to 1; [`Method::Exact`] spends no more than it needs.
    pub tolerance: f64,
    /// Whether pixels with the edge of a surface in them show the mean of several rays, where every pixel is traced; else each
    /// pixel is one ray.
    pub antialias: bool,
    /// Milliseconds that a frame may take, from the field's pointers to its pixels; `None` is as long as it takes.
    ///
    /// Within it the renderer picks, from what a few rays are measured to cost: first a looser tolerance (up to 1e-2), then
    /// light that is not cut where the gradient turns, then fewer traced pixels; where gradients alone would take half of
    /// the time, no light. [`Quality`](crate::Quality) says what it was.
    pub time_budget_ms: Option<f64>,
    /// Precision of the inner loop; scenes that are not plain ([`Scenery::is_plain`]) have double precision throughout.
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

    /// Parses a scene from the text of a scene file.
    ///
    /// ```
    /// use icoray::Scene;
    ///
    /// let text = "field = 'theta'
    ///             camera = { lon = 190, lat = 45, distance = 2.6 }
    ///             [transfer]
    ///             map = 'plasma'
    ///             range = [300, 400]
    ///             opacity = [[300, 0], [400, 0.9]]";
    /// let scene = Scene::parse(text)?;
    /// assert_eq!((scene.field.as_str(), scene.width), ("theta", 512));
    ///
    /// let error = Scene::parse(&text.replace("[300, 400]", "[400, 300]")).unwrap_err();
    /// assert!(error.to_string().contains("line 5, key transfer.range"), "{error}");
    /// # Ok::<(), icoray::Error>(())
    /// ```
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

    /// Gives the field that the scene shows without naming it the name `first`; nothing changes where it names all.
    pub fn name_first_field(&mut self, first: &str) {
        let mut rename = |name: &mut String| {
            if name.is_empty() {
                first.clone_into(name);
            }
        };
        rename(&mut self.field);
        self.scenery.rename_fields(&mut rename);
    }

    /// Shows the first volume as an opaque surface on the innermost layer, with the same colours, where the scene gives it no
    /// opacity. For fields of one value per column, which have no inside.
    pub fn show_as_surface(&mut self) {
        let has_own_opacity = self.scenery.opacity.is_some();
        let is_to_change = |coloring: &mut Coloring| !has_own_opacity && coloring.has_default_opacity();
        let Some(coloring) = self.coloring.take_if(is_to_change) else { return };
        let coloring = coloring.without_opacity();
        let transfer = coloring.transfer(coloring.fixed().unwrap_or_else(|| coloring.unknown()));
        let paint =
            Paint::Field { field: self.field.clone(), transfer, coloring: Some(coloring), by_cell: false };
        self.scenery.surfaces.insert(0, Surface { at: Level::Layer(0), paint, opacity: 1.0 });
        self.transfer = TransferFunction::clear();
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
        let derived = &self.scenery.derived;
        let mut names = Vec::new();
        // Names, and how many of the derived fields each may be one of: those before what is made of it.
        let mut todo: Vec<(&str, usize)> =
            self.shown_fields().into_iter().map(|name| (name, derived.len())).collect();
        todo.reverse();
        while let Some((name, count)) = todo.pop() {
            match derived[..count].iter().rposition(|derived| derived.name == name) {
                Some(at) => todo.extend(derived[at].how.fields().into_iter().rev().map(|field| (field, at))),
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
