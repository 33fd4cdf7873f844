!> Numbers that each key promises to accept and to reject, in whichever way it is given.
module test_limit_promises
   use nutate_kinds, only: wp
   use test_limit_text, only: setting_t
   implicit none
   private

   public :: promise_t, of_bodies, of_potentials, of_torques, of_orbits, of_fields, of_wheels, of_controllers, &
      of_starts, of_settings, of_events, of_fits, of_tangents

   !> Numbers that a key admits for one of its numbers while the others stay: sizes from least to greatest, zero, and
   !> others.
   type :: promise_t
      type(setting_t) :: setting
      !> Index of the number that is tried; 0: all of them together.
      integer :: which = 1
      real(wp) :: least = 1e-300_wp, greatest = 1e100_wp
      logical :: zero = .true., negative = .true., infinite = .false.
      !> A program carries the number from call to call, so that it may have decayed to any size: C and FORTRAN 77 take
      !> it below `least` too.
      logical :: from_calls = .false.
      !> C says by 0, FORTRAN 77 by 0 or a negative number, that it is not given.
      logical :: c_leaves_out = .false., f77_leaves_out = .false.
      !> C and FORTRAN 77 do not have it.
      logical :: text_only = .false.
      !> Without an end: C says so by infinity of this sign; 0: it has an end.
      integer :: c_open_end = 0
   end type promise_t

contains

   !> Returns the promise of a key with the numbers that stay; one of them may be any number.
   pure type(promise_t) function any_number(group, key, values, which) result(promise)
      character(len=*), intent(in) :: group, key
      real(wp), intent(in) :: values(:)
      integer, intent(in), optional :: which
      promise%setting%group = group
      promise%setting%key = key
      promise%setting%n = size(values)
      promise%setting%values(1:size(values)) = values
      if (present(which)) promise%which = which
   end function any_number

   !> Returns the promise of a key whose number is a size: positive, and not negligible.
   pure type(promise_t) function positive(group, key, values, which, least, greatest) result(promise)
      character(len=*), intent(in) :: group, key
      real(wp), intent(in) :: values(:)
      integer, intent(in), optional :: which
      real(wp), intent(in), optional :: least, greatest
      promise = any_number(group, key, values, which)
      promise%zero = .false.
      promise%negative = .false.
      promise%least = 1e-100_wp
      if (present(least)) promise%least = least
      if (present(greatest)) promise%greatest = greatest
   end function positive

   pure function of_bodies() result(promises)
      type(promise_t) :: promises(10)
      real(wp), parameter :: sphere(6) = [1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      promises(1) = positive('body', 'inertia', sphere(1:3), which=0)
      promises(2) = any_number('body', 'inertia_tensor', sphere, which=4)
      ! Beyond half of its moments no body has such a tensor.
      promises(2)%greatest = 0.5_wp
      promises(3) = any_number('body', 'inertia_tensor', sphere, which=6)
      promises(3)%greatest = 0.5_wp
      promises(4) = positive('body', 'mass', [1.0_wp])
      promises(4)%c_leaves_out = .true.
      promises(5) = any_number('body', 'center_of_mass', sphere(4:6), which=1)
      promises(6) = any_number('body', 'center_of_mass', sphere(4:6), which=3)
      promises(7) = positive('body', 'size', sphere(1:3), which=0, least=1e-30_wp, greatest=1e30_wp)
      ! Small and large boxes, in which masses and moments stay within their own limits.
      promises(8) = positive('body', 'density', [1.0_wp], greatest=1e85_wp)
      promises(8)%setting%edge = 1e3_wp
      promises(9) = positive('body', 'density', [1.0_wp], least=1e-94_wp)
      promises(9)%setting%edge = 0.1_wp
      promises(10) = positive('body', 'inertia_scale', [1.0_wp])
      promises(10)%text_only = .true.
      promises%setting%omega(3) = 0.25_wp
   end function of_bodies

   pure function of_potentials() result(promises)
      type(promise_t) :: promises(12)
      real(wp), parameter :: zero(3) = 0.0_wp, up(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      integer :: i
      promises(1) = any_number('gravity', 'acceleration', zero, 1)
      promises(2) = any_number('gravity', 'acceleration', zero, 3)
      promises(3) = any_number('dipole', 'moment', zero, 2)
      promises(4) = any_number('dipole', 'field', zero, 3)
      ! A direction: one component must be there.
      promises(5) = any_number('gravity_gradient', 'direction', up, 1)
      promises(6) = any_number('gravity_gradient', 'direction', zero, 1)
      promises(6)%least = 1e-100_wp
      promises(6)%zero = .false.
      promises(7) = any_number('gravity_gradient', 'strength', [1.0_wp])
      promises(8) = any_number('spring', 'body_point', zero, 1)
      promises(9) = any_number('spring', 'anchor', zero, 2)
      promises(10) = any_number('spring', 'rest_length', zero(1:1))
      promises(10)%negative = .false.
      promises(11) = any_number('spring', 'stiffness', zero(1:1))
      promises(12) = any_number('gravity_gradient', 'direction', zero, 0)
      promises(12)%least = 1e-100_wp
      promises(12)%zero = .false.
      ! The spring is so weak that the longest one has an energy within its limit.
      do i = 8, 10
         promises(i)%setting%stiffness = 1e-150_wp
      end do
   end function of_potentials

   pure function of_torques() result(promises)
      type(promise_t) :: promises(13)
      real(wp), parameter :: zero(3) = 0.0_wp
      promises(1) = any_number('damping', 'coefficient', zero, 3)
      promises(2) = any_number('torque', 'body', zero, 1)
      promises(3) = any_number('torque', 'space', zero, 2)
      promises(4) = any_number('torque', 'frequency', zero(1:1))
      promises(5) = any_number('torque', 'phase', zero(1:1))
      promises(6) = any_number('torque', 'start', zero(1:1))
      promises(7) = any_number('torque', 'stop', zero(1:1))
      promises(6)%c_open_end = -1
      promises(7)%c_open_end = 1
      promises(8) = any_number('rotor', 'momentum', zero, 1)
      ! |p| is twice the momentum.
      promises(8)%greatest = 0.5e100_wp
      promises(9) = any_number('rotating_frame', 'rate', zero, 2)
      ! 1e8 rad in a step.
      promises(9)%greatest = 1e58_wp
      promises(9)%setting%time_step = 1e-50_wp
      promises(10) = any_number('rotating_frame', 'latitude', zero(1:1))
      promises(10)%greatest = 2*atan(1.0_wp)
      promises(11) = any_number('inertia_rate', 'tensor', [zero, zero], 4)
      promises(12) = any_number('inertia_rate', 'start', zero(1:1))
      promises(13) = any_number('inertia_rate', 'stop', zero(1:1))
      promises(11:13)%text_only = .true.
   end function of_torques

   pure function of_orbits() result(promises)
      type(promise_t) :: promises(13)
      real(wp), parameter :: zero(3) = 0.0_wp
      promises(1) = positive('orbit', 'semi_major_axis', [1.0_wp], least=1e-30_wp, greatest=1e30_wp)
      promises(2) = positive('orbit', 'altitude', [1.0_wp], least=1e-30_wp, greatest=1e30_wp)
      promises(3) = any_number('orbit', 'eccentricity', zero(1:1))
      promises(3)%negative = .false.
      promises(3)%greatest = 1 - epsilon(1.0_wp)/2
      promises(4) = any_number('orbit', 'inclination', zero(1:1))
      promises(5) = any_number('orbit', 'raan', zero(1:1))
      promises(6) = any_number('orbit', 'argument_of_periapsis', zero(1:1))
      promises(7) = any_number('orbit', 'mean_anomaly', zero(1:1))
      promises(8) = positive('orbit', 'mu', [1.0_wp])
      promises(9) = any_number('initial', 'roll_pitch_yaw', zero, 2)
      promises(10) = any_number('orbit', 'sun', zero, 1)
      promises(10)%least = 1e-100_wp
      promises(10)%zero = .false.
      promises(11) = positive('orbit', 'shadow_radius', [1.0_wp], least=1e-30_wp, greatest=1e30_wp)
      promises(12) = positive('orbit', 'periapsis_distance', [1.0_wp], least=1e-30_wp, greatest=1e30_wp)
      promises(13) = any_number('orbit', 'periapsis_time', zero(1:1))
      promises%text_only = .true.
   end function of_orbits

   !> The field of the Earth, far away from it, and forces.
   pure function of_fields() result(promises)
      type(promise_t) :: promises(9)
      real(wp), parameter :: zero(3) = 0.0_wp
      promises(1) = any_number('earth_field', 'moment', zero, 2)
      promises(2) = any_number('earth_field', 'epoch_angle', zero(1:1))
      promises(3) = any_number('earth_field', 'coefficients', zero, 3)
      promises(4) = any_number('force', 'body_point', zero, 1)
      promises(5) = any_number('force', 'force', zero, 2)
      promises(6) = any_number('force', 'start', zero(1:1))
      promises(7) = any_number('force', 'stop', zero(1:1))
      promises(8) = any_number('third_degree', 'third_moments', spread(0.0_wp, 1, 10), 2)
      ! Two points, whose third powers count.
      promises(9) = any_number('third_degree', 'points', [1.0_wp, zero, 3.0_wp, zero], 2)
      promises(9)%greatest = 1e10_wp
      promises%text_only = .true.
   end function of_fields

   pure function of_wheels() result(promises)
      type(promise_t) :: promises(15)
      real(wp), parameter :: zero(1) = 0.0_wp, up(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      promises(1) = any_number('wheel', 'axis', [0.0_wp, 0.0_wp, 0.0_wp], 2)
      promises(1)%least = 1e-100_wp
      promises(1)%zero = .false.
      promises(2) = any_number('wheel', 'axis', up, 1)
      ! The inertia of a wheel is a part of the body's.
      promises(3) = positive('wheel', 'inertia', [1.0_wp], greatest=1.5_wp)
      promises(4) = any_number('wheel', 'speed', zero)
      ! Jw ω², Jw = 0.4 kg m², is below the limit of energies.
      promises(4)%greatest = 1.5e50_wp
      promises(5) = any_number('wheel', 'torque', zero)
      promises(6) = any_number('wheel', 'friction', zero)
      promises(6)%negative = .false.
      ! At 3 rad/s its torque is at the limit.
      promises(6)%greatest = 0.3e100_wp
      promises(7) = any_number('wheel', 'frequency', zero)
      promises(8) = any_number('wheel', 'start', zero)
      promises(9) = any_number('wheel', 'stop', zero)
      promises(10) = any_number('wheel', 'phase', zero)
      ! Above the torque of the sample, and its speed.
      promises(11) = positive('wheel', 'torque_limit', [1.0_wp], least=0.5_wp)
      promises(12) = positive('wheel', 'speed_limit', [4.0_wp], least=3.0_wp)
      ! Momentum, friction and energy of a sphere at rates of 1.6 rad/s are below their limits.
      promises(13) = positive('inner_sphere', 'inertia', [1.0_wp], greatest=0.49e100_wp)
      promises(14) = positive('inner_sphere', 'damping', [1.0_wp], greatest=0.9e100_wp)
      promises(15) = any_number('inner_sphere', 'angular_velocity', [0.0_wp, 0.0_wp, 0.0_wp], 2)
      promises(15)%greatest = 1.1e50_wp
      promises(12:15)%text_only = .true.
      promises%setting%inertia = 2.0_wp
   end function of_wheels

   pure function of_controllers() result(promises)
      type(promise_t) :: promises(12)
      real(wp), parameter :: zero(3) = 0.0_wp, unit(4) = [1.0_wp, zero]
      ! The sample is one of B-dot for the field and the gain.
      promises(1) = any_number('controller', 'attitude_gain', zero(1:1))
      promises(2) = any_number('controller', 'rate_gain', zero(1:1))
      promises(1:2)%negative = .false.
      promises(3) = any_number('controller', 'target', unit, 2)
      promises(3)%greatest = 1e-3_wp
      promises(4) = positive('controller', 'sample', [1.0_wp], least=1e-50_wp)
      promises(5) = positive('controller', 'limit', [1.0_wp])
      promises(4:5)%text_only = .true.
      promises(6) = any_number('controller', 'start', zero(1:1))
      promises(7) = any_number('controller', 'stop', zero(1:1))
      promises(8) = any_number('controller', 'field', [zero(1:2), 1.0_wp], 1)
      promises(8)%greatest = 1e50_wp
      promises(9) = any_number('controller', 'gain', zero(1:1))
      promises(9)%negative = .false.
      promises(10) = any_number('controller', 'attitude_gain_matrix', zero, which=2)
      promises(11) = any_number('controller', 'rate_gain_matrix', zero, which=3)
      promises(12) = positive('controller', 'inertia', [1.0_wp, 1.0_wp, 1.0_wp], which=0)
      promises(10:12)%text_only = .true.
   end function of_controllers

   pure function of_starts() result(promises)
      type(promise_t) :: promises(14)
      real(wp), parameter :: zero(3) = 0.0_wp
      promises(1) = any_number('initial', 'quaternion', [1.0_wp, zero], 1)
      promises(1)%least = 1.0_wp - 1e-6_wp
      promises(1)%greatest = 1.0_wp + 1e-6_wp
      promises(1)%zero = .false.
      promises(2) = any_number('initial', 'quaternion', [1.0_wp, zero], 3)
      promises(2)%greatest = 1e-3_wp
      promises(2)%from_calls = .true.
      promises(3) = any_number('initial', 'axis', zero, 1)
      promises(3)%least = 1e-100_wp
      promises(3)%zero = .false.
      promises(4) = any_number('initial', 'axis', [zero(1:2), 1.0_wp], 2)
      promises(5) = any_number('initial', 'angle', zero(1:1))
      promises(6) = any_number('initial', 'euler', zero, 2)
      ! Beside another component: a momentum of nothing but denormal numbers has lost digits.
      promises(7) = any_number('initial', 'euler_rates', [1.0_wp, zero(1:2)], 2)
      promises(8) = any_number('initial', 'angular_velocity', [1.0_wp, zero(1:2)], 3)
      promises(4:8)%from_calls = .true.
      ! |p||Ω| = 2JΩ² is at the limit of energies; steps are short enough to follow.
      promises(7:8)%greatest = sqrt(5.0_wp)*1e50_wp
      promises(7:8)%setting%time_step = 1e-45_wp
      promises(9) = positive('initial', 'precession_period', [1.0_wp], least=1e-40_wp)
      promises(9)%setting%time_step = 1e-45_wp
      ! The body has a short-axis mode with E/E0 from 1 to 1.25, and with P_psi from 0.263 on if P_phi is 0.1.
      promises(10) = positive('initial', 'rotation_period', [1.0_wp], least=0.5_wp, greatest=2.0_wp)
      promises(11) = positive('initial', 'energy_ratio', [1.1_wp], least=1.0_wp, greatest=1.2_wp)
      promises(12) = any_number('initial', 'pole', zero(1:2), 2)
      promises(12)%greatest = 2*atan(1.0_wp)
      promises(13) = any_number('initial', 'precession_angle', zero(1:1))
      promises(14) = any_number('initial', 'rotation_phase', zero(1:1))
      promises(9:14)%text_only = .true.
   end function of_starts

   pure function of_settings() result(promises)
      type(promise_t) :: promises(9)
      real(wp), parameter :: below_one = nearest(1.0_wp, -1.0_wp)
      promises(1) = any_number('integrator', 'time_step', [1.0_wp])
      promises(1)%least = 1e-50_wp
      promises(1)%greatest = 1e50_wp
      promises(1)%zero = .false.
      promises(1)%setting%omega(3) = 1e-50_wp
      ! The first time is 0. Fewer than 9e15 steps of 0.01 s.
      promises(2) = positive('integrator', 'end_time', [1.0_wp], greatest=9e13_wp)
      promises(2)%from_calls = .true.
      promises(2)%c_leaves_out = .true.
      promises(3) = positive('integrator', 'accuracy', [1.0_wp], greatest=below_one)
      promises(4) = positive('integrator', 'local_tolerance', [1.0_wp], greatest=below_one)
      promises(5) = positive('integrator', 'tolerance', [1.0_wp], greatest=below_one)
      promises(6) = positive('integrator', 'auxiliary_inertia', [1.0_wp])
      promises(6)%infinite = .true.
      promises(6)%f77_leaves_out = .true.
      ! Fewer than 9e15 rows in 0.08 s.
      promises(7) = positive('output', 'interval', [1.0_wp], least=1e-17_wp)
      promises(7)%c_leaves_out = .true.
      ! Times of the run, of 0.08 s.
      promises(8) = any_number('output', 'times', [0.0_wp])
      promises(8)%greatest = 0.08_wp
      promises(8)%negative = .false.
      promises(8)%text_only = .true.
      promises(9) = positive('integrator', 'max_step', [1.0_wp])
      promises(9)%text_only = .true.
   end function of_settings

   pure function of_events() result(promises)
      type(promise_t) :: promises(8)
      promises(1) = any_number('event', 'crosses', [0.0_wp])
      promises(2) = any_number('event', 'weights', [1.0_wp])
      promises(3) = positive('event', 'modulo', [1.0_wp])
      promises(4) = any_number('vary', 'low', [0.0_wp])
      promises(5) = any_number('vary', 'high', [0.0_wp])
      promises(6) = any_number('vary', 'mean', [0.0_wp])
      promises(7) = any_number('vary', 'sigma', [0.0_wp])
      promises(8) = any_number('vary', 'covariance', [0.0_wp])
      promises(7:8)%negative = .false.
      ! Only scenes have them.
      promises%text_only = .true.
   end function of_events

   pure function of_fits() result(promises)
      type(promise_t) :: promises(5)
      promises(1) = positive('free', 'sigma', [1.0_wp])
      promises(2) = any_number('free', 'low', [0.0_wp])
      promises(3) = any_number('free', 'high', [0.0_wp])
      promises(4) = positive('measurement', 'sigma', [1.0_wp])
      promises(5) = any_number('measurement', 'direction', [0.0_wp, 0.0_wp, 1.0_wp])
      ! Only scenes have them.
      promises%text_only = .true.
   end function of_fits

   pure function of_tangents() result(promises)
      type(promise_t) :: promises(2)
      promises(1) = any_number('chaos', 'vector', [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], 2)
      promises(2) = positive('chaos', 'momentum_scale', [1.0_wp])
      ! Only scenes have them.
      promises%text_only = .true.
   end function of_tangents

end module test_limit_promises
