!> The Euler angles of an attitude one by one, as columns of events, and their rates along a motion.
module nutate_euler_column
   use nutate_attitude, only: euler_from_quat
   use nutate_kinds, only: wp, eps
   implicit none
   private

   public :: euler_angle, euler_rate

   !> Which angle.
   integer, parameter :: PHI = 1, THETA = 2, PSI = 3

contains

   !> The angle at an attitude, rad.
   pure real(wp) function euler_angle(angle, q) result(x)
      !> `PHI`, `THETA` or `PSI`.
      integer, intent(in) :: angle
      !> Unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      real(wp) :: phi_now, theta_now, psi_now
      if (angle == THETA) then
         x = 2*atan2(sqrt(q(2)*q(2) + q(3)*q(3)), sqrt(q(1)*q(1) + q(4)*q(4)))
         return
      end if
      call euler_from_quat(q, phi_now, theta_now, psi_now)
      x = phi_now
      if (angle == PSI) x = psi_now
   end function euler_angle

   !> Its rate, rad/s. With γ = Rᵀe₃ = (sin θ sin ψ, sin θ cos ψ, cos θ): φ' = (Ω1 sin ψ + Ω2 cos ψ)/sin θ,
   !> θ' = Ω1 cos ψ - Ω2 sin ψ, ψ' = Ω3 - φ' cos θ; at a pole, where ψ = 0, φ takes all of Ω3.
   pure real(wp) function euler_rate(angle, q, omega) result(rate)
      !> `PHI`, `THETA` or `PSI`.
      integer, intent(in) :: angle
      !> Body→space, of any length; against the space axes, body axes, rad/s.
      real(wp), intent(in) :: q(4), omega(3)
      real(wp) :: gamma(2), cosine, sine, precession, square
      square = q(1)*q(1) + q(2)*q(2) + q(3)*q(3) + q(4)*q(4)
      gamma(1) = 2*(q(2)*q(4) - q(1)*q(3))/square
      gamma(2) = 2*(q(3)*q(4) + q(1)*q(2))/square
      cosine = ((q(1)*q(1) + q(4)*q(4)) - (q(2)*q(2) + q(3)*q(3)))/square
      sine = sqrt(gamma(1)*gamma(1) + gamma(2)*gamma(2))
      precession = sign(omega(3), omega(3)*cosine)
      if (sine > 4*eps) then
         gamma = gamma/sine
         precession = (omega(1)*gamma(1) + omega(2)*gamma(2))/sine
      else
         gamma = [0.0_wp, 1.0_wp]
      end if
      select case (angle)
      case (PHI)
         rate = precession
      case (THETA)
         rate = omega(1)*gamma(2) - omega(2)*gamma(1)
      case default
         rate = omega(3) - precession*cosine
      end select
   end function euler_rate

end module nutate_euler_column
