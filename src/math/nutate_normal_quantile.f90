!> The quantile of the normal distribution by sums, products, quotients and square roots alone, which IEEE 754 defines
!> to the last bit: deviates are the same on every machine, whatever its C library makes of a logarithm.
!>
!> Rational approximations of Wichura, Algorithm AS 241: The percentage points of the normal distribution, Applied
!> Statistics 37 (1988) 477-484: relative error 2e-16 in exact arithmetic.
module nutate_normal_quantile
   use nutate_kinds, only: wp
   implicit none
   private

   public :: normal_quantile, plain_log

   !> Numerators and denominators, lowest power first: near the middle, in the tails, far out in them.
   real(wp), parameter :: middle_above(0:7) = [ &
      3.3871328727963666080e0_wp, 1.3314166789178437745e2_wp, 1.9715909503065514427e3_wp, &
      1.3731693765509461125e4_wp, 4.5921953931549871457e4_wp, 6.7265770927008700853e4_wp, &
      3.3430575583588128105e4_wp, 2.5090809287301226727e3_wp]
   real(wp), parameter :: middle_below(0:7) = [ &
      1.0_wp, 4.2313330701600911252e1_wp, 6.8718700749205790830e2_wp, 5.3941960214247511077e3_wp, &
      2.1213794301586595867e4_wp, 3.9307895800092710610e4_wp, 2.8729085735721942674e4_wp, &
      5.2264952788528545610e3_wp]
   real(wp), parameter :: tail_above(0:7) = [ &
      1.42343711074968357734e0_wp, 4.63033784615654529590e0_wp, 5.76949722146069140550e0_wp, &
      3.64784832476320460504e0_wp, 1.27045825245236838258e0_wp, 2.41780725177450611770e-1_wp, &
      2.27238449892691845833e-2_wp, 7.74545014278341407640e-4_wp]
   real(wp), parameter :: tail_below(0:7) = [ &
      1.0_wp, 2.05319162663775882187e0_wp, 1.67638483018380384940e0_wp, 6.89767334985100004550e-1_wp, &
      1.48103976427480074590e-1_wp, 1.51986665636164571966e-2_wp, 5.47593808499534494600e-4_wp, &
      1.05075007164441684324e-9_wp]
   real(wp), parameter :: far_above(0:7) = [ &
      6.65790464350110377720e0_wp, 5.46378491116411436990e0_wp, 1.78482653991729133580e0_wp, &
      2.96560571828504891230e-1_wp, 2.65321895265761230930e-2_wp, 1.24266094738807843860e-3_wp, &
      2.71155556874348757815e-5_wp, 2.01033439929228813265e-7_wp]
   real(wp), parameter :: far_below(0:7) = [ &
      1.0_wp, 5.99832206555887937690e-1_wp, 1.36929880922735805310e-1_wp, 1.48753612908506148525e-2_wp, &
      7.86869131145613259100e-4_wp, 1.84631831751005468180e-5_wp, 1.42151175831644588870e-7_wp, &
      2.04426310338993978564e-15_wp]

   !> ln 2 as a number of few bits, whose products with exponents are exact, and the rest.
   real(wp), parameter :: ln2_high = 6.93147180369123816490e-01_wp, ln2_low = 1.90821492927058770002e-10_wp
   real(wp), parameter :: sqrt_half = 0.70710678118654752440_wp

contains

   !> Returns the number below which a normal deviate lies with probability p.
   elemental real(wp) function normal_quantile(p) result(z)
      !> Probability between 0 and 1, both excluded.
      real(wp), intent(in) :: p
      real(wp) :: t, r
      t = p - 0.5_wp
      if (abs(t) <= 0.425_wp) then
         r = 0.180625_wp - t*t
         z = t*ratio(middle_above, middle_below, r)
         return
      end if
      r = sqrt(-plain_log(merge(p, 1 - p, t < 0.0_wp)))
      if (r <= 5.0_wp) then
         z = ratio(tail_above, tail_below, r - 1.6_wp)
      else
         z = ratio(far_above, far_below, r - 5.0_wp)
      end if
      z = sign(z, t)
   end function normal_quantile

   pure real(wp) function ratio(above, below, x)
      real(wp), intent(in) :: above(0:7), below(0:7), x
      real(wp) :: a, b
      integer :: i
      a = above(7)
      b = below(7)
      do i = 6, 0, -1
         a = a*x + above(i)
         b = b*x + below(i)
      end do
      ratio = a/b
   end function ratio

   !> Returns ln x from the series of artanh: ln x = k ln 2 + 2 artanh s, s = (m - 1)/(m + 1), x = 2**k m, m next to 1.
   elemental real(wp) function plain_log(x) result(y)
      !> x > 0, not denormal.
      real(wp), intent(in) :: x
      real(wp) :: m, s, s2, tail
      integer :: k, i
      k = exponent(x)
      m = fraction(x)
      if (m < sqrt_half) then
         m = 2*m
         k = k - 1
      end if
      s = (m - 1)/(m + 1)
      s2 = s*s
      ! |s| < 0.172: the remainder of the series is below 1e-18.
      tail = 0.0_wp
      do i = 11, 1, -1
         tail = (tail + 1.0_wp/real(2*i + 1, wp))*s2
      end do
      y = k*ln2_high + (2*(s + s*tail) + k*ln2_low)
   end function plain_log

end module nutate_normal_quantile
