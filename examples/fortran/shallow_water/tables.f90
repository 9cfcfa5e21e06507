!> The model's own copy of the six tables of a geodesic grid, numbered from 1: what the model computes on and what it lends
!> to icoray. With `relax`, generated meshes become centroidal: Lloyd's iteration moves each centre to the centroid of its
!> cell and each corner to the circumcentre of its centres; who is whose neighbour stays.
module tables
   use kinds, only: wp, ip, pi
   use sphere, only: place_at, longitude, latitude, unit, cross, triangle_area, circumcentre
   use icoray, only: icoray_mesh, icoray_grid_tables, icoray_mesh_create, icoray_mesh_tables, icoray_mesh_free, &
                     icoray_last_error
   implicit none
   private
   public :: grid_tables, generate, tilt, relax

   type :: grid_tables
      real(wp), allocatable :: lon_center(:), lat_center(:), lon_corner(:), lat_corner(:)  !< radians
      integer(ip), allocatable :: cell_corner(:, :)  !< (6, cells); a pentagon repeats one
      integer(ip), allocatable :: corner_cell(:, :)  !< (3, corners)
      integer(ip), allocatable :: corner_edge(:, :)  !< (3, corners)
      integer(ip), allocatable :: edge_corner(:, :)  !< (2, edges)
   end type grid_tables

contains

   !> The icosahedral mesh of 10*4**level + 2 cells, from icoray.
   subroutine generate(level, t)
      integer, intent(in) :: level
      type(grid_tables), intent(out) :: t
      type(icoray_mesh) :: mesh
      type(icoray_grid_tables) :: g
      integer :: ierr
      integer(ip) :: to_one

      call icoray_mesh_create(level, mesh, ierr)
      if (ierr == 0) call icoray_mesh_tables(mesh, g, ierr)
      if (ierr /= 0) error stop 'shallow_water: icoray has no mesh of this level'
      to_one = int(1 - g%index_base, ip)
      t%lon_center = g%lon_center
      t%lat_center = g%lat_center
      t%lon_corner = g%lon_corner
      t%lat_corner = g%lat_corner
      t%cell_corner = g%cell_corner + to_one
      t%corner_cell = g%corner_cell + to_one
      t%corner_edge = g%corner_edge + to_one
      t%edge_corner = g%edge_corner + to_one
      call icoray_mesh_free(mesh, ierr)
   end subroutine generate

   !> Turns the whole mesh by an angle about 0 N 18 E. As generated it has a pentagon at each pole and is five-fold about them, so
   !> that of all waves its errors excite the fifth; turned, they excite all. What a flow owes to the mesh changes with it.
   subroutine tilt(t, turned)
      type(grid_tables), intent(inout) :: t
      real(wp), intent(in) :: turned  !< radians
      call turn(t%lon_center, t%lat_center, turned)
      call turn(t%lon_corner, t%lat_corner, turned)
   end subroutine tilt

   pure subroutine turn(lon, lat, turned)
      real(wp), intent(inout) :: lon(:), lat(:)
      real(wp), intent(in) :: turned
      real(wp), parameter :: axis(3) = [cos(pi/10.0_wp), sin(pi/10.0_wp), 0.0_wp]
      real(wp) :: p(3)
      integer :: i
      do i = 1, size(lon)
         p = place_at(lon(i), lat(i))  ! Rodrigues' formula
         p = cos(turned)*p + sin(turned)*cross(axis, p) + (1.0_wp - cos(turned))*dot_product(axis, p)*axis
         lon(i) = longitude(p)
         lat(i) = latitude(p)
      end do
   end subroutine turn

   !> Lloyd's iteration, `rounds` times. Returns how far a centre is from its cell's centroid at most, and in the mean, in
   !> units of the mean distance between neighbours, before the last move.
   subroutine relax(t, rounds, farthest, mean)
      type(grid_tables), intent(inout) :: t
      integer, intent(in) :: rounds
      real(wp), intent(out) :: farthest, mean
      real(wp), allocatable :: center(:, :), corner(:, :), moment(:, :)
      real(wp) :: spacing
      integer :: c, v, round

      allocate (center(3, size(t%lon_center)), moment(3, size(t%lon_center)), corner(3, size(t%lon_corner)))
      do c = 1, size(center, 2)
         center(:, c) = place_at(t%lon_center(c), t%lat_center(c))
      end do
      do v = 1, size(corner, 2)
         corner(:, v) = place_at(t%lon_corner(v), t%lat_corner(v))
      end do
      spacing = sqrt(8.0_wp*pi/sqrt(3.0_wp)/real(size(center, 2), wp))
      farthest = 0.0_wp
      mean = 0.0_wp
      do round = 0, rounds
         call cell_moments(t, center, corner, moment)
         farthest = 0.0_wp
         mean = 0.0_wp
         do c = 1, size(center, 2)
            moment(:, c) = unit(moment(:, c))
            farthest = max(farthest, norm2(moment(:, c) - center(:, c))/spacing)
            mean = mean + norm2(moment(:, c) - center(:, c))/spacing/real(size(center, 2), wp)
         end do
         if (round == rounds) exit
         center = moment
         do v = 1, size(corner, 2)
            associate (i => t%corner_cell(:, v))
               corner(:, v) = circumcentre(center(:, i(1)), center(:, i(2)), center(:, i(3)))
            end associate
         end do
      end do
      if (rounds == 0) return
      do c = 1, size(center, 2)
         t%lon_center(c) = longitude(center(:, c))
         t%lat_center(c) = latitude(center(:, c))
      end do
      do v = 1, size(corner, 2)
         t%lon_corner(v) = longitude(corner(:, v))
         t%lat_corner(v) = latitude(corner(:, v))
      end do
   end subroutine relax

   !> Adds up area times centroid of each cell, from its triangles of centre and side.
   subroutine cell_moments(t, center, corner, moment)
      type(grid_tables), intent(in) :: t
      real(wp), intent(in) :: center(:, :), corner(:, :)
      real(wp), intent(out) :: moment(:, :)
      integer :: e, i, j, c

      moment = 0.0_wp
      do e = 1, size(t%edge_corner, 2)
         associate (a => t%edge_corner(1, e), b => t%edge_corner(2, e))
            do i = 1, 3
               do j = 1, 3
                  c = t%corner_cell(i, a)
                  if (c /= t%corner_cell(j, b)) cycle  ! a cell of both ends is a cell of the edge
                  moment(:, c) = moment(:, c) + abs(triangle_area(center(:, c), corner(:, a), corner(:, b))) &
                                 *(center(:, c) + corner(:, a) + corner(:, b))
               end do
            end do
         end associate
      end do
   end subroutine cell_moments

end module tables
