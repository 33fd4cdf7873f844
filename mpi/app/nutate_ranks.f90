!> The processes of a sweep, and the messages between them. Rank 0 hands out numbers of chunks; all others request one
!> after the other. No other module calls MPI.
!>
!> A request names the chunk that has been finished, if any; the answer is the next chunk, or 0. Rows are sent if they
!> are to be added up, not if they go to the file.
module nutate_ranks
   use, intrinsic :: iso_c_binding, only: c_int
   use mpi_f08, only: MPI_ANY_SOURCE, MPI_Bcast, MPI_CHARACTER, MPI_COMM_WORLD, MPI_Comm_rank, MPI_Comm_size, &
      MPI_Finalize, MPI_Get_library_version, MPI_Init, MPI_INTEGER8, MPI_Iprobe, MPI_MAX_LIBRARY_VERSION_STRING, &
      MPI_Recv, MPI_Send, MPI_Status, MPI_STATUS_IGNORE
   use nutate_kinds, only: long
   use nutate_status, only: status_t
   implicit none
   private

   public :: ranks_t, request_t, nap

   !> Tags of messages.
   integer, parameter :: of_request = 1, of_answer = 2, of_rows = 3, of_words = 4

   !> All processes.
   type :: ranks_t
      !> Number of this process, from 0 on; number of processes.
      integer :: rank = 0, count = 1
   contains
      !> Starts MPI; to be called first.
      procedure :: start
      !> Ends MPI; to be called last, by all.
      procedure :: finish
      !> Sends numbers of rank 0 to all others.
      procedure :: announce
      !> Requests a chunk from rank 0.
      procedure :: ask
      !> Receives the answer to `ask`, if it has come.
      procedure :: listen
      !> Receives the next request to rank 0, if there is one.
      procedure :: next_request
      !> Receives the rows that follow a request.
      procedure :: receive_rows
      !> Answers a request.
      procedure :: answer
      !> Returns the name of the MPI library.
      procedure, nopass :: library
   end type ranks_t

   !> A request of a rank to rank 0.
   type :: request_t
      integer :: rank = 0
      !> Chunk that the rank has finished; 0: none.
      integer(long) :: chunk = 0
      !> Reason why the rank cannot go on.
      type(status_t) :: status
   end type request_t

   interface
      !> Sleeps for some µs.
      integer(c_int) function usleep(microseconds) bind(c, name='usleep')
         import :: c_int
         integer(c_int), intent(in), value :: microseconds
      end function usleep
   end interface

contains

   !> Starts MPI; to be called first.
   subroutine start(self)
      class(ranks_t), intent(out) :: self
      call MPI_Init()
      call MPI_Comm_rank(MPI_COMM_WORLD, self%rank)
      call MPI_Comm_size(MPI_COMM_WORLD, self%count)
   end subroutine start

   !> Ends MPI; to be called last, by all.
   subroutine finish(self)
      class(ranks_t), intent(inout) :: self
      call MPI_Finalize()
      self%count = 0
   end subroutine finish

   !> Sends numbers of rank 0 to all others; called by all.
   subroutine announce(self, numbers)
      class(ranks_t), intent(in) :: self
      !> Numbers; on return those of rank 0.
      integer(long), intent(inout) :: numbers(:)
      if (self%count > 1) call MPI_Bcast(numbers, size(numbers), MPI_INTEGER8, 0, MPI_COMM_WORLD)
   end subroutine announce

   !> Requests a chunk from rank 0.
   subroutine ask(self, chunk, fields, status)
      !> Any rank but rank 0.
      class(ranks_t), intent(in) :: self
      !> Chunk that has been finished; 0: none.
      integer(long), intent(in) :: chunk
      !> Rows of the chunk, if rank 0 is to add them up; else not allocated. Shape (fields, members).
      integer(long), allocatable, intent(in) :: fields(:, :)
      !> Reason why this rank cannot go on, if it cannot; there is no answer then.
      type(status_t), intent(in) :: status
      integer(long) :: numbers(2)
      numbers = [chunk, int(status%code, long)]
      call MPI_Send(numbers, 2, MPI_INTEGER8, 0, of_request, MPI_COMM_WORLD)
      if (.not. status%ok()) then
         call MPI_Send(status%message, len(status%message), MPI_CHARACTER, 0, of_words, MPI_COMM_WORLD)
      else if (chunk > 0 .and. allocated(fields)) then
         call MPI_Send(fields, size(fields), MPI_INTEGER8, 0, of_rows, MPI_COMM_WORLD)
      end if
   end subroutine ask

   !> Receives the answer of rank 0, if it has come.
   subroutine listen(self, there, chunk)
      !> Any rank but rank 0.
      class(ranks_t), intent(in) :: self
      logical, intent(out) :: there
      !> Next chunk; 0: there are no more.
      integer(long), intent(out) :: chunk
      chunk = 0
      call MPI_Iprobe(0, of_answer, MPI_COMM_WORLD, there, MPI_STATUS_IGNORE)
      if (there) call MPI_Recv(chunk, 1, MPI_INTEGER8, 0, of_answer, MPI_COMM_WORLD, MPI_STATUS_IGNORE)
   end subroutine listen

   !> Receives the next request, if there is one.
   subroutine next_request(self, there, request)
      !> Rank 0.
      class(ranks_t), intent(in) :: self
      logical, intent(out) :: there
      type(request_t), intent(out) :: request
      type(MPI_Status) :: envelope
      integer(long) :: numbers(2)
      there = .false.
      if (self%count > 1) call MPI_Iprobe(MPI_ANY_SOURCE, of_request, MPI_COMM_WORLD, there, envelope)
      if (.not. there) return
      request%rank = envelope%MPI_SOURCE
      call MPI_Recv(numbers, 2, MPI_INTEGER8, request%rank, of_request, MPI_COMM_WORLD, MPI_STATUS_IGNORE)
      request%chunk = numbers(1)
      request%status%code = int(numbers(2))
      if (.not. request%status%ok()) &
         call MPI_Recv(request%status%message, len(request%status%message), MPI_CHARACTER, request%rank, of_words, &
                       MPI_COMM_WORLD, MPI_STATUS_IGNORE)
   end subroutine next_request

   !> Receives the rows that follow a request.
   subroutine receive_rows(self, request, fields)
      !> Rank 0.
      class(ranks_t), intent(in) :: self
      type(request_t), intent(in) :: request
      !> Shape (fields, members).
      integer(long), intent(inout), contiguous :: fields(:, :)
      call MPI_Recv(fields, size(fields), MPI_INTEGER8, request%rank, of_rows, MPI_COMM_WORLD, MPI_STATUS_IGNORE)
   end subroutine receive_rows

   !> Answers a request.
   subroutine answer(self, request, chunk)
      !> Rank 0.
      class(ranks_t), intent(in) :: self
      type(request_t), intent(in) :: request
      !> Chunk to be run; 0: there are no more.
      integer(long), intent(in) :: chunk
      call MPI_Send(chunk, 1, MPI_INTEGER8, request%rank, of_answer, MPI_COMM_WORLD)
   end subroutine answer

   !> Returns the name of the MPI library.
   function library() result(text)
      character(len=:), allocatable :: text
      character(len=MPI_MAX_LIBRARY_VERSION_STRING) :: name
      integer :: length
      call MPI_Get_library_version(name, length)
      text = name(1:scan(name(1:length)//',', ','//achar(0)//achar(10)) - 1)
   end function library

   !> Yields the core for a while: a process that waits for messages would keep it.
   subroutine nap()
      integer(c_int), parameter :: microseconds = 50
      integer(c_int) :: ignored
      ignored = usleep(microseconds)
   end subroutine nap

end module nutate_ranks
