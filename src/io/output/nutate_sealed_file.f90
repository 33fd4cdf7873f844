!> Files that are either whole or rejected: the content stands between a signature with its length and a checksum of it
!> all, and a new file replaces an old one at once.
module nutate_sealed_file
   use nutate_checksum, only: checksum
   use nutate_files, only: replace_file
   use nutate_kinds, only: long
   use nutate_status, only: status_t
   use nutate_text_file, only: read_text_file
   implicit none
   private

   public :: bytes_of, write_sealed, read_sealed

   !> Number of bytes of a length, and of a checksum.
   integer, parameter :: number_bytes = storage_size(1_long)/8

contains

   !> Writes a file. Errors: `NUTATE_IO`; the file that was there stays then.
   subroutine write_sealed(path, signature, content, status)
      character(len=*), intent(in) :: path
      !> First bytes of the file: its kind and, after a blank, the number of its format.
      character(len=*), intent(in) :: signature
      character(len=*), intent(in) :: content
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: bytes
      bytes = signature//bytes_of(len(content, long))//content
      call replace_file(path, bytes//bytes_of(checksum(bytes)), status)
   end subroutine write_sealed

   !> Reads a file that `write_sealed` wrote.
   subroutine read_sealed(path, signature, content, problem)
      character(len=*), intent(in) :: path, signature
      character(len=:), allocatable, intent(out) :: content
      !> Message that says what is wrong with the file; empty on success.
      character(len=:), allocatable, intent(out) :: problem
      character(len=:), allocatable :: bytes
      integer(long) :: length, first
      content = ''
      call read_text_file(path, bytes, problem)
      if (problem /= '') then
         problem = 'cannot be read ('//problem//')'
         return
      end if
      first = len(signature) + number_bytes + 1
      if (len(bytes) < len(signature) .or. index(bytes, kind_of(signature)) /= 1) then
         problem = 'is not a checkpoint'
      else if (index(bytes, signature) /= 1) then
         problem = 'was written by another version of nutate'
      else if (len(bytes) < first + number_bytes - 1) then
         problem = 'is damaged: it has been cut short'
      else
         length = number_of(bytes(len(signature) + 1:first - 1))
         if (length /= len(bytes, long) - (first + number_bytes - 1)) then
            problem = 'is damaged: its length differs from that in its header'
         else if (number_of(bytes(first + length:)) /= checksum(bytes(1:first + length - 1))) then
            problem = 'is damaged: its checksum is wrong'
         else
            content = bytes(first:first + length - 1)
         end if
      end if
   end subroutine read_sealed

   !> Returns a signature without the number of the format.
   pure function kind_of(signature) result(kind)
      character(len=*), intent(in) :: signature
      character(len=:), allocatable :: kind
      kind = signature(1:index(signature, ' ', back=.true.))
   end function kind_of

   !> Returns the bytes of a number, as it is in memory.
   pure function bytes_of(number) result(bytes)
      integer(long), intent(in) :: number
      character(len=number_bytes) :: bytes
      bytes = transfer(number, bytes)
   end function bytes_of

   pure integer(long) function number_of(bytes)
      character(len=number_bytes), intent(in) :: bytes
      number_of = transfer(bytes, number_of)
   end function number_of

end module nutate_sealed_file
