!> The state of the model, its step in time (classical Runge-Kutta, fourth order), and the integrals that it should keep.
module model
   use kinds, only: wp, gravity
   use mesh, only: mesh_type
   use operators, only: operators_type
   use ranks, only: exchange, largest_of_ranks
   use sums, only: sum_over_columns
   use trisk, only: workspace, new_workspace, tendencies, vorticity_at_corners, thickness_at_corners
   implicit none
   private
   public :: state_type, stepper_type, integrals_type, new_state, new_stepper, advance, integrate, largest_drift

   !> h and u stay where they are in memory for the whole run: icoray reads h in place.
   type :: state_type
      integer :: layers = 0
      real(wp), allocatable :: h(:, :)  !< (layers, cells), m
      real(wp), allocatable :: u(:, :)  !< (layers, edges), m/s along the edge's normal
   end type state_type

   !> Data of a step beside the state.
   type :: stepper_type
      type(workspace) :: work
      real(wp), allocatable :: h(:, :), u(:, :), dh(:, :), du(:, :), h_next(:, :), u_next(:, :)
   end type stepper_type

   !> Of each layer; the extremes of all.
   type :: integrals_type
      real(wp), allocatable :: mass(:)       !< m3 (of unit density)
      real(wp), allocatable :: energy(:)     !< kinetic and potential, m5/s2
      real(wp), allocatable :: kinetic(:)    !< the kinetic part
      real(wp), allocatable :: enstrophy(:)  !< potential, m/s2
      real(wp) :: lowest, highest            !< thickness, m
      real(wp) :: vorticity                  !< largest absolute relative vorticity, 1/s
   end type integrals_type

contains

   subroutine new_state(layers, m, s)
      integer, intent(in) :: layers
      type(mesh_type), intent(in) :: m
      type(state_type), intent(out) :: s
      s%layers = layers
      allocate (s%h(layers, m%cells), s%u(layers, m%edges), source=0.0_wp)
   end subroutine new_state

   subroutine new_stepper(s, m, r)
      type(state_type), intent(in) :: s
      type(mesh_type), intent(in) :: m
      type(stepper_type), intent(out) :: r
      call new_workspace(s%layers, m, r%work)
      allocate (r%h, r%dh, r%h_next, mold=s%h)
      allocate (r%u, r%du, r%u_next, mold=s%u)
   end subroutine new_stepper

   subroutine advance(m, o, dt, lead, s, r)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp), intent(in) :: dt, lead
      type(state_type), intent(inout) :: s
      type(stepper_type), intent(inout) :: r
      real(wp), parameter :: ahead(3) = [0.5_wp, 0.5_wp, 1.0_wp]  ! where stages 2 to 4 stand
      real(wp), parameter :: counts(4) = [1.0_wp, 2.0_wp, 2.0_wp, 1.0_wp]/6.0_wp
      integer :: stage, n_h, n_u

      n_h = s%layers*m%cells_in(0)
      n_u = s%layers*m%edges_in(0)
      call tendencies(s%layers, m, o, lead, s%h, s%u, r%work, r%dh, r%du)
      call add(n_h, s%h, counts(1)*dt, r%dh, r%h_next)
      call add(n_u, s%u, counts(1)*dt, r%du, r%u_next)
      do stage = 2, 4
         call add(n_h, s%h, ahead(stage - 1)*dt, r%dh, r%h)
         call add(n_u, s%u, ahead(stage - 1)*dt, r%du, r%u)
         call exchange(m%by_cell, r%h)
         call exchange(m%by_edge, r%u)
         call tendencies(s%layers, m, o, lead, r%h, r%u, r%work, r%dh, r%du)
         if (stage == 4) exit
         call accumulate(n_h, counts(stage)*dt, r%dh, r%h_next)
         call accumulate(n_u, counts(stage)*dt, r%du, r%u_next)
      end do
      call add(n_h, r%h_next, counts(4)*dt, r%dh, s%h)
      call add(n_u, r%u_next, counts(4)*dt, r%du, s%u)
      call exchange(m%by_cell, s%h)
      call exchange(m%by_edge, s%u)
   end subroutine advance

   subroutine add(n, a, factor, b, sum)
      integer, intent(in) :: n
      real(wp), intent(in) :: a(n), factor, b(n)
      real(wp), intent(out) :: sum(n)
      integer :: i
      !$omp parallel do
      do i = 1, n
         sum(i) = a(i) + factor*b(i)
      end do
   end subroutine add

   subroutine accumulate(n, factor, b, sum)
      integer, intent(in) :: n
      real(wp), intent(in) :: factor, b(n)
      real(wp), intent(inout) :: sum(n)
      integer :: i
      !$omp parallel do
      do i = 1, n
         sum(i) = sum(i) + factor*b(i)
      end do
   end subroutine accumulate

   !> Mass, energy and potential enstrophy as the scheme defines them. Collective; the same on all ranks.
   subroutine integrate(m, o, s, x)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      type(state_type), intent(in) :: s
      type(integrals_type), intent(out) :: x
      real(wp), allocatable :: vorticity(:, :), thickness(:, :), of_edge(:, :)
      integer :: e, v

      allocate (x%mass(s%layers), x%energy(s%layers), x%kinetic(s%layers), x%enstrophy(s%layers))
      allocate (vorticity(s%layers, m%corners), thickness(s%layers, m%corners), of_edge(s%layers, m%edges))
      call vorticity_at_corners(s%layers, m, o, s%u, vorticity)
      call thickness_at_corners(s%layers, m, o, s%h, thickness)
      x%lowest = -largest_of_ranks(-minval(s%h(:, :m%cells_in(0))))
      x%highest = largest_of_ranks(maxval(s%h(:, :m%cells_in(0))))
      x%vorticity = largest_of_ranks(maxval(abs(vorticity(:, :m%corners_in(0)))))
      do e = 1, m%edges_in(0)
         associate (a => m%edge_cell(:, e))
            of_edge(:, e) = (s%h(:, a(1)) + s%h(:, a(2)))*s%u(:, e)**2
         end associate
      end do
      do v = 1, m%corners_in(0)
         vorticity(:, v) = (m%coriolis(v) + vorticity(:, v))**2/thickness(:, v)
      end do
      call sum_over_columns(m%by_cell, m%cell_area, s%h, x%mass)
      call sum_over_columns(m%by_cell, 0.5_wp*gravity*m%cell_area, s%h**2, x%energy)
      call sum_over_columns(m%by_edge, 0.25_wp*m%dv*m%dc, of_edge, x%kinetic)
      x%energy = x%energy + x%kinetic
      call sum_over_columns(m%by_corner, 0.5_wp*m%corner_area, vorticity, x%enstrophy)
   end subroutine integrate

   !> The drift, relative to what was, of the layer that drifts most.
   pure real(wp) function largest_drift(now, before)
      real(wp), intent(in) :: now(:), before(:)
      real(wp) :: drift(size(now))
      drift = (now - before)/before
      largest_drift = drift(maxloc(abs(drift), dim=1))
   end function largest_drift

end module model
