!> `nutate cost SCENE`: work-precision study of a scene, run time against error.
module nutate_cost_command
   use nutate_scene_loading, only: add_space_axes, propagated_fault, load_scene
   use nutate_cli, only: command_t
   use nutate_console, only: page_t, plural, report_file, say_error, show_page, EXIT_INPUT, EXIT_RUN, EXIT_SIGNAL, &
      EXIT_SUCCESS
   use nutate_control, only: needs_control
   use nutate_cost_report, only: add_answer, cost_csv_t, method_label, add_reference, add_table
   use nutate_cost_plot, only: draw_cost
   use nutate_decimal, only: rounded_text
   use nutate_files, only: STANDARD_ERROR, STANDARD_OUTPUT
   use nutate_gnuplot, only: picture_t
   use nutate_outputs, only: discard_file, outputs_t, picture_kind, COSTS
   use nutate_plot_command, only: open_picture
   use nutate_kinds, only: wp, long
   use nutate_printable, only: printable_path
   use nutate_run_watcher, only: progress_bar_t, caught_signal, signal_name, stop_watcher_t, watch_signals
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   use nutate_study_budget, only: study_budget_t
   use nutate_measured_run, only: problem_t
   use nutate_methods, only: methods
   use nutate_work_precision, only: work_precision_t
   implicit none
   private

   public :: cost_command

   !> Files of a study, in addition to the page of text.
   type :: study_files_t
      type(cost_csv_t) :: csv
      type(picture_t) :: plot
      logical :: has_csv = .false., has_plot = .false.
   end type study_files_t

contains

   !> Studies a scene and shows the result.
   subroutine cost_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(scene_t) :: scene
      type(work_precision_t) :: study
      type(study_files_t) :: outputs
      type(problem_t) :: problem

      call load_scene(command, scene, exit_code)
      ! The study measures runs without derivatives.
      if (exit_code == EXIT_SUCCESS .and. propagated_fault(scene) /= '') &
         call say_error(propagated_fault(scene), exit_code, EXIT_INPUT)
      if (exit_code == EXIT_SUCCESS) call refuse_switches()
      if (exit_code /= EXIT_SUCCESS) return
      call open_outputs()
      if (exit_code /= EXIT_SUCCESS) return
      problem = problem_t(scene%system, scene%initial, scene%plan%end_time, scene%integrator)
      allocate (stop_watcher_t :: problem%observer)
      call watch_signals()
      call measure(problem, scene%plan%time_step, budget_of(command), study)
      if (size(study%points) == 0) then
         call discard_outputs()
         call report_nothing()
         return
      end if
      call show()

   contains

      !> Reports why no run was completed.
      subroutine report_nothing()
         character(len=:), allocatable :: line
         integer :: m
         line = 'nutate: '//printable_path(scene%file)//': '
         if (caught_signal() /= 0) then
            call say_error(line//'stopped by '//signal_name()//'; nothing was written')
            exit_code = EXIT_SIGNAL + caught_signal()
            return
         end if
         exit_code = EXIT_RUN
         ! The closed solution has no order; it rejects most scenes.
         do m = 1, size(methods)
            if (methods(m)%order < 1 .or. study%refusal(m)%ok()) cycle
            call say_error(line//'no run was completed: '//method_label(m)//': '//trim(study%refusal(m)%message))
            return
         end do
         call say_error(line//budget_text(command))
      end subroutine report_nothing

      !> Claims the files before any time is spent.
      subroutine open_outputs()
         type(status_t) :: status

         exit_code = EXIT_SUCCESS
         call check_names()
         if (exit_code /= EXIT_SUCCESS) return
         if (allocated(command%csv)) then
            call outputs%csv%open(command%csv, status)
            call report_file(command%csv, status, exit_code)
            outputs%has_csv = status%ok()
         end if
         if (exit_code == EXIT_SUCCESS .and. allocated(command%plot)) then
            call open_picture(command%plot, outputs%plot, exit_code)
            outputs%has_plot = exit_code == EXIT_SUCCESS
         end if
         if (exit_code /= EXIT_SUCCESS) call discard_outputs()
      end subroutine open_outputs

      !> Rejects file names that would overwrite an input, a file of another kind or each other.
      subroutine check_names()
         type(outputs_t) :: files
         call files%read_scene(scene)
         if (allocated(command%csv)) call files%add(command%csv, COSTS)
         if (allocated(command%plot)) call files%add(command%plot, picture_kind(command%plot))
         call files%report(exit_code)
      end subroutine check_names

      subroutine discard_outputs()
         if (outputs%has_csv) call discard_file(outputs%csv%file)
         if (outputs%has_plot) call outputs%plot%discard()
      end subroutine discard_outputs

      !> Shows table and answer on standard output, or on standard error if the CSV goes to standard output; then writes
      !> the files.
      subroutine show()
         type(page_t) :: page
         type(status_t) :: status
         integer :: descriptor

         call page%line(printable_path(scene%file)//': '//scene%title)
         call add_space_axes(page, scene)
         call page%item('motion', 'to t = '//rounded_text(scene%plan%end_time)//' s, at up to '// &
                        rounded_text(study%rate)//' rad/s')
         call add_reference(page, study)
         call page%item('measured for', rounded_text(study%budget%clock%seconds(), 3)//' s, '// &
                        plural(study%budget%evaluations, 'evaluation')//' of the equations')
         call add_table(page, study)
         call add_answer(page, study)
         descriptor = STANDARD_OUTPUT
         if (outputs%has_csv .and. outputs%csv%on_standard_output) descriptor = STANDARD_ERROR
         call show_page(page, descriptor, exit_code)
         if (caught_signal() /= 0) then
            call keep_runs()
            exit_code = EXIT_SIGNAL + caught_signal()
            return
         end if
         if (outputs%has_csv) then
            call outputs%csv%write(study, .true., status)
            call report_file(command%csv, status, exit_code)
         end if
         if (outputs%has_plot) then
            call draw_cost(outputs%plot, scene%title, study, command%draws_all, status)
            call report_file(command%plot, status, exit_code)
         end if
      end subroutine show

      !> Keeps the runs of a stopped study and reports their file; no picture is drawn.
      subroutine keep_runs()
         character(len=:), allocatable :: line
         type(status_t) :: status
         line = 'nutate: '//printable_path(scene%file)//': stopped by '//signal_name()//' after '// &
                plural(size(study%points, kind=long), 'run')
         if (outputs%has_plot) call outputs%plot%discard()
         if (outputs%has_csv) then
            call outputs%csv%write(study, .false., status)
            if (status%ok() .and. outputs%csv%file%kept_in() /= '') &
               line = line//'; kept in '//printable_path(outputs%csv%file%kept_in())
         end if
         call say_error(line)
      end subroutine keep_runs

      !> Rejects a scene whose events switch effects: the study runs without events, so its motion would differ.
      subroutine refuse_switches()
         integer :: i
         do i = 1, scene%events%count()
            if (scene%events%slots(i)%item%action == 0) cycle
            call say_error('nutate: '//printable_path(scene%file)// &
               ': a cost study does not support events, and the scene has '// &
                           'effects that events switch (expected no switch)', exit_code, EXIT_INPUT)
            return
         end do
         if (.not. needs_control(scene%system%effects)) return
         call say_error('nutate: '//printable_path(scene%file)// &
                        ': a cost study supports neither limits nor samples (expected no speed_limit '// &
                        'in &wheel, no sample and no limits in &controller)', exit_code, EXIT_INPUT)
      end subroutine refuse_switches

   end subroutine cost_command

   !> Returns the budget that the options set.
   pure type(study_budget_t) function budget_of(command) result(budget)
      type(command_t), intent(in) :: command
      budget%is_in_evaluations = command%evaluations > 0
      budget%limit = command%seconds
      if (budget%is_in_evaluations) budget%limit = real(command%evaluations, wp)
   end function budget_of

   !> Returns the message for a budget in which no run was completed.
   pure function budget_text(command) result(text)
      type(command_t), intent(in) :: command
      character(len=:), allocatable :: text, option
      if (command%evaluations > 0) then
         text = plural(command%evaluations, 'evaluation')
         option = '--evaluations'
      else
         text = rounded_text(command%seconds)//' s'
         option = '--seconds'
      end if
      text = 'no run was completed within '//text//' (try more '//option//', or a shorter integrator.end_time by --set)'
   end function budget_text

   !> Studies a problem until the study is complete or a signal arrives.
   subroutine measure(problem, time_step, budget, study)
      type(problem_t), intent(in) :: problem
      !> Step of the scene, s; 0 if it has none.
      real(wp), intent(in) :: time_step
      type(study_budget_t), intent(in) :: budget
      type(work_precision_t), intent(inout) :: study
      type(progress_bar_t) :: progress

      call progress%start(wanted=.true.)
      call study%begin(problem, time_step, budget)
      do while (.not. study%done .and. caught_signal() == 0)
         call study%advance()
         call show_progress(progress, study%budget%spent()/budget%limit)
      end do
      call progress%erase()
   end subroutine measure

   subroutine show_progress(progress, fraction)
      type(progress_bar_t), intent(inout) :: progress
      real(wp), intent(in) :: fraction
      integer(long) :: now
      call system_clock(now)
      call progress%update(fraction, now)
   end subroutine show_progress

end module nutate_cost_command
