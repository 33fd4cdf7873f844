!> Wall time since a start, and the time at which work must be over.
module nutate_stopwatch
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: stopwatch_t

   type :: stopwatch_t
      integer(long), private :: started = 0, rate = 1
      !> Time since the start at which work must be over, s.
      real(wp) :: deadline = huge(1.0_wp)
   contains
      !> Starts from zero.
      procedure :: start
      !> Time since the start, s.
      procedure :: seconds
      !> The deadline has passed.
      procedure :: is_over
   end type stopwatch_t

contains

   !> Starts from zero.
   subroutine start(self)
      class(stopwatch_t), intent(inout) :: self
      call system_clock(self%started, self%rate)
   end subroutine start

   !> Time since the start, s.
   real(wp) function seconds(self)
      class(stopwatch_t), intent(in) :: self
      integer(long) :: now
      call system_clock(now)
      seconds = real(now - self%started, wp)/real(self%rate, wp)
   end function seconds

   !> True once the deadline has passed; without one the clock is not read.
   logical function is_over(self)
      class(stopwatch_t), intent(in) :: self
      is_over = self%deadline < huge(1.0_wp)
      if (is_over) is_over = self%seconds() > self%deadline
   end function is_over

end module nutate_stopwatch
