!> Limits of the projection onto the invariants: equilibria, saddles, the turning points of a pendulum, steps that are
!> too long.
submodule(suites_of_runs) test_conserve_limits
   use nutate_invariant_projection, only: invariant_projection_t
   use nutate_body, only: diagonal, make_body
   use nutate_damping, only: damping_t
   use nutate_kinds, only: wp, eps, pi
   use nutate_methods, only: default_settings, integrator_settings_t, stepper_t
   use nutate_quaternion, only: attitude_distance, quat_exp, quat_product, rotation_matrix
   use nutate_run, only: integrate
   use nutate_run_plan, only: run_goal_t, run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: NUTATE_OFF_BRANCH, status_t
   use test_conserving_runs, only: check_run, get_stepper, go, methods
   use test_problems, only: body_momentum, forced_body, free_body, make_state, new_problem, problem_t, simo_top, &
      total_energy
   use test_support, only: check, check_below, check_close, error_type, new_unittest
   implicit none

contains

   module procedure collect_conserve_limits
      testsuite = [ &
                  new_unittest("equilibria stay where they are", equilibria_stay), &
                  new_unittest("motions next to equilibria are no rougher", next_to_equilibria), &
                  new_unittest("the separatrix is passed", separatrix_is_passed), &
                  new_unittest("large errors next to a saddle are removed", large_errors_are_removed), &
                  new_unittest("too long a move is refused, nothing changed", long_moves_are_refused), &
                  new_unittest("a pendulum keeps the order at the bottom", pendulum_keeps_the_order), &
                  new_unittest("round-off of the energy moves nothing far", round_off_moves_nothing), &
                  new_unittest("a steady rod stays as good as without projection", steady_rod), &
                  new_unittest("any length of q is put right", any_length_is_put_right), &
                  new_unittest("a wild state leaves no trace", wild_state_leaves_no_trace), &
                  new_unittest("damped motions come to rest", damped_motions_come_to_rest)]
   end procedure collect_conserve_limits

   !> Checks states of stationary energy: each principal axis, no momentum at all, a top that sleeps, hangs or stands.
   subroutine equilibria_stay(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: axes(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
                                                   1.0_wp], [3, 3]), nothing(3) = 0.0_wp
      real(wp), parameter :: up(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], down(4) = [0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp]
      type(problem_t), pointer :: top
      integer :: i
      do i = 1, 3
         call check_spin(error, free_body([0.6_wp, 0.8_wp, 1.0_wp], axes(:, i)))
      end do
      call check_spin(error, free_body([0.6_wp, 0.8_wp, 1.0_wp], nothing))
      top => simo_top()
      do i = 1, 3
         if (allocated(error)) return
         if (i == 1) top%start = make_state(top%system, up, [0.0_wp, 0.0_wp, 50.0_wp])
         if (i == 2) top%start = make_state(top%system, down, nothing)
         if (i == 3) top%start = make_state(top%system, up, nothing)
         call check_spin(error, top)
      end do
   end subroutine equilibria_stay

   !> The body momentum is what it was, to round-off of the steps taken.
   subroutine check_spin(error, problem)
      type(error_type), allocatable, intent(inout) :: error
      type(problem_t), intent(in) :: problem
      type(state_t) :: state
      real(wp) :: before(3)
      integer :: m
      before = body_momentum(problem%start)
      do m = 1, 2
         call go(error, problem, methods(m), .true., 0.01_wp, 10000, state)
         call check_close(error, body_momentum(state), before, 1e-13_wp*norm2(before), methods(m)//" L")
         call check_run(error, problem, methods(m), 0.01_wp, 1000, 1)
      end do
   end subroutine check_spin

   !> Tilted from an equilibrium by angles around the square root of round-off, and more: the projection adds no more to
   !> the attitude than the method's own error, whatever it takes for energy.
   subroutine next_to_equilibria(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: plain, corrected
      real(wp) :: tilt
      integer :: k
      do k = 0, 12, 2
         tilt = 10.0_wp**(-k)
         problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [0.1_wp*tilt, 0.2_wp*tilt, 1.0_wp])
         call go(error, problem, 'rk4', .true., 0.1_wp, 2000, corrected)
         call go(error, problem, 'dop853', .false., 0.05_wp, 4000, plain)
         call check_below(error, attitude_distance(corrected%q, plain%q), 1e-4_wp, "spin")
         call check_close(error, body_momentum(corrected), body_momentum(plain), 1e-4_wp*tilt + 4*2000*eps, "L")
         call check_run(error, problem, 'rk4', 0.1_wp, 2000, 1)
      end do
   end subroutine next_to_equilibria

   !> 2TJ₂ = |L|²: the motion that comes from a rotation about the middle axis and goes to one, where H has a saddle.
   subroutine separatrix_is_passed(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: moments(3) = [1.0_wp, 2.0_wp, 3.0_wp]
      real(wp) :: along, momentum(3)
      integer :: k, m
      do k = 0, 9, 3
         ! L₁²(1/J₁ - 1/J₂) = L₃²(1/J₂ - 1/J₃)
         along = 10.0_wp**(-k)
         momentum = along*[sqrt(1.0_wp/6), 0.0_wp, sqrt(1.0_wp/2)]
         momentum(2) = -sqrt(max(0.0_wp, 1 - sum(momentum**2)))
         do m = 1, 2
            call check_run(error, free_body(moments, momentum), methods(m), 0.1_wp, 3000, 1)
         end do
      end do
   end subroutine separatrix_is_passed

   !> Attitudes rotated away by up to 0.01 rad at fixed l, next to a saddle and far from it.
   subroutine large_errors_are_removed(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: tilts(3) = [0.05_wp, 0.1_wp, 0.5_wp]
      type(problem_t), pointer :: problem
      type(invariant_projection_t) :: projection
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: energy
      integer :: i, k
      do i = 1, size(tilts)
         problem => free_body([5.0_wp, 20.0_wp, 17.0_wp], &
                             170*[sin(tilts(i))*0.8_wp, sin(tilts(i))*0.6_wp, cos(tilts(i))])
         energy = total_energy(problem%system, problem%start)
         call projection%prepare(problem%system, .true., .false.)
         do k = 2, 8
            call projection%follow(problem%system, problem%start)
            state = rotated(problem%start, 0.1_wp**k*[0.5_wp, -0.4_wp, 0.3_wp])
            call projection%project(problem%system, state, 0.0_wp, status)
            call check(error, status%ok(), trim(status%message))
            call check_close(error, total_energy(problem%system, state), energy, 8*eps*energy, "energy")
            call check_below(error, attitude_distance(state%q, problem%start%q), 2*0.1_wp**k, "far away")
         end do
      end do
   end subroutine large_errors_are_removed

   !> The state rotated at fixed space momentum: q∘exp(v), p = 2[0, l]∘q.
   function rotated(start, v) result(state)
      type(state_t), intent(in) :: start
      real(wp), intent(in) :: v(3)
      type(state_t) :: state
      state = start
      state%q = quat_product(start%q, quat_exp(v))
      state%p = quat_product(start%p, quat_exp(v))
   end function rotated

   !> A step so long that the energy is beyond reach: through the stepper the state stays, and so do the targets.
   subroutine long_moves_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      class(stepper_t), allocatable :: stepper, fresh
      type(state_t) :: a, b
      type(status_t) :: status
      integer :: k
      problem => forced_body()
      call get_stepper(problem, 'rk4', .true., stepper, status)
      call get_stepper(problem, 'rk4', .true., fresh, status)
      a = problem%start
      b = a
      do k = 1, 20
         call stepper%step(problem%system, a, 0.02_wp, status)
         if (status%ok()) call fresh%step(problem%system, b, 0.02_wp, status)
         call check(error, status%ok(), trim(status%message))
         a%q_compensation = eps*a%q
         b%q_compensation = a%q_compensation
         call stepper%step(problem%system, a, 1.5_wp, status)
         call check(error, status%code, NUTATE_OFF_BRANCH)
         call check(error, index(status%message, 'energy') > 0, "refused by the method itself")
         call check_close(error, [a%t, a%q, a%p, a%q_compensation], [b%t, b%q, b%p, b%q_compensation], 0.0_wp, "state")
      end do
   end subroutine long_moves_are_refused

   !> A plane pendulum: at the bottom of each swing no turn changes its energy, at the end of each no momentum does.
   subroutine pendulum_keeps_the_order(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: reference, state
      real(wp) :: errors(2, 2)
      integer :: k, m
      problem => simo_top()
      problem%start = make_state(problem%system, [cos(0.4_wp*pi), sin(0.4_wp*pi), 0.0_wp, 0.0_wp], &
                                 [0.0_wp, 0.0_wp, 0.0_wp])
      call go(error, problem, 'dop853', .false., 0.01_wp, 2000, reference)
      do k = 1, 2
         do m = 0, 1
            if (.not. allocated(error)) call go(error, problem, 'rk4', m == 1, 0.1_wp/k, 200*k, state)
            errors(k, m + 1) = attitude_distance(state%q, reference%q)
         end do
         call check_below(error, errors(k, 2), 2*errors(k, 1), "far worse than without")
         call check_run(error, problem, 'rk4', 0.1_wp/k, 200*k, 1)
      end do
      call check_close(error, log(errors(1, 2)/errors(2, 2))/log(2.0_wp), 4.0_wp, 0.3_wp, "order")
   end subroutine pendulum_keeps_the_order

   !> An account that is wrong by 10 ε, where the energy hardly depends on the attitude, or not at all; one that is
   !> wrong by 1000 ε is not met there.
   subroutine round_off_moves_nothing(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(invariant_projection_t) :: projection
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: energy
      integer :: k
      do k = 6, 10
         problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [0.0_wp, merge(0.0_wp, 0.1_wp**k, k == 10), 1.0_wp])
         energy = total_energy(problem%system, problem%start)
         state = problem%start
         call projection%prepare(problem%system, .true., .false.)
         call projection%follow(problem%system, state)
         call projection%project(problem%system, state, 10*eps*energy, status)
         call check(error, status%ok(), trim(status%message))
         call check_below(error, attitude_distance(state%q, problem%start%q), 64*eps, "moved")
      end do
      call projection%project(problem%system, state, 1000*eps*energy, status)
      call check(error, status%code, NUTATE_OFF_BRANCH)
   end subroutine round_off_moves_nothing

   !> A method need not normalise: p = 2 q∘[0, L] tells L whatever |q|.
   subroutine any_length_is_put_right(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: lengths(4) = [1 + 3e-9_wp, 1 - 3e-9_wp, 1.01_wp, 0.5_wp]
      type(problem_t), pointer :: problem
      type(invariant_projection_t) :: projection
      type(state_t) :: state
      type(status_t) :: status
      integer :: i
      problem => simo_top()
      call projection%prepare(problem%system, .true., .false.)
      do i = 1, size(lengths)
         state = problem%start
         call projection%follow(problem%system, state)
         state%q = lengths(i)*state%q
         state%p = lengths(i)*state%p
         call projection%project(problem%system, state, 0.0_wp, status)
         call check(error, status%ok(), trim(status%message))
         call check_close(error, state%q, problem%start%q, 4*eps, "q")
         call check_close(error, state%p, problem%start%p, 8*eps*norm2(state%p), "p")
      end do
   end subroutine any_length_is_put_right

   !> Rods that rotate steadily about a transverse axis, where H is stationary among all states of the same l, and whose
   !> kinetic energy is a small difference of large terms if the tensor is not diagonal: round-off of H is no reason to
   !> rotate them. The remaining error is that of rounding the terms of J⁻¹ and L of a rod: an angular velocity along
   !> its axis, by 1/thin each.
   subroutine steady_rod(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: thin(3) = [0.3_wp, 1e-2_wp, 1e-3_wp], rate = 1.7_wp, duration = 60.0_wp
      type(problem_t), pointer :: problem
      type(state_t) :: state
      type(status_t) :: status
      type(integrator_settings_t) :: settings
      real(wp) :: axes(3, 3), omega(3)
      integer :: i, k
      problem => new_problem()
      settings = default_settings('dop853')
      settings%conserve = .true.
      do i = 1, size(thin)
         do k = 1, 8
            axes = rotation_matrix(quat_exp([0.1_wp*k, 0.5_wp, -0.3_wp]))
            call make_body(matmul(axes, matmul(diagonal([thin(i), 1.0_wp, 1.0_wp]), transpose(axes))), &
                           problem%system%body, status)
            omega = rate*matmul(axes, [0.0_wp, cos(0.7_wp*k), sin(0.7_wp*k)])
            problem%start = make_state(problem%system, quat_exp([0.3_wp*k, -0.8_wp, 1.1_wp]), omega)
            state = problem%start
            call integrate(problem%system, settings, state, &
                           run_plan_t(end_time=duration, goal=run_goal_t(local_tolerance=1e-13_wp)), status)
            call check(error, status%ok(), trim(status%message))
            call check_below(error, attitude_distance(state%q, quat_product(problem%start%q, &
                                                                            quat_exp(0.5_wp*duration*omega))), &
                             32*eps*duration*rate/thin(i)**2, "attitude")
         end do
      end do
   end subroutine steady_rod

   !> A refused state of 1e8 times the energy does not make a small error of the next one look like round-off.
   subroutine wild_state_leaves_no_trace(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(invariant_projection_t) :: projection
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: energy
      problem => simo_top()
      energy = total_energy(problem%system, problem%start)
      call projection%prepare(problem%system, .true., .false.)
      call projection%follow(problem%system, problem%start)
      state = problem%start
      state%p = 1e4_wp*state%p
      call projection%project(problem%system, state, 0.0_wp, status)
      call check(error, status%code, NUTATE_OFF_BRANCH)
      state = problem%start
      state%p = (1 + 1e-12_wp)*state%p
      status = status_t()
      call projection%project(problem%system, state, 0.0_wp, status)
      call check(error, status%ok(), trim(status%message))
      call check_close(error, total_energy(problem%system, state), energy, 8*eps*energy, "energy")
   end subroutine wild_state_leaves_no_trace

   !> The account of a free body ends where nothing is left of its energy, that of a pendulum where H has a minimum.
   subroutine damped_motions_come_to_rest(error)
      type(error_type), allocatable, intent(out) :: error
      type(problem_t), pointer :: problem
      type(state_t) :: state
      integer :: i, m
      problem => new_problem()
      do i = 1, 2
         if (i == 1) problem => free_body([0.6_wp, 0.8_wp, 1.0_wp], [1.8_wp, 0.4_wp, -0.9_wp])
         if (i == 2) problem => simo_top()
         call problem%system%effects%add(damping_t([0.2_wp, 0.3_wp, 0.4_wp]*merge(1, 20, i == 1)))
         if (i == 2) problem%start = make_state(problem%system, [0.6_wp, 0.8_wp, 0.0_wp, 0.0_wp], &
                                                [0.0_wp, 0.5_wp, 0.2_wp])
         do m = 1, 2
            call check_run(error, problem, methods(m), 0.1_wp, 5000, 1)
            if (.not. allocated(error)) call go(error, problem, methods(m), .true., 0.1_wp, 5000, state)
            call check_below(error, norm2(body_momentum(state)), 1e-9_wp, "still moves")
         end do
      end do
   end subroutine damped_motions_come_to_rest

end submodule test_conserve_limits
