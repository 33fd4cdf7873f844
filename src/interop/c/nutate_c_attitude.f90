!> C interface: attitudes in their several forms. The functions are documented in `include/nutate_attitude.h`.
!>
!> Results go through local variables, so that a result may overwrite an argument.
module nutate_c_attitude
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use nutate_attitude, only: angular_velocity_from_euler_rates, axis_angle_from_quat, euler_from_quat, follow_euler, &
      quat_from_axis_angle, quat_from_euler, quat_from_matrix, quat_from_rotation_vector, rotation_vector_from_quat
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, is_direction, is_moderate
   use nutate_quaternion, only: attitude_distance, quat_normalized, quat_product, rotate_to_body, rotate_to_space, &
      rotation_matrix
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_OK
   implicit none
   private

   public :: nutate_matrix_from_quat, nutate_quat_from_matrix, nutate_euler_from_quat, nutate_follow_euler, &
      nutate_quat_from_euler, nutate_omega_from_euler_rates, nutate_quat_from_axis_angle, nutate_axis_angle_from_quat, &
      nutate_quat_from_rotation_vector, nutate_rotation_vector_from_quat, nutate_quat_product, nutate_quat_normalized, &
      nutate_rotate_to_space, nutate_rotate_to_body, nutate_attitude_distance

contains

   integer(c_int) function nutate_matrix_from_quat(q, r) result(code) bind(C)
      real(c_double), intent(in), optional :: q(4)
      !> Rotation matrix, body to space, as C's r[3][3]: the transpose of this array.
      real(c_double), intent(inout), optional :: r(3, 3)
      code = code_if(is_attitude(q) .and. present(r))
      if (code == NUTATE_OK) r = transpose(rotation_matrix(quat_normalized(q)))
   end function nutate_matrix_from_quat

   integer(c_int) function nutate_quat_from_matrix(r, q) result(code) bind(C)
      !> Rotation matrix, body to space, as C's r[3][3]: the transpose of this array.
      real(c_double), intent(in), optional :: r(3, 3)
      real(c_double), intent(inout), optional :: q(4)
      real(wp) :: product(3, 3)
      integer :: i
      code = NUTATE_BAD_ARGUMENT
      if (.not. (present(r) .and. present(q))) return
      if (.not. all(is_moderate(r))) return
      if (maxval(abs(r)) > 2) return
      product = matmul(r, transpose(r))
      do i = 1, 3
         product(i, i) = product(i, i) - 1
      end do
      if (maxval(abs(product)) > attitude_tolerance .or. determinant(r) < 0.0_wp) return
      q = quat_from_matrix(transpose(r))
      code = NUTATE_OK
   end function nutate_quat_from_matrix

   integer(c_int) function nutate_euler_from_quat(q, angles) result(code) bind(C)
      real(c_double), intent(in), optional :: q(4)
      real(c_double), intent(inout), optional :: angles(3)
      code = code_if(is_attitude(q) .and. present(angles))
      if (code == NUTATE_OK) call euler_from_quat(q, angles(1), angles(2), angles(3))
   end function nutate_euler_from_quat

   integer(c_int) function nutate_follow_euler(q, angles) result(code) bind(C)
      real(c_double), intent(in), optional :: q(4)
      real(c_double), intent(inout), optional :: angles(3)
      real(wp) :: side
      code = code_if(is_attitude(q) .and. is_vector(angles))
      if (code /= NUTATE_OK) return
      ! The sign of q is chosen to continue the earlier attitude.
      side = sign(1.0_wp, dot_product(q, quat_from_euler(angles(1), angles(2), angles(3))))
      call follow_euler(side*q, angles(1), angles(2), angles(3))
   end function nutate_follow_euler

   integer(c_int) function nutate_quat_from_euler(angles, q) result(code) bind(C)
      real(c_double), intent(in), optional :: angles(3)
      real(c_double), intent(inout), optional :: q(4)
      code = code_if(is_vector(angles) .and. present(q))
      if (code == NUTATE_OK) q = quat_from_euler(angles(1), angles(2), angles(3))
   end function nutate_quat_from_euler

   integer(c_int) function nutate_omega_from_euler_rates(angles, rates, omega) result(code) bind(C)
      real(c_double), intent(in), optional :: angles(3), rates(3)
      real(c_double), intent(inout), optional :: omega(3)
      code = code_if(is_vector(angles) .and. is_vector(rates) .and. present(omega))
      if (code == NUTATE_OK) &
         omega = angular_velocity_from_euler_rates(angles(2), angles(3), rates(1), rates(2), rates(3))
   end function nutate_omega_from_euler_rates

   integer(c_int) function nutate_quat_from_axis_angle(axis, angle, q) result(code) bind(C)
      real(c_double), intent(in), optional :: axis(3)
      real(c_double), intent(in), value :: angle
      real(c_double), intent(inout), optional :: q(4)
      type(status_t) :: status
      real(wp) :: unit(4)
      code = code_if(is_vector(axis) .and. is_moderate(angle) .and. present(q))
      if (code == NUTATE_OK) code = code_if(is_direction(axis))
      if (code /= NUTATE_OK) return
      call quat_from_axis_angle(axis, angle, unit, status)
      code = status%code
      if (code == NUTATE_OK) q = unit
   end function nutate_quat_from_axis_angle

   integer(c_int) function nutate_axis_angle_from_quat(q, axis, angle) result(code) bind(C)
      real(c_double), intent(in), optional :: q(4)
      real(c_double), intent(inout), optional :: axis(3), angle
      code = code_if(is_attitude(q) .and. present(axis) .and. present(angle))
      if (code == NUTATE_OK) call axis_angle_from_quat(q, axis, angle)
   end function nutate_axis_angle_from_quat

   integer(c_int) function nutate_quat_from_rotation_vector(v, q) result(code) bind(C)
      real(c_double), intent(in), optional :: v(3)
      real(c_double), intent(inout), optional :: q(4)
      code = code_if(is_vector(v) .and. present(q))
      if (code == NUTATE_OK) q = quat_from_rotation_vector(v)
   end function nutate_quat_from_rotation_vector

   integer(c_int) function nutate_rotation_vector_from_quat(q, v) result(code) bind(C)
      real(c_double), intent(in), optional :: q(4)
      real(c_double), intent(inout), optional :: v(3)
      code = code_if(is_attitude(q) .and. present(v))
      if (code == NUTATE_OK) v = rotation_vector_from_quat(q)
   end function nutate_rotation_vector_from_quat

   integer(c_int) function nutate_quat_product(a, b, c) result(code) bind(C)
      real(c_double), intent(in), optional :: a(4), b(4)
      real(c_double), intent(inout), optional :: c(4)
      real(wp) :: product(4)
      code = code_if(is_quaternion(a) .and. is_quaternion(b) .and. present(c))
      if (code /= NUTATE_OK) return
      product = quat_product(a, b)
      c = product
   end function nutate_quat_product

   integer(c_int) function nutate_quat_normalized(q, unit) result(code) bind(C)
      real(c_double), intent(in), optional :: q(4)
      real(c_double), intent(inout), optional :: unit(4)
      real(wp) :: normalized(4)
      code = code_if(is_attitude(q) .and. present(unit))
      if (code /= NUTATE_OK) return
      normalized = quat_normalized(q)
      unit = normalized
   end function nutate_quat_normalized

   integer(c_int) function nutate_rotate_to_space(q, v, r) result(code) bind(C)
      real(c_double), intent(in), optional :: q(4), v(3)
      real(c_double), intent(inout), optional :: r(3)
      real(wp) :: rotated(3)
      code = code_if(is_attitude(q) .and. is_vector(v) .and. present(r))
      if (code /= NUTATE_OK) return
      rotated = rotate_to_space(quat_normalized(q), v)
      r = rotated
   end function nutate_rotate_to_space

   integer(c_int) function nutate_rotate_to_body(q, v, r) result(code) bind(C)
      real(c_double), intent(in), optional :: q(4), v(3)
      real(c_double), intent(inout), optional :: r(3)
      real(wp) :: rotated(3)
      code = code_if(is_attitude(q) .and. is_vector(v) .and. present(r))
      if (code /= NUTATE_OK) return
      rotated = rotate_to_body(quat_normalized(q), v)
      r = rotated
   end function nutate_rotate_to_body

   integer(c_int) function nutate_attitude_distance(a, b, angle) result(code) bind(C)
      real(c_double), intent(in), optional :: a(4), b(4)
      real(c_double), intent(inout), optional :: angle
      code = code_if(is_attitude(a) .and. is_attitude(b) .and. present(angle))
      if (code == NUTATE_OK) angle = attitude_distance(quat_normalized(a), quat_normalized(b))
   end function nutate_attitude_distance

   !> Returns success if the arguments are good, else `NUTATE_BAD_ARGUMENT`.
   pure integer(c_int) function code_if(good)
      logical, intent(in) :: good
      code_if = merge(NUTATE_OK, NUTATE_BAD_ARGUMENT, good)
   end function code_if

   !> Returns true if a vector is present and its components are finite and within the limits of the library.
   pure logical function is_vector(v)
      real(wp), intent(in), optional :: v(3)
      is_vector = present(v)
      if (is_vector) is_vector = all(is_moderate(v))
   end function is_vector

   !> Returns true if a quaternion is present and its components are finite and within the limits of the library.
   pure logical function is_quaternion(q)
      real(wp), intent(in), optional :: q(4)
      is_quaternion = present(q)
      if (is_quaternion) is_quaternion = all(is_moderate(q))
   end function is_quaternion

   !> Returns true if `is_quaternion` is true and the quaternion is long enough to have a direction.
   pure logical function is_attitude(q)
      real(wp), intent(in), optional :: q(4)
      is_attitude = is_quaternion(q)
      if (is_attitude) is_attitude = is_direction(q)
   end function is_attitude

   pure real(wp) function determinant(r)
      real(wp), intent(in) :: r(3, 3)
      determinant = r(1, 1)*(r(2, 2)*r(3, 3) - r(2, 3)*r(3, 2)) + r(1, 2)*(r(2, 3)*r(3, 1) - r(2, 1)*r(3, 3)) &
                    + r(1, 3)*(r(2, 1)*r(3, 2) - r(2, 2)*r(3, 1))
   end function determinant

end module nutate_c_attitude
