//! The contents of a scene: volumes, surfaces, lines and clips.

use crate::coloring::Coloring;
use crate::outlines::Outlines;
use crate::transfer::TransferFunction;
use glam::DVec3;
use std::iter;
use std::sync::Arc;

/// Surfaces, lines, clips and ground beside volumes; none by default.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scenery {
    /// Coloured layers.
    pub surfaces: Vec<Surface>,
    /// Surfaces on which a field has one value.
    pub isosurfaces: Vec<Isosurface>,
    /// Lines on the ground or on a level.
    pub lines: Vec<Lines>,
    /// Appearance of the opaque core.
    pub ground: Ground,
    /// Clips, which cut volumes and surfaces away. Ground and lines on it stay.
    pub clips: Vec<Clip>,
    /// Fields that are made of the model's, or of derived ones before them in the list.
    pub derived: Vec<Derivation>,
    /// Whether layers lie at the same height everywhere.
    pub heights: Heights,
}

impl Scenery {
    /// The names of all fields that surfaces and isosurfaces show.
    pub(super) fn shown_fields(&self) -> impl Iterator<Item = &str> {
        let isosurfaces = self.isosurfaces.iter();
        let isosurfaces = isosurfaces.flat_map(|surface| iter::once(&*surface.field).chain(surface.paint.field()));
        self.surfaces.iter().filter_map(|surface| surface.paint.field()).chain(isosurfaces)
    }

    /// Changes the names of fields that are shown.
    pub(super) fn rename_fields(&mut self, rename: &mut impl FnMut(&mut String)) {
        self.isosurfaces.iter_mut().for_each(|surface| rename(&mut surface.field));
        for paint in self.paints_mut() {
            if let Paint::Field { field, .. } = paint {
                rename(field);
            }
        }
    }

    /// The paints of surfaces, then those of isosurfaces.
    pub fn paints(&self) -> impl Iterator<Item = &Paint> {
        let isosurfaces = self.isosurfaces.iter().map(|surface| &surface.paint);
        self.surfaces.iter().map(|surface| &surface.paint).chain(isosurfaces)
    }

    /// The same, to be changed.
    pub(super) fn paints_mut(&mut self) -> impl Iterator<Item = &mut Paint> {
        let isosurfaces = self.isosurfaces.iter_mut().map(|surface| &mut surface.paint);
        self.surfaces.iter_mut().map(|surface| &mut surface.paint).chain(isosurfaces)
    }
}

/// A field shown as a volume.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume {
    /// Name of the field.
    pub field: String,
    /// From values to colour and extinction. Where the range follows the data it is a stand-in over 0 to 1 (1 to 10 on
    /// a log scale); a renderer draws with the ranges that it finds ([`Scene::over_each`](crate::Scene::over_each)).
    pub transfer: TransferFunction,
    /// Colour map and opacities of the transfer function; `None` if its knots are given.
    pub coloring: Option<Coloring>,
    /// Where the extinction comes from; `None` is the transfer function.
    pub opacity: Option<Opacity>,
}

impl Volume {
    /// A volume of `field` that is nowhere visible.
    pub(crate) fn clear(field: String) -> Self {
        Volume { field, transfer: TransferFunction::clear(), coloring: None, opacity: None }
    }
}

/// Extinction by the values of another field than that which gives the colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Opacity {
    /// Name of the field.
    pub field: String,
    /// From values to extinction; its colours have no meaning.
    pub transfer: TransferFunction,
}

/// Where something lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Level {
    /// On the opaque core: on the lowest layer, and round under holes of the mesh.
    Ground,
    /// On a layer of the first field, counted from the innermost.
    Layer(usize),
    /// On the outermost layer.
    Top,
    /// At a height above the planet's surface, metres, before exaggeration.
    Height(f64),
}

/// Colours of a surface.
#[derive(Debug, Clone, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a scene has few of them")]
pub enum Paint {
    /// One linear RGB colour.
    Plain([f64; 3]),
    /// By a field's values.
    Field {
        /// Name of the field.
        field: String,
        /// From values to colours; its extinctions have no meaning.
        transfer: TransferFunction,
        /// Colour map and opacities of the transfer function; `None` if its knots are given.
        coloring: Option<Coloring>,
        /// Whether each cell has one colour, that of its centre; else values are interpolated.
        by_cell: bool,
    },
}

impl Paint {
    /// The field that colours, if one does.
    fn field(&self) -> Option<&str> {
        match self {
            Paint::Plain(_) => None,
            Paint::Field { field, .. } => Some(field),
        }
    }
}

/// A coloured level.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Where it lies; not [`Level::Ground`], whose colours are [`Ground`]'s.
    pub at: Level,
    /// Its colours.
    pub paint: Paint,
    /// The part of the light behind that it absorbs, above 0 and at most 1.
    pub opacity: f64,
}

/// A surface on which a field has one value.
#[derive(Debug, Clone, PartialEq)]
pub struct Isosurface {
    /// Name of the field.
    pub field: String,
    /// The value.
    pub value: f64,
    /// Its colours.
    pub paint: Paint,
    /// The part of the light behind that it absorbs, above 0 and at most 1.
    pub opacity: f64,
}

/// The pattern of lines.
#[derive(Debug, Clone, PartialEq)]
pub enum Pattern {
    /// Edges of the Voronoi cells.
    Cells,
    /// Sides of the dual triangles.
    Triangles,
    /// Meridians and parallels.
    Graticule {
        /// Degrees from one to the next.
        spacing_deg: f64,
    },
    /// Coast lines: Natural Earth 1:110m, and 1:50m where pixels are smaller than 0.06 degrees.
    Coast,
    /// Borders between countries: Natural Earth's, at the scales of coasts.
    Borders,
    /// Lines and outlines of polygons of a file.
    Outlines(Arc<Outlines>),
}

/// Lines on the ground or on a level, drawn anti-aliased.
#[derive(Debug, Clone, PartialEq)]
pub struct Lines {
    /// The pattern of the lines.
    pub pattern: Pattern,
    /// Where they lie.
    pub on: Level,
    /// Linear RGB.
    pub color: [f64; 3],
    /// Width in pixels.
    pub width_px: f64,
    /// Opacity, above 0 and at most 1.
    pub opacity: f64,
    /// Where they are drawn; `None` is everywhere.
    pub region: Option<LonLatBox>,
}

/// A box in longitude and latitude, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LonLatBox {
    /// From western to eastern end; the second is the larger, by at most 360.
    pub lon_deg: [f64; 2],
    /// From south to north.
    pub lat_deg: [f64; 2],
}

impl LonLatBox {
    /// Whether the direction of a point lies in the box.
    #[inline]
    pub fn holds(&self, at: DVec3) -> bool {
        let lat = at.z.atan2(at.x.hypot(at.y)).to_degrees();
        let east = (at.y.atan2(at.x).to_degrees() - self.lon_deg[0]).rem_euclid(360.0);
        lat >= self.lat_deg[0] && lat <= self.lat_deg[1] && east <= self.lon_deg[1] - self.lon_deg[0]
    }
}

/// Colours of the opaque core, in place of its one colour.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Ground {
    /// Linear RGB of land.
    pub land: Option<[f64; 3]>,
    /// Linear RGB of the sea.
    pub ocean: Option<[f64; 3]>,
}

/// A part of space that is cut away, or outside of which all is: where all of its conditions hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// Whether the inside is cut away; else the outside.
    pub cuts_inside: bool,
    /// A box in longitude and latitude.
    pub region: Option<LonLatBox>,
    /// From layer to layer, counted from the innermost of the first field; both included.
    pub layers: Option<[usize; 2]>,
    /// From height to height above the planet's surface, metres, before exaggeration.
    pub height_m: Option<[f64; 2]>,
    /// Beyond a plane.
    pub half_space: Option<HalfSpace>,
}

/// The points beyond a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// Longitude and latitude, in degrees, of the direction in which it lies.
    pub towards_deg: [f64; 2],
    /// How far from the planet's centre the plane is in that direction, in planet radii; may be negative.
    pub distance: f64,
}

/// A field that is made of others when a frame is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Derivation {
    /// Its name.
    pub name: String,
    /// Its definition.
    pub how: How,
}

/// How a field is made of others, value by value.
#[derive(Debug, Clone, PartialEq)]
pub enum How {
    /// The length of the vector of two or three fields.
    Magnitude(Vec<String>),
    /// The sum of fields times numbers.
    Combination(Vec<(f64, String)>),
    /// A field less its mean over the cells of the same latitude, layer by layer.
    FromZonalMean {
        /// Name of the field.
        field: String,
        /// Width of the bands of latitude, degrees.
        band_deg: f64,
    },
    /// A field less what it was in the first step that was drawn.
    FromFirst(String),
}

impl How {
    /// Names of the fields that it is made of.
    pub fn fields(&self) -> Vec<&str> {
        match self {
            How::Magnitude(fields) => fields.iter().map(String::as_str).collect(),
            How::Combination(terms) => terms.iter().map(|(_, field)| field.as_str()).collect(),
            How::FromZonalMean { field, .. } | How::FromFirst(field) => vec![field],
        }
    }
}

/// Where layers lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Heights {
    /// Concentric, at the layers' mean heights.
    #[default]
    Mean,
    /// Each column at its own, where they are given.
    Native,
}
