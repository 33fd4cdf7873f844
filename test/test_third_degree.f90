!> Gravity of third degree: its numbers, its discrete gradient, and bodies that pass others, against 16 digits of two
!> methods in 128-bit arithmetic.
submodule(suites_of_effects) test_third_degree
   use nutate_hamiltonian, only: angular_velocity, total_energy
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp, eps
   use nutate_orbit, only: orbit_t
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_run, only: integrate
   use nutate_scene, only: parse_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_third_degree, only: third_degree_t, third_moments_of
   use test_support, only: check, check_close, error_type, new_unittest, random_unit_quaternion, random_vector
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none

   character, parameter :: nl = new_line('a')
   !> xxx, yyy, zzz, xxy, xxz, xyy, yyz, xzz, yzz, xyz.
   real(wp), parameter :: moments(10) = [10.0_wp, -4.0_wp, 7.0_wp, 2.0_wp, -3.0_wp, 1.0_wp, 5.0_wp, -2.0_wp, -6.0_wp, &
                                         3.0_wp]*1e-4_wp
   real(wp), parameter :: distance = 1.25_wp, unit(3) = [0.48_wp, -0.6_wp, 0.64_wp]
   real(wp), parameter :: points(4, 4) = reshape([ &
      1.0_wp, 0.12_wp, 0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 0.09_wp, 0.0_wp, 3.0_wp, -0.02_wp, -0.03_wp, 0.08_wp, &
      4.0_wp, -0.015_wp, -0.0225_wp, -0.06_wp], [4, 4])

   !> A body with these moments passes another one.
   character(len=*), parameter :: body = '&body inertia = 0.05, 0.06, 0.075 /'//nl// &
      '&orbit mu = 1.0, periapsis_distance = 1.0, eccentricity = 1.5, inclination = 0.4, raan = 0.5, '// &
      'argument_of_periapsis = 0.6, periapsis_time = 4.0 /'//nl//'&gravity_gradient /'//nl// &
      '&initial quaternion = 0.9, 0.1, -0.3, 0.3, angular_velocity = 0.2, -0.1, 0.5 /'//nl
   character(len=*), parameter :: flyby = body// &
      '&third_degree third_moments = 10e-4, -4e-4, 7e-4, 2e-4, -3e-4, 1e-4, 5e-4, -2e-4, -6e-4, 3e-4 /'//nl

   !> Motion in the flyby: t, q, Ω, H.
   real(wp), parameter :: third(9, 5) = reshape([ &
      0.0_wp, 0.9_wp, 0.1_wp, -0.3_wp, 0.3_wp, 0.2_wp, -0.1_wp, 0.5_wp, 0.01181493985434165_wp, &
      2.0_wp, 0.5855886197344764_wp, 0.1344705350599183_wp, -0.2927018539197035_wp, 0.7438610544652399_wp, &
      0.2272494149997771_wp, -0.01716619073740479_wp, 0.5131255184707867_wp, 0.01655422205203526_wp, &
      4.0_wp, 0.06320989886681358_wp, 0.07840220916525724_wp, -0.1416595949074498_wp, 0.9847792450361206_wp, &
      0.2400211694569789_wp, 0.05006243451493634_wp, 0.6667262753951525_wp, 0.1062275640479857_wp, &
      6.0_wp, -0.5710787822415679_wp, -0.0910272414345521_wp, -0.05005395049066472_wp, 0.814295811011319_wp, &
      0.04671025281662878_wp, 0.1199025173786163_wp, 0.674693088862863_wp, 0.02361423212032857_wp, &
      8.0_wp, -0.9443045649881078_wp, -0.1991709678380682_wp, -0.04019038365510185_wp, 0.2588523655961509_wp, &
      -0.02081787412167031_wp, 0.1363025286501634_wp, 0.6824091190211093_wp, 0.01897389181114478_wp], [9, 5])

contains

   module procedure collect_third_degree
      testsuite = [ &
                  new_unittest("energy, gradient and torque, to 13 digits", numbers), &
                  new_unittest("third moments of point masses", point_masses), &
                  new_unittest("the discrete gradient is exact, its derivatives are those of it", discrete_gradient), &
                  new_unittest("series and power are those of the direction", series_and_power), &
                  new_unittest("a body with third moments by every method", by_methods), &
                  new_unittest("the energy balance closes in long steps", long_steps), &
                  new_unittest("the LVLH frame and inertial axes show the same motion", both_frames), &
                  new_unittest("what is no third degree is refused", refused)]
   end procedure collect_third_degree

   !> The effect at a distance of 1.25, μ = 1, in the LVLH frame.
   type(third_degree_t) function near_body() result(effect)
      effect = third_degree_t(moments, orbit_t(kepler_orbit_t(semi_major_axis=distance)))
   end function near_body

   subroutine numbers(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: other(3) = [0.9_wp, 0.1_wp, 0.2_wp], slope(3) = [0.002491809792_wp, 0.00025755648_wp, &
                                                                             -5.505024e-6_wp]
      type(third_degree_t) :: effect
      real(wp) :: size
      effect = near_body()
      size = norm2(effect%direction)
      call check_close(error, size**3*distance**4, 1.0_wp, 8*eps, 'strength')
      call check_close(error, effect%energy(size*unit), 0.0003460038656_wp, 8*eps*1e-3_wp, 'energy')
      call check_close(error, size*effect%gradient(size*unit), slope, 16*eps*1e-3_wp, 'gradient')
      call check_close(error, size*cross(unit, effect%gradient(size*unit)), &
                       [-0.0001615331328_wp, 0.0015974006784_wp, 0.0016187129856_wp], 16*eps*1e-3_wp, 'torque')
      call check_close(error, size*effect%discrete_gradient(size*unit, size*other), &
                       [0.000934027264_wp, -0.0006295552_wp, 0.001087700992_wp], 16*eps*1e-3_wp, 'discrete gradient')
   end subroutine numbers

   !> Checks point masses at a distance of 4, a third of them at the position of the origin: only their centre counts.
   subroutine point_masses(error)
      type(error_type), allocatable, intent(out) :: error
      type(third_degree_t) :: effect
      real(wp) :: moved(4, 4)
      integer :: i
      effect = third_degree_t(third_moments_of(points), orbit_t(kepler_orbit_t(semi_major_axis=4.0_wp)))
      call check_close(error, effect%energy(norm2(effect%direction)*unit), 8.41444921875e-7_wp, 1e-20_wp, 'energy')
      moved = points
      do i = 1, 4
         moved(2:4, i) = moved(2:4, i) + [0.5_wp, -0.25_wp, 1.0_wp]
      end do
      call check_close(error, third_moments_of(moved), third_moments_of(points), 1e-17_wp, 'moved')
   end subroutine point_masses

   subroutine discrete_gradient(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1e-3_wp
      type(third_degree_t) :: effect
      real(wp) :: a(3), b(3), shift(3), scale
      integer(int64) :: seed
      integer :: i, k
      effect = near_body()
      scale = maxval(abs(effect%moments))
      seed = 11
      do i = 1, 100
         a = random_vector(seed)
         b = random_vector(seed)
         call check_close(error, dot_product(effect%discrete_gradient(a, b), b - a), &
              effect%energy(b) - effect%energy(a), &
                          200*eps*scale, 'exact')
         call check_close(error, effect%discrete_gradient(a, b), &
                          (effect%gradient(a) + 4*effect%gradient(0.5_wp*(a + b)) + effect%gradient(b))/6, &
                          100*eps*scale, 'the mean of the gradient')
         do k = 1, 3
            shift = 0.0_wp
            shift(k) = h
            ! Exact but for round-off: all of them are polynomials of degree 2.
            associate (derivative => effect%hessian(a), mean => effect%discrete_hessian(a, b))
               call check_close(error, (effect%gradient(a + shift) - effect%gradient(a - shift))/(2*h), &
                    derivative(:, k), &
                                1e-11_wp*scale, 'second derivatives')
               call check_close(error, (effect%discrete_gradient(a, b + shift) - effect%discrete_gradient(a, &
                    b - shift)) &
                                /(2*h), mean(:, k), 1e-11_wp*scale, 'derivatives of the discrete gradient')
            end associate
         end do
      end do
   end subroutine discrete_gradient

   !> Checks series and power on a hyperbola.
   subroutine series_and_power(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: h = 1e-4_wp
      type(third_degree_t) :: effect
      real(wp) :: series(3, 0:24), n(3), t, q(4)
      integer(int64) :: seed
      integer :: i, k
      effect = third_degree_t(moments, orbit_t(kepler_orbit_t(periapsis_distance=1.0_wp, eccentricity=1.5_wp, &
                                                              inclination=0.4_wp, raan=0.5_wp, periapsis_time=0.7_wp)))
      seed = 5
      do i = -4, 8
         t = 0.5_wp*i
         q = random_unit_quaternion(seed)
         call effect%direction_series(t, 0.25_wp, series)
         n = series(:, 24)
         do k = 23, 0, -1
            n = 0.5_wp*n + series(:, k)
         end do
         call check_close(error, n, effect%direction_at(t + 0.125_wp), 64*eps, 'series')
         call check_close(error, effect%power(q, t), (energy_at(t + h) - energy_at(t - h))/(2*h), 1e-9_wp, 'power')
         call check_close(error, effect%direction_at(t)*norm2(effect%path%position(t))**(7.0_wp/3), &
                          -effect%path%position(t), 32*eps*norm2(effect%path%position(t)), 'to the attracting body')
      end do

   contains

      real(wp) function energy_at(time)
         real(wp), intent(in) :: time
         energy_at = effect%energy(rotate_to_body(q, effect%direction_at(time)))
      end function energy_at

   end subroutine series_and_power

   !> Runs a scene to the times of a table.
   subroutine check_run(error, text, integrator, rows, bound)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: text, integrator
      real(wp), intent(in) :: rows(:, :), bound
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      character(len=:), allocatable :: message
      real(wp) :: first
      integer :: i
      allocate (scene)
      call parse_scene(text//'&integrator '//integrator//', end_time = 1.0 /', 's.nml', scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      state = scene%initial
      first = total_energy(scene%system, state)
      do i = 1, size(rows, 2)
         scene%plan%end_time = rows(1, i)
         if (rows(1, i) > 0.0_wp) call integrate(scene%system, scene%integrator, state, scene%plan, status)
         call check(error, status%ok(), integrator//': '//trim(status%message))
         if (allocated(error)) return
         call check_close(error, sign(1.0_wp, dot_product(state%q, rows(2:5, i)))*state%q, rows(2:5, i), bound, &
                          integrator//': attitude')
         call check_close(error, angular_velocity(scene%system, state), rows(6:8, i), bound, integrator//': rate')
         call check_close(error, total_energy(scene%system, state), rows(9, i), bound, integrator//': energy')
         if (.not. scene%integrator%conserve .and. scene%integrator%method /= 'nielsen_krenk') cycle
         call check_close(error, total_energy(scene%system, state) - state%time_dependent_work, first, 16*eps, &
                          integrator//': energy balance')
      end do
   end subroutine check_run

   subroutine by_methods(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: bound = 1e-11_wp
      !> The last row of the reference, of the moments of inertia alone.
      real(wp), parameter :: alone(9, 1) = reshape([8.0_wp, -0.9354595080923432_wp, -0.2129053458836512_wp, &
         0.007053434967809646_wp, 0.2820231754110805_wp, 0.01656574237619399_wp, 0.1740235785701431_wp, &
         0.6661031759622199_wp, 0.01852546542859081_wp], [9, 1])
      call check_run(error, flyby, "method = 'taylor', local_tolerance = 1e-15", third, bound)
      call check_run(error, flyby, "method = 'taylor', series_order = 20, time_step = 0.05", third, bound)
      call check_run(error, flyby, 'order = 8, time_step = 0.02', third, bound)
      call check_run(error, flyby, "formulation = 'reduced', order = 8, time_step = 0.02", third, bound)
      call check_run(error, flyby, "formulation = 'reduced', order = 6, time_step = 0.01", third, bound)
      call check_run(error, flyby, "method = 'rk4', time_step = 5e-4", third, bound)
      call check_run(error, flyby, "method = 'rk8', time_step = 0.02", third, bound)
      call check_run(error, flyby, "method = 'dop853', conserve = .true., local_tolerance = 1e-15", third, bound)
      call check_run(error, flyby, 'accuracy = 1e-12', third, bound)
      call check_run(error, body, "method = 'taylor', local_tolerance = 1e-15", alone, bound)
   end subroutine by_methods

   subroutine long_steps(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=9), parameter :: formulations(2) = [character(len=9) :: 'full', 'reduced']
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      character(len=:), allocatable :: message
      real(wp) :: first
      integer :: i
      allocate (scene)
      do i = 1, 2
         call parse_scene(flyby//"&integrator formulation = '"//trim(formulations(i))// &
                          "', time_step = 0.5, end_time = 20.0 /", 's.nml', scene, status, message)
         call check(error, status%ok(), message)
         if (allocated(error)) return
         state = scene%initial
         first = total_energy(scene%system, state)
         call integrate(scene%system, scene%integrator, state, scene%plan, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, total_energy(scene%system, state) - state%time_dependent_work, first, 64*eps, &
                          'energy balance')
         call check(error, abs(total_energy(scene%system, state) - first) > 1e-3_wp, 'the energy itself changes')
      end do
   end subroutine long_steps

   !> Compares both frames on a circular orbit.
   subroutine both_frames(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=8), parameter :: frames(2) = [character(len=8) :: 'lvlh', 'inertial']
      class(scene_t), allocatable :: scene
      type(state_t) :: state
      type(status_t) :: status
      character(len=:), allocatable :: message
      real(wp) :: omega(3, 2)
      integer :: i
      allocate (scene)
      do i = 1, 2
         call parse_scene('&body inertia = 0.05, 0.06, 0.075 /'//nl// &
              "&orbit mu = 1.0, semi_major_axis = 1.0, frame = '"// &
                          trim(frames(i))//"' /"//nl//'&gravity_gradient /'//nl// &
                               '&third_degree points = 1.0, 0.12, 0.0, '// &
                          '0.0, 2.0, 0.0, 0.09, 0.0, 3.0, -0.02, -0.03, 0.08, 4.0, -0.015, -0.0225, -0.06 /'//nl// &
                          "&initial roll_pitch_yaw = 0.3, 0.2, 0.1, attitude_from = 'lvlh', "// &
                          'angular_velocity = 3*0.0, '// &
                          "rate_from = 'lvlh' /"//nl//"&integrator method = 'taylor', local_tolerance = 1e-15, "// &
                          'end_time = 5.0 /', 's.nml', scene, status, message)
         call check(error, status%ok(), message)
         if (allocated(error)) return
         state = scene%initial
         call integrate(scene%system, scene%integrator, state, scene%plan, status)
         omega(:, i) = angular_velocity(scene%system, state)
      end do
      call check_close(error, omega(:, 1), omega(:, 2), 1e-13_wp, 'rate')
   end subroutine both_frames

   !> Fails unless a group is refused with certain words.
   subroutine expect(error, group, words, orbit)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: group, words
      logical, intent(in), optional :: orbit
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message, text
      allocate (scene)
      text = '&orbit semi_major_axis = 7e6 /'
      if (present(orbit)) text = '!'
      call parse_scene('&body inertia = 1.0, 1.5, 2.2 /'//nl//text//nl//'&third_degree '//group//' /'//nl// &
                       '&initial angular_velocity = 3*0.0 /'//nl//'&integrator time_step = 0.01, end_time = 1.0 /', &
                       's.nml', scene, status, message)
      call check(error, .not. status%ok(), 'accepted: '//group)
      call check(error, index(message, words) > 0, message)
   end subroutine expect

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      call expect(error, 'third_moments = 10*0.0', 's.nml:3: gravity of third degree needs an orbit', orbit=.false.)
      call expect(error, '', 's.nml:3: gravity of third degree needs third_moments, points or a table')
      call expect(error, 'third_moments = 10*1.0, points = 4*1.0', &
           's.nml:3: gravity of third degree needs third_moments')
      call expect(error, 'third_moments = 9*1.0', 's.nml:3: third_moments has 9 values')
      call expect(error, 'points = 5*1.0', 's.nml:3: the number of values of points is no multiple of 4')
      call expect(error, 'points = 1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0', &
           's.nml:3: the mass of a point is out of range')
      call expect(error, 'points = 1.0, 1e30, 0.0, 0.0', 's.nml:3: the position of a point is out of range')
      call expect(error, "points = 1.0, 0.0, 0.0, 0.0, orbit = 'b'", "s.nml:3: no orbit is called 'b'")
      call expect(error, "table = 'absent.csv'", "s.nml:3: table 'absent.csv' cannot be read")
   end subroutine refused

end submodule test_third_degree
