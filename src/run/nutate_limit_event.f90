!> Events of a run that limits make, those of motors and controllers. Each ends a step, so that methods keep their
!> order, and is settled before the next one.
module nutate_limit_event
   use nutate_event, only: event_t
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: limit_event_t, limit_slot_t

   !> What becomes of an effect: it comes to a limit, or leaves it.
   integer, parameter, public :: SWITCH_LIMIT = 4

   !> Something comes to a limit, or leaves it.
   type, abstract, extends(event_t) :: limit_event_t
      !> What it is in messages; the summary of a run lists those with a `name`.
      character(len=64) :: words = ''
   contains
      !> The side of its level on which the quantity is, as the system has it; 0: the system does not know.
      procedure :: side_held => no_side
      !> Makes the system what it is from there on.
      procedure(settle_limit), deferred :: settle
   end type limit_event_t

   !> Holds one of them.
   type :: limit_slot_t
      class(limit_event_t), allocatable :: item
   end type limit_slot_t

   abstract interface
      !> Makes a system what it is behind the event.
      pure subroutine settle_limit(self, system, state)
         import :: limit_event_t, state_t, system_t
         class(limit_event_t), intent(in) :: self
         type(system_t), intent(inout) :: system
         !> At the event.
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
