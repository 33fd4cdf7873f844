!> Signals that request a stop of the program: SIGINT, SIGTERM and SIGHUP.
!>
!> The first signal is noted. The next `poll` of a run detects it, and the run ends in order. Another signal more than
!> 0.2 s later kills the program at once.
module nutate_run_signals
   use, intrinsic :: iso_c_binding, only: c_int, c_ptr
   use nutate_kinds, only: wp
   use nutate_observer, only: observer_t
   use nutate_status, only: status_t, fail, NUTATE_STOPPED
   implicit none
   private

   public :: stop_watcher_t, watch_signals, caught_signal, signal_flag, signal_name, end_by_signal, check_signals

   !> Observer that only ends runs on a signal.
   type, extends(observer_t) :: stop_watcher_t
   contains
      procedure :: poll => poll_signals
   end type stop_watcher_t

   interface
      !> Notes requests to stop from now on.
      subroutine watch_signals() bind(c, name='nutate_signals_watch')
      end subroutine watch_signals
      !> Returns the number of the signal that requested the stop; 0 for none.
      integer(c_int) function caught_signal() bind(c, name='nutate_signals_caught')
         import :: c_int
      end function caught_signal
      !> Returns the address of the number of the caught signal.
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

   !> Returns `NUTATE_STOPPED` if a signal has requested the stop.
   subroutine check_signals(status)
      type(status_t), intent(inout) :: status
      if (caught_signal() /= 0) status = fail(NUTATE_STOPPED, 'it was stopped by '//signal_name())
   end subroutine check_signals

   !> Returns the name of the signal that requested the stop.
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
