!> Torques and rotors against what is known about them without this code: closed forms, and other bodies.
submodule(suites_of_effects) test_torque_physics
   use nutate_applied_torque, only: applied_torque_t
   use nutate_body, only: make_shape_body
   use nutate_damping, only: damping_t
   use nutate_gravity, only: gravity_t
   use nutate_kinds, only: wp, pi, eps
   use nutate_nielsen_krenk, only: nielsen_krenk_t
   use nutate_quaternion, only: attitude_distance, quat_exp, rotate_to_space
   use nutate_rotor, only: rotor_t
   use nutate_run, only: integrate, observer_t, run_record_t, run_summary_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use test_effect_samples, only: sample_body, spinner
   use test_problems, only: angular_velocity, body_momentum, kinetic_energy, make_state, new_problem, problem_t, &
      solve, space_momentum, system_t
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

   !> Sees the rows and keeps nothing but the last work.
   type, extends(observer_t) :: work_recorder_t
      real(wp) :: work = 0.0_wp
   contains
      procedure :: observe => note_work
   end type work_recorder_t

   real(wp), parameter :: identity(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], axis3(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

   module procedure collect_torque_physics
      testsuite = [ &
                  new_unittest("damping decays a spin", damping_decays_a_spin), &
                  new_unittest("a constant torque does work", constant_torque_does_work), &
                  new_unittest("a harmonic torque drives a spin", harmonic_torque_drives_a_spin), &
                  new_unittest("a torque acts from start to stop", torque_acts_from_start_to_stop), &
                  new_unittest("a torque in space axes turns the momentum", space_torque_turns_the_momentum), &
                  new_unittest("work is told for each torque", work_is_told_for_each_torque), &
                  new_unittest("a gyrostat rotates steadily", gyrostat_rotates_steadily), &
                  new_unittest("a rotor stands for faster spin", rotor_stands_for_faster_spin), &
                  new_unittest("a rotor stabilises the intermediate axis", rotor_stabilises_the_axis)]
   end procedure collect_torque_physics

   subroutine note_work(self, system, state, record, status)
      class(work_recorder_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      self%work = record%work
   end subroutine note_work

   !> Runs a problem to a time through `integrate`.
   subroutine run_to(error, problem, dt, t, state, summary, recorder)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      real(wp), intent(in) :: dt, t
      type(state_t), intent(out) :: state
      type(run_summary_t), intent(out) :: summary
      type(work_recorder_t), intent(out) :: recorder
      type(nielsen_krenk_t) :: stepper
      type(status_t) :: status
      state = problem%start
      call stepper%prepare(problem%system, integrator_settings_t(), status)
      call integrate(problem%system, stepper, state, run_plan_t(time_step=dt, end_time=t), status, recorder, summary)
      call check(error, status%ok(), trim(status%message))
   end subroutine run_to

   !> J Ω̇ = -cΩ. A step multiplies Ω by (1 - x/2)/(1 + x/2), x = cΔt/J: the exact exponential up to x³/12.
   subroutine damping_decays_a_spin(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: x, omega(3)
      integer, parameter :: n = 200
      problem => spinner([3.0_wp, 4.0_wp, 5.0_wp], 2.0_wp)
      call problem%system%effects%add(damping_t([0.3_wp, 0.1_wp, 0.7_wp]))
      call solve(problem, 0.1_wp, n, state, status)
      call check(error, status%ok(), trim(status%message))
      x = 0.7_wp*0.1_wp/5
      omega = angular_velocity(problem%system, state)
      call check_close(error, omega, 2*((1 - x/2)/(1 + x/2))**n*axis3, n*eps, "discrete law")
      call check_close(error, (1 - omega(3)/(2*exp(-n*x)))/(n*x**3/12), 1.0_wp, 1e-2_wp, "error of the exponential")
   end subroutine damping_decays_a_spin

   !> Checks a torque from rest: Ω = τt/J, and the work is the kinetic energy (τt)²/2J; in any motion the work of a
   !> torque alone is the gain.
   subroutine constant_torque_does_work(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(work_recorder_t) :: recorder
      real(wp) :: gain
      problem => spinner([3.0_wp, 4.0_wp, 5.0_wp], 0.0_wp)
      call problem%system%effects%add(applied_torque_t(amplitude=2*axis3))
      call run_to(error, problem, 0.1_wp, 3.0_wp, state, summary, recorder)
      call check_close(error, angular_velocity(problem%system, state), 1.2_wp*axis3, 32*eps, "rate")
      call check_close(error, recorder%work, 3.6_wp, 64*eps, "work from rest")

      problem => spinner([3.0_wp, 4.0_wp, 5.0_wp], 0.0_wp)
      call problem%system%effects%add(applied_torque_t(amplitude=[1.0_wp, -2.0_wp, 0.5_wp]))
      problem%start = make_state(problem%system, identity, [0.3_wp, 0.8_wp, -0.5_wp])
      call run_to(error, problem, 0.1_wp, 3.0_wp, state, summary, recorder)
      gain = kinetic_energy(problem%system, state) - kinetic_energy(problem%system, problem%start)
      call check(error, gain > 1.0_wp, "the torque does no work")
      call check_close(error, recorder%work, gain, 30*8*eps*gain, "work in any motion")
   end subroutine constant_torque_does_work

   !> J Ω̇ = τ cos(2πft + phase): Ω gains τ/(2πfJ) (sin(2πft + phase) - sin(phase)). A step takes the torque at its
   !> middle, which multiplies the gain by y/sin y, y = πfΔt, exactly.
   subroutine harmonic_torque_drives_a_spin(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp), parameter :: f = 0.7_wp, phase = 0.4_wp, dt = 0.02_wp
      real(wp) :: gain, y
      problem => spinner([3.0_wp, 4.0_wp, 5.0_wp], 0.5_wp)
      call problem%system%effects%add(applied_torque_t(amplitude=2*axis3, frequency=f, phase=phase))
      call solve(problem, dt, 165, state, status)
      call check(error, status%ok(), trim(status%message))
      gain = 2/(2*pi*f*5)*(sin(2*pi*f*165*dt + phase) - sin(phase))
      y = pi*f*dt
      call check_close(error, angular_velocity(problem%system, state), (0.5_wp + gain*y/sin(y))*axis3, 1e-14_wp, "rate")
   end subroutine harmonic_torque_drives_a_spin

   !> The momentum gained is τ(stop - start), however long the steps and wherever the times fall among them, forwards
   !> and backwards in time.
   subroutine torque_acts_from_start_to_stop(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(work_recorder_t) :: recorder
      real(wp), parameter :: steps(5) = [0.01_wp, 0.07_wp, 0.25_wp, 0.6_wp, 3.0_wp]
      integer :: i
      problem => spinner([3.0_wp, 4.0_wp, 5.0_wp], 0.1_wp)
      call problem%system%effects%add(applied_torque_t(amplitude=2*axis3, start=0.5_wp, stop=1.37_wp))
      do i = 1, size(steps)
         call run_to(error, problem, steps(i), 3.0_wp, state, summary, recorder)
         call check_close(error, body_momentum(state), (0.5_wp + 2*0.87_wp)*axis3, 1e-14_wp, "momentum")
         call check_close(error, state%t, 3.0_wp, 0.0_wp, "time")
      end do
      problem%start%t = 3.0_wp
      call run_to(error, problem, -0.07_wp, 0.0_wp, state, summary, recorder)
      call check_close(error, body_momentum(state), (0.5_wp - 2*0.87_wp)*axis3, 1e-14_wp, "momentum, backwards")
   end subroutine torque_acts_from_start_to_stop

   !> A torque fixed in space adds τt to the space momentum of a body that rotates any way it likes.
   subroutine space_torque_turns_the_momentum(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(work_recorder_t) :: recorder
      real(wp), parameter :: tau(3) = [1.0_wp, -2.0_wp, 0.5_wp]
      problem => new_problem()
      problem%system = sample_body()
      call problem%system%effects%add(applied_torque_t(amplitude=tau, in_space=.true., start=0.33_wp))
      problem%start = make_state(problem%system, [0.5_wp, -0.5_wp, 0.1_wp, 0.7_wp], [0.7_wp, -1.1_wp, 0.9_wp])
      call run_to(error, problem, 0.1_wp, 3.0_wp, state, summary, recorder)
      call check_close(error, space_momentum(state) - space_momentum(problem%start), 2.67_wp*tau, 1e-13_wp, "momentum")
   end subroutine space_torque_turns_the_momentum

   !> Three torques on a spin: each does its own work, the row tells the sum.
   subroutine work_is_told_for_each_torque(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(run_summary_t) :: summary
      type(work_recorder_t) :: recorder
      real(wp) :: gain
      problem => spinner([3.0_wp, 4.0_wp, 5.0_wp], 0.0_wp)
      call problem%system%effects%add(damping_t([0.0_wp, 0.0_wp, 0.7_wp]))
      call problem%system%effects%add(applied_torque_t(amplitude=2*axis3))
      call problem%system%effects%add(applied_torque_t(amplitude=0.5_wp*axis3, in_space=.true.))
      call run_to(error, problem, 0.1_wp, 3.0_wp, state, summary, recorder)
      gain = kinetic_energy(problem%system, state)
      call check_close(error, sum(summary%work), gain, 64*eps*gain, "sum")
      call check_close(error, recorder%work, gain, 64*eps*gain, "row")
      call check_close(error, summary%work(3), summary%work(2)/4, 64*eps*gain, "share")
      call check(error, summary%work(1) < 0.0_wp, "damping takes energy")
   end subroutine work_is_told_for_each_torque

   !> Checks that a body rotates steadily about an axis that is not principal if JΩ + h lies along Ω; a step rotates it
   !> by 4 atan(Δt|Ω|/4).
   subroutine gyrostat_rotates_steadily(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp), parameter :: omega(3) = [0.6_wp, -0.9_wp, 1.2_wp], dt = 0.1_wp
      integer, parameter :: n = 300
      real(wp) :: rate
      problem => new_problem()
      problem%system = sample_body()
      call problem%system%effects%add(rotor_t(momentum=8*omega - matmul(problem%system%body%inertia, omega)))
      problem%start = make_state(problem%system, identity, omega)
      call solve(problem, dt, n, state, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, angular_velocity(problem%system, state), omega, 1e-13_wp, "rate")
      rate = norm2(omega)
      call check_below(error, attitude_distance(state%q, quat_exp(2*n*atan(dt*rate/4)*omega/rate)), 1e-12_wp, &
                       "attitude")
   end subroutine gyrostat_rotates_steadily

   !> The axis of a heavy symmetric body knows its L3 only: spinning at 150 rad/s, or not, with a rotor.
   subroutine rotor_stands_for_faster_spin(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: fast
      type(problem_t) :: still
      type(state_t) :: a, b
      type(status_t) :: status
      real(wp), parameter :: tilt(4) = [0.9_wp, 0.1_wp*sqrt(19.0_wp), 0.0_wp, 0.0_wp]
      real(wp) :: apart(3), change(3)
      integer :: k, n
      fast => new_problem()
      call make_shape_body('cone', [0.05_wp, 0.1_wp], fast%system%body, status, density=2700.0_wp, &
                           center_of_mass=[0.0_wp, 0.0_wp, 0.075_wp])
      call fast%system%effects%add(gravity_t(fast%system%body, [0.0_wp, 0.0_wp, -9.81_wp]))
      still = fast
      call still%system%effects%add(rotor_t(momentum=matmul(still%system%body%inertia, 150*axis3)))
      fast%start = make_state(fast%system, tilt, [1.0_wp, 2.0_wp, 150.0_wp])
      still%start = make_state(still%system, tilt, [1.0_wp, 2.0_wp, 0.0_wp])
      do k = 1, 3
         n = 200*2**k
         call solve(fast, 0.4_wp/n, n, a, status)
         call solve(still, 0.4_wp/n, n, b, status)
         call check(error, status%ok(), trim(status%message))
         apart(k) = norm2(rotate_to_space(a%q, axis3) - rotate_to_space(b%q, axis3))
      end do
      change = rotate_to_space(b%q, axis3) - rotate_to_space(tilt, axis3)
      call check(error, norm2(change) > 0.5_wp, "the top does not precess")
      call check_close(error, log(apart(1:2)/apart(2:3))/log(2.0_wp), [2.0_wp, 2.0_wp], 0.05_wp, "order")
      call check_below(error, apart(3), 3e-3_wp, "axes apart")
   end subroutine rotor_stands_for_faster_spin

   !> Rotation about axis 3 of moments J1 < J3 < J2 is stable with a rotor along it for (JΩ)₃ + h > J2 Ω, as if J3 were
   !> the largest; small disturbances then turn with λ² = (L3/Ω - J1)(L3/Ω - J2) Ω²/(J1 J2).
   subroutine rotor_stabilises_the_axis(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: omega(3), lambda, period
      integer :: i
      do i = 0, 1
         problem => spinner([5.0_wp, 20.0_wp, 17.0_wp], 0.0_wp)
         if (i == 1) call problem%system%effects%add(rotor_t(momentum=60*axis3))
         problem%start = make_state(problem%system, identity, [1e-5_wp, 0.0_wp, 10.0_wp])
         lambda = 10*sqrt((23.0_wp - 5)*(23 - 20)/(5*20))
         period = 2*pi/lambda
         call solve(problem, period/2000, 2000, state, status)
         call check(error, status%ok(), trim(status%message))
         omega = angular_velocity(problem%system, state)
         if (i == 0) then
            call check(error, norm2(omega(1:2)) > 1e-4_wp, "the free body should leave its axis")
         else
            call check_close(error, omega(1:2), [1e-5_wp, 0.0_wp], 1e-9_wp, "one turn of the disturbance")
         end if
      end do
   end subroutine rotor_stabilises_the_axis

end submodule test_torque_physics
