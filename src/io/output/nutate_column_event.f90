!> Columns of a history as quantities of events, with their rates in closed form.
module nutate_column_event
   use nutate_attitude, only: roll_pitch_yaw_from_quat, euler_from_quat
   use nutate_columns, only: column_sets
   use nutate_event, only: CROSSING, event_t, most_parts, part_t
   use nutate_hamiltonian, only: potential_energy, time_dependent_power
   use nutate_kinds, only: wp, eps, pi
   use nutate_motion, only: motion_t
   use nutate_motion_bounds, only: speed_bounds_t
   use nutate_quaternion, only: cross, quat_conjugate, quat_norm, quat_product, quat_vector_product, rotate_to_body, &
      rotate_to_space
   use nutate_small_products, only: vector_length
   use nutate_system, only: system_t
   use nutate_tumbling_columns, only: tumbling_rate, tumbling_value
   implicit none
   private

   public :: column_event_t, event_columns, frame_of, natural_period, needs_attitude, shows_orbit, shows_sun, &
      shows_tumbling, wheel_of

   !> Most columns of an event.
   integer, parameter, public :: most_columns = most_parts

   !> The columns that can be asked for, comma separated: those that are smooth functions of the state.
   character(len=*), parameter :: event_columns = &
      'q0,q1,q2,q3,p0,p1,p2,p3,omega1,omega2,omega3,omega_x,omega_y,omega_z,'// &
      'L1,L2,L3,l_x,l_y,l_z,phi,theta,psi,kinetic,potential,total,jacobi,'// &
      'roll,pitch,yaw,orbit_radius,true_anomaly,shadow_depth,'// &
      'energy_ratio,precession_period_short,precession_period_long,rotation_period,pole_longitude,pole_latitude,'// &
      'frame1_q0,frame1_q1,frame1_q2,frame1_q3,frame1_angle,frame2_q0,frame2_q1,frame2_q2,frame2_q3,frame2_angle,'// &
      'frame3_q0,frame3_q1,frame3_q2,frame3_q3,frame3_angle,'// &
      'wheel1_speed,wheel1_momentum,wheel2_speed,wheel2_momentum,wheel3_speed,wheel3_momentum,'// &
      'wheel4_speed,wheel4_momentum,wheel5_speed,wheel5_momentum,wheel6_speed,wheel6_momentum'

   !> Places in it.
   integer, parameter :: AT_Q0 = 1, AT_P0 = 5, AT_OMEGA1 = 9, AT_OMEGA_X = 12, AT_L1 = 15, AT_L_X = 18, AT_PHI = 21, &
      AT_THETA = 22, AT_PSI = 23, AT_KINETIC = 24, AT_POTENTIAL = 25, AT_TOTAL = 26, AT_JACOBI = 27, &
      AT_ROLL = 28, AT_PITCH = 29, AT_YAW = 30, AT_RADIUS = 31, AT_TRUE_ANOMALY = 32, AT_SHADOW = 33, &
      AT_ENERGY_RATIO = 34, AT_LONGITUDE = 38, AT_LATITUDE = 39, AT_FRAME = 40, AT_WHEEL = 55
   !> Columns of a frame.
   integer, parameter :: of_frame = 5

   !> A sum of columns with weights.
   type, extends(event_t) :: column_event_t
      !> Their names; blank: no more.
      character(len=24) :: columns(most_columns) = ''
      real(wp) :: weights(most_columns) = 1.0_wp
      !> How many of them there are, and their places in the list, once `place` has been called.
      integer, private :: n = 0
      integer, private :: places(most_columns) = 0
   contains
      !> Looks the names up, which is not to be done in every step.
      procedure :: place
      procedure :: value => sum_of_columns
      procedure :: rate => rate_of_sum
      procedure :: parts => parts_of_sum
      procedure :: magnitude => size_of_sum
      procedure :: is_out_of_reach => sum_is_out_of_reach
   end type column_event_t

   !> Which Euler angle.
   integer, parameter :: PHI = 1, THETA = 2, PSI = 3

contains

   !> The period of a column: 2π for the angles that have one; 0 for others.
   pure real(wp) function natural_period(column) result(period)
      character(len=*), intent(in) :: column
      period = merge(2*pi, 0.0_wp, any(column == ['phi         ', 'psi         ', 'roll        ', 'yaw         ', &
                                                  'true_anomaly']) .or. column == 'pole_longitude')
   end function natural_period

   !> Returns true for a column that depends on the attitude.
   pure logical function needs_attitude(column)
      character(len=*), intent(in) :: column
      integer :: i
      needs_attitude = column /= 'kinetic' .and. column /= 'potential' .and. column /= 'total'
      do i = 1, size(column_sets)
         if (index(','//trim(column_sets(i)%headers)//',', ','//trim(column)//',') > 0) &
            needs_attitude = column_sets(i)%attitude
      end do
   end function needs_attitude

   !> Finds the columns by their names. An unknown name counts as no column.
   pure subroutine place(self)
      class(column_event_t), intent(inout) :: self
      integer :: i, at, k
      self%n = 0
      do i = 1, most_columns
         if (self%columns(i) == '') return
         at = index(','//event_columns//',', ','//trim(self%columns(i))//',')
         if (at == 0) return
         self%n = i
         self%places(i) = 1 + count([(event_columns(k:k) == ',', k=1, at - 1)])
      end do
   end subroutine place

   !> Returns Σ weights × columns, unit of the columns.
   pure real(wp) function sum_of_columns(self, system, motion) result(g)
      class(column_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      integer :: i
      g = 0.0_wp
      do i = 1, self%n
         g = g + self%weights(i)*column_value(self%places(i), system, motion)
      end do
   end function sum_of_columns

   !> Returns the time derivative of the sum.
   pure real(wp) function rate_of_sum(self, system, motion) result(rate)
      class(column_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      integer :: i
      rate = 0.0_wp
      do i = 1, self%n
         rate = rate + self%weights(i)*column_rate(self%places(i), system, motion)
      end do
   end function rate_of_sum

   !> Returns each weighted column with its rate, so that angles are followed one by one.
   pure subroutine parts_of_sum(self, system, motion, parts)
      class(column_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      type(part_t), intent(out) :: parts(most_parts)
      integer :: i
      do i = 1, self%n
         associate (weight => self%weights(i), column => self%places(i))
            parts(i)%value = weight*column_value(column, system, motion)
            parts(i)%rate = weight*column_rate(column, system, motion)
            if (any(column == [AT_PHI, AT_PSI, AT_ROLL, AT_YAW, AT_LONGITUDE])) parts(i)%wrap = 2*pi*abs(weight)
         end associate
      end do
   end subroutine parts_of_sum

   !> Returns Σ |weights| × size of the columns.
   pure real(wp) function size_of_sum(self, system, motion) result(magnitude)
      class(column_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      integer :: i
      magnitude = 0.0_wp
      do i = 1, self%n
         magnitude = magnitude + abs(self%weights(i))*column_size(self%places(i), system, motion)
      end do
   end function size_of_sum

   !> Size of what a column is a component or a sum of.
   pure real(wp) function column_size(column, system, motion) result(x)
      !> Place in the list.
      integer, intent(in) :: column
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      select case (column)
      case (AT_Q0:AT_Q0 + 3, AT_PHI:AT_PSI, AT_ROLL:AT_YAW, AT_TRUE_ANOMALY, AT_LONGITUDE, AT_LATITUDE, &
            AT_FRAME:AT_WHEEL - 1)
         x = 1.0_wp
      case (AT_P0:AT_P0 + 3)
         x = quat_norm(motion%state%p)
      case (AT_OMEGA1:AT_OMEGA_X + 2)
         x = vector_length(motion%omega)
      case (AT_L1:AT_L_X + 2)
         x = vector_length(motion%momentum)
      case (AT_KINETIC:AT_JACOBI)
         x = 0.5_wp*vector_length(motion%omega)*vector_length(motion%momentum)
         if (column /= AT_KINETIC) x = x + abs(column_value(AT_POTENTIAL, system, motion))
      case default
         x = abs(column_value(column, system, motion))
      end select
   end function column_size

   !> The value of a column; energies without that of an auxiliary inertia, which is none of the body's.
   pure real(wp) function column_value(column, system, motion) result(x)
      !> Place in the list.
      integer, intent(in) :: column
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3)
      associate (q => motion%state%q, omega => motion%omega, momentum => motion%momentum)
         select case (column)
         case (AT_Q0:AT_Q0 + 3)
            x = q(column - AT_Q0 + 1)
         case (AT_P0:AT_P0 + 3)
            x = motion%state%p(column - AT_P0 + 1)
         case (AT_OMEGA1:AT_OMEGA1 + 2)
            x = omega(column - AT_OMEGA1 + 1)
         case (AT_L1:AT_L1 + 2)
            x = momentum(column - AT_L1 + 1)
         case (AT_OMEGA_X:AT_OMEGA_X + 2)
            v = rotate_to_space(unit(q), omega)
            x = v(column - AT_OMEGA_X + 1)
         case (AT_L_X:AT_L_X + 2)
            v = rotate_to_space(unit(q), momentum)
            x = v(column - AT_L_X + 1)
         case (AT_PHI:AT_PSI)
            x = euler_angle(1 + column - AT_PHI, unit(q))
         case (AT_ROLL:AT_SHADOW)
            x = orbit_value(column, system, motion)
         case (AT_ENERGY_RATIO:AT_LATITUDE)
            x = tumbling_value(element(column), system, motion)
         case (AT_FRAME:AT_WHEEL - 1)
            x = frame_value(column - AT_FRAME, system, motion)
         case (AT_WHEEL:)
            x = wheel_value(column - AT_WHEEL, system, motion)
         case default
            x = 0.0_wp
            associate (effects => system%effects, wheels => motion%state%wheel_momentum)
               if (column /= AT_POTENTIAL) x = 0.5_wp*dot_product(omega, momentum - effects%inner_momentum(wheels)) &
                                               + effects%wheel_energy(wheels)
            end associate
            if (column /= AT_KINETIC) x = x + potential_energy(system%effects, q, motion%state%t)
            if (column == AT_JACOBI) x = x - dot_product(omega - motion%relative, momentum)
         end select
      end associate
   end function column_value

   !> Roll, pitch, yaw against the LVLH frame, its radius, true anomaly or shadow; 0 where there is no orbit.
   pure real(wp) function orbit_value(column, system, motion) result(x)
      !> Place in the list.
      integer, intent(in) :: column
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: angles(3)
      x = 0.0_wp
      if (.not. system%effects%on_orbit) return
      associate (orbit => system%effects%orbit, t => motion%state%t)
         select case (column)
         case (AT_RADIUS)
            x = orbit%path%radius(t)
         case (AT_TRUE_ANOMALY)
            x = orbit%path%true_anomaly(t)
         case (AT_SHADOW)
            x = orbit%shadow_depth(t)
         case default
            angles = roll_pitch_yaw_from_quat(quat_product(quat_conjugate(orbit%axes(t)), motion%state%q))
            x = angles(column - AT_ROLL + 1)
         end select
      end associate
   end function orbit_value

   !> Its rate along the motion. With w the body's rate against the LVLH frame: pitch' = w2 cos(roll) - w3 sin(roll),
   !> yaw' = (w2 sin(roll) + w3 cos(roll))/cos(pitch), roll' = w1 + yaw' sin(pitch).
   pure real(wp) function orbit_rate(column, system, motion) result(x)
      !> Place in the list.
      integer, intent(in) :: column
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: angles(3), w(3), velocity(3), place(3)
      x = 0.0_wp
      if (.not. system%effects%on_orbit) return
      associate (orbit => system%effects%orbit, t => motion%state%t)
         select case (column)
         case (AT_RADIUS)
            velocity = orbit%path%velocity(t)
            place = orbit%path%position(t)
            x = dot_product(velocity, place)/orbit%path%radius(t)
         case (AT_TRUE_ANOMALY)
            x = orbit%path%turn_rate(t)
         case (AT_SHADOW)
            x = orbit%shadow_rate(t)
         case default
            angles = roll_pitch_yaw_from_quat(quat_product(quat_conjugate(orbit%axes(t)), motion%state%q))
            w = motion%omega - rotate_to_body(unit(motion%state%q), orbit%axes_rate(t))
            x = w(2)*cos(angles(1)) - w(3)*sin(angles(1))
            if (column == AT_PITCH) return
            x = (w(2)*sin(angles(1)) + w(3)*cos(angles(1)))/max(cos(angles(2)), eps)
            if (column == AT_ROLL) x = w(1) + x*sin(angles(2))
         end select
      end associate
   end function orbit_rate

   !> True for a column that shows an orbit.
   pure logical function shows_orbit(column) result(shows)
      character(len=*), intent(in) :: column
      integer :: k
      shows = .false.
      do k = 1, size(column_sets)
         if (index(','//trim(column_sets(k)%headers)//',', ','//trim(column)//',') > 0) &
            shows = shows .or. column_sets(k)%orbit
      end do
   end function shows_orbit

   !> Which of the columns of tumbling elements: all but the mode and the sense are smooth.
   pure integer function element(column)
      !> Place in the list.
      integer, intent(in) :: column
      element = column - AT_ENERGY_RATIO + 1
      if (element > 1) element = element + 1
   end function element

   !> True for a column that shows tumbling elements.
   pure logical function shows_tumbling(column) result(shows)
      character(len=*), intent(in) :: column
      integer :: k
      shows = .false.
      do k = 1, size(column_sets)
         if (index(','//trim(column_sets(k)%headers)//',', ','//trim(column)//',') > 0) &
            shows = shows .or. column_sets(k)%tumbling
      end do
   end function shows_tumbling

   !> True for a column that shows the sun of an orbit.
   pure logical function shows_sun(column) result(shows)
      character(len=*), intent(in) :: column
      integer :: k
      shows = .false.
      do k = 1, size(column_sets)
         if (index(','//trim(column_sets(k)%headers)//',', ','//trim(column)//',') > 0) &
            shows = shows .or. column_sets(k)%sun
      end do
   end function shows_sun

   !> Speed or momentum of a wheel, rad/s or N m s.
   pure real(wp) function wheel_value(place, system, motion) result(x)
      !> 0: speed of the first, 1: its momentum, 2: speed of the second, ...
      integer, intent(in) :: place
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      integer :: i
      i = 1 + place/2
      x = 0.0_wp
      if (i > system%effects%n_wheels) return
      x = motion%state%wheel_momentum(i)
      if (mod(place, 2) == 0) x = system%effects%wheels(i)%speed_of(x, motion%omega)
   end function wheel_value

   !> Its rate along the motion.
   pure real(wp) function wheel_rate(place, system, motion) result(x)
      integer, intent(in) :: place
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      integer :: i
      i = 1 + place/2
      x = 0.0_wp
      if (i > system%effects%n_wheels) return
      x = motion%wheel_rate(i)
      if (mod(place, 2) == 0) x = system%effects%wheels(i)%speed_of(x, motion%acceleration)
   end function wheel_rate

   !> Attitude relative to a frame, or its angle, rad; 0 for a frame that does not exist.
   pure real(wp) function frame_value(place, system, motion) result(x)
      !> 0: q0 of the first, 1: q1, ..., 4: its angle, 5: q0 of the second, ...
      integer, intent(in) :: place
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: values(of_frame)
      x = 0.0_wp
      if (place/of_frame >= system%effects%n_frames) return
      associate (frame => system%effects%frames(1 + place/of_frame))
         call frame%relative(motion%state%t, quat_product(system%effects%space_axes(motion%state%t), motion%state%q), &
                             values(:4), values(of_frame))
      end associate
      x = values(1 + mod(place, of_frame))
   end function frame_value

   !> Its rate along the motion.
   pure real(wp) function frame_rate(place, system, motion) result(x)
      integer, intent(in) :: place
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: rates(4), q(4), omega(3)
      x = 0.0_wp
      if (place/of_frame >= system%effects%n_frames) return
      associate (frame => system%effects%frames(1 + place/of_frame), t => motion%state%t)
         q = quat_product(system%effects%space_axes(t), motion%state%q)
         omega = motion%relative
         if (system%effects%knows_space_axes()) omega = motion%omega
         if (mod(place, of_frame) == 4) then
            x = frame%angle_rate(t, q, omega)
         else
            rates = frame%quaternion_rate(t, q, omega)
            x = rates(1 + mod(place, of_frame))
         end if
      end associate
   end function frame_rate

   !> The frame that a column refers to; 0: none.
   pure integer function frame_of(column) result(i)
      character(len=*), intent(in) :: column
      i = set_of(column)
      if (i > 0) i = column_sets(i)%frame
   end function frame_of

   !> The wheel that a column shows; 0: it is no wheel's.
   pure integer function wheel_of(column) result(i)
      character(len=*), intent(in) :: column
      i = set_of(column)
      if (i > 0) i = column_sets(i)%wheel
   end function wheel_of

   !> The set that a column belongs to; 0: none.
   pure integer function set_of(column) result(i)
      character(len=*), intent(in) :: column
      do i = size(column_sets), 1, -1
         if (index(','//trim(column_sets(i)%headers)//',', ','//trim(column)//',') > 0) return
      end do
   end function set_of

   !> Its rate along the motion.
   pure real(wp) function column_rate(column, system, motion) result(x)
      !> Place in the list.
      integer, intent(in) :: column
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3), w(4), torque(3), momentum_rate(3), frame_in_body(3)
      torque = motion%potential_torque + motion%torque
      frame_in_body = motion%omega - motion%relative
      momentum_rate = cross(motion%momentum, motion%omega) + torque
      associate (q => motion%state%q, omega => motion%omega, relative => motion%relative)
         select case (column)
         case (AT_Q0:AT_Q0 + 3)
            w = quat_vector_product(q, 0.5_wp*relative)
            x = w(column - AT_Q0 + 1)
         case (AT_P0:AT_P0 + 3)
            ! ṗ of p = 2 q∘[0, L].
            w = quat_product(quat_vector_product(q, relative), [0.0_wp, motion%momentum]) + &
                quat_vector_product(q, 2*momentum_rate)
            x = w(column - AT_P0 + 1)
         case (AT_OMEGA1:AT_OMEGA1 + 2)
            x = motion%acceleration(column - AT_OMEGA1 + 1)
         case (AT_L1:AT_L1 + 2)
            x = momentum_rate(column - AT_L1 + 1)
         case (AT_OMEGA_X:AT_OMEGA_X + 2)
            v = rotate_to_space(unit(q), motion%acceleration + cross(omega, frame_in_body))
            x = v(column - AT_OMEGA_X + 1)
         case (AT_L_X:AT_L_X + 2)
            v = rotate_to_space(unit(q), torque + cross(motion%momentum, frame_in_body))
            x = v(column - AT_L_X + 1)
         case (AT_PHI:AT_PSI)
            x = euler_rate(1 + column - AT_PHI, q, relative)
         case (AT_KINETIC)
            x = dot_product(omega, torque) + motion%inner_power
         case (AT_POTENTIAL)
            x = time_dependent_power_of(system, motion) - dot_product(relative, motion%potential_torque)
         case (AT_JACOBI)
            x = dot_product(relative, motion%torque) + motion%inner_power + time_dependent_power_of(system, motion)
         case (AT_TOTAL)
            x = dot_product(omega, motion%torque) + dot_product(frame_in_body, motion%potential_torque) + &
                motion%inner_power + time_dependent_power_of(system, motion)
         case (AT_ROLL:AT_SHADOW)
            x = orbit_rate(column, system, motion)
         case (AT_ENERGY_RATIO:AT_LATITUDE)
            x = tumbling_rate(element(column), system, motion)
         case (AT_FRAME:AT_WHEEL - 1)
            x = frame_rate(column - AT_FRAME, system, motion)
         case default
            x = wheel_rate(column - AT_WHEEL, system, motion)
         end select
      end associate
   end function column_rate

   !> What the energy of potentials that move changes by, W.
   pure real(wp) function time_dependent_power_of(system, motion) result(power)
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      power = 0.0_wp
      if (system%effects%moves) power = time_dependent_power(system%effects, unit(motion%state%q), motion%state%t)
   end function time_dependent_power_of

   !> Returns true if the bounds of the motion keep the sum from reaching its value for a time. A margin of a quarter
   !> covers the errors of a computed motion.
   pure logical function sum_is_out_of_reach(self, speeds, f, time) result(stays)
      class(column_event_t), intent(in) :: self
      type(speed_bounds_t), intent(in) :: speeds
      real(wp), intent(in) :: f, time
      real(wp), parameter :: margin = 1.25_wp
      real(wp) :: fastest, range, rate, value
      integer :: i
      stays = .false.
      if (self%kind /= CROSSING) return
      fastest = 0.0_wp
      do i = 1, self%n
         rate = fastest_rate(self%places(i), speeds)
         ! An angle that jumps at the poles.
         if (rate < 0.0_wp) return
         fastest = fastest + abs(self%weights(i))*rate
      end do
      stays = abs(f) > margin*fastest*time
      if (stays .or. self%period > 0.0_wp) return
      range = 0.0_wp
      do i = 1, self%n
         value = greatest_value(self%places(i), speeds)
         if (value < 0.0_wp) return
         range = range + abs(self%weights(i))*value
      end do
      stays = abs(self%level) > range
   end function sum_is_out_of_reach

   !> No column changes faster; negative where that is not known.
   pure real(wp) function fastest_rate(column, speeds) result(rate)
      !> Place in the list.
      integer, intent(in) :: column
      type(speed_bounds_t), intent(in) :: speeds
      select case (column)
      case (AT_Q0:AT_Q0 + 3)
         rate = 0.5_wp*(speeds%speed + speeds%frame_speed)
      case (AT_P0:AT_P0 + 3)
         ! p = 2 [0, l]∘q with l in the space axes, which turn, and |q̇| half of the speed against them.
         rate = speeds%momentum*(speeds%speed + 3*speeds%frame_speed) + 2*speeds%torque
      case (AT_OMEGA1:AT_OMEGA1 + 2)
         rate = speeds%accelerations(column - AT_OMEGA1 + 1)
      case (AT_OMEGA_X:AT_OMEGA_X + 2)
         rate = speeds%acceleration + speeds%speed*speeds%frame_speed
      case (AT_L1:AT_L1 + 2)
         rate = speeds%axis_momentum_rates(column - AT_L1 + 1)
      case (AT_L_X:AT_L_X + 2)
         rate = speeds%space_torques(column - AT_L_X + 1) + speeds%momentum*speeds%frame_speed
      case (AT_THETA)
         ! About the line of nodes, which lies across axis 3.
         rate = speeds%tilting + speeds%frame_speed
      case (AT_KINETIC)
         rate = speeds%kinetic_rate
      case (AT_POTENTIAL)
         rate = speeds%potential_rate
      case (AT_TOTAL)
         rate = speeds%total_rate
      case (AT_JACOBI)
         rate = speeds%jacobi_rate
      case (AT_WHEEL:)
         rate = speeds%wheel_rates(1 + (column - AT_WHEEL)/2)
         if (mod(column - AT_WHEEL, 2) == 1) rate = speeds%drives(1 + (column - AT_WHEEL)/2)
      case default
         rate = -1.0_wp
      end select
   end function fastest_rate

   !> No column is greater, with a hundredth for the errors of a computed motion where they count; negative where that
   !> is not known.
   pure real(wp) function greatest_value(column, speeds) result(value)
      !> Place in the list.
      integer, intent(in) :: column
      type(speed_bounds_t), intent(in) :: speeds
      real(wp), parameter :: margin = 1.01_wp, longest_quaternion = 1.001_wp, half_turn = pi*(1 + 4*eps)
      select case (column)
      case (AT_Q0:AT_Q0 + 3)
         value = longest_quaternion
      case (AT_P0:AT_P0 + 3)
         value = 2*margin*speeds%momentum
      case (AT_OMEGA1:AT_OMEGA1 + 2)
         value = margin*speeds%axis_speeds(column - AT_OMEGA1 + 1)
      case (AT_OMEGA_X:AT_OMEGA_X + 2)
         value = margin*speeds%speed
      case (AT_L1:AT_L1 + 2)
         value = margin*speeds%axis_momenta(column - AT_L1 + 1)
      case (AT_L_X:AT_L_X + 2)
         value = margin*speeds%momentum
      case (AT_THETA)
         value = half_turn
      case (AT_KINETIC)
         value = -1.0_wp
         if (speeds%kinetic_rate >= 0.0_wp) value = 0.5_wp*margin*speeds%root_energy**2
      case default
         value = -1.0_wp
      end select
   end function greatest_value

   pure function unit(q)
      real(wp), intent(in) :: q(4)
      real(wp) :: unit(4)
      unit = (1/quat_norm(q))*q
   end function unit

   !> An Euler angle of an attitude, rad.
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

   !> Its rate, rad/s. With γ = Rᵀe₃ = (sin θ sin ψ, sin θ cos ψ, cos θ): φ' = (Ω1 sin ψ + Ω2 cos ψ)/sin θ,
   !> θ' = Ω1 cos ψ - Ω2 sin ψ, ψ' = Ω3 - φ' cos θ; at a pole, where ψ = 0, φ takes all of Ω3.
   pure real(wp) function euler_rate(angle, q, omega) result(rate)
      !> `PHI`, `THETA` or `PSI`.
      integer, intent(in) :: angle
      !> Body→space, of any length; against the space axes, body axes, rad/s.
      real(wp), intent(in) :: q(4), omega(3)
      real(wp) :: gamma(2), cosine, sine, precession, square
      square = q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)
      gamma(1) = 2*(q(2)*q(4) - q(1)*q(3))/square
      gamma(2) = 2*(q(3)*q(4) + q(1)*q(2))/square
      cosine = ((q(1)*q(1) + q(4)*q(4)) - (q(2)*q(2) + q(3)*q(3)))/square
      sine = sqrt(gamma(1)*gamma(1) + gamma(2)*gamma(2))
      precession = sign(omega(3), omega(3)*cosine)
      if (sine > 4*eps) then
         gamma = gamma/sine
         precession = (omega(1)*gamma(1) + omega(2)*gamma(2))/sine
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

end module nutate_column_event
