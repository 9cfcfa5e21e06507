!> icoray: in-situ ray casting of geodesic grids. The Fortran module, on top of the C interface in icoray.h.
!>
!> Call icoray_open_serial, icoray_grid_set, icoray_layers_set and icoray_scene_load once, icoray_field_set and
!> icoray_execute at each step, and icoray_close at the end. Compile this file with the model and link libicoray.
!>
!> ERRORS. Every subroutine has an optional ierr: ICORAY_OK (0), or an ICORAY_ERR_ number, whose message
!> icoray_last_error returns. Without ierr a failure is silent, and its message is kept for icoray_last_error. No
!> procedure stops or prints. ierr can be passed by position directly after the mandatory arguments; arguments after it
!> are passed by keyword.
!>
!> MEMORY. Tables and fields are read in place, never copied and never written, until they are replaced or the context
!> is closed. Their dummy arguments are pointers with intent(in): the actual argument is an array, or a section of it by
!> triplets (2::2, not by a vector subscript), and has the attribute TARGET or POINTER. If the compiler finds no
!> specific subroutine, TARGET is missing or the kinds differ. To pass a component of an array of structures, associate
!> a pointer with it first (p => cell%q) and pass p: gfortran 12 passes a wrong address for cell%q itself. Everything
!> else (names, radii, paths) is copied by the call.
!>
!> KINDS. Reals of fields and coordinates have 32 or 64 bits, as have index tables, times and radii of layers. All
!> other integers and logicals are of the default kind. Trailing blanks of strings are ignored.
!>
!> PICTURES are written by a separate thread. Call icoray_close or icoray_wait before the program ends: pictures that
!> are not on disk by then are lost. After icoray_close the copies of an icoray_context must not be used.
!>
!> One call at a time is made on a context (else ICORAY_ERR_BUSY); different contexts are independent.
!> Fortran 2018 without extensions. Generated from crates/icoray-capi/icoray.f90.jinja. Apache-2.0 OR MIT.
module icoray
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_float, c_funloc, c_funptr, &
    c_int32_t, c_int64_t, c_intptr_t, c_loc, c_null_char, c_null_funptr, c_null_ptr, c_ptr, c_size_t, c_sizeof
  implicit none
  private

  ! Status of a call (ierr).
  integer, parameter, public :: &
    ICORAY_OK = 0, &                !< success
    ICORAY_ERR_NULL = 1, &          !< an argument is not associated, or a context or mesh is not open
    ICORAY_ERR_STRUCT_SIZE = 2, &   !< this file and the library have different versions
    ICORAY_ERR_ARGUMENT = 3, &      !< a number, string or shape is out of range
    ICORAY_ERR_GRID = 4, &          !< a table contradicts itself or another; the message names table, row and value
    ICORAY_ERR_UNSUPPORTED = 5, &   !< MPI in a library without it or for another one
    ICORAY_ERR_LAYERS = 6, &        !< radii are not positive, finite and strictly monotone; wrong heights
    ICORAY_ERR_FIELD = 7, &         !< a field is missing, or its shape does not fit the grid and layers
    ICORAY_ERR_SCENE = 8, &         !< the scene is wrong; the message names line and key
    ICORAY_ERR_ORDER = 9, &         !< a call that must come before this one is missing
    ICORAY_ERR_IO = 10, &           !< a file could not be read or written
    ICORAY_ERR_INTERNAL = 11, &     !< a bug in icoray; only icoray_last_error and icoray_close work now
    ICORAY_ERR_EXISTS = 12, &       !< the picture exists (ICORAY_NEVER_MODIFY); nothing was rendered
    ICORAY_ERR_DISABLED = 13, &     !< the context has switched itself off after too many failures (ICORAY_DISABLE)
    ICORAY_ERR_BUSY = 14, &         !< another thread is in a call on this context, or its log procedure called it
    ICORAY_ERR_FORKED = 15, &       !< the context was opened before this process was forked
    ICORAY_ERR_MPI = 16, &          !< MPI is not initialised or failed, or ranks differ in call, step, scene or data
    ICORAY_ERR_MEMORY = 17          !< a grid or frame needs more memory than there is; the message has the bytes
  integer, parameter, public :: &
    ICORAY_F32 = 1, ICORAY_F64 = 2, &           !< icoray_array%type, icoray_grid%real_type
    ICORAY_I32 = 3, ICORAY_I64 = 4, &           !< icoray_grid%index_type, icoray_part%index_type
    ICORAY_CENTER = 0, ICORAY_CORNER = 1, &     !< location: values at cell centres, or at corners (averaged to centres)
    ICORAY_ALONE = 0, ICORAY_TILES = 1, ICORAY_FRAGMENTS = 2, &   !< icoray_frame_report%scheme: how ranks share it
    ICORAY_CPU = 0, ICORAY_GPU = 1, ICORAY_GPU_AND_CPU = 2, &     !< icoray_frame_report%drawn_on: what traced the rays
    ICORAY_NEVER_MODIFY = 0, ICORAY_OVERWRITE = 1, &              !< existing: keep or replace existing pictures
    ICORAY_WARN = 0, ICORAY_IGNORE = 1, ICORAY_DISABLE = 2, &     !< on_error: log, do not log, or switch off
    ICORAY_BLOCK = 0, ICORAY_DROP_OLDEST = 1, &                   !< when_full: wait, or drop the oldest frame
    ICORAY_LOG_OFF = 0, ICORAY_LOG_ERROR = 1, ICORAY_LOG_WARN = 2, ICORAY_LOG_INFO = 3, ICORAY_LOG_DEBUG = 4, &
    ICORAY_MAX_RANK = 7                         !< maximum number of dimensions of an icoray_ndarray

  !> Log procedure: receives one line per call, during a call on the context. It must not call icoray on that context.
  abstract interface
    subroutine icoray_log(level, message)
      integer, intent(in) :: level              !< ICORAY_LOG_ERROR to ICORAY_LOG_DEBUG
      character(len=*), intent(in) :: message
    end subroutine icoray_log
  end interface
  public :: icoray_log

  !> State of a context in this module: the log procedure.
  type :: own_part
    procedure(icoray_log), pointer, nopass :: log => null()
  end type own_part

  !> An open context; handle is its icoray_ctx pointer, for the functions ending in _c. A copy is the same context.
  type, public :: icoray_context
    type(c_ptr) :: handle = c_null_ptr
    type(own_part), pointer, private :: own => null()
  end type icoray_context

  !> A generated mesh that owns its tables.
  type, public :: icoray_mesh
    type(c_ptr) :: handle = c_null_ptr
  end type icoray_mesh

  !> The tables of a generated mesh, valid until icoray_mesh_free. Coordinates are radians; indices begin at index_base.
  type, public :: icoray_grid_tables
    real(c_double), pointer :: lon_center(:) => null(), lat_center(:) => null()     !< (cells)
    real(c_double), pointer :: lon_corner(:) => null(), lat_corner(:) => null()     !< (corners)
    integer(c_int32_t), pointer :: cell_corner(:, :) => null()                      !< (6, cells)
    integer(c_int32_t), pointer :: corner_cell(:, :) => null(), corner_edge(:, :) => null()   !< (3, corners)
    integer(c_int32_t), pointer :: edge_corner(:, :) => null()                      !< (2, edges)
    integer :: index_base = 0
  end type icoray_grid_tables

  ! The structs of icoray.h, which documents each member. struct_size must be set only for the functions ending in _c.

  !> Settings of a context.
  type, bind(C), public :: icoray_config
    integer(c_size_t) :: struct_size = 0
    type(c_ptr) :: output_dir = c_null_ptr
    integer(c_int32_t) :: threads = 0, existing = 0, on_error = 0, disable_after = 0
    integer(c_int32_t) :: async_render = 0, writer_queue = 0, when_full = 0, log_level = 0
    type(c_funptr) :: log = c_null_funptr       !< a procedure with the interface of icoray_log_stderr_c
    type(c_ptr) :: log_user = c_null_ptr
  end type icoray_config

  !> The tables of a grid, as addresses.
  type, bind(C), public :: icoray_grid
    integer(c_size_t) :: struct_size = 0
    integer(c_int64_t) :: cells = 0, corners = 0, edges = 0
    integer(c_int32_t) :: index_base = 0, real_type = 0, index_type = 0
    type(c_ptr) :: lon_center_rad = c_null_ptr, lat_center_rad = c_null_ptr
    type(c_ptr) :: lon_corner_rad = c_null_ptr, lat_corner_rad = c_null_ptr
    type(c_ptr) :: cell_corner = c_null_ptr
    integer(c_int64_t) :: cell_corner_row = 0
    type(c_ptr) :: cell_corner_count = c_null_ptr, corner_cell = c_null_ptr, corner_edge = c_null_ptr
    type(c_ptr) :: edge_corner = c_null_ptr, name = c_null_ptr
  end type icoray_grid

  !> The cells of a grid that belong to this rank, as addresses.
  type, bind(C), public :: icoray_part
    integer(c_size_t) :: struct_size = 0
    type(c_ptr) :: grid = c_null_ptr
    integer(c_int64_t) :: cells = 0
    integer(c_int32_t) :: index_type = 0
    type(c_ptr) :: cell_global = c_null_ptr
    integer(c_int64_t) :: owned_cells = 0
    type(c_ptr) :: is_owned = c_null_ptr
    integer(c_int64_t) :: corners = 0
    type(c_ptr) :: corner_global = c_null_ptr
    integer(c_int64_t) :: owned_corners = 0
    type(c_ptr) :: is_corner_owned = c_null_ptr
  end type icoray_part

  !> Radii of layers.
  type, bind(C), public :: icoray_layers
    integer(c_size_t) :: struct_size = 0
    integer(c_int64_t) :: count = 0
    type(c_ptr) :: radius_m = c_null_ptr
    real(c_double) :: planet_radius_m = 0
    type(c_ptr) :: name = c_null_ptr
  end type icoray_layers

  !> A field: address, numbers of columns and layers, strides in elements.
  type, bind(C), public :: icoray_array
    integer(c_size_t) :: struct_size = 0
    type(c_ptr) :: data = c_null_ptr
    integer(c_int32_t) :: type = 0, location = 0
    integer(c_int64_t) :: columns = 0, layers = 0, column_stride = 0, layer_stride = 0, block = 0, block_stride = 0
    integer(c_int32_t) :: has_fill = 0
    real(c_double) :: fill_value = 0
    type(c_ptr) :: grid_name = c_null_ptr, layers_name = c_null_ptr
  end type icoray_array

  !> A field: address, extents and strides of its dimensions.
  type, bind(C), public :: icoray_ndarray
    integer(c_size_t) :: struct_size = 0
    type(c_ptr) :: data = c_null_ptr
    integer(c_int32_t) :: type = 0, location = 0, rank = 0, has_fill = 0
    real(c_double) :: fill_value = 0
    integer(c_int64_t) :: extent(ICORAY_MAX_RANK) = 0, stride(ICORAY_MAX_RANK) = 0
    type(c_ptr) :: grid_name = c_null_ptr, layers_name = c_null_ptr
  end type icoray_ndarray

  !> Cost and error of the last rendered frame, and counts of all frames so far. Seconds are wall-clock time.
  !> 
  !> If one call of icoray_execute rendered several frames, host_s, waited_s, copy_s and bytes_copied are sums over
  !> them, `frames` is their number, and all other members are of the last one. With async_render the report is of
  !> the frame that was finished last; icoray_wait waits for the one in progress.
  !> 
  !> The error of a pixel is the largest error of its channels (premultiplied, linear, 0 to 1) against the exact
  !> integral of the interpolated field along its ray. It does not include the error of the interpolation between
  !> cells and layers. A pixel that was not traced (pixel_step) has an error of 1, or of the brightest that the scene
  !> may show.
  type, bind(C), public :: icoray_frame_report
    integer(c_size_t) :: struct_size = 0
    !> Step passed to icoray_execute.
    integer(c_int64_t) :: step = 0
    !> Time passed to icoray_execute, seconds.
    real(c_double) :: time_s = 0
    !> Seconds that the call of icoray_execute took.
    real(c_double) :: host_s = 0
    !> Part of host_s: waiting for a full queue or for earlier frames.
    real(c_double) :: waited_s = 0
    !> Part of host_s: copying fields (async_render; fields distributed over ranks, including waiting for other
    !> ranks).
    real(c_double) :: copy_s = 0
    !> Seconds for value range, averages of corner fields, and gradients.
    real(c_double) :: prepare_s = 0
    !> Seconds for tracing rays.
    real(c_double) :: render_s = 0
    !> Seconds for encoding and writing the frame that was written last, on the writing thread.
    real(c_double) :: write_s = 0
    !> Rays that meet the shell.
    integer(c_int64_t) :: rays = 0
    !> Columns that these rays cross.
    integer(c_int64_t) :: columns = 0
    !> Frusta that these rays cross and read.
    integer(c_int64_t) :: frusta = 0
    !> Frusta among these that are empty because of a missing value.
    integer(c_int64_t) :: void_frusta = 0
    !> Smallest value of the field; NaN if all values are missing.
    real(c_double) :: value_min = 0
    !> Largest value of the field; NaN if all values are missing.
    real(c_double) :: value_max = 0
    !> Number of values that are NaN, infinite or equal to fill_value.
    integer(c_int64_t) :: missing_values = 0
    !> Bytes of fields that were copied: 0, or those of the fields with async_render. For columns distributed over
    !> ranks: bytes of columns that this rank wrote to the memory of its node.
    integer(c_int64_t) :: bytes_copied = 0
    !> Bytes derived from the field: averages of corner fields, gradients; averages that this rank wrote to the
    !> memory of its node count here. One rank of each node counts what else its ranks share: gradients, visible
    !> blocks, fields made of others and, with parts, the tables of the node's mesh.
    integer(c_int64_t) :: bytes_derived = 0
    !> Largest number of bytes that icoray has held at once in this process, over all contexts and meshes; without
    !> memory that the ranks of a node share.
    integer(c_int64_t) :: bytes_peak = 0
    !> Largest error of a pixel.
    real(c_double) :: error_max = 0
    !> Mean error of the pixels with an error above 0; 0 if there are none.
    real(c_double) :: error_mean = 0
    !> 99.9th percentile of the errors above 0; 0 if there are none.
    real(c_double) :: error_p999 = 0
    !> Largest error allowed in a traced pixel: the scene's tolerance, or a larger one to keep its time_budget_ms.
    real(c_double) :: tolerance = 0
    !> 1 if the errors are bounds (unlit, f64), 0 if they are estimates.
    integer(c_int32_t) :: error_is_bound = 0
    !> Every how many pixels one is traced, in both directions, the others being interpolated: 1, or more to keep
    !> the scene's time_budget_ms.
    integer(c_int32_t) :: pixel_step = 0
    !> Light: 0 off, 1 coarse (to keep the time budget), 2 full.
    integer(c_int32_t) :: lights = 0
    !> Number of rendering threads.
    integer(c_int32_t) :: threads = 0
    !> Frames written so far.
    integer(c_int64_t) :: frames_written = 0
    !> Frames so far that could not be rendered or written; without those refused with ICORAY_ERR_EXISTS.
    integer(c_int64_t) :: frames_failed = 0
    !> Frames dropped so far because the queue was full (ICORAY_DROP_OLDEST).
    integer(c_int64_t) :: frames_dropped = 0
    !> Seconds inside icoray_execute so far.
    real(c_double) :: host_total_s = 0
    !> Seconds for encoding and writing so far.
    real(c_double) :: write_total_s = 0
    !> Number of ranks that rendered the frame: 1, or those of icoray_open. With several, errors, rays, columns,
    !> frusta, values, fragments, gather_s, balance and bytes_received are of the whole picture and equal on all
    !> ranks; other seconds and bytes, threads and tiles are of this rank; files are written and counted at rank 0.
    integer(c_int32_t) :: ranks = 0
    !> Tiles of the picture that this rank rendered, or composed of fragments.
    integer(c_int32_t) :: tiles = 0
    !> Seconds in which rank 0 waited for and received tiles of the other ranks.
    real(c_double) :: gather_s = 0
    !> Load balance: mean over maximum of the seconds that ranks rendered; 1 is even.
    real(c_double) :: balance = 0
    !> Bytes of tiles that rank 0 received.
    integer(c_int64_t) :: bytes_received = 0
    !> How ranks shared the picture: ICORAY_ALONE, ICORAY_TILES or ICORAY_FRAGMENTS.
    integer(c_int32_t) :: scheme = 0
    !> Fragments of which rays were composed (ICORAY_FRAGMENTS), of all ranks.
    integer(c_int64_t) :: fragments = 0
    !> Bytes of fragments that ranks sent each other.
    integer(c_int64_t) :: fragment_bytes = 0
    !> Seconds in which this rank composed rays of fragments.
    real(c_double) :: compose_s = 0
    !> Devices that traced this rank's rays: ICORAY_CPU, ICORAY_GPU, or ICORAY_GPU_AND_CPU. The log names the GPU
    !> and the reason for using the CPU, each once.
    integer(c_int32_t) :: drawn_on = 0
    !> Part of render_s before rays could start on the GPU: preparing and uploading data, seconds.
    real(c_double) :: upload_s = 0
    !> Seconds for rays by the GPU's clock; NaN if there is none.
    real(c_double) :: device_s = 0
    !> Bytes uploaded to the GPU.
    integer(c_int64_t) :: bytes_uploaded = 0
    !> Number of frames that the call of icoray_execute rendered; this report is of the last one.
    integer(c_int64_t) :: frames = 0
    !> Number of pixels with the edge of a surface in them, each drawn as the mean of 8 rays or more; 0 with
    !> antialias = false in the scene. rays and the numbers after it include the rays of these pixels.
    integer(c_int64_t) :: edge_pixels = 0
    !> Number of pixels of the picture whose error is above `tolerance`. The log warns of them once per view.
    integer(c_int64_t) :: pixels_over_tolerance = 0
    !> Mean number of rays of the pixels that may show the shell: 1, or up to the scene's `samples`; below 1 where
    !> not every pixel was traced.
    real(c_double) :: rays_per_pixel = 0
    !> Largest estimated sampling error of a pixel: how far the mean of its rays may be from the mean over its
    !> area, not counting the errors of the rays' integrals; with pixel_step above 1, how far a pixel that was not
    !> traced may be from its ray. NaN where pixels are one ray each.
    real(c_double) :: sampling_error_max = 0
    !> Mean of the estimated sampling errors; NaN where pixels are one ray each.
    real(c_double) :: sampling_error_mean = 0
    !> Largest number of cells that fall into a pixel where its ray meets the shell, of up to 16 x 16 pixels at
    !> equal distances.
    real(c_double) :: cells_per_pixel_max = 0
    !> Mean number of cells that fall into these pixels. From 4 on, with samples = 1, the log has a hint once per
    !> view.
    real(c_double) :: cells_per_pixel_mean = 0
    !> The coarser grid on which rays were traced: 0 is the model's own, and larger ones have fewer cells.
    integer(c_int32_t) :: level = 0
  end type icoray_frame_report

  !> Opens a context for one process, without MPI. In a job of several MPI ranks rank 0 logs a warning, once.
  !>   call icoray_open_serial(ctx, [ierr], keywords)   or   call icoray_open_serial(ctx, icoray_config, [ierr])
  !>   output_dir     directory of the pictures and of report.csv, created if missing; default: the working directory.
  !>                  ICORAY_ERR_IO if it cannot be written to or created (icoray_open: by rank 0)
  !>   threads        number of rendering threads; default: the processors in the affinity mask, divided by the ranks of
  !>                  the node that may run on some of them
  !>   existing       ICORAY_NEVER_MODIFY (default) or ICORAY_OVERWRITE
  !>   on_error       ICORAY_WARN (default), ICORAY_IGNORE or ICORAY_DISABLE; ierr has the status in all cases
  !>   disable_after  with ICORAY_DISABLE: consecutive failed frames until the context switches itself off; default 3
  !>   async_render   .true.: icoray_execute copies the fields that the pictures need, and a thread renders the copies;
  !>                  over ranks the same on all
  !>   writer_queue   number of frames that may wait for the writing thread; default 2
  !>   when_full      ICORAY_BLOCK (default) or ICORAY_DROP_OLDEST
  !>   log            a module procedure with the interface icoray_log, such as icoray_log_stderr; default: no log
  !>   log_level      ICORAY_LOG_OFF to ICORAY_LOG_DEBUG; default ICORAY_LOG_WARN
  !> On failure icoray_last_error(message), without ctx, returns the message. A context that is already open is not
  !> opened again (ICORAY_ERR_ORDER).
  interface icoray_open_serial
    procedure :: open_serial, open_config
  end interface icoray_open_serial

  !> Opens a context over the ranks of an MPI communicator, which render each picture together.
  !>   call icoray_open(ctx, comm, [ierr], keywords)   or   call icoray_open(ctx, comm, icoray_config, [ierr])
  !>   comm      an integer: MPI_COMM_WORLD%MPI_VAL of mpi_f08, MPI_COMM_WORLD of mpi. It is duplicated, and the
  !>             duplicate is freed by icoray_close
  !>   keywords  those of icoray_open_serial; output_dir, existing and disable_after are used at rank 0
  !> Each rank has the whole grid and field, or its part of them, or the whole grid and columns of its own cells
  !> (icoray_part_set). The picture is written at rank 0. icoray_open, icoray_part_set, icoray_scene_load,
  !> icoray_scene_text, icoray_execute, icoray_wait and icoray_close are collective: all ranks call them in the same
  !> order, also after failed calls, and get the same ierr. All other calls are local. MPI is initialised before and
  !> finalised after. ICORAY_ERR_UNSUPPORTED if the library was built without MPI. With async_render each call on ctx
  !> transfers messages between ranks, and icoray_grid_set is collective too.
  interface icoray_open
    procedure :: open_i4, open_i8, open_config_i4, open_config_i8
  end interface icoray_open

  !> Sets a grid: checks all its tables and borrows them. All real arrays are of one kind, all index arrays are of one
  !> kind, and all are contiguous (ICORAY_ERR_ARGUMENT names the table that is not). The entries of a row may be in any
  !> order and orientation. ICORAY_ERR_GRID if tables contradict each other; the previous grid then stays in effect.
  !>   call icoray_grid_set(ctx, lon_center, lat_center, lon_corner, lat_corner, cell_corner, corner_cell, &
  !>                        corner_edge, edge_corner, [ierr], keywords)
  !>   lon_center(cells), lat_center(cells)      radians (MPAS lonCell, latCell)
  !>   lon_corner(corners), lat_corner(corners)  radians (lonVertex, latVertex)
  !>   cell_corner(row, cells)                   corners of each cell; row is 6 or more (verticesOnCell)
  !>   corner_cell(3, corners)                   cells at each corner (cellsOnVertex)
  !>   corner_edge(3, corners)                   edges at each corner (edgesOnVertex)
  !>   edge_corner(2, edges)                     corners of each edge (verticesOnEdge)
  !>   index_base                                number of the first cell, corner and edge: 1 (default) or 0
  !>   cell_corner_count(cells)                  number of valid entries in each column of cell_corner (nEdgesOnCell);
  !>                                             without it a cell with fewer corners repeats one of them
  !>   cells, corners, edges                     numbers of cells, corners and edges; default: the sizes of lon_center,
  !>                                             lon_corner and edge_corner. Required where arrays are longer, as in
  !>                                             MPAS
  !>   name                                      name of the grid, for contexts with several grids
  !> Or (ctx, icoray_mesh, [ierr], name), or (ctx, icoray_grid, [ierr]).
  interface icoray_grid_set
    procedure :: grid_r4_i4, grid_r4_i8, grid_r8_i4, grid_r8_i8, grid_mesh, grid_struct
  end interface icoray_grid_set

  !> Sets a grid of points, for models whose columns have places and no tables of neighbours: the cells are the points, and
  !> the corners their Delaunay triangles, which icoray makes and owns. The arrays are read during the call only.
  !>   call icoray_points_set(ctx, lon, lat, [ierr], name)
  !>   lon(cells), lat(cells)   radians, of one kind and any strides
  !>   name                     name of the grid, for contexts with several grids
  !> The points cover the sphere or regions; a triangle whose circumcircle is more than 5 times as large as others at its
  !> points lies outside. Of points less than 3e-7 rad apart one is shown. Each rank gives all points; icoray_part_set
  !> then states which are its columns. ICORAY_ERR_GRID if a point is not finite or the points span no area; the
  !> previous grid then stays in effect.
  interface icoray_points_set
    procedure :: points_r4, points_r8
  end interface icoray_points_set

  !> Declares which cells of a grid belong to this rank, where ranks have parts of the grid, or the whole grid and some
  !> columns of the fields. It is called after each icoray_grid_set of that grid, collectively, with the same ierr on
  !> all ranks. A rank may have no cells: arrays of size 0.
  !>   call icoray_part_set(ctx, cell_global, [ierr], owned=n, [grid='name'], &
  !>                        [corner_global=numbers, owned_corners=n])
  !>   call icoray_part_set(ctx, cell_global, [ierr], is_owned=mask, [grid='name'], &
  !>                        [corner_global=numbers, is_corner_owned=mask])
  !>   cell_global(cells)  global number of each cell, from index_base (MPAS indexToCellID); for parts, gaps are allowed
  !>   owned               number of own cells, which come first (MPAS nCellsSolve)
  !>   is_owned(cells)     logical, or integer(int32) that is nonzero where a cell is own; as long as cell_global
  !>   grid                name of the grid; default: the unnamed grid
  !>   corner_global(corners), owned_corners, is_corner_owned   the same of corners, for columns, see below
  !> Parts: if cell_global has a row for each cell of the grid, on all ranks, the tables are the rank's part: its own
  !> cells and a halo of all cells that share a corner with them, with local numbers. Neighbours beyond the halo are
  !> marked as missing. Fields at centres have a column for each of these cells, of which own ones are read; fields at
  !> corners have a column for each corner, and those whose first cell in corner_cell is own are read: halos of fields
  !> need no exchange before. Columns: otherwise the tables are the whole grid's on all ranks, and cell_global holds
  !> rows of them. Fields at centres have a column for each row of cell_global, those at corners for each row of
  !> corner_global (of the kind of cell_global; ICON: the global index of a triangle), and are set after this call; only
  !> own columns are read, and each cell and corner has one owner. Without corner_global on any rank, fields at corners
  !> have a column for each corner of the grid, of which those whose first cell in corner_cell is own are read. Each
  !> node assembles fields once per frame, in memory that its ranks share (bytes_copied); of fields at corners of parts,
  !> averages at cells (bytes_derived).
  !> These arrays are read during the call only, and need no TARGET. Or (ctx, icoray_part, [ierr]).
  interface icoray_part_set
    procedure :: part_first_i4, part_first_i8, part_mask_i4, part_mask_i8, part_marks_i4, part_marks_i8, part_struct
  end interface icoray_part_set

  !> Sets the radii of layers, which are copied: call icoray_layers_set(ctx, radius_m, planet_radius_m, [ierr], name)
  !>   radius_m(:)      metres from the planet's centre, at least 2, positive, strictly rising or falling, in the order
  !>                    of the fields' layers (else ICORAY_ERR_LAYERS); a field with one layer fewer is midway
  !>                    between them
  !>   planet_radius_m  radius of the planet's surface in metres; exaggeration stretches heights above it
  !> Or (ctx, icoray_layers, [ierr]).
  interface icoray_layers_set
    procedure :: layers_r4, layers_r8, layers_struct
  end interface icoray_layers_set

  !> Sets a field under the name that scenes use, after the grid and layers:
  !>   call icoray_field_set(ctx, name, values, [ierr], keywords)
  !>   values       real, rank 1 to 4, any strides. Which dimension holds the layers and which the columns is found from
  !>                their numbers: (layers, cells), (cells, layers), (nproma, layers, blocks) with a last block that may
  !>                be partly filled, (layers*cells), (cells) of a 2D field. Dimensions of extent 1 are ignored. That of
  !>                cells may be longer by at most 64, as MPAS's nCells + 1, but not as long as the grid has corners or
  !>                edges, or one longer: ICORAY_ERR_FIELD names the likely location
  !>   location     ICORAY_CENTER (default), or ICORAY_CORNER for values at corners
  !>   fill_value   marks missing values, in the kind of values; NaN and infinities always do
  !>   grid_name, layers_name   grid and layers of the field; default: the unnamed ones
  !> The call stores where the array is, and icoray_execute reads it. It belongs into the time loop, before
  !> icoray_execute: models swap time levels, and a pointer that is given once shows the step before at every odd step.
  !> ICORAY_ERR_FIELD if the shape fits in no way. A scene of several fields needs all of them, on the same grid and
  !> layers. Or (ctx, name, icoray_array, [ierr]).
  interface icoray_field_set
    procedure :: field_r4_1, field_r4_2, field_r4_3, field_r4_4, field_r8_1, field_r8_2, field_r8_3, field_r8_4
    procedure :: field_struct
  end interface icoray_field_set

  !> Sets the heights of layers that differ from column to column (terrain, a sea floor), after the grid and layers:
  !>   call icoray_heights_set(ctx, values, [ierr], keywords)
  !>   values       real, dimensions as in icoray_field_set: metres above the planet's surface, negative below it, of
  !>                each cell (or corner) and each layer of icoray_layers_set
  !>   fill_value   marks missing heights, in the kind of values; a column without heights has the mean heights
  !>   grid_name, layers_name   grid and layers of the heights; default: the unnamed ones
  !>   location     ICORAY_CENTER (default), or ICORAY_CORNER for heights at corners (ICON's triangles), which are
  !>                averaged to cells as fields are
  !> Scenes with heights = "native" read them at each icoray_execute, which returns ICORAY_ERR_LAYERS if they are wrong.
  !> They replace earlier ones; call icoray_heights_set(ctx, [ierr]) removes them. Or (ctx, icoray_array, [ierr]).
  interface icoray_heights_set
    procedure :: heights_r4_1, heights_r4_2, heights_r4_3, heights_r4_4
    procedure :: heights_r8_1, heights_r8_2, heights_r8_3, heights_r8_4
    procedure :: heights_struct, heights_none
  end interface icoray_heights_set

  !> Sets wants to .true. if icoray_execute may draw a picture at this step, from any field or from the named one.
  !> Conditions of a scene are not evaluated here; a field that one of them needs counts as wanted, and so does one that
  !> viewers of a page ([live]) have chosen, before a picture shows it. Local, without communication; on all ranks that
  !> give the same step and time_s the answer is the same, also after calls that failed on some of them, so that all
  !> call icoray_execute or none. If time_s is not finite, the step alone decides (ICORAY_ERR_ARGUMENT); wants is
  !> .false. after other failures. time_s has 32 or 64 bits.
  !>   call icoray_wants(ctx, step, time_s, wants, [ierr])
  !>   call icoray_wants_field(ctx, name, step, time_s, wants, [ierr])
  interface icoray_wants
    procedure :: wants_i4, wants_i8, wants_i4_r4, wants_i8_r4
  end interface icoray_wants
  interface icoray_wants_field
    procedure :: wants_field_i4, wants_field_i8, wants_field_i4_r4, wants_field_i8_r4
  end interface icoray_wants_field

  !> Renders all pictures that are due at this step from the fields as they are now; a thread writes them. It is called
  !> at each step, or at least where icoray_wants returns .true. If one of several pictures fails, the others are drawn
  !> nevertheless, and ierr is that of the first failure. A picture that could not be written is reported by the next
  !> call.
  !>   call icoray_execute(ctx, step, time_s, [ierr])   call icoray_execute(ctx, step, time_s, date, [ierr])
  !>   step     the model's step
  !>   time_s   model time in seconds, in 32 or 64 bits
  !>   date     'YYYY-MM-DD_hh:mm:ss', required only if an output name of the scene contains a date. Pictures for which
  !>            the scene has no output.file then have date and step in their names, and a restarted run draws new files
  interface icoray_execute
    procedure :: execute_i4, execute_i8, execute_date_i4, execute_date_i8
    procedure :: execute_i4_r4, execute_i8_r4, execute_date_i4_r4, execute_date_i8_r4
  end interface icoray_execute

  !> Returns the message of the last failed call on a context, at most 400 characters, truncated to len(message):
  !>   call icoray_last_error(ctx, message, [ierr])   or, for the calls that have no open context,   (message, [ierr])
  !> Without ctx the message is that of this thread's last failed call: of icoray_open, icoray_open_serial,
  !> icoray_mesh_create or icoray_close.
  interface icoray_last_error
    procedure :: last_error_ctx, last_error_thread
  end interface icoray_last_error

  public :: icoray_open, icoray_open_serial, icoray_grid_set, icoray_part_set, icoray_layers_set, icoray_field_set
  public :: icoray_points_set
  public :: icoray_field_set_ndarray, icoray_field_describe, icoray_heights_set, icoray_heights_set_ndarray
  public :: icoray_scene_load, icoray_scene_text, icoray_scene_field
  public :: icoray_wants, icoray_wants_field
  public :: icoray_execute, icoray_wait, icoray_report, icoray_last_error, icoray_close, icoray_version
  public :: icoray_log_stderr, icoray_mesh_create, icoray_mesh_grid, icoray_mesh_tables, icoray_mesh_free

  ! The functions of icoray.h: strings end in c_null_char, and the caller sets struct_size.
  interface
    function icoray_open_serial_c(config, ctx) bind(C, name='icoray_open_serial') result(status)
      import
      type(icoray_config), intent(in) :: config
      type(c_ptr), intent(out) :: ctx
      integer(c_int32_t) :: status
    end function icoray_open_serial_c
    function icoray_open_c(config, fortran_comm, ctx) bind(C, name='icoray_open') result(status)
      import
      type(icoray_config), intent(in) :: config
      integer(c_int32_t), value :: fortran_comm
      type(c_ptr), intent(out) :: ctx
      integer(c_int32_t) :: status
    end function icoray_open_c
    function icoray_close_c(ctx) bind(C, name='icoray_close') result(status)
      import
      type(c_ptr), intent(inout) :: ctx
      integer(c_int32_t) :: status
    end function icoray_close_c
    function icoray_last_error_c(ctx, buf, len) bind(C, name='icoray_last_error') result(status)
      import
      type(c_ptr), value :: ctx
      character(kind=c_char), intent(out) :: buf(*)
      integer(c_size_t), value :: len
      integer(c_int32_t) :: status
    end function icoray_last_error_c
    function icoray_version_c() bind(C, name='icoray_version') result(text)
      import
      type(c_ptr) :: text
    end function icoray_version_c
    function icoray_grid_set_c(ctx, grid) bind(C, name='icoray_grid_set') result(status)
      import
      type(c_ptr), value :: ctx
      type(icoray_grid), intent(in) :: grid
      integer(c_int32_t) :: status
    end function icoray_grid_set_c
    function icoray_points_set_c(ctx, name, cells, real_type, lon_rad, lat_rad) bind(C, name='icoray_points_set') &
        result(status)
      import
      type(c_ptr), value :: ctx, name, lon_rad, lat_rad
      integer(c_int64_t), value :: cells
      integer(c_int32_t), value :: real_type
      integer(c_int32_t) :: status
    end function icoray_points_set_c
    function icoray_part_set_c(ctx, part) bind(C, name='icoray_part_set') result(status)
      import
      type(c_ptr), value :: ctx
      type(icoray_part), intent(in) :: part
      integer(c_int32_t) :: status
    end function icoray_part_set_c
    function icoray_layers_set_c(ctx, layers) bind(C, name='icoray_layers_set') result(status)
      import
      type(c_ptr), value :: ctx
      type(icoray_layers), intent(in) :: layers
      integer(c_int32_t) :: status
    end function icoray_layers_set_c
    function icoray_field_set_c(ctx, name, array) bind(C, name='icoray_field_set') result(status)
      import
      type(c_ptr), value :: ctx
      character(kind=c_char), intent(in) :: name(*)
      type(icoray_array), intent(in) :: array
      integer(c_int32_t) :: status
    end function icoray_field_set_c
    function icoray_field_set_ndarray_c(ctx, name, array) bind(C, name='icoray_field_set_ndarray') result(status)
      import
      type(c_ptr), value :: ctx
      character(kind=c_char), intent(in) :: name(*)
      type(icoray_ndarray), intent(in) :: array
      integer(c_int32_t) :: status
    end function icoray_field_set_ndarray_c
    function icoray_refuse_c(ctx, call, name, status, message) bind(C, name='icoray_refuse') result(returned)
      import
      type(c_ptr), value :: ctx
      character(kind=c_char), intent(in) :: call(*)
      character(kind=c_char), intent(in) :: name(*)
      integer(c_int32_t), value :: status
      character(kind=c_char), intent(in) :: message(*)
      integer(c_int32_t) :: returned
    end function icoray_refuse_c
    function icoray_field_describe_c(ctx, name, long_name, units) bind(C, name='icoray_field_describe') result(status)
      import
      type(c_ptr), value :: ctx
      character(kind=c_char), intent(in) :: name(*)
      character(kind=c_char), intent(in) :: long_name(*)
      character(kind=c_char), intent(in) :: units(*)
      integer(c_int32_t) :: status
    end function icoray_field_describe_c
    function icoray_heights_set_c(ctx, heights) bind(C, name='icoray_heights_set') result(status)
      import
      type(c_ptr), value :: ctx
      type(c_ptr), value :: heights
      integer(c_int32_t) :: status
    end function icoray_heights_set_c
    function icoray_heights_set_ndarray_c(ctx, heights) bind(C, name='icoray_heights_set_ndarray') result(status)
      import
      type(c_ptr), value :: ctx
      type(c_ptr), value :: heights
      integer(c_int32_t) :: status
    end function icoray_heights_set_ndarray_c
    function icoray_scene_load_c(ctx, path) bind(C, name='icoray_scene_load') result(status)
      import
      type(c_ptr), value :: ctx
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int32_t) :: status
    end function icoray_scene_load_c
    function icoray_scene_text_c(ctx, toml) bind(C, name='icoray_scene_text') result(status)
      import
      type(c_ptr), value :: ctx
      character(kind=c_char), intent(in) :: toml(*)
      integer(c_int32_t) :: status
    end function icoray_scene_text_c
    function icoray_scene_field_c(ctx, index, name, len) bind(C, name='icoray_scene_field') result(status)
      import
      type(c_ptr), value :: ctx
      integer(c_int64_t), value :: index
      character(kind=c_char), intent(out) :: name(*)
      integer(c_size_t), value :: len
      integer(c_int32_t) :: status
    end function icoray_scene_field_c
    function icoray_wants_c(ctx, step, time_s, wants) bind(C, name='icoray_wants') result(status)
      import
      type(c_ptr), value :: ctx
      integer(c_int64_t), value :: step
      real(c_double), value :: time_s
      integer(c_int32_t), intent(out) :: wants
      integer(c_int32_t) :: status
    end function icoray_wants_c
    function icoray_wants_field_c(ctx, name, step, time_s, wants) bind(C, name='icoray_wants_field') result(status)
      import
      type(c_ptr), value :: ctx
      character(kind=c_char), intent(in) :: name(*)
      integer(c_int64_t), value :: step
      real(c_double), value :: time_s
      integer(c_int32_t), intent(out) :: wants
      integer(c_int32_t) :: status
    end function icoray_wants_field_c
    function icoray_execute_c(ctx, step, time_s, iso_datetime) bind(C, name='icoray_execute') result(status)
      import
      type(c_ptr), value :: ctx
      integer(c_int64_t), value :: step
      real(c_double), value :: time_s
      type(c_ptr), value :: iso_datetime   !< a string, or c_null_ptr
      integer(c_int32_t) :: status
    end function icoray_execute_c
    function icoray_wait_c(ctx) bind(C, name='icoray_wait') result(status)
      import
      type(c_ptr), value :: ctx
      integer(c_int32_t) :: status
    end function icoray_wait_c
    function icoray_report_c(ctx, report) bind(C, name='icoray_report') result(status)
      import
      type(c_ptr), value :: ctx
      type(icoray_frame_report), intent(inout) :: report
      integer(c_int32_t) :: status
    end function icoray_report_c
    subroutine icoray_log_stderr_c(user, level, message) bind(C, name='icoray_log_stderr')
      import
      type(c_ptr), value :: user
      integer(c_int32_t), value :: level
      type(c_ptr), value :: message
    end subroutine icoray_log_stderr_c
    function icoray_mesh_create_c(level, mesh) bind(C, name='icoray_mesh_create') result(status)
      import
      integer(c_int32_t), value :: level
      type(c_ptr), intent(out) :: mesh
      integer(c_int32_t) :: status
    end function icoray_mesh_create_c
    function icoray_mesh_grid_c(mesh, grid) bind(C, name='icoray_mesh_grid') result(status)
      import
      type(c_ptr), value :: mesh
      type(icoray_grid), intent(inout) :: grid
      integer(c_int32_t) :: status
    end function icoray_mesh_grid_c
    function icoray_mesh_free_c(mesh) bind(C, name='icoray_mesh_free') result(status)
      import
      type(c_ptr), intent(inout) :: mesh
      integer(c_int32_t) :: status
    end function icoray_mesh_free_c
    pure function c_strlen(text) bind(C, name='strlen') result(length)
      import
      type(c_ptr), value :: text
      integer(c_size_t) :: length
    end function c_strlen
  end interface
  public :: icoray_open_c, icoray_open_serial_c, icoray_close_c, icoray_last_error_c, icoray_version_c
  public :: icoray_points_set_c
  public :: icoray_grid_set_c, icoray_part_set_c, icoray_layers_set_c, icoray_field_set_c, icoray_field_set_ndarray_c
  public :: icoray_scene_load_c, icoray_field_describe_c, icoray_heights_set_c, icoray_heights_set_ndarray_c
  public :: icoray_scene_text_c, icoray_scene_field_c, icoray_wants_c, icoray_wants_field_c, icoray_execute_c
  public :: icoray_wait_c, icoray_report_c, icoray_log_stderr_c, icoray_mesh_create_c, icoray_mesh_grid_c
  public :: icoray_mesh_free_c

  !> Layout of an array: what a descriptor contains, found from the addresses of its elements.
  type :: view
    type(c_ptr) :: first = c_null_ptr           !< the first element; null where there is none
    integer :: rank = 0                         !< 0 where there is no array
    logical :: is_set = .false.                 !< whether it is associated; an array without elements is too
    integer(c_int64_t) :: extent(4) = 0, bytes(4) = 0   !< of each dimension: extent, and bytes between indices
  end type view
  interface view_of
    procedure :: view_r4_1, view_r4_2, view_r4_3, view_r4_4, view_r8_1, view_r8_2, view_r8_3, view_r8_4
    procedure :: view_i4_1, view_i4_2, view_i8_1, view_i8_2
  end interface view_of

contains

  subroutine open_serial(ctx, ierr, output_dir, threads, existing, on_error, disable_after, async_render, &
      writer_queue, when_full, log_level, log)
    type(icoray_context), intent(inout) :: ctx
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: output_dir
    integer, intent(in), optional :: threads, existing, on_error, disable_after, writer_queue, when_full, log_level
    logical, intent(in), optional :: async_render
    procedure(icoray_log), optional :: log
    call open_keywords(ctx, ierr, output_dir, threads, existing, on_error, disable_after, async_render, &
      writer_queue, when_full, log_level, log)
  end subroutine open_serial

  subroutine open_i4(ctx, comm, ierr, output_dir, threads, existing, on_error, disable_after, async_render, &
      writer_queue, when_full, log_level, log)
    type(icoray_context), intent(inout) :: ctx
    integer(c_int32_t), intent(in) :: comm
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: output_dir
    integer, intent(in), optional :: threads, existing, on_error, disable_after, writer_queue, when_full, log_level
    logical, intent(in), optional :: async_render
    procedure(icoray_log), optional :: log
    call open_keywords(ctx, ierr, output_dir, threads, existing, on_error, disable_after, async_render, &
      writer_queue, when_full, log_level, log, comm)
  end subroutine open_i4

  subroutine open_i8(ctx, comm, ierr, output_dir, threads, existing, on_error, disable_after, async_render, &
      writer_queue, when_full, log_level, log)
    type(icoray_context), intent(inout) :: ctx
    integer(c_int64_t), intent(in) :: comm
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: output_dir
    integer, intent(in), optional :: threads, existing, on_error, disable_after, writer_queue, when_full, log_level
    logical, intent(in), optional :: async_render
    procedure(icoray_log), optional :: log
    call open_keywords(ctx, ierr, output_dir, threads, existing, on_error, disable_after, async_render, &
      writer_queue, when_full, log_level, log, int(comm, c_int32_t))
  end subroutine open_i8

  !> Opens a context; without comm for one process.
  subroutine open_keywords(ctx, ierr, output_dir, threads, existing, on_error, disable_after, async_render, &
      writer_queue, when_full, log_level, log, comm)
    type(icoray_context), intent(inout) :: ctx
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: output_dir
    integer, intent(in), optional :: threads, existing, on_error, disable_after, writer_queue, when_full, log_level
    logical, intent(in), optional :: async_render
    procedure(icoray_log), optional :: log
    integer(c_int32_t), intent(in), optional :: comm
    type(icoray_config) :: config
    type(own_part), pointer :: own
    character(kind=c_char), allocatable, target :: directory(:)
    if (is_open(ctx, ierr)) return
    if (present(output_dir)) then
      directory = c_text(output_dir)
      config%output_dir = c_loc(directory)
    end if
    config%log_level = ICORAY_LOG_WARN
    call put(config%threads, threads)
    call put(config%existing, existing)
    call put(config%on_error, on_error)
    call put(config%disable_after, disable_after)
    call put(config%writer_queue, writer_queue)
    call put(config%when_full, when_full)
    call put(config%log_level, log_level)
    if (present(async_render)) config%async_render = merge(1_c_int32_t, 0_c_int32_t, async_render)
    allocate (own)
    if (present(log)) then
      own%log => log
      config%log = c_funloc(relay)
      config%log_user = c_loc(own)
    end if
    call open_with(ctx, config, own, ierr, comm)
  end subroutine open_keywords

  subroutine open_config(ctx, config, ierr)
    type(icoray_context), intent(inout) :: ctx
    type(icoray_config), intent(in) :: config
    integer, intent(out), optional :: ierr
    call open_struct(ctx, config, ierr)
  end subroutine open_config

  subroutine open_config_i4(ctx, comm, config, ierr)
    type(icoray_context), intent(inout) :: ctx
    integer(c_int32_t), intent(in) :: comm
    type(icoray_config), intent(in) :: config
    integer, intent(out), optional :: ierr
    call open_struct(ctx, config, ierr, comm)
  end subroutine open_config_i4

  subroutine open_config_i8(ctx, comm, config, ierr)
    type(icoray_context), intent(inout) :: ctx
    integer(c_int64_t), intent(in) :: comm
    type(icoray_config), intent(in) :: config
    integer, intent(out), optional :: ierr
    call open_struct(ctx, config, ierr, int(comm, c_int32_t))
  end subroutine open_config_i8

  subroutine open_struct(ctx, config, ierr, comm)
    type(icoray_context), intent(inout) :: ctx
    type(icoray_config), intent(in) :: config
    integer, intent(out), optional :: ierr
    integer(c_int32_t), intent(in), optional :: comm
    type(own_part), pointer :: own
    if (is_open(ctx, ierr)) return
    allocate (own)
    call open_with(ctx, config, own, ierr, comm)
  end subroutine open_struct

  subroutine open_with(ctx, config, own, ierr, comm)
    type(icoray_context), intent(inout) :: ctx
    type(icoray_config), intent(in) :: config
    type(own_part), pointer, intent(in) :: own
    integer, intent(out), optional :: ierr
    integer(c_int32_t), intent(in), optional :: comm
    type(icoray_config) :: sized
    integer(c_int32_t) :: status
    type(own_part), pointer :: unused
    sized = config
    sized%struct_size = c_sizeof(sized)
    if (present(comm)) then
      status = icoray_open_c(sized, comm, ctx%handle)
    else
      status = icoray_open_serial_c(sized, ctx%handle)
    end if
    unused => own
    if (status == ICORAY_OK) then
      ctx%own => own
    else
      deallocate (unused)
    end if
    call done(status, ierr)
  end subroutine open_with

  !> Whether ctx is already open; opening it again would lose the context.
  function is_open(ctx, ierr) result(open)
    type(icoray_context), intent(in) :: ctx
    integer, intent(out), optional :: ierr
    logical :: open
    open = c_associated(ctx%handle)
    if (open) call refuse(ctx, 'icoray_open', '', ICORAY_ERR_ORDER, &
      'the context is open already; call icoray_close first', ierr)
  end function is_open

  !> Waits for all frames, closes the context and ends the borrow of all arrays; a context that is not open is allowed.
  !> A status other than ICORAY_ERR_BUSY is that of a frame whose failure no call has returned; the context is closed
  !> all the same, and icoray_last_error(message) returns the message.
  subroutine icoray_close(ctx, ierr)
    type(icoray_context), intent(inout) :: ctx
    integer, intent(out), optional :: ierr
    integer(c_int32_t) :: status
    status = icoray_close_c(ctx%handle)
    call done(status, ierr)
    if (associated(ctx%own) .and. .not. c_associated(ctx%handle)) deallocate (ctx%own)
  end subroutine icoray_close

  subroutine last_error_ctx(ctx, message, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(out) :: message
    integer, intent(out), optional :: ierr
    call message_of(ctx%handle, message, ierr)
  end subroutine last_error_ctx

  subroutine last_error_thread(message, ierr)
    character(len=*), intent(out) :: message
    integer, intent(out), optional :: ierr
    call message_of(c_null_ptr, message, ierr)
  end subroutine last_error_thread

  subroutine message_of(handle, message, ierr)
    type(c_ptr), intent(in) :: handle
    character(len=*), intent(out) :: message
    integer, intent(out), optional :: ierr
    character(kind=c_char) :: buffer(len(message) + 1)
    integer(c_int32_t) :: status
    integer :: i
    buffer(1) = c_null_char
    status = icoray_last_error_c(handle, buffer, int(size(buffer), c_size_t))
    message = ''
    do i = 1, len(message)
      if (buffer(i) == c_null_char) exit
      message(i:i) = buffer(i)
    end do
    if (present(ierr)) ierr = int(status)
  end subroutine message_of

  !> Returns the library's version, 'major.minor.patch'.
  function icoray_version() result(version)
    character(len=:), allocatable :: version
    version = f_text(icoray_version_c())
  end function icoray_version

  !> A log procedure that writes lines such as 'icoray: warning: ...' to standard error.
  subroutine icoray_log_stderr(level, message)
    integer, intent(in) :: level
    character(len=*), intent(in) :: message
    character(kind=c_char), target :: line(len_trim(message) + 1)
    line = c_text(message)
    call icoray_log_stderr_c(c_null_ptr, int(level, c_int32_t), c_loc(line))
  end subroutine icoray_log_stderr

  !> Passes a line of the library's log to the Fortran procedure; user is the context's state in this module.
  subroutine relay(user, level, message) bind(C, name='')
    type(c_ptr), value :: user
    integer(c_int32_t), value :: level
    type(c_ptr), value :: message
    type(own_part), pointer :: own
    call c_f_pointer(user, own)
    call own%log(int(level), f_text(message))
  end subroutine relay

  !> Creates the icosahedral mesh with 10*4**level + 2 cells, level 0 to 12 (else ICORAY_ERR_ARGUMENT).
  subroutine icoray_mesh_create(level, mesh, ierr)
    integer, intent(in) :: level
    type(icoray_mesh), intent(inout) :: mesh
    integer, intent(out), optional :: ierr
    integer(c_int32_t) :: status
    status = ICORAY_ERR_ORDER   ! one that is there would be lost
    if (.not. c_associated(mesh%handle)) status = icoray_mesh_create_c(int(level, c_int32_t), mesh%handle)
    if (present(ierr)) ierr = int(status)
  end subroutine icoray_mesh_create

  !> Frees a mesh that no context uses any more; a mesh that was not created is allowed.
  subroutine icoray_mesh_free(mesh, ierr)
    type(icoray_mesh), intent(inout) :: mesh
    integer, intent(out), optional :: ierr
    integer(c_int32_t) :: status
    status = icoray_mesh_free_c(mesh%handle)
    if (present(ierr)) ierr = int(status)
  end subroutine icoray_mesh_free

  !> Returns the sizes and tables of a mesh as addresses, valid until icoray_mesh_free.
  subroutine icoray_mesh_grid(mesh, grid, ierr)
    type(icoray_mesh), intent(in) :: mesh
    type(icoray_grid), intent(out) :: grid
    integer, intent(out), optional :: ierr
    integer(c_int32_t) :: status
    grid%struct_size = c_sizeof(grid)
    status = icoray_mesh_grid_c(mesh%handle, grid)
    if (present(ierr)) ierr = int(status)
  end subroutine icoray_mesh_grid

  !> Returns the tables of a mesh as arrays, valid until icoray_mesh_free; none is associated on failure.
  subroutine icoray_mesh_tables(mesh, tables, ierr)
    type(icoray_mesh), intent(in) :: mesh
    type(icoray_grid_tables), intent(out) :: tables
    integer, intent(out), optional :: ierr
    type(icoray_grid) :: grid
    integer :: status
    call icoray_mesh_grid(mesh, grid, status)
    if (present(ierr)) ierr = status
    if (status /= ICORAY_OK) return
    tables%index_base = int(grid%index_base)
    call c_f_pointer(grid%lon_center_rad, tables%lon_center, [grid%cells])
    call c_f_pointer(grid%lat_center_rad, tables%lat_center, [grid%cells])
    call c_f_pointer(grid%lon_corner_rad, tables%lon_corner, [grid%corners])
    call c_f_pointer(grid%lat_corner_rad, tables%lat_corner, [grid%corners])
    call c_f_pointer(grid%cell_corner, tables%cell_corner, [grid%cell_corner_row, grid%cells])
    call c_f_pointer(grid%corner_cell, tables%corner_cell, [3_c_int64_t, grid%corners])
    call c_f_pointer(grid%corner_edge, tables%corner_edge, [3_c_int64_t, grid%corners])
    call c_f_pointer(grid%edge_corner, tables%edge_corner, [2_c_int64_t, grid%edges])
  end subroutine icoray_mesh_tables

  subroutine grid_r4_i4(ctx, lon_center, lat_center, lon_corner, lat_corner, cell_corner, &
      corner_cell, corner_edge, edge_corner, ierr, index_base, cell_corner_count, cells, corners, edges, name)
    type(icoray_context), intent(in) :: ctx
    real(c_float), pointer, intent(in) :: lon_center(:), lat_center(:), lon_corner(:), lat_corner(:)
    integer(c_int32_t), pointer, intent(in) :: cell_corner(:, :), corner_cell(:, :), corner_edge(:, :)
    integer(c_int32_t), pointer, intent(in) :: edge_corner(:, :)
    integer, intent(out), optional :: ierr
    integer(c_int32_t), pointer, intent(in), optional :: cell_corner_count(:)
    integer, intent(in), optional :: index_base, cells, corners, edges
    character(len=*), intent(in), optional :: name
    type(view) :: count
    if (present(cell_corner_count)) count = view_of(cell_corner_count)
    call set_views(ctx, [view_of(lon_center), view_of(lat_center), view_of(lon_corner), view_of(lat_corner), &
      view_of(cell_corner), view_of(corner_cell), view_of(corner_edge), view_of(edge_corner), count], &
      ICORAY_F32, ICORAY_I32, ierr, index_base, cells, corners, edges, name)
  end subroutine grid_r4_i4

  subroutine grid_r4_i8(ctx, lon_center, lat_center, lon_corner, lat_corner, cell_corner, &
      corner_cell, corner_edge, edge_corner, ierr, index_base, cell_corner_count, cells, corners, edges, name)
    type(icoray_context), intent(in) :: ctx
    real(c_float), pointer, intent(in) :: lon_center(:), lat_center(:), lon_corner(:), lat_corner(:)
    integer(c_int64_t), pointer, intent(in) :: cell_corner(:, :), corner_cell(:, :), corner_edge(:, :)
    integer(c_int64_t), pointer, intent(in) :: edge_corner(:, :)
    integer, intent(out), optional :: ierr
    integer(c_int64_t), pointer, intent(in), optional :: cell_corner_count(:)
    integer, intent(in), optional :: index_base, cells, corners, edges
    character(len=*), intent(in), optional :: name
    type(view) :: count
    if (present(cell_corner_count)) count = view_of(cell_corner_count)
    call set_views(ctx, [view_of(lon_center), view_of(lat_center), view_of(lon_corner), view_of(lat_corner), &
      view_of(cell_corner), view_of(corner_cell), view_of(corner_edge), view_of(edge_corner), count], &
      ICORAY_F32, ICORAY_I64, ierr, index_base, cells, corners, edges, name)
  end subroutine grid_r4_i8

  subroutine grid_r8_i4(ctx, lon_center, lat_center, lon_corner, lat_corner, cell_corner, &
      corner_cell, corner_edge, edge_corner, ierr, index_base, cell_corner_count, cells, corners, edges, name)
    type(icoray_context), intent(in) :: ctx
    real(c_double), pointer, intent(in) :: lon_center(:), lat_center(:), lon_corner(:), lat_corner(:)
    integer(c_int32_t), pointer, intent(in) :: cell_corner(:, :), corner_cell(:, :), corner_edge(:, :)
    integer(c_int32_t), pointer, intent(in) :: edge_corner(:, :)
    integer, intent(out), optional :: ierr
    integer(c_int32_t), pointer, intent(in), optional :: cell_corner_count(:)
    integer, intent(in), optional :: index_base, cells, corners, edges
    character(len=*), intent(in), optional :: name
    type(view) :: count
    if (present(cell_corner_count)) count = view_of(cell_corner_count)
    call set_views(ctx, [view_of(lon_center), view_of(lat_center), view_of(lon_corner), view_of(lat_corner), &
      view_of(cell_corner), view_of(corner_cell), view_of(corner_edge), view_of(edge_corner), count], &
      ICORAY_F64, ICORAY_I32, ierr, index_base, cells, corners, edges, name)
  end subroutine grid_r8_i4

  subroutine grid_r8_i8(ctx, lon_center, lat_center, lon_corner, lat_corner, cell_corner, &
      corner_cell, corner_edge, edge_corner, ierr, index_base, cell_corner_count, cells, corners, edges, name)
    type(icoray_context), intent(in) :: ctx
    real(c_double), pointer, intent(in) :: lon_center(:), lat_center(:), lon_corner(:), lat_corner(:)
    integer(c_int64_t), pointer, intent(in) :: cell_corner(:, :), corner_cell(:, :), corner_edge(:, :)
    integer(c_int64_t), pointer, intent(in) :: edge_corner(:, :)
    integer, intent(out), optional :: ierr
    integer(c_int64_t), pointer, intent(in), optional :: cell_corner_count(:)
    integer, intent(in), optional :: index_base, cells, corners, edges
    character(len=*), intent(in), optional :: name
    type(view) :: count
    if (present(cell_corner_count)) count = view_of(cell_corner_count)
    call set_views(ctx, [view_of(lon_center), view_of(lat_center), view_of(lon_corner), view_of(lat_corner), &
      view_of(cell_corner), view_of(corner_cell), view_of(corner_edge), view_of(edge_corner), count], &
      ICORAY_F64, ICORAY_I64, ierr, index_base, cells, corners, edges, name)
  end subroutine grid_r8_i8

  subroutine grid_mesh(ctx, mesh, ierr, name)
    type(icoray_context), intent(in) :: ctx
    type(icoray_mesh), intent(in) :: mesh
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: name
    type(icoray_grid) :: grid
    character(kind=c_char), allocatable, target :: c_name(:)
    character(len=400) :: message
    integer :: status
    call icoray_mesh_grid(mesh, grid, status)
    if (status /= ICORAY_OK) then
      call message_of(c_null_ptr, message)
      call refuse(ctx, 'icoray_grid_set', given_name(name), status, message, ierr)
      return
    end if
    call put_name(grid%name, c_name, name)
    call grid_struct(ctx, grid, ierr)
  end subroutine grid_mesh

  subroutine grid_struct(ctx, grid, ierr)
    type(icoray_context), intent(in) :: ctx
    type(icoray_grid), intent(in) :: grid
    integer, intent(out), optional :: ierr
    type(icoray_grid) :: sized
    sized = grid
    sized%struct_size = c_sizeof(sized)
    call done(icoray_grid_set_c(ctx%handle, sized), ierr)
  end subroutine grid_struct

  subroutine points_r4(ctx, lon, lat, ierr, name)
    type(icoray_context), intent(in) :: ctx
    real(c_float), intent(in) :: lon(:), lat(:)
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: name
    real(c_float), allocatable, target :: places(:, :)
    character(kind=c_char), allocatable, target :: c_name(:)
    type(c_ptr) :: named
    if (size(lon) /= size(lat) .and. c_associated(ctx%handle)) then
      call refuse(ctx, 'icoray_points_set', given_name(name), ICORAY_ERR_ARGUMENT, 'lat: ' &
        //decimal(size(lat, kind=c_int64_t))//' values, expected '//decimal(size(lon, kind=c_int64_t))//' as of lon', ierr)
      return
    end if
    allocate (places(size(lon) + 1, 2))   ! never empty, so that it has an address
    places(:size(lon), 1) = lon
    places(:size(lon), 2) = lat(:min(size(lat), size(lon)))
    named = c_null_ptr
    call put_name(named, c_name, name)
    call done(icoray_points_set_c(ctx%handle, named, size(lon, kind=c_int64_t), int(ICORAY_F32, c_int32_t), &
      c_loc(places(1, 1)), c_loc(places(1, 2))), ierr)
  end subroutine points_r4

  subroutine points_r8(ctx, lon, lat, ierr, name)
    type(icoray_context), intent(in) :: ctx
    real(c_double), intent(in) :: lon(:), lat(:)
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: name
    real(c_double), allocatable, target :: places(:, :)
    character(kind=c_char), allocatable, target :: c_name(:)
    type(c_ptr) :: named
    if (size(lon) /= size(lat) .and. c_associated(ctx%handle)) then
      call refuse(ctx, 'icoray_points_set', given_name(name), ICORAY_ERR_ARGUMENT, 'lat: ' &
        //decimal(size(lat, kind=c_int64_t))//' values, expected '//decimal(size(lon, kind=c_int64_t))//' as of lon', ierr)
      return
    end if
    allocate (places(size(lon) + 1, 2))   ! never empty, so that it has an address
    places(:size(lon), 1) = lon
    places(:size(lon), 2) = lat(:min(size(lat), size(lon)))
    named = c_null_ptr
    call put_name(named, c_name, name)
    call done(icoray_points_set_c(ctx%handle, named, size(lon, kind=c_int64_t), int(ICORAY_F64, c_int32_t), &
      c_loc(places(1, 1)), c_loc(places(1, 2))), ierr)
  end subroutine points_r8

  !> Checks the shapes of the tables, which the library cannot see, and passes their addresses on. The views are those
  !> of the arrays in the order of icoray_grid_set, followed by cell_corner_count, of rank 0 if absent.
  subroutine set_views(ctx, v, real_type, index_type, ierr, index_base, cells, corners, edges, name)
    type(icoray_context), intent(in) :: ctx
    type(view), intent(in) :: v(9)
    integer, intent(in) :: real_type, index_type
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: index_base, cells, corners, edges
    character(len=*), intent(in), optional :: name
    character(len=*), parameter :: table(9) = [character(len=17) :: 'lon_center', 'lat_center', 'lon_corner', &
      'lat_corner', 'cell_corner', 'corner_cell', 'corner_edge', 'edge_corner', 'cell_corner_count']
    integer, parameter :: counts(9) = [1, 1, 2, 2, 1, 2, 2, 3, 1]       ! cells, corners or edges
    integer, parameter :: rows(9) = [0, 0, 0, 0, 0, 3, 3, 2, 0]         ! length of a row where it is fixed
    type(icoray_grid) :: grid
    character(kind=c_char), allocatable, target :: c_name(:)
    integer(c_int64_t) :: n(3), whole, apart
    integer :: i, d
    n = [v(1)%extent(1), v(3)%extent(1), v(8)%extent(2)]
    if (present(cells)) n(1) = cells
    if (present(corners)) n(2) = corners
    if (present(edges)) n(3) = edges
    do i = 1, 9
      if (v(i)%rank == 0 .or. .not. c_associated(ctx%handle)) cycle
      if (.not. v(i)%is_set) then
        call refuse(ctx, 'icoray_grid_set', given_name(name), ICORAY_ERR_NULL, trim(table(i)) &
          //' is not associated', ierr)
        return
      end if
      if (rows(i) /= 0 .and. v(i)%extent(1) /= rows(i)) then
        call refuse(ctx, 'icoray_grid_set', given_name(name), ICORAY_ERR_ARGUMENT, trim(table(i))//': columns of ' &
          //decimal(v(i)%extent(1))//', expected '//decimal(int(rows(i), c_int64_t)), ierr)
        return
      end if
      if (v(i)%extent(v(i)%rank) < n(counts(i))) then
        call refuse(ctx, 'icoray_grid_set', given_name(name), ICORAY_ERR_ARGUMENT, trim(table(i))//': ' &
          //decimal(v(i)%extent(v(i)%rank))//' entries or columns, expected at least '//decimal(n(counts(i))), ierr)
        return
      end if
      if (.not. c_associated(v(i)%first)) cycle   ! no element, so no address either
      apart = merge(8, 4, merge(real_type == ICORAY_F64, index_type == ICORAY_I64, i <= 4))
      do d = 1, v(i)%rank
        whole = v(i)%bytes(d)
        if (v(i)%extent(d) > 1 .and. whole /= apart) then
          call refuse(ctx, 'icoray_grid_set', given_name(name), ICORAY_ERR_ARGUMENT, trim(table(i)) &
            //': not contiguous, dimension '//decimal(int(d, c_int64_t))//' steps by '//decimal(whole) &
            //' bytes, expected '//decimal(apart), ierr)
          return
        end if
        apart = apart*v(i)%extent(d)
      end do
    end do
    grid%cells = n(1)
    grid%corners = n(2)
    grid%edges = n(3)
    grid%index_base = 1
    call put(grid%index_base, index_base)
    grid%real_type = int(real_type, c_int32_t)
    grid%index_type = int(index_type, c_int32_t)
    grid%lon_center_rad = v(1)%first
    grid%lat_center_rad = v(2)%first
    grid%lon_corner_rad = v(3)%first
    grid%lat_corner_rad = v(4)%first
    grid%cell_corner = v(5)%first
    grid%cell_corner_row = v(5)%extent(1)
    grid%corner_cell = v(6)%first
    grid%corner_edge = v(7)%first
    grid%edge_corner = v(8)%first
    grid%cell_corner_count = v(9)%first
    call put_name(grid%name, c_name, name)
    call grid_struct(ctx, grid, ierr)
  end subroutine set_views

  subroutine part_first_i4(ctx, cell_global, ierr, owned, grid, corner_global, owned_corners)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t), intent(in), contiguous, target :: cell_global(:)
    integer, intent(out), optional :: ierr
    integer, intent(in) :: owned
    character(len=*), intent(in), optional :: grid
    integer(c_int32_t), intent(in), contiguous, target, optional :: corner_global(:)
    integer, intent(in), optional :: owned_corners
    type(view) :: corners
    if (present(corner_global)) corners = view_of(corner_global)
    call part_first(ctx, ICORAY_I32, view_of(cell_global), owned, ierr, grid, corners, owned_corners)
  end subroutine part_first_i4

  subroutine part_mask_i4(ctx, cell_global, ierr, is_owned, grid, corner_global, is_corner_owned)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t), intent(in), contiguous, target :: cell_global(:)
    integer, intent(out), optional :: ierr
    logical, intent(in) :: is_owned(:)
    character(len=*), intent(in), optional :: grid
    integer(c_int32_t), intent(in), contiguous, target, optional :: corner_global(:)
    logical, intent(in), optional :: is_corner_owned(:)
    type(view) :: corners
    integer(c_int32_t), allocatable :: corner_marks(:)   ! absent where it is not allocated
    if (present(corner_global)) corners = view_of(corner_global)
    if (present(is_corner_owned)) corner_marks = merge(1_c_int32_t, 0_c_int32_t, is_corner_owned)
    call part_marks(ctx, ICORAY_I32, view_of(cell_global), merge(1_c_int32_t, 0_c_int32_t, is_owned), ierr, &
      grid, corners, corner_marks)
  end subroutine part_mask_i4

  subroutine part_marks_i4(ctx, cell_global, ierr, is_owned, grid, corner_global, is_corner_owned)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t), intent(in), contiguous, target :: cell_global(:)
    integer, intent(out), optional :: ierr
    integer(c_int32_t), intent(in) :: is_owned(:)
    character(len=*), intent(in), optional :: grid
    integer(c_int32_t), intent(in), contiguous, target, optional :: corner_global(:)
    integer(c_int32_t), intent(in), optional :: is_corner_owned(:)
    type(view) :: corners
    if (present(corner_global)) corners = view_of(corner_global)
    call part_marks(ctx, ICORAY_I32, view_of(cell_global), is_owned, ierr, grid, corners, is_corner_owned)
  end subroutine part_marks_i4

  subroutine part_first_i8(ctx, cell_global, ierr, owned, grid, corner_global, owned_corners)
    type(icoray_context), intent(in) :: ctx
    integer(c_int64_t), intent(in), contiguous, target :: cell_global(:)
    integer, intent(out), optional :: ierr
    integer, intent(in) :: owned
    character(len=*), intent(in), optional :: grid
    integer(c_int64_t), intent(in), contiguous, target, optional :: corner_global(:)
    integer, intent(in), optional :: owned_corners
    type(view) :: corners
    if (present(corner_global)) corners = view_of(corner_global)
    call part_first(ctx, ICORAY_I64, view_of(cell_global), owned, ierr, grid, corners, owned_corners)
  end subroutine part_first_i8

  subroutine part_mask_i8(ctx, cell_global, ierr, is_owned, grid, corner_global, is_corner_owned)
    type(icoray_context), intent(in) :: ctx
    integer(c_int64_t), intent(in), contiguous, target :: cell_global(:)
    integer, intent(out), optional :: ierr
    logical, intent(in) :: is_owned(:)
    character(len=*), intent(in), optional :: grid
    integer(c_int64_t), intent(in), contiguous, target, optional :: corner_global(:)
    logical, intent(in), optional :: is_corner_owned(:)
    type(view) :: corners
    integer(c_int32_t), allocatable :: corner_marks(:)   ! absent where it is not allocated
    if (present(corner_global)) corners = view_of(corner_global)
    if (present(is_corner_owned)) corner_marks = merge(1_c_int32_t, 0_c_int32_t, is_corner_owned)
    call part_marks(ctx, ICORAY_I64, view_of(cell_global), merge(1_c_int32_t, 0_c_int32_t, is_owned), ierr, &
      grid, corners, corner_marks)
  end subroutine part_mask_i8

  subroutine part_marks_i8(ctx, cell_global, ierr, is_owned, grid, corner_global, is_corner_owned)
    type(icoray_context), intent(in) :: ctx
    integer(c_int64_t), intent(in), contiguous, target :: cell_global(:)
    integer, intent(out), optional :: ierr
    integer(c_int32_t), intent(in) :: is_owned(:)
    character(len=*), intent(in), optional :: grid
    integer(c_int64_t), intent(in), contiguous, target, optional :: corner_global(:)
    integer(c_int32_t), intent(in), optional :: is_corner_owned(:)
    type(view) :: corners
    if (present(corner_global)) corners = view_of(corner_global)
    call part_marks(ctx, ICORAY_I64, view_of(cell_global), is_owned, ierr, grid, corners, is_corner_owned)
  end subroutine part_marks_i8

  subroutine part_first(ctx, index_type, cell_global, owned, ierr, grid, corner_global, owned_corners)
    type(icoray_context), intent(in) :: ctx
    integer, intent(in) :: index_type, owned
    type(view), intent(in) :: cell_global, corner_global
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: grid
    integer, intent(in), optional :: owned_corners
    type(icoray_part) :: part
    character(kind=c_char), allocatable, target :: c_grid(:)
    part%cells = cell_global%extent(1)
    part%index_type = int(index_type, c_int32_t)
    part%cell_global = cell_global%first
    part%owned_cells = int(owned, c_int64_t)
    part%corners = corner_global%extent(1)
    part%corner_global = corner_global%first
    if (present(owned_corners)) part%owned_corners = int(owned_corners, c_int64_t)
    call put_name(part%grid, c_grid, grid)
    call part_struct(ctx, part, ierr)
  end subroutine part_first

  !> Different lengths are passed as a length that no array has, which the library refuses on all ranks: an error in
  !> this module would leave the other ranks waiting.
  subroutine part_marks(ctx, index_type, cell_global, is_owned, ierr, grid, corner_global, is_corner_owned)
    type(icoray_context), intent(in) :: ctx
    integer, intent(in) :: index_type
    type(view), intent(in) :: cell_global, corner_global
    integer(c_int32_t), intent(in) :: is_owned(:)
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: grid
    integer(c_int32_t), intent(in), optional :: is_corner_owned(:)
    type(icoray_part) :: part
    integer(c_int32_t), allocatable, target :: marks(:), corner_marks(:)
    character(kind=c_char), allocatable, target :: c_grid(:)
    allocate (marks(size(is_owned) + 1))   ! never empty, so that it has an address
    marks(:size(is_owned)) = is_owned
    part%cells = cell_global%extent(1)
    if (part%cells /= size(is_owned, kind=c_int64_t)) part%cells = -1 - size(is_owned, kind=c_int64_t)
    part%index_type = int(index_type, c_int32_t)
    part%cell_global = cell_global%first
    part%is_owned = c_loc(marks)
    part%corners = corner_global%extent(1)
    part%corner_global = corner_global%first
    if (present(is_corner_owned)) then
      allocate (corner_marks(size(is_corner_owned) + 1))
      corner_marks(:size(is_corner_owned)) = is_corner_owned
      if (part%corners /= size(is_corner_owned, kind=c_int64_t)) &
        part%corners = -1 - size(is_corner_owned, kind=c_int64_t)
      part%is_corner_owned = c_loc(corner_marks)
    end if
    call put_name(part%grid, c_grid, grid)
    call part_struct(ctx, part, ierr)
  end subroutine part_marks

  subroutine part_struct(ctx, part, ierr)
    type(icoray_context), intent(in) :: ctx
    type(icoray_part), intent(in) :: part
    integer, intent(out), optional :: ierr
    type(icoray_part) :: sized
    sized = part
    sized%struct_size = c_sizeof(sized)
    call done(icoray_part_set_c(ctx%handle, sized), ierr)
  end subroutine part_struct

  subroutine layers_r4(ctx, radius_m, planet_radius_m, ierr, name)
    type(icoray_context), intent(in) :: ctx
    real(c_float), intent(in) :: radius_m(:), planet_radius_m
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: name
    call layers_r8(ctx, real(radius_m, c_double), real(planet_radius_m, c_double), ierr, name)
  end subroutine layers_r4

  subroutine layers_r8(ctx, radius_m, planet_radius_m, ierr, name)
    type(icoray_context), intent(in) :: ctx
    real(c_double), intent(in) :: radius_m(:), planet_radius_m
    integer, intent(out), optional :: ierr
    character(len=*), intent(in), optional :: name
    type(icoray_layers) :: layers
    real(c_double), target :: radius(size(radius_m) + 1)   ! never empty, so that it has an address
    character(kind=c_char), allocatable, target :: c_name(:)
    radius(:size(radius_m)) = radius_m
    layers%radius_m = c_loc(radius)
    layers%count = size(radius_m, kind=c_int64_t)
    layers%planet_radius_m = planet_radius_m
    call put_name(layers%name, c_name, name)
    call layers_struct(ctx, layers, ierr)
  end subroutine layers_r8

  subroutine layers_struct(ctx, layers, ierr)
    type(icoray_context), intent(in) :: ctx
    type(icoray_layers), intent(in) :: layers
    integer, intent(out), optional :: ierr
    type(icoray_layers) :: sized
    sized = layers
    sized%struct_size = c_sizeof(sized)
    call done(icoray_layers_set_c(ctx%handle, sized), ierr)
  end subroutine layers_struct

  subroutine field_r4_1(ctx, name, values, ierr, location, fill_value, grid_name, layers_name)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    real(c_float), pointer, intent(in) :: values(:)
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: location
    real(c_float), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    real(c_double), allocatable :: fill   ! absent where it is not allocated
    if (present(fill_value)) fill = real(fill_value, c_double)
    call field_view(ctx, name, view_of(values), ICORAY_F32, ierr, location, fill, grid_name, layers_name)
  end subroutine field_r4_1

  subroutine field_r4_2(ctx, name, values, ierr, location, fill_value, grid_name, layers_name)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    real(c_float), pointer, intent(in) :: values(:, :)
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: location
    real(c_float), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    real(c_double), allocatable :: fill   ! absent where it is not allocated
    if (present(fill_value)) fill = real(fill_value, c_double)
    call field_view(ctx, name, view_of(values), ICORAY_F32, ierr, location, fill, grid_name, layers_name)
  end subroutine field_r4_2

  subroutine field_r4_3(ctx, name, values, ierr, location, fill_value, grid_name, layers_name)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    real(c_float), pointer, intent(in) :: values(:, :, :)
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: location
    real(c_float), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    real(c_double), allocatable :: fill   ! absent where it is not allocated
    if (present(fill_value)) fill = real(fill_value, c_double)
    call field_view(ctx, name, view_of(values), ICORAY_F32, ierr, location, fill, grid_name, layers_name)
  end subroutine field_r4_3

  subroutine field_r4_4(ctx, name, values, ierr, location, fill_value, grid_name, layers_name)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    real(c_float), pointer, intent(in) :: values(:, :, :, :)
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: location
    real(c_float), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    real(c_double), allocatable :: fill   ! absent where it is not allocated
    if (present(fill_value)) fill = real(fill_value, c_double)
    call field_view(ctx, name, view_of(values), ICORAY_F32, ierr, location, fill, grid_name, layers_name)
  end subroutine field_r4_4

  subroutine field_r8_1(ctx, name, values, ierr, location, fill_value, grid_name, layers_name)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    real(c_double), pointer, intent(in) :: values(:)
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: location
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    call field_view(ctx, name, view_of(values), ICORAY_F64, ierr, location, fill_value, grid_name, layers_name)
  end subroutine field_r8_1

  subroutine field_r8_2(ctx, name, values, ierr, location, fill_value, grid_name, layers_name)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    real(c_double), pointer, intent(in) :: values(:, :)
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: location
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    call field_view(ctx, name, view_of(values), ICORAY_F64, ierr, location, fill_value, grid_name, layers_name)
  end subroutine field_r8_2

  subroutine field_r8_3(ctx, name, values, ierr, location, fill_value, grid_name, layers_name)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    real(c_double), pointer, intent(in) :: values(:, :, :)
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: location
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    call field_view(ctx, name, view_of(values), ICORAY_F64, ierr, location, fill_value, grid_name, layers_name)
  end subroutine field_r8_3

  subroutine field_r8_4(ctx, name, values, ierr, location, fill_value, grid_name, layers_name)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    real(c_double), pointer, intent(in) :: values(:, :, :, :)
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: location
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    call field_view(ctx, name, view_of(values), ICORAY_F64, ierr, location, fill_value, grid_name, layers_name)
  end subroutine field_r8_4

  subroutine field_struct(ctx, name, array, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    type(icoray_array), intent(in) :: array
    integer, intent(out), optional :: ierr
    type(icoray_array) :: sized
    sized = array
    sized%struct_size = c_sizeof(sized)
    call done(icoray_field_set_c(ctx%handle, c_text(name), sized), ierr)
  end subroutine field_struct

  !> As icoray_field_set, for an array of up to ICORAY_MAX_RANK dimensions given by its address.
  subroutine icoray_field_set_ndarray(ctx, name, array, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    type(icoray_ndarray), intent(in) :: array
    integer, intent(out), optional :: ierr
    type(icoray_ndarray) :: sized
    sized = array
    sized%struct_size = c_sizeof(sized)
    call done(icoray_field_set_ndarray_c(ctx%handle, c_text(name), sized), ierr)
  end subroutine icoray_field_set_ndarray

  !> Sets the long name and the units (such as 'm s-1') of a field for labels in pictures; either may be blank. They
  !> apply to the field of that name, set before or later.
  subroutine icoray_field_describe(ctx, name, long_name, units, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name, long_name, units
    integer, intent(out), optional :: ierr
    call done(icoray_field_describe_c(ctx%handle, c_text(name), c_text(long_name), c_text(units)), ierr)
  end subroutine icoray_field_describe

  subroutine field_view(ctx, name, v, type, ierr, location, fill_value, grid_name, layers_name)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    type(view), intent(in) :: v
    integer, intent(in) :: type
    integer, intent(out), optional :: ierr
    integer, intent(in), optional :: location
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    type(icoray_ndarray) :: array
    character(kind=c_char), allocatable, target :: grid(:), layers(:)
    if (.not. is_laid_out(array, ctx, 'icoray_field_set', name, v, type, ierr)) return
    call put(array%location, location)
    if (present(fill_value)) then
      array%has_fill = 1
      array%fill_value = fill_value
    end if
    call put_name(array%grid_name, grid, grid_name)
    call put_name(array%layers_name, layers, layers_name)
    call icoray_field_set_ndarray(ctx, name, array, ierr)
  end subroutine field_view

  !> Fills in the layout of an array, or reports strides that are not whole elements.
  function is_laid_out(array, ctx, of_call, name, v, type, ierr)
    type(icoray_ndarray), intent(inout) :: array
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: of_call, name
    type(view), intent(in) :: v
    integer, intent(in) :: type
    integer, intent(out), optional :: ierr
    logical :: is_laid_out
    integer(c_int64_t) :: element
    integer :: d
    element = merge(8, 4, type == ICORAY_F64)
    is_laid_out = .true.
    do d = 1, v%rank
      array%extent(d) = v%extent(d)
      array%stride(d) = v%bytes(d)/element
      if (array%stride(d)*element == v%bytes(d)) cycle
      call refuse(ctx, of_call, name, ICORAY_ERR_ARGUMENT, 'dimension '//decimal(int(d, c_int64_t)) &
        //' steps by '//decimal(v%bytes(d))//' bytes, expected a multiple of '//decimal(element), ierr)
      is_laid_out = .false.
      return
    end do
    array%data = v%first
    array%rank = int(v%rank, c_int32_t)
    array%type = int(type, c_int32_t)
  end function is_laid_out

  subroutine heights_r4_1(ctx, values, ierr, fill_value, grid_name, layers_name, location)
    type(icoray_context), intent(in) :: ctx
    real(c_float), pointer, intent(in) :: values(:)
    integer, intent(out), optional :: ierr
    real(c_float), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    integer, intent(in), optional :: location
    real(c_double), allocatable :: fill   ! absent where it is not allocated
    if (present(fill_value)) fill = real(fill_value, c_double)
    call heights_view(ctx, view_of(values), ICORAY_F32, ierr, fill, grid_name, layers_name, location)
  end subroutine heights_r4_1

  subroutine heights_r4_2(ctx, values, ierr, fill_value, grid_name, layers_name, location)
    type(icoray_context), intent(in) :: ctx
    real(c_float), pointer, intent(in) :: values(:, :)
    integer, intent(out), optional :: ierr
    real(c_float), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    integer, intent(in), optional :: location
    real(c_double), allocatable :: fill   ! absent where it is not allocated
    if (present(fill_value)) fill = real(fill_value, c_double)
    call heights_view(ctx, view_of(values), ICORAY_F32, ierr, fill, grid_name, layers_name, location)
  end subroutine heights_r4_2

  subroutine heights_r4_3(ctx, values, ierr, fill_value, grid_name, layers_name, location)
    type(icoray_context), intent(in) :: ctx
    real(c_float), pointer, intent(in) :: values(:, :, :)
    integer, intent(out), optional :: ierr
    real(c_float), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    integer, intent(in), optional :: location
    real(c_double), allocatable :: fill   ! absent where it is not allocated
    if (present(fill_value)) fill = real(fill_value, c_double)
    call heights_view(ctx, view_of(values), ICORAY_F32, ierr, fill, grid_name, layers_name, location)
  end subroutine heights_r4_3

  subroutine heights_r4_4(ctx, values, ierr, fill_value, grid_name, layers_name, location)
    type(icoray_context), intent(in) :: ctx
    real(c_float), pointer, intent(in) :: values(:, :, :, :)
    integer, intent(out), optional :: ierr
    real(c_float), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    integer, intent(in), optional :: location
    real(c_double), allocatable :: fill   ! absent where it is not allocated
    if (present(fill_value)) fill = real(fill_value, c_double)
    call heights_view(ctx, view_of(values), ICORAY_F32, ierr, fill, grid_name, layers_name, location)
  end subroutine heights_r4_4

  subroutine heights_r8_1(ctx, values, ierr, fill_value, grid_name, layers_name, location)
    type(icoray_context), intent(in) :: ctx
    real(c_double), pointer, intent(in) :: values(:)
    integer, intent(out), optional :: ierr
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    integer, intent(in), optional :: location
    call heights_view(ctx, view_of(values), ICORAY_F64, ierr, fill_value, grid_name, layers_name, location)
  end subroutine heights_r8_1

  subroutine heights_r8_2(ctx, values, ierr, fill_value, grid_name, layers_name, location)
    type(icoray_context), intent(in) :: ctx
    real(c_double), pointer, intent(in) :: values(:, :)
    integer, intent(out), optional :: ierr
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    integer, intent(in), optional :: location
    call heights_view(ctx, view_of(values), ICORAY_F64, ierr, fill_value, grid_name, layers_name, location)
  end subroutine heights_r8_2

  subroutine heights_r8_3(ctx, values, ierr, fill_value, grid_name, layers_name, location)
    type(icoray_context), intent(in) :: ctx
    real(c_double), pointer, intent(in) :: values(:, :, :)
    integer, intent(out), optional :: ierr
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    integer, intent(in), optional :: location
    call heights_view(ctx, view_of(values), ICORAY_F64, ierr, fill_value, grid_name, layers_name, location)
  end subroutine heights_r8_3

  subroutine heights_r8_4(ctx, values, ierr, fill_value, grid_name, layers_name, location)
    type(icoray_context), intent(in) :: ctx
    real(c_double), pointer, intent(in) :: values(:, :, :, :)
    integer, intent(out), optional :: ierr
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    integer, intent(in), optional :: location
    call heights_view(ctx, view_of(values), ICORAY_F64, ierr, fill_value, grid_name, layers_name, location)
  end subroutine heights_r8_4

  subroutine heights_struct(ctx, array, ierr)
    type(icoray_context), intent(in) :: ctx
    type(icoray_array), intent(in) :: array
    integer, intent(out), optional :: ierr
    type(icoray_array), target :: sized
    sized = array
    sized%struct_size = c_sizeof(sized)
    call done(icoray_heights_set_c(ctx%handle, c_loc(sized)), ierr)
  end subroutine heights_struct
  subroutine heights_none(ctx, ierr)
    type(icoray_context), intent(in) :: ctx
    integer, intent(out), optional :: ierr
    call done(icoray_heights_set_c(ctx%handle, c_null_ptr), ierr)
  end subroutine heights_none

  !> As icoray_heights_set, for an array of up to ICORAY_MAX_RANK dimensions given by its address.
  subroutine icoray_heights_set_ndarray(ctx, array, ierr)
    type(icoray_context), intent(in) :: ctx
    type(icoray_ndarray), intent(in) :: array
    integer, intent(out), optional :: ierr
    type(icoray_ndarray), target :: sized
    sized = array
    sized%struct_size = c_sizeof(sized)
    call done(icoray_heights_set_ndarray_c(ctx%handle, c_loc(sized)), ierr)
  end subroutine icoray_heights_set_ndarray

  subroutine heights_view(ctx, v, type, ierr, fill_value, grid_name, layers_name, location)
    type(icoray_context), intent(in) :: ctx
    type(view), intent(in) :: v
    integer, intent(in) :: type
    integer, intent(out), optional :: ierr
    real(c_double), intent(in), optional :: fill_value
    character(len=*), intent(in), optional :: grid_name, layers_name
    integer, intent(in), optional :: location
    type(icoray_ndarray) :: array
    character(kind=c_char), allocatable, target :: grid(:), layers(:)
    if (.not. is_laid_out(array, ctx, 'icoray_heights_set', '', v, type, ierr)) return
    call put(array%location, location)
    if (present(fill_value)) then
      array%has_fill = 1
      array%fill_value = fill_value
    end if
    call put_name(array%grid_name, grid, grid_name)
    call put_name(array%layers_name, layers, layers_name)
    call icoray_heights_set_ndarray(ctx, array, ierr)
  end subroutine heights_view

  !> Loads the scene, one picture or several views, from a TOML file (ICORAY_ERR_IO, ICORAY_ERR_SCENE); on failure the
  !> previous scene, if any, stays in effect. A view that names a field alone has the colours, opacities and camera that
  !> suit the first values that it shows, and keeps them. Collective over the ranks of icoray_open: rank 0 reads its file
  !> and sends the text to the others, whose paths are not read.
  subroutine icoray_scene_load(ctx, path, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: path
    integer, intent(out), optional :: ierr
    call done(icoray_scene_load_c(ctx%handle, c_text(path)), ierr)
  end subroutine icoray_scene_load

  !> Loads the scene from TOML text with lines that end in new_line('a'); text that has only comments draws nothing.
  !> Collective over the ranks of icoray_open, which all use the text of rank 0.
  subroutine icoray_scene_text(ctx, toml, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: toml
    integer, intent(out), optional :: ierr
    call done(icoray_scene_text_c(ctx%handle, c_text(toml)), ierr)
  end subroutine icoray_scene_text

  !> Returns the name of one of the model's fields that the scene reads, of all pictures and conditions at any step,
  !> number index from 1, or blanks past the last one: for models that must request fields before the first step.
  subroutine icoray_scene_field(ctx, index, name, ierr)
    type(icoray_context), intent(in) :: ctx
    integer, intent(in) :: index
    character(len=*), intent(out) :: name
    integer, intent(out), optional :: ierr
    character(kind=c_char) :: buffer(len(name) + 1)
    integer(c_int32_t) :: status
    integer :: i
    buffer(1) = c_null_char
    status = icoray_scene_field_c(ctx%handle, int(index, c_int64_t) - 1, buffer, int(size(buffer), c_size_t))
    name = ''
    do i = 1, len(name)
      if (buffer(i) == c_null_char) exit
      name(i:i) = buffer(i)
    end do
    if (present(ierr)) ierr = int(status)
  end subroutine icoray_scene_field

  subroutine wants_i8(ctx, step, time_s, wants, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int64_t), intent(in) :: step
    real(c_double), intent(in) :: time_s
    logical, intent(out) :: wants
    integer, intent(out), optional :: ierr
    integer(c_int32_t) :: yes, status
    status = icoray_wants_c(ctx%handle, step, time_s, yes)
    wants = yes /= 0
    call done(status, ierr)
  end subroutine wants_i8

  subroutine wants_i4(ctx, step, time_s, wants, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t), intent(in) :: step
    real(c_double), intent(in) :: time_s
    logical, intent(out) :: wants
    integer, intent(out), optional :: ierr
    call wants_i8(ctx, int(step, c_int64_t), time_s, wants, ierr)
  end subroutine wants_i4

  subroutine wants_i4_r4(ctx, step, time_s, wants, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t), intent(in) :: step
    real(c_float), intent(in) :: time_s
    logical, intent(out) :: wants
    integer, intent(out), optional :: ierr
    call wants_i8(ctx, int(step, c_int64_t), real(time_s, c_double), wants, ierr)
  end subroutine wants_i4_r4

  subroutine wants_i8_r4(ctx, step, time_s, wants, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int64_t), intent(in) :: step
    real(c_float), intent(in) :: time_s
    logical, intent(out) :: wants
    integer, intent(out), optional :: ierr
    call wants_i8(ctx, int(step, c_int64_t), real(time_s, c_double), wants, ierr)
  end subroutine wants_i8_r4

  subroutine wants_field_i8(ctx, name, step, time_s, wants, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    integer(c_int64_t), intent(in) :: step
    real(c_double), intent(in) :: time_s
    logical, intent(out) :: wants
    integer, intent(out), optional :: ierr
    integer(c_int32_t) :: yes, status
    status = icoray_wants_field_c(ctx%handle, c_text(name), step, time_s, yes)
    wants = yes /= 0
    call done(status, ierr)
  end subroutine wants_field_i8

  subroutine wants_field_i4(ctx, name, step, time_s, wants, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    integer(c_int32_t), intent(in) :: step
    real(c_double), intent(in) :: time_s
    logical, intent(out) :: wants
    integer, intent(out), optional :: ierr
    call wants_field_i8(ctx, name, int(step, c_int64_t), time_s, wants, ierr)
  end subroutine wants_field_i4

  subroutine wants_field_i4_r4(ctx, name, step, time_s, wants, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    integer(c_int32_t), intent(in) :: step
    real(c_float), intent(in) :: time_s
    logical, intent(out) :: wants
    integer, intent(out), optional :: ierr
    call wants_field_i8(ctx, name, int(step, c_int64_t), real(time_s, c_double), wants, ierr)
  end subroutine wants_field_i4_r4

  subroutine wants_field_i8_r4(ctx, name, step, time_s, wants, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: name
    integer(c_int64_t), intent(in) :: step
    real(c_float), intent(in) :: time_s
    logical, intent(out) :: wants
    integer, intent(out), optional :: ierr
    call wants_field_i8(ctx, name, int(step, c_int64_t), real(time_s, c_double), wants, ierr)
  end subroutine wants_field_i8_r4

  subroutine execute_i8(ctx, step, time_s, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int64_t), intent(in) :: step
    real(c_double), intent(in) :: time_s
    integer, intent(out), optional :: ierr
    call done(icoray_execute_c(ctx%handle, step, time_s, c_null_ptr), ierr)
  end subroutine execute_i8

  subroutine execute_i4(ctx, step, time_s, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t), intent(in) :: step
    real(c_double), intent(in) :: time_s
    integer, intent(out), optional :: ierr
    call execute_i8(ctx, int(step, c_int64_t), time_s, ierr)
  end subroutine execute_i4

  subroutine execute_i4_r4(ctx, step, time_s, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t), intent(in) :: step
    real(c_float), intent(in) :: time_s
    integer, intent(out), optional :: ierr
    call execute_i8(ctx, int(step, c_int64_t), real(time_s, c_double), ierr)
  end subroutine execute_i4_r4

  subroutine execute_i8_r4(ctx, step, time_s, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int64_t), intent(in) :: step
    real(c_float), intent(in) :: time_s
    integer, intent(out), optional :: ierr
    call execute_i8(ctx, int(step, c_int64_t), real(time_s, c_double), ierr)
  end subroutine execute_i8_r4

  subroutine execute_date_i8(ctx, step, time_s, date, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int64_t), intent(in) :: step
    real(c_double), intent(in) :: time_s
    character(len=*), intent(in) :: date
    integer, intent(out), optional :: ierr
    character(kind=c_char), target :: text(len_trim(date) + 1)
    text = c_text(date)
    call done(icoray_execute_c(ctx%handle, step, time_s, c_loc(text)), ierr)
  end subroutine execute_date_i8

  subroutine execute_date_i4(ctx, step, time_s, date, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t), intent(in) :: step
    real(c_double), intent(in) :: time_s
    character(len=*), intent(in) :: date
    integer, intent(out), optional :: ierr
    call execute_date_i8(ctx, int(step, c_int64_t), time_s, date, ierr)
  end subroutine execute_date_i4

  subroutine execute_date_i4_r4(ctx, step, time_s, date, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t), intent(in) :: step
    real(c_float), intent(in) :: time_s
    character(len=*), intent(in) :: date
    integer, intent(out), optional :: ierr
    call execute_date_i8(ctx, int(step, c_int64_t), real(time_s, c_double), date, ierr)
  end subroutine execute_date_i4_r4

  subroutine execute_date_i8_r4(ctx, step, time_s, date, ierr)
    type(icoray_context), intent(in) :: ctx
    integer(c_int64_t), intent(in) :: step
    real(c_float), intent(in) :: time_s
    character(len=*), intent(in) :: date
    integer, intent(out), optional :: ierr
    call execute_date_i8(ctx, int(step, c_int64_t), real(time_s, c_double), date, ierr)
  end subroutine execute_date_i8_r4

  !> Waits until all frames are on disk; ierr is that of the first failed frame that no call has returned yet.
  subroutine icoray_wait(ctx, ierr)
    type(icoray_context), intent(in) :: ctx
    integer, intent(out), optional :: ierr
    call done(icoray_wait_c(ctx%handle), ierr)
  end subroutine icoray_wait

  !> Returns cost and error of the last rendered frame; ICORAY_ERR_ORDER before the first one.
  subroutine icoray_report(ctx, report, ierr)
    type(icoray_context), intent(in) :: ctx
    type(icoray_frame_report), intent(out) :: report
    integer, intent(out), optional :: ierr
    report%struct_size = c_sizeof(report)
    call done(icoray_report_c(ctx%handle, report), ierr)
  end subroutine icoray_report

  !> Ends a call with its status.
  subroutine done(status, ierr)
    integer(c_int32_t), intent(in) :: status
    integer, intent(out), optional :: ierr
    if (present(ierr)) ierr = int(status)
  end subroutine done

  !> Ends a call with an error found by this module, which the library keeps and logs as its own.
  subroutine refuse(ctx, of_call, name, status, message, ierr)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: of_call, name
    integer, intent(in) :: status
    character(len=*), intent(in) :: message
    integer, intent(out), optional :: ierr
    call done(icoray_refuse_c(ctx%handle, c_text(of_call), c_text(name), int(status, c_int32_t), c_text(message)), ierr)
  end subroutine refuse

  !> A name that may be absent, which is the empty one.
  function given_name(name) result(given)
    character(len=*), intent(in), optional :: name
    character(len=:), allocatable :: given
    given = ''
    if (present(name)) given = trim(name)
  end function given_name

  !> Sets a member if the number is present.
  subroutine put(member, number)
    integer(c_int32_t), intent(inout) :: member
    integer, intent(in), optional :: number
    if (present(number)) member = int(number, c_int32_t)
  end subroutine put

  !> Sets a member to a name, which is kept in text, if present.
  subroutine put_name(member, text, name)
    type(c_ptr), intent(inout) :: member
    character(kind=c_char), allocatable, target, intent(out) :: text(:)
    character(len=*), intent(in), optional :: name
    if (.not. present(name)) return
    text = c_text(name)
    member = c_loc(text)
  end subroutine put_name

  pure function c_text(text) result(characters)
    character(len=*), intent(in) :: text
    character(kind=c_char) :: characters(len_trim(text) + 1)
    integer :: i
    do i = 1, len_trim(text)
      characters(i) = text(i:i)
    end do
    characters(len_trim(text) + 1) = c_null_char
  end function c_text

  function f_text(characters) result(text)
    type(c_ptr), intent(in) :: characters
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: each(:)
    integer :: i
    call c_f_pointer(characters, each, [c_strlen(characters)])
    allocate (character(len=size(each)) :: text)
    do i = 1, size(each)
      text(i:i) = each(i)
    end do
  end function f_text

  pure function decimal(number) result(text)
    integer(c_int64_t), intent(in) :: number
    character(len=:), allocatable :: text
    character(len=20) :: wide
    write (wide, '(i0)') number
    text = trim(wide)
  end function decimal

  !> Starts the view of an associated array: l and u become the first and, if there is one, the second index of each
  !> dimension. Returns whether there are elements.
  function has_elements(v, lower, upper, l, u) result(some)
    type(view), intent(inout) :: v
    integer(c_int64_t), intent(in) :: lower(:), upper(:)
    integer(c_int64_t), intent(out) :: l(:), u(:)
    logical :: some
    v%is_set = .true.
    v%extent(:size(lower)) = upper - lower + 1
    some = all(upper >= lower)
    l = lower
    u = min(lower + 1, upper)
  end function has_elements

  !> Ends a view, given the first element and the second element along each dimension.
  subroutine locate(v, elements)
    type(view), intent(inout) :: v
    type(c_ptr), intent(in) :: elements(:)
    integer :: d
    v%first = elements(1)
    do d = 1, size(elements) - 1
      v%bytes(d) = int(transfer(elements(d + 1), 0_c_intptr_t) - transfer(elements(1), 0_c_intptr_t), c_int64_t)
    end do
  end subroutine locate

  function view_r4_1(p) result(v)
    real(c_float), pointer, intent(in) :: p(:)
    type(view) :: v
    integer(c_int64_t) :: l(1), u(1)
    v%rank = 1
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1))), &
      c_loc(p(u(1)))])
  end function view_r4_1

  function view_r4_2(p) result(v)
    real(c_float), pointer, intent(in) :: p(:, :)
    type(view) :: v
    integer(c_int64_t) :: l(2), u(2)
    v%rank = 2
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1), l(2))), &
      c_loc(p(u(1), l(2))), &
      c_loc(p(l(1), u(2)))])
  end function view_r4_2

  function view_r4_3(p) result(v)
    real(c_float), pointer, intent(in) :: p(:, :, :)
    type(view) :: v
    integer(c_int64_t) :: l(3), u(3)
    v%rank = 3
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1), l(2), l(3))), &
      c_loc(p(u(1), l(2), l(3))), &
      c_loc(p(l(1), u(2), l(3))), &
      c_loc(p(l(1), l(2), u(3)))])
  end function view_r4_3

  function view_r4_4(p) result(v)
    real(c_float), pointer, intent(in) :: p(:, :, :, :)
    type(view) :: v
    integer(c_int64_t) :: l(4), u(4)
    v%rank = 4
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1), l(2), l(3), l(4))), &
      c_loc(p(u(1), l(2), l(3), l(4))), &
      c_loc(p(l(1), u(2), l(3), l(4))), &
      c_loc(p(l(1), l(2), u(3), l(4))), &
      c_loc(p(l(1), l(2), l(3), u(4)))])
  end function view_r4_4

  function view_r8_1(p) result(v)
    real(c_double), pointer, intent(in) :: p(:)
    type(view) :: v
    integer(c_int64_t) :: l(1), u(1)
    v%rank = 1
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1))), &
      c_loc(p(u(1)))])
  end function view_r8_1

  function view_r8_2(p) result(v)
    real(c_double), pointer, intent(in) :: p(:, :)
    type(view) :: v
    integer(c_int64_t) :: l(2), u(2)
    v%rank = 2
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1), l(2))), &
      c_loc(p(u(1), l(2))), &
      c_loc(p(l(1), u(2)))])
  end function view_r8_2

  function view_r8_3(p) result(v)
    real(c_double), pointer, intent(in) :: p(:, :, :)
    type(view) :: v
    integer(c_int64_t) :: l(3), u(3)
    v%rank = 3
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1), l(2), l(3))), &
      c_loc(p(u(1), l(2), l(3))), &
      c_loc(p(l(1), u(2), l(3))), &
      c_loc(p(l(1), l(2), u(3)))])
  end function view_r8_3

  function view_r8_4(p) result(v)
    real(c_double), pointer, intent(in) :: p(:, :, :, :)
    type(view) :: v
    integer(c_int64_t) :: l(4), u(4)
    v%rank = 4
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1), l(2), l(3), l(4))), &
      c_loc(p(u(1), l(2), l(3), l(4))), &
      c_loc(p(l(1), u(2), l(3), l(4))), &
      c_loc(p(l(1), l(2), u(3), l(4))), &
      c_loc(p(l(1), l(2), l(3), u(4)))])
  end function view_r8_4

  function view_i4_1(p) result(v)
    integer(c_int32_t), pointer, intent(in) :: p(:)
    type(view) :: v
    integer(c_int64_t) :: l(1), u(1)
    v%rank = 1
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1))), &
      c_loc(p(u(1)))])
  end function view_i4_1

  function view_i4_2(p) result(v)
    integer(c_int32_t), pointer, intent(in) :: p(:, :)
    type(view) :: v
    integer(c_int64_t) :: l(2), u(2)
    v%rank = 2
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1), l(2))), &
      c_loc(p(u(1), l(2))), &
      c_loc(p(l(1), u(2)))])
  end function view_i4_2

  function view_i8_1(p) result(v)
    integer(c_int64_t), pointer, intent(in) :: p(:)
    type(view) :: v
    integer(c_int64_t) :: l(1), u(1)
    v%rank = 1
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1))), &
      c_loc(p(u(1)))])
  end function view_i8_1

  function view_i8_2(p) result(v)
    integer(c_int64_t), pointer, intent(in) :: p(:, :)
    type(view) :: v
    integer(c_int64_t) :: l(2), u(2)
    v%rank = 2
    if (.not. associated(p)) return
    if (.not. has_elements(v, lbound(p, kind=c_int64_t), ubound(p, kind=c_int64_t), l, u)) return
    call locate(v, [ &
      c_loc(p(l(1), l(2))), &
      c_loc(p(u(1), l(2))), &
      c_loc(p(l(1), u(2)))])
  end function view_i8_2

end module icoray
