!> Who looks on while the members of an ensemble run.
module nutate_sweep_watcher
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: long
   use nutate_status, only: status_t
   implicit none
   private

   public :: sweep_watcher_t

   !> Looks on. A program extends it by what it does with what it sees.
   type :: sweep_watcher_t
   contains
      !> True if the sweep is to end; asked by several threads at once.
      procedure :: wants_end => never
      !> Told how many members are done, of how many; by one thread at a time.
      procedure :: report => ignore
      !> Prepares the effects of a member for what `check` looks at; called by the thread that runs the member.
      procedure :: prepare => leave_effects
      !> Looks whether a user-defined effect has failed in the member that the thread runs. Errors: as the program says.
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
