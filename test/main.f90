!> Runs the unit tests: all of them, one suite (`fpm test -- SUITE`) or one test (`fpm test -- SUITE "TEST"`).
!>
!> Ends with a line `N passed, N failed`; a failure makes the exit status 1.
!>
!> `--stress GROUP` runs the stability cases of a group at full length instead and writes their rows of
!> docs/results/hard-cases.csv, the total to standard error; `--stress` alone lists groups and cases (see
!> tools/tests/stress.sh).
!> `--attack SEED STAGES` does so with the attack on the true root, `--attack SEED case NUMBER` repeats one case of it
!> (see tools/tests/attack.sh). `--accuracy`
!> runs random scenes and writes the tables of docs/results/accuracy-costs.md; `--accuracy CASE` repeats one run (see
!> tools/docs/accuracy.sh). `--exact` runs random free bodies against the oracle, `--exact CASE` repeats one;
!> `--dying` does so with motions that die out.
program unit
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use testdrive, only: get_argument, run_selected, run_testsuite, select_suite, testsuite_type, &
      unittest_type
   use suites_of_effects, only: effect_suites
   use suites_of_interfaces, only: interface_suites
   use suites_of_methods, only: method_suites
   use suites_of_runs, only: run_suites
   use test_accuracy, only: read_numbers, report_accuracy
   use test_attack_report, only: repeat_case, report_attack
   use test_event_attack, only: report_event_attack
   use test_path_attack, only: report_path_attack
   use test_dying_motion, only: report_dying_motion
   use test_exact_round_off, only: report_round_off
   use test_stability_stress, only: list_groups, report_group
   use test_tangent_attack, only: report_tangent_attack
   implicit none

   integer :: tests, failures

   tests = 0
   failures = 0
   call run_what_is_asked_for(tests, failures)
   write (output_unit, '(i0," passed, ",i0," failed")') tests - failures, failures
   flush (output_unit)
   if (failures > 0) call stop_with("unit tests failed")

contains

   !> Runs what the arguments name.
   subroutine run_what_is_asked_for(tests, failures)
      integer, intent(inout) :: tests, failures
      type(testsuite_type), allocatable :: suites(:)
      character(len=:), allocatable :: suite_name, test_name
      integer :: i
      call list_suites(suites)
      call get_argument(1, suite_name)
      call get_argument(2, test_name)
      if (allocated(suite_name)) then
         if (suite_name == '--stress') call run_stress(test_name)
         if (suite_name == '--attack') call run_attack()
         if (suite_name == '--attack-events') call run_event_attack()
         if (suite_name == '--attack-paths') call run_path_attack()
         if (suite_name == '--attack-tangents') call run_tangent_attack()
         if (suite_name == '--accuracy') call run_accuracy(test_name)
         if (suite_name == '--exact') call run_exact(test_name)
         if (suite_name == '--dying') call run_dying(test_name)
      end if
      if (.not. allocated(suite_name)) then
         do i = 1, size(suites)
            call run_suite(suites(i), tests, failures)
         end do
         return
      end if
      i = select_suite(suites, suite_name)
      if (i == 0) call stop_listing(suites, suite_name)
      if (allocated(test_name)) then
         tests = 1
         call run_selected(suites(i)%collect, test_name, error_unit, failures)
         if (failures < 0) call stop_with("no test '"//test_name//"' in suite '"//suite_name//"'")
      else
         call run_suite(suites(i), tests, failures)
      end if
   end subroutine run_what_is_asked_for

   !> All suites. gfortran 12 loses the names of suites that a function returns into an array constructor.
   subroutine list_suites(suites)
      type(testsuite_type), allocatable, intent(out) :: suites(:)
      type(testsuite_type), allocatable :: methods(:), effects(:), interfaces(:), runs(:)
      methods = method_suites()
      effects = effect_suites()
      interfaces = interface_suites()
      runs = run_suites()
      suites = [methods, effects, interfaces, runs]
   end subroutine list_suites

   !> Runs one suite, adds its size to `tests` and what failed to `failures`.
   subroutine run_suite(suite, tests, failures)
      type(testsuite_type), intent(in) :: suite
      integer, intent(inout) :: tests, failures
      type(unittest_type), allocatable :: members(:)
      write (error_unit, '("# ",a)') suite%name
      call suite%collect(members)
      tests = tests + size(members)
      call run_testsuite(suite%collect, error_unit, failures, parallel=.false.)
   end subroutine run_suite

   !> Runs a group of stability cases at full length, or names the groups; does not return.
   subroutine run_stress(group)
      character(len=:), allocatable, intent(in) :: group
      integer :: runs, misses
      if (.not. allocated(group)) then
         call list_groups()
         stop
      end if
      call report_group(group, runs, misses)
      if (runs == 0) call stop_with("no group '"//group//"' of stability cases")
      write (error_unit, '(i0," passed, ",i0," failed")') runs - misses, misses
      if (misses > 0) call stop_with("stability cases failed")
      stop
   end subroutine run_stress

   !> Runs the attack on the true root at full length, or one case of it; does not return.
   subroutine run_attack()
      integer :: seed, number
      logical :: alone, passed
      call get_attack("--attack SEED STAGES | SEED case NUMBER", seed, number, alone)
      if (alone) then
         call repeat_case(seed, number, passed)
      else
         call report_attack(seed, number, passed)
      end if
      if (.not. passed) call stop_with("the attack found what must not be")
      stop
   end subroutine run_attack

   !> Runs the attack on events at full length, or one case of it; does not return.
   subroutine run_event_attack()
      integer :: seed, number
      logical :: alone, passed
      call get_attack("--attack-events SEED CASES | SEED case NUMBER", seed, number, alone)
      call report_event_attack(seed, number, alone, passed)
      if (.not. passed) call stop_with("the attack found what must not be")
      stop
   end subroutine run_event_attack

   !> Runs the attack on levels and extremes at full length, or one case of it; does not return.
   subroutine run_path_attack()
      integer :: seed, number
      logical :: alone, passed
      call get_attack("--attack-paths SEED CASES | SEED case NUMBER", seed, number, alone)
      call report_path_attack(seed, number, alone, passed)
      if (.not. passed) call stop_with("the attack found what must not be")
      stop
   end subroutine run_path_attack

   !> Runs the attack on sensitivities at full length, or one case of it; does not return.
   subroutine run_tangent_attack()
      integer :: seed, number
      logical :: alone, passed
      call get_attack("--attack-tangents SEED CASES | SEED case NUMBER", seed, number, alone)
      call report_tangent_attack(seed, number, alone, passed)
      if (.not. passed) call stop_with("the attack found what must not be")
      stop
   end subroutine run_tangent_attack

   !> The arguments of an attack: the seed, and how many cases or the number of the one that is run alone.
   subroutine get_attack(usage, seed, number, alone)
      character(len=*), intent(in) :: usage
      integer, intent(out) :: seed, number
      logical, intent(out) :: alone
      character(len=:), allocatable :: text, what, which
      integer :: io
      call get_argument(2, text)
      call get_argument(3, what)
      call get_argument(4, which)
      if (.not. (allocated(text) .and. allocated(what))) call stop_with(usage)
      alone = what == 'case'
      if (.not. allocated(which)) which = what
      read (text, *, iostat=io) seed
      if (io == 0) read (which, *, iostat=io) number
      if (io /= 0) call stop_with("the attack needs whole numbers")
   end subroutine get_attack

   !> Runs the accuracy of random scenes in full, or a case of it again; does not return.
   subroutine run_accuracy(case)
      character(len=:), allocatable, intent(in) :: case
      integer :: failures
      call report_accuracy(case, failures)
      if (failures > 0) call stop_with("the accuracy was not kept")
      stop
   end subroutine run_accuracy

   !> Runs random free bodies, or the case of a number, against the oracle; does not return.
   subroutine run_exact(case)
      character(len=:), allocatable, intent(in) :: case
      integer :: number, problem, failures
      number = 0
      problem = 0
      if (allocated(case)) read (case, *, iostat=problem) number
      if (problem /= 0 .or. (allocated(case) .and. number < 1)) call stop_with("--exact takes the number of a case")
      call report_round_off(number, number, failures)
      if (failures > 0) call stop_with("an error exceeds its estimate")
      stop
   end subroutine run_exact

   !> Runs random motions that die out, or those of a number or two, `N:M`; does not return.
   subroutine run_dying(case)
      character(len=:), allocatable, intent(in) :: case
      integer :: first, last
      logical :: passed
      first = 0
      last = 0
      if (allocated(case)) call read_numbers(case, first, last)
      if (allocated(case) .and. (first < 1 .or. last < first)) call stop_with("--dying takes N, or N:M")
      call report_dying_motion(first, last, passed)
      if (.not. passed) call stop_with("the accuracy was not kept")
      stop
   end subroutine run_dying

   subroutine stop_listing(suites, name)
      type(testsuite_type), intent(in) :: suites(:)
      character(len=*), intent(in) :: name
      integer :: i
      write (error_unit, '("The suites are:",*(1x,a))') (suites(i)%name, i=1, size(suites))
      call stop_with("no suite '"//name//"'")
   end subroutine stop_listing

   subroutine stop_with(message)
      character(len=*), intent(in) :: message
      write (error_unit, '(a)') message
      stop 1, quiet=.true.
   end subroutine stop_with

end program unit
