!> `nutate run SCENE`: simulates a scene and writes its history.
module nutate_run_command
   use nutate_byte_archive, only: byte_archive_t
   use nutate_cli, only: command_t
   use nutate_console, only: count_text, report_file, say_error, show_page, EXIT_INPUT, EXIT_OUTPUT, EXIT_RUN, &
      EXIT_SIGNAL, EXIT_SUCCESS
   use nutate_event_history, only: events_name
   use nutate_notes, only: expectation_text, known_steps, most_rows, rows_of, too_many_rows
   use nutate_files, only: file_exists, goes_to_file, same_file, STANDARD_ERROR
   use nutate_free_variations, only: usual_sets
   use nutate_scene_loading, only: propagate_free_parameters, load_scene
   use nutate_gnuplot, only: picture_t
   use nutate_history_plot, only: name_length, recorded_t
   use nutate_kinds, only: wp, long
   use nutate_outputs, only: outputs_t, picture_kind, CHECKPOINT, EVENTS, HISTORY
   use nutate_plot_command, only: add_picture_sets, sample_rows, open_picture, draw_file
   use nutate_printable, only: printable_path
   use nutate_run, only: run_record_t, run_t, system_t
   use nutate_run_checkpoint, only: read_checkpoint
   use nutate_run_watcher, only: progress_bar_t, caught_signal, signal_flag, watch_signals, check_signals, &
      stop_watcher_t, run_watcher_t
   use nutate_run_summary, only: report_checkpoint, report_failure, report_output, report_signal, kept_rows, &
      summary_page
   use nutate_scene, only: scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t, NUTATE_BAD_ARGUMENT, NUTATE_IO, NUTATE_STOPPED
   implicit none
   private

   public :: run_command

   !> Observer of the trial runs that find the steps of a run: shows a progress bar for each, and ends them on a signal.
   type, extends(stop_watcher_t) :: trial_watcher_t
      type(progress_bar_t) :: progress
      !> Number of trial runs so far, including the current one.
      integer(long), private :: runs = 0
      !> Start time and duration of each run, s.
      real(wp), private :: t_first = 0.0_wp, duration = 0.0_wp
   contains
      !> Starts the clock.
      procedure :: start
      procedure :: observe => count_run
      procedure :: poll => poll
   end type trial_watcher_t

contains

   !> Runs a scene from its file to its picture.
   subroutine run_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(scene_t) :: scene
      type(picture_t) :: picture
      type(byte_archive_t), allocatable :: archive
      type(recorded_t), allocatable :: sampled

      call load_scene(command, scene, exit_code)
      if (exit_code == EXIT_SUCCESS) scene%output%columns = usual_sets(scene)
      if (exit_code == EXIT_SUCCESS) call load_checkpoint()
      if (exit_code == EXIT_SUCCESS) call check_names()
      if (exit_code == EXIT_SUCCESS .and. allocated(command%plot)) &
         call claim_picture()
      if (exit_code /= EXIT_SUCCESS) return
      call watch_signals()
      call run_scene(command, scene, archive, exit_code)
      if (.not. allocated(command%plot)) return
      if (exit_code == EXIT_SUCCESS) then
         ! Rows nearer to each other than those of the run, if these are too far apart.
         call sample_rows(command, scene, sampled)
         call draw_file(command, scene%output%file, command%plot, scene%title, picture, exit_code, sampled)
      else
         call picture%discard()
      end if

   contains

      !> Claims the file of the picture before any time is spent.
      subroutine claim_picture()
         type(status_t) :: status
         character(len=name_length), allocatable :: sets(:)
         call add_picture_sets(command, scene, sets, status)
         if (.not. status%ok()) then
            call say_error('nutate: --plot '//printable_path(command%plot)//': '//trim(status%message))
            exit_code = EXIT_INPUT
         else if (.not. goes_to_file(scene%output%file)) then
            call say_error('nutate: --plot needs rows in a file (expected --output FILE)', exit_code, EXIT_INPUT)
         else
            call open_picture(command%plot, picture, exit_code)
         end if
      end subroutine claim_picture

      !> Reads the checkpoint that the run resumes, if there is one.
      subroutine load_checkpoint()
         character(len=:), allocatable :: content, problem
         exit_code = EXIT_SUCCESS
         if (.not. allocated(command%resume)) return
         exit_code = EXIT_INPUT
         call read_checkpoint(command%resume, scene, content, problem)
         if (problem == '' .and. allocated(command%output)) then
            if (command%output /= scene%output%file) &
               problem = 'the rows of '//printable_path(command%resume)//' are in '// &
               printable_path(scene%output%file)// &
                         ' (expected no other --output)'
         end if
         if (problem /= '') then
            call say_error('nutate: '//problem)
            return
         end if
         allocate (archive)
         call archive%begin_reading(content)
         exit_code = EXIT_SUCCESS
      end subroutine load_checkpoint

      !> Rejects file names that would overwrite an input, a file of another kind or each other.
      subroutine check_names()
         type(outputs_t) :: files
         call files%read_scene(scene)
         call files%add(scene%output%file, HISTORY)
         call files%add(events_file(scene), EVENTS)
         if (allocated(command%plot)) call files%add(command%plot, picture_kind(command%plot))
         if (allocated(command%checkpoint)) then
            associate (file => command%checkpoint)
               if (files%problem == '' .and. .not. goes_to_file(scene%output%file)) then
                  files%problem = '--checkpoint needs rows in a file (expected --output FILE)'
               else if (files%problem == '' .and. file_exists(file) .and. .not. is_resumed(command)) then
                  files%problem = printable_path(file)//' exists (expected --resume, or another --checkpoint)'
               end if
               call files%add(file, CHECKPOINT)
            end associate
         end if
         call files%report(exit_code)
      end subroutine check_names

   end subroutine run_command

   !> Runs a scene to its summary.
   subroutine run_scene(command, scene, archive, exit_code)
      type(command_t), intent(in) :: command
      type(scene_t), intent(inout) :: scene
      !> Archive of the watcher of the interrupted run; not allocated for a run from the start.
      type(byte_archive_t), allocatable, intent(inout) :: archive
      integer, intent(inout) :: exit_code
      type(run_t) :: run
      type(run_watcher_t) :: watcher
      type(status_t) :: status

      scene%plan%max_steps = command%max_steps
      call run%begin(scene%system, scene%integrator, scene%initial, scene%plan, status)
      if (status%ok()) call run%set_events(scene%events, scene%system, status)
      if (status%ok()) call propagate_free_parameters(scene, run, exit_code)
      if (status%ok() .and. exit_code == EXIT_SUCCESS) call run%follow_chaos(scene%chaos, scene%system, status)
      if (.not. status%ok()) then
         call say_error(printable_path(scene%file)//': '//trim(status%message), exit_code, EXIT_INPUT)
         return
      end if
      if (exit_code == EXIT_SUCCESS .and. .not. allocated(archive)) call find_steps()
      if (exit_code == EXIT_SUCCESS .and. .not. allocated(archive)) call expect()
      if (exit_code /= EXIT_SUCCESS) return
      if (allocated(command%checkpoint)) then
         call watcher%checkpoint%prepare(command%checkpoint, command%every_seconds, scene, is_resumed(command))
      else if (allocated(command%resume)) then
         call watcher%checkpoint%prepare(command%resume, command%every_seconds, scene, .true.)
      end if
      call open_history()
      if (exit_code == EXIT_SUCCESS .and. events_file(scene) /= '') call open_events()
      if (exit_code == EXIT_SUCCESS) call simulate()

   contains

      !> Finds the steps that meet the accuracy of the scene.
      subroutine find_steps()
         type(trial_watcher_t) :: watcher
         type(status_t) :: status
         call watcher%start(scene%initial%t, scene%plan%end_time, wanted=.not. command%quiet)
         call run%find_steps(scene%system, status, watcher)
         call watcher%progress%erase()
         if (status%ok()) return
         call say_error('nutate: '//printable_path(scene%file)//': a trial run failed: '//trim(status%message))
         exit_code = EXIT_RUN
         if (status%code == NUTATE_STOPPED) exit_code = EXIT_SIGNAL + caught_signal()
      end subroutine find_steps

      !> Reports the expected steps and rows; rejects more rows than are written by default.
      subroutine expect()
         character(len=:), allocatable :: text
         integer(long) :: rows
         rows = rows_of(scene, known_steps(scene, run))
         if (rows > most_rows(scene)) then
            call say_error('nutate: '//printable_path(scene%file)//': '//too_many_rows(scene, rows), exit_code, &
               EXIT_INPUT)
            return
         end if
         text = expectation_text(scene, run)
         if (.not. command%quiet .and. text /= '') call say_error(text)
      end subroutine expect

      !> Opens the history, or continues the history of an archive.
      subroutine open_history()
         type(status_t) :: status
         character(len=:), allocatable :: rows
         watcher%file%stop_flag = signal_flag()
         associate (j0 => scene%integrator%inverse_auxiliary_inertia, columns => scene%output%columns)
            if (allocated(archive)) then
               call watcher%reopen(scene%output%file, columns, scene%system, scene%initial, j0, archive, status, &
                                           scene%output%degrees, scene%output%digits, &
                                           scene%plan%end_time < scene%initial%t, scene%output%epoch, &
                                           scene%propagated())
            else
               call watcher%open(scene%output%file, columns, scene%system, scene%initial, j0, status, &
                                         scene%output%degrees, scene%output%digits, &
                                         scene%plan%end_time < scene%initial%t, scene%output%epoch, &
                                         scene%propagated())
            end if
         end associate
         if (status%ok()) return
         if (allocated(archive)) then
            rows = scene%output%file
            if (allocated(watcher%file%partial)) rows = watcher%file%partial
            call say_error('nutate: '//printable_path(command%resume)//' cannot be resumed: '//printable_path(rows)// &
                           ': '//trim(status%message), exit_code, EXIT_INPUT)
         else if (caught_signal() /= 0) then
            call report_signal(scene)
            exit_code = EXIT_SIGNAL + caught_signal()
         else
            call report_output(scene, status, '')
            exit_code = merge(EXIT_OUTPUT, EXIT_INPUT, status%code == NUTATE_IO)
         end if
      end subroutine open_history

      !> Opens the file of the events, or continues that of an archive. On failure, the history is abandoned too.
      subroutine open_events()
         type(status_t) :: status, closing
         character(len=:), allocatable :: name
         name = events_file(scene)
         watcher%events%file%stop_flag = signal_flag()
         if (allocated(archive)) then
            call watcher%events%reopen(name, archive, status)
         else
            call watcher%events%open(name, watcher%history_t, status)
         end if
         if (status%ok()) return
         call watcher%abandon(closing)
         if (allocated(archive)) then
            if (allocated(watcher%events%file%partial)) name = watcher%events%file%partial
            call say_error('nutate: '//printable_path(command%resume)//' cannot be resumed: '//printable_path(name)// &
                           ': '//trim(status%message), exit_code, EXIT_INPUT)
         else
            call report_file(name, status, exit_code)
         end if
      end subroutine open_events

      !> Integrates and ends the history, complete or not.
      subroutine simulate()
         type(status_t) :: status

         watcher%max_rows = command%max_rows
         call watcher%start(scene%system, scene%initial, scene%plan, scene%integrator, command%quiet)
         if (allocated(archive)) call resume(status)
         if (status%ok()) call run%run_to_end(scene%system, status, watcher)
         call watcher%progress%erase()
         if (status%ok()) then
            call complete()
         else
            call give_up(status)
         end if
      end subroutine simulate

      !> Gives the watcher its part of an archive, and the run the rest.
      subroutine resume(status)
         type(status_t), intent(out) :: status
         type(byte_archive_t) :: inner
         character(len=:), allocatable :: content
         call watcher%resume(archive)
         content = ''
         call archive%transfer(content)
         call inner%begin_reading(content)
         call run%resume(inner, status)
      end subroutine resume

      !> Gives a complete history its name and shows the summary of the run.
      subroutine complete()
         type(status_t) :: status
         exit_code = EXIT_SUCCESS
         if (watcher%events%wanted) call watcher%events%file%finish(status)
         if (.not. status%ok()) then
            call report_file(events_file(scene), status, exit_code)
            call watcher%abandon(status)
            return
         end if
         call watcher%finish(status)
         if (.not. status%ok()) then
            exit_code = EXIT_OUTPUT
            call report_output(scene, status, kept_rows(watcher, status))
            return
         end if
         call watcher%checkpoint%remove(status)
         if (.not. status%ok()) then
            exit_code = EXIT_OUTPUT
            call report_checkpoint('remove', watcher, status, '')
         end if
         if (.not. command%quiet) call show_page(summary_page(scene, watcher, run), STANDARD_ERROR, exit_code)
      end subroutine complete

      !> Ends an incomplete history, and reports why it is incomplete.
      subroutine give_up(status)
         !> Status that ended the run.
         type(status_t), intent(in) :: status
         type(status_t) :: closing
         if (watcher%events%wanted) call watcher%events%file%abandon(closing)
         call watcher%abandon(closing)
         if (status%code == NUTATE_STOPPED .or. (status%code == NUTATE_IO .and. caught_signal() /= 0 .and. &
                                                 .not. goes_to_file(scene%output%file))) then
            exit_code = EXIT_SIGNAL + caught_signal()
            call report_signal(scene, watcher, run%state%t, run%summary, closing)
         else if (.not. watcher%checkpoint_status%ok()) then
            exit_code = EXIT_OUTPUT
            if (status%code == NUTATE_BAD_ARGUMENT) exit_code = EXIT_INPUT
            call report_checkpoint('write', watcher, status, kept_rows(watcher, closing))
         else if (status%code == NUTATE_IO) then
            exit_code = EXIT_OUTPUT
            call report_output(scene, status, kept_rows(watcher, closing))
         else
            exit_code = EXIT_RUN
            call report_failure(scene, watcher, run%state%t, run%summary, status, closing)
         end if
      end subroutine give_up

   end subroutine run_scene

   !> Returns true if the run writes its checkpoints to the file that it resumes.
   logical function is_resumed(command)
      type(command_t), intent(in) :: command
      is_resumed = .false.
      if (allocated(command%resume)) is_resumed = same_file(command%resume, command%checkpoint)
   end function is_resumed

   !> Returns the path of the file of the events; blank if there are no events.
   function events_file(scene) result(name)
      type(scene_t), intent(in) :: scene
      character(len=:), allocatable :: name
      name = ''
      if (scene%events%count() == 0) return
      name = scene%output%events
      if (name == '') name = events_name(scene%output%file)
   end function events_file

   !> Starts the clock.
   subroutine start(self, t_first, end_time, wanted)
      class(trial_watcher_t), intent(inout) :: self
      !> Start and end times of each run, s.
      real(wp), intent(in) :: t_first, end_time
      !> True if a progress bar is wanted.
      logical, intent(in) :: wanted
      self%t_first = t_first
      self%duration = end_time - t_first
      call self%progress%start(wanted)
   end subroutine start

   !> Counts a trial run when its first state arrives, and labels the progress bar.
   subroutine count_run(self, system, state, record, status)
      class(trial_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (abs(state%t - self%t_first) > 0.5_wp*abs(self%duration)) return
      self%runs = self%runs + 1
      self%progress%label = 'trial run '//count_text(self%runs)
   end subroutine count_run

   !> Shows the progress, and ends the runs on a signal.
   subroutine poll(self, fraction, status)
      class(trial_watcher_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      integer(long) :: now
      call system_clock(now)
      call self%progress%update(fraction, now)
      call check_signals(status)
   end subroutine poll

end module nutate_run_command
