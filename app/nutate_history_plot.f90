!> The usual picture of a history, drawn by gnuplot: a panel for each set of columns that is there.
module nutate_history_plot
   use nutate_attitude, only: euler_from_quat
   use nutate_console, only: count_text
   use nutate_decimal, only: rounded_text
   use nutate_gnuplot, only: picture_t, colours, gnuplot_quoted
   use nutate_history_reading, only: recorded_t
   use nutate_kinds, only: wp, long, pi
   use nutate_spelling, only: split_list
   use nutate_status, only: status_t
   implicit none
   private

   public :: draw_history, can_draw, drawn_columns

   !> One panel.
   type :: panel_t
      character(len=32) :: label
      !> Columns that must be there, comma separated.
      character(len=72) :: columns
      !> What is drawn, comma separated: columns, or what `curve` makes of them.
      character(len=72) :: curves
   end type panel_t

   !> All panels, from top to bottom.
   type(panel_t), parameter :: panels(*) = [ &
      panel_t('Ω  (rad/s)', 'omega1,omega2,omega3', 'omega1,omega2,omega3'), &
      panel_t('ω in space  (rad/s)', 'omega_x,omega_y,omega_z', 'omega_x,omega_y,omega_z'), &
      panel_t('angles  (rad)', 'phi,theta,psi', 'phi,psi,theta'), &
      panel_t('angles  (rad)', 'q0,q1,q2,q3', 'phi,psi,theta'), &
      panel_t('energy  (J)', 'kinetic,potential,total,work', 'kinetic,potential,work,total'), &
      panel_t('energy residual', 'kinetic,potential,energy_residual', 'residual'), &
      panel_t('q·q − 1', 'norm_error', 'norm_error'), &
      panel_t('L  (N m s)', 'L1,L2,L3', 'L1,L2,L3'), &
      panel_t('l in space  (N m s)', 'l_x,l_y,l_z', 'l_x,l_y,l_z'), &
      panel_t('controller 1  (SI)', 'regulator1_commanded1,regulator1_commanded2,regulator1_commanded3', &
              'regulator1_commanded1,regulator1_commanded2,regulator1_commanded3'), &
      panel_t('controller 1  (SI)', 'regulator1_applied1,regulator1_applied2,regulator1_applied3', &
              'regulator1_applied1,regulator1_applied2,regulator1_applied3'), &
      panel_t('pointing  (rad)', 'pointing_error1', 'pointing_error1'), &
      panel_t('controller 2  (SI)', 'regulator2_commanded1,regulator2_commanded2,regulator2_commanded3', &
              'regulator2_commanded1,regulator2_commanded2,regulator2_commanded3'), &
      panel_t('controller 2  (SI)', 'regulator2_applied1,regulator2_applied2,regulator2_applied3', &
              'regulator2_applied1,regulator2_applied2,regulator2_applied3'), &
      panel_t('pointing  (rad)', 'pointing_error2', 'pointing_error2'), &
      panel_t('controller 3  (SI)', 'regulator3_commanded1,regulator3_commanded2,regulator3_commanded3', &
              'regulator3_commanded1,regulator3_commanded2,regulator3_commanded3'), &
      panel_t('controller 3  (SI)', 'regulator3_applied1,regulator3_applied2,regulator3_applied3', &
              'regulator3_applied1,regulator3_applied2,regulator3_applied3'), &
      panel_t('pointing  (rad)', 'pointing_error3', 'pointing_error3'), &
      panel_t('controller 4  (SI)', 'regulator4_commanded1,regulator4_commanded2,regulator4_commanded3', &
              'regulator4_commanded1,regulator4_commanded2,regulator4_commanded3'), &
      panel_t('controller 4  (SI)', 'regulator4_applied1,regulator4_applied2,regulator4_applied3', &
              'regulator4_applied1,regulator4_applied2,regulator4_applied3'), &
      panel_t('pointing  (rad)', 'pointing_error4', 'pointing_error4'), &
      panel_t('controller 5  (SI)', 'regulator5_commanded1,regulator5_commanded2,regulator5_commanded3', &
              'regulator5_commanded1,regulator5_commanded2,regulator5_commanded3'), &
      panel_t('controller 5  (SI)', 'regulator5_applied1,regulator5_applied2,regulator5_applied3', &
              'regulator5_applied1,regulator5_applied2,regulator5_applied3'), &
      panel_t('pointing  (rad)', 'pointing_error5', 'pointing_error5'), &
      panel_t('controller 6  (SI)', 'regulator6_commanded1,regulator6_commanded2,regulator6_commanded3', &
              'regulator6_commanded1,regulator6_commanded2,regulator6_commanded3'), &
      panel_t('controller 6  (SI)', 'regulator6_applied1,regulator6_applied2,regulator6_applied3', &
              'regulator6_applied1,regulator6_applied2,regulator6_applied3'), &
      panel_t('pointing  (rad)', 'pointing_error6', 'pointing_error6'), &
      panel_t('B  (T)', 'B1,B2,B3', 'B1,B2,B3')]

   !> Histories of more rows than this are drawn by the least and the greatest value in each of half as many intervals.
   integer, parameter :: most_points = 1200
   !> Angles that change by more from row to row jump, rad: by whole turns, or by half a turn near a pole.
   real(wp), parameter :: jump = 2.5_wp
   !> Height of a panel, of the title and of the time axis.
   integer, parameter :: panel_height = 170, top = 50, bottom = 60

contains

   !> Names of all columns that can be drawn.
   pure function drawn_columns() result(names)
      character(len=24), allocatable :: names(:)
      integer :: i
      allocate (names(0))
      do i = 1, size(panels)
         names = [character(len=24) :: names, split_list(trim(panels(i)%columns))]
      end do
   end function drawn_columns

   !> The panels that a history fills; angles in columns go before those of the quaternion.
   pure function panels_of(history) result(chosen)
      type(recorded_t), intent(in) :: history
      integer, allocatable :: chosen(:)
      integer :: i
      allocate (chosen(0))
      do i = 1, size(panels)
         if (.not. history%has(trim(panels(i)%columns))) cycle
         if (panels(i)%columns == 'q0,q1,q2,q3' .and. history%has('phi,theta,psi')) cycle
         chosen = [chosen, i]
      end do
   end function panels_of

   !> True if there is something to be drawn.
   pure logical function can_draw(history)
      type(recorded_t), intent(in) :: history
      can_draw = size(panels_of(history)) > 0
   end function can_draw

   !> Draws a history. Errors: `NUTATE_IO`; nothing is left then.
   subroutine draw_history(picture, title, history, status)
      !> Open.
      type(picture_t), intent(inout) :: picture
      character(len=*), intent(in) :: title
      type(recorded_t), intent(in) :: history
      type(status_t), intent(out) :: status
      integer, allocatable :: chosen(:)
      real(wp) :: height, upper
      integer :: i
      chosen = panels_of(history)
      height = real(top + bottom + panel_height*size(chosen), wp)
      call picture%begin(900, nint(height))
      call picture%put('set lmargin at screen 0.13; set rmargin at screen 0.83; set key outside right top '// &
                       'samplen 1.5 noenhanced; set format y ''%g''; set xrange ['//extent(history%values(:, 1))//']')
      call picture%put('set multiplot title '//gnuplot_quoted(title)//' noenhanced')
      do i = 1, size(chosen)
         call add_data(picture, history, panels(chosen(i)))
         upper = 1 - (top + panel_height*(i - 1))/height
         call picture%put('set tmargin at screen '//rounded_text(upper, 4)//'; set bmargin at screen '// &
                          rounded_text(upper - (panel_height - 25)/height, 4))
         if (i == size(chosen)) call picture%put('set xlabel ''t  (s)''; set format x ''%g''')
         if (i < size(chosen)) call picture%put('set format x ''''')
         call picture%put('set ylabel '//gnuplot_quoted(trim(panels(chosen(i))%label))//' offset 1')
         call picture%put('plot '//curves_text(panels(chosen(i))))
      end do
      call picture%put('unset multiplot')
      call picture%draw(status)
   end subroutine draw_history

   !> The least and the greatest time.
   pure function extent(t) result(text)
      !> s
      real(wp), intent(in) :: t(:)
      character(len=:), allocatable :: text
      text = rounded_text(minval(t), 9)//':'//rounded_text(maxval(t), 9)
   end function extent

   !> What gnuplot draws in a panel.
   function curves_text(panel) result(text)
      type(panel_t), intent(in) :: panel
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      associate (names => split_list(trim(panel%curves)))
         do i = 1, size(names)
            if (i > 1) text = text//', '
            text = text//'$c'//count_text(int(i, long))//' using 1:2 with lines linewidth 1.4 linecolor rgb '''// &
                   trim(colours(min(2*i - 1, size(colours))))//''' title '//gnuplot_quoted(legend(trim(names(i))))
         end do
      end associate
   end function curves_text

   !> The name of a curve in the legend, without what its panel is called.
   pure function legend(name)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: legend
      legend = name
      if (index(name, 'regulator') == 1) legend = name(index(name, '_') + 1:)
      if (index(name, 'pointing_') == 1) legend = name(len('pointing_') + 1:)
   end function legend

   !> The curves of a panel as blocks of data.
   subroutine add_data(picture, history, panel)
      type(picture_t), intent(inout) :: picture
      type(recorded_t), intent(in) :: history
      type(panel_t), intent(in) :: panel
      integer :: i
      associate (names => split_list(trim(panel%curves)))
         do i = 1, size(names)
            call picture%put('$c'//count_text(int(i, long))//' << EOD')
            call add_points(picture, history%values(:, 1), curve(history, trim(names(i))), &
                            breaks=any(names(i) == ['phi', 'psi']))
            call picture%put('EOD')
         end do
      end associate
   end subroutine add_data

   !> The points of a curve, thinned where there are many.
   subroutine add_points(picture, t, y, breaks)
      type(picture_t), intent(inout) :: picture
      !> Same shape.
      real(wp), intent(in) :: t(:), y(:)
      !> The line is broken where it jumps.
      logical, intent(in) :: breaks
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
            if (breaks .and. abs(y(ends(e)) - before) > jump) call picture%put('')
            before = y(ends(e))
            call picture%put(rounded_text(t(ends(e)), 9)//' '//rounded_text(before, 7))
         end do
      end do
   end subroutine add_points

   !> What a name of `panel_t%curves` stands for; shape (rows).
   pure function curve(history, name) result(y)
      type(recorded_t), intent(in) :: history
      character(len=*), intent(in) :: name
      real(wp), allocatable :: y(:)
      real(wp) :: largest
      select case (name)
      case ('residual')
         y = history%column('energy_residual')
         largest = maxval(abs(history%column('kinetic')) + abs(history%column('potential')))
         if (largest > 0.0_wp) y = y/largest
      case ('phi', 'theta', 'psi')
         if (history%has('phi,theta,psi')) then
            y = history%column(name)
            ! Turns are left out, as those of a quaternion are.
            if (name /= 'theta') y = y - 2*pi*anint(y/(2*pi))
         else
            y = angle_of(history, findloc(['phi  ', 'theta', 'psi  '] == name, .true., dim=1))
         end if
      case default
         y = history%column(name)
      end select
   end function curve

   !> φ, θ or ψ of the quaternion, rad; shape (rows).
   pure function angle_of(history, which) result(y)
      type(recorded_t), intent(in) :: history
      !> 1, 2 or 3.
      integer, intent(in) :: which
      real(wp), allocatable :: y(:)
      real(wp) :: q(size(history%values, 1), 4), angles(3)
      integer :: i
      q(:, 1) = history%column('q0')
      q(:, 2) = history%column('q1')
      q(:, 3) = history%column('q2')
      q(:, 4) = history%column('q3')
      allocate (y(size(q, 1)))
      do i = 1, size(y)
         call euler_from_quat(q(i, :), angles(1), angles(2), angles(3))
         y(i) = angles(which)
      end do
   end function angle_of

end module nutate_history_plot
