!> Runs with the projection onto the invariants, for its suites.
module test_conserving_runs
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: default_settings, make_stepper
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t, system_t
   use test_problems, only: march, problem_t
   use test_support, only: check, check_below, error_type
   implicit none
   private

   public :: guard_t, guard_row, get_stepper, go, check_run, check_guard, methods, round_off

   !> Round-off of an invariant, as part of the largest T + |V| or |l|, whatever the number of steps: the projection
   !> does not let it add up.
   real(wp), parameter :: round_off = 1e-14_wp
   character(len=6), parameter :: methods(2) = ['rk4   ', 'dop853']

   !> Keeps the largest departures of the invariants.
   type, extends(observer_t) :: guard_t
      logical :: started = .false., attitude = .true.
      integer :: rows = 0
      type(invariants_t) :: invariants
   contains
      procedure :: begin => begin_guard
      procedure :: observe => guard_row
   end type guard_t

contains

   !> Makes ready for another run.
   subroutine begin_guard(self, attitude)
      class(guard_t), intent(inout) :: self
      logical, intent(in) :: attitude
      self%started = .false.
      self%attitude = attitude
      self%rows = 0
   end subroutine begin_guard

   subroutine guard_row(self, system, state, record, status)
      class(guard_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (.not. self%started) call self%invariants%start(system, state, attitude=self%attitude)
      self%started = .true.
      self%rows = self%rows + 1
      call self%invariants%measure(system, state, record%work)
   end subroutine guard_row

   !> A prepared stepper of a method, with the projection onto the invariants or without.
   subroutine get_stepper(problem, method, conserve, stepper, status)
      type(problem_t), intent(in) :: problem
      character(len=*), intent(in) :: method
      logical, intent(in) :: conserve
      class(stepper_t), allocatable, intent(out) :: stepper
      type(status_t), intent(out) :: status
      type(integrator_settings_t) :: settings
      settings = default_settings(trim(method))
      settings%conserve = conserve
      call make_stepper(problem%system, settings, stepper, status)
   end subroutine get_stepper

   !> The state after n steps with the projection, or without.
   subroutine go(error, problem, method, conserve, dt, n, state)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      character(len=*), intent(in) :: method
      logical, intent(in) :: conserve
      real(wp), intent(in) :: dt
      integer, intent(in) :: n
      type(state_t), intent(out) :: state
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      call get_stepper(problem, method, conserve, stepper, status)
      state = problem%start
      if (status%ok()) call march(problem%system, stepper, state, dt, n, status)
      call check(error, status%ok(), trim(method)//': '//trim(status%message))
   end subroutine go

   !> Runs with the projection and checks that all steps keep the invariants.
   subroutine check_run(error, problem, method, dt, n, every)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      character(len=*), intent(in) :: method
      real(wp), intent(in) :: dt
      integer, intent(in) :: n, every
      class(stepper_t), allocatable :: stepper
      type(state_t) :: state
      type(guard_t) :: guard
      type(run_summary_t) :: summary
      type(status_t) :: status
      call get_stepper(problem, method, .true., stepper, status)
      state = problem%start
      call integrate(problem%system, stepper, state, &
                     run_plan_t(time_step=dt, end_time=state%t + n*dt, every=every), status, guard, summary)
      call check(error, status%ok() .and. summary%subdivided_steps == 0, &
                 trim(method)//' subdivided: '//trim(status%message))
      call check_guard(error, guard)
   end subroutine check_run

   subroutine check_guard(error, guard)
      type(error_type), allocatable, intent(inout) :: error
      type(guard_t), intent(in) :: guard
      call check_below(error, guard%invariants%energy_error(), round_off, "energy")
      call check_below(error, guard%invariants%momentum_error(), round_off, "momentum")
      call check_below(error, guard%invariants%norm_error, 8*eps, "norm")
   end subroutine check_guard

end module test_conserving_runs
