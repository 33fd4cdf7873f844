!> Interface of the policies that choose and take the steps of a run: by a fixed length (`nutate_fixed_steps`), by their
!> error (`nutate_error_control`).
module nutate_step_policy
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: progress_t, run_point_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: step_policy_t

   !> A way to choose and take steps, with the steppers that it needs.
   type, abstract :: step_policy_t
      !> Steps, or parts of steps that are subdivided, between two calls of the observer's `poll`.
      integer(long) :: steps_per_poll = 1
      !> `state_inside` is available at all times of a step, by dense output.
      logical :: is_dense = .false.
      !> `state_inside` costs much less than a step.
      logical :: evaluates_cheaply = .false.
      !> Upper bound on the length of steps, s.
      real(wp) :: longest_step = huge(1.0_wp)
   contains
      !> Moves a run by one step.
      procedure(move_on), deferred :: advance
      !> Evaluates the state at a time inside the last step of the method, for an output point or for events.
      procedure(evaluate), deferred :: state_inside
      !> Projects the state at the end of the last step for output.
      procedure :: project_for_output => leave_state
      !> Prepares for events: each call of `advance` then ends at the first end of a step of the method.
      procedure(get_ready), deferred :: expect_events
      !> Repeats the last step of the method, shorter.
      procedure(repeat_part), deferred :: retake
      !> Moves the sensitivities of a run over the step of the method that was accepted last.
      procedure(propagate_sensitivities), deferred :: propagate
      !> Prepares again for a system that has changed.
      procedure(set_system), deferred :: renew
      !> Notes that torques and motors hold other values.
      procedure(update_values), deferred :: update_commands
      !> Writes or reads the data on which the next steps depend in checkpoint data.
      procedure(transfer_memory), deferred :: transfer
   end type step_policy_t

   abstract interface
      !> Moves a run by one step, and counts it; or finds that a step must be shorter, and counts none. Errors: why no
      !> step is possible, with the last state reached.
      subroutine move_on(self, system, progress, status, observer)
         import :: step_policy_t, system_t, progress_t, status_t, observer_t
         class(step_policy_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> Run that is not at its end.
         type(progress_t), intent(inout) :: progress
         !> Success on entry: a status that is passed down is not set to success again in every call.
         type(status_t), intent(inout) :: status
         !> Watches parts of steps.
         class(observer_t), intent(inout), optional :: observer
      end subroutine move_on

      !> Errors: those of the method.
      subroutine propagate_sensitivities(self, system, before, progress, status)
         import :: step_policy_t, system_t, state_t, progress_t, status_t
         class(step_policy_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> State at the start of the step.
         type(state_t), intent(in) :: before
         !> Run at the end of the step; its sensitivities are those at the start of the step on entry.
         type(progress_t), intent(inout) :: progress
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine propagate_sensitivities

      subroutine get_ready(self, system, progress, status)
         import :: step_policy_t, system_t, progress_t, status_t
         class(step_policy_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> Run that was started.
         type(progress_t), intent(inout) :: progress
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine get_ready

      !> Errors: those of the method.
      subroutine evaluate(self, system, progress, t, state, status, record, tangent, before)
         import :: step_policy_t, system_t, progress_t, run_point_t, run_record_t, state_t, status_t, tangent_t, wp
         class(step_policy_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> Run at the end of the step.
         type(progress_t), intent(in) :: progress
         !> Time inside the step, s.
         real(wp), intent(in) :: t
         type(state_t), intent(inout) :: state
         !> Success on entry.
         type(status_t), intent(inout) :: status
         !> Record of an output point of that state.
         type(run_record_t), intent(out), optional :: record
         !> Sensitivities at the start of the step on entry, at the time on exit.
         type(tangent_t), intent(inout), optional :: tangent
         !> The run before the step, for events: output points and later steps stay as they are.
         type(run_point_t), intent(in), optional :: before
      end subroutine evaluate

      !> Moves a run by a part of the step that was taken last, and counts no step of the run. Errors: those of the
      !> method.
      subroutine repeat_part(self, system, progress, t_end, status)
         import :: step_policy_t, system_t, progress_t, status_t, wp
         class(step_policy_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> Run as it was before that step.
         type(progress_t), intent(inout) :: progress
         !> Time at which the repeated part ends, s.
         real(wp), intent(in) :: t_end
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine repeat_part

      !> Errors: those of the methods' `prepare`.
      subroutine set_system(self, system, status)
         import :: step_policy_t, system_t, status_t
         class(step_policy_t), intent(inout) :: self
         type(system_t), intent(in) :: system
         !> Success on entry.
         type(status_t), intent(inout) :: status
      end subroutine set_system

      subroutine update_values(self)
         import :: step_policy_t
         class(step_policy_t), intent(inout) :: self
      end subroutine update_values

      subroutine transfer_memory(self, archive)
         import :: step_policy_t, archive_t
         class(step_policy_t), intent(inout) :: self
         class(archive_t), intent(inout) :: archive
      end subroutine transfer_memory
   end interface

contains

   !> Leaves the state as it is, for policies whose steps need no projection for output.
   subroutine leave_state(self, system, state)
      class(step_policy_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
   end subroutine leave_state

end module nutate_step_policy
