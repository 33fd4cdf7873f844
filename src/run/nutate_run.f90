!> Runs: from a state to an end time, with fixed or adaptive steps, and output points for an observer.
!>
!>     call integrate(system, settings, state, plan, status, observer, summary)
!>
!> is all that most programs need. A `run_t` splits a run into parts: it can find the steps before the output is opened,
!> continue from checkpoint data, or stop at user-defined times, and it continues from wherever it has stopped:
!>
!>     call run%begin(system, settings, state, plan, status)
!>     call run%run_to(system, t, status, observer)
!>     call run%run_steps(system, n, status, observer)
!>     call run%state_at(system, t, state, status)
module nutate_run
   use nutate_archive, only: archive_t
   use nutate_chaos_settings, only: chaos_settings_t
   use nutate_variation, only: variation_t
   use nutate_event_list, only: event_list_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: progress_t
   use nutate_summary, only: run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t, system_t
   use nutate_step_policy, only: step_policy_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: run_t, integrate
   !> Types of the arguments of `integrate`, which its callers need, and what an observer receives.
   public :: observer_t, run_record_t, run_summary_t, system_t

   !> A run: its plan, its progress and its step policy.
   type, extends(progress_t) :: run_t
      !> The stepper of fixed steps, prepared for the system.
      class(stepper_t), allocatable :: stepper
      !> The requested settings and goal; method and steps that they leave open are chosen for each end time.
      type(integrator_settings_t) :: requested
      type(run_goal_t), private :: goal
      !> Sensitivities as they were given, if there are any: those of a tangent follow the body.
      type(variation_t), allocatable, private :: variations(:)
      class(step_policy_t), allocatable :: policy
      !> Stepper of an earlier part of the run, which serves the next part if it has the same method.
      class(stepper_t), allocatable :: spare
   contains
      !> Sets a plan and the first state; prepares the steppers, or copies those that are prepared.
      generic :: begin => begin_by_settings, begin_by_stepper
      procedure, private, non_overridable :: begin_by_settings
      procedure, private, non_overridable :: begin_by_stepper
      !> Sets the events; to be called directly after `begin`.
      procedure, non_overridable :: set_events
      !> Sets sensitivities to propagate; between `begin` and all else.
      procedure, non_overridable :: differentiate
      !> Sets indicators of chaos to follow; between `differentiate`, if it is called, and all else.
      procedure, non_overridable :: follow_chaos
      !> Sets the plan for the next part of the run, from the current state.
      procedure, non_overridable :: set_plan
      !> Finds the local tolerance that meets the accuracy goal, by trial runs.
      procedure, non_overridable :: find_steps
      !> Restores checkpoint data; the run continues from there.
      procedure, non_overridable :: resume
      !> Runs to the end time of the plan.
      procedure, non_overridable :: run_to_end
      !> Runs to a time.
      procedure, non_overridable :: run_to
      !> Performs a number of fixed steps.
      procedure, non_overridable :: run_steps
      !> Returns the state at a time inside the last step (dense output).
      procedure, non_overridable :: state_at
      !> Return the number of fixed steps to a time, and the time at their end.
      procedure, non_overridable :: steps_to
      procedure, non_overridable :: end_of_steps
      !> Releases the step policy, so that the caller can perform single steps.
      procedure, non_overridable :: release
   end type run_t

   !> Integrates from a state to the end time of a plan.
   interface integrate
      module procedure integrate_by_settings
      module procedure integrate_by_stepper
   end interface integrate

   interface

      !> Integrates from `state` to the end time of a plan: by its time step, or by steps that keep to its goal.
      !>
      !> Errors: those of `begin`, `set_events` and `follow_chaos`; `NUTATE_BAD_ARGUMENT` for a plan without an end
      !> time; `NUTATE_STEP_LIMIT`; `NUTATE_NOT_CONVERGED` and others if no step is short enough; what the observer
      !> returned. `state` is then the last state reached.
      module subroutine integrate_by_settings(system, settings, state, plan, status, observer, summary, events, chaos)
         type(system_t), intent(in) :: system
         type(integrator_settings_t), intent(in) :: settings
         type(state_t), intent(inout) :: state
         type(run_plan_t), intent(in) :: plan
         type(status_t), intent(out) :: status
         !> Receives the output points.
         class(observer_t), intent(inout), optional :: observer
         !> Steps, work, error estimate and indicators of chaos of the run.
         type(run_summary_t), intent(out), optional :: summary
         !> Events to locate; the observer receives them.
         type(event_list_t), intent(in), optional :: events
         !> Indicators of chaos to follow.
         type(chaos_settings_t), intent(in), optional :: chaos
      end subroutine integrate_by_settings

      !> Integrates with fixed steps of a stepper that is already prepared, which may be a user-defined method; the
      !> stepper continues its previous steps. Errors as for `integrate_by_settings`.
      module subroutine integrate_by_stepper(system, stepper, state, plan, status, observer, summary, events)
         type(system_t), intent(in) :: system
         !> Stepper prepared for `system`.
         class(stepper_t), intent(inout), target :: stepper
         type(state_t), intent(inout) :: state
         !> Plan without a goal.
         type(run_plan_t), intent(in) :: plan
         type(status_t), intent(out) :: status
         class(observer_t), intent(inout), optional :: observer
         type(run_summary_t), intent(out), optional :: summary
         type(event_list_t), intent(in), optional :: events
      end subroutine integrate_by_stepper

      !> Sets a plan and the first state, chooses what the settings leave open, and prepares steppers; for a plan
      !> without an end time, in `run_to`. Errors: `NUTATE_BAD_BODY` for a system without a body; `NUTATE_BAD_ARGUMENT`
      !> for numbers of the plan that are out of range, for times of rows out of order, for effects that cannot be
      !> computed with, for a step that leads away from the end, and for settings that a method cannot honour.
      module subroutine begin_by_settings(self, system, settings, state, plan, status)
         class(run_t), intent(inout), target :: self
         type(system_t), intent(in) :: system
         type(integrator_settings_t), intent(in) :: settings
         type(state_t), intent(in) :: state
         type(run_plan_t), intent(in) :: plan
         type(status_t), intent(out) :: status
      end subroutine begin_by_settings

      !> Sets a plan and the first state, for fixed steps with a copy of a stepper that is already prepared, which may
      !> be a user-defined method. Errors: `NUTATE_BAD_ARGUMENT` for a plan with a goal, for numbers of the plan that
      !> are out of range, for times of rows out of order, for a stepper that was not prepared for the system, and for
      !> a step that leads away from the end.
      module subroutine begin_by_stepper(self, system, stepper, state, plan, status)
         class(run_t), intent(inout), target :: self
         type(system_t), intent(in) :: system
         !> Stepper prepared for `system`; it is not changed.
         class(stepper_t), intent(inout) :: stepper
         type(state_t), intent(in) :: state
         !> Plan without a goal.
         type(run_plan_t), intent(in) :: plan
         type(status_t), intent(out) :: status
      end subroutine begin_by_stepper

      !> Sets the plan for the next part of the run, from the current state; fixed steps continue the previous ones.
      !> Errors: those of `begin` and `set_events`.
      module subroutine set_plan(self, system, plan, status)
         !> Run that has begun.
         class(run_t), intent(inout), target :: self
         type(system_t), intent(in) :: system
         !> Plan; `first_time` and `steps_before` are those of the run.
         type(run_plan_t), intent(in) :: plan
         type(status_t), intent(out) :: status
      end subroutine set_plan

      !> Sets the events that the run locates. Errors: `NUTATE_BAD_ARGUMENT` for settings of an event that are out of
      !> range, for columns and effects to switch that do not exist, and for switches in a run to an accuracy, whose
      !> trial runs do not locate events.
      module subroutine set_events(self, events, system, status)
         !> Run that has begun.
         class(run_t), intent(inout), target :: self
         type(event_list_t), intent(in) :: events
         type(system_t), intent(in) :: system
         type(status_t), intent(out) :: status
      end subroutine set_events

      !> Sets sensitivities to propagate from here (`nutate_tangent`): `tangent` holds them. Errors, with no
      !> sensitivities set: `NUTATE_BAD_ARGUMENT` for effects without a derivative.
      module subroutine differentiate(self, variations, system, status)
         !> Run that has begun.
         class(run_t), intent(inout), target :: self
         !> Sensitivities to propagate; shape (n).
         type(variation_t), intent(in) :: variations(:)
         type(system_t), intent(in) :: system
         type(status_t), intent(out) :: status
      end subroutine differentiate

      !> Follows indicators of chaos from here (`nutate_chaos`), by additional sensitivities after those that the run
      !> propagates: `summary%chaos` holds them. Does nothing for settings without exponents. Errors:
      !> `NUTATE_BAD_ARGUMENT` for settings out of range, for effects without a derivative, and for a body at rest
      !> without a scale of momentum.
      module subroutine follow_chaos(self, settings, system, status)
         !> Run that has begun, and whose sensitivities are set, if it has any.
         class(run_t), intent(inout), target :: self
         type(chaos_settings_t), intent(in) :: settings
         type(system_t), intent(in) :: system
         type(status_t), intent(out) :: status
      end subroutine follow_chaos

      !> Finds the local tolerance that meets the accuracy goal, by trial runs; does nothing without such a goal, or if
      !> it is already known. `run_to_end` calls it if necessary.
      !>
      !> Errors: those of the trial runs, and what the observer returned.
      recursive module subroutine find_steps(self, system, status, observer, trial_observer)
         !> Run that has begun.
         class(run_t), intent(inout), target :: self
         type(system_t), intent(in) :: system
         type(status_t), intent(out) :: status
         !> Observer whose `poll` can end the search; the output points that it receives are the ends of trial runs.
         class(observer_t), intent(inout), optional :: observer
         !> Observer for a run without events, which receives only the output points at steps, of several runs from
         !> their start to their end. If trial runs were performed, the last one that it received is the run, which is
         !> then at its end.
         class(observer_t), intent(inout), optional :: trial_observer
      end subroutine find_steps

      !> Restores the checkpoint data that `save_checkpoint` of an observer received: the run continues from there.
      !> Errors: `NUTATE_BAD_ARGUMENT` for data of another run.
      module subroutine resume(self, archive, status)
         !> Run that has begun in the same way as the run that was saved.
         class(run_t), intent(inout), target :: self
         !> Checkpoint data, being read.
         class(archive_t), intent(inout) :: archive
         type(status_t), intent(out) :: status
      end subroutine resume

      !> Runs to the end time; the observer receives output points, polls and checkpoint data. Errors: those of the
      !> steps and of trial runs; `NUTATE_STEP_LIMIT`; what the observer returned. The state is then the last one
      !> reached.
      module subroutine run_to_end(self, system, status, observer)
         !> Run that has begun, with an end time.
         class(run_t), intent(inout), target :: self
         type(system_t), intent(in) :: system
         type(status_t), intent(out) :: status
         class(observer_t), intent(inout), optional :: observer
      end subroutine run_to_end

      !> Runs to a time from the current state. Errors: those of `begin` and `run_to_end`.
      module subroutine run_to(self, system, t, status, observer)
         !> Run that has begun.
         class(run_t), intent(inout), target :: self
         type(system_t), intent(in) :: system
         !> End time, s.
         real(wp), intent(in) :: t
         type(status_t), intent(out) :: status
         class(observer_t), intent(inout), optional :: observer
      end subroutine run_to

      !> Performs fixed steps from the current state. Errors: those of `begin` and `run_to_end`.
      module subroutine run_steps(self, system, n, status, observer)
         !> Run that has begun, without a goal.
         class(run_t), intent(inout), target :: self
         type(system_t), intent(in) :: system
         integer(long), intent(in) :: n
         type(status_t), intent(out) :: status
         class(observer_t), intent(inout), optional :: observer
      end subroutine run_steps

      !> Returns the time at the end of n fixed steps from here, s.
      pure real(wp) module function end_of_steps(self, n, time_step) result(t)
         class(run_t), intent(in) :: self
         integer(long), intent(in) :: n
         !> Nominal length of a step, s.
         real(wp), intent(in) :: time_step
      end function end_of_steps

      !> Returns the number of fixed steps from here to a time, the last one shortened if necessary.
      pure integer(long) module function steps_to(self, t, time_step) result(n)
         class(run_t), intent(in) :: self
         !> End time, and nominal length of a step, s.
         real(wp), intent(in) :: t, time_step
      end function steps_to

      !> Returns the state at a time inside the last step (dense output), to the accuracy of the method; later steps are
      !> unaffected. Errors: `NUTATE_BAD_ARGUMENT` for a time outside of the step, or one that has not been kept
      !> (`keeps_dense_output`), and for sensitivities that the run does not propagate.
      module subroutine state_at(self, system, t, state, status, tangent)
         class(run_t), intent(inout), target :: self
         type(system_t), intent(in) :: system
         !> Time inside the last step, s.
         real(wp), intent(in) :: t
         type(state_t), intent(out) :: state
         type(status_t), intent(out) :: status
         !> The sensitivities of the run at that time.
         type(tangent_t), intent(out), optional :: tangent
      end subroutine state_at

      !> Releases the step policy, so that the caller can perform single steps, and keeps its stepper as the spare one.
      module subroutine release(self)
         class(run_t), intent(inout), target :: self
      end subroutine release

   end interface

end module nutate_run
