!> Rotation of rigid bodies, integrated with quaternions so that energy, momentum and the unit norm hold to round-off at
!> any step size (Nielsen & Krenk 2012).
!>
!> This module has what most programs need. A body and what acts on it make a **system**; an attitude and an angular
!> velocity make a **state**; a **stepper** moves the state:
!>
!>     type(system_t) :: system
!>     type(state_t) :: state
!>     class(stepper_t), allocatable :: stepper
!>     type(status_t) :: status
!>
!>     call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], system%body, status, mass=12.0_wp)
!>     state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.0_wp, 10.0_wp])
!>     call make_stepper(system, integrator_settings_t(), stepper, status)
!>     call stepper%step(system, state, 0.01_wp, status)
!>
!> `angular_velocity`, `body_momentum`, `space_momentum`, `total_energy` read the state. Effects are added with
!> `system%effects%add(...)`: built-in ones such as `gravity_t`, or a program's own extension of `potential_t` or
!> `torque_t`.
!>
!> `integrate` runs to an end time, by fixed steps or, with a goal in place of it, by steps that keep to an
!> error:
!>
!>     call integrate(system, integrator_settings_t(), state, run_plan_t(time_step=0.01_wp, end_time=20.0_wp), status)
!>     call integrate(system, integrator_settings_t(), state, &
!>                    run_plan_t(end_time=20.0_wp, goal=run_goal_t(accuracy=1e-9_wp)), status, observer, summary)
!>
!> With a goal the method is chosen where the settings name none; `summary%settings` and `summary%choice` say which and
!> why.
!> Extend `observer_t` to receive the output rows; `run_summary_t` reports steps and errors. `run_t` exposes the same
!> run in stages: begin, find the steps, resume from a checkpoint, run to the end. `read_scene` reads all of this from
!> a file. `free_body_t` and `lagrange_top_t` are exact solutions.
!>
!> Quaternions have their scalar first and take body components to space components. SI units, radians.
!>
!> A program takes the rest from these modules, which are public as this one is:
!>
!> Mathematics and constants:
!>
!>     use nutate_attitude, only: angular_velocity_from_euler_rates, axis_angle_from_quat, euler_from_quat, &
!>        quat_from_axis_angle, quat_from_euler, quat_from_matrix, quat_from_roll_pitch_yaw, &
!>        quat_from_rotation_vector, roll_pitch_yaw_from_quat, rotation_vector_from_quat
!>     use nutate_bodies, only: BODY_MOMENTUM, BODY_RATE, SPACE_MOMENTUM
!>     use nutate_body, only: diagonal
!>     use nutate_kinds, only: pi
!>     use nutate_quaternion, only: attitude_distance, cayley_map, cross, quat_conjugate, quat_exp, quat_left_matrix, &
!>        quat_log, quat_norm, quat_normalized, quat_product, quat_right_matrix, rotate_to_body, rotate_to_space, &
!>        rotation_matrix
!>     use nutate_gravity, only: standard_gravity
!>     use nutate_orbit, only: earth_mu
!>     use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY, NUTATE_BAD_SCENE, NUTATE_IO, &
!>        NUTATE_NOT_CONVERGED, NUTATE_NOT_FINITE, NUTATE_OFF_BRANCH, NUTATE_OK, NUTATE_SINGULAR, NUTATE_STEP_LIMIT, &
!>        NUTATE_STOPPED
!>
!> Parts of effects, events and wheels:
!>
!>     use nutate_lvlh_vector, only: lvlh_vector_t
!>     use nutate_effect_list, only: effect_list_t
!>     use nutate_event, only: CROSSING, EXTREMUM, MAXIMUM, MINIMUM, SWITCH_OFF, SWITCH_ON, SWITCH_TOGGLE
!>     use nutate_geomagnetic_field, only: geomagnetic_field_t
!>     use nutate_control_law, only: BY_MAGNETORQUERS, BY_TORQUE, BY_WHEELS, DETUMBLING, POINTING
!>     use nutate_wheel_mounting, only: mount_wheels
!>     use nutate_wheel_motor, only: make_motor_table
!>
!> Calendar time, and attitudes for other programs:
!>
!>     use nutate_aem_reading, only: parse_aem, read_aem
!>     use nutate_aem_writing, only: write_aem
!>     use nutate_attitude_rows, only: attitude_rows_t
!>     use nutate_epoch, only: epoch_t, read_epoch
!>
!> Invariants, exact solutions, runs that are interrupted, and members of ensembles:
!>
!>     use nutate_archive, only: archive_t
!>     use nutate_hamiltonian, only: relative_rate, time_dependent_power
!>     use nutate_invariants, only: invariants_t
!>     use nutate_member, only: member_t
!>     use nutate_member_rows, only: run_members
!>     use nutate_progress, only: progress_t
!>     use nutate_row_layout, only: make_layout, row_layout_t
!>     use nutate_steady_top, only: sleeping_spin, steady_precession
module nutate
   use nutate_effect_base, only: effect_t
   use nutate_applied_torque, only: applied_torque_t
   use nutate_bodies, only: bodies_t
   use nutate_body, only: body_t, make_body, make_shape_body
   use nutate_center_change, only: center_change_t, make_tabulated_center
   use nutate_chaos, only: chaos_t
   use nutate_chaos_settings, only: chaos_settings_t
   use nutate_rotor, only: rotor_t
   use nutate_variation, only: attitude_variation, variation_t, inertia_variation, rate_variation
   use nutate_column_event, only: column_event_t
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_earth_field, only: earth_field_t
   use nutate_event, only: event_t
   use nutate_event_list, only: event_list_t
   use nutate_exact_free, only: free_body_t
   use nutate_exact_top, only: lagrange_top_t
   use nutate_force, only: force_t, moving_force_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, conserved_energy, kinetic_energy, make_state, &
      potential_energy, space_momentum, total_energy
   use nutate_history, only: history_t
   use nutate_inertia_change, only: inertia_change_t, make_tabulated_inertia
   use nutate_inner_sphere, only: inner_sphere_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: long, wp
   use nutate_methods, only: make_stepper
   use nutate_motion, only: motion_t
   use nutate_observer, only: observer_t, run_record_t
   use nutate_orbit, only: orbit_t
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_potential, only: potential_t
   use nutate_summary, only: run_summary_t
   use nutate_controller, only: controller_t
   use nutate_controller_mounting, only: add_controller
   use nutate_rotating_frame, only: frame_at_latitude, rotating_frame_t
   use nutate_run, only: integrate, run_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_scene, only: parse_scene, read_scene, scene_t
   use nutate_spring, only: spring_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t
   use nutate_system, only: system_t
   use nutate_tabulated_torque, only: make_tabulated_torque, tabulated_torque_t
   use nutate_tangent, only: tangent_t
   use nutate_propagated, only: propagated_t
   use nutate_third_degree, only: third_degree_t
   use nutate_timed_force, only: timed_force_t
   use nutate_torque, only: torque_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_inner_sphere, add_wheel
   implicit none
   public
end module nutate
