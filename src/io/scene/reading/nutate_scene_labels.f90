!> `&scene`: title, epoch of t = 0, and the names of body and axes in files for other programs.
module nutate_scene_labels
   use nutate_epoch, only: epoch_t, read_epoch, time_systems
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_printable, only: quoted
   use nutate_scene_error, only: scene_error_t
   implicit none
   private

   public :: labels_t, label_keys, build_labels, check_calendar, label_of

   !> Labels of a scene.
   type :: labels_t
      !> Instant t = 0; not set if the scene gives none.
      type(epoch_t) :: epoch
      !> Date as the scene gives it.
      character(len=:), allocatable :: date
      !> Name and identifier of the body, and names of space axes and body axes; empty if the scene gives none.
      character(len=:), allocatable :: object, object_id, space_frame, body_frame
   end type labels_t

   !> Keys of the scene group `&scene`.
   type(key_t), parameter :: label_keys(7) = [ &
      key_t(name='title', kind=KEY_TEXT), &
      key_t(name='epoch', kind=KEY_TEXT), &
      key_t(name='time_system', kind=KEY_TEXT, choices=time_systems), &
      key_t(name='object', kind=KEY_TEXT), &
      key_t(name='object_id', kind=KEY_TEXT), &
      key_t(name='space_frame', kind=KEY_TEXT), &
      key_t(name='body_frame', kind=KEY_TEXT)]

contains

   !> Builds the labels of a scene.
   subroutine build_labels(group, labels, error)
      !> Group `&scene`, or a group without keys.
      type(group_t), intent(in) :: group
      type(labels_t), intent(out) :: labels
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: problem
      labels%date = trim(group%text('epoch', ''))
      call read_name(group, 'object', labels%object, error)
      call read_name(group, 'object_id', labels%object_id, error)
      call read_name(group, 'space_frame', labels%space_frame, error)
      call read_name(group, 'body_frame', labels%body_frame, error)
      if (group%has('epoch') .neqv. group%has('time_system')) then
         call error%raise(group%line_of('epoch'), 'an epoch needs its time system, and a time system an epoch', &
                          expected="epoch = '2029-04-13T21:46:12.7', time_system = 'TDB'")
      else if (group%has('epoch')) then
         call read_epoch(labels%date, group%text('time_system', ''), labels%epoch, problem)
         if (problem /= '') call error%raise(group%line_of('epoch'), quoted(labels%date)//' '//problem)
      end if
   end subroutine build_labels

   !> Reads a name. Raises an error for one that a line of ASCII cannot hold.
   subroutine read_name(group, key, name, error)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      character(len=:), allocatable, intent(out) :: name
      type(scene_error_t), intent(inout) :: error
      integer, parameter :: longest = 120
      integer :: i
      name = trim(adjustl(group%text(key, '')))
      if (.not. group%has(key)) return
      if (name == '') call error%raise(group%line_of(key), key//' is blank', expected='a name')
      if (len(name) > longest) call error%raise(group%line_of(key), key//' is too long', &
                                                expected='a name of up to 120 letters')
      do i = 1, len(name)
         if (iachar(name(i:i)) < 32 .or. iachar(name(i:i)) > 126) &
            call error%raise(group%line_of(key), quoted(name)//' is not ASCII', expected='a name of ASCII letters')
      end do
   end subroutine read_name

   !> Returns the value of a key; empty if the scene gives none, not allocated for an unknown key.
   pure subroutine label_of(labels, key, value)
      type(labels_t), intent(in) :: labels
      !> `epoch`, `time_system`, `object`, ...
      character(len=*), intent(in) :: key
      character(len=:), allocatable, intent(out) :: value
      select case (key)
      case ('epoch')
         value = labels%date
      case ('time_system')
         value = trim(labels%epoch%system)
      case ('object')
         value = labels%object
      case ('object_id')
         value = labels%object_id
      case ('space_frame')
         value = labels%space_frame
      case ('body_frame')
         value = labels%body_frame
      case default
         continue
      end select
   end subroutine label_of

   !> Raises an error if the run leaves the calendar of its epoch.
   subroutine check_calendar(labels, group, end_time, error)
      type(labels_t), intent(in) :: labels
      !> Group `&scene`.
      type(group_t), intent(in) :: group
      !> End time, s.
      real(wp), intent(in) :: end_time
      type(scene_error_t), intent(inout) :: error
      type(epoch_t) :: last
      if (.not. labels%epoch%is_set()) return
      last = labels%epoch%after(end_time)
      if (last%is_set()) return
      call error%raise(group%line_of('epoch'), 'end_time leaves the calendar', expected='a run within the years '// &
                       trim(merge('1972 to 9999 of UTC', '1583 to 9999       ', labels%epoch%system == 'UTC')))
   end subroutine check_calendar

end module nutate_scene_labels
