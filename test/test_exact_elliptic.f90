!> Elliptic integrals and functions against 40-digit values, their identities and their limits.
submodule(suites_of_runs) test_exact_elliptic
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_carlson, only: carlson_rc, carlson_rf, carlson_rj
   use nutate_elliptic, only: elliptic_k, jacobi
   use nutate_kinds, only: wp, pi, eps
   use test_support, only: check_below, check_close, error_type, new_unittest, random_unit
   implicit none

contains

   module procedure collect_exact_elliptic
      testsuite = [ &
         new_unittest("symmetric integrals match 40-digit values", symmetric_integrals_match_40_digit_values), &
         new_unittest("complete integrals match 40-digit values", complete_integrals_match_40_digit_values), &
         new_unittest("sn, cn, dn match 40-digit values", functions_match_40_digit_values), &
         new_unittest("identities hold to round-off for any parameter", identities_hold_to_round_off), &
         new_unittest("the functions invert the integral", the_functions_invert_the_integral), &
         new_unittest("Legendre's relation holds", legendres_relation_holds), &
         new_unittest("m1 = 0 gives hyperbolic functions", no_complement_gives_hyperbolic_functions), &
         new_unittest("m1 = 1 gives circular functions", full_complement_gives_circular_functions), &
         new_unittest("a million periods cost their rounding only", a_million_periods_cost_their_rounding_only)]
   end procedure collect_exact_elliptic

   !> |actual/expected - 1| <= tolerance.
   subroutine check_relative(error, actual, expected, tolerance, label)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: actual, expected, tolerance
      character(len=*), intent(in) :: label
      call check_close(error, actual/expected, 1.0_wp, tolerance, label)
   end subroutine check_relative

   subroutine symmetric_integrals_match_40_digit_values(error)
      type(error_type), allocatable, intent(out) :: error
      ! mpmath elliprj, elliprf, elliprd, 60 digits: x, y, z, p, R_J, R_F, R_D
      real(wp), parameter :: rows(7, 5) = reshape([ &
         1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, &
         2.3984809974956776218e-1_wp, 7.2694593546890819854e-1_wp, 2.9046028102899064423e-1_wp, &
         0.0_wp, 0.5_wp, 1.0_wp, 1.0e-6_wp, &
         6.656230527954104629e+3_wp, 1.8540746773013719184_wp, 3.0205847775221784955_wp, &
         1.0e-20_wp, 2.0e-10_wp, 1.0_wp, 1.0e-15_wp, &
         1.0501087731475504638e+13_wp, 12.552639165344966695_wp, 34.657917499350693955_wp, &
         1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, &
         0.1_wp, 7.0_wp, 2.0_wp, 1.0e5_wp, &
         2.1396946352630161683e-5_wp, 7.1816609147451484249e-1_wp, 4.0082411942131460916e-1_wp], [7, 5])
      ! x, y, R_C
      real(wp), parameter :: rc(3, 7) = reshape([1.0_wp, 2.0_wp, 7.8539816339744830962e-1_wp, &
         2.0_wp, 1.0_wp, 8.8137358701954302523e-1_wp, 0.0_wp, 3.0_wp, 9.068996821171089253e-1_wp, &
         1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1 + 2.0_wp**(-30), 9.9999999968955914197e-1_wp, &
         1.0_wp, 1 - 2.0_wp**(-30), 1.0000000003104408584_wp, 5.0_wp, 1.0e-9_wp, 5.3037292138348089834_wp], [3, 7])
      integer :: i
      do i = 1, size(rows, 2)
         associate (x => rows(1, i), y => rows(2, i), z => rows(3, i), p => rows(4, i))
            call check_relative(error, carlson_rj(x, y, z, p), rows(5, i), 8*eps, "R_J")
            call check_relative(error, carlson_rf(x, y, z), rows(6, i), 6*eps, "R_F")
            call check_relative(error, carlson_rj(x, y, z, z), rows(7, i), 8*eps, "R_D")
         end associate
      end do
      do i = 1, size(rc, 2)
         call check_relative(error, carlson_rc(rc(1, i), rc(2, i)), rc(3, i), 4*eps, "R_C")
      end do
   end subroutine symmetric_integrals_match_40_digit_values

   subroutine complete_integrals_match_40_digit_values(error)
      type(error_type), allocatable, intent(out) :: error
      ! mpmath agm and ellipe, 400 digits: m1, K, E
      real(wp), parameter :: rows(3, 9) = reshape([ &
         1.0_wp, 1.5707963267948966192_wp, 1.5707963267948966192_wp, &
         0.75_wp, 1.6857503548125960429_wp, 1.4674622093394271555_wp, &
         0.5_wp, 1.8540746773013719184_wp, 1.3506438810476755025_wp, &
         0.1_wp, 2.5780921133481731621_wp, 1.1047747327040733306_wp, &
         0.001_wp, 4.8411325605502970199_wp, 1.0021707908344451659_wp, &
         1.0e-8_wp, 10.59663475708766031_wp, 1.0000000504831738439_wp, &
         1.0e-16_wp, 19.806975105072256572_wp, 1.0000000000000009653_wp, &
         1.0e-100_wp, 116.51554901082217481_wp, 1.0_wp, &
         1.0e-300_wp, 346.77405831022674321_wp, 1.0_wp], [3, 9])
      integer :: i
      do i = 1, size(rows, 2)
         call check_relative(error, elliptic_k(rows(1, i)), rows(2, i), 4*eps, "K")
         call check_relative(error, elliptic_e(rows(1, i)), rows(3, i), 5*eps, "E")
      end do
   end subroutine complete_integrals_match_40_digit_values

   subroutine functions_match_40_digit_values(error)
      type(error_type), allocatable, intent(out) :: error
      ! descending Landen transformation with 700 digits: u, m1, sn, cn, dn
      real(wp), parameter :: rows(5, 12) = reshape([ &
         0.75_wp, 1.0_wp, 6.8163876002333416673e-1_wp, 7.3168886887382088631e-1_wp, 1.0_wp, &
         1.25_wp, 0.5_wp, 9.0485151397965262273e-1_wp, 4.257273043260562519e-1_wp, 7.6851927030124967266e-1_wp, &
         -4.5_wp, 0.5_wp, 6.8577106463888359414e-1_wp, -7.2781731698555520103e-1_wp, 8.7456218958518099753e-1_wp, &
         30.0_wp, 0.25_wp, 1.8920514019642463614e-1_wp, -9.819375819894313926e-1_wp, 9.8648419206413970483e-1_wp, &
         3.0_wp, 1.0e-8_wp, 9.9505475610037175777e-1_wp, 9.932790323987350799e-2_wp, 9.9327953081543719613e-2_wp, &
         11.0_wp, 1.0e-8_wp, 9.999999991413933286e-1_wp, -4.143927294316215727e-5_wp, 1.0824607764203633272e-4_wp, &
         20.0_wp, 1.0e-30_wp, 9.999999999999999915e-1_wp, 4.1223072448770549928e-9_wp, 4.1223072448771762841e-9_wp, &
         36.0_wp, 1.0e-30_wp, 1.0_wp, -7.4999377340685570637e-17_wp, 1.002808509438113326e-15_wp, &
         5.0_wp, 1.0e-300_wp, 9.9990920426259513121e-1_wp, 1.3475282221304557306e-2_wp, 1.3475282221304557306e-2_wp, &
         340.0_wp, 1.0e-300_wp, 1.0_wp, 4.374269949163494789e-148_wp, 4.3742813796273786674e-148_wp, &
         346.0_wp, 1.0e-300_wp, 1.0_wp, 8.5370561975912075553e-151_wp, 1.3148434451326532341e-150_wp, &
         2.0_wp, 2.0_wp, 6.1285796745166631447e-1_wp, -7.9019308509440419698e-1_wp, 1.1728575737356124895_wp], [5, 12])
      real(wp) :: sn, cn, dn
      integer :: i
      do i = 1, size(rows, 2)
         call jacobi(rows(1, i), rows(2, i), sn, cn, dn)
         ! An error of one rounding of u is admitted next to that of the result: that is what follows from the number u.
         associate (u => abs(rows(1, i)), s => abs(rows(3, i)), c => abs(rows(4, i)), d => rows(5, i))
            call check_close(error, sn, rows(3, i), 3*eps*(s + u*c*d), "sn")
            call check_close(error, cn, rows(4, i), 3*eps*(c + u*s*d), "cn")
            call check_close(error, dn, rows(5, i), 3*eps*(d + u*s*c), "dn")
         end associate
      end do
   end subroutine functions_match_40_digit_values

   subroutine identities_hold_to_round_off(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: u, m1, a(3), b(3), half(3)
      integer :: i
      seed = 20240101_int64
      do i = 1, 300
         m1 = random_unit(seed)
         if (mod(i, 3) == 0) m1 = m1**60
         u = (random_unit(seed) - 0.5_wp)*8*min(elliptic_k(m1), 30.0_wp)
         call jacobi(u, m1, a(1), a(2), a(3))
         call check_close(error, [a(1)**2 + a(2)**2, a(3)**2 - (a(2)**2 + m1*a(1)**2)], [1.0_wp, 0.0_wp], &
            4*eps, "squares")
         call check_below(error, abs(a(3)/sqrt(a(2)**2 + m1*a(1)**2) - 1), 20*eps, "dn keeps its digits")
         ! The addition theorem for u/2 + u/2.
         call jacobi(u/2, m1, half(1), half(2), half(3))
         b = [2*half(1)*half(2)*half(3), half(2)**2 - (half(1)*half(3))**2, &
            half(3)**2 - (1 - m1)*(half(1)*half(2))**2]/(half(2)**2 + (half(1)*half(3))**2)
         call check_close(error, a, b, 10*eps*(1 + abs(u)), "doubling")
      end do
   end subroutine identities_hold_to_round_off

   !> u = F(am u) = sn u R_F(cn² u, dn² u, 1) up to a quarter of a period.
   subroutine the_functions_invert_the_integral(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: u, m1, sn, cn, dn
      integer :: i
      seed = 5_int64
      do i = 1, 200
         m1 = 0.05_wp + 0.95_wp*random_unit(seed)
         u = 2*elliptic_k(m1)*(random_unit(seed) - 0.5_wp)
         call jacobi(u, m1, sn, cn, dn)
         ! du/dam = 1/dn <= 1/√m1.
         call check_close(error, sn*carlson_rf(cn**2, dn**2, 1.0_wp), u, 6*eps*(1 + abs(u))/sqrt(m1))
      end do
   end subroutine the_functions_invert_the_integral

   !> Complete integral of the second kind, DLMF 19.25.1, of m1 = 1 - m.
   pure real(wp) function elliptic_e(m1) result(e)
      real(wp), intent(in) :: m1
      e = 1
      if (m1 < 1.0e-20_wp) return
      e = m1*(carlson_rj(0.0_wp, m1, 1.0_wp, 1.0_wp) + carlson_rj(0.0_wp, 1.0_wp, m1, m1))/3
   end function elliptic_e

   subroutine legendres_relation_holds(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: m, m1, k, k1
      integer :: i
      seed = 77_int64
      do i = 1, 100
         m1 = random_unit(seed)
         m = 1 - m1
         k = elliptic_k(m1)
         k1 = elliptic_k(m)
         call check_close(error, elliptic_e(m1)*k1 + elliptic_e(m)*k - k*k1, pi/2, 8*eps*k*k1)
      end do
   end subroutine legendres_relation_holds

   subroutine no_complement_gives_hyperbolic_functions(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: u(6) = [-3.0_wp, 0.0_wp, 1.0e-12_wp, 0.5_wp, 20.0_wp, 1.0e4_wp]
      real(wp) :: sn, cn, dn, near(3)
      integer :: i
      do i = 1, size(u)
         call jacobi(u(i), 0.0_wp, sn, cn, dn)
         call check_close(error, sn, tanh(u(i)), eps, "tanh")
         call check_close(error, [cn, dn], [1, 1]/cosh(min(abs(u(i)), 700.0_wp)), 2*eps, "sech")
         if (abs(u(i)) > 100) cycle
         call jacobi(u(i), 1.0e-300_wp, near(1), near(2), near(3))
         call check_close(error, near, [sn, cn, dn], 4*eps, "next to the limit")
      end do
      call check_close(error, elliptic_k(0.0_wp), huge(1.0_wp), 0.0_wp)
      call check_close(error, elliptic_e(0.0_wp), 1.0_wp, 0.0_wp)
   end subroutine no_complement_gives_hyperbolic_functions

   subroutine full_complement_gives_circular_functions(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: u(5) = [-9.0_wp, 0.0_wp, 1.0e-200_wp, 1.5_wp, 100.0_wp]
      real(wp) :: sn, cn, dn
      integer :: i
      do i = 1, size(u)
         call jacobi(u(i), 1.0_wp, sn, cn, dn)
         call check_close(error, [sn, cn, dn], [sin(u(i)), cos(u(i)), 1.0_wp], eps*(1 + abs(u(i))))
      end do
   end subroutine full_complement_gives_circular_functions

   subroutine a_million_periods_cost_their_rounding_only(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: m1(4) = [1.0_wp, 0.5_wp, 1.0e-4_wp, 1.0e-12_wp]
      real(wp) :: near(3), far(3), period
      integer :: i
      do i = 1, size(m1)
         period = 4*elliptic_k(m1(i))
         call jacobi(0.7_wp, m1(i), near(1), near(2), near(3))
         call jacobi(0.7_wp + 1.0e6_wp*period, m1(i), far(1), far(2), far(3))
         call check_close(error, far, near, 3*eps*1.0e6_wp*period)
      end do
   end subroutine a_million_periods_cost_their_rounding_only

end submodule test_exact_elliptic
