!> A checksum that finds every change of up to 64 neighbouring bits, and others but for one in 2**64.
module nutate_checksum
   use, intrinsic :: iso_fortran_env, only: int64
   implicit none
   private

   public :: checksum

   !> The generator of ECMA-182, lowest power in the highest bit.
   integer(int64), parameter :: generator = ior(ishft(int(z'C96C5795', int64), 32), int(z'D7870F42', int64))

contains

   !> CRC-64/XZ of some bytes. Only bits are moved, so that nothing can overflow.
   pure integer(int64) function checksum(bytes)
      character(len=*), intent(in) :: bytes
      integer(int64) :: i
      integer :: k
      checksum = not(0_int64)
      do i = 1, len(bytes, int64)
         checksum = ieor(checksum, int(ichar(bytes(i:i)), int64))
         do k = 1, 8
            if (btest(checksum, 0)) then
               checksum = ieor(ishft(checksum, -1), generator)
            else
               checksum = ishft(checksum, -1)
            end if
         end do
      end do
      checksum = not(checksum)
   end function checksum

end module nutate_checksum
