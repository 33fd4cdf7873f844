!> Observer of the run of a scene: writes the history, measures the invariants for the summary, shows the progress bar,
!> writes checkpoints, and ends the run on signals.
module nutate_run_watcher
   use nutate_byte_archive, only: byte_archive_t
   use nutate_run_checkpoint, only: checkpoint_t
   use nutate_event, only: event_t
   use nutate_event_history, only: event_history_t
   use nutate_history, only: history_t
   use nutate_invariants, only: invariants_t
   use nutate_kinds, only: wp, long
   use nutate_run_progress, only: progress_bar_t
   use nutate_observer, only: run_record_t
   use nutate_run_plan, only: run_plan_t
   use nutate_run_signals, only: check_signals
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_stepper, only: integrator_settings_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: run_watcher_t

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
      !> Time of the last row written, s.
      real(wp) :: last_row = 0.0_wp
      real(wp), private :: t_first = 0.0_wp, duration = 0.0_wp
      !> Clock count at the start.
      integer(long), private :: started = 0
   contains
      !> Stores the first state; the history must be open.
      procedure :: start
      !> Restores the data that `save_checkpoint` wrote into an archive; after `start`.
      procedure :: resume
      !> Returns the wall time so far, s.
      procedure :: seconds
      procedure :: observe => write_row
      procedure :: poll => poll
      procedure :: observe_event => write_event
      procedure :: save_checkpoint => write_checkpoint
   end type run_watcher_t

contains

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

   !> Restores the data that `save_checkpoint` wrote into an archive; after `start`.
   subroutine resume(self, archive)
      class(run_watcher_t), intent(inout) :: self
      !> Archive that is being read.
      type(byte_archive_t), intent(inout) :: archive
      call transfer_values(self, archive)
   end subroutine resume

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

   !> Writes a row and measures the invariants. Errors: those of the history.
   subroutine write_row(self, system, state, record, status)
      class(run_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      integer(long) :: before, after

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

   !> Writes an event. Errors: those of the file.
   subroutine write_event(self, system, event, which, number, state, record, status)
      class(run_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      class(event_t), intent(in) :: event
      integer, intent(in) :: which
      integer(long), intent(in) :: number
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(inout) :: status
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
