!> Runs with steps chosen by their error, for the suites that look at them: a recorder, and the run with its pilots.
module test_controlled_run
   use nutate_accuracy, only: find_error_rate
   use nutate_step_control, only: control_settings_t, integrate_controlled
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp
   use nutate_run, only: observer_t, run_plan_t, run_record_t, run_summary_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t
   use nutate_system, only: system_t
   use test_problems, only: problem_t
   implicit none
   private

   public :: recorder_t, run_to

   !> Keeps the states shown, and the largest departure of the invariants.
   type, extends(observer_t) :: recorder_t
      integer :: rows = 0
      type(state_t) :: states(200)
      real(wp) :: work(200) = 0.0_wp
      type(invariants_t) :: invariants
   contains
      procedure :: observe => record_row
   end type recorder_t

contains

   subroutine record_row(self, system, state, record, status)
      class(recorder_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (self%rows == 0) call self%invariants%start(system, state)
      call self%invariants%measure(system, state, record%work)
      self%rows = min(self%rows + 1, size(self%states))
      self%states(self%rows) = state
      self%work(self%rows) = record%work
   end subroutine record_row

   !> Runs a problem to an end time, with pilots where an accuracy is asked for.
   subroutine run_to(problem, settings, end_time, goal, recorder, state, summary, status)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      real(wp), intent(in) :: end_time
      type(control_settings_t), intent(inout) :: goal
      type(recorder_t), intent(inout) :: recorder
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      type(run_plan_t) :: plan
      plan%end_time = end_time
      state = problem%start
      recorder%rows = 0
      if (goal%accuracy > 0.0_wp) call find_error_rate(problem%system, settings, state, plan, goal, status)
      if (.not. status%ok()) return
      call integrate_controlled(problem%system, settings, goal, state, plan, recorder, summary, status)
   end subroutine run_to

end module test_controlled_run
