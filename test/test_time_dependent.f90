!> Gravity gradients along an orbit, seen from inertial axes: against values of 20 digits, the account with the work of
!> time-dependent potentials, and the same motion as in the LVLH frame.
module test_time_dependent
   use nutate_attitude, only: quat_from_axis_angle
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, eps, pi
   use nutate_methods, only: integrator_settings_t, make_stepper, methods, stepper_t
   use nutate_orbit, only: earth_mu, orbit_t
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_quaternion, only: quat_product, rotate_to_body
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate, observer_t, run_record_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_problems, only: angular_velocity, make_state, new_problem, potential_energy, problem_t, space_momentum, &
      system_t, time_dependent_power, total_energy
   use test_resume, only: settings_of
   use test_support, only: check, check_below, check_close, error_type, in_turn, new_unittest, one_in, &
                           random_unit_quaternion, unittest_type
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none
   private

   public :: collect_time_dependent, make_moon

   real(wp), parameter :: degree = pi/180
   !> Times, s, and q and Ω, rad/s, of the satellite on an ellipse: 20 digits, by extrapolation in quadruple precision.
   real(wp), parameter :: times(5) = [1000.0_wp, 5000.0_wp, 10000.0_wp, 20000.0_wp, 50000.0_wp]
   real(wp), parameter :: attitudes(4, 5) = reshape([ &
      0.67068305661762240558_wp, 0.55859542853096831903_wp, -0.15041683994550873965_wp, 0.46425225799252088292_wp, &
      0.029982256775036825909_wp, -0.12924393494468285792_wp, -0.050216414292221880346_wp, -0.98988654970876449304_wp, &
      -0.87779836196552909281_wp, 0.035165844952236215231_wp, -0.40249388875519937442_wp, -0.25735591812535891441_wp, &
      0.42812082675171797841_wp, 0.71720862104416005171_wp, -0.36914231031657241862_wp, 0.4075025231032358299_wp, &
      -0.0088611905818959125769_wp, 0.41706902727400034488_wp, 0.89779285859953323048_wp, -0.1412192934335425938_wp], &
                                                [4, 5])
   real(wp), parameter :: rates(3, 5) = reshape([ &
      0.00032274874683223567589_wp, -0.000654403973458539362_wp, 0.0011561445849172954335_wp, &
      -0.0010351871995929757219_wp, 0.00060270717291061999531_wp, 0.0012443102778176148766_wp, &
      0.00023253943919053571902_wp, -0.00026821537691597555755_wp, 0.0012920406194956267227_wp, &
      -0.00029123795511169615314_wp, 0.0001872349159996603103_wp, 0.0014099745675024808708_wp, &
      -0.0017012500783921389602_wp, -0.00046571844457511395728_wp, 0.0010979564124190652767_wp], [3, 5])
   !> Moons in the plane: revolutions, θ, θ̇, and how much errors of the start have grown; ten for each.
   real(wp), parameter :: planar(4, 30) = reshape([ &
      0.25_wp, 1.240707286935387765582_wp, 1.058838912462976548557_wp, 1.488_wp, &
      1.0_wp, 6.222266171084901159337_wp, 0.5534946516796222855675_wp, 1.482_wp, &
      2.0_wp, 12.5737168349647843525_wp, 0.5051005667659636504258_wp, 1.423_wp, &
      3.0_wp, 18.90924885507001745003_wp, 0.5644476225521458670129_wp, 1.486_wp, &
      5.0_wp, 31.35675085601173226508_wp, 0.5423385856063427880472_wp, 1.476_wp, &
      7.0_wp, 44.03790827298545248242_wp, 0.5745659201422366389671_wp, 1.485_wp, &
      10.0_wp, 62.86627164726066375879_wp, 0.5131032653977770794089_wp, 1.45_wp, &
      15.0_wp, 94.28747444708484902986_wp, 0.5903708991825718244726_wp, 1.458_wp, &
      20.0_wp, 125.6090543116321183413_wp, 0.5761527579844762003538_wp, 1.488_wp, &
      30.0_wp, 188.5556635390369396994_wp, 0.5626403191489905660677_wp, 1.49_wp, &
      0.25_wp, 3.252895021381732321419_wp, 1.821598173457027582382_wp, 2.126_wp, &
      1.0_wp, 12.65821769688940180456_wp, 2.315064392116929710984_wp, 11.47_wp, &
      2.0_wp, 25.05870733477037109029_wp, 2.314530378635434199531_wp, 9.717_wp, &
      3.0_wp, 37.66962071808668777679_wp, 2.328865587932419294689_wp, 2.965_wp, &
      5.0_wp, 62.79027323587131337944_wp, 2.315135926250322935072_wp, 5.875_wp, &
      7.0_wp, 88.04484672976647895407_wp, 2.321466900978843036689_wp, 8.868_wp, &
      10.0_wp, 125.7214202918583745338_wp, 2.325673928527090946454_wp, 6.093_wp, &
      15.0_wp, 188.4035023937671909101_wp, 2.315097748562868381708_wp, 11.63_wp, &
      20.0_wp, 251.420722151220595992_wp, 2.317438570004454826468_wp, 11.12_wp, &
      30.0_wp, 377.0639739994174207542_wp, 2.31454276902016419406_wp, 8.76_wp, &
      0.25_wp, 2.656009165878093507716_wp, 1.499772587938936747991_wp, 2.113_wp, &
      1.0_wp, 9.723353941314001040585_wp, 1.499652609428492036027_wp, 6.437_wp, &
      2.0_wp, 19.14453006737395869966_wp, 1.499307939769129230057_wp, 12.6_wp, &
      3.0_wp, 28.56355151351628160404_wp, 1.498968219643767500196_wp, 18.73_wp, &
      5.0_wp, 47.39529333388889538076_wp, 1.498312572315243651951_wp, 30.62_wp, &
      7.0_wp, 66.21904707540155582413_wp, 1.497703604651354344252_wp, 41.71_wp, &
      10.0_wp, 94.44128164447645895757_wp, 1.496916587504581703553_wp, 56.12_wp, &
      15.0_wp, 141.451358678463502198_wp, 1.496077797946556660736_wp, 71.68_wp, &
      20.0_wp, 188.4463766315799974059_wp, 1.495983033881155535412_wp, 73.79_wp, &
      30.0_wp, 282.4865232494803573157_wp, 1.497939855277459801867_wp, 38.99_wp], [4, 30])

   !> Watches an account: the largest departure of total - work from its first value.
   type, extends(observer_t) :: account_t
      logical :: started = .false.
      real(wp) :: first = 0.0_wp, worst = 0.0_wp, scale = 0.0_wp, power = 0.0_wp
   contains
      procedure :: observe => watch_account
   end type account_t

contains

   subroutine collect_time_dependent(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("direction, power and series of a gradient that moves", parts_belong_together), &
                  new_unittest("an elliptic orbit by the series", ellipse_by_series), &
                  new_unittest("an elliptic orbit by order 8", ellipse_by_order_8), &
                  new_unittest("an elliptic orbit by dop853", ellipse_by_dop853), &
                  new_unittest("Hyperion and Mercury", moons), &
                  new_unittest("Hyperion's chaos: errors grow e-fold in 1.3 to 1.4 revolutions", lyapunov_time), &
                  new_unittest("a circular orbit is the same in its own axes", both_axes), &
                  new_unittest("every method steps in the LVLH frame", every_method_in_lvlh), &
                  new_unittest("the work of time-dependent potentials is its power summed up", &
                  work_is_integrated_power), &
                  new_unittest("the account closes in every form, at every order", account_closes), &
                  new_unittest("the account closes where times have few digits left", account_closes_late), &
                  new_unittest("orders 2, 4 and 6", orders)]
   end subroutine collect_time_dependent

   subroutine watch_account(self, system, state, record, status)
      class(account_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      real(wp) :: rest
      rest = total_energy(system, state) - record%work
      if (.not. self%started) self%first = rest
      self%started = .true.
      self%worst = max(self%worst, abs(rest - self%first))
      self%scale = max(self%scale, abs(total_energy(system, state)), abs(record%work))
      self%power = max(self%power, abs(time_dependent_power(system%effects, state%q, state%t)))
   end subroutine watch_account

   type(kepler_orbit_t) function ellipse() result(path)
      path = kepler_orbit_t(semi_major_axis=1e7_wp, eccentricity=0.3_wp, mu=earth_mu, inclination=60*degree, &
                            raan=30*degree, argument_of_periapsis=45*degree)
   end function ellipse

   !> The satellite on the ellipse.
   function satellite() result(problem)
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: q(4)
      problem => new_problem()
      call make_body(diagonal([90.0_wp, 100.0_wp, 40.0_wp]), problem%system%body, status)
      call problem%system%effects%add(orbit_t(ellipse()))
      call problem%system%effects%add(orbital_gradient_t(problem%system%body, ellipse()))
      call quat_from_axis_angle([1.0_wp, 1.0_wp, 1.0_wp], 40*degree, q, status)
      problem%start = make_state(problem%system, q, [1e-3_wp, -5e-4_wp, 8e-4_wp])
   end function satellite

   !> n against its definition, ∂V/∂t against differences, the series against n.
   subroutine parts_belong_together(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1.0_wp, unit = 256.0_wp
      type(problem_t), pointer :: problem
      type(orbital_gradient_t) :: gradient
      real(wp) :: q(4), r(3), n(3), series(3, 0:24), difference, t
      integer(int64) :: seed
      integer :: i, k
      problem => satellite()
      gradient = orbital_gradient_t(problem%system%body, ellipse())
      seed = 3
      do i = 0, 8
         t = 1200.0_wp*i
         q = random_unit_quaternion(seed)
         r = gradient%path%position(t)
         n = rotate_to_body(q, r/norm2(r))
         associate (energy => potential_energy(problem%system%effects, q, t))
            call check_close(error, energy, 1.5_wp*earth_mu/norm2(r)**3* &
                             dot_product(n, [90.0_wp, 100.0_wp, 40.0_wp]*n), 16*eps*energy, "energy")
            ! The difference is of second order in h n = 6e-4.
            difference = (potential_energy(problem%system%effects, q, t + h) &
                          - potential_energy(problem%system%effects, q, t - h))/(2*h)
            call check_close(error, time_dependent_power(problem%system%effects, q, t), difference, 3e-9_wp*energy, &
                             "power")
         end associate
         call gradient%direction_series(t, unit, series)
         n = series(:, 24)
         do k = 23, 0, -1
            n = 0.5_wp*n + series(:, k)
         end do
         call check_close(error, n/1e-3_wp, gradient%direction_at(t + 0.5_wp*unit)/1e-3_wp, 64*eps, "series")
      end do
   end subroutine parts_belong_together

   !> Runs the satellite to each of the times; errors of the start have grown by 1.9e3 at the last.
   subroutine check_ellipse(error, settings, plan, last)
      type(error_type), allocatable, intent(inout) :: error
      type(integrator_settings_t), intent(in) :: settings
      !> Without its end.
      type(run_plan_t), intent(in) :: plan
      !> Bound for the last time; default that of the others.
      real(wp), intent(in), optional :: last
      type(run_plan_t) :: whole
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(account_t) :: account
      type(status_t) :: status
      real(wp) :: bound
      integer :: i
      problem => satellite()
      whole = plan
      bound = 1e-11_wp
      do i = 1, size(times)
         state = problem%start
         if (i == size(times)) then
            if (present(last)) bound = last
         end if
         whole%end_time = times(i)
         account%started = .false.
         call integrate(problem%system, settings, state, whole, status, observer=account)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, state%q, attitudes(:, i), bound, "attitude")
         call check_close(error, angular_velocity(problem%system, state)/1e-3_wp, rates(:, i)/1e-3_wp, bound, "rate")
      end do
      call check_below(error, account%worst, 64*eps*account%scale, "account")
   end subroutine check_ellipse

   subroutine ellipse_by_series(error)
      type(error_type), allocatable, intent(out) :: error
      call check_ellipse(error, integrator_settings_t(method='taylor', conserve=.true.), &
                         run_plan_t(goal=run_goal_t(local_tolerance=1e-16_wp)))
   end subroutine ellipse_by_series

   subroutine ellipse_by_order_8(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t) :: plan
      plan%time_step = 25.0_wp
      call check_ellipse(error, integrator_settings_t(order=8, formulation='reduced'), plan)
      call check_ellipse(error, integrator_settings_t(order=8), plan)
   end subroutine ellipse_by_order_8

   subroutine ellipse_by_dop853(error)
      type(error_type), allocatable, intent(out) :: error
      type(run_plan_t) :: plan
      plan%time_step = 20.0_wp
      ! Roundings of 2500 steps without compensation, grown.
      call check_ellipse(error, integrator_settings_t(method='dop853', conserve=.true.), plan, last=128*eps*1.9e3_wp)
   end subroutine ellipse_by_dop853

   !> Moons on ellipses in the plane, semi-major axis and mean motion 1, axis 1 at θ from the periapsis's.
   subroutine moons(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: moments(3, 3) = reshape([ &
         0.5_wp, 0.5_wp + 0.7921_wp/3, 1.0_wp, 0.6_wp, 0.6_wp + 0.7921_wp/3, 1.0_wp, 0.9998_wp, 0.9999_wp, 1.0_wp], &
                                                [3, 3])
      real(wp), parameter :: shapes(3) = [0.1_wp, 0.1_wp, 0.20563_wp]
      real(wp), parameter :: starts(2, 3) = reshape([0.0_wp, 0.6_wp, 0.0_wp, 2.33_wp, 0.3_wp, 1.5_wp], [2, 3])
      type(problem_t), pointer :: problem
      !> The motions by both methods, which go on from one row to the next.
      type(state_t) :: states(2)
      integer :: i, k, moon
      moon = 0
      problem => new_problem()
      do k = 1, size(planar, 2)
         i = (k + 9)/10
         if (.not. in_turn(k)) cycle
         if (i /= moon) then
            call make_moon(moments(:, i), shapes(i), starts(:, i), problem)
            states = problem%start
            moon = i
         end if
         call compare(integrator_settings_t(method='taylor', conserve=.true.), &
                      run_plan_t(goal=run_goal_t(local_tolerance=1e-16_wp)), states(1))
         if (.not. allocated(error)) call compare(integrator_settings_t(order=8, formulation='reduced'), &
                                                  run_plan_t(time_step=2*pi/100), states(2))
      end do

   contains

      subroutine compare(settings, plan, state)
         type(integrator_settings_t), intent(in) :: settings
         !> Without its end.
         type(run_plan_t), intent(in) :: plan
         type(state_t), intent(inout) :: state
         type(run_plan_t) :: whole
         type(status_t) :: status
         real(wp) :: half
         whole = plan
         whole%end_time = 2*pi*planar(1, k)
         call integrate(problem%system, settings, state, whole, status)
         call check(error, status%ok(), trim(status%message))
         half = 0.5_wp*planar(2, k)
         call check_close(error, state%q, [cos(half), 0.0_wp, 0.0_wp, sin(half)], 1e-11_wp, "angle")
         call check_close(error, angular_velocity(problem%system, state), [0.0_wp, 0.0_wp, planar(3, k)], 1e-11_wp, &
                          "rate")
      end subroutine compare

   end subroutine moons

   !> The median of nine motions. One may stick to the regular motions beside it for hundreds of revolutions; over
   !> 40 000 the mean comes to 1.32 to 1.46 revolutions by the start, from θ = 0, θ' = 1 to 1.342, 1.291 and 1.340 with
   !> local tolerances of 1e-12, 1e-10 and 1e-9: its sampling error is 0.03.
   subroutine lyapunov_time(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: times(9)
      integer :: i, n
      n = merge(5, 9, one_in() > 3)
      do i = 1, n
         call grow(error, 1 + 1e-3_wp*(i - 1), times(i))
         if (allocated(error)) return
      end do
      ! The median is compared: as many values are longer as are shorter.
      do i = 1, n
         if (count(times(:n) < times(i)) == n/2) call check_close(error, times(i), 1.35_wp, 0.1_wp, "revolutions")
      end do
   end subroutine lyapunov_time

   !> Two motions, the other one brought back to a distance of 1e-8 after each revolution, by angle and rate: in how
   !> many revolutions it grows e-fold.
   subroutine grow(error, first_rate, time)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in) :: first_rate
      real(wp), intent(out) :: time
      integer, parameter :: revolutions = 600
      real(wp), parameter :: off = 1e-8_wp, moments(3) = [0.5_wp, 0.5_wp + 0.7921_wp/3, 1.0_wp]
      type(problem_t), pointer :: problem
      type(state_t) :: states(2)
      type(status_t) :: status
      real(wp) :: growth, distance(2), angles(2), rate(3)
      integer :: i, k
      problem => new_problem()
      time = 0.0_wp
      call make_moon(moments, 0.1_wp, [0.0_wp, first_rate], problem)
      states = problem%start
      distance = [off, 0.0_wp]
      growth = 0.0_wp
      do i = 1, revolutions
         rate = angular_velocity(problem%system, states(1))
         states(2) = make_state(problem%system, quat_product([cos(0.5_wp*distance(1)), 0.0_wp, 0.0_wp, &
                                                              sin(0.5_wp*distance(1))], states(1)%q), &
                                rate + [0.0_wp, 0.0_wp, distance(2)], states(1)%t)
         do k = 1, 2
            call integrate(problem%system, integrator_settings_t(method='taylor', conserve=.true.), states(k), &
                           run_plan_t(goal=run_goal_t(local_tolerance=1e-12_wp), end_time=2*pi*i), status)
            call check(error, status%ok(), trim(status%message))
            rate = angular_velocity(problem%system, states(k))
            angles(k) = rate(3)
         end do
         distance(2) = angles(2) - angles(1)
         distance(1) = 2*(states(1)%q(1)*states(2)%q(4) - states(1)%q(4)*states(2)%q(1))
         growth = growth + log(norm2(distance)/off)
         distance = (off/norm2(distance))*distance
      end do
      time = revolutions/growth
   end subroutine grow

   subroutine make_moon(moments, eccentricity, start, problem)
      real(wp), intent(in) :: moments(3), eccentricity
      !> θ and its rate; shape (2).
      real(wp), intent(in) :: start(2)
      type(problem_t), intent(inout) :: problem
      type(status_t) :: status
      problem = new_problem()
      call make_body(diagonal(moments), problem%system%body, status)
      call problem%system%effects%add(orbital_gradient_t(problem%system%body, &
                                                         kepler_orbit_t(eccentricity=eccentricity)))
      problem%start = make_state(problem%system, [cos(0.5_wp*start(1)), 0.0_wp, 0.0_wp, sin(0.5_wp*start(1))], &
                                 [0.0_wp, 0.0_wp, start(2)])
   end subroutine make_moon

   !> In LVLH space axes, where H - ω·l is conserved, in inertial ones with steps in the LVLH frame, and with steps in
   !> inertial axes, which know nothing of it: the time-dependent potential has done ω·Δl.
   subroutine both_axes(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t) :: problems(3)
      type(state_t) :: states(3)
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      real(wp) :: rate(3), work
      integer :: i
      do i = 1, 3
         problems(i) = on_circle(i > 1)
         settings = integrator_settings_t(method='taylor', conserve=.true., in_space_axes=i == 3)
         states(i) = problems(i)%start
         call integrate(problems(i)%system, settings, states(i), &
                        run_plan_t(goal=run_goal_t(local_tolerance=1e-15_wp), end_time=8000.0_wp), status)
         call check(error, status%ok(), trim(status%message))
      end do
      do i = 2, 3
         associate (system => problems(i)%system, orbit => problems(i)%system%effects%orbit, q => states(i)%q)
            call check_close(error, q, quat_product(orbit%axes(8000.0_wp), states(1)%q), 1e-12_wp, "attitude")
            rate = orbit%axes_rate(0.0_wp)
            work = dot_product(rate, space_momentum(states(i)) - space_momentum(problems(i)%start))
            call check_close(error, states(i)%time_dependent_work, work, &
                             1e-12_wp*potential_energy(system%effects, q, 8000.0_wp), "work")
         end associate
      end do
   end subroutine both_axes

   !> A body on a circular orbit, in inertial space axes or in LVLH ones, with the same motion.
   function on_circle(inertial) result(problem)
      logical, intent(in) :: inertial
      type(problem_t), pointer :: problem
      type(kepler_orbit_t) :: path
      type(orbit_t) :: orbit
      type(status_t) :: status
      real(wp) :: q(4)
      problem => new_problem()
      path = ellipse()
      path%eccentricity = 0.0_wp
      path%mean_anomaly = 1.0_wp
      orbit = orbit_t(path, inertial=inertial)
      call make_body(diagonal([90.0_wp, 100.0_wp, 40.0_wp]), problem%system%body, status)
      call problem%system%effects%add(orbit)
      if (inertial) then
         call problem%system%effects%add(orbital_gradient_t(problem%system%body, path))
      else
         call problem%system%effects%add(gravity_gradient_t(problem%system%body, orbit))
      end if
      q = quat_product(orbit%axes(0.0_wp), [0.8_wp, 0.36_wp, 0.48_wp, 0.0_wp])
      problem%start = make_state(problem%system, q, [1e-3_wp, -5e-4_wp, 8e-4_wp])
   end function on_circle

   !> Every method steps in the LVLH frame as in inertial axes, to its errors in steps of 10 s: by single steps, and
   !> after a change of the state. A state that is put back gives the same step, and time runs backwards to the start.
   subroutine every_method_in_lvlh(error)
      type(error_type), allocatable, intent(out) :: error
      class(stepper_t), allocatable :: here, there
      type(problem_t), pointer :: problem
      type(state_t) :: a, b, before, again
      type(status_t) :: status
      integer :: m, i
      problem => on_circle(.true.)
      do m = 1, size(methods)
         if (methods(m)%name == 'exact' .or. methods(m)%order < 8) cycle
         associate (name => trim(methods(m)%name)//' '//trim(methods(m)%formulation))
            call make_stepper(problem%system, settings_of_row(m, .false.), here, status)
            if (status%ok()) call make_stepper(problem%system, settings_of_row(m, .true.), there, status)
            a = problem%start
            b = problem%start
            do i = 1, 100
               if (i == 50) a = make_state(problem%system, a%q, [-4e-4_wp, 7e-4_wp, 9e-4_wp], a%t)
               if (i == 50) b = make_state(problem%system, b%q, [-4e-4_wp, 7e-4_wp, 9e-4_wp], b%t)
               before = a
               if (status%ok()) call here%step(problem%system, a, 10.0_wp, status)
               if (status%ok()) call there%step(problem%system, b, 10.0_wp, status)
            end do
            call check(error, status%ok(), name//': '//trim(status%message))
            call check_close(error, a%q, b%q, 1e-10_wp, name)
            call check_close(error, space_momentum(a), space_momentum(b), 1e-10_wp*norm2(space_momentum(b)), name)
            again = before
            call here%step(problem%system, again, 10.0_wp, status)
            call check_close(error, again%q, a%q, 4*eps, name//': the same step again')
            call here%step(problem%system, again, -10.0_wp, status)
            call check_close(error, again%q, before%q, 1e-13_wp, name//': backwards')
         end associate
         if (allocated(error)) return
      end do
   end subroutine every_method_in_lvlh

   !> Settings of a row of the table of methods.
   pure type(integrator_settings_t) function settings_of_row(row, in_space_axes) result(settings)
      integer, intent(in) :: row
      logical, intent(in) :: in_space_axes
      settings = settings_of(methods(row))
      settings%in_space_axes = in_space_axes
   end function settings_of_row

   !> Compares with Simpson's rule over 2000 rows, whose error is some 1e-12.
   subroutine work_is_integrated_power(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=13), parameter :: names(4) = [character(len=13) :: 'nielsen_krenk', 'taylor', 'rk4', 'dop853']
      integer, parameter :: rows = 2000
      real(wp), parameter :: end_time = 9000.0_wp
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: expected, weight, scale
      integer :: i
      problem => satellite()
      state = problem%start
      scale = potential_energy(problem%system%effects, state%q, 0.0_wp)
      expected = 0.0_wp
      do i = 0, rows
         if (i > 0) call integrate(problem%system, integrator_settings_t(order=8, formulation='reduced'), state, &
                                   run_plan_t(time_step=end_time/rows, end_time=i*end_time/rows), status)
         weight = 2.0_wp + 2*mod(i, 2)
         if (i == 0 .or. i == rows) weight = 1.0_wp
         expected = expected + weight*time_dependent_power(problem%system%effects, state%q, state%t)
      end do
      expected = expected*end_time/(3*rows)
      call check_close(error, state%time_dependent_work, expected, 1e-9_wp*scale, "order 8")
      do i = 1, size(names)
         if (allocated(error)) return
         state = problem%start
         call integrate(problem%system, integrator_settings_t(method=trim(names(i)), order=merge(8, 0, i == 1)), &
                        state, run_plan_t(time_step=10.0_wp, end_time=end_time), status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, state%time_dependent_work, expected, 1e-8_wp*scale, trim(names(i)))
      end do
   end subroutine work_is_integrated_power

   !> Checks the energy balance with a rotor and damping beside the gradient, long steps, and a finite J0.
   subroutine account_closes(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: solvers(2) = ['full   ', 'reduced']
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(account_t) :: account
      type(status_t) :: status
      integer :: order, form
      problem => satellite()
      call problem%system%effects%add(rotor_t(name='rotor', momentum=[0.01_wp, -0.02_wp, 0.03_wp]))
      call problem%system%effects%add(damping_t(name='damping', coefficient=[1e-4_wp, 2e-4_wp, 3e-4_wp]))
      problem%start = make_state(problem%system, problem%start%q, [1e-3_wp, -5e-4_wp, 8e-4_wp])
      do order = 2, 8, 2
         do form = 1, 2
            state = problem%start
            account = account_t()
            call integrate(problem%system, integrator_settings_t(order=order, formulation=solvers(form), &
                           inverse_auxiliary_inertia=merge(0.01_wp, 0.0_wp, form == 1)), state, &
                           run_plan_t(time_step=200.0_wp, end_time=40000.0_wp), status, observer=account)
            call check(error, status%ok(), trim(status%message))
            call check_below(error, account%worst, 64*eps*account%scale, "account")
         end do
      end do
   end subroutine account_closes

   !> Checks the energy balance if 1e-9 of a step is below the last digit of t, and on the way from there to 0; the
   !> observed balance lacks the work of a rounding of t.
   subroutine account_closes_late(error)
      type(error_type), allocatable, intent(out) :: error
      type(integrator_settings_t) :: settings(5)
      real(wp), parameter :: starts(4) = [1e6_wp, 1e7_wp, 1e6_wp, -1e6_wp], dt(4) = [0.1_wp, 0.1_wp, -0.1_wp, 0.1_wp]
      integer(int64), parameter :: most = 2000, before(4) = [0_int64, 0_int64, 10000000 - most, 10000000 - most]
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(account_t) :: account
      type(status_t) :: status
      integer :: i, k
      problem => satellite()
      settings(4:)%method = 'taylor'
      settings(5)%conserve = .true.
      settings(2)%formulation = 'reduced'
      do k = 1, size(starts)
         do i = 1, size(settings)
            state = problem%start
            state%t = starts(k) + before(k)*dt(k)
            account = account_t()
            call integrate(problem%system, settings(i), state, run_plan_t( &
                           dt(k), state%t + most*dt(k), steps=most, steps_before=before(k), first_time=starts(k)), &
                           status, observer=account)
            call check(error, status%ok(), trim(status%message))
            call check_below(error, account%worst, 64*eps*account%scale + 4*spacing(starts(k))*account%power, "account")
         end do
      end do
   end subroutine account_closes_late

   !> Errors of two steps, one half of the other, fall as the order says.
   subroutine orders(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: errors(2)
      integer :: order, i
      problem => satellite()
      do order = 2, 6, 2
         do i = 1, 2
            state = problem%start
            call integrate(problem%system, integrator_settings_t(order=order, formulation='reduced'), state, &
                           run_plan_t(time_step=merge(100.0_wp, 50.0_wp, i == 1), end_time=5000.0_wp), status)
            call check(error, status%ok(), trim(status%message))
            errors(i) = norm2(state%q - attitudes(:, 2))
         end do
         call check_close(error, log(errors(1)/errors(2))/log(2.0_wp), real(order, wp), 0.4_wp, "order")
      end do
   end subroutine orders

end module test_time_dependent
