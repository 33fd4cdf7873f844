!> Headers of NumPy files: arrays of records, all fields of 8 bytes, so that the position of each row is known
!> beforehand.
module nutate_npy
   use, intrinsic :: iso_fortran_env, only: int8
   use nutate_kinds, only: long
   use nutate_row_layout, only: row_layout_t
   use nutate_spelling, only: count_text
   implicit none
   private

   public :: npy_header, longest_header

   !> Longest header, in bytes, that NumPy reads without being told to trust the file.
   integer, parameter :: longest_header = 10000
   !> Rows begin at a multiple of this number of bytes.
   integer, parameter :: alignment = 64
   !> Digits reserved for the number of rows: headers have one length for any number of rows.
   integer, parameter :: count_digits = 12

contains

   !> Returns the bytes before the rows, in version 1.0 of the format.
   pure function npy_header(layout, rows) result(header)
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: rows
      character(len=:), allocatable :: header
      integer :: i, length
      header = "{'descr': ["
      do i = 1, layout%width()
         header = header//"('"//trim(layout%names(i))//"', '"//byte_order()// &
                  merge('i8', 'f8', layout%is_whole(i))//"'), "
      end do
      header = header//"], 'fortran_order': False, 'shape': ("//count_text(rows)//",), }"// &
               repeat(' ', count_digits - len(count_text(rows)))
      length = 10 + len(header) + 1
      length = (length + alignment - 1)/alignment*alignment
      header = header//repeat(' ', length - 11 - len(header))//achar(10)
      header = char(147)//'NUMPY'//char(1)//char(0)//char(mod(len(header), 256))//char(len(header)/256)//header
   end function npy_header

   !> Returns the byte order of this machine, `<` or `>`.
   pure character function byte_order()
      byte_order = merge('<', '>', any(transfer(1_long, [0_int8], 1) == 1_int8))
   end function byte_order

end module nutate_npy
