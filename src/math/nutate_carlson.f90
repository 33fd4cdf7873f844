!> Carlson's symmetric elliptic integrals by duplication.
!>
!> B. C. Carlson, "Numerical computation of real or complex elliptic integrals", Numer. Algorithms 10 (1995) 13-26;
!> the series are equations 19.36.1 and 19.36.2 of the DLMF. Every sum here has terms of one sign, so the results
!> are good to a few units in the last place however far apart the arguments lie.
module nutate_carlson
   use nutate_kinds, only: wp
   implicit none
   private

   public :: carlson_rc, carlson_rf, carlson_rj

   !> Relative spread of the arguments below which the series of degree 7 is exact to round-off.
   real(wp), parameter :: series_radius = 6.0e-3_wp
   !> Duplications at most: a spread of 1e300 needs about 20.
   integer, parameter :: most_duplications = 60

contains

   !> Returns R_F(x, y, z) = ½ ∫₀^∞ dt / √((t+x)(t+y)(t+z)).
   pure real(wp) function carlson_rf(x, y, z) result(rf)
      !> >= 0, at most one of them zero.
      real(wp), intent(in) :: x, y, z
      real(wp) :: v(3), r(3), mean, e2, e3
      integer :: i
      v = [x, y, z]
      do i = 1, most_duplications
         mean = sum(v)/3
         if (maxval(abs(v - mean)) <= series_radius*mean) exit
         r = sqrt(v)
         v = (v + (r(1)*r(2) + r(1)*r(3) + r(2)*r(3)))/4
      end do
      v = (mean - v)/mean
      e2 = v(1)*v(2) - v(3)**2
      e3 = v(1)*v(2)*v(3)
      rf = (1 - e2/10 + e3/14 + e2**2/24 - 3*e2*e3/44 - 5*e2**3/208 + 3*e3**2/104 + e2**2*e3/16)/sqrt(mean)
   end function carlson_rf

   !> Returns R_C(x, y) = R_F(x, y, y) = ½ ∫₀^∞ dt / (√(t+x) (t+y)): an inverse circular or hyperbolic tangent.
   pure real(wp) function carlson_rc(x, y) result(rc)
      !> >= 0.
      real(wp), intent(in) :: x
      !> > 0.
      real(wp), intent(in) :: y
      real(wp) :: w
      w = sqrt(abs(x - y))
      if (w <= 1.0e-9_wp*sqrt(y)) then
         rc = 1/sqrt(y)
      else if (x < y) then
         rc = atan2(w, sqrt(x))/w
      else if (y > 0.5_wp*x) then
         rc = atanh(w/sqrt(x))/w
      else
         rc = log((sqrt(x) + w)/sqrt(y))/w
      end if
   end function carlson_rc

   !> Returns R_J(x, y, z, p) = 3/2 ∫₀^∞ dt / (√((t+x)(t+y)(t+z)) (t+p)).
   pure real(wp) function carlson_rj(x, y, z, p) result(rj)
      !> >= 0, at most one of them zero.
      real(wp), intent(in) :: x, y, z
      !> > 0.
      real(wp), intent(in) :: p
      real(wp) :: v(3), r(3), w, root, mean, lambda, d, weight, total
      integer :: i
      v = [x, y, z]
      w = p
      weight = 1
      total = 0
      do i = 1, most_duplications
         mean = (sum(v) + 2*w)/5
         if (max(maxval(abs(v - mean)), abs(w - mean)) <= series_radius*mean) exit
         r = sqrt(v)
         root = sqrt(w)
         lambda = r(1)*r(2) + r(1)*r(3) + r(2)*r(3)
         d = (root + r(1))*(root + r(2))*(root + r(3))
         ! Carlson's 1 + e, written without the difference that loses digits for small p.
         total = total + weight/d*carlson_rc(1.0_wp, 2*root*(w + lambda)/d)
         v = (v + lambda)/4
         w = (w + lambda)/4
         weight = weight/4
      end do
      rj = 6*total + weight*rj_series((mean - v)/mean)/mean/sqrt(mean)
   end function carlson_rj

   !> Returns the series of R_J about equal arguments, DLMF 19.36.2.
   pure real(wp) function rj_series(v) result(series)
      !> Relative deviations of x, y, z from the weighted mean; that of p follows from them.
      real(wp), intent(in) :: v(3)
      real(wp) :: p, product3, e2, e3, e4, e5
      p = -sum(v)/2
      product3 = v(1)*v(2)*v(3)
      e2 = v(1)*v(2) + v(1)*v(3) + v(2)*v(3) - 3*p**2
      e3 = product3 + 2*e2*p + 4*p**3
      e4 = (2*product3 + e2*p + 3*p**3)*p
      e5 = product3*p**2
      series = 1 - 3*e2/14 + e3/6 + 9*e2**2/88 - 3*e4/22 - 9*e2*e3/52 + 3*e5/26 &
         - e2**3/16 + 3*e3**2/40 + 3*e2*e4/20 + 45*e2**2*e3/272 - 9*(e3*e4 + e2*e5)/68
   end function rj_series

end module nutate_carlson
