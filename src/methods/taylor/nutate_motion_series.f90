!> The motion of a rigid body as power series in time, by the fewest equations that suffice: the four lanes of
!> `nutate_row_series`, the rotation and L if no torque depends on the attitude, two rows for symmetric tops, Euler's
!> equations for free bodies and gyrostats of diagonal inertia, or the closed form for symmetric free bodies.
module nutate_motion_series
   use nutate_invariants, only: follows_rotating_axes
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order, inverses
   use nutate_quaternion, only: cross, quat_product, rotate_to_body
   use nutate_row_series, only: row_series_t, steepest_growth
   use nutate_rows_avx2, only: expand_avx2 => expand_rows, multiply_avx2 => multiply_last, sum_avx2 => sum_rows, &
      top_avx2 => expand_axial_top, free_avx2 => expand_free, four_avx2 => sum_four
   use nutate_rows_sse2, only: expand_sse2 => expand_rows, multiply_sse2 => multiply_last, sum_sse2 => sum_rows, &
      top_sse2 => expand_axial_top, free_sse2 => expand_free, four_sse2 => sum_four
   use nutate_series_sum, only: length_of, rotation_between
   use nutate_series_tail, only: add_products, most_parts, series_tail_t
   use nutate_simd, only: has_avx2
   use nutate_system, only: inverse_inertia_at, system_t
   implicit none
   private

   public :: motion_series_t, ROWS, FREE_BODY, AXIAL_TOP, NO_ROWS

   !> The equations used: L and three rows; a free body; a free body, and a top, in the axial frame; L and the rotation
   !> since the start.
   integer, parameter :: ROWS = 1, FREE_BODY = 2, AXIAL_FREE = 3, AXIAL_TOP = 4, NO_ROWS = 5

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

   !> Estimate of a rotation, by three coefficients of its rate, up to which it is less than π, rad.
   real(wp), parameter :: certain_turn = 2.6_wp

   !> Series of one step.
   type, extends(row_series_t) :: motion_series_t
      !> Remainder of the series after the highest coefficient.
      type(series_tail_t) :: tail
      !> Equations of the system, and of the present series: `ROWS`, ...
      integer :: best = ROWS, equations = ROWS
      !> True if the processor has AVX2.
      logical, private :: avx2 = .false.
      !> L at the start, N m s, and diagonal moments over the unit of time, shape (3); 1 over the |L| of errors.
      real(wp) :: momentum(3) = 0.0_wp, inertia(3) = 0.0_wp, scale = 0.0_wp
      !> Largest principal moment, kg m², if torques or wheels do work: no energy then holds the momentum along an axis
      !> whose moment is small, and errors of Ω are held to the tolerance, too; else 0.
      real(wp), private :: largest_moment = 0.0_wp
      !> Ω times the unit of time, and the angle about L, rad, of a body without torques; shape (4, 0:highest_order).
      real(wp), private :: free(4, 0:highest_order) = 0.0_wp
      !> The rows at the start, and of a free body only the second: L/|L|; shape (3,3).
      real(wp) :: frame(3, 3) = 0.0_wp
   contains
      !> Determines which equations suffice.
      procedure :: prepare
      !> Computes the coefficients.
      procedure :: expand
      !> Computes the changes of the lanes up to a time.
      procedure :: get_changes
      !> Computes momentum and rotation at a time.
      procedure :: evaluate
      !> Fits the tail.
      procedure :: fit_tail
      !> Returns true if a rotation since the start needs the other sign.
      procedure :: is_opposite
      !> Returns the largest rotation of the axes used that a step can follow.
      procedure :: largest_turn
   end type motion_series_t

contains

   !> Determines which equations suffice for a system, whose torques and wheels are prepared.
   subroutine prepare(self, system)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      logical :: diagonal, is_free
      associate (j => system%body%inverse_inertia)
         diagonal = .not. any(abs([j(2, 1), j(3, 1), j(3, 2)]) > 0.0_wp)
      end associate
      self%avx2 = has_avx2()
      self%lanes = 0.0_wp
      self%angle = 0.0_wp
      call self%axial%recognise(system)
      is_free = .not. (self%torques%has_more .or. self%torques%rank > 0 .or. allocated(self%wheels))
      self%best = ROWS
      if (is_free .and. diagonal) self%best = FREE_BODY
      if (is_free .and. self%axial%axis > 0) self%best = AXIAL_FREE
      self%frame_turns = system%effects%frame_turns .and. (self%torques%has_more .or. self%torques%rank > 0) .and. &
                         .not. follows_rotating_axes(system%effects)
      if (self%axial%axis > 0 .and. self%torques%n_moments == 1 .and. .not. (self%torques%has_more .or. &
                                                                            self%frame_turns)) self%best = AXIAL_TOP
      self%frame_rate = matmul(system%effects%frame_rate, self%torques%basis)
      self%asks_no_effect = (self%torques%is_simple .or. .not. self%torques%has_more) .and. &
                            .not. (self%torques%varies .or. self%frame_turns .or. self%axial%axis > 0)
      if (allocated(self%wheels) .and. self%asks_no_effect) self%asks_no_effect = self%wheels%asks_no_effect
      self%largest_moment = 0.0_wp
      if (self%torques%n_lanes > 0 .or. allocated(self%wheels)) self%largest_moment = maxval(system%body%moments)
      self%by_rotation = self%best == ROWS .and. self%asks_no_effect .and. self%torques%n_moments == 0
      if (self%by_rotation) self%best = NO_ROWS
   end subroutine prepare

   !> Computes the coefficients from the values at the start.
   pure subroutine expand(self, system, acts, q, momentum, converges)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      !> The torque acts; shape (number of torques).
      logical, intent(in) :: acts(:)
      !> Attitude, body→space, and L, body axes, N m s; shapes (4), (3).
      real(wp), intent(in) :: q(4), momentum(3)
      !> False if the coefficients grow so fast that the unit of time is far too long.
      logical, intent(out) :: converges
      integer :: i
      self%momentum = momentum
      self%equations = self%best
      ! A body at rest has no direction of L, relative to which its attitude would be known; if rotors nearly cancel the
      ! momentum of the body, that direction is round-off.
      if (self%best == FREE_BODY .and. .not. length_of(momentum) > max( &
          tiny(1.0_wp), 0.5_wp*length_of(system%effects%rotor_momentum))) self%equations = ROWS
      select case (self%equations)
      case (FREE_BODY)
         call expand_euler(self, system, converges)
      case (AXIAL_FREE)
         self%angle(1) = self%time_unit*self%axial%spin(momentum(self%axial%axis))
         self%omega(:, 0) = (self%time_unit*self%axial%inverse_across)*momentum
         converges = maxval(abs(self%omega(:, 0))) <= steepest_growth
      case (NO_ROWS)
         self%lanes(:, 1, 0) = identity
         self%lanes(1:3, 2, 0) = momentum
         call expand_lanes(self, system, acts, converges)
      case default
         self%lanes(1, :, 0) = momentum
         do i = 1, 3
            self%frame(:, i) = rotate_to_body(q, self%torques%basis(:, i))
            self%lanes(1 + i, :, 0) = self%frame(:, i)
         end do
         if (self%equations == AXIAL_TOP .and. self%avx2) then
            call top_avx2(self%row_series_t, converges)
         else if (self%equations == AXIAL_TOP) then
            call top_sse2(self%row_series_t, converges)
         else if (system%effects%varies) then
            call expand_varying(self, system, acts, converges)
         else
            call expand_lanes(self, system, acts, converges)
         end if
      end select
   end subroutine expand

   !> Computes the coefficients with a constant inertia.
   pure subroutine expand_lanes(self, system, acts, converges)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      logical, intent(in) :: acts(:)
      logical, intent(out) :: converges
      if (self%avx2) then
         call expand_avx2(self%row_series_t, system%effects, acts, system%body%inverse_inertia, converges)
      else
         call expand_sse2(self%row_series_t, system%effects, acts, system%body%inverse_inertia, converges)
      end if
   end subroutine expand_lanes

   !> Computes the coefficients with an inertia that varies.
   pure subroutine expand_varying(self, system, acts, converges)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      logical, intent(in) :: acts(:)
      logical, intent(out) :: converges
      if (self%avx2) then
         call expand_avx2(self%row_series_t, system%effects, acts, inverse_inertia_at(system, self%t), converges)
      else
         call expand_sse2(self%row_series_t, system%effects, acts, inverse_inertia_at(system, self%t), converges)
      end if
      if (converges .and. self%frame_turns) call self%torques%add_transported_work(self%time_unit)
   end subroutine expand_varying

   !> Computes the coefficients of a free body or gyrostat of diagonal inertia.
   pure subroutine expand_euler(self, system, converges)
      class(motion_series_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      logical, intent(out) :: converges
      real(wp) :: length
      integer :: i
      length = length_of(self%momentum)
      self%frame(:, 2) = self%momentum/length
      associate (rotor => system%effects%rotor_momentum)
         do i = 1, 3
            self%inertia(i) = system%body%inertia(i, i)/self%time_unit
            self%omega(i, 0) = self%time_unit*system%body%inverse_inertia(i, i)*(self%momentum(i) - rotor(i))
         end do
         self%free(1:3, 0) = self%omega(:, 0)
         if (self%avx2) then
            call free_avx2(self%order, self%inertia, rotor, length, self%frame(:, 2), self%free, converges)
         else
            call free_sse2(self%order, self%inertia, rotor, length, self%frame(:, 2), self%free, converges)
         end if
      end associate
   end subroutine expand_euler

   !> Computes the changes of L, N m s, and of the rows, or of the rotation and of L, up to a time.
   pure subroutine get_changes(self, s, changes)
      class(motion_series_t), intent(in) :: self
      !> In units of time.
      real(wp), intent(in) :: s
      !> Shape (lane, component).
      real(wp), intent(out) :: changes(4, 3)
      real(wp) :: weights(2)
      call self%tail%weights(self%order, s, weights(1), weights(2))
      if (self%avx2) then
         call sum_avx2(self%order, s, self%lanes, weights, changes)
      else
         call sum_sse2(self%order, s, self%lanes, weights, changes)
      end if
   end subroutine get_changes

   !> Computes momentum, and rotation since the start, at a time from the start.
   pure subroutine evaluate(self, s, momentum, rotation)
      class(motion_series_t), intent(in) :: self
      !> In units of time.
      real(wp), intent(in) :: s
      !> L, body axes, N m s; shape (3).
      real(wp), intent(out) :: momentum(3)
      !> Quaternion c, not normalised: the attitude is that of the start times c; shape (4).
      real(wp), intent(out) :: rotation(4)
      real(wp) :: angle, power_sum, weights(2), changes(4, 3), rows(3, 3)
      integer :: i
      select case (self%equations)
      case (FREE_BODY)
         call evaluate_free(self, s, momentum, rotation)
         return
      case (AXIAL_FREE)
         momentum = self%momentum
         angle = length_of(self%omega(:, 0))
         rotation = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         if (angle > tiny(1.0_wp)) rotation = [cos(0.5_wp*s*angle), (sin(0.5_wp*s*angle)/angle)*self%omega(:, 0)]
         angle = s*self%angle(1)
      case (NO_ROWS)
         call self%get_changes(s, changes)
         momentum = self%momentum + changes(1:3, 2)
         rotation = identity + changes(:, 1)
         return
      case default
         call self%get_changes(s, changes)
         momentum = self%momentum + changes(1, :)
         do i = 1, 3
            rows(:, i) = self%frame(:, i) + changes(1 + i, :)
         end do
         if (self%equations == AXIAL_TOP) rows(:, 3) = cross(rows(:, 1), rows(:, 2))
         rotation = rotation_between(self%frame, rows)
         if (self%is_opposite(s, rotation)) rotation = -rotation
         if (self%axial%axis == 0) return
         if (self%equations == AXIAL_TOP) then
            angle = s*self%angle(1)
         else
            call self%tail%weights(self%order, s, weights(1), weights(2))
            power_sum = 0.0_wp
            angle = weights(1)*self%angle(self%order) + weights(2)*self%angle(self%order - 1)
            do i = 0, self%order - 1
               power_sum = s*(power_sum + self%angle(self%order - i))
            end do
            angle = angle + power_sum
         end if
      end select
      momentum = self%axial%to_body(angle, momentum)
      rotation = self%axial%turn(angle, rotation)
   end subroutine evaluate

   !> Computes momentum and rotation of a free body.
   pure subroutine evaluate_free(self, s, momentum, rotation)
      class(motion_series_t), intent(in) :: self
      real(wp), intent(in) :: s
      real(wp), intent(out) :: momentum(3), rotation(4)
      real(wp) :: weights(2), change(4), axis(3), along(3), shortest(4), about(4)
      call self%tail%weights(self%order, s, weights(1), weights(2))
      if (self%avx2) then
         call four_avx2(self%order, s, self%free, weights, change)
      else
         call four_sse2(self%order, s, self%free, weights, change)
      end if
      momentum = self%momentum + self%inertia*change(1:3)
      axis = self%frame(:, 2)
      along = momentum/length_of(momentum)
      shortest(1) = 1 + (along(1)*axis(1) + along(2)*axis(2) + along(3)*axis(3))
      shortest(2:4) = cross(along, axis)
      about(1) = cos(0.5_wp*change(4))
      about(2:4) = sin(0.5_wp*change(4))*axis
      rotation = quat_product(about, shortest)
   end subroutine evaluate_free

   !> Returns true if the quaternion of a rotation since the start of the series needs the other sign to follow from the
   !> identity continuously. The rows do not determine the sign: from π on it is not that of the shortest rotation. If
   !> the rotation may be as large, it is compared with exp(½∫w dt), the first term of its Magnus series, whose error is
   !> far less than the π between the two signs.
   pure logical function is_opposite(self, s, rotation)
      class(motion_series_t), intent(in) :: self
      !> Time, in units; quaternion of the shortest rotation.
      real(wp), intent(in) :: s, rotation(4)
      real(wp) :: turn(3), angle
      integer :: k
      angle = s*(length_of(turn_term(self, 0)) + s*(length_of(turn_term(self, 1))/2 &
                                                    + s*length_of(turn_term(self, 2))/3))
      is_opposite = .false.
      if (angle < certain_turn) return
      turn = 0.0_wp
      do k = self%order - 1, 0, -1
         turn = s*(turn + inverses(k + 1)*turn_term(self, k))
      end do
      angle = length_of(turn)
      if (angle > 0.0_wp) is_opposite = cos(0.5_wp*angle)*rotation(1) + &
                                        (sin(0.5_wp*angle)/angle)*dot_product(turn, rotation(2:4)) < 0.0_wp
   end function is_opposite

   !> Returns coefficient k of the rate at which the rows rotate, times the unit of time; shape (3).
   pure function turn_term(self, k) result(rate)
      type(motion_series_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp) :: rate(3)
      integer :: i
      rate = self%omega(:, k)
      if (self%axial%axis > 0) rate = (self%time_unit*self%axial%inverse_across)*self%lanes(1, :, k)
      if (.not. self%frame_turns) return
      do i = 1, 3
         rate = rate - (self%time_unit*self%frame_rate(i))*self%lanes(1 + i, :, k)
      end do
   end function turn_term

   !> Returns the largest rotation of the axes used in a step, rad: rows determine a rotation up to its sign, which is
   !> lost at π. The rotation of a free body is an angle, or it is computed itself; in the axial frame there is a closed
   !> solution.
   pure real(wp) function largest_turn(self)
      class(motion_series_t), intent(in) :: self
      select case (self%equations)
      case (FREE_BODY)
         largest_turn = 12.0_wp
      case (AXIAL_FREE)
         largest_turn = 200.0_wp
      case (NO_ROWS)
         largest_turn = 12.0_wp
      case default
         largest_turn = 3.0_wp
      end select
   end function largest_turn

   !> Fits the tail. Sizes are angles: |x|² = |L|²/scale² + ½Σ|E|², or θ² or |2c|² in the place of the rows, and
   !> |Ω|² over that at the start if torques do work; in the axial frame the angle takes its place.
   pure subroutine fit_tail(self, reach)
      class(motion_series_t), intent(inout) :: self
      !> Time, in units of time, up to which terms of L count for its size: those of later times may be far larger.
      real(wp), intent(in) :: reach
      real(wp) :: x(most_parts, 4), squares(4), next(3), second(2), largest
      integer :: k, m
      if (self%equations == AXIAL_FREE) then
         call self%tail%leave()
         return
      end if
      self%scale = 0.0_wp
      do k = 0, 2
         self%scale = max(self%scale, reach**(2*k)*momentum_square(self, k))
      end do
      if (self%scale > tiny(1.0_wp)) self%scale = 1/sqrt(self%scale)
      if (self%equations == FREE_BODY) then
         do m = 1, 4
            k = self%order + 1 - m
            x(:, m) = [self%scale*self%inertia, 1.0_wp]*self%free(:, k)
         end do
         call self%tail%fit(4, x)
         return
      end if
      if (self%avx2) then
         call multiply_avx2(self%order, self%scale, self%by_rotation, self%lanes, squares, next, second, largest)
      else
         call multiply_sse2(self%order, self%scale, self%by_rotation, self%lanes, squares, next, second, largest)
      end if
      if (self%axial%axis > 0 .and. self%equations /= AXIAL_TOP) then
         x(1, :) = self%angle(self%order:self%order - 3:-1)
         call add_products(1, x, squares, next, second, largest)
      else if (self%largest_moment > 0.0_wp) then
         call get_rates(self, reach, x)
         call add_products(3, x, squares, next, second, largest)
      end if
      call self%tail%fit_products(squares, next, second, largest)
   end subroutine fit_tail

   !> Returns the last four coefficients of Ω, the last one first, over the largest of the first ones, or over |L| by
   !> the largest moment if that is more: wheels may hold most of L.
   pure subroutine get_rates(self, reach, x)
      class(motion_series_t), intent(in) :: self
      !> As in `fit_tail`.
      real(wp), intent(in) :: reach
      !> Shape (most_parts, 4).
      real(wp), intent(out) :: x(most_parts, 4)
      real(wp) :: size
      integer :: k, m
      size = 0.0_wp
      do k = 0, 2
         size = max(size, reach**k*maxval(abs(self%omega(:, k))))
      end do
      if (self%scale > tiny(1.0_wp)) size = max(size, abs(self%time_unit)/(self%scale*self%largest_moment))
      x = 0.0_wp
      if (.not. size > tiny(1.0_wp)) return
      do m = 1, 4
         x(1:3, m) = self%omega(:, self%order + 1 - m)/size
      end do
   end subroutine get_rates

   !> Returns |Lₖ|², (N m s)².
   pure real(wp) function momentum_square(self, k) result(square)
      class(motion_series_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp) :: term(3)
      if (self%equations == FREE_BODY) then
         term = self%inertia*self%free(1:3, k)
      else if (self%by_rotation) then
         term = self%lanes(1:3, 2, k)
      else
         term = self%lanes(1, :, k)
      end if
      square = term(1)*term(1) + term(2)*term(2) + term(3)*term(3)
   end function momentum_square

end module nutate_motion_series
