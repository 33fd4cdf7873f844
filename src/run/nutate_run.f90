!> A run: from a state to an end time, by steps of one length or chosen by their error, with rows for an observer.
!>
!>     call integrate(system, settings, state, plan, status, observer, summary)
!>
!> is all that most programs need. A `run_t` is for those that do something between its parts: look for the steps before
!> the output is opened, or go on from an archive.
module nutate_run
   use nutate_accuracy, only: find_tolerance
   use nutate_archive, only: archive_t
   use nutate_control, only: is_watched, needs_control
   use nutate_error_control, only: error_control_t
   use nutate_fixed_steps, only: fixed_steps_t
   use nutate_event_tracker, only: event_list_t
   use nutate_kinds, only: wp
   use nutate_method_choice, only: choose_settings
   use nutate_methods, only: make_stepper
   use nutate_observer, only: observer_t
   use nutate_progress, only: conclude_run, is_over, progress_t, put_works, run_summary_t, start_run
   use nutate_run_loop, only: drive, transfer_run
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_step_policy, only: step_policy_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: run_t, integrate

   !> A run: what it is to do, how far it is, and its way to step.
   type, extends(progress_t) :: run_t
      class(step_policy_t), allocatable, private :: policy
   contains
      !> Takes a plan and the first state; prepares the steppers, or takes one that is prepared.
      generic :: begin => begin_by_settings, begin_by_stepper
      procedure, private :: begin_by_settings
      procedure, private :: begin_by_stepper
      !> Takes events to look for; between `begin` and all else.
      procedure :: expect
      !> Takes what an earlier run of the system knows.
      procedure :: go_on_from
      !> Finds the error of steps that meets the accuracy of the goal, by pilot runs.
      procedure :: find_steps
      !> Takes what an observer's `keep` was given: the run goes on from there.
      procedure :: resume
      !> Goes to the end.
      procedure :: go
   end type run_t

   !> Integrates from a state to the end time of a plan.
   interface integrate
      module procedure integrate_by_settings
      module procedure integrate_by_stepper
   end interface integrate

contains

   !> Integrates from `state` to the end time of a plan: by its time step, or by steps that keep to its goal.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for a step that leads away from the end, and for settings that a method cannot
   !> honour; `NUTATE_STEP_LIMIT`; `NUTATE_NOT_CONVERGED` and others where no step is short enough; what the observer
   !> returned. `state` is then the last state reached.
   subroutine integrate_by_settings(system, settings, state, plan, status, observer, summary, events)
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(state_t), intent(inout) :: state
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      !> Shown the rows.
      class(observer_t), intent(inout), optional :: observer
      !> What it took.
      type(run_summary_t), intent(out), optional :: summary
      !> Looked for, and shown to the observer.
      type(event_list_t), intent(in), optional :: events
      type(run_t) :: run
      call run%begin(system, settings, state, plan, status)
      if (present(events) .and. status%ok()) call run%expect(events, system, status)
      if (status%ok()) call run%go(system, status, observer)
      call conclude_run(run%progress_t, state, summary)
   end subroutine integrate_by_settings

   !> The same by steps of one length with a stepper that is prepared already, perhaps of a method of one's own. It
   !> remembers what it did before.
   subroutine integrate_by_stepper(system, stepper, state, plan, status, observer, summary, events)
      type(system_t), intent(in) :: system
      !> Prepared for `system`.
      class(stepper_t), intent(inout), target :: stepper
      type(state_t), intent(inout) :: state
      !> Without a goal.
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      class(observer_t), intent(inout), optional :: observer
      type(run_summary_t), intent(out), optional :: summary
      type(event_list_t), intent(in), optional :: events
      type(progress_t) :: progress
      type(fixed_steps_t) :: policy
      call start_run(progress, system%effects, state, plan, status)
      policy%lent => stepper
      if (status%ok()) call policy%begin(progress, status)
      if (status%ok()) call expect_events(progress, policy, event_list_t(), system, status)
      if (present(events) .and. status%ok()) call expect_events(progress, policy, events, system, status)
      if (status%ok()) call drive(progress, policy, system, status, observer)
      call conclude_run(progress, state, summary)
   end subroutine integrate_by_stepper

   !> Takes a plan and the first state, chooses what the settings leave open, and prepares steppers. Errors:
   !> `NUTATE_BAD_ARGUMENT` for a step that leads away from the end, and for settings that a method cannot honour.
   subroutine begin_by_settings(self, system, settings, state, plan, status)
      class(run_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(state_t), intent(in) :: state
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      type(error_control_t), allocatable :: control
      type(fixed_steps_t), allocatable :: fixed
      call start_run(self%progress_t, system%effects, state, plan, status)
      if (.not. status%ok()) return
      self%summary%settings = settings
      call choose_settings(system, state, plan%end_time - state%t, plan%goal%accuracy, plan%goal%local_tolerance, &
                           self%summary%settings, self%summary%choice, status)
      if (.not. status%ok()) return
      if (plan%goal%active()) then
         allocate (control)
         call control%begin(system, self%summary%settings, self%progress_t, status)
         call move_alloc(control, self%policy)
      else
         allocate (fixed)
         call make_stepper(system, self%summary%settings, fixed%own, status)
         if (status%ok()) call fixed%begin(self%progress_t, status)
         call move_alloc(fixed, self%policy)
      end if
      if (status%ok()) call expect_events(self%progress_t, self%policy, event_list_t(), system, status)
   end subroutine begin_by_settings

   !> Takes a plan without a goal, the first state, and a stepper.
   subroutine begin_by_stepper(self, system, stepper, state, plan, status)
      class(run_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> Prepared for `system`. It stays the caller's, and must be there for as long as the run goes on.
      class(stepper_t), intent(inout), target :: stepper
      type(state_t), intent(in) :: state
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      type(fixed_steps_t), allocatable :: fixed
      call start_run(self%progress_t, system%effects, state, plan, status)
      if (.not. status%ok()) return
      allocate (fixed)
      fixed%lent => stepper
      call fixed%begin(self%progress_t, status)
      call move_alloc(fixed, self%policy)
      if (status%ok()) call expect_events(self%progress_t, self%policy, event_list_t(), system, status)
   end subroutine begin_by_stepper

   !> Takes events to look for. Errors: `NUTATE_BAD_ARGUMENT` for a switch of an effect that there is not, and for
   !> switches in a run to an accuracy, whose pilot runs do not look for events.
   subroutine expect(self, events, system, status)
      !> Begun.
      class(run_t), intent(inout) :: self
      type(event_list_t), intent(in) :: events
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      call expect_events(self%progress_t, self%policy, events, system, status)
   end subroutine expect

   !> Takes events, and what the wheels of a system bring with them.
   subroutine expect_events(progress, policy, events, system, status)
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      type(event_list_t), intent(in) :: events
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      integer :: i
      logical :: is_first
      if (events%count() == 0 .and. allocated(progress%events)) return
      if (progress%plan%goal%accuracy > 0.0_wp .and. needs_control(system%effects)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'an accuracy is promised only where no wheel has a limit of its speed, '// &
                       'and no regulator samples or has limits (expected time_step or local_tolerance with '// &
                       'them)', 'accuracy')
         return
      end if
      if (events%count() == 0 .and. .not. is_watched(system%effects)) return
      do i = 1, events%count()
         if (events%slots(i)%item%action /= 0 .and. progress%plan%goal%accuracy > 0.0_wp) then
            status = fail(NUTATE_BAD_ARGUMENT, &
               'an accuracy is promised only where nothing is switched (expected time_step '// &
                          'or local_tolerance with a switch)', 'switch')
            return
         end if
      end do
      is_first = .not. allocated(progress%events)
      if (.not. is_first) deallocate (progress%events)
      allocate (progress%events)
      call progress%events%begin(events, system, progress%state, status)
      if (is_first .and. status%ok()) call policy%expect_events(system, progress, status)
   end subroutine expect_events

   !> Takes what an earlier run of the system, which ended in this one's first state, knows: its events, how often they
   !> have happened and on which side they are; and its works, if the nominal steps go on as well
   !> (`plan%steps_before`): then the two are one run to the last bit.
   subroutine go_on_from(self, before)
      !> Begun, its events expected.
      class(run_t), intent(inout) :: self
      !> It looked for the same events.
      type(progress_t), intent(in) :: before
      if (self%plan%steps_before > 0) then
         self%summary%work = before%summary%work
         self%work_compensation = before%work_compensation
         self%summary%world_work = before%summary%world_work
         self%world_compensation = before%world_compensation
         self%summary%unproved_steps = before%summary%unproved_steps
         self%next_break = before%next_break
         call put_works(self%summary, self%record)
      end if
      if (.not. (allocated(self%events) .and. allocated(before%events))) return
      self%events = before%events
      self%events%stopped = .false.
      self%events%n_due = 0
   end subroutine go_on_from

   !> Finds the error of steps that meets the accuracy of the goal, by pilot runs; where there is none, or it is known
   !> already, there is nothing to find. `go` does this if it has not been done.
   !>
   !> Errors: those of the pilot runs, and what the observer returned.
   subroutine find_steps(self, system, status, observer)
      !> Begun.
      class(run_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      !> Its `poll` can end the search; the rows that it is shown are the ends of pilot runs.
      class(observer_t), intent(inout), optional :: observer
      if (.not. lacks_steps(self)) return
      select type (control => self%policy)
      class is (error_control_t)
         call find_tolerance(system, self%summary%settings, self%progress_t, control, status, observer)
         if (status%ok()) call control%begin(system, self%summary%settings, self%progress_t, status)
      end select
   end subroutine find_steps

   !> True where pilot runs have to find the steps, and have not.
   pure logical function lacks_steps(self)
      class(run_t), intent(in) :: self
      associate (goal => self%plan%goal)
         lacks_steps = goal%accuracy > 0.0_wp .and. max(goal%error_rate, goal%local_tolerance) <= 0.0_wp .and. &
                       .not. is_over(self%progress_t)
      end associate
   end function lacks_steps

   !> Takes what an observer's `keep` was given: the run goes on from there. Errors: `NUTATE_BAD_ARGUMENT` for an
   !> archive of another run.
   subroutine resume(self, archive, status)
      !> Begun in the same way as the run in the archive.
      class(run_t), intent(inout) :: self
      !> Being read.
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      call transfer_run(self%progress_t, self%policy, archive)
      self%resumed = .true.
      if (archive%problem() /= '') &
         status = fail(NUTATE_BAD_ARGUMENT, 'the archive cannot be resumed: '//archive%problem())
   end subroutine resume

   !> Goes to the end, with rows, polls and archives for an observer. Errors: those of the steps and of pilot runs;
   !> `NUTATE_STEP_LIMIT`; what the observer returned. The state is then the last one reached.
   subroutine go(self, system, status, observer)
      !> Begun.
      class(run_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      class(observer_t), intent(inout), optional :: observer
      if (lacks_steps(self) .and. .not. present(observer) .and. .not. allocated(self%events)) then
         call go_unseen(self, system, status)
      else
         call self%find_steps(system, status)
         if (status%ok()) call drive(self%progress_t, self%policy, system, status, observer)
      end if
   end subroutine go

   !> Finds the steps and takes them, for nobody to see: the last run of the search is the run itself.
   subroutine go_unseen(self, system, status)
      class(run_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      type(progress_t) :: last
      select type (control => self%policy)
      class is (error_control_t)
         call find_tolerance(system, self%summary%settings, self%progress_t, control, status, last=last)
      end select
      if (.not. status%ok()) return
      if (.not. allocated(last%summary%work)) then
         call drive(self%progress_t, self%policy, system, status)
         return
      end if
      last%plan = self%plan
      last%summary%estimate = self%summary%estimate
      last%summary%round_off = self%summary%round_off
      last%summary%settings = self%summary%settings
      last%summary%choice = self%summary%choice
      self%progress_t = last
   end subroutine go_unseen

end module nutate_run
