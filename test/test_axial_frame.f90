!> The frame in which symmetric bodies do not spin: which systems have one, and that the series moves them as it should.
submodule(suites_of_methods) test_axial_frame
   use nutate_applied_torque, only: applied_torque_t
   use nutate_axial_frame, only: axial_frame_t
   use nutate_body, only: diagonal, make_body
   use nutate_columns, only: columns_t
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_dop853, only: dop853_t
   use nutate_effect, only: effect_t
   use nutate_exact_free, only: free_body_t
   use nutate_exact_top, only: lagrange_top_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, stepper_t
   use nutate_attitude, only: quat_from_euler
   use nutate_rotor, only: rotor_t
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_controlled_run, only: recorder_t, run_to
   use test_problems, only: body_momentum, bruls_top, free_body, make_state, march, new_problem, problem_t, simo_top, &
      system_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

   !> Follows the states that it is shown, and compares rows with the Euler angles followed so far.
   type, extends(observer_t) :: follower_t
      type(columns_t) :: columns
      type(state_t) :: last
      integer :: rows = 0
      !> Least cosine of half the turn between two states; largest difference between a row and its angles.
      real(wp) :: least = 1.0_wp, difference = 0.0_wp
   contains
      procedure :: observe => compare_row
      procedure :: observe_step => follow_state
   end type follower_t

contains

   module procedure collect_axial_frame
      testsuite = [ &
                  new_unittest("bodies of two equal moments have the frame, to the last bit", recognised_by_moments), &
                  new_unittest("every effect must be symmetric about the axis", recognised_by_effects), &
                  new_unittest("symmetric effects of every kind, about each axis, as by dop853", agrees_with_dop853), &
                  new_unittest("the exact top, and its order at fixed steps", exact_top_and_order), &
                  new_unittest("a symmetric free body takes one step to the end", free_body_in_one_step), &
                  new_unittest("a fast top takes few steps, a nearly symmetric one many", few_steps), &
                  new_unittest("invariants of tops hold at every length of step", invariants_hold), &
                  new_unittest("turns inside long steps are followed, rows show their own angles", turns_are_followed)]
   end procedure collect_axial_frame

   !> The axis of a system; 0: none.
   integer function axis_of(system)
      type(system_t), intent(in) :: system
      type(axial_frame_t) :: frame
      call frame%recognise(system)
      axis_of = frame%axis
   end function axis_of

   subroutine recognised_by_moments(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp), parameter :: at_rest(3) = 0.0_wp, above = 2.0_wp*(1 + eps)
      real(wp) :: tensor(3, 3)
      integer :: axis
      do axis = 1, 3
         problem => free_body(cshift([2.0_wp, 2.0_wp, 1.0_wp], -axis), at_rest)
         call check(error, axis_of(problem%system), axis, "two equal moments")
         problem => free_body(cshift([2.0_wp, above, 1.0_wp], -axis), at_rest)
         call check(error, axis_of(problem%system), 0, "nearly equal moments")
      end do
      tensor = reshape([2.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.5_wp, 0.5_wp, 0.0_wp, 0.5_wp, 1.5_wp], [3, 3])
      call make_body(tensor, problem%system%body, status)
      call check(error, axis_of(problem%system), 0, "an axis that is none of the body's")
   end subroutine recognised_by_moments

   !> Checks each effect alone on a body with axis 3, with parameters that are symmetric about it and with others.
   subroutine recognised_by_effects(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: symmetric, other
      real(wp), parameter :: at_rest(3) = 0.0_wp, down(3) = [0.0_wp, 0.6_wp, -0.8_wp]
      symmetric => free_body([2.0_wp, 2.0_wp, 1.0_wp], at_rest)
      other => free_body([2.0_wp, 1.5_wp, 1.0_wp], at_rest)
      call expect(dipole_t([0.0_wp, 0.0_wp, 2.0_wp], down), 3)
      call expect(dipole_t([1e-9_wp, 0.0_wp, 2.0_wp], down), 0)
      call expect(gravity_gradient_t(symmetric%system%body, down, 1.0_wp), 3)
      call expect(gravity_gradient_t(other%system%body, down, 1.0_wp), 0)
      call expect(spring_t([0.0_wp, 0.0_wp, 0.5_wp], down, 1.0_wp, 0.1_wp), 3)
      call expect(spring_t([0.0_wp, 0.1_wp, 0.5_wp], down, 1.0_wp, 0.1_wp), 0)
      call expect(damping_t([0.1_wp, 0.1_wp, 0.3_wp]), 3)
      call expect(damping_t([0.1_wp, 0.2_wp, 0.3_wp]), 0)
      call expect(rotor_t(name='rotor', momentum=[0.0_wp, 0.0_wp, 0.7_wp]), 3)
      call expect(rotor_t(name='rotor', momentum=[0.0_wp, 0.1_wp, 0.7_wp]), 0)
      call expect(applied_torque_t(name='torque', amplitude=[0.0_wp, 0.0_wp, 1.0_wp]), 3)
      call expect(applied_torque_t(name='torque', amplitude=[1.0_wp, 0.0_wp, 0.0_wp]), 0)
      call expect(applied_torque_t(name='torque', amplitude=[1.0_wp, 2.0_wp, 0.0_wp], in_space=.true.), 3)
   contains
      subroutine expect(effect, axis)
         class(effect_t), intent(in) :: effect
         integer, intent(in) :: axis
         type(problem_t) :: problem
         if (allocated(error)) return
         problem = symmetric
         call problem%system%effects%add(effect)
         call check(error, axis_of(problem%system), axis, trim(effect%name))
      end subroutine expect
   end subroutine recognised_by_effects

   !> A body of axis `axis` with effects of every kind that are symmetric about it.
   function symmetric_body(axis) result(problem)
      integer, intent(in) :: axis
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: along(3)
      problem => new_problem()
      along = 0.0_wp
      along(axis) = 1.0_wp
      call make_body(diagonal(2.0_wp - 0.8_wp*along), problem%system%body, status)
      associate (effects => problem%system%effects)
         call effects%add(dipole_t(1.5_wp*along, [0.3_wp, 1.0_wp, -2.0_wp]))
         call effects%add(gravity_gradient_t(problem%system%body, [1.0_wp, 0.5_wp, 0.2_wp], 0.8_wp))
         call effects%add(spring_t(0.6_wp*along, [1.0_wp, -0.4_wp, 0.3_wp], 2.0_wp, 0.3_wp))
         call effects%add(damping_t(0.1_wp + 0.2_wp*along))
         call effects%add(applied_torque_t(name='torque', amplitude=0.7_wp*along, frequency=0.3_wp))
         call effects%add(applied_torque_t(name='torque', amplitude=[0.2_wp, -0.5_wp, 0.4_wp], in_space=.true.))
         call effects%add(rotor_t(name='rotor', momentum=0.9_wp*along))
      end associate
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], &
                                 8.0_wp*along + [0.5_wp, -0.3_wp, 0.7_wp])
   end function symmetric_body

   subroutine agrees_with_dop853(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(dop853_t) :: dop853
      class(stepper_t), allocatable :: taylor
      type(state_t) :: a, b
      type(status_t) :: status
      real(wp) :: work_a(3), work_b(3)
      integer :: axis, i
      do axis = 1, 3
         problem => symmetric_body(axis)
         call check(error, axis_of(problem%system), axis, "no axis")
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
         call check_below(error, attitude_distance(a%q, b%q), 4e-13_wp, 'attitude')
         call check_close(error, body_momentum(a), body_momentum(b), 2e-12_wp, 'momentum')
         call check_close(error, work_a, work_b, 4e-12_wp, 'work')
      end do
   end subroutine agrees_with_dop853

   !> The top of Simo and Wong, 3 s; halved steps divide the error by 2 to the order.
   subroutine exact_top_and_order(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      class(stepper_t), allocatable :: stepper
      type(lagrange_top_t) :: top
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: q(4), momentum(3), errors(2)
      integer :: order, k
      problem => simo_top()
      call top%prepare(5.0_wp, 1.0_wp, 20.0_wp, problem%start%q, body_momentum(problem%start), status)
      call top%evaluate(3.0_wp, q, momentum)
      settings = default_settings('taylor')
      do order = 4, 16, 4
         settings%series_order = order
         do k = 1, 2
            state = problem%start
            call make_stepper(problem%system, settings, stepper, status)
            call march(problem%system, stepper, state, 3.0_wp/(k*merge(60, 12, order < 16)), &
                       k*merge(60, 12, order < 16), status)
            call check(error, status%ok(), trim(status%message))
            errors(k) = attitude_distance(state%q, q)
         end do
         if (order < 16) call check(error, errors(1)/errors(2) > 2.0_wp**(order - 0.5_wp) .or. errors(2) < 1e-13_wp, &
                                    "the error does not fall as the order says")
      end do
      call check_below(error, errors(2), 1e-12_wp, "24 steps of order 16")
      call check_close(error, body_momentum(state), momentum, 1e-12_wp*norm2(momentum), "momentum")
   end subroutine exact_top_and_order

   subroutine free_body_in_one_step(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(free_body_t) :: solution
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: q(4), momentum(3)
      integer :: axis
      do axis = 1, 3
         problem => free_body(cshift([2.0_wp, 2.0_wp, 1.0_wp], -axis), [1.0_wp, -2.0_wp, 3.0_wp])
         call solution%prepare(problem%system%body%moments, problem%start%q, body_momentum(problem%start), status)
         call run_to(problem, default_settings('taylor'), &
                     run_plan_t(end_time=50.0_wp, goal=run_goal_t(local_tolerance=1e-6_wp)), recorder, state, summary, &
                     status)
         call check(error, status%ok() .and. summary%steps == 1, "more than one step")
         call solution%evaluate(50.0_wp, q, momentum)
         call check_below(error, attitude_distance(state%q, q), 400*eps, "attitude")
         call check_close(error, body_momentum(state), momentum, 400*eps, "momentum")
      end do
   end subroutine free_body_in_one_step

   !> The top of Brüls turns by 300 rad in 2 s.
   subroutine few_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(recorder_t) :: recorder
      type(run_summary_t) :: few, many
      type(state_t) :: a, b
      type(status_t) :: status
      type(run_plan_t), parameter :: plan = run_plan_t(end_time=2.0_wp, goal=run_goal_t(local_tolerance=1e-12_wp))
      real(wp), parameter :: q(4) = [0.122947135041533467_wp, -0.491079892550027015_wp, 0.350430030343620962_wp, &
                                     -0.787986887550485669_wp]
      problem => bruls_top()
      call run_to(problem, default_settings('taylor'), plan, recorder, a, few, status)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, attitude_distance(a%q, q), 5e-12_wp, "attitude")
      call check(error, few%steps < 20, "many steps")
      problem%system%body%inertia(3, 3) = problem%system%body%inertia(1, 1)*(1 + 4*eps)
      problem%system%body%inverse_inertia(3, 3) = problem%system%body%inverse_inertia(1, 1)*(1 - 4*eps)
      call run_to(problem, default_settings('taylor'), plan, recorder, b, many, status)
      call check(error, many%steps > 80, "a nearly symmetric body has the frame")
      call check_below(error, attitude_distance(b%q, a%q), 1e-10_wp, "other motions")
   end subroutine few_steps

   subroutine invariants_hold(error)
      type(error_type), allocatable, intent(out) :: error
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      character(len=24) :: label
      integer :: exponent
      do exponent = 2, 14, 3
         write (label, '("tolerance 1e-",i0)') exponent
         call run_to(bruls_top(), default_settings('taylor'), run_plan_t(end_time=40.0_wp, goal=run_goal_t( &
                     local_tolerance=10.0_wp**(-exponent))), recorder, state, summary, status)
         call check(error, status%ok(), trim(label)//': '//trim(status%message))
         associate (invariants => recorder%invariants)
            call check_below(error, max(invariants%energy_error(), invariants%momentum_error(), &
                                        invariants%norm_error), 4e-15_wp, label)
         end associate
      end do
   end subroutine invariants_hold

   subroutine compare_row(self, system, state, record, status)
      class(follower_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      real(wp) :: values(4)
      self%rows = self%rows + 1
      if (self%rows == 1) then
         self%last = state
         call self%columns%start(system, state, 0.0_wp)
      end if
      call self%columns%evaluate(system, state, record, values)
      self%difference = max(self%difference, &
                            attitude_distance(state%q, quat_from_euler(values(2), values(3), values(4))))
   end subroutine compare_row

   subroutine follow_state(self, state)
      class(follower_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      self%least = min(self%least, dot_product(state%q, self%last%q))
      self%last = state
      call self%columns%follow(state)
   end subroutine follow_state

   !> No two states watched are more than 3 rad apart, sign included, with rows inside the steps and without, and every
   !> row has the angles of its state; steps turn by far more.
   subroutine turns_are_followed(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_plan_t) :: plan
      integer :: i
      problem => bruls_top()
      do i = 1, 3
         plan = run_plan_t(end_time=merge(2.0_wp, -2.0_wp, i < 3), goal=run_goal_t(local_tolerance=1e-8_wp))
         if (i > 1) plan%interval = 0.05_wp
         call follow(error, problem, plan)
      end do
   end subroutine turns_are_followed

   subroutine follow(error, problem, plan)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(run_plan_t), intent(in) :: plan
      type(follower_t) :: follower
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      follower%observes_every_step = .true.
      call follower%columns%choose(['euler'], status)
      state = problem%start
      call integrate(problem%system, default_settings('taylor'), state, plan, status, follower, summary)
      call check(error, status%ok() .and. summary%steps < 20, "steps, or "//trim(status%message))
      call check_below(error, acos(follower%least), 1.5_wp, "half a turn between two states")
      call check_below(error, follower%difference, 1e-13_wp, "angles of a row")
   end subroutine follow

end submodule test_axial_frame
