!> The path of a body relative to a centre of attraction, by a table of positions, or of positions and velocities. Steps
!> end on the times of the table, so that each has one polynomial and every method keeps its order.
!>
!> LVLH frame: z to the centre of attraction, y against r×v, x = y×z. With h = r×v and a the acceleration it rotates at
!> ω = h/|r|² + (|r| a·h/|h|²) r̂.
module nutate_track
   use nutate_attitude, only: quat_from_matrix
   use nutate_kinds, only: wp, eps
   use nutate_limits, only: greatest_length, in_words, is_moderate, least_length, least_step
   use nutate_piecewise, only: interval_at, new_hermite, new_spline, piecewise_t, taylor_term, value_at
   use nutate_quaternion, only: cross
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: track_t, make_track, check_track
   public :: track_position, track_velocity, track_axes, track_axes_rate, track_true_anomaly, track_position_series, &
      next_track_break, track_contains, thin_track, track_order

   !> Tolerance for a time to be the end of an interval, over the size of the times: beyond their rounding.
   real(wp), parameter :: at_end = 4*eps
   !> Largest speed, m/s: the square of the longest duration of a run, times that of a speed, stays finite.
   real(wp), parameter :: greatest_speed = 1e20_wp
   !> Ratio of the length of a path by positions to that by speeds from which on their units are assumed to differ.
   real(wp), parameter :: contradiction = 30.0_wp
   !> Least distance from the centre between two lines, over that of these lines; smaller distances require closer
   !> lines.
   real(wp), parameter :: nearest_share = 0.1_wp

   !> Positions and velocities as functions of time; `make_track` makes one.
   type :: track_t
      type(piecewise_t) :: curve = piecewise_t()
      !> The curve is a spline of positions alone.
      logical :: is_spline = .false.
      !> Lower bound of the distance, m, and largest rate of the direction on the lines and between them, rad/s.
      real(wp) :: nearest = 0.0_wp, fastest = 0.0_wp
      !> Attitudes of the LVLH frame at the times of the table, LVLH→inertial, without jumps; shape (4, 0:n).
      real(wp), allocatable, private :: knots(:, :)
   end type track_t

contains

   !> Makes a track: a natural cubic spline of positions, or Hermite's polynomials of degree 3 with velocities, of
   !> degree 5 with accelerations too.
   !>
   !> Errors: those of `check_track`; `NUTATE_BAD_ARGUMENT` if the path comes too close to the centre between lines.
   subroutine make_track(times, positions, track, status, at, velocities, mu)
      !> s; shape (n).
      real(wp), intent(in) :: times(:)
      !> Inertial axes, m; shape (3, n).
      real(wp), intent(in) :: positions(:, :)
      type(track_t), intent(out) :: track
      type(status_t), intent(out) :: status
      !> The line with the error, 1 to n; 0 if no single line is at fault.
      integer, intent(out) :: at
      !> m/s; shape (3, n).
      real(wp), intent(in), optional :: velocities(:, :)
      !> m³/s²: accelerations are -μr/|r|³; default: there are none.
      real(wp), intent(in), optional :: mu
      real(wp), allocatable :: accelerations(:, :)
      integer :: i
      call check_track(times, positions, at, status, velocities)
      if (.not. status%ok()) return
      if (.not. present(velocities)) then
         track%curve = new_spline(times, positions, .false.)
         track%is_spline = .true.
      else if (present(mu)) then
         allocate (accelerations, mold=positions)
         do i = 1, size(times)
            accelerations(:, i) = -(mu/norm2(positions(:, i))/norm2(positions(:, i)))* &
                                  (positions(:, i)/norm2(positions(:, i)))
         end do
         track%curve = new_hermite(times, positions, velocities, accelerations)
      else
         track%curve = new_hermite(times, positions, velocities)
      end if
      call find_nearest(track, at, status)
      if (status%ok() .and. present(velocities)) call check_velocities(times, positions, velocities, at, status)
      if (status%ok()) call prepare(track)
   end subroutine make_track

   !> Leaves out every second line of the table, but for the last; a table of two lines stays as it is. Accelerations
   !> are those of the curve.
   subroutine thin_track(self)
      type(track_t), intent(inout) :: self
      type(track_t) :: other
      type(status_t) :: status
      real(wp), allocatable :: motion(:, :, :), times(:)
      integer :: i, at
      if (self%curve%n < 2) return
      times = [self%curve%x(0:self%curve%n - 1:2), self%curve%x(self%curve%n)]
      allocate (motion(3, size(times), 3))
      do i = 1, size(times)
         motion(:, i, 1) = track_position(self, times(i))
         motion(:, i, 2) = track_velocity(self, times(i))
         motion(:, i, 3) = track_acceleration(self, times(i))
      end do
      if (self%is_spline) then
         other%curve = new_spline(times, motion(:, :, 1), .false.)
      else if (self%curve%degree == 3) then
         other%curve = new_hermite(times, motion(:, :, 1), motion(:, :, 2))
      else
         other%curve = new_hermite(times, motion(:, :, 1), motion(:, :, 2), motion(:, :, 3))
      end if
      other%is_spline = self%is_spline
      call find_nearest(other, at, status)
      ! A bound on the distance that is never zero, for a path that comes too close to the centre.
      other%nearest = max(other%nearest, nearest_share*self%nearest)
      call prepare(other)
      self%curve = other%curve
      self%nearest = other%nearest
      self%fastest = other%fastest
      call move_alloc(other%knots, self%knots)
   end subroutine thin_track

   !> Returns the order of the interpolation: its error goes as this power of the distance of the lines.
   pure integer function track_order(self) result(order)
      type(track_t), intent(in) :: self
      order = self%curve%degree + 1
   end function track_order

   !> Checks a table of positions.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` with the first line that has an error: a number that is not finite or too large, a
   !> time that does not increase, a distance out of range; too few lines.
   subroutine check_track(times, positions, at, status, velocities)
      real(wp), intent(in) :: times(:), positions(:, :)
      integer, intent(out) :: at
      type(status_t), intent(out) :: status
      real(wp), intent(in), optional :: velocities(:, :)
      integer :: i, last
      logical :: good
      do i = 1, size(times)
         at = i
         good = is_moderate(times(i)) .and. all(is_moderate(positions(:, i)))
         if (good .and. present(velocities)) good = all(is_moderate(velocities(:, i)))
         if (good) good = maxval(abs(positions(:, i))) <= greatest_length .and. &
                          maxval(abs(positions(:, i))) >= least_length
         if (.not. good) then
            status = fail(NUTATE_BAD_ARGUMENT, 'a position is out of range (expected a distance of '// &
                          in_words(least_length, greatest_length)//' m)', 'table')
            return
         end if
         if (present(velocities)) good = maxval(abs(velocities(:, i))) <= greatest_speed
         if (.not. good) status = fail(NUTATE_BAD_ARGUMENT, 'a velocity is out of range (expected up to '// &
                                       in_words(greatest_speed)//' m/s)', 'table')
         if (.not. good) return
         if (i == 1) cycle
         last = max(i - 1, 1)
         if (times(i) - times(last) < least_step) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the time does not increase (expected increasing times, '// &
                          in_words(least_step)//' s apart or more)', 'table')
            return
         end if
         if (maxval(abs(positions(:, i) - positions(:, last)))/greatest_speed > times(i) - times(last)) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the body moves too fast from the line before (expected up to '// &
                          in_words(greatest_speed)//' m/s)', 'table')
            return
         end if
      end do
      at = size(times)
      if (size(times) < 2) status = fail(NUTATE_BAD_ARGUMENT, 'the table is too short (expected two lines of '// &
                                         'numbers, or more)', 'table')
      if (status%ok()) at = 0
   end subroutine check_track

   !> Compares the length of the path with that by the speeds. Errors: `NUTATE_BAD_ARGUMENT` if one is several times the
   !> other, as with km/s in a column of m/s; lines that are far apart make no such difference.
   pure subroutine check_velocities(times, positions, velocities, at, status)
      real(wp), intent(in) :: times(:), positions(:, :), velocities(:, :)
      integer, intent(out) :: at
      type(status_t), intent(out) :: status
      real(wp) :: path, by_speed
      integer :: i
      path = 0.0_wp
      by_speed = 0.0_wp
      do i = 2, size(times)
         path = path + norm2(positions(:, i) - positions(:, i - 1))
         by_speed = by_speed + 0.5_wp*(times(i) - times(i - 1))*(norm2(velocities(:, i - 1)) + norm2(velocities(:, i)))
      end do
      at = 0
      if (max(path, by_speed) <= contradiction*min(path, by_speed)) return
      at = 1
      status = fail(NUTATE_BAD_ARGUMENT, 'the velocities contradict the positions (expected m and m/s)', 'table')
   end subroutine check_velocities

   !> Bounds the distance from below, by the corners of each polynomial in Bernstein's basis along the mean direction of
   !> its ends. Errors: `NUTATE_BAD_ARGUMENT` for a polynomial that comes too close to the centre.
   subroutine find_nearest(track, at, status)
      type(track_t), intent(inout) :: track
      integer, intent(out) :: at
      type(status_t), intent(out) :: status
      real(wp) :: along(0:5), direction(3), ends(2), least
      integer :: k
      track%nearest = huge(1.0_wp)
      do k = 1, track%curve%n
         associate (curve => track%curve)
            ends = [norm2(value_at(curve, k, curve%x(k - 1))), norm2(value_at(curve, k, curve%x(k)))]
            direction = value_at(curve, k, curve%x(k - 1))/ends(1) + value_at(curve, k, curve%x(k))/ends(2)
            direction = direction/max(norm2(direction), eps)
            along(:curve%degree) = matmul(direction, curve%c(:, :, k))
            least = minval(corners_of(along(:curve%degree)))
         end associate
         track%nearest = min(track%nearest, least)
         at = k + 1
         if (.not. least >= nearest_share*minval(ends)) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the path may come too close to the centre after the line before '// &
                          '(expected lines closer together)', 'table')
            return
         end if
      end do
      at = 0
   end subroutine find_nearest

   !> Returns the corners of a polynomial in Bernstein's basis: b_j = Σ_{i<=j} (j over i)/(n over i) c_i; shape (0:n).
   pure function corners_of(c) result(b)
      !> Coefficients of s⁰ to sⁿ, 0 <= s <= 1; shape (0:n).
      real(wp), intent(in) :: c(0:)
      real(wp) :: b(0:ubound(c, 1)), ratio
      integer :: i, j
      do j = 0, ubound(c, 1)
         b(j) = 0.0_wp
         ratio = 1.0_wp
         do i = 0, j
            b(j) = b(j) + ratio*c(i)
            if (i < j) ratio = ratio*real(j - i, wp)/(ubound(c, 1) - i)
         end do
      end do
   end function corners_of

   !> Finds the attitudes at the times of the table, and the largest rate.
   subroutine prepare(track)
      type(track_t), intent(inout) :: track
      real(wp) :: r(3), v(3), q(4), t
      integer :: k
      allocate (track%knots(4, 0:track%curve%n))
      do k = 0, track%curve%n
         q = attitude_at(track, track%curve%x(k))
         if (k > 0) q = sign(1.0_wp, dot_product(q, track%knots(:, k - 1)))*q
         track%knots(:, k) = q
      end do
      do k = 0, 2*track%curve%n
         t = track%curve%x(k/2)
         if (mod(k, 2) == 1) t = 0.5_wp*(t + track%curve%x(k/2 + 1))
         r = track_position(track, t)
         v = track_velocity(track, t)/norm2(r)
         r = r/norm2(r)
         track%fastest = max(track%fastest, norm2(v - dot_product(r, v)*r))
      end do
   end subroutine prepare

   !> Finds the interval of a time, and the time inside the table that is nearest to it.
   pure subroutine locate(self, t, k, time, sense)
      class(track_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      integer, intent(out) :: k
      real(wp), intent(out) :: time
      !> Direction of time, which decides the interval at the times of the table: 1 or -1.
      real(wp), intent(in), optional :: sense
      real(wp) :: edge
      time = min(max(t, self%curve%x(0)), self%curve%x(self%curve%n))
      k = interval_at(self%curve, time)
      if (.not. present(sense)) return
      edge = at_end*max(abs(time), abs(self%curve%x(k)))
      if (sense > 0.0_wp .and. self%curve%x(k) - time <= edge) k = min(k + 1, self%curve%n)
      edge = at_end*max(abs(time), abs(self%curve%x(k - 1)))
      if (sense < 0.0_wp .and. time - self%curve%x(k - 1) <= edge) k = max(k - 1, 1)
   end subroutine locate

   !> Returns true if the table contains a time, to a rounding of it.
   pure logical function track_contains(self, t) result(contains_time)
      type(track_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      associate (x => self%curve%x, n => self%curve%n)
         contains_time = t >= x(0) - at_end*max(abs(x(0)), abs(t)) .and. t <= x(n) + at_end*max(abs(x(n)), abs(t))
      end associate
   end function track_contains

   !> Returns the position from the centre of attraction at a time, inertial axes, m; shape (3). Outside of the table it
   !> is that of the nearest end.
   pure function track_position(self, t) result(position)
      type(track_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: position(3), time
      integer :: k
      call locate(self, t, k, time)
      position = value_at(self%curve, k, time)
   end function track_position

   !> Returns the velocity at a time, inertial axes, m/s; shape (3). Outside of the table it is zero.
   pure function track_velocity(self, t) result(velocity)
      type(track_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: velocity(3), time
      integer :: k
      call locate(self, t, k, time)
      velocity = 0.0_wp
      if (track_contains(self, t)) velocity = taylor_term(self%curve, k, 1, time, 1.0_wp)
   end function track_velocity

   !> Returns the acceleration at a time, inertial axes, m/s²; shape (3). Outside of the table it is zero.
   pure function track_acceleration(self, t) result(acceleration)
      type(track_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: acceleration(3), time
      integer :: k
      call locate(self, t, k, time)
      acceleration = 0.0_wp
      if (track_contains(self, t)) acceleration = 2*taylor_term(self%curve, k, 2, time, 1.0_wp)
   end function track_acceleration

   !> Returns the attitude of the LVLH frame at a time, unit quaternion, LVLH→inertial, without jumps; shape (4).
   pure function track_axes(self, t) result(q)
      type(track_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: q(4), time
      integer :: k
      call locate(self, t, k, time)
      q = attitude_at(self, t)
      q = sign(1.0_wp, dot_product(q, self%knots(:, k - 1)))*q
   end function track_axes

   !> Returns the attitude with q0 >= 0. If the body moves along the radius, y is any direction across it.
   pure function attitude_at(self, t) result(q)
      class(track_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: q(4), x(3), y(3), z(3), v(3)
      z = -track_position(self, t)
      z = z/norm2(z)
      v = track_velocity(self, t)
      if (norm2(v) > 0.0_wp) v = v/norm2(v)
      y = cross(z, v)
      if (norm2(y) <= 100*eps) then
         v = 0.0_wp
         v(minloc(abs(z), dim=1)) = 1.0_wp
         y = cross(z, v)
      end if
      y = y/norm2(y)
      x = cross(y, z)
      q = quat_from_matrix(reshape([x, y, z], [3, 3]))
   end function attitude_at

   !> Returns the rate of the LVLH frame at a time, inertial axes, rad/s; shape (3).
   pure function track_axes_rate(self, t) result(rate)
      type(track_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: rate(3), r(3), v(3), h(3), distance
      r = track_position(self, t)
      distance = norm2(r)
      r = r/distance
      v = track_velocity(self, t)
      h = cross(r, v)
      rate = h/distance
      if (norm2(h) > 100*eps*norm2(v)) rate = rate + (dot_product(track_acceleration(self, t), h/norm2(h))/norm2(h))*r
   end function track_axes_rate

   !> Returns the osculating true anomaly at a time, rad, from -π to π.
   pure real(wp) function track_true_anomaly(self, t, mu) result(nu)
      type(track_t), intent(in) :: self
      !> s; m³/s².
      real(wp), intent(in) :: t, mu
      real(wp) :: r(3), v(3), h(3), e(3)
      r = track_position(self, t)
      v = track_velocity(self, t)
      h = cross(r, v)
      r = r/norm2(r)
      e = cross(v, h/mu) - r
      nu = 0.0_wp
      if (norm2(h) > 0.0_wp) nu = atan2(dot_product(h/norm2(h), cross(e, r)), dot_product(e, r))
   end function track_true_anomaly

   !> Computes the coefficients of the power series of the position about a time, over a length.
   pure subroutine track_position_series(self, t, time_unit, length, x)
      type(track_t), intent(in) :: self
      !> s, the latter negative backwards in time; m.
      real(wp), intent(in) :: t, time_unit, length
      !> Inertial axes; shape (0:order, 3).
      real(wp), intent(out) :: x(0:, :)
      real(wp) :: time
      integer :: k, interval
      call locate(self, t, interval, time, sense=time_unit)
      x = 0.0_wp
      do k = 0, merge(min(self%curve%degree, ubound(x, 1)), 0, track_contains(self, t))
         x(k, :) = taylor_term(self%curve, interval, k, time, time_unit)/length
      end do
   end subroutine track_position_series

   !> Returns the next time of the table, s; beyond all times if there is none.
   pure real(wp) function next_track_break(self, t, sense) result(next)
      type(track_t), intent(in) :: self
      !> Time, s; direction of time: 1 or -1.
      real(wp), intent(in) :: t, sense
      integer :: k
      next = sense*huge(next)
      associate (x => self%curve%x, n => self%curve%n)
         if (sense > 0.0_wp .and. t < x(0)) then
            next = x(0)
         else if (sense < 0.0_wp .and. t > x(n)) then
            next = x(n)
         else if (t >= x(0) .and. t <= x(n)) then
            k = interval_at(self%curve, t)
            if (sense > 0.0_wp) then
               if (t < x(k)) next = x(k)
            else
               k = k - 1
               if (.not. t > x(k)) k = k - 1
               if (k >= 0) next = x(k)
            end if
         end if
      end associate
   end function next_track_break

end module nutate_track
