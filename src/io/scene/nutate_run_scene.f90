!> A scene, run from its initial state to its end time, whichever way it says how long steps are.
module nutate_run_scene
   use nutate_accuracy, only: find_error_rate
   use nutate_step_control, only: control_settings_t, integrate_controlled
   use nutate_kinds, only: wp
   use nutate_methods, only: make_stepper
   use nutate_run, only: integrate, observer_t, run_summary_t
   use nutate_scene, only: scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: run_scene

contains

   !> Runs a scene and shows its rows to an observer.
   !>
   !> Errors: those of the method, of pilot runs, of steps, and what the observer returned.
   subroutine run_scene(scene, system, observer, status)
      type(scene_t), intent(in) :: scene
      !> The scene's system, or a copy of it.
      type(system_t), intent(in) :: system
      class(observer_t), intent(inout) :: observer
      type(status_t), intent(out) :: status
      class(stepper_t), allocatable :: stepper
      type(control_settings_t) :: goal
      type(run_summary_t) :: summary
      type(state_t) :: state
      goal = scene%control
      state = scene%initial
      if (goal%accuracy > 0.0_wp) &
         call find_error_rate(system, scene%integrator, scene%initial, scene%plan, goal, status)
      if (.not. status%ok()) return
      if (goal%active()) then
         call integrate_controlled(system, scene%integrator, goal, state, scene%plan, observer, summary, status)
      else
         call make_stepper(system, scene%integrator, stepper, status)
         if (status%ok()) call integrate(system, stepper, state, scene%plan, observer, summary, status)
      end if
   end subroutine run_scene

end module nutate_run_scene
