!> Picture of a fit, drawn by gnuplot: data and model of each measurement, and below them the residuals.
module nutate_fit_plot
   use nutate_console, only: count_text
   use nutate_decimal, only: rounded_text
   use nutate_fit, only: fit_t
   use nutate_fit_model, only: motion_at_t
   use nutate_fit_plan, only: measurement_t, ATTITUDES
   use nutate_gnuplot, only: colours, gnuplot_quoted, picture_t
   use nutate_history_plot, only: extent, tick
   use nutate_kinds, only: wp
   use nutate_plot_panels, only: panel_t, panels_of, symbol_of
   use nutate_printable, only: printable_path
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: draw_fit

   !> Number of times at which the model is drawn; most columns of a measurement that are drawn.
   integer, parameter :: curve_points = 800, most_columns = 6
   !> Heights of a panel of data, of a panel of residuals, of the title and of the time axis; gap between panels.
   integer, parameter :: data_height = 190, residual_height = 110, top = 50, bottom = 60, gap = 40

contains

   !> Draws data, model and residuals. Errors: `NUTATE_IO`, and errors of the run; no file is left then.
   subroutine draw_fit(picture, scene, fit, status)
      !> Picture, open.
      type(picture_t), intent(inout) :: picture
      type(scene_t), intent(in) :: scene
      type(fit_t), intent(inout) :: fit
      type(status_t), intent(out) :: status
      type(motion_at_t) :: motion
      real(wp) :: times(curve_points), height, upper
      integer :: i, first
      associate (last => fit%problem%times(size(fit%problem%times)))
         times = [(last*i/curve_points, i=1, curve_points)]
      end associate
      call fit%problem%model%states_at(times, motion, status)
      if (.not. status%ok()) then
         call picture%discard()
         return
      end if
      height = real(top + bottom + (data_height + residual_height)*size(fit%problem%residuals), wp)
      call picture%begin(900, nint(height))
      call picture%put('set lmargin at screen 0.11; set rmargin at screen 0.77; set tics font '',12''')
      call picture%put('set key at graph 1.02, 1 left top Left reverse samplen 1.5 font '',14''')
      call picture%put('set format y ''%.6g''; set xrange ['//extent([0.0_wp, times(curve_points)])//']')
      call picture%put('set multiplot title '//gnuplot_quoted(scene%title)//' noenhanced')
      upper = 1 - (top + 20)/height
      first = 1
      do i = 1, size(fit%problem%residuals)
         call draw_data()
         upper = upper - data_height/height
         if (i == size(fit%problem%residuals)) call picture%put('set xlabel ''t (s)''; set format x ''%g''')
         call draw_residuals(fit%problem%residuals(i)%measurement, fit%result%residuals(first:))
         upper = upper - residual_height/height
         first = first + size(fit%problem%residuals(i)%measurement%times)*fit%problem%residuals(i)%measurement%width()
      end do
      call picture%put('unset multiplot')
      call picture%draw(status)

   contains

      !> Draws the data as points and the model as lines.
      subroutine draw_data()
         real(wp), allocatable :: curves(:, :), points(:, :)
         character(len=:), allocatable :: plot, label
         character(len=7) :: paint(most_columns)
         integer :: c, n
         associate (problem => fit%problem)
            associate (measurement => problem%residuals(i)%measurement)
               n = min(size(measurement%columns), most_columns)
               call find_curves(curves)
               points = measurement%rows
               if (measurement%kind == ATTITUDES) call choose_signs(times, curves, measurement%times, points)
               do c = 1, n
                  call add_block(picture, 'm', c, times, curves(c, :), turn_of(measurement, c))
                  call add_block(picture, 'd', c, measurement%times, points(c, :), 0.0_wp)
               end do
               call find_style(measurement, label, paint)
               call begin_panel(picture, label, points(:n, :), upper, data_height, height)
               call picture%put('set format x ''''')
               plot = ''
               do c = 1, n
                  if (c > 1) plot = plot//', '
                  plot = plot//'$d'//count_text(c)//' using 1:2 with points pointtype 7 pointsize '// &
                         point_size(measurement)//' linecolor rgb '''//paint(c)//''' notitle, $m'//count_text(c)// &
                         ' using 1:2 with lines linewidth 1.2 linecolor rgb '''//paint(c)//''' title '// &
                         gnuplot_quoted(symbol_of(trim(measurement%columns(c))))
               end do
               call picture%put('plot '//plot)
            end associate
         end associate
      end subroutine draw_data

      !> Draws the residuals as points.
      subroutine draw_residuals(measurement, residuals)
         type(measurement_t), intent(in) :: measurement
         !> Residuals, beginning with the first of the measurement.
         real(wp), intent(in) :: residuals(:)
         character(len=:), allocatable :: plot, name, label
         character(len=7) :: paint(most_columns)
         integer :: c, width
         width = measurement%width()
         call find_style(measurement, label, paint)
         ! The rotation about axis 1 has the colour of q1.
         if (measurement%kind == ATTITUDES) paint = cshift(paint, 1)
         plot = ''
         do c = 1, min(width, most_columns)
            call add_block(picture, 'r', c, measurement%times, residuals(c:width*size(measurement%times):width), 0.0_wp)
            name = symbol_of(trim(measurement%columns(c)))
            if (measurement%kind == ATTITUDES) name = 'rotation '//count_text(c)
            if (c > 1) plot = plot//', '
            plot = plot//'$r'//count_text(c)//' using 1:2 with points pointtype 7 pointsize '// &
               point_size(measurement)// &
                   ' linecolor rgb '''//paint(c)//''' title '//gnuplot_quoted(name)
         end do
         label = 'residuals'
         if (measurement%sigma_is_known) label = 'residuals (standard deviations)'
         call begin_panel(picture, label, reshape(residuals(:width*size(measurement%times)), &
                          [width, size(measurement%times)]), upper, residual_height, height)
         call picture%put('plot '//plot)
      end subroutine draw_residuals

      !> Finds the columns of the model at the times of the curve, with their biases; shape (columns, times).
      subroutine find_curves(curves)
         real(wp), allocatable, intent(out) :: curves(:, :)
         type(system_t) :: system
         integer :: k, bias
         bias = fit%problem%n_free
         do k = 1, i - 1
            if (fit%problem%residuals(k)%measurement%has_bias) bias = bias + &
               fit%problem%residuals(k)%measurement%width()
         end do
         associate (residuals => fit%problem%residuals(i))
            allocate (curves(size(residuals%measurement%columns), size(motion%states)))
            system = fit%problem%model%scene%system
            do k = 1, size(motion%states)
               call motion%switches(k)%apply(system%effects)
               curves(:, k) = residuals%model(system, motion%states(k))
               if (residuals%measurement%has_bias) curves(:, k) = curves(:, k) + fit%result%x(bias + 1:bias + &
                  size(curves, 1))
            end do
         end associate
      end subroutine find_curves

   end subroutine draw_fit

   !> Begins a panel.
   subroutine begin_panel(picture, label, values, upper, panel, height)
      type(picture_t), intent(inout) :: picture
      character(len=*), intent(in) :: label
      !> Values that the panel shows.
      real(wp), intent(in) :: values(:, :)
      !> Upper end of the panel, from 0 to 1; heights of the panel and of the picture.
      real(wp), intent(in) :: upper
      integer, intent(in) :: panel
      real(wp), intent(in) :: height
      call picture%put('set tmargin at screen '//rounded_text(upper, 4)//'; set bmargin at screen '// &
                       rounded_text(upper - (panel - gap)/height, 4))
      call picture%put('set ytics '//rounded_text(tick(values), 2))
      call picture%put('set label 1 '//gnuplot_quoted(label)//' at graph 0, 1 left offset 0, 0.7 noenhanced')
   end subroutine begin_panel

   !> Finds the label of a panel of data, with the unit if all columns have the same, and the colours of its columns, as
   !> in pictures of histories.
   subroutine find_style(measurement, label, paint)
      type(measurement_t), intent(in) :: measurement
      character(len=:), allocatable, intent(out) :: label
      character(len=7), intent(out) :: paint(most_columns)
      type(panel_t), allocatable :: panels(:)
      integer :: n
      label = printable_path(measurement%file)//', and the model'
      paint = colours(:most_columns)
      n = min(size(measurement%columns), most_columns)
      panels = panels_of([character(len=len(measurement%columns)) :: 't', measurement%columns(:n)])
      if (size(panels) /= 1) return
      label = trim(panels(1)%label)//': '//label
      paint(:n) = panels(1)%colours
   end subroutine find_style

   !> Chooses, of the two quaternions of each attitude, the one near the curve.
   pure subroutine choose_signs(times, curves, measured_times, points)
      real(wp), intent(in) :: times(:), curves(:, :), measured_times(:)
      real(wp), intent(inout) :: points(:, :)
      integer :: k, near
      do k = 1, size(points, 2)
         near = minloc(abs(times - measured_times(k)), dim=1)
         if (dot_product(points(:, k), curves(:, near)) < 0.0_wp) points(:, k) = -points(:, k)
      end do
   end subroutine choose_signs

   !> Returns one revolution, in the unit of the column, if the column is known only modulo revolutions; else 0.
   pure real(wp) function turn_of(measurement, c)
      type(measurement_t), intent(in) :: measurement
      integer, intent(in) :: c
      turn_of = 0.0_wp
      if (allocated(measurement%turns)) turn_of = measurement%turns(c)
   end function turn_of

   !> Returns the size of the points, small if there are many.
   pure function point_size(measurement) result(text)
      type(measurement_t), intent(in) :: measurement
      character(len=:), allocatable :: text
      text = trim(merge('0.3', '0.8', size(measurement%times) > 60))
   end function point_size

   !> Adds a block of data. A line is broken where an angle goes over to the other end of its range.
   subroutine add_block(picture, name, c, times, values, turn)
      type(picture_t), intent(inout) :: picture
      !> Name of the block; the number of the column is appended to it.
      character(len=*), intent(in) :: name
      integer, intent(in) :: c
      real(wp), intent(in) :: times(:), values(:)
      real(wp), intent(in) :: turn
      integer :: k
      call picture%put('$'//name//count_text(c)//' << EOD')
      do k = 1, size(times)
         if (k > 1 .and. turn > 0.0_wp) then
            if (abs(values(k) - values(max(k - 1, 1))) > 0.5_wp*turn) call picture%put('')
         end if
         call picture%put(rounded_text(times(k), 9)//' '//rounded_text(values(k), 7))
      end do
      call picture%put('EOD')
   end subroutine add_block

end module nutate_fit_plot
