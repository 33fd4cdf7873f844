!> A sweep: members of an ensemble run by some threads, to a file of rows or to their mean.
!>
!>     call sweep%open(scene, first, last, file, resume, status)
!>     call sweep%go(threads, watcher, status)
!>     call sweep%close(status)
!>
!> Threads take chunks of members as they come; a row depends on its member alone, and sums are made in the order of the
!> members, so that the bytes are the same whoever ran what.
module nutate_sweep
   use nutate_byte_archive, only: byte_archive_t
   use nutate_kinds, only: long
   use nutate_member_rows, only: has_threads, take_rows
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

   !> What the file of sums under way begins with; the number is that of its format.
   character(len=*), parameter :: signature = 'nutate sweep sums 1'//achar(10)
   character(len=*), parameter :: partial = '.partial'
   !> Chunks that an ensemble is cut into, as far as they are no larger than suits.
   integer(long), parameter :: usual_chunks = 64, largest_chunk = 4096

   !> Rows of one chunk that wait for those before them.
   type :: waiting_t
      integer(long), allocatable :: fields(:, :)
   end type waiting_t

   !> Members of an ensemble on their way to a file.
   type :: sweep_t
      type(row_layout_t) :: layout
      !> First and last of the members.
      integer(long) :: first = 1, last = 0
      !> Members done, those of an earlier sweep that is gone on with included.
      integer(long) :: members_done = 0
      !> Path of the whole file.
      character(len=:), allocatable :: name
      !> Of the members so far, where no rows are kept.
      type(sweep_sums_t) :: sums
      !> Rows go to a file.
      logical, private :: keeps_rows = .true.
      type(sweep_file_t), private :: file
      !> Members of a chunk; chunks in all, next to be taken, next to be added.
      integer(long), private :: chunk = 1, chunks = 0, next = 1, to_add = 1
      integer(long), private :: identity = 0
      type(waiting_t), allocatable, private :: waiting(:)
      !> The first thing that went wrong.
      type(status_t), private :: failure
   contains
      !> Opens the file.
      procedure :: open => open_sweep
      !> Runs what is not done yet.
      procedure :: go
      !> Gives the file its name.
      procedure :: close => close_sweep
      !> Leaves it to be gone on with.
      procedure :: abandon
   end type sweep_t

contains

   !> Opens the file. Errors: `NUTATE_IO`; `NUTATE_BAD_ARGUMENT` for more fields than a header holds, and for a file to
   !> go on with that belongs to another sweep.
   subroutine open_sweep(self, scene, first, last, name, resume, status)
      class(sweep_t), intent(inout) :: self
      !> With an ensemble.
      type(scene_t), intent(in) :: scene
      !> Members.
      integer(long), intent(in) :: first, last
      !> Path of the file.
      character(len=*), intent(in) :: name
      !> Go on with what another sweep has left, if it has left anything.
      logical, intent(in) :: resume
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: header
      integer(long) :: members
      self%first = first
      self%last = last
      self%name = name
      self%keeps_rows = scene%ensemble%keeps_rows
      self%identity = identity_of(scene, first, last)
      call make_layout(scene, self%layout, status)
      if (.not. status%ok()) return
      members = last - first + 1
      header = npy_header(self%layout, members)
      if (len(header) > longest_header) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a row has more fields than the header of a .npy file names (expected '// &
                       'fewer columns, events or varied numbers)')
         return
      end if
      self%chunk = scene%ensemble%chunk
      if (self%chunk == 0) self%chunk = max(min((members + usual_chunks - 1)/usual_chunks, largest_chunk), 1_long)
      self%chunk = min(self%chunk, members)
      if (self%keeps_rows) then
         call self%file%open(name, header, self%layout%width(), members, self%chunk, self%identity, resume, status)
         if (.not. status%ok()) return
         self%chunk = self%file%chunk
      else
         call open_sums(self, resume, status)
      end if
      self%chunks = (members + self%chunk - 1)/self%chunk
      if (self%keeps_rows) self%members_done = count_done(self)
   end subroutine open_sweep

   !> Starts sums, or goes on with those that another sweep has left. Errors: `NUTATE_BAD_ARGUMENT`.
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
      if (problem == '') call take_sums(self, content, problem)
      if (problem /= '') status = fail(NUTATE_BAD_ARGUMENT, self%name//partial//' '//problem)
   end subroutine open_sums

   !> Takes the sums of another sweep.
   subroutine take_sums(self, content, problem)
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
   end subroutine take_sums

   !> Notes the sums so far. Errors: `NUTATE_IO`.
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

   !> Rows that are in the file.
   integer(long) function count_done(self) result(n)
      class(sweep_t), intent(in) :: self
      integer(long) :: i, first, last
      n = 0
      do i = 1, self%chunks
         if (.not. self%file%done(i)) cycle
         call self%file%bounds(i, first, last)
         n = n + last - first + 1
      end do
   end function count_done

   !> Runs what is not done yet. Errors: `NUTATE_STOPPED` where the watcher wants the end; `NUTATE_IO`;
   !> `NUTATE_BAD_ARGUMENT` for threads of a library that has none.
   subroutine go(self, scene, threads, watcher, status)
      !> Open.
      class(sweep_t), intent(inout) :: self
      !> The scene that it was opened with.
      type(scene_t), intent(in) :: scene
      !> How many; 1: the one that calls, and none is started.
      integer, intent(in) :: threads
      class(sweep_watcher_t), intent(inout) :: watcher
      type(status_t), intent(out) :: status
      if (threads > 1 .and. .not. has_threads()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'this library was built without threads')
         return
      end if
      self%failure = status_t()
      if (.not. self%keeps_rows) allocate (self%waiting(self%to_add:self%chunks))
      call watcher%show(self%members_done, self%last - self%first + 1)
      if (threads > 1) then
         !$omp parallel num_threads(threads) default(shared)
         call work(self, scene, watcher)
         !$omp end parallel
      else
         call work(self, scene, watcher)
      end if
      status = self%failure
   end subroutine go

   !> What each thread does: takes chunks until there are none.
   subroutine work(self, scene, watcher)
      class(sweep_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      class(sweep_watcher_t), intent(inout) :: watcher
      type(member_run_t) :: runner
      type(status_t) :: status
      integer(long), allocatable :: fields(:, :)
      integer(long) :: chunk, first, last
      integer :: error
      error = 0
      call runner%prepare(scene, self%layout, status, watcher)
      do while (status%ok())
         call lock_texts()
         chunk = self%next
         self%next = self%next + 1
         call unlock_texts()
         if (chunk > self%chunks .or. .not. self%failure%ok()) exit
         if (self%keeps_rows) then
            if (self%file%done(chunk)) cycle
         end if
         first = self%first + (chunk - 1)*self%chunk
         last = min(first + self%chunk - 1, self%last)
         if (allocated(fields)) deallocate (fields)
         allocate (fields(self%layout%width(), last - first + 1))
         call take_rows(runner, scene, first, last, fields, status)
         error = 0
         if (status%ok() .and. self%keeps_rows) call self%file%put_chunk(chunk, fields, error)
         if (.not. status%ok() .or. error /= 0) exit
         call lock_texts()
         call count_chunk(self, chunk, fields, status)
         call watcher%show(self%members_done, self%last - self%first + 1)
         call unlock_texts()
      end do
      call lock_texts()
      if (error /= 0) status = fail(NUTATE_IO, error_text(error))
      if (self%failure%ok()) self%failure = status
      call unlock_texts()
   end subroutine work

   !> Counts a chunk; where no rows are kept, adds it when its turn has come, with those that waited for it. Errors:
   !> `NUTATE_IO`.
   subroutine count_chunk(self, chunk, fields, status)
      class(sweep_t), intent(inout) :: self
      integer(long), intent(in) :: chunk
      !> Taken away where they have to wait.
      integer(long), allocatable, intent(inout) :: fields(:, :)
      type(status_t), intent(inout) :: status
      if (self%keeps_rows) then
         self%members_done = self%members_done + size(fields, 2)
         return
      end if
      call move_alloc(fields, self%waiting(chunk)%fields)
      if (.not. allocated(self%waiting(self%to_add)%fields)) return
      do while (self%to_add <= self%chunks)
         if (.not. allocated(self%waiting(self%to_add)%fields)) exit
         call self%sums%add(self%layout, self%waiting(self%to_add)%fields)
         self%members_done = self%members_done + size(self%waiting(self%to_add)%fields, 2)
         deallocate (self%waiting(self%to_add)%fields)
         self%to_add = self%to_add + 1
      end do
      call keep_sums(self, status)
   end subroutine count_chunk

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

   !> Leaves the file to be gone on with. Errors: `NUTATE_IO`.
   subroutine abandon(self, status)
      class(sweep_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      if (self%keeps_rows) call self%file%abandon(status)
   end subroutine abandon

end module nutate_sweep
