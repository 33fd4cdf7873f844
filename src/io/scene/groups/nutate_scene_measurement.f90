!> `&measurement`: columns of a CSV file or a message that were measured, with their standard deviations.
module nutate_scene_measurement
   use nutate_admissible, only: ANY_DIRECTION, POSITIVE
   use nutate_columns, only: columns_t
   use nutate_effect_list, only: effect_list_t
   use nutate_fit_plan, only: measurement_t, ATTITUDES, DIRECTIONS, VALUES
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp, pi
   use nutate_measured_message, only: is_message, read_message
   use nutate_printable, only: printable_path, quoted
   use nutate_motion_quantities, only: Q_EULER
   use nutate_orbit_quantities, only: Q_ROLL_PITCH_YAW
   use nutate_quantities, only: find_quantity, names_for, quantities, reason_of, set_of, turns_to_degrees
   use nutate_quantity, only: AS_MEASUREMENT
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_labels, only: labels_t
   use nutate_scene_table, only: begin_of, count_lines, next_field, read_named_file, read_number
   use nutate_spelling, only: comma_list, count_text, nearest_name, split_list
   use nutate_table_units, only: conversion, split_header, units_of
   use nutate_status, only: status_t
   implicit none
   private

   public :: measurement_keys, build_measurement

   !> Largest number of columns of a group, and of letters of a name.
   integer, parameter :: most_columns = 24, longest_name = 48
   character(len=*), parameter :: degree_mark = '_deg'
   character(len=*), parameter :: losses(4) = [character(len=8) :: 'linear', 'huber', 'soft_l1', 'cauchy']
   !> Largest deviation from 1 of the norm of a measured quaternion or direction.
   real(wp), parameter :: norm_tolerance = 1e-3_wp
   !> Sine of the least distance of a folded angle from its ends: several steps of the differences of a fit.
   real(wp), parameter :: least_sine = 1e-2_wp

contains

   !> Keys of the scene group `&measurement`.
   pure function measurement_keys() result(keys)
      type(key_t) :: keys(6)
      keys = [key_t(name='file', kind=KEY_TEXT, required=.true.), &
              key_t(name='columns', kind=KEY_TEXT, most=most_columns, required=.true.), &
              key_t(name='sigma', most=most_columns, range=POSITIVE), &
              key_t(name='bias', kind=KEY_TEXT, choices='none,constant'), &
              key_t(name='loss', kind=KEY_TEXT, choices='linear,huber,soft_l1,cauchy'), &
              key_t(name='direction', least=3, most=3, range=ANY_DIRECTION)]
   end function measurement_keys

   !> Reads a group and its file. Raises an error, with file and line, for columns or rows that cannot be measurements.
   subroutine build_measurement(group, effects, end_time, scene, labels, measurement, error)
      type(group_t), intent(in) :: group
      !> Effects of the scene.
      type(effect_list_t), intent(in) :: effects
      !> End time of the run, s.
      real(wp), intent(in) :: end_time
      !> Path of the scene.
      character(len=*), intent(in) :: scene
      !> Epoch and frames of the scene.
      type(labels_t), intent(in) :: labels
      type(measurement_t), intent(out) :: measurement
      type(scene_error_t), intent(inout) :: error
      integer :: i
      allocate (measurement%columns(group%count_of('columns')))
      do i = 1, size(measurement%columns)
         measurement%columns(i) = group%text_at('columns', i)
         if (any(measurement%columns(:i - 1) == measurement%columns(i))) &
            call error%raise(group%line_of('columns'), quoted(trim(measurement%columns(i)))//' is named twice', &
                             expected='each column once')
      end do
      if (.not. error%raised) call find_kind()
      if (.not. error%raised) call read_statistics()
      if (.not. error%raised) call read_file()

   contains

      !> Finds the kind of the columns: values, directions or attitudes.
      subroutine find_kind()
         character(len=*), parameter :: quaternion(4) = ['q0', 'q1', 'q2', 'q3']
         integer :: i
         measurement%kind = VALUES
         if (group%has('direction')) then
            measurement%kind = DIRECTIONS
            measurement%direction = group%vector('direction', measurement%direction)
            measurement%direction = measurement%direction/norm2(measurement%direction)
            if (size(measurement%columns) /= 3) &
               call error%raise(group%line_of('columns'), 'a direction has three components', expected='three columns')
         else if (any([(any(measurement%columns == quaternion(i)), i=1, 4)])) then
            measurement%kind = ATTITUDES
            if (size(measurement%columns) /= 4) then
               call error%raise(group%line_of('columns'), 'an attitude has four components', &
                                expected="columns = 'q0', 'q1', 'q2', 'q3'")
            else if (any(measurement%columns /= quaternion)) then
               call error%raise(group%line_of('columns'), 'an attitude has other columns', &
                                expected="columns = 'q0', 'q1', 'q2', 'q3'")
            end if
         else
            call find_columns()
         end if
      end subroutine find_kind

      !> Finds the columns in the sets of a history.
      subroutine find_columns()
         type(columns_t) :: columns
         type(status_t) :: status
         character(len=longest_name), allocatable :: headers(:)
         character(len=24), allocatable :: sets(:)
         integer :: i, at
         allocate (sets(0), measurement%places(size(measurement%columns)), &
                   measurement%turns(size(measurement%columns)))
         measurement%turns = 0.0_wp
         measurement%degrees = any([(index(measurement%columns(i), degree_mark) > 0, i=1, size(measurement%columns))])
         do i = 1, size(measurement%columns)
            at = find_quantity(base_name(measurement%columns(i)), AS_MEASUREMENT)
            if (at == 0) then
               call reject(measurement%columns(i))
               return
            end if
            if (.not. any(sets == set_of(quantities(at)))) sets = [sets, set_of(quantities(at))]
            if (any(quantities(at)%kind == [Q_EULER, Q_ROLL_PITCH_YAW])) &
               measurement%turns(i) = merge(360.0_wp, 2*pi, measurement%degrees)
         end do
         measurement%sets = sets
         call columns%choose(sets, status, measurement%degrees, effects)
         if (.not. status%ok()) then
            call error%raise_status(group%line_of('columns'), status)
            return
         end if
         headers = [character(len=longest_name) :: split_list(columns%header())]
         do i = 1, size(measurement%columns)
            measurement%places(i) = findloc(headers, measurement%columns(i), dim=1)
            if (measurement%places(i) > 0) cycle
            call error%raise(group%line_of('columns'), quoted(trim(measurement%columns(i)))//' has another unit', &
                             expected='angles and rates all in degrees, NAME_deg, or all in radians')
            return
         end do
      end subroutine find_columns

      !> Raises an error for a column that cannot be fitted, with the reason.
      subroutine reject(name)
         character(len=*), intent(in) :: name
         integer :: at
         at = find_quantity(base_name(name))
         if (at > 0) then
            call error%raise(group%line_of('columns'), quoted(trim(name))//' cannot be fitted: it '// &
                             reason_of(quantities(at), AS_MEASUREMENT), &
                             expected="attitude or momentum, such as 'omega1' or 'q0', 'q1', 'q2', 'q3'")
         else
            call error%raise(group%line_of('columns'), quoted(trim(name))//' is not a column that can be fitted', &
                             expected="columns of attitude and momentum, such as 'omega1', 'phi_deg' or "// &
                             "'q0', 'q1', 'q2', 'q3'", &
                             nearest=nearest_name(trim(name), split_list(names_for(AS_MEASUREMENT))))
         end if
      end subroutine reject

      !> Reads standard deviations, bias and loss.
      subroutine read_statistics()
         integer :: n
         n = measurement%width()
         measurement%sigma = spread(1.0_wp, 1, n)
         measurement%sigma_is_known = group%has('sigma')
         select case (group%count_of('sigma'))
         case (0)
            continue
         case (1)
            measurement%sigma = spread(group%number('sigma', 1.0_wp), 1, n)
         case default
            if (group%count_of('sigma') == n) then
               measurement%sigma = group%vector('sigma', measurement%sigma)
            else
               call error%raise(group%line_of('sigma'), 'sigma has the wrong number of values', &
                                expected='one, or one for each column, for an attitude three about the body axes')
            end if
         end select
         measurement%has_bias = group%text('bias', 'none') == 'constant'
         if (measurement%has_bias .and. measurement%kind /= VALUES) &
            call error%raise(group%line_of('bias'), 'attitudes and directions have no bias', &
                             expected="bias with columns such as 'omega1'")
         measurement%loss = findloc(losses, group%text('loss', 'linear'), dim=1)
      end subroutine read_statistics

      !> Reads the file of measurements.
      subroutine read_file()
         character(len=:), allocatable :: text, problem
         integer, allocatable :: fields(:)
         real(wp), allocatable :: factors(:)
         integer :: position, i
         call read_named_file(group, 'file', scene, 'a CSV file or an AEM', measurement%file, text, error)
         if (error%raised) return
         if (is_message(text)) then
            call take_message(text)
            return
         end if
         position = begin_of(text)
         call read_header(text, position, fields, factors, problem)
         associate (rows => count_lines(text) - 1)
            if (problem == '' .and. rows < 1) problem = 'there are no measurements (expected one for each line)'
            if (problem /= '') then
               call error%raise_in(measurement%file, 1, problem)
               return
            end if
            allocate (measurement%times(rows), measurement%rows(size(measurement%columns), rows))
         end associate
         do i = 1, size(measurement%times)
            call read_row(text, position, fields, factors, measurement%times(i), measurement%rows(:, i), problem)
            if (problem == '') call check_row(i, problem)
            if (problem == '') cycle
            call error%raise_in(measurement%file, i + 1, problem)
            return
         end do
      end subroutine read_file

      !> Reads the records of a message.
      subroutine take_message(text)
         character(len=*), intent(in) :: text
         character(len=:), allocatable :: problem
         logical :: has_place
         integer :: i, n
         call read_message(text, measurement%file, labels, effects, measurement%columns, measurement%times, &
                           measurement%rows, problem, has_place)
         if (problem == '' .and. .not. effects%knows_space_axes() .and. measurement%kind == VALUES) &
            problem = &
               'the rates of an AEM belong to axes that do not rotate (expected attitudes where space axes rotate)'
         if (problem /= '') then
            call error%raise(group%line_of('file'), problem)
            error%elsewhere = has_place
            return
         end if
         n = size(measurement%times)
         if (measurement%kind == ATTITUDES .and. effects%knows_space_axes() .and. effects%frame_turns) then
            do i = 1, n
               measurement%rows(:, i) = quat_product(quat_conjugate(effects%space_axes(measurement%times(i))), &
                                                     measurement%rows(:, i))
            end do
         end if
         if (end_time < 0.0_wp) then
            measurement%times = measurement%times(n:1:-1)
            measurement%rows = measurement%rows(:, n:1:-1)
         end if
         do i = 1, n
            call check_row(i, problem)
            if (problem == '') cycle
            call error%raise(group%line_of('file'), 'record '//count_text(merge(i, n + 1 - i, end_time >= 0.0_wp))// &
                             ' of '//printable_path(measurement%file)//': '//problem)
            return
         end do
      end subroutine take_message

      !> Finds t and the columns in the header, with the factors that convert their units.
      subroutine read_header(text, position, fields, factors, problem)
         character(len=*), intent(in) :: text
         integer, intent(inout) :: position
         !> Number of the column of the fit in each field, -1 for t; 0: none. Shape (fields).
         integer, allocatable, intent(out) :: fields(:)
         !> Unit of each field in the unit of its column; shape (fields).
         real(wp), allocatable, intent(out) :: factors(:)
         !> Message on a wrong header; empty on success.
         character(len=:), allocatable, intent(out) :: problem
         character(len=:), allocatable :: header, unit
         character(len=longest_name) :: name
         character(len=longest_name), allocatable :: names(:)
         integer :: first, last, i
         logical :: ends
         problem = ''
         ends = .false.
         allocate (fields(0), factors(0), names(0))
         do while (.not. ends)
            call next_field(text, position, first, last, ends, problem)
            if (problem /= '') return
            call split_header(text(first:last), header, unit)
            name = header
            i = findloc(measurement%columns, name, dim=1)
            if (name == 't') i = -1
            fields = [fields, i]
            factors = [factors, factor_of(i, header, unit, problem)]
            if (i /= 0 .and. any(names == name)) problem = 'there are two columns '//quoted(trim(name))// &
               ' (expected one)'
            if (problem /= '') return
            names = [names, name]
         end do
         if (.not. any(fields == -1)) problem = "there is no column 't' (expected the time in s)"
         do i = 1, size(measurement%columns)
            if (problem == '' .and. .not. any(fields == i)) problem = 'there is no column '// &
               quoted(trim(measurement%columns(i)))//' (expected it, beside '//printable_path(comma_list(names))//')'
         end do
      end subroutine read_header

      !> Returns the unit of a field in the unit of its column; 1 without a unit.
      function factor_of(i, name, unit, problem) result(factor)
         !> Number of the column, -1 for t; 0: none.
         integer, intent(in) :: i
         character(len=*), intent(in) :: name, unit
         !> Message on a wrong unit; unchanged on success.
         character(len=:), allocatable, intent(inout) :: problem
         real(wp) :: factor
         character(len=:), allocatable :: wanted
         factor = 1.0_wp
         if (i == 0 .or. unit == '') return
         wanted = 's'
         if (i > 0) wanted = column_unit(i)
         factor = conversion(unit, wanted)
         if (factor > 0.0_wp) return
         problem = quoted(name//' ('//unit//')')//' has an unknown unit (expected '//units_of(wanted)//')'
         if (wanted == '') problem = quoted(name//' ('//unit//')')//' has a unit (expected none)'
      end function factor_of

      !> Returns the unit of a column; empty for components of attitudes and directions, which have none.
      pure function column_unit(i) result(unit)
         integer, intent(in) :: i
         character(len=:), allocatable :: unit
         integer :: at
         unit = ''
         if (measurement%kind /= VALUES) return
         at = find_quantity(base_name(measurement%columns(i)), AS_MEASUREMENT)
         unit = trim(quantities(at)%unit)
         if (measurement%degrees .and. turns_to_degrees(quantities(at))) unit = 'deg'//unit(4:)
      end function column_unit

      !> Reads a line of measurements.
      subroutine read_row(text, position, fields, factors, t, row, problem)
         character(len=*), intent(in) :: text
         integer, intent(inout) :: position
         integer, intent(in) :: fields(:)
         real(wp), intent(in) :: factors(:)
         real(wp), intent(out) :: t
         !> Measured values; shape (columns).
         real(wp), intent(out) :: row(:)
         character(len=:), allocatable, intent(out) :: problem
         real(wp) :: number
         integer :: i, first, last
         logical :: ends
         problem = ''
         t = 0.0_wp
         row = 0.0_wp
         do i = 1, size(fields)
            call next_field(text, position, first, last, ends, problem)
            if (problem == '' .and. (ends .neqv. i == size(fields))) &
               problem = 'wrong number of values in this line (expected one per column)'
            if (problem /= '') return
            if (fields(i) == 0) cycle
            call read_number(text(first:last), number, problem)
            if (problem /= '') return
            if (fields(i) < 0) t = factors(i)*number
            if (fields(i) > 0) row(fields(i)) = factors(i)*number
         end do
      end subroutine read_row

      !> Checks a row, and normalises attitudes and directions.
      subroutine check_row(i, problem)
         !> Number of the row.
         integer, intent(in) :: i
         character(len=:), allocatable, intent(inout) :: problem
         real(wp) :: sense, norm, angle
         integer :: k, at
         sense = sign(1.0_wp, end_time)
         if (sense*measurement%times(i) < 0.0_wp .or. sense*(measurement%times(i) - end_time) > 0.0_wp) then
            problem = 'the time of a measurement is outside of the run (expected times from 0 to end_time)'
            return
         end if
         if (i > 1) then
            if (sense*(measurement%times(i) - measurement%times(i - 1)) < 0.0_wp) then
               problem = 'the times of measurements are out of order (expected the order of the run)'
               return
            end if
         end if
         if (measurement%kind == VALUES) then
            do k = 1, size(measurement%columns)
               at = find_quantity(base_name(measurement%columns(k)), AS_MEASUREMENT)
               angle = measurement%rows(k, i)
               if (measurement%degrees) angle = angle*pi/180
               if (quantities(at)%is_folded .and. sin(angle) < least_sine) problem = 'the angle '// &
                  quoted(trim(measurement%columns(k)))// &
                  ' has no derivative at 0 and pi (expected at least 0.01 rad '// &
                  'from both, or an attitude, q0 to q3)'
            end do
            return
         end if
         norm = norm2(measurement%rows(:, i))
         if (abs(norm - 1) > norm_tolerance) then
            problem = 'the norm is not 1 (expected a unit quaternion, or the components of a unit vector)'
         else
            measurement%rows(:, i) = measurement%rows(:, i)/norm
         end if
      end subroutine check_row

   end subroutine build_measurement

   !> Returns the name of a column without the mark of degrees.
   pure function base_name(column) result(name)
      character(len=*), intent(in) :: column
      character(len=:), allocatable :: name
      integer :: last
      name = trim(column)
      last = len(name) - len(degree_mark)
      if (last > 0) then
         if (name(last + 1:) == degree_mark) name = name(:last)
      end if
   end function base_name

end module nutate_scene_measurement
