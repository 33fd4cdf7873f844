!> Tops in space axes that turn, by their series: the equations of motion, the order, few steps, invariants; and by the
!> conserving step.
submodule(suites_of_runs) test_rotating_tops
   use nutate_body, only: diagonal, make_body
   use nutate_dipole, only: dipole_t
   use nutate_dop853, only: dop853_t
   use nutate_gravity, only: gravity_t
   use nutate_invariants, only: follows_rotating_axes
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, stepper_t
   use nutate_rotor, only: rotor_t
   use nutate_summary, only: run_summary_t
   use nutate_quaternion, only: attitude_distance, quat_exp, quat_product
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_controlled_run, only: recorder_t, run_to
   use test_problems, only: body_momentum, bruls_top, conserved_energy, kinetic_energy, make_state, march, &
      new_problem, problem_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> A rate that lies along nothing else, rad/s.
   real(wp), parameter :: inclined(3) = [0.8_wp, -1.4_wp, 1.1_wp]

contains

   module procedure collect_rotating_tops
      testsuite = [ &
                  new_unittest("which effects know that the axes turn", which_effects_know), &
                  new_unittest("symmetric tops about each axis, and others, as by dop853", agree_with_dop853), &
                  new_unittest("a rate along the field, nearly so, and against it", rates_along_the_field), &
                  new_unittest("halved steps divide the error as the order says", orders), &
                  new_unittest("conserving steps in one field and in two", conserving_steps), &
                  new_unittest("a fast top takes few steps, and keeps H - omega.l", few_steps), &
                  new_unittest("a rate that is all but zero turns nothing", tiny_rates)]
   end procedure collect_rotating_tops

   !> Rates whose length, or its square, is no number but zero, along the field and beside it.
   subroutine tiny_rates(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: down(3) = [2.0_wp, 1.0_wp, -9.0_wp], sizes(3) = [1e-120_wp, 1e-200_wp, 1e-300_wp]
      character(len=*), parameter :: methods(4) = [character(len=13) :: 'taylor', 'dop853', 'rk8', 'nielsen_krenk']
      class(stepper_t), allocatable :: stepper
      type(problem_t), pointer :: problem
      type(state_t) :: state, still
      type(status_t) :: status
      integer :: i, k, way
      do k = 1, size(methods)
         problem => top(0, 0.0_wp*down)
         still = problem%start
         call make_stepper(problem%system, default_settings(trim(methods(k))), stepper, status)
         if (status%ok()) call march(problem%system, stepper, still, 0.01_wp, 20, status)
         do i = 1, size(sizes)
            do way = 1, 2
               problem => top(0, sizes(i)*merge(down, inclined, way == 1))
               state = problem%start
               if (status%ok()) call make_stepper(problem%system, default_settings(trim(methods(k))), stepper, status)
               if (status%ok()) call march(problem%system, stepper, state, 0.01_wp, 20, status)
               call check(error, status%ok(), trim(methods(k))//': '//trim(status%message))
               call check_below(error, attitude_distance(state%q, still%q), 100*eps, trim(methods(k)))
            end do
         end do
      end do
   end subroutine tiny_rates

   !> A top whose centre of mass lies on a body axis, in axes that turn at a rate; of axis 0 no moments are equal.
   function top(axis, rate) result(problem)
      integer, intent(in) :: axis
      real(wp), intent(in) :: rate(3)
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: moments(3), along(3)
      problem => new_problem()
      moments = [2.0_wp, 2.6_wp, 1.5_wp]
      along = [0.1_wp, -0.3_wp, 0.5_wp]
      if (axis > 0) then
         along = merge(1.0_wp, 0.0_wp, [1, 2, 3] == axis)
         moments = 2.0_wp - 0.9_wp*along
      end if
      call make_body(diagonal(moments), problem%system%body, status, mass=1.0_wp, center_of_mass=0.7_wp*along)
      call problem%system%effects%add(gravity_t(problem%system%body, [2.0_wp, 1.0_wp, -9.0_wp]))
      if (axis > 0) call problem%system%effects%add(rotor_t(name='rotor', momentum=0.6_wp*along))
      if (any(abs(rate) > 0.0_wp)) call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=rate))
      problem%start = make_state(problem%system, quat_exp([0.3_wp, 0.1_wp, -0.2_wp]), [1.0_wp, 0.5_wp, 4.0_wp])
   end function top

   subroutine which_effects_know(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      real(wp), parameter :: down(3) = [2.0_wp, 1.0_wp, -9.0_wp]
      problem => top(3, inclined)
      call check(error,.not. follows_rotating_axes(problem%system%effects), "an inclined field")
      problem => top(3, -0.3_wp*down)
      call check(error, follows_rotating_axes(problem%system%effects), "a field along the rate")
      problem => top(3, 0.0_wp*down)
      call check(error,.not. follows_rotating_axes(problem%system%effects), "axes that stand still")
   end subroutine which_effects_know

   !> 1 s by the series in 20 steps, and by DOP853 in 1000, that follows no rows.
   subroutine compare_with_dop853(error, problem, what)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      character(len=*), intent(in) :: what
      type(dop853_t) :: dop853
      class(stepper_t), allocatable :: taylor
      type(state_t) :: a, b
      type(status_t) :: status
      call make_stepper(problem%system, default_settings('taylor'), taylor, status)
      call dop853%prepare(problem%system, integrator_settings_t(), status)
      a = problem%start
      b = problem%start
      call march(problem%system, taylor, a, 0.05_wp, 20, status)
      if (status%ok()) call march(problem%system, dop853, b, 0.001_wp, 1000, status)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, attitude_distance(a%q, b%q), 4e-13_wp, what//': attitude')
      call check_close(error, body_momentum(a), body_momentum(b), 2e-12_wp*norm2(body_momentum(b)), what//': momentum')
   end subroutine compare_with_dop853

   subroutine agree_with_dop853(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=6) :: label
      integer :: axis
      do axis = 0, 3
         write (label, '("axis ",i0)') axis
         call compare_with_dop853(error, top(axis, inclined), label)
      end do
   end subroutine agree_with_dop853

   !> Checks rates along the field, from those at which the rotation of the axes is left to the end of a step to those
   !> at which it is not; the motion along the field is that of non-rotating axes.
   subroutine rates_along_the_field(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: off(5) = [0.0_wp, 1e-15_wp, 1e-13_wp, 1e-10_wp, 1e-5_wp]
      real(wp) :: rate(3)
      type(problem_t), pointer :: still
      class(stepper_t), allocatable :: stepper
      type(state_t) :: a, b
      type(status_t) :: status
      integer :: i, axis
      do axis = 0, 3, 3
         do i = 1, 2*size(off)
            rate = [-0.4_wp, -0.2_wp, 1.8_wp]*merge(1, -1, i <= size(off))
            rate(1) = rate(1) + off(1 + modulo(i - 1, size(off)))
            call compare_with_dop853(error, top(axis, rate), 'along the field')
            if (abs(off(1 + modulo(i - 1, size(off)))) > 0.0_wp) cycle
            still => top(axis, [0.0_wp, 0.0_wp, 0.0_wp])
            a = still%start
            call make_stepper(still%system, default_settings('taylor'), stepper, status)
            call march(still%system, stepper, a, 0.05_wp, 40, status)
            still => top(axis, rate)
            b = still%start
            call make_stepper(still%system, default_settings('taylor'), stepper, status)
            if (status%ok()) call march(still%system, stepper, b, 0.05_wp, 40, status)
            call check(error, status%ok(), trim(status%message))
            call check_below(error, attitude_distance(b%q, quat_product(quat_exp(-rate), a%q)), 100*eps, 'at rest')
         end do
      end do
   end subroutine rates_along_the_field

   subroutine orders(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state, exact
      type(status_t) :: status
      real(wp) :: errors(2)
      integer :: order, axis, k
      do axis = 0, 3, 3
         problem => top(axis, inclined)
         settings = default_settings('dop853')
         settings%conserve = .false.
         call make_stepper(problem%system, settings, stepper, status)
         exact = problem%start
         call march(problem%system, stepper, exact, 0.002_wp, 1000, status)
         do order = 4, 12, 4
            settings = default_settings('taylor')
            settings%series_order = order
            do k = 1, 2
               state = problem%start
               if (status%ok()) call make_stepper(problem%system, settings, stepper, status)
               if (status%ok()) call march(problem%system, stepper, state, 2.0_wp/(k*merge(40, 12, order < 8)), &
                                           k*merge(40, 12, order < 8), status)
               call check(error, status%ok(), trim(status%message))
               errors(k) = attitude_distance(state%q, exact%q)
            end do
            call check(error, errors(1)/errors(2) > 2.0_wp**(order - 0.6_wp) .or. errors(2) < 4e-13_wp, "order")
         end do
      end do
   end subroutine orders

   !> The reduced form, whose torque of uniform fields is its own in these axes, against the eight equations, and what
   !> both keep; there and back.
   subroutine conserving_steps(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: n_steps = 200
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: full, reduced
      type(state_t) :: a, b
      type(status_t) :: status
      real(wp) :: energy, scale
      integer :: axis, fields
      do axis = 0, 3
         do fields = 1, 2
            problem => top(axis, inclined)
            if (fields == 2) &
               call problem%system%effects%add(dipole_t([1.0_wp, 0.3_wp, 0.5_wp], [0.0_wp, 2.0_wp, 1.0_wp]))
            energy = conserved_energy(problem%system, problem%start)
            scale = abs(energy) + kinetic_energy(problem%system, problem%start)
            call make_stepper(problem%system, integrator_settings_t(formulation='full'), full, status)
            call make_stepper(problem%system, integrator_settings_t(formulation='reduced'), reduced, status)
            a = problem%start
            b = problem%start
            call march(problem%system, full, a, 0.02_wp, n_steps, status)
            if (status%ok()) call march(problem%system, reduced, b, 0.02_wp, n_steps, status)
            call check(error, status%ok(), trim(status%message))
            call check_below(error, attitude_distance(a%q, b%q), 1e-12_wp, "both forms: attitude")
            call check_close(error, b%p, a%p, 1e-12_wp*norm2(a%p), "both forms: momentum")
            call check_close(error, conserved_energy(problem%system, b), energy, 16*eps*scale, "H - omega.l")
            call march(problem%system, reduced, b, -0.02_wp, n_steps, status)
            call check_below(error, attitude_distance(b%q, problem%start%q), 1e-12_wp, "there and back")
         end do
      end do
   end subroutine conserving_steps

   !> The top of Brüls on the rotating Earth, and on one that turns 1e4 times as fast.
   subroutine few_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(recorder_t) :: recorder
      type(run_summary_t) :: few, many
      type(state_t) :: a, b
      type(status_t) :: status
      real(wp) :: energy
      integer :: i
      do i = 1, 2
         problem => bruls_top()
         call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=7.3e-5_wp*merge(1e4_wp, 1.0_wp, &
                                                                                  i == 2)*[0.0_wp, 0.6_wp, 0.8_wp]))
         energy = conserved_energy(problem%system, problem%start)
         call run_to(problem, default_settings('taylor'), &
                     run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=1e-12_wp)), recorder, a, few, status)
         call check(error, status%ok() .and. few%steps < 24, "many steps")
         call check_close(error, conserved_energy(problem%system, a), energy, 8*eps*kinetic_energy(problem%system, a), &
                          "H - omega.l")
         problem%system%body%inertia(3, 3) = problem%system%body%inertia(1, 1)*(1 + 4*eps)
         problem%system%body%inverse_inertia(3, 3) = problem%system%body%inverse_inertia(1, 1)*(1 - 4*eps)
         call run_to(problem, default_settings('taylor'), &
                     run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=1e-12_wp)), recorder, b, many, status)
         call check(error, status%ok() .and. many%steps > 100, "a nearly symmetric body has the frame")
         call check_below(error, attitude_distance(b%q, a%q), 1e-10_wp, "other motions")
      end do
   end subroutine few_steps

end submodule test_rotating_tops
