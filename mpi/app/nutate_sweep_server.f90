!> Server of rank 0: it hands out chunks and receives what has been finished. As long as the other ranks are few, rank 0
!> runs chunks itself, and answers requests whenever the members that it runs poll.
module nutate_sweep_server
   use nutate_kinds, only: long
   use nutate_member_run, only: member_run_t
   use nutate_ranks, only: nap, ranks_t, request_t
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, fail, NUTATE_STOPPED
   use nutate_sweep, only: sweep_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   implicit none
   private

   public :: sweep_server_t

   !> Largest number of ranks with which rank 0 runs chunks. With more, one more worker would not be noticed, and no
   !> rank waits for an answer.
   integer, parameter :: most_helped = 32

   !> A sweep that is handed out, and its progress.
   type :: sweep_server_t
      type(ranks_t) :: ranks
      type(sweep_t), pointer :: sweep => null()
      !> Watcher that receives the progress, and is polled for a request to stop.
      class(sweep_watcher_t), pointer :: watcher => null()
      !> Number of ranks that have received the answer 0, or that cannot go on.
      integer :: gone = 0
      !> First failure.
      type(status_t) :: failure
   contains
      !> Runs the whole sweep.
      procedure :: run
      !> Answers all pending requests.
      procedure :: serve
   end type sweep_server_t

   !> Watcher that answers requests while rank 0 runs members.
   type, extends(sweep_watcher_t) :: bell_t
      type(sweep_server_t), pointer :: server => null()
   contains
      procedure :: wants_end
   end type bell_t

contains

   !> Runs the whole sweep. Errors: `NUTATE_STOPPED` if the watcher wants the end; `NUTATE_IO`; errors of other ranks.
   subroutine run(self, scene, status)
      class(sweep_server_t), intent(inout), target :: self
      type(scene_t), intent(in) :: scene
      type(status_t), intent(out) :: status
      logical :: served
      call report(self)
      if (self%ranks%count <= most_helped) call help(self, scene)
      do while (self%gone < self%ranks%count - 1 .and. self%failure%code /= NUTATE_STOPPED)
         call self%serve(served)
         if (self%watcher%wants_end()) self%failure = fail(NUTATE_STOPPED, 'the sweep was stopped')
         if (.not. served) call nap()
      end do
      status = self%failure
   end subroutine run

   !> Runs chunks, as the other ranks do.
   subroutine help(self, scene)
      type(sweep_server_t), intent(inout), target :: self
      type(scene_t), intent(in) :: scene
      type(bell_t), target :: bell
      type(member_run_t) :: runner
      type(status_t) :: status
      integer(long), allocatable :: fields(:, :)
      integer(long) :: chunk
      bell%server => self
      call runner%prepare(scene, self%sweep%layout, status, bell)
      do while (status%ok() .and. self%failure%ok())
         call self%sweep%get_chunk(chunk)
         if (chunk == 0) exit
         call self%sweep%run_chunk(scene, runner, chunk, fields, status)
         if (status%ok()) call self%sweep%finish_chunk(chunk, fields, status)
         call report(self)
      end do
      if (self%failure%ok()) self%failure = status
   end subroutine help

   !> Returns true if the members that rank 0 runs are to end. Answers requests meanwhile.
   logical function wants_end(self)
      class(bell_t), intent(in) :: self
      logical :: served
      call self%server%serve(served)
      wants_end = .not. self%server%failure%ok()
      if (.not. wants_end) wants_end = self%server%watcher%wants_end()
   end function wants_end

   !> Answers all pending requests.
   subroutine serve(self, served)
      class(sweep_server_t), intent(inout) :: self
      !> True if there were requests.
      logical, intent(out) :: served
      type(request_t) :: request
      integer(long), allocatable :: fields(:, :)
      integer(long) :: chunk
      logical :: there
      served = .false.
      do
         call self%ranks%next_request(there, request)
         if (.not. there) return
         served = .true.
         if (.not. request%status%ok()) then
            self%gone = self%gone + 1
            if (self%failure%ok()) self%failure = said_by(request)
            cycle
         end if
         if (request%chunk > 0) call finish(self, request, fields)
         chunk = 0
         if (self%failure%ok()) call self%sweep%get_chunk(chunk)
         if (chunk == 0) self%gone = self%gone + 1
         call self%ranks%answer(request, chunk)
      end do
   end subroutine serve

   !> Receives a finished chunk.
   subroutine finish(self, request, fields)
      class(sweep_server_t), intent(inout) :: self
      type(request_t), intent(in) :: request
      !> Rows of the chunk, if they are to be added up; on return not allocated.
      integer(long), allocatable, intent(inout) :: fields(:, :)
      type(status_t) :: status
      if (.not. self%sweep%keeps_rows) then
         allocate (fields(self%sweep%layout%width(), self%sweep%size_of(request%chunk)))
         call self%ranks%receive_rows(request, fields)
      end if
      call self%sweep%finish_chunk(request%chunk, fields, status)
      if (self%failure%ok()) self%failure = status
      call report(self)
   end subroutine finish

   !> Returns the failure of another rank.
   function said_by(request) result(status)
      type(request_t), intent(in) :: request
      type(status_t) :: status
      character(len=12) :: rank
      write (rank, '(i0)') request%rank
      status = request%status
      status%message = 'rank '//trim(rank)//': '//request%status%message
   end function said_by

   subroutine report(self)
      class(sweep_server_t), intent(inout) :: self
      call self%watcher%report(self%sweep%members_done, self%sweep%last - self%sweep%first + 1)
   end subroutine report

end module nutate_sweep_server
