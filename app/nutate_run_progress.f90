!> Progress bar on standard error: shown only on a terminal, and only if a run is long.
module nutate_run_progress
   use nutate_console, only: count_text
   use nutate_decimal, only: rounded_text
   use nutate_files, only: is_terminal, write_text, STANDARD_ERROR
   use nutate_kinds, only: wp, long
   use nutate_status, only: status_t
   implicit none
   private

   public :: progress_bar_t

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
      character(len=24) :: label = ''
      integer(long) :: started = 0, next = 0, rate = 1
   contains
      !> Starts the clock.
      procedure :: start
      !> Sets the label of the bar.
      procedure :: name
      !> Updates the bar, if an update is due.
      procedure :: update
      !> Removes the bar.
      procedure :: erase
   end type progress_bar_t

contains

   !> Starts the clock.
   subroutine start(self, wanted)
      class(progress_bar_t), intent(inout) :: self
      logical, intent(in) :: wanted
      self%enabled = wanted
      if (wanted) self%enabled = is_terminal(STANDARD_ERROR)
      call system_clock(self%started, self%rate)
      self%next = self%started + int(patience*real(self%rate, wp), long)
   end subroutine start

   !> Sets the label of the bar.
   subroutine name(self, label)
      class(progress_bar_t), intent(inout) :: self
      character(len=*), intent(in) :: label
      self%label = label
   end subroutine name

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
             count_text(int(100*fraction, long))//' %'//left
   end function picture

   !> Removes the bar.
   subroutine erase(self)
      class(progress_bar_t), intent(inout) :: self
      type(status_t) :: status
      if (self%visible) call write_text(STANDARD_ERROR, achar(13)//repeat(' ', line_width)//achar(13), status)
      self%visible = .false.
      self%enabled = .false.
   end subroutine erase

end module nutate_run_progress
