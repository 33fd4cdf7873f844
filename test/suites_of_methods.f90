!> Suites of the methods: series, the true root of a step, dense output and events, fits, hard cases.
module suites_of_methods
   use test_attack, only: collect_attack
   use test_axial_frame, only: collect_axial_frame
   use test_bounds, only: collect_bounds
   use test_dense_output, only: collect_dense_output
   use test_equal_steps, only: collect_equal_steps
   use test_event_attack, only: collect_event_attack
   use test_event_switches, only: collect_event_switches
   use test_events, only: collect_events
   use test_fit, only: collect_fit
   use test_least_squares, only: collect_least_squares
   use test_motion_bounds, only: collect_motion_bounds
   use test_path_attack, only: collect_path_attack
   use test_root_proof, only: collect_root_proof
   use test_series, only: collect_series
   use test_series_tail, only: collect_series_tail
   use test_stability_axes, only: collect_stability_axes
   use test_stability_columns, only: collect_stability_columns
   use test_stability_large_steps, only: collect_stability_large_steps
   use test_stability_long, only: collect_stability_long
   use test_stability_scales, only: collect_stability_scales
   use test_stability_starts, only: collect_stability_starts
   use test_stability_stiff, only: collect_stability_stiff
   use test_stability_time, only: collect_stability_time
   use test_stability_top, only: collect_stability_top
   use test_step_tolerance, only: collect_step_tolerance
   use test_taylor, only: collect_taylor
   use test_taylor_steps, only: collect_taylor_steps
   use test_uncertified, only: collect_uncertified
   use testdrive, only: new_testsuite, testsuite_type
   implicit none
   private

   public :: method_suites

contains

   !> The suites, by name.
   function method_suites() result(suites)
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
