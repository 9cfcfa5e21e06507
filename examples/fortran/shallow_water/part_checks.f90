!> That parts of the mesh do as the whole mesh does, to the bit. First each of several partitions is cut up here, in this process,
!> with halos that are copied from the whole; then the ranks of this run take some steps, with halos that they exchange.
module part_checks
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use kinds, only: wp
   use tables, only: grid_tables
   use mesh, only: mesh_type, halo
   use operators, only: operators_type
   use trisk, only: workspace, new_workspace, tendencies, vorticity_at_corners
   use model, only: state_type, stepper_type, new_state, new_stepper, advance
   use partition, only: partition_by_curve
   use parts, only: part_type, choose, cut, share
   use ranks, only: rank, rank_count, largest_of_ranks, exchange
   use checking, only: check, noise
   implicit none
   private
   public :: check_parts

   integer, parameter :: layers = 3
   real(wp), parameter :: dt = 60.0_wp, lead = 30.0_wp  ! s

contains

   subroutine check_parts(t, m, o, well)
      type(grid_tables), intent(in) :: t
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      logical, intent(inout) :: well
      integer, allocatable :: owner(:)
      integer, parameter :: numbers(*) = [2, 3, 4, 7]
      character(12) :: of_parts
      integer :: i, c

      do i = 1, size(numbers)
         call partition_by_curve(m, numbers(i), owner)
         write (of_parts, '(", ",i0," parts")') numbers(i)
         associate (cells => [(count(owner == c), c=0, numbers(i) - 1)])
            call check('cells of the largest part less those of the smallest'//of_parts, &
                       real(maxval(cells) - minval(cells), wp), 1.0_wp, well)
         end associate
         call check_cuts(t, m, o, owner, numbers(i), of_parts, well)
      end do
      ! one in ten cells is an island in another's part
      owner = merge(modulo(owner + 1, numbers(size(numbers))), owner, [(noise(c) > 0.8_wp, c=1, m%cells)])
      call check_cuts(t, m, o, owner, numbers(size(numbers)), ', scattered', well)
      call check_steps(t, m, o, well)
   end subroutine check_parts

   !> Counts what is not owned once, and the bits of tendencies and vorticity that are not those of the whole mesh.
   subroutine check_cuts(t, m, o, owner, number, which, well)
      type(grid_tables), intent(in) :: t
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      integer, intent(in) :: owner(:), number
      character(*), intent(in) :: which
      logical, intent(inout) :: well
      type(state_type) :: s
      real(wp), allocatable :: dh(:, :), du(:, :), vorticity(:, :)
      integer :: owners(m%cells), part, wrong

      call noisy_state(m, s)
      call evaluate(m, o, s, dh, du, vorticity)
      owners = 0
      wrong = 0
      do part = 0, number - 1
         block
            type(part_type) :: p
            type(grid_tables) :: part_t
            type(mesh_type) :: part_m
            type(operators_type) :: part_o
            type(state_type) :: part_s
            real(wp), allocatable :: part_dh(:, :), part_du(:, :), part_vorticity(:, :)
            call choose(m, owner, part, p)
            call cut(p, t, m, o, part_t, part_m, part_o)
            call restrict(p, s, p%cells_in(halo), p%edges_in(halo), part_s)
            call evaluate(part_m, part_o, part_s, part_dh, part_du, part_vorticity)
            associate (cell => p%cell(:p%cells_in(0)), edge => p%edge(:p%edges_in(0)), corner => p%corner(:p%corners_in(2)))
               owners(cell) = owners(cell) + 1
               wrong = wrong + count(differ(part_dh(:, :size(cell)), dh(:, cell))) &
                       + count(differ(part_du(:, :size(edge)), du(:, edge))) &
                       + count(differ(part_vorticity(:, :size(corner)), vorticity(:, corner)))
            end associate
         end block
      end do
      call check('cells that are not owned once'//which, real(count(owners /= 1), wp), 0.0_wp, well)
      call check('numbers that parts have not as the whole'//which, real(wrong, wp), 0.0_wp, well)
   end subroutine check_cuts

   !> Three steps of all ranks, beside the whole mesh in each. Halos are void before.
   subroutine check_steps(t, m, o, well)
      type(grid_tables), intent(in) :: t
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      logical, intent(inout) :: well
      type(part_type) :: p
      type(grid_tables) :: part_t
      type(mesh_type) :: part_m
      type(operators_type) :: part_o
      type(state_type) :: s, part_s
      type(stepper_type) :: r, part_r
      integer, allocatable :: owner(:)
      integer :: step, wrong

      call partition_by_curve(m, rank_count, owner)
      call choose(m, owner, rank, p)
      call cut(p, t, m, o, part_t, part_m, part_o)
      call share(p, owner, m, part_m)
      call noisy_state(m, s)
      call restrict(p, s, p%cells_in(0), p%edges_in(0), part_s)
      call exchange(part_m%by_cell, part_s%h)
      call exchange(part_m%by_edge, part_s%u)
      call new_stepper(s, m, r)
      call new_stepper(part_s, part_m, part_r)
      do step = 1, 3
         call advance(m, o, dt, lead, s, r)
         call advance(part_m, part_o, dt, lead, part_s, part_r)
      end do
      wrong = count(differ(part_s%h, s%h(:, p%cell))) &
              + count(differ(part_s%u(:, :p%edges_in(halo)), s%u(:, p%edge(:p%edges_in(halo)))))
      call check('numbers that ranks have not as the whole after 3 steps', largest_of_ranks(real(wrong, wp)), 0.0_wp, well)
   end subroutine check_steps

   !> NaN differs from all.
   elemental logical function differ(a, b)
      real(wp), intent(in) :: a, b
      differ = .not. abs(a - b) <= 0.0_wp
   end function differ

   subroutine noisy_state(m, s)
      type(mesh_type), intent(in) :: m
      type(state_type), intent(out) :: s
      integer :: i, c
      call new_state(layers, m, s)
      do i = 1, layers
         s%h(i, :) = 10000.0_wp + 1000.0_wp*noise([(i*m%cells + c, c=1, m%cells)])
         s%u(i, :) = 50.0_wp*noise([(i*m%edges + c, c=1, m%edges)])
      end do
   end subroutine noisy_state

   !> A part's state, void beyond so many of its cells and edges.
   subroutine restrict(p, s, cells, edges, part)
      type(part_type), intent(in) :: p
      type(state_type), intent(in) :: s
      integer, intent(in) :: cells, edges
      type(state_type), intent(out) :: part
      part%layers = s%layers
      part%h = s%h(:, p%cell)
      part%u = s%u(:, p%edge)
      part%h(:, cells + 1:) = ieee_value(1.0_wp, ieee_quiet_nan)
      part%u(:, edges + 1:) = ieee_value(1.0_wp, ieee_quiet_nan)
   end subroutine restrict

   subroutine evaluate(m, o, s, dh, du, vorticity)
      type(mesh_type), intent(in) :: m
      type(operators_type), intent(in) :: o
      type(state_type), intent(in) :: s
      real(wp), allocatable, intent(out) :: dh(:, :), du(:, :), vorticity(:, :)
      type(workspace) :: w
      allocate (dh(layers, m%cells), du(layers, m%edges), vorticity(layers, m%corners))
      call new_workspace(layers, m, w)
      call tendencies(layers, m, o, lead, s%h, s%u, w, dh, du)
      call vorticity_at_corners(layers, m, o, s%u, vorticity)
   end subroutine evaluate

end module part_checks
