!> A magnetic moment in the field of the Earth and forces that turn with an orbit: against explicit integration of the
!> equations of motion, and the account with the work of time-dependent potentials.
submodule(suites_of_effects) test_moving_fields
   use nutate_attitude, only: quat_from_axis_angle
   use nutate_body, only: diagonal, make_body
   use nutate_lvlh_vector, only: lvlh_vector_t
   use nutate_damping, only: damping_t
   use nutate_earth_field, only: earth_field_t
   use nutate_effect, only: effect_t
   use nutate_force, only: force_t, moving_force_t
   use nutate_geomagnetic_field, only: geomagnetic_field_t
   use nutate_gravity, only: gravity_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, eps
   use nutate_orbit, only: orbit_t
   use nutate_quaternion, only: cross, quat_product, rotate_to_body, rotate_to_space
   use nutate_control_law, only: BY_MAGNETORQUERS, DETUMBLING
   use nutate_controller, only: controller_t
   use nutate_controller_mounting, only: add_controller
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate, observer_t, run_record_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_timed_force, only: timed_force_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: angular_velocity, conserved_energy, make_state, new_problem, problem_t, space_momentum, &
      system_t, time_dependent_power
   use test_satellites, only: degree, field_along, magnet, moments, path_of, point, push, push_along, satellite, &
      rotating, BOTH, FORCE_ALONG, MAGNETIC
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest
   implicit none

   real(wp), parameter :: end_time = 3000.0_wp
   !> Gain of B-dot, A m² s/T.
   real(wp), parameter :: gain = 5e4_wp

   !> Methods, with the steps that they need for 1e-11 rad; the first four conserve.
   integer, parameter :: n_methods = 7
   character(len=13), parameter :: methods(n_methods) = [character(len=13) :: 'nielsen_krenk', 'nielsen_krenk', &
                                                         'taylor', 'dop853', 'dop853', 'rk4', 'rk8']
   real(wp), parameter :: steps(n_methods) = [4.0_wp, 4.0_wp, 10.0_wp, 4.0_wp, 4.0_wp, 0.1_wp, 4.0_wp]

   !> Watches an account: the largest departure of what is kept, less all work, from its first value.
   type, extends(observer_t) :: account_t
      logical :: started = .false.
      real(wp) :: first = 0.0_wp, worst = 0.0_wp, scale = 0.0_wp
   contains
      procedure :: observe => watch_account
   end type account_t

contains

   module procedure collect_moving_fields
      testsuite = [ &
                  new_unittest("motions against the equations of Euler", explicit_motion), &
                  new_unittest("a circular orbit is the same in its own axes", both_axes), &
                  new_unittest("the work of time-dependent potentials is its power summed up", &
                  work_is_integrated_power), &
                  new_unittest("the account closes in every form, at every order", account_closes), &
                  new_unittest("orders 2, 4 and 6", orders), &
                  new_unittest("forces are weights, torques and windows of each other", forces_are_known), &
                  new_unittest("B-dot in the field of the Earth", magnetorquers)]
   end procedure collect_moving_fields

   subroutine watch_account(self, system, state, record, status)
      class(account_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      real(wp) :: rest
      rest = conserved_energy(system, state) - record%work
      if (.not. self%started) self%first = rest
      self%started = .true.
      self%worst = max(self%worst, abs(rest - self%first))
      self%scale = max(self%scale, abs(conserved_energy(system, state)), abs(record%work))
   end subroutine watch_account

   type(integrator_settings_t) function settings_of(m) result(settings)
      integer, intent(in) :: m
      settings%method = methods(m)
      settings%conserve = any(m == [3, 4, 7])
      if (m <= 2) settings%order = 8
      if (m == 2) settings%formulation = 'reduced'
   end function settings_of

   type(run_plan_t) function plan_of(m) result(plan)
      integer, intent(in) :: m
      plan = run_plan_t(time_step=steps(m), end_time=end_time)
   end function plan_of

   function name_of(m) result(name)
      integer, intent(in) :: m
      character(len=:), allocatable :: name
      character(len=1) :: digit
      write (digit, '(i1)') m
      name = trim(methods(m))//' '//digit
   end function name_of

   !> q and Ω at the end by the classical Runge-Kutta method of 15 000 steps, extrapolated from 7500, error some 1e-12;
   !> with B-dot instead of the magnet where asked for. In inertial axes.
   subroutine follow_equations(what, path, bdot, q, omega)
      integer, intent(in) :: what
      type(kepler_orbit_t), intent(in) :: path
      logical, intent(in) :: bdot
      real(wp), intent(out) :: q(4), omega(3)
      integer, parameter :: steps = 15000
      real(wp) :: y(7)
      y = end_of(steps)
      y = y + (y - end_of(steps/2))/15
      q = y(1:4)/norm2(y(1:4))
      omega = y(5:7)

   contains

      !> (q, Ω) after equal steps.
      function end_of(steps) result(y)
         integer, intent(in) :: steps
         real(wp), dimension(7) :: y, k1, k2, k3, k4
         !> Field and orbit at the start, in the middle and at the end of a step.
         real(wp), dimension(3, 3) :: first, middle, last
         type(status_t) :: status
         real(wp) :: h
         integer :: i
         call quat_from_axis_angle([1.0_wp, 1.0_wp, 1.0_wp], 40*degree, y(1:4), status)
         y(5:7) = rotating
         h = end_time/steps
         last = acting(0.0_wp)
         do i = 0, steps - 1
            first = last
            middle = acting((i + 0.5_wp)*h)
            last = acting((i + 1)*h)
            k1 = rates(first, y)
            k2 = rates(middle, y + 0.5_wp*h*k1)
            k3 = rates(middle, y + 0.5_wp*h*k2)
            k4 = rates(last, y + h*k3)
            y = y + (h/6)*(k1 + 2*k2 + 2*k3 + k4)
         end do
      end function end_of

      !> The field, its rate and the force at a time, inertial axes.
      pure function acting(t) result(a)
         real(wp), intent(in) :: t
         real(wp), parameter :: dt = 2.0_wp
         real(wp) :: a(3, 3)
         type(geomagnetic_field_t) :: field
         field%path = path
         field%epoch_angle = 0.7_wp
         a = 0.0_wp
         if (bdot .or. what /= FORCE_ALONG) a(:, 1) = field%at(t)
         if (bdot) a(:, 2) = (8*(field%at(t + dt) - field%at(t - dt)) - field%at(t + 2*dt) + field%at(t - 2*dt))/(12*dt)
         if (what /= MAGNETIC) a(:, 3) = rotate_to_space(path%axes(t), push)
      end function acting

      pure function rates(a, y) result(k)
         real(wp), intent(in) :: a(3, 3), y(7)
         real(wp) :: k(7), tau(3), b(3), u(4)
         u = y(1:4)/norm2(y(1:4))
         b = rotate_to_body(u, a(:, 1))
         if (bdot) then
            tau = -gain*cross(cross(b, y(5:7)) + rotate_to_body(u, a(:, 2)), b)
         else
            tau = cross(magnet, b)
         end if
         tau = tau + cross(point, rotate_to_body(u, a(:, 3)))
         k(1:4) = 0.5_wp*quat_product(y(1:4), [0.0_wp, y(5:7)])
         k(5:7) = (cross(moments*y(5:7), y(5:7)) + tau)/moments
      end function rates

   end subroutine follow_equations

   !> Checks the motion on an ellipse, with every kind of method.
   subroutine explicit_motion(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(account_t) :: account
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: q(4), omega(3)
      integer :: m
      problem => satellite(orbit_t(path_of(0.3_wp)), BOTH)
      call follow_equations(BOTH, path_of(0.3_wp), .false., q, omega)
      do m = 1, n_methods
         state = problem%start
         account = account_t()
         call integrate(problem%system, settings_of(m), state, plan_of(m), status, observer=account)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, state%q, q, 1e-10_wp, name_of(m)//", attitude")
         call check_close(error, angular_velocity(problem%system, state), omega, 1e-12_wp, name_of(m)//", rate")
         ! rk4 and dop853 without the projection book what they do, not what they should.
         if (m <= 4) call check_below(error, account%worst, 64*eps*account%scale, name_of(m)//", account")
      end do
   end subroutine explicit_motion

   !> Compares inertial axes with those of the orbit, where H - ω·l is conserved: the works differ by ω·Δl. The vector
   !> of FORCE_ALONG is at rest in the LVLH frame.
   subroutine both_axes(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t) :: problems(2)
      type(state_t) :: states(2)
      type(orbit_t) :: orbits(2)
      type(status_t) :: status
      real(wp) :: rate(3), work
      integer :: i
      orbits = [orbit_t(path_of(0.0_wp), inertial=.false.), orbit_t(path_of(0.0_wp))]
      problems(1) = satellite(orbits(1), MAGNETIC)
      call problems(1)%system%effects%add(force_t(point, push))
      problems(2) = satellite(orbits(2), BOTH)
      do i = 1, 2
         states(i) = problems(i)%start
         call integrate(problems(i)%system, integrator_settings_t(method='taylor', conserve=.true.), states(i), &
                        run_plan_t(goal=run_goal_t(local_tolerance=1e-15_wp), end_time=end_time), status)
         call check(error, status%ok(), trim(status%message))
      end do
      call check_close(error, states(2)%q, quat_product(orbits(2)%axes(end_time), states(1)%q), 1e-12_wp, "attitude")
      rate = orbits(2)%axes_rate(0.0_wp)
      work = dot_product(rate, space_momentum(states(2)) - space_momentum(problems(2)%start))
      call check_close(error, states(2)%time_dependent_work - states(1)%time_dependent_work, work, &
                       1e-12_wp*norm2(magnet)*3e-5_wp, "work")
   end subroutine both_axes

   !> Compares with Simpson's rule over 2000 rows of the series, on an ellipse and in the axes of a circular orbit.
   subroutine work_is_integrated_power(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: rows = 2000
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: expected, weight, scale
      integer :: i, k, m
      scale = 1e-9_wp*norm2(magnet)*3e-5_wp
      do k = 0, 1
         problem => satellite(orbit_t(path_of(0.3_wp*k)), BOTH)
         state = problem%start
         expected = 0.0_wp
         do i = 0, rows
            if (i > 0) call integrate(problem%system, integrator_settings_t(method='dop853', conserve=.true.), state, &
                                      run_plan_t(time_step=end_time/rows, end_time=i*end_time/rows), status)
            weight = 2.0_wp + 2*mod(i, 2)
            if (i == 0 .or. i == rows) weight = 1.0_wp
            expected = expected + weight*time_dependent_power(problem%system%effects, state%q, state%t)
         end do
         expected = expected*end_time/(3*rows)
         call check(error, abs(expected) > 1e3_wp*scale, "time-dependent potentials do work")
         do m = 1, n_methods
            state = problem%start
            call integrate(problem%system, settings_of(m), state, plan_of(m), status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, state%time_dependent_work, expected, scale, name_of(m))
         end do
      end do
   end subroutine work_is_integrated_power

   !> Checks the energy balance with a rotor, damping and a wheel beside the field, long steps, and a finite J0; in both
   !> axes.
   subroutine account_closes(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: solvers(2) = ['full   ', 'reduced']
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(account_t) :: account
      type(status_t) :: status
      integer :: order, form, k
      do k = 0, 1
         problem => satellite(orbit_t(path_of(0.3_wp*k)), BOTH)
         call problem%system%effects%add(rotor_t(name='rotor', momentum=[1e-4_wp, -2e-4_wp, 3e-4_wp]))
         call problem%system%effects%add(damping_t([1e-6_wp, 2e-6_wp, 3e-6_wp]))
         call add_wheel(problem%system, wheel_t(name='wheel', axis=[0.6_wp, 0.0_wp, 0.8_wp], inertia=1e-3_wp, &
                                                friction=1e-6_wp), status)
         call problem%system%effects%add(timed_force_t(name='force', body_point=point, start=500.0_wp, &
                                                       stop=2000.0_wp, moves=.true., &
                                                       force=push_along(problem%system%effects%orbit)))
         problem%start = make_state(problem%system, problem%start%q, rotating)
         problem%start%wheel_momentum(1) = 0.01_wp
         do order = 2, 8, 2
            do form = 1, 2
               state = problem%start
               account = account_t()
               call integrate(problem%system, integrator_settings_t( &
                              order=order, formulation=solvers(form), &
                              inverse_auxiliary_inertia=merge(20.0_wp, 0.0_wp, form == 1)), state, &
                              run_plan_t(time_step=20.0_wp, end_time=4000.0_wp), status, observer=account)
               call check(error, status%ok(), trim(status%message))
               call check_below(error, account%worst, 64*eps*account%scale, "account")
            end do
         end do
      end do
   end subroutine account_closes

   !> Errors of two steps, one half of the other, fall as the order says.
   subroutine orders(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: errors(2), q(4), omega(3)
      integer :: order, i
      problem => satellite(orbit_t(path_of(0.3_wp)), BOTH)
      call follow_equations(BOTH, path_of(0.3_wp), .false., q, omega)
      do order = 2, 6, 2
         do i = 1, 2
            state = problem%start
            call integrate(problem%system, integrator_settings_t(order=order, formulation='reduced'), state, &
                           run_plan_t(time_step=merge(30.0_wp, 15.0_wp, i == 1), end_time=end_time), status)
            call check(error, status%ok(), trim(status%message))
            errors(i) = norm2(state%q - q)
         end do
         call check_close(error, log(errors(1)/errors(2))/log(2.0_wp), real(order, wp), 0.4_wp, "order")
      end do
   end subroutine orders

   !> In body axes a force is a torque, at the centre of mass a weight, and a window that holds all times changes
   !> nothing but the account.
   subroutine forces_are_known(error)
      type(error_type), allocatable, intent(out) :: error
      type(orbit_t) :: orbit
      type(problem_t), pointer :: one
      type(problem_t) :: other
      type(status_t) :: status
      one => new_problem()
      orbit = orbit_t(path_of(0.3_wp))
      call make_body(diagonal(moments), one%system%body, status, mass=2.0_wp, center_of_mass=point)
      one%start = make_state(one%system, [0.8_wp, 0.0_wp, 0.6_wp, 0.0_wp], rotating)
      other = one
      call one%system%effects%add(force_t(point, push))
      call other%system%effects%add(gravity_t(other%system%body, 0.5_wp*push))
      call check_same(error, one, other, 1e-13_wp, "weight")
      call other%system%effects%add(timed_force_t(name='force', body_point=point, &
                                                  force=lvlh_vector_t(vector=push), start=-1.0_wp))
      call one%system%effects%add(force_t(point, push))
      call check_same(error, one, other, 1e-11_wp, "window")
      call one%system%effects%add(moving_force_t(point, push_along(orbit)))
      call other%system%effects%add(timed_force_t(name='force', body_point=point, force=push_along(orbit), &
                                                  moves=.true., pace=orbit%path%fastest_turn(), stop=1e9_wp))
      call check_same(error, one, other, 1e-11_wp, "moving window")
   end subroutine forces_are_known

   !> Checks that two problems have the same motion by the series.
   subroutine check_same(error, one, other, bound, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: one, other
      real(wp), intent(in) :: bound
      character(len=*), intent(in) :: label
      type(state_t) :: states(2)
      type(status_t) :: status(2)
      states = [one%start, other%start]
      call integrate(one%system, settings_of(3), states(1), plan_of(3), status(1))
      call integrate(other%system, settings_of(3), states(2), plan_of(3), status(2))
      call check(error, status(1)%ok() .and. status(2)%ok(), trim(status(1)%message)//trim(status(2)%message))
      call check_close(error, states(1)%q, states(2)%q, bound, label)
      call check(error, norm2(states(1)%q - one%start%q) > 1e-3_wp, "a motion")
   end subroutine check_same

   !> Checks magnetorquers at all times against the equations of motion; sampled, with every method the same motion, and
   !> the energy balance closes.
   subroutine magnetorquers(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(controller_t) :: controller
      type(account_t) :: account
      type(state_t) :: state, reference
      type(status_t) :: status
      real(wp) :: q(4), omega(3)
      integer :: m
      call follow_equations(MAGNETIC, path_of(0.3_wp), .true., q, omega)
      controller%name = 'controller'
      controller%law = DETUMBLING
      controller%by = BY_MAGNETORQUERS
      controller%gain = gain
      controller%follows_earth = .true.
      problem => satellite(orbit_t(path_of(0.3_wp)), MAGNETIC)
      call add_magnetorquers(earth_field_t([0.0_wp, 0.0_wp, 0.0_wp], field_along(problem%system%effects%orbit)))
      if (allocated(error)) return
      do m = 1, n_methods
         if (m == 3 .or. .not. in_turn(m + 1)) cycle
         state = problem%start
         call integrate(problem%system, settings_of(m), state, plan_of(m), status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, state%q, q, 1e-9_wp, name_of(m)//", at all times")
      end do
      controller%sample = 10.0_wp
      call add_magnetorquers(earth_field_t(magnet, field_along(problem%system%effects%orbit)))
      if (allocated(error)) return
      do m = 1, n_methods
         if (m > 1 .and. .not. in_turn(m)) cycle
         state = problem%start
         account = account_t()
         call integrate(problem%system, settings_of(m), state, plan_of(m), status, observer=account)
         call check(error, status%ok(), trim(status%message))
         if (m == 1) reference = state
         call check_close(error, state%q, reference%q, 1e-9_wp, name_of(m)//", sampled")
         if (m <= 4) call check_below(error, account%worst, 64*eps*account%scale, name_of(m)//", account")
      end do

   contains

      !> A body with a field and the controller alone.
      subroutine add_magnetorquers(field)
         class(effect_t), intent(in) :: field
         type(system_t) :: system
         system%body = problem%system%body
         call system%effects%add(problem%system%effects%orbit)
         call system%effects%add(field)
         problem%system = system
         call add_controller(problem%system, controller, status)
         call check(error, status%ok(), trim(status%message))
      end subroutine add_magnetorquers

   end subroutine magnetorquers

end submodule test_moving_fields
