!> One step: it solves the paper's equations, its Jacobian is the derivative of its residual, and failure leaves no
!> trace.
submodule(suites_of_runs) test_step
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_effect, only: potential_t, torque_t
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: wp, eps
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_quaternion, only: cross, quat_left_matrix, quat_right_matrix, rotate_to_body
   use nutate_rotor, only: rotor_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_NOT_CONVERGED, NUTATE_OFF_BRANCH, status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_jacobian, only: check_jacobian
   use test_problems, only: angular_velocity, bilinear_form, box, make_state, march, new_system, precessing_top, &
      problem_t, system_t, total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit_quaternion, &
                           random_vector
   implicit none

   !> U = γ1³ + γ2 γ3 + cosh γ2: neither linear nor quadratic, second derivatives left to the library.
   type, extends(potential_t) :: crooked_potential_t
   contains
      procedure :: energy => crooked_energy
      procedure :: gradient => crooked_gradient
   end type crooked_potential_t

   !> τ = -Ω|Ω|/4 + γ×(1,2,3) cos t, γ = R(q)ᵀe₁: depends on everything, derivatives left to the library.
   type, extends(torque_t) :: crooked_torque_t
   contains
      procedure :: torque => crooked_torque
   end type crooked_torque_t

contains

   module procedure collect_step
      testsuite = [ &
                  new_unittest("a step solves the paper's equations", step_solves_the_papers_equations), &
                  new_unittest("discrete gradient closes the energy", discrete_gradient_closes_the_energy), &
                  new_unittest("Jacobian of the free step", jacobian_of_the_free_step), &
                  new_unittest("Jacobian with gravity", jacobian_with_gravity), &
                  new_unittest("Jacobian without projection", jacobian_without_projection), &
                  new_unittest("Jacobian with a general potential", jacobian_with_general_potential), &
                  new_unittest("Jacobian with a general torque and a rotor", jacobian_with_torque_and_rotor), &
                  new_unittest("a failed step leaves the state untouched", failed_step_leaves_the_state), &
                  new_unittest("a step off the true branch is refused", step_off_the_branch_is_refused), &
                  new_unittest("projection off needs a finite J0", projection_off_needs_finite_j0), &
                  new_unittest("tolerance ends the iteration early", tolerance_ends_the_iteration), &
                  new_unittest("a body at rest stays at rest", body_at_rest_stays), &
                  new_unittest("the momentum may outgrow its unit", momentum_outgrows_its_unit), &
                  new_unittest("a force against the motion sets no unit of momentum", damping_sets_no_unit)]
   end procedure collect_step

   pure real(wp) function crooked_energy(self, gamma)
      class(crooked_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      crooked_energy = gamma(1)**3 + gamma(2)*gamma(3) + cosh(gamma(2))
   end function crooked_energy

   pure function crooked_gradient(self, gamma) result(gradient)
      class(crooked_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = [3*gamma(1)**2, gamma(3) + sinh(gamma(2)), gamma(2)]
   end function crooked_gradient

   pure function crooked_torque(self, t, q, omega) result(tau)
      class(crooked_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = -0.25_wp*norm2(omega)*omega &
            + cos(t)*cross(rotate_to_body(q, [1.0_wp, 0.0_wp, 0.0_wp]), [1.0_wp, 2.0_wp, 3.0_wp])
   end function crooked_torque

   !> A full tensor with mass, no effects yet.
   function asymmetric_body() result(system)
      type(system_t), pointer :: system
      type(status_t) :: status
      system => new_system()
      call make_body(reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3]), &
                     system%body, status, mass=2.0_wp, center_of_mass=[0.3_wp, -0.2_wp, 0.5_wp])
   end function asymmetric_body

   !> q1 - q0 = ¼Δt Q(q̄)a, p1 - p0 = -¼Δt Q(p̄)Ca - Δt(I - q̄q̄ᵀ/q̄ᵀq̄)∂V*/∂q, written in q and p with explicit
   !> matrices, as in the paper; for gravity V is quadratic in q and ∂V*/∂q = ∂V/∂q at q̄.
   subroutine step_solves_the_papers_equations(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: start, end
      type(nielsen_krenk_t) :: stepper
      type(integrator_settings_t) :: settings
      type(status_t) :: status
      integer(int64) :: seed
      real(wp) :: qm(4), pm(4), a(4), w(4), slope(4), dt, right(4), weight(4, 4)
      integer :: i
      ! V = -m g·(q∘c∘q*) = -m (g∘q)·(q∘c) = qᵀBq, B = -m Q(g)ᵀR(c), a symmetric matrix.
      weight = -2*matmul(transpose(quat_left_matrix([0.0_wp, 1.0_wp, -2.0_wp, -9.0_wp])), &
                         quat_right_matrix([0.0_wp, 0.3_wp, -0.2_wp, 0.5_wp]))
      system => asymmetric_body()
      call system%effects%add(gravity_t(system%body, [1.0_wp, -2.0_wp, -9.0_wp]))
      seed = 4711_int64
      dt = 0.05_wp
      settings%inverse_auxiliary_inertia = 0.1_wp
      call stepper%prepare(system, settings, status)
      do i = 1, 20
         start = make_state(system, random_unit_quaternion(seed), 3*random_vector(seed))
         start%p = start%p + 0.1_wp*start%q
         end = start
         call stepper%step(system, end, dt, status)
         call check(error, status%ok(), trim(status%message))
         qm = 0.5_wp*(start%q + end%q)
         pm = 0.5_wp*(start%p + end%p)
         w = 0.5_wp*(bilinear_form(start%q, start%p) + bilinear_form(end%q, end%p))
         a = [0.1_wp*w(1), matmul(system%body%inverse_inertia, w(2:4))]
         right = 0.25_wp*dt*matmul(quat_left_matrix(qm), a)
         call check_close(error, end%q - start%q, right, 8*eps, "q1 - q0")
         slope = 2*matmul(weight, qm)
         slope = slope - qm*dot_product(qm, slope)/dot_product(qm, qm)
         right = -0.25_wp*dt*matmul(quat_left_matrix(pm), a*[1, -1, -1, -1]) - dt*slope
         call check_close(error, end%p - start%p, right, 16*eps*norm2(start%p), "p1 - p0")
      end do

   end subroutine step_solves_the_papers_equations

   subroutine discrete_gradient_closes_the_energy(error)
      type(error_type), allocatable, intent(out) :: error
      type(crooked_potential_t) :: potential
      integer(int64) :: seed
      real(wp) :: gamma0(3), gamma1(3), distance, closure
      integer :: i, k
      seed = 99_int64
      do k = 0, 16
         distance = 10.0_wp**(-k)
         do i = 1, 20
            gamma0 = random_vector(seed)
            gamma1 = gamma0 + distance*random_vector(seed)
            closure = dot_product(potential%discrete_gradient(gamma0, gamma1), gamma1 - gamma0) &
                      - (potential%energy(gamma1) - potential%energy(gamma0))
            ! |U| is below 4 here.
            call check_below(error, abs(closure), 32*eps, "closure")
         end do
      end do
   end subroutine discrete_gradient_closes_the_energy

   subroutine jacobian_of_the_free_step(error)
      type(error_type), allocatable, intent(out) :: error
      call check_jacobian(error, asymmetric_body(), 0.3_wp, .true.)
   end subroutine jacobian_of_the_free_step

   subroutine jacobian_with_gravity(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      system => asymmetric_body()
      call system%effects%add(gravity_t(system%body, [1.0_wp, -2.0_wp, -9.0_wp]))
      call check_jacobian(error, system, 0.0_wp, .true.)
   end subroutine jacobian_with_gravity

   subroutine jacobian_without_projection(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      system => asymmetric_body()
      call system%effects%add(gravity_t(system%body, [1.0_wp, -2.0_wp, -9.0_wp]))
      call check_jacobian(error, system, 0.3_wp, .false.)
   end subroutine jacobian_without_projection

   subroutine jacobian_with_general_potential(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(crooked_potential_t) :: potential
      system => asymmetric_body()
      potential%direction = [0.6_wp, 0.5_wp, -0.7_wp]
      call system%effects%add(potential)
      call check_jacobian(error, system, 0.3_wp, .false.)
   end subroutine jacobian_with_general_potential

   subroutine jacobian_with_torque_and_rotor(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(crooked_torque_t) :: torque
      system => asymmetric_body()
      call system%effects%add(torque)
      call system%effects%add(rotor_t(momentum=[0.5_wp, -1.0_wp, 2.0_wp]))
      call check_jacobian(error, system, 0.3_wp, .true.)
   end subroutine jacobian_with_torque_and_rotor

   subroutine failed_step_leaves_the_state(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(nielsen_krenk_t) :: stepper
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      type(status_t) :: status
      problem => precessing_top()
      settings%max_iterations = 1
      call stepper%prepare(problem%system, settings, status)
      state = problem%start
      call stepper%step(problem%system, state, 0.001_wp, status)
      call check(error, status%code, NUTATE_NOT_CONVERGED)
      call check_close(error, [state%t, state%q, state%p, state%q_compensation, state%p_compensation], &
                       [0.0_wp, problem%start%q, problem%start%p, spread(0.0_wp, 1, 8)], 0.0_wp, "state")
   end subroutine failed_step_leaves_the_state

   !> The box on its unstable axis: the branch of the true motion ends at Δt|Ω| = 2.27, beyond it Newton finds other
   !> roots.
   subroutine step_off_the_branch_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(nielsen_krenk_t) :: stepper
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      type(status_t) :: status
      problem => box()
      problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [1e-6_wp, 0.0_wp, 10.0_wp])
      call stepper%prepare(problem%system, settings, status)
      state = problem%start
      call stepper%step(problem%system, state, 0.22_wp, status)
      call check(error, status%ok(), "Δt|Ω| = 2.2: "//trim(status%message))
      state = problem%start
      call stepper%step(problem%system, state, 0.24_wp, status)
      call check(error, status%code == NUTATE_OFF_BRANCH .or. status%code == NUTATE_NOT_CONVERGED, &
                 "Δt|Ω| = 2.4 accepted")
      call stepper%step(problem%system, state, 0.5_wp, status)
      call check(error,.not. status%ok(), "Δt|Ω| = 5 accepted")
   end subroutine step_off_the_branch_is_refused

   subroutine projection_off_needs_finite_j0(error)
      type(error_type), allocatable, intent(out) :: error
      type(nielsen_krenk_t) :: stepper
      type(status_t) :: status
      call stepper%prepare(asymmetric_body(), integrator_settings_t(projection=.false.), status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
   end subroutine projection_off_needs_finite_j0

   subroutine tolerance_ends_the_iteration(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(nielsen_krenk_t) :: loose, tight
      type(state_t) :: a, b
      type(status_t) :: status
      problem => box()
      a = problem%start
      b = problem%start
      call loose%prepare(problem%system, integrator_settings_t(tolerance=1e-3_wp), status)
      call tight%prepare(problem%system, integrator_settings_t(), status)
      call march(problem%system, loose, a, 0.01_wp, 1, status)
      call march(problem%system, tight, b, 0.01_wp, 1, status)
      call check(error, loose%iterations < tight%iterations, "no iteration saved")
      call check_below(error, loose%residual, 1e-3_wp, "residual")
      call check_below(error, norm2(a%q - b%q), 1e-3_wp*norm2(b%q - problem%start%q), "difference")
   end subroutine tolerance_ends_the_iteration

   subroutine body_at_rest_stays(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(nielsen_krenk_t) :: stepper
      type(state_t) :: state
      type(status_t) :: status
      system => asymmetric_body()
      state = make_state(system, [0.5_wp, 0.5_wp, -0.5_wp, 0.5_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call stepper%prepare(system, integrator_settings_t(), status)
      call march(system, stepper, state, 0.1_wp, 10, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, [state%q, state%p], &
                       [0.5_wp, 0.5_wp, -0.5_wp, 0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 0.0_wp)
   end subroutine body_at_rest_stays

   !> The upright pendulum falls from 1e-8 rad/s to 6 rad/s in fixed steps.
   subroutine momentum_outgrows_its_unit(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(nielsen_krenk_t) :: stepper
      type(state_t) :: state
      type(status_t) :: status
      system => new_system()
      call make_body(diagonal([1.0_wp, 1.0_wp, 0.25_wp]), system%body, status, mass=1.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, 1.0_wp])
      call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [1e-8_wp, 0.0_wp, 0.0_wp])
      call stepper%prepare(system, integrator_settings_t(), status)
      call march(system, stepper, state, 0.01_wp, 1000, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, total_energy(system, state), 9.81_wp, 100*eps*9.81_wp, "energy")
   end subroutine momentum_outgrows_its_unit

   !> Damping that would reverse the motion 1e10 times over: Ω1 = -Ω0(1 - 4e-10).
   subroutine damping_sets_no_unit(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(nielsen_krenk_t) :: stepper
      type(state_t) :: state
      type(status_t) :: status
      system => new_system()
      call make_body(diagonal([1.0_wp, 1.0_wp, 1.0_wp]), system%body, status)
      call system%effects%add(damping_t([1e12_wp, 1e12_wp, 1e12_wp]))
      state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [1.0_wp, 2.0_wp, 3.0_wp])
      call stepper%prepare(system, integrator_settings_t(), status)
      call march(system, stepper, state, 0.01_wp, 1, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, angular_velocity(system, state), -(1 - 4e-10_wp)*[1.0_wp, 2.0_wp, 3.0_wp], 1e-14_wp, "Ω")
   end subroutine damping_sets_no_unit

end submodule test_step
