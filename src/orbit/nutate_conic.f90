!> Kepler motion from the periapsis on, for any eccentricity, by universal variables: nothing cancels where a conic is
!> nearly a parabola.
!>
!> Unit of length is the distance q of the periapsis, of time √(q³/μ). With α = 1 - e and Stumpff's functions cₖ(αs²)
!> as Uₖ = sᵏcₖ:
!>
!>     τ = s + e U₃,   r = 1 + e U₂,   x = 1 - U₂,   y = √(1+e) U₁,   x' = -U₁/r,   y' = √(1+e) U₀/r,
!>     tan(ν/2) = √(1+e) U₁(s/2)/U₀(s/2).
module nutate_conic
   use nutate_kinds, only: wp, eps, pi
   implicit none
   private

   public :: place_on_conic, change_on_conic

contains

   !> Computes the position of a body on a conic.
   pure subroutine place_on_conic(eccentricity, time, place, velocity, radius, true_anomaly)
      !> e >= 0, and the time since the periapsis in units of √(q³/μ).
      real(wp), intent(in) :: eccentricity, time
      !> Components along the direction to the periapsis, and across it in the plane, in units of q and √(μ/q); shape
      !> (2).
      real(wp), intent(out) :: place(2), velocity(2)
      !> Radius in units of q; true anomaly, rad: on an ellipse it grows by 2π with each revolution.
      real(wp), intent(out) :: radius, true_anomaly
      real(wp) :: s, u(0:3), half(0:3), turns, e, root
      e = eccentricity
      root = sqrt(1 + e)
      call find_anomaly(e, time, s, turns)
      u = universal(1 - e, s)
      half = universal(1 - e, 0.5_wp*s)
      radius = 1 + e*u(2)
      place = [1 - u(2), root*u(1)]
      velocity = [-u(1)/radius, root*u(0)/radius]
      true_anomaly = 2*atan2(root*half(1), half(0)) + 2*pi*turns
   end subroutine place_on_conic

   !> Computes the derivatives of the position with respect to time and eccentricity. With ∂Uₖ/∂s = Uₖ₋₁ and ∂Uₖ/∂e =
   !> ½(sUₖ₊₁ - kUₖ₊₂), r∂s/∂e = -U₃ - e∂U₃/∂e, less the change of the period times the number of complete revolutions.
   !> The derivative of the velocity with respect to eccentricity is that of the position, differentiated by time, with
   !> s' = 1/r and ∂s'/∂e = -(U₂ + e ∂U₂/∂e)/r²; that with respect to time is -x/r³.
   pure subroutine change_on_conic(eccentricity, time, by_time, by_eccentricity, velocity_by_eccentricity)
      !> Eccentricity and time as in `place_on_conic`.
      real(wp), intent(in) :: eccentricity, time
      !> Derivatives in units of q, with time in units of √(q³/μ); shape (2).
      real(wp), intent(out) :: by_time(2), by_eccentricity(2)
      !> Derivative in units of √(μ/q); shape (2).
      real(wp), intent(out) :: velocity_by_eccentricity(2)
      real(wp) :: s, u(0:5), turns, e, root, radius, s_by_e, rate_by_e
      e = eccentricity
      root = sqrt(1 + e)
      call find_anomaly(e, time, s, turns)
      u(0:3) = universal(1 - e, s)
      u(4:5) = higher(1 - e, s, u(2:3))
      radius = 1 + e*u(2)
      by_time = [-u(1)/radius, root*u(0)/radius]
      s_by_e = anomaly_by_eccentricity(e, s, turns, u, radius)
      by_eccentricity = [-u(1)*s_by_e - 0.5_wp*(s*u(3) - 2*u(4)), &
                         0.5_wp*u(1)/root + root*(u(0)*s_by_e + 0.5_wp*(s*u(2) - u(3)))]
      rate_by_e = -(u(2) + e*(u(1)*s_by_e + 0.5_wp*(s*u(3) - 2*u(4))))/radius**2
      velocity_by_eccentricity = &
         [-u(0)*s_by_e/radius - u(1)*rate_by_e - 0.5_wp*(s*u(2) - u(3))/radius, &
          (0.5_wp*u(0)/root + root*(0.5_wp*s*u(1) - (1 - e)*u(1)*s_by_e))/radius + root*u(0)*rate_by_e]
   end subroutine change_on_conic

   !> Returns ∂s/∂e at a time.
   pure real(wp) function anomaly_by_eccentricity(e, s, turns, u, radius) result(s_by_e)
      !> e, s, the number of complete revolutions on an ellipse, U₀ to U₅ and r.
      real(wp), intent(in) :: e, s, turns, u(0:5), radius
      s_by_e = -u(3) - 0.5_wp*e*(s*u(4) - 3*u(5))
      if (e < 1.0_wp) s_by_e = s_by_e - 1.5_wp*turns*period_of(e)/(1 - e)
      s_by_e = s_by_e/radius
   end function anomaly_by_eccentricity

   !> Computes s, less the complete revolutions on an ellipse, and their number.
   pure subroutine find_anomaly(e, time, s, turns)
      real(wp), intent(in) :: e, time
      real(wp), intent(out) :: s, turns
      turns = 0.0_wp
      if (e < 1.0_wp) turns = anint(time/period_of(e))
      s = time
      if (e < 1.0_wp) s = time - turns*period_of(e)
      s = sign(anomaly_of(e, abs(s)), s)
   end subroutine find_anomaly

   !> Returns the period of an ellipse in units of √(q³/μ).
   pure real(wp) function period_of(e)
      real(wp), intent(in) :: e
      period_of = 2*pi/((1 - e)*sqrt(1 - e))
   end function period_of

   !> Returns s of s + e U₃ = τ by Newton's iteration: the left side is convex where s > 0, on an ellipse up to the
   !> apoapsis, so that the iteration, once above the root, decreases monotonically to it.
   pure real(wp) function anomaly_of(e, time) result(s)
      !> τ, not negative; on an ellipse not after the apoapsis.
      real(wp), intent(in) :: e, time
      integer, parameter :: most = 80
      real(wp) :: u(0:3), change, last
      integer :: i
      last = huge(last)
      if (e < 1.0_wp) last = pi/sqrt(1 - e)
      s = min(start_of(e, time), last)
      do i = 1, most
         u = universal(1 - e, s)
         change = (s + e*u(3) - time)/(1 + e*u(2))
         ! The initial guess on an ellipse is below the root.
         if (change <= 0.0_wp .and. i > 1) exit
         s = min(s - change, last)
         if (abs(change) <= eps*s) exit
      end do
   end function anomaly_of

   !> Returns the initial guess: the root of the cubic s + e s³/6 = τ, exact for a parabola, above the root for a
   !> hyperbola; for a hyperbola the smaller one of it and the root of sinh without s.
   pure real(wp) function start_of(e, time) result(s)
      real(wp), intent(in) :: e, time
      real(wp) :: root
      s = time
      if (e > 0.0_wp) then
         root = sqrt(0.5_wp*e)
         s = 2*sinh(asinh(1.5_wp*time*root)/3)/root
      end if
      if (e > 1.0_wp) s = min(s, asinh(time*sqrt(e - 1))/sqrt(e - 1))
   end function start_of

   !> Returns U₀ to U₃ of α and s: series if |αs²| <= 1, else circular or hyperbolic functions.
   pure function universal(alpha, s) result(u)
      real(wp), intent(in) :: alpha, s
      real(wp) :: u(0:3)
      real(wp) :: z, w, root, c2, c3
      integer :: j
      z = alpha*s*s
      if (abs(z) <= 1.0_wp) then
         c2 = 1.0_wp
         c3 = 1.0_wp
         do j = 10, 1, -1
            c2 = 1 - z*c2/((2*j + 1)*(2*j + 2))
            c3 = 1 - z*c3/((2*j + 2)*(2*j + 3))
         end do
         c2 = 0.5_wp*c2
         c3 = c3/6
         u = [1 - z*c2, s*(1 - z*c3), s*s*c2, s*s*s*c3]
         return
      end if
      root = sqrt(abs(alpha))
      w = root*s
      if (z > 0.0_wp) then
         u = [cos(w), sin(w)/root, 2*(sin(0.5_wp*w)/root)**2, (w - sin(w))/(root*root*root)]
      else
         u = [cosh(w), sinh(w)/root, 2*(sinh(0.5_wp*w)/root)**2, (sinh(w) - w)/(root*root*root)]
      end if
   end function universal

   !> Returns U₄ and U₅: series if |αs²| <= 1, else (s²/2 - U₂)/α and (s³/6 - U₃)/α.
   pure function higher(alpha, s, lower)
      real(wp), intent(in) :: alpha, s
      !> U₂ and U₃; shape (2).
      real(wp), intent(in) :: lower(2)
      real(wp) :: higher(2), z
      integer :: j
      z = alpha*s*s
      if (abs(z) > 1.0_wp) then
         higher = [0.5_wp*s*s - lower(1), s*s*s/6 - lower(2)]/alpha
         return
      end if
      higher = 1.0_wp
      do j = 9, 1, -1
         higher(1) = 1 - z*higher(1)/((2*j + 3)*(2*j + 4))
         higher(2) = 1 - z*higher(2)/((2*j + 4)*(2*j + 5))
      end do
      higher = [s**4/24, s**5/120]*higher
   end function higher

end module nutate_conic
