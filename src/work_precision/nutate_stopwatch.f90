!> Time since a start, and the time at which work must be over: wall time, or that of another clock.
module nutate_stopwatch
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: clock_t, stopwatch_t

   !> A clock that follows what a program wants it to.
   type, abstract :: clock_t
   contains
      !> Time, s.
      procedure(read_clock), deferred :: time
   end type clock_t

   abstract interface
      !> Time, s.
      real(wp) function read_clock(self)
         import :: clock_t, wp
         class(clock_t), intent(inout) :: self
      end function read_clock
   end interface

   type :: stopwatch_t
      !> Where associated, the clock to go by; otherwise it follows wall time.
      class(clock_t), pointer :: clock => null()
      integer(long), private :: started = 0, rate = 1
      !> The clock's time at the start, s.
      real(wp), private :: begun = 0.0_wp
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
      if (associated(self%clock)) then
         self%begun = self%clock%time()
      else
         call system_clock(self%started, self%rate)
      end if
   end subroutine start

   !> Time since the start, s.
   real(wp) function seconds(self)
      class(stopwatch_t), intent(in) :: self
      integer(long) :: now
      if (associated(self%clock)) then
         seconds = self%clock%time() - self%begun
      else
         call system_clock(now)
         seconds = real(now - self%started, wp)/real(self%rate, wp)
      end if
   end function seconds

   !> True once the deadline has passed; without one the clock is not read.
   logical function is_over(self)
      class(stopwatch_t), intent(in) :: self
      is_over = self%deadline < huge(1.0_wp)
      if (is_over) is_over = self%seconds() > self%deadline
   end function is_over

end module nutate_stopwatch
