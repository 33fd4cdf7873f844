!> A work-precision diagram, drawn by gnuplot: attitude error and energy residual against time.
module nutate_cost_plot
   use nutate_console, only: count_text
   use nutate_cost_report, only: hopeless, full_label
   use nutate_decimal, only: rounded_text
   use nutate_gnuplot, only: picture_t, colours, gnuplot_quoted
   use nutate_kinds, only: wp
   use nutate_methods, only: family_of, methods
   use nutate_status, only: status_t
   use nutate_work_point, only: point_at_error, work_point_t
   use nutate_work_precision, only: work_precision_t, REFUSED
   implicit none
   private

   public :: draw_cost

   !> Lower limit of the drawn errors, below ε: zero has no logarithm.
   real(wp), parameter :: lowest = 1e-17_wp
   !> Lines of the script that do not depend on the runs.
   character(len=*), parameter :: head(*) = [character(len=96) :: &
      'set logscale xy', &
      'set format ''10^{%T}''', &
      'set lmargin at screen 0.11', &
      'set rmargin at screen 0.65']

contains

   !> Draws the runs of all methods, or of the most common ones. Errors: `NUTATE_IO`; no file is left then.
   subroutine draw_cost(picture, title, study, draws_all, status)
      !> Picture, open.
      type(picture_t), intent(inout) :: picture
      character(len=*), intent(in) :: title
      type(work_precision_t), intent(in) :: study
      !> True if all methods are drawn.
      logical, intent(in) :: draws_all
      type(status_t), intent(out) :: status
      logical :: drawn(size(methods)), has_attitudes
      integer :: i
      drawn = is_drawn(study, draws_all)
      ! gnuplot fails on a panel without a point.
      has_attitudes = any(drawn(study%points%method) .and. study%points%attitude_error >= 0.0_wp .and. &
                          study%points%attitude_error <= hopeless)
      call picture%begin(980, 860)
      do i = 1, size(head)
         call picture%put(trim(head(i)))
      end do
      call add_data(picture, study)
      associate (seconds => pack(study%points%seconds, drawn(study%points%method)))
         call picture%put('set xrange ['//power_text(minval(seconds), 0)//':'// &
                          power_text(maxval(seconds), 1)//']')
      end associate
      call picture%put('set multiplot title '//gnuplot_quoted(title)//' noenhanced')
      if (has_attitudes) call add_panel(picture, study, drawn, 'attitude', has_legend=.true.)
      call add_panel(picture, study, drawn, 'energy', has_legend=.not. has_attitudes)
      call picture%put('unset multiplot')
      call picture%draw(status)
   end subroutine draw_cost

   !> Returns the methods to draw: by default the explicit methods and series with the projection, and the best order of
   !> each form of the conserving step; if none of these has a run, all that have one. Shape (rows of `methods`).
   function is_drawn(study, draws_all) result(drawn)
      type(work_precision_t), intent(in) :: study
      logical, intent(in) :: draws_all
      logical :: drawn(size(methods)), measured(size(methods))
      integer :: m
      measured = [(any(study%points%method == m), m=1, size(methods))]
      drawn = methods%order > 0 .or. measured
      if (draws_all) return
      drawn = methods%order > 0 .and. methods%projected
      do m = 1, size(methods)
         if (methods(m)%formulation /= '') drawn(m) = m == best_order(study, m)
      end do
      if (.not. any(drawn .and. measured)) drawn = measured
   end function is_drawn

   !> Returns, of the rows that differ from one by their order alone, the row with the least cost for the smallest error
   !> that any of them attains; without a reference, the highest order that has a run.
   integer function best_order(study, method) result(best)
      type(work_precision_t), intent(in) :: study
      !> Row of `methods`.
      integer, intent(in) :: method
      type(work_point_t) :: point
      real(wp) :: error, seconds
      integer :: m, decade
      logical :: relatives(size(methods))
      relatives = family_of(methods) == family_of(methods(method)) .and. &
                  methods%formulation == methods(method)%formulation
      best = findloc(relatives, .true., dim=1, back=.true.)
      do m = 1, best
         if (relatives(m) .and. any(study%points%method == m)) best = m
      end do
      if (.not. study%reference%known()) return
      do decade = -12, -1
         error = 10.0_wp**decade
         seconds = huge(1.0_wp)
         do m = 1, size(methods)
            if (.not. relatives(m) .or. error < study%reference%uncertainty) cycle
            point = point_at_error(study%points_of(m), methods(m)%order, error)
            if (.not. point%exists() .or. point%seconds >= seconds) cycle
            seconds = point%seconds
            best = m
         end do
         if (seconds < huge(1.0_wp)) return
      end do
   end function best_order

   !> Returns the points that no other point beats in time and error, cheapest first. A curve through all would bend
   !> back: beyond the least error round-off grows, and steps that must be subdivided cost more than shorter ones.
   pure function unbeaten(points, floor_of_errors) result(kept)
      !> Points of one method.
      type(work_point_t), intent(in) :: points(:)
      !> Uncertainty of the reference attitude, rad.
      real(wp), intent(in) :: floor_of_errors
      type(work_point_t), allocatable :: kept(:)
      real(wp) :: errors(size(points))
      logical :: waits(size(points))
      real(wp) :: least
      integer :: i
      allocate (kept(0))
      errors = max(points%attitude_error, floor_of_errors, lowest)
      if (any(points%attitude_error < 0.0_wp)) errors = max(points%energy_error, lowest)
      if (any(points%attitude_error < 0.0_wp) .and. all(methods(points%method)%conserving)) &
         errors = lowest/points%seconds
      waits = .true.
      least = huge(least)
      do while (any(waits))
         i = minloc(points%seconds, dim=1, mask=waits)
         waits(i) = .false.
         ! A lower error must differ in the digits that are drawn.
         if (errors(i) > (1 - 1e-5_wp)*least) cycle
         ! If several points took the same time, only the best is on the curve.
         if (any(points%seconds <= points(i)%seconds .and. errors < errors(i))) cycle
         least = errors(i)
         kept = [kept, points(i)]
      end do
   end function unbeaten

   !> Adds a block of data for each method: time (ms), attitude error, energy residual.
   subroutine add_data(picture, study)
      type(picture_t), intent(inout) :: picture
      type(work_precision_t), intent(in) :: study
      type(work_point_t), allocatable :: points(:)
      character(len=:), allocatable :: attitude
      integer :: m, i
      do m = 1, size(methods)
         call picture%put('$m'//count_text(m)//' << EOD')
         points = unbeaten(study%points_of(m), study%reference%uncertainty)
         do i = 1, size(points)
            attitude = 'NaN'
            if (points(i)%attitude_error >= 0.0_wp .and. points(i)%attitude_error <= hopeless) &
               attitude = rounded_text(max(points(i)%attitude_error, study%reference%uncertainty, lowest), 6)
            call picture%put(rounded_text(1e3_wp*points(i)%seconds, 6)//' '//attitude//' '// &
                             rounded_text(max(points(i)%energy_error, lowest), 6))
         end do
         call picture%put('EOD')
      end do
   end subroutine add_data

   !> Adds one panel: `attitude` above, or `energy` below.
   subroutine add_panel(picture, study, drawn, what, has_legend)
      type(picture_t), intent(inout) :: picture
      type(work_precision_t), intent(in) :: study
      !> True for the methods that are drawn; shape (rows of `methods`).
      logical, intent(in) :: drawn(:)
      character(len=*), intent(in) :: what
      logical, intent(in) :: has_legend
      real(wp) :: least
      if (has_legend) then
         call picture%put('set key at screen 0.66, screen 0.94 left top Left reverse samplen 2 font '',13'' noenhanced')
      else
         call picture%put('unset key')
      end if
      if (what == 'attitude') then
         call picture%put('set tmargin at screen 0.94; set bmargin at screen 0.54; set format x ''''; '// &
                          'set ylabel ''attitude error  (rad)'' offset 1')
         ! The least errors lie above the lower edge.
         least = minval(max(study%points%attitude_error, study%reference%uncertainty, lowest), &
                        mask=study%points%attitude_error >= 0.0_wp .and. study%points%attitude_error <= hopeless)
         call picture%put('set yrange [1e'//count_text(floor(log10(least) - 0.2_wp))//':*]')
         call picture%put('plot '//curves(study, drawn, '2'))
      else
         call picture%put('set tmargin at screen 0.50; set bmargin at screen 0.10; set format x ''10^{%T}''; '// &
                          'set ylabel ''worst energy residual'' offset 1; set yrange [*:*]; '// &
                          'set xlabel ''time of a run  (ms)''')
         call picture%put('plot '//curves(study, drawn, '3'))
      end if
   end subroutine add_panel

   !> Returns the curves of a panel, one for each method; a method without a run has a legend entry with the reason.
   function curves(study, drawn, column) result(text)
      type(work_precision_t), intent(in) :: study
      !> True for the methods that are drawn; shape (rows of `methods`).
      logical, intent(in) :: drawn(:)
      !> Column of the data.
      character(len=*), intent(in) :: column
      character(len=:), allocatable :: text, label
      integer :: m
      text = ''
      do m = 1, size(methods)
         if (.not. drawn(m)) cycle
         if (text /= '') text = text//', '
         label = full_label(m)
         if (any(study%points%method == m)) then
            text = text//'$m'//count_text(m)//' using 1:'//column
         else
            text = text//'NaN'
            label = label//trim(merge(': not here', ': no time ', study%ending(m) == REFUSED))
         end if
         text = text//' with linespoints '//style(m)//' title '//gnuplot_quoted(label)
      end do
   end function curves

   !> Returns the power of ten below a time, in ms, raised by some powers of ten.
   pure function power_text(seconds, above) result(text)
      !> Time, s.
      real(wp), intent(in) :: seconds
      integer, intent(in) :: above
      character(len=:), allocatable :: text
      text = '1e'//count_text(floor(log10(max(1e3_wp*seconds, 1e-9_wp))) + above)
   end function power_text

   !> Returns the style of a curve: colour by method, projection and order; of several solvers of one order, all but
   !> the last are dashed.
   function style(method) result(text)
      !> Row of `methods`.
      integer, intent(in) :: method
      character(len=:), allocatable :: text
      integer :: i, colour
      logical :: is_new, repeats
      if (methods(method)%order < 1) then
         text = 'linecolor rgb ''black'' pointtype 3'
         return
      end if
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

end module nutate_cost_plot
