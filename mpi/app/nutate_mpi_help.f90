!> The help page of nutate-mpi, and which options of `nutate sweep` it takes.
module nutate_mpi_help
   use nutate_cli, only: command_t, options
   use nutate_console, only: page_t
   use nutate_spelling, only: is_listed
   implicit none
   private

   public :: mpi_help, objection_to

   !> Options of `nutate sweep` that are for one process.
   character(len=*), parameter :: not_here = '--member,--threads,--merge'

contains

   !> What keeps a command from being one for several processes; blank if nothing does.
   pure function objection_to(command) result(text)
      type(command_t), intent(in) :: command
      character(len=:), allocatable :: text
      text = ''
      if (all(command%verb /= [character(len=8) :: 'sweep', 'help', 'version', ''])) then
         text = 'MPI runs sweeps only (expected nutate-mpi sweep SCENE)'
      else if (command%member > 0) then
         text = '--member is for one process (expected nutate sweep SCENE --member K)'
      else if (command%merges) then
         text = '--merge is for one process (expected nutate sweep SCENE --merge)'
      else if (command%threads > 1) then
         text = 'each process has one thread (expected more processes: mpirun -n N)'
      end if
   end function objection_to

   !> The help page.
   function mpi_help() result(page)
      type(page_t) :: page
      integer :: i
      call page%line('nutate-mpi: run the members of an ensemble by the processes of MPI, and keep a row of each')
      call page%line('')
      call page%line('Usage: mpirun -n N nutate-mpi sweep SCENE [options]')
      call page%line('')
      call page%line('Options')
      do i = 1, size(options)
         if (.not. is_listed('sweep', trim(options(i)%verbs)) .or. is_listed(trim(options(i)%name), not_here)) cycle
         call page%item(trim(options(i)%name)//' '//options(i)%value, options(i)%purpose)
      end do
      call page%line('')
      call page%line('The file is that of nutate sweep, to the last byte, for any number of processes. All of them')
      call page%line('need to see the folder where it is written. When a process is lost MPI ends all others; --resume')
      call page%line('goes on, with as many as there are then, and so does nutate sweep --resume.')
      call page%line('')
      call page%line('Exit status: that of nutate sweep')
   end function mpi_help

end module nutate_mpi_help
