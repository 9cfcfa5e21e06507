//! In-situ ray casting of geodesic grids: the core library.
//!
//! A model's six connectivity tables become a [`Grid`], its arrays [`Field`]s, both borrowed; a [`Scene`] says what to
//! draw; a [`Renderer`] makes a [`Frame`] of them, and [`output`] writes it. The method is that of Xie, Yu and Ma,
//! *Interactive Ray Casting of Geodesic Grids* (2013, doi:10.1111/cgf.12135), with a walk that cannot lose a ray.
//!
//! ```
//! use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
//!
//! let mesh = IcosahedralMesh::new(3)?;
//! let grid = Grid::new(mesh.tables())?;
//! let layers = Layers::from_heights(&[0.0, 50e3, 100e3], 6.371e6)?;
//! let values: Vec<f32> = (0..grid.cells() * 3).map(|i| (i % 3) as f32).collect();
//! let field = Field::new(values.as_slice().into(), Shape::level_fastest(grid.cells(), 3), Location::Center, None)?;
//! let scene = Scene::parse(r##"
//!     field = "level"
//!     exaggeration = 10
//!     [image]
//!     width = 64
//!     height = 64
//!     [camera]
//!     lon = 10
//!     lat = 40
//!     distance = 4
//!     [transfer]
//!     map = "viridis"
//!     range = [0, 2]
//!     opacity = [[0, 0.0], [2, 0.9]]
//! "##)?;
//! let frame = Renderer::new(0)?.render(&scene, &grid, &layers, &field)?;
//! assert_eq!(frame.pixels.len(), 64 * 64);
//! # Ok::<(), icoray::Error>(())
//! ```
#![forbid(unsafe_code)]

mod array;
mod background;
mod compose;
mod derive;
mod description;
pub mod device;
mod edges;
mod error;
mod field;
mod fields;
mod frame;
mod gradient;
mod grid;
mod ground;
mod heights;
mod kernel;
mod label;
mod layers;
mod layout;
mod numbers;
pub mod output;
mod plan;
mod quality;
mod ranges;
pub mod ranks;
mod raster;
mod render;
mod scene;
mod script;
mod shape;
mod snapshot;
pub mod suggest;
mod threads;
mod traverse;

pub use background::{Accepted, Background, Drawn, Job};
pub use description::Description;
pub use error::{Error, ErrorKind, Result};
pub use field::{CenterField, Field, Location};
pub use fields::Fields;
pub use frame::{Certainty, Colors, Counts, ErrorSummary, Frame, FrameReport};
pub use grid::{Connectivity, Grid, GridTables, IcosahedralMesh, Indices, LonLat, MAX_LEVEL, Reals};
pub use kernel::piece::Method;
pub use label::{Labels, Legend, Place};
pub use layers::Layers;
pub use layout::{ColumnCount, Dimension};
pub use plan::{Plan, Savings, Sharing};
pub use quality::{Lights, Quality};
pub use ranks::{Columns, Held, Owned, Part, PartCells, Ranks, Team};
pub use render::{Rendered, Renderer};
pub use scene::{
    Adapter, Backend, Camera, Clip, ColorRange, Coloring, Derivation, Ground, HalfSpace, Heights, How,
    Isosurface, Knot, Level, Lighting, Lines, LonLatBox, Opacity, Paint, Pattern, Precision, Scale, Scene,
    Scenery, Scheme, Source, Surface, TransferFunction, Volume,
};
pub use script::{Condition, Script, Shot, Statistic, Summary, View};
pub use shape::Shape;
pub use snapshot::Snapshot;
pub use traverse::{Frustum, Stretch, Traversal};

/// The library's version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
