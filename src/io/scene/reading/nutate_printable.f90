!> Text from a file made fit for a message: printable, on one line, not too long.
module nutate_printable
   implicit none
   private

   public :: quoted, printable_path

   !> Longest piece of a file that a message repeats.
   integer, parameter :: longest = 40

contains

   !> Returns a string in single quotes: bytes that are not printable ASCII as `\xHH`, long strings cut and marked by
   !> `...`.
   pure function quoted(text) result(shown)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: shown
      shown = "'"//escaped(text(1:min(len(text), longest)), ascii_only=.true.)
      if (len(text) > longest) shown = shown//'...'
      shown = shown//"'"
   end function quoted

   !> Returns a path with its control characters as `\xHH`.
   pure function printable_path(path) result(shown)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: shown
      shown = escaped(path, ascii_only=.false.)
   end function printable_path

   pure function escaped(text, ascii_only) result(shown)
      character(len=*), intent(in) :: text
      !> Bytes beyond ASCII are escaped too.
      logical, intent(in) :: ascii_only
      character(len=:), allocatable :: shown
      character(len=4*len(text)) :: buffer
      character(len=4) :: code
      integer :: i, n, byte

      n = 0
      do i = 1, len(text)
         byte = ichar(text(i:i))
         if (byte < 32 .or. byte == 127 .or. (byte > 127 .and. ascii_only)) then
            write (code, '("\x",z2.2)') byte
            buffer(n + 1:n + 4) = code
            n = n + 4
         else
            n = n + 1
            buffer(n:n) = text(i:i)
         end if
      end do
      shown = buffer(1:n)
   end function escaped

end module nutate_printable
