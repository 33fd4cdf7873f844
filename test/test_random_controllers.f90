!> Controllers at all times, at random: what is at a limit asks for that much; accuracies are met across zeros of e₀,
!> where laws without limits jump.
module test_random_controllers
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_control, only: limit_events
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp
   use nutate_limit_event, only: limit_event_t
   use nutate_methods, only: default_settings
   use nutate_motion, only: find_motion, motion_t
   use nutate_quaternion, only: attitude_distance, quat_normalized
   use nutate_control_law, only: BY_MAGNETORQUERS, BY_TORQUE, BY_WHEELS, DETUMBLING
   use nutate_controller, only: controller_t
   use nutate_controller_mounting, only: add_controller
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: make_state, new_problem, problem_t, system_t
   use test_support, only: check, check_below, error_type, new_unittest, random_unit, random_unit_quaternion, &
                           random_vector, share_of, unittest_type
   implicit none
   private

   public :: collect_random_controllers, jump_error

   !> Compares at each row what a law asks for with what is at its limit.
   type, extends(observer_t) :: limit_watcher_t
      !> The farthest that a component at its limit was below it, or another one above it, over the limit.
      real(wp) :: worst = 0.0_wp
   contains
      procedure :: observe => compare_limits
   end type limit_watcher_t

   character(len=13), parameter :: methods(4) = [character(len=13) :: 'dop853', 'rk8', 'rk4', 'nielsen_krenk']

contains

   subroutine collect_random_controllers(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("what is at a limit asks for that much", limits_are_left), &
                  new_unittest("every limit has a name and its controller", limits_have_names), &
                  new_unittest("accuracies are met across the zeros of e0", accuracies_are_met), &
                  new_unittest("fixed steps keep their order across the zeros of e0", order_is_kept)]
   end subroutine collect_random_controllers

   !> Stiff B-dot loops that come to their limits and leave them, by steps that ring: many times longer than the loop's
   !> own time. A component that was not detected to leave its limit stayed there with the law requiring the opposite,
   !> from limit to limit without end.
   subroutine limits_are_left(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(limit_watcher_t) :: watcher
      type(state_t) :: state
      type(status_t) :: status
      character(len=32) :: label
      real(wp) :: step
      integer :: i
      problem => new_problem()
      do i = 1, share_of(150)
         call make_stiff_loop(i, problem, step)
         state = problem%start
         watcher = limit_watcher_t()
         call integrate(problem%system, integrator_settings_t(), state, &
                        run_plan_t(time_step=step, end_time=25*step), status, watcher)
         write (label, '(a,i0)') 'loop ', i
         call check(error, status%ok(), trim(label)//': '//trim(status%message))
         call check_below(error, watcher%worst, 1e-6_wp, trim(label))
      end do
   end subroutine limits_are_left

   !> The loop of a number, and a step of 3 to 30 of its own times.
   subroutine make_stiff_loop(number, problem, step)
      integer, intent(in) :: number
      type(problem_t), intent(inout) :: problem
      real(wp), intent(out) :: step
      type(controller_t) :: controller
      type(status_t) :: status
      integer(int64) :: seed
      real(wp) :: moments(3), rate
      integer :: i
      problem = new_problem()
      seed = 7919_int64*number + 1
      do i = 1, 20
         rate = random_unit(seed)
      end do
      moments = [(3 + 2*random_unit(seed), i=1, 3)]
      rate = 10**(1.5_wp*random_unit(seed) - 1)
      step = 10**(2*random_unit(seed) - 2)
      controller%name = 'controller'
      controller%law = DETUMBLING
      controller%by = BY_MAGNETORQUERS
      controller%field = [(random_unit(seed) - 0.5_wp, i=1, 3)]
      controller%gain = 10**(0.5_wp + random_unit(seed))*minval(moments)/(step*sum(controller%field**2))
      controller%limit = controller%gain*norm2(controller%field)*rate*10**(-3*random_unit(seed))
      call make_body(diagonal(moments), problem%system%body, status)
      call add_controller(problem%system, controller, status)
      problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], &
                                 [(rate*(2*random_unit(seed) - 1), i=1, 3)])
   end subroutine make_stiff_loop

   subroutine compare_limits(self, system, state, record, status)
      class(limit_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      type(motion_t) :: motion
      real(wp) :: asked(3)
      integer :: k
      call find_motion(system, state, motion)
      select type (controller => system%effects%torques(1)%item)
      class is (controller_t)
         asked = controller%command(state%t, quat_normalized(state%q), motion%relative)/controller%limit
         do k = 1, 3
            if (controller%saturated(k) /= 0) then
               self%worst = max(self%worst, 1 - controller%saturated(k)*asked(k))
            else
               self%worst = max(self%worst, abs(asked(k)) - 1)
            end if
         end do
      end select
   end subroutine compare_limits

   !> Checks the words in which a chattering run is reported: they name the controller.
   subroutine limits_have_names(error)
      type(error_type), allocatable, intent(out) :: error
      type(event_list_t) :: events
      type(problem_t), pointer :: problem
      integer :: i, k
      do k = BY_TORQUE, BY_MAGNETORQUERS
         problem => rotating(k, 1, label=merge('fine', '    ', k == BY_WHEELS))
         events = limit_events(problem%system%effects)
         call check(error, events%count() > 0, 'there are limits')
         do i = 1, events%count()
            if (allocated(error)) return
            select type (event => events%slots(i)%item)
            class is (limit_event_t)
               call check(error, index(event%words, merge("controller 'fine'", 'controller 1     ', &
                                                          k == BY_WHEELS)) > 0, event%words)
            class default
               call check(error, .false., 'the event is a limit')
            end select
         end do
      end do
   end subroutine limits_have_names

   !> A body of random moments that turns on past the attitude opposite to its target, again and again.
   function rotating(by, number, label) result(problem)
      integer, intent(in) :: by, number
      character(len=*), intent(in) :: label
      type(problem_t), pointer :: problem
      type(controller_t) :: controller
      type(status_t) :: status
      integer(int64) :: seed
      real(wp) :: moments(3), axis(3)
      integer :: i
      problem => new_problem()
      seed = 104729_int64*number + 7
      do i = 1, 20
         moments(1) = random_unit(seed)
      end do
      moments = [(3 + 2*random_unit(seed), i=1, 3)]
      call make_body(diagonal(moments), problem%system%body, status)
      controller%name = 'controller'
      controller%label = label
      controller%by = by
      controller%attitude_gain = 10**(random_unit(seed) - 1)*diagonal(moments)
      controller%rate_gain = 0.3_wp*random_unit(seed)*diagonal(moments)
      controller%target = random_unit_quaternion(seed)
      if (by == BY_MAGNETORQUERS) controller%field = random_vector(seed)
      do i = 1, merge(3, 0, by == BY_WHEELS)
         axis = 0.0_wp
         axis(i) = 1.0_wp
         call add_wheel(problem%system, wheel_t(name='wheel', axis=axis, inertia=0.1_wp), status)
      end do
      call add_controller(problem%system, controller, status)
      problem%start = make_state(problem%system, random_unit_quaternion(seed), 1.5_wp*random_vector(seed))
   end function rotating

   !> The error of a run to an accuracy over the larger of the accuracy and what the run says of it.
   subroutine jump_error(number, ratio, status)
      integer, intent(in) :: number
      real(wp), intent(out) :: ratio
      type(status_t), intent(out) :: status
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(run_plan_t) :: plan
      type(state_t) :: wanted, state
      real(wp) :: accuracy
      integer :: method, by
      method = 1 + mod(number, 4)
      by = 1 + mod(number/4, 3)
      if (methods(method) == 'nielsen_krenk' .and. by == BY_WHEELS) by = BY_TORQUE
      accuracy = 10.0_wp**(-4 - mod(number/12, merge(5, 3, method < 3)))
      problem => rotating(by, number, label='')
      ratio = 0.0_wp
      plan%end_time = 8.0_wp
      plan%goal = run_goal_t(local_tolerance=1e-14_wp)
      wanted = problem%start
      call integrate(problem%system, default_settings('dop853'), wanted, plan, status)
      if (.not. status%ok()) return
      plan%goal = run_goal_t(accuracy=accuracy)
      state = problem%start
      call integrate(problem%system, default_settings(methods(method)), state, plan, status, summary=summary)
      if (.not. status%ok()) return
      ratio = attitude_distance(state%q, wanted%q)/max(accuracy, summary%estimate)
      if (summary%estimate > accuracy) ratio = max(ratio, 1e3_wp)
   end subroutine jump_error

   subroutine accuracies_are_met(error)
      type(error_type), allocatable, intent(out) :: error
      type(status_t) :: status
      character(len=32) :: label
      real(wp) :: ratio
      integer :: i
      ! Every method, torque and accuracy; where fewer are drawn the largest accuracy alone.
      do i = 1, share_of(36)
         call jump_error(i, ratio, status)
         write (label, '(a,i0)') 'run ', i
         call check(error, status%ok(), trim(label)//': '//trim(status%message))
         call check_below(error, ratio, 1.0_wp, trim(label))
      end do
   end subroutine accuracies_are_met

   !> Also where the run begins with e₀ = 0 and leaves it to either side.
   subroutine order_is_kept(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: wanted, state
      type(status_t) :: status
      real(wp) :: errors(2)
      integer :: way, m, k
      do way = 1, 4
         problem => rotating(BY_TORQUE, 40 + way, label='')
         if (way > 2) call start_half_a_turn_off(problem, merge(1.0_wp, -1.0_wp, way == 3))
         wanted = problem%start
         call integrate(problem%system, default_settings('dop853'), wanted, &
                        run_plan_t(time_step=0.01_wp, end_time=8.0_wp), status)
         do m = 1, size(methods)
            do k = 1, 2
               state = problem%start
               call integrate(problem%system, default_settings(methods(m)), state, &
                              run_plan_t(time_step=merge(0.2_wp, 0.05_wp, m < 3)/k, end_time=8.0_wp), status)
               call check(error, status%ok(), trim(methods(m))//': '//trim(status%message))
               errors(k) = attitude_distance(state%q, wanted%q)
            end do
            call check(error, errors(2) < 1e-11_wp .or. log(errors(1)/errors(2))/log(2.0_wp) > &
                       merge(7.0_wp, merge(3.2_wp, 1.5_wp, m == 3), m < 3), trim(methods(m)))
         end do
      end do
   end subroutine order_is_kept

   !> Half a turn from the target, about axis 1, which goes on in one sense or in the other.
   subroutine start_half_a_turn_off(problem, sense)
      type(problem_t), intent(inout) :: problem
      real(wp), intent(in) :: sense
      select type (controller => problem%system%effects%torques(1)%item)
      class is (controller_t)
         controller%target = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      end select
      problem%start = make_state(problem%system, [0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp], [sense, 0.3_wp, -0.2_wp])
   end subroutine start_half_a_turn_off

end module test_random_controllers
