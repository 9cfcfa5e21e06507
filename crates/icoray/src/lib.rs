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

mod background;
mod cells_per_pixel;
mod compose;
mod derive;
pub mod device;
mod edges;
mod fields;
mod plan;
mod ranges;
pub mod ranks;
mod raster;
mod render;
mod sampling;
mod scattered;
mod snapshot;
pub mod suggest;
mod time_budget;

pub use background::{Accepted, Background, Drawn, Job};
pub use fields::Fields;
pub use icoray_grid::memory;
pub use icoray_grid::{
    CenterField, ColumnCount, Connectivity, Description, Dimension, Error, ErrorKind, Field, Grid, GridTables,
    IcosahedralMesh, Indices, Layers, Location, LonLat, MAX_LEVEL, OwnedReals, Reals, Result, Shape,
};
pub use icoray_kernel::{Counts, Frustum, Stretch, Traversal};
pub use icoray_output::{
    CellsPerPixel, Certainty, Colors, DeviceReport, ErrorSummary, Frame, FrameReport, Legend, RanksReport,
    SamplingError, SamplingReport, Sharing, Timing,
};
pub use icoray_scene::{
    Adapter, Backend, Camera, Clip, ColorRange, Coloring, Condition, Derivation, Ground, HalfSpace, Heights, How,
    Isosurface, Knot, LabelPlace, Labels, Level, Lighting, Lights, Lines, Live, LonLatBox, Method, Opacity, Paint,
    Pattern, Precision, Quality, Scale, Scene, Scenery, Scheme, Script, Shot, Source, Statistic, Summary, Surface,
    TransferFunction, View, Volume,
};
pub use icoray_scene::{color_map_stops, color_maps, keys, srgb8};
pub use plan::{FrameMemory, Plan, Savings};
pub use ranks::{Columns, Decomposition, Owned, Part, PartCells, PartCorners, Ranks, Team};
pub use render::{Histogram, Probe, ProbePoint, Rendered, Renderer};
pub use snapshot::Snapshot;

/// Pictures and their report on disk: one at a time, or on a thread that writes while the model goes on.
///
/// ```
/// # use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
/// # let mesh = IcosahedralMesh::new(2)?;
/// # let grid = Grid::new(mesh.tables())?;
/// # let layers = Layers::from_heights(&[0.0, 1e6], 6.371e6)?;
/// # let values = vec![1.0f32; 2 * grid.cells()];
/// # let shape = Shape::cell_fastest(grid.cells(), 2);
/// # let field = Field::new(values.as_slice().into(), shape, Location::Center, None)?;
/// # let scene = Scene::parse(
/// #     "field = 'one'
/// #      image = { width = 8, height = 8 }
/// #      camera = { lon = 0, lat = 0, distance = 3 }
/// #      transfer = { map = 'viridis', range = [0, 2], opacity = [[0, 0.5], [2, 0.5]] }",
/// # )?;
/// let frame = Renderer::new(1)?.render(&scene, &grid, &layers, &field)?;
/// let folder = std::env::temp_dir().join(format!("icoray-doc-{}", std::process::id()));
/// std::fs::create_dir_all(&folder).unwrap();
/// icoray::output::write_picture(&folder.join("picture.png"), &frame)?;
/// icoray::output::write_picture(&folder.join("picture.exr"), &frame)?;
/// assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 2);
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), icoray::Error>(())
/// ```
///
/// With a writer of its own:
///
/// ```
/// # use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, Shape};
/// # let mesh = IcosahedralMesh::new(2)?;
/// # let grid = Grid::new(mesh.tables())?;
/// # let layers = Layers::from_heights(&[0.0, 1e6], 6.371e6)?;
/// # let values = vec![1.0f32; 2 * grid.cells()];
/// # let shape = Shape::cell_fastest(grid.cells(), 2);
/// # let field = Field::new(values.as_slice().into(), shape, Location::Center, None)?;
/// # let scene = Scene::parse(
/// #     "field = 'one'
/// #      image = { width = 8, height = 8 }
/// #      camera = { lon = 0, lat = 0, distance = 3 }
/// #      transfer = { map = 'viridis', range = [0, 2], opacity = [[0, 0.5], [2, 0.5]] }",
/// # )?;
/// use icoray::output::{Stamp, Writer, WriterOptions};
///
/// let frame = Renderer::new(1)?.render(&scene, &grid, &layers, &field)?;
/// let folder = std::env::temp_dir().join(format!("icoray-doc-writer-{}", std::process::id()));
/// let writer = Writer::new(WriterOptions::new(&folder))?;
/// writer.submit(frame, scene.output.clone(), Stamp { step: 7, ..Stamp::default() });
/// writer.wait();
/// assert!(folder.join("one_000007.png").is_file() && folder.join("report.csv").is_file());
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), icoray::Error>(())
/// ```
pub mod output {
    pub use icoray_output::{
        Animated, Existing, Mask, Outcome, Outcomes, Submitted, WhenFull, Writer, WriterOptions, Written, exr_bytes,
        png_bytes, printed_units, rgba8, write_animation, write_error_map, write_error_map_with, write_frame,
        write_frame_with, write_picture, write_picture_with,
    };
    pub use icoray_scene::name::{FrameNames, NameTemplate, Output, Stamp};
    pub use icoray_scene::series::{Cinema, Concat, Series};
}

/// The library's version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
