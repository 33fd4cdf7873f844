!> Motors by tables, limits of torque and of speed: closed forms with every method, the account and the momentum, runs
!> that are interrupted.
submodule(suites_of_effects) test_wheel_limits
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body
   use nutate_kinds, only: wp, long, eps
   use nutate_methods, only: methods
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_tabulated_torque, only: tabulated_torque_t
   use nutate_wheel, only: released_at, wheel_t
   use nutate_wheel_motor, only: make_motor_table
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: angular_velocity, forced_body, kinetic_energy, make_state, new_problem, problem_t, &
      space_momentum, total_energy
   use test_resume, only: check_run, label_of, settings_of
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest
   implicit none

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

contains

   module procedure collect_wheel_limits
      testsuite = [ &
                  new_unittest("a table of one torque is a constant motor", one_torque_is_constant), &
                  new_unittest("a limit of torque cuts the lines of a table", limit_cuts_a_table), &
                  new_unittest("a motor holds at the limit of its speed", speed_limit_has_the_closed_form), &
                  new_unittest("friction lets a motor push again", friction_releases_the_motor), &
                  new_unittest("account and momentum with limits", account_and_momentum), &
                  new_unittest("what is interrupted goes on bit for bit", runs_go_on), &
                  new_unittest("limits that cannot be kept are refused", bad_limits_are_refused)]
   end procedure collect_wheel_limits

   !> A body with a wheel on its axis 3, driven by a motor of one's own.
   function driven_wheel(motor, friction, speed_limit) result(problem)
      class(tabulated_torque_t), intent(in), optional :: motor
      real(wp), intent(in), optional :: friction, speed_limit
      type(problem_t), pointer :: problem
      type(wheel_t) :: wheel
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([4.0_wp, 5.0_wp, 3.0_wp]), problem%system%body, status)
      wheel = wheel_t(name='wheel', axis=[0.0_wp, 0.0_wp, 1.0_wp], inertia=0.2_wp)
      if (present(friction)) wheel%friction = friction
      if (present(speed_limit)) wheel%speed_limit = speed_limit
      if (present(motor)) then
         allocate (wheel%motor, source=motor)
      else
         allocate (wheel%motor, source=applied_torque_t(amplitude=[0.5_wp, 0.0_wp, 0.0_wp]))
      end if
      call add_wheel(problem%system, wheel, status)
      problem%start = make_state(problem%system, identity, [0.0_wp, 0.0_wp, 0.1_wp])
   end function driven_wheel

   !> Runs a problem; its end in the problem's start.
   subroutine run(problem, settings, plan, summary, status)
      type(problem_t), intent(inout) :: problem
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      call integrate(problem%system, settings, problem%start, plan, status, summary=summary)
   end subroutine run

   !> ω of the wheel.
   real(wp) function speed_of(problem) result(speed)
      type(problem_t), intent(in) :: problem
      speed = problem%system%effects%wheels(1)%speed_of(problem%start%wheel_momentum(1), &
                                                        angular_velocity(problem%system, problem%start))
   end function speed_of

   subroutine one_torque_is_constant(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: motor
      type(problem_t), pointer :: by_table, constant
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: m, at
      call make_motor_table([-1.0_wp, 0.83_wp, 9.0_wp], [0.5_wp, 0.5_wp, 0.5_wp], motor, status, at)
      do m = 1, size(methods)
         if (methods(m)%name == 'exact') cycle
         by_table => driven_wheel(motor)
         constant => driven_wheel()
         call run(by_table, settings_of(methods(m)), run_plan_t(time_step=0.1_wp, end_time=2.0_wp), summary, status)
         call check(error, status%ok(), trim(status%message))
         call run(constant, settings_of(methods(m)), run_plan_t(time_step=0.1_wp, end_time=2.0_wp), summary, status)
         call check_close(error, by_table%start%wheel_momentum(1), constant%start%wheel_momentum(1), 8*eps, &
                          label_of(methods(m)))
         call check_below(error, attitude_distance(by_table%start%q, constant%start%q), merge(1e-4_wp, 1e-9_wp, &
                          methods(m)%order < 6), label_of(methods(m)))
      end do
   end subroutine one_torque_is_constant

   !> A ramp from -2 to 2 N m, and a jump, cut at 0.5: the gain is that of the trapezium, and steps end on its corners.
   subroutine limit_cuts_a_table(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: times(4) = [0.0_wp, 4.0_wp, 4.0_wp, 5.0_wp], torques(4) = [-2.0_wp, 2.0_wp, -3.0_wp, &
            0.25_wp]
      type(tabulated_torque_t) :: motor
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(status_t) :: status
      real(wp) :: t, corners(6)
      integer :: m, i, at
      call make_motor_table(times, torques, motor, status, at, torque_limit=0.5_wp)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      t = -1.0_wp
      do i = 1, 6
         t = motor%next_break(t, 1.0_wp)
         corners(i) = t
      end do
      call check_close(error, corners, [0.0_wp, 1.5_wp, 2.0_wp, 2.5_wp, 4.0_wp, 4.0_wp + 2.5_wp/3.25_wp], 8*eps, &
            'corners')
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. allocated(error)) cycle
         problem => driven_wheel(motor)
         call run(problem, settings_of(methods(m)), run_plan_t(time_step=0.7_wp, end_time=6.0_wp), summary, status)
         call check(error, status%ok(), trim(status%message))
         ! The ramp adds and removes equal momentum; behind the jump it is -0.5 up to a corner, and a triangle each way.
         call check_close(error, problem%start%wheel_momentum(1), 0.2_wp*0.1_wp - 0.5_wp*(2.5_wp/3.25_wp) &
                          - 0.5_wp*0.5_wp*(0.5_wp/3.25_wp) + 0.5_wp*0.25_wp*(0.25_wp/3.25_wp), 64*eps, &
                                label_of(methods(m)))
      end do
   end subroutine limit_cuts_a_table

   !> Without friction ω grows by u(1/Jw + 1/Jr) and then stays: the motor's work and the rate of the body tell when.
   subroutine speed_limit_has_the_closed_form(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: limit = 4.0_wp, gain = 1/(1/0.2_wp + 1/2.8_wp)
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(status_t) :: status
      type(run_plan_t) :: plan
      real(wp) :: omega(3)
      integer :: m, way
      do m = 1, size(methods)
         if (methods(m)%name == 'exact') cycle
         do way = 1, 2
            problem => driven_wheel(speed_limit=limit)
            plan = run_plan_t(time_step=0.3_wp, end_time=4.0_wp)
            if (way == 2) plan = run_plan_t(goal=run_goal_t(local_tolerance=1e-8_wp), end_time=4.0_wp)
            call run(problem, settings_of(methods(m)), plan, summary, status)
            call check(error, status%ok(), trim(status%message))
            omega = angular_velocity(problem%system, problem%start)
            call check_close(error, speed_of(problem), limit, 64*eps*limit, label_of(methods(m))//', speed')
            call check_close(error, omega(3), 0.1_wp - limit*gain/2.8_wp, 64*eps, label_of(methods(m))//', rate')
            call check_close(error, problem%start%wheel_work(1, 1), 0.5_wp*limit**2*gain, 256*eps, &
                             label_of(methods(m))//', work')
         end do
      end do
   end subroutine speed_limit_has_the_closed_form

   !> ω = (u/c)(1 - exp(-ckt)), k = 1/Jw + 1/Jr, up to the limit, and from then on between it and a hundredth below.
   subroutine friction_releases_the_motor(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: limit = 3.0_wp, c = 0.04_wp, u = 0.5_wp, rate = c*(1/0.2_wp + 1/2.8_wp), end_time = 4.0_wp
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(status_t) :: status
      real(wp) :: t, down, up, wanted
      integer :: m
      t = end_time + log(1 - limit*c/u)/rate
      down = -log(released_at)/rate
      up = log((u/c - released_at*limit)/(u/c - limit))/rate
      t = modulo(t, down + up)
      if (t < down) then
         wanted = limit*exp(-rate*t)
      else
         wanted = u/c - (u/c - released_at*limit)*exp(-rate*(t - down))
      end if
      do m = 1, size(methods)
         if (methods(m)%name == 'exact') cycle
         ! About a fixed axis no attitude restores the energy that the error of h of order 4 takes.
         if (methods(m)%projected .and. methods(m)%order == 4) cycle
         problem => driven_wheel(friction=c, speed_limit=limit)
         call run(problem, settings_of(methods(m)), run_plan_t(time_step=0.05_wp, end_time=end_time), summary, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, speed_of(problem), wanted, merge(2e-4_wp, 1e-8_wp, methods(m)%order == 2), &
                          label_of(methods(m)))
      end do
   end subroutine friction_releases_the_motor

   !> Two wheels with limits of speed, one with friction, one by a table that is cut, on a tumbling body,
   !> beside every kind of effect or alone.
   function limited_wheels(alone) result(problem)
      logical, intent(in) :: alone
      type(problem_t), pointer :: problem
      type(tabulated_torque_t) :: motor
      type(wheel_t) :: wheel
      type(status_t) :: status
      integer :: at
      problem => new_problem()
      if (alone) then
         call make_body(diagonal([4.0_wp, 5.0_wp, 6.0_wp]), problem%system%body, status)
      else
         problem => forced_body()
      end if
      call make_motor_table([0.0_wp, 0.37_wp, 0.9_wp], [3.0_wp, -2.0_wp, 5.0_wp], motor, status, at, periodic=.true., &
                            torque_limit=1.5_wp, stops_at_a_speed=.true.)
      wheel = wheel_t(name='wheel', axis=[2.0_wp, -1.0_wp, 2.0_wp]/3, inertia=0.1_wp, speed=1.0_wp, speed_limit=3.0_wp)
      allocate (wheel%motor, source=motor)
      call add_wheel(problem%system, wheel, status)
      deallocate (wheel%motor)
      wheel = wheel_t(name='wheel', axis=[0.0_wp, 0.6_wp, 0.8_wp], inertia=0.2_wp, friction=0.2_wp, speed_limit=2.5_wp)
      allocate (wheel%motor, source=applied_torque_t(amplitude=[-2.5_wp, 0.0_wp, 0.0_wp]))
      call add_wheel(problem%system, wheel, status)
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [1.0_wp, -0.5_wp, 1.5_wp])
   end function limited_wheels

   subroutine account_and_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: before
      type(problem_t) :: problem
      type(run_summary_t) :: summary
      type(run_plan_t) :: plan
      type(status_t) :: status
      real(wp) :: energy, size_of_energy
      integer :: m, way
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. .not. methods(m)%conserving) cycle
         do way = 1, 3
            if (.not. in_turn(m + way)) cycle
            before => limited_wheels(alone=way /= 1)
            problem = before
            plan = run_plan_t(time_step=0.02_wp, end_time=2.0_wp)
            if (way == 3) plan = run_plan_t(goal=run_goal_t(local_tolerance=1e-8_wp), end_time=2.0_wp)
            energy = total_energy(before%system, before%start)
            call run(problem, settings_of(methods(m)), plan, summary, status)
            call check(error, status%ok(), trim(status%message))
            size_of_energy = abs(energy) + kinetic_energy(problem%system, problem%start) + sum(abs(summary%work))
            call check_below(error, abs(total_energy(problem%system, problem%start) - energy - sum(summary%work)), &
                             64*eps*size_of_energy, label_of(methods(m))//', account')
            ! A step of halves that is taken again, for an event, reads the targets of the projection anew.
            if (way > 1) call check_below(error, norm2(space_momentum(problem%start) - space_momentum(before%start)), &
                                          merge(256, 64, way == 3)*eps*norm2(space_momentum(before%start)), &
                                          label_of(methods(m))//', momentum')
         end do
      end do
   end subroutine account_and_momentum

   subroutine runs_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: m
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. .not. in_turn(m)) cycle
         call check_run(error, limited_wheels(alone=.false.), settings_of(methods(m)), &
                        run_plan_t(time_step=0.05_wp, end_time=1.0_wp, every=3_long), [2, 3, 5, 8, 10, 14, 17], &
                        label_of(methods(m)))
         call check_run(error, limited_wheels(alone=.false.), settings_of(methods(m)), &
                        run_plan_t(goal=run_goal_t(local_tolerance=1e-7_wp), end_time=0.5_wp), [1, 3, 4], &
                              label_of(methods(m)))
      end do
   end subroutine runs_go_on

   subroutine bad_limits_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(tabulated_torque_t) :: motor
      type(problem_t), pointer :: problem
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: at
      call make_motor_table([0.0_wp, 1.0_wp], [1.0_wp, 2.0_wp], motor, status, at, spline=.true., torque_limit=1.0_wp)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'a spline')
      call make_motor_table([0.0_wp, -1.0_wp], [1.0_wp, 2.0_wp], motor, status, at, torque_limit=1.0_wp)
      call check(error, status%code == NUTATE_BAD_ARGUMENT .and. at == 2, 'back in time')
      problem => driven_wheel(speed_limit=1.0_wp)
      call run(problem, integrator_settings_t(), run_plan_t(goal=run_goal_t(accuracy=1e-6_wp), end_time=1.0_wp), &
            summary, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'an accuracy')
      call add_wheel(problem%system, wheel_t(name='wheel', axis=[1.0_wp, 0.0_wp, 0.0_wp], inertia=0.1_wp, &
            speed_limit=0.0_wp), &
                     status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT, 'no speed at all')
   end subroutine bad_limits_are_refused

end submodule test_wheel_limits
