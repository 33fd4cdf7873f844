!> A checksum that detects every change of up to 64 neighbouring bits, and all other changes but one in 2**64.
module nutate_checksum
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none
   private

   public :: checksum

   !> The generator of ECMA-182, lowest power in the highest bit.
   integer(int64), parameter :: generator = ior(ishft(int(z'C96C5795', int64), 32), int(z'D7870F42', int64))

contains

   !> Returns the CRC-64/XZ of some bytes. Only bits are moved, so that nothing can overflow.
   pure integer(int64) function checksum(bytes)
      character(len=*), intent(in) :: bytes
      integer(int64) :: of_byte(0:255), i
      integer :: k
      do k = 0, 255
         of_byte(k) = remainder_of(k)
      end do
      checksum = not(0_int64)
      do i = 1, len(bytes, int64)
         k = ieor(int(iand(checksum, 255_int64)), ichar(bytes(i:i)))
         checksum = ieor(ishft(checksum, -8), of_byte(k))
      end do
      checksum = not(checksum)
   end function checksum

   !> Returns the entry of the CRC table for a byte.
   pure integer(int64) function remainder_of(byte) result(sum)
      integer, intent(in) :: byte
      integer :: k
      sum = int(byte, int64)
      do k = 1, 8
         if (btest(sum, 0)) then
            sum = ieor(ishft(sum, -1), generator)
         else
            sum = ishft(sum, -1)
         end if
      end do
   end function remainder_of

end module nutate_checksum
