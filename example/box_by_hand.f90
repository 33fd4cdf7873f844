!> Steps the free box of Nielsen & Krenk by hand: a body, a state, a stepper, a loop.
!>
!> The box rotates about its intermediate axis and tumbles; energy and angular momentum stay constant.
program box_by_hand
   use nutate, only: angular_velocity, integrator_settings_t, make_shape_body, make_state, make_stepper, &
      space_momentum, state_t, status_t, stepper_t, system_t, total_energy, wp
   implicit none
   type(system_t) :: system
   type(state_t) :: state
   class(stepper_t), allocatable :: stepper
   type(status_t) :: status
   real(wp) :: energy, momentum(3)
   integer :: i

   call make_shape_body('box', [4.0_wp, 1.0_wp, 2.0_wp], system%body, status, mass=12.0_wp)
   state = make_state(system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.1_wp, 0.0_wp, 10.0_wp])
   call make_stepper(system, integrator_settings_t(), stepper, status)
   energy = total_energy(system, state)
   momentum = space_momentum(state)

   print '(a)', '     t     omega1     omega2     omega3   energy error   momentum error'
   do i = 1, 1000
      call stepper%step(system, state, 0.01_wp, status)
      if (.not. status%ok()) exit
      if (mod(i, 50) == 0) print '(f6.2,3f11.5,2es15.2)', state%t, angular_velocity(system, state), &
         total_energy(system, state)/energy - 1, norm2(space_momentum(state) - momentum)/norm2(momentum)
   end do
   if (.not. status%ok()) print '(a)', trim(status%message)
end program box_by_hand
