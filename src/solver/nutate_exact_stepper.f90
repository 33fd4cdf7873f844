!> `method = 'exact'`: a free body by its closed solution, at whatever times are asked for.
module nutate_exact_stepper
   use nutate_exact_free, only: free_body_t
   use nutate_hamiltonian, only: body_momentum
   use nutate_kinds, only: wp
   use nutate_quaternion, only: quat_product
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t, stepper_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: exact_t

   !> A stepper without an error: every step goes back to the state it started from.
   type, extends(stepper_t) :: exact_t
      private
      type(free_body_t) :: solution
      !> The solution's start, s, and the state that the last step left: one that differs starts a new solution.
      real(wp) :: t_first = 0.0_wp
      type(state_t) :: last
      logical :: started = .false.
   contains
      procedure :: prepare
      procedure :: step
   end type exact_t

contains

   !> Errors: `NUTATE_BAD_ARGUMENT` where there is an effect: only a free body is solved in closed form.
   subroutine prepare(self, system, settings, status)
      class(exact_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(integrator_settings_t), intent(in) :: settings
      type(status_t), intent(out) :: status
      associate (effects => system%effects)
         if (effects%n_potentials + effects%n_torques + effects%n_rotors > 0) &
            status = fail(NUTATE_BAD_ARGUMENT, "method 'exact' solves free bodies only (expected no effects)", 'method')
      end associate
      if (.not. settings%projection) &
         status = fail(NUTATE_BAD_ARGUMENT, 'the exact solution has no projection', 'projection')
      self%started = .false.
      if (allocated(self%work)) deallocate (self%work)
      allocate (self%work(0))
   end subroutine prepare

   !> One step. Errors: `NUTATE_BAD_ARGUMENT`, `NUTATE_BAD_BODY` for a state or body that has no solution.
   subroutine step(self, system, state, dt, status)
      class(exact_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(inout) :: state
      real(wp), intent(in) :: dt
      type(status_t), intent(out) :: status
      real(wp) :: momentum(3)

      if (.not. self%started .or. any(abs(state%q - self%last%q) > 0.0_wp) .or. &
          any(abs(state%p - self%last%p) > 0.0_wp)) then
         call self%solution%prepare(system%body%moments, state%q, body_momentum(state), status, system%body%axes)
         if (.not. status%ok()) return
         self%t_first = state%t
         self%started = .true.
      end if
      state%t = state%t + dt
      call self%solution%evaluate(state%t - self%t_first, state%q, momentum)
      state%p = 2*quat_product(state%q, [0.0_wp, momentum])
      state%q_carry = 0.0_wp
      state%p_carry = 0.0_wp
      self%last = state
   end subroutine step

end module nutate_exact_stepper
