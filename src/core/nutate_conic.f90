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

   public :: place_on_conic

contains

   !> Computes where a body is on a conic.
   pure subroutine place_on_conic(eccentricity, time, place, velocity, radius, true_anomaly)
      !> e >= 0, and the time since the periapsis in units of √(q³/μ).
      real(wp), intent(in) :: eccentricity, time
      !> Along the direction to the periapsis, and across it in the plane, in units of q and √(μ/q); shape (2).
      real(wp), intent(out) :: place(2), velocity(2)
      !> In units of q, and in rad: of an ellipse it grows by 2π with each revolution.
      real(wp), intent(out) :: radius, true_anomaly
      real(wp) :: s, u(0:3), half(0:3), turns, e, root
      e = eccentricity
      root = sqrt(1 + e)
      turns = 0.0_wp
      if (e < 1.0_wp) turns = anint(time/period_of(e))
      s = time
      if (e < 1.0_wp) s = time - turns*period_of(e)
      s = sign(anomaly_of(e, abs(s)), s)
      u = universal(1 - e, s)
      half = universal(1 - e, 0.5_wp*s)
      radius = 1 + e*u(2)
      place = [1 - u(2), root*u(1)]
      velocity = [-u(1)/radius, root*u(0)/radius]
      true_anomaly = 2*atan2(root*half(1), half(0)) + 2*pi*turns
   end subroutine place_on_conic

   !> Period of an ellipse in units of √(q³/μ).
   pure real(wp) function period_of(e)
      real(wp), intent(in) :: e
      period_of = 2*pi/((1 - e)*sqrt(1 - e))
   end function period_of

   !> s of s + e U₃ = τ by Newton's iteration: the left side is convex where s > 0, on an ellipse up to the apoapsis, so
   !> that the iteration, once above the root, falls to it without fail.
   pure real(wp) function anomaly_of(e, time) result(s)
      !> τ, not negative; of an ellipse not after the apoapsis.
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
         ! The start on an ellipse is below the root.
         if (change <= 0.0_wp .and. i > 1) exit
         s = min(s - change, last)
         if (abs(change) <= eps*s) exit
      end do
   end function anomaly_of

   !> The root of the cubic s + e s³/6 = τ, exact for a parabola, above the root of a hyperbola; of this the smaller one
   !> of it and the root of sinh without s.
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

   !> U₀ to U₃ of α and s: series where |αs²| <= 1, else circular or hyperbolic functions.
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

end module nutate_conic
