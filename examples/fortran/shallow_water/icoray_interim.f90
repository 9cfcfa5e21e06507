!> Stands in for include/icoray.f90 until it is there; to be deleted then. Only what the model uses.
module icoray
   use, intrinsic :: iso_c_binding
   use, intrinsic :: iso_fortran_env, only: int32, int64, real64
   implicit none
   private
   public :: icoray_context, icoray_mesh, icoray_grid_tables, icoray_mesh_create, icoray_mesh_tables, icoray_mesh_free, &
             icoray_open_serial, icoray_grid_set, icoray_layers_set, icoray_field_set, icoray_scene_load, icoray_execute, &
             icoray_last_error, icoray_close

   integer, parameter, public :: ICORAY_OK = 0, ICORAY_CENTER = 0, ICORAY_CORNER = 1

   type :: icoray_context
      type(c_ptr) :: handle = c_null_ptr
   end type
   type :: icoray_mesh
      type(c_ptr) :: handle = c_null_ptr
   end type
   type :: icoray_grid_tables
      integer :: index_base = 0
      real(real64), pointer :: lon_center(:) => null(), lat_center(:) => null()
      real(real64), pointer :: lon_corner(:) => null(), lat_corner(:) => null()
      integer(int32), pointer :: cell_corner(:, :) => null(), corner_cell(:, :) => null()
      integer(int32), pointer :: corner_edge(:, :) => null(), edge_corner(:, :) => null()
   end type

   type, bind(C) :: c_config
      integer(c_size_t) :: struct_size
      type(c_ptr) :: output_dir
      integer(c_int32_t) :: threads
   end type
   type, bind(C) :: c_grid
      integer(c_size_t) :: struct_size
      integer(c_int64_t) :: cells, corners, edges
      integer(c_int32_t) :: index_base, real_type
      type(c_ptr) :: lon_center, lat_center, lon_corner, lat_corner, cell_corner
      integer(c_int64_t) :: cell_corner_row
      type(c_ptr) :: cell_corner_count, corner_cell, corner_edge, edge_corner
   end type
   type, bind(C) :: c_layers
      integer(c_size_t) :: struct_size
      integer(c_int64_t) :: count
      type(c_ptr) :: radius
      real(c_double) :: planet_radius
   end type
   type, bind(C) :: c_array
      integer(c_size_t) :: struct_size
      type(c_ptr) :: data
      integer(c_int32_t) :: type, location
      integer(c_int64_t) :: columns, layers, column_stride, layer_stride
      integer(c_int32_t) :: has_fill
      real(c_double) :: fill_value
   end type

   interface
      integer(c_int32_t) function c_mesh_create(level, mesh) bind(C, name='icoray_mesh_create')
         import; integer(c_int32_t), value :: level; type(c_ptr) :: mesh
      end function
      integer(c_int32_t) function c_mesh_grid(mesh, grid) bind(C, name='icoray_mesh_grid')
         import; type(c_ptr), value :: mesh; type(c_grid) :: grid
      end function
      integer(c_int32_t) function c_mesh_free(mesh) bind(C, name='icoray_mesh_free')
         import; type(c_ptr) :: mesh
      end function
      integer(c_int32_t) function c_open(config, ctx) bind(C, name='icoray_open_serial')
         import; type(c_config) :: config; type(c_ptr) :: ctx
      end function
      integer(c_int32_t) function c_grid_set(ctx, grid) bind(C, name='icoray_grid_set')
         import; type(c_ptr), value :: ctx; type(c_grid) :: grid
      end function
      integer(c_int32_t) function c_layers_set(ctx, layers) bind(C, name='icoray_layers_set')
         import; type(c_ptr), value :: ctx; type(c_layers) :: layers
      end function
      integer(c_int32_t) function c_field_set(ctx, name, array) bind(C, name='icoray_field_set')
         import; type(c_ptr), value :: ctx; character(kind=c_char) :: name(*); type(c_array) :: array
      end function
      integer(c_int32_t) function c_scene_load(ctx, path) bind(C, name='icoray_scene_load')
         import; type(c_ptr), value :: ctx; character(kind=c_char) :: path(*)
      end function
      integer(c_int32_t) function c_execute(ctx, step, time, date) bind(C, name='icoray_execute')
         import; type(c_ptr), value :: ctx; integer(c_int64_t), value :: step; real(c_double), value :: time
         character(kind=c_char) :: date(*)
      end function
      integer(c_int32_t) function c_last_error(ctx, buf, len) bind(C, name='icoray_last_error')
         import; type(c_ptr), value :: ctx; character(kind=c_char) :: buf(*); integer(c_size_t), value :: len
      end function
      integer(c_int32_t) function c_close(ctx) bind(C, name='icoray_close')
         import; type(c_ptr) :: ctx
      end function
   end interface

contains

   subroutine icoray_mesh_create(level, mesh, ierr)
      integer, intent(in) :: level
      type(icoray_mesh), intent(inout) :: mesh
      integer, intent(out) :: ierr
      ierr = c_mesh_create(int(level, c_int32_t), mesh%handle)
   end subroutine

   subroutine icoray_mesh_tables(mesh, tables, ierr)
      type(icoray_mesh), intent(in) :: mesh
      type(icoray_grid_tables), intent(out) :: tables
      integer, intent(out) :: ierr
      type(c_grid) :: g
      g%struct_size = c_sizeof(g)
      ierr = c_mesh_grid(mesh%handle, g)
      if (ierr /= 0) return
      tables%index_base = g%index_base
      call c_f_pointer(g%lon_center, tables%lon_center, [g%cells])
      call c_f_pointer(g%lat_center, tables%lat_center, [g%cells])
      call c_f_pointer(g%lon_corner, tables%lon_corner, [g%corners])
      call c_f_pointer(g%lat_corner, tables%lat_corner, [g%corners])
      call c_f_pointer(g%cell_corner, tables%cell_corner, [g%cell_corner_row, g%cells])
      call c_f_pointer(g%corner_cell, tables%corner_cell, [3_int64, g%corners])
      call c_f_pointer(g%corner_edge, tables%corner_edge, [3_int64, g%corners])
      call c_f_pointer(g%edge_corner, tables%edge_corner, [2_int64, g%edges])
   end subroutine

   subroutine icoray_mesh_free(mesh, ierr)
      type(icoray_mesh), intent(inout) :: mesh
      integer, intent(out) :: ierr
      ierr = c_mesh_free(mesh%handle)
   end subroutine

   subroutine icoray_open_serial(ctx, output_dir, threads, ierr)
      type(icoray_context), intent(inout) :: ctx
      character(*), intent(in) :: output_dir
      integer, intent(in) :: threads
      integer, intent(out) :: ierr
      type(c_config) :: config
      character(len=:, kind=c_char), allocatable, target :: dir
      dir = output_dir//c_null_char
      config%struct_size = c_sizeof(config)
      config%output_dir = c_loc(dir)
      config%threads = threads
      ierr = c_open(config, ctx%handle)
   end subroutine

   subroutine icoray_grid_set(ctx, lon_center, lat_center, lon_corner, lat_corner, cell_corner, corner_cell, corner_edge, &
                              edge_corner, ierr, index_base)
      type(icoray_context), intent(in) :: ctx
      real(real64), intent(in), target, contiguous :: lon_center(:), lat_center(:), lon_corner(:), lat_corner(:)
      integer(int32), intent(in), target, contiguous :: cell_corner(:, :), corner_cell(:, :), corner_edge(:, :), &
                                                        edge_corner(:, :)
      integer, intent(out) :: ierr
      integer, intent(in) :: index_base
      type(c_grid) :: g
      g%struct_size = c_sizeof(g)
      g%cells = size(lon_center)
      g%corners = size(lon_corner)
      g%edges = size(edge_corner, 2)
      g%index_base = index_base
      g%real_type = 2
      g%lon_center = c_loc(lon_center)
      g%lat_center = c_loc(lat_center)
      g%lon_corner = c_loc(lon_corner)
      g%lat_corner = c_loc(lat_corner)
      g%cell_corner = c_loc(cell_corner)
      g%cell_corner_row = size(cell_corner, 1)
      g%cell_corner_count = c_null_ptr
      g%corner_cell = c_loc(corner_cell)
      g%corner_edge = c_loc(corner_edge)
      g%edge_corner = c_loc(edge_corner)
      ierr = c_grid_set(ctx%handle, g)
   end subroutine

   subroutine icoray_layers_set(ctx, radius_m, planet_radius_m, ierr)
      type(icoray_context), intent(in) :: ctx
      real(real64), intent(in), target, contiguous :: radius_m(:)
      real(real64), intent(in) :: planet_radius_m
      integer, intent(out) :: ierr
      type(c_layers) :: layers
      layers%struct_size = c_sizeof(layers)
      layers%count = size(radius_m)
      layers%radius = c_loc(radius_m)
      layers%planet_radius = planet_radius_m
      ierr = c_layers_set(ctx%handle, layers)
   end subroutine

   subroutine icoray_field_set(ctx, name, values, ierr, location)
      type(icoray_context), intent(in) :: ctx
      character(*), intent(in) :: name
      real(real64), intent(in), target, contiguous :: values(:, :)
      integer, intent(out) :: ierr
      integer, intent(in), optional :: location
      type(c_array) :: array
      array%struct_size = c_sizeof(array)
      array%data = c_loc(values)
      array%type = 2
      array%location = 0
      if (present(location)) array%location = location
      array%columns = size(values, 2)
      array%layers = size(values, 1)
      array%column_stride = size(values, 1)
      array%layer_stride = 1
      array%has_fill = 0
      array%fill_value = 0
      ierr = c_field_set(ctx%handle, name//c_null_char, array)
   end subroutine

   subroutine icoray_scene_load(ctx, path, ierr)
      type(icoray_context), intent(in) :: ctx
      character(*), intent(in) :: path
      integer, intent(out) :: ierr
      ierr = c_scene_load(ctx%handle, path//c_null_char)
   end subroutine

   subroutine icoray_execute(ctx, step, time_s, date, ierr)
      type(icoray_context), intent(in) :: ctx
      integer(int64), intent(in) :: step
      real(real64), intent(in) :: time_s
      character(*), intent(in) :: date
      integer, intent(out) :: ierr
      ierr = c_execute(ctx%handle, step, time_s, date//c_null_char)
   end subroutine

   subroutine icoray_last_error(ctx, message)
      type(icoray_context), intent(in) :: ctx
      character(*), intent(out) :: message
      character(kind=c_char) :: buffer(1024)
      integer :: i, ierr
      buffer = c_null_char
      ierr = c_last_error(ctx%handle, buffer, 1024_c_size_t)
      message = ''
      if (ierr /= 0) return
      do i = 1, min(1023, len(message))
         if (buffer(i) == c_null_char) exit
         message(i:i) = buffer(i)
      end do
   end subroutine

   subroutine icoray_close(ctx, ierr)
      type(icoray_context), intent(inout) :: ctx
      integer, intent(out) :: ierr
      ierr = c_close(ctx%handle)
   end subroutine

end module icoray
