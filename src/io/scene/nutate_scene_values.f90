!> The values of one key: read from tokens, converted, and tested against what the key admits.
module nutate_scene_values
   use nutate_keys, only: key_t, setting_t, value_t, KEY_INTEGER, KEY_LOGICAL, KEY_REAL, KEY_TEXT, &
      ANY_VALUE, NON_NEGATIVE, NOT_ZERO, POSITIVE, POSITIVE_OR_INFINITE
   use nutate_kinds, only: wp
   use nutate_number_text, only: read_logical, read_real, read_whole
   use nutate_printable, only: quoted
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_lexer, only: lexer_t, token_t, text_value, TOKEN_COMMA, TOKEN_EQUALS, TOKEN_TEXT, TOKEN_WORD
   use nutate_spelling, only: is_listed, nearest_name, split_list
   implicit none
   private

   public :: read_values, expectation

   !> Numbers of which a scene needs more than their sign lie in this range, so that squares and products of a few stay
   !> finite.
   real(wp), parameter :: least_size = 1e-100_wp
   !> Longest text: longer than any path.
   integer, parameter :: longest_text = 4096

contains

   !> Reads what stands behind `key =`, up to the next key or the end of the group, as the values of a key.
   subroutine read_values(lexer, text, key, setting, token, error)
      type(lexer_t), intent(inout) :: lexer
      !> The scene.
      character(len=*), intent(in) :: text
      type(key_t), intent(in) :: key
      !> Its name and line are set already.
      type(setting_t), intent(inout) :: setting
      !> The token behind the values.
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
      if (key%range == NOT_ZERO) call check_not_zero(key, values(1:n), setting%line, error)
   end subroutine read_values

   !> Raises an error unless a key has as many values as it needs.
   subroutine check_count(key, n, line, error)
      type(key_t), intent(in) :: key
      integer, intent(in) :: n, line
      type(scene_error_t), intent(inout) :: error
      character(len=24) :: count
      if (n >= key%least) return
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
      if (problem == '' .and. any(key%kind == [KEY_INTEGER, KEY_REAL])) then
         if (.not. in_range(value%number, key%range)) problem = quoted(text(token%first:token%last))//' is out of range'
      end if
      if (problem /= '') call error%raise(token%line, problem, expected=expectation(key)//' for '//trim(key%name))
   end subroutine read_value

   !> A text of which a beginning is left that is still too long.
   pure type(token_t) function shortened(token)
      type(token_t), intent(in) :: token
      shortened = token
      shortened%last = min(token%last, token%first + 2*longest_text + 2)
   end function shortened

   !> True if a number is what a range admits.
   pure logical function in_range(number, range)
      real(wp), intent(in) :: number
      !> `ANY_VALUE`, ...
      integer, intent(in) :: range
      in_range = .true.
      select case (range)
      case (POSITIVE)
         in_range = number >= least_size .and. number <= huge(number)
      case (NON_NEGATIVE)
         in_range = number >= 0.0_wp .and. number <= huge(number)
      case (POSITIVE_OR_INFINITE)
         in_range = number >= least_size
      case default
         in_range = abs(number) <= huge(number)
      end select
   end function in_range

   !> Raises an error if all numbers are zero, or so small that their squares are.
   subroutine check_not_zero(key, values, line, error)
      type(key_t), intent(in) :: key
      type(value_t), intent(in) :: values(:)
      integer, intent(in) :: line
      type(scene_error_t), intent(inout) :: error
      if (any(abs(values%number) >= least_size)) return
      call error%raise(line, trim(key%name)//' is zero', expected=expectation(key))
   end subroutine check_not_zero

   !> Raises an error for a text that is not one of the key's choices, is too long or has control characters.
   subroutine check_text(key, text, line, error)
      type(key_t), intent(in) :: key
      character(len=*), intent(in) :: text
      integer, intent(in) :: line
      type(scene_error_t), intent(inout) :: error
      integer :: i

      if (key%choices /= '') then
         if (is_listed(text, key%choices) .and. text /= '') return
         call error%raise(line, quoted(text)//' is not available for '//trim(key%name), expected=expectation(key), &
                          nearest=nearest_name(text, split_list(key%choices)))
      else if (len(text) > longest_text) then
         call error%raise(line, quoted(text)//' is too long', expected='a shorter text for '//trim(key%name))
      end if
      do i = 1, len(text)
         if (error%raised) return
         if (iachar(text(i:i)) < 32 .or. iachar(text(i:i)) == 127) &
            call error%raise(line, quoted(text)//' has a control character', expected='a text for '//trim(key%name))
      end do
   end subroutine check_text

   !> What a key expects, in words: `3 numbers > 0`.
   pure function expectation(key) result(words)
      type(key_t), intent(in) :: key
      character(len=:), allocatable :: words
      character(len=12) :: many

      select case (key%kind)
      case (KEY_LOGICAL)
         words = '.true. or .false.'
         return
      case (KEY_TEXT)
         words = 'a text in quotes'
         if (key%choices /= '') words = quoted_list(key%choices)
         return
      case default
         words = 'number'
         if (key%kind == KEY_INTEGER) words = 'whole number'
      end select
      if (key%most == 1) then
         words = 'a '//words//range_in_words(key%range)
      else
         write (many, '(i0)') key%most
         if (key%least < key%most) write (many, '(i0," to ",i0)') key%least, key%most
         words = trim(many)//' '//words//'s'//range_in_words(key%range)
      end if
   end function expectation

   !> What a range adds to `a number`.
   pure function range_in_words(range) result(words)
      !> `ANY_VALUE`, ...
      integer, intent(in) :: range
      character(len=:), allocatable :: words
      select case (range)
      case (POSITIVE)
         words = ' > 0'
      case (NON_NEGATIVE)
         words = ' >= 0'
      case (NOT_ZERO)
         words = ', not zero'
      case (POSITIVE_OR_INFINITE)
         words = ' > 0, or Infinity'
      case default
         words = ''
      end select
   end function range_in_words

   !> `'a', 'b'` for `a,b`.
   pure function quoted_list(list) result(words)
      character(len=*), intent(in) :: list
      character(len=:), allocatable :: words
      character(len=:), allocatable :: item
      integer :: i
      words = ''
      associate (names => split_list(list))
         do i = 1, size(names)
            item = "'"//trim(names(i))//"'"
            if (i > 1) words = words//', '
            words = words//item
         end do
      end associate
   end function quoted_list

end module nutate_scene_values
