!> All effects at once against a classical integration of the textbook's equations, which shares nothing with the
!> library: rotation matrix and Ω, Runge-Kutta of order 4, each torque written from its force.
submodule(suites_of_effects) test_effect_reference
   use nutate_applied_torque, only: applied_torque_t
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_hamiltonian, only: angular_velocity, make_state, system_t
   use nutate_kinds, only: wp, pi
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_quaternion, only: rotation_matrix
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_plan_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_effect_samples, only: sample_body
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   real(wp), parameter :: acceleration(3) = [0.5_wp, 1.0_wp, -3.0_wp], kappa = 0.4_wp
   real(wp), parameter :: moment(3) = [0.5_wp, -1.0_wp, 2.0_wp], field(3) = [1.0_wp, 0.5_wp, -0.3_wp]
   real(wp), parameter :: nadir(3) = [2.0_wp, 2.0_wp, -1.0_wp]/3
   real(wp), parameter :: point(3) = [0.4_wp, 0.1_wp, -0.6_wp], anchor(3) = [0.5_wp, 1.0_wp, -0.8_wp]
   real(wp), parameter :: stiffness = 5.0_wp, rest_length = 0.7_wp
   real(wp), parameter :: drag(3) = [0.3_wp, 0.1_wp, 0.2_wp], rotor(3) = [0.5_wp, -1.0_wp, 2.0_wp]
   real(wp), parameter :: push(3) = [1.0_wp, -0.4_wp, 1.6_wp], frequency = 0.7_wp, phase = 0.4_wp
   real(wp), parameter :: thrust(3) = [-1.5_wp, 2.0_wp, 1.0_wp], start = 0.31_wp, stop = 0.87_wp, end_time = 1.2_wp
   real(wp), parameter :: first_q(4) = [0.5_wp, -0.5_wp, 0.1_wp, 0.7_wp], first_omega(3) = [0.7_wp, -1.1_wp, 0.9_wp]

contains

   module procedure collect_effect_reference
      testsuite = [ &
                  new_unittest("all effects converge to a classical integration", effects_converge_to_reference)]
   end procedure collect_effect_reference

   function full_system() result(system)
      type(system_t), pointer :: system
      system => sample_body()
      associate (effects => system%effects)
         call effects%add(gravity_t(system%body, acceleration))
         call effects%add(dipole_t(moment, field))
         call effects%add(gravity_gradient_t(system%body, nadir, kappa))
         call effects%add(spring_t(point, anchor, stiffness, rest_length))
         call effects%add(damping_t(drag))
         call effects%add(applied_torque_t(amplitude=push, in_space=.true., frequency=frequency, phase=phase))
         call effects%add(applied_torque_t(amplitude=thrust, start=start, stop=stop))
         call effects%add(rotor_t(momentum=rotor))
      end associate
   end function full_system

   !> Attitude and rate at the end fall to the reference as Δt², slope 2.0 ± 0.1 over three halvings; 1e-5 is reached.
   subroutine effects_converge_to_reference(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(nielsen_krenk_t) :: stepper
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: rotation(3, 3), omega(3), errors(4, 2)
      integer :: k
      system => full_system()
      call solve_classically(system%body%inertia, rotation, omega)
      do k = 1, 4
         state = make_state(system, first_q, first_omega)
         call stepper%prepare(system, integrator_settings_t(), status)
         call integrate(system, stepper, state, run_plan_t(time_step=0.02_wp/2**k, end_time=end_time), status)
         call check(error, status%ok(), trim(status%message))
         errors(k, 1) = maxval(abs(rotation_matrix(state%q) - rotation))
         errors(k, 2) = maxval(abs(angular_velocity(system, state) - omega))
      end do
      do k = 1, 2
         call check_close(error, log(errors(1:3, k)/errors(2:4, k))/log(2.0_wp), [2.0_wp, 2.0_wp, 2.0_wp], 0.1_wp, &
                          "order")
         call check_below(error, errors(4, k), 1e-5_wp, "error at the shortest step")
      end do
   end subroutine effects_converge_to_reference

   !> Integrates to the end time, piece by piece where the thrust begins and ends; error about 1e-12.
   subroutine solve_classically(inertia, rotation, omega)
      real(wp), intent(in) :: inertia(3, 3)
      !> Body→space.
      real(wp), intent(out) :: rotation(3, 3)
      real(wp), intent(out) :: omega(3)
      real(wp), parameter :: times(4) = [0.0_wp, start, stop, end_time]
      integer, parameter :: n = 800
      real(wp) :: y(12), k1(12), k2(12), k3(12), k4(12), t, h
      real(wp) :: q(4)
      integer :: piece, i
      q = first_q
      y(1:9) = pack(first_rotation(q), .true.)
      y(10:12) = first_omega
      do piece = 1, 3
         h = (times(piece + 1) - times(piece))/n
         do i = 1, n
            t = times(piece) + (i - 1)*h
            k1 = rates(inertia, t, y, piece == 2)
            k2 = rates(inertia, t + h/2, y + h/2*k1, piece == 2)
            k3 = rates(inertia, t + h/2, y + h/2*k2, piece == 2)
            k4 = rates(inertia, t + h, y + h*k3, piece == 2)
            y = y + h/6*(k1 + 2*k2 + 2*k3 + k4)
         end do
      end do
      rotation = reshape(y(1:9), [3, 3])
      omega = y(10:12)
   end subroutine solve_classically

   !> Rotation by 2 arccos(q0) about the vector of q: cos I + (1 - cos) nnᵀ + sin [n×] (Rodrigues).
   pure function first_rotation(q) result(rotation)
      real(wp), intent(in) :: q(4)
      real(wp) :: rotation(3, 3)
      real(wp) :: n(3), angle
      integer :: i
      angle = 2*acos(q(1))
      n = q(2:4)/norm2(q(2:4))
      do i = 1, 3
         rotation(:, i) = (1 - cos(angle))*n(i)*n + sin(angle)*vector_product(n, unit(i))
         rotation(i, i) = rotation(i, i) + cos(angle)
      end do
   end function first_rotation

   pure function unit(i) result(e)
      integer, intent(in) :: i
      real(wp) :: e(3)
      e = 0.0_wp
      e(i) = 1.0_wp
   end function unit

   !> Ṙ = R[Ω×] and J Ω̇ = (JΩ + h)×Ω + torques, y the columns of R and Ω.
   pure function rates(inertia, t, y, thrusting) result(dy)
      real(wp), intent(in) :: inertia(3, 3), t, y(12)
      logical, intent(in) :: thrusting
      real(wp) :: dy(12)
      real(wp) :: r(3, 3), omega(3), force(3), tau(3), reach(3), down(3)
      integer :: i
      r = reshape(y(1:9), [3, 3])
      omega = y(10:12)
      ! Weight at the centre of mass, m·B about the reference point, 3κ n×Jn.
      tau = vector_product([0.3_wp, -0.2_wp, 0.5_wp], 2*matmul(acceleration, r))
      tau = tau + vector_product(moment, matmul(field, r))
      down = matmul(nadir, r)
      tau = tau + 3*kappa*vector_product(down, matmul(inertia, down))
      ! The spring pulls its end towards the anchor with the tension k(ℓ - l₀).
      reach = matmul(anchor - matmul(r, point), r)
      force = stiffness*(sqrt(sum(reach**2)) - rest_length)*reach/sqrt(sum(reach**2))
      tau = tau + vector_product(point, force) - drag*omega
      tau = tau + cos(2*pi*frequency*t + phase)*matmul(push, r)
      if (thrusting) tau = tau + thrust
      tau = tau + vector_product(matmul(inertia, omega) + rotor, omega)
      do i = 1, 3
         dy(3*i - 2:3*i) = matmul(r, vector_product(omega, unit(i)))
      end do
      dy(10:12) = solve3(inertia, tau)
   end function rates

   !> a×b
   pure function vector_product(a, b) result(c)
      real(wp), intent(in) :: a(3), b(3)
      real(wp) :: c(3)
      c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
   end function vector_product

   !> x of Ax = b by Cramer's rule.
   pure function solve3(a, b) result(x)
      real(wp), intent(in) :: a(3, 3), b(3)
      real(wp) :: x(3)
      x = [dot_product(b, vector_product(a(:, 2), a(:, 3))), dot_product(a(:, 1), vector_product(b, a(:, 3))), &
           dot_product(a(:, 1), vector_product(a(:, 2), b))]/dot_product(a(:, 1), vector_product(a(:, 2), a(:, 3)))
   end function solve3

end submodule test_effect_reference
