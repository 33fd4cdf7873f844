!> What looks on while a scene is run: the history, the invariants for the summary, the progress bar, checkpoints, and
!> signals that ask for the end.
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

   !> The history of a run, with what else watches it.
   type, extends(history_t) :: run_watcher_t
      type(event_history_t) :: events
      type(invariants_t) :: invariants
      type(progress_bar_t) :: progress
      type(checkpoint_t) :: checkpoint
      !> What the last checkpoint came to.
      type(status_t) :: checkpoint_status
      !> The invariants are wanted.
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
      !> Restores what `save_checkpoint` put in an archive; after `start`.
      procedure :: resume
      !> Wall time so far, s.
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
      !> No progress bar; no invariants, unless there are checkpoints: the run that is resumed may show them.
      logical, intent(in) :: quiet
      self%saves_at_step_limit = self%checkpoint%is_wanted()
      ! At once, so that what cannot be written is known at the start.
      self%wants_checkpoint = self%saves_at_step_limit
      self%t_first = state%t
      self%duration = plan%end_time - state%t
      self%measures = .not. quiet .or. self%saves_at_step_limit
      if (self%measures) call self%invariants%start(system, state, settings%inverse_auxiliary_inertia, &
                                                      settings%attitude)
      call system_clock(self%started, self%rate)
      call self%progress%start(wanted=.not. quiet)
   end subroutine start

   !> Restores what `save_checkpoint` put in an archive; after `start`.
   subroutine resume(self, archive)
      class(run_watcher_t), intent(inout) :: self
      !> Being read.
      type(byte_archive_t), intent(inout) :: archive
      call transfer_values(self, archive)
   end subroutine resume

   !> What lives from row to row beside the history, which is first in an archive.
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

   !> Wall time so far, that before an interruption included, s.
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

   !> Shows the progress where rows are rare, asks for a checkpoint when it is time, and ends the run on a signal.
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

   !> Writes a checkpoint: the rows so far to the disk, then what is needed to go on. Errors: `NUTATE_IO`; for a method
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
