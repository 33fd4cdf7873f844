!> Paths by tables of positions: their error between the lines, the effects and columns that use them, and that
!> steps which end on the lines keep order and energy balance of every method.
submodule(suites_of_effects) test_orbit_table
   use nutate_body, only: diagonal, make_body
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, eps, pi
   use nutate_orbit, only: earth_mu, orbit_t
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_quaternion, only: cross, quat_product, rotate_to_body
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_track, only: make_track, track_t, track_position, track_velocity, next_track_break, track_contains
   use test_problems, only: angular_velocity, make_state, new_system, system_t, total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> Contents of a table: positions; velocities too; and accelerations made from them.
   integer, parameter :: POSITIONS = 1, VELOCITIES = 2, ACCELERATIONS = 3
   real(wp), parameter :: degree = pi/180
   !> Two hours before and behind the passage.
   real(wp), parameter :: passage = 7200.0_wp

contains

   module procedure collect_orbit_table
      testsuite = [ &
                  new_unittest("errors of 1/r**3 between the lines are those of theory", errors_between), &
                  new_unittest("velocities, LVLH frame and its rate are those of the positions", parts_of_track), &
                  new_unittest("series hold on either side of a line", series_at_lines), &
                  new_unittest("a table of a Kepler orbit shows its true anomaly", true_anomaly), &
                  new_unittest("every method keeps its order and the energy balance", methods), &
                  new_unittest("there and back through the lines", back), &
                  new_unittest("outside of the table the body stays at its end", outside), &
                  new_unittest("tables that are none are refused at their line", refused)]
   end procedure collect_orbit_table

   !> The hyperbola of Apophis about the Earth.
   type(kepler_orbit_t) function apophis() result(path)
      path = kepler_orbit_t(mu=earth_mu, periapsis_distance=38011486.49129103_wp, periapsis_time=passage, &
                            eccentricity=4.253901873212790_wp, inclination=162.8561543134850_wp*degree, &
                            raan=152.0019490904037_wp*degree, argument_of_periapsis=32.56762207107416_wp*degree)
   end function apophis

   !> Returns the path of Apophis from a table.
   type(track_t) function track_of(kind, spacing, margin) result(track)
      integer, intent(in) :: kind
      !> Interval of the table, s.
      real(wp), intent(in) :: spacing
      !> Time by which the table begins earlier and ends later, s; default 0.
      real(wp), intent(in), optional :: margin
      type(kepler_orbit_t) :: path
      type(status_t) :: status
      real(wp), allocatable :: times(:), r(:, :), v(:, :)
      real(wp) :: more
      integer :: i, n, at
      path = apophis()
      more = 0.0_wp
      if (present(margin)) more = margin
      n = nint(2*(passage + more)/spacing)
      allocate (times(n + 1), r(3, n + 1), v(3, n + 1))
      do i = 1, n + 1
         times(i) = (i - 1)*spacing - more
         r(:, i) = path%position(times(i))
         v(:, i) = path%velocity(times(i))
      end do
      select case (kind)
      case (POSITIONS)
         call make_track(times, r, track, status, at)
      case (VELOCITIES)
         call make_track(times, r, track, status, at, v)
      case default
         call make_track(times, r, track, status, at, v, earth_mu)
      end select
   end function track_of

   !> Largest relative errors for lines every 300 s and 1800 s, of another program, to a digit.
   subroutine errors_between(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: spacings(2) = [300.0_wp, 1800.0_wp]
      real(wp), parameter :: expected(3, 2) = reshape([5e-8_wp, 5e-8_wp, 2e-11_wp, 9e-5_wp, 6e-5_wp, 7e-7_wp], [3, 2])
      type(kepler_orbit_t) :: path
      type(track_t) :: track
      real(wp) :: worst, t
      integer :: kind, i, k
      path = apophis()
      do i = 1, size(spacings)
         do kind = POSITIONS, ACCELERATIONS
            ! A natural spline is worse at its ends.
            track = track_of(kind, spacings(i), passage)
            worst = 0.0_wp
            do k = 0, 4000
               t = 2*passage*k/4000
               worst = max(worst, abs((path%radius(t)/norm2(track_position(track, t)))**3 - 1))
            end do
            ! The expected errors are given to half a unit of their digit.
            call check_close(error, worst/expected(kind, i), 1.0_wp, 0.3_wp, 'error')
         end do
      end do
   end subroutine errors_between

   subroutine parts_of_track(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 0.5_wp
      type(orbit_t) :: orbit
      real(wp) :: t, q(4), r(3), v(3), rate(3)
      integer :: kind, i
      do kind = POSITIONS, ACCELERATIONS
         orbit = orbit_of(kind, 300.0_wp)
         call check(error, .not. orbit%is_frame, 'inertial axes')
         do i = 0, 46
            ! Between the lines: on them the third derivatives jump.
            t = 150.0_wp + 300.0_wp*i
            r = orbit%path%position(t)
            v = orbit%path%velocity(t)
            q = orbit%axes(t)
            call check_close(error, v, (orbit%path%position(t + h) - orbit%path%position(t - h))/(2*h), 1e-4_wp, &
                 'velocity')
            call check_close(error, rotate_to_body(q, r/norm2(r)), [0.0_wp, 0.0_wp, -1.0_wp], 8*eps, 'z')
            call check_close(error, rotate_to_body(q, cross(r, v))/norm2(cross(r, v)), [0.0_wp, -1.0_wp, 0.0_wp], &
                             16*eps, 'normal')
            rate = orbit%axes_rate(t)
            call check_close(error, (orbit%axes(t + h) - orbit%axes(t - h))/(2*h), &
                             0.5_wp*quat_product([0.0_wp, rate], q), 1e-9_wp*norm2(rate) + 1e-13_wp, 'rate')
            call check_close(error, orbit%path%turn_rate(t), norm2(cross(r, v))/dot_product(r, r), 1e-10_wp, 'turn')
            call check_below(error, norm2(cross(r, v))/dot_product(r, r), 1.001_wp*orbit%path%fastest_turn(), 'fastest')
            call check_below(error, orbit%path%nearest(), norm2(r), 'nearest')
         end do
      end do
   end subroutine parts_of_track

   type(orbit_t) function orbit_of(kind, spacing) result(orbit)
      integer, intent(in) :: kind
      real(wp), intent(in) :: spacing
      type(kepler_orbit_t) :: path
      path%mu = earth_mu
      allocate (path%track)
      path%track = track_of(kind, spacing)
      orbit = orbit_t(path)
   end function orbit_of

   !> Checks series from a line on, with time forward and backward, and from between two lines.
   subroutine series_at_lines(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(orbital_gradient_t) :: gradient
      type(orbit_t) :: orbit
      type(status_t) :: status
      real(wp) :: n(3), series(3, 0:24), t, unit
      integer :: kind, i, k, way
      system => new_system()
      call make_body(diagonal([0.64_wp, 0.97_wp, 1.0_wp]), system%body, status)
      do kind = POSITIONS, ACCELERATIONS
         orbit = orbit_of(kind, 600.0_wp)
         gradient = orbital_gradient_t(system%body, orbit%path)
         do i = 1, 23
            do way = -1, 1, 2
               t = 600.0_wp*i
               if (mod(i, 3) == 0) t = t*(1 + way*2*eps)
               if (mod(i, 3) == 1) t = t + way*100.0_wp
               unit = way*400.0_wp
               call gradient%direction_series(t, unit, series)
               n = series(:, 24)
               do k = 23, 0, -1
                  n = n + series(:, k)
               end do
               call check_close(error, n/1e-5_wp, gradient%direction_at(t + unit)/1e-5_wp, 1e-12_wp, 'series')
            end do
         end do
      end do
   end subroutine series_at_lines

   subroutine true_anomaly(error)
      type(error_type), allocatable, intent(out) :: error
      type(kepler_orbit_t) :: path
      type(orbit_t) :: orbit
      integer :: i
      path = apophis()
      orbit = orbit_of(ACCELERATIONS, 60.0_wp)
      do i = 0, 40
         call check_close(error, orbit%path%true_anomaly(350.0_wp*i), path%true_anomaly(350.0_wp*i), 1e-11_wp, &
              'anomaly')
         call check_close(error, orbit%path%radius(350.0_wp*i), path%radius(350.0_wp*i), 1e-3_wp, 'radius')
      end do
   end subroutine true_anomaly

   !> Apophis, start A of the reference, on a table.
   subroutine make_flyby(system, state, kind, spacing)
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: state
      integer, intent(in) :: kind
      real(wp), intent(in) :: spacing
      type(orbit_t) :: orbit
      type(status_t) :: status
      real(wp) :: q(4)
      call make_body(diagonal([0.64_wp, 0.97_wp, 1.0_wp]), system%body, status)
      orbit = orbit_of(kind, spacing)
      call system%effects%add(orbit)
      call system%effects%add(orbital_gradient_t(system%body, orbit%path))
      q = [0.5_wp, -0.7_wp, 0.1_wp, 0.5_wp]
      state = make_state(system, q, [1.3e-4_wp, -2e-4_wp, 5.6e-4_wp])
   end subroutine make_flyby

   !> Steps of 150 s and 250 s on lines every 600 s: those that meet a line are cut there.
   subroutine methods(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: start, reference, state
      type(run_plan_t) :: plan
      type(status_t) :: status
      type(integrator_settings_t) :: settings(5)
      integer :: kind, i
      system => new_system()
      settings = [integrator_settings_t(order=8), integrator_settings_t(order=8, formulation='reduced'), &
                  integrator_settings_t(method='dop853'), integrator_settings_t(method='rk8', conserve=.true.), &
                  integrator_settings_t(method='taylor', series_order=20, conserve=.true.)]
      do kind = POSITIONS, ACCELERATIONS
         call make_flyby(system, start, kind, 600.0_wp)
         reference = start
         call integrate(system, integrator_settings_t(method='taylor', conserve=.true.), reference, &
                        run_plan_t(end_time=2*passage, goal=run_goal_t(local_tolerance=1e-15_wp)), status)
         call check(error, status%ok(), trim(status%message))
         do i = 1, size(settings)
            state = start
            plan = run_plan_t(time_step=merge(100.0_wp, 125.0_wp, i < 3), end_time=2*passage)
            call integrate(system, settings(i), state, plan, status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, state%q, reference%q, 1e-11_wp, settings(i)%method//' attitude')
            call check_close(error, angular_velocity(system, state)/1e-4_wp, angular_velocity(system, &
                 reference)/1e-4_wp, &
                             1e-11_wp, settings(i)%method//' rate')
            if (i == 3) cycle
            call check_close(error, total_energy(system, state) - state%time_dependent_work, total_energy(system, &
                 start), &
                             64*eps*total_energy(system, start), settings(i)%method//' energy balance')
         end do
         ! Order 2 in steps as long as the lines are apart.
         state = start
         call integrate(system, integrator_settings_t(order=2), state, run_plan_t(time_step=600.0_wp, &
              end_time=2*passage), &
                        status)
         call check_close(error, total_energy(system, state) - state%time_dependent_work, total_energy(system, start), &
                          64*eps*total_energy(system, start), 'energy balance of order 2')
      end do
   end subroutine methods

   subroutine back(error)
      type(error_type), allocatable, intent(out) :: error
      type(system_t), pointer :: system
      type(state_t) :: start, state
      type(status_t) :: status
      integer :: kind
      system => new_system()
      do kind = POSITIONS, ACCELERATIONS
         call make_flyby(system, start, kind, 600.0_wp)
         state = start
         call integrate(system, integrator_settings_t(method='taylor'), state, &
                        run_plan_t(end_time=2*passage, goal=run_goal_t(local_tolerance=1e-15_wp)), status)
         call integrate(system, integrator_settings_t(method='taylor'), state, &
                        run_plan_t(end_time=0.0_wp, goal=run_goal_t(local_tolerance=1e-15_wp)), status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, state%q, start%q, 1e-12_wp, 'attitude')
         call check_close(error, state%time_dependent_work, 0.0_wp, 64*eps*total_energy(system, start), 'work')
         state = start
         call integrate(system, integrator_settings_t(order=4), state, run_plan_t(time_step=130.0_wp, &
              end_time=2*passage), &
                        status)
         call integrate(system, integrator_settings_t(order=4), state, run_plan_t(time_step=-130.0_wp, &
              end_time=0.0_wp), &
                        status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, total_energy(system, state) - state%time_dependent_work, total_energy(system, start), &
                          64*eps*total_energy(system, start), 'energy balance')
      end do
   end subroutine back

   subroutine outside(error)
      type(error_type), allocatable, intent(out) :: error
      type(track_t) :: track
      track = track_of(VELOCITIES, 600.0_wp)
      call check_close(error, track_position(track, -10.0_wp), track_position(track, 0.0_wp), 0.0_wp, 'before')
      call check_close(error, track_position(track, 3*passage), track_position(track, 2*passage), 0.0_wp, 'behind')
      call check_close(error, track_velocity(track, 3*passage), [0.0_wp, 0.0_wp, 0.0_wp], 0.0_wp, 'velocity')
      call check(error, track_contains(track, 2*passage) .and. .not. track_contains(track, 2*passage + 1), 'end')
      call check_close(error, next_track_break(track, 0.0_wp, 1.0_wp), 600.0_wp, 0.0_wp, 'next line')
      call check_close(error, next_track_break(track, 600.0_wp, -1.0_wp), 0.0_wp, 0.0_wp, 'line before')
      call check_close(error, next_track_break(track, -5.0_wp, 1.0_wp), 0.0_wp, 0.0_wp, 'first line')
      call check(error, next_track_break(track, 2*passage, 1.0_wp) > 1e300_wp, 'none behind the last')
   end subroutine outside

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: times(3) = [0.0_wp, 1.0_wp, 2.0_wp]
      real(wp) :: r(3, 3), v(3, 3)
      type(track_t) :: track
      type(status_t) :: status
      integer :: at
      r = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.5_wp, 1.5_wp, 0.0_wp], [3, 3])
      v = 0.0_wp
      call make_track(times, r, track, status, at)
      call check(error, status%ok() .and. at == 0, trim(status%message))
      call make_track([0.0_wp, 1.0_wp, 1.0_wp], r, track, status, at)
      call check(error, at == 3 .and. index(status%message, 'the time does not increase') > 0, trim(status%message))
      call make_track(times(:1), r(:, :1), track, status, at)
      call check(error, index(status%message, 'the table is too short') > 0, trim(status%message))
      ! km/s beside m.
      v = 1e-3_wp*spread(r(:, 2) - r(:, 1), 2, 3)
      call make_track(times, r, track, status, at, v)
      call check(error, at == 1 .and. index(status%message, 'contradict the positions') > 0, trim(status%message))
      call make_track(times, r, track, status, at, 1e3_wp*v)
      call check(error, status%ok() .and. at == 0, trim(status%message))
      v(1, 2) = 1e30_wp
      call make_track(times, r, track, status, at, v)
      call check(error, at == 2 .and. index(status%message, 'a velocity is out of range') > 0, trim(status%message))
      v = 0.0_wp
      r(:, 3) = 0.0_wp
      call make_track(times, r, track, status, at, v)
      call check(error, at == 3 .and. index(status%message, 'a position is out of range') > 0, trim(status%message))
      ! Straight through the centre.
      r(:, 3) = -r(:, 2)
      call make_track(times, r, track, status, at)
      call check(error, at == 3 .and. index(status%message, 'may come too close to the centre') > 0, &
           trim(status%message))
      ! Faster than it can be.
      r(:, 3) = [1e30_wp, 0.0_wp, 0.0_wp]
      call make_track(times, r, track, status, at)
      call check(error, at == 3 .and. index(status%message, 'moves too fast') > 0, trim(status%message))
   end subroutine refused

end submodule test_orbit_table
