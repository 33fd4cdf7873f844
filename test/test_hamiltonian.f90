!> The Hamiltonian: its forms agree, its derivatives are those of its value, its equations those of mechanics.
submodule(suites_of_runs) test_hamiltonian
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: make_body
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: cross, quat_left_matrix, quat_product, rotate_to_space
   use nutate_rotor, only: rotor_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_problems, only: angular_velocity, bilinear_form, body_momentum, kinetic_energy, make_state, new_system, &
      potential_energy, potential_torque, space_momentum, system_t, total_energy
   use test_reference_forms, only: hamilton_equations, inverse_mass_matrix, mass_matrix, momentum_from_rate, &
      potential_gradient
   use test_support, only: check_close, error_type, new_unittest, random_unit_quaternion, random_vector
   implicit none

   integer(int64), parameter :: first_seed = 20121025_int64
   integer, parameter :: trials = 50
   !> J0, kg m².
   real(wp), parameter :: j0 = 7.0_wp

contains

   module procedure collect_hamiltonian
      testsuite = [ &
                  new_unittest("mass matrix times its inverse is one", mass_matrix_has_its_inverse), &
                  new_unittest("kinetic energy in its three forms", kinetic_energy_in_three_forms), &
                  new_unittest("momentum from rate, rate from momentum", momentum_and_rate_agree), &
                  new_unittest("w is the constraint and twice the momentum", w_is_constraint_and_momentum), &
                  new_unittest("space momentum is the rotated body momentum", space_momentum_is_rotated), &
                  new_unittest("gravity potential is m g h", gravity_is_m_g_h), &
                  new_unittest("potential gradient against differences", gradient_matches_differences), &
                  new_unittest("potential torque is r x m g", torque_is_r_cross_weight), &
                  new_unittest("equations of motion are Hamilton's", equations_are_hamiltons), &
                  new_unittest("equations of motion are Euler's", equations_are_eulers), &
                  new_unittest("rotor adds momentum, not energy", rotor_adds_momentum_not_energy)]
   end procedure collect_hamiltonian

   !> An asymmetric body with a full tensor, under inclined gravity.
   function sample_system() result(system)
      type(system_t), pointer :: system
      type(status_t) :: status
      system => new_system()
      call make_body(reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, 0.75_wp, 6.0_wp], [3, 3]), &
                     system%body, status, mass=2.0_wp, center_of_mass=[0.3_wp, -0.2_wp, 0.5_wp])
      call system%effects%add(gravity_t(system%body, [1.0_wp, -2.0_wp, -9.0_wp]))
   end function sample_system

   subroutine mass_matrix_has_its_inverse(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      integer(int64) :: seed
      real(wp) :: q(4), unit(4, 4)
      integer :: i
      system => sample_system()
      seed = first_seed
      unit = 0.0_wp
      do i = 1, 4
         unit(i, i) = 1.0_wp
      end do
      do i = 1, trials
         q = random_unit_quaternion(seed)
         call check_close(error, pack(matmul(mass_matrix(system%body, j0, q), &
                                             inverse_mass_matrix(system%body, 1/j0, q)), .true.), &
                          pack(unit, .true.), 64*eps)
      end do
   end subroutine mass_matrix_has_its_inverse

   subroutine kinetic_energy_in_three_forms(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      integer(int64) :: seed
      real(wp) :: by_w, by_p, by_q
      integer :: i
      system => sample_system()
      seed = first_seed
      do i = 1, trials
         ! Off the constraint manifold too.
         state%q = 1.1_wp*random_unit_quaternion(seed)
         state%p = 3*random_unit_quaternion(seed)
         by_w = kinetic_energy(system, state, 1/j0)
         by_p = 0.5_wp*dot_product(state%p, matmul(inverse_mass_matrix(system%body, 1/j0, state%q), state%p))
         by_q = 0.5_wp*dot_product(state%q, matmul(inverse_mass_matrix(system%body, 1/j0, state%p), state%q))
         call check_close(error, [by_p, by_q], [by_w, by_w], 64*eps*by_w)
      end do
   end subroutine kinetic_energy_in_three_forms

   subroutine momentum_and_rate_agree(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      integer(int64) :: seed
      real(wp) :: omega(3), rate(4)
      integer :: i
      system => sample_system()
      seed = first_seed
      do i = 1, trials
         omega = random_vector(seed)
         state = make_state(system, random_unit_quaternion(seed), omega)
         call check_close(error, angular_velocity(system, state), omega, 32*eps, "rate from momentum")
         rate = 0.5_wp*quat_product(state%q, [0.0_wp, omega])
         call check_close(error, momentum_from_rate(system%body, j0, state%q, rate), state%p, 64*eps, "p = M q'")
      end do
   end subroutine momentum_and_rate_agree

   subroutine w_is_constraint_and_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      integer(int64) :: seed
      real(wp) :: w(4)
      system => sample_system()
      seed = first_seed
      state = make_state(system, random_unit_quaternion(seed), random_vector(seed))
      w = bilinear_form(state%q, state%p)
      call check_close(error, w, matmul(transpose(quat_left_matrix(state%q)), state%p), 16*eps*norm2(w), "Q(q)'p")
      call check_close(error, w, [0.0_wp, 2*matmul(system%body%inertia, angular_velocity(system, state))], &
                       64*eps*norm2(w), "[q.p, 2L]")
      state%p = state%p + 0.25_wp*state%q
      w = bilinear_form(state%q, state%p)
      call check_close(error, w(1), 0.25_wp, 16*eps*norm2(w), "q.p")
   end subroutine w_is_constraint_and_momentum

   subroutine space_momentum_is_rotated(error)
      type(error_type), allocatable, intent(out) :: error
      type(state_t) :: state
      integer(int64) :: seed
      real(wp) :: momentum(3)
      integer :: i
      seed = first_seed
      do i = 1, trials
         state = make_state(sample_system(), random_unit_quaternion(seed), random_vector(seed))
         momentum = body_momentum(state)
         call check_close(error, space_momentum(state), rotate_to_space(state%q, momentum), 32*eps*norm2(momentum))
      end do
   end subroutine space_momentum_is_rotated

   subroutine gravity_is_m_g_h(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      integer(int64) :: seed
      real(wp) :: q(4), lifted(3)
      system => sample_system()
      seed = first_seed
      q = random_unit_quaternion(seed)
      lifted = rotate_to_space(q, system%body%center_of_mass)
      call check_close(error, potential_energy(system%effects, q), &
                       -2*dot_product([1.0_wp, -2.0_wp, -9.0_wp], lifted), 64*eps)
   end subroutine gravity_is_m_g_h

   subroutine gradient_matches_differences(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      integer(int64) :: seed
      real(wp) :: q(4), h, shift(4), differences(4)
      integer :: i
      system => sample_system()
      seed = first_seed
      q = 1.2_wp*random_unit_quaternion(seed)
      h = eps**(1.0_wp/3)
      do i = 1, 4
         shift = 0.0_wp
         shift(i) = h
         differences(i) = (potential_energy(system%effects, q + shift) &
                           - potential_energy(system%effects, q - shift))/(2*h)
      end do
      ! V is quadratic in q: central differences are exact to round-off, ε|V|/h.
      call check_close(error, potential_gradient(system%effects, q), differences, 100*eps/h)
   end subroutine gradient_matches_differences

   subroutine torque_is_r_cross_weight(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      integer(int64) :: seed
      real(wp) :: q(4), in_space(3)
      system => sample_system()
      seed = first_seed
      q = random_unit_quaternion(seed)
      in_space = cross(rotate_to_space(q, system%body%center_of_mass), 2*[1.0_wp, -2.0_wp, -9.0_wp])
      call check_close(error, rotate_to_space(q, potential_torque(system%effects, q)), in_space, 128*eps)
   end subroutine torque_is_r_cross_weight

   !> Without projection q̇ = ∂H/∂p and ṗ = -∂H/∂q; with it, ṗ lacks just the part of ∂V/∂q along q.
   subroutine equations_are_hamiltons(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state, above, below
      integer(int64) :: seed
      real(wp) :: h, by_q(4), by_p(4), q_rate(4), p_rate(4), slope(4)
      integer :: i
      system => sample_system()
      seed = first_seed
      state%q = random_unit_quaternion(seed)
      state%p = 3*random_unit_quaternion(seed)
      h = eps**(1.0_wp/3)
      do i = 1, 4
         above = state
         below = state
         above%q(i) = state%q(i) + h
         below%q(i) = state%q(i) - h
         by_q(i) = (total_energy(system, above, 1/j0) - total_energy(system, below, 1/j0))/(2*h)
         above = state
         below = state
         above%p(i) = state%p(i) + h
         below%p(i) = state%p(i) - h
         by_p(i) = (total_energy(system, above, 1/j0) - total_energy(system, below, 1/j0))/(2*h)
      end do
      call hamilton_equations(system, state, q_rate, p_rate, 1/j0)
      call check_close(error, q_rate, by_p, 100*eps/h, "q' = dH/dp")
      slope = potential_gradient(system%effects, state%q)
      call check_close(error, p_rate, -by_q + state%q*dot_product(state%q, slope), 300*eps/h, "p' = -dH/dq, projected")
   end subroutine equations_are_hamiltons

   !> q̇ = ½ q∘Ω and L̇ = L×Ω + τ.
   subroutine equations_are_eulers(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: state
      integer(int64) :: seed
      real(wp) :: omega(3), q_rate(4), p_rate(4), l_rate(3), expected(3)
      real(wp) :: w_rate(4), conjugated(4)
      system => sample_system()
      call system%effects%add(rotor_t(momentum=[0.5_wp, -1.0_wp, 2.0_wp]))
      seed = first_seed
      omega = random_vector(seed)
      state = make_state(system, random_unit_quaternion(seed), omega)
      call hamilton_equations(system, state, q_rate, p_rate)
      call check_close(error, q_rate, 0.5_wp*quat_product(state%q, [0.0_wp, omega]), 32*eps, "q'")
      conjugated = q_rate*[1, -1, -1, -1]
      w_rate = quat_product(conjugated, state%p) + quat_product(state%q*[1, -1, -1, -1], p_rate)
      l_rate = 0.5_wp*w_rate(2:4)
      expected = cross(body_momentum(state), omega) + potential_torque(system%effects, state%q)
      call check_close(error, l_rate, expected, 128*eps, "L'")
   end subroutine equations_are_eulers

   subroutine rotor_adds_momentum_not_energy(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: plain
      type(system_t) :: with_rotor
      type(state_t) :: a, b
      real(wp) :: q(4), omega(3)
      integer(int64) :: seed
      seed = first_seed
      q = random_unit_quaternion(seed)
      omega = random_vector(seed)
      plain => sample_system()
      with_rotor = plain
      call with_rotor%effects%add(rotor_t(momentum=[0.5_wp, -1.0_wp, 2.0_wp]))
      a = make_state(plain, q, omega)
      b = make_state(with_rotor, q, omega)
      call check_close(error, body_momentum(b) - body_momentum(a), [0.5_wp, -1.0_wp, 2.0_wp], 64*eps, "momentum")
      call check_close(error, kinetic_energy(with_rotor, b), kinetic_energy(plain, a), 64*eps, "energy")
   end subroutine rotor_adds_momentum_not_energy

end submodule test_hamiltonian
