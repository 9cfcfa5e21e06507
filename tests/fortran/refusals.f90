!> Wrong calls are refused with a status and a message that has the number; the program continues.
module refusals
  use icoray
  use check
  use model
  use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64
  implicit none
  private
  public :: refuse_all
  integer :: lines = 0, level_seen = 0
  character(len=200) :: line_seen = ''

contains

  subroutine refuse_all()
    type(icoray_context) :: ctx
    call not_open()
    call opening()
    ctx = opened('refusals')
    call grid_tables(ctx)
    call fields(ctx)
    call heights(ctx)
    call scenes(ctx)
    call icoray_close(ctx)
    call orders()
    call in_the_background()
  end subroutine refuse_all

  subroutine take_log(level, message)
    integer, intent(in) :: level
    character(len=*), intent(in) :: message
    lines = lines + 1
    level_seen = level
    line_seen = message
  end subroutine take_log

  !> Every call on a context that is not open, with ierr and without.
  subroutine not_open()
    type(icoray_context) :: ctx
    type(icoray_mesh) :: none
    type(icoray_frame_report) :: report
    real(real32), allocatable, target :: values(:, :)
    character(len=80) :: message
    logical :: wants
    integer :: ierr
    values = at_centers
    call icoray_scene_text(ctx, '')
    call icoray_scene_load(ctx, 'nowhere')
    call icoray_wait(ctx)
    call icoray_layers_set(ctx, radius, planet)
    call icoray_grid_set(ctx, mesh)
    call icoray_field_set(ctx, 'f', values)
    call icoray_execute(ctx, 1, 0.0_real64)
    call icoray_execute(ctx, 1_int64, 0.0_real64, '2026-01-01_00:00:00')
    call icoray_report(ctx, report)
    call icoray_close(ctx)
    wants = .true.
    call icoray_wants(ctx, 1_int64, 0.0_real64, wants, ierr)
    call expect(ierr == ICORAY_ERR_NULL .and. .not. wants, 'wants of no context')
    wants = .true.
    call icoray_wants_field(ctx, 'f', 1, 0.0_real64, wants, ierr)
    call expect(ierr == ICORAY_ERR_NULL .and. .not. wants, 'wants_field of no context')
    call icoray_execute(ctx, 1, 0.0_real64, ierr)
    call refused(ctx, ierr, ICORAY_ERR_NULL, 'ctx is NULL')
    call icoray_field_set(ctx, 'f', values, ierr)
    call refused(ctx, ierr, ICORAY_ERR_NULL, 'ctx is NULL')
    associate (t => tables)
      call icoray_grid_set(ctx, t%lon_center, t%lat_center, t%lon_corner, t%lat_corner, t%cell_corner, t%corner_cell, &
        t%corner_edge, t%edge_corner, ierr, index_base=0)
    end associate
    call refused(ctx, ierr, ICORAY_ERR_NULL, 'ctx is NULL')
    call icoray_close(ctx, ierr)
    call expect(ierr == ICORAY_OK, 'closing no context')
    call icoray_mesh_create(-3, none, ierr)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '-3')
    call icoray_mesh_create(77, none)
    call icoray_last_error(message, ierr)
    call expect(ierr == ICORAY_OK .and. index(message, '77') > 0, 'without ctx')
    call icoray_last_error(message(:5))
    call expect(message(:5) == 'ICORA' .or. len_trim(message(:5)) > 0, 'a short message')
  end subroutine not_open

  subroutine opening()
    type(icoray_context) :: ctx
    type(icoray_config) :: config
    integer :: ierr
    character(len=80) :: message
    call icoray_open_serial(ctx, ierr, threads=-4)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '-4')
    call icoray_open_serial(ctx, ierr, existing=71)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '71')
    call icoray_open_serial(ctx, ierr, on_error=72)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '72')
    call icoray_open_serial(ctx, ierr, disable_after=-73)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '73')
    call icoray_open_serial(ctx, ierr, writer_queue=7400)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '7400')
    call icoray_open_serial(ctx, ierr, when_full=75)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '75')
    call icoray_open_serial(ctx, ierr, log_level=76, log=take_log)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '76')
    config%threads = -5
    call icoray_open_serial(ctx, config, ierr)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '-5')
    config%threads = 1
    call icoray_open_serial(ctx, config, ierr)
    call went_well(ctx, ierr, 'open with a struct')
    call icoray_open_serial(ctx, ierr)
    call refused(ctx, ierr, ICORAY_ERR_ORDER, 'open already')
    call icoray_scene_text(ctx, 'nonsense', ierr)
    call icoray_last_error(ctx, message)
    call expect(ierr == ICORAY_ERR_SCENE .and. index(message, 'open already') == 0, 'the later message')
    call icoray_close(ctx)
  end subroutine opening

  subroutine grid_tables(ctx)
    type(icoray_context), intent(in) :: ctx
    real(real64), allocatable, target :: lon(:), lat(:)
    real(real64), pointer :: unset(:)
    integer(int32), allocatable, target :: cv(:, :), cc(:, :), ce(:, :), ev(:, :), few(:), from_1(:, :)
    character(len=12) :: count, fewer
    integer :: ierr
    lon = tables%lon_center
    lat = [tables%lat_center, tables%lat_center]
    cv = tables%cell_corner
    cc = transpose(tables%corner_cell)
    ce = tables%corner_edge
    ev = tables%edge_corner
    few = [6_int32, 6_int32]
    write (count, '(i0)') cells
    write (fewer, '(i0)') cells - 1
    associate (t => tables)
      call icoray_grid_set(ctx, lon, lat(2::2), t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr, 0)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'lat_center: not contiguous, dimension 1 steps by 16 bytes, expected 8')
      call icoray_grid_set(ctx, lon, lon, t%lon_corner, t%lat_corner, cv(6:1:-1, :), t%corner_cell, ce, ev, ierr, 0)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'cell_corner: not contiguous, dimension 1 steps by -4 bytes')
      call icoray_grid_set(ctx, lon, lon, t%lon_corner, t%lat_corner, cv(:5, :), t%corner_cell, ce, ev, ierr, 0)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'cell_corner: not contiguous, dimension 2 steps by 24 bytes, expected 20')
      call icoray_points_set(ctx, lon, lon(:cells - 1), ierr)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'as of lon')
      call icoray_points_set(ctx, lon(:2), lon(:2), ierr, name='two')
      call refused(ctx, ierr, ICORAY_ERR_GRID, 'the 2 points span no area')
      call icoray_grid_set(ctx, lon, lon, t%lon_corner, t%lat_corner, cv, cc, ce, ev, ierr, 0)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'corner_cell: columns of ')
      call icoray_grid_set(ctx, lon, lon(:cells - 1), t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr, 0)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'lat_center: '//trim(fewer)//' entries or columns, expected at least ' &
        //trim(count))
      call icoray_grid_set(ctx, lon, lon, t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr, 0, few)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'cell_corner_count: 2 entries or columns, expected at least '//trim(count))
      call icoray_grid_set(ctx, lon, lon, t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr, 0, cells=777777)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '777777')
      call icoray_grid_set(ctx, lon, lon, t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr, 0, edges=-8)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '-8')
      call icoray_grid_set(ctx, lon, lon, t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr, 7)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '7')
      ! Numbered from 0, said to begin at 1.
      call icoray_grid_set(ctx, t%lon_center, t%lat_center, t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr)
      call expect(ierr == ICORAY_ERR_GRID, 'the wrong index base')
      ! Places in tables that count from 1 are written as Fortran writes them.
      from_1 = t%corner_cell + 1_int32
      from_1(2, 5) = 99999_int32
      cv = cv + 1_int32
      ce = ce + 1_int32
      ev = ev + 1_int32
      call icoray_grid_set(ctx, lon, t%lat_center, t%lon_corner, t%lat_corner, cv, from_1, ce, ev, ierr)
      call refused(ctx, ierr, ICORAY_ERR_GRID, 'corner_cell(2, 5) (MPAS cellsOnVertex, ICON vertex_of_cell): 99999, expected 1 to ')
      unset => null()
      call icoray_grid_set(ctx, unset, lon, t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr, 0)
      call refused(ctx, ierr, ICORAY_ERR_NULL, 'lon_center is not associated')
      call icoray_grid_set(ctx, lon, unset, t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr, 0)
      call refused(ctx, ierr, ICORAY_ERR_NULL, 'lat_center is not associated')
      call icoray_grid_set(ctx, lon(:0), lon(:0), lon(:0), lon(:0), cv(:, :0), t%corner_cell(:, :0), ce(:, :0), ev(:, :0), &
        ierr, 0)
      call refused(ctx, ierr, ICORAY_ERR_GRID, '0 cells, expected at least 1')
      call icoray_grid_set(ctx, lon, lon(:0), t%lon_corner, t%lat_corner, cv, t%corner_cell, ce, ev, ierr, 0)
      call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'lat_center: 0 entries')
    end associate
  end subroutine grid_tables

  subroutine fields(ctx)
    type(icoray_context), intent(in) :: ctx
    real(real32), allocatable, target :: values(:, :), wrong(:, :), empty(:, :), three(:, :, :), corners(:, :)
    real(real64), pointer :: unset(:, :)
    integer :: ierr
    values = at_centers
    allocate (wrong(nz + 3, cells), three(2, nz, 5), source=0.0_real32)
    allocate (empty(nz, 0))
    unset => null()
    call icoray_layers_set(ctx, [radius(1)], planet, ierr)
    call expect(ierr == ICORAY_ERR_LAYERS, 'one radius')
    call icoray_layers_set(ctx, [real(real64) ::], planet, ierr)
    call expect(ierr == ICORAY_ERR_LAYERS, 'no radius')
    call icoray_field_set(ctx, 'f', wrong, ierr)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, '7')
    call icoray_field_set(ctx, 'f', empty, ierr)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, '0')
    call icoray_field_set(ctx, 'f', unset, ierr)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, '0')
    call icoray_field_set(ctx, 'f', three, ierr)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, '5')
    call icoray_field_set(ctx, 'f', values, ierr, location=ICORAY_CORNER)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, 'field "f"')
    allocate (corners(nz, size(tables%lon_corner) + 1), source=0.0_real32)
    call icoray_field_set(ctx, 'f', corners(:, :size(tables%lon_corner)), ierr)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, 'columns are the grid''s corners: set location = ICORAY_CORNER')
    call icoray_field_set(ctx, 'f', corners, ierr)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, 'columns are the grid''s corners: set location = ICORAY_CORNER')
    call icoray_field_set(ctx, 'f', corners, ierr, location=ICORAY_CORNER)
    call went_well(ctx, ierr, 'corners and one more')
    call icoray_field_set(ctx, 'f', values, ierr, location=9)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '9')
    call icoray_field_set(ctx, 'f', values, ierr, grid_name='other')
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'other')
    call icoray_field_set(ctx, 'f', values, ierr, layers_name='others')
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'others')
    call icoray_field_set(ctx, 'f', values, ierr, grid_name='', layers_name='')
    call went_well(ctx, ierr, 'empty names are those without a name')
  end subroutine fields

  subroutine heights(ctx)
    type(icoray_context), intent(in) :: ctx
    type(icoray_context) :: none
    type(icoray_array) :: array
    real(real32), allocatable, target :: values(:, :), wrong(:, :), line(:), blocks(:, :, :), four(:, :, :, :)
    real(real64), allocatable, target :: line8(:), values8(:, :), blocks8(:, :, :), four8(:, :, :, :)
    real(real32), allocatable, target :: triangles(:, :)
    real(real64), allocatable, target :: triangles8(:, :)
    real(real64), pointer :: unset(:, :)
    integer :: ierr
    values = at_centers
    values8 = at_centers
    line = reshape(values, [nz*cells])
    line8 = line
    allocate (wrong(nz + 3, cells), blocks(cells, nz, 1), four(1, nz, 1, cells), source=0.0_real32)
    allocate (blocks8(cells, nz, 1), four8(1, nz, 1, cells), triangles8(2*cells - 4, nz), source=0.0_real64)
    allocate (triangles(nz, 2*cells - 4), source=0.0_real32)
    unset => null()
    call icoray_heights_set(ctx, wrong, ierr)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, 'heights: ')
    call icoray_heights_set(ctx, unset, ierr)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, 'heights: ')
    call icoray_heights_set(ctx, values, ierr, layers_name='others')
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'heights: no set of layers named "others"')
    call icoray_heights_set(none, values, ierr)
    call refused(none, ierr, ICORAY_ERR_NULL, 'ctx is NULL')
    call icoray_heights_set(none, ierr)
    call refused(none, ierr, ICORAY_ERR_NULL, 'ctx is NULL')
    array%location = 7
    call icoray_heights_set(ctx, array, ierr)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'heights: icoray_array.location: 7')
    call icoray_heights_set(ctx, values, ierr, location=ICORAY_CORNER)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, 'columns are the grid''s cells: set location = ICORAY_CENTER')
    call icoray_heights_set(ctx, triangles, ierr)
    call refused(ctx, ierr, ICORAY_ERR_FIELD, 'columns are the grid''s corners: set location = ICORAY_CORNER')
    call icoray_heights_set(ctx, triangles, ierr, location=ICORAY_CORNER)
    call went_well(ctx, ierr, 'heights of layers and corners')
    call icoray_heights_set(ctx, triangles8, ierr, fill_value=-1e30_real64, location=ICORAY_CORNER)
    call went_well(ctx, ierr, 'heights of corners and layers, 64 bits')
    call icoray_heights_set(ctx, line, ierr)
    call went_well(ctx, ierr, 'heights in a line')
    call icoray_heights_set(ctx, line8, ierr, fill_value=-1e30_real64)
    call went_well(ctx, ierr, 'heights in a line, 64 bits')
    call icoray_heights_set(ctx, values, ierr, fill_value=-1e30_real32, grid_name='', layers_name='')
    call went_well(ctx, ierr, 'heights of layers and cells')
    call icoray_heights_set(ctx, values8(nz:1:-1, :), ierr)
    call went_well(ctx, ierr, 'heights of layers and cells, 64 bits')
    call icoray_heights_set(ctx, blocks, ierr)
    call went_well(ctx, ierr, 'heights in blocks')
    call icoray_heights_set(ctx, blocks8, ierr)
    call went_well(ctx, ierr, 'heights in blocks, 64 bits')
    call icoray_heights_set(ctx, four, ierr)
    call went_well(ctx, ierr, 'heights of four dimensions')
    call icoray_heights_set(ctx, four8, ierr)
    call went_well(ctx, ierr, 'heights of four dimensions, 64 bits')
    call icoray_heights_set(ctx, ierr)
    call went_well(ctx, ierr, 'heights taken back')
    call icoray_heights_set(ctx)
  end subroutine heights

  subroutine scenes(ctx)
    type(icoray_context), intent(in) :: ctx
    logical :: wants
    integer :: ierr
    call icoray_scene_load(ctx, 'no/such/scene.toml   ', ierr)
    call refused(ctx, ierr, ICORAY_ERR_IO, 'no/such/scene.toml: ')
    call icoray_scene_text(ctx, base_scene('x')//'every = 3'//new_line('a'), ierr)
    call refused(ctx, ierr, ICORAY_ERR_SCENE, 'every')
    call icoray_scene_text(ctx, 'every = 3'//new_line('a')//base_scene('x'), ierr)
    call went_well(ctx, ierr, 'every third step')
    call icoray_wants(ctx, 4, 0.0_real64, wants, ierr)
    call expect(ierr == ICORAY_OK .and. .not. wants, 'step 4 of every third')
    call icoray_wants_field(ctx, 'f', 6_int64, 0.0_real64, wants, ierr)
    call expect(ierr == ICORAY_OK .and. wants, 'step 6 of every third')
    call icoray_wants_field(ctx, 'g', 6, 0.0_real64, wants, ierr)
    call expect(ierr == ICORAY_OK .and. .not. wants, 'another field')
    ! Times of 32 bits.
    call icoray_wants(ctx, 6, 0.0_real32, wants, ierr)
    call expect(ierr == ICORAY_OK .and. wants, 'a time of 32 bits')
    call icoray_wants(ctx, 4_int64, 0.0_real32, wants)
    call expect(.not. wants, 'a time of 32 bits, a step of 64')
    call icoray_wants_field(ctx, 'f', 6, 0.0_real32, wants)
    call expect(wants, 'a field at a time of 32 bits')
    call icoray_wants_field(ctx, 'f', 4_int64, 0.0_real32, wants, ierr)
    call expect(ierr == ICORAY_OK .and. .not. wants, 'a field at a time of 32 bits, a step of 64')
    call icoray_wants(ctx, 6, ieee_value(1.0_real32, ieee_quiet_nan), wants, ierr)
    call expect(ierr == ICORAY_ERR_ARGUMENT .and. wants, 'no time: the step decides')
    call icoray_execute(ctx, 6, ieee_value(1.0_real32, ieee_positive_inf), ierr)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'time_s')
    call icoray_execute(ctx, 6_int64, ieee_value(1.0_real32, ieee_positive_inf), '2026-11-22_00:00:00', ierr)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'time_s')
    call icoray_execute(ctx, 4, 240.0_real32, '2026-11-22_00:00:00', ierr)
    call went_well(ctx, ierr, 'a step that is not drawn, with a date')
    call icoray_execute(ctx, 5_int64, 300.0_real32, ierr)
    call went_well(ctx, ierr, 'a step that is not drawn')
    call icoray_execute(ctx, 6, ieee_value(1.0_real64, ieee_positive_inf), ierr)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'time_s')
  end subroutine scenes

  !> Calls before what they need; the log.
  subroutine orders()
    type(icoray_context) :: ctx
    type(icoray_frame_report) :: report
    real(real32), allocatable, target :: values(:, :)
    real(real64), allocatable, target :: lon(:)
    integer :: ierr
    values = at_centers
    call icoray_open_serial(ctx, ierr, output_dir=directory//'/orders', threads=1, on_error=ICORAY_WARN, log=take_log)
    call went_well(ctx, ierr, 'open with a log')
    call icoray_field_set(ctx, 'f', values, ierr)
    call refused(ctx, ierr, ICORAY_ERR_ORDER, 'icoray_grid_set')
    call icoray_report(ctx, report, ierr)
    call expect(ierr == ICORAY_ERR_ORDER, 'report of no frame')
    call icoray_execute(ctx, 1_int64, 0.0_real64, ierr)
    call refused(ctx, ierr, ICORAY_ERR_ORDER, 'scene')
    call icoray_scene_text(ctx, base_scene('x'))
    lines = 0
    call icoray_execute(ctx, 1, 0.0_real64)
    call refused(ctx, ICORAY_OK, ICORAY_OK, 'icoray_grid_set')
    call expect(lines == 1 .and. level_seen == ICORAY_LOG_WARN .and. index(line_seen, 'icoray_grid_set') > 0, 'the log')
    ! Refusals of this module are logged, and stored by the library.
    lon = [tables%lon_center, tables%lon_center]
    associate (t => tables)
      call icoray_grid_set(ctx, lon(2::2), t%lat_center, t%lon_corner, t%lat_corner, t%cell_corner, t%corner_cell, &
        t%corner_edge, t%edge_corner, ierr, 0)
    end associate
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'lon_center: not contiguous')
    call expect(lines == 2 .and. index(line_seen, 'lon_center: not contiguous') > 0, 'the log of a refusal')
    call icoray_execute(ctx, 2, 0.0_real64, ierr)
    call refused(ctx, ierr, ICORAY_ERR_ORDER, 'grid was refused by icoray_grid_set: lon_center: not contiguous, dimension 1')
    call icoray_close(ctx)
  end subroutine orders

  !> A copy of the field is drawn while the model goes on.
  subroutine in_the_background()
    type(icoray_context) :: ctx
    type(icoray_frame_report) :: report
    real(real32), allocatable, target :: values(:, :)
    integer :: ierr
    values = at_centers
    call icoray_open_serial(ctx, ierr, output_dir=directory//'/background', threads=1, async_render=.true., &
      existing=ICORAY_OVERWRITE, writer_queue=1, when_full=ICORAY_BLOCK, log=take_log, log_level=ICORAY_LOG_INFO)
    call icoray_grid_set(ctx, mesh)
    call icoray_layers_set(ctx, radius, planet)
    call icoray_field_set(ctx, 'f', values)
    call icoray_scene_text(ctx, base_scene('plain'))
    lines = 0
    call icoray_execute(ctx, 200_int64, 0.0_real64, '2026-11-21_00:00:00', ierr)
    call went_well(ctx, ierr, 'in the background')
    values = garbage
    call icoray_wait(ctx, ierr)
    call went_well(ctx, ierr, 'icoray_wait')
    call icoray_report(ctx, report, ierr)
    call expect(report%bytes_copied == 4*nz*cells .and. report%frames_written == 1, 'bytes_copied of a copy')
    call icoray_close(ctx)
    call expect(lines > 0 .and. level_seen == ICORAY_LOG_INFO, 'the log of a picture')
  end subroutine in_the_background
end module refusals
