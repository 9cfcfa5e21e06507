!> icoray in a Fortran model, on one page: a wave that turns around a planet, with a picture at each tenth step.
program minimal
  use icoray
  use, intrinsic :: iso_fortran_env, only: real32, real64
  implicit none
  integer, parameter :: layers = 20
  real(real64), parameter :: planet_m = 6371220, top_m = 30000, step_s = 3600
  character, parameter :: nl = new_line('a')
  character(len=*), parameter :: scene = &
    'field = "wave"'//nl// &   ! its colours and opacities are those that suit the first values
    'every = 10'//nl// &
    'image = { width = 640, height = 480 }'//nl// &
    'camera = { lon = 20, lat = 35 }'//nl// &
    '[output]'//nl//'file = "wave_{step}.png"'//nl
  type(icoray_context) :: ctx
  type(icoray_mesh) :: mesh
  type(icoray_grid_tables) :: grid
  type(icoray_frame_report) :: report
  real(real32), allocatable, target :: wave(:, :)   ! TARGET: icoray reads it where it lies
  real(real64) :: radius_m(layers)
  integer :: step, ierr, k
  logical :: wants

  ! A model has these tables already: MPAS's lonCell, latCell, ..., verticesOnEdge, numbered from 1.
  call icoray_mesh_create(5, mesh, ierr)
  call report_error(ierr)
  call icoray_mesh_tables(mesh, grid)
  allocate (wave(layers, size(grid%lon_center)))
  radius_m = [(planet_m + top_m*(k - 1)/(layers - 1), k=1, layers)]

  call icoray_open_serial(ctx, ierr, output_dir='pictures', existing=ICORAY_OVERWRITE)
  call report_error(ierr)
  call icoray_grid_set(ctx, grid%lon_center, grid%lat_center, grid%lon_corner, grid%lat_corner, grid%cell_corner, &
    grid%corner_cell, grid%corner_edge, grid%edge_corner, ierr, index_base=grid%index_base)
  call report_error(ierr)
  call icoray_layers_set(ctx, radius_m, planet_m, ierr)
  call report_error(ierr)
  call icoray_scene_text(ctx, scene, ierr)   ! or icoray_scene_load(ctx, 'scene.toml', ierr)
  call report_error(ierr)
  call icoray_field_describe(ctx, 'wave', 'a wave that turns around the planet', 'm s-1', ierr)
  call report_error(ierr)

  do step = 0, 30
    do k = 1, layers
      wave(k, :) = real(sin(3*(grid%lon_center - 0.05*step) + 0.1*k)*cos(grid%lat_center)**2, real32)
    end do
    call icoray_wants(ctx, step, step*step_s, wants)   ! before a costly diagnostic
    if (.not. wants) cycle
    ! In the loop: models swap time levels, and a pointer that is given once shows the step before at every odd step.
    call icoray_field_set(ctx, 'wave', wave, ierr)
    call report_error(ierr)
    call icoray_execute(ctx, step, step*step_s, ierr)
    call report_error(ierr)
    call icoray_report(ctx, report)
    print '(a, i0, a, f6.3, a)', 'step ', step, ': ', report%host_s, ' s'
  end do

  call icoray_close(ctx, ierr)   ! waits for the last picture
  call report_error(ierr)
  call icoray_mesh_free(mesh)

contains

  !> A picture that fails is no reason to end a model.
  subroutine report_error(ierr)
    integer, intent(in) :: ierr
    character(len=300) :: message
    if (ierr == ICORAY_OK) return
    call icoray_last_error(ctx, message)
    print '(a, i0, 2a)', 'icoray: status ', ierr, ': ', trim(message)
  end subroutine report_error
end program minimal
