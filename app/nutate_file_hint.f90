!> Suggests a file instead of one that does not exist.
module nutate_file_hint
   use nutate_printable, only: printable_path
   implicit none
   private

   public :: did_you_mean

contains

   !> Returns `did you mean FILE.nml?` if a file does not exist but the one with the ending does; else empty.
   function did_you_mean(path, ending) result(text)
      character(len=*), intent(in) :: path
      !> Ending of file names, with its dot.
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
