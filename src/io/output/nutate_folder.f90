!> Names of the files in a folder.
module nutate_folder
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
   implicit none
   private

   public :: files_between

   interface
      !> Lists the names in a folder; see `nutate_folder.c`.
      integer(c_int) function folder_names(folder, prefix, suffix, names, size, used) &
         bind(c, name='nutate_folder_names')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: folder(*), prefix(*), suffix(*)
         character(kind=c_char), intent(out) :: names(*)
         integer(c_int), intent(in), value :: size
         integer(c_int), intent(out) :: used
      end function folder_names
   end interface

contains

   !> Returns the parts between a beginning and an ending in the names of files that have both; shape (files).
   function files_between(beginning, ending) result(middles)
      !> Path: folder, and beginning of the names.
      character(len=*), intent(in) :: beginning
      character(len=*), intent(in) :: ending
      character(len=:), allocatable :: middles(:)
      character(len=:), allocatable :: names, folder, prefix
      integer(c_int) :: used, again
      integer :: slash, i, n, first, last
      slash = index(beginning, '/', back=.true.)
      folder = './'
      if (slash > 0) folder = beginning(:slash)
      prefix = beginning(slash + 1:)
      names = ' '
      allocate (character(len=0) :: middles(0))
      if (folder_names(folder//c_null_char, prefix//c_null_char, ending//c_null_char, names, 0_c_int, used) /= 0) return
      if (used == 0) return
      deallocate (names)
      allocate (character(len=used) :: names)
      if (folder_names(folder//c_null_char, prefix//c_null_char, ending//c_null_char, names, used, again) /= 0) return
      ! Another program may have made or removed files in between.
      n = count([(names(i:i) == '/', i=1, min(used, again))])
      deallocate (middles)
      allocate (character(len=used) :: middles(n))
      first = 1
      do i = 1, n
         last = first + index(names(first:), '/') - 2
         middles(i) = names(first + len(prefix):last - len(ending))
         first = last + 2
      end do
   end function files_between

end module nutate_folder
