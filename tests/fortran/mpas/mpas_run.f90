!> A run of MPAS's double with the hook of examples/fortran/mpas: mpas_run hook | direct. It draws into the directory `pictures`
!> of where it runs, over all ranks; `direct` draws the same pictures from whole arrays through icoray's own calls.
!>
!> A rank has the cells of some numbers and two rings around them, own cells first, and the corners and edges of all these, in
!> arrays with one column more, as MPAS has them. That column, and every column of the other time level, holds no values.
program mpas_run
  use mpi_f08
  use icoray
  use mpas_kind_types, only: RKIND
  use mpas_derived_types
  use mpas_pool_routines
  use mpas_icoray
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  integer, parameter :: levels = 6, steps = 3, step_s = 43200
  real(RKIND), parameter :: planet = 6371229, top = 30000
  type(icoray_mesh) :: icosahedron
  type(icoray_grid_tables) :: whole
  character(len=8) :: how
  integer :: rank, ranks

  call MPI_Init()
  call MPI_Comm_rank(MPI_COMM_WORLD, rank)
  call MPI_Comm_size(MPI_COMM_WORLD, ranks)
  call icoray_mesh_create(3, icosahedron)
  call icoray_mesh_tables(icosahedron, whole)
  call get_command_argument(1, how)
  if (how == 'direct') then
    call draw_directly()
  else
    call run_with_hook()
  end if
  call icoray_mesh_free(icosahedron)
  call MPI_Finalize()

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
    call icoray_grid_set(ctx, icosahedron)
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
      call icoray_execute(ctx, step, real(step, real64)*step_s, date(step), ierr)
      if (ierr /= ICORAY_OK) error stop 'icoray_execute'
    end do
    call icoray_close(ctx, ierr)
    if (ierr /= ICORAY_OK) error stop 'icoray_close'
  end subroutine draw_directly

  function date(step) result(text)
    integer, intent(in) :: step
    character(len=19) :: text
    write (text, '(a, i2.2, a, i2.2, a)') '2000-01-', 1 + step*step_s/86400, '_', mod(step*step_s/3600, 24), ':00:00'
  end function date

  subroutine run_with_hook()
    type(domain_type) :: domain
    type(mpas_pool_type), pointer :: mesh, state, diag
    real(RKIND), pointer :: w(:, :), theta_m(:, :), vorticity(:, :)
    integer, allocatable :: cell(:), corner(:), edge(:)
    integer :: step, k, own
    allocate (domain%blocklist, domain%clock, domain%dminfo, mesh, state, diag)
    allocate (domain%blocklist%structs)
#ifdef MPAS_USE_MPI_F08
    domain%dminfo%comm = MPI_COMM_WORLD
#else
    domain%dminfo%comm = MPI_COMM_WORLD%MPI_VAL
#endif
    domain%sphere_radius = planet
    call add_member(domain%blocklist%structs, 'mesh', sub=mesh)
    call add_member(domain%blocklist%structs, 'state', sub=state)
    call add_member(domain%blocklist%structs, 'diag', sub=diag)
    call choose_part(cell, corner, edge, own)
    call fill_mesh(mesh, cell, corner, edge, own)
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

  !> Numbers in the whole mesh, from 1, of this rank's cells, the first `own` of which are its own, and of their corners and edges.
  subroutine choose_part(cell, corner, edge, own)
    integer, allocatable, intent(out) :: cell(:), corner(:), edge(:)
    integer, intent(out) :: own
    integer :: ring(0:size(whole%lon_center) - 1), i, r
    logical :: is_here(0:size(whole%lon_corner) - 1)
    ring = [(merge(0, 9, (i - 1)*ranks/size(ring) == rank), i=1, size(ring))]
    do r = 1, 2
      do i = 1, size(whole%lon_corner)
        associate (c => whole%corner_cell(:, i))
          if (minval(ring(c)) == r - 1) ring(c) = min(ring(c), r)
        end associate
      end do
    end do
    cell = [(pack([(i, i=1, size(ring))], ring == r), r=0, 2)]
    own = count(ring == 0)
    is_here = [(any(ring(whole%corner_cell(:, i)) <= 2), i=1, size(is_here))]
    corner = pack([(i, i=1, size(is_here))], is_here)
    edge = pack([(i, i=1, size(whole%edge_corner, 2))], [(has_cell(i, ring), i=1, size(whole%edge_corner, 2))])
  end subroutine choose_part

  !> Whether an edge is between cells of which one is here.
  logical function has_cell(edge, ring)
    integer, intent(in) :: edge, ring(0:)
    integer :: k
    has_cell = .false.
    associate (a => whole%corner_cell(:, whole%edge_corner(1, edge) + 1), b => whole%corner_cell(:, whole%edge_corner(2, edge) + 1))
      do k = 1, 3
        if (any(b == a(k))) has_cell = has_cell .or. ring(a(k)) <= 2
      end do
    end associate
  end function has_cell

  subroutine fill_mesh(mesh, cell, corner, edge, own)
    type(mpas_pool_type), intent(inout) :: mesh
    integer, intent(in) :: cell(:), corner(:), edge(:), own
    integer, pointer :: numbers(:), counts(:)
    real(RKIND), pointer :: rdzw(:), zgrid(:, :)
    integer :: k
    call add_dimension(mesh, 'nCells', size(cell))
    call add_dimension(mesh, 'nCellsSolve', own)
    call add_dimension(mesh, 'nVertices', size(corner))
    call add_dimension(mesh, 'nEdges', size(edge))
    call add_dimension(mesh, 'nVertLevels', levels)
    call add_member(mesh, 'lonCell', r1=column(whole%lon_center(cell)))
    call add_member(mesh, 'latCell', r1=column(whole%lat_center(cell)))
    call add_member(mesh, 'lonVertex', r1=column(whole%lon_corner(corner)))
    call add_member(mesh, 'latVertex', r1=column(whole%lat_corner(corner)))
    call add_member(mesh, 'verticesOnCell', i2=table(whole%cell_corner(:, cell), corner, size(whole%lon_corner)))
    call add_member(mesh, 'cellsOnVertex', i2=table(whole%corner_cell(:, corner), cell, size(whole%lon_center)))
    call add_member(mesh, 'edgesOnVertex', i2=table(whole%corner_edge(:, corner), edge, size(whole%edge_corner, 2)))
    call add_member(mesh, 'verticesOnEdge', i2=table(whole%edge_corner(:, edge), corner, size(whole%lon_corner)))
    allocate (numbers(size(cell) + 1), counts(size(cell) + 1), rdzw(levels), zgrid(levels + 1, size(cell) + 1))
    numbers(:size(cell)) = cell
    numbers(size(cell) + 1) = 0
    ! A pentagon repeats a corner, in the last place.
    counts(:size(cell)) = [(6 - count(whole%cell_corner(:5, cell(k)) == whole%cell_corner(6, cell(k))), k=1, size(cell))]
    counts(size(cell) + 1) = 0
    rdzw = levels/top
    zgrid = ieee_value(zgrid, ieee_quiet_nan)
    do k = 1, levels + 1
      zgrid(k, :size(cell)) = height_at(whole%lon_center(cell), whole%lat_center(cell), k)
    end do
    call add_member(mesh, 'indexToCellID', i1=numbers)
    call add_member(mesh, 'nEdgesOnCell', i1=counts)
    call add_member(mesh, 'rdzw', r1=rdzw)
    call add_member(mesh, 'zgrid', r2=zgrid)
  end subroutine fill_mesh

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

  subroutine add_dimension(pool, name, number)
    type(mpas_pool_type), intent(inout) :: pool
    character(len=*), intent(in) :: name
    integer, intent(in) :: number
    integer, pointer :: dim
    allocate (dim, source=number)
    call add_member(pool, name, i0=dim)
  end subroutine add_dimension

  !> Values in MPAS's precision, with one more behind.
  function column(values) result(array)
    real(real64), intent(in) :: values(:)
    real(RKIND), pointer :: array(:)
    allocate (array(size(values) + 1))
    array(:size(values)) = real(values, RKIND)
    array(size(values) + 1) = 0
  end function column

  !> Rows of a table of the whole mesh, which counts from 0, with numbers of here in them: one past the last for what is not here.
  function table(rows, here, total) result(local)
    integer, intent(in) :: rows(:, :), here(:), total
    integer, pointer :: local(:, :)
    integer :: number(0:total - 1), i
    number = size(here) + 1
    number(here - 1) = [(i, i=1, size(here))]
    allocate (local(size(rows, 1), size(rows, 2) + 1))
    do i = 1, size(rows, 2)
      local(:, i) = number(rows(:, i))
    end do
    local(:, size(local, 2)) = size(here) + 1
  end function table
end program mpas_run
