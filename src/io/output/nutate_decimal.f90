!> Numbers as decimal text: as short as reads back exactly, or rounded for people.
!>
!> The 17 digits of x are those of the integer nearest to |x| 10^(16-k), 10^k <= |x| < 10^(k+1). The product is
!> formed in twice the working precision (error below 1e-28 of it), so that the text lies within half a unit of the
!> 17th digit, and 15 or 16 digits are used if they stay within half the distance to the next double: the text
!> reads back exactly by construction. This takes a fifth of the time of a formatted write.
module nutate_decimal
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: decimal_t, decimal_length, append_rounded, exact_text, multiply, rounded_text

   !> Length of the longest number.
   integer, parameter :: decimal_length = 24
   !> Numbers of a larger or smaller power of ten are left to the runtime.
   integer, parameter :: largest_power = 120
   !> Powers of ten between these bounds are written without exponent.
   integer, parameter :: least_plain = -5, most_plain = 16
   !> Units of the last digit of numbers of 15 and 16 digits, in units of the 17th.
   integer(long), parameter :: units(2) = [100_long, 10_long]

   !> Writer of numbers; constant after `prepare`.
   type :: decimal_t
      private
      !> 10^n as the unevaluated sum of two numbers.
      real(wp), allocatable :: power_high(:), power_low(:)
   contains
      !> Computes the powers of ten.
      procedure :: prepare
      !> Appends a number to a line.
      procedure :: append
   end type decimal_t

contains

   !> Computes the powers of ten.
   pure subroutine prepare(self)
      class(decimal_t), intent(inout) :: self
      integer, parameter :: last = largest_power + 18
      real(wp) :: tenth, tenth_low
      integer :: n

      if (allocated(self%power_high)) return
      allocate (self%power_high(-last:last), self%power_low(-last:last))
      ! Rounding error of 0.1: 10*0.1 exceeds 1 by ten times this error.
      call multiply(0.1_wp, 0.0_wp, 10.0_wp, 0.0_wp, tenth, tenth_low)
      tenth_low = -((tenth - 1.0_wp) + tenth_low)/10.0_wp
      tenth = 0.1_wp
      self%power_high(0) = 1.0_wp
      self%power_low(0) = 0.0_wp
      do n = 1, last
         call multiply(self%power_high(n - 1), self%power_low(n - 1), 10.0_wp, 0.0_wp, &
                       self%power_high(n), self%power_low(n))
         call multiply(self%power_high(1 - n), self%power_low(1 - n), tenth, tenth_low, &
                       self%power_high(-n), self%power_low(-n))
      end do
   end subroutine prepare

   !> Appends a finite number to a line: as short as reads back exactly.
   pure subroutine append(self, line, used, x)
      class(decimal_t), intent(in) :: self
      character(len=*), intent(inout) :: line
      !> Characters of the line in use; at least `decimal_length` more must be free.
      integer, intent(inout) :: used
      real(wp), intent(in) :: x
      integer(long) :: digits
      integer :: power

      ! The sign bit decides: -0 is written as -0.
      if (sign(1.0_wp, x) < 0.0_wp) call put('-', line, used)
      if (abs(x) > 0.0_wp) then
         call get_digits(self, abs(x), digits, power)
         call place(digits, power, line, used)
      else
         call put('0', line, used)
      end if
   end subroutine append

   !> Finds 17 decimal digits of x > 0 (the last ones zero if they are not needed), as an integer, and the power of ten
   !> of the first.
   pure subroutine get_digits(self, x, digits, power)
      class(decimal_t), intent(in) :: self
      real(wp), intent(in) :: x
      integer(long), intent(out) :: digits
      integer, intent(out) :: power
      real(wp) :: high, low, rest, reach
      integer(long) :: bits, shorter
      integer :: binary_power, i

      ! The fields of an IEEE double: |x| = 2**binary_power (1 + ...); the intrinsics would cost more than all the
      ! rest.
      bits = transfer(x, bits)
      binary_power = int(ishft(bits, -52)) - 1023
      power = floor(0.30103_wp*real(binary_power, wp))
      if (abs(power) > largest_power) then
         call read_digits(x, 17, digits, power)
         return
      end if
      call multiply(x, 0.0_wp, self%power_high(16 - power), self%power_low(16 - power), high, low)
      if (high > 1e17_wp .or. (high >= 1e17_wp .and. low >= 0.0_wp)) then
         power = power + 1
         call multiply(x, 0.0_wp, self%power_high(16 - power), self%power_low(16 - power), high, low)
      end if
      ! The high part is an integer, since it exceeds 2**53.
      shorter = int(low + sign(0.5_wp, low), long)
      digits = int(high, long) + shorter
      rest = low - real(shorter, wp)
      ! Half the distance 2**(binary_power - 52) to the next double; a quarter if the double below is nearer.
      reach = 0.49999_wp*transfer(ishft(int(binary_power - 52 + 1023, long), 52), reach)*self%power_high(16 - power)
      if (iand(bits, 2_long**52 - 1) == 0) reach = 0.5_wp*reach
      do i = 1, size(units)
         shorter = units(i)*((digits + units(i)/2)/units(i))
         if (abs(real(shorter - digits, wp) - rest) < reach) then
            digits = shorter
            exit
         end if
      end do
      if (digits >= 100000000000000000_long) then
         digits = digits/10
         power = power + 1
      end if
   end subroutine get_digits

   !> Finds `n` decimal digits of x > 0, as an integer of 17 digits, and the power of ten of the first, by a formatted
   !> write: for numbers of extreme size and for people.
   pure subroutine read_digits(x, n, digits, power)
      real(wp), intent(in) :: x
      integer, intent(in) :: n
      integer(long), intent(out) :: digits
      integer, intent(out) :: power
      character(len=decimal_length) :: text
      character(len=17) :: spelt
      character(len=12) :: form
      integer :: mark
      write (form, '("(es24.",i0,"e3)")') n - 1
      write (text, form) x
      text = adjustl(text)
      mark = index(text, 'E')
      spelt = text(1:1)//text(3:mark - 1)//repeat('0', 17 - n)
      read (spelt, '(i17)') digits
      read (text(mark + 1:), '(i4)') power
   end subroutine read_digits

   !> Writes 17 digits, the first of power `power`, without the zeros at their end.
   pure subroutine place(digits, power, line, used)
      integer(long), intent(in) :: digits
      integer, intent(in) :: power
      character(len=*), intent(inout) :: line
      integer, intent(inout) :: used
      character(len=*), parameter :: zeros = repeat('0', -least_plain)
      character(len=17) :: text
      integer :: n, whole

      call spell(digits, text, n)
      if (power < 0 .and. power >= least_plain) then
         call put('0.', line, used)
         call put(zeros(1:-power - 1), line, used)
         call put(text(1:n), line, used)
         return
      end if
      whole = 1
      if (power >= 0 .and. power <= most_plain) whole = power + 1
      call put(text(1:whole), line, used)
      if (n > whole) then
         call put('.', line, used)
         call put(text(whole + 1:n), line, used)
      end if
      if (power < 0 .or. power > most_plain) call put_power(power, line, used)
   end subroutine place

   !> Appends a power of ten: E-13.
   pure subroutine put_power(power, line, used)
      !> Exponent of at most three digits.
      integer, intent(in) :: power
      character(len=*), intent(inout) :: line
      integer, intent(inout) :: used
      integer :: rest
      call put('E', line, used)
      call put(merge('-', '+', power < 0), line, used)
      rest = abs(power)
      if (rest >= 100) call put(achar(48 + rest/100), line, used)
      if (rest >= 10) call put(achar(48 + modulo(rest/10, 10)), line, used)
      call put(achar(48 + modulo(rest, 10)), line, used)
   end subroutine put_power

   !> Appends a piece of text to a line.
   pure subroutine put(piece, line, used)
      character(len=*), intent(in) :: piece
      character(len=*), intent(inout) :: line
      integer, intent(inout) :: used
      line(used + 1:used + len(piece)) = piece
      used = used + len(piece)
   end subroutine put

   !> Finds the 17 characters of an integer and the number of them before the zeros at the end, at least one.
   pure subroutine spell(digits, text, n)
      integer(long), intent(in) :: digits
      character(len=17), intent(out) :: text
      integer, intent(out) :: n
      integer(long) :: rest, next
      integer :: i
      rest = digits
      n = 1
      do i = 17, 1, -1
         next = rest/10
         text(i:i) = achar(int(rest - 10*next) + 48)
         if (n == 1 .and. rest /= 10*next) n = i
         rest = next
      end do
   end subroutine spell

   !> Computes (high + low) = (a + a_low)(b + b_low) in twice the working precision (Dekker 1971). The factors are split
   !> into halves by bits so that fused operations do no harm.
   pure subroutine multiply(a, a_low, b, b_low, high, low)
      real(wp), intent(in) :: a, a_low, b, b_low
      real(wp), intent(out) :: high, low
      real(wp) :: a1, a2, b1, b2, product, error
      a1 = leading_half(a)
      a2 = a - a1
      b1 = leading_half(b)
      b2 = b - b1
      product = a*b
      error = ((a1*b1 - product) + a1*b2 + a2*b1) + a2*b2 + (a*b_low + a_low*b)
      high = product + error
      low = error - (high - product)
   end subroutine multiply

   !> Returns the leading 26 bits of a number.
   pure real(wp) function leading_half(x)
      real(wp), intent(in) :: x
      leading_half = transfer(iand(transfer(x, 1_long), not(2_long**27 - 1)), x)
   end function leading_half

   !> Returns a finite number as text, as short as reads back exactly.
   pure function exact_text(x) result(text)
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text
      type(decimal_t) :: decimal
      character(len=decimal_length) :: line
      integer :: used
      call decimal%prepare()
      used = 0
      call decimal%append(line, used, x)
      text = line(1:used)
   end function exact_text

   !> Returns a number as text, rounded for people, without zeros at the end.
   pure function rounded_text(x, n) result(text)
      real(wp), intent(in) :: x
      !> Significant digits, 1 to 17; default 6.
      integer, intent(in), optional :: n
      character(len=:), allocatable :: text
      character(len=decimal_length) :: line
      integer :: used, kept

      if (.not. abs(x) <= huge(x)) then
         text = 'infinite'
         return
      end if
      kept = 6
      if (present(n)) kept = n
      used = 0
      call append_rounded(line, used, x, kept)
      text = line(1:used)
   end function rounded_text

   !> Appends a finite number to a line, rounded, without zeros at its end.
   pure subroutine append_rounded(line, used, x, n)
      character(len=*), intent(inout) :: line
      !> Characters of the line in use; at least `decimal_length` more must be free.
      integer, intent(inout) :: used
      real(wp), intent(in) :: x
      !> Significant digits, 1 to 17.
      integer, intent(in) :: n
      integer(long) :: digits
      integer :: power
      digits = 0
      power = 0
      if (abs(x) > 0.0_wp) call read_digits(abs(x), n, digits, power)
      if (x < 0.0_wp) call put('-', line, used)
      call place(digits, power, line, used)
   end subroutine append_rounded

end module nutate_decimal
