!> Properties that the scheme promises: invariants to round-off at any step, in any units, forward and back; and
!> properties that are lost without the projection.
submodule(suites_of_runs) test_conservation
   use nutate_body, only: diagonal, make_body
   use nutate_invariants, only: ALL_COMPONENTS, ALONG_AXIS, invariants_t
   use nutate_kinds, only: wp, eps
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_quaternion, only: rotate_to_space
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: angular_velocity, body_momentum, box, fast_top, make_state, march, new_problem, &
      precessing_top, problem_t, solve
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_conservation
      testsuite = [ &
                  new_unittest("box keeps everything, step 0.1", box_keeps_everything_at_long_steps), &
                  new_unittest("box keeps everything, step 0.01", box_keeps_everything_at_short_steps), &
                  new_unittest("box keeps energy and momentum at Δt|Ω| = 2", box_keeps_invariants_at_huge_steps), &
                  new_unittest("tops keep energy and l3", tops_keep_energy_and_l3), &
                  new_unittest("without projection physical quantities break", without_projection_quantities_break), &
                  new_unittest("norm error follows the law in 1/J0", norm_error_follows_the_law), &
                  new_unittest("q.p does not depend on J0", orthogonality_does_not_depend_on_j0), &
                  new_unittest("box steps back to where it came from", box_is_reversible), &
                  new_unittest("top steps back to where it came from", top_is_reversible), &
                  new_unittest("water molecule and Earth in SI units", molecule_and_planet_in_si_units), &
                  new_unittest("units scaled by powers of two change no digit", scaled_units_change_no_digit)]
   end procedure collect_conservation

   subroutine box_keeps_everything_at_long_steps(error)
      type(error_type), allocatable, intent(out) :: error
      call check_invariants(error, box(), 0.1_wp, 200, 0.0_wp, 1e-13_wp)
      call check_invariants(error, box(), 0.1_wp, 200, 1/200.0_wp, 1e-13_wp)
   end subroutine box_keeps_everything_at_long_steps

   subroutine box_keeps_everything_at_short_steps(error)
      type(error_type), allocatable, intent(out) :: error
      call check_invariants(error, box(), 0.01_wp, 2000, 0.0_wp, 1e-13_wp)
      call check_invariants(error, box(), 0.01_wp, 2000, 1/200.0_wp, 1e-13_wp)
   end subroutine box_keeps_everything_at_short_steps

   subroutine box_keeps_invariants_at_huge_steps(error)
      type(error_type), allocatable, intent(out) :: error
      call check_invariants(error, box(), 0.15_wp, 200, 0.0_wp, 1e-13_wp)
   end subroutine box_keeps_invariants_at_huge_steps

   subroutine tops_keep_energy_and_l3(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: top
      top => precessing_top()
      call check_invariants(error, top, 0.001_wp, 2000, 0.0_wp, 1e-13_wp)
      call check_invariants(error, top, 0.001_wp, 2000, 0.1_wp/top%system%body%moments(1), 1e-13_wp)
      call check_invariants(error, fast_top(), 0.001_wp, 2000, 0.0_wp, 1e-13_wp)
   end subroutine tops_keep_energy_and_l3

   !> H, conserved momentum, |L| of a free body, norm and orthogonality within `bound`, relative, over the run; the
   !> norm within
   !> `norm_bound` where it is given: with a finite J0 round-off drives it.
   subroutine check_invariants(error, problem, dt, n, inverse_j0, bound, norm_bound)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt, inverse_j0, bound
      integer, intent(in) :: n
      real(wp), intent(in), optional :: norm_bound
      type(nielsen_krenk_t) :: stepper
      type(integrator_settings_t) :: settings
      type(invariants_t) :: invariants
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: length, norm_limit
      integer :: i
      settings%inverse_auxiliary_inertia = inverse_j0
      call stepper%prepare(problem%system, settings, status)
      state = problem%start
      length = norm2(body_momentum(state))
      call invariants%start(problem%system, state, inverse_j0)
      do i = 1, n
         call stepper%step(problem%system, state, dt, status)
         call check(error, status%ok(), trim(status%message))
         call invariants%measure(problem%system, state)
         if (invariants%components == ALL_COMPONENTS) &
            call check_below(error, abs(norm2(body_momentum(state))/length - 1), bound, "|L|")
      end do
      call check_below(error, invariants%energy_error(), bound, "energy")
      call check_below(error, invariants%momentum_error(), bound, "momentum")
      norm_limit = bound
      if (present(norm_bound)) norm_limit = norm_bound
      call check_below(error, invariants%norm_error, norm_limit, "norm")
      call check_below(error, invariants%orthogonality/norm2(problem%start%p), bound, "orthogonality")
   end subroutine check_invariants

   !> J0 = 10 J1, 0.6 s at 1 ms. H and ½vec(p∘q*)₃ still hold; q·p, the norm, the energy and the momentum of a unit
   !> quaternion do not.
   subroutine without_projection_quantities_break(error)
      type(error_type), allocatable, intent(out) :: error
      call check_ablation(error, precessing_top(), [0.5_wp, 0.5_wp, 1e-2_wp, 0.5_wp])
      call check_ablation(error, fast_top(), [0.3_wp, 0.3_wp, 5e-3_wp, 0.3_wp])
   end subroutine without_projection_quantities_break

   !> Relative departures of q·p, norm, ½ΩᵀJΩ + mgl cos θ and [R(q)JΩ]₃ reach at least `least`.
   subroutine check_ablation(error, problem, least)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: least(4)
      type(nielsen_krenk_t) :: stepper
      type(integrator_settings_t) :: settings
      type(invariants_t) :: invariants
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: broken(4), energy, momentum, first(2)
      integer :: i
      settings%inverse_auxiliary_inertia = 0.1_wp/problem%system%body%moments(1)
      settings%projection = .false.
      call stepper%prepare(problem%system, settings, status)
      state = problem%start
      call invariants%start(problem%system, state, settings%inverse_auxiliary_inertia)
      broken = 0.0_wp
      call measure(problem, state, energy, momentum)
      first = [energy, momentum]
      do i = 1, 600
         call stepper%step(problem%system, state, 0.001_wp, status)
         call check(error, status%ok(), trim(status%message))
         call invariants%measure(problem%system, state)
         call measure(problem, state, energy, momentum)
         broken(3:4) = max(broken(3:4), abs([energy, momentum]/first - 1))
      end do
      broken(1) = invariants%orthogonality/norm2(problem%start%p)
      broken(2) = invariants%norm_error
      call check_below(error, invariants%energy_error(), 1e-12_wp, "H")
      call check(error, invariants%components, ALONG_AXIS)
      call check_below(error, invariants%momentum_error(), 1e-12_wp, "l3 of p and q")
      do i = 1, 4
         call check_below(error, least(i), broken(i), "ablation shows nothing")
      end do
   end subroutine check_ablation

   !> Energy and l₃ as one would take them from attitude and angular velocity: with the rotation of q/|q|.
   subroutine measure(problem, state, energy, momentum)
      type(problem_t), intent(in) :: problem
      type(state_t), intent(in) :: state
      real(wp), intent(out) :: energy, momentum
      real(wp) :: omega(3), l(3), up(3), square
      square = dot_product(state%q, state%q)
      omega = angular_velocity(problem%system, state)/square
      associate (body => problem%system%body)
         l = rotate_to_space(state%q, matmul(body%inertia, omega))/square
         up = rotate_to_space(state%q, body%center_of_mass)/square
         energy = 0.5_wp*dot_product(omega, matmul(body%inertia, omega)) + body%mass*9.81_wp*up(3)
      end associate
      momentum = l(3)
   end subroutine measure

   !> |q|² - 1 = ½Δt Σ|q̄|² w̄₀/J0 to three digits over four decades of J0, for a start with q·p = ε.
   subroutine norm_error_follows_the_law(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: off = 4e-6_wp, dt = 0.01_wp
      type(problem_t), pointer :: problem
      type(nielsen_krenk_t) :: stepper
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: before(4), sum, law
      integer :: decade, i
      problem => box()
      problem%start%p = problem%start%p + off*problem%start%q
      do decade = -2, 2
         settings%inverse_auxiliary_inertia = 1/(20*10.0_wp**decade)
         call stepper%prepare(problem%system, settings, status)
         state = problem%start
         sum = 0.0_wp
         do i = 1, 200
            before = state%q
            call stepper%step(problem%system, state, dt, status)
            call check(error, status%ok(), trim(status%message))
            sum = sum + 0.25_wp*dot_product(before + state%q, before + state%q)
         end do
         law = 0.5_wp*dt*sum*off*settings%inverse_auxiliary_inertia
         call check_close(error, dot_product(state%q, state%q) - 1, law, 1e-3_wp*law, "norm error")
      end do
   end subroutine norm_error_follows_the_law

   subroutine orthogonality_does_not_depend_on_j0(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: off = 4e-6_wp
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      integer :: decade
      problem => box()
      problem%start%p = problem%start%p + off*problem%start%q
      do decade = -2, 2
         call solve(problem, 0.01_wp, 500, state, status, 1/(20*10.0_wp**decade))
         call check(error, status%ok(), trim(status%message))
         call check_close(error, dot_product(state%q, state%p), off, 500*eps*norm2(state%p), "q.p")
      end do
   end subroutine orthogonality_does_not_depend_on_j0

   subroutine box_is_reversible(error)
      type(error_type), allocatable, intent(out) :: error
      call check_reversal(error, box(), 0.01_wp, 300)
   end subroutine box_is_reversible

   subroutine top_is_reversible(error)
      type(error_type), allocatable, intent(out) :: error
      call check_reversal(error, fast_top(), 0.001_wp, 1000)
   end subroutine top_is_reversible

   subroutine check_reversal(error, problem, dt, n)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt
      integer, intent(in) :: n
      type(nielsen_krenk_t) :: stepper
      type(state_t) :: state
      type(status_t) :: status
      call stepper%prepare(problem%system, integrator_settings_t(), status)
      state = problem%start
      call march(problem%system, stepper, state, dt, n, status)
      call check(error, norm2(state%q - problem%start%q) > 0.1_wp, "nothing moved")
      call march(problem%system, stepper, state, -dt, n, status)
      call check_close(error, state%q, problem%start%q, 1e-11_wp, "q")
      call check_close(error, state%p/norm2(problem%start%p), problem%start%p/norm2(problem%start%p), 1e-11_wp, "p")
      call check_close(error, state%t, 0.0_wp, n*eps*n*dt, "t")
   end subroutine check_reversal

   subroutine molecule_and_planet_in_si_units(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: water, earth
      type(status_t) :: status
      water => new_problem()
      earth => new_problem()
      ! H₂O: a flat molecule, 300 K.
      call make_body(diagonal([1.022e-47_wp, 1.918e-47_wp, 2.940e-47_wp]), water%system%body, status)
      water%start = make_state(water%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [1.2e13_wp, 1.5e13_wp, -0.8e13_wp])
      call check_invariants(error, water, 1e-15_wp, 2000, 0.0_wp, 1e-13_wp)
      call check_invariants(error, water, 1e-15_wp, 2000, 0.1_wp/2.94e-47_wp, 1e-13_wp, 1e-12_wp)
      ! The Earth, its axis 0.2" off: a year in steps of two hours.
      call make_body(diagonal([8.0101e37_wp, 8.0103e37_wp, 8.0365e37_wp]), earth%system%body, status)
      earth%start = make_state(earth%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [7.07e-11_wp, 0.0_wp, 7.292115e-5_wp])
      call check_invariants(error, earth, 7200.0_wp, 4383, 0.0_wp, 1e-13_wp)
      call check_invariants(error, earth, 7200.0_wp, 4383, 0.1_wp/8.0365e37_wp, 1e-13_wp, 1e-12_wp)
   end subroutine molecule_and_planet_in_si_units

   !> The box in units of 2^-3 s and 2^-150 kg m²: every digit of q and of the scaled p is the same.
   subroutine scaled_units_change_no_digit(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: inertia = 2.0_wp**(-150), time = 0.125_wp
      type(problem_t), pointer :: plain, scaled
      type(state_t) :: a, b
      type(status_t) :: status
      scaled => new_problem()
      plain => box()
      call make_body(inertia*plain%system%body%inertia, scaled%system%body, status)
      scaled%start = make_state(scaled%system, plain%start%q, angular_velocity(plain%system, plain%start)/time)
      call solve(plain, 0.05_wp, 500, a, status)
      call solve(scaled, 0.05_wp*time, 500, b, status)
      call check_close(error, b%q, a%q, 0.0_wp, "q")
      call check_close(error, b%p*(time/inertia), a%p, 0.0_wp, "p")
   end subroutine scaled_units_change_no_digit

end submodule test_conservation
