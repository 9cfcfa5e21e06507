!> Everything that the scheme needs of a Voronoi mesh, derived from the six tables with no trust in the order of their rows
!> or the way that they wind. Every edge gets a normal, from its cell 1 to its cell 2, and a tangent = up x normal, from its
!> corner 1 to its corner 2. Work and memory are linear in the number of cells. Lengths and areas are the sphere's, in m.
module mesh
   use kinds, only: wp, radius, omega
   use sphere, only: place_at, unit, cross, angle, triangle_area
   use tables, only: grid_tables
   use ranks, only: pattern_type
   implicit none
   private
   public :: mesh_type, derive

   integer, parameter, public :: sides = 6  !< most edges of a cell
   integer, parameter, public :: halo = 3   !< rings of cells around a rank's own that their tendencies depend on

   !> The whole mesh, or a rank's part of it (parts.f90): its own cells, then those of the first ring around them, and so on. What
   !> touches a cell of at most the r-th ring comes first in the arrays, as many as `.._in(r)` says; only in the last ring are
   !> neighbours missing, and their numbers 0. In a whole mesh all is in ring 0.
   type :: mesh_type
      integer :: cells, corners, edges
      integer :: cells_in(0:halo), corners_in(0:halo), edges_in(0:halo)
      type(pattern_type) :: by_cell, by_corner, by_edge  !< how ranks share them; not set in a whole mesh
      real(wp), allocatable :: center(:, :), corner(:, :), middle(:, :)    !< unit vectors (3, n); middles of the edges
      real(wp), allocatable :: normal(:, :)                                !< of each edge at its middle (3, edges)
      integer, allocatable :: edge_cell(:, :), edge_corner(:, :)           !< (2, edges), in the order above
      integer, allocatable :: corner_cell(:, :), corner_edge(:, :)         !< (3, corners)
      real(wp), allocatable :: corner_sign(:, :)  !< (3, corners): 1 where the edge's normal goes counter-clockwise round it
      integer, allocatable :: cell_count(:)                                !< edges of each cell, 5 or 6
      integer, allocatable :: cell_edge(:, :)     !< (6, cells), counter-clockwise; a pentagon's sixth repeats its first
      real(wp), allocatable :: cell_sign(:, :)    !< (6, cells): 1 where the normal points out, -1 in, 0 past the count
      real(wp), allocatable :: dv(:), dc(:)       !< length of each edge; distance of the centres on its sides
      real(wp), allocatable :: kite(:, :)         !< (3, corners): the part of cell corner_cell(i, v) next to corner v
      real(wp), allocatable :: cell_area(:), corner_area(:)                !< sums of kites: polygons and triangles
      real(wp), allocatable :: coriolis(:)                                 !< f at corners, 1/s
   end type mesh_type

contains

   subroutine derive(t, m)
      type(grid_tables), intent(in) :: t
      type(mesh_type), intent(out) :: m
      integer :: i

      m%cells = size(t%lon_center)
      m%corners = size(t%lon_corner)
      m%edges = size(t%edge_corner, 2)
      m%cells_in = m%cells
      m%corners_in = m%corners
      m%edges_in = m%edges
      allocate (m%center(3, m%cells), m%corner(3, m%corners))
      do i = 1, m%cells
         m%center(:, i) = place_at(t%lon_center(i), t%lat_center(i))
      end do
      do i = 1, m%corners
         m%corner(:, i) = place_at(t%lon_corner(i), t%lat_corner(i))
      end do
      m%corner_cell = t%corner_cell
      m%corner_edge = t%corner_edge
      m%edge_corner = t%edge_corner
      m%coriolis = 2.0_wp*omega*sin(t%lat_corner)
      call orient_edges(m)
      call sort_cells(m)
      call measure(m)
   end subroutine derive

   !> Finds the two cells of each edge, those that its two corners share, and turns its corners to run to the left of the
   !> normal.
   subroutine orient_edges(m)
      type(mesh_type), intent(inout) :: m
      integer :: e, i, j, found
      real(wp) :: ahead(3)

      allocate (m%edge_cell(2, m%edges), m%normal(3, m%edges), m%middle(3, m%edges), m%dv(m%edges), m%dc(m%edges))
      do e = 1, m%edges
         found = 0
         do i = 1, 3
            do j = 1, 3
               if (m%corner_cell(i, m%edge_corner(1, e)) /= m%corner_cell(j, m%edge_corner(2, e))) cycle
               found = found + 1
               if (found <= 2) m%edge_cell(found, e) = m%corner_cell(i, m%edge_corner(1, e))
            end do
         end do
         if (found /= 2) error stop 'shallow_water: an edge without two cells'
         associate (a => m%center(:, m%edge_cell(1, e)), b => m%center(:, m%edge_cell(2, e)))
            m%middle(:, e) = unit(a + b)
            ahead = unit(b - a)                 ! at the middle of the arc this is the sphere's tangent
            m%normal(:, e) = ahead
            m%dc(e) = radius*angle(a, b)
         end associate
         associate (c => m%edge_corner(:, e))
            if (dot_product(cross(m%middle(:, e), ahead), m%corner(:, c(2)) - m%corner(:, c(1))) < 0.0_wp) c = c([2, 1])
            m%dv(e) = radius*angle(m%corner(:, c(1)), m%corner(:, c(2)))
         end associate
      end do
   end subroutine orient_edges

   !> Lists the edges of each cell counter-clockwise: the next one is the other edge of the same cell at the corner ahead.
   subroutine sort_cells(m)
      type(mesh_type), intent(inout) :: m
      integer :: e, c, i, j, v, next

      allocate (m%cell_count(m%cells), source=0)
      allocate (m%cell_edge(sides, m%cells), source=0)
      allocate (m%cell_sign(sides, m%cells), source=0.0_wp)
      do e = 1, m%edges
         do i = 1, 2
            c = m%edge_cell(i, e)
            m%cell_count(c) = m%cell_count(c) + 1
            if (m%cell_count(c) > sides) error stop 'shallow_water: a cell with more than 6 edges'
            m%cell_edge(1, c) = e
         end do
      end do
      do c = 1, m%cells
         e = m%cell_edge(1, c)
         do j = 1, m%cell_count(c)
            m%cell_edge(j, c) = e
            m%cell_sign(j, c) = merge(1.0_wp, -1.0_wp, m%edge_cell(1, e) == c)
            v = corner_ahead(m, c, e)
            next = 0
            do i = 1, 3
               if (m%corner_edge(i, v) /= e .and. any(m%edge_cell(:, m%corner_edge(i, v)) == c)) next = m%corner_edge(i, v)
            end do
            if (next == 0) error stop 'shallow_water: corner_edge contradicts corner_cell'
            e = next
         end do
         if (e /= m%cell_edge(1, c)) error stop 'shallow_water: the edges of a cell do not close'
         m%cell_edge(m%cell_count(c) + 1:, c) = e
      end do
   end subroutine sort_cells

   !> The corner at the counter-clockwise end of edge e of cell c.
   pure integer function corner_ahead(m, c, e)
      type(mesh_type), intent(in) :: m
      integer, intent(in) :: c, e
      corner_ahead = merge(m%edge_corner(2, e), m%edge_corner(1, e), m%edge_cell(1, e) == c)
   end function corner_ahead

   !> Kites, their sums, and the signs of circulation. The kite of a cell and a corner has two more vertices: the middles of
   !> the cell's edges that meet there.
   subroutine measure(m)
      type(mesh_type), intent(inout) :: m
      integer :: v, i, j, e, c
      real(wp) :: area

      allocate (m%kite(3, m%corners), m%corner_sign(3, m%corners), m%corner_area(m%corners))
      allocate (m%cell_area(m%cells), source=0.0_wp)
      do v = 1, m%corners
         do i = 1, 3
            c = m%corner_cell(i, v)
            m%kite(i, v) = 0.0_wp
            do j = 1, 3
               e = m%corner_edge(j, v)
               if (all(m%edge_cell(:, e) /= c)) cycle
               area = triangle_area(m%center(:, c), m%middle(:, e), m%corner(:, v))  ! v ahead of e's middle: positive
               m%kite(i, v) = m%kite(i, v) + radius**2*merge(area, -area, corner_ahead(m, c, e) == v)
            end do
            if (m%kite(i, v) <= 0.0_wp) error stop 'shallow_water: not a Voronoi mesh with its edges across: a kite is void'
            m%cell_area(c) = m%cell_area(c) + m%kite(i, v)
            e = m%corner_edge(i, v)
            m%corner_sign(i, v) = merge(1.0_wp, -1.0_wp, m%edge_corner(2, e) == v)
         end do
         m%corner_area(v) = sum(m%kite(:, v))
      end do
   end subroutine measure

end module mesh
