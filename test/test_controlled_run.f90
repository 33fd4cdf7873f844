!> Runs with adaptive steps, for the suites that look at them: a recorder, and the run with its trial runs.
module test_controlled_run
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t, system_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
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

   !> Runs a problem by a plan.
   subroutine run_to(problem, settings, plan, recorder, state, summary, status)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      type(recorder_t), intent(inout) :: recorder
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      state = problem%start
      recorder%rows = 0
      call integrate(problem%system, settings, state, plan, status, recorder, summary)
   end subroutine run_to

end module test_controlled_run
