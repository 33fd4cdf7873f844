!> Rows of a run in an array of C, in a history, or in a file.
module nutate_c_rows
   use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_loc, c_null_ptr, c_ptr, c_size_t
   use nutate_c_effects, only: add_failure, status_of_failure
   use nutate_c_handles, only: history_handle_t, make_room, HISTORY_MARK
   use nutate_c_stepper_handle, only: stepper_handle_t
   use nutate_event, only: event_t
   use nutate_event_history, only: event_history_t
   use nutate_history, only: history_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: observer_t, run_record_t
   use nutate_progress, only: is_over, total_work
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_NO_MEMORY, NUTATE_STEP_LIMIT
   use nutate_system, only: system_t
   implicit none
   private

   public :: row_receiver_t, write_row, present_record

   !> Writes the rows of a run into an array, a history or a file.
   type, extends(observer_t) :: row_receiver_t
      !> Array `double[capacity][width]`, or null; rows that it can hold, a negative number beyond the greatest integer.
      type(c_ptr) :: array = c_null_ptr
      integer(c_size_t) :: capacity = 0
      !> Variable of C for a history, which receives all rows as soon as the array has no room for them, or null.
      type(c_ptr), pointer :: slot => null()
      !> History that receives all rows in place of an array, or null.
      type(history_handle_t), pointer :: history => null()
      !> Files that receive the rows and events in place of an array or a history, or null.
      type(history_t), pointer :: file => null()
      type(event_history_t), pointer :: events => null()
      !> True if there is an array, a history or a file.
      logical :: wants_rows = .false.
      !> Number of rows so far.
      integer(c_size_t) :: rows = 0
      !> Rows of the array or of the history; shape (width, room for rows).
      real(wp), pointer, contiguous :: values(:, :) => null()
      !> True if the run omits its first row, and the row at the end of its plan unless that is due.
      logical :: leaves_out_ends = .false.
      !> Stepper of the run.
      type(stepper_handle_t), pointer :: handle => null()
   contains
      !> Opens the array.
      procedure :: open_array
      !> Opens a history for all rows.
      procedure, non_overridable :: open_history
      procedure :: observe => receive_row
      procedure :: poll => ask_program
      procedure :: check_step => check_callbacks
      procedure :: observe_event => receive_event
      procedure :: observe_step => follow_state
   end type row_receiver_t

contains

   !> Opens the array. Errors: `NUTATE_BAD_ARGUMENT` if it is too small.
   subroutine open_array(self, width, needed, status)
      class(row_receiver_t), intent(inout) :: self
      integer, intent(in) :: width
      !> Number of rows that the array must hold.
      integer(long), intent(in) :: needed
      type(status_t), intent(out) :: status
      self%wants_rows = associated(self%history)
      if (self%wants_rows) self%history%width = width
      if (.not. c_associated(self%array) .or. self%wants_rows) return
      if (self%capacity >= 0 .and. self%capacity < needed .and. .not. associated(self%slot)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the array for the rows is too small', 'capacity')
         return
      end if
      self%wants_rows = .true.
      self%rows = 0
      associate (capacity => self%capacity)
         call c_f_pointer(self%array, self%values, &
                          [int(width, c_size_t), merge(capacity, huge(capacity)/width, capacity >= 0)])
      end associate
   end subroutine open_array

   !> Opens a history in the slot of C, unless there is one, with the rows so far. Errors: `NUTATE_NO_MEMORY`.
   subroutine open_history(self, handle, status)
      class(row_receiver_t), intent(inout) :: self
      type(stepper_handle_t), intent(in) :: handle
      type(status_t), intent(inout) :: status
      integer :: failed
      if (associated(self%history)) return
      allocate (self%history, stat=failed)
      if (failed == 0 .and. self%rows > 0) &
         allocate (self%history%values(size(self%values, 1), self%rows), stat=failed, source=self%values(:, :self%rows))
      if (failed /= 0) then
         status = fail(NUTATE_NO_MEMORY, 'not enough memory for a history')
         if (associated(self%history)) deallocate (self%history)
         return
      end if
      self%history%mark = HISTORY_MARK
      self%history%names = handle%names
      self%history%width = handle%columns%width
      self%history%rows = self%rows
      self%slot = c_loc(self%history)
   end subroutine open_history

   !> Returns the record of the present state, which a row needs beside the state.
   type(run_record_t) function present_record(handle) result(record)
      type(stepper_handle_t), intent(in) :: handle
      record = handle%run%record
      if (.not. allocated(handle%run%policy) .and. allocated(handle%run%stepper)) then
         record%iterations = handle%run%stepper%iterations
         record%residual = handle%run%stepper%residual
      end if
      associate (summary => handle%run%summary)
         record%work = total_work(summary)
         if (handle%columns%needs_works) record%works = [summary%work, summary%switch_work]
      end associate
   end function present_record

   !> Writes the present state as a row. Errors: `NUTATE_NOT_FINITE`.
   subroutine write_row(handle, receiver, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(row_receiver_t), intent(inout) :: receiver
      type(status_t), intent(inout) :: status
      if (receiver%wants_rows) &
         call put_row(handle, receiver, handle%system, handle%run%state, present_record(handle), status)
   end subroutine write_row

   !> Appends a row. Errors: `NUTATE_NOT_FINITE`; `NUTATE_STEP_LIMIT` if there is no room.
   subroutine put_row(handle, receiver, system, state, record, status)
      type(stepper_handle_t), intent(inout) :: handle
      class(row_receiver_t), intent(inout) :: receiver
      !> System with the effects that are on now.
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      if (associated(receiver%file)) then
         if (allocated(receiver%tangent)) call move_alloc(receiver%tangent, receiver%file%tangent)
         if (allocated(receiver%chaos)) call move_alloc(receiver%chaos, receiver%file%chaos)
         call receiver%file%observe(system, state, record, status)
         return
      end if
      if (associated(receiver%slot) .and. is_full(receiver)) call receiver%open_history(handle, status)
      if (associated(receiver%history)) call make_room(receiver%history, status)
      if (status%code /= 0) return
      if (associated(receiver%history)) then
         receiver%values => receiver%history%values
      else if (is_full(receiver)) then
         status = fail(NUTATE_STEP_LIMIT, 'the run has more rows than the array has room for')
         return
      end if
      associate (row => receiver%values(:, receiver%rows + 1))
         call handle%columns%evaluate(system, state, record, row, receiver%tangent, receiver%chaos)
         call handle%columns%check_row(row, status)
      end associate
      call add_failure(handle%failure, status)
      if (status%code == 0) receiver%rows = receiver%rows + 1
      if (associated(receiver%history)) receiver%history%rows = receiver%rows
   end subroutine put_row

   !> Returns true if there is no array, or it has no room for another row.
   pure logical function is_full(receiver)
      class(row_receiver_t), intent(in) :: receiver
      is_full = .not. associated(receiver%values)
      if (.not. is_full) is_full = receiver%rows >= size(receiver%values, 2, c_size_t)
   end function is_full

   !> Writes a row of a run, if it is due.
   subroutine receive_row(self, system, state, record, status)
      class(row_receiver_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      status = status_of_failure(self%handle%failure)
      if (status%code /= 0 .or. .not. self%wants_rows) return
      if (self%leaves_out_ends) then
         associate (run => self%handle%run)
            if (run%summary%steps == run%first_step .and. .not. run%way%begun) return
            if (mod(run%summary%steps - run%first_step, run%plan%every) /= 0 .and. is_over(run%progress_t)) return
         end associate
      end if
      call put_row(self%handle, self, system, state, record, status)
   end subroutine receive_row

   !> Keeps an event of a run.
   subroutine receive_event(self, system, event, which, number, state, record, status)
      class(row_receiver_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer, intent(in) :: which
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      status = status_of_failure(self%handle%failure)
      if (status%code == 0 .and. associated(self%file)) then
         call self%events%write(self%file, system, trim(event%name), number, state, record, status)
      else if (status%code == 0) then
         if (.not. allocated(self%handle%found)) allocate (self%handle%found)
         call self%handle%found%put(system, event, number, state, status)
      end if
   end subroutine receive_event

   !> Ends the run if the poll callback requests it.
   subroutine ask_program(self, fraction, status)
      class(row_receiver_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      call self%handle%poll%ask(status)
   end subroutine ask_program

   !> Undoes a step in which a callback has failed.
   subroutine check_callbacks(self, status)
      class(row_receiver_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      status = status_of_failure(self%handle%failure)
   end subroutine check_callbacks

   !> Follows angles, so that no full revolution is lost.
   subroutine follow_state(self, state)
      class(row_receiver_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      if (associated(self%file)) then
         call self%file%observe_step(state)
      else
         call self%handle%columns%follow(state)
      end if
   end subroutine follow_state

end module nutate_c_rows
