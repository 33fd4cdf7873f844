! Attitudes for FORTRAN 77: external subroutines, see nutate_f77_steps.f90 for what they have in common.

!> NUQ2M converts a quaternion to the rotation matrix.
subroutine nuq2m(q, r, info)
   use nutate_f77_check, only: is_attitude
   use nutate_kinds, only: wp
   use nutate_quaternion, only: rotation_matrix
   implicit none
   !> (input) Attitude, unit quaternion to 5D-10, body to space; dimension (4).
   real(wp), intent(in) :: q(4)
   !> (output) Rotation matrix: a vector's space components are R times its body components; dimension (3,3).
   real(wp), intent(inout) :: r(3, 3)
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   info = 0
   if (.not. is_attitude(q)) info = -1
   if (info == 0) r = rotation_matrix(q)
end subroutine nuq2m

!> NUM2Q converts a rotation matrix to the quaternion with Q(1) >= 0.
subroutine num2q(r, q, info)
   use nutate_attitude, only: quat_from_matrix
   use nutate_f77_check, only: is_rotation
   use nutate_kinds, only: wp
   implicit none
   !> (input) Rotation matrix, body to space, orthogonal to 1D-9 and of determinant 1; dimension (3,3).
   real(wp), intent(in) :: r(3, 3)
   !> (output) Attitude, unit quaternion, body to space; dimension (4).
   real(wp), intent(inout) :: q(4)
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   info = 0
   if (.not. is_rotation(r)) info = -1
   if (info == 0) q = quat_from_matrix(r)
end subroutine num2q

!> NUQ2E converts a quaternion to the Euler angles z-x-z. If THETA is 0 or pi, only the sum or the difference of PHI and
!> PSI is defined; PSI is then 0.
subroutine nuq2e(q, phi, theta, psi, info)
   use nutate_attitude, only: euler_from_quat
   use nutate_f77_check, only: is_attitude
   use nutate_kinds, only: wp
   implicit none
   !> (input) Attitude, unit quaternion to 5D-10, body to space; dimension (4).
   real(wp), intent(in) :: q(4)
   !> (output) Precession about the space axis 3, rad, in (-pi, pi].
   real(wp), intent(inout) :: phi
   !> (output) Nutation, from the space to the body axis 3, rad, in [0, pi].
   real(wp), intent(inout) :: theta
   !> (output) Spin about the body axis 3, rad, in (-pi, pi].
   real(wp), intent(inout) :: psi
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   info = 0
   if (.not. is_attitude(q)) info = -1
   if (info == 0) call euler_from_quat(q, phi, theta, psi)
end subroutine nuq2e

!> NUE2Q converts Euler angles z-x-z to the quaternion.
subroutine nue2q(phi, theta, psi, q, info)
   use nutate_attitude, only: quat_from_euler
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   implicit none
   !> (input) Precession about the space axis 3, rad.
   real(wp), intent(in) :: phi
   !> (input) Nutation about the line of nodes, rad.
   real(wp), intent(in) :: theta
   !> (input) Spin about the body axis 3, rad.
   real(wp), intent(in) :: psi
   !> (output) Attitude, unit quaternion, body to space; dimension (4).
   real(wp), intent(inout) :: q(4)
   !> (output) 0; -i: argument i is wrong.
   integer, intent(out) :: info
   info = 0
   if (.not. is_moderate(phi)) then
      info = -1
   else if (.not. is_moderate(theta)) then
      info = -2
   else if (.not. is_moderate(psi)) then
      info = -3
   else
      q = quat_from_euler(phi, theta, psi)
   end if
end subroutine nue2q
