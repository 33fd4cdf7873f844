!> An observer that ends its run at a poll and keeps the checkpoint.
module test_stopping_observer
   use nutate_byte_archive, only: byte_archive_t
   use nutate_kinds, only: wp
   use nutate_observer, only: observer_t
   use nutate_status, only: status_t, fail, NUTATE_STOPPED
   implicit none
   private

   public :: stopping_observer_t

   type, abstract, extends(observer_t) :: stopping_observer_t
      !> Polls so far, and the one that ends the run; 0: none.
      integer :: polls = 0, stops_at = 0
      character(len=:), allocatable :: archive
   contains
      procedure :: poll => count_poll
      procedure :: save_checkpoint => keep_archive
   end type stopping_observer_t

contains

   subroutine count_poll(self, fraction, status)
      class(stopping_observer_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      self%polls = self%polls + 1
      if (self%polls /= self%stops_at) return
      self%wants_checkpoint = .true.
      status = fail(NUTATE_STOPPED, 'asked to')
   end subroutine count_poll

   subroutine keep_archive(self, archive, status)
      class(stopping_observer_t), intent(inout) :: self
      type(byte_archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      self%archive = archive%content()
   end subroutine keep_archive

end module test_stopping_observer
