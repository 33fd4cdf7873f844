!> `&chaos`: the indicators of chaos that a run computes.
module nutate_scene_chaos
   use nutate_admissible, only: ANY_DIRECTION, POSITIVE
   use nutate_chaos_settings, only: chaos_settings_t, longest_interval, most_exponents
   use nutate_variation, only: variation_t
   use nutate_keys, only: group_t, key_t, KEY_INTEGER
   use nutate_kinds, only: wp
   use nutate_method_choice, only: choose_with_tangent
   use nutate_methods, only: make_stepper
   use nutate_run_plan, only: run_plan_t
   use nutate_scene_error, only: scene_error_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t, system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: chaos_keys, build_chaos, check_chaos

contains

   !> Keys of the scene group `&chaos`.
   pure function chaos_keys() result(keys)
      type(key_t) :: keys(4)
      keys = [key_t(name='exponents', kind=KEY_INTEGER, range=POSITIVE, default='1'), &
              key_t(name='vector', least=6, most=6, range=ANY_DIRECTION, default='1, 1, 1, 1, 1, 1'), &
              key_t(name='momentum_scale', range=POSITIVE), &
              key_t(name='every', kind=KEY_INTEGER, range=POSITIVE, default='1')]
   end function chaos_keys

   !> Reads which indicators a run computes. Adaptive steps without a method in the scene get one that propagates
   !> sensitivities.
   subroutine build_chaos(group, plan, chaos, settings, error)
      type(group_t), intent(in) :: group
      type(run_plan_t), intent(in) :: plan
      type(chaos_settings_t), intent(out) :: chaos
      type(integrator_settings_t), intent(inout) :: settings
      type(scene_error_t), intent(inout) :: error
      chaos%exponents = group%whole('exponents', 1)
      chaos%vector = group%vector('vector', chaos%vector)
      chaos%momentum_scale = group%number('momentum_scale', 0.0_wp)
      chaos%every = group%whole('every', 1)
      settings%attitude = .true.
      if (plan%goal%active()) call choose_with_tangent(.true., settings)
      if (all(chaos%exponents /= [1, most_exponents])) then
         call error%raise(group%line_of('exponents'), 'exponents is neither 1 nor 6', &
                          expected='1, the largest Lyapunov exponent, or 6, all')
      else if (chaos%every > longest_interval) then
         call error%raise(group%line_of('every'), 'every is too large', expected='1 to 100 steps')
      end if
   end subroutine build_chaos

   !> Raises an error if the motion or the method has no sensitivities; performs a step with one to find out.
   subroutine check_chaos(group, system, state, plan, settings, error)
      type(group_t), intent(in) :: group
      type(system_t), intent(in) :: system
      !> Initial state.
      type(state_t), intent(in) :: state
      type(run_plan_t), intent(in) :: plan
      type(integrator_settings_t), intent(in) :: settings
      type(scene_error_t), intent(inout) :: error
      !> Length of the step relative to the end time, for adaptive steps.
      real(wp), parameter :: part_of_run = 1e-6_wp
      class(stepper_t), allocatable :: stepper
      type(variation_t) :: variation
      type(tangent_t) :: tangent
      type(state_t) :: after
      type(status_t) :: status
      real(wp) :: dt
      call tangent%begin(system, state, [variation], status)
      if (status%ok()) call make_stepper(system, settings, stepper, status)
      if (status%ok()) then
         dt = plan%time_step
         if (plan%goal%active()) dt = part_of_run*plan%end_time
         after = state
         call stepper%advance(system, after, dt, state%t + 0.5_wp*dt, status)
         ! A step that fails is reported by the run.
         if (.not. status%ok()) return
         call stepper%propagate(system, state, after, dt, state%t + 0.5_wp*dt, tangent, status)
      end if
      if (.not. status%ok()) call error%raise_status(group%line, status)
   end subroutine check_chaos

end module nutate_scene_chaos
