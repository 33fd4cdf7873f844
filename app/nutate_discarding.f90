!> Discards output files.
module nutate_discarding
   use nutate_files, only: output_file_t
   use nutate_status, only: status_t
   implicit none
   private

   public :: discard_file

contains

   !> Closes an output file and removes its partial file.
   subroutine discard_file(file)
      type(output_file_t), intent(inout) :: file
      type(status_t) :: status
      integer :: unit, iostat
      call file%abandon(status)
      if (.not. allocated(file%partial)) return
      open (newunit=unit, file=file%partial, status='old', iostat=iostat)
      if (iostat /= 0) return
      close (unit, status='delete', iostat=iostat)
      if (iostat /= 0) file%partial = ''
   end subroutine discard_file

end module nutate_discarding
