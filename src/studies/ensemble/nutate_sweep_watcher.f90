!> Watcher of an ensemble while its members run.
module nutate_sweep_watcher
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: long
   use nutate_status, only: status_t
   implicit none
   private

   public :: sweep_watcher_t

   !> Watcher that does nothing. A program extends it to report progress, to stop the sweep, and to detect failures.
   type :: sweep_watcher_t
   contains
      !> Returns true if the sweep is to end; called by several threads at once.
      procedure :: wants_end => never
      !> Receives the number of members done, and of all members; called by one thread at a time.
      procedure :: report => ignore
      !> Prepares the effects of a member for `check`; called by the thread that runs the member.
      procedure :: prepare => leave_effects
      !> Reports the failure of a user-defined effect in the member that the thread runs. Errors: those of the program.
      procedure :: check => find_no_failure
   end type sweep_watcher_t

contains

   logical function never(self)
      class(sweep_watcher_t), intent(in) :: self
      never = .false.
   end function never

   subroutine ignore(self, done, members)
      class(sweep_watcher_t), intent(inout) :: self
      integer(long), intent(in) :: done, members
   end subroutine ignore

   subroutine leave_effects(self, effects)
      class(sweep_watcher_t), intent(in) :: self
      type(effect_list_t), intent(inout) :: effects
   end subroutine leave_effects

   subroutine find_no_failure(self, status)
      class(sweep_watcher_t), intent(in) :: self
      type(status_t), intent(out) :: status
   end subroutine find_no_failure

end module nutate_sweep_watcher
