!> The principal frame of a body, in which exact solutions are computed, for any handedness and order of the user's
!> axes.
module nutate_principal_frame
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, quat_product
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: check_frame, handedness, identity_frame, time_horizon, rotated

   !> Departure from orthonormality that is treated as round-off of the caller's diagonalisation: some thousand ε.
   real(wp), parameter :: orthonormal_to = 1.0e-12_wp
   !> Binary exponent of the largest angle: 2**56 rad leave no digit of an angle.
   integer, parameter :: largest_angle_power = 56

   !> The body axes themselves.
   real(wp), parameter :: identity_frame(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
      0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

contains

   !> Rejects axes that are not orthonormal.
   pure subroutine check_frame(axes, status)
      !> Columns: axes in body components.
      real(wp), intent(in) :: axes(3, 3)
      !> `NUTATE_BAD_ARGUMENT` if they are not orthonormal.
      type(status_t), intent(out) :: status
      if (.not. all(ieee_is_finite(axes))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'principal axes must be finite')
      else if (maxval(abs(axes)) > 2) then
         status = fail(NUTATE_BAD_ARGUMENT, 'principal axes must be orthonormal')
      else if (maxval(abs(matmul(transpose(axes), axes) - identity_frame)) > orthonormal_to) then
         status = fail(NUTATE_BAD_ARGUMENT, 'principal axes must be orthonormal')
      end if
   end subroutine check_frame

   !> Returns +1 for a right-handed frame, -1 for a left-handed one.
   pure real(wp) function handedness(frame)
      !> Columns: orthonormal axes.
      real(wp), intent(in) :: frame(3, 3)
      handedness = sign(1.0_wp, dot_product(cross(frame(:, 1), frame(:, 2)), frame(:, 3)))
   end function handedness

   !> Returns the attitude q0 followed by a rotation relative to the body that is given in another frame of the body.
   pure function rotated(q0, frame, relative) result(q)
      !> Attitude, body -> space.
      real(wp), intent(in) :: q0(4)
      !> Columns: right-handed orthonormal axes in body components.
      real(wp), intent(in) :: frame(3, 3)
      !> Rotation with its vector part in components of `frame`.
      real(wp), intent(in) :: relative(4)
      real(wp) :: q(4)
      q = quat_product(q0, [relative(1), matmul(frame, relative(2:4))])
   end function rotated

   !> Returns a time beyond which no digit of an angle is left (s), so that products with it cannot overflow.
   pure real(wp) function time_horizon(power) result(horizon)
      !> Binary exponent of the fastest rate (rad/s).
      integer, intent(in) :: power
      horizon = huge(1.0_wp)
      if (largest_angle_power - power < maxexponent(1.0_wp)) horizon = scale(1.0_wp, largest_angle_power - power)
   end function time_horizon

end module nutate_principal_frame
