!> Sums of power series, and the rotation between two frames: from coefficients to the state at a time.
module nutate_series_sum
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order
   implicit none
   private

   public :: length_of, rotation_between, sum_series

contains

   !> Returns √(x·x), cheaper than the intrinsic, which guards against overflow.
   pure real(wp) function length_of(x)
      real(wp), intent(in) :: x(3)
      length_of = sqrt(x(1)*x(1) + x(2)*x(2) + x(3)*x(3))
   end function length_of

   !> Computes Σ xₖ sᵏ from k = 1 on, and the tail, of four series; even and odd powers apart, which halves the chain.
   pure subroutine sum_series(order, s, x, weights, total)
      !> Highest coefficient.
      integer, intent(in) :: order
      real(wp), intent(in) :: s, x(4, 0:highest_order)
      !> Weights of the last coefficient and of the one before in the tail; shape (2).
      real(wp), intent(in) :: weights(2)
      real(wp), intent(out) :: total(4)
      real(wp) :: odd(4), even(4), square
      integer :: k, last
      square = s*s
      last = 2*((order - 1)/2)
      odd = x(:, last + 1)
      even = 0.0_wp
      if (order > last + 1) even = x(:, order)
      do k = last, 2, -2
         odd = odd*square + x(:, k - 1)
         even = even*square + x(:, k)
      end do
      total = s*(odd + s*even) + (weights(1)*x(:, order) + weights(2)*x(:, order - 1))
   end subroutine sum_series

   !> Returns the quaternion c, not normalised, with R(c) gᵢ = fᵢ for two right-handed frames that are orthonormal up to
   !> errors: 4cᵢcⱼ are linear in Σ fᵢgᵢᵀ; the row with the largest diagonal element is used.
   pure function rotation_between(f, g) result(c)
      !> fᵢ and gᵢ as columns; shape (3,3).
      real(wp), intent(in) :: f(3, 3), g(3, 3)
      real(wp) :: c(4)
      real(wp) :: m(3, 3)
      integer :: i
      do i = 1, 3
         m(:, i) = f(:, 1)*g(i, 1) + f(:, 2)*g(i, 2) + f(:, 3)*g(i, 3)
      end do
      c(1) = 1 + (m(1, 1) + m(2, 2) + m(3, 3))
      if (c(1) > 1.0_wp) then
         c(2:4) = [m(3, 2) - m(2, 3), m(1, 3) - m(3, 1), m(2, 1) - m(1, 2)]
      else if (m(1, 1) >= max(m(2, 2), m(3, 3))) then
         c = [m(3, 2) - m(2, 3), 1 + m(1, 1) - m(2, 2) - m(3, 3), m(1, 2) + m(2, 1), m(1, 3) + m(3, 1)]
      else if (m(2, 2) >= m(3, 3)) then
         c = [m(1, 3) - m(3, 1), m(1, 2) + m(2, 1), 1 + m(2, 2) - m(1, 1) - m(3, 3), m(2, 3) + m(3, 2)]
      else
         c = [m(2, 1) - m(1, 2), m(1, 3) + m(3, 1), m(2, 3) + m(3, 2), 1 + m(3, 3) - m(1, 1) - m(2, 2)]
      end if
      if (c(1) < 0.0_wp) c = -c
   end function rotation_between

end module nutate_series_sum
