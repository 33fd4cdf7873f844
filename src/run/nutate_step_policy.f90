!> How the steps of a run are chosen and taken: by a fixed length (`nutate_fixed_steps`) or by their error
!> (`nutate_error_control`). All else is the run's own (`nutate_run_loop`).
module nutate_step_policy
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: progress_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   implicit none
   private

   public :: step_policy_t

   !> A way to choose and take steps, with the steppers that it needs.
   type, abstract :: step_policy_t
      !> Steps between two calls of the observer's `poll`.
      integer(long) :: steps_per_poll = 1
   contains
      !> Moves a run by one step.
      procedure(move_on), deferred :: advance
      !> The state at a time inside the last step.
      procedure :: state_inside => refuse_state
      !> Shows to an archive what the next steps depend on.
      procedure(show_memory), deferred :: transfer
   end type step_policy_t

   abstract interface
      !> Moves a run by one step, and counts it; or finds that a step must be shorter, and counts none. Errors: why no
      !> step is possible, with the last state reached.
      subroutine move_on(self, system, progress, status, observer)
         import :: step_policy_t, system_t, progress_t, status_t, observer_t
         class(step_policy_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> Not at its end.
         type(progress_t), intent(inout) :: progress
         !> Success on entry: what is passed down is not set to success again in every call.
         type(status_t), intent(inout) :: status
         !> Watches parts of steps.
         class(observer_t), intent(inout), optional :: observer
      end subroutine move_on

      subroutine show_memory(self, archive)
         import :: step_policy_t, archive_t
         class(step_policy_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine show_memory
   end interface

contains

   !> Refuses: inside steps of one length there are no rows.
   subroutine refuse_state(self, system, progress, t, state, record, status)
      class(step_policy_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> At the end of the step.
      type(progress_t), intent(in) :: progress
      !> s.
      real(wp), intent(in) :: t
      type(state_t), intent(out) :: state
      !> What belongs to a row of that state.
      type(run_record_t), intent(out) :: record
      type(status_t), intent(inout) :: status
      status = fail(NUTATE_BAD_ARGUMENT, 'rows at intervals need steps chosen by their error')
   end subroutine refuse_state

end module nutate_step_policy
