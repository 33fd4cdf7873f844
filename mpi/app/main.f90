!> `nutate-mpi sweep SCENE`: a sweep by the processes of MPI. Rank 0 prints all messages.
program main
   use nutate_cli, only: argument_t, command_t, get_arguments, options, parse_arguments
   use nutate_console, only: page_t, say_error, show_page, EXIT_INPUT, EXIT_SIGNAL
   use nutate_contraction, only: arithmetic_in_words
   use nutate_files, only: prepare_process, STANDARD_ERROR, STANDARD_OUTPUT
   use nutate_rank_workers, only: follow, rank_workers_t
   use nutate_ranks, only: ranks_t
   use nutate_run_watcher, only: caught_signal, end_by_signal
   use nutate_spelling, only: is_listed
   use nutate_sweep_command, only: sweep_command
   use nutate_version, only: version
   implicit none
   !> Options of `nutate sweep` that are for one process.
   character(len=*), parameter :: not_here = '--member,--threads,--merge'
   type(ranks_t) :: ranks
   type(argument_t), allocatable :: arguments(:)
   type(command_t) :: command
   integer :: exit_code

   call prepare_process()
   call ranks%start()
   call get_arguments(arguments)
   call parse_arguments(arguments, command)
   if (.not. allocated(command%error)) command%error = objection_to(command)
   exit_code = 0
   if (ranks%rank == 0) then
      call lead(exit_code)
   else if (command%error == '' .and. command%verb == 'sweep') then
      call follow(ranks, command)
      if (caught_signal() /= 0) exit_code = EXIT_SIGNAL + caught_signal()
   end if
   ! If a signal ends one process, MPI ends the others.
   if (exit_code > EXIT_SIGNAL) call end_by_signal(exit_code - EXIT_SIGNAL)
   call ranks%finish()
   if (exit_code /= 0) stop exit_code, quiet=.true.

contains

   !> Executes the command; called by rank 0.
   subroutine lead(exit_code)
      integer, intent(inout) :: exit_code
      type(rank_workers_t) :: workers
      type(page_t) :: page
      if (command%error /= '') then
         call say_error('nutate-mpi: '//command%error)
         exit_code = EXIT_INPUT
         return
      end if
      select case (command%verb)
      case ('sweep')
         workers%program = 'nutate-mpi'
         workers%ranks = ranks
         call sweep_command(command, workers, exit_code)
         call workers%dismiss()
      case ('help')
         call show_page(mpi_help(), STANDARD_OUTPUT, exit_code)
      case ('version')
         call page%line('nutate-mpi '//version)
         call page%line(arithmetic_in_words()//'; '//ranks%library())
         call show_page(page, STANDARD_OUTPUT, exit_code)
      case default
         call show_page(mpi_help(), STANDARD_ERROR, exit_code)
         exit_code = EXIT_INPUT
      end select
   end subroutine lead

   !> Returns the reason why a command cannot run in several processes; blank if there is none.
   pure function objection_to(command) result(text)
      type(command_t), intent(in) :: command
      character(len=:), allocatable :: text
      text = ''
      if (all(command%verb /= [character(len=8) :: 'sweep', 'help', 'version', ''])) then
         text = 'MPI runs sweeps only (expected nutate-mpi sweep SCENE)'
      else if (command%member > 0) then
         text = '--member runs in one process (expected nutate sweep SCENE --member K)'
      else if (command%merges) then
         text = '--merge runs in one process (expected nutate sweep SCENE --merge)'
      else if (command%threads > 1) then
         text = 'each process runs one thread (expected more processes: mpirun -n N)'
      end if
   end function objection_to

   !> Returns the help page.
   function mpi_help() result(page)
      type(page_t) :: page
      integer :: i
      call page%line('nutate-mpi: run an ensemble on MPI processes; one result row per member')
      call page%line('')
      call page%line('Usage: mpirun -n N nutate-mpi sweep SCENE [options]')
      call page%line('')
      call page%line('Options')
      do i = 1, size(options)
         if (.not. is_listed('sweep', trim(options(i)%verbs)) .or. is_listed(trim(options(i)%name), not_here)) cycle
         call page%item(trim(options(i)%name)//' '//options(i)%value, options(i)%purpose)
      end do
      call page%line('')
      call page%line('The file is identical to that of nutate sweep, for any number of processes. All processes')
      call page%line('must have access to its folder. If a process is lost, MPI terminates all others; --resume')
      call page%line('continues with any number of processes, and so does nutate sweep --resume.')
      call page%line('')
      call page%line('Exit status: that of nutate sweep')
   end function mpi_help

end program main
