!> Counter-based random numbers: Philox4x32-10 of Salmon, Moraes, Dror and Shaw, Parallel random numbers: as easy as
!> 1, 2, 3 (SC'11). A number is a function of its key and its counter alone: nothing is remembered, so that any draw can
!> be made again, in any order and by any number of threads.
module nutate_philox
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: philox4x32, uniform_of, DRAW, PERMUTATION

   !> Purpose of a counter, the last of its words.
   integer(long), parameter :: DRAW = 0, PERMUTATION = 1

   integer, parameter :: rounds = 10
   !> Mask of 32 bits.
   integer(long), parameter :: word = int(z'FFFFFFFF', long)
   !> Factors of a round less 2**32, D2511F53 and CD9E8D57: a product with a word then fits into a signed integer.
   integer(long), parameter :: factor_1 = int(z'D2511F53', long) - word - 1
   integer(long), parameter :: factor_2 = int(z'CD9E8D57', long) - word - 1
   !> Increments of the two words of the key from round to round.
   integer(long), parameter :: step_1 = int(z'9E3779B9', long), step_2 = int(z'BB67AE85', long)

contains

   !> Returns four words of 32 random bits.
   pure function philox4x32(counter, key) result(words)
      !> Words of the counter and of the key, each 0 to 2**32 - 1.
      integer(long), intent(in) :: counter(4), key(2)
      integer(long) :: words(4)
      integer(long) :: k_1, k_2, product_1, product_2, high_1, high_2
      integer :: i
      words = counter
      k_1 = key(1)
      k_2 = key(2)
      do i = 1, rounds
         product_1 = factor_1*words(1)
         product_2 = factor_2*words(3)
         high_1 = shifta(product_1, 32) + words(1)
         high_2 = shifta(product_2, 32) + words(3)
         words(1) = ieor(ieor(high_2, words(2)), k_1)
         words(2) = iand(product_2, word)
         words(3) = ieor(ieor(high_1, words(4)), k_2)
         words(4) = iand(product_1, word)
         k_1 = iand(k_1 + step_1, word)
         k_2 = iand(k_2 + step_2, word)
      end do
   end function philox4x32

   !> Returns a number between 0 and 1, both excluded: the middle of one of 2**52 equal parts.
   pure real(wp) function uniform_of(seed, member, number)
      !> Key, 0 or more.
      integer(long), intent(in) :: seed
      !> Counter: index of the member, and of its draw; 0 or more.
      integer(long), intent(in) :: member
      integer, intent(in) :: number
      integer(long) :: words(4)
      words = philox4x32([iand(member, word), ishft(member, -32), int(number, long), DRAW], &
                         [iand(seed, word), ishft(seed, -32)])
      ! 52 bits, and the half that gives the middle, fill the 53 bits of a double.
      uniform_of = (real(ior(ishft(words(1), 20), ishft(words(2), -12)), wp) + 0.5_wp)*2.0_wp**(-52)
   end function uniform_of

end module nutate_philox
