!> `nutate plot HISTORY.csv`: draws a history; so does `nutate run SCENE --plot PICTURE`.
module nutate_plot_command
   use nutate_cli, only: command_t
   use nutate_console, only: say_error, EXIT_INPUT, EXIT_SUCCESS
   use nutate_gnuplot, only: picture_t, is_picture
   use nutate_history_plot, only: can_draw, draw_history, drawn_columns
   use nutate_history_reading, only: recorded_t, read_history
   use nutate_outputs, only: outputs_t, picture_kind
   use nutate_picture_opening, only: open_picture, report_file
   use nutate_printable, only: printable_path
   use nutate_status, only: status_t
   implicit none
   private

   public :: plot_command, draw_file

contains

   !> Draws a history that was written before.
   subroutine plot_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(outputs_t) :: files
      type(picture_t) :: picture
      character(len=:), allocatable :: name

      name = without_csv(command%scene)//'.svg'
      if (allocated(command%output)) name = command%output
      exit_code = EXIT_SUCCESS
      if (.not. is_picture(name)) then
         call say_error('nutate: '//printable_path(name)// &
                        ' is no picture (expected the name of a file in .svg or .png)')
         exit_code = EXIT_INPUT
         return
      end if
      call files%read_file(command%scene, 'the history itself')
      call files%add(name, picture_kind(name))
      call files%report(exit_code)
      if (exit_code == EXIT_SUCCESS) call open_picture(name, picture, exit_code)
      if (exit_code == EXIT_SUCCESS) call draw_file(command%scene, name, picture, exit_code)
   end subroutine plot_command

   !> A name without `.csv` at its end.
   pure function without_csv(name) result(stem)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: stem
      stem = name
      if (len(name) < 5) return
      if (name(len(name) - 3:) == '.csv') stem = name(:len(name) - 4)
   end function without_csv

   !> Reads a history and draws it.
   subroutine draw_file(file, name, picture, exit_code)
      !> The history, and the picture.
      character(len=*), intent(in) :: file, name
      !> Open; complete or given up on return.
      type(picture_t), intent(inout) :: picture
      !> Changed on failure.
      integer, intent(inout) :: exit_code
      type(recorded_t) :: history
      type(status_t) :: status
      character(len=:), allocatable :: problem
      call read_history(file, drawn_columns(), history, problem)
      if (problem == '') then
         if (size(history%values, 1) < 2) then
            problem = printable_path(file)//': there are no rows to draw'
         else if (.not. can_draw(history)) then
            problem = printable_path(file)//': none of its columns is drawn (expected omega1,omega2,omega3 or '// &
                      'others, see nutate help plot)'
         end if
      end if
      if (problem /= '') then
         call picture%discard()
         call say_error('nutate: '//problem)
         exit_code = EXIT_INPUT
         return
      end if
      call draw_history(picture, printable_path(file), history, status)
      call report_file(name, status, exit_code)
   end subroutine draw_file

end module nutate_plot_command
