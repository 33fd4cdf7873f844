!> The tangent of one step of the conserving scheme: one 3×3 solve with the step's own Jacobian, for both forms of the
!> equations.
!>
!> The b of the step is a root of G (`nutate_reduced_equations`), with the r by which the body rotates in rotating space
!> axes (`nutate_frame_turn`; r = b if they do not rotate). A change of b, at the root with A = ∂G/∂b, β = |b|², ρ =
!> |r|², d = |δ|², δ̄ = b - r, δL̄ and δτ̄ at fixed b, φ = Rhθ0:
!>
!>     Aδb = (1-β+d)(δL0 - δL̄) - 2b×δL̄ - Be - Cδτ̄
!>     δr  = Dδb + e,   D = (1 + [δ̄]×N)⁻¹,   e = -Dδ̄×φ
!>     θ1  = Rh(φ + 4δr/(1+ρ)),   δL1 = 2((4/Δt)Jδb + δL̄) - δL0
!>     C   = -½Δt(1+ρ)F,   F = 1 - 2rbᵀ/(1+ρ),   B = -½Δt(2τ̄rᵀ - 2(b·τ̄)1) + C ∂τ̄/∂r
!>     A   = (1-β+d)(4/Δt)J + 2[b]×(4/Δt)J - 2(L̄-L0)bᵀ - 2[L̄]× + Δt rτ̄ᵀ + BD
!>
!> Every part of A is taken at the root: the Jacobian that Newton's method keeps from earlier steps is not accurate
!> enough. δL1 is L̄ = ½(L0 + L1) = (4/Δt)Jb + h differentiated. The unknown is y, half of the gain of δL, so that only
!> the gain is rounded: with T = (Δt/4)J⁻¹ and M = AT = 1-β+d - S,
!>
!>     My = S(δL0 - δL̄) - 2b×δL̄ - Be - Cδτ̄,   δb = T(δL0 + y - δL̄),   δL1 = δL0 + 2y
!>
!> With the parts of δτ̄ (`nutate_tangent_forces`), τp that of the potentials:
!>
!>     B   = Δt((b·τ̄)1 - F(X0(1 - [r]×) + 2E) + (Fτp - τ̄)rᵀ) - 2(1+ρ)F ∂τ̄/∂Ω
!>     -Cδτ̄ = ½Δt(1+ρ)F((X0 + E)Rh + S0)θ0
!>
!> Elements of matrices are written out: numbers that are stored one by one and read at once as a vector wait for the
!> memory, which here cost as much as the arithmetic.
module nutate_step_tangent
   use nutate_variation, only: variation_t, OF_WHEEL
   use nutate_sensitivity_steps, only: add_products, move_pairs, set_product, set_products, rotate_sensitivities
   use nutate_discrete_forces, only: discrete_forces_t
   use nutate_frame_turn, only: frame_turn_t
   use nutate_kinds, only: wp
   use nutate_quaternion, only: rotate_to_body
   use nutate_small_products, only: add_multiple, add_outer, multiply, times_columns, times_vector
   use nutate_sphere_steps, only: sphere_steps_t
   use nutate_sphere_tangent, only: begin_spheres, finish_spheres, turn_spheres
   use nutate_status, only: status_t, fail, NUTATE_SINGULAR
   use nutate_system, only: inertia_at, inverse_inertia_at, system_t
   use nutate_tangent, only: tangent_t
   use nutate_tangent_forces, only: forces_tangent_t, full_swing_back, half_swing_back
   use nutate_wheel, only: wheel_t, axis_change
   use nutate_wheel_steps, only: wheel_steps_t
   implicit none
   private

   public :: conserving_step_t

   !> Determinants below are those of singular systems.
   real(wp), parameter :: least_determinant = 1e-150_wp

   !> One step and the matrices of its tangent.
   type :: conserving_step_t
      !> Δt, s.
      real(wp) :: dt = 0.0_wp
      !> Middle of the step, s, if the inertia varies.
      real(wp) :: middle = 0.0_wp
      !> u, attitude at the start, body→space; shape (4).
      real(wp) :: frame(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> b, dimensionless, and L0, N m s, body axes; shape (3).
      real(wp) :: b(3) = 0.0_wp, momentum(3) = 0.0_wp
      !> h of rotors, and of wheels at fixed b, N m s; shape (3).
      real(wp) :: rotor(3) = 0.0_wp
      type(forces_tangent_t), private :: forces
      !> T, of J with the contribution of wheels, shape (3,3), and true if T is diagonal.
      real(wp), private :: turn_by_mean(3, 3) = 0.0_wp
      logical, private :: is_diagonal = .true.
      !> M⁻¹; B, D and ∂e/∂φ if the space axes rotate; shape (3,3).
      real(wp), private :: inverse(3, 3) = 0.0_wp
      real(wp), private :: by_relative(3, 3) = 0.0_wp, by_absolute(3, 3) = 0.0_wp, by_turn(3, 3) = 0.0_wp
      !> Derivatives of y by δL0, and by θ0; shape (3,3).
      real(wp), private :: by_momentum(3, 3) = 0.0_wp, by_start(3, 3) = 0.0_wp
   contains
      !> Moves sensitivities over the step.
      procedure :: propagate
   end type conserving_step_t

contains

   !> Moves sensitivities over the step. Errors: `NUTATE_SINGULAR`, with the sensitivities unchanged.
   subroutine propagate(self, system, forces, turn, wheels, spheres, tangent, status)
      class(conserving_step_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Forces of the step, started.
      type(discrete_forces_t), intent(in) :: forces
      type(frame_turn_t), intent(in) :: turn
      !> Present if there are wheels, or inner spheres.
      type(wheel_steps_t), intent(in), optional :: wheels
      type(sphere_steps_t), intent(in), optional :: spheres
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      real(wp) :: by_start(3), by_mean(3)
      logical :: plain
      self%turn_by_mean = (0.25_wp*self%dt)*inverse_inertia_at(system, self%middle)
      if (present(wheels)) call add_wheels(self, system, wheels)
      associate (t => self%turn_by_mean)
         self%is_diagonal = .not. abs(t(1, 2)) + abs(t(1, 3)) + abs(t(2, 3)) > 0.0_wp
      end associate
      if (turn%there) then
         call self%forces%set(system%effects, forces, turn%to_relative(self%b), self%dt)
      else
         call self%forces%set(system%effects, forces, self%b, self%dt)
      end if
      plain = .not. (turn%there .or. present(wheels) .or. size(tangent%parametric) > 0)
      call set_matrices(self, inertia_at(system, self%middle), forces%active, plain, turn, status)
      if (status%code /= 0) return
      if (.not. plain) then
         call move_extended(self, system, forces, turn, wheels, spheres, tangent)
         return
      end if
      if (self%forces%has_torques) then
         call find_plain_rows(self, by_start, by_mean)
         ! Changes are summed first, and added once: works grow large beside sensitivities that decay.
         if (self%forces%follows_attitude) then
            call set_products(tangent%n, by_start, tangent%theta, by_mean, tangent%momentum, tangent%change)
         else
            call set_product(tangent%n, by_mean, tangent%momentum, tangent%change)
         end if
      end if
      call move_plain(self, tangent)
      if (self%forces%has_torques) &
         call add_products(tangent%n, tangent%change, by_mean, tangent%momentum, tangent%work)
   end subroutine propagate

   !> Adds the contributions of wheels with friction to h and T.
   subroutine add_wheels(self, system, wheels)
      type(conserving_step_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(wheel_steps_t), intent(in) :: wheels
      real(wp) :: inverse(3, 3)
      self%rotor = self%rotor + (4/self%dt)*times_vector(wheels%coupling, self%b)
      inverse = inverse_inertia_at(system, self%middle)
      call wheels%add_to_inverse(system%effects, inverse)
      self%turn_by_mean = (0.25_wp*self%dt)*inverse
   end subroutine add_wheels

   !> Moves sensitivities with all terms of parameters, wheels, torques and rotating axes.
   subroutine move_extended(self, system, forces, turn, wheels, spheres, tangent)
      type(conserving_step_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(discrete_forces_t), intent(in) :: forces
      type(frame_turn_t), intent(in) :: turn
      !> Present if there are wheels, or inner spheres.
      type(wheel_steps_t), intent(in), optional :: wheels
      type(sphere_steps_t), intent(in), optional :: spheres
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: half_swing(3, 3), by_mid(3), by_turn(3), torque(tangent%n, 3)
      logical :: extended
      integer :: i
      call half_swing_back(self%forces%r, self%forces%shrink, half_swing)
      if (present(spheres)) call begin_spheres(spheres, system%effects, self%frame, self%forces%r, tangent, torque)
      call find_changes(self, half_swing, tangent%n, tangent%theta, tangent%momentum, tangent%mid, tangent%change)
      if (present(spheres)) call add_sphere_torques(self, torque, tangent)
      extended = present(wheels) .or. size(tangent%parametric) > 0
      if (extended .or. turn%there) tangent%shift = 0.0_wp
      if (extended) then
         tangent%mean = 0.0_wp
         do i = 1, system%effects%n_reaction_wheels
            call begin_wheel(system%effects%wheels(i)%axis, wheels%share(i), tangent%wheels(:, i), &
                             tangent%inner(:, i), tangent%mean)
         end do
         do i = 1, size(tangent%parametric)
            call add_parameters(self, system, forces, turn, wheels, tangent, i)
         end do
         call change_by_mean(self, tangent%n, tangent%mean, tangent%change)
         tangent%turn = tangent%momentum + tangent%change - tangent%mean
      else
         tangent%turn = tangent%momentum + tangent%change
      end if
      call rotate_sensitivities(self%turn_by_mean, tangent%n, tangent%turn)
      do i = 1, system%effects%n_reaction_wheels
         call finish_wheel(self, system%effects%wheels(i), wheels, i, tangent)
      end do
      tangent%momentum = tangent%momentum + 2*tangent%change
      if (turn%there) then
         call shift_sensitivities(self, tangent%n, tangent%mid, tangent%turn, tangent%shift)
         tangent%turn = tangent%shift
      end if
      if (self%forces%has_torques) then
         call find_work_rows(self%forces, by_mid, by_turn)
         call set_products(tangent%n, by_mid, tangent%mid, by_turn, tangent%turn, tangent%change)
         tangent%work(:) = tangent%work + tangent%change(:, 1)
      end if
      if (present(spheres)) call turn_spheres(spheres, system%effects, self%frame, self%forces%r, tangent)
      tangent%theta = tangent%mid + (4*self%forces%shrink)*tangent%turn
      tangent%turn = tangent%theta
      call rotate_sensitivities(half_swing, tangent%n, tangent%turn)
      tangent%theta = tangent%theta + tangent%turn
      if (present(spheres)) call finish_spheres(spheres, system%effects, self%forces%r, tangent)
   end subroutine move_extended

   !> Adds the changes of y and of the works by those of the torque of inner spheres at fixed r and attitude.
   subroutine add_sphere_torques(self, torque, tangent)
      type(conserving_step_t), intent(in) :: self
      !> N m; shape (n, 3).
      real(wp), intent(in) :: torque(:, :)
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: rhs(3)
      integer :: k
      do k = 1, tangent%n
         rhs = (0.5_wp*self%dt)*(torque(k, :)/self%forces%shrink - (2*dot_product(self%b, torque(k, :)))*self%forces%r)
         tangent%change(k, :) = tangent%change(k, :) + times_vector(self%inverse, rhs)
         tangent%work(k) = tangent%work(k) + 4*dot_product(self%forces%r, torque(k, :))
      end do
   end subroutine add_sphere_torques

   !> Sets M⁻¹ with all its terms, and the matrices of the sensitivities.
   pure subroutine set_matrices(self, inertia, active, plain, turn, status)
      type(conserving_step_t), intent(inout) :: self
      !> J, shape (3,3).
      real(wp), intent(in) :: inertia(3, 3)
      !> True if there are effects with a force; true if M⁻¹ itself is not needed.
      logical, intent(in) :: active, plain
      type(frame_turn_t), intent(in) :: turn
      type(status_t), intent(inout) :: status
      real(wp) :: s(3, 3), inverse(3, 3), force(3, 3), by_start(3, 3), mean(3), change(3), rest, rate
      associate (b => self%b, j => inertia)
         rest = 1 - (b(1)*b(1) + b(2)*b(2) + b(3)*b(3))
         if (turn%there) then
            rest = rest + turn%square
            call set_frame(self, turn)
         end if
         rate = 2*self%forces%rate
         mean(1) = rate*(j(1, 1)*b(1) + j(1, 2)*b(2) + j(1, 3)*b(3)) + 2*self%rotor(1)
         mean(2) = rate*(j(2, 1)*b(1) + j(2, 2)*b(2) + j(2, 3)*b(3)) + 2*self%rotor(2)
         mean(3) = rate*(j(3, 1)*b(1) + j(3, 2)*b(2) + j(3, 3)*b(3)) + 2*self%rotor(3)
         change(1) = mean(1) - 2*self%momentum(1)
         change(2) = mean(2) - 2*self%momentum(2)
         change(3) = mean(3) - 2*self%momentum(3)
         if (active) call find_forces(self, turn%there, change, force, by_start)
         s(1, 1) = b(1)*change(1)
         s(2, 1) = b(1)*change(2) + mean(3)
         s(3, 1) = b(1)*change(3) - mean(2)
         s(1, 2) = b(2)*change(1) - mean(3)
         s(2, 2) = b(2)*change(2)
         s(3, 2) = b(2)*change(3) + mean(1)
         s(1, 3) = b(3)*change(1) + mean(2)
         s(2, 3) = b(3)*change(2) - mean(1)
         s(3, 3) = b(3)*change(3)
      end associate
      if (active) call add_multiple(1.0_wp, force, s)
      call finish_matrix(self, s)
      call invert(rest, s, inverse, status)
      if (status%code /= 0) return
      if (.not. plain) self%inverse = inverse
      call multiply(inverse, s, self%by_momentum)
      if (turn%there) then
         if (.not. active) by_start = 0.0_wp
         by_start = by_start - (2*self%forces%shrink)*times_columns(times_columns(self%by_relative, self%by_turn), &
                                                                    self%forces%back)
      end if
      self%by_start = 0.0_wp
      if (active .or. turn%there) call multiply(inverse, by_start, self%by_start)
   end subroutine set_matrices

   !> Completes S from the matrix that is to be multiplied by T.
   pure subroutine finish_matrix(self, s)
      type(conserving_step_t), intent(in) :: self
      real(wp), intent(inout) :: s(3, 3)
      real(wp) :: full(3, 3), x, y, z
      associate (b => self%b, t => self%turn_by_mean)
         x = 2*b(1)
         y = 2*b(2)
         z = 2*b(3)
         if (self%is_diagonal) then
            s(1, 1) = t(1, 1)*s(1, 1)
            s(2, 1) = t(1, 1)*s(2, 1) - z
            s(3, 1) = t(1, 1)*s(3, 1) + y
            s(1, 2) = t(2, 2)*s(1, 2) + z
            s(2, 2) = t(2, 2)*s(2, 2)
            s(3, 2) = t(2, 2)*s(3, 2) - x
            s(1, 3) = t(3, 3)*s(1, 3) - y
            s(2, 3) = t(3, 3)*s(2, 3) + x
            s(3, 3) = t(3, 3)*s(3, 3)
         else
            full = s
            s = times_columns(full, t)
            call add_cross(-2*b, s)
         end if
      end associate
   end subroutine finish_matrix

   !> Adds [v]× to a matrix.
   pure subroutine add_cross(v, matrix)
      real(wp), intent(in) :: v(3)
      real(wp), intent(inout) :: matrix(3, 3)
      matrix(2, 1) = matrix(2, 1) + v(3)
      matrix(3, 1) = matrix(3, 1) - v(2)
      matrix(1, 2) = matrix(1, 2) - v(3)
      matrix(3, 2) = matrix(3, 2) + v(1)
      matrix(1, 3) = matrix(1, 3) + v(2)
      matrix(2, 3) = matrix(2, 3) - v(1)
   end subroutine add_cross

   !> Computes (rest·1 - s)⁻¹ from the adjugate. Errors: `NUTATE_SINGULAR`.
   pure subroutine invert(rest, s, inverse, status)
      real(wp), intent(in) :: rest, s(3, 3)
      real(wp), intent(out) :: inverse(3, 3)
      type(status_t), intent(inout) :: status
      real(wp) :: m(3), row(3), determinant, factor
      m(1) = rest - s(1, 1)
      m(2) = rest - s(2, 2)
      m(3) = rest - s(3, 3)
      row(1) = m(2)*m(3) - s(3, 2)*s(2, 3)
      row(2) = s(3, 2)*s(1, 3) + s(1, 2)*m(3)
      row(3) = s(1, 2)*s(2, 3) + m(2)*s(1, 3)
      determinant = m(1)*row(1) - s(2, 1)*row(2) - s(3, 1)*row(3)
      if (.not. abs(determinant) > least_determinant) then
         status = fail(NUTATE_SINGULAR, 'the linear system of the step is singular')
         return
      end if
      factor = 1/determinant
      inverse(1, 1) = factor*row(1)
      inverse(1, 2) = factor*row(2)
      inverse(1, 3) = factor*row(3)
      inverse(2, 1) = factor*(s(2, 3)*s(3, 1) + s(2, 1)*m(3))
      inverse(2, 2) = factor*(m(1)*m(3) - s(3, 1)*s(1, 3))
      inverse(2, 3) = factor*(s(2, 1)*s(1, 3) + m(1)*s(2, 3))
      inverse(3, 1) = factor*(s(2, 1)*s(3, 2) + s(3, 1)*m(2))
      inverse(3, 2) = factor*(s(3, 1)*s(1, 2) + m(1)*s(3, 2))
      inverse(3, 3) = factor*(m(1)*m(2) - s(2, 1)*s(1, 2))
   end subroutine invert

   !> Sets D and ∂e/∂φ = -D[δ̄]×.
   pure subroutine set_frame(self, turn)
      type(conserving_step_t), intent(inout) :: self
      type(frame_turn_t), intent(in) :: turn
      self%by_absolute = turn%relative_by_absolute(self%b, self%forces%r)
      self%by_turn = 0.0_wp
      call add_cross(self%forces%r - self%b, self%by_turn)
      self%by_turn = times_columns(self%by_absolute, self%by_turn)
      self%by_relative = 0.0_wp
   end subroutine set_frame

   !> Computes the effects' part of -A, -Δt rτ̄ᵀ - BD, and the derivative of -Cδτ̄ by θ0. If D = 1, and r = b, the part
   !> of B along rᵀ is added to the factor of bᵀ instead.
   pure subroutine find_forces(self, relative, change, force, by_start)
      type(conserving_step_t), intent(inout) :: self
      !> True if D is not 1.
      logical, intent(in) :: relative
      !> 2(L̄ - L0), the factor of bᵀ; shape (3).
      real(wp), intent(inout) :: change(3)
      !> Shape (3,3).
      real(wp), intent(out) :: force(3, 3), by_start(3, 3)
      real(wp) :: v(3), along, share, x(3, 3)
      logical :: simple
      simple = .not. (self%forces%has_torques .or. self%forces%is_curved)
      associate (b => self%b, r => self%forces%r, impulse => self%forces%impulse, working => self%forces%working)
         v(1) = (2*self%forces%shrink)*r(1)
         v(2) = (2*self%forces%shrink)*r(2)
         v(3) = (2*self%forces%shrink)*r(3)
         x = self%forces%by_mid
         ! F is the leftmost factor of all terms, and is applied where it costs least.
         if (simple) call project(v, b, x)
         call turn_by_relative(x, r, force)
         if (self%forces%has_torques) call add_multiple(2/self%forces%shrink, self%forces%working_by_rate, force)
         if (self%forces%is_curved) then
            call add_multiple(2.0_wp, self%forces%by_end, force)
            call add_multiple(1.0_wp, self%forces%by_end, x)
         end if
         call multiply(x, self%forces%back, by_start)
         if (self%forces%is_curved) call add_multiple(1.0_wp, self%forces%by_start, by_start)
         if (.not. simple) then
            call project(v, b, force)
            call project(v, b, by_start)
         end if
         along = b(1)*impulse(1) + b(2)*impulse(2) + b(3)*impulse(3)
         force(1, 1) = force(1, 1) - along
         force(2, 2) = force(2, 2) - along
         force(3, 3) = force(3, 3) - along
         share = along
         if (self%forces%has_torques) share = along - (b(1)*working(1) + b(2)*working(2) + b(3)*working(3))
         v(1) = share*v(1)
         v(2) = share*v(2)
         v(3) = share*v(3)
         if (self%forces%has_torques) then
            v(1) = v(1) + working(1)
            v(2) = v(2) + working(2)
            v(3) = v(3) + working(3)
         end if
         if (relative) then
            call add_outer(1.0_wp, v, r, force)
            self%by_relative = -force
            force = times_columns(force, self%by_absolute)
         else
            change(1) = change(1) + v(1)
            change(2) = change(2) + v(2)
            change(3) = change(3) + v(3)
         end if
         call add_outer(-1.0_wp, r, impulse, force)
      end associate
   end subroutine find_forces

   !> Multiplies a matrix by F from the left.
   pure subroutine project(v, b, x)
      !> v = 2r/(1+ρ); shape (3).
      real(wp), intent(in) :: v(3), b(3)
      real(wp), intent(inout) :: x(3, 3)
      real(wp) :: along(3)
      along(1) = b(1)*x(1, 1) + b(2)*x(2, 1) + b(3)*x(3, 1)
      along(2) = b(1)*x(1, 2) + b(2)*x(2, 2) + b(3)*x(3, 2)
      along(3) = b(1)*x(1, 3) + b(2)*x(2, 3) + b(3)*x(3, 3)
      call add_outer(-1.0_wp, v, along, x)
   end subroutine project

   !> Computes x(1 - [r]×).
   pure subroutine turn_by_relative(x, r, product)
      real(wp), intent(in) :: x(3, 3), r(3)
      real(wp), intent(out) :: product(3, 3)
      product(1, 1) = x(1, 1) - (x(1, 2)*r(3) - x(1, 3)*r(2))
      product(2, 1) = x(2, 1) - (x(2, 2)*r(3) - x(2, 3)*r(2))
      product(3, 1) = x(3, 1) - (x(3, 2)*r(3) - x(3, 3)*r(2))
      product(1, 2) = x(1, 2) - (x(1, 3)*r(1) - x(1, 1)*r(3))
      product(2, 2) = x(2, 2) - (x(2, 3)*r(1) - x(2, 1)*r(3))
      product(3, 2) = x(3, 2) - (x(3, 3)*r(1) - x(3, 1)*r(3))
      product(1, 3) = x(1, 3) - (x(1, 1)*r(2) - x(1, 2)*r(1))
      product(2, 3) = x(2, 3) - (x(2, 1)*r(2) - x(2, 2)*r(1))
      product(3, 3) = x(3, 3) - (x(3, 1)*r(2) - x(3, 2)*r(1))
   end subroutine turn_by_relative

   !> Moves sensitivities without terms of their own in the step.
   subroutine move_plain(self, tangent)
      type(conserving_step_t), intent(in) :: self
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: swing(3, 3), rotated(3, 3)
      integer :: n
      call full_swing_back(self%forces%r, self%forces%shrink, swing)
      call set_rotated(self, rotated)
      associate (p => self%by_start, w => self%by_momentum, even => tangent%even)
         n = tangent%n
         if (modulo(n, 2) == 0) then
            call move_pairs(n/2, p, w, swing, rotated, tangent%theta, tangent%momentum)
         else
            even(:n, :3) = tangent%theta
            even(:n, 4:) = tangent%momentum
            call move_pairs((n + 1)/2, p, w, swing, rotated, even(:, :3), even(:, 4:))
            tangent%theta = even(:n, :3)
            tangent%momentum = even(:n, 4:)
         end if
      end associate
   end subroutine move_plain

   !> Computes 4RhT/(1+ρ).
   pure subroutine set_rotated(self, rotated)
      type(conserving_step_t), intent(in) :: self
      real(wp), intent(out) :: rotated(3, 3)
      real(wp) :: factor, x, y, z
      factor = 8*self%forces%shrink**2
      associate (back => self%forces%back, t => self%turn_by_mean)
         if (self%is_diagonal) then
            x = factor*t(1, 1)
            y = factor*t(2, 2)
            z = factor*t(3, 3)
            rotated(1, 1) = x*back(1, 1)
            rotated(2, 1) = x*back(2, 1)
            rotated(3, 1) = x*back(3, 1)
            rotated(1, 2) = y*back(1, 2)
            rotated(2, 2) = y*back(2, 2)
            rotated(3, 2) = y*back(3, 2)
            rotated(1, 3) = z*back(1, 3)
            rotated(2, 3) = z*back(2, 3)
            rotated(3, 3) = z*back(3, 3)
         else
            rotated = factor*times_columns(back, t)
         end if
      end associate
   end subroutine set_rotated

   !> Computes the derivatives by θ0, and by both δL0 and δL1, of the work of the torques, 4r·τ, for sensitivities
   !> without terms of their own: δr = ½T(δL0 + δL1).
   pure subroutine find_plain_rows(self, by_start, by_mean)
      type(conserving_step_t), intent(in) :: self
      !> Shape (3).
      real(wp), intent(out) :: by_start(3), by_mean(3)
      real(wp) :: by_mid(3), by_turn(3)
      call find_work_rows(self%forces, by_mid, by_turn)
      by_start = by_mid
      if (self%forces%follows_attitude) call multiply_row(2*self%forces%shrink, by_mid, self%forces%back, by_start)
      call multiply_row(0.5_wp, by_turn, self%turn_by_mean, by_mean)
   end subroutine find_plain_rows

   !> Computes a multiple of a row times a matrix.
   pure subroutine multiply_row(factor, row, m, product)
      real(wp), intent(in) :: factor, row(3), m(3, 3)
      real(wp), intent(out) :: product(3)
      product(1) = factor*(row(1)*m(1, 1) + row(2)*m(2, 1) + row(3)*m(3, 1))
      product(2) = factor*(row(1)*m(1, 2) + row(2)*m(2, 2) + row(3)*m(3, 2))
      product(3) = factor*(row(1)*m(1, 3) + row(2)*m(2, 3) + row(3)*m(3, 3))
   end subroutine multiply_row

   !> Computes φ and y of sensitivities without parameters of their own.
   pure subroutine find_changes(self, half_swing, n, theta, momentum, mid, change)
      type(conserving_step_t), intent(in) :: self
      !> Rh - 1; shape (3,3).
      real(wp), intent(in) :: half_swing(3, 3)
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(in) :: theta(n, 3), momentum(n, 3)
      real(wp), intent(out) :: mid(n, 3), change(n, 3)
      integer :: i, j
      associate (h => half_swing, w => self%by_momentum, p => self%by_start)
         do j = 1, 3
            do i = 1, n
               mid(i, j) = theta(i, j) + (h(j, 1)*theta(i, 1) + h(j, 2)*theta(i, 2) + h(j, 3)*theta(i, 3))
               change(i, j) = (w(j, 1)*momentum(i, 1) + w(j, 2)*momentum(i, 2) + w(j, 3)*momentum(i, 3)) &
                              + (p(j, 1)*theta(i, 1) + p(j, 2)*theta(i, 2) + p(j, 3)*theta(i, 3))
            end do
         end do
      end associate
   end subroutine find_changes

   !> Adds δL̄ of a wheel at fixed b, from its momentum at the start alone.
   pure subroutine begin_wheel(axis, share, start, inner, mean)
      !> s, shape (3), and σ.
      real(wp), intent(in) :: axis(3), share
      !> δh0, and δh̄ at fixed b, N m s; shape (n).
      real(wp), intent(in) :: start(:)
      real(wp), intent(out) :: inner(:)
      !> Shape (n,3).
      real(wp), intent(inout) :: mean(:, :)
      integer :: j
      inner = share*start
      do j = 1, 3
         mean(:, j) = mean(:, j) + axis(j)*inner
      end do
   end subroutine begin_wheel

   !> Adds the changes by a sensitivity's parameters in the step: of L̄ at fixed b, of y and r, and of the works.
   subroutine add_parameters(self, system, forces, turn, wheels, tangent, m)
      class(conserving_step_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(discrete_forces_t), intent(in) :: forces
      type(frame_turn_t), intent(in) :: turn
      type(wheel_steps_t), intent(in), optional :: wheels
      type(tangent_t), intent(inout) :: tangent
      !> Index of the parametric sensitivity.
      integer, intent(in) :: m
      real(wp) :: mean(3), rhs(3), torque(3), working(3), shift(3)
      integer :: k
      k = tangent%parametric(m)
      associate (variation => tangent%variations(k), b => self%b, rate => self%forces%rate)
         mean = rate*times_vector(tangent%inertia_of(system%effects, m, self%middle), b) + variation%rotor
         if (present(wheels)) call add_wheel_parameters(self, system%effects%wheels, wheels, variation, mean, &
                                                     tangent%inner(k, :), tangent%work(k))
         rhs = 0.0_wp
         if (forces%active) then
            call self%forces%own_change(system%effects, forces, variation, torque, working)
            if (forces%reshapes) torque = torque + self%forces%reshaped_change( &
                                 system%effects, forces, variation, tangent%inertia_of(system%effects, m, self%middle))
            rhs = (0.5_wp*self%dt)*(torque/self%forces%shrink - (2*dot_product(b, torque))*self%forces%r)
            tangent%work(k) = tangent%work(k) + 4*dot_product(self%forces%r, working)
         end if
         if (turn%there) then
            shift = (-0.5_wp*self%dt*self%forces%shrink)*times_vector(self%by_absolute, times_vector( &
                                               self%forces%back, rotate_to_body(self%frame, variation%frame)))
            tangent%shift(k, :) = shift
            rhs = rhs - times_vector(self%by_relative, shift) &
                  - (2*(0.25_wp*self%dt)**2*dot_product(turn%rate, variation%frame))*( &
                  self%forces%rate*times_vector(inertia_at(system, self%middle), b) + self%rotor - self%momentum)
         end if
         tangent%change(k, :) = tangent%change(k, :) + times_vector(self%inverse, rhs)
         tangent%mean(k, :) = tangent%mean(k, :) + mean
      end associate
   end subroutine add_parameters

   !> Adds the changes by parameters of wheels and motors, at fixed b: of L̄, and of h̄ and the works of wheels.
   pure subroutine add_wheel_parameters(self, wheels, steps, variation, mean, inner, work)
      type(conserving_step_t), intent(in) :: self
      !> Wheels of the system; shape (n_wheels).
      type(wheel_t), intent(in) :: wheels(:)
      type(wheel_steps_t), intent(in) :: steps
      type(variation_t), intent(in) :: variation
      real(wp), intent(inout) :: mean(3), inner(:), work
      ! Placeholders: motors that follow attitude and rate have no such steps.
      real(wp), parameter :: unturned(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], at_rest(3) = 0.0_wp
      real(wp) :: half, base, rotated, share, coupling, own, drive, speed, axis(3), moved
      integer :: i, m
      if (.not. allocated(variation%effects)) return
      do m = 1, size(variation%effects)
         if (variation%effects(m)%kind /= OF_WHEEL) cycle
         i = variation%effects(m)%place
         if (wheels(i)%component > 0) cycle
         associate (wheel => wheels(i), c => variation%effects(m)%change, sigma => steps%share(i))
            half = 0.5_wp*self%dt
            base = steps%start_momentum(i) + half*steps%drive(i)
            rotated = self%forces%rate*dot_product(wheel%axis, self%b)
            share = -half*sigma**2*(c(6) - wheel%friction*c(4)/wheel%inertia)/wheel%inertia
            coupling = half*(c(6)*sigma + wheel%friction*share)
            axis = axis_change(wheel, c)
            moved = self%forces%rate*dot_product(axis, self%b)
            drive = 0.0_wp
            if (steps%drives(i)) drive = wheel%drive_change(c, steps%asked(i), unturned, at_rest)
            own = share*base + sigma*half*drive + coupling*rotated &
                  + half*wheel%friction*sigma*moved
            speed = sigma*(base/wheel%inertia - rotated)
            inner(i) = inner(i) + own
            mean = mean + own*wheel%axis + (sigma*base + half*wheel%friction*sigma*rotated)*axis
            work = work + self%dt*(drive - c(6)*speed)*speed &
                   - self%dt*(steps%drive(i) - 2*wheel%friction*speed)*( &
                   (sigma*base + half*wheel%friction*sigma*rotated)*c(4)/wheel%inertia**2 + moved)
         end associate
      end do
   end subroutine add_wheel_parameters

   !> Adds the change of y by δL̄ at fixed b: M⁻¹(R δL̄ - 2b×δL̄).
   pure subroutine change_by_mean(self, n, mean, change)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(in) :: mean(n, 3)
      real(wp), intent(inout) :: change(n, 3)
      real(wp) :: m(3, 3)
      integer :: i, j
      m = 0.0_wp
      call add_cross(-2*self%b, m)
      m = times_columns(self%inverse, m) - self%by_momentum
      do j = 1, 3
         do i = 1, n
            change(i, j) = change(i, j) + (m(j, 1)*mean(i, 1) + m(j, 2)*mean(i, 2) + m(j, 3)*mean(i, 3))
         end do
      end do
   end subroutine change_by_mean

   !> Computes δh1 of a wheel, and adds the changes of the works of motor and friction.
   pure subroutine finish_wheel(self, wheel, steps, i, tangent)
      type(conserving_step_t), intent(in) :: self
      type(wheel_t), intent(in) :: wheel
      type(wheel_steps_t), intent(in) :: steps
      !> Index of the wheel.
      integer, intent(in) :: i
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: rotated, inner, coupling, speed, factor
      integer :: k
      coupling = 0.5_wp*self%dt*wheel%friction*steps%share(i)
      speed = steps%share(i)*((steps%start_momentum(i) + 0.5_wp*self%dt*steps%drive(i))/wheel%inertia &
                              - self%forces%rate*dot_product(wheel%axis, self%b))
      factor = self%dt*(steps%drive(i) - 2*wheel%friction*speed)
      do k = 1, tangent%n
         rotated = self%forces%rate*dot_product(wheel%axis, tangent%turn(k, :))
         inner = tangent%inner(k, i) + coupling*rotated
         tangent%work(k) = tangent%work(k) + factor*(inner/wheel%inertia - rotated)
         tangent%wheels(k, i) = 2*inner - tangent%wheels(k, i)
      end do
   end subroutine finish_wheel

   !> Computes δr of sensitivities from φ and δb; on entry `shift` holds the part by their own parameters.
   pure subroutine shift_sensitivities(self, n, mid, turn, shift)
      type(conserving_step_t), intent(in) :: self
      integer, intent(in) :: n
      !> Shape (n,3).
      real(wp), intent(in) :: mid(n, 3), turn(n, 3)
      real(wp), intent(inout) :: shift(n, 3)
      integer :: i, j
      associate (d => self%by_absolute, e => self%by_turn)
         do j = 1, 3
            do i = 1, n
               shift(i, j) = shift(i, j) + (d(j, 1)*turn(i, 1) + d(j, 2)*turn(i, 2) + d(j, 3)*turn(i, 3)) &
                             + (e(j, 1)*mid(i, 1) + e(j, 2)*mid(i, 2) + e(j, 3)*mid(i, 3))
            end do
         end do
      end associate
   end subroutine shift_sensitivities

   !> Computes the derivatives of the work of the torques, 4r·τ, by φ, 0 unless torques depend on the attitude, and by
   !> δr; shape (3).
   pure subroutine find_work_rows(forces, by_mid, by_turn)
      type(forces_tangent_t), intent(in) :: forces
      real(wp), intent(out) :: by_mid(3), by_turn(3)
      real(wp) :: by_rate(3), twice
      associate (r => forces%r)
         call multiply_row(4*forces%rate, r, forces%working_by_rate, by_rate)
         by_turn(1) = forces%rate*forces%working(1) + by_rate(1)
         by_turn(2) = forces%rate*forces%working(2) + by_rate(2)
         by_turn(3) = forces%rate*forces%working(3) + by_rate(3)
         by_mid = 0.0_wp
         if (.not. forces%follows_attitude) return
         call multiply_row(4.0_wp, r, forces%working_by_mid, by_mid)
         twice = 2*forces%shrink
         by_turn(1) = by_turn(1) + twice*(by_mid(1) - (by_mid(2)*r(3) - by_mid(3)*r(2)))
         by_turn(2) = by_turn(2) + twice*(by_mid(2) - (by_mid(3)*r(1) - by_mid(1)*r(3)))
         by_turn(3) = by_turn(3) + twice*(by_mid(3) - (by_mid(1)*r(2) - by_mid(2)*r(1)))
      end associate
   end subroutine find_work_rows

end module nutate_step_tangent
