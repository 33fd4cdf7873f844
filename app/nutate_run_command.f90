!> `nutate run SCENE`: simulates a scene and writes its history.
module nutate_run_command
   use nutate_accuracy, only: find_error_rate
   use nutate_cli, only: command_t
   use nutate_console, only: plural, say_error, show_page, EXIT_INPUT, EXIT_OUTPUT, EXIT_RUN, EXIT_SUCCESS
   use nutate_control, only: integrate_controlled
   use nutate_decimal, only: rounded_text
   use nutate_files, only: same_file, STANDARD_ERROR
   use nutate_kinds, only: wp, long
   use nutate_methods, only: make_stepper
   use nutate_printable, only: printable_path
   use nutate_run, only: integrate, run_summary_t
   use nutate_run_watcher, only: run_watcher_t
   use nutate_scene, only: scene_t
   use nutate_scene_loading, only: load_scene
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_IO
   use nutate_stepper, only: stepper_t
   use nutate_summary, only: summary_page
   implicit none
   private

   public :: run_command

contains

   !> Runs a scene from its file to its summary.
   subroutine run_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(scene_t) :: scene
      class(stepper_t), allocatable :: stepper
      type(run_watcher_t) :: watcher
      type(status_t) :: status

      call load_scene(command, scene, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      scene%plan%max_steps = command%max_steps
      exit_code = EXIT_INPUT
      if (same_file(scene%file, scene%output%file)) then
         call say_error('nutate: '//printable_path(scene%output%file)// &
                        ' is the scene itself and will not be written over')
         return
      end if
      call make_stepper(scene%system, scene%integrator, stepper, status)
      if (.not. status%ok()) then
         call say_error(printable_path(scene%file)//': '//trim(status%message))
         return
      end if
      if (scene%control%accuracy > 0.0_wp) then
         call find_error_rate(scene%system, scene%integrator, scene%initial, scene%plan, scene%control, status)
         if (.not. status%ok()) then
            call say_error('nutate: '//printable_path(scene%file)//': a pilot run failed: '//trim(status%message))
            exit_code = EXIT_RUN
            return
         end if
      end if
      call watcher%history%open(scene%output%file, scene%output%columns, scene%system, scene%initial, &
                                scene%integrator%inverse_auxiliary_inertia, status)
      if (.not. status%ok()) then
         call report_output(scene, status)
         if (status%code == NUTATE_IO) exit_code = EXIT_OUTPUT
         return
      end if
      call simulate(command, scene, stepper, watcher, exit_code)
   end subroutine run_command

   !> Integrates and ends the history, complete or not.
   subroutine simulate(command, scene, stepper, watcher, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(in) :: scene
      class(stepper_t), intent(inout) :: stepper
      type(run_watcher_t), intent(inout) :: watcher
      integer, intent(out) :: exit_code
      type(run_summary_t) :: summary
      type(state_t) :: state
      type(status_t) :: status, closing
      integer(long) :: started, ended

      state = scene%initial
      call watcher%start(scene%system, state, scene%plan, scene%integrator, command%quiet)
      call system_clock(started)
      if (scene%control%active()) then
         call integrate_controlled(scene%system, scene%integrator, scene%control, state, scene%plan, watcher, summary, &
                                   status)
      else
         call integrate(scene%system, stepper, state, scene%plan, watcher, summary, status)
      end if
      call watcher%progress%erase()
      if (.not. status%ok()) then
         call watcher%history%abandon(closing)
         exit_code = EXIT_RUN
         if (status%code == NUTATE_IO) exit_code = EXIT_OUTPUT
         if (status%code == NUTATE_IO) call report_output(scene, status, kept_rows(watcher, closing))
         if (status%code /= NUTATE_IO) call report_failure(scene, watcher, state%t, summary, status, closing)
         return
      end if
      call watcher%history%finish(status)
      call system_clock(ended)
      if (.not. status%ok()) then
         exit_code = EXIT_OUTPUT
         call report_output(scene, status, kept_rows(watcher, status))
      else if (command%quiet) then
         exit_code = EXIT_SUCCESS
      else
         call show_page(summary_page(scene, watcher, summary, real(ended - started, wp)/real(watcher%rate, wp)), &
                        STANDARD_ERROR, exit_code)
      end if
   end subroutine simulate

   !> Says that the output cannot be written.
   subroutine report_output(scene, status, kept)
      type(scene_t), intent(in) :: scene
      type(status_t), intent(in) :: status
      !> Where rows are kept.
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

   !> Says when and why a run failed and where its rows are.
   subroutine report_failure(scene, watcher, t, summary, status, closing)
      type(scene_t), intent(in) :: scene
      type(run_watcher_t), intent(in) :: watcher
      !> Time reached, s.
      real(wp), intent(in) :: t
      type(run_summary_t), intent(in) :: summary
      type(status_t), intent(in) :: status
      !> What closing the history came to.
      type(status_t), intent(in) :: closing
      call say_error('nutate: '//printable_path(scene%file)//': stopped at t = '//rounded_text(t, 9)//' s after '// &
                     plural(summary%steps, 'step')//': '//trim(status%message)//kept_rows(watcher, closing))
   end subroutine report_failure

   !> Where the rows of an incomplete history are.
   function kept_rows(watcher, closing) result(text)
      type(run_watcher_t), intent(in) :: watcher
      !> What closing the history came to.
      type(status_t), intent(in) :: closing
      character(len=:), allocatable :: text
      text = ''
      if (watcher%history%file%kept_in() == '') return
      if (closing%ok()) then
         text = '; kept '//plural(watcher%history%rows, 'row')//' up to t = '// &
                rounded_text(watcher%last_row, 9)//' s in '
      else
         text = '; kept whole rows in '
      end if
      text = text//printable_path(watcher%history%file%kept_in())
   end function kept_rows

end module nutate_run_command
