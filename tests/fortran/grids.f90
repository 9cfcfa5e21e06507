!> Grids as models have them in memory: kinds, numberings and longer arrays make no difference to a picture.
module grids
  use icoray
  use check
  use model
  use, intrinsic :: iso_fortran_env, only: int32, int64, real32, real64
  implicit none
  private
  public :: draw_grids

contains

  subroutine draw_grids()
    type(icoray_context) :: ctx
    type(icoray_grid) :: grid
    real(real32), allocatable, target :: values(:, :)
    real(real32), allocatable, target :: lon_c4(:), lat_c4(:), lon_v4(:), lat_v4(:)
    integer(int32), allocatable, target :: cc(:, :), ce(:, :), cv(:, :), ev(:, :), n(:)
    integer(int64), allocatable, target :: cc8(:, :), ce8(:, :), cv8(:, :), ev8(:, :), n8(:)
    integer :: ierr, step
    values = at_centers
    step = 100
    ctx = opened('grids')
    call icoray_field_set(ctx, 'f', values)
    associate (t => tables)
      ! Base 0: the mesh's own tables, then in 64 bits.
      call icoray_grid_set(ctx, t%lon_center, t%lat_center, t%lon_corner, t%lat_corner, t%cell_corner, t%corner_cell, &
        t%corner_edge, t%edge_corner, ierr, index_base=0)
      call draw('plain')
      cv8 = t%cell_corner
      cc8 = t%corner_cell
      ce8 = t%corner_edge
      ev8 = t%edge_corner
      call icoray_grid_set(ctx, t%lon_center, t%lat_center, t%lon_corner, t%lat_corner, cv8, cc8, ce8, ev8, ierr, 0)
      call draw('plain')
      ! Base 1, which is the default.
      cv = t%cell_corner + 1_int32
      cc = t%corner_cell + 1_int32
      ce = t%corner_edge + 1_int32
      ev = t%edge_corner + 1_int32
      call icoray_grid_set(ctx, t%lon_center, t%lat_center, t%lon_corner, t%lat_corner, cv, cc, ce, ev, ierr)
      call draw('plain')
      cv8 = cv
      cc8 = cc
      ce8 = ce
      ev8 = ev
      call icoray_grid_set(ctx, t%lon_center, t%lat_center, t%lon_corner, t%lat_corner, cv8, cc8, ce8, ev8, ierr)
      call draw('plain')
      ! Rounded coordinates are another sphere, but by less than a picture shows.
      lon_c4 = real(t%lon_center, real32)
      lat_c4 = real(t%lat_center, real32)
      lon_v4 = real(t%lon_corner, real32)
      lat_v4 = real(t%lat_corner, real32)
      call icoray_grid_set(ctx, lon_c4, lat_c4, lon_v4, lat_v4, cv, cc, ce, ev, ierr)
      call draw('plain')
      call icoray_grid_set(ctx, lon_c4, lat_c4, lon_v4, lat_v4, cv8, cc8, ce8, ev8, ierr)
      call draw('plain')
      ! Points alone.
      call icoray_points_set(ctx, t%lon_center, t%lat_center, ierr)
      call draw('plain')
      call icoray_points_set(ctx, lon_c4, lat_c4, ierr, name='')
      call draw('plain')
      ! An address for each.
      call icoray_mesh_grid(mesh, grid)
      call icoray_grid_set(ctx, grid, ierr)
      call draw('plain')
    end associate
    call mpas_like()
    call icoray_close(ctx)

  contains

    !> As MPAS has them: one column longer than the count, rows of maxEdges, of which nEdgesOnCell count.
    subroutine mpas_like()
      real(real64), pointer :: lon(:), lat(:), lon_v(:), lat_v(:)
      integer :: c, k
      allocate (lon(cells + 1), lat(cells + 1), lon_v(corners + 1), lat_v(corners + 1), source=huge(1.0_real64))
      lon(:cells) = tables%lon_center
      lat(:cells) = tables%lat_center
      lon_v(:corners) = tables%lon_corner
      lat_v(:corners) = tables%lat_corner
      cv = wide(8, cells, tables%cell_corner + 1_int32)
      cc = wide(3, corners, tables%corner_cell + 1_int32)
      ce = wide(3, corners, tables%corner_edge + 1_int32)
      ev = wide(2, edges, tables%edge_corner + 1_int32)
      allocate (n(cells + 1), source=-huge(1_int32))
      do c = 1, cells
        n(c) = 0
        do k = 1, 6
          if (any(cv(:n(c), c) == cv(k, c))) cycle
          n(c) = n(c) + 1_int32
          cv(n(c), c) = cv(k, c)
        end do
        cv(n(c) + 1:, c) = -5
      end do
      call expect(count(n(:cells) == 5) == 12 .and. count(n(:cells) == 6) == cells - 12, 'twelve pentagons')
      call icoray_grid_set(ctx, lon, lat, lon_v, lat_v, cv, cc, ce, ev, ierr, cell_corner_count=n, cells=cells, &
        corners=corners, edges=edges)
      call draw('plain')
      cv8 = cv
      cc8 = cc
      ce8 = ce
      ev8 = ev
      n8 = n
      call icoray_grid_set(ctx, lon, lat, lon_v, lat_v, cv8, cc8, ce8, ev8, ierr, cell_corner_count=n8, cells=cells, &
        corners=corners, edges=edges)
      call draw('plain')
      ! Without the numbers the column of garbage is a cell too many.
      call icoray_grid_set(ctx, lon, lat, lon_v, lat_v, cv, cc, ce, ev, ierr, cell_corner_count=n)
      call expect(ierr /= ICORAY_OK, 'a column of garbage')
      call draw_again('plain')
      deallocate (lon, lat, lon_v, lat_v)
    end subroutine mpas_like

    function wide(row, rows, table) result(longer)
      integer, intent(in) :: row, rows
      integer(int32), intent(in) :: table(:, :)
      integer(int32) :: longer(row, rows + 1)
      longer = -huge(1_int32)
      longer(:size(table, 1), :rows) = table
    end function wide

    subroutine draw(group)
      character(len=*), intent(in) :: group
      call went_well(ctx, ierr, 'icoray_grid_set')
      call draw_again(group)
    end subroutine draw

    subroutine draw_again(group)
      character(len=*), intent(in) :: group
      call frame(ctx, group, step)
      step = step + 1
    end subroutine draw_again
  end subroutine draw_grids
end module grids
