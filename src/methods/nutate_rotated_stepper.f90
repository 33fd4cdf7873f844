!> A stepper whose states are sums of increments, for a motion that does not know of the rotating of the space axes
!> (`nutate_axes_turn`): it takes its step in axes that stand still, with all that is certified of its root there, and
!> the state is turned back with its compensation. Explicit methods have the turn at the ends of their own steps.
module nutate_rotated_stepper
   use nutate_axes_turn, only: axes_turn_t, rotated
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_range, only: check_start
   use nutate_state, only: add_by_kahan, state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OFF_BRANCH
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_stepper_wrapper, only: stepper_wrapper_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: rotated_stepper_t, rotate_sensitivities

   !> A stepper and the turn of its states. `step` allocates nothing.
   type, extends(stepper_wrapper_t) :: rotated_stepper_t
      private
      !> The system of the last `prepare` may be stepped so; the same in axes that stand still.
      type(axes_turn_t) :: turn
      type(system_t) :: standing
      !> The next step is the first since `prepare`. Start of the last step, s.
      logical :: untested = .true.
      real(wp) :: start = 0.0_wp
   contains
      !> Sets the stepper whose states to turn; must come before `prepare`.
      procedure :: wrap
      procedure :: set_up
      procedure :: advance
      procedure :: mark_step
      procedure :: state_at
      procedure :: propagate_step
      procedure :: propagate_inside
   end type rotated_stepper_t

contains

   !> Sets the stepper whose states to turn.
   subroutine wrap(self, base)
      class(rotated_stepper_t), intent(inout) :: self
      !> Moved: not allocated afterwards.
      class(stepper_t), allocatable, intent(inout) :: base
      call move_alloc(base, self%base)
   end subroutine wrap

   !> A system that knows of the rotating is left to the stepper. Errors: those of the stepper's `prepare`;
   !> `NUTATE_BAD_ARGUMENT` where there is none.
   subroutine set_up(self, system, settings, status)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      call self%check_base('a turn of the axes', status)
      if (.not. status%ok()) return
      call self%turn%prepare(system%effects, settings%attitude)
      self%untested = .true.
      if (.not. self%turn%there) then
         call self%base%prepare(system, settings, status)
         return
      end if
      self%standing = system
      self%standing%effects%frame_turns = .false.
      self%standing%effects%frame_rate = 0.0_wp
      call self%base%prepare(self%standing, settings, status)
   end subroutine set_up

   !> One step and the turn. Errors, with the state as it was: those of the stepper; `NUTATE_OFF_BRANCH` where the axes
   !> turn so far in it that the digits of the turn are lost.
   subroutine advance(self, system, state, dt, window_time, status)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      if (.not. self%turn%there) then
         call self%advance_base(system, state, dt, window_time, status)
         return
      end if
      if (self%untested) call check_start(system, state, dt, status)
      if (status%code == 0 .and. dt /= self%turn%length) call set_turn(self, dt, status)
      if (status%code /= 0) return
      call self%base%advance(self%standing, state, dt, window_time, status)
      call self%copy_counts()
      if (status%code /= 0) return
      self%untested = .false.
      call turn_state(self%turn%change, state)
   end subroutine advance

   !> Sets the length of a step.
   pure subroutine set_turn(self, dt, status)
      class(rotated_stepper_t), intent(inout) :: self
      !> s.
      real(wp), intent(in) :: dt
      type(status_t), intent(inout) :: status
      logical :: possible
      call self%turn%set_length(dt, possible)
      if (.not. possible) status = fail(NUTATE_OFF_BRANCH, 'the step is too long: the space axes turn too far')
   end subroutine set_turn

   !> Turns attitude and momentum: adds d∘q and d∘p.
   pure subroutine turn_state(d, state)
      !> Shape (4).
      real(wp), intent(in) :: d(4)
      type(state_t), intent(inout) :: state
      call add_by_kahan(state%q, state%q_compensation, rotated(d, state%q))
      call add_by_kahan(state%p, state%p_compensation, rotated(d, state%p))
   end subroutine turn_state

   !> Sets the start of a step.
   recursive subroutine mark_step(self, state, dt, window_time)
      class(rotated_stepper_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      self%start = state%t
      call self%base%mark_step(state, dt, window_time)
   end subroutine mark_step

   !> The state at a time inside the last step, rotated. Errors: those of the stepper, and of a turn.
   recursive subroutine state_at(self, system, t, state, work, status, works)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      real(wp), intent(out) :: work
      type(status_t), intent(out) :: status
      real(wp), intent(inout), optional :: works(:)
      type(state_t) :: inside
      if (.not. self%turn%there) then
         call self%base%state_at(system, t, state, work, status, works)
         self%step_error = self%base%step_error
         return
      end if
      call self%base%state_at(self%standing, t, inside, work, status, works)
      self%step_error = self%base%step_error
      if (.not. status%ok()) return
      if (abs(t - self%start) > 0.0_wp) then
         if (t - self%start /= self%turn%length) call set_turn(self, t - self%start, status)
         if (.not. status%ok()) return
         call turn_state(self%turn%change, inside)
      end if
      state = inside
   end subroutine state_at

   !> By the stepper inside, in axes that stand still; sensitivities are in body axes, which the turn leaves as they
   !> are. Errors: those of the stepper; `NUTATE_BAD_ARGUMENT` for a change of the axes' rate across a potential's
   !> direction, of which the motion would know.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      if (.not. self%turn%there) then
         call self%base%propagate_step(system, before, after, dt, window_time, tangent, status)
      else
         call self%base%propagate_step(self%standing, before, standing_state(self, after), dt, window_time, tangent, &
                                     status)
         call rotate_sensitivities(system, after, dt, tangent, status)
      end if
   end subroutine propagate_step

   !> The same to a state inside of the last step.
   recursive subroutine propagate_inside(self, system, state, tangent, status)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      if (.not. self%turn%there) then
         call self%base%propagate_inside(system, state, tangent, status)
      else
         call self%base%propagate_inside(self%standing, standing_state(self, state), tangent, status)
         call rotate_sensitivities(system, state, state%t - self%start, tangent, status)
      end if
   end subroutine propagate_inside

   !> A state without the turn that was made last.
   type(state_t) function standing_state(self, state) result(standing)
      type(rotated_stepper_t), intent(in) :: self
      type(state_t), intent(in) :: state
      real(wp) :: back(4)
      back = [self%turn%change(1), -self%turn%change(2:4)]
      standing = state
      if (.not. abs(self%turn%length) > 0.0_wp) return
      standing%q = state%q + rotated(back, state%q)
      standing%p = state%p + rotated(back, state%p)
   end function standing_state

   !> θ of sensitivities that change the rate ω of the axes: these turn by a = -ωΔt, whose change is a rotation J(a)δa,
   !> J = 1 + (1 - cos a)/a² [a]× + (a - sin a)/a³ [a]×².
   subroutine rotate_sensitivities(system, after, dt, tangent, status)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: after
      !> s.
      real(wp), intent(in) :: dt
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      real(wp) :: a(3), change(3), across(3), angle, second, third
      integer :: k, m
      if (status%code /= 0) return
      a = -dt*system%effects%frame_rate
      angle = norm2(a)
      second = 0.5_wp
      if (angle > 0.0_wp) second = 2*(sin(0.5_wp*angle)/angle)**2
      third = 1.0_wp/6 - angle**2/120 + angle**4/5040
      if (angle > 0.03_wp) third = (angle - sin(angle))/angle**3
      do m = 1, size(tangent%parametric)
         k = tangent%parametric(m)
         change = -dt*tangent%variations(k)%frame
         if (.not. any(abs(change) > 0.0_wp)) cycle
         across = cross(a, change)
         if (system%effects%n_potentials > 0 .and. any(abs(across) > 0.0_wp)) then
            status = fail(NUTATE_BAD_ARGUMENT, 'where the space axes turn about the direction of the potentials, '// &
                          'their rate has a derivative along it only (expected a change along it, or another '// &
                          'method)', 'rate')
            return
         end if
         change = change + second*across + third*cross(a, across)
         tangent%theta(k, :) = tangent%theta(k, :) + rotate_to_body(after%q, change)
      end do
   end subroutine rotate_sensitivities

end module nutate_rotated_stepper
