!> Values of the table of quantities along a motion, their rates in closed form, and bounds of both.
module nutate_quantity_motion
   use nutate_attitude, only: roll_pitch_yaw_from_quat, euler_from_quat
   use nutate_control_columns, only: field_in_body, pointing_error
   use nutate_hamiltonian, only: potential_energy, system_t, time_dependent_power
   use nutate_kinds, only: wp, eps, pi
   use nutate_motion, only: motion_t
   use nutate_motion_bounds, only: speed_bounds_t
   use nutate_moving_frame, only: angle_rate, quaternion_rate, see_from_frame
   use nutate_orbit, only: shadow_rate
   use nutate_quantities, only: quantity_t, Q_CONJUGATE_MOMENTUM, Q_ENERGY, Q_EULER, Q_FIELD, &
      Q_FRAME_ANGLE, Q_FRAME_ATTITUDE, Q_JACOBI, Q_LVLH_ATTITUDE, Q_LVLH_RATE, Q_MOMENTUM, Q_MOMENTUM_SPACE, &
      Q_ORBIT_POSITION, Q_ORBIT_RADIUS, Q_ORBIT_SPEED, Q_POINTING_ERROR, Q_QUATERNION, Q_RATE, Q_RATE_SPACE, &
      Q_ROLL_PITCH_YAW, Q_SHADOW_DEPTH, Q_SPEED, Q_SPHERE_ENERGY, Q_SPHERE_MOMENTUM, Q_SPHERE_RATE, Q_SPHERE_WORK, &
      Q_SUN_ANGLE, Q_TRUE_ANOMALY, Q_TUMBLING, Q_WHEEL_MOMENTUM, Q_WHEEL_SPEED
   use nutate_quaternion, only: cross, quat_conjugate, quat_norm, quat_product, quat_vector_product, rotate_to_body, &
      rotate_to_space
   use nutate_small_products, only: vector_length
   use nutate_tumbling_columns, only: tumbling_rate, tumbling_values, tumbling_width
   implicit none
   private

   public :: attitude_in_lvlh, quantity_value, quantity_rate, quantity_size, fastest_rate, greatest_value

   !> Components of Euler angles, of roll, pitch and yaw, and of energies.
   integer, parameter :: PHI = 1, THETA = 2, PSI = 3, ROLL = 1, PITCH = 2, KINETIC = 1, POTENTIAL = 2

contains

   !> Returns the value of a component of a quantity; energies exclude that of an auxiliary inertia, which does not
   !> belong to the body.
   pure real(wp) function quantity_value(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3), elements(tumbling_width)
      associate (q => motion%state%q, n => quantity%number)
         select case (quantity%kind)
         case (Q_QUATERNION)
            x = q(component)
         case (Q_CONJUGATE_MOMENTUM)
            x = motion%state%p(component)
         case (Q_RATE)
            x = motion%omega(component)
         case (Q_MOMENTUM)
            x = motion%momentum(component)
         case (Q_RATE_SPACE)
            v = rotate_to_space(unit(q), motion%omega)
            x = v(component)
         case (Q_MOMENTUM_SPACE)
            v = rotate_to_space(unit(q), motion%momentum)
            x = v(component)
         case (Q_EULER)
            x = euler_angle(component, unit(q))
         case (Q_SPEED)
            x = vector_length(motion%omega)
         case (Q_SUN_ANGLE)
            x = sun_angle(system, q, motion%state%t)
         case (Q_POINTING_ERROR)
            x = pointing_error(n, system, motion%state)
         case (Q_FIELD)
            v = field_in_body(system%effects, motion%state)
            x = v(component)
         case (Q_ROLL_PITCH_YAW)
            v = roll_pitch_yaw_from_quat(attitude_in_lvlh(system, q, motion%state%t))
            x = v(component)
         case (Q_LVLH_ATTITUDE, Q_LVLH_RATE, Q_ORBIT_POSITION, Q_ORBIT_RADIUS, Q_ORBIT_SPEED, Q_TRUE_ANOMALY, &
               Q_SHADOW_DEPTH)
            x = orbit_value(quantity%kind, component, system, motion)
         case (Q_TUMBLING)
            elements = tumbling_values(system, motion%state)
            x = elements(component)
         case (Q_FRAME_ATTITUDE, Q_FRAME_ANGLE)
            x = frame_value(quantity, component, system, motion)
         case (Q_WHEEL_SPEED, Q_WHEEL_MOMENTUM)
            x = 0.0_wp
            if (n > system%effects%n_reaction_wheels) return
            x = motion%state%wheel_momentum(n)
            if (quantity%kind == Q_WHEEL_SPEED) x = system%effects%wheels(n)%speed_of(x, motion%omega)
         case (Q_SPHERE_RATE, Q_SPHERE_MOMENTUM, Q_SPHERE_ENERGY, Q_SPHERE_WORK)
            x = sphere_value(quantity, component, system, motion)
         case default
            x = energy_value(quantity, component, system, motion)
         end select
      end associate
   end function quantity_value

   !> Returns a component of the rate of an inner sphere relative to the body, rad/s, or of its momentum in space axes,
   !> N m s, its energy, or the work of its friction, J; 0 if the sphere does not exist.
   pure real(wp) function sphere_value(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3)
      integer :: last
      x = 0.0_wp
      if (quantity%number > system%effects%n_spheres) return
      last = system%effects%n_reaction_wheels + 3*quantity%number
      associate (h => motion%state%wheel_momentum(last - 2:last), inertia => system%effects%wheels(last)%inertia)
         v = h/inertia - motion%omega
         if (quantity%kind == Q_SPHERE_MOMENTUM) v = rotate_to_space(unit(motion%state%q), h)
         x = v(component)
         if (quantity%kind == Q_SPHERE_ENERGY) x = 0.5_wp*dot_product(h/inertia, h)
         if (quantity%kind == Q_SPHERE_WORK) x = sum(motion%state%wheel_work(2, last - 2:last))
      end associate
   end function sphere_value

   !> Returns the rate of `sphere_value` along the motion.
   pure real(wp) function sphere_value_rate(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3)
      integer :: last
      x = 0.0_wp
      if (quantity%number > system%effects%n_spheres) return
      last = system%effects%n_reaction_wheels + 3*quantity%number
      associate (h => motion%state%wheel_momentum(last - 2:last), rate => motion%wheel_rate(last - 2:last), &
                 inertia => system%effects%wheels(last)%inertia)
         v = rate/inertia - motion%acceleration
         if (quantity%kind == Q_SPHERE_MOMENTUM) &
            v = rotate_to_space(unit(motion%state%q), rate + cross(motion%relative, h))
         x = v(component)
         if (quantity%kind == Q_SPHERE_ENERGY) x = dot_product(h/inertia, rate)
      end associate
   end function sphere_value_rate

   !> Returns the kinetic, potential or total energy, or the Jacobi integral, J.
   pure real(wp) function energy_value(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      x = 0.0_wp
      associate (omega => motion%omega, momentum => motion%momentum, effects => system%effects, state => motion%state)
         if (quantity%kind == Q_JACOBI .or. component /= POTENTIAL) &
            x = 0.5_wp*dot_product(omega, momentum - effects%inner_momentum(state%wheel_momentum)) &
                + effects%wheel_energy(state%wheel_momentum)
         if (quantity%kind == Q_JACOBI .or. component /= KINETIC) x = x + potential_energy(effects, state%q, state%t)
         if (quantity%kind == Q_JACOBI) x = x - dot_product(omega - motion%relative, momentum)
      end associate
   end function energy_value

   !> Returns a component of attitude or angular velocity against the LVLH frame, or a quantity of orbit or shadow; 0 if
   !> there is no orbit.
   pure real(wp) function orbit_value(kind, component, system, motion) result(x)
      integer, intent(in) :: kind, component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3), attitude(4)
      x = 0.0_wp
      if (.not. system%effects%on_orbit) return
      associate (orbit => system%effects%orbit, t => motion%state%t)
         select case (kind)
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
      if (.not. system%effects%on_orbit) return
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

   !> Returns a component of the attitude relative to a frame, or its angle, rad; 0 if the frame does not exist.
   pure real(wp) function frame_value(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: q(4), angle
      x = 0.0_wp
      if (quantity%number > system%effects%n_frames) return
      call see_from_frame(system%effects%frames(quantity%number), motion%state%t, &
                          quat_product(system%effects%space_axes(motion%state%t), motion%state%q), q, angle)
      x = merge(angle, q(component), quantity%kind == Q_FRAME_ANGLE)
   end function frame_value

   !> Returns the rate of `frame_value` along the motion.
   pure real(wp) function frame_rate(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: rates(4), q(4), omega(3)
      x = 0.0_wp
      if (quantity%number > system%effects%n_frames) return
      associate (frame => system%effects%frames(quantity%number), t => motion%state%t)
         q = quat_product(system%effects%space_axes(t), motion%state%q)
         omega = motion%relative
         if (system%effects%knows_space_axes()) omega = motion%omega
         if (quantity%kind == Q_FRAME_ANGLE) then
            x = angle_rate(frame, t, q, omega)
         else
            rates = quaternion_rate(frame, t, q, omega)
            x = rates(component)
         end if
      end associate
   end function frame_rate

   !> Returns the rate of a component of a quantity along the motion.
   pure real(wp) function quantity_rate(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      !> Motion with its rates.
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3), w(4), torque(3), momentum_rate(3), frame_in_body(3)
      torque = motion%potential_torque + motion%torque
      frame_in_body = motion%omega - motion%relative
      momentum_rate = cross(motion%momentum, motion%omega) + torque
      associate (q => motion%state%q, relative => motion%relative, n => quantity%number)
         select case (quantity%kind)
         case (Q_QUATERNION)
            w = quat_vector_product(q, 0.5_wp*relative)
            x = w(component)
         case (Q_CONJUGATE_MOMENTUM)
            ! ṗ of p = 2 q∘[0, L].
            w = quat_product(quat_vector_product(q, relative), [0.0_wp, motion%momentum]) + &
                quat_vector_product(q, 2*momentum_rate)
            x = w(component)
         case (Q_RATE)
            x = motion%acceleration(component)
         case (Q_MOMENTUM)
            x = momentum_rate(component)
         case (Q_RATE_SPACE)
            v = rotate_to_space(unit(q), motion%acceleration + cross(motion%omega, frame_in_body))
            x = v(component)
         case (Q_MOMENTUM_SPACE)
            v = rotate_to_space(unit(q), torque + cross(motion%momentum, frame_in_body))
            x = v(component)
         case (Q_EULER)
            x = euler_rate(component, q, relative)
         case (Q_SPEED)
            x = 0.0_wp
            if (any(abs(motion%omega) > 0.0_wp)) &
               x = dot_product(motion%omega, motion%acceleration)/vector_length(motion%omega)
         case (Q_SUN_ANGLE)
            x = sun_angle_rate(system, motion)
         case (Q_ROLL_PITCH_YAW)
            x = roll_pitch_yaw_rate(component, system, motion)
         case (Q_LVLH_ATTITUDE, Q_ORBIT_POSITION, Q_ORBIT_RADIUS, Q_ORBIT_SPEED, Q_TRUE_ANOMALY, Q_SHADOW_DEPTH)
            x = orbit_rate(quantity%kind, component, system, motion)
         case (Q_TUMBLING)
            x = tumbling_rate(component, system, motion)
         case (Q_FRAME_ATTITUDE, Q_FRAME_ANGLE)
            x = frame_rate(quantity, component, system, motion)
         case (Q_WHEEL_SPEED, Q_WHEEL_MOMENTUM)
            x = 0.0_wp
            if (n > system%effects%n_reaction_wheels) return
            x = motion%wheel_rate(n)
            if (quantity%kind == Q_WHEEL_SPEED) x = system%effects%wheels(n)%speed_of(x, motion%acceleration)
         case (Q_SPHERE_RATE, Q_SPHERE_MOMENTUM, Q_SPHERE_ENERGY)
            x = sphere_value_rate(quantity, component, system, motion)
         case default
            x = energy_rate(quantity, component, system, motion)
         end select
      end associate
   end function quantity_rate

   !> Returns the rate of an energy or of the Jacobi integral, W.
   pure real(wp) function energy_rate(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: by_time
      by_time = 0.0_wp
      if (system%effects%moves) by_time = time_dependent_power(system%effects, unit(motion%state%q), motion%state%t)
      associate (omega => motion%omega, relative => motion%relative)
         if (quantity%kind == Q_JACOBI) then
            x = dot_product(relative, motion%torque) + motion%inner_power + motion%inertia_power + by_time
         else if (component == KINETIC) then
            x = dot_product(omega, motion%potential_torque + motion%torque) + motion%inner_power + motion%inertia_power
         else if (component == POTENTIAL) then
            x = by_time - dot_product(relative, motion%potential_torque)
         else
            x = dot_product(omega, motion%torque) + dot_product(omega - relative, motion%potential_torque) + &
                motion%inner_power + motion%inertia_power + by_time
         end if
      end associate
   end function energy_rate

   !> Returns the size of the vector or sum that a component belongs to, to which its round-off is relative.
   pure real(wp) function quantity_size(quantity, component, system, motion) result(x)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      select case (quantity%kind)
      case (Q_QUATERNION, Q_LVLH_ATTITUDE, Q_FRAME_ATTITUDE)
         x = 1.0_wp
      case (Q_CONJUGATE_MOMENTUM)
         x = quat_norm(motion%state%p)
      case (Q_RATE, Q_RATE_SPACE, Q_LVLH_RATE)
         x = vector_length(motion%omega)
      case (Q_MOMENTUM, Q_MOMENTUM_SPACE)
         x = vector_length(motion%momentum)
      case (Q_ENERGY, Q_JACOBI)
         x = 0.5_wp*vector_length(motion%omega)*vector_length(motion%momentum)
         if (quantity%kind == Q_JACOBI .or. component /= KINETIC) &
            x = x + abs(potential_energy(system%effects, motion%state%q, motion%state%t))
      case default
         x = 1.0_wp
         if (quantity%unit /= 'rad') x = abs(quantity_value(quantity, component, system, motion))
      end select
   end function quantity_size

   !> Returns a bound of the rate of a component; negative if none is known.
   pure real(wp) function fastest_rate(quantity, component, speeds) result(rate)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(speed_bounds_t), intent(in) :: speeds
      rate = -1.0_wp
      select case (quantity%kind)
      case (Q_QUATERNION)
         rate = 0.5_wp*(speeds%speed + speeds%frame_speed)
      case (Q_CONJUGATE_MOMENTUM)
         ! p = 2 [0, l]∘q with l in the space axes, which rotate, and |q̇| half of the speed against them.
         rate = speeds%momentum*(speeds%speed + 3*speeds%frame_speed) + 2*speeds%torque
      case (Q_RATE)
         rate = speeds%accelerations(component)
      case (Q_SPEED)
         rate = speeds%acceleration
      case (Q_RATE_SPACE)
         rate = speeds%acceleration + speeds%speed*speeds%frame_speed
      case (Q_MOMENTUM)
         rate = speeds%axis_momentum_rates(component)
      case (Q_MOMENTUM_SPACE)
         rate = speeds%space_torques(component) + speeds%momentum*speeds%frame_speed
      case (Q_EULER)
         ! θ is the rotation about the line of nodes, which is perpendicular to axis 3.
         if (component == THETA) rate = speeds%tilting + speeds%frame_speed
      case (Q_ENERGY)
         select case (component)
         case (KINETIC)
            rate = speeds%kinetic_rate
         case (POTENTIAL)
            rate = speeds%potential_rate
         case default
            rate = speeds%total_rate
         end select
      case (Q_JACOBI)
         rate = speeds%jacobi_rate
      case (Q_WHEEL_SPEED)
         rate = speeds%wheel_rates(quantity%number)
      case (Q_WHEEL_MOMENTUM)
         rate = speeds%drives(quantity%number)
      case default
         continue
      end select
   end function fastest_rate

   !> Returns a bound of a component, with a margin of a hundredth if errors of a computed motion matter; negative if
   !> none is known.
   pure real(wp) function greatest_value(quantity, component, speeds) result(value)
      type(quantity_t), intent(in) :: quantity
      integer, intent(in) :: component
      type(speed_bounds_t), intent(in) :: speeds
      real(wp), parameter :: margin = 1.01_wp, longest_quaternion = 1.001_wp, half_turn = pi*(1 + 4*eps)
      value = -1.0_wp
      select case (quantity%kind)
      case (Q_QUATERNION)
         value = longest_quaternion
      case (Q_CONJUGATE_MOMENTUM)
         value = 2*margin*speeds%momentum
      case (Q_RATE)
         value = margin*speeds%axis_speeds(component)
      case (Q_SPEED, Q_RATE_SPACE)
         value = margin*speeds%speed
      case (Q_MOMENTUM)
         value = margin*speeds%axis_momenta(component)
      case (Q_MOMENTUM_SPACE)
         value = margin*speeds%momentum
      case (Q_EULER)
         if (component == THETA) value = half_turn
      case (Q_ENERGY)
         if (component == KINETIC .and. speeds%kinetic_rate >= 0.0_wp) value = 0.5_wp*margin*speeds%root_energy**2
      case default
         continue
      end select
   end function greatest_value

   pure function unit(q)
      real(wp), intent(in) :: q(4)
      real(wp) :: unit(4)
      unit = (1/quat_norm(q))*q
   end function unit

   !> Returns an Euler angle of an attitude, rad.
   pure real(wp) function euler_angle(angle, q) result(x)
      !> `PHI`, `THETA` or `PSI`.
      integer, intent(in) :: angle
      !> Unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: phi_now, theta_now, psi_now
      if (angle == THETA) then
         x = 2*atan2(sqrt(q(2)*q(2) + q(3)*q(3)), sqrt(q(1)*q(1) + q(4)*q(4)))
         return
      end if
      call euler_from_quat(q, phi_now, theta_now, psi_now)
      x = phi_now
      if (angle == PSI) x = psi_now
   end function euler_angle

   !> Returns true beside a pole of angles: where one turns more than 10⁴ times as fast as the body, for an instant.
   !> A search for events would follow thousands of revolutions that do not happen.
   pure logical function is_beside_pole(numerator, sine, omega)
      !> Numerator and denominator of the rate: rad/s, positive sine of the distance from the pole; rate of the body,
      !> rad/s, shape (3).
      real(wp), intent(in) :: numerator, sine, omega(3)
      is_beside_pole = abs(numerator) > 1e4_wp*vector_length(omega)*sine .or. .not. sine > 0.0_wp
   end function is_beside_pole

   !> Returns the rate of an Euler angle, rad/s. With γ = Rᵀe₃ = (sin θ sin ψ, sin θ cos ψ, cos θ):
   !> φ' = (Ω1 sin ψ + Ω2 cos ψ)/sin θ, θ' = Ω1 cos ψ - Ω2 sin ψ, ψ' = Ω3 - φ' cos θ. At a pole, ψ = 0 and all of Ω3 is
   !> assigned to φ.
   pure real(wp) function euler_rate(angle, q, omega) result(rate)
      !> `PHI`, `THETA` or `PSI`.
      integer, intent(in) :: angle
      !> Attitude, body→space, of any length, shape (4); Ω against the space axes, body axes, rad/s, shape (3).
      real(wp), intent(in) :: q(4), omega(3)
      real(wp) :: gamma(2), cosine, sine, precession, square
      square = q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)
      gamma(1) = 2*(q(2)*q(4) - q(1)*q(3))/square
      gamma(2) = 2*(q(3)*q(4) + q(1)*q(2))/square
      cosine = ((q(1)*q(1) + q(4)*q(4)) - (q(2)*q(2) + q(3)*q(3)))/square
      sine = sqrt(gamma(1)*gamma(1) + gamma(2)*gamma(2))
      precession = sign(omega(3), omega(3)*cosine)
      if (sine > 4*eps) gamma = gamma/sine
      square = omega(1)*gamma(1) + omega(2)*gamma(2)
      if (sine > 4*eps .and. .not. is_beside_pole(square, sine, omega)) then
         precession = square/sine
      else
         gamma = [0.0_wp, 1.0_wp]
      end if
      select case (angle)
      case (PHI)
         rate = precession
      case (THETA)
         rate = omega(1)*gamma(2) - omega(2)*gamma(1)
      case default
         rate = omega(3) - precession*cosine
      end select
   end function euler_rate

end module nutate_quantity_motion
