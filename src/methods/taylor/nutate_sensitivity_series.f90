!> The sums of products of two series for coefficient k + 1 of sensitivities, and the layout of coefficients and
!> factors.
!>
!> The loop over lanes is the outer one, and is vectorised since the inner one has at least one iteration: the sums then
!> stay in registers.
module nutate_sensitivity_series
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order
   implicit none
   private

   public :: lanes, numbers, n_factors, of_theta, of_momentum, of_lack, by_angle, by_momentum, for_momentum, for_theta
   public :: set_vector, set_matrix, sum_free, add_rest, add_row, add_rotated, add_lacking, sum_block

   !> Number of sensitivities that are computed together, whose sums stay in registers.
   integer, parameter :: lanes = 2
   !> Numbers of a sensitivity: θ, δL and u, by which ΔtδΩ is less than ΔtJ⁻¹δL; where each starts.
   integer, parameter :: of_theta = 0, of_momentum = 3, of_lack = 6, numbers = 9
   !> Factors in a coefficient: ΔtΩ, L, and the matrices of δL and of θ in δL̇, of the latter E instead where there is
   !> but the moment m of one row, m×(E×θ); where each starts.
   integer, parameter :: by_angle = 0, by_momentum = 3, for_momentum = 6, for_theta = 15, n_factors = 24

contains

   !> Sets three factors of a coefficient.
   pure subroutine set_vector(f, first, v)
      real(wp), intent(inout) :: f(lanes, n_factors)
      integer, intent(in) :: first
      real(wp), intent(in) :: v(3)
      integer :: i
      do i = 1, 3
         f(:, first + i) = v(i)
      end do
   end subroutine set_vector

   !> Sets nine factors of a coefficient.
   pure subroutine set_matrix(f, first, matrix)
      real(wp), intent(inout) :: f(lanes, n_factors)
      integer, intent(in) :: first
      real(wp), intent(in) :: matrix(3, 3)
      integer :: j
      do j = 1, 3
         call set_vector(f, first + 3*(j - 1), matrix(:, j))
      end do
   end subroutine set_matrix

   !> Sets θ×Ω, and the matrices of δL without their diagonals times it.
   pure subroutine sum_free(k, f, x, s)
      integer, intent(in) :: k
      real(wp), intent(in) :: f(lanes, n_factors, 0:highest_order), x(lanes, numbers, 0:highest_order)
      real(wp), intent(out) :: s(lanes, 6)
      real(wp) :: s1, s2, s3, s4, s5, s6
      integer :: i, j
      if (k < 0) then
         s = 0.0_wp
         return
      end if
      !GCC$ unroll 1
      do i = 1, lanes
         s1 = 0.0_wp
         s2 = 0.0_wp
         s3 = 0.0_wp
         s4 = 0.0_wp
         s5 = 0.0_wp
         s6 = 0.0_wp
         do j = 0, k
            s1 = s1 + (x(i, 2, j)*f(i, 3, k - j) - x(i, 3, j)*f(i, 2, k - j))
            s2 = s2 + (x(i, 3, j)*f(i, 1, k - j) - x(i, 1, j)*f(i, 3, k - j))
            s3 = s3 + (x(i, 1, j)*f(i, 2, k - j) - x(i, 2, j)*f(i, 1, k - j))
            s4 = s4 + (x(i, 5, j)*f(i, 10, k - j) + x(i, 6, j)*f(i, 13, k - j))
            s5 = s5 + (x(i, 4, j)*f(i, 8, k - j) + x(i, 6, j)*f(i, 14, k - j))
            s6 = s6 + (x(i, 4, j)*f(i, 9, k - j) + x(i, 5, j)*f(i, 12, k - j))
         end do
         s(i, 1) = s1
         s(i, 2) = s2
         s(i, 3) = s3
         s(i, 4) = s4
         s(i, 5) = s5
         s(i, 6) = s6
      end do
   end subroutine sum_free

   !> Adds the diagonals of the matrices of δL times it, and what ΔtJ⁻¹ has off its diagonal.
   pure subroutine add_rest(k, f, a, x, s)
      integer, intent(in) :: k
      !> The factors; ΔtJ⁻¹, shape (3,3).
      real(wp), intent(in) :: f(lanes, n_factors, 0:highest_order), a(3, 3), x(lanes, numbers, 0:highest_order)
      real(wp), intent(inout) :: s(lanes, 6)
      real(wp) :: s4, s5, s6
      integer :: i, j
      if (k < 0) return
      !GCC$ unroll 1
      do i = 1, lanes
         s4 = s(i, 4)
         s5 = s(i, 5)
         s6 = s(i, 6)
         do j = 0, k
            s4 = s4 + x(i, 4, j)*f(i, 7, k - j)
            s5 = s5 + x(i, 5, j)*f(i, 11, k - j)
            s6 = s6 + x(i, 6, j)*f(i, 15, k - j)
         end do
         s(i, 4) = s4
         s(i, 5) = s5
         s(i, 6) = s6
      end do
      s(:, 1) = s(:, 1) + (a(1, 2)*x(:, 5, k) + a(1, 3)*x(:, 6, k))
      s(:, 2) = s(:, 2) + (a(2, 1)*x(:, 4, k) + a(2, 3)*x(:, 6, k))
      s(:, 3) = s(:, 3) + (a(3, 1)*x(:, 4, k) + a(3, 2)*x(:, 5, k))
   end subroutine add_rest

   !> Adds m×(E×θ).
   pure subroutine add_row(k, f, m, x, s)
      integer, intent(in) :: k
      !> The factors; Δt times the moment, shape (3).
      real(wp), intent(in) :: f(lanes, n_factors, 0:highest_order), m(3), x(lanes, numbers, 0:highest_order)
      real(wp), intent(inout) :: s(lanes, 6)
      real(wp) :: t1, t2, t3
      integer :: i, j
      if (k < 0) return
      !GCC$ unroll 1
      do i = 1, lanes
         t1 = 0.0_wp
         t2 = 0.0_wp
         t3 = 0.0_wp
         do j = 0, k
            t1 = t1 + (x(i, 3, j)*f(i, 17, k - j) - x(i, 2, j)*f(i, 18, k - j))
            t2 = t2 + (x(i, 1, j)*f(i, 18, k - j) - x(i, 3, j)*f(i, 16, k - j))
            t3 = t3 + (x(i, 2, j)*f(i, 16, k - j) - x(i, 1, j)*f(i, 17, k - j))
         end do
         s(i, 4) = s(i, 4) + (m(2)*t3 - m(3)*t2)
         s(i, 5) = s(i, 5) + (m(3)*t1 - m(1)*t3)
         s(i, 6) = s(i, 6) + (m(1)*t2 - m(2)*t1)
      end do
   end subroutine add_row

   !> Adds the matrices of θ times it.
   pure subroutine add_rotated(k, f, x, s)
      integer, intent(in) :: k
      real(wp), intent(in) :: f(lanes, n_factors, 0:highest_order), x(lanes, numbers, 0:highest_order)
      real(wp), intent(inout) :: s(lanes, 6)
      real(wp) :: s4, s5, s6
      integer :: i, j
      if (k < 0) return
      !GCC$ unroll 1
      do i = 1, lanes
         s4 = s(i, 4)
         s5 = s(i, 5)
         s6 = s(i, 6)
         do j = 0, k
            s4 = s4 + (x(i, 1, j)*f(i, 16, k - j) + x(i, 2, j)*f(i, 19, k - j) + x(i, 3, j)*f(i, 22, k - j))
            s5 = s5 + (x(i, 1, j)*f(i, 17, k - j) + x(i, 2, j)*f(i, 20, k - j) + x(i, 3, j)*f(i, 23, k - j))
            s6 = s6 + (x(i, 1, j)*f(i, 18, k - j) + x(i, 2, j)*f(i, 21, k - j) + x(i, 3, j)*f(i, 24, k - j))
         end do
         s(i, 4) = s4
         s(i, 5) = s5
         s(i, 6) = s6
      end do
   end subroutine add_rotated

   !> Adds the contribution of u to ΔtδΩ, its effect on the torques, and u×L.
   pure subroutine add_lacking(k, f, d, x, s)
      integer, intent(in) :: k
      !> The factors; D, shape (3,3).
      real(wp), intent(in) :: f(lanes, n_factors, 0:highest_order), d(3, 3), x(lanes, numbers, 0:highest_order)
      real(wp), intent(inout) :: s(lanes, 6)
      real(wp) :: s4, s5, s6
      integer :: i, j
      if (k < 0) return
      !GCC$ unroll 1
      do i = 1, lanes
         s4 = s(i, 4)
         s5 = s(i, 5)
         s6 = s(i, 6)
         do j = 0, k
            s4 = s4 + (x(i, 8, j)*f(i, 6, k - j) - x(i, 9, j)*f(i, 5, k - j))
            s5 = s5 + (x(i, 9, j)*f(i, 4, k - j) - x(i, 7, j)*f(i, 6, k - j))
            s6 = s6 + (x(i, 7, j)*f(i, 5, k - j) - x(i, 8, j)*f(i, 4, k - j))
         end do
         s(i, 4) = s4
         s(i, 5) = s5
         s(i, 6) = s6
      end do
      do j = 1, 3
         s(:, j) = s(:, j) - x(:, 6 + j, k)
         s(:, 3 + j) = s(:, 3 + j) - (d(j, 1)*x(:, 7, k) + d(j, 2)*x(:, 8, k) + d(j, 3)*x(:, 9, k))
      end do
   end subroutine add_lacking

   !> Sums the series of a block, the smallest terms first.
   pure subroutine sum_block(order, x, ends)
      integer, intent(in) :: order
      real(wp), intent(in) :: x(lanes, numbers, 0:highest_order)
      !> The sums, and the last terms.
      real(wp), intent(out) :: ends(12, lanes)
      real(wp) :: sums(lanes, 6)
      integer :: i, k
      sums = x(:, :6, order)
      do i = 1, lanes
         ends(7:12, i) = sums(i, :)
      end do
      do k = order - 1, 0, -1
         sums = sums + x(:, :6, k)
      end do
      do i = 1, lanes
         ends(:6, i) = sums(i, :)
      end do
   end subroutine sum_block

end module nutate_sensitivity_series
