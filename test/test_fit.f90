!> Fits of scenes: standard errors at the truth, the radar attitudes of Toutatis, starts, and errors of random fits.
submodule(suites_of_methods) test_fit
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_attitude, only: quat_from_rotation_vector
   use nutate_fit, only: fit_scene, fit_t
   use nutate_fit_model, only: fit_model_t, motion_at_t
   use nutate_hamiltonian, only: body_momentum, system_t
   use nutate_fit_residuals, only: inverse_right_jacobian, residuals_t, right_jacobian
   use nutate_attitude, only: rotation_vector_from_quat
   use nutate_kinds, only: wp, pi
   use nutate_least_squares, only: UNKNOWN_BELOW
   use nutate_normal_quantile, only: normal_quantile
   use nutate_quaternion, only: quat_conjugate, quat_normalized, quat_product
   use nutate_scene, only: parse_scene, scene_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_STEP_LIMIT
   use test_support, only: check, check_below, check_close, draws_fewer, error_type, new_unittest, one_in, &
      random_unit, random_unit_quaternion, random_vector, test_failed
   implicit none

   character, parameter :: lf = achar(10)
   !> A satellite whose magnet an event switches off at 0.25 s, whose wheel comes to the limit of its speed at 0.2 s,
   !> whose thruster has a window, and whose controller comes to its limit and leaves it.
   character(len=*), parameter :: switched = "&body inertia = 4, 5, 6 /"//lf// &
      "&initial quaternion = 0.5, -0.5, 0.5, 0.5, angular_velocity = 1, -2, 3 /"//lf// &
      "&dipole name = 'magnet', moment = 1, -2, 3, field = 0.5, 1, -1 /"//lf// &
      "&torque name = 'thruster', body = 0.5, 2, -1, start = 0.1, stop = 0.5 /"//lf// &
      "&wheel axis = 2, -1, 2, inertia = 0.3, speed = 5, torque = 1.5, speed_limit = 6 /"//lf// &
      "&controller law = 'quaternion', attitude_gain_matrix = 3*2, rate_gain_matrix = 3*1.2, limit = 1.3 /"//lf// &
      "&event when = 'omega1', crosses = 1.3, switch = 'magnet toggle', stop = .true. /"//lf// &
      "&integrator method = 'nielsen_krenk', order = 8, time_step = 0.02, end_time = 1 /"//lf
   !> Files that scenes name; `measure` replaces their rows.
   character(len=*), parameter :: rates_file = 'test/fit_rates.csv', attitudes_file = 'test/fit_attitudes.csv', &
                                  heading_file = 'test/fit_heading.csv', energies_file = 'test/fit_energies.csv'
   character(len=*), parameter :: rates = "&measurement file = '"//rates_file// &
      "', columns = 'omega1', 'omega2', 'omega3'"
   character(len=*), parameter :: gyroscope = "&body inertia = 5, 20, 17 /"//lf// &
                                  "&initial angular_velocity = 3, 1, 5 /"//lf// &
                                  "&integrator local_tolerance = 1e-11, end_time = 10 /"//lf// &
                                  "&free key = 'initial.angular_velocity' /"//lf

contains

   module procedure collect_fit
      testsuite = [ &
                  new_unittest("standard_errors_of_a_gyroscope", test_gyroscope), &
                  new_unittest("standard_errors_of_a_compass", test_compass), &
                  new_unittest("radar_attitudes_of_Toutatis", test_toutatis), &
                  new_unittest("a_free_body_gives_ratios_of_moments_only", test_ratios), &
                  new_unittest("a_compass_gives_ratios_only", test_compass_ratios), &
                  new_unittest("a_steady_spin_gives_no_moment", test_steady_spin), &
                  new_unittest("errors_of_random_fits_are_their_standard_errors", test_random_fits), &
                  new_unittest("growing_arcs_arrive_where_the_whole_record_does_not", test_arcs), &
                  new_unittest("rates_give_ratios_of_moments_without_a_fit", test_data_start), &
                  new_unittest("the_same_fit_from_degrees_and_space_axes", test_units), &
                  new_unittest("outliers_and_a_prior", test_prior_and_loss), &
                  new_unittest("columns_of_free_numbers_are_differences_of_runs", test_columns), &
                  new_unittest("the_derivative_of_the_logarithm", test_logarithm), &
                  new_unittest("columns_of_free_numbers_cross_switches_and_limits", test_switched_columns), &
                  new_unittest("a_fit_crosses_switches_and_limits", test_switched_fit), &
                  new_unittest("data_that_begin_late_are_fitted_from_where_they_begin", test_late_data), &
                  new_unittest("a_run_of_hopeless_numbers_ends", test_hopeless), &
                  new_unittest("what_cannot_be_fitted_is_rejected", test_rejections)]
   end procedure collect_fit

   !> Reads a scene.
   subroutine read(text, scene, error)
      character(len=*), intent(in) :: text
      type(scene_t), intent(inout) :: scene
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(text, 'fit.nml', scene, status, message)
      if (.not. status%ok()) call test_failed(error, message)
   end subroutine read

   !> Gives each measurement of a scene what its motion is at given times, with noise of its sigma.
   subroutine measure(scene, times, error, seed)
      type(scene_t), intent(inout) :: scene
      real(wp), intent(in) :: times(:)
      type(error_type), allocatable, intent(inout) :: error
      !> Seed of the noise; absent: no noise.
      integer(int64), intent(inout), optional :: seed
      class(fit_model_t), allocatable :: model
      type(residuals_t) :: residuals
      type(motion_at_t) :: motion
      type(system_t) :: system
      type(status_t) :: status
      real(wp) :: noise(4)
      integer :: i, k, c
      allocate (model)
      if (allocated(error)) return
      call model%prepare(scene, status)
      if (status%ok()) call model%states_at(times, motion, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      system = scene%system
      do i = 1, size(scene%fit%measurements)
         residuals = residuals_t()
         call residuals%prepare(scene%fit%measurements(i), scene%system, 0.0_wp, status)
         associate (measurement => scene%fit%measurements(i))
            measurement%times = times
            if (allocated(measurement%rows)) deallocate (measurement%rows)
            allocate (measurement%rows(size(measurement%columns), size(times)))
            do k = 1, size(times)
               call motion%switches(k)%apply(system%effects)
               measurement%rows(:, k) = residuals%model(system, motion%states(k))
            end do
            if (.not. present(seed)) cycle
            do k = 1, size(times)
               noise = [(normal_quantile(random_unit(seed)), c=1, 4)]
               if (size(measurement%columns) == 4) then
                  measurement%rows(:, k) = quat_product(measurement%rows(:, k), &
                                                        quat_from_rotation_vector(measurement%sigma*noise(:3)))
               else
                  measurement%rows(:, k) = measurement%rows(:, k) + measurement%sigma*noise(:size(measurement%sigma))
               end if
            end do
         end associate
      end do
   end subroutine measure

   subroutine fit_and_check(scene, fit, error)
      type(scene_t), intent(in) :: scene
      type(fit_t), intent(out) :: fit
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      if (allocated(error)) return
      call fit_scene(scene, fit, status)
      call check(error, status%ok(), trim(status%message))
   end subroutine fit_and_check

   pure function every(interval, n) result(times)
      real(wp), intent(in) :: interval
      integer, intent(in) :: n
      real(wp) :: times(n)
      integer :: i
      times = [(interval*i, i=1, n)]
   end function every

   !> shared/reference/tangent.md, section 10.
   subroutine test_gyroscope(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: errors(8) = [1.44392383273e-3_wp, 4.15230193256e-4_wp, 4.58307514772e-4_wp, &
         4.64752292636e-3_wp, 2.47016127864e-3_wp, 1.31774121343e-3_wp, 3.17557425618e-4_wp, 3.17158611193e-4_wp]
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      allocate (scene, fit)
      call read("&body inertia = 5, 20, 17 /&initial angular_velocity = 3, 1, 5 /&integrator time_step = 0.01, "// &
                "method = 'nielsen_krenk', order = 4, end_time = 10 /&free key = 'initial.angular_velocity' /"// &
                "&free key = 'body.inertia.1', 'body.inertia.2' /"//rates//", sigma = 0.01, bias = 'constant' /", &
                   scene, error)
      call measure(scene, every(0.01_wp, 1000), error)
      call fit_and_check(scene, fit, error)
      if (allocated(error)) return
      call check_close(error, fit%result%standard_errors()/errors, spread(1.0_wp, 1, 8), 2e-8_wp)
      associate (covariance => fit%result%covariance)
         call check_close(error, covariance(4, 1)/sqrt(covariance(1, 1)*covariance(4, 4)), 0.981588540548_wp, 2e-9_wp)
      end associate
      call check_below(error, maxval(abs(fit%result%x - [3.0_wp, 1.0_wp, 5.0_wp, 5.0_wp, 20.0_wp, 0.0_wp, 0.0_wp, &
         0.0_wp])/ &
                                     errors), 1e-6_wp)
   end subroutine test_gyroscope

   !> A compass needle, of which heading, rate, damping and moment are free.
   subroutine read_compass(more, scene, error)
      character(len=*), intent(in) :: more
      type(scene_t), intent(inout) :: scene
      type(error_type), allocatable, intent(inout) :: error
      call read("&body shape = 'box', size = 0.06, 0.005, 0.0005, density = 7800 /"//lf// &
                "&dipole moment = 0.1, 0, 0, field = 20e-6, 0, 0 /"//lf// &
                "&damping coefficient = 0, 0, 7e-8 /"//lf// &
                "&initial euler = 150, 0, 0, angular_velocity = 0, 0, 0, degrees = .true. /"//lf// &
                "&integrator local_tolerance = 1e-11, end_time = 60 /"//lf// &
                "&free key = 'initial.euler.1', 'initial.angular_velocity.3' /"//lf// &
                "&free key = 'damping.coefficient.3', 'dipole.moment.1' /"//lf//more// &
                "&measurement file = '"//heading_file//"', columns = 'phi_deg', sigma = 1 /", scene, error)
      call measure(scene, every(0.5_wp, 120), error)
   end subroutine read_compass

   !> shared/reference/tangent.md, section 10.
   subroutine test_compass(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: errors(4) = [1.0946620550_wp, 2.7971862234_wp, 4.33752654384e-10_wp, 1.02842308003e-4_wp]
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      allocate (scene, fit)
      call read_compass('', scene, error)
      call fit_and_check(scene, fit, error)
      if (allocated(error)) return
      call check_close(error, fit%result%standard_errors()/errors, spread(1.0_wp, 1, 4), 1e-6_wp)
      associate (covariance => fit%result%covariance)
         call check_close(error, covariance(3, 4)/sqrt(covariance(3, 3)*covariance(4, 4)), -0.3755934486_wp, 1e-6_wp)
      end associate
   end subroutine test_compass

   !> shared/reference/tangent.md, section 10. Takahashi, Busch & Scheeres (2013) published 3.0836 and 3.235.
   subroutine test_toutatis(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: rate = 1/86400.0_wp
      character(len=*), parameter :: crude(2) = [character(len=72) :: &
         'initial.angular_velocity=-4.1204E-4,8.3333E-5,-1.12269E-3', 'fit.start=scene']
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      type(status_t) :: status
      character(len=:), allocatable :: message
      real(wp) :: errors(8)
      integer :: pass
      allocate (scene, fit)
      do pass = 1, 2
         if (pass == 1) call parse(['body.inertia=3,3,1'])
         if (pass == 2) call parse([character(len=72) :: 'body.inertia=3,3,1', crude])
         call check(error, status%ok(), message)
         call fit_and_check(scene, fit, error)
         if (allocated(error)) return
         errors = fit%result%standard_errors()
         associate (result => fit%result, q => fit%problem%model%plan%attitude)
            call check_close(error, result%chi_squared, 34.247024949_wp, 1e-7_wp)
            call check(error, result%degrees_of_freedom, 43)
            call check_close(error, q*sign(1.0_wp, -q(1)), [-0.258689230_wp, 0.644752057_wp, 0.061284541_wp, &
                                                            0.716672082_wp], 2e-9_wp)
            call check_close(error, result%x(4:6)/rate, [-38.1804508_wp, -2.4014233_wp, -97.8520831_wp], 1e-6_wp)
            call check_close(error, errors(4:6)/rate, [3.31_wp, 1.89_wp, 2.39_wp], 0.005_wp)
            call check_close(error, result%x(7:8), [2.97785949_wp, 3.22207447_wp], 1e-7_wp)
            call check_close(error, errors(7:8), [0.214_wp, 0.253_wp], 0.0005_wp)
            call check_close(error, result%covariance(7, 8)/(errors(7)*errors(8)), -0.885_wp, 0.0005_wp)
         end associate
      end do
   contains
      subroutine parse(overrides)
         use nutate_scene, only: read_scene
         character(len=*), intent(in) :: overrides(:)
         call read_scene('scenes/toutatis.nml', scene, status, message, overrides)
      end subroutine parse
   end subroutine test_toutatis

   !> All three moments of a free body are free.
   subroutine test_ratios(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      integer :: n
      allocate (scene, fit)
      call read(gyroscope//"&free key = 'body.inertia' /"//rates//', sigma = 0.01 /', scene, error)
      call measure(scene, every(0.02_wp, 200), error)
      call fit_and_check(scene, fit, error)
      if (allocated(error)) return
      n = size(fit%result%x)
      call check(error, count(fit%result%singular_values < UNKNOWN_BELOW), 1)
      call check(error, all(fit%result%unidentified .eqv. [.false., .false., .false., .true., .true., .true.]))
      ! The direction is J itself.
      associate (direction => fit%result%directions(:, n))
         call check_close(error, direction(4:6)/direction(4), fit%result%x(4:6)/fit%result%x(4), 1e-7_wp)
      end associate
   end subroutine test_ratios

   subroutine test_compass_ratios(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      allocate (scene, fit)
      call read_compass("&free key = 'body.density' /"//lf, scene, error)
      call fit_and_check(scene, fit, error)
      if (allocated(error)) return
      call check(error, count(fit%result%singular_values < UNKNOWN_BELOW), 1)
      call check(error, all(fit%result%unidentified .eqv. [.false., .false., .true., .true., .true.]))
      associate (change => fit%result%directions(3:5, 5)/fit%result%x(3:5))
         call check_close(error, change/change(1), [1.0_wp, 1.0_wp, 1.0_wp], 1e-7_wp)
      end associate
   end subroutine test_compass_ratios

   subroutine test_steady_spin(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      allocate (scene, fit)
      call read("&body inertia = 5, 20, 17 /&initial angular_velocity = 0, 0, 5 /"// &
                "&integrator local_tolerance = 1e-11, end_time = 10 /"// &
                "&free key = 'initial.angular_velocity', 'body.inertia' /"//rates//', sigma = 0.01 /', scene, error)
      call measure(scene, every(0.05_wp, 20), error)
      call fit_and_check(scene, fit, error)
      if (allocated(error)) return
      call check(error, all(fit%result%unidentified .eqv. [.false., .false., .false., .true., .true., .true.]))
   end subroutine test_steady_spin

   !> Random bodies, seen by a gyroscope and a star tracker with noise.
   subroutine test_random_fits(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      real(wp) :: j(3), squares, omega(3), truth(8), off(8)
      integer(int64) :: seed
      integer :: i, fits, n
      character(len=400) :: start
      allocate (scene, fit)
      seed = 20261125_int64
      fits = merge(merge(20, 40, one_in() > 3), 200, draws_fewer())
      squares = 0.0_wp
      n = 0
      do i = 1, fits
         do
            j = [1 + 4*random_unit(seed), 1 + 4*random_unit(seed), 2.0_wp]
            if (2*maxval(j) < 0.95_wp*sum(j)) exit
         end do
         omega = 2*random_vector(seed) + [0.5_wp, 0.5_wp, 0.5_wp]
         write (start, &
            '("&body inertia =",3es24.16," / &initial quaternion =",4es24.16,", angular_velocity =",3es24.16," /")') &
            j, random_unit_quaternion(seed), omega
         call read(trim(start)//"&integrator local_tolerance = 1e-10, end_time = 5 /"// &
                   "&free key = 'initial.attitude', 'initial.angular_velocity', "// &
                   "'body.inertia.1', 'body.inertia.2' /"// &
                   rates//", sigma = 0.01 /&measurement file = '"//attitudes_file// &
                   "', columns = 'q0', 'q1', 'q2', 'q3', sigma = 0.02 /&fit start = 'scene', arcs = 'whole' /", &
                      scene, error)
         call measure(scene, every(0.1_wp, 50), error, seed)
         call fit_and_check(scene, fit, error)
         if (allocated(error)) return
         truth = [0.0_wp, 0.0_wp, 0.0_wp, omega, j(:2)]
         off = fit%result%x - truth
         off(:3) = rotation_vector_from_quat(quat_product([1.0_wp, -1.0_wp, -1.0_wp, -1.0_wp]*scene%initial%q, &
                                                          fit%problem%model%plan%attitude))
         squares = squares + sum((off/fit%result%standard_errors())**2)
         n = n + size(off)
      end do
      call check_close(error, sqrt(squares/n), 1.0_wp, 0.1_wp)
   end subroutine test_random_fits

   !> shared/reference/tangent.md, section 10: of random moments growing arcs find the minimum, the whole record does
   !> not; from the ratios that the data give, every start does.
   subroutine test_arcs(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene, own
      class(fit_t), allocatable :: fit
      type(status_t) :: status
      real(wp) :: ratios(2)
      integer(int64) :: seed
      integer :: i, starts, arrived(3), way
      allocate (scene, fit)
      seed = 40_int64
      starts = merge(merge(1, 3, one_in() > 3), 40, draws_fewer())
      arrived = 0
      ! Fixed steps, which cost the same however fast the motions are that the fits try.
      call read("&body inertia = 5, 20, 17 /&initial angular_velocity = 3, 1, 5 /&integrator time_step = 0.02, "// &
                "method = 'nielsen_krenk', formulation = 'reduced', order = 4, end_time = 10 /"// &
                "&free key = 'initial.angular_velocity', 'body.inertia.1', 'body.inertia.2' /"//rates// &
                ", sigma = 0.01 /&fit start = 'scene' /", scene, error)
      call measure(scene, every(0.02_wp, 500), error, seed)
      if (allocated(error)) return
      do i = 1, starts
         do
            ratios = exp([2.3_wp*(2*random_unit(seed) - 1), 2.3_wp*(2*random_unit(seed) - 1)])
            if (abs(ratios(1) - ratios(2)) < 1.0_wp .and. sum(ratios) > 1.0_wp) exit
         end do
         if (allocated(own)) deallocate (own)
         allocate (own, source=scene)
         do way = 1, 3
            own%fit%grows = way == 1
            own%fit%starts_from_data = way == 3
            associate (inertia => own%fit%numbers%groups(1)%settings(1)%values)
               inertia(:2)%number = 17*ratios
            end associate
            call fit_scene(own, fit, status)
            if (fit%best == 0) cycle
            if (fit%result%chi_squared < 1.2_wp*fit%result%degrees_of_freedom) arrived(way) = arrived(way) + 1
         end do
      end do
      if (allocated(error)) return
      call check(error, arrived(1) >= max(1, (8*starts)/10), 'growing arcs arrive too rarely')
      call check(error, arrived(2) <= starts/4, 'the whole record arrives too often')
      call check(error, arrived(3), starts, 'from the data')
   end subroutine test_arcs

   !> Moments of the wrong order in the scene.
   subroutine test_data_start(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      real(wp) :: errors(5)
      integer(int64) :: seed
      allocate (scene, fit)
      seed = 7_int64
      call read(gyroscope//"&free key = 'body.inertia.1', 'body.inertia.2' /"//rates//", sigma = 0.01 /"// &
                "&fit arcs = 'whole' /", scene, error)
      call measure(scene, every(0.02_wp, 500), error, seed)
      if (allocated(error)) return
      scene%fit%numbers%groups(1)%settings(1)%values(:2)%number = [20.0_wp, 5.0_wp]
      call fit_and_check(scene, fit, error)
      if (allocated(error)) return
      call check(error, fit%best, 2)
      errors = fit%result%standard_errors()
      call check_below(error, maxval(abs(fit%result%x(4:5) - [5.0_wp, 20.0_wp])/errors(4:5)), 4.0_wp)
      call check_below(error, real(fit%result%iterations, wp), 10.0_wp)
   end subroutine test_data_start

   !> Rates of the scene in degrees and in space axes: the same motion, and the same errors.
   subroutine test_units(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: plain, other
      character(len=*), parameter :: rest = "&integrator local_tolerance = 1e-11, end_time = 2 /"//lf// &
         "&free key = 'initial.attitude', 'initial.angular_velocity' /&measurement file = '"//attitudes_file// &
         "', columns = 'q0', 'q1', 'q2', 'q3', sigma = 0.02 /"
      real(wp), parameter :: degree = pi/180
      real(wp), allocatable :: a(:), b(:)
      allocate (scene, plain, other)
      call read("&body inertia = 5, 20, 17 /&initial axis = 0, 0, 1, angle = 90, angular_velocity = 3, 1, 5, "// &
                "degrees = .true. /"//rest, scene, error)
      call measure(scene, every(0.1_wp, 20), error)
      call fit_and_check(scene, plain, error)
      if (allocated(error)) return
      call read("&body inertia = 5, 20, 17 /&initial axis = 0, 0, 1, angle = 90, angular_velocity = -1, 3, 5, "// &
                "frame = 'space', degrees = .true. /"//rest, scene, error)
      call measure(scene, every(0.1_wp, 20), error)
      call fit_and_check(scene, other, error)
      if (allocated(error)) return
      ! Components 1 and 2 in space are 2 and 1 of the body, when the attitude is held; where it is free as well, its
      ! error adds to them.
      a = plain%result%standard_errors()
      b = other%result%standard_errors()
      call check_close(error, b(1:3), a(1:3), 1e-7_wp*maxval(a))
      associate (c => plain%result%covariance)
         ! δω_space = R(δΩ + θ×Ω), of which component 3 is δΩ3 + θ1Ω2 - θ2Ω1.
         call check_close(error, other%result%covariance(6, 6), c(6, 6) + degree**2*(c(1, 1) - 6*c(1, 2) + 9*c(2, &
            2)) + &
                          2*degree*(c(6, 1) - 3*c(6, 2)), 1e-7_wp*c(6, 6))
      end associate
   end subroutine test_units

   subroutine test_prior_and_loss(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      type(status_t) :: status
      integer(int64) :: seed
      allocate (scene, fit)
      seed = 11_int64
      call read(gyroscope//"&free key = 'body.inertia.1', sigma = 1e-6 /"//rates// &
                ", sigma = 0.01, loss = 'cauchy' /&fit start = 'scene' /", scene, error)
      call measure(scene, every(0.02_wp, 200), error, seed)
      if (allocated(error)) return
      scene%fit%measurements(1)%rows(2, [30, 60, 61, 150]) = 40.0_wp
      call fit_scene(scene, fit, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      call check_close(error, fit%result%x(:3), [3.0_wp, 1.0_wp, 5.0_wp], 0.005_wp)
      ! The data know the moment less well than the scene says.
      associate (errors => fit%result%standard_errors())
         call check_close(error, errors(4), 1e-6_wp, 1e-9_wp)
      end associate
   end subroutine test_prior_and_loss

   !> Numbers of start, body and effects, by the chain rule.
   subroutine test_columns(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: motion = "&integrator method = 'nielsen_krenk', order = 4, time_step = 0.02, "// &
                                     "end_time = 1 /"//lf
      character(len=*), parameter :: rest = "&measurement file = '"//rates_file//"', columns = 'omega1' /"
      call compare_columns(error, &
         "&body shape = 'box', size = 1, 0.6, 0.3, density = 5, center_of_mass = 0.1, 0.2, 0.3 /"// &
                           "&initial euler = 20, 40, 60, euler_rates = 10, -20, 90, degrees = .true. /"// &
                           "&gravity acceleration = 0.5, 1, -9 /"//motion// &
                           "&free key = 'body.size', 'body.density', 'body.center_of_mass', 'initial.euler', "// &
                           "'initial.euler_rates', 'gravity.acceleration' /"//rest)
      call compare_columns(error, "&body inertia_tensor = 2, 1.5, 1, 0.1, 0.05, -0.1 /"// &
                           "&initial roll_pitch_yaw = 0.2, 0.4, 0.6, angular_velocity = 1, -0.5, 0.8, "// &
                           "frame = 'space' /"// &
                           "&dipole moment = 0.3, 0, 1, field = 0, 0.6, -0.8 /"// &
                           "&damping coefficient = 0.2, 0.1, 0.05 /"// &
                           "&spring body_point = 0.1, 0.2, 0.5, anchor = 0.3, -0.4, 0.9, "// &
                           "stiffness = 5, rest_length = 0.4 /"// &
                           "&rotor momentum = 0.1, 0.2, 0.3 /"//motion// &
                           "&free key = 'body.inertia_tensor', 'initial.attitude', 'initial.angular_velocity' /"// &
                           "&free key = 'dipole.moment', 'dipole.field', 'damping.coefficient', 'rotor.momentum' /"// &
                           "&free key = 'spring.body_point', 'spring.anchor', 'spring.stiffness', "// &
                           "'spring.rest_length' /"// &
                           rest)
      call compare_columns(error, "&body inertia = 2, 1.5, 1, mass = 3 /&initial axis = 1, 2, 3, angle = 0.7, "// &
                           "angular_velocity = 1, -0.5, 0.8 /"// &
                           "&torque body = 0.3, 0.2, 0.1, frequency = 0.4, phase = 0.3 /"// &
                           "&gravity_gradient direction = 0, 0.6, 0.7, strength = 0.8 /"// &
                           "&wheel axis = 0, 0.6, 0.8, inertia = 0.1, speed = 20, friction = 0.01 /"//motion// &
                           "&free key = 'body.inertia', 'initial.angle', 'torque.body', 'torque.frequency', "// &
                           "'torque.phase' /&free key = 'wheel.inertia', 'wheel.speed', 'wheel.friction', "// &
                           "'gravity_gradient.strength', 'gravity_gradient.direction' /"//rest)
   end subroutine test_columns

   !> Checks derivatives with respect to the initial state, the body, switched effects, and effects that come to a
   !> limit.
   subroutine test_switched_columns(error)
      type(error_type), allocatable, intent(out) :: error
      call compare_columns(error, switched//"&free key = 'initial.angular_velocity', 'body.inertia' /"//lf// &
                           "&free key = 'dipole.moment', 'dipole.field', 'torque.body' /"//lf// &
                           "&free key = 'wheel.inertia', 'wheel.speed', 'wheel.torque' /"//lf// &
                           "&measurement file = '"//rates_file//"', columns = 'omega1' /")
   end subroutine test_switched_columns

   !> Without noise, from a start off by some percent. The energy has the potential of the magnet where that is on.
   subroutine test_switched_fit(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: truth(6) = [1.0_wp, -2.0_wp, 3.0_wp, -2.0_wp, 2.0_wp, 0.3_wp]
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene, fit)
      call read(switched//"&free key = 'initial.angular_velocity', 'dipole.moment.2', 'torque.body.2' /"//lf// &
                "&free key = 'wheel.inertia' /"//rates//", sigma = 0.01 /"//lf// &
                "&measurement file = '"//energies_file//"', columns = 'potential', 'total', sigma = 0.05 /"//lf// &
                "&fit start = 'scene' /", scene, error)
      call measure(scene, every(0.05_wp, 20), error)
      if (allocated(error)) return
      call check(error, count(abs(scene%fit%measurements(2)%rows(1, :)) > 0.0_wp) < 10, 'the magnet is off for a time')
      call set_numbers(scene, 'initial', 'angular_velocity', [1.04_wp, -1.93_wp, 3.05_wp])
      call set_numbers(scene, 'dipole', 'moment', [1.0_wp, -2.1_wp, 3.0_wp])
      call set_numbers(scene, 'torque', 'body', [0.5_wp, 1.9_wp, -1.0_wp])
      call set_numbers(scene, 'wheel', 'inertia', [0.31_wp])
      call fit_and_check(scene, fit, error)
      if (allocated(error)) return
      ! The last steps are those of Newton's method.
      call check_close(error, fit%result%x, truth, 1e-8_wp*maxval(abs(truth)))
      call check(error, fit%result%iterations <= 8, 'iterations')
      call parse_scene(switched//"&controller law = 'quaternion', attitude_gain = 1, rate_gain = 1, "// &
                       "sample = 0.1 /&free key = 'wheel.inertia' /"//lf//rates//' /', 'fit.nml', scene, &
                       status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      call fit_scene(scene, fit, status)
      call check(error, index(status%message, 'a controller that samples has no derivative') > 0, trim(status%message))
   end subroutine test_switched_fit

   !> Rates after fifty turns of a free body, and attitudes of a top in a field after some turns: the fits need no more
   !> runs than those of data that begin at once.
   subroutine test_late_data(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      real(wp) :: errors(5)
      integer(int64) :: seed
      allocate (scene, fit)
      seed = 13_int64
      call read(gyroscope//"&free key = 'body.inertia.1', 'body.inertia.2' /"//rates//", sigma = 0.01 /"//lf// &
                "&fit start = 'scene' /", scene, error)
      scene%plan%end_time = 100.0_wp
      call measure(scene, 50 + every(0.02_wp, 200), error, seed)
      if (allocated(error)) return
      call set_numbers(scene, 'initial', 'angular_velocity', [3.1_wp, 0.9_wp, 5.1_wp])
      call set_numbers(scene, 'body', 'inertia', [5.3_wp, 19.4_wp, 17.0_wp])
      call fit_and_check(scene, fit, error)
      if (allocated(error)) return
      errors = fit%result%standard_errors()
      call check_below(error, maxval(abs(fit%result%x - [3.0_wp, 1.0_wp, 5.0_wp, 5.0_wp, 20.0_wp])/errors), 4.0_wp)
      call check(error, fit%problem%model%runs <= 80, 'runs of a free body')
      call read("&body inertia = 2, 1.5, 1 /&dipole moment = 0.3, 0.1, 1, field = 0, 0, -1 /"//lf// &
                "&initial quaternion = 0.8, 0.4, -0.4, 0.2, angular_velocity = 0.4, -0.3, 2 /"//lf// &
                "&integrator local_tolerance = 1e-11, end_time = 20 /"//lf// &
                "&free key = 'initial.attitude', 'initial.angular_velocity', 'dipole.moment.1' /"//lf// &
                "&measurement file = '"//attitudes_file//"', columns = 'q0', 'q1', 'q2', 'q3', sigma = 0.01 /", &
                scene, error)
      call measure(scene, 10 + every(0.1_wp, 40), error)
      if (allocated(error)) return
      call set_numbers(scene, 'initial', 'angular_velocity', [0.5_wp, -0.2_wp, 2.1_wp])
      call set_numbers(scene, 'dipole', 'moment', [0.35_wp, 0.1_wp, 1.0_wp])
      call fit_and_check(scene, fit, error)
      if (allocated(error)) return
      call check_close(error, fit%result%x, [0.0_wp, 0.0_wp, 0.0_wp, 0.4_wp, -0.3_wp, 2.0_wp, 0.3_wp], 1e-6_wp)
      call check_close(error, fit%problem%model%plan%attitude*sign(1.0_wp, fit%problem%model%plan%attitude(1)), &
                       [0.8_wp, 0.4_wp, -0.4_wp, 0.2_wp], 1e-6_wp)
      call check(error, fit%problem%model%runs <= 80, 'runs of a top')
   end subroutine test_late_data

   !> Sets numbers of a scene that is to be fitted.
   subroutine set_numbers(scene, group, key, numbers)
      type(scene_t), intent(inout) :: scene
      character(len=*), intent(in) :: group, key
      real(wp), intent(in) :: numbers(:)
      integer :: i, k
      associate (groups => scene%fit%numbers%groups)
         i = findloc(groups%name == group, .true., dim=1)
         k = findloc(groups(i)%settings%name == key, .true., dim=1)
         groups(i)%settings(k)%values%number = numbers
      end associate
   end subroutine set_numbers

   !> A body that spins a million times as fast as the one that is measured.
   subroutine test_hopeless(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_model_t), allocatable :: model
      type(motion_at_t) :: motion
      type(status_t) :: status
      real(wp) :: times(1)
      allocate (scene, model)
      call read(gyroscope//rates//' /', scene, error)
      if (allocated(error)) return
      times = 1.0_wp
      ! A method whose steps are as long as the motion permits.
      scene%integrator%method = 'nielsen_krenk'
      scene%integrator%order = 8
      call model%prepare(scene, status)
      if (status%ok()) call model%run(times, motion, status)
      call check(error, status%ok(), trim(status%message))
      call model%set_values(1e6_wp*model%values, status)
      if (status%ok()) call model%run(times, motion, status)
      call check(error, status%code, NUTATE_STEP_LIMIT)
      call model%set_values(1e-6_wp*model%values, status)
      if (status%ok()) call model%run(times, motion, status)
      call check(error, status%ok(), 'the fit goes on: '//trim(status%message))
   end subroutine test_hopeless

   !> Compares the columns of a scene's free numbers with differences of its runs.
   subroutine compare_columns(error, text)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: text
      class(scene_t), allocatable :: scene
      class(fit_model_t), allocatable :: model, other
      type(motion_at_t) :: motion, moved
      type(status_t) :: status
      real(wp), allocatable :: values(:), column(:)
      integer :: i, k
      allocate (scene, model)
      call read(text, scene, error)
      if (allocated(error)) return
      call model%prepare(scene, status)
      if (status%ok()) call model%set_values(model%values, status)
      if (status%ok()) call model%run([0.7_wp], motion, status)
      call check(error, status%ok(), trim(status%message))
      if (allocated(error)) return
      do i = 1, size(model%values)
         column = 0*motion%sensitivities(:, i, 1)
         do k = 1, 4
            if (allocated(other)) deallocate (other)
            allocate (other, source=model)
            values = model%values
            values(i) = values(i) + model%offsets(k, i)
            call other%set_values(values, status)
            if (status%ok()) call other%states_at([0.7_wp], moved, status)
            call check(error, status%ok(), trim(status%message))
            if (allocated(error)) return
            column = column + model%weights(k, i)*[rotation_vector_from_quat(quat_product( &
               quat_conjugate(motion%states(1)%q), moved%states(1)%q)), body_momentum(moved%states(1)), &
               moved%states(1)%wheel_momentum(:size(column) - 6)]
         end do
         call check_close(error, motion%sensitivities(:, i, 1), column, 2e-9_wp*maxval(abs(column)), &
                          trim(model%plan%free(i)%name))
      end do
   end subroutine compare_columns

   subroutine test_logarithm(error)
      type(error_type), allocatable, intent(out) :: error
      integer(int64) :: seed
      real(wp) :: e(3), q(4), step(3), slope(3)
      integer :: i
      seed = 3_int64
      do i = 1, 100
         q = random_unit_quaternion(seed)
         if (i < 20) q = quat_normalized([1.0_wp, 10.0_wp**(-i)*random_vector(seed)])
         e = rotation_vector_from_quat(q)
         if (norm2(e) > 2.5_wp) cycle
         step = 1e-3_wp*random_vector(seed)
         slope = (8*(at(1) - at(-1)) - (at(2) - at(-2)))/12
         call check_close(error, matmul(inverse_right_jacobian(e), step), slope, 1e-12_wp)
         call check_close(error, matmul(right_jacobian(e), matmul(inverse_right_jacobian(e), step)), step, 1e-15_wp)
      end do
   contains
      function at(k) result(v)
         integer, intent(in) :: k
         real(wp) :: v(3)
         v = rotation_vector_from_quat(quat_product(q, quat_from_rotation_vector(k*step)))
      end function at
   end subroutine test_logarithm

   subroutine test_rejections(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      class(fit_t), allocatable :: fit
      type(status_t) :: status
      allocate (scene, fit)
      call read(gyroscope, scene, error)
      call fit_scene(scene, fit, status)
      call check(error, status%code, NUTATE_BAD_ARGUMENT)
      call read(gyroscope//"&free key = 'body.inertia' /"//rates//' /', scene, error)
      call fit_scene(scene, fit, status)
      call check(error, index(status%message, 'fewer measurements') > 0, trim(status%message))
   end subroutine test_rejections

end submodule test_fit
