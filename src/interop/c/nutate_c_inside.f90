!> C interface: states inside the last step. What each function does stands in `include/nutate_stepper.h`.
module nutate_c_inside
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_ptr
   use nutate_c_effects, only: judge_failure
   use nutate_c_handles, only: conclude, find_stepper, null_argument, stepper_handle_t
   use nutate_c_settings, only: prepare_if_needed
   use nutate_control, only: needs_control
   use nutate_hamiltonian, only: angular_velocity
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE
   implicit none
   private

   public :: nutate_stepper_keep_steps, nutate_stepper_state_at

contains

   integer(c_int) function nutate_stepper_keep_steps(stepper) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      code = NUTATE_BAD_HANDLE
      handle => find_stepper(stepper)
      if (.not. associated(handle)) return
      handle%run%is_looked_into = .true.
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
      code = NUTATE_BAD_HANDLE
      handle => find_stepper(stepper)
      if (.not. associated(handle)) return
      if (.not. (present(q) .and. present(omega))) then
         code = conclude(handle, null_argument('q or omega'))
         return
      end if
      ! What was held in the last step may not be what is held now.
      if (needs_control(handle%system%effects)) status = fail( &
         NUTATE_BAD_ARGUMENT, 'a wheel has a speed_limit, or a regulator a sample or limits (expected rows of a '// &
                                             'run at times of your own)', 't')
      if (status%ok()) then
         handle%failure = 0
         call handle%run%look(handle%system, t, state, status)
         if (handle%failure(1) /= 0) status = judge_failure(handle%failure)
      end if
      code = conclude(handle, status)
      if (.not. status%ok()) return
      q = state%q
      omega = angular_velocity(handle%system, state)
   end function nutate_stepper_state_at

end module nutate_c_inside
