!> The automatic choice of the method: each of its rules, and the accuracy that comes of it.
submodule(suites_of_runs) test_choice
   use nutate_method_choice, only: choose_method, AUTOMATIC_METHOD
   use nutate_applied_torque, only: applied_torque_t
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_effect, only: potential_t
   use nutate_exact_free, only: free_body_t
   use nutate_kinds, only: wp, eps, long
   use nutate_methods, only: default_settings, integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: attitude_distance
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   use test_problems, only: body_momentum, box, bruls_top, forced_body, free_body, make_state, problem_t, system_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> A user's effect, without series: U = γ₃⁴.
   type, extends(potential_t) :: own_potential_t
   contains
      procedure :: energy => fourth_power
      procedure :: gradient => fourth_power_gradient
   end type own_potential_t

   !> Counts rows; keeps their largest distance from a closed solution, if there is one.
   type, extends(observer_t) :: spectator_t
      integer :: rows = 0
      type(free_body_t) :: solution
      logical :: compares = .false.
      real(wp) :: distance = 0.0_wp
   contains
      procedure :: observe => look_at_row
   end type spectator_t

contains

   module procedure collect_choice
      testsuite = [ &
                  new_unittest("a free body is solved in closed form", free_body_is_solved), &
                  new_unittest("short smooth motions take fixed steps", smooth_motions_take_equal_steps), &
                  new_unittest("linear effects take the series at any accuracy", linear_effects_take_series), &
                  new_unittest("other motions take the series from 1e-6 rad on", others_take_series_late), &
                  new_unittest("torques at times far from 0 take the series", late_torques_take_series), &
                  new_unittest("long motions take the series sooner", long_motions_take_series), &
                  new_unittest("an effect without series takes dop853 with conserve", without_series_dop853), &
                  new_unittest("strong damping takes the implicit step", strong_damping_takes_implicit_step), &
                  new_unittest("what is not the method's is kept", other_settings_are_kept), &
                  new_unittest("extreme input is assessed without a trap", extreme_input), &
                  new_unittest("a run chooses where no method is named", run_chooses_method), &
                  new_unittest("a run chooses the order where it is open", run_chooses_order), &
                  new_unittest("strongly damped runs take order 2", damped_run_takes_order_2), &
                  new_unittest("auto needs a goal, and nothing beside it", auto_is_refused), &
                  new_unittest("fixed steps take order 2 where nothing is named", fixed_steps_take_order_2), &
                  new_unittest("closed solution with accuracy and rows at intervals", closed_solution_with_accuracy), &
                  new_unittest("no row a rounding of the time before the end", no_row_next_to_the_end), &
                  new_unittest("trial runs that nothing tells apart keep their difference", trial_runs_alike), &
                  new_unittest("a chaotic motion is not called solved", chaos_is_not_called_solved)]
   end procedure collect_choice

   !> Checks what is chosen for a problem.
   subroutine expect(error, problem, duration, accuracy, method, words, at_end)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: duration, accuracy
      character(len=*), intent(in) :: method
      !> Part of the reason.
      character(len=*), intent(in) :: words
      logical, intent(in), optional :: at_end
      type(integrator_settings_t) :: settings
      character(len=:), allocatable :: reason
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      settings%method = AUTOMATIC_METHOD
      call choose_method(problem%system, problem%start, duration, accuracy, settings, reason, at_end)
      call check(error, trim(settings%method), method, reason)
      call check(error, index(reason, words) > 0, reason)
      call check(error, settings%conserve .eqv. any(method == [character(len=6) :: 'dop853', 'rk8', &
                                                                                   'taylor']), "conserve")
      call make_stepper(problem%system, settings, stepper, status)
      call check(error, status%ok(), trim(status%message))
   end subroutine expect

   subroutine free_body_is_solved(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => box()
      call expect(error, problem, 20.0_wp, 1e-4_wp, 'exact', 'closed solution')
      ! Moments too far apart for the closed solution.
      problem => free_body([1e-70_wp, 1.0_wp, 1.0_wp], [0.0_wp, 1.0_wp, 1.0_wp])
      call expect(error, problem, 20.0_wp, 1e-4_wp, 'taylor', 'linear')
      problem => box()
      call problem%system%effects%add(rotor_t(name='rotor', momentum=[1.0_wp, 0.0_wp, 0.0_wp]))
      call expect(error, problem, 5.0_wp, 1e-2_wp, 'taylor', 'linear')
   end subroutine free_body_is_solved

   !> Checks gravity, damping, a rotating frame and a torque that depends on time alone, short as the runs may be.
   subroutine linear_effects_take_series(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(applied_torque_t) :: torque
      problem => bruls_top()
      call expect(error, problem, 40.0_wp, 1e-1_wp, 'taylor', 'linear')
      call expect(error, problem, -0.1_wp, 9e-8_wp, 'taylor', 'linear')
      call problem%system%effects%add(damping_t([0.1_wp, 0.1_wp, 0.2_wp]))
      call expect(error, problem, 2.0_wp, 1e-1_wp, 'taylor', 'linear')
      call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=[0.1_wp, -0.2_wp, 0.3_wp]))
      call expect(error, problem, 2.0_wp, 1e-1_wp, 'taylor', 'linear')
      problem => free_body([0.5_wp, 0.8_wp, 1.0_wp], [0.0_wp, 30.0_wp, 1.0_wp])
      torque%name = 'torque'
      torque%amplitude = [1.0_wp, 0.0_wp, 0.0_wp]
      torque%frequency = 1.0_wp
      call problem%system%effects%add(torque)
      call expect(error, problem, 20.0_wp, 1e-2_wp, 'taylor', 'linear')
   end subroutine linear_effects_take_series

   !> A top turns by 14 rad/s in the frame that does not spin; what swings, by 8 rad/s at most.
   subroutine smooth_motions_take_equal_steps(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      problem => bruls_top()
      call expect(error, problem, 2.0_wp, 1e-1_wp, 'rk8', 'equal steps')
      call expect(error, problem, -0.1_wp, 1e-7_wp, 'rk8', 'equal steps')
      call expect(error, problem, 2.0_wp, 1e-6_wp, 'taylor', 'linear', at_end=.false.)
      problem => free_body([0.5_wp, 0.8_wp, 1.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call problem%system%effects%add(dipole_t([1.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 4.0_wp, 0.0_wp]))
      call expect(error, problem, 20.0_wp, 1e-2_wp, 'rk8', 'equal steps')
      call expect(error, problem, 20.0_wp, 1e-7_wp, 'rk8', 'equal steps')
      call expect(error, problem, 20.0_wp, 9e-8_wp, 'taylor', 'linear')
      call expect(error, problem, 40.0_wp, 1e-2_wp, 'taylor', 'linear')
   end subroutine smooth_motions_take_equal_steps

   subroutine others_take_series_late(error)
      type(error_type), allocatable, intent(out) :: error
      call expect(error, forced_body(), 10.0_wp, 1.1e-6_wp, 'dop853', 'threshold 1e-6')
      call expect(error, forced_body(), 10.0_wp, 1e-6_wp, 'taylor', 'from 1e-6')
   end subroutine others_take_series_late

   !> At whole periods of a torque the motion is that from t = 0, to the rounding of the times; it takes as few steps.
   subroutine late_torques_take_series(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: starts(4) = [0.0_wp, 1e4_wp, 2e8_wp, 1.7e9_wp], accuracy = 2e-6_wp
      type(problem_t), pointer :: problem
      type(applied_torque_t) :: torque
      type(run_summary_t) :: summary
      type(run_plan_t) :: plan
      type(status_t) :: status
      type(state_t) :: last
      real(wp) :: first(4)
      integer :: i
      problem => free_body([2.0_wp, 3.0_wp, 4.0_wp], [0.1_wp, 0.2_wp, 1.0_wp])
      call problem%system%effects%add(spring_t([0.4_wp, 0.1_wp, -0.6_wp], [0.5_wp, 1.0_wp, -0.8_wp], 1.0_wp, 0.7_wp))
      torque%name = 'torque'
      torque%amplitude = [1.0_wp, 0.0_wp, 0.0_wp]
      torque%frequency = 1.0_wp
      call problem%system%effects%add(torque)
      do i = 1, size(starts)
         problem%start%t = starts(i)
         if (i > 2) call expect(error, problem, 4.0_wp, accuracy, 'taylor', 'far from t = 0')
         if (i < 3) call expect(error, problem, 4.0_wp, accuracy, 'dop853', 'threshold 1e-6')
         plan = run_plan_t(end_time=starts(i) + 4.0_wp)
         plan%goal%accuracy = accuracy
         last = problem%start
         call integrate(problem%system, integrator_settings_t(), last, plan, status, summary=summary)
         call check(error, status%ok(), trim(status%message))
         call check(error, summary%steps < 200, 'number of steps')
         if (i == 1) first = last%q
         call check_below(error, attitude_distance(first, last%q), 10*accuracy + 6*spacing(starts(i)), 'attitude')
      end do
   end subroutine late_torques_take_series

   !> Turns of many revolutions, swings of many periods.
   subroutine long_motions_take_series(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      call expect(error, forced_body(), 1000.0_wp, 1e-3_wp, 'taylor', 'from 1e-3')
      call expect(error, forced_body(), 1000.0_wp, 1.1e-3_wp, 'dop853', 'threshold 1e-3')
      problem => free_body([0.5_wp, 0.8_wp, 1.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
      call problem%system%effects%add(dipole_t([1.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 4.0_wp, 0.0_wp]))
      call problem%system%effects%add(spring_t([0.1_wp, 0.0_wp, 0.0_wp], [0.0_wp, 1.0_wp, 0.0_wp], 0.1_wp, 0.5_wp))
      call expect(error, problem, 80.0_wp, 1e-3_wp, 'taylor', 'from 1e-3')
      call expect(error, problem, 40.0_wp, 1e-3_wp, 'dop853', 'threshold 1e-6')
   end subroutine long_motions_take_series

   subroutine without_series_dop853(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(own_potential_t) :: own
      problem => bruls_top()
      own%name = 'own'
      call problem%system%effects%add(own)
      call expect(error, problem, 2.0_wp, 1e-12_wp, 'dop853', "effect 'own' has no series")
      problem => box()
      own%name = ''
      call problem%system%effects%add(own)
      call expect(error, problem, 2.0_wp, 1e-12_wp, 'dop853', "effect 'unnamed' has no series")
   end subroutine without_series_dop853

   !> On one axis damping is strong from 30 000/√accuracy on: 1e5/s for 100 s at 9.2e-6 rad (9.9e6). On all of them from
   !> 2000 over the fifth root: 1000/s for 10 s at 3.3e-4 rad (9.94e3), if anything drives the body. Negative
   !> coefficients drive it as well.
   subroutine strong_damping_takes_implicit_step(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(problem_t), pointer :: turning
      problem => free_body([1.0_wp, 2.0_wp, 2.5_wp], [1.0_wp, 1.0_wp, 1.0_wp])
      call problem%system%effects%add(damping_t([1e5_wp, 0.0_wp, 0.0_wp]))
      call expect(error, problem, 100.0_wp, 9.2e-6_wp, 'nielsen_krenk', 'strong damping')
      call expect(error, problem, -100.0_wp, 9.2e-6_wp, 'nielsen_krenk', 'strong damping')
      call expect(error, problem, 100.0_wp, 8.8e-6_wp, 'taylor', 'linear')
      problem => free_body([1.0_wp, 2.0_wp, 2.5_wp], [1.0_wp, 1.0_wp, 1.0_wp])
      call problem%system%effects%add(damping_t([-1000.0_wp, 0.0_wp, 0.0_wp]))
      call expect(error, problem, 100.0_wp, 1e-2_wp, 'taylor', 'linear')
      problem => free_body([1.0_wp, 2.0_wp, 2.5_wp], [1.0_wp, 1.0_wp, 1.0_wp])
      call problem%system%effects%add(damping_t([1000.0_wp, 2000.0_wp, 3000.0_wp]))
      call expect(error, problem, 10.0_wp, 1e-3_wp, 'taylor', 'linear')
      turning => free_body([1.0_wp, 2.0_wp, 2.5_wp], [1.0_wp, 1.0_wp, 1.0_wp])
      call turning%system%effects%add(damping_t([1000.0_wp, 2000.0_wp, 3000.0_wp]))
      call turning%system%effects%add(rotating_frame_t(name='rotating_frame', rate=[0.1_wp, -0.2_wp, 0.3_wp]))
      call expect(error, turning, 10.0_wp, 1e-3_wp, 'nielsen_krenk', 'strong damping')
      call problem%system%effects%add(dipole_t([1.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 4.0_wp, 0.0_wp]))
      call expect(error, problem, 10.0_wp, 3.3e-4_wp, 'nielsen_krenk', 'strong damping')
      call expect(error, problem, 10.0_wp, 3.1e-4_wp, 'taylor', 'linear')
   end subroutine strong_damping_takes_implicit_step

   subroutine other_settings_are_kept(error)
      type(error_type), allocatable, intent(out) :: error
      type(integrator_settings_t) :: settings
      type(problem_t), pointer :: problem
      character(len=:), allocatable :: reason
      problem => forced_body()
      settings = integrator_settings_t(method=AUTOMATIC_METHOD, inverse_auxiliary_inertia=0.25_wp, attitude=.false., &
                                       tolerance=1e-9_wp, max_iterations=7)
      call choose_method(problem%system, problem%start, 1.0_wp, 1e-9_wp, settings, reason)
      call check(error, .not. settings%attitude .and. settings%max_iterations == 7, "kept")
      call check_close(error, [settings%inverse_auxiliary_inertia, settings%tolerance], [0.25_wp, 1e-9_wp], 0.0_wp, &
                       "kept")
   end subroutine other_settings_are_kept

   !> Numbers at the ends of what a scene can hold; a body at rest.
   subroutine extreme_input(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: sizes(3) = [1e-100_wp, 1.0_wp, 1e100_wp]
      type(problem_t), pointer :: problem
      type(integrator_settings_t) :: settings
      character(len=:), allocatable :: reason
      integer :: i, j, k
      do i = 1, 3
         do j = 1, 3
            do k = 1, 3
               problem => bruls_top()
               problem%start = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], &
                                          [0.0_wp, sizes(k), 0.0_wp])
               call choose_method(problem%system, problem%start, sizes(i), min(sizes(j), 0.5_wp), settings, reason)
               problem => free_body(sizes(i)*[1.0_wp, 1.0_wp, 1.0_wp], [0.0_wp, 0.0_wp, 0.0_wp])
               call problem%system%effects%add(damping_t(sizes(j)*[1.0_wp, 1.0_wp, 1.0_wp]))
               call choose_method(problem%system, problem%start, sizes(k), 1e-300_wp, settings, reason)
            end do
         end do
      end do
      call expect(error, free_body([1.0_wp, 2.0_wp, 2.5_wp], [0.0_wp, 0.0_wp, 0.0_wp]), 0.0_wp, 1e-16_wp, 'exact', &
                  'closed solution')
   end subroutine extreme_input

   !> Checks runs with an accuracy and with a local tolerance, without a name and with `auto`: they use the method of
   !> `choose_method`.
   subroutine run_chooses_method(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=4), parameter :: names(2) = [character(len=4) :: '', AUTOMATIC_METHOD]
      real(wp), parameter :: accuracies(3) = [1e-3_wp, 1e-7_wp, 1e-10_wp]
      type(problem_t) :: problems(3)
      type(integrator_settings_t) :: wanted
      type(run_plan_t) :: plan
      type(run_summary_t) :: summary
      type(status_t) :: status
      character(len=:), allocatable :: reason
      integer :: i, j, k
      ! A constructor of this array would leak with gfortran 12.
      problems(1) = box()
      problems(2) = bruls_top()
      problems(3) = forced_body()
      do i = 1, size(problems)
         do j = 1, size(accuracies)
            do k = 1, 4
               plan = run_plan_t(end_time=0.2_wp)
               if (k <= 2) plan%goal%accuracy = accuracies(j)
               if (k > 2) plan%goal%local_tolerance = accuracies(j)
               call choose_method(problems(i)%system, problems(i)%start, 0.2_wp, accuracies(j), wanted, reason, k <= 2)
               call run_unseen(problems(i), integrator_settings_t(method=names(1 + mod(k, 2))), plan, summary, status)
               call check(error, status%ok(), trim(status%message))
               if (.not. allocated(error)) call check(error, summary%settings%method == wanted%method .and. &
                                              (summary%settings%conserve .eqv. wanted%conserve), wanted%method)
               call check(error, summary%choice == reason .and. reason /= '', reason)
            end do
         end do
      end do
   end subroutine run_chooses_method

   !> Checks that settings of one method rule out the choice of the method; the order of the implicit step is still
   !> chosen.
   subroutine run_chooses_order(error)
      type(error_type), allocatable, intent(out) :: error
      type(integrator_settings_t) :: settings(6)
      integer, parameter :: orders(6) = [8, 4, 8, 2, 4, 2]
      type(run_plan_t) :: plan
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: i
      settings(:) = integrator_settings_t(formulation='reduced')
      settings(2) = integrator_settings_t(order=4)
      settings(3) = integrator_settings_t(method='nielsen_krenk')
      settings(4) = integrator_settings_t(method='nielsen_krenk', order=2)
      do i = 1, size(settings)
         plan = run_plan_t(end_time=0.02_wp, goal=run_goal_t(accuracy=1e-5_wp))
         if (i == 5) plan%goal%accuracy = 1e-2_wp
         if (i == 6) plan%goal = run_goal_t(local_tolerance=1e-5_wp)
         call run_unseen(box(), settings(i), plan, summary, status)
         call check(error, status%ok(), trim(status%message))
         call check(error, summary%settings%method == 'nielsen_krenk' .and. summary%choice == '', &
                    summary%settings%method)
         call check(error, summary%settings%order, orders(i), "order")
      end do
   end subroutine run_chooses_order

   !> Stages of higher orders that go back in time amplify strongly damped motion: they would take 1e4 steps and more.
   subroutine damped_run_takes_order_2(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(run_plan_t) :: plan
      type(run_summary_t) :: summary
      type(status_t) :: status
      problem => free_body([2.0_wp, 3.0_wp, 4.0_wp], [0.3_wp, 1.0_wp, 5.0_wp])
      call problem%system%effects%add(damping_t([1000.0_wp, 1500.0_wp, 3000.0_wp]))
      call problem%system%effects%add(dipole_t([1.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 4.0_wp, 0.0_wp]))
      plan = run_plan_t(end_time=20.0_wp, goal=run_goal_t(accuracy=1e-6_wp), max_steps=3000_long)
      call run_unseen(problem, integrator_settings_t(method='nielsen_krenk'), plan, summary, status)
      call check(error, status%ok() .and. summary%estimate < 1e-6_wp, trim(status%message))
      call check(error, summary%settings%order, 2, "order")
   end subroutine damped_run_takes_order_2

   !> As scenes refuse it.
   subroutine auto_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(integrator_settings_t) :: settings(5)
      type(run_plan_t) :: plan
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: i
      settings = integrator_settings_t(method=AUTOMATIC_METHOD)
      settings(1)%order = 8
      settings(2)%formulation = 'reduced'
      settings(3)%series_order = 12
      settings(4)%conserve = .true.
      plan = run_plan_t(end_time=0.1_wp, goal=run_goal_t(accuracy=1e-5_wp))
      do i = 1, size(settings)
         if (i == 5) plan = run_plan_t(end_time=0.1_wp, time_step=0.01_wp)
         call run_unseen(box(), settings(i), plan, summary, status)
         call check(error, status%code, NUTATE_BAD_ARGUMENT, trim(status%message))
      end do
   end subroutine auto_is_refused

   subroutine fixed_steps_take_order_2(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: states(2)
      type(run_summary_t) :: summary
      type(status_t) :: status
      type(run_plan_t) :: plan
      problem => box()
      states = problem%start
      plan = run_plan_t(end_time=0.5_wp, time_step=0.01_wp)
      call integrate(problem%system, integrator_settings_t(), states(1), plan, status, summary=summary)
      call check(error, status%ok() .and. summary%settings%method == 'nielsen_krenk' .and. summary%choice == '')
      call check(error, summary%settings%order, 2)
      call integrate(problem%system, integrator_settings_t(method='nielsen_krenk', order=2, formulation='full'), &
                     states(2), plan, status)
      call check_close(error, states(1)%p, states(2)%p, 0.0_wp, "the same bits")
   end subroutine fixed_steps_take_order_2

   !> Runs a problem by settings, for nobody to see.
   subroutine run_unseen(problem, settings, plan, summary, status)
      type(problem_t), intent(in) :: problem
      type(integrator_settings_t), intent(in) :: settings
      type(run_plan_t), intent(in) :: plan
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      type(state_t) :: state
      state = problem%start
      call integrate(problem%system, settings, state, plan, status, summary=summary)
   end subroutine run_unseen

   !> Rows where they are asked for, each as exact as the last, by steps of 64 of them; nobody to see them: one step.
   !> Steps that are rows turn by a radian.
   subroutine closed_solution_with_accuracy(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(spectator_t) :: spectator
      type(state_t) :: state, last
      type(run_summary_t) :: summary
      type(status_t) :: status
      problem => box()
      call spectator%solution%prepare(problem%system%body%moments, problem%start%q, body_momentum(problem%start), &
                                      status, problem%system%body%axes)
      spectator%compares = .true.
      call run(problem, 'exact', run_plan_t(end_time=20.0_wp, interval=0.03_wp, goal=run_goal_t(accuracy=1e-6_wp)), &
               spectator, state, summary, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, spectator%rows, 668, "rows: the first, 666 at intervals, the last")
      call check_below(error, spectator%distance, 16*eps, "every row")
      call check_close(error, real(summary%steps, wp), 11.0_wp, 0.0_wp, "64 rows in a step")
      call run(problem, 'exact', run_plan_t(end_time=20.0_wp, goal=run_goal_t(accuracy=1e-6_wp)), spectator, state, &
               summary, status)
      ! √(2T/J1) = √(1700.05/5) = 18.44 rad/s.
      call check_close(error, real(summary%steps, wp), 369.0_wp, 1.0_wp, "a radian of turn in a step")
      last = state
      state = problem%start
      call integrate(problem%system, default_settings('exact'), state, &
                     run_plan_t(end_time=20.0_wp, goal=run_goal_t(accuracy=1e-6_wp)), status, summary=summary)
      call check(error, status%ok() .and. summary%steps == 1, "the end at once")
      call check_close(error, state%q, last%q, 16*eps, "the end")
   end subroutine closed_solution_with_accuracy

   !> Checks that there are 101 rows if 1e-9 of an interval is below the last digit of the time, however the end is
   !> rounded.
   subroutine no_row_next_to_the_end(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(spectator_t) :: spectator
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: k
      problem => box()
      problem%start%t = 1e7_wp
      do k = -1, 1
         spectator%rows = 0
         call run(problem, 'taylor', run_plan_t(end_time=1e7_wp + 10 + k*spacing(1e7_wp), interval=0.1_wp, &
                                                goal=run_goal_t(local_tolerance=1e-12_wp)), spectator, state, summary, &
                  status)
         call check(error, status%ok(), trim(status%message))
         call check(error, spectator%rows, 101, "rows")
      end do
   end subroutine no_row_next_to_the_end

   !> Order 8 on damping so strong that its steps have one length whatever the rate.
   subroutine trial_runs_alike(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(spectator_t) :: spectator
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(status_t) :: status
      problem => free_body([3.75e-3_wp, 3.75e-3_wp, 7.5e-3_wp], [0.01_wp, 0.0_wp, 0.3_wp])
      call problem%system%effects%add(damping_t([1.0_wp, 1.0_wp, 1.0_wp]))
      call run(problem, 'nielsen_krenk', run_plan_t(end_time=3.0_wp, goal=run_goal_t(accuracy=1e-2_wp)), spectator, &
               state, summary, status)
      call check(error, status%ok(), trim(status%message))
      call check_below(error, summary%estimate, 1e-2_wp, "estimate")
   end subroutine trial_runs_alike

   !> A stiff spring on a body that many other effects push: trial runs differ by radians, and in the end not at all,
   !> where their steps are at round-off.
   subroutine chaos_is_not_called_solved(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(spectator_t) :: spectator
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(status_t) :: status
      problem => forced_body()
      call problem%system%effects%add(spring_t([0.4_wp, 0.1_wp, -0.6_wp], [0.5_wp, 1.0_wp, -0.8_wp], 1e5_wp, 0.7_wp))
      call run(problem, 'taylor', run_plan_t(end_time=20.0_wp, goal=run_goal_t(accuracy=1e-4_wp)), spectator, state, &
               summary, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, summary%estimate > 1e-4_wp, "the estimate is too good")
   end subroutine chaos_is_not_called_solved

   !> Runs a problem for an accuracy.
   subroutine run(problem, method, plan, spectator, state, summary, status)
      type(problem_t), intent(in) :: problem
      character(len=*), intent(in) :: method
      type(run_plan_t), intent(in) :: plan
      type(spectator_t), intent(inout) :: spectator
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(status_t), intent(out) :: status
      type(integrator_settings_t) :: settings
      settings = integrator_settings_t(method=method, order=8, formulation='reduced', conserve=method == 'taylor')
      state = problem%start
      call integrate(problem%system, settings, state, plan, status, spectator, summary)
   end subroutine run

   subroutine look_at_row(self, system, state, record, status)
      class(spectator_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      real(wp) :: q(4), momentum(3)
      self%rows = self%rows + 1
      if (.not. self%compares) return
      call self%solution%evaluate(state%t, q, momentum)
      self%distance = max(self%distance, attitude_distance(state%q, q))
   end subroutine look_at_row

   !> γ₃⁴.
   pure real(wp) function fourth_power(self, gamma) result(energy)
      class(own_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      energy = gamma(3)**4
   end function fourth_power

   pure function fourth_power_gradient(self, gamma) result(gradient)
      class(own_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = [0.0_wp, 0.0_wp, 4*gamma(3)**3]
   end function fourth_power_gradient

end submodule test_choice
