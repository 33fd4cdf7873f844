!> `method = 'exact'`: a free body by its closed solution, at any times.
module nutate_exact_stepper
   use nutate_archive, only: archive_t
   use nutate_exact_free, only: free_body_t
   use nutate_exact_tangent, only: exact_tangent_t
   use nutate_hamiltonian, only: angular_velocity, body_momentum, system_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_same_time
   use nutate_quaternion, only: quat_norm, quat_product
   use nutate_range, only: check_start
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: dense_stepper_t, integrator_settings_t, is_inside, outside, step_goal_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: exact_t, round_off_of_exact

   !> Rotation in a step whose length is left to the method, rad: if the ends of steps are observed, Euler angles are
   !> followed from one to the next, and are lost at 2π; otherwise far below the rotation at which digits of the
   !> direction are lost.
   real(wp), parameter :: usual_turn = 1.0_wp, longest_turn = 1e6_wp

   !> A stepper without an error: every step goes back to the state that the solution started from.
   type, extends(dense_stepper_t) :: exact_t
      private
      type(free_body_t) :: solution
      !> The solution's start, and the state that the last step left: one that differs starts a new solution.
      type(state_t) :: first, last
      logical :: started = .false.
      !> The solution is that from `first`.
      logical :: solved = .false.
   contains
      procedure :: set_up
      procedure :: advance
      procedure :: choose_step
      procedure :: state_at
      procedure :: propagate_step
      procedure :: transfer
   end type exact_t

contains

   !> Returns an estimate of the attitude error of the closed solution after a time, rad: that of round-off.
   pure real(wp) function round_off_of_exact(system, state, duration) result(round_off)
      !> System without effects.
      type(system_t), intent(in) :: system
      !> Initial state.
      type(state_t), intent(in) :: state
      !> Time from start to end, s, of either sign.
      real(wp), intent(in) :: duration
      type(free_body_t) :: solution
      type(status_t) :: status
      round_off = 0.0_wp
      call solution%prepare(system%body%moments, state%q, body_momentum(state), status, system%body%axes)
      if (status%ok()) round_off = solution%round_off(duration)
   end function round_off_of_exact

   !> Prepares the stepper. Errors: `NUTATE_BAD_ARGUMENT` if there is an effect: only a free body has a closed solution.
   subroutine set_up(self, system, settings, status)
      class(exact_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      associate (effects => system%effects)
         if (effects%n_potentials + effects%n_off + effects%n_torques + effects%n_rotors > 0 .or. effects%frame_turns) &
            status = fail(NUTATE_BAD_ARGUMENT, "method 'exact' solves free bodies only (expected no effects)", 'method')
      end associate
      if (.not. settings%projection) &
         status = fail(NUTATE_BAD_ARGUMENT, 'the exact solution has no projection', 'projection')
      self%started = .false.
      self%solved = .false.
   end subroutine set_up

   !> Performs one step. Errors: `NUTATE_BAD_ARGUMENT`, `NUTATE_BAD_BODY` for a state or body that has no solution.
   subroutine advance(self, system, state, dt, window_time, status)
      class(exact_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status

      if (.not. abs(state%t + dt) <= huge(dt)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time is not finite')
         return
      end if
      if (self%started) self%started = is_last(self, state, dt)
      if (.not. self%started) then
         call check_start(system, state, dt, status)
         if (.not. status%ok()) return
         self%first = state
         self%started = .true.
         self%solved = .false.
      end if
      if (.not. self%solved) then
         call self%solution%prepare(system%body%moments, self%first%q, body_momentum(self%first), status, &
                                    system%body%axes)
         self%solved = status%ok()
         self%started = self%solved
         if (.not. self%solved) return
      end if
      call put_solution(self, state%t + dt, state)
      self%last = state
   end subroutine advance

   !> Returns true for the state that the last step left; its time may have been rounded differently.
   pure logical function is_last(self, state, dt)
      type(exact_t), intent(in) :: self
      type(state_t), intent(in) :: state
      !> s.
      real(wp), intent(in) :: dt
      is_last = all(abs(state%q - self%last%q) <= 0.0_wp) .and. all(abs(state%p - self%last%p) <= 0.0_wp) .and. &
                is_same_time(state%t, self%last%t, dt)
   end function is_last

   !> Evaluates the solution at a time.
   subroutine put_solution(self, t, state)
      type(exact_t), intent(in) :: self
      !> s.
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      real(wp) :: momentum(3)
      state%t = t
      call self%solution%evaluate(t - self%first%t, state%q, momentum)
      state%p = 2*quat_product(state%q, [0.0_wp, momentum])
      state%q_compensation = 0.0_wp
      state%p_compensation = 0.0_wp
   end subroutine put_solution

   !> Chooses the step: to the end of the run, or, if the ends of steps are observed, about a radian of rotation: |Ω| is
   !> at most √(2T/J), J the least moment, which does not change.
   recursive subroutine choose_step(self, system, state, goal, step, status)
      class(exact_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(step_goal_t), intent(in) :: goal
      real(wp), intent(inout) :: step
      type(status_t), intent(inout) :: status
      real(wp) :: rate, turn
      associate (body => system%body)
         rate = quat_norm([0.0_wp, matmul(angular_velocity(system, state), body%axes) &
                           *sqrt(body%moments/minval(body%moments))])
      end associate
      turn = merge(usual_turn, longest_turn, goal%seen)
      ! A step that reaches the end is cut there, without the rounding of the time.
      step = 2*abs(goal%end_time - state%t)
      if (.not. goal%seen) step = min(step, goal%longest)
      if (step*rate > turn) step = turn/rate
   end subroutine choose_step

   !> Computes the state at a time, inside the last step if steps are kept. Errors: `NUTATE_BAD_ARGUMENT` elsewhere.
   subroutine state_at(self, system, t, state, work, status, works)
      class(exact_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      real(wp), intent(out) :: work
      type(status_t), intent(out) :: status
      real(wp), intent(inout), optional :: works(:)
      work = 0.0_wp
      if (present(works)) works = 0.0_wp
      if (.not. self%solved .or. (self%keeps_steps .and. .not. is_inside(self, t))) then
         status = fail(NUTATE_BAD_ARGUMENT, outside)
      else
         call put_solution(self, t, state)
      end if
   end subroutine state_at

   !> Moves sensitivities by the derivative of the solution. Errors: `NUTATE_BAD_ARGUMENT` for sensitivities to anything
   !> but initial state and inertia, and for those that rotate principal axes of equal moments.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(exact_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      type(free_body_t) :: solution
      type(exact_tangent_t) :: derivative
      real(wp) :: theta(3), momentum(3), own(3, 2, size(tangent%parametric))
      logical :: possible
      integer :: k, m
      call solution%prepare(system%body%moments, before%q, body_momentum(before), status, system%body%axes)
      if (.not. status%ok()) return
      call derivative%set(solution, dt)
      do m = 1, size(tangent%parametric)
         associate (variation => tangent%variations(tangent%parametric(m)))
            if (any(abs([variation%rotor, variation%frame]) > 0.0_wp)) &
               status = fail(NUTATE_BAD_ARGUMENT, "method = 'exact' has sensitivities by start and inertia only "// &
                             '(expected another method)', 'method')
            call derivative%of_inertia(tangent%inertia(:, :, m), own(:, 1, m), own(:, 2, m), possible)
            if (.not. possible) status = fail(NUTATE_BAD_ARGUMENT, "method = 'exact' has no sensitivities by "// &
                                              'products of inertia between equal moments (expected another method)', &
                                              'method')
         end associate
         if (.not. status%ok()) return
      end do
      do k = 1, tangent%n
         theta = tangent%theta(k, :)
         momentum = tangent%momentum(k, :)
         call derivative%of_start(theta, momentum)
         tangent%theta(k, :) = theta
         tangent%momentum(k, :) = momentum
      end do
      do m = 1, size(tangent%parametric)
         k = tangent%parametric(m)
         tangent%theta(k, :) = tangent%theta(k, :) + own(:, 1, m)
         tangent%momentum(k, :) = tangent%momentum(k, :) + own(:, 2, m)
      end do
   end subroutine propagate_step

   !> Writes or reads the start of the solution and the end of the last step; the solution is found again from its
   !> start.
   subroutine transfer(self, archive)
      class(exact_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call self%first%transfer(archive)
      call self%last%transfer(archive)
      call archive%transfer(self%started)
      if (archive%is_reading()) self%solved = .false.
   end subroutine transfer

end module nutate_exact_stepper
