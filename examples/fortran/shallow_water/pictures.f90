!> All that the model adds in order to be drawn: `pictures_open` once before the time loop, `pictures_draw` every k steps,
!> `pictures_close` after it. Mesh, height and vorticity are lent, not copied. When something fails, the reason is printed and
!> the simulation goes on without pictures. Over several ranks each lends its part, halo and all, and they make every call
!> together.
module pictures
   use, intrinsic :: iso_fortran_env, only: error_unit
   use kinds, only: wp, ip, ik, clock
   use tables, only: grid_tables
   use ranks, only: rank, rank_count, communicator, largest_of_ranks
   use icoray, only: icoray_context, icoray_open, icoray_open_serial, icoray_grid_set, icoray_part_set, icoray_layers_set, &
                     icoray_field_set, icoray_scene_load, icoray_wants, icoray_execute, icoray_last_error, &
                     icoray_close, ICORAY_OK, ICORAY_CORNER, ICORAY_OVERWRITE
   implicit none
   private
   public :: pictures_type, pictures_open, pictures_wanted, pictures_draw, pictures_close

   type :: pictures_type
      type(icoray_context) :: context
      logical :: open = .false.
      character(:), allocatable :: trouble  !< what has gone wrong on this rank
      integer :: taken = 0, failed = 0
      real(wp) :: seconds = 0.0_wp  !< wall-clock time inside icoray
      integer(ik) :: asked = 0_ik   !< steps at which it was asked for a picture
      real(wp) :: asking = 0.0_wp   !< the part of seconds that this took
   end type pictures_type

contains

   !> Tables and fields must be targets that stay where they are until `pictures_close`.
   subroutine pictures_open(p, t, cell_number, own_cells, level_radius, planet_radius, scene, out, threads, beside)
      type(pictures_type), intent(inout) :: p
      type(grid_tables), intent(in), target :: t
      integer(ip), intent(in) :: cell_number(:)  !< of each cell in the whole mesh
      integer, intent(in) :: own_cells           !< the first so many are this rank's own
      real(wp), intent(in) :: level_radius(:), planet_radius             !< m
      character(*), intent(in) :: scene, out
      integer, intent(in) :: threads
      logical, intent(in) :: beside  !< drawn from a copy of the field, beside the simulation
      real(wp) :: start
      integer :: ierr

      start = clock()
      p%open = .true.
      if (rank_count > 1) then
         call icoray_open(p%context, communicator, ierr, output_dir=out, threads=threads, async_render=beside, &
                          existing=ICORAY_OVERWRITE)
      else
         call icoray_open_serial(p%context, ierr, output_dir=out, threads=threads, async_render=beside, existing=ICORAY_OVERWRITE)
      end if
      call check(p, ierr, 'icoray_open')
      if (p%open) call icoray_grid_set(p%context, t%lon_center, t%lat_center, t%lon_corner, t%lat_corner, t%cell_corner, &
                                       t%corner_cell, t%corner_edge, t%edge_corner, ierr, index_base=1)
      call check(p, ierr, 'icoray_grid_set')
      if (p%open) call icoray_layers_set(p%context, level_radius, planet_radius, ierr)
      call check(p, ierr, 'icoray_layers_set')
      call settle(p)  ! so far a rank may have failed alone
      if (p%open) then
         call icoray_scene_load(p%context, scene, ierr)
         call check(p, ierr, 'icoray_scene_load')
         call settle(p)
      end if
      if (p%open .and. rank_count > 1) then
         call icoray_part_set(p%context, cell_number, ierr, owned=own_cells)
         call check(p, ierr, 'icoray_part_set')
         call settle(p)
      end if
      p%seconds = p%seconds + clock() - start
   end subroutine pictures_open

   !> Whether the scene wants a picture of this step: asked before the vorticity is computed for it.
   logical function pictures_wanted(p, step, time) result(wanted)
      type(pictures_type), intent(inout) :: p
      integer(ik), intent(in) :: step
      real(wp), intent(in) :: time  !< s
      real(wp) :: start

      start = clock()
      if (p%open) then
         call icoray_wants(p%context, step, time, wanted)
      end if
      p%asked = p%asked + 1
      p%asking = p%asking + clock() - start
      p%seconds = p%seconds + clock() - start
      if (.not. p%open) wanted = .true.  ! so that what is missing is counted
   end function pictures_wanted

   !> Draws the scene from the arrays as they are now. They are handed over here: models swap time levels, and a pointer that
   !> is given once shows the step before at every odd step.
   subroutine pictures_draw(p, height, vorticity, step, time, date)
      type(pictures_type), intent(inout) :: p
      real(wp), intent(in), target, contiguous :: height(:, :), vorticity(:, :)  !< (layers, cells), (layers, corners)
      integer(ik), intent(in) :: step
      real(wp), intent(in) :: time  !< s
      character(*), intent(in) :: date
      real(wp) :: start
      integer :: ierr

      start = clock()
      if (p%open) then
         ! A failure here on one rank is the status of icoray_execute on all.
         call icoray_field_set(p%context, 'height', height)
         call icoray_field_set(p%context, 'vorticity', vorticity, location=ICORAY_CORNER)
         call icoray_execute(p%context, step, time, date, ierr)
         call check(p, ierr, 'icoray_execute')
         call settle(p)
      end if
      if (p%open) then
         p%taken = p%taken + 1
      else
         p%failed = p%failed + 1
      end if
      p%seconds = p%seconds + clock() - start
   end subroutine pictures_draw

   !> Waits for the last picture: a thread of icoray writes them, and the next call returns a failure.
   subroutine pictures_close(p)
      type(pictures_type), intent(inout) :: p
      real(wp) :: start
      integer :: ierr

      if (.not. p%open) return
      start = clock()
      call icoray_close(p%context, ierr)
      if (ierr /= ICORAY_OK) p%failed = p%failed + 1
      call check(p, ierr, 'icoray_close')
      call settle(p)
      p%open = .false.
      p%seconds = p%seconds + clock() - start
   end subroutine pictures_close

   !> On an error, keeps what is to be said and draws no more.
   subroutine check(p, ierr, what)
      type(pictures_type), intent(inout) :: p
      integer, intent(in) :: ierr
      character(*), intent(in) :: what
      character(1024) :: message
      character(12) :: status

      if (.not. p%open .or. ierr == ICORAY_OK) return
      p%open = .false.
      call icoray_last_error(p%context, message)
      write (status, '(i0)') ierr
      p%trouble = what//': status '//trim(status)//': '//trim(message)
   end subroutine check

   !> Collective: if any rank is in trouble, the first says why and all close.
   subroutine settle(p)
      type(pictures_type), intent(inout) :: p
      integer :: first, ignored

      first = rank_count
      if (allocated(p%trouble)) first = rank
      first = -nint(largest_of_ranks(-real(first, wp)))
      if (first == rank_count) return
      p%open = .false.
      if (first == rank) then
         write (error_unit, '(2a)') 'shallow_water: ', p%trouble
         write (error_unit, '(a)') 'shallow_water: the simulation goes on without pictures'
      end if
      call icoray_close(p%context, ignored)
   end subroutine settle

end module pictures
