!> The projection of tangent columns: after the projection of a state its columns are moved, by the same directions,
!> until what they change of the invariants is what they changed of them at the start of the run.
!>
!> The rows dH·X, less the change of the works, d(l·n)·X or δl take the values of the start, the targets of the state's
!> projection differentiated: free bodies by δL = Rᵀδl - θ×L, others by a move along γ; then, with e what dH·X lacks,
!>
!>     k = -e/(|L̇|² + S²|Ω⊥|²),   θ += kL̇,   δL += -kL̇×L - kS²Ω⊥
!>
!> L̇ = L×Ω + τ; of l the move changes what is not conserved alone, by Ω⊥ (`nutate_invariant_projection`).
!> Of the exact derivative this leaves out how the direction of the state's move changes, times the length of that move.
!> Potentials that move do work on a column that is not known: columns stay as they are there.
module nutate_column_projection
   use nutate_column, only: column_t, OF_POTENTIAL
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, frame_rate_of, potential_torque
   use nutate_invariants, only: ALL_COMPONENTS, ALONG_AXIS, conserved_momentum
   use nutate_kinds, only: wp, eps
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: project_columns

   !> Part of the energies of a row that is round-off; longest move, of the length of the column.
   real(wp), parameter :: round_off = 16*eps, longest = 0.1_wp

contains

   !> Moves the columns at a state that was projected, with its attitude.
   subroutine project_columns(system, state, tangent)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: axis(3), gamma(3), momentum(3)
      integer :: components, k
      gamma = 0.0_wp
      if (system%effects%moves) return
      call conserved_momentum(system%effects, components, axis)
      momentum = body_momentum(state)
      if (components == ALL_COMPONENTS) then
         do k = 1, tangent%n
            tangent%momentum(k, :) = rotate_to_body(state%q, tangent%space_momentum(k, :)) &
                                     - cross(tangent%theta(k, :), momentum)
         end do
      else if (components == ALONG_AXIS) then
         gamma = rotate_to_body(state%q, axis)
         call put_component(system%effects, state, axis, gamma, momentum, tangent)
      end if
      call put_energy(system, state, components, gamma, momentum, tangent)
   end subroutine project_columns

   !> Puts δ(l·n), but for columns that turn n: what they change depends on all of l.
   subroutine put_component(effects, state, axis, gamma, momentum, tangent)
      type(effect_list_t), intent(in) :: effects
      type(state_t), intent(in) :: state
      !> n, space axes, and in the body; L; shape (3).
      real(wp), intent(in) :: axis(3), gamma(3), momentum(3)
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: along(3)
      integer :: k
      along = cross(momentum, gamma)
      do k = 1, tangent%n
         if (turns_axis(effects, state%t, axis, tangent%columns(k))) cycle
         tangent%momentum(k, :) = tangent%momentum(k, :) &
                                  + (dot_product(axis, tangent%space_momentum(k, :)) - dot_product( &
                                     gamma, tangent%momentum(k, :)) - dot_product(along, tangent%theta(k, :)))*gamma
      end do
   end subroutine put_component

   !> True for a column that turns a direction which all potentials share, or that of the turning of the axes.
   pure logical function turns_axis(effects, t, axis, column) result(turns)
      type(effect_list_t), intent(in) :: effects
      !> s; n; shape (3).
      real(wp), intent(in) :: t, axis(3)
      type(column_t), intent(in) :: column
      integer :: i, m
      turns = any(abs(cross(axis, column%frame)) > 0.0_wp)
      if (.not. allocated(column%effects)) return
      do m = 1, size(column%effects)
         if (column%effects(m)%kind /= OF_POTENTIAL) cycle
         do i = 1, effects%n_potentials
            if (effects%potentials(i)%place /= column%effects(m)%place) cycle
            associate (potential => effects%potentials(i)%item)
               turns = turns .or. &
                       any(abs(cross(axis, potential%direction_change(column%effects(m)%change, t))) > 0.0_wp)
            end associate
         end do
      end do
   end function turns_axis

   !> Puts what columns change of the energy.
   subroutine put_energy(system, state, components, gamma, momentum, tangent)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Of l that are conserved.
      integer, intent(in) :: components
      !> n where one is; L; shape (3).
      real(wp), intent(in) :: gamma(3), momentum(3)
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: omega(3), rate(3), push(3), square, steepness, lacks(tangent%n), size_of, length, k, s2
      integer :: i
      omega = angular_velocity(system, state)
      s2 = 0.0_wp
      square = dot_product(omega, omega)
      if (square > tiny(1.0_wp)/eps) s2 = (dot_product(omega, matmul(system%body%inertia, omega))/square)**2
      push = omega - frame_rate_of(system%effects, state%q)
      rate = cross(momentum, omega) + potential_torque(system%effects, state%q, state%t)
      if (components == ALL_COMPONENTS) push = 0.0_wp
      if (components == ALONG_AXIS) push = push - dot_product(push, gamma)*gamma
      steepness = dot_product(rate, rate) + s2*dot_product(push, push)
      lacks = tangent%energy + tangent%work - tangent%energy_row(system, state)
      do i = 1, tangent%n
         length = dot_product(tangent%theta(i, :), tangent%theta(i, :))
         if (s2 > 0.0_wp) length = length + dot_product(tangent%momentum(i, :), tangent%momentum(i, :))/s2
         size_of = norm2(rate)*norm2(tangent%theta(i, :)) + norm2(omega)*norm2(tangent%momentum(i, :))
         if (abs(lacks(i)) <= round_off*size_of) cycle
         if (.not. lacks(i)**2 < longest**2*steepness*length) cycle
         k = -lacks(i)/steepness
         tangent%theta(i, :) = tangent%theta(i, :) + k*rate
         tangent%momentum(i, :) = tangent%momentum(i, :) - k*cross(rate, momentum) - (k*s2)*push
      end do
   end subroutine put_energy

end module nutate_column_projection
