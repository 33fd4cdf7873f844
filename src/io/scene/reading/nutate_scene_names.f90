!> Names of groups and keys, and their lookup in the tables of groups and keys.
module nutate_scene_names
   use nutate_keys, only: group_kind_t, name_length
   use nutate_printable, only: quoted
   use nutate_scene_error, only: scene_error_t
   use nutate_spelling, only: comma_list, lower_case, nearest_name, new_name
   implicit none
   private

   public :: find_kind, find_key, number_of

contains

   !> Finds the index of a group's name among the kinds. Errors: unknown.
   subroutine find_kind(name, kinds, line, kind, error)
      character(len=*), intent(in) :: name
      type(group_kind_t), intent(in) :: kinds(:)
      integer, intent(in) :: line
      integer, intent(out) :: kind
      type(scene_error_t), intent(inout) :: error

      kind = 0
      if (len(name) <= name_length) kind = findloc(kinds%name == lower_case(name), .true., dim=1, back=.true.)
      if (kind > 0) return
      if (new_name(name, group_names(kinds)) /= '') &
         call error%raise(line, '&'//lower_case(name)//' is now &'//new_name(name, group_names(kinds)))
      call error%raise(line, 'unknown group '//quoted(name), expected=comma_list(group_names(kinds)), &
                       nearest=nearest_name(name, group_names(kinds)))
   end subroutine find_kind

   !> Finds the index of a key among those of a kind of group. Errors: a subscript, unknown.
   subroutine find_key(name, kinds, kind, line, key, error)
      character(len=*), intent(in) :: name
      type(group_kind_t), intent(in) :: kinds(:)
      integer, intent(in) :: kind, line
      integer, intent(out) :: key
      type(scene_error_t), intent(inout) :: error

      key = 0
      if (len(name) <= name_length) &
         key = findloc(kinds(kind)%keys%name == lower_case(name), .true., dim=1, back=.true.)
      if (key > 0) return
      if (index(name, '(') > 0) then
         call error%raise(line, quoted(name)//' has a subscript', expected='all values of a key at once')
      else
         call error%raise(line, 'unknown key '//quoted(name)//' in &'//trim(kinds(kind)%name)//elsewhere(name, kinds), &
                          expected=comma_list(key_names(kinds(kind))), &
                          nearest=nearest_name(name, key_names(kinds(kind))))
      end if
   end subroutine find_key

   !> Returns the value of a positive integer; 0 for other strings.
   pure integer function number_of(word)
      character(len=*), intent(in) :: word
      number_of = 0
      if (verify(word, '0123456789') /= 0 .or. len(word) < 1 .or. len(word) > 8) return
      read (word, *) number_of
   end function number_of

   !> Returns `, a key of &group` for a name that is a key of another group.
   pure function elsewhere(name, kinds) result(hint)
      character(len=*), intent(in) :: name
      type(group_kind_t), intent(in) :: kinds(:)
      character(len=:), allocatable :: hint
      integer :: i
      hint = ''
      if (len(name) > name_length) return
      do i = 1, size(kinds)
         if (any(key_names(kinds(i)) == lower_case(name))) then
            hint = ', a key of &'//trim(kinds(i)%name)
            return
         end if
      end do
   end function elsewhere

   !> Names of all kinds of group; shape (number of kinds).
   pure function group_names(kinds) result(names)
      type(group_kind_t), intent(in) :: kinds(:)
      character(len=name_length) :: names(size(kinds))
      integer :: i
      do i = 1, size(kinds)
         names(i) = kinds(i)%name
      end do
   end function group_names

   !> Names of all keys of a kind of group; shape (number of keys).
   pure function key_names(kind) result(names)
      type(group_kind_t), intent(in) :: kind
      character(len=name_length) :: names(size(kind%keys))
      integer :: i
      do i = 1, size(kind%keys)
         names(i) = kind%keys(i)%name
      end do
   end function key_names

end module nutate_scene_names
