!> Scales: the same motion in any units, from a molecule to a planet, and inputs beyond all of them.
module test_stability_scales
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: body_t, diagonal, make_body, make_shape_body
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_exact_free, only: free_body_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp, long
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: parse_scene, scene_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_BAD_SCENE, status_t
   use test_problems, only: body_momentum, make_state, new_problem, problem_t
   use test_stability_case, only: check_case, EVERY_WAY, record_t, stability_case_t, way_t
   use test_stability_meter, only: follow, meter_t
   use test_support, only: check, error_type, in_turn, new_unittest, unittest_type
   implicit none
   private

   public :: collect_stability_scales, scales_cases

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   !> Ways to choose the steps: one that suits the motion, one that must be subdivided, one by its error.
   integer, parameter :: SUITABLE = 1, LONG_STEPS = 2, CONTROLLED = 3

   !> Units of length, mass and time, in m, kg, s.
   type :: units_t
      real(wp) :: l = 1.0_wp, m = 1.0_wp, t = 1.0_wp
   end type units_t

contains

   subroutine collect_stability_scales(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("a water molecule in SI units", water_in_si_units), &
                  new_unittest("the Earth in SI units", earth_in_si_units), &
                  new_unittest("units of powers of two change no digit", units_change_no_digit), &
                  new_unittest("what is out of its range is refused", out_of_range_is_refused), &
                  new_unittest("bodies out of their ranges are refused", bodies_are_refused), &
                  new_unittest("scenes out of their ranges are refused", scenes_are_refused)]
   end subroutine collect_stability_scales

   !> The cases, for `make stress`.
   function scales_cases() result(cases)
      type(stability_case_t), allocatable :: cases(:)
      cases = [water_case(), earth_case(), units_case(), beyond_case()]
   end function scales_cases

   type(stability_case_t) function water_case() result(item)
      item%name = 'water molecule, SI units'
      item%guards = 'moments of 1e-47 kg m², steps of 1e-14 s: products that underflow, tolerances that '// &
                    'are not relative'
      item%selected = EVERY_WAY
      item%run => run_water
   end function water_case

   type(stability_case_t) function earth_case() result(item)
      item%name = 'Earth, SI units'
      item%guards = 'moments of 1e38 kg m², momentum of 1e34 kg m²/s beside quaternions of order one'
      item%selected = EVERY_WAY
      item%run => run_earth
   end function earth_case

   type(stability_case_t) function units_case() result(item)
      item%name = 'every effect in units of powers of two'
      item%guards = 'length, mass and time in units from 2^-70 to 2^100: no bit may change, in short, subdivided '// &
                    'and adaptive steps'
      item%selected = EVERY_WAY
      item%run => run_units
   end function units_case

   type(stability_case_t) function beyond_case() result(item)
      item%name = 'states, steps and effects out of their ranges'
      item%guards = 'numbers near overflow, denormal, not finite: an error before the first step, without a '// &
                    'floating-point exception'
      item%selected = EVERY_WAY
      item%run => run_beyond
   end function beyond_case

   subroutine water_in_si_units(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, water_case())
   end subroutine water_in_si_units

   subroutine earth_in_si_units(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, earth_case())
   end subroutine earth_in_si_units

   subroutine units_change_no_digit(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, units_case())
   end subroutine units_change_no_digit

   !> Free, against the closed solution, and as a dipole in a field.
   subroutine run_water(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      real(wp), parameter :: moments(3) = [1.022e-47_wp, 1.9187e-47_wp, 2.9407e-47_wp]
      real(wp), parameter :: omega(3) = [0.6e13_wp, 0.3e13_wp, 0.7e13_wp]
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      call record%require(status%ok(), trim(status%message))
      problem%start = make_state(problem%system, identity, omega)
      call compare_free(problem, way, 1e-14_wp, merge(100000_long, 500_long, whole), record)
      ! 1.85 debye in 1 V/nm, of the order of the kinetic energy.
      call problem%system%effects%add(dipole_t([6.17e-30_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 1e9_wp]))
      call follow(problem, way, 1e-14_wp, merge(1000000_long, 1000_long, whole), record)
      call record%require(.not. record%refused .and. record%subdivided_steps == 0, trim(record%outcome))
      call record%require_invariants(1e-11_wp)
   end subroutine run_water

   !> Free, against the closed solution, and under the gradient of the Moon's gravity.
   subroutine run_earth(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      real(wp), parameter :: moments(3) = [8.0101e37_wp, 8.0103e37_wp, 8.0365e37_wp]
      real(wp), parameter :: omega(3) = [1e-10_wp, 0.0_wp, 7.292115e-5_wp]
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      call record%require(status%ok(), trim(status%message))
      problem%start = make_state(problem%system, identity, omega)
      call compare_free(problem, way, 1800.0_wp, merge(100000_long, 500_long, whole), record)
      call problem%system%effects%add(gravity_gradient_t(problem%system%body, [0.9_wp, 0.0_wp, 0.4_wp], 8.6e-14_wp))
      call follow(problem, way, 1800.0_wp, merge(1000000_long, 1000_long, whole), record)
      call record%require(.not. record%refused .and. record%subdivided_steps == 0, trim(record%outcome))
      call record%require_invariants(1e-11_wp)
   end subroutine run_earth

   !> A free body against its closed solution: (Δt|Ω|)²/12 of the angle rotated, or next to nothing at order 8.
   subroutine compare_free(problem, way, dt, n, record)
      type(problem_t), intent(in) :: problem
      type(way_t), intent(in) :: way
      !> s
      real(wp), intent(in) :: dt
      integer(long), intent(in) :: n
      type(record_t), intent(inout) :: record
      type(free_body_t) :: exact
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: q(4), momentum(3), turn, distance
      call follow(problem, way, dt, n, record, state=state)
      call exact%prepare(problem%system%body%moments, problem%start%q, body_momentum(problem%start), status)
      call exact%evaluate(state%t, q, momentum)
      turn = dt*norm2(body_momentum(problem%start)/problem%system%body%moments)
      distance = attitude_distance(state%q, q)
      if (way%order == 2) then
         ! Order 2 makes the motion run slow; after many turns the angle says nothing.
         if (n*turn**3 < 1.0_wp) call record%require_below(distance, 0.2_wp*n*turn**3, 'attitude')
         call record%require(distance > 1e-3_wp*min(1.0_wp, n*turn**3), 'order 2 without an error')
      else
         call record%require_below(distance, 1e-6_wp*n*turn**9 + 1e-13_wp*n, 'attitude')
      end if
      call record%show('attitude error, rad', distance)
   end subroutine compare_free

   !> A body under every effect, twice of some kinds, in some units.
   function all_effects(u) result(problem)
      type(units_t), intent(in) :: u
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: energy, tensor(3, 3)
      problem => new_problem()
      energy = u%m*(u%l/u%t)**2
      tensor = reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3])
      call make_body((u%m*u%l**2)*tensor, problem%system%body, status, mass=2*u%m, &
                     center_of_mass=u%l*[0.3_wp, -0.2_wp, 0.5_wp])
      associate (effects => problem%system%effects)
         call effects%add(gravity_t(problem%system%body, (u%l/u%t**2)*[0.5_wp, 1.0_wp, -9.0_wp]))
         call effects%add(dipole_t(energy*[0.5_wp, -1.0_wp, 2.0_wp], [1.0_wp, 0.5_wp, -0.3_wp]))
         call effects%add(gravity_gradient_t(problem%system%body, [2.0_wp, 2.0_wp, -1.0_wp], 0.4_wp/u%t**2))
         call effects%add(spring_t(u%l*[0.4_wp, 0.1_wp, -0.6_wp], u%l*[0.5_wp, 1.0_wp, -0.8_wp], 5*(u%m/u%t**2), &
                                   0.7_wp*u%l))
         call effects%add(spring_t(u%l*[1.0_wp, 0.0_wp, 0.0_wp], u%l*[0.6_wp, 0.8_wp, 0.0_wp], 3*(u%m/u%t**2), &
                                   0.1_wp*u%l))
         call effects%add(damping_t((energy*u%t)*[0.03_wp, 0.01_wp, 0.02_wp]))
         call effects%add(applied_torque_t(name='torque', amplitude=energy*[1.0_wp, -0.4_wp, 1.6_wp], in_space=.true., &
                                           frequency=0.7_wp/u%t, phase=0.4_wp))
         call effects%add(applied_torque_t(name='torque', amplitude=energy*[-1.5_wp, 2.0_wp, 1.0_wp], &
                                           start=0.205_wp*u%t, stop=1.7_wp*u%t))
         call effects%add(rotor_t(name='rotor', momentum=(energy*u%t)*[0.5_wp, -1.0_wp, 2.0_wp]))
      end associate
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp], [0.7_wp, -1.1_wp, 0.9_wp]/u%t)
   end function all_effects

   subroutine run_units(way, whole, record)
      type(way_t), intent(in) :: way
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(run_summary_t) :: summary, expected
      type(state_t) :: state, reference
      type(units_t) :: u
      integer, parameter :: powers(3, 6) = reshape([40, 0, 0, 0, -70, 0, 0, 0, 53, 40, -30, 20, -60, -70, -50, &
                                                    31, 100, -33], [3, 6])
      integer :: i, kind
      do kind = SUITABLE, CONTROLLED
         call run_in_units(units_t(), way, kind, whole, record, reference, expected)
         do i = 1, size(powers, 2)
            if (.not. (whole .or. in_turn(i + kind))) cycle
            u = units_t(2.0_wp**powers(1, i), 2.0_wp**powers(2, i), 2.0_wp**powers(3, i))
            call run_in_units(u, way, kind, whole, record, state, summary)
            call record%require(all(state%q == reference%q) .and. state%t == u%t*reference%t .and. &
                                all(state%p == (u%m*u%l**2/u%t)*reference%p), 'a digit of the state changed')
            call record%require(all(summary%work == (u%m*(u%l/u%t)**2)*expected%work), 'a digit of the work changed')
            call record%require(summary%steps == expected%steps .and. summary%parts == expected%parts .and. &
                                summary%subdivided_steps == expected%subdivided_steps .and. &
                                summary%iterations == expected%iterations, 'other steps or iterations')
         end do
         if (kind == LONG_STEPS) &
            call record%require(expected%subdivided_steps > 0, 'the long steps were not subdivided')
      end do
      call record%require_below(max(record%energy, record%norm), 1e-11_wp, 'energy and norm')
      call record%show('units with identical bits', 6.0_wp)
   end subroutine run_units

   !> A run in some units.
   subroutine run_in_units(u, way, kind, whole, record, state, summary)
      type(units_t), intent(in) :: u
      type(way_t), intent(in) :: way
      !> `SUITABLE`, `LONG_STEPS` or `CONTROLLED`.
      integer, intent(in) :: kind
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(problem_t), pointer :: problem
      type(run_plan_t) :: plan
      type(meter_t) :: meter
      type(status_t) :: status
      class(stepper_t), allocatable :: stepper
      problem => all_effects(u)
      state = problem%start
      meter%inverse_j0 = way%inverse_j0(problem%system)
      plan%end_time = merge(200.0_wp, 10.0_wp, whole)*u%t
      if (kind == CONTROLLED) then
         plan%goal%local_tolerance = 1e-6_wp
      else
         plan%time_step = merge(0.02_wp, 10.0_wp, kind == SUITABLE)*u%t
      end if
      call integrate(problem%system, way%settings(problem%system), state, plan, status, meter, summary)
      call record%require(status%ok(), trim(status%message))
      record%steps = record%steps + summary%steps
      record%subdivided_steps = record%subdivided_steps + summary%subdivided_steps
      record%energy = max(record%energy, meter%invariants%energy_error())
      record%norm = max(record%norm, meter%invariants%norm_error)
   end subroutine run_in_units

   subroutine out_of_range_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_case(error, beyond_case())
   end subroutine out_of_range_is_refused

   !> A body with one thing wrong with its motion, its step, or an effect; and with none, which must go.
   subroutine run_beyond(way, whole, record)
      type(way_t), intent(in) :: way
      !> Makes no difference.
      logical, intent(in) :: whole
      type(record_t), intent(inout) :: record
      class(stepper_t), allocatable :: stepper
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      type(state_t) :: before
      type(status_t) :: status
      character(len=4) :: label
      real(wp) :: dt
      integer :: i
      problem => new_problem()
      do i = 0, 19
         call make_broken(i, problem, dt)
         write (label, '(i0)') i
         before = problem%start
         if (i == 0) settings = way%settings(problem%system)
         call make_stepper(problem%system, settings, stepper, status)
         if (status%ok()) call stepper%step(problem%system, problem%start, dt, status)
         if (i == 0) then
            call record%require(status%ok(), trim(status%message))
            record%steps = record%steps + 1
         else
            call record%require(any(status%code == [NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY]), 'accepted: '//label)
            call record%require(len_trim(status%message) > 0, 'no reason: '//label)
            call record%require(same_bits(before, problem%start), 'state touched: '//label)
         end if
      end do
      call record%show('of 19 inputs rejected', 19.0_wp)
   end subroutine run_beyond

   !> True if the states are the same to the last bit, numbers or not.
   pure logical function same_bits(a, b)
      type(state_t), intent(in) :: a, b
      same_bits = all(transfer([a%t, a%q, a%p], [0_long]) == transfer([b%t, b%q, b%p], [0_long]))
   end function same_bits

   !> The i-th mistake; 0: none.
   subroutine make_broken(i, problem, dt)
      integer, intent(in) :: i
      type(problem_t), intent(inout) :: problem
      !> s
      real(wp), intent(out) :: dt
      type(status_t) :: status
      real(wp) :: omega(3), nan, infinity
      problem = new_problem()
      nan = ieee_value(nan, ieee_quiet_nan)
      infinity = ieee_value(infinity, ieee_positive_inf)
      dt = 0.01_wp
      omega = [1.0_wp, 2.0_wp, 3.0_wp]
      if (i == 1) omega(1) = 1e200_wp
      if (i == 2) omega = huge(1.0_wp)
      if (i == 3) omega = 1e-310_wp
      if (i == 4) omega(2) = nan
      if (i == 5) omega(2) = infinity
      if (i == 6) dt = 1e300_wp
      if (i == 7) dt = 1e-310_wp
      if (i == 8) dt = 0.0_wp
      if (i == 9) dt = nan
      if (i == 10) dt = 1e10_wp
      if (i /= 11) call make_body(diagonal([1.0_wp, 2.0_wp, 2.5_wp]), problem%system%body, status, mass=1.0_wp, &
                                  center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      associate (effects => problem%system%effects, body => problem%system%body)
         if (i == 12) call effects%add(gravity_t(body, [0.0_wp, 0.0_wp, -1e308_wp]))
         if (i == 13) call effects%add(spring_t([1e200_wp, 0.0_wp, 0.0_wp], [0.0_wp, 1e200_wp, 0.0_wp], 1.0_wp, 1.0_wp))
         if (i == 14) call effects%add(damping_t([1e308_wp, 0.0_wp, nan]))
         if (i == 15) call effects%add(applied_torque_t(name='torque', amplitude=[1e308_wp, 0.0_wp, 0.0_wp]))
         if (i == 16) call effects%add(gravity_gradient_t(body, [1.0_wp, 0.0_wp, 1.0_wp], 1e308_wp))
         if (i == 17) call effects%add(dipole_t([1e80_wp, 0.0_wp, 1.0_wp], [0.0_wp, 1e80_wp, 0.0_wp]))
         if (i == 18) call effects%add(rotor_t(name='rotor', momentum=[1e308_wp, 0.0_wp, 0.0_wp]))
      end associate
      problem%start = make_state(problem%system, merge(0.0_wp, identity, i == 19), omega)
   end subroutine make_broken

   subroutine bodies_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: moments(5) = [1e-320_wp, 1e-309_wp, 1e-150_wp, 1e150_wp, 1.7e308_wp]
      real(wp), parameter :: lengths(4) = [1e-320_wp, 1e-200_wp, 1e150_wp, 1e308_wp]
      type(body_t) :: body
      type(status_t) :: status
      integer :: i
      do i = 1, size(moments)
         call make_body(diagonal(moments(i)*[1.0_wp, 1.0_wp, 1.0_wp]), body, status)
         call check(error, status%code, NUTATE_BAD_BODY, 'moments')
         call make_body(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), body, status, mass=moments(i))
         call check(error, status%code, NUTATE_BAD_ARGUMENT, 'mass')
         call make_shape_body('sphere', [1.0_wp], body, status, density=moments(i))
         call check(error, status%code, NUTATE_BAD_ARGUMENT, 'density')
      end do
      do i = 1, size(lengths)
         call make_shape_body('box', [1.0_wp, lengths(i), 1.0_wp], body, status, mass=1.0_wp)
         call check(error, status%code, NUTATE_BAD_ARGUMENT, 'length')
      end do
      call make_body(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), body, status, mass=1e90_wp, &
                     center_of_mass=[1e90_wp, 0.0_wp, 0.0_wp], about_center_of_mass=.true.)
      call check(error, status%code, NUTATE_BAD_BODY, 'moved moments')
   end subroutine bodies_are_refused

   subroutine scenes_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: groups(10) = [character(len=110) :: &
         '&gravity acceleration = 0, 0, 1e308 /', '&gravity acceleration = 0, 1e150, 0 /', &
         '&dipole moment = 1e200, 0, 0, field = 0, 1e200, 0 /', &
         '&gravity_gradient direction = 1, 0, 1, strength = 1e308 /', &
         '&spring body_point = 1e200, 0, 0, anchor = 0, 1e200, 0, stiffness = 1, rest_length = 1 /', &
         '&spring body_point = 1, 0, 0, anchor = 0, 1, 0, stiffness = 1e308 /', &
         '&damping coefficient = 1e308, 0, 0 /', &
         '&torque body = 1e308, 0, 0 /', '&rotor momentum = 1e308, 1e308, 0 /', &
         '&torque space = 1, 0, 0, frequency = 1e308 /']
      character(len=*), parameter :: rest = ' &body inertia = 1, 2, 2.5, mass = 1, center_of_mass = 0, 1, 1 / '// &
         '&initial angular_velocity = 1, 2, 3 / &integrator time_step = 0.01, end_time = 1 /'
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      integer :: i
      allocate (scene)
      do i = 1, size(groups)
         call parse_scene(trim(groups(i))//rest, 'scene.nml', scene, status, message)
         call check(error, status%code, NUTATE_BAD_SCENE, trim(groups(i)))
      end do
      call parse_scene('&gravity /'//rest, 'scene.nml', scene, status, message)
      call check(error, status%ok(), message)
   end subroutine scenes_are_refused

end module test_stability_scales
