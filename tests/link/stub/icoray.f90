! Stands for the Fortran module while there is none: the C functions that minimal.f90 beside it needs, as they are. To
! be removed, with this directory, when include/icoray.f90 and examples/fortran/minimal.f90 are there.
module icoray
  use, intrinsic :: iso_c_binding
  implicit none

  interface
    integer(c_int32_t) function icoray_mesh_create(level, mesh) bind(C)
      import
      integer(c_int32_t), value :: level
      type(c_ptr), intent(out) :: mesh
    end function

    integer(c_int32_t) function icoray_mesh_free(mesh) bind(C)
      import
      type(c_ptr), intent(inout) :: mesh
    end function

    integer(c_int32_t) function icoray_mesh_grid(mesh, grid) bind(C)
      import
      type(c_ptr), value :: mesh
      integer(c_int64_t), intent(inout) :: grid(*)
    end function

    integer(c_int32_t) function icoray_open_serial(config, ctx) bind(C)
      import
      integer(c_int64_t), intent(in) :: config(*)
      type(c_ptr), intent(out) :: ctx
    end function

    integer(c_int32_t) function icoray_grid_set(ctx, grid) bind(C)
      import
      type(c_ptr), value :: ctx
      integer(c_int64_t), intent(in) :: grid(*)
    end function

    integer(c_int32_t) function icoray_layers_set(ctx, layers) bind(C)
      import
      type(c_ptr), value :: ctx
      integer(c_int64_t), intent(in) :: layers(*)
    end function

    integer(c_int32_t) function icoray_field_set(ctx, name, array) bind(C)
      import
      type(c_ptr), value :: ctx
      character(c_char), intent(in) :: name(*)
      integer(c_int64_t), intent(in) :: array(*)
    end function

    integer(c_int32_t) function icoray_scene_text(ctx, toml) bind(C)
      import
      type(c_ptr), value :: ctx
      character(c_char), intent(in) :: toml(*)
    end function

    integer(c_int32_t) function icoray_execute(ctx, step, time_s, iso_datetime) bind(C)
      import
      type(c_ptr), value :: ctx, iso_datetime
      integer(c_int64_t), value :: step
      real(c_double), value :: time_s
    end function

    integer(c_int32_t) function icoray_close(ctx) bind(C)
      import
      type(c_ptr), intent(inout) :: ctx
    end function
  end interface
end module
