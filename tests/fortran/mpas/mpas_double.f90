!> Stands for the modules of MPAS that examples/fortran/mpas and mpas_ocean use, with as much of them as they use. Reals have 32
!> bits with SINGLE_PRECISION, as MPAS's makefile says for PRECISION=single, and 64 without.
module mpas_kind_types
  implicit none
  public
#ifdef SINGLE_PRECISION
  integer, parameter :: RKIND = selected_real_kind(6)
#else
  integer, parameter :: RKIND = selected_real_kind(12)
#endif
  integer, parameter :: StrKIND = 512
end module mpas_kind_types

module mpas_constants
  use mpas_kind_types, only: RKIND
  implicit none
  public
  real(kind=RKIND), parameter :: rvord = 461.6_RKIND/287.0_RKIND
end module mpas_constants

module mpas_derived_types
  use mpas_kind_types
#ifdef MPAS_USE_MPI_F08
  use mpi_f08, only: MPI_Comm
#endif
  implicit none
  public
  integer, parameter :: MPAS_NOW = 0, MPAS_START_TIME = 1
  integer, parameter :: MPAS_LOG_OUT = 1, MPAS_LOG_WARN = 2

  !> An array, dimension or pool of a name, and of a time level if it has any.
  type :: member_type
    character(len=32) :: name = ''
    integer :: level = 1
    real(kind=RKIND), pointer :: r1(:) => null(), r2(:, :) => null(), r3(:, :, :) => null()
    integer, pointer :: i0 => null(), i1(:) => null(), i2(:, :) => null()
    type(mpas_pool_type), pointer :: pool => null()
  end type member_type

  type :: mpas_pool_type
    integer :: count = 0
    type(member_type) :: member(30)
  end type mpas_pool_type

  type :: dm_info
#ifdef MPAS_USE_MPI_F08
    type(MPI_Comm) :: comm
#else
    integer :: comm = 0
#endif
  end type dm_info

  type :: block_type
    type(mpas_pool_type), pointer :: structs => null()
  end type block_type

  !> Seconds since 2000-01-01_00:00:00.
  type :: MPAS_Time_type
    integer :: second = 0
  end type MPAS_Time_type
  type :: MPAS_TimeInterval_type
    integer :: second = 0
  end type MPAS_TimeInterval_type
  type :: MPAS_Clock_type
    type(MPAS_Time_type) :: start, now
  end type MPAS_Clock_type

  type :: domain_type
    type(block_type), pointer :: blocklist => null()
    type(MPAS_Clock_type), pointer :: clock => null()
    type(dm_info), pointer :: dminfo => null()
    real(kind=RKIND) :: sphere_radius = 1
  end type domain_type
end module mpas_derived_types

module mpas_timekeeping
  use mpas_kind_types
  use mpas_derived_types
  implicit none
  public
  interface operator(-)
    procedure :: time_between
  end interface operator(-)

contains

  function time_between(a, b) result(interval)
    type(MPAS_Time_type), intent(in) :: a, b
    type(MPAS_TimeInterval_type) :: interval
    interval%second = a%second - b%second
  end function time_between

  type(MPAS_Time_type) function mpas_get_clock_time(clock, whichTime, ierr)
    type(MPAS_Clock_type), intent(in) :: clock
    integer, intent(in) :: whichTime
    integer, intent(out), optional :: ierr
    mpas_get_clock_time = clock%now
    if (whichTime == MPAS_START_TIME) mpas_get_clock_time = clock%start
    if (present(ierr)) ierr = 0
  end function mpas_get_clock_time

  !> In January 2000.
  subroutine mpas_get_time(curr_time, dateTimeString, ierr)
    type(MPAS_Time_type), intent(in) :: curr_time
    character(len=StrKIND), intent(out), optional :: dateTimeString
    integer, intent(out), optional :: ierr
    associate (s => curr_time%second)
      if (present(dateTimeString)) write (dateTimeString, '(a, i2.2, a, i2.2, 2(a, i2.2))') '2000-01-', 1 + s/86400, '_', &
        mod(s/3600, 24), ':', mod(s/60, 60), ':', mod(s, 60)
    end associate
    if (present(ierr)) ierr = 0
  end subroutine mpas_get_time

  subroutine mpas_get_timeInterval(interval, DD, S, S_n, S_d, ierr)
    type(MPAS_TimeInterval_type), intent(in) :: interval
    integer, intent(out), optional :: DD, S, S_n, S_d, ierr
    if (present(DD)) DD = interval%second/86400
    if (present(S)) S = merge(mod(interval%second, 86400), interval%second, present(DD))
    if (present(S_n)) S_n = 0
    if (present(S_d)) S_d = 0
    if (present(ierr)) ierr = 0
  end subroutine mpas_get_timeInterval
end module mpas_timekeeping

module mpas_pool_routines
  use mpas_kind_types
  use mpas_derived_types
  implicit none
  private
  public :: mpas_pool_get_subpool, mpas_pool_get_dimension, mpas_pool_get_array, mpas_pool_shift_time_levels, add_member
  interface mpas_pool_get_array
    procedure :: get_r1, get_r2, get_r3, get_i1, get_i2
  end interface mpas_pool_get_array

contains

  !> The member of a name, and of a time level if one is asked for. If there is none, all its pointers are null, as MPAS's are.
  function found(pool, key, timeLevel) result(member)
    type(mpas_pool_type), intent(in) :: pool
    character(len=*), intent(in) :: key
    integer, intent(in), optional :: timeLevel
    type(member_type) :: member
    integer :: i, level
    level = 1
    if (present(timeLevel)) level = timeLevel
    do i = 1, pool%count
      member = pool%member(i)
      if (member%name == key .and. member%level == level) return
    end do
    member = member_type()
  end function found

  subroutine mpas_pool_get_subpool(inPool, key, subPool)
    type(mpas_pool_type), intent(in) :: inPool
    character(len=*), intent(in) :: key
    type(mpas_pool_type), pointer, intent(out) :: subPool
    type(member_type) :: member
    member = found(inPool, key)
    subPool => member%pool
  end subroutine mpas_pool_get_subpool

  subroutine mpas_pool_get_dimension(inPool, key, dim)
    type(mpas_pool_type), intent(in) :: inPool
    character(len=*), intent(in) :: key
    integer, pointer, intent(out) :: dim
    type(member_type) :: member
    member = found(inPool, key)
    dim => member%i0
  end subroutine mpas_pool_get_dimension

  subroutine get_r1(inPool, key, array, timeLevel)
    type(mpas_pool_type), intent(in) :: inPool
    character(len=*), intent(in) :: key
    real(kind=RKIND), pointer, intent(out) :: array(:)
    integer, intent(in), optional :: timeLevel
    type(member_type) :: member
    member = found(inPool, key, timeLevel)
    array => member%r1
  end subroutine get_r1
  subroutine get_r2(inPool, key, array, timeLevel)
    type(mpas_pool_type), intent(in) :: inPool
    character(len=*), intent(in) :: key
    real(kind=RKIND), pointer, intent(out) :: array(:, :)
    integer, intent(in), optional :: timeLevel
    type(member_type) :: member
    member = found(inPool, key, timeLevel)
    array => member%r2
  end subroutine get_r2
  subroutine get_r3(inPool, key, array, timeLevel)
    type(mpas_pool_type), intent(in) :: inPool
    character(len=*), intent(in) :: key
    real(kind=RKIND), pointer, intent(out) :: array(:, :, :)
    integer, intent(in), optional :: timeLevel
    type(member_type) :: member
    member = found(inPool, key, timeLevel)
    array => member%r3
  end subroutine get_r3
  subroutine get_i1(inPool, key, array, timeLevel)
    type(mpas_pool_type), intent(in) :: inPool
    character(len=*), intent(in) :: key
    integer, pointer, intent(out) :: array(:)
    integer, intent(in), optional :: timeLevel
    type(member_type) :: member
    member = found(inPool, key, timeLevel)
    array => member%i1
  end subroutine get_i1
  subroutine get_i2(inPool, key, array, timeLevel)
    type(mpas_pool_type), intent(in) :: inPool
    character(len=*), intent(in) :: key
    integer, pointer, intent(out) :: array(:, :)
    integer, intent(in), optional :: timeLevel
    type(member_type) :: member
    member = found(inPool, key, timeLevel)
    array => member%i2
  end subroutine get_i2

  !> Exchanges the memory of time levels 1 and 2, in pools of the pool too, as MPAS does at the end of a step.
  recursive subroutine mpas_pool_shift_time_levels(inPool)
    type(mpas_pool_type), intent(inout) :: inPool
    integer :: i
    logical :: has_levels(size(inPool%member))
    do i = 1, inPool%count
      has_levels(i) = count(inPool%member(:inPool%count)%name == inPool%member(i)%name) == 2
    end do
    do i = 1, inPool%count
      if (has_levels(i)) inPool%member(i)%level = 3 - inPool%member(i)%level
      if (associated(inPool%member(i)%pool)) call mpas_pool_shift_time_levels(inPool%member(i)%pool)
    end do
  end subroutine mpas_pool_shift_time_levels

  !> Puts something into a pool; MPAS does it from its registry.
  subroutine add_member(pool, name, level, r1, r2, r3, i0, i1, i2, sub)
    type(mpas_pool_type), intent(inout) :: pool
    character(len=*), intent(in) :: name
    integer, intent(in), optional :: level
    real(kind=RKIND), pointer, intent(in), optional :: r1(:), r2(:, :), r3(:, :, :)
    integer, pointer, intent(in), optional :: i0, i1(:), i2(:, :)
    type(mpas_pool_type), pointer, intent(in), optional :: sub
    pool%count = pool%count + 1
    associate (m => pool%member(pool%count))
      m%name = name
      if (present(level)) m%level = level
      if (present(r1)) m%r1 => r1
      if (present(r2)) m%r2 => r2
      if (present(r3)) m%r3 => r3
      if (present(i0)) m%i0 => i0
      if (present(i1)) m%i1 => i1
      if (present(i2)) m%i2 => i2
      if (present(sub)) m%pool => sub
    end associate
  end subroutine add_member
end module mpas_pool_routines

module mpas_log
  use mpas_derived_types
  implicit none
  public

contains

  !> MPAS's own overruns its buffer where a line is longer than it.
  subroutine mpas_log_write(message, messageType)
    character(len=*), intent(in) :: message
    integer, intent(in), optional :: messageType
    integer :: kind
    kind = MPAS_LOG_OUT
    if (present(messageType)) kind = messageType
    if (len(message) > StrKIND) error stop 'mpas_log_write: the message is longer than StrKIND'
    print '(a, i0, 2a)', 'log ', kind, ': ', message
  end subroutine mpas_log_write
end module mpas_log
