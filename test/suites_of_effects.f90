!> Suites of orbits, time-dependent torques, wheels, controllers, and sensitivities.
module suites_of_effects
   use test_chaos, only: collect_chaos
   use test_check_cases, only: collect_check_cases
   use test_classical_tops, only: collect_classical_tops
   use test_controllers, only: collect_controllers
   use test_equilibria, only: collect_equilibria
   use test_flyby, only: collect_flyby
   use test_linearization, only: collect_linearization
   use test_moon_states, only: collect_moon_states
   use test_moving_fields, only: collect_moving_fields
   use test_near_rest, only: collect_near_rest
   use test_orbit, only: collect_orbit
   use test_orbit_fields, only: collect_orbit_fields
   use test_orbit_reference, only: collect_orbit_reference
   use test_orbit_table, only: collect_orbit_table
   use test_periodic_start, only: collect_periodic_start
   use test_random_controllers, only: collect_random_controllers
   use test_saturation, only: collect_saturation
   use test_table_torques, only: collect_table_torques
   use test_tables, only: collect_tables
   use test_tangent, only: collect_tangent
   use test_tangent_attack, only: collect_tangent_attack
   use test_tangent_differences, only: collect_tangent_differences
   use test_tangent_events, only: collect_tangent_events
   use test_tangent_explicit, only: collect_tangent_explicit
   use test_tangent_identities, only: collect_tangent_identities
   use test_tangent_runs, only: collect_tangent_runs
   use test_tangent_windows, only: collect_tangent_windows
   use test_third_degree, only: collect_third_degree
   use test_time_dependent, only: collect_time_dependent
   use test_torque_physics, only: collect_torque_physics
   use test_tumbling, only: collect_tumbling
   use test_wheel_limits, only: collect_wheel_limits
   use test_wheel_reference, only: collect_wheel_reference
   use test_wheels, only: collect_wheels
   use test_error_weighting, only: collect_error_weighting
   use testdrive, only: new_testsuite, testsuite_type
   implicit none
   private

   public :: effect_suites

contains

   !> The suites, by name.
   function effect_suites() result(suites)
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
         new_testsuite("error_weighting", collect_error_weighting)]
   end function effect_suites

end module suites_of_effects
