!> Workers that run the members of a sweep: the threads of this process. A program of several processes extends them.
module nutate_sweep_workers
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   use nutate_sweep, only: sweep_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   implicit none
   private

   public :: sweep_workers_t

   type :: sweep_workers_t
      !> Name of the program in messages.
      character(len=12) :: program = 'nutate'
      integer :: threads = 1
   contains
      !> Returns the number of members that run at once.
      procedure :: count => count_workers
      !> Runs the members that are not done yet.
      procedure :: go
   end type sweep_workers_t

contains

   !> Returns the number of members that run at once.
   integer function count_workers(self)
      class(sweep_workers_t), intent(in) :: self
      count_workers = self%threads
   end function count_workers

   !> Runs the members that are not done yet. Errors: those of `sweep%go`.
   subroutine go(self, sweep, scene, watcher, status)
      class(sweep_workers_t), intent(inout) :: self
      !> Sweep, open.
      type(sweep_t), intent(inout), target :: sweep
      !> Scene with which the sweep was opened.
      type(scene_t), intent(in) :: scene
      class(sweep_watcher_t), intent(inout), target :: watcher
      type(status_t), intent(out) :: status
      call sweep%go(scene, self%threads, watcher, status)
   end subroutine go

end module nutate_sweep_workers
