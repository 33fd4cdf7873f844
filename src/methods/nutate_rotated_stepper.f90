!> A stepper around another one, for a motion that does not depend on the rotation of the space axes
!> (`follows_rotating_axes`): torque-free bodies, and potentials that are symmetric about the rate ω. The stepper inside
!> performs its step in fixed axes, as cheap and as long as there; then the state is rotated back by ωΔt, exactly. The
!> step conserves T + V, l·ω and |l| in these axes; all of these stay, and with them H - ω·l.
!>
!> All other motions are integrated by equations that contain ω. Power series rotate their sums themselves.
module nutate_rotated_stepper
   use nutate_invariants, only: follows_rotating_axes
   use nutate_kinds, only: wp, pi
   use nutate_limits, only: greatest_turn
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_range, only: check_start
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OFF_BRANCH
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_stepper_wrapper, only: stepper_wrapper_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: rotated_stepper_t

   !> A stepper and the rotation of its states. `step` allocates nothing.
   type, extends(stepper_wrapper_t) :: rotated_stepper_t
      private
      !> The system of the last `prepare` is stepped in fixed axes; that system in fixed axes.
      logical :: there = .false.
      type(system_t) :: standing
      !> |ω|, rad/s, and -ω over it; shape (3).
      real(wp) :: rate = 0.0_wp, axis(3) = 0.0_wp
      !> Length of the step for which the rotation was computed last, s, and d, its quaternion minus 1; shape (4).
      real(wp) :: length = 0.0_wp, change(4) = 0.0_wp
      !> The next step is the first since `prepare`. Start of the last step, s.
      logical :: untested = .true.
      real(wp) :: start = 0.0_wp
   contains
      procedure :: set_up
      procedure :: advance
      procedure :: mark_step
      procedure :: state_at
      procedure :: propagate_step
      procedure :: propagate_inside
   end type rotated_stepper_t

contains

   !> Prepares the stepper inside for the system in fixed axes, or for the system itself if its motion depends on the
   !> rotation. Errors: those of the stepper's `prepare`; `NUTATE_BAD_ARGUMENT` if there is none.
   subroutine set_up(self, system, settings, status)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      call self%check_base('a turn of the axes', status)
      if (.not. status%ok()) return
      self%there = follows_rotating_axes(system%effects) .and. settings%attitude
      self%untested = .true.
      self%length = 0.0_wp
      self%change = 0.0_wp
      if (.not. self%there) then
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

   !> Performs one step and the rotation. Errors, with the state as it was: those of the stepper; `NUTATE_OFF_BRANCH` if
   !> the axes rotate so far in it that the digits of the rotation are lost.
   subroutine advance(self, system, state, dt, window_time, status)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      if (.not. self%there) then
         call self%advance_base(system, state, dt, window_time, status)
         return
      end if
      if (self%untested) call check_start(system, state, dt, status)
      if (status%code == 0 .and. dt /= self%length) call set_turn(self, dt, status)
      if (status%code /= 0) return
      call self%base%advance(self%standing, state, dt, window_time, status)
      call self%copy_counts()
      if (status%code /= 0) return
      self%error_estimate = self%base%error_estimate
      self%untested = .false.
      call turn_state(self%change, state)
   end subroutine advance

   !> Sets the length of a step: the quaternion c = 1 + d of the rotation, -ω̂ sin x its vector, x = ½|ω|Δt. The length
   !> of c depends on the vector as it is rounded, so that rotations of one length do not stretch what they rotate.
   pure subroutine set_turn(self, dt, status)
      class(rotated_stepper_t), intent(inout) :: self
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      type(status_t), intent(inout) :: status
      real(wp) :: angle, square
      angle = self%rate*dt
      if (.not. abs(angle) <= greatest_turn) then
         status = fail(NUTATE_OFF_BRANCH, 'the step is too long: the space axes turn too far')
         return
      end if
      ! Beyond half a revolution the rotation is the shorter one in the other direction, with the opposite quaternion.
      angle = angle - (2*pi)*anint(angle/(2*pi))
      self%change(2:4) = sin(0.5_wp*angle)*self%axis
      square = min(dot_product(self%change(2:4), self%change(2:4)), 1.0_wp)
      self%change(1) = -square/(1 + sqrt(1 - square))
      self%length = dt
   end subroutine set_turn

   !> Rotates attitude and momentum.
   pure subroutine turn_state(d, state)
      !> Shape (4).
      real(wp), intent(in) :: d(4)
      type(state_t), intent(inout) :: state
      call add_rotated(d, state%q, state%q_compensation)
      call add_rotated(d, state%p, state%p_compensation)
   end subroutine turn_state

   !> Adds d∘x to x by compensated summation: in one procedure, because this is most of the cost of a frame.
   pure subroutine add_rotated(d, x, compensation)
      real(wp), intent(in) :: d(4)
      real(wp), intent(inout) :: x(4), compensation(4)
      real(wp) :: addend(4), rounded(4)
      addend(1) = (d(1)*x(1) - d(2)*x(2) - d(3)*x(3) - d(4)*x(4)) + compensation(1)
      addend(2) = (d(1)*x(2) + d(2)*x(1) + d(3)*x(4) - d(4)*x(3)) + compensation(2)
      addend(3) = (d(1)*x(3) + d(3)*x(1) + d(4)*x(2) - d(2)*x(4)) + compensation(3)
      addend(4) = (d(1)*x(4) + d(4)*x(1) + d(2)*x(3) - d(3)*x(2)) + compensation(4)
      rounded = x + addend
      compensation = addend - (rounded - x)
      x = rounded
   end subroutine add_rotated

   !> Sets the start of a step.
   recursive subroutine mark_step(self, state, dt, window_time)
      class(rotated_stepper_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      self%start = state%t
      call self%base%mark_step(state, dt, window_time)
   end subroutine mark_step

   !> Computes the state at a time inside the last step, rotated. Errors: those of the stepper, and of the rotation.
   recursive subroutine state_at(self, system, t, state, work, status, works)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      real(wp), intent(out) :: work
      type(status_t), intent(out) :: status
      real(wp), intent(inout), optional :: works(:)
      type(state_t) :: inside
      if (.not. self%there) then
         call self%base%state_at(system, t, state, work, status, works)
         self%step_error = self%base%step_error
         return
      end if
      call self%base%state_at(self%standing, t, inside, work, status, works)
      self%step_error = self%base%step_error
      if (.not. status%ok()) return
      if (abs(t - self%start) > 0.0_wp) then
         if (t - self%start /= self%length) call set_turn(self, t - self%start, status)
         if (.not. status%ok()) return
         call turn_state(self%change, inside)
      end if
      state = inside
   end subroutine state_at

   !> Moves sensitivities by the stepper inside, in fixed axes; sensitivities are in body axes, which the rotation
   !> leaves as they are. Errors: those of the stepper; `NUTATE_BAD_ARGUMENT` for a change of the axes' rate across a
   !> potential's direction, on which the motion would depend.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      if (.not. self%there) then
         call self%base%propagate_step(system, before, after, dt, window_time, tangent, status)
      else
         call self%base%propagate_step(self%standing, before, standing_state(self, after), dt, window_time, tangent, &
                                     status)
         call rotate_sensitivities(system, after, dt, tangent, status)
      end if
   end subroutine propagate_step

   !> Moves sensitivities to a state inside of the last step.
   recursive subroutine propagate_inside(self, system, state, tangent, status)
      class(rotated_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      if (.not. self%there) then
         call self%base%propagate_inside(system, state, tangent, status)
      else
         call self%base%propagate_inside(self%standing, standing_state(self, state), tangent, status)
         call rotate_sensitivities(system, state, state%t - self%start, tangent, status)
      end if
   end subroutine propagate_inside

   !> Returns a state without the last rotation.
   type(state_t) function standing_state(self, state) result(standing)
      type(rotated_stepper_t), intent(in) :: self
      type(state_t), intent(in) :: state
      real(wp) :: back(4), zero(4)
      back = [self%change(1), -self%change(2:4)]
      standing = state
      if (.not. abs(self%length) > 0.0_wp) return
      zero = 0.0_wp
      call add_rotated(back, standing%q, zero)
      zero = 0.0_wp
      call add_rotated(back, standing%p, zero)
   end function standing_state

   !> Changes θ of sensitivities to the rate ω of the axes, which rotate by a = -ωΔt: the change of a is a rotation
   !> J(a)δa, J = 1 + (1 - cos a)/a² [a]× + (a - sin a)/a³ [a]×².
   subroutine rotate_sensitivities(system, after, dt, tangent, status)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: after
      !> Length of the step, s.
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
