!> Bodies of the procedures whose interfaces are in `nutate_quantities`.
submodule(nutate_quantities) nutate_quantities_procedures
   use nutate_control_quantities, only: has_controller, has_field
   use nutate_effect_columns, only: energy_headers, work_headers
   implicit none

contains

   module procedure numbered
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
   end procedure numbered

   module procedure set_of
      set = numbered(quantity%set, quantity)
   end procedure set_of

   module procedure set_names
      integer :: k
      names = set_of(pack(quantities, [(k == 1 .or. .not. are_one_set(quantities(max(k - 1, 1)), quantities(k)), &
                                        k=1, size(quantities))]))
   end procedure set_names

   !> Returns true for two quantities of one set.
   elemental logical function are_one_set(one, other)
      type(quantity_t), intent(in) :: one, other
      are_one_set = one%set == other%set .and. one%number == other%number .and. one%sequence == other%sequence
   end function are_one_set

   module procedure find_set
      do first = 1, size(quantities)
         if (set_of(quantities(first)) == name) return
      end do
      first = 0
   end procedure find_set

   module procedure turns_to_degrees
      turns_to_degrees = index(quantity%unit, 'rad') == 1 .and. .not. quantity%in_radians
   end procedure turns_to_degrees

   module procedure reason_of
      reason = trim(merge(quantity%no_event, quantity%no_measurement, use == AS_EVENT))
   end procedure reason_of

   module procedure serves
      serves = merge(quantity%no_event, quantity%no_measurement, use == AS_EVENT) == ''
   end procedure serves

   module procedure find_quantity
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
   end procedure find_quantity

   module procedure component_of
      character(len=len(quantity%names)) :: names
      integer :: at, k
      component = 0
      names = numbered(quantity%names, quantity)
      at = index(','//trim(names)//',', ','//trim(name)//',')
      if (at > 0) component = quantity%first + count([(names(k:k) == ',', k=1, at - 1)])
   end procedure component_of

   module procedure names_for
      integer :: k
      names = ''
      do k = 1, size(quantities)
         if (serves(quantities(k), use) .and. quantities(k)%names /= '') &
            names = names//','//headers_of(quantities(k), degrees=.false.)
      end do
      names = names(2:)
   end procedure names_for

   module procedure last_of_set
      do last = first, size(quantities) - 1
         if (.not. are_one_set(quantities(last + 1), quantities(first))) return
      end do
   end procedure last_of_set

   module procedure width_of
      integer :: k
      width = 1 + count([(quantity%names(k:k) == ',', k=1, len_trim(quantity%names))])
   end procedure width_of

   module procedure headers_of
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
   end procedure headers_of

   module procedure set_headers
      integer :: k
      headers = ''
      do k = find_set(set), last_of_set(find_set(set))
         if (quantities(k)%names /= '') headers = headers//','//headers_of(quantities(k), degrees=.false.)
      end do
      headers = headers(2:)
   end procedure set_headers

   module procedure depends_on_orbit
      depends_on_orbit = quantity%needs == NEEDS_ORBIT .or. quantity%needs == NEEDS_SUN
   end procedure depends_on_orbit

   module procedure find_missing
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

   end procedure find_missing

end submodule nutate_quantities_procedures
