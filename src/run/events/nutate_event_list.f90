!> List of the events of a run.
module nutate_event_list
   use nutate_event, only: event_t
   implicit none
   private

   public :: event_list_t

   !> Holds one event.
   type, private :: event_slot_t
      class(event_t), allocatable :: item
   end type event_slot_t

   !> The events of a run.
   type :: event_list_t
      type(event_slot_t), allocatable :: slots(:)
   contains
      !> Adds a copy of an event.
      procedure :: add => add_event
      !> Returns the number of events.
      procedure :: count => count_events
   end type event_list_t

contains

   !> Adds a copy of an event.
   subroutine add_event(self, event)
      class(event_list_t), intent(inout) :: self
      class(event_t), intent(in) :: event
      type(event_slot_t), allocatable :: grown(:)
      integer :: i
      allocate (grown(self%count() + 1))
      do i = 1, self%count()
         call move_alloc(self%slots(i)%item, grown(i)%item)
      end do
      allocate (grown(self%count() + 1)%item, source=event)
      call move_alloc(grown, self%slots)
   end subroutine add_event

   !> Returns the number of events.
   pure integer function count_events(self)
      class(event_list_t), intent(in) :: self
      count_events = 0
      if (allocated(self%slots)) count_events = size(self%slots)
   end function count_events

end module nutate_event_list
