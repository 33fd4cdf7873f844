!> The picture of a history: reads its file, and draws a panel for each quantity by gnuplot.
module nutate_history_plot
   use, intrinsic :: iso_c_binding, only: c_null_char
   use nutate_console, only: count_text
   use nutate_decimal, only: rounded_text
   use nutate_file_calls, only: file_kind, file_readable, KIND_REGULAR
   use nutate_cli, only: did_you_mean
   use nutate_gnuplot, only: gnuplot_quoted, picture_t
   use nutate_kinds, only: long, pi, wp
   use nutate_number_text, only: read_real
   use nutate_plot_panels, only: is_wrapped, label_of_column, panel_t, panels_of, symbol_of
   use nutate_printable, only: printable_path, quoted
   use nutate_run_watcher, only: caught_signal, signal_name
   use nutate_scene_table, only: begin_of, next_field
   use nutate_status, only: status_t
   use nutate_system_text, only: error_text
   use nutate_table_units, only: conversion, split_header, units_of
   implicit none
   private

   public :: recorded_t, read_history, read_names, name_length, draw_history, draw_xy, extent, tick

   !> Longest line of a history, and longest name of a column.
   integer, parameter :: line_length = 16384, name_length = 112

   !> Times up to this are converted, s.
   real(wp), parameter :: greatest_time = 1e100_wp

   !> Columns of a history.
   type :: recorded_t
      !> Names of the columns, `t` first; shape (number of columns).
      character(len=name_length), allocatable :: names(:)
      !> Values of the columns; shape (rows, columns).
      real(wp), allocatable :: values(:, :)
   end type recorded_t

   !> Histories of more rows are drawn by the least and the greatest value in each of half as many intervals.
   integer, parameter :: most_points = 1200
   !> Heights of a panel, of the title and of the time axis.
   integer, parameter :: panel_height = 150, top = 50, bottom = 60
   !> Longest title, bytes, that fits into a line with the titles of the panels.
   integer, parameter :: longest_title = 105
   !> Significant digits of drawn values; those of times are all kept.
   integer, parameter :: digits = 11
   !> Extent of a panel relative to its values, and in its unit, up to which it is drawn as constant.
   real(wp), parameter :: same = 1e-9_wp, least_span = 1e-280_wp
   !> Extent of a panel below which angles are not magnified, rad.
   real(wp), parameter :: least_angle = 0.1_wp
   !> Width of a letter in a legend, as a fraction of the width of the picture; greatest in PNG and PDF.
   real(wp), parameter :: width_of_a_letter = 0.0115_wp
   !> Width of a line as a fraction of the height of a panel.
   real(wp), parameter :: width_of_a_line = 0.012_wp

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
      character(len=:), allocatable :: name, time_unit
      real(wp) :: second
      integer :: unit, fields, i
      call open_history(path, unit, line, problem)
      if (problem /= '') return
      close (unit)
      call read_header(trim(line), names, places, fields, second)
      if (size(places) == 0) then
         problem = printable_path(path)//':1: not a history (expected a first line t,...)'
      else if (.not. second > 0.0_wp) then
         problem = printable_path(path)//':1: t has an unknown unit (expected '//units_of('s')//')'
      end if
      do i = 2, size(names)
         call split_header(trim(names(i)), name, time_unit)
         if (name == 't') names(i) = name
         if (problem == '' .and. names(i) /= '' .and. any(names(:i - 1) == names(i))) &
            problem = printable_path(path)//':1: there are two columns '//quoted(trim(names(i)))//' (expected one)'
      end do
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
      if (iostat == 0 .and. file_kind(path//c_null_char) /= KIND_REGULAR) then
         problem = printable_path(path)//': cannot be read twice (expected a file, no pipe)'
         return
      end if
      if (iostat == 0) open (newunit=unit, file=path, status='old', action='read', iostat=iostat, iomsg=why)
      if (iostat == 0) read (unit, '(a)', iostat=iostat, iomsg=why) line
      if (is_iostat_end(iostat)) then
         ! An empty file is no history.
         line = ''
         return
      end if
      if (iostat == 0) then
         line = line(begin_of(line):)
         return
      end if
      if (did_you_mean(path, '.csv') /= '') why = 'there is no such file; '//did_you_mean(path, '.csv')
      problem = printable_path(path)//': cannot be read ('//trim(why)//')'
   end subroutine open_history

   !> Reads `t`, in seconds, and the wanted columns.
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
      real(wp) :: second
      integer :: unit, iostat, fields

      call open_history(path, unit, line, problem)
      if (problem /= '') return
      call read_header(trim(line), history%names, places, fields, second, wanted)
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
      associate (t => history%values(:, 1))
         ! Others are rejected, and would overflow.
         where (abs(t) < greatest_time) t = second*t
      end associate
   end subroutine read_history

   !> Finds `t` and the wanted columns in the first line; none if the line is not that of a history.
   pure subroutine read_header(line, names, places, fields, second, wanted)
      character(len=*), intent(in) :: line
      character(len=name_length), allocatable, intent(out) :: names(:)
      !> Positions of the fields of a row that are read; shape (number of names).
      integer, allocatable, intent(out) :: places(:)
      !> Number of fields in a row.
      integer, intent(out) :: fields
      !> Unit of `t`, s; 0 if it is unknown.
      real(wp), intent(out) :: second
      !> Names of the wanted columns; default: all.
      character(len=*), intent(in), optional :: wanted(:)
      character(len=name_length) :: name
      character(len=:), allocatable :: problem, header, unit
      integer :: position, first, last
      logical :: ends
      allocate (names(0), places(0))
      fields = 0
      second = 1.0_wp
      position = 1
      ends = .false.
      problem = ''
      do while (.not. ends)
         call next_field(line, position, first, last, ends, problem)
         fields = fields + 1
         name = line(first:last)
         if (fields == 1) then
            call split_header(line(first:last), header, unit)
            name = header
            if (unit /= '') second = conversion(unit, 's')
         end if
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
         if (caught_signal() /= 0) problem = 'stopped by '//signal_name()
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
         problem = count_text(field)//' fields (expected '//count_text(fields)//')'
      else if (field > fields) then
         problem = 'more than '//count_text(fields)//' fields'
      end if
   end subroutine read_row

   !> Draws all columns of a history over the time. Errors: `NUTATE_IO`; no file is left then.
   subroutine draw_history(picture, title, history, status)
      !> Picture, open.
      type(picture_t), intent(inout) :: picture
      character(len=*), intent(in) :: title
      type(recorded_t), intent(in) :: history
      type(status_t), intent(out) :: status
      type(panel_t), allocatable :: panels(:)
      real(wp) :: height, upper
      integer :: i
      panels = panels_of(history%names)
      height = real(top + bottom + panel_height*size(panels), wp)
      call picture%begin(900, nint(height))
      call picture%put('set lmargin at screen 0.11; set rmargin at screen '// &
                       rounded_text(right_edge(history%names), 4)//'; set tics font '',12''')
      call picture%put('set key at graph 1.02, 1 left top Left reverse samplen 2 spacing 0.85 font '',14''')
      call picture%put('set xrange ['//extent(history%values(:, 1))//']')
      call picture%put('set multiplot title '//gnuplot_quoted(title//contents_of(title, panels))//' noenhanced')
      do i = 1, size(panels)
         call add_data(picture, history, panels(i))
         upper = 1 - (top + 20 + panel_height*(i - 1))/height
         call picture%put('set tmargin at screen '//rounded_text(upper, 4)//'; set bmargin at screen '// &
                          rounded_text(upper - (panel_height - 40)/height, 4))
         if (i == size(panels)) call picture%put('set xlabel ''t (s)''; set format x ''%.12g''')
         if (i < size(panels)) call picture%put('set format x ''''')
         call put_range(picture, panels(i)%label, history%values(:, panels(i)%columns))
         ! The label is above its panel, where the axis has no numbers.
         call picture%put('set label 1 '//gnuplot_quoted(trim(panels(i)%label))// &
                          ' at graph 0, 1 left offset 0, 0.7 noenhanced')
         call picture%put('plot '//curves_text(panels(i), history))
      end do
      call picture%put('unset multiplot')
      call picture%draw(status)
   end subroutine draw_history

   !> Returns the right end of the panels, as a fraction of the width, so that the longest symbol fits beside them.
   pure real(wp) function right_edge(names)
      !> Names of the columns, `t` first.
      character(len=*), intent(in) :: names(:)
      integer :: i
      right_edge = 0.81_wp - width_of_a_letter*max(0, maxval([(len(symbol_of(trim(names(i)))), i=2, size(names))]) - 13)
   end function right_edge

   !> Returns the titles of the panels, to be added to the title of the picture; empty if they do not fit into its line.
   pure function contents_of(title, panels) result(text)
      character(len=*), intent(in) :: title
      type(panel_t), intent(in) :: panels(:)
      character(len=:), allocatable :: text
      integer :: i, unit
      text = ''
      do i = 1, size(panels)
         if (any(panels(:i - 1)%label == panels(i)%label)) cycle
         unit = index(panels(i)%label, ' (')
         if (unit == 0) unit = len_trim(panels(i)%label) + 1
         text = text//merge(': ', ', ', i == 1)//panels(i)%label(:unit - 1)
      end do
      if (len(title) + len(text) > longest_title) text = ''
   end function contents_of

   !> Sets range and numbers of the vertical axis. Angles that hardly change are not magnified.
   subroutine put_range(picture, label, values)
      type(picture_t), intent(inout) :: picture
      !> Title of the panel, with its unit.
      character(len=*), intent(in) :: label
      !> Values of the panel; shape (rows, curves).
      real(wp), intent(in) :: values(:, :)
      real(wp) :: least, ends(2), largest, half, span
      least = 0.0_wp
      if (index(label, '(rad)') > 0) least = least_angle
      if (index(label, '(°)') > 0) least = least_angle*180/pi
      ends = [minval(values), maxval(values)]
      largest = maxval(abs(ends))
      span = ends(2) - ends(1)
      half = 0.0_wp
      if (span < least .and. span < 0.1_wp*largest) then
         half = least/2
      else if (span <= same*largest .or. span < least_span) then
         half = merge(1.0_wp, 0.01_wp*largest, largest < least_span)
      end if
      if (half > 0.0_wp) then
         ends = sum(ends)/2 + [-half, half]
         call picture%put('set yrange ['//rounded_text(ends(1), 16)//':'//rounded_text(ends(2), 16)//']')
      else
         call picture%put('set yrange [*:*] noextend; set offsets 0, 0, graph 0.04, graph 0.04')
      end if
      span = tick(reshape(ends, [2, 1]))
      call picture%put('set ytics '//rounded_text(span, 2)//'; set format y ''%.'// &
                       count_text(max(6, 2 + floor(log10(maxval(abs(ends))/span))))//'g''')
   end subroutine put_range

   !> Draws one column against another. Errors: `NUTATE_IO`; no file is left then.
   subroutine draw_xy(picture, title, history, is_path, status)
      !> Picture, open.
      type(picture_t), intent(inout) :: picture
      character(len=*), intent(in) :: title
      !> History with the columns t, x and y.
      type(recorded_t), intent(in) :: history
      !> True for the path of an axis on the unit sphere, from above: x and y are components along space axes.
      logical, intent(in) :: is_path
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: labels(:)
      real(wp) :: jumps(2)
      integer :: i
      jumps = [jump(trim(history%names(2))), jump(trim(history%names(3)))]
      labels = [character(len=96) :: axis_label(history%names(2)), axis_label(history%names(3))]
      if (is_path) labels = [character(len=96) :: 'x (space axes)', 'y (space axes)']
      call picture%begin(720, 720)
      call picture%put('set title '//gnuplot_quoted(title)//' noenhanced offset 0, 1')
      call picture%put('set format ''%.10g''; set tics font '',12''')
      do i = 1, 2
         call picture%put('set '//achar(iachar('x') + i - 1)//'label '//gnuplot_quoted(trim(labels(i))))
      end do
      ! Lengths in both directions compare if the unit is the same.
      if (is_path .or. unit_of(labels(1)) == unit_of(labels(2))) call picture%put('set size ratio -1')
      call picture%put('set offsets graph 0.03, graph 0.03, graph 0.03, graph 0.03; set autoscale noextend')
      call picture%put('set key at graph 1, 1.01 right bottom horizontal font '',13''; set rmargin 4; set tmargin 5')
      call picture%put('$c << EOD')
      do i = 1, size(history%values, 1)
         if (i > 1) then
            if (any(abs(history%values(i, 2:) - history%values(i - 1, 2:)) > jumps)) call picture%put('')
         end if
         call picture%put(rounded_text(history%values(i, 2), digits)//' '// &
                         rounded_text(history%values(i, 3), digits))
      end do
      call picture%put('EOD')
      call picture%put('$e << EOD')
      do i = 1, size(history%values, 1), max(size(history%values, 1) - 1, 1)
         call picture%put(rounded_text(history%values(i, 2), digits)//' '// &
                         rounded_text(history%values(i, 3), digits))
      end do
      call picture%put('EOD')
      call picture%put('plot $c using 1:2 with lines linewidth 1.4 linecolor rgb ''#0b3c5d'' notitle, '// &
                       end_text(1, '#009e73', history%values(1, 1))//', '// &
                       end_text(2, '#d55e00', history%values(size(history%values, 1), 1)))
      call picture%draw(status)
   end subroutine draw_xy

   !> Returns the point at an end of a path, for the command `plot` of gnuplot.
   pure function end_text(which, colour, t) result(text)
      !> 1: the start, 2: the end.
      integer, intent(in) :: which
      character(len=*), intent(in) :: colour
      !> Time, s.
      real(wp), intent(in) :: t
      character(len=:), allocatable :: text, row
      row = count_text(which - 1)
      text = '$e every ::'//row//'::'//row//' using 1:2 with points pointtype 7 pointsize 1.2 linecolor rgb '''// &
             colour//''' title ''t = '//rounded_text(t, 6)//' s'''
   end function end_text

   !> Returns the label of an axis: symbol and unit of a column.
   pure function axis_label(name) result(label)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: label
      label = symbol_of(trim(name))
      if (unit_of(label_of_column(name)) /= '') label = label//' '//unit_of(label_of_column(name))
   end function axis_label

   !> Returns the unit at the end of a label, in parentheses; empty if there is none.
   pure function unit_of(label) result(unit)
      character(len=*), intent(in) :: label
      character(len=:), allocatable :: unit
      unit = ''
      if (index(label, ' (') > 0) unit = trim(label(index(label, ' (', back=.true.) + 1:))
   end function unit_of

   !> Returns the range of the time axis, from the least to the greatest time.
   pure function extent(t) result(text)
      !> Times, s.
      real(wp), intent(in) :: t(:)
      character(len=:), allocatable :: text
      text = rounded_text(minval(t), 16)//':'//rounded_text(maxval(t), 16)
   end function extent

   !> Returns the distance of the numbers of an axis: 1, 2 or 5 times a power of ten, about a quarter of the span of the
   !> values.
   pure real(wp) function tick(values)
      real(wp), intent(in) :: values(:, :)
      real(wp) :: span, power
      span = maxval(values) - minval(values)
      ! gnuplot widens a range without extent in the same way.
      if (span <= 0.0_wp) span = merge(2.0_wp, 0.02_wp*abs(maxval(values)), abs(maxval(values)) <= 0.0_wp)
      power = 10.0_wp**floor(log10(span/4))
      ! Two multiples of the distance at least lie within the span.
      tick = power*merge(merge(2, 5, span/power < 9.9_wp), 10, span/power <= 20)
   end function tick

   !> Returns the curves of a panel, for the command `plot` of gnuplot. A curve that coincides with others is dashed, so
   !> that these are seen below it.
   function curves_text(panel, history) result(text)
      type(panel_t), intent(in) :: panel
      type(recorded_t), intent(in) :: history
      character(len=:), allocatable :: text
      integer :: i, k, below
      text = ''
      do i = 1, size(panel%columns)
         associate (curves => history%values(:, panel%columns))
            below = count([(coincide(curves(:, k), curves(:, i), maxval(curves) - minval(curves)), k=1, i - 1)])
         end associate
         if (i > 1) text = text//', '
         text = text//'$c'//count_text(i)//' using 1:2 with lines linewidth 1.4 dashtype '// &
                count_text(1_long + min(below, 3))//' linecolor rgb '''//panel%colours(i)//''' title '// &
                gnuplot_quoted(symbol_of(trim(history%names(panel%columns(i)))))
      end do
   end function curves_text

   !> Returns true for two curves that coincide in half of the rows or more.
   pure logical function coincide(one, other, span)
      real(wp), intent(in) :: one(:), other(:)
      !> Extent of the panel.
      real(wp), intent(in) :: span
      coincide = count(abs(one - other) <= width_of_a_line*span) >= 0.5_wp*size(one)
   end function coincide

   !> Adds the curves of a panel as blocks of data.
   subroutine add_data(picture, history, panel)
      type(picture_t), intent(inout) :: picture
      type(recorded_t), intent(in) :: history
      type(panel_t), intent(in) :: panel
      integer :: i
      do i = 1, size(panel%columns)
         call picture%put('$c'//count_text(i)//' << EOD')
         call add_points(picture, history%values(:, 1), history%values(:, panel%columns(i)), &
                         jump(trim(history%names(panel%columns(i)))))
         call picture%put('EOD')
      end do
   end subroutine add_data

   !> Returns the change between rows that breaks a curve: three quarters of a revolution for an angle that wraps.
   pure real(wp) function jump(name)
      character(len=*), intent(in) :: name
      jump = huge(1.0_wp)
      if (is_wrapped(name)) jump = merge(270.0_wp, 1.5_wp*pi, index(name, '_deg') > 0)
   end function jump

   !> Adds the points of a curve, thinned if there are many.
   subroutine add_points(picture, t, y, jump)
      type(picture_t), intent(inout) :: picture
      !> Times, s, and values; same shape.
      real(wp), intent(in) :: t(:), y(:)
      !> Change above which the line is broken.
      real(wp), intent(in) :: jump
      integer :: i, bins, first, last, ends(2), e
      real(wp) :: before
      bins = size(t)
      if (size(t) > most_points) bins = most_points/2
      if (size(t) > 0) before = y(1)
      do i = 1, bins
         first = 1 + int(int(i - 1, long)*size(t)/bins)
         last = int(int(i, long)*size(t)/bins)
         ends = first - 1 + [minloc(y(first:last), dim=1), maxloc(y(first:last), dim=1)]
         ends = [minval(ends), maxval(ends)]
         do e = 1, merge(1, 2, ends(1) == ends(2))
            if (abs(y(ends(e)) - before) > jump) call picture%put('')
            before = y(ends(e))
            call picture%put(rounded_text(t(ends(e)), 16)//' '//rounded_text(before, digits))
         end do
      end do
   end subroutine add_points

end module nutate_history_plot
