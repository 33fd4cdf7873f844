!> Power series of vectors that turn against several bodies at once: one body a lane, each with its own numbers.
!>
!> The arithmetic is that of tops in `nutate_diagonal_series`, and of one pair in `nutate_motion_series`, product by
!> product. The two rows are series of their own. Series have the lanes first, then the components, so that a
!> coefficient is one piece of memory. Where products are added up, the loop over coefficients is left at its end:
!> gfortran then puts it inside the loop over lanes, with the sums in registers.
module nutate_lane_row_series
   use nutate_kinds, only: wp
   use nutate_lane_torque_series, only: add_torques, gradient_series_t, lane_torques_t
   use nutate_lane_vectors, only: find_full_rates
   use nutate_lane_width, only: lanes
   use nutate_power_series, only: highest_order, inverses
   implicit none
   private

   public :: expand_top_lanes, expand_axial_lanes, expand_pair_lanes

contains

   !> Tops: w = Ω·time_unit, and the rows.
   pure subroutine expand_top_lanes(order, c, moments, w, rows)
      !> At least 3.
      integer, intent(in) :: order
      !> (J₂ - J₃)/J₁, ...; shape (lanes, 3). The potential's moment times time_unit²/Jᵢ in column i; shape
      !> (lanes, 3, 3).
      real(wp), intent(in) :: c(lanes, 3), moments(lanes, 3, 3)
      !> Coefficient 0 on entry, all on exit; shapes (lanes, 3, 0:highest_order) and (lanes, 3, 0:highest_order, 4);
      !> the first two rows.
      real(wp), intent(inout) :: w(lanes, 3, 0:highest_order), rows(lanes, 3, 0:highest_order, 4)
      real(wp) :: sums(lanes, 3)
      integer :: k, row
      do k = 0, order - 1
         sums = 0.0_wp
         if (k > 1) call add_rate_products(k, w, sums)
         call add_rate_ends(k, w(:, :, 0), w(:, :, k), sums)
         call continue_rates(inverses(k + 1), c, moments, sums, rows(:, :, k, 1), w(:, :, k + 1))
         do row = 1, 2
            sums = 0.0_wp
            if (k > 1) call add_row_products(k, w, rows(:, :, :, row), sums)
            call add_row_ends(k, w(:, :, 0), w(:, :, k), rows(:, :, 0, row), rows(:, :, k, row), sums)
            call continue_row(inverses(k + 1), sums, rows(:, :, k + 1, row))
         end do
      end do
   end subroutine expand_top_lanes

   !> The products w₂w₃, ... of coefficient k > 1 that do without the coefficients 0 and k.
   pure subroutine add_rate_products(k, w, sums)
      integer, intent(in) :: k
      real(wp), intent(in) :: w(lanes, 3, 0:highest_order)
      !> Shape (lanes, 3).
      real(wp), intent(inout) :: sums(lanes, 3)
      real(wp) :: p1, p2, p3
      integer :: i, j
      do i = 1, lanes
         p1 = 0.0_wp
         p2 = 0.0_wp
         p3 = 0.0_wp
         j = 1
         do
            p1 = p1 + w(i, 2, j)*w(i, 3, k - j)
            p2 = p2 + w(i, 3, j)*w(i, 1, k - j)
            p3 = p3 + w(i, 1, j)*w(i, 2, k - j)
            j = j + 1
            if (j >= k) exit
         end do
         sums(i, 1) = p1
         sums(i, 2) = p2
         sums(i, 3) = p3
      end do
   end subroutine add_rate_products

   !> Adds the products of coefficient 0 with coefficient k, and, from k = 1 on, of k with 0.
   pure subroutine add_rate_ends(k, first, w, sums)
      integer, intent(in) :: k
      !> Coefficients 0 and k; shape (lanes, 3).
      real(wp), intent(in) :: first(lanes, 3), w(lanes, 3)
      real(wp), intent(inout) :: sums(lanes, 3)
      integer :: i
      do i = 1, lanes
         sums(i, 1) = sums(i, 1) + first(i, 2)*w(i, 3)
         sums(i, 2) = sums(i, 2) + first(i, 3)*w(i, 1)
         sums(i, 3) = sums(i, 3) + first(i, 1)*w(i, 2)
      end do
      if (k == 0) return
      do i = 1, lanes
         sums(i, 1) = sums(i, 1) + w(i, 2)*first(i, 3)
         sums(i, 2) = sums(i, 2) + w(i, 3)*first(i, 1)
         sums(i, 3) = sums(i, 3) + w(i, 1)*first(i, 2)
      end do
   end subroutine add_rate_ends

   !> Coefficient k + 1 of w.
   pure subroutine continue_rates(inverse, c, moments, sums, e, next)
      !> 1/(k + 1)
      real(wp), intent(in) :: inverse
      !> As in `expand_top_lanes`.
      real(wp), intent(in) :: c(lanes, 3), moments(lanes, 3, 3)
      !> The products, and coefficient k of the first row; shape (lanes, 3).
      real(wp), intent(in) :: sums(lanes, 3), e(lanes, 3)
      real(wp), intent(out) :: next(lanes, 3)
      integer :: i
      do i = 1, lanes
         next(i, 1) = inverse*(c(i, 1)*sums(i, 1) + (moments(i, 2, 1)*e(i, 3) - moments(i, 3, 1)*e(i, 2)))
         next(i, 2) = inverse*(c(i, 2)*sums(i, 2) + (moments(i, 3, 2)*e(i, 1) - moments(i, 1, 2)*e(i, 3)))
         next(i, 3) = inverse*(c(i, 3)*sums(i, 3) + (moments(i, 1, 3)*e(i, 2) - moments(i, 2, 3)*e(i, 1)))
      end do
   end subroutine continue_rates

   !> The products E×w of coefficient k > 1 that do without the coefficients 0 and k.
   pure subroutine add_row_products(k, w, e, sums)
      integer, intent(in) :: k
      real(wp), intent(in) :: w(lanes, 3, 0:highest_order), e(lanes, 3, 0:highest_order)
      !> Shape (lanes, 3).
      real(wp), intent(inout) :: sums(lanes, 3)
      real(wp) :: s1, s2, s3
      integer :: i, j
      do i = 1, lanes
         s1 = 0.0_wp
         s2 = 0.0_wp
         s3 = 0.0_wp
         j = 1
         do
            s1 = s1 + (e(i, 2, j)*w(i, 3, k - j) - e(i, 3, j)*w(i, 2, k - j))
            s2 = s2 + (e(i, 3, j)*w(i, 1, k - j) - e(i, 1, j)*w(i, 3, k - j))
            s3 = s3 + (e(i, 1, j)*w(i, 2, k - j) - e(i, 2, j)*w(i, 1, k - j))
            j = j + 1
            if (j >= k) exit
         end do
         sums(i, 1) = s1
         sums(i, 2) = s2
         sums(i, 3) = s3
      end do
   end subroutine add_row_products

   !> Adds those of the row at the start with coefficient k of w, and, from k = 1 on, of coefficient k with the start.
   pure subroutine add_row_ends(k, first, w, first_row, e, sums)
      integer, intent(in) :: k
      !> Coefficients 0 and k; shape (lanes, 3).
      real(wp), dimension(lanes, 3), intent(in) :: first, w, first_row, e
      real(wp), intent(inout) :: sums(lanes, 3)
      integer :: i
      do i = 1, lanes
         sums(i, 1) = sums(i, 1) + (first_row(i, 2)*w(i, 3) - first_row(i, 3)*w(i, 2))
         sums(i, 2) = sums(i, 2) + (first_row(i, 3)*w(i, 1) - first_row(i, 1)*w(i, 3))
         sums(i, 3) = sums(i, 3) + (first_row(i, 1)*w(i, 2) - first_row(i, 2)*w(i, 1))
      end do
      if (k == 0) return
      do i = 1, lanes
         sums(i, 1) = sums(i, 1) + (e(i, 2)*first(i, 3) - e(i, 3)*first(i, 2))
         sums(i, 2) = sums(i, 2) + (e(i, 3)*first(i, 1) - e(i, 1)*first(i, 3))
         sums(i, 3) = sums(i, 3) + (e(i, 1)*first(i, 2) - e(i, 2)*first(i, 1))
      end do
   end subroutine add_row_ends

   !> Coefficient k + 1 of a row.
   pure subroutine continue_row(inverse, sums, next)
      !> 1/(k + 1)
      real(wp), intent(in) :: inverse
      real(wp), intent(in) :: sums(lanes, 3)
      real(wp), intent(out) :: next(lanes, 3)
      integer :: i
      do i = 1, lanes
         next(i, 1) = inverse*sums(i, 1)
         next(i, 2) = inverse*sums(i, 2)
         next(i, 3) = inverse*sums(i, 3)
      end do
   end subroutine continue_row

   !> Bodies of any inertia: w = Ω·time_unit, in the axial frame L/J₁·time_unit; L, and as many rows E as tell the
   !> attitude.
   pure subroutine expand_pair_lanes(order, last, to_angle, axis, across, torques, w, rows, angle)
      !> At least 3; the last of the rows: 2 without potentials, else 4.
      integer, intent(in) :: order, last
      !> J⁻¹ times the unit of time; shape (lanes, 3, 3).
      real(wp), intent(in) :: to_angle(lanes, 3, 3)
      !> That of symmetry, 0: none; with one 1/J₁ times the unit of time, shape (lanes).
      integer, intent(in) :: axis
      real(wp), intent(in) :: across(lanes)
      !> With four rows.
      type(lane_torques_t), intent(in) :: torques
      !> Coefficient 0 on entry, of Ω·time_unit; all of L and E, all but the last of w on exit; shapes
      !> (lanes, 3, 0:highest_order) and (lanes, 3, 0:highest_order, 4), L first.
      real(wp), intent(inout) :: w(lanes, 3, 0:highest_order), rows(lanes, 3, 0:highest_order, 4)
      !> By which bodies turn in the axial frame, from coefficient 1 on, rad; shape (lanes, 0:highest_order).
      real(wp), intent(inout) :: angle(lanes, 0:highest_order)
      type(gradient_series_t) :: gradient
      real(wp) :: sums(lanes, 3)
      integer :: k, row
      do k = 0, order - 1
         if (k > 0) call find_full_rates(to_angle, rows(:, :, k, 1), w(:, :, k))
         if (axis > 0) call leave_spin(inverses(k + 1), axis, across, rows(:, :, k, 1), w(:, :, k), angle(:, k + 1))
         do row = 1, last
            sums = 0.0_wp
            if (k > 1) call add_row_products(k, w, rows(:, :, :, row), sums)
            call add_row_ends(k, w(:, :, 0), w(:, :, k), rows(:, :, 0, row), rows(:, :, k, row), sums)
            if (row == 1 .and. last > 2) call add_torques(torques, k, rows(:, :, :, 2:4), gradient, sums)
            call continue_row(inverses(k + 1), sums, rows(:, :, k + 1, row))
         end do
      end do
   end subroutine expand_pair_lanes

   !> Coefficient k of L/J₁·time_unit in the place of Ω·time_unit, and k + 1 of the angle in the axial frame.
   pure subroutine leave_spin(inverse, axis, across, l, w, angle)
      !> 1/(k + 1)
      real(wp), intent(in) :: inverse
      integer, intent(in) :: axis
      !> As in `expand_pair_lanes`, and coefficient k of L, N m s; shapes (lanes) and (lanes, 3).
      real(wp), intent(in) :: across(lanes), l(lanes, 3)
      real(wp), intent(inout) :: w(lanes, 3)
      !> Shape (lanes).
      real(wp), intent(out) :: angle(lanes)
      real(wp) :: rate(lanes), along(lanes)
      integer :: i
      rate = w(:, axis)
      along = l(:, axis)
      do i = 1, lanes
         angle(i) = inverse*(rate(i) - across(i)*along(i))
         w(i, 1) = across(i)*l(i, 1)
         w(i, 2) = across(i)*l(i, 2)
         w(i, 3) = across(i)*l(i, 3)
      end do
   end subroutine leave_spin

   !> Symmetric tops in the axial frame, components with the axis last: w = L/J₁·time_unit, of which the last component
   !> is constant, and the rows.
   pure subroutine expand_axial_lanes(order, g, w, rows)
      !> At least 3.
      integer, intent(in) :: order
      !> Moment of the potential along the axis, over J₁, times the square of the unit of time; shape (lanes).
      real(wp), intent(in) :: g(lanes)
      !> Coefficient 0 on entry, all on exit; shapes (lanes, 3, 0:highest_order) and (lanes, 3, 0:highest_order, 4);
      !> the first two rows.
      real(wp), intent(inout) :: w(lanes, 3, 0:highest_order), rows(lanes, 3, 0:highest_order, 4)
      real(wp) :: sums(lanes, 3)
      integer :: k, row
      w(:, 3, 1:order) = 0.0_wp
      do k = 0, order - 1
         call continue_axial_rates(inverses(k + 1), g, rows(:, :, k, 1), w(:, :, k + 1))
         do row = 1, 2
            call add_axial_products(k, w, rows(:, :, :, row), sums)
            call continue_row(inverses(k + 1), sums, rows(:, :, k + 1, row))
         end do
      end do
   end subroutine expand_axial_lanes

   !> E×w of coefficient k.
   pure subroutine add_axial_products(k, w, e, sums)
      integer, intent(in) :: k
      real(wp), intent(in) :: w(lanes, 3, 0:highest_order), e(lanes, 3, 0:highest_order)
      !> Shape (lanes, 3).
      real(wp), intent(out) :: sums(lanes, 3)
      real(wp) :: s1, s2, s3
      integer :: i, j
      do i = 1, lanes
         s1 = e(i, 2, k)*w(i, 3, 0)
         s2 = -e(i, 1, k)*w(i, 3, 0)
         s3 = 0.0_wp
         j = 0
         do
            s1 = s1 - e(i, 3, j)*w(i, 2, k - j)
            s2 = s2 + e(i, 3, j)*w(i, 1, k - j)
            s3 = s3 + (e(i, 1, j)*w(i, 2, k - j) - e(i, 2, j)*w(i, 1, k - j))
            j = j + 1
            if (j > k) exit
         end do
         sums(i, 1) = s1
         sums(i, 2) = s2
         sums(i, 3) = s3
      end do
   end subroutine add_axial_products

   !> Coefficient k + 1 of w, of which the last component stays.
   pure subroutine continue_axial_rates(inverse, g, e, next)
      !> 1/(k + 1)
      real(wp), intent(in) :: inverse
      !> As in `expand_axial_lanes`, and coefficient k of the first row, shape (lanes, 3).
      real(wp), intent(in) :: g(lanes), e(lanes, 3)
      real(wp), intent(inout) :: next(lanes, 3)
      integer :: i
      do i = 1, lanes
         next(i, 1) = -(g(i)*inverse)*e(i, 2)
         next(i, 2) = (g(i)*inverse)*e(i, 1)
      end do
   end subroutine continue_axial_rates

end module nutate_lane_row_series
