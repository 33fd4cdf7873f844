!> Bodies of the procedures whose interfaces are in `nutate_scene_output`.
submodule(nutate_scene_output) nutate_scene_output_procedures
   use nutate_admissible, only: POSITIVE
   use nutate_keys, only: KEY_INTEGER, KEY_LOGICAL, KEY_TEXT
   use nutate_kinds, only: long
   use nutate_limits, only: is_countable, whole_tolerance
   use nutate_printable, only: quoted
   use nutate_quantities, only: set_names
   use nutate_scene_error, only: allow_one_of
   use nutate_scene_table, only: path_beside
   use nutate_spelling, only: joined, lower_case
   implicit none

contains

   module procedure output_keys
      keys = [key_t(name='file', kind=KEY_TEXT), &
              key_t(name='events', kind=KEY_TEXT), &
              key_t(name='every', kind=KEY_INTEGER, range=POSITIVE, instead_of='interval,times,times_file'), &
              key_t(name='interval', range=POSITIVE, instead_of='every,times,times_file'), &
              key_t(name='columns', kind=KEY_TEXT, most=size(set_names()), choices=joined(set_names())), &
              key_t(name='times', most=most_times, instead_of='every,interval,times_file'), &
              key_t(name='times_file', kind=KEY_TEXT, instead_of='every,interval,times'), &
              key_t(name='precision', kind=KEY_INTEGER, range=POSITIVE), &
              key_t(name='degrees', kind=KEY_LOGICAL), &
              key_t(name='calendar', kind=KEY_LOGICAL)]
   end procedure output_keys

   module procedure build_output

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
         call error%raise(group%line_of('events'), 'events is not a separate file', &
                          expected='the name of another CSV file')
      call allow_one_of(group, [character(len=name_length) :: 'every', 'interval', 'times', 'times_file'], error)
      if (error%raised) return
      output%degrees = group%flag('degrees', .false.)
      output%digits = group%whole('precision', 0)
      if (output%digits > most_digits) call error%raise(group%line_of('precision'), 'precision is too large', &
                                                        expected='1 to 17 digits')
      call build_times(group, plan, path, error)
      if (error%raised) return
      plan%every = group%whole('every', 1)
      output%by_default = .not. (group%has('interval') .or. group%has('every') .or. allocated(plan%times))
      if (plan%goal%active()) then
         plan%interval = group%number('interval', 0.0_wp)
         if (output%by_default) plan%interval = abs(plan%end_time)/usual_intervals
         if (group%has('interval') .and. .not. is_countable(plan%end_time, plan%interval)) call error%raise( &
            group%line_of('interval'), 'interval is too small for end_time', expected='less than 9e15 rows')
      else if (group%has('interval')) then
         call count_steps(group, plan, error)
      end if
      call build_columns(group, output, error)
   end procedure build_output

   module procedure format_fault
      integer :: dot
      words = ''
      dot = index(name, '.', back=.true.)
      if (dot < 2) return
      if (any(other_formats == lower_case(name(dot:)))) words = 'has the wrong extension: histories are CSV'
   end procedure format_fault

   !> Reads the times of rows. Raises an error for the first time that is not after the one before, or not in the run.
   subroutine build_times(group, plan, path, error)
      !> Group, with its table if it names a file.
      type(group_t), intent(in) :: group
      type(run_plan_t), intent(inout) :: plan
      !> Path of the scene.
      character(len=*), intent(in) :: path
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: problem
      real(wp) :: sense
      integer :: i
      if (group%has('times')) then
         plan%times = group%vector('times', spread(0.0_wp, 1, group%count_of('times')))
      else if (allocated(group%table)) then
         plan%times = group%table%numbers(1, :)
      else
         return
      end if
      sense = sign(1.0_wp, plan%end_time)
      problem = ''
      if (size(plan%times) < 1) problem = 'there are no times (expected one or more)'
      do i = 1, size(plan%times)
         if (sense*plan%times(i) < 0.0_wp .or. sense*(plan%times(i) - plan%end_time) > 0.0_wp) then
            problem = 'an output time is outside of the run (expected times from 0 to end_time)'
         else if (i > 1) then
            if (sense*(plan%times(i) - plan%times(i - 1)) <= 0.0_wp) &
               problem = 'output times are out of order (expected the order of the run)'
         end if
         if (problem /= '') exit
      end do
      if (problem == '') return
      if (group%has('times')) then
         call error%raise(group%line_of('times'), problem)
      else
         call error%raise_in(path_beside(path, group%text('times_file', '')), i + 1, problem)
      end if
   end subroutine build_times

   !> Converts the interval between rows to a number of steps.
   subroutine count_steps(group, plan, error)
      type(group_t), intent(in) :: group
      type(run_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      real(wp) :: interval, step, ratio
      character(len=24) :: number

      interval = group%number('interval', 1.0_wp)
      step = abs(plan%time_step)
      ! The limits keep the division below from overflow; 2^53 steps are beyond any run.
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

   !> Reads the requested sets of columns, each once.
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

end submodule nutate_scene_output_procedures
