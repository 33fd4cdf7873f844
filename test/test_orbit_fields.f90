!> Effects that move along an orbit: the field of the Earth, forces, the shadow of the Earth; values, rates and series.
submodule(suites_of_effects) test_orbit_fields
   use nutate_attitude, only: quat_from_axis_angle
   use nutate_earth_field, only: earth_field_t
   use nutate_effect, only: potential_t
   use nutate_force, only: moving_force_t
   use nutate_geomagnetic_field, only: geomagnetic_field_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, eps, pi
   use nutate_orbit, only: earth_mu, orbit_t, shadow_rate
   use nutate_quaternion, only: rotate_to_body, rotate_to_space
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_problems, only: angular_velocity, problem_t
   use test_satellites, only: field_along, magnet, path_of, point, push_along, satellite, MAGNETIC
   use test_support, only: check, check_close, error_type, in_turn, new_unittest
   implicit none

   !> References of the satellite with a magnet on an ellipse: times, s, growth of errors of the initial state, q, Ω,
   !> rad/s, and the work of time-dependent potentials, J; 20 digits, by tools/docs/references/earth_field.py.
   real(wp), parameter :: references(10, 4) = reshape([ &
      1000.0_wp, 8.0_wp, -0.157441154044054495413_wp, -0.26522758030340914011_wp, &
      0.454209329442636325016_wp, -0.835799317244842944841_wp, -0.00307391279908655615741_wp, &
      -0.00752089712237434235082_wp, -0.00214159401728597576162_wp, 0.0000103033184935389970528_wp, &
      3000.0_wp, 11.2_wp, 0.792322021902449193322_wp, 0.330927725730735111656_wp, &
      0.32410039547374050035_wp, -0.397078817874818383372_wp, 0.00505416443744330829039_wp, &
      -0.00330039957518212881908_wp, 0.00872078660532897825186_wp, 0.000011982262522248574157_wp, &
      10000.0_wp, 61.8_wp, 0.163314787272037419789_wp, -0.924001821183446381202_wp, &
      0.148229913809599136242_wp, -0.31237286591501886412_wp, 0.00497406837453507892185_wp, &
      -0.00272606749275377430041_wp, 0.00488804691768621715902_wp, 0.00000100532739055500616609_wp, &
      20000.0_wp, 39.0_wp, -0.402303111103945307561_wp, -0.403584073517441025768_wp, &
      -0.0818310897482529028963_wp, -0.817664830569206256193_wp, -0.00011898064349070998783_wp, &
      -0.00245094958043927805745_wp, 0.011490205537927231641_wp, 0.0000014669325892818742657_wp], [10, 4])

contains

   module procedure collect_orbit_fields
      testsuite = [ &
                  new_unittest("the field is that of a dipole", field_of_a_dipole), &
                  new_unittest("a magnet on an ellipse agrees with 20 digits", magnet_agrees), &
                  new_unittest("what moves, its rate and its series", parts_belong_together), &
                  new_unittest("shadow of a circular orbit, and its rate", shadow)]
   end procedure collect_orbit_fields

   !> B = -∇ of the potential a³ G·r/|r|³, G rotated with the Earth, by differences; near the equator it points north.
   subroutine field_of_a_dipole(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: step = 100.0_wp, times(3) = [0.0_wp, 2500.0_wp, 40000.0_wp]
      type(geomagnetic_field_t) :: field
      type(orbit_t) :: orbit
      real(wp) :: expected(3), r(3), shift(3)
      integer :: i, k
      orbit = orbit_t(path_of(0.3_wp))
      field = field_along(orbit)
      do k = 1, size(times)
         r = orbit%path%position(times(k))
         do i = 1, 3
            shift = merge(step, 0.0_wp, [1, 2, 3] == i)
            expected(i) = (potential_of(r - shift, times(k)) - potential_of(r + shift, times(k)))/(2*step)
         end do
         call check_close(error, field%at(times(k)), expected, 1e-9_wp*norm2(expected), "field")
         call check(error, expected(3) > 0.0_wp .or. abs(r(3)) > 0.3_wp*norm2(r), "north")
      end do
   end subroutine field_of_a_dipole

   !> a³ G·r/|r|³ of 2025, Greenwich 0.7 rad from the equinox at t = 0, T m.
   pure real(wp) function potential_of(r, t)
      real(wp), intent(in) :: r(3), t
      real(wp) :: g(3), angle
      angle = 0.7_wp + 7.292115e-5_wp*t
      g = [-1410.3_wp*cos(angle) - 4545.5_wp*sin(angle), -1410.3_wp*sin(angle) + 4545.5_wp*cos(angle), -29350.0_wp]
      potential_of = 6371200.0_wp**3*1e-9_wp*dot_product(g, r)/norm2(r)**3
   end function potential_of

   !> Compares order 8 in both forms and the series with references, within the growth of initial errors of 64 eps:
   !> rounding, of up to 1e4 steps.
   subroutine magnet_agrees(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: solvers(2) = ['full   ', 'reduced']
      type(problem_t), pointer :: problem
      real(wp) :: q(4), rate(3)
      integer :: i, k
      problem => satellite(orbit_t(path_of(0.3_wp)), MAGNETIC)
      do i = 1, size(references, 2)
         associate (t => references(1, i))
            q = references(3:6, i)
            rate = references(7:9, i)
            do k = 1, 2
               if (.not. in_turn(i + k)) cycle
               call check_magnet(error, integrator_settings_t(order=8, formulation=solvers(k)), &
                                 run_plan_t(time_step=2.0_wp, end_time=t))
               call check_magnet(error, integrator_settings_t(method='taylor', conserve=k == 1), &
                                 run_plan_t(goal=run_goal_t(local_tolerance=1e-15_wp), end_time=t))
            end do
         end associate
      end do

   contains

      subroutine check_magnet(error, settings, plan)
         type(error_type), allocatable, intent(inout) :: error
         type(integrator_settings_t), intent(in) :: settings
         type(run_plan_t), intent(in) :: plan
         type(state_t) :: state
         type(status_t) :: status
         real(wp) :: bound
         bound = 64*eps*references(2, i)
         state = problem%start
         call integrate(problem%system, settings, state, plan, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, state%q, q, bound, "attitude")
         call check_close(error, angular_velocity(problem%system, state)/norm2(rate), rate/norm2(rate), bound, "rate")
         call check_close(error, state%time_dependent_work, references(10, i), 1e-5_wp*bound, &
                          "work of time-dependent potentials")
      end subroutine check_magnet

   end subroutine magnet_agrees

   !> Checks series and rates of the field and the force, in inertial axes and in those of a circular orbit.
   subroutine parts_belong_together(error)
      type(error_type), allocatable, intent(out) :: error
      type(orbit_t) :: orbits(3)
      type(orbit_t) :: still
      type(geomagnetic_field_t) :: inner, outer
      real(wp) :: b(3)
      integer :: i
      orbits = [orbit_t(path_of(0.3_wp)), orbit_t(path_of(0.0_wp), inertial=.false.), orbit_t(path_of(0.0_wp))]
      do i = 1, size(orbits)
         call check_direction(error, earth_field_t(magnet, field_along(orbits(i))))
         call check_direction(error, moving_force_t(point, push_along(orbits(i))))
      end do
      still = orbit_t(path_of(0.0_wp), inertial=.true.)
      inner = field_along(orbits(2))
      outer = field_along(still)
      b = rotate_to_space(still%path%axes(700.0_wp), inner%at(700.0_wp))
      call check_close(error, b, outer%at(700.0_wp), 8*eps*norm2(b), "both axes")
   end subroutine parts_belong_together

   !> The series against n, ∂V/∂t against differences.
   subroutine check_direction(error, potential)
      type(error_type), allocatable, intent(inout) :: error
      class(potential_t), intent(in) :: potential
      real(wp), parameter :: t = 900.0_wp, unit = 256.0_wp, h = 1.0_wp
      real(wp) :: n(3, 0:20), total(3), q(4), difference
      type(status_t) :: status
      integer :: k
      call potential%direction_series(t, unit, n)
      total = 0.0_wp
      do k = 20, 0, -1
         total = 0.5_wp*total + n(:, k)
      end do
      call check_close(error, total, potential%direction_at(t + 0.5_wp*unit), 64*eps*norm2(total), "series")
      call quat_from_axis_angle([1.0_wp, 2.0_wp, 3.0_wp], 1.0_wp, q, status)
      difference = (potential%energy(rotate_to_body(q, potential%direction_at(t + h))) - &
                    potential%energy(rotate_to_body(q, potential%direction_at(t - h))))/(2*h)
      call check_close(error, potential%power(q, t), difference, 1e-5_wp*abs(difference), "power")
      call check(error, norm2(n(:, 1)) <= 3*unit*potential%pace*norm2(n(:, 0)), "pace")
   end subroutine check_direction

   !> A circular orbit whose plane the sun lies in is in the dark for 2 asin(R/a)/n, about the middle of the far side;
   !> the rate is the depth's, on an ellipse too.
   subroutine shadow(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 0.01_wp
      type(orbit_t) :: orbit
      real(wp) :: n, half, t, rate
      integer :: i
      orbit = orbit_t(kepler_orbit_t(semi_major_axis=7e6_wp, mu=earth_mu))
      call check(error, .not. orbit%has_sun(), "no sun")
      orbit%sun = [1.0_wp, 0.0_wp, 0.0_wp]
      n = orbit%path%mean_motion()
      half = asin(orbit%shadow_radius/7e6_wp)
      do i = -1, 1, 2
         call check_close(error, orbit%shadow_depth((pi + i*half)/n), 0.0_wp, 1e-6_wp, "edge")
         call check(error, orbit%shadow_depth((pi + 0.99_wp*i*half)/n) > 0.0_wp, "dark")
         call check(error, orbit%shadow_depth((pi + 1.01_wp*i*half)/n) < 0.0_wp, "light")
      end do
      call check_close(error, orbit%shadow_depth(pi/n), orbit%shadow_radius, 1e-6_wp, "middle")
      orbit%path = path_of(0.3_wp)
      orbit%sun = [0.36_wp, 0.48_wp, -0.8_wp]
      do i = 0, 20
         t = 400.0_wp*i
         rate = (orbit%shadow_depth(t + h) - orbit%shadow_depth(t - h))/(2*h)
         call check_close(error, shadow_rate(orbit, t), rate, 1e-2_wp, "rate")
      end do
   end subroutine shadow

end submodule test_orbit_fields
