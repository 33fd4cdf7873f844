!> Numbers of long tables, read quickly: as integers times a power of ten, only if the rounding is certain.
module nutate_quick_number
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_decimal, only: multiply
   use nutate_kinds, only: wp
   implicit none
   private

   public :: read_quickly

   !> Limits of the mantissa: up to the first another digit can be added; up to the second a `wp` holds it exactly; up
   !> to the third its rounding to a `wp` fits into an integer.
   integer(int64), parameter :: room = 900000000000000000_int64, exact = 2_int64**53, &
                                countable = 9200000000000000000_int64
   !> Powers of ten up to this are a `wp` exactly.
   integer, parameter :: most_power = 22
   integer :: i
   real(wp), parameter :: powers(0:most_power) = [(10.0_wp**i, i=0, most_power)]
   !> Limit of the exponent.
   integer, parameter :: far = 10000
   !> Relative uncertainty of the part that is rounded away; the actual errors are far smaller.
   real(wp), parameter :: doubt = 2.0_wp**(-40)

contains

   !> Reads a number, rounded correctly; not done if it is no plain number, or has too many digits or too large a power.
   pure subroutine read_quickly(word, value, done)
      character(len=*), intent(in) :: word
      real(wp), intent(out) :: value
      logical, intent(out) :: done
      integer(int64) :: mantissa
      integer :: power

      value = 0.0_wp
      call split_digits(word, mantissa, power, done)
      if (.not. done .or. mantissa == 0) return
      done = mantissa <= countable .and. abs(power) <= 2*most_power
      if (.not. done) return
      if (mantissa <= exact .and. abs(power) <= most_power) then
         value = real(mantissa, wp)
         if (power < 0) then
            value = value/powers(-power)
         else
            value = value*powers(power)
         end if
      else
         call scale(mantissa, power, value, done)
      end if
      if (word(1:1) == '-') value = -value
   end subroutine read_quickly

   !> Splits a number such as `-12.5e3` into digits and power of ten.
   pure subroutine split_digits(word, mantissa, power, done)
      character(len=*), intent(in) :: word
      integer(int64), intent(out) :: mantissa
      integer, intent(out) :: power
      logical, intent(out) :: done
      integer :: k, digit, n
      logical :: point

      mantissa = 0
      power = 0
      n = 0
      point = .false.
      done = .false.
      k = 1
      if (len(word) > 0) then
         if (word(1:1) == '-' .or. word(1:1) == '+') k = 2
      end if
      do k = k, len(word)
         digit = ichar(word(k:k)) - ichar('0')
         if (digit >= 0 .and. digit <= 9) then
            if (mantissa > room) return
            mantissa = 10*mantissa + digit
            n = n + 1
            if (point) power = power - 1
         else if (word(k:k) == '.' .and. .not. point) then
            point = .true.
         else
            exit
         end if
      end do
      done = n > 0
      if (done .and. k <= len(word)) call add_exponent(word(k:), power, done)
   end subroutine split_digits

   !> Adds `e-3`.
   pure subroutine add_exponent(tail, power, done)
      character(len=*), intent(in) :: tail
      integer, intent(inout) :: power
      logical, intent(out) :: done
      integer :: k, digit, first, exponent

      done = .false.
      if (tail(1:1) /= 'e' .and. tail(1:1) /= 'E') return
      first = 2
      if (len(tail) > 1) then
         if (tail(2:2) == '-' .or. tail(2:2) == '+') first = 3
      end if
      if (first > len(tail)) return
      exponent = 0
      do k = first, len(tail)
         digit = ichar(tail(k:k)) - ichar('0')
         if (digit < 0 .or. digit > 9 .or. exponent > far) return
         exponent = 10*exponent + digit
      end do
      if (tail(2:2) == '-') exponent = -exponent
      power = power + exponent
      done = .true.
   end subroutine add_exponent

   !> Computes an integer times a power of ten, as a sum of two numbers.
   pure subroutine scale(mantissa, power, value, done)
      integer(int64), intent(in) :: mantissa
      integer, intent(in) :: power
      real(wp), intent(out) :: value
      logical, intent(out) :: done
      real(wp) :: high, low, product, error
      integer :: rest, part

      high = real(mantissa, wp)
      low = real(mantissa - int(high, int64), wp)
      rest = abs(power)
      do while (rest > 0)
         part = min(rest, most_power)
         if (power > 0) then
            call multiply(high, low, powers(part), 0.0_wp, product, error)
            high = product
            low = error
         else
            call divide(powers(part), high, low)
         end if
         rest = rest - part
      end do
      value = high
      done = .not. abs((high + low*(1 + doubt)) - high) > 0.0_wp
   end subroutine scale

   pure subroutine divide(divisor, high, low)
      real(wp), intent(in) :: divisor
      real(wp), intent(inout) :: high, low
      real(wp) :: quotient, product, rest
      quotient = high/divisor
      call multiply(quotient, 0.0_wp, divisor, 0.0_wp, product, rest)
      rest = (((high - product) - rest) + low)/divisor
      high = quotient + rest
      low = rest - (high - quotient)
   end subroutine divide

end module nutate_quick_number
