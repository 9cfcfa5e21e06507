!> Which rank owns which cell: as a file of METIS says, or by equal pieces of a curve through all cells.
module partition
   use kinds, only: wp, ik
   use mesh, only: mesh_type
   implicit none
   private
   public :: partition_by_curve, read_partition, write_graph

   integer, parameter :: levels = 20              ! of the curve
   integer, parameter :: side = 2**levels

contains

   !> Cuts a Hilbert curve over the sphere into pieces of equally many cells. The sphere is unfolded to a square, as an octahedron
   !> whose south pole is at the four corners, so that what is whole on the curve is so on the sphere.
   subroutine partition_by_curve(m, parts, owner)
      type(mesh_type), intent(in) :: m
      integer, intent(in) :: parts
      integer, allocatable, intent(out) :: owner(:)  !< of each cell, from 0
      integer(ik) :: place(m%cells)
      integer :: order(m%cells), c

      do c = 1, m%cells
         place(c) = place_on_curve(m%center(:, c))
      end do
      call sort(place, order)
      allocate (owner(m%cells))
      do c = 1, m%cells
         owner(order(c)) = int((c - 1_ik)*parts/m%cells)
      end do
   end subroutine partition_by_curve

   pure integer(ik) function place_on_curve(p) result(place)
      real(wp), intent(in) :: p(3)
      real(wp) :: q(2)
      integer :: x, y, s, right, upper, swap

      q = p(1:2)/sum(abs(p))
      if (p(3) < 0.0_wp) q = sign(1.0_wp - abs(q([2, 1])), q)
      x = min(int(0.5_wp*(q(1) + 1.0_wp)*side), side - 1)
      y = min(int(0.5_wp*(q(2) + 1.0_wp)*side), side - 1)
      place = 0_ik
      s = side/2
      do while (s > 0)
         right = merge(1, 0, iand(x, s) > 0)
         upper = merge(1, 0, iand(y, s) > 0)
         place = 4_ik*place + ieor(3*right, upper)
         if (upper == 0) then  ! these quarters are turned
            if (right == 1) then
               x = side - 1 - x
               y = side - 1 - y
            end if
            swap = x
            x = y
            y = swap
         end if
         s = s/2
      end do
   end function place_on_curve

   !> The numbers of the keys in rising order; of equal ones the first comes first. Runs that are sorted are merged.
   pure subroutine sort(key, order)
      integer(ik), intent(in) :: key(:)
      integer, intent(out) :: order(:)
      integer :: before(size(key)), n, run, start, middle, last, i, a, b

      n = size(key)
      order = [(i, i=1, n)]
      run = 1
      do while (run < n)
         before = order
         do start = 1, n, 2*run
            middle = min(start + run, n + 1)
            last = min(start + 2*run, n + 1) - 1
            a = start
            b = middle
            do i = start, last
               if (first_is_next()) then
                  order(i) = before(a)
                  a = a + 1
               else
                  order(i) = before(b)
                  b = b + 1
               end if
            end do
         end do
         run = 2*run
      end do

   contains

      pure logical function first_is_next()
         first_is_next = a < middle
         if (first_is_next .and. b <= last) first_is_next = key(before(a)) <= key(before(b))
      end function first_is_next
   end subroutine sort

   !> As gpmetis writes it: a line for each cell with the number of its part, from 0. `trouble` is empty when all is well.
   subroutine read_partition(file, cells, parts, owner, trouble)
      character(*), intent(in) :: file
      integer, intent(in) :: cells, parts
      integer, allocatable, intent(out) :: owner(:)
      character(:), allocatable, intent(out) :: trouble
      integer :: unit, failed, c, i, extra
      character(80) :: line

      trouble = ''
      allocate (owner(cells), source=-1)
      open (newunit=unit, file=file, status='old', action='read', iostat=failed)
      if (failed /= 0) then
         trouble = 'cannot be read'
         return
      end if
      do c = 1, cells
         read (unit, *, iostat=failed) owner(c)
         if (failed == 0 .and. owner(c) >= 0 .and. owner(c) < parts) cycle
         write (line, '(a,i0,a,i0)') 'line ', c, ' is not a number from 0 to ', parts - 1
         trouble = trim(line)
         exit
      end do
      if (trouble == '') then
         read (unit, *, iostat=failed) extra
         if (failed == 0) trouble = 'has more lines than the mesh has cells'
      end if
      close (unit)
      do i = 0, parts - 1
         if (trouble == '' .and. all(owner /= i)) trouble = 'leaves a rank without cells'
      end do
   end subroutine read_partition

   !> The graph of cells that share an edge, for `gpmetis FILE PARTS`.
   subroutine write_graph(file, m)
      character(*), intent(in) :: file
      type(mesh_type), intent(in) :: m
      integer :: unit, c, j
      open (newunit=unit, file=file, status='replace', action='write')
      write (unit, '(i0,1x,i0)') m%cells, m%edges
      do c = 1, m%cells
         write (unit, '(*(i0,1x))') (sum(m%edge_cell(:, m%cell_edge(j, c))) - c, j=1, m%cell_count(c))
      end do
      close (unit)
   end subroutine write_graph

end module partition
