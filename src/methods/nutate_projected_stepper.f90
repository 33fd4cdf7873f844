!> A stepper of any method with the projection onto the invariants after each of its steps.
module nutate_projected_stepper
   use nutate_archive, only: archive_t
   use nutate_invariant_projection, only: invariant_projection_t
   use nutate_kinds, only: wp
   use nutate_noise, only: noise_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: projected_stepper_t

   !> A stepper and the projection of its states. The estimate of the error is that of the stepper: the projection moves
   !> the state by no more than the error, and mostly takes some of it away. `step` allocates nothing.
   type, extends(stepper_t) :: projected_stepper_t
      private
      class(stepper_t), allocatable :: base
      type(invariant_projection_t) :: projection
   contains
      !> Takes the stepper whose states to project; must come before `prepare`.
      procedure :: wrap
      procedure :: disturb
      procedure :: set_up
      procedure :: advance
      procedure :: keep_steps
      procedure :: mark_step
      procedure :: state_at
      procedure :: forget_steps
      procedure :: transfer
   end type projected_stepper_t

contains

   !> Takes the stepper whose states to project.
   subroutine wrap(self, base)
      class(projected_stepper_t), intent(inout) :: self
      !> Moved: not allocated afterwards.
      class(stepper_t), allocatable, intent(inout) :: base
      call move_alloc(base, self%base)
   end subroutine wrap

   !> Takes the noise of a pilot run, for the states before their projection.
   subroutine disturb(self, noise)
      class(projected_stepper_t), intent(inout) :: self
      type(noise_t), intent(in) :: noise
      call self%projection%disturb(noise)
   end subroutine disturb

   !> Errors: those of the stepper's `prepare`; `NUTATE_BAD_ARGUMENT` where there is none.
   subroutine set_up(self, system, settings, status)
      class(projected_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (.not. allocated(self%base)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a projection onto the invariants needs a stepper')
         return
      end if
      call self%base%prepare(system, settings, status)
      if (.not. status%ok()) return
      call self%projection%prepare(system, settings%attitude)
   end subroutine set_up

   !> One step and its projection. Errors, with the state as it was: those of the stepper and of the projection.
   subroutine advance(self, system, state, dt, window_time, status)
      class(projected_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: work, t, q_compensation(4), p_compensation(4)
      integer :: i
      t = state%t
      q_compensation = state%q_compensation
      p_compensation = state%p_compensation
      call self%projection%follow(system, state)
      call self%base%advance(system, state, dt, window_time, status)
      self%iterations = self%base%iterations
      self%residual = self%base%residual
      self%continued = self%base%continued
      self%unproved = self%base%unproved
      if (status%code /= 0) return
      work = 0.0_wp
      do i = 1, size(self%work)
         self%work(i) = self%base%work(i)
         work = work + self%work(i)
      end do
      self%error_estimate = self%base%error_estimate
      call self%projection%project(system, state, work, status)
      if (status%code == 0) return
      call self%projection%restore(state)
      state%t = t
      state%q_compensation = q_compensation
      state%p_compensation = p_compensation
   end subroutine advance

   !> The starts of steps are kept where they are taken again: without the projection.
   recursive subroutine keep_steps(self)
      class(projected_stepper_t), intent(inout) :: self
      call self%base%keep_steps()
      self%keeps_steps = .true.
   end subroutine keep_steps

   !> Takes the start of a step.
   recursive subroutine mark_step(self, state, dt, window_time)
      class(projected_stepper_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      call self%base%mark_step(state, dt, window_time)
   end subroutine mark_step

   !> The state at a time inside the last step, projected. Errors: those of the stepper and of the projection.
   recursive subroutine state_at(self, system, t, state, work, status)
      class(projected_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      real(wp), intent(out) :: work
      type(status_t), intent(out) :: status
      type(state_t) :: inside
      call self%base%state_at(system, t, inside, work, status)
      if (status%ok()) call self%projection%project_inside(system, inside, work, status)
      if (status%ok()) state = inside
   end subroutine state_at

   !> So does the stepper.
   recursive subroutine forget_steps(self)
      class(projected_stepper_t), intent(inout) :: self
      call self%base%forget_steps()
   end subroutine forget_steps

   !> What the stepper and the projection remember.
   subroutine transfer(self, archive)
      class(projected_stepper_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call self%base%transfer(archive)
      call self%projection%transfer(archive)
   end subroutine transfer

end module nutate_projected_stepper
