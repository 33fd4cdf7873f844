!> A satellite on a circular orbit, made without a scene: the gravity gradient of the orbit, three wheels, and a
!> controller that points it to the Earth by their motors, held between samples.
module pointing_rows
   use nutate, only: conserved_energy, observer_t, run_record_t, state_t, status_t, system_t, wp
   use nutate_attitude, only: roll_pitch_yaw_from_quat
   use nutate_kinds, only: pi
   use nutate_quaternion, only: quat_conjugate, quat_product
   implicit none
   private
   public :: printer_t

   !> Prints roll, pitch and yaw, the momenta of the wheels, and how well the energy balance closes.
   type, extends(observer_t) :: printer_t
      real(wp) :: first = 0.0_wp
   contains
      procedure :: observe
   end type printer_t

contains

   subroutine observe(self, system, state, record, status)
      class(printer_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      real(wp) :: energy
      energy = conserved_energy(system, state, 0.0_wp)
      if (record%step == 0) self%first = energy
      ! The space axes are inertial: the attitude relative to the LVLH frame is printed.
      associate (lvlh => system%effects%orbit%axes(state%t))
         print '(f6.0,3f11.4,3f12.5,es20.2)', state%t, &
            180/pi*roll_pitch_yaw_from_quat(quat_product(quat_conjugate(lvlh), state%q)), &
            state%wheel_momentum(1:3), energy - self%first - record%work
      end associate
   end subroutine observe

end module pointing_rows

program satellite_by_hand
   use nutate, only: add_controller, add_wheel, controller_t, integrate, integrator_settings_t, kepler_orbit_t, long, &
      make_body, make_state, orbit_t, orbital_gradient_t, run_plan_t, state_t, status_t, system_t, wheel_t, wp
   use nutate_attitude, only: quat_from_roll_pitch_yaw
   use nutate_body, only: diagonal
   use nutate_orbit, only: earth_mu
   use nutate_quaternion, only: quat_product, rotate_to_body
   use nutate_control_law, only: BY_WHEELS
   use pointing_rows, only: printer_t
   implicit none
   type(system_t) :: system
   type(state_t) :: state
   type(status_t) :: status
   type(orbit_t) :: orbit
   type(controller_t) :: controller
   type(printer_t) :: printer
   real(wp) :: attitude(4)
   integer :: i

   call make_body(diagonal([90.0_wp, 100.0_wp, 40.0_wp]), system%body, status)
   orbit = orbit_t(kepler_orbit_t(semi_major_axis=6878137.0_wp, mu=earth_mu))
   call system%effects%add(orbit)
   ! The gravity gradient acts on the whole body with its wheels locked: it is added before the wheels.
   call system%effects%add(orbital_gradient_t(system%body, orbit%path))
   do i = 1, 3
      call add_wheel(system, wheel_t(axis=merge(1.0_wp, 0.0_wp, [1, 2, 3] == i), inertia=0.05_wp, &
                                     torque_limit=0.1_wp), status)
      if (.not. status%ok()) exit
   end do
   controller%by = BY_WHEELS
   controller%attitude_gain = diagonal([0.09_wp, 0.1_wp, 0.04_wp])
   controller%rate_gain = diagonal([4.0_wp, 4.5_wp, 2.0_wp])
   controller%sample = 1.0_wp
   call controller%follow_orbit(orbit)
   if (status%ok()) call add_controller(system, controller, status)
   attitude = quat_product(orbit%axes(0.0_wp), quat_from_roll_pitch_yaw([0.2_wp, -0.3_wp, 0.5_wp]))
   ! The satellite starts at rest in the LVLH frame.
   state = make_state(system, attitude, rotate_to_body(attitude, orbit%axes_rate(0.0_wp)))

   print '(a)', '     t       roll      pitch        yaw (deg)     h1          h2          h3 (N m s)    balance (J)'
   if (status%ok()) call integrate(system, integrator_settings_t(order=4), state, &
                                   run_plan_t(time_step=2.0_wp, end_time=600.0_wp, every=25_long), status, printer)
   if (.not. status%ok()) error stop 'the run has failed'
end program satellite_by_hand
