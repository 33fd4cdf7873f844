!> Poll callbacks, with which a C program can stop runs.
module nutate_c_polls
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_procpointer, c_funptr, c_int, c_null_funptr, c_null_ptr, &
      c_ptr
   use nutate_c_effects, only: status_of_failure
   use nutate_kinds, only: wp, long
   use nutate_run, only: observer_t, run_record_t, run_t, system_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_STOPPED
   implicit none
   private

   public :: poll_t, trial_observer_t, find_steps_asking, steps_between_polls

   !> The poll callback, and the time of its last call.
   type :: poll_t
      type(c_funptr) :: function = c_null_funptr
      !> User data, passed to the callback.
      type(c_ptr) :: user = c_null_ptr
      !> System clock counts at the last call, and at the last reading.
      integer(long), private :: asked = 0, read = 0
      !> Polls until the clock is read again, and between two readings.
      integer, private :: left = 0, stride = 1
   contains
      !> Calls the callback, unless the last call was too recent.
      procedure, non_overridable :: ask
      procedure, non_overridable :: wants_end
   end type poll_t

   !> Calls the poll callback in trial runs and in those of fits, which write no output.
   type, extends(observer_t) :: trial_observer_t
      type(poll_t) :: callback
      !> Status of a callback that failed, and the value that it returned; shape (2). Null for scenes, which have none.
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

   !> Time between two calls of the poll callback, s: a tenth of what a person notices. A call to a Python program takes
   !> 1e-6 s.
   real(wp), parameter :: patience = 0.02_wp
   !> Most polls between two readings of the clock, and the time between two readings above which each poll reads it, s.
   integer, parameter :: most_polls = 16
   real(wp), parameter :: quick = 1e-3_wp
   !> Steps between two readings of the clock; a reading takes a tenth of the cheapest step.
   integer(long), parameter :: steps_between_polls = 64

contains

   !> Calls the callback, unless the last call was too recent. Errors: `NUTATE_STOPPED` if the callback does not return
   !> 0.
   subroutine ask(self, status)
      class(poll_t), intent(inout) :: self
      !> Status, success on entry.
      type(status_t), intent(inout) :: status
      if (self%wants_end()) status = fail(NUTATE_STOPPED, 'the run was asked to stop')
   end subroutine ask

   !> Returns true if the callback was called and does not return 0.
   logical function wants_end(self)
      class(poll_t), intent(inout) :: self
      procedure(asked_function), pointer :: function
      integer(long) :: now, rate
      wants_end = .false.
      if (.not. c_associated(self%function)) return
      self%left = self%left - 1
      if (self%left > 0) return
      call system_clock(now, rate)
      ! A reading takes 3 % of the cheapest step, so that quick steps share one.
      self%stride = min(2*self%stride, most_polls)
      if (now - self%read > int(quick*real(rate, wp), long)) self%stride = 1
      self%left = self%stride
      self%read = now
      if (self%asked > 0 .and. now - self%asked < int(patience*real(rate, wp), long)) return
      self%asked = now
      call c_f_procpointer(self%function, function)
      wants_end = function(self%user) /= 0
   end function wants_end

   !> Finds the steps of a run that has begun, with its `find_steps`, and calls the poll callback in trial runs. Errors:
   !> those of trial runs and of callbacks, and `NUTATE_STOPPED`.
   subroutine find_steps_asking(run, callback, failure, system, status)
      type(run_t), intent(inout) :: run
      type(poll_t), intent(in) :: callback
      !> Status of a callback that failed, and the value that it returned; shape (2).
      integer(c_int), intent(in), target :: failure(:)
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      type(trial_observer_t) :: trials
      trials%callback = callback
      trials%failure => failure
      call run%find_steps(system, status, trials)
   end subroutine find_steps_asking

   !> Ends a trial run if a callback has failed.
   subroutine observe_trial(self, system, state, record, status)
      class(trial_observer_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (associated(self%failure)) status = status_of_failure(self%failure)
   end subroutine observe_trial

   !> Ends a trial run if a callback has failed, or if the poll callback requests it.
   subroutine poll_trial(self, fraction, status)
      class(trial_observer_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      if (associated(self%failure)) status = status_of_failure(self%failure)
      if (status%ok()) call self%callback%ask(status)
   end subroutine poll_trial

end module nutate_c_polls
