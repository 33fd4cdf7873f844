!> `&output`: where the rows go, how often, and which columns they have.
module nutate_scene_output
   use nutate_admissible, only: POSITIVE
   use nutate_columns, only: column_sets
   use nutate_keys, only: group_t, key_t, name_length, KEY_INTEGER, KEY_TEXT
   use nutate_kinds, only: wp, long
   use nutate_limits, only: is_countable, whole_tolerance
   use nutate_printable, only: quoted
   use nutate_run_plan, only: run_plan_t
   use nutate_scene_error, only: scene_error_t, allow_one_of
   use nutate_spelling, only: joined, lower_case
   implicit none
   private

   public :: output_settings_t, output_keys, build_output, format_fault

   !> Ends of names that promise what a history is not.
   character(len=8), parameter :: other_formats(*) = [character(len=8) :: &
      '.npy', '.npz', '.h5', '.hdf5', '.nc', '.mat', '.parquet', '.feather', '.xlsx', '.ods', '.json', '.pkl', '.gz', &
      '.zip', '.svg', '.png', '.pdf']

   !> Where the rows go and what they hold.
   type :: output_settings_t
      !> Path of the CSV file, relative to the working directory.
      character(len=:), allocatable :: file
      !> That of the events, where the scene names one; else blank: it goes by that of the rows.
      character(len=:), allocatable :: events
      !> Names of the sets of columns, as asked for; shape (number of sets).
      character(len=name_length), allocatable :: columns(:)
   end type output_settings_t

contains

   !> Keys of the scene group `&output`.
   pure function output_keys() result(keys)
      type(key_t) :: keys(5)
      character(len=*), parameter :: sets(*) = column_sets%name

      keys = [key_t(name='file', kind=KEY_TEXT), &
              key_t(name='events', kind=KEY_TEXT), &
              key_t(name='every', kind=KEY_INTEGER, range=POSITIVE, instead_of='interval'), &
              key_t(name='interval', range=POSITIVE, instead_of='every'), &
              key_t(name='columns', kind=KEY_TEXT, most=size(sets), choices=joined(sets))]
   end function output_keys

   !> Output settings, and when rows are due.
   subroutine build_output(group, scene_name, path, plan, output, error)
      type(group_t), intent(in) :: group
      !> Name of the scene: that of the file unless the group gives one.
      character(len=*), intent(in) :: scene_name
      !> Path of the scene file, which must not be written over.
      character(len=*), intent(in) :: path
      !> Its `time_step`, `end_time` and goal are used; `every` is set, and `interval` where the goal is active.
      type(run_plan_t), intent(inout) :: plan
      type(output_settings_t), intent(out) :: output
      type(scene_error_t), intent(inout) :: error

      output%file = trim(group%text('file', scene_name//'.csv'))
      if (output%file == '') then
         call error%raise(group%line_of('file'), 'file is blank', expected='the name of the CSV file')
      else if (format_fault(output%file) /= '') then
         call error%raise(group%line_of('file'), quoted(output%file)//' '//format_fault(output%file), &
                          expected='a name such as '//scene_name//'.csv')
      else if (output%file == path) then
         call error%raise(group%line_of('file'), 'file would replace the scene itself', expected='another name')
      end if
      output%events = trim(group%text('events', ''))
      if (group%has('events') .and. (output%events == '' .or. output%events == '-' .or. output%events == path .or. &
                                     output%events == output%file)) &
         call error%raise(group%line_of('events'), 'events is no file of its own', &
         expected='the name of another CSV file')
      call allow_one_of(group, [character(len=name_length) :: 'every', 'interval'], error)
      if (error%raised) return
      plan%every = group%whole('every', 1)
      if (plan%goal%active()) then
         plan%interval = group%number('interval', 0.0_wp)
         if (group%has('interval') .and. .not. is_countable(plan%end_time, plan%interval)) call error%raise( &
            group%line_of('interval'), 'interval is too small for end_time', expected='less than 9e15 rows')
      else if (group%has('interval')) then
         call count_steps(group, plan, error)
      end if
      call build_columns(group, output, error)
   end subroutine build_output

   !> What is wrong with a name that ends like those of files in another format; empty if nothing is.
   pure function format_fault(name) result(words)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: words
      integer :: dot
      words = ''
      dot = index(name, '.', back=.true.)
      if (dot < 2) return
      if (any(other_formats == lower_case(name(dot:)))) words = 'would not be what it says: histories are CSV'
   end function format_fault

   !> The interval between rows as a number of steps.
   subroutine count_steps(group, plan, error)
      type(group_t), intent(in) :: group
      type(run_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      real(wp) :: interval, step, ratio
      character(len=24) :: number

      interval = group%number('interval', 1.0_wp)
      step = abs(plan%time_step)
      ! Dividing only what cannot overflow; 2^53 steps are beyond any run.
      if (interval < 0.5_wp*step .or. exponent(interval) - exponent(step) > 52) then
         call error%raise(group%line_of('interval'), 'interval is not a whole number of steps', &
                          expected='a small multiple of time_step')
         return
      end if
      ratio = interval/step
      if (anint(ratio) < 1 .or. abs(ratio - anint(ratio)) > whole_tolerance*anint(ratio)) then
         write (number, '(g0.6)') ratio
         call error%raise(group%line_of('interval'), 'interval is '//trim(number)//' steps', &
                          expected='a whole number of steps')
         return
      end if
      plan%every = nint(ratio, long)
   end subroutine count_steps

   !> The sets asked for, each once.
   subroutine build_columns(group, output, error)
      type(group_t), intent(in) :: group
      type(output_settings_t), intent(inout) :: output
      type(scene_error_t), intent(inout) :: error
      integer :: i

      if (.not. group%has('columns')) then
         output%columns = [character(len=name_length) :: 'quaternion', 'angular_velocity', 'energy', 'constraints']
         return
      end if
      allocate (output%columns(group%count_of('columns')))
      do i = 1, size(output%columns)
         output%columns(i) = group%text_at('columns', i)
         if (any(output%columns(1:i - 1) == output%columns(i))) then
            call error%raise(group%line_of('columns'), "columns names '"//trim(output%columns(i))//"' twice", &
                             expected='each set once')
            return
         end if
      end do
   end subroutine build_columns

end module nutate_scene_output
