!> The mesh of a rank in MPAS's mesh pool, for runs of MPAS's double: the cells of some numbers and two rings around
!> them, own cells first, and the corners and edges of all these, in arrays with one column more. A cell that is culled
!> is in no part.
module mpas_parts
  use mpi_f08
  use icoray
  use mpas_kind_types, only: RKIND
  use mpas_derived_types
  use mpas_pool_routines
  use, intrinsic :: iso_fortran_env, only: real64
  implicit none
  private
  public :: start, finish, choose_part, add_mesh, add_dimension, numbered, corner_counts, date
  integer, public, protected :: rank, ranks
  type(icoray_grid_tables), public, protected :: whole
  logical, allocatable, public :: is_culled(:)   !< of all cells, from 1
  type(icoray_mesh) :: icosahedron

contains

  !> Makes the whole mesh, and a domain of all ranks with pools of these names and no mesh in them.
  subroutine start(domain, radius, pools)
    type(domain_type), intent(out) :: domain
    real(RKIND), intent(in) :: radius
    character(len=*), intent(in) :: pools(:)
    type(mpas_pool_type), pointer :: pool
    integer :: i
    call MPI_Init()
    call MPI_Comm_rank(MPI_COMM_WORLD, rank)
    call MPI_Comm_size(MPI_COMM_WORLD, ranks)
    call icoray_mesh_create(3, icosahedron)
    call icoray_mesh_tables(icosahedron, whole)
    allocate (is_culled(size(whole%lon_center)), source=.false.)
    allocate (domain%blocklist, domain%clock, domain%dminfo)
    allocate (domain%blocklist%structs)
#ifdef MPAS_USE_MPI_F08
    domain%dminfo%comm = MPI_COMM_WORLD
#else
    domain%dminfo%comm = MPI_COMM_WORLD%MPI_VAL
#endif
    domain%sphere_radius = radius
    do i = 1, size(pools)
      allocate (pool)
      call add_member(domain%blocklist%structs, pools(i), sub=pool)
    end do
  end subroutine start

  subroutine finish()
    call icoray_mesh_free(icosahedron)
    call MPI_Finalize()
  end subroutine finish

  !> `YYYY-MM-DD_hh:mm:ss` of the double's calendar.
  function date(second) result(text)
    integer, intent(in) :: second
    character(len=19) :: text
    write (text, '(a, i2.2, a, i2.2, a)') '2000-01-', 1 + second/86400, '_', mod(second/3600, 24), ':00:00'
  end function date

  !> Numbers in the whole mesh, from 1, of a rank's cells, the first `own` of which are its own, and of their corners
  !> and edges.
  subroutine choose_part(rank, ranks, cell, corner, edge, own)
    integer, intent(in) :: rank, ranks
    integer, allocatable, intent(out) :: cell(:), corner(:), edge(:)
    integer, intent(out) :: own
    integer :: ring(0:size(whole%lon_center) - 1), i, k, r
    logical :: is_here(0:size(whole%lon_corner) - 1)
    ring = [(merge(0, 9, (i - 1)*ranks/size(ring) == rank .and. .not. is_culled(i)), i=1, size(ring))]
    do r = 1, 2
      do i = 1, size(whole%lon_corner)
        associate (c => whole%corner_cell(:, i))
          if (minval(ring(c)) /= r - 1) cycle
          do k = 1, 3
            if (.not. is_culled(c(k) + 1)) ring(c(k)) = min(ring(c(k)), r)
          end do
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

  !> Puts the part's mesh into the mesh pool. Numbers of cells leave out those that are culled.
  subroutine add_mesh(mesh, levels, cell, corner, edge, own)
    type(mpas_pool_type), intent(inout) :: mesh
    integer, intent(in) :: levels, cell(:), corner(:), edge(:), own
    integer, pointer :: numbers(:), counts(:)
    integer :: i
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
    allocate (numbers(size(cell) + 1), counts(size(cell) + 1))
    numbers = [(count(.not. is_culled(:cell(i))), i=1, size(cell)), 0]
    counts = [corner_counts(cell), 0]
    call add_member(mesh, 'indexToCellID', i1=numbers)
    call add_member(mesh, 'nEdgesOnCell', i1=counts)
  end subroutine add_mesh

  !> A pentagon repeats a corner, in the last place.
  function corner_counts(cell) result(counts)
    integer, intent(in) :: cell(:)
    integer :: counts(size(cell)), k
    counts = [(6 - count(whole%cell_corner(:5, cell(k)) == whole%cell_corner(6, cell(k))), k=1, size(cell))]
  end function corner_counts

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

  !> Rows of a table of the whole mesh, which counts from 0, with numbers of here in them: `absent` for what is not
  !> here.
  function numbered(rows, here, total, absent) result(local)
    integer, intent(in) :: rows(:, :), here(:), total, absent
    integer :: local(size(rows, 1), size(rows, 2)), number(0:total - 1), i
    number = absent
    number(here - 1) = [(i, i=1, size(here))]
    do i = 1, size(rows, 2)
      local(:, i) = number(rows(:, i))
    end do
  end function numbered

  !> Such rows as MPAS has them: one past the last for what is not here, and a row more.
  function table(rows, here, total) result(local)
    integer, intent(in) :: rows(:, :), here(:), total
    integer, pointer :: local(:, :)
    allocate (local(size(rows, 1), size(rows, 2) + 1), source=size(here) + 1)
    local(:, :size(rows, 2)) = numbered(rows, here, total, size(here) + 1)
  end function table
end module mpas_parts
