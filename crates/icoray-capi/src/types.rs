//! The structs and numbers that cross the boundary.
#![expect(non_camel_case_types, reason = "the names are C's")]

use bytemuck::CheckedBitPattern;
/// Declared with the list of a frame's figures.
pub use icoray_core::output::figures::CFrameReport as icoray_frame_report;
use serde::{Deserialize, Serialize};
use std::ffi::{c_char, c_void};

/// Status of a call. Numbers never change; new ones are added at the end.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, CheckedBitPattern)]
pub enum icoray_status {
    /// Success.
    ICORAY_OK = 0,
    /// A pointer that must not be NULL is NULL.
    ICORAY_ERR_NULL = 1,
    /// struct_size differs from the size of the struct in this library's header.
    ICORAY_ERR_STRUCT_SIZE = 2,
    /// A number or string is out of range.
    ICORAY_ERR_ARGUMENT = 3,
    /// A grid table contradicts itself or another table; the message names table, row and value.
    ICORAY_ERR_GRID = 4,
    /// Not supported: MPI in a library built without it or for another MPI.
    ICORAY_ERR_UNSUPPORTED = 5,
    /// Layer radii are not positive, finite and strictly monotone, or heights of columns are wrong.
    ICORAY_ERR_LAYERS = 6,
    /// A field is missing, or its shape does not fit the grid and layers.
    ICORAY_ERR_FIELD = 7,
    /// The scene is wrong; the message names the line and key.
    ICORAY_ERR_SCENE = 8,
    /// A call that must come before this one is missing.
    ICORAY_ERR_ORDER = 9,
    /// A file could not be read or written.
    ICORAY_ERR_IO = 10,
    /// A bug in icoray. The context accepts only icoray_last_error and icoray_close from now on.
    ICORAY_ERR_INTERNAL = 11,
    /// The picture exists and is not replaced (icoray_config.existing). Nothing was rendered.
    ICORAY_ERR_EXISTS = 12,
    /// The context has switched itself off after too many failures (icoray_config.on_error).
    ICORAY_ERR_DISABLED = 13,
    /// Another thread is in a call on this context, or the context's log callback called it.
    ICORAY_ERR_BUSY = 14,
    /// The context was opened before this process was forked; its threads exist only in the parent process.
    ICORAY_ERR_FORKED = 15,
    /// MPI is not initialised or has failed, or ranks differ in call, step, scene or data.
    ICORAY_ERR_MPI = 16,
    /// A grid or a frame needs more than the available memory; the message states the missing bytes.
    ICORAY_ERR_MEMORY = 17,
}

/// icoray_array.type, icoray_grid.real_type: float.
pub const ICORAY_F32: i32 = 1;
/// icoray_array.type, icoray_grid.real_type: double.
pub const ICORAY_F64: i32 = 2;
/// icoray_grid.index_type, icoray_part.index_type: int32_t.
pub const ICORAY_I32: i32 = 3;
/// icoray_grid.index_type, icoray_part.index_type: int64_t.
pub const ICORAY_I64: i32 = 4;
/// icoray_array.location: values at cell centres.
pub const ICORAY_CENTER: i32 = 0;
/// icoray_array.location: values at cell corners; they are averaged to centres before rendering.
pub const ICORAY_CORNER: i32 = 1;

/// icoray_frame_report.scheme: one process rendered the picture.
pub const ICORAY_ALONE: i32 = 0;
/// icoray_frame_report.scheme: each rank rendered tiles of the picture.
pub const ICORAY_TILES: i32 = 1;
/// icoray_frame_report.scheme: each node rendered its part of the grid, and the fragments of rays were composed.
pub const ICORAY_FRAGMENTS: i32 = 2;

/// icoray_frame_report.drawn_on: the CPU traced this rank's rays.
pub const ICORAY_CPU: i32 = 0;
/// icoray_frame_report.drawn_on: a GPU traced this rank's rays.
pub const ICORAY_GPU: i32 = 1;
/// icoray_frame_report.drawn_on: a GPU traced this rank's rays, except some that the CPU traced.
pub const ICORAY_GPU_AND_CPU: i32 = 2;

/// icoray_config.existing: existing pictures are kept; icoray_execute returns ICORAY_ERR_EXISTS.
pub const ICORAY_NEVER_MODIFY: i32 = 0;
/// icoray_config.existing: existing pictures are replaced.
pub const ICORAY_OVERWRITE: i32 = 1;
/// icoray_config.on_error: a failure is a status, a message and a warning in the log.
pub const ICORAY_WARN: i32 = 0;
/// icoray_config.on_error: a failure is a status and a message, without a log line.
pub const ICORAY_IGNORE: i32 = 1;
/// icoray_config.on_error: as ICORAY_WARN; after disable_after failed frames in a row the context switches itself
/// off.
pub const ICORAY_DISABLE: i32 = 2;
/// icoray_config.when_full: icoray_execute waits until the writer has taken a frame.
pub const ICORAY_BLOCK: i32 = 0;
/// icoray_config.when_full: the oldest waiting frame is dropped, counted and logged.
pub const ICORAY_DROP_OLDEST: i32 = 1;
/// icoray_config.log_level: no messages.
pub const ICORAY_LOG_OFF: i32 = 0;
/// icoray_config.log_level: errors that switch the context off.
pub const ICORAY_LOG_ERROR: i32 = 1;
/// icoray_config.log_level: also frames that failed or were dropped.
pub const ICORAY_LOG_WARN: i32 = 2;
/// icoray_config.log_level: also each picture that was written.
pub const ICORAY_LOG_INFO: i32 = 3;
/// icoray_config.log_level: also what each frame left out, and how ranks shared it.
pub const ICORAY_LOG_DEBUG: i32 = 4;

/// Log callback. `message` is one line without a newline, valid until the callback returns; `level` is
/// ICORAY_LOG_ERROR to ICORAY_LOG_DEBUG; `user` is icoray_config.log_user. It is called only inside calls on the
/// context, on the caller's thread. It must not throw, longjmp, or call icoray on that context (ICORAY_ERR_BUSY).
pub type icoray_log_fn = Option<unsafe extern "C" fn(user: *mut c_void, level: i32, message: *const c_char)>;

/// Settings of a context. All members may be 0 or NULL except struct_size.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct icoray_config {
    /// sizeof(icoray_config)
    pub struct_size: usize,
    /// Directory of the pictures and of report.csv; created if missing. NULL is the working directory. Copied. Opening
    /// a context fails (ICORAY_ERR_IO) if pictures could not be written there; it leaves nothing there.
    pub output_dir: *const c_char,
    /// Number of rendering threads; 0 is the number of processors in the affinity mask of the thread that opens the
    /// context, divided by the number of ranks of icoray_open on this node whose masks share a processor with it, at
    /// least 1. All threads of icoray, including the writer, inherit the mask: with one processor in it they compete
    /// with the model.
    pub threads: i32,
    /// Existing pictures: ICORAY_NEVER_MODIFY or ICORAY_OVERWRITE.
    pub existing: i32,
    /// Failed frames: ICORAY_WARN, ICORAY_IGNORE or ICORAY_DISABLE. The status is returned in all cases.
    pub on_error: i32,
    /// With ICORAY_DISABLE: number of consecutive failed frames after which the context switches itself off; 0 is
    /// 3.
    pub disable_after: i32,
    /// Nonzero: icoray_execute copies the fields that the step's pictures need, each once, and returns; a thread
    /// renders from the copies. Only one step is in progress: icoray_execute first waits for the frames of the step
    /// before. Over several ranks it must be the same on all; icoray_open describes the transfer of their messages. A
    /// scene with async_render = true switches it on when it is loaded, until the context is closed.
    pub async_render: i32,
    /// Number of frames that may wait for the writing thread, 1 to 1024; 0 is 2.
    pub writer_queue: i32,
    /// If that many frames wait: ICORAY_BLOCK or ICORAY_DROP_OLDEST.
    pub when_full: i32,
    /// Most detailed level that is logged, ICORAY_LOG_OFF to ICORAY_LOG_DEBUG.
    pub log_level: i32,
    /// Log callback; NULL disables the log. icoray_log_stderr is one.
    pub log: icoray_log_fn,
    /// First argument of the log callback.
    pub log_user: *mut c_void,
}

/// The tables of a geodesic grid. They are borrowed until icoray_close or the next icoray_grid_set of the same name,
/// and must not change in that time.
///
/// Index tables are row-major and number cells, corners and edges from index_base. The entries of a row may be in any
/// order and orientation. Each corner with its three cells is a triangle of the dual mesh, over which values are
/// interpolated. The mesh may have holes or cover a part of the sphere: a missing cell in corner_cell, edge in
/// corner_edge or corner in edge_corner and cell_corner is index_base - 1, -1, or one past the last number.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct icoray_grid {
    /// sizeof(icoray_grid)
    pub struct_size: usize,
    /// Number of cells.
    pub cells: i64,
    /// Number of corners.
    pub corners: i64,
    /// Number of edges.
    pub edges: i64,
    /// Number of the first cell, corner and edge: 0 or 1.
    pub index_base: i32,
    /// Type of the four coordinate arrays: ICORAY_F32 or ICORAY_F64.
    pub real_type: i32,
    /// Type of the index tables: ICORAY_I32 or ICORAY_I64.
    pub index_type: i32,
    /// Longitudes of the cell centres: cells values, radians (MPAS lonCell).
    pub lon_center_rad: *const c_void,
    /// Latitudes of the cell centres: cells values, radians (MPAS latCell).
    pub lat_center_rad: *const c_void,
    /// Longitudes of the corners: corners values, radians (MPAS lonVertex).
    pub lon_corner_rad: *const c_void,
    /// Latitudes of the corners: corners values, radians (MPAS latVertex).
    pub lat_corner_rad: *const c_void,
    /// Corners of each cell: cells x cell_corner_row (MPAS verticesOnCell).
    pub cell_corner: *const c_void,
    /// Row length of cell_corner: 6, or MPAS's maxEdges.
    pub cell_corner_row: i64,
    /// Number of valid entries in each row of cell_corner: cells values of index_type (MPAS nEdgesOnCell). NULL if
    /// a cell with fewer corners repeats one of them.
    pub cell_corner_count: *const c_void,
    /// Cells at each corner: corners x 3 (MPAS cellsOnVertex).
    pub corner_cell: *const c_void,
    /// Edges at each corner: corners x 3 (MPAS edgesOnVertex).
    pub corner_edge: *const c_void,
    /// Corners of each edge: edges x 2 (MPAS verticesOnEdge).
    pub edge_corner: *const c_void,
    /// Name of the grid, for contexts with several grids; NULL is the unnamed grid. Copied.
    pub name: *const c_char,
}

/// The cells of a grid that belong to this rank, where the grid or its fields are distributed over the ranks of
/// icoray_open. Read during the call only. Every cell is owned by exactly one rank.
///
/// If `cells` equals the number of cells of the icoray_grid on all ranks, that grid is the rank's part: its own
/// cells and a halo of all cells that share a corner with them, with local numbers. Neighbours beyond the halo are
/// marked as missing. Fields at centres have a column for each of these cells, of which own ones are read; fields at
/// corners have a column for each corner, and those that corner_global and is_corner_owned mark as own are read, or, if
/// no rank has corner_global, those whose first cell in corner_cell is own. What stands in a halo is not read: halos of
/// fields need no exchange before icoray_execute.
///
/// If it differs on any rank, icoray_grid is the whole grid on all ranks, and cell_global holds rows of its tables.
/// Fields at centres have a column for each of the `cells` cells, of which only own ones are read; a halo is not
/// needed. Fields at corners have a column for each of the `corners` corners, whose rows corner_global holds, of which
/// only own ones are read; every corner is owned by exactly one rank. If no rank has corner_global, fields at corners
/// have a column for each corner of the grid, of which those whose first cell in corner_cell is own are read.
///
/// Columns are assembled once per frame in memory shared by the ranks of a node (bytes_copied). With parts, each rank
/// averages fields and heights at corners to its own cells, from the model's arrays and the values at the rim that other
/// ranks own and send, and the averages are assembled instead (bytes_derived); fields of which a scene derives others are
/// assembled as they are. With one rank nothing is copied.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_part {
    /// sizeof(icoray_part)
    pub struct_size: usize,
    /// Name of the grid, set before by icoray_grid_set; NULL is the unnamed grid.
    pub grid: *const c_char,
    /// Number of cells of this rank: rows of cell_global and is_owned.
    pub cells: i64,
    /// Type of cell_global: ICORAY_I32 or ICORAY_I64.
    pub index_type: i32,
    /// Global number of each cell (MPAS indexToCellID), counted from the grid's index_base. For parts, numbers may
    /// have gaps. index_base - 1 is that of a column that is no cell here, such as the copies of cells in NICAM's
    /// halos: it is not own, no corner has it, and it is not read.
    pub cell_global: *const c_void,
    /// Number of own cells, which come first (MPAS nCellsSolve). Ignored if is_owned is not NULL.
    pub owned_cells: i64,
    /// For each cell: nonzero if it is own. NULL if the first owned_cells cells are own.
    pub is_owned: *const i32,
    /// Number of columns of this rank's fields at corners: rows of corner_global and is_corner_owned. For parts, the
    /// number of corners of the icoray_grid. 0 if the rank has none, and if no rank has corner_global.
    pub corners: i64,
    /// Global number of each of these corners, counted from index_base (ICON: the global index of a triangle), of
    /// index_type: with the whole grid's tables, rows there; for parts, numbers may have gaps. NULL as `corners` is 0.
    pub corner_global: *const c_void,
    /// Number of own corners, which come first. Ignored if is_corner_owned is not NULL.
    pub owned_corners: i64,
    /// For each corner: nonzero if it is own. NULL if the first owned_corners corners are own.
    pub is_corner_owned: *const i32,
}

/// Radii of the layers. Copied by the call.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_layers {
    /// sizeof(icoray_layers)
    pub struct_size: usize,
    /// Number of radii, at least 2.
    pub count: i64,
    /// Radii from the planet's centre: count values, metres, positive, strictly rising or strictly falling, in the
    /// order of the fields' layers. A field with count - 1 layers is midway between them.
    pub radius_m: *const f64,
    /// Radius of the planet's surface, metres, above 0. Exaggeration stretches heights above it.
    pub planet_radius_m: f64,
    /// Name of the layers, for contexts with several sets; NULL is the unnamed set. Copied.
    pub name: *const c_char,
}

/// A field with strides. With block = 0, value (column, layer) is element column*column_stride + layer*layer_stride
/// of data. The data are borrowed: they are read during icoray_execute, and must live until the field is replaced
/// or the context is closed. No other thread may write to them during icoray_execute.
///
/// | layout | column_stride | layer_stride | block | block_stride |
/// |---|---|---|---|---|
/// | level-fastest (MPAS) | layers | 1 | 0 | |
/// | cell-fastest | 1 | columns | 0 | |
/// | Fortran's (nproma, layers, blocks) (ICON, NICAM) | 1 | nproma | nproma | nproma*layers |
///
/// Padded rows have a longer column_stride. An array with more columns than the grid (MPAS's nCells + 1) is read up
/// to `columns`. All elements between the lowest and the highest belong to one allocation.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct icoray_array {
    /// sizeof(icoray_array)
    pub struct_size: usize,
    /// Element (0, 0).
    pub data: *const c_void,
    /// ICORAY_F32 or ICORAY_F64.
    pub r#type: i32,
    /// ICORAY_CENTER or ICORAY_CORNER.
    pub location: i32,
    /// Number of columns: cells of the grid, or corners for ICORAY_CORNER; another number is refused by icoray_execute,
    /// whose message names the likely location.
    pub columns: i64,
    /// Number of layers: count of icoray_layers, or count - 1; or 1 of a 2D field, which has the same values on all
    /// layers. A volume of a 2D field is shown as a surface on the innermost layer, unless the scene gives it an opacity.
    pub layers: i64,
    /// Elements from one column to the next; may be negative.
    pub column_stride: i64,
    /// Elements from one layer to the next; may be negative, or 0 if all layers have the same values.
    pub layer_stride: i64,
    /// Columns per block; 0 if columns are not in blocks. Otherwise value (column, layer) is element (column %
    /// block)*column_stride + (column / block)*block_stride + layer*layer_stride. The last block may be partly
    /// filled.
    pub block: i64,
    /// Elements from one block to the next; may be negative.
    pub block_stride: i64,
    /// Nonzero: fill_value marks missing values. NaN and infinities always do.
    pub has_fill: i32,
    /// Value that marks missing values.
    pub fill_value: f64,
    /// Name of the field's grid; NULL is the unnamed grid. Copied.
    pub grid_name: *const c_char,
    /// Name of the field's layers; NULL is the unnamed set. Copied.
    pub layers_name: *const c_char,
}

/// Maximum number of dimensions of an icoray_ndarray.
pub const ICORAY_MAX_RANK: usize = 7;

/// A field as an array of up to seven dimensions. Which dimension holds the layers and which the columns is found
/// from the numbers of layers and of cells or corners, so the grid and layers must be set before.
///
/// Dimensions of extent 1 are ignored. Of two dimensions, one holds the layers and the other the columns, in either
/// order. Of three, one holds the layers and the other two, in order, the columns of a block and the blocks. If
/// several readings fit, the layers are the dimension with as many entries as icoray_layers, else one fewer; among
/// these the second of three, or the first. One that holds the columns alone is that of a 2D field, of 1 layer.
///
/// The dimension of columns may be longer than the grid has cells (or corners) by padding of at most 64, such as the
/// one column more of MPAS's arrays. A dimension that is as long as the grid has corners or edges (or cells, for a
/// field at corners), or one longer, is refused with what it looks like, as is more padding: pass a section of the
/// array, and give the columns of a halo to icoray_grid and icoray_part too. The only block of an array
/// (nproma, layers, 1) may be longer by any number of columns.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_ndarray {
    /// sizeof(icoray_ndarray)
    pub struct_size: usize,
    /// First element: all indices 0.
    pub data: *const c_void,
    /// ICORAY_F32 or ICORAY_F64.
    pub r#type: i32,
    /// ICORAY_CENTER or ICORAY_CORNER.
    pub location: i32,
    /// Number of dimensions, 1 to 7.
    pub rank: i32,
    /// Nonzero: fill_value marks missing values. NaN and infinities always do.
    pub has_fill: i32,
    /// Value that marks missing values.
    pub fill_value: f64,
    /// Extent of each dimension.
    pub extent: [i64; ICORAY_MAX_RANK],
    /// Elements from one index to the next in each dimension; may be negative.
    pub stride: [i64; ICORAY_MAX_RANK],
    /// Name of the field's grid; NULL is the unnamed grid. Copied.
    pub grid_name: *const c_char,
    /// Name of the field's layers; NULL is the unnamed set. Copied.
    pub layers_name: *const c_char,
}
