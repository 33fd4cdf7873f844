!> Tables that a scene names: RFC 4180, one header row with the units, then numbers. Columns are times and torques,
!> times alone, a path of an orbit, or point masses.
module nutate_scene_table
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_checksum, only: checksum
   use nutate_body, only: body_t, make_body
   use nutate_center_change, only: center_change_t, make_tabulated_center
   use nutate_inertia_change, only: inertia_change_t, make_tabulated_inertia
   use nutate_keys, only: group_t, table_t
   use nutate_kinds, only: wp
   use nutate_number_text, only: read_real
   use nutate_printable, only: quoted
   use nutate_quick_number, only: read_quickly
   use nutate_scene_error, only: scene_error_t
   use nutate_spelling, only: lower_case
   use nutate_status, only: status_t
   use nutate_tabulated_torque, only: check_table
   use nutate_third_degree, only: check_points
   use nutate_track, only: make_track, track_t
   use nutate_text_file, only: read_text_file
   implicit none
   private

   public :: read_table, read_effect_table, parse_table, path_beside, begin_of, count_lines, next_field, read_row
   public :: names_a_file, read_named_file, read_number

   !> Units of the columns: a time and the components of a torque; a time alone.
   character(len=3), parameter, public :: torque_units(4) = ['s  ', 'N m', 'N m', 'N m'], time_units(1) = ['s  ']
   !> Units of the columns of point masses; of a path: positions, and velocities, which are optional.
   character(len=3), parameter :: point_units(4) = ['kg ', 'm  ', 'm  ', 'm  ']
   character(len=3), parameter :: path_units(7) = ['s  ', 'm  ', 'm  ', 'm  ', 'm/s', 'm/s', 'm/s']
   !> Units of the columns of an inertia: three principal components, and three off the diagonal, which are optional.
   character(len=5), parameter :: inertia_units(7) = ['s    ', 'kg m2', 'kg m2', 'kg m2', 'kg m2', 'kg m2', 'kg m2']
   character, parameter :: quote = '"', line_feed = achar(10), carriage_return = achar(13), tab = achar(9)
   !> Byte order mark that some programs put before a text in UTF-8.
   character(len=*), parameter :: mark = char(239)//char(187)//char(191)

contains

   !> Reads the table that a group names by its key `table`, and those of &body; a group without one, or with one
   !> that has been read, stays unchanged. Raises an error, with file and line, for an invalid table.
   subroutine read_effect_table(group, folder, error, space)
      type(group_t), intent(inout) :: group
      !> Folder of the scene, `/` at its end, to which names of tables are relative; empty: the working directory.
      character(len=*), intent(in) :: folder
      type(scene_error_t), intent(inout) :: error
      !> Kind of the space axes, as `frame` of `read_table`; default: `space`.
      character(len=*), intent(in), optional :: space
      type(status_t) :: status
      character(len=:), allocatable :: axes
      integer :: at

      if (group%name == 'body') call read_body_tables(group, folder, error)
      if (allocated(group%table)) return
      if (.not. group%has('table')) return
      select case (group%name)
      case ('orbit')
         call read_table(group, 'table', path_units, folder, error, least=4, frame='inertial')
      case ('third_degree')
         call read_table(group, 'table', point_units, folder, error, frame='body')
      case ('wheel')
         ! A wheel has one torque, about its axis.
         call read_table(group, 'table', torque_units(:2), folder, error)
      case default
         axes = group%text('axes', 'body')
         if (axes == 'space' .and. present(space)) axes = space
         call read_table(group, 'table', torque_units, folder, error, frame=axes)
      end select
      if (error%raised) return
      associate (numbers => group%table%numbers)
         if (group%name == 'orbit') then
            call check_path(numbers, at, status)
         else if (group%name == 'third_degree') then
            call check_points(numbers, at, status)
         else
            call check_table(numbers(1, :), numbers(2:, :), group%text('interpolation', 'linear') == 'cubic', &
                             group%text('outside', 'zero') == 'periodic', at, status)
         end if
      end associate
      if (.not. status%ok()) call error%raise_in(path_beside(folder, group%text('table', '')), at + 1, &
                                                 trim(status%message))
   end subroutine read_effect_table

   !> Reads the tables of a body that have not been read.
   subroutine read_body_tables(group, folder, error)
      type(group_t), intent(inout) :: group
      character(len=*), intent(in) :: folder
      type(scene_error_t), intent(inout) :: error
      type(table_t), allocatable :: inertia
      type(center_change_t) :: change
      type(status_t) :: status
      integer :: at
      if (group%has('inertia_table') .and. .not. allocated(group%table)) call read_inertia(group, folder, error)
      if (error%raised .or. .not. group%has('center_of_mass_table') .or. allocated(group%center_table)) return
      call move_alloc(group%table, inertia)
      call read_table(group, 'center_of_mass_table', path_units(:4), folder, error, frame='body')
      if (.not. error%raised) then
         associate (numbers => group%table%numbers)
            call make_tabulated_center(numbers(1, :), numbers(2:4, :), change, status, at, &
                                       spline=group%text('center_of_mass_interpolation', 'linear') == 'cubic')
         end associate
         if (.not. status%ok()) call error%raise_in(path_beside(folder, group%text('center_of_mass_table', '')), &
                                                    at + 1, trim(status%message))
      end if
      call move_alloc(group%table, group%center_table)
      call move_alloc(inertia, group%table)
   end subroutine read_body_tables

   !> Reads the table of the inertia of a body, and checks each of its lines.
   subroutine read_inertia(group, folder, error)
      type(group_t), intent(inout) :: group
      character(len=*), intent(in) :: folder
      type(scene_error_t), intent(inout) :: error
      type(inertia_change_t) :: change
      type(body_t) :: body
      type(status_t) :: status
      integer :: at, i
      call read_table(group, 'inertia_table', inertia_units, folder, error, least=4, frame='body')
      if (error%raised) return
      associate (numbers => group%table%numbers)
         call make_tabulated_inertia(numbers(1, :), numbers(2:, :), change, status, at, &
                                     spline=group%text('inertia_interpolation', 'linear') == 'cubic')
         do i = 1, size(numbers, 2)
            if (.not. status%ok()) exit
            at = i
            call make_body(change%tabulated_at(numbers(1, i)), body, status, &
                           check_triangle=group%flag('check_triangle', .true.))
         end do
      end associate
      if (.not. status%ok()) call error%raise_in(path_beside(folder, group%text('inertia_table', '')), at + 1, &
                                                 trim(status%message))
   end subroutine read_inertia

   !> Checks a table of an orbit, and its path. Errors: those of `make_track`.
   subroutine check_path(numbers, at, status)
      !> Shape (4 or 7, lines).
      real(wp), intent(in) :: numbers(:, :)
      !> Line with the error; 0: no error.
      integer, intent(out) :: at
      type(status_t), intent(out) :: status
      type(track_t) :: track
      if (size(numbers, 1) == 4) then
         call make_track(numbers(1, :), numbers(2:4, :), track, status, at)
      else
         call make_track(numbers(1, :), numbers(2:4, :), track, status, at, numbers(5:7, :))
      end if
   end subroutine check_path

   !> Reads the table that a group names by a given key. Raises an error, with file and line, for a table that cannot be
   !> read or has other columns.
   subroutine read_table(group, key, units, folder, error, least, frame)
      type(group_t), intent(inout) :: group
      character(len=*), intent(in) :: key
      !> Units of the columns; shape (columns).
      character(len=*), intent(in) :: units(:)
      character(len=*), intent(in) :: folder
      type(scene_error_t), intent(inout) :: error
      !> Number of first columns that a table may have alone; default: it has all of them.
      integer, intent(in), optional :: least
      !> Axes of the components: `body`, `inertial`, `LVLH`, `rotating` (space axes), or `space`, any that stand still;
      !> default: they have none.
      character(len=*), intent(in), optional :: frame
      character(len=:), allocatable :: path, text
      integer :: columns

      if (error%raised) return
      call read_named_file(group, key, folder, 'a CSV file', path, text, error)
      if (error%raised) return
      if (allocated(group%table)) deallocate (group%table)
      allocate (group%table)
      columns = size(units)
      if (present(least)) then
         if (count_columns(text) == least) columns = least
      end if
      call parse_table(text, path, units(:columns), group%table, error, frame)
      if (.not. error%raised) group%table%checksum = checksum(text)
   end subroutine read_table

   !> Reads the file that a key names. Raises an error if the name is blank, or the file cannot be read.
   subroutine read_named_file(group, key, scene, kind, path, text, error)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      !> Path of the scene, or its folder with `/` at the end.
      character(len=*), intent(in) :: scene
      !> Kind of the file, for messages: `a CSV file`.
      character(len=*), intent(in) :: kind
      !> Path of the file and its text.
      character(len=:), allocatable, intent(out) :: path, text
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: reason
      path = ''
      if (group%text(key, '') == '') then
         call error%raise(group%line_of(key), key//' is blank', expected='the name of '//kind)
         return
      end if
      path = path_beside(scene, group%text(key, ''))
      call read_text_file(path, text, reason)
      if (reason /= '') call error%raise(group%line_of(key), key//' '//quoted(path)//' cannot be read', &
                                         expected=kind//'; '//reason)
   end subroutine read_named_file

   !> Returns the path of a file that a scene names, relative to the working directory.
   pure function path_beside(scene, name) result(path)
      !> Path of the scene, or its folder with `/` at the end; empty: the working directory.
      character(len=*), intent(in) :: scene, name
      character(len=:), allocatable :: path
      path = trim(name)
      if (name(1:1) /= '/') path = scene(1:index(scene, '/', back=.true.))//path
   end function path_beside

   !> Returns true if a key of a group names a file that is read, relative to the folder of the scene.
   pure logical function names_a_file(group, key)
      character(len=*), intent(in) :: group, key
      select case (key)
      case ('table', 'times_file', 'inertia_table', 'center_of_mass_table')
         names_a_file = .true.
      case ('file')
         names_a_file = group == 'measurement'
      case ('attitude')
         names_a_file = group == 'frame'
      case default
         names_a_file = .false.
      end select
   end function names_a_file

   !> Reads the numbers of a table. Raises an error at its first invalid line.
   subroutine parse_table(text, path, units, table, error, frame)
      character(len=*), intent(in) :: text
      !> Name of the table in messages.
      character(len=*), intent(in) :: path
      !> Units of the columns; shape (columns).
      character(len=*), intent(in) :: units(:)
      !> Table; its numbers have the shape (columns, lines without the header).
      type(table_t), intent(inout) :: table
      type(scene_error_t), intent(inout) :: error
      !> Axes of the components: `body`, `inertial`, `LVLH`, `rotating` (space axes), or `space`, any that stand still;
      !> default: they have none.
      character(len=*), intent(in), optional :: frame
      character(len=:), allocatable :: problem
      integer :: position, line

      allocate (table%numbers(size(units), count_lines(text) - 1))
      position = begin_of(text)
      call read_header(text, position, units, problem, frame)
      line = 1
      do while (problem == '' .and. line <= size(table%numbers, 2))
         line = line + 1
         call read_row(text, position, table%numbers(:, line - 1), problem)
      end do
      if (problem /= '') call error%raise_in(path, line, problem)
   end subroutine parse_table

   !> Returns the position where a text begins: behind its byte order mark, if it has one.
   pure integer function begin_of(text)
      character(len=*), intent(in) :: text
      begin_of = 1
      if (len(text) < len(mark)) return
      if (text(:len(mark)) == mark) begin_of = len(mark) + 1
   end function begin_of

   !> Returns the number of lines of a text without blank ones at its end, the last of which need not be ended; 1 at
   !> least.
   pure integer function count_lines(text) result(n)
      character(len=*), intent(in) :: text
      integer :: i
      n = 1
      do i = 1, verify(text, ' '//tab//carriage_return//line_feed, back=.true.)
         if (text(i:i) == line_feed) n = n + 1
      end do
   end function count_lines

   !> Returns the number of columns in the first line of a text.
   pure integer function count_columns(text) result(n)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: problem
      integer :: position, first, last
      logical :: ends
      problem = ''
      position = begin_of(text)
      n = 0
      ends = .false.
      do while (.not. ends .and. problem == '')
         call next_field(text, position, first, last, ends, problem)
         n = n + 1
      end do
   end function count_columns

   !> Reads the header row: names, each with its unit in brackets at the end.
   subroutine read_header(text, position, units, problem, frame)
      character(len=*), intent(in) :: text
      integer, intent(inout) :: position
      character(len=*), intent(in) :: units(:)
      !> Error message; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      !> Axes of the components: `body`, `inertial`, `LVLH`, `rotating` (space axes), or `space`, any that stand still;
      !> default: they have none.
      character(len=*), intent(in), optional :: frame
      integer :: column, first(size(units)), last(size(units))
      logical :: ends

      problem = ''
      do column = 1, size(units)
         call next_field(text, position, first(column), last(column), ends, problem)
         if (problem == '' .and. (ends .neqv. column == size(units))) &
            problem = 'the header has the wrong number of columns (expected '//header_of(units)//')'
         if (problem /= '') return
         associate (name => text(first(column):last(column)))
            if (.not. has_unit(name, trim(units(column)))) then
               problem = quoted(name)//' lacks the unit ('//trim(units(column))//') at its end '// &
                         '(expected '//header_of(units)//')'
               return
            end if
         end associate
         last(column) = last(column) - len_trim(units(column)) - 2
         last(column) = first(column) - 1 + len_trim(text(first(column):last(column)))
      end do
      if (size(units) < 4) return
      if (size(units) == 7 .and. units(2) == 'kg m2') then
         if (in_another_order(text, first(2:), last(2:), [1, 2, 3, 12, 13, 23])) problem = '11, 22, 33, 12, 13, 23'
      else if (in_another_order(text, first(2:4), last(2:4), [1, 2, 3])) then
         problem = 'those of the axes 1, 2, 3'
      else if (size(units) == 7) then
         if (in_another_order(text, first(5:), last(5:), [1, 2, 3])) problem = 'those of the axes 1, 2, 3'
      end if
      if (problem /= '') problem = 'the components are not in order (expected '//problem//')'
      if (problem == '' .and. present(frame)) call check_frame(text, first(2:), last(2:), frame, problem)
   end subroutine read_header

   !> Rejects names that tell other axes, such as `x_eci` of components along body axes.
   pure subroutine check_frame(text, first, last, frame, problem)
      character(len=*), intent(in) :: text
      !> Positions of the names.
      integer, intent(in) :: first(:), last(:)
      character(len=*), intent(in) :: frame
      !> Error message; unchanged if there is none.
      character(len=:), allocatable, intent(inout) :: problem
      character(len=*), parameter :: word_letters = 'abcdefghijklmnopqrstuvwxyz0123456789'
      !> Names of body axes, of space axes, of inertial ones, of those of the LVLH frame, of a place, and of other
      !> rotating ones.
      character(len=10), parameter :: words(22) = [character(len=10) :: 'body', 'space', 'inertial', 'eci', 'gcrf', &
         'icrf', 'j2000', 'eme2000', 'gcrs', 'teme', 'b1950', 'eclipj2000', 'lvlh', 'vvlh', 'ned', 'enu', 'ecef', &
         'ecf', 'itrf', 'rtn', 'rsw', 'ric']
      logical :: is_right(size(words)), found(size(words), size(first))
      character(len=:), allocatable :: rest
      integer :: i, n
      is_right(1) = frame == 'body'
      is_right(2) = frame /= 'body'
      is_right(3:12) = frame == 'inertial' .or. frame == 'space'
      is_right(13:14) = frame == 'LVLH' .or. frame == 'rotating'
      is_right(15:16) = frame == 'rotating' .or. frame == 'space'
      is_right(17:) = frame == 'rotating'
      found = .false.
      do i = 1, size(first)
         rest = lower_case(text(first(i):last(i)))
         do while (scan(rest, word_letters) > 0)
            rest = rest(scan(rest, word_letters):)
            n = verify(rest//' ', word_letters) - 1
            found(:, i) = found(:, i) .or. words == rest(:n)
            rest = rest(n + 1:)
         end do
      end do
      if (any(found .and. spread(is_right, 2, size(first)))) return
      i = findloc(any(found, dim=1), .true., dim=1)
      if (i > 0) problem = quoted(text(first(i):last(i)))//' names other axes (expected components along '// &
                           frame//' axes)'
   end subroutine check_frame

   !> Returns true if the names of columns tell another order of the axes than the expected one: all of them, each once,
   !> or one by nothing but an axis.
   pure logical function in_another_order(text, first, last, expected)
      character(len=*), intent(in) :: text
      !> Positions of the names.
      integer, intent(in) :: first(:), last(:)
      integer, intent(in) :: expected(:)
      integer :: axes(size(first)), from(size(first)), to(size(first)), i
      logical :: is_axis(size(first)), from_zero
      from = first
      to = last
      call strip_common(text, from, to)
      ! Numbers may begin at zero.
      from_zero = any([(text(from(i):to(i)) == '0', i=1, size(first))])
      do i = 1, size(first)
         call find_axes(text(from(i):to(i)), axes(i), is_axis(i))
         if (from_zero .and. scan(text(from(i):to(i)), '012') == 1) axes(i) = index('012', text(from(i):to(i)))
      end do
      in_another_order = any(axes /= expected) .and. all([(any(axes == expected(i)), i=1, size(expected))])
      if (.not. in_another_order) in_another_order = any(is_axis .and. axes /= expected)
   end function in_another_order

   !> Moves the ends of names inwards over the letters that all have in common; none becomes empty.
   pure subroutine strip_common(text, from, to)
      character(len=*), intent(in) :: text
      integer, intent(inout) :: from(:), to(:)
      do while (all(to > from))
         if (.not. are_equal(text, from)) exit
         from = from + 1
      end do
      do while (all(to > from))
         if (.not. are_equal(text, to)) exit
         to = to - 1
      end do
   end subroutine strip_common

   !> Returns true if the letters at some positions are equal.
   pure logical function are_equal(text, places)
      character(len=*), intent(in) :: text
      integer, intent(in) :: places(:)
      integer :: i
      are_equal = all([(text(places(i):places(i)) == text(places(1):places(1)), i=2, size(places))])
   end function are_equal

   !> Finds the axes that the end of a name stands for: 1 to 3 for `x`, `Ty`, `J33`, `roll`; 12, 13 or 23 for `Jxy`,
   !> `J31`; 0 if there are none.
   pure subroutine find_axes(name, axes, is_axis)
      character(len=*), intent(in) :: name
      integer, intent(out) :: axes
      !> The name is that of an axis, and nothing else.
      logical, intent(out) :: is_axis
      character(len=*), parameter :: letters = 'xyzXYZ', digits = '123'
      character(len=5), parameter :: angles(3) = [character(len=5) :: 'roll', 'pitch', 'yaw']
      integer :: last, other
      axes = findloc(angles == lower_case(name), .true., dim=1)
      is_axis = axes > 0
      last = len_trim(name)
      if (last == 0 .or. is_axis) return
      axes = axis_of(name(last:last))
      is_axis = last == 1 .and. axes > 0
      if (last == 1 .or. axes == 0) return
      if (index(letters, name(last:last)) > 0 .neqv. index(letters, name(last - 1:last - 1)) > 0) return
      other = axis_of(name(last - 1:last - 1))
      is_axis = last == 2 .and. other > 0
      if (other > 0 .and. other /= axes) axes = 10*min(axes, other) + max(axes, other)

   contains

      !> Returns the axis that a letter or a digit stands for; 0 for others.
      pure integer function axis_of(letter)
         character, intent(in) :: letter
         axis_of = index(digits, letter)
         if (axis_of == 0 .and. index(letters, letter) > 0) axis_of = modulo(index(letters, letter) - 1, 3) + 1
      end function axis_of

   end subroutine find_axes

   !> Returns the description of a valid header: of times, of a torque about an axis, of the components of a torque, of
   !> a path, of point masses, of an inertia.
   pure function header_of(units) result(words)
      character(len=*), intent(in) :: units(:)
      character(len=:), allocatable :: words
      words = 't (s)'
      if (units(1) == 'kg') words = 'a mass with the unit (kg)'
      if (size(units) == 2) words = words//' and a torque with its unit (N m)'
      if (size(units) < 3) return
      words = words//' and three components, each with its unit ('//trim(units(2))//')'
      if (units(2) == 'kg m2') words = 't (s) and components 11, 22, 33, or also 12, 13, 23, each with its unit (kg m2)'
      if (units(2) == 'm' .and. size(units) > 4) &
         words = words//', then, if known, those of the velocity with the unit (m/s)'
   end function header_of

   !> Returns true if a name ends with its unit in brackets.
   pure logical function has_unit(name, unit)
      character(len=*), intent(in) :: name, unit
      integer :: last
      last = len_trim(name)
      has_unit = .false.
      if (last >= len(unit) + 2) has_unit = name(last - len(unit) - 1:last) == '('//unit//')'
   end function has_unit

   !> Reads a line of numbers.
   subroutine read_row(text, position, numbers, problem)
      character(len=*), intent(in) :: text
      integer, intent(inout) :: position
      !> Shape (columns).
      real(wp), intent(out) :: numbers(:)
      character(len=:), allocatable, intent(out) :: problem
      integer :: column, first, last
      logical :: ends, done

      problem = ''
      do column = 1, size(numbers)
         call next_field(text, position, first, last, ends, problem)
         if (problem == '' .and. (ends .neqv. column == size(numbers))) &
            problem = 'wrong number of values in this line (expected one per column)'
         if (problem /= '') return
         call read_quickly(text(first:last), numbers(column), done)
         if (.not. done) call read_real(text(first:last), numbers(column), problem)
         if (problem /= '') then
            problem = problem//' (expected a number)'
            return
         end if
      end do
   end subroutine read_row

   !> Reads a finite number of a measurement or a table.
   subroutine read_number(word, number, problem)
      character(len=*), intent(in) :: word
      real(wp), intent(out) :: number
      !> Error message; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      logical :: done
      problem = ''
      call read_quickly(word, number, done)
      if (.not. done) call read_real(word, number, problem)
      if (problem == '' .and. .not. ieee_is_finite(number)) problem = quoted(word)//' is not finite'
      if (problem /= '') problem = problem//' (expected a number)'
   end subroutine read_number

   !> Finds the next field of a line, without the blanks and the quotes around it. In quotes a comma is an ordinary
   !> letter, and a doubled quote is one quote; line breaks are not admitted there.
   pure subroutine next_field(text, position, first, last, ends, problem)
      character(len=*), intent(in) :: text
      !> Position; on exit behind the field and its separator.
      integer, intent(inout) :: position
      !> First and last position of the field; the last is before the first if it is empty.
      integer, intent(out) :: first, last
      !> The field is the last of its line.
      logical, intent(out) :: ends
      !> Error message; unchanged on success.
      character(len=:), allocatable, intent(inout) :: problem
      integer :: n, behind

      n = len(text)
      first = position
      do while (first <= n)
         if (text(first:first) /= ' ' .and. text(first:first) /= tab) exit
         first = first + 1
      end do
      behind = behind_quotes(text, first)
      position = max(first, behind)
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
      if (last /= behind - 1) then
         problem = quoted(text(first:last))//' has a quote that is not closed in its field (expected a number '// &
                   'or a name)'
         return
      end if
      first = first + 1
      last = last - 1
   end subroutine next_field

   !> Returns the position behind the quotes of a field; 0 if it has none, or they are not closed in its line.
   pure integer function behind_quotes(text, first) result(behind)
      character(len=*), intent(in) :: text
      !> First position of the field.
      integer, intent(in) :: first
      integer :: step
      behind = 0
      if (first > len(text)) return
      if (text(first:first) /= quote) return
      behind = first + 1
      do
         step = scan(text(behind:), quote//line_feed)
         behind = behind + step
         if (step == 0) exit
         if (text(behind - 1:behind - 1) /= quote) exit
         if (behind > len(text)) return
         if (text(behind:behind) /= quote) return
         behind = behind + 1
      end do
      behind = 0
   end function behind_quotes

end module nutate_scene_table
