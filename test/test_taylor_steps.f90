!> Steps of the Taylor series, of one length each: its order, its states inside, what it does not do.
submodule(suites_of_methods) test_taylor_steps
   use nutate_damping, only: damping_t
   use nutate_dop853, only: dop853_t
   use nutate_effect, only: potential_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_power_series, only: highest_order
   use nutate_rotor, only: rotor_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_OFF_BRANCH
   use nutate_taylor_stepper, only: taylor_t
   use test_problems, only: body_momentum, box, bruls_top, fast_top, forced_body, free_body, march, problem_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> A user's potential, U = |γ|² z: without series.
   type, extends(potential_t) :: own_potential_t
   contains
      procedure :: energy => own_energy
      procedure :: gradient => own_gradient
   end type own_potential_t

contains

   module procedure collect_taylor_steps
      testsuite = [ &
                  new_unittest("agrees with dop853 where every kind of effect acts", agrees_with_all_effects), &
                  new_unittest("the order of the series is the order of the error", order_of_fixed_steps), &
                  new_unittest("states inside a step are those of a step that ends there", states_inside_a_step), &
                  new_unittest("equations of a top are those of any body", top_as_any_body), &
                  new_unittest("the attitude may be left out", without_attitude), &
                  new_unittest("a rotor turns a body without momentum", rotor_without_momentum), &
                  new_unittest("refuses effects without series, and orders there are not", refusals), &
                  new_unittest("a step far too long fails and leaves the state", step_too_long)]
   end procedure collect_taylor_steps

   pure real(wp) function own_energy(self, gamma)
      class(own_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      own_energy = gamma(3)
   end function own_energy

   pure function own_gradient(self, gamma) result(gradient)
      class(own_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = [0.0_wp, 0.0_wp, 1.0_wp]
   end function own_gradient

   !> Attitude, momentum and the work of each torque, at fixed steps.
   subroutine agrees_with_all_effects(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(dop853_t) :: dop853
      class(stepper_t), allocatable :: taylor
      type(state_t) :: a, b
      type(status_t) :: status
      real(wp) :: work_a(2), work_b(2)
      integer :: i
      problem => forced_body()
      call make_stepper(problem%system, default_settings('taylor'), taylor, status)
      call dop853%prepare(problem%system, integrator_settings_t(), status)
      a = problem%start
      b = problem%start
      work_a = 0.0_wp
      work_b = 0.0_wp
      do i = 1, 20
         call taylor%step(problem%system, a, 0.05_wp, status)
         work_a = work_a + taylor%work
      end do
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      do i = 1, 1000
         call dop853%step(problem%system, b, 0.001_wp, status)
         work_b = work_b + dop853%work
      end do
      call check_below(error, attitude_distance(a%q, b%q), 2e-13_wp, 'attitude')
      call check_close(error, body_momentum(a), body_momentum(b), 2e-12_wp, 'momentum')
      call check_close(error, work_a, work_b, 2e-12_wp, 'work')
   end subroutine agrees_with_all_effects

   !> Halved steps divide the error by 2 to the order, where every kind of effect acts.
   subroutine order_of_fixed_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      type(state_t) :: exact, state
      type(status_t) :: status
      real(wp) :: errors(2)
      integer :: order, k
      character(len=16) :: label
      problem => forced_body()
      settings = default_settings('taylor')
      call solve(problem, settings, 60, exact, status)
      settings%conserve = .false.
      do order = 4, 10
         settings%series_order = order
         do k = 1, 2
            call solve(problem, settings, merge(30, 12, order < 8)*2**(k - 1), state, status)
            errors(k) = attitude_distance(state%q, exact%q)
         end do
         write (label, '("order ",i0)') order
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         call check_close(error, log(errors(1)/errors(2))/log(2.0_wp), real(order, wp), 0.4_wp, trim(label))
      end do
   end subroutine order_of_fixed_steps

   !> One second in `n` steps.
   subroutine solve(problem, settings, n, state, status)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      integer, intent(in) :: n
      type(state_t), intent(out) :: state
      type(status_t), intent(out) :: status
      class(stepper_t), allocatable :: stepper
      state = problem%start
      call make_stepper(problem%system, settings, stepper, status)
      if (status%ok()) call march(problem%system, stepper, state, 1.0_wp/n, n, status)
   end subroutine solve

   !> Look inside one step of all kinds of effects, forwards and backwards.
   subroutine states_inside_a_step(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(taylor_t) :: whole, part
      type(state_t) :: at_end, inside, expected
      type(status_t) :: status
      real(wp) :: dt, work
      integer :: i
      problem => forced_body()
      do i = 1, 2
         dt = merge(0.06_wp, -0.06_wp, i == 1)
         call whole%prepare(problem%system, default_settings('taylor'), status)
         call part%prepare(problem%system, default_settings('taylor'), status)
         at_end = problem%start
         call whole%step(problem%system, at_end, dt, status)
         inside = at_end
         call whole%state_at(problem%system, problem%start%t + 0.37_wp*dt, inside, work, status)
         expected = problem%start
         call part%step(problem%system, expected, 0.37_wp*dt, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, [inside%t, inside%q], [expected%t, expected%q], 16*eps, 'attitude')
         call check_close(error, inside%p, expected%p, 32*eps*norm2(expected%p), 'momentum')
         call check_close(error, work, sum(part%work), 64*eps, 'work')
         inside = at_end
         call whole%step(problem%system, at_end, dt, status)
         call whole%prepare(problem%system, default_settings('taylor'), status)
         call whole%step(problem%system, inside, dt, status)
         call check_close(error, at_end%q, inside%q, 16*eps, 'the look moved the run')
      end do
   end subroutine states_inside_a_step

   !> A rotor that is next to nothing takes a top to the equations of any body.
   subroutine top_as_any_body(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: top
      type(problem_t) :: body
      type(state_t) :: a, b
      type(status_t) :: status
      top => fast_top()
      body = top
      call body%system%effects%add(rotor_t(name='rotor', momentum=[0.0_wp, 1e-100_wp, 0.0_wp]))
      call solve(top, default_settings('taylor'), 200, a, status)
      call solve(body, default_settings('taylor'), 200, b, status)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, attitude_distance(a%q, b%q), 1e-12_wp, 'attitude')
      call check_close(error, body_momentum(a), body_momentum(b), 1e-12_wp*norm2(body_momentum(a)), 'momentum')
   end subroutine top_as_any_body

   subroutine without_attitude(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      type(state_t) :: a, b
      type(status_t) :: status
      integer :: i
      do i = 1, 2
         problem => box()
         if (i == 2) call problem%system%effects%add(damping_t([0.1_wp, 0.2_wp, 0.3_wp]))
         settings = default_settings('taylor')
         call solve(problem, settings, 50, a, status)
         settings%attitude = .false.
         call solve(problem, settings, 50, b, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, body_momentum(b), body_momentum(a), 1e-12_wp*norm2(body_momentum(a)), 'momentum')
         call check_close(error, b%q, problem%start%q, 0.0_wp, 'attitude')
      end do
   end subroutine without_attitude

   !> L = JΩ + h = 0: the rotor keeps the body rotating, with nothing to tell the attitude by but itself.
   subroutine rotor_without_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(dop853_t) :: dop853
      type(state_t) :: a, b
      type(status_t) :: status
      problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call problem%system%effects%add(rotor_t(name='rotor', momentum=[0.5_wp, -0.7_wp, 0.3_wp]))
      call solve(problem, default_settings('taylor'), 10, a, status)
      b = problem%start
      call dop853%prepare(problem%system, integrator_settings_t(), status)
      call march(problem%system, dop853, b, 0.01_wp, 100, status)
      call check_below(error, 0.5_wp, attitude_distance(a%q, problem%start%q), 'it does not turn')
      call check_below(error, attitude_distance(a%q, b%q), 1e-13_wp, 'attitude')
   end subroutine rotor_without_momentum

   subroutine refusals(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      problem => bruls_top()
      call problem%system%effects%add(own_potential_t(name='whirl'))
      settings = default_settings('taylor')
      call make_stepper(problem%system, settings, stepper, status)
      call check(error, status%code == NUTATE_BAD_ARGUMENT .and. index(status%message, "'whirl'") > 0 .and. &
                 index(status%message, 'dop853') > 0, trim(status%message))
      problem => bruls_top()
      settings%series_order = highest_order + 1
      call make_stepper(problem%system, settings, stepper, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      call check(error, trim(status%subject), 'series_order')
   end subroutine refusals

   subroutine step_too_long(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      problem => bruls_top()
      call make_stepper(problem%system, default_settings('taylor'), stepper, status)
      state = problem%start
      call stepper%step(problem%system, state, 1e3_wp, status)
      call check(error, status%code, NUTATE_OFF_BRANCH)
      call check_close(error, [state%t, state%q, state%p], [0.0_wp, problem%start%q, problem%start%p], 0.0_wp)
   end subroutine step_too_long

end submodule test_taylor_steps
