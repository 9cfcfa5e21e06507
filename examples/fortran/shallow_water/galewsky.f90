!> The initial state of Galewsky, Scott and Polvani 2004 (doi:10.3402/tellusa.v16i5.14436): a zonal jet in the northern
!> mid-latitudes, the height in balance with it, and a bump of 120 m that sets its barotropic instability off. Each layer has a
!> jet of its own strength, `u_max`, balanced for itself.
module galewsky
   use kinds, only: wp, pi, radius, omega, gravity
   use sphere, only: latitude, longitude
   use mesh, only: mesh_type
   use model, only: state_type
   implicit none
   private
   public :: galewsky_mean, galewsky_state

   real(wp), parameter :: south = pi/7.0_wp, north = pi/2.0_wp - south  ! where the jet ends
   real(wp), parameter :: mean_height = 10000.0_wp                      ! over the sphere, m
   real(wp), parameter :: bump_height = 120.0_wp, bump_latitude = pi/4.0_wp
   real(wp), parameter :: bump_east = 1.0_wp/3.0_wp, bump_north = 1.0_wp/15.0_wp

   integer, parameter :: panels = 200
   real(wp), parameter :: panel = (north - south)/panels

   !> Integrals from the jet's south on: of the wind, of wind times f, of wind squared times tan(latitude); for a jet of 1 m/s.
   type :: jet_integrals
      real(wp) :: at(3, 0:panels)
   end type jet_integrals

contains

   !> The mean of each layer's balanced heights over the whole mesh.
   subroutine galewsky_mean(m, u_max, mean)
      type(mesh_type), intent(in) :: m
      real(wp), intent(in) :: u_max(:)  !< of each layer, m/s
      real(wp), intent(out) :: mean(:)  !< m
      type(jet_integrals) :: jet
      integer :: c
      call integrate_jet(jet)
      mean = 0.0_wp
      do c = 1, m%cells
         mean = mean + m%cell_area(c)*balanced(jet, u_max, latitude(m%center(:, c)))
      end do
      mean = mean/sum(m%cell_area)
   end subroutine galewsky_mean

   subroutine galewsky_state(m, u_max, mean, s)
      type(mesh_type), intent(in) :: m
      real(wp), intent(in) :: u_max(:), mean(:)
      type(state_type), intent(inout) :: s
      type(jet_integrals) :: jet
      real(wp) :: lat, lon, i(3), transport(m%corners)
      integer :: c, e, v

      call integrate_jet(jet)
      ! The wind is that of a stream function at corners, so that it diverges nowhere, not even by the discrete operator.
      do v = 1, m%corners
         i = integrals_at(jet, latitude(m%corner(:, v)))
         transport(v) = radius*i(1)
      end do
      do e = 1, m%edges
         associate (a => m%edge_corner(:, e))
            s%u(:, e) = u_max*(transport(a(2)) - transport(a(1)))/m%dv(e)
         end associate
      end do
      do c = 1, m%cells
         lat = latitude(m%center(:, c))
         lon = longitude(m%center(:, c))
         if (lon > pi) lon = lon - 2.0_wp*pi
         s%h(:, c) = balanced(jet, u_max, lat) + mean_height - mean &
                     + bump_height*cos(lat)*exp(-(lon/bump_east)**2 - ((bump_latitude - lat)/bump_north)**2)
      end do
   end subroutine galewsky_state

   !> Heights above that south of the jet: g dh/dlat = -a u (f + u tan(lat)/a).
   pure function balanced(jet, u_max, lat) result(h)
      type(jet_integrals), intent(in) :: jet
      real(wp), intent(in) :: u_max(:), lat
      real(wp) :: h(size(u_max)), i(3)
      i = integrals_at(jet, lat)
      h = -(radius*u_max*i(2) + u_max**2*i(3))/gravity
   end function balanced

   !> The jet of 1 m/s.
   pure real(wp) function wind(lat)
      real(wp), intent(in) :: lat
      wind = 0.0_wp
      if (lat <= south .or. lat >= north) return
      wind = exp(1.0_wp/((lat - south)*(lat - north)) + 4.0_wp/(north - south)**2)
   end function wind

   subroutine integrate_jet(jet)
      type(jet_integrals), intent(out) :: jet
      integer :: i
      jet%at(:, 0) = 0.0_wp
      do i = 1, panels
         jet%at(:, i) = jet%at(:, i - 1) + quadrature(south + (i - 1)*panel, south + i*panel)
      end do
   end subroutine integrate_jet

   pure function integrals_at(jet, lat) result(sum)
      type(jet_integrals), intent(in) :: jet
      real(wp), intent(in) :: lat
      real(wp) :: sum(3), inside
      integer :: i
      inside = min(max(lat, south), north)
      i = min(int((inside - south)/panel), panels)
      sum = jet%at(:, i) + quadrature(south + i*panel, inside)
   end function integrals_at

   !> Gauss's five points.
   pure function quadrature(from, to) result(sum)
      real(wp), intent(in) :: from, to
      real(wp) :: sum(3), lat, u
      real(wp), parameter :: inner = sqrt(5.0_wp - 2.0_wp*sqrt(10.0_wp/7.0_wp))/3.0_wp
      real(wp), parameter :: outer = sqrt(5.0_wp + 2.0_wp*sqrt(10.0_wp/7.0_wp))/3.0_wp
      real(wp), parameter :: heavy = (322.0_wp + 13.0_wp*sqrt(70.0_wp))/900.0_wp
      real(wp), parameter :: light = (322.0_wp - 13.0_wp*sqrt(70.0_wp))/900.0_wp
      real(wp), parameter :: place(5) = [-outer, -inner, 0.0_wp, inner, outer]
      real(wp), parameter :: weight(5) = [light, heavy, 128.0_wp/225.0_wp, heavy, light]
      integer :: i
      sum = 0.0_wp
      do i = 1, 5
         lat = 0.5_wp*(from + to) + 0.5_wp*(to - from)*place(i)
         u = wind(lat)
         sum = sum + 0.5_wp*(to - from)*weight(i)*[u, u*2.0_wp*omega*sin(lat), u**2*tan(lat)]
      end do
   end function quadrature

end module galewsky
