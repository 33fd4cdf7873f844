!> Adaptive steps: the accuracy asked for is the error that comes out, and nothing else suffers.
submodule(suites_of_runs) test_control
   use nutate_applied_torque, only: applied_torque_t
   use nutate_damping, only: damping_t
   use nutate_exact_free, only: free_body_t
   use nutate_kinds, only: wp, eps, long
   use nutate_methods, only: default_settings
   use nutate_quaternion, only: attitude_distance
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_spring, only: spring_t
   use nutate_run, only: integrate, observer_t, run_summary_t, run_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_STEP_LIMIT, NUTATE_STOPPED, fail, status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_controlled_run, only: recorder_t, run_to
   use test_problems, only: body_momentum, box, bruls_top, free_body, precessing_top, problem_t, simo_top
   use test_random_scenes, only: make_random_scene, random_scene_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> Stops a run at its third poll.
   type, extends(observer_t) :: stopper_t
      integer :: polls = 0
   contains
      procedure :: poll => stop_at_poll
   end type stopper_t

contains

   module procedure collect_control
      testsuite = [ &
                  new_unittest("accuracy is met on the top of Brüls", accuracy_on_the_top_of_bruls), &
                  new_unittest("accuracy is met on the top of Simo", accuracy_on_the_top_of_simo), &
                  new_unittest("accuracy is met on the precessing top", accuracy_on_the_precessing_top), &
                  new_unittest("accuracy is met on a free body", accuracy_on_a_free_body), &
                  new_unittest("accuracy is met on the unstable box", accuracy_on_the_box), &
                  new_unittest("accuracy is met with all kinds of effects", accuracy_with_effects), &
                  new_unittest("accuracy out of reach is reported to be", accuracy_out_of_reach), &
                  new_unittest("rows at intervals are as accurate as the steps", rows_at_intervals), &
                  new_unittest("rows do not disturb the steps", rows_do_not_disturb), &
                  new_unittest("local tolerance bounds the error of each step", local_tolerance_bounds_steps), &
                  new_unittest("steps end where torques do", steps_end_where_torques_do), &
                  new_unittest("goes backwards in time", goes_backwards), &
                  new_unittest("a goal without tolerance is refused, a limit ends the run", bad_goals_and_limits), &
                  new_unittest("plans that nothing can follow are refused", impossible_plans), &
                  new_unittest("a run of no length has its state as its only row", runs_of_no_length), &
                  new_unittest("a search that needs too many steps says so", search_has_a_limit), &
                  new_unittest("a finer run that fails is not the end of a search", failing_finer_runs), &
                  new_unittest("trial runs can be stopped, and begun again", trial_runs_can_be_stopped), &
                  new_unittest("a run is the same without observer and in parts", runs_in_parts)]
   end procedure collect_control

   pure type(integrator_settings_t) function of_order(order)
      integer, intent(in) :: order
      of_order%order = order
      of_order%formulation = 'reduced'
   end function of_order

   subroutine accuracy_on_the_top_of_bruls(error)
      type(error_type), allocatable, intent(out) :: error
      call check_accuracy(error, bruls_top(), 2.0_wp, [0.122947135041533467_wp, -0.491079892550027015_wp, &
                                                       0.350430030343620962_wp, -0.787986887550485669_wp])
   end subroutine accuracy_on_the_top_of_bruls

   subroutine accuracy_on_the_top_of_simo(error)
      type(error_type), allocatable, intent(out) :: error
      call check_accuracy(error, simo_top(), 10.0_wp, [0.2438016485933435_wp, 0.0195997964216783492_wp, &
                                                       -0.0187249229592649203_wp, -0.96944622408030772_wp])
   end subroutine accuracy_on_the_top_of_simo

   subroutine accuracy_on_the_precessing_top(error)
      type(error_type), allocatable, intent(out) :: error
      call check_accuracy(error, precessing_top(), 1.0_wp, [-0.74129324557326555_wp, 0.49974636690044272_wp, &
                                                            0.015923842809073599_wp, -0.44775475884400627_wp])
   end subroutine accuracy_on_the_precessing_top

   subroutine accuracy_on_a_free_body(error)
      type(error_type), allocatable, intent(out) :: error
      call check_accuracy(error, free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp]), 10.0_wp, &
                          [-0.736061364160793936_wp, -0.570786951240350733_wp, -0.299388571830790094_wp, &
                           -0.206839086104673192_wp])
   end subroutine accuracy_on_a_free_body

   !> Checks the accuracy of the box, whose instability amplifies local errors, round-off included.
   subroutine accuracy_on_the_box(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(free_body_t) :: solution
      type(status_t) :: status
      real(wp) :: q(4), momentum(3)
      problem => box()
      call solution%prepare(problem%system%body%moments, problem%start%q, body_momentum(problem%start), status)
      call solution%evaluate(5.0_wp, q, momentum)
      call check_accuracy(error, problem, 5.0_wp, q, finest=1e-10_wp)
   end subroutine accuracy_on_the_box

   !> Compares with order 8 at steps for 1e-13.
   subroutine accuracy_with_effects(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: reference
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(run_goal_t) :: goal
      type(status_t) :: status
      problem => bruls_top()
      call problem%system%effects%add(damping_t([0.3_wp, 0.1_wp, 0.2_wp]))
      call problem%system%effects%add(spring_t([0.0_wp, 1.0_wp, 0.0_wp], [1.0_wp, 1.0_wp, 1.0_wp], 40.0_wp, 0.5_wp))
      call problem%system%effects%add(applied_torque_t(name='torque', amplitude=[3.0_wp, 1.0_wp, -2.0_wp], &
                                                       in_space=.true., frequency=2.0_wp))
      goal%accuracy = 1e-13_wp
      call run(problem, 8, 0.5_wp, goal, recorder, reference, summary, status)
      call check_accuracy(error, problem, 0.5_wp, reference%q, finest=1e-11_wp)
   end subroutine accuracy_with_effects

   !> Runs a problem, with trial runs where an accuracy is asked for.
   subroutine run(problem, order, end_time, goal, recorder, state, summary, status, interval)
      type(problem_t), intent(in) :: problem
      integer, intent(in) :: order
      real(wp), intent(in) :: end_time
      type(run_goal_t), intent(in) :: goal
      type(recorder_t), intent(inout) :: recorder
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      !> Between rows, s.
      real(wp), intent(in), optional :: interval
      type(run_plan_t) :: plan
      plan = run_plan_t(end_time=end_time, goal=goal)
      if (present(interval)) plan%interval = interval
      call run_to(problem, of_order(order), plan, recorder, state, summary, status)
   end subroutine run

   !> The error that comes out is at most twice the accuracy asked for (docs/results/accuracy-costs.md), or what the
   !> summary says, which is below the accuracy or else names round-off; the invariants hold.
   subroutine check_accuracy(error, problem, end_time, exact, finest)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: end_time, exact(4)
      !> Least accuracy to try, rad; default 1e-12.
      real(wp), intent(in), optional :: finest
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: accuracy, least, found
      integer :: order, exponent
      character(len=40) :: label
      least = 1e-12_wp
      if (present(finest)) least = finest
      do order = 4, 8, 2
         do exponent = 4, 2*order - 4, 2
            accuracy = 10.0_wp**(-exponent)
            if (accuracy < 0.5_wp*least) exit
            write (label, '("order ",i0,", accuracy ",es7.1)') order, accuracy
            goal = run_goal_t(accuracy=accuracy)
            recorder%rows = 0
            call run(problem, order, end_time, goal, recorder, state, summary, status)
            call check(error, status%ok(), trim(label)//": "//trim(status%message))
            found = attitude_distance(state%q, exact)
            call check_below(error, found, 2*max(accuracy, summary%estimate), trim(label)//": error")
            call check(error, summary%estimate <= accuracy .or. summary%round_off > accuracy, &
                       trim(label)//": neither met nor out of reach")
            call check_below(error, max(recorder%invariants%energy_error(), recorder%invariants%momentum_error()), &
                             1e-12_wp, trim(label)//": invariants")
         end do
      end do
   end subroutine check_accuracy

   subroutine accuracy_out_of_reach(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      goal%accuracy = 1e-15_wp
      call run(bruls_top(), 8, 0.5_wp, goal, recorder, state, summary, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, summary%estimate > goal%accuracy, "an accuracy below round-off is reported to be reached")
   end subroutine accuracy_out_of_reach

   !> Rows between the steps: unit quaternions, at the times asked for, within the accuracy of the exact solution.
   subroutine rows_at_intervals(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(free_body_t) :: solution
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: q(4), momentum(3)
      integer :: i
      problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp])
      call solution%prepare(problem%system%body%moments, problem%start%q, body_momentum(problem%start), status)
      goal = run_goal_t(accuracy=1e-9_wp)
      call run(problem, 6, 10.0_wp, goal, recorder, state, summary, status, interval=0.07_wp)
      call check(error, recorder%rows, 144)
      do i = 1, recorder%rows
         associate (row => recorder%states(i))
            call check_close(error, row%t, min(10.0_wp, (i - 1)*0.07_wp), 2*eps*10, "time")
            call check_close(error, dot_product(row%q, row%q), 1.0_wp, 16*eps, "unit norm")
            call solution%evaluate(row%t, q, momentum)
            call check_below(error, attitude_distance(row%q, q), 1e-9_wp, "error of a row")
         end associate
      end do
   end subroutine rows_at_intervals

   subroutine rows_do_not_disturb(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_goal_t) :: goal
      type(recorder_t) :: rare, dense
      type(run_summary_t) :: a, b
      type(state_t) :: few, many
      type(status_t) :: status
      goal%local_tolerance = 1e-8_wp
      call run(bruls_top(), 6, 0.5_wp, goal, rare, few, a, status)
      call run(bruls_top(), 6, 0.5_wp, goal, dense, many, b, status, interval=0.003_wp)
      call check(error, a%steps == b%steps .and. dense%rows == 168, "other steps, or other rows")
      call check_close(error, [many%q, many%p], [few%q, few%p], 0.0_wp, "last state")
   end subroutine rows_do_not_disturb

   !> Compares each step of a free body with its exact solution from the start of that step.
   subroutine local_tolerance_bounds_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(free_body_t) :: solution
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: q(4), momentum(3), worst
      integer :: i
      problem => box()
      goal%local_tolerance = 1e-7_wp
      call run(problem, 4, 1.5_wp, goal, recorder, state, summary, status)
      worst = 0.0_wp
      do i = 2, recorder%rows
         associate (before => recorder%states(i - 1), after => recorder%states(i))
            call solution%prepare(problem%system%body%moments, before%q, body_momentum(before), status)
            call solution%evaluate(after%t - before%t, q, momentum)
            worst = max(worst, attitude_distance(after%q, q))
         end associate
      end do
      call check_below(error, worst, 2e-7_wp, "largest error")
      call check_below(error, 1e-8_wp, worst, "steps far shorter than need be")
   end subroutine local_tolerance_bounds_steps

   !> A torque from 0.3 to 0.7 s on a body at rest: its momentum is the torque times 0.4 s to round-off.
   subroutine steps_end_where_torques_do(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call problem%system%effects%add(applied_torque_t(name='torque', amplitude=[0.0_wp, 0.0_wp, 2.0_wp], &
                                                       start=0.3_wp, stop=0.7_wp))
      goal%local_tolerance = 1e-8_wp
      call run(problem, 8, 1.0_wp, goal, recorder, state, summary, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, body_momentum(state), [0.0_wp, 0.0_wp, 0.8_wp], 16*eps, "momentum")
      call check_close(error, recorder%work(recorder%rows), 0.32_wp, 16*eps, "work")
   end subroutine steps_end_where_torques_do

   subroutine goes_backwards(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      problem => bruls_top()
      goal%accuracy = 1e-10_wp
      call run(problem, 8, -0.3_wp, goal, recorder, state, summary, status)
      problem%start = state
      goal = run_goal_t(accuracy=1e-10_wp)
      call run(problem, 8, 0.0_wp, goal, recorder, state, summary, status)
      problem => bruls_top()
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check_close(error, [state%t, state%q], [0.0_wp, problem%start%q], 2e-10_wp, "start")
   end subroutine goes_backwards

   subroutine bad_goals_and_limits(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_goal_t) :: goal
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      problem => bruls_top()
      state = problem%start
      call integrate(problem%system, of_order(4), state, run_plan_t(end_time=1.0_wp), status, recorder)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      goal%local_tolerance = 1e-10_wp
      call integrate(problem%system, of_order(4), state, run_plan_t(end_time=1.0_wp, max_steps=5_long, goal=goal), &
                     status, recorder, summary)
      call check(error, status%code == NUTATE_STEP_LIMIT .and. summary%steps == 5, "limit")
   end subroutine bad_goals_and_limits

   subroutine impossible_plans(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t), parameter :: plans(3) = [ &
                                     run_plan_t(time_step=0.01_wp, end_time=1.0_wp, interval=0.05_wp), &
                                     run_plan_t(time_step=0.01_wp, end_time=1.0_wp, every=0), &
                                     run_plan_t(end_time=1.0_wp, every=0, goal=run_goal_t(local_tolerance=1e-6_wp))]
      type(problem_t), pointer :: problem
      type(recorder_t) :: recorder
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      problem => bruls_top()
      do i = 1, size(plans)
         state = problem%start
         call integrate(problem%system, of_order(4), state, plans(i), status, recorder)
         call check(error, status%code == NUTATE_BAD_ARGUMENT .and. state%t <= 0.05_wp, "taken")
      end do
   end subroutine impossible_plans

   !> Also where trial runs would have nothing to measure.
   subroutine runs_of_no_length(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_goal_t), parameter :: goals(3) = [run_goal_t(), run_goal_t(local_tolerance=1e-6_wp), &
                                                 run_goal_t(accuracy=1e-6_wp)]
      type(problem_t), pointer :: problem
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      problem => bruls_top()
      do i = 1, size(goals)
         state = problem%start
         recorder%rows = 0
         call integrate(problem%system, of_order(4), state, run_plan_t(time_step=0.01_wp, end_time=0.0_wp, &
                                                                       goal=goals(i)), status, recorder, summary)
         call check(error, status%ok() .and. recorder%rows == 1 .and. summary%steps == 0, trim(status%message))
      end do
   end subroutine runs_of_no_length

   subroutine trial_runs_can_be_stopped(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(run_t), allocatable :: run_1
      type(stopper_t) :: stopper
      type(state_t) :: state
      type(status_t) :: status
      type(run_plan_t) :: plan
      allocate (run_1)
      problem => bruls_top()
      plan = run_plan_t(end_time=0.5_wp, goal=run_goal_t(accuracy=1e-8_wp))
      call run_1%begin(problem%system, of_order(4), problem%start, plan, status)
      call run_1%find_steps(problem%system, status, stopper)
      call check(error, status%code == NUTATE_STOPPED .and. stopper%polls == 3, "not stopped")
      call run_1%run_to_end(problem%system, status)
      state = problem%start
      if (status%ok()) call integrate(problem%system, of_order(4), state, plan, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, [run_1%state%q, run_1%state%p], [state%q, state%p], 0.0_wp, "last state")
   end subroutine trial_runs_can_be_stopped

   subroutine runs_in_parts(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(run_t), allocatable :: run_1
      type(recorder_t) :: recorder
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      type(run_plan_t) :: plan
      allocate (run_1)
      problem => bruls_top()
      state = problem%start
      plan = run_plan_t(end_time=0.5_wp, interval=0.03_wp, goal=run_goal_t(accuracy=1e-8_wp))
      call integrate(problem%system, of_order(6), state, plan, status, recorder, summary)
      call run_1%begin(problem%system, of_order(6), problem%start, plan, status)
      if (status%ok()) call run_1%find_steps(problem%system, status)
      call check(error, status%ok() .and. recorder%rows == 18 .and. run_1%summary%estimate > 0.0_wp)
      if (allocated(error)) return
      if (status%ok()) call run_1%run_to_end(problem%system, status)
      call check_close(error, [run_1%state%q, run_1%state%p], [state%q, state%p], 0.0_wp, "last state")
      call check_close(error, [run_1%summary%estimate, real(run_1%summary%steps, wp)], &
                       [summary%estimate, real(summary%steps, wp)], 0.0_wp, "summary")
   end subroutine runs_in_parts

   subroutine search_has_a_limit(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      problem => bruls_top()
      state = problem%start
      call integrate(problem%system, default_settings('rk4'), state, &
                     run_plan_t(end_time=1.0_wp, max_steps=200_long, goal=run_goal_t(accuracy=1e-9_wp)), status)
      call check(error, status%code, NUTATE_STEP_LIMIT)
      call check(error, trim(status%message), 'the accuracy needs more than 200 steps of this method')
   end subroutine search_has_a_limit

   !> Steps of order 4 with an error far below round-off cannot be found: the answer is what larger ones give. (How good
   !> that is hangs on the last bits: the motion is chaotic.)
   subroutine failing_finer_runs(error)
      type(error_type), allocatable, intent(out) :: error
      type(random_scene_t) :: scene
      type(integrator_settings_t) :: settings
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(status_t) :: status
      type(run_plan_t) :: plan
      call make_random_scene(617, scene)
      state = scene%problem%start
      plan%end_time = scene%end_time
      plan%goal%accuracy = 4.6e-6_wp
      settings = default_settings('rk4')
      settings%conserve = .true.
      call integrate(scene%problem%system, settings, state, plan, status, summary=summary)
      call check(error, status%ok(), 'the run: '//trim(status%message))
      call check(error, summary%estimate > 0.0_wp, 'an estimate')
   end subroutine failing_finer_runs

   subroutine stop_at_poll(self, fraction, status)
      class(stopper_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      self%polls = self%polls + 1
      if (self%polls == 3) status = fail(NUTATE_STOPPED, 'asked to')
   end subroutine stop_at_poll

end submodule test_control
