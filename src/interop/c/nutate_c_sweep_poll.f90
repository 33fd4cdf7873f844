!> Sweeps that can be asked to stop: the thread that called asks the program, the others see what it was told.
module nutate_c_sweep_poll
   !$ use omp_lib, only: omp_get_thread_num
   use nutate_c_polls, only: poll_t
   use nutate_status, only: status_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   implicit none
   private

   public :: polling_sweep_t

   !> What the threads share.
   type :: answer_t
      type(poll_t) :: poll
      logical :: ended = .false.
      !> No threads but the one that called.
      logical :: alone = .false.
   end type answer_t

   !> Asks the poll of a scene.
   type, extends(sweep_watcher_t) :: polling_sweep_t
      type(answer_t), pointer, private :: answer => null()
   contains
      !> Takes whom to ask.
      procedure :: start
      procedure :: wants_end => ask_program
      final :: forget
   end type polling_sweep_t

contains

   !> Takes whom to ask.
   subroutine start(self, poll, threads)
      class(polling_sweep_t), intent(inout) :: self
      type(poll_t), intent(in) :: poll
      !> How many will ask; the first is the one that calls.
      integer, intent(in) :: threads
      if (.not. associated(self%answer)) allocate (self%answer)
      self%answer%poll = poll
      self%answer%alone = threads == 1
   end subroutine start

   logical function ask_program(self) result(wants_end)
      class(polling_sweep_t), intent(in) :: self
      type(status_t) :: status
      integer :: thread
      thread = 0
      !$ thread = omp_get_thread_num()
      !$omp atomic read
      wants_end = self%answer%ended
      if (wants_end .or. (thread > 0 .and. .not. self%answer%alone)) return
      call self%answer%poll%ask(status)
      wants_end = .not. status%ok()
      if (.not. wants_end) return
      !$omp atomic write
      self%answer%ended = .true.
   end function ask_program

   subroutine forget(self)
      type(polling_sweep_t), intent(inout) :: self
      if (associated(self%answer)) deallocate (self%answer)
   end subroutine forget

end module nutate_c_sweep_poll
