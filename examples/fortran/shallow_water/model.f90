!> The state of the model, its step in time (classical Runge-Kutta, fourth order), and the integrals that it should keep.
module model
   use kinds, only: wp, gravity
   use mesh, only: mesh_type
   use operators, only: operators_type
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

   !> What a step needs beside the state.
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
      integer :: stage

      call tendencies(s%layers, m, o, lead, s%h, s%u, r%work, r%dh, r%du)
      call add(size(s%h), s%h, counts(1)*dt, r%dh, r%h_next)
      call add(size(s%u), s%u, counts(1)*dt, r%du, r%u_next)
      do stage = 2, 4
         call add(size(s%h), s%h, ahead(stage - 1)*dt, r%dh, r%h)
         call add(size(s%u), s%u, ahead(stage - 1)*dt, r%du, r%u)
         call tendencies(s%layers, m, o, lead, r%h, r%u, r%work, r%dh, r%du)
         if (stage == 4) exit
         call accumulate(size(s%h), counts(stage)*dt, r%dh, r%h_next)
         call accumulate(size(s%u), counts(stage)*dt, r%du, r%u_next)
      end do
      call add(size(s%h), r%h_next, counts(4)*dt, r%dh, s%h)
      call add(size(s%u), r%u_next, counts(4)*dt, r%du, s%u)
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

   !> Mass, energy and potential enstrophy as the scheme defines them.
   subroutine integrate(m, o, s, x)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      type(state_type), intent(in) :: s
      type(integrals_type), intent(out) :: x
      real(wp), allocatable :: vorticity(:, :), thickness(:, :)
      real(wp), dimension(s%layers) :: mass_rest, potential, potential_rest, kinetic_rest, enstrophy_rest
      integer :: c, e, v

      allocate (x%mass(s%layers), x%energy(s%layers), x%kinetic(s%layers), x%enstrophy(s%layers), source=0.0_wp)
      mass_rest = 0.0_wp
      potential = 0.0_wp
      potential_rest = 0.0_wp
      kinetic_rest = 0.0_wp
      enstrophy_rest = 0.0_wp
      allocate (vorticity(s%layers, m%corners), thickness(s%layers, m%corners))
      call vorticity_at_corners(s%layers, m, o, s%u, vorticity)
      call thickness_at_corners(s%layers, m, o, s%h, thickness)
      do c = 1, m%cells
         call add_term(m%cell_area(c)*s%h(:, c), x%mass, mass_rest)
         call add_term(m%cell_area(c)*0.5_wp*gravity*s%h(:, c)**2, potential, potential_rest)
      end do
      do e = 1, m%edges
         associate (a => m%edge_cell(:, e))
            call add_term(m%dv(e)*m%dc(e)*0.25_wp*(s%h(:, a(1)) + s%h(:, a(2)))*s%u(:, e)**2, x%kinetic, kinetic_rest)
         end associate
      end do
      x%energy = potential + x%kinetic
      do v = 1, m%corners
         call add_term(m%corner_area(v)*0.5_wp*(m%coriolis(v) + vorticity(:, v))**2/thickness(:, v), x%enstrophy, enstrophy_rest)
      end do
      x%lowest = minval(s%h)
      x%highest = maxval(s%h)
      x%vorticity = maxval(abs(vorticity))
   end subroutine integrate

   !> Kahan's sum: what an addition rounds off goes into the next. Else the sum of a mesh loses more than the model does.
   elemental subroutine add_term(term, sum, rest)
      real(wp), intent(in) :: term
      real(wp), intent(inout) :: sum, rest
      real(wp) :: new
      rest = rest + term
      new = sum + rest
      rest = rest - (new - sum)
      sum = new
   end subroutine add_term

   !> The drift, relative to what was, of the layer that drifts most.
   pure real(wp) function largest_drift(now, before)
      real(wp), intent(in) :: now(:), before(:)
      real(wp) :: drift(size(now))
      drift = (now - before)/before
      largest_drift = drift(maxloc(abs(drift), dim=1))
   end function largest_drift

end module model
