!> The classical Runge-Kutta method of order 4 with the attitude normalised after every step: a baseline. It conserves
!> nothing but |q| = 1.
module nutate_rk4
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   use nutate_rigid_rates, only: begin_step, end_step, end_wheels, get_error, get_rates, n_rates, prepare_rates, &
      rigid_rates_t
   use nutate_stage_tangent, only: stage_tangent_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t, system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: rk4_t

   !> Weights of the outer and the inner stages.
   real(wp), parameter :: outer = 1.0_wp/6, inner = 1.0_wp/3
   !> aᵢⱼ as a(j, i - 1), i from the second stage on; shape (3,3).
   real(wp), parameter :: a(3, 3) = reshape([0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], &
                                            [3, 3])

   !> Kutta's method (1901). `step` allocates nothing.
   type, extends(stepper_t) :: rk4_t
      private
      type(rigid_rates_t) :: rates
      !> Tangent of the stages, made by the first `propagate_step`.
      type(stage_tangent_t), allocatable :: tangent
   contains
      procedure :: set_up
      procedure :: advance
      procedure :: propagate_step
      procedure :: transfer
   end type rk4_t

contains

   !> Uses only the settings `attitude` and `conserve`. Reports no errors of its own.
   subroutine set_up(self, system, settings, status)
      class(rk4_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (self%keeps_system) return
      call prepare_rates(self%rates, system, settings%attitude, settings%conserve, a)
   end subroutine set_up

   !> Performs one step. Errors, with the state unchanged: `NUTATE_OFF_BRANCH` for a step so long that its stages
   !> diverge, `NUTATE_NOT_FINITE`, `NUTATE_BAD_ARGUMENT` for a state off the constraint manifold.
   subroutine advance(self, system, state, dt, window_time, status)
      class(rk4_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp), dimension(n_rates) :: y, k1, k2, k3, k4
      call begin_step(self%rates, system, state, dt, window_time, y)
      call get_rates(self%rates, system, 0.0_wp, y, outer, k1)
      call get_rates(self%rates, system, 0.5_wp, y + 0.5_wp*k1, inner, k2)
      call get_rates(self%rates, system, 0.5_wp, y + 0.5_wp*k2, inner, k3)
      call get_rates(self%rates, system, 1.0_wp, y + k3, outer, k4)
      y = y + (outer*(k1 + k4) + inner*(k2 + k3))
      call end_step(self%rates, y, state, status)
      if (status%code /= 0) return
      if (self%rates%n_wheels > 0) call end_wheels(self%rates, state)
      self%work(:) = self%rates%work
      ! The estimate is the difference from the mean of both midpoints, which is of order 2.
      if (self%rates%estimates) &
         call get_error(self%rates, y, outer*(k1 - k2 - k3 + k4), outer*[1, -1, -1, 1], self%step_error)
   end subroutine advance

   !> Moves sensitivities over a step, by the same stages.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(rk4_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      if (.not. allocated(self%tangent)) then
         allocate (self%tangent)
         call self%tangent%set(a, [outer, inner, inner, outer], [0.0_wp, 0.5_wp, 0.5_wp, 1.0_wp])
      end if
      call self%tangent%propagate(self%rates, system, before, dt, window_time, tangent)
   end subroutine propagate_step

   !> Writes and reads nothing: a step does not depend on the ones before.
   subroutine transfer(self, archive)
      class(rk4_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
   end subroutine transfer

end module nutate_rk4
