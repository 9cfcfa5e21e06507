!> Case 2 of Williamson et al. 1992 (doi:10.1016/S0021-9991(05)80016-6): steady zonal flow in geostrophic balance. The
!> initial state is the exact solution for ever, so any change of the height is error.
module williamson2
   use kinds, only: wp, pi, radius, omega, gravity, day
   use mesh, only: mesh_type
   use model, only: state_type
   use ranks, only: largest_of_ranks
   use sums, only: sum_over_columns
   implicit none
   private
   public :: williamson2_state, height_error

   real(wp), parameter :: wind = 2.0_wp*pi*radius/(12.0_wp*day)  ! at the equator, m/s
   real(wp), parameter :: geopotential = 2.94e4_wp               ! there, m2/s2

contains

   subroutine williamson2_state(m, s)
      type(mesh_type), intent(in) :: m
      type(state_type), intent(inout) :: s
      integer :: c, e
      do e = 1, m%edges
         associate (a => m%edge_corner(:, e))
            s%u(:, e) = wind*radius*(m%corner(3, a(2)) - m%corner(3, a(1)))/m%dv(e)
         end associate
      end do
      do c = 1, m%cells
         s%h(:, c) = height(m%center(3, c))
      end do
   end subroutine williamson2_state

   pure real(wp) function height(sine)
      real(wp), intent(in) :: sine  !< of the latitude
      height = (geopotential - (radius*omega*wind + 0.5_wp*wind**2)*sine**2)/gravity
   end function height

   !> l2 norm of the height's error by that of the height, and the same of the largest values; of the first layer. Collective.
   subroutine height_error(m, s, l2, largest)
      type(mesh_type), intent(in) :: m
      type(state_type), intent(in) :: s
      real(wp), intent(out) :: l2, largest
      real(wp) :: exact(1, m%cells), wrong(1, m%cells), squares(2)
      integer :: c
      do c = 1, m%cells
         exact(1, c) = height(m%center(3, c))
         wrong(1, c) = s%h(1, c) - exact(1, c)
      end do
      call sum_over_columns(m%by_cell, m%cell_area, wrong**2, squares(1:1))
      call sum_over_columns(m%by_cell, m%cell_area, exact**2, squares(2:2))
      l2 = sqrt(squares(1)/squares(2))
      largest = largest_of_ranks(maxval(abs(wrong)))/largest_of_ranks(maxval(exact))
   end subroutine height_error

end module williamson2
