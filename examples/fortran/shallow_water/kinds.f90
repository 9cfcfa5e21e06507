!> Kinds of numbers, and the planet (Williamson et al. 1992, Table 1; Galewsky et al. 2004).
module kinds
   use, intrinsic :: iso_fortran_env, only: int32, int64, real64
   implicit none
   private

   integer, parameter, public :: wp = real64  !< every real of the model
   integer, parameter, public :: ip = int32   !< indices, as icoray takes them
   integer, parameter, public :: ik = int64   !< clock ticks, numbers of steps

   real(wp), parameter, public :: pi = acos(-1.0_wp)
   real(wp), parameter, public :: radius = 6.37122e6_wp   !< of the Earth, m
   real(wp), parameter, public :: omega = 7.292e-5_wp     !< its rotation, 1/s
   real(wp), parameter, public :: gravity = 9.80616_wp    !< m/s2
   real(wp), parameter, public :: day = 86400.0_wp        !< s

   public :: clock

contains

   !> Wall-clock time in seconds from an arbitrary start.
   real(wp) function clock()
      integer(ik) :: ticks, rate
      call system_clock(ticks, rate)
      clock = real(ticks, wp)/real(rate, wp)
   end function clock

end module kinds
