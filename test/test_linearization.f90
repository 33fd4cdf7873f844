!> Linearisation: matrices against differences of the motion, eigenvalues against closed formulas, Floquet multipliers.
submodule(suites_of_effects) test_linearization
   use nutate_attitude, only: quat_from_rotation_vector, rotation_vector_from_quat
   use nutate_hamiltonian, only: angular_velocity, make_state, system_t
   use nutate_kinds, only: wp, pi
   use nutate_linear_rates, only: linearize_rates
   use nutate_linearization, only: linearization_t, linearize_equilibrium, linearize_period
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_plan_t
   use nutate_scene, only: parse_scene, read_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   character, parameter :: lf = achar(10)
   real(wp), parameter :: eps = epsilon(1.0_wp)
   character(len=*), parameter :: at_rest = '&initial angular_velocity = 0, 0, 0 / '
   character(len=*), parameter :: steps = '&integrator order = 8, formulation = "reduced", time_step = '
   !> A satellite at rest in the orbit's axes, with a momentum wheel along the normal, damping and a spring.
   character(len=*), parameter :: satellite = "&body inertia = 90, 100, 40 / &rotating_frame rate = 0, -0.3, 0 / "// &
      "&gravity_gradient direction = 0, 0, 1, strength = 0.09 / &damping coefficient = 1, 2, 3 /"// &
      " &wheel axis = 0, -2, 0, inertia = 0.5, speed = 40 / "// &
      "&initial angular_velocity = 0, -0.3, 0 / "//steps//"0.05, end_time = 10 /"

contains

   module procedure collect_linearization
      testsuite = [ &
                  new_unittest("A_is_the_difference_of_the_right_side_for_all_effects", test_differences), &
                  new_unittest("a_period_at_rest_is_the_exponential_of_A_and_B", test_exponential), &
                  new_unittest("a_period_is_the_difference_of_two_runs", test_two_runs), &
                  new_unittest("a_free_body_about_each_axis", test_free_body), &
                  new_unittest("a_top_sleeps_above_its_threshold", test_sleeping_top), &
                  new_unittest("damping_and_a_pendulum", test_damping), &
                  new_unittest("a_wheel_with_friction_and_motor", test_wheel), &
                  new_unittest("an_orbit_in_inertial_axes_is_an_equilibrium", test_inertial_axes), &
                  new_unittest("a_controller_with_gains_closes_the_loop", test_closed_loop), &
                  new_unittest("gains_that_a_controller_cannot_have_are_refused", test_impossible_gains), &
                  new_unittest("Floquet_multipliers_of_Hyperion", test_hyperion), &
                  new_unittest("what_is_no_equilibrium_is_refused_with_its_residual", test_refusals)]
   end procedure collect_linearization

   !> Reads a scene.
   subroutine read(text, scene, error)
      character(len=*), intent(in) :: text
      type(scene_t), intent(inout) :: scene
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      character(len=:), allocatable :: message
      call parse_scene(text, 'small.nml', scene, status, message)
      call check(error, status%ok(), message)
   end subroutine read

   !> Linearises a scene at its start, or over a period.
   subroutine linearize(text, linear, error, period)
      character(len=*), intent(in) :: text
      type(linearization_t), intent(out) :: linear
      type(error_type), allocatable, intent(inout) :: error
      real(wp), intent(in), optional :: period
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      allocate (scene)
      call read(text, scene, error)
      if (allocated(error)) return
      if (present(period)) then
         call linearize_period(scene%system, scene%integrator, scene%initial, scene%plan, period, linear, status)
      else
         call linearize_equilibrium(scene%system, scene%initial, scene%plan%end_time, linear, status)
      end if
      call check(error, status%ok(), trim(status%message))
   end subroutine linearize

   !> A state beside another one.
   function beside(system, start, linear, change) result(state)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: start
      type(linearization_t), intent(in) :: linear
      !> Change of x.
      real(wp), intent(in) :: change(:)
      type(state_t) :: state
      state = make_state(system, quat_product(start%q, quat_from_rotation_vector(change(1:3))), &
                         linear%omega + change(4:6), start%t, linear%speeds + change(7:))
   end function beside

   !> The start of a scene as a linearisation describes it.
   function start_of(scene) result(linear)
      type(scene_t), intent(in) :: scene
      type(linearization_t) :: linear
      integer :: i
      linear%omega = angular_velocity(scene%system, scene%initial)
      linear%speeds = [(scene%system%effects%wheels(i)%speed_of(scene%initial%wheel_momentum(i), linear%omega), &
                        i=1, scene%system%effects%n_wheels)]
   end function start_of

   subroutine test_differences(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call read_scene('scenes/all_effects.nml', scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      call compare(scene, error)
      call read(satellite//" &torque space = 1, -2, 3 / &dipole moment = 3, 1, 2, field = 1, 0, 2 / "// &
                "&spring body_point = 0.1, 0.2, 0.5, anchor = 0.3, -0.4, 0.9, stiffness = 5, rest_length = 0.4 / "// &
                "&wheel axis = 1, 1, 2, inertia = 0.7, speed = -9, friction = 0.3, torque = 2 /", scene, error)
      if (.not. allocated(error)) call compare(scene, error)

   contains

      !> Fourth-order differences with steps h: rounding eps/h and h⁴ of the largest entry, which 1e3 bounds here.
      subroutine compare(scene, error)
         type(scene_t), intent(in) :: scene
         type(error_type), allocatable, intent(inout) :: error
         real(wp), parameter :: h = 1e-3_wp
         real(wp), allocatable :: a(:, :), rates(:), change(:), column(:), unused(:, :)
         integer, parameter :: places(4) = [-2, -1, 1, 2], weights(4) = [1, -8, 8, -1]
         integer :: i, k, n
         type(linearization_t) :: linear
         n = 6 + scene%system%effects%n_wheels
         allocate (a(n, n), unused(n, n), rates(n), change(n), column(n))
         linear = start_of(scene)
         call linearize_rates(scene%system, scene%initial, rates, a, status)
         call check(error, status%ok(), trim(status%message))
         do k = 1, n
            column = 0.0_wp
            do i = 1, 4
               change = 0.0_wp
               change(k) = places(i)*h
               call linearize_rates(scene%system, beside(scene%system, scene%initial, linear, change), rates, unused, &
                                    status)
               column = column + weights(i)*rates/(12*h)
            end do
            call check_close(error, a(4:, k), column(4:), 1e2_wp*(eps/h + h**4)*maxval(abs(a(4:, :))), 'column')
         end do
      end subroutine compare

   end subroutine test_differences

   !> exp of a matrix.
   pure function exponential(matrix) result(power)
      real(wp), intent(in) :: matrix(:, :)
      real(wp) :: power(size(matrix, 1), size(matrix, 1))
      real(wp) :: term(size(matrix, 1), size(matrix, 1)), small(size(matrix, 1), size(matrix, 1))
      integer :: i, halvings
      halvings = max(0, exponent(maxval(sum(abs(matrix), dim=2))) + 2)
      small = matrix/2.0_wp**halvings
      term = 0.0_wp
      do i = 1, size(matrix, 1)
         term(i, i) = 1.0_wp
      end do
      power = term
      do i = 1, 18
         term = matmul(term, small)/i
         power = power + term
      end do
      do i = 1, halvings
         power = matmul(power, power)
      end do
   end function exponential

   !> x(T) = exp(AT)x and ∫exp(As)B ds: the linear motion beside an equilibrium, integrated by the method.
   subroutine test_exponential(error)
      type(error_type), allocatable, intent(out) :: error
      type(linearization_t) :: rest, period
      real(wp), allocatable :: both(:, :)
      integer :: n, m
      call linearize(satellite, rest, error)
      call linearize(satellite, period, error, period=3.0_wp)
      if (allocated(error)) return
      n = size(rest%states)
      m = size(rest%inputs)
      call check(error, n, 7)
      call check(error, m, 4)
      allocate (both(n + m, n + m), source=0.0_wp)
      both(:n, :n) = 3*rest%a
      both(:n, n + 1:) = 3*rest%b
      both = exponential(both)
      call check(error, period%closes)
      ! The error of steps of 0.05 s by order 8.
      call check_close(error, reshape(period%a, [n*n]), reshape(both(:n, :n), [n*n]), &
                       1e-10_wp*maxval(abs(both(:n, :n))))
      call check_close(error, reshape(period%b, [n*m]), reshape(both(:n, n + 1:), [n*m]), &
                       1e-10_wp*maxval(abs(both(:n, n + 1:))))
      ! The wheel alone gives u/Jw and u/J2.
      call check_close(error, rest%b(7, 4), 1/0.5_wp + 1/99.5_wp, 8*eps)
   end subroutine test_exponential

   subroutine test_two_runs(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: text = "&body inertia = 5, 20, 17 / &damping coefficient = 0.3, 0.1, 0.2 / "// &
         "&dipole moment = 3, 1, 2, field = 1, 0, 2 / &wheel axis = 1, 1, 2, inertia = 0.7, speed = -9, "// &
         "friction = 0.3, torque = 2 / &initial angular_velocity = 0.5, 1, -0.7 / "//steps//"0.1, end_time = 10 /"
      real(wp), parameter :: h = 1e-3_wp, period = 1.5_wp
      integer, parameter :: places(4) = [-2, -1, 1, 2], weights(4) = [1, -8, 8, -1]
      type(linearization_t) :: linear
      class(scene_t), allocatable :: scene
      type(state_t) :: reference
      real(wp) :: x(7), change(7)
      integer :: i, k
      allocate (scene)
      call linearize(text, linear, error, period)
      call read(text, scene, error)
      if (allocated(error)) return
      call check(error,.not. linear%closes)
      call go(scene, scene%initial, reference)
      do k = 1, 7
         x = 0.0_wp
         do i = 1, 4
            change = 0.0_wp
            change(k) = places(i)*h
            x = x + weights(i)*end_of(scene, beside(scene%system, scene%initial, linear, change))/(12*h)
         end do
         call check_close(error, linear%a(:, k), x, 1e2_wp*(eps/h + h**4)*maxval(abs(linear%a)), 'A')
      end do
      do k = 1, 4
         x = 0.0_wp
         do i = 1, 4
            call read(text//input(k, places(i)*h), scene, error)
            if (allocated(error)) return
            if (k == 4) call set_motor(scene, 2 + places(i)*h)
            x = x + weights(i)*end_of(scene, scene%initial)/(12*h)
         end do
         call check_close(error, linear%b(:, k), x, 1e2_wp*(eps/h + h**4)*maxval(abs(linear%a)), 'B')
      end do

   contains

      !> A torque about an axis of the body.
      function input(axis, torque) result(group)
         integer, intent(in) :: axis
         real(wp), intent(in) :: torque
         character(len=64) :: group
         real(wp) :: torques(4)
         torques = 0.0_wp
         torques(axis) = torque
         write (group, '(" &torque body = ",2(f7.4,","),f7.4," /")') torques(1:3)
      end function input

      subroutine set_motor(scene, torque)
         type(scene_t), intent(inout) :: scene
         real(wp), intent(in) :: torque
         character(len=8) :: number
         type(status_t) :: status
         character(len=:), allocatable :: message
         write (number, '(f8.4)') torque
         call parse_scene(text, 'small.nml', scene, status, message, ['wheel.torque='//adjustl(number)])
         call check(error, status%ok(), message)
      end subroutine set_motor

      !> The state after the period.
      subroutine go(scene, start, state)
         type(scene_t), intent(in) :: scene
         type(state_t), intent(in) :: start
         type(state_t), intent(out) :: state
         type(status_t) :: status
         state = start
         call integrate(scene%system, scene%integrator, state, run_plan_t(time_step=scene%plan%time_step, &
                                                                          end_time=period), status)
         call check(error, status%ok(), trim(status%message))
      end subroutine go

      !> x of the end against that of the reference.
      function end_of(scene, start) result(x)
         type(scene_t), intent(in) :: scene
         type(state_t), intent(in) :: start
         real(wp) :: x(7)
         type(state_t) :: state
         call go(scene, start, state)
         x(1:3) = rotation_vector_from_quat(quat_product(quat_conjugate(reference%q), state%q))
         x(4:6) = angular_velocity(scene%system, state)
         x(7) = scene%system%effects%wheels(1)%speed_of(state%wheel_momentum(1), x(4:6))
      end function end_of

   end subroutine test_two_runs

   !> Checks that a number is an eigenvalue.
   subroutine check_eigenvalue(error, linear, value, tolerance, label)
      type(error_type), allocatable, intent(inout) :: error
      type(linearization_t), intent(in) :: linear
      complex(wp), intent(in) :: value
      real(wp), intent(in) :: tolerance
      character(len=*), intent(in) :: label
      if (.not. allocated(error)) call check_below(error, minval(abs(linear%eigenvalues - value)), tolerance, label)
   end subroutine check_eigenvalue

   !> λ² = -Ω²(J - Jᵢ)(J - Jⱼ)/(JᵢJⱼ), and ±iΩ of the direction in space.
   subroutine test_free_body(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: rates(3) = ['2, 0, 0', '0, 2, 0', '0, 0, 2']
      real(wp), parameter :: j(3) = [5.0_wp, 20.0_wp, 17.0_wp]
      type(linearization_t) :: linear
      complex(wp) :: root
      real(wp) :: a, b
      integer :: k
      do k = 1, 3
         call linearize('&body inertia = 5, 20, 17 / &initial angular_velocity = '//rates(k)//' /'// &
                        steps//'0.1, end_time = 10 /', linear, error)
         a = j(modulo(k, 3) + 1)
         b = j(modulo(k + 1, 3) + 1)
         root = sqrt(cmplx(-4*(j(k) - a)*(j(k) - b)/(a*b), 0.0_wp, wp))
         call check_eigenvalue(error, linear, root, 16*eps, 'rate')
         call check_eigenvalue(error, linear, -root, 16*eps, 'rate')
         call check_eigenvalue(error, linear, (0.0_wp, 2.0_wp), 16*eps, 'turn')
      end do
   end subroutine test_free_body

   !> s = (iJ₃Ω ± √(4J₁k - J₃²Ω²))/2J₁ in space axes, s - iΩ in those of the body.
   subroutine test_sleeping_top(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: spins(2) = [3.4_wp, 3.5_wp]
      type(linearization_t) :: linear
      character(len=8) :: spin
      complex(wp) :: root, s
      integer :: k, sign
      do k = 1, 2
         write (spin, '(f8.2)') spins(k)
         call linearize('&body inertia = 2, 2, 1 / &dipole moment = 0, 0, 1.5, field = 0, 0, -1 / '// &
                        '&initial angular_velocity = 0, 0, '//spin//' / '//steps//'0.1, end_time = 10 /', linear, error)
         root = sqrt(cmplx(12 - spins(k)**2, 0.0_wp, wp))
         do sign = -1, 1, 2
            s = (cmplx(0.0_wp, spins(k), wp) + sign*root)/4
            ! Near the threshold the roots lie 0.3 apart.
            call check_eigenvalue(error, linear, s - cmplx(0.0_wp, spins(k), wp), 1e-13_wp, spin)
         end do
         if (allocated(error)) return
         call check(error, maxval(real(linear%eigenvalues, wp)) > 1e-3_wp .eqv. spins(k) < sqrt(12.0_wp), spin)
      end do
   end subroutine test_sleeping_top

   !> Jλ² + cλ + k = 0 about each axis.
   subroutine test_damping(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: j(3) = [2.0_wp, 1.5_wp, 1.0_wp], c(3) = [0.2_wp, 0.1_wp, 0.05_wp]
      type(linearization_t) :: linear
      integer :: k
      call linearize('&body inertia = 2, 1.5, 1 / &dipole moment = 0, 0, 0.8, field = 0, 0, 1 / '// &
                     '&damping coefficient = 0.2, 0.1, 0.05 / '//at_rest//steps//'0.1, end_time = 10 /', linear, error)
      do k = 1, 2
         call check_eigenvalue(error, linear, cmplx(-c(k)/2, sqrt(0.8_wp*j(k) - c(k)**2/4), wp)/j(k), 16*eps, 'swing')
      end do
      call check_eigenvalue(error, linear, cmplx(-c(3)/j(3), 0.0_wp, wp), 16*eps, 'spin')
      call check_eigenvalue(error, linear, (0.0_wp, 0.0_wp), 16*eps, 'turn')
   end subroutine test_damping

   !> Relative to a body of J₃ - Jw that turns freely: ω̇ = (u - cω)(1/Jw + 1/(J₃ - Jw)); nutation h/√(J₁J₂).
   subroutine test_wheel(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: wheel = '&body inertia = 5, 20, 17 / &wheel axis = 0, 0, 3, inertia = 0.7, ', &
                                     rest = ' / '//at_rest//steps//'0.1, end_time = 10 /'
      real(wp), parameter :: both = 1/0.7_wp + 1/16.3_wp
      type(linearization_t) :: linear
      call linearize(wheel//'friction = 0.3'//rest, linear, error)
      call check_eigenvalue(error, linear, cmplx(-0.3_wp*both, 0.0_wp, wp), 16*eps, 'friction')
      if (allocated(error)) return
      call check_close(error, linear%b(:, 4), [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, -1/16.3_wp, both], 16*eps, &
                       'motor')
      call check_close(error, linear%b(:, 3), [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1/16.3_wp, -1/16.3_wp], 16*eps, &
                       'torque')
      call linearize(wheel//'speed = 50'//rest, linear, error)
      call check_eigenvalue(error, linear, cmplx(0.0_wp, 35/sqrt(100.0_wp), wp), 1e2_wp*eps, 'nutation')
      ! A motor that its friction balances is at equilibrium; one with a table is no input.
      call linearize(wheel//'speed = 50, friction = 0.1, torque = 5'//rest, linear, error)
      if (allocated(error)) return
      call check(error, size(linear%inputs), 4)
      call linearize(wheel//'torque = 0, frequency = 2'//rest, linear, error)
      if (allocated(error)) return
      call check(error, size(linear%inputs), 3)
      call check(error, linear%states(7), 'wheel1_speed')
   end subroutine test_wheel

   subroutine test_inertial_axes(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: body = "&body inertia = 90, 100, 40 / &gravity_gradient / &initial "// &
         "attitude_from = 'lvlh', rate_from = 'lvlh', angular_velocity = 0, 0, 0 / "//steps//"50, end_time = 6e3 / "// &
         "&orbit semi_major_axis = 6878137, inclination = 0.5, frame = "
      type(linearization_t) :: inertial, lvlh
      real(wp) :: pace
      call linearize(body//"'inertial' /", inertial, error)
      call linearize(body//"'lvlh' /", lvlh, error)
      if (allocated(error)) return
      pace = maxval(abs(lvlh%eigenvalues))
      call check_close(error, reshape(inertial%a(:3, :), [18]), reshape(lvlh%a(:3, :), [18]), 1e-12_wp)
      call check_close(error, reshape(inertial%a(4:, :3), [9]), reshape(lvlh%a(4:, :3), [9]), 1e-12_wp*pace**2)
      call check_close(error, reshape(inertial%a(4:, 4:), [9]), reshape(lvlh%a(4:, 4:), [9]), 1e-12_wp*pace)
   end subroutine test_inertial_axes

   !> A feedback of torques by states.
   pure function some_feedback() result(k)
      real(wp) :: k(3, 6)
      integer :: i, j
      do j = 1, 6
         do i = 1, 3
            k(i, j) = 5*sin(2.0_wp*i + 3.0_wp*j)
         end do
      end do
   end function some_feedback

   !> A - BK, with a target in rotating axes and in the LVLH frame.
   subroutine test_closed_loop(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: orbiting = "&body inertia = 90, 100, 40 / &gravity_gradient / &initial "// &
         "attitude_from = 'lvlh', rate_from = 'lvlh', roll_pitch_yaw = 3*0, angular_velocity = 3*0 / "//steps// &
         "0.05, end_time = 10 / &orbit semi_major_axis = 1e7, mu = 9e19, inclination = 0.5, frame = "
      type(linearization_t) :: open, closed
      type(status_t) :: status
      character(len=:), allocatable :: text, target
      real(wp) :: k(3, 6), attitude_gain(3, 3), rate_gain(3, 3)
      integer :: way
      k = some_feedback()
      do way = 1, 3
         target = "'lvlh'"
         if (way == 1) text = satellite
         if (way == 1) target = "'space'"
         if (way == 2) text = orbiting//"'lvlh' /"
         if (way == 3) text = orbiting//"'inertial' /"
         call linearize(text, open, error)
         if (allocated(error)) return
         call open%controller_gains(k, attitude_gain, rate_gain, status)
         call check(error, status%ok(), trim(status%message))
         call linearize(text//" &controller law = 'quaternion', target_from = "//target//", attitude_gain_matrix = "// &
                        numbers(attitude_gain)//", rate_gain_matrix = "//numbers(rate_gain)//" /", closed, error)
         if (allocated(error)) return
         open%a(:, :6) = open%a(:, :6) - matmul(open%b(:, :3), k)
         call check_close(error, reshape(closed%a, [size(closed%a)]), reshape(open%a, [size(open%a)]), 1e-12_wp, text)
         ! The closed loop is also compared with feedback of relative rates.
         call linearize(text, open, error)
         if (allocated(error)) return
         call open%use_relative_rates(status)
         call check_below(error, maxval(abs(open%a(:3, :3))), 1e-15_wp, 'theta is the integral of relative rates')
         call open%controller_gains(k, attitude_gain, rate_gain, status)
         call check(error, status%ok(), trim(status%message))
         call linearize(text//" &controller law = 'quaternion', target_from = "//target//", attitude_gain_matrix = "// &
                        numbers(attitude_gain)//", rate_gain_matrix = "//numbers(rate_gain)//" /", closed, error)
         if (allocated(error)) return
         call closed%use_relative_rates(status)
         open%a(:, :6) = open%a(:, :6) - matmul(open%b(:, :3), k)
         call check_close(error, reshape(closed%a, [size(closed%a)]), reshape(open%a, [size(open%a)]), 1e-12_wp, text)
      end do

   contains

      !> Row by row.
      function numbers(matrix) result(text)
         real(wp), intent(in) :: matrix(3, 3)
         character(len=240) :: text
         write (text, '(8(es24.16e3,","),es24.16e3)') transpose(matrix)
      end function numbers

   end subroutine test_closed_loop

   subroutine test_impossible_gains(error)
      type(error_type), allocatable, intent(out) :: error
      type(linearization_t) :: linear
      type(status_t) :: status
      real(wp) :: k(4, 7), attitude_gain(3, 3), rate_gain(3, 3)
      call linearize(satellite, linear, error)
      if (allocated(error)) return
      k = 0.0_wp
      k(:3, :6) = some_feedback()
      call linear%controller_gains(k, attitude_gain, rate_gain, status)
      call check(error, status%ok(), trim(status%message))
      call linear%controller_gains(k(:, :6), attitude_gain, rate_gain, status)
      call check(error, index(status%message, 'expected 3 rows and 6 columns') > 0, 'shape')
      k(1, 7) = 1.0_wp
      call linear%controller_gains(k, attitude_gain, rate_gain, status)
      call check(error, index(status%message, 'uses motors or speeds') > 0, 'speed')
      k(:, 7) = 0.0_wp
      k(4, 2) = 1.0_wp
      call linear%controller_gains(k, attitude_gain, rate_gain, status)
      call check(error, index(status%message, 'uses motors or speeds') > 0, 'motor')
      linear%period = 3.0_wp
      call linear%controller_gains(k(:3, :6), attitude_gain, rate_gain, status)
      call check(error, index(status%message, 'expected an equilibrium') > 0, 'period')
      call linear%use_relative_rates(status)
      call check(error, index(status%message, 'expected an equilibrium') > 0, 'relative rates over a period')
   end subroutine test_impossible_gains

   !> Checks the eigenvalues of the periodic motion with one rotation per revolution against 17 digits from another
   !> program. The eigenvalues come in pairs λ, 1/λ.
   subroutine test_hyperion(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: moon = '&body inertia = 0.5, 0.764033333333333, 1 / &gravity_gradient / '// &
         '&orbit semi_major_axis = 1, mu = 1, eccentricity = 0.1 / &initial angular_velocity = 0, 0, '
      type(linearization_t) :: linear
      complex(wp) :: product
      integer :: i
      call linearize(moon//'0.5515368654328064883257 / '//steps//'0.04, end_time = 7 /', linear, error, 2*pi)
      if (allocated(error)) return
      call check(error, linear%closes)
      ! The error of steps of 1/157 of a revolution by order 8.
      call check_eigenvalue(error, linear, cmplx(-1.88104197787748_wp, 0.0_wp, wp), 1e-9_wp, 'p = 1')
      call check_close(error, linear%a(3, 3) + linear%a(6, 6), -0.111459168718541921_wp, 1e-9_wp)
      product = 1
      do i = 1, 6
         call check_eigenvalue(error, linear, 1/linear%eigenvalues(i), 1e-9_wp, 'pair')
         product = product*linear%eigenvalues(i)
      end do
      call check_below(error, abs(product - 1), 1e-9_wp)
      call linearize(moon//'2.322129821632623343152 / '//steps//'0.04, end_time = 7 /', linear, error, 2*pi)
      if (allocated(error)) return
      call check(error, linear%closes)
      call check_close(error, abs(linear%eigenvalues), spread(1.0_wp, 1, 6), 1e-9_wp, 'p = 2 is stable')
   end subroutine test_hyperion

   subroutine test_refusals(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: box = '&body inertia = 5, 20, 17 / '//steps//'0.1, end_time = 10 / '
      ! J2 Ω2' = (J3 - J1)Ω3Ω1.
      call refuse(box//'&initial angular_velocity = 0.1, 0, 2 /', 'angular acceleration 1.20E-01 rad/s^2 (expected')
      call refuse(box//at_rest//'&torque body = 5, 0, 0, frequency = 0.05, phase = 1.5707963267948966 /', &
                  'angular acceleration', ' at t = ')
      call refuse(box//'&initial angular_velocity = 0, 0, 2 / &gravity_gradient direction = 1, 0, 0, strength = 1 /', &
                  'angular acceleration', ' at t = ')
      ! Without torque at all times, with a stiffness that changes as the body turns.
      call refuse('&body inertia = 5, 5, 9 / '//steps//'0.1, end_time = 10 / &initial angular_velocity = 0, 0, 2 / '// &
                  '&spring body_point = 0, 0, 1, anchor = 2, 0, 0, stiffness = 1, rest_length = 0.5 / '// &
                  '&spring body_point = 0, 0, 1, anchor = -2, 0, 0, stiffness = 1, rest_length = 0.5 /', 'derivatives')
      call refuse(box//at_rest//"&controller law = 'quaternion', attitude_gain = 1, rate_gain = 1, sample = 0.5 /", &
                  'samples')

   contains

      !> Checks that a scene is rejected with these words.
      subroutine refuse(text, words, more)
         character(len=*), intent(in) :: text, words
         character(len=*), intent(in), optional :: more
         type(linearization_t) :: linear
         class(scene_t), allocatable :: scene
         type(status_t) :: status
      allocate (scene)
         call read(text, scene, error)
         if (allocated(error)) return
         call linearize_equilibrium(scene%system, scene%initial, scene%plan%end_time, linear, status)
         call check(error, .not. status%ok() .and. index(status%message, words) > 0, words//': '//trim(status%message))
         if (present(more)) call check(error, index(status%message, more) > 0, more//': '//trim(status%message))
      end subroutine refuse

   end subroutine test_refusals

end submodule test_linearization
