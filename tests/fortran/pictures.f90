!> Pictures and refusals through the Fortran module: pictures <directory> <level> <pixels>
!>
!> A picture's name is its group and its step; tests/fortran.rs compares the pixels of a group.
program pictures
  use icoray
  use check
  use model
  use layouts
  use grids
  use refusals
  use scripts
  implicit none
  call start_model()
  call expect(index(icoray_version(), '.') > 0, 'icoray_version')
  call draw_layouts()
  call draw_corners()
  call draw_named()
  call draw_grids()
  call draw_scripts()
  call refuse_all()
  call end_model()
  call verdict('pictures')
end program pictures
