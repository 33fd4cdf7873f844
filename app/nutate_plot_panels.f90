!> The panels of the picture of a history: which columns share one, what it is called and the colour of each curve.
module nutate_plot_panels
   use nutate_columns, only: column_sets
   use nutate_history_reading, only: name_length
   use nutate_spelling, only: split_list
   implicit none
   private

   public :: panel_t, panels_of, columns_named, known_columns, is_wrapped

   !> One panel.
   type :: panel_t
      !> The quantity with its unit.
      character(len=128) :: label = ''
      !> Columns of the history; shape (number of curves).
      integer, allocatable :: columns(:)
      !> Their colours; shape (number of curves).
      character(len=7), allocatable :: colours(:)
   end type panel_t

   !> What is drawn together.
   type :: rule_t
      !> Names of columns: `#` is a digit, `@` is x, y or z, `*` the rest of the name.
      character(len=24) :: pattern
      !> `#` is the first digit of the name, `%` the unit of an angle, `*` the free number of a derivative.
      character(len=40) :: label
      !> Blank: that of the component.
      character(len=7) :: colour = ''
   end type rule_t

   !> Colours of the components 1, 2, 3, or x, y, z, of the wheels and controllers 1 to 6, and of one that is neither.
   character(len=7), parameter :: component_colours(6) = ['#d55e00', '#009e73', '#0b3c5d', '#e69f00', '#56b4e9', &
      '#cc79a7'], grey = '#666666'
   !> Colours of columns that have no component, one after the other.
   character(len=7), parameter :: others(6) = ['#0b3c5d', '#e69f00', '#009e73', '#d55e00', '#56b4e9', '#cc79a7']

   !> All columns of histories, in the order of the panels.
   type(rule_t), parameter :: rules(*) = [ &
      rule_t('omega#', 'Ω (%/s)'), &
      rule_t('omega_@', 'ω in space (%/s)'), &
      rule_t('q#', 'q'), &
      rule_t('lvlh_q#', 'q from the LVLH frame'), &
      rule_t('roll', 'roll, pitch, yaw (%)', component_colours(1)), &
      rule_t('pitch', 'roll, pitch, yaw (%)', component_colours(2)), &
      rule_t('yaw', 'roll, pitch, yaw (%)', component_colours(3)), &
      rule_t('phi', 'φ, ψ (%)', component_colours(1)), &
      rule_t('psi', 'φ, ψ (%)', component_colours(3)), &
      rule_t('theta', 'θ (%)', component_colours(2)), &
      rule_t('euler_###_#', 'Euler angles (%)'), &
      rule_t('pointing_error#', 'pointing error (%)'), &
      rule_t('frame#_q#', 'q from frame #'), &
      rule_t('frame#_angle', 'angle from frame # (%)', component_colours(3)), &
      rule_t('wheel#_speed', 'wheel speed (rad/s)'), &
      rule_t('wheel#_momentum', 'wheel momentum (N m s)'), &
      rule_t('controller#_commanded#', 'controller #, commanded (N m or A m²)'), &
      rule_t('controller#_applied#', 'controller #, applied (N m or A m²)'), &
      rule_t('controller#_saturations', 'saturations'), &
      rule_t('B#', 'B (T)'), &
      rule_t('L#', 'L (N m s)'), &
      rule_t('l_@', 'l in space (N m s)'), &
      rule_t('p#', 'p (N m s)'), &
      rule_t('orbit_@', 'position (m)'), &
      rule_t('orbit_radius', 'radius of the orbit (m)', component_colours(3)), &
      rule_t('true_anomaly', 'true anomaly (%)', component_colours(3)), &
      rule_t('eclipse', 'eclipse', component_colours(3)), &
      rule_t('shadow_depth', 'depth in the shadow (m)', component_colours(3)), &
      rule_t('energy_ratio', 'E/E₀', component_colours(3)), &
      rule_t('short_axis_mode', 'short-axis mode', component_colours(3)), &
      rule_t('sense', 'sense', component_colours(3)), &
      rule_t('precession_period_short', 'periods (s)', component_colours(1)), &
      rule_t('precession_period_long', 'periods (s)', component_colours(2)), &
      rule_t('rotation_period', 'periods (s)', component_colours(3)), &
      rule_t('pole_longitude', 'pole (%)', component_colours(1)), &
      rule_t('pole_latitude', 'pole (%)', component_colours(3)), &
      rule_t('kinetic', 'energy (J)', '#56b4e9'), &
      rule_t('potential', 'energy (J)', '#e69f00'), &
      rule_t('total', 'energy (J)', '#000000'), &
      rule_t('work', 'energy (J)', '#cc79a7'), &
      rule_t('energy_residual', 'energy residual (J)', grey), &
      rule_t('jacobi', 'Jacobi integral (J)', '#000000'), &
      rule_t('energy_*', 'potential energies (J)'), &
      rule_t('work_*', 'works (J)'), &
      rule_t('time_dependent_work', 'works (J)'), &
      rule_t('wheel#_motor_work', 'works of wheel # (J)', '#e69f00'), &
      rule_t('wheel#_friction_work', 'works of wheel # (J)', '#cc79a7'), &
      rule_t('norm_error', 'q·q − 1', grey), &
      rule_t('orthogonality', 'q·p (N m s)', grey), &
      rule_t('iterations', 'iterations', grey), &
      rule_t('step_residual', 'residual of a step', grey), &
      rule_t('d_rotation#/d_*', 'rotation by * (% per unit)'), &
      rule_t('d_rotation#_deg/d_*', 'rotation by * (% per unit)'), &
      rule_t('d_omega#/d_*', 'Ω by * (%/s per unit)'), &
      rule_t('d_omega#_deg/d_*', 'Ω by * (%/s per unit)'), &
      rule_t('d_wheel#_momentum/d_*', 'wheel momentum by * (N m s per unit)'), &
      rule_t('sigma_rotation#', 'σ of the rotation (%)'), &
      rule_t('sigma_omega#', 'σ of Ω (%/s)'), &
      rule_t('covariance_*', 'covariances'), &
      rule_t('lyapunov', 'Lyapunov exponent (1/s)', component_colours(3)), &
      rule_t('lyapunov#', 'Lyapunov exponents (1/s)'), &
      rule_t('megno', 'mean MEGNO', component_colours(3)), &
      rule_t('fli', 'FLI', component_colours(3))]

contains

   !> Returns the panels of columns, from top to bottom. A column that no rule knows has a panel of its own.
   pure function panels_of(names) result(panels)
      !> The first is t.
      character(len=*), intent(in) :: names(:)
      type(panel_t), allocatable :: panels(:)
      integer :: rule, i
      allocate (panels(0))
      do rule = 1, size(rules) + 1
         do i = 2, size(names)
            if (rule_of(names(i)) /= rule) cycle
            if (rule <= size(rules)) then
               call add_curve(panels, label_of(rules(rule)%label, names(i)), i, rules(rule)%colour, names(i))
            else
               call add_curve(panels, names(i), i, others(1), names(i))
            end if
         end do
      end do
   end function panels_of

   !> Adds a curve to the panel of a label, or to a new one.
   pure subroutine add_curve(panels, label, column, colour, name)
      type(panel_t), allocatable, intent(inout) :: panels(:)
      character(len=*), intent(in) :: label, name
      integer, intent(in) :: column
      !> Blank: that of the component.
      character(len=*), intent(in) :: colour
      type(panel_t), allocatable :: longer(:)
      character(len=7) :: drawn
      integer :: place
      place = findloc(panels%label == label, .true., dim=1)
      if (place == 0) then
         allocate (longer(size(panels) + 1))
         longer(:size(panels)) = panels
         call move_alloc(longer, panels)
         place = size(panels)
         panels(place)%label = label
         allocate (panels(place)%columns(0), panels(place)%colours(0))
      end if
      drawn = colour
      if (drawn == '') drawn = component_colour(base_name(numerator(name)), size(panels(place)%columns))
      panels(place)%columns = [panels(place)%columns, column]
      panels(place)%colours = [panels(place)%colours, drawn]
   end subroutine add_curve

   !> Returns the colour of a component or wheel, whose number or letter the name has; else the next colour.
   pure function component_colour(name, curves) result(colour)
      character(len=*), intent(in) :: name
      !> How many curves the panel has.
      integer, intent(in) :: curves
      character(len=7) :: colour
      character(len=1) :: last
      integer :: place
      last = name(len(name):)
      place = max(index('123456', last), index('xyz', last))
      colour = others(1 + modulo(curves, size(others)))
      if (index(name, 'wheel') == 1) place = index('123456', name(6:6))
      if (index(name, 'd_wheel') == 1) place = index('123456', name(8:8))
      if (place > 0) then
         colour = component_colours(place)
      else if (last == '0') then
         colour = grey
      end if
   end function component_colour

   !> Returns the rule of a column; one more than there are for a column that none knows.
   pure integer function rule_of(name) result(rule)
      character(len=*), intent(in) :: name
      do rule = 1, size(rules)
         if (matches(trim(rules(rule)%pattern), base_name(name))) return
      end do
   end function rule_of

   !> Returns which columns have a rule; shape (that of `names`).
   pure function known_columns(names) result(known)
      character(len=*), intent(in) :: names(:)
      logical :: known(size(names))
      integer :: i
      known = [(rule_of(names(i)) <= size(rules), i=1, size(names))]
   end function known_columns

   !> True for an angle that jumps by a turn.
   pure logical function is_wrapped(name)
      character(len=*), intent(in) :: name
      is_wrapped = any(base_name(name) == [character(len=12) :: 'roll', 'yaw', 'true_anomaly'])
   end function is_wrapped

   !> True for a name that a pattern stands for.
   pure logical function matches(pattern, name)
      character(len=*), intent(in) :: pattern, name
      integer :: i
      matches = .false.
      do i = 1, len(pattern)
         if (i > len(name)) return
         select case (pattern(i:i))
         case ('*')
            matches = .true.
            return
         case ('#')
            if (scan(name(i:i), '0123456789') == 0) return
         case ('@')
            if (scan(name(i:i), 'xyz') == 0) return
         case default
            if (name(i:i) /= pattern(i:i)) return
         end select
      end do
      matches = len(name) == len(pattern)
   end function matches

   !> Returns the name of a column without the mark of degrees.
   pure function base_name(name) result(base)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: base
      base = trim(name)
      if (in_degrees(base)) base = base(:len(base) - 4)
   end function base_name

   !> Returns what a column is the derivative of; any other as it is.
   pure function numerator(name)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: numerator
      numerator = trim(name)
      if (index(name, 'd_') == 1 .and. index(name, '/d_') > 0) numerator = name(:index(name, '/d_') - 1)
   end function numerator

   pure logical function in_degrees(name)
      character(len=*), intent(in) :: name
      in_degrees = .false.
      if (len_trim(name) > 4) in_degrees = name(len_trim(name) - 3:len_trim(name)) == '_deg'
   end function in_degrees

   !> Returns the label of a panel with the number of the column and its unit.
   pure function label_of(pattern, name) result(label)
      character(len=*), intent(in) :: pattern, name
      character(len=:), allocatable :: label
      integer :: i
      label = ''
      do i = 1, len_trim(pattern)
         if (pattern(i:i) == '#') then
            label = label//name(scan(name, '0123456789'):scan(name, '0123456789'))
         else if (pattern(i:i) == '%') then
            label = label//trim(merge('°  ', 'rad ', in_degrees(numerator(name))))
         else if (pattern(i:i) == '*') then
            label = label//trim(name(index(name, '/d_') + len('/d_'):))
         else
            label = label//pattern(i:i)
         end if
      end do
   end function label_of

   !> Returns the columns that a word stands for: one of that name, or those of a set; shape (that of `names`).
   pure function columns_named(word, names) result(chosen)
      character(len=*), intent(in) :: word
      character(len=*), intent(in) :: names(:)
      logical :: chosen(size(names))
      character(len=name_length), allocatable :: headers(:)
      !> A pattern of names stands for the scene's own from its first capital on.
      character(len=*), parameter :: capitals = 'ABCDEFGHIJKLMNOPQRSTUVWXYZ'
      integer :: i, set
      chosen = names == word
      if (any(chosen)) return
      do i = 1, size(names)
         if (base_name(names(i)) == word) chosen(i) = .true.
      end do
      set = findloc(column_sets%name == word, .true., dim=1)
      if (set == 0) return
      if (column_sets(set)%width == 0) then
         allocate (headers(1))
         headers(1) = column_sets(set)%headers(:scan(column_sets(set)%headers, capitals) - 1)//'*'
      else
         headers = split_list(trim(column_sets(set)%headers))
      end if
      do i = 1, size(names)
         chosen(i) = any_matches(headers, base_name(names(i)))
      end do
   end function columns_named

   pure logical function any_matches(patterns, name)
      character(len=*), intent(in) :: patterns(:), name
      integer :: i
      any_matches = any([(matches(trim(patterns(i)), name), i=1, size(patterns))])
   end function any_matches

end module nutate_plot_panels
