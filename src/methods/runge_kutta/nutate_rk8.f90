!> The explicit Runge-Kutta method of order 8 of Dormand and Prince at fixed steps: the stages and weights of DOP853,
!> without its estimates.
!>
!> Free bodies and bodies in uniform fields are integrated in special variables (`nutate_specialised_motion`), all
!> others by the evaluation that DOP853 uses. `prepare` decides once between the two.
module nutate_rk8
   use nutate_archive, only: archive_t
   use nutate_dop853, only: estimate_of_fifth, get_stages
   use nutate_free_tangent, only: free_tangent_t
   use nutate_kinds, only: wp
   use nutate_specialised_motion, only: specialised_motion_t
   use nutate_order_eight, only: a, b, c, e5, n_stages
   use nutate_rigid_rates, only: begin_step, end_step, end_wheels, get_error, n_rates, prepare_rates, read_state, &
      rigid_rates_t
   use nutate_stage_tangent, only: stage_tangent_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_OFF_BRANCH
   use nutate_stepper, only: integrator_settings_t, stepper_t, system_t
   use nutate_tangent, only: tangent_t
   use nutate_step_error, only: step_error_t
   implicit none
   private

   public :: rk8_t

   !> One step of the method. `step` allocates nothing.
   type, extends(stepper_t) :: rk8_t
      private
      type(rigid_rates_t) :: rates
      type(specialised_motion_t) :: specialised
      !> Tangent of the stages, made by the first `propagate_step` that needs it.
      type(stage_tangent_t), allocatable :: tangent
      type(free_tangent_t), allocatable :: free
   contains
      procedure :: set_up
      procedure :: advance
      procedure :: propagate_step
      procedure :: transfer
   end type rk8_t

contains

   !> Uses only the settings `attitude` and `conserve`. Reports no errors of its own.
   subroutine set_up(self, system, settings, status)
      class(rk8_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (self%keeps_system) return
      call prepare_rates(self%rates, system, settings%attitude, settings%conserve, a)
      call self%specialised%prepare(system, settings%attitude)
   end subroutine set_up

   !> Performs one step. Errors, with the state unchanged: `NUTATE_OFF_BRANCH` for a step so long that its stages
   !> diverge, `NUTATE_NOT_FINITE`, `NUTATE_BAD_ARGUMENT` for a state off the constraint manifold.
   subroutine advance(self, system, state, dt, window_time, status)
      class(rk8_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: y(n_rates)
      logical :: is_specialised, moved
      call self%specialised%fits(dt, is_specialised)
      if (is_specialised) then
         call self%specialised%move(state, moved)
         if (moved) return
         call read_state(self%rates, state, dt, y)
         if (self%rates%failure == 0) self%rates%failure = NUTATE_OFF_BRANCH
      else
         call begin_step(self%rates, system, state, dt, window_time, y)
         call evaluate_stages(self%rates, system, y, self%step_error)
      end if
      call end_step(self%rates, y, state, status)
      if (status%code /= 0) return
      if (self%rates%n_wheels > 0) call end_wheels(self%rates, state)
      self%work(:) = self%rates%work
   end subroutine advance

   !> Performs a step by the general equations.
   subroutine evaluate_stages(rates, system, y, error)
      type(rigid_rates_t), intent(inout) :: rates
      type(system_t), intent(in) :: system
      real(wp), intent(inout) :: y(n_rates)
      !> Error of the step, estimated if there are works.
      type(step_error_t), intent(inout) :: error
      real(wp) :: k(n_rates, n_stages), change(n_rates)
      call get_stages(rates, system, y, k, change)
      y = y + change
      if (rates%estimates) call get_error(rates, y, estimate_of_fifth(k), e5, error)
   end subroutine evaluate_stages

   !> Moves sensitivities over a step, by the same stages.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(rk8_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      logical :: is_specialised, propagated
      call self%specialised%fits(dt, is_specialised)
      if (is_specialised .and. self%specialised%free) then
         if (.not. allocated(self%free)) allocate (self%free)
         call self%free%propagate(system, before, dt, tangent, propagated)
         if (propagated) return
         is_specialised = .false.
      end if
      if (is_specialised) then
         call self%specialised%propagate(before, tangent, propagated)
         if (propagated) return
      end if
      if (.not. allocated(self%tangent)) then
         allocate (self%tangent)
         call self%tangent%set(a, b, c)
      end if
      if (is_specialised) then
         call self%tangent%propagate(self%rates, system, before, dt, window_time, tangent, &
                                 homogeneous=.true., axis=self%specialised%spin_axis())
      else
         call self%tangent%propagate(self%rates, system, before, dt, window_time, tangent)
      end if
   end subroutine propagate_step

   !> Writes and reads nothing: a step does not depend on the ones before.
   subroutine transfer(self, archive)
      class(rk8_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
   end subroutine transfer

end module nutate_rk8
