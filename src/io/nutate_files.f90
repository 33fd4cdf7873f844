!> Output that is complete or recognisably is not: files written under another name until they are whole, and honest
!> errors.
!>
!> The Fortran runtimes buffer what they write and lose errors of the disk, so bytes go through the system's own
!> `write` (`nutate_files.c`). A regular file `NAME` is written as `NAME.partial`, locked against a second writer,
!> and renamed by `finish`; standard output, pipes and devices are written directly.
module nutate_files
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long_long, c_null_char
   use nutate_kinds, only: long
   use nutate_status, only: status_t, fail, NUTATE_IO
   implicit none
   private

   public :: output_file_t, write_text, is_terminal, same_file, prepare_process, STANDARD_OUTPUT, STANDARD_ERROR

   !> Descriptors that every process has.
   integer, parameter :: STANDARD_OUTPUT = 1, STANDARD_ERROR = 2
   !> Bytes collected before they are handed to the system.
   integer, parameter :: buffer_size = 65536
   !> Longest path.
   integer, parameter :: path_size = 4096
   !> What is appended to the name of a file that is not complete.
   character(len=*), parameter :: partial_suffix = '.partial'
   !> Names that mean a descriptor of this process, and the descriptors.
   character(len=11), parameter :: descriptor_names(5) = &
      [character(len=11) :: '-', '/dev/stdout', '/dev/fd/1', '/dev/stderr', '/dev/fd/2']
   integer, parameter :: descriptors(5) = &
      [STANDARD_OUTPUT, STANDARD_OUTPUT, STANDARD_OUTPUT, STANDARD_ERROR, STANDARD_ERROR]

   !> What a name stands for; the same numbers stand in `nutate_files.c`.
   integer, parameter :: KIND_ABSENT = 0, KIND_REGULAR = 1, KIND_FOLDER = 2
   !> What `nutate_file_open_locked` returns where somebody else holds the lock; the same number stands there.
   integer, parameter :: LOCKED = -1

   !> A file being written line by line.
   type :: output_file_t
      !> As asked for; `-` is standard output.
      character(len=:), allocatable :: name
      !> Where the bytes go until the file is complete; not allocated for what is written directly.
      character(len=:), allocatable :: partial
      !> Bytes handed to the system.
      integer(long) :: bytes = 0
      !> Bytes of whole lines among these.
      integer(long), private :: whole_bytes = 0
      character(len=:), allocatable, private :: target
      character(len=:), allocatable, private :: buffer
      integer, private :: used = 0
      integer, private :: descriptor = -1
   contains
      !> Starts writing.
      procedure :: open => open_output
      !> Appends one line.
      procedure :: put_line
      !> Hands everything to the system.
      procedure :: flush => flush_output
      !> Writes what is left and gives the file its name.
      procedure :: finish
      !> Writes what is left and leaves the partial file as it is.
      procedure :: abandon
      !> Where the whole lines written so far can be read; blank where they cannot.
      procedure :: kept_in
   end type output_file_t

   interface
      integer(c_int) function file_kind(path) bind(c, name='nutate_file_kind')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
      end function file_kind
      integer(c_int) function file_target(path, target, size) bind(c, name='nutate_file_target')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
         character(kind=c_char), intent(out) :: target(*)
         integer(c_int), intent(in), value :: size
      end function file_target
      integer(c_int) function file_same(a, b) bind(c, name='nutate_file_same')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: a(*), b(*)
      end function file_same
      integer(c_int) function file_replaceable(path) bind(c, name='nutate_file_replaceable')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
      end function file_replaceable
      integer(c_int) function file_open(path, descriptor) bind(c, name='nutate_file_open')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), intent(out) :: descriptor
      end function file_open
      integer(c_int) function file_open_locked(path, descriptor) bind(c, name='nutate_file_open_locked')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)
         integer(c_int), intent(out) :: descriptor
      end function file_open_locked
      integer(c_int) function file_write(descriptor, bytes, count, written) bind(c, name='nutate_file_write')
         import :: c_char, c_int, c_long_long
         integer(c_int), intent(in), value :: descriptor
         character(kind=c_char), intent(in) :: bytes(*)
         integer(c_long_long), intent(in), value :: count
         integer(c_long_long), intent(out) :: written
      end function file_write
      integer(c_int) function file_truncate(descriptor, size) bind(c, name='nutate_file_truncate')
         import :: c_int, c_long_long
         integer(c_int), intent(in), value :: descriptor
         integer(c_long_long), intent(in), value :: size
      end function file_truncate
      integer(c_int) function file_settle(descriptor) bind(c, name='nutate_file_settle')
         import :: c_int
         integer(c_int), intent(in), value :: descriptor
      end function file_settle
      integer(c_int) function file_close(descriptor) bind(c, name='nutate_file_close')
         import :: c_int
         integer(c_int), intent(in), value :: descriptor
      end function file_close
      integer(c_int) function file_rename(from, to) bind(c, name='nutate_file_rename')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: from(*), to(*)
      end function file_rename
      integer(c_int) function file_is_terminal(descriptor) bind(c, name='nutate_file_is_terminal')
         import :: c_int
         integer(c_int), intent(in), value :: descriptor
      end function file_is_terminal
      !> For a program, to be called first: makes a limit on the size of files an error of writing, keeps the
      !> runtime's backtraces away from signals that end the program, and keeps the numbers of closed standard
      !> streams from other files.
      subroutine prepare_process() bind(c, name='nutate_file_prepare_process')
      end subroutine prepare_process
      subroutine file_error_text(error, text, size) bind(c, name='nutate_file_error_text')
         import :: c_char, c_int
         integer(c_int), intent(in), value :: error
         character(kind=c_char), intent(out) :: text(*)
         integer(c_int), intent(in), value :: size
      end subroutine file_error_text
   end interface

contains

   !> Starts writing to a name. Errors: `NUTATE_IO` with the reason; nothing has been changed then.
   subroutine open_output(self, name, status)
      class(output_file_t), intent(inout) :: self
      !> A path, or `-` for standard output.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      integer :: i, error

      self%name = name
      self%used = 0
      self%bytes = 0
      self%whole_bytes = 0
      if (allocated(self%partial)) deallocate (self%partial)
      if (.not. allocated(self%buffer)) allocate (character(len=buffer_size) :: self%buffer)
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
         error = file_open(name//c_null_char, self%descriptor)
         if (error /= 0) status = fail(NUTATE_IO, error_text(error))
      end select
   end subroutine open_output

   !> Starts writing a regular file under its partial name.
   subroutine open_partial(self, status)
      class(output_file_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      character(kind=c_char) :: path(path_size)
      integer :: error

      error = file_target(self%name//c_null_char, path, path_size)
      if (error == 0) then
         self%target = text_of(path)
         if (file_kind(self%target//c_null_char) == KIND_REGULAR) error = file_replaceable(self%target//c_null_char)
      end if
      if (error /= 0) then
         status = fail(NUTATE_IO, error_text(error))
         return
      end if
      self%partial = self%target//partial_suffix
      error = file_open_locked(self%partial//c_null_char, self%descriptor)
      if (error == LOCKED) then
         status = fail(NUTATE_IO, 'another run is writing it')
      else if (error /= 0) then
         status = fail(NUTATE_IO, error_text(error))
      end if
   end subroutine open_partial

   !> Appends one line. Errors: `NUTATE_IO`, whole lines handed to the system before are kept.
   subroutine put_line(self, line, status)
      class(output_file_t), intent(inout) :: self
      !> Without its line end.
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

   !> Hands whole lines to the system. Where it takes only some of the bytes, a partial file is cut back to its last
   !> whole line.
   subroutine write_block(self, block, status)
      class(output_file_t), intent(inout) :: self
      character(len=*), intent(in) :: block
      type(status_t), intent(out) :: status
      integer(c_long_long) :: written
      integer :: error

      error = file_write(self%descriptor, block, len(block, c_long_long), written)
      self%bytes = self%bytes + written
      self%whole_bytes = self%whole_bytes + index(block(1:written), new_line('a'), back=.true.)
      if (error == 0) return
      status = fail(NUTATE_IO, error_text(error))
      if (.not. allocated(self%partial)) return
      if (file_truncate(self%descriptor, self%whole_bytes) == 0) self%bytes = self%whole_bytes
   end subroutine write_block

   !> Writes what is left and gives the file its name. Errors: `NUTATE_IO`; the partial file stays.
   subroutine finish(self, status)
      class(output_file_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      integer :: error

      call self%flush(status)
      if (status%ok() .and. allocated(self%partial)) then
         ! Renamed while the lock is held: otherwise another run could empty it in between.
         error = file_settle(self%descriptor)
         if (error == 0) error = file_rename(self%partial//c_null_char, self%target//c_null_char)
         if (error /= 0) status = fail(NUTATE_IO, error_text(error))
      end if
      call release(self, error)
      if (status%ok() .and. error /= 0) status = fail(NUTATE_IO, error_text(error))
   end subroutine finish

   !> Writes what is left and leaves the partial file as it is. Errors: `NUTATE_IO`.
   subroutine abandon(self, status)
      class(output_file_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      integer :: error
      if (self%descriptor < 0) return
      call self%flush(status)
      call release(self, error)
      if (status%ok() .and. error /= 0) status = fail(NUTATE_IO, error_text(error))
   end subroutine abandon

   !> Closes what was opened here; standard output and standard error stay open.
   subroutine release(self, error)
      class(output_file_t), intent(inout) :: self
      integer, intent(out) :: error
      error = 0
      if (self%descriptor > STANDARD_ERROR) error = file_close(self%descriptor)
      self%descriptor = -1
   end subroutine release

   !> Where the whole lines written so far can be read; blank where they cannot.
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
      integer :: error
      error = file_write(int(descriptor, c_int), text, len(text, c_long_long), written)
      if (error /= 0) status = fail(NUTATE_IO, error_text(error))
   end subroutine write_text

   !> True if a descriptor is a terminal.
   logical function is_terminal(descriptor)
      !> `STANDARD_OUTPUT` or `STANDARD_ERROR`.
      integer, intent(in) :: descriptor
      is_terminal = file_is_terminal(int(descriptor, c_int)) /= 0
   end function is_terminal

   !> True if two paths stand for the same existing file.
   logical function same_file(a, b)
      character(len=*), intent(in) :: a, b
      same_file = file_same(a//c_null_char, b//c_null_char) /= 0
   end function same_file

   !> The system's words for an error.
   function error_text(error) result(text)
      integer, intent(in) :: error
      character(len=:), allocatable :: text
      character(kind=c_char) :: words(200)
      call file_error_text(int(error, c_int), words, size(words))
      text = text_of(words)
   end function error_text

   !> Text up to the terminating null.
   pure function text_of(characters) result(text)
      character(kind=c_char), intent(in) :: characters(:)
      character(len=:), allocatable :: text
      integer :: n, i
      n = findloc(characters, c_null_char, dim=1) - 1
      allocate (character(len=n) :: text)
      do i = 1, n
         text(i:i) = characters(i)
      end do
   end function text_of

end module nutate_files
