!> Limits of controllers that act at all times: located, so that methods keep their order; exact in the account; targets
!> that go round with an orbit.
submodule(suites_of_effects) test_saturation
   use nutate_body, only: diagonal, make_body
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, long, eps
   use nutate_methods, only: integrator_settings_t, method_t, methods
   use nutate_motion, only: find_motion, motion_t
   use nutate_orbit, only: orbit_t
   use nutate_quaternion, only: attitude_distance, quat_exp, quat_product
   use nutate_control_law, only: BY_MAGNETORQUERS, BY_TORQUE, BY_WHEELS, DETUMBLING
   use nutate_controller, only: controller_t
   use nutate_controller_mounting, only: add_controller
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: angular_velocity, forced_body, kinetic_energy, make_state, new_problem, new_system, &
      problem_t, space_momentum, system_t, total_energy
   use test_resume, only: check_run, label_of, settings_of
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest
   implicit none

   real(wp), parameter :: moments(3) = [4.0_wp, 5.0_wp, 3.0_wp], field(3) = [0.4_wp, -0.3_wp, 0.7_wp]
   type(integrator_settings_t), parameter :: fine = integrator_settings_t(method='dop853', order=8, formulation='')

   !> The greatest torque of the motor of wheel 1 that the change of its momentum shows, and its greatest speed.
   type, extends(observer_t) :: wheel_watcher_t
      real(wp) :: torque = 0.0_wp, speed = 0.0_wp, t = 0.0_wp, momentum = 0.0_wp
      logical :: begun = .false.
   contains
      procedure :: observe => watch_wheel
   end type wheel_watcher_t

contains

   module procedure collect_saturation
      testsuite = [ &
                  new_unittest("a turn from full torque to the law, in closed form", turn_has_the_closed_form), &
                  new_unittest("methods keep their order across limits", order_is_kept), &
                  new_unittest("account and momentum with limits", account_and_momentum), &
                  new_unittest("a motor within the limits of torque and speed", motor_minds_its_limits), &
                  new_unittest("a law that jumps from limit to limit", law_jumps), &
                  new_unittest("derivatives with components at the limit", derivatives_at_limits), &
                  new_unittest("runs with limits go on bit for bit", runs_go_on), &
                  new_unittest("a target seen from an orbit is the one in its axes", target_of_the_orbit), &
                  new_unittest("who has no run refuses limits", limits_need_runs)]
   end procedure collect_saturation

   !> The law -k J e_v - d J Ω at all times.
   pure type(controller_t) function pointing(by, limit) result(controller)
      integer, intent(in) :: by
      real(wp), intent(in) :: limit
      controller%name = 'controller'
      controller%by = by
      controller%limit = limit
      controller%attitude_gain = 0.6_wp*diagonal(moments)
      controller%rate_gain = 0.5_wp*diagonal(moments)
      if (by == BY_MAGNETORQUERS) controller%field = field
   end function pointing

   !> A body that turns about its axis 3, θ(0) = 1 rad.
   function plain_turn(controller, wheel) result(problem)
      type(controller_t), intent(in) :: controller
      type(wheel_t), intent(in), optional :: wheel
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      if (present(wheel)) call add_wheel(problem%system, wheel, status)
      call add_controller(problem%system, controller, status)
      problem%start = make_state(problem%system, [cos(0.5_wp), 0.0_wp, 0.0_wp, sin(0.5_wp)], [0.0_wp, 0.0_wp, 0.4_wp])
   end function plain_turn

   !> A tumbling body with four wheels on inclined axes and a controller.
   function tumbling(controller, forced, torque_limit, speed_limit) result(problem)
      type(controller_t), intent(in) :: controller
      !> The body has every other kind of effect too.
      logical, intent(in) :: forced
      !> Limits of the motors, N m and rad/s.
      real(wp), intent(in) :: torque_limit, speed_limit
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: axis(3)
      integer :: i
      problem => new_problem()
      if (forced) problem => forced_body()
      if (.not. forced) call make_body(diagonal(moments), problem%system%body, status)
      do i = 1, 4
         axis = [merge(1, -1, i < 3), merge(1, -1, mod(i, 2) == 0), 1]
         call add_wheel(problem%system, wheel_t(name='wheel', axis=axis/norm2(axis), inertia=0.05_wp, &
               speed=i*1.0_wp, torque_limit=torque_limit, speed_limit=speed_limit), status)
      end do
      call add_controller(problem%system, controller, status)
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [0.3_wp, -0.2_wp, 0.4_wp])
   end function tumbling

   !> Methods that take a law which acts at all times; by wheels the explicit ones.
   pure logical function takes_laws(method, by)
      type(method_t), intent(in) :: method
      integer, intent(in) :: by
      takes_laws = method%name /= 'exact' .and. method%name /= 'taylor'
      if (by == BY_WHEELS) takes_laws = takes_laws .and. method%name /= 'nielsen_krenk'
   end function takes_laws

   !> θ and θ' at a time: full torque until the law asks for less, by bisection of its parabola, and from there on the
   !> law, by short steps of a Runge-Kutta method.
   subroutine turn_in_two_parts(until, inertia, limit, theta, rate)
      !> s; kg m²; N m.
      real(wp), intent(in) :: until, inertia, limit
      real(wp), intent(out) :: theta, rate
      integer, parameter :: n = 40000
      real(wp) :: low, high, middle, y(2), k1(2), k2(2), k3(2), k4(2), h
      integer :: i
      low = 0.0_wp
      high = 3.0_wp
      do i = 1, 60
         middle = 0.5_wp*(low + high)
         y = parabola(middle)
         if (-law(y) > limit) low = middle
         if (.not. -law(y) > limit) high = middle
      end do
      y = parabola(high)
      h = (until - high)/n
      do i = 1, n
         k1 = slope(y)
         k2 = slope(y + 0.5_wp*h*k1)
         k3 = slope(y + 0.5_wp*h*k2)
         k4 = slope(y + h*k3)
         y = y + (h/6)*(k1 + 2*k2 + 2*k3 + k4)
      end do
      theta = y(1)
      rate = y(2)

   contains

      pure function parabola(t) result(y)
         real(wp), intent(in) :: t
         real(wp) :: y(2)
         y = [1 + 0.4_wp*t - 0.5_wp*(limit/inertia)*t*t, 0.4_wp - (limit/inertia)*t]
      end function parabola

      pure real(wp) function law(y)
         real(wp), intent(in) :: y(2)
         law = -3*(0.6_wp*sin(0.5_wp*y(1)) + 0.5_wp*y(2))
      end function law

      pure function slope(y)
         real(wp), intent(in) :: y(2)
         real(wp) :: slope(2)
         slope = [y(2), law(y)/inertia]
      end function slope

   end subroutine turn_in_two_parts

   !> Checks a rotation by torque, and by a wheel on the axis, without whose inertia the body rotates.
   subroutine turn_has_the_closed_form(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t) :: problems(2)
      type(run_plan_t) :: plan
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: theta, rate, omega(3)
      integer :: m, i
      problems(1) = plain_turn(pointing(BY_TORQUE, 0.7_wp))
      problems(2) = plain_turn(pointing(BY_WHEELS, huge(1.0_wp)), &
                               wheel_t(name='wheel', axis=[0.0_wp, 0.0_wp, 1.0_wp], inertia=0.1_wp, &
                                       torque_limit=0.7_wp))
      do i = 1, 2
         call turn_in_two_parts(6.2_wp, merge(3.0_wp, 2.9_wp, i == 1), 0.7_wp, theta, rate)
         do m = 1, size(methods)
            if (.not. takes_laws(methods(m), merge(BY_TORQUE, BY_WHEELS, i == 1))) cycle
            state = problems(i)%start
            plan = run_plan_t(time_step=0.02_wp, end_time=6.2_wp)
            call integrate(problems(i)%system, settings_of(methods(m)), state, plan, status)
            call check(error, status%ok(), label_of(methods(m))//': '//trim(status%message))
            omega = angular_velocity(problems(i)%system, state)
            call check_close(error, omega(3), rate, bound_of(methods(m)%order), label_of(methods(m))//', rate')
            call check_close(error, 2*atan2(state%q(4), state%q(1)), theta, bound_of(methods(m)%order), &
                             label_of(methods(m)))
         end do
      end do

   contains

      !> Returns the bound of errors of 310 steps of 0.02 s.
      pure real(wp) function bound_of(order) result(bound)
         integer, intent(in) :: order
         bound = 1e-11_wp
         if (order == 2) bound = 2e-4_wp
         if (order == 4) bound = 1e-8_wp
      end function bound_of

   end subroutine turn_has_the_closed_form

   !> Compares with dop853 at short steps, with limits that are left and reached again.
   subroutine order_is_kept(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: halvings = 3
      type(problem_t) :: problems(4)
      type(state_t) :: wanted, state
      type(status_t) :: status
      type(run_summary_t) :: summary
      real(wp) :: errors(halvings), step
      integer :: i, m, k, by(4)
      by = [BY_TORQUE, BY_MAGNETORQUERS, BY_MAGNETORQUERS, BY_WHEELS]
      problems(1) = tumbling(pointing(BY_TORQUE, 0.5_wp), .false., huge(1.0_wp), huge(1.0_wp))
      problems(2) = tumbling(pointing(BY_MAGNETORQUERS, 0.8_wp), .false., huge(1.0_wp), huge(1.0_wp))
      problems(3) = tumbling(controller_t(name='controller', law=DETUMBLING, by=BY_MAGNETORQUERS, gain=1.5_wp, &
                                          field=field, limit=0.15_wp), .false., huge(1.0_wp), huge(1.0_wp))
      problems(4) = tumbling(pointing(BY_WHEELS, huge(1.0_wp)), .false., 0.3_wp, 12.0_wp)
      do i = 1, size(problems)
         wanted = problems(i)%start
         call integrate(problems(i)%system, fine, wanted, run_plan_t(time_step=0.002_wp, end_time=3.2_wp), status)
         do m = 1, size(methods)
            if (.not. takes_laws(methods(m), by(i)) .or. .not. in_turn(m + i)) cycle
            do k = 1, halvings
               step = merge(0.05_wp, 0.2_wp, methods(m)%order < 6)/2**k
               state = problems(i)%start
               call integrate(problems(i)%system, settings_of(methods(m)), state, &
                              run_plan_t(time_step=step, end_time=3.2_wp), status, summary=summary)
               call check(error, status%ok(), label_of(methods(m))//': '//trim(status%message))
               errors(k) = attitude_distance(state%q, wanted%q)
            end do
            ! Steps end on limits at other places for each length: errors fall by the order on the whole.
            call check(error, errors(halvings) < 1e-11_wp .or. &
                       log(errors(1)/errors(halvings))/log(2.0_wp) > (halvings - 1)*(methods(m)%order - 0.8_wp), &
                       label_of(methods(m)))
         end do
      end do
   end subroutine order_is_kept

   !> Checks controllers beside every other effect. With wheels all momentum stays if no external torque acts.
   subroutine account_and_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      type(run_summary_t) :: summary
      real(wp) :: energy
      integer :: m, way, by
      do way = 1, 4
         by = merge(BY_WHEELS, merge(BY_MAGNETORQUERS, BY_TORQUE, way == 3), way < 3)
         problem => tumbling(pointing(by, merge(huge(1.0_wp), 0.6_wp, by == BY_WHEELS)), way > 1, &
                            0.2_wp, merge(huge(1.0_wp), 12.0_wp, way > 2))
         do m = 1, size(methods)
            if (.not. takes_laws(methods(m), by) .or. .not. methods(m)%conserving) cycle
            state = problem%start
            energy = total_energy(problem%system, state)
            call integrate(problem%system, settings_of(methods(m)), state, &
                           run_plan_t(time_step=0.03_wp, end_time=2.0_wp), status, summary=summary)
            call check(error, status%ok(), label_of(methods(m))//': '//trim(status%message))
            call check_below(error, abs(total_energy(problem%system, state) - energy - sum(summary%work)), &
                             64*eps*(abs(energy) + kinetic_energy(problem%system, state) + sum(abs(summary%work))), &
                             label_of(methods(m))//', account')
            if (way == 1) call check_below(error, norm2(space_momentum(state) - space_momentum(problem%start)), &
                                           64*eps*norm2(space_momentum(problem%start)), &
                                           label_of(methods(m))//', momentum')
         end do
      end do
   end subroutine account_and_momentum

   !> Checks that the motor alone changes the wheel's momentum on its own axis: by no more than its limit allows; and
   !> that its speed stays within its limit, but reaches it.
   subroutine motor_minds_its_limits(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: torque_limit = 0.7_wp, speed_limit = 9.0_wp
      type(problem_t), pointer :: problem
      type(wheel_watcher_t) :: watcher
      type(state_t) :: state
      type(status_t) :: status
      problem => plain_turn(pointing(BY_WHEELS, huge(1.0_wp)), &
                           wheel_t(name='wheel', axis=[0.0_wp, 0.0_wp, 1.0_wp], inertia=0.1_wp, &
                                   torque_limit=torque_limit, speed_limit=speed_limit))
      state = problem%start
      call integrate(problem%system, fine, state, run_plan_t(time_step=0.01_wp, end_time=12.0_wp), status, watcher)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, watcher%torque, torque_limit*(1 + 1e-9_wp), 'torque')
      call check_below(error, 0.999_wp*torque_limit, watcher%torque, 'at its limit')
      call check_below(error, watcher%speed, speed_limit*(1 + 1e-9_wp), 'speed')
      call check_below(error, speed_limit*(1 - 1e-9_wp), watcher%speed, 'at its limit')
   end subroutine motor_minds_its_limits

   subroutine watch_wheel(self, system, state, record, status)
      class(wheel_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      type(motion_t) :: motion
      call find_motion(system, state, motion)
      if (self%begun .and. state%t > self%t) &
         self%torque = max(self%torque, abs(state%wheel_momentum(1) - self%momentum)/(state%t - self%t))
      self%speed = max(self%speed, abs(system%effects%wheels(1)%speed_of(state%wheel_momentum(1), motion%omega)))
      self%t = state%t
      self%momentum = state%wheel_momentum(1)
      self%begun = .true.
   end subroutine watch_wheel

   !> Checks a torque that jumps from one limit to the other where e₀ passes zero: half a turn ahead of the target the
   !> body is driven on, and then back; it is never driven harder than the limit allows.
   subroutine law_jumps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: omega(3), before
      integer :: i
      problem => plain_turn(pointing(BY_TORQUE, 0.7_wp))
      problem%start = make_state(problem%system, [cos(1.5_wp), 0.0_wp, 0.0_wp, sin(1.5_wp)], [0.0_wp, 0.0_wp, 1.4_wp])
      state = problem%start
      before = 1.4_wp
      do i = 1, 200
         call integrate(problem%system, fine, state, run_plan_t(time_step=0.05_wp, end_time=0.1_wp*i), status)
         call check(error, status%ok(), trim(status%message))
         omega = angular_velocity(problem%system, state)
         call check_below(error, abs(omega(3) - before), 0.1_wp*0.7_wp/3*(1 + 1e-9_wp), 'no more than the limit')
         before = omega(3)
      end do
      call check_below(error, 1 - abs(state%q(1)), 1e-3_wp, 'it comes to its target')
   end subroutine law_jumps

   !> Analytic ones against central differences of the torque, at random states, for every set of components at limits.
   subroutine derivatives_at_limits(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1e-5_wp
      type(controller_t) :: controllers(4)
      real(wp) :: q(4), omega(3), by_rotation(3, 3), by_rate(3, 3), change(3), shift(3), t
      integer :: r, c, i
      controllers = pointing(BY_TORQUE, 0.7_wp)
      controllers(2) = pointing(BY_MAGNETORQUERS, 0.7_wp)
      controllers(3) = controller_t(name='controller', law=DETUMBLING, by=BY_MAGNETORQUERS, gain=1.5_wp, field=field, &
                                  limit=0.4_wp)
      call controllers(4)%follow_orbit(orbit_t(kepler_orbit_t(eccentricity=0.4_wp, inclination=0.4_wp, raan=1.0_wp)))
      t = 0.7_wp
      do r = 1, size(controllers)
         do c = 0, 26
            controllers(r)%saturated = [mod(c, 3), mod(c/3, 3), c/9] - 1
            q = quat_exp([0.3_wp, -0.5_wp, 0.1_wp*c])
            omega = [0.6_wp, -0.05_wp*c, 0.4_wp]
            call controllers(r)%derivatives(t, q, omega, by_rotation, by_rate)
            do i = 1, 3
               shift = 0.0_wp
               shift(i) = 0.5_wp*h
               change = (controllers(r)%torque(t, quat_product(q, quat_exp(shift)), omega) &
                         - controllers(r)%torque(t, quat_product(q, quat_exp(-shift)), omega))/(2*h)
               call check_below(error, norm2(by_rotation(:, i) - change), 1e-8_wp, 'by rotation')
               change = (controllers(r)%torque(t, q, omega + 2*shift) &
                         - controllers(r)%torque(t, q, omega - 2*shift))/(2*h)
               call check_below(error, norm2(by_rate(:, i) - change), 1e-8_wp, 'by rate')
            end do
         end do
      end do
   end subroutine derivatives_at_limits

   !> Interrupted before, at and behind limits.
   subroutine runs_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      integer :: m, way, by
      do way = 1, 3
         by = merge(BY_WHEELS, merge(BY_MAGNETORQUERS, BY_TORQUE, way == 2), way == 1)
         problem => tumbling(pointing(by, merge(huge(1.0_wp), 0.6_wp, by == BY_WHEELS)), .true., 0.2_wp, 6.0_wp)
         do m = 1, size(methods)
            if (.not. takes_laws(methods(m), by)) cycle
            call check_run(error, problem, settings_of(methods(m)), &
                           run_plan_t(time_step=0.05_wp, end_time=1.0_wp, every=3_long), [1, 2, 3, 4, 5, 7, 14], &
                           label_of(methods(m)))
         end do
      end do
   end subroutine runs_go_on

   !> Checks the same motion on a circular orbit, from its own axes and from inertial ones, by torque and by wheels,
   !> with limits.
   subroutine target_of_the_orbit(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: until = 40.0_wp
      type(kepler_orbit_t) :: path
      type(controller_t) :: controller
      type(system_t), pointer :: empty
      type(system_t) :: system
      type(orbit_t) :: orbit
      type(state_t) :: states(2)
      type(status_t) :: status
      real(wp) :: q(4)
      integer :: way, by
      empty => new_system()
      path = kepler_orbit_t(mu=0.04_wp, inclination=0.5_wp, raan=0.3_wp, mean_anomaly=1.0_wp)
      do by = BY_TORQUE, BY_WHEELS
         do way = 1, 2
            system = empty
            call make_body(diagonal(moments), system%body, status)
            orbit = orbit_t(path, inertial=way == 2)
            call system%effects%add(orbit)
            if (by == BY_WHEELS) call add_three_wheels(system)
            controller = pointing(by, merge(0.5_wp, huge(1.0_wp), by == BY_TORQUE))
            ! Ten times stiffer, so that what the turn of the orbit asks for leaves a small error.
            controller%attitude_gain = 10*controller%attitude_gain
            controller%rate_gain = 10*controller%rate_gain
            controller%target = quat_exp([0.2_wp, -0.1_wp, 0.3_wp])
            controller%follows_orbit = .true.
            call add_controller(system, controller, status)
            call check(error, status%ok(), trim(status%message))
            q = quat_exp([0.4_wp, 0.3_wp, -0.2_wp])
            if (way == 2) q = quat_product(path%axes(0.0_wp), q)
            states(way) = make_state(system, q, [0.1_wp, -0.3_wp, 0.2_wp])
            call integrate(system, fine, states(way), run_plan_t(time_step=0.01_wp, end_time=until), status)
            call check(error, status%ok(), trim(status%message))
         end do
         q = quat_product(path%axes(until), states(1)%q)
         call check_below(error, attitude_distance(q, states(2)%q), 1e-11_wp, 'the same motion')
         ! The body has reached its target, which rotates by 8 rad in this time.
         call check_below(error, attitude_distance(states(1)%q, controller%target), 0.1_wp, 'its target')
      end do
      system = empty
      call make_body(diagonal(moments), system%body, status)
      call add_controller(system, controller, status)
      call check(error, status%code == NUTATE_BAD_ARGUMENT .and. index(status%message, 'expected &orbit') > 0, &
                 'no orbit')

   contains

      subroutine add_three_wheels(system)
         type(system_t), intent(inout) :: system
         real(wp) :: axis(3)
         integer :: i
         do i = 1, 3
            axis = 0.0_wp
            axis(i) = 1.0_wp
            call add_wheel(system, wheel_t(name='wheel', axis=axis, inertia=0.05_wp, torque_limit=0.4_wp), status)
         end do
      end subroutine add_three_wheels

   end subroutine target_of_the_orbit

   subroutine limits_need_runs(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      problem => plain_turn(pointing(BY_TORQUE, 0.7_wp))
      state = problem%start
      call integrate(problem%system, fine, state, &
                     run_plan_t(goal=run_goal_t(accuracy=1e-6_wp), end_time=1.0_wp), status)
      call check(error, status%code == NUTATE_BAD_ARGUMENT .and. index(status%message, 'limit') > 0, &
                 trim(status%message))
   end subroutine limits_need_runs

end submodule test_saturation
