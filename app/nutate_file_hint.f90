!> What to try in the place of a file that is not there.
module nutate_file_hint
   use nutate_printable, only: printable_path
   implicit none
   private

   public :: did_you_mean

contains

   !> `did you mean FILE.nml?` where a file is not there and the one with the ending is; else empty.
   function did_you_mean(path, ending) result(text)
      character(len=*), intent(in) :: path
      !> With its dot.
      character(len=*), intent(in) :: ending
      character(len=:), allocatable :: text
      logical :: exists
      text = ''
      inquire (file=path, exist=exists)
      if (path == '' .or. exists) return
      inquire (file=path//ending, exist=exists)
      if (exists) text = 'did you mean '//printable_path(path//ending)//'?'
   end function did_you_mean

end module nutate_file_hint
