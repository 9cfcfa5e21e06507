!> Geometry on the unit sphere. Differences of nearby points are taken first, so that small cells keep their digits.
module sphere
   use kinds, only: wp, pi
   implicit none
   private
   public :: place_at, longitude, latitude, unit, cross, angle, triangle_area, circumcentre

contains

   !> The unit vector at a longitude and latitude.
   pure function place_at(lon, lat) result(p)
      real(wp), intent(in) :: lon, lat
      real(wp) :: p(3)
      p = [cos(lat)*cos(lon), cos(lat)*sin(lon), sin(lat)]
   end function place_at

   !> Longitude of a vector, in [0, 2 pi).
   pure real(wp) function longitude(p)
      real(wp), intent(in) :: p(3)
      longitude = atan2(p(2), p(1))
      if (longitude < 0.0_wp) longitude = longitude + 2.0_wp*pi
      if (longitude >= 2.0_wp*pi) longitude = 0.0_wp
   end function longitude

   pure real(wp) function latitude(p)
      real(wp), intent(in) :: p(3)
      latitude = atan2(p(3), hypot(p(1), p(2)))
   end function latitude

   pure function unit(v) result(p)
      real(wp), intent(in) :: v(3)
      real(wp) :: p(3)
      p = v/norm2(v)
   end function unit

   pure function cross(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)
      c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function cross

   !> Angle between unit vectors, from half their chord: exact for small ones.
   pure real(wp) function angle(a, b)
      real(wp), intent(in) :: a(3), b(3)
      angle = 2.0_wp*atan2(norm2(b - a), norm2(b + a))
   end function angle

   !> Area of a spherical triangle, positive where a, b, c run counter-clockwise seen from outside
   !> (van Oosterom and Strackee 1983, doi:10.1109/TBME.1983.325207).
   pure real(wp) function triangle_area(a, b, c)
      real(wp), intent(in) :: a(3), b(3), c(3)
      real(wp) :: volume
      volume = dot_product(a, cross(b - a, c - a))
      triangle_area = 2.0_wp*atan2(volume, 1.0_wp + dot_product(a, b) + dot_product(b, c) + dot_product(c, a))
   end function triangle_area

   !> The point at equal distance from three, on their side of the sphere, whichever way they run.
   pure function circumcentre(a, b, c) result(p)
      real(wp), intent(in) :: a(3), b(3), c(3)
      real(wp) :: p(3)
      p = unit(cross(b - a, c - a))
      p = sign(1.0_wp, dot_product(p, a + b + c))*p
   end function circumcentre

end module sphere
