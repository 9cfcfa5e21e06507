!> The report of a check, and helpers of checks.
module checking
   use kinds, only: wp
   use ranks, only: rank
   implicit none
   private
   public :: check, noise

   real(wp), parameter, public :: rounding = 1.0e-12_wp

contains

   !> Each is printed with what was found, on all ranks alike, and what is allowed.
   subroutine check(name, found, allowed, well)
      character(*), intent(in) :: name
      real(wp), intent(in) :: found, allowed
      logical, intent(inout) :: well
      character(6) :: verdict
      verdict = merge('ok    ', 'FAILED', found <= allowed)  ! NaN fails
      if (rank == 0) write (*, '(a,1x,a,t80,es10.2,a,es9.2)') verdict, name, found, ' of', allowed
      well = well .and. found <= allowed
   end subroutine check

   !> A number between -1 and 1 without rhyme or reason.
   elemental real(wp) function noise(i)
      integer, intent(in) :: i
      noise = 2.0_wp*modulo(43758.5453_wp*sin(12.9898_wp*real(i, wp)), 1.0_wp) - 1.0_wp
   end function noise

end module checking
