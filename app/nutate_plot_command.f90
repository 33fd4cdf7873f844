!> `nutate plot`: draws a history, or the energy residual of a run.
module nutate_plot_command
   use nutate_cli, only: command_t
   use nutate_console, only: say_error, EXIT_INPUT, EXIT_OUTPUT, EXIT_SUCCESS
   use nutate_decimal, only: rounded_text
   use nutate_gnuplot, only: gnuplot_is_here, is_picture, picture_t
   use nutate_history_plot, only: draw_history, name_length, read_history, read_names, recorded_t
   use nutate_kinds, only: pi, wp
   use nutate_outputs, only: outputs_t, picture_kind
   use nutate_plot_panels, only: columns_named, known_columns
   use nutate_printable, only: printable_path, quoted
   use nutate_spelling, only: nearest_name, split_list
   use nutate_status, only: status_t
   implicit none
   private

   public :: open_picture, report_file, plot_command, draw_file

   !> Columns of the angular velocity in body axes.
   character(len=name_length), parameter :: rates(6) = [character(len=name_length) :: &
      'omega1', 'omega2', 'omega3', 'omega1_deg', 'omega2_deg', 'omega3_deg']

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

   !> Draws a history that was written before.
   subroutine plot_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(outputs_t) :: files
      type(picture_t) :: picture
      character(len=:), allocatable :: name, title, columns

      name = without_csv(command%scene)//'.svg'
      if (allocated(command%output)) name = command%output
      exit_code = EXIT_SUCCESS
      if (.not. is_picture(name)) then
         call say_error('nutate: '//printable_path(name)// &
                        ' is not a picture file (expected the name of a file in .svg, .png or .pdf)')
         exit_code = EXIT_INPUT
         return
      end if
      call files%read_file(command%scene, 'the history itself')
      call files%add(name, picture_kind(name))
      call files%report(exit_code)
      if (exit_code == EXIT_SUCCESS) call open_picture(name, picture, exit_code)
      title = ''
      if (allocated(command%title)) title = command%title
      columns = ''
      if (allocated(command%columns)) columns = command%columns
      if (exit_code == EXIT_SUCCESS) call draw_file(command%scene, name, title, columns, picture, exit_code)
      if (exit_code == EXIT_SUCCESS) call note_sparse_rows(command%scene)
   end subroutine plot_command

   !> Notes rows between which the body rotates by half a revolution or more, if the history has the angular velocity:
   !> curves through such rows show false oscillations.
   subroutine note_sparse_rows(file)
      character(len=*), intent(in) :: file
      type(recorded_t) :: history
      character(len=name_length), allocatable :: names(:)
      character(len=:), allocatable :: problem
      real(wp) :: unit, h, turn
      integer :: i
      call read_names(file, names, problem)
      if (problem /= '') return
      names = pack(names, [(any(names(i) == rates), i=1, size(names))])
      if (size(names) /= 3) return
      unit = merge(pi/180, 1.0_wp, index(names(1), '_deg') > 0)
      call read_history(file, names, history, problem)
      if (problem /= '') return
      do i = 1, size(history%values, 1) - 1
         h = abs(history%values(i + 1, 1) - history%values(i, 1))
         turn = unit*h*max(norm2(history%values(i, 2:)), norm2(history%values(i + 1, 2:)))
         if (.not. turn >= pi) cycle
         call say_error('nutate: note: '//printable_path(file)//': the body turns by half a revolution or more '// &
                        'between rows, from t = '//rounded_text(history%values(i, 1))//' s on: curves show other '// &
                        'oscillations (expected rows less than '//rounded_text(pi*h/turn, 3)//' s apart)')
         return
      end do
   end subroutine note_sparse_rows

   !> Returns a name without `.csv` at its end.
   pure function without_csv(name) result(stem)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: stem
      stem = name
      if (len(name) < 5) return
      if (name(len(name) - 3:) == '.csv') stem = name(:len(name) - 4)
   end function without_csv

   !> Reads a history and draws it.
   subroutine draw_file(file, name, title, columns, picture, exit_code)
      !> Paths of the history and of the picture, and the title; a blank title is the name of the history.
      character(len=*), intent(in) :: file, name, title
      !> Names of columns and of sets, comma separated; empty: all columns of nutate.
      character(len=*), intent(in) :: columns
      !> Picture, open; complete or discarded on return.
      type(picture_t), intent(inout) :: picture
      !> Exit code, changed on failure.
      integer, intent(inout) :: exit_code
      type(recorded_t) :: history
      type(status_t) :: status
      character(len=name_length), allocatable :: names(:), wanted(:)
      character(len=:), allocatable :: problem
      call read_names(file, names, problem)
      if (problem == '') call choose_columns(names, columns, wanted, problem)
      if (problem == '') then
         call read_history(file, wanted, history, problem)
      else if (allocated(names)) then
         problem = printable_path(file)//problem
      end if
      if (problem == '') then
         if (size(history%values, 1) < 2) problem = printable_path(file)//': no rows to plot'
      end if
      if (problem /= '') then
         call picture%discard()
         call say_error('nutate: '//problem)
         exit_code = EXIT_INPUT
         return
      end if
      if (title == '') then
         call draw_history(picture, printable_path(file), history, status)
      else
         call draw_history(picture, title, history, status)
      end if
      call report_file(name, status, exit_code)
   end subroutine draw_file

   !> Chooses the columns that are drawn.
   pure subroutine choose_columns(names, columns, wanted, problem)
      !> Names of all columns of the history, `t` first.
      character(len=*), intent(in) :: names(:)
      !> Names of columns and of sets, comma separated; empty: all columns of nutate.
      character(len=*), intent(in) :: columns
      character(len=name_length), allocatable, intent(out) :: wanted(:)
      !> Error message, to be written after the name of the file; empty on success.
      character(len=:), allocatable, intent(inout) :: problem
      logical :: chosen(size(names)), found(size(names))
      integer :: i
      chosen = .false.
      if (columns == '') then
         chosen = known_columns(names)
         if (.not. any(chosen)) problem = ': none of its columns is a column of nutate (expected --columns NAME,...)'
      else
         associate (words => split_list(columns))
            do i = 1, size(words)
               found = columns_named(trim(adjustl(words(i))), names)
               if (.not. any(found)) problem = ': there is no column '//quoted(trim(adjustl(words(i))))// &
                                               hint(names(2:), nearest_name(trim(adjustl(words(i))), names))
               if (problem /= '') exit
               chosen = chosen .or. found
            end do
         end associate
      end if
      wanted = pack(names, chosen)
   end subroutine choose_columns

   !> Returns what to write in the place of an unknown name: the columns of the history, and the nearest one.
   pure function hint(names, nearest) result(text)
      character(len=*), intent(in) :: names(:)
      !> Nearest known name; blank if there is none.
      character(len=*), intent(in) :: nearest
      character(len=:), allocatable :: text
      integer :: i
      text = ' (expected '
      do i = 1, size(names)
         if (i > 1) text = text//', '
         text = text//trim(names(i))
      end do
      if (nearest /= '') text = text//'; nearest: '//trim(nearest)
      text = text//')'
   end function hint

end module nutate_plot_command
