!> `nutate cost SCENE`: what accuracy costs in time on a scene.
module nutate_cost_command
   use nutate_cli, only: command_t
   use nutate_console, only: page_t, say_error, show_page, EXIT_INPUT, EXIT_OUTPUT, EXIT_RUN, EXIT_SIGNAL, &
      EXIT_SUCCESS
   use nutate_cost_answer, only: add_answer
   use nutate_cost_csv, only: cost_csv_t
   use nutate_cost_plot, only: cost_plot_t, gnuplot_is_here
   use nutate_cost_table, only: add_reference, add_table
   use nutate_decimal, only: rounded_text
   use nutate_files, only: same_file, STANDARD_ERROR, STANDARD_OUTPUT
   use nutate_kinds, only: wp, long
   use nutate_step_ladder, only: step_ladder_t
   use nutate_printable, only: printable_path
   use nutate_run_progress, only: progress_bar_t
   use nutate_reference, only: reference_methods, reference_t
   use nutate_scene, only: scene_t
   use nutate_scene_loading, only: load_scene
   use nutate_run_signals, only: caught_signal, signal_name, stop_watcher_t, watch_signals
   use nutate_status, only: status_t
   use nutate_stopwatch, only: stopwatch_t
   use nutate_measured_run, only: fastest_rate, problem_t
   implicit none
   private

   public :: cost_command

   !> Share of the time that may go into the reference.
   real(wp), parameter :: reference_share = 0.3_wp

   !> A study and where it goes.
   type :: study_t
      type(problem_t) :: problem
      type(reference_t) :: reference
      type(step_ladder_t) :: ladder
      type(stopwatch_t) :: clock
      !> Largest |Ω|, rad/s.
      real(wp) :: rate = 0.0_wp
      type(cost_csv_t) :: csv
      type(cost_plot_t) :: plot
      logical :: has_csv = .false., has_plot = .false.
   end type study_t

contains

   !> Studies a scene and shows what came of it.
   subroutine cost_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(scene_t) :: scene
      type(study_t) :: study

      call load_scene(command, scene, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      call open_outputs(command, scene, study, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      study%problem = problem_t(scene%system, scene%initial, scene%plan%end_time, scene%integrator)
      allocate (stop_watcher_t :: study%problem%onlooker)
      call watch_signals()
      call measure(study, scene%plan%time_step, command%seconds)
      if (caught_signal() /= 0) then
         call discard_outputs(study)
         call say_error('nutate: '//printable_path(scene%file)//': stopped by '//signal_name()//'; nothing was written')
         exit_code = EXIT_SIGNAL + caught_signal()
         return
      end if
      if (size(study%ladder%runs) == 0) then
         call discard_outputs(study)
         call say_error('nutate: '//printable_path(scene%file)//': no run was completed within '// &
                        rounded_text(command%seconds)//' s (try --seconds, or a shorter integrator.end_time by --set)')
         exit_code = EXIT_RUN
         return
      end if
      call show(command, scene, study, exit_code)
   end subroutine cost_command

   !> Claims the files before any time is spent.
   subroutine open_outputs(command, scene, study, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      type(study_t), intent(inout) :: study
      integer, intent(out) :: exit_code
      type(status_t) :: status

      exit_code = EXIT_SUCCESS
      if (allocated(command%csv)) then
         call refuse_scene(command%csv, scene, exit_code)
         if (exit_code /= EXIT_SUCCESS) return
         call study%csv%open(command%csv, status)
         call report(command%csv, status, exit_code)
         study%has_csv = status%ok()
      end if
      if (exit_code == EXIT_SUCCESS .and. allocated(command%plot)) then
         call refuse_scene(command%plot, scene, exit_code)
         if (exit_code == EXIT_SUCCESS) then
            call open_plot(command%plot, study, exit_code)
            study%has_plot = exit_code == EXIT_SUCCESS
         end if
      end if
      if (exit_code /= EXIT_SUCCESS) call discard_outputs(study)
   end subroutine open_outputs

   subroutine open_plot(name, study, exit_code)
      character(len=*), intent(in) :: name
      type(study_t), intent(inout) :: study
      integer, intent(inout) :: exit_code
      type(status_t) :: status
      if (gnuplot_is_here()) then
         call study%plot%open(name, status)
         call report(name, status, exit_code)
      else
         call say_error('nutate: cannot draw '//printable_path(name)//': gnuplot is not installed, or not on PATH')
         exit_code = EXIT_OUTPUT
      end if
   end subroutine open_plot

   !> The scene must not be written over.
   subroutine refuse_scene(name, scene, exit_code)
      character(len=*), intent(in) :: name
      type(scene_t), intent(in) :: scene
      integer, intent(inout) :: exit_code
      if (.not. same_file(scene%file, name)) return
      call say_error('nutate: '//printable_path(name)//' is the scene itself and will not be written over')
      exit_code = EXIT_INPUT
   end subroutine refuse_scene

   !> Says that an output cannot be written, if so.
   subroutine report(name, status, exit_code)
      character(len=*), intent(in) :: name
      type(status_t), intent(in) :: status
      integer, intent(inout) :: exit_code
      if (status%ok()) return
      call say_error('nutate: cannot write '//printable_path(name)//': '//trim(status%message))
      exit_code = EXIT_OUTPUT
   end subroutine report

   subroutine discard_outputs(study)
      type(study_t), intent(inout) :: study
      if (study%has_csv) call study%csv%discard()
      if (study%has_plot) call study%plot%discard()
   end subroutine discard_outputs

   !> Finds the reference and makes the runs.
   subroutine measure(study, time_step, seconds)
      type(study_t), intent(inout) :: study
      !> The scene's step, s; 0 where it has none.
      real(wp), intent(in) :: time_step
      !> Time to be spent, s.
      real(wp), intent(in) :: seconds
      type(progress_bar_t) :: progress
      type(status_t) :: status
      integer :: first, second

      call study%clock%start()
      call progress%start(wanted=.true.)
      call reference_methods(first, second)
      ! What the pilot run fails at is said by the runs themselves.
      call fastest_rate(study%problem, first, study%rate, status)
      call study%reference%begin(study%problem, study%rate)
      do while (.not. study%reference%settled .and. caught_signal() == 0)
         call study%reference%refine(study%problem, study%clock, reference_share*seconds)
         call show_progress(progress, study%clock%seconds()/seconds)
      end do
      call study%ladder%begin(study%problem, study%rate, time_step)
      do while (.not. study%ladder%done .and. caught_signal() == 0)
         call study%ladder%climb(study%problem, study%reference, study%clock, seconds)
         call show_progress(progress, study%clock%seconds()/seconds)
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

   !> Table and answer on standard output, or on standard error where the CSV is there; then the files.
   subroutine show(command, scene, study, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      type(study_t), intent(inout) :: study
      integer, intent(out) :: exit_code
      type(page_t) :: page
      type(status_t) :: status
      integer :: descriptor

      call page%line(printable_path(scene%file)//': '//scene%title)
      call page%item('motion', 'to t = '//rounded_text(scene%plan%end_time)//' s, at up to '// &
                     rounded_text(study%rate)//' rad/s')
      call add_reference(page, study%reference, scene%plan%end_time)
      call page%item('measured for', rounded_text(study%clock%seconds(), 3)//' s')
      call add_table(page, study%problem, study%reference, study%ladder)
      call add_answer(page, study%reference, study%ladder, scene%plan%end_time)
      descriptor = STANDARD_OUTPUT
      if (study%has_csv .and. study%csv%on_standard_output) descriptor = STANDARD_ERROR
      call show_page(page, descriptor, exit_code)
      if (study%has_csv) then
         call study%csv%write(study%problem, study%reference, study%ladder, status)
         call report(command%csv, status, exit_code)
      end if
      if (study%has_plot) then
         call study%plot%draw(scene%title, study%reference, study%ladder, status)
         call report(command%plot, status, exit_code)
      end if
   end subroutine show

end module nutate_cost_command
