!> Suites of bodies, attitudes, closed solutions, scenes and runs.
module suites_of_runs
   use testdrive, only: new_testsuite, testsuite_type, unittest_type
   implicit none
   private

   public :: run_suites

   interface
      module subroutine collect_archive(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_archive
      module subroutine collect_attitude(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_attitude
      module subroutine collect_baselines(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_baselines
      module subroutine collect_bodies(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_bodies
      module subroutine collect_bodies_attack(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_bodies_attack
      module subroutine collect_body(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_body
      module subroutine collect_changed_states(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_changed_states
      module subroutine collect_choice(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_choice
      module subroutine collect_composition(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_composition
      module subroutine collect_conservation(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_conservation
      module subroutine collect_conserve(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_conserve
      module subroutine collect_conserve_limits(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_conserve_limits
      module subroutine collect_control(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_control
      module subroutine collect_discrete_states(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_discrete_states
      module subroutine collect_earth_frames(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_earth_frames
      module subroutine collect_euler(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_euler
      module subroutine collect_exact_elliptic(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_exact_elliptic
      module subroutine collect_exact_free(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_exact_free
      module subroutine collect_exact_steady(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_exact_steady
      module subroutine collect_exact_top(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_exact_top
      module subroutine collect_exact_top_limits(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_exact_top_limits
      module subroutine collect_hamiltonian(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_hamiltonian
      module subroutine collect_heap(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_heap
      module subroutine collect_history(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_history
      module subroutine collect_jumps(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_jumps
      module subroutine collect_limits(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_limits
      module subroutine collect_literature(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_literature
      module subroutine collect_paper(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_paper
      module subroutine collect_plan(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_plan
      module subroutine collect_predictor(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_predictor
      module subroutine collect_quaternion(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_quaternion
      module subroutine collect_reduced(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_reduced
      module subroutine collect_rk8(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_rk8
      module subroutine collect_rotating_frame(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_rotating_frame
      module subroutine collect_rotation(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_rotation
      module subroutine collect_round_off(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_round_off
      module subroutine collect_run(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_run
      module subroutine collect_run_misuse(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_run_misuse
      module subroutine collect_scene(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_scene
      module subroutine collect_scene_errors(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_scene_errors
      module subroutine collect_scene_notation(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_scene_notation
      module subroutine collect_step(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_step
      module subroutine collect_rotating_tops(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_rotating_tops
      module subroutine collect_work_precision(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_work_precision
   end interface

contains

   !> The suites, by name.
   function run_suites() result(suites)
      use test_accuracy, only: collect_accuracy
      use test_dying_motion, only: collect_dying_motion
      use test_exact_round_off, only: collect_exact_round_off
      use test_resume, only: collect_resume
      use test_shipped_scenes, only: collect_shipped_scenes
      use test_threads, only: collect_threads
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
         new_testsuite("run_misuse", collect_run_misuse), &
         new_testsuite("scene", collect_scene), &
         new_testsuite("scene_errors", collect_scene_errors), &
         new_testsuite("scene_notation", collect_scene_notation), &
         new_testsuite("shipped_scenes", collect_shipped_scenes), &
         new_testsuite("step", collect_step), &
         new_testsuite("threads", collect_threads), &
         new_testsuite("work_precision", collect_work_precision)]
   end function run_suites

end module suites_of_runs
