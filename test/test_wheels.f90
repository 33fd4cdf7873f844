!> Wheels: references to 20 digits, closed forms, the account and the momentum with every method, orders.
submodule(suites_of_effects) test_wheels
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: diagonal, make_body, whole_body
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp, long, eps
   use nutate_limits, only: most_wheels
   use nutate_methods, only: integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_rotor, only: rotor_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, status_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: angular_velocity, kinetic_energy, make_state, march, new_problem, new_system, problem_t, &
      space_momentum, system_t, total_energy, wheeled_body
   use test_resume, only: check_run, check_stepper, label_of, settings_of
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   use test_wheel_reference, only: reference_problem
   implicit none

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

contains

   module procedure collect_wheels
      testsuite = [ &
                  new_unittest("friction has the closed form", friction_has_the_closed_form), &
                  new_unittest("strong friction locks a wheel", strong_friction_locks), &
                  new_unittest("a wheel at rest in space is a lighter body", wheel_at_rest_is_a_lighter_body), &
                  new_unittest("every method closes the account", every_method_closes_the_account), &
                  new_unittest("every method keeps the momentum", every_method_keeps_the_momentum), &
                  new_unittest("the methods have their orders", methods_have_their_orders), &
                  new_unittest("both forms give one trajectory", both_forms_agree), &
                  new_unittest("what is interrupted goes on bit for bit", runs_go_on_with_wheels), &
                  new_unittest("a large momentum does no harm", large_momentum_does_no_harm), &
                  new_unittest("roots count as not certified", roots_are_not_certified), &
                  new_unittest("gravity acts on the locked body", gravity_acts_on_the_locked_body), &
                  new_unittest("wheels that cannot be are refused", bad_wheels_are_refused)]
   end procedure collect_wheels

   !> About one axis ω falls as exp(-ct(1/Jw + 1/Jr)); the motor does work, if it has to, on the rest.
   subroutine friction_has_the_closed_form(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp), parameter :: axis(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      real(wp) :: omega(3), lost
      integer :: m
      system => new_system()
      call make_body(diagonal([90.0_wp, 100.0_wp, 40.0_wp]), system%body, status)
      call add_wheel(system, wheel_t(name='wheel', axis=axis, inertia=0.05_wp, speed=200.0_wp, &
                                     friction=0.002_wp), status)
      do m = 1, size(methods)
         if (methods(m)%order < 8 .or. methods(m)%name == 'exact') cycle
         call make_stepper(system, settings_of(methods(m)), stepper, status)
         state = make_state(system, identity, 0.03_wp*axis)
         lost = kinetic_energy(system, state)
         call march(system, stepper, state, 0.5_wp, 100, status)
         call check(error, status%ok(), trim(status%message))
         omega = angular_velocity(system, state)
         lost = kinetic_energy(system, state) - lost
         call check_close(error, system%effects%wheels(1)%speed_of(state%wheel_momentum(1), omega), &
                          26.9993890409918828799_wp, 27e-11_wp, label_of(methods(m))//", speed")
         call check_close(error, omega(3), 0.2462507636987601464001_wp, 1e-12_wp, label_of(methods(m))//", rate")
         call check_close(error, state%wheel_work(:, 1), [0.0_wp, lost], 1e-11_wp*abs(lost), &
                          label_of(methods(m))//", work")
      end do
   end subroutine friction_has_the_closed_form

   !> A wheel at rest in the body, with friction beyond all: the body is what it was before the wheel was cut out of it.
   subroutine strong_friction_locks(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: loose
      type(problem_t) :: locked
      type(state_t) :: state, other
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      integer :: m
      loose => new_problem()
      call make_body(diagonal([4.0_wp, 5.0_wp, 6.0_wp]), loose%system%body, status)
      locked = loose
      call add_wheel(loose%system, wheel_t(name='wheel', axis=[0.6_wp, 0.0_wp, 0.8_wp], inertia=1.5_wp, &
                                           friction=1e9_wp), status)
      do m = 1, size(methods)
         if (methods(m)%name /= 'nielsen_krenk' .or. methods(m)%order > 2) cycle
         call make_stepper(loose%system, settings_of(methods(m)), stepper, status)
         state = make_state(loose%system, identity, [1.0_wp, -0.5_wp, 2.0_wp])
         call march(loose%system, stepper, state, 0.05_wp, 200, status)
         call check(error, status%ok(), trim(status%message))
         call make_stepper(locked%system, settings_of(methods(m)), stepper, status)
         other = make_state(locked%system, identity, [1.0_wp, -0.5_wp, 2.0_wp])
         call march(locked%system, stepper, other, 0.05_wp, 200, status)
         call check_below(error, attitude_distance(state%q, other%q), 1e-7_wp, label_of(methods(m)))
      end do
   end subroutine strong_friction_locks

   !> Without motor and friction h stays, to the last bit; h = 0 leaves a body of the inertia Jr.
   subroutine wheel_at_rest_is_a_lighter_body(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: with, lighter
      type(state_t) :: state, other
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp), parameter :: axis(3) = [0.0_wp, 1.0_wp, 0.0_wp], omega(3) = [1.0_wp, -0.5_wp, 2.0_wp]
      integer :: m
      with => new_problem()
      lighter => new_problem()
      call make_body(diagonal([4.0_wp, 5.0_wp, 6.0_wp]), with%system%body, status)
      call add_wheel(with%system, wheel_t(name='wheel', axis=axis, inertia=1.5_wp, speed=0.5_wp), status)
      call make_body(diagonal([4.0_wp, 3.5_wp, 6.0_wp]), lighter%system%body, status)
      do m = 1, size(methods)
         ! Every step with wheels is projected.
         if (methods(m)%name == 'exact' .or. (methods(m)%name == 'rk4' .and. methods(m)%projected)) cycle
         call make_stepper(with%system, settings_of(methods(m)), stepper, status)
         state = make_state(with%system, identity, omega)
         call march(with%system, stepper, state, 0.05_wp, 200, status)
         call check(error, status%ok(), trim(status%message))
         call check(error, .not. abs(state%wheel_momentum(1)) > 0.0_wp, "h has changed")
         call make_stepper(lighter%system, settings_of(methods(m)), stepper, status)
         other = make_state(lighter%system, identity, omega)
         call march(lighter%system, stepper, other, 0.05_wp, 200, status)
         ! The series of a free body is another one than that with wheels.
         call check_below(error, attitude_distance(state%q, other%q), &
                          merge(1e-10_wp, 1e-12_wp, methods(m)%name == 'taylor'), label_of(methods(m)))
      end do
   end subroutine wheel_at_rest_is_a_lighter_body

   !> H - H(0) - work, with wheels beside every kind of effect.
   subroutine every_method_closes_the_account(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      integer :: m
      problem => wheeled_body()
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. .not. methods(m)%conserving) cycle
         call check_account(error, problem, settings_of(methods(m)), label_of(methods(m)))
      end do
      call check_account(error, problem, integrator_settings_t(inverse_auxiliary_inertia=1/60.0_wp), "finite J0")
      call check_account(error, problem, integrator_settings_t(order=6, inverse_auxiliary_inertia=1/60.0_wp), &
                         "finite J0, order 6")
   end subroutine every_method_closes_the_account

   subroutine check_account(error, problem, settings, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      character(len=*), intent(in) :: label
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: work, first, size
      integer :: i
      call make_stepper(problem%system, settings, stepper, status)
      state = problem%start
      first = total_energy(problem%system, state, settings%inverse_auxiliary_inertia)
      size = abs(first) + kinetic_energy(problem%system, state)
      work = 0.0_wp
      do i = 1, 100
         call stepper%step(problem%system, state, 0.01_wp, status)
         call check(error, status%ok(), label//": "//trim(status%message))
         work = work + sum(stepper%work)
         call check_below(error, abs(total_energy(problem%system, state, settings%inverse_auxiliary_inertia) &
                                     - first - work), 64*eps*size, label//", account")
      end do
      call check(error, all(abs(state%wheel_work(:, 1) - [1.0_wp, 0.0_wp]*state%wheel_work(1, 1)) <= 0.0_wp) .and. &
                 abs(state%wheel_work(1, 1)) > 0.1_wp .and. state%wheel_work(2, 2) < -1.0_wp, label//", works")
   end subroutine check_account

   !> Motors and friction leave all of l alone.
   subroutine every_method_keeps_the_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: momentum(3)
      integer :: m
      problem => wheels_alone()
      momentum = space_momentum(problem%start)
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. .not. methods(m)%conserving) cycle
         call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
         state = problem%start
         call march(problem%system, stepper, state, 0.02_wp, 400, status)
         call check(error, status%ok(), trim(status%message))
         call check_below(error, norm2(space_momentum(state) - momentum), 64*eps*norm2(momentum), label_of(methods(m)))
      end do
   end subroutine every_method_keeps_the_momentum

   !> Two inclined wheels, one driven in turns, one with friction, in a body of three different moments.
   function wheels_alone() result(problem)
      type(problem_t), pointer :: problem
      type(wheel_t) :: wheel
      type(status_t) :: status
      problem => new_problem()
      call make_body(reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3]), &
                     problem%system%body, status)
      wheel = wheel_t(name='wheel', axis=[2.0_wp, -1.0_wp, 2.0_wp]/3, inertia=0.3_wp, speed=5.0_wp, friction=0.05_wp)
      allocate (wheel%motor, source=applied_torque_t(amplitude=[1.5_wp, 0.0_wp, 0.0_wp], frequency=0.3_wp))
      call add_wheel(problem%system, wheel, status)
      call add_wheel(problem%system, wheel_t(name='wheel', axis=[0.0_wp, 0.6_wp, 0.8_wp], inertia=0.2_wp, &
                                             speed=-20.0_wp, friction=0.15_wp), status)
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [1.0_wp, -0.5_wp, 1.5_wp])
   end function wheels_alone

   !> Errors at two steps against the series at a tenth of them.
   subroutine methods_have_their_orders(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: wanted, state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: steps(2), errors(2), order
      integer :: m, k
      problem => wheels_alone()
      call make_stepper(problem%system, integrator_settings_t(method='taylor', formulation='', order=16, &
                                                               conserve=.true.), stepper, status)
      wanted = problem%start
      call march(problem%system, stepper, wanted, 0.01_wp, 320, status)
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. methods(m)%name == 'taylor') cycle
         steps = [0.02_wp, 0.01_wp]
         if (methods(m)%order > 2) steps = 2**(methods(m)%order/2)*steps
         do k = 1, 2
            call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
            state = problem%start
            call march(problem%system, stepper, state, steps(k), nint(3.2_wp/steps(k)), status)
            call check(error, status%ok(), trim(status%message))
            errors(k) = attitude_distance(state%q, wanted%q) &
                        + norm2(state%wheel_momentum - wanted%wheel_momentum)/norm2(wanted%wheel_momentum)
         end do
         order = log(errors(1)/errors(2))/log(2.0_wp)
         call check(error, abs(order - methods(m)%order) < 0.5_wp, label_of(methods(m)))
      end do
   end subroutine methods_have_their_orders

   !> The eight equations and the three are those of one step.
   subroutine both_forms_agree(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state, other
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      problem => wheeled_body()
      call make_stepper(problem%system, integrator_settings_t(), stepper, status)
      state = problem%start
      call march(problem%system, stepper, state, 0.01_wp, 200, status)
      call make_stepper(problem%system, integrator_settings_t(formulation='reduced'), stepper, status)
      other = problem%start
      call march(problem%system, stepper, other, 0.01_wp, 200, status)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, attitude_distance(state%q, other%q), 1e-12_wp, "attitude")
      call check_close(error, state%wheel_momentum, other%wheel_momentum, 1e-12_wp, "momenta")
   end subroutine both_forms_agree

   !> Everything together, with a wheel that its motor drives from and to times inside of steps, and one that friction
   !> stops; steppers, and runs with fixed steps and with adaptive steps.
   subroutine runs_go_on_with_wheels(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t), parameter :: controlled = run_plan_t(goal=run_goal_t(local_tolerance=1e-9_wp), &
                                                             end_time=0.4_wp)
      type(problem_t), pointer :: problem
      integer :: m
      problem => wheeled_body()
      do m = 1, size(methods)
         if (methods(m)%name == 'exact') cycle
         call check_stepper(error, problem, settings_of(methods(m)), [0.01_wp, 0.01_wp, 50.0_wp, 0.01_wp, 0.02_wp], &
                            [0.02_wp, 0.02_wp, 0.015_wp, 0.015_wp], label_of(methods(m)))
         call check_run(error, problem, settings_of(methods(m)), run_plan_t(time_step=0.01_wp, end_time=0.403_wp, &
                        every=3_long), [1, 5, 10, 11, 25, 26, 39], label_of(methods(m)))
         call check_run(error, problem, settings_of(methods(m)), controlled, [1, 2], label_of(methods(m)))
      end do
   end subroutine runs_go_on_with_wheels

   !> A wheel that holds 1e6 times the momentum of the body, alone and with a rotor that stands against it.
   subroutine large_momentum_does_no_harm(error)
      type(error_type), allocatable, intent(out) :: error
      call try_large_momentum(error, 0.0_wp)
      if (.not. allocated(error)) call try_large_momentum(error, -1e6_wp)
   end subroutine large_momentum_does_no_harm

   subroutine try_large_momentum(error, against)
      type(error_type), allocatable, intent(inout) :: error
      !> Momentum of the rotor along the axis, N m s.
      real(wp), intent(in) :: against
      type(system_t), pointer :: system
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp), parameter :: axis(3) = [0.36_wp, 0.48_wp, 0.8_wp]
      real(wp) :: momentum(3), energy
      system => new_system()
      call make_body(diagonal([4.0_wp, 5.0_wp, 6.0_wp]), system%body, status)
      call add_wheel(system, wheel_t(name='wheel', axis=axis, inertia=0.1_wp, speed=1e7_wp), status)
      call system%effects%add(rotor_t(name='rotor', momentum=against*axis))
      call make_stepper(system, integrator_settings_t(formulation='reduced'), stepper, status)
      state = make_state(system, identity, [0.1_wp, -0.2_wp, 0.3_wp])
      momentum = space_momentum(state)
      energy = kinetic_energy(system, state)
      call march(system, stepper, state, 1e-5_wp, 200, status)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, norm2(space_momentum(state) - momentum), 256*eps*1e6_wp, "momentum")
      call check_below(error, abs(kinetic_energy(system, state) - energy), 64*eps*energy, "energy")
   end subroutine try_large_momentum

   !> No proof has been derived: no root is taken as certified, in either form and by no short step.
   subroutine roots_are_not_certified(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      integer :: m, i
      problem => reference_problem()
      do m = 1, size(methods)
         if (methods(m)%name /= 'nielsen_krenk') cycle
         call make_stepper(problem%system, settings_of(methods(m)), stepper, status)
         state = problem%start
         do i = 1, 3
            call stepper%step(problem%system, state, 1e-3_wp, status)
            call check(error, stepper%uncertified, methods(m)%stages, label_of(methods(m)))
         end do
      end do
   end subroutine roots_are_not_certified

   !> The gradient is that of the body with its wheel locked, whichever was there first.
   subroutine gravity_acts_on_the_locked_body(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: before
      type(system_t) :: after
      type(status_t) :: status
      type(wheel_t) :: wheel
      real(wp), parameter :: nadir(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      before => new_system()
      wheel = wheel_t(name='wheel', axis=[0.6_wp, 0.0_wp, 0.8_wp], inertia=1.5_wp)
      call make_body(diagonal([4.0_wp, 5.0_wp, 6.0_wp]), before%body, status)
      after = before
      call before%effects%add(gravity_gradient_t(before%body, nadir, 0.4_wp))
      call add_wheel(before, wheel, status)
      call add_wheel(after, wheel, status)
      call after%effects%add(gravity_gradient_t(whole_body(after%body), nadir, 0.4_wp))
      call check(error, all(abs(before%effects%potentials(1)%item%gradient(nadir) - &
                                after%effects%potentials(1)%item%gradient(nadir)) <= 0.0_wp), "gradients")
      call check_close(error, after%body%inertia(:, 3), [-0.72_wp, 0.0_wp, 5.04_wp], 8*eps, "what turns")
   end subroutine gravity_acts_on_the_locked_body

   !> Checks that invalid wheels leave the system unchanged.
   subroutine bad_wheels_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp), parameter :: axis(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      integer :: i
      system => new_system()
      call make_body(diagonal([4.0_wp, 5.0_wp, 6.0_wp]), system%body, status)
      call add_wheel(system, wheel_t(name='wheel', axis=axis, inertia=6.0_wp), status)
      call check(error, status%code, NUTATE_BAD_BODY, "all of the inertia")
      if (.not. allocated(error)) call refuse(wheel_t(axis=axis, inertia=0.0_wp), "no inertia")
      if (.not. allocated(error)) call refuse(wheel_t(axis=2*axis, inertia=1.0_wp), "no unit vector")
      if (.not. allocated(error)) call refuse(wheel_t(axis=axis, inertia=1.0_wp, friction=-1.0_wp), "it drives")
      if (.not. allocated(error)) call refuse(wheel_t(axis=axis, inertia=1.0_wp, speed=1e99_wp), "too fast")
      do i = 1, most_wheels
         if (allocated(error)) return
         call add_wheel(system, wheel_t(axis=axis, inertia=0.5_wp), status)
         call check(error, status%ok(), "one of as many as there may be")
      end do
      if (.not. allocated(error)) call refuse(wheel_t(axis=axis, inertia=0.5_wp), "one too many")
      if (allocated(error)) return
      call system%effects%add(wheel_t(axis=axis, inertia=0.5_wp))
      call make_stepper(system, integrator_settings_t(), stepper, status)
      call check(error, status%code, NUTATE_BAD_BODY, "wheels that are not mounted")

   contains

      subroutine refuse(wheel, label)
         type(wheel_t), intent(in) :: wheel
         character(len=*), intent(in) :: label
         integer :: before
         before = system%effects%n_wheels
         call add_wheel(system, wheel, status)
         call check(error, status%code, NUTATE_BAD_ARGUMENT, label)
         call check(error, system%effects%n_wheels, before, label//", number")
      end subroutine refuse

   end subroutine bad_wheels_are_refused

end submodule test_wheels
