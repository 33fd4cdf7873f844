!> Sums of the power series of several bodies, and what these leave out, from their last coefficients: one body a lane.
!> The arithmetic is that of `nutate_series_sum` and `nutate_series_tail`, at the end of the unit of time, where all
!> powers are 1.
module nutate_lane_tail
   use nutate_kinds, only: wp
   use nutate_lane_choice, only: choose_lanes, replace_lanes
   use nutate_lane_motion, only: find_scale, scale_moments
   use nutate_lane_width, only: lanes
   use nutate_power_series, only: highest_order
   use nutate_series_tail, only: largest, largest_rest, least, least_denominator, same_direction
   implicit none
   private

   public :: begin_tail, add_row, add_angle, tail_products_t, tail_weights, sum_angles, sum_lanes

   !> Lengths of rows as angles (`nutate_motion_series`).
   real(wp), parameter :: root_half = sqrt(0.5_wp)

   !> Scalar products of the last four coefficients, the last one first: |x₀|², ..., |x₃|²; x₀·x₁, x₁·x₂, x₂·x₃;
   !> x₀·x₂, x₁·x₃; shape (lanes, any).
   type :: tail_products_t
      real(wp) :: squares(lanes, 4), next(lanes, 3), second(lanes, 2)
   end type tail_products_t

contains

   !> The products of the coefficients of L, as angles, that a tail is fitted to.
   pure subroutine begin_tail(order, inertia, w, products)
      integer, intent(in) :: order
      !> What the series is multiplied by; shape (lanes, 3).
      real(wp), intent(in) :: inertia(lanes, 3)
      real(wp), intent(in) :: w(lanes, 3, 0:highest_order)
      type(tail_products_t), intent(out) :: products
      real(wp) :: scale(lanes), scaled(lanes, 3)
      integer :: i
      call find_scale(inertia, w(:, :, 0), w(:, :, 1), w(:, :, 2), scale)
      call scale_moments(scale, inertia, scaled)
      call clear_parts(products)
      do i = 1, 3
         call add_parts(order, i, scaled(:, i), w, products)
      end do
   end subroutine begin_tail

   !> Adds those of a row.
   pure subroutine add_row(order, row, products)
      integer, intent(in) :: order
      real(wp), intent(in) :: row(lanes, 3, 0:highest_order)
      type(tail_products_t), intent(inout) :: products
      real(wp), parameter :: scale(lanes) = root_half
      integer :: i
      do i = 1, 3
         call add_parts(order, i, scale, row, products)
      end do
   end subroutine add_row

   !> Adds those of an angle.
   pure subroutine add_angle(n, x, products)
      !> Highest coefficient.
      integer, intent(in) :: n
      !> rad; shape (lanes, 0:highest_order).
      real(wp), intent(in) :: x(lanes, 0:highest_order)
      type(tail_products_t), intent(inout) :: products
      real(wp), parameter :: scale(lanes) = 1.0_wp
      call add_part(scale, x(:, n), x(:, n - 1), x(:, n - 2), x(:, n - 3), products%squares, products%next, &
                    products%second)
   end subroutine add_angle

   !> Adds those of one component of a series.
   pure subroutine add_parts(n, i, scale, x, products)
      !> Highest coefficient, and which component.
      integer, intent(in) :: n, i
      !> Makes it an angle; shape (lanes).
      real(wp), intent(in) :: scale(lanes), x(lanes, 3, 0:highest_order)
      type(tail_products_t), intent(inout) :: products
      call add_part(scale, x(:, i, n), x(:, i, n - 1), x(:, i, n - 2), x(:, i, n - 3), products%squares, &
                    products%next, products%second)
   end subroutine add_parts

   !> Before the first part.
   pure subroutine clear_parts(products)
      type(tail_products_t), intent(out) :: products
      products%squares = 0.0_wp
      products%next = 0.0_wp
      products%second = 0.0_wp
   end subroutine clear_parts

   !> Adds the products of one component, times its scale.
   pure subroutine add_part(scale, x0, x1, x2, x3, squares, next, second)
      !> Shape (lanes).
      real(wp), intent(in) :: scale(lanes)
      !> Of the last coefficient, the one before, ...; shape (lanes).
      real(wp), dimension(lanes), intent(in) :: x0, x1, x2, x3
      !> Components of `tail_products_t`.
      real(wp), intent(inout) :: squares(lanes, 4), next(lanes, 3), second(lanes, 2)
      real(wp) :: a, b, c, d
      integer :: i
      do i = 1, lanes
         a = scale(i)*x0(i)
         b = scale(i)*x1(i)
         c = scale(i)*x2(i)
         d = scale(i)*x3(i)
         squares(i, 1) = squares(i, 1) + a*a
         squares(i, 2) = squares(i, 2) + b*b
         squares(i, 3) = squares(i, 3) + c*c
         squares(i, 4) = squares(i, 4) + d*d
         next(i, 1) = next(i, 1) + a*b
         next(i, 2) = next(i, 2) + b*c
         next(i, 3) = next(i, 3) + c*d
         second(i, 1) = second(i, 1) + a*c
         second(i, 2) = second(i, 2) + b*d
      end do
   end subroutine add_part

   !> What comes after the last coefficient is `last` times it and `before` times the one before; both are 0 where the
   !> coefficients follow no recurrence, or a pole comes near.
   pure subroutine tail_weights(products, last, before)
      type(tail_products_t), intent(inout) :: products
      !> Shape (lanes).
      real(wp), intent(out) :: last(lanes), before(lanes)
      real(wp), dimension(lanes) :: follows, alpha, beta, rest
      associate (s => products%squares, next => products%next, second => products%second)
         call test_range(s, next, second, follows)
         call fit_lanes(s(:, 3), s(:, 4), next(:, 3), next(:, 2), second(:, 2), alpha, beta)
         call find_rest(s, next, second, alpha, beta, rest)
         call fit_lanes(s(:, 2), s(:, 3), next(:, 2), next(:, 1), second(:, 1), alpha, beta)
         call weigh(s(:, 1), rest, follows, alpha, beta, last, before)
      end associate
   end subroutine tail_weights

   !> Lanes whose squares are in a range where products of two are numbers; the others get those of a series that
   !> follows no recurrence, and can be divided by.
   pure subroutine test_range(s, next, second, follows)
      real(wp), intent(inout) :: s(lanes, 4), next(lanes, 3), second(lanes, 2)
      !> 1: yes.
      real(wp), intent(out) :: follows(lanes)
      real(wp) :: low, high
      integer :: i, k
      do i = 1, lanes
         low = min(min(s(i, 1), s(i, 2)), min(s(i, 3), s(i, 4)))
         high = max(max(s(i, 1), s(i, 2)), max(s(i, 3), s(i, 4)))
         follows(i) = merge(1.0_wp, 0.0_wp, low > least)*merge(1.0_wp, 0.0_wp, high < largest)
      end do
      do k = 1, 4
         call replace_lanes(follows, 1.0_wp, s(:, k))
      end do
      do k = 1, 3
         call replace_lanes(follows, 0.0_wp, next(:, k))
      end do
      do k = 1, 2
         call replace_lanes(follows, 0.0_wp, second(:, k))
      end do
   end subroutine test_range

   !> α and β that minimise |x₀ + αx₁ + βx₂|².
   pure subroutine fit_lanes(s1, s2, c12, c1, c2, alpha, beta)
      !> |x₁|², |x₂|², x₁·x₂, x₀·x₁, x₀·x₂; shape (lanes).
      real(wp), dimension(lanes), intent(in) :: s1, s2, c12, c1, c2
      real(wp), dimension(lanes), intent(out) :: alpha, beta
      real(wp), dimension(lanes) :: area, steep, of_both, beta_of_both
      real(wp) :: inverse
      integer :: i
      do i = 1, lanes
         area(i) = s1(i)*s2(i) - c12(i)*c12(i)
         steep(i) = merge(1.0_wp, 0.0_wp, area(i) > same_direction*(s1(i)*s2(i)))
      end do
      call replace_lanes(steep, 1.0_wp, area)
      do i = 1, lanes
         inverse = 1/area(i)
         of_both(i) = inverse*(c12(i)*c2(i) - s2(i)*c1(i))
         beta_of_both(i) = inverse*(c12(i)*c1(i) - s1(i)*c2(i))
         alpha(i) = -c1(i)/s1(i)
         beta(i) = 0.0_wp
      end do
      call choose_lanes(steep, of_both, alpha)
      call choose_lanes(steep, beta_of_both, beta)
   end subroutine fit_lanes

   !> What the recurrence leaves of the last coefficient, squared.
   pure subroutine find_rest(s, next, second, alpha, beta, rest)
      real(wp), intent(in) :: s(lanes, 4), next(lanes, 3), second(lanes, 2)
      real(wp), dimension(lanes), intent(in) :: alpha, beta
      real(wp), intent(out) :: rest(lanes)
      integer :: i
      do i = 1, lanes
         rest(i) = s(i, 1) + alpha(i)*(alpha(i)*s(i, 2) + 2*next(i, 1)) &
                   + beta(i)*(beta(i)*s(i, 3) + 2*second(i, 1)) + 2*alpha(i)*beta(i)*next(i, 2)
      end do
   end subroutine find_rest

   !> The weights, in lanes that follow a recurrence of which no pole comes near up to the end of the unit of time.
   pure subroutine weigh(square, rest, follows, alpha, beta, last, before)
      !> |x₀|², what is left of it, 1 in lanes that are in range, α and β; shape (lanes).
      real(wp), dimension(lanes), intent(in) :: square, rest, follows, alpha, beta
      real(wp), dimension(lanes), intent(out) :: last, before
      real(wp), dimension(lanes) :: used, bound, divisor, root
      real(wp) :: sum, power
      integer :: i
      do i = 1, lanes
         root(i) = alpha(i)*alpha(i) - 4*beta(i)*(1 - least_denominator)
         ! 1 where there is one.
         bound(i) = 1 - merge(1.0_wp, 0.0_wp, alpha(i) >= 0.0_wp)*merge(1.0_wp, 0.0_wp, beta(i) >= 0.0_wp)
         bound(i) = merge(0.0_wp, bound(i), root(i) < 0.0_wp)
      end do
      call replace_lanes(bound, 1.0_wp, root)
      do i = 1, lanes
         divisor(i) = sqrt(root(i)) - alpha(i)
      end do
      call replace_lanes(bound, 1.0_wp, divisor)
      do i = 1, lanes
         root(i) = 2*(1 - least_denominator)/divisor(i)
         last(i) = alpha(i)
         before(i) = beta(i)
      end do
      do i = 1, lanes
         used(i) = 1 - merge(1.0_wp, 0.0_wp, root(i) < 1.0_wp)
         used(i) = used(i)*merge(1.0_wp, 0.0_wp, rest(i) < largest_rest**2*square(i))
      end do
      do i = 1, lanes
         used(i) = follows(i)*used(i)
      end do
      call replace_lanes(used, 0.0_wp, last)
      call replace_lanes(used, 0.0_wp, before)
      do i = 1, lanes
         sum = last(i) + before(i)
         power = -1/(1 + sum)
         last(i) = power*sum
         before(i) = power*before(i)
      end do
      call replace_lanes(used, 0.0_wp, last)
      call replace_lanes(used, 0.0_wp, before)
   end subroutine weigh

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

end module nutate_lane_tail
