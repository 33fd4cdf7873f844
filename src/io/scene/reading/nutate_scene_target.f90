!> Numbers of a scene by name: `GROUP[.N].KEY[.I]` is the I-th number of a key of the N-th group of that name.
module nutate_scene_target
   use nutate_ensemble_plan, only: ensemble_plan_t, target_t
   use nutate_keys, only: group_kind_t, setting_t, KEY_INTEGER, KEY_REAL
   use nutate_printable, only: quoted
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_names, only: find_key, find_kind, number_of
   use nutate_spelling, only: count_text, lower_case
   implicit none
   private

   public :: add_targets

   !> Parts of a name.
   type :: parts_t
      character(len=:), allocatable :: group, key
      !> Number of the group, and index of the value; 0: not given.
      integer :: number = 0, value = 0
   end type parts_t

   character(len=*), parameter :: form = 'GROUP.KEY, GROUP.N.KEY, GROUP.KEY.I or GROUP.N.KEY.I'
   !> Groups that do not affect the motion.
   character(len=*), parameter :: no_motion(9) = [character(len=11) :: &
      'output', 'scene', 'ensemble', 'vary', 'free', 'measurement', 'fit', 'chaos', 'frame']

contains

   !> Adds the numbers of a name to the targets of a plan. Raises an error for a name that refers to no number.
   subroutine add_targets(name, line, used, kinds, plan, n, error)
      character(len=*), intent(in) :: name
      !> Line to report in errors.
      integer, intent(in) :: line
      !> Use of the numbers: `varied` or `free`.
      character(len=*), intent(in) :: used
      type(group_kind_t), intent(in) :: kinds(:)
      !> Plan; its groups get a position for each number.
      type(ensemble_plan_t), intent(inout) :: plan
      !> Number of targets that were added; 0 on failure.
      integer, intent(out) :: n
      type(scene_error_t), intent(inout) :: error
      type(parts_t) :: parts
      type(target_t) :: target
      integer :: kind, key

      n = 0
      call split()
      if (.not. error%raised) call find_kind(parts%group, kinds, line, kind, error)
      if (error%raised) return
      if (any(no_motion == kinds(kind)%name)) then
         call error%raise(line, quoted(name)//' does not change the motion', &
                          expected='a key of &body, &initial, &integrator, &event or an effect')
         return
      end if
      call find_key(parts%key, kinds, kind, line, key, error)
      if (error%raised) return
      target%key = kinds(kind)%keys(key)
      if (all(target%key%kind /= [KEY_REAL, KEY_INTEGER])) then
         call error%raise(line, quoted(name)//' is not numeric', expected='a key of numbers')
         return
      end if
      call find_group(kinds(kind))
      if (.not. error%raised) call find_setting()
      if (.not. error%raised) call add_each()

   contains

      !> Splits a name at its points.
      subroutine split()
         character(len=:), allocatable :: rest
         integer :: number
         rest = lower_case(trim(adjustl(name)))
         call take(rest, parts%group)
         call take(rest, parts%key)
         number = number_of(parts%key)
         if (number > 0) then
            parts%number = number
            call take(rest, parts%key)
         end if
         if (rest /= '') then
            parts%value = number_of(rest)
            if (parts%value == 0) parts%key = ''
         end if
         if (parts%group == '' .or. parts%key == '' .or. number_of(parts%key) > 0) &
            call error%raise(line, quoted(name)//' is not the name of a number', expected=form)
      end subroutine split

      !> Finds the index of the group that a name refers to.
      subroutine find_group(kind)
         type(group_kind_t), intent(in) :: kind
         integer :: i, n
         n = 0
         do i = 1, size(plan%groups)
            if (plan%groups(i)%name /= kind%name) cycle
            n = n + 1
            if (n < max(parts%number, 1)) cycle
            target%group = i
            return
         end do
         call error%raise(line, 'the scene has no group that '//quoted(name)//' means', &
                          expected='groups of the scene, counted from 1 by their name')
      end subroutine find_group

      !> Finds the index of the key in its group; a key that the group lacks is added.
      subroutine find_setting()
         type(setting_t) :: setting
         integer :: i
         associate (group => plan%groups(target%group), key => target%key)
            do i = 1, size(group%settings)
               target%setting = i
               if (group%settings(i)%name == key%name) return
            end do
            target%setting = size(group%settings) + 1
            if (parts%value > 0 .and. key%most > 1) then
               call error%raise(line, quoted(name)//' is one of several numbers that the scene does not give', &
                                expected='the key in its group')
            else if (key%least /= key%most) then
               call error%raise(line, 'the scene does not say how many numbers '//quoted(name)//' has', &
                                expected='the key in its group')
            end if
            if (error%raised) return
            setting%name = key%name
            setting%line = line
            setting%kind = key%kind
            allocate (setting%values(key%most))
            call group%put(setting)
         end associate
      end subroutine find_setting

      !> Adds one number of a key, or all of them.
      subroutine add_each()
         character(len=:), allocatable :: stem
         integer :: i, count, first, last
         n = 0
         count = size(plan%groups(target%group)%settings(target%setting)%values)
         if (parts%value > count) then
            call error%raise(line, quoted(name)//' is beyond the last number of its key', expected='a number from 1 on')
            return
         end if
         first = merge(parts%value, 1, parts%value > 0)
         last = merge(parts%value, count, parts%value > 0)
         stem = trim(plan%groups(target%group)%name)
         if (parts%number > 0) stem = stem//'.'//count_text(parts%number)
         stem = stem//'.'//trim(target%key%name)
         do i = first, last
            target%value = i
            target%name = stem
            if (count > 1) target%name = stem//'.'//count_text(i)
            if (any(plan%targets%group == target%group .and. plan%targets%setting == target%setting .and. &
                    plan%targets%value == target%value)) then
               call error%raise(line, trim(target%name)//' is '//used//' twice', expected='each number once')
               return
            end if
            plan%targets = [plan%targets, target]
            n = n + 1
         end do
      end subroutine add_each

   end subroutine add_targets

   !> Reads the word before the first point.
   subroutine take(rest, word)
      character(len=:), allocatable, intent(inout) :: rest
      character(len=:), allocatable, intent(out) :: word
      integer :: dot
      dot = index(rest//'.', '.')
      word = rest(:dot - 1)
      rest = rest(min(dot + 1, len(rest) + 1):)
   end subroutine take

end module nutate_scene_target
