!> Works that err more than the state take their part of the difference between the two; the account stays what it is.
submodule(suites_of_effects) test_error_weighting
   use nutate, only: read_scene, scene_t
   use nutate_damping, only: damping_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, stepper_t
   use nutate_projection_point, only: evaluate, projection_plan_t, projection_point_t, read_point
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_error_weighting, only: balance_momentum, share_of_works, step_error_t
   use test_problems, only: box, forced_body, new_problem, problem_t, total_energy, wheeled_body
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   character(len=6), parameter :: methods(3) = ['dop853', 'rk8   ', 'rk4   ']
   !> Times in the second half of a run at which its error is taken: at one of them it may be small by accident.
   integer, parameter :: samples = 10

contains

   module procedure collect_error_weighting
      testsuite = [ &
                  new_unittest("works that err most do not spoil the state", works_do_not_spoil_the_state), &
                  new_unittest("a state that errs most is corrected in full", state_is_corrected), &
                  new_unittest("a weak torque does not spoil an unstable axis", unstable_axis_is_followed), &
                  new_unittest("the account of the momentum, blended", momentum_is_blended), &
                  new_unittest("works and energy close, effect by effect", works_close), &
                  new_unittest("what did no work is given none", idle_effects_are_given_none), &
                  new_unittest("a state inside a step has the works of that step", inside_agrees_with_the_end), &
                  new_unittest("the share in any unit of energy", share_has_no_unit)]
   end procedure collect_error_weighting

   !> Geometric mean of the attitude errors of a run of n steps, over ten times of its second half.
   subroutine find_error(problem, method, conserve, end_time, n, error)
      type(problem_t), intent(in) :: problem
      character(len=*), intent(in) :: method
      logical, intent(in) :: conserve
      real(wp), intent(in) :: end_time
      integer, intent(in) :: n
      !> rad; huge where a run failed.
      real(wp), intent(out) :: error
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: settings
      type(state_t) :: state, exact
      type(run_plan_t) :: plan, fine
      type(status_t) :: status, fine_status
      integer :: k
      settings = default_settings(method)
      settings%conserve = conserve
      call make_stepper(problem%system, settings, stepper, status)
      state = problem%start
      exact = problem%start
      fine%goal%local_tolerance = 1e-14_wp
      error = 0.0_wp
      do k = 1, 2*samples
         plan = run_plan_t(time_step=end_time/n, end_time=end_time*k/(2*samples), every=huge(plan%every))
         fine%end_time = plan%end_time
         if (status%ok()) call integrate(problem%system, stepper, state, plan, status)
         call integrate(problem%system, default_settings('taylor'), exact, fine, fine_status)
         if (k > samples) error = error + log(max(eps, attitude_distance(state%q, exact%q)))/samples
      end do
      error = exp(error)
      if (.not. (status%ok() .and. fine_status%ok())) error = huge(error)
   end subroutine find_error

   !> All effects together, at three long steps: off by no more than without the projection, where the works as they
   !> come from their quadrature make it 1.2 to 3.5 times that.
   subroutine works_do_not_spoil_the_state(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: steps(3) = [120, 160, 200]
      class(scene_t), allocatable :: scene
      type(problem_t), pointer :: problem
      type(status_t) :: status
      character(len=:), allocatable :: message
      real(wp) :: bare, conserving
      integer :: i, k
      problem => new_problem()
      allocate (scene)
      call read_scene('scenes/all_effects.nml', scene, status, message)
      call check(error, status%ok(), message)
      problem%system = scene%system
      problem%start = scene%initial
      do k = 1, 2
         do i = 1, size(steps)
            if (allocated(error)) return
            call find_error(problem, trim(methods(k)), .false., 20.0_wp, steps(i), bare)
            call find_error(problem, trim(methods(k)), .true., 20.0_wp, steps(i), conserving)
            call check_below(error, conserving, bare, methods(k))
         end do
      end do
   end subroutine works_do_not_spoil_the_state

   !> Damping that takes 3e-5 of the energy of the box in a step: of the difference between energy and account the work
   !> takes a thousandth at most, and the state the rest.
   subroutine state_is_corrected(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: dt = 0.08_wp
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper, plain
      type(integrator_settings_t) :: settings
      type(state_t) :: state, other
      type(status_t) :: status
      real(wp) :: first, excess
      integer :: k
      problem => box()
      call problem%system%effects%add(damping_t([1e-3_wp, 3e-3_wp, 4e-3_wp]))
      first = total_energy(problem%system, problem%start)
      do k = 1, size(methods)
         settings = default_settings(trim(methods(k)))
         settings%conserve = .false.
         call make_stepper(problem%system, settings, plain, status)
         settings%conserve = .true.
         call make_stepper(problem%system, settings, stepper, status)
         state = problem%start
         other = problem%start
         call plain%step(problem%system, other, dt, status)
         call stepper%step(problem%system, state, dt, status)
         call check(error, status%ok(), status%message)
         excess = total_energy(problem%system, other) - first - sum(plain%work)
         call check_below(error, abs(sum(stepper%work) - sum(plain%work)), 1e-3_wp*abs(excess), methods(k))
         call check_close(error, total_energy(problem%system, state) - first, sum(stepper%work), 16*eps*first, &
                          methods(k))
      end do
   end subroutine state_is_corrected

   !> The box on its unstable axis with a little damping: as without it, the projection divides the error by five.
   !> With the energy alone it multiplies it by forty, since no component of the momentum is conserved.
   subroutine unstable_axis_is_followed(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: steps(3) = [320, 320, 640]
      type(problem_t), pointer :: problem
      real(wp) :: bare, conserving
      integer :: k
      problem => box()
      call problem%system%effects%add(damping_t([1e-3_wp, 3e-3_wp, 4e-3_wp]))
      do k = 1, size(methods)
         call find_error(problem, trim(methods(k)), .false., 20.0_wp, steps(k), bare)
         call find_error(problem, trim(methods(k)), .true., 20.0_wp, steps(k), conserving)
         call check_below(error, conserving, bare/merge(2, 5, k == 3), methods(k))
      end do
   end subroutine unstable_axis_is_followed

   !> Half way between two momenta that err alike, at the better one of two that do not, and where it is for round-off.
   subroutine momentum_is_blended(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: first(3) = [1.0_wp, 2.0_wp, -1.0_wp], difference(3) = [1e-6_wp, 0.0_wp, -1e-6_wp], &
                             off(3) = [1e-7_wp, 1e-7_wp, 0.0_wp]
      type(step_error_t) :: step
      real(wp) :: momentum(3)
      step%balances = .true.
      step%balance = difference
      step%momentum = off
      step%of_balance = -off
      momentum = first
      call balance_momentum(step, 32*eps, momentum)
      call check_close(error, momentum, first + 0.5_wp*difference, 4*eps, 'alike')
      call check_close(error, step%momentum, 0.0_wp*off, eps*1e-6_wp, 'what is left')
      step%momentum = off
      step%of_balance = 0.0_wp
      momentum = first
      call balance_momentum(step, 32*eps, momentum)
      call check_close(error, momentum, first + difference, 4*eps, 'the account')
      step%momentum = off
      step%balance = 16*eps*first
      momentum = first
      call balance_momentum(step, 32*eps, momentum)
      call check_close(error, momentum, first, 0.0_wp, 'round-off')
   end subroutine momentum_is_blended

   !> Damping, a torque, a driven wheel and one with friction: at long steps the works add up to what the energy gains,
   !> and those that the state has of the wheels are those of the run.
   subroutine works_close(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: settings
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: size_of_energy
      integer :: k
      problem => wheeled_body()
      size_of_energy = abs(total_energy(problem%system, problem%start))
      do k = 1, size(methods)
         settings = default_settings(trim(methods(k)))
         settings%conserve = .true.
         call make_stepper(problem%system, settings, stepper, status)
         state = problem%start
         call integrate(problem%system, stepper, state, run_plan_t(time_step=0.04_wp, end_time=4.0_wp), status, &
                        summary=summary)
         call check(error, status%ok(), status%message)
         call check_close(error, sum(summary%work), total_energy(problem%system, state) - total_energy(problem%system, &
                          problem%start), 100*eps*size_of_energy, methods(k))
         call check_close(error, summary%work(3:6), [state%wheel_work(:, 1), state%wheel_work(:, 2)], &
                          100*eps*size_of_energy, methods(k)//' wheels')
      end do
   end subroutine works_close

   !> In steps before the motor starts its work is exactly nothing, while damping and torque are given their shares.
   subroutine idle_effects_are_given_none(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper, plain
      type(integrator_settings_t) :: settings
      type(state_t) :: state, other
      type(status_t) :: status
      integer :: k
      problem => wheeled_body()
      do k = 1, size(methods)
         settings = default_settings(trim(methods(k)))
         settings%conserve = .false.
         call make_stepper(problem%system, settings, plain, status)
         settings%conserve = .true.
         call make_stepper(problem%system, settings, stepper, status)
         state = problem%start
         other = problem%start
         call plain%step(problem%system, other, 0.1_wp, status)
         call stepper%step(problem%system, state, 0.1_wp, status)
         call check(error, status%ok(), status%message)
         call check_close(error, stepper%work(3:4), [0.0_wp, 0.0_wp], 0.0_wp, methods(k))
         call check(error, all(abs(stepper%work([1, 2, 6]) - plain%work([1, 2, 6])) > 0.0_wp), &
                    methods(k)//' takes none')
      end do
   end subroutine idle_effects_are_given_none

   !> Checks that `state_at` at the end of the last step is that end, and its work that of the step.
   subroutine inside_agrees_with_the_end(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: dt = 0.2_wp
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: settings
      type(state_t) :: state, inside
      type(status_t) :: status
      real(wp) :: work
      integer :: k
      problem => forced_body()
      do k = 1, size(methods)
         settings = default_settings(trim(methods(k)))
         settings%conserve = .true.
         call make_stepper(problem%system, settings, stepper, status)
         call stepper%keep_steps()
         state = problem%start
         call stepper%step(problem%system, state, dt, status)
         if (status%ok()) call stepper%state_at(problem%system, dt, inside, work, status)
         call check(error, status%ok(), status%message)
         call check_close(error, inside%q, state%q, 4*eps, methods(k))
         call check_close(error, work, sum(stepper%work), 100*eps, methods(k)//' work')
      end do
   end subroutine inside_agrees_with_the_end

   !> Between 0 and 1; all for works that alone err, nothing where nothing is known.
   subroutine share_has_no_unit(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(projection_plan_t) :: plan
      type(projection_point_t) :: point
      type(step_error_t) :: step
      real(wp) :: share
      problem => forced_body()
      call plan%prepare(problem%system, .true.)
      call read_point(plan, problem%system%effects, problem%start, point)
      call evaluate(plan, problem%system%effects, point)
      call check_close(error, share_of_works(plan, point, step, 0.0_wp, 1.0_wp, 0.0_wp), 0.0_wp, 0.0_wp, 'nothing')
      step%work = 1e-9_wp
      call check_close(error, share_of_works(plan, point, step, 0.0_wp, 1.0_wp, 0.0_wp), 1.0_wp, 0.0_wp, 'works')
      step%momentum = [1e-9_wp, -2e-9_wp, 1e-9_wp]
      step%rotation = [3e-10_wp, 1e-10_wp, -2e-10_wp]
      share = share_of_works(plan, point, step, 0.0_wp, 1.0_wp, 0.0_wp)
      call check(error, share > 0.01_wp .and. share < 0.99_wp, 'both')
      call check_close(error, share_of_works(plan, point, step, 0.0_wp, 2.0_wp**(-40), 0.0_wp), share, 0.0_wp, 'unit')
      call check_close(error, share_of_works(plan, point, step, 0.0_wp, 1.0_wp, 1e-7_wp), 0.0_wp, 0.0_wp, 'beyond both')
      step%work = 0.0_wp
      call check_close(error, share_of_works(plan, point, step, 0.0_wp, 1.0_wp, 0.0_wp), 0.0_wp, 0.0_wp, 'state')
   end subroutine share_has_no_unit

end submodule test_error_weighting
