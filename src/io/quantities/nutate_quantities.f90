!> The table of quantities: what histories, events, measurements, sweeps and pictures can show. Names, units, panels and
!> the reasons of errors are read from it. Each family of quantities is a file with its entries, values and rates: a new
!> quantity is an entry and a case of one of them.
module nutate_quantities
   use nutate_control_quantities, only: control_quantities, has_controller, has_field
   use nutate_effect_list, only: effect_list_t
   use nutate_energy_quantities, only: effect_quantities, energy_quantities, time_dependent_quantities
   use nutate_frame_quantities, only: frame_quantities
   use nutate_motion_quantities, only: followed_quantities, motion_quantities
   use nutate_orbit_quantities, only: orbit_quantities, roll_pitch_yaw_quantities
   use nutate_propagated_columns, only: propagated_quantities
   use nutate_quantity, only: quantity_t, AS_EVENT, NEEDS_CONTROLLER, NEEDS_FIELD, NEEDS_FRAME, NEEDS_NO_ROTOR, &
      NEEDS_ORBIT, NEEDS_POTENTIAL, NEEDS_SPHERE, NEEDS_SUN, NEEDS_TARGET, NEEDS_WHEEL, NEEDS_WORK
   use nutate_tumbling_quantities, only: tumbling_quantities
   use nutate_wheel_quantities, only: wheel_quantities
   implicit none
   private

   public :: quantities
   public :: component_of, depends_on_orbit, find_missing, find_quantity, find_set, headers_of, last_of_set, &
      names_for, numbered, reason_of, serves, set_headers, set_names, set_of, turns_to_degrees, width_of

   type(quantity_t), parameter :: table(*) = [ &
      motion_quantities, energy_quantities, orbit_quantities, time_dependent_quantities, wheel_quantities, &
      roll_pitch_yaw_quantities, followed_quantities, effect_quantities, control_quantities, tumbling_quantities, &
      frame_quantities, propagated_quantities]
   !> All quantities, in the order in which they stand in a history, stored once: a constant would be copied into every
   !> expression with an index.
   type(quantity_t), protected :: quantities(size(table)) = table

contains

   !> Returns a text of the table with the number, or the sequence, of a quantity.
   elemental function numbered(text, quantity) result(full)
      character(len=*), intent(in) :: text
      type(quantity_t), intent(in) :: quantity
      character(len=len(text)) :: full
      character(len=1), parameter :: digits(*) = ['1', '2', '3', '4', '5', '6']
      integer :: k, n
      full = ''
      n = 0
      do k = 1, len_trim(text)
         n = n + 1
         if (text(k:k) /= '#') then
            full(n:n) = text(k:k)
         else if (quantity%sequence == '') then
            full(n:n) = digits(quantity%number)
         else
            full(n:n + 2) = quantity%sequence
            n = n + 2
         end if
      end do
   end function numbered

   !> Returns the name of the set of a quantity.
   elemental function set_of(quantity) result(set)
      type(quantity_t), intent(in) :: quantity
      character(len=24) :: set
      set = numbered(quantity%set, quantity)
   end function set_of

   !> Returns the names of all sets, in the order of the table.
   pure function set_names() result(names)
      character(len=24), allocatable :: names(:)
      integer :: k
      names = set_of(pack(quantities, [(k == 1 .or. .not. are_one_set(quantities(max(k - 1, 1)), quantities(k)), &
                                        k=1, size(quantities))]))
   end function set_names

   !> Returns true for two quantities of one set.
   elemental logical function are_one_set(one, other)
      type(quantity_t), intent(in) :: one, other
      are_one_set = one%set == other%set .and. one%number == other%number .and. one%sequence == other%sequence
   end function are_one_set

   !> Returns the position of the first quantity of a set by its name; 0 for an unknown name.
   pure integer function find_set(name) result(first)
      character(len=*), intent(in) :: name
      do first = 1, size(quantities)
         if (set_of(quantities(first)) == name) return
      end do
      first = 0
   end function find_set

   !> Returns true if `degrees` of a scene changes the unit of a quantity.
   elemental logical function turns_to_degrees(quantity)
      type(quantity_t), intent(in) :: quantity
      turns_to_degrees = index(quantity%unit, 'rad') == 1 .and. .not. quantity%in_radians
   end function turns_to_degrees

   !> Returns why a quantity cannot be an event or a measurement; blank if it can.
   pure function reason_of(quantity, use) result(reason)
      type(quantity_t), intent(in) :: quantity
      !> `AS_EVENT` or `AS_MEASUREMENT`.
      integer, intent(in) :: use
      character(len=:), allocatable :: reason
      reason = trim(merge(quantity%no_event, quantity%no_measurement, use == AS_EVENT))
   end function reason_of

   !> Returns true for a quantity that has a use.
   elemental logical function serves(quantity, use)
      type(quantity_t), intent(in) :: quantity
      !> `AS_EVENT` or `AS_MEASUREMENT`.
      integer, intent(in) :: use
      serves = merge(quantity%no_event, quantity%no_measurement, use == AS_EVENT) == ''
   end function serves

   !> Returns the position of a quantity in the table, of two of one name that which needs no orbit; 0 for an unknown
   !> name, or one without the use.
   pure integer function find_quantity(name, use) result(at)
      character(len=*), intent(in) :: name
      !> `AS_EVENT` or `AS_MEASUREMENT`; default: any.
      integer, intent(in), optional :: use
      integer :: i
      at = 0
      do i = 1, size(quantities)
         if (component_of(quantities(i), name) == 0) cycle
         if (present(use)) then
            if (.not. serves(quantities(i), use)) cycle
         end if
         at = i
         if (quantities(i)%needs /= NEEDS_ORBIT) return
      end do
   end function find_quantity

   !> Returns the position of a name among the components of the quantity's kind; 0: it has another name.
   pure integer function component_of(quantity, name) result(component)
      type(quantity_t), intent(in) :: quantity
      character(len=*), intent(in) :: name
      character(len=len(quantity%names)) :: names
      integer :: at, k
      component = 0
      names = numbered(quantity%names, quantity)
      at = index(','//trim(names)//',', ','//trim(name)//',')
      if (at > 0) component = quantity%first + count([(names(k:k) == ',', k=1, at - 1)])
   end function component_of

   !> Returns the names of all components that have a use, comma separated.
   pure function names_for(use) result(names)
      !> `AS_EVENT` or `AS_MEASUREMENT`.
      integer, intent(in) :: use
      character(len=:), allocatable :: names
      integer :: k
      names = ''
      do k = 1, size(quantities)
         if (serves(quantities(k), use) .and. quantities(k)%names /= '') &
            names = names//','//headers_of(quantities(k), degrees=.false.)
      end do
      names = names(2:)
   end function names_for

   !> Returns the position of the last quantity of a set.
   pure integer function last_of_set(first) result(last)
      !> Position of a quantity of the set.
      integer, intent(in) :: first
      do last = first, size(quantities) - 1
         if (.not. are_one_set(quantities(last + 1), quantities(first))) return
      end do
   end function last_of_set

   !> Returns the number of components of a quantity.
   elemental integer function width_of(quantity) result(width)
      type(quantity_t), intent(in) :: quantity
      integer :: k
      width = 1 + count([(quantity%names(k:k) == ',', k=1, len_trim(quantity%names))])
   end function width_of

   !> Returns the names of the columns of a quantity, comma separated.
   pure function headers_of(quantity, degrees) result(headers)
      type(quantity_t), intent(in) :: quantity
      !> True if angles and rates are in degrees; their names then end in `_deg`.
      logical, intent(in) :: degrees
      character(len=:), allocatable :: headers
      character(len=len(quantity%names)) :: names
      integer :: k
      names = numbered(quantity%names, quantity)
      headers = trim(names)
      if (.not. (degrees .and. turns_to_degrees(quantity))) return
      headers = ''
      do k = 1, len_trim(names)
         if (names(k:k) == ',') headers = headers//'_deg'
         headers = headers//names(k:k)
      end do
      headers = headers//'_deg'
   end function headers_of

   !> Returns the names of the columns of a set, comma separated.
   pure function set_headers(set) result(headers)
      character(len=*), intent(in) :: set
      character(len=:), allocatable :: headers
      integer :: k
      headers = ''
      do k = find_set(set), last_of_set(find_set(set))
         if (quantities(k)%names /= '') headers = headers//','//headers_of(quantities(k), degrees=.false.)
      end do
      headers = headers(2:)
   end function set_headers

   !> Returns true for a quantity that does not exist without an orbit.
   elemental logical function depends_on_orbit(quantity)
      type(quantity_t), intent(in) :: quantity
      depends_on_orbit = quantity%needs == NEEDS_ORBIT .or. quantity%needs == NEEDS_SUN
   end function depends_on_orbit

   !> Finds the requirement of a quantity that a system does not meet.
   subroutine find_missing(quantity, effects, missing, expected)
      use nutate_effect_columns, only: energy_headers, work_headers
      type(quantity_t), intent(in) :: quantity
      type(effect_list_t), intent(in) :: effects
      !> Predicate such as `need a potential`, and what to write; empty if nothing is missing.
      character(len=:), allocatable, intent(out) :: missing, expected
      logical :: has_sun
      missing = ''
      expected = ''
      associate (n => quantity%number)
         select case (quantity%needs)
         case (NEEDS_WHEEL)
            if (n > effects%n_reaction_wheels) call refer_to('a wheel', 'one group &wheel for each')
         case (NEEDS_SPHERE)
            if (n > effects%n_spheres) call refer_to('an inner sphere', 'one group &inner_sphere for each')
         case (NEEDS_CONTROLLER)
            if (.not. has_controller(n, .false., effects)) &
               call refer_to('a controller', 'one group &controller for each')
         case (NEEDS_TARGET)
            if (.not. has_controller(n, .true., effects)) &
               call refer_to('a controller', 'one group &controller for each, which points')
         case (NEEDS_FIELD)
            if (.not. has_field(effects)) call refer_to('a field', '&earth_field, or field in &controller or &dipole')
         case (NEEDS_ORBIT, NEEDS_SUN)
            has_sun = .false.
            if (effects%on_orbit) has_sun = effects%orbit%has_sun()
            if (quantity%needs == NEEDS_SUN .and. .not. has_sun) call refer_to('a sun', 'sun in &orbit')
            if (.not. effects%on_orbit) call refer_to('an orbit', '&orbit')
         case (NEEDS_FRAME)
            if (n > effects%n_frames) call refer_to('a frame', 'one group &frame for each')
         case (NEEDS_NO_ROTOR)
            if (effects%n_rotors > 0) call need('a body without rotors, wheels and inner spheres', &
                                                'no &rotor, no &wheel and no &inner_sphere')
            if (effects%varies) call need('a constant inertia', 'no inertia_rate and inertia_table')
         case (NEEDS_POTENTIAL)
            if (energy_headers(effects) == '') call need('a potential', 'one, such as &gravity')
         case (NEEDS_WORK)
            if (work_headers(effects) == '') call need('an effect that does work', 'one, such as &torque')
         case default
            continue
         end select
      end associate

   contains

      subroutine refer_to(what, instead)
         character(len=*), intent(in) :: what, instead
         missing = 'refer to '//what//' that does not exist'
         expected = instead
      end subroutine refer_to

      subroutine need(what, instead)
         character(len=*), intent(in) :: what, instead
         missing = 'need '//what
         expected = instead
      end subroutine need

   end subroutine find_missing

end module nutate_quantities
