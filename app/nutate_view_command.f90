!> `nutate view SCENE`: has Python run a scene and write a web page that shows it.
module nutate_view_command
   use nutate_cli, only: command_t
   use nutate_console, only: say_error, EXIT_INPUT, EXIT_OUTPUT, EXIT_RUN, EXIT_SUCCESS
   use nutate_files, only: same_file
   use nutate_gnuplot, only: shell_quoted
   use nutate_printable, only: printable_path
   implicit none
   private

   public :: view_command

contains

   !> Starts `python3 -m nutate.view`, which says itself what is wrong with a scene or a file.
   subroutine view_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      character(len=:), allocatable :: line, change
      integer :: i, command_status

      exit_code = EXIT_OUTPUT
      if (.not. python_is_ready()) then
         call say_error('nutate: cannot show '//printable_path(command%scene)// &
                        ': python3 has not both nutate and plotly '// &
                        '(expected python3 -m pip install ".[view]" in a checkout)')
         return
      end if
      line = 'python3 -m nutate.view'
      if (allocated(command%output)) then
         if (same_file(command%output, command%scene)) then
            call say_error('nutate: '//printable_path(command%output)// &
                           ' is the scene itself and will not be written over')
            exit_code = EXIT_INPUT
            return
         end if
         line = line//' --output='//shell_quoted(command%output)
      end if
      do i = 1, size(command%overrides)
         change = trim(command%overrides(i))
         if (index(change, '-') == 1) then
            line = line//' --unset='//shell_quoted(change(2:))
         else
            line = line//' --set='//shell_quoted(change)
         end if
      end do
      call execute_command_line(line//' -- '//shell_quoted(command%scene), exitstat=exit_code, cmdstat=command_status)
      if (command_status /= 0) exit_code = EXIT_OUTPUT
      if (all(exit_code /= [EXIT_SUCCESS, EXIT_INPUT, EXIT_RUN, EXIT_OUTPUT])) then
         call say_error('nutate: python3 failed to show '//printable_path(command%scene))
         exit_code = EXIT_OUTPUT
      end if
   end subroutine view_command

   !> True if Python can be started and has what it takes.
   logical function python_is_ready()
      integer :: exit_status, command_status
      call execute_command_line('python3 -c "import nutate, plotly" >/dev/null 2>&1', exitstat=exit_status, &
                                cmdstat=command_status)
      python_is_ready = exit_status == 0 .and. command_status == 0
   end function python_is_ready

end module nutate_view_command
