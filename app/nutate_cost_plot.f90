!> A work-precision diagram, drawn by gnuplot: attitude error and energy residual against time.
module nutate_cost_plot
   use nutate_console, only: count_text
   use nutate_cost_files, only: discard_file
   use nutate_cost_names, only: hopeless, short_label
   use nutate_decimal, only: rounded_text
   use nutate_files, only: output_file_t
   use nutate_kinds, only: wp, long
   use nutate_methods, only: family_of, methods
   use nutate_status, only: status_t, fail, NUTATE_IO
   use nutate_work_point, only: work_point_t
   use nutate_work_precision, only: work_precision_t
   implicit none
   private

   public :: cost_plot_t, gnuplot_is_here

   !> Colours that differ for every kind of colour vision, one for each method and order.
   character(len=7), parameter :: colours(10) = ['#d55e00', '#e69f00', '#009e73', '#0b3c5d', '#56b4e9', '#cc79a7', &
                                                '#666666', '#000000', '#8c510a', '#66a61e']
   !> Errors are drawn no lower than here, below ε: zero has no logarithm.
   real(wp), parameter :: lowest = 1e-17_wp
   !> Lines of the script that do not depend on the runs.
   character(len=*), parameter :: head(*) = [character(len=96) :: &
      'set encoding utf8', &
      'set output ARG1', &
      'set border 3 linecolor rgb ''#444444''', &
      'set tics nomirror out scale 0.6', &
      'set grid linecolor rgb ''#dddddd'' linewidth 1 linetype 1', &
      'set logscale xy', &
      'set format ''10^{%T}''', &
      'set lmargin at screen 0.12', &
      'set rmargin at screen 0.73']

   !> A picture under way: its file and the script that draws it, both under partial names.
   type :: cost_plot_t
      type(output_file_t), private :: picture, script
      !> The picture is an SVG, not a PNG.
      logical, private :: is_svg = .true.
   contains
      !> Claims the files.
      procedure :: open
      !> Draws.
      procedure :: draw
      !> Gives the files up.
      procedure :: discard
   end type cost_plot_t

contains

   !> True if gnuplot can be started.
   logical function gnuplot_is_here()
      integer :: exit_status, command_status
      call execute_command_line('command -v gnuplot >/dev/null 2>&1', exitstat=exit_status, cmdstat=command_status)
      gnuplot_is_here = exit_status == 0 .and. command_status == 0
   end function gnuplot_is_here

   !> Claims the files. Errors: `NUTATE_IO`.
   subroutine open(self, name, status)
      class(cost_plot_t), intent(inout) :: self
      !> Ends in `.svg` or `.png`.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      self%is_svg = name(len(name) - 3:) == '.svg'
      call self%picture%open(name, status)
      if (.not. status%ok()) return
      ! As long as the picture's name, which may be as long as names can be.
      call self%script%open(name(1:len(name) - 4)//'.gp'//name(len(name) - 2:len(name) - 2), status)
      if (.not. status%ok()) call discard_file(self%picture)
   end subroutine open

   !> Draws the runs. Errors: `NUTATE_IO`; nothing is left then.
   subroutine draw(self, title, study, status)
      class(cost_plot_t), intent(inout) :: self
      character(len=*), intent(in) :: title
      type(work_precision_t), intent(in) :: study
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: target
      integer :: exit_status, command_status

      call write_script(self%script, self%is_svg, title, study, status)
      if (status%ok()) call self%script%flush(status)
      if (status%ok()) then
         target = self%picture%name
         if (allocated(self%picture%partial)) target = self%picture%partial
         call execute_command_line('gnuplot -c '//shell_quoted(self%script%partial)//' '//shell_quoted(target)// &
                                   ' >/dev/null 2>&1', exitstat=exit_status, cmdstat=command_status)
         if (exit_status /= 0 .or. command_status /= 0) status = fail(NUTATE_IO, 'gnuplot failed to draw it')
      end if
      call discard_file(self%script)
      if (status%ok()) then
         call self%picture%finish(status)
      else
         call discard_file(self%picture)
      end if
   end subroutine draw

   !> Gives the files up.
   subroutine discard(self)
      class(cost_plot_t), intent(inout) :: self
      call discard_file(self%script)
      call discard_file(self%picture)
   end subroutine discard

   !> Writes what gnuplot is to do, the data included. Errors: `NUTATE_IO`.
   subroutine write_script(script, is_svg, title, study, status)
      type(output_file_t), intent(inout) :: script
      logical, intent(in) :: is_svg
      character(len=*), intent(in) :: title
      type(work_precision_t), intent(in) :: study
      type(status_t), intent(out) :: status
      integer :: i
      call add_terminal(script, is_svg, status)
      do i = 1, size(head)
         if (status%ok()) call script%put_line(trim(head(i)), status)
      end do
      if (status%ok()) call add_data(script, study, status)
      if (status%ok()) call script%put_line('set xrange ['//power_text(minval(study%points%seconds), 0)//':'// &
                                            power_text(maxval(study%points%seconds), 1)//']', status)
      if (status%ok()) call script%put_line('set multiplot title '//gnuplot_quoted(title)//' noenhanced', status)
      if (status%ok() .and. study%reference%known()) call add_panel(script, study, 'attitude', status)
      if (status%ok()) call add_panel(script, study, 'energy', status)
      if (status%ok()) call script%put_line('unset multiplot', status)
   end subroutine write_script

   subroutine add_terminal(script, is_svg, status)
      type(output_file_t), intent(inout) :: script
      logical, intent(in) :: is_svg
      type(status_t), intent(out) :: status
      character(len=*), parameter :: svg = &
         'set terminal svg size 900,860 fixed name ''cost'' font ''Helvetica,Arial,sans-serif,15'' '// &
         'background ''#ffffff'''
      character(len=*), parameter :: png = &
         'if (strstrt(GPVAL_TERMINALS, ''pngcairo'') > 0) { set terminal pngcairo size 1350,1290 fontscale 1.4 } '// &
         'else { set terminal png size 1350,1290 large }'
      if (is_svg) then
         call script%put_line(svg, status)
      else
         call script%put_line(png, status)
      end if
   end subroutine add_terminal

   !> A block of data for each method: time (ms), attitude error, energy residual.
   subroutine add_data(script, study, status)
      type(output_file_t), intent(inout) :: script
      type(work_precision_t), intent(in) :: study
      type(status_t), intent(out) :: status
      type(work_point_t), allocatable :: points(:)
      character(len=:), allocatable :: attitude
      integer :: m, i
      do m = 1, size(methods)
         call script%put_line('$m'//count_text(int(m, long))//' << EOD', status)
         points = study%points_of(m)
         do i = 1, size(points)
            attitude = 'NaN'
            if (points(i)%attitude_error >= 0.0_wp .and. points(i)%attitude_error <= hopeless) &
               attitude = rounded_text(max(points(i)%attitude_error, study%reference%uncertainty, lowest), 6)
            if (status%ok()) call script%put_line(rounded_text(1e3_wp*points(i)%seconds, 6)//' '//attitude//' '// &
                                                  rounded_text(max(points(i)%energy_error, lowest), 6), status)
         end do
         if (status%ok()) call script%put_line('EOD', status)
         if (.not. status%ok()) return
      end do
   end subroutine add_data

   !> One panel: `attitude` above, or `energy` below.
   subroutine add_panel(script, study, what, status)
      type(output_file_t), intent(inout) :: script
      type(work_precision_t), intent(in) :: study
      character(len=*), intent(in) :: what
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: curves, column
      integer :: m
      if (what == 'attitude') then
         call script%put_line('set tmargin at screen 0.94; set bmargin at screen 0.54; set format x ''''; '// &
                              'set ylabel ''attitude error  (rad)'' offset 1; '// &
                              'set key at screen 0.99, screen 0.94 right top samplen 2.5 noenhanced', status)
         column = '2'
      else
         call script%put_line('set tmargin at screen 0.50; set bmargin at screen 0.10; set format x ''10^{%T}''; '// &
                              'set ylabel ''worst energy residual'' offset 1; '// &
                              'set xlabel ''time of a run  (ms)''', status)
         column = '3'
         if (status%ok() .and. any(study%points%attitude_error >= 0.0_wp)) call script%put_line('unset key', status)
      end if
      curves = ''
      do m = 1, size(methods)
         if (.not. any(study%points%method == m)) cycle
         if (curves /= '') curves = curves//', '
         curves = curves//'$m'//count_text(int(m, long))//' using 1:'//column//' with linespoints '//style(m)// &
                  ' title '//gnuplot_quoted(short_label(m))
      end do
      if (status%ok()) call script%put_line('plot '//curves, status)
   end subroutine add_panel

   !> The power of ten below a time, in ms, or some powers above that.
   pure function power_text(seconds, above) result(text)
      !> s.
      real(wp), intent(in) :: seconds
      integer, intent(in) :: above
      character(len=:), allocatable :: text
      text = '1e'//count_text(int(floor(log10(max(1e3_wp*seconds, 1e-9_wp))) + above, long))
   end function power_text

   !> Colour by method, projection and order; a second solver of the same is dashed.
   function style(method) result(text)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: text
      integer :: i, colour
      logical :: is_new, repeats
      colour = 0
      do i = 1, method
         is_new = .not. any(family_of(methods(:i - 1)) == family_of(methods(i)) .and. &
                            methods(:i - 1)%order == methods(i)%order)
         if (is_new .and. methods(i)%order > 0) colour = colour + 1
         if (family_of(methods(i)) == family_of(methods(method)) .and. methods(i)%order == methods(method)%order) exit
      end do
      repeats = any(family_of(methods(method + 1:)) == family_of(methods(method)) .and. &
                    methods(method + 1:)%order == methods(method)%order)
      text = 'linecolor rgb '''//colours(1 + modulo(colour - 1, size(colours)))//''''
      if (repeats) text = text//' dashtype 2 linewidth 1 pointtype 6 pointsize 0.4'
      if (.not. repeats) text = text//' linewidth 1.8 pointtype 7 pointsize 0.4'
   end function style

   !> Text in single quotes for gnuplot.
   pure function gnuplot_quoted(text) result(quoted)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: quoted
      quoted = in_quotes(text, "''")
   end function gnuplot_quoted

   !> Text in single quotes for the shell.
   pure function shell_quoted(text) result(quoted)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: quoted
      quoted = in_quotes(text, "'\''")
   end function shell_quoted

   !> Text in single quotes.
   pure function in_quotes(text, apostrophe) result(quoted)
      character(len=*), intent(in) :: text
      !> What stands for an apostrophe.
      character(len=*), intent(in) :: apostrophe
      character(len=:), allocatable :: quoted
      integer :: i
      quoted = "'"
      do i = 1, len(text)
         if (text(i:i) == "'") then
            quoted = quoted//apostrophe
         else
            quoted = quoted//text(i:i)
         end if
      end do
      quoted = quoted//"'"
   end function in_quotes

end module nutate_cost_plot
