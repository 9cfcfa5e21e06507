!> A rank's part of the mesh: its own cells with `halo` rings around them, and all edges and corners of these, numbered anew. Rows
!> keep the order that they have in the whole mesh and coefficients are copied, so that what comes of them has the same bits.
module parts
   use kinds, only: wp, ip
   use tables, only: grid_tables
   use mesh, only: mesh_type, halo
   use operators, only: operators_type
   use ranks, only: new_pattern
   implicit none
   private
   public :: part_type, choose, cut, share

   !> Cells, corners and edges of a part: their numbers in the whole mesh, in the part's order.
   type :: part_type
      integer(ip), allocatable :: cell(:), corner(:), edge(:)
      integer :: cells_in(0:halo), corners_in(0:halo), edges_in(0:halo)
   end type part_type

contains

   subroutine choose(m, owner, rank, p)
      type(mesh_type), intent(in) :: m
      integer, intent(in) :: owner(:), rank  !< of each cell; whose part this is to be
      type(part_type), intent(out) :: p
      integer :: ring(m%cells), edge_ring(m%edges), corner_ring(m%corners), r, e, v

      ring = merge(0, halo + 1, owner == rank)
      do r = 1, halo
         do e = 1, m%edges
            associate (c => m%edge_cell(:, e))
               if (minval(ring(c)) == r - 1) ring(c) = min(ring(c), r)
            end associate
         end do
      end do
      do e = 1, m%edges
         associate (c => ring(m%edge_cell(:, e)))
            ! in the last ring, one that has both cells here comes before those that have one: halo, halo + 1
            edge_ring(e) = merge(sum(c) - halo, minval(c), minval(c) >= halo)
         end associate
      end do
      do v = 1, m%corners
         corner_ring(v) = minval(ring(m%corner_cell(:, v)))
      end do
      call list(ring, halo, p%cell, p%cells_in)
      call list(edge_ring, halo + 1, p%edge, p%edges_in)
      call list(corner_ring, halo, p%corner, p%corners_in)
   end subroutine choose

   !> The numbers of all up to a ring, ring by ring.
   subroutine list(ring, last, numbers, within)
      integer, intent(in) :: ring(:), last
      integer(ip), allocatable, intent(out) :: numbers(:)
      integer, intent(out) :: within(0:halo)
      integer :: r, i, found
      allocate (numbers(count(ring <= last)))
      found = 0
      do r = 0, last
         do i = 1, size(ring)
            if (ring(i) /= r) cycle
            found = found + 1
            numbers(found) = int(i, ip)
         end do
         if (r <= halo) within(r) = found
      end do
   end subroutine list

   subroutine cut(p, whole_t, whole_m, whole_o, t, m, o)
      type(part_type), intent(in) :: p
      type(grid_tables), intent(in) :: whole_t
      type(mesh_type), intent(in) :: whole_m
      type(operators_type), intent(in) :: whole_o
      type(grid_tables), intent(out) :: t
      type(mesh_type), intent(out) :: m
      type(operators_type), intent(out) :: o
      integer(ip) :: cell_here(whole_m%cells), corner_here(whole_m%corners), edge_here(whole_m%edges)

      cell_here = inverse(p%cell, whole_m%cells)
      corner_here = inverse(p%corner, whole_m%corners)
      edge_here = inverse(p%edge, whole_m%edges)

      t%lon_center = whole_t%lon_center(p%cell)
      t%lat_center = whole_t%lat_center(p%cell)
      t%lon_corner = whole_t%lon_corner(p%corner)
      t%lat_corner = whole_t%lat_corner(p%corner)
      t%cell_corner = renumbered(whole_t%cell_corner, p%cell, corner_here)
      t%corner_cell = renumbered(whole_t%corner_cell, p%corner, cell_here)
      t%corner_edge = renumbered(whole_t%corner_edge, p%corner, edge_here)
      t%edge_corner = renumbered(whole_t%edge_corner, p%edge, corner_here)

      m%cells = size(p%cell)
      m%corners = size(p%corner)
      m%edges = size(p%edge)
      m%cells_in = p%cells_in
      m%corners_in = p%corners_in
      m%edges_in = p%edges_in
      m%center = whole_m%center(:, p%cell)
      m%corner = whole_m%corner(:, p%corner)
      m%middle = whole_m%middle(:, p%edge)
      m%normal = whole_m%normal(:, p%edge)
      m%edge_cell = renumbered(whole_m%edge_cell, p%edge, cell_here)
      m%edge_corner = renumbered(whole_m%edge_corner, p%edge, corner_here)
      m%corner_cell = renumbered(whole_m%corner_cell, p%corner, cell_here)
      m%corner_edge = renumbered(whole_m%corner_edge, p%corner, edge_here)
      m%corner_sign = whole_m%corner_sign(:, p%corner)
      m%cell_count = whole_m%cell_count(p%cell)
      m%cell_edge = renumbered(whole_m%cell_edge, p%cell, edge_here)
      m%cell_sign = whole_m%cell_sign(:, p%cell)
      m%dv = whole_m%dv(p%edge)
      m%dc = whole_m%dc(p%edge)
      m%kite = whole_m%kite(:, p%corner)
      m%cell_area = whole_m%cell_area(p%cell)
      m%corner_area = whole_m%corner_area(p%corner)
      m%coriolis = whole_m%coriolis(p%corner)

      o%divergence = whole_o%divergence(:, p%cell)
      o%kinetic = whole_o%kinetic(:, p%cell)
      o%curl = whole_o%curl(:, p%corner)
      o%share = whole_o%share(:, p%corner)
      o%other = renumbered(whole_o%other, p%edge, edge_here)
      o%weight = whole_o%weight(:, p%edge)
   end subroutine cut

   !> The number here of each in the whole mesh; 0 for what is not here.
   pure function inverse(numbers, total) result(here)
      integer(ip), intent(in) :: numbers(:)
      integer, intent(in) :: total
      integer(ip) :: here(total)
      integer :: i
      here = 0_ip
      here(numbers) = [(int(i, ip), i=1, size(numbers))]
   end function inverse

   !> Some rows of a table, with numbers of here in them.
   pure function renumbered(table, rows, here) result(part)
      integer(ip), intent(in) :: table(:, :), rows(:), here(:)
      integer(ip) :: part(size(table, 1), size(rows))
      integer :: i
      do i = 1, size(rows)
         part(:, i) = here(table(:, rows(i)))
      end do
   end function renumbered

   !> Collective: settles with the other ranks who sends what to whom. An edge or corner is owned by the rank of its first cell; all
   !> ranks compute those that touch their own cells, so only what lies farther out is sent. Corners are summed but not sent.
   subroutine share(p, owner, whole, m)
      type(part_type), intent(in) :: p
      integer, intent(in) :: owner(:)
      type(mesh_type), intent(in) :: whole
      type(mesh_type), intent(inout) :: m
      call new_pattern(whole%cells, p%cell, owner(p%cell), p%cells_in(0) + 1, p%cells_in(halo), m%by_cell)
      call new_pattern(whole%edges, p%edge, owner(whole%edge_cell(1, p%edge)), p%edges_in(0) + 1, p%edges_in(halo), m%by_edge)
      call new_pattern(whole%corners, p%corner, owner(whole%corner_cell(1, p%corner)), 1, 0, m%by_corner)
   end subroutine share

end module parts
