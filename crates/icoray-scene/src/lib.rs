//! Scenes: the description of pictures in a scene file.
//!
//! A scene is TOML; `examples/scenes/` has annotated ones. Lengths are in planet radii, heights that end in `_m` in
//! metres, angles in degrees, colours are CSS colours (`"#ff8800"`, `"steelblue"`) in sRGB. Unknown keys and bad values
//! are errors with line and key.
//!
//! [`Scene`] is one picture's, [`Script`] a whole file with its views, sweeps and moving cameras. [`keys`] is the schema of
//! both, and the scene reference of icoray's book lists it, with examples.
#![forbid(unsafe_code)]

mod camera;
mod color;
mod coloring;
pub mod keys;
mod labels;
pub mod name;
mod outlines;
pub mod painting;
mod parse;
mod quality;
pub mod scene;
mod scenery;
mod script;
pub mod template;
mod transfer;
mod values;

pub use camera::Camera;
pub use color::{color_map_stops, color_maps, is_color_map, srgb8};
pub use coloring::{ColorRange, Coloring, Scale};
pub use labels::{LabelPlace, Labels};
pub use outlines::Outlines;
pub use parse::hint::did_you_mean;
pub use quality::{Lights, Quality};
pub use scene::{Adapter, Backend, LightSource, Lighting, Method, Precision, Scene, Scheme};
pub use scenery::{
    Clip, Derivation, Ground, HalfSpace, Heights, How, Isosurface, Level, Lines, LonLatBox, Opacity, Paint, Pattern,
    Scenery, Surface, Volume,
};
pub use script::{Condition, Live, Script, Shot, Statistic, Summary, View};
pub use transfer::{Knot, TransferFunction};
