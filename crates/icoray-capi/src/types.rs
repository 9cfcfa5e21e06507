//! The structs and numbers that cross the boundary.
#![expect(non_camel_case_types, reason = "the names are C's")]

use std::ffi::{c_char, c_void};

/// What a call says. Numbers are fixed for ever; new ones are added at the end.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum icoray_status {
    /// All went well.
    ICORAY_OK = 0,
    /// A pointer that must not be NULL is NULL.
    ICORAY_ERR_NULL = 1,
    /// A struct_size is not the size of the struct in this library's header.
    ICORAY_ERR_STRUCT_SIZE = 2,
    /// A number or string is out of its range.
    ICORAY_ERR_ARGUMENT = 3,
    /// A grid table contradicts itself or another; the message names table, row and value.
    ICORAY_ERR_GRID = 4,
    /// The grid is right but not supported yet (holes).
    ICORAY_ERR_UNSUPPORTED = 5,
    /// Layer radii are not strictly monotone, positive and finite.
    ICORAY_ERR_LAYERS = 6,
    /// A field is missing, or its shape does not fit grid and layers.
    ICORAY_ERR_FIELD = 7,
    /// The scene is wrong; the message names line and key.
    ICORAY_ERR_SCENE = 8,
    /// A call came before what it needs.
    ICORAY_ERR_ORDER = 9,
    /// A file could not be read or written.
    ICORAY_ERR_IO = 10,
    /// A bug in icoray. The context takes no more calls but icoray_last_error and icoray_close.
    ICORAY_ERR_INTERNAL = 11,
}

/// icoray_array.type, icoray_grid.real_type: float.
pub const ICORAY_F32: i32 = 1;
/// icoray_array.type, icoray_grid.real_type: double.
pub const ICORAY_F64: i32 = 2;
/// icoray_array.location: values at cell centres.
pub const ICORAY_CENTER: i32 = 0;
/// icoray_array.location: values at cell corners; averaged to centres before rendering.
pub const ICORAY_CORNER: i32 = 1;

/// How a context is opened. All zero but struct_size is a good choice.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_config {
    /// sizeof(icoray_config)
    pub struct_size: usize,
    /// Directory of the pictures and report.csv, made when missing; NULL is the working directory.
    pub output_dir: *const c_char,
    /// Threads that render; 0 is as many as the affinity mask allows.
    pub threads: i32,
}

/// The six tables of a geodesic grid, borrowed until icoray_close or the next icoray_grid_set.
///
/// Index tables are row-major and number cells, corners and edges from index_base. Rows may be in any order and wind
/// either way. A triangle of the dual mesh is a corner with its three cells.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_grid {
    /// sizeof(icoray_grid)
    pub struct_size: usize,
    /// Number of cells.
    pub cells: i64,
    /// Number of corners.
    pub corners: i64,
    /// Number of edges.
    pub edges: i64,
    /// 0 or 1: the number of the first cell, corner and edge.
    pub index_base: i32,
    /// ICORAY_F32 or ICORAY_F64, for the four coordinate arrays.
    pub real_type: i32,
    /// Longitudes of the cell centres, radians (MPAS lonCell).
    pub lon_center_rad: *const c_void,
    /// Latitudes of the cell centres, radians (MPAS latCell).
    pub lat_center_rad: *const c_void,
    /// Longitudes of the corners, radians (MPAS lonVertex).
    pub lon_corner_rad: *const c_void,
    /// Latitudes of the corners, radians (MPAS latVertex).
    pub lat_corner_rad: *const c_void,
    /// Corners of each cell: cells x cell_corner_row (MPAS verticesOnCell).
    pub cell_corner: *const i32,
    /// Row length of cell_corner: 6, or MPAS's maxEdges.
    pub cell_corner_row: i64,
    /// How many entries of each cell_corner row count (MPAS nEdgesOnCell); NULL where a cell with fewer corners repeats
    /// one of them.
    pub cell_corner_count: *const i32,
    /// The three cells at each corner: corners x 3 (MPAS cellsOnVertex).
    pub corner_cell: *const i32,
    /// The three edges at each corner: corners x 3 (MPAS edgesOnVertex).
    pub corner_edge: *const i32,
    /// The two corners of each edge: edges x 2 (MPAS verticesOnEdge).
    pub edge_corner: *const i32,
}

/// Layers, copied by the call.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_layers {
    /// sizeof(icoray_layers)
    pub struct_size: usize,
    /// Number of radii, at least 2.
    pub count: i64,
    /// Radii from the planet's centre in metres, strictly rising or strictly falling, in the order of the fields'
    /// layers. A field with one layer fewer lies midway between them.
    pub radius_m: *const f64,
    /// Radius of the planet's surface in metres: vertical exaggeration stretches heights above it.
    pub planet_radius_m: f64,
}

/// A field: value (column, layer) is element column*column_stride + layer*layer_stride of data. Borrowed: read during
/// icoray_execute, so the array must live until it is replaced or the context is closed.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_array {
    /// sizeof(icoray_array)
    pub struct_size: usize,
    /// Value (0, 0).
    pub data: *const c_void,
    /// ICORAY_F32 or ICORAY_F64.
    pub r#type: i32,
    /// ICORAY_CENTER or ICORAY_CORNER.
    pub location: i32,
    /// Number of columns: cells of the grid, or corners for ICORAY_CORNER.
    pub columns: i64,
    /// Number of layers: count of icoray_layers, or one fewer.
    pub layers: i64,
    /// Elements from a column to the next; may be negative.
    pub column_stride: i64,
    /// Elements from a layer to the next; may be negative.
    pub layer_stride: i64,
    /// Not 0: fill_value marks missing values. NaN and infinities always do.
    pub has_fill: i32,
    /// The value that marks missing values.
    pub fill_value: f64,
}

/// What the last frame cost and how exact it is. Seconds are wall clock.
///
/// Errors are how far a channel of a pixel may be from the exact integral along the pixel's ray: of premultiplied linear
/// channels, 0 to 1, the largest of each pixel. What the interpolation between cells and layers itself is off is not in them.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct icoray_frame_report {
    /// sizeof(icoray_frame_report)
    pub struct_size: usize,
    /// Step given to icoray_execute.
    pub step: i64,
    /// Time given to icoray_execute.
    pub time_s: f64,
    /// Value range, averages of corner fields, gradients.
    pub prepare_s: f64,
    /// Rays.
    pub render_s: f64,
    /// Encoding and disk.
    pub write_s: f64,
    /// Rays that met the shell.
    pub rays: u64,
    /// Columns that they walked over.
    pub columns: u64,
    /// Frusta that they crossed.
    pub frusta: u64,
    /// Frusta among these that a missing value made void.
    pub void_frusta: u64,
    /// Least value of the field; NaN when all are missing.
    pub value_min: f64,
    /// Greatest value of the field; NaN when all are missing.
    pub value_max: f64,
    /// Values that are NaN, infinite or the fill value.
    pub missing_values: u64,
    /// Bytes that were derived from the field: averages, gradients.
    pub derived_bytes: u64,
    /// Largest error of a pixel.
    pub error_max: f64,
    /// Mean error of the pixels whose error is above 0; 0 where there is none.
    pub error_mean: f64,
    /// 99.9th percentile of the errors above 0; 0 where there is none.
    pub error_p999: f64,
    /// The largest error that was allowed in a traced pixel: the scene's tolerance, or more to stay inside its
    /// time_budget_ms.
    pub tolerance: f64,
    /// 1 where the errors are bounds (unlit, in f64), 0 where they are estimates.
    pub error_is_bound: i32,
    /// Each how many-th pixel was traced, in both directions, those between being interpolated: 1, or more to stay inside
    /// the scene's time_budget_ms.
    pub pixel_step: i32,
    /// Light: 0 off, 1 coarse (to stay inside the time budget), 2 full.
    pub lights: i32,
}
