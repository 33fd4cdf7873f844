!> Power series of tops whose space axes turn at ω, with the field in them.
!>
!> The rows E are two unit vectors fixed in these axes, the first along ω, the field in their plane: `Rᵀω = ωE₁`, and
!> the field in body axes is `γ = n₁E₁ + n₂E₂` at any time. Against the first the body rotates as in fixed axes,
!> `E₁' = E₁×w`, against the other by `u = w - ωE₁`: of the six products of a row in the axial frame, whose w has a
!> constant last component, the first keeps four. The momentum remains that of the absolute motion. The factors for both
!> rows lie side by side, and the sums go to memory: so gfortran computes them in pairs.
module nutate_rotating_top_series
   use nutate_diagonal_series, only: steepest_growth
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order, inverses
   implicit none
   private

   public :: expand_rotating_top, expand_rotating_axial_top

contains

   !> A top of diagonal inertia, `w₁' = c₁w₂w₃ + (m₁×γ)₁`, ..., w = Ω·time_unit.
   pure subroutine expand_rotating_top(order, c, moments, field, turn, w, rows, converges)
      integer, intent(in) :: order
      !> (J₂ - J₃)/J₁, ...; shape (3).
      real(wp), intent(in) :: c(3)
      !> The potential's moment times time_unit²/Jᵢ in column i; shape (3,3).
      real(wp), intent(in) :: moments(3, 3)
      !> n₁, n₂, and ω times time_unit.
      real(wp), intent(in) :: field(2), turn
      !> Coefficient 0 on entry, all on exit; shapes (3, 0:highest_order) and (2, 3, 0:highest_order).
      real(wp), intent(inout) :: w(3, 0:highest_order), rows(2, 3, 0:highest_order)
      !> False where the coefficients grow so fast that the unit of time is far too long.
      logical, intent(out) :: converges
      real(wp) :: e(2, 3, 0:highest_order), u(2, 3, 0:highest_order), w1, w2, w3, gamma(3), bound
      integer :: k
      e(:, :, 0) = rows(:, :, 0)
      w1 = w(1, 0)
      w2 = w(2, 0)
      w3 = w(3, 0)
      bound = steepest_growth
      do k = 0, order
         converges = max(abs(w1), abs(w2), abs(w3)) <= bound
         if (.not. converges) return
         bound = bound*steepest_growth
         w(1, k) = w1
         w(2, k) = w2
         w(3, k) = w3
         if (k == order) exit
         u(1, :, k) = w(:, k)
         u(2, :, k) = w(:, k) - turn*e(1, :, k)
         gamma = field(1)*e(1, :, k) + field(2)*e(2, :, k)
         call add_euler_products(k, w, w1, w2, w3)
         w1 = inverses(k + 1)*(c(1)*w1 + (moments(2, 1)*gamma(3) - moments(3, 1)*gamma(2)))
         w2 = inverses(k + 1)*(c(2)*w2 + (moments(3, 2)*gamma(1) - moments(1, 2)*gamma(3)))
         w3 = inverses(k + 1)*(c(3)*w3 + (moments(1, 3)*gamma(2) - moments(2, 3)*gamma(1)))
         call add_products(k, u, e)
      end do
      rows(:, :, 1:order) = e(:, :, 1:order)
   end subroutine expand_rotating_top

   !> A symmetric one in the axial frame, components with the axis last, w = L/J₁·time_unit, `w₁' = -gγ₂`, `w₂' = gγ₁`.
   pure subroutine expand_rotating_axial_top(order, g, turn, w, rows, converges)
      integer, intent(in) :: order
      !> The potential's moment along the axis times time_unit²/J₁, times n₁ and n₂; ω times time_unit.
      real(wp), intent(in) :: g(2), turn
      real(wp), intent(inout) :: w(3, 0:highest_order), rows(2, 3, 0:highest_order)
      logical, intent(out) :: converges
      !> The first two components of w and u, and the last of -ωE₁ twice; the first two of the second row; what its
      !> product with that last component adds to it.
      real(wp) :: u(2, 3, 0:highest_order), across(2, 0:highest_order), more(2, 0:highest_order)
      real(wp) :: w1, w2, w3, bound
      integer :: k
      w1 = w(1, 0)
      w2 = w(2, 0)
      w3 = w(3, 0)
      bound = steepest_growth
      converges = abs(w3) <= bound
      if (.not. converges) return
      w(3, 1:order) = 0.0_wp
      do k = 0, order
         converges = max(abs(w1), abs(w2)) <= bound
         if (.not. converges) return
         bound = bound*steepest_growth
         w(1, k) = w1
         w(2, k) = w2
         if (k == order) exit
         u(:, 1, k) = [w1, w1 - turn*rows(1, 1, k)]
         u(:, 2, k) = [w2, w2 - turn*rows(1, 2, k)]
         u(:, 3, k) = -turn*rows(1, 3, k)
         across(:, k) = rows(2, 1:2, k)
         call add_axial_products(k, w3, u, across, rows, more)
         rows(2, 1, k + 1) = rows(2, 1, k + 1) + more(2, k)
         rows(2, 2, k + 1) = rows(2, 2, k + 1) - more(1, k)
         w1 = -inverses(k + 1)*(g(1)*rows(1, 2, k) + g(2)*rows(2, 2, k))
         w2 = inverses(k + 1)*(g(1)*rows(1, 1, k) + g(2)*rows(2, 1, k))
      end do
   end subroutine expand_rotating_axial_top

   !> Coefficient k + 1 of the rows by what has the same form for both, and what comes to the second alone.
   pure subroutine add_axial_products(k, w3, u, across, rows, more)
      integer, intent(in) :: k
      real(wp), intent(in) :: w3, u(2, 3, 0:highest_order), across(2, 0:highest_order)
      real(wp), intent(inout) :: rows(2, 3, 0:highest_order), more(2, 0:highest_order)
      real(wp), dimension(2) :: s1, s2, s3, s4
      integer :: j
      s1 = w3*rows(:, 2, k)
      s2 = -w3*rows(:, 1, k)
      s3 = 0.0_wp
      s4 = 0.0_wp
      do j = 0, k
         s1 = s1 - rows(:, 3, j)*u(:, 2, k - j)
         s2 = s2 + rows(:, 3, j)*u(:, 1, k - j)
         s3 = s3 + (rows(:, 1, j)*u(:, 2, k - j) - rows(:, 2, j)*u(:, 1, k - j))
         s4 = s4 + across(:, j)*u(:, 3, k - j)
      end do
      rows(:, 1, k + 1) = inverses(k + 1)*s1
      rows(:, 2, k + 1) = inverses(k + 1)*s2
      rows(:, 3, k + 1) = inverses(k + 1)*s3
      more(:, k) = inverses(k + 1)*s4
   end subroutine add_axial_products

   !> Coefficient k of w₂w₃, w₃w₁ and w₁w₂.
   pure subroutine add_euler_products(k, w, p1, p2, p3)
      integer, intent(in) :: k
      real(wp), intent(in) :: w(3, 0:highest_order)
      real(wp), intent(out) :: p1, p2, p3
      integer :: j
      p1 = 0.0_wp
      p2 = 0.0_wp
      p3 = 0.0_wp
      do j = 0, k
         p1 = p1 + w(2, j)*w(3, k - j)
         p2 = p2 + w(3, j)*w(1, k - j)
         p3 = p3 + w(1, j)*w(2, k - j)
      end do
   end subroutine add_euler_products

   !> Coefficient k + 1 of the rows, from E' = E×u, with the u of each.
   pure subroutine add_products(k, u, e)
      integer, intent(in) :: k
      real(wp), intent(in) :: u(2, 3, 0:highest_order)
      real(wp), intent(inout) :: e(2, 3, 0:highest_order)
      real(wp), dimension(2) :: s1, s2, s3
      integer :: j
      s1 = e(:, 2, 0)*u(:, 3, k) - e(:, 3, 0)*u(:, 2, k)
      s2 = e(:, 3, 0)*u(:, 1, k) - e(:, 1, 0)*u(:, 3, k)
      s3 = e(:, 1, 0)*u(:, 2, k) - e(:, 2, 0)*u(:, 1, k)
      do j = 1, k
         s1 = s1 + (e(:, 2, j)*u(:, 3, k - j) - e(:, 3, j)*u(:, 2, k - j))
         s2 = s2 + (e(:, 3, j)*u(:, 1, k - j) - e(:, 1, j)*u(:, 3, k - j))
         s3 = s3 + (e(:, 1, j)*u(:, 2, k - j) - e(:, 2, j)*u(:, 1, k - j))
      end do
      e(:, 1, k + 1) = inverses(k + 1)*s1
      e(:, 2, k + 1) = inverses(k + 1)*s2
      e(:, 3, k + 1) = inverses(k + 1)*s3
   end subroutine add_products

end module nutate_rotating_top_series
