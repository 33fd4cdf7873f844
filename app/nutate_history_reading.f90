!> Reads histories: the CSV files that runs write.
module nutate_history_reading
   use, intrinsic :: iso_c_binding, only: c_null_char
   use nutate_console, only: count_text
   use nutate_file_calls, only: file_readable
   use nutate_file_hint, only: did_you_mean
   use nutate_kinds, only: wp, long
   use nutate_number_text, only: read_real
   use nutate_printable, only: printable_path, quoted
   use nutate_scene_table, only: next_field
   use nutate_system_text, only: error_text
   implicit none
   private

   public :: recorded_t, read_history, read_names, name_length

   !> Longest line of a history, and longest name of a column.
   integer, parameter :: line_length = 16384, name_length = 48

   !> Columns of a history.
   type :: recorded_t
      !> Names of the columns, `t` first; shape (number of columns).
      character(len=name_length), allocatable :: names(:)
      !> Values of the columns; shape (rows, columns).
      real(wp), allocatable :: values(:, :)
   end type recorded_t

contains

   !> Reads the names of all columns.
   subroutine read_names(path, names, problem)
      character(len=*), intent(in) :: path
      !> Names of the columns, `t` first; not allocated on failure.
      character(len=name_length), allocatable, intent(out) :: names(:)
      !> Error message, one printable line, `FILE: ...` or `FILE:LINE: ...`; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      character(len=line_length) :: line
      integer, allocatable :: places(:)
      integer :: unit, fields
      call open_history(path, unit, line, problem)
      if (problem /= '') return
      close (unit)
      call read_header(trim(line), names, places, fields)
      if (size(places) == 0) problem = printable_path(path)//':1: not a history (expected a first line t,...)'
   end subroutine read_names

   !> Opens a history and reads its first line.
   subroutine open_history(path, unit, line, problem)
      character(len=*), intent(in) :: path
      !> Unit, open on success.
      integer, intent(out) :: unit
      character(len=*), intent(out) :: line
      character(len=:), allocatable, intent(out) :: problem
      character(len=200) :: why
      integer :: iostat
      problem = ''
      iostat = file_readable(path//c_null_char)
      if (iostat /= 0) why = error_text(iostat)
      if (iostat == 0) open (newunit=unit, file=path, status='old', action='read', iostat=iostat, iomsg=why)
      if (iostat == 0) read (unit, '(a)', iostat=iostat, iomsg=why) line
      if (iostat == 0) return
      if (did_you_mean(path, '.csv') /= '') why = 'there is no such file; '//did_you_mean(path, '.csv')
      problem = printable_path(path)//': cannot be read ('//trim(why)//')'
   end subroutine open_history

   !> Reads `t` and the wanted columns.
   subroutine read_history(path, wanted, history, problem)
      character(len=*), intent(in) :: path
      !> Names of columns that `read_names` found.
      character(len=*), intent(in) :: wanted(:)
      type(recorded_t), intent(out) :: history
      !> Error message, one printable line, `FILE: ...` or `FILE:LINE: ...`; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      character(len=line_length) :: line
      integer, allocatable :: places(:)
      integer(long) :: lines, rows
      integer :: unit, iostat, fields

      call open_history(path, unit, line, problem)
      if (problem /= '') return
      call read_header(trim(line), history%names, places, fields, wanted)
      rows = 0
      lines = 0
      do
         read (unit, '(a)', iostat=iostat) line
         if (iostat /= 0) exit
         lines = lines + 1
         ! Blank lines at the end are not rows.
         if (line /= '') rows = lines
      end do
      rewind (unit)
      ! The header may end with the file.
      read (unit, '(a)', iostat=iostat) line
      if (iostat /= 0) rows = 0
      allocate (history%values(rows, size(places)))
      call read_rows(unit, path, places, fields, history%values, problem)
      close (unit)
   end subroutine read_history

   !> Finds `t` and the wanted columns in the first line; none if the line is not that of a history.
   pure subroutine read_header(line, names, places, fields, wanted)
      character(len=*), intent(in) :: line
      character(len=name_length), allocatable, intent(out) :: names(:)
      !> Positions of the fields of a row that are read; shape (number of names).
      integer, allocatable, intent(out) :: places(:)
      !> Number of fields in a row.
      integer, intent(out) :: fields
      !> Names of the wanted columns; default: all.
      character(len=*), intent(in), optional :: wanted(:)
      character(len=name_length) :: name
      character(len=:), allocatable :: problem
      integer :: position, first, last
      logical :: ends
      allocate (names(0), places(0))
      fields = 0
      position = 1
      ends = .false.
      problem = ''
      do while (.not. ends)
         call next_field(line, position, first, last, ends, problem)
         fields = fields + 1
         name = line(first:last)
         if (problem /= '' .or. (fields == 1 .and. (name /= 't' .or. ends))) return
         if (fields > 1 .and. present(wanted)) then
            if (.not. any(wanted == name)) cycle
         end if
         names = [names, name]
         places = [places, fields]
      end do
   end subroutine read_header

   !> Reads all rows.
   subroutine read_rows(unit, path, places, fields, values, problem)
      integer, intent(in) :: unit
      character(len=*), intent(in) :: path
      integer, intent(in) :: places(:), fields
      real(wp), intent(out) :: values(:, :)
      character(len=:), allocatable, intent(inout) :: problem
      character(len=line_length) :: line
      integer :: row, iostat
      values = 0.0_wp
      do row = 1, size(values, 1)
         read (unit, '(a)', iostat=iostat) line
         if (iostat == 0) call read_row(trim(line), places, fields, values(row, :), problem)
         if (iostat /= 0) problem = 'cannot be read'
         if (problem == '') cycle
         problem = printable_path(path)//':'//count_text(row + 1_long)//': '//problem
         return
      end do
   end subroutine read_rows

   !> Reads the requested fields of a row.
   subroutine read_row(line, places, fields, values, problem)
      character(len=*), intent(in) :: line
      integer, intent(in) :: places(:), fields
      !> Values of the fields; shape (number of `places`).
      real(wp), intent(out) :: values(:)
      character(len=:), allocatable, intent(inout) :: problem
      character(len=:), allocatable :: fault
      integer :: position, first, last, field, n
      logical :: ends
      position = 1
      n = 1
      values = 0.0_wp
      do field = 1, fields
         call next_field(line, position, first, last, ends, problem)
         if (problem /= '') return
         if (places(n) == field) then
            call read_real(line(first:last), values(n), fault)
            if (fault /= '' .and. abs(values(n)) <= 0.0_wp) then
               problem = quoted(line(first:last))//' is not a number'
               return
            end if
            n = min(n + 1, size(places))
         end if
         if (ends) exit
      end do
      if (field < fields) then
         problem = count_text(int(field, long))//' fields (expected '//count_text(int(fields, long))//')'
      else if (field > fields) then
         problem = 'more than '//count_text(int(fields, long))//' fields'
      end if
   end subroutine read_row

end module nutate_history_reading
