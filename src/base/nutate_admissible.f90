!> Ranges of the numbers of a key, as a table: sign, size, and whether they may all be zero; and the words for numbers
!> out of range.
module nutate_admissible
   use nutate_finite, only: is_finite, is_nan
   use nutate_kinds, only: wp
   use nutate_limits, only: greatest_length, greatest_number, greatest_step, least_length, least_number, least_size, &
      least_step, in_words
   implicit none
   private

   public :: ANY_VALUE, POSITIVE, NON_NEGATIVE, POSITIVE_OR_INFINITE, NOT_ZERO, ANY_DIRECTION, SHAPE_LENGTH, &
      TIME_STEP, FRACTION
   public :: admits, fault_of, fault_together, kind_in_words

   !> Any number.
   integer, parameter :: ANY_VALUE = 1
   !> Each > 0.
   integer, parameter :: POSITIVE = 2
   !> Each >= 0.
   integer, parameter :: NON_NEGATIVE = 3
   !> Each > 0; `Infinity` is admissible.
   integer, parameter :: POSITIVE_OR_INFINITE = 4
   !> Not zero.
   integer, parameter :: NOT_ZERO = 5
   !> Several, of which one at least is long enough to have a direction.
   integer, parameter :: ANY_DIRECTION = 6
   !> Each > 0, a length that a body can have.
   integer, parameter :: SHAPE_LENGTH = 7
   !> Not zero, a time that a step can have.
   integer, parameter :: TIME_STEP = 8
   !> Each > 0 and < 1.
   integer, parameter :: FRACTION = 9

   !> Range of the numbers of a key.
   type, private :: range_t
      !> Words that messages add to `a number`.
      character(len=20) :: words = ''
      !> Least and greatest size of a number that is not zero.
      real(wp) :: least = least_number, greatest = greatest_number
      logical :: negative = .false., zero = .false., infinite = .false.
      !> Least size of the largest of the numbers.
      real(wp) :: least_longest = 0.0_wp
   end type range_t

   type(range_t), parameter :: ranges(9) = [ &
      range_t('', negative=.true., zero=.true.), &
      range_t(' > 0', least=least_size), &
      range_t(' >= 0', zero=.true.), &
      range_t(' > 0, or Infinity', least=least_size, infinite=.true.), &
      range_t(', not zero', least=least_size, negative=.true., zero=.true., least_longest=least_size), &
      range_t(', not zero', negative=.true., zero=.true., least_longest=least_size), &
      range_t(' > 0', least=least_length, greatest=greatest_length), &
      range_t(', not zero', least=least_step, greatest=greatest_step, negative=.true., zero=.true., &
              least_longest=least_step), &
      range_t(' > 0 and < 1', least=least_size, greatest=1 - epsilon(1.0_wp)/2)]

   !> Faults of one number.
   integer, parameter :: good = 0, no_number = 1, wrong_sign = 2, too_large = 3, too_small = 4
   character(len=20), parameter :: faults(4) = [character(len=20) :: &
      'is not a number', 'is out of range', 'is too large', 'is too close to zero']

contains

   !> Returns true if all numbers are in a range.
   pure logical function admits(range, numbers)
      !> `ANY_VALUE`, ...
      integer, intent(in) :: range
      real(wp), intent(in) :: numbers(:)
      admits = all(fault_in(range, numbers) == good)
      if (admits) admits = .not. is_short(range, numbers)
   end function admits

   !> Returns the fault of one number in words: `is too large (expected 1e-50 to 1e50 in size`, for the caller to
   !> complete; empty if there is none.
   pure function fault_of(range, number, expected) result(words)
      integer, intent(in) :: range
      real(wp), intent(in) :: number
      !> Numbers that the key expects, in words.
      character(len=*), intent(in) :: expected
      character(len=:), allocatable :: words
      integer :: fault
      fault = fault_in(range, number)
      select case (fault)
      case (good)
         words = ''
      case (too_large, too_small)
         words = trim(faults(fault))//' (expected '//sizes_in_words(ranges(range))
      case default
         words = trim(faults(fault))//' (expected '//expected
      end select
   end function fault_of

   !> Returns the fault of all numbers together, each of which is admissible, as `fault_of` does.
   pure function fault_together(range, numbers, expected) result(words)
      integer, intent(in) :: range
      real(wp), intent(in) :: numbers(:)
      character(len=*), intent(in) :: expected
      character(len=:), allocatable :: words
      words = ''
      if (.not. is_short(range, numbers)) return
      if (any(abs(numbers) > 0.0_wp)) then
         words = 'is too short (expected a component of '//sizes_in_words( &
                 range_t(least=ranges(range)%least_longest, negative=.true.))
      else
         words = 'is zero (expected '//expected
      end if
   end function fault_together

   !> Returns the words that a range adds to `a number`.
   pure function kind_in_words(range) result(words)
      integer, intent(in) :: range
      character(len=:), allocatable :: words
      words = trim(ranges(range)%words)
   end function kind_in_words

   !> Returns the fault of one number: `good`, `no_number`, ...
   elemental integer function fault_in(range, number)
      integer, intent(in) :: range
      real(wp), intent(in) :: number
      type(range_t) :: r
      r = ranges(range)
      fault_in = good
      if (is_nan(number)) then
         fault_in = no_number
      else if (.not. is_finite(number)) then
         if (.not. (r%infinite .and. number > 0.0_wp)) fault_in = wrong_sign
      else if (number < 0.0_wp .and. .not. r%negative) then
         fault_in = wrong_sign
      else if (abs(number) <= 0.0_wp) then
         if (.not. r%zero) fault_in = wrong_sign
      else if (abs(number) > r%greatest) then
         fault_in = too_large
      else if (abs(number) < r%least) then
         fault_in = too_small
      end if
   end function fault_in

   !> Returns true if none of several numbers is as large as one of them must be.
   pure logical function is_short(range, numbers)
      integer, intent(in) :: range
      real(wp), intent(in) :: numbers(:)
      is_short = .not. any(abs(numbers) >= ranges(range)%least_longest)
   end function is_short

   !> Returns the sizes of a range in words: `1e-50 to 1e50 in size`.
   pure function sizes_in_words(range) result(words)
      type(range_t), intent(in) :: range
      character(len=:), allocatable :: words
      if (range%greatest < 1.0_wp) then
         words = in_words(range%least)//' to below 1'
      else
         words = in_words(range%least, range%greatest)
      end if
      if (range%negative) words = words//' in size'
   end function sizes_in_words

end module nutate_admissible
