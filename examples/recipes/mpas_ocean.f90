!> Pictures of MPAS-Ocean's arrays: a tracer of the packed array, read in place, on the heights of its layers.
!> The first part stands for the model. Run: ./mpas_ocean, with scene.toml in the directory of the run.
program mpas_ocean
  use icoray
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  integer, parameter :: nVertLevels = 6, nTracers = 2, indexTemperature = 2
  real(real64), parameter :: sphere_radius = 6371e3_real64, fill = -1e34_real64
  type(icoray_context) :: ctx
  type(icoray_mesh) :: mesh
  type(icoray_grid_tables) :: grid
  type(icoray_frame_report) :: report
  real(real64), allocatable, target :: tracers(:, :, :)      ! pool tracers: activeTracers(nTracers, nVertLevels, nCells)
  real(real64), allocatable :: layerThickness(:, :), ssh(:)  ! pool state, time level 1
  integer, allocatable :: maxLevelCell(:)                    ! pool mesh
  real(real64), allocatable, target :: height_m(:, :)        ! icoray's: interfaces of layers, from the surface down
  real(real64) :: refBottomDepth(nVertLevels)
  integer :: nCells, i, k, step, ierr

  call icoray_mesh_create(3, mesh)
  call icoray_mesh_tables(mesh, grid)
  nCells = size(grid%lon_center)
  allocate (tracers(nTracers, nVertLevels, nCells), height_m(nVertLevels + 1, nCells))
  refBottomDepth = [(5e3_real64*k, k=1, nVertLevels)]
  maxLevelCell = [(3 + mod(i, 4), i=1, nCells)]
  ssh = 300*sin(2*grid%lon_center)*cos(grid%lat_center)
  allocate (layerThickness(nVertLevels, nCells), source=0d0)
  do i = 1, nCells
    layerThickness(:maxLevelCell(i), i) = 5e3_real64
  end do

  call icoray_open_serial(ctx, ierr, output_dir='pictures', existing=ICORAY_OVERWRITE)
  call told(ierr)
  call icoray_grid_set(ctx, grid%lon_center, grid%lat_center, grid%lon_corner, grid%lat_corner, grid%cell_corner, &
    grid%corner_cell, grid%corner_edge, grid%edge_corner, ierr, index_base=grid%index_base)
  call told(ierr)
  ! The nominal interfaces, from the surface down, as the levels of MPAS-Ocean are.
  call icoray_layers_set(ctx, sphere_radius - [0d0, refBottomDepth], sphere_radius, ierr)
  call told(ierr)
  call icoray_scene_load(ctx, 'scene.toml', ierr)
  call told(ierr)
  do step = 0, 1
    call advance(step)
    do i = 1, nCells
      height_m(1, i) = ssh(i)
      do k = 1, nVertLevels
        height_m(k + 1, i) = height_m(k, i) - layerThickness(k, i)   ! 0 below the floor
      end do
    end do
    call icoray_heights_set(ctx, height_m, ierr)
    call told(ierr)
    call icoray_field_set(ctx, 'q', tracers(indexTemperature, :, :), ierr, fill_value=fill)
    call told(ierr)
    call icoray_execute(ctx, step, 3600d0*step, ierr=ierr)
    call told(ierr)
  end do
  call icoray_report(ctx, report)
  print '(a, i0)', 'bytes copied: ', report%bytes_copied
  call icoray_close(ctx, ierr)
  call told(ierr)
  call icoray_mesh_free(mesh)

contains

  !> The model: below maxLevelCell stands its fill value.
  subroutine advance(step)
    integer, intent(in) :: step
    integer :: i, k
    tracers = fill
    do i = 1, nCells
      do k = 1, maxLevelCell(i)
        tracers(indexTemperature, k, i) = sin(3*grid%lon_center(i) + 0.3d0*(k - 1) + 0.5d0*step)*cos(grid%lat_center(i))
      end do
    end do
  end subroutine advance

  subroutine told(ierr)
    integer, intent(in) :: ierr
    character(len=400) :: message
    if (ierr == ICORAY_OK) return
    call icoray_last_error(ctx, message)
    print '(2a)', 'icoray: ', trim(message)
  end subroutine told
end program mpas_ocean
