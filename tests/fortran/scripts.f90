!> Scene files of several views: each is drawn in its own steps.
module scripts
  use icoray
  use check
  use model
  use, intrinsic :: iso_fortran_env, only: int64, real32, real64
  implicit none
  private
  public :: draw_scripts

contains

  subroutine draw_scripts()
    character(len=1), parameter :: nl = new_line('a')
    type(icoray_context) :: ctx
    type(icoray_frame_report) :: report
    real(real32), allocatable, target :: values(:, :), watched(:, :)
    character(len=:), allocatable :: toml
    integer :: ierr, step, frames
    logical :: wants, wants_f, wants_w
    character(len=8) :: field
    character(len=:), allocatable :: fields
    ctx = opened('scripts')
    fields = ''
    values = at_centers
    watched = at_centers
    toml = base_scene('{view}')//'[[views]]'//nl//'name = "still"'//nl//'every = 2'//nl//'camera.lon = 80'//nl &
      //'[[views]]'//nl//'name = "once"'//nl//'every = 3'//nl//'camera.lon = 140'//nl//'when = "max(w) > 2.5"'//nl
    call icoray_field_set(ctx, 'f', values, ierr)
    call went_well(ctx, ierr, 'icoray_field_set')
    call icoray_field_set(ctx, 'w', watched, ierr)
    call went_well(ctx, ierr, 'icoray_field_set')
    call icoray_scene_text(ctx, toml//'colour = 1'//nl, ierr)
    call refused(ctx, ierr, ICORAY_ERR_SCENE, 'line')
    call icoray_scene_text(ctx, toml, ierr)
    call went_well(ctx, ierr, 'icoray_scene_text')
    do step = 1, 3
      call icoray_scene_field(ctx, step, field, ierr)
      call went_well(ctx, ierr, 'icoray_scene_field')
      fields = fields//trim(field)//';'
    end do
    call expect(fields == 'f;w;;', 'icoray_scene_field: '//fields)
    do step = 0, 4
      watched = real(step, real32)
      frames = merge(1, 0, mod(step, 2) == 0) + merge(1, 0, step == 3)
      call icoray_wants(ctx, step, 60.0_real64*step, wants, ierr)
      call icoray_wants_field(ctx, 'f', step, 60.0_real64*step, wants_f, ierr)
      call icoray_wants_field(ctx, 'w', step, 60.0_real64*step, wants_w, ierr)
      call expect(wants .eqv. (mod(step, 2) == 0 .or. mod(step, 3) == 0), 'icoray_wants')
      call expect((wants_f .eqv. wants) .and. (wants_w .eqv. mod(step, 3) == 0), 'icoray_wants_field')
      call icoray_execute(ctx, step, 60.0_real64*step, ierr)
      call went_well(ctx, ierr, 'icoray_execute')
      if (frames == 0) cycle
      call icoray_report(ctx, report, ierr)
      call went_well(ctx, ierr, 'icoray_report')
      call expect(report%step == int(step, int64) .and. report%frames == frames, 'frames')
    end do
    call icoray_close(ctx, ierr)
    call expect(ierr == ICORAY_OK, 'icoray_close')
  end subroutine draw_scripts
end module scripts
