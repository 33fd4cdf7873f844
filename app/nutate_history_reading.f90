!> Reads histories: the CSV files that runs write.
module nutate_history_reading
   use nutate_console, only: count_text
   use nutate_file_hint, only: did_you_mean
   use nutate_kinds, only: wp, long
   use nutate_number_text, only: read_real
   use nutate_printable, only: printable_path, quoted
   use nutate_scene_table, only: next_field
   use nutate_spelling, only: split_list
   implicit none
   private

   public :: recorded_t, read_history

   !> Longest line of a history.
   integer, parameter :: line_length = 4096

   !> Columns of a history.
   type :: recorded_t
      !> Their names, `t` first; shape (number of columns).
      character(len=24), allocatable :: names(:)
      !> Shape (rows, columns).
      real(wp), allocatable :: values(:, :)
   contains
      !> True if there are columns of all these names.
      procedure :: has
      !> The values of a column that is there.
      procedure :: column
   end type recorded_t

contains

   pure logical function has(self, names)
      class(recorded_t), intent(in) :: self
      !> Comma separated.
      character(len=*), intent(in) :: names
      integer :: i
      associate (wanted => split_list(names))
         has = all([(any(self%names == wanted(i)), i=1, size(wanted))])
      end associate
   end function has

   pure function column(self, name) result(values)
      class(recorded_t), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp), allocatable :: values(:)
      values = self%values(:, findloc(self%names == name, .true., dim=1))
   end function column

   !> Reads `t` and those of the wanted columns that are there.
   subroutine read_history(path, wanted, history, problem)
      character(len=*), intent(in) :: path
      !> Names of columns.
      character(len=*), intent(in) :: wanted(:)
      type(recorded_t), intent(out) :: history
      !> What is wrong, one printable line, `FILE: ...` or `FILE:LINE: ...`; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      character(len=line_length) :: line
      character(len=200) :: why
      integer, allocatable :: places(:)
      integer(long) :: rows
      integer :: unit, iostat, fields

      problem = ''
      why = 'there is no such file'
      open (newunit=unit, file=path, status='old', action='read', iostat=iostat, iomsg=why)
      if (iostat == 0) read (unit, '(a)', iostat=iostat, iomsg=why) line
      if (iostat /= 0) then
         if (did_you_mean(path, '.csv') /= '') why = 'there is no such file; '//did_you_mean(path, '.csv')
         problem = printable_path(path)//': cannot be read ('//trim(why)//')'
         return
      end if
      call read_header(trim(line), wanted, history%names, places, fields)
      if (size(places) == 0) then
         problem = printable_path(path)//':1: this is no history (expected a first line t,...)'
      else
         rows = 0
         do
            read (unit, '(a)', iostat=iostat) line
            if (iostat /= 0) exit
            rows = rows + 1
         end do
         rewind (unit)
         read (unit, '(a)')
         allocate (history%values(rows, size(places)))
         call read_rows(unit, path, places, fields, history%values, problem)
      end if
      close (unit)
   end subroutine read_history

   !> Finds `t` and the wanted columns in the first line; none where it is not that of a history.
   pure subroutine read_header(line, wanted, names, places, fields)
      character(len=*), intent(in) :: line
      character(len=*), intent(in) :: wanted(:)
      character(len=24), allocatable, intent(out) :: names(:)
      !> Fields of a row that are read; shape (number of names).
      integer, allocatable, intent(out) :: places(:)
      !> How many fields a row has.
      integer, intent(out) :: fields
      character(len=24) :: name
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
         if (fields > 1 .and. .not. any(wanted == name)) cycle
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

   !> Reads the fields of a row that are asked for.
   subroutine read_row(line, places, fields, values, problem)
      character(len=*), intent(in) :: line
      integer, intent(in) :: places(:), fields
      !> Shape (number of places).
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
