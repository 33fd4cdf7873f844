!> Messages of the operating system as Fortran strings.
module nutate_system_text
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
   use nutate_file_calls, only: file_error_text
   implicit none
   private

   public :: error_text, text_of

contains

   !> Returns the system's message for an error number.
   function error_text(error) result(text)
      integer, intent(in) :: error
      character(len=:), allocatable :: text
      character(kind=c_char) :: words(200)
      call file_error_text(int(error, c_int), words, size(words))
      text = text_of(words)
   end function error_text

   !> Returns the text before the terminating null.
   pure function text_of(characters) result(text)
      character(kind=c_char), intent(in) :: characters(:)
      character(len=:), allocatable :: text
      integer :: n, i
      n = findloc(characters, c_null_char, dim=1) - 1
      allocate (character(len=n) :: text)
      do i = 1, n
         text(i:i) = characters(i)
      end do
   end function text_of

end module nutate_system_text
