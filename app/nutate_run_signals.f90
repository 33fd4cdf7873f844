!> Signals that ask the program to stop: SIGINT, SIGTERM and SIGHUP.
!>
!> The first is noted and seen by the next `poll` of a run, which then ends in order; another one more than 0.2 s later
!> kills at once.
module nutate_run_signals
   use, intrinsic :: iso_c_binding, only: c_int, c_ptr
   use nutate_kinds, only: wp
   use nutate_observer, only: observer_t
   use nutate_status, only: status_t, fail, NUTATE_STOPPED
   implicit none
   private

   public :: stop_watcher_t, watch_signals, caught_signal, signal_flag, signal_name, end_by_signal, check_signals

   !> Ends runs without any other observer on a signal.
   type, extends(observer_t) :: stop_watcher_t
   contains
      procedure :: poll => poll_signals
   end type stop_watcher_t

   interface
      !> Notes requests to stop from now on.
      subroutine watch_signals() bind(c, name='nutate_signals_watch')
      end subroutine watch_signals
      !> Number of the signal that asked to stop; 0 for none.
      integer(c_int) function caught_signal() bind(c, name='nutate_signals_caught')
         import :: c_int
      end function caught_signal
      !> Where that number stands.
      type(c_ptr) function signal_flag() bind(c, name='nutate_signals_flag')
         import :: c_ptr
      end function signal_flag
      !> Ends the program by a signal, so that a shell sees what ended it.
      subroutine end_by_signal(number) bind(c, name='nutate_signals_end_by')
         import :: c_int
         integer(c_int), intent(in), value :: number
      end subroutine end_by_signal
   end interface

contains

   !> `NUTATE_STOPPED` if a signal has asked to stop.
   subroutine check_signals(status)
      type(status_t), intent(inout) :: status
      if (caught_signal() /= 0) status = fail(NUTATE_STOPPED, 'it was stopped by '//signal_name())
   end subroutine check_signals

   !> The name of the signal that asked to stop.
   function signal_name() result(name)
      character(len=:), allocatable :: name
      character(len=12) :: number
      select case (caught_signal())
      case (1)
         name = 'SIGHUP'
      case (2)
         name = 'SIGINT'
      case (15)
         name = 'SIGTERM'
      case default
         write (number, '(i0)') caught_signal()
         name = 'signal '//trim(number)
      end select
   end function signal_name

   subroutine poll_signals(self, fraction, status)
      class(stop_watcher_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      call check_signals(status)
   end subroutine poll_signals

end module nutate_run_signals
