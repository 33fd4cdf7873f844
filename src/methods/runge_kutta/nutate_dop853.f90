!> The explicit Runge-Kutta method of order 8 of Dormand and Prince with estimates of orders 5 and 3, and the attitude
!> normalised after every step: a baseline.
module nutate_dop853
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   use nutate_order_eight, only: a, b, b3, c, e5, n_stages
   use nutate_rigid_rates, only: begin_step, end_step, end_wheels, get_error, get_rates, n_rates, prepare_rates, &
      rigid_rates_t
   use nutate_stage_tangent, only: stage_tangent_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_stepper, only: integrator_settings_t, stepper_t, system_t
   use nutate_tangent, only: tangent_t
   implicit none
   private

   public :: dop853_t, estimate_of_fifth, get_stages

   !> One step of the method. `step` allocates nothing.
   type, extends(stepper_t) :: dop853_t
      type(rigid_rates_t), private :: rates
      !> Tangent of the stages, made by the first `propagate_step`.
      type(stage_tangent_t), allocatable, private :: tangent
   contains
      procedure :: set_up
      procedure :: advance
      procedure :: propagate_step
      procedure :: transfer
   end type dop853_t

contains

   !> Uses only the settings `attitude` and `conserve`. Reports no errors of its own.
   subroutine set_up(self, system, settings, status)
      class(dop853_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(inout) :: status
      if (self%keeps_system) return
      call prepare_rates(self%rates, system, settings%attitude, settings%conserve, a)
   end subroutine set_up

   !> Performs one step. Errors, with the state unchanged: `NUTATE_OFF_BRANCH` for a step so long that its stages
   !> diverge, `NUTATE_NOT_FINITE`, `NUTATE_BAD_ARGUMENT` for a state off the constraint manifold.
   subroutine advance(self, system, state, dt, window_time, status)
      class(dop853_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt, window_time
      type(status_t), intent(inout) :: status
      real(wp) :: y(n_rates), change(n_rates), last(n_rates), fifth(n_rates), k(n_rates, n_stages)
      call begin_step(self%rates, system, state, dt, window_time, y)
      call get_stages(self%rates, system, y, k, change)
      last = y + change
      call end_step(self%rates, last, state, status)
      if (status%code /= 0) return
      if (self%rates%n_wheels > 0) call end_wheels(self%rates, state)
      self%work(:) = self%rates%work
      fifth = estimate_of_fifth(k)
      self%error_estimate = estimate(k, change, fifth, y)
      if (self%rates%estimates) call get_error(self%rates, last, fifth, e5, self%step_error)
   end subroutine advance

   !> Computes k = Δt ẏ of all stages, shape (n_rates, 12), and the increment of the step.
   subroutine get_stages(rates, system, y, k, change)
      type(rigid_rates_t), intent(inout) :: rates
      type(system_t), intent(in) :: system
      real(wp), intent(in) :: y(n_rates)
      real(wp), intent(out) :: k(n_rates, n_stages)
      !> Shape (n_rates).
      real(wp), intent(out) :: change(n_rates)
      real(wp) :: sum(n_rates), x(n_rates, n_stages + 1)
      integer :: i
      x(:, 1) = y
      i = 0
      include 'order_eight_stages.inc'
      change = x(:, n_stages + 1)
   contains
      subroutine evaluate_stage(rates, y, sum, factor, rate, next)
         type(rigid_rates_t), intent(inout) :: rates
         real(wp), intent(in) :: y(n_rates), sum(n_rates), factor
         real(wp), intent(out) :: rate(n_rates), next(n_rates)
         i = i + 1
         call get_rates(rates, system, c(i), y, b(i), rate)
         next = sum + factor*rate
      end subroutine evaluate_stage
   end subroutine get_stages

   !> Returns the difference from the method of order 5; shape (n_rates).
   pure function estimate_of_fifth(k) result(fifth)
      !> Shape (n_rates, 12).
      real(wp), intent(in) :: k(n_rates, n_stages)
      real(wp) :: fifth(n_rates)
      fifth = e5(1)*k(:, 1) + e5(6)*k(:, 6) + e5(7)*k(:, 7) + e5(8)*k(:, 8) + e5(9)*k(:, 9) + e5(10)*k(:, 10) &
              + e5(11)*k(:, 11) + e5(12)*k(:, 12)
   end function estimate_of_fifth

   !> Returns the estimate |e5|²/√(|e5|² + |e3|²/100) of the error.
   pure real(wp) function estimate(k, change, fifth, y)
      !> Rates of the stages and the step's increment; shapes (n_rates, 12) and (n_rates).
      real(wp), intent(in) :: k(n_rates, n_stages), change(n_rates)
      !> Difference from the method of order 5; shape (n_rates).
      real(wp), intent(in) :: fifth(n_rates)
      !> Start of the step; shape (n_rates).
      real(wp), intent(in) :: y(n_rates)
      real(wp) :: third(n_rates), last(3), scale, square5, square3
      third = change - (b3(1)*k(:, 1) + b3(2)*k(:, 9) + b3(3)*k(:, 12))
      last = y(5:7) + change(5:7)
      ! The error of a body that starts from rest is relative to the momentum that it gains.
      scale = max(y(5)*y(5) + y(6)*y(6) + y(7)*y(7), last(1)*last(1) + last(2)*last(2) + last(3)*last(3))
      if (scale > tiny(1.0_wp)) scale = 1/scale
      square5 = weighted_square(fifth, scale)
      square3 = square5 + 0.01_wp*weighted_square(third, scale)
      estimate = 0.0_wp
      if (square3 > 0.0_wp) estimate = square5/sqrt(square3)
   end function estimate

   !> Returns |2δq|² + |δL|²/|L|².
   pure real(wp) function weighted_square(error, scale)
      real(wp), intent(in) :: error(n_rates)
      !> 1/|L|².
      real(wp), intent(in) :: scale
      weighted_square = 4*(error(1)**2 + error(2)**2 + error(3)**2 + error(4)**2) &
                        + scale*(error(5)**2 + error(6)**2 + error(7)**2)
   end function weighted_square

   !> Moves sensitivities over a step, by the same stages.
   recursive subroutine propagate_step(self, system, before, after, dt, window_time, tangent, status)
      class(dop853_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: before, after
      real(wp), intent(in) :: dt, window_time
      type(tangent_t), intent(inout) :: tangent
      type(status_t), intent(inout) :: status
      real(wp) :: third(n_stages)
      if (.not. allocated(self%tangent)) then
         allocate (self%tangent)
         third = b
         third([1, 9, 12]) = third([1, 9, 12]) - b3
         call self%tangent%set(a, b, c, reshape([e5, 0.1_wp*third], [n_stages, 2]))
      end if
      call self%tangent%propagate(self%rates, system, before, dt, window_time, tangent)
   end subroutine propagate_step

   !> Writes and reads nothing: a step does not depend on the ones before.
   subroutine transfer(self, archive)
      class(dop853_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
   end subroutine transfer

end module nutate_dop853
