!> A run of MPAS's double with the hook of examples/fortran/mpas: mpas_run hook | direct. It draws into the directory `pictures`
!> of where it runs, over all ranks; `direct` draws the same pictures from whole arrays through icoray's own calls. The column that
!> a rank's arrays have more, and every column of the other time level, hold no values.
program mpas_run
  use icoray
  use mpas_kind_types, only: RKIND
  use mpas_derived_types
  use mpas_pool_routines
  use mpas_parts
  use mpas_icoray
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  integer, parameter :: levels = 6, steps = 3, step_s = 43200
  real(RKIND), parameter :: planet = 6371229, top = 30000
  type(domain_type) :: domain
  character(len=8) :: how

  call start(domain, planet, [character(len=5) :: 'mesh', 'state', 'diag'])
  call get_command_argument(1, how)
  if (how == 'direct') then
    call draw_directly()
  else
    call run_with_hook()
  end if
  call finish()

contains

  !> Values of a place, in radians, at a level and a step.
  elemental real(RKIND) function theta_m_at(lon, lat, k, step)
    real(real64), intent(in) :: lon, lat
    integer, intent(in) :: k, step
    theta_m_at = real(290 + 12*k + 10*sin(2*lon + 0.5*step)*cos(lat), RKIND)
  end function theta_m_at
  elemental real(RKIND) function vapour_at(lat, k)
    real(real64), intent(in) :: lat
    integer, intent(in) :: k
    vapour_at = real(0.02*cos(lat)**2/k, RKIND)
  end function vapour_at
  elemental real(RKIND) function w_at(lon, lat, k, step)
    real(real64), intent(in) :: lon, lat
    integer, intent(in) :: k, step
    w_at = real(sin(3*lon - 0.7*step)*cos(lat)*sin(0.4*k), RKIND)
  end function w_at
  elemental real(RKIND) function vorticity_at(lon, lat, k, step)
    real(real64), intent(in) :: lon, lat
    integer, intent(in) :: k, step
    vorticity_at = real(1e-4*sin(4*lon + step)*cos(2*lat)*k/levels, RKIND)
  end function vorticity_at
  !> Of an interface above a mountain.
  elemental real(RKIND) function height_at(lon, lat, k)
    real(real64), intent(in) :: lon, lat
    integer, intent(in) :: k
    real(real64) :: z
    z = real(top, real64)*(k - 1)/levels
    height_at = real(z + 5000*max(0d0, cos(lon - 0.3)*cos(lat))**8*(1 - z/top), RKIND)
  end function height_at

  subroutine draw_directly()
    type(icoray_context) :: ctx
    real(RKIND), dimension(levels, size(whole%lon_center)), target :: theta
    real(RKIND), dimension(levels + 1, size(whole%lon_center)), target :: w, height
    real(RKIND), target :: vorticity(levels, size(whole%lon_corner))
    integer :: k, step, ierr
    call icoray_open_serial(ctx, output_dir='pictures', threads=1)
    call icoray_grid_set(ctx, whole%lon_center, whole%lat_center, whole%lon_corner, whole%lat_corner, whole%cell_corner, &
      whole%corner_cell, whole%corner_edge, whole%edge_corner, index_base=whole%index_base)
    call icoray_layers_set(ctx, [(real(planet, real64) + real(top, real64)*(k - 1)/levels, k=1, levels + 1)], &
      real(planet, real64))
    do k = 1, levels + 1
      height(k, :) = height_at(whole%lon_center, whole%lat_center, k)
    end do
    call icoray_heights_set(ctx, height)
    call icoray_field_set(ctx, 'theta', theta)
    call icoray_field_set(ctx, 'w', w)
    call icoray_field_set(ctx, 'vorticity', vorticity, location=ICORAY_CORNER)
    call icoray_scene_load(ctx, 'icoray.toml')
    do step = 0, steps
      do k = 1, levels + 1
        w(k, :) = w_at(whole%lon_center, whole%lat_center, k, step)
      end do
      do k = 1, levels
        theta(k, :) = theta_m_at(whole%lon_center, whole%lat_center, k, step) &
          /(1 + 461.6_RKIND/287.0_RKIND*vapour_at(whole%lat_center, k))
        vorticity(k, :) = vorticity_at(whole%lon_corner, whole%lat_corner, k, step)
      end do
      call icoray_execute(ctx, step, real(step, real64)*step_s, date(step*step_s), ierr)
      if (ierr /= ICORAY_OK) error stop 'icoray_execute'
    end do
    call icoray_close(ctx, ierr)
    if (ierr /= ICORAY_OK) error stop 'icoray_close'
  end subroutine draw_directly

  subroutine run_with_hook()
    type(mpas_pool_type), pointer :: mesh, state, diag
    real(RKIND), pointer :: w(:, :), theta_m(:, :), vorticity(:, :)
    integer, allocatable :: cell(:), corner(:), edge(:)
    integer :: step, k, own
    call mpas_pool_get_subpool(domain%blocklist%structs, 'mesh', mesh)
    call mpas_pool_get_subpool(domain%blocklist%structs, 'state', state)
    call mpas_pool_get_subpool(domain%blocklist%structs, 'diag', diag)
    call choose_part(rank, ranks, cell, corner, edge, own)
    call add_mesh(mesh, levels, cell, corner, edge, own)
    call add_heights(mesh, cell)
    call fill_state(state, diag, cell, corner)
    call mpas_icoray_init(domain)
    do step = 0, steps
      if (step > 0) domain%clock%now%second = domain%clock%now%second + step_s
      ! A step writes to level 2, which is level 1 after it.
      call mpas_pool_get_array(state, 'w', w, 2)
      call mpas_pool_get_array(state, 'theta_m', theta_m, 2)
      call mpas_pool_get_array(diag, 'vorticity', vorticity)
      do k = 1, levels + 1
        w(k, :size(cell)) = w_at(whole%lon_center(cell), whole%lat_center(cell), k, step)
      end do
      do k = 1, levels
        theta_m(k, :size(cell)) = theta_m_at(whole%lon_center(cell), whole%lat_center(cell), k, step)
        vorticity(k, :size(corner)) = vorticity_at(whole%lon_corner(corner), whole%lat_corner(corner), k, step)
      end do
      call mpas_pool_shift_time_levels(state)
      call mpas_pool_get_array(state, 'w', w, 2)
      w = ieee_value(w, ieee_quiet_nan)
      call mpas_icoray_draw(domain, step)
    end do
    call mpas_icoray_finalize()
  end subroutine run_with_hook

  subroutine add_heights(mesh, cell)
    type(mpas_pool_type), intent(inout) :: mesh
    integer, intent(in) :: cell(:)
    real(RKIND), pointer :: rdzw(:), zgrid(:, :)
    integer :: k
    allocate (rdzw(levels), zgrid(levels + 1, size(cell) + 1))
    rdzw = levels/top
    zgrid = ieee_value(zgrid, ieee_quiet_nan)
    do k = 1, levels + 1
      zgrid(k, :size(cell)) = height_at(whole%lon_center(cell), whole%lat_center(cell), k)
    end do
    call add_member(mesh, 'rdzw', r1=rdzw)
    call add_member(mesh, 'zgrid', r2=zgrid)
  end subroutine add_heights

  subroutine fill_state(state, diag, cell, corner)
    type(mpas_pool_type), intent(inout) :: state, diag
    integer, intent(in) :: cell(:), corner(:)
    real(RKIND), pointer :: scalars(:, :, :), w(:, :), theta_m(:, :), vorticity(:, :)
    integer :: level, k
    call add_dimension(state, 'index_qv', 2)
    do level = 1, 2
      allocate (scalars(3, levels, size(cell) + 1), w(levels + 1, size(cell) + 1), theta_m(levels, size(cell) + 1))
      scalars = ieee_value(scalars, ieee_quiet_nan)
      w = ieee_value(w, ieee_quiet_nan)
      theta_m = ieee_value(theta_m, ieee_quiet_nan)
      do k = 1, levels
        scalars(2, k, :size(cell)) = vapour_at(whole%lat_center(cell), k)
      end do
      call add_member(state, 'scalars', level, r3=scalars)
      call add_member(state, 'w', level, r2=w)
      call add_member(state, 'theta_m', level, r2=theta_m)
    end do
    allocate (vorticity(levels, size(corner) + 1))
    vorticity = ieee_value(vorticity, ieee_quiet_nan)
    call add_member(diag, 'vorticity', r2=vorticity)
  end subroutine fill_state
end program mpas_run
