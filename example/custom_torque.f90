!> A user-defined torque, τ(t, attitude, Ω): a controller that points the body's axis 3 upwards and stops its rotation.
module pointing_torque
   use nutate, only: torque_t, wp
   use nutate_quaternion, only: cross, rotate_to_body
   implicit none
   private
   public :: pointing_t

   !> τ = stiffness e₃×z - damping Ω from the time `start` on, z the vertical in body axes.
   type, extends(torque_t) :: pointing_t
      real(wp) :: stiffness = 1.0_wp, damping = 1.0_wp, start = 0.0_wp
   contains
      procedure :: torque
   end type pointing_t

contains

   pure function torque(self, t, q, omega) result(tau)
      class(pointing_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      real(wp), parameter :: up(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      tau = 0.0_wp
      if (t < self%start) return
      tau = self%stiffness*cross(up, rotate_to_body(q, up)) - self%damping*omega
   end function torque

end module pointing_torque

program custom_torque
   use nutate, only: angular_velocity, integrator_settings_t, make_body, make_state, make_stepper, state_t, status_t, &
      stepper_t, system_t, total_energy, wp
   use nutate_attitude, only: quat_from_euler
   use nutate_body, only: diagonal
   use nutate_kinds, only: pi
   use nutate_quaternion, only: rotate_to_space
   use pointing_torque, only: pointing_t
   implicit none
   type(system_t) :: system
   type(state_t) :: state
   class(stepper_t), allocatable :: stepper
   type(status_t) :: status
   real(wp) :: energy, work, axis(3)
   integer :: i

   call make_body(diagonal([3.0_wp, 4.0_wp, 5.0_wp]), system%body, status)
   call system%effects%add(pointing_t(stiffness=2.0_wp, damping=3.0_wp, start=5.0_wp))
   state = make_state(system, quat_from_euler(0.3_wp, 2.5_wp, 0.0_wp), [0.4_wp, -0.2_wp, 0.3_wp])
   call make_stepper(system, integrator_settings_t(), stepper, status)
   energy = total_energy(system, state)
   work = 0.0_wp

   print '(a)', '     t   tilt (deg)   |omega|         work   energy - energy(0) - work'
   do i = 1, 800
      call stepper%step(system, state, 0.05_wp, status)
      if (.not. status%ok()) exit
      work = work + sum(stepper%work)
      if (mod(i, 40) /= 0) cycle
      axis = rotate_to_space(state%q, [0.0_wp, 0.0_wp, 1.0_wp])
      print '(f6.2,f12.4,2f12.6,es20.2)', state%t, 180/pi*atan2(norm2(axis(1:2)), axis(3)), &
         norm2(angular_velocity(system, state)), work, total_energy(system, state) - energy - work
   end do
   if (.not. status%ok()) print '(a)', trim(status%message)
end program custom_torque
