!> Work-precision studies: references, measured runs, series of steps, interpolated points.
submodule(suites_of_runs) test_work_precision
   use nutate_kinds, only: wp, eps
   use nutate_methods, only: methods
   use nutate_quaternion, only: attitude_distance
   use nutate_reference, only: reference_methods, reference_t, AGREED, EXACT_FREE_BODY, EXACT_TOP, NO_REFERENCE
   use nutate_scene, only: parse_scene, scene_t
   use nutate_status, only: status_t
   use nutate_study_budget, only: study_budget_t
   use nutate_measured_run, only: fastest_rate, problem_t
   use nutate_work_point, only: measure_point, median, point_at_error, work_point_t
   use nutate_work_precision, only: longest_step, work_precision_t, OUT_OF_BUDGET, UNDER_WAY
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   character(len=*), parameter :: newline = new_line('a')
   character(len=*), parameter :: box = '&body inertia = 5, 20, 17 /'//newline// &
                                  '&initial angular_velocity = 0.1, 0, 10 /'//newline// &
                                  '&integrator time_step = 0.01, end_time = 1 /'//newline
   character(len=*), parameter :: top = '&body inertia = 5, 1, 5, mass = 2, center_of_mass = 0, 0.4, 0 /'//newline// &
                                  '&initial axis = 1, 2, 0.3, angle = 1, angular_velocity = 0.3, 8, 1 /'//newline// &
                                  '&integrator time_step = 0.01, end_time = 1 /'//newline// &
                                  '&gravity acceleration = 1, 2, -9 /'//newline

   !> Steps of higher order that are subdivided into a thousand parts each.
   character(len=*), parameter :: subdivided = '&body inertia = 4.2e-5, 4.2e-5, 1.1e-5, mass = 0.0148 /'//newline// &
      "&orbit altitude = 184324, argument_of_periapsis = 56.8, frame = 'inertial' /"//newline// &
      '&earth_field moment = 4354.5, 0.016, 1.058, epoch_angle = -30.9, '// &
      'coefficients = 0.5256, 4.7e-52, 1702.37, degrees = .true. /'//newline// &
      "&initial rate_from = 'inertial', attitude_from = 'lvlh', roll_pitch_yaw = -2.56, 1.0, 0.0055, "// &
      'angular_velocity = 2.82, 0.079, 0.0207 /'//newline// &
      '&integrator time_step = 614.3, end_time = 1843, auxiliary_inertia = 3.53e-8 /'

contains

   module procedure collect_work_precision
      testsuite = [ &
                  new_unittest("a closed solution is used where there is one", closed_solutions_are_found), &
                  new_unittest("what two methods agree on is the exact attitude", agreement_is_exact), &
                  new_unittest("a motion too long to be followed has no reference", chaos_has_no_reference), &
                  new_unittest("errors fall with the order of the method", errors_fall_with_the_order), &
                  new_unittest("a study ends within its budget with runs of every method", study_keeps_its_budget), &
                  new_unittest("runs that are too long end with the budget", long_runs_keep_the_budget), &
                  new_unittest("steps in a thousand parts keep the budget", subdivided_steps_keep_the_budget), &
                  new_unittest("the run for the fastest rate keeps its share", first_run_keeps_its_share), &
                  new_unittest("the same budget gives the same runs", runs_are_repeated), &
                  new_unittest("the user's step is among those of a study", longest_step_leads_to_the_users), &
                  new_unittest("specialised steps begin with those of the slow motion", specialised_steps_are_long), &
                  new_unittest("points between runs follow from power laws", points_follow_from_power_laws), &
                  new_unittest("a hopeless step does not make the next look better", no_better_than_the_order), &
                  new_unittest("an error that is small by accident does not count", accidents_do_not_count), &
                  new_unittest("the median is the middle", median_is_the_middle)]
   end procedure collect_work_precision

   !> A problem from a scene in memory.
   function problem_of(text) result(problem)
      character(len=*), intent(in) :: text
      type(problem_t) :: problem
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse_scene(text, 'work_precision.nml', scene, status, message)
      if (status%ok()) problem = problem_t(scene%system, scene%initial, scene%plan%end_time, scene%integrator)
   end function problem_of

   !> The reference of a problem, settled.
   function reference_of(problem, evaluations) result(reference)
      type(problem_t), intent(in) :: problem
      !> Budget.
      real(wp), intent(in) :: evaluations
      type(reference_t) :: reference
      type(study_budget_t) :: budget
      type(status_t) :: status
      real(wp) :: rate
      integer :: first, second
      call reference_methods(first, second)
      call fastest_rate(problem, first, rate, status)
      budget = study_budget_t(limit=evaluations, is_in_evaluations=.true.)
      call reference%begin(problem, rate)
      do while (.not. reference%settled)
         call reference%refine(problem, budget)
      end do
   end function reference_of

   !> The run would take 20 000 steps of 17 solutions; the reference may spend 0.3 of the budget.
   subroutine first_run_keeps_its_share(error)
      type(error_type), allocatable, intent(out) :: error
      type(work_precision_t) :: study
      type(problem_t) :: problem
      real(wp), parameter :: limit = 1e5_wp
      problem = problem_of(top//'&damping coefficient = 1e-9, 1e-9, 1e-9 /'//newline)
      problem%end_time = 1e4_wp
      call study%begin(problem, 0.0_wp, study_budget_t(limit=limit, is_in_evaluations=.true.))
      call check_close(error, study%budget%spent(), 0.3_wp*limit, 17.0_wp)
   end subroutine first_run_keeps_its_share

   subroutine closed_solutions_are_found(error)
      type(error_type), allocatable, intent(out) :: error
      call expect(box, EXACT_FREE_BODY)
      call expect(top, EXACT_TOP)
      call expect(box//'&dipole moment = 0, 0, 0, field = 1, 0, 0 /', EXACT_FREE_BODY)
      call expect('&body inertia = 2, 2, 2 /'//newline//'&initial angular_velocity = 1, 2, 3 /'//newline// &
                  '&integrator time_step = 0.01, end_time = 1 /'//newline// &
                  '&dipole moment = 1, -2, 0.5, field = 1, 0, 0 /', EXACT_TOP)
      call expect(box//'&rotor momentum = 1, 0, 0 /', AGREED)
      call expect(top//'&damping coefficient = 1, 1, 1 /', AGREED)
      call expect(top//'&dipole moment = 0, 1, 0, field = 1, 0, 0 /', AGREED)
      call expect(box//'&dipole moment = 0, 1, 0, field = 1, 0, 0 /', AGREED)
   contains
      subroutine expect(text, kind)
         character(len=*), intent(in) :: text
         integer, intent(in) :: kind
         type(reference_t) :: reference
         if (allocated(error)) return
         reference = reference_of(problem_of(text), 3e6_wp)
         call check(error, reference%kind == kind, 'another kind of reference for '//text)
      end subroutine expect
   end subroutine closed_solutions_are_found

   !> A rotor at rest leaves the motion as it is, but no closed solution is looked for then.
   subroutine agreement_is_exact(error)
      type(error_type), allocatable, intent(out) :: error
      type(reference_t) :: exact, agreed_on
      exact = reference_of(problem_of(box), 3e6_wp)
      agreed_on = reference_of(problem_of(box//'&rotor momentum = 0, 0, 0 /'), 3e6_wp)
      call check_below(error, agreed_on%uncertainty, 1e-11_wp, 'uncertainty')
      call check_below(error, attitude_distance(exact%q, agreed_on%q), 10*agreed_on%uncertainty, 'distance')
      exact = reference_of(problem_of(top), 3e6_wp)
      agreed_on = reference_of(problem_of(top//'&rotor momentum = 0, 0, 0 /'), 3e6_wp)
      call check_below(error, attitude_distance(exact%q, agreed_on%q), 10*agreed_on%uncertainty, 'distance, top')
   end subroutine agreement_is_exact

   subroutine chaos_has_no_reference(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t) :: problem
      type(reference_t) :: reference
      problem = problem_of('&body inertia = 5, 20, 17, mass = 9, center_of_mass = 0.4, 0.3, 0.2 /'//newline// &
                           '&initial angular_velocity = 0.1, 0, 1 /'//newline// &
                           '&integrator time_step = 0.1, end_time = 1e9 /'//newline//'&gravity /')
      reference = reference_of(problem, 2e5_wp)
      call check(error, reference%kind == NO_REFERENCE .and. .not. reference%known(), 'there is a reference')
   end subroutine chaos_has_no_reference

   subroutine errors_fall_with_the_order(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t) :: problem
      type(reference_t) :: reference
      type(work_point_t) :: long, short
      type(study_budget_t) :: unlimited
      type(status_t) :: status
      real(wp) :: step
      integer :: m
      problem = problem_of(box)
      reference = reference_of(problem, 3e6_wp)
      do m = 1, size(methods)
         if (methods(m)%order < 1) cycle
         ! Steps of order 16 that are short enough to show it are all at round-off.
         if (methods(m)%dense) cycle
         step = merge(0.005_wp, 0.05_wp, methods(m)%order < 6)
         long = work_point_t(method=m, time_step=step)
         short = work_point_t(method=m, time_step=step/2)
         call measure_point(problem, reference, 0.0_wp, unlimited, long, status)
         if (status%ok()) call measure_point(problem, reference, 0.0_wp, unlimited, short, status)
         call check(error, status%ok(), trim(status%message))
         if (allocated(error)) return
         call check_close(error, log(long%attitude_error/short%attitude_error)/log(2.0_wp), &
                          real(methods(m)%order, wp), 0.6_wp, 'order of '//methods(m)%name)
         call check(error, short%steps == 2*long%steps .and. short%samples == 3 .and. short%seconds > 0.0_wp, &
                    'steps and times of '//methods(m)%name)
         if (methods(m)%name == 'nielsen_krenk') call check_below(error, max(short%energy_error, &
            short%momentum_error, short%norm_error), 100*eps, 'invariants')
      end do
   end subroutine errors_fall_with_the_order

   subroutine study_keeps_its_budget(error)
      type(error_type), allocatable, intent(out) :: error
      type(work_precision_t) :: study
      type(work_point_t), allocatable :: points(:)
      integer :: m
      call make_study(error, problem_of(box), 3e5_wp, study)
      if (allocated(error)) return
      call check(error, count(study%ending == OUT_OF_BUDGET) > 0, 'the budget was enough for everything')
      do m = 1, size(methods)
         call check(error, study%ending(m) /= UNDER_WAY, 'a method is under way')
         if (methods(m)%order < 1) cycle
         points = study%points_of(m)
         call check(error, size(points) >= 3, 'hardly a run of '//methods(m)%name)
         if (allocated(error)) return
         if (methods(m)%dense) then
            call check_close(error, points(1)%tolerance/points(2)%tolerance, 10.0_wp, 8*eps, &
                             'tolerances of '//methods(m)%name)
         else
            call check_close(error, points(1)%time_step/points(2)%time_step, 2.0_wp, 0.0_wp, 'steps')
         end if
      end do
   end subroutine study_keeps_its_budget

   !> Runs of the box for 1e5 s need a hundred times the budget and more.
   subroutine long_runs_keep_the_budget(error)
      type(error_type), allocatable, intent(out) :: error
      type(work_precision_t) :: study
      type(problem_t) :: problem
      problem = problem_of(box)
      problem%end_time = 1e5_wp
      call make_study(error, problem, 3e5_wp, study)
      if (allocated(error)) return
      call check(error, all(study%ending == OUT_OF_BUDGET .or. methods%order < 1), 'a run was ended by something else')
   end subroutine long_runs_keep_the_budget

   subroutine subdivided_steps_keep_the_budget(error)
      type(error_type), allocatable, intent(out) :: error
      type(work_precision_t) :: study
      call make_study(error, problem_of(subdivided), 5e3_wp, study)
   end subroutine subdivided_steps_keep_the_budget

   !> No decision of a study depends on a clock: not the runs, their order or their errors.
   subroutine runs_are_repeated(error)
      type(error_type), allocatable, intent(out) :: error
      type(work_precision_t) :: first, second
      call make_study(error, problem_of(top), 1e5_wp, first)
      if (.not. allocated(error)) call make_study(error, problem_of(top), 1e5_wp, second)
      if (allocated(error)) return
      call check(error, size(first%points) == size(second%points) .and. all(first%ending == second%ending), &
                 'other runs')
      if (allocated(error)) return
      call check(error, all(first%points%method == second%points%method), 'other methods')
      call check(error, all(first%points%steps == second%points%steps), 'other steps')
      call check(error, all(first%points%samples == second%points%samples), 'other samples')
      call check_close(error, first%points%attitude_error, second%points%attitude_error, 0.0_wp, 'attitude errors')
   end subroutine runs_are_repeated

   !> A study to its end; it spends no more than its budget but for one step of each method, the least that a run takes.
   subroutine make_study(error, problem, evaluations, study)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      !> Budget.
      real(wp), intent(in) :: evaluations
      type(work_precision_t), intent(out) :: study
      call study%begin(problem, 0.01_wp, study_budget_t(limit=evaluations, is_in_evaluations=.true.))
      do while (.not. study%done)
         call study%advance()
      end do
      call check_below(error, study%budget%spent(), evaluations + sum(methods%stages), 'evaluations')
   end subroutine make_study

   subroutine longest_step_leads_to_the_users(error)
      type(error_type), allocatable, intent(out) :: error
      call check_close(error, longest_step(1.0_wp, 10.0_wp, 0.01_wp), 0.32_wp, 0.0_wp)
      call check_close(error, longest_step(1.0_wp, 10.0_wp, 0.0_wp), 1.0_wp/3, eps)
      call check_close(error, longest_step(-1.0_wp, 10.0_wp, -3.0_wp), -0.375_wp, 0.0_wp)
   end subroutine longest_step_leads_to_the_users

   !> A top that spins at 150 rad/s while its axis moves at 5: `rk8` is at round-off at the longest step of the others.
   subroutine specialised_steps_are_long(error)
      type(error_type), allocatable, intent(out) :: error
      type(work_precision_t) :: study
      type(work_point_t), allocatable :: points(:), others(:)
      integer :: m
      call make_study(error, problem_of('&body inertia = 15.234375, 0.46875, 15.234375, mass = 15, '// &
                                        'center_of_mass = 0, 1, 0 /'//newline//'&gravity /'//newline// &
                                        '&initial angular_velocity = 0, 150, -4.61538 /'//newline// &
                                        '&integrator time_step = 0.01, end_time = 2 /'), 2e5_wp, study)
      if (allocated(error)) return
      others = study%points_of(1)
      do m = 1, size(methods)
         if (.not. methods(m)%specialised) cycle
         points = study%points_of(m)
         ! Powers of two times 0.01 s: 4 rad of the spin are 0.027 s, of 10 rad/s 0.4 s.
         call check_close(error, points(1)%time_step/others(1)%time_step, 16.0_wp, 0.0_wp, 'steps')
         call check(error, points(1)%attitude_error > 1e-6_wp, 'no error of the first step')
         ! Three halvings by a method of order 8.
         call check_below(error, points(4)%attitude_error/points(1)%attitude_error, 2.0_wp**(-3*7), 'fall of the error')
      end do
   end subroutine specialised_steps_are_long

   !> Runs whose errors and times are powers of the step.
   pure function power_law(order, factor) result(runs)
      integer, intent(in) :: order
      !> Error at a step of 1, rad.
      real(wp), intent(in) :: factor
      type(work_point_t) :: runs(6)
      integer :: i
      do i = 1, 6
         runs(i)%method = 7
         runs(i)%time_step = 0.5_wp**i
         runs(i)%seconds = 1e-3_wp*2.0_wp**i
         runs(i)%attitude_error = factor*runs(i)%time_step**order
      end do
   end function power_law

   subroutine points_follow_from_power_laws(error)
      type(error_type), allocatable, intent(out) :: error
      type(work_point_t) :: point
      real(wp) :: step
      integer :: order
      do order = 2, 8, 2
         step = 0.1_wp
         point = point_at_error(power_law(order, 0.3_wp), order, 0.3_wp*step**order)
         call check(error, point%exists() .and. point%method == 7, 'not reached')
         call check_close(error, [point%time_step, point%seconds], [step, 1e-3_wp/step], 1e-14_wp)
      end do
      point = point_at_error(power_law(2, 0.3_wp), 2, 1e-6_wp)
      call check(error, .not. point%exists(), 'reached beyond the last run')
      point = point_at_error(power_law(2, 0.3_wp), 2, 1.0_wp)
      call check_close(error, point%time_step, 0.5_wp, 0.0_wp, 'met by the first')
   end subroutine points_follow_from_power_laws

   subroutine no_better_than_the_order(error)
      type(error_type), allocatable, intent(out) :: error
      type(work_point_t) :: runs(6)
      type(work_point_t) :: point
      runs = power_law(4, 1e-4_wp)
      runs(1)%attitude_error = 3.0_wp
      point = point_at_error(runs, 4, 16*runs(2)%attitude_error)
      call check_close(error, point%time_step, 0.5_wp, 1e-14_wp)
      point = point_at_error(runs, 4, 4*runs(2)%attitude_error)
      call check_close(error, point%time_step, sqrt(0.125_wp), 1e-14_wp)
   end subroutine no_better_than_the_order

   subroutine accidents_do_not_count(error)
      type(error_type), allocatable, intent(out) :: error
      type(work_point_t) :: runs(6)
      type(work_point_t) :: point
      runs = power_law(2, 1.0_wp)
      runs(1)%attitude_error = 1e-9_wp
      point = point_at_error(runs, 2, 1e-3_wp)
      call check_close(error, point%time_step, sqrt(1e-3_wp), 1e-14_wp)
   end subroutine accidents_do_not_count

   subroutine median_is_the_middle(error)
      type(error_type), allocatable, intent(out) :: error
      call check_close(error, median([3.0_wp, 9.0_wp, 1.0_wp]), 3.0_wp, 0.0_wp)
      call check_close(error, median([3.0_wp, 9.0_wp, 1.0_wp, 4.0_wp]), 3.5_wp, 0.0_wp)
      call check_close(error, median([7.0_wp]), 7.0_wp, 0.0_wp)
      call check_close(error, median([2.0_wp, 2.0_wp, 1.0_wp]), 2.0_wp, 0.0_wp)
   end subroutine median_is_the_middle

end submodule test_work_precision
