!> C interface: frames, orbits, the Earth's field, forces, wheels and controllers of a system. The functions are
!> documented in `include/nutate_satellites.h`.
module nutate_c_satellites
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_int, c_ptr, c_size_t
   use nutate_c_groups, only: add_motor_of, parse_motor_keys, put_numbers, put_text
   use nutate_c_handles, only: conclude, found, null_argument, system_handle_t
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
      if (present(rate)) call put_numbers(group, 'rate', rate)
      code = add(system, 'rotating_frame', group, .not. present(rate))
   end function nutate_system_add_rotating_frame

   integer(c_int) function nutate_system_add_latitude(system, latitude) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), value :: latitude
      type(group_t) :: group
      call put_numbers(group, 'latitude', [latitude])
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
      call put_numbers(group, 'semi_major_axis', [semi_major_axis])
      call put_numbers(group, 'eccentricity', [eccentricity])
      if (present(angles)) then
         do i = 1, 4
            call put_numbers(group, trim(names(i)), angles(i:i))
         end do
      end if
      call put_numbers(group, 'mu', [merge(mu, earth_mu, given(mu))])
      if (inertial == 0 .and. .not. abs(eccentricity) > 0.0_wp) call put_text(group, 'frame', 'lvlh')
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
      if (present(moment)) call put_numbers(group, 'moment', moment)
      call put_numbers(group, 'epoch_angle', [epoch_angle])
      if (present(coefficients)) call put_numbers(group, 'coefficients', coefficients)
      code = add(system, 'earth_field', group, .false.)
   end function nutate_system_add_earth_field

   integer(c_int) function nutate_system_add_force(system, body_point, force, axes, start, stop) result(code) bind(C)
      type(c_ptr), intent(in), value :: system, axes
      real(c_double), intent(in), optional :: body_point(3), force(3)
      real(c_double), intent(in), value :: start, stop
      type(group_t) :: group
      character(len=:), allocatable :: name
      if (present(body_point)) call put_numbers(group, 'body_point', body_point)
      if (present(force)) call put_numbers(group, 'force', force)
      if (c_associated(axes)) then
         call copy_text(axes, name)
         call put_text(group, 'axes', name)
      end if
      if (is_finite_or_bad(-start)) call put_numbers(group, 'start', [start])
      if (is_finite_or_bad(stop)) call put_numbers(group, 'stop', [stop])
      code = add(system, 'force', group, .not. (present(body_point) .and. present(force) .and. c_associated(axes)))
   end function nutate_system_add_force

   integer(c_int) function nutate_system_add_wheel(system, axis, inertia, speed, friction, torque_limit, speed_limit) &
      result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: axis(3)
      real(c_double), intent(in), value :: inertia, speed, friction, torque_limit, speed_limit
      type(group_t) :: group
      if (present(axis)) call put_numbers(group, 'axis', axis)
      call put_numbers(group, 'inertia', [inertia])
      call put_numbers(group, 'speed', [speed])
      call put_numbers(group, 'friction', [friction])
      if (is_finite_or_bad(torque_limit)) call put_numbers(group, 'torque_limit', [torque_limit])
      if (is_finite_or_bad(speed_limit)) call put_numbers(group, 'speed_limit', [speed_limit])
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
      call put_numbers(group, 'torque', [torque])
      call put_numbers(group, 'frequency', [frequency])
      call put_numbers(group, 'phase', [phase])
      if (is_finite_or_bad(-start)) call put_numbers(group, 'start', [start])
      if (is_finite_or_bad(stop)) call put_numbers(group, 'stop', [stop])
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
      call put_text(group, 'law', 'quaternion')
      if (c_associated(by)) then
         call copy_text(by, means)
         call put_text(group, 'by', means)
      end if
      if (present(target)) call put_numbers(group, 'target', target)
      call put_numbers(group, 'attitude_gain', [attitude_gain])
      call put_numbers(group, 'rate_gain', [rate_gain])
      call put_text(group, 'gains', trim(merge('inertia', 'scalar ', by_inertia /= 0)))
      call put_held(group, field, sample, limit)
      code = add(system, 'controller', group, .not. c_associated(by))
   end function nutate_system_add_pointing

   integer(c_int) function nutate_system_add_detumbling(system, gain, field, sample, limit) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: field(3)
      real(c_double), intent(in), value :: gain, sample, limit
      type(group_t) :: group
      call put_text(group, 'law', 'bdot')
      call put_numbers(group, 'gain', [gain])
      call put_held(group, field, sample, limit)
      code = add(system, 'controller', group, .false.)
   end function nutate_system_add_detumbling

   !> Puts the keys that all controllers have into a group: the field, if there is one, sample and limit.
   subroutine put_held(group, field, sample, limit)
      type(group_t), intent(inout) :: group
      real(wp), intent(in), optional :: field(3)
      real(wp), intent(in) :: sample, limit
      if (present(field)) call put_numbers(group, 'field', field)
      if (given(sample)) call put_numbers(group, 'sample', [sample])
      if (is_finite_or_bad(limit)) call put_numbers(group, 'limit', [limit])
   end subroutine put_held

   !> Returns false for zero; NaN is treated as given, and is rejected later.
   pure logical function given(x)
      real(wp), intent(in) :: x
      given = ieee_is_nan(x)
      if (.not. given) given = abs(x) > 0.0_wp
   end function given

end module nutate_c_satellites
