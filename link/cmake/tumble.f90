! A free box tumbles about its intermediate axis; its energy must not change.
program tumble
   use nutate, only: integrator_settings_t, make_shape_body, make_state, make_stepper, state_t, status_t, stepper_t, &
      system_t, total_energy, wp
   implicit none
   type(system_t) :: system
   type(state_t) :: state
   class(stepper_t), allocatable :: stepper
   type(status_t) :: status
   real(wp) :: energy
   integer :: i

   call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], system%body, status, mass=12.0_wp)
   state = make_state(system, q=[1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], omega=[0.1_wp, 0.0_wp, 10.0_wp])
   call make_stepper(system, integrator_settings_t(), stepper, status)
   energy = total_energy(system, state)
   do i = 1, 1000
      if (status%ok()) call stepper%step(system, state, 0.01_wp, status)
   end do
   print '(f0.12, a, es8.1, a)', total_energy(system, state), ' J, off by', total_energy(system, state) - energy, ' J'
   if (.not. status%ok()) error stop 1
   if (abs(total_energy(system, state) - energy) > 1e-13_wp*energy) error stop 2
end program tumble
