!> The projection of sensitivities: after the projection of a state its sensitivities are moved, in the same directions,
!> until the changes of the invariants equal those at the start of the run.
!>
!> The rows dH·X, less the change of the works, d(l·n)·X or δl are set to their initial values, the differentiated
!> targets of the state's projection: for free bodies by δL = Rᵀδl - θ×L, for others by a move along γ. Then, with e the
!> defect of dH·X,
!>
!>     k = -e/(|L̇|² + S²|Ω⊥|²),   θ += kL̇,   δL += -kL̇×L - kS²Ω⊥
!>
!> L̇ = L×Ω + τ; the move changes only components of l that are not conserved, by Ω⊥ (`nutate_invariant_projection`).
!> The exact derivative has one more term, the change of the direction of the state's move times the length of that
!> move; it is left out. The work of moving potentials on a sensitivity is not known: with such potentials sensitivities
!> are not moved.
!>
!> The sensitivities of a method that conserves by itself are moved in this way every so many steps, if their defect is
!> round-off: in steady motions round-off is the same in each step, and adds up. A larger defect is an error of the
!> sensitivities, and stays.
module nutate_sensitivity_projection
   use nutate_variation, only: variation_t, OF_POTENTIAL
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, frame_rate_of, potential_torque, system_t
   use nutate_invariants, only: ALL_COMPONENTS, ALONG_AXIS, conserved_momentum
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: cross, quat_normalized, rotate_to_body
   use nutate_state, only: state_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: project_sensitivities, kept_steps

   !> Steps after which round-off is removed from sensitivities.
   integer, parameter :: kept_steps = 500
   !> Part of the energies of a row that is round-off; longest move, relative to the length of the sensitivity.
   real(wp), parameter :: round_off = 16*eps, longest = 0.1_wp
   !> Round-off of that many steps, of a row or of a sensitivity.
   real(wp), parameter :: accumulated = 4096*eps

contains

   !> Moves sensitivities to the initial values of the rows, at a state with its attitude: after the projection of a
   !> state, or for a method that conserves by itself.
   subroutine project_sensitivities(system, state, only_round_off, tangent)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> True if only defects of the size of round-off are removed.
      logical, intent(in) :: only_round_off
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: axis(3), gamma(3), momentum(3)
      integer :: components
      gamma = 0.0_wp
      if (system%effects%depends_on_time) return
      call conserved_momentum(system%effects, components, axis)
      momentum = body_momentum(state)
      if (components == ALL_COMPONENTS) then
         call put_momentum(quat_normalized(state%q), momentum, only_round_off, tangent)
      else if (components == ALONG_AXIS) then
         gamma = rotate_to_body(quat_normalized(state%q), axis)
         call put_component(system%effects, state%t, axis, gamma, momentum, only_round_off, tangent)
      end if
      call put_energy(system, state, components, gamma, momentum, only_round_off, tangent)
   end subroutine project_sensitivities

   !> Sets δl to its target.
   pure subroutine put_momentum(q, momentum, only_round_off, tangent)
      !> Attitude, shape (4); L, shape (3).
      real(wp), intent(in) :: q(4), momentum(3)
      logical, intent(in) :: only_round_off
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: target(3), theta(3), delta(3), length
      integer :: k
      length = norm2(momentum)
      do k = 1, tangent%n
         theta = tangent%theta(k, :)
         delta = tangent%momentum(k, :)
         target = tangent%space_momentum(k, :)
         target = rotate_to_body(q, target) - cross(theta, momentum)
         if (only_round_off .and. norm2(target - delta) > accumulated*(norm2(delta) + norm2(theta)*length)) cycle
         tangent%momentum(k, :) = target
      end do
   end subroutine put_momentum

   !> Sets δ(l·n) to its target, except for sensitivities that rotate n: their change depends on all of l.
   subroutine put_component(effects, t, axis, gamma, momentum, only_round_off, tangent)
      type(effect_list_t), intent(in) :: effects
      !> Time, s; n, in space and in body axes; L; shape (3).
      real(wp), intent(in) :: t, axis(3), gamma(3), momentum(3)
      logical, intent(in) :: only_round_off
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: along(3), theta(3), delta(3), length, lacks
      integer :: k
      along = cross(momentum, gamma)
      length = norm2(momentum)
      do k = 1, tangent%n
         if (turns_axis(effects, t, axis, tangent%variations(k))) cycle
         theta = tangent%theta(k, :)
         delta = tangent%momentum(k, :)
         lacks = dot_product(axis, tangent%space_momentum(k, :)) - dot_product(gamma, delta) - dot_product(along, theta)
         if (only_round_off .and. abs(lacks) > accumulated*(norm2(delta) + norm2(theta)*length)) cycle
         tangent%momentum(k, :) = delta + lacks*gamma
      end do
   end subroutine put_component

   !> Returns true for a sensitivity that rotates the direction shared by all potentials, or the axis of the rotating
   !> frame.
   pure logical function turns_axis(effects, t, axis, variation) result(turns)
      type(effect_list_t), intent(in) :: effects
      !> Time, s; n; shape (3).
      real(wp), intent(in) :: t, axis(3)
      type(variation_t), intent(in) :: variation
      integer :: i, m
      turns = any(abs(cross(axis, variation%frame)) > 0.0_wp)
      if (.not. allocated(variation%effects)) return
      do m = 1, size(variation%effects)
         if (variation%effects(m)%kind /= OF_POTENTIAL) cycle
         do i = 1, effects%n_potentials
            if (effects%potentials(i)%place /= variation%effects(m)%place) cycle
            turns = turns .or. any(abs(cross(axis, effects%potentials(i)%item%direction_change( &
                                                   variation%effects(m)%change, t))) > 0.0_wp)
         end do
      end do
   end function turns_axis

   !> Sets the change of the energy to its target. For a body that rotates about a principal axis no move leaves l
   !> unchanged: the rows of energy and l coincide, and share the difference that round-off of the state has left
   !> between them.
   subroutine put_energy(system, state, components, gamma, momentum, only_round_off, tangent)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Components of l that are conserved.
      integer, intent(in) :: components
      !> n, body axes, if there is one; L; shape (3).
      real(wp), intent(in) :: gamma(3), momentum(3)
      logical, intent(in) :: only_round_off
      type(tangent_t), intent(inout) :: tangent
      real(wp), dimension(3) :: omega, by_momentum, rate, push, theta, delta
      real(wp) :: lacks(tangent%n), square, steepness, speed, size_of, theta_size, delta_size, length, farthest, k, s2
      integer :: i
      omega = angular_velocity(system, state)
      speed = norm2(omega)
      s2 = 0.0_wp
      square = dot_product(omega, omega)
      if (square > tiny(1.0_wp)/eps) s2 = (dot_product(omega, matmul(system%body%inertia, omega))/square)**2
      by_momentum = omega - frame_rate_of(system%effects, state%q)
      square = dot_product(by_momentum, by_momentum)
      rate = cross(momentum, omega) + potential_torque(system%effects, state%q, state%t)
      push = by_momentum
      if (components == ALL_COMPONENTS) push = 0.0_wp
      if (components == ALONG_AXIS) push = push - dot_product(push, gamma)*gamma
      steepness = dot_product(rate, rate) + s2*dot_product(push, push)
      farthest = merge(accumulated, longest, only_round_off)
      lacks = tangent%energy + tangent%work - tangent%energy_row(system, state)
      do i = 1, tangent%n
         theta = tangent%theta(i, :)
         delta = tangent%momentum(i, :)
         theta_size = norm2(theta)
         delta_size = norm2(delta)
         size_of = norm2(rate)*theta_size + speed*delta_size
         if (abs(lacks(i)) <= round_off*size_of) cycle
         if (only_round_off .and. abs(lacks(i)) > accumulated*(size_of + speed*norm2(momentum)*theta_size)) cycle
         length = theta_size
         if (s2 > 0.0_wp) length = max(length, delta_size/sqrt(s2))
         if (abs(lacks(i)) < farthest*sqrt(steepness)*length) then
            k = -lacks(i)/steepness
            tangent%theta(i, :) = theta + k*rate
            tangent%momentum(i, :) = delta - k*cross(rate, momentum) - (k*s2)*push
         else if (only_round_off .and. square > tiny(1.0_wp)/eps) then
            tangent%momentum(i, :) = delta + (0.5_wp*lacks(i)/square)*by_momentum
         end if
      end do
   end subroutine put_energy

end module nutate_sensitivity_projection
