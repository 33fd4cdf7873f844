!> Reading of a whole file as text.
module nutate_text_file
   use, intrinsic :: iso_c_binding, only: c_null_char
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_file_calls, only: file_readable
   use nutate_system_text, only: error_text
   implicit none
   private

   public :: read_text_file

   !> Largest file that is read, bytes: no scene or table is larger.
   integer(int64), parameter :: size_limit = 1000000000_int64
   character(len=*), parameter :: too_large = 'it is larger than 1 GB'

contains

   !> Reads a file, byte by byte as it is: a regular file in one piece, a pipe until it ends.
   subroutine read_text_file(path, text, reason)
      character(len=*), intent(in) :: path
      !> The file's content.
      character(len=:), allocatable, intent(out) :: text
      !> Reason why the file cannot be read; empty on success.
      character(len=:), allocatable, intent(out) :: reason
      integer :: unit, status
      integer(int64) :: bytes
      logical :: exists
      character(len=200) :: why

      reason = ''
      text = ''
      inquire (file=path, exist=exists)
      if (path == '' .or. .not. exists) then
         reason = 'there is no such file'
         return
      end if
      status = file_readable(path//c_null_char)
      if (status /= 0) then
         reason = error_text(status)
         return
      end if
      why = ''
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', &
            iostat=status, iomsg=why)
      if (status /= 0) then
         reason = last_part(why)
         return
      end if
      inquire (unit=unit, size=bytes)
      if (bytes > size_limit) then
         reason = too_large
      else if (bytes > 0) then
         deallocate (text)
         allocate (character(len=bytes) :: text)
         read (unit, iostat=status, iomsg=why) text
         if (status /= 0) reason = last_part(why)
      else
         call read_to_end(unit, text, reason)
      end if
      close (unit)
      if (reason == '' .and. (index(text, char(255)//char(254)) == 1 .or. index(text, char(254)//char(255)) == 1)) &
         reason = 'it is in UTF-16; expected UTF-8'
   end subroutine read_text_file

   !> Reads a file without a size in advance, such as a pipe; up to a NUL, of which a device may have any number.
   subroutine read_to_end(unit, text, reason)
      integer, intent(in) :: unit
      character(len=:), allocatable, intent(inout) :: text, reason
      character(len=:), allocatable :: larger
      character(len=200) :: why
      character :: byte
      integer :: n, status

      allocate (character(len=4096) :: larger)
      call move_alloc(larger, text)
      n = 0
      do
         why = ''
         read (unit, iostat=status, iomsg=why) byte
         if (status /= 0) exit
         if (n == len(text)) then
            allocate (character(len=2*n) :: larger)
            larger(1:n) = text
            call move_alloc(larger, text)
         end if
         n = n + 1
         text(n:n) = byte
         if (n >= size_limit .or. byte == achar(0)) exit
      end do
      if (status == 0) then
         reason = too_large
         if (byte == achar(0)) reason = 'it has a NUL character'
      else if (.not. is_iostat_end(status)) then
         reason = last_part(why)
      end if
      allocate (character(len=n) :: larger)
      larger(1:n) = text(1:n)
      call move_alloc(larger, text)
   end subroutine read_to_end

   !> Returns the reason in a compiler's message, which begins with the position of the error.
   pure function last_part(why) result(reason)
      character(len=*), intent(in) :: why
      character(len=:), allocatable :: reason
      reason = trim(why(index(why, ': ', back=.true.) + 1:))
      reason = trim(adjustl(reason))
      if (reason == '') reason = 'reading failed'
   end function last_part

end module nutate_text_file
