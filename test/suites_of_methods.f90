!> Suites of the methods: series, the true root of a step, dense output and events, fits, hard cases.
module suites_of_methods
   use testdrive, only: new_testsuite, testsuite_type, unittest_type
   implicit none
   private

   public :: method_suites

   interface
      module subroutine collect_attack(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_attack
      module subroutine collect_axial_frame(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_axial_frame
      module subroutine collect_bounds(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_bounds
      module subroutine collect_dense_output(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_dense_output
      module subroutine collect_equal_steps(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_equal_steps
      module subroutine collect_event_switches(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_event_switches
      module subroutine collect_events(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_events
      module subroutine collect_fit(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_fit
      module subroutine collect_least_squares(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_least_squares
      module subroutine collect_motion_bounds(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_motion_bounds
      module subroutine collect_root_proof(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_root_proof
      module subroutine collect_series(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_series
      module subroutine collect_series_tail(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_series_tail
      module subroutine collect_step_tolerance(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_step_tolerance
      module subroutine collect_taylor(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_taylor
      module subroutine collect_taylor_steps(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_taylor_steps
      module subroutine collect_uncertified(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_uncertified
   end interface

contains

   !> The suites, by name.
   function method_suites() result(suites)
      use test_event_attack, only: collect_event_attack
      use test_path_attack, only: collect_path_attack
      use test_stability_axes, only: collect_stability_axes
      use test_stability_columns, only: collect_stability_columns
      use test_stability_large_steps, only: collect_stability_large_steps
      use test_stability_long, only: collect_stability_long
      use test_stability_scales, only: collect_stability_scales
      use test_stability_starts, only: collect_stability_starts
      use test_stability_stiff, only: collect_stability_stiff
      use test_stability_time, only: collect_stability_time
      use test_stability_top, only: collect_stability_top
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("axial_frame", collect_axial_frame), &
         new_testsuite("series", collect_series), &
         new_testsuite("series_tail", collect_series_tail), &
         new_testsuite("taylor", collect_taylor), &
         new_testsuite("taylor_steps", collect_taylor_steps), &
         new_testsuite("step_tolerance", collect_step_tolerance), &
         new_testsuite("equal_steps", collect_equal_steps), &
         new_testsuite("attack", collect_attack), &
         new_testsuite("motion_bounds", collect_motion_bounds), &
         new_testsuite("event_attack", collect_event_attack), &
         new_testsuite("path_attack", collect_path_attack), &
         new_testsuite("bounds", collect_bounds), &
         new_testsuite("root_proof", collect_root_proof), &
         new_testsuite("uncertified", collect_uncertified), &
         new_testsuite("fit", collect_fit), &
         new_testsuite("least_squares", collect_least_squares), &
         new_testsuite("dense_output", collect_dense_output), &
         new_testsuite("event_switches", collect_event_switches), &
         new_testsuite("events", collect_events), &
         new_testsuite("stability_axes", collect_stability_axes), &
         new_testsuite("stability_columns", collect_stability_columns), &
         new_testsuite("stability_large_steps", collect_stability_large_steps), &
         new_testsuite("stability_long", collect_stability_long), &
         new_testsuite("stability_scales", collect_stability_scales), &
         new_testsuite("stability_starts", collect_stability_starts), &
         new_testsuite("stability_stiff", collect_stability_stiff), &
         new_testsuite("stability_time", collect_stability_time), &
         new_testsuite("stability_top", collect_stability_top)]
   end function method_suites

end module suites_of_methods
