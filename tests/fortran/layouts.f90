!> Fields as models have them in memory: the same values are the same picture.
module layouts
  use icoray
  use check
  use model
  use, intrinsic :: iso_c_binding, only: c_loc
  use, intrinsic :: iso_fortran_env, only: int64, real32, real64
  implicit none
  private
  public :: draw_layouts, draw_corners, draw_named

  !> A model's column, of which one component is drawn.
  type :: cell_state
    real(real64) :: t
    real(real32) :: u, v
  end type cell_state

contains

  subroutine draw_layouts()
    integer, parameter :: nproma = 16
    type(icoray_context) :: ctx
    real(real32), allocatable, target :: level(:, :), longer(:, :), cell(:, :), block(:, :, :), four(:, :, :, :)
    real(real64), allocatable, target :: level8(:, :), longer8(:, :), cell8(:, :), block8(:, :, :), four8(:, :, :, :)
    real(real32), allocatable, target :: shifted(:, :)
    real(real32), pointer :: swapped(:, :), component(:, :)
    type(cell_state), allocatable, target :: state(:, :)
    type(icoray_array) :: array
    type(icoray_ndarray) :: ndarray
    integer :: c, step
    ctx = opened('layouts')
    level = at_centers
    cell = transpose(at_centers)
    allocate (longer(nz, cells + 1), source=garbage)
    longer(:, :cells) = at_centers
    allocate (block(nproma, nz, (cells + nproma - 1)/nproma), source=garbage)
    do c = 0, cells - 1
      block(mod(c, nproma) + 1, :, c/nproma + 1) = at_centers(:, c + 1)
    end do
    call expect(mod(cells, nproma) /= 0, 'the last block is partly filled')
    allocate (four(3, 2*nz, cells + 2, 2), source=garbage)
    four(2, 2::2, :cells, 2) = at_centers
    allocate (shifted(0:nz - 1, -7:cells - 8), source=at_centers)
    allocate (swapped(-1:nz - 2, 5:cells + 4), source=at_centers)
    allocate (state(nz, cells), source=cell_state(1e30_real64, garbage, garbage))
    state%v = at_centers
    level8 = level
    longer8 = longer
    cell8 = cell
    block8 = block
    four8 = four

    step = 0
    call icoray_field_set(ctx, 'f', level)
    call draw()
    call icoray_field_set(ctx, 'f', longer)
    call draw()
    call icoray_field_set(ctx, 'f', longer(:, :cells))
    call draw()
    call icoray_field_set(ctx, 'f', cell)
    call draw()
    call icoray_field_set(ctx, 'f', block)
    call draw()
    call icoray_field_set(ctx, 'f', four(2, 2::2, :, 2))
    call draw()
    call icoray_field_set(ctx, 'f', four(2:2, 2::2, :, 2:2))
    call draw()
    call icoray_field_set(ctx, 'f', four(2, 2::2, :, 2:2))
    call draw()
    call icoray_field_set(ctx, 'f', shifted)
    call draw()
    call icoray_field_set(ctx, 'f', swapped)
    call draw()
    component => state%v
    call icoray_field_set(ctx, 'f', component)
    call draw()
    call icoray_field_set(ctx, 'f', level8)
    call draw()
    call icoray_field_set(ctx, 'f', longer8)
    call draw()
    call icoray_field_set(ctx, 'f', cell8)
    call draw()
    call icoray_field_set(ctx, 'f', block8)
    call draw()
    call icoray_field_set(ctx, 'f', four8(2, 2::2, :, 2))
    call draw()
    call icoray_field_set(ctx, 'f', four8(2:2, 2::2, :, 2:2))
    call draw()

    array = icoray_array(data=c_loc(level), type=ICORAY_F32, columns=cells, layers=nz, column_stride=nz, &
      layer_stride=1)
    call icoray_field_set(ctx, 'f', array)
    call draw()
    ndarray = icoray_ndarray(data=c_loc(level), type=ICORAY_F32, rank=2)
    ndarray%extent(:2) = shape(level)
    ndarray%stride(:2) = [1, nz]
    call icoray_field_set_ndarray(ctx, 'f', ndarray)
    call draw()

    ! The radii fall: level 1 of the section is the top.
    call icoray_layers_set(ctx, radius(nz:1:-1), planet)
    call icoray_field_set(ctx, 'f', level(nz:1:-1, :))
    call draw()
    call icoray_field_set(ctx, 'f', cell8(:, nz:1:-1))
    call draw()
    ! Cells backwards are another field.
    call icoray_layers_set(ctx, radius, planet)
    call icoray_field_set(ctx, 'f', level(:, cells:1:-1))
    call frame(ctx, 'backwards', 0)

    ! Handed over once and changed in place, in whichever way.
    call icoray_field_set(ctx, 'f', four(2, 2::2, :, 2))
    four(2, 2::2, :cells, 2) = -at_centers
    call frame(ctx, 'negative', 0)
    call icoray_field_set(ctx, 'f', component)
    state%v = -at_centers
    call frame(ctx, 'negative', 1)
    call icoray_close(ctx)
    deallocate (swapped)

  contains

    subroutine draw()
      call frame(ctx, 'plain', step)
      step = step + 1
    end subroutine draw
  end subroutine draw_layouts

  !> Values at corners.
  subroutine draw_corners()
    type(icoray_context) :: ctx
    real(real32), allocatable, target :: level(:, :), cell(:, :), longer(:, :)
    ctx = opened('corners')
    level = at_corners
    cell = transpose(at_corners)
    allocate (longer(nz, corners + 1), source=garbage)
    longer(:, :corners) = at_corners
    call icoray_field_set(ctx, 'f', level, location=ICORAY_CORNER)
    call frame(ctx, 'corner', 0)
    call icoray_field_set(ctx, 'f', cell, location=ICORAY_CORNER)
    call frame(ctx, 'corner', 1)
    call icoray_field_set(ctx, 'f', longer, location=ICORAY_CORNER)
    call frame(ctx, 'corner', 2)
    call icoray_close(ctx)
  end subroutine draw_corners

  !> Rows one after the other, several grids and sets of layers, missing values.
  subroutine draw_named()
    type(icoray_context) :: ctx
    real(real32), allocatable, target :: flat(:), few(:, :)
    real(real64), allocatable, target :: flat8(:)
    type(icoray_mesh) :: other
    type(icoray_frame_report) :: report
    integer :: ierr
    ctx = opened('named')
    call icoray_mesh_create(0, other)
    call icoray_grid_set(ctx, other, ierr, name='coarse  ')
    call went_well(ctx, ierr, 'a second grid')
    call icoray_layers_set(ctx, real(radius(:3), real32), real(planet, real32), ierr, name='thin')
    call went_well(ctx, ierr, 'a second set of layers')
    allocate (few(2, 12), source=0.5_real32)
    call icoray_field_set(ctx, 'f ', few, grid_name='coarse', layers_name='thin  ', ierr=ierr)
    call went_well(ctx, ierr, 'a field on the second grid')
    call frame(ctx, 'coarse', 0)
    flat = reshape(at_centers, [nz*cells])
    flat8 = flat
    call icoray_field_set(ctx, 'f', flat)
    call frame(ctx, 'plain', 300)
    call icoray_field_set(ctx, 'f', flat8)
    call frame(ctx, 'plain', 301)
    ! -9.9999e30 is another number in 32 than in 64 bits.
    flat(::5) = -9.9999e30_real32
    flat8(::5) = -9.9999e30_real64
    call icoray_field_describe(ctx, 'f', 'a field of the tests', 'm s-1', ierr)
    call went_well(ctx, ierr, 'icoray_field_describe')
    call icoray_field_describe(ctx, '', 'a field without a name', ' ', ierr)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'name')
    call icoray_scene_text(ctx, base_scene('missing'))
    call icoray_field_set(ctx, 'f', flat, ierr, ICORAY_CENTER, -9.9999e30_real32)
    call icoray_execute(ctx, 4, 0.0_real64)
    call icoray_report(ctx, report)
    call expect(report%missing_values == size(flat(::5)) .and. report%bytes_copied == 0, 'missing values, 32 bits')
    call icoray_field_set(ctx, 'f', flat8, fill_value=-9.9999e30_real64)
    call icoray_execute(ctx, 5, 0.0_real64)
    call icoray_report(ctx, report)
    call expect(report%missing_values == size(flat(::5)) .and. report%bytes_copied == 0, 'missing values, 64 bits')

    ! A name with a date needs one, with either kind of step.
    flat = reshape(at_centers, [nz*cells])/2
    call icoray_field_set(ctx, 'f', flat)
    call icoray_scene_text(ctx, base_scene('year_$Y'))
    call icoray_execute(ctx, 7, 0.0_real64, ierr)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, 'date is absent')
    call icoray_execute(ctx, 7, 0.0_real64, '0001-02-03', ierr)
    call refused(ctx, ierr, ICORAY_ERR_ARGUMENT, '0001-02-03')
    call icoray_execute(ctx, 7, 0.0_real64, '0001-02-03_04:05:06  ', ierr)
    call went_well(ctx, ierr, 'a date')
    call icoray_execute(ctx, 8_int64, 0.0_real64, '0001-02-03T04:05:06', ierr)
    call went_well(ctx, ierr, 'a date and a step of 64 bits')
    call icoray_close(ctx, ierr)
    call expect(ierr == ICORAY_OK, 'icoray_close')
    call icoray_mesh_free(other)
  end subroutine draw_named
end module layouts
