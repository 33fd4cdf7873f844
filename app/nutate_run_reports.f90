!> One line on standard error for a run that is not complete: when and why it ended, and where its rows are.
module nutate_run_reports
   use nutate_console, only: plural, say_error
   use nutate_decimal, only: rounded_text
   use nutate_kinds, only: wp
   use nutate_printable, only: printable_path
   use nutate_progress, only: run_summary_t
   use nutate_run_watcher, only: run_watcher_t
   use nutate_scene, only: scene_t
   use nutate_run_signals, only: signal_name
   use nutate_status, only: status_t
   implicit none
   private

   public :: report_checkpoint, report_failure, report_output, report_signal, kept_rows

contains

   !> Reports that the output cannot be written.
   subroutine report_output(scene, status, kept)
      type(scene_t), intent(in) :: scene
      type(status_t), intent(in) :: status
      !> Location of the rows, as `kept_rows` returns it.
      character(len=*), intent(in), optional :: kept
      character(len=:), allocatable :: name
      name = printable_path(scene%output%file)
      if (name == '-') name = 'standard output'
      if (present(kept)) then
         call say_error('nutate: cannot write '//name//': '//trim(status%message)//kept)
      else
         call say_error('nutate: cannot write '//name//': '//trim(status%message))
      end if
   end subroutine report_output

   !> Reports that the checkpoint cannot be written or removed.
   subroutine report_checkpoint(what, watcher, status, kept)
      !> Action that failed: `write` or `remove`.
      character(len=*), intent(in) :: what
      type(run_watcher_t), intent(in) :: watcher
      type(status_t), intent(in) :: status
      !> Location of the rows, as `kept_rows` returns it.
      character(len=*), intent(in), optional :: kept
      character(len=:), allocatable :: line
      line = 'nutate: cannot '//what//' checkpoint '//printable_path(watcher%checkpoint%file)//': '// &
             trim(status%message)
      if (present(kept)) line = line//kept
      call say_error(line)
   end subroutine report_checkpoint

   !> Reports when and why a run failed, and the location of its rows.
   subroutine report_failure(scene, watcher, t, summary, status, closing)
      type(scene_t), intent(in) :: scene
      type(run_watcher_t), intent(in) :: watcher
      !> Time reached, s.
      real(wp), intent(in) :: t
      type(run_summary_t), intent(in) :: summary
      type(status_t), intent(in) :: status
      !> Status of closing the history.
      type(status_t), intent(in) :: closing
      call say_error('nutate: '//printable_path(scene%file)//': stopped at t = '//rounded_text(t, 9)//' s after '// &
                     plural(summary%steps, 'step')//': '//trim(status%message)//kept_rows(watcher, closing))
   end subroutine report_failure

   !> Reports by which signal a run was stopped, and when, if it had begun.
   subroutine report_signal(scene, watcher, t, summary, closing)
      type(scene_t), intent(in) :: scene
      type(run_watcher_t), intent(in), optional :: watcher
      !> Time reached, s.
      real(wp), intent(in), optional :: t
      type(run_summary_t), intent(in), optional :: summary
      !> Status of closing the history.
      type(status_t), intent(in), optional :: closing
      character(len=:), allocatable :: line
      line = 'nutate: '//printable_path(scene%file)//': stopped by '//signal_name()
      if (present(watcher)) then
         line = line//' at t = '//rounded_text(t, 9)//' s after '//plural(summary%steps, 'step')// &
                kept_rows(watcher, closing)
         if (.not. watcher%checkpoint_status%ok()) &
            line = line//'; the last checkpoint could not be written: '//trim(watcher%checkpoint_status%message)
      end if
      call say_error(line)
   end subroutine report_signal

   !> Returns the location of the rows of an incomplete history, and how to resume the run.
   function kept_rows(watcher, closing) result(text)
      type(run_watcher_t), intent(in) :: watcher
      !> Status of closing the history.
      type(status_t), intent(in) :: closing
      character(len=:), allocatable :: text
      text = ''
      if (watcher%file%kept_in() == '') return
      if (closing%ok()) then
         text = '; kept '//plural(watcher%rows, 'row')//' up to t = '// &
                rounded_text(watcher%last_row, 9)//' s in '
      else
         text = '; complete rows are in '
      end if
      text = text//printable_path(watcher%file%kept_in())
      if (watcher%checkpoint%written) &
         text = text//' (to continue: --resume '//printable_path(watcher%checkpoint%file)//')'
   end function kept_rows

end module nutate_run_reports
