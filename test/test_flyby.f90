!> Open orbits and several attracting bodies: places on conics, and bodies that pass others, against 16 digits of two
!> methods in 128-bit arithmetic.
submodule(suites_of_effects) test_flyby
   use nutate_conic, only: place_on_conic
   use nutate_hamiltonian, only: angular_velocity, potential_energy, total_energy
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, eps
   use nutate_orbit, only: orbit_t
   use nutate_orbital_gradient, only: orbital_gradient_t
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_run, only: integrate
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_support, only: check, check_close, error_type, new_unittest, random_unit
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none

   character, parameter :: nl = new_line('a')

   !> Two bodies that attract a third.
   character(len=*), parameter :: two = &
      '&body inertia = 1.0, 1.5, 2.2 /'//nl// &
      "&orbit name = 'one', mu = 1.0, periapsis_distance = 1.0, eccentricity = 0.3, inclination = 0.4, raan = 0.5, "// &
      'argument_of_periapsis = 0.6 /'//nl// &
      "&orbit name = 'two', mu = 0.3, periapsis_distance = 1.2, eccentricity = 1.5, inclination = 1.1, raan = 2.0, "// &
      'argument_of_periapsis = -0.7, periapsis_time = 4.0 /'//nl// &
      '&gravity_gradient /'//nl// &
      '&initial quaternion = 0.9, 0.1, -0.3, 0.3, angular_velocity = 0.2, -0.1, 0.5 /'//nl

   !> The hyperbola of Apophis in 2029 about the Earth, ecliptic axes.
   character(len=*), parameter :: apophis = &
      '&body inertia = 0.64, 0.97, 1.0 /'//nl// &
      '&orbit mu = 3.986004418e14, periapsis_distance = 38011486.49129103, eccentricity = 4.253901873212790, '// &
      'inclination = 162.8561543134850, raan = 152.0019490904037, argument_of_periapsis = 32.56762207107416, '// &
      'degrees = .true., periapsis_time = 172800.0 /'//nl// &
      '&gravity_gradient /'//nl

   !> Motion on conics, μ = q = 1: e, time since the periapsis, r, ν, x, y, ẋ, ẏ; of the classic equations, 60 digits.
   real(wp), parameter :: conics(8, 11) = reshape([ &
      0.99999999_wp, 10.0_wp, 6.8047207401239575_wp, 2.3547524982217947_wp, -4.8047207981711655_wp, &
      4.8185975555855024_wp, -0.50072047715208958_wp, 0.20782829020558023_wp, &
      0.99999999_wp, 1000.0_wp, 164.10241671040841_wp, 2.9853086963581581_wp, -162.1024183414326_wp, &
      25.542300954606797_wp, -0.1100601357330125_wp, 0.0086178575585312993_wp, &
      1.0_wp, 1.0_wp, 1.3912782187175312_wp, 1.1179497088870858_wp, 0.60872178128246875_wp, 1.2510447133776334_wp, &
      -0.6358341476892686_wp, 1.0164850878472786_wp, &
      1.0_wp, -3.0_wp, 2.7757266234667932_wp, -1.8540362598526041_wp, -0.77572662346679316_wp, &
      -2.6651278569455486_wp, 0.67893212697641352_wp, 0.50949310008302902_wp, &
      1.0_wp, 1000.0_wp, 164.10244397119079_wp, 2.9853086455098439_wp, -162.10244397119079_wp, 25.542313440343714_wp, &
      -0.11006017097484594_wp, 0.0086178702044277239_wp, &
      1.00000001_wp, 10.0_wp, 6.8047208641878095_wp, 2.3547524816961645_wp, -4.8047208061406015_wp, &
      4.8185977228393426_wp, -0.50072048289937869_wp, 0.20782831158329582_wp, &
      1.00000001_wp, 1000.0_wp, 164.1024712319693_wp, 2.985308594661541_wp, -162.1024696009446_wp, &
      25.542325926080856_wp, -0.11006020621667097_wp, 0.0086178828503246372_wp, &
      1.2_wp, 1.0_wp, 1.4579181635848267_wp, 1.1327539148734415_wp, 0.61840153034597773_wp, 1.3202669877628185_wp, &
      -0.61054443507017922_wp, 1.0950135179239046_wp, &
      1.2_wp, 1000.0_wp, 467.54913398062424_wp, 2.5488509426299009_wp, -387.79094498385353_wp, 261.19030547583805_wp, &
      -0.37663307496542118_wp, 0.24985025942041437_wp, &
      4.25390187321279_wp, 10.0_wp, 18.813137367148379_wp, 1.7410461004971483_wp, -3.1874819631640631_wp, &
      18.541146036038291_wp, -0.4299662521705929_wp, 1.7819482556543321_wp, &
      30.0_wp, -3.0_wp, 16.272817249014029_wp, -1.5406245025850912_wp, 0.49090609169953238_wp, &
      -16.265410920998608_wp, 0.17952355737495688_wp, 5.3935772582497783_wp], [8, 11])

   !> Two attracting bodies: t, q, Ω, H; of two methods in 128 bits, as the tables below.
   real(wp), parameter :: two_bodies(9, 5) = reshape([ &
      0.0_wp, 0.9_wp, 0.1_wp, -0.3_wp, 0.3_wp, 0.2_wp, -0.1_wp, 0.5_wp, 2.19986387897743_wp, &
      1.0_wp, 0.7655337213363232_wp, 0.03772515024456461_wp, -0.2629950965715646_wp, 0.5859765470693337_wp, &
      0.1194884072933048_wp, 0.08539653256861043_wp, 0.7644858159901559_wp, 2.040149003549564_wp, &
      4.0_wp, -0.5130885106498339_wp, -0.0742403825608845_wp, 0.1885921826410025_wp, 0.8340632676740126_wp, &
      0.4349022778343656_wp, 0.3181700730084481_wp, 1.002698721075141_wp, 1.911253563433963_wp, &
      8.0_wp, -0.4753808468051067_wp, 0.1345927352418627_wp, 0.08909232438099646_wp, -0.8648470407230199_wp, &
      -0.2105660882743414_wp, -0.3900494506410578_wp, 1.013665773480139_wp, 1.825357519285437_wp, &
      12.0_wp, 0.7342298005202412_wp, 0.6128511073604635_wp, -0.01212149811978699_wp, -0.2918444611747712_wp, &
      0.7824378433780706_wp, 0.9687407841357545_wp, 0.1112675942196829_wp, 1.957743241223832_wp], [9, 5])

   !> Apophis passes the Earth, starts A and C: t, q, Ω.
   real(wp), parameter :: start_a(8, 5) = reshape([ &
      0.0_wp, 0.020090959167059877_wp, -0.73695125123330905_wp, 0.67529140523622722_wp, 0.021925434533648052_wp, &
      1.2968878841891378e-05_wp, 0.0_wp, 5.6151964338719312e-05_wp, &
      151200.0_wp, 0.04141606529906837_wp, -0.3295520655350237_wp, -0.8886922182312911_wp, 0.3160795578519591_wp, &
      6.399587067178664e-06_wp, 3.124553371244817e-05_wp, 4.732926942134037e-05_wp, &
      172800.0_wp, 0.1832636741234202_wp, -0.7786250007370177_wp, -0.5570360380197681_wp, 0.2233123066946906_wp, &
      2.969730825063049e-06_wp, 2.645732155063629e-05_wp, 3.466941410818314e-05_wp, &
      194400.0_wp, 0.3072652413889082_wp, -0.9109288760712241_wp, -0.2747889024883395_wp, 0.01696211198778916_wp, &
      2.449350598756649e-06_wp, 3.149952483790042e-05_wp, 1.930516615002602e-05_wp, &
      345600.0_wp, -0.2178522418772809_wp, 0.7838006475355681_wp, 0.5414617749226201_wp, -0.2121699600073314_wp, &
      -1.692884403370018e-06_wp, 3.16674253201309e-05_wp, 1.848700642328027e-05_wp], [8, 5])

   real(wp), parameter :: start_c(8, 5) = reshape([ &
      0.0_wp, -0.057340733173217097_wp, -0.97178068165486757_wp, 0.21260202420960839_wp, -0.084585615701110482_wp, &
      -1.2968878841891378e-05_wp, 0.0_wp, 5.6151964338719312e-05_wp, &
      151200.0_wp, 0.08865993430444799_wp, 0.1644945250677147_wp, -0.9552094043730014_wp, -0.2294688673202835_wp, &
      -6.39760786267827e-06_wp, -3.213006680216994e-05_wp, 4.759656121933653e-05_wp, &
      172800.0_wp, -0.1330127857162137_wp, -0.3808288507991365_wp, -0.8792740123242034_wp, -0.2532867870346147_wp, &
      -4.871525162167504e-06_wp, -3.083526380547306e-05_wp, 4.190142227441394e-05_wp, &
      194400.0_wp, -0.2629770960856012_wp, -0.8534805531295124_wp, -0.4117540162605067_wp, -0.1813080871264942_wp, &
      -2.762432894386742e-06_wp, -3.449974103044031e-05_wp, 5.866290244092757e-05_wp, &
      345600.0_wp, -0.1126480486438868_wp, 0.05510279664969389_wp, -0.9836563050091814_wp, -0.1292067047555632_wp, &
      1.03896180443254e-05_wp, -1.962303863147729e-05_wp, 6.441722016145258e-05_wp], [8, 5])

contains

   module procedure collect_flyby
      testsuite = [ &
                  new_unittest("places on conics, to 15 digits", places_on_conics), &
                  new_unittest("place and velocity of every conic keep energy and momentum", kept_on_conics), &
                  new_unittest("an ellipse from its periapsis is that of its semi-major axis", same_ellipse), &
                  new_unittest("series, rates and power of open orbits are those of their places", open_series), &
                  new_unittest("two attracting bodies by every method", two_by_methods), &
                  new_unittest("the energy balance of two bodies closes in long steps", two_in_long_steps), &
                  new_unittest("Apophis passes the Earth", apophis_passes), &
                  new_unittest("orbits that do not go together are refused", refused_orbits), &
                  new_unittest("effects, starts and columns refer to the orbit that is named", named_orbits)]
   end procedure collect_flyby

   subroutine places_on_conics(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: place(2), velocity(2), radius, nu
      integer :: i
      do i = 1, size(conics, 2)
         associate (row => conics(:, i))
            call place_on_conic(row(1), row(2), place, velocity, radius, nu)
            call check_close(error, radius, row(3), 16*eps*row(3), 'radius')
            call check_close(error, nu, row(4), 8*eps, 'true anomaly')
            call check_close(error, place, row(5:6), 16*eps*row(3), 'place')
            call check_close(error, velocity, row(7:8), 16*eps*norm2(row(7:8)), 'velocity')
         end associate
      end do
   end subroutine places_on_conics

   !> Checks conics with e from 0 to 1 - ε, 1, and 1 + ε to 1e6, and the time from one position to the next by the
   !> energy's own equation: d(r·v)/dt = v² - 1/r.
   subroutine kept_on_conics(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: shapes(12) = [0.0_wp, 1e-12_wp, 0.5_wp, 0.9_wp, 0.999999_wp, 1 - 2*eps, 1.0_wp, &
                                           1 + 2*eps, 1.000001_wp, 1.1_wp, 3.0_wp, 1e6_wp]
      real(wp), parameter :: h = 1e-4_wp
      real(wp) :: place(2), velocity(2), before(2), after(2), unused(2), radius, nu, time, r
      integer(int64) :: seed
      integer :: i, k
      seed = 7
      do i = 1, size(shapes)
         associate (e => shapes(i))
            do k = 1, 60
               time = sign(10**(8*random_unit(seed) - 4), random_unit(seed) - 0.5_wp)
               call place_on_conic(e, time, place, velocity, radius, nu)
               call check_close(error, norm2(place), radius, 16*eps*radius, 'radius')
               call check_close(error, place, radius*[cos(nu), sin(nu)], 16*eps*radius*max(1.0_wp, abs(nu)), 'angle')
               call check_close(error, place(1)*velocity(2) - place(2)*velocity(1), sqrt(1 + e), &
                                16*eps*radius*norm2(velocity), 'angular momentum')
               call check_close(error, dot_product(velocity, velocity) - 2/radius, e - 1, &
                                32*eps*(1 + dot_product(velocity, velocity)), 'energy')
               if (e > 10 .or. abs(time) > 100.0_wp) cycle
               call place_on_conic(e, time - h, before, unused, r, nu)
               call place_on_conic(e, time + h, after, unused, r, nu)
               call check_close(error, (after - before)/(2*h), velocity, 100*h**2, 'velocity')
            end do
         end associate
      end do
   end subroutine kept_on_conics

   !> Five revolutions of it: times are known to a rounding of themselves.
   subroutine same_ellipse(error)
      type(error_type), allocatable, intent(out) :: error
      type(kepler_orbit_t) :: path, other
      real(wp) :: t
      integer :: i
      path = kepler_orbit_t(semi_major_axis=2.0_wp, eccentricity=0.4_wp, mu=3.0_wp, inclination=0.5_wp, raan=0.3_wp, &
                            argument_of_periapsis=-0.7_wp, mean_anomaly=0.8_wp)
      other = path
      other%semi_major_axis = 1.0_wp
      other%periapsis_distance = 1.2_wp
      other%periapsis_time = -0.8_wp/path%mean_motion()
      call check_close(error, other%mean_motion(), path%mean_motion(), 8*eps, 'mean motion')
      call check_close(error, other%fastest_turn(), path%fastest_turn(), 16*eps, 'rate in the periapsis')
      call check_close(error, other%nearest(), path%nearest(), 4*eps, 'distance of the periapsis')
      do i = -20, 20
         t = 0.5_wp*i
         call check_close(error, other%position(t), path%position(t), 200*eps, 'place')
         call check_close(error, other%velocity(t), path%velocity(t), 200*eps, 'velocity')
         call check_close(error, other%radius(t), path%radius(t), 200*eps, 'radius')
         call check_close(error, other%true_anomaly(t), path%true_anomaly(t), 200*eps, 'true anomaly')
         call check_close(error, other%turn_rate(t), path%turn_rate(t), 200*eps, 'rate')
         call check_close(error, other%axes(t), path%axes(t), 100*eps, 'LVLH frame')
      end do
      other%eccentricity = 1.5_wp
      call check_close(error, other%mean_motion(), 0.0_wp, 0.0_wp, 'mean motion of a hyperbola')
   end subroutine same_ellipse

   subroutine open_series(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1e-4_wp, shapes(3) = [1.0_wp, 1.5_wp, 6.0_wp]
      class(scene_t), allocatable :: scene
      type(orbital_gradient_t) :: gradient
      type(orbit_t) :: orbit
      real(wp) :: series(3, 0:24), n(3), t, q(4), r(3), v(3)
      integer :: i, j, k
      allocate (scene)
      call read_text(error, two, 'integrator', scene)
      if (allocated(error)) return
      q = scene%initial%q
      do i = 1, size(shapes)
         orbit = orbit_t(kepler_orbit_t(eccentricity=shapes(i), periapsis_distance=1.0_wp, periapsis_time=0.7_wp, &
                                        inclination=0.4_wp, raan=0.5_wp))
         call check(error, .not. orbit%is_frame, 'the LVLH frame of an open orbit does not turn evenly')
         gradient = orbital_gradient_t(scene%system%body, orbit%path)
         do j = -4, 8
            t = 0.5_wp*j
            r = orbit%path%position(t)
            v = orbit%path%velocity(t)
            call gradient%direction_series(t, 0.125_wp, series)
            n = series(:, 24)
            do k = 23, 0, -1
               n = 0.5_wp*n + series(:, k)
            end do
            call check_close(error, n, gradient%direction_at(t + 0.0625_wp), 64*eps, 'series')
            call check_close(error, gradient%power(q, t), (energy_at(t + h) - energy_at(t - h))/(2*h), 2e-5_wp, 'power')
            call check_close(error, rotate_to_body(orbit%axes(t), r), [0.0_wp, 0.0_wp, -norm2(r)], 16*eps*norm2(r), 'z')
            call check_close(error, rotate_to_body(orbit%axes(t), cross(r, v)), &
                             [0.0_wp, -sqrt(1 + shapes(i)), 0.0_wp], 64*eps*norm2(r), 'normal')
            call check_close(error, rotate_to_body(orbit%axes(t), orbit%axes_rate(t)), &
                             [0.0_wp, -sqrt(1 + shapes(i))/dot_product(r, r), 0.0_wp], 64*eps, 'rate')
         end do
      end do

   contains

      real(wp) function energy_at(time)
         real(wp), intent(in) :: time
         energy_at = gradient%energy(rotate_to_body(q, gradient%direction_at(time)))
      end function energy_at

   end subroutine open_series

   !> Reads a scene. The group `&integrator` has the keys `integrator`, or, if that is the word itself, arbitrary ones.
   subroutine read_text(error, text, integrator, scene)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: text, integrator
      type(scene_t), intent(inout) :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message, steps
      steps = integrator
      if (steps == 'integrator') steps = 'time_step = 0.01, end_time = 12.0'
      call parse_scene(text//'&integrator '//steps//' /', 'flyby.nml', scene, status, message)
      call check(error, status%ok(), message)
   end subroutine read_text

   !> Runs a scene to the times of a table and compares attitude and rate, over its unit, with those of the table. The
   !> energy balance closes to a rounding of what enters it.
   subroutine check_run(error, text, integrator, table, rate_unit, bound, label)
      type(error_type), allocatable, intent(inout) :: error
      !> Scene without `&integrator`, and the keys of that group.
      character(len=*), intent(in) :: text, integrator, label
      !> t, q, Ω, and the energy where there is a ninth column.
      real(wp), intent(in) :: table(:, :), rate_unit, bound
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: first
      integer :: i
      allocate (scene)
      call read_text(error, text, integrator//', end_time = 1.0', scene)
      if (allocated(error)) return
      state = scene%initial
      first = total_energy(scene%system, state)
      do i = 1, size(table, 2)
         scene%plan%end_time = table(1, i)
         if (i > 1) call integrate(scene%system, scene%integrator, state, scene%plan, status)
         call check(error, status%ok(), label//': '//trim(status%message))
         if (allocated(error)) return
         call check_close(error, sign(1.0_wp, dot_product(state%q, table(2:5, i)))*state%q, table(2:5, i), bound, &
                          label//': attitude')
         call check_close(error, angular_velocity(scene%system, state)/rate_unit, table(6:8, i)/rate_unit, bound, &
                          label//': rate')
         if (size(table, 1) < 9) cycle
         call check_close(error, total_energy(scene%system, state), table(9, i), 4*bound, label//': energy')
         if (.not. scene%integrator%conserve .and. scene%integrator%method /= 'nielsen_krenk') cycle
         call check_close(error, total_energy(scene%system, state) - state%time_dependent_work, first, 64*eps, &
                          label//': energy balance')
      end do
   end subroutine check_run

   !> Steps at which the errors of each method have fallen below the bound.
   subroutine two_by_methods(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: bound = 1e-11_wp
      call check_run(error, two, "method = 'taylor', local_tolerance = 1e-15", two_bodies, 1.0_wp, bound, 'taylor')
      call check_run(error, two, "method = 'taylor', series_order = 20, time_step = 0.05", two_bodies, 1.0_wp, bound, &
                     'taylor, fixed steps')
      call check_run(error, two, "method = 'nielsen_krenk', order = 8, time_step = 0.02", two_bodies, 1.0_wp, bound, &
                     'nielsen_krenk 8')
      call check_run(error, two, "method = 'nielsen_krenk', formulation = 'reduced', order = 8, time_step = 0.02", &
                     two_bodies, 1.0_wp, bound, 'nielsen_krenk 8, reduced')
      call check_run(error, two, "method = 'nielsen_krenk', formulation = 'reduced', order = 6, time_step = 0.01", &
                     two_bodies, 1.0_wp, bound, 'nielsen_krenk 6, reduced')
      call check_run(error, two, "method = 'rk4', time_step = 5e-4", two_bodies, 1.0_wp, bound, 'rk4')
      call check_run(error, two, "method = 'rk8', time_step = 0.02", two_bodies, 1.0_wp, bound, 'rk8')
      call check_run(error, two, "method = 'dop853', time_step = 0.02", two_bodies, 1.0_wp, bound, 'dop853')
      call check_run(error, two, "method = 'dop853', conserve = .true., local_tolerance = 1e-15", two_bodies, 1.0_wp, &
                     bound, 'dop853, conserving')
      call check_run(error, two, 'accuracy = 1e-12', two_bodies, 1.0_wp, bound, 'accuracy')
   end subroutine two_by_methods

   !> Half a radian and more of both orbits in a step.
   subroutine two_in_long_steps(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=9), parameter :: formulations(2) = [character(len=9) :: 'full', 'reduced']
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: first
      integer :: i, order
      allocate (scene)
      do i = 1, 2
         do order = 2, 4, 2
            call read_text(error, two, "formulation = '"//trim(formulations(i))//"', order = "// &
                           merge('2', '4', order == 2)//', time_step = 0.5, end_time = 40.0', scene)
            if (allocated(error)) return
            state = scene%initial
            first = total_energy(scene%system, state)
            call integrate(scene%system, scene%integrator, state, scene%plan, status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, total_energy(scene%system, state) - state%time_dependent_work, first, 200*eps, &
                             'energy balance')
            call check(error, abs(total_energy(scene%system, state) - first) > 0.1_wp, 'the energy itself changes')
         end do
      end do
   end subroutine two_in_long_steps

   !> Two days before and behind the passage. Rates are compared in units of 1e-5 rad/s.
   subroutine apophis_passes(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: series = "method = 'taylor', local_tolerance = 1e-15"
      call check_run(error, apophis//initial_of(start_a), series, start_a, 1e-5_wp, 1e-11_wp, 'A')
      call check_run(error, apophis//initial_of(start_c), series, start_c, 1e-5_wp, 1e-11_wp, 'C')
      call check_run(error, apophis//initial_of(start_c), "formulation = 'reduced', order = 8, time_step = 300.0", &
                     start_c, 1e-5_wp, 1e-11_wp, 'C by order 8')
   end subroutine apophis_passes

   !> `&initial` of a table's first column.
   function initial_of(table) result(text)
      real(wp), intent(in) :: table(:, :)
      character(len=:), allocatable :: text
      character(len=400) :: numbers
      write (numbers, '("&initial quaternion = ", 4(es23.16, ","), " angular_velocity = ", 2(es23.16, ","), '// &
             'es23.16, '// &
             '" /")') table(2:8, 1)
      text = trim(numbers)//nl
   end function initial_of

   !> Fails unless a scene is refused with certain words.
   subroutine expect(error, text, words)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: text, words
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse_scene('&body inertia = 1.0, 1.5, 2.2 /'//nl//'&initial angular_velocity = 0.2, -0.1, 0.5 /'//nl// &
                       '&integrator time_step = 0.01, end_time = 1.0 /'//nl//text, 's.nml', scene, status, message)
      call check(error, .not. status%ok(), 'accepted: '//text)
      call check(error, index(message, words) > 0, message)
   end subroutine expect

   subroutine refused_orbits(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: one = "&orbit name = 'one', semi_major_axis = 1.0, mu = 1.0, "// &
                                           "frame = 'inertial' /"//nl
      call expect(error, one//'&orbit semi_major_axis = 1.0, eccentricity = 0.1 /', &
                  's.nml:5: several orbits need different names')
      call expect(error, one//one, 's.nml:5: several orbits need different names')
      call expect(error, one//"&orbit name = 'two', semi_major_axis = 2.0, frame = 'lvlh' /", &
                  "s.nml:5: several orbits need common space axes (expected frame = 'inertial'")
      call expect(error, "&orbit name = 'one', main = .true., semi_major_axis = 1.0, frame = 'inertial' /"//nl// &
                  "&orbit name = 'two', main = .true., semi_major_axis = 1.0, frame = 'inertial' /", &
                  's.nml:5: a second main orbit')
      call expect(error, one//"&gravity_gradient orbit = 'three' /", "s.nml:5: no orbit is called 'three'")
      call expect(error, one//"&gravity_gradient orbit = 'one', direction = 0.0, 0.0, 1.0, strength = 1.0 /", &
                  's.nml:5: orbit with direction and strength')
      call expect(error, '&orbit semi_major_axis = 1.0, eccentricity = 1.0 /', &
                  's.nml:4: eccentricity is out of range (expected a number >= 0 and < 1, or periapsis_distance)')
      call expect(error, '&orbit periapsis_distance = 1.0, semi_major_axis = 1.0 /', &
                  's.nml:4: semi_major_axis and periapsis_distance exclude each other')
      call expect(error, '&orbit periapsis_distance = 1.0, mean_anomaly = 1.0 /', &
                  's.nml:4: mean_anomaly with periapsis_distance (expected periapsis_time)')
      call expect(error, '&orbit semi_major_axis = 1.0, periapsis_time = 1.0 /', &
                  's.nml:4: periapsis_time without periapsis_distance')
      call expect(error, "&orbit periapsis_distance = 1.0, eccentricity = 1.0, frame = 'lvlh' /", &
                  's.nml:4: the LVLH frame of an eccentric orbit')
      call expect(error, '&orbit periapsis_distance = 1.0, mu = 1e90 /', 's.nml:4: the effect orbit is too strong')
      call expect(error, '&orbit inclination = 1.0 /', &
                  's.nml:4: an orbit needs semi_major_axis, altitude or periapsis_distance')
      call expect(error, '&rotating_frame rate = 1.0, 0.0, 0.0 /'//nl//'&orbit semi_major_axis = 1.0 /', &
                  'an orbit defines its own space axes')
   end subroutine refused_orbits

   subroutine named_orbits(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: start = '&initial attitude_from = ''lvlh'', angular_velocity = 3*0.0, '// &
                                             'rate_from = ''lvlh'' /'//nl, &
                                     body = '&body inertia = 1.0, 1.5, 2.2 /'//nl, &
                                     near = "&orbit name = 'near', periapsis_distance = 1.0, eccentricity = 2.0, "// &
                                            'mu = 1.0', &
                                     far = "&orbit name = 'far', semi_major_axis = 5.0, eccentricity = 0.5, "// &
                                           'inclination = 1.0, mu = 20.0'
      class(scene_t), allocatable :: scene, main, one, other
      integer :: i
      allocate (scene, main, one, other)
      call read_text(error, body//near//' /'//nl//far//' /'//nl//'&gravity_gradient /'//nl//start, 'integrator', scene)
      call read_text(error, body//near//' /'//nl//far//', main = .true. /'//nl//'&gravity_gradient /'//nl//start, &
                     'integrator', main)
      call read_text(error, body//near//' /'//nl//far//" /"//nl//"&gravity_gradient orbit = 'near' /"//nl//start, &
                     'integrator', one)
      call read_text(error, body//near//' /'//nl//far//" /"//nl//"&gravity_gradient orbit = 'far' /"//nl//start, &
                     'integrator', other)
      if (allocated(error)) return
      call check(error, scene%system%effects%orbit%label, 'near', 'the first is the main one')
      call check(error, main%system%effects%orbit%label, 'far', 'main')
      do i = 1, 2
         call check(error, scene%system%effects%orbits(i)%label, main%system%effects%orbits(i)%label, 'both are there')
      end do
      call check_close(error, scene%initial%q, scene%system%effects%orbits(1)%axes(0.0_wp), 4*eps, 'start')
      call check_close(error, main%initial%q, main%system%effects%orbits(2)%axes(0.0_wp), 4*eps, 'start on the other')
      call check_close(error, angular_velocity(main%system, main%initial), &
                       [0.0_wp, -main%system%effects%orbits(2)%path%turn_rate(0.0_wp), 0.0_wp], 8*eps, 'rate')
      call check(error, one%system%effects%n_potentials, 1, 'a gradient of one')
      call check_close(error, potential_energy(scene%system%effects, [0.6_wp, 0.8_wp, 0.0_wp, 0.0_wp], 0.4_wp), &
                       potential_energy(one%system%effects, [0.6_wp, 0.8_wp, 0.0_wp, 0.0_wp], 0.4_wp) &
                       + potential_energy(other%system%effects, [0.6_wp, 0.8_wp, 0.0_wp, 0.0_wp], 0.4_wp), 32*eps, &
                       'sum')
   end subroutine named_orbits

end submodule test_flyby
