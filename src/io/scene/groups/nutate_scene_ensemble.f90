!> `&ensemble`: many members of one scene, with the differences that `&vary` groups or a table give.
module nutate_scene_ensemble
   use nutate_admissible, only: NON_NEGATIVE, POSITIVE
   use nutate_ensemble_plan, only: ensemble_plan_t, varied_key_t, CASES, GRID
   use nutate_keys, only: first_group, group_t, group_kind_t, key_t, KEY_INTEGER, KEY_TEXT
   use nutate_kinds, only: wp, long
   use nutate_limits, only: is_moderate
   use nutate_scene_body, only: check_body_keys
   use nutate_scene_cases, only: read_cases
   use nutate_scene_error, only: scene_error_t, LINE_OF_SET
   use nutate_scene_events, only: check_event_names
   use nutate_scene_initial, only: check_initial_keys
   use nutate_scene_target, only: add_targets
   use nutate_scene_vary, only: build_variation
   implicit none
   private

   public :: ensemble_keys, build_ensemble, add_table

   !> Maximum number of members with histories.
   integer, parameter :: most_histories = 1000
   !> Maximum number of members: nine digits, more than any machine can run.
   integer(long), parameter :: most_members = 999999999_long

contains

   !> Keys of the scene group `&ensemble`.
   pure function ensemble_keys() result(keys)
      type(key_t) :: keys(8)
      keys = [key_t(name='members', kind=KEY_INTEGER, range=POSITIVE), &
              key_t(name='seed', kind=KEY_INTEGER, range=NON_NEGATIVE), &
              key_t(name='file', kind=KEY_TEXT), &
              key_t(name='rows', kind=KEY_TEXT, choices='final,none'), &
              key_t(name='histories', kind=KEY_INTEGER, most=most_histories, range=POSITIVE), &
              key_t(name='table', kind=KEY_TEXT), &
              key_t(name='sampling', kind=KEY_TEXT, choices='random,latin'), &
              key_t(name='chunk', kind=KEY_INTEGER, range=POSITIVE)]
   end function ensemble_keys

   !> Builds the ensemble of a scene; none if there is no group `&ensemble`.
   subroutine build_ensemble(groups, kinds, scene_name, path, plan, error)
      !> Groups that have been checked and built as a scene.
      type(group_t), intent(in) :: groups(:)
      type(group_kind_t), intent(in) :: kinds(:)
      !> Name of the scene: that of the file unless the group gives one.
      character(len=*), intent(in) :: scene_name
      !> Path of the scene file.
      character(len=*), intent(in) :: path
      type(ensemble_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      integer :: at, i

      at = findloc(groups%name == 'ensemble', .true., dim=1)
      i = findloc(groups%name == 'vary', .true., dim=1)
      if (i > 0 .and. at == 0) call error%raise(groups(i)%line, '&vary without &ensemble', &
                                                expected='&ensemble with the number of members')
      if (at == 0 .or. error%raised) return
      plan%groups = groups
      allocate (plan%targets(0), plan%variations(0))
      do i = 1, size(groups)
         if (groups(i)%name == 'vary' .and. .not. error%raised) &
            call build_variation(groups(i), groups, kinds, plan, error)
      end do
      if (groups(at)%has('table') .and. .not. error%raised) call read_table(groups(at))
      if (.not. error%raised) call check_added_keys(plan, error)
      if (.not. error%raised) call read_settings(groups(at))
      if (.not. error%raised) call count_members(groups(at))
      if (.not. error%raised) call check_event_names(groups, error)
      if (error%raised) return
      if (any(plan%histories > plan%members)) call error%raise( &
         groups(at)%line_of('histories'), 'histories lists a member that does not exist', expected='numbers of members')

   contains

      !> Reads the settings of output and draws.
      subroutine read_settings(group)
         type(group_t), intent(in) :: group
         plan%seed = group%whole('seed', 0)
         plan%latin = group%text('sampling', 'random') == 'latin'
         plan%keeps_rows = group%text('rows', 'final') == 'final'
         plan%file = trim(group%text('file', scene_name//trim(merge('.npy', '.csv', plan%keeps_rows))))
         plan%chunk = group%whole('chunk', 0)
         plan%histories = nint(group%vector('histories', spread(0.0_wp, 1, group%count_of('histories'))))
         if (plan%file == '' .or. plan%file == '-') then
            call error%raise(group%line_of('file'), 'file is not a file name', expected='the name of the .npy file')
         else if (plan%file == path) then
            call error%raise(group%line_of('file'), 'file would replace the scene itself', expected='another name')
         end if
      end subroutine read_settings

      !> Determines the number of members: as given, or the size of the grid or the table.
      subroutine count_members(group)
         type(group_t), intent(in) :: group
         integer(long) :: places, lines
         integer :: i, k
         places = 0
         lines = 0
         do i = 1, size(plan%variations)
            associate (variation => plan%variations(i))
               if (variation%distribution == CASES) lines = size(variation%cases, 2)
               if (variation%distribution /= GRID) cycle
               if (places == 0) places = 1
               do k = 1, variation%n
                  places = min(places*variation%points(k), most_members + 1)
               end do
            end associate
         end do
         plan%members = group%whole('members', 0)
         if (plan%members == 0) plan%members = max(lines, places)
         if (plan%members == 0) then
            call error%raise(group%line, '&ensemble lacks members', expected='a whole number > 0, a grid or a table')
         else if (plan%members > most_members) then
            call error%raise(group%line, 'the ensemble has too many members', expected='at most 999999999')
         else if (lines > 0 .and. plan%members > lines) then
            call error%raise(group%line_of('members'), 'there are more members than lines in the table', &
                             expected='at most one for each line')
         end if
      end subroutine count_members

      !> Adds the table that the group names.
      subroutine read_table(group)
         type(group_t), intent(in) :: group
         character(len=80), allocatable :: names(:)
         real(wp), allocatable :: numbers(:, :)
         character(len=:), allocatable :: file
         type(scene_error_t) :: fault
         call read_cases(group, path, names, numbers, file, error)
         if (error%raised) return
         call add_cases(names, numbers, group%line_of('table'), kinds, plan, fault)
         if (fault%raised) call error%raise_in(file, 1, fault%text)
      end subroutine read_table

   end subroutine build_ensemble

   !> Raises an error for varied keys of body or initial state that exclude or require others: members are rebuilt
   !> without this check.
   subroutine check_added_keys(plan, error)
      type(ensemble_plan_t), intent(in) :: plan
      type(scene_error_t), intent(inout) :: error
      call check_body_keys(first_group(plan%groups, 'body'), error)
      call check_initial_keys(first_group(plan%groups, 'initial'), error)
   end subroutine check_added_keys

   !> Adds a table from memory to the ensemble of a scene, or makes an ensemble of it. Raises an error for an invalid
   !> table, and leaves the plan unchanged then.
   subroutine add_table(names, numbers, groups, kinds, plan, error)
      !> Names of the columns; shape (columns).
      character(len=*), intent(in) :: names(:)
      !> Shape (columns, lines).
      real(wp), intent(in) :: numbers(:, :)
      !> Groups of the scene.
      type(group_t), intent(in) :: groups(:)
      type(group_kind_t), intent(in) :: kinds(:)
      type(ensemble_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      type(ensemble_plan_t) :: extended
      extended = plan
      if (.not. plan%active()) then
         extended%groups = groups
         extended%members = size(numbers, 2, long)
         allocate (extended%targets(0), extended%variations(0), extended%histories(0))
      end if
      if (any(extended%variations%distribution == CASES)) then
         call error%raise(LINE_OF_SET, 'the ensemble already has a table', expected='only one')
      else if (extended%members > size(numbers, 2, long)) then
         call error%raise(LINE_OF_SET, 'there are more members than lines in the table', &
                          expected='at most one for each line')
      else if (size(numbers, 2, long) > most_members) then
         call error%raise(LINE_OF_SET, 'the table has too many lines', expected='at most 999999999')
      else if (.not. all(is_moderate(numbers))) then
         call error%raise(LINE_OF_SET, 'the table has a number that is not finite or exceeds 1e100', &
                          expected='numbers')
      else
         call add_cases(names, numbers, LINE_OF_SET, kinds, extended, error)
         if (.not. error%raised) call check_added_keys(extended, error)
         if (.not. error%raised) call check_event_names(groups, error)
      end if
      if (.not. error%raised) plan = extended
   end subroutine add_table

   !> Adds a table: a line of numbers for each member. Raises an error for a column that is not the name of a number.
   subroutine add_cases(names, numbers, line, kinds, plan, error)
      !> Names of the columns; shape (columns).
      character(len=*), intent(in) :: names(:)
      !> Shape (columns, members).
      real(wp), intent(in) :: numbers(:, :)
      !> Line to report in errors.
      integer, intent(in) :: line
      type(group_kind_t), intent(in) :: kinds(:)
      type(ensemble_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      type(varied_key_t) :: variation
      integer :: i, n
      variation%distribution = CASES
      variation%first = size(plan%targets) + 1
      variation%n = size(names)
      variation%cases = numbers
      do i = 1, size(names)
         call add_targets(trim(names(i)), line, 'varied', kinds, plan, n, error)
         if (error%raised) return
         if (n /= 1) then
            call error%raise(line, "column '"//trim(names(i))//"' stands for several numbers", &
                             expected='one number for each column, such as '//trim(names(i))//'.1')
            return
         end if
      end do
      plan%variations = [plan%variations, variation]
   end subroutine add_cases

end module nutate_scene_ensemble
