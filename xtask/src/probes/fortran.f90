module numbers
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  integer(c_int), parameter :: one = 1
end module numbers

program probe
  use numbers, only: one
  implicit none
  print '(i0)', one
end program probe
