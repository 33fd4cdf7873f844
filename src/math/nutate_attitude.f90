!> Attitudes in the forms people give and read them: rotation matrix, axis and angle, rotation vector, Euler angles.
!>
!> Every form describes the rotation from body to space, as the quaternion does. Quaternions are scalar first, angles
!> are in radians. A quaternion that is read need not have unit length, and its sign does not matter, unless said.
module nutate_attitude
   use nutate_finite, only: is_finite
   use nutate_kinds, only: wp, pi, eps
   use nutate_quaternion, only: quat_exp, quat_log, quat_norm, quat_normalized, quat_product
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: quat_from_matrix, quat_to_third_axis
   public :: quat_from_axis_angle, axis_angle_from_quat
   public :: quat_from_rotation_vector, rotation_vector_from_quat
   public :: quat_from_euler, euler_from_quat, euler_of_motion, follow_euler, unwrap_angle
   public :: quat_from_roll_pitch_yaw, roll_pitch_yaw_from_quat
   public :: angular_velocity_from_euler_rates

   !> Kinds of z-x-z angles: φ and ψ separate, or only their sum (θ = 0) or their difference (θ = π) defined.
   integer, parameter :: regular = 0, pole_at_zero = 1, pole_at_pi = 2

contains

   !> Returns the unit quaternion of a rotation matrix, with `q0 >= 0`.
   !>
   !> Shepperd, J. Guidance Control 1 (1978) 223: of the four products `4 q_k q` the one with the largest `q_k` is used,
   !> so there is no cancellation at any angle. At 180°, where `q` and `-q` are equally good, the largest component of
   !> the axis is positive.
   pure function quat_from_matrix(r) result(q)
      !> Rotation matrix, body to space, orthogonal to round-off and of determinant 1. Shape: (3,3).
      real(wp), intent(in) :: r(3, 3)
      real(wp) :: q(4)
      real(wp) :: trace, square(4)
      trace = r(1, 1) + r(2, 2) + r(3, 3)
      ! Squares 4 q_k**2; the sum is 4 for any matrix, so the largest is at least 1.
      square = [1 + trace, 1 + 2*r(1, 1) - trace, 1 + 2*r(2, 2) - trace, 1 + 2*r(3, 3) - trace]
      select case (maxloc(square, dim=1))
      case (1)
         q = [square(1), r(3, 2) - r(2, 3), r(1, 3) - r(3, 1), r(2, 1) - r(1, 2)]
      case (2)
         q = [r(3, 2) - r(2, 3), square(2), r(2, 1) + r(1, 2), r(1, 3) + r(3, 1)]
      case (3)
         q = [r(1, 3) - r(3, 1), r(2, 1) + r(1, 2), square(3), r(3, 2) + r(2, 3)]
      case default
         q = [r(2, 1) - r(1, 2), r(1, 3) + r(3, 1), r(3, 2) + r(2, 3), square(4)]
      end select
      q = quat_normalized(q)
      if (q(1) < 0) q = -q
   end function quat_from_matrix

   !> Returns the unit quaternion of the shortest rotation from a direction to the third axis, or to its opposite if
   !> that is nearer: the angle is 90° at most.
   pure function quat_to_third_axis(n) result(q)
      !> Unit vector. Shape: (3).
      real(wp), intent(in) :: n(3)
      real(wp) :: q(4)
      q = [1 + abs(n(3)), sign(1.0_wp, n(3))*n(2), -sign(1.0_wp, n(3))*n(1), 0.0_wp]
      q = q/norm2(q)
   end function quat_to_third_axis

   !> Returns the unit quaternion of the rotation by an angle about an axis: `[cos(angle/2), n sin(angle/2)]`.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for an axis of length zero and for an axis or angle that is not finite; `q` is then
   !> the identity.
   pure subroutine quat_from_axis_angle(axis, angle, q, status)
      !> Direction of the axis, of any length but zero; the same components in body and space. Shape: (3).
      real(wp), intent(in) :: axis(3)
      !> Angle (rad), right-handed about the axis, any finite value.
      real(wp), intent(in) :: angle
      !> Attitude, body to space. Shape: (4).
      real(wp), intent(out) :: q(4)
      type(status_t), intent(out) :: status
      real(wp) :: n(4)
      q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      if (.not. (all(is_finite(axis)) .and. is_finite(angle))) then
         status = fail(NUTATE_BAD_ARGUMENT, "the axis and the angle of a rotation must be finite", "axis")
      else if (maxval(abs(axis)) <= 0) then
         status = fail(NUTATE_BAD_ARGUMENT, "the axis of a rotation must not be zero", "axis")
      else
         n = quat_normalized([0.0_wp, axis])
         q(1) = cos(angle/2)
         q(2:4) = sin(angle/2)*n(2:4)
      end if
   end subroutine quat_from_axis_angle

   !> Returns axis and angle of the shortest rotation to an attitude.
   !>
   !> At 180°, where both directions of the axis are right, it is the vector part of `q` as given.
   pure subroutine axis_angle_from_quat(q, axis, angle)
      !> Attitude, body to space. Shape: (4).
      real(wp), intent(in) :: q(4)
      !> Unit vector along the axis; axis 3 if there is no rotation. Shape: (3).
      real(wp), intent(out) :: axis(3)
      !> Angle about it (rad), in [0, π].
      real(wp), intent(out) :: angle
      real(wp) :: n(4), sine
      n = quat_normalized([0.0_wp, q(2:4)])
      sine = quat_norm([0.0_wp, q(2:4)])
      if (sine <= 0) then
         axis = [0.0_wp, 0.0_wp, 1.0_wp]
         angle = 0
      else
         axis = n(2:4)
         if (q(1) < 0) axis = -axis
         angle = 2*atan2(sine, abs(q(1)))
      end if
   end subroutine axis_angle_from_quat

   !> Returns the unit quaternion of a rotation vector, the axis times the angle.
   pure function quat_from_rotation_vector(v) result(q)
      !> Rotation vector (rad), the same components in body and space. Shape: (3).
      real(wp), intent(in) :: v(3)
      real(wp) :: q(4)
      q = quat_exp(v/2)
   end function quat_from_rotation_vector

   !> Returns the rotation vector (rad) of the shortest rotation to an attitude: `|v| <= π` to round-off.
   !>
   !> At 180°, where `v` and `-v` are right, it points along the vector part of `q` as given.
   pure function rotation_vector_from_quat(q) result(v)
      !> Attitude, body to space. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: v(3)
      v = 2*quat_log(merge(-q, q, q(1) < 0))
   end function rotation_vector_from_quat

   !> Returns the unit quaternion of the z-x-z Euler angles: `exp(k φ/2)∘exp(i θ/2)∘exp(k ψ/2)`.
   pure function quat_from_euler(phi, theta, psi) result(q)
      !> Precession φ about the space axis 3 (rad).
      real(wp), intent(in) :: phi
      !> Nutation θ about the line of nodes, the angle from the space to the body axis 3 (rad).
      real(wp), intent(in) :: theta
      !> Spin ψ about the body axis 3 (rad).
      real(wp), intent(in) :: psi
      real(wp) :: q(4)
      real(wp) :: half_sum, half_difference
      half_sum = (phi + psi)/2
      half_difference = (phi - psi)/2
      q(1) = cos(theta/2)*cos(half_sum)
      q(2) = sin(theta/2)*cos(half_difference)
      q(3) = sin(theta/2)*sin(half_difference)
      q(4) = cos(theta/2)*sin(half_sum)
   end function quat_from_euler

   !> Returns the z-x-z Euler angles of an attitude: φ and ψ in (-π, π], θ in [0, π].
   !>
   !> At the poles (θ within `2 eps` of 0 or π) only φ + ψ or φ - ψ is defined; then ψ = 0. Near them θ keeps its full
   !> accuracy, while φ and ψ are as uncertain as `eps/sin θ` each. The zero quaternion gives zeros.
   pure subroutine euler_from_quat(q, phi, theta, psi)
      !> Attitude, body to space. Shape: (4).
      real(wp), intent(in) :: q(4)
      !> Precession φ (rad).
      real(wp), intent(out) :: phi
      !> Nutation θ (rad).
      real(wp), intent(out) :: theta
      !> Spin ψ (rad).
      real(wp), intent(out) :: psi
      real(wp) :: half_sum, half_difference
      integer :: place
      call locate_euler(q, theta, half_sum, half_difference, place)
      if (place == pole_at_zero) half_difference = half_sum
      if (place == pole_at_pi) half_sum = half_difference
      phi = wrapped(half_sum + half_difference)
      psi = wrapped(half_sum - half_difference)
   end subroutine euler_from_quat

   !> Returns the unit quaternion of the rotation Rz(yaw) Ry(pitch) Rx(roll); shape (4).
   pure function quat_from_roll_pitch_yaw(angles) result(q)
      !> Roll, pitch, yaw (rad). Shape: (3).
      real(wp), intent(in) :: angles(3)
      real(wp) :: q(4), c(3), s(3)
      ! One by one: gfortran at -O3 computes those of an array by its vector functions, which err by up to 4 roundings.
      c = [cos(angles(1)/2), cos(angles(2)/2), cos(angles(3)/2)]
      s = [sin(angles(1)/2), sin(angles(2)/2), sin(angles(3)/2)]
      q(1) = c(1)*c(2)*c(3) + s(1)*s(2)*s(3)
      q(2) = s(1)*c(2)*c(3) - c(1)*s(2)*s(3)
      q(3) = c(1)*s(2)*c(3) + s(1)*c(2)*s(3)
      q(4) = c(1)*c(2)*s(3) - s(1)*s(2)*c(3)
   end function quat_from_roll_pitch_yaw

   !> Returns roll, pitch, yaw of an attitude (rad): roll and yaw in (-π, π], pitch in [-π/2, π/2], where only the sum
   !> or difference of the others is defined; then the roll is 0. Shape: (3).
   pure function roll_pitch_yaw_from_quat(q) result(angles)
      !> Attitude, body to space. Shape: (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: angles(3), square, x(3), up(2), half_sum, half_difference
      square = q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)
      ! Direction of the body's axis 1, and the last components of its axes 2 and 3.
      x = [(q(1)*q(1) + q(2)*q(2)) - (q(3)*q(3) + q(4)*q(4)), 2*(q(2)*q(3) + q(1)*q(4)), 2*(q(2)*q(4) - q(1)*q(3))]
      up = [2*(q(3)*q(4) + q(1)*q(2)), (q(1)*q(1) + q(4)*q(4)) - (q(2)*q(2) + q(3)*q(3))]
      angles(2) = atan2(-x(3), hypot(x(1), x(2)))
      if (hypot(x(1), x(2)) > 0.5_wp*square) then
         angles(1) = atan2(up(1), up(2))
         angles(3) = atan2(x(2), x(1))
      else if (hypot(x(1), x(2)) > 4*eps*square) then
         ! Near a pitch of 90 degrees x and up cancel; sum and difference of roll and yaw are angles in planes of q.
         half_sum = atan2(q(2) + q(4), q(1) - q(3))
         half_difference = atan2(q(4) - q(2), q(1) + q(3))
         angles(1) = wrapped(half_sum - half_difference)
         angles(3) = wrapped(half_sum + half_difference)
      else
         angles(1) = 0.0_wp
         angles(3) = atan2(2*(q(1)*q(4) - q(2)*q(3)), (q(1)*q(1) + q(3)*q(3)) - (q(2)*q(2) + q(4)*q(4)))
      end if
   end function roll_pitch_yaw_from_quat

   !> Returns the z-x-z Euler angles of an attitude in a motion: at a pole, where `euler_from_quat` must choose, those
   !> that the motion goes on from. The line of nodes is then that about which it leaves the pole; where it does not
   !> leave it immediately, ψ = 0.
   pure subroutine euler_of_motion(q, omega, phi, theta, psi)
      !> Attitude, body to space. Shape: (4).
      real(wp), intent(in) :: q(4)
      !> Angular velocity in the direction of the motion to come, body axes (rad/s). Shape: (3).
      real(wp), intent(in) :: omega(3)
      !> Precession φ (rad).
      real(wp), intent(out) :: phi
      !> Nutation θ (rad).
      real(wp), intent(out) :: theta
      !> Spin ψ (rad).
      real(wp), intent(out) :: psi
      real(wp) :: half_sum, half_difference, change(4), least
      integer :: place
      call euler_from_quat(q, phi, theta, psi)
      call locate_euler(q, theta, half_sum, half_difference, place)
      change = quat_product(quat_normalized(q), [0.0_wp, omega])
      least = eps*norm2(omega)
      if (place == pole_at_zero .and. hypot(change(2), change(3)) > least) then
         half_difference = atan2(change(3), change(2))
      else if (place == pole_at_pi .and. hypot(change(1), change(4)) > least) then
         half_sum = atan2(change(4), change(1))
      else
         return
      end if
      phi = wrapped(half_sum + half_difference)
      psi = wrapped(half_sum - half_difference)
   end subroutine euler_of_motion

   !> Replaces the z-x-z angles of an earlier moment by those of `q`, with φ and ψ continued beyond ±π.
   !>
   !> `q` must continue the quaternion of the earlier angles, sign included: then (φ+ψ)/2 and (φ-ψ)/2, which are angles
   !> in its planes of q0, q3 and of q1, q2, are followed as long as φ+ψ and φ-ψ change by less than 2π between calls.
   !> At a pole ψ stays and φ takes the rest. θ does not leave [0, π]: a motion straight through a pole makes φ and ψ
   !> jump by π each, and round-off decides the direction; φ+ψ stays continuous at θ = 0, φ-ψ at θ = π.
   pure subroutine follow_euler(q, phi, theta, psi)
      !> Attitude, body to space. Shape: (4).
      real(wp), intent(in) :: q(4)
      !> Precession φ (rad): on entry the earlier one, on return that of `q`.
      real(wp), intent(inout) :: phi
      !> Nutation θ (rad), in [0, π].
      real(wp), intent(out) :: theta
      !> Spin ψ (rad): on entry the earlier one, on return that of `q`.
      real(wp), intent(inout) :: psi
      real(wp) :: half_sum, half_difference
      integer :: place
      call locate_euler(q, theta, half_sum, half_difference, place)
      half_sum = unwrap_angle((phi + psi)/2, half_sum)
      half_difference = unwrap_angle((phi - psi)/2, half_difference)
      select case (place)
      case (pole_at_zero)
         phi = 2*half_sum - psi
      case (pole_at_pi)
         phi = 2*half_difference + psi
      case default
         phi = half_sum + half_difference
         psi = half_sum - half_difference
      end select
   end subroutine follow_euler

   !> Returns the angle that differs from `angle` by integer multiples of 2π and is nearest to `previous` (rad).
   elemental function unwrap_angle(previous, angle) result(continued)
      !> Angle to come close to (rad).
      real(wp), intent(in) :: previous
      !> Angle known up to multiples of 2π (rad).
      real(wp), intent(in) :: angle
      real(wp) :: continued
      continued = angle + 2*pi*anint((previous - angle)/(2*pi))
   end function unwrap_angle

   !> Returns the body components of the angular velocity (rad/s) that belong to given rates of the z-x-z angles.
   !>
   !> `Ω = [φ' sinθ sinψ + θ' cosψ, φ' sinθ cosψ - θ' sinψ, φ' cosθ + ψ']`; it does not depend on φ.
   pure function angular_velocity_from_euler_rates(theta, psi, phi_dot, theta_dot, psi_dot) result(omega)
      !> Nutation θ (rad).
      real(wp), intent(in) :: theta
      !> Spin ψ (rad).
      real(wp), intent(in) :: psi
      !> Rate of the precession φ' (rad/s).
      real(wp), intent(in) :: phi_dot
      !> Rate of the nutation θ' (rad/s).
      real(wp), intent(in) :: theta_dot
      !> Rate of the spin ψ' (rad/s).
      real(wp), intent(in) :: psi_dot
      real(wp) :: omega(3)
      omega(1) = phi_dot*sin(theta)*sin(psi) + theta_dot*cos(psi)
      omega(2) = phi_dot*sin(theta)*cos(psi) - theta_dot*sin(psi)
      omega(3) = phi_dot*cos(theta) + psi_dot
   end function angular_velocity_from_euler_rates

   !> Computes θ, half the sum and half the difference of φ and ψ, and whether θ is at a pole.
   !>
   !> From `q = [cos(θ/2) cos σ, sin(θ/2) cos δ, sin(θ/2) sin δ, cos(θ/2) sin σ]`, `σ = (φ+ψ)/2`, `δ = (φ-ψ)/2`.
   pure subroutine locate_euler(q, theta, half_sum, half_difference, place)
      real(wp), intent(in) :: q(4)
      real(wp), intent(out) :: theta
      !> Half sum and half difference in [-π, π]; 0 if q does not define them.
      real(wp), intent(out) :: half_sum, half_difference
      integer, intent(out) :: place
      real(wp) :: u(4), cosine, sine
      u = quat_normalized(q)
      cosine = hypot(u(1), u(4))
      sine = hypot(u(2), u(3))
      half_sum = 0
      half_difference = 0
      theta = 0
      if (cosine > 0) half_sum = atan2(u(4), u(1))
      if (sine > 0) then
         half_difference = atan2(u(3), u(2))
         theta = 2*atan2(sine, cosine)
      end if
      place = regular
      if (sine <= eps) then
         place = pole_at_zero
      else if (cosine <= eps) then
         place = pole_at_pi
      end if
   end subroutine locate_euler

   !> Maps an angle of [-2π, 2π] to (-π, π] by at most one revolution.
   elemental function wrapped(angle) result(reduced)
      real(wp), intent(in) :: angle
      real(wp) :: reduced
      reduced = angle
      if (angle > pi) reduced = angle - 2*pi
      if (angle <= -pi) reduced = angle + 2*pi
   end function wrapped

end module nutate_attitude
