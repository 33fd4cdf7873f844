!> The invariants of a motion: the conserved quantities of a system, and their errors in a run.
module nutate_invariants
   use nutate_archive, only: archive_t
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: conserved_energy, kinetic_energy, potential_energy, space_momentum
   use nutate_kinds, only: wp
   use nutate_limits, only: is_direction
   use nutate_quaternion, only: cross
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: invariants_t, conserved_momentum, common_direction, follows_rotating_axes, parallel
   public :: NO_COMPONENT, ALONG_AXIS, ONLY_LENGTH, ALL_COMPONENTS

   !> Conserved components of the space momentum; only its length if the attitude is not known.
   integer, parameter :: NO_COMPONENT = 0, ALONG_AXIS = 1, ONLY_LENGTH = 2, ALL_COMPONENTS = 3

   !> Sine of an angle between two directions below which it is round-off of their input.
   real(wp), parameter :: parallel = 1e-14_wp

   !> The invariants of a run: their first values, and the largest departures so far.
   type :: invariants_t
      !> `NO_COMPONENT`, `ALONG_AXIS`, `ONLY_LENGTH` or `ALL_COMPONENTS`.
      integer :: components = ALL_COMPONENTS
      !> Unit vector along the conserved component, space axes; shape (3).
      real(wp) :: axis(3) = 0.0_wp
      !> H at the start, J; the Jacobi integral if the space axes rotate.
      real(wp) :: energy = 0.0_wp
      !> l at the start, space axes, N m s; shape (3).
      real(wp) :: momentum(3) = 0.0_wp
      !> Largest T + |V| and |l| so far, to which the errors are relative.
      real(wp) :: energy_scale = 0.0_wp, momentum_scale = 0.0_wp
      !> Largest |H - H(0) - work|, J.
      real(wp) :: worst_energy = 0.0_wp
      !> Largest error of the conserved components of l, N m s.
      real(wp) :: worst_momentum = 0.0_wp
      !> Largest |qᵀq - 1|, and |qᵀp|, kg m²/s: the constraints (2) and (5) of Nielsen & Krenk (2012).
      real(wp) :: norm_error = 0.0_wp, orthogonality = 0.0_wp
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), private :: inverse_j0 = 0.0_wp
   contains
      !> Stores the first values.
      procedure :: start
      !> Compares a state with the first one.
      procedure :: measure
      !> Returns the largest energy residual over the energy scale.
      procedure :: energy_error
      !> Returns the largest momentum error over the momentum scale.
      procedure :: momentum_error
      !> Writes or reads its values in checkpoint data.
      procedure :: transfer => transfer_invariants
   end type invariants_t

contains

   !> Stores the first values from a state.
   pure subroutine start(self, system, state, inverse_j0, attitude)
      class(invariants_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> 1/J0, kg⁻¹ m⁻²; default 0.
      real(wp), intent(in), optional :: inverse_j0
      !> The states have an attitude; default `.true.`.
      logical, intent(in), optional :: attitude
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
   end subroutine start

   !> Compares a state with the first and keeps the largest departures.
   pure subroutine measure(self, system, state, work)
      class(invariants_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Work of all torques since the start, J; default 0.
      real(wp), intent(in), optional :: work
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
   end subroutine measure

   !> Returns the largest |H - H(0) - work| over the largest T + |V|.
   pure real(wp) function energy_error(self)
      class(invariants_t), intent(in) :: self
      energy_error = ratio(self%worst_energy, self%energy_scale)
   end function energy_error

   !> Returns the largest error of the conserved components over the largest |l|.
   pure real(wp) function momentum_error(self)
      class(invariants_t), intent(in) :: self
      momentum_error = ratio(self%worst_momentum, self%momentum_scale)
   end function momentum_error

   !> Writes or reads the values in checkpoint data, except those that follow from the system.
   subroutine transfer_invariants(self, archive)
      class(invariants_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%energy)
      call archive%transfer(self%momentum)
      call archive%transfer(self%energy_scale)
      call archive%transfer(self%momentum_scale)
      call archive%transfer(self%worst_energy)
      call archive%transfer(self%worst_momentum)
      call archive%transfer(self%norm_error)
      call archive%transfer(self%orthogonality)
   end subroutine transfer_invariants

   pure real(wp) function ratio(error, scale)
      real(wp), intent(in) :: error, scale
      ratio = 0.0_wp
      if (scale > 0.0_wp) ratio = error/scale
   end function ratio

   !> Finds the components of l that the effects conserve, on or off: all without torque; the one along n with
   !> potentials that share the direction n, since each is a function of R(q)ᵀn; none otherwise. If the space axes
   !> rotate, only the component along their axis can be conserved; with a time-dependent potential none is.
   pure subroutine conserved_momentum(effects, components, axis)
      type(effect_list_t), intent(in) :: effects
      !> `NO_COMPONENT`, `ALONG_AXIS` or `ALL_COMPONENTS`.
      integer, intent(out) :: components
      !> Unit vector along the conserved component, space axes; zero unless exactly one is conserved; shape (3).
      real(wp), intent(out) :: axis(3)
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
      if (has_outer_torques(effects) .or. effects%moves) components = NO_COMPONENT
      if (components /= ALONG_AXIS) axis = 0.0_wp
   end subroutine conserved_momentum

   !> Finds the direction that all potentials share, on or off, whatever other effects there are: in axes that do not
   !> rotate, l·n is conserved without torques.
   pure subroutine common_direction(effects, components, axis)
      type(effect_list_t), intent(in) :: effects
      !> `ALL_COMPONENTS` without potentials, `ALONG_AXIS` with one direction, `NO_COMPONENT` with several.
      integer, intent(out) :: components
      !> Unit vector, space axes; the first direction if there are several, zero if there is none; shape (3).
      real(wp), intent(out) :: axis(3)
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
   end subroutine common_direction

   !> Returns true if the space axes rotate and no effect depends on it, because each is symmetric about their rate, or
   !> there is none: the motion is that in non-rotating axes, rotated back by ω times the time. Wheels are left out,
   !> since their motors may depend on the rotation. False if a number of an effect is not one that a run accepts, or if
   !> the rate is too small to have a direction.
   pure logical function follows_rotating_axes(effects) result(follows)
      type(effect_list_t), intent(in) :: effects
      integer :: components
      real(wp) :: axis(3)
      integer :: i
      follows = .false.
      if (.not. effects%frame_turns .or. effects%n_torques + effects%n_wheels > 0) return
      if (.not. is_direction(effects%frame_rate)) return
      do i = 1, effects%n_potentials + effects%n_off
         if (.not. effects%potentials(i)%item%is_valid()) return
      end do
      call conserved_momentum(effects, components, axis)
      follows = components == ALONG_AXIS
   end function follows_rotating_axes

   !> Returns true if there is an external torque on the body; the torque of a controller by wheels is internal.
   pure logical function has_outer_torques(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      has_outer_torques = .not. all([(effects%torques(i)%item%drives_wheels(), i=1, effects%n_torques)])
   end function has_outer_torques

end module nutate_invariants
