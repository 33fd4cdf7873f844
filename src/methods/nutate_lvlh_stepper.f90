!> A stepper that works in the LVLH frame, for a satellite on a circular orbit whose space axes are inertial
!> (`nutate_lvlh_view`). It wraps a stepper of any method with its projection. States, works and sensitivities are
!> converted at the ends of a step; the state in LVLH axes travels with the converted one, so that no round-off of the
!> conversions adds up.
module nutate_lvlh_stepper
   use nutate_kinds, only: wp
   use nutate_lvlh_view, only: lvlh_view_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t, step_goal_t, system_t
   use nutate_stepper_wrapper, only: stepper_wrapper_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: lvlh_stepper_t

   !> A stepper and the view in which it works. `step` allocates nothing.
   type, extends(stepper_wrapper_t) :: lvlh_stepper_t
      private
      type(lvlh_view_t) :: view
      !> State of the step under way, LVLH axes.
      type(state_t) :: inner = state_t()
      !> Start of the last step, without balance and wheels, LVLH axes.
      type(state_t) :: start = state_t()
   contains
      procedure :: set_up
      procedure :: advance
      procedure :: choose_step
      procedure :: mark_step
      procedure :: state_at
      procedure :: project_for_output
      procedure :: propagate_step
      procedure :: propagate_inside
   end type lvlh_stepper_t

contains

   !> Prepares the stepper for the system as seen from the LVLH frame, or for the system itself if there is no such
   !> view. Errors: those of the stepper's `prepare`; `NUTATE_BAD_ARGUMENT` without a stepper.
   subroutine set_up(self, system, settings, status)
      class(lvlh_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      type(integrator_settings_t) :: each
      call self%check_base('the LVLH frame', status)
      if (.not. status%ok()) return
      call self%view%prepare(system)
      if (self%view%exists) then
         ! A projection after several steps would change ω·l without work.
         each = settings
         each%project_each = .true.
         call self%base%prepare(self%view%system, each, status)
      else
         call self%base%prepare(system, settings, status)
      end if
   end subroutine set_up

   !> Performs one step in the LVLH frame. Errors, with the state as it was: those of the stepper.
   subroutine advance(self, system, state, dt, window_time, status)
      class(lvlh_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      integer :: i, n
      if (.not. self%view%exists) then
         call self%advance_base(system, state, dt, window_time, status)
         return
      end if
      call self%view%to_lvlh(state, self%inner)
      call set_start(self)
      call self%base%advance(self%view%system, self%inner, dt, window_time, status)
      call self%copy_counts()
      if (status%code /= 0) return
      self%error_estimate = self%base%error_estimate
      self%step_error = self%base%step_error
      self%moved_by_round_off = self%base%moved_by_round_off
      n = size(self%work)
      do i = 1, n - 1
         self%work(i) = self%base%work(i)
      end do
      self%work(n) = self%view%frame_energy(self%inner) - self%view%frame_energy(self%start)
      self%inner%time_dependent_work = self%inner%time_dependent_work + self%work(n)
      self%inner%time_dependent_until = self%inner%t
      call self%view%to_inertial(self%inner, state)
   end subroutine advance

   !> Stores the start of a step.
   subroutine set_start(self)
      class(lvlh_stepper_t), intent(inout) :: self
      self%start%t = self%inner%t
      self%start%q = self%inner%q
      self%start%p = self%inner%p
      self%start%time_dependent_work = self%inner%time_dependent_work
   end subroutine set_start

   !> Computes the length of a step that meets a goal, by the stepper inside.
   recursive subroutine choose_step(self, system, state, goal, step, status)
      class(lvlh_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(step_goal_t), intent(in) :: goal
      real(wp), intent(inout) :: step
      type(status_t), intent(inout) :: status
      if (self%view%exists) then
         call self%view%to_lvlh(state, self%inner)
         call self%base%choose_step(self%view%system, self%inner, goal, step, status)
      else
         call self%base%choose_step(system, state, goal, step, status)
      end if
   end subroutine choose_step

   !> Sets the start of a step.
   recursive subroutine mark_step(self, state, dt, window_time)
      class(lvlh_stepper_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      self%last_start = state
      self%last_length = dt
      self%last_window = window_time
      if (self%view%exists) then
         call self%view%to_lvlh(state, self%inner)
         call set_start(self)
         call self%base%mark_step(self%inner, dt, window_time)
      else
         call self%base%mark_step(state, dt, window_time)
      end if
   end subroutine mark_step

   !> Computes the state at a time inside the last step. Errors: those of the stepper.
   recursive subroutine state_at(self, system, t, state, work, status, works)
      class(lvlh_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      real(wp), intent(out) :: work
      type(status_t), intent(out) :: status
      real(wp), intent(inout), optional :: works(:)
      type(state_t) :: inside
      real(wp) :: each(size(self%base%work)), change
      if (.not. self%view%exists) then
         call self%base%state_at(system, t, state, work, status, works)
         self%step_error = self%base%step_error
         return
      end if
      call self%base%state_at(self%view%system, t, inside, work, status, each)
      self%step_error = self%base%step_error
      if (.not. status%ok()) return
      change = self%view%frame_energy(inside) - self%view%frame_energy(self%start)
      inside%time_dependent_work = self%start%time_dependent_work + change
      inside%time_dependent_until = inside%t
      call self%view%to_inertial(inside, state)
      work = work + change
      if (present(works)) works(:) = [each, change]
   end subroutine state_at

   !> Completes the state that a step left for output: projects one with an open balance.
   subroutine project_for_output(self, system, state)
      class(lvlh_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      if (.not. self%view%exists) then
         call self%base%project_for_output(system, state)
      else if (state%balance%open .and. state%is_from_other_axes()) then
         call self%view%to_lvlh(state, self%inner)
         call self%base%project_for_output(self%view%system, self%inner)
         call self%view%to_inertial(self%inner, state)
      end if
   end subroutine project_for_output

   !> Propagates sensitivities over the last step in the LVLH frame. They are in body axes, which the conversion leaves
   !> as they are; work and energy differ by the change of ω·l. Errors: those of the stepper; `NUTATE_BAD_ARGUMENT` for
   !> derivatives with respect to the elements of the orbit, which require `in_space_axes`.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(lvlh_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      type(state_t) :: first, last
      real(wp) :: energy(tangent%n)
      if (.not. self%view%exists) then
         call self%base%propagate(system, before, after, dt, window_time, tangent, status)
         return
      end if
      call check_sensitivities(tangent, status)
      if (status%code /= 0) return
      call self%view%to_lvlh(before, first)
      call self%view%to_lvlh(after, last)
      energy = tangent%energy
      call enter_frame(self%view, first, tangent)
      call self%base%propagate(self%view%system, first, last, dt, window_time, tangent, status)
      if (status%code == 0) call leave_frame(self%view, last, energy, tangent)
      if (status%code /= 0) call leave_frame(self%view, first, energy, tangent)
   end subroutine propagate_step

   !> Propagates sensitivities to a state inside the last step. Errors: those of `propagate_step`.
   recursive subroutine propagate_inside(self, system, state, tangent, status)
      class(lvlh_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      type(state_t) :: inside
      real(wp) :: energy(tangent%n)
      if (.not. self%view%exists) then
         call self%base%propagate_inside(system, state, tangent, status)
         return
      end if
      call check_sensitivities(tangent, status)
      if (status%code /= 0) return
      call self%view%to_lvlh(state, inside)
      energy = tangent%energy
      call enter_frame(self%view, self%start, tangent)
      call self%base%propagate_inside(self%view%system, inside, tangent, status)
      if (status%code == 0) call leave_frame(self%view, inside, energy, tangent)
      if (status%code /= 0) call leave_frame(self%view, self%start, energy, tangent)
   end subroutine propagate_inside

   !> Errors: `NUTATE_BAD_ARGUMENT` for derivatives with respect to the elements of the orbit.
   subroutine check_sensitivities(tangent, status)
      type(tangent_t), intent(in) :: tangent
      type(status_t), intent(inout) :: status
      integer :: m
      do m = 1, size(tangent%parametric)
         if (tangent%variations(tangent%parametric(m))%changes_orbit()) status = fail(NUTATE_BAD_ARGUMENT, &
            'steps in the LVLH frame have no derivatives with respect to the elements of the orbit '// &
            '(expected settings with in_space_axes)', trim(tangent%variations(tangent%parametric(m))%name))
      end do
   end subroutine check_sensitivities

   !> Subtracts from work and energy of sensitivities the derivatives of ω·l: of its change since the start, and at the
   !> start.
   subroutine enter_frame(view, inner, tangent)
      type(lvlh_view_t), intent(in) :: view
      !> LVLH axes.
      type(state_t), intent(in) :: inner
      type(tangent_t), intent(inout) :: tangent
      real(wp) :: at_start(tangent%n)
      at_start = matmul(tangent%space_momentum, view%rate)
      tangent%work = tangent%work - (matmul(tangent%momentum_row(inner), view%system%effects%frame_rate) - at_start)
      tangent%energy = tangent%energy - at_start
   end subroutine enter_frame

   !> Adds to the work of sensitivities the derivative of the change of ω·l since the start, and restores the energy.
   subroutine leave_frame(view, inner, energy, tangent)
      type(lvlh_view_t), intent(in) :: view
      !> LVLH axes.
      type(state_t), intent(in) :: inner
      !> J per unit of each parameter; shape (n).
      real(wp), intent(in) :: energy(:)
      type(tangent_t), intent(inout) :: tangent
      tangent%work = tangent%work + (matmul(tangent%momentum_row(inner), view%system%effects%frame_rate) - &
                                     matmul(tangent%space_momentum, view%rate))
      tangent%energy = energy
   end subroutine leave_frame

end module nutate_lvlh_stepper
