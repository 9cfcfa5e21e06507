//! In-situ ray casting of geodesic grids: icoray borrows the tables and fields of a climate or ocean model (MPAS, ICON
//! and other meshes of hexagons and pentagons), renders them on the CPU with an error estimate per pixel, and writes
//! pictures. The method is that of Xie, Yu and Ma, *Interactive Ray Casting of Geodesic Grids* (2013,
//! doi:10.1111/cgf.12135), with a walk that cannot lose a ray.
//!
//! # A first picture
//!
//! A generated mesh of 2,562 cells in place of a model's tables, and a wave in place of its field:
//!
//! ```standalone_crate
//! use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene, output};
//!
//! let mesh = IcosahedralMesh::new(4)?;
//! let grid = Grid::new(mesh.tables())?;
//! let layers = Layers::from_heights(&[0.0, 5e3, 10e3], 6.371e6)?; // metres; the planet's radius
//! let wave = |(lon, lat): (&f64, &f64)| [(6.0 * lon).cos() * (2.0 * lat).sin(); 3]; // of a cell, on three layers
//! let values: Vec<f64> = mesh.lon_center_rad.iter().zip(&mesh.lat_center_rad).flat_map(wave).collect();
//! let field = Field::level_fastest(&values, 3, Location::Center)?;
//! let scene = Scene::parse("field = 'wave'
//!     exaggeration = 40
//!     core = '#8090a0'
//!     camera = { lon = 10, lat = 40, distance = 5 }
//!     light = { kind = 'sun', lon = -20, lat = 45, ambient = 0.5, diffuse = 0.7 }
//!     [transfer]
//!     map = 'vik'
//!     range = [-1.5, 1.5]
//!     opacity = [[-0.8, 0.9], [-0.3, 0], [0.3, 0], [0.8, 0.9]]
//!     unit_length = 0.05")?;
//! let frame = Renderer::new(0)?.render(&scene, &grid, &layers, &field)?; // on all processors
//! # let folder = std::env::temp_dir().join(format!("icoray-doc-first-{}", std::process::id()));
//! # std::fs::create_dir_all(&folder).unwrap();
//! # std::env::set_current_dir(&folder).unwrap();
//! output::write_picture("first.png".as_ref(), &frame)?;
//! # let count = |is: fn(&&[f32; 4]) -> bool| frame.pixels.iter().filter(is).count();
//! # let orange = count(|pixel| pixel[0] > 2.0 * pixel[2]);
//! # let blue = count(|pixel| pixel[2] > 2.0 * pixel[0]);
//! # assert!(orange.min(blue) > frame.pixels.len() / 20, "{orange} orange, {blue} blue");
//! # std::fs::remove_dir_all(&folder).unwrap();
//! # Ok::<(), icoray::Error>(())
//! ```
//!
//! The same with coasts, a colour bar and comments is
//! [examples/rust](https://github.com/icoray/icoray/tree/main/examples/rust).
//!
//! # Overview
//!
//! - **Grid**: [`GridTables`] are a model's six index tables in 32 or 64 bits, [`Grid`] checks and borrows them.
//! - **Field**: [`Field`] borrows values in the memory layout that a [`Shape`] describes; [`Layers`] are their heights.
//! - **Scene**: [`Scene`] describes the picture: [`Camera`], [`TransferFunction`], [`Lighting`], [`Surface`]s,
//!   [`Clip`]s; [`Script`] has several views and a schedule. Both are TOML, whose keys are listed by [`keys`].
//! - **Plan**: [`Plan`] lists the data of a grid that a scene needs (layers, blocks, gradients, bytes), before it is
//!   rendered.
//! - **Render**: [`Renderer`] makes a [`Frame`] with its [`FrameReport`]; [`Background`] renders copies of fields while
//!   the model computes on; [`ranks`] share a picture; [`device`]s render in place of the CPU.
//! - **Output**: [`output`] writes frames as PNG and EXR, with labels and `report.csv`, in place or on a thread.
//!
//! # Features and further crates
//!
//! This crate has no features: all that needs a library of the system or a large dependency is a crate of its own.
//! `icoray-gpu` is a [`device`] (Vulkan, by wgpu), `icoray-mpi` a [`Team`] of [`ranks`], `icoray-netcdf` reads model
//! files, `icoray-live` serves a page that shows and steers a program, and `icoray-cli` is the command `icoray`.
//!
//! # Supported Rust versions
//!
//! Rust 1.89 and later. Only a minor version of icoray may require a later Rust, which is then at least six months
//! old.
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
pub mod suggest;
mod time_budget;

// The tests of the public interface share these with the tests of modules.
#[cfg(test)]
#[path = "../tests/suite/common.rs"]
mod common;
#[cfg(test)]
#[path = "../tests/suite/culled/mod.rs"]
mod culled;
#[cfg(test)]
extern crate self as icoray;
#[cfg(test)]
#[path = "../tests/suite/spread/mod.rs"]
mod spread;

pub use background::{Accepted, Background, Drawn, FrameInputs, FrameSetup};
pub use fields::Fields;
pub use icoray_grid::{
    ColumnCount, ComputedField, Connectivity, Description, Dimension, Error, ErrorKind, Field, Grid, GridTables,
    IcosahedralMesh, Indices, Layers, Location, LonLat, MAX_LEVEL, OwnedGrid, OwnedReals, OwnedTables, Reals, Result,
    Shape, circumcenter, cut_polygon, memory, printable,
};
pub use icoray_kernel::ground::coast_runs;
pub use icoray_kernel::{Counts, Frustum, Stretch, Traversal};
pub use icoray_output::{
    CellsPerPixel, Certainty, Colors, DeviceReport, ErrorSummary, Frame, FrameReport, Legend, RanksReport,
    SamplingError, SamplingReport, Sharing, Timing,
};
pub use icoray_scene::{
    Adapter, Backend, Camera, Clip, ColorRange, Coloring, Condition, Derivation, Ground, HalfSpace, Heights, How,
    Isosurface, Knot, LabelPlace, Labels, Level, LightSource, Lighting, Lights, Lines, Live, LonLatBox, Method,
    Opacity, Paint, Pattern, Precision, Quality, Scale, Scene, Scenery, Scheme, Script, Shot, Statistic, Summary,
    Surface, TransferFunction, View, Volume, color_map_stops, color_maps, did_you_mean, keys, srgb8,
};
pub use plan::{FrameMemory, Plan, Savings};
pub use ranks::{Columns, Decomposition, DistributedGrid, Owned, PartCells, PartCorners, Ranks, Team};
pub use render::{Contribution, Histogram, Probe, ProbePoint, Rendered, Renderer, ScenePart};

/// Writes pictures and their report to disk: one at a time, or on a thread while the model goes on.
///
/// ```
/// # use icoray::{Field, Grid, IcosahedralMesh, Layers, Location, Renderer, Scene};
/// # let mesh = IcosahedralMesh::new(2)?;
/// # let grid = Grid::new(mesh.tables())?;
/// # let layers = Layers::from_heights(&[0.0, 1e6], 6.371e6)?;
/// # let values = vec![1.0f32; 2 * grid.cells()];
/// # let field = Field::level_fastest(&values, 2, Location::Center)?;
/// # let scene = Scene::parse("field = 'one'\nimage = { width = 8, height = 8 }")?;
/// # let folder = std::env::temp_dir().join(format!("icoray-doc-{}", std::process::id()));
/// # std::fs::create_dir_all(&folder).unwrap();
/// use icoray::output::{Stamp, Writer, WriterOptions, write_picture};
///
/// let frame = Renderer::new(1)?.render(&scene, &grid, &layers, &field)?;
/// write_picture(&folder.join("picture.png"), &frame)?;
/// write_picture(&folder.join("picture.exr"), &frame)?;
///
/// let writer = Writer::new(WriterOptions::new(&folder))?;
/// writer.submit(frame, scene.output.clone(), Stamp { step: 7, ..Stamp::default() });
/// writer.wait();
/// for name in ["picture.png", "picture.exr", "one_000007.png", "report.csv"] {
///     assert!(folder.join(name).is_file(), "{name}");
/// }
/// # std::fs::remove_dir_all(&folder).unwrap();
/// # Ok::<(), icoray::Error>(())
/// ```
pub mod output {
    pub use icoray_output::{
        Animated, Existing, Outcome, Outcomes, Submitted, WhenFull, Writer, WriterOptions, Written, exr_bytes, figures,
        png_bytes, png_layers, printed_units, rgba8, write_animation, write_color_maps, write_error_map, write_frame,
        write_picture, write_picture_with, write_text,
    };
    pub use icoray_scene::name::{Cinema, Concat, FrameNames, NameTemplate, Output, Series, Stamp};
}

/// The library's version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
