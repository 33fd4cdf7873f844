!> The panels of the picture of a history: which columns share one, and the colour of each curve.
module nutate_plot_panels
   use nutate_effect_list, only: effect_list_t
   use nutate_motion_quantities, only: Q_CONJUGATE_MOMENTUM, Q_EULER, Q_QUATERNION
   use nutate_quantities, only: component_of, find_missing, find_quantity, numbered, quantities, set_of
   use nutate_quantity, only: quantity_t, component_colours, GREY
   use nutate_spelling, only: escaped, split_list
   implicit none
   private

   public :: panel_t, panels_of, columns_named, known_columns, usual_columns, is_wrapped, label_of_column, set_with, &
      symbol_of

   type :: panel_t
      !> The quantity with its unit.
      character(len=128) :: label = ''
      !> Columns of the history; shape (number of curves).
      integer, allocatable :: columns(:)
      !> Colours of the curves; shape (number of curves).
      character(len=7), allocatable :: colours(:)
   end type panel_t

   !> Greatest number of curves in a panel, which is that of the lines of its legend.
   integer, parameter :: most_curves = 6
   !> Colours of columns that have no component, one after the other.
   character(len=7), parameter :: others(6) = ['#0b3c5d', '#e69f00', '#009e73', '#d55e00', '#56b4e9', '#cc79a7']

contains

   !> Returns the panels of columns, from top to bottom. A column that is not in the table has a panel of its own; more
   !> curves than a panel shows are continued in another one.
   pure function panels_of(names) result(panels)
      !> Names of the columns; the first is t.
      character(len=*), intent(in) :: names(:)
      type(panel_t), allocatable :: panels(:)
      integer :: place, at(size(names)), i
      allocate (panels(0))
      at = [(position_of(names(i)), i=1, size(names))]
      do place = 1, maxval(quantities%panel)
         do i = 2, size(names)
            if (at(i) == 0) cycle
            if (quantities(at(i))%panel == place) &
               call add_curve(panels, label_of(quantities(at(i)), names(i)), i, quantities(at(i))%colour, names(i))
         end do
      end do
      do i = 2, size(names)
         if (at(i) == 0) call add_curve(panels, names(i), i, others(1), names(i))
      end do
   end function panels_of

   !> Adds a curve to the panel of a label, or to a new one.
   pure subroutine add_curve(panels, label, column, colour, name)
      type(panel_t), allocatable, intent(inout) :: panels(:)
      character(len=*), intent(in) :: label, name
      integer, intent(in) :: column
      !> Colour of the curve; blank: the colour of the component.
      character(len=*), intent(in) :: colour
      type(panel_t), allocatable :: longer(:)
      character(len=7) :: drawn
      logical :: is_used(size(others))
      integer :: place, i
      place = findloc(panels%label == label, .true., dim=1, back=.true.)
      if (place > 0) then
         if (size(panels(place)%columns) == most_curves) place = 0
      end if
      if (place == 0) then
         allocate (longer(size(panels) + 1))
         longer(:size(panels)) = panels
         call move_alloc(longer, panels)
         place = size(panels)
         panels(place)%label = label
         allocate (panels(place)%columns(0), panels(place)%colours(0))
      end if
      drawn = colour
      if (drawn == '') drawn = component_colour(numerator(base_name(name)), size(panels(place)%columns))
      ! Names of effects end as they like: energy_gravity and energy_spring2 would have the colour of component 2.
      is_used = [(any(panels(place)%colours == others(i)), i=1, size(others))]
      if (any(panels(place)%colours == drawn) .and. .not. all(is_used)) drawn = others(findloc(is_used, .false., dim=1))
      panels(place)%columns = [panels(place)%columns, column]
      panels(place)%colours = [panels(place)%colours, drawn]
   end subroutine add_curve

   !> Returns the colour of a component or wheel, whose number or letter the name has; else the next colour.
   pure function component_colour(name, curves) result(colour)
      character(len=*), intent(in) :: name
      !> Number of curves that the panel has.
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
         colour = GREY
      end if
   end function component_colour

   !> Returns the position of a column's quantity in the table; 0 for a column that is not in it.
   pure integer function position_of(name) result(at)
      character(len=*), intent(in) :: name
      do at = 1, size(quantities)
         if (shows(quantities(at), name)) return
      end do
      at = 0
   end function position_of

   !> Returns true for a column of a quantity, in degrees or not.
   pure logical function shows(quantity, name)
      type(quantity_t), intent(in) :: quantity
      character(len=*), intent(in) :: name
      if (quantity%pattern == '') then
         shows = component_of(quantity, base_name(name)) > 0
      else
         shows = matches(trim(quantity%pattern), base_name(name))
         ! energy_ratio is no energy of an effect.
         if (shows) shows = find_quantity(base_name(name)) == 0
      end if
   end function shows

   !> Returns which columns are in the table; shape (that of `names`).
   pure function known_columns(names) result(known)
      character(len=*), intent(in) :: names(:)
      logical :: known(size(names))
      integer :: i
      known = [(position_of(names(i)) > 0, i=1, size(names))]
   end function known_columns

   !> Returns which columns a picture has unless some are requested: those in the table, without conjugate momenta, and
   !> without quaternions beside Euler angles; shape (that of `names`).
   pure function usual_columns(names, residuals) result(usual)
      character(len=*), intent(in) :: names(:)
      !> True to include the errors of the integration.
      logical, intent(in) :: residuals
      logical :: usual(size(names)), has_angles
      integer :: i, at
      usual = .false.
      has_angles = .false.
      do i = 1, size(names)
         at = position_of(names(i))
         if (at == 0) cycle
         usual(i) = quantities(at)%kind /= Q_CONJUGATE_MOMENTUM .and. (residuals .or. .not. quantities(at)%is_residual)
         has_angles = has_angles .or. quantities(at)%kind == Q_EULER
      end do
      if (.not. has_angles) return
      do i = 1, size(names)
         at = position_of(names(i))
         if (at > 0) usual(i) = usual(i) .and. quantities(max(at, 1))%kind /= Q_QUATERNION
      end do
   end function usual_columns

   !> Returns the name of the set that a word stands for or belongs to, of several one that the system can have; blank
   !> for an unknown word.
   function set_with(word, effects) result(set)
      !> Name of a set or of a column.
      character(len=*), intent(in) :: word
      type(effect_list_t), intent(in) :: effects
      character(len=24) :: set
      character(len=:), allocatable :: missing, expected
      integer :: at
      set = ''
      do at = 1, size(quantities)
         if (.not. (set_of(quantities(at)) == word .or. shows(quantities(at), word))) cycle
         if (set == '') set = set_of(quantities(at))
         call find_missing(quantities(at), effects, missing, expected)
         if (missing /= '') cycle
         set = set_of(quantities(at))
         return
      end do
   end function set_with

   !> Returns the symbol of a column, as gnuplot typesets it: the character after `_` is a subscript. A column without a
   !> symbol has its name.
   pure function symbol_of(name) result(symbol)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: symbol
      character(len=len(quantities%symbols)) :: symbols
      integer :: at, i
      at = position_of(name)
      symbols = ''
      if (at > 0) symbols = numbered(quantities(max(at, 1))%symbols, quantities(max(at, 1)))
      if (symbols == '') then
         symbol = escaped(trim(name), '_^{}@&~\', '\')
         if (at > 0) symbol = escaped(base_name(name), '_^{}@&~\', '\')
         return
      end if
      i = 1
      if (quantities(at)%pattern == '') i = component_of(quantities(at), base_name(name)) - quantities(at)%first + 1
      associate (words => split_list(symbols))
         symbol = trim(words(i))
      end associate
   end function symbol_of

   !> Returns the title of the panel of a column, with its unit.
   pure function label_of_column(name) result(label)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: label
      integer :: at
      at = position_of(name)
      label = trim(name)
      if (at > 0) label = label_of(quantities(at), name)
   end function label_of_column

   !> Returns true for an angle that jumps by 2π.
   pure logical function is_wrapped(name)
      character(len=*), intent(in) :: name
      integer :: at
      at = position_of(name)
      is_wrapped = .false.
      ! Histories follow Euler angles continuously.
      if (at > 0) is_wrapped = quantities(at)%is_periodic .and. .not. quantities(at)%is_continuous .and. &
                               quantities(at)%kind /= Q_EULER
   end function is_wrapped

   !> Returns true if a pattern matches a name.
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
         case default
            if (name(i:i) /= pattern(i:i)) return
         end select
      end do
      matches = len(name) == len(pattern)
   end function matches

   !> Returns the name of a column without the mark of degrees, which a derivative has behind its numerator.
   pure function base_name(name) result(base)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: base
      base = numerator(name)
      if (in_degrees(base)) base = base(:len(base) - 4)
      base = base//trim(name(len(numerator(name)) + 1:))
   end function base_name

   !> Returns the quantity of which a column is the derivative; any other column as it is.
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

   !> Returns the title of the panel of a quantity, with its unit.
   pure function label_of(quantity, name) result(label)
      type(quantity_t), intent(in) :: quantity
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: label, unit
      integer :: star
      label = trim(numbered(quantity%label, quantity))
      star = index(label, '*')
      if (star > 0) label = label(:star - 1)//trim(name(index(name, '/d_') + len('/d_'):))
      unit = trim(quantity%unit)
      if (in_degrees(numerator(name))) unit = '°'//unit(len('rad') + 1:)
      if (unit /= '') label = label//' ('//unit//')'
   end function label_of

   !> Returns the columns that a word stands for: one of that name, or those of a set; shape (that of `names`).
   pure function columns_named(word, names) result(chosen)
      character(len=*), intent(in) :: word
      character(len=*), intent(in) :: names(:)
      logical :: chosen(size(names))
      integer :: i, k
      chosen = names == word
      if (any(chosen)) return
      do i = 1, size(names)
         chosen(i) = base_name(names(i)) == word
         do k = 1, size(quantities)
            if (set_of(quantities(k)) == word) chosen(i) = chosen(i) .or. shows(quantities(k), names(i))
         end do
      end do
   end function columns_named

end module nutate_plot_panels
