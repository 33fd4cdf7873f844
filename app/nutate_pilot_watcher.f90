!> What looks on while pilot runs find the steps of a run: a progress bar for each of them, and signals.
module nutate_pilot_watcher
   use nutate_console, only: count_text
   use nutate_kinds, only: wp, long
   use nutate_observer, only: run_record_t
   use nutate_run_progress, only: progress_bar_t
   use nutate_run_signals, only: check_signals, stop_watcher_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: pilot_watcher_t

   type, extends(stop_watcher_t) :: pilot_watcher_t
      type(progress_bar_t) :: progress
      !> Pilot runs so far, that under way included.
      integer(long), private :: runs = 0
      !> Start and length of each run, s.
      real(wp), private :: t_first = 0.0_wp, duration = 0.0_wp
   contains
      !> Starts the clock.
      procedure :: start
      procedure :: observe => count_run
      procedure :: poll => look_up
   end type pilot_watcher_t

contains

   !> Starts the clock.
   subroutine start(self, t_first, end_time, wanted)
      class(pilot_watcher_t), intent(inout) :: self
      !> Start and end of each run, s.
      real(wp), intent(in) :: t_first, end_time
      !> A progress bar is wanted.
      logical, intent(in) :: wanted
      self%t_first = t_first
      self%duration = end_time - t_first
      call self%progress%start(wanted)
   end subroutine start

   !> Takes the first state of a run for a new run.
   subroutine count_run(self, system, state, record, status)
      class(pilot_watcher_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
      if (abs(state%t - self%t_first) > 0.5_wp*abs(self%duration)) return
      self%runs = self%runs + 1
      call self%progress%name('pilot run '//count_text(self%runs))
   end subroutine count_run

   !> Shows the progress, and ends the runs on a signal.
   subroutine look_up(self, fraction, status)
      class(pilot_watcher_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      integer(long) :: now
      call system_clock(now)
      call self%progress%update(fraction, now)
      call check_signals(status)
   end subroutine look_up

end module nutate_pilot_watcher
