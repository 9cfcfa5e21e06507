!> A model that hands its communicators over: mpi_model DIRECTORY. MPI is initialised for one thread.
program mpi_model
  use mpi_f08
  use icoray
  use, intrinsic :: iso_c_binding
  implicit none
  type(icoray_mesh) :: mesh
  real(c_double), allocatable, target :: q(:, :)
  type(icoray_grid_tables) :: tables
  type(MPI_Comm) :: part
  character(len=512) :: directory
  integer :: rank, ranks, cells, k, whole, failures

  call MPI_Init()
  call MPI_Comm_rank(MPI_COMM_WORLD, rank)
  call MPI_Comm_size(MPI_COMM_WORLD, ranks)
  call get_command_argument(1, directory)
  failures = 0

  call icoray_mesh_create(3, mesh)
  call icoray_mesh_tables(mesh, tables)
  cells = size(tables%lon_center)
  allocate (q(3, cells))
  do k = 1, 3
    q(k, :) = sin(3*tables%lon_center + k)*cos(tables%lat_center)
  end do

  call draw(MPI_COMM_WORLD%MPI_VAL, 'world', ranks)
  whole = MPI_COMM_WORLD%MPI_VAL
  call draw(whole, 'integer', ranks)
  ! Ranks 0 and 1, in the other order; the rest draws no picture.
  call MPI_Comm_split(MPI_COMM_WORLD, merge(0, MPI_UNDEFINED, rank < 2), -rank, part)
  if (rank < 2) then
    call draw(part%MPI_VAL, 'part', min(ranks, 2))
    call MPI_Comm_free(part)
  end if
  call draw(MPI_COMM_WORLD%MPI_VAL, 'first', ranks)
  call draw(MPI_COMM_WORLD%MPI_VAL, 'last', ranks)
  call draw(MPI_COMM_WORLD%MPI_VAL, 'columns', ranks)
  call beside()

  call icoray_mesh_free(mesh)
  call MPI_Allreduce(MPI_IN_PLACE, failures, 1, MPI_INTEGER, MPI_SUM, MPI_COMM_WORLD)
  if (rank == 0 .and. failures == 0) print '(a, i0)', 'mpi_model: all well on ', ranks
  call MPI_Finalize()
  if (failures > 0) error stop 1

contains

  !> Of whole grids, of parts that are called 'first' and 'last', or of columns.
  subroutine draw(comm, name, expected)
    integer, intent(in) :: comm, expected
    character(len=*), intent(in) :: name
    type(icoray_context) :: ctx
    type(icoray_frame_report) :: report
    character(len=200) :: message
    logical :: in_parts
    integer :: ierr
    call icoray_open(ctx, comm, ierr, output_dir=trim(directory)//'/'//name, threads=1)
    call check(ierr == ICORAY_OK, 'icoray_open')
    if (ierr /= ICORAY_OK) then
      call icoray_last_error(message)
      print '(a)', trim(message)
      return
    end if
    call icoray_layers_set(ctx, [6371d3, 6376d3, 6381d3], 6371d3)
    in_parts = .true.
    select case (name)
    case ('first')
      call spread(ctx)
    case ('last')
      call spread_last(ctx)
    case ('columns')
      call spread_columns(ctx)
    case default
      in_parts = .false.
      call icoray_grid_set(ctx, mesh)
      call icoray_field_set(ctx, 'q', q)
    end select
    call icoray_scene_text(ctx, 'field = "q"'//new_line('a')//'exaggeration = 40'//new_line('a')// &
      '[image]'//new_line('a')//'width = 90'//new_line('a')//'height = 70'//new_line('a')// &
      '[camera]'//new_line('a')//'lon = 10'//new_line('a')//'lat = 20'//new_line('a')//'distance = 3'//new_line('a')// &
      '[transfer]'//new_line('a')//'map = "viridis"'//new_line('a')//'range = [-1, 1]'//new_line('a')// &
      'opacity = [[-1, 0.8], [1, 0.9]]'//new_line('a')//'[output]'//new_line('a')//'file = "f_{step}.png"')
    call icoray_execute(ctx, 1, 0d0, ierr)
    call check(ierr == ICORAY_OK, 'icoray_execute')
    call icoray_wait(ctx, ierr)
    call check(ierr == ICORAY_OK, 'icoray_wait')
    call icoray_report(ctx, report)
    call check(report%ranks == expected .and. report%tiles > 0 .and. report%rays > 0, 'the report')
    call check(report%scheme == ICORAY_TILES .and. report%fragments == 0, 'the scheme')
    ! Of the last ones, a single rank has all.
    call check((report%bytes_copied > 0) .eqv. (in_parts .and. expected > 1 .and. (name /= 'last' .or. rank == ranks - 1)), &
               'copies')
    call icoray_close(ctx, ierr)
    call check(ierr == ICORAY_OK, 'icoray_close')
  end subroutine draw

  !> Rank r owns the cells of numbers r, r + ranks, ...; the others are its halo. Each way to say so is tried.
  subroutine spread(ctx)
    type(icoray_context), intent(in) :: ctx
    integer(c_int32_t) :: numbers(cells)
    integer(c_int64_t) :: wide(2*cells)
    logical :: mask(cells)
    character(len=200) :: message
    integer :: i, ierr
    numbers = [(int(i - 1, c_int32_t), i = 1, cells)]
    wide(1::2) = numbers
    wide(2::2) = -1
    mask = mod(numbers, int(ranks, c_int32_t)) == rank
    call icoray_grid_set(ctx, mesh)
    call icoray_field_set(ctx, 'q', q)
    ! Refused on all, whichever rank it is.
    call icoray_part_set(ctx, numbers, ierr, is_owned=mask(:cells - merge(1, 0, rank == 0)))
    call check(ierr == ICORAY_ERR_ARGUMENT, 'a short mask is refused')
    call icoray_last_error(ctx, message)
    call check(index(message, 'icoray_part.cells: -642, expected 0 to') > 0, 'the message of a short mask')
    call icoray_part_set(ctx, numbers, ierr, owned=cells + 1)
    call check(ierr == ICORAY_ERR_GRID, 'more own cells than there are')
    call icoray_part_set(ctx, numbers, ierr, owned=-1, grid='other')
    call check(ierr == ICORAY_ERR_ARGUMENT, 'no grid of that name')
    call icoray_part_set(ctx, numbers, ierr, is_owned=merge(-3_c_int32_t, 0_c_int32_t, mask))
    call check(ierr == ICORAY_OK, 'icoray_part_set with marks')
    call icoray_part_set(ctx, wide(1::2), ierr, is_owned=merge(1_c_int32_t, 0_c_int32_t, mask))
    call check(ierr == ICORAY_OK, 'icoray_part_set with marks and wide numbers')
    call icoray_part_set(ctx, numbers, is_owned=mask)
    call icoray_part_set(ctx, wide(1::2), ierr, is_owned=mask)
    call check(ierr == ICORAY_OK, 'icoray_part_set')
  end subroutine spread

  !> The last rank owns all, by their number, and the others have no cells.
  subroutine spread_last(ctx)
    type(icoray_context), intent(in) :: ctx
    real(c_double), allocatable, target, save :: place(:), nothing(:, :)
    integer(c_int32_t), allocatable, target, save :: six(:, :), three(:, :), two(:, :)
    integer(c_int32_t) :: numbers(cells)
    integer :: i, ierr, own
    numbers = [(int(i - 1, c_int32_t), i = 1, cells)]
    own = merge(cells, 0, rank == ranks - 1)
    if (own > 0) then
      call icoray_grid_set(ctx, mesh, name='named')
      call icoray_field_set(ctx, 'q', q, grid_name='named')
    else
      allocate (place(0), nothing(3, 0), six(6, 0), three(3, 0), two(2, 0))
      call icoray_grid_set(ctx, place, place, place, place, six, three, three, two, ierr, index_base=0, name='named')
      call check(ierr == ICORAY_OK, 'a grid without cells')
      call icoray_field_set(ctx, 'q', nothing, ierr, grid_name='named')
      call check(ierr == ICORAY_OK, 'a field without columns')
    end if
    call icoray_part_set(ctx, numbers(:own), ierr, owned=own, grid='named')
    call check(ierr == ICORAY_OK, 'icoray_part_set with their number')
    call icoray_part_set(ctx, int(numbers(:own), c_int64_t), ierr, owned=own, grid='named')
    call check(ierr == ICORAY_OK, 'icoray_part_set with their number and wide numbers')
  end subroutine spread_last

  !> Each rank has all tables, every so many cell and the heights of every so many corner, which no scene shows.
  subroutine spread_columns(ctx)
    type(icoray_context), intent(in) :: ctx
    real(c_double), allocatable, target, save :: own(:, :)
    real(c_float), allocatable, target, save :: heights(:, :)
    integer(c_int64_t) :: numbers((cells - rank - 1)/ranks + 1), corners((2*cells - 5 - rank)/ranks + 1)
    character(len=200) :: message
    integer :: i, ierr
    numbers = [(int(i - 1, c_int64_t), i = rank + 1, cells, ranks)]
    corners = [(int(i - 1, c_int64_t), i = rank + 1, 2*cells - 4, ranks)]
    own = q(:, rank + 1::ranks)
    allocate (heights(size(corners), 3), source=1.0_c_float)
    call icoray_grid_set(ctx, mesh)
    call icoray_part_set(ctx, numbers, ierr, owned=size(numbers), corner_global=corners)
    call check(ierr == ICORAY_ERR_GRID, 'corners that nobody owns')
    call icoray_part_set(ctx, int(numbers), ierr, is_owned=numbers >= 0, corner_global=int(corners), &
                         is_corner_owned=[corners >= 0, .true.])
    call check(ierr == ICORAY_ERR_ARGUMENT, 'a mask of corners that is too long')
    call icoray_last_error(ctx, message)
    call check(index(message, 'icoray_part.corners: -') > 0, 'its message')
    call icoray_part_set(ctx, int(numbers), ierr, is_owned=numbers >= 0, corner_global=int(corners), &
                         is_corner_owned=corners >= 0)
    call check(ierr == ICORAY_OK, 'icoray_part_set with a mask of corners')
    call icoray_part_set(ctx, numbers, ierr, is_owned=int(numbers*0 + 1), corner_global=corners, &
                         is_corner_owned=int(corners*0 + 1))
    call check(ierr == ICORAY_OK, 'icoray_part_set with marks of corners')
    call icoray_part_set(ctx, numbers, ierr, owned=size(numbers), corner_global=corners, owned_corners=size(corners))
    call check(ierr == ICORAY_OK, 'icoray_part_set with the number of corners')
    call icoray_field_set(ctx, 'q', own, ierr)
    call check(ierr == ICORAY_OK, 'own columns')
    call icoray_heights_set(ctx, heights, ierr, location=ICORAY_CORNER)
    call check(ierr == ICORAY_OK, 'heights of own corners')
  end subroutine spread_columns

  !> With a configuration, in which threads that draw on are asked for.
  subroutine beside()
    type(icoray_context) :: ctx
    type(icoray_config) :: config
    integer :: ierr
    config%async_render = 1
    call icoray_open(ctx, MPI_COMM_WORLD%MPI_VAL, config, ierr)
    call check(ierr == ICORAY_OK, 'async_render over ranks')
    call icoray_close(ctx, ierr)
    call check(ierr == ICORAY_OK, 'closing it')
  end subroutine beside

  subroutine check(good, what)
    logical, intent(in) :: good
    character(len=*), intent(in) :: what
    if (good) return
    failures = failures + 1
    print '(a, i0, 2a)', 'rank ', rank, ' failed: ', what
  end subroutine check
end program mpi_model
