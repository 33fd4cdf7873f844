!> Arguments of C functions as the groups of a scene: values from programs have the same limits as values in scenes.
module nutate_c_groups
   use, intrinsic :: iso_c_binding, only: c_size_t
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_effect_list, only: effect_list_t
   use nutate_event_list, only: event_list_t
   use nutate_effect, only: effect_t
   use nutate_keys, only: group_kind_t, group_t, table_t
   use nutate_kinds, only: wp
   use nutate_scene_body, only: body_keys, build_body
   use nutate_scene_check, only: check_complete, read_groups
   use nutate_scene_effects, only: build_effects
   use nutate_scene_table, only: read_effect_table
   use nutate_scene_events, only: build_events, event_keys
   use nutate_scene, only: scene_kinds
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_values, only: check_values
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_SCENE
   use nutate_system, only: system_t
   use nutate_tabulated_torque, only: make_tabulated_torque, tabulated_torque_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_group, only: build_wheel, wheel_keys
   use nutate_wheel_mounting, only: mount_wheels
   implicit none
   private

   public :: make_body_of, add_effect_of, add_motor_of, build_system, parse_events, parse_motor_keys, parse_table_keys

contains

   !> Makes the body that a group `body` describes. Errors: `NUTATE_BAD_ARGUMENT`, `NUTATE_BAD_BODY`.
   subroutine make_body_of(group, system, status)
      type(group_t), intent(in) :: group
      type(system_t), intent(inout) :: system
      type(status_t), intent(out) :: status
      type(scene_error_t) :: error
      character(len=:), allocatable :: shape
      call check_values(group, body_keys(), error)
      if (.not. error%raised) call build_body(group, system%body, shape, error)
      if (error%raised) status = fail(error%code, error%text)
   end subroutine make_body_of

   !> Adds the effect that a group describes. Errors: `NUTATE_BAD_ARGUMENT`; `NUTATE_BAD_BODY` without a mass that is
   !> needed.
   subroutine add_effect_of(group, system, status)
      type(group_t), intent(in) :: group
      type(system_t), intent(inout) :: system
      type(status_t), intent(out) :: status
      type(effect_kind_t), allocatable :: kinds(:)
      type(group_t) :: groups(1)
      type(scene_error_t) :: error
      integer :: k
      kinds = effect_kinds()
      do k = 1, size(kinds)
         if (kinds(k)%group%name == group%name) call check_values(group, kinds(k)%group%keys, error)
      end do
      groups(1) = group
      if (.not. error%raised) call build_effects(groups, system, error)
      if (error%raised) status = fail(error%code, error%text)
   end subroutine add_effect_of

   !> Reads the events of a string in the format of a scene, with columns or without. Errors: `NUTATE_BAD_SCENE`.
   subroutine parse_events(text, with_columns, effects, accuracy, events, status, whole)
      character(len=*), intent(in) :: text
      !> True if each event names its columns; false if none does.
      logical, intent(in) :: with_columns
      !> Effects that events can switch.
      type(effect_list_t), intent(in) :: effects
      !> Attitude error that runs promise, rad; 0: none.
      real(wp), intent(in) :: accuracy
      type(event_list_t), intent(inout) :: events
      type(status_t), intent(out) :: status
      !> Complete error message, if there is an error.
      character(len=:), allocatable, intent(inout) :: whole
      type(group_kind_t) :: kinds(1)
      type(group_t), allocatable :: groups(:)
      type(scene_error_t) :: error
      integer :: i, last_line
      kinds(1)%name = 'event'
      kinds(1)%keys = event_keys()
      kinds(1)%repeatable = .true.
      if (.not. with_columns) then
         do i = 1, size(kinds(1)%keys)
            kinds(1)%keys(i)%required = .false.
         end do
      end if
      call read_groups(text, kinds, groups, last_line, error)
      if (.not. error%raised) call check_complete(kinds, groups, 1, error)
      if (.not. (error%raised .or. with_columns)) then
         do i = 1, size(groups)
            if (groups(i)%has('when')) call error%raise(groups(i)%line, 'when is not allowed here', &
                                                        expected='a quantity of the program alone')
            if (groups(i)%has('weights')) call error%raise(groups(i)%line, 'weights are not allowed here')
         end do
      end if
      if (.not. error%raised) call build_events(groups, effects, accuracy, events, error)
      if (.not. error%raised) return
      status = fail(NUTATE_BAD_SCENE, error%text)
      whole = error%text
   end subroutine parse_events

   !> Makes a tabulated torque from arrays, with the keys of `&torque` that a table can have. Errors:
   !> `NUTATE_BAD_SCENE`; those of `make_tabulated_torque`.
   subroutine parse_table_keys(text, times, values, torque, at, status)
      !> Keys of `&torque`.
      character(len=*), intent(in) :: text
      !> Times, s; shape (n). Torques, N m; shape (3, n).
      real(wp), intent(in) :: times(:), values(:, :)
      type(tabulated_torque_t), intent(inout) :: torque
      !> Line of the table that is wrong; 0 if no single line is.
      integer, intent(out) :: at
      type(status_t), intent(out) :: status
      type(group_t), allocatable :: groups(:)
      type(scene_error_t) :: error
      integer :: last_line
      at = 0
      call read_groups('&torque table = ''memory'' '//text//' /', scene_kinds(), groups, last_line, error)
      if (.not. error%raised .and. size(groups) /= 1) call error%raise(1, 'more than the keys of one torque')
      if (.not. error%raised) call check_alone(groups(1), error)
      if (error%raised) then
         status = fail(NUTATE_BAD_SCENE, error%text)
         return
      end if
      associate (group => groups(1))
         call make_tabulated_torque(times, values, torque, status, at, &
                                    spline=group%text('interpolation', 'linear') == 'cubic', &
                                    periodic=group%text('outside', 'zero') == 'periodic', &
                                    in_space=group%text('axes', 'body') == 'space', &
                                    start=group%number('start', -huge(1.0_wp)), stop=group%number('stop', huge(1.0_wp)))
         torque%label = group%text('name', '')
         torque%on = group%flag('on', .true.)
      end associate
   end subroutine parse_table_keys

   !> Makes a group from the keys of `&wheel` that a table can have, and from the table. Errors: `NUTATE_BAD_SCENE`.
   subroutine parse_motor_keys(text, table, group, status)
      !> Keys of `&wheel`.
      character(len=*), intent(in) :: text
      !> Times, s, and torques, N m.
      type(table_t), intent(in) :: table
      type(group_t), intent(inout) :: group
      type(status_t), intent(out) :: status
      character(len=13), parameter :: known(5) = [character(len=13) :: &
                                                  'table', 'interpolation', 'outside', 'start', 'stop']
      type(group_t), allocatable :: groups(:)
      type(scene_error_t) :: error
      integer :: i, last_line
      call read_groups('&wheel table = ''memory'' '//text//' /', scene_kinds(), groups, last_line, error)
      if (.not. error%raised .and. size(groups) /= 1) call error%raise(1, 'more than the keys of one motor')
      if (.not. error%raised) then
         do i = 1, size(groups(1)%settings)
            if (.not. any(known == groups(1)%settings(i)%name)) call error%raise( &
               1, trim(groups(1)%settings(i)%name)//' is not allowed here', expected='keys of a table')
         end do
      end if
      if (error%raised) then
         status = fail(NUTATE_BAD_SCENE, error%text)
         return
      end if
      group = groups(1)
      group%table = table
   end subroutine parse_motor_keys

   !> Adds a motor, described by keys of `&wheel`, to a wheel of a system. Errors: those of the keys and of
   !> `build_motor`; `NUTATE_BAD_ARGUMENT` for a wheel that does not exist, or that is driven already.
   subroutine add_motor_of(group, number, system, status)
      !> Keys of the motor, without axis, inertia, speed, friction and limits.
      type(group_t), intent(inout) :: group
      !> Number of the wheel, 1 or more.
      integer(c_size_t), intent(in) :: number
      type(system_t), intent(inout) :: system
      type(status_t), intent(out) :: status
      class(effect_t), allocatable :: effect
      type(scene_error_t) :: error
      if (number < 1 .or. number > system%effects%n_reaction_wheels) then
         status = fail(NUTATE_BAD_ARGUMENT, 'wheel is out of range (expected 1 to the number of wheels)', 'wheel')
         return
      end if
      associate (wheel => system%effects%wheels(number))
         if (allocated(wheel%motor) .or. system%effects%controls_wheels()) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the wheel is driven already (expected one motor, or a controller)', &
                          'wheel')
            return
         end if
         group%name = 'wheel'
         call group%put('axis', wheel%axis)
         call group%put('inertia', [wheel%inertia])
         if (wheel%torque_limit < huge(1.0_wp)) call group%put('torque_limit', [wheel%torque_limit])
         if (wheel%speed_limit < huge(1.0_wp)) call group%put('speed_limit', [wheel%speed_limit])
         call check_values(group, wheel_keys, error)
         if (error%raised) then
            status = fail(error%code, error%text)
            return
         end if
         call build_wheel(group, system%body, effect, status)
         if (.not. status%ok()) return
         select type (effect)
         type is (wheel_t)
            call move_alloc(effect%motor, wheel%motor)
         end select
         wheel%motor%label = wheel%label
         wheel%motor%on = wheel%on
      end associate
   end subroutine add_motor_of

   !> Raises an error for a key of a torque that excludes a table.
   subroutine check_alone(group, error)
      type(group_t), intent(in) :: group
      type(scene_error_t), intent(inout) :: error
      character(len=9), parameter :: others(4) = [character(len=9) :: 'body', 'space', 'frequency', 'phase']
      integer :: i
      do i = 1, size(others)
         if (group%has(trim(others(i)))) call error%raise(group%line, trim(others(i))//' excludes a table')
      end do
   end subroutine check_alone

   !> Makes the body and the effects of a string in the format of a scene, or adds its effects alone. Errors:
   !> `NUTATE_BAD_SCENE`, with no effect added.
   subroutine build_system(text, with_body, system, status, whole)
      character(len=*), intent(in) :: text
      !> True if the string begins the system with a body; else it has effects only.
      logical, intent(in) :: with_body
      type(system_t), intent(inout) :: system
      type(status_t), intent(out) :: status
      !> Complete error message, if there is an error.
      character(len=:), allocatable, intent(inout) :: whole
      type(group_t), allocatable :: groups(:)
      type(scene_error_t) :: error
      type(system_t) :: built, grown
      character(len=:), allocatable :: shape
      integer :: i, last_line
      call read_groups(text, scene_kinds(), groups, last_line, error)
      if (.not. error%raised) call check_parts(groups, with_body, error)
      if (with_body .and. .not. error%raised) then
         do i = 1, size(groups)
            if (groups(i)%name /= 'body') cycle
            call read_effect_table(groups(i), '', error)
            if (.not. error%raised) call build_body(groups(i), built%body, shape, error)
         end do
      else
         built%body = system%body
         call copy_surroundings(system%effects, built%effects)
      end if
      if (.not. error%raised) call build_effects(groups, built, error)
      if (.not. error%raised .and. .not. with_body) call check_once(groups, system, error)
      if (error%raised) then
         status = fail(NUTATE_BAD_SCENE, error%text)
         whole = error%text
         return
      end if
      grown = system
      grown%body = built%body
      call grown%effects%append(built%effects)
      call mount_wheels(grown, status)
      if (status%ok()) system = grown
   end subroutine build_system

   !> Raises an error for a group that a scene may have only once, if the system already has its effect.
   subroutine check_once(groups, system, error)
      type(group_t), intent(in) :: groups(:)
      type(system_t), intent(in) :: system
      type(scene_error_t), intent(inout) :: error
      type(group_kind_t), allocatable :: kinds(:)
      integer :: i, k
      kinds = scene_kinds()
      do i = 1, size(groups)
         k = findloc(kinds%name == groups(i)%name, .true., dim=1)
         if (kinds(k)%repeatable) cycle
         if (has_effect_of(groups(i), system)) call error%raise( &
            groups(i)%line, 'a second group &'//trim(groups(i)%name), expected='only one')
      end do
   end subroutine check_once

   !> Returns true if a system has an effect of the kind that a group describes.
   logical function has_effect_of(group, system) result(has)
      type(group_t), intent(in) :: group
      type(system_t), intent(in) :: system
      type(system_t) :: alone
      type(group_t) :: groups(1)
      type(scene_error_t) :: error
      integer :: i
      alone%body = system%body
      if (group%name /= 'orbit') call copy_surroundings(system%effects, alone%effects)
      groups(1) = group
      call build_effects(groups, alone, error)
      has = .false.
      if (alone%effects%n_potentials > 0) then
         do i = 1, system%effects%n_potentials
            has = has .or. same_type_as(system%effects%potentials(i)%item, alone%effects%potentials(1)%item)
         end do
      else if (alone%effects%n_torques > 0) then
         do i = 1, system%effects%n_torques
            has = has .or. same_type_as(system%effects%torques(i)%item, alone%effects%torques(1)%item)
         end do
      else if (alone%effects%frame_turns .or. alone%effects%on_orbit) then
         has = system%effects%frame_turns .or. system%effects%on_orbit
      end if
   end function has_effect_of

   !> Copies the orbits and the Earth's field, from which effects are made, into a list.
   subroutine copy_surroundings(effects, list)
      type(effect_list_t), intent(in) :: effects
      type(effect_list_t), intent(inout) :: list
      integer :: i
      if (effects%on_orbit) then
         do i = 1, size(effects%orbits)
            call list%add(effects%orbits(i))
         end do
      end if
      list%in_earth_field = effects%in_earth_field
      if (effects%in_earth_field) allocate (list%earth_field, source=effects%earth_field)
   end subroutine copy_surroundings

   !> Raises an error for a group that no system can have, and for a missing key or body.
   subroutine check_parts(groups, with_body, error)
      type(group_t), intent(in) :: groups(:)
      logical, intent(in) :: with_body
      type(scene_error_t), intent(inout) :: error
      integer :: i
      do i = 1, size(groups)
         if (any(groups(i)%name == ['scene     ', 'initial   ', 'integrator', 'output    ', 'event     ', &
                                       'frame     ']) .or. &
             (groups(i)%name == 'body' .and. .not. with_body)) &
            call error%raise(groups(i)%line, '&'//trim(groups(i)%name)//' is not allowed here')
      end do
      if (with_body .and. .not. any(groups%name == 'body')) call error%raise(1, 'the group &body is missing')
      call check_keys(groups, error)
   end subroutine check_parts

   !> Raises an error for a key that a group lacks.
   subroutine check_keys(groups, error)
      type(group_t), intent(in) :: groups(:)
      type(scene_error_t), intent(inout) :: error
      type(group_kind_t), allocatable :: kinds(:)
      kinds = scene_kinds()
      kinds%required = .false.
      call check_complete(kinds, groups, 1, error)
   end subroutine check_keys

end module nutate_c_groups
