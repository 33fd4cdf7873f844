!> Who runs the members of a sweep: the threads of this process. A program of several processes extends it.
module nutate_sweep_workers
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t
   use nutate_sweep, only: sweep_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   implicit none
   private

   public :: sweep_workers_t

   type :: sweep_workers_t
      !> The program, as messages name it.
      character(len=12) :: program = 'nutate'
      integer :: threads = 1
   contains
      !> How many members are run at once.
      procedure :: count => count_workers
      !> Runs what is not done yet.
      procedure :: go
   end type sweep_workers_t

contains

   !> How many members are run at once.
   integer function count_workers(self)
      class(sweep_workers_t), intent(in) :: self
      count_workers = self%threads
   end function count_workers

   !> Runs what is not done yet. Errors: those of `sweep%go`.
   subroutine go(self, sweep, scene, watcher, status)
      class(sweep_workers_t), intent(inout) :: self
      !> Open.
      type(sweep_t), intent(inout), target :: sweep
      !> The scene that it was opened with.
      type(scene_t), intent(in) :: scene
      class(sweep_watcher_t), intent(inout), target :: watcher
      type(status_t), intent(out) :: status
      call sweep%go(scene, self%threads, watcher, status)
   end subroutine go

end module nutate_sweep_workers
