!> `nutate fit`: reads a scene and its measurements, fits the free parameters, writes the files.
module nutate_fit_command
   use nutate_cli, only: command_t
   use nutate_console, only: count_text, page_t, report_file, say_error, show_page, EXIT_INPUT, EXIT_RUN, EXIT_SIGNAL, &
      EXIT_SUCCESS
   use nutate_decimal, only: exact_text
   use nutate_outputs, only: check_writable, close_file, outputs_t, picture_kind, write_whole, FITTED, RESIDUALS
   use nutate_files, only: output_file_t, STANDARD_ERROR, STANDARD_OUTPUT
   use nutate_fit, only: fit_scene, fit_t
   use nutate_fit_plan, only: ATTITUDES
   use nutate_fit_plot, only: draw_fit
   use nutate_fit_report, only: add_fit
   use nutate_fit_warning, only: misfit_text
   use nutate_gnuplot, only: picture_t
   use nutate_kinds, only: wp
   use nutate_plot_command, only: open_picture
   use nutate_printable, only: printable_path
   use nutate_run_watcher, only: caught_signal, signal_name, stop_watcher_t, watch_signals
   use nutate_scene, only: scene_t
   use nutate_scene_loading, only: load_scene
   use nutate_scene_text, only: scene_text
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: fit_command

contains

   !> Writes one line for each residual. Errors: `NUTATE_IO`.
   subroutine write_residuals(fit, name, status)
      type(fit_t), intent(in) :: fit
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      type(output_file_t) :: file
      integer :: i, k, at
      call file%open(name, status)
      if (status%ok()) call file%put_line('measurement,t,column,measured,model,residual', status)
      at = 0
      do i = 1, size(fit%problem%residuals)
         do k = 1, size(fit%problem%residuals(i)%measurement%times)
            if (status%ok()) call put_row(fit, i, k, at, file, status)
            at = at + fit%problem%residuals(i)%measurement%width()
         end do
      end do
      call close_file(file, status)
   end subroutine write_residuals

   !> Writes the residuals of a row.
   subroutine put_row(fit, i, k, before, file, status)
      type(fit_t), intent(in) :: fit
      !> Index of the measurement, and its row.
      integer, intent(in) :: i, k
      !> Number of residuals before those of the row.
      integer, intent(in) :: before
      type(output_file_t), intent(inout) :: file
      type(status_t), intent(inout) :: status
      real(wp), allocatable :: measured(:), model(:)
      character(len=:), allocatable :: line
      integer :: c
      associate (measurement => fit%problem%residuals(i)%measurement)
         associate (residuals => fit%result%residuals(before + 1:before + measurement%width()))
            if (measurement%kind == ATTITUDES) then
               ! The model value is the rotation vector from the measured attitude to that of the model.
               measured = spread(0.0_wp, 1, 3)
            else
               measured = measurement%rows(:, k)
            end if
            model = measured + measurement%sigma*residuals
            do c = 1, size(model)
               line = count_text(i)//','//exact_text(measurement%times(k))//','
               if (measurement%kind == ATTITUDES) then
                  line = line//'rotation'//achar(iachar('0') + c)
               else
                  line = line//trim(measurement%columns(c))
               end if
               call file%put_line(line//','//exact_text(measured(c))//','//exact_text(model(c))//','// &
                                  exact_text(residuals(c)), status)
               if (.not. status%ok()) return
            end do
         end associate
      end associate
   end subroutine put_row

   !> Fits a scene, shows the result, and writes the files.
   subroutine fit_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(scene_t) :: scene
      type(fit_t) :: fit
      type(stop_watcher_t), target :: watcher
      type(picture_t) :: picture
      type(status_t) :: status
      character(len=:), allocatable :: fitted, csv

      call load_scene(command, scene, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      fitted = scene%name//'.fit.nml'
      if (allocated(command%output)) fitted = command%output
      csv = scene%name//'.residuals.csv'
      if (allocated(command%csv)) csv = command%csv
      call check_names(command, scene, fitted, csv, exit_code)
      ! A signal ends the command when the files are whole or removed.
      if (exit_code == EXIT_SUCCESS) call watch_signals()
      if (exit_code == EXIT_SUCCESS) call check_writable(fitted, exit_code)
      if (exit_code == EXIT_SUCCESS) call check_writable(csv, exit_code)
      if (exit_code == EXIT_SUCCESS .and. allocated(command%plot)) call open_picture(command%plot, picture, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      scene%plan%max_steps = command%max_steps
      call fit_scene(scene, fit, status, watcher)
      if (caught_signal() /= 0) then
         call say_error('nutate: '//printable_path(scene%file)//': stopped by '//signal_name()//'; nothing was written')
         if (allocated(command%plot)) call picture%discard()
      else if (fit%best == 0) then
         call say_error('nutate: '//printable_path(scene%file)//': '//trim(status%message))
         exit_code = merge(EXIT_INPUT, EXIT_RUN, status%code == NUTATE_BAD_ARGUMENT)
         if (allocated(command%plot)) call picture%discard()
      else
         call report(command, scene, fit, status, fitted, csv, picture, exit_code)
         if (caught_signal() /= 0) &
            call say_error('nutate: '//printable_path(scene%file)//': stopped by '//signal_name())
      end if
      if (caught_signal() /= 0) exit_code = EXIT_SIGNAL + caught_signal()
   end subroutine fit_command

   !> Shows a fit, and writes the files.
   subroutine report(command, scene, fit, status, fitted, csv, picture, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      type(fit_t), intent(inout) :: fit
      !> Status of the fit.
      type(status_t), intent(in) :: status
      !> Names of the fitted scene and of the residuals.
      character(len=*), intent(in) :: fitted, csv
      type(picture_t), intent(inout) :: picture
      integer, intent(inout) :: exit_code
      if (.not. command%quiet) call show(scene, fit, csv, exit_code)
      if (.not. status%ok()) then
         call say_error('nutate: '//printable_path(scene%file)//': the fit did not converge: '//trim(status%message))
         exit_code = EXIT_RUN
      else if (fit%exceeds_noise()) then
         call say_error('nutate: '//printable_path(scene%file)//': '//misfit_text(fit))
      end if
      call write_files(command, scene, fit, fitted, csv, picture, exit_code)
   end subroutine report

   !> Rejects file names that would overwrite an input, a file of another kind or each other.
   subroutine check_names(command, scene, fitted_name, csv, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      character(len=*), intent(in) :: fitted_name, csv
      integer, intent(inout) :: exit_code
      type(outputs_t) :: files
      call files%read_scene(scene)
      call files%add(fitted_name, FITTED)
      call files%add(csv, RESIDUALS)
      if (allocated(command%plot)) call files%add(command%plot, picture_kind(command%plot))
      call files%report(exit_code)
   end subroutine check_names

   !> Shows the result on standard output, or on standard error if the residuals go to standard output.
   subroutine show(scene, fit, csv, exit_code)
      type(scene_t), intent(in) :: scene
      type(fit_t), intent(in) :: fit
      character(len=*), intent(in) :: csv
      integer, intent(out) :: exit_code
      type(page_t) :: page
      call page%line(printable_path(scene%file)//': '//scene%title)
      call add_fit(page, fit)
      call show_page(page, merge(STANDARD_ERROR, STANDARD_OUTPUT, csv == '-'), exit_code)
   end subroutine show

   !> Writes the fitted scene, the residuals, and the picture.
   subroutine write_files(command, scene, fit, fitted_name, csv, picture, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      type(fit_t), intent(inout) :: fit
      character(len=*), intent(in) :: fitted_name, csv
      type(picture_t), intent(inout) :: picture
      integer, intent(inout) :: exit_code
      type(status_t) :: status
      call write_whole('! nutate fit of '//printable_path(scene%file)//new_line('a')// &
                       scene_text(fit%problem%model%present_groups(), scene%file, fitted_name), fitted_name, exit_code)
      call write_residuals(fit, csv, status)
      call report_file(csv, status, exit_code)
      if (.not. allocated(command%plot)) return
      call draw_fit(picture, scene, fit, status)
      call report_file(command%plot, status, exit_code)
   end subroutine write_files

end module nutate_fit_command
