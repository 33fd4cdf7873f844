!> Time histories: one CSV row for each state received.
!>
!> RFC 4180 fields, lines ended by LF. Each number is as short as reads back exactly; a number that is not finite is
!> an error, never a field.
module nutate_history
   use nutate_archive, only: archive_t
   use nutate_columns, only: columns_t
   use nutate_decimal, only: append_rounded, decimal_t, decimal_length
   use nutate_epoch, only: epoch_t
   use nutate_files, only: output_file_t
   use nutate_kinds, only: wp, long
   use nutate_observer, only: observer_t, run_record_t
   use nutate_propagated, only: propagated_t
   use nutate_state, only: state_t
   use nutate_status, only: fail, status_t, NUTATE_BAD_ARGUMENT
   use nutate_system, only: system_t
   implicit none
   private

   public :: history_t, append_date

   !> A history being written: pass it to `integrate`, or call `observe` for each row.
   type, extends(observer_t) :: history_t
      !> Rows so far, the header not counted.
      integer(long) :: rows = 0
      type(output_file_t) :: file
      type(columns_t) :: columns
      type(decimal_t), private :: decimal
      !> Significant digits; 0: as many as read back exactly.
      integer :: digits = 0
      !> Date of t = 0, for the column of dates; not set: there is no such column.
      type(epoch_t) :: epoch
      !> One row; shape (number of columns).
      real(wp), allocatable, private :: values(:)
      character(len=:), allocatable, private :: line
   contains
      !> Opens the file and writes the header.
      procedure :: open => open_history
      !> Continues a history from checkpoint data.
      procedure :: reopen => reopen_history
      !> Records in checkpoint data how far the history is.
      procedure :: transfer => transfer_history
      !> Writes a row.
      procedure :: observe => write_row
      !> Appends numbers to a line, as they stand in the rows.
      procedure :: append_values
      !> Returns the names of the columns, comma separated, including that of the dates.
      procedure :: header
      !> Follows angles from step to step.
      procedure :: observe_step => follow_state
      !> Ends a complete history: the file gets its name.
      procedure :: finish
      !> Ends a history that is not complete: the rows written so far stay in the partial file.
      procedure :: abandon
   end type history_t

contains

   !> Opens the file and writes the header. Errors: `NUTATE_BAD_ARGUMENT` for an unknown set of columns, an empty path
   !> and a number of digits out of range; `NUTATE_IO`.
   subroutine open_history(self, name, columns, system, state, inverse_j0, status, degrees, digits, backward, epoch, &
                           propagated)
      class(history_t), intent(inout) :: self
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      !> Names of the sets of columns.
      character(len=*), intent(in) :: columns(:)
      type(system_t), intent(in) :: system
      !> The first state of the run; it is written by the first `observe`.
      type(state_t), intent(in) :: state
      !> 1/J0, kg⁻¹ m⁻².
      real(wp), intent(in) :: inverse_j0
      type(status_t), intent(out) :: status
      !> Angles in degrees; default `.false.`. Significant digits of the numbers, 1 to 17; default: as many as read back
      !> exactly.
      logical, intent(in), optional :: degrees
      integer, intent(in), optional :: digits
      !> The run goes backward in time; default `.false.`.
      logical, intent(in), optional :: backward
      !> Date of t = 0, for a column of dates.
      type(epoch_t), intent(in), optional :: epoch
      !> Quantities that the run propagates, for columns that show them.
      type(propagated_t), intent(in), optional :: propagated

      if (name == '') then
         status = fail(NUTATE_BAD_ARGUMENT, 'the path is empty (expected that of a file)', 'name')
         return
      end if
      call start(self, columns, system, state, inverse_j0, status, degrees, digits, backward, epoch, propagated)
      if (.not. status%ok()) return
      call self%file%open(name, status)
      if (status%ok()) call self%file%put_line(self%header(), status)
      if (.not. status%ok()) call forget_rows(self)
   end subroutine open_history

   !> Continues a history from checkpoint data, instead of `open`. Errors: those of `open`, and `NUTATE_IO` if the
   !> partial file differs from what was recorded; then nothing has been changed.
   subroutine reopen_history(self, name, columns, system, state, inverse_j0, archive, status, degrees, digits, &
                             backward, epoch, propagated)
      class(history_t), intent(inout) :: self
      !> Path and names of sets, as given to `open`.
      character(len=*), intent(in) :: name, columns(:)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: inverse_j0
      !> Checkpoint data being read.
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      logical, intent(in), optional :: degrees
      integer, intent(in), optional :: digits
      logical, intent(in), optional :: backward
      type(epoch_t), intent(in), optional :: epoch
      type(propagated_t), intent(in), optional :: propagated
      call start(self, columns, system, state, inverse_j0, status, degrees, digits, backward, epoch, propagated)
      if (.not. status%ok()) return
      call archive%transfer(self%rows)
      call self%columns%transfer(archive)
      call self%file%reopen(name, archive, status)
      if (.not. status%ok()) call forget_rows(self)
   end subroutine reopen_history

   !> Records in checkpoint data how far the history is, after all of it has been written to the disk. Errors:
   !> `NUTATE_IO`.
   subroutine transfer_history(self, archive, status)
      class(history_t), intent(inout) :: self
      !> Checkpoint data being written.
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      call archive%transfer(self%rows)
      call self%columns%transfer(archive)
      call self%file%record(archive, status)
   end subroutine transfer_history

   !> Prepares the history for rows of the requested columns.
   subroutine start(self, columns, system, state, inverse_j0, status, degrees, digits, backward, epoch, propagated)
      class(history_t), intent(inout) :: self
      character(len=*), intent(in) :: columns(:)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp), intent(in) :: inverse_j0
      type(status_t), intent(out) :: status
      logical, intent(in), optional :: degrees
      integer, intent(in), optional :: digits
      logical, intent(in), optional :: backward
      type(epoch_t), intent(in), optional :: epoch
      type(propagated_t), intent(in), optional :: propagated
      call forget_rows(self)
      self%digits = 0
      if (present(digits)) self%digits = digits
      call self%columns%choose(columns, status, degrees, system%effects, propagated)
      if (status%ok() .and. (self%digits < 0 .or. self%digits > 17)) status = fail( &
         NUTATE_BAD_ARGUMENT, 'digits is out of range (expected 1 to 17, or 0 for the shortest)', 'digits')
      if (.not. status%ok()) return
      if (present(epoch)) self%epoch = epoch
      self%observes_every_step = self%columns%follows_steps
      self%wants_works = self%columns%needs_works
      self%wants_tangent = self%columns%differentiates
      self%rows = 0
      if (allocated(self%values)) deallocate (self%values, self%line)
      allocate (self%values(self%columns%width))
      allocate (character(len=(decimal_length + 1)*(self%columns%width + 2)) :: self%line)
      call self%decimal%prepare()
      call self%columns%start(system, state, inverse_j0, backward)
   end subroutine start

   !> Returns the names of the columns, comma separated, including that of the dates.
   pure function header(self, plain) result(line)
      class(history_t), intent(in) :: self
      !> True to leave out the columns of derivatives; default false.
      logical, intent(in), optional :: plain
      character(len=:), allocatable :: line
      line = self%columns%header(plain)
      if (self%epoch%is_set()) line = 't,date'//line(2:)
   end function header

   !> Appends a date as a field of its own.
   pure subroutine append_date(date, line, used)
      type(epoch_t), intent(in) :: date
      character(len=*), intent(inout) :: line
      !> Characters of the line in use; 40 more must be free.
      integer, intent(inout) :: used
      character(len=:), allocatable :: text
      text = ','//date%text()
      line(used + 1:used + len(text)) = text
      used = used + len(text)
   end subroutine append_date

   !> Writes a row. Errors: `NUTATE_BAD_ARGUMENT` for a history that is not open; `NUTATE_NOT_FINITE`, and the row is
   !> not written; `NUTATE_IO`.
   subroutine write_row(self, system, state, record, status)
      class(history_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      integer :: used
      if (.not. allocated(self%values)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the history is not open (expected open before)')
         return
      end if
      call self%columns%evaluate(system, state, record, self%values, self%tangent, self%chaos)
      call self%columns%check_row(self%values, status)
      if (status%code /= 0) return
      used = 0
      call self%append_values(self%values(:1), self%line, used)
      if (self%epoch%is_set()) call append_date(self%epoch%after(state%t), self%line, used)
      call self%append_values(self%values(2:), self%line, used)
      call self%file%put_line(self%line(1:used), status)
      if (status%ok()) self%rows = self%rows + 1
   end subroutine write_row

   !> Appends numbers to a line, with commas between them and after the present content.
   subroutine append_values(self, values, line, used)
      class(history_t), intent(inout) :: self
      !> Finite numbers; shape (n).
      real(wp), intent(in) :: values(:)
      character(len=*), intent(inout) :: line
      !> Characters of the line so far.
      integer, intent(inout) :: used
      integer :: i
      do i = 1, size(values)
         if (used > 0) then
            used = used + 1
            line(used:used) = ','
         end if
         if (self%digits > 0) then
            call append_rounded(line, used, values(i), self%digits)
         else
            call self%decimal%append(line, used, values(i))
         end if
      end do
   end subroutine append_values

   !> Follows angles from step to step, so that no revolution is lost between rows.
   subroutine follow_state(self, state)
      class(history_t), intent(inout) :: self
      type(state_t), intent(in) :: state
      call self%columns%follow(state)
   end subroutine follow_state

   !> Completes a history and gives the file its name. Errors: `NUTATE_IO`; the partial file stays.
   subroutine finish(self, status)
      class(history_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      call self%file%finish(status)
      call forget_rows(self)
   end subroutine finish

   !> Ends a history that is not complete; the partial file stays. Errors: `NUTATE_IO`.
   subroutine abandon(self, status)
      class(history_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      call self%file%abandon(status)
      call forget_rows(self)
   end subroutine abandon

   !> Frees the memory for rows: the history accepts none until it is opened again.
   subroutine forget_rows(self)
      class(history_t), intent(inout) :: self
      if (allocated(self%values)) deallocate (self%values, self%line)
   end subroutine forget_rows

end module nutate_history
