!> C interface: single steps, and states inside the last one. The functions are documented in
!> `include/nutate_stepper.h`.
module nutate_c_stepping
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_int64_t, c_ptr
   use nutate_c_effects, only: has_callbacks, status_of_failure
   use nutate_c_stepper_handle, only: conclude, found, null_argument, stepper_handle_t, unprepare, STEPPER_MARK
   use nutate_c_polls, only: steps_between_polls
   use nutate_c_settings, only: prepare_if_needed
   use nutate_control, only: needs_control
   use nutate_failure_causes, only: add_jump
   use nutate_hamiltonian, only: angular_velocity
   use nutate_kinds, only: wp
   use nutate_progress, only: count_works
   use nutate_summary, only: run_summary_t
   use nutate_range, only: check_step
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NOT_CONVERGED, NUTATE_OK
   use nutate_varying_inertia, only: check_change
   implicit none
   private

   public :: nutate_stepper_step, nutate_stepper_steps
   public :: nutate_stepper_keep_steps, nutate_stepper_state_at
   public :: test_step

contains

   integer(c_int) function nutate_stepper_step(stepper, dt) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(in), value :: dt
      type(stepper_handle_t), pointer :: handle
      code = NUTATE_BAD_HANDLE
      if (.not. c_associated(stepper)) return
      call c_f_pointer(stepper, handle)
      if (handle%mark /= STEPPER_MARK) return
      if (handle%plain .and. dt == handle%tested_dt) then
         call handle%run%stepper%step(handle%system, handle%run%state, dt, handle%status)
         if (handle%works .and. handle%status%code == NUTATE_OK) &
            call count_works(handle%run%progress_t, handle%run%stepper)
      else
         call step_with_care(handle, dt, handle%status)
      end if
      code = handle%status%code
      if (code /= NUTATE_OK) return
      if (handle%run%stepper%uncertified > 0) call count_uncertified(handle%run%summary)
   end function nutate_stepper_step

   integer(c_int) function nutate_stepper_steps(stepper, dt, n, done) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(in), value :: dt
      integer(c_int64_t), intent(in), value :: n
      integer(c_int64_t), intent(inout), optional :: done
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: success
      integer(c_int64_t) :: i
      if (present(done)) done = 0
      if (.not. found(stepper, handle, code)) return
      if (n < 0) then
         code = conclude(handle, fail(NUTATE_BAD_ARGUMENT, 'the number of steps is negative', 'n'))
         return
      end if
      code = conclude(handle, success)
      do i = 1, n
         if (handle%plain .and. dt == handle%tested_dt) then
            call handle%run%stepper%step(handle%system, handle%run%state, dt, handle%status)
            if (handle%works .and. handle%status%code == NUTATE_OK) &
               call count_works(handle%run%progress_t, handle%run%stepper)
         else
            call step_with_care(handle, dt, handle%status)
         end if
         code = handle%status%code
         if (code /= NUTATE_OK) return
         if (handle%run%stepper%uncertified > 0) call count_uncertified(handle%run%summary)
         if (present(done)) done = i
         if (mod(i, steps_between_polls) == 0 .or. .not. handle%plain) then
            call handle%poll%ask(handle%status)
            code = handle%status%code
            if (code /= NUTATE_OK) return
         end if
      end do
   end function nutate_stepper_steps

   !> Performs a step that needs more than the method's step: a preparation, a test of its length, callbacks, or angles.
   subroutine step_with_care(handle, dt, status)
      type(stepper_handle_t), intent(inout) :: handle
      real(wp), intent(in) :: dt
      type(status_t), intent(out) :: status
      type(state_t) :: before
      handle%plain = .false.
      call prepare_if_needed(handle, status)
      if (status%ok() .and. needs_control(handle%system%effects)) status = fail( &
         NUTATE_BAD_ARGUMENT, 'a wheel has a speed_limit, or a controller a sample or limits, which only runs '// &
                                             'support (expected nutate_stepper_run or nutate_stepper_run_to)')
      if (status%ok()) call test_step(handle, dt, status)
      if (status%ok()) call check_change(handle%system, handle%run%state%t, handle%run%state%t + dt, status)
      if (.not. status%ok()) return
      call handle%run%release()
      if (allocated(handle%run%events)) deallocate (handle%run%events)
      before = handle%run%state
      handle%failure = 0
      call handle%run%stepper%step(handle%system, handle%run%state, dt, status)
      if (handle%failure(1) /= 0) then
         handle%run%state = before
         call unprepare(handle)
         status = status_of_failure(handle%failure)
      else if (status%code == 0) then
         call count_works(handle%run%progress_t, handle%run%stepper)
         if (handle%columns%follows_steps) call handle%columns%follow(handle%run%state)
         handle%works = size(handle%run%stepper%work) > 0
         handle%plain = .not. (has_callbacks(handle%system%effects) .or. handle%columns%follows_steps .or. &
                               handle%system%effects%varies)
      else if (status%code == NUTATE_NOT_CONVERGED) then
         call add_jump(handle%system, status)
      end if
   end subroutine step_with_care

   pure subroutine count_uncertified(summary)
      type(run_summary_t), intent(inout) :: summary
      summary%uncertified_steps = summary%uncertified_steps + 1
   end subroutine count_uncertified

   !> Tests the length of a step. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine test_step(handle, dt, status)
      type(stepper_handle_t), intent(inout) :: handle
      real(wp), intent(in) :: dt
      type(status_t), intent(inout) :: status
      if (dt == handle%tested_dt .and. abs(dt) > 0.0_wp) return
      call check_step(handle%system, handle%run%state, dt, status)
      if (status%ok()) handle%tested_dt = dt
   end subroutine test_step

   integer(c_int) function nutate_stepper_keep_steps(stepper) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      handle%run%keeps_dense_output = .true.
      call prepare_if_needed(handle, status)
      if (status%ok()) call handle%run%stepper%keep_steps()
      code = conclude(handle, status)
   end function nutate_stepper_keep_steps

   integer(c_int) function nutate_stepper_state_at(stepper, t, q, omega) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(in), value :: t
      real(c_double), intent(inout), optional :: q(4), omega(3)
      type(stepper_handle_t), pointer :: handle
      type(state_t) :: state
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      if (.not. (present(q) .and. present(omega))) then
         code = conclude(handle, null_argument('q or omega'))
         return
      end if
      ! Values held in the last step may differ from those held now.
      if (needs_control(handle%system%effects)) status = fail( &
         NUTATE_BAD_ARGUMENT, 'a wheel has a speed_limit, or a controller a sample or limits (expected rows of a '// &
                                             'run at user-defined times)', 't')
      if (status%ok()) then
         handle%failure = 0
         call handle%run%state_at(handle%system, t, state, status)
         if (handle%failure(1) /= 0) status = status_of_failure(handle%failure)
      end if
      code = conclude(handle, status)
      if (.not. status%ok()) return
      q = state%q
      omega = angular_velocity(handle%system, state)
   end function nutate_stepper_state_at

end module nutate_c_stepping
