//! Scenes: the description of pictures in a scene file.
//!
//! A scene is TOML; `examples/scenes/` has annotated ones. Lengths are in planet radii, heights that end in `_m` in
//! metres, angles in degrees, colours are CSS colours (`"#ff8800"`, `"steelblue"`) in sRGB. Unknown keys and bad values
//! are errors with line and key.
//!
//! A plain scene shows one volume, by `field` and `[transfer]`. All else that a scene may show is below; each list may
//! have any number of entries, and what is left out costs nothing.
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
#![forbid(unsafe_code)]

mod backend;
mod camera;
mod color;
mod coloring;
pub mod keys;
mod labels;
mod method;
pub mod name;
pub mod painting;
mod parse;
mod quality;
mod scale;
pub mod scene;
mod scenery;
mod script;
pub mod series;
pub mod template;
mod transfer;
mod values;

pub use backend::{Adapter, Backend};
pub use camera::Camera;
pub use coloring::{ColorRange, Coloring};
pub use labels::{LabelPlace, Labels};
pub use method::Method;
pub use quality::{Lights, Quality};
pub use scale::Scale;
pub use scene::{Lighting, Precision, Scene, Scheme, Source};
pub use scenery::{
    Clip, Derivation, Ground, HalfSpace, Heights, How, Isosurface, Level, Lines, LonLatBox, Opacity, Paint, Pattern,
    Scenery, Surface, Volume,
};
pub use script::{Condition, Live, Script, Shot, Statistic, Summary, View};
pub use transfer::{Knot, TransferFunction};

/// Whether there is a colour map of this name.
pub fn is_color_map(name: &str) -> bool {
    color::ColorMap::named(name).is_some()
}

/// A linear colour, 0 to 1, in 8-bit sRGB.
pub fn srgb8(linear: [f64; 3]) -> [u8; 3] {
    color::srgb8(linear)
}

/// The colours of a map at `count` places from its beginning to its end, at least two, in 8-bit sRGB.
pub fn color_map_stops(name: &str, count: usize) -> Option<Vec<[u8; 3]>> {
    let map = color::ColorMap::named(name)?;
    let last = count.max(2) - 1;
    Some((0..=last).map(|k| color::srgb8(map.at(k as f64 / last as f64))).collect())
}

/// Names of the colour maps.
pub fn color_maps() -> &'static str {
    &color::MAPS
}
