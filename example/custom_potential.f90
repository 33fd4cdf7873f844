!> A user-defined potential, given by U(γ) and its gradient only: a soft wall that holds the body's axis up.
module wall_potential
   use nutate, only: potential_t, wp
   implicit none
   private
   public :: wall_t

   !> U = height exp(-γ3/width), γ the body components of the vertical: steep where axis 3 points down.
   type, extends(potential_t) :: wall_t
      real(wp) :: height = 1.0_wp, width = 0.1_wp
   contains
      procedure :: energy
      procedure :: gradient
   end type wall_t

contains

   pure real(wp) function energy(self, gamma)
      class(wall_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      energy = self%height*exp(-gamma(3)/self%width)
   end function energy

   pure function gradient(self, gamma)
      class(wall_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = [0.0_wp, 0.0_wp, -self%height/self%width*exp(-gamma(3)/self%width)]
   end function gradient

end module wall_potential

program custom_potential
   use nutate, only: gravity_t, integrator_settings_t, make_shape_body, make_state, make_stepper, space_momentum, &
      state_t, status_t, stepper_t, system_t, total_energy, wp
   use nutate_attitude, only: quat_from_euler
   use nutate_quaternion, only: rotate_to_space
   use wall_potential, only: wall_t
   implicit none
   type(system_t) :: system
   type(state_t) :: state
   class(stepper_t), allocatable :: stepper
   type(status_t) :: status
   real(wp) :: energy, momentum(3), axis(3)
   integer :: i

   ! A top that falls over, and that the wall throws back.
   call make_shape_body('cone', [0.05_wp, 0.1_wp], system%body, status, density=2700.0_wp, &
                        center_of_mass=[0.0_wp, 0.0_wp, 0.075_wp])
   call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
   call system%effects%add(wall_t(height=0.02_wp, width=0.05_wp))
   state = make_state(system, quat_from_euler(0.0_wp, 0.3_wp, 0.0_wp), [0.0_wp, 0.0_wp, 10.0_wp])
   call make_stepper(system, integrator_settings_t(), stepper, status)
   energy = total_energy(system, state)
   momentum = space_momentum(state)

   print '(a)', '     t   height of the axis   energy error   l_z error'
   do i = 1, 2000
      call stepper%step(system, state, 0.002_wp, status)
      if (.not. status%ok()) exit
      if (mod(i, 100) /= 0) cycle
      axis = rotate_to_space(state%q, [0.0_wp, 0.0_wp, 1.0_wp])
      print '(f6.2,f21.5,2es15.2)', state%t, axis(3), total_energy(system, state)/energy - 1, &
         dot_product(space_momentum(state) - momentum, [0.0_wp, 0.0_wp, 1.0_wp])/norm2(momentum)
   end do
   if (.not. status%ok()) print '(a)', trim(status%message)
end program custom_potential
