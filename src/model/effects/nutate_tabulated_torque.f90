!> A torque given by a table of times and components, along axes of the body or of space: straight lines or a spline
!> between the lines of the table; outside of it zero, or repeated periodically.
!>
!> Steps end on the times of the table, so that each has one polynomial and every method keeps its order.
module nutate_tabulated_torque
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, torque_t, SPACE_SERIES, TIME_SERIES
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t
   use nutate_finite, only: is_nan
   use nutate_keys, only: group_t
   use nutate_kinds, only: wp, eps
   use nutate_limits, only: is_moderate, in_words, least_step, greatest_number
   use nutate_piecewise, only: find_bounds, interval_at, least_periodic, move_inside, new_linear, new_spline, &
      piecewise_t, taylor_term, value_at
   use nutate_quaternion, only: rotate_to_body
   use nutate_small_products, only: skew
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: tabulated_torque_t, build_tabulated_torque, make_tabulated_torque, check_table, make_body_curve

   !> Least length of a period over the size of a time: shorter periods differ by rounding alone.
   real(wp), parameter :: least_round = 4*eps
   character(len=*), parameter :: three_numbers = 'a line of the table has a wrong length (expected three numbers)'

   !> τ(t) of a table; `make_tabulated_torque` makes one.
   type, extends(torque_t) :: tabulated_torque_t
      type(piecewise_t) :: curve
      !> True if the components are in space axes; else in body axes.
      logical :: in_space = .false.
      !> True if the table repeats after its end; else the torque is zero outside.
      logical :: periodic = .false.
      !> Start and stop of the torque, s.
      real(wp) :: start = -huge(1.0_wp), stop = huge(1.0_wp)
      !> Bounds of |τ|, |τ̇| and |τ̈|, N m over powers of s; shape (3).
      real(wp), private :: bounds(3) = 0.0_wp
   contains
      procedure :: torque => tabulated_torque
      procedure :: is_valid => table_is_valid
      procedure :: derivatives => tabulated_derivatives
      procedure :: window => tabulated_window
      procedure :: own_ends => tabulated_own_ends
      procedure :: piece => tabulated_piece
      procedure :: next_break => tabulated_break
      procedure :: needs_attitude => attitude_in_space
      procedure :: bound => tabulated_bound
      procedure :: time_derivative => tabulated_time_derivative
      procedure :: series_kind => tabulated_series
      procedure :: series_torque => tabulated_series_torque
   end type tabulated_torque_t

contains

   !> Builds a torque from a scene's group with a table. Errors: those of `make_tabulated_torque`; `NUTATE_BAD_ARGUMENT`
   !> for a key that belongs to a torque without table.
   subroutine build_tabulated_torque(group, body, effect, status)
      !> Group with its table.
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(tabulated_torque_t) :: torque
      character(len=9), parameter :: others(4) = [character(len=9) :: 'body', 'space', 'frequency', 'phase']
      integer :: i, at
      do i = 1, size(others)
         if (.not. group%has(trim(others(i)))) cycle
         status = fail(NUTATE_BAD_ARGUMENT, 'table and '//trim(others(i))//' exclude each other (expected one of '// &
                       'the two)', others(i))
         return
      end do
      if (.not. allocated(group%table)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the table has not been read', 'table')
         return
      end if
      associate (table => group%table)
         call make_tabulated_torque(table%numbers(1, :), table%numbers(2:4, :), torque, status, at, &
                                    spline=group%text('interpolation', 'linear') == 'cubic', &
                                    periodic=group%text('outside', 'zero') == 'periodic', &
                                    in_space=group%text('axes', 'body') == 'space', &
                                    start=group%number('start', -huge(1.0_wp)), stop=group%number('stop', huge(1.0_wp)))
      end associate
      if (status%ok()) allocate (effect, source=torque)
   end subroutine build_tabulated_torque

   !> Makes the curve of a table that belongs to the body (inertia, centre of mass) and contains t = 0. Errors: those of
   !> `check_table`; `NUTATE_BAD_ARGUMENT` for lines without three numbers, for times that repeat, and for a table that
   !> does not contain t = 0.
   subroutine make_body_curve(times, values, spline, of, key, curve, status, at)
      !> Times, s, and values; shapes (n), (3, n).
      real(wp), intent(in) :: times(:), values(:, :)
      !> A cubic spline, not straight lines.
      logical, intent(in) :: spline
      !> Subject of the table in messages, and the key that names the table.
      character(len=*), intent(in) :: of, key
      type(piecewise_t), intent(out) :: curve
      type(status_t), intent(out) :: status
      !> The line with the error, 1 to n; 0 for none.
      integer, intent(out) :: at
      integer :: i
      call check_table(times, values, spline, .false., at, status)
      if (size(values, 1) /= 3 .and. status%ok()) status = fail(NUTATE_BAD_ARGUMENT, three_numbers, key)
      do i = 2, size(times)
         if (.not. status%ok() .or. times(i) > times(i - 1)) cycle
         at = i
         status = fail(NUTATE_BAD_ARGUMENT, 'the time repeats that of the line before (expected increasing times)', key)
      end do
      if (.not. status%ok()) return
      if (.not. (times(1) <= 0.0_wp .and. times(size(times)) >= 0.0_wp)) then
         at = 1
         status = fail(NUTATE_BAD_ARGUMENT, 'the table of '//of//' lacks t = 0 (expected times from 0 on)', key)
      else if (spline) then
         curve = new_spline(times, values, .false.)
      else
         curve = new_linear(times, values)
      end if
   end subroutine make_body_curve

   !> Makes a torque that interpolates a table.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for numbers that are not finite or above 1e100, for times that do not increase (for
   !> linear interpolation two may be equal, which makes a jump) or are less than 1e-50 s apart, for too few of them,
   !> for more or fewer lines of values than times, for lines without three numbers, for a periodic spline whose last
   !> values differ from its first, and for an empty window.
   subroutine make_tabulated_torque(times, values, torque, status, at, spline, periodic, in_space, start, stop)
      !> Times, s; shape (n).
      real(wp), intent(in) :: times(:)
      !> Torques, N m; shape (3, n).
      real(wp), intent(in) :: values(:, :)
      type(tabulated_torque_t), intent(inout) :: torque
      type(status_t), intent(out) :: status
      !> The line with the error, 1 to n; 0 for none.
      integer, intent(out) :: at
      !> `spline`: a cubic spline, not linear interpolation; `periodic`: the table repeats, and is not zero outside of
      !> its times; `in_space`: the values are in space axes, not in body axes. Defaults `.false.`.
      logical, intent(in), optional :: spline, periodic, in_space
      !> The torque acts from `start` to `stop`, s; default: at all times.
      real(wp), intent(in), optional :: start, stop
      logical :: smooth
      torque%name = 'torque'
      smooth = .false.
      if (present(spline)) smooth = spline
      torque%periodic = .false.
      if (present(periodic)) torque%periodic = periodic
      torque%in_space = .false.
      if (present(in_space)) torque%in_space = in_space
      call check_table(times, values, smooth, torque%periodic, at, status)
      if (size(values, 1) /= 3 .and. status%ok()) status = fail(NUTATE_BAD_ARGUMENT, three_numbers, 'table')
      if (.not. status%ok()) return
      if (smooth) then
         torque%curve = new_spline(times, values, torque%periodic)
      else
         torque%curve = new_linear(times, values)
      end if
      call find_bounds(torque%curve, torque%bounds)
      torque%start = -huge(1.0_wp)
      if (present(start)) torque%start = start
      torque%stop = huge(1.0_wp)
      if (present(stop)) torque%stop = stop
      ! A NaN stays, and is rejected: MAX and MIN would drop it.
      if (.not. torque%periodic .and. torque%stop > torque%start) then
         torque%start = max(torque%start, times(1))
         torque%stop = min(torque%stop, times(size(times)))
      end if
      if (.not. torque%stop > torque%start) status = fail(NUTATE_BAD_ARGUMENT, 'the torque acts at no time of its '// &
                                                          'table (expected start < stop, inside of the table)', 'stop')
   end subroutine make_tabulated_torque

   !> Checks a table. Errors: `NUTATE_BAD_ARGUMENT` with the first line that is at fault.
   subroutine check_table(times, values, spline, periodic, at, status)
      real(wp), intent(in) :: times(:), values(:, :)
      logical, intent(in) :: spline, periodic
      integer, intent(out) :: at
      type(status_t), intent(out) :: status
      integer :: i, n
      n = size(times)
      at = 0
      if (size(values, 2) /= n) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the number of lines differs from that of the times '// &
                       '(expected one for each)', 'table')
         return
      end if
      do i = 1, n
         at = i
         if (.not. (is_moderate(times(i)) .and. all(is_moderate(values(:, i))))) then
            status = fail(NUTATE_BAD_ARGUMENT, 'a number is not finite or too large (expected up to '// &
                          in_words(greatest_number)//')', 'table')
            return
         else if (i > 1) then
            status = fault_of_time(times(max(1, i - 2):i), spline)
            if (.not. status%ok()) return
         end if
      end do
      at = n
      if (n < 2 .or. (spline .and. periodic .and. n < least_periodic)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the table is too short (expected '// &
                       trim(merge('four', 'two ', spline .and. periodic))//' lines of numbers, or more)', 'table')
      else if (.not. times(n) > times(1)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the table has one time only (expected two or more)', 'table')
      else if (spline .and. periodic .and. any(abs(values(:, n) - values(:, 1)) > 0.0_wp)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the last torque differs from the first (expected equal torques for a '// &
                       'periodic spline)', 'table')
      else
         at = 0
      end if
   end subroutine check_table

   !> Returns the error of a time after the one or two before it.
   pure type(status_t) function fault_of_time(times, spline) result(status)
      !> Time with the one or two before it, s; shape (2) or (3).
      real(wp), intent(in) :: times(:)
      logical, intent(in) :: spline
      real(wp) :: step
      integer :: n
      n = size(times)
      step = times(n) - times(n - 1)
      if (step < 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time decreases (expected increasing times)', 'table')
      else if (step >= least_step) then
         return
      else if (step > 0.0_wp) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time is too close to the one before (expected '// &
                       in_words(least_step)//' s or more)', 'table')
      else if (spline) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time repeats that of the line before (expected increasing times; '// &
                       "jumps need interpolation = 'linear')", 'table')
      else if (n > 2) then
         if (times(n - 1) <= times(1)) &
            status = fail(NUTATE_BAD_ARGUMENT, 'three lines have the same time (expected two, for a jump)', 'table')
      end if
   end function fault_of_time

   !> Finds the interval of a time, and that time in the first round of a periodic table.
   pure subroutine locate(self, t, k, time)
      class(tabulated_torque_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      integer, intent(out) :: k
      real(wp), intent(out) :: time
      time = t
      if (self%periodic) time = t - rounds_before(self, t)*period_of(self)
      k = interval_at(self%curve, time)
   end subroutine locate

   !> Returns how often a periodic table has been completed at a time: an integer.
   pure real(wp) function rounds_before(self, t) result(rounds)
      class(tabulated_torque_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: ratio
      ratio = (t - self%curve%x(0))/period_of(self)
      rounds = aint(ratio)
      if (ratio < rounds) rounds = rounds - 1
   end function rounds_before

   !> Returns the time from the first to the last line of the table, s.
   pure real(wp) function period_of(self) result(period)
      class(tabulated_torque_t), intent(in) :: self
      period = self%curve%x(self%curve%n) - self%curve%x(0)
   end function period_of

   !> Returns the interpolated torque, body axes, N m; shape (3).
   pure function tabulated_torque(self, t, q, omega) result(tau)
      class(tabulated_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      real(wp) :: time
      integer :: k
      call locate(self, t, k, time)
      tau = value_at(self%curve, k, time)
      if (self%in_space) tau = rotate_to_body(q, tau)
   end function tabulated_torque

   !> Computes ∂τ/∂θ (τ×θ for a table in space axes, else 0) and ∂τ/∂Ω = 0.
   pure subroutine tabulated_derivatives(self, t, q, omega, by_rotation, by_rate)
      class(tabulated_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: by_rotation(3, 3), by_rate(3, 3)
      by_rotation = 0.0_wp
      by_rate = 0.0_wp
      if (self%in_space) by_rotation = skew(self%torque(t, q, omega))
   end subroutine tabulated_derivatives

   !> Returns the times between which the torque acts, s.
   pure subroutine tabulated_window(self, start, stop)
      class(tabulated_torque_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = self%start
      stop = self%stop
   end subroutine tabulated_window

   !> Returns which ends of the window are not those of the table: the ends inside of it, and both if it is periodic.
   pure function tabulated_own_ends(self) result(own)
      class(tabulated_torque_t), intent(in) :: self
      logical :: own(2)
      own = [self%start > self%curve%x(0), self%stop < self%curve%x(self%curve%n)] .or. self%periodic
   end function tabulated_own_ends

   !> Returns the interval of the table that contains a time, s, so that all calls within a step use one polynomial.
   pure subroutine tabulated_piece(self, moment, start, stop)
      class(tabulated_torque_t), intent(in) :: self
      real(wp), intent(in) :: moment
      real(wp), intent(out) :: start, stop
      real(wp) :: time, before
      integer :: k
      call locate(self, moment, k, time)
      before = 0.0_wp
      if (self%periodic) before = rounds_before(self, moment)*period_of(self)
      start = before + self%curve%x(k - 1)
      stop = before + self%curve%x(k)
      call move_inside(moment, start, stop, abs(before) + abs(self%curve%x(k)))
   end subroutine tabulated_piece

   !> Returns the next end of the window or time of the table, s.
   pure real(wp) function tabulated_break(self, t, sense) result(next)
      class(tabulated_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, sense
      real(wp) :: first, last
      first = merge(self%start, self%stop, sense > 0.0_wp)
      last = merge(self%stop, self%start, sense > 0.0_wp)
      if (sense*first > sense*t) then
         next = first
      else if (sense*last > sense*t) then
         next = next_line(self, t, sense)
         if (sense*next > sense*last) next = last
      else
         next = sense*huge(next)
      end if
   end function tabulated_break

   !> Returns the next time of the table, s; huge if there is none, or none that differs from others in floating point.
   pure real(wp) function next_line(self, t, sense) result(next)
      class(tabulated_torque_t), intent(in) :: self
      !> Time inside of the table, s, and direction of time: 1 or -1.
      real(wp), intent(in) :: t, sense
      real(wp) :: rounds, period
      integer :: k, way
      next = sense*huge(next)
      way = nint(sense)
      rounds = 0.0_wp
      period = period_of(self)
      if (self%periodic) then
         if (period <= least_round*abs(t)) return
         rounds = rounds_before(self, t)
      end if
      k = interval_at(self%curve, t - rounds*period)
      if (way < 0) k = k - 1
      ! Rounding may have moved a time of the table in either direction.
      do while (sense*(rounds*period + self%curve%x(k) - t) <= 0.0_wp)
         if (k == merge(self%curve%n, 0, way > 0)) then
            if (.not. self%periodic) return
            rounds = rounds + sense
            k = merge(0, self%curve%n, way > 0)
         end if
         k = k + way
      end do
      next = rounds*period + self%curve%x(k)
   end function next_line

   !> Returns true for a table in space axes.
   pure logical function attitude_in_space(self)
      class(tabulated_torque_t), intent(in) :: self
      attitude_in_space = self%in_space
   end function attitude_in_space

   !> Bounds the torque in a step by those of the whole table. In body axes: T = (1+β)τ - 2b(b·τ). In space axes, ν at
   !> the start of the step: T = (1-β)ν - 2b×ν.
   pure subroutine tabulated_bound(self, map, radius, gamma, slack, bounds)
      class(tabulated_torque_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      real(wp) :: whole, square, slope
      whole = map%norm*self%bounds(1)
      square = 1 + radius*radius
      slope = merge(2*sqrt(square), 2*radius, self%in_space)
      bounds%known = all(self%bounds <= greatest_number)
      if (.not. bounds%known) return
      bounds%force = square*whole
      bounds%slope = slope*whole
      bounds%curvature = 2*whole
      bounds%change = square*map%norm*self%bounds(2)
      bounds%change_slope = slope*map%norm*self%bounds(2)
      bounds%change_rate = square*map%norm*self%bounds(3)
   end subroutine tabulated_bound

   !> Returns ∂τ/∂t of the interpolating polynomial, body axes, N m/s; shape (3).
   pure function tabulated_time_derivative(self, t, q, omega, span) result(derivative)
      class(tabulated_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3), span
      real(wp) :: derivative(3)
      real(wp) :: time
      integer :: k
      call locate(self, t, k, time)
      derivative = taylor_term(self%curve, k, 1, time, 1.0_wp)
      if (self%in_space) derivative = rotate_to_body(q, derivative)
   end function tabulated_time_derivative

   !> Returns `SPACE_SERIES` for a table in space axes, else `TIME_SERIES`.
   pure integer function tabulated_series(self)
      class(tabulated_torque_t), intent(in) :: self
      tabulated_series = merge(SPACE_SERIES, TIME_SERIES, self%in_space)
   end function tabulated_series

   !> Computes coefficient k of the polynomial, in the axes of the table, N m.
   pure subroutine tabulated_series_torque(self, k, t, time_unit, omega, gamma, auxiliary, tau)
      class(tabulated_torque_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit, omega(3, 0:k), gamma(3, 0:k)
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      real(wp) :: time
      integer :: interval
      tau = 0.0_wp
      if (k > self%curve%degree) return
      call locate(self, t, interval, time)
      tau = taylor_term(self%curve, interval, k, time, time_unit)
   end subroutine tabulated_series_torque

   !> Returns true if the values of the table can be computed with; `start` and `stop` need only be comparable.
   pure logical function table_is_valid(self)
      class(tabulated_torque_t), intent(in) :: self
      table_is_valid = self%curve%n > 0 .and. .not. (is_nan(self%start) .or. is_nan(self%stop))
      if (table_is_valid) table_is_valid = is_moderate(self%bounds(1))
   end function table_is_valid

end module nutate_tabulated_torque
