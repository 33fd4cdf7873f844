!> Overrides of a scene: `GROUP.KEY=VALUE` sets a key, `-GROUP.KEY` removes it. `GROUP.N` instead of GROUP is the N-th
!> group of this name.
module nutate_scene_override
   use nutate_keys, only: group_t, group_kind_t, key_t, name_length, setting_t, KEY_TEXT
   use nutate_printable, only: quoted
   use nutate_scene_check, only: resize
   use nutate_scene_error, only: scene_error_t, LINE_OF_SET, LINE_OF_UNSET
   use nutate_scene_lexer, only: lexer_t, token_t, TOKEN_END
   use nutate_scene_names, only: find_key, find_kind, number_of
   use nutate_scene_values, only: read_values
   use nutate_spelling, only: count_text, split_list
   implicit none
   private

   public :: apply_override

   !> Position that an override changes: indices of the kind of group and of its key in the tables, and of the group in
   !> the scene, 0 if it is not there.
   type :: place_t
      integer :: kind = 0, key = 0, group = 0
      !> Number of the group among those of this name, counted from 1.
      integer :: number = 1
   end type place_t

contains

   !> Applies a change to the first group of the name, which `GROUP.KEY=VALUE` makes if there is none, or to the N-th.
   subroutine apply_override(override, kinds, groups, error)
      !> `GROUP.KEY=VALUE`, or `-GROUP.KEY`.
      character(len=*), intent(in) :: override
      type(group_kind_t), intent(in) :: kinds(:)
      type(group_t), allocatable, intent(inout) :: groups(:)
      type(scene_error_t), intent(inout) :: error
      type(place_t) :: at
      integer :: equals

      if (error%raised) return
      if (index(override, '-') == 1) then
         call find_name(override(2:), 'GROUP.KEY', LINE_OF_UNSET)
         if (error%raised .or. at%group == 0) return
         call groups(at%group)%drop(trim(kinds(at%kind)%keys(at%key)%name))
         return
      end if
      equals = index(override, '=')
      if (equals == 0) then
         call error%raise(LINE_OF_SET, quoted(override)//' is not a setting', expected='GROUP.KEY=VALUE')
      else
         call find_name(override, 'GROUP.KEY=VALUE', LINE_OF_SET)
         if (.not. error%raised) call set(override(equals + 1:))
      end if

   contains

      !> Finds group and key of `GROUP.KEY`, `GROUP.N.KEY`, or of those with `=VALUE` behind them.
      subroutine find_name(name, form, line)
         character(len=*), intent(in) :: name
         !> Expected form, for messages.
         character(len=*), intent(in) :: form
         !> Line to report in errors, `LINE_OF_...`.
         integer, intent(in) :: line
         integer :: dot, last, second
         last = index(name//'=', '=') - 1
         dot = index(name(:last), '.')
         if (dot == 0) then
            call error%raise(line, quoted(name)//' is not a setting', expected=form)
            return
         end if
         call find_kind(trim(adjustl(name(:dot - 1))), kinds, line, at%kind, error)
         if (error%raised) return
         second = index(name(dot + 1:last), '.')
         if (second > 0) then
            at%number = max(1, number_of(name(dot + 1:dot + second - 1)))
            if (number_of(name(dot + 1:dot + second - 1)) > 0) dot = dot + second
         end if
         call find_key(trim(adjustl(name(dot + 1:last))), kinds, at%kind, line, at%key, error)
         if (.not. error%raised) call find_group(trim(kinds(at%kind)%name), line)
      end subroutine find_name

      !> Finds the group. Raises an error for a second or later one that does not exist.
      subroutine find_group(name, line)
         character(len=*), intent(in) :: name
         !> Line to report in errors, `LINE_OF_...`.
         integer, intent(in) :: line
         integer :: i, n
         n = 0
         do i = 1, size(groups)
            if (groups(i)%name /= name) cycle
            n = n + 1
            if (n == at%number) at%group = i
         end do
         if (at%group > 0 .or. at%number == 1) return
         call error%raise(line, 'the scene has no group &'//name//' number '//count_text(at%number), &
                          expected='groups of the scene, counted from 1 by their name')
      end subroutine find_group

      !> Reads the value of a key and puts it into the groups.
      subroutine set(value)
         character(len=*), intent(in) :: value
         type(scene_error_t) :: mistake
         type(key_t) :: key
         type(setting_t) :: setting
         type(lexer_t) :: lexer
         type(token_t) :: token
         character(len=:), allocatable :: text

         key = kinds(at%kind)%keys(at%key)
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
            call put(kinds(at%kind)%name, at%group, key, setting)
         end if
      end subroutine set

      !> Puts a setting into a group, in place of that of the file.
      subroutine put(name, place, key, setting)
         !> Name of the group.
         character(len=*), intent(in) :: name
         !> Index of the group; 0: a new one.
         integer, intent(in) :: place
         type(key_t), intent(in) :: key
         type(setting_t), intent(in) :: setting
         character(len=name_length), allocatable :: others(:)
         integer :: i, j

         i = place
         if (i == 0) then
            i = size(groups) + 1
            call resize(groups, i, i - 1)
            groups(i)%name = name
            allocate (groups(i)%settings(0))
         end if
         others = split_list(key%instead_of)
         do j = 1, size(others)
            if (groups(i)%line_of(trim(others(j))) /= LINE_OF_SET) call groups(i)%drop(trim(others(j)))
         end do
         ! The setting goes behind the others: where two keys exclude each other, the later one is at fault.
         call groups(i)%put(setting)
      end subroutine put

   end subroutine apply_override

   !> Returns a string as it is in a scene: quotes that the shell has removed are restored, in a list around each word.
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

end module nutate_scene_override
