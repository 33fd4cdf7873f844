!> Runs that can be asked to stop: what a C program wants to be asked while they go on.
module nutate_c_polls
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_procpointer, c_funptr, c_int, c_null_funptr, c_null_ptr, &
      c_ptr
   use nutate_c_effects, only: status_of_failure
   use nutate_kinds, only: wp, long
   use nutate_observer, only: observer_t, run_record_t
   use nutate_run, only: run_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_STOPPED
   use nutate_system, only: system_t
   implicit none
   private

   public :: poll_t, find_steps_asking, steps_between_polls

   !> The poll callback, and when it was called last.
   type :: poll_t
      type(c_funptr) :: function = c_null_funptr
      !> Passed through.
      type(c_ptr) :: user = c_null_ptr
      !> Count of the system's clock when it was asked.
      integer(long), private :: asked = 0
   contains
      !> Asks, if it is time to.
      procedure :: ask
   end type poll_t

   !> Calls the poll callback in trial runs, which write no output.
   type, extends(observer_t) :: trial_observer_t
      type(poll_t) :: callback
      !> Status and what the callback returned, of a callback that failed; shape (2).
      integer(c_int), pointer :: failure(:) => null()
   contains
      procedure :: observe => observe_trial
      procedure :: poll => poll_trial
   end type trial_observer_t

   abstract interface
      integer(c_int) function asked_function(user) bind(C)
         import :: c_int, c_ptr
         type(c_ptr), intent(in), value :: user
      end function asked_function
   end interface

   !> Time between two questions, s: a tenth of what a person notices, and a question to a program in Python takes 1e-6
   !> s.
   real(wp), parameter :: patience = 0.02_wp
   !> Steps between two looks at the clock, which takes a tenth of the cheapest step.
   integer(long), parameter :: steps_between_polls = 64

contains

   !> Asks, if it is time to. Errors: `NUTATE_STOPPED` where the answer is not 0.
   subroutine ask(self, status)
      class(poll_t), intent(inout) :: self
      !> Success on entry.
      type(status_t), intent(inout) :: status
      procedure(asked_function), pointer :: function
      integer(long) :: now, rate
      if (.not. c_associated(self%function)) return
      call system_clock(now, rate)
      if (self%asked > 0 .and. now - self%asked < int(patience*real(rate, wp), long)) return
      self%asked = now
      call c_f_procpointer(self%function, function)
      if (function(self%user) /= 0) status = fail(NUTATE_STOPPED, 'the run was asked to stop')
   end subroutine ask

   !> Finds the steps of a run that has begun, as its `find_steps` does, and asks in trial runs. Errors: those of trial
   !> run runs and of callbacks, and `NUTATE_STOPPED`.
   subroutine find_steps_asking(run, callback, failure, system, status)
      type(run_t), intent(inout) :: run
      type(poll_t), intent(in) :: callback
      !> Status and what the callback returned, of a callback that failed; shape (2).
      integer(c_int), intent(in), target :: failure(:)
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      type(trial_observer_t) :: trials
      trials%callback = callback
      trials%failure => failure
      call run%find_steps(system, status, trials)
   end subroutine find_steps_asking

   !> Ends a trial run where a callback has failed.
   subroutine observe_trial(self, system, state, record, status)
      class(trial_observer_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      status = status_of_failure(self%failure)
   end subroutine observe_trial

   !> Ends a trial run where a callback has failed, or the program wants it.
   subroutine poll_trial(self, fraction, status)
      class(trial_observer_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      status = status_of_failure(self%failure)
      if (status%ok()) call self%callback%ask(status)
   end subroutine poll_trial

end module nutate_c_polls
