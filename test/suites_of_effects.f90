!> Suites of effects, orbits, time-dependent torques, wheels, controllers, and sensitivities.
module suites_of_effects
   use testdrive, only: new_testsuite, testsuite_type, unittest_type
   implicit none
   private

   public :: effect_suites

   interface
      module subroutine collect_effect_calls(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_effect_calls
      module subroutine collect_effect_columns(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_effect_columns
      module subroutine collect_effect_gradients(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_effect_gradients
      module subroutine collect_effect_physics(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_effect_physics
      module subroutine collect_effect_reference(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_effect_reference
      module subroutine collect_effects(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_effects
      module subroutine collect_chaos(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_chaos
      module subroutine collect_check_cases(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_check_cases
      module subroutine collect_classical_tops(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_classical_tops
      module subroutine collect_controllers(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_controllers
      module subroutine collect_equilibria(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_equilibria
      module subroutine collect_flyby(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_flyby
      module subroutine collect_inner_sphere(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_inner_sphere
      module subroutine collect_linearization(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_linearization
      module subroutine collect_moon_states(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_moon_states
      module subroutine collect_moving_fields(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_moving_fields
      module subroutine collect_near_rest(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_near_rest
      module subroutine collect_orbit(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_orbit
      module subroutine collect_orbit_fields(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_orbit_fields
      module subroutine collect_orbit_table(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_orbit_table
      module subroutine collect_periodic_start(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_periodic_start
      module subroutine collect_reshaped_bodies(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_reshaped_bodies
      module subroutine collect_saturation(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_saturation
      module subroutine collect_table_torques(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_table_torques
      module subroutine collect_tables(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_tables
      module subroutine collect_tangent(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_tangent
      module subroutine collect_tangent_differences(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_tangent_differences
      module subroutine collect_tangent_events(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_tangent_events
      module subroutine collect_tangent_explicit(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_tangent_explicit
      module subroutine collect_tangent_windows(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_tangent_windows
      module subroutine collect_third_degree(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_third_degree
      module subroutine collect_torque_physics(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_torque_physics
      module subroutine collect_tumbling(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_tumbling
      module subroutine collect_wheel_limits(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_wheel_limits
      module subroutine collect_wheels(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_wheels
      module subroutine collect_error_weighting(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_error_weighting
   end interface

contains

   !> The suites, by name.
   function effect_suites() result(suites)
      use test_orbit_reference, only: collect_orbit_reference
      use test_random_controllers, only: collect_random_controllers
      use test_tangent_attack, only: collect_tangent_attack
      use test_tangent_identities, only: collect_tangent_identities
      use test_tangent_runs, only: collect_tangent_runs
      use test_time_dependent, only: collect_time_dependent
      use test_varying_inertia, only: collect_varying_inertia
      use test_wheel_reference, only: collect_wheel_reference
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("effect_calls", collect_effect_calls), &
         new_testsuite("effect_columns", collect_effect_columns), &
         new_testsuite("effect_gradients", collect_effect_gradients), &
         new_testsuite("effect_physics", collect_effect_physics), &
         new_testsuite("effect_reference", collect_effect_reference), &
         new_testsuite("effects", collect_effects), &
         new_testsuite("orbit_fields", collect_orbit_fields), &
         new_testsuite("moving_fields", collect_moving_fields), &
         new_testsuite("moon_states", collect_moon_states), &
         new_testsuite("time_dependent", collect_time_dependent), &
         new_testsuite("varying_inertia", collect_varying_inertia), &
         new_testsuite("reshaped_bodies", collect_reshaped_bodies), &
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
         new_testsuite("inner_sphere", collect_inner_sphere), &
         new_testsuite("error_weighting", collect_error_weighting)]
   end function effect_suites

end module suites_of_effects
