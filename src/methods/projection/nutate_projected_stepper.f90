!> A stepper of any method with the projection onto the invariants after its steps.
module nutate_projected_stepper
   use nutate_archive, only: archive_t
   use nutate_sensitivity_projection, only: project_sensitivities
   use nutate_kinds, only: wp
   use nutate_noise, only: noise_t
   use nutate_spaced_projection, only: spaced_projection_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_stepper_wrapper, only: stepper_wrapper_t
   use nutate_system, only: system_t
   use nutate_tangent, only: tangent_t
   use nutate_error_weighting, only: book_share
   implicit none
   private

   public :: projected_stepper_t

   !> A stepper and the projection of its states. The estimate of the error is that of the stepper: the projection moves
   !> the state by no more than the error, and mostly reduces it. `step` allocates nothing.
   type, extends(stepper_wrapper_t) :: projected_stepper_t
      private
      type(spaced_projection_t) :: projection
      !> Steps from one projection to the next, without torques and while errors are small, unless every step is
      !> projected.
      integer, public :: spacing = 1
      !> Number of momenta of wheels and inner spheres.
      integer :: n_wheels = 0
      !> The state before the step under way.
      type(state_t) :: kept = state_t()
   contains
      procedure :: disturb
      procedure :: set_up
      procedure :: advance
      procedure :: project_for_output
      procedure :: mark_step
      procedure :: state_at
      procedure :: propagate_step
      procedure :: propagate_inside
      procedure :: transfer
   end type projected_stepper_t

contains

   !> Adds the noise of a trial run, for the states before their projection.
   subroutine disturb(self, noise)
      class(projected_stepper_t), intent(inout) :: self
      type(noise_t), intent(in) :: noise
      call self%projection%disturb(noise)
   end subroutine disturb

   !> Prepares the stepper and the projection. Errors: those of the stepper's `prepare`; `NUTATE_BAD_ARGUMENT` if there
   !> is none.
   subroutine set_up(self, system, settings, status)
      class(projected_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      call self%check_base('a projection onto the invariants', status)
      if (.not. status%ok()) return
      self%base%keeps_system = self%keeps_system
      call self%base%prepare(system, settings, status)
      if (.not. status%ok()) return
      self%n_wheels = system%effects%n_wheels
      call self%projection%prepare(system, settings%attitude, merge(1, self%spacing, settings%project_each))
   end subroutine set_up

   !> Performs one step and, if it is due, its projection. Errors, with the state unchanged: those of the stepper and of
   !> the projection.
   subroutine advance(self, system, state, dt, window_time, status)
      class(projected_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: work, done, given
      integer :: i
      call self%kept%copy_from(state, self%n_wheels, .true.)
      call self%projection%begin_step(system, state)
      call self%base%advance(system, state, dt, window_time, status)
      call self%copy_counts()
      if (status%code == 0) then
         call self%copy_work()
         work = 0.0_wp
         done = 0.0_wp
         do i = 1, size(self%work)
            work = work + self%work(i)
            done = done + abs(self%work(i))
         end do
         if (done > 0.0_wp) then
            given = 0.0_wp
            call self%projection%end_step(system, state, .false., work, status, self%base%step_error, given)
            if (abs(given) > 0.0_wp) call book_share(system%effects, given, done, self%work, state)
         else
            call self%projection%end_step(system, state, .false., work, status)
         end if
         self%moved_by_round_off = self%projection%moved_by_round_off()
      end if
      if (status%code /= 0) call state%copy_from(self%kept, self%n_wheels, .true.)
   end subroutine advance

   !> Projects a copy of the state that the last step left.
   subroutine project_for_output(self, system, state)
      class(projected_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      call self%projection%project_for_output(system, state)
   end subroutine project_for_output

   !> Sets the start of a step.
   recursive subroutine mark_step(self, state, dt, window_time)
      class(projected_stepper_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: dt, window_time
      self%last_start = state
      call self%projection%find_origin(self%last_start)
      call self%base%mark_step(self%last_start, dt, window_time)
   end subroutine mark_step

   !> Computes the state at a time inside the last step, projected. Errors: those of the stepper and of the projection.
   recursive subroutine state_at(self, system, t, state, work, status, works)
      class(projected_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: t
      type(state_t), intent(inout) :: state
      real(wp), intent(out) :: work
      type(status_t), intent(out) :: status
      real(wp), intent(inout), optional :: works(:)
      type(state_t) :: inside
      real(wp) :: given, done, each(size(self%work))
      call self%base%state_at(system, t, inside, work, status, each)
      given = 0.0_wp
      if (allocated(self%last_start)) then
         call self%projection%begin_step(system, self%last_start)
         inside%balance = self%last_start%balance
      end if
      if (status%ok()) call self%projection%project_inside(system, inside, work, status, self%base%step_error, given)
      done = sum(abs(each))
      if (abs(given) > 0.0_wp .and. done > 0.0_wp) call book_share(system%effects, given, done, each, inside)
      if (status%ok()) state = inside
      work = work + given
      if (present(works)) works(:) = each
   end subroutine state_at

   !> Moves sensitivities by the stepper, from the state that the step continued from, and projects them if the state
   !> was projected. Errors: those of the stepper.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(projected_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      type(state_t) :: origin
      origin = before
      call origin%restore_left()
      call self%base%propagate_step(system, origin, after, dt, window_time, tangent, status)
      if (status%code == 0 .and. after%balance%count == 0 .and. self%prepared_with%attitude) &
         call project_sensitivities(system, after, .false., tangent)
   end subroutine propagate_step

   !> Moves sensitivities to a state inside the last step, which is projected.
   recursive subroutine propagate_inside(self, system, state, tangent, status)
      class(projected_stepper_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      call self%base%propagate_inside(system, state, tangent, status)
      if (status%code == 0 .and. self%prepared_with%attitude) call project_sensitivities(system, state, .false., &
         tangent)
   end subroutine propagate_inside

   !> Writes or reads the data that the stepper and the projection keep between steps.
   subroutine transfer(self, archive)
      class(projected_stepper_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call self%base%transfer(archive)
      call self%projection%transfer(archive)
   end subroutine transfer

end module nutate_projected_stepper
