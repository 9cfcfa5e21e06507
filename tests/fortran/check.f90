!> Checks that are counted, and that say what failed and what the library said of it.
module check
  use icoray
  implicit none
  private
  public :: expect, went_well, refused, verdict
  integer :: checks = 0, failures = 0

contains

  subroutine expect(good, what)
    logical, intent(in) :: good
    character(len=*), intent(in) :: what
    checks = checks + 1
    if (good) return
    failures = failures + 1
    print '(2a)', 'failed: ', what
  end subroutine expect

  subroutine went_well(ctx, ierr, what)
    type(icoray_context), intent(in) :: ctx
    integer, intent(in) :: ierr
    character(len=*), intent(in) :: what
    character(len=400) :: message
    call expect(ierr == ICORAY_OK, what)
    if (ierr == ICORAY_OK) return
    call icoray_last_error(ctx, message)
    print '(a, i0, 2a)', '  status ', ierr, ': ', trim(message)
  end subroutine went_well

  !> The call gave this status, and its message has this part.
  subroutine refused(ctx, ierr, expected, part)
    type(icoray_context), intent(in) :: ctx
    integer, intent(in) :: ierr, expected
    character(len=*), intent(in) :: part
    character(len=400) :: message
    call icoray_last_error(ctx, message)
    call expect(ierr == expected .and. index(message, part) > 0, part)
    if (ierr == expected .and. index(message, part) > 0) return
    print '(a, i0, a, i0, 2a)', '  status ', ierr, ', expected ', expected, ': ', trim(message)
  end subroutine refused

  !> The last line that a program prints.
  subroutine verdict(program)
    character(len=*), intent(in) :: program
    print '(2a, i0, a, i0, a)', program, ': ', checks, ' checks, ', failures, ' failed'
  end subroutine verdict
end module check
