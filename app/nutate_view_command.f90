!> `nutate view SCENE`: has Python run a scene and write a web page that shows it.
module nutate_view_command
   use nutate_cli, only: command_t
   use nutate_console, only: say_error, EXIT_INPUT, EXIT_OUTPUT, EXIT_RUN, EXIT_SUCCESS
   use nutate_gnuplot, only: shell_quoted
   use nutate_outputs, only: outputs_t, PAGE
   use nutate_printable, only: printable_path
   implicit none
   private

   public :: view_command

contains

   !> Starts the module `nutate.view` of Python, which reports errors in a scene or a file.
   subroutine view_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      character(len=:), allocatable :: python, line, change
      integer :: i, command_status

      exit_code = EXIT_OUTPUT
      call find_python(python)
      if (python == '') then
         call say_error('nutate: cannot show '//printable_path(command%scene)//': no python3 beside the program or '// &
                        'on PATH has the module nutate (expected python3 -m pip install . in a checkout)')
         return
      end if
      call check_names(command, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      line = python//' -m nutate.view --output='//shell_quoted(page_name(command))
      if (allocated(command%begin)) line = line//' --from='//shell_quoted(command%begin)
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
         call say_error('nutate: python3 failed to show '//printable_path(command%scene), exit_code, EXIT_OUTPUT)
      end if
   end subroutine view_command

   !> Returns the path of the page.
   pure function page_name(command) result(name)
      type(command_t), intent(in) :: command
      character(len=:), allocatable :: name
      integer :: dot
      name = command%scene(index(command%scene, '/', back=.true.) + 1:)
      dot = index(name, '.', back=.true.)
      if (dot > 1) name = name(:dot - 1)
      name = name//'.html'
      if (allocated(command%output)) name = command%output
   end function page_name

   !> Rejects file names that would overwrite an input, a file of another kind or each other.
   subroutine check_names(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(outputs_t) :: files
      exit_code = EXIT_SUCCESS
      call files%read_file(command%scene, 'the scene itself')
      call files%add(page_name(command), PAGE)
      call files%report(exit_code)
   end subroutine check_names

   !> Finds a Python that has the module: beside the program, as in a virtual environment, on PATH, or on PATH with the
   !> module that was installed with the program.
   subroutine find_python(python)
      !> Shell words that start Python; empty if no Python has the module.
      character(len=:), allocatable, intent(out) :: python
      ! The shell is a child of the program. Without /proc only PATH is searched.
      character(len=*), parameter :: folder = '"$(dirname "$(readlink -f /proc/$PPID/exe)")'
      character(len=*), parameter :: module = 'PYTHONPATH='//folder// &
                                              '/../share/nutate/python${PYTHONPATH:+:$PYTHONPATH}" '
      integer :: i, exit_status, command_status
      do i = 1, 3
         if (i == 1) python = folder//'/python3"'
         if (i == 2) python = 'python3'
         if (i == 3) python = module//'python3'
         call execute_command_line(python//' -c "import nutate" >/dev/null 2>&1', exitstat=exit_status, &
                                   cmdstat=command_status)
         if (exit_status == 0 .and. command_status == 0) return
      end do
      python = ''
   end subroutine find_python

end module nutate_view_command
