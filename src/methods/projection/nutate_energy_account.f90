!> The energy that a run has by its account: H₀ + work, and the states to which that belongs.
!>
!> A stepper is also handed states that it did not return last: a step that is refused is taken again from where it
!> started. The account knows the last state and that start, to the last digit.
module nutate_energy_account
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   use nutate_state, only: state_t
   implicit none
   private

   public :: energy_account_t, energy_sum_t

   !> An energy as a compensated sum, J.
   type :: energy_sum_t
      real(wp) :: energy = 0.0_wp, compensation = 0.0_wp
   end type energy_sum_t

   !> The account of one run.
   type :: energy_account_t
      !> H₀ + work at the last state, and before its step.
      type(energy_sum_t) :: now, before
      logical :: open = .false.
      !> q and p of the last state, and of the one from which the step to it started; shape (4).
      real(wp), dimension(4), private :: last_q = 0.0_wp, last_p = 0.0_wp, start_q = 0.0_wp, start_p = 0.0_wp
   contains
      !> Goes on from a state with an energy.
      procedure :: resume
      !> Takes a step to a state, and the energy there.
      procedure :: book
      !> Takes a state as the last one; its energy is that of the last one.
      procedure :: move_to
      !> True for the last state.
      procedure :: is_at
      !> True for the state from which the step to the last one started.
      procedure :: began_at
      !> Shows what the next steps depend on to an archive.
      procedure :: transfer
   end type energy_account_t

contains

   !> Goes on from a state with an energy.
   pure subroutine resume(self, state, energy)
      class(energy_account_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      type(energy_sum_t), intent(in) :: energy
      self%now = energy
      self%before = energy
      call self%move_to(state)
      self%open = .true.
   end subroutine resume

   !> Takes a step to a state, and the energy there.
   pure subroutine book(self, state, energy)
      class(energy_account_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      type(energy_sum_t), intent(in) :: energy
      self%before = self%now
      self%now = energy
      self%start_q = self%last_q
      self%start_p = self%last_p
      call self%move_to(state)
   end subroutine book

   !> Takes a state as the last one.
   pure subroutine move_to(self, state)
      class(energy_account_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      self%last_q = state%q
      self%last_p = state%p
   end subroutine move_to

   !> True for the last state.
   pure logical function is_at(self, state)
      class(energy_account_t), intent(in) :: self
      type(state_t), intent(in) :: state
      is_at = self%open
      if (is_at) is_at = state%is_at(self%last_q, self%last_p)
   end function is_at

   !> True for the state from which the step to the last one started.
   pure logical function began_at(self, state)
      class(energy_account_t), intent(in) :: self
      type(state_t), intent(in) :: state
      began_at = self%open
      if (began_at) began_at = state%is_at(self%start_q, self%start_p)
   end function began_at

   !> Shows what the next steps depend on to an archive: where the last step started counts only until it is taken.
   subroutine transfer(self, archive)
      class(energy_account_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%now%energy)
      call archive%transfer(self%now%compensation)
      call archive%transfer(self%before%energy)
      call archive%transfer(self%before%compensation)
      call archive%transfer(self%last_q)
      call archive%transfer(self%last_p)
      call archive%transfer(self%open)
   end subroutine transfer

end module nutate_energy_account
