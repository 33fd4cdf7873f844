!> `&event`: conditions to find in a run, and the actions to take then.
module nutate_scene_events
   use nutate_admissible, only: POSITIVE
   use nutate_column_event, only: column_event_t, most_columns
   use nutate_control, only: beyond_accuracy
   use nutate_effect_list, only: effect_list_t
   use nutate_event, only: CROSSING, EXTREMUM, MAXIMUM, MINIMUM, SWITCH_OFF, SWITCH_ON, SWITCH_TOGGLE
   use nutate_event_list, only: event_list_t
   use nutate_keys, only: group_t, key_t, name_length, KEY_INTEGER, KEY_LOGICAL, KEY_TEXT
   use nutate_kinds, only: wp, long, pi
   use nutate_printable, only: quoted
   use nutate_orbit_quantities, only: Q_ORBIT_SPEED, Q_TRUE_ANOMALY
   use nutate_quantities, only: find_missing, find_quantity, names_for, quantities
   use nutate_quantity, only: quantity_t, AS_EVENT
   use nutate_scene_error, only: scene_error_t, allow_one_of
   use nutate_spelling, only: count_text
   implicit none
   private

   public :: event_keys, build_events, check_event_names, events_need_attitude, plain_name

contains

   !> Keys of the scene group `&event`.
   pure function event_keys() result(keys)
      type(key_t) :: keys(10)
      keys = [key_t(name='name', kind=KEY_TEXT), &
              key_t(name='when', kind=KEY_TEXT, most=most_columns, required=.true., choices=names_for(AS_EVENT)), &
              key_t(name='weights', most=most_columns), &
              key_t(name='crosses'), &
              key_t(name='modulo', range=POSITIVE), &
              key_t(name='extremum', kind=KEY_TEXT, choices='maximum,minimum,both'), &
              key_t(name='direction', kind=KEY_INTEGER), &
              key_t(name='stop', kind=KEY_LOGICAL), &
              key_t(name='count', kind=KEY_INTEGER, range=POSITIVE), &
              key_t(name='switch', kind=KEY_TEXT)]
   end function event_keys

   !> Builds the events of the groups, in their order.
   subroutine build_events(groups, effects, accuracy, events, error)
      type(group_t), intent(in) :: groups(:)
      !> Effects that events can switch.
      type(effect_list_t), intent(in) :: effects
      !> Attitude error that the run promises, rad; 0: none.
      real(wp), intent(in) :: accuracy
      type(event_list_t), intent(inout) :: events
      type(scene_error_t), intent(inout) :: error
      type(column_event_t) :: event
      character(len=name_length) :: names(size(groups))
      integer :: i
      names = event_names(groups)
      do i = 1, size(groups)
         if (groups(i)%name /= 'event' .or. error%raised) cycle
         event = column_event_t()
         call read_quantity(groups(i), effects, event, error)
         call read_kind(groups(i), event, error)
         call read_name(groups(i), names(i), event, error)
         event%stop = groups(i)%flag('stop', .false.)
         event%count = int(groups(i)%whole('count', 0), long)
         if (groups(i)%has('switch')) call read_switch(groups(i), effects, accuracy, event, error)
         if (.not. error%raised) call events%add(event)
      end do
   end subroutine build_events

   !> Raises an error if two events of an ensemble would have the same columns.
   subroutine check_event_names(groups, error)
      type(group_t), intent(in) :: groups(:)
      type(scene_error_t), intent(inout) :: error
      character(len=name_length) :: names(size(groups))
      integer :: i
      names = plain_name(event_names(groups))
      do i = 1, size(groups)
         if (groups(i)%name /= 'event' .or. all(names(:i - 1) /= names(i))) cycle
         call error%raise(groups(i)%line_of('name'), 'two events have the columns '//trim(names(i))//'_count and '// &
                          trim(names(i))//'_first', expected='a name for each')
         return
      end do
   end subroutine check_event_names

   !> Returns the name of each group that is an event: the given name, or else that of its first column, with a number
   !> from the second event of that name on. Shape (groups).
   pure function event_names(groups) result(names)
      type(group_t), intent(in) :: groups(:)
      character(len=name_length) :: names(size(groups))
      integer :: i, n
      names = ''
      do i = 1, size(groups)
         if (groups(i)%name == 'event' .and. groups(i)%has('name')) names(i) = groups(i)%text('name', '')
      end do
      do i = 1, size(groups)
         if (groups(i)%name /= 'event' .or. groups(i)%has('name') .or. .not. groups(i)%has('when')) cycle
         n = 1
         do
            names(i) = groups(i)%text('when', '')
            if (n > 1) names(i) = trim(names(i))//'_'//count_text(n)
            if (count(names == names(i)) == 1) exit
            n = n + 1
         end do
      end do
   end function event_names

   !> Returns a name without characters that the header of a table would have to mark.
   elemental function plain_name(name) result(text)
      character(len=*), intent(in) :: name
      character(len=len(name)) :: text
      character(len=*), parameter :: marks = ' ,;:''"\()[]{}'
      integer :: i
      text = name
      do i = 1, len_trim(text)
         if (scan(text(i:i), marks) > 0 .or. iachar(text(i:i)) > 126) text(i:i) = '_'
      end do
   end function plain_name

   !> Returns true if a column of an event depends on the attitude.
   pure logical function events_need_attitude(groups)
      type(group_t), intent(in) :: groups(:)
      integer :: i, k, at
      events_need_attitude = .false.
      do i = 1, size(groups)
         if (groups(i)%name /= 'event') cycle
         do k = 1, groups(i)%count_of('when')
            at = find_quantity(groups(i)%text_at('when', k), AS_EVENT)
            if (at == 0) cycle
            events_need_attitude = events_need_attitude .or. quantities(at)%attitude
         end do
      end do
   end function events_need_attitude

   !> Reads columns, weights and period of an event.
   subroutine read_quantity(group, effects, event, error)
      type(group_t), intent(in) :: group
      type(effect_list_t), intent(in) :: effects
      type(column_event_t), intent(inout) :: event
      type(scene_error_t), intent(inout) :: error
      integer :: i, n
      n = group%count_of('when')
      do i = 1, n
         event%columns(i) = group%text_at('when', i)
         call check_quantity(quantities(find_quantity(event%columns(i), AS_EVENT)), event%columns(i), &
                             group%line_of('when'), effects, error)
         if (error%raised) return
      end do
      call event%place()
      if (group%has('weights')) then
         if (group%count_of('weights') /= n) then
            call error%raise(group%line_of('weights'), 'the number of weights differs from the number of columns', &
                             expected='one for each column of when')
            return
         end if
         event%weights(1:n) = group%vector('weights', event%weights(1:n))
      end if
      if (n == 1 .and. .not. group%has('weights')) &
         event%period = merge(2*pi, 0.0_wp, quantities(find_quantity(event%columns(1), AS_EVENT))%is_periodic)
      event%period = group%number('modulo', event%period)
   end subroutine read_quantity

   !> Raises an error for a quantity that a scene does not have.
   subroutine check_quantity(quantity, name, line, effects, error)
      type(quantity_t), intent(in) :: quantity
      character(len=*), intent(in) :: name
      integer, intent(in) :: line
      type(effect_list_t), intent(in) :: effects
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: missing, expected
      integer :: verb
      call find_missing(quantity, effects, missing, expected)
      if (missing /= '') then
         verb = index(missing, ' ') - 1
         call error%raise(line, quoted(trim(name))//' '//missing(:verb)//'s'//missing(verb + 1:), expected)
      else if (quantity%kind == Q_TRUE_ANOMALY .or. quantity%kind == Q_ORBIT_SPEED) then
         if (allocated(effects%orbit%path%track)) &
            call error%raise(line, 'an event of '//quoted(trim(name))//' with a table of &orbit', &
                             expected='orbit_radius')
      end if
   end subroutine check_quantity

   !> Reads the kind of an event, crossing or extremum, and its level and direction.
   subroutine read_kind(group, event, error)
      type(group_t), intent(in) :: group
      type(column_event_t), intent(inout) :: event
      type(scene_error_t), intent(inout) :: error
      call allow_one_of(group, [character(len=name_length) :: 'crosses', 'extremum'], error)
      if (error%raised) return
      if (.not. (group%has('crosses') .or. group%has('extremum'))) then
         call error%raise(group%line, '&event has no condition', expected='crosses or extremum')
         return
      end if
      event%level = group%number('crosses', 0.0_wp)
      event%direction = group%whole('direction', 0)
      select case (group%text('extremum', ''))
      case ('maximum')
         event%kind = MAXIMUM
      case ('minimum')
         event%kind = MINIMUM
      case ('both')
         event%kind = EXTREMUM
      case default
         event%kind = CROSSING
      end select
      if (group%has('direction') .and. abs(event%direction) /= 1) then
         call error%raise(group%line_of('direction'), 'direction is out of range', expected='1 or -1')
      else if (event%kind /= CROSSING .and. group%has('direction')) then
         call error%raise(group%line_of('direction'), 'an extremum has no direction', &
            expected="extremum = 'maximum' or "// &
                          "'minimum' without direction")
      else if (event%kind /= CROSSING .and. group%has('modulo')) then
         call error%raise(group%line_of('modulo'), 'an extremum has no modulo', expected='modulo with crosses')
      end if
   end subroutine read_kind

   !> Sets the name of an event.
   subroutine read_name(group, name, event, error)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: name
      type(column_event_t), intent(inout) :: event
      type(scene_error_t), intent(inout) :: error
      if (len_trim(group%text('name', '')) > len(event%name)) &
         call error%raise(group%line_of('name'), 'name is too long', expected='at most 24 characters')
      if (name == '') call error%raise(group%line_of('name'), 'name is blank', expected='a name for the event')
      event%name = name
   end subroutine read_name

   !> Reads the switch of an event: `NAME on`, `NAME off` or `NAME toggle`.
   subroutine read_switch(group, effects, accuracy, event, error)
      type(group_t), intent(in) :: group
      type(effect_list_t), intent(in) :: effects
      real(wp), intent(in) :: accuracy
      type(column_event_t), intent(inout) :: event
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: text, label
      integer :: at
      text = trim(group%text('switch', ''))
      at = index(text, ' ', back=.true.)
      select case (text(at + 1:))
      case ('on')
         event%action = SWITCH_ON
      case ('off')
         event%action = SWITCH_OFF
      case ('toggle')
         event%action = SWITCH_TOGGLE
      case default
         event%action = 0
      end select
      label = trim(adjustl(text(:max(at - 1, 0))))
      if (event%action == 0 .or. label == '') then
         call error%raise(group%line_of('switch'), 'switch is '//quoted(text), &
            expected="'NAME on', 'NAME off' or 'NAME toggle'")
      else if (.not. effects%has(label)) then
         call error%raise(group%line_of('switch'), 'no effect that can be switched is called '//quoted(label), &
                          expected='the name of an effect; a rotor cannot be switched')
      else if (accuracy > 0.0_wp) then
         call error%raise(group%line_of('switch'), beyond_accuracy(effects, .true.), &
                          expected='time_step or local_tolerance')
      end if
      event%effect = label
   end subroutine read_switch

end module nutate_scene_events
