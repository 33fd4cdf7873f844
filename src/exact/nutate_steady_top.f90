!> Steady motions of Lagrange's top in closed form: regular precession and the sleeping top.
!>
!> With V = m g l cos θ the tilt stays constant if J₁ φ̇² cos θ - J₃ Ω₃ φ̇ + m g l = 0 (F. Klein, A. Sommerfeld,
!> "Über die Theorie des Kreisels", ch. IV).
module nutate_steady_top
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_kinds, only: wp
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: steady_precession, sleeping_spin

contains

   !> Computes the two rates of steady precession for a given body rate Ω₃ about the symmetry axis.
   pure subroutine steady_precession(j1, j3, mgl, theta, omega3, slow, fast, status)
      !> Moments about the pivot, across and along the symmetry axis (kg m²), > 0.
      real(wp), intent(in) :: j1, j3
      !> m g times the distance of the centre of mass above the pivot along the axis (N m), of either sign.
      real(wp), intent(in) :: mgl
      !> Tilt of the axis from the upward vertical (rad).
      real(wp), intent(in) :: theta
      !> Body rate about the symmetry axis, ψ̇ + φ̇ cos θ (rad/s).
      real(wp), intent(in) :: omega3
      !> Precession rates about the upward vertical, |slow| <= |fast| (rad/s); `fast` is +-huge for a horizontal axis,
      !> which has no fast precession.
      real(wp), intent(out) :: slow, fast
      !> `NUTATE_BAD_ARGUMENT`: moments not positive, or the spin is too slow for any steady precession.
      type(status_t), intent(out) :: status
      real(wp) :: a, b, r, q
      slow = 0
      fast = 0
      if (.not. in_range([j1, j3, mgl, theta, omega3])) then
         status = fail(NUTATE_BAD_ARGUMENT, 'moments, torque, tilt and spin must be finite and of a sensible size')
         return
      end if
      ! Roots of a x² - b x + m g l = 0 without cancellation or overflow.
      a = j1*cos(theta)
      b = j3*omega3
      r = 2*sqrt(abs(a))*sqrt(abs(mgl))
      if (min(j1, j3) <= 0) then
         status = fail(NUTATE_BAD_ARGUMENT, 'moments of inertia must be positive')
         return
      end if
      if (a > 0 .eqv. mgl > 0) then
         if (abs(b) < r) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the spin is too slow for a steady precession at this tilt')
            return
         end if
         r = sqrt(abs(b) - r)*sqrt(abs(b) + r)
      else
         r = hypot(b, r)
      end if
      q = (b + sign(r, b))/2
      if (abs(mgl) > 0) slow = quotient(mgl, q)
      ! cos(pi/2) is 6e-17: a horizontal axis in floating point.
      fast = sign(huge(1.0_wp), q)
      if (abs(a) > 1.0e-16_wp*j1) fast = quotient(q, a)
   end subroutine steady_precession

   !> Returns the body rate |Ω₃| above which the upright top is stable (rad/s): J₃² Ω₃² = 4 J₁ m g l; 0 for a hanging
   !> one.
   pure real(wp) function sleeping_spin(j1, j3, mgl) result(omega3)
      !> Moments about the pivot, across and along the symmetry axis (kg m²), > 0.
      real(wp), intent(in) :: j1, j3
      !> m g times the distance of the centre of mass above the pivot along the axis (N m).
      real(wp), intent(in) :: mgl
      omega3 = 0
      if (j1 > 0 .and. mgl > 0) omega3 = quotient(2*sqrt(j1)*sqrt(mgl), j3)
   end function sleeping_spin

   !> Returns true if numbers are finite and so far from the ends of the range that their products do not overflow.
   pure logical function in_range(data)
      real(wp), intent(in) :: data(:)
      in_range = all(ieee_is_finite(data))
      if (in_range) in_range = maxval(abs(data)) < 1.0e140_wp
   end function in_range

   !> Returns x/y, or `huge` with its sign if that is larger.
   pure real(wp) function quotient(x, y)
      real(wp), intent(in) :: x, y
      quotient = sign(huge(1.0_wp), x)*sign(1.0_wp, y)
      if (.not. abs(y) > 0) return
      if (exponent(x) - exponent(y) < maxexponent(1.0_wp) - 1) quotient = x/y
   end function quotient

end module nutate_steady_top
