!> The picture of a history, drawn by gnuplot: a panel for each quantity.
module nutate_history_plot
   use nutate_console, only: count_text
   use nutate_decimal, only: rounded_text
   use nutate_gnuplot, only: picture_t, gnuplot_quoted
   use nutate_history_reading, only: recorded_t
   use nutate_kinds, only: wp, long, pi
   use nutate_plot_panels, only: panel_t, panels_of, is_wrapped
   use nutate_status, only: status_t
   implicit none
   private

   public :: draw_history, tick

   !> Histories of more rows are drawn by the least and the greatest value in each of half as many intervals.
   integer, parameter :: most_points = 1200
   !> Heights of a panel, of the title and of the time axis.
   integer, parameter :: panel_height = 150, top = 50, bottom = 60

contains

   !> Draws all columns of a history. Errors: `NUTATE_IO`; no file is left then.
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
      call picture%put('set lmargin at screen 0.11; set rmargin at screen 0.77; set tics font '',12''')
      call picture%put('set key at graph 1.02, 1 left top Left reverse samplen 1.5 font '',12'' noenhanced')
      call picture%put('set format y ''%.6g''; set xrange ['//extent(history%values(:, 1))//']')
      call picture%put('set multiplot title '//gnuplot_quoted(title)//' noenhanced')
      do i = 1, size(panels)
         call add_data(picture, history, panels(i))
         upper = 1 - (top + 20 + panel_height*(i - 1))/height
         call picture%put('set tmargin at screen '//rounded_text(upper, 4)//'; set bmargin at screen '// &
                          rounded_text(upper - (panel_height - 40)/height, 4))
         if (i == size(panels)) call picture%put('set xlabel ''t (s)''; set format x ''%g''')
         if (i < size(panels)) call picture%put('set format x ''''')
         call picture%put('set ytics '//rounded_text(tick(history%values(:, panels(i)%columns)), 2))
         ! The label is above its panel, where the axis has no numbers.
         call picture%put('set label 1 '//gnuplot_quoted(trim(panels(i)%label))// &
                          ' at graph 0, 1 left offset 0, 0.7 noenhanced')
         call picture%put('plot '//curves_text(panels(i), history%names))
      end do
      call picture%put('unset multiplot')
      call picture%draw(status)
   end subroutine draw_history

   !> Returns the range of the time axis, from the least to the greatest time.
   pure function extent(t) result(text)
      !> Times, s.
      real(wp), intent(in) :: t(:)
      character(len=:), allocatable :: text
      text = rounded_text(minval(t), 9)//':'//rounded_text(maxval(t), 9)
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
      tick = power*merge(merge(2, 5, span/power <= 8), 10, span/power <= 20)
   end function tick

   !> Returns the curves of a panel, for the command `plot` of gnuplot.
   function curves_text(panel, names) result(text)
      type(panel_t), intent(in) :: panel
      character(len=*), intent(in) :: names(:)
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(panel%columns)
         if (i > 1) text = text//', '
         text = text//'$c'//count_text(int(i, long))//' using 1:2 with lines linewidth 1.4 linecolor rgb '''// &
                panel%colours(i)//''' title '//gnuplot_quoted(trim(names(panel%columns(i))))
      end do
   end function curves_text

   !> Adds the curves of a panel as blocks of data.
   subroutine add_data(picture, history, panel)
      type(picture_t), intent(inout) :: picture
      type(recorded_t), intent(in) :: history
      type(panel_t), intent(in) :: panel
      integer :: i
      do i = 1, size(panel%columns)
         call picture%put('$c'//count_text(int(i, long))//' << EOD')
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
            call picture%put(rounded_text(t(ends(e)), 9)//' '//rounded_text(before, 7))
         end do
      end do
   end subroutine add_points

end module nutate_history_plot
