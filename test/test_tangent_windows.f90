!> Sensitivities by the times at which torques, forces, controllers and motors start and stop, against central
!> differences of runs.
submodule(suites_of_effects) test_tangent_windows
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body
   use nutate_byte_archive, only: byte_archive_t
   use nutate_lvlh_vector, only: lvlh_vector_t
   use nutate_variation, only: variation_t, rate_variation
   use nutate_control_law, only: BY_WHEELS
   use nutate_controller, only: controller_t
   use nutate_controller_mounting, only: add_controller
   use nutate_event, only: event_t, MAXIMUM
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp, long
   use nutate_progress, only: total_work
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_run, only: run_record_t, run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_STOPPED
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_tabulated_torque, only: make_tabulated_torque, tabulated_torque_t
   use nutate_timed_force, only: timed_force_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_event_support, only: rate_event_t
   use test_problems, only: body_momentum, make_state, new_system, system_t
   use test_stopping_observer, only: stopping_observer_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> Effects, start and stop of each.
   integer, parameter :: n_effects = 5, n_times = 2*n_effects
   character(len=10), parameter :: names(n_effects) = [character(len=10) :: 'torque', 'torque', 'force', 'wheel', &
      'controller']
   !> Numbers of the effects among those of their name.
   integer, parameter :: numbers(n_effects) = [1, 2, 1, 1, 1]
   !> Starts and stops of the effects, s.
   real(wp), parameter :: times(n_times) = [0.513_wp, 2.031_wp, 0.327_wp, 2.618_wp, 0.911_wp, 1.713_wp, 0.413_wp, &
                                            2.207_wp, 0.724_wp, 1.937_wp]
   real(wp), parameter :: last = 3.0_wp
   real(wp), parameter :: attitude(4) = [0.8_wp, 0.4_wp, -0.4_wp, 0.2_wp], rate(3) = [0.4_wp, -0.3_wp, 0.6_wp]

   !> Keeps what the tests compare.
   type, extends(stopping_observer_t) :: keeper_t
      integer :: n = 0
      real(wp) :: time = 0.0_wp, change(2) = 0.0_wp, momentum(100) = 0.0_wp, row_times(100) = 0.0_wp
   contains
      procedure :: observe => keep_row
      procedure :: observe_event => keep_event
   end type keeper_t

   type(integrator_settings_t), parameter :: methods(7) = [ &
      integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=8), &
      integrator_settings_t(method='nielsen_krenk', formulation='full', order=8), &
      integrator_settings_t(method='rk8'), &
      integrator_settings_t(method='rk8', conserve=.true.), &
      integrator_settings_t(method='dop853'), &
      integrator_settings_t(method='rk4'), &
      integrator_settings_t(method='taylor', series_order=24)]

contains

   module procedure collect_tangent_windows
      testsuite = [ &
                  new_unittest("starts and stops of all effects have the derivatives of differences", differ), &
                  new_unittest("so have they in adaptive steps and backward in time", differ_otherwise), &
                  new_unittest("a controller that starts at its limits, or by wheels", differ_at_limits), &
                  new_unittest("the derivative has the order of the method", converge), &
                  new_unittest("a start and a stop at the ends of a run count as inside of it", stand_at_ends), &
                  new_unittest("what lies outside of the run, or of a table, has the derivative 0", stand_outside), &
                  new_unittest("an event at a stop has the derivative of the stop", peak_at_stop), &
                  new_unittest("a checkpoint behind a start holds what it made", resume), &
                  new_unittest("effects without start and stop are refused", refuse)]
   end procedure collect_tangent_windows

   subroutine keep_row(self, system, state, record, status)
      class(keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (.not. self%wants_tangent .or. self%n == size(self%momentum)) return
      self%n = self%n + 1
      self%row_times(self%n) = state%t
      self%momentum(self%n) = self%tangent%momentum(1, 3)
   end subroutine keep_row

   subroutine keep_event(self, system, event, which, number, state, record, status)
      class(keeper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer, intent(in) :: which
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      self%n = self%n + 1
      self%time = state%t
      if (allocated(self%time_change)) self%change = self%time_change
   end subroutine keep_event

   !> A body on which everything acts for a time.
   subroutine build(shift, kind, system, status)
      !> Shift of the times, s.
      real(wp), intent(in) :: shift(n_times)
      !> Controller: 0: none; 1: without limit; 2: with a limit that it is at from its start on; 3: by wheels.
      integer, intent(in) :: kind
      type(system_t), intent(out) :: system
      type(status_t), intent(out) :: status
      type(tabulated_torque_t) :: table
      type(timed_force_t) :: force
      type(wheel_t) :: wheel
      type(controller_t) :: controller
      real(wp) :: t(n_times)
      integer :: at, i
      t = times + shift
      call make_body(reshape([4.0_wp, 0.1_wp, -0.05_wp, 0.1_wp, 5.0_wp, 0.2_wp, -0.05_wp, 0.2_wp, 6.0_wp], [3, 3]), &
                     system%body, status)
      call system%effects%add(applied_torque_t(name='torque', amplitude=[0.5_wp, -0.2_wp, 0.8_wp], in_space=.true., &
                                               frequency=0.2_wp, start=t(1), stop=t(2)))
      call make_tabulated_torque([0.0_wp, 1.1_wp, 2.3_wp, 3.0_wp], reshape( &
                                 [0.3_wp, 0.1_wp, -0.4_wp, -0.2_wp, 0.5_wp, 0.2_wp, 0.4_wp, -0.3_wp, 0.6_wp, &
                                  -0.5_wp, 0.2_wp, 0.3_wp], [3, 4]), table, status, at, start=t(3), stop=t(4))
      call system%effects%add(table)
      force%name = 'force'
      force%body_point = [0.5_wp, 0.2_wp, -0.4_wp]
      force%force = lvlh_vector_t(vector=[-0.3_wp, 0.8_wp, 0.6_wp])
      force%start = t(5)
      force%stop = t(6)
      call system%effects%add(force)
      wheel%name = 'wheel'
      wheel%axis = [0.0_wp, 0.6_wp, 0.8_wp]
      wheel%inertia = 0.1_wp
      wheel%speed = 3.0_wp
      wheel%friction = 0.01_wp
      if (kind /= 3) allocate (wheel%motor, source=applied_torque_t( &
                               name='motor', amplitude=[0.2_wp, 0.0_wp, 0.0_wp], start=t(7), stop=t(8)))
      call add_wheel(system, wheel, status)
      controller%name = 'controller'
      do i = 1, 3
         controller%attitude_gain(i, i) = 1.5_wp
         controller%rate_gain(i, i) = 0.8_wp
      end do
      controller%start = t(9)
      controller%stop = t(10)
      if (kind == 2) controller%limit = 0.3_wp
      if (kind == 3) controller%by = BY_WHEELS
      if (kind > 0 .and. status%ok()) call add_controller(system, controller, status)
   end subroutine build

   !> Lists the variations of the starts and stops.
   subroutine list_variations(system, kind, columns, status)
      type(system_t), intent(in) :: system
      integer, intent(in) :: kind
      type(variation_t), allocatable, intent(out) :: columns(:)
      type(status_t), intent(out) :: status
      character(len=5), parameter :: sides(2) = [character(len=5) :: 'start', 'stop']
      integer :: i, k
      allocate (columns(n_times))
      do i = 1, n_effects
         do k = 1, 2
            columns(2*i - 2 + k)%name = trim(names(i))//'.'//sides(k)
            if (kind == 0 .and. names(i) == 'controller' .or. kind == 3 .and. names(i) == 'wheel') cycle
            call columns(2*i - 2 + k)%add(system%effects, trim(names(i)), numbers(i), trim(sides(k)), [1.0_wp], status)
            if (.not. status%ok()) return
         end do
      end do
   end subroutine list_variations

   !> A run from one time to another, with columns or without.
   subroutine go(system, settings, plan, start, run, status, columns)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      !> s.
      real(wp), intent(in) :: start
      type(run_t), intent(inout) :: run
      type(status_t), intent(out) :: status
      type(variation_t), intent(in), optional :: columns(:)
      call run%begin(system, settings, make_state(system, attitude, rate, start), plan, status)
      if (present(columns) .and. status%ok()) call run%differentiate(columns, system, status)
      if (status%ok()) call run%run_to_end(system, status)
   end subroutine go

   !> All columns of a run against differences of 1 and ½ of a shift, extrapolated.
   subroutine compare(error, settings, plan, start, kind, tolerance)
      type(error_type), allocatable, intent(inout) :: error
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      real(wp), intent(in) :: start
      integer, intent(in) :: kind
      real(wp), intent(in) :: tolerance
      type(system_t), pointer :: system
      type(variation_t), allocatable :: columns(:)
      class(run_t), allocatable :: run
      type(status_t) :: status
      real(wp) :: column(8), difference(8), none(n_times)
      integer :: k
      system => new_system()
      allocate (run)
      none = 0.0_wp
      call build(none, kind, system, status)
      if (status%ok()) call list_variations(system, kind, columns, status)
      if (status%ok()) call go(system, settings, plan, start, run, status, columns)
      call check(error, status%ok(), trim(settings%method)//': '//trim(status%message))
      if (allocated(error)) return
      do k = 1, n_times
         if (.not. allocated(columns(k)%windows)) cycle
         associate (tangent => run%tangent)
            column = [tangent%theta(k, :), tangent%momentum(k, :), tangent%wheels(k, 1), tangent%work(k)]
         end associate
         call find_difference(settings, plan, start, kind, k, 1e-3_wp, difference, status)
         call check(error, status%ok(), trim(settings%method)//': '//trim(status%message))
         call check(error, maxval(abs(difference)) > 0.05_wp, trim(columns(k)%name)//' matters')
         call check_below(error, maxval(abs(column - difference)), tolerance, &
                          trim(settings%method)//' '//trim(settings%formulation)//' '//trim(columns(k)%name))
         if (allocated(error)) return
      end do
   end subroutine compare

   !> θ, δL, δh and the change of the work at the end by one of the times; shape (8).
   subroutine find_difference(settings, plan, start, kind, k, shift, difference, status)
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      real(wp), intent(in) :: start
      integer, intent(in) :: kind, k
      !> s.
      real(wp), intent(in) :: shift
      real(wp), intent(out) :: difference(8)
      type(status_t), intent(out) :: status
      class(run_t), allocatable :: ends(:)
      type(system_t), pointer :: system
      real(wp) :: shifts(n_times), turn(4), by_half(8), step
      integer :: i, half
      system => new_system()
      allocate (ends(2))
      do half = 1, 2
         step = shift/half
         do i = 1, 2
            shifts = 0.0_wp
            shifts(k) = (3 - 2*i)*step
            call build(shifts, kind, system, status)
            if (status%ok()) call go(system, settings, plan, start, ends(i), status)
            if (.not. status%ok()) return
         end do
         turn = quat_product(quat_conjugate(ends(2)%state%q), ends(1)%state%q)
         by_half = [turn(2:4)/step, (body_momentum(ends(1)%state) - body_momentum(ends(2)%state))/(2*step), &
                    (ends(1)%state%wheel_momentum(1) - ends(2)%state%wheel_momentum(1))/(2*step), &
                    (total_work(ends(1)%summary) - total_work(ends(2)%summary))/(2*step)]
         if (half == 1) difference = by_half
      end do
      difference = (4*by_half - difference)/3
   end subroutine find_difference

   !> Fixed steps of 0.02 s. A step of length h has the derivative by h of the flow but for terms of the order of the
   !> method: they are the tolerance of the Runge-Kutta method of order 4; otherwise that of the differences.
   subroutine differ(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      do i = 1, size(methods)
         call compare(error, methods(i), run_plan_t(time_step=0.02_wp, end_time=last), 0.0_wp, &
                      merge(0, 1, methods(i)%method == 'taylor'), merge(1e-6_wp, 1e-9_wp, methods(i)%method == 'rk4'))
         if (allocated(error)) return
      end do
   end subroutine differ

   !> Differences over 1e-3 s divide the tolerance of adaptive steps.
   subroutine differ_otherwise(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t) :: plan
      plan%end_time = last
      plan%goal%local_tolerance = 1e-12_wp
      call compare(error, methods(3), plan, 0.0_wp, 1, 1e-8_wp)
      call compare(error, methods(5), plan, 0.0_wp, 1, 1e-8_wp)
      call compare(error, methods(7), plan, 0.0_wp, 0, 1e-8_wp)
      call compare(error, methods(1), plan, 0.0_wp, 1, 1e-8_wp)
      call compare(error, methods(1), run_plan_t(time_step=-0.02_wp, end_time=0.0_wp), last, 1, 1e-9_wp)
      plan%end_time = 0.0_wp
      call compare(error, methods(5), plan, last, 1, 1e-8_wp)
   end subroutine differ_otherwise

   subroutine differ_at_limits(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      do i = 2, 3
         call compare(error, methods(3), run_plan_t(time_step=0.02_wp, end_time=last), 0.0_wp, i, 1e-8_wp)
         call compare(error, methods(5), run_plan_t(time_step=0.02_wp, end_time=last), 0.0_wp, i, 1e-8_wp)
      end do
   end subroutine differ_at_limits

   !> Orders 2, 4 and 6 against differences of order 8, with steps of 0.04 and 0.01 s: the error falls by 4 to the
   !> order, but for where the times lie in the steps.
   subroutine converge(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: steps(2) = [0.04_wp, 0.01_wp]
      type(system_t), pointer :: system
      type(variation_t), allocatable :: columns(:)
      class(run_t), allocatable :: run
      type(status_t) :: status
      real(wp) :: difference(8, n_times), worst(2), none(n_times)
      integer :: form, i, k, order
      system => new_system()
      allocate (run)
      none = 0.0_wp
      call build(none, 1, system, status)
      if (status%ok()) call list_variations(system, 1, columns, status)
      do k = 1, n_times
         if (status%ok()) call find_difference(methods(3), run_plan_t(time_step=0.01_wp, end_time=last), 0.0_wp, 1, k, &
                                               1e-3_wp, difference(:, k), status)
      end do
      do order = 2, 6, 2
         do form = 1, 2
            worst = 0.0_wp
            do i = 1, 2
               if (status%ok()) call go(system, integrator_settings_t( &
                                        method='nielsen_krenk', formulation=merge('reduced', 'full   ', form == 1), &
                                        order=order), run_plan_t(time_step=steps(i), end_time=last), 0.0_wp, run, &
                                        status, columns)
               call check(error, status%ok(), trim(status%message))
               if (allocated(error)) return
               do k = 1, n_times
                  worst(i) = max(worst(i), maxval(abs([run%tangent%theta(k, :), run%tangent%momentum(k, :), &
                                                       run%tangent%wheels(k, 1), run%tangent%work(k)] &
                                                      - difference(:, k))))
               end do
            end do
            call check_below(error, worst(2), max(3*worst(1)/4.0_wp**order, 1e-9_wp), 'order')
            call check_below(error, worst(1), 3*steps(1)**order, 'error')
         end do
      end do
   end subroutine converge

   !> One-sided differences: the derivative by a start at 0 is that of a later one, by a stop at the end that of an
   !> earlier one.
   subroutine stand_at_ends(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1e-3_wp
      type(system_t), pointer :: system
      type(variation_t) :: columns(2)
      class(run_t), allocatable :: run(:)
      type(run_plan_t) :: plan
      type(status_t) :: status
      real(wp) :: slope(3)
      integer :: i, k, m
      system => new_system()
      allocate (run(3))
      do m = 1, 2
         plan = run_plan_t(time_step=0.02_wp, end_time=1.0_wp)
         if (m == 2) then
            plan = run_plan_t(end_time=1.0_wp)
            plan%goal%local_tolerance = 1e-12_wp
         end if
         do k = 1, 2
            do i = 1, 3
               call build_one([merge((i - 1)*h, 0.0_wp, k == 1), merge(1 - (i - 1)*h, 1.0_wp, k == 2)], system)
               call columns(1)%add(system%effects, 'torque', 1, 'start', [1.0_wp], status)
               call columns(2)%add(system%effects, 'torque', 1, 'stop', [1.0_wp], status)
               call go(system, methods(5), plan, 0.0_wp, run(i), status, columns)
               call check(error, status%ok(), trim(status%message))
               if (allocated(error)) return
               columns = variation_t()
            end do
            slope = (4*body_momentum(run(2)%state) - 3*body_momentum(run(1)%state) - body_momentum(run(3)%state))/(2*h)
            if (k == 2) slope = -slope
            call check_close(error, run(1)%tangent%momentum(k, :), slope, 10*h**2, merge('start', 'stop ', k == 1))
            call check(error, norm2(slope) > 0.1_wp, 'it matters')
         end do
      end do
   end subroutine stand_at_ends

   !> A body with one torque.
   subroutine build_one(window, system)
      !> s.
      real(wp), intent(in) :: window(2)
      type(system_t), intent(out) :: system
      type(status_t) :: status
      call make_body(diagonal([1.5_wp, 1.5_wp, 2.0_wp]), system%body, status)
      call system%effects%add(applied_torque_t(name='torque', amplitude=[0.1_wp, 0.2_wp, 0.5_wp], in_space=.true., &
                                               start=window(1), stop=window(2)))
   end subroutine build_one

   subroutine stand_outside(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(tabulated_torque_t) :: table
      type(variation_t) :: columns(4)
      class(run_t), allocatable :: run
      type(status_t) :: status
      integer :: at, k
      system => new_system()
      allocate (run)
      call build_one([-0.5_wp, 1.5_wp], system)
      call make_tabulated_torque([0.2_wp, 0.8_wp], &
                                 reshape([0.3_wp, 0.1_wp, -0.4_wp, -0.2_wp, 0.5_wp, 0.2_wp], [3, 2]), &
                                 table, status, at, start=-1.0_wp, stop=0.8_wp)
      call system%effects%add(table)
      do k = 1, 2
         call columns(2*k - 1)%add(system%effects, 'torque', k, 'start', [1.0_wp], status)
         call columns(2*k)%add(system%effects, 'torque', k, 'stop', [1.0_wp], status)
      end do
      call go(system, methods(3), run_plan_t(time_step=0.02_wp, end_time=1.0_wp), 0.0_wp, run, status, columns)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check(error, all(abs(run%tangent%theta) <= 0.0_wp) .and. all(abs(run%tangent%momentum) <= 0.0_wp), 'zero')
   end subroutine stand_outside

   !> A rate that rises until a torque stops, and falls then: its maximum has the time of the stop. Rows at that time
   !> and after it have the columns behind the stop.
   subroutine peak_at_stop(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(event_list_t) :: events
      type(variation_t) :: columns(2)
      type(keeper_t) :: keeper, rows
      type(run_plan_t) :: plan
      class(run_t), allocatable :: run
      type(status_t) :: status
      system => new_system()
      allocate (run)
      call make_body(diagonal([1.5_wp, 1.5_wp, 2.0_wp]), system%body, status)
      call system%effects%add(applied_torque_t(name='torque', amplitude=[0.0_wp, 0.0_wp, 0.5_wp], stop=1.25_wp))
      call system%effects%add(applied_torque_t(name='torque', amplitude=[0.0_wp, 0.0_wp, -0.1_wp]))
      columns(1)%name = 'torque.stop'
      call columns(1)%add(system%effects, 'torque', 1, 'stop', [1.0_wp], status)
      columns(2) = rate_variation(3)
      call events%add(rate_event_t(name='peak', kind=MAXIMUM))
      plan = run_plan_t(time_step=0.3_wp, end_time=3.0_wp)
      call run%begin(system, methods(1), make_state(system, attitude, [0.0_wp, 0.0_wp, 0.2_wp], 0.0_wp), plan, status)
      if (status%ok()) call run%set_events(events, system, status)
      if (status%ok()) call run%differentiate(columns, system, status)
      if (status%ok()) call run%run_to_end(system, status, keeper)
      call check(error, status%ok(), trim(status%message))
      call check(error, keeper%n, 1, 'events')
      call check_close(error, keeper%time, 1.25_wp, 1e-14_wp, 'time')
      call check_close(error, keeper%change, [1.0_wp, 0.0_wp], 1e-14_wp, 'its derivative')
      rows%wants_tangent = .true.
      plan = run_plan_t(end_time=3.0_wp)
      plan%goal%local_tolerance = 1e-9_wp
      plan%interval = 0.25_wp
      call run%begin(system, methods(5), make_state(system, attitude, [0.0_wp, 0.0_wp, 0.2_wp], 0.0_wp), plan, status)
      if (status%ok()) call run%differentiate(columns, system, status)
      if (status%ok()) call run%run_to_end(system, status, rows)
      call check(error, status%ok(), trim(status%message))
      call check(error, rows%n, 13, 'rows')
      if (allocated(error)) return
      call check_close(error, rows%row_times(6), 1.25_wp, 1e-15_wp, 'row')
      call check_close(error, rows%momentum(5:7), [0.0_wp, 0.5_wp, 0.5_wp], 1e-12_wp, 'columns of rows')
   end subroutine peak_at_stop

   subroutine resume(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(variation_t), allocatable :: columns(:)
      class(run_t), allocatable :: whole, broken, resumed
      type(run_plan_t) :: plan
      type(keeper_t) :: keeper
      type(byte_archive_t) :: archive
      type(status_t) :: status
      real(wp) :: none(n_times)
      system => new_system()
      allocate (whole, broken, resumed)
      none = 0.0_wp
      call build(none, 1, system, status)
      if (status%ok()) call list_variations(system, 1, columns, status)
      plan%end_time = last
      plan%goal%local_tolerance = 1e-8_wp
      call begin(whole)
      if (status%ok()) call whole%run_to_end(system, status, keeper)
      call check(error, status%ok(), trim(status%message))
      keeper = keeper_t(stops_at=keeper%polls/2)
      call begin(broken)
      if (status%ok()) call broken%run_to_end(system, status, keeper)
      call check(error, status%code, NUTATE_STOPPED, 'the run is stopped')
      call check(error, any(abs(broken%tangent%momentum) > 0.0_wp), 'behind a start')
      if (allocated(error)) return
      call archive%begin_reading(keeper%archive)
      call begin(resumed)
      if (status%ok()) call resumed%resume(archive, status)
      if (status%ok()) call resumed%run_to_end(system, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check(error, all(abs(resumed%tangent%momentum - whole%tangent%momentum) <= 0.0_wp), 'momentum')
      call check(error, all(abs(resumed%tangent%theta - whole%tangent%theta) <= 0.0_wp), 'attitude')
      call check(error, all(abs(resumed%tangent%work - whole%tangent%work) <= 0.0_wp), 'work')

   contains

      subroutine begin(run)
         type(run_t), intent(inout) :: run
         call run%begin(system, methods(5), make_state(system, attitude, rate, 0.0_wp), plan, status)
         if (status%ok()) call run%differentiate(columns, system, status)
      end subroutine begin

   end subroutine resume

   !> A torque at all times, the controller's window by the name of a wheel that it drives.
   subroutine refuse(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(variation_t) :: column
      type(status_t) :: status
      real(wp) :: none(n_times)
      system => new_system()
      none = 0.0_wp
      call build(none, 3, system, status)
      call column%add(system%effects, 'wheel', 1, 'start', [1.0_wp], status)
      call check(error, index(status%message, 'wheel has no derivative with respect to start') > 0, &
                 trim(status%message))
      call system%effects%add(applied_torque_t(name='other', amplitude=[1.0_wp, 0.0_wp, 0.0_wp], stop=1.0_wp))
      call column%add(system%effects, 'other', 1, 'start', [1.0_wp], status)
      call check(error, index(status%message, 'other has no derivative with respect to start '// &
                              '(expected body(3), frequency, phase, stop)') > 0, trim(status%message))
      call column%add(system%effects, 'other', 1, 'stop', [1.0_wp, 1.0_wp], status)
      call check(error, index(status%message, 'other has no derivative with respect to stop') > 0, &
                 trim(status%message))
   end subroutine refuse

end submodule test_tangent_windows
