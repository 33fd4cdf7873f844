!> A stepper of any method for a motion that does not know of the turning of the space axes
!> (`follows_turning_axes`): free bodies, and potentials that are symmetric about their rate ω.
!>
!> The method takes its step in axes that stand still, as cheap and as long as there; then the state is turned back by
!> ωΔt, exactly. What the step keeps in these axes, T + V, l·ω and |l|, stays, and with it H - ω·l; what is proved of
!> its root is proved.
module nutate_turned_stepper
   use nutate_invariants, only: follows_turning_axes
   use nutate_kinds, only: wp, pi
   use nutate_limits, only: greatest_turn
   use nutate_range, only: check_start
   use nutate_state, only: add_increment, state_t
   use nutate_status, only: status_t, fail, NUTATE_OFF_BRANCH
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_stepper_wrapper, only: stepper_wrapper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: turned_stepper_t

   !> A stepper and the turn of its states. `step` allocates nothing.
   type, extends(stepper_wrapper_t) :: turned_stepper_t
      private
      !> Its states are sums of increments, with their compensation.
      logical :: compensated = .false.
      !> The system of the last `prepare` may be stepped so; the same in axes that stand still.
      logical :: follows = .false.
      type(system_t) :: standing
      !> |ω|, rad/s, and -ω over it; shape (3).
      real(wp) :: rate = 0.0_wp, axis(3) = 0.0_wp
      !> Length of step for which the turn was computed last, s, and d, what its quaternion is more than 1; shape (4).
      real(wp) :: length = 0.0_wp, change(4) = 0.0_wp
      !> The next step is the first since `prepare`. Start of the last step, s.
      logical :: untested = .true.
      real(wp) :: start = 0.0_wp
   contains
      !> Takes the stepper whose states to turn; must come before `prepare`.
      procedure :: wrap
      procedure :: set_up
      procedure :: advance
      procedure :: keep_steps
      procedure :: mark_step
      procedure :: state_at
   end type turned_stepper_t

contains

   !> Takes the stepper whose states to turn.
   subroutine wrap(self, base, compensated)
      class(turned_stepper_t), intent(inout) :: self
      !> Moved: not allocated afterwards.
      class(stepper_t), allocatable, intent(inout) :: base
      !> Its states are sums of increments.
      logical, intent(in) :: compensated
      call move_alloc(base, self%base)
      self%compensated = compensated
   end subroutine wrap

   !> A system that knows of the turning is left to the stepper. Errors: those of the stepper's `prepare`;
   !> `NUTATE_BAD_ARGUMENT` where there is none.
   subroutine set_up(self, system, settings, status)
      class(turned_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      call self%check_base('a turn of the axes', status)
      if (.not. status%ok()) return
      self%follows = follows_turning_axes(system%effects) .and. settings%attitude
      self%length = 0.0_wp
      self%untested = .true.
      if (.not. self%follows) then
         call self%base%prepare(system, settings, status)
         return
      end if
      self%rate = norm2(system%effects%frame_rate)
      self%axis = -system%effects%frame_rate/self%rate
      self%standing = system
      self%standing%effects%frame_turns = .false.
      self%standing%effects%frame_rate = 0.0_wp
      call self%base%prepare(self%standing, settings, status)
   end subroutine set_up

   !> One step and the turn. Errors, with the state as it was: those of the stepper; `NUTATE_OFF_BRANCH` where the axes
   !> turn so far in it that the digits of the turn are lost.
   subroutine advance(self, system, state, dt, window_time, status)
      class(turned_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      if (self%untested .and. self%compensated) call check_start(system, state, dt, status)
      if (status%code == 0 .and. dt /= self%length) call set_length(self, dt, status)
      if (status%code /= 0) return
      if (self%follows) then
         call self%base%advance(self%standing, state, dt, window_time, status)
      else
         call self%base%advance(system, state, dt, window_time, status)
      end if
      call self%take_counts()
      if (status%code /= 0) return
      self%untested = .false.
      call self%take_work()
      self%step_error = self%base%step_error
      if (self%follows) call turn_state(self, state)
   end subroutine advance

   !> Takes the length of a step: the quaternion c = 1 + d of the turn, -ω̂ sin x its vector, x = ½|ω|Δt. The length of
   !> c goes by the vector as it is rounded, so that turns of one length do not stretch what they turn.
   pure subroutine set_length(self, dt, status)
      class(turned_stepper_t), intent(inout) :: self
      !> s.
      real(wp), intent(in) :: dt
      type(status_t), intent(inout) :: status
      real(wp) :: angle, square
      if (.not. self%follows) return
      angle = self%rate*dt
      if (.not. abs(angle) <= greatest_turn) then
         status = fail(NUTATE_OFF_BRANCH, 'the step is too long: the space axes turn too far')
         return
      end if
      ! Beyond half a turn the other way round, to the opposite quaternion.
      angle = angle - (2*pi)*anint(angle/(2*pi))
      self%change(2:4) = sin(0.5_wp*angle)*self%axis
      square = min(dot_product(self%change(2:4), self%change(2:4)), 1.0_wp)
      self%change(1) = -square/(1 + sqrt(1 - square))
      self%length = dt
   end subroutine set_length

   !> Turns attitude and momentum by the turn of the length last taken.
   pure subroutine turn_state(self, state)
      class(turned_stepper_t), intent(in) :: self
      type(state_t), intent(inout) :: state
      if (self%compensated) then
         call add_increment(state%q, state%q_compensation, turned(self%change, state%q))
         call add_increment(state%p, state%p_compensation, turned(self%change, state%p))
      else
         state%q = state%q + turned(self%change, state%q)
         state%p = state%p + turned(self%change, state%p)
      end if
   end subroutine turn_state

   !> d∘x, in this file so that it is compiled into its callers: it is all that a frame costs. The compensation of x is
   !> not turned: what that misses is rounding of the increment.
   pure function turned(d, x)
      real(wp), intent(in) :: d(4), x(4)
      real(wp) :: turned(4)
      turned(1) = d(1)*x(1) - d(2)*x(2) - d(3)*x(3) - d(4)*x(4)
      turned(2) = d(1)*x(2) + d(2)*x(1) + d(3)*x(4) - d(4)*x(3)
      turned(3) = d(1)*x(3) + d(3)*x(1) + d(4)*x(2) - d(2)*x(4)
      turned(4) = d(1)*x(4) + d(4)*x(1) + d(2)*x(3) - d(3)*x(2)
   end function turned

   !> The starts of steps are kept where they are taken again: before the turn.
   recursive subroutine keep_steps(self)
      class(turned_stepper_t), intent(inout) :: self
      call self%base%keep_steps()
      self%keeps_steps = .true.
   end subroutine keep_steps

   !> Takes the start of a step.
   recursive subroutine mark_step(self, state, dt, window_time)
      class(turned_stepper_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      self%start = state%t
      call self%base%mark_step(state, dt, window_time)
   end subroutine mark_step

   !> The state at a time inside the last step, turned. Errors: those of the stepper, and of a turn.
   recursive subroutine state_at(self, system, t, state, work, status)
      class(turned_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      real(wp), intent(out) :: work
      type(status_t), intent(out) :: status
      type(state_t) :: inside
      if (.not. self%follows) then
         call self%base%state_at(system, t, state, work, status)
         self%step_error = self%base%step_error
         return
      end if
      call self%base%state_at(self%standing, t, inside, work, status)
      self%step_error = self%base%step_error
      if (.not. status%ok()) return
      if (abs(t - self%start) > 0.0_wp) then
         if (t - self%start /= self%length) call set_length(self, t - self%start, status)
         if (.not. status%ok()) return
         call turn_state(self, inside)
      end if
      state = inside
   end subroutine state_at

end module nutate_turned_stepper
