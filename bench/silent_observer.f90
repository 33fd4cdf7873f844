!> An observer that looks away: a run costs what its steps cost.
module silent_observer
   use nutate, only: observer_t, run_record_t, state_t, status_t, system_t
   implicit none
   private

   public :: silent_t

   !> Does nothing with any row.
   type, extends(observer_t) :: silent_t
   contains
      procedure :: observe => look_away
   end type silent_t

contains

   subroutine look_away(self, system, state, record, status)
      class(silent_t), intent(inout) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(run_record_t), intent(in) :: record
      type(status_t), intent(out) :: status
   end subroutine look_away

end module silent_observer
