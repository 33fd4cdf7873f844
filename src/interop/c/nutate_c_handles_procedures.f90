!> Bodies of the procedures whose interfaces are in `nutate_c_handles`.
submodule(nutate_c_handles) nutate_c_handles_procedures
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_null_ptr
   use nutate_c_effects, only: report_failures_to
   use nutate_c_text, only: message_to_c
   use nutate_status, only: fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NO_MEMORY, NUTATE_OK
   implicit none

contains

   !> Returns true if an address is that of a handle of one of the kinds.
   logical function has_mark(address, marks, code)
      type(c_ptr), intent(in) :: address
      integer(c_int64_t), intent(in) :: marks(:)
      integer(c_int), intent(out), optional :: code
      type(handle_t), pointer :: handle
      if (present(code)) code = NUTATE_BAD_HANDLE
      has_mark = c_associated(address)
      if (.not. has_mark) return
      call c_f_pointer(address, handle)
      has_mark = any(handle%mark == marks)
   end function has_mark

   module procedure found_system
      is_found = has_mark(address, [SYSTEM_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end procedure found_system

   module procedure found_scene
      is_found = has_mark(address, [SCENE_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end procedure found_scene

   module procedure found_stepper
      is_found = has_mark(address, [STEPPER_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end procedure found_stepper

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

   module procedure destroy
      type(c_ptr), pointer :: slot
      type(handle_t), pointer :: handle
      type(system_handle_t), pointer :: system
      type(scene_handle_t), pointer :: scene
      type(stepper_handle_t), pointer :: stepper
      type(history_handle_t), pointer :: history
      type(bodies_handle_t), pointer :: bodies
      code = NUTATE_BAD_ARGUMENT
      if (.not. c_associated(address)) return
      call c_f_pointer(address, slot)
      code = NUTATE_OK
      if (.not. c_associated(slot)) return
      if (.not. has_mark(slot, [mark], code)) return
      call c_f_pointer(slot, handle)
      call erase_mark(handle%mark)
      if (mark == SYSTEM_MARK) then
         call c_f_pointer(slot, system)
         deallocate (system)
      else if (mark == SCENE_MARK) then
         call c_f_pointer(slot, scene)
         deallocate (scene)
      else if (mark == STEPPER_MARK) then
         call c_f_pointer(slot, stepper)
         deallocate (stepper)
      else if (mark == HISTORY_MARK) then
         call c_f_pointer(slot, history)
         deallocate (history)
      else
         call c_f_pointer(slot, bodies)
         deallocate (bodies)
      end if
      slot = c_null_ptr
      code = NUTATE_OK
   end procedure destroy

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

   module procedure set_start
      self%t = state%t
      self%q = state%q
      self%p = state%p
      self%wheel_momentum = state%wheel_momentum
   end procedure set_start

   module procedure state_of_start
      state%t = self%t
      state%q = self%q
      state%p = self%p
      state%wheel_momentum = self%wheel_momentum
   end procedure state_of_start

   module procedure get_propagated
      if (allocated(handle%propagated)) then
         propagated = handle%propagated
      else
         allocate (propagated%names(0), propagated%sigma(0))
      end if
   end procedure get_propagated

   module procedure set_propagated
      if (allocated(handle%propagated)) deallocate (handle%propagated)
      if (size(propagated%names) > 0 .or. propagated%exponents > 0) handle%propagated = propagated
   end procedure set_propagated

   module procedure set_chaos
      if (allocated(handle%chaos)) deallocate (handle%chaos)
      if (chaos%exponents > 0) handle%chaos = chaos
   end procedure set_chaos

   module procedure unprepare
      handle%plain = .false.
      call handle%run%release()
      if (allocated(handle%run%stepper)) deallocate (handle%run%stepper)
      if (allocated(handle%inside)) deallocate (handle%inside)
   end procedure unprepare

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
