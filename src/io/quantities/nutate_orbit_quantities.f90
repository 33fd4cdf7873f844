!> Quantities of an orbit: the attitude against its frame, its position and speed, the shadow of the Earth, the sun.
module nutate_orbit_quantities
   use nutate_attitude, only: roll_pitch_yaw_from_quat
   use nutate_kinds, only: wp
   use nutate_motion, only: motion_t
   use nutate_motion_quantities, only: is_beside_pole
   use nutate_orbit, only: shadow_rate
   use nutate_quantity, only: quantity_t, unit, other_angles, still, two_values, GREEN, NAVY, NEEDS_ORBIT, NEEDS_SUN, &
      OF_ORBIT, VERMILION
   use nutate_quaternion, only: quat_conjugate, quat_product, quat_vector_product, rotate_to_body
   use nutate_small_products, only: vector_length
   use nutate_system, only: system_t
   implicit none
   private

   public :: attitude_in_lvlh, orbit_rate, orbit_size, orbit_value
   public :: Q_ROLL_PITCH_YAW, Q_ORBIT_POSITION, Q_ORBIT_SPEED, Q_TRUE_ANOMALY, Q_ECLIPSE

   !> Kinds: one case evaluates all components of a kind. `Q_ECLIPSE` is only a column.
   enum, bind(c)
      enumerator :: Q_ROLL_PITCH_YAW = OF_ORBIT, Q_LVLH_ATTITUDE, Q_LVLH_RATE, Q_ORBIT_POSITION, Q_ORBIT_RADIUS, &
         Q_TRUE_ANOMALY, Q_ORBIT_SPEED, Q_ECLIPSE, Q_SHADOW_DEPTH, Q_SUN_ANGLE
   end enum

   !> Components of roll, pitch and yaw.
   integer, parameter :: ROLL = 1, PITCH = 2

   !> Quantities that need an orbit.
   type(quantity_t), parameter, public :: orbit_quantities(*) = [ &
      quantity_t('lvlh_attitude', 'roll', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, VERMILION, &
                 is_periodic=.true., needs=NEEDS_ORBIT), &
      quantity_t('lvlh_attitude', 'pitch', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, GREEN, first=2, &
                 needs=NEEDS_ORBIT), &
      quantity_t('lvlh_attitude', 'yaw', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, NAVY, first=3, &
                 is_periodic=.true., needs=NEEDS_ORBIT), &
      quantity_t('lvlh_attitude', 'lvlh_q0,lvlh_q1,lvlh_q2,lvlh_q3', Q_LVLH_ATTITUDE, '', &
                 'attitude from the LVLH frame', 4, no_measurement=other_angles, needs=NEEDS_ORBIT, &
                 symbols='q_0,q_1,q_2,q_3'), &
      quantity_t('lvlh_angular_velocity', 'lvlh_omega1,lvlh_omega2,lvlh_omega3', Q_LVLH_RATE, 'rad/s', &
                 'angular velocity against the LVLH frame', 2, '', 'body', needs=NEEDS_ORBIT, by_differences=.true., &
                 symbols='Ω_1,Ω_2,Ω_3'), &
      quantity_t('orbit', 'orbit_x,orbit_y,orbit_z', Q_ORBIT_POSITION, 'm', 'position on the orbit', 21, '', &
                 'inertial', no_measurement=still, attitude=.false., needs=NEEDS_ORBIT, symbols='x,y,z'), &
      quantity_t('orbit', 'orbit_radius', Q_ORBIT_RADIUS, 'm', 'radius of the orbit', 22, NAVY, no_measurement=still, &
                 attitude=.false., needs=NEEDS_ORBIT, symbols='r'), &
      quantity_t('orbit', 'true_anomaly', Q_TRUE_ANOMALY, 'rad', 'true anomaly', 23, NAVY, no_measurement=still, &
                 is_periodic=.true., is_continuous=.true., attitude=.false., needs=NEEDS_ORBIT, symbols='ν'), &
      quantity_t('orbit_speed', 'orbit_speed', Q_ORBIT_SPEED, 'm/s', 'speed on the orbit', 22, NAVY, &
                 no_measurement=still, attitude=.false., needs=NEEDS_ORBIT, symbols='v'), &
      quantity_t('eclipse', 'eclipse', Q_ECLIPSE, '', 'eclipse', 24, NAVY, '', two_values, two_values, &
                 attitude=.false., needs=NEEDS_SUN), &
      quantity_t('eclipse', 'shadow_depth', Q_SHADOW_DEPTH, 'm', 'depth in the shadow', 25, NAVY, &
                 no_measurement=still, attitude=.false., needs=NEEDS_SUN, symbols='depth'), &
      quantity_t('sun_angle', 'sun_angle', Q_SUN_ANGLE, 'rad', 'angle to the sun', 11, NAVY, needs=NEEDS_SUN, &
                 is_folded=.true., symbols='angle')]
   !> Roll, pitch and yaw, from the LVLH frame, or from the space axes without an orbit.
   type(quantity_t), parameter, public :: roll_pitch_yaw_quantities(*) = [ &
      quantity_t('roll_pitch_yaw', 'roll', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, VERMILION, &
                 is_periodic=.true.), &
      quantity_t('roll_pitch_yaw', 'pitch', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, GREEN, first=2), &
      quantity_t('roll_pitch_yaw', 'yaw', Q_ROLL_PITCH_YAW, 'rad', 'roll, pitch, yaw', 5, NAVY, first=3, &
                 is_periodic=.true.)]

contains

   !> Returns a component of attitude or angular velocity against the LVLH frame, or a quantity of orbit or shadow; 0 if
   !> there is no orbit.
   pure real(wp) function orbit_value(kind, component, system, motion) result(x)
      integer, intent(in) :: kind, component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3), attitude(4)
      if (kind == Q_ROLL_PITCH_YAW) then
         v = roll_pitch_yaw_from_quat(attitude_in_lvlh(system, motion%state%q, motion%state%t))
         x = v(component)
         return
      end if
      x = 0.0_wp
      if (.not. system%effects%on_orbit) return
      associate (orbit => system%effects%orbit, t => motion%state%t)
         select case (kind)
         case (Q_SUN_ANGLE)
            x = sun_angle(system, motion%state%q, t)
         case (Q_ORBIT_RADIUS)
            x = orbit%path%radius(t)
         case (Q_TRUE_ANOMALY)
            x = orbit%path%true_anomaly(t)
         case (Q_SHADOW_DEPTH)
            x = orbit%shadow_depth(t)
         case (Q_ORBIT_POSITION)
            v = orbit%path%position(t)
            x = v(component)
         case (Q_ORBIT_SPEED)
            x = vector_length(orbit%path%velocity(t))
         case (Q_LVLH_RATE)
            v = rate_in_lvlh(system, unit(motion%state%q), motion%omega, t)
            x = v(component)
         case default
            attitude = attitude_in_lvlh(system, motion%state%q, t)
            x = attitude(component)
         end select
      end associate
   end function orbit_value

   !> Returns the rate of `orbit_value` along the motion.
   pure real(wp) function orbit_rate(kind, component, system, motion) result(x)
      integer, intent(in) :: kind, component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: velocity(3), place(3), rates(4)
      x = 0.0_wp
      if (kind == Q_ROLL_PITCH_YAW) x = roll_pitch_yaw_rate(component, system, motion)
      if (kind == Q_ROLL_PITCH_YAW .or. .not. system%effects%on_orbit) return
      associate (orbit => system%effects%orbit, t => motion%state%t)
         select case (kind)
         case (Q_ORBIT_POSITION)
            velocity = orbit%path%velocity(t)
            x = velocity(component)
         case (Q_ORBIT_SPEED)
            velocity = orbit%path%velocity(t)
            place = orbit%path%position(t)
            x = -orbit%path%mu*dot_product(velocity, place)/(vector_length(place)**3*vector_length(velocity))
         case (Q_LVLH_ATTITUDE)
            rates = quat_vector_product(attitude_in_lvlh(system, motion%state%q, t), &
                                        0.5_wp*rate_in_lvlh(system, unit(motion%state%q), motion%omega, t))
            x = rates(component)
         case (Q_SUN_ANGLE)
            x = sun_angle_rate(system, motion)
         case (Q_ORBIT_RADIUS)
            velocity = orbit%path%velocity(t)
            place = orbit%path%position(t)
            x = dot_product(velocity, place)/orbit%path%radius(t)
         case (Q_TRUE_ANOMALY)
            x = orbit%path%turn_rate(t)
         case default
            x = shadow_rate(orbit, t)
         end select
      end associate
   end function orbit_rate

   !> Returns the size of the vector that a component belongs to, to which its round-off is relative.
   pure real(wp) function orbit_size(kind, component, system, motion) result(x)
      integer, intent(in) :: kind, component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      select case (kind)
      case (Q_ROLL_PITCH_YAW, Q_LVLH_ATTITUDE, Q_TRUE_ANOMALY, Q_SUN_ANGLE)
         x = 1.0_wp
      case (Q_LVLH_RATE)
         x = vector_length(motion%omega)
      case default
         x = abs(orbit_value(kind, component, system, motion))
      end select
   end function orbit_size

   !> Returns the rate of roll, pitch or yaw along the motion. With w the body's rate against the LVLH frame, or against
   !> the space axes: pitch' = w2 cos(roll) - w3 sin(roll), yaw' = (w2 sin(roll) + w3 cos(roll))/cos(pitch),
   !> roll' = w1 + yaw' sin(pitch). Beside a pitch of 90°, where roll and yaw pass half a revolution in no time,
   !> yaw' = 0.
   pure real(wp) function roll_pitch_yaw_rate(component, system, motion) result(x)
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: angles(3), w(3)
      angles = roll_pitch_yaw_from_quat(attitude_in_lvlh(system, motion%state%q, motion%state%t))
      w = motion%relative
      if (system%effects%on_orbit) w = rate_in_lvlh(system, unit(motion%state%q), motion%omega, motion%state%t)
      x = w(2)*cos(angles(1)) - w(3)*sin(angles(1))
      if (component == PITCH) return
      x = w(2)*sin(angles(1)) + w(3)*cos(angles(1))
      if (is_beside_pole(x, cos(angles(2)), w)) then
         x = 0.0_wp
      else
         x = x/cos(angles(2))
      end if
      if (component == ROLL) x = w(1) + x*sin(angles(2))
   end function roll_pitch_yaw_rate

   !> Returns the attitude from the body to the LVLH frame, or to the space axes if there is no orbit; shape (4).
   pure function attitude_in_lvlh(system, q, t) result(relative)
      type(system_t), intent(in) :: system
      !> Attitude, body→space, shape (4), and time, s.
      real(wp), intent(in) :: q(4), t
      real(wp) :: relative(4)
      relative = q
      if (system%effects%on_orbit) relative = quat_product(quat_conjugate(system%effects%orbit%axes(t)), q)
   end function attitude_in_lvlh

   !> Returns the angular velocity against the LVLH frame, body axes, rad/s; Ω if there is no orbit. Shape (3).
   pure function rate_in_lvlh(system, q, omega, t) result(rate)
      type(system_t), intent(in) :: system
      !> Attitude, unit quaternion, body→space, shape (4); Ω, body axes, rad/s, shape (3); time, s.
      real(wp), intent(in) :: q(4), omega(3), t
      real(wp) :: rate(3)
      rate = omega
      if (system%effects%on_orbit) rate = omega - rotate_to_body(q, system%effects%orbit%axes_rate(t))
   end function rate_in_lvlh

   !> Returns the direction of the sun, body axes, unit vector; zero if there is no sun. Shape (3).
   pure function sun_in_body(system, q, t) result(sun)
      type(system_t), intent(in) :: system
      !> Attitude, body→space, shape (4), and time, s.
      real(wp), intent(in) :: q(4), t
      real(wp) :: sun(3)
      sun = 0.0_wp
      if (system%effects%on_orbit) &
         sun = rotate_to_body(unit(quat_product(system%effects%space_axes(t), q)), system%effects%orbit%sun)
   end function sun_in_body

   !> Returns the angle between body axis 3 and the direction of the sun, rad, 0 to π; 0 if there is no sun.
   pure real(wp) function sun_angle(system, q, t)
      type(system_t), intent(in) :: system
      !> Attitude, body→space, shape (4), and time, s.
      real(wp), intent(in) :: q(4), t
      real(wp) :: sun(3)
      sun = sun_in_body(system, q, t)
      sun_angle = atan2(hypot(sun(1), sun(2)), sun(3))
   end function sun_angle

   !> Returns the rate of the angle to the sun along the motion, rad/s: the sun is fixed in inertial axes.
   pure real(wp) function sun_angle_rate(system, motion) result(rate)
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: sun(3), omega(3)
      sun = sun_in_body(system, motion%state%q, motion%state%t)
      omega = motion%relative
      if (system%effects%knows_space_axes()) omega = motion%omega
      rate = 0.0_wp
      if (hypot(sun(1), sun(2)) > 0.0_wp) rate = (sun(2)*omega(1) - sun(1)*omega(2))/hypot(sun(1), sun(2))
   end function sun_angle_rate

end module nutate_orbit_quantities
