!> Periodic states of moons: Hyperion and Mercury on their ellipses, of 20 digits, by extrapolation in quadruple
!> precision, and how motions next to them grow, in the plane and out of it.
submodule(suites_of_effects) test_moon_states
   use nutate_kinds, only: wp, pi
   use nutate_quaternion, only: quat_conjugate, quat_exp, quat_product
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_time_dependent, only: make_moon
   use test_problems, only: angular_velocity, make_state, new_problem, problem_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> Eccentricity, 3(B-A)/C, turns in a revolution, θ in units of π and θ̇ at the pericentre, and the trace of the
   !> planar monodromy matrix, over one revolution or, where turns are halves, over two.
   real(wp), parameter :: states(6, 13) = reshape([ &
      0.1_wp, 0.7921_wp, 1.0_wp, 0.0_wp, 0.5515368654328064883257_wp, -0.11145916871854192068_wp, &
      0.1_wp, 0.7921_wp, 1.0_wp, 0.5_wp, 1.099105177037073524284_wp, 263.76742282484746209_wp, &
      0.1_wp, 0.7921_wp, 0.5_wp, 0.5_wp, 0.871262024564525901236_wp, -1.9864388881712447261_wp, &
      0.1_wp, 0.7921_wp, 2.0_wp, 0.0_wp, 2.322129821632623343152_wp, -0.76302950326618053982_wp, &
      0.1_wp, 0.7921_wp, 2.0_wp, 0.5_wp, 1.711370591161811570522_wp, 5.3924918515946041189_wp, &
      0.1_wp, 0.7921_wp, 1.5_wp, 0.5_wp, 1.294219468594211513339_wp, 718.71483396331622827_wp, &
      0.1_wp, 0.7921_wp, 2.5_wp, 0.0_wp, 2.721608009905376293622_wp, 0.08829380598290711358_wp, &
      0.1_wp, 0.7921_wp, 2.5_wp, 0.5_wp, 2.276456591892984743578_wp, 4.6242192570680632667_wp, &
      0.1_wp, 0.7921_wp, 3.0_wp, 0.0_wp, 3.160100957045201063451_wp, 1.896523714194746267_wp, &
      0.20563_wp, 0.0003_wp, 1.5_wp, 0.0_wp, 1.500063783670356055442_wp, 1.9690770653337990295_wp, &
      0.20563_wp, 0.0003_wp, 1.5_wp, 0.5_wp, 1.499936257997116621418_wp, 2.0310666432795461112_wp, &
      0.20563_wp, 0.0003_wp, 1.0_wp, 0.0_wp, 0.9998523248243055453121_wp, 1.9894011988860641148_wp, &
      0.20563_wp, 0.0003_wp, 2.0_wp, 0.0_wp, 2.000134208910761560187_wp, 1.9961386147699281262_wp], [6, 13])

   !> A state of Hyperion, its smallest moment of inertia, multipliers of small tilts that grow (0: on the unit circle),
   !> and how well these are known.
   type :: tilt_t
      integer :: state
      real(wp) :: smallest, multipliers(2), digits
   end type tilt_t

   type(tilt_t), parameter :: tilts(6) = [ &
      tilt_t(1, 0.6_wp, [-1.9485904_wp, -1.2179206_wp], 1e-7_wp), &
      tilt_t(1, 0.5_wp, [-1.88104198_wp, 0.0_wp], 1e-7_wp), &
      tilt_t(4, 0.6_wp, [0.0_wp, 0.0_wp], 1e-7_wp), &
      tilt_t(4, 0.5_wp, [0.0_wp, 0.0_wp], 1e-7_wp), &
      tilt_t(3, 0.6_wp, [38.73_wp, 0.0_wp], 5e-3_wp), &
      tilt_t(3, 0.5_wp, [27.157_wp, 0.0_wp], 5e-4_wp)]

contains

   module procedure collect_moon_states
      testsuite = [ &
                  new_unittest("periodic states come back", states_come_back), &
                  new_unittest("their planar neighbours grow by the trace of the monodromy matrix", planar_traces), &
                  new_unittest("tilts of Hyperion grow by the multipliers of Floquet", tilt_multipliers)]
   end procedure collect_moon_states

   !> The moon of a state, its smallest moment of inertia given, at its start.
   subroutine make_problem(k, smallest, problem)
      integer, intent(in) :: k
      real(wp), intent(in) :: smallest
      type(problem_t), intent(inout) :: problem
      problem = new_problem()
      call make_moon([smallest, smallest + states(2, k)/3, 1.0_wp], states(1, k), [states(4, k)*pi, states(5, k)], &
                     problem)
   end subroutine make_problem

   !> Revolutions after which a state is back.
   pure integer function revolutions(k)
      integer, intent(in) :: k
      revolutions = merge(1, 2, abs(states(3, k) - nint(states(3, k))) < 0.25_wp)
   end function revolutions

   subroutine states_come_back(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      integer :: k
      problem => new_problem()
      do k = 1, size(states, 2)
         call make_problem(k, merge(0.6_wp, 0.9998_wp, states(1, k) < 0.2_wp), problem)
         call compare(integrator_settings_t(method='taylor', conserve=.true.), &
                      run_plan_t(goal=run_goal_t(local_tolerance=1e-16_wp)))
         if (.not. allocated(error)) call compare(integrator_settings_t(order=8, formulation='reduced'), &
                                                  run_plan_t(time_step=2*pi/200))
      end do

   contains

      subroutine compare(settings, plan)
         type(integrator_settings_t), intent(in) :: settings
         !> Without its end.
         type(run_plan_t), intent(in) :: plan
         type(run_plan_t) :: whole
         type(state_t) :: state
         type(status_t) :: status
         real(wp) :: turn
         state = problem%start
         whole = plan
         whole%end_time = 2*pi*revolutions(k)
         call integrate(problem%system, settings, state, whole, status)
         call check(error, status%ok(), trim(status%message))
         turn = pi*states(3, k)*revolutions(k)
         call check_close(error, state%q, quat_product(quat_exp([0.0_wp, 0.0_wp, turn]), problem%start%q), 1e-11_wp, &
                          "attitude")
         call check_close(error, angular_velocity(problem%system, state), [0.0_wp, 0.0_wp, states(5, k)], 1e-11_wp, &
                          "rate")
      end subroutine compare

   end subroutine states_come_back

   !> Computes the change, after a period, of a small rotation about body axes and of a small change of rate.
   subroutine grown(error, problem, end_time, turn, change, after)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: end_time
      !> rad, and rad/s; body axes; shape (3).
      real(wp), intent(in) :: turn(3), change(3)
      !> Rotation and change of rate at the end, relative to the initial state; shape (6).
      real(wp), intent(out) :: after(6)
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: q(4), omega(3)
      omega = angular_velocity(problem%system, problem%start)
      state = make_state(problem%system, quat_product(problem%start%q, quat_exp(0.5_wp*turn)), omega + change)
      call integrate(problem%system, integrator_settings_t(order=8, formulation='reduced'), state, &
                     run_plan_t(time_step=2*pi/200, end_time=end_time), status)
      call check(error, status%ok(), trim(status%message))
      q = quat_product(quat_conjugate(problem%start%q), state%q)
      after = [2*q(2:4)/q(1), angular_velocity(problem%system, state) - omega]
   end subroutine grown

   !> Some rows and columns of the monodromy matrix, by central differences.
   subroutine monodromy(error, problem, end_time, axes, matrix)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: end_time
      !> 1 to 3: turns; 4 to 6: rates.
      integer, intent(in) :: axes(:)
      real(wp), intent(out) :: matrix(size(axes), size(axes))
      real(wp), parameter :: h = 1e-5_wp
      real(wp) :: start(6), after(6, 2)
      integer :: i, side
      do i = 1, size(axes)
         do side = 1, 2
            start = 0.0_wp
            start(axes(i)) = merge(h, -h, side == 1)
            call grown(error, problem, end_time, start(1:3), start(4:6), after(:, side))
            if (allocated(error)) return
         end do
         matrix(:, i) = (after(axes, 1) - after(axes, 2))/(2*h)
      end do
   end subroutine monodromy

   subroutine planar_traces(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      real(wp) :: matrix(2, 2)
      integer :: k
      problem => new_problem()
      do k = 1, size(states, 2)
         call make_problem(k, merge(0.6_wp, 0.9998_wp, states(1, k) < 0.2_wp), problem)
         call monodromy(error, problem, 2*pi*revolutions(k), [3, 6], matrix)
         if (allocated(error)) return
         ! The differences are of second order, their error the larger the farther neighbours part.
         call check_close(error, matrix(1, 1) + matrix(2, 2), states(6, k), 1e-7_wp + 1e-8_wp*states(6, k)**2, "trace")
      end do
   end subroutine planar_traces

   !> The multipliers are λ₁, 1/λ₁, λ₂, 1/λ₂: the traces of the matrix and of its square give both λ + 1/λ, which is
   !> between -2 and 2 on the unit circle.
   subroutine tilt_multipliers(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      real(wp) :: matrix(4, 4), square(4, 4), traces(2), pairs(2), expected
      integer :: k, j
      problem => new_problem()
      do k = 1, size(tilts)
         call make_problem(tilts(k)%state, tilts(k)%smallest, problem)
         call monodromy(error, problem, 2*pi*revolutions(tilts(k)%state), [1, 2, 4, 5], matrix)
         if (allocated(error)) return
         square = matmul(matrix, matrix)
         traces = [sum([(matrix(j, j), j=1, 4)]), sum([(square(j, j), j=1, 4)])]
         pairs = 0.5_wp*traces(1) + [1, -1]*sqrt(0.5_wp*(traces(2) + 4) - 0.25_wp*traces(1)**2)
         ! The larger one first.
         if (abs(pairs(2)) > abs(pairs(1))) pairs = pairs([2, 1])
         do j = 1, 2
            associate (multiplier => tilts(k)%multipliers(j))
               if (abs(multiplier) > 0.0_wp) then
                  expected = multiplier + 1/multiplier
                  call check_close(error, pairs(j), expected, tilts(k)%digits, "growing pair")
               else
                  call check_below(error, abs(pairs(j)), 2.0_wp, "pair on the unit circle")
               end if
            end associate
         end do
      end do
   end subroutine tilt_multipliers

end submodule test_moon_states
