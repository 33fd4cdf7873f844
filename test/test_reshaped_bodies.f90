!> Gravity on bodies that change: the gradient on a body whose inertia varies, weight on one whose centre of mass moves.
!> The oracle, the energy balance, orders, the same motion in two frames, sensitivities and rejections.
submodule(suites_of_effects) test_reshaped_bodies
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: make_body, symmetric
   use nutate_center_change, only: center_change_t, make_tabulated_center
   use nutate_damping, only: damping_t
   use nutate_rotor, only: rotor_t
   use nutate_event, only: EXTREMUM
   use nutate_event_list, only: event_list_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_inertia_change, only: inertia_change_t, make_tabulated_inertia
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_motion, only: find_motion, find_rates, motion_t
   use nutate_orbit, only: orbit_t
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_quaternion, only: quat_conjugate, quat_product, rotate_to_body
   use nutate_run, only: run_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tangent, only: tangent_t
   use nutate_variation, only: attitude_variation, inertia_variation, rate_variation, variation_t
   use test_event_support, only: rate_event_t
   use test_oracle, only: find_true_attitude, has_oracle, qp, true_distance
   use test_problems, only: angular_velocity, body_momentum, conserved_energy, inertia_at, make_state, new_problem, &
      potential_energy, problem_t, space_momentum, system_t, time_dependent_power, total_energy
   use test_resume, only: check_balance, check_stepper, label_of, run_steps, settings_of
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest, random_unit, &
      random_unit_quaternion, random_vector, skip_test
   implicit none

   !> Inertia at t = 0, kg m²: 11, 22, 33, 12, 13, 23.
   real(wp), parameter :: first_inertia(6) = [2.0_wp, 1.5_wp, 1.0_wp, 0.1_wp, 0.2_wp, -0.05_wp]
   !> Gravity in which a body of 1 kg m² swings in some seconds: μ, m³/s², and semi-major axis, m, of an orbit of mean
   !> motion 0.7 rad/s.
   real(wp), parameter :: mu = 0.49_wp*343.0_wp, axis = 7.0_wp
   !> Potentials that act: the gradient of a fixed direction, that along an orbit, weight about a pivot, the gradient on
   !> a circle in LVLH axes.
   integer, parameter :: FIXED = 1, ON_ORBIT = 2, WEIGHT = 3, IN_LVLH = 4
   !> Parameters by which problems move: rate and attitude of the start; inertia, its change with time, mass and centre
   !> of mass; strength and direction of gravity; the stop of a rate of the inertia.
   integer, parameter :: n_parts = 9
   real(wp), parameter :: unmoved(n_parts) = 0.0_wp
   !> Changes of a rate of the inertia, kg m²/s, of the centre of mass, m, and of a direction, per unit of its
   !> parameter.
   real(wp), parameter :: tensor_change(6) = [0.2_wp, 1.0_wp, -0.3_wp, 0.5_wp, 0.1_wp, -0.4_wp], &
      center_change(3) = [0.3_wp, -0.5_wp, 0.2_wp], direction_change(3) = [0.4_wp, 1.0_wp, -0.7_wp]
   !> Mass, kg.
   real(wp), parameter :: mass = 2.0_wp
   !> Five-point differences: points in steps, step, and weights.
   real(wp), parameter :: places(4) = [-2.0_wp, -1.0_wp, 1.0_wp, 2.0_wp], h = 2e-3_wp, &
      weights(4) = [1.0_wp, -8.0_wp, 8.0_wp, -1.0_wp]/(12*h)

contains

   module procedure collect_reshaped_bodies
      testsuite = [ &
                  new_unittest("random motions as by the oracle", random_motions), &
                  new_unittest("orders 2, 4 and 6", orders), &
                  new_unittest("energy to round-off over many steps", balance), &
                  new_unittest("the work of the dependence on time by every method, and as its power", same_work), &
                  new_unittest("a circular orbit in inertial and in LVLH axes", both_axes), &
                  new_unittest("power and rates of a motion by differences", rates_of_motion), &
                  new_unittest("a sphere that grows feels no torque", growing_sphere), &
                  new_unittest("a centre of mass that rises: work = m g h", rising_center), &
                  new_unittest("sensitivities as by differences of the same steps", sensitivities), &
                  new_unittest("sensitivities as by the oracle", true_sensitivities), &
                  new_unittest("the time of an extremum has the derivatives of differences", times_of_extremes), &
                  new_unittest("steppers go on bit for bit", steppers_go_on)]
   end procedure collect_reshaped_bodies

   !> Random changes of the body under gravity.
   subroutine make_random(seed, kind, problem, part)
      integer(int64), intent(inout) :: seed
      integer, intent(in) :: kind
      type(problem_t), intent(inout) :: problem
      !> By how much each parameter is moved; default: not at all.
      real(wp), intent(in), optional :: part(n_parts)
      real(wp), parameter :: times(5) = [-0.1_wp, 0.7_wp, 1.2_wp, 2.9_wp, 5.0_wp]
      type(inertia_change_t) :: change
      type(center_change_t) :: path
      type(status_t) :: status
      real(wp) :: tensors(6, 5), centers(3, 5), window(2), center(3), moved(n_parts), q(4), first(6)
      integer :: i, at
      problem = new_problem()
      moved = unmoved
      if (present(part)) moved = part
      first = [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, moved(3), 0.0_wp]
      do i = 1, 5
         centers(:, i) = 0.4_wp*random_vector(seed)
         tensors(:, i) = first_inertia + 0.1_wp*[random_vector(seed), 0.3_wp*random_vector(seed)]
      end do
      call make_tabulated_center(times, centers, path, status, at, spline=random_unit(seed) < 0.5_wp)
      if (.not. status%ok()) error stop 'the path is none'
      center = path%center_at(0.0_wp) + moved(6)*center_change
      associate (body => problem%system%body)
         if (random_unit(seed) < 0.6_wp) then
            call make_tabulated_inertia(times, tensors, change, status, at, spline=random_unit(seed) < 0.5_wp, &
                                        mass_leaves=random_unit(seed) < 0.5_wp, scale=1.1_wp + moved(4))
            if (.not. status%ok()) error stop 'the table is none'
            call make_body((1.1_wp + moved(4))*change%tabulated_at(0.0_wp) + symmetric(first), body, status, &
                           mass=mass + moved(5), center_of_mass=center, check_triangle=.false.)
         else
            window = 0.1_wp + [3*random_unit(seed), 3*random_unit(seed)]
            change = inertia_change_t(0.1_wp*[random_vector(seed), 0.3_wp*random_vector(seed)] + &
                                      moved(4)*tensor_change, minval(window), maxval(window) + 0.5_wp + moved(9), &
                                      random_unit(seed) < 0.5_wp)
            call make_body(symmetric(first_inertia + first), body, status, mass=mass + moved(5), &
                           center_of_mass=center, check_triangle=.false.)
         end if
      end associate
      if (.not. status%ok()) error stop 'the body is none'
      call add_effects(seed, kind, change, path, moved, problem)
      q = quat_product(random_unit_quaternion(seed), [cos(0.5_wp*moved(2)), sin(0.5_wp*moved(2)), 0.0_wp, 0.0_wp])
      problem%start = make_state(problem%system, q, random_vector(seed) + [0.0_wp, moved(1), 0.0_wp])
   end subroutine make_random

   !> Adds the changes of the body, and what acts on it: the order does not matter.
   subroutine add_effects(seed, kind, change, path, moved, problem)
      integer(int64), intent(inout) :: seed
      integer, intent(in) :: kind
      type(inertia_change_t), intent(in) :: change
      type(center_change_t), intent(in) :: path
      real(wp), intent(in) :: moved(n_parts)
      type(problem_t), intent(inout) :: problem
      type(orbit_t) :: orbit
      real(wp) :: random(4)
      logical :: changes_first, moves
      changes_first = random_unit(seed) < 0.5_wp
      associate (effects => problem%system%effects, body => problem%system%body)
         if (changes_first) call effects%add(path)
         select case (kind)
         case (FIXED)
            call effects%add(gravity_gradient_t(body, random_vector(seed) + moved(8)*direction_change, &
                                                0.7_wp + moved(7)))
         case (ON_ORBIT, IN_LVLH)
            random = [random_unit(seed), random_unit(seed), random_unit(seed), 0.0_wp]
            if (kind == IN_LVLH) random(1) = 0.0_wp
            orbit = orbit_t(kepler_orbit_t(semi_major_axis=axis*(1 + moved(8)), eccentricity=0.4_wp*random(1), &
                                           inclination=random(2) + moved(8), mean_anomaly=6*random(3), &
                                           mu=mu*(1 + moved(7))), inertial=kind == ON_ORBIT)
            call effects%add(orbit)
            if (kind == ON_ORBIT) call effects%add(orbital_gradient_t(body, orbit%path))
            if (kind == IN_LVLH) call effects%add(gravity_gradient_t(body, orbit))
         case default
            call effects%add(gravity_t(body, 2*(1 + moved(7))*random_vector(seed) + moved(8)*direction_change))
         end select
         if (.not. changes_first) call effects%add(path)
         moves = kind /= WEIGHT
         if (.not. moves) moves = random_unit(seed) < 0.5_wp
         if (moves) call effects%add(change)
         if (random_unit(seed) < 0.5_wp) call effects%add(damping_t(0.1_wp*abs(random_vector(seed))))
         if (random_unit(seed) < 0.5_wp) call effects%add(rotor_t(name='rotor', momentum=0.3_wp*random_vector(seed)))
      end associate
   end subroutine add_effects

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
      seed = 57_int64
      do number = 1, 24
         call make_random(seed, merge(FIXED, WEIGHT, modulo(number/3, 2) == 0), problem)
         if (.not. in_turn(number)) cycle
         call find_true_attitude(problem%system, problem%start, 4.0_wp, q, 1e-20_qp)
         do i = 1, size(methods)
            if (methods(i)%order < 8 .or. methods(i)%name == 'exact') cycle
            if (modulo(i + number/6, 2) == 0) cycle
            call run_steps(error, problem, settings_of(methods(i)), 0.02_wp, 4.0_wp, state, label_of(methods(i)))
            call check_below(error, true_distance(q, state%q), 1e-12_wp, label_of(methods(i)))
         end do
         if (allocated(error)) return
      end do
   end subroutine random_motions

   !> Half the step divides the error by two to the power of the order.
   subroutine orders(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: expected, last
      integer(int64) :: seed
      real(wp) :: errors(2), step
      integer :: i, n, number
      problem => new_problem()
      seed = 2012_int64
      do number = FIXED, WEIGHT
         call make_random(seed, number, problem)
         call run_steps(error, problem, integrator_settings_t(method='dop853', order=8), 0.005_wp, 2.5_wp, expected, &
                        'dop853')
         do i = 1, size(methods)
            if (methods(i)%order > 6 .or. methods(i)%name == 'exact') cycle
            do n = 1, 2
               step = 0.1_wp/n
               if (methods(i)%order == 6) step = 0.2_wp/n
               call run_steps(error, problem, settings_of(methods(i)), step, 2.5_wp, last, label_of(methods(i)))
               errors(n) = norm2(last%q - expected%q)
            end do
            call check_close(error, log(errors(1)/errors(2))/log(2.0_wp), real(methods(i)%order, wp), 0.5_wp, &
                             label_of(methods(i)))
         end do
      end do
   end subroutine orders

   !> Energy less works of conserving methods with long steps.
   subroutine balance(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      integer(int64) :: seed
      integer :: i, number
      problem => new_problem()
      seed = 4712_int64
      do number = 1, 6
         call make_random(seed, 1 + modulo(number, 3), problem)
         do i = 1, size(methods)
            if (methods(i)%name == 'exact' .or. .not. methods(i)%conserving .or. .not. in_turn(i + number)) cycle
            call check_balance(error, problem, methods(i), state)
            if (allocated(error)) return
         end do
      end do
   end subroutine balance

   !> All methods book the same work: that of the changes of the inertia at fixed momentum and of the potentials, by
   !> Simpson's rule between the breaks of the inertia.
   subroutine same_work(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state, first
      integer(int64) :: seed
      integer :: i, number
      problem => new_problem()
      seed = 816_int64
      do number = FIXED, WEIGHT
         call make_random(seed, number, problem)
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

   !> A boom deploys on a circular orbit: with masses that stay, and that leave.
   subroutine both_axes(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t) :: problems(2)
      type(state_t) :: states(2)
      type(kepler_orbit_t) :: path
      type(orbit_t) :: orbit
      type(status_t) :: status
      real(wp) :: q(4), energy
      integer :: i, m, n
      path = kepler_orbit_t(semi_major_axis=axis, inclination=0.4_wp, mean_anomaly=1.0_wp, mu=mu)
      do n = 1, 2
         do m = 1, 2
            problems(m) = new_problem()
            orbit = orbit_t(path, inertial=m == 1)
            associate (system => problems(m)%system)
               call make_body(symmetric(first_inertia), system%body, status)
               call system%effects%add(orbit)
               call system%effects%add(inertia_change_t([0.2_wp, 0.15_wp, 0.02_wp, 0.01_wp, 0.0_wp, 0.03_wp], &
                                                        start=0.5_wp, stop=3.0_wp, mass_leaves=n == 2))
               if (m == 1) then
                  call system%effects%add(orbital_gradient_t(system%body, path))
               else
                  call system%effects%add(gravity_gradient_t(system%body, orbit))
               end if
               q = [0.8_wp, 0.36_wp, 0.48_wp, 0.0_wp]
               if (m == 1) q = quat_product(path%axes(0.0_wp), q)
               problems(m)%start = make_state(system, q, [0.3_wp, -0.5_wp, 0.8_wp])
            end associate
         end do
         do i = 1, size(methods)
            if (methods(i)%order < 8 .or. methods(i)%name == 'exact') cycle
            do m = 1, 2
               call run_steps(error, problems(m), settings_of(methods(i)), 0.02_wp, 4.0_wp, states(m), &
                              label_of(methods(i)))
            end do
            q = quat_product(path%axes(4.0_wp), states(2)%q)
            call check_close(error, sign(1.0_wp, dot_product(q, states(1)%q))*q, states(1)%q, 2e-12_wp, &
                             label_of(methods(i)))
            if (.not. methods(i)%conserving .or. n == 2) cycle
            energy = conserved_energy(problems(2)%system, states(2)) - states(2)%time_dependent_work
            call check_close(error, energy, conserved_energy(problems(2)%system, problems(2)%start), 100*eps, &
                             label_of(methods(i))//", Jacobi's integral")
         end do
      end do
   end subroutine both_axes

   !> ∂V/∂t at fixed attitude, and Ω̇.
   subroutine rates_of_motion(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1e-3_wp, t = 0.9_wp
      type(problem_t), pointer :: problem
      type(state_t) :: middle, states(2)
      type(motion_t) :: motion
      integer(int64) :: seed
      integer :: number, i
      problem => new_problem()
      seed = 42_int64
      do number = 1, 6
         call make_random(seed, 1 + modulo(number, 3), problem)
         call run_steps(error, problem, integrator_settings_t(order=8, formulation="reduced"), 0.02_wp, t, middle, &
                        "start")
         problem%start = middle
         do i = 1, 2
            call run_steps(error, problem, integrator_settings_t(order=8, formulation="reduced"), h*(2*i - 3), &
                           t + h*(2*i - 3), states(i), "h")
         end do
         call find_motion(problem%system, middle, motion)
         call find_rates(problem%system, t, motion)
         call check_close(error, motion%acceleration, (angular_velocity(problem%system, states(2)) - &
                          angular_velocity(problem%system, states(1)))/(2*h), 2e-5_wp, 'acceleration')
         associate (effects => problem%system%effects, q => middle%q)
            call check_close(error, time_dependent_power(effects, q, t), (potential_energy(effects, q, t + h) - &
                             potential_energy(effects, q, t - h))/(2*h), 2e-5_wp, 'power')
         end associate
      end do
   end subroutine rates_of_motion

   !> Equal moments at all times: torque-free at any step, with the work of the gradient's isotropic part.
   subroutine growing_sphere(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(kepler_orbit_t) :: path
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: moments(3, 3), momentum(3), work, energy
      integer :: i, n
      problem => new_problem()
      call make_body(symmetric([1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]), problem%system%body, status)
      call problem%system%effects%add(inertia_change_t([0.1_wp, 0.1_wp, 0.1_wp]))
      path = kepler_orbit_t(semi_major_axis=axis, eccentricity=0.3_wp, mu=mu)
      call problem%system%effects%add(orbital_gradient_t(problem%system%body, path))
      problem%start = make_state(problem%system, [0.5_wp, 0.1_wp, -0.7_wp, 0.5_wp], [0.3_wp, 1.0_wp, -0.4_wp])
      momentum = space_momentum(problem%start)
      energy = total_energy(problem%system, problem%start)
      do i = 1, size(methods)
         if (methods(i)%name == 'exact' .or. .not. methods(i)%conserving) cycle
         call make_stepper(problem%system, settings_of(methods(i)), stepper, status)
         state = problem%start
         work = 0.0_wp
         do n = 1, 20
            if (status%ok()) call stepper%step(problem%system, state, 0.4_wp, status)
            work = work + sum(stepper%work)
         end do
         call check(error, status%ok(), trim(status%message))
         moments = inertia_at(problem%system, state%t)
         call check_close(error, space_momentum(state), momentum, 40*eps, label_of(methods(i)))
         call check_close(error, rotate_to_body(state%q, momentum)/moments(1, 1), &
                          angular_velocity(problem%system, state), 40*eps, label_of(methods(i)))
         call check_close(error, total_energy(problem%system, state) - work, energy, 100*eps, label_of(methods(i)))
      end do
   end subroutine growing_sphere

   !> A top spins upright, and its centre of mass rises along its axis, which does not tilt: the work is m g h, and the
   !> momentum along the vertical stays. Beside it hangs a body at rest, whose centre of mass moves up to the pivot.
   subroutine rising_center(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: times(3) = [0.0_wp, 1.0_wp, 3.0_wp], mass = 2.0_wp, g = 9.81_wp, &
         heights(3, 2) = reshape([0.1_wp, 0.3_wp, 0.4_wp, -0.5_wp, -0.2_wp, 0.0_wp], [3, 2])
      type(center_change_t) :: path
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      real(wp) :: centers(3, 3), momentum(3), work
      integer :: at, i, k, n
      do k = 1, 2
         centers = 0.0_wp
         centers(3, :) = heights(:, k)
         call make_tabulated_center(times, centers, path, status, at)
         problem => new_problem()
         call make_body(symmetric([2.0_wp, 2.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]), problem%system%body, status, &
                        mass=mass, center_of_mass=path%center_at(0.0_wp))
         call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -g]))
         call problem%system%effects%add(path)
         problem%start = make_state(problem%system, [0.6_wp, 0.0_wp, 0.0_wp, 0.8_wp], &
                                    [0.0_wp, 0.0_wp, merge(30.0_wp, 0.0_wp, k == 1)])
         momentum = space_momentum(problem%start)
         do i = 1, size(methods)
            if (methods(i)%name == 'exact') cycle
            call make_stepper(problem%system, settings_of(methods(i)), stepper, status)
            state = problem%start
            work = 0.0_wp
            do n = 1, 30
               if (status%ok()) call stepper%step(problem%system, state, 0.1_wp, status)
               work = work + sum(stepper%work)
            end do
            call check(error, status%ok(), label_of(methods(i))//': '//trim(status%message))
            call check_close(error, work, mass*g*(heights(3, k) - heights(1, k)), 200*eps, label_of(methods(i)))
            call check_close(error, space_momentum(state), momentum, 200*eps, label_of(methods(i)))
         end do
      end do
   end subroutine rising_center

   !> Sensitivities of unprojected steps, by five-point differences of the same steps: by the initial state, the body,
   !> its changes and gravity.
   subroutine sensitivities(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem, moved
      type(integrator_settings_t) :: settings
      type(variation_t), allocatable :: variations(:)
      type(tangent_t) :: tangent
      type(state_t) :: last, state
      real(wp) :: theta(3), momentum(3), turn(4), part(n_parts)
      integer(int64) :: seed
      integer :: number, i, k, m
      problem => new_problem()
      moved => new_problem()
      do number = 1, 12
         seed = 31416_int64 + 17*number
         call make_random(seed, 1 + modulo(number, 4), problem)
         call list_variations(problem%system, variations, error)
         do i = 1, size(methods)
            if (methods(i)%name == 'exact' .or. methods(i)%projected .or. .not. in_turn(i + number)) cycle
            settings = settings_of(methods(i))
            settings%conserve = .false.
            settings%in_space_axes = .true.
            tangent = tangent_t()
            call follow(problem, last, tangent)
            ! Steps do not end at the stop of a rate.
            do k = 1, n_parts - 1
               if (is_absent(variations(k), k) .or. .not. in_turn(k + (i + number)/3)) cycle
               theta = 0.0_wp
               momentum = 0.0_wp
               do m = 1, size(places)
                  seed = 31416_int64 + 17*number
                  part = 0.0_wp
                  part(k) = h*places(m)
                  call make_random(seed, 1 + modulo(number, 4), moved, part)
                  call follow(moved, state)
                  turn = quat_product(quat_conjugate(last%q), state%q)
                  theta = theta + (2*weights(m))*turn(2:4)
                  momentum = momentum + weights(m)*body_momentum(state)
               end do
               if (allocated(error)) return
               call check_close(error, tangent%theta(k, :), theta, 2e-8_wp, &
                                label_of(methods(i))//', theta of '//trim(variations(k)%name))
               call check_close(error, tangent%momentum(k, :), momentum, 2e-8_wp, &
                                label_of(methods(i))//', L of '//trim(variations(k)%name))
            end do
         end do
      end do

   contains

      !> The state after some steps, and its sensitivities.
      subroutine follow(problem, state, tangent)
         type(problem_t), intent(in) :: problem
         type(state_t), intent(out) :: state
         type(tangent_t), intent(inout), optional :: tangent
         class(stepper_t), allocatable :: stepper
         type(state_t) :: before
         type(status_t) :: status
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
         call check(error, status%ok(), trim(status%message))
      end subroutine follow

   end subroutine sensitivities

   !> Sensitivities of runs by five-point differences of the oracle.
   subroutine true_sensitivities(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem, moved
      type(variation_t), allocatable :: variations(:)
      class(run_t), allocatable :: run
      type(status_t) :: status
      real(qp) :: q(4, 0:4), theta(3, n_parts)
      !> Short, since the oracle has more digits: with this error of its steps the differences have one of 1e-12.
      real(wp), parameter :: step = 1e-4_wp
      real(qp), parameter :: tolerance = 1e-18_qp
      real(wp) :: part(n_parts)
      integer(int64) :: seed, start
      integer :: number, i, k, m
      problem => new_problem()
      moved => new_problem()
      if (.not. has_oracle) then
         call skip_test(error, 'the compiler has no quadruple precision')
         return
      end if
      allocate (run)
      start = 271828_int64
      do number = 1, 6
         start = start + 1
         seed = start
         call make_random(seed, merge(FIXED, WEIGHT, modulo(number, 2) == 0), problem)
         call list_variations(problem%system, variations, error)
         if (allocated(error)) return
         call find_true_attitude(problem%system, problem%start, 4.0_wp, q(:, 0), tolerance)
         do k = 1, n_parts
            if (is_absent(variations(k), k) .or. .not. in_turn(k + number)) cycle
            do m = 1, 4
               seed = start
               part = unmoved
               part(k) = step*places(m)
               call make_random(seed, merge(FIXED, WEIGHT, modulo(number, 2) == 0), moved, part)
               call find_true_attitude(moved%system, moved%start, 4.0_wp, q(:, m), tolerance)
            end do
            associate (a => q(:, 0), b => matmul(q(:, 1:4), real(weights*h/step, qp)))
               theta(:, k) = 2*(a(1)*b(2:4) - b(1)*a(2:4) - [a(3)*b(4) - a(4)*b(3), a(4)*b(2) - a(2)*b(4), &
                                                             a(2)*b(3) - a(3)*b(2)])
            end associate
         end do
         do i = 1, size(methods)
            if (methods(i)%order < 8 .or. methods(i)%name == 'exact' .or. .not. in_turn(i + number)) cycle
            call run%begin(problem%system, settings_of(methods(i)), problem%start, &
                           run_plan_t(time_step=0.02_wp, end_time=4.0_wp), status)
            if (status%ok()) call run%differentiate(variations, problem%system, status)
            if (status%ok()) call run%run_to_end(problem%system, status)
            call check(error, status%ok(), label_of(methods(i))//': '//trim(status%message))
            do k = 1, n_parts
               if (is_absent(variations(k), k) .or. .not. in_turn(k + number)) cycle
               call check_close(error, run%tangent%theta(k, :), real(theta(:, k), wp), 1e-9_wp, &
                                label_of(methods(i))//', theta of '//trim(variations(k)%name))
            end do
         end do
      end do
   end subroutine true_sensitivities

   !> The last extremum of Ω₁ in a run: its time depends on the torque there, and thus on all parameters once more.
   subroutine times_of_extremes(error)
      type(error_type), allocatable, intent(out) :: error
      !> Differences of order 6: an extremum that is about to vanish moves in proportion to a root of the parameter.
      real(wp), parameter :: step = 2e-5_wp, slopes(3) = [45.0_wp, -9.0_wp, 1.0_wp]/(60*step)
      type(problem_t), pointer :: problem
      type(variation_t), allocatable :: variations(:)
      real(wp) :: part(n_parts), time, moved(2), change(n_parts), expected
      integer(int64) :: seed, start
      integer :: number, k, m
      problem => new_problem()
      start = 141421_int64
      do number = 1, 8
         start = start + 1
         seed = start
         call make_random(seed, 1 + modulo(number, 4), problem)
         call list_variations(problem%system, variations, error)
         call find_extremum(time, change)
         if (allocated(error)) return
         call check(error, time > 0.0_wp, 'there is an extremum')
         do k = 1, n_parts
            if (is_absent(variations(k), k) .or. .not. in_turn(k + number)) cycle
            expected = 0.0_wp
            do m = 1, 3
               part = unmoved
               part(k) = m*step
               call move(moved(1))
               part(k) = -m*step
               call move(moved(2))
               expected = expected + slopes(m)*(moved(1) - moved(2))
            end do
            call check_close(error, change(k), expected, 1e-8_wp*max(1.0_wp, abs(expected)), trim(variations(k)%name))
         end do
      end do

   contains

      !> Finds the extremum with the changed parameters.
      subroutine move(time)
         real(wp), intent(out) :: time
         seed = start
         call make_random(seed, 1 + modulo(number, 4), problem, part)
         call find_extremum(time)
      end subroutine move

      !> Finds the time of the last extremum, 0 if there is none, and its derivatives.
      subroutine find_extremum(time, change)
         real(wp), intent(out) :: time
         real(wp), intent(out), optional :: change(n_parts)
         class(run_t), allocatable :: run
         type(event_list_t) :: events
         type(status_t) :: status
         type(integrator_settings_t) :: settings
         allocate (run)
         settings = integrator_settings_t(method='dop853', in_space_axes=.true.)
         call events%add(rate_event_t(name='extremum', kind=EXTREMUM, axis=1))
         call run%begin(problem%system, settings, problem%start, run_plan_t(time_step=0.02_wp, end_time=4.5_wp), status)
         if (status%ok()) call run%set_events(events, problem%system, status)
         if (status%ok() .and. present(change)) call run%differentiate(variations, problem%system, status)
         if (status%ok()) call run%run_to_end(problem%system, status)
         call check(error, status%ok(), trim(status%message))
         time = run%events%watched(1)%last_time
         if (present(change)) change = run%events%watched(1)%time_change
      end subroutine find_extremum

   end subroutine times_of_extremes

   !> Returns true for a change of the inertia that the problem lacks.
   pure logical function is_absent(variation, k)
      type(variation_t), intent(in) :: variation
      integer, intent(in) :: k
      is_absent = any(k == [4, 9]) .and. .not. (allocated(variation%effects) .or. allocated(variation%windows))
   end function is_absent

   !> Lists a variation for each component of `part` of `make_random`.
   subroutine list_variations(system, variations, error)
      type(system_t), intent(in) :: system
      type(variation_t), allocatable, intent(out) :: variations(:)
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status(5)
      character(len=24) :: gravity
      integer :: i
      allocate (variations(n_parts))
      variations(1) = rate_variation(2)
      variations(2) = attitude_variation(1)
      variations(3) = inertia_variation(1, 3)
      gravity = system%effects%potentials(1)%item%name
      associate (effects => system%effects)
         variations(4)%name = 'change of the inertia'
         variations(9)%name = 'stop'
         do i = 1, effects%n_torques
            select case (effects%torques(i)%item%name)
            case ('inertia_rate')
               call variations(4)%add(effects, 'inertia_rate', 1, 'tensor', tensor_change, status(1))
               call variations(9)%add(effects, 'inertia_rate', 1, 'stop', [1.0_wp], status(5))
            case ('inertia_table')
               call variations(4)%add(effects, 'inertia_table', 1, 'inertia_scale', [1.0_wp], status(1))
            case default
            end select
         end do
         variations(5)%name = 'mass'
         variations(5)%mass = 1.0_wp
         variations(5)%mass_moment = system%body%center_of_mass
         variations(6)%name = 'centre of mass'
         variations(6)%mass_moment = mass*center_change
         variations(7)%name = 'strength'
         variations(8)%name = 'direction'
         if (effects%on_orbit) then
            call variations(7)%add(effects, 'orbit', 1, 'mu', [mu], status(2))
            call variations(8)%add(effects, 'orbit', 1, 'inclination', [1.0_wp], status(3))
            call variations(8)%add(effects, 'orbit', 1, 'semi_major_axis', [axis], status(4))
         else if (gravity == 'gravity') then
            call variations(7)%add(effects, trim(gravity), 1, 'acceleration', effects%potentials(1)%item%direction, &
                                   status(2))
            call variations(8)%add(effects, trim(gravity), 1, 'acceleration', direction_change, status(3))
         else
            call variations(7)%add(effects, trim(gravity), 1, 'strength', [1.0_wp], status(2))
            call variations(8)%add(effects, trim(gravity), 1, 'direction', direction_change, status(3))
         end if
      end associate
      call check(error, all([(status(i)%ok(), i=1, 5)]), 'there are the parameters')
   end subroutine list_variations

   subroutine steppers_go_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      integer(int64) :: seed
      integer :: i
      problem => new_problem()
      seed = 99_int64
      call make_random(seed, ON_ORBIT, problem)
      do i = 1, size(methods)
         if (methods(i)%name == 'exact') cycle
         call check_stepper(error, problem, settings_of(methods(i)), spread(0.05_wp, 1, 7), &
                            [0.05_wp, 0.05_wp, 0.03_wp, 0.03_wp, 0.05_wp], label_of(methods(i)))
      end do
   end subroutine steppers_go_on

end submodule test_reshaped_bodies
