!> Quantities of the motion itself: attitude, angular velocity, momentum, Euler angles.
module nutate_motion_quantities
   use nutate_attitude, only: euler_from_quat
   use nutate_kinds, only: wp, eps, pi
   use nutate_motion, only: motion_t
   use nutate_motion_bounds, only: speed_bounds_t
   use nutate_quantity, only: quantity_t, unit, bound_margin, is_followed, is_stored, other_angles, GREEN, NAVY, &
      OF_MOTION, VERMILION
   use nutate_quaternion, only: cross, quat_norm, quat_product, quat_vector_product, rotate_to_space
   use nutate_small_products, only: vector_length
   implicit none
   private

   public :: motion_fastest, motion_greatest, motion_rate, motion_size, motion_value, is_beside_pole
   public :: Q_QUATERNION, Q_CONJUGATE_MOMENTUM, Q_RATE, Q_RATE_SPACE, Q_MOMENTUM, Q_MOMENTUM_SPACE, Q_EULER

   !> Kinds: one case evaluates all components of a kind.
   enum, bind(c)
      enumerator :: Q_QUATERNION = OF_MOTION, Q_CONJUGATE_MOMENTUM, Q_RATE, Q_RATE_SPACE, Q_MOMENTUM, &
         Q_MOMENTUM_SPACE, Q_EULER, Q_SPEED
   end enum

   !> Components of Euler angles.
   integer, parameter :: PHI = 1, THETA = 2, PSI = 3

   !> Sequences of Euler angles beside 313.
   character(len=3), parameter :: sequences(11) = ['121', '123', '131', '132', '212', '213', '231', '232', '312', &
      '321', '323']
   !> Index of the implied loop of entries.
   integer :: i

   !> Quantities of the motion, in the order of a history.
   type(quantity_t), parameter, public :: motion_quantities(*) = [ &
      quantity_t('quaternion', 'q0,q1,q2,q3', Q_QUATERNION, '', 'attitude quaternion q', 3, &
                 no_measurement=other_angles, symbols='q_0,q_1,q_2,q_3'), &
      quantity_t('conjugate_momentum', 'p0,p1,p2,p3', Q_CONJUGATE_MOMENTUM, 'N m s', 'conjugate momentum p', 20, &
                 no_measurement=is_stored, symbols='p_0,p_1,p_2,p_3'), &
      quantity_t('angular_velocity', 'omega1,omega2,omega3', Q_RATE, 'rad/s', 'angular velocity Ω', 1, axes='body', &
                 attitude=.false., symbols='Ω_1,Ω_2,Ω_3'), &
      quantity_t('angular_velocity_space', 'omega_x,omega_y,omega_z', Q_RATE_SPACE, 'rad/s', &
                 'angular velocity ω in space axes', 2, axes='space', symbols='ω_x,ω_y,ω_z'), &
      quantity_t('angular_speed', 'angular_speed', Q_SPEED, 'rad/s', 'angular speed', 2, NAVY, attitude=.false., &
                 symbols='|Ω|'), &
      quantity_t('angular_momentum', 'L1,L2,L3', Q_MOMENTUM, 'N m s', 'angular momentum L', 18, axes='body', &
                 attitude=.false., symbols='L_1,L_2,L_3'), &
      quantity_t('angular_momentum_space', 'l_x,l_y,l_z', Q_MOMENTUM_SPACE, 'N m s', &
                 'angular momentum l in space axes', 19, axes='space', symbols='l_x,l_y,l_z'), &
      quantity_t('euler', 'phi', Q_EULER, 'rad', 'precession angle φ', 6, VERMILION, is_periodic=.true., &
                 sequence='313', symbols='φ'), &
      quantity_t('euler', 'theta', Q_EULER, 'rad', 'nutation angle θ', 7, GREEN, first=2, sequence='313', &
                 symbols='θ'), &
      quantity_t('euler', 'psi', Q_EULER, 'rad', 'spin angle ψ', 8, NAVY, first=3, is_periodic=.true., &
                 sequence='313', symbols='ψ')]
   !> Euler angles by other sequences, which are followed from step to step.
   type(quantity_t), parameter, public :: followed_quantities(*) = [ &
      [(quantity_t('euler_#', 'euler_#_1,euler_#_2,euler_#_3', Q_EULER, 'rad', 'Euler angles #', 8, &
                   no_event=is_followed, sequence=sequences(i), symbols='α_1,α_2,α_3'), i=1, size(sequences))]]

contains

   !> Returns the value of a component of a quantity.
   pure real(wp) function motion_value(kind, component, motion) result(x)
      integer, intent(in) :: kind, component
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3)
      associate (q => motion%state%q)
         select case (kind)
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
         case default
            x = vector_length(motion%omega)
         end select
      end associate
   end function motion_value

   !> Returns the rate of a component of a quantity along the motion.
   pure real(wp) function motion_rate(kind, component, motion) result(x)
      integer, intent(in) :: kind, component
      !> Motion with its rates.
      type(motion_t), intent(in) :: motion
      real(wp) :: v(3), w(4), torque(3), momentum_rate(3), frame_in_body(3)
      torque = motion%potential_torque + motion%torque
      frame_in_body = motion%omega - motion%relative
      momentum_rate = cross(motion%momentum, motion%omega) + torque
      associate (q => motion%state%q, relative => motion%relative)
         select case (kind)
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
         case default
            x = 0.0_wp
            if (any(abs(motion%omega) > 0.0_wp)) &
               x = dot_product(motion%omega, motion%acceleration)/vector_length(motion%omega)
         end select
      end associate
   end function motion_rate

   !> Returns the size of the vector that a component belongs to, to which its round-off is relative.
   pure real(wp) function motion_size(kind, motion) result(x)
      integer, intent(in) :: kind
      type(motion_t), intent(in) :: motion
      select case (kind)
      case (Q_CONJUGATE_MOMENTUM)
         x = quat_norm(motion%state%p)
      case (Q_RATE, Q_RATE_SPACE, Q_SPEED)
         x = vector_length(motion%omega)
      case (Q_MOMENTUM, Q_MOMENTUM_SPACE)
         x = vector_length(motion%momentum)
      case default
         x = 1.0_wp
      end select
   end function motion_size

   !> Returns a bound of the rate of a component; negative if none is known.
   pure real(wp) function motion_fastest(kind, component, speeds) result(rate)
      integer, intent(in) :: kind, component
      type(speed_bounds_t), intent(in) :: speeds
      select case (kind)
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
      case default
         ! θ is the rotation about the line of nodes, which is perpendicular to axis 3.
         rate = -1.0_wp
         if (component == THETA) rate = speeds%tilting + speeds%frame_speed
      end select
   end function motion_fastest

   !> Returns a bound of a component, with a margin of a hundredth if errors of a computed motion matter; negative if
   !> none is known.
   pure real(wp) function motion_greatest(kind, component, speeds) result(value)
      integer, intent(in) :: kind, component
      type(speed_bounds_t), intent(in) :: speeds
      real(wp), parameter :: longest_quaternion = 1.001_wp, half_turn = pi*(1 + 4*eps)
      select case (kind)
      case (Q_QUATERNION)
         value = longest_quaternion
      case (Q_CONJUGATE_MOMENTUM)
         value = 2*bound_margin*speeds%momentum
      case (Q_RATE)
         value = bound_margin*speeds%axis_speeds(component)
      case (Q_SPEED, Q_RATE_SPACE)
         value = bound_margin*speeds%speed
      case (Q_MOMENTUM)
         value = bound_margin*speeds%axis_momenta(component)
      case (Q_MOMENTUM_SPACE)
         value = bound_margin*speeds%momentum
      case default
         value = merge(half_turn, -1.0_wp, component == THETA)
      end select
   end function motion_greatest

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

end module nutate_motion_quantities
