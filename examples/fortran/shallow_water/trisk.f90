!> Tendencies of the rotating shallow-water equations in vector-invariant form,
!>
!>   dh/dt = -div(h u)        du/dt = q (h u)_t - d/dn (g h + K)        q = (f + curl u) / h
!>
!> by TRiSK (Ringler, Thuburn, Klemp and Skamarock 2010, doi:10.1016/j.jcp.2009.12.007), the form that conserves energy: in
!> the flux of potential vorticity, each pair of edges sees the mean of its two q (their equation 49). h at centres, u normal
!> to the edges, q at corners; arrays are (layers, columns), each layer a fluid of its own, and every inner loop runs over
!> layers. Mass is conserved to rounding, and so is energy by these tendencies: only the time step loses some.
!>
!> With `lead` above 0, q at edges is what the flow brings within that time, q - lead u.grad q (the anticipated potential
!> vorticity of Sadourny and Basdevant 1985): it takes enstrophy from the smallest scales, and no energy.
!>
!> On a part of the mesh each loop goes as many rings outwards as those after it need, so that h and u in three rings give the
!> tendencies of the part's own cells and edges, and nothing else need be exchanged. What lies farther out is left as it was.
module trisk
   use kinds, only: wp, gravity
   use mesh, only: mesh_type, sides
   use operators, only: operators_type, others
   implicit none
   private
   public :: workspace, new_workspace, tendencies, vorticity_at_corners, thickness_at_corners

   !> Arrays that tendencies use between their loops.
   type :: workspace
      real(wp), allocatable :: flux(:, :), q_edge(:, :)  !< (layers, edges)
      real(wp), allocatable :: bernoulli(:, :)           !< (layers, cells); before, q averaged to cells
      real(wp), allocatable :: q(:, :)                   !< (layers, corners)
   end type workspace

contains

   subroutine new_workspace(layers, m, w)
      integer, intent(in) :: layers
      type(mesh_type), intent(in) :: m
      type(workspace), intent(out) :: w
      allocate (w%flux(layers, m%edges), w%q_edge(layers, m%edges), w%bernoulli(layers, m%cells), w%q(layers, m%corners), &
                source=0.0_wp)
   end subroutine new_workspace

   subroutine tendencies(n, m, o, lead, h, u, w, dh, du)
      integer, intent(in) :: n  !< layers
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp), intent(in) :: lead  !< s
      real(wp), intent(in) :: h(n, m%cells), u(n, m%edges)
      type(workspace), intent(inout) :: w
      real(wp), intent(out) :: dh(n, m%cells), du(n, m%edges)

      call potential_vorticity(n, m, o, h, u, w%q)
      call fluxes(n, m, h, u, w%q, w%flux, w%q_edge)
      if (lead > 0.0_wp) call anticipate(n, m, o, lead, u, w%q, w%bernoulli, w%q_edge)
      call cells(n, m, o, h, u, w%flux, w%bernoulli, dh)
      call edges(n, m, o, w%flux, w%q_edge, w%bernoulli, du)
   end subroutine tendencies

   !> Relative vorticity: circulation round each triangle by its area, 1/s.
   subroutine vorticity_at_corners(n, m, o, u, vorticity)
      integer, intent(in) :: n
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp), intent(in) :: u(n, m%edges)
      real(wp), intent(out) :: vorticity(n, m%corners)
      integer :: v, k
      !$omp parallel do private(k)
      do v = 1, m%corners_in(2)
         associate (e => m%corner_edge(:, v), a => o%curl(:, v))
            do k = 1, n
               vorticity(k, v) = a(1)*u(k, e(1)) + a(2)*u(k, e(2)) + a(3)*u(k, e(3))
            end do
         end associate
      end do
   end subroutine vorticity_at_corners

   !> Thickness of the fluid over each triangle, from the kites of its cells.
   subroutine thickness_at_corners(n, m, o, h, thickness)
      integer, intent(in) :: n
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp), intent(in) :: h(n, m%cells)
      real(wp), intent(out) :: thickness(n, m%corners)
      integer :: v, k
      !$omp parallel do private(k)
      do v = 1, m%corners_in(2)
         associate (c => m%corner_cell(:, v), s => o%share(:, v))
            do k = 1, n
               thickness(k, v) = s(1)*h(k, c(1)) + s(2)*h(k, c(2)) + s(3)*h(k, c(3))
            end do
         end associate
      end do
   end subroutine thickness_at_corners

   subroutine potential_vorticity(n, m, o, h, u, q)
      integer, intent(in) :: n
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp), intent(in) :: h(n, m%cells), u(n, m%edges)
      real(wp), intent(out) :: q(n, m%corners)
      integer :: v, k
      !$omp parallel do private(k)
      do v = 1, m%corners_in(2)
         associate (c => m%corner_cell(:, v), s => o%share(:, v), e => m%corner_edge(:, v), a => o%curl(:, v))
            do k = 1, n
               q(k, v) = (m%coriolis(v) + a(1)*u(k, e(1)) + a(2)*u(k, e(2)) + a(3)*u(k, e(3))) &
                         /(s(1)*h(k, c(1)) + s(2)*h(k, c(2)) + s(3)*h(k, c(3)))
            end do
         end associate
      end do
   end subroutine potential_vorticity

   !> Mass flux h u and potential vorticity at edges.
   subroutine fluxes(n, m, h, u, q, flux, q_edge)
      integer, intent(in) :: n
      type(mesh_type), intent(in) :: m
      real(wp), intent(in) :: h(n, m%cells), u(n, m%edges), q(n, m%corners)
      real(wp), intent(out) :: flux(n, m%edges), q_edge(n, m%edges)
      integer :: e, k
      !$omp parallel do private(k)
      do e = 1, m%edges_in(1)
         associate (c => m%edge_cell(:, e), v => m%edge_corner(:, e))
            do k = 1, n
               flux(k, e) = 0.5_wp*(h(k, c(1)) + h(k, c(2)))*u(k, e)
               q_edge(k, e) = 0.5_wp*(q(k, v(1)) + q(k, v(2)))
            end do
         end associate
      end do
   end subroutine fluxes

   !> Takes lead * u.grad q from q at edges; its slope across an edge is that of its averages over the two cells.
   subroutine anticipate(n, m, o, lead, u, q, q_cell, q_edge)
      integer, intent(in) :: n
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp), intent(in) :: lead
      real(wp), intent(in) :: u(n, m%edges), q(n, m%corners)
      real(wp), intent(inout) :: q_cell(n, m%cells), q_edge(n, m%edges)
      real(wp) :: along(n)
      integer :: c, e, j, k, v

      !$omp parallel do private(e, j, k, v)
      do c = 1, m%cells_in(2)
         q_cell(:, c) = 0.0_wp
         do j = 1, m%cell_count(c)
            e = m%cell_edge(j, c)
            v = m%edge_corner(merge(2, 1, m%cell_sign(j, c) > 0.0_wp), e)
            do k = 1, n
               q_cell(k, c) = q_cell(k, c) + q(k, v)
            end do
         end do
         q_cell(:, c) = q_cell(:, c)/m%cell_count(c)
      end do
      !$omp parallel do private(along, j, k)
      do e = 1, m%edges_in(1)
         along = 0.0_wp
         do j = 1, others, 2
            associate (a => o%other(j, e), b => o%other(j + 1, e), wa => o%weight(j, e), wb => o%weight(j + 1, e))
               do k = 1, n
                  along(k) = along(k) + wa*u(k, a) + wb*u(k, b)
               end do
            end associate
         end do
         associate (a => m%edge_cell(:, e), b => m%edge_corner(:, e))
            do k = 1, n
               q_edge(k, e) = q_edge(k, e) - lead*(u(k, e)*(q_cell(k, a(2)) - q_cell(k, a(1)))/m%dc(e) &
                                                   + along(k)*(q(k, b(2)) - q(k, b(1)))/m%dv(e))
            end do
         end associate
      end do
   end subroutine anticipate

   !> dh/dt and the Bernoulli function g h + K.
   subroutine cells(n, m, o, h, u, flux, bernoulli, dh)
      integer, intent(in) :: n
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp), intent(in) :: h(n, m%cells), u(n, m%edges), flux(n, m%edges)
      real(wp), intent(out) :: bernoulli(n, m%cells), dh(n, m%cells)
      integer :: c, j, k
      !$omp parallel do private(j, k)
      do c = 1, m%cells_in(1)
         bernoulli(:, c) = gravity*h(:, c)
         dh(:, c) = 0.0_wp
         do j = 1, sides
            associate (e => m%cell_edge(j, c), a => o%divergence(j, c), b => o%kinetic(j, c))
               do k = 1, n
                  dh(k, c) = dh(k, c) - a*flux(k, e)
                  bernoulli(k, c) = bernoulli(k, c) + b*u(k, e)**2
               end do
            end associate
         end do
      end do
   end subroutine cells

   !> du/dt: the flux of potential vorticity along the edge less the slope of the Bernoulli function across it.
   subroutine edges(n, m, o, flux, q_edge, bernoulli, du)
      integer, intent(in) :: n
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp), intent(in) :: flux(n, m%edges), q_edge(n, m%edges), bernoulli(n, m%cells)
      real(wp), intent(out) :: du(n, m%edges)
      real(wp) :: force(n), q(n)
      integer :: e, j, k
      !$omp parallel do private(force, q, j, k)
      do e = 1, m%edges_in(0)
         associate (c => m%edge_cell(:, e))
            do k = 1, n
               force(k) = (bernoulli(k, c(1)) - bernoulli(k, c(2)))/m%dc(e)
               q(k) = q_edge(k, e)
            end do
         end associate
         do j = 1, others, 2
            associate (a => o%other(j, e), b => o%other(j + 1, e), wa => 0.5_wp*o%weight(j, e), wb => 0.5_wp*o%weight(j + 1, e))
               do k = 1, n
                  force(k) = force(k) + wa*(q(k) + q_edge(k, a))*flux(k, a) + wb*(q(k) + q_edge(k, b))*flux(k, b)
               end do
            end associate
         end do
         do k = 1, n
            du(k, e) = force(k)
         end do
      end do
   end subroutine edges

end module trisk
