!> Products of series in pairs of lanes: coefficient by coefficient, two vectors at a time.
module nutate_lane_products
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order
   implicit none
   private

   public :: add_inner, add_outer, see_from_frame

contains

   !> Coefficient k as space axes that turn have it: of Ω less Rᵀω = Σ ωᵢEᵢ, and -E×Rᵀω of the three rows.
   pure subroutine see_from_frame(turn, a, b, omega, carried)
      !> ω along the rows, times the unit of time; shape (3).
      real(wp), intent(in) :: turn(3)
      !> Coefficient k of the lanes (L, E1) and (E2, E3).
      real(wp), intent(in) :: a(2, 3), b(2, 3)
      !> Times the unit of time; shape (3).
      real(wp), intent(inout) :: omega(3)
      !> One row each; shape (3,3).
      real(wp), intent(out) :: carried(3, 3)
      omega = omega - (turn(1)*a(2, :) + turn(2)*b(1, :) + turn(3)*b(2, :))
      carried(1, :) = turn(3)*b(1, :) - turn(2)*b(2, :)
      carried(2, :) = turn(1)*b(2, :) - turn(3)*a(2, :)
      carried(3, :) = turn(2)*a(2, :) - turn(1)*b(1, :)
   end subroutine see_from_frame

   !> Coefficient k of lane × Ω, for a pair of lanes, without the products with the coefficients 0 and k: what comes
   !> before does not wait for the newest.
   pure subroutine add_inner(k, lanes, omega, sums)
      integer, intent(in) :: k
      real(wp), intent(in) :: lanes(2, 3, 0:highest_order), omega(3, 0:highest_order)
      real(wp), intent(out) :: sums(2, 3)
      real(wp), dimension(2) :: x, y, z
      integer :: j
      x = 0.0_wp
      y = 0.0_wp
      z = 0.0_wp
      do j = 1, k - 1
         x = x + (lanes(:, 2, j)*omega(3, k - j) - lanes(:, 3, j)*omega(2, k - j))
         y = y + (lanes(:, 3, j)*omega(1, k - j) - lanes(:, 1, j)*omega(3, k - j))
         z = z + (lanes(:, 1, j)*omega(2, k - j) - lanes(:, 2, j)*omega(1, k - j))
      end do
      sums(:, 1) = x
      sums(:, 2) = y
      sums(:, 3) = z
   end subroutine add_inner

   !> Adds these products.
   pure subroutine add_outer(k, first, last, v, w, sums)
      integer, intent(in) :: k
      !> Coefficients 0 and k of the lanes, and of Ω; shapes (2,3) and (3).
      real(wp), intent(in) :: first(2, 3), last(2, 3), v(3), w(3)
      real(wp), intent(inout) :: sums(2, 3)
      sums(:, 1) = sums(:, 1) + (first(:, 2)*w(3) - first(:, 3)*w(2))
      sums(:, 2) = sums(:, 2) + (first(:, 3)*w(1) - first(:, 1)*w(3))
      sums(:, 3) = sums(:, 3) + (first(:, 1)*w(2) - first(:, 2)*w(1))
      if (k == 0) return
      sums(:, 1) = sums(:, 1) + (last(:, 2)*v(3) - last(:, 3)*v(2))
      sums(:, 2) = sums(:, 2) + (last(:, 3)*v(1) - last(:, 1)*v(3))
      sums(:, 3) = sums(:, 3) + (last(:, 1)*v(2) - last(:, 2)*v(1))
   end subroutine add_outer

end module nutate_lane_products
