!> C interface: frames, orbits, the Earth's field, forces, wheels and controllers of a system. The functions are
!> documented in `include/nutate_satellites.h`.
module nutate_c_satellites
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_int, c_ptr, c_size_t
   use nutate_c_groups, only: add_motor_of, parse_motor_keys
   use nutate_c_handles, only: conclude, found, null_argument, system_handle_t
   use nutate_c_system, only: given
   use nutate_c_system_effects, only: add, is_finite_or_bad
   use nutate_c_text, only: lock_texts, copy_text, unlock_texts
   use nutate_keys, only: group_t, table_t
   use nutate_kinds, only: wp
   use nutate_limits, only: most_rows
   use nutate_orbit, only: earth_mu
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OK
   implicit none
   private

   public :: nutate_system_add_rotating_frame, nutate_system_add_latitude, nutate_system_add_orbit, &
      nutate_system_add_orbital_gradient, nutate_system_add_earth_field, nutate_system_add_force, &
      nutate_system_add_wheel, nutate_system_wheel_count, nutate_system_add_motor, nutate_system_add_motor_table, &
      nutate_system_add_pointing, nutate_system_add_detumbling

contains

   integer(c_int) function nutate_system_add_rotating_frame(system, rate) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: rate(3)
      type(group_t) :: group
      call group%put('rate', rate)
      code = add(system, 'rotating_frame', group, .not. present(rate))
   end function nutate_system_add_rotating_frame

   integer(c_int) function nutate_system_add_latitude(system, latitude) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), value :: latitude
      type(group_t) :: group
      call group%put('latitude', [latitude])
      code = add(system, 'rotating_frame', group, .false.)
   end function nutate_system_add_latitude

   integer(c_int) function nutate_system_add_orbit(system, semi_major_axis, eccentricity, angles, mu, inertial) &
      result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), value :: semi_major_axis, eccentricity, mu
      real(c_double), intent(in), optional :: angles(4)
      integer(c_int), intent(in), value :: inertial
      character(len=21), parameter :: names(4) = [character(len=21) :: &
                                                  'inclination', 'raan', 'argument_of_periapsis', 'mean_anomaly']
      type(group_t) :: group
      integer :: i
      call group%put('semi_major_axis', [semi_major_axis])
      call group%put('eccentricity', [eccentricity])
      if (present(angles)) then
         do i = 1, 4
            call group%put(trim(names(i)), angles(i:i))
         end do
      end if
      call group%put('mu', [merge(mu, earth_mu, given(mu))])
      if (inertial == 0 .and. .not. abs(eccentricity) > 0.0_wp) call group%put('frame', 'lvlh')
      code = add(system, 'orbit', group, .false.)
   end function nutate_system_add_orbit

   integer(c_int) function nutate_system_add_orbital_gradient(system) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      type(system_handle_t), pointer :: handle
      type(group_t) :: group
      if (.not. found(system, handle, code)) return
      if (handle%system%effects%on_orbit) then
         allocate (group%settings(0))
         code = add(system, 'gravity_gradient', group, .false.)
      else
         code = conclude(handle, fail(NUTATE_BAD_ARGUMENT, 'there is no orbit (expected nutate_system_add_orbit '// &
                                      'before)', 'system'))
      end if
   end function nutate_system_add_orbital_gradient

   integer(c_int) function nutate_system_add_earth_field(system, moment, epoch_angle, coefficients) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: moment(3), coefficients(3)
      real(c_double), intent(in), value :: epoch_angle
      type(group_t) :: group
      call group%put('moment', moment)
      call group%put('epoch_angle', [epoch_angle])
      call group%put('coefficients', coefficients)
      code = add(system, 'earth_field', group, .false.)
   end function nutate_system_add_earth_field

   integer(c_int) function nutate_system_add_force(system, body_point, force, axes, start, stop) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, axes
      real(c_double), intent(in), optional :: body_point(3), force(3)
      real(c_double), intent(in), value :: start, stop
      type(group_t) :: group
      character(len=:), allocatable :: name
      call group%put('body_point', body_point)
      call group%put('force', force)
      if (c_associated(axes)) then
         call copy_text(axes, name)
         call group%put('axes', name)
      end if
      if (is_finite_or_bad(-start)) call group%put('start', [start])
      if (is_finite_or_bad(stop)) call group%put('stop', [stop])
      code = add(system, 'force', group, .not. (present(body_point) .and. present(force) .and. c_associated(axes)))
   end function nutate_system_add_force

   integer(c_int) function nutate_system_add_wheel(system, axis, inertia, speed, friction, torque_limit, speed_limit) &
      result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: axis(3)
      real(c_double), intent(in), value :: inertia, speed, friction, torque_limit, speed_limit
      type(group_t) :: group
      call group%put('axis', axis)
      call group%put('inertia', [inertia])
      call group%put('speed', [speed])
      call group%put('friction', [friction])
      if (is_finite_or_bad(torque_limit)) call group%put('torque_limit', [torque_limit])
      if (is_finite_or_bad(speed_limit)) call group%put('speed_limit', [speed_limit])
      code = add(system, 'wheel', group, .not. present(axis))
   end function nutate_system_add_wheel

   integer(c_int) function nutate_system_wheel_count(system, n) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      integer(c_size_t), intent(inout), optional :: n
      type(system_handle_t), pointer :: handle
      if (.not. found(system, handle, code)) return
      if (present(n)) then
         n = handle%system%effects%n_reaction_wheels
         code = NUTATE_OK
      else
         code = NUTATE_BAD_ARGUMENT
      end if
   end function nutate_system_wheel_count

   integer(c_int) function nutate_system_add_motor(system, wheel, torque, frequency, phase, start, stop) result(code) &
      bind(C)
      type(c_ptr), intent(in), value :: system
      integer(c_size_t), intent(in), value :: wheel
      real(c_double), intent(in), value :: torque, frequency, phase, start, stop
      type(system_handle_t), pointer :: handle
      type(group_t) :: group
      type(status_t) :: status
      if (.not. found(system, handle, code)) return
      call group%put('torque', [torque])
      call group%put('frequency', [frequency])
      call group%put('phase', [phase])
      if (is_finite_or_bad(-start)) call group%put('start', [start])
      if (is_finite_or_bad(stop)) call group%put('stop', [stop])
      call lock_texts()
      call add_motor_of(group, wheel, handle%system, status)
      call unlock_texts()
      code = conclude(handle, status)
   end function nutate_system_add_motor

   integer(c_int) function nutate_system_add_motor_table(system, wheel, n, t, torque, keys) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, keys
      integer(c_size_t), intent(in), value :: wheel, n
      real(c_double), intent(in), optional :: t(n), torque(n)
      type(system_handle_t), pointer :: handle
      type(group_t) :: group
      type(table_t) :: table
      type(status_t) :: status
      character(len=:), allocatable :: text
      integer :: failed
      if (.not. found(system, handle, code)) return
      if (.not. (present(t) .and. present(torque))) then
         code = conclude(handle, null_argument('t or torque'))
         return
      end if
      failed = 1
      if (n >= 1 .and. n <= most_rows) allocate (table%numbers(2, n), stat=failed)
      if (failed /= 0) then
         code = conclude(handle, fail(NUTATE_BAD_ARGUMENT, 'the table has no line, or too many '// &
                                      '(expected 1 to 2^28)', 'n'))
         return
      end if
      text = ''
      if (c_associated(keys)) call copy_text(keys, text)
      table%numbers(1, :) = t
      table%numbers(2, :) = torque
      call lock_texts()
      call parse_motor_keys(text, table, group, status)
      if (status%ok()) call add_motor_of(group, wheel, handle%system, status)
      call unlock_texts()
      code = conclude(handle, status)
   end function nutate_system_add_motor_table

   integer(c_int) function nutate_system_add_pointing(system, by, target, attitude_gain, rate_gain, by_inertia, field, &
                                                      sample, limit) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, by
      real(c_double), intent(in), optional :: target(4), field(3)
      real(c_double), intent(in), value :: attitude_gain, rate_gain, sample, limit
      integer(c_int), intent(in), value :: by_inertia
      type(group_t) :: group
      character(len=:), allocatable :: means
      call group%put('law', 'quaternion')
      if (c_associated(by)) then
         call copy_text(by, means)
         call group%put('by', means)
      end if
      call group%put('target', target)
      call group%put('attitude_gain', [attitude_gain])
      call group%put('rate_gain', [rate_gain])
      call group%put('gains', trim(merge('inertia', 'scalar ', by_inertia /= 0)))
      call put_held(group, field, sample, limit)
      code = add(system, 'controller', group, .not. c_associated(by))
   end function nutate_system_add_pointing

   integer(c_int) function nutate_system_add_detumbling(system, gain, field, sample, limit) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: field(3)
      real(c_double), intent(in), value :: gain, sample, limit
      type(group_t) :: group
      call group%put('law', 'bdot')
      call group%put('gain', [gain])
      call put_held(group, field, sample, limit)
      code = add(system, 'controller', group, .false.)
   end function nutate_system_add_detumbling

   !> Puts the keys that all controllers have into a group: the field, if there is one, sample and limit.
   subroutine put_held(group, field, sample, limit)
      type(group_t), intent(inout) :: group
      real(wp), intent(in), optional :: field(3)
      real(wp), intent(in) :: sample, limit
      call group%put('field', field)
      if (given(sample)) call group%put('sample', [sample])
      if (is_finite_or_bad(limit)) call group%put('limit', [limit])
   end subroutine put_held

end module nutate_c_satellites
