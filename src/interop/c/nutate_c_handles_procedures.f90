!> Bodies of the procedures whose interfaces are in `nutate_c_handles`.
submodule(nutate_c_handles) nutate_c_handles_procedures
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_null_ptr
   use nutate_c_effects, only: report_failures_to
   use nutate_c_text, only: message_to_c
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NO_MEMORY, NUTATE_OK
   implicit none

contains

   module procedure has_mark
      type(handle_t), pointer :: handle
      if (present(code)) code = NUTATE_BAD_HANDLE
      has_mark = c_associated(address)
      if (.not. has_mark) return
      call c_f_pointer(address, handle)
      has_mark = any(handle%mark == marks)
   end procedure has_mark

   module procedure found_system
      is_found = has_mark(address, [SYSTEM_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end procedure found_system

   module procedure found_history
      is_found = has_mark(address, [HISTORY_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end procedure found_history

   module procedure found_bodies
      is_found = has_mark(address, [BODIES_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end procedure found_bodies

   module procedure found_any
      is_found = has_mark(address, [SYSTEM_MARK, SCENE_MARK, STEPPER_MARK, HISTORY_MARK, BODIES_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end procedure found_any

   module procedure is_taken
      type(c_ptr), pointer :: slot
      type(handle_t), pointer :: any_handle
      is_taken = .false.
      handle = c_null_ptr
      code = NUTATE_BAD_ARGUMENT
      if (.not. c_associated(address)) return
      call c_f_pointer(address, slot)
      code = NUTATE_OK
      if (.not. c_associated(slot)) return
      is_taken = has_mark(slot, [mark], code)
      if (.not. is_taken) return
      call c_f_pointer(slot, any_handle)
      call erase_mark(any_handle%mark)
      handle = slot
      slot = c_null_ptr
      code = NUTATE_OK
   end procedure is_taken

   module procedure open_slot
      slot => null()
      if (.not. c_associated(address)) return
      call c_f_pointer(address, slot)
      slot = c_null_ptr
   end procedure open_slot

   !> Clears the mark of a handle that is about to be freed; volatile, so that the compiler does not omit the write.
   subroutine erase_mark(mark)
      integer(c_int64_t), intent(inout), volatile :: mark
      mark = 0
   end subroutine erase_mark

   module procedure copy_system
      to%body = from%body
      call to%effects%append(from%effects)
      call report_failures_to(to%effects, cell)
   end procedure copy_system

   module procedure make_room
      real(wp), allocatable :: grown(:, :)
      integer(c_size_t), parameter :: first_room = 1024
      integer :: failed
      if (.not. allocated(history%values)) allocate (history%values(history%width, 0))
      if (history%rows < size(history%values, 2, c_size_t)) return
      allocate (grown(history%width, max(first_room, 2*history%rows)), stat=failed)
      if (failed /= 0) then
         status = fail(NUTATE_NO_MEMORY, 'not enough memory for so many rows')
         return
      end if
      grown(:, 1:history%rows) = history%values
      call move_alloc(grown, history%values)
   end procedure make_room

   module procedure null_argument
      status = fail(NUTATE_BAD_ARGUMENT, 'the argument '//name//' is NULL', name)
   end procedure null_argument

   module procedure conclude
      handle%status = status
      code = status%code
   end procedure conclude

   module procedure report
      if (present(whole)) then
         call message_to_c(whole_message(status, whole), buffer, size)
      else
         call message_to_c(status%message, buffer, size)
      end if
      code = status%code
   end procedure report

   module procedure whole_message
      type(status_t) :: short
      message = trim(status%message)
      if (status%ok() .or. .not. allocated(whole)) return
      short = fail(status%code, whole)
      if (short%message == status%message) message = whole
   end procedure whole_message

end submodule nutate_c_handles_procedures
