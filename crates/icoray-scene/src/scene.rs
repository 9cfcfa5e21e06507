//! A scene: what to draw and how.

use crate::camera::Camera;
use crate::labels::Labels;
use crate::name::Output;
use crate::scenery::{Heights, Level, Lines, Paint, Pattern, Scenery, Surface, Volume};
use crate::transfer::TransferFunction;
use std::ops::RangeInclusive;
use std::{fmt, iter};

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

/// The device that traces rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// A GPU where there is one, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, or a processor that acts as one; the CPU where there is neither, and for what they cannot do.
    Gpu,
}

/// Which of several GPUs.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Adapter {
    /// The one of this number, from 0 (`icoray devices` lists them).
    Number(usize),
    /// Devices whose name contains this text, in any case.
    Name(String),
}

/// Text of a user: a number, or else a part of a name.
impl From<&str> for Adapter {
    fn from(text: &str) -> Self {
        text.parse().map_or_else(|_| Adapter::Name(text.to_owned()), Adapter::Number)
    }
}

impl fmt::Display for Adapter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Adapter::Number(number) => write!(f, "{number}"),
            Adapter::Name(name) => write!(f, "{name:?}"),
        }
    }
}

/// How a piece is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// f linear over the piece, colour the mean of its ends (the paper's piecewise linear approximation).
    Paper,
    /// The bend of f kept, colour to the scene's tolerance.
    #[default]
    Exact,
}

/// Where light comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LightSource {
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
    pub source: LightSource,
    /// Part of the colour that is there without light, 0 to 1.
    pub ambient: f64,
    /// Part of the colour that needs light, 0 to 1.
    pub diffuse: f64,
    /// Strength of the white highlight, 0 to 1.
    pub specular: f64,
    /// Exponent of the highlight: larger is smaller and sharper.
    pub shininess: f64,
}

/// The names, each once.
pub(super) fn each_once<N: PartialEq>(names: impl Iterator<Item = N>) -> Vec<N> {
    let mut once = Vec::new();
    for name in names {
        if !once.contains(&name) {
            once.push(name);
        }
    }
    once
}

/// A whole scene, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Fields shown as volumes, at least one: extinctions add up, colours mix by extinction. The first one's field
    /// gives the scene its layers and the picture its name; where a scene shows no volume, it is transparent.
    pub volumes: Vec<Volume>,
    /// Of the steps that a running model offers, those that are multiples of this are drawn; at least 1. The renderer
    /// itself draws every scene; `icoray render` takes the times of a file for steps.
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
    /// Surfaces, lines, clips and ground beside the volumes.
    pub scenery: Scenery,
    /// The light; `None` shows the transfer function's colours as they are.
    pub lighting: Option<Lighting>,
    /// How pieces are integrated. Scenes of several volumes, or of one in the colours of another field, are integrated
    /// to the tolerance with either method, as `Plan::left_out` states.
    pub method: Method,
    /// Largest error allowed in a channel of a premultiplied pixel, 0 to 1; [`Method::Exact`] spends no more than it
    /// needs.
    pub tolerance: f64,
    /// Whether pixels with the edge of a surface in them show the mean of several rays, where every pixel is traced;
    /// else each pixel is one ray, or its [samples](Self::samples).
    pub antialias: bool,
    /// Most rays whose mean a pixel shows, 1 to [`Scene::MAX_SAMPLES`]; 1 is the ray through its middle. Where it is
    /// more, pixels take 4 rays, and twice as many again while the estimated error of their mean is above
    /// [`Scene::tolerance`]. Rays are averaged where every pixel is traced, on the CPU.
    pub samples: u32,
    /// Milliseconds that a frame may take, from the field's pointers to its pixels; `None` is as long as it takes.
    ///
    /// Within it the renderer picks, from what a few rays are measured to cost: first a looser tolerance (up to 1e-2),
    /// then light that is not cut where the gradient turns, then fewer traced pixels; where gradients alone would
    /// take half of the time, no light. [`Quality`](crate::quality::Quality) says what it was. Samples beyond a pixel's
    /// first are taken as long as time is left.
    pub time_budget_ms: Option<f64>,
    /// The largest step between traced pixels within a time budget, [`Quality::LARGEST_STEP`](crate::quality::Quality) by
    /// default; no key sets it.
    pub largest_step: u32,
    /// Precision of the inner loop; scenes of more than one volume ([`Scene::has_single_volume`]) have double precision
    /// throughout.
    pub precision: Precision,
    /// How several ranks share out the picture.
    pub ranks: Scheme,
    /// Device that traces rays.
    pub backend: Backend,
    /// Which of several GPUs; `None` is one of the fastest kind, another for each rank on a node.
    pub device: Option<Adapter>,
    /// Labels in the picture; `None` for none.
    pub labels: Option<Labels>,
    /// Names of the pictures, and of the maps of their errors.
    pub output: Output,
}

impl Scene {
    /// Range of [`Scene::tolerance`] in a scene's text. Pixels are in single precision: a smaller tolerance costs time
    /// and changes none.
    pub const TOLERANCE: RangeInclusive<f64> = 1e-7..=0.5;
    /// The tolerance of a scene that names none.
    pub const DEFAULT_TOLERANCE: f64 = 1e-3;
    /// Largest value of [`Scene::samples`].
    pub const MAX_SAMPLES: u32 = 64;

    /// Name of the first volume's field. Empty where the scene names none, for the first of the fields that a renderer
    /// is given ([`Scene::name_first_field`]).
    pub fn field(&self) -> &str {
        &self.volumes[0].field
    }

    /// Whether rays may meet surfaces other than a round core, at whose edges they differ.
    pub fn has_boundaries(&self) -> bool {
        let Scenery { surfaces, isosurfaces, clips, heights, .. } = &self.scenery;
        let has_surfaces = !(surfaces.is_empty() && isosurfaces.is_empty() && clips.is_empty());
        has_surfaces || *heights == Heights::Native
    }

    /// Whether there is one volume, in the colours of its own field.
    pub fn has_one_field_of_volume(&self) -> bool {
        matches!(self.volumes.as_slice(), [Volume { opacity: None, .. }])
    }

    /// Whether there is such a volume without surfaces.
    pub fn has_volume_alone(&self) -> bool {
        self.has_one_field_of_volume() && !self.has_boundaries()
    }

    /// Whether nothing but one volume is shown, over a ground that may have lines on it.
    pub fn has_single_volume(&self) -> bool {
        let Scenery { surfaces, isosurfaces, lines, ground: _, clips, derived: _, heights: _ } = &self.scenery;
        let is_on_ground = |lines: &Lines| lines.on == Level::Ground;
        let is_meshless = |lines: &Lines| !matches!(lines.pattern, Pattern::Cells | Pattern::Triangles);
        self.has_one_field_of_volume()
            && surfaces.is_empty()
            && isosurfaces.is_empty()
            && lines.iter().all(|lines| is_on_ground(lines) && is_meshless(lines))
            && clips.is_empty()
    }

    /// Gives the field that the scene shows without naming it the name `first`; nothing changes where it names all.
    pub fn name_first_field(&mut self, first: &str) {
        let mut rename = |name: &mut String| {
            if name.is_empty() {
                first.clone_into(name);
            }
        };
        for volume in &mut self.volumes {
            rename(&mut volume.field);
            volume.opacity.iter_mut().for_each(|opacity| rename(&mut opacity.field));
        }
        self.scenery.rename_fields(&mut rename);
    }

    /// Shows the first volume as an opaque surface on the innermost layer, with the same colours, where the scene gives
    /// it no opacity. For fields of one value per column, which have no inside.
    pub fn show_as_surface(&mut self) {
        let first = &mut self.volumes[0];
        let has_default_opacity = first.opacity.is_none();
        let Some(coloring) = first.coloring.take_if(|c| has_default_opacity && c.has_default_opacity()) else {
            return;
        };
        let coloring = coloring.without_opacity();
        let transfer = coloring.transfer(coloring.fixed().unwrap_or_else(|| coloring.unknown()));
        let field = first.field.clone();
        let paint = Paint::Field { field, transfer, coloring: Some(coloring), by_cell: false };
        first.transfer = TransferFunction::clear();
        self.scenery.surfaces.insert(0, Surface { at: Level::Layer(0), paint, opacity: 1.0 });
    }

    /// The names of the fields that are shown, each once, the first one first; some may be derived.
    pub fn shown_fields<'s>(&'s self) -> Vec<&'s str> {
        let opacity_of = |volume: &'s Volume| volume.opacity.as_ref().map(|opacity| &*opacity.field);
        let of_volumes = self.volumes.iter().flat_map(|volume| iter::once(&*volume.field).chain(opacity_of(volume)));
        each_once(of_volumes.chain(self.scenery.shown_fields()))
    }

    /// The names of the model's fields that the scene needs, each once: those that are shown, and those of which
    /// derived ones are made.
    pub fn model_fields(&self) -> Vec<&str> {
        let derived = &self.scenery.derived;
        let mut names = Vec::new();
        // Names, and how many of the derived fields each may be one of: those before what is made of it.
        let mut todo: Vec<(&str, usize)> = self.shown_fields().into_iter().map(|name| (name, derived.len())).collect();
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

    /// The names of the fields of which derived ones are made; some may be of derived ones.
    pub fn derivation_inputs(&self) -> impl Iterator<Item = &str> {
        self.scenery.derived.iter().flat_map(|derived| derived.how.fields())
    }
}
