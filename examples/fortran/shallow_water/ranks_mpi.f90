!> The ranks of a run, over MPI; ranks_serial.f90 is the same module without it, and the Makefile takes one of the two.
!>
!> A rank holds some columns of every array, by numbers of its own. Some are its own to compute; around them are copies of other
!> ranks' columns, the halo. A `pattern_type` knows who needs which of whom: one for cells, one for edges, one for corners.
module ranks
   use kinds, only: wp, ik
   use mpi_f08
   implicit none
   private
   public :: pattern_type, ranks_start, ranks_finish, new_pattern, exchange, gather, broadcast, largest_of_ranks, xor_of_ranks

   integer, protected, public :: rank = 0, rank_count = 1  !< the number of this one, from 0; how many there are
   integer, protected, public :: communicator = 0          !< theirs, as icoray takes it

   type :: pattern_type
      integer :: total = 0            !< columns on all ranks
      integer, allocatable :: own(:)  !< this rank's own columns
      integer, allocatable, private :: neighbour(:)  !< ranks to exchange columns with; with the i-th of them ...
      integer, allocatable, private :: give(:), give_start(:)  !< ... give(give_start(i):give_start(i + 1) - 1) go there,
      integer, allocatable, private :: take(:), take_start(:)  !< ... and these come from there
      integer, allocatable, private :: counts(:), starts(:)    !< how many columns rank 0 gathers from each rank, and where
      integer, allocatable, private :: place(:)                !< global numbers of those columns
   end type pattern_type

contains

   subroutine ranks_start()
      integer :: provided
      call MPI_Init_thread(MPI_THREAD_FUNNELED, provided)
      call MPI_Comm_rank(MPI_COMM_WORLD, rank)
      call MPI_Comm_size(MPI_COMM_WORLD, rank_count)
      communicator = MPI_COMM_WORLD%MPI_VAL
   end subroutine ranks_start

   subroutine ranks_finish()
      call MPI_Finalize()
   end subroutine ranks_finish

   !> Collective. Each rank asks the owners for its halo, and will give what it was asked for.
   subroutine new_pattern(total, number, owner, first, last, p)
      integer, intent(in) :: total                !< columns on all ranks
      integer, intent(in) :: number(:), owner(:)  !< global number and rank of each column that is held here
      integer, intent(in) :: first, last          !< those to receive
      type(pattern_type), intent(out) :: p
      integer, dimension(0:rank_count - 1) :: wanted, asked
      integer, allocatable, asynchronous :: asking(:), asked_for(:)
      type(MPI_Request), allocatable :: request(:)
      integer :: here(total), i, j, n

      p%total = total
      p%own = pack([(i, i=1, size(owner))], owner == rank)
      wanted = [(count(owner(first:last) == i), i=0, rank_count - 1)]
      call MPI_Alltoall(wanted, 1, MPI_INTEGER, asked, 1, MPI_INTEGER, MPI_COMM_WORLD)
      p%neighbour = pack([(i, i=0, rank_count - 1)], wanted > 0 .or. asked > 0)
      n = size(p%neighbour)
      p%take_start = [1, (1 + sum(wanted(p%neighbour(:i))), i=1, n)]
      p%give_start = [1, (1 + sum(asked(p%neighbour(:i))), i=1, n)]
      p%take = [(pack([(j, j=first, last)], owner(first:last) == p%neighbour(i)), i=1, n)]
      asking = number(p%take)
      allocate (asked_for(sum(asked)), request(2*n))
      do i = 1, n
         call MPI_Irecv(asked_for(p%give_start(i):), asked(p%neighbour(i)), MPI_INTEGER, p%neighbour(i), 0, MPI_COMM_WORLD, &
                        request(i))
         call MPI_Isend(asking(p%take_start(i):), wanted(p%neighbour(i)), MPI_INTEGER, p%neighbour(i), 0, MPI_COMM_WORLD, &
                        request(n + i))
      end do
      call MPI_Waitall(2*n, request, MPI_STATUSES_IGNORE)
      call MPI_F_sync_reg(asked_for)
      here = 0
      here(number) = [(i, i=1, size(number))]
      p%give = here(asked_for)
      call prepare_gather(p, number(p%own))
   end subroutine new_pattern

   subroutine prepare_gather(p, own_numbers)
      type(pattern_type), intent(inout) :: p
      integer, intent(in) :: own_numbers(:)
      integer :: i
      allocate (p%counts(rank_count), p%place(merge(p%total, 0, rank == 0)))
      call MPI_Allgather(size(own_numbers), 1, MPI_INTEGER, p%counts, 1, MPI_INTEGER, MPI_COMM_WORLD)
      p%starts = [(sum(p%counts(:i - 1)), i=1, rank_count)]
      call MPI_Gatherv(own_numbers, size(own_numbers), MPI_INTEGER, p%place, p%counts, p%starts, MPI_INTEGER, 0, MPI_COMM_WORLD)
   end subroutine prepare_gather

   !> Fills the halo of an array (layers, columns).
   subroutine exchange(p, values)
      type(pattern_type), intent(in) :: p
      real(wp), intent(inout) :: values(:, :)
      real(wp), allocatable, asynchronous :: outgoing(:, :), incoming(:, :)
      type(MPI_Request), allocatable :: request(:)
      integer :: i, n, layers

      if (.not. allocated(p%neighbour)) return  ! a whole mesh
      n = size(p%neighbour)
      layers = size(values, 1)
      allocate (incoming(layers, size(p%take)), outgoing(layers, size(p%give)), request(2*n))
      do i = 1, n
         associate (from => p%take_start(i), to => p%take_start(i + 1) - 1)
            call MPI_Irecv(incoming(:, from:to), layers*(to - from + 1), MPI_DOUBLE_PRECISION, p%neighbour(i), 0, MPI_COMM_WORLD, &
                           request(i))
         end associate
      end do
      do i = 1, n
         associate (from => p%give_start(i), to => p%give_start(i + 1) - 1)
            outgoing(:, from:to) = values(:, p%give(from:to))
            call MPI_Isend(outgoing(:, from:to), layers*(to - from + 1), MPI_DOUBLE_PRECISION, p%neighbour(i), 0, MPI_COMM_WORLD, &
                           request(n + i))
         end associate
      end do
      call MPI_Waitall(2*n, request, MPI_STATUSES_IGNORE)
      call MPI_F_sync_reg(incoming)
      values(:, p%take) = incoming
   end subroutine exchange

   !> Rank 0 gets the own columns of all, in the order of the whole mesh.
   subroutine gather(p, own, all)
      type(pattern_type), intent(in) :: p
      real(wp), intent(in) :: own(:)    !< in the order of p%own
      real(wp), intent(out) :: all(:)   !< (total) at rank 0, else empty
      real(wp) :: by_rank(size(all))
      call MPI_Gatherv(own, size(own), MPI_DOUBLE_PRECISION, by_rank, p%counts, p%starts, MPI_DOUBLE_PRECISION, 0, MPI_COMM_WORLD)
      all(p%place) = by_rank
   end subroutine gather

   !> From rank 0 to all.
   subroutine broadcast(values)
      real(wp), intent(inout) :: values(:)
      call MPI_Bcast(values, size(values), MPI_DOUBLE_PRECISION, 0, MPI_COMM_WORLD)
   end subroutine broadcast

   !> NaN only where all are, as maxval has it.
   real(wp) function largest_of_ranks(x)
      real(wp), intent(in) :: x
      real(wp) :: of_rank(rank_count)
      call MPI_Allgather(x, 1, MPI_DOUBLE_PRECISION, of_rank, 1, MPI_DOUBLE_PRECISION, MPI_COMM_WORLD)
      largest_of_ranks = maxval(of_rank)
   end function largest_of_ranks

   integer(ik) function xor_of_ranks(bits)
      integer(ik), intent(in) :: bits
      call MPI_Allreduce(bits, xor_of_ranks, 1, MPI_INTEGER8, MPI_BXOR, MPI_COMM_WORLD)
   end function xor_of_ranks

end module ranks
