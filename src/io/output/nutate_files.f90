!> Output that is either complete or recognisably incomplete: files have another name until they are whole, and errors
!> are reported.
!>
!> The Fortran runtimes buffer what they write and lose errors of the disk, so bytes go through the system's own
!> `write` (`nutate_files.c`). A regular file `NAME` is written as `NAME.partial`, locked against a second writer,
!> and renamed by `finish`; standard output, pipes and devices are written directly. A link is followed to its target,
!> which need not exist, and stays.
module nutate_files
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_loc, c_long_long, c_null_char, c_null_ptr, &
      c_ptr
   use nutate_archive, only: archive_t
   use nutate_checksum, only: checksum
   use nutate_file_calls, only: file_close, file_is_terminal, file_kind, file_open, file_open_beside, &
      file_open_locked, file_read_tail, file_remove, file_rename, file_replace, file_replaceable, file_same, &
      file_settle, file_sync, file_target, file_truncate, file_write, file_write_at, prepare_process, &
      KIND_ABSENT, KIND_FOLDER, KIND_REGULAR
   use nutate_kinds, only: long
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_IO
   use nutate_system_text, only: error_text, text_of
   implicit none
   private

   public :: output_file_t, write_text, is_terminal, same_file, file_exists, goes_to_file, replace_file
   public :: partial_name, remove_file, prepare_process, STANDARD_OUTPUT, STANDARD_ERROR

   !> Descriptors that every process has.
   integer, parameter :: STANDARD_OUTPUT = 1, STANDARD_ERROR = 2
   !> Bytes collected before they are handed to the system.
   integer, parameter :: buffer_size = 65536
   !> Longest path.
   integer, parameter :: path_size = 4096
   !> Suffixes of the names of files that are not complete, and of files that are to replace another.
   character(len=*), parameter :: partial_suffix = '.partial', replacing_suffix = '.tmp'
   !> Names that mean a descriptor of this process, and the descriptors.
   character(len=11), parameter :: descriptor_names(5) = &
      [character(len=11) :: '-', '/dev/stdout', '/dev/fd/1', '/dev/stderr', '/dev/fd/2']
   integer, parameter :: descriptors(5) = &
      [STANDARD_OUTPUT, STANDARD_OUTPUT, STANDARD_OUTPUT, STANDARD_ERROR, STANDARD_ERROR]

   !> Results of `nutate_file_open_locked` if another process holds the lock, and if the file is too short;
   !> `nutate_files.c` has the same numbers.
   integer, parameter :: LOCKED = -1, TOO_SHORT = -2
   !> Number of bytes at the end of a file by which it is recognised.
   integer, parameter :: tail_size = 4096

   !> A file being written line by line.
   type :: output_file_t
      !> Name as given; `-` is standard output.
      character(len=:), allocatable :: name
      !> Path of the file until it is complete; not allocated if output is written directly.
      character(len=:), allocatable :: partial
      !> Bytes handed to the system.
      integer(long) :: bytes = 0
      !> Address of a C `sig_atomic_t`, or null: once its value is nonzero, writing does not wait for readers of a pipe.
      type(c_ptr) :: stop_flag = c_null_ptr
      !> Bytes of whole lines among those handed to the system.
      integer(long), private :: whole_bytes = 0
      character(len=:), allocatable, private :: target
      character(len=:), allocatable, private :: buffer
      integer, private :: used = 0
      integer, private :: descriptor = -1
   contains
      !> Starts writing.
      procedure, non_overridable :: open => open_output
      !> Continues a file where another run stopped.
      procedure, non_overridable :: reopen
      !> Reopens a file of a known size for writing to any part of it.
      procedure, non_overridable :: reopen_whole
      !> Opens a file that another process has open, for writing to parts of it.
      procedure, non_overridable :: open_beside
      !> Gives the file a size.
      procedure, non_overridable :: resize
      !> Writes bytes at a position, past all buffers.
      procedure, non_overridable :: put_at
      !> Writes numbers at a position and syncs them to the disk; several threads may call it at once.
      procedure, non_overridable :: put_safely
      !> Syncs the bytes handed to the system to the disk.
      procedure, non_overridable :: sync
      !> Writes everything to the disk, and returns how far the file is.
      procedure, non_overridable :: record
      !> Appends one line.
      procedure, non_overridable :: put_line
      !> Hands everything to the system.
      procedure, non_overridable :: flush => flush_output
      !> Writes the rest and gives the file its name.
      procedure, non_overridable :: finish
      !> Writes the rest and leaves the partial file as it is.
      procedure, non_overridable :: abandon
      !> Does the first of these if the status is a success, else the second.
      procedure, non_overridable :: close => close_output
      !> Returns the path at which the whole lines written so far can be read; blank if there is none.
      procedure, non_overridable :: kept_in
   end type output_file_t

contains

   !> Starts writing to a name. Errors: `NUTATE_IO` with the reason; nothing has been changed then.
   subroutine open_output(self, name, status)
      class(output_file_t), intent(inout) :: self
      !> A path, or `-` for standard output.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      integer :: i
      call begin(self, name)
      do i = 1, size(descriptors)
         if (name == descriptor_names(i)) then
            self%descriptor = descriptors(i)
            return
         end if
      end do
      select case (file_kind(name//c_null_char))
      case (KIND_FOLDER)
         status = fail(NUTATE_IO, 'it is a folder')
      case (KIND_ABSENT, KIND_REGULAR)
         call open_partial(self, status)
      case default
         status = status_of(file_open(name//c_null_char, self%stop_flag, self%descriptor))
      end select
   end subroutine open_output

   !> Resets the object for output to a name.
   subroutine begin(self, name)
      class(output_file_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      self%name = name
      self%used = 0
      self%bytes = 0
      self%whole_bytes = 0
      if (allocated(self%partial)) deallocate (self%partial)
      if (.not. allocated(self%buffer)) allocate (character(len=buffer_size) :: self%buffer)
   end subroutine begin

   !> Continues the partial file that another run left, after the bytes that it recorded; later bytes are cut off.
   !> Errors: `NUTATE_BAD_ARGUMENT` for checkpoint data that cannot be read; `NUTATE_IO` if that file does not exist or
   !> has changed; nothing has been changed then.
   subroutine reopen(self, name, archive, status)
      class(output_file_t), intent(inout) :: self
      !> Name that `open` received.
      character(len=*), intent(in) :: name
      !> Checkpoint data being read.
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      integer(long) :: recorded, tail
      integer :: error, ignored
      call begin(self, name)
      recorded = 0
      call archive%transfer(self%bytes)
      call archive%transfer(recorded)
      if (archive%problem() /= '') then
         status = fail(NUTATE_BAD_ARGUMENT, 'the checkpoint data cannot be resumed: '//archive%problem())
         return
      end if
      self%whole_bytes = self%bytes
      call open_partial(self, status)
      if (.not. status%ok()) return
      call get_tail(self%partial, self%bytes, tail, error)
      if (error == 0 .and. tail /= recorded) then
         status = fail(NUTATE_IO, 'its rows have changed')
      else
         if (error == 0) error = file_truncate(self%descriptor, self%bytes)
         status = status_of(error)
      end if
      if (.not. status%ok()) call release(self, ignored)
   end subroutine reopen

   !> Reopens the partial file that another run left, for writing to any part of it. Errors: `NUTATE_IO` if it does not
   !> exist or is shorter; nothing has been changed then.
   subroutine reopen_whole(self, name, bytes, status)
      class(output_file_t), intent(inout) :: self
      !> Name that `open` received.
      character(len=*), intent(in) :: name
      !> Size of the partial file, bytes.
      integer(long), intent(in) :: bytes
      type(status_t), intent(out) :: status
      call begin(self, name)
      self%whole_bytes = bytes
      call open_partial(self, status)
   end subroutine reopen_whole

   !> Opens the partial file that another process has open and will finish, for writing to parts of it by `put_safely`;
   !> `abandon` closes it. Errors: `NUTATE_IO` if it does not exist or is shorter.
   subroutine open_beside(self, name, bytes, status)
      class(output_file_t), intent(inout) :: self
      !> Name that the other process gave to `open`.
      character(len=*), intent(in) :: name
      !> Size of the partial file, bytes.
      integer(long), intent(in) :: bytes
      type(status_t), intent(out) :: status
      call begin(self, name)
      self%partial = partial_name(name)
      status = status_of(file_open_beside(self%partial//c_null_char, bytes, self%descriptor))
   end subroutine open_beside

   !> Gives the file a size: cuts it, or fills it with zeros. Errors: `NUTATE_IO`.
   subroutine resize(self, bytes, status)
      class(output_file_t), intent(inout) :: self
      integer(long), intent(in) :: bytes
      type(status_t), intent(out) :: status
      status = status_of(file_truncate(self%descriptor, bytes))
      self%whole_bytes = bytes
   end subroutine resize

   !> Writes bytes at a position. Errors: `NUTATE_IO`.
   subroutine put_at(self, offset, bytes, status)
      class(output_file_t), intent(in) :: self
      !> Number of bytes before the position.
      integer(long), intent(in) :: offset
      character(len=*), intent(in), target :: bytes
      type(status_t), intent(out) :: status
      status = status_of(file_write_at(self%descriptor, c_loc(bytes(1:1)), len(bytes, c_long_long), offset))
   end subroutine put_at

   !> Writes numbers at a position and syncs them to the disk.
   subroutine put_safely(self, offset, words, error)
      class(output_file_t), intent(in) :: self
      integer(long), intent(in) :: offset
      !> Numbers of 8 bytes each.
      integer(long), intent(in), contiguous, target :: words(:, :)
      !> Error number of the system, for `error_text`; 0: no error.
      integer, intent(out) :: error
      error = file_write_at(self%descriptor, c_loc(words), 8*size(words, kind=c_long_long), offset)
      if (error == 0) error = file_sync(self%descriptor)
   end subroutine put_safely

   !> Syncs the bytes handed to the system to the disk. Errors: `NUTATE_IO`.
   subroutine sync(self, status)
      class(output_file_t), intent(in) :: self
      type(status_t), intent(out) :: status
      status = status_of(file_sync(self%descriptor))
   end subroutine sync

   !> Writes everything to the disk, and records in checkpoint data how far the file is. Errors: `NUTATE_IO`.
   subroutine record(self, archive, status)
      class(output_file_t), intent(inout) :: self
      !> Checkpoint data being written.
      class(archive_t), intent(inout) :: archive
      type(status_t), intent(out) :: status
      integer(long) :: tail
      integer :: error
      call self%flush(status)
      if (status%ok()) call self%sync(status)
      if (.not. status%ok()) return
      call get_tail(self%partial, self%bytes, tail, error)
      status = status_of(error)
      call archive%transfer(self%bytes)
      call archive%transfer(tail)
   end subroutine record

   !> Computes the checksum of the last bytes of a file before a position.
   subroutine get_tail(path, end, tail, error)
      character(len=*), intent(in) :: path
      integer(long), intent(in) :: end
      integer(long), intent(out) :: tail
      integer, intent(out) :: error
      character(kind=c_char, len=tail_size) :: bytes
      integer(c_int) :: count
      tail = 0
      count = 0
      error = file_read_tail(path//c_null_char, end, bytes, tail_size, count)
      if (error == 0) tail = checksum(bytes(1:count))
   end subroutine get_tail

   !> Starts writing a regular file under its partial name: after the bytes to be kept, or from its beginning.
   subroutine open_partial(self, status)
      !> Output whose first `whole_bytes` bytes are to be kept.
      class(output_file_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: partial
      integer :: error
      call find_target(self%name, partial_suffix, self%target, partial, error)
      if (error == 0) then
         if (file_kind(self%target//c_null_char) == KIND_REGULAR) error = file_replaceable(self%target//c_null_char)
      end if
      status = status_of(error)
      if (.not. status%ok()) return
      call move_alloc(partial, self%partial)
      error = file_open_locked(self%partial//c_null_char, self%whole_bytes, self%descriptor)
      if (error == LOCKED) then
         status = fail(NUTATE_IO, 'another run is writing it')
      else if (error == TOO_SHORT) then
         status = fail(NUTATE_IO, 'it has fewer rows than before')
      else
         status = status_of(error)
      end if
   end subroutine open_partial

   !> Finds the file that a path stands for, and the name of a file beside it that is to become it.
   subroutine find_target(path, suffix, target, unfinished, error)
      character(len=*), intent(in) :: path, suffix
      character(len=:), allocatable, intent(out) :: target, unfinished
      !> Error number of the system; 0: no error.
      integer, intent(out) :: error
      character(kind=c_char) :: found(path_size)
      integer(c_int) :: longest
      error = file_target(path//c_null_char, found, path_size, longest)
      target = path
      if (error == 0) target = text_of(found)
      unfinished = with_suffix(target, suffix, int(longest))
   end subroutine find_target

   !> Returns a path with a suffix. If the name would become too long, a checksum of it replaces its end, so that names
   !> that begin alike stay different.
   pure function with_suffix(path, suffix, longest) result(longer)
      character(len=*), intent(in) :: path, suffix
      !> Largest number of bytes of a name.
      integer, intent(in) :: longest
      character(len=:), allocatable :: longer
      character(len=16) :: digits
      integer :: folder, kept
      folder = index(path, '/', back=.true.)
      longer = path//suffix
      if (len(longer) - folder <= longest) return
      write (digits, '(z16.16)') checksum(path(folder + 1:))
      kept = max(longest - len('-') - len(digits) - len(suffix), 0)
      ! Letters of several bytes (UTF-8) are left out whole: all of their bytes but the first begin with the bits 10.
      do while (kept > 0)
         if (iand(ichar(path(folder + kept + 1:folder + kept + 1)), 192) /= 128) exit
         kept = kept - 1
      end do
      longer = path(1:folder + kept)//'-'//digits//suffix
   end function with_suffix

   !> Appends one line. Errors: `NUTATE_IO`, whole lines handed to the system before are kept.
   subroutine put_line(self, line, status)
      class(output_file_t), intent(inout) :: self
      !> Line without its line end.
      character(len=*), intent(in) :: line
      type(status_t), intent(out) :: status
      if (self%used + len(line) + 1 > buffer_size) then
         call self%flush(status)
         if (.not. status%ok()) return
         if (len(line) + 1 > buffer_size) then
            call write_block(self, line//new_line('a'), status)
            return
         end if
      end if
      self%buffer(self%used + 1:self%used + len(line)) = line
      self%used = self%used + len(line) + 1
      self%buffer(self%used:self%used) = new_line('a')
   end subroutine put_line

   !> Hands everything to the system. Errors: `NUTATE_IO`.
   subroutine flush_output(self, status)
      class(output_file_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      integer :: used
      used = self%used
      self%used = 0
      if (used > 0) call write_block(self, self%buffer(1:used), status)
   end subroutine flush_output

   !> Hands whole lines to the system. If it accepts only some of the bytes, a partial file is cut back to its last
   !> whole line.
   subroutine write_block(self, block, status)
      class(output_file_t), intent(inout) :: self
      character(len=*), intent(in) :: block
      type(status_t), intent(out) :: status
      integer(c_long_long) :: written
      integer :: error
      error = file_write(self%descriptor, block, len(block, c_long_long), self%stop_flag, written)
      self%bytes = self%bytes + written
      self%whole_bytes = self%whole_bytes + index(block(1:written), new_line('a'), back=.true.)
      if (error == 0) return
      status = fail(NUTATE_IO, error_text(error))
      if (.not. allocated(self%partial)) return
      if (file_truncate(self%descriptor, self%whole_bytes) == 0) self%bytes = self%whole_bytes
   end subroutine write_block

   !> Writes the rest and gives the file its name. Errors: `NUTATE_IO`; the partial file stays.
   subroutine finish(self, status)
      class(output_file_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      integer :: error
      call self%flush(status)
      if (status%ok() .and. allocated(self%partial)) then
         ! The file is renamed while the lock is held: otherwise another run could empty it in between.
         error = file_settle(self%descriptor)
         if (error == 0) error = file_rename(self%partial//c_null_char, self%target//c_null_char)
         status = status_of(error)
      end if
      call release(self, error)
      if (status%ok()) status = status_of(error)
   end subroutine finish

   !> Writes the rest and leaves the partial file as it is. Errors: `NUTATE_IO`.
   subroutine abandon(self, status)
      class(output_file_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      integer :: error
      if (self%descriptor < 0) return
      call self%flush(status)
      call release(self, error)
      if (status%ok()) status = status_of(error)
   end subroutine abandon

   !> Writes the rest; gives the file its name if the status is a success. Errors: `NUTATE_IO`; others are kept.
   subroutine close_output(self, status)
      class(output_file_t), intent(inout) :: self
      type(status_t), intent(inout) :: status
      type(status_t) :: closing
      if (status%ok()) then
         call self%finish(status)
      else
         call self%abandon(closing)
      end if
   end subroutine close_output

   !> Closes the file or device; standard output and standard error stay open.
   subroutine release(self, error)
      class(output_file_t), intent(inout) :: self
      integer, intent(out) :: error
      error = 0
      if (self%descriptor > STANDARD_ERROR) error = file_close(self%descriptor)
      self%descriptor = -1
   end subroutine release

   !> Returns the path at which the whole lines written so far can be read; blank if there is none.
   pure function kept_in(self) result(path)
      class(output_file_t), intent(in) :: self
      character(len=:), allocatable :: path
      path = ''
      if (allocated(self%partial) .and. self%whole_bytes > 0) path = self%partial
   end function kept_in

   !> Writes text to a descriptor at once. Errors: `NUTATE_IO`.
   subroutine write_text(descriptor, text, status)
      !> `STANDARD_OUTPUT` or `STANDARD_ERROR`.
      integer, intent(in) :: descriptor
      character(len=*), intent(in) :: text
      type(status_t), intent(out) :: status
      integer(c_long_long) :: written
      status = status_of(file_write(int(descriptor, c_int), text, len(text, c_long_long), c_null_ptr, written))
   end subroutine write_text

   !> Returns true if a descriptor is a terminal.
   logical function is_terminal(descriptor)
      !> `STANDARD_OUTPUT` or `STANDARD_ERROR`.
      integer, intent(in) :: descriptor
      is_terminal = file_is_terminal(int(descriptor, c_int)) /= 0
   end function is_terminal

   !> Returns true if two paths stand for the same file, existing or still to be written.
   logical function same_file(a, b)
      character(len=*), intent(in) :: a, b
      same_file = file_same(a//c_null_char, b//c_null_char) /= 0
   end function same_file

   !> Returns the name of the partial file of a path, which is written until the file is whole; blank if there is none.
   function partial_name(path) result(name)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: name, target
      integer :: error
      call find_target(path, partial_suffix, target, name, error)
      if (error /= 0 .or. .not. file_exists(name)) name = ''
   end function partial_name

   !> Returns true if a path stands for anything that exists.
   logical function file_exists(path)
      character(len=*), intent(in) :: path
      file_exists = file_kind(path//c_null_char) /= KIND_ABSENT
   end function file_exists

   !> Returns true if output to a name is a regular file, which has a partial file while it is written.
   logical function goes_to_file(name)
      character(len=*), intent(in) :: name
      goes_to_file = all(name /= descriptor_names) .and. &
                     any(file_kind(name//c_null_char) == [KIND_ABSENT, KIND_REGULAR])
   end function goes_to_file

   !> Replaces the content of a file at once; a crash leaves the old or the new content. Errors: `NUTATE_IO`; the old
   !> content stays.
   subroutine replace_file(path, bytes, status)
      character(len=*), intent(in) :: path, bytes
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: target, temporary
      integer :: error
      call find_target(path, replacing_suffix, target, temporary, error)
      if (error == 0) error = file_replace(target//c_null_char, temporary//c_null_char, bytes, len(bytes, c_long_long))
      status = status_of(error)
   end subroutine replace_file

   !> Removes a file; links to it stay. Errors: `NUTATE_IO`.
   subroutine remove_file(path, status)
      character(len=*), intent(in) :: path
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: target, unused
      integer :: error
      call find_target(path, replacing_suffix, target, unused, error)
      if (error == 0) error = file_remove(target//c_null_char)
      status = status_of(error)
   end subroutine remove_file

   !> Returns the status of a call of the system: `NUTATE_IO` with the words for an error number that is not 0.
   type(status_t) function status_of(error) result(status)
      integer, intent(in) :: error
      if (error /= 0) status = fail(NUTATE_IO, error_text(error))
   end function status_of

end module nutate_files
