!> Wall time since a start.
module nutate_stopwatch
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: stopwatch_t

   type :: stopwatch_t
      !> Count of the system's clock at the start, and counts in a second.
      integer(long), private :: started = 0, rate = 1
   contains
      !> Starts from zero.
      procedure :: start
      !> Returns the time since the start, s.
      procedure :: seconds
   end type stopwatch_t

contains

   !> Starts from zero.
   subroutine start(self)
      class(stopwatch_t), intent(inout) :: self
      call system_clock(self%started, self%rate)
   end subroutine start

   !> Returns the time since the start, s.
   real(wp) function seconds(self)
      class(stopwatch_t), intent(in) :: self
      integer(long) :: now
      call system_clock(now)
      seconds = real(now - self%started, wp)/real(self%rate, wp)
   end function seconds

end module nutate_stopwatch
