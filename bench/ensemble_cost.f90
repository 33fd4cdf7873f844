!> What many bodies cost: a step of a lane over one of the scalar stepper, in the same process, how well it conserves,
!> whole sweeps by their number of members and of threads, and files of rows.
program bench_ensemble
   use, intrinsic :: iso_fortran_env, only: int64
   use, intrinsic :: iso_c_binding, only: c_double
   use nutate, only: gravity_gradient_t, gravity_t, integrator_settings_t, kinetic_energy, make_body, &
      make_shape_body, make_state, make_stepper, parse_scene, rotor_t, scene_t, space_momentum, state_t, status_t, &
      stepper_t, system_t, total_energy, wp
   use nutate_member_rows, only: fill_rows, has_threads
   use nutate_npy, only: npy_header
   use nutate_methods, only: default_settings
   use nutate_row_layout, only: make_layout, row_layout_t
   use nutate_sweep_csv, only: write_csv
   use nutate_sweep_file, only: sweep_file_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   use nutate_taylor_lanes, only: lanes, taylor_lanes_t
   implicit none

   interface
      real(c_double) function bench_thread_seconds() bind(C)
         import :: c_double
      end function bench_thread_seconds

      real(c_double) function bench_process_seconds() bind(C)
         import :: c_double
      end function bench_process_seconds
   end interface

   !> Bodies: a rod and the paper's box with rotors, the box hung up, a heavy top, a satellite in the gradient of
   !> gravity; with the steps that they are moved by, s.
   integer, parameter :: repeats = 25, orders(3) = [12, 16, 24]
   character(len=*), parameter :: kinds(5) = [character(len=9) :: 'rod', 'gyrostat', 'hung box', 'top', &
                                              'satellite']
   real(wp), parameter :: dt(5) = [0.1_wp, 0.1_wp, 0.1_wp, 0.002_wp, 100.0_wp]
   integer :: i, k

   write (*, '(a)') 'ns a body-step: alone, in a lane, and the ratio'
   do k = 1, size(dt)
      do i = 1, size(orders)
         call compare(k, orders(i), 3000)
      end do
   end do
   write (*, '(/,a)') 'largest error of energy and of what is conserved of momentum, in lanes, 1e6 steps of order 16'
   do k = 1, size(dt)
      call drift(k, 16, 1000000)
   end do
   write (*, '(/,a)') 'us a member of 100 steps (one thread: CPU time; two: CPU time of both, wall time)'
   write (*, '(a)') '  members threads alone together'
   do i = 2, 6
      call sweep(10_int64**i, 1)
      if (has_threads()) call sweep(10_int64**i, 2)
   end do
   call files()

contains

   !> Body k and the start of the n-th of its kind.
   subroutine take(k, n, system, state)
      integer, intent(in) :: k, n
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: state
      type(status_t) :: status
      real(wp), parameter :: upright(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      if (k == 1) then
         call make_shape_body('cylinder', [0.5_wp, 4.0_wp], system%body, status, mass=12.0_wp)
         call system%effects%add(rotor_t(name='rotor', momentum=[0.0_wp, 0.0_wp, 5.0_wp]))
         state = make_state(system, upright, [0.1_wp, 0.1_wp*n, 10.0_wp])
      else if (k == 3) then
         call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], system%body, status, mass=12.0_wp)
         system%body%center_of_mass = [0.0_wp, 0.0_wp, 1.0_wp]
         call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
         state = make_state(system, upright, [0.1_wp, 0.1_wp*n, 10.0_wp])
      else if (k == 2) then
         call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], system%body, status, mass=12.0_wp)
         call system%effects%add(rotor_t(name='rotor', momentum=[2.0_wp, 1.0_wp, 5.0_wp]))
         state = make_state(system, upright, [0.1_wp, 0.1_wp*n, 10.0_wp])
      else if (k == 5) then
         call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], system%body, status, mass=12.0_wp)
         call system%effects%add(gravity_gradient_t(system%body, [0.0_wp, 0.0_wp, 1.0_wp], 1.2e-6_wp))
         state = make_state(system, upright, [1e-3_wp, 2e-4_wp*n, 4e-3_wp])
      else
         call make_body(reshape([15.234375_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.46875_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
                                 15.234375_wp], [3, 3]), system%body, status, mass=15.0_wp, &
                        center_of_mass=[0.0_wp, 1.0_wp, 0.0_wp])
         call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
         state = make_state(system, upright, [0.0_wp, 150.0_wp, -4.6_wp - 0.01_wp*n])
      end if
   end subroutine take

   !> Fills all lanes.
   subroutine fill(k, order, bodies)
      integer, intent(in) :: k, order
      type(taylor_lanes_t), allocatable, intent(out) :: bodies
      type(system_t) :: system
      type(state_t) :: state
      integer :: n
      allocate (bodies)
      call bodies%set_up(order, dt(k))
      do n = 1, lanes
         call take(k, n, system, state)
         call bodies%put(n, system, state)
      end do
   end subroutine fill

   !> Least times of interleaved repeats.
   subroutine compare(k, order, steps)
      integer, intent(in) :: k, order, steps
      type(taylor_lanes_t), allocatable :: bodies
      type(system_t) :: system
      type(state_t) :: state
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      class(stepper_t), allocatable :: stepper
      real(wp) :: alone, together, start
      integer :: i, n
      alone = huge(alone)
      together = huge(together)
      settings = default_settings('taylor')
      settings%series_order = order
      do i = 1, repeats
         call take(k, 1, system, state)
         call make_stepper(system, settings, stepper, status)
         start = bench_thread_seconds()
         do n = 1, steps
            call stepper%advance(system, state, dt(k), state%t + 0.5_wp*dt(k), status)
         end do
         alone = min(alone, 1e9_wp*(bench_thread_seconds() - start)/steps)
         call fill(k, order, bodies)
         start = bench_thread_seconds()
         do n = 1, steps
            call bodies%step()
         end do
         together = min(together, 1e9_wp*(bench_thread_seconds() - start)/(real(steps, wp)*lanes))
         if (.not. all(bodies%taken)) error stop 'a body of the benchmark was given up'
      end do
      write (*, '(3x,a,", order ",i0,3f10.2)') trim(kinds(k)), order, alone, together, together/alone
   end subroutine compare

   !> Energy over that of the rotation, momentum over its length; of tops and satellites that about the vertical.
   subroutine drift(k, order, steps)
      integer, intent(in) :: k, order, steps
      type(taylor_lanes_t), allocatable :: bodies
      type(system_t) :: system
      type(state_t) :: first, last
      real(wp) :: errors(2), change(3)
      integer :: n
      call fill(k, order, bodies)
      do n = 1, steps
         call bodies%step()
      end do
      call bodies%look()
      errors = 0.0_wp
      do n = 1, lanes
         if (.not. bodies%taken(n)) error stop 'a body of the benchmark was given up'
         call take(k, n, system, first)
         last = first
         call bodies%get(n, last)
         change = space_momentum(last) - space_momentum(first)
         if (k >= 3) change(1:2) = 0.0_wp
         errors = max(errors, [abs(total_energy(system, last) - total_energy(system, first))/ &
                               kinetic_energy(system, first), norm2(change)/norm2(space_momentum(first))])
      end do
      write (*, '(3x,a,2es9.1)') trim(kinds(k)), errors
   end subroutine drift

   !> Rows a second that go into a file of NumPy, each chunk on the disk before the next, and from it into CSV.
   subroutine files()
      integer(int64), parameter :: members = 200000, chunk = 4096
      character(len=*), parameter :: name = 'bench_rows'
      type(sweep_file_t) :: file
      type(scene_t) :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      integer(int64), allocatable :: rows(:, :)
      integer(int64) :: begun, written, ended, rate, k
      integer :: error, unit
      call make_scene("'quaternion'", members, scene, layout)
      allocate (rows(layout%width(), chunk))
      rows = transfer(1.0_wp/3, rows(1, 1))
      call system_clock(begun, rate)
      call file%open(name//'.npy', npy_header(layout, members), layout%width(), members, chunk, 1_int64, .false., &
                     status)
      do k = 1, (members + chunk - 1)/chunk
         call file%put_chunk(k, rows(:, 1:min(chunk, members - (k - 1)*chunk)), error)
         if (error /= 0) error stop 'rows of the benchmark cannot be written'
         call file%mark(k, status)
      end do
      call file%finish(status)
      call system_clock(written)
      call write_csv(name//'.npy', layout, members, name//'.csv', status)
      call system_clock(ended)
      if (.not. status%ok()) error stop 'the files of the benchmark cannot be written'
      write (*, '(/,a,i0,a,2es9.1)') 'rows of ', layout%width(), ' fields a second, .npy and CSV: ', &
         real(members, wp)*real(rate, wp)/real(written - begun, wp), &
         real(members, wp)*real(rate, wp)/real(ended - written, wp)
      open (newunit=unit, file=name//'.npy')
      close (unit, status='delete')
      open (newunit=unit, file=name//'.csv')
      close (unit, status='delete')
   end subroutine files

   !> Members of 100 steps.
   subroutine make_scene(columns, members, scene, layout)
      character(len=*), intent(in) :: columns
      integer(int64), intent(in) :: members
      type(scene_t), intent(out) :: scene
      type(row_layout_t), intent(out) :: layout
      type(status_t) :: status
      character(len=:), allocatable :: message
      character(len=12) :: digits
      write (digits, '(i0)') members
      call parse_scene("&body inertia = 5, 20, 17 / &initial angular_velocity = 0.1, 0, 10 / "// &
                       "&rotor momentum = 2, 1, 5 / &integrator time_step = 0.1, end_time = 10, "// &
                       "method = 'taylor' / &output every = 100, columns = "//columns//" / "// &
                       "&ensemble members = "//digits//" / &vary key = 'initial.angular_velocity', "// &
                       "distribution = 'normal', sigma = 0.1, 0.1, 0.1 /", 'bench', scene, status, message)
      if (.not. status%ok()) error stop 'the scene of the benchmark is refused'
      call make_layout(scene, layout, status)
   end subroutine make_scene

   !> A sweep in memory, with what lanes take and with a column that they do not.
   subroutine sweep(members, threads)
      integer(int64), intent(in) :: members
      integer, intent(in) :: threads
      real(wp) :: alone(2), together(2)
      call cost("'quaternion', 'solver'", members, threads, alone)
      call cost("'quaternion'", members, threads, together)
      if (threads == 1) then
         write (*, '(i9,i4,2f10.2)') members, threads, alone(1), together(1)
      else
         write (*, '(i9,i4,2(f10.2,f8.2))') members, threads, alone, together
      end if
   end subroutine sweep

   !> Time of a member, us, of processors and on the wall: the least of some sweeps, of many where they are short. Of
   !> several threads the processors' is the mean, since the clock of a process is coarse.
   subroutine cost(columns, members, threads, spent)
      character(len=*), intent(in) :: columns
      integer(int64), intent(in) :: members
      integer, intent(in) :: threads
      real(wp), intent(out) :: spent(2)
      type(sweep_watcher_t), target :: nobody
      type(scene_t) :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      integer(int64), allocatable :: rows(:, :)
      integer(int64) :: begun, ended, rate, sweeps, k
      real(wp) :: start, all_start
      call make_scene(columns, members, scene, layout)
      allocate (rows(layout%width(), members))
      spent = huge(spent)
      sweeps = min(1000_int64, max(2_int64, 300000/members))
      all_start = bench_process_seconds()
      do k = 1, sweeps
         call system_clock(begun, rate)
         start = bench_thread_seconds()
         call fill_rows(scene, layout, 1_int64, members, threads, nobody, rows, status)
         spent(1) = min(spent(1), bench_thread_seconds() - start)
         call system_clock(ended)
         spent(2) = min(spent(2), real(ended - begun, wp)/real(rate, wp))
      end do
      if (threads > 1) spent(1) = (bench_process_seconds() - all_start)/sweeps
      spent = 1e6_wp*spent/real(members, wp)
   end subroutine cost

end program bench_ensemble
