!> Interpolation between two attitudes a time apart: a rotation at a constant rate, or a cubic polynomial of the
!> rotation vector that has the angular velocities of both.
module nutate_attitude_between
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, quat_conjugate, quat_exp, quat_log, quat_normalized, quat_product
   implicit none
   private

   public :: constant_rate, cubic_between, shorter_log

contains

   !> Returns the attitude between two at a constant rate, the shorter way: the spherical linear interpolation of glTF,
   !> of SPICE's CK of type 3, and of most readers of AEM.
   pure function constant_rate(q1, q2, s) result(q)
      !> Both attitudes, unit quaternions.
      real(wp), intent(in) :: q1(4), q2(4)
      !> Fraction of the time between them.
      real(wp), intent(in) :: s
      real(wp) :: q(4)
      q = quat_product(q1, quat_exp(s*shorter_log(quat_product(quat_conjugate(q1), q2))))
   end function constant_rate

   !> Returns the logarithm of a quaternion or of its negative, half of the shorter rotation.
   pure function shorter_log(q) result(v)
      real(wp), intent(in) :: q(4)
      real(wp) :: v(3)
      v = quat_log(merge(q, -q, q(1) >= 0.0_wp))
   end function shorter_log

   !> Computes attitude and angular velocity between two attitudes with rates: the cubic polynomial of the rotation
   !> vector from the first that has both rates. The error is h⁴/384 of the vector's fourth derivative.
   pure subroutine cubic_between(q1, turn, omega1, omega2, h, s, q, omega)
      !> The first attitude, unit quaternion; the rotation vector from it to the second, body axes, rad; shape (3).
      real(wp), intent(in) :: q1(4), turn(3)
      !> Angular velocities at both attitudes, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega1(3), omega2(3)
      !> The time from one to the other, s, and the fraction of it that has passed.
      real(wp), intent(in) :: h, s
      real(wp), intent(out) :: q(4), omega(3)
      real(wp) :: first(3), last(3), phi(3), rate(3)
      first = h*omega1
      last = h*vector_rate(turn, omega2)
      phi = s*((1 - s)**2*first + s*((3 - 2*s)*turn - (1 - s)*last))
      rate = ((1 - s)*((1 - 3*s)*first + 6*s*turn) + s*(3*s - 2)*last)/h
      q = quat_normalized(quat_product(q1, quat_exp(0.5_wp*phi)))
      omega = body_rate(phi, rate)
   end subroutine cubic_between

   !> Returns the rate of the rotation vector φ of a body that rotates with Ω: Ω + ½φ×Ω + (1 - ½|φ| cot ½|φ|)/|φ|²
   !> φ×(φ×Ω).
   pure function vector_rate(phi, omega) result(rate)
      real(wp), intent(in) :: phi(3), omega(3)
      real(wp) :: rate(3), angle, factor, half
      angle = norm2(phi)
      half = 0.5_wp*angle
      factor = 1.0_wp/12
      ! Near multiples of 2π the vector is singular; the rate along it is not.
      if (angle > 1e-3_wp) factor = (1 - half*cos(half)/sign(max(abs(sin(half)), 1e-6_wp), sin(half)))/angle**2
      rate = omega + 0.5_wp*cross(phi, omega) + factor*cross(phi, cross(phi, omega))
   end function vector_rate

   !> Returns Ω of a body whose rotation vector φ has a given rate: the inverse of `vector_rate`.
   pure function body_rate(phi, rate) result(omega)
      real(wp), intent(in) :: phi(3), rate(3)
      real(wp) :: omega(3), angle, first, second
      angle = norm2(phi)
      first = 0.5_wp - angle**2/24
      second = 1.0_wp/6 - angle**2/120
      if (angle > 1e-2_wp) then
         first = (1 - cos(angle))/angle**2
         second = (angle - sin(angle))/angle**3
      end if
      omega = rate - first*cross(phi, rate) + second*cross(phi, cross(phi, rate))
   end function body_rate

end module nutate_attitude_between
