!> Attitudes as rotation matrix, axis and angle, and rotation vector, to and from the quaternion.
submodule(suites_of_runs) test_attitude
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_attitude, only: axis_angle_from_quat, quat_from_axis_angle, quat_from_matrix, &
                              quat_from_rotation_vector, rotation_vector_from_quat
   use nutate_kinds, only: wp, pi, eps
   use nutate_quaternion, only: attitude_distance, quat_exp, quat_norm, quat_normalized, rotate_to_space, &
                                rotation_matrix
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit_quaternion, &
                           random_vector
   implicit none

   !> Number of random samples where a test takes any.
   integer, parameter :: samples = 200
   real(wp), parameter :: one(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: e1(3) = [1.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: e2(3) = [0.0_wp, 1.0_wp, 0.0_wp]
   real(wp), parameter :: e3(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   module procedure collect_attitude
      testsuite = [ &
                  new_unittest("random matrices give back their quaternion", random_matrices_give_back_quaternion), &
                  new_unittest("matrices up to 180 degrees give back their quaternion", matrices_up_to_180_degrees), &
                  new_unittest("exact matrices give exact quaternions", exact_matrices_give_exact_quaternions), &
                  new_unittest("matrices of tiny rotations keep every digit", matrices_of_tiny_rotations), &
                  new_unittest("axis and angle give the quaternion", axis_and_angle_give_quaternion), &
                  new_unittest("an axis without direction is refused", axis_without_direction_is_refused), &
                  new_unittest("axis and angle come back the shortest way", axis_and_angle_come_back), &
                  new_unittest("rotation vectors come back", rotation_vectors_come_back), &
                  new_unittest("rotation vectors come back the shortest way", rotation_vectors_come_back_shortest)]
   end procedure collect_attitude

   subroutine random_matrices_give_back_quaternion(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: q(4), back(4)
      integer :: n
      seed = 31
      do n = 1, samples
         q = random_unit_quaternion(seed)
         if (q(1) < 0) q = -q
         back = quat_from_matrix(rotation_matrix(q))
         call check_close(error, back, q, 4*eps)
         call check_close(error, quat_norm(back), 1.0_wp, 2*eps, "unit length")
      end do
   end subroutine random_matrices_give_back_quaternion

   subroutine matrices_up_to_180_degrees(error)
      type(error_type), allocatable, intent(out) :: error
      ! Every component of the axis in turn the largest, ties, and either sign.
      integer, parameter :: axes(3, 13) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, -1, 0, 0, 0, -1, &
                                                   1, 1, 0, 0, 1, 1, 1, 0, -1, 1, 1, 1, &
                                                   3, -1, 2, -1, 3, 2, 1, 2, -3], [3, 13])
      real(wp), parameter :: angles(9) = [0.0_wp, 1.0e-9_wp, 1.0_wp, pi/2, 2*pi/3, 3.0_wp, pi - 1.0e-5_wp, &
                                          pi - 1.0e-9_wp, pi]
      real(wp) :: n(4), q(4), back(4)
      integer :: i, j
      do j = 1, size(axes, 2)
         n = quat_normalized([0.0_wp, real(axes(:, j), wp)])
         do i = 1, size(angles)
            q = quat_exp(angles(i)/2*n(2:4))
            back = quat_from_matrix(rotation_matrix(q))
            call check(error, back(1) >= 0, "q0 must not be negative")
            call check_below(error, attitude_distance(back, q), 6*eps, "distance")
            if (angles(i) < pi) call check_close(error, back, q, 3*eps, "sign")
         end do
      end do
   end subroutine matrices_up_to_180_degrees

   subroutine exact_matrices_give_exact_quaternions(error)
      type(error_type), allocatable, intent(out) :: error
      call check_close(error, quat_from_matrix(diagonal(1, 1, 1)), one, 0.0_wp, "identity")
      call check_close(error, quat_from_matrix(diagonal(1, -1, -1)), [0.0_wp, e1], 0.0_wp, "180 about 1")
      call check_close(error, quat_from_matrix(diagonal(-1, 1, -1)), [0.0_wp, e2], 0.0_wp, "180 about 2")
      call check_close(error, quat_from_matrix(diagonal(-1, -1, 1)), [0.0_wp, e3], 0.0_wp, "180 about 3")
      ! Axis 1 to 2, 2 to 3, 3 to 1: 120 degrees about the diagonal; all four branches are equally good.
      call check_close(error, quat_from_matrix(real(reshape([0, 1, 0, 0, 0, 1, 1, 0, 0], [3, 3]), wp)), &
                       [0.5_wp, 0.5_wp, 0.5_wp, 0.5_wp], 0.0_wp, "cyclic exchange")
      ! 180 degrees about the diagonal of 2 and -3.
      call check_close(error, abs(quat_from_matrix(real(reshape([-1, 0, 0, 0, 0, -1, 0, -1, 0], [3, 3]), wp))), &
                       [0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp]*sqrt(0.5_wp), eps, "exchange")
   end subroutine exact_matrices_give_exact_quaternions

   subroutine matrices_of_tiny_rotations(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: v(3) = [3.0e-12_wp, -1.0e-12_wp, 2.0e-100_wp]
      real(wp) :: r(3, 3), q(4)
      r = diagonal(1, 1, 1)
      r(3, 2) = v(1); r(2, 3) = -v(1)
      r(1, 3) = v(2); r(3, 1) = -v(2)
      r(2, 1) = v(3); r(1, 2) = -v(3)
      q = quat_from_matrix(r)
      call check_close(error, q(2:4)/(v/2), [1.0_wp, 1.0_wp, 1.0_wp], 2*eps)
   end subroutine matrices_of_tiny_rotations

   subroutine axis_and_angle_give_quaternion(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: lengths(5) = [1.0_wp, 6.0_wp, 1.0e-200_wp, 1.0e200_wp, 1.0e-322_wp]
      type(status_t) :: status
      real(wp) :: q(4)
      integer :: n
      do n = 1, size(lengths)
         call quat_from_axis_angle(lengths(n)*[2, -1, 2], 2*pi/3, q, status)
         call check(error, status%ok(), status%message)
         call check_close(error, q, [0.5_wp, [2, -1, 2]/sqrt(12.0_wp)], eps)
      end do
      call quat_from_axis_angle([0.0_wp, 0.0_wp, 4.0_wp], pi/2, q, status)
      call check_close(error, rotate_to_space(q, e1), [0.0_wp, 1.0_wp, 0.0_wp], 2*eps, "sense")
   end subroutine axis_and_angle_give_quaternion

   subroutine axis_without_direction_is_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(status_t) :: status
      real(wp) :: q(4), axes(3, 4), angles(4)
      integer :: n
      axes = spread(e3, 2, 4)
      angles = 1
      axes(:, 1) = 0
      axes(2, 2) = ieee_value(1.0_wp, ieee_quiet_nan)
      axes(1, 3) = ieee_value(1.0_wp, ieee_positive_inf)
      angles(4) = ieee_value(1.0_wp, ieee_positive_inf)
      do n = 1, 4
         call quat_from_axis_angle(axes(:, n), angles(n), q, status)
         call check(error, status%code == NUTATE_BAD_ARGUMENT, "not refused")
         call check(error, len_trim(status%message) > 0, "no message")
         call check_close(error, q, one, 0.0_wp, "identity on failure")
      end do
   end subroutine axis_without_direction_is_refused

   subroutine axis_and_angle_come_back(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: n3(3) = [2, -1, 2]/3.0_wp
      real(wp), parameter :: angles(7) = [1.0e-200_wp, 1.0e-8_wp, 1.0_wp, 3.0_wp, pi - 1.0e-9_wp, 4.0_wp, 6.0_wp]
      type(status_t) :: status
      real(wp) :: q(4), axis(3), angle
      integer :: n
      do n = 1, size(angles)
         call quat_from_axis_angle(n3, angles(n), q, status)
         call axis_angle_from_quat(3*q, axis, angle)
         if (angles(n) < pi) then
            call check_close(error, [angle/angles(n), axis], [1.0_wp, n3], 2*eps)
         else
            call check_close(error, [angle, axis], [2*pi - angles(n), -n3], 4*eps)
         end if
      end do
      call axis_angle_from_quat(-one, axis, angle)
      call check_close(error, [angle, axis], [0.0_wp, e3], 0.0_wp, "no rotation")
   end subroutine axis_and_angle_come_back

   subroutine rotation_vectors_come_back(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: angles(8) = [1.0e-300_wp, 1.0e-100_wp, 1.0e-8_wp, 1.0_wp, 2.0_wp, 3.0_wp, &
                                          pi - 1.0e-9_wp, pi]
      integer(int64) :: seed
      real(wp) :: v(3), n(4), q(4)
      integer :: i, sample
      call check_close(error, quat_from_rotation_vector(pi/2*e3), [1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]*sqrt(0.5_wp), eps)
      seed = 32
      do sample = 1, 20
         n = quat_normalized([0.0_wp, random_vector(seed)])
         do i = 1, size(angles)
            v = angles(i)*n(2:4)
            q = quat_from_rotation_vector(v)
            ! Half a turn comes back with either sign.
            if (angles(i) >= pi .and. q(1) < 0) v = -v
            call check_close(error, rotation_vector_from_quat(q), v, 4*eps*angles(i))
         end do
      end do
   end subroutine rotation_vectors_come_back

   subroutine rotation_vectors_come_back_shortest(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: q(4), v(3)
      integer :: n
      call check_close(error, rotation_vector_from_quat(quat_from_rotation_vector(1.5_wp*pi*e1)), -0.5_wp*pi*e1, 4*eps)
      call check_close(error, rotation_vector_from_quat(-one), 0*e1, 0.0_wp, "whole turn")
      seed = 33
      do n = 1, samples
         q = random_unit_quaternion(seed)
         v = rotation_vector_from_quat(q)
         call check_below(error, norm2(v), pi*(1 + 2*eps), "length")
         call check_close(error, rotation_vector_from_quat(-q), v, 0.0_wp, "sign of q")
         call check_below(error, attitude_distance(quat_from_rotation_vector(v), q), 6*eps, "distance")
      end do
   end subroutine rotation_vectors_come_back_shortest

   pure function diagonal(a, b, c) result(r)
      integer, intent(in) :: a, b, c
      real(wp) :: r(3, 3)
      r = 0
      r(1, 1) = a
      r(2, 2) = b
      r(3, 3) = c
   end function diagonal

end submodule test_attitude
