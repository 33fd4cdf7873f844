!> Orders 4, 6 and 8 by composition: the coefficients meet their conditions, the orders are seen, the invariants stay.
submodule(suites_of_runs) test_composition
   use nutate_composition, only: compositions
   use nutate_damping, only: damping_t
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, status_t
   use test_problems, only: box, bruls_top, march, precessing_top, problem_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_composition
      testsuite = [ &
                  new_unittest("coefficients meet the order conditions", coefficients_meet_the_conditions), &
                  new_unittest("orders on the box", orders_on_the_box), &
                  new_unittest("orders on the precessing top", orders_on_the_precessing_top), &
                  new_unittest("orders on the top of Brüls", orders_on_the_top_of_bruls), &
                  new_unittest("orders with damping", orders_with_damping), &
                  new_unittest("invariants at every order and Δt|Ω| = 1", invariants_at_every_order), &
                  new_unittest("a composed step can be undone", composed_step_can_be_undone), &
                  new_unittest("a failed stage leaves the state untouched", failed_stage_leaves_the_state), &
                  new_unittest("orders without a composition are refused", other_orders_are_refused)]
   end procedure collect_composition

   !> Σγ = 1; Σγ³ = 0 from order 4, Σγ⁵ = 0 from order 6, Σγ⁷ = 0 from order 8 (the conditions of one exponent).
   subroutine coefficients_meet_the_conditions(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: i, power
      do i = 1, size(compositions)
         call check_close(error, power_sum(1), 1.0_wp, 2*eps, "sum of weights")
         do power = 3, compositions(i)%order - 1, 2
            call check_close(error, power_sum(power), 0.0_wp, 4*eps, "sum of powers")
         end do
      end do

   contains

      real(wp) function power_sum(power)
         integer, intent(in) :: power
         integer :: middle
         associate (c => compositions(i))
            middle = (c%stages + 1)/2
            power_sum = 2*sum(c%weights(1:middle - 1)**power) + c%weights(middle)**power
         end associate
      end function power_sum

   end subroutine coefficients_meet_the_conditions

   subroutine orders_on_the_box(error)
      type(error_type), allocatable, intent(out) :: error
      call check_orders(error, box(), 2.0_wp, [40, 30, 20])
   end subroutine orders_on_the_box

   subroutine orders_on_the_precessing_top(error)
      type(error_type), allocatable, intent(out) :: error
      call check_orders(error, precessing_top(), 0.5_wp, [320, 110, 80])
   end subroutine orders_on_the_precessing_top

   subroutine orders_on_the_top_of_bruls(error)
      type(error_type), allocatable, intent(out) :: error
      call check_orders(error, bruls_top(), 0.2_wp, [80, 40, 30])
   end subroutine orders_on_the_top_of_bruls

   subroutine orders_with_damping(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => bruls_top()
      call problem%system%effects%add(damping_t([0.3_wp, 0.1_wp, 0.2_wp]))
      call check_orders(error, problem, 0.2_wp, [80, 40, 30])
   end subroutine orders_with_damping

   !> Slope of the attitude error at time t over one halving from n steps, one n for each order: within 0.2 of it (0.4
   !> for order 8). The errors lie between 1e-3 and 1e-10, where neither higher orders nor round-off (1e-13) blur the
   !> slope. The reference is order 8 with 8 times the steps.
   subroutine check_orders(error, problem, t, n)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: t
      integer, intent(in) :: n(3)
      real(wp) :: reference(4), errors(2), slope
      character(len=7), parameter :: solvers(2) = ['full   ', 'reduced']
      integer :: i, k, solver
      reference = attitude(problem, 8, 'reduced', t, 8*n(3))
      do solver = 1, 2
         do i = 1, 3
            do k = 1, 2
               errors(k) = attitude_distance(attitude(problem, 2 + 2*i, solvers(solver), t, k*n(i)), reference)
            end do
            slope = log(errors(1)/errors(2))/log(2.0_wp)
            call check(error, errors(1) < 1e-3_wp .and. errors(2) > 1e-12_wp, "errors are out of the range that shows")
            call check_close(error, slope, real(2 + 2*i, wp), merge(0.4_wp, 0.2_wp, i == 3), "order")
         end do
      end do
   end subroutine check_orders

   !> q after n steps to time t; not a number where a step fails.
   function attitude(problem, order, solver, t, n) result(q)
      type(problem_t), intent(in) :: problem
      integer, intent(in) :: order, n
      character(len=*), intent(in) :: solver
      real(wp), intent(in) :: t
      real(wp) :: q(4)
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      state = problem%start
      call make_stepper(problem%system, integrator_settings_t(order=order, formulation=solver), stepper, status)
      if (status%ok()) call march(problem%system, stepper, state, t/n, n, status)
      q = state%q
      if (.not. status%ok()) q = 0.0_wp
   end function attitude

   subroutine invariants_at_every_order(error)
      type(error_type), allocatable, intent(out) :: error
      integer :: order
      do order = 4, 8, 2
         call check_invariants(error, box(), order, 0.1_wp)
         call check_invariants(error, precessing_top(), order, 0.007_wp)
      end do
   end subroutine invariants_at_every_order

   !> 200 steps.
   subroutine check_invariants(error, problem, order, dt)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      integer, intent(in) :: order
      real(wp), intent(in) :: dt
      class(stepper_t), allocatable :: stepper
      type(invariants_t) :: invariants
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      call make_stepper(problem%system, integrator_settings_t(order=order), stepper, status)
      state = problem%start
      call invariants%start(problem%system, state)
      do i = 1, 200
         call stepper%step(problem%system, state, dt, status)
         call check(error, status%ok(), trim(status%message))
         call invariants%measure(problem%system, state)
      end do
      call check_below(error, max(invariants%energy_error(), invariants%momentum_error()), 1e-12_wp, "invariants")
   end subroutine check_invariants

   subroutine composed_step_can_be_undone(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      problem => bruls_top()
      call make_stepper(problem%system, integrator_settings_t(order=6), stepper, status)
      state = problem%start
      call march(problem%system, stepper, state, 0.005_wp, 20, status)
      call march(problem%system, stepper, state, -0.005_wp, 20, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, [state%t, state%q], [0.0_wp, problem%start%q], 1e-12_wp)
   end subroutine composed_step_can_be_undone

   subroutine failed_stage_leaves_the_state(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      problem => box()
      call make_stepper(problem%system, integrator_settings_t(order=8), stepper, status)
      state = problem%start
      call stepper%step(problem%system, state, 2.0_wp, status)
      call check(error,.not. status%ok(), "stages of Δt|Ω| = 12 accepted")
      call check_close(error, [state%t, state%q, state%p], [0.0_wp, problem%start%q, problem%start%p], 0.0_wp, "state")
   end subroutine failed_stage_leaves_the_state

   subroutine other_orders_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      problem => box()
      call make_stepper(problem%system, integrator_settings_t(order=10), stepper, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
   end subroutine other_orders_are_refused

end submodule test_composition
