!> `--self-test`: properties that mesh and operators have exactly, to rounding, and one that they have in the limit; and that
!> parts of the mesh do as the whole (part_checks.f90). Each rank checks the whole mesh, and all together their parts.
module checks
   use kinds, only: wp, pi, radius, gravity
   use sphere, only: unit, cross
   use tables, only: grid_tables, generate, relax
   use mesh, only: mesh_type, derive
   use operators, only: operators_type, prepare, others
   use checking, only: check, noise, rounding
   use part_checks, only: check_parts
   use ranks, only: rank
   use trisk, only: workspace, new_workspace, tendencies, vorticity_at_corners, thickness_at_corners
   implicit none
   private
   public :: self_test

contains

   !> True where all is well, on all ranks.
   logical function self_test(level, lloyd) result(well)
      integer, intent(in) :: level, lloyd
      type(grid_tables) :: t, coarse_t
      type(mesh_type) :: m, coarse
      type(operators_type) :: o, coarse_o
      real(wp) :: errors(2), coarse_errors(2), unused(2)

      call generate(level, t)
      call relax(t, lloyd, unused(1), unused(2))
      call derive(t, m)
      call prepare(m, o)
      call generate(level - 1, coarse_t)
      call relax(coarse_t, lloyd, unused(1), unused(2))
      call derive(coarse_t, coarse)
      call prepare(coarse, coarse_o)

      well = .true.
      call geometry(m, well)
      call check('the weights of the tangential flow are antisymmetric', asymmetry(m, o), 1.0e-11_wp, well)
      call check('the tangential flow diverges as the flow does, averaged by kites', compatibility(m, o), rounding, well)
      call check('the vorticity of a gradient is zero', curl_of_gradient(m, o), rounding, well)
      errors = constant_vector(m, o)
      coarse_errors = constant_vector(coarse, coarse_o)
      call check('a constant vector''s tangential part, l2 error', errors(1), 0.05_wp, well)
      call check('... the largest error', errors(2), 0.2_wp, well)
      call check('... 0.4 less the order of the l2 error', 0.4_wp - log(coarse_errors(1)/errors(1))/log(2.0_wp), 0.0_wp, well)
      call budgets(m, o, 0.0_wp, '', well)
      call budgets(m, o, 1000.0_wp, ' with anticipation', well)
      call uniform_vorticity(m, o, well)
      call check_parts(t, m, o, well)
      if (rank == 0) write (*, '(2a)') 'self-test ', merge('passed', 'FAILED', well)
   end function self_test

   subroutine geometry(m, well)
      type(mesh_type), intent(in) :: m
      logical, intent(inout) :: well
      real(wp) :: skew, sphere_area
      integer :: e

      sphere_area = 4.0_wp*pi*radius**2
      skew = 0.0_wp
      do e = 1, m%edges
         skew = max(skew, abs(dot_product(m%normal(:, e), &
                                          unit(m%corner(:, m%edge_corner(2, e)) - m%corner(:, m%edge_corner(1, e))))))
      end do
      call check('cells - edges + corners = 2', abs(real(m%cells - m%edges + m%corners - 2, wp)), 0.0_wp, well)
      call check('12 pentagons', abs(real(count(m%cell_count == 5) - 12, wp)), 0.0_wp, well)
      call check('cells cover the sphere', abs(sum(m%cell_area)/sphere_area - 1.0_wp), rounding, well)
      call check('triangles cover the sphere', abs(sum(m%corner_area)/sphere_area - 1.0_wp), rounding, well)
      call check('edges stand upright on the lines between centres', skew, 1.0e-10_wp, well)
   end subroutine geometry

   !> weight(e, a) dc(e) dv(e) + weight(a, e) dc(a) dv(a), by the larger dv squared.
   real(wp) function asymmetry(m, o)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp) :: there, back
      integer :: e, j, i
      asymmetry = 0.0_wp
      do e = 1, m%edges
         do j = 1, others
            associate (a => o%other(j, e))
               if (a == e) cycle
               there = o%weight(j, e)*m%dc(e)*m%dv(e)
               back = 0.0_wp
               do i = 1, others
                  if (o%other(i, a) == e) back = back + o%weight(i, a)*m%dc(a)*m%dv(a)
               end do
               asymmetry = max(asymmetry, abs(there + back)/max(m%dv(e), m%dv(a))**2)
            end associate
         end do
      end do
   end function asymmetry

   !> Thuburn et al. 2009: the property from which the weights follow.
   real(wp) function compatibility(m, o)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp) :: u(m%edges), along(m%edges), divergence(m%cells), left, right
      integer :: i, c, v, e
      u = noise([(i, i=1, m%edges)])
      do e = 1, m%edges
         along(e) = sum(o%weight(:, e)*u(o%other(:, e)))
      end do
      do c = 1, m%cells
         divergence(c) = sum(o%divergence(:, c)*u(m%cell_edge(:, c)))
      end do
      compatibility = 0.0_wp
      do v = 1, m%corners
         ! along runs towards its second corner: into the triangle where corner_sign is 1
         left = -sum(m%corner_sign(:, v)*m%dc(m%corner_edge(:, v))*along(m%corner_edge(:, v)))
         right = sum(m%kite(:, v)*divergence(m%corner_cell(:, v)))
         compatibility = max(compatibility, abs(left - right)/maxval(m%dc(m%corner_edge(:, v))))
      end do
   end function compatibility

   real(wp) function curl_of_gradient(m, o)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp) :: hill(m%cells), slope(1, m%edges), vorticity(1, m%corners)
      integer :: i
      hill = noise([(i, i=1, m%cells)])
      slope(1, :) = (hill(m%edge_cell(2, :)) - hill(m%edge_cell(1, :)))/m%dc
      call vorticity_at_corners(1, m, o, slope, vorticity)
      curl_of_gradient = maxval(abs(vorticity(1, :))*m%corner_area)/maxval(abs(hill))
   end function curl_of_gradient

   !> The tangential part of a vector that is constant in space, from its normal parts: l2 and largest error, by the vector's
   !> length. (Exact on a plane of equal hexagons; here the largest error need not vanish with the cells.)
   function constant_vector(m, o) result(errors)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp) :: errors(2), vector(3), u(m%edges), wrong, area
      integer :: e
      vector = unit([0.3_wp, -0.5_wp, 0.8_wp])
      do e = 1, m%edges
         u(e) = dot_product(vector, m%normal(:, e))
      end do
      errors = 0.0_wp
      area = 0.0_wp
      do e = 1, m%edges
         wrong = abs(sum(o%weight(:, e)*u(o%other(:, e))) - dot_product(vector, cross(m%middle(:, e), m%normal(:, e))))
         errors = [errors(1) + m%dv(e)*m%dc(e)*wrong**2, max(errors(2), wrong)]
         area = area + m%dv(e)*m%dc(e)
      end do
      errors(1) = sqrt(errors(1)/area)
   end function constant_vector

   !> The tendencies of a noisy flow neither make mass nor energy: sums by sums of magnitudes.
   subroutine budgets(m, o, lead, how, well)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      real(wp), intent(in) :: lead
      character(*), intent(in) :: how
      logical, intent(inout) :: well
      type(workspace) :: w
      real(wp) :: h(1, m%cells), u(1, m%edges), dh(1, m%cells), du(1, m%edges), of_cell(m%cells), of_edge(m%edges)
      integer :: i, c
      h(1, :) = 10000.0_wp + 1000.0_wp*noise([(i, i=1, m%cells)])
      u(1, :) = 50.0_wp*noise([(i, i=1, m%edges)])
      call new_workspace(1, m, w)
      call tendencies(1, m, o, lead, h, u, w, dh, du)
      of_cell = m%cell_area*dh(1, :)
      call check('no mass is made'//how, abs(sum(of_cell))/sum(abs(of_cell)), rounding, well)
      do c = 1, m%cells
         of_cell(c) = of_cell(c)*(gravity*h(1, c) + sum(o%kinetic(:, c)*u(1, m%cell_edge(:, c))**2))
      end do
      of_edge = 0.5_wp*m%dv*m%dc*(h(1, m%edge_cell(1, :)) + h(1, m%edge_cell(2, :)))*u(1, :)*du(1, :)
      call check('no energy is made'//how, abs(sum(of_cell) + sum(of_edge))/(sum(abs(of_cell)) + sum(abs(of_edge))), &
                 rounding, well)
   end subroutine budgets

   !> Uniform potential vorticity q stays uniform in any flow: absolute vorticity changes by q times the change of
   !> thickness. A fitted Coriolis parameter gives a noisy flow uniform q.
   subroutine uniform_vorticity(m, o, well)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      logical, intent(inout) :: well
      real(wp), parameter :: q = 1.0e-8_wp
      type(mesh_type) :: fitted
      type(workspace) :: w
      real(wp) :: h(1, m%cells), u(1, m%edges), dh(1, m%cells), du(1, m%edges), thickness(1, m%corners), vorticity(1, m%corners)
      integer :: i
      h(1, :) = 10000.0_wp + 1000.0_wp*noise([(i, i=1, m%cells)])
      u(1, :) = 50.0_wp*noise([(i, i=1, m%edges)])
      call thickness_at_corners(1, m, o, h, thickness)
      call vorticity_at_corners(1, m, o, u, vorticity)
      fitted = m
      fitted%coriolis = q*thickness(1, :) - vorticity(1, :)
      call new_workspace(1, m, w)
      call tendencies(1, fitted, o, 1000.0_wp, h, u, w, dh, du)
      call thickness_at_corners(1, m, o, dh, thickness)
      call vorticity_at_corners(1, m, o, du, vorticity)
      call check('uniform potential vorticity stays uniform', &
                 maxval(abs(vorticity - q*thickness))/maxval(abs(q*thickness)), 1.0e-10_wp, well)
   end subroutine uniform_vorticity

end module checks
