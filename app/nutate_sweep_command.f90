!> `nutate sweep SCENE`: runs the members of an ensemble.
module nutate_sweep_command
   use nutate_cli, only: command_t
   use nutate_console, only: count_text, report_file, say_error, EXIT_INPUT, EXIT_OUTPUT, EXIT_RUN, EXIT_SIGNAL, &
      EXIT_SUCCESS
   use nutate_decimal, only: decimal_t
   use nutate_event_history, only: events_name
   use nutate_files, only: file_exists, partial_name, write_text, STANDARD_OUTPUT
   use nutate_forks, only: has_threads
   use nutate_scene_loading, only: propagated_fault, read_scene_of
   use nutate_kinds, only: long
   use nutate_member_history, only: write_member
   use nutate_outputs, only: outputs_t, EVENTS, HISTORY, LISTING, MEANS, ROWS, ROWS_AS_CSV
   use nutate_printable, only: printable_path
   use nutate_row_layout, only: make_layout, row_layout_t
   use nutate_run_watcher, only: caught_signal, signal_name, watch_signals
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, NUTATE_IO, NUTATE_STOPPED
   use nutate_sweep, only: sweep_t
   use nutate_sweep_report, only: sweep_workers_t, sweep_progress_t, show_summary
   use nutate_sweep_csv, only: csv_line, header_line, write_csv
   use nutate_sweep_listing, only: listing_fits, listing_name, write_listing
   use nutate_sweep_merge, only: merge_parts, part_name, stem_of
   use nutate_sweep_sums, only: any_succeeded
   implicit none
   private

   public :: sweep_command, read_ensemble, choose_members

contains

   !> Runs the requested members, runs one member alone, or merges files.
   subroutine sweep_command(command, workers, exit_code)
      type(command_t), intent(in) :: command
      !> Workers that run the members.
      class(sweep_workers_t), intent(inout) :: workers
      integer, intent(out) :: exit_code
      type(scene_t) :: scene
      character(len=:), allocatable :: name, message
      integer(long) :: first, last

      workers%threads = command%threads
      call read_ensemble(command, scene, message)
      if (message /= '') then
         call say_error(message, exit_code, EXIT_INPUT)
         return
      end if
      exit_code = EXIT_SUCCESS
      call choose_members(command, scene, first, last, name)
      call check_wishes()
      if (exit_code == EXIT_SUCCESS) call check_names()
      if (exit_code /= EXIT_SUCCESS) return
      call watch_signals()
      if (command%member > 0) then
         call run_one()
      else if (command%merges) then
         call merge_files()
      else
         call run_all()
      end if

   contains

      !> Rejects members that do not exist, and options that do not fit the scene or the program.
      subroutine check_wishes()
         character(len=:), allocatable :: problem
         problem = ''
         if (max(last, command%member) > scene%ensemble%members) then
            problem = 'there is no member '//count_text(max(last, command%member))//' (expected 1 to '// &
                      count_text(scene%ensemble%members)//')'
         else if (command%member == 0 .and. last - first >= command%max_rows) then
            problem = count_text(last - first + 1)//' members are more than --max-rows allows (expected at most '// &
                      count_text(command%max_rows)//')'
         else if (command%threads > 1 .and. .not. has_threads()) then
            problem = 'this program was built without threads (expected --threads 1, or a build by make or CMake)'
         else if (name == '-') then
            problem = 'rows need a file (expected --output FILE.npy)'
         else if (scene%ensemble%keeps_rows .and. command%member == 0 .and. ends_in_csv(name)) then
            problem = printable_path(name)//' is the name of a CSV file, but rows are a NumPy array '// &
                      '(expected FILE.npy, and --csv FILE for CSV)'
         else if (.not. scene%ensemble%keeps_rows .and. (command%merges .or. command%first > 0 .or. &
                                                         allocated(command%csv))) then
            problem = "the scene keeps no rows (expected rows = 'final' in &ensemble)"
         end if
         if (problem == '') return
         call say_error('nutate: '//problem, exit_code, EXIT_INPUT)
      end subroutine check_wishes

      !> Rejects file names that would overwrite an input, a file of another kind or each other.
      subroutine check_names()
         type(outputs_t) :: files
         integer(long) :: member
         integer :: i
         call files%read_scene(scene)
         if (command%member > 0) then
            call add_history(single_name(), files)
         else
            call files%add(name, merge(ROWS, MEANS, scene%ensemble%keeps_rows))
            call files%add(listing_name(name), LISTING)
            if (allocated(command%csv)) call files%add(command%csv, ROWS_AS_CSV)
            do i = 1, size(scene%ensemble%histories)
               member = scene%ensemble%histories(i)
               if (member >= first .and. member <= last) call add_history(history_name(name, member), files)
            end do
         end if
         call files%report(exit_code)
      end subroutine check_names

      !> Adds the files of a member's history and of its events.
      subroutine add_history(name, files)
         character(len=*), intent(in) :: name
         type(outputs_t), intent(inout) :: files
         call files%add(name, HISTORY)
         if (scene%events%count() > 0) call files%add(events_name(name), EVENTS)
      end subroutine add_history

      !> Runs members and writes their file.
      subroutine run_all()
         type(sweep_t), target :: sweep
         type(sweep_progress_t), target :: watcher
         type(status_t) :: status, closing
         if (command%goes_on .and. file_exists(name) .and. partial_name(name) == '') then
            call keep_finished()
            return
         end if
         call sweep%open(scene, first, last, name, command%goes_on, status, workers%count())
         if (.not. status%ok()) then
            call say_error('nutate: cannot write '//printable_path(name)//': '//trim(status%message), exit_code, &
                           merge(EXIT_OUTPUT, EXIT_INPUT, status%code == NUTATE_IO))
            return
         end if
         call watcher%start(wanted=.not. command%quiet)
         call workers%go(sweep, scene, watcher, status)
         call watcher%bar%erase()
         if (status%ok()) call write_listing(scene, sweep%layout, first, last, name, status)
         ! A complete file of rows means that the histories are complete, too.
         if (status%ok()) call write_histories(sweep%layout, watcher, only_missing=.false.)
         if (status%ok() .and. exit_code == EXIT_SUCCESS) then
            call sweep%close(status)
         else
            call sweep%abandon(closing)
         end if
         if (.not. status%ok()) then
            call give_up(sweep, status)
         else if (exit_code == EXIT_SUCCESS) then
            call finish_output(sweep%layout, first, last, watcher, sweep)
         end if
      end subroutine run_all

      !> Keeps a finished file, which must belong to this sweep, and adds histories that were not asked for before.
      subroutine keep_finished()
         type(row_layout_t) :: layout
         type(sweep_progress_t) :: watcher
         type(status_t) :: status
         if (.not. listing_fits(scene, first, last, name)) then
            exit_code = EXIT_INPUT
            call say_error('nutate: '//printable_path(name)//' is complete and belongs to another sweep, or '// &
                           printable_path(listing_name(name))// &
                           ' is missing (expected another --output, or no --resume)')
            return
         end if
         if (.not. command%quiet) call say_error(printable_path(name)//' is complete')
         call make_layout(scene, layout, status)
         if (status%ok()) call write_histories(layout, watcher, only_missing=.true.)
         if (.not. status%ok()) call say_error('nutate: '//trim(status%message), exit_code, EXIT_INPUT)
         if (exit_code /= EXIT_SUCCESS) return
         if (scene%ensemble%keeps_rows) then
            call finish_output(layout, first, last)
         else if (.not. any_succeeded(name)) then
            exit_code = EXIT_RUN
         end if
      end subroutine keep_finished

      !> Reports why a sweep ended early.
      subroutine give_up(sweep, status)
         type(sweep_t), intent(in) :: sweep
         type(status_t), intent(in) :: status
         if (status%code == NUTATE_STOPPED) then
            call say_error('nutate: '//printable_path(scene%file)//': stopped by '//signal_name()//'; '// &
                           count_text(sweep%members_done)//' of '//count_text(sweep%last - sweep%first + 1)// &
                           ' members are in '//printable_path(name)//'.partial ('//trim(workers%program)// &
                           ' sweep --resume continues)', exit_code, EXIT_SIGNAL + caught_signal())
         else if (status%code == NUTATE_IO) then
            call report_file(name, status, exit_code)
         else
            call say_error('nutate: '//trim(status%message), exit_code, EXIT_INPUT)
         end if
      end subroutine give_up

      !> Writes the histories that the scene requests, next to the rows.
      subroutine write_histories(layout, watcher, only_missing)
         type(row_layout_t), intent(in) :: layout
         type(sweep_progress_t), intent(inout) :: watcher
         !> Keep files that are there.
         logical, intent(in) :: only_missing
         type(status_t) :: status, reason
         integer(long) :: fields(layout%width()), member
         integer :: i
         do i = 1, size(scene%ensemble%histories)
            member = scene%ensemble%histories(i)
            if (member < first .or. member > last) cycle
            if (only_missing .and. file_exists(history_name(name, member))) cycle
            call write_member(scene, layout, member, history_name(name, member), watcher, fields, reason, status)
            if (status%ok()) cycle
            exit_code = EXIT_OUTPUT
            if (status%code == NUTATE_STOPPED) exit_code = EXIT_SIGNAL + caught_signal()
            call say_error('nutate: member '//count_text(member)//': '//trim(status%message)//' ('// &
                           trim(workers%program)//' sweep --resume continues)')
            return
         end do
      end subroutine write_histories

      !> Writes finished rows as CSV if requested, and shows their summary.
      subroutine finish_output(layout, first, last, watcher, sweep)
         type(row_layout_t), intent(in) :: layout
         integer(long), intent(in) :: first, last
         type(sweep_progress_t), intent(in), optional :: watcher
         type(sweep_t), intent(in), optional :: sweep
         type(status_t) :: status
         if (allocated(command%csv)) then
            call write_csv(name, layout, last - first + 1, command%csv, status)
            call report_file(command%csv, status, exit_code)
         end if
         if (.not. status%ok()) return
         call show_summary(scene, layout, last - first + 1, name, command%quiet, exit_code, watcher, sweep)
      end subroutine finish_output

      !> Merges the files of parts.
      subroutine merge_files()
         type(row_layout_t) :: layout
         type(status_t) :: status
         integer :: parts
         call merge_parts(scene, name, parts, status)
         if (status%ok()) then
            if (.not. command%quiet) call say_error(printable_path(name)//': merged from '// &
                                                    count_text(parts)//' files')
            call make_layout(scene, layout, status)
            call finish_output(layout, 1_long, scene%ensemble%members)
         else
            call say_error('nutate: cannot merge '//printable_path(name)//': '//trim(status%message), exit_code, &
                           merge(EXIT_OUTPUT, EXIT_INPUT, status%code == NUTATE_IO))
         end if
      end subroutine merge_files

      !> Runs one member with its whole history; its row goes to standard output.
      subroutine run_one()
         type(row_layout_t) :: layout
         type(sweep_progress_t) :: watcher
         type(decimal_t) :: decimal
         type(status_t) :: status, reason
         character(len=:), allocatable :: name
         integer(long), allocatable :: fields(:)
         call make_layout(scene, layout, status)
         name = single_name()
         allocate (fields(layout%width()))
         if (status%ok()) call write_member(scene, layout, command%member, name, watcher, fields, reason, status)
         if (.not. status%ok()) then
            exit_code = EXIT_OUTPUT
            if (status%code == NUTATE_STOPPED) exit_code = EXIT_SIGNAL + caught_signal()
            call say_error('nutate: '//trim(status%message))
            return
         end if
         call decimal%prepare()
         if (name /= '-') call write_text(STANDARD_OUTPUT, header_line(layout)//new_line('a')// &
                                          csv_line(layout, decimal, fields)//new_line('a'), status)
         if (.not. status%ok()) then
            call say_error('nutate: '//trim(status%message), exit_code, EXIT_OUTPUT)
         else if (.not. reason%ok()) then
            call say_error('nutate: member '//count_text(command%member)//': '//trim(reason%message), exit_code, &
               EXIT_RUN)
         end if
      end subroutine run_one

      !> Returns the path of the history of the member that is run alone.
      pure function single_name() result(name)
         character(len=:), allocatable :: name
         name = history_name(scene%ensemble%file, command%member)
         if (allocated(command%output)) name = command%output
      end function single_name

   end subroutine sweep_command

   !> Reads the scene, which must have an ensemble.
   subroutine read_ensemble(command, scene, message)
      type(command_t), intent(in) :: command
      type(scene_t), intent(out) :: scene
      !> Error message, in a line; blank on success.
      character(len=:), allocatable, intent(out) :: message
      type(status_t) :: status
      call read_scene_of(command, scene, status, message)
      if (.not. status%ok()) return
      scene%plan%max_steps = command%max_steps
      message = propagated_fault(scene)
      if (.not. scene%ensemble%active()) message = printable_path(scene%file)//': there is no group &ensemble '// &
                                                   '(expected it, with the number of members)'
   end subroutine read_ensemble

   !> Chooses the requested members and the file of their rows.
   subroutine choose_members(command, scene, first, last, name)
      type(command_t), intent(in) :: command
      !> Scene with an ensemble.
      type(scene_t), intent(in) :: scene
      integer(long), intent(out) :: first, last
      !> Path of the file.
      character(len=:), allocatable, intent(out) :: name
      first = 1
      last = scene%ensemble%members
      name = scene%ensemble%file
      if (command%first > 0) then
         first = command%first
         last = command%last
         name = part_name(name, first, last)
      end if
      if (allocated(command%output) .and. command%member == 0) name = command%output
   end subroutine choose_members

   !> Returns true for a file name with the ending of CSV.
   pure logical function ends_in_csv(name)
      character(len=*), intent(in) :: name
      ends_in_csv = .false.
      if (len(name) > 4) ends_in_csv = any(name(len(name) - 3:) == ['.csv', '.CSV'])
   end function ends_in_csv

   !> Returns the path of the history of a member.
   pure function history_name(name, member) result(history)
      !> Path of the rows.
      character(len=*), intent(in) :: name
      integer(long), intent(in) :: member
      character(len=:), allocatable :: history
      history = stem_of(name)//'.member'//count_text(member)//'.csv'
   end function history_name

end module nutate_sweep_command
