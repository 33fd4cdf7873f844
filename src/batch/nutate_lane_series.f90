!> Power series of the motion of several bodies at once: one body a lane, each with its own numbers.
!>
!> The arithmetic is that of `nutate_diagonal_series`, product by product. Series have the lanes first, then the
!> components, so that a coefficient is one piece of memory. Where products are added up, the loop over coefficients is
!> left at its end: gfortran then puts it inside the loop over lanes, with the sums in registers.
module nutate_lane_series
   use nutate_kinds, only: wp
   use nutate_lane_width, only: lanes
   use nutate_power_series, only: highest_order, inverses
   implicit none
   private

   public :: expand_free_lanes, sum_angles, sum_lanes

contains

   !> Free bodies: w = Ω·time_unit, and the angle θ about the momentum.
   pure subroutine expand_free_lanes(order, c, weights, axis, w, angle)
      !> At least 3.
      integer, intent(in) :: order
      !> (J₂ - J₃)/J₁, ...; u₀ times the moments over |L| and the unit of time; u₀; shape (lanes, 3).
      real(wp), intent(in) :: c(lanes, 3), weights(lanes, 3), axis(lanes, 3)
      !> Coefficient 0 on entry, all on exit; shape (lanes, 3, 0:highest_order).
      real(wp), intent(inout) :: w(lanes, 3, 0:highest_order)
      !> θ, rad, from coefficient 1 on; shape (lanes, 0:highest_order).
      real(wp), intent(inout) :: angle(lanes, 0:highest_order)
      real(wp) :: rate(lanes, 0:highest_order), cosine(lanes, 0:highest_order), p(lanes, 4)
      integer :: k
      call begin_free(c, axis, w(:, :, 0), rate(:, 0), angle(:, 1), w(:, :, 1))
      p = 0.0_wp
      do k = 1, order - 1
         if (k > 1) call add_free_products(k, w, cosine, rate, p)
         call continue_free(inverses(k + 1), c, weights, axis, w(:, :, 0), w(:, :, k), rate(:, 0), p, cosine(:, k), &
                            rate(:, k), angle(:, k + 1), w(:, :, k + 1))
      end do
   end subroutine expand_free_lanes

   !> Coefficient 1 from the start.
   pure subroutine begin_free(c, axis, w, rate, angle, next)
      !> As in `expand_free_lanes`, and coefficient 0; shape (lanes, 3).
      real(wp), intent(in) :: c(lanes, 3), axis(lanes, 3), w(lanes, 3)
      !> θ' and θ; shape (lanes).
      real(wp), intent(out) :: rate(lanes), angle(lanes)
      real(wp), intent(out) :: next(lanes, 3)
      integer :: i
      do i = 1, lanes
         rate(i) = axis(i, 1)*w(i, 1) + axis(i, 2)*w(i, 2) + axis(i, 3)*w(i, 3)
         angle(i) = rate(i)
         ! The sum takes the sign of a zero away.
         next(i, 1) = c(i, 1)*(0.0_wp + w(i, 2)*w(i, 3))
         next(i, 2) = c(i, 2)*(0.0_wp + w(i, 3)*w(i, 1))
         next(i, 3) = c(i, 3)*(0.0_wp + w(i, 1)*w(i, 2))
      end do
   end subroutine begin_free

   !> The products of coefficient k > 1 that do without the coefficients 0 and k: w₂w₃, ..., and u·u₀ times θ'.
   pure subroutine add_free_products(k, w, cosine, rate, p)
      integer, intent(in) :: k
      real(wp), intent(in) :: w(lanes, 3, 0:highest_order)
      real(wp), intent(in) :: cosine(lanes, 0:highest_order), rate(lanes, 0:highest_order)
      !> Shape (lanes, 4).
      real(wp), intent(out) :: p(lanes, 4)
      real(wp) :: p1, p2, p3, p4
      integer :: i, j
      do i = 1, lanes
         p1 = 0.0_wp
         p2 = 0.0_wp
         p3 = 0.0_wp
         p4 = 0.0_wp
         j = 1
         do
            p1 = p1 + w(i, 2, j)*w(i, 3, k - j)
            p2 = p2 + w(i, 3, j)*w(i, 1, k - j)
            p3 = p3 + w(i, 1, j)*w(i, 2, k - j)
            p4 = p4 + cosine(i, j)*rate(i, k - j)
            j = j + 1
            if (j >= k) exit
         end do
         p(i, 1) = p1
         p(i, 2) = p2
         p(i, 3) = p3
         p(i, 4) = p4
      end do
   end subroutine add_free_products

   !> Coefficient k + 1, with the products that come last.
   pure subroutine continue_free(inverse, c, weights, axis, first, w, first_rate, p, cosine, rate, angle, next)
      !> 1/(k + 1)
      real(wp), intent(in) :: inverse
      !> As in `expand_free_lanes`; coefficients 0 and k; shape (lanes, 3).
      real(wp), dimension(lanes, 3), intent(in) :: c, weights, axis, first, w
      !> Coefficient 0 of θ', and the other products; shapes (lanes) and (lanes, 4).
      real(wp), intent(in) :: first_rate(lanes), p(lanes, 4)
      !> Coefficient k of u·u₀ and of θ', k + 1 of θ; shape (lanes).
      real(wp), dimension(lanes), intent(out) :: cosine, rate, angle
      !> Shape (lanes, 3).
      real(wp), intent(out) :: next(lanes, 3)
      integer :: i
      do i = 1, lanes
         cosine(i) = weights(i, 1)*w(i, 1) + weights(i, 2)*w(i, 2) + weights(i, 3)*w(i, 3)
         rate(i) = 0.5_wp*((axis(i, 1)*w(i, 1) + axis(i, 2)*w(i, 2) + axis(i, 3)*w(i, 3)) &
                           - (p(i, 4) + cosine(i)*first_rate(i)))
         angle(i) = inverse*rate(i)
         next(i, 1) = inverse*(c(i, 1)*((p(i, 1) + first(i, 2)*w(i, 3)) + w(i, 2)*first(i, 3)))
         next(i, 2) = inverse*(c(i, 2)*((p(i, 2) + first(i, 3)*w(i, 1)) + w(i, 3)*first(i, 1)))
         next(i, 3) = inverse*(c(i, 3)*((p(i, 3) + first(i, 1)*w(i, 2)) + w(i, 1)*first(i, 2)))
      end do
   end subroutine continue_free

   !> Σ xₖ from k = 1 on, which is the series at the end of the unit of time, and the tail; of the components of a
   !> vector.
   pure subroutine sum_lanes(order, x, last, before, total)
      !> Highest coefficient, at least 3.
      integer, intent(in) :: order
      real(wp), intent(in) :: x(lanes, 3, 0:highest_order)
      !> Weights of the last coefficient and of the one before in the tail; shape (lanes).
      real(wp), intent(in) :: last(lanes), before(lanes)
      !> Shape (lanes, 3).
      real(wp), intent(out) :: total(lanes, 3)
      real(wp) :: start(lanes, 3), even1, even2, even3, odd1, odd2, odd3
      integer :: i, k, top
      top = 2*((order - 1)/2)
      start = 0.0_wp
      if (order > top + 1) start = x(:, :, order)
      do i = 1, lanes
         odd1 = x(i, 1, top + 1)
         odd2 = x(i, 2, top + 1)
         odd3 = x(i, 3, top + 1)
         even1 = start(i, 1)
         even2 = start(i, 2)
         even3 = start(i, 3)
         k = top
         do
            odd1 = odd1 + x(i, 1, k - 1)
            odd2 = odd2 + x(i, 2, k - 1)
            odd3 = odd3 + x(i, 3, k - 1)
            even1 = even1 + x(i, 1, k)
            even2 = even2 + x(i, 2, k)
            even3 = even3 + x(i, 3, k)
            k = k - 2
            if (k < 2) exit
         end do
         total(i, 1) = (odd1 + even1) + (last(i)*x(i, 1, order) + before(i)*x(i, 1, order - 1))
         total(i, 2) = (odd2 + even2) + (last(i)*x(i, 2, order) + before(i)*x(i, 2, order - 1))
         total(i, 3) = (odd3 + even3) + (last(i)*x(i, 3, order) + before(i)*x(i, 3, order - 1))
      end do
   end subroutine sum_lanes

   !> The same of an angle.
   pure subroutine sum_angles(order, x, last, before, total)
      integer, intent(in) :: order
      real(wp), intent(in) :: x(lanes, 0:highest_order)
      real(wp), intent(in) :: last(lanes), before(lanes)
      !> Shape (lanes).
      real(wp), intent(out) :: total(lanes)
      real(wp) :: start(lanes), even, odd
      integer :: i, k, top
      top = 2*((order - 1)/2)
      start = 0.0_wp
      if (order > top + 1) start = x(:, order)
      do i = 1, lanes
         odd = x(i, top + 1)
         even = start(i)
         k = top
         do
            odd = odd + x(i, k - 1)
            even = even + x(i, k)
            k = k - 2
            if (k < 2) exit
         end do
         total(i) = (odd + even) + (last(i)*x(i, order) + before(i)*x(i, order - 1))
      end do
   end subroutine sum_angles

end module nutate_lane_series
