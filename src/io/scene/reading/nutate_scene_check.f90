!> Groups of a scene, read and checked against the tables of groups and keys.
module nutate_scene_check
   use nutate_keys, only: group_t, group_kind_t, setting_t
   use nutate_printable, only: quoted
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_lexer, only: lexer_t, token_t, TOKEN_COMMA, TOKEN_END, TOKEN_EQUALS, TOKEN_GROUP, TOKEN_KEY, &
      TOKEN_SLASH
   use nutate_scene_names, only: find_key, find_kind
   use nutate_scene_values, only: expectation, read_values
   implicit none
   private

   public :: read_groups, check_complete, resize

contains

   !> Reads all groups of a scene. The first error in the order of the text ends it.
   subroutine read_groups(text, kinds, groups, last_line, error)
      character(len=*), intent(in) :: text
      !> Every group that a scene can have.
      type(group_kind_t), intent(in) :: kinds(:)
      !> Groups in the order of the text.
      type(group_t), allocatable, intent(out) :: groups(:)
      !> Number of the text's last line, at least 1.
      integer, intent(out) :: last_line
      type(scene_error_t), intent(inout) :: error
      character(len=*), parameter :: byte_order_mark = char(239)//char(187)//char(191)
      type(lexer_t) :: lexer
      type(token_t) :: token
      type(group_t), allocatable :: found(:)
      integer :: n, kind

      if (index(text, byte_order_mark) == 1) lexer%position = 4
      allocate (found(16))
      n = 0
      do
         call lexer%next(text, token, error)
         if (error%raised .or. token%kind == TOKEN_END) exit
         call start_group(found(1:n), kind)
         if (error%raised) exit
         if (n == size(found)) call resize(found, 2*n, n)
         n = n + 1
         call read_group(token%line, found(n))
         if (error%raised) exit
      end do
      call resize(found, n, n)
      call move_alloc(found, groups)
      last_line = lexer%line
      if (len(text) > 0) then
         if (text(len(text):) == achar(10)) last_line = max(1, last_line - 1)
      end if

   contains

      !> Returns the kind of a group that starts. Errors: not a group, unknown, there already.
      subroutine start_group(groups, kind)
         !> Groups read so far.
         type(group_t), intent(in) :: groups(:)
         !> Index of the group among the kinds.
         integer, intent(out) :: kind

         kind = 0
         if (token%kind /= TOKEN_GROUP) then
            call error%raise(token%line, quoted(text(token%first:token%last))//' stands outside of a group', &
                             expected='&name of a group, or ! before a comment')
            return
         end if
         call find_kind(text(token%first:token%last), kinds, token%line, kind, error)
         if (error%raised) return
         if (kinds(kind)%repeatable) return
         if (any(groups%name == kinds(kind)%name)) &
            call error%raise(token%line, 'a second group &'//trim(kinds(kind)%name), expected='only one')
      end subroutine start_group

      !> Reads the keys of a group up to its closing slash.
      subroutine read_group(line, group)
         !> Line where the group starts.
         integer, intent(in) :: line
         type(group_t), intent(inout) :: group
         type(setting_t) :: settings(size(kinds(kind)%keys))
         type(token_t) :: token
         integer :: n, key

         group%name = kinds(kind)%name
         group%line = line
         n = 0
         call lexer%next(text, token, error)
         do while (token%kind == TOKEN_KEY .and. .not. error%raised)
            call find_key(text(token%first:token%last), kinds, kind, token%line, key, error)
            if (error%raised) return
            if (any(settings(1:n)%name == kinds(kind)%keys(key)%name)) then
               call error%raise(token%line, trim(kinds(kind)%keys(key)%name)//' is given twice in &'// &
                  trim(group%name), &
                                expected='it once')
               return
            end if
            n = n + 1
            settings(n)%name = kinds(kind)%keys(key)%name
            settings(n)%line = token%line
            call read_values(lexer, text, kinds(kind)%keys(key), settings(n), token, error)
         end do
         if (token%kind /= TOKEN_SLASH .and. .not. error%raised) call blame(text, token, group, error)
         group%settings = settings(1:n)
      end subroutine read_group

   end subroutine read_groups

   !> Raises the error of a token that is found instead of a key or the end of a group.
   subroutine blame(text, token, group, error)
      character(len=*), intent(in) :: text
      type(token_t), intent(in) :: token
      type(group_t), intent(in) :: group
      type(scene_error_t), intent(inout) :: error
      character(len=*), parameter :: due = 'key = value, or / at the end of the group'

      select case (token%kind)
      case (TOKEN_END)
         call error%raise(group%line, '&'//trim(group%name)//' is not closed', expected='/ at its end')
      case (TOKEN_GROUP)
         call error%raise(token%line, quoted('&'//text(token%first:token%last))//' starts inside of &'// &
                          trim(group%name), expected='/ at the end of the group')
      case (TOKEN_COMMA, TOKEN_EQUALS)
         call error%raise(token%line, 'a '//quoted(text(token%first:token%last))//' without a key', expected=due)
      case default
         call error%raise(token%line, quoted(text(token%first:token%last))//' in &'//trim(group%name)// &
                          ' is not a key', expected=due)
      end select
   end subroutine blame

   !> Raises an error for a group or a key that a scene requires and lacks.
   subroutine check_complete(kinds, groups, last_line, error)
      type(group_kind_t), intent(in) :: kinds(:)
      type(group_t), intent(in) :: groups(:)
      integer, intent(in) :: last_line
      type(scene_error_t), intent(inout) :: error
      integer :: i, j, k

      do k = 1, size(kinds)
         if (kinds(k)%required .and. .not. any(groups%name == kinds(k)%name)) &
            call error%raise(last_line, 'the group &'//trim(kinds(k)%name)//' is missing', &
                             expected='exactly one in every scene')
      end do
      do i = 1, size(groups)
         k = findloc(kinds%name == groups(i)%name, .true., dim=1)
         if (k == 0) cycle
         do j = 1, size(kinds(k)%keys)
            if (kinds(k)%keys(j)%required .and. .not. groups(i)%has(kinds(k)%keys(j)%name)) &
               call error%raise(groups(i)%line, '&'//trim(groups(i)%name)//' lacks '//trim(kinds(k)%keys(j)%name), &
                                expected=expectation(kinds(k)%keys(j)))
         end do
      end do
   end subroutine check_complete

   !> Changes the room for groups and keeps the first ones.
   subroutine resize(groups, length, kept)
      type(group_t), allocatable, intent(inout) :: groups(:)
      !> New length; number of groups to keep.
      integer, intent(in) :: length, kept
      type(group_t), allocatable :: moved(:)
      integer :: i
      allocate (moved(length))
      do i = 1, kept
         moved(i)%name = groups(i)%name
         moved(i)%line = groups(i)%line
         call move_alloc(groups(i)%settings, moved(i)%settings)
      end do
      call move_alloc(moved, groups)
   end subroutine resize

end module nutate_scene_check
