!> The motion of a rigid body as power series in time: body momentum, and directions fixed in space as the body sees
!> them.
!>
!>     L̇ = L×Ω + τ,   Ė = E×Ω,   Ω = J⁻¹(L - h),   E = R(q)ᵀe
!>
!> Everything rotates against the body alike, so that L and the rows E are lanes of one product with Ω: two lanes make a
!> pair, as many as a vector instruction takes at a time. Three rows are the attitude, and cost less than the series of
!> q; without torque L is one of them, another follows, and one pair does. A free body and a top of diagonal inertia
!> have series of their own (`nutate_diagonal_series`).
module nutate_motion_series
   use nutate_effect_list, only: effect_list_t
   use nutate_diagonal_series, only: expand_free, expand_top, steepest_growth
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, quat_product, rotate_to_body
   use nutate_power_series, only: highest_order, inverses
   use nutate_torque_series, only: torque_series_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: motion_series_t

   !> The equations used: L and three rows; L and one; a top; a free body.
   integer, parameter :: TWO_PAIRS = 1, ONE_PAIR = 2, TOP = 3, FREE_BODY = 4
   !> Series that are summed at a time, at most.
   integer, parameter :: most_series = 6
   !> The momentum is a row of the attitude where it is at least this part of a rotor's: rounding, which goes by the
   !> larger of the two, then leaves its direction to 100ε.
   real(wp), parameter :: least_share = 1e-2_wp

   !> Series of one step.
   type :: motion_series_t
      !> Highest coefficient, to be set.
      integer :: order = 0
      !> Start and unit of time, s, to be set; the latter is negative backwards in time.
      real(wp) :: t = 0.0_wp, time_unit = 1.0_wp
      !> Ω times the unit of time; shape (3, 0:highest_order).
      real(wp) :: omega(3, 0:highest_order) = 0.0_wp
      type(torque_series_t) :: torques
      !> `TWO_PAIRS`, ...: of the system, and of the present series.
      integer, private :: best = TWO_PAIRS, equations = TWO_PAIRS
      !> Lanes (L, E1) and (E2, E3), of a top (E1, E2); body axes; shape (2, 3, 0:highest_order).
      real(wp), private :: lanes_1(2, 3, 0:highest_order) = 0.0_wp, lanes_2(2, 3, 0:highest_order) = 0.0_wp
      !> Angle about the momentum of a free body, rad; shape (0:highest_order).
      real(wp), private :: angle(0:highest_order) = 0.0_wp
      !> L at the start, N m s, and diagonal moments over the unit of time; shape (3).
      real(wp), private :: momentum(3) = 0.0_wp, inertia(3) = 0.0_wp
      !> The rows at the start; second, of one pair, and of a free body the only one: L/|L|; shape (3,3).
      real(wp), private :: frame(3, 3) = 0.0_wp
   contains
      !> Finds out which equations do.
      procedure :: prepare
      !> Computes the coefficients.
      procedure :: expand
      !> Momentum and rotation at a time.
      procedure :: evaluate
      !> Size of a coefficient.
      procedure :: size_of
      procedure :: momentum_square
   end type motion_series_t

contains

   !> Finds out which equations do for a system, whose torques are prepared.
   pure subroutine prepare(self, system, attitude)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> The attitude is wanted.
      logical, intent(in) :: attitude
      logical :: diagonal
      associate (j => system%body%inverse_inertia)
         diagonal = .not. any(abs([j(2, 1), j(3, 1), j(3, 2), system%effects%rotor_momentum]) > 0.0_wp)
      end associate
      self%best = TWO_PAIRS
      if (.not. self%torques%has_more .and. self%torques%rank == 0) then
         self%best = ONE_PAIR
         if (diagonal) self%best = FREE_BODY
      else if (.not. self%torques%has_more .and. self%torques%n_moments == 1 .and. diagonal) then
         self%best = TOP
      else if (.not. attitude .and. self%torques%rank < 2) then
         self%best = ONE_PAIR
      end if
   end subroutine prepare

   !> Computes the coefficients from the values at the start.
   pure subroutine expand(self, system, acts, q, momentum, converges)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> The torque acts; shape (number of torques).
      logical, intent(in) :: acts(:)
      !> Attitude, body→space, and L, body axes, N m s; shapes (4), (3).
      real(wp), intent(in) :: q(4), momentum(3)
      !> False where the coefficients grow so fast that the unit of time is far too long.
      logical, intent(out) :: converges
      real(wp) :: c(3), moments(3, 3)
      integer :: i
      self%momentum = momentum
      call choose_frame(self, system, q)
      if (self%equations == TWO_PAIRS .or. self%equations == ONE_PAIR) then
         call expand_pairs(self, system, acts, converges)
         return
      end if
      associate (inverse => system%body%inverse_inertia, inertia => system%body%inertia)
         do i = 1, 3
            self%omega(i, 0) = self%time_unit*inverse(i, i)*momentum(i)
            self%inertia(i) = inertia(i, i)/self%time_unit
            moments(:, i) = (self%time_unit*inverse(i, i))*(self%time_unit*self%torques%moments(:, 1))
         end do
         c = [inverse(1, 1)*(inertia(2, 2) - inertia(3, 3)), inverse(2, 2)*(inertia(3, 3) - inertia(1, 1)), &
              inverse(3, 3)*(inertia(1, 1) - inertia(2, 2))]
      end associate
      if (self%equations == TOP) then
         self%lanes_1(1, :, 0) = self%frame(:, 1)
         self%lanes_1(2, :, 0) = self%frame(:, 2)
         call expand_top(self%order, c, moments, self%omega, self%lanes_1, converges)
      else
         call expand_free(self%order, c, self%inertia/length_of(momentum), self%frame(:, 2), self%omega, self%angle, &
                          converges)
      end if
   end subroutine expand

   !> The rows at the start: of the basis of the directions; without torque a vector across L, and L.
   pure subroutine choose_frame(self, system, q)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: q(4)
      real(wp) :: length, across(3)
      integer :: i
      self%equations = self%best
      associate (torques => self%torques, f => self%frame)
         if (torques%has_more .or. torques%rank > 0) then
            do i = 1, 3
               f(:, i) = rotate_to_body(q, torques%basis(:, i))
            end do
            return
         end if
         length = length_of(self%momentum)
         if (length > max(least_share*length_of(system%effects%rotor_momentum), tiny(1.0_wp))) then
            f(:, 2) = self%momentum/length
            if (self%best == FREE_BODY) return
            across = 0.0_wp
            across(minloc(abs(f(:, 2)), 1)) = 1.0_wp
            f(:, 1) = cross(across, f(:, 2))
            f(:, 1) = f(:, 1)/length_of(f(:, 1))
            f(:, 3) = cross(f(:, 1), f(:, 2))
         else
            self%equations = TWO_PAIRS
            f = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
         end if
      end associate
   end subroutine choose_frame

   !> √(x·x), cheaper than the intrinsic, which guards against overflow.
   pure real(wp) function length_of(x)
      real(wp), intent(in) :: x(3)
      length_of = sqrt(x(1)*x(1) + x(2)*x(2) + x(3)*x(3))
   end function length_of

   !> Momentum and rows as pairs of lanes.
   pure subroutine expand_pairs(self, system, acts, converges)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      logical, intent(in) :: acts(:)
      logical, intent(out) :: converges
      real(wp), dimension(2, 3) :: a, b, sums_a, sums_b
      real(wp) :: to_omega(3, 3), moments(3, 3), w(3), tau(3), bound
      logical :: two
      integer :: k
      to_omega = self%time_unit*system%body%inverse_inertia
      moments = self%time_unit*self%torques%moments
      two = self%equations == TWO_PAIRS
      a(1, :) = self%momentum
      a(2, :) = self%frame(:, 1)
      b(1, :) = self%frame(:, 2)
      b(2, :) = self%frame(:, 3)
      w = self%momentum - system%effects%rotor_momentum
      bound = steepest_growth
      do k = 0, self%order
         self%lanes_1(:, :, k) = a
         self%lanes_2(:, :, k) = b
         w = to_omega(:, 1)*w(1) + to_omega(:, 2)*w(2) + to_omega(:, 3)*w(3)
         self%omega(:, k) = w
         converges = max(abs(w(1)), abs(w(2)), abs(w(3))) <= bound
         if (.not. converges .or. k == self%order) return
         bound = bound*steepest_growth
         tau = 0.0_wp
         if (self%torques%n_moments > 0 .or. self%torques%has_more) &
            call add_torque(self, system%effects, k, acts, moments, tau)
         call add_inner(k, self%lanes_1, self%omega, sums_a)
         if (two) call add_inner(k, self%lanes_2, self%omega, sums_b)
         call add_outer(k, self%lanes_1(:, :, 0), a, self%omega(:, 0), w, sums_a)
         w = inverses(k + 1)*(sums_a(1, :) + tau)
         a(1, :) = w
         a(2, :) = inverses(k + 1)*sums_a(2, :)
         if (.not. two) cycle
         call add_outer(k, self%lanes_2(:, :, 0), b, self%omega(:, 0), self%omega(:, k), sums_b)
         b = inverses(k + 1)*sums_b
      end do
   end subroutine expand_pairs

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

   !> Adds m×E.
   pure subroutine add_moment(moment, row, tau)
      real(wp), intent(in) :: moment(3), row(3)
      real(wp), intent(inout) :: tau(3)
      tau(1) = tau(1) + (moment(2)*row(3) - moment(3)*row(2))
      tau(2) = tau(2) + (moment(3)*row(1) - moment(1)*row(3))
      tau(3) = tau(3) + (moment(1)*row(2) - moment(2)*row(1))
   end subroutine add_moment

   !> Adds coefficient k of the torque times the unit of time.
   pure subroutine add_torque(self, effects, k, acts, moments, tau)
      class(motion_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: k
      logical, intent(in) :: acts(:)
      !> Of the linear potentials, times the unit of time.
      real(wp), intent(in) :: moments(3, 3)
      real(wp), intent(inout) :: tau(3)
      real(wp) :: rows(3, 3), more(3)
      integer :: i
      rows(:, 1) = self%lanes_1(2, :, k)
      rows(:, 2) = self%lanes_2(1, :, k)
      rows(:, 3) = self%lanes_2(2, :, k)
      do i = 1, self%torques%n_moments
         call add_moment(moments(:, i), rows(:, i), tau)
      end do
      if (.not. self%torques%has_more) return
      more = 0.0_wp
      call self%torques%add_terms(effects, k, self%torques%start, self%time_unit, acts, &
                                  self%omega(:, k)/self%time_unit, rows, more)
      tau = tau + self%time_unit*more
   end subroutine add_torque

   !> Momentum, and rotation since the start, at a time from the start.
   pure subroutine evaluate(self, s, momentum, rotation)
      class(motion_series_t), intent(in) :: self
      !> In units of time.
      real(wp), intent(in) :: s
      !> L, body axes, N m s; shape (3).
      real(wp), intent(out) :: momentum(3)
      !> Quaternion c, not normalised: the attitude is that of the start times c; shape (4). Without attitude it may say
      !> nothing.
      real(wp), intent(out) :: rotation(4)
      real(wp) :: values(2, 3), rows(3, 3), angle(1), axis(3), along(3), shortest(4), about(4)
      select case (self%equations)
      case (FREE_BODY)
         call sum_series(3, self%order, s, self%omega, momentum)
         momentum = self%momentum + self%inertia*momentum
         call sum_series(1, self%order, s, self%angle, angle)
         axis = self%frame(:, 2)
         along = momentum/length_of(momentum)
         shortest(1) = 1 + (along(1)*axis(1) + along(2)*axis(2) + along(3)*axis(3))
         shortest(2:4) = cross(along, axis)
         about(1) = cos(0.5_wp*angle(1))
         about(2:4) = sin(0.5_wp*angle(1))*axis
         rotation = quat_product(about, shortest)
         return
      case (TOP)
         call sum_series(3, self%order, s, self%omega, momentum)
         momentum = self%momentum + self%inertia*momentum
         call sum_series(6, self%order, s, self%lanes_1, values)
         rows(:, 1) = self%frame(:, 1) + values(1, :)
         rows(:, 2) = self%frame(:, 2) + values(2, :)
         rows(:, 3) = cross(rows(:, 1), rows(:, 2))
      case default
         call sum_series(6, self%order, s, self%lanes_1, values)
         momentum = self%momentum + values(1, :)
         rows(:, 1) = self%frame(:, 1) + values(2, :)
         if (self%equations == ONE_PAIR) then
            rows(:, 2) = momentum/length_of(momentum)
            rows(:, 1) = rows(:, 1) - dot_product(rows(:, 1), rows(:, 2))*rows(:, 2)
            rows(:, 1) = rows(:, 1)/length_of(rows(:, 1))
            rows(:, 3) = cross(rows(:, 1), rows(:, 2))
         else
            call sum_series(6, self%order, s, self%lanes_2, values)
            rows(:, 2) = self%frame(:, 2) + values(1, :)
            rows(:, 3) = self%frame(:, 3) + values(2, :)
         end if
      end select
      rotation = rotation_between(self%frame, rows)
   end subroutine evaluate

   !> Σ xₖ sᵏ from k = 1 on; even and odd powers apart, which halves the chain.
   pure subroutine sum_series(n, order, s, x, total)
      !> Number of series, and their highest coefficient.
      integer, intent(in) :: n, order
      real(wp), intent(in) :: s
      real(wp), intent(in) :: x(n, 0:highest_order)
      real(wp), intent(out) :: total(n)
      real(wp) :: even(most_series), square
      integer :: k, last
      square = s*s
      last = 2*((order - 1)/2)
      total = x(:, last + 1)
      even(1:n) = 0.0_wp
      if (order > last + 1) even(1:n) = x(:, order)
      do k = last, 2, -2
         total = total*square + x(:, k - 1)
         even(1:n) = even(1:n)*square + x(:, k)
      end do
      total = s*(total + s*even(1:n))
   end subroutine sum_series

   !> The quaternion c, to be normalised, with R(c) gᵢ = fᵢ for two frames, right-handed and orthonormal but for errors:
   !> 4cᵢcⱼ are linear in Σ fᵢgᵢᵀ; the row with the largest diagonal is taken.
   pure function rotation_between(f, g) result(c)
      !> Columns; shape (3,3).
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

   !> Size of a coefficient as an angle, squared: |Lₖ|²/scale² + ½Σ|Eₖ|², or θₖ² in the place of the rows.
   pure real(wp) function size_of(self, k, inverse_square) result(square)
      class(motion_series_t), intent(in) :: self
      integer, intent(in) :: k
      !> 1/scale² of the momentum.
      real(wp), intent(in) :: inverse_square
      select case (self%equations)
      case (FREE_BODY)
         square = self%angle(k)**2
      case (ONE_PAIR)
         square = sum(self%lanes_1(2, :, k)**2)
      case (TOP)
         square = 0.5_wp*sum(self%lanes_1(:, :, k)**2)
      case default
         square = 0.5_wp*(sum(self%lanes_1(2, :, k)**2) + sum(self%lanes_2(:, :, k)**2))
      end select
      square = square + inverse_square*self%momentum_square(k)
   end function size_of

   !> |Lₖ|², (N m s)².
   pure real(wp) function momentum_square(self, k) result(square)
      class(motion_series_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp) :: term(3)
      if (self%equations == TOP .or. self%equations == FREE_BODY) then
         term = self%inertia*self%omega(:, k)
      else
         term = self%lanes_1(1, :, k)
      end if
      square = term(1)*term(1) + term(2)*term(2) + term(3)*term(3)
   end function momentum_square

end module nutate_motion_series
