!> The processes of a sweep, and the messages between them. Rank 0 hands out numbers of chunks; all others ask for one
!> after the other. Nothing else knows MPI.
!>
!> A request says which chunk has been finished, if any; the answer is the next chunk, or 0. Rows are sent where they
!> are to be added up, not where they go to the file.
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

   !> What a message is.
   integer, parameter :: of_request = 1, of_answer = 2, of_rows = 3, of_words = 4

   !> All processes.
   type :: ranks_t
      !> Of this one, from 0 on; of all.
      integer :: rank = 0, count = 1
   contains
      !> To be called first.
      procedure :: start
      !> To be called last, by all.
      procedure :: finish
      !> Tells all others what rank 0 has to say.
      procedure :: announce
      !> Asks rank 0 for a chunk.
      procedure :: ask
      !> The answer to that, if it has come.
      procedure :: listen
      !> The next request to rank 0, if there is one.
      procedure :: next_request
      !> Receives the rows that follow a request.
      procedure :: receive_rows
      !> Answers a request.
      procedure :: answer
      !> Which MPI this is.
      procedure, nopass :: library
   end type ranks_t

   !> What a rank asks of rank 0.
   type :: request_t
      integer :: rank = 0
      !> What it has finished; 0: nothing.
      integer(long) :: chunk = 0
      !> Why it cannot go on.
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

   !> To be called first.
   subroutine start(self)
      class(ranks_t), intent(out) :: self
      call MPI_Init()
      call MPI_Comm_rank(MPI_COMM_WORLD, self%rank)
      call MPI_Comm_size(MPI_COMM_WORLD, self%count)
   end subroutine start

   !> To be called last, by all.
   subroutine finish(self)
      class(ranks_t), intent(inout) :: self
      call MPI_Finalize()
      self%count = 0
   end subroutine finish

   !> Tells all others what rank 0 has to say; called by all.
   subroutine announce(self, numbers)
      class(ranks_t), intent(in) :: self
      !> Those of rank 0 on return.
      integer(long), intent(inout) :: numbers(:)
      if (self%count > 1) call MPI_Bcast(numbers, size(numbers), MPI_INTEGER8, 0, MPI_COMM_WORLD)
   end subroutine announce

   !> Asks rank 0 for a chunk.
   subroutine ask(self, chunk, fields, status)
      !> Not rank 0.
      class(ranks_t), intent(in) :: self
      !> What has been finished; 0: nothing.
      integer(long), intent(in) :: chunk
      !> Its rows, where rank 0 is to add them up; else not allocated. Shape (fields, members).
      integer(long), allocatable, intent(in) :: fields(:, :)
      !> Why this rank cannot go on, if it cannot; there is no answer then.
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

   !> The answer of rank 0, if it has come.
   subroutine listen(self, there, chunk)
      !> Not rank 0.
      class(ranks_t), intent(in) :: self
      logical, intent(out) :: there
      !> 0: there are no more.
      integer(long), intent(out) :: chunk
      chunk = 0
      call MPI_Iprobe(0, of_answer, MPI_COMM_WORLD, there, MPI_STATUS_IGNORE)
      if (there) call MPI_Recv(chunk, 1, MPI_INTEGER8, 0, of_answer, MPI_COMM_WORLD, MPI_STATUS_IGNORE)
   end subroutine listen

   !> The next request, if there is one.
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
      !> To be run; 0: there are no more.
      integer(long), intent(in) :: chunk
      call MPI_Send(chunk, 1, MPI_INTEGER8, request%rank, of_answer, MPI_COMM_WORLD)
   end subroutine answer

   !> Which MPI this is.
   function library() result(text)
      character(len=:), allocatable :: text
      character(len=MPI_MAX_LIBRARY_VERSION_STRING) :: name
      integer :: length
      call MPI_Get_library_version(name, length)
      text = name(1:scan(name(1:length)//',', ','//achar(0)//achar(10)) - 1)
   end function library

   !> Lets others have the core for a while: a process that waits for messages would keep it.
   subroutine nap()
      integer(c_int), parameter :: microseconds = 50
      integer(c_int) :: ignored
      ignored = usleep(microseconds)
   end subroutine nap

end module nutate_ranks
