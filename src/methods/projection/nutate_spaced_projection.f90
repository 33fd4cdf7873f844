!> The projection onto the invariants after steps, as often as round-off requires.
!>
!> The errors that a projection removes come back slowly, so that without torques only every few steps are projected,
!> counted from the start, while errors are small. The output of the steps between is a projected copy, whose balance
!> stores the state that it is a copy of: output does not change the motion.
module nutate_spaced_projection
   use nutate_archive, only: archive_t
   use nutate_energy_balance, only: energy_balance_t
   use nutate_invariant_projection, only: invariant_projection_t
   use nutate_kinds, only: wp
   use nutate_noise, only: noise_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_step_error, only: step_error_t
   implicit none
   private

   public :: spaced_projection_t, small

   !> Move of a projection, of q and of p relative to |p|, up to which the next steps need none: several such moves are
   !> far below the limit of the projection; with larger errors, projecting every step costs little.
   real(wp), parameter :: small = 1e-4_wp

   !> The projection of the states of one system.
   type :: spaced_projection_t
      private
      type(invariant_projection_t) :: projection
      !> Every step is projected.
      logical :: each = .true.
      !> No step has been projected: the next one starts a new balance, whatever balance the state has.
      logical :: fresh = .true.
      !> Steps from one projection to the next while errors are small.
      integer :: usual = 1
   contains
      !> Finds the invariants that a system has.
      procedure :: prepare
      !> Adds the noise of a trial run.
      procedure :: disturb
      !> Returns the move of the last projected state due to round-off of the energy.
      procedure :: moved_by_round_off
      !> Replaces an observed copy by the state that a step left.
      procedure :: find_origin
      !> Prepares the state from which a step starts.
      procedure :: begin_step
      !> Projects the state that the step reached, if that is due.
      procedure :: end_step
      !> Projects a copy of the state that the last step left.
      procedure :: project_for_output
      !> Projects a state inside the last step.
      procedure :: project_inside
      !> Writes or reads the data kept from step to step.
      procedure :: transfer
   end type spaced_projection_t

contains

   !> Finds the invariants that a system has. To be called before the first step and after every change of the system.
   pure subroutine prepare(self, system, attitude, usual, compensated)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> True if the attitude is integrated.
      logical, intent(in) :: attitude
      !> Steps from one projection to the next while errors are small. With torques or wheels every step is projected.
      integer, intent(in) :: usual
      !> True if states are compensated sums, and stay so if moves allow it.
      logical, intent(in), optional :: compensated
      logical :: sums
      sums = .false.
      if (present(compensated)) sums = compensated
      call self%projection%prepare(system, attitude, sums)
      self%usual = usual
      self%each = usual == 1 .or. system%effects%n_works() > 0
      self%fresh = .true.
   end subroutine prepare

   !> Adds the noise of a trial run, for every state that a step reaches.
   pure subroutine disturb(self, noise)
      class(spaced_projection_t), intent(inout) :: self
      type(noise_t), intent(in) :: noise
      call self%projection%disturb(noise)
   end subroutine disturb

   !> Returns the move of the last projected state due to round-off of the energy, rad.
   pure real(wp) function moved_by_round_off(self)
      class(spaced_projection_t), intent(in) :: self
      moved_by_round_off = self%projection%moved_by_round_off
   end function moved_by_round_off

   !> Replaces an observed copy by the state that a step left. Before the first step there is no balance: the one that a
   !> state has may be that of another system.
   pure subroutine find_origin(self, state, restored)
      class(spaced_projection_t), intent(in) :: self
      type(state_t), intent(inout) :: state
      !> True if the state was such a copy and was replaced: its balance belongs to it.
      logical, intent(out), optional :: restored
      logical :: was_projected
      was_projected = state%balance%projected .and. .not. self%fresh
      if (self%fresh) then
         state%balance%open = .false.
      else
         call state%restore_left()
      end if
      if (present(restored)) restored = was_projected .and. .not. state%balance%projected
   end subroutine find_origin

   !> Prepares the state from which a step starts; one whose balance starts anew is projected after its
   !> first step.
   pure subroutine begin_step(self, system, state)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      logical :: restored
      call self%find_origin(state, restored)
      if (.not. restored) call self%projection%follow(system, state)
   end subroutine begin_step

   !> Counts a step, and projects the state if that is due. Errors, with state and count unchanged: those of the
   !> projection.
   pure subroutine end_step(self, system, state, due, work, status, error, given)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> True if the projection is due in any case.
      logical, intent(in) :: due
      !> Work of all torques in the step, J.
      real(wp), intent(in) :: work
      !> Success on entry.
      type(status_t), intent(inout) :: status
      !> Estimated error of the step, and the share of the works, J: zero if they take none.
      type(step_error_t), intent(in), optional :: error
      real(wp), intent(inout), optional :: given
      real(wp) :: q(4), p(4)
      if (.not. self%each .and. state%balance%count + 1 < state%balance%interval .and. .not. due) then
         state%balance%count = state%balance%count + 1
         call self%projection%shake_state(state)
         call state%balance_here()
         return
      end if
      q = state%q
      p = state%p
      call self%projection%project(system, state, work, status, error, given)
      if (status%code /= 0) return
      self%fresh = .false.
      if (self%each) return
      state%balance%count = 0
      state%balance%interval = 1
      if (maxval(abs(state%q - q)) <= small .and. maxval(abs(state%p - p)) <= small*maxval(abs(p))) &
         state%balance%interval = self%usual
   end subroutine end_step

   !> Replaces a state by a projected copy, unless its step was projected. The state is unchanged if the projection
   !> fails: the next step that is projected then fails.
   pure subroutine project_for_output(self, system, state)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      type(energy_balance_t) :: balance
      type(status_t) :: status
      if (self%each .or. self%fresh .or. state%balance%count == 0 .or. state%balance%projected) return
      if (.not. state%is_balanced()) return
      balance = state%balance
      balance%projected = .true.
      balance%left_q = state%q
      balance%left_p = state%p
      balance%left_q_compensation = state%q_compensation
      balance%left_p_compensation = state%p_compensation
      call self%projection%project(system, state, 0.0_wp, status)
      state%balance = balance
      call state%balance_here()
   end subroutine project_for_output

   !> Projects a state inside the last step, which has the balance of the start of the step. Errors: those of the
   !> projection.
   pure subroutine project_inside(self, system, state, work, status, error, given)
      class(spaced_projection_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> Work of all torques from the start of the step to the state, J.
      real(wp), intent(in) :: work
      !> Success on entry.
      type(status_t), intent(inout) :: status
      !> Arguments as for `end_step`.
      type(step_error_t), intent(in), optional :: error
      real(wp), intent(inout), optional :: given
      call self%projection%project(system, state, work, status, error, given)
      state%balance%count = 0
      state%balance%interval = 1
   end subroutine project_inside

   !> Writes or reads the data kept from step to step.
   subroutine transfer(self, archive)
      class(spaced_projection_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%fresh)
   end subroutine transfer

end module nutate_spaced_projection
