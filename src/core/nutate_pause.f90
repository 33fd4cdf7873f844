!> A thread that waits and lets others work.
module nutate_pause
   use, intrinsic :: iso_c_binding, only: c_int
   use nutate_kinds, only: wp
   implicit none
   private

   public :: pause_thread

   interface
      !> Of POSIX.
      integer(c_int) function usleep(microseconds) bind(c, name='usleep')
         import :: c_int
         implicit none
         integer(c_int), value :: microseconds
      end function usleep
   end interface

contains

   !> Waits for some time, or until a signal comes.
   subroutine pause_thread(seconds)
      !> Below 1.
      real(wp), intent(in) :: seconds
      if (usleep(int(1e6_wp*seconds, c_int)) /= 0) return
   end subroutine pause_thread

end module nutate_pause
