!> Counter-based random numbers: Philox4x32-10 of Salmon, Moraes, Dror and Shaw, Parallel random numbers: as easy as
!> 1, 2, 3 (SC'11). A number is a function of its key and its counter alone: nothing is remembered, so that any draw can
!> be made again, in any order and by any number of threads.
module nutate_philox
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: philox4x32, uniform_of, DRAW, PERMUTATION

   !> What a counter is for: the last of its words.
   integer(long), parameter :: DRAW = 0, PERMUTATION = 1

   integer, parameter :: rounds = 10
   !> 32 bits, 16 bits.
   integer(long), parameter :: word = int(z'FFFFFFFF', long), half = int(z'FFFF', long)
   !> Factors of a round, and what its keys grow by.
   integer(long), parameter :: factors(2) = [int(z'D2511F53', long), int(z'CD9E8D57', long)]
   integer(long), parameter :: steps(2) = [int(z'9E3779B9', long), int(z'BB67AE85', long)]

contains

   !> Four words of 32 random bits.
   pure function philox4x32(counter, key) result(words)
      !> Each 0 to 2**32 - 1.
      integer(long), intent(in) :: counter(4), key(2)
      integer(long) :: words(4)
      integer(long) :: k(2), high(2), low(2)
      integer :: i
      words = counter
      k = key
      do i = 1, rounds
         call multiply(factors(1), words(1), high(1), low(1))
         call multiply(factors(2), words(3), high(2), low(2))
         words = [ieor(ieor(high(2), words(2)), k(1)), low(2), ieor(ieor(high(1), words(4)), k(2)), low(1)]
         k = iand(k + steps, word)
      end do
   end function philox4x32

   !> The upper and the lower word of a product of two words, by halves: signed integers must not overflow.
   elemental subroutine multiply(a, b, high, low)
      integer(long), intent(in) :: a, b
      integer(long), intent(out) :: high, low
      integer(long) :: upper, lower
      lower = a*iand(b, half)
      upper = a*ishft(b, -16) + ishft(lower, -16)
      high = ishft(upper, -16)
      low = ior(ishft(iand(upper, half), 16), iand(lower, half))
   end subroutine multiply

   !> A number between 0 and 1, never one of them: the middle of one of 2**52 equal parts.
   pure real(wp) function uniform_of(seed, member, number)
      !> Key, 0 or more.
      integer(long), intent(in) :: seed
      !> Counter: which member, and which of its draws; 0 or more.
      integer(long), intent(in) :: member
      integer, intent(in) :: number
      integer(long) :: words(4)
      words = philox4x32([iand(member, word), ishft(member, -32), int(number, long), DRAW], &
                         [iand(seed, word), ishft(seed, -32)])
      ! 52 bits and the half of the middle fill the 53 of a number.
      uniform_of = (real(ior(ishft(words(1), 20), ishft(words(2), -12)), wp) + 0.5_wp)*2.0_wp**(-52)
   end function uniform_of

end module nutate_philox
