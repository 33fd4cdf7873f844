!> Numbers as strings: checked letter by letter before conversion, so that no conversion can fail or trap.
module nutate_number_text
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
   use nutate_kinds, only: wp
   use nutate_limits, only: greatest_power, least_power
   use nutate_printable, only: quoted
   use nutate_spelling, only: lower_case
   implicit none
   private

   public :: read_real, read_whole, read_logical

   !> Maximum number of digits kept; more than are needed to round correctly.
   integer, parameter :: most_digits = 780
   !> Limit of exponents and digit counts; far beyond any number that can be represented.
   integer, parameter :: far = 100000000

   character(len=*), parameter :: digits = '0123456789'

   !> Parts of a real number: ± 0.DDDD × 10^power, DDDD without leading zeros.
   type :: decimal_t
      logical :: negative = .false.
      integer :: power = 0
      integer :: n_digits = 0
      character(len=most_digits + 1) :: digits = ''
   end type decimal_t

contains

   !> Reads a real number: digits with at most one point, then an optional exponent with E, D or Q, or (after a point)
   !> with its sign alone, as Fortran programs write it. `Infinity` becomes infinite.
   subroutine read_real(word, value, problem)
      character(len=*), intent(in) :: word
      !> Value; the largest or smallest number of its sign if it is too large or too close to zero.
      real(wp), intent(out) :: value
      !> Error message; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      type(decimal_t) :: decimal
      logical :: legal

      value = 0.0_wp
      problem = ''
      if (is_infinity(word)) then
         value = ieee_value(value, ieee_positive_inf)
         if (word(1:1) == '-') value = -value
         return
      end if
      call split_digits(word, decimal, legal)
      if (.not. legal) then
         problem = quoted(word)//' is not a number'
      else if (decimal%n_digits == 0) then
         return
      else if (is_too_large(decimal)) then
         problem = quoted(word)//' is too large'
         value = merge(-huge(value), huge(value), decimal%negative)
      else if (decimal%power - 1 < least_power) then
         problem = quoted(word)//' is too close to zero'
         value = merge(-tiny(value), tiny(value), decimal%negative)
      else
         call convert(decimal, value)
      end if
   end subroutine read_real

   !> Returns true for `inf` or `infinity`, with or without a sign, in any case.
   pure logical function is_infinity(word)
      character(len=*), intent(in) :: word
      integer :: first
      is_infinity = .false.
      if (len(word) < 3 .or. len(word) > 9) return
      first = 1
      if (scan(word(1:1), '+-') == 1) first = 2
      is_infinity = any(lower_case(word(first:)) == [character(len=8) :: 'inf', 'infinity'])
   end function is_infinity

   !> Returns true for more than one times the greatest power of ten.
   pure logical function is_too_large(decimal)
      type(decimal_t), intent(in) :: decimal
      logical :: is_one
      is_one = decimal%digits(1:1) == '1' .and. verify(decimal%digits(2:decimal%n_digits), '0') == 0
      is_too_large = decimal%power - 1 > greatest_power .or. (decimal%power - 1 == greatest_power .and. .not. is_one)
   end function is_too_large

   !> Splits a string into the parts of a number.
   pure subroutine split_digits(word, decimal, legal)
      character(len=*), intent(in) :: word
      type(decimal_t), intent(out) :: decimal
      !> The string is a number.
      logical, intent(out) :: legal
      integer :: i, after_point, n_mantissa, exponent
      logical :: point

      i = 1
      if (word /= '') decimal%negative = word(1:1) == '-'
      if (scan(word(1:min(1, len(word))), '+-') == 1) i = 2
      point = .false.
      after_point = 0
      n_mantissa = 0
      do i = i, len(word)
         if (word(i:i) == '.' .and. .not. point) then
            point = .true.
         else if (is_digit(word(i:i))) then
            n_mantissa = n_mantissa + 1
            if (point) after_point = after_point + 1
            call add_digit(decimal, word(i:i), point)
         else
            exit
         end if
      end do
      exponent = 0
      legal = n_mantissa > 0
      if (legal .and. i <= len(word)) call read_exponent(word(i:), point, exponent, legal)
      decimal%power = decimal%power + exponent
   end subroutine split_digits

   !> Appends a digit of the mantissa; leading zeros only move the point.
   pure subroutine add_digit(decimal, digit, after_point)
      type(decimal_t), intent(inout) :: decimal
      character, intent(in) :: digit
      logical, intent(in) :: after_point

      if (decimal%n_digits == 0 .and. digit == '0') then
         if (after_point) decimal%power = decimal%power - 1
         return
      end if
      if (.not. after_point) decimal%power = decimal%power + 1
      if (decimal%n_digits < most_digits) then
         decimal%n_digits = decimal%n_digits + 1
         decimal%digits(decimal%n_digits:decimal%n_digits) = digit
      else if (digit /= '0') then
         ! A nonzero digit in place of the omitted digits decides ties as they would.
         decimal%n_digits = most_digits + 1
         decimal%digits(most_digits + 1:) = '1'
      end if
   end subroutine add_digit

   !> Reads the exponent: `e12`, `D+3`, `q-4`; after a point also `+100`.
   pure subroutine read_exponent(tail, point, exponent, legal)
      character(len=*), intent(in) :: tail
      !> The mantissa has a point.
      logical, intent(in) :: point
      integer, intent(out) :: exponent
      logical, intent(out) :: legal
      integer :: i
      logical :: letter, negative

      exponent = 0
      letter = scan(tail(1:1), 'eEdDqQ') == 1
      i = merge(2, 1, letter)
      negative = .false.
      legal = letter
      if (i <= len(tail)) then
         if (scan(tail(i:i), '+-') == 1) then
            negative = tail(i:i) == '-'
            legal = letter .or. point
            i = i + 1
         end if
      end if
      legal = legal .and. i <= len(tail)
      if (legal) legal = verify(tail(i:), digits) == 0
      if (.not. legal) return
      do i = i, len(tail)
         exponent = min(10*exponent + index(digits, tail(i:i)) - 1, far)
      end do
      if (negative) exponent = -exponent
   end subroutine read_exponent

   !> Computes the number nearest to a decimal that is in range.
   subroutine convert(decimal, value)
      type(decimal_t), intent(in) :: decimal
      real(wp), intent(out) :: value
      character(len=most_digits + 20) :: canonical
      integer :: status

      write (canonical, '("0.",a,"e",i0)') decimal%digits(1:decimal%n_digits), decimal%power
      read (canonical, *, iostat=status) value
      if (status /= 0) value = 0.0_wp
      if (decimal%negative) value = -value
   end subroutine convert

   !> Reads an integer of at most nine digits, not counting leading zeros.
   subroutine read_whole(word, value, problem)
      character(len=*), intent(in) :: word
      integer, intent(out) :: value
      !> Error message; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      integer :: i, first, leading

      value = 0
      problem = ''
      first = 1
      if (word /= '') first = 1 + scan(word(1:1), '+-')
      if (verify(word(first:), digits) /= 0 .or. first > len(word)) then
         problem = quoted(word)//' is not a whole number'
         return
      end if
      leading = verify(word(first:), '0')
      if (leading == 0) return
      if (len(word) - (first + leading - 1) >= 9) then
         problem = quoted(word)//' is too large'
         return
      end if
      do i = first + leading - 1, len(word)
         value = 10*value + index(digits, word(i:i)) - 1
      end do
      if (word(1:1) == '-') value = -value
   end subroutine read_whole

   !> Reads `.true.` or `.false.`, also without points, or as the first letter alone.
   subroutine read_logical(word, value, problem)
      character(len=*), intent(in) :: word
      logical, intent(out) :: value
      !> Error message; empty on success.
      character(len=:), allocatable, intent(out) :: problem

      problem = ''
      value = .false.
      if (len(word) <= 7) then
         if (any(lower_case(word) == [character(len=7) :: '.false.', 'false', '.f.', 'f'])) return
         value = any(lower_case(word) == [character(len=7) :: '.true.', 'true', '.t.', 't'])
         if (value) return
      end if
      problem = quoted(word)//' is not a logical value'
   end subroutine read_logical

   pure logical function is_digit(letter)
      character, intent(in) :: letter
      is_digit = letter >= '0' .and. letter <= '9'
   end function is_digit

end module nutate_number_text
