!> Tables of times and torques that a scene names: RFC 4180, one header row with the units, then a time and three
!> components in each line.
module nutate_scene_table
   use nutate_checksum, only: checksum
   use nutate_keys, only: group_t, table_t
   use nutate_kinds, only: wp
   use nutate_number_text, only: read_real
   use nutate_printable, only: printable_path, quoted
   use nutate_quick_number, only: read_quickly
   use nutate_scene_error, only: scene_error_t
   use nutate_status, only: status_t
   use nutate_tabulated_torque, only: check_table
   use nutate_text_file, only: read_text_file
   implicit none
   private

   public :: read_table, parse_table

   !> Columns: a time and the components of a vector; and their units.
   integer, parameter :: n_columns = 4
   character(len=3), parameter :: units(n_columns) = ['s  ', 'N m', 'N m', 'N m']
   character(len=*), parameter :: header = 't (s) and three components, each with its unit (N m)'
   character, parameter :: quote = '"', line_feed = achar(10), carriage_return = achar(13), tab = achar(9)
   !> What some programs put in front of a text in UTF-8.
   character(len=*), parameter :: mark = char(239)//char(187)//char(191)

contains

   !> Reads the table that a group names by its key `table`; a group without one stays as it is. Raises an error, with
   !> file and line, for one that is no table of times and torques.
   subroutine read_table(group, folder, error)
      type(group_t), intent(inout) :: group
      !> Folder of the scene, `/` at its end: where names of tables begin; empty: the working directory.
      character(len=*), intent(in) :: folder
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: path, text, reason
      type(status_t) :: status
      integer :: at

      if (.not. group%has('table') .or. error%raised) return
      path = trim(group%text('table', ''))
      if (path == '') then
         call error%raise(group%line_of('table'), 'table is blank', expected='the name of a CSV file')
         return
      end if
      if (path(1:1) /= '/') path = folder//path
      call read_text_file(path, text, reason)
      if (reason /= '') then
         call error%raise(group%line_of('table'), 'table '//quoted(path)//' cannot be read', expected='a CSV file; '// &
                          reason)
         return
      end if
      if (allocated(group%table)) deallocate (group%table)
      allocate (group%table)
      call parse_table(text, path, group%table, error)
      if (error%raised) return
      group%table%checksum = checksum(text)
      associate (numbers => group%table%numbers)
         call check_table(numbers(1, :), numbers(2:4, :), group%text('interpolation', 'linear') == 'cubic', &
                          group%text('outside', 'zero') == 'periodic', at, status)
      end associate
      if (.not. status%ok()) call error%raise_in(path, at + 1, trim(status%message))
   end subroutine read_table

   !> The numbers of a table. Raises an error at its first line that is none.
   subroutine parse_table(text, path, table, error)
      character(len=*), intent(in) :: text
      !> What to call it in messages.
      character(len=*), intent(in) :: path
      !> Shape of its numbers (4, lines without the header).
      type(table_t), intent(inout) :: table
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: problem
      integer :: position, line

      allocate (table%numbers(n_columns, count_lines(text) - 1))
      position = 1
      if (len(text) >= len(mark)) then
         if (text(1:len(mark)) == mark) position = len(mark) + 1
      end if
      call read_header(text, position, problem)
      line = 1
      do while (problem == '' .and. line <= size(table%numbers, 2))
         line = line + 1
         call read_row(text, position, table%numbers(:, line - 1), problem)
      end do
      if (problem /= '') call error%raise_in(path, line, problem)
   end subroutine parse_table

   !> Lines of a text, the last of which need not be ended; 1 at least.
   pure integer function count_lines(text) result(n)
      character(len=*), intent(in) :: text
      integer :: i
      n = 0
      do i = 1, len(text)
         if (text(i:i) == line_feed) n = n + 1
      end do
      if (len(text) == 0) then
         n = 1
      else if (text(len(text):) /= line_feed) then
         n = n + 1
      end if
   end function count_lines

   !> The header row: four names, each with its unit in brackets at the end.
   subroutine read_header(text, position, problem)
      character(len=*), intent(in) :: text
      integer, intent(inout) :: position
      !> What is wrong with it; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      integer :: column, first, last
      logical :: ends

      problem = ''
      do column = 1, n_columns
         call next_field(text, position, first, last, ends, problem)
         if (problem == '' .and. (ends .neqv. column == n_columns)) &
            problem = 'the header has not four columns (expected '//header//')'
         if (problem /= '') return
         if (.not. has_unit(text(first:last), trim(units(column)))) then
            problem = quoted(text(first:last))//' has not the unit ('//trim(units(column))//') at its end '// &
                      '(expected '//header//')'
            return
         end if
      end do
   end subroutine read_header

   !> A name ends with its unit in brackets.
   pure logical function has_unit(name, unit)
      character(len=*), intent(in) :: name, unit
      integer :: last
      last = len_trim(name)
      has_unit = .false.
      if (last >= len(unit) + 2) has_unit = name(last - len(unit) - 1:last) == '('//unit//')'
   end function has_unit

   !> A line of four numbers.
   subroutine read_row(text, position, numbers, problem)
      character(len=*), intent(in) :: text
      integer, intent(inout) :: position
      real(wp), intent(out) :: numbers(n_columns)
      character(len=:), allocatable, intent(out) :: problem
      integer :: column, first, last
      logical :: ends, done

      problem = ''
      do column = 1, n_columns
         call next_field(text, position, first, last, ends, problem)
         if (problem == '' .and. (ends .neqv. column == n_columns)) &
            problem = 'the line has not four numbers (expected a time, s, and three components, N m)'
         if (problem /= '') return
         call read_quickly(text(first:last), numbers(column), done)
         if (.not. done) call read_real(text(first:last), numbers(column), problem)
         if (problem /= '') then
            problem = problem//' (expected a number)'
            return
         end if
      end do
   end subroutine read_row

   !> The next field of a line, without the blanks and the quotes around it.
   pure subroutine next_field(text, position, first, last, ends, problem)
      character(len=*), intent(in) :: text
      !> Behind the field and what ends it, on exit.
      integer, intent(inout) :: position
      !> Where it stands; the last is before the first where it is empty.
      integer, intent(out) :: first, last
      !> It is the last of its line.
      logical, intent(out) :: ends
      !> What is wrong with it; left as it is on success.
      character(len=:), allocatable, intent(inout) :: problem
      integer :: n

      n = len(text)
      first = position
      do while (first <= n)
         if (text(first:first) /= ' ' .and. text(first:first) /= tab) exit
         first = first + 1
      end do
      position = first
      do while (position <= n)
         if (text(position:position) == ',' .or. text(position:position) == line_feed) exit
         position = position + 1
      end do
      last = position - 1
      ends = .true.
      if (position <= n) ends = text(position:position) == line_feed
      if (ends .and. last >= first) then
         if (text(last:last) == carriage_return) last = last - 1
      end if
      do while (last >= first)
         if (text(last:last) /= ' ' .and. text(last:last) /= tab) exit
         last = last - 1
      end do
      position = position + 1
      if (last < first) return
      if (text(first:first) /= quote) return
      if (last == first .or. text(last:last) /= quote) then
         problem = quoted(text(first:last))//' has a quote that is not closed in its field (expected a number '// &
                   'or a name)'
         return
      end if
      first = first + 1
      last = last - 1
   end subroutine next_field

end module nutate_scene_table
