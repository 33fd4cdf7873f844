!> Events of a run at limits of motors and controllers. Each ends a step, so that methods keep their order, and is
!> settled before the next one.
module nutate_limit_event
   use nutate_event, only: event_t
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: limit_event_t

   !> Action of an event: an effect reaches a limit, or leaves it.
   integer, parameter, public :: SWITCH_LIMIT = 4

   !> Event: an effect reaches a limit, or leaves it.
   type, abstract, extends(event_t) :: limit_event_t
      !> Description for messages; the summary of a run lists only events with a `name`.
      character(len=64) :: words = ''
   contains
      !> Returns the side of its level on which the quantity is, as recorded in the system; 0: not recorded.
      procedure :: side_held => no_side
      !> Updates the system for the motion after the event.
      procedure(settle_limit), deferred :: settle
   end type limit_event_t

   abstract interface
      !> Updates a system for the motion after the event.
      pure subroutine settle_limit(self, system, state)
         import :: limit_event_t, state_t, system_t
         class(limit_event_t), intent(in) :: self
         type(system_t), intent(inout) :: system
         !> State at the event.
         type(state_t), intent(in) :: state
      end subroutine settle_limit
   end interface

contains

   pure integer function no_side(self, system)
      class(limit_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      no_side = 0
   end function no_side

end module nutate_limit_event
