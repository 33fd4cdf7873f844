!> Space axes that turn, on the Earth: Foucault's pendulum, a free gyroscope, a gyrocompass; and that roots of steps in
!> such axes which count as certified are the true ones.
submodule(suites_of_runs) test_earth_frames
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_body, only: diagonal, make_body, make_shape_body
   use nutate_damping, only: damping_t
   use nutate_dipole, only: dipole_t
   use nutate_gravity, only: gravity_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_invariants, only: follows_rotating_axes
   use nutate_inner_sphere, only: inner_sphere_t
   use nutate_kinds, only: wp, eps, pi
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_rotor, only: rotor_t
   use nutate_quaternion, only: quat_exp, quat_product, rotate_to_space
   use nutate_reduced_equations, only: reduced_equations_t
   use nutate_rotating_frame, only: frame_at_latitude, rotating_frame_t
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_wheel_mounting, only: add_inner_sphere
   use test_problems, only: conserved_energy, frame_rate_of, make_state, new_problem, problem_t, system_t
   use test_support, only: check, check_close, error_type, new_unittest, random_unit, random_unit_quaternion, &
                           random_vector
   implicit none

   real(wp), parameter :: degree = pi/180, x(3) = [1.0_wp, 0.0_wp, 0.0_wp]
   character(len=*), parameter :: solvers(2) = ['full   ', 'reduced']

   !> Foucault's pendulum: times, s, attitudes and places of the bob, m; 20 digits, by extrapolation in quadruple
   !> precision.
   real(wp), parameter :: times(4) = [10.0_wp, 60.0_wp, 600.0_wp, 3600.0_wp]
   real(wp), parameter :: pendulums(4, 4) = reshape([ &
      0.99979420995009491149_wp, -0.020286386127995672139_wp, &
      8.5865160309269645006e-06_wp, -1.4642511543016132301e-05_wp, &
      0.99988844786735556344_wp, -0.014935986452943957626_wp, &
      4.5053928347946638983e-05_wp, -7.8103979351794229795e-05_wp, &
      0.99967218987596939662_wp, -0.025578655646198008764_wp, &
      0.00082204274720171242558_wp, -0.00075459236597356507118_wp, &
      0.99995991134410364639_wp, 0.0075856064057499933275_wp, &
      -0.001478466904658144556_wp, -0.0045219924547980931825_wp], [4, 4])
   real(wp), parameter :: bobs(3, 4) = reshape([ &
      -0.0011901602156909008946_wp, -2.717816309624414281_wp, -66.944853970194439366_wp, &
      -0.0061928719701324270999_wp, -2.0011984502500597838_wp, -66.970106513362016009_wp, &
      -0.1127040140276037101_wp, -3.4263331531626977203_wp, -66.912237587221369436_wp, &
      0.20270309843842856226_wp, 1.0155346368348643593_wp, -66.991996543283229281_wp], [3, 4])

contains

   module procedure collect_earth_frames
      testsuite = [ &
                  new_unittest("Foucault's pendulum by the series", pendulum_by_series), &
                  new_unittest("Foucault's pendulum by order 8", pendulum_by_order_8), &
                  new_unittest("the axis of a free gyroscope goes round with the stars", free_gyroscope), &
                  new_unittest("a gyrocompass rests in the meridian", gyrocompass_rests), &
                  new_unittest("a gyrocompass swings about north with its period", gyrocompass_swings), &
                  new_unittest("roots that are certified are the true ones", certified_roots_are_true), &
                  new_unittest("mild steps are certified", mild_steps_is_certified)]
   end procedure collect_earth_frames

   !> 28 kg on 67 m at 48.8462° north, rotated 3° about east, at rest on the Earth.
   function pendulum() result(problem)
      type(problem_t), pointer :: problem
      type(status_t) :: status
      real(wp) :: q(4)
      problem => new_problem()
      call make_shape_body('sphere', [0.1_wp], problem%system%body, status, mass=28.0_wp, &
                           center_of_mass=[0.0_wp, 0.0_wp, -67.0_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      call problem%system%effects%add(frame_at_latitude(48.8462_wp*degree))
      q = quat_exp(1.5_wp*degree*x)
      problem%start = make_state(problem%system, q, frame_rate_of(problem%system%effects, q))
   end function pendulum

   !> The bob's direction, and the attitude: the spin about the suspension is known a million times worse than the
   !> direction, as the moments are.
   subroutine check_pendulum(error, state, k)
      type(error_type), allocatable, intent(inout) :: error
      type(state_t), intent(in) :: state
      !> Index of the time.
      integer, intent(in) :: k
      call check_close(error, rotate_to_space(state%q, [0.0_wp, 0.0_wp, -67.0_wp])/67, bobs(:, k)/67, 1e-11_wp, "bob")
      call check_close(error, state%q, pendulums(:, k), 1e-7_wp, "attitude")
   end subroutine check_pendulum

   subroutine pendulum_by_series(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      integer :: k
      problem => pendulum()
      do k = 1, size(times)
         state = problem%start
         call integrate(problem%system, integrator_settings_t(method='taylor', conserve=.true.), state, &
                        run_plan_t(goal=run_goal_t(local_tolerance=1e-15_wp), end_time=times(k)), status)
         call check(error, status%ok(), trim(status%message))
         call check_pendulum(error, state, k)
      end do
   end subroutine pendulum_by_series

   subroutine pendulum_by_order_8(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      integer :: form, k
      problem => pendulum()
      do form = 1, 2
         state = problem%start
         ! The last time by the cheaper form.
         do k = 1, size(times) - 2 + form
            call integrate(problem%system, integrator_settings_t(order=8, formulation=solvers(form)), &
                           state, run_plan_t(time_step=0.25_wp, end_time=times(k)), status)
            call check(error, status%ok(), trim(status%message))
            call check_pendulum(error, state, k)
            call check_close(error, conserved_energy(problem%system, state), &
                             conserved_energy(problem%system, problem%start), 64*eps*18424.4_wp, "H - omega.l")
         end do
      end do
   end subroutine pendulum_by_order_8

   !> Checks a free gyroscope at 50° north: seen from the Earth it rotates back about the Earth's axis, once in a
   !> sidereal day. The axis of the gyroscope begins in the east, and in the north.
   subroutine free_gyroscope(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: expected(3, 6) = reshape([ &
         0.9657400690704306_wp, -0.1987971954376032_wp, 0.1668106533707705_wp, &
         -0.004300499949203825_wp, -0.766037359358425_wp, 0.6427816657056719_wp, &
         0.9998520483378082_wp, -0.01317688708740705_wp, 0.01105672109510792_wp, &
         0.1987971954376032_wp, 0.979895447248758_wp, 0.01686972279855134_wp, &
         0.766037359358425_wp, 0.4106522742023149_wp, 0.4945214593520063_wp, &
         0.01317688708740705_wp, 0.9999131784006429_wp, 7.28519719987699e-5_wp], [3, 6])
      real(wp), parameter :: hours(3) = [1.0_wp, 6.0_wp, 24.0_wp]
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(status_t) :: status
      integer :: k
      problem => new_problem()
      call make_body(diagonal([2.0_wp, 1.0_wp, 1.0_wp]), problem%system%body, status)
      call problem%system%effects%add(frame_at_latitude(50*degree))
      do k = 1, size(expected, 2)
         state = make_state(problem%system, quat_exp([0.0_wp, 0.0_wp, merge(0.0_wp, 45*degree, k <= 3)]), 3*x)
         call integrate(problem%system, integrator_settings_t(method='taylor', conserve=.true.), state, &
                        run_plan_t(goal=run_goal_t(local_tolerance=1e-12_wp), end_time=3600*hours(1 + mod(k - 1, 3))), &
                        status, summary=summary)
         call check(error, status%ok(), trim(status%message))
         ! Roundings of the steps, which walk.
         call check_close(error, rotate_to_space(state%q, x), expected(:, k), 4*eps*sqrt(real(summary%steps, wp)), &
                          "series")
      end do
      state = make_state(problem%system, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 3*x)
      call integrate(problem%system, integrator_settings_t(order=8, formulation='reduced'), state, &
                     run_plan_t(time_step=0.125_wp, end_time=3600.0_wp), status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, rotate_to_space(state%q, x), expected(:, 1), 1e-12_wp, "order 8")
   end subroutine free_gyroscope

   !> Returns a rotor of 15 N m s along axis 2, hung above its centre of mass, at 50° north. The axis of the rotor is
   !> rotated from north and lifted by the angle (rad) at which it rests.
   function gyrocompass(azimuth) result(problem)
      real(wp), intent(in) :: azimuth
      type(problem_t), pointer :: problem
      real(wp), parameter :: tilt = 0.0017058357338493677566_wp
      type(status_t) :: status
      real(wp) :: q(4)
      problem => new_problem()
      call make_body(diagonal([0.05_wp, 0.06_wp, 0.07_wp]), problem%system%body, status, mass=5.0_wp, &
                     center_of_mass=[0.0_wp, 0.0_wp, -0.01_wp])
      call problem%system%effects%add(gravity_t(problem%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      call problem%system%effects%add(rotor_t(name='rotor', momentum=[0.0_wp, 15.0_wp, 0.0_wp]))
      call problem%system%effects%add(frame_at_latitude(50*degree))
      q = quat_product(quat_exp([0.0_wp, 0.0_wp, 0.5_wp*azimuth]), quat_exp(0.5_wp*tilt*x))
      problem%start = make_state(problem%system, q, frame_rate_of(problem%system%effects, q))
   end function gyrocompass

   subroutine gyrocompass_rests(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      problem => gyrocompass(0.0_wp)
      state = problem%start
      call integrate(problem%system, integrator_settings_t(formulation='reduced'), state, &
                     run_plan_t(time_step=0.002_wp, end_time=60.0_wp), status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, state%q, problem%start%q, 1e-13_wp, "q")
   end subroutine gyrocompass_rests

   !> Half a period of its slow oscillation, 5071.856 s, after 1e-3 rad to the west it is 1e-3 rad to the east, and a
   !> quarter of it north.
   subroutine gyrocompass_swings(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: period = 5071.856349609926_wp, azimuth = 1e-3_wp
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: axis(3)
      integer :: k
      problem => gyrocompass(azimuth)
      do k = 1, 2
         state = problem%start
         call integrate(problem%system, integrator_settings_t(method='taylor', conserve=.true.), state, &
                        run_plan_t(goal=run_goal_t(local_tolerance=1e-11_wp), end_time=0.25_wp*k*period), status)
         call check(error, status%ok(), trim(status%message))
         axis = rotate_to_space(state%q, [0.0_wp, 1.0_wp, 0.0_wp])
         call check_close(error, atan2(-axis(1), axis(2)), merge(0.0_wp, -azimuth, k == 1), 2e-5_wp*azimuth, "azimuth")
      end do
   end subroutine gyrocompass_swings

   !> A body and effects drawn at random in axes that turn, effects up to those that dominate a step of 1 s.
   function drawn(seed) result(problem)
      integer(int64), intent(inout) :: seed
      type(problem_t), pointer :: problem
      real(wp) :: moments(3), strength
      type(status_t) :: status
      problem => new_problem()
      moments = [1.0_wp, 0.5_wp + random_unit(seed), 1.0_wp]
      moments(3) = abs(moments(1) - moments(2)) + (0.02_wp + 0.96_wp*random_unit(seed))*2*min(moments(1), moments(2))
      call make_body(diagonal(moments), problem%system%body, status)
      strength = 10.0_wp**(3*random_unit(seed) - 2)
      associate (effects => problem%system%effects, body => problem%system%body)
         if (random_unit(seed) < 0.5_wp) call effects%add(dipole_t(strength*random_vector(seed), random_vector(seed)))
         if (random_unit(seed) < 0.5_wp) call effects%add(gravity_gradient_t(body, random_vector(seed), strength))
         if (random_unit(seed) < 0.3_wp) call effects%add(damping_t(strength*[random_unit(seed), random_unit(seed), &
                                                                             random_unit(seed)]))
         if (random_unit(seed) < 0.3_wp) call effects%add(rotor_t(name='rotor', momentum=strength*random_vector(seed)))
         call effects%add(rotating_frame_t(name='rotating_frame', rate=2*random_unit(seed)*random_vector(seed)))
      end associate
      if (random_unit(seed) < 0.3_wp) call add_inner_sphere(problem%system, inner_sphere_t( &
         0.3_wp*strength, 0.3_wp*strength*random_unit(seed), random_vector(seed)), status)
      problem%start = make_state(problem%system, random_unit_quaternion(seed), 2*random_unit(seed)*random_vector(seed))
   end function drawn

   !> The root of a step that counts as certified is that of a continuation in short increments of its length.
   subroutine certified_roots_are_true(error)
      type(error_type), allocatable, intent(out) :: error
      integer, parameter :: problems = 600, parts = 200
      class(stepper_t), allocatable :: stepper
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      integer(int64) :: seed
      !> In axes that stand still, where the motion does not know of their rotating; they turn back by a quaternion.
      type(system_t) :: system
      real(wp) :: r(3), c(4), turn(4), expected(4)
      integer :: n, certified
      logical :: followed
      seed = 271828_int64
      certified = 0
      do n = 1, problems
         problem => drawn(seed)
         call make_stepper(problem%system, integrator_settings_t(formulation=solvers(1 + mod(n, 2))), &
                           stepper, status)
         state = problem%start
         call stepper%step(problem%system, state, 1.0_wp, status)
         if (.not. status%ok() .or. stepper%uncertified > 0) cycle
         system = problem%system
         turn = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
         if (follows_rotating_axes(system%effects)) then
            turn = quat_exp(-0.5_wp*system%effects%frame_rate)
            system%effects%frame_turns = .false.
            system%effects%frame_rate = 0.0_wp
         end if
         call follow()
         ! A root that the continuation loses proves nothing.
         if (.not. followed) cycle
         certified = certified + 1
         c = [1 - dot_product(r, r), 2*r]/(1 + dot_product(r, r))
         expected = quat_product(turn, quat_product(problem%start%q, c))
         call check_close(error, sign(1.0_wp, dot_product(expected, state%q))*expected, state%q, 1e-9_wp, "root")
      end do
      call check(error, certified > 100, "hardly any step was certified")

   contains

      !> The root r of the whole step.
      subroutine follow()
         type(reduced_equations_t) :: equations
         real(wp) :: f(3), rows(3, 3), determinant, before(3), last(3)
         integer :: k, i
         call equations%prepare(system%effects)
         before = 0.0_wp
         r = 0.0_wp
         followed = .true.
         do k = 1, parts
            call equations%set_step(system, real(k, wp)/parts)
            call equations%start(system, problem%start)
            last = r
            r = 2*r - before
            before = last
            do i = 1, 20
               call equations%residual(system, r, f)
               call equations%linearize_forces(system, r)
               call equations%invert(r, rows, determinant)
               f = matmul(f, rows)
               r = r - f
               if (maxval(abs(f)) <= 1e-13_wp) exit
            end do
            if (i > 20) followed = .false.
            if (k > 1) followed = followed .and. maxval(abs(r - before)) < 0.02_wp
         end do
         r = equations%turn%to_relative(r)
      end subroutine follow

   end subroutine certified_roots_are_true

   !> Short steps are certified directly, beside effects as without; in axes that turn by a radian in a step none is.
   subroutine mild_steps_is_certified(error)
      type(error_type), allocatable, intent(out) :: error
      class(stepper_t), allocatable :: stepper
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      integer(int64) :: seed
      integer :: n, form
      seed = 161803_int64
      do n = 1, 50
         problem => drawn(seed)
         do form = 1, 2
            call make_stepper(problem%system, integrator_settings_t(order=4, formulation=solvers(form)), stepper, &
                              status)
            state = problem%start
            call stepper%step(problem%system, state, 0.01_wp, status)
            call check(error, status%ok(), trim(status%message))
            call check(error, stepper%uncertified, 0, "uncertified")
         end do
      end do
      call problem%system%effects%add(rotating_frame_t(name='rotating_frame', rate=200*x))
      state = problem%start
      call make_stepper(problem%system, integrator_settings_t(), stepper, status)
      call stepper%step(problem%system, state, 0.01_wp, status)
      call check(error, status%ok(), trim(status%message))
      call check(error, stepper%uncertified, 1, "a fast frame")
   end subroutine mild_steps_is_certified

end submodule test_earth_frames
