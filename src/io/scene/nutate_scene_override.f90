!> What the command line changes in the groups of a scene: `GROUP.KEY=VALUE` sets a key, `-GROUP.KEY` takes it out.
module nutate_scene_override
   use nutate_keys, only: group_t, group_kind_t, key_t, setting_t, KEY_TEXT
   use nutate_printable, only: quoted
   use nutate_scene_check, only: resize
   use nutate_scene_error, only: scene_error_t, LINE_OF_SET, LINE_OF_UNSET
   use nutate_scene_lexer, only: lexer_t, token_t, TOKEN_END
   use nutate_scene_names, only: find_key, find_kind
   use nutate_scene_values, only: read_values
   use nutate_spelling, only: is_listed
   implicit none
   private

   public :: apply_override

contains

   !> Applies a change to the first group of the name, which `GROUP.KEY=VALUE` makes if there is none.
   subroutine apply_override(override, kinds, groups, error)
      !> `GROUP.KEY=VALUE`, or `-GROUP.KEY`.
      character(len=*), intent(in) :: override
      type(group_kind_t), intent(in) :: kinds(:)
      type(group_t), allocatable, intent(inout) :: groups(:)
      type(scene_error_t), intent(inout) :: error
      integer :: equals, kind, key

      if (error%raised) return
      if (index(override, '-') == 1) then
         call find_name(override(2:), 'GROUP.KEY', LINE_OF_UNSET, kinds, kind, key, error)
         if (.not. error%raised) call take_out(kinds(kind)%name, kinds(kind)%keys(key)%name, groups)
         return
      end if
      equals = index(override, '=')
      if (equals == 0) then
         call error%raise(LINE_OF_SET, quoted(override)//' is not a setting', expected='GROUP.KEY=VALUE')
      else
         call find_name(override, 'GROUP.KEY=VALUE', LINE_OF_SET, kinds, kind, key, error)
         if (.not. error%raised) call set(override(equals + 1:), kinds(kind)%name, kinds(kind)%keys(key), groups, error)
      end if
   end subroutine apply_override

   !> Finds group and key of `GROUP.KEY`, or of `GROUP.KEY=VALUE`.
   subroutine find_name(name, form, line, kinds, kind, key, error)
      character(len=*), intent(in) :: name
      !> How it is written.
      character(len=*), intent(in) :: form
      !> `LINE_OF_...`
      integer, intent(in) :: line
      type(group_kind_t), intent(in) :: kinds(:)
      !> Their places in the tables.
      integer, intent(out) :: kind, key
      type(scene_error_t), intent(inout) :: error
      integer :: dot, last
      kind = 0
      key = 0
      last = index(name//'=', '=') - 1
      dot = index(name(:last), '.')
      if (dot == 0) then
         call error%raise(line, quoted(name)//' is not a setting', expected=form)
         return
      end if
      call find_kind(trim(adjustl(name(:dot - 1))), kinds, line, kind, error)
      if (.not. error%raised) call find_key(trim(adjustl(name(dot + 1:last))), kinds, kind, line, key, error)
   end subroutine find_name

   !> Reads the value of a key and puts it into the groups.
   subroutine set(value, group, key, groups, error)
      character(len=*), intent(in) :: value
      !> Name of the group.
      character(len=*), intent(in) :: group
      type(key_t), intent(in) :: key
      type(group_t), allocatable, intent(inout) :: groups(:)
      type(scene_error_t), intent(inout) :: error
      type(scene_error_t) :: mistake
      type(setting_t) :: setting
      type(lexer_t) :: lexer
      type(token_t) :: token
      character(len=:), allocatable :: text

      text = value
      if (key%kind == KEY_TEXT) text = with_quotes(value, is_list=key%most > 1)
      setting%name = key%name
      call read_values(lexer, text, key, setting, token, mistake)
      if (token%kind /= TOKEN_END) &
         call mistake%raise(LINE_OF_SET, quoted(text(token%first:token%last))//' follows the value of '// &
                            trim(key%name), expected='one setting')
      if (mistake%raised) then
         call error%raise(LINE_OF_SET, mistake%text)
      else
         call put(group, key, setting, groups)
      end if
   end subroutine set

   !> A text as a scene has it: one that the shell has freed from its quotes gets them back, a list around each word.
   pure function with_quotes(value, is_list) result(text)
      character(len=*), intent(in) :: value
      logical, intent(in) :: is_list
      character(len=:), allocatable :: text
      integer :: i
      logical :: in_word
      if (scan(adjustl(value), '''"') == 1 .or. value == '' .or. (is_list .and. scan(value, '''"') > 0)) then
         text = value
         return
      end if
      text = ''
      in_word = .false.
      do i = 1, len_trim(value)
         if (in_word .neqv. (.not. is_list .or. scan(value(i:i), ', ') == 0)) then
            in_word = .not. in_word
            text = text//"'"
         end if
         if (value(i:i) == "'") text = text//"'"
         text = text//value(i:i)
      end do
      if (in_word) text = text//"'"
   end function with_quotes

   !> Puts a setting into the first group of a name, in place of what the file has for it.
   subroutine put(name, key, setting, groups)
      character(len=*), intent(in) :: name
      type(key_t), intent(in) :: key
      type(setting_t), intent(in) :: setting
      type(group_t), allocatable, intent(inout) :: groups(:)
      type(setting_t), allocatable :: settings(:)
      integer :: i, j, n

      i = findloc(groups%name == name, .true., dim=1)
      if (i == 0) then
         i = size(groups) + 1
         call resize(groups, i, i - 1)
         groups(i)%name = name
         allocate (groups(i)%settings(0))
      end if
      ! The setting goes behind the others: where two keys exclude each other, the later one is at fault.
      allocate (settings(size(groups(i)%settings) + 1))
      n = 0
      do j = 1, size(groups(i)%settings)
         associate (other => groups(i)%settings(j))
            if (other%name == setting%name) cycle
            if (other%line /= LINE_OF_SET .and. is_listed(trim(other%name), key%instead_of)) cycle
            n = n + 1
            settings(n) = other
         end associate
      end do
      settings(n + 1) = setting
      groups(i)%settings = settings(1:n + 1)
   end subroutine put

   !> Takes a key out of the first group of a name, if it is there.
   subroutine take_out(name, key, groups)
      character(len=*), intent(in) :: name, key
      type(group_t), intent(inout) :: groups(:)
      type(setting_t), allocatable :: settings(:)
      integer :: i, j, n
      i = findloc(groups%name == name, .true., dim=1)
      if (i == 0) return
      allocate (settings(size(groups(i)%settings)))
      n = 0
      do j = 1, size(groups(i)%settings)
         if (groups(i)%settings(j)%name == key) cycle
         n = n + 1
         settings(n) = groups(i)%settings(j)
      end do
      groups(i)%settings = settings(1:n)
   end subroutine take_out

end module nutate_scene_override
