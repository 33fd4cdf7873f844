!> The events of a run as a CSV file: one row for each, with its time, name and number, and the columns of the history
!> without derivatives.
module nutate_event_history
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_archive, only: archive_t
   use nutate_columns, only: columns_t
   use nutate_decimal, only: decimal_length
   use nutate_files, only: output_file_t
   use nutate_history, only: append_date, history_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: run_record_t
   use nutate_spelling, only: count_text, escaped
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_NOT_FINITE
   use nutate_system, only: system_t
   implicit none
   private

   public :: evaluate_event, event_history_t, events_name

   !> Events being written.
   type :: event_history_t
      !> True if events are written to a file.
      logical :: wanted = .false.
      integer(long) :: rows = 0
      type(output_file_t) :: file
   contains
      !> Opens the file and writes the header.
      procedure :: open => open_events
      !> Continues the file recorded in checkpoint data.
      procedure :: reopen => reopen_events
      !> Records in checkpoint data how far the file is.
      procedure :: transfer => transfer_events
      !> Writes a row.
      procedure :: write => write_event
   end type event_history_t

contains

   !> Returns the name of the file of events that belongs to a file of rows: `NAME.events.csv` for `NAME.csv`; blank if
   !> the rows go to standard output.
   pure function events_name(rows) result(name)
      character(len=*), intent(in) :: rows
      character(len=:), allocatable :: name
      name = rows//'.events.csv'
      if (rows == '-') name = ''
      if (len(rows) <= 4) return
      if (rows(len(rows) - 3:) == '.csv') name = rows(:len(rows) - 4)//'.events.csv'
   end function events_name

   !> Opens the file and writes the header. Errors: as for opening a history.
   subroutine open_events(self, name, history, status)
      class(event_history_t), intent(inout) :: self
      !> Path of the file of events.
      character(len=*), intent(in) :: name
      !> History that is open; the rows of events have its columns.
      class(history_t), intent(in) :: history
      type(status_t), intent(inout) :: status
      character(len=:), allocatable :: header
      self%wanted = .true.
      self%rows = 0
      call self%file%open(name, status)
      if (.not. status%ok()) return
      header = history%header(plain=.true.)
      call self%file%put_line('t,event,number'//header(2:), status)
   end subroutine open_events

   !> Continues the file recorded in checkpoint data. Errors: as for continuing a history.
   subroutine reopen_events(self, name, archive, status)
      class(event_history_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      !> Checkpoint data being read.
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(inout) :: status
      self%wanted = .true.
      call archive%transfer(self%rows)
      call self%file%reopen(name, archive, status)
   end subroutine reopen_events

   !> Records in checkpoint data how far the file is, after all of it has been written to the disk. Errors: `NUTATE_IO`.
   subroutine transfer_events(self, archive, status)
      class(event_history_t), intent(inout) :: self
      !> Checkpoint data being written.
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(inout) :: status
      if (.not. self%wanted) return
      call archive%transfer(self%rows)
      call self%file%record(archive, status)
   end subroutine transfer_events

   !> Writes a row. Errors: `NUTATE_NOT_FINITE`, the row is not written then; `NUTATE_IO`.
   subroutine write_event(self, history, system, name, number, state, record, status)
      class(event_history_t), intent(inout) :: self
      !> History at the last state that it received; the numbers are written as in its rows.
      class(history_t), intent(inout) :: history
      type(system_t), intent(in) :: system
      !> Name of the event.
      character(len=*), intent(in) :: name
      !> Number of times that the event has happened.
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      real(wp) :: values(history%columns%plain_width)
      character(len=(decimal_length + 1)*(history%columns%plain_width + 2)) :: line
      integer :: used, first
      if (.not. self%wanted) return
      call evaluate_event(history%columns, system, state, record, values)
      if (.not. all(ieee_is_finite(values))) then
         status = fail(NUTATE_NOT_FINITE, 'a value at an event is not finite')
         return
      end if
      first = 0
      call history%append_values(values(:1), line, first)
      used = first
      if (history%epoch%is_set()) call append_date(history%epoch%after(state%t), line, used)
      call history%append_values(values(2:), line, used)
      call self%file%put_line(line(:first)//','//field(name)//','//count_text(number)//line(first + 1:used), status)
      if (status%ok()) self%rows = self%rows + 1
   end subroutine write_event

   !> Evaluates the columns of a history at an event inside a step, without changing those of its rows.
   subroutine evaluate_event(followed, system, state, record, values)
      !> Columns at the last state that the history received.
      type(columns_t), intent(in) :: followed
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      !> Values of the columns; shape (plain_width).
      real(wp), intent(out) :: values(:)
      type(columns_t) :: columns
      columns = followed
      if (columns%follows_steps) call columns%follow(state)
      call columns%evaluate(system, state, record, values)
   end subroutine evaluate_event

   !> Returns a string as a field of RFC 4180: in quotes if it has a comma or quotes, which are doubled.
   pure function field(text)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: field
      field = trim(text)
      if (scan(field, ',"') > 0) field = '"'//escaped(field, '"', '"')//'"'
   end function field

end module nutate_event_history
