!> The command line.
module options
   use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
   use kinds, only: wp, ik, day
   use ranks, only: rank, ranks_finish
   implicit none
   private
   public :: options_type, read_options, refuse

   type :: options_type
      integer :: level = 5
      integer :: layers = 20
      real(wp) :: days = 6.0_wp
      real(wp) :: dt = 0.0_wp        !< s; 0: from the Courant number
      integer(ik) :: every = 0_ik    !< steps between pictures; 0: 6 hours
      integer :: lloyd = 100         !< rounds
      real(wp) :: tilt = 0.0_wp      !< of the mesh, degrees
      real(wp) :: lead = 0.5_wp      !< of the anticipated potential vorticity, in time steps
      character(:), allocatable :: initial, scene, out
      character(:), allocatable :: partition, graph  !< files, or empty
      integer :: threads = 0
      logical :: pictures = .true., beside = .false., self_test = .false.
   end type options_type

contains

   subroutine usage(to)
      integer, intent(in) :: to
      character(*), parameter :: text(*) = [character(110) :: &
         'usage: shallow_water [options]', &
         '  --level n        icosahedral grid of 10 * 4^n + 2 cells, 2 to 9 (5)', &
         '  --layers N       independent layers, 2 to 1000 (20)', &
         '  --case NAME      galewsky: an unstable jet, 40 m/s in the lowest layer to 100 in the highest; or', &
         '                   williamson2: steady flow, of which the error is printed (galewsky)', &
         '  --days D         length of the simulation (6)', &
         '  --dt S           longest time step in seconds (from the Courant number of gravity waves)', &
         '  --lloyd n        rounds of Lloyd''s iteration that make the mesh centroidal (100)', &
         '  --tilt DEG       turns the mesh: what changes with it in the flow is the mesh''s work (0)', &
         '  --partition FILE a line for each cell with the rank that owns it, from 0, as gpmetis writes it (pieces of a', &
         '                   curve through all cells)', &
         '  --graph FILE     write the graph of cells for gpmetis', &
         '  --lead x         potential vorticity is anticipated by x time steps; 0 leaves enstrophy alone (0.5)', &
         '  --every k        steps between pictures (6 hours), of which the scene may leave some out', &
         '  --scene FILE     scene to draw (examples/scenes/shallow_water.toml)', &
         '  --out DIR        where pictures go (the current directory)', &
         '  --threads T      threads that draw, 0 for all (0)', &
         '  --async          draw from a copy, beside the simulation', &
         '  --no-pictures    simulate only', &
         '  --self-test      check mesh and operators at this level, print each check, fail if one does', &
         '  --help           print this and leave']
      integer :: i
      do i = 1, size(text)
         write (to, '(a)') trim(text(i))
      end do
   end subroutine usage

   !> Ends the program; on all ranks, which have the same command line.
   subroutine refuse(name, why)
      character(*), intent(in) :: name, why
      if (rank == 0) then
         write (error_unit, '(4a)') 'shallow_water: ', name, ': ', why
         call usage(error_unit)
      end if
      call ranks_finish()
      stop 2, quiet=.true.
   end subroutine refuse

   subroutine read_options(o)
      type(options_type), intent(out) :: o
      character(:), allocatable :: name
      integer :: i

      o%initial = 'galewsky'
      o%scene = 'examples/scenes/shallow_water.toml'
      o%out = '.'
      o%partition = ''
      o%graph = ''
      i = 1
      do while (i <= command_argument_count())
         name = argument(i)
         i = i + 2
         select case (name)
         case ('--help')
            if (rank == 0) call usage(output_unit)
            call ranks_finish()
            stop
         case ('--no-pictures')
            o%pictures = .false.
            i = i - 1
         case ('--async')
            o%beside = .true.
            i = i - 1
         case ('--self-test')
            o%self_test = .true.
            i = i - 1
         case ('--level')
            o%level = nint(number(i - 1, 2.0_wp, 9.0_wp, whole=.true.))
         case ('--layers')
            o%layers = nint(number(i - 1, 2.0_wp, 1000.0_wp, whole=.true.))
         case ('--days')
            o%days = number(i - 1, 0.01_wp, 10000.0_wp)
         case ('--dt')
            o%dt = number(i - 1, 0.01_wp, day)
         case ('--lloyd')
            o%lloyd = nint(number(i - 1, 0.0_wp, 1.0e6_wp, whole=.true.))
         case ('--tilt')
            o%tilt = number(i - 1, -180.0_wp, 180.0_wp)
         case ('--lead')
            o%lead = number(i - 1, 0.0_wp, 10.0_wp)
         case ('--every')
            o%every = nint(number(i - 1, 1.0_wp, 1.0e9_wp, whole=.true.), ik)
         case ('--threads')
            o%threads = nint(number(i - 1, 0.0_wp, 4096.0_wp, whole=.true.))
         case ('--case')
            o%initial = argument(i - 1)
            if (o%initial /= 'galewsky' .and. o%initial /= 'williamson2') call refuse(name, 'galewsky or williamson2')
         case ('--partition')
            o%partition = argument(i - 1)
            if (o%partition == '') call refuse(name, 'without its value')
         case ('--graph')
            o%graph = argument(i - 1)
            if (o%graph == '') call refuse(name, 'without its value')
         case ('--scene')
            o%scene = argument(i - 1)
            if (o%scene == '') call refuse(name, 'without its value')
         case ('--out')
            o%out = argument(i - 1)
            if (o%out == '') call refuse(name, 'without its value')
         case default
            call refuse(name, 'unknown')
         end select
      end do
   end subroutine read_options

   !> Argument i, or nothing past the last.
   function argument(i) result(text)
      integer, intent(in) :: i
      character(:), allocatable :: text
      integer :: length
      length = 0
      if (i <= command_argument_count()) call get_command_argument(i, length=length)
      allocate (character(length) :: text)
      if (length > 0) call get_command_argument(i, text)
   end function argument

   !> The number in argument i; refuses what is none, or out of range.
   real(wp) function number(i, lowest, highest, whole)
      integer, intent(in) :: i
      real(wp), intent(in) :: lowest, highest
      logical, intent(in), optional :: whole
      character(:), allocatable :: text
      integer :: failed
      text = argument(i)
      number = lowest
      failed = merge(1, 0, text == '' .or. verify(text, '0123456789.+-eEdD') /= 0)
      if (failed == 0) read (text, *, iostat=failed) number
      if (failed /= 0 .or. .not. (number >= lowest .and. number <= highest)) then
         call refuse(argument(i - 1), 'not a number in its range: "'//text//'"')
      end if
      if (present(whole)) then
         if (whole .and. abs(number - anint(number)) > 0.0_wp) call refuse(argument(i - 1), 'not a whole number')
      end if
   end function number

end module options
