!> Periodic starts of spin-orbit resonances: the forced librations of Phobos and Mercury against 16 digits of shooting
!> and of harmonic balance, the free ones by the multipliers.
submodule(suites_of_effects) test_periodic_start
   use nutate_attitude, only: quat_from_euler
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp, pi
   use nutate_linearization, only: linearization_t, linearize_period
   use nutate_periodic_start, only: find_periodic_start, periodic_start_t
   use nutate_quaternion, only: attitude_distance
   use nutate_run, only: integrate
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_support, only: check, check_close, error_type, new_unittest
   implicit none

   character, parameter :: nl = new_line('a')
   character(len=*), parameter :: phobos = '&body inertia = 0.3615, 0.4265, 0.5024 /'//nl, &
      mercury = '&body inertia = 0.9995, 0.999703, 1.0 /'//nl, &
      mars = '&orbit semi_major_axis = 1.0, mu = 1.0, eccentricity = 0.0151', &
      sun = '&orbit semi_major_axis = 1.0, mu = 1.0, eccentricity = 0.2056'
   !> Θ'(0)/n of both.
   real(wp), parameter :: rate_of_phobos = 0.98057115494161525576_wp, rate_of_mercury = 1.500129574985608999697_wp

contains

   module procedure collect_periodic_start
      testsuite = [ &
                  new_unittest("Phobos: the forced libration", forced_phobos), &
                  new_unittest("Mercury: the forced libration", forced_mercury), &
                  new_unittest("multipliers are the free librations", free_librations), &
                  new_unittest("any axes, place on the orbit and units", anywhere), &
                  new_unittest("multipliers tell of unstable resonances", unstable_resonance), &
                  new_unittest("of a family the nearest motion is found", families), &
                  new_unittest("what has no periodic motion is refused", refused)]
   end procedure collect_periodic_start

   subroutine read_start(error, body, orbit, resonance, scene)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: body, orbit, resonance
      type(scene_t), intent(inout) :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(body//orbit//' /'//nl//"&gravity_gradient /"//nl// &
                       "&initial resonance = '"//resonance//"' /"//nl// &
                       "&integrator method = 'taylor', local_tolerance = 1e-15, end_time = 1.0 /", 's.nml', scene, &
                       status, message)
      call check(error, status%ok(), message)
   end subroutine read_start

   subroutine forced_phobos(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call read_start(error, phobos, mars, '1:1', scene)
      if (allocated(error)) return
      call check_rate(error, scene, rate_of_phobos)
      call check_libration(error, scene, 1.0_wp, [-0.01911977418546502_wp, -0.0001504587783339739_wp, &
                                                  -2.650948308665697e-6_wp], 1.095466160498906_wp*pi/180, &
                                                  1.555055509728412_wp)
   end subroutine forced_phobos

   subroutine forced_mercury(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      allocate (scene)
      call read_start(error, mercury, sun, '3:2', scene)
      if (allocated(error)) return
      call check_rate(error, scene, rate_of_mercury)
      call check_libration(error, scene, 1.5_wp, [1.735565345760495e-4_wp, -1.827312200773274e-5_wp], &
                           36.81041541414131_wp/3600*pi/180, 1.748838156774148_wp)
   end subroutine forced_mercury

   !> The rate at periapsis, about the axis of the largest moment, which is along the normal.
   subroutine check_rate(error, scene, rate)
      type(error_type), allocatable, intent(inout) :: error
      type(scene_t), intent(in) :: scene
      real(wp), intent(in) :: rate
      call check_close(error, angular_velocity(scene%system, scene%initial), [0.0_wp, 0.0_wp, rate], 1e-13_wp, 'rate')
      ! The slow libration of Mercury, 1/50 n, multiplies the rounding of the rates after a revolution by 400.
      call check_close(error, scene%initial%q, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 1e-11_wp, 'attitude')
   end subroutine check_rate

   !> The coefficients b_k of θ - pM = Σ b_k sin kM, by the trapezoidal rule, and its largest value.
   subroutine check_libration(error, scene, turns, coefficients, largest, where_it_is)
      type(error_type), allocatable, intent(inout) :: error
      type(scene_t), intent(inout) :: scene
      real(wp), intent(in) :: turns
      real(wp), intent(in) :: coefficients(:)
      !> rad, and M there.
      real(wp), intent(in) :: largest, where_it_is
      integer, parameter :: n = 64
      real(wp) :: angles(n), times(n)
      type(state_t) :: state
      integer :: i, k
      times = [(2*pi*i/n, i=1, n)]
      state = scene%initial
      do i = 1, n
         angles(i) = excess(times(i), state)
      end do
      do k = 1, size(coefficients)
         call check_close(error, 2*sum(angles*sin(k*times))/n, coefficients(k), 2e-12_wp, 'coefficient')
      end do
      state = scene%initial
      call check(error, abs(excess(where_it_is - 0.1_wp, state)) < largest - 1e-9_wp, 'it is smaller before')
      call check_close(error, abs(excess(where_it_is, state)), largest, 1e-11_wp, 'largest')
      call check(error, abs(excess(where_it_is + 0.1_wp, state)) < largest - 1e-9_wp, 'it is smaller after')

   contains

      !> θ - pM at a time, rad; the state moves on to it.
      real(wp) function excess(t, state)
         real(wp), intent(in) :: t
         type(state_t), intent(inout) :: state
         type(status_t) :: status
         scene%plan%end_time = t
         call integrate(scene%system, scene%integrator, state, scene%plan, status)
         call check(error, status%ok(), trim(status%message))
         excess = 2*atan2(state%q(4), state%q(1)) - turns*t
         excess = excess - 2*pi*anint(excess/(2*pi))
      end function excess

   end subroutine check_libration

   !> The trace of M in the plane, and across it, is the sum of 2 cos 2πf of the free librations.
   subroutine free_librations(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(periodic_start_t) :: start
      type(status_t) :: status
      allocate (scene)
      call read_start(error, phobos, mars, '1:1', scene)
      if (allocated(error)) return
      call find_periodic_start(scene%system, 1.0_wp, start, status)
      associate (m => start%monodromy)
         call check_close(error, m(3, 3) + m(6, 6), 2*cos(2*pi*0.622129699614924_wp), 1e-11_wp, 'Phobos, in the plane')
         ! Known to 8 digits: 0.5e-8 of a revolution each.
         call check_close(error, m(1, 1) + m(2, 2) + m(4, 4) + m(5, 5), 2*cos(2*pi*0.37663157_wp) + &
                          2*cos(2*pi*1.38884359_wp), 1e-7_wp, 'Phobos, across')
         call check(error, maxval(abs(m([1, 2, 4, 5], [3, 6]))) < 1e-12_wp, 'the plane is apart')
      end associate
      call check(error, start%condition > 1.5_wp .and. start%condition < 2.5_wp, 'condition of Phobos')
      call check_close(error, start%free_frequencies(), [0.38884359_wp, 1 - 0.622129699614924_wp, 0.37663157_wp], &
                       1e-8_wp, 'frequencies')
      call check(error, abs(start%growth() - 1) < 1e-11_wp, 'stable')
      call check(error, start%revolutions < 8 .and. start%n_families == 0, 'steps of the iteration')
      call read_start(error, mercury, sun, '3:2', scene)
      if (allocated(error)) return
      call find_periodic_start(scene%system, 1.5_wp, start, status)
      call check_close(error, start%monodromy(3, 3) + start%monodromy(6, 6), 2*cos(2*pi*0.0199651934142077622_wp), &
                       1e-11_wp, 'Mercury, in the plane')
      call check(error, start%condition > 2000.0_wp .and. start%condition < 3000.0_wp, 'condition of Mercury')
   end subroutine free_librations

   !> Hyperion's synchronous rotation, e = 0.1, lets its axis tilt: the multiplier is that of the monodromy matrix by
   !> another method, 1.88.
   subroutine unstable_resonance(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(linearization_t) :: linear
      type(status_t) :: status
      allocate (scene)
      call read_start(error, '&body inertia = 0.5, 0.764033333333333, 1.0 /'//nl, &
                      '&orbit semi_major_axis = 1.0, mu = 1.0, eccentricity = 0.1', '1:1', scene)
      if (allocated(error)) return
      scene%plan%goal%local_tolerance = 0.0_wp
      scene%plan%time_step = 0.05_wp
      call linearize_period(scene%system, integrator_settings_t(method='nielsen_krenk', order=8), scene%initial, &
                            scene%plan, 2*pi, linear, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, scene%periodic%growth(), maxval(abs(linear%eigenvalues)), 1e-8_wp, 'multiplier')
      call check(error, scene%periodic%growth() > 1.88_wp, 'it grows')
      call check(error, size(scene%periodic%free_frequencies()) == 2, 'the others are on the circle')
   end subroutine unstable_resonance

   !> Other axes of the body, an orbit in space, a start 2 rad after periapsis, in SI units: the same motion.
   subroutine anywhere(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: orbits(2) = [character(len=200) :: &
         'semi_major_axis = 9.376e6, mu = 4.282837e13, eccentricity = 0.0151, mean_anomaly = 2.0', &
         'periapsis_distance = 9234422.4, mu = 4.282837e13, eccentricity = 0.0151, periapsis_time = 18771.26']
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: rate, expected(4)
      integer :: i
      allocate (scene)
      do i = 1, size(orbits)
         call read_start(error, '&body inertia = 0.5024, 0.3615, 0.4265 /'//nl, '&orbit '//trim(orbits(i))// &
                         ', inclination = 0.4, raan = 0.5, argument_of_periapsis = 0.6', '1:1', scene)
         if (allocated(error)) return
         rate = scene%system%effects%orbit%path%mean_motion()
         state = scene%initial
         scene%plan%end_time = (2*pi - 2)/rate
         if (i == 2) scene%plan%end_time = 18771.26_wp
         call integrate(scene%system, scene%integrator, state, scene%plan, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, angular_velocity(scene%system, state)/rate, [rate_of_phobos, 0.0_wp, 0.0_wp], &
                          1e-12_wp, 'rate at periapsis')
         ! Axes 2, 3, 1 of the body are those to the planet, forward and along the normal.
         expected = product_of(quat_from_euler(0.5_wp, 0.4_wp, 0.6_wp), [0.5_wp, -0.5_wp, -0.5_wp, -0.5_wp])
         call check(error, attitude_distance(state%q, expected) < 1e-11_wp, 'attitude at periapsis')
      end do
   end subroutine anywhere

   pure function product_of(a, b) result(c)
      use nutate_quaternion, only: quat_product
      real(wp), intent(in) :: a(4), b(4)
      real(wp) :: c(4)
      c = quat_product(a, b)
   end function product_of

   !> A symmetric body on a circular orbit keeps any attitude about its axis: the guess is periodic.
   subroutine families(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(periodic_start_t) :: start
      type(status_t) :: status
      allocate (scene)
      call read_start(error, '&body inertia = 1.0, 1.0, 1.6 /'//nl, &
                      '&orbit semi_major_axis = 1.0, mu = 1.0', '1:1', scene)
      if (allocated(error)) return
      call find_periodic_start(scene%system, 1.0_wp, start, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, start%n_families > 0, 'a family')
      call check_close(error, start%omega, [0.0_wp, 0.0_wp, 1.0_wp], 1e-12_wp, 'rate')
   end subroutine families

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_refusal(error, '', 'there is no orbit')
      call check_refusal(error, "&orbit semi_major_axis = 1.0, mu = 1.0, frame = 'lvlh' /", 'the space axes turn')
      call check_refusal(error, '&orbit periapsis_distance = 1.0, mu = 1.0, eccentricity = 1.5 /', 'is not closed')
      call check_refusal(error, mars//", name = 'a' /"//nl//sun//", name = 'b' /", 'several orbits')
      call check_refusal(error, mars//' /'//nl//'&wheel axis = 0.0, 0.0, 1.0, inertia = 0.01 /', 'wheels')
      ! A torque spins the body up.
      call check_refusal(error, mars//' /'//nl//'&torque body = 0.0, 0.0, 1.0 /', 'no periodic motion')
   end subroutine refused

   subroutine check_refusal(error, groups, words)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: groups, words
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse_scene(phobos//groups//nl//"&initial resonance = '1:1' /"//nl// &
                       '&integrator time_step = 0.1, end_time = 1.0 /', 's.nml', scene, status, message)
      call check(error, .not. status%ok() .and. index(message, words) > 0, words//' expected, got '//message)
   end subroutine check_refusal

end submodule test_periodic_start
