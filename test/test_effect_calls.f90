!> Evaluations of effects: absent effects are not evaluated, and others just as often as the solver requires.
submodule(suites_of_effects) test_effect_calls
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_long_long
   use nutate_effect, only: potential_t, torque_t
   use nutate_hamiltonian, only: body_momentum, make_state, system_t
   use nutate_kinds, only: wp
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_quaternion, only: cross
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate, run_summary_t
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_effect_samples, only: sample_body
   use test_support, only: check, error_type, new_unittest
   implicit none

   !> Quantities whose evaluations are counted.
   integer(c_int), parameter :: ENERGY = 1, GRADIENT = 2, HESSIAN = 3, DISCRETE_GRADIENT = 4, DISCRETE_HESSIAN = 5
   integer(c_int), parameter :: TORQUE = 6, DERIVATIVES = 7

   !> U = ½|γ - m|²ₖ, k = (1, 2, 3): supplies everything and counts its evaluations.
   type, extends(potential_t) :: counting_potential_t
   contains
      procedure :: energy => counted_energy
      procedure :: gradient => counted_gradient
      procedure :: hessian => counted_hessian
      procedure :: discrete_gradient => counted_discrete_gradient
      procedure :: discrete_hessian => counted_discrete_hessian
   end type counting_potential_t

   !> U = ½|γ - m|²ₖ, given by U and ∇U alone.
   type, extends(potential_t) :: counting_short_potential_t
   contains
      procedure :: energy => counted_short_energy
      procedure :: gradient => counted_short_gradient
   end type counting_short_potential_t

   !> τ = Ω×(1, 2, 3) - Ω/10.
   type, extends(torque_t) :: counting_torque_t
   contains
      procedure :: torque => counted_torque
      procedure :: derivatives => counted_derivatives
   end type counting_torque_t

   !> τ = 0, by a procedure.
   type, extends(torque_t) :: counting_nothing_t
   contains
      procedure :: torque => counted_nothing
   end type counting_nothing_t

   !> A pulse of 0.01 s about t = 50 s, about the first axis, with the impulse 0.005 N m s.
   type, extends(torque_t) :: pulse_t
   contains
      procedure :: torque => pulse_torque
   end type pulse_t

   interface
      !> Adds one to a counter. Not pure at all: this is what makes counting possible where the counted must be.
      pure subroutine count_call(which, zero) bind(c, name='test_count_call')
         import :: c_double, c_int
         integer(c_int), intent(in), value :: which
         !> Always 0. It must be used, or the call may be left out.
         real(c_double), intent(out) :: zero
      end subroutine count_call

      !> Sets all counters to 0.
      subroutine reset_counts() bind(c, name='test_reset_counts')
      end subroutine reset_counts

      !> The counters.
      subroutine read_counts(counts) bind(c, name='test_read_counts')
         import :: c_long_long
         integer(c_long_long), intent(out) :: counts(7)
      end subroutine read_counts
   end interface

   real(wp), parameter :: stiffness(3) = [1.0_wp, 2.0_wp, 3.0_wp], center(3) = [0.5_wp, -0.2_wp, 1.0_wp]
   integer, parameter :: n_steps = 50

contains

   module procedure collect_effect_calls
      testsuite = [ &
                  new_unittest("an absent effect is never evaluated", absent_effect_is_never_evaluated), &
                  new_unittest("a potential is evaluated as the iteration says", potential_is_evaluated_as_needed), &
                  new_unittest("a potential given by U and its gradient", short_potential_is_evaluated_as_needed), &
                  new_unittest("a torque is evaluated as the iteration says", torque_is_evaluated_as_needed), &
                  new_unittest("steps that end at limits of B-dot cost no more than sixteen", &
                               limits_are_found_cheaply), &
                  new_unittest("max_step finds a pulse that adaptive steps miss", pulse_is_found), &
                  new_unittest("one effect does not call for another", effects_are_evaluated_alone)]
   end procedure collect_effect_calls

   pure real(wp) function counted_energy(self, gamma)
      class(counting_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(c_double) :: zero
      call count_call(ENERGY, zero)
      counted_energy = zero + 0.5_wp*sum(stiffness*(gamma - center)**2)
   end function counted_energy

   pure function counted_gradient(self, gamma) result(slope)
      class(counting_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: slope(3)
      real(c_double) :: zero
      call count_call(GRADIENT, zero)
      slope = zero + stiffness*(gamma - center)
   end function counted_gradient

   pure function counted_hessian(self, gamma) result(matrix)
      class(counting_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: matrix(3, 3)
      real(c_double) :: zero
      call count_call(HESSIAN, zero)
      matrix = zero + curvature(1.0_wp)
   end function counted_hessian

   pure function counted_discrete_gradient(self, gamma0, gamma1) result(slope)
      class(counting_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: slope(3)
      real(c_double) :: zero
      call count_call(DISCRETE_GRADIENT, zero)
      slope = zero + stiffness*(0.5_wp*(gamma0 + gamma1) - center)
   end function counted_discrete_gradient

   pure function counted_discrete_hessian(self, gamma0, gamma1) result(matrix)
      class(counting_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: matrix(3, 3)
      real(c_double) :: zero
      call count_call(DISCRETE_HESSIAN, zero)
      matrix = zero + curvature(0.5_wp)
   end function counted_discrete_hessian

   pure function curvature(factor) result(matrix)
      real(wp), intent(in) :: factor
      real(wp) :: matrix(3, 3)
      integer :: i
      matrix = 0.0_wp
      do i = 1, 3
         matrix(i, i) = factor*stiffness(i)
      end do
   end function curvature

   pure real(wp) function counted_short_energy(self, gamma)
      class(counting_short_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(c_double) :: zero
      call count_call(ENERGY, zero)
      counted_short_energy = zero + 0.5_wp*sum(stiffness*(gamma - center)**2)
   end function counted_short_energy

   pure function counted_short_gradient(self, gamma) result(slope)
      class(counting_short_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: slope(3)
      real(c_double) :: zero
      call count_call(GRADIENT, zero)
      slope = zero + stiffness*(gamma - center)
   end function counted_short_gradient

   pure function counted_torque(self, t, q, omega) result(tau)
      class(counting_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      real(c_double) :: zero
      call count_call(TORQUE, zero)
      tau = zero + cross(omega, stiffness) - 0.1_wp*omega
   end function counted_torque

   pure function pulse_torque(self, t, q, omega) result(tau)
      class(pulse_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
      if (abs(t - 50.0_wp) < 0.005_wp) tau(1) = cos(200.0_wp*acos(0.0_wp)*(t - 50.0_wp))**2
   end function pulse_torque

   pure function counted_nothing(self, t, q, omega) result(tau)
      class(counting_nothing_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      real(c_double) :: zero
      call count_call(TORQUE, zero)
      tau = zero
   end function counted_nothing

   pure subroutine counted_derivatives(self, t, q, omega, by_rotation, by_rate)
      class(counting_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: by_rotation(3, 3), by_rate(3, 3)
      real(c_double) :: zero
      integer :: i
      call count_call(DERIVATIVES, zero)
      by_rotation = zero
      by_rate = 0.0_wp
      do i = 1, 3
         by_rate(i, i) = -0.1_wp
      end do
      by_rate(2, 1) = -stiffness(3)
      by_rate(3, 1) = stiffness(2)
      by_rate(1, 2) = stiffness(3)
      by_rate(3, 2) = -stiffness(1)
      by_rate(1, 3) = -stiffness(2)
      by_rate(2, 3) = stiffness(1)
   end subroutine counted_derivatives

   !> Performs the steps and counts iterations and calls. Every step converges fast, so that the unit of momentum is
   !> chosen once.
   subroutine run(error, system, iterations, counts)
      type(error_type), allocatable, intent(inout) :: error
      type(system_t), intent(in) :: system
      integer(c_long_long), intent(out) :: iterations, counts(7)
      type(nielsen_krenk_t) :: stepper
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      state = make_state(system, [0.5_wp, -0.5_wp, 0.1_wp, 0.7_wp], [0.7_wp, -1.1_wp, 0.9_wp])
      call stepper%prepare(system, integrator_settings_t(), status)
      iterations = 0
      call reset_counts()
      do i = 1, n_steps
         call stepper%step(system, state, 0.02_wp, status)
         call check(error, status%ok() .and. stepper%iterations <= 7, "slow convergence: "//trim(status%message))
         iterations = iterations + stepper%iterations
      end do
      call read_counts(counts)
   end subroutine run

   !> Neither an unforced body nor one with a rotor alone asks anything, though effects are lent to other bodies.
   subroutine absent_effect_is_never_evaluated(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: free
      type(system_t) :: forced
      integer(c_long_long) :: counts(7)
      integer(c_long_long) :: iterations
      free => sample_body()
      forced = free
      call forced%effects%add(counting_potential_t())
      call forced%effects%add(counting_torque_t())
      call run(error, free, iterations, counts)
      call check(error, all(counts == 0), "an absent effect was evaluated")
      call free%effects%add(rotor_t(momentum=[0.1_wp, 0.2_wp, 0.3_wp]))
      call run(error, free, iterations, counts)
      call check(error, all(counts == 0), "an absent effect was evaluated beside a rotor")
      call run(error, forced, iterations, counts)
      call check(error, counts(DISCRETE_GRADIENT) > 0 .and. counts(TORQUE) > 0, "the counters do not count")
   end subroutine absent_effect_is_never_evaluated

   !> The discrete gradient once per iteration, twice per Jacobian and once for the unit of momentum; its derivative
   !> once per Jacobian; U and ∇U themselves never.
   subroutine potential_is_evaluated_as_needed(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      integer(c_long_long) :: counts(7)
      integer(c_long_long) :: iterations
      system => sample_body()
      call system%effects%add(counting_potential_t())
      call run(error, system, iterations, counts)
      call check(error, counts(DISCRETE_GRADIENT) == iterations + 2*counts(DISCRETE_HESSIAN) + 1, "discrete gradient")
      call check(error, counts(DISCRETE_HESSIAN) >= 1 .and. counts(DISCRETE_HESSIAN) <= n_steps/10, &
                 "Jacobians are kept")
      call check(error, all(counts([ENERGY, GRADIENT, HESSIAN, TORQUE, DERIVATIVES]) == 0), "not needed")
   end subroutine potential_is_evaluated_as_needed

   !> U twice and ∇U once per discrete gradient where the ends differ; they coincide when the unit of momentum is
   !> chosen.
   subroutine short_potential_is_evaluated_as_needed(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      integer(c_long_long) :: counts(7)
      integer(c_long_long) :: iterations, jacobians
      system => sample_body()
      call system%effects%add(counting_short_potential_t())
      call run(error, system, iterations, counts)
      ! A Jacobian takes two discrete gradients and one derivative of such: U six times.
      call check(error, mod(counts(ENERGY) - 2*iterations, 6_c_long_long) == 0, "U")
      jacobians = (counts(ENERGY) - 2*iterations)/6
      call check(error, jacobians >= 1 .and. jacobians <= n_steps/10, "Jacobians are kept")
      ! ∇U in the Jacobian: two discrete gradients, six for second differences, two for the rest.
      call check(error, counts(GRADIENT) == iterations + 10*jacobians + 1, "gradient of U")
   end subroutine short_potential_is_evaluated_as_needed

   !> Once per iteration, once per Jacobian beside its derivatives, once for the unit of momentum, and once per step for
   !> the work.
   subroutine torque_is_evaluated_as_needed(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      integer(c_long_long) :: counts(7)
      integer(c_long_long) :: iterations
      system => sample_body()
      call system%effects%add(counting_torque_t())
      call run(error, system, iterations, counts)
      call check(error, counts(TORQUE) == iterations + counts(DERIVATIVES) + n_steps + 1, "torque")
      call check(error, counts(DERIVATIVES) >= 1 .and. counts(DERIVATIVES) <= n_steps/10, "Jacobians are kept")
      call check(error, all(counts(:DISCRETE_HESSIAN) == 0), "not needed")
   end subroutine torque_is_evaluated_as_needed

   !> Checks that a potential and a torque in one system are each evaluated as if alone.
   subroutine effects_are_evaluated_alone(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      integer(c_long_long) :: counts(7)
      integer(c_long_long) :: iterations
      system => sample_body()
      call system%effects%add(counting_potential_t())
      call system%effects%add(counting_torque_t())
      call run(error, system, iterations, counts)
      call check(error, counts(DERIVATIVES) == counts(DISCRETE_HESSIAN), "one linearisation for all")
      call check(error, counts(DISCRETE_GRADIENT) == iterations + 2*counts(DISCRETE_HESSIAN) + 1, "discrete gradient")
      call check(error, counts(TORQUE) == iterations + counts(DERIVATIVES) + n_steps + 1, "torque")
   end subroutine effects_are_evaluated_alone

   !> The three components of the moment come to their limits and leave them 13 times in a second.
   subroutine limits_are_found_cheaply(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=16), parameter :: methods(4) = [character(len=16) :: 'dop853', 'rk8', 'rk4', 'nielsen_krenk']
      type(run_summary_t) :: plain, limited
      integer(c_long_long) :: calls(2)
      integer :: i
      do i = 1, size(methods)
         call detumble(error, trim(methods(i)), '', plain, calls(1))
         call detumble(error, trim(methods(i)), ', limit = 0.2', limited, calls(2))
         if (allocated(error)) return
         call check(error, limited%parts - limited%steps >= 60, trim(methods(i))//': events end steps')
         call check(error, calls(2)/limited%parts <= 16*(calls(1)/plain%parts), trim(methods(i))//': cost of a step')
      end do
   end subroutine limits_are_found_cheaply

   !> Runs a satellite with magnetorquers for 5 s and counts the evaluations of the equations of motion.
   subroutine detumble(error, method, limit, summary, calls)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: method, limit
      type(run_summary_t), intent(out) :: summary
      integer(c_long_long), intent(out) :: calls
      character, parameter :: nl = new_line('a')
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      character(len=:), allocatable :: message
      integer(c_long_long) :: counts(7)
      allocate (scene)
      calls = 0
      call parse_scene('&body inertia = 0.042, 0.042, 0.0067 /'//nl//'&initial angular_velocity = 3*3.5 /'//nl// &
                       '&orbit altitude = 400e3, inclination = 51.6, degrees = .true. /'//nl//'&earth_field /'//nl// &
                       "&controller law = 'bdot', gain = 5e4"//limit//' /'//nl//"&integrator method = '"//method// &
                       "', local_tolerance = 1e-6, end_time = 5.0 /", 's.nml', scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      call scene%system%effects%add(counting_nothing_t())
      state = scene%initial
      call reset_counts()
      call integrate(scene%system, scene%integrator, state, scene%plan, status, summary=summary)
      call check(error, status%ok(), trim(status%message))
      call read_counts(counts)
      calls = counts(TORQUE)
   end subroutine detumble

   subroutine pulse_is_found(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=16), parameter :: methods(4) = [character(len=16) :: 'dop853', 'rk8', 'rk4', 'nielsen_krenk']
      real(wp) :: missed, found
      integer :: i
      do i = 1, size(methods)
         missed = momentum_behind(error, trim(methods(i)), '')
         found = momentum_behind(error, trim(methods(i)), ', max_step = 0.005')
         if (allocated(error)) return
         call check(error, abs(missed - 0.01_wp) <= 1e-14_wp, trim(methods(i))//': long steps miss the pulse')
         call check(error, abs(found - 0.015_wp) <= 1e-5_wp, trim(methods(i))//': the impulse')
      end do
   end subroutine pulse_is_found

   !> Returns L₁ of a sphere behind the pulse, N m s.
   real(wp) function momentum_behind(error, method, keys) result(momentum)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: method, keys
      character, parameter :: nl = new_line('a')
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: l(3)
      character(len=:), allocatable :: message
      allocate (scene)
      momentum = 0.0_wp
      call parse_scene('&body inertia = 1.0, 1.0, 1.0 /'//nl//'&initial angular_velocity = 0.01, 0.0, 0.0 /'//nl// &
                       "&integrator method = '"//method//"', local_tolerance = 1e-6, end_time = 100.0"//keys//' /', &
                       's.nml', scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      call scene%system%effects%add(pulse_t())
      state = scene%initial
      call integrate(scene%system, scene%integrator, state, scene%plan, status)
      call check(error, status%ok(), trim(status%message))
      l = body_momentum(state)
      momentum = l(1)
   end function momentum_behind

end submodule test_effect_calls
