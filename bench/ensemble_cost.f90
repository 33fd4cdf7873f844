!> What many bodies cost: a step of a lane over one of the scalar stepper, in the same process, and whole sweeps by
!> their number of members and of threads.
program bench_ensemble
   use, intrinsic :: iso_fortran_env, only: int64
   use, intrinsic :: iso_c_binding, only: c_double
   use nutate, only: integrator_settings_t, make_shape_body, make_state, make_stepper, parse_scene, scene_t, state_t, &
      status_t, stepper_t, system_t, wp
   use nutate_free_lanes, only: free_lanes_t, lanes
   use nutate_member_rows, only: fill_rows, has_threads
   use nutate_row_layout, only: make_layout, row_layout_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   implicit none

   interface
      real(c_double) function bench_thread_seconds() bind(C)
         import :: c_double
      end function bench_thread_seconds
   end interface

   integer, parameter :: repeats = 15, orders(4) = [2, 4, 6, 8]
   integer :: i

   write (*, '(a)') 'ns a body-step of a free box: alone, in a lane, and the ratio'
   do i = 1, size(orders)
      call compare(orders(i), 20000/orders(i)**2)
   end do
   write (*, '(/,a)') 'us a member of 100 steps of order 2 (one thread: CPU time; two: wall time)'
   write (*, '(a)') '  members threads alone together'
   do i = 2, 5
      call sweep(10_int64**i, 1)
      if (has_threads()) call sweep(10_int64**i, 2)
   end do

contains

   !> Least times of interleaved repeats.
   subroutine compare(order, steps)
      integer, intent(in) :: order, steps
      type(integrator_settings_t) :: settings
      type(free_lanes_t) :: bodies
      type(system_t) :: system
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: alone, together, start
      integer :: k, n
      settings%order = order
      settings%linear_solver = 'reduced'
      call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], system%body, status, mass=12.0_wp)
      alone = huge(alone)
      together = huge(together)
      do k = 1, repeats
         call make_stepper(system, settings, stepper, status)
         state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.1_wp, 10.0_wp])
         start = bench_thread_seconds()
         do n = 1, steps
            call stepper%step(system, state, 0.01_wp, status)
         end do
         alone = min(alone, 1e9_wp*(bench_thread_seconds() - start)/steps)
         call bodies%set_up(order, 0.01_wp)
         do n = 1, lanes
            state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.1_wp*n, 10.0_wp])
            call bodies%put(n, system, state)
         end do
         start = bench_thread_seconds()
         do n = 1, steps
            call bodies%step()
         end do
         together = min(together, 1e9_wp*(bench_thread_seconds() - start)/(real(steps, wp)*lanes))
         if (.not. all(bodies%taken)) error stop 'a body of the benchmark was given up'
      end do
      write (*, '(3x,"order ",i0,3f10.2)') order, alone, together, together/alone
   end subroutine compare

   !> A sweep in memory, with what lanes take and with a column that they do not.
   subroutine sweep(members, threads)
      integer(int64), intent(in) :: members
      integer, intent(in) :: threads
      write (*, '(i9,i4,2f10.2)') members, threads, cost("'quaternion', 'solver'", members, threads), &
         cost("'quaternion'", members, threads)
   end subroutine sweep

   !> Time of a member, us: the least of some sweeps.
   real(wp) function cost(columns, members, threads)
      character(len=*), intent(in) :: columns
      integer(int64), intent(in) :: members
      integer, intent(in) :: threads
      type(sweep_watcher_t), target :: nobody
      type(scene_t) :: scene
      type(row_layout_t) :: layout
      type(status_t) :: status
      character(len=:), allocatable :: message
      character(len=12) :: digits
      integer(int64), allocatable :: rows(:, :)
      integer(int64) :: begun, ended, rate
      real(wp) :: start, spent
      integer :: k
      write (digits, '(i0)') members
      call parse_scene("&body inertia = 5, 20, 17 / &initial angular_velocity = 0.1, 0, 10 / &integrator time_step "// &
                       "= 0.01, end_time = 1, linear_solver = 'reduced' / &output every = 100, columns = "// &
                       columns//" / &ensemble members = "//digits//" / &vary key = 'initial.angular_velocity', "// &
                       "distribution = 'normal', sigma = 0.1, 0.1, 0.1 /", 'bench', scene, status, message)
      if (.not. status%ok()) error stop 'the scene of the benchmark is refused'
      call make_layout(scene, layout, status)
      allocate (rows(layout%width(), members))
      cost = huge(cost)
      do k = 1, merge(3, 1, members < 100000)
         call system_clock(begun, rate)
         start = bench_thread_seconds()
         call fill_rows(scene, layout, 1_int64, members, threads, nobody, rows, status)
         call system_clock(ended)
         spent = bench_thread_seconds() - start
         if (threads > 1) spent = real(ended - begun, wp)/real(rate, wp)
         cost = min(cost, 1e6_wp*spent/real(members, wp))
      end do
   end function cost

end program bench_ensemble
