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
    /// The grid is right but of a kind that is not rendered (none that can be set here).
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
    /// A picture of that name is there and is not replaced (icoray_config.existing); nothing was rendered.
    ICORAY_ERR_EXISTS = 12,
    /// The context has switched itself off after too many failures (icoray_config.on_error).
    ICORAY_ERR_DISABLED = 13,
    /// Another thread is in a call on this context, or the context's log callback called it.
    ICORAY_ERR_BUSY = 14,
    /// The context was opened before this process was forked: its threads are in the other process.
    ICORAY_ERR_FORKED = 15,
    /// MPI is not initialised or has failed, or ranks that draw one picture differ in call, step, scene or data.
    ICORAY_ERR_MPI = 16,
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
/// icoray_array.location: values at cell corners; averaged to centres before rendering.
pub const ICORAY_CORNER: i32 = 1;

/// icoray_frame_report.scheme: one process drew.
pub const ICORAY_ALONE: i32 = 0;
/// icoray_frame_report.scheme: every rank has the whole grid and drew tiles of its own.
pub const ICORAY_TILES: i32 = 1;
/// icoray_frame_report.scheme: each rank drew its own part of the grid, and rays were put together of what ranks had.
pub const ICORAY_FRAGMENTS: i32 = 2;

/// icoray_frame_report.drawn_on: the CPU traced this rank's rays.
pub const ICORAY_CPU: i32 = 0;
/// icoray_frame_report.drawn_on: a GPU did.
pub const ICORAY_GPU: i32 = 1;
/// icoray_frame_report.drawn_on: a GPU did, and left some to the CPU.
pub const ICORAY_GPU_AND_CPU: i32 = 2;

/// icoray_config.existing: a picture that is there is not replaced; icoray_execute says ICORAY_ERR_EXISTS.
pub const ICORAY_NEVER_MODIFY: i32 = 0;
/// icoray_config.existing: a picture of the same name is replaced.
pub const ICORAY_OVERWRITE: i32 = 1;
/// icoray_config.on_error: a failure is a status, a message and a warning in the log.
pub const ICORAY_WARN: i32 = 0;
/// icoray_config.on_error: a failure is a status and a message, and is not logged.
pub const ICORAY_IGNORE: i32 = 1;
/// icoray_config.on_error: as ICORAY_WARN; after disable_after failed frames in a row the context switches itself off.
pub const ICORAY_DISABLE: i32 = 2;
/// icoray_config.when_full: icoray_execute waits until the writer has taken a frame.
pub const ICORAY_BLOCK: i32 = 0;
/// icoray_config.when_full: the oldest frame that waits for the writer is dropped, counted and logged.
pub const ICORAY_DROP_OLDEST: i32 = 1;
/// icoray_config.log_level: nothing.
pub const ICORAY_LOG_OFF: i32 = 0;
/// icoray_config.log_level: what switches the context off.
pub const ICORAY_LOG_ERROR: i32 = 1;
/// icoray_config.log_level: also frames that failed or were dropped.
pub const ICORAY_LOG_WARN: i32 = 2;
/// icoray_config.log_level: also each picture that was written.
pub const ICORAY_LOG_INFO: i32 = 3;
/// icoray_config.log_level: also what each frame left out, and how ranks shared it.
pub const ICORAY_LOG_DEBUG: i32 = 4;

/// Takes the log: one line without its end, valid until the callback returns. Called only inside a call on the context,
/// on the caller's thread. It must not throw, longjmp or call icoray on that context (which says ICORAY_ERR_BUSY).
pub type icoray_log_fn = Option<unsafe extern "C" fn(user: *mut c_void, level: i32, message: *const c_char)>;

/// How a context is opened. All zero but struct_size is a good choice.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_config {
    /// sizeof(icoray_config)
    pub struct_size: usize,
    /// Directory of the pictures and report.csv, made when missing; NULL is the working directory.
    pub output_dir: *const c_char,
    /// Threads that render; 0 is as many as the affinity mask allows. All threads of icoray's, the writer's too, keep the
    /// mask of the thread that opens the context: with one core in it they take turns with the model.
    pub threads: i32,
    /// Pictures that are there already: ICORAY_NEVER_MODIFY or ICORAY_OVERWRITE.
    pub existing: i32,
    /// Frames that fail: ICORAY_WARN, ICORAY_IGNORE or ICORAY_DISABLE. The status is returned either way.
    pub on_error: i32,
    /// With ICORAY_DISABLE: failed frames in a row after which the context switches itself off; 0 is 3.
    pub disable_after: i32,
    /// Not 0: icoray_execute copies the fields that the pictures of the step need, each once, and returns; a thread renders
    /// the copies. One step at a time: icoray_execute first waits for the frames before.
    pub async_render: i32,
    /// Frames that may wait for the thread that writes, 1 to 1024; 0 is 2.
    pub writer_queue: i32,
    /// When that many wait: ICORAY_BLOCK or ICORAY_DROP_OLDEST.
    pub when_full: i32,
    /// The most talkative level that is logged, ICORAY_LOG_OFF to ICORAY_LOG_DEBUG.
    pub log_level: i32,
    /// Takes the log; NULL logs nothing. icoray_log_stderr is one.
    pub log: icoray_log_fn,
    /// Passed to log.
    pub log_user: *mut c_void,
}

/// The six tables of a geodesic grid, borrowed until icoray_close or the next icoray_grid_set of the same name.
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
    /// ICORAY_I32 or ICORAY_I64, for the tables of indices.
    pub index_type: i32,
    /// Longitudes of the cell centres, radians (MPAS lonCell).
    pub lon_center_rad: *const c_void,
    /// Latitudes of the cell centres, radians (MPAS latCell).
    pub lat_center_rad: *const c_void,
    /// Longitudes of the corners, radians (MPAS lonVertex).
    pub lon_corner_rad: *const c_void,
    /// Latitudes of the corners, radians (MPAS latVertex).
    pub lat_corner_rad: *const c_void,
    /// Corners of each cell: cells x cell_corner_row (MPAS verticesOnCell).
    pub cell_corner: *const c_void,
    /// Row length of cell_corner: 6, or MPAS's maxEdges.
    pub cell_corner_row: i64,
    /// How many entries of each cell_corner row count (MPAS nEdgesOnCell); NULL where a cell with fewer corners repeats
    /// one of them.
    pub cell_corner_count: *const c_void,
    /// The three cells at each corner: corners x 3 (MPAS cellsOnVertex).
    pub corner_cell: *const c_void,
    /// The three edges at each corner: corners x 3 (MPAS edgesOnVertex).
    pub corner_edge: *const c_void,
    /// The two corners of each edge: edges x 2 (MPAS verticesOnEdge).
    pub edge_corner: *const c_void,
    /// Name, for contexts with several grids; NULL is the grid of fields that name none. Copied.
    pub name: *const c_char,
}

/// Which cells of a grid are this rank's own, where the grid or its fields are spread over the ranks of icoray_open. Read
/// during the call only. Every cell is own on just one rank.
///
/// Where `cells` is the number of the grid's cells on all ranks, each rank's icoray_grid is its part: own cells and a halo of
/// all cells that share a corner with these, with local numbers; what lies beyond is marked as missing, as beside a hole. Fields
/// have values in the halo too, as after the model's exchange; of fields at corners those at the corners of own cells do.
///
/// Where it is another number on any rank, icoray_grid is the whole grid on all, and cell_global has rows of its tables. Fields
/// are at centres (ICORAY_ERR_FIELD), with a column for each of this rank's cells, of which only own ones are read: a halo is
/// not needed. They are put together in memory that the ranks of a node share, once per frame (bytes_copied).
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_part {
    /// sizeof(icoray_part)
    pub struct_size: usize,
    /// Name of the grid, which icoray_grid_set was given before; NULL is the one without a name.
    pub grid: *const c_char,
    /// Number of rows below: the cells of which this rank has columns.
    pub cells: i64,
    /// ICORAY_I32 or ICORAY_I64, for cell_global.
    pub index_type: i32,
    /// Number of each cell in the whole grid (MPAS indexToCellID), counted from the grid's index_base; of parts there may be
    /// gaps.
    pub cell_global: *const c_void,
    /// The first so many cells are own (MPAS nCellsSolve); not read where is_owned is not NULL.
    pub owned_cells: i64,
    /// For each cell: not 0 where it is own. NULL where these are the first owned_cells.
    pub is_owned: *const i32,
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
    /// Name, for contexts with several sets of layers; NULL is the set of fields that name none. Copied.
    pub name: *const c_char,
}

/// A field: with block 0, value (column, layer) is element column*column_stride + layer*layer_stride of data. Borrowed:
/// read during icoray_execute, so the array must live until it is replaced or the context is closed.
///
/// Level-fastest (MPAS): column_stride = layers, layer_stride = 1. Cell-fastest: column_stride = 1, layer_stride =
/// columns. Blocked, Fortran's (nproma, layers, blocks) (ICON, NICAM): block = nproma, column_stride = 1, layer_stride =
/// nproma, block_stride = nproma*layers. Padded rows have a longer column_stride; an array with more columns than the grid
/// (MPAS's nCells + 1) is read up to columns. All elements from the lowest to the highest lie in one allocation, and no
/// other thread writes to it during icoray_execute.
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
    /// Number of layers, at least 2: count of icoray_layers, or one fewer.
    pub layers: i64,
    /// Elements from a column to the next; may be negative.
    pub column_stride: i64,
    /// Elements from a layer to the next; may be negative, and 0 where all layers show the values of one.
    pub layer_stride: i64,
    /// Columns per block; 0 where columns are not in blocks. Then value (column, layer) is element (column %
    /// block)*column_stride + (column / block)*block_stride + layer*layer_stride; the last block may be partly filled.
    pub block: i64,
    /// Elements from a block to the next; may be negative.
    pub block_stride: i64,
    /// Not 0: fill_value marks missing values. NaN and infinities always do.
    pub has_fill: i32,
    /// The value that marks missing values.
    pub fill_value: f64,
    /// Name of the field's grid; NULL is the one without a name. Copied.
    pub grid_name: *const c_char,
    /// Name of the field's layers; NULL is those without a name. Copied.
    pub layers_name: *const c_char,
}

/// Most dimensions of an icoray_ndarray.
pub const ICORAY_MAX_RANK: usize = 7;

/// A field as an array of up to seven dimensions; which of them are layers and which columns is found from the numbers of
/// layers and of cells or corners, so grid and layers come first.
///
/// Dimensions of extent 1 do not count. Of two, one holds the layers and one the columns, in either order; of three, one
/// holds the layers and the other two, in order, the columns of a block and the blocks. Where several readings fit, the
/// layers are the dimension that has just as many as icoray_layers, else one fewer; of these the second of three, or the
/// first. The dimension of columns may be longer than the grid has.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct icoray_ndarray {
    /// sizeof(icoray_ndarray)
    pub struct_size: usize,
    /// The first element: all indices 0.
    pub data: *const c_void,
    /// ICORAY_F32 or ICORAY_F64.
    pub r#type: i32,
    /// ICORAY_CENTER or ICORAY_CORNER.
    pub location: i32,
    /// Number of dimensions, 1 to 7.
    pub rank: i32,
    /// Not 0: fill_value marks missing values. NaN and infinities always do.
    pub has_fill: i32,
    /// The value that marks missing values.
    pub fill_value: f64,
    /// Size of each dimension.
    pub extent: [i64; ICORAY_MAX_RANK],
    /// Elements from one index to the next in each dimension; may be negative.
    pub stride: [i64; ICORAY_MAX_RANK],
    /// Name of the field's grid; NULL is the one without a name. Copied.
    pub grid_name: *const c_char,
    /// Name of the field's layers; NULL is those without a name. Copied.
    pub layers_name: *const c_char,
}

/// What the last rendered frame cost and how exact it is, and the counts of all frames so far. Seconds are wall clock.
///
/// Where one call of icoray_execute drew several frames, host_s, waited_s, copy_s and bytes_copied are of all of them together,
/// `frames` says how many they are, and all else is the last one's.
///
/// With async_render this is the frame that was finished last; icoray_wait waits for the one in the works.
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
    /// What the frames of the call cost the model: icoray_execute from its call to its return.
    pub host_s: f64,
    /// Of these: waiting for a full queue or for the frames before.
    pub waited_s: f64,
    /// Of these: copying the fields (async_render, or columns that are spread over ranks, with waiting for each other).
    pub copy_s: f64,
    /// Value range, averages of corner fields, gradients.
    pub prepare_s: f64,
    /// Rays.
    pub render_s: f64,
    /// Encoding and disk of the frame that was written last, on a thread of its own.
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
    /// Bytes of input that were copied: 0, or the fields' with async_render. Of columns that are spread over ranks: what this
    /// rank wrote to its node's memory, which is the fields' of all ranks there.
    pub bytes_copied: u64,
    /// Bytes that were derived from the field: averages of corner fields, gradients.
    pub bytes_derived: u64,
    /// The most memory that icoray has held at once in this process, bytes, by all contexts and meshes; without what ranks of a
    /// node share.
    pub bytes_peak: u64,
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
    /// Threads that rendered.
    pub threads: i32,
    /// Frames on disk so far.
    pub frames_written: u64,
    /// Frames that could not be rendered or written so far; those that nobody rendered for ICORAY_ERR_EXISTS do not count.
    pub frames_failed: u64,
    /// Frames that a full queue dropped so far (ICORAY_DROP_OLDEST).
    pub frames_dropped: u64,
    /// Seconds of the model inside icoray_execute so far.
    pub host_total_s: f64,
    /// Seconds of encoding and disk so far.
    pub write_total_s: f64,
    /// Ranks that drew the frame: 1, or those of icoray_open. With several, errors, rays, columns, frusta, values, fragments,
    /// gather_s, balance and bytes_received are of the whole picture and the same on all; other seconds and bytes, threads
    /// and tiles are this rank's; frames are written, and what becomes of files is counted, at rank 0.
    pub ranks: i32,
    /// Tiles of the picture that this rank drew, or put together of fragments.
    pub tiles: i32,
    /// Seconds in which rank 0 waited for the other ranks' tiles and took them in.
    pub gather_s: f64,
    /// How even ranks were loaded: the mean of the seconds that they drew, divided by the most; 1 is even.
    pub balance: f64,
    /// Bytes of tiles that rank 0 received.
    pub bytes_received: u64,
    /// How ranks shared the picture: ICORAY_ALONE, ICORAY_TILES or ICORAY_FRAGMENTS.
    pub scheme: i32,
    /// Fragments that rays were put together of (ICORAY_FRAGMENTS), of all ranks.
    pub fragments: u64,
    /// Bytes of these that ranks sent each other.
    pub fragment_bytes: u64,
    /// Seconds in which this rank put rays together of fragments.
    pub compose_s: f64,
    /// Who traced this rank's rays: ICORAY_CPU, ICORAY_GPU, or ICORAY_GPU_AND_CPU where a GPU left some to the CPU. The log says
    /// which GPU it was and why the CPU drew, each thing once.
    pub drawn_on: i32,
    /// Seconds of render_s until rays could begin on the GPU: preparing what is uploaded, and uploading.
    pub upload_s: f64,
    /// Seconds of rays by the GPU's clock; NaN where there is none.
    pub device_s: f64,
    /// Bytes that were uploaded to the GPU.
    pub bytes_uploaded: u64,
    /// Frames that the call of icoray_execute drew, of which this is the last one.
    pub frames: u64,
}
