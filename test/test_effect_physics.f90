!> Potentials against results that are independent of this code: closed forms, and other bodies.
submodule(suites_of_effects) test_effect_physics
   use nutate_body, only: diagonal, make_body
   use nutate_dipole, only: dipole_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kinds, only: wp, pi
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_effect_samples, only: sample_body, spinner
   use test_problems, only: make_state, new_problem, problem_t, solve, space_momentum
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

contains

   module procedure collect_effect_physics
      testsuite = [ &
                  new_unittest("gravity swings a pendulum", gravity_swings_a_pendulum), &
                  new_unittest("a field swings a compass needle", field_swings_a_compass_needle), &
                  new_unittest("a gravity gradient librates a satellite", gradient_librates_a_satellite), &
                  new_unittest("a gravity gradient leaves a sphere alone", gradient_leaves_a_sphere_alone), &
                  new_unittest("a spring without rest length is uniform gravity", spring_is_gravity), &
                  new_unittest("a spring at the pivot does nothing", spring_at_the_pivot_does_nothing), &
                  new_unittest("a spring swings about its anchor", spring_swings_about_its_anchor)]
   end procedure collect_effect_physics

   !> A quarter of the period of φ̈ = -ω² sin φ let go at rest at φ0 (Gauss): π/(2ω M(1, cos(φ0/2))).
   pure real(wp) function quarter_period(frequency, phi0) result(quarter)
      !> ω of small swings, rad/s.
      real(wp), intent(in) :: frequency
      real(wp), intent(in) :: phi0
      real(wp) :: a, b, mean
      integer :: i
      a = 1.0_wp
      b = cos(0.5_wp*phi0)
      do i = 1, 8
         mean = 0.5_wp*(a + b)
         b = sqrt(a*b)
         a = mean
      end do
      quarter = 0.5_wp*pi/(frequency*a)
   end function quarter_period

   !> A swing that is let go at rest passes its middle after a quarter of the period: the error of the angle there falls
   !> as Δt² and, that taken away, as Δt⁴.
   subroutine check_swing(error, problem, axis, quarter, amplitude)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      !> Body axis about which the body swings; its middle is the attitude 1.
      integer, intent(in) :: axis
      real(wp), intent(in) :: quarter
      !> rad.
      real(wp), intent(in) :: amplitude
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: angle(3)
      integer :: k, n
      do k = 1, 3
         n = 25*2**k
         call solve(problem, quarter/n, n, state, status)
         call check(error, status%ok(), trim(status%message))
         angle(k) = 2*atan2(state%q(1 + axis), state%q(1))/amplitude
      end do
      call check_close(error, log(angle(1:2)/angle(2:3))/log(2.0_wp), [2.0_wp, 2.0_wp], 0.01_wp, "order")
      call check_below(error, abs(angle(3)), 2e-4_wp, "angle at the quarter of the period")
      call check_below(error, abs(4*angle(3) - angle(2))/3, 2e-7_wp, "angle extrapolated to short steps")
   end subroutine check_swing

   !> J φ̈ = -mgl sin φ, from 2 rad.
   subroutine gravity_swings_a_pendulum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(status_t) :: status
      problem => new_problem()
      call make_body(diagonal([4.0_wp, 5.0_wp, 3.0_wp]), problem%system%body, status, mass=2.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, -0.5_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      problem%start = make_state(problem%system, [cos(1.0_wp), sin(1.0_wp), 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call check_swing(error, problem, 1, quarter_period(sqrt(9.81_wp*2*0.5_wp/4), 2.0_wp), 2.0_wp)
   end subroutine gravity_swings_a_pendulum

   !> J φ̈ = -mb sin φ, from 3 rad, close to the unstable direction.
   subroutine field_swings_a_compass_needle(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => spinner([0.1_wp, 3.0_wp, 3.0_wp], 0.0_wp)
      call problem%system%effects%add(dipole_t([7.0_wp, 0.0_wp, 0.0_wp], [0.5_wp, 0.0_wp, 0.0_wp]))
      problem%start%q = [cos(1.5_wp), 0.0_wp, 0.0_wp, sin(1.5_wp)]
      call check_swing(error, problem, 3, quarter_period(sqrt(3.5_wp/3), 3.0_wp), 3.0_wp)
   end subroutine field_swings_a_compass_needle

   !> n = x, rotation ψ about axis 3: V = ½·3κ(J1 cos²ψ + J2 sin²ψ), so J3 ψ̈ = -3κ(J2 - J1) sin ψ cos ψ: 2ψ is a
   !> pendulum of frequency ω² = 3κ(J2 - J1)/J3, the pitch libration of a satellite; here in a frame that does not turn.
   subroutine gradient_librates_a_satellite(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      real(wp), parameter :: kappa = 1.2e-6_wp, amplitudes(2) = [1e-3_wp, 1.0_wp]
      real(wp) :: omega
      integer :: i
      omega = sqrt(3*kappa*(90.0_wp - 40.0_wp)/100.0_wp)
      do i = 1, 2
         problem => spinner([40.0_wp, 90.0_wp, 100.0_wp], 0.0_wp)
         call problem%system%effects%add(gravity_gradient_t(problem%system%body, [-2.0_wp, 0.0_wp, 0.0_wp], kappa))
         problem%start%q = [cos(amplitudes(i)/2), 0.0_wp, 0.0_wp, sin(amplitudes(i)/2)]
         call check_swing(error, problem, 3, quarter_period(omega, 2*amplitudes(i)), amplitudes(i))
      end do
      call check_close(error, quarter_period(omega, 2e-3_wp), 0.5_wp*pi/omega, 1e-6_wp/omega, "small amplitude")
   end subroutine gradient_librates_a_satellite

   !> Three equal moments: no torque, not even a small one.
   subroutine gradient_leaves_a_sphere_alone(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      problem => spinner([2.0_wp, 2.0_wp, 2.0_wp], 0.0_wp)
      call problem%system%effects%add(gravity_gradient_t(problem%system%body, [1.0_wp, 2.0_wp, -1.0_wp], 3.0_wp))
      problem%start = make_state(problem%system, identity, [1.0_wp, -2.0_wp, 0.5_wp])
      call solve(problem, 0.1_wp, 100, state, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, space_momentum(state), [2.0_wp, -4.0_wp, 1.0_wp], 1e-13_wp, "space momentum")
   end subroutine gradient_leaves_a_sphere_alone

   !> ½k|Rx - a|² = const - k a·Rx: the weight of a mass m at x in the acceleration ka/m.
   subroutine spring_is_gravity(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: held
      type(problem_t) :: heavy
      type(state_t) :: a, b
      type(status_t) :: status
      real(wp), parameter :: anchor(3) = [3.0_wp, -5.0_wp, 20.0_wp], k = 0.3_wp
      held => new_problem()
      held%system = sample_body()
      heavy = held
      call held%system%effects%add(spring_t(held%system%body%center_of_mass, anchor, k))
      call heavy%system%effects%add(gravity_t(heavy%system%body, k*anchor/heavy%system%body%mass))
      held%start = make_state(held%system, [0.5_wp, -0.5_wp, 0.1_wp, 0.7_wp], [0.7_wp, -1.1_wp, 0.9_wp])
      heavy%start = held%start
      call solve(held, 0.05_wp, 200, a, status)
      call solve(heavy, 0.05_wp, 200, b, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, [a%q, a%p], [b%q, b%p], 1e-11_wp, "state")
   end subroutine spring_is_gravity

   subroutine spring_at_the_pivot_does_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      problem => spinner([2.0_wp, 3.0_wp, 4.0_wp], 0.0_wp)
      call problem%system%effects%add(spring_t([0.0_wp, 0.0_wp, 0.0_wp], [1.0_wp, 2.0_wp, -1.0_wp], 30.0_wp, 0.5_wp))
      problem%start = make_state(problem%system, identity, [1.0_wp, -2.0_wp, 0.5_wp])
      call solve(problem, 0.1_wp, 100, state, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, space_momentum(state), [2.0_wp, -6.0_wp, 2.0_wp], 1e-12_wp, "space momentum")
   end subroutine spring_at_the_pivot_does_nothing

   !> Small swings about the line to the anchor: J φ̈ = -k(1 - l₀/ℓ)|x||a| φ; with the anchor on the circle of the
   !> spring's end, without rest length, J φ̈ = -k|x|² φ.
   subroutine spring_swings_about_its_anchor(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: phi = 1e-4_wp
      call check_spring(error, [0.5_wp, 0.0_wp, 0.0_wp], [1.5_wp, 0.0_wp, 0.0_wp], 0.4_wp, sqrt(6*0.6_wp*0.75_wp/2))
      call check_spring(error, [0.5_wp, 0.0_wp, 0.0_wp], [0.5_wp, 0.0_wp, 0.0_wp], 0.0_wp, sqrt(6*0.25_wp/2))
   contains
      subroutine check_spring(error, x, a, rest_length, omega)
         type(error_type), allocatable, intent(inout) :: error
         real(wp), intent(in) :: x(3), a(3), rest_length, omega
         type(problem_t) :: problem
         problem = spinner([3.0_wp, 4.0_wp, 2.0_wp], 0.0_wp)
         call problem%system%effects%add(spring_t(x, a, 6.0_wp, rest_length))
         problem%start%q = [cos(phi/2), 0.0_wp, 0.0_wp, sin(phi/2)]
         call check_swing(error, problem, 3, 0.5_wp*pi/omega, phi)
      end subroutine check_spring
   end subroutine spring_swings_about_its_anchor

end submodule test_effect_physics
