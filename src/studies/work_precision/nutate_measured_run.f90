!> One integration of a work-precision study: without output, within a budget, measured or as fast as it goes.
module nutate_measured_run
   use nutate_hamiltonian, only: angular_velocity, body_momentum, system_t
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, long
   use nutate_specialised_motion, only: specialised_motion_t
   use nutate_methods, only: integrator_settings_t, methods, stepper_t
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_STEP_LIMIT
   use nutate_stopwatch, only: stopwatch_t
   use nutate_study_budget, only: study_budget_t
   implicit none
   private

   public :: problem_t, run_monitor_t, outcome_t, run_once, run_to_tolerance, settings_of, fastest_rate, &
      specialised_rate

   !> Steps of the trial run for the fastest rotation: most, some 0.1 s of work; least, if the initial state does not
   !> show how fast the body is.
   integer(long), parameter :: most_trial_steps = 20000, least_trial_steps = 64
   !> Rotation in a step of the trial run, rad: the maximum of |Ω| is found to a few per cent, and every method allows
   !> such steps.
   real(wp), parameter :: trial_rotation = 0.5_wp

   !> A problem to be studied: a motion from a state to a time.
   type :: problem_t
      type(system_t) :: system
      type(state_t) :: start
      !> End time, s.
      real(wp) :: end_time = 0.0_wp
      !> Settings of all methods: tolerances, auxiliary inertia, projection.
      type(integrator_settings_t) :: settings
      !> Observer whose `poll` can end every run of the problem; may be absent.
      class(observer_t), allocatable :: observer
   contains
      !> Returns the time from start to end, s; negative if time runs backwards.
      procedure :: duration
   end type problem_t

   !> Outcome of a run.
   type :: outcome_t
      !> The last state.
      type(state_t) :: state
      type(run_summary_t) :: summary
      !> Wall time, s.
      real(wp) :: seconds = 0.0_wp
   end type outcome_t

   !> Observer that ends a run at the end of the budget, and measures the invariants if it receives output points.
   type, extends(observer_t) :: run_monitor_t
      type(invariants_t) :: invariants
      !> Largest |Ω| so far, rad/s.
      real(wp) :: fastest = 0.0_wp
      !> True if the invariants are measured.
      logical :: measures = .false.
      !> Budget of the study; runs are added to what is spent.
      type(study_budget_t) :: budget
      !> Evaluations in a step of the method.
      integer :: stages = 1
      class(observer_t), allocatable :: observer
   contains
      procedure :: observe => measure_row
      procedure :: poll => watch_budget
   end type run_monitor_t

contains

   !> Returns the time from start to end, s; negative if time runs backwards.
   pure real(wp) function duration(self)
      class(problem_t), intent(in) :: self
      duration = self%end_time - self%start%t
   end function duration

   !> Returns a problem's settings for a row of the table of methods, with the attitude, whose errors are measured.
   pure function settings_of(base, method) result(settings)
      type(integrator_settings_t), intent(in) :: base
      !> Row of `methods`.
      integer, intent(in) :: method
      type(integrator_settings_t) :: settings
      settings = base
      settings%method = methods(method)%name
      settings%formulation = methods(method)%formulation
      settings%order = methods(method)%order
      settings%conserve = methods(method)%projected
      settings%attitude = .true.
   end function settings_of

   !> Runs a problem once from its start. With `monitor%measures` every step is an output point; otherwise only the ends
   !> are.
   !>
   !> Errors: those of `integrate`; `NUTATE_STEP_LIMIT` if the budget is used up; the status that the observer's `poll`
   !> returned.
   subroutine run_once(problem, stepper, time_step, monitor, outcome, status)
      type(problem_t), intent(in) :: problem
      !> Prepared stepper.
      class(stepper_t), intent(inout) :: stepper
      !> Time step, s.
      real(wp), intent(in) :: time_step
      type(run_monitor_t), intent(inout) :: monitor
      type(outcome_t), intent(out) :: outcome
      type(status_t), intent(out) :: status
      type(run_plan_t) :: plan
      type(stopwatch_t) :: clock

      plan = plan_of(problem, monitor)
      plan%time_step = time_step
      outcome%state = problem%start
      call copy_observer(monitor, problem)
      call clock%start()
      call integrate(problem%system, stepper, outcome%state, plan, status, monitor, outcome%summary)
      outcome%seconds = clock%seconds()
      call count_run(monitor, plan, outcome%summary, status)
   end subroutine run_once

   !> Runs a problem once from its start, with steps chosen for an error of each. Preparing the method is part of the
   !> time.
   subroutine run_to_tolerance(problem, settings, tolerance, monitor, outcome, status)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      !> Error of each step, rad.
      real(wp), intent(in) :: tolerance
      type(run_monitor_t), intent(inout) :: monitor
      type(outcome_t), intent(out) :: outcome
      type(status_t), intent(out) :: status
      type(run_plan_t) :: plan
      type(stopwatch_t) :: clock

      plan = plan_of(problem, monitor)
      plan%goal%local_tolerance = tolerance
      outcome%state = problem%start
      call copy_observer(monitor, problem)
      call clock%start()
      call integrate(problem%system, settings, outcome%state, plan, status, monitor, outcome%summary)
      outcome%seconds = clock%seconds()
      call count_run(monitor, plan, outcome%summary, status)
   end subroutine run_to_tolerance

   !> Adds a run to the budget: its steps, or the allowed number if it needed more.
   subroutine count_run(monitor, plan, summary, status)
      type(run_monitor_t), intent(inout) :: monitor
      type(run_plan_t), intent(in) :: plan
      type(run_summary_t), intent(in) :: summary
      !> Status of the run.
      type(status_t), intent(in) :: status
      integer(long) :: steps
      steps = summary%parts
      if (status%code == NUTATE_STEP_LIMIT .and. plan%max_steps < huge(1_long)) steps = max(steps, plan%max_steps)
      call monitor%budget%count_run(steps, monitor%stages)
   end subroutine count_run

   !> Returns the plan to run to the end of a problem, with an output point for every step if the monitor measures.
   type(run_plan_t) function plan_of(problem, monitor) result(plan)
      type(problem_t), intent(in) :: problem
      type(run_monitor_t), intent(in) :: monitor
      plan%end_time = problem%end_time
      plan%every = huge(1_long)
      if (monitor%measures) plan%every = 1
      plan%max_steps = monitor%budget%most_steps(monitor%stages)
   end function plan_of

   !> Finds the largest |Ω| of a motion, rad/s, from a run of a highest-order method that ends early if the motion, or
   !> its steps, are long.
   subroutine fastest_rate(problem, method, rate, status, budget)
      type(problem_t), intent(in) :: problem
      !> Row of `methods`.
      integer, intent(in) :: method
      real(wp), intent(out) :: rate
      type(status_t), intent(out) :: status
      !> Budget that ends the run when it is used up, and to which the run is added.
      type(study_budget_t), intent(inout), optional :: budget
      type(run_plan_t) :: plan
      type(run_monitor_t) :: monitor
      type(run_summary_t) :: summary
      type(state_t) :: state

      rate = norm2(angular_velocity(problem%system, problem%start))
      monitor%measures = .true.
      monitor%stages = methods(method)%stages
      if (present(budget)) monitor%budget = budget
      plan = plan_of(problem, monitor)
      plan%time_step = problem%duration()/real(least_trial_steps, wp)
      if (abs(plan%time_step)*rate > trial_rotation) plan%time_step = sign(trial_rotation/rate, plan%time_step)
      plan%max_steps = min(plan%max_steps, most_trial_steps)
      state = problem%start
      call copy_observer(monitor, problem)
      call monitor%invariants%start(problem%system, state)
      call integrate(problem%system, settings_of(integrator_settings_t(), method), state, plan, status, monitor, &
                     summary)
      call count_run(monitor, plan, summary, status)
      if (present(budget)) budget%evaluations = monitor%budget%evaluations
      if (status%code == NUTATE_STEP_LIMIT) status = status_t()
      rate = max(rate, monitor%fastest)
   end subroutine fastest_rate

   !> Returns the approximate rate of a motion in the special variables of free bodies and tops, rad/s; for a symmetric
   !> top the rate of the slow motion, without the spin. The rate is larger than any other if there are no such
   !> variables, and in rotating axes.
   pure real(wp) function specialised_rate(problem) result(rate)
      type(problem_t), intent(in) :: problem
      type(specialised_motion_t) :: motion
      rate = huge(1.0_wp)
      call motion%prepare(problem%system, .true.)
      if (motion%possible .and. .not. problem%system%effects%frame_turns) &
         rate = motion%pace(body_momentum(problem%start))
   end function specialised_rate

   subroutine copy_observer(monitor, problem)
      type(run_monitor_t), intent(inout) :: monitor
      type(problem_t), intent(in) :: problem
      if (allocated(problem%observer) .and. .not. allocated(monitor%observer)) &
         allocate (monitor%observer, source=problem%observer)
   end subroutine copy_observer

   !> Measures the invariants and the rate of rotation.
   subroutine measure_row(self, system, state, record, status)
      class(run_monitor_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (.not. self%measures) return
      call self%invariants%measure(system, state, record%work)
      self%fastest = max(self%fastest, norm2(angular_velocity(system, state)))
   end subroutine measure_row

   !> Ends a run at the end of the time budget, or if the observer ends it.
   subroutine watch_budget(self, fraction, status)
      class(run_monitor_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      if (allocated(self%observer)) call self%observer%poll(fraction, status)
      if (.not. status%ok()) return
      if (self%budget%time_is_over()) status = fail(NUTATE_STEP_LIMIT, 'the time budget is used up')
   end subroutine watch_budget

end module nutate_measured_run
