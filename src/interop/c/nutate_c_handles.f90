!> Types behind the opaque handles of the C interface; those of scenes and steppers have modules of their own
!> (`nutate_c_scene_handle`, `nutate_c_stepper_handle`).
!>
!> Every handle begins with a mark of its kind. The mark is cleared when the handle is destroyed, so that a destroyed
!> handle, or one of another kind, is recognised.
module nutate_c_handles
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_int, c_int64_t, c_null_ptr, c_ptr, c_size_t
   use nutate_bodies, only: movement_t
   use nutate_bodies_drift, only: body_class_t
   use nutate_c_effects, only: report_failures_to
   use nutate_c_found, only: found_events_t
   use nutate_c_text, only: message_to_c
   use nutate_chaos, only: chaos_t
   use nutate_kinds, only: wp, long
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_HANDLE, NUTATE_NO_MEMORY, NUTATE_OK
   use nutate_system, only: system_t
   implicit none
   private

   public :: handle_t, system_handle_t, history_handle_t, bodies_handle_t
   public :: SYSTEM_MARK, SCENE_MARK, STEPPER_MARK, HISTORY_MARK, BODIES_MARK
   public :: found, has_mark, is_taken, open_slot, copy_system, null_argument, report, whole_message, conclude
   public :: make_room

   !> Marks of the kinds of handles.
   integer(c_int64_t), parameter :: SYSTEM_MARK = 7811887110843601971_c_int64_t, &
                                    SCENE_MARK = 7811887110843601972_c_int64_t, &
                                    STEPPER_MARK = 7811887110843601973_c_int64_t, &
                                    HISTORY_MARK = 7811887110843601974_c_int64_t, &
                                    BODIES_MARK = 7811887110843601975_c_int64_t

   !> Common part of all handles, at their beginning.
   type :: handle_t
      !> Mark of the kind.
      integer(c_int64_t) :: mark = 0
      !> Status of the last call.
      type(status_t) :: status
      !> Complete message of an error; that of the status may lack its middle.
      character(len=:), allocatable :: text
   end type handle_t

   !> A body and the effects on it.
   type, extends(handle_t) :: system_handle_t
      type(system_t) :: system
   end type system_handle_t

   !> The rows of a run.
   type, extends(handle_t) :: history_handle_t
      !> Names of the columns, comma separated.
      character(len=:), allocatable :: names
      integer :: width = 0
      integer(c_size_t) :: rows = 0
      !> Steps of the run in which a root was accepted without certification.
      integer(long) :: uncertified_steps = 0
      !> `estimate` and `round_off` of a run with an accuracy, and this accuracy, rad.
      real(wp) :: error(2) = 0.0_wp, accuracy = 0.0_wp
      !> Rows; shape (width, room for rows).
      real(wp), allocatable :: values(:, :)
      type(found_events_t) :: found
      !> Chaos indicators, if the run computed any.
      type(chaos_t), allocatable :: indicators
   end type history_handle_t

   !> Classes of many bodies.
   type, extends(handle_t) :: bodies_handle_t
      type(body_class_t), allocatable :: classes(:)
      !> Frame, threads and the number of the first class and body.
      type(movement_t) :: what = movement_t()
      !> Bodies that failed in the last call, counted from 1.
      integer, allocatable :: failed(:)
   end type bodies_handle_t

   !> Points to the handle at an address and returns true, if it is one of the pointer's kind. The code becomes
   !> `NUTATE_BAD_HANDLE`, which the caller replaces.
   interface found
      module procedure found_system, found_history, found_bodies, found_any
   end interface found

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

   logical function found_system(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(system_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [SYSTEM_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_system

   logical function found_history(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(history_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [HISTORY_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_history

   logical function found_bodies(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(bodies_handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [BODIES_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_bodies

   !> Finds a handle of any kind; the pointer gives access to the common part of all handles.
   logical function found_any(address, handle, code) result(is_found)
      type(c_ptr), intent(in) :: address
      type(handle_t), pointer, intent(inout) :: handle
      integer(c_int), intent(out), optional :: code
      is_found = has_mark(address, [SYSTEM_MARK, SCENE_MARK, STEPPER_MARK, HISTORY_MARK, BODIES_MARK], code)
      if (is_found) call c_f_pointer(address, handle)
   end function found_any

   !> Takes a handle out of the variable of C that holds it, to be freed: clears its mark, and sets the variable to
   !> null. Returns false if there is nothing to free. Errors: `NUTATE_BAD_ARGUMENT` for no variable,
   !> `NUTATE_BAD_HANDLE` for a handle of another kind.
   logical function is_taken(address, mark, handle, code)
      type(c_ptr), intent(in) :: address
      integer(c_int64_t), intent(in) :: mark
      type(c_ptr), intent(out) :: handle
      integer(c_int), intent(out) :: code
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
   end function is_taken

   !> Returns the variable in which C keeps a handle, set to null; null if there is no variable.
   function open_slot(address) result(slot)
      !> Address of the variable, of type `nutate_...**`.
      type(c_ptr), intent(in) :: address
      type(c_ptr), pointer :: slot
      slot => null()
      if (.not. c_associated(address)) return
      call c_f_pointer(address, slot)
      slot = c_null_ptr
   end function open_slot

   !> Clears the mark of a handle that is about to be freed; volatile, so that the compiler does not omit the write.
   subroutine erase_mark(mark)
      integer(c_int64_t), intent(inout), volatile :: mark
      mark = 0
   end subroutine erase_mark

   !> Copies a system; the callbacks of the copy report their failures to a cell.
   subroutine copy_system(from, to, cell)
      type(system_t), intent(in) :: from
      type(system_t), intent(inout) :: to
      !> Address of two `int`, or null.
      type(c_ptr), intent(in) :: cell
      to%body = from%body
      call to%effects%append(from%effects)
      call report_failures_to(to%effects, cell)
   end subroutine copy_system

   !> Makes room for one more row in a history. Errors: `NUTATE_NO_MEMORY`.
   subroutine make_room(history, status)
      type(history_handle_t), intent(inout) :: history
      type(status_t), intent(inout) :: status
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
   end subroutine make_room

   !> Returns the status for an argument that is null and must not be.
   pure function null_argument(name) result(status)
      character(len=*), intent(in) :: name
      type(status_t) :: status
      status = fail(NUTATE_BAD_ARGUMENT, 'the argument '//name//' is NULL', name)
   end function null_argument

   !> Stores a status in a handle and returns its code.
   integer(c_int) function conclude(handle, status) result(code)
      class(handle_t), intent(inout) :: handle
      type(status_t), intent(in) :: status
      handle%status = status
      code = status%code
   end function conclude

   !> Writes the message of a status into a buffer and returns its code.
   integer(c_int) function report(status, buffer, size, whole) result(code)
      type(status_t), intent(in) :: status
      type(c_ptr), intent(in) :: buffer
      integer(c_size_t), intent(in) :: size
      !> Complete message, which is used if the status has its shortened form.
      character(len=:), allocatable, intent(in), optional :: whole
      if (present(whole)) then
         call message_to_c(whole_message(status, whole), buffer, size)
      else
         call message_to_c(status%message, buffer, size)
      end if
      code = status%code
   end function report

   !> Returns the message of a status, or the complete message if the status has its shortened form.
   pure function whole_message(status, whole) result(message)
      type(status_t), intent(in) :: status
      character(len=:), allocatable, intent(in) :: whole
      character(len=:), allocatable :: message
      type(status_t) :: short
      message = trim(status%message)
      if (status%ok() .or. .not. allocated(whole)) return
      short = fail(status%code, whole)
      if (short%message == status%message) message = whole
   end function whole_message

end module nutate_c_handles
