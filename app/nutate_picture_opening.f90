!> Claims the file of a picture, and reports a problem with a file in one line.
module nutate_picture_opening
   use nutate_console, only: say_error, EXIT_OUTPUT
   use nutate_gnuplot, only: picture_t, gnuplot_is_here
   use nutate_printable, only: printable_path
   use nutate_status, only: status_t
   implicit none
   private

   public :: open_picture, report_file

contains

   !> Claims the file of a picture, if there is a gnuplot to draw it.
   subroutine open_picture(name, picture, exit_code)
      !> Name of a picture, as `is_picture` requires.
      character(len=*), intent(in) :: name
      type(picture_t), intent(inout) :: picture
      !> Exit code, changed on failure.
      integer, intent(inout) :: exit_code
      type(status_t) :: status
      if (gnuplot_is_here()) then
         call picture%open(name, status)
         call report_file(name, status, exit_code)
      else
         call say_error('nutate: cannot draw '//printable_path(name)//': gnuplot is not installed, or not on PATH')
         exit_code = EXIT_OUTPUT
      end if
   end subroutine open_picture

   !> Reports a file that cannot be written; does nothing on success.
   subroutine report_file(name, status, exit_code)
      character(len=*), intent(in) :: name
      type(status_t), intent(in) :: status
      !> Exit code, changed on failure.
      integer, intent(inout) :: exit_code
      if (status%ok()) return
      call say_error('nutate: cannot write '//printable_path(name)//': '//trim(status%message))
      exit_code = EXIT_OUTPUT
   end subroutine report_file

end module nutate_picture_opening
