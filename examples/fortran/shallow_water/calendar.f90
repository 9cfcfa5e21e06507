!> Time as a date of a 365-day calendar that starts on 1 January of year 0.
module calendar
   use kinds, only: wp, ik
   implicit none
   private
   public :: date_of

contains

   !> To the nearest second, as icoray wants it.
   pure function date_of(time) result(text)
      real(wp), intent(in) :: time  !< s
      character(19) :: text
      integer, parameter :: length(12) = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]
      integer(ik) :: whole, days
      integer :: month, seconds

      whole = nint(time, ik)
      days = whole/86400_ik
      seconds = int(modulo(whole, 86400_ik))
      associate (year => days/365_ik)
         days = modulo(days, 365_ik)
         month = 1
         do while (days >= length(month))
            days = days - length(month)
            month = month + 1
         end do
         write (text, '(i4.4,"-",i2.2,"-",i2.2,"_",i2.2,":",i2.2,":",i2.2)') year, month, days + 1, seconds/3600, &
            modulo(seconds/60, 60), modulo(seconds, 60)
      end associate
   end function date_of

end module calendar
