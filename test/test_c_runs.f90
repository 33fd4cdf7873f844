!> The C interface: runs into histories, runs that are asked to stop, copies of steppers. The tests are in
!> `test_c_runs.c`.
submodule(suites_of_interfaces) test_c_runs
   use, intrinsic :: ieee_arithmetic, only: ieee_set_flag, ieee_set_halting_mode, ieee_usual
   use test_c_support, only: c_test, check_line
   use test_support, only: error_type, new_unittest
   implicit none

   procedure(c_test), bind(C, name='test_c_run_histories') :: test_c_run_histories
   procedure(c_test), bind(C, name='test_c_polls') :: test_c_polls
   procedure(c_test), bind(C, name='test_c_copies') :: test_c_copies
   procedure(c_test), bind(C, name='test_c_saved_steppers') :: test_c_saved_steppers
   procedure(c_test), bind(C, name='test_c_sensitivities') :: test_c_sensitivities
   procedure(c_test), bind(C, name='test_c_chaos') :: test_c_chaos
   procedure(c_test), bind(C, name='test_c_misused_runs') :: test_c_misused_runs

contains

   module procedure collect_c_runs
      testsuite = [ &
              new_unittest('histories have the rows of runs', histories_have_the_rows_of_runs), &
              new_unittest('runs end when they are asked to', runs_end_when_they_are_asked_to), &
              new_unittest('copies go on as the first', copies_go_on_as_the_first), &
              new_unittest('saved steppers go on as the first', saved_steppers_go_on_as_the_first), &
              new_unittest('runs have the derivatives of a scene', runs_have_the_derivatives_of_a_scene), &
              new_unittest('runs follow indicators of chaos', runs_follow_indicators_of_chaos), &
              new_unittest('misuse is refused', misuse_is_refused)]
   end procedure collect_c_runs

   subroutine histories_have_the_rows_of_runs(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_run_histories(), 'test_c_runs.c')
   end subroutine histories_have_the_rows_of_runs

   subroutine runs_end_when_they_are_asked_to(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_polls(), 'test_c_runs.c')
   end subroutine runs_end_when_they_are_asked_to

   subroutine copies_go_on_as_the_first(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_copies(), 'test_c_runs.c')
   end subroutine copies_go_on_as_the_first

   subroutine saved_steppers_go_on_as_the_first(error)
      type(error_type), allocatable, intent(out) :: error
      ! Damaged bytes may be a NaN that signals, and numbers that overflow.
      call ieee_set_halting_mode(ieee_usual, .false.)
      call check_line(error, test_c_saved_steppers(), 'test_c_runs.c')
      call ieee_set_flag(ieee_usual, .false.)
   end subroutine saved_steppers_go_on_as_the_first

   subroutine runs_have_the_derivatives_of_a_scene(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_sensitivities(), 'test_c_runs.c')
   end subroutine runs_have_the_derivatives_of_a_scene

   subroutine runs_follow_indicators_of_chaos(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_chaos(), 'test_c_runs.c')
   end subroutine runs_follow_indicators_of_chaos

   subroutine misuse_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_misused_runs(), 'test_c_runs.c')
   end subroutine misuse_is_refused

end submodule test_c_runs
