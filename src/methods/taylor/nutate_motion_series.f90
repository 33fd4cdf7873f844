!> The motion of a rigid body as power series in time: body momentum, and directions fixed in space, in body axes.
!>
!>     L̇ = L×Ω + τ,   Ė = E×Ω,   Ω = J⁻¹(L - h),   E = R(q)ᵀe
!>
!> Everything rotates against the body alike, so that L and the rows E are lanes of one product with Ω: two lanes make a
!> pair, as many as a vector instruction takes at a time. Three rows are the attitude, and cost less than the series of
!> q; without torque L is one of them, another follows, and one pair does. A free body and a top of diagonal inertia
!> have series of their own (`nutate_diagonal_series`).
!>
!> If the space axes rotate at ω, E is fixed in them: `Ė = E×(Ω - Rᵀω)`, and Rᵀω is a sum of the three rows with
!> constant weights, so that `E×Rᵀω` needs no products. Tops have a series of their own; tops that do not depend on ω
!> move as in fixed axes.
!>
!> If body and effects are symmetric about an axis, all is computed in a frame that does not spin with the body
!> (`nutate_axial_frame`): L/J₁ replaces Ω, and the angle of the body in that frame is one more series.
module nutate_motion_series
   use nutate_axial_frame, only: axial_frame_t
   use nutate_diagonal_series, only: expand_axial_top, expand_free, expand_top, steepest_growth
   use nutate_effect_list, only: effect_list_t
   use nutate_invariants, only: follows_rotating_axes
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order, inverses
   use nutate_quaternion, only: cross, quat_product, rotate_to_body
   use nutate_series_sum, only: length_of, rotation_between, sum_series
   use nutate_series_tail, only: most_parts, series_tail_t
   use nutate_system, only: system_t
   use nutate_torque_series, only: torque_series_t
   use nutate_rotating_top_series, only: expand_rotating_axial_top, expand_rotating_top
   use nutate_wheel_series, only: wheel_series_t
   implicit none
   private

   public :: motion_series_t, least_share, TWO_PAIRS

   !> The equations used: L and three rows; L and one; a top; a free body; the latter two in the axial frame.
   integer, parameter :: TWO_PAIRS = 1, ONE_PAIR = 2, TOP = 3, FREE_BODY = 4, AXIAL_TOP = 5, AXIAL_FREE = 6
   !> The momentum is a row of the attitude where it is at least this part of a rotor's: rounding, which depends on the
   !> larger of the two, then leaves its direction to 100ε.
   real(wp), parameter :: least_share = 1e-2_wp

   !> Series of one step.
   type :: motion_series_t
      !> Highest coefficient, to be set.
      integer :: order = 0
      !> Start and unit of time, s, to be set; the latter is negative backwards in time.
      real(wp) :: t = 0.0_wp, time_unit = 1.0_wp
      !> Rate of the axes used, Ω or L/J₁, times the unit of time; shape (3, 0:highest_order).
      real(wp) :: omega(3, 0:highest_order) = 0.0_wp
      type(torque_series_t) :: torques
      !> Remainder of the series after the highest coefficient.
      type(series_tail_t) :: tail
      !> The momenta of the wheels, where there are any.
      type(wheel_series_t), allocatable :: wheels
      !> Equations of the system, and of the present series: `TWO_PAIRS`, ...
      integer :: best = TWO_PAIRS, equations = TWO_PAIRS
      !> Lanes (L, E1) and (E2, E3), or (E1, E2) for a top; body axes; shape (2, 3, 0:highest_order).
      real(wp) :: lanes_1(2, 3, 0:highest_order) = 0.0_wp, lanes_2(2, 3, 0:highest_order) = 0.0_wp
      !> Angle about the momentum of a free body, or of the body in the axial frame, rad; shape (0:highest_order).
      real(wp), private :: angle(0:highest_order) = 0.0_wp
      !> The axial frame, if there is one. The axis of a top comes last: `places` are the indices of the components in
      !> the body.
      type(axial_frame_t) :: axial
      !> The rows rotate in space; components of their rate along them, rad/s; shape (3).
      logical, private :: frame_turns = .false.
      real(wp), private :: frame_rate(3) = 0.0_wp
      !> Direction of the potential of a top in rotating axes, along the first two rows; shape (2).
      real(wp), private :: field(2) = 0.0_wp
      integer, private :: places(3) = [1, 2, 3]
      !> L at the start, N m s, and diagonal moments over the unit of time, shape (3); 1 over the |L| of errors.
      real(wp) :: momentum(3) = 0.0_wp, inertia(3) = 0.0_wp, scale = 0.0_wp
      !> The rows at the start; second, of one pair, and of a free body the only one: L/|L|; shape (3,3).
      real(wp) :: frame(3, 3) = 0.0_wp
   contains
      !> Finds out which equations do.
      procedure :: prepare
      !> Computes the coefficients.
      procedure :: expand
      !> Momentum and rotation at a time.
      procedure :: evaluate
      !> Fits the tail.
      procedure :: fit_tail
      !> Largest turn of the axes used that a step can tell.
      procedure :: largest_turn
      !> The equations are those of an axial top.
      procedure :: is_axial_top
   end type motion_series_t

contains

   !> Finds out which equations do for a system, whose torques and wheels are prepared.
   pure subroutine prepare(self, system, attitude)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> The attitude is wanted.
      logical, intent(in) :: attitude
      logical :: diagonal
      associate (j => system%body%inverse_inertia)
         diagonal = .not. any(abs([j(2, 1), j(3, 1), j(3, 2), system%effects%rotor_momentum]) > 0.0_wp)
      end associate
      call self%axial%recognise(system)
      self%frame_turns = system%effects%frame_turns .and. (self%torques%has_more .or. self%torques%rank > 0) .and. &
                         .not. follows_rotating_axes(system%effects)
      call choose_equations(self, diagonal, attitude)
      if (self%frame_turns .and. (self%best == TOP .or. self%best == AXIAL_TOP)) &
         call self%torques%turn_basis(system%effects%frame_rate, self%field)
      self%frame_rate = matmul(system%effects%frame_rate, self%torques%basis)
      self%places = 1 + modulo(self%axial%axis + [0, 1, 2], 3)
   end subroutine prepare

   !> The fewest equations that do.
   pure subroutine choose_equations(self, diagonal, attitude)
      class(motion_series_t), intent(inout) :: self
      !> J is diagonal and there are no rotors; the attitude is wanted.
      logical, intent(in) :: diagonal, attitude
      self%best = TWO_PAIRS
      if (allocated(self%wheels)) return
      if (.not. self%torques%has_more .and. self%torques%rank == 0) then
         self%best = ONE_PAIR
         if (diagonal) self%best = FREE_BODY
         if (self%axial%axis > 0) self%best = AXIAL_FREE
      else if (.not. self%torques%has_more .and. self%torques%n_moments == 1 .and. &
               (diagonal .or. self%axial%axis > 0) .and. (self%torques%rank == 1 .or. .not. self%frame_turns)) then
         self%best = merge(AXIAL_TOP, TOP, self%axial%axis > 0)
      else if (.not. attitude .and. self%torques%rank < 2 .and. .not. self%frame_turns) then
         self%best = ONE_PAIR
      end if
   end subroutine choose_equations

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
      select case (self%equations)
      case (TWO_PAIRS, ONE_PAIR)
         call expand_pairs(self, system, acts, converges)
         return
      case (AXIAL_TOP, AXIAL_FREE)
         call expand_axial(self, converges)
         return
      case default
         continue
      end select
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
         if (self%frame_turns) then
            call expand_rotating_top(self%order, c, moments, self%field, self%time_unit*self%frame_rate(1), &
               self%omega, &
                                    self%lanes_1, converges)
         else
            call expand_top(self%order, c, moments, self%omega, self%lanes_1, converges)
         end if
      else
         call expand_free(self%order, c, self%inertia/length_of(momentum), self%frame(:, 2), self%omega, self%angle, &
                          converges)
      end if
   end subroutine expand

   !> Symmetric tops and free bodies in the axial frame, where only the directions of L and of the axis change.
   pure subroutine expand_axial(self, converges)
      class(motion_series_t), intent(inout) :: self
      logical, intent(out) :: converges
      real(wp) :: rate, g
      integer :: axis, k
      axis = self%axial%axis
      rate = self%time_unit*self%axial%inverse_across
      self%angle = 0.0_wp
      self%angle(1) = self%time_unit*self%axial%spin(self%momentum(axis))
      self%momentum = self%momentum(self%places)
      self%omega(:, 0) = rate*self%momentum
      self%inertia = 1/rate
      converges = maxval(abs(self%omega(:, 0))) <= steepest_growth
      if (.not. converges .or. self%equations == AXIAL_FREE) return
      do k = 1, 3
         self%frame(:, k) = self%frame(self%places, k)
      end do
      self%lanes_1(1, :, 0) = self%frame(:, 1)
      self%lanes_1(2, :, 0) = self%frame(:, 2)
      g = rate*(self%time_unit*self%torques%moments(axis, 1))
      if (self%frame_turns) then
         call expand_rotating_axial_top(self%order, g*self%field, self%time_unit*self%frame_rate(1), self%omega, &
                                       self%lanes_1, converges)
      else
         call expand_axial_top(self%order, g, self%omega, self%lanes_1, converges)
      end if
   end subroutine expand_axial

   !> The rows at the start: of the basis of the directions; without torque a vector across L, and L.
   pure subroutine choose_frame(self, system, q)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: q(4)
      real(wp) :: length, across(3)
      integer :: i
      self%equations = self%best
      associate (torques => self%torques, f => self%frame)
         if (torques%has_more .or. torques%rank > 0 .or. allocated(self%wheels)) then
            do i = 1, 3
               f(:, i) = rotate_to_body(q, torques%basis(:, i))
            end do
            return
         end if
         if (self%best == AXIAL_FREE) return
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

   !> Momentum and rows as pairs of lanes.
   pure subroutine expand_pairs(self, system, acts, converges)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      logical, intent(in) :: acts(:)
      logical, intent(out) :: converges
      real(wp), dimension(2, 3) :: a, b, sums_a, sums_b
      real(wp) :: to_omega(3, 3), moments(3, 3), w(3), omega(3), tau(3), turn(3), transport(3, 3), bound, across
      logical :: two
      integer :: k
      to_omega = self%time_unit*system%body%inverse_inertia
      across = self%time_unit*self%axial%inverse_across
      moments = self%time_unit*self%torques%moments
      two = self%equations == TWO_PAIRS
      turn = self%time_unit*self%frame_rate
      a(1, :) = self%momentum
      a(2, :) = self%frame(:, 1)
      b(1, :) = self%frame(:, 2)
      b(2, :) = self%frame(:, 3)
      w = self%momentum - system%effects%rotor_momentum
      if (allocated(self%wheels)) call self%wheels%start(self%torques%start, self%time_unit)
      bound = steepest_growth
      converges = max(maxval(abs(turn)), abs(self%time_unit)*self%torques%pace) <= bound
      if (.not. converges) return
      do k = 0, self%order
         self%lanes_1(:, :, k) = a
         self%lanes_2(:, :, k) = b
         if (allocated(self%wheels)) w = w - self%wheels%term(k)
         w = to_omega(:, 1)*w(1) + to_omega(:, 2)*w(2) + to_omega(:, 3)*w(3)
         omega = w
         if (allocated(self%wheels)) call self%wheels%add_term(system%effects, k, omega/self%time_unit)
         if (self%axial%axis > 0) then
            w = across*a(1, :)
            if (k < self%order) self%angle(k + 1) = inverses(k + 1)*(omega(self%axial%axis) - w(self%axial%axis))
         end if
         self%omega(:, k) = w
         converges = max(abs(w(1)), abs(w(2)), abs(w(3))) <= bound
         if (.not. converges .or. k == self%order) return
         bound = bound*steepest_growth
         tau = 0.0_wp
         if (self%frame_turns) call see_from_frame(turn, a, b, omega, transport)
         if (self%torques%n_moments > 0 .or. self%torques%has_more) &
            call add_torque(self, system%effects, k, acts, moments, omega, tau)
         call add_inner(k, self%lanes_1, self%omega, sums_a)
         if (two) call add_inner(k, self%lanes_2, self%omega, sums_b)
         call add_outer(k, self%lanes_1(:, :, 0), a, self%omega(:, 0), w, sums_a)
         w = inverses(k + 1)*(sums_a(1, :) + tau)
         a(1, :) = w
         a(2, :) = inverses(k + 1)*sums_a(2, :)
         if (.not. two) b = 0.0_wp
         if (.not. two) cycle
         call add_outer(k, self%lanes_2(:, :, 0), b, self%omega(:, 0), self%omega(:, k), sums_b)
         b = inverses(k + 1)*sums_b
         if (.not. self%frame_turns) cycle
         a(2, :) = a(2, :) + inverses(k + 1)*transport(1, :)
         b = b + inverses(k + 1)*transport(2:3, :)
      end do
   end subroutine expand_pairs

   !> Adds coefficient k of the torque times the unit of time.
   pure subroutine add_torque(self, effects, k, acts, moments, omega, tau)
      class(motion_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: k
      logical, intent(in) :: acts(:)
      !> Moments of the linear potentials, times the unit of time.
      real(wp), intent(in) :: moments(3, 3)
      !> Ω times the unit of time.
      real(wp), intent(in) :: omega(3)
      real(wp), intent(inout) :: tau(3)
      real(wp) :: rows(3, 3), more(3)
      integer :: i
      rows(:, 1) = self%lanes_1(2, :, k)
      rows(:, 2) = self%lanes_2(1, :, k)
      rows(:, 3) = self%lanes_2(2, :, k)
      do i = 1, self%torques%n_moments
         tau = tau + cross(moments(:, i), rows(:, i))
      end do
      if (.not. self%torques%has_more) return
      more = 0.0_wp
      call self%torques%add_terms(effects, k, self%torques%start, self%time_unit, acts, omega/self%time_unit, rows, &
                                  more)
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
      !> nothing; of length zero where the momentum has no direction that it needs.
      real(wp), intent(out) :: rotation(4)
      real(wp) :: rotated(1), weights(2), own(3), c(4)
      call self%tail%weights(self%order, s, weights(1), weights(2))
      call evaluate_frame(self, s, weights, momentum, rotation)
      if (self%axial%axis == 0) return
      if (self%equations == AXIAL_TOP .or. self%equations == AXIAL_FREE) then
         own = momentum
         c = rotation
         momentum(self%places) = own
         rotation(1 + self%places) = c(2:4)
         rotated = s*self%angle(1)
      else
         call sum_series(1, self%order, s, self%angle, weights, rotated)
      end if
      momentum = self%axial%to_body(rotated(1), momentum)
      rotation = self%axial%turn(rotated(1), rotation)
   end subroutine evaluate

   !> Momentum and rotation of the axes used.
   pure subroutine evaluate_frame(self, s, weights, momentum, rotation)
      class(motion_series_t), intent(in) :: self
      !> s, and of the last two coefficients in the tail; shape (2).
      real(wp), intent(in) :: s, weights(2)
      real(wp), intent(out) :: momentum(3), rotation(4)
      real(wp) :: values(2, 3), rows(3, 3), angle(1), axis(3), along(3), shortest(4), about(4), length
      select case (self%equations)
      case (AXIAL_FREE)
         momentum = self%momentum
         angle = length_of(self%omega(:, 0))
         rotation = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         if (angle(1) > tiny(1.0_wp)) rotation = [cos(0.5_wp*s*angle(1)), &
                                                  (sin(0.5_wp*s*angle(1))/angle(1))*self%omega(:, 0)]
         return
      case (FREE_BODY)
         call sum_series(3, self%order, s, self%omega, weights, momentum)
         momentum = self%momentum + self%inertia*momentum
         call sum_series(1, self%order, s, self%angle, weights, angle)
         axis = self%frame(:, 2)
         along = momentum/length_of(momentum)
         shortest(1) = 1 + (along(1)*axis(1) + along(2)*axis(2) + along(3)*axis(3))
         shortest(2:4) = cross(along, axis)
         about(1) = cos(0.5_wp*angle(1))
         about(2:4) = sin(0.5_wp*angle(1))*axis
         rotation = quat_product(about, shortest)
         return
      case (TOP, AXIAL_TOP)
         call sum_series(3, self%order, s, self%omega, weights, momentum)
         momentum = self%momentum + self%inertia*momentum
         call sum_series(6, self%order, s, self%lanes_1, weights, values)
         rows(:, 1) = self%frame(:, 1) + values(1, :)
         rows(:, 2) = self%frame(:, 2) + values(2, :)
         rows(:, 3) = cross(rows(:, 1), rows(:, 2))
      case default
         call sum_series(6, self%order, s, self%lanes_1, weights, values)
         momentum = self%momentum + values(1, :)
         rows(:, 1) = self%frame(:, 1) + values(2, :)
         if (self%equations == ONE_PAIR) then
            ! Without a length there is no direction: a rotation of length zero, which is no attitude.
            rotation = 0.0_wp
            length = length_of(momentum)
            if (.not. length > tiny(1.0_wp)) return
            rows(:, 2) = momentum/length
            rows(:, 1) = rows(:, 1) - dot_product(rows(:, 1), rows(:, 2))*rows(:, 2)
            length = length_of(rows(:, 1))
            if (.not. length > tiny(1.0_wp)) return
            rows(:, 1) = rows(:, 1)/length
            rows(:, 3) = cross(rows(:, 1), rows(:, 2))
         else
            call sum_series(6, self%order, s, self%lanes_2, weights, values)
            rows(:, 2) = self%frame(:, 2) + values(1, :)
            rows(:, 3) = self%frame(:, 3) + values(2, :)
         end if
      end select
      rotation = rotation_between(self%frame, rows)
   end subroutine evaluate_frame

   !> Returns the largest rotation of the axes used in a step, rad: rows determine a rotation up to its sign, which is
   !> lost at π. The rotation of a free body is an angle; in the axial frame there is a closed solution.
   pure real(wp) function largest_turn(self)
      class(motion_series_t), intent(in) :: self
      select case (self%equations)
      case (FREE_BODY)
         largest_turn = 12.0_wp
      case (AXIAL_FREE)
         largest_turn = 200.0_wp
      case default
         largest_turn = 3.0_wp
      end select
   end function largest_turn

   !> True for a top in the axial frame, whose coefficients cost least.
   pure logical function is_axial_top(self)
      class(motion_series_t), intent(in) :: self
      is_axial_top = self%best == AXIAL_TOP
   end function is_axial_top

   !> Fits the tail. Sizes are angles: |x|² = |L|²/scale² + ½Σ|E|², or θ² in the place of the rows.
   pure subroutine fit_tail(self)
      class(motion_series_t), intent(inout) :: self
      real(wp) :: x(most_parts, 4)
      integer :: k, n
      if (self%equations == AXIAL_FREE) then
         call self%tail%leave()
         return
      end if
      self%scale = 0.0_wp
      do k = 0, 2
         self%scale = max(self%scale, momentum_square(self, k))
      end do
      if (self%scale > tiny(1.0_wp)) self%scale = 1/sqrt(self%scale)
      do k = 1, 4
         call get_parts(self, self%order + 1 - k, self%scale, x(:, k), n)
      end do
      call self%tail%fit(n, x)
   end subroutine fit_tail

   !> The components of a coefficient, as angles.
   pure subroutine get_parts(self, k, scale, x, n)
      class(motion_series_t), intent(in) :: self
      integer, intent(in) :: k
      !> 1 over the size of L, (N m s)⁻¹.
      real(wp), intent(in) :: scale
      !> Shape (most_parts), of which the first n are set.
      real(wp), intent(inout) :: x(most_parts)
      integer, intent(out) :: n
      real(wp), parameter :: root_half = sqrt(0.5_wp)
      select case (self%equations)
      case (FREE_BODY)
         n = 4
         x(1:3) = (scale*self%inertia)*self%omega(:, k)
         x(4) = self%angle(k)
      case (TOP, AXIAL_TOP)
         n = 9
         x(1:3) = (scale*self%inertia)*self%omega(:, k)
         x(4:6) = root_half*self%lanes_1(1, :, k)
         x(7:9) = root_half*self%lanes_1(2, :, k)
      case default
         n = 6
         x(1:3) = scale*self%lanes_1(1, :, k)
         x(4:6) = root_half*self%lanes_1(2, :, k)
         if (self%equations == TWO_PAIRS) then
            n = 12
            x(7:9) = root_half*self%lanes_2(1, :, k)
            x(10:12) = root_half*self%lanes_2(2, :, k)
         end if
         if (self%axial%axis > 0) then
            n = n + 1
            x(n) = self%angle(k)
         end if
      end select
   end subroutine get_parts

   !> |Lₖ|², (N m s)².
   pure real(wp) function momentum_square(self, k) result(square)
      class(motion_series_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp) :: term(3)
      if (self%equations == TOP .or. self%equations == FREE_BODY .or. self%equations == AXIAL_TOP) then
         term = self%inertia*self%omega(:, k)
      else
         term = self%lanes_1(1, :, k)
      end if
      square = term(1)*term(1) + term(2)*term(2) + term(3)*term(3)
   end function momentum_square

   !> Coefficient k as space axes that turn have it: of Ω less Rᵀω = Σ ωᵢEᵢ, and -E×Rᵀω of the three rows.
   pure subroutine see_from_frame(turn, a, b, omega, transport)
      !> ω along the rows, times the unit of time; shape (3).
      real(wp), intent(in) :: turn(3)
      !> Coefficient k of the lanes (L, E1) and (E2, E3).
      real(wp), intent(in) :: a(2, 3), b(2, 3)
      !> Times the unit of time; shape (3).
      real(wp), intent(inout) :: omega(3)
      !> One row each; shape (3,3).
      real(wp), intent(out) :: transport(3, 3)
      omega = omega - (turn(1)*a(2, :) + turn(2)*b(1, :) + turn(3)*b(2, :))
      transport(1, :) = turn(3)*b(1, :) - turn(2)*b(2, :)
      transport(2, :) = turn(1)*b(2, :) - turn(3)*a(2, :)
      transport(3, :) = turn(2)*a(2, :) - turn(1)*b(1, :)
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

end module nutate_motion_series
