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
   use nutate_accuracy, only: find_tolerance
   use nutate_archive, only: archive_t
   use nutate_chaos, only: chaos_settings_t
   use nutate_variation, only: variation_t
   use nutate_control, only: beyond_accuracy, is_watched
   use nutate_error_control, only: error_control_t
   use nutate_fixed_steps, only: count_steps, fixed_steps_t
   use nutate_event_tracker, only: event_list_t
   use nutate_kinds, only: wp, long
   use nutate_method_choice, only: choose_settings
   use nutate_methods, only: make_stepper
   use nutate_observer, only: observer_t
   use nutate_passed_windows, only: begin_windows, pass_windows_inside
   use nutate_progress, only: conclude_run, end_of_step, is_over, progress_t, run_summary_t, start_run, way_t
   use nutate_run_loop, only: drive, transfer_run
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t, outside, stepper_t
   use nutate_step_policy, only: step_policy_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: run_t, integrate

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
   contains
      !> Sets a plan and the first state; prepares the steppers, or copies those that are prepared.
      generic :: begin => begin_by_settings, begin_by_stepper
      procedure, private :: begin_by_settings
      procedure, private :: begin_by_stepper
      !> Sets the events; to be called directly after `begin`.
      procedure :: set_events
      !> Sets sensitivities to propagate; between `begin` and all else.
      procedure :: differentiate
      !> Sets indicators of chaos to follow; between `differentiate`, if it is called, and all else.
      procedure :: follow_chaos
      !> Sets the plan for the next part of the run, from the current state.
      procedure :: set_plan
      !> Finds the local tolerance that meets the accuracy goal, by trial runs.
      procedure :: find_steps
      !> Restores checkpoint data; the run continues from there.
      procedure :: resume
      !> Runs to the end time of the plan.
      procedure :: run_to_end
      !> Runs to a time.
      procedure :: run_to
      !> Performs a number of fixed steps.
      procedure :: run_steps
      !> Returns the state at a time inside the last step (dense output).
      procedure :: state_at
      !> Return the number of fixed steps to a time, and the time at their end.
      procedure :: steps_to
      procedure :: end_of_steps
      !> Releases the step policy, so that the caller can perform single steps.
      procedure :: release
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
   !> honour; `NUTATE_STEP_LIMIT`; `NUTATE_NOT_CONVERGED` and others if no step is short enough; what the observer
   !> returned. `state` is then the last state reached.
   subroutine integrate_by_settings(system, settings, state, plan, status, observer, summary, events, chaos)
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
      type(run_t) :: run
      call run%begin(system, settings, state, plan, status)
      if (present(events) .and. status%ok()) call run%set_events(events, system, status)
      if (present(chaos) .and. status%ok()) call run%follow_chaos(chaos, system, status)
      if (status%ok()) call run%run_to_end(system, status, observer)
      call conclude_run(run%progress_t, state, summary)
   end subroutine integrate_by_settings

   !> Integrates with fixed steps of a stepper that is already prepared, which may be a user-defined method; the stepper
   !> continues its previous steps. Errors as for `integrate_by_settings`.
   subroutine integrate_by_stepper(system, stepper, state, plan, status, observer, summary, events)
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
      type(progress_t) :: progress
      type(fixed_steps_t) :: policy
      call start_run(progress, system%effects, state, plan, status)
      policy%stepper => stepper
      if (status%ok()) call policy%begin(progress, status)
      if (status%ok()) call expect_events(progress, policy, event_list_t(), system, status)
      if (present(events) .and. status%ok()) call expect_events(progress, policy, events, system, status)
      if (status%ok()) call drive(progress, policy, system, status, observer)
      call conclude_run(progress, state, summary)
   end subroutine integrate_by_stepper

   !> Sets a plan and the first state, chooses what the settings leave open, and prepares steppers; for a plan without
   !> an end time, in `run_to`. Errors: `NUTATE_BAD_ARGUMENT` for a step that leads away from the end, and for settings
   !> that a method cannot honour.
   subroutine begin_by_settings(self, system, settings, state, plan, status)
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(state_t), intent(in) :: state
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      call start_run(self%progress_t, system%effects, state, plan, status)
      if (.not. status%ok()) return
      self%requested = settings
      self%goal = plan%goal
      if (allocated(self%stepper)) deallocate (self%stepper)
      call self%release()
      if (plan%end_time < huge(plan%end_time)) call prepare_steps(self, system, status)
   end subroutine begin_by_settings

   !> Sets a plan and the first state, for fixed steps with a copy of a stepper that is already prepared, which may be a
   !> user-defined method.
   subroutine begin_by_stepper(self, system, stepper, state, plan, status)
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      !> Stepper prepared for `system`; it is not changed.
      class(stepper_t), intent(inout) :: stepper
      type(state_t), intent(in) :: state
      !> Plan without a goal.
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      if (plan%goal%active()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'adaptive steps are made from settings, not from a stepper')
         return
      end if
      call start_run(self%progress_t, system%effects, state, plan, status)
      if (.not. status%ok()) return
      call stepper%copy(self%stepper)
      call self%release()
      if (plan%end_time < huge(plan%end_time)) call prepare_steps(self, system, status)
   end subroutine begin_by_stepper

   !> Sets the plan for the next part of the run, from the current state; fixed steps continue the previous ones.
   !> Errors: those of `begin`.
   subroutine set_plan(self, system, plan, status)
      !> Run that has begun.
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      !> Plan; `first_time` and `steps_before` are those of the run.
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(out) :: status
      type(run_plan_t) :: own
      own = plan
      if (is_on_grid(self, plan%time_step) .and. .not. plan%goal%active()) then
         own%steps_before = self%plan%steps_before
      else
         own%steps_before = -self%summary%steps
         self%t_first = self%state%t
         self%next_break = system%effects%next_break(self%state%t, sign(1.0_wp, plan%end_time - self%state%t))
      end if
      self%plan = own
      self%way = way_t()
      self%n_steps = -1
      self%first_step = self%summary%steps
      self%rows = 0
      self%resumed = .false.
      self%keeps_starts = .true.
      self%summary%estimate = 0.0_wp
      self%summary%round_off = 0.0_wp
      self%summary%table_error = 0.0_wp
      call prepare_steps(self, system, status)
   end subroutine set_plan

   !> Returns true if the next nominal step continues the previous ones.
   pure logical function is_on_grid(self, time_step)
      class(run_t), intent(in) :: self
      !> Nominal length of a step, s.
      real(wp), intent(in) :: time_step
      is_on_grid = .not. (self%way%begun .or. self%plan%goal%active() .or. &
                          abs(self%plan%time_step - time_step) > 0.0_wp)
      if (is_on_grid) is_on_grid = .not. abs(end_of_step(self%progress_t, self%summary%steps) - self%state%t) > 0.0_wp
   end function is_on_grid

   !> Prepares the policy that takes the steps of the plan. Errors: those of `begin`.
   subroutine prepare_steps(self, system, status)
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      type(error_control_t), allocatable :: control
      type(fixed_steps_t), allocatable :: fixed
      integer :: i
      if (self%plan%goal%active()) then
         call choose(self, system, status)
         if (.not. status%ok()) return
         allocate (control)
         call control%begin(system, self%summary%settings, self%progress_t, status)
         call move_alloc(control, self%policy)
      else
         if (.not. allocated(self%stepper)) then
            call choose(self, system, status)
            if (status%ok()) call make_stepper(system, self%summary%settings, self%stepper, status)
         end if
         if (.not. status%ok()) return
         allocate (fixed)
         call move_alloc(fixed, self%policy)
         call point_to_stepper(self)
         select type (policy => self%policy)
         class is (fixed_steps_t)
            call policy%begin(self%progress_t, status)
         end select
      end if
      if (.not. status%ok()) return
      if (allocated(self%events)) then
         self%events%stopped = .false.
         self%events%n_due = 0
         associate (watched => self%events%watched(:self%events%n_asked))
            call check_promise(self%plan, system, any([(watched(i)%event%action /= 0, i=1, size(watched))]), status)
         end associate
         if (status%ok()) call self%policy%expect_events(system, self%progress_t, status)
      else
         call expect_events(self%progress_t, self%policy, event_list_t(), system, status)
      end if
   end subroutine prepare_steps

   !> Chooses what the settings leave open. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine choose(self, system, status)
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      self%summary%settings = self%requested
      associate (plan => self%plan)
         call choose_settings(system, self%state, plan%end_time - self%state%t, plan%goal%accuracy, &
                              plan%goal%local_tolerance, self%summary%settings, self%summary%choice, status)
      end associate
   end subroutine choose

   !> Points the policy to the present address of the stepper: the run may be a copy.
   subroutine point_to_stepper(self)
      class(run_t), intent(inout), target :: self
      select type (policy => self%policy)
      class is (fixed_steps_t)
         policy%stepper => self%stepper
      end select
   end subroutine point_to_stepper

   !> Sets the events that the run locates. Errors: `NUTATE_BAD_ARGUMENT` for a switch of an effect that does not exist,
   !> and for switches in a run to an accuracy, whose trial runs do not locate events.
   subroutine set_events(self, events, system, status)
      !> Run that has begun.
      class(run_t), intent(inout), target :: self
      type(event_list_t), intent(in) :: events
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      call point_to_stepper(self)
      call expect_events(self%progress_t, self%policy, events, system, status)
   end subroutine set_events

   !> Sets sensitivities to propagate from here (`nutate_tangent`): `tangent` holds them. Errors, with no sensitivities
   !> set: `NUTATE_BAD_ARGUMENT` for effects without a derivative.
   subroutine differentiate(self, variations, system, status)
      !> Run that has begun.
      class(run_t), intent(inout), target :: self
      !> Sensitivities to propagate; shape (n).
      type(variation_t), intent(in) :: variations(:)
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      integer :: k
      self%variations = variations
      if (any([(variations(k)%changes_orbit(), k=1, size(variations))])) call step_in_space_axes(self, system, status)
      if (status%ok()) call begin_sensitivities(self, variations, system, status)
   end subroutine differentiate

   !> Has the steps taken in the space axes of the system: derivatives by the elements of an orbit require that. Errors:
   !> those of `begin`.
   subroutine step_in_space_axes(self, system, status)
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      type(integrator_settings_t) :: settings
      if (self%summary%settings%in_space_axes) return
      self%requested%in_space_axes = .true.
      self%summary%settings%in_space_axes = .true.
      if (allocated(self%stepper)) then
         settings = self%stepper%prepared_with
         settings%in_space_axes = .true.
         call make_stepper(system, settings, self%stepper, status)
      end if
      if (allocated(self%policy) .and. status%ok()) call prepare_steps(self, system, status)
   end subroutine step_in_space_axes

   !> Begins the sensitivities at the present state. Errors: those of `differentiate`.
   subroutine begin_sensitivities(self, variations, system, status)
      class(run_t), intent(inout), target :: self
      !> Sensitivities to propagate; shape (n).
      type(variation_t), intent(in) :: variations(:)
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      if (allocated(self%tangent)) deallocate (self%tangent, self%last_tangent)
      if (allocated(self%events)) call self%events%forget_changes()
      allocate (self%tangent, self%last_tangent)
      call self%tangent%begin(system, self%state, variations, status)
      if (status%ok()) then
         call begin_windows(self%progress_t, system)
         self%last_tangent = self%tangent
      else
         deallocate (self%tangent, self%last_tangent)
      end if
   end subroutine begin_sensitivities

   !> Follows indicators of chaos from here (`nutate_chaos`), by additional sensitivities after those that the run
   !> propagates: `summary%chaos` holds them. Does nothing for settings without exponents. Errors: `NUTATE_BAD_ARGUMENT`
   !> for effects without a derivative, and for a body at rest without a scale of momentum.
   subroutine follow_chaos(self, settings, system, status)
      !> Run that has begun, and whose sensitivities are set, if it has any.
      class(run_t), intent(inout), target :: self
      type(chaos_settings_t), intent(in) :: settings
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      type(variation_t), allocatable :: variations(:)
      integer :: n
      if (settings%exponents == 0) return
      n = 0
      if (allocated(self%tangent)) n = size(self%variations)
      allocate (variations(n + settings%exponents))
      if (n > 0) variations(:n) = self%variations
      variations(n + 1:)%name = 'deviation'
      call begin_sensitivities(self, variations, system, status)
      if (.not. status%ok()) return
      if (allocated(self%summary%chaos)) deallocate (self%summary%chaos)
      allocate (self%summary%chaos)
      call self%summary%chaos%begin(settings, system, self%state, self%tangent, status)
      if (status%ok()) self%last_tangent = self%tangent
   end subroutine follow_chaos

   !> Sets events, and those of the limits and samples of a system.
   subroutine expect_events(progress, policy, events, system, status)
      type(progress_t), intent(inout) :: progress
      class(step_policy_t), intent(inout) :: policy
      type(event_list_t), intent(in) :: events
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      logical :: is_first, switches
      integer :: i
      if (events%count() == 0 .and. allocated(progress%events)) return
      switches = .false.
      do i = 1, events%count()
         switches = switches .or. events%slots(i)%item%action /= 0
      end do
      call check_promise(progress%plan, system, switches, status)
      if (.not. status%ok() .or. (events%count() == 0 .and. .not. is_watched(system%effects))) return
      is_first = .not. allocated(progress%events)
      if (.not. is_first) deallocate (progress%events)
      allocate (progress%events)
      call progress%events%begin(events, system, progress%state, status)
      if (is_first .and. status%ok()) call policy%expect_events(system, progress, status)
   end subroutine expect_events

   !> Tests whether the accuracy of a plan can be promised. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_promise(plan, system, switches, status)
      type(run_plan_t), intent(in) :: plan
      type(system_t), intent(in) :: system
      !> Events switch something.
      logical, intent(in) :: switches
      type(status_t), intent(inout) :: status
      character(len=:), allocatable :: words
      if (.not. plan%goal%accuracy > 0.0_wp) return
      words = beyond_accuracy(system%effects, switches)
      if (words /= '') status = fail(NUTATE_BAD_ARGUMENT, words//' (expected time_step or local_tolerance)', 'accuracy')
   end subroutine check_promise

   !> Finds the local tolerance that meets the accuracy goal, by trial runs; does nothing without such a goal, or if it
   !> is already known. `run_to_end` calls it if necessary.
   !>
   !> Errors: those of the trial runs, and what the observer returned.
   recursive subroutine find_steps(self, system, status, observer, trial_observer)
      !> Run that has begun.
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      !> Observer whose `poll` can end the search; the output points that it receives are the ends of trial runs.
      class(observer_t), intent(inout), optional :: observer
      !> Observer for a run without events, which receives only the output points at steps, of several runs from their
      !> start to their end. If trial runs were performed, the last one that it received is the run, which is then at
      !> its end.
      class(observer_t), intent(inout), optional :: trial_observer
      type(progress_t) :: last
      if (.not. lacks_steps(self)) return
      if (allocated(self%tangent) .and. present(trial_observer)) then
         call self%find_steps(system, status, observer)
         return
      end if
      select type (control => self%policy)
      class is (error_control_t)
         call find_tolerance(system, self%summary%settings, self%progress_t, control, status, observer, last, &
            trial_observer)
         if (.not. status%ok()) return
         if (present(trial_observer) .and. allocated(last%summary%work)) then
            call use_last_run(self, last)
         else
            call control%begin(system, self%summary%settings, self%progress_t, status)
         end if
      end select
   end subroutine find_steps

   !> Returns true if trial runs have to find the steps, and have not yet.
   pure logical function lacks_steps(self)
      class(run_t), intent(in) :: self
      associate (goal => self%plan%goal)
         lacks_steps = goal%accuracy > 0.0_wp .and. max(goal%error_rate, goal%local_tolerance) <= 0.0_wp .and. &
                       .not. is_over(self%progress_t)
      end associate
   end function lacks_steps

   !> Restores the checkpoint data that `save_checkpoint` of an observer received: the run continues from there. Errors:
   !> `NUTATE_BAD_ARGUMENT` for data of another run.
   subroutine resume(self, archive, status)
      !> Run that has begun in the same way as the run that was saved.
      class(run_t), intent(inout), target :: self
      !> Checkpoint data, being read.
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      call point_to_stepper(self)
      call transfer_run(self%progress_t, self%policy, archive)
      self%resumed = .true.
      if (archive%problem() /= '') &
         status = fail(NUTATE_BAD_ARGUMENT, 'the checkpoint data cannot be resumed: '//archive%problem())
   end subroutine resume

   !> Runs to the end time; the observer receives output points, polls and checkpoint data. Errors: those of the steps
   !> and of trial runs; `NUTATE_STEP_LIMIT`; what the observer returned. The state is then the last one reached.
   subroutine run_to_end(self, system, status, observer)
      !> Run that has begun, with an end time.
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      class(observer_t), intent(inout), optional :: observer
      call point_to_stepper(self)
      if (lacks_steps(self) .and. self%first_step == 0 .and. &
          .not. (allocated(self%tangent) .or. present(observer) .or. allocated(self%events) .or. &
                 self%keeps_dense_output)) then
         call go_unseen(self, system, status)
      else
         call self%find_steps(system, status)
         if (status%ok()) call drive(self%progress_t, self%policy, system, status, observer)
      end if
   end subroutine run_to_end

   !> Finds and performs the steps without an observer: the last run of the search is the run itself.
   subroutine go_unseen(self, system, status)
      class(run_t), intent(inout), target :: self
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
      else
         call use_last_run(self, last)
      end if
   end subroutine go_unseen

   !> Uses the last run of a search as the run itself.
   subroutine use_last_run(self, last)
      class(run_t), intent(inout) :: self
      !> Last run, at its end.
      type(progress_t), intent(inout) :: last
      last%plan = self%plan
      last%summary%estimate = self%summary%estimate
      last%summary%round_off = self%summary%round_off
      last%summary%table_error = self%summary%table_error
      last%summary%settings = self%summary%settings
      last%summary%choice = self%summary%choice
      self%progress_t = last
   end subroutine use_last_run

   !> Runs to a time from the current state. Errors: those of `begin` and `run_to_end`.
   subroutine run_to(self, system, t, status, observer)
      !> Run that has begun.
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      !> End time, s.
      real(wp), intent(in) :: t
      type(status_t), intent(out) :: status
      class(observer_t), intent(inout), optional :: observer
      type(run_plan_t) :: plan
      plan = self%plan
      plan%goal = self%goal
      plan%end_time = t
      plan%steps = -1
      call self%set_plan(system, plan, status)
      if (status%ok()) call self%run_to_end(system, status, observer)
   end subroutine run_to

   !> Performs fixed steps from the current state. Errors: those of `begin` and `run_to_end`.
   subroutine run_steps(self, system, n, status, observer)
      !> Run that has begun, without a goal.
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      integer(long), intent(in) :: n
      type(status_t), intent(out) :: status
      class(observer_t), intent(inout), optional :: observer
      type(run_plan_t) :: plan
      plan = self%plan
      plan%steps = n
      plan%end_time = self%end_of_steps(n, plan%time_step)
      call self%set_plan(system, plan, status)
      if (status%ok()) call self%run_to_end(system, status, observer)
   end subroutine run_steps

   !> Returns the time at the end of n fixed steps from here, s.
   pure real(wp) function end_of_steps(self, n, time_step) result(t)
      class(run_t), intent(in) :: self
      integer(long), intent(in) :: n
      !> Nominal length of a step, s.
      real(wp), intent(in) :: time_step
      t = self%state%t + real(n, wp)*time_step
      if (is_on_grid(self, time_step)) t = end_of_step(self%progress_t, self%summary%steps + n)
   end function end_of_steps

   !> Returns the number of fixed steps from here to a time, the last one shortened if necessary.
   pure integer(long) function steps_to(self, t, time_step) result(n)
      class(run_t), intent(in) :: self
      !> End time, and nominal length of a step, s.
      real(wp), intent(in) :: t, time_step
      type(run_plan_t) :: plan
      plan = run_plan_t(time_step=time_step, end_time=t)
      if (is_on_grid(self, time_step)) then
         n = count_steps(self%t_first, plan) - (self%plan%steps_before + self%summary%steps)
      else
         n = count_steps(self%state%t, plan)
      end if
      n = max(n, 0_long)
   end function steps_to

   !> Returns the state at a time inside the last step (dense output), to the accuracy of the method; later steps are
   !> unaffected. Errors: `NUTATE_BAD_ARGUMENT` for a time outside of the step, or one that has not been kept
   !> (`keeps_dense_output`), and for sensitivities that the run does not propagate.
   subroutine state_at(self, system, t, state, status, tangent)
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      !> Time inside the last step, s.
      real(wp), intent(in) :: t
      type(state_t), intent(out) :: state
      type(status_t), intent(out) :: status
      !> The sensitivities of the run at that time.
      type(tangent_t), intent(out), optional :: tangent
      real(wp) :: work
      if (present(tangent)) then
         if (.not. (allocated(self%policy) .and. allocated(self%last_tangent))) then
            status = fail(NUTATE_BAD_ARGUMENT, &
               'the run propagates no sensitivities (expected a call of differentiate before)', &
                          'tangent')
            return
         end if
         tangent = self%last_tangent
      end if
      if (allocated(self%policy)) then
         call point_to_stepper(self)
         call self%policy%state_inside(system, self%progress_t, t, state, status, tangent=tangent)
         if (present(tangent) .and. status%ok()) &
            call pass_windows_inside(self%progress_t, system, state, tangent)
      else if (allocated(self%stepper)) then
         call self%stepper%state_at(system, t, state, work, status)
      else
         status = fail(NUTATE_BAD_ARGUMENT, outside, 't')
      end if
   end subroutine state_at

   !> Releases the step policy, so that the caller can perform single steps.
   subroutine release(self)
      class(run_t), intent(inout), target :: self
      if (allocated(self%policy)) deallocate (self%policy)
   end subroutine release

end module nutate_run
