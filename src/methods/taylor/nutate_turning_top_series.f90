!> Power series of tops whose space axes turn at ω, with the field in them.
!>
!> The rows E are two unit vectors fixed in these axes, the first along the field, ω in their plane: with the same
!> weights at all times `Rᵀω = ω₁E₁ + ω₂E₂`. They turn against the body by `u = w - Rᵀω`, `E' = E×u`: no products more
!> than in axes that stand still, but that in the axial frame the last component of u is no constant. The momentum
!> remains that of the absolute motion. Rows, and u twice side by side, are kept where vector instructions read them
!> without a copy.
module nutate_turning_top_series
   use nutate_diagonal_series, only: steepest_growth
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order, inverses
   implicit none
   private

   public :: expand_turning_top, expand_turning_axial_top

contains

   !> A top of diagonal inertia, `w₁' = c₁w₂w₃ + (m₁×E)₁`, ..., w = Ω·time_unit.
   pure subroutine expand_turning_top(order, c, moments, turn, w, rows, converges)
      integer, intent(in) :: order
      !> (J₂ - J₃)/J₁, ...; shape (3).
      real(wp), intent(in) :: c(3)
      !> The potential's moment times time_unit²/Jᵢ in column i; shape (3,3).
      real(wp), intent(in) :: moments(3, 3)
      !> ω along the rows times time_unit; shape (2).
      real(wp), intent(in) :: turn(2)
      !> Coefficient 0 on entry, all on exit; shapes (3, 0:highest_order) and (2, 3, 0:highest_order).
      real(wp), intent(inout) :: w(3, 0:highest_order), rows(2, 3, 0:highest_order)
      !> False where the coefficients grow so fast that the unit of time is far too long.
      logical, intent(out) :: converges
      real(wp) :: e(2, 3, 0:highest_order), u(2, 3, 0:highest_order), w1, w2, w3, bound
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
         call set_relative_rate(k, turn, w, e, u)
         call add_euler_products(k, w, w1, w2, w3)
         w1 = inverses(k + 1)*(c(1)*w1 + (moments(2, 1)*e(1, 3, k) - moments(3, 1)*e(1, 2, k)))
         w2 = inverses(k + 1)*(c(2)*w2 + (moments(3, 2)*e(1, 1, k) - moments(1, 2)*e(1, 3, k)))
         w3 = inverses(k + 1)*(c(3)*w3 + (moments(1, 3)*e(1, 2, k) - moments(2, 3)*e(1, 1, k)))
         call add_products(k, u, e)
      end do
      rows(:, :, 1:order) = e(:, :, 1:order)
   end subroutine expand_turning_top

   !> A symmetric one in the axial frame, components with the axis last, w = L/J₁·time_unit, `w₁' = -gE₂, w₂' = gE₁` of
   !> the first row.
   pure subroutine expand_turning_axial_top(order, g, turn, w, rows, converges)
      integer, intent(in) :: order
      !> The potential's moment along the axis times time_unit²/J₁.
      real(wp), intent(in) :: g
      !> As of `expand_turning_top`.
      real(wp), intent(in) :: turn(2)
      real(wp), intent(inout) :: w(3, 0:highest_order), rows(2, 3, 0:highest_order)
      logical, intent(out) :: converges
      real(wp) :: u(2, 3, 0:highest_order), w1, w2, bound
      integer :: k
      w1 = w(1, 0)
      w2 = w(2, 0)
      bound = steepest_growth
      converges = abs(w(3, 0)) <= bound
      if (.not. converges) return
      w(3, 1:order) = 0.0_wp
      do k = 0, order
         converges = max(abs(w1), abs(w2)) <= bound
         if (.not. converges) return
         bound = bound*steepest_growth
         w(1, k) = w1
         w(2, k) = w2
         if (k == order) exit
         call set_relative_rate(k, turn, w, rows, u)
         w1 = -(g*inverses(k + 1))*rows(1, 2, k)
         w2 = (g*inverses(k + 1))*rows(1, 1, k)
         call add_products(k, u, rows)
      end do
   end subroutine expand_turning_axial_top

   !> Coefficient k of u, twice side by side.
   pure subroutine set_relative_rate(k, turn, w, e, u)
      integer, intent(in) :: k
      real(wp), intent(in) :: turn(2), w(3, 0:highest_order), e(2, 3, 0:highest_order)
      real(wp), intent(inout) :: u(2, 3, 0:highest_order)
      real(wp) :: one
      integer :: i
      do i = 1, 3
         one = w(i, k) - (turn(1)*e(1, i, k) + turn(2)*e(2, i, k))
         u(1, i, k) = one
         u(2, i, k) = one
      end do
   end subroutine set_relative_rate

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

   !> Coefficient k + 1 of the rows, from E' = E×u.
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

end module nutate_turning_top_series
