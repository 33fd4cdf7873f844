!> The motion of a body's centre about a centre of attraction: a Kepler orbit, at any time.
!>
!> Inertial axes: x to the equinox, z north. Orbital axes (LVLH): x across the radius in the plane, forward on a
!> circular orbit, y against the orbit's normal, z to the centre of attraction. With E the eccentric anomaly,
!> `E - e sin E = M`, β = e/(1 + √(1-e²)):
!>
!>     ν = E + 2 atan(β sin E/(1 - β cos E)),   r = a(1 - e cos E),   ν̇ = h/r²,   h = √(μ a (1-e²)).
!>
!> An orbit that is given by its periapsis may have any e >= 0 (`nutate_conic`); a table of positions replaces
!> all elements (`nutate_track`).
module nutate_kepler_orbit
   use nutate_conic, only: change_on_conic, place_on_conic
   use nutate_kinds, only: wp, pi
   use nutate_power_series, only: highest_order, inverses
   use nutate_quaternion, only: cross, quat_product, rotate_to_body, rotate_to_space
   use nutate_track, only: track_t, track_position, track_velocity, track_axes, track_axes_rate, track_true_anomaly, &
      track_position_series, thin_track
   implicit none
   private

   public :: kepler_orbit_t, eccentric_anomaly
   public :: axes_change, position_change, velocity_change, plane_change, normal_of, turn_rate_change, &
      mean_motion_change, find_place

   !> Numbers of a *change of the elements*: of a or q, e, inclination, right ascension of the node, argument of the
   !> periapsis, mean anomaly or time of the periapsis, and μ.
   integer, parameter, public :: n_elements = 7

   !> Series that are multiplied by a power of the distance together: the lanes of `expand_position`.
   integer, parameter :: n_lanes = 5
   !> Orbital axes from those along radius, transverse and normal: unit quaternion.
   real(wp), parameter :: from_radial(4) = [0.5_wp, -0.5_wp, -0.5_wp, 0.5_wp]

   !> A Kepler orbit: an ellipse by its elements, with the position on it at t = 0, or, with a periapsis distance, any
   !> conic with the time of the periapsis.
   type :: kepler_orbit_t
      !> a, m; e, 0 <= e < 1; μ, m³/s².
      real(wp) :: semi_major_axis = 1.0_wp, eccentricity = 0.0_wp, mu = 1.0_wp
      !> Inclination, right ascension of the ascending node, argument of the periapsis, mean anomaly at t = 0, rad.
      real(wp) :: inclination = 0.0_wp, raan = 0.0_wp, argument_of_periapsis = 0.0_wp, mean_anomaly = 0.0_wp
      !> q, m, and the time of the passage, s: replacing a and the mean anomaly if q > 0, with any e >= 0.
      real(wp) :: periapsis_distance = 0.0_wp, periapsis_time = 0.0_wp
      !> Positions by time, replacing all elements.
      type(track_t), allocatable :: track
      !> Right ascension of the ascending node, inclination and argument of the periapsis, rad, shape (3), for which the
      !> quaternion of the plane is stored; and this, shape (4).
      real(wp), private :: angles_of_plane(3) = huge(1.0_wp), plane(4) = 0.0_wp
   contains
      !> Returns n = √(μ/a³), rad/s; 0 of an open orbit and of a table.
      procedure, non_overridable :: mean_motion
      !> Return true if the orbit is given by its periapsis, and the distance of the periapsis, m.
      procedure, non_overridable :: is_from_periapsis
      procedure, non_overridable :: nearest => nearest_distance
      !> Returns ν at a time, rad, without jumps: on an ellipse it grows by 2π with each revolution.
      procedure, non_overridable :: true_anomaly
      !> Return ν̇ at a time, and its largest value, at periapsis, rad/s.
      procedure, non_overridable :: turn_rate
      procedure, non_overridable :: fastest_turn
      !> Returns the distance from the centre of attraction at a time, m.
      procedure, non_overridable :: radius
      !> Returns the position from the centre of attraction at a time, inertial axes, m.
      procedure, non_overridable :: position
      !> Returns the velocity at a time, inertial axes, m/s.
      procedure, non_overridable :: velocity
      !> Returns the attitude of the LVLH frame at a time, LVLH→inertial, without jumps.
      procedure, non_overridable :: axes
      !> Compute the power series of the position about a time, and of its product with a power of the distance.
      procedure, non_overridable :: position_series
      procedure, non_overridable :: pull_series
      !> Stores the quaternion of the plane, so that positions take less time.
      procedure, non_overridable :: store_plane
      !> Adds a change to the elements.
      procedure, non_overridable :: shift
      !> Returns true if another orbit has the same numbers.
      procedure, non_overridable :: equals
      !> Leaves out every second line of the table, if there is one.
      procedure, non_overridable :: thin_table
   end type kepler_orbit_t

contains

   !> Leaves out every second line of the table, if there is one.
   subroutine thin_table(self)
      class(kepler_orbit_t), intent(inout) :: self
      if (allocated(self%track)) call thin_track(self%track)
   end subroutine thin_table

   !> Returns the mean motion n = √(μ/a³), rad/s; 0 of an open orbit and of a table.
   pure real(wp) function mean_motion(self)
      class(kepler_orbit_t), intent(in) :: self
      if (allocated(self%track)) then
         mean_motion = 0.0_wp
      else if (self%is_from_periapsis()) then
         mean_motion = 0.0_wp
         if (self%eccentricity < 1.0_wp) mean_motion = periapsis_rate(self)*(1 - self%eccentricity)**1.5_wp
      else
         mean_motion = sqrt(self%mu/self%semi_major_axis**3)
      end if
   end function mean_motion

   !> Returns true if the orbit is given by its periapsis.
   pure logical function is_from_periapsis(self)
      class(kepler_orbit_t), intent(in) :: self
      is_from_periapsis = self%periapsis_distance > 0.0_wp
   end function is_from_periapsis

   !> Returns the distance of the periapsis, m.
   pure real(wp) function nearest_distance(self) result(nearest)
      class(kepler_orbit_t), intent(in) :: self
      if (allocated(self%track)) then
         nearest = self%track%nearest
      else if (self%is_from_periapsis()) then
         nearest = self%periapsis_distance
      else
         nearest = self%semi_major_axis*(1 - self%eccentricity)
      end if
   end function nearest_distance

   !> Returns √(μ/q³), rad/s.
   pure real(wp) function periapsis_rate(self) result(rate)
      class(kepler_orbit_t), intent(in) :: self
      rate = sqrt(self%mu/self%periapsis_distance/self%periapsis_distance/self%periapsis_distance)
   end function periapsis_rate

   !> Computes position and velocity at a time on an orbit that is given by its periapsis.
   pure subroutine find_from_periapsis(self, t, place, velocity, radius, true_anomaly)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> In the plane of the orbit, the first component to the periapsis, m, m/s; shape (2).
      real(wp), intent(out) :: place(2), velocity(2)
      !> m, rad.
      real(wp), intent(out) :: radius, true_anomaly
      real(wp) :: rate
      rate = periapsis_rate(self)
      call place_on_conic(self%eccentricity, (t - self%periapsis_time)*rate, place, velocity, radius, true_anomaly)
      place = self%periapsis_distance*place
      radius = self%periapsis_distance*radius
      velocity = (self%periapsis_distance*rate)*velocity
   end subroutine find_from_periapsis

   !> Returns E of `E - e sin E = M`, rad.
   pure real(wp) function eccentric_anomaly(mean, eccentricity) result(anomaly)
      !> M, rad, any number; e, 0 <= e < 1.
      real(wp), intent(in) :: mean, eccentricity
      real(wp) :: s, c
      call solve_kepler(mean, eccentricity, anomaly, s, c)
   end function eccentric_anomaly

   !> Solves Kepler's equation by Newton's iteration. On 0 <= M <= π the function is convex and M not above its root,
   !> so that the first move leads to where the iteration decreases monotonically. Near the root sine and cosine are
   !> rotated by the move instead of evaluated.
   pure subroutine solve_kepler(mean, e, anomaly, s, c)
      !> M, rad, any number; e, 0 <= e < 1.
      real(wp), intent(in) :: mean, e
      !> E, rad; sin E and cos E.
      real(wp), intent(out) :: anomaly, s, c
      !> Newton's iteration doubles its digits; a nearly parabolic orbit first comes down by thirds.
      integer, parameter :: most = 80
      !> Longest move, rad, for which the terms of `rotate_back` are enough; change of the slope in it, relative to the
      !> slope, from which on three more moves are enough; relative change of a move after which none follows.
      real(wp), parameter :: near = 0.25_wp, curved = 0.0625_wp, settled = 1e-9_wp
      real(wp) :: turns, m, excess, slope, move, change, sine, cosine
      integer :: i
      turns = 2*pi*anint(mean/(2*pi))
      m = min(abs(mean - turns), pi)
      anomaly = m
      do i = 1, most
         s = sin(anomaly)
         c = cos(anomaly)
         excess = (anomaly - e*s) - m
         slope = 1 - e*c
         move = excess/slope
         if (abs(move) <= near .and. e*abs(move)*(s + abs(move)) <= curved*slope) exit
         anomaly = min(anomaly - move, m + e, pi)
      end do
      move = move/(1 - 0.5_wp*e*s*move/slope)
      do i = 1, 3
         call rotate_back(s, c, move, sine, cosine)
         change = (excess - (move - e*(s - sine)))/(1 - e*cosine)
         move = move + change
         if (abs(change) <= settled*abs(move)) exit
      end do
      call rotate_back(s, c, move, sine, cosine)
      anomaly = turns + sign(anomaly - move, mean - turns)
      s = sign(1.0_wp, mean - turns)*sine
      c = cosine
   end subroutine solve_kepler

   !> Returns sine and cosine of an angle less another one, by the series of the other one.
   pure subroutine rotate_back(s, c, move, sine, cosine)
      !> Sine and cosine of the angle; the other one, up to 1/4 rad.
      real(wp), intent(in) :: s, c, move
      real(wp), intent(out) :: sine, cosine
      real(wp), parameter :: r(2:13) = [0.5_wp, 1.0_wp/6, 1.0_wp/24, 1.0_wp/120, 1.0_wp/720, 1.0_wp/5040, &
                                        1.0_wp/40320, 1.0_wp/362880, 1.0_wp/3628800, 1.0_wp/39916800, &
                                        1.0_wp/479001600, 1.0_wp/6227020800.0_wp]
      real(wp) :: x, small, versed
      x = move*move
      small = move*(1 - x*(r(3) - x*(r(5) - x*(r(7) - x*(r(9) - x*(r(11) - x*r(13)))))))
      versed = x*(r(2) - x*(r(4) - x*(r(6) - x*(r(8) - x*(r(10) - x*r(12))))))
      sine = s - (s*versed + c*small)
      cosine = c - (c*versed - s*small)
   end subroutine rotate_back

   !> Computes E, rad, with its sine and cosine, at a time.
   pure subroutine find_anomaly(self, t, anomaly, s, c)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp), intent(out) :: anomaly, s, c
      call solve_kepler(self%mean_anomaly + self%mean_motion()*t, self%eccentricity, anomaly, s, c)
   end subroutine find_anomaly

   !> Returns the true anomaly at a time, rad, without jumps: it grows by 2π with each revolution.
   pure real(wp) function true_anomaly(self, t) result(nu)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: anomaly, s, c, beta, place(2), velocity(2), radius
      if (self%is_from_periapsis()) then
         call find_from_periapsis(self, t, place, velocity, radius, nu)
         return
      else if (allocated(self%track)) then
         nu = track_true_anomaly(self%track, t, self%mu)
         return
      end if
      call find_anomaly(self, t, anomaly, s, c)
      beta = self%eccentricity/(1 + flatness(self))
      nu = anomaly + 2*atan2(beta*s, 1 - beta*c)
   end function true_anomaly

   !> Returns √(1-e²).
   pure real(wp) function flatness(self)
      class(kepler_orbit_t), intent(in) :: self
      flatness = sqrt((1 - self%eccentricity)*(1 + self%eccentricity))
   end function flatness

   !> Returns ν̇ at a time, the rate of rotation of the LVLH frame, rad/s.
   pure real(wp) function turn_rate(self, t)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      if (self%is_from_periapsis()) then
         turn_rate = self%fastest_turn()*(self%periapsis_distance/self%radius(t))**2
      else if (allocated(self%track)) then
         turn_rate = dot_product(rotate_to_body(track_axes(self%track, t), track_axes_rate(self%track, t)), &
                                 [0.0_wp, -1.0_wp, 0.0_wp])
      else
         turn_rate = self%mean_motion()*flatness(self)*(self%semi_major_axis/self%radius(t))**2
      end if
   end function turn_rate

   !> Returns the largest ν̇, at periapsis, rad/s.
   pure real(wp) function fastest_turn(self)
      class(kepler_orbit_t), intent(in) :: self
      if (self%is_from_periapsis()) then
         fastest_turn = periapsis_rate(self)*sqrt(1 + self%eccentricity)
         return
      else if (allocated(self%track)) then
         fastest_turn = self%track%fastest
         return
      end if
      fastest_turn = self%mean_motion()*sqrt((1 + self%eccentricity)/(1 - self%eccentricity))/(1 - self%eccentricity)
   end function fastest_turn

   !> Returns the distance from the centre of attraction at a time, m.
   pure real(wp) function radius(self, t)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: place(2), velocity(2), anomaly, s, c
      if (self%is_from_periapsis()) then
         call find_from_periapsis(self, t, place, velocity, radius, anomaly)
         return
      else if (allocated(self%track)) then
         radius = norm2(track_position(self%track, t))
         return
      end if
      call find_anomaly(self, t, anomaly, s, c)
      radius = self%semi_major_axis*(1 - self%eccentricity*c)
   end function radius

   !> Returns the position from the centre of attraction at a time, inertial axes, m; shape (3).
   pure function position(self, t)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: position(3), distance
      call find_place(self, t, position, distance)
   end function position

   !> Returns the velocity at a time, inertial axes, m/s; shape (3).
   pure function velocity(self, t)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: velocity(3), position(3), distance
      call find_place(self, t, position, distance, velocity)
   end function velocity

   !> Computes position, distance and velocity at a time by one solution of Kepler's equation.
   pure subroutine find_place(self, t, position, distance, velocity)
      type(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> Position from the centre of attraction, inertial axes, m, shape (3); its length, m.
      real(wp), intent(out) :: position(3), distance
      !> Velocity, inertial axes, m/s; shape (3).
      real(wp), intent(out), optional :: velocity(3)
      real(wp) :: anomaly, c, s, flat, rate, place(2), speeds(2), q(4)
      if (allocated(self%track)) then
         position = track_position(self%track, t)
         distance = norm2(position)
         if (present(velocity)) velocity = track_velocity(self%track, t)
         return
      else if (self%is_from_periapsis()) then
         call find_from_periapsis(self, t, place, speeds, distance, anomaly)
      else
         rate = self%mean_motion()
         call solve_kepler(self%mean_anomaly + rate*t, self%eccentricity, anomaly, s, c)
         flat = flatness(self)
         distance = self%semi_major_axis*(1 - self%eccentricity*c)
         place = self%semi_major_axis*[c - self%eccentricity, flat*s]
         speeds = (self%semi_major_axis*rate/(1 - self%eccentricity*c))*[-s, flat*c]
      end if
      q = plane_at(self, 0.0_wp)
      position = rotate_to_space(q, [place, 0.0_wp])
      if (present(velocity)) velocity = rotate_to_space(q, [speeds, 0.0_wp])
   end subroutine find_place

   !> Returns the attitude of the LVLH frame at a time, unit quaternion, LVLH→inertial, without jumps; shape (4).
   pure function axes(self, t) result(q)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: q(4)
      if (allocated(self%track)) then
         q = track_axes(self%track, t)
      else
         q = quat_product(plane_at(self, self%true_anomaly(t)), from_radial)
      end if
   end function axes

   !> Computes the coefficients of the power series of x = r/r₀, r₀ = |r| at the start, of x·x and of (x·x)^(-3/2).
   pure subroutine position_series(self, t, time_unit, x, square, w)
      class(kepler_orbit_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t, time_unit
      !> Inertial axes; shape (0:order, 3).
      real(wp), contiguous, intent(out) :: x(0:, :)
      !> x·x and w; shape (0:order).
      real(wp), contiguous, intent(out) :: square(0:), w(0:)
      real(wp) :: lanes(n_lanes, 0:ubound(x, 1)), start
      call expand_position(self, t, time_unit, lanes, w, start)
      x = transpose(lanes(1:3, :))
      square = lanes(4, :)
   end subroutine position_series

   !> Computes the coefficients of the power series of x (x·x)^b, x = r/r₀, r₀ = |r| at the start.
   pure subroutine pull_series(self, exponent, t, time_unit, n, distance)
      class(kepler_orbit_t), intent(in) :: self
      !> b; time and its unit, s.
      real(wp), intent(in) :: exponent, t, time_unit
      !> Inertial axes; shape (3, 0:order).
      real(wp), intent(out) :: n(:, 0:)
      !> r₀, m.
      real(wp), intent(out) :: distance
      real(wp) :: lanes(n_lanes, 0:ubound(n, 2)), power(0:ubound(n, 2)), product(3)
      integer :: k
      if (.not. (allocated(self%track) .or. self%is_from_periapsis())) then
         call expand_on_ellipse(self, exponent, t, time_unit, n, distance)
         return
      end if
      call expand_position(self, t, time_unit, lanes, power, distance)
      do k = 0, ubound(n, 2)
         call continue_power(k, exponent, lanes, power, product)
         n(:, k) = product
      end do
   end subroutine pull_series

   !> Computes the coefficients of `pull_series` on an ellipse from those of cos E, sin E and Ė, and of p = (ρ/ρ₀)^(2b),
   !> ρ = r/a: by ρĖ = n and ρṗ = 2b ρ̇p, with ρ = 1 - e cos E. These are half of the products of `expand_position`. The
   !> arguments are those of `pull_series`.
   pure subroutine expand_on_ellipse(self, exponent, t, time_unit, n, distance)
      class(kepler_orbit_t), intent(in) :: self
      real(wp), intent(in) :: exponent, t, time_unit
      real(wp), intent(out) :: n(:, 0:), distance
      !> cos E, sin E, and index times coefficient of cos E.
      real(wp) :: lanes(3, 0:highest_order)
      real(wp) :: rate(0:highest_order), p(0:highest_order), by_rate(2), by_p(3), along(3), across(3), q(4)
      real(wp) :: anomaly, s, c, rho, motion
      integer :: j, k
      associate (e => self%eccentricity)
         motion = self%mean_motion()
         call solve_kepler(self%mean_anomaly + motion*t, e, anomaly, s, c)
         rho = 1 - e*c
         distance = self%semi_major_axis*rho
         q = plane_at(self, 0.0_wp)
         along = rotate_to_space(q, [1/rho, 0.0_wp, 0.0_wp])
         across = rotate_to_space(q, [0.0_wp, flatness(self)/rho, 0.0_wp])
         lanes(:, 0) = [c, s, 0.0_wp]
         do k = 0, ubound(n, 2)
            by_rate = 0.0_wp
            by_p = 0.0_wp
            do j = 1, k
               by_rate = by_rate + lanes(1:2, j)*rate(k - j)
               by_p = by_p + lanes(:, j)*p(k - j)
            end do
            rate(k) = merge(motion*time_unit, e*by_rate(1), k == 0)/rho
            p(k) = merge(1.0_wp, (e/rho)*(by_p(1) - (2*exponent + 1)*inverses(max(k, 1))*by_p(3)), k == 0)
            n(:, k) = (by_p(1) + (c - e)*p(k))*along + (by_p(2) + s*p(k))*across
            if (k == ubound(n, 2)) exit
            lanes(3, k + 1) = -(by_rate(2) + s*rate(k))
            lanes(1, k + 1) = inverses(k + 1)*lanes(3, k + 1)
            lanes(2, k + 1) = inverses(k + 1)*(by_rate(1) + c*rate(k))
         end do
      end associate
   end subroutine expand_on_ellipse

   !> Computes the coefficients of the power series of x = r/r₀, with x·x, and of w = (x·x)^(-3/2), from
   !> ẍ = -(μ/r₀³) x w.
   pure subroutine expand_position(self, t, time_unit, lanes, w, start)
      class(kepler_orbit_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t, time_unit
      !> x, inertial axes; x·x; index times coefficient of x·x; shape (n_lanes, 0:order).
      real(wp), contiguous, intent(out) :: lanes(:, 0:)
      !> w, shape (0:order); r₀, m.
      real(wp), contiguous, intent(out) :: w(0:)
      real(wp), intent(out) :: start
      real(wp) :: pull, product(3), position(3), velocity(3), table(0:ubound(lanes, 2), 3)
      integer :: k, last
      last = ubound(lanes, 2)
      call find_place(self, t, position, start, velocity)
      if (allocated(self%track)) then
         call track_position_series(self%track, t, time_unit, start, table)
         lanes(1:3, :) = transpose(table)
      else
         lanes(1:3, 0) = position/start
         if (last > 0) lanes(1:3, 1) = (time_unit/start)*velocity
      end if
      pull = self%mu*time_unit*time_unit/start/start/start
      do k = 0, last
         lanes(4, k) = square_term(k, lanes)
         lanes(5, k) = k*lanes(4, k)
         call continue_power(k, -1.5_wp, lanes, w, product)
         if (k + 2 <= last .and. .not. allocated(self%track)) &
            lanes(1:3, k + 2) = -(pull*inverses(k + 1)*inverses(k + 2))*product
      end do
   end subroutine expand_position

   !> Returns coefficient k of x·x.
   pure real(wp) function square_term(k, lanes) result(term)
      integer, intent(in) :: k
      !> x first; shape (n_lanes, 0:k).
      real(wp), intent(in) :: lanes(n_lanes, 0:k)
      real(wp) :: sums(3)
      integer :: j
      sums = 0.0_wp
      do j = 0, (k + 1)/2 - 1
         sums = sums + lanes(1:3, j)*lanes(1:3, k - j)
      end do
      sums = 2*sums
      j = k/2
      if (2*j == k) sums = sums + lanes(1:3, j)*lanes(1:3, j)
      term = (sums(1) + sums(2)) + sums(3)
   end function square_term

   !> Computes coefficient k of p = (x·x)^α from those before, as `power_term` does, and of x p; one loop for all.
   pure subroutine continue_power(k, exponent, lanes, power, product)
      integer, intent(in) :: k
      !> α.
      real(wp), intent(in) :: exponent
      !> x, x·x and index times coefficient of x·x; shape (n_lanes, 0:k).
      real(wp), intent(in) :: lanes(n_lanes, 0:k)
      !> p; shape (0:k).
      real(wp), intent(inout) :: power(0:k)
      !> x p; shape (3).
      real(wp), intent(out) :: product(3)
      real(wp) :: sums(4), weighted
      integer :: j
      sums = 0.0_wp
      weighted = 0.0_wp
      do j = 1, k
         sums = sums + lanes(1:4, j)*power(k - j)
         weighted = weighted + lanes(5, j)*power(k - j)
      end do
      if (k == 0) then
         power(0) = lanes(4, 0)**exponent
      else
         power(k) = ((exponent + 1)*weighted - k*sums(4))*(inverses(k)/lanes(4, 0))
      end if
      product = sums(1:3) + lanes(1:3, 0)*power(k)
   end subroutine continue_power

   !> Returns the unit quaternion to inertial axes from those with x at an angle from the periapsis in the plane, z
   !> along its normal; shape (4).
   pure function plane_at(self, angle) result(q)
      class(kepler_orbit_t), intent(in) :: self
      !> rad.
      real(wp), intent(in) :: angle
      real(wp) :: q(4), half(3)
      if (.not. abs(angle) > 0.0_wp) then
         q = self%plane
         if (.not. any(abs(angles_of(self) - self%angles_of_plane) > 0.0_wp)) return
      end if
      half = 0.5_wp*[self%raan, self%inclination, self%argument_of_periapsis + angle]
      q = quat_product(quat_product([cos(half(1)), 0.0_wp, 0.0_wp, sin(half(1))], &
                                    [cos(half(2)), sin(half(2)), 0.0_wp, 0.0_wp]), &
                       [cos(half(3)), 0.0_wp, 0.0_wp, sin(half(3))])
   end function plane_at

   !> Stores the quaternion of the plane for its present angles.
   pure subroutine store_plane(self)
      class(kepler_orbit_t), intent(inout) :: self
      self%plane = plane_at(self, 0.0_wp)
      self%angles_of_plane = angles_of(self)
   end subroutine store_plane

   !> Returns right ascension of the ascending node, inclination and argument of the periapsis, rad; shape (3).
   pure function angles_of(self) result(angles)
      class(kepler_orbit_t), intent(in) :: self
      real(wp) :: angles(3)
      angles = [self%raan, self%inclination, self%argument_of_periapsis]
   end function angles_of

   !> Returns δn, rad/s.
   pure real(wp) function mean_motion_change(self, change)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements; shape (n_elements).
      real(wp), intent(in) :: change(:)
      real(wp) :: relative
      mean_motion_change = 0.0_wp
      if (allocated(self%track)) return
      if (self%is_from_periapsis()) then
         if (self%eccentricity >= 1.0_wp) return
         relative = 0.5_wp*change(7)/self%mu - 1.5_wp*(change(1)/self%periapsis_distance + &
                                                       change(2)/(1 - self%eccentricity))
      else
         relative = 0.5_wp*change(7)/self%mu - 1.5_wp*change(1)/self%semi_major_axis
      end if
      mean_motion_change = relative*self%mean_motion()
   end function mean_motion_change

   !> Computes the position in the plane, as in `find_from_periapsis`, and its change: from that of M = E - e sin E, or
   !> of the position on the conic; and the change of the velocity.
   pure subroutine find_change(self, change, t, place, moved, moved_velocity)
      class(kepler_orbit_t), intent(in) :: self
      !> Change of the elements; time, s.
      real(wp), intent(in) :: change(:), t
      !> m; shape (2).
      real(wp), intent(out) :: place(2), moved(2)
      !> m/s; shape (2).
      real(wp), intent(out), optional :: moved_velocity(2)
      real(wp) :: anomaly, c, s, flat, moved_anomaly, rate, time, moved_time, by_time(2), by_eccentricity(2)
      real(wp) :: velocity(2), velocity_by_eccentricity(2), radius, distance
      if (self%is_from_periapsis()) then
         call find_from_periapsis(self, t, place, velocity, radius, anomaly)
         rate = periapsis_rate(self)
         time = (t - self%periapsis_time)*rate
         moved_time = time*(0.5_wp*change(7)/self%mu - 1.5_wp*change(1)/self%periapsis_distance) - rate*change(6)
         call change_on_conic(self%eccentricity, time, by_time, by_eccentricity, velocity_by_eccentricity)
         moved = (change(1)/self%periapsis_distance)*place + &
                 self%periapsis_distance*(moved_time*by_time + change(2)*by_eccentricity)
         if (.not. present(moved_velocity)) return
         distance = radius/self%periapsis_distance
         moved_velocity = (0.5_wp*change(7)/self%mu - 0.5_wp*change(1)/self%periapsis_distance)*velocity + &
                          rate*(self%periapsis_distance*change(2)*velocity_by_eccentricity &
                                - (moved_time/distance/distance/distance)*place)
      else
         call find_anomaly(self, t, anomaly, s, c)
         flat = flatness(self)
         place = self%semi_major_axis*[c - self%eccentricity, flat*s]
         distance = 1 - self%eccentricity*c
         moved_anomaly = (change(6) + t*mean_motion_change(self, change) + s*change(2))/distance
         moved = (change(1)/self%semi_major_axis)*place + self%semi_major_axis* &
                 [-s*moved_anomaly - change(2), flat*c*moved_anomaly - (self%eccentricity/flat)*s*change(2)]
         if (.not. present(moved_velocity)) return
         velocity = (self%semi_major_axis*self%mean_motion()/distance)*[-s, flat*c]
         moved_velocity = (0.5_wp*change(7)/self%mu - 0.5_wp*change(1)/self%semi_major_axis &
                           + (c*change(2) - self%eccentricity*s*moved_anomaly)/distance)*velocity &
                          + (self%semi_major_axis*self%mean_motion()/distance)* &
                          [-c*moved_anomaly, -flat*s*moved_anomaly - (self%eccentricity/flat)*c*change(2)]
      end if
   end subroutine find_change

   !> Returns δv at a time, inertial axes, m/s; shape (3).
   pure function velocity_change(self, change, t) result(moved)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: moved(3), place(2), moved_place(2), moved_velocity(2)
      call find_change(self, change, t, place, moved_place, moved_velocity)
      moved = rotate_to_space(plane_at(self, 0.0_wp), [moved_velocity, 0.0_wp]) + &
              cross(plane_change(self, change), self%velocity(t))
   end function velocity_change

   !> Returns the rotation of the plane, vector in inertial axes, rad; shape (3).
   pure function plane_change(self, change) result(turn)
      class(kepler_orbit_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      real(wp) :: turn(3)
      turn = change(3)*[cos(self%raan), sin(self%raan), 0.0_wp] + change(5)*normal_of(self)
      turn(3) = turn(3) + change(4)
   end function plane_change

   !> Returns the unit vector along the orbit's normal, inertial axes; shape (3).
   pure function normal_of(self) result(normal)
      class(kepler_orbit_t), intent(in) :: self
      real(wp) :: normal(3)
      normal = rotate_to_space(plane_at(self, 0.0_wp), [0.0_wp, 0.0_wp, 1.0_wp])
   end function normal_of

   !> Returns δr at a time, inertial axes, m; shape (3). Zero for a table.
   pure function position_change(self, change, t) result(moved)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: moved(3), place(2), moved_place(2)
      moved = 0.0_wp
      if (allocated(self%track)) return
      call find_change(self, change, t, place, moved_place)
      moved = rotate_to_space(plane_at(self, 0.0_wp), [moved_place, 0.0_wp]) + &
              cross(plane_change(self, change), rotate_to_space(plane_at(self, 0.0_wp), [place, 0.0_wp]))
   end function position_change

   !> Returns the rotation of the LVLH frame at a time, vector in inertial axes, rad; shape (3). Zero for a table.
   pure function axes_change(self, change, t) result(turn)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: turn(3), place(2), moved(2)
      turn = 0.0_wp
      if (allocated(self%track)) return
      call find_change(self, change, t, place, moved)
      place = place/norm2(place)**2
      turn = plane_change(self, change) + (place(1)*moved(2) - place(2)*moved(1))*normal_of(self)
   end function axes_change

   !> Returns δν̇ at a time, rad/s; from ν̇ = √(μp)/r². Zero for a table.
   pure real(wp) function turn_rate_change(self, change, t)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: place(2), moved(2), relative
      turn_rate_change = 0.0_wp
      if (allocated(self%track)) return
      call find_change(self, change, t, place, moved)
      relative = 0.5_wp*change(7)/self%mu - 2*dot_product(place, moved)/dot_product(place, place)
      if (self%is_from_periapsis()) then
         relative = relative + 0.5_wp*(change(1)/self%periapsis_distance + change(2)/(1 + self%eccentricity))
      else
         relative = relative + 0.5_wp*change(1)/self%semi_major_axis - self%eccentricity*change(2)/flatness(self)**2
      end if
      turn_rate_change = relative*self%turn_rate(t)
   end function turn_rate_change

   !> Adds a change to the elements.
   pure subroutine shift(self, change)
      class(kepler_orbit_t), intent(inout) :: self
      !> Change of the elements; shape (n_elements).
      real(wp), intent(in) :: change(:)
      self%eccentricity = self%eccentricity + change(2)
      self%inclination = self%inclination + change(3)
      self%raan = self%raan + change(4)
      self%argument_of_periapsis = self%argument_of_periapsis + change(5)
      self%mu = self%mu + change(7)
      if (self%is_from_periapsis()) then
         self%periapsis_distance = self%periapsis_distance + change(1)
         self%periapsis_time = self%periapsis_time + change(6)
      else
         self%semi_major_axis = self%semi_major_axis + change(1)
         self%mean_anomaly = self%mean_anomaly + change(6)
      end if
   end subroutine shift

   !> Returns true if another orbit has the same numbers; an orbit with a table never equals another.
   pure logical function equals(self, other)
      class(kepler_orbit_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: other
      equals = .not. (allocated(self%track) .or. allocated(other%track)) .and. .not. &
               any(abs(numbers_of(self) - numbers_of(other)) > 0.0_wp)
   end function equals

   !> Returns the elements of the orbit; shape (9).
   pure function numbers_of(self) result(numbers)
      class(kepler_orbit_t), intent(in) :: self
      real(wp) :: numbers(9)
      numbers = [self%semi_major_axis, self%eccentricity, self%mu, self%inclination, self%raan, &
                 self%argument_of_periapsis, self%mean_anomaly, self%periapsis_distance, self%periapsis_time]
   end function numbers_of

end module nutate_kepler_orbit
