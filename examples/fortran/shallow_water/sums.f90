!> Sums over all ranks, with the same bits on any number of them.
module sums
   use kinds, only: wp, ik
   use ranks, only: pattern_type, rank, gather, broadcast, xor_of_ranks
   implicit none
   private
   public :: sum_over_columns, fingerprint

contains

   !> The sum of weight times value over all columns, for each layer. Rank 0 adds in the order of the whole mesh, as one rank alone
   !> does: it takes in a layer at a time. Collective; all get the sums.
   subroutine sum_over_columns(p, weight, values, total)
      type(pattern_type), intent(in) :: p
      real(wp), intent(in) :: weight(:), values(:, :)  !< (columns held here), (layers, columns)
      real(wp), intent(out) :: total(:)                !< (layers)
      real(wp), dimension(merge(p%total, 0, rank == 0)) :: all_weights, all_values
      real(wp) :: rest
      integer :: i, k

      call gather(p, weight(p%own), all_weights)
      total = 0.0_wp
      do k = 1, size(values, 1)
         call gather(p, values(k, p%own), all_values)
         rest = 0.0_wp
         do i = 1, size(all_values)
            call add_term(all_weights(i)*all_values(i), total(k), rest)
         end do
      end do
      call broadcast(total)
   end subroutine sum_over_columns

   !> Kahan's sum: what an addition rounds off goes into the next. Else the sum of a mesh loses more than the model does.
   pure subroutine add_term(term, sum, rest)
      real(wp), intent(in) :: term
      real(wp), intent(inout) :: sum, rest
      real(wp) :: new
      rest = rest + term
      new = sum + rest
      rest = rest - (new - sum)
      sum = new
   end subroutine add_term

   !> 64 bits that change when any bit of the values does, or where they lie in the whole mesh. Collective.
   integer(ik) function fingerprint(p, number, values) result(bits)
      type(pattern_type), intent(in) :: p
      integer, intent(in) :: number(:)        !< of the columns held here in the whole mesh
      real(wp), intent(in) :: values(:, :)
      integer(ik) :: place
      integer :: i, k
      bits = 0_ik
      do i = 1, size(p%own)
         do k = 1, size(values, 1)
            place = k + size(values, 1, ik)*number(p%own(i))
            bits = ieor(bits, scrambled(ieor(scrambled(place), transfer(values(k, p%own(i)), place))))
         end do
      end do
      bits = xor_of_ranks(bits)
   end function fingerprint

   !> Twice: each half times a prime of 31 bits, which cannot overflow, one turned by half a word.
   pure integer(ik) function scrambled(bits) result(x)
      integer(ik), intent(in) :: bits
      integer(ik), parameter :: low = 4294967295_ik, primes(2) = [2147483647_ik, 1540483477_ik]
      integer :: i
      x = bits
      do i = 1, 2
         x = ieor(iand(x, low)*primes(1), ishftc(ishft(x, -32)*primes(2), 32))
      end do
   end function scrambled

end module sums
