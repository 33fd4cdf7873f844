!> Bodies of the procedures whose interfaces are in `nutate_run`.
submodule(nutate_run) nutate_run_procedures
   use nutate_accuracy, only: find_tolerance
   use nutate_chaos_settings, only: most_exponents
   use nutate_control, only: beyond_accuracy, is_watched
   use nutate_error_control, only: error_control_t, is_evaluable
   use nutate_event_tracker, only: event_tracker_t
   use nutate_fixed_steps, only: fixed_steps_t
   use nutate_kinds, only: eps
   use nutate_limits, only: is_moderate
   use nutate_method_choice, only: choose_settings
   use nutate_methods, only: make_stepper
   use nutate_passed_windows, only: begin_windows, pass_windows_inside
   use nutate_progress, only: conclude_run, end_of_step, is_over, start_run, way_t
   use nutate_range, only: check_system
   use nutate_run_loop, only: drive, transfer_run
   use nutate_run_plan, only: count_steps
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: check_prepared, outside
   use nutate_varying_inertia, only: check_change
   implicit none

contains

   module procedure integrate_by_settings
      type(run_t) :: run
      call run%begin(system, settings, state, plan, status)
      if (present(events) .and. status%ok()) call run%set_events(events, system, status)
      if (present(chaos) .and. status%ok()) call run%follow_chaos(chaos, system, status)
      if (status%ok()) call run%run_to_end(system, status, observer)
      call conclude_run(run%progress_t, state, summary)
   end procedure integrate_by_settings

   module procedure integrate_by_stepper
      type(progress_t) :: progress
      type(fixed_steps_t) :: policy
      call check_plan(plan, state%t, status)
      if (status%ok()) call check_steps_before(plan, state%t, status)
      if (status%ok()) call check_end(plan, status)
      if (status%ok()) call check_prepared(stepper, system, status)
      if (status%ok()) call start_run(progress, system%effects, state, plan, status)
      policy%stepper => stepper
      if (status%ok()) call policy%begin(progress, status)
      if (status%ok()) call expect_events(progress, event_list_t(), system, status, policy)
      if (present(events) .and. status%ok()) call expect_events(progress, events, system, status, policy)
      if (status%ok()) call drive(progress, policy, system, status, observer)
      call conclude_run(progress, state, summary)
   end procedure integrate_by_stepper

   module procedure begin_by_settings
      call check_plan(plan, state%t, status)
      if (status%ok()) call check_steps_before(plan, state%t, status)
      if (status%ok()) call check_system(system, status)
      if (status%ok()) call start_run(self%progress_t, system%effects, state, plan, status)
      if (.not. status%ok()) return
      self%requested = settings
      self%goal = plan%goal
      if (allocated(self%stepper)) deallocate (self%stepper)
      call self%release()
      if (plan%end_time < huge(plan%end_time)) call prepare_steps(self, system, status)
   end procedure begin_by_settings

   module procedure begin_by_stepper
      if (plan%goal%active()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'adaptive steps are made from settings, not from a stepper')
         return
      end if
      call check_plan(plan, state%t, status)
      if (status%ok()) call check_steps_before(plan, state%t, status)
      if (status%ok()) call check_prepared(stepper, system, status)
      if (status%ok()) call start_run(self%progress_t, system%effects, state, plan, status)
      if (.not. status%ok()) return
      call stepper%copy(self%stepper)
      call self%release()
      if (plan%end_time < huge(plan%end_time)) call prepare_steps(self, system, status)
   end procedure begin_by_stepper

   module procedure set_plan
      type(run_plan_t) :: own
      call check_plan(plan, self%state%t, status)
      if (status%ok()) call check_works(self, system, status)
      if (.not. status%ok()) return
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
   end procedure set_plan

   !> Tests the numbers of a plan. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_plan(plan, start, status)
      type(run_plan_t), intent(in) :: plan
      !> Start of the run, s.
      real(wp), intent(in) :: start
      type(status_t), intent(out) :: status
      character(len=15), parameter :: names(3) = [character(len=15) :: 'accuracy', 'local_tolerance', 'error_rate']
      character(len=:), allocatable :: name
      real(wp) :: goals(3)
      logical :: fits(3)
      goals = [plan%goal%accuracy, plan%goal%local_tolerance, plan%goal%error_rate]
      fits = is_moderate(goals) .and. goals >= 0.0_wp
      if (.not. is_moderate(start)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time is not finite or too large (expected up to 1e100 s)', 't')
      else if (plan%every < 1) then
         status = fail(NUTATE_BAD_ARGUMENT, 'rows are at least one step apart (expected every >= 1)', 'every')
      else if (.not. abs(plan%end_time) <= huge(plan%end_time)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the end time is not finite (expected a time in s)', 'end_time')
      else if (.not. is_moderate(plan%time_step)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time step is not finite or too large (expected up to 1e100 s)', &
                       'time_step')
      else if (.not. all(fits)) then
         name = trim(names(findloc(fits, .false., 1)))
         status = fail(NUTATE_BAD_ARGUMENT, name//' is out of range (expected a number > 0, or 0 for none)', name)
      else if (.not. (is_moderate(plan%interval) .and. plan%interval >= 0.0_wp)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the interval between rows is out of range (expected a number >= 0)', &
                       'interval')
      else if (.not. leads_to(plan, start, plan%steps, plan%end_time)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the steps do not lead to the end time (expected end_time after steps '// &
                       'times time_step, or steps < 0)', 'steps')
      else if (allocated(plan%times) .and. plan%end_time < huge(plan%end_time)) then
         if (.not. are_in_order(plan, start)) status = fail(NUTATE_BAD_ARGUMENT, &
            'the times of the rows are not in order (expected times from the present one towards end_time)', 'times')
      end if
   end subroutine check_plan

   !> Tests whether the steps before a run end at its start. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_steps_before(plan, start, status)
      type(run_plan_t), intent(in) :: plan
      !> Start of the run, s.
      real(wp), intent(in) :: start
      type(status_t), intent(inout) :: status
      if (plan%steps_before == 0) return
      if (plan%steps_before < 0 .or. .not. (is_moderate(plan%first_time) .and. &
                                            leads_to(plan, plan%first_time, plan%steps_before, start))) &
         status = fail(NUTATE_BAD_ARGUMENT, 'the steps before the run do not end at its start (expected it at '// &
                       'first_time after steps_before times time_step)', 'steps_before')
   end subroutine check_steps_before

   !> Returns true if fixed steps lead from a time to another one, which may be half a step away, or are not counted.
   pure logical function leads_to(plan, start, steps, end_time)
      type(run_plan_t), intent(in) :: plan
      !> Times at the start and at the end of the steps, s; a huge end: not yet set.
      real(wp), intent(in) :: start, end_time
      !> Number of steps; negative: not counted.
      integer(long), intent(in) :: steps
      leads_to = steps < 0 .or. plan%goal%active() .or. .not. end_time < huge(end_time)
      if (leads_to) return
      leads_to = abs(start + real(steps, wp)*plan%time_step - end_time) <= &
                 0.5_wp*abs(plan%time_step) + 8*eps*max(abs(start), abs(end_time))
   end function leads_to

   !> Tests whether a run has begun, with as many works as a system has. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_works(self, system, status)
      class(run_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      if (.not. allocated(self%summary%work)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the run has not begun (expected begin before)', 'run')
      else if (size(self%summary%work) /= system%effects%n_works()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the run has begun with other effects (expected begin)', 'system')
      end if
   end subroutine check_works

   !> Returns true if the times of the output points are in the order of the run, from its start.
   !> Times after its end are not reached.
   pure logical function are_in_order(plan, start)
      !> Plan with such times.
      type(run_plan_t), intent(in) :: plan
      !> Start of the run, s.
      real(wp), intent(in) :: start
      real(wp) :: sense
      sense = sign(1.0_wp, plan%end_time - start)
      associate (times => plan%times, n => size(plan%times))
         are_in_order = all(is_moderate(times))
         if (.not. are_in_order .or. n == 0) return
         are_in_order = all(sense*(times(2:) - times(:n - 1)) >= 0.0_wp) .and. sense*(times(1) - start) >= 0.0_wp
      end associate
   end function are_in_order

   !> Tests whether a plan has an end. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine check_end(plan, status)
      type(run_plan_t), intent(in) :: plan
      type(status_t), intent(inout) :: status
      if (.not. plan%end_time < huge(plan%end_time)) status = fail(NUTATE_BAD_ARGUMENT, &
         'the plan has no end time (expected end_time, or run_to)', 'end_time')
   end subroutine check_end

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
      call check_change(system, self%state%t, self%plan%end_time, status)
      if (.not. status%ok()) return
      if (self%plan%goal%active()) then
         call choose(self, system, status)
         if (.not. status%ok()) return
         call self%release()
         allocate (control)
         if (allocated(self%spare)) call move_alloc(self%spare, control%half)
         call control%begin(system, self%summary%settings, self%progress_t, status)
         if (status%ok()) call move_alloc(control, self%policy)
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
         call expect_events(self%progress_t, event_list_t(), system, status, self%policy)
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

   module procedure set_events
      if (.not. allocated(self%policy)) then
         call expect_events(self%progress_t, events, system, status)
      else
         call point_to_stepper(self)
         call expect_events(self%progress_t, events, system, status, self%policy)
      end if
   end procedure set_events

   module procedure differentiate
      integer :: k
      self%variations = variations
      if (any([(variations(k)%changes_orbit(), k=1, size(variations))])) call step_in_space_axes(self, system, status)
      if (status%ok()) call begin_sensitivities(self, variations, system, status)
   end procedure differentiate

   !> Makes the steps use the space axes of the system, as derivatives with respect to the elements of an orbit require.
   !> Errors: those of `begin`.
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

   module procedure follow_chaos
      type(variation_t), allocatable :: variations(:)
      integer :: n
      if (settings%exponents == 0) return
      if (settings%exponents < 0 .or. settings%exponents > most_exponents) then
         status = fail(NUTATE_BAD_ARGUMENT, 'exponents is out of range (expected 1 to 6)', 'exponents')
         return
      end if
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
      if (status%ok()) then
         self%last_tangent = self%tangent
      else
         deallocate (self%summary%chaos)
      end if
   end procedure follow_chaos

   !> Sets events, and those of the limits and samples of a system.
   subroutine expect_events(progress, events, system, status, policy)
      type(progress_t), intent(inout) :: progress
      type(event_list_t), intent(in) :: events
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      !> The policy of the steps, unless the plan has no end yet.
      class(step_policy_t), intent(inout), optional :: policy
      type(event_tracker_t), allocatable :: tracker
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
      allocate (tracker)
      call tracker%begin(events, system, progress%state, status)
      if (.not. status%ok()) return
      call move_alloc(tracker, progress%events)
      if (is_first .and. present(policy)) call policy%expect_events(system, progress, status)
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

   module procedure find_steps
      if (lacks_steps(self)) call search_steps(self, system, status, observer, trial_observer)
   end procedure find_steps

   !> Finds the steps of a run that lacks them. Errors: those of `find_steps`.
   recursive subroutine search_steps(self, system, status, observer, trial_observer)
      class(run_t), intent(inout), target :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      class(observer_t), intent(inout), optional :: observer, trial_observer
      type(progress_t) :: last
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
   end subroutine search_steps

   !> Returns true if trial runs have to find the steps, and have not yet.
   pure logical function lacks_steps(self)
      class(run_t), intent(in) :: self
      associate (goal => self%plan%goal)
         lacks_steps = goal%accuracy > 0.0_wp .and. max(goal%error_rate, goal%local_tolerance) <= 0.0_wp .and. &
                       .not. is_over(self%progress_t)
      end associate
   end function lacks_steps

   module procedure resume
      call point_to_stepper(self)
      call transfer_run(self%progress_t, self%policy, archive)
      self%resumed = .true.
      if (archive%problem() /= '') &
         status = fail(NUTATE_BAD_ARGUMENT, 'the checkpoint data cannot be resumed: '//archive%problem())
   end procedure resume

   module procedure run_to_end
      call check_end(self%plan, status)
      if (.not. allocated(self%policy) .and. status%ok()) status = fail(NUTATE_BAD_ARGUMENT, &
         'the run has no steps (expected begin or set_plan before)', 'run')
      if (status%ok() .and. .not. is_over(self%progress_t)) call check_steppers(self, system, status)
      if (.not. status%ok()) return
      call point_to_stepper(self)
      if (lacks_steps(self) .and. self%first_step == 0 .and. &
          .not. (allocated(self%tangent) .or. present(observer) .or. allocated(self%events) .or. &
                 self%keeps_dense_output)) then
         call go_unseen(self, system, status)
      else
         call self%find_steps(system, status)
         if (status%ok()) call drive(self%progress_t, self%policy, system, status, observer)
      end if
   end procedure run_to_end

   !> Tests whether the steppers of a run were prepared for a system, unless events have given the run a system of its
   !> own. Errors: those of `check_prepared`.
   subroutine check_steppers(self, system, status)
      !> Run with a policy.
      class(run_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(status_t), intent(inout) :: status
      if (allocated(self%events)) return
      select type (control => self%policy)
      class is (error_control_t)
         call check_prepared(control%half, system, status)
      class default
         if (allocated(self%stepper)) call check_prepared(self%stepper, system, status)
      end select
   end subroutine check_steppers

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

   module procedure run_to
      type(run_plan_t) :: plan
      plan = self%plan
      plan%goal = self%goal
      plan%end_time = t
      plan%steps = -1
      call drop_passed_times(self, plan)
      call self%set_plan(system, plan, status)
      if (status%ok()) call self%run_to_end(system, status, observer)
   end procedure run_to

   !> Removes from a plan the times of rows up to the present time, if the run has made steps.
   pure subroutine drop_passed_times(self, plan)
      class(run_t), intent(in) :: self
      !> Plan with its end time.
      type(run_plan_t), intent(inout) :: plan
      real(wp) :: sense
      if (self%summary%steps == 0 .or. .not. allocated(plan%times)) return
      sense = sign(1.0_wp, plan%end_time - self%state%t)
      plan%times = pack(plan%times, sense*(plan%times - self%state%t) > 0.0_wp)
   end subroutine drop_passed_times

   module procedure run_steps
      type(run_plan_t) :: plan
      plan = self%plan
      plan%steps = n
      plan%end_time = self%end_of_steps(n, plan%time_step)
      call drop_passed_times(self, plan)
      call self%set_plan(system, plan, status)
      if (status%ok()) call self%run_to_end(system, status, observer)
   end procedure run_steps

   module procedure end_of_steps
      t = self%state%t + real(n, wp)*time_step
      if (is_on_grid(self, time_step)) t = end_of_step(self%progress_t, self%summary%steps + n)
   end procedure end_of_steps

   module procedure steps_to
      type(run_plan_t) :: plan
      plan = run_plan_t(time_step=time_step, end_time=t)
      if (is_on_grid(self, time_step)) then
         n = count_steps(self%t_first, plan) - (self%plan%steps_before + self%summary%steps)
      else
         n = count_steps(self%state%t, plan)
      end if
      n = max(n, 0_long)
   end procedure steps_to

   module procedure state_at
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
      if (.not. holds_step(self, t)) then
         status = fail(NUTATE_BAD_ARGUMENT, outside, 't')
      else if (allocated(self%policy)) then
         call point_to_stepper(self)
         call self%policy%state_inside(system, self%progress_t, t, state, status, tangent=tangent)
         if (present(tangent) .and. status%ok()) &
            call pass_windows_inside(self%progress_t, system, state, tangent)
      else
         call self%stepper%state_at(system, t, state, work, status)
      end if
   end procedure state_at

   !> Returns true if the last step is kept; of adaptive steps, if it contains a time.
   logical function holds_step(self, t)
      class(run_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t
      holds_step = .false.
      if (allocated(self%stepper)) holds_step = self%stepper%keeps_steps
      if (.not. allocated(self%policy)) return
      select type (control => self%policy)
      type is (error_control_t)
         holds_step = is_evaluable(control, self%state%t, t)
      end select
   end function holds_step

   module procedure release
      if (.not. allocated(self%policy)) return
      select type (control => self%policy)
      type is (error_control_t)
         if (allocated(control%half)) call move_alloc(control%half, self%spare)
      end select
      deallocate (self%policy)
   end procedure release

end submodule nutate_run_procedures
