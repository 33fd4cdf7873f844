!> Plans, events, tables, sensitivities and steppers that no run can follow: each is rejected, and nothing has changed.
submodule(suites_of_runs) test_run_misuse
   use, intrinsic :: ieee_arithmetic, only: ieee_invalid, ieee_positive_inf, ieee_quiet_nan, ieee_set_halting_mode, &
      ieee_usual, ieee_value
   use nutate, only: add_controller, add_wheel, applied_torque_t, attitude_variation, center_change_t, &
      chaos_settings_t, chaos_t, column_event_t, controller_t, damping_t, earth_field_t, effect_t, event_list_t, &
      event_t, gravity_t, history_t, inertia_change_t, inertia_variation, integrate, integrator_settings_t, long, &
      make_shape_body, make_state, make_stepper, make_tabulated_center, make_tabulated_inertia, &
      make_tabulated_torque, observer_t, rate_variation, rotating_frame_t, run_goal_t, run_plan_t, run_record_t, &
      run_t, spring_t, state_t, status_t, stepper_t, system_t, tabulated_torque_t, tangent_t, variation_t, wheel_t, &
      wp
   use nutate_status, only: NUTATE_BAD_ARGUMENT
   use nutate_wheel_motor, only: make_motor_table
   use test_support, only: check, error_type, new_unittest
   implicit none

   !> Counts rows and events.
   type, extends(observer_t) :: counter_t
      integer :: rows = 0, events = 0
   contains
      procedure :: observe => count_row
      procedure :: observe_event => count_event
   end type counter_t

   !> Plan that all others differ from.
   type(run_plan_t), parameter :: usual = run_plan_t(time_step=0.01_wp, end_time=2.0_wp)

contains

   module procedure collect_run_misuse
      testsuite = [ &
                  new_unittest("plans that lead nowhere are rejected", plans_that_lead_nowhere), &
                  new_unittest("a run without an end, or a begin, is rejected", runs_without_an_end), &
                  new_unittest("a run starts where the steps before it end", starts_elsewhere), &
                  new_unittest("events may be set before the end time", events_before_the_end), &
                  new_unittest("a run in parts has the rows of its times", times_in_parts), &
                  new_unittest("an event finds its columns by itself", columns_are_found), &
                  new_unittest("events that cannot occur are rejected", events_that_cannot_occur), &
                  new_unittest("tables of a wrong shape are rejected", tables_of_a_wrong_shape), &
                  new_unittest("sensitivities of axes that do not exist", axes_that_do_not_exist), &
                  new_unittest("a stepper rejects another system", steppers_of_another_system), &
                  new_unittest("a run and a stepper reject other effects", other_effects), &
                  new_unittest("every wheel has a speed", speeds_of_other_wheels), &
                  new_unittest("settings out of their ranges are rejected", settings_out_of_range), &
                  new_unittest("effects that were not made are rejected", effects_that_were_not_made), &
                  new_unittest("indicators of chaos need settings in range", chaos_out_of_range), &
                  new_unittest("a history that is not open takes no row", history_not_open)]
   end procedure collect_run_misuse

   subroutine count_row(self, system, state, record, status)
      class(counter_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      self%rows = self%rows + 1
   end subroutine count_row

   subroutine count_event(self, system, event, which, number, state, record, status)
      class(counter_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer, intent(in) :: which
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      self%events = self%events + 1
   end subroutine count_event

   !> Comparing with NaN is an invalid operation. A program that traps it is stopped where it made the NaN: tests with
   !> NaN do not trap it.
   subroutine plans_that_lead_nowhere(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t) :: plan
      real(wp) :: nan
      call ieee_set_halting_mode(ieee_invalid, .false.)
      nan = ieee_value(nan, ieee_quiet_nan)
      call reject(run_plan_t(time_step=0.01_wp, end_time=2.0_wp, every=0_long), 'every')
      call reject(run_plan_t(time_step=nan, end_time=2.0_wp), 'time_step')
      call reject(run_plan_t(time_step=0.01_wp, end_time=nan), 'end_time')
      call reject(run_plan_t(time_step=0.01_wp, end_time=2.0_wp, interval=nan), 'interval')
      call reject(run_plan_t(time_step=0.01_wp, end_time=2.0_wp, interval=-0.1_wp), 'interval')
      call reject(run_plan_t(end_time=2.0_wp, goal=run_goal_t(accuracy=nan)), 'accuracy')
      call reject(run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=-1.0_wp)), 'local_tolerance')
      call reject(run_plan_t(end_time=2.0_wp, goal=run_goal_t(error_rate=nan)), 'error_rate')
      call reject(run_plan_t(time_step=0.01_wp, end_time=2.0_wp, steps=3_long), 'steps')
      plan = usual
      plan%times = [0.5_wp, 0.2_wp]
      call reject(plan, 'times')
      plan%times = [0.5_wp, nan]
      call reject(plan, 'times')
      plan%times = [-0.5_wp, 0.5_wp]
      call reject(plan, 'times')

   contains

      subroutine reject(plan, subject)
         type(run_plan_t), intent(in) :: plan
         character(len=*), intent(in) :: subject
         type(system_t) :: box
         type(state_t) :: state, start
         type(status_t) :: status
         type(run_t) :: run
         call make_box(box, start)
         state = start
         call integrate(box, integrator_settings_t(), state, plan, status)
         call check(error, status%code, NUTATE_BAD_ARGUMENT, subject)
         call check(error, trim(status%subject), subject)
         call check(error, index(status%message, '(expected ') > 0, trim(status%message))
         call check(error, all(abs(state%q - start%q) <= 0.0_wp) .and. abs(state%t) <= 0.0_wp, 'moved: '//subject)
         call run%begin(box, integrator_settings_t(), start, usual, status)
         call run%set_plan(box, plan, status)
         call check(error, trim(status%subject), subject, 'another plan')
      end subroutine reject

   end subroutine plans_that_lead_nowhere

   subroutine runs_without_an_end(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t) :: box
      type(state_t) :: state
      type(status_t) :: status
      type(run_t) :: run
      class(stepper_t), allocatable :: stepper
      call ieee_set_halting_mode(ieee_invalid, .false.)
      call make_box(box, state)
      call integrate(box, integrator_settings_t(), state, run_plan_t(time_step=0.01_wp), status)
      call check(error, trim(status%subject), 'end_time', 'by settings')
      call make_stepper(box, integrator_settings_t(), stepper, status)
      call integrate(box, stepper, state, run_plan_t(time_step=0.01_wp, steps=5_long), status)
      call check(error, trim(status%subject), 'end_time', 'by stepper')
      call run%run_to_end(box, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'no begin')
      call run%set_plan(box, usual, status)
      call check(error, trim(status%subject), 'run', 'a plan without begin')
      call run%begin(box, integrator_settings_t(), state, usual, status)
      call run%release()
      call run%run_to_end(box, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'released')
      call run%begin(box, integrator_settings_t(), state, run_plan_t(time_step=0.01_wp), status)
      call run%run_to(box, ieee_value(1.0_wp, ieee_quiet_nan), status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'to NaN')
      call run%run_to(box, 0.5_wp, status)
      call check(error, status%ok() .and. abs(run%state%t - 0.5_wp) <= 0.0_wp, trim(status%message))
   end subroutine runs_without_an_end

   subroutine starts_elsewhere(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t) :: box
      type(state_t) :: state
      real(wp) :: nan
      call ieee_set_halting_mode(ieee_invalid, .false.)
      nan = ieee_value(nan, ieee_quiet_nan)
      call make_box(box, state)
      call begin(state, nan, 1_long, 'steps_before')
      call begin(state, 0.0_wp, 1_long, 'steps_before')
      call begin(state, 0.0_wp, -5_long, 'steps_before')
      call begin(state, 0.0_wp, huge(1_long), 'steps_before')
      call begin(state, -0.05_wp, 5_long, '')
      state%t = nan
      call begin(state, 0.0_wp, 0_long, 't')

   contains

      subroutine begin(start, first_time, steps_before, subject)
         type(state_t), intent(in) :: start
         real(wp), intent(in) :: first_time
         integer(long), intent(in) :: steps_before
         character(len=*), intent(in) :: subject
         type(run_plan_t) :: plan
         type(state_t) :: state
         type(status_t) :: status
         class(stepper_t), allocatable :: stepper
         plan = usual
         plan%first_time = first_time
         plan%steps_before = steps_before
         state = start
         call integrate(box, integrator_settings_t(), state, plan, status)
         call check(error, trim(status%subject), subject, 'by settings')
         state = start
         call make_stepper(box, integrator_settings_t(), stepper, status)
         call integrate(box, stepper, state, plan, status)
         call check(error, trim(status%subject), subject, 'by stepper')
      end subroutine begin

   end subroutine starts_elsewhere

   subroutine events_before_the_end(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t) :: box
      type(state_t) :: state
      type(status_t) :: status
      type(run_t) :: run
      type(counter_t) :: counter, expected
      call make_box(box, state)
      call run%begin(box, integrator_settings_t(), state, run_plan_t(time_step=0.01_wp), status)
      call run%set_events(one_event(crossing_of('omega9')), box, status)
      call check(error, trim(status%subject), 'event')
      call run%set_events(one_event(crossing_of('omega3')), box, status)
      call run%run_to(box, 1.0_wp, status, counter)
      call run%run_to(box, 2.0_wp, status, counter)
      call check(error, status%ok(), trim(status%message))
      call integrate(box, integrator_settings_t(), state, usual, status, expected, &
                     events=one_event(crossing_of('omega3')))
      call check(error, expected%events > 0, 'no events')
      call check(error, counter%events, expected%events)
   end subroutine events_before_the_end

   subroutine times_in_parts(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t) :: plan
      type(system_t) :: box
      type(state_t) :: state
      type(status_t) :: status
      type(run_t) :: run
      type(counter_t) :: counter
      call make_box(box, state)
      plan = run_plan_t(time_step=0.01_wp)
      plan%times = [0.5_wp, 1.0_wp, 1.5_wp, 2.0_wp]
      call run%begin(box, integrator_settings_t(), state, plan, status)
      call run%run_to(box, 1.2_wp, status, counter)
      call check(error, status%ok() .and. counter%rows == 2, trim(status%message))
      call run%run_to(box, 2.0_wp, status, counter)
      call check(error, status%ok() .and. counter%rows == 4, trim(status%message))
      call run%run_steps(box, 10_long, status, counter)
      call check(error, status%ok() .and. abs(run%state%t - 2.1_wp) <= 1e-12_wp, trim(status%message))
   end subroutine times_in_parts

   subroutine columns_are_found(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t) :: box
      type(state_t) :: state, start
      type(status_t) :: status
      type(column_event_t) :: event
      type(counter_t) :: counter, expected
      call make_box(box, start)
      event%columns(1:2) = [character(len=24) :: 'omega1', 'omega2']
      state = start
      call integrate(box, integrator_settings_t(), state, usual, status, counter, events=one_event(event))
      call check(error, status%ok(), trim(status%message))
      call event%place()
      state = start
      call integrate(box, integrator_settings_t(), state, usual, status, expected, events=one_event(event))
      call check(error, expected%events > 0, 'no events')
      call check(error, counter%events, expected%events)
   end subroutine columns_are_found

   subroutine events_that_cannot_occur(error)
      type(error_type), allocatable, intent(out) :: error
      type(column_event_t) :: event
      real(wp) :: nan
      call ieee_set_halting_mode(ieee_invalid, .false.)
      nan = ieee_value(nan, ieee_quiet_nan)
      call reject(column_event_t())
      call reject(crossing_of('omega9'))
      event = crossing_of('omega1')
      event%level = nan
      call reject(event)
      event%level = 0.0_wp
      event%period = -1.0_wp
      call reject(event)
      event%period = 0.0_wp
      event%kind = 77
      call reject(event)
      event%kind = 0
      event%direction = 2
      call reject(event)
      event%direction = 0
      event%count = -1
      call reject(event)
      event%count = 0
      event%weights(1) = nan
      call reject(event)

   contains

      subroutine reject(event)
         type(column_event_t), intent(in) :: event
         type(system_t) :: box
         type(state_t) :: state
         type(status_t) :: status
         call make_box(box, state)
         call integrate(box, integrator_settings_t(), state, usual, status, events=one_event(event))
         call check(error, trim(status%subject), 'event', trim(status%message))
         call check(error, index(status%message, '(expected ') > 0, trim(status%message))
         call check(error, abs(state%t) <= 0.0_wp, 'moved: '//trim(status%message))
      end subroutine reject

   end subroutine events_that_cannot_occur

   subroutine tables_of_a_wrong_shape(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: times(3) = [0.0_wp, 1.0_wp, 2.0_wp]
      real(wp) :: numbers(6, 3)
      type(tabulated_torque_t) :: torque
      type(inertia_change_t) :: inertia
      type(center_change_t) :: center
      type(status_t) :: status
      integer :: at
      numbers = 1.0_wp
      call make_tabulated_torque(times, numbers(1:3, 1:2), torque, status, at)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'two lines of torques')
      call make_tabulated_torque(times(1:2), numbers(1:3, :), torque, status, at)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'two times of torques')
      call make_tabulated_torque(times, numbers(1:2, :), torque, status, at)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'two components of a torque')
      call ieee_set_halting_mode(ieee_invalid, .false.)
      call make_tabulated_torque(times, numbers(1:3, :), torque, status, at, start=ieee_value(1.0_wp, ieee_quiet_nan))
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'a start that is not finite')
      call make_tabulated_torque(times, numbers(1:3, :), torque, status, at, stop=ieee_value(1.0_wp, ieee_quiet_nan))
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'a stop that is not finite')
      call make_tabulated_inertia(times, numbers(1:4, :), inertia, status, at)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'four moments of inertia')
      call make_tabulated_inertia(times, numbers(1:2, :), inertia, status, at)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'two moments of inertia')
      call make_tabulated_inertia(times, numbers(:, 1:2), inertia, status, at)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'two lines of inertia')
      call make_tabulated_center(times, numbers(1:2, :), center, status, at)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'two components of a centre')
      call make_tabulated_center(times, numbers(1:3, :), center, status, at)
      call check(error, status%ok(), trim(status%message))
   end subroutine tables_of_a_wrong_shape

   subroutine axes_that_do_not_exist(error)
      type(error_type), allocatable, intent(out) :: error
      type(variation_t) :: variation
      call ieee_set_halting_mode(ieee_invalid, .false.)
      call reject(attitude_variation(0))
      call reject(attitude_variation(4))
      call reject(rate_variation(-1))
      call reject(inertia_variation(1, 4))
      call reject(inertia_variation(0, 3))
      variation%rotor(2) = ieee_value(1.0_wp, ieee_quiet_nan)
      call reject(variation)

   contains

      subroutine reject(variation)
         type(variation_t), intent(in) :: variation
         type(system_t) :: box
         type(state_t) :: state
         type(status_t) :: status
         type(run_t) :: run
         call make_box(box, state)
         call run%begin(box, integrator_settings_t(), state, usual, status)
         call run%differentiate([variation], box, status)
         call check(error, status%code, NUTATE_BAD_ARGUMENT, trim(variation%name))
      end subroutine reject

   end subroutine axes_that_do_not_exist

   subroutine steppers_of_another_system(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: methods(5) = [character(len=13) :: 'nielsen_krenk', 'taylor', 'rk8', 'dop853', &
                                                   'rk4']
      type(system_t) :: box, heavy
      type(state_t) :: state, start
      type(status_t) :: status
      type(run_t) :: run
      class(stepper_t), allocatable :: stepper
      integer :: i
      call make_box(box, start)
      heavy = box
      call heavy%effects%add(gravity_t(box%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      call heavy%effects%add(damping_t(coefficient=[0.1_wp, 0.1_wp, 0.1_wp]))
      do i = 1, size(methods)
         call make_stepper(box, integrator_settings_t(method=methods(i)), stepper, status)
         state = start
         call stepper%step(heavy, state, 0.01_wp, status)
         call check(error, trim(status%subject), 'system', methods(i))
         call check(error, abs(state%t) <= 0.0_wp, 'moved by '//methods(i))
         call integrate(heavy, stepper, state, usual, status)
         call check(error, trim(status%subject), 'system', methods(i)//' in a run')
         call stepper%renew(heavy, status)
         if (status%ok()) call stepper%step(heavy, state, 0.01_wp, status)
         call check(error, status%ok(), methods(i)//trim(status%message))
         call run%begin(box, integrator_settings_t(method=methods(i)), start, usual, status)
         call run%run_to_end(heavy, status)
         call check(error, trim(status%subject), 'system', methods(i)//' run to the end')
         call make_stepper(box, integrator_settings_t(method=methods(i)), stepper, status)
         call run%begin(heavy, stepper, start, usual, status)
         call check(error, trim(status%subject), 'system', methods(i)//' begin')
         call run%begin(box, integrator_settings_t(method=methods(i)), start, &
                        run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=1e-6_wp)), status)
         call run%run_to_end(heavy, status)
         call check(error, trim(status%subject), 'system', methods(i)//' adaptive')
      end do
   end subroutine steppers_of_another_system

   subroutine other_effects(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: methods(5) = [character(len=13) :: 'nielsen_krenk', 'taylor', 'rk8', 'dop853', &
                                                   'rk4']
      type(system_t) :: box, turning, heavy, hung
      type(state_t) :: state, start
      type(status_t) :: status
      type(run_t) :: run
      class(stepper_t), allocatable :: stepper
      integer :: i
      call make_box(box, start)
      turning = box
      call turning%effects%add(rotating_frame_t(rate=[0.0_wp, 0.3_wp, 1.0_wp]))
      heavy = box
      call heavy%effects%add(gravity_t(box%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      hung = box
      call hung%effects%add(spring_t(body_point=[0.0_wp, 0.0_wp, 1.0_wp], stiffness=2.0_wp))
      do i = 1, size(methods)
         state = start
         call make_stepper(box, integrator_settings_t(method=methods(i)), stepper, status)
         call stepper%step(turning, state, 0.01_wp, status)
         call check(error, trim(status%subject), 'system', methods(i)//' a frame is added')
         call make_stepper(turning, integrator_settings_t(method=methods(i)), stepper, status)
         call stepper%step(box, state, 0.01_wp, status)
         call check(error, trim(status%subject), 'system', methods(i)//' the frame is gone')
         call make_stepper(heavy, integrator_settings_t(method=methods(i)), stepper, status)
         call stepper%step(hung, state, 0.01_wp, status)
         call check(error, trim(status%subject), 'system', methods(i)//' another potential')
      end do
      ! A run with adaptive steps prepares its steppers anew, but sums as many works as it began with.
      heavy = box
      call run%begin(box, integrator_settings_t(), start, run_plan_t(goal=run_goal_t(local_tolerance=1e-6_wp)), status)
      call run%run_to(box, 0.1_wp, status)
      call heavy%effects%add(damping_t(coefficient=[0.1_wp, 0.1_wp, 0.1_wp]))
      call run%run_to(heavy, 0.2_wp, status)
      call check(error, trim(status%subject), 'system', 'a torque is added')
      call run%run_to(box, 0.2_wp, status)
      call check(error, status%ok() .and. abs(run%state%t - 0.2_wp) <= 0.0_wp, trim(status%message))
   end subroutine other_effects

   subroutine speeds_of_other_wheels(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t) :: box
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      integer :: n
      ! The exponent of NaN is one that overflows.
      call ieee_set_halting_mode(ieee_usual, .false.)
      call make_box(box, state)
      call add_wheel(box, wheel_t(inertia=0.01_wp), status)
      call add_wheel(box, wheel_t(axis=[1.0_wp, 0.0_wp, 0.0_wp], inertia=0.01_wp), status)
      call make_stepper(box, integrator_settings_t(), stepper, status)
      do n = 0, 3
         state = make_state(box, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.2_wp, 10.0_wp], &
                            speeds=spread(5.0_wp, 1, n))
         call stepper%step(box, state, 0.01_wp, status)
         call check(error, status%ok() .eqv. n == 2, 'speeds of other wheels: '//trim(status%message))
      end do
   end subroutine speeds_of_other_wheels

   subroutine settings_out_of_range(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: nan
      call ieee_set_halting_mode(ieee_invalid, .false.)
      nan = ieee_value(nan, ieee_quiet_nan)
      ! With these lengths no step ends, and the run would not either.
      call reject(integrator_settings_t(method='dop853', max_step=nan), 'max_step')
      call reject(integrator_settings_t(method='dop853', max_step=0.0_wp), 'max_step')
      call reject(integrator_settings_t(method='nielsen_krenk', max_iterations=0), 'max_iterations')
      call reject(integrator_settings_t(method='nielsen_krenk', tolerance=nan), 'tolerance')

   contains

      subroutine reject(settings, subject)
         type(integrator_settings_t), intent(in) :: settings
         character(len=*), intent(in) :: subject
         type(system_t) :: box
         type(state_t) :: state
         type(status_t) :: status
         class(stepper_t), allocatable :: stepper
         call make_box(box, state)
         call make_stepper(box, settings, stepper, status)
         call check(error, trim(status%subject), subject, 'stepper: '//trim(status%message))
         call integrate(box, settings, state, run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=1e-6_wp)), &
                        status)
         call check(error, trim(status%subject), subject, 'run: '//trim(status%message))
      end subroutine reject

   end subroutine settings_out_of_range

   subroutine effects_that_were_not_made(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t) :: box
      type(status_t) :: status
      type(tabulated_torque_t) :: motor
      real(wp) :: nan
      integer :: at
      call ieee_set_halting_mode(ieee_invalid, .false.)
      nan = ieee_value(nan, ieee_quiet_nan)
      call reject(tabulated_torque_t(), 'table')
      call reject(inertia_change_t(is_table=.true.), 'inertia')
      call reject(center_change_t(), 'centre')
      call reject(earth_field_t(), 'field')
      call reject(applied_torque_t(amplitude=[1.0_wp, 0.0_wp, 0.0_wp], start=nan), 'start')
      call reject(applied_torque_t(amplitude=[1.0_wp, 0.0_wp, 0.0_wp], start=2.0_wp, stop=1.0_wp), 'stop before start')
      call reject(damping_t(coefficient=[nan, 0.0_wp, 0.0_wp]), 'damping')
      call make_motor_table([0.0_wp, 1.0_wp], [1.0_wp, 2.0_wp], motor, status, at, torque_limit=-0.5_wp)
      call check(error, trim(status%subject), 'torque_limit')
      call make_motor_table([0.0_wp, 1.0_wp], [1.0_wp, 2.0_wp, 3.0_wp], motor, status, at, torque_limit=0.5_wp)
      call check(error, trim(status%subject), 'table')
      call add_controller(box, controller_t(by=9), status)
      call check(error, trim(status%subject), 'controller')

   contains

      subroutine reject(effect, what)
         class(effect_t), intent(in) :: effect
         character(len=*), intent(in) :: what
         character(len=*), parameter :: methods(3) = [character(len=13) :: 'nielsen_krenk', 'taylor', 'rk4']
         type(state_t) :: state
         class(stepper_t), allocatable :: stepper
         integer :: i
         do i = 1, size(methods)
            call make_box(box, state)
            call box%effects%add(effect)
            call make_stepper(box, integrator_settings_t(method=methods(i)), stepper, status)
            call check(error, status%code, NUTATE_BAD_ARGUMENT, what//' by a stepper of '//methods(i))
            call integrate(box, integrator_settings_t(method=methods(i)), state, usual, status)
            call check(error, status%code, NUTATE_BAD_ARGUMENT, what//' by a run of '//methods(i))
         end do
      end subroutine reject

   end subroutine effects_that_were_not_made

   subroutine chaos_out_of_range(error)
      type(error_type), allocatable, intent(out) :: error
      type(chaos_t) :: chaos
      type(run_t) :: run
      type(tangent_t) :: tangent
      type(system_t) :: box
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: nan
      call ieee_set_halting_mode(ieee_invalid, .false.)
      nan = ieee_value(nan, ieee_quiet_nan)
      call reject(chaos_settings_t(exponents=7))
      call reject(chaos_settings_t(exponents=-1))
      call reject(chaos_settings_t(exponents=1, every=0))
      call reject(chaos_settings_t(exponents=1, every=huge(1)))
      call reject(chaos_settings_t(exponents=1, vector=0.0_wp))
      call reject(chaos_settings_t(exponents=1, momentum_scale=nan))
      call reject(chaos_settings_t(exponents=1, momentum_scale=ieee_value(nan, ieee_positive_inf)))
      call reject(chaos_settings_t(exponents=1, momentum_scale=-1.0_wp))
      call make_box(box, state)
      call run%begin(box, integrator_settings_t(), state, usual, status)
      call run%differentiate([attitude_variation(1)], box, status)
      call run%follow_chaos(chaos_settings_t(exponents=-1), box, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'beside sensitivities')
      call chaos%begin(chaos_settings_t(exponents=1), box, state, tangent, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'a tangent without begin')

   contains

      subroutine reject(settings)
         type(chaos_settings_t), intent(in) :: settings
         call make_box(box, state)
         call integrate(box, integrator_settings_t(), state, usual, status, chaos=settings)
         call check(error, status%code, NUTATE_BAD_ARGUMENT, trim(status%message))
         call check(error, abs(state%t) <= 0.0_wp, 'moved')
      end subroutine reject

   end subroutine chaos_out_of_range

   subroutine history_not_open(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t) :: box
      type(state_t) :: state
      type(status_t) :: status
      type(history_t) :: history
      integer :: unit
      call make_box(box, state)
      call integrate(box, integrator_settings_t(), state, usual, status, history)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      call history%open('no/folder/never.csv', ['energy'], box, state, 0.0_wp, status)
      call integrate(box, integrator_settings_t(), state, usual, status, history)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'after a failure')
      call history%open('never.csv', ['energy'], box, state, 0.0_wp, status)
      call history%abandon(status)
      call integrate(box, integrator_settings_t(), state, usual, status, history)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'after its end')
      open (newunit=unit, file='never.csv.partial')
      close (unit, status='delete')
      call history%open('never.csv', ['energy'], box, state, 0.0_wp, status, digits=18)
      call check(error, trim(status%subject), 'digits')
      call history%open('never.csv', ['energy'], box, state, 0.0_wp, status, digits=-1)
      call check(error, trim(status%subject), 'digits')
      call history%open('', ['energy'], box, state, 0.0_wp, status)
      call check(error, trim(status%subject), 'name')
   end subroutine history_not_open

   !> Makes a box that rotates about its intermediate axis, and its initial state.
   subroutine make_box(box, state)
      type(system_t), intent(out) :: box
      type(state_t), intent(out) :: state
      type(status_t) :: status
      call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], box%body, status, mass=12.0_wp, &
                           center_of_mass=[0.0_wp, 0.0_wp, 0.3_wp])
      state = make_state(box, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.2_wp, 10.0_wp])
   end subroutine make_box

   !> Returns the event that a column crosses zero.
   type(column_event_t) function crossing_of(column) result(event)
      character(len=*), intent(in) :: column
      event%columns(1) = column
   end function crossing_of

   !> Returns a list of one event.
   function one_event(event) result(events)
      class(event_t), intent(in) :: event
      type(event_list_t) :: events
      call events%add(event)
   end function one_event

end submodule test_run_misuse
