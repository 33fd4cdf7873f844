!> Runs: they end where they should, show the rows asked for, subdivide steps that are too long, and stop with a reason.
submodule(suites_of_runs) test_run
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, eps, long
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t, system_t
   use nutate_run_plan, only: count_steps, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_IO, NUTATE_STEP_LIMIT, fail, status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: box, precessing_top, problem_t, solve
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> Keeps the times shown, and the largest departure of the invariants.
   type, extends(observer_t) :: recorder_t
      integer :: rows = 0
      real(wp) :: times(2000) = 0.0_wp
      type(invariants_t) :: invariants
      !> The row at which to fail; 0: never.
      integer :: fails_at = 0
   contains
      procedure :: observe => record_row
   end type recorder_t

contains

   module procedure collect_run
      testsuite = [ &
                  new_unittest("steps are counted to the end", steps_are_counted), &
                  new_unittest("times are multiples of the step", times_are_multiples_of_the_step), &
                  new_unittest("the last step ends at the end time", last_step_ends_at_the_end), &
                  new_unittest("rows come every so many steps", rows_come_every_so_many_steps), &
                  new_unittest("a run goes backwards in time", run_goes_backwards), &
                  new_unittest("a run is the steps it is made of", run_is_its_steps), &
                  new_unittest("steps keep their length late in time", steps_keep_their_length), &
                  new_unittest("a run goes on where one ended", run_goes_on), &
                  new_unittest("steps too long are subdivided, invariants hold", long_steps_are_subdivided), &
                  new_unittest("a step limit ends the run", step_limit_ends_the_run), &
                  new_unittest("an observer can end the run", observer_can_end_the_run), &
                  new_unittest("a step away from the end is refused", wrong_direction_is_refused)]
   end procedure collect_run

   subroutine record_row(self, system, state, record, status)
      class(recorder_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      self%rows = self%rows + 1
      self%times(self%rows) = state%t
      if (record%step == 0) call self%invariants%start(system, state)
      call self%invariants%measure(system, state, record%work)
      if (self%rows == self%fails_at) status = fail(NUTATE_IO, 'the disk is full')
   end subroutine record_row

   !> Runs a problem by the 8×8 method.
   subroutine run(problem, plan, recorder, state, summary, status)
      type(problem_t), intent(in) :: problem
      type(run_plan_t), intent(in) :: plan
      type(recorder_t), intent(inout) :: recorder
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      state = problem%start
      call integrate(problem%system, integrator_settings_t(), state, plan, status, recorder, summary)
   end subroutine run

   subroutine steps_are_counted(error)
      type(error_type), allocatable, intent(out) :: error
      call expect(0.1_wp, 1.0_wp, 10_long)
      call expect(0.1_wp, 1.0_wp + 0.9e-10_wp, 10_long)
      call expect(0.1_wp, 1.0_wp - 0.9e-10_wp, 10_long)
      call expect(0.1_wp, 1.0_wp + 1e-9_wp, 11_long)
      call expect(0.3_wp, 1.0_wp, 4_long)
      call expect(-0.3_wp, -1.0_wp, 4_long)
      call expect(1e-9_wp, 1e3_wp, 1000000000000_long)
      call expect(1e-300_wp, 1.0_wp, huge(1_long))

   contains

      subroutine expect(step, end, n)
         real(wp), intent(in) :: step, end
         integer(long), intent(in) :: n
         character(len=80) :: text
         write (text, '("step ",g0," to ",g0)') step, end
         call check(error, count_steps(0.0_wp, run_plan_t(time_step=step, end_time=end)) == n, trim(text))
      end subroutine expect

   end subroutine steps_are_counted

   subroutine times_are_multiples_of_the_step(error)
      type(error_type), allocatable, intent(out) :: error
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      integer :: k
      call run(box(), run_plan_t(time_step=0.01_wp, end_time=10.0_wp), recorder, state, summary, status)
      call check_close(error, recorder%times(1:1001), [(k*0.01_wp, k=0, 1000)], 0.0_wp, "t")
      call check(error, summary%steps == 1000 .and. summary%parts == 1000 .and. summary%subdivided_steps == 0, "steps")
   end subroutine times_are_multiples_of_the_step

   subroutine last_step_ends_at_the_end(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state, expected
      type(status_t) :: status
      problem => box()
      call run(problem, run_plan_t(time_step=0.02_wp, end_time=0.05_wp), recorder, state, summary, status)
      call check_close(error, recorder%times(1:4), [0.0_wp, 0.02_wp, 0.04_wp, 0.05_wp], 0.0_wp, "t")
      ! Two whole steps and one of half the length.
      call solve(problem, 0.02_wp, 2, expected, status)
      problem%start = expected
      call solve(problem, 0.05_wp - 0.04_wp, 1, expected, status)
      call check_close(error, state%q, expected%q, 16*eps, "q")
   end subroutine last_step_ends_at_the_end

   subroutine rows_come_every_so_many_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      call run(box(), run_plan_t(time_step=0.01_wp, end_time=0.1_wp, every=4_long), recorder, state, summary, status)
      call check(error, recorder%rows == 4, "number of rows")
      call check_close(error, recorder%times(1:4), [0.0_wp, 0.04_wp, 0.08_wp, 0.1_wp], 0.0_wp, "t")
   end subroutine rows_come_every_so_many_steps

   subroutine run_goes_backwards(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      problem => precessing_top()
      call run(problem, run_plan_t(time_step=-0.001_wp, end_time=-0.5_wp), recorder, state, summary, status)
      call check(error, status%ok(), trim(status%message))
      problem%start = state
      call run(problem, run_plan_t(time_step=0.001_wp, end_time=0.0_wp), recorder, state, summary, status)
      problem => precessing_top()
      call check_close(error, [state%t, state%q], [0.0_wp, problem%start%q], 1e-12_wp, "back at the start")
   end subroutine run_goes_backwards

   subroutine run_is_its_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state, expected
      type(status_t) :: status
      problem => precessing_top()
      call run(problem, run_plan_t(time_step=0.001_wp, end_time=0.2_wp), recorder, state, summary, status)
      call solve(problem, 0.001_wp, 200, expected, status)
      call check_close(error, [state%q, state%p], [expected%q, expected%p], 0.0_wp, "q, p")
      call check(error, summary%iterations >= 400 .and. summary%most_iterations <= 20, "iterations")
   end subroutine run_is_its_steps

   !> Δt|Ω| = 5 from the box's unstable axis: more than one piece can follow in many steps.
   subroutine long_steps_are_subdivided(error)
      type(error_type), allocatable, intent(out) :: error
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      call run(box(), run_plan_t(time_step=0.5_wp, end_time=50.0_wp), recorder, state, summary, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, summary%subdivided_steps > 0 .and. summary%parts > summary%steps .and. &
                 summary%steps == 100, "subdivided")
      call check(error, recorder%rows, 101)
      call check_below(error, recorder%invariants%energy_error(), 1e-13_wp, "energy")
      call check_below(error, recorder%invariants%momentum_error(), 1e-13_wp, "momentum")
   end subroutine long_steps_are_subdivided

   !> Checks steps whose ends are uncertain by more than a billionth of their length.
   subroutine steps_keep_their_length(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: start(2) = [0.0_wp, 1e7_wp]
      type(problem_t), pointer :: problem
      type(recorder_t) :: recorder
      type(state_t) :: state(2)
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: i
      problem => box()
      do i = 1, 2
         problem%start%t = start(i)
         recorder%rows = 0
         call run(problem, run_plan_t(time_step=0.01_wp, end_time=start(i) + 3.17_wp), recorder, state(i), summary, &
                  status)
         call check(error, int(summary%steps), 317)
      end do
      call check_close(error, [state(2)%q, state(2)%p], [state(1)%q, state(1)%p], 0.0_wp)
   end subroutine steps_keep_their_length

   !> Two runs show the times of one, to the last digit.
   subroutine run_goes_on(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(recorder_t) :: whole, first, second
      type(state_t) :: state(3)
      type(run_summary_t) :: summary
      type(status_t) :: status
      problem => box()
      problem%start%t = 0.3_wp
      call run(problem, run_plan_t(time_step=0.1_wp, end_time=0.3_wp + 57*0.1_wp), whole, state(1), summary, status)
      call run(problem, run_plan_t(time_step=0.1_wp, end_time=0.3_wp + 20*0.1_wp, steps=20), first, state(2), summary, &
               status)
      problem%start = state(2)
      call run(problem, run_plan_t(time_step=0.1_wp, end_time=0.3_wp + 57*0.1_wp, steps=37, steps_before=20, &
                                   first_time=0.3_wp), second, state(3), summary, status)
      call check(error, first%rows == 21 .and. second%rows == 38)
      call check_close(error, [first%times(:20), second%times(:38)], whole%times(:58), 0.0_wp)
      call check_close(error, state(3)%q, state(1)%q, 1e4_wp*eps)
   end subroutine run_goes_on

   subroutine step_limit_ends_the_run(error)
      type(error_type), allocatable, intent(out) :: error
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      call run(box(), run_plan_t(time_step=0.01_wp, end_time=1.0_wp, max_steps=7_long), recorder, state, summary, &
               status)
      call check(error, status%code, NUTATE_STEP_LIMIT)
      call check_close(error, [recorder%times(recorder%rows), state%t], [0.07_wp, 0.07_wp], eps, "last row")
   end subroutine step_limit_ends_the_run

   subroutine observer_can_end_the_run(error)
      type(error_type), allocatable, intent(out) :: error
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      recorder%fails_at = 3
      call run(box(), run_plan_t(time_step=0.01_wp, end_time=1.0_wp), recorder, state, summary, status)
      call check(error, status%code == NUTATE_IO .and. recorder%rows == 3, "went on, or lost the reason")
   end subroutine observer_can_end_the_run

   subroutine wrong_direction_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      call run(box(), run_plan_t(time_step=-0.01_wp, end_time=1.0_wp), recorder, state, summary, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
   end subroutine wrong_direction_is_refused

end submodule test_run
