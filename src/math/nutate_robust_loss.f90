!> Loss functions ρ(z) of the squares z of residuals, as SciPy's `least_squares` defines them: outliers count less.
module nutate_robust_loss
   use nutate_kinds, only: wp
   implicit none
   private

   public :: loss_of, weigh
   public :: LINEAR, HUBER, SOFT_L1, CAUCHY

   !> ρ = z; z up to 1, then 2√z - 1; 2(√(1+z) - 1); ln(1+z).
   integer, parameter :: LINEAR = 1, HUBER = 2, SOFT_L1 = 3, CAUCHY = 4

contains

   !> Computes ρ, ρ' and ρ'' at the square of a residual; shape (3).
   pure function loss_of(loss, z) result(rho)
      !> `LINEAR`, ...
      integer, intent(in) :: loss
      real(wp), intent(in) :: z
      real(wp) :: rho(3)
      real(wp) :: root
      rho = [z, 1.0_wp, 0.0_wp]
      select case (loss)
      case (HUBER)
         if (z <= 1.0_wp) return
         root = sqrt(z)
         rho = [2*root - 1, 1/root, -0.5_wp/(z*root)]
      case (SOFT_L1)
         root = sqrt(1 + z)
         rho = [2*z/(root + 1), 1/root, -0.5_wp/root**3]
      case (CAUCHY)
         rho = [log(1 + z), 1/(1 + z), -1/(1 + z)**2]
      case default
         continue
      end select
   end function loss_of

   !> Turns residuals and their Jacobian into those of the quadratic model of the loss (Triggs et al., Bundle
   !> adjustment, 1999, equation 11), as SciPy does.
   pure subroutine weigh(losses, least, residuals, jacobian, cost)
      !> Loss of each residual; shape (residuals).
      integer, intent(in) :: losses(:)
      !> Least curvature of ρ, relative to its slope: without a curvature of outliers, steps would have no bound.
      real(wp), intent(in) :: least
      !> Shape (residuals) and (residuals, parameters).
      real(wp), intent(inout) :: residuals(:), jacobian(:, :)
      !> Sum of ρ.
      real(wp), intent(out) :: cost
      real(wp) :: rho(3), scale
      integer :: i
      cost = 0.0_wp
      do i = 1, size(residuals)
         rho = loss_of(losses(i), residuals(i)**2)
         cost = cost + rho(1)
         if (losses(i) == LINEAR) cycle
         scale = sqrt(max(rho(2) + 2*rho(3)*residuals(i)**2, least*rho(2)))
         jacobian(i, :) = scale*jacobian(i, :)
         residuals(i) = residuals(i)*rho(2)/scale
      end do
   end subroutine weigh

end module nutate_robust_loss
