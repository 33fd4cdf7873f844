!> Number of times that the command of a controller has reached a limit.
module nutate_saturation_count
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp
   implicit none
   private

   public :: saturation_count_t, side_of_limit, transfer_integers
   public :: note_saturation, transfer_count
   public :: number_at

   !> Counts components that reach their limit while the controller acts; a component that stays there is counted once.
   type :: saturation_count_t
      !> Number of times so far.
      integer :: number = 0
      !> 1: a component has been counted at its limit; -1: at the negative limit; 0: neither.
      integer, private :: side(3) = 0
      !> Time of the last call of `note`, s.
      real(wp), private :: since = 0.0_wp
   end type saturation_count_t

contains

   !> Counts components that have reached their limit: to be called with the sides until now, and with the sides from
   !> now on.
   pure subroutine note_saturation(self, t, side, on, start, stop)
      type(saturation_count_t), intent(inout) :: self
      !> Present time, s.
      real(wp), intent(in) :: t
      !> Side of each component, 1: at the limit; -1: at the negative limit; 0: neither; shape (3).
      integer, intent(in) :: side(3)
      !> True if the controller is on; start and stop of its window, s.
      logical, intent(in) :: on
      real(wp), intent(in) :: start, stop
      integer :: now(3)
      now = 0
      if (on .and. start <= max(t, self%since) .and. stop >= min(t, self%since)) now = side
      self%number = self%number + count(now /= 0 .and. now /= self%side)
      self%side = now
      self%since = t
   end subroutine note_saturation

   !> Returns the number, with components that would be counted now.
   pure integer function number_at(self, t, side, on, start, stop)
      type(saturation_count_t), intent(in) :: self
      !> Arguments as in `note`.
      real(wp), intent(in) :: t
      integer, intent(in) :: side(3)
      logical, intent(in) :: on
      real(wp), intent(in) :: start, stop
      type(saturation_count_t) :: copy
      copy = self
      call note_saturation(copy, t, side, on, start, stop)
      number_at = copy%number
   end function number_at

   !> Writes or reads its values in checkpoint data.
   subroutine transfer_count(self, archive)
      type(saturation_count_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%number)
      call transfer_integers(self%side, archive)
      call archive%transfer(self%since)
   end subroutine transfer_count

   !> Writes or reads integers in checkpoint data.
   subroutine transfer_integers(values, archive)
      integer, intent(inout) :: values(:)
      class(archive_t), intent(inout) :: archive
      integer :: i
      do i = 1, size(values)
         call archive%transfer(values(i))
      end do
   end subroutine transfer_integers

   !> Returns 1 for an amount at its limit or above; -1 for one at the negative limit or below; 0 for others.
   elemental integer function side_of_limit(amount, limit) result(side)
      real(wp), intent(in) :: amount, limit
      side = 0
      if (abs(amount) >= limit) side = nint(sign(1.0_wp, amount))
   end function side_of_limit

end module nutate_saturation_count
