!> Shared by the pictures: a mesh, a field on it, and contexts that draw it.
module model
  use icoray
  use check
  use, intrinsic :: iso_fortran_env, only: int64, real32, real64
  implicit none
  private
  public :: start_model, end_model, opened, frame, values_at, base_scene
  integer, parameter, public :: nz = 4
  real(real64), parameter, public :: planet = 6371220.0_real64
  real(real64), parameter, public :: radius(nz) = planet + [0.0_real64, 4e3_real64, 9e3_real64, 20e3_real64]
  !> Values beyond the grid's, which a picture must not show.
  real(real32), parameter, public :: garbage = 1e30_real32
  character(len=:), allocatable, public :: directory
  integer, public :: pixels
  type(icoray_mesh), public :: mesh
  type(icoray_grid_tables), public :: tables
  integer, public :: cells, corners, edges
  !> The field, exact in 32 bits: (layers, cells) and (layers, corners).
  real(real32), allocatable, public :: at_centers(:, :), at_corners(:, :)

contains

  subroutine start_model()
    character(len=200) :: argument(3)
    integer :: ierr, i, level
    do i = 1, 3
      call get_command_argument(i, argument(i))
    end do
    directory = trim(argument(1))
    read (argument(2), *) level
    read (argument(3), *) pixels
    call icoray_mesh_create(level, mesh, ierr)
    call expect(ierr == ICORAY_OK, 'icoray_mesh_create')
    call icoray_mesh_tables(mesh, tables, ierr)
    call expect(ierr == ICORAY_OK, 'icoray_mesh_tables')
    cells = size(tables%lon_center)
    corners = size(tables%lon_corner)
    edges = size(tables%edge_corner, 2)
    call expect(cells == 10*4**level + 2 .and. corners == 2*cells - 4 .and. edges == 3*cells - 6, 'sizes')
    call expect(all(shape(tables%cell_corner) == [6, cells]) .and. tables%index_base == 0, 'cell_corner')
    at_centers = values_at(tables%lon_center, tables%lat_center, nz)
    at_corners = values_at(tables%lon_corner, tables%lat_corner, nz)
  end subroutine start_model

  subroutine end_model()
    integer :: ierr
    call icoray_mesh_free(mesh, ierr)
    call expect(ierr == ICORAY_OK, 'icoray_mesh_free')
    call icoray_mesh_free(mesh, ierr)
    call expect(ierr == ICORAY_OK, 'icoray_mesh_free twice')
    call icoray_mesh_tables(mesh, tables, ierr)
    call expect(ierr == ICORAY_ERR_NULL .and. .not. associated(tables%lon_center), 'tables of no mesh')
  end subroutine end_model

  pure function values_at(lon, lat, layers) result(values)
    real(real64), intent(in) :: lon(:), lat(:)
    integer, intent(in) :: layers
    real(real32) :: values(layers, size(lon))
    integer :: c, k
    do c = 1, size(lon)
      do k = 1, layers
        values(k, c) = real((sin(3*lon(c) + 0.4_real64*(k - 1))*cos(lat(c)) + 0.3_real64*sin(5*lat(c))) &
          *(1 + 0.2_real64*(k - 1)), real32)
      end do
    end do
  end function values_at

  !> A context whose pictures go to directory/name, with the mesh and the radii.
  function opened(name) result(ctx)
    character(len=*), intent(in) :: name
    type(icoray_context) :: ctx
    integer :: ierr
    call icoray_open_serial(ctx, ierr, output_dir=directory//'/'//name, threads=1)
    call went_well(ctx, ierr, 'icoray_open_serial')
    call icoray_grid_set(ctx, mesh, ierr)
    call went_well(ctx, ierr, 'icoray_grid_set')
    call icoray_layers_set(ctx, radius, planet, ierr)
    call went_well(ctx, ierr, 'icoray_layers_set')
  end function opened

  !> The scene of a group.
  function base_scene(group) result(toml)
    character(len=*), intent(in) :: group
    character(len=:), allocatable :: toml
    character(len=1), parameter :: nl = new_line('a')
    character(len=12) :: size
    write (size, '(i0)') pixels
    toml = 'field = "f"'//nl//'backend = "cpu"'//nl//'exaggeration = 40'//nl &
      //'[image]'//nl//'width = '//trim(size)//nl//'height = '//trim(size)//nl &
      //'[camera]'//nl//'lon = 20'//nl//'lat = 35'//nl//'distance = 3.2'//nl//'fov = 45'//nl &
      //'[transfer]'//nl//'map = "viridis"'//nl//'range = [-1.5, 1.5]'//nl &
      //'opacity = [[-1.5, 0.8], [0, 0.1], [1.5, 0.9]]'//nl &
      //'[output]'//nl//'file = "'//group//'_{step}.png"'//nl
  end function base_scene

  !> Draws a picture of a group, of the field that was set; nothing was copied for it.
  subroutine frame(ctx, group, step)
    type(icoray_context), intent(in) :: ctx
    character(len=*), intent(in) :: group
    integer, intent(in) :: step
    type(icoray_frame_report) :: report
    integer :: ierr
    logical :: wants
    call icoray_scene_text(ctx, base_scene(group), ierr)
    call went_well(ctx, ierr, 'icoray_scene_text')
    call icoray_wants(ctx, step, 60.0_real64*step, wants, ierr)
    call expect(wants .and. ierr == ICORAY_OK, 'icoray_wants')
    call icoray_execute(ctx, step, 60.0_real64*step, ierr)
    call went_well(ctx, ierr, 'icoray_execute')
    call icoray_wait(ctx, ierr)
    call went_well(ctx, ierr, 'icoray_wait')
    call icoray_report(ctx, report, ierr)
    call went_well(ctx, ierr, 'icoray_report')
    call expect(report%step == int(step, int64) .and. report%rays > 0 .and. report%render_s > 0, 'report')
    call expect(report%bytes_copied == 0, 'bytes_copied')
    call expect(report%missing_values == 0 .and. report%value_max < 3, 'values')
  end subroutine frame
end module model
