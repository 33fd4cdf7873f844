!> Suites of bodies, attitudes, closed solutions, effects, scenes and runs.
module suites_of_runs
   use test_accuracy, only: collect_accuracy
   use test_archive, only: collect_archive
   use test_attitude, only: collect_attitude
   use test_baselines, only: collect_baselines
   use test_bodies, only: collect_bodies
   use test_bodies_attack, only: collect_bodies_attack
   use test_body, only: collect_body
   use test_changed_states, only: collect_changed_states
   use test_choice, only: collect_choice
   use test_composition, only: collect_composition
   use test_conservation, only: collect_conservation
   use test_conserve, only: collect_conserve
   use test_conserve_limits, only: collect_conserve_limits
   use test_control, only: collect_control
   use test_discrete_states, only: collect_discrete_states
   use test_dying_motion, only: collect_dying_motion
   use test_earth_frames, only: collect_earth_frames
   use test_effect_calls, only: collect_effect_calls
   use test_effect_columns, only: collect_effect_columns
   use test_effect_gradients, only: collect_effect_gradients
   use test_effect_physics, only: collect_effect_physics
   use test_effect_reference, only: collect_effect_reference
   use test_effects, only: collect_effects
   use test_euler, only: collect_euler
   use test_exact_elliptic, only: collect_exact_elliptic
   use test_exact_free, only: collect_exact_free
   use test_exact_round_off, only: collect_exact_round_off
   use test_exact_steady, only: collect_exact_steady
   use test_exact_top, only: collect_exact_top
   use test_exact_top_limits, only: collect_exact_top_limits
   use test_hamiltonian, only: collect_hamiltonian
   use test_heap, only: collect_heap
   use test_history, only: collect_history
   use test_jumps, only: collect_jumps
   use test_limits, only: collect_limits
   use test_literature, only: collect_literature
   use test_paper, only: collect_paper
   use test_plan, only: collect_plan
   use test_predictor, only: collect_predictor
   use test_quaternion, only: collect_quaternion
   use test_reduced, only: collect_reduced
   use test_resume, only: collect_resume
   use test_rk8, only: collect_rk8
   use test_rotating_frame, only: collect_rotating_frame
   use test_rotation, only: collect_rotation
   use test_round_off, only: collect_round_off
   use test_run, only: collect_run
   use test_scene, only: collect_scene
   use test_scene_errors, only: collect_scene_errors
   use test_scene_notation, only: collect_scene_notation
   use test_shipped_scenes, only: collect_shipped_scenes
   use test_step, only: collect_step
   use test_threads, only: collect_threads
   use test_rotating_tops, only: collect_rotating_tops
   use test_work_precision, only: collect_work_precision
   use testdrive, only: new_testsuite, testsuite_type
   implicit none
   private

   public :: run_suites

contains

   !> The suites, by name.
   function run_suites() result(suites)
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("accuracy", collect_accuracy), &
         new_testsuite("bodies", collect_bodies), &
         new_testsuite("bodies_attack", collect_bodies_attack), &
         new_testsuite("archive", collect_archive), &
         new_testsuite("attitude", collect_attitude), &
         new_testsuite("baselines", collect_baselines), &
         new_testsuite("rk8", collect_rk8), &
         new_testsuite("body", collect_body), &
         new_testsuite("changed_states", collect_changed_states), &
         new_testsuite("choice", collect_choice), &
         new_testsuite("composition", collect_composition), &
         new_testsuite("conservation", collect_conservation), &
         new_testsuite("conserve", collect_conserve), &
         new_testsuite("conserve_limits", collect_conserve_limits), &
         new_testsuite("control", collect_control), &
         new_testsuite("discrete_states", collect_discrete_states), &
         new_testsuite("effect_calls", collect_effect_calls), &
         new_testsuite("effect_columns", collect_effect_columns), &
         new_testsuite("effect_gradients", collect_effect_gradients), &
         new_testsuite("effect_physics", collect_effect_physics), &
         new_testsuite("effect_reference", collect_effect_reference), &
         new_testsuite("effects", collect_effects), &
         new_testsuite("euler", collect_euler), &
         new_testsuite("exact_elliptic", collect_exact_elliptic), &
         new_testsuite("exact_free", collect_exact_free), &
         new_testsuite("exact_round_off", collect_exact_round_off), &
         new_testsuite("exact_steady", collect_exact_steady), &
         new_testsuite("exact_top", collect_exact_top), &
         new_testsuite("exact_top_limits", collect_exact_top_limits), &
         new_testsuite("hamiltonian", collect_hamiltonian), &
         new_testsuite("heap", collect_heap), &
         new_testsuite("history", collect_history), &
         new_testsuite("jumps", collect_jumps), &
         new_testsuite("limits", collect_limits), &
         new_testsuite("literature", collect_literature), &
         new_testsuite("paper", collect_paper), &
         new_testsuite("plan", collect_plan), &
         new_testsuite("predictor", collect_predictor), &
         new_testsuite("quaternion", collect_quaternion), &
         new_testsuite("reduced", collect_reduced), &
         new_testsuite("resume", collect_resume), &
         new_testsuite("dying_motion", collect_dying_motion), &
         new_testsuite("earth_frames", collect_earth_frames), &
         new_testsuite("rotating_frame", collect_rotating_frame), &
         new_testsuite("rotating_tops", collect_rotating_tops), &
         new_testsuite("rotation", collect_rotation), &
         new_testsuite("round_off", collect_round_off), &
         new_testsuite("run", collect_run), &
         new_testsuite("scene", collect_scene), &
         new_testsuite("scene_errors", collect_scene_errors), &
         new_testsuite("scene_notation", collect_scene_notation), &
         new_testsuite("shipped_scenes", collect_shipped_scenes), &
         new_testsuite("step", collect_step), &
         new_testsuite("threads", collect_threads), &
         new_testsuite("work_precision", collect_work_precision)]
   end function run_suites

end module suites_of_runs
