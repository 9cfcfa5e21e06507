!> shallow_water: a stack of shallow-water layers on a geodesic grid, each with an unstable jet, that draws itself with icoray
!> while it runs.
!>
!> Solves the nonlinear rotating shallow-water equations on the sphere by TRiSK, the finite-volume scheme of MPAS (Ringler et
!> al. 2010, doi:10.1016/j.jcp.2009.12.007), on the Voronoi cells of an icosahedral mesh: thickness at centres, normal velocity
!> at edges, potential vorticity at corners; energy-conserving form; classical Runge-Kutta steps. Layers do not feel each
!> other. They start from the barotropic jet of Galewsky et al. 2004 (doi:10.3402/tellusa.v16i5.14436), 40 m/s in the lowest to
!> 100 m/s in the highest, whose instability rolls the jet up within a week, the stronger the sooner.
!>
!> Build and run, from this directory, with icoray installed:
!>
!>     make
!>     build/shallow_water --scene ../../scenes/shallow_water.toml --out pictures
!>     build/shallow_water --self-test                          (properties of mesh and operators, to rounding)
!>     build/shallow_water --case williamson2 --no-pictures     (steady flow, with the error of its height)
!>
!>     make MPI=1
!>     mpirun -n 4 build_mpi/shallow_water ...                  (the same bits, each rank with its part of the mesh)
!>
!> Each day a line: drift of mass, energy and potential enstrophy since the start, relative, of the layer that drifts most;
!> extremes; seconds of that day's simulation and pictures. README.md beside this file has measured numbers.
!> All that the model adds in order to be drawn is in pictures.f90; what it computes with is in mesh, operators and trisk; what
!> makes it run over ranks is in ranks, partition and parts.
program shallow_water
   use, intrinsic :: iso_fortran_env, only: output_unit
   use kinds, only: wp, ik, pi, radius, gravity, day, clock
   use ranks, only: rank, rank_count, ranks_start, ranks_finish, largest_of_ranks
   use tables, only: grid_tables, generate, tilt, relax
   use mesh, only: mesh_type, derive
   use operators, only: operators_type, prepare
   use partition, only: partition_by_curve, read_partition, write_graph
   use parts, only: part_type, choose, cut, share
   use sums, only: fingerprint
   use trisk, only: vorticity_at_corners
   use model, only: state_type, stepper_type, integrals_type, new_state, new_stepper, advance, integrate, largest_drift
   use galewsky, only: galewsky_mean, galewsky_state
   use williamson2, only: williamson2_state, height_error
   use checks, only: self_test
   use options, only: options_type, read_options, refuse
   use pictures, only: pictures_type, pictures_open, pictures_wanted, pictures_draw, pictures_close
   use calendar, only: date_of
   implicit none

   real(wp), parameter :: weakest = 40.0_wp, strongest = 100.0_wp  ! jets, m/s
   real(wp), parameter :: top = 30000.0_wp                         ! where the stack of layers ends in the pictures, m
   real(wp), parameter :: courant = 0.7_wp                         ! of the default step: gravity waves on the shortest dc

   type(options_type) :: opt
   type(part_type), target :: part          ! what this rank has of the mesh: all that follows is of its part
   type(grid_tables), target :: grid
   type(mesh_type) :: cells
   type(operators_type) :: ops
   type(state_type), target :: state
   type(stepper_type) :: stepper
   type(integrals_type) :: start, now
   type(pictures_type) :: shots
   real(wp), allocatable, target :: vorticity(:, :)
   real(wp), allocatable :: u_max(:), level_radius(:)
   real(wp) :: shortest  ! distance of neighbouring centres, m
   real(wp) :: dt, began, simulation, shown(2), off(2)
   integer(ik) :: step, steps, every
   logical :: wanted
   integer :: k, shown_day

   call ranks_start()
   call read_options(opt)
   if (opt%self_test) call leave(self_test(opt%level, opt%lloyd))
   began = clock()
   u_max = [(weakest + (strongest - weakest)*real(k - 1, wp)/real(opt%layers - 1, wp), k=1, opt%layers)]
   level_radius = [(radius + top*(real(k, wp) - 0.5_wp)/real(opt%layers, wp), k=1, opt%layers)]
   call set_up()
   call new_stepper(state, cells, stepper)
   allocate (vorticity(opt%layers, cells%corners), source=0.0_wp)
   call integrate(cells, ops, state, start)
   call plan_steps()

   call print_head()
   if (opt%pictures) call pictures_open(shots, grid, part%cell, cells%cells_in(0), level_radius, radius, opt%scene, opt%out, &
                                        opt%threads, opt%beside)
   simulation = 0.0_wp
   shown = 0.0_wp
   shown_day = -1
   step = 0
   do
      associate (time => real(step, wp)*dt)
         if (opt%pictures) then
            ! Asked at each step: with --async, ranks move the messages of pictures on in each call.
            wanted = pictures_wanted(shots, step, time)
            if (wanted .and. (modulo(step, every) == 0 .or. step == steps)) then
               call vorticity_at_corners(opt%layers, cells, ops, state%u, vorticity)
               call pictures_draw(shots, state%h, vorticity, step, time, date_of(time))
            end if
         end if
         if (int((time + 0.5_wp*dt)/day) > shown_day .or. step == steps) call print_line(time)
      end associate
      if (step == steps .or. .not. now%highest < huge(dt)) exit
      began = clock()
      call advance(cells, ops, dt, opt%lead*dt, state, stepper)
      simulation = simulation + clock() - began
      step = step + 1
   end do
   if (opt%pictures) call pictures_close(shots)
   call print_summary()
   call leave(shots%failed == 0 .and. now%highest < huge(dt))

contains

   !> The mesh, of which each rank makes the whole and keeps its part, and the state at the start.
   subroutine set_up()
      type(grid_tables) :: whole_grid
      type(mesh_type) :: whole
      type(operators_type) :: whole_ops
      integer, allocatable :: owner(:)
      character(:), allocatable :: trouble
      real(wp) :: mean(opt%layers)

      call generate(opt%level, whole_grid)
      call tilt(whole_grid, opt%tilt*pi/180.0_wp)
      call relax(whole_grid, opt%lloyd, off(1), off(2))
      call derive(whole_grid, whole)
      call prepare(whole, whole_ops)
      shortest = minval(whole%dc)
      if (opt%graph /= '' .and. rank == 0) call write_graph(opt%graph, whole)
      if (rank_count > whole%cells) call refuse('mpirun', 'more ranks than cells')
      if (opt%partition == '') then
         call partition_by_curve(whole, rank_count, owner)
      else
         call read_partition(opt%partition, whole%cells, rank_count, owner, trouble)
         if (trouble /= '') call refuse(opt%partition, trouble)
      end if
      call choose(whole, owner, rank, part)
      call cut(part, whole_grid, whole, whole_ops, grid, cells, ops)
      call share(part, owner, whole, cells)
      call new_state(opt%layers, cells, state)
      if (opt%initial == 'williamson2') call williamson2_state(cells, state)
      if (opt%initial == 'galewsky') then
         call galewsky_mean(whole, u_max, mean)
         call galewsky_state(cells, u_max, mean, state)
      end if
   end subroutine set_up

   !> Sets the number of steps, and of those between pictures, so that dt is at most the one asked for or allowed.
   subroutine plan_steps()
      integer(ik) :: intervals
      dt = opt%dt
      if (.not. dt > 0.0_wp) then
         dt = courant*shortest/(sqrt(gravity*start%highest) &
                                + largest_of_ranks(maxval(abs(state%u(:, :cells%edges_in(0))))))
      end if
      every = opt%every
      if (every > 0) then
         steps = ceiling(opt%days*day/dt, ik)
      else
         intervals = max(1_ik, nint(4.0_wp*opt%days, ik))
         every = ceiling(opt%days*day/real(intervals, wp)/dt, ik)
         steps = intervals*every
      end if
      dt = opt%days*day/real(steps, wp)
   end subroutine plan_steps

   subroutine print_head()
      integer :: own(2), around(2)
      own = range_of(cells%cells_in(0))
      around = range_of(cells%cells - cells%cells_in(0))
      if (rank /= 0) return
      write (*, '(3(a,i0),a,f0.3,a,i0,a)') 'shallow_water: ', cells%by_cell%total, ' cells, ', opt%layers, ' layers, ', steps, &
         ' steps of ', dt, ' s, a picture every ', every, ' steps'
      if (rank_count > 1) write (*, '(5(i0,a))') rank_count, ' ranks, each with ', own(1), ' to ', own(2), &
         ' cells of its own and ', around(1), ' to ', around(2), ' of others around them'
      write (*, '(a,f7.1,a,f7.1,a,2(f7.4,a))') 'set up in', clock() - began, ' s; centres are at least', shortest/1000.0_wp, &
         ' km apart, and', off(1), ' of a spacing from their centroids at most,', off(2), ' in the mean'
      write (*, '(a)') '   day       mass     energy  enstrophy    min h/m   max h/m  max vort*s simulate/s   pictures/s'
   end subroutine print_head

   !> The least and the largest of all ranks.
   function range_of(n) result(range)
      integer, intent(in) :: n
      integer :: range(2)
      range = nint([-largest_of_ranks(-real(n, wp)), largest_of_ranks(real(n, wp))])
   end function range_of

   subroutine print_line(time)
      real(wp), intent(in) :: time
      call integrate(cells, ops, state, now)
      shown_day = int((time + 0.5_wp*dt)/day)
      if (rank /= 0) return
      write (*, '(f6.2,3es11.2,2f10.2,es11.3,f11.2,f13.2)') time/day, largest_drift(now%mass, start%mass), &
         largest_drift(now%energy, start%energy), largest_drift(now%enstrophy, start%enstrophy), now%lowest, now%highest, &
         now%vorticity, simulation - shown(1), shots%seconds - shown(2)
      flush (output_unit)
      shown = [simulation, shots%seconds]
   end subroutine print_line

   subroutine print_summary()
      real(wp) :: mass, energy, l2, largest
      integer(ik) :: bits
      if (opt%initial == 'williamson2') call height_error(cells, state, l2, largest)
      bits = ieor(fingerprint(cells%by_cell, part%cell, state%h), fingerprint(cells%by_edge, part%edge, state%u))
      if (rank /= 0) return
      mass = largest_drift(now%mass, start%mass)
      energy = largest_drift(now%energy, start%energy)
      if (opt%initial == 'williamson2') write (*, '(a,es10.3,a,es10.3)') 'height error   l2', l2, ', largest', largest
      write (*, '(a,a,a,es10.2)') 'mass           ', trim(merge('conserved to rounding', 'NOT conserved        ', &
         abs(mass) <= epsilon(mass)*real(max(steps, 100_ik), wp))), ', relative drift', mass
      write (*, '(a,es10.2,a,es10.2,a)') 'energy         relative drift', energy, ' of the total, ', &
         largest_drift(now%energy - start%energy + start%kinetic, start%kinetic), ' of the kinetic energy at the start'
      write (*, '(a,es10.2,a)') 'enstrophy      relative drift', largest_drift(now%enstrophy, start%enstrophy), ', potential'
      write (*, '(a,f9.3,3a)') 'simulation     ', simulation, ' s, ', decimal(simulation/real(steps, wp)), ' s per step'
      write (*, '(a,f9.3,a,i0,a)') 'visualization  ', shots%seconds, ' s, ', shots%taken, ' pictures'
      if (shots%asked > 0) write (*, '(a,f9.6,a,i0,a)') '   of which    ', shots%asking, ' s to ask ', shots%asked, &
         ' times whether a picture is wanted'
      ! for programs to read
      write (*, '(a,i0,a,i0,4a,a,es10.3,a,es10.3,a,i0,a,z16.16)') 'summary steps=', steps, ' frames=', shots%taken, &
         ' simulation_s=', decimal(simulation), ' visualization_s=', decimal(shots%seconds), ' mass_drift=', mass, &
         ' energy_drift=', energy, ' pictures_failed=', shots%failed, ' fingerprint=', bits
   end subroutine print_summary

   subroutine leave(well)
      logical, intent(in) :: well
      call ranks_finish()
      stop merge(0, 1, well), quiet=.true.
   end subroutine leave

   !> With six decimals and a digit before them.
   function decimal(x) result(text)
      real(wp), intent(in) :: x
      character(:), allocatable :: text
      character(24) :: buffer
      write (buffer, '(f24.6)') x
      text = trim(adjustl(buffer))
   end function decimal

end program shallow_water
