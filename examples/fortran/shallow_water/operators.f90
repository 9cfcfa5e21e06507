!> The discrete operators of TRiSK as coefficients on rows of the mesh's tables, computed once:
!>
!>   divergence at a cell        sum over its edges of       divergence * u
!>   kinetic energy at a cell    sum over its edges of       kinetic * u**2
!>   vorticity at a corner       sum over its 3 edges of     curl * u
!>   thickness at a corner       sum over its 3 cells of     share * h
!>   tangential flow at an edge  sum over 10 other edges of  weight * u
!>
!> The last is that of Thuburn, Ringler, Skamarock and Klemp 2009 (doi:10.1016/j.jcp.2009.08.006): with R the part of a
!> cell's area in the kites of its corners, edge e' of cell c adds +-(1/2 - sum of R from e to e') dv(e')/dc(e). It makes the
!> divergence of the tangential flow on a triangle the average, by kites, of that on its cells (so geostrophic modes stay put),
!> and weight(e, e') dc(e)/dv(e') is antisymmetric (so the Coriolis force does no work).
module operators
   use kinds, only: wp
   use mesh, only: mesh_type, sides
   implicit none
   private
   public :: operators_type, prepare

   integer, parameter, public :: others = 2*(sides - 1)  !< most edges of the two cells of an edge, itself left out

   type :: operators_type
      real(wp), allocatable :: divergence(:, :), kinetic(:, :)  !< (6, cells)
      real(wp), allocatable :: curl(:, :), share(:, :)          !< (3, corners)
      integer, allocatable :: other(:, :)                       !< (10, edges); the edge itself where there are fewer
      real(wp), allocatable :: weight(:, :)                     !< (10, edges); 0 there
   end type operators_type

contains

   subroutine prepare(m, o)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(out) :: o
      integer :: c, j, v

      allocate (o%divergence(sides, m%cells), o%kinetic(sides, m%cells), o%curl(3, m%corners), o%share(3, m%corners))
      do c = 1, m%cells
         do j = 1, sides
            associate (e => m%cell_edge(j, c), s => m%cell_sign(j, c))
               o%divergence(j, c) = s*m%dv(e)/m%cell_area(c)
               o%kinetic(j, c) = abs(s)*m%dv(e)*m%dc(e)/(4.0_wp*m%cell_area(c))
            end associate
         end do
      end do
      do v = 1, m%corners
         o%curl(:, v) = m%corner_sign(:, v)*m%dc(m%corner_edge(:, v))/m%corner_area(v)
         o%share(:, v) = m%kite(:, v)/m%corner_area(v)
      end do
      call prepare_weights(m, o)
   end subroutine prepare

   !> Walks counter-clockwise round both cells of each edge, from the edge on.
   subroutine prepare_weights(m, o)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(inout) :: o
      integer :: e, i, j, c, n, start, at, found
      real(wp), allocatable :: part(:, :)
      real(wp) :: passed

      call prepare_parts(m, part)
      allocate (o%weight(others, m%edges), source=0.0_wp)
      allocate (o%other(others, m%edges))
      do e = 1, m%edges
         o%other(:, e) = e
         found = 0
         do i = 1, 2
            c = m%edge_cell(i, e)
            n = m%cell_count(c)
            start = findloc(m%cell_edge(:n, c), e, dim=1)
            passed = 0.0_wp
            do j = 1, n - 1
               passed = passed + part(modulo(start + j - 2, n) + 1, c)
               at = modulo(start + j - 1, n) + 1
               found = found + 1
               o%other(found, e) = m%cell_edge(at, c)
               o%weight(found, e) = m%cell_sign(start, c)*m%cell_sign(at, c)*(0.5_wp - passed) &
                                    *m%dv(m%cell_edge(at, c))/m%dc(e)
            end do
         end do
      end do
   end subroutine prepare_weights

   !> part(j, c): the share of cell c's area in the kite at the counter-clockwise end of its edge j.
   subroutine prepare_parts(m, part)
      type(mesh_type), intent(in) :: m
      real(wp), allocatable, intent(out) :: part(:, :)
      integer :: c, i, j, v

      allocate (part(sides, m%cells), source=0.0_wp)
      do v = 1, m%corners
         do i = 1, 3
            c = m%corner_cell(i, v)
            do j = 1, m%cell_count(c)
               associate (e => m%cell_edge(j, c))
                  if (m%edge_corner(merge(2, 1, m%cell_sign(j, c) > 0.0_wp), e) /= v) cycle
               end associate
               part(j, c) = m%kite(i, v)/m%cell_area(c)
            end do
         end do
      end do
   end subroutine prepare_parts

end module operators
