!> N steps of the box without anything around them: the yardstick of `scene_overhead.sh`.   free_step N full|reduced
program free_step
   use nutate, only: integrator_settings_t, make_shape_body, make_state, make_stepper, state_t, status_t, stepper_t, &
      system_t, wp
   implicit none

   type(system_t) :: system
   type(state_t) :: state
   type(integrator_settings_t) :: settings
   class(stepper_t), allocatable :: stepper
   type(status_t) :: status
   character(len=24) :: argument
   integer :: n, i

   call get_command_argument(1, argument)
   read (argument, *) n
   call get_command_argument(2, settings%formulation)
   call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], system%body, status, mass=12.0_wp)
   state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.0_wp, 10.0_wp])
   call make_stepper(system, settings, stepper, status)
   do i = 1, n
      call stepper%step(system, state, 0.01_wp, status)
   end do
   write (*, '(es24.16)') state%q(1)
end program free_step
