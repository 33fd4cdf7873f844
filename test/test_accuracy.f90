!> The accuracy that is asked for is kept: random scenes against an oracle of higher precision.
!>
!> `make test` runs the first scenes, `make accuracy` all of them, and writes the tables of
!> docs/results/accuracy-costs.md.
module test_accuracy
   use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
   use nutate_kinds, only: wp
   use nutate_method_choice, only: choose_method, AUTOMATIC_METHOD
   use nutate_methods, only: default_settings
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_STEP_LIMIT
   use nutate_integrator_settings, only: integrator_settings_t
   use test_oracle, only: find_true_attitude, has_oracle, qp, true_distance
   use test_problems, only: precessing_top, problem_t
   use test_random_scenes, only: make_random_scene, random_scene_t
   use test_support, only: check, check_below, error_type, new_unittest, random_unit, share_of, skip_test, &
                           unittest_type
   implicit none
   private

   public :: collect_accuracy, read_numbers, report_accuracy

   !> Ways to integrate; every scene is run by the first and three others in turn.
   integer, parameter :: n_ways = 12, ways_per_scene = 4
   character(len=22), parameter :: ways(n_ways) = [character(len=22) :: 'auto', 'taylor', 'dop853+conserve', &
      'nielsen_krenk order 8', 'dop853', 'taylor, plain', 'rk4', 'rk4+conserve', 'nielsen_krenk order 6', &
      'nielsen_krenk order 4', 'nielsen_krenk order 2', 'rk8+conserve']
   !> The ways that follow the first, three for each scene: those of which much is asked more often.
   integer, parameter :: turns(21) = [2, 3, 4, 2, 3, 5, 4, 6, 7, 2, 3, 4, 8, 9, 10, 3, 4, 11, 2, 12, 4]
   !> Steps that a run may have: low orders meet motions that grow so much that they would need 1e10.
   integer(int64), parameter :: most_steps = 3000000_int64
   !> Runs in `make accuracy`.
   integer, parameter :: all_runs = 2000

   !> Result of a run.
   type :: outcome_t
      integer :: way = 0
      !> Errors: requested, reported and true; rad.
      real(wp) :: asked = 0.0_wp, said = 0.0_wp, true = 0.0_wp
      !> The run was given up because of the number of steps that it would have needed; it reports so, and no error.
      logical :: given_up = .false.
      !> Reason why the run failed; blank: it did not fail.
      character(len=64) :: failure = ''
   contains
      !> Returns the true error over the larger of the requested and the reported one.
      procedure :: miss
   end type outcome_t

   !> Counts of many runs.
   type :: tally_t
      integer :: runs = 0, failed = 0, above_2 = 0, above_10 = 0, in_reach = 0, needlessly = 0
      real(wp), allocatable :: misses(:)
   end type tally_t

contains

   subroutine collect_accuracy(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("a number names one scene in every build", number_names_scene), &
                  new_unittest("the oracle knows the precessing top", oracle_knows_the_top), &
                  new_unittest("an accuracy is kept on random scenes", accuracy_is_kept)]
   end subroutine collect_accuracy

   !> A draw that an optimizer may leave out gives other scenes, a few of which no integration can follow.
   subroutine number_names_scene(error)
      type(error_type), allocatable, intent(out) :: error
      type(random_scene_t) :: scene
      call make_random_scene(45, scene)
      call check(error, trim(scene%text), 'rod, near the middle axis, at rest')
   end subroutine number_names_scene

   !> Checks the oracle against digits of an independent integration (suite `control`).
   subroutine oracle_knows_the_top(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      real(qp) :: q(4)
      problem => precessing_top()
      if (.not. has_oracle) then
         call skip_test(error, "no kind of 33 digits")
         return
      end if
      call find_true_attitude(problem%system, problem%start, 1.0_wp, q)
      call check_below(error, true_distance(q, [-0.74129324557326555_wp, 0.49974636690044272_wp, &
                                                0.015923842809073599_wp, -0.44775475884400627_wp]), 1e-13_wp, &
                       "attitude")
   end subroutine oracle_knows_the_top

   !> The first runs of `make accuracy`: as many as take some seconds.
   subroutine accuracy_is_kept(error)
      type(error_type), allocatable, intent(out) :: error
      type(outcome_t), allocatable :: outcomes(:)
      type(tally_t) :: tally
      if (.not. has_oracle) then
         call skip_test(error, "no kind of 33 digits")
         return
      end if
      call run_cases(1, share_of(160), outcomes)
      tally = tally_of(outcomes, 0)
      call check(error, tally%failed, 0, "runs failed")
      call check(error, tally%above_10, 0, "errors above ten times what was said")
      call check(error, tally%above_2 <= 1, "errors above twice what was said")
      call check_below(error, 0.85_wp*tally%runs, real(tally%in_reach, wp), "in reach")
      call check_below(error, real(tally%needlessly, wp), 0.06_wp*tally%runs, "out of reach although it was not")
   end subroutine accuracy_is_kept

   !> Runs all cases and writes the table; or one again; or those from one to another, say 2001:4000. Failures go to
   !> standard error.
   subroutine report_accuracy(argument, failures)
      !> The number of a case, or two with a colon between; else all of them.
      character(len=:), allocatable, intent(in) :: argument
      integer, intent(out) :: failures
      type(outcome_t), allocatable :: outcomes(:)
      integer :: first, last
      failures = 0
      if (.not. has_oracle) then
         write (error_unit, '(a)') 'no kind of 33 digits: nothing to compare with'
         return
      end if
      first = 1
      last = all_runs
      if (allocated(argument)) call read_numbers(argument, first, last)
      if (first < 1 .or. last < first) then
         write (error_unit, '(a)') "no case '"//argument//"'"
         failures = 1
         return
      end if
      call run_cases(first, last, outcomes)
      if (first == last) then
         failures = merge(1, 0, .not. outcomes(first)%miss() <= 2.0_wp)
      else
         call write_tables(outcomes)
         failures = failures_of(tally_of(outcomes, 0))
      end if
   end subroutine report_accuracy

   !> `N`, or `N:M`; 0 where it is neither.
   pure subroutine read_numbers(text, first, last)
      character(len=*), intent(in) :: text
      integer, intent(out) :: first, last
      integer :: colon, problem
      colon = index(text, ':')
      if (colon == 0) colon = len(text) + 1
      read (text(:colon - 1), *, iostat=problem) first
      if (problem /= 0) first = 0
      last = first
      if (colon < len(text)) read (text(colon + 1:), *, iostat=problem) last
      if (problem /= 0) last = 0
   end subroutine read_numbers

   !> Returns the number of broken bounds on many runs; each run that breaks one by itself is counted.
   pure integer function failures_of(tally) result(failures)
      type(tally_t), intent(in) :: tally
      failures = tally%failed + tally%above_10
      if (tally%above_2 > 0.005_wp*tally%runs) failures = failures + tally%above_2
      if (tally%in_reach < 0.85_wp*tally%runs) failures = failures + 1
      if (tally%needlessly > 0.06_wp*tally%runs) failures = failures + 1
   end function failures_of

   !> Runs cases of consecutive numbers. A single one is described, and those that miss, each at once.
   subroutine run_cases(first, last, outcomes)
      integer, intent(in) :: first, last
      type(outcome_t), allocatable, intent(out) :: outcomes(:)
      type(random_scene_t) :: scene
      real(qp) :: exact(4)
      integer :: i, number, known
      allocate (outcomes(first:last))
      known = 0
      do i = first, last
         number = (i - 1)/ways_per_scene + 1
         if (number /= known) then
            call make_random_scene(number, scene)
            call find_true_attitude(scene%problem%system, scene%problem%start, scene%end_time, exact)
         end if
         known = number
         call run_case(i, scene, exact, outcomes(i))
         if (first == last .or. .not. outcomes(i)%miss() <= 2.0_wp) call describe(i, outcomes(i))
      end do
   end subroutine run_cases

   !> One run: its way and its accuracy belong to its number.
   subroutine run_case(number, scene, exact, outcome)
      integer, intent(in) :: number
      type(random_scene_t), intent(in) :: scene
      real(qp), intent(in) :: exact(4)
      type(outcome_t), intent(out) :: outcome
      type(integrator_settings_t) :: settings
      type(run_plan_t) :: plan
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status
      character(len=:), allocatable :: reason
      integer(int64) :: seed
      real(wp) :: exponent
      integer :: i
      i = mod(number - 1, ways_per_scene)
      outcome%way = 1
      if (i > 0) outcome%way = turns(1 + mod(3*((number - 1)/ways_per_scene) + i - 1, size(turns)))
      seed = 15485863_int64*number
      do i = 1, 10
         exponent = random_unit(seed)
      end do
      ! Low orders get looser accuracies: otherwise they would need millions of steps.
      outcome%asked = 10.0_wp**(-3 - 9*exponent)
      if (ways(outcome%way) == 'nielsen_krenk order 2') outcome%asked = 10.0_wp**(-2 - 3*exponent)
      if (index(ways(outcome%way), 'rk4') + index(ways(outcome%way), 'order 4') > 0) &
         outcome%asked = 10.0_wp**(-3 - 5*exponent)
      settings = settings_of(ways(outcome%way))
      associate (problem => scene%problem)
         if (settings%method == AUTOMATIC_METHOD) call choose_method(problem%system, problem%start, scene%end_time, &
                                                                     outcome%asked, settings, reason)
         state = problem%start
         plan%end_time = scene%end_time
         plan%goal%accuracy = outcome%asked
         plan%max_steps = most_steps
         call integrate(problem%system, settings, state, plan, status, summary=summary)
      end associate
      outcome%given_up = status%code == NUTATE_STEP_LIMIT
      if (.not. outcome%given_up) outcome%failure = status%message
      outcome%said = summary%estimate
      outcome%true = true_distance(exact, state%q)
   end subroutine run_case

   !> Settings of a way.
   pure type(integrator_settings_t) function settings_of(way) result(settings)
      character(len=*), intent(in) :: way
      integer :: i
      i = scan(way, ' ,+')
      settings = default_settings(way(1:merge(i - 1, len_trim(way), i > 0)))
      if (index(way, '+conserve') > 0) settings%conserve = .true.
      if (index(way, 'plain') > 0) settings%conserve = .false.
      i = index(way, 'order ')
      if (i > 0) settings%order = ichar(way(i + 6:i + 6)) - ichar('0')
      if (i > 0) settings%formulation = 'reduced'
   end function settings_of

   !> True error over the larger of what was asked for and what was said.
   pure real(wp) function miss(self)
      class(outcome_t), intent(in) :: self
      miss = huge(miss)
      if (self%failure == '') miss = self%true/max(self%asked, self%said)
      if (self%given_up) miss = 0.0_wp
   end function miss

   !> Counts of the runs of a way, or of all (0).
   pure type(tally_t) function tally_of(outcomes, way) result(tally)
      type(outcome_t), intent(in) :: outcomes(:)
      integer, intent(in) :: way
      real(wp) :: smallest
      integer :: i, k
      allocate (tally%misses(0))
      do i = 1, size(outcomes)
         associate (one => outcomes(i))
            if (way /= 0 .and. one%way /= way) cycle
            tally%runs = tally%runs + 1
            if (one%failure /= '') tally%failed = tally%failed + 1
            if (.not. one%miss() <= 2.0_wp) tally%above_2 = tally%above_2 + 1
            if (.not. one%miss() <= 10.0_wp) tally%above_10 = tally%above_10 + 1
            if (one%said <= one%asked .and. .not. one%given_up) tally%in_reach = tally%in_reach + 1
            if (one%said > one%asked .and. one%true < 0.1_wp*one%asked) tally%needlessly = tally%needlessly + 1
            tally%misses = [tally%misses, one%miss()]
         end associate
      end do
      do i = 1, size(tally%misses) - 1
         k = i - 1 + minloc(tally%misses(i:), 1)
         smallest = tally%misses(k)
         tally%misses(k) = tally%misses(i)
         tally%misses(i) = smallest
      end do
   end function tally_of

   !> Writes the table of docs/results/accuracy-costs.md.
   subroutine write_tables(outcomes)
      type(outcome_t), intent(in) :: outcomes(:)
      type(tally_t) :: all
      integer :: way
      write (output_unit, '(a,/,a)') '| method | runs | h: median | h: largest | estimate within the accuracy |', &
         '|---|---|---|---|---|'
      do way = 1, n_ways
         call write_row(trim(ways(way)), tally_of(outcomes, way))
      end do
      all = tally_of(outcomes, 0)
      call write_row('all', all)
      write (output_unit, '(/,2(a,i0),a,f3.1,a)') 'All runs: h > 2 in ', all%above_2, ', h > 10 in ', all%above_10, &
         '; needless warnings in ', 100*real(all%needlessly, wp)/all%runs, ' %.'
   end subroutine write_tables

   !> Writes a row of errors over the larger of the requested and the estimated one.
   subroutine write_row(name, tally)
      character(len=*), intent(in) :: name
      type(tally_t), intent(in) :: tally
      if (tally%runs == 0) return
      associate (n => tally%runs, misses => tally%misses)
         write (output_unit, '("| ",a," | ",i0,2(" | ",es7.1)," | ",f5.1," % |")') name, n, misses((n + 1)/2), &
            misses(n), 100*real(tally%in_reach, wp)/n
      end associate
   end subroutine write_row

   !> Reports a case, its result, and the command that repeats it.
   subroutine describe(number, outcome)
      integer, intent(in) :: number
      type(outcome_t), intent(in) :: outcome
      type(random_scene_t) :: scene
      call make_random_scene((number - 1)/ways_per_scene + 1, scene)
      write (error_unit, '("case ",i0,", ",a,": asked ",es8.1,", said ",es8.1,", true ",es8.1,"; ",a,"; again: make ", &
         &"accuracy CASE=",i0,1x,a)') number, trim(ways(outcome%way)), outcome%asked, outcome%said, outcome%true, &
         trim(scene%text), number, trim(outcome%failure)
   end subroutine describe

end module test_accuracy
