!> A cone on its tip that precesses steadily, run by `integrate`; its precession rate against the exact 10 rad/s.
module precession_meter
   use nutate, only: observer_t, run_record_t, state_t, status_t, system_t, wp
   use nutate_kinds, only: pi
   use nutate_quaternion, only: rotate_to_space
   implicit none
   private
   public :: precession_meter_t

   !> Follows the azimuth of the body's axis 3 from step to step.
   type, extends(observer_t) :: precession_meter_t
      !> Azimuth, rad, continuous; and its first value.
      real(wp) :: azimuth = 0.0_wp, first = 0.0_wp
      logical :: started = .false.
   contains
      procedure :: observe
   end type precession_meter_t

contains

   subroutine observe(self, system, state, record, status)
      class(precession_meter_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      real(wp) :: axis(3), angle
      axis = rotate_to_space(state%q, [0.0_wp, 0.0_wp, 1.0_wp])
      angle = atan2(axis(2), axis(1))
      if (.not. self%started) then
         self%started = .true.
         self%first = angle
         self%azimuth = angle
      else
         self%azimuth = angle + 2*pi*nint((self%azimuth - angle)/(2*pi))
      end if
   end subroutine observe

end module precession_meter

program top_precession
   use nutate, only: gravity_t, integrate, integrator_settings_t, make_shape_body, make_state, run_plan_t, state_t, &
      status_t, system_t, wp
   use nutate_attitude, only: quat_from_euler
   use nutate_kinds, only: pi
   use precession_meter, only: precession_meter_t
   implicit none
   type(system_t) :: system
   type(state_t) :: state
   type(precession_meter_t) :: meter
   type(status_t) :: status
   real(wp) :: dt, rate
   integer :: k

   ! Radius 5 cm, height 10 cm, 2700 kg/m3, tip at the reference point; theta = 60 degrees, spin 135.6 rad/s.
   call make_shape_body('cone', [0.05_wp, 0.1_wp], system%body, status, density=2700.0_wp, &
                        center_of_mass=[0.0_wp, 0.0_wp, 0.075_wp])
   call system%effects%add(gravity_t(system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
   print '(a)', 'time step   precession (rad/s)   error'
   do k = 0, 3
      dt = 0.002_wp/2**k
      meter = precession_meter_t()
      state = make_state(system, quat_from_euler(0.0_wp, pi/3, 0.0_wp), [0.0_wp, 10*sin(pi/3), 140.6_wp])
      call integrate(system, integrator_settings_t(), state, run_plan_t(time_step=dt, end_time=2.0_wp), status, meter)
      if (.not. status%ok()) print '(a)', trim(status%message)
      rate = (meter%azimuth - meter%first)/2
      print '(f9.5,f16.8,es15.2)', dt, rate, rate - 10
   end do
end program top_precession
