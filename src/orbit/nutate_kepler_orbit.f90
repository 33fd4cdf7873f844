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
   use nutate_conic, only: change_on_conic, place_on_conic, velocity_change_on_conic
   use nutate_kinds, only: wp, eps, pi
   use nutate_power_series, only: inverses, power_term, product_term
   use nutate_quaternion, only: cross, quat_product, rotate_to_body, rotate_to_space
   use nutate_track, only: track_t, track_position, track_velocity, track_axes, track_axes_rate, track_true_anomaly, &
      track_position_series, thin_track
   implicit none
   private

   public :: kepler_orbit_t, eccentric_anomaly
   public :: position_change_series, pull_change_series, axes_change_series, axes_change, position_change, &
      turn_rate_change, mean_motion_change, find_place

   !> Numbers of a *change of the elements*: of a or q, e, inclination, right ascension of the node, argument of the
   !> periapsis, mean anomaly or time of the periapsis, and μ.
   integer, parameter, public :: n_elements = 7

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
   contains
      !> Returns n = √(μ/a³), rad/s; 0 of an open orbit and of a table.
      procedure :: mean_motion
      !> Return true if the orbit is given by its periapsis, and the distance of the periapsis, m.
      procedure :: is_from_periapsis
      procedure :: nearest => nearest_distance
      !> Returns ν at a time, rad, without jumps: on an ellipse it grows by 2π with each revolution.
      procedure :: true_anomaly
      !> Return ν̇ at a time, and its largest value, at periapsis, rad/s.
      procedure :: turn_rate
      procedure :: fastest_turn
      !> Returns the distance from the centre of attraction at a time, m.
      procedure :: radius
      !> Returns the position from the centre of attraction at a time, inertial axes, m.
      procedure :: position
      !> Returns the velocity at a time, inertial axes, m/s.
      procedure :: velocity
      !> Returns the attitude of the LVLH frame at a time, LVLH→inertial, without jumps.
      procedure :: axes
      !> Computes the power series of the position about a time.
      procedure :: position_series
      !> Adds a change to the elements.
      procedure :: shift
      !> Returns true if another orbit has the same numbers.
      procedure :: equals
      !> Leaves out every second line of the table, if there is one.
      procedure :: thin_table
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

   !> Returns E of `E - e sin E = M`, rad, by Newton's iteration. On 0 <= M <= π the function is convex and M + e is not
   !> below its root, so the iteration decreases monotonically to it. It ends when it stops decreasing.
   pure real(wp) function eccentric_anomaly(mean, eccentricity) result(anomaly)
      !> M, rad, any number; e, 0 <= e < 1.
      real(wp), intent(in) :: mean, eccentricity
      !> Newton's iteration doubles its digits; a nearly parabolic orbit first comes down by thirds.
      integer, parameter :: most = 80
      real(wp) :: turns, m, change
      integer :: i
      turns = 2*pi*anint(mean/(2*pi))
      m = abs(mean - turns)
      anomaly = min(m + eccentricity, pi)
      do i = 1, most
         change = (anomaly - eccentricity*sin(anomaly) - m)/(1 - eccentricity*cos(anomaly))
         if (change <= 0.0_wp) exit
         anomaly = anomaly - change
         if (change <= eps*anomaly) exit
      end do
      anomaly = turns + sign(anomaly, mean - turns)
   end function eccentric_anomaly

   pure real(wp) function anomaly_at(self, t) result(anomaly)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      anomaly = eccentric_anomaly(self%mean_anomaly + self%mean_motion()*t, self%eccentricity)
   end function anomaly_at

   !> Returns the true anomaly at a time, rad, without jumps: it grows by 2π with each revolution.
   pure real(wp) function true_anomaly(self, t) result(nu)
      class(kepler_orbit_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: anomaly, beta, place(2), velocity(2), radius
      if (self%is_from_periapsis()) then
         call find_from_periapsis(self, t, place, velocity, radius, nu)
         return
      else if (allocated(self%track)) then
         nu = track_true_anomaly(self%track, t, self%mu)
         return
      end if
      anomaly = anomaly_at(self, t)
      beta = self%eccentricity/(1 + flatness(self))
      nu = anomaly + 2*atan2(beta*sin(anomaly), 1 - beta*cos(anomaly))
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
      real(wp) :: place(2), velocity(2), nu
      if (self%is_from_periapsis()) then
         call find_from_periapsis(self, t, place, velocity, radius, nu)
         return
      else if (allocated(self%track)) then
         radius = norm2(track_position(self%track, t))
         return
      end if
      radius = self%semi_major_axis*(1 - self%eccentricity*cos(anomaly_at(self, t)))
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
      real(wp) :: anomaly, c, s, place(2), speeds(2), q(4)
      if (allocated(self%track)) then
         position = track_position(self%track, t)
         distance = norm2(position)
         if (present(velocity)) velocity = track_velocity(self%track, t)
         return
      else if (self%is_from_periapsis()) then
         call find_from_periapsis(self, t, place, speeds, distance, anomaly)
      else
         anomaly = anomaly_at(self, t)
         c = cos(anomaly)
         s = sin(anomaly)
         distance = self%semi_major_axis*(1 - self%eccentricity*c)
         place = self%semi_major_axis*[c - self%eccentricity, flatness(self)*s]
         if (present(velocity)) speeds = (self%semi_major_axis*self%mean_motion()/(1 - self%eccentricity*c))* &
                                         [-s, flatness(self)*c]
      end if
      q = plane(self, 0.0_wp)
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
         q = quat_product(plane(self, self%true_anomaly(t)), from_radial)
      end if
   end function axes

   !> Computes the coefficients of the power series of x = r/r₀, r₀ = |r| at the start, from ẍ = -(μ/r₀³) x w, w =
   !> (x·x)^(-3/2).
   pure subroutine position_series(self, t, time_unit, x, square, w, distance)
      class(kepler_orbit_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t, time_unit
      !> Inertial axes; shape (0:order, 3).
      real(wp), contiguous, intent(out) :: x(0:, :)
      !> x·x and w; shape (0:order).
      real(wp), contiguous, intent(out) :: square(0:), w(0:)
      !> r₀, m.
      real(wp), intent(out), optional :: distance
      real(wp) :: start, pull, sum(3), position(3), velocity(3)
      integer :: j, k
      call find_place(self, t, position, start, velocity)
      if (present(distance)) distance = start
      if (allocated(self%track)) then
         call track_position_series(self%track, t, time_unit, start, x)
      else
         x(0, :) = position/start
         if (ubound(x, 1) > 0) x(1, :) = (time_unit/start)*velocity
      end if
      pull = self%mu/start/start/start
      do k = 0, ubound(x, 1)
         ! The three sums do not wait for each other.
         sum = 0.0_wp
         do j = 0, k
            sum(1) = sum(1) + x(j, 1)*x(k - j, 1)
            sum(2) = sum(2) + x(j, 2)*x(k - j, 2)
            sum(3) = sum(3) + x(j, 3)*x(k - j, 3)
         end do
         square(k) = sum(1) + sum(2) + sum(3)
         if (k == 0) then
            w(0) = 1/(square(0)*sqrt(square(0)))
         else
            w(k) = power_term(k, -1.5_wp, square(0:k), w(0:k - 1))
         end if
         if (k + 2 > ubound(x, 1) .or. allocated(self%track)) cycle
         sum = 0.0_wp
         do j = 0, k
            sum(1) = sum(1) + x(j, 1)*w(k - j)
            sum(2) = sum(2) + x(j, 2)*w(k - j)
            sum(3) = sum(3) + x(j, 3)*w(k - j)
         end do
         x(k + 2, :) = -(pull*time_unit*time_unit)*sum*inverses(k + 1)*inverses(k + 2)
      end do
   end subroutine position_series

   !> Returns the unit quaternion to inertial axes from those with x at an angle from the periapsis in the plane, z
   !> along its normal; shape (4).
   pure function plane(self, angle) result(q)
      class(kepler_orbit_t), intent(in) :: self
      !> rad.
      real(wp), intent(in) :: angle
      real(wp) :: q(4), half(3)
      half = 0.5_wp*[self%raan, self%inclination, self%argument_of_periapsis + angle]
      q = quat_product(quat_product([cos(half(1)), 0.0_wp, 0.0_wp, sin(half(1))], &
                                    [cos(half(2)), sin(half(2)), 0.0_wp, 0.0_wp]), &
                       [cos(half(3)), 0.0_wp, 0.0_wp, sin(half(3))])
   end function plane

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
   !> of the position on the conic.
   pure subroutine find_change(self, change, t, place, moved)
      class(kepler_orbit_t), intent(in) :: self
      !> Change of the elements; time, s.
      real(wp), intent(in) :: change(:), t
      !> m; shape (2).
      real(wp), intent(out) :: place(2), moved(2)
      real(wp) :: anomaly, c, s, flat, moved_anomaly, rate, time, moved_time, by_time(2), by_eccentricity(2)
      real(wp) :: velocity(2), radius
      if (self%is_from_periapsis()) then
         call find_from_periapsis(self, t, place, velocity, radius, anomaly)
         rate = periapsis_rate(self)
         time = (t - self%periapsis_time)*rate
         moved_time = time*(0.5_wp*change(7)/self%mu - 1.5_wp*change(1)/self%periapsis_distance) - rate*change(6)
         call change_on_conic(self%eccentricity, time, by_time, by_eccentricity)
         moved = (change(1)/self%periapsis_distance)*place + &
                 self%periapsis_distance*(moved_time*by_time + change(2)*by_eccentricity)
      else
         anomaly = anomaly_at(self, t)
         c = cos(anomaly)
         s = sin(anomaly)
         flat = flatness(self)
         place = self%semi_major_axis*[c - self%eccentricity, flat*s]
         moved_anomaly = (change(6) + t*mean_motion_change(self, change) + s*change(2))/(1 - self%eccentricity*c)
         moved = (change(1)/self%semi_major_axis)*place + self%semi_major_axis* &
                 [-s*moved_anomaly - change(2), flat*c*moved_anomaly - (self%eccentricity/flat)*s*change(2)]
      end if
   end subroutine find_change

   !> Returns the change of the velocity in the plane, m/s; shape (2).
   pure function velocity_change_in_plane(self, change, t) result(moved)
      class(kepler_orbit_t), intent(in) :: self
      !> Change of the elements; time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: moved(2), place(2), velocity(2), by_eccentricity(2), radius, anomaly, c, s, flat, moved_anomaly
      real(wp) :: distance, rate, time, moved_time
      if (self%is_from_periapsis()) then
         call find_from_periapsis(self, t, place, velocity, radius, anomaly)
         rate = periapsis_rate(self)
         time = (t - self%periapsis_time)*rate
         moved_time = time*(0.5_wp*change(7)/self%mu - 1.5_wp*change(1)/self%periapsis_distance) - rate*change(6)
         call velocity_change_on_conic(self%eccentricity, time, by_eccentricity)
         distance = radius/self%periapsis_distance
         moved = (0.5_wp*change(7)/self%mu - 0.5_wp*change(1)/self%periapsis_distance)*velocity + &
                 rate*(self%periapsis_distance*change(2)*by_eccentricity &
                       - (moved_time/distance/distance/distance)*place)
      else
         anomaly = anomaly_at(self, t)
         c = cos(anomaly)
         s = sin(anomaly)
         flat = flatness(self)
         distance = 1 - self%eccentricity*c
         moved_anomaly = (change(6) + t*mean_motion_change(self, change) + s*change(2))/distance
         velocity = (self%semi_major_axis*self%mean_motion()/distance)*[-s, flat*c]
         moved = (0.5_wp*change(7)/self%mu - 0.5_wp*change(1)/self%semi_major_axis &
                  + (c*change(2) - self%eccentricity*s*moved_anomaly)/distance)*velocity &
                 + (self%semi_major_axis*self%mean_motion()/distance)* &
                 [-c*moved_anomaly, -flat*s*moved_anomaly - (self%eccentricity/flat)*c*change(2)]
      end if
   end function velocity_change_in_plane

   !> Computes the coefficients of the power series of x = r/r₀, as `position_series` does, and of δx, δr over the same
   !> r₀, from ẍ = -(μ/r₀³) x w differentiated: δẍ = -(μ/r₀³)(δx w + x δw + (δμ/μ) x w), δw = -3 (x·δx)(x·x)^(-5/2).
   pure subroutine position_change_series(self, change, t, time_unit, x, moved, square, along)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time and its unit, s.
      real(wp), intent(in) :: change(:), t, time_unit
      !> Inertial axes; shape (0:order, 3).
      real(wp), intent(out) :: x(0:, :), moved(0:, :)
      !> x·x and x·δx; shape (0:order).
      real(wp), intent(out) :: square(0:), along(0:)
      real(wp), dimension(0:ubound(x, 1)) :: w, steep, moved_w
      real(wp) :: start, pull, velocity(3)
      integer :: i, k
      call self%position_series(t, time_unit, x, square, w)
      start = self%radius(t)
      pull = self%mu/start/start/start
      moved(0, :) = position_change(self, change, t)/start
      velocity = rotate_to_space(plane(self, 0.0_wp), [velocity_change_in_plane(self, change, t), 0.0_wp]) + &
                 cross(plane_change(self, change), self%velocity(t))
      if (ubound(x, 1) > 0) moved(1, :) = (time_unit/start)*velocity
      do k = 0, ubound(x, 1)
         along(k) = product_term(k, x(0:k, 1), moved(0:k, 1)) + product_term(k, x(0:k, 2), moved(0:k, 2)) &
                    + product_term(k, x(0:k, 3), moved(0:k, 3))
         if (k == 0) then
            steep(0) = w(0)/square(0)
         else
            steep(k) = power_term(k, -2.5_wp, square(0:k), steep(0:k - 1))
         end if
         moved_w(k) = (change(7)/self%mu)*w(k) - 3*product_term(k, along(0:k), steep(0:k))
         if (k + 2 > ubound(x, 1)) cycle
         do i = 1, 3
            moved(k + 2, i) = -(pull*time_unit*time_unit)*inverses(k + 1)*inverses(k + 2)* &
                              (product_term(k, moved(0:k, i), w(0:k)) + product_term(k, x(0:k, i), moved_w(0:k)))
         end do
      end do
   end subroutine position_change_series

   !> Computes the coefficients of the power series of the change of μ^a x (x·x)^b over μ^a:
   !> (a(δμ/μ)x + δx)(x·x)^b + 2b x (x·δx)(x·x)^(b-1).
   pure subroutine pull_change_series(self, change, of_mu, exponent, t, time_unit, n)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); exponents a and b; time and its unit, s.
      real(wp), intent(in) :: change(:), of_mu, exponent, t, time_unit
      !> Inertial axes; shape (3, 0:order).
      real(wp), intent(out) :: n(:, 0:)
      real(wp), dimension(0:ubound(n, 2), 3) :: x, moved
      real(wp), dimension(0:ubound(n, 2)) :: square, along, u, steep, moved_u
      integer :: i, k
      call position_change_series(self, change, t, time_unit, x, moved, square, along)
      do k = 0, ubound(n, 2)
         if (k == 0) then
            u(0) = square(0)**exponent
            steep(0) = u(0)/square(0)
         else
            u(k) = power_term(k, exponent, square(0:k), u(0:k - 1))
            steep(k) = power_term(k, exponent - 1, square(0:k), steep(0:k - 1))
         end if
         moved_u(k) = (of_mu*change(7)/self%mu)*u(k) + 2*exponent*product_term(k, along(0:k), steep(0:k))
         do i = 1, 3
            n(i, k) = product_term(k, moved(0:k, i), u(0:k)) + product_term(k, x(0:k, i), moved_u(0:k))
         end do
      end do
   end subroutine pull_change_series

   !> Computes the coefficients of the power series of the rotation of the LVLH frame, a vector, rad: the rotation P of
   !> the plane, and about the normal n the rotation in the plane, n·(x×δx)/(x·x) - P·n.
   pure subroutine axes_change_series(self, change, t, time_unit, in_orbit, turn)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time and its unit, s.
      real(wp), intent(in) :: change(:), t, time_unit
      !> The rotation is seen from the LVLH frame of a circular orbit; else from inertial axes.
      logical, intent(in) :: in_orbit
      !> Shape (3, 0:order).
      real(wp), intent(out) :: turn(:, 0:)
      real(wp), dimension(0:ubound(turn, 2), 3) :: x, moved
      real(wp), dimension(0:ubound(turn, 2)) :: square, along, inverse, across
      real(wp) :: normal(3), axis(3), tilt(3)
      integer :: j, k
      call position_change_series(self, change, t, time_unit, x, moved, square, along)
      normal = normal_of(self)
      do k = 0, ubound(turn, 2)
         if (k == 0) then
            inverse(0) = 1/square(0)
         else
            inverse(k) = power_term(k, -1.0_wp, square(0:k), inverse(0:k - 1))
         end if
         across(k) = 0.0_wp
         do j = 0, k
            across(k) = across(k) + dot_product(normal, cross(x(j, :), moved(k - j, :)))
         end do
      end do
      tilt = plane_change(self, change)
      tilt = tilt - dot_product(tilt, normal)*normal
      axis = normal
      if (in_orbit) then
         axis = [0.0_wp, -1.0_wp, 0.0_wp]
         tilt = rotate_to_body(self%axes(t), tilt)
      end if
      do k = 0, ubound(turn, 2)
         turn(:, k) = product_term(k, across(0:k), inverse(0:k))*axis
         if (k == 0 .or. in_orbit) turn(:, k) = turn(:, k) + tilt
         ! A constant inertial vector rotates backwards in the frame.
         tilt = (time_unit*self%mean_motion()*inverses(k + 1))*cross(tilt, axis)
      end do
   end subroutine axes_change_series

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
      normal = rotate_to_space(plane(self, 0.0_wp), [0.0_wp, 0.0_wp, 1.0_wp])
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
      moved = rotate_to_space(plane(self, 0.0_wp), [moved_place, 0.0_wp]) + &
              cross(plane_change(self, change), rotate_to_space(plane(self, 0.0_wp), [place, 0.0_wp]))
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
