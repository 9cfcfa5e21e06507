! A picture from Fortran without the module's types: a struct is an array of words, whose size, the first of them, is
! found by trying, as it changes while the types are being written.
program minimal
  use icoray
  implicit none
  integer(c_int64_t), dimension(64) :: config = 0, grid = 0, layers = 0, array = 0
  real(c_double), target :: radius(2) = [6.4e6_c_double, 6.9e6_c_double], field(642)
  type(c_ptr) :: mesh, ctx
  character(*), parameter :: scene = "field = 'q'" // c_new_line // "image = { width = 64, height = 64 }" // c_new_line &
    // "camera = { lon = 0, lat = 30, distance = 4, fov = 40 }" // c_new_line &
    // "transfer = { unit_length = 0.1, knots = [ { value = 0, color = '#0000ff', opacity = 0.5 }," // c_new_line &
    // "{ value = 1, color = '#ff0000', opacity = 0.5 }] }" // c_new_line &
    // "output = { file = 'fortran_{step:04}.png' }" // c_new_line // c_null_char
  integer :: size, i

  field = [(real(i, c_double) / 642, i = 1, 642)]
  call check(icoray_mesh_create(3, mesh))
  do size = 8, 512, 8
    config(1) = size
    if (icoray_open_serial(config, ctx) == 0) exit
  end do
  do size = 8, 512, 8
    grid(1) = size
    if (icoray_mesh_grid(mesh, grid) == 0) exit
  end do
  call check(icoray_grid_set(ctx, grid))
  layers(2:4) = [2_c_int64_t, transfer(c_loc(radius), 1_c_int64_t), transfer(6.4e6_c_double, 1_c_int64_t)]
  do size = 8, 512, 8
    layers(1) = size
    if (icoray_layers_set(ctx, layers) == 0) exit
  end do
  array(2:7) = [transfer(c_loc(field), 1_c_int64_t), 2_c_int64_t, 642_c_int64_t, 2_c_int64_t, 1_c_int64_t, 0_c_int64_t]
  do size = 8, 512, 8
    array(1) = size
    if (icoray_field_set(ctx, "q" // c_null_char, array) == 0) exit
  end do
  call check(icoray_scene_text(ctx, scene))
  call check(icoray_execute(ctx, 0_c_int64_t, 0.0_c_double, c_null_ptr))
  call check(icoray_close(ctx))
  call check(icoray_mesh_free(mesh))

contains

  subroutine check(status)
    integer(c_int32_t), intent(in) :: status
    if (status /= 0) error stop "a call failed"
  end subroutine
end program
