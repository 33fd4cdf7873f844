!> Reference forms of the equations of motion: the matrices of the kinetic energy, and Hamilton's equations. Numbers in
!> parentheses are those of the equations of Nielsen & Krenk (2012).
module test_reference_forms
   use nutate_body, only: body_t
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: bilinear_form, frame_rate_of, inverse_inertia_at, potential_torque, system_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, quat_conjugate, quat_left_matrix, quat_product, rotate_to_body, &
      vector_quat_product
   use nutate_small_products, only: times_vector
   use nutate_state, only: state_t
   implicit none
   private

   public :: momentum_from_rate, mass_matrix, inverse_mass_matrix, potential_gradient, hamilton_equations

contains

   !> Returns the conjugate momentum (4): p = ∂T/∂q̇ = M(q,q) q̇ = 4 Q(q) J Q(q)ᵀ q̇ for a finite J0; shape (4).
   pure function momentum_from_rate(body, j0, q, rate) result(p)
      type(body_t), intent(in) :: body
      !> J0, kg m².
      real(wp), intent(in) :: j0
      !> q and q̇; shape (4).
      real(wp), intent(in) :: q(4), rate(4)
      real(wp) :: p(4)
      p = matmul(mass_matrix(body, j0, q), rate)
   end function momentum_from_rate

   !> Returns the mass matrix of (3): M(x,x) = 4 Q(x) J Q(x)ᵀ, J = diag(J0, inertia); shape (4,4), kg m².
   pure function mass_matrix(body, j0, x) result(matrix)
      type(body_t), intent(in) :: body
      !> J0, kg m².
      real(wp), intent(in) :: j0
      real(wp), intent(in) :: x(4)
      real(wp) :: matrix(4, 4)
      matrix = sandwich(x, 4*extended(j0, body%inertia))
   end function mass_matrix

   !> Returns M⁻¹(x,x) = ¼ Q(x) J⁻¹ Q(x)ᵀ; shape (4,4). With x = q, a unit quaternion, it is the inverse of the mass
   !> matrix and T = ½ pᵀM⁻¹(q,q)p; with x = p it is the matrix of T = ½ qᵀM⁻¹(p,p)q: equation (6).
   pure function inverse_mass_matrix(body, inverse_j0, x) result(matrix)
      type(body_t), intent(in) :: body
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), intent(in) :: inverse_j0
      real(wp), intent(in) :: x(4)
      real(wp) :: matrix(4, 4)
      matrix = sandwich(x, 0.25_wp*extended(inverse_j0, body%inverse_inertia))
   end function inverse_mass_matrix

   !> Returns diag(scalar, block); shape (4,4).
   pure function extended(scalar, block) result(matrix)
      real(wp), intent(in) :: scalar, block(3, 3)
      real(wp) :: matrix(4, 4)
      matrix = 0.0_wp
      matrix(1, 1) = scalar
      matrix(2:4, 2:4) = block
   end function extended

   !> Returns Q(x) A Q(x)ᵀ; shape (4,4).
   pure function sandwich(x, a) result(matrix)
      real(wp), intent(in) :: x(4), a(4, 4)
      real(wp) :: matrix(4, 4)
      real(wp) :: left(4, 4)
      left = quat_left_matrix(x)
      matrix = matmul(matmul(left, a), transpose(left))
   end function sandwich

   !> Returns ∂V/∂q of (9b) = Σ γ'(q)ᵀ∇U at t = 0; shape (4). With γ = vec(q*∘n∘q) it is 2 q∘[γ·∇U, ∇U×γ]/|q|².
   pure function potential_gradient(effects, q) result(gradient)
      type(effect_list_t), intent(in) :: effects
      !> Attitude, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: gradient(4)
      real(wp) :: inner(4), gamma(3), slope(3)
      integer :: i
      inner = 0.0_wp
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            gamma = rotate_to_body(q, potential%direction)
            slope = potential%gradient(gamma)
            inner(1) = inner(1) + dot_product(gamma, slope)
            inner(2:4) = inner(2:4) + cross(slope, gamma)
         end associate
      end do
      gradient = (2/dot_product(q, q))*quat_product(q, inner)
   end function potential_gradient

   !> Computes Hamilton's equations (7) of this H, with the torques beside the potentials:
   !>
   !>     q̇ = M⁻¹(q,q)p = ¼Q(q)J⁻¹(w-2h)                                                         (9a)
   !>     ṗ = -M⁻¹(p,p)q - (I - qqᵀ/qᵀq)∂V/∂q + f = -¼Q(p)CJ⁻¹(w-2h) + 2q∘[0,τ]/|q|²             (11)
   !>
   !> The multiplier λ of (9b), which (10) would give, is eliminated by the projection of (11). The projection removes
   !> the part of ∂V/∂q along q, which is exactly the scalar part of 2q∘[γ·∇U, ∇U×γ]/|q|²: so the potentials enter as
   !> torques τ = γ×∇U, whose scalar part is 0. Space axes that rotate at ω add -½ω∘q and -½ω∘p.
   pure subroutine hamilton_equations(system, state, q_rate, p_rate, inverse_j0)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> q̇, 1/s; shape (4).
      real(wp), intent(out) :: q_rate(4)
      !> ṗ, kg m²/s²; shape (4).
      real(wp), intent(out) :: p_rate(4)
      !> 1/J0, kg⁻¹ m⁻²; default 0.
      real(wp), intent(in), optional :: inverse_j0
      real(wp) :: w(4), a(4), tau(3), rate(3)
      integer :: i
      w = bilinear_form(state%q, state%p)
      a(1) = 0.0_wp
      if (present(inverse_j0)) a(1) = inverse_j0*w(1)
      a(2:4) = times_vector(inverse_inertia_at(system, state%t), &
                            w(2:4) - 2*system%effects%inner_momentum(state%wheel_momentum))
      rate = 0.5_wp*a(2:4) - frame_rate_of(system%effects, state%q)
      tau = potential_torque(system%effects, state%q, state%t)
      do i = 1, system%effects%n_torques
         associate (torque => system%effects%torques(i)%item)
            if (torque%acts_at(state%t)) tau = tau + torque%torque(state%t, state%q, rate)
         end associate
      end do
      q_rate = 0.25_wp*quat_product(state%q, a)
      p_rate = -0.25_wp*quat_product(state%p, quat_conjugate(a)) &
               + (2/dot_product(state%q, state%q))*quat_product(state%q, [0.0_wp, tau])
      if (.not. system%effects%frame_turns) return
      q_rate = q_rate - vector_quat_product(0.5_wp*system%effects%frame_rate, state%q)
      p_rate = p_rate - vector_quat_product(0.5_wp*system%effects%frame_rate, state%p)
   end subroutine hamilton_equations

end module test_reference_forms
