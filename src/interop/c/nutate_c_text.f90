!> Strings from and to C.
!>
!> Callers of functions whose results are strings hold the lock of `nutate_text_lock`; steps and runs do not.
module nutate_c_text
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_null_char, c_ptr, c_size_t
   use nutate_status, only: NUTATE_BAD_ARGUMENT, NUTATE_OK, NUTATE_TRUNCATED
   use nutate_text_lock, only: lock_texts, unlock_texts
   implicit none
   private

   public :: copy_text, text_to_c, message_to_c, nth_name, lock_texts, unlock_texts

   interface
      pure integer(c_size_t) function strlen(text) bind(C, name='strlen')
         import :: c_ptr, c_size_t
         type(c_ptr), intent(in), value :: text
      end function strlen
   end interface

contains

   !> Copies a string of C; the result is empty if the address is null.
   subroutine copy_text(address, text)
      !> Address of the string, which ends with NUL.
      type(c_ptr), intent(in) :: address
      character(len=:), allocatable, intent(out) :: text
      character(kind=c_char), pointer :: bytes(:)
      integer :: i, length
      text = ''
      if (.not. c_associated(address)) return
      length = int(strlen(address))
      call c_f_pointer(address, bytes, [length])
      deallocate (text)
      allocate (character(len=length) :: text)
      do i = 1, length
         text(i:i) = bytes(i)
      end do
   end subroutine copy_text

   !> Writes a string into a buffer of C, cut to its size and ended by NUL. Code: `NUTATE_OK` or `NUTATE_TRUNCATED`;
   !> `NUTATE_BAD_ARGUMENT` for a buffer that is null or has no room for the NUL.
   integer(c_int) function text_to_c(text, buffer, size) result(code)
      character(len=*), intent(in) :: text
      type(c_ptr), intent(in) :: buffer
      !> Size of the buffer, bytes.
      integer(c_size_t), intent(in) :: size
      character(kind=c_char), pointer :: bytes(:)
      integer :: i, length
      code = NUTATE_BAD_ARGUMENT
      if (.not. c_associated(buffer) .or. size < 1) return
      length = int(min(int(len(text), c_size_t), size - 1))
      call c_f_pointer(buffer, bytes, [length + 1])
      do i = 1, length
         bytes(i) = text(i:i)
      end do
      bytes(length + 1) = c_null_char
      code = NUTATE_OK
      if (length < len(text)) code = NUTATE_TRUNCATED
   end function text_to_c

   !> Writes a message into a buffer, if there is one.
   subroutine message_to_c(text, buffer, size)
      character(len=*), intent(in) :: text
      !> Address of the buffer, or null.
      type(c_ptr), intent(in) :: buffer
      integer(c_size_t), intent(in) :: size
      integer(c_int) :: ignored
      ignored = text_to_c(trim(text), buffer, size)
   end subroutine message_to_c

   !> Returns one of the names of a comma separated list; empty beyond its end.
   pure function nth_name(list, n) result(name)
      character(len=*), intent(in) :: list
      !> Number of the name, from 1.
      integer, intent(in) :: n
      character(len=:), allocatable :: name
      integer :: first, comma, i
      first = 1
      do i = 1, n - 1
         comma = index(list(first:), ',')
         if (comma == 0) then
            name = ''
            return
         end if
         first = first + comma
      end do
      comma = index(list(first:), ',')
      if (comma == 0) comma = len(list) - first + 2
      name = trim(adjustl(list(first:first + comma - 2)))
   end function nth_name

end module nutate_c_text
