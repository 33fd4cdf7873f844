!> `method = 'exact'`: a free body by its closed solution, at whatever times are asked for.
module nutate_exact_stepper
   use nutate_archive, only: archive_t
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
      !> The solution's start, and the state that the last step left: one that differs starts a new solution.
      type(state_t) :: first, last
      logical :: started = .false.
      !> The solution is that from `first`.
      logical :: solved = .false.
   contains
      procedure :: prepare
      procedure :: step
      procedure :: transfer_memory
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
      self%solved = .false.
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
         self%first = state
         self%started = .true.
         self%solved = .false.
      end if
      if (.not. self%solved) then
         call self%solution%prepare(system%body%moments, self%first%q, body_momentum(self%first), status, &
                                    system%body%axes)
         self%solved = status%ok()
         self%started = self%solved
         if (.not. self%solved) return
      end if
      state%t = state%t + dt
      call self%solution%evaluate(state%t - self%first%t, state%q, momentum)
      state%p = 2*quat_product(state%q, [0.0_wp, momentum])
      state%q_carry = 0.0_wp
      state%p_carry = 0.0_wp
      self%last = state
   end subroutine step

   !> Where the solution started and where the last step ended; the solution is found again from its start.
   subroutine transfer_memory(self, archive)
      class(exact_t), intent(inout) :: self
      type(archive_t), intent(inout) :: archive
      call self%first%transfer(archive)
      call self%last%transfer(archive)
      call archive%transfer(self%started)
      if (archive%is_reading()) self%solved = .false.
   end subroutine transfer_memory

end module nutate_exact_stepper
