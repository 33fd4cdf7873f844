!> Rotation of vectors by quaternions, the rotation matrix, and the distance between attitudes.
submodule(suites_of_runs) test_rotation
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_kinds, only: wp, pi, eps
   use nutate_quaternion, only: attitude_distance, cross, quat_conjugate, quat_exp, quat_normalized, quat_product, &
                                rotate_to_body, rotate_to_space, rotation_matrix
   use test_support, only: check_close, error_type, new_unittest, random_unit_quaternion, random_vector
   implicit none

   !> Number of random samples where a test takes any.
   integer, parameter :: samples = 200
   real(wp), parameter :: one(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: e1(3) = [1.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: e2(3) = [0.0_wp, 1.0_wp, 0.0_wp]
   real(wp), parameter :: e3(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   module procedure collect_rotation
      testsuite = [ &
                  new_unittest("quarter turns have the right sense", quarter_turns_have_the_right_sense), &
                  new_unittest("rotations follow Rodrigues' formula", rotations_follow_rodrigues), &
                  new_unittest("rotation, matrix and triple product agree", rotation_matrix_and_product_agree), &
                  new_unittest("rotations compose from right to left", rotations_compose_from_right_to_left), &
                  new_unittest("rotations are quadratic in the quaternion", rotations_are_quadratic), &
                  new_unittest("the rotation matrix is orthogonal", rotation_matrix_is_orthogonal), &
                  new_unittest("the distance of attitudes is the angle between them", distance_is_the_angle), &
                  new_unittest("tiny distances keep every digit", tiny_distances_keep_every_digit), &
                  new_unittest("the distance ignores sign and length", distance_ignores_sign_and_length), &
                  new_unittest("no attitude is at the largest distance", no_attitude_is_at_largest_distance)]
   end procedure collect_rotation

   subroutine quarter_turns_have_the_right_sense(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: x(4), y(4), z(4)
      x = quat_exp(pi/4*e1)
      y = quat_exp(pi/4*e2)
      z = quat_exp(pi/4*e3)
      call check_close(error, [rotate_to_space(z, e1), rotate_to_space(z, e2), rotate_to_space(z, e3)], &
                       [e2, -e1, e3], 2*eps, "about 3")
      call check_close(error, [rotate_to_space(x, e1), rotate_to_space(x, e2), rotate_to_space(x, e3)], &
                       [e1, e3, -e2], 2*eps, "about 1")
      call check_close(error, [rotate_to_space(y, e1), rotate_to_space(y, e2), rotate_to_space(y, e3)], &
                       [-e3, e2, e1], 2*eps, "about 2")
      call check_close(error, [rotate_to_body(z, e1), rotate_to_body(x, e2), rotate_to_body(y, e3)], &
                       [-e2, -e3, -e1], 2*eps, "to body")
   end subroutine quarter_turns_have_the_right_sense

   subroutine rotations_follow_rodrigues(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: n(4), v(3), angle, expected(3)
      integer :: sample
      seed = 19
      do sample = 1, samples
         n = quat_normalized([0.0_wp, random_vector(seed)])
         v = random_vector(seed)
         angle = 2*pi*sample/samples
         expected = cos(angle)*v + sin(angle)*cross(n(2:4), v) + (1 - cos(angle))*dot_product(n(2:4), v)*n(2:4)
         call check_close(error, rotate_to_space(quat_exp(angle/2*n(2:4)), v), expected, 8*eps)
      end do
   end subroutine rotations_follow_rodrigues

   subroutine rotation_matrix_and_product_agree(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: q(4), v(3), r(3, 3), triple(4)
      integer :: n
      seed = 20
      do n = 1, samples
         q = (1 + n/real(samples, wp))*random_unit_quaternion(seed)
         v = random_vector(seed)
         r = rotation_matrix(q)
         triple = quat_product(quat_product(q, [0.0_wp, v]), quat_conjugate(q))
         call check_close(error, rotate_to_space(q, v), matmul(r, v), 16*eps, "R v")
         call check_close(error, rotate_to_space(q, v), triple(2:4), 16*eps, "vec(q∘v∘q*)")
         call check_close(error, rotate_to_body(q, v), matmul(transpose(r), v), 16*eps, "Rᵀ v")
      end do
   end subroutine rotation_matrix_and_product_agree

   subroutine rotations_compose_from_right_to_left(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: a(4), b(4), v(3)
      integer :: n
      seed = 21
      do n = 1, samples
         a = random_unit_quaternion(seed)
         b = random_unit_quaternion(seed)
         v = random_vector(seed)
         call check_close(error, rotate_to_space(quat_product(a, b), v), rotate_to_space(a, rotate_to_space(b, v)), &
                          16*eps, "to space")
         call check_close(error, rotate_to_body(quat_product(a, b), v), rotate_to_body(b, rotate_to_body(a, v)), &
                          16*eps, "to body")
      end do
   end subroutine rotations_compose_from_right_to_left

   subroutine rotations_are_quadratic(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: q(4), v(3)
      seed = 22
      q = random_unit_quaternion(seed)
      v = random_vector(seed)
      call check_close(error, rotate_to_space(4*q, v), 16*rotate_to_space(q, v), 0.0_wp, "to space")
      call check_close(error, rotate_to_body(4*q, v), 16*rotate_to_body(q, v), 0.0_wp, "to body")
      call check_close(error, reshape(rotation_matrix(4*q), [9]), reshape(16*rotation_matrix(q), [9]), 0.0_wp, "matrix")
      call check_close(error, norm2(rotate_to_space(3*q, v)), 9*norm2(v), 9*8*eps, "length")
   end subroutine rotations_are_quadratic

   subroutine rotation_matrix_is_orthogonal(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: r(3, 3)
      integer :: n
      seed = 23
      do n = 1, samples
         r = rotation_matrix(random_unit_quaternion(seed))
         call check_close(error, reshape(matmul(transpose(r), r), [9]), [e1, e2, e3], 8*eps, "RᵀR")
         call check_close(error, cross(r(:, 1), r(:, 2)), r(:, 3), 8*eps, "right-handed")
      end do
   end subroutine rotation_matrix_is_orthogonal

   subroutine distance_is_the_angle(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: angles(8) = [0.0_wp, 1.0e-15_wp, 1.0e-8_wp, 1.0e-3_wp, 1.0_wp, 3.0_wp, pi - 1.0e-9_wp, pi]
      integer(int64) :: seed
      real(wp) :: q(4), turn(4), n(4)
      integer :: i, sample
      seed = 24
      do sample = 1, 20
         q = random_unit_quaternion(seed)
         n = quat_normalized([0.0_wp, random_vector(seed)])
         do i = 1, size(angles)
            turn = quat_exp(angles(i)/2*n(2:4))
            ! Against the identity every digit is there; elsewhere the quaternion itself is rounded.
            call check_close(error, attitude_distance(one, turn), angles(i), 4*eps*angles(i), "from the identity")
            call check_close(error, attitude_distance(q, quat_product(q, turn)), angles(i), 8*eps, "in the body")
            call check_close(error, attitude_distance(quat_product(turn, q), q), angles(i), 8*eps, "in space")
         end do
      end do
   end subroutine distance_is_the_angle

   subroutine tiny_distances_keep_every_digit(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: q(4) = [0.1_wp, 0.5_wp, 0.7_wp, 0.5_wp], h = 2.0_wp**(-50)
      ! Orthogonal to q, and q + change is exact.
      real(wp), parameter :: change(4) = [0.0_wp, h, 0.0_wp, -h]
      call check_close(error, attitude_distance(q, q + change), 2*sqrt(2.0_wp)*h, 4*eps*h)
      call check_close(error, attitude_distance(q + change, -q), 2*sqrt(2.0_wp)*h, 4*eps*h, "other sign")
      call check_close(error, attitude_distance(q, q), 0.0_wp, 0.0_wp, "same attitude")
      call check_close(error, attitude_distance(one, quat_exp(1.0e-300_wp*e2)), 2.0e-300_wp, 1.0e-315_wp, "tiniest")
   end subroutine tiny_distances_keep_every_digit

   subroutine distance_ignores_sign_and_length(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: factors(6) = [-1.0_wp, 3.0_wp, 1.0e-200_wp, -1.0e200_wp, 1.0e-310_wp, -1.0e308_wp]
      integer(int64) :: seed
      real(wp) :: a(4), b(4), angle
      integer :: i, j
      seed = 25
      a = random_unit_quaternion(seed)
      b = random_unit_quaternion(seed)
      angle = attitude_distance(a, b)
      do i = 1, size(factors)
         do j = 1, size(factors)
            ! The factor 1e-310 leaves its quaternion about 45 bits.
            call check_close(error, attitude_distance(factors(i)*a, factors(j)*b), angle, 2**10*eps)
         end do
         call check_close(error, attitude_distance(2*a, -5*b), attitude_distance(b, a), 4*eps, "order")
      end do
   end subroutine distance_ignores_sign_and_length

   subroutine no_attitude_is_at_largest_distance(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: nan(4), infinite(4)
      nan = [ieee_value(1.0_wp, ieee_quiet_nan), 0.0_wp, 0.0_wp, 0.0_wp]
      infinite = [1.0_wp, 0.0_wp, ieee_value(1.0_wp, ieee_positive_inf), 0.0_wp]
      call check_close(error, [attitude_distance(one, 0*one), attitude_distance(0*one, one), &
                               attitude_distance(nan, one), attitude_distance(one, nan), &
                               attitude_distance(infinite, one)], spread(pi, 1, 5), 0.0_wp)
   end subroutine no_attitude_is_at_largest_distance

end submodule test_rotation
