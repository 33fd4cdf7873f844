!> The baselines RK4 and DOP853: their coefficients, their orders, and that they keep a stepper's promises.
submodule(suites_of_runs) test_baselines
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: make_body
   use nutate_composition, only: composition_t
   use nutate_damping, only: damping_t
   use nutate_dop853, only: dop853_t
   use nutate_order_eight, only: matrix => a, nodes => c, third => b3, fifth => e5, weights => b
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: attitude_distance
   use nutate_reduced, only: reduced_t
   use nutate_rk4, only: rk4_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_NOT_FINITE, NUTATE_OFF_BRANCH, status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use test_problems, only: body_momentum, box, bruls_top, forced_body, free_body, make_state, march, new_problem, &
      problem_t, total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> A torque that answers nothing outside of its window or to an attitude that is not a unit quaternion.
   type, extends(applied_torque_t) :: watchful_torque_t
   contains
      procedure :: torque => watchful_torque
   end type watchful_torque_t

   !> A torque that is no number.
   type, extends(applied_torque_t) :: broken_torque_t
   contains
      procedure :: torque => broken_torque
   end type broken_torque_t

contains

   module procedure collect_baselines
      testsuite = [ &
                  new_unittest("coefficients meet the order conditions", coefficients_meet_the_conditions), &
                  new_unittest("orders on free bodies", orders_on_free_bodies), &
                  new_unittest("orders on the top of Brüls", orders_on_the_top_of_bruls), &
                  new_unittest("orders under every kind of effect", orders_under_every_kind_of_effect), &
                  new_unittest("as the conserving steps of order 8", as_the_conserving_steps), &
                  new_unittest("work is the change of energy", work_is_the_change_of_energy), &
                  new_unittest("error estimate is of order 8", error_estimate_is_of_order_8), &
                  new_unittest("torques are asked within their window", torques_are_asked_within_their_window), &
                  new_unittest("the middle of the whole decides on torques", middle_of_the_whole_decides), &
                  new_unittest("momentum does not drift by the norm", momentum_does_not_drift_by_the_norm), &
                  new_unittest("a step can be undone to its error", a_step_can_be_undone), &
                  new_unittest("momentum alone as with the attitude", momentum_alone_as_with_attitude), &
                  new_unittest("runaway steps leave the state untouched", runaway_steps_leave_the_state), &
                  new_unittest("numbers that are not finite are reported", not_finite_is_reported), &
                  new_unittest("states off the constraints are refused", states_off_the_constraints_are_refused)]
   end procedure collect_baselines

   !> Σⱼaᵢⱼ = cᵢ; Σbᵢcᵢᵏ = 1/(k+1) to k = 7, for b - e5 to 4, for the weights of order 3 to 2; and
   !> Σbᵢcᵢ³aᵢⱼcⱼ³ = 1/32, of order 8, which knows a.
   subroutine coefficients_meet_the_conditions(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: of_third(3) = [nodes(1), nodes(9), nodes(12)]
      real(wp) :: inner(12)
      integer :: k
      call check_close(error, sum(matrix, 1), nodes(2:12), 1e-14_wp, "row sums")
      do k = 0, 7
         call check_close(error, sum(weights*powers(nodes, k)), 1.0_wp/(k + 1), 1e-14_wp, "order 8")
         if (k <= 4) call check_close(error, sum(fifth*powers(nodes, k)), 0.0_wp, 1e-14_wp, "order 5")
         if (k <= 2) call check_close(error, sum(third*powers(of_third, k)), 1.0_wp/(k + 1), 1e-14_wp, "order 3")
      end do
      inner(1) = 0.0_wp
      inner(2:12) = matmul(nodes(1:11)**3, matrix)
      call check_close(error, sum(weights*nodes**3*inner), 1.0_wp/32, 1e-14_wp, "a condition on a")
   end subroutine coefficients_meet_the_conditions

   !> xᵏ with 0⁰ = 1.
   pure function powers(x, k) result(power)
      real(wp), intent(in) :: x(:)
      integer, intent(in) :: k
      real(wp) :: power(size(x))
      power = 1.0_wp
      if (k > 0) power = x**k
   end function powers

   subroutine orders_on_free_bodies(error)
      type(error_type), allocatable, intent(out) :: error
      call check_orders(error, free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp]), 10.0_wp, &
                        [-0.736061364160793936_wp, -0.570786951240350733_wp, -0.299388571830790094_wp, &
                         -0.206839086104673192_wp], [200, 32], 0.3_wp)
      call check_orders(error, box(), 2.0_wp, attitude(box(), conserving(), 2.0_wp, 400), [400, 40], 0.3_wp)
   end subroutine orders_on_free_bodies

   subroutine orders_on_the_top_of_bruls(error)
      type(error_type), allocatable, intent(out) :: error
      call check_orders(error, bruls_top(), 0.2_wp, [-0.708279152974312562_wp, 0.438781088126581897_wp, &
                                                     0.545728396145417673_wp, 0.0893997528240050105_wp], [400, 40], &
                        0.3_wp)
   end subroutine orders_on_the_top_of_bruls

   subroutine orders_under_every_kind_of_effect(error)
      type(error_type), allocatable, intent(out) :: error
      call check_orders(error, forced_body(), 2.0_wp, attitude(forced_body(), conserving(), 2.0_wp, 400), [100, 16], &
                        0.7_wp)
   end subroutine orders_under_every_kind_of_effect

   !> Slope of the attitude error at time t over one halving from n steps, one n for each method: 4 ± 0.1, and 8 ± 0.3
   !> or `excess` above it: the error constant of DOP853 is so small that terms of order 9 can lead down to round-off.
   subroutine check_orders(error, problem, t, exact, n, excess)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: t, exact(4)
      integer, intent(in) :: n(2)
      real(wp), intent(in) :: excess
      real(wp), parameter :: orders(2) = [4.0_wp, 8.0_wp], below(2) = [0.1_wp, 0.3_wp]
      class(stepper_t), allocatable :: stepper
      real(wp) :: errors(2), slope, above(2)
      integer :: i, k
      above = [0.1_wp, excess]
      do i = 1, 2
         call make_baseline(i, stepper)
         do k = 1, 2
            errors(k) = attitude_distance(attitude(problem, stepper, t, k*n(i)), exact)
         end do
         call check(error, errors(1) < 1e-3_wp .and. errors(2) > 1e-12_wp, "errors are out of the range that shows")
         slope = log(errors(1)/errors(2))/log(2.0_wp)
         call check_below(error, slope, orders(i) + above(i), "order")
         call check_below(error, orders(i) - below(i), slope, "order")
      end do
   end subroutine check_orders

   !> q after n steps to time t; zero where a step fails.
   function attitude(problem, stepper, t, n) result(q)
      type(problem_t), intent(in) :: problem
      class(stepper_t), intent(in) :: stepper
      real(wp), intent(in) :: t
      integer, intent(in) :: n
      real(wp) :: q(4)
      class(stepper_t), allocatable :: own
      type(state_t) :: state
      type(status_t) :: status
      allocate (own, source=stepper)
      state = problem%start
      call own%prepare(problem%system, integrator_settings_t(), status)
      if (status%ok()) call march(problem%system, own, state, t/n, n, status)
      q = state%q
      if (.not. status%ok()) q = 0.0_wp
   end function attitude

   !> The i-th baseline.
   subroutine make_baseline(i, stepper)
      integer, intent(in) :: i
      class(stepper_t), allocatable, intent(out) :: stepper
      if (i == 1) then
         allocate (rk4_t :: stepper)
      else
         allocate (dop853_t :: stepper)
      end if
   end subroutine make_baseline

   !> The conserving scheme of order 8.
   function conserving() result(composition)
      type(composition_t) :: composition
      type(reduced_t) :: reduced
      type(status_t) :: status
      call composition%compose(reduced, 8, status)
   end function conserving

   !> Two methods that have nothing in common, where both are at round-off.
   subroutine as_the_conserving_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(composition_t) :: composition
      type(dop853_t) :: dop853
      type(state_t) :: a, b
      type(status_t) :: status
      problem => forced_body()
      composition = conserving()
      a = problem%start
      b = problem%start
      call composition%prepare(problem%system, integrator_settings_t(), status)
      call march(problem%system, composition, a, 0.005_wp, 800, status)
      call check(error, status%ok(), trim(status%message))
      call dop853%prepare(problem%system, integrator_settings_t(), status)
      call march(problem%system, dop853, b, 0.01_wp, 400, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, b%q, a%q, 1e-12_wp, "q")
      call check_close(error, b%p, a%p, 1e-12_wp*norm2(a%p), "p")
   end subroutine as_the_conserving_steps

   !> The residual of the energy balance falls with the order of the method.
   subroutine work_is_the_change_of_energy(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: n(2) = [40, 16]
      real(wp), parameter :: orders(2) = [4.0_wp, 8.0_wp]
      class(stepper_t), allocatable :: stepper
      real(wp) :: errors(2)
      integer :: i, k
      do i = 1, 2
         call make_baseline(i, stepper)
         do k = 1, 2
            errors(k) = account_error(stepper, 2.0_wp, k*n(i))
         end do
         call check(error, errors(1) < 1e-3_wp .and. errors(2) > 1e-13_wp, "errors are out of the range that shows")
         call check_below(error, orders(i) - 0.5_wp, log(errors(1)/errors(2))/log(2.0_wp), "order")
      end do
   end subroutine work_is_the_change_of_energy

   !> |ΔH - Σ work| over the largest work, after n steps to time t.
   real(wp) function account_error(stepper, t, n)
      class(stepper_t), intent(inout) :: stepper
      real(wp), intent(in) :: t
      integer, intent(in) :: n
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: work(2)
      integer :: i
      problem => forced_body()
      state = problem%start
      work = 0.0_wp
      call stepper%prepare(problem%system, integrator_settings_t(), status)
      do i = 1, n
         call stepper%step(problem%system, state, t/n, status)
         work = work + stepper%work
      end do
      account_error = abs(total_energy(problem%system, state) - total_energy(problem%system, problem%start) &
                          - sum(work))/maxval(abs(work))
   end function account_error

   !> Slope 8 ± 0.3 over a halving, and never below the error of the step it speaks of.
   subroutine error_estimate_is_of_order_8(error)
      type(error_type), allocatable, intent(out) :: error
      call check_estimate(error, box(), 0.04_wp)
      call check_estimate(error, bruls_top(), 0.004_wp)
      call check_estimate(error, forced_body(), 0.1_wp)
   end subroutine error_estimate_is_of_order_8

   subroutine check_estimate(error, problem, dt)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt
      type(dop853_t) :: dop853
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: estimates(2)
      integer :: k
      call dop853%prepare(problem%system, integrator_settings_t(), status)
      do k = 1, 2
         state = problem%start
         call dop853%step(problem%system, state, dt/k, status)
         estimates(k) = dop853%error_estimate
         call check_below(error, attitude_distance(state%q, attitude(problem, dop853, dt/k, 8)), estimates(k), "error")
      end do
      call check_close(error, log(estimates(1)/estimates(2))/log(2.0_wp), 8.0_wp, 0.3_wp, "order")
   end subroutine check_estimate

   !> The steps end next to the window, which the middle of a step decides on.
   subroutine torques_are_asked_within_their_window(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      type(watchful_torque_t) :: torque
      real(wp) :: work
      integer :: i, k
      problem => new_problem()
      torque%name = 'torque'
      torque%amplitude = [0.0_wp, 0.0_wp, 5.0_wp]
      torque%start = 0.301_wp
      torque%stop = 0.699_wp
      call make_body(reshape([4.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 5.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 6.0_wp], [3, 3]), &
                     problem%system%body, status)
      call problem%system%effects%add(torque)
      problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1.0_wp])
      do i = 1, 2
         call make_baseline(i, stepper)
         call stepper%prepare(problem%system, integrator_settings_t(), status)
         state = problem%start
         work = 0.0_wp
         do k = 1, 10
            call stepper%step(problem%system, state, 0.1_wp, status)
            call check(error, status%ok(), trim(status%message))
            work = work + stepper%work(1)
         end do
         ! A torque τ in 4 steps: L + 0.4τ, and its work ½(L1² - L0²)/J.
         call check_close(error, body_momentum(state), [0.0_wp, 0.0_wp, 8.0_wp], 40*eps, "L")
         call check_close(error, work, (8.0_wp**2 - 6.0_wp**2)/12, 40*eps, "work")
      end do
   end subroutine torques_are_asked_within_their_window

   pure function watchful_torque(self, t, q, omega) result(tau)
      class(watchful_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = self%amplitude
      if (t < self%start .or. t > self%stop .or. abs(norm2(q) - 1) > 4*eps) tau = ieee_value(tau, ieee_quiet_nan)
   end function watchful_torque

   subroutine middle_of_the_whole_decides(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      problem => box()
      call problem%system%effects%add(applied_torque_t(name='torque', amplitude=[1.0_wp, 2.0_wp, 3.0_wp], &
                                                       start=0.0_wp, stop=1.0_wp))
      do i = 1, 2
         call make_baseline(i, stepper)
         call stepper%prepare(problem%system, integrator_settings_t(), status)
         state = problem%start
         call stepper%advance(problem%system, state, 0.01_wp, 1.5_wp, status)
         call check_close(error, stepper%work, [0.0_wp], 0.0_wp, "work without the whole in the window")
         state%t = 1.5_wp
         call stepper%advance(problem%system, state, 0.01_wp, 0.5_wp, status)
         call check(error, abs(stepper%work(1)) > 0.1_wp, "no work though the whole is in the window")
      end do
   end subroutine middle_of_the_whole_decides

   !> A body that spins about a principal axis: L is constant for every method, and so it stays but for round-off.
   subroutine momentum_does_not_drift_by_the_norm(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [0.0_wp, 0.0_wp, 1.0_wp])
      do i = 1, 2
         call make_baseline(i, stepper)
         call stepper%prepare(problem%system, integrator_settings_t(), status)
         state = problem%start
         call march(problem%system, stepper, state, 0.01_wp, 20000, status)
         call check_close(error, body_momentum(state), [0.0_wp, 0.0_wp, 1.0_wp], 1e-13_wp, "L")
      end do
   end subroutine momentum_does_not_drift_by_the_norm

   !> Goes there and back: the difference is of the order of the error of going there, and far larger with a wrong sign.
   subroutine a_step_can_be_undone(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: steps(2) = [0.01_wp, 0.05_wp], tolerances(2) = [1e-7_wp, 1e-9_wp]
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      problem => forced_body()
      do i = 1, 2
         call make_baseline(i, stepper)
         call stepper%prepare(problem%system, integrator_settings_t(), status)
         state = problem%start
         call march(problem%system, stepper, state, steps(i), 40, status)
         call march(problem%system, stepper, state, -steps(i), 40, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, [state%t, state%q], [0.0_wp, problem%start%q], tolerances(i), "q")
         call check_close(error, state%p, problem%start%p, tolerances(i)*norm2(state%p), "p")
      end do
   end subroutine a_step_can_be_undone

   subroutine momentum_alone_as_with_attitude(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: a, b
      type(status_t) :: status
      integer :: i
      problem => box()
      call problem%system%effects%add(damping_t([0.1_wp, 0.2_wp, 0.3_wp]))
      do i = 1, 2
         call make_baseline(i, stepper)
         a = problem%start
         b = problem%start
         call stepper%prepare(problem%system, integrator_settings_t(), status)
         call march(problem%system, stepper, a, 0.01_wp, 300, status)
         call stepper%prepare(problem%system, integrator_settings_t(attitude=.false.), status)
         call march(problem%system, stepper, b, 0.01_wp, 300, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, body_momentum(b), body_momentum(a), 1e-11_wp*norm2(body_momentum(a)), "L")
         call check_close(error, b%q, problem%start%q, 0.0_wp, "attitude integrated all the same")
      end do
   end subroutine momentum_alone_as_with_attitude

   subroutine runaway_steps_leave_the_state(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: steps(3) = [1e2_wp, 1e10_wp, -1e100_wp]
      integer :: k
      do k = 1, size(steps)
         call check_failure(error, box(), steps(k), NUTATE_OFF_BRANCH)
         call check_failure(error, forced_body(), steps(k), NUTATE_OFF_BRANCH)
      end do
   end subroutine runaway_steps_leave_the_state

   subroutine not_finite_is_reported(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => box()
      call problem%system%effects%add(broken_torque_t(name='torque'))
      call check_failure(error, problem, 0.01_wp, NUTATE_NOT_FINITE)
   end subroutine not_finite_is_reported

   pure function broken_torque(self, t, q, omega) result(tau)
      class(broken_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = ieee_value(tau, ieee_quiet_nan)
   end function broken_torque

   subroutine states_off_the_constraints_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => box()
      problem%start%q = 1.001_wp*problem%start%q
      call check_failure(error, problem, 0.01_wp, NUTATE_BAD_ARGUMENT)
      problem => box()
      problem%start%p = problem%start%p + problem%start%q
      call check_failure(error, problem, 0.01_wp, NUTATE_BAD_ARGUMENT)
   end subroutine states_off_the_constraints_are_refused

   !> Checks that both baselines fail with a code and leave the state unchanged.
   subroutine check_failure(error, problem, dt, code)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt
      integer, intent(in) :: code
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      do i = 1, 2
         call make_baseline(i, stepper)
         call stepper%prepare(problem%system, integrator_settings_t(), status)
         state = problem%start
         call stepper%step(problem%system, state, dt, status)
         call check(error, status%code, code)
         call check_close(error, [state%t, state%q, state%p], &
                          [problem%start%t, problem%start%q, problem%start%p], 0.0_wp, "state")
      end do
   end subroutine check_failure

end submodule test_baselines
