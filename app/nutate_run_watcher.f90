!> Observer of a run: progress on the terminal, and signals that end the run.
module nutate_run_watcher
   use, intrinsic :: iso_c_binding, only: c_int, c_ptr
   use nutate_byte_archive, only: byte_archive_t
   use nutate_console, only: count_text
   use nutate_decimal, only: rounded_text
   use nutate_event, only: event_t
   use nutate_event_history, only: event_history_t
   use nutate_files, only: is_terminal, write_text, STANDARD_ERROR
   use nutate_history, only: history_t
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: long, wp
   use nutate_observer, only: observer_t, run_record_t
   use nutate_run_checkpoint, only: checkpoint_t
   use nutate_run_plan, only: run_plan_t
   use nutate_state, only: state_t
   use nutate_status, only: fail, status_t, NUTATE_BAD_ARGUMENT, NUTATE_STEP_LIMIT, NUTATE_STOPPED
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: stop_watcher_t, watch_signals, caught_signal, signal_flag, signal_name, end_by_signal, check_signals, &
             progress_bar_t, run_watcher_t

   !> Observer that only ends runs on a signal.
   type, extends(observer_t) :: stop_watcher_t
   contains
      procedure :: poll => poll_signals
   end type stop_watcher_t

   interface
      !> Notes requests to stop from now on.
      subroutine watch_signals() bind(c, name='nutate_signals_watch')
      end subroutine watch_signals
      !> Returns the number of the signal that requested the stop; 0 for none.
      integer(c_int) function caught_signal() bind(c, name='nutate_signals_caught')
         import :: c_int
      end function caught_signal
      !> Returns the address of the number of the caught signal.
      type(c_ptr) function signal_flag() bind(c, name='nutate_signals_flag')
         import :: c_ptr
      end function signal_flag
      !> Ends the program by a signal, so that a shell sees what ended it.
      subroutine end_by_signal(number) bind(c, name='nutate_signals_end_by')
         import :: c_int
         integer(c_int), intent(in), value :: number
      end subroutine end_by_signal
   end interface

   !> Runs that end sooner show no bar, s.
   real(wp), parameter :: patience = 0.5_wp
   !> Least time between two updates of the bar, s.
   real(wp), parameter :: interval = 0.1_wp
   integer, parameter :: bar_width = 40
   !> Characters of the line with the bar.
   integer, parameter :: line_width = 76

   type :: progress_bar_t
      private
      logical :: enabled = .false.
      logical :: visible = .false.
      !> Label before the bar.
      character(len=24), public :: label = ''
      integer(long) :: started = 0, next = 0, rate = 1
   contains
      !> Starts the clock.
      procedure :: start => start_bar
      !> Updates the bar, if an update is due.
      procedure :: update
      !> Removes the bar.
      procedure :: erase
   end type progress_bar_t

   !> History of a run, with its events, invariants, progress bar and checkpoints.
   type, extends(history_t) :: run_watcher_t
      type(event_history_t) :: events
      type(invariants_t) :: invariants
      type(progress_bar_t) :: progress
      type(checkpoint_t) :: checkpoint
      !> Status of the last checkpoint.
      type(status_t) :: checkpoint_status
      !> True if the invariants are measured.
      logical :: measures = .false.
      !> Clock counts spent on rows, and clock counts in a second.
      integer(long) :: row_counts = 0, rate = 1
      !> Wall time of this run before it was interrupted, s.
      real(wp) :: seconds_before = 0.0_wp
      !> Limit of the rows of the history, and of those of the events.
      integer(long) :: max_rows = huge(1_long)
      !> Time of the last row written, s.
      real(wp) :: last_row = 0.0_wp
      real(wp), private :: t_first = 0.0_wp, duration = 0.0_wp
      !> Clock count at the start.
      integer(long), private :: started = 0
   contains
      !> Stores the first state; the history must be open.
      procedure :: start
      !> Restores the data that `save_checkpoint` wrote into an archive; after `start`.
      procedure :: resume => transfer_values
      !> Returns the wall time so far, s.
      procedure :: seconds
      procedure :: observe => write_row
      procedure :: poll => poll
      procedure :: observe_event => write_event
      procedure :: save_checkpoint => write_checkpoint
   end type run_watcher_t

contains

   !> Returns `NUTATE_STOPPED` if a signal has requested the stop.
   subroutine check_signals(status)
      type(status_t), intent(inout) :: status
      if (caught_signal() /= 0) status = fail(NUTATE_STOPPED, 'it was stopped by '//signal_name())
   end subroutine check_signals

   !> Returns the name of the signal that requested the stop.
   function signal_name() result(name)
      character(len=:), allocatable :: name
      select case (caught_signal())
      case (1)
         name = 'SIGHUP'
      case (2)
         name = 'SIGINT'
      case (15)
         name = 'SIGTERM'
      case default
         name = 'signal '//count_text(int(caught_signal()))
      end select
   end function signal_name

   subroutine poll_signals(self, fraction, status)
      class(stop_watcher_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      call check_signals(status)
   end subroutine poll_signals

   !> Starts the clock.
   subroutine start_bar(self, wanted)
      class(progress_bar_t), intent(inout) :: self
      logical, intent(in) :: wanted
      self%enabled = wanted
      if (wanted) self%enabled = is_terminal(STANDARD_ERROR)
      call system_clock(self%started, self%rate)
      self%next = self%started + int(patience*real(self%rate, wp), long)
   end subroutine start_bar

   !> Updates the bar, if an update is due.
   subroutine update(self, fraction, now)
      class(progress_bar_t), intent(inout) :: self
      !> Fraction of the run that is done, 0 to 1.
      real(wp), intent(in) :: fraction
      !> Count of the system clock.
      integer(long), intent(in) :: now
      type(status_t) :: status
      real(wp) :: elapsed

      if (.not. self%enabled) return
      if (now < self%next) return
      self%next = now + int(interval*real(self%rate, wp), long)
      self%visible = .true.
      elapsed = real(now - self%started, wp)/real(self%rate, wp)
      call write_text(STANDARD_ERROR, achar(13)//picture(trim(self%label), min(max(fraction, 0.0_wp), 1.0_wp), &
                                                         elapsed), status)
   end subroutine update

   !> Returns the bar, the part done and, for a bar without label, the time left; shape: `line_width` characters.
   pure function picture(label, fraction, elapsed) result(line)
      character(len=*), intent(in) :: label
      real(wp), intent(in) :: fraction
      !> Time since the start, s.
      real(wp), intent(in) :: elapsed
      character(len=line_width) :: line
      character(len=:), allocatable :: left
      integer :: filled
      filled = int(bar_width*fraction)
      left = ''
      if (fraction > 0.01_wp .and. label == '') left = ', '//rounded_text(elapsed*(1 - fraction)/fraction, 2)//' s left'
      line = label//repeat(' ', min(len(label), 1))//'['//repeat('#', filled)//repeat('.', bar_width - filled)//'] '// &
             count_text(int(100*fraction))//' %'//left
   end function picture

   !> Removes the bar.
   subroutine erase(self)
      class(progress_bar_t), intent(inout) :: self
      type(status_t) :: status
      if (self%visible) call write_text(STANDARD_ERROR, achar(13)//repeat(' ', line_width)//achar(13), status)
      self%visible = .false.
      self%enabled = .false.
   end subroutine erase

   !> Stores the first state; the history must be open.
   subroutine start(self, system, state, plan, settings, quiet)
      class(run_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_plan_t), intent(in) :: plan
      type(integrator_settings_t), intent(in) :: settings
      !> True for no progress bar, and no invariants unless there are checkpoints: a resumed run may show them.
      logical, intent(in) :: quiet
      self%saves_at_step_limit = self%checkpoint%is_wanted()
      ! The first checkpoint is written at the start, so that a file that cannot be written is reported there.
      self%wants_checkpoint = self%saves_at_step_limit
      self%t_first = state%t
      self%duration = plan%end_time - state%t
      self%measures = .not. quiet .or. self%saves_at_step_limit
      if (self%measures) call self%invariants%start(system, state, settings%inverse_auxiliary_inertia, &
                                                      settings%attitude)
      call system_clock(self%started, self%rate)
      call self%progress%start(wanted=.not. quiet)
   end subroutine start

   !> Writes or reads the data kept from row to row, without those of the history, which are first in an archive.
   subroutine transfer_values(self, archive)
      class(run_watcher_t), intent(inout) :: self
      type(byte_archive_t), intent(inout) :: archive
      real(wp) :: row_seconds
      call self%invariants%transfer(archive)
      call archive%transfer(self%last_row)
      row_seconds = real(self%row_counts, wp)/real(self%rate, wp)
      call archive%transfer(row_seconds)
      self%row_counts = int(row_seconds*real(self%rate, wp), long)
      self%seconds_before = self%seconds()
      call archive%transfer(self%seconds_before)
      call system_clock(self%started)
   end subroutine transfer_values

   !> Returns the wall time so far, s, with the time before an interruption.
   real(wp) function seconds(self)
      class(run_watcher_t), intent(in) :: self
      integer(long) :: now
      call system_clock(now)
      seconds = self%seconds_before + real(now - self%started, wp)/real(self%rate, wp)
   end function seconds

   !> Writes a row and measures the invariants. Errors: those of the history; `NUTATE_STEP_LIMIT` beyond `max_rows`.
   subroutine write_row(self, system, state, record, status)
      class(run_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      integer(long) :: before, after

      if (self%rows >= self%max_rows) then
         status = fail(NUTATE_STEP_LIMIT, 'the history needs more rows than allowed')
         return
      end if
      call system_clock(before)
      call self%history_t%observe(system, state, record, status)
      if (status%ok()) self%last_row = state%t
      if (self%measures .and. status%ok()) call self%invariants%measure(system, state, record%work)
      call system_clock(after)
      self%row_counts = self%row_counts + (after - before)
      if (abs(self%duration) > 0.0_wp) call self%progress%update((state%t - self%t_first)/self%duration, after)
   end subroutine write_row

   !> Shows the progress if rows are rare, requests a checkpoint when it is due, and ends the run on a signal.
   subroutine poll(self, fraction, status)
      class(run_watcher_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      integer(long) :: now
      call system_clock(now)
      call self%progress%update(fraction, now)
      call check_signals(status)
      self%wants_checkpoint = self%checkpoint%is_due(now) .or. (self%saves_at_step_limit .and. .not. status%ok())
   end subroutine poll

   !> Writes an event. Errors: those of the file; `NUTATE_STEP_LIMIT` beyond `max_rows`.
   subroutine write_event(self, system, event, which, number, state, record, status)
      class(run_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer, intent(in) :: which
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
      if (self%events%rows >= self%max_rows) then
         status = fail(NUTATE_STEP_LIMIT, 'the file of the events needs more rows than allowed')
         return
      end if
      if (self%measures) call self%invariants%measure(system, state, record%work)
      call self%events%write(self%history_t, system, trim(event%name), number, state, record, status)
   end subroutine write_event

   !> Writes a checkpoint: the rows so far to the disk, then the data to continue. Errors: `NUTATE_IO`; for a method
   !> that cannot be archived `NUTATE_BAD_ARGUMENT`.
   subroutine write_checkpoint(self, archive, status)
      class(run_watcher_t), intent(inout) :: self
      type(byte_archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      type(byte_archive_t) :: outer
      character(len=:), allocatable :: inner
      if (archive%problem() /= '') then
         status = fail(NUTATE_BAD_ARGUMENT, archive%problem())
      else
         call outer%begin_writing()
         call self%transfer(outer, status)
         if (status%ok()) call self%events%transfer(outer, status)
      end if
      if (status%ok()) then
         call transfer_values(self, outer)
         inner = archive%content()
         call outer%transfer(inner)
         call self%checkpoint%write(outer%content(), status)
      end if
      self%checkpoint_status = status
   end subroutine write_checkpoint

end module nutate_run_watcher
