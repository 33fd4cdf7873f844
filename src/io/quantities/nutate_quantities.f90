!> The table of quantities: what histories, events, measurements, sweeps and pictures can show. Names, units, panels and
!> the reasons of errors are read from it. Each family of quantities is a file with its entries, values and rates: a new
!> quantity is an entry and a case of one of them.
module nutate_quantities
   use nutate_control_quantities, only: control_quantities
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

   interface

      !> Returns a text of the table with the number, or the sequence, of a quantity.
      elemental module function numbered(text, quantity) result(full)
         character(len=*), intent(in) :: text
         type(quantity_t), intent(in) :: quantity
         character(len=len(text)) :: full
      end function numbered

      !> Returns the name of the set of a quantity.
      elemental module function set_of(quantity) result(set)
         type(quantity_t), intent(in) :: quantity
         character(len=24) :: set
      end function set_of

      !> Returns the names of all sets, in the order of the table.
      pure module function set_names() result(names)
         character(len=24), allocatable :: names(:)
      end function set_names

      !> Returns the position of the first quantity of a set by its name; 0 for an unknown name.
      pure integer module function find_set(name) result(first)
         character(len=*), intent(in) :: name
      end function find_set

      !> Returns true if `degrees` of a scene changes the unit of a quantity.
      elemental logical module function turns_to_degrees(quantity)
         type(quantity_t), intent(in) :: quantity
      end function turns_to_degrees

      !> Returns why a quantity cannot be an event or a measurement; blank if it can.
      pure module function reason_of(quantity, use) result(reason)
         type(quantity_t), intent(in) :: quantity
         !> `AS_EVENT` or `AS_MEASUREMENT`.
         integer, intent(in) :: use
         character(len=:), allocatable :: reason
      end function reason_of

      !> Returns true for a quantity that has a use.
      elemental logical module function serves(quantity, use)
         type(quantity_t), intent(in) :: quantity
         !> `AS_EVENT` or `AS_MEASUREMENT`.
         integer, intent(in) :: use
      end function serves

      !> Returns the position of a quantity in the table, of two of one name that which needs no orbit; 0 for an unknown
      !> name, or one without the use.
      pure integer module function find_quantity(name, use) result(at)
         character(len=*), intent(in) :: name
         !> `AS_EVENT` or `AS_MEASUREMENT`; default: any.
         integer, intent(in), optional :: use
      end function find_quantity

      !> Returns the position of a name among the components of the quantity's kind; 0: it has another name.
      pure integer module function component_of(quantity, name) result(component)
         type(quantity_t), intent(in) :: quantity
         character(len=*), intent(in) :: name
      end function component_of

      !> Returns the names of all components that have a use, comma separated.
      pure module function names_for(use) result(names)
         !> `AS_EVENT` or `AS_MEASUREMENT`.
         integer, intent(in) :: use
         character(len=:), allocatable :: names
      end function names_for

      !> Returns the position of the last quantity of a set.
      pure integer module function last_of_set(first) result(last)
         !> Position of a quantity of the set.
         integer, intent(in) :: first
      end function last_of_set

      !> Returns the number of components of a quantity.
      elemental integer module function width_of(quantity) result(width)
         type(quantity_t), intent(in) :: quantity
      end function width_of

      !> Returns the names of the columns of a quantity, comma separated.
      pure module function headers_of(quantity, degrees) result(headers)
         type(quantity_t), intent(in) :: quantity
         !> True if angles and rates are in degrees; their names then end in `_deg`.
         logical, intent(in) :: degrees
         character(len=:), allocatable :: headers
      end function headers_of

      !> Returns the names of the columns of a set, comma separated.
      pure module function set_headers(set) result(headers)
         character(len=*), intent(in) :: set
         character(len=:), allocatable :: headers
      end function set_headers

      !> Returns true for a quantity that does not exist without an orbit.
      elemental logical module function depends_on_orbit(quantity)
         type(quantity_t), intent(in) :: quantity
      end function depends_on_orbit

      !> Finds the requirement of a quantity that a system does not meet.
      module subroutine find_missing(quantity, effects, missing, expected)
         type(quantity_t), intent(in) :: quantity
         type(effect_list_t), intent(in) :: effects
         !> Predicate such as `need a potential`, and what to write; empty if nothing is missing.
         character(len=:), allocatable, intent(out) :: missing, expected
      end subroutine find_missing

   end interface

end module nutate_quantities
