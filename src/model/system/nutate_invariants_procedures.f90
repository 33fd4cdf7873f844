!> Bodies of the procedures whose interfaces are in `nutate_invariants`.
submodule(nutate_invariants) nutate_invariants_procedures
   use nutate_effect_traits, only: DRIVES_WHEELS
   use nutate_hamiltonian, only: conserved_energy, kinetic_energy, potential_energy, space_momentum
   use nutate_limits, only: is_direction
   use nutate_quaternion, only: cross
   implicit none

contains

   module procedure start
      self%inverse_j0 = 0.0_wp
      if (present(inverse_j0)) self%inverse_j0 = inverse_j0
      call conserved_momentum(system%effects, self%components, self%axis)
      if (present(attitude)) then
         if (.not. attitude .and. self%components == ALL_COMPONENTS) self%components = ONLY_LENGTH
      end if
      self%energy = conserved_energy(system, state, self%inverse_j0)
      self%momentum = space_momentum(state)
      self%energy_scale = 0.0_wp
      self%momentum_scale = 0.0_wp
      self%worst_energy = 0.0_wp
      self%worst_momentum = 0.0_wp
      self%norm_error = 0.0_wp
      self%orthogonality = 0.0_wp
      call self%measure(system, state)
   end procedure start

   module procedure measure
      real(wp) :: kinetic, potential, residual, change(3)
      kinetic = kinetic_energy(system, state, self%inverse_j0)
      potential = potential_energy(system%effects, state%q, state%t)
      if (system%effects%frame_turns) potential = potential - dot_product(system%effects%frame_rate, &
                                                                          space_momentum(state))
      residual = kinetic + potential - self%energy
      if (present(work)) residual = residual - work
      self%energy_scale = max(self%energy_scale, kinetic + abs(potential))
      self%worst_energy = max(self%worst_energy, abs(residual))
      change = space_momentum(state) - self%momentum
      self%momentum_scale = max(self%momentum_scale, norm2(self%momentum + change))
      if (self%components == ALL_COMPONENTS) then
         self%worst_momentum = max(self%worst_momentum, norm2(change))
      else if (self%components == ONLY_LENGTH) then
         self%worst_momentum = max(self%worst_momentum, abs(norm2(self%momentum + change) - norm2(self%momentum)))
      else if (self%components == ALONG_AXIS) then
         self%worst_momentum = max(self%worst_momentum, abs(dot_product(self%axis, change)))
      end if
      self%norm_error = max(self%norm_error, abs(dot_product(state%q, state%q) - 1))
      self%orthogonality = max(self%orthogonality, abs(dot_product(state%q, state%p)))
   end procedure measure

   module procedure energy_error
      energy_error = ratio(self%worst_energy, self%energy_scale)
   end procedure energy_error

   module procedure momentum_error
      momentum_error = ratio(self%worst_momentum, self%momentum_scale)
   end procedure momentum_error

   module procedure transfer_invariants
      call archive%transfer(self%energy)
      call archive%transfer(self%momentum)
      call archive%transfer(self%energy_scale)
      call archive%transfer(self%momentum_scale)
      call archive%transfer(self%worst_energy)
      call archive%transfer(self%worst_momentum)
      call archive%transfer(self%norm_error)
      call archive%transfer(self%orthogonality)
   end procedure transfer_invariants

   pure real(wp) function ratio(error, scale)
      real(wp), intent(in) :: error, scale
      ratio = 0.0_wp
      if (scale > 0.0_wp) ratio = error/scale
   end function ratio

   module procedure conserved_momentum
      real(wp) :: length, rate(3)
      call common_direction(effects, components, axis)
      if (effects%frame_turns) then
         ! Scaled first: the length of a tiny rate may be zero.
         rate = effects%frame_rate/maxval(abs(effects%frame_rate))
         length = norm2(rate)
         if (components == ALL_COMPONENTS) then
            components = ALONG_AXIS
            axis = rate/length
         else if (norm2(cross(axis, rate)) > parallel*length) then
            components = NO_COMPONENT
         end if
      end if
      if (has_outer_torques(effects) .or. directions_move(effects)) components = NO_COMPONENT
      if (components /= ALONG_AXIS) axis = 0.0_wp
   end procedure conserved_momentum

   !> Returns true if the direction of a potential moves, on or off.
   pure logical function directions_move(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      directions_move = any([(effects%potentials(i)%item%moves, i=1, effects%n_potentials + effects%n_off)])
   end function directions_move

   module procedure common_direction
      real(wp) :: length
      integer :: i
      components = ALL_COMPONENTS
      axis = 0.0_wp
      do i = 1, effects%n_potentials + effects%n_off
         associate (n => effects%potentials(i)%item%direction)
            length = norm2(n)
            if (length <= 0.0_wp) cycle
            if (components == ALL_COMPONENTS) then
               components = ALONG_AXIS
               axis = n/length
            else if (norm2(cross(axis, n)) > parallel*length) then
               components = NO_COMPONENT
            end if
         end associate
      end do
   end procedure common_direction

   module procedure follows_rotating_axes
      integer :: components
      real(wp) :: axis(3)
      integer :: i
      follows = .false.
      if (.not. effects%frame_turns .or. effects%n_torques + effects%n_wheels > 0) return
      if (.not. is_direction(effects%frame_rate)) return
      if (.not. all([(effects%potentials(i)%item%is_valid(), i=1, effects%n_potentials + effects%n_off)])) return
      call conserved_momentum(effects, components, axis)
      follows = components == ALONG_AXIS
   end procedure follows_rotating_axes

   !> Returns true if there is an external torque on the body; the torque of a controller by wheels is internal, and so
   !> is a change of the inertia by masses that stay.
   pure logical function has_outer_torques(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      has_outer_torques = any([(.not. (effects%torques(i)%item%has(DRIVES_WHEELS) .or. &
                                       effects%torques(i)%item%is_internal), i=1, effects%n_torques)])
   end function has_outer_torques

end submodule nutate_invariants_procedures
