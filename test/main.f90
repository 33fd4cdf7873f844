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
   use testdrive, only: get_argument, new_testsuite, run_selected, run_testsuite, select_suite, testsuite_type, &
      unittest_type
   use test_accuracy, only: collect_accuracy, read_numbers, report_accuracy
   use test_archive, only: collect_archive
   use test_attack, only: collect_attack
   use test_attack_report, only: repeat_case, report_attack
   use test_event_attack, only: collect_event_attack, report_event_attack
   use test_path_attack, only: collect_path_attack, report_path_attack
   use test_attitude, only: collect_attitude
   use test_axial_frame, only: collect_axial_frame
   use test_baselines, only: collect_baselines
   use test_bodies, only: collect_bodies
   use test_bodies_attack, only: collect_bodies_attack
   use test_body, only: collect_body
   use test_bounds, only: collect_bounds
   use test_c_bodies, only: collect_c_bodies
   use test_c_events, only: collect_c_events
   use test_c_interface, only: collect_c_interface
   use test_c_runs, only: collect_c_runs
   use test_c_exchange, only: collect_c_exchange
   use test_c_satellites, only: collect_c_satellites
   use test_c_sweep, only: collect_c_sweep
   use test_classical_tops, only: collect_classical_tops
   use test_changed_states, only: collect_changed_states
   use test_choice, only: collect_choice
   use test_composition, only: collect_composition
   use test_conservation, only: collect_conservation
   use test_conserve, only: collect_conserve
   use test_conserve_limits, only: collect_conserve_limits
   use test_control, only: collect_control
   use test_random_controllers, only: collect_random_controllers
   use test_dense_output, only: collect_dense_output
   use test_discrete_states, only: collect_discrete_states
   use test_dying_motion, only: collect_dying_motion, report_dying_motion
   use test_earth_frames, only: collect_earth_frames
   use test_effect_columns, only: collect_effect_columns
   use test_effect_calls, only: collect_effect_calls
   use test_effect_gradients, only: collect_effect_gradients
   use test_effect_physics, only: collect_effect_physics
   use test_effect_reference, only: collect_effect_reference
   use test_effects, only: collect_effects
   use test_ensemble, only: collect_ensemble
   use test_euler, only: collect_euler
   use test_exchange, only: collect_exchange
   use test_event_switches, only: collect_event_switches
   use test_events, only: collect_events
   use test_exact_elliptic, only: collect_exact_elliptic
   use test_exact_free, only: collect_exact_free
   use test_exact_round_off, only: collect_exact_round_off, report_round_off
   use test_exact_steady, only: collect_exact_steady
   use test_exact_top, only: collect_exact_top
   use test_exact_top_limits, only: collect_exact_top_limits
   use test_f77, only: collect_f77
   use test_f77_arguments, only: collect_f77_arguments
   use test_f77_bodies, only: collect_f77_bodies
   use test_f77_prepared, only: collect_f77_prepared
   use test_f77_helpers, only: collect_f77_helpers
   use test_hamiltonian, only: collect_hamiltonian
   use test_fit, only: collect_fit
   use test_heap, only: collect_heap
   use test_history, only: collect_history
   use test_jumps, only: collect_jumps
   use test_least_squares, only: collect_least_squares
   use test_limits, only: collect_limits
   use test_literature, only: collect_literature
   use test_paper, only: collect_paper
   use test_periodic_start, only: collect_periodic_start
   use test_plan, only: collect_plan
   use test_predictor, only: collect_predictor
   use test_quaternion, only: collect_quaternion
   use test_random, only: collect_random
   use test_reduced, only: collect_reduced
   use test_resume, only: collect_resume
   use test_root_proof, only: collect_root_proof
   use test_moving_fields, only: collect_moving_fields
   use test_motion_bounds, only: collect_motion_bounds
   use test_moon_states, only: collect_moon_states
   use test_time_dependent, only: collect_time_dependent
   use test_near_rest, only: collect_near_rest
   use test_flyby, only: collect_flyby
   use test_orbit, only: collect_orbit
   use test_check_cases, only: collect_check_cases
   use test_third_degree, only: collect_third_degree
   use test_tumbling, only: collect_tumbling
   use test_orbit_table, only: collect_orbit_table
   use test_orbit_reference, only: collect_orbit_reference
   use test_orbit_fields, only: collect_orbit_fields
   use test_rotating_frame, only: collect_rotating_frame
   use test_rotation, only: collect_rotation
   use test_rk8, only: collect_rk8
   use test_round_off, only: collect_round_off
   use test_run, only: collect_run
   use test_saturation, only: collect_saturation
   use test_scene, only: collect_scene
   use test_scene_errors, only: collect_scene_errors
   use test_scene_notation, only: collect_scene_notation
   use test_series, only: collect_series
   use test_series_tail, only: collect_series_tail
   use test_shipped_scenes, only: collect_shipped_scenes
   use test_stability_axes, only: collect_stability_axes
   use test_stability_columns, only: collect_stability_columns
   use test_stability_large_steps, only: collect_stability_large_steps
   use test_stability_long, only: collect_stability_long
   use test_stability_scales, only: collect_stability_scales
   use test_stability_starts, only: collect_stability_starts
   use test_stability_stiff, only: collect_stability_stiff
   use test_stability_stress, only: list_groups, report_group
   use test_stability_time, only: collect_stability_time
   use test_stability_top, only: collect_stability_top
   use test_step, only: collect_step
   use test_step_tolerance, only: collect_step_tolerance
   use test_equal_steps, only: collect_equal_steps
   use test_sweep, only: collect_sweep
   use test_table_torques, only: collect_table_torques
   use test_tables, only: collect_tables
   use test_equilibria, only: collect_equilibria
   use test_linearization, only: collect_linearization
   use test_chaos, only: collect_chaos
   use test_tangent, only: collect_tangent
   use test_tangent_attack, only: collect_tangent_attack, report_tangent_attack
   use test_tangent_runs, only: collect_tangent_runs
   use test_tangent_identities, only: collect_tangent_identities
   use test_tangent_events, only: collect_tangent_events
   use test_tangent_differences, only: collect_tangent_differences
   use test_tangent_explicit, only: collect_tangent_explicit
   use test_tangent_windows, only: collect_tangent_windows
   use test_taylor, only: collect_taylor
   use test_taylor_steps, only: collect_taylor_steps
   use test_threads, only: collect_threads
   use test_torque_physics, only: collect_torque_physics
   use test_uncertified, only: collect_uncertified
   use test_controllers, only: collect_controllers
   use test_wheel_limits, only: collect_wheel_limits
   use test_wheel_reference, only: collect_wheel_reference
   use test_turning_tops, only: collect_turning_tops
   use test_wheels, only: collect_wheels
   use test_work_share, only: collect_work_share
   use test_work_precision, only: collect_work_precision
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
      type(testsuite_type), allocatable :: stability(:), roots(:), inside(:), series(:), torques(:), others(:)
      type(testsuite_type), allocatable :: ensembles(:), interop(:)
      stability = stability_suites()
      inside = inside_suites()
      roots = root_suites()
      series = series_suites()
      torques = torque_suites()
      ensembles = ensemble_suites()
      interop = interop_suites()
      others = other_suites()
      suites = [stability, roots, inside, series, torques, ensembles, interop, others]
   end subroutine list_suites

   !> The suites of ensembles.
   function ensemble_suites() result(suites)
      type(testsuite_type), allocatable :: suites(:)
      suites = [new_testsuite("ensemble", collect_ensemble), &
                new_testsuite("random", collect_random), &
                new_testsuite("sweep", collect_sweep)]
   end function ensemble_suites

   !> The suites of what C and FORTRAN 77 call, and of exchange with other programs.
   function interop_suites() result(suites)
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("c_bodies", collect_c_bodies), &
         new_testsuite("c_events", collect_c_events), &
         new_testsuite("c_interface", collect_c_interface), &
         new_testsuite("c_runs", collect_c_runs), &
         new_testsuite("exchange", collect_exchange), &
         new_testsuite("c_exchange", collect_c_exchange), &
         new_testsuite("c_satellites", collect_c_satellites), &
         new_testsuite("c_sweep", collect_c_sweep), &
         new_testsuite("f77", collect_f77), &
         new_testsuite("f77_arguments", collect_f77_arguments), &
         new_testsuite("f77_bodies", collect_f77_bodies), &
         new_testsuite("f77_prepared", collect_f77_prepared), &
         new_testsuite("f77_helpers", collect_f77_helpers)]
   end function interop_suites

   !> The suites of the Taylor series.
   function series_suites() result(suites)
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("axial_frame", collect_axial_frame), &
         new_testsuite("series", collect_series), &
         new_testsuite("series_tail", collect_series_tail), &
         new_testsuite("taylor", collect_taylor), &
         new_testsuite("taylor_steps", collect_taylor_steps), &
         new_testsuite("step_tolerance", collect_step_tolerance), &
         new_testsuite("equal_steps", collect_equal_steps)]
   end function series_suites

   !> The suites but those of the other groups: one line for each, here or there.
   function other_suites() result(suites)
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
         new_testsuite("turning_tops", collect_turning_tops), &
         new_testsuite("rotation", collect_rotation), &
         new_testsuite("round_off", collect_round_off), &
         new_testsuite("run", collect_run), &
         new_testsuite("scene", collect_scene), &
         new_testsuite("scene_errors", collect_scene_errors), &
         new_testsuite("scene_notation", collect_scene_notation), &
         new_testsuite("shipped_scenes", collect_shipped_scenes), &
         new_testsuite("step", collect_step), &
         new_testsuite("threads", collect_threads), &
         new_testsuite("work_precision", collect_work_precision) &
         ]
   end function other_suites

   !> The suites about what lies inside of steps, and about fits.
   function inside_suites() result(suites)
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("fit", collect_fit), &
         new_testsuite("least_squares", collect_least_squares), &
         new_testsuite("dense_output", collect_dense_output), &
         new_testsuite("event_switches", collect_event_switches), &
         new_testsuite("events", collect_events) &
         ]
   end function inside_suites

   !> The suites about orbits, torques of time and wheels.
   function torque_suites() result(suites)
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("orbit_fields", collect_orbit_fields), &
         new_testsuite("moving_fields", collect_moving_fields), &
         new_testsuite("moon_states", collect_moon_states), &
         new_testsuite("time_dependent", collect_time_dependent), &
         new_testsuite("near_rest", collect_near_rest), &
         new_testsuite("flyby", collect_flyby), &
        new_testsuite("orbit", collect_orbit), &
        new_testsuite("check_cases", collect_check_cases), &
        new_testsuite("third_degree", collect_third_degree), &
        new_testsuite("tumbling", collect_tumbling), &
        new_testsuite("classical_tops", collect_classical_tops), &
        new_testsuite("periodic_start", collect_periodic_start), &
        new_testsuite("orbit_table", collect_orbit_table), &
         new_testsuite("orbit_reference", collect_orbit_reference), &
         new_testsuite("table_torques", collect_table_torques), &
         new_testsuite("tables", collect_tables), &
         new_testsuite("linearization", collect_linearization), &
         new_testsuite("equilibria", collect_equilibria), &
         new_testsuite("chaos", collect_chaos), &
         new_testsuite("tangent", collect_tangent), &
         new_testsuite("tangent_events", collect_tangent_events), &
         new_testsuite("tangent_differences", collect_tangent_differences), &
         new_testsuite("tangent_identities", collect_tangent_identities), &
         new_testsuite("tangent_runs", collect_tangent_runs), &
         new_testsuite("tangent_attack", collect_tangent_attack), &
         new_testsuite("tangent_explicit", collect_tangent_explicit), &
         new_testsuite("tangent_windows", collect_tangent_windows), &
         new_testsuite("torque_physics", collect_torque_physics), &
         new_testsuite("controllers", collect_controllers), &
         new_testsuite("saturation", collect_saturation), &
         new_testsuite("wheel_limits", collect_wheel_limits), &
         new_testsuite("random_controllers", collect_random_controllers), &
         new_testsuite("wheel_reference", collect_wheel_reference), &
         new_testsuite("wheels", collect_wheels), &
         new_testsuite("work_share", collect_work_share) &
         ]
   end function torque_suites

   !> The suites about the true root of a step.
   function root_suites() result(suites)
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("attack", collect_attack), &
        new_testsuite("motion_bounds", collect_motion_bounds), &
         new_testsuite("event_attack", collect_event_attack), &
         new_testsuite("path_attack", collect_path_attack), &
         new_testsuite("bounds", collect_bounds), &
         new_testsuite("root_proof", collect_root_proof), &
         new_testsuite("uncertified", collect_uncertified) &
         ]
   end function root_suites

   !> The suites of stability cases.
   function stability_suites() result(suites)
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("stability_axes", collect_stability_axes), &
         new_testsuite("stability_columns", collect_stability_columns), &
         new_testsuite("stability_large_steps", collect_stability_large_steps), &
         new_testsuite("stability_long", collect_stability_long), &
         new_testsuite("stability_scales", collect_stability_scales), &
         new_testsuite("stability_starts", collect_stability_starts), &
         new_testsuite("stability_stiff", collect_stability_stiff), &
         new_testsuite("stability_time", collect_stability_time), &
         new_testsuite("stability_top", collect_stability_top) &
         ]
   end function stability_suites

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

   !> Runs the attack on tangent columns at full length, or one case of it; does not return.
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
