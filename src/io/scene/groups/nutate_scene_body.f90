!> `&body`: the rigid body from its moments, its tensor or its shape.
module nutate_scene_body
   use nutate_admissible, only: POSITIVE, SHAPE_LENGTH
   use nutate_body, only: body_t, diagonal, make_body, make_shape_body, symmetric
   use nutate_center_change, only: center_change_t, make_tabulated_center
   use nutate_inertia_change, only: inertia_change_t, make_tabulated_inertia
   use nutate_keys, only: group_t, key_t, name_length, KEY_LOGICAL, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_scene_error, only: scene_error_t, allow_one_of, demand_one_of, demand_with
   use nutate_shapes, only: shape_kinds
   use nutate_spelling, only: joined
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: body_keys, build_body, build_center_table, build_inertia_table, check_body_keys, rebuild_body

contains

   !> Keys of the scene group `&body`.
   pure function body_keys() result(keys)
      type(key_t) :: keys(15)
      character(len=*), parameter :: shapes(*) = shape_kinds%name

      keys = [key_t(name='inertia', least=3, most=3), &
              key_t(name='inertia_tensor', least=6, most=6), &
              key_t(name='shape', kind=KEY_TEXT, choices=joined(shapes)), &
              key_t(name='size', most=maxval(shape_kinds%sizes), range=SHAPE_LENGTH), &
              key_t(name='mass', range=POSITIVE), &
              key_t(name='density', range=POSITIVE), &
              key_t(name='center_of_mass', least=3, most=3), &
              key_t(name='center_of_mass_table', kind=KEY_TEXT), &
              key_t(name='center_of_mass_interpolation', kind=KEY_TEXT, choices='linear,cubic', default='linear', &
                    beside='center_of_mass_table'), &
              key_t(name='inertia_about', kind=KEY_TEXT, choices='reference,center_of_mass'), &
              key_t(name='check_triangle', kind=KEY_LOGICAL), &
              key_t(name='inertia_table', kind=KEY_TEXT), &
              key_t(name='inertia_interpolation', kind=KEY_TEXT, choices='linear,cubic', default='linear', &
                    beside='inertia_table'), &
              key_t(name='inertia_scale', range=POSITIVE, default='1', beside='inertia_table'), &
              key_t(name='mass_leaves', kind=KEY_LOGICAL, default='.false.', beside='inertia_table')]
   end function body_keys

   !> Builds the body of a scene.
   subroutine build_body(group, body, shape, error)
      type(group_t), intent(in) :: group
      type(body_t), intent(out) :: body
      !> Name of the shape; blank if the inertia is given.
      character(len=:), allocatable, intent(out) :: shape
      type(scene_error_t), intent(inout) :: error
      shape = trim(group%text('shape', ''))
      call check_body_keys(group, error)
      if (.not. error%raised) call rebuild_body(group, shape, body, error)
   end subroutine build_body

   !> Builds the body of a group whose keys have been checked.
   subroutine rebuild_body(group, shape, body, error)
      type(group_t), intent(in) :: group
      !> Name of the shape; blank if the inertia is given.
      character(len=*), intent(in) :: shape
      type(body_t), intent(out) :: body
      type(scene_error_t), intent(inout) :: error
      type(status_t) :: status
      if (shape /= '') then
         call build_shape(group, shape, body, status)
      else
         call build_inertia(group, body, status)
      end if
      ! A group of the libraries, without a line, has no such key.
      if (body%breaks_triangle .and. group%line > 0) &
         status%message = trim(status%message)//' (check_triangle = .false. accepts them)'
      if (.not. status%ok()) call error%raise_status(line_at_fault(group, trim(status%subject)), status)
   end subroutine rebuild_body

   !> Checks keys that exclude or require each other.
   subroutine check_body_keys(group, error)
      type(group_t), intent(in) :: group
      type(scene_error_t), intent(inout) :: error

      call allow_one_of(group, [character(len=name_length) :: 'inertia', 'inertia_tensor', 'shape', 'inertia_table'], &
                        error)
      call allow_one_of(group, [character(len=name_length) :: 'inertia', 'inertia_tensor', 'size', 'inertia_table'], &
                        error)
      call demand_with(group, 'inertia_interpolation', 'inertia_table', error)
      call demand_with(group, 'inertia_scale', 'inertia_table', error)
      call demand_with(group, 'mass_leaves', 'inertia_table', error)
      call allow_one_of(group, [character(len=name_length) :: 'center_of_mass', 'center_of_mass_table'], error)
      call demand_with(group, 'center_of_mass_interpolation', 'center_of_mass_table', error)
      if (group%has('center_of_mass_table')) call check_moving_center(group, error)
      call allow_one_of(group, [character(len=name_length) :: 'mass', 'density'], error)
      call demand_with(group, 'shape', 'size', error)
      call demand_with(group, 'size', 'shape', error)
      call demand_one_of(group, [character(len=name_length) :: 'inertia', 'inertia_tensor', 'shape', 'inertia_table'], &
                         error)
      if (group%flag('mass_leaves', .false.) .and. group%text('inertia_about', 'reference') /= 'reference') &
         call error%raise(group%line_of('inertia_about'), 'the inertia about the centre of mass needs a constant '// &
                          "mass", expected="inertia_about = 'reference' with mass_leaves")
      if (group%has('shape')) then
         call demand_one_of(group, [character(len=name_length) :: 'mass', 'density'], error)
         if (group%text('inertia_about', 'center_of_mass') /= 'center_of_mass') &
            call error%raise(group%line_of('inertia_about'), 'the inertia of a shape is about its centre of mass', &
                             expected="inertia_about = 'center_of_mass', or none")
      else if (group%has('density')) then
         call error%raise(group%line_of('density'), 'density without a shape', expected='mass, or a shape')
      end if
   end subroutine check_body_keys

   !> Checks the other keys of a body whose centre of mass moves.
   subroutine check_moving_center(group, error)
      type(group_t), intent(in) :: group
      type(scene_error_t), intent(inout) :: error
      if (group%flag('mass_leaves', .false.)) then
         call error%raise(group%line_of('mass_leaves'), 'the weight of a body whose centre of mass moves needs a '// &
                          'constant mass', expected='center_of_mass_table without mass_leaves')
      else if (group%has('shape')) then
         call error%raise(group%line_of('shape'), 'the inertia of a shape needs a centre of mass that stays', &
                          expected='inertia, inertia_tensor or inertia_table with center_of_mass_table')
      else if (group%text('inertia_about', 'reference') /= 'reference') then
         call error%raise(group%line_of('inertia_about'), 'the centre of mass moves', &
                          expected="inertia_about = 'reference' with center_of_mass_table")
      end if
   end subroutine check_moving_center

   !> Builds a body of a homogeneous shape.
   subroutine build_shape(group, shape, body, status)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: shape
      type(body_t), intent(out) :: body
      type(status_t), intent(out) :: status
      real(wp) :: lengths(group%count_of('size')), center(3)

      lengths = group%vector('size', lengths)
      center = group%vector('center_of_mass', [0.0_wp, 0.0_wp, 0.0_wp])
      if (group%has('mass')) then
         call make_shape_body(shape, lengths, body, status, mass=group%number('mass', 0.0_wp), center_of_mass=center)
      else
         call make_shape_body(shape, lengths, body, status, density=group%number('density', 0.0_wp), &
                              center_of_mass=center)
      end if
   end subroutine build_shape

   !> Builds a body from moments or a tensor.
   subroutine build_inertia(group, body, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(out) :: body
      type(status_t), intent(out) :: status
      real(wp) :: tensor(3, 3), center(3)
      real(wp), allocatable :: mass
      type(center_change_t) :: path
      logical :: about_center

      tensor = given_tensor(group)
      if (group%has('inertia_table')) then
         call first_tensor(group, tensor, status)
         if (.not. status%ok()) return
      end if
      center = group%vector('center_of_mass', [0.0_wp, 0.0_wp, 0.0_wp])
      if (group%has('center_of_mass_table')) then
         call build_center_table(group, path, status)
         if (.not. status%ok()) return
         center = path%center_at(0.0_wp)
      end if
      about_center = group%text('inertia_about', 'reference') == 'center_of_mass'
      ! An allocatable that is not allocated is treated as an absent argument.
      if (group%has('mass')) mass = group%number('mass', 0.0_wp)
      call make_body(tensor, body, status, mass=mass, center_of_mass=center, about_center_of_mass=about_center, &
                     check_triangle=group%flag('check_triangle', .true.))
   end subroutine build_inertia

   !> Computes the tensor of a table at t = 0, body axes, kg m². Errors: those of `build_inertia_table`.
   subroutine first_tensor(group, tensor, status)
      type(group_t), intent(in) :: group
      real(wp), intent(out) :: tensor(3, 3)
      type(status_t), intent(out) :: status
      type(inertia_change_t) :: change
      tensor = 0.0_wp
      call build_inertia_table(group, change, status)
      if (status%ok()) tensor = change%scale*change%tabulated_at(0.0_wp)
   end subroutine first_tensor

   !> Builds the change of the inertia that a table describes. Errors: those of `make_tabulated_inertia`;
   !> `NUTATE_BAD_ARGUMENT` if the table has not been read.
   subroutine build_inertia_table(group, change, status)
      !> Group `&body` with its table.
      type(group_t), intent(in) :: group
      type(inertia_change_t), intent(inout) :: change
      type(status_t), intent(out) :: status
      integer :: at
      if (.not. allocated(group%table)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the table has not been read', 'inertia_table')
         return
      end if
      associate (numbers => group%table%numbers)
         call make_tabulated_inertia(numbers(1, :), numbers(2:, :), change, status, at, &
                                     spline=group%text('inertia_interpolation', 'linear') == 'cubic', &
                                     mass_leaves=group%flag('mass_leaves', .false.), &
                                     scale=group%number('inertia_scale', 1.0_wp))
      end associate
   end subroutine build_inertia_table

   !> Builds the path of the centre of mass that a table describes. Errors: those of `make_tabulated_center`;
   !> `NUTATE_BAD_ARGUMENT` if the table has not been read.
   subroutine build_center_table(group, change, status)
      !> Group `&body` with its tables.
      type(group_t), intent(in) :: group
      type(center_change_t), intent(inout) :: change
      type(status_t), intent(out) :: status
      integer :: at
      if (.not. allocated(group%center_table)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the table has not been read', 'center_of_mass_table')
         return
      end if
      associate (numbers => group%center_table%numbers)
         call make_tabulated_center(numbers(1, :), numbers(2:4, :), change, status, at, &
                                    spline=group%text('center_of_mass_interpolation', 'linear') == 'cubic')
      end associate
   end subroutine build_center_table

   !> Returns the tensor that `inertia` or `inertia_tensor` gives, body axes, kg m².
   pure function given_tensor(group) result(tensor)
      type(group_t), intent(in) :: group
      real(wp) :: tensor(3, 3)
      real(wp) :: j(6)

      j = 0.0_wp
      if (group%has('inertia')) then
         tensor = diagonal(group%vector('inertia', j(1:3)))
         return
      end if
      tensor = symmetric(group%vector('inertia_tensor', j))
   end function given_tensor

   !> Returns the line of the key at fault: the one that gave the inertia, or the subject itself.
   pure integer function line_at_fault(group, subject) result(line)
      type(group_t), intent(in) :: group
      !> `inertia`, `mass`, ...; blank for the whole group.
      character(len=*), intent(in) :: subject

      line = group%line_of(subject)
      if (group%has(subject)) return
      select case (subject)
      case ('inertia')
         if (group%has('inertia_tensor')) line = group%line_of('inertia_tensor')
         if (group%has('size')) line = group%line_of('size')
         if (group%has('inertia_table')) line = group%line_of('inertia_table')
      case ('mass')
         line = group%line_of('density')
      case default
         line = group%line
      end select
   end function line_at_fault

end module nutate_scene_body
