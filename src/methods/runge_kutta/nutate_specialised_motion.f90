!> Steps of the Runge-Kutta method of order 8 for free bodies and for bodies in uniform fields, in variables with short
!> equations.
!>
!> With `s = t/Δt` and `w = ½ΔtΩ` the only factors in the equations are constants, which are multiplied by the step
!> beforehand:
!>
!>     q' = q∘w,   wᵢ' = κᵢ wⱼwₖ + ½Δt²(m×γ)ᵢ/Jᵢ,   κ₁ = 2(J₂ - J₃)/J₁, ...
!>
!> γ is a row of R(q), homogeneous in q: nothing is normalised in a stage.
!>
!> * **Free bodies**: w alone is integrated. The attitude follows from the angle φ about the fixed l, a quadrature. With
!>   u = L/|l| and u₀ at the start of the step, R = R₀ Rot(u₀, φ) S, S the shortest rotation from u to u₀, and
!>   `φ̇ = (u₀ + u)·Ω/(1 + u₀·u)`; u·Ω = 2T/|l| is constant.
!> * **Potentials linear in directions**: V = -Σ m·Rᵀn, summed into the matrix Σ m nᵀ. If all n are parallel, the space
!>   axes are rotated so that n is the third one, and γ the third row of R alone.
!> * **Symmetric tops**, J₁ = J₂ and all m along axis 3, are integrated as bodies with J₃' = 3J₁/2, in whose axes the
!>   top rotates about its own by `(1/J₃ - 1/J₃')L₃Δt` exactly. There q, at the rate `L₃/2J₃'`, and the momentum across
!>   the axis, at `(1/J₁ - 1/J₃')L₃`, change equally fast.
!> * **Rotating space axes**, at ω: q' = q∘w - φ∘q with φ = ½Δtω.
module nutate_specialised_motion
   use nutate_attitude, only: quat_to_third_axis
   use nutate_effect_list, only: effect_list_t
   use nutate_invariants, only: common_direction, ALL_COMPONENTS, ALONG_AXIS
   use nutate_kinds, only: wp
   use nutate_specialised_stages, only: sensitivity_stages, free_stages, heavy_stages, specialised_rates_t, &
      steady_ratio, evaluate_field_stage, &
      evaluate_rotating_field_stage, evaluate_rotating_stage, evaluate_upright_stage
   use nutate_limits, only: manifold_tolerance
   use nutate_order_eight, only: n_stages
   use nutate_quaternion, only: quat_conjugate, quat_product, quat_vector_product, rotate_to_body, &
      rotate_to_space
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: specialised_motion_t

   !> Largest product of w and the constants of the equations: a longer step does not follow the motion, and from 14 on
   !> stages could overflow, since each may square the one before.
   real(wp), parameter :: longest = 10.0_wp
   !> Largest rate that is used, 1/s or 1/s²; larger ones are replaced by it.
   real(wp), parameter :: fastest = 1e150_wp
   !> Limits of ½Δt/J, with a representable reciprocal; other steps use the general equations.
   real(wp), parameter :: least_half = 1e-150_wp, greatest_half = 1e150_wp

   !> Largest number of pairs of sensitivities that are propagated through the stages together.
   integer, parameter :: most_pairs = 6

   !> Data of a system that do not change from step to step.
   type :: specialised_motion_t
      private
      !> True if the system is one of those above.
      logical, public :: possible = .false.
      !> True if there is no force; all directions are parallel; the body is a symmetric top; the space axes of the
      !> equations are others.
      logical, public :: free = .true.
      logical :: single = .true., symmetric = .false., rotated = .false.
      !> True if the space axes rotate; their rate in the space axes of the equations, rad/s; shape (3).
      logical :: frame_turns = .false.
      real(wp) :: frame_rate(3) = 0.0_wp
      !> The first body axis of the equations, 1 to 3; the others follow cyclically, and space axes with them.
      integer :: first = 1
      !> Principal moments of the equations in that order, kg m²; shape (3).
      real(wp) :: moments(3) = 1.0_wp
      !> Space axes of the equations ← space axes; unit quaternion.
      real(wp) :: space(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> κ of the rates, shape (3); their constants in uniform fields, not allocated if there is no force.
      real(wp) :: kappa(3) = 0.0_wp
      type(specialised_rates_t), allocatable :: rates
      !> Δt, s; ½Δt/J and its reciprocal; J₃'/J₃ - 1 for the spin, or 0.
      real(wp) :: dt = 0.0_wp, half(3) = 0.0_wp, back(3) = 0.0_wp, spin = 0.0_wp
      !> Factor of |w| in the test whether a step is too long; the term that torques and rotating axes add.
      real(wp) :: stiffness = 3.0_wp, pulled = 0.0_wp
   contains
      !> Classifies a system.
      procedure :: prepare
      !> Sets the length of a step, and determines whether the equations can be used with it.
      procedure :: fits
      !> Performs one step.
      procedure :: move
      !> Moves sensitivities over a step.
      procedure :: propagate
      !> Returns about the largest rate of a motion in these variables.
      procedure :: pace
      !> Returns the axis of a symmetric top that rotates in the frame of its steps.
      procedure :: spin_axis
   end type specialised_motion_t

contains

   !> Classifies a system: the equations need a diagonal inertia, no torques and rotors, and only potentials that are
   !> linear in directions.
   pure subroutine prepare(self, system, attitude)
      class(specialised_motion_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> True if the attitude is integrated, as these steps require.
      logical, intent(in) :: attitude
      real(wp) :: axis(3)
      integer :: components
      self%dt = 0.0_wp
      associate (effects => system%effects, inertia => system%body%inertia)
         self%possible = attitude .and. effects%n_torques + effects%n_rotors == 0 .and. are_linear(effects) .and. &
                         .not. any(abs(effects%rotor_momentum) > 0.0_wp) .and. &
                         .not. any(abs([inertia(1, 2), inertia(1, 3), inertia(2, 3)]) > 0.0_wp)
         if (.not. self%possible) return
         call common_direction(effects, components, axis)
         self%free = components == ALL_COMPONENTS
         self%frame_turns = effects%frame_turns
         if (self%free .and. self%frame_turns) self%possible = .false.
         if (.not. self%possible) return
         self%single = components == ALONG_AXIS
         self%first = 1
         if (.not. self%free) self%first = first_axis(effects, system%body%moments)
         self%moments = from_axis(system%body%moments, self%first - 1)
         self%space = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         if (self%single) self%space = quat_to_third_axis(from_axis(axis, self%first - 1))
         self%rotated = any(abs(self%space(2:4)) > 0.0_wp)
         self%frame_rate = rotate_to_space(self%space, from_axis(effects%frame_rate, self%first - 1))
         if (allocated(self%rates)) deallocate (self%rates)
         self%symmetric = .false.
         if (.not. self%free) call add_torques(self, effects, axis)
      end associate
      self%spin = 0.0_wp
      if (self%symmetric) then
         self%spin = steady_ratio*self%moments(1)/self%moments(3) - 1
         self%moments(3) = steady_ratio*self%moments(1)
      end if
      self%kappa = 2*(from_axis(self%moments, 1) - from_axis(self%moments, 2))/self%moments
      self%stiffness = max(3.0_wp, maxval(abs(self%kappa)))
      if (allocated(self%rates)) self%rates%kappa = self%kappa
   end subroutine prepare

   !> Returns true if all potentials are linear in a fixed direction.
   pure logical function are_linear(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      are_linear = .true.
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            if (potential%moves .or. potential%varies .or. .not. potential%is_linear()) are_linear = .false.
         end associate
      end do
   end function are_linear

   !> Returns the body axis that becomes the first: with two equal moments the one after the axis of symmetry, if all m
   !> lie on the latter.
   pure integer function first_axis(effects, moments) result(first)
      !> Linear potentials.
      type(effect_list_t), intent(in) :: effects
      !> Principal moments, kg m²; shape (3).
      real(wp), intent(in) :: moments(3)
      real(wp) :: off(3)
      integer :: axis, i
      first = 1
      do axis = 1, 3
         off = 0.0_wp
         do i = 1, effects%n_potentials
            off = off + abs(from_axis(effects%potentials(i)%item%series_moment(), axis))
         end do
         if (equal(moments(mod(axis, 3) + 1), moments(mod(axis + 1, 3) + 1)) .and. .not. off(1) + off(2) > 0.0_wp) &
            first = mod(axis, 3) + 1
      end do
   end function first_axis

   !> Returns the components in cyclic order after the first k: `cshift`, without a call of the library.
   pure function from_axis(v, k) result(shifted)
      real(wp), intent(in) :: v(3)
      !> Number of components to skip, 0 to 3.
      integer, intent(in) :: k
      real(wp) :: shifted(3)
      shifted(1) = v(1 + mod(k, 3))
      shifted(2) = v(1 + mod(k + 1, 3))
      shifted(3) = v(1 + mod(k + 2, 3))
   end function from_axis

   !> Returns true for equal numbers.
   elemental logical function equal(x, y)
      real(wp), intent(in) :: x, y
      equal = .not. abs(x - y) > 0.0_wp
   end function equal

   !> Sums Σ m nᵀ into the torques: those of all directions along n, or each of three axes; a top may be symmetric then.
   pure subroutine add_torques(self, effects, axis)
      type(specialised_motion_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Unit vector along all directions, if they are parallel; shape (3).
      real(wp), intent(in) :: axis(3)
      real(wp) :: m(3), n(3), along(3)
      integer :: i, k
      allocate (self%rates)
      along = from_axis(axis, self%first - 1)
      do i = 1, effects%n_potentials
         m = from_axis(effects%potentials(i)%item%series_moment(), self%first - 1)
         n = from_axis(effects%potentials(i)%item%direction, self%first - 1)
         if (self%single) n = [0.0_wp, 0.0_wp, sign(1.0_wp, along(3))*dot_product(n, along)]
         associate (torque => self%rates%torque)
            do k = 1, 3
               torque(1, 3, k) = torque(1, 3, k) + m(2)*n(k)
               torque(1, 2, k) = torque(1, 2, k) - m(3)*n(k)
               torque(2, 1, k) = torque(2, 1, k) + m(3)*n(k)
               torque(2, 3, k) = torque(2, 3, k) - m(1)*n(k)
               torque(3, 2, k) = torque(3, 2, k) + m(1)*n(k)
               torque(3, 1, k) = torque(3, 1, k) - m(2)*n(k)
            end do
         end associate
      end do
      associate (torque => self%rates%torque)
         self%symmetric = equal(self%moments(1), self%moments(2)) .and. .not. any(abs(torque(3, :, :)) > 0.0_wp) .and. &
                          .not. any(abs(torque(:, 3, :)) > 0.0_wp)
      end associate
   end subroutine add_torques

   !> Returns about the largest rate of a motion in these variables, 1/s: a falling body gains some 8 τ/J of Ω². A rate
   !> beyond all motions is replaced by the largest number that can be squared.
   pure real(wp) function pace(self, momentum)
      !> Motion with `possible` true.
      class(specialised_motion_t), intent(in) :: self
      !> Momentum of the body at the start, kg m²/s; shape (3).
      real(wp), intent(in) :: momentum(3)
      real(wp) :: rate(3), pull(3)
      integer :: i
      rate = from_axis(momentum, self%first - 1)
      do i = 1, 3
         rate(i) = bounded_ratio(rate(i), self%moments(i))
         pull(i) = 0.0_wp
         if (.not. self%free) pull(i) = bounded_ratio(maxval(abs(self%rates%torque(i, :, :))), self%moments(i))
      end do
      pace = sqrt(dot_product(rate, rate) + 8*maxval(pull))*sqrt(max(1.0_wp, maxval(abs(self%kappa))))
   end function pace

   !> Returns |x|/y, or the largest number that can be squared.
   elemental real(wp) function bounded_ratio(x, y) result(ratio)
      !> Numerator and denominator; `y` is positive.
      real(wp), intent(in) :: x, y
      ratio = fastest
      if (abs(x) < fastest*min(1.0_wp, y)) ratio = abs(x)/y
   end function bounded_ratio

   !> Returns the axis of a symmetric top that rotates in the frame of its steps, 1 to 3; 0 for other bodies.
   pure integer function spin_axis(self) result(axis)
      class(specialised_motion_t), intent(in) :: self
      axis = 0
      if (self%symmetric) axis = mod(self%first + 1, 3) + 1
   end function spin_axis

   !> Sets the length of a step. `yes` is false for one so short, or long, that the general equations are required.
   pure subroutine fits(self, dt, yes)
      class(specialised_motion_t), intent(inout) :: self
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      logical, intent(out) :: yes
      integer :: j, k
      yes = self%possible
      if (abs(dt - self%dt) <= 0.0_wp .or. .not. yes) return
      self%half = 0.5_wp*dt/self%moments
      yes = all(abs(self%half) >= least_half) .and. all(abs(self%half) <= greatest_half)
      self%dt = 0.0_wp
      if (.not. yes) return
      self%back = 1/self%half
      self%pulled = 0.0_wp
      if (.not. self%free) then
         associate (rates => self%rates)
            do k = 1, 3
               do j = 1, 3
                  rates%pull(:, j, k) = merge(1, 2, j == k)*((0.5_wp*dt*dt/self%moments)*rates%torque(:, j, k))
               end do
            end do
            self%pulled = sqrt(self%stiffness*maxval(abs(rates%pull)))
         end associate
      end if
      if (self%frame_turns) then
         self%rates%frame_turn = (0.5_wp*dt)*self%frame_rate
         self%pulled = self%pulled + maxval(abs(self%rates%frame_turn))
      end if
      self%dt = dt
   end subroutine fits

   !> Performs one step. `moved` is false, and the state unchanged, if the step is too long to follow the motion, or the
   !> state is not finite or off the constraint manifold.
   pure subroutine move(self, state, moved)
      class(specialised_motion_t), intent(in) :: self
      type(state_t), intent(inout) :: state
      logical, intent(out) :: moved
      real(wp) :: y(8), square, length, product
      associate (q => state%q, p => state%p)
         square = q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)
         length = p(1)*p(1) + p(2)*p(2) + p(3)*p(3) + p(4)*p(4)
         product = q(1)*p(1) + q(2)*p(2) + q(3)*p(3) + q(4)*p(4)
         moved = abs(square - 1) <= manifold_tolerance .and. product**2 <= manifold_tolerance**2*length .and. &
                 length <= huge(1.0_wp) .and. abs(state%t + self%dt) <= huge(1.0_wp)
         if (.not. moved) return
      end associate
      call read_motion(state, square, y)
      if (self%free) then
         call move_free(self, y, moved)
      else
         call move_heavy(self, y, moved)
      end if
      if (moved) moved = abs(y(5)) + abs(y(6)) + abs(y(7)) <= huge(1.0_wp)
      if (.not. moved) return
      state%q = inverse_root(y(1)*y(1) + y(2)*y(2) + y(3)*y(3) + y(4)*y(4))*y(1:4)
      state%p = quat_vector_product(state%q, 2*y(5:7))
      state%q_compensation = 0.0_wp
      state%p_compensation = 0.0_wp
      state%t = state%t + self%dt
   end subroutine move

   !> Computes [q, L, 0] of a state.
   pure subroutine read_motion(state, square, y)
      type(state_t), intent(in) :: state
      !> |q|², nearly 1.
      real(wp), intent(in) :: square
      real(wp), intent(out) :: y(8)
      real(wp) :: half
      ! This is 0.5/square, to first order near 1.
      half = 1 - 0.5_wp*square
      associate (q => state%q, p => state%p)
         y(5) = half*(q(1)*p(2) - q(2)*p(1) - q(3)*p(4) + q(4)*p(3))
         y(6) = half*(q(1)*p(3) - q(3)*p(1) - q(4)*p(2) + q(2)*p(4))
         y(7) = half*(q(1)*p(4) - q(4)*p(1) - q(2)*p(3) + q(3)*p(2))
         y(1:4) = q
         y(8) = 0.0_wp
      end associate
   end subroutine read_motion

   !> Returns 1/√x, from the first terms of its series if x is so near to 1 that the next is below ε: a root and a
   !> division would take as long as a stage, since each step needs the result of the one before.
   pure real(wp) function inverse_root(x)
      real(wp), intent(in) :: x
      real(wp) :: e
      e = x - 1
      if (abs(e) <= 1e-4_wp) then
         inverse_root = 1 - 0.5_wp*e*(1 - 0.75_wp*e*(1 - e/1.2_wp))
      else
         inverse_root = 1/sqrt(x)
      end if
   end function inverse_root

   !> Performs a step of a free body.
   pure subroutine move_free(self, y, followed)
      type(specialised_motion_t), intent(in) :: self
      !> [q, L, 0], |q| nearly 1 before and not normalised afterwards; shape (8).
      real(wp), intent(inout) :: y(8)
      logical, intent(out) :: followed
      real(wp) :: w(3), axis(3), along(3), last(3), change(4), turn(4), swing(4), angle, square, inverse
      w(1) = self%half(1)*y(5)
      w(2) = self%half(2)*y(6)
      w(3) = self%half(3)*y(7)
      followed = self%stiffness*max(abs(w(1)), abs(w(2)), abs(w(3))) <= longest
      if (.not. followed) return
      square = y(5)*y(5) + y(6)*y(6) + y(7)*y(7)
      if (square <= tiny(1.0_wp)) return
      inverse = 1/sqrt(square)
      axis = inverse*y(5:7)
      along = self%back*(inverse*axis)
      call free_stages(self%kappa, w, axis, along, change, angle, followed)
      if (.not. followed) return
      y(5:7) = y(5:7) + self%back*change(1:3)
      last = inverse*y(5:7)
      last = inverse_root(last(1)*last(1) + last(2)*last(2) + last(3)*last(3))*last
      swing(1) = 1 + (last(1)*axis(1) + last(2)*axis(2) + last(3)*axis(3))
      swing(2) = last(2)*axis(3) - last(3)*axis(2)
      swing(3) = last(3)*axis(1) - last(1)*axis(3)
      swing(4) = last(1)*axis(2) - last(2)*axis(1)
      turn(1) = cos(angle)
      turn(2:4) = sin(angle)*axis
      y(1:4) = quat_product(quat_product(y(1:4), turn), swing)
   end subroutine move_free

   !> Performs a step of a body in uniform fields.
   pure subroutine move_heavy(self, y, followed)
      type(specialised_motion_t), intent(in) :: self
      !> [q, L, 0], |q| nearly 1 before and not normalised afterwards; shape (8).
      real(wp), intent(inout) :: y(8)
      logical, intent(out) :: followed
      real(wp) :: change(8)
      call to_equations(self, y)
      followed = self%stiffness*max(abs(y(5)), abs(y(6)), abs(y(7))) + self%pulled <= longest
      if (.not. followed) return
      if (self%frame_turns) then
         if (self%single) then
            call heavy_stages(evaluate_rotating_stage, self%rates, y, change)
         else
            call heavy_stages(evaluate_rotating_field_stage, self%rates, y, change)
         end if
      else if (self%single) then
         call heavy_stages(evaluate_upright_stage, self%rates, y, change)
      else
         call heavy_stages(evaluate_field_stage, self%rates, y, change)
      end if
      y = y + change
      if (self%rotated) y(1:4) = quat_product(quat_conjugate(self%space), y(1:4))
      y(5) = self%back(1)*y(5)
      y(6) = self%back(2)*y(6)
      y(7) = self%back(3)*y(7)
      if (self%symmetric) call turn_body(self, y)
      if (self%first /= 1) call permute(5 - self%first, y)
   end subroutine move_heavy

   !> Converts [q, L, 0] to [q, w, 0] in the axes of the equations.
   pure subroutine to_equations(self, y)
      type(specialised_motion_t), intent(in) :: self
      real(wp), intent(inout) :: y(8)
      if (self%first /= 1) call permute(self%first, y)
      if (self%rotated) y(1:4) = quat_product(self%space, y(1:4))
      y(5) = self%half(1)*y(5)
      y(6) = self%half(2)*y(6)
      y(7) = self%half(3)*y(7)
   end subroutine to_equations

   !> Moves sensitivities over a step, in the equations of the step, as its exact derivative. `propagated` is false, and
   !> the sensitivities are unchanged, for free bodies, several directions, rotating space axes, and if there are
   !> sensitivities of parameters.
   pure subroutine propagate(self, before, tangent, propagated)
      !> Motion set to the length of the step.
      class(specialised_motion_t), intent(inout) :: self
      !> State at the start of the step, which succeeded.
      type(state_t), intent(in) :: before
      type(tangent_t), intent(inout) :: tangent
      logical, intent(out) :: propagated
      real(wp) :: y(8 + 14*most_pairs), start(8), spin(4), room(8 + 14*most_pairs, 2*n_stages + 2)
      integer :: i, k, n, first, last
      propagated = self%single .and. .not. (self%free .or. self%frame_turns) .and. size(tangent%parametric) == 0
      if (.not. propagated) return
      call read_motion(before, dot_product(before%q, before%q), start)
      call to_equations(self, start)
      spin = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      do first = 1, tangent%n, 2*most_pairs
         last = min(first + 2*most_pairs - 1, tangent%n)
         self%rates%pairs = (last - first)/2 + 1
         n = 8 + 14*self%rates%pairs
         y(1:8) = start
         y(9:n) = 0.0_wp
         do i = first, last
            k = 9 + 14*((i - first)/2) + modulo(i - first, 2)
            call start_sensitivity(self, tangent%theta(i, :), tangent%momentum(i, :), start(1:4), y(k:k + 12:2))
         end do
         call sensitivity_stages(self%rates, n, y, room, room(1, n_stages + 1))
         if (first == 1 .and. self%symmetric) spin = [cos(self%spin*y(7)), 0.0_wp, 0.0_wp, sin(self%spin*y(7))]
         do i = first, last
            k = 9 + 14*((i - first)/2) + modulo(i - first, 2)
            call finish_sensitivity(self, y(1:8), y(k:k + 12:2), spin, tangent%theta(i, :), tangent%momentum(i, :))
         end do
      end do
   end subroutine propagate

   !> Converts a sensitivity to the variables of the equations, δq = ½q∘θ.
   pure subroutine start_sensitivity(self, theta, momentum, q, sensitivity)
      type(specialised_motion_t), intent(in) :: self
      !> θ and δL; shape (3).
      real(wp), intent(in) :: theta(:), momentum(:)
      !> Attitude in the axes of the equations; shape (4).
      real(wp), intent(in) :: q(4)
      !> [δq, δw]; shape (7).
      real(wp), intent(inout) :: sensitivity(:)
      ! θ and δL are copied first: a row of a matrix as an array of explicit shape would be packed on the heap.
      real(wp) :: turn(3), along(3)
      turn = theta
      along = momentum
      sensitivity(1:4) = 0.5_wp*quat_vector_product(q, from_axis(turn, self%first - 1))
      sensitivity(5:7) = self%half*from_axis(along, self%first - 1)
   end subroutine start_sensitivity

   !> Computes θ = 2 vec(q*∘δq)/|q|² and δL at the end of a step, in body axes.
   pure subroutine finish_sensitivity(self, y, sensitivity, spin, theta, momentum)
      type(specialised_motion_t), intent(in) :: self
      !> [q, w, 0], and a sensitivity; shapes (8), (7).
      real(wp), intent(in) :: y(8), sensitivity(:)
      !> Rotation of a symmetric top in the frame of the step; unit quaternion.
      real(wp), intent(in) :: spin(4)
      !> θ, rad, and δL, N m s; shape (3).
      real(wp), intent(inout) :: theta(:), momentum(:)
      real(wp) :: change(4), turn(3), along(3), across(3)
      change = sensitivity(1:4)
      change = quat_product(quat_conjugate(y(1:4)), change)
      turn = (2/(y(1)*y(1) + y(2)*y(2) + y(3)*y(3) + y(4)*y(4)))*change(2:4)
      along = self%back*sensitivity(5:7)
      if (self%symmetric) then
         turn = rotate_to_body(spin, turn) + [0.0_wp, 0.0_wp, 2*self%spin*sensitivity(7)]
         across = rotate_to_body(spin, self%back*y(5:7))
         along = rotate_to_body(spin, along) + (2*self%spin*sensitivity(7))*[across(2), -across(1), 0.0_wp]
      end if
      theta = from_axis(turn, 4 - self%first)
      momentum = from_axis(along, 4 - self%first)
   end subroutine finish_sensitivity

   !> Permutes the axes of body and space cyclically, so that a given one becomes the first: components of attitude and
   !> momentum only change places.
   pure subroutine permute(first, x)
      !> Axis that becomes the first, 2 or 3.
      integer, intent(in) :: first
      real(wp), intent(inout) :: x(8)
      if (first == 2) then
         x(2:4) = [x(3), x(4), x(2)]
         x(5:7) = [x(6), x(7), x(5)]
      else
         x(2:4) = [x(4), x(2), x(3)]
         x(5:7) = [x(7), x(5), x(6)]
      end if
   end subroutine permute

   !> Converts from the axes of the equations to those of a symmetric top, which has rotated in them about axis 3.
   pure subroutine turn_body(self, x)
      type(specialised_motion_t), intent(in) :: self
      !> [q, L, 0]; shape (8).
      real(wp), intent(inout) :: x(8)
      real(wp) :: angle, c, s, double_c, double_s, first
      angle = self%spin*(self%half(3)*x(7))
      c = cos(angle)
      s = sin(angle)
      x(1:4) = [c*x(1) - s*x(4), c*x(2) + s*x(3), c*x(3) - s*x(2), c*x(4) + s*x(1)]
      double_c = (c - s)*(c + s)
      double_s = 2*c*s
      first = double_c*x(5) + double_s*x(6)
      x(6) = double_c*x(6) - double_s*x(5)
      x(5) = first
   end subroutine turn_body

end module nutate_specialised_motion
