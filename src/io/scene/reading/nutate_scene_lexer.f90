!> Splits a scene into tokens, one at a time: names of groups and keys, values, and separators.
!>
!> The notation is that of a Fortran namelist, with two restrictions: a string ends on the line where it begins, and `&`
!> only starts a group.
module nutate_scene_lexer
   use nutate_printable, only: quoted
   use nutate_scene_error, only: scene_error_t
   implicit none
   private

   public :: lexer_t, token_t, text_value
   public :: TOKEN_END, TOKEN_GROUP, TOKEN_SLASH, TOKEN_COMMA, TOKEN_EQUALS, TOKEN_KEY, TOKEN_WORD, TOKEN_TEXT

   !> End of the scene.
   integer, parameter :: TOKEN_END = 0
   !> `&name`: its span is the name.
   integer, parameter :: TOKEN_GROUP = 1
   integer, parameter :: TOKEN_SLASH = 2
   integer, parameter :: TOKEN_COMMA = 3
   !> An `=` without a key before it.
   integer, parameter :: TOKEN_EQUALS = 4
   !> A word before an `=`, which is read with it.
   integer, parameter :: TOKEN_KEY = 5
   !> A value without quotes.
   integer, parameter :: TOKEN_WORD = 6
   !> A value in quotes: its span is the string between them.
   integer, parameter :: TOKEN_TEXT = 7

   character, parameter :: tab = achar(9), newline = achar(10), return = achar(13)
   character(len=*), parameter :: blanks = ' '//tab//newline//return
   !> Characters that end a word.
   character(len=*), parameter :: word_ends = blanks//',=/!&''"'
   !> Characters that may follow a value.
   character(len=*), parameter :: separators = blanks//',=/!'

   !> Token of the scene.
   type :: token_t
      !> Kind: `TOKEN_...`
      integer :: kind = TOKEN_END
      !> Span in the scene.
      integer :: first = 1, last = 0
      !> Line where it begins.
      integer :: line = 0
      !> Number of times that the value counts: the `3` of `3*0.0`.
      integer :: repeat = 1
   end type token_t

   !> Position in the scene.
   type :: lexer_t
      integer :: position = 1
      integer :: line = 1
   contains
      !> Reads the next token.
      procedure :: next
   end type lexer_t

contains

   !> Reads the next token and moves behind it. Errors: a string that is not closed, a repeat count without a value,
   !> values that are not separated.
   subroutine next(self, text, token, error)
      class(lexer_t), intent(inout) :: self
      !> The scene.
      character(len=*), intent(in) :: text
      type(token_t), intent(out) :: token
      type(scene_error_t), intent(inout) :: error

      call skip_blanks(self, text)
      token%line = self%line
      token%first = self%position
      token%last = self%position
      if (self%position > len(text)) return
      select case (text(self%position:self%position))
      case ('/')
         token%kind = TOKEN_SLASH
      case (',')
         token%kind = TOKEN_COMMA
      case ('=')
         token%kind = TOKEN_EQUALS
      case ('&')
         token%kind = TOKEN_GROUP
         token%first = self%position + 1
         token%last = end_of_word(text, token%first)
      case ('''', '"')
         call read_text()
         return
      case default
         call read_word()
         return
      end select
      self%position = token%last + 1

   contains

      !> Reads a word: a key if an `=` follows, otherwise a value, perhaps with a repeat count.
      subroutine read_word()
         type(lexer_t) :: behind
         integer :: star

         token%kind = TOKEN_WORD
         token%last = end_of_word(text, token%first)
         self%position = token%last + 1
         star = repeat_width(text(token%first:token%last))
         if (star > 0) then
            token%repeat = repeat_count(text(token%first:token%first + star - 2))
            token%first = token%first + star
            if (token%repeat == 0) then
               call error%raise(token%line, 'a repeat count is zero', expected='a count of 1 or more before *')
            else if (token%first <= token%last) then
               continue
            else if (starts_text(text, self%position)) then
               call read_text()
               return
            else
               call error%raise(token%line, 'nothing is repeated after *', expected='a value right after it')
            end if
         end if
         behind = self
         call skip_blanks(behind, text)
         if (behind%position <= len(text)) then
            if (text(behind%position:behind%position) == '=') then
               token%kind = TOKEN_KEY
               self%line = behind%line
               self%position = behind%position + 1
               return
            end if
         end if
         call check_separated()
      end subroutine read_word

      !> Reads a string in quotes; a doubled quote inside stands for one.
      subroutine read_text()
         character :: quote
         integer :: step

         token%kind = TOKEN_TEXT
         quote = text(self%position:self%position)
         self%position = self%position + 1
         token%first = self%position
         do
            step = scan(text(self%position:), quote//newline)
            if (step > 0) self%position = self%position + step - 1
            if (step == 0 .or. self%position > len(text)) exit
            if (text(self%position:self%position) == newline) exit
            token%last = self%position - 1
            self%position = self%position + 1
            if (self%position > len(text)) return
            if (text(self%position:self%position) /= quote) then
               call check_separated()
               return
            end if
            self%position = self%position + 1
         end do
         call error%raise(token%line, 'a string is not closed', expected='a '//quote//' at its end, on the same line')
         self%position = len(text) + 1
      end subroutine read_text

      !> Raises an error for a value that is not separated from the next one.
      subroutine check_separated()
         if (self%position > len(text)) return
         if (scan(text(self%position:self%position), separators) == 1) return
         call error%raise(self%line, quoted(text(self%position:end_of_word(text, self%position + 1)))// &
                          ' follows a value without a separator', expected='a comma or a blank between values')
      end subroutine check_separated

   end subroutine next

   !> Moves over blanks, ends of lines and comments.
   pure subroutine skip_blanks(self, text)
      type(lexer_t), intent(inout) :: self
      character(len=*), intent(in) :: text
      do while (self%position <= len(text))
         select case (text(self%position:self%position))
         case (newline)
            self%line = self%line + 1
         case (' ', tab, return)
            continue
         case ('!')
            self%position = end_of_line(text, self%position)
            cycle
         case default
            return
         end select
         self%position = self%position + 1
      end do
   end subroutine skip_blanks

   !> Returns the value of a string in quotes: doubled quotes single.
   pure function text_value(text, token) result(value)
      !> The scene.
      character(len=*), intent(in) :: text
      !> Token of kind `TOKEN_TEXT`.
      type(token_t), intent(in) :: token
      character(len=:), allocatable :: value
      character :: quote
      integer :: i, n

      quote = text(token%first - 1:token%first - 1)
      value = text(token%first:token%last)
      n = 0
      i = token%first
      do while (i <= token%last)
         n = n + 1
         value(n:n) = text(i:i)
         i = i + merge(2, 1, text(i:i) == quote)
      end do
      value = value(1:n)
   end function text_value

   !> Returns the last position of a word that starts at `first`; `first - 1` if there is none.
   pure integer function end_of_word(text, first) result(last)
      character(len=*), intent(in) :: text
      integer, intent(in) :: first
      last = scan(text(first:), word_ends)
      if (last == 0) last = len(text(first:)) + 1
      last = first + last - 2
   end function end_of_word

   !> Returns the position of the next end of line, or behind the text.
   pure integer function end_of_line(text, first) result(position)
      character(len=*), intent(in) :: text
      integer, intent(in) :: first
      position = index(text(first:), newline)
      position = merge(len(text) + 1, first + position - 1, position == 0)
   end function end_of_line

   !> Returns the length of `3*` at the start of a word; 0 if it does not start so.
   pure integer function repeat_width(word) result(width)
      character(len=*), intent(in) :: word
      width = verify(word, '0123456789')
      if (width < 2) then
         width = 0
      else if (word(width:width) /= '*') then
         width = 0
      end if
   end function repeat_width

   !> Returns the number that some digits represent, or a very large one.
   pure integer function repeat_count(digits) result(n)
      character(len=*), intent(in) :: digits
      integer :: i
      n = 0
      do i = 1, len(digits)
         n = min(10*n + iachar(digits(i:i)) - iachar('0'), 100000000)
      end do
   end function repeat_count

   pure logical function starts_text(text, position)
      character(len=*), intent(in) :: text
      integer, intent(in) :: position
      starts_text = .false.
      if (position <= len(text)) starts_text = scan(text(position:position), '''"') == 1
   end function starts_text

end module nutate_scene_lexer
