!> The ranks of a run without MPI: this one, which owns every column. See ranks_mpi.f90.
module ranks
   use kinds, only: wp, ik
   implicit none
   private
   public :: pattern_type, ranks_start, ranks_finish, new_pattern, exchange, gather, broadcast, largest_of_ranks, xor_of_ranks

   integer, parameter, public :: rank = 0, rank_count = 1
   integer, parameter, public :: communicator = 0

   type :: pattern_type
      integer :: total = 0
      integer, allocatable :: own(:)
      integer, allocatable, private :: place(:)
   end type pattern_type

contains

   subroutine ranks_start()
   end subroutine ranks_start

   subroutine ranks_finish()
   end subroutine ranks_finish

   subroutine new_pattern(total, number, owner, first, last, p)
      integer, intent(in) :: total, number(:), owner(:), first, last
      type(pattern_type), intent(out) :: p
      integer :: i
      if (last >= first) error stop 'shallow_water: a halo, but no other rank'
      p%total = total
      p%own = pack([(i, i=1, size(owner))], owner == rank)
      p%place = number(p%own)
   end subroutine new_pattern

   subroutine exchange(p, values)
      type(pattern_type), intent(in) :: p
      real(wp), intent(inout) :: values(:, :)
      if (p%total > size(values, 2)) error stop 'shallow_water: a part of the mesh, but no other rank'
   end subroutine exchange

   subroutine gather(p, own, all)
      type(pattern_type), intent(in) :: p
      real(wp), intent(in) :: own(:)
      real(wp), intent(out) :: all(:)
      all(p%place) = own
   end subroutine gather

   subroutine broadcast(values)
      real(wp), intent(inout) :: values(:)
      associate (there_already => values)
      end associate
   end subroutine broadcast

   real(wp) function largest_of_ranks(x)
      real(wp), intent(in) :: x
      largest_of_ranks = x
   end function largest_of_ranks

   integer(ik) function xor_of_ranks(bits)
      integer(ik), intent(in) :: bits
      xor_of_ranks = bits
   end function xor_of_ranks

end module ranks
