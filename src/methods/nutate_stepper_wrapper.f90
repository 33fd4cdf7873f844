!> A stepper around another one, which performs the steps: base of steppers that change the states of any method.
module nutate_stepper_wrapper
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   use nutate_noise, only: noise_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: keep_starts, stepper_t, system_t
   implicit none
   private

   public :: stepper_wrapper_t

   !> Base of all steppers around another one.
   type, abstract, extends(stepper_t) :: stepper_wrapper_t
      !> The stepper inside.
      class(stepper_t), allocatable :: base
   contains
      !> Sets the stepper inside; must come before `prepare`.
      procedure, non_overridable :: wrap
      !> Reports an error if there is no stepper inside.
      procedure, non_overridable :: check_base
      !> Copies what the inner stepper reports of its last step, successful or not, except for work and estimate.
      procedure, non_overridable :: copy_counts
      !> Copies the work of the last step, and the estimate of its error.
      procedure, non_overridable :: copy_work
      !> Performs a step of the inner stepper, with nothing added to it.
      procedure, non_overridable :: advance_base
      procedure :: copy
      procedure :: chooses_steps
      procedure :: disturb
      procedure :: forget_steps
      procedure :: keep_steps
      procedure :: update_commands
      procedure :: transfer
   end type stepper_wrapper_t

contains

   !> Sets the stepper inside.
   subroutine wrap(self, base)
      class(stepper_wrapper_t), intent(inout) :: self
      !> Moved: not allocated afterwards.
      class(stepper_t), allocatable, intent(inout) :: base
      call move_alloc(base, self%base)
   end subroutine wrap

   !> Returns true if the stepper inside chooses its steps.
   pure logical function chooses_steps(self)
      class(stepper_wrapper_t), intent(in) :: self
      chooses_steps = self%base%chooses_steps()
   end function chooses_steps

   !> Sets the perturbation of a trial run.
   subroutine disturb(self, noise)
      class(stepper_wrapper_t), intent(inout) :: self
      type(noise_t), intent(in) :: noise
      call self%base%disturb(noise)
   end subroutine disturb

   !> Checks that there is a stepper inside. Errors: `NUTATE_BAD_ARGUMENT` if there is none.
   subroutine check_base(self, name, status)
      class(stepper_wrapper_t), intent(in) :: self
      !> Name of what needs a stepper, for the message.
      character(len=*), intent(in) :: name
      type(status_t), intent(inout) :: status
      if (.not. allocated(self%base)) status = fail(NUTATE_BAD_ARGUMENT, name//' needs a stepper')
   end subroutine check_base

   !> Copies what the inner stepper reports of its last step.
   subroutine copy_counts(self)
      class(stepper_wrapper_t), intent(inout) :: self
      self%iterations = self%base%iterations
      self%residual = self%base%residual
      self%continued = self%base%continued
      self%uncertified = self%base%uncertified
   end subroutine copy_counts

   !> Copies the work of the last step, and the estimate of its error.
   subroutine copy_work(self)
      class(stepper_wrapper_t), intent(inout) :: self
      integer :: i
      self%error_estimate = self%base%error_estimate
      do i = 1, size(self%work)
         self%work(i) = self%base%work(i)
      end do
   end subroutine copy_work

   !> Performs a step of the inner stepper, with nothing added to it. Errors: those of the stepper.
   subroutine advance_base(self, system, state, dt, window_time, status)
      class(stepper_wrapper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      !> Length of the step and time that decides which torques act, as in `advance`, s.
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      call self%base%advance(system, state, dt, window_time, status)
      call self%copy_counts()
      if (status%code == 0) call self%copy_work()
      self%step_error = self%base%step_error
      self%moved_by_round_off = self%base%moved_by_round_off
   end subroutine advance_base

   !> Makes a stepper that continues with identical results.
   recursive subroutine copy(self, twin)
      class(stepper_wrapper_t), intent(inout) :: self
      class(stepper_t), allocatable, intent(out) :: twin
      class(stepper_t), allocatable :: base
      call move_alloc(self%base, base)
      allocate (twin, source=self)
      select type (twin)
      class is (stepper_wrapper_t)
         call base%copy(twin%base)
      end select
      call move_alloc(base, self%base)
   end subroutine copy

   !> Stores the starts of steps in the stepper inside, which repeats them: they are not changed by the wrapper.
   recursive subroutine keep_steps(self)
      class(stepper_wrapper_t), intent(inout) :: self
      call self%base%keep_steps()
      call keep_starts(self)
   end subroutine keep_steps

   !> Discards the history of the stepper inside.
   recursive subroutine forget_steps(self)
      class(stepper_wrapper_t), intent(inout) :: self
      call self%base%forget_steps()
   end subroutine forget_steps

   !> Notifies the stepper inside. The invariants that a wrapper stores remain valid: the work of the new values is
   !> counted as before.
   recursive subroutine update_commands(self)
      class(stepper_wrapper_t), intent(inout) :: self
      call self%base%update_commands()
   end subroutine update_commands

   !> Writes or reads the data that the stepper inside keeps between steps.
   subroutine transfer(self, archive)
      class(stepper_wrapper_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call self%base%transfer(archive)
   end subroutine transfer

end module nutate_stepper_wrapper
