!> Who looks on while the members of an ensemble run.
module nutate_sweep_watcher
   use nutate_kinds, only: long
   implicit none
   private

   public :: sweep_watcher_t

   !> Looks on. A program extends it by what it does with what it sees.
   type :: sweep_watcher_t
   contains
      !> True if the sweep is to end; asked by several threads at once.
      procedure :: wants_end => never
      !> Told how many members are done, of how many; by one thread at a time.
      procedure :: show => ignore
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

end module nutate_sweep_watcher
