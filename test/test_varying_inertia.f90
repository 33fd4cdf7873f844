!> Bodies whose inertia varies with time: trajectories of 20 digits, closed solutions, the oracle, the balance of energy
!> and momentum, checkpoints and rejections.
module test_varying_inertia
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: body_t, diagonal, make_body, symmetric, whole_body
   use nutate_damping, only: damping_t
   use nutate_exact_free, only: free_body_t
   use nutate_gravity, only: gravity_t
   use nutate_inertia_change, only: inertia_change_t, make_tabulated_inertia
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_motion, only: find_motion, find_rates, motion_t
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_rotor, only: rotor_t
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tangent, only: tangent_t
   use nutate_variation, only: inertia_variation, rate_variation, variation_t
   use nutate_varying_inertia, only: check_change
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel, mount_wheels
   use test_oracle, only: find_true_attitude, has_oracle, qp, true_distance
   use test_problems, only: angular_velocity, body_momentum, inertia_at, make_state, new_problem, new_system, &
      problem_t, space_momentum, system_t, total_energy
   use test_resume, only: check_balance, check_stepper, label_of, run_steps, settings_of
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest, random_unit, &
      random_unit_quaternion, random_vector, skip_test, unittest_type
   implicit none
   private

   public :: collect_varying_inertia

   !> Inertia at t = 0, kg m², and its rate, kg m²/s: 11, 22, 33, 12, 13, 23; attitude and rate of the start.
   real(wp), parameter :: j0(6) = [2.0_wp, 1.5_wp, 1.0_wp, 0.1_wp, 0.2_wp, -0.05_wp], &
      k(6) = [0.03_wp, 0.08_wp, 0.05_wp, 0.01_wp, -0.02_wp, 0.0_wp], q0(4) = [0.5_wp, 0.1_wp, -0.7_wp, 0.5_wp], &
      omega0(3) = [0.8_wp, -0.6_wp, 1.4_wp]
   !> Attitude at t = 10 s, and Ω, rad/s, and T, J, of a body of inertia J0 + Kt; L, N m s, of one of J0 (1 + t/10); Ω
   !> of one of J0 (1 - t/20) whose mass leaves: extrapolation in quadruple precision.
   real(wp), parameter :: deployed_q(4) = [-0.34545319262413252806_wp, -0.096396643223820462326_wp, &
                                           -0.6319659070125338467_wp, 0.68701446218751383681_wp], &
      deployed_omega(3) = [0.16428850987422898006_wp, -1.0381018270361070239_wp, 0.60333204274331495896_wp], &
      deployed_energy = 1.5405565651306415041_wp, &
      scaled_q(4) = [0.086917199088295052308_wp, 0.21395208642470958814_wp, -0.7176103068188379801_wp, &
                     -0.65704288502694593694_wp], &
      scaled_momentum(3) = [1.2523951126548887682_wp, 2.1461730752770956315_wp, -0.67679214885650267793_wp], &
      lost_omega(3) = [0.47004815791460342327_wp, 1.366521516399393707_wp, 0.89368108192887143106_wp]

contains

   subroutine collect_varying_inertia(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("trajectories of 20 digits by every method", trajectories), &
                  new_unittest("orders 2, 4 and 6", orders), &
                  new_unittest("an inertia that grows as one moves the rigid body more slowly", scaled_body), &
                  new_unittest("an inertia that is lost as one leaves the rigid motion", lost_mass), &
                  new_unittest("a boom by a table: rate = l/J", boom), &
                  new_unittest("random motions as by the oracle", random_motions), &
                  new_unittest("energy and momentum to round-off over many steps", balance), &
                  new_unittest("the work of a change by every method", same_work), &
                  new_unittest("rates of a motion", rates_of_motion), &
                  new_unittest("sensitivities by rates and by the scale of a table", sensitivities), &
                  new_unittest("steppers go on bit for bit", steppers_go_on), &
                  new_unittest("a tensor between the lines of a cubic table", between_lines), &
                  new_unittest("a step to a time without a positive inertia", beyond_positive), &
                  new_unittest("rejections", rejections)]
   end subroutine collect_varying_inertia

   !> The body of inertia J0, with one change of the inertia or two.
   subroutine make_changing(problem, first, second)
      type(problem_t), intent(inout) :: problem
      type(inertia_change_t), intent(in) :: first
      type(inertia_change_t), intent(in), optional :: second
      type(status_t) :: status
      problem = new_problem()
      call make_body(symmetric(j0), problem%system%body, status, mass=3.0_wp, center_of_mass=[0.1_wp, -0.2_wp, 0.3_wp])
      if (.not. status%ok()) error stop 'the body is none'
      call problem%system%effects%add(first)
      if (present(second)) call problem%system%effects%add(second)
      problem%start = make_state(problem%system, q0, omega0)
   end subroutine make_changing

   !> Attitudes may differ by a sign.
   subroutine check_attitude(error, q, expected, tolerance, label)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: q(4), expected(4), tolerance
      character(len=*), intent(in) :: label
      call check_close(error, sign(1.0_wp, dot_product(q, expected))*q, expected, tolerance, label)
   end subroutine check_attitude

   subroutine trajectories(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: deployed, scaled, lost
      type(state_t) :: state
      real(wp) :: step
      character(len=:), allocatable :: label
      integer :: i
      deployed => new_problem()
      scaled => new_problem()
      lost => new_problem()
      call make_changing(deployed, inertia_change_t(k))
      call make_changing(scaled, inertia_change_t(0.1_wp*j0))
      call make_changing(lost, inertia_change_t(-0.05_wp*j0, mass_leaves=.true.))
      do i = 1, size(methods)
         if (methods(i)%order < 8 .or. methods(i)%name == 'exact') cycle
         step = merge(0.02_wp, 0.05_wp, methods(i)%name == 'rk8' .or. methods(i)%name == 'dop853')
         label = label_of(methods(i))
         associate (settings => settings_of(methods(i)))
            call run_steps(error, deployed, settings, step, 10.0_wp, state, label)
            call check_attitude(error, state%q, deployed_q, 1e-12_wp, label//', deployed')
            call check_close(error, angular_velocity(deployed%system, state), deployed_omega, 1e-12_wp, label)
            call check_close(error, total_energy(deployed%system, state), deployed_energy, 1e-12_wp, label)
            call run_steps(error, scaled, settings, step, 10.0_wp, state, label)
            call check_attitude(error, state%q, scaled_q, 1e-12_wp, label//', scaled')
            call check_close(error, body_momentum(state), scaled_momentum, 1e-12_wp, label)
            call run_steps(error, lost, settings, step, 10.0_wp, state, label)
            call check_close(error, angular_velocity(lost%system, state), lost_omega, 1e-12_wp, label//', lost')
         end associate
         if (allocated(error)) return
      end do
   end subroutine trajectories

   !> Half the step divides the error by two to the power of the order.
   subroutine orders(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      real(wp) :: errors(2), step
      integer :: i, n
      problem => new_problem()
      call make_changing(problem, inertia_change_t(k), &
                         inertia_change_t([-0.05_wp, -0.04_wp, -0.03_wp], mass_leaves=.true.))
      call run_steps(error, problem, integrator_settings_t(method='dop853', order=8), 0.01_wp, 2.0_wp, state, 'dop853')
      if (allocated(error)) return
      associate (expected => state%q)
         do i = 1, size(methods)
            if (methods(i)%order > 6 .or. methods(i)%name == 'exact') cycle
            do n = 1, 2
               step = 0.2_wp/n
               if (methods(i)%order == 6) step = 0.4_wp/n
               call last_error(step, expected, errors(n))
            end do
            call check_close(error, log(errors(1)/errors(2))/log(2.0_wp), real(methods(i)%order, wp), 0.4_wp, &
                             label_of(methods(i)))
         end do
      end associate

   contains

      subroutine last_error(step, expected, distance)
         real(wp), intent(in) :: step, expected(4)
         real(wp), intent(out) :: distance
         type(state_t) :: last
         call run_steps(error, problem, settings_of(methods(i)), step, 2.0_wp, last, label_of(methods(i)))
         distance = norm2(last%q - expected)
      end subroutine last_error

   end subroutine orders

   !> J = J0 f(t): the attitude at t is that of the rigid body at ∫dt/f.
   subroutine scaled_body(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(free_body_t) :: rigid
      type(status_t) :: status
      real(wp) :: q(4), momentum(3)
      integer :: i
      problem => new_problem()
      call make_changing(problem, inertia_change_t(0.1_wp*j0, start=1.0_wp, stop=6.0_wp))
      associate (body => problem%system%body)
         call rigid%prepare(body%moments, q0, body_momentum(problem%start), status, body%axes)
      end associate
      call check(error, status%ok(), trim(status%message))
      ! From 1 s to 6 s f grows from 1 to 1.5.
      call rigid%evaluate(1 + 10*log(1.5_wp) + 4/1.5_wp, q, momentum)
      do i = 1, size(methods)
         if (methods(i)%order < 8 .or. methods(i)%name == 'exact') cycle
         call run_steps(error, problem, settings_of(methods(i)), 0.023_wp, 10.0_wp, state, label_of(methods(i)))
         call check_attitude(error, state%q, q, 1e-12_wp, label_of(methods(i)))
         call check_close(error, body_momentum(state), momentum, 4e-12_wp, label_of(methods(i)))
      end do
   end subroutine scaled_body

   !> J = J0 f(t) of mass that leaves: the motion is the rigid one.
   subroutine lost_mass(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(free_body_t) :: rigid
      type(status_t) :: status
      real(wp) :: q(4), momentum(3)
      integer :: i
      problem => new_problem()
      call make_changing(problem, inertia_change_t(-0.08_wp*j0, stop=5.5_wp, mass_leaves=.true.))
      associate (body => problem%system%body)
         call rigid%prepare(body%moments, q0, body_momentum(problem%start), status, body%axes)
      end associate
      call check(error, status%ok(), trim(status%message))
      call rigid%evaluate(8.0_wp, q, momentum)
      do i = 1, size(methods)
         if (methods(i)%order < 8 .or. methods(i)%name == 'exact') cycle
         call run_steps(error, problem, settings_of(methods(i)), 0.025_wp, 8.0_wp, state, label_of(methods(i)))
         call check_attitude(error, state%q, q, 1e-12_wp, label_of(methods(i)))
         call check_close(error, body_momentum(state), 0.56_wp*momentum, 4e-12_wp, label_of(methods(i)))
      end do
   end subroutine lost_mass

   !> A boom that leaves the axis of rotation, by a table with straight lines and by a spline.
   subroutine boom(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: times(4) = [0.0_wp, 2.0_wp, 3.0_wp, 7.0_wp], growth(4) = [0.0_wp, 0.3_wp, 0.5_wp, 0.9_wp]
      type(inertia_change_t) :: change
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: tensors(3, 4), j(3, 3), momentum
      integer :: i, m, at
      logical :: spline
      tensors(1, :) = 1.0_wp
      tensors(2, :) = 1.2_wp + growth
      tensors(3, :) = 1.5_wp + growth
      do m = 1, 2
         spline = m == 2
         call make_tabulated_inertia(times, tensors, change, status, at, spline=spline)
         call check(error, status%ok(), trim(status%message))
         problem => new_problem()
         call make_body(diagonal(tensors(:, 1)), problem%system%body, status)
         call problem%system%effects%add(change)
         problem%start = make_state(problem%system, q0, [0.0_wp, 0.0_wp, 2.0_wp])
         momentum = 3.0_wp
         do i = 1, size(methods)
            if (methods(i)%name == 'exact') cycle
            call run_steps(error, problem, settings_of(methods(i)), 0.35_wp, 6.0_wp, state, label_of(methods(i)))
            j = inertia_at(problem%system, 6.0_wp)
            call check_close(error, angular_velocity(problem%system, state), [0.0_wp, 0.0_wp, momentum/j(3, 3)], &
                             20*eps, label_of(methods(i)))
            if (.not. spline) call check_close(error, j(3, 3), 2.3_wp, 4*eps, 'moment')
         end do
      end do
   end subroutine boom

   !> Random changes with random effects: several rates and a table, masses that stay and that leave.
   subroutine make_random(seed, problem)
      integer(int64), intent(inout) :: seed
      type(problem_t), intent(inout) :: problem
      type(inertia_change_t) :: change, changes(2)
      type(wheel_t) :: wheel
      type(status_t) :: status
      real(wp) :: tensors(6, 5), times(5), window(2)
      integer :: i, at
      do i = 1, 2
         window = 0.1_wp + [3*random_unit(seed), 3*random_unit(seed)]
         changes(i) = inertia_change_t(0.05_wp*[random_vector(seed), 0.3_wp*random_vector(seed)], minval(window), &
                                       maxval(window) + 0.1_wp, random_unit(seed) < 0.5_wp)
      end do
      if (random_unit(seed) < 0.5_wp) then
         call make_changing(problem, changes(1))
      else
         call make_changing(problem, changes(1), changes(2))
      end if
      if (random_unit(seed) < 0.6_wp) then
         times = [-0.1_wp, 0.7_wp, 1.2_wp, 2.9_wp, 5.0_wp]
         do i = 1, 5
            tensors(:, i) = j0 + 0.1_wp*[random_vector(seed), 0.3_wp*random_vector(seed)]
         end do
         call make_tabulated_inertia(times, tensors, change, status, at, spline=random_unit(seed) < 0.5_wp, &
                                     mass_leaves=random_unit(seed) < 0.5_wp, scale=1.1_wp)
         if (.not. status%ok()) error stop 'the table is none'
         call make_body(1.1_wp*change%tabulated_at(0.0_wp), problem%system%body, status, mass=3.0_wp, &
                        center_of_mass=[0.1_wp, -0.2_wp, 0.3_wp])
         call problem%system%effects%add(change)
      end if
      if (random_unit(seed) < 0.5_wp) &
         call problem%system%effects%add(gravity_t(problem%system%body, 2*random_vector(seed)))
      if (random_unit(seed) < 0.5_wp) call problem%system%effects%add(damping_t(0.1_wp*abs(random_vector(seed))))
      if (random_unit(seed) < 0.5_wp) &
         call problem%system%effects%add(rotor_t(name='rotor', momentum=0.3_wp*random_vector(seed)))
      if (random_unit(seed) < 0.5_wp) then
         wheel = wheel_t(name='wheel', axis=[0.6_wp, 0.0_wp, 0.8_wp], inertia=0.05_wp, speed=2.0_wp, friction=0.01_wp)
         call add_wheel(problem%system, wheel, status)
         if (.not. status%ok()) error stop 'the wheel does not fit'
      end if
      problem%start = make_state(problem%system, random_unit_quaternion(seed), 1.5_wp*random_vector(seed))
   end subroutine make_random

   subroutine random_motions(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      real(qp) :: q(4)
      integer(int64) :: seed
      integer :: number, i
      problem => new_problem()
      if (.not. has_oracle) then
         call skip_test(error, 'the compiler has no quadruple precision')
         return
      end if
      seed = 20261129_int64
      do number = 1, 24
         call make_random(seed, problem)
         if (.not. in_turn(number)) cycle
         call find_true_attitude(problem%system, problem%start, 4.0_wp, q, 1e-20_qp)
         do i = 1, size(methods)
            if (methods(i)%order < 8 .or. methods(i)%name == 'exact') cycle
            if (modulo(i + number, 2) == 0) cycle
            call run_steps(error, problem, settings_of(methods(i)), 0.02_wp, 4.0_wp, state, label_of(methods(i)))
            call check_below(error, true_distance(q, state%q), 1e-12_wp, label_of(methods(i)))
         end do
         if (allocated(error)) return
      end do
   end subroutine random_motions

   !> Energy less works, and momentum, of conserving methods with long steps.
   subroutine balance(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      real(wp) :: momentum(3)
      integer(int64) :: seed
      integer :: i, number
      problem => new_problem()
      seed = 4711_int64
      do number = 0, 4
         if (number == 0) then
            ! Nothing from outside.
            call make_changing(problem, inertia_change_t(1e-4_wp*k))
         else
            call make_random(seed, problem)
         end if
         momentum = space_momentum(problem%start)
         do i = 1, size(methods)
            if (methods(i)%name == 'exact' .or. .not. methods(i)%conserving .or. .not. in_turn(i + number)) cycle
            call check_balance(error, problem, methods(i), state)
            if (allocated(error)) return
            if (number == 0) call check_close(error, space_momentum(state), momentum, 100*eps, &
                                              label_of(methods(i))//', momentum')
         end do
      end do
   end subroutine balance

   subroutine same_work(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state, first
      integer(int64) :: seed
      integer :: i, number
      problem => new_problem()
      seed = 815_int64
      do number = 1, 3
         call make_random(seed, problem)
         call run_steps(error, problem, integrator_settings_t(order=8, formulation='reduced'), 0.01_wp, 4.0_wp, first, &
                  'first')
         do i = 1, size(methods)
            if (methods(i)%order < 8 .or. methods(i)%name == 'exact') cycle
            call run_steps(error, problem, settings_of(methods(i)), 0.02_wp, 4.0_wp, state, label_of(methods(i)))
            call check_close(error, state%time_dependent_work, first%time_dependent_work, 1e-11_wp, &
                             label_of(methods(i)))
            call check_below(error, 1e-3_wp, abs(first%time_dependent_work), 'there is work')
         end do
      end do
   end subroutine same_work

   !> Ω̇ by differences.
   subroutine rates_of_motion(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1e-3_wp
      type(problem_t), pointer :: problem
      type(state_t) :: states(2)
      type(motion_t) :: motion
      integer(int64) :: seed
      integer :: number, i
      problem => new_problem()
      seed = 42_int64
      do number = 1, 4
         call make_random(seed, problem)
         do i = 1, 2
            call run_steps(error, problem, integrator_settings_t(order=8, formulation="reduced"), h*(2*i - 3), &
                     h*(2*i - 3), states(i), "h")
         end do
         call find_motion(problem%system, problem%start, motion)
         call find_rates(problem%system, 0.1_wp*h, motion)
         call check_close(error, motion%acceleration, (angular_velocity(problem%system, states(2)) - &
                          angular_velocity(problem%system, states(1)))/(2*h), 2e-5_wp, 'acceleration')
      end do
   end subroutine rates_of_motion

   !> Sensitivities of the unprojected steps of every method, by five-point differences of the same
   !> steps: by a component of the rate, a component of the inertia at t = 0, the rate at the start and the scale of a
   !> table.
   subroutine sensitivities(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      type(variation_t) :: variations(4)
      type(status_t) :: status
      integer(int64) :: seed
      integer :: number, i, n
      problem => new_problem()
      seed = 31415_int64
      do number = 1, 6
         call make_random(seed, problem)
         variations = variation_t()
         variations(1) = rate_variation(2)
         variations(2) = inertia_variation(1, 3)
         associate (effects => problem%system%effects)
            call variations(3)%add(effects, 'inertia_rate', 1, 'tensor', &
                                   [0.0_wp, 1.0_wp, 0.0_wp, 0.5_wp, 0.0_wp, 0.0_wp], status)
            call check(error, status%ok(), trim(status%message))
            n = 3
            if (effects%n_wheels == 0 .and. place_of_table(problem%system) > 0) n = 4
            if (n == 4) call variations(4)%add(effects, 'inertia_table', 1, 'inertia_scale', [1.0_wp], status)
            call check(error, status%ok(), trim(status%message))
         end associate
         do i = 1, size(methods)
            if (methods(i)%name == 'exact' .or. methods(i)%projected) cycle
            if (.not. in_turn(i + number)) cycle
            settings = settings_of(methods(i))
            settings%conserve = .false.
            call compare_sensitivities(error, problem, settings, variations(:n), label_of(methods(i)))
            if (allocated(error)) return
         end do
      end do
   end subroutine sensitivities

   !> Index of the torque that is a table of the inertia; 0 where there is none.
   pure integer function place_of_table(system) result(place)
      type(system_t), intent(in) :: system
      do place = system%effects%n_torques, 1, -1
         if (system%effects%torques(place)%item%name == 'inertia_table') return
      end do
   end function place_of_table

   subroutine compare_sensitivities(error, problem, settings, variations, label)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      type(variation_t), intent(in) :: variations(:)
      character(len=*), intent(in) :: label
      real(wp), parameter :: places(4) = [-2.0_wp, -1.0_wp, 1.0_wp, 2.0_wp], h = 2e-3_wp, &
         weights(4) = [1.0_wp, -8.0_wp, 8.0_wp, -1.0_wp]/(12*h)
      type(problem_t), pointer :: moved
      type(tangent_t) :: tangent
      type(state_t) :: last, state
      type(status_t) :: status
      real(wp) :: theta(3), momentum(3), turn(4)
      integer :: k, m
      moved => new_problem()
      call follow(problem, last, tangent)
      do k = 1, size(variations)
         theta = 0.0_wp
         momentum = 0.0_wp
         do m = 1, size(places)
            call move_problem(problem, k, h*places(m), moved, status)
            call check(error, status%ok(), trim(status%message))
            if (allocated(error)) return
            call follow(moved, state)
            turn = quat_product(quat_conjugate(last%q), state%q)
            theta = theta + (2*weights(m))*turn(2:4)
            momentum = momentum + weights(m)*body_momentum(state)
         end do
         call check_close(error, tangent%theta(k, :), theta, 1e-8_wp, label//', theta of '//trim(variations(k)%name))
         call check_close(error, tangent%momentum(k, :), momentum, 1e-8_wp, label//', L')
      end do

   contains

      !> The state after some steps, and its sensitivities.
      subroutine follow(problem, state, tangent)
         type(problem_t), intent(in) :: problem
         type(state_t), intent(out) :: state
         type(tangent_t), intent(inout), optional :: tangent
         class(stepper_t), allocatable :: stepper
         type(state_t) :: before
         integer :: i
         state = problem%start
         call make_stepper(problem%system, settings, stepper, status)
         if (present(tangent) .and. status%ok()) call tangent%begin(problem%system, state, variations, status)
         do i = 1, 24
            if (.not. status%ok()) exit
            before = state
            call stepper%step(problem%system, state, 0.05_wp, status)
            if (status%ok() .and. present(tangent)) call stepper%propagate(problem%system, before, state, 0.05_wp, &
                                                                          before%t + 0.025_wp, tangent, status)
         end do
         call check(error, status%ok(), label//': '//trim(status%message))
      end subroutine follow

   end subroutine compare_sensitivities

   !> Moves a parameter; Ω of the start stays.
   subroutine move_problem(problem, k, part, moved, status)
      type(problem_t), intent(in) :: problem
      !> Index of the sensitivity.
      integer, intent(in) :: k
      real(wp), intent(in) :: part
      type(problem_t), intent(inout) :: moved
      type(status_t), intent(out) :: status
      real(wp) :: tensor(3, 3), omega(3)
      logical :: done
      moved = problem
      tensor = 0.0_wp
      omega = angular_velocity(problem%system, problem%start)
      done = .true.
      select case (k)
      case (1)
         omega(2) = omega(2) + part
      case (2)
         tensor(1, 3) = part
         tensor(3, 1) = part
      case (3)
         done = moved%system%effects%torques(1)%item%shift(part*[0.0_wp, 1.0_wp, 0.0_wp, 0.5_wp, 0.0_wp, 0.0_wp])
      case default
         associate (item => moved%system%effects%torques(place_of_table(moved%system))%item)
            done = item%shift([part])
            tensor = item%inertia_derivative([part], 0, 0.0_wp, 0.0_wp, 1.0_wp)
         end associate
      end select
      if (.not. done) error stop 'the effect has no such parameter'
      if (any(abs(tensor) > 0.0_wp)) call move_body(moved%system, tensor, status)
      moved%start = make_state(moved%system, problem%start%q, omega)
   end subroutine move_problem

   !> Changes the inertia at t = 0, with wheels mounted.
   subroutine move_body(system, tensor, status)
      type(system_t), intent(inout) :: system
      real(wp), intent(in) :: tensor(3, 3)
      type(status_t), intent(out) :: status
      type(body_t) :: body
      body = whole_body(system%body)
      call make_body(body%inertia + tensor, system%body, status, mass=body%mass, center_of_mass=body%center_of_mass, &
                     check_triangle=.false.)
      if (status%ok()) call mount_wheels(system, status)
   end subroutine move_body

   subroutine steppers_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      integer(int64) :: seed
      integer :: i
      problem => new_problem()
      seed = 99_int64
      call make_random(seed, problem)
      do i = 1, size(methods)
         if (methods(i)%name == 'exact') cycle
         call check_stepper(error, problem, settings_of(methods(i)), spread(0.05_wp, 1, 7), &
                            [0.05_wp, 0.05_wp, 0.03_wp, 0.03_wp, 0.05_wp], label_of(methods(i)))
      end do
   end subroutine steppers_go_on

   !> A step to a time without a positive inertia is rejected by every method.
   subroutine beyond_positive(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      integer :: i
      problem => new_problem()
      call make_changing(problem, inertia_change_t([-2.0_wp, -1.0_wp, -1.0_wp]))
      do i = 1, size(methods)
         if (methods(i)%name == 'exact') cycle
         call make_stepper(problem%system, settings_of(methods(i)), stepper, status)
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         state = problem%start
         call stepper%step(problem%system, state, 1.1_wp, status)
         call check(error, status%message, 'the inertia is not positive definite at all times of the step', &
                    label_of(methods(i)))
      end do
   end subroutine beyond_positive

   !> A spline between valid lines may leave the valid tensors.
   subroutine between_lines(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: times(4) = [0.0_wp, 1.0_wp, 2.0_wp, 3.0_wp]
      real(wp) :: tensors(3, 4)
      type(inertia_change_t) :: change
      type(system_t), pointer :: system
      type(status_t) :: status
      real(wp) :: t, tensor(3, 3)
      integer :: at, m, i
      system => new_system()
      tensors = 1.0_wp
      tensors(1, :) = [1.9_wp, 0.05_wp, 0.05_wp, 1.9_wp]
      do m = 1, 2
         call make_tabulated_inertia(times, tensors, change, status, at, spline=m == 2)
         call make_body(diagonal(tensors(:, 1)), system%body, status)
         if (allocated(system%effects%torques)) deallocate (system%effects%torques)
         system%effects%n_torques = 0
         call system%effects%add(change)
         call check_change(system, 0.0_wp, 3.0_wp, status)
         call check(error, status%ok() .eqv. m == 1, trim(status%message)//' by degree')
      end do
      i = index(status%message, 't = ')
      call check(error, i > 0 .and. index(status%message, 'the inertia is not positive definite') == 1, &
                 trim(status%message))
      if (allocated(error)) return
      read (status%message(i + 4:), *) t
      ! The time has six decimals.
      tensor = inertia_at(system, t + 1e-5_wp)
      call check_below(error, tensor(1, 1), 0.0_wp, 'moment after the fault')
      tensor = inertia_at(system, t - 1e-5_wp)
      call check_below(error, 0.0_wp, tensor(1, 1), 'moment before the fault')
   end subroutine between_lines

   subroutine rejections(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: body = '&body inertia = 2, 1.5, 1 / &inertia_rate ', &
         rest = ' / &initial angular_velocity = 0.8, -0.6, 1.4 / &integrator time_step = 1, end_time = 5'
      call expect(body//'tensor = 3*0.1'//rest//" method = 'exact' /", &
                  "method 'exact' has no solution for an inertia that varies (expected another method)")
      call expect(body//'tensor = 0, 0, -0.25'//rest//' /', 'the inertia is that of no rigid body: one moment '// &
                  'exceeds the sum of the other two, at t = 2.000000 s')
      call expect('&body inertia = 2, 1.5, 1, check_triangle = .false. / &inertia_rate tensor = 0, -0.5, -0.5'// &
                  rest//' /', 'the inertia is not positive definite at t = 2.000000 s')
      call expect(body//'tensor = 0, -0.5, 0, 1'//rest//' /', 'the tensor has neither three nor six numbers '// &
                  '(expected 11, 22, 33, or 11, 22, 33, 12, 13, 23)')
      call expect(body//'tensor = 3*0.1, start = 2, stop = 1'//rest//' /', &
                  'the change stops before it starts (expected stop > start)')
      call expect("&body inertia_table = 'test/inertia_table.csv'"//' / &initial angular_velocity = 0, 0, 1 / '// &
                  '&integrator time_step = 1, end_time = 11 /', 'end_time is outside of the table of the inertia')
      call expect("&body inertia_table = 'test/torque_table.csv'"//rest//' /', 'lacks the unit (kg m2) at its end')
      call expect('&body inertia = 2, 1.5, 1, mass_leaves = .true.'//rest//' /', 'mass_leaves')

   contains

      !> A scene is rejected with a message.
      subroutine expect(text, message)
         character(len=*), intent(in) :: text, message
         class(scene_t), allocatable :: scene
         type(status_t) :: status
         character(len=:), allocatable :: found
         allocate (scene)
         call parse_scene(text, 'scene.nml', scene, status, found)
         call check(error, .not. status%ok() .and. index(found, message) > 0, found//' is not: '//message)
      end subroutine expect

   end subroutine rejections

end module test_varying_inertia
