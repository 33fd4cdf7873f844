!> Bodies on orbits: Kepler's ellipse, the axes of an orbit, and the gravity gradient on a circular one against what is
!> known of stability.
submodule(suites_of_effects) test_orbit
   use nutate_attitude, only: quat_from_roll_pitch_yaw, roll_pitch_yaw_from_quat
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kepler_orbit, only: eccentric_anomaly, kepler_orbit_t, n_elements, axes_change, position_change, &
      turn_rate_change, mean_motion_change
   use nutate_kinds, only: wp, eps, pi
   use nutate_orbit, only: earth_mu, orbit_t
   use nutate_quaternion, only: quat_conjugate, quat_exp, quat_product, rotate_to_body, rotate_to_space
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_orbit_reference, only: period, satellite, stable, unstable, wide
   use test_problems, only: angular_velocity, conserved_energy, frame_rate_of, make_state, new_problem, problem_t, &
      total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest, random_unit_quaternion
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none

   real(wp), parameter :: degree = pi/180

contains

   module procedure collect_orbit
      testsuite = [ &
                  new_unittest("Kepler's equation is solved to round-off", kepler_equation), &
                  new_unittest("places on an ellipse, to 13 digits", places), &
                  new_unittest("power series of the pull sum up to it, on ellipses and by the periapsis", pulls), &
                  new_unittest("changes of elements are the derivatives of place, axes and rate", changes), &
                  new_unittest("axes, rates and velocities of an orbit belong together", axes_and_rates), &
                  new_unittest("roll, pitch and yaw there and back", roll_pitch_yaw), &
                  new_unittest("Lagrange's region is stable", lagrange_region), &
                  new_unittest("outside of it a satellite turns over at the rate of theory", growth_outside), &
                  new_unittest("spinning satellites keep three attitudes", kept_attitudes), &
                  new_unittest("and leave two others at the rates of theory", left_attitudes), &
                  new_unittest("a free body is the same in both axes of an orbit", both_frames), &
                  new_unittest("a scene without direction takes the orbit's", direction_of_orbit), &
                  new_unittest("an orbit takes the place of another", orbit_replaced)]
   end procedure collect_orbit

   !> `E - e sin E - M` is a rounding of M, at any time and eccentricity.
   subroutine kepler_equation(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: shapes(6) = [0.0_wp, 1e-8_wp, 0.3_wp, 0.9_wp, 0.999_wp, 1 - 2*eps]
      real(wp) :: mean, e
      integer :: i, k
      do i = 1, size(shapes)
         do k = -40, 40
            mean = k*0.25_wp
            if (abs(k) < 8) mean = sign(0.1_wp**abs(k), real(k, wp))
            e = eccentric_anomaly(mean, shapes(i))
            call check_close(error, e - shapes(i)*sin(e), mean, 3*eps*(1 + abs(mean)), "M")
         end do
         ! A multiple of π is its own eccentric anomaly.
         call check_close(error, eccentric_anomaly(3*pi, shapes(i)), 3*pi, 8*eps, "apogee")
      end do
      ! Near the periapsis E is M/(1 - e), to all digits however small it is.
      do k = 9, 14
         mean = 0.1_wp**k
         call check_close(error, 0.7_wp*eccentric_anomaly(mean, 0.3_wp)/mean, 1.0_wp, 8*eps, "periapsis")
      end do
   end subroutine kepler_equation

   type(kepler_orbit_t) function inclined_ellipse() result(path)
      path = kepler_orbit_t(semi_major_axis=1e7_wp, eccentricity=0.3_wp, mu=earth_mu, inclination=60*degree, &
                            raan=30*degree, argument_of_periapsis=45*degree)
   end function inclined_ellipse

   subroutine places(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: times(5) = [0.0_wp, 1000.0_wp, 5000.0_wp, 10000.0_wp, 50000.0_wp]
      real(wp), parameter :: expected(3, 5) = reshape([ &
         3049170.1827941035041_wp, 4618177.2590881971713_wp, 4286607.0498705616718_wp, &
         -4156565.9146296816584_wp, 1991284.3686653052685_wp, 6586618.2275717624981_wp, &
         -5574732.2982575910209_wp, -8570902.0074534795451_wp, -8028493.2215915373958_wp, &
         2719427.2571622835723_wp, 4592453.5364648668895_wp, 4533587.2162509252296_wp, &
         1337134.762848616858_wp, 4368613.6314037346923_wp, 5394927.7741954190121_wp], [3, 5])
      type(kepler_orbit_t) :: path
      integer :: i
      path = inclined_ellipse()
      do i = 1, size(times)
         ! The mean anomaly is known to a rounding of itself; next to the periapsis the place is half again as
         ! sensitive.
         call check_close(error, path%position(times(i))/1e7_wp, expected(:, i)/1e7_wp, &
                          eps*(8 + 4*path%mean_motion()*times(i)), "place")
         call check_close(error, path%radius(times(i)), norm2(path%position(times(i))), 1e7_wp*8*eps, "radius")
      end do
   end subroutine places

   !> Compares sums of the series of x (x·x)^b, over a fifth of the time scale of the periapsis, with positions; and the
   !> coefficients of an ellipse with those of the same orbit given by its periapsis, which has another recurrence. The
   !> mean anomaly is known to a rounding of itself, by which the place errs (1 + e)/(1 - e) times as much at most.
   subroutine pulls(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: order = 26
      real(wp), parameter :: shapes(4) = [0.0_wp, 0.02_wp, 0.3_wp, 0.9_wp], powers(2) = [-1.25_wp, -7.0_wp/6]
      type(kepler_orbit_t) :: ellipse, conic
      real(wp) :: n(3, 0:order), other(3, 0:order), sum(3), x(3), distance, other_distance, unit, t, bound
      integer :: i, j, k
      do i = 1, size(shapes)
         ellipse = kepler_orbit_t(semi_major_axis=1.3_wp, eccentricity=shapes(i), mu=1.7_wp, inclination=0.6_wp, &
                                  raan=-0.9_wp, argument_of_periapsis=0.5_wp)
         conic = ellipse
         conic%periapsis_distance = 1.3_wp*(1 - shapes(i))
         unit = 0.2_wp*(1 - shapes(i))**1.5_wp/ellipse%mean_motion()
         bound = 100*eps*(1 + shapes(i))/(1 - shapes(i))
         do j = -2, 5
            t = 0.7_wp*j
            do k = 1, size(powers)
               call ellipse%pull_series(powers(k), t, unit, n, distance)
               call conic%pull_series(powers(k), t, unit, other, other_distance)
               call check_close(error, distance, norm2(ellipse%position(t)), bound, 'distance')
               call check_below(error, maxval(abs(n - other)), bound, 'coefficients by the periapsis')
               sum = sum_of(n)
               x = ellipse%position(t + unit)/distance
               call check_below(error, maxval(abs(sum - x*dot_product(x, x)**powers(k))), bound, 'sum')
            end do
         end do
      end do

   contains

      !> The smallest terms are added first.
      pure function sum_of(terms) result(total)
         real(wp), intent(in) :: terms(:, :)
         real(wp) :: total(3)
         integer :: l
         total = 0.0_wp
         do l = size(terms, 2), 1, -1
            total = total + terms(:, l)
         end do
      end function sum_of

   end subroutine pulls

   !> Compares with differences of 1 and ½ of a step, extrapolated: ellipses and all conics, also next to a parabola,
   !> before the periapsis, after several revolutions, on a circle.
   subroutine changes(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: shapes(9) = [0.01_wp, 0.4_wp, 0.8_wp, 0.01_wp, 0.5_wp, 0.98_wp, 1.0_wp, 1.03_wp, 3.0_wp]
      real(wp), parameter :: times(5) = [-11.0_wp, -0.4_wp, 0.3_wp, 2.0_wp, 17.0_wp]
      type(kepler_orbit_t) :: path
      real(wp) :: change(n_elements), found(7), wanted(7)
      integer :: i, j, k
      do i = 1, size(shapes)
         path = kepler_orbit_t(eccentricity=shapes(i), mu=1.7_wp, inclination=0.6_wp, raan=-0.9_wp, &
                               argument_of_periapsis=0.5_wp)
         if (i <= 3) then
            path%semi_major_axis = 1.3_wp
            path%mean_anomaly = 0.7_wp
         else
            path%periapsis_distance = 1.1_wp
            path%periapsis_time = 0.2_wp
         end if
         do j = 1, size(times)
            do k = 1, n_elements
               change = 0.0_wp
               change(k) = 1.0_wp
               found = [position_change(path, change, times(j)), axes_change(path, change, times(j)), &
                        turn_rate_change(path, change, times(j))]
               wanted = (4*slope(0.5e-4_wp) - slope(1e-4_wp))/3
               call check_below(error, maxval(abs(found - wanted))/max(1.0_wp, maxval(abs(wanted))), 1e-9_wp, 'change')
               found(1) = mean_motion_change(path, change)
               call check_below(error, abs(found(1) - (4*rise(0.5e-4_wp) - rise(1e-4_wp))/3), 1e-9_wp, 'mean motion')
            end do
         end do
      end do

   contains

      type(kepler_orbit_t) function moved(part)
         real(wp), intent(in) :: part
         moved = path
         call moved%shift(part*change)
      end function moved

      function slope(h) result(difference)
         real(wp), intent(in) :: h
         real(wp) :: difference(7), turn(4)
         type(kepler_orbit_t) :: more, less
         more = moved(h)
         less = moved(-h)
         turn = quat_product(more%axes(times(j)), quat_conjugate(less%axes(times(j))))
         difference(1:3) = (more%position(times(j)) - less%position(times(j)))/(2*h)
         difference(4:6) = turn(2:4)/h
         difference(7) = (more%turn_rate(times(j)) - less%turn_rate(times(j)))/(2*h)
      end function slope

      real(wp) function rise(h)
         real(wp), intent(in) :: h
         type(kepler_orbit_t) :: more, less
         more = moved(h)
         less = moved(-h)
         rise = 0.0_wp
         ! Mean motion has a kink at the parabola.
         if (abs(path%eccentricity - 1) > h) rise = (more%mean_motion() - less%mean_motion())/(2*h)
      end function rise

   end subroutine changes

   !> z points to the centre, y against the orbit's normal; the axes turn at ν̇ about y, and nothing jumps in three
   !> revolutions.
   subroutine axes_and_rates(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1e-2_wp
      type(kepler_orbit_t) :: path
      type(orbit_t) :: orbit
      real(wp) :: t, q(4), before(4), after(4), r(3), v(3), rate(3)
      integer :: i
      path = inclined_ellipse()
      path%mean_anomaly = 4.0_wp
      orbit = orbit_t(path)
      call check(error, .not. orbit%is_frame, "the axes of an ellipse do not turn evenly")
      do i = -30, 30
         t = 1000.0_wp*i
         q = orbit%axes(t)
         r = path%position(t)/path%radius(t)
         v = path%velocity(t)
         call check_close(error, rotate_to_space(q, [0.0_wp, 0.0_wp, 1.0_wp]), -r, 32*eps, "z")
         call check_close(error, rotate_to_body(q, v - dot_product(v, r)*r)/norm2(v), &
                          [norm2(v - dot_product(v, r)*r)/norm2(v), 0.0_wp, 0.0_wp], 64*eps, "x")
         call check_close(error, v, (path%position(t + h) - path%position(t - h))/(2*h), 1e-3_wp, "velocity")
         before = orbit%axes(t - h)
         after = orbit%axes(t + h)
         ! q̇ = ½ω∘q.
         rate = orbit%axes_rate(t)
         call check_close(error, (after - before)/(2*h), 0.5_wp*quat_product([0.0_wp, rate], q), 1e-12_wp, "rate")
         call check_close(error, (path%true_anomaly(t + h) - path%true_anomaly(t - h))/(2*h), path%turn_rate(t), &
                          1e-12_wp, "rate of the true anomaly")
      end do
      t = 3*2*pi/path%mean_motion()
      call check_close(error, path%true_anomaly(t) - path%true_anomaly(0.0_wp), 6*pi, 64*eps, "three revolutions")
   end subroutine axes_and_rates

   subroutine roll_pitch_yaw(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: x(3) = [1.0_wp, 0.0_wp, 0.0_wp], y(3) = [0.0_wp, 1.0_wp, 0.0_wp]
      real(wp), parameter :: z(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      real(wp) :: q(4), again(4), angles(3)
      integer(int64) :: seed
      integer :: i
      q = quat_product(quat_product(quat_exp(0.15_wp*z), quat_exp(-0.35_wp*y)), quat_exp(0.2_wp*x))
      call check_close(error, quat_from_roll_pitch_yaw([0.4_wp, -0.7_wp, 0.3_wp]), q, 4*eps, "order of the turns")
      seed = 5
      do i = 1, 200
         q = random_unit_quaternion(seed)
         ! Twice the length: the angles are those of its direction.
         angles = roll_pitch_yaw_from_quat(2*q)
         again = quat_from_roll_pitch_yaw(angles)
         call check_close(error, sign(1.0_wp, dot_product(q, again))*again, q, 16*eps, "there and back")
         call check(error, abs(angles(2)) <= 0.5_wp*pi .and. all(abs(angles) <= pi), "ranges")
      end do
      do i = -1, 1, 2
         q = quat_from_roll_pitch_yaw([0.4_wp, i*0.5_wp*pi, 0.9_wp])
         angles = roll_pitch_yaw_from_quat(q)
         call check_close(error, angles, [0.0_wp, i*0.5_wp*pi, 0.9_wp - i*0.4_wp], 8*eps, "at the pole")
      end do
      do i = 1, 200
         q = quat_from_roll_pitch_yaw([1.3_wp + i, (-1)**i*(0.5_wp*pi - 10.0_wp**(-0.07_wp*i)), 0.9_wp - 2*i])
         again = quat_from_roll_pitch_yaw(roll_pitch_yaw_from_quat(q))
         call check_close(error, sign(1.0_wp, dot_product(q, again))*again, q, 8*eps, "near the pole")
      end do
   end subroutine roll_pitch_yaw

   !> 2000 revolutions in steps of a twentieth: the attitude stays, the Jacobi integral keeps 13 digits of T + V.
   subroutine lagrange_region(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: start, size, widest
      integer :: i
      problem => satellite(stable, wide)
      state = problem%start
      start = conserved_energy(problem%system, state)
      size = total_energy(problem%system, state)
      widest = 0.0_wp
      do i = 1, 100
         call integrate(problem%system, integrator_settings_t(formulation='reduced'), state, &
                        run_plan_t(time_step=period/20, end_time=i*20*period), status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, conserved_energy(problem%system, state), start, 1e-13_wp*size, "H - omega.l")
         widest = max(widest, maxval(abs(roll_pitch_yaw_from_quat(state%q))))
      end do
      call check_below(error, widest, 0.4_wp, "widest angle")
   end subroutine lagrange_region

   !> Roll and yaw of the unstable satellite grow by exp(0.4411168 n t), as long as they are small.
   subroutine growth_outside(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: yaw(2), angles(3)
      integer :: i
      problem => satellite(unstable, [0.0_wp, 0.0_wp, 1e-9_wp])
      state = problem%start
      do i = 1, 2
         call integrate(problem%system, integrator_settings_t(order=4, formulation='reduced'), state, &
                        run_plan_t(time_step=period/50, end_time=(1 + 2*i)*period), status)
         call check(error, status%ok(), trim(status%message))
         angles = roll_pitch_yaw_from_quat(state%q)
         yaw(i) = angles(3)
      end do
      call check_close(error, log(yaw(2)/yaw(1))/(4*pi), 0.44111679203868311606_wp, 0.01_wp*0.44_wp, "rate of growth")
   end subroutine growth_outside

   !> A symmetric satellite that spins about its axis 3, in an attitude of Likins and Pringle: the axis at rest in those
   !> of the orbit, but for a turn of `off` about x and z.
   function spinning_satellite(transverse, axial, axis, momentum, off) result(problem)
      real(wp), intent(in) :: transverse, axial
      !> Direction of the axis, LVLH frame; shape (3); L3, N m s.
      real(wp), intent(in) :: axis(3), momentum
      real(wp), intent(in) :: off
      type(problem_t), pointer :: problem
      real(wp) :: q(4), rate(3)
      problem => satellite([transverse, transverse, axial], [0.0_wp, 0.0_wp, 0.0_wp])
      ! Half a turn about the line between z and the axis.
      q = [0.0_wp, axis + [0.0_wp, 0.0_wp, 1.0_wp]]
      q = q/norm2(q)
      rate = frame_rate_of(problem%system%effects, q)
      rate(3) = momentum/axial
      q = quat_product(quat_exp(0.5_wp*off*[1.0_wp, 0.0_wp, 1.0_wp]), q)
      problem%start = make_state(problem%system, q, rate)
   end function spinning_satellite

   !> Distances of the axis 3 from where it was meant to be, at times that `orbits` revolutions lie between.
   subroutine follow_axis(error, problem, axis, first, orbits, far)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      !> Shape (3).
      real(wp), intent(in) :: axis(3)
      !> Revolutions until the first.
      real(wp), intent(in) :: first, orbits
      !> Shape (any).
      real(wp), intent(out) :: far(:)
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      state = problem%start
      do i = 1, size(far)
         call integrate(problem%system, integrator_settings_t(method='taylor', conserve=.true.), state, &
                        run_plan_t(goal=run_goal_t(local_tolerance=1e-15_wp), &
                                   end_time=(first + (i - 1)*orbits)*period), status)
         call check(error, status%ok(), trim(status%message))
         far(i) = norm2(rotate_to_space(state%q, [0.0_wp, 0.0_wp, 1.0_wp]) - axis)
      end do
   end subroutine follow_axis

   !> Cylindrical, hyperbolic and conical: none goes farther than some times the start.
   subroutine kept_attitudes(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: axes(3, 3) = reshape([0.0_wp, -1.0_wp, 0.0_wp, 0.6_wp, -0.8_wp, 0.0_wp, &
                                                   0.0_wp, -0.8_wp, 0.6_wp], [3, 3])
      real(wp), parameter :: moments(2, 3) = reshape([100.0_wp, 40.0_wp, 60.0_wp, 100.0_wp, 100.0_wp, 40.0_wp], [2, 3])
      real(wp), parameter :: momenta(3) = [0.44271337853397623223_wp, 0.053125605424077147867_wp, &
                                           0.24791949197902669005_wp]
      real(wp) :: far(50)
      integer :: i
      do i = 1, 3
         call follow_axis(error, spinning_satellite(moments(1, i), moments(2, i), axes(:, i), momenta(i), 1e-6_wp), &
                          axes(:, i), 0.37_wp, 0.37_wp, far)
         call check_below(error, maxval(far), 2e-5_wp, "distance")
      end do
   end subroutine kept_attitudes

   !> Checks growth by exp(σnt): σ = 1.13968777 of the hyperbolic rod; 0.71149685 of the slow cylindrical one, which
   !> swings, so that it is measured over one of its swings.
   subroutine left_attitudes(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: hyperbolic(3) = [0.6_wp, -0.8_wp, 0.0_wp], cylindrical(3) = [0.0_wp, -1.0_wp, 0.0_wp]
      real(wp), parameter :: momentum = 0.088542675706795246445_wp, swing = 1/0.35528547115923_wp
      real(wp) :: far(2)
      call follow_axis(error, spinning_satellite(100.0_wp, 40.0_wp, hyperbolic, momentum, 1e-9_wp), hyperbolic, &
                       1.0_wp, 1.0_wp, far)
      call check_close(error, log(far(2)/far(1))/(2*pi), 1.1396877652102_wp, 0.0114_wp, "hyperbolic rod")
      call follow_axis(error, spinning_satellite(100.0_wp, 40.0_wp, cylindrical, momentum, 1e-9_wp), cylindrical, &
                       0.75_wp, swing, far)
      call check_close(error, log(far(2)/far(1))/(2*pi*swing), 0.71149684891561_wp, 0.0071_wp, "slow rod")
   end subroutine left_attitudes

   !> The scene of a body on the circular orbit in axes of a kind.
   subroutine read_on_orbit(error, frame, rest, scene)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: frame, rest
      type(scene_t), intent(inout) :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene("&body inertia = 90, 100, 40 / &orbit semi_major_axis = 7e6, inclination = 50, raan = 200, "// &
                       "argument_of_periapsis = 20, mean_anomaly = 70, degrees = .true., frame = '"//frame//"' / "// &
                       "&initial roll_pitch_yaw = 5, -8, 10, degrees = .true., attitude_from = 'lvlh', "// &
                       "angular_velocity = 0.1, -0.2, 0.05, rate_from = 'lvlh' / "//rest, 'a.nml', scene, status, &
                       message)
      call check(error, status%ok(), message)
   end subroutine read_on_orbit

   !> Attitude and rate against the orbit, given and shown: the same motion.
   subroutine both_frames(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: rest = "&integrator method = 'taylor', local_tolerance = 1e-15, end_time = 9000 /"
      class(scene_t), allocatable :: scenes(:)
      type(state_t) :: states(2)
      type(status_t) :: status
      integer :: i
      allocate (scenes(2))
      call read_on_orbit(error, 'lvlh', rest, scenes(1))
      if (.not. allocated(error)) call read_on_orbit(error, 'inertial', rest, scenes(2))
      if (allocated(error)) return
      do i = 1, 2
         associate (scene => scenes(i))
            states(i) = scene%initial
            call integrate(scene%system, scene%integrator, states(i), scene%plan, status)
            call check(error, status%ok(), trim(status%message))
         end associate
      end do
      associate (orbit => scenes(2)%system%effects%orbit)
         call check_close(error, states(2)%q, quat_product(orbit%axes(9000.0_wp), states(1)%q), 1e-12_wp, "attitude")
      end associate
      call check_close(error, angular_velocity(scenes(2)%system, states(2)), &
                       angular_velocity(scenes(1)%system, states(1)), 1e-14_wp, "rate")
   end subroutine both_frames

   !> n² along z.
   subroutine direction_of_orbit(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      real(wp), parameter :: gamma(3) = [0.36_wp, 0.48_wp, 0.8_wp]
      real(wp) :: expected
      allocate (scene)
      call read_on_orbit(error, 'lvlh', "&gravity_gradient / &integrator time_step = 60, end_time = 600 /", scene)
      if (allocated(error)) return
      call check(error, scene%system%effects%n_potentials, 1)
      associate (potential => scene%system%effects%potentials(1)%item)
         expected = 1.5_wp*earth_mu/7e6_wp**3*dot_product(gamma, [90.0_wp, 100.0_wp, 40.0_wp]*gamma)
         call check_close(error, potential%energy(gamma), expected, 8*eps*expected, "energy")
         call check_close(error, potential%direction, [0.0_wp, 0.0_wp, 1.0_wp], 0.0_wp, "direction")
      end associate
   end subroutine direction_of_orbit

   !> Added by hand, the last orbit counts, with its rate; a list that is appended keeps it.
   subroutine orbit_replaced(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem, other
      type(orbit_t) :: orbit
      type(gravity_gradient_t) :: gradient
      other => new_problem()
      problem => satellite(stable, wide)
      orbit = orbit_t(kepler_orbit_t(semi_major_axis=8e6_wp, mu=earth_mu), inertial=.false.)
      call problem%system%effects%add(orbit)
      call check_close(error, problem%system%effects%frame_rate, orbit%rate, 1e-19_wp, "rate")
      call other%system%effects%append(problem%system%effects)
      call check_close(error, other%system%effects%frame_rate, orbit%rate, 1e-19_wp, "appended")
      call problem%system%effects%add(orbit_t(orbit%path))
      call check(error, .not. any(abs(problem%system%effects%frame_rate) > 1e-19_wp), "no rate in inertial axes")
      gradient = gravity_gradient_t(problem%system%body, orbit_t(orbit%path))
      call check(error, .not. gradient%is_valid(), "a constant gradient in inertial axes is not that of the orbit")
   end subroutine orbit_replaced

end submodule test_orbit
