!> Quaternion algebra: products and their matrices, norm, exponential, logarithm, Cayley map.
submodule(suites_of_runs) test_quaternion
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan, ieee_positive_inf, ieee_quiet_nan, &
                                            ieee_value
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_kinds, only: wp, pi, eps
   use nutate_quaternion, only: cayley_map, cross, quat_conjugate, quat_exp, quat_left_matrix, quat_log, quat_norm, &
                                quat_normalized, quat_product, quat_right_matrix, quat_vector_product
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit_quaternion, &
                           random_vector
   implicit none

   !> Number of random samples where a test takes any.
   integer, parameter :: samples = 200
   real(wp), parameter :: one(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: i_unit(4) = [0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: j_unit(4) = [0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp]
   real(wp), parameter :: k_unit(4) = [0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]
   real(wp), parameter :: e1(3) = [1.0_wp, 0.0_wp, 0.0_wp]
   real(wp), parameter :: e2(3) = [0.0_wp, 1.0_wp, 0.0_wp]
   real(wp), parameter :: e3(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   module procedure collect_quaternion
      testsuite = [ &
                  new_unittest("units multiply by Hamilton's table", units_multiply_by_hamiltons_table), &
                  new_unittest("the cross product is right-handed", cross_product_is_right_handed), &
                  new_unittest("the product is associative", product_is_associative), &
                  new_unittest("the norm of a product is the product of norms", norm_is_multiplicative), &
                  new_unittest("the conjugate inverts and reverses products", conjugate_inverts_and_reverses), &
                  new_unittest("left and right matrices give products", matrices_give_products), &
                  new_unittest("left and right matrices commute", left_and_right_matrices_commute), &
                  new_unittest("transposed matrices belong to the conjugate", transpose_is_conjugate), &
                  new_unittest("the norm holds at the ends of the range", norm_holds_at_ends_of_range), &
                  new_unittest("normalisation holds at the ends of the range", normalisation_holds_at_ends_of_range), &
                  new_unittest("the exponential of known vectors is known", exponential_of_known_vectors), &
                  new_unittest("the exponential keeps every digit of tiny angles", exponential_of_tiny_angles), &
                  new_unittest("the logarithm inverts the exponential", logarithm_inverts_exponential), &
                  new_unittest("the logarithm is defined where the axis is not", logarithm_without_axis), &
                  new_unittest("the Cayley map is (1+b)(1-b)^-1", cayley_map_is_its_definition), &
                  new_unittest("the Cayley map turns by 4 atan |b|", cayley_map_turns_by_four_atan)]
   end procedure collect_quaternion

   subroutine units_multiply_by_hamiltons_table(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: actual(4, 9), expected(4, 9)
      actual(:, 1) = quat_product(i_unit, i_unit)
      actual(:, 2) = quat_product(j_unit, j_unit)
      actual(:, 3) = quat_product(k_unit, k_unit)
      actual(:, 4) = quat_product(i_unit, j_unit)
      actual(:, 5) = quat_product(j_unit, i_unit)
      actual(:, 6) = quat_product(j_unit, k_unit)
      actual(:, 7) = quat_product(k_unit, j_unit)
      actual(:, 8) = quat_product(k_unit, i_unit)
      actual(:, 9) = quat_product(i_unit, k_unit)
      expected = reshape([-one, -one, -one, k_unit, -k_unit, i_unit, -i_unit, j_unit, -j_unit], [4, 9])
      call check_close(error, reshape(actual, [36]), reshape(expected, [36]), 0.0_wp)
      ! Integers are exact; computed by hand from (1+2i+3j+4k)(5+6i+7j+8k).
      call check_close(error, quat_product([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp], [5.0_wp, 6.0_wp, 7.0_wp, 8.0_wp]), &
                       [-60.0_wp, 12.0_wp, 30.0_wp, 24.0_wp], 0.0_wp)
   end subroutine units_multiply_by_hamiltons_table

   subroutine cross_product_is_right_handed(error)
      type(error_type), allocatable, intent(out) :: error
      call check_close(error, [cross(e1, e2), cross(e2, e3), cross(e3, e1)], [e3, e1, e2], 0.0_wp)
      call check_close(error, cross([1.0_wp, 2.0_wp, 3.0_wp], [4.0_wp, 6.0_wp, 9.0_wp]), [0.0_wp, 3.0_wp, -2.0_wp], &
                       0.0_wp)
   end subroutine cross_product_is_right_handed

   subroutine product_is_associative(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: a(4), b(4), c(4)
      integer :: n
      seed = 11
      do n = 1, samples
         a = random_unit_quaternion(seed)
         b = random_unit_quaternion(seed)
         c = random_unit_quaternion(seed)
         call check_close(error, quat_product(quat_product(a, b), c), quat_product(a, quat_product(b, c)), 4*eps)
      end do
   end subroutine product_is_associative

   subroutine norm_is_multiplicative(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: a(4), b(4)
      integer :: n
      call check_close(error, quat_norm([1.0_wp, -2.0_wp, -4.0_wp, 2.0_wp]), 5.0_wp, 0.0_wp)
      seed = 12
      do n = 1, samples
         a = 3*random_unit_quaternion(seed)
         b = random_unit_quaternion(seed)/7
         call check_close(error, quat_norm(quat_product(a, b)), quat_norm(a)*quat_norm(b), 4*eps*3/7)
         call check_close(error, quat_norm(a), 3.0_wp, 4*eps*3)
      end do
   end subroutine norm_is_multiplicative

   subroutine conjugate_inverts_and_reverses(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: a(4), b(4)
      integer :: n
      seed = 13
      do n = 1, samples
         a = random_unit_quaternion(seed)
         b = random_unit_quaternion(seed)
         call check_close(error, quat_product(a, quat_conjugate(a)), one, 4*eps, "q∘q*")
         call check_close(error, quat_conjugate(quat_product(a, b)), &
                          quat_product(quat_conjugate(b), quat_conjugate(a)), 2*eps, "(a∘b)*")
      end do
   end subroutine conjugate_inverts_and_reverses

   subroutine matrices_give_products(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: q(4), x(4)
      integer :: n
      seed = 14
      do n = 1, samples
         q = random_unit_quaternion(seed)
         x = random_unit_quaternion(seed)
         call check_close(error, matmul(quat_left_matrix(q), x), quat_product(q, x), 2*eps, "Q(q) x")
         call check_close(error, quat_vector_product(q, x(2:4)), quat_product(q, [0.0_wp, x(2:4)]), 2*eps, "q∘[0, v]")
         call check_close(error, matmul(quat_right_matrix(q), x), quat_product(x, q), 2*eps, "x∘q")
      end do
   end subroutine matrices_give_products

   subroutine left_and_right_matrices_commute(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: left(4, 4), right(4, 4)
      seed = 15
      left = quat_left_matrix(random_unit_quaternion(seed))
      right = quat_right_matrix(random_unit_quaternion(seed))
      call check_close(error, reshape(matmul(left, right), [16]), reshape(matmul(right, left), [16]), 4*eps)
   end subroutine left_and_right_matrices_commute

   subroutine transpose_is_conjugate(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: q(4), left(4, 4), right(4, 4)
      integer :: n
      seed = 16
      q = 2*random_unit_quaternion(seed)
      left = quat_left_matrix(q)
      right = quat_right_matrix(q)
      call check_close(error, reshape(transpose(left), [16]), reshape(quat_left_matrix(quat_conjugate(q)), [16]), &
                       0.0_wp, "left")
      call check_close(error, reshape(transpose(right), [16]), reshape(quat_right_matrix(quat_conjugate(q)), [16]), &
                       0.0_wp, "right")
      left = matmul(left, transpose(left))
      do n = 1, 4
         left(n, n) = left(n, n) - 4
      end do
      call check_below(error, maxval(abs(left)), 16*eps, "Q Qᵀ - |q|²")
   end subroutine transpose_is_conjugate

   subroutine norm_holds_at_ends_of_range(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: q(4) = [1.0_wp, -2.0_wp, -4.0_wp, 2.0_wp]
      real(wp) :: p(4)
      integer :: n
      call check_close(error, quat_norm(scale(q, 1000)), scale(5.0_wp, 1000), 0.0_wp, "large")
      call check_close(error, quat_norm(scale(q, -1060)), scale(5.0_wp, -1060), 0.0_wp, "subnormal")
      call check_close(error, quat_norm(0*q), 0.0_wp, 0.0_wp, "zero")
      call check_close(error, quat_norm(q*0 + huge(1.0_wp)), huge(1.0_wp), 0.0_wp, "beyond the range")
      do n = 1, 4
         p = 0
         p(n) = scale(3.0_wp, 1000)
         call check_close(error, quat_norm(p), scale(3.0_wp, 1000), 0.0_wp, "one large component")
         p = 1
         p(n) = -ieee_value(1.0_wp, ieee_positive_inf)
         call check(error, quat_norm(p) > huge(1.0_wp), "an infinity must show in the norm")
         p(n) = ieee_value(1.0_wp, ieee_quiet_nan)
         call check(error, ieee_is_nan(quat_norm(p)), "a NaN must show in the norm")
      end do
   end subroutine norm_holds_at_ends_of_range

   subroutine normalisation_holds_at_ends_of_range(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: q(4) = [1.0_wp, -4.0_wp, -8.0_wp, 12.0_wp]
      integer, parameter :: powers(5) = [0, 600, 1020, -600, -1074]
      real(wp) :: infinite(4)
      integer :: n
      do n = 1, size(powers)
         call check_close(error, quat_normalized(scale(q, powers(n))), q/15, eps)
      end do
      call check_close(error, quat_normalized(0*q + huge(1.0_wp)), [0.5_wp, 0.5_wp, 0.5_wp, 0.5_wp], eps, "huge")
      call check_close(error, quat_normalized(0*q), 0*q, 0.0_wp, "zero")
      infinite = [0.0_wp, 1.0_wp, 0.0_wp, ieee_value(1.0_wp, ieee_positive_inf)]
      call check(error, .not. any(ieee_is_finite(quat_normalized(infinite)) .neqv. ieee_is_finite(infinite)), &
                 "an infinity must not vanish")
   end subroutine normalisation_holds_at_ends_of_range

   subroutine exponential_of_known_vectors(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: r = sqrt(0.5_wp)
      call check_close(error, quat_exp(0*e1), one, 0.0_wp, "identity")
      call check_close(error, quat_exp(pi/4*e1), [r, r, 0.0_wp, 0.0_wp], eps, "axis 1")
      call check_close(error, quat_exp(-pi/4*e2), [r, 0.0_wp, -r, 0.0_wp], eps, "axis 2")
      call check_close(error, quat_exp(3*pi/4*e3), [-r, 0.0_wp, 0.0_wp, r], 2*eps, "axis 3")
      call check_close(error, quat_exp(pi/3*[2, -1, 2]/3.0_wp), [0.5_wp, [2, -1, 2]/sqrt(12.0_wp)], 2*eps, "oblique")
   end subroutine exponential_of_known_vectors

   subroutine exponential_of_tiny_angles(error)
      type(error_type), allocatable, intent(out) :: error
      ! The angles include both sides of the change from series to sine.
      real(wp), parameter :: angles(7) = [1.0e-300_wp, 1.0e-160_wp, 1.0e-20_wp, 1.0e-8_wp, 9.9e-5_wp, &
                                          1.01e-4_wp, 1.0e-3_wp]
      real(wp) :: a, q(4)
      integer :: n
      do n = 1, size(angles)
         a = angles(n)
         q = quat_exp(a*e3)
         ! sin and cos by Taylor series: what is left out is a**7/5040 of a.
         call check_close(error, q(4), a*(1 - a**2/6*(1 - a**2/20)), eps*a, "sine")
         call check_close(error, q(1), 1 - a**2/2*(1 - a**2/12), eps, "cosine")
      end do
   end subroutine exponential_of_tiny_angles

   subroutine logarithm_inverts_exponential(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: angles(14) = [1.0e-300_wp, 1.0e-160_wp, 1.0e-20_wp, 1.0e-8_wp, 9.9e-5_wp, 1.01e-4_wp, &
                                           1.0e-2_wp, 1.0_wp, pi/2, 2.0_wp, 3.0_wp, pi - 1.0e-6_wp, pi - 1.0e-12_wp, &
                                           pi - 2.0e-15_wp]
      integer(int64) :: seed
      real(wp) :: v(3), q(4), direction(4)
      integer :: n, m
      seed = 17
      do m = 1, 20
         direction = quat_normalized([0.0_wp, random_vector(seed)])
         do n = 1, size(angles)
            v = angles(n)*direction(2:4)
            q = quat_exp(v)
            call check_close(error, quat_log(q), v, 4*eps*angles(n), "log(exp(v))")
            call check_close(error, quat_log(8*q), v, 4*eps*angles(n), "length does not matter")
            call check_close(error, quat_exp(quat_log(q)), q, 4*eps, "exp(log(q))")
         end do
      end do
   end subroutine logarithm_inverts_exponential

   subroutine logarithm_without_axis(error)
      type(error_type), allocatable, intent(out) :: error
      call check_close(error, quat_log(one), 0*e1, 0.0_wp, "identity")
      call check_close(error, quat_log(-one), pi*e1, 0.0_wp, "-1")
      call check_close(error, quat_log(-one - tiny(1.0_wp)/2**20*k_unit), -pi*e3, 0.0_wp, "next to -1")
      call check_close(error, quat_log(0*one), 0*e1, 0.0_wp, "zero")
   end subroutine logarithm_without_axis

   subroutine cayley_map_is_its_definition(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: b(4), c(4), inverse(4)
      integer :: n
      seed = 18
      do n = 1, samples
         b = [0.0_wp, 3*random_vector(seed)]
         inverse = quat_conjugate(one - b)/quat_norm(one - b)**2
         c = cayley_map(b(2:4))
         call check_close(error, c, quat_product(one + b, inverse), 4*eps)
         call check_close(error, quat_norm(c), 1.0_wp, 2*eps, "unit length")
      end do
   end subroutine cayley_map_is_its_definition

   subroutine cayley_map_turns_by_four_atan(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: lengths(9) = [0.0_wp, 1.0e-300_wp, 1.0e-8_wp, 0.1_wp, 1.0_wp, 3.0_wp, 1.0e8_wp, &
                                           1.0e149_wp, 1.0e300_wp]
      real(wp), parameter :: n3(3) = [2, -1, 2]/3.0_wp
      integer :: n
      do n = 1, size(lengths)
         call check_close(error, cayley_map(lengths(n)*n3), quat_exp(2*atan(lengths(n))*n3), 4*eps)
      end do
      call check_close(error, [cayley_map(1.0e300_wp*e1), cayley_map(1.0e300_wp*e2), cayley_map(1.0e300_wp*e3)], &
                       [-one, -one, -one], 0.0_wp, "no overflow")
      call check_close(error, cayley_map(-1.0e-300_wp*e2), [1.0_wp, 0.0_wp, -2.0e-300_wp, 0.0_wp], 0.0_wp)
   end subroutine cayley_map_turns_by_four_atan

end submodule test_quaternion
