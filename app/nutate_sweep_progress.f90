!> Observer of running members: shows a progress bar, and ends the sweep on a signal.
module nutate_sweep_progress
   use nutate_kinds, only: wp, long
   use nutate_run_progress, only: progress_bar_t
   use nutate_run_signals, only: caught_signal
   use nutate_sweep_watcher, only: sweep_watcher_t
   implicit none
   private

   public :: sweep_progress_t

   type, extends(sweep_watcher_t) :: sweep_progress_t
      type(progress_bar_t) :: bar
      !> Number of members that were done at the start.
      integer(long) :: before = -1
      integer(long), private :: started = 0, rate = 1
   contains
      !> Starts the clock.
      procedure :: start
      !> Returns the wall time since the start, s.
      procedure :: seconds
      procedure :: wants_end
      procedure :: report
   end type sweep_progress_t

contains

   !> Starts the clock.
   subroutine start(self, wanted)
      class(sweep_progress_t), intent(inout) :: self
      !> True if a progress bar is wanted.
      logical, intent(in) :: wanted
      call system_clock(self%started, self%rate)
      call self%bar%start(wanted)
   end subroutine start

   !> Returns the wall time since the start, s.
   real(wp) function seconds(self)
      class(sweep_progress_t), intent(in) :: self
      integer(long) :: now
      call system_clock(now)
      seconds = real(now - self%started, wp)/real(self%rate, wp)
   end function seconds

   logical function wants_end(self)
      class(sweep_progress_t), intent(in) :: self
      wants_end = caught_signal() /= 0
   end function wants_end

   subroutine report(self, done, members)
      class(sweep_progress_t), intent(inout) :: self
      integer(long), intent(in) :: done, members
      integer(long) :: now
      if (self%before < 0) self%before = done
      call system_clock(now)
      call self%bar%update(real(done, wp)/real(members, wp), now)
   end subroutine report

end module nutate_sweep_progress
