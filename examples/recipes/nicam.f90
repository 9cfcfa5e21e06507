!> Pictures of NICAM's arrays (gall, kall, lall), read in place: regions of rows with halo points among their own, ghost
!> levels below and above, and the two poles, which NICAM has in arrays of their own and in the halos of regions.
!> The first part stands for the model. Run: ./nicam, with scene.toml in the directory of the run.
program nicam
  use icoray
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  integer, parameter :: glevel = 3, lall = 10, gmin = 2, gmax = 2**glevel + 1, gall_1d = gmax + 1, gall = gall_1d**2
  integer, parameter :: kmin = 2, kmax = 7, kall = kmax + 1
  type(icoray_context) :: ctx
  type(icoray_mesh) :: mesh
  type(icoray_grid_tables) :: whole
  type(icoray_frame_report) :: report
  real(real64), allocatable, target :: q(:, :, :), lon(:), lat(:)
  integer, allocatable, target :: cell_corner(:, :), corner_cell(:, :), count(:)
  integer, allocatable :: point(:)   ! where the model has each cell: ij + (l - 1)*gall
  integer :: i, j, l, k, c, step, ierr

  call icoray_mesh_create(glevel, mesh)
  call icoray_mesh_tables(mesh, whole)   ! numbered from 0
  allocate (point(0:size(whole%lon_center) - 1), q(gall, kall, lall))
  c = 0
  do l = 1, lall
    do j = gmin, gmax
      do i = gmin, gmax
        point(c) = i + (j - 1)*gall_1d + (l - 1)*gall
        c = c + 1
      end do
    end do
  end do
  point(c) = gmin + gmax*gall_1d                     ! the north pole, in the halo of region 1 behind its last row
  point(c + 1) = gmax + 1 + (gmin - 1)*gall_1d + (lall/2)*gall   ! the south pole, behind a row of region 6

  ! icoray's cells are all points of the arrays. Halo points that nothing is read from have no corner.
  allocate (lon(gall*lall), lat(gall*lall), source=0d0)
  allocate (cell_corner(6, gall*lall), source=0)
  allocate (count(gall*lall), source=3)
  do c = 0, size(point) - 1
    lon(point(c)) = whole%lon_center(c + 1)
    lat(point(c)) = whole%lat_center(c + 1)
    cell_corner(:, point(c)) = whole%cell_corner(:, c + 1) + 1
    count(point(c)) = merge(5, 6, cell_corner(6, point(c)) == cell_corner(5, point(c)))
  end do
  corner_cell = reshape([(point(whole%corner_cell(:, c)), c=1, size(whole%lon_corner))], shape(whole%corner_cell))

  call icoray_open_serial(ctx, ierr, output_dir='pictures', existing=ICORAY_OVERWRITE)
  call check(ierr)
  call set_grid(whole%corner_edge + 1, whole%edge_corner + 1)
  call icoray_layers_set(ctx, [(6371d3 + 5d3*(k - kmin), k=kmin, kmax)], 6371d3, ierr)
  call check(ierr)
  call icoray_scene_load(ctx, 'scene.toml', ierr)
  call check(ierr)
  do step = 0, 1
    call advance(step)
    call icoray_field_set(ctx, 'q', q(:, kmin:kmax, :), ierr)   ! without the ghost levels
    call check(ierr)
    call icoray_execute(ctx, step, 3600d0*step, ierr=ierr)
    call check(ierr)
  end do
  call icoray_report(ctx, report)
  print '(a, i0)', 'bytes copied: ', report%bytes_copied
  call icoray_close(ctx, ierr)
  call check(ierr)
  call icoray_mesh_free(mesh)

contains

  !> Tables live as long as the context.
  subroutine set_grid(edges_of_corners, corners_of_edges)
    integer, intent(in) :: edges_of_corners(:, :), corners_of_edges(:, :)
    integer, allocatable, target, save :: corner_edge(:, :), edge_corner(:, :)
    corner_edge = edges_of_corners
    edge_corner = corners_of_edges
    call icoray_grid_set(ctx, lon, lat, whole%lon_corner, whole%lat_corner, cell_corner, corner_cell, corner_edge, &
      edge_corner, ierr, index_base=1, cell_corner_count=count)
    call check(ierr)
  end subroutine set_grid

  !> The model: halo points that were not exchanged and ghost levels have no numbers.
  subroutine advance(step)
    integer, intent(in) :: step
    integer :: c, k, ij, l
    q = transfer(-1_8, 1d0)
    do c = 0, size(point) - 1
      ij = mod(point(c) - 1, gall) + 1
      l = (point(c) - 1)/gall + 1
      do k = kmin, kmax
        q(ij, k, l) = sin(3*lon(point(c)) + 0.3d0*(k - kmin) + 0.5d0*step)*cos(lat(point(c)))
      end do
    end do
  end subroutine advance

  subroutine check(ierr)
    integer, intent(in) :: ierr
    character(len=400) :: message
    if (ierr == ICORAY_OK) return
    call icoray_last_error(ctx, message)
    print '(2a)', 'icoray: ', trim(message)
  end subroutine check
end program nicam
