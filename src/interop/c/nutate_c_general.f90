!> C interface: version, statuses, messages, and the exact solution of a free body. The functions are documented in
!> `include/nutate.h`.
module nutate_c_general
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_ptr, c_size_t
   use nutate_c_handles, only: found, handle_t, system_handle_t, whole_message
   use nutate_c_text, only: text_to_c
   use nutate_exact_free, only: free_body_t
   use nutate_hamiltonian, only: make_state
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_quaternion, only: quat_normalized
   use nutate_range, only: check_motion
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_OK
   use nutate_version, only: version
   implicit none
   private

   public :: nutate_get_version, nutate_status_text, nutate_last_message, nutate_exact_free_body

   !> Meanings of the status codes, from 0.
   character(len=*), parameter :: meanings(0:14) = [character(len=64) :: &
      'success', &
      'the iteration of a step did not converge', &
      'the step is too long to follow the motion', &
      'the linear system of a step is singular', &
      'a number is not finite or exceeds 1e100', &
      'an argument is out of its range', &
      'the inertia is not that of a rigid body', &
      'a scene cannot be understood or simulated', &
      'a file cannot be read or written', &
      'the run needs more steps than allowed', &
      'not a handle of this kind: NULL, another kind, or destroyed', &
      'a callback reported a failure', &
      'a string did not fit into its buffer and was cut', &
      'memory ran out', &
      'the run was asked to stop']

contains

   integer(c_int) function nutate_get_version(buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: buffer
      integer(c_size_t), intent(in), value :: size
      code = text_to_c(version, buffer, size)
   end function nutate_get_version

   integer(c_int) function nutate_status_text(status, buffer, size) result(code) bind(C)
      integer(c_int), intent(in), value :: status
      type(c_ptr), intent(in), value :: buffer
      integer(c_size_t), intent(in), value :: size
      if (status >= lbound(meanings, 1) .and. status <= ubound(meanings, 1)) then
         code = text_to_c(trim(meanings(status)), buffer, size)
      else
         code = text_to_c('unknown status code', buffer, size)
      end if
   end function nutate_status_text

   integer(c_int) function nutate_last_message(handle, buffer, size) result(code) bind(C)
      type(c_ptr), intent(in), value :: handle, buffer
      integer(c_size_t), intent(in), value :: size
      type(handle_t), pointer :: last
      if (found(handle, last, code)) code = text_to_c(whole_message(last%status, last%text), buffer, size)
   end function nutate_last_message

   integer(c_int) function nutate_exact_free_body(system, q0, omega0, n, t, q, omega) result(code) bind(C)
      type(c_ptr), intent(in), value :: system
      real(c_double), intent(in), optional :: q0(4), omega0(3), t(*)
      integer(c_size_t), intent(in), value :: n
      real(c_double), intent(inout), optional :: q(4, *), omega(3, *)
      type(system_handle_t), pointer :: handle
      type(free_body_t) :: motion
      type(status_t) :: status
      real(wp) :: attitude(4), momentum(3)
      integer(c_size_t) :: i
      if (.not. found(system, handle, code)) return
      code = NUTATE_BAD_ARGUMENT
      if (.not. (present(q0) .and. present(omega0)) .or. n < 0) return
      if (n > 0 .and. .not. present(t)) return
      if (.not. (all(is_moderate(q0)) .and. all(is_moderate(omega0)))) return
      associate (body => handle%system%body, effects => handle%system%effects)
         if (effects%n_potentials + effects%n_off + effects%n_torques + effects%n_rotors > 0) return
         if (effects%frame_turns) return
         call check_motion(handle%system, make_state(handle%system, quat_normalized(q0), omega0), status)
         code = status%code
         if (code /= NUTATE_OK) return
         call motion%prepare(body%moments, q0, matmul(body%inertia, omega0), status, body%axes)
         code = status%code
         if (code /= NUTATE_OK) return
         do i = 1, n
            if (.not. is_moderate(t(i))) then
               code = NUTATE_BAD_ARGUMENT
               return
            end if
            call motion%evaluate(t(i), attitude, momentum)
            if (present(q)) q(:, i) = attitude
            if (present(omega)) omega(:, i) = matmul(body%inverse_inertia, momentum)
         end do
      end associate
   end function nutate_exact_free_body

end module nutate_c_general
