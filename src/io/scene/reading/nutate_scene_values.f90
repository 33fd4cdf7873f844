!> The values of one key: read from tokens, converted, and tested against what the key admits.
module nutate_scene_values
   use nutate_keys, only: group_t, key_t, setting_t, value_t, KEY_INTEGER, KEY_LOGICAL, KEY_REAL, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_number_text, only: read_logical, read_real, read_whole
   use nutate_printable, only: quoted
   use nutate_quantities, only: find_quantity, quantities, reason_of
   use nutate_quantity, only: AS_EVENT
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_lexer, only: lexer_t, token_t, text_value, TOKEN_COMMA, TOKEN_EQUALS, TOKEN_TEXT, TOKEN_WORD
   use nutate_spelling, only: is_listed, nearest_name, split_list
   implicit none
   private

   public :: read_values, check_setting, check_values, expectation

   !> Length of the longest string: longer than any path.
   integer, parameter :: longest_text = 4096
   !> Largest length of the list of choices in a message.
   integer, parameter :: longest_choices = 700

contains

   !> Reads the values of a key: everything after `key =`, up to the next key or the end of the group.
   subroutine read_values(lexer, text, key, setting, token, error)
      type(lexer_t), intent(inout) :: lexer
      !> Text of the scene.
      character(len=*), intent(in) :: text
      type(key_t), intent(in) :: key
      !> Setting of the key; its name and line are set already.
      type(setting_t), intent(inout) :: setting
      !> Token after the values.
      type(token_t), intent(out) :: token
      type(scene_error_t), intent(inout) :: error
      type(value_t) :: values(key%most)
      logical :: after_value
      integer :: n

      n = 0
      after_value = .false.
      do
         call lexer%next(text, token, error)
         if (error%raised) return
         select case (token%kind)
         case (TOKEN_WORD, TOKEN_TEXT)
            if (token%repeat > key%most - n) then
               call error%raise(token%line, quoted(text(token%first:token%last))//' is one value too many for '// &
                                trim(key%name), expected=expectation(key))
               return
            end if
            call read_value(text, token, key, values(n + 1), error)
            if (error%raised) return
            values(n + 2:n + token%repeat) = values(n + 1)
            n = n + token%repeat
            after_value = .true.
         case (TOKEN_COMMA)
            if (.not. after_value) call error%raise(token%line, 'a value of '//trim(key%name)//' is left out', &
                                                    expected=expectation(key))
            after_value = .false.
         case (TOKEN_EQUALS)
            call error%raise(token%line, "a second '=' behind "//trim(key%name), expected=expectation(key))
         case default
            exit
         end select
      end do
      call check_count(key, n, setting%line, error)
      if (error%raised) return
      setting%kind = key%kind
      setting%values = values(1:n)
      call check_together(key, setting, error)
   end subroutine read_values

   !> Raises an error unless a key has as many values as it needs, and no more.
   subroutine check_count(key, n, line, error)
      type(key_t), intent(in) :: key
      integer, intent(in) :: n, line
      type(scene_error_t), intent(inout) :: error
      character(len=24) :: count
      if (n >= key%least .and. n <= key%most) return
      write (count, '(i0,a)') n, merge(' value ', ' values', n == 1)
      if (n == 0) count = 'no value'
      call error%raise(line, trim(key%name)//' has '//trim(count), expected=expectation(key))
   end subroutine check_count

   !> Converts one value. Errors: not of the key's kind, out of its range, not one of its choices.
   subroutine read_value(text, token, key, value, error)
      character(len=*), intent(in) :: text
      type(token_t), intent(in) :: token
      type(key_t), intent(in) :: key
      type(value_t), intent(out) :: value
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: problem

      problem = ''
      if ((token%kind == TOKEN_TEXT) .neqv. (key%kind == KEY_TEXT)) then
         call error%raise(token%line, quoted(text(token%first:token%last))//' is '// &
                          trim(merge('in quotes    ', 'not in quotes', token%kind == TOKEN_TEXT)), &
                          expected=expectation(key)//' for '//trim(key%name))
         return
      end if
      select case (key%kind)
      case (KEY_TEXT)
         value%text = text_value(text, shortened(token))
         call check_text(key, value%text, token%line, error)
      case (KEY_LOGICAL)
         call read_logical(text(token%first:token%last), value%flag, problem)
      case (KEY_INTEGER)
         call read_whole(text(token%first:token%last), value%whole, problem)
         value%number = value%whole
      case (KEY_REAL)
         call read_real(text(token%first:token%last), value%number, problem)
      case default
         problem = 'a value of no kind'
      end select
      ! For a number out of range, the message of the key states the sizes that it admits.
      if (any(key%kind == [KEY_INTEGER, KEY_REAL]) .and. (problem == '' .or. abs(value%number) > 0.0_wp)) then
         problem = key%fault(value%number)
         if (problem /= '') call error%raise(token%line, quoted(text(token%first:token%last))//' '//problem)
      else if (problem /= '') then
         call error%raise(token%line, problem, expected=expectation(key)//' for '//trim(key%name))
      end if
   end subroutine read_value

   !> Returns the token of a string, shortened to a beginning that is still too long.
   pure type(token_t) function shortened(token)
      type(token_t), intent(in) :: token
      shortened = token
      shortened%last = min(token%last, token%first + 2*longest_text + 2)
   end function shortened

   !> Raises an error if the numbers of a key are not admitted together.
   subroutine check_together(key, setting, error)
      type(key_t), intent(in) :: key
      type(setting_t), intent(in) :: setting
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: problem
      if (all(key%kind /= [KEY_INTEGER, KEY_REAL])) return
      problem = key%fault_of_all(setting%values%number)
      if (problem /= '') call error%raise(setting%line, trim(key%name)//' '//problem)
   end subroutine check_together

   !> Raises an error for the first value of a group that its key does not admit: for groups that come from elsewhere
   !> than a scene.
   subroutine check_values(group, keys, error)
      type(group_t), intent(in) :: group
      !> All keys of the group.
      type(key_t), intent(in) :: keys(:)
      type(scene_error_t), intent(inout) :: error
      integer :: i, k
      do i = 1, size(group%settings)
         do k = 1, size(keys)
            if (keys(k)%name == group%settings(i)%name) call check_setting(keys(k), group%settings(i), error)
         end do
      end do
   end subroutine check_values

   !> Raises an error for the first value of a setting that its key does not admit.
   subroutine check_setting(key, setting, error)
      type(key_t), intent(in) :: key
      type(setting_t), intent(in) :: setting
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: problem
      character(len=32) :: digits
      integer :: i
      call check_count(key, size(setting%values), setting%line, error)
      do i = 1, size(setting%values)
         if (error%raised) return
         if (key%kind == KEY_TEXT) then
            call check_text(key, setting%values(i)%text, setting%line, error)
         else
            problem = key%fault(setting%values(i)%number)
            if (problem == '') cycle
            write (digits, '(g0)') setting%values(i)%number
            call error%raise(setting%line, trim(digits)//' '//problem)
         end if
      end do
      if (.not. error%raised) call check_together(key, setting, error)
   end subroutine check_setting

   !> Raises an error for a string that is not one of the key's choices, with the reason if a quantity is no event.
   subroutine raise_unknown(key, text, line, error)
      type(key_t), intent(in) :: key
      character(len=*), intent(in) :: text
      integer, intent(in) :: line
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: choices, nearest
      integer :: at
      at = find_quantity(text)
      if (key%name == 'when' .and. at > 0) then
         call error%raise(line, quoted(text)//' cannot be the quantity of an event: it '// &
                          reason_of(quantities(at), AS_EVENT), expected='a smooth function of the state')
         return
      end if
      choices = expectation(key)
      nearest = trim(nearest_name(text, split_list(key%choices)))
      if (len(choices) > longest_choices) choices = 'a name that the reference lists'
      call error%raise(line, quoted(text)//' is not available for '//trim(key%name), choices, nearest)
   end subroutine raise_unknown

   !> Raises an error for a string that is not one of the key's choices, is too long or has control characters.
   subroutine check_text(key, text, line, error)
      type(key_t), intent(in) :: key
      character(len=*), intent(in) :: text
      integer, intent(in) :: line
      type(scene_error_t), intent(inout) :: error
      integer :: i

      if (key%choices /= '') then
         if (is_listed(text, key%choices) .and. text /= '') return
         call raise_unknown(key, text, line, error)
      else if (len(text) > longest_text) then
         call error%raise(line, quoted(text)//' is too long', expected='a shorter text for '//trim(key%name))
      end if
      do i = 1, len(text)
         if (error%raised) return
         if (iachar(text(i:i)) < 32 .or. iachar(text(i:i)) == 127) &
            call error%raise(line, quoted(text)//' has a control character', expected='a string for '//trim(key%name))
      end do
   end subroutine check_text

   !> Returns what a key expects, in words: `3 numbers > 0`.
   pure function expectation(key) result(words)
      type(key_t), intent(in) :: key
      character(len=:), allocatable :: words

      select case (key%kind)
      case (KEY_LOGICAL)
         words = '.true. or .false.'
      case (KEY_TEXT)
         words = 'a string in quotes'
         if (key%choices /= '') words = quoted_list(key%choices)
      case default
         words = key%expected_numbers()
      end select
   end function expectation

   !> Returns `'a', 'b'` for `a,b`, and `'wheel1' to 'wheel6'` for names that differ by the number at their end.
   pure function quoted_list(list) result(words)
      character(len=*), intent(in) :: list
      character(len=:), allocatable :: words
      integer :: first, last
      words = ''
      associate (names => split_list(list))
         first = 1
         do while (first <= size(names))
            last = first
            do while (last < size(names))
               if (stem(names(last + 1)) /= stem(names(first)) .or. stem(names(first)) == names(first)) exit
               last = last + 1
            end do
            if (first > 1) words = words//', '
            words = words//quoted(trim(names(first)))
            if (last > first) words = words//' to '//quoted(trim(names(last)))
            first = last + 1
         end do
      end associate
   end function quoted_list

   !> Returns a name without the number at its end.
   pure function stem(name)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: stem
      stem = name(:verify(trim(name), '0123456789', back=.true.))
   end function stem

end module nutate_scene_values
