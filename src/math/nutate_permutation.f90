!> Pseudo-random permutations of 1 .. n that map one position at a time, in any order: a Feistel network of Philox over
!> the next power of four, repeated until the result lies in the range.
module nutate_permutation
   use nutate_kinds, only: long
   use nutate_philox, only: philox4x32, PERMUTATION
   implicit none
   private

   public :: permuted

   !> Rounds of the network.
   integer, parameter :: rounds = 6
   integer(long), parameter :: word = int(z'FFFFFFFF', long)

contains

   !> Returns the position that a position is mapped to, 1 to n.
   pure integer(long) function permuted(place, n, seed, which)
      !> Position, 1 to n.
      integer(long), intent(in) :: place
      !> Number of positions, at most 2**62.
      integer(long), intent(in) :: n
      !> Key, 0 or more.
      integer(long), intent(in) :: seed
      !> Index of the permutation of this key, 0 or more.
      integer, intent(in) :: which
      integer :: bits
      bits = 1
      do while (ishft(1_long, 2*bits) < n)
         bits = bits + 1
      end do
      permuted = place - 1
      do
         permuted = shuffled(permuted, bits, seed, which)
         if (permuted < n) exit
      end do
      permuted = permuted + 1
   end function permuted

   !> Applies the network once: a permutation of 0 .. 4**bits - 1.
   pure integer(long) function shuffled(place, bits, seed, which)
      integer(long), intent(in) :: place
      !> Number of bits of each half.
      integer, intent(in) :: bits
      integer(long), intent(in) :: seed
      integer, intent(in) :: which
      integer(long) :: left, right, mask, words(4)
      integer :: i
      mask = ishft(1_long, bits) - 1
      left = ishft(place, -bits)
      right = iand(place, mask)
      do i = 1, rounds
         words = philox4x32([right, int(i, long), int(which, long), PERMUTATION], &
                            [iand(seed, word), ishft(seed, -32)])
         words(2) = iand(ieor(left, words(1)), mask)
         left = right
         right = words(2)
      end do
      shuffled = ior(ishft(left, bits), right)
   end function shuffled

end module nutate_permutation
