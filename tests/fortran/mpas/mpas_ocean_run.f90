!> A run of MPAS's double with the hook of examples/fortran/mpas_ocean: mpas_ocean_run hook | direct [ice]. It draws
!> into the directory `pictures` of where it runs, over all ranks; `direct` draws the same pictures from whole arrays
!> through icoray's own calls. Land is culled. With `ice` the highest levels of some columns are missing and the mesh
!> has minLevelCell; without, it has not. The column that a rank's arrays have more, and every column of the other time
!> level, hold no values.
program mpas_ocean_run
  use icoray
  use mpas_kind_types, only: RKIND
  use mpas_derived_types
  use mpas_pool_routines
  use mpas_parts
  use mpas_icoray_ocean
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  integer, parameter :: levels = 8, steps = 36, step_s = 3600
  real(RKIND), parameter :: planet = 6371220
  real(RKIND), parameter :: depth(0:levels) = real([0, 50, 150, 400, 1000, 2000, 3000, 4000, 5500], RKIND)
  type(domain_type) :: domain
  character(len=8) :: how, ice
  integer, allocatable :: cell(:), corner(:), edge(:)
  integer :: own
  real(RKIND) :: nan

  nan = ieee_value(nan, ieee_quiet_nan)
  call start(domain, planet, [character(len=11) :: 'mesh', 'state', 'diagnostics'])
  call get_command_argument(1, how)
  call get_command_argument(2, ice)
  ! A continent and an island.
  is_culled = cos(whole%lat_center)*cos(whole%lon_center - 5) > 0.85d0 .or. &
    cos(whole%lat_center - 0.3d0)*cos(whole%lon_center - 3.2d0) > 0.98d0
  if (how == 'direct') then
    call choose_part(0, 1, cell, corner, edge, own)
    call draw_directly(whole%lon_center(cell), whole%lat_center(cell), whole%lon_corner(corner), whole%lat_corner(corner))
  else
    call choose_part(rank, ranks, cell, corner, edge, own)
    call run_with_hook(whole%lon_center(cell), whole%lat_center(cell), whole%lon_corner(corner), whole%lat_corner(corner))
  end if
  call finish()

contains

  !> The highest and the lowest level with water of a place, in radians.
  elemental integer function highest_at(lat)
    real(real64), intent(in) :: lat
    highest_at = 1
    if (ice == 'ice') highest_at = 1 + count(lat > [0.3d0, 0.7d0])
  end function highest_at
  elemental integer function lowest_at(lon, lat)
    real(real64), intent(in) :: lon, lat
    lowest_at = min(levels, 4 + int(5*(0.5d0 + 0.5d0*sin(3*lon)*cos(lat))))
  end function lowest_at
  !> The surface, below the ice if there is any.
  elemental real(RKIND) function ssh_at(lon, lat, step)
    real(real64), intent(in) :: lon, lat
    integer, intent(in) :: step
    ssh_at = real(100*sin(2*lon + 0.1d0*step)*cos(lat), RKIND) - depth(highest_at(lat) - 1)
  end function ssh_at
  elemental real(RKIND) function thickness_at(lon, lat, k, step)
    real(real64), intent(in) :: lon, lat
    integer, intent(in) :: k, step
    thickness_at = (depth(k) - depth(k - 1))*real(1 + 0.2d0*sin(lon + 0.05d0*step)*sin(2*lat), RKIND)
  end function thickness_at
  elemental real(RKIND) function temperature_at(lon, lat, k, step)
    real(real64), intent(in) :: lon, lat
    integer, intent(in) :: k, step
    temperature_at = real(2 + 24*cos(lat)**2*exp(-k/4d0) + 3*sin(3*lon + 0.1d0*step)*cos(lat), RKIND)
  end function temperature_at
  elemental real(RKIND) function salinity_at(lon, lat, k, step)
    real(real64), intent(in) :: lon, lat
    integer, intent(in) :: k, step
    salinity_at = real(34.5d0 + cos(2*lat + 0.02d0*step)*exp(-k/5d0) + 0.3d0*sin(2*lon), RKIND)
  end function salinity_at
  !> At corners; MPAS-Ocean has 0 below the floor.
  elemental real(RKIND) function vorticity_at(lon, lat, k, step)
    real(real64), intent(in) :: lon, lat
    integer, intent(in) :: k, step
    vorticity_at = real(merge(2d-6*sin(4*lon + step)*cos(2*lat)*k/levels, 0d0, k <= lowest_at(lon, lat)), RKIND)
  end function vorticity_at

  subroutine draw_directly(lon, lat, lon_corner, lat_corner)
    real(real64), intent(in) :: lon(:), lat(:), lon_corner(:), lat_corner(:)
    type(icoray_context) :: ctx
    integer, allocatable, target :: cell_corner(:, :), corner_cell(:, :), corner_edge(:, :), edge_corner(:, :), counts(:)
    real(real64), allocatable, target :: places(:, :), corners(:, :)
    real(RKIND), allocatable, target :: temperature(:, :), salinity(:, :), vorticity(:, :), height(:, :)
    integer :: i, k, step, ierr
    places = reshape([lon, lat], [size(lon), 2])
    corners = reshape([lon_corner, lat_corner], [size(lon_corner), 2])
    cell_corner = numbered(whole%cell_corner(:, cell), corner, size(whole%lon_corner), 0)
    corner_cell = numbered(whole%corner_cell(:, corner), cell, size(whole%lon_center), 0)
    corner_edge = numbered(whole%corner_edge(:, corner), edge, size(whole%edge_corner, 2), 0)
    edge_corner = numbered(whole%edge_corner(:, edge), corner, size(whole%lon_corner), 0)
    counts = corner_counts(cell)
    if (all(corner_cell > 0)) error stop 'nothing is culled'
    allocate (temperature(levels, size(lon)), salinity(levels, size(lon)), height(0:levels, size(lon)))
    allocate (vorticity(levels, size(lon_corner)))
    call icoray_open_serial(ctx, output_dir='pictures', threads=1)
    call icoray_grid_set(ctx, places(:, 1), places(:, 2), corners(:, 1), corners(:, 2), cell_corner, corner_cell, corner_edge, &
      edge_corner, index_base=1, cell_corner_count=counts)
    call icoray_layers_set(ctx, real(planet - depth, real64), real(planet, real64))
    call icoray_field_set(ctx, 'temperature', temperature)
    call icoray_field_set(ctx, 'salinity', salinity)
    call icoray_field_set(ctx, 'vorticity', vorticity, location=ICORAY_CORNER)
    call icoray_heights_set(ctx, height)
    call icoray_scene_load(ctx, 'icoray.toml')
    do step = 0, steps
      do i = 1, size(lon)
        height(0, i) = ssh_at(lon(i), lat(i), step)
        do k = 1, levels
          height(k, i) = height(k - 1, i)
          temperature(k, i) = nan
          salinity(k, i) = nan
          if (k < highest_at(lat(i)) .or. k > lowest_at(lon(i), lat(i))) cycle
          height(k, i) = height(k - 1, i) - thickness_at(lon(i), lat(i), k, step)
          temperature(k, i) = temperature_at(lon(i), lat(i), k, step)
          salinity(k, i) = salinity_at(lon(i), lat(i), k, step)
        end do
      end do
      do k = 1, levels
        vorticity(k, :) = vorticity_at(lon_corner, lat_corner, k, step)
      end do
      call icoray_execute(ctx, step, real(step, real64)*step_s, date(step*step_s), ierr)
      if (ierr /= ICORAY_OK) error stop 'icoray_execute'
    end do
    call icoray_close(ctx, ierr)
    if (ierr /= ICORAY_OK) error stop 'icoray_close'
  end subroutine draw_directly

  subroutine run_with_hook(lon, lat, lon_corner, lat_corner)
    real(real64), intent(in) :: lon(:), lat(:), lon_corner(:), lat_corner(:)
    type(mpas_pool_type), pointer :: mesh, state, tracers, diagnostics
    integer :: step
    call mpas_pool_get_subpool(domain%blocklist%structs, 'mesh', mesh)
    call mpas_pool_get_subpool(domain%blocklist%structs, 'state', state)
    call mpas_pool_get_subpool(domain%blocklist%structs, 'diagnostics', diagnostics)
    call add_mesh(mesh, levels, cell, corner, edge, own)
    call add_levels(mesh, lon, lat)
    allocate (tracers)
    call add_member(state, 'tracers', sub=tracers)
    call add_state(state, tracers, diagnostics, size(lon), size(lon_corner))
    call advance(state, tracers, diagnostics, lon, lat, lon_corner, lat_corner, 0)
    call mpas_icoray_init(domain)
    call mpas_icoray_draw(domain, 0)
    do step = 1, steps
      domain%clock%now%second = domain%clock%now%second + step_s
      call advance(state, tracers, diagnostics, lon, lat, lon_corner, lat_corner, step)
      call mpas_icoray_draw(domain, step)
    end do
    call mpas_icoray_finalize()
  end subroutine run_with_hook

  subroutine add_levels(mesh, lon, lat)
    type(mpas_pool_type), intent(inout) :: mesh
    real(real64), intent(in) :: lon(:), lat(:)
    integer, pointer :: minLevelCell(:), maxLevelCell(:)
    real(RKIND), pointer :: refBottomDepth(:)
    allocate (refBottomDepth(levels), source=depth(1:))
    allocate (minLevelCell(size(lon) + 1), maxLevelCell(size(lon) + 1), source=0)
    minLevelCell(:size(lon)) = highest_at(lat)
    maxLevelCell(:size(lon)) = lowest_at(lon, lat)
    call add_member(mesh, 'refBottomDepth', r1=refBottomDepth)
    call add_member(mesh, 'maxLevelCell', i1=maxLevelCell)
    if (ice == 'ice') call add_member(mesh, 'minLevelCell', i1=minLevelCell)
  end subroutine add_levels

  !> Arrays without values. The packed array has another tracer before the two that are drawn.
  subroutine add_state(state, tracers, diagnostics, cells, corners)
    type(mpas_pool_type), intent(inout) :: state, tracers, diagnostics
    integer, intent(in) :: cells, corners
    real(RKIND), pointer :: ssh(:), layerThickness(:, :), activeTracers(:, :, :), relativeVorticity(:, :)
    integer :: level
    call add_dimension(tracers, 'index_salinity', 2)
    call add_dimension(tracers, 'index_temperature', 3)
    do level = 1, 2
      allocate (ssh(cells + 1), layerThickness(levels, cells + 1), activeTracers(3, levels, cells + 1), source=nan)
      call add_member(state, 'ssh', level, r1=ssh)
      call add_member(state, 'layerThickness', level, r2=layerThickness)
      call add_member(tracers, 'activeTracers', level, r3=activeTracers)
    end do
    allocate (relativeVorticity(levels, corners + 1), source=nan)
    call add_member(diagnostics, 'relativeVorticity', r2=relativeVorticity)
  end subroutine add_state

  !> A step writes to level 2, which is level 1 after it; then level 2 has no values.
  subroutine advance(state, tracers, diagnostics, lon, lat, lon_corner, lat_corner, step)
    type(mpas_pool_type), intent(inout) :: state, tracers, diagnostics
    real(real64), intent(in) :: lon(:), lat(:), lon_corner(:), lat_corner(:)
    integer, intent(in) :: step
    real(RKIND), parameter :: fill = -1.0e34_RKIND
    real(RKIND), pointer :: ssh(:), layerThickness(:, :), activeTracers(:, :, :), relativeVorticity(:, :)
    integer :: i, k
    call mpas_pool_get_array(state, 'ssh', ssh, 2)
    call mpas_pool_get_array(state, 'layerThickness', layerThickness, 2)
    call mpas_pool_get_array(tracers, 'activeTracers', activeTracers, 2)
    call mpas_pool_get_array(diagnostics, 'relativeVorticity', relativeVorticity)
    ssh(:size(lon)) = ssh_at(lon, lat, step)
    do i = 1, size(lon)
      do k = 1, levels
        if (k < highest_at(lat(i)) .or. k > lowest_at(lon(i), lat(i))) then
          layerThickness(k, i) = merge(-3000, 7000, mod(i, 2) == 0)
          activeTracers(:, k, i) = fill
        else
          layerThickness(k, i) = thickness_at(lon(i), lat(i), k, step)
          activeTracers(2, k, i) = salinity_at(lon(i), lat(i), k, step)
          activeTracers(3, k, i) = temperature_at(lon(i), lat(i), k, step)
        end if
      end do
    end do
    do k = 1, levels
      relativeVorticity(k, :size(lon_corner)) = vorticity_at(lon_corner, lat_corner, k, step)
    end do
    call mpas_pool_shift_time_levels(state)
    call mpas_pool_get_array(state, 'ssh', ssh, 2)
    call mpas_pool_get_array(state, 'layerThickness', layerThickness, 2)
    call mpas_pool_get_array(tracers, 'activeTracers', activeTracers, 2)
    ssh = nan
    layerThickness = nan
    activeTracers = nan
  end subroutine advance
end program mpas_ocean_run
