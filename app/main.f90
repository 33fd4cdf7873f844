!> Command line program: parses the arguments, executes the command, and ends with its exit code.
program main
   use nutate_check_command, only: check_command
   use nutate_cli, only: argument_t, command_t, get_arguments, parse_arguments
   use nutate_contraction, only: arithmetic_in_words
   use nutate_console, only: page_t, say_error, show_page, EXIT_INPUT, EXIT_SIGNAL
   use nutate_cost_command, only: cost_command
   use nutate_export_command, only: export_command
   use nutate_fit_command, only: fit_command
   use nutate_files, only: STANDARD_ERROR, STANDARD_OUTPUT, prepare_process
   use nutate_forks, only: has_threads
   use nutate_help, only: help_page
   use nutate_linearize_command, only: linearize_command
   use nutate_plot_command, only: plot_command
   use nutate_run_command, only: run_command
   use nutate_run_watcher, only: end_by_signal
   use nutate_sweep_command, only: sweep_command
   use nutate_sweep_report, only: sweep_workers_t
   use nutate_version, only: version
   use nutate_view_command, only: view_command
   implicit none
   integer :: exit_code

   call prepare_process()
   call serve(exit_code)
   if (exit_code > EXIT_SIGNAL) call end_by_signal(exit_code - EXIT_SIGNAL)
   if (exit_code /= 0) stop exit_code, quiet=.true.

contains

   !> Executes the command that the arguments name.
   subroutine serve(exit_code)
      integer, intent(out) :: exit_code
      type(argument_t), allocatable :: arguments(:)
      type(command_t) :: command
      type(page_t) :: page
      type(sweep_workers_t) :: workers

      call get_arguments(arguments)
      call parse_arguments(arguments, command)
      if (allocated(command%error)) then
         call say_error('nutate: '//command%error, exit_code, EXIT_INPUT)
         return
      end if
      select case (command%verb)
      case ('run')
         call run_command(command, exit_code)
      case ('check')
         call check_command(command, exit_code)
      case ('cost')
         call cost_command(command, exit_code)
      case ('fit')
         call fit_command(command, exit_code)
      case ('linearize')
         call linearize_command(command, exit_code)
      case ('plot')
         call plot_command(command, exit_code)
      case ('sweep')
         call sweep_command(command, workers, exit_code)
      case ('export')
         call export_command(command, exit_code)
      case ('view')
         call view_command(command, exit_code)
      case ('help')
         call show_page(help_page(command%topic), STANDARD_OUTPUT, exit_code)
      case ('version')
         call page%line('nutate '//version)
         call page%line(arithmetic_in_words()//trim(merge('; threads   ', '; one thread', has_threads())))
         call show_page(page, STANDARD_OUTPUT, exit_code)
      case default
         call show_page(help_page(''), STANDARD_ERROR, exit_code)
         exit_code = EXIT_INPUT
      end select
   end subroutine serve

end program main
