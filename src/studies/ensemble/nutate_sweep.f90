!> A sweep: members of an ensemble run by some threads, to a file of rows or to their mean.
!>
!>     call sweep%open(scene, first, last, file, resume, status)
!>     call sweep%go(threads, watcher, status)
!>     call sweep%close(status)
!>
!> Threads take chunks of members as they become free. A row depends on its member alone, and sums are added in the
!> order of the members, so that results are bitwise identical whichever thread ran a member.
!>
!> In place of `go`, a program may hand out the chunks itself, to other processes too, each of which has joined:
!>
!>     call sweep%get_chunk(chunk)                                 ! where it was opened; 0: there are no more
!>     call sweep%run_chunk(scene, runner, chunk, fields, status)   ! anywhere; returns when the rows are on the disk
!>     call sweep%finish_chunk(chunk, fields, status)               ! where it was opened
module nutate_sweep
   use nutate_byte_archive, only: byte_archive_t
   use nutate_forks, only: has_threads
   use nutate_kinds, only: long
   use nutate_member_rows, only: run_share
   use nutate_member_run, only: member_run_t
   use nutate_npy, only: longest_header, npy_header
   use nutate_row_layout, only: make_layout, row_layout_t
   use nutate_scene, only: scene_t
   use nutate_sealed_file, only: read_sealed, write_sealed
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_IO
   use nutate_sweep_file, only: sweep_file_t
   use nutate_sweep_identity, only: identity_of
   use nutate_sweep_sums, only: sweep_sums_t
   use nutate_sweep_watcher, only: sweep_watcher_t
   use nutate_system_text, only: error_text
   use nutate_text_lock, only: lock_texts, unlock_texts
   use nutate_text_file, only: read_text_file
   implicit none
   private

   public :: sweep_t

   !> First bytes of the file of sums in progress; the number is the version of its format.
   character(len=*), parameter :: signature = 'nutate sweep sums 1'//achar(10)
   character(len=*), parameter :: partial = '.partial'
   !> Least number of chunks of an ensemble, in all and for each worker; largest number of members of a chunk.
   integer(long), parameter :: usual_chunks = 64, chunks_of_each = 16, largest_chunk = 4096

   !> Rows of one chunk that wait for those before them.
   type :: waiting_t
      integer(long), allocatable :: fields(:, :)
   end type waiting_t

   !> Members of an ensemble on their way to a file.
   type :: sweep_t
      type(row_layout_t) :: layout
      !> First and last of the members.
      integer(long) :: first = 1, last = 0
      !> Members done, including those of an earlier sweep that is continued.
      integer(long) :: members_done = 0
      !> Path of the complete file.
      character(len=:), allocatable :: name
      !> Sums over the members so far, if no rows are kept.
      type(sweep_sums_t) :: sums
      !> True if rows go to a file, false if they are only added up.
      logical :: keeps_rows = .true.
      !> Members of a chunk; the last one may have fewer.
      integer(long) :: chunk = 1
      !> Checksum of what the rows depend on; the same for sweeps with the same rows.
      integer(long) :: identity = 0
      type(sweep_file_t), private :: file
      !> Number of chunks; next chunk to run; next chunk to add to the sums.
      integer(long), private :: chunks = 0, next = 1, to_add = 1
      type(waiting_t), allocatable, private :: waiting(:)
      !> First failure.
      type(status_t), private :: failure
   contains
      !> Opens the file.
      procedure :: open => open_sweep
      !> Joins a sweep that another process has opened.
      procedure :: join
      !> Runs the chunks that are not done yet.
      procedure :: go
      !> Returns the next chunk to run.
      procedure :: get_chunk
      !> Runs a chunk to rows on the disk.
      procedure :: run_chunk
      !> Counts a chunk that has been run.
      procedure :: finish_chunk
      !> Returns the number of members of a chunk.
      procedure :: size_of
      !> Gives the file its name.
      procedure :: close => close_sweep
      !> Leaves the file to be continued, or to the process that has opened it.
      procedure :: abandon
   end type sweep_t

contains

   !> Opens the file. Errors: `NUTATE_IO`; `NUTATE_BAD_ARGUMENT` for more fields than a header holds, and for a file to
   !> continue that belongs to another sweep.
   subroutine open_sweep(self, scene, first, last, name, resume, status, workers)
      class(sweep_t), intent(inout) :: self
      !> Scene with an ensemble.
      type(scene_t), intent(in) :: scene
      !> First and last member.
      integer(long), intent(in) :: first, last
      !> Path of the file.
      character(len=*), intent(in) :: name
      !> True to continue what an earlier sweep has left, if it has left anything.
      logical, intent(in) :: resume
      type(status_t), intent(out) :: status
      !> Number of threads or processes that run chunks; default 1. A continued file keeps its chunks.
      integer, intent(in), optional :: workers
      character(len=:), allocatable :: header
      integer(long) :: members
      call begin(self, scene, first, last, name, status)
      if (.not. status%ok()) return
      members = last - first + 1
      header = npy_header(self%layout, members)
      if (len(header) > longest_header) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a row has more fields than the header of a .npy file names (expected '// &
                       'fewer columns, events or varied numbers)')
         return
      end if
      self%chunk = scene%ensemble%chunk
      if (self%chunk == 0) self%chunk = usual_chunk(members, workers)
      self%chunk = min(self%chunk, members)
      if (self%keeps_rows) then
         call self%file%open(name, header, self%layout%width(), members, self%chunk, self%identity, resume, status)
         if (.not. status%ok()) return
         self%chunk = self%file%chunk
      else
         call open_sums(self, resume, status)
      end if
      self%chunks = (members + self%chunk - 1)/self%chunk
      if (self%keeps_rows) then
         self%members_done = count_done(self)
      else
         allocate (self%waiting(self%to_add:self%chunks))
      end if
   end subroutine open_sweep

   !> Joins a sweep that another process has opened: runs chunks of it. Errors: `NUTATE_IO`; `NUTATE_BAD_ARGUMENT` if
   !> the scene is not that of the other process.
   subroutine join(self, scene, first, last, name, chunk, identity, status)
      class(sweep_t), intent(inout) :: self
      !> Arguments that the other process has passed to `open`.
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: first, last
      character(len=*), intent(in) :: name
      !> Chunk size and identity of the sweep of the other process.
      integer(long), intent(in) :: chunk, identity
      type(status_t), intent(out) :: status
      integer(long) :: members
      call begin(self, scene, first, last, name, status)
      if (status%ok() .and. self%identity /= identity) &
         status = fail(NUTATE_BAD_ARGUMENT, 'the scene differs between processes')
      if (.not. status%ok()) return
      members = last - first + 1
      self%chunk = chunk
      self%chunks = (members + chunk - 1)/chunk
      if (self%keeps_rows) call self%file%join(name, npy_header(self%layout, members), self%layout%width(), members, &
                                               chunk, status)
   end subroutine join

   !> Sets what `open` and `join` have in common.
   subroutine begin(self, scene, first, last, name, status)
      class(sweep_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      integer(long), intent(in) :: first, last
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      self%first = first
      self%last = last
      self%name = name
      self%keeps_rows = scene%ensemble%keeps_rows
      self%identity = identity_of(scene, first, last)
      call make_layout(scene, self%layout, status)
   end subroutine begin

   !> Returns the default number of members of a chunk.
   pure integer(long) function usual_chunk(members, workers) result(chunk)
      integer(long), intent(in) :: members
      !> Number of threads or processes, as in `open`.
      integer, intent(in), optional :: workers
      integer(long) :: parts
      parts = usual_chunks
      if (present(workers)) parts = max(parts, chunks_of_each*workers)
      chunk = max(min((members + parts - 1)/parts, largest_chunk), 1_long)
   end function usual_chunk

   !> Starts sums, or continues those that another sweep has left. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine open_sums(self, resume, status)
      class(sweep_t), intent(inout) :: self
      logical, intent(in) :: resume
      type(status_t), intent(inout) :: status
      character(len=:), allocatable :: content, problem
      call self%sums%prepare(self%layout)
      if (.not. resume) return
      call read_text_file(self%name//partial, content, problem)
      if (problem /= '') return
      call read_sealed(self%name//partial, signature, content, problem)
      if (problem == '') call read_sums(self, content, problem)
      if (problem /= '') status = fail(NUTATE_BAD_ARGUMENT, self%name//partial//' '//problem)
   end subroutine open_sums

   !> Reads the sums of another sweep.
   subroutine read_sums(self, content, problem)
      class(sweep_t), intent(inout) :: self
      character(len=*), intent(in) :: content
      character(len=:), allocatable, intent(inout) :: problem
      type(byte_archive_t) :: archive
      integer(long) :: identity
      call archive%begin_reading(content)
      identity = self%identity
      call archive%transfer(identity)
      if (identity /= self%identity) then
         problem = 'belongs to another sweep'
         return
      end if
      call archive%transfer(self%chunk)
      call archive%transfer(self%to_add)
      call archive%transfer(self%members_done)
      call self%sums%transfer(archive)
      problem = archive%problem()
      self%next = self%to_add
   end subroutine read_sums

   !> Writes the sums so far to the partial file. Errors: `NUTATE_IO`.
   subroutine keep_sums(self, status)
      class(sweep_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      type(byte_archive_t) :: archive
      call archive%begin_writing()
      call archive%transfer(self%identity)
      call archive%transfer(self%chunk)
      call archive%transfer(self%to_add)
      call archive%transfer(self%members_done)
      call self%sums%transfer(archive)
      call write_sealed(self%name//partial, signature, archive%content(), status)
   end subroutine keep_sums

   !> Returns the number of rows in the file.
   integer(long) function count_done(self) result(n)
      class(sweep_t), intent(in) :: self
      integer(long) :: i
      n = 0
      do i = 1, self%chunks
         if (self%file%done(i)) n = n + self%size_of(i)
      end do
   end function count_done

   !> Runs the chunks that are not done yet. Errors: `NUTATE_STOPPED` if the watcher wants the end; `NUTATE_IO`;
   !> `NUTATE_BAD_ARGUMENT` for threads in a library built without them.
   subroutine go(self, scene, threads, watcher, status)
      !> Open sweep.
      class(sweep_t), intent(inout) :: self
      !> Scene that the sweep was opened with.
      type(scene_t), intent(in) :: scene
      !> Number of threads; 1: the calling thread, and none is started.
      integer, intent(in) :: threads
      class(sweep_watcher_t), intent(inout) :: watcher
      type(status_t), intent(out) :: status
      if (threads > 1 .and. .not. has_threads()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'this library was built without threads')
         return
      end if
      self%failure = status_t()
      call watcher%report(self%members_done, self%last - self%first + 1)
      if (threads > 1) then
         !$omp parallel num_threads(threads) default(shared)
         call work(self, scene, watcher)
         !$omp end parallel
      else
         call work(self, scene, watcher)
      end if
      status = self%failure
   end subroutine go

   !> Takes and runs chunks until there are none; called by each thread.
   subroutine work(self, scene, watcher)
      class(sweep_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      class(sweep_watcher_t), intent(inout) :: watcher
      type(member_run_t) :: runner
      type(status_t) :: status
      integer(long), allocatable :: fields(:, :)
      integer(long) :: chunk
      call runner%prepare(scene, self%layout, status, watcher)
      do while (status%ok())
         call lock_texts()
         chunk = 0
         if (self%failure%ok()) call self%get_chunk(chunk)
         call unlock_texts()
         if (chunk == 0) exit
         call self%run_chunk(scene, runner, chunk, fields, status)
         if (.not. status%ok()) exit
         call lock_texts()
         call self%finish_chunk(chunk, fields, status)
         call watcher%report(self%members_done, self%last - self%first + 1)
         call unlock_texts()
      end do
      call lock_texts()
      if (self%failure%ok()) self%failure = status
      call unlock_texts()
   end subroutine work

   !> Returns the next chunk to run. Not for several threads at once.
   subroutine get_chunk(self, chunk)
      !> Open sweep.
      class(sweep_t), intent(inout) :: self
      !> Number of the chunk; 0 if there are no more.
      integer(long), intent(out) :: chunk
      chunk = 0
      do while (self%next <= self%chunks .and. chunk == 0)
         chunk = self%next
         if (self%keeps_rows) then
            if (self%file%done(chunk)) chunk = 0
         end if
         self%next = self%next + 1
      end do
   end subroutine get_chunk

   !> Runs a chunk; its rows are on the disk when this returns. For several threads at once. Errors: `NUTATE_STOPPED` if
   !> the watcher of the runner wants the end; `NUTATE_IO`.
   subroutine run_chunk(self, scene, runner, chunk, fields, status)
      !> Open or joined sweep. A target, so that the watcher may take and finish other chunks meanwhile.
      class(sweep_t), intent(inout), target :: self
      !> Scene of the sweep.
      type(scene_t), intent(in) :: scene
      !> Runner, prepared with the scene and the layout of the sweep.
      type(member_run_t), intent(inout) :: runner
      integer(long), intent(in) :: chunk
      !> Rows of the chunk; shape (fields, members of the chunk).
      integer(long), allocatable, intent(out) :: fields(:, :)
      type(status_t), intent(out) :: status
      integer(long) :: first
      integer :: error
      first = self%first + (chunk - 1)*self%chunk
      allocate (fields(self%layout%width(), self%size_of(chunk)))
      call run_share(runner, scene, first, first + self%size_of(chunk) - 1, fields, status)
      if (.not. (status%ok() .and. self%keeps_rows)) return
      call self%file%put_chunk(chunk, fields, error)
      if (error == 0) return
      call lock_texts()
      status = fail(NUTATE_IO, error_text(error))
      call unlock_texts()
   end subroutine run_chunk

   !> Returns the number of members of a chunk.
   pure integer(long) function size_of(self, chunk)
      class(sweep_t), intent(in) :: self
      integer(long), intent(in) :: chunk
      size_of = min(self%chunk, self%last - self%first + 1 - (chunk - 1)*self%chunk)
   end function size_of

   !> Counts a chunk that has been run, and marks it in the file. If no rows are kept, adds the chunks to the sums in
   !> their order, each when those before it are there. Not for several threads at once. Errors: `NUTATE_IO`.
   subroutine finish_chunk(self, chunk, fields, status)
      !> Open sweep.
      class(sweep_t), intent(inout) :: self
      integer(long), intent(in) :: chunk
      !> Rows of the chunk; shape (fields, members of the chunk). Only needed if no rows are kept, and then deallocated.
      integer(long), allocatable, intent(inout) :: fields(:, :)
      type(status_t), intent(out) :: status
      if (self%keeps_rows) then
         call self%file%mark(chunk, status)
         if (status%ok()) self%members_done = self%members_done + self%size_of(chunk)
         return
      end if
      call move_alloc(fields, self%waiting(chunk)%fields)
      if (.not. allocated(self%waiting(self%to_add)%fields)) return
      do while (self%to_add <= self%chunks)
         if (.not. allocated(self%waiting(self%to_add)%fields)) exit
         call self%sums%add(self%layout, self%waiting(self%to_add)%fields)
         self%members_done = self%members_done + self%size_of(self%to_add)
         deallocate (self%waiting(self%to_add)%fields)
         self%to_add = self%to_add + 1
      end do
      call keep_sums(self, status)
   end subroutine finish_chunk

   !> Gives the file its name. Errors: `NUTATE_IO`.
   subroutine close_sweep(self, status)
      class(sweep_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      if (self%keeps_rows) then
         call self%file%finish(status)
      else
         call self%sums%write(self%layout, self%name, status)
      end if
   end subroutine close_sweep

   !> Leaves the file to be continued, or to the process that has opened it. Errors: `NUTATE_IO`.
   subroutine abandon(self, status)
      class(sweep_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      if (self%keeps_rows) call self%file%abandon(status)
   end subroutine abandon

end module nutate_sweep
