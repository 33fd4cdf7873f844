!> Attitudes by time, as other programs exchange them, and what lies between them.
module nutate_attitude_rows
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_kinds, only: wp, pi
   use nutate_quaternion, only: cross, quat_conjugate, quat_exp, quat_log, quat_norm, quat_normalized, quat_product, &
      rotate_to_body
   use nutate_scene_labels, only: labels_t
   implicit none
   private

   public :: attitude_rows_t, between_rows, constant_rate, is_unit, put_in_order, turn_rates

   !> Attitudes by time.
   type :: attitude_rows_t
      !> Epoch of t = 0, names of body and axes.
      type(labels_t) :: labels
      !> s, ascending; shape (n).
      real(wp), allocatable :: t(:)
      !> Unit quaternions, body to space, scalar first; shape (4, n).
      real(wp), allocatable :: q(:, :)
      !> Ω relative to the space axes, body axes, rad/s; shape (3, n). Not allocated where rates are not known.
      real(wp), allocatable :: omega(:, :)
   contains
      !> Number of rows.
      procedure :: count => count_rows
   end type attitude_rows_t

contains

   !> Returns the number of rows.
   pure integer function count_rows(self)
      class(attitude_rows_t), intent(in) :: self
      count_rows = 0
      if (allocated(self%t)) count_rows = size(self%t)
   end function count_rows

   !> Returns true for a quaternion whose norm is 1 up to a tolerance. No number of it traps.
   pure logical function is_unit(q, tolerance)
      real(wp), intent(in) :: q(4), tolerance
      is_unit = .false.
      if (.not. all(ieee_is_finite(q))) return
      if (maxval(abs(q)) > 1 + tolerance) return
      is_unit = abs(quat_norm(q) - 1) <= tolerance
   end function is_unit

   !> Brings the rows of a run back in time into ascending order.
   pure subroutine put_in_order(rows)
      type(attitude_rows_t), intent(inout) :: rows
      integer :: n
      n = rows%count()
      if (n < 2) return
      if (rows%t(n) >= rows%t(1)) return
      rows%t = rows%t(n:1:-1)
      rows%q = rows%q(:, n:1:-1)
      if (allocated(rows%omega)) rows%omega = rows%omega(:, n:1:-1)
   end subroutine put_in_order

   !> Turns absolute angular velocities into those relative to space axes that turn.
   pure subroutine turn_rates(rows, rate)
      type(attitude_rows_t), intent(inout) :: rows
      !> Rate of the space axes, in these, rad/s; shape (3).
      real(wp), intent(in) :: rate(3)
      integer :: i
      if (.not. allocated(rows%omega) .or. all(abs(rate) <= 0.0_wp)) return
      do i = 1, rows%count()
         rows%omega(:, i) = rows%omega(:, i) - rotate_to_body(rows%q(:, i), rate)
      end do
   end subroutine turn_rates

   !> Computes attitude and angular velocity between two rows with rates: the cubic polynomial of the rotation vector
   !> from the first row that has both rates. Its error is h⁴/384 of the vector's fourth derivative.
   pure subroutine between_rows(rows, i, k, t, q, omega)
      type(attitude_rows_t), intent(in) :: rows
      !> The rows.
      integer, intent(in) :: i, k
      !> Between theirs, s.
      real(wp), intent(in) :: t
      real(wp), intent(out) :: q(4), omega(3)
      real(wp) :: h, s, turn(3), first(3), last(3), phi(3), rate(3)
      h = rows%t(k) - rows%t(i)
      s = (t - rows%t(i))/h
      first = h*rows%omega(:, i)
      turn = turn_between(rows%q(:, i), rows%q(:, k), 0.5_wp*(first + h*rows%omega(:, k)))
      last = h*vector_rate(turn, rows%omega(:, k))
      phi = s*((1 - s)**2*first + s*((3 - 2*s)*turn - (1 - s)*last))
      rate = ((1 - s)*((1 - 3*s)*first + 6*s*turn) + s*(3*s - 2)*last)/h
      q = quat_normalized(quat_product(rows%q(:, i), quat_exp(0.5_wp*phi)))
      omega = body_rate(phi, rate)
   end subroutine between_rows

   !> Returns the attitude between two at a constant rate, the shorter way: the spherical linear interpolation of glTF,
   !> of SPICE's CK of type 3, and of most readers of AEM.
   pure function constant_rate(q1, q2, s) result(q)
      !> Unit quaternions.
      real(wp), intent(in) :: q1(4), q2(4)
      !> Fraction of the time between them.
      real(wp), intent(in) :: s
      real(wp) :: q(4)
      q = quat_product(q1, quat_exp(s*shorter_log(quat_product(quat_conjugate(q1), q2))))
   end function constant_rate

   !> The logarithm of a quaternion or of its negative, half of the shorter rotation.
   pure function shorter_log(q) result(v)
      real(wp), intent(in) :: q(4)
      real(wp) :: v(3)
      v = quat_log(merge(q, -q, q(1) >= 0.0_wp))
   end function shorter_log

   !> The rotation vector from one attitude to another, with the number of turns that comes nearest to what is expected.
   pure function turn_between(q1, q2, expected) result(phi)
      real(wp), intent(in) :: q1(4), q2(4), expected(3)
      real(wp) :: phi(3), angle
      phi = 2*shorter_log(quat_product(quat_conjugate(q1), q2))
      angle = norm2(phi)
      if (angle > 0.0_wp) then
         phi = phi + phi/angle*2*pi*anint(dot_product(expected - phi, phi/angle)/(2*pi))
      else if (norm2(expected) > pi) then
         phi = expected/norm2(expected)*2*pi*anint(norm2(expected)/(2*pi))
      end if
   end function turn_between

   !> Rate of the rotation vector φ of a body that turns with Ω: Ω + ½φ×Ω + (1 - ½|φ| cot ½|φ|)/|φ|² φ×(φ×Ω).
   pure function vector_rate(phi, omega) result(rate)
      real(wp), intent(in) :: phi(3), omega(3)
      real(wp) :: rate(3), angle, factor, half
      angle = norm2(phi)
      half = 0.5_wp*angle
      factor = 1.0_wp/12
      ! Near whole turns the vector is singular; the rate along it is not.
      if (angle > 1e-3_wp) factor = (1 - half*cos(half)/sign(max(abs(sin(half)), 1e-6_wp), sin(half)))/angle**2
      rate = omega + 0.5_wp*cross(phi, omega) + factor*cross(phi, cross(phi, omega))
   end function vector_rate

   !> Ω of a body whose rotation vector φ has a rate: the inverse of `vector_rate`.
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

end module nutate_attitude_rows
