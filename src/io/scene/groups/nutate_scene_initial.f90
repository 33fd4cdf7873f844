!> `&initial`: attitude and angular velocity at t = 0.
module nutate_scene_initial
   use nutate_admissible, only: ANY_DIRECTION, POSITIVE
   use nutate_attitude, only: angular_velocity_from_euler_rates, quat_from_axis_angle, quat_from_euler, &
      quat_from_roll_pitch_yaw
   use nutate_body, only: body_t
   use nutate_decimal, only: rounded_text
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: frame_rate_of, system_t
   use nutate_keys, only: group_t, key_t, name_length, KEY_LOGICAL, KEY_TEXT
   use nutate_kinds, only: wp, pi
   use nutate_periodic_start, only: find_periodic_start, periodic_start_t
   use nutate_quaternion, only: quat_normalized, quat_product, rotate_to_body
   use nutate_range, only: check_attitude, check_motion, check_step
   use nutate_run_plan, only: run_plan_t
   use nutate_scene_error, only: scene_error_t, allow_one_of, demand_one_of, demand_with
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tumbling, only: tumbling_start_t, tumbling_state
   implicit none
   private

   public :: initial_keys, build_initial, rebuild_initial, check_initial, check_initial_keys

   !> Keys of the scene group `&initial`.
   type(key_t), parameter :: initial_keys(21) = [ &
      key_t(name='quaternion', least=4, most=4, range=ANY_DIRECTION), &
      key_t(name='axis', least=3, most=3, range=ANY_DIRECTION), &
      key_t(name='angle'), &
      key_t(name='euler', least=3, most=3), &
      key_t(name='roll_pitch_yaw', least=3, most=3), &
      key_t(name='attitude_from', kind=KEY_TEXT, choices='space,lvlh'), &
      key_t(name='angular_velocity', least=3, most=3), &
      key_t(name='euler_rates', least=3, most=3), &
      key_t(name='frame', kind=KEY_TEXT, choices='body,space'), &
      key_t(name='rate_from', kind=KEY_TEXT, choices='inertial,frame,lvlh'), &
      key_t(name='tumbling', kind=KEY_TEXT, choices='sam,lam'), &
      key_t(name='sense', kind=KEY_TEXT, choices='positive,negative', default='positive', beside='tumbling'), &
      key_t(name='precession_period', range=POSITIVE), &
      key_t(name='period_axis', kind=KEY_TEXT, choices='short,long'), &
      key_t(name='rotation_period', range=POSITIVE, instead_of='energy_ratio'), &
      key_t(name='energy_ratio', range=POSITIVE, instead_of='rotation_period'), &
      key_t(name='pole', least=2, most=2), &
      key_t(name='precession_angle', default='0', beside='tumbling'), &
      key_t(name='rotation_phase', default='0', beside='tumbling'), &
      key_t(name='resonance', kind=KEY_TEXT, choices='1:2,1:1,3:2,2:1,5:2,3:1'), &
      key_t(name='degrees', kind=KEY_LOGICAL)]

   !> Keys that go with `tumbling`; those that it requires come first.
   character(len=name_length), parameter :: elements(8) = [character(len=name_length) :: &
      'precession_period', 'period_axis', 'pole', 'rotation_period', 'energy_ratio', 'precession_angle', &
      'rotation_phase', 'sense']
   !> Keys of an attitude and a rotation that are given directly.
   character(len=name_length), parameter :: as_such(10) = [character(len=name_length) :: &
      'quaternion', 'axis', 'angle', 'euler', 'roll_pitch_yaw', 'attitude_from', 'angular_velocity', 'euler_rates', &
      'frame', 'rate_from']

contains

   !> Builds attitude and angular velocity at t = 0.
   subroutine build_initial(group, system, q, omega, periodic, error)
      type(group_t), intent(in) :: group
      !> System with the orbit and the rate of the space axes, to which they may be relative.
      type(system_t), intent(in) :: system
      !> Unit quaternion, body→space; shape (4).
      real(wp), intent(out) :: q(4)
      !> Ω, body axes, rad/s; shape (3).
      real(wp), intent(out) :: omega(3)
      !> Periodic motion that was found for a resonance; otherwise without revolutions.
      type(periodic_start_t), intent(out) :: periodic
      type(scene_error_t), intent(inout) :: error
      q = 0.0_wp
      omega = 0.0_wp
      call check_initial_keys(group, error)
      call check_references(group, system%effects, error)
      if (.not. error%raised) call rebuild_initial(group, system, q, omega, periodic, error)
   end subroutine build_initial

   !> Builds attitude and angular velocity of a group whose keys have been checked.
   subroutine rebuild_initial(group, system, q, omega, periodic, error)
      type(group_t), intent(in) :: group
      type(system_t), intent(in) :: system
      real(wp), intent(out) :: q(4), omega(3)
      type(periodic_start_t), intent(out) :: periodic
      type(scene_error_t), intent(inout) :: error
      real(wp) :: unit
      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      omega = 0.0_wp
      unit = 1.0_wp
      if (group%flag('degrees', .false.)) unit = pi/180
      if (group%has('tumbling')) then
         call build_tumbling(system%body)
         return
      else if (group%has('resonance')) then
         call build_resonance()
         q = periodic%q
         omega = periodic%omega
         return
      end if
      call build_attitude()
      if (error%raised) return
      if (group%text('attitude_from', 'space') == 'lvlh') q = quat_product(system%effects%orbit%axes(0.0_wp), q)
      call build_rate()
      select case (group%text('rate_from', 'inertial'))
      case ('frame')
         omega = omega + frame_rate_of(system%effects, q)
      case ('lvlh')
         omega = omega + rotate_to_body(q, system%effects%orbit%axes_rate(0.0_wp))
      case default
         ! The given rate is inertial, as Ω is.
      end select

   contains

      !> Builds attitude and angular velocity of tumbling elements.
      subroutine build_tumbling(body)
         type(body_t), intent(in) :: body
         type(tumbling_start_t) :: start
         type(status_t) :: status
         call check_latitude()
         if (error%raised) return
         start%is_short_axis = group%text('tumbling', 'sam') == 'sam'
         start%period_of_short = group%text('period_axis', 'short') == 'short'
         start%is_negative = group%text('sense', 'positive') == 'negative'
         start%precession_period = group%number('precession_period', 0.0_wp)
         start%rotation_period = group%number('rotation_period', 0.0_wp)
         start%energy_ratio = group%number('energy_ratio', 0.0_wp)
         start%pole = unit*group%vector('pole', start%pole)
         start%angle = unit*group%number('precession_angle', 0.0_wp)
         start%phase = group%number('rotation_phase', 0.0_wp)
         call tumbling_state(body%moments, body%axes, start, q, omega, status)
         if (.not. status%ok()) call error%raise_status(group%line_of(trim(status%subject)), status)
      end subroutine build_tumbling

      !> Raises an error for a pole whose latitude is beyond a right angle.
      subroutine check_latitude()
         real(wp) :: pole(2), right_angle
         character(len=:), allocatable :: range
         pole = group%vector('pole', [0.0_wp, 0.0_wp])
         right_angle = pi/2
         range = '-pi/2 to pi/2 rad, or degrees = .true.'
         if (group%flag('degrees', .false.)) then
            right_angle = 90.0_wp
            range = '-90 to 90 degrees'
         end if
         if (abs(pole(2)) > right_angle*(1 + 4*epsilon(right_angle))) call error%raise( &
            group%line_of('pole'), 'the latitude of the pole is '//rounded_text(pole(2)), expected=range)
      end subroutine check_latitude

      !> Finds the periodic motion of a resonance.
      subroutine build_resonance()
         type(status_t) :: status
         character(len=3) :: ratio
         ratio = group%text('resonance', '1:1')
         call find_periodic_start(system, real(iachar(ratio(1:1)) - iachar('0'), wp) &
                                  /(iachar(ratio(3:3)) - iachar('0')), periodic, status)
         if (.not. status%ok()) call error%raise_status(group%line_of('resonance'), status)
      end subroutine build_resonance

      !> Builds the attitude, from any form that is given; unchanged if none is.
      subroutine build_attitude()
         real(wp) :: angles(3)
         type(status_t) :: status

         angles = 0.0_wp
         if (group%has('quaternion')) then
            q = group%vector('quaternion', q)
            call check_attitude(q, status)
            if (.not. status%ok()) call error%raise_status(group%line_of('quaternion'), status)
            q = quat_normalized(q)
         else if (group%has('axis')) then
            call quat_from_axis_angle(group%vector('axis', angles), unit*group%number('angle', 0.0_wp), q, status)
            if (.not. status%ok()) call error%raise_status(group%line_of('axis'), status)
         else if (group%has('euler')) then
            angles = unit*group%vector('euler', angles)
            q = quat_from_euler(angles(1), angles(2), angles(3))
         else if (group%has('roll_pitch_yaw')) then
            q = quat_from_roll_pitch_yaw(unit*group%vector('roll_pitch_yaw', angles))
         end if
      end subroutine build_attitude

      !> Builds the angular velocity in body axes, rad/s.
      subroutine build_rate()
         real(wp) :: angles(3), rates(3)

         if (group%has('euler_rates')) then
            angles = unit*group%vector('euler', omega)
            rates = unit*group%vector('euler_rates', omega)
            omega = angular_velocity_from_euler_rates(angles(2), angles(3), rates(1), rates(2), rates(3))
         else
            omega = unit*group%vector('angular_velocity', omega)
            if (group%text('frame', 'body') == 'space') omega = rotate_to_body(q, omega)
         end if
      end subroutine build_rate

   end subroutine rebuild_initial

   !> Checks keys that exclude or require each other.
   subroutine check_initial_keys(group, error)
      type(group_t), intent(in) :: group
      type(scene_error_t), intent(inout) :: error
      if (group%has('tumbling')) then
         call check_tumbling()
      else if (group%has('resonance')) then
         call check_resonance()
      else
         call check_keys()
      end if

   contains

      !> Checks the keys of tumbling elements: all that a motion requires, and no other form of the initial state.
      subroutine check_tumbling()
         integer :: i
         do i = 1, size(as_such)
            call allow_one_of(group, [character(len=name_length) :: 'tumbling', as_such(i)], error)
         end do
         call allow_one_of(group, [character(len=name_length) :: 'tumbling', 'resonance'], error)
         call allow_one_of(group, [character(len=name_length) :: 'rotation_period', 'energy_ratio'], error)
         do i = 1, 3
            call demand_with(group, 'tumbling', trim(elements(i)), error)
         end do
         call demand_one_of(group, [character(len=name_length) :: 'rotation_period', 'energy_ratio'], error)
      end subroutine check_tumbling

      !> Raises an error for a resonance with another form of the initial state.
      subroutine check_resonance()
         integer :: i
         do i = 1, size(as_such)
            call allow_one_of(group, [character(len=name_length) :: 'resonance', as_such(i)], error)
         end do
         do i = 1, size(elements)
            call demand_with(group, trim(elements(i)), 'tumbling', error)
         end do
      end subroutine check_resonance

      !> Checks the keys of an attitude and a rotation that are given directly.
      subroutine check_keys()
         integer :: i

         call allow_one_of(group, [character(len=name_length) :: 'quaternion', 'axis', 'euler', 'roll_pitch_yaw'], &
            error)
         call allow_one_of(group, [character(len=name_length) :: 'quaternion', 'angle', 'euler', 'roll_pitch_yaw'], &
            error)
         call allow_one_of(group, [character(len=name_length) :: 'angular_velocity', 'euler_rates'], error)
         call demand_with(group, 'axis', 'angle', error)
         call demand_with(group, 'angle', 'axis', error)
         call demand_with(group, 'euler_rates', 'euler', error)
         call demand_one_of(group, [character(len=name_length) :: 'angular_velocity', 'euler_rates'], error)
         do i = 1, size(elements)
            call demand_with(group, trim(elements(i)), 'tumbling', error)
         end do
         if (group%has('euler_rates') .and. group%has('frame')) &
            call error%raise(group%line_of('frame'), 'frame has no meaning with euler_rates', &
                             expected='frame with angular_velocity only')
         if (group%has('euler_rates') .and. group%text('attitude_from', 'space') == 'lvlh') &
            call error%raise(group%line_of('attitude_from'), 'Euler rates are those of the space axes', &
                             expected='angular_velocity with it')
      end subroutine check_keys

   end subroutine check_initial_keys

   !> Raises an error for an initial state that the effects of the scene do not allow.
   subroutine check_references(group, effects, error)
      type(group_t), intent(in) :: group
      type(effect_list_t), intent(in) :: effects
      type(scene_error_t), intent(inout) :: error
      if (group%has('tumbling') .and. effects%n_rotors > 0) &
         call error%raise(group%line_of('tumbling'), 'tumbling elements of a body with a rotor or wheel', &
                          expected='a body without them')
      if (group%text('rate_from', 'inertial') == 'frame' .and. .not. effects%frame_turns) &
         call error%raise(group%line_of('rate_from'), 'there is no rotating frame', &
                          expected='&rotating_frame')
      if (effects%frame_turns .and. group%has('euler_rates') .and. .not. group%has('rate_from')) &
         call error%raise(group%line_of('euler_rates'), 'Euler rates in rotating axes do not say what they are '// &
                          'relative to', expected='rate_from = ''frame'', for the rates of the angles, or ''inertial''')
      if (effects%on_orbit) return
      if (group%text('rate_from', 'inertial') == 'lvlh') &
         call error%raise(group%line_of('rate_from'), 'there is no orbit', expected='&orbit')
      if (group%text('attitude_from', 'space') == 'lvlh') &
         call error%raise(group%line_of('attitude_from'), 'there is no orbit', expected='&orbit')
   end subroutine check_references

   !> Raises an error for a motion, or a rotation in a step, beyond the limits of the computation.
   subroutine check_initial(system, state, plan, initial, integrator, error)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Plan of the run; `time_step` 0: steps are adaptive.
      type(run_plan_t), intent(in) :: plan
      !> Groups `&initial` and `&integrator`.
      type(group_t), intent(in) :: initial, integrator
      type(scene_error_t), intent(inout) :: error
      type(status_t) :: status

      call check_motion(system, state, status)
      if (.not. status%ok()) then
         call error%raise_status(initial%line_of(rate_key(initial)), status)
      else if (abs(plan%time_step) > 0.0_wp) then
         call check_step(system, state, plan%time_step, status)
         if (.not. status%ok()) call error%raise_status(integrator%line_of('time_step'), status)
      end if
   end subroutine check_initial

   !> Returns the key that gives the angular velocity.
   pure function rate_key(initial) result(key)
      type(group_t), intent(in) :: initial
      character(len=:), allocatable :: key
      key = 'angular_velocity'
      if (initial%has('euler_rates')) key = 'euler_rates'
      if (initial%has('tumbling')) key = 'precession_period'
      if (initial%has('resonance')) key = 'resonance'
   end function rate_key

end module nutate_scene_initial
