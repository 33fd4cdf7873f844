!> Rows of a sweep in progress: a NumPy file under another name, at its full size from the start, and behind the rows a
!> map of the chunks that are finished. A chunk is marked when it is on the disk, so that marked chunks are complete
!> whatever ends the program.
module nutate_sweep_file
   use, intrinsic :: iso_c_binding, only: c_null_char
   use nutate_file_calls, only: file_readable
   use nutate_files, only: output_file_t, partial_name
   use nutate_kinds, only: long
   use nutate_printable, only: printable_path
   use nutate_sealed_file, only: bytes_of
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: sweep_file_t, read_bytes

   !> First bytes of the map; the number is the version of its format.
   character(len=*), parameter :: signature = 'nutate sweep map 1'//achar(10)
   !> Bytes of a number.
   integer, parameter :: word = 8
   !> Bytes of the head of the map: the signature, the identity of the sweep, and the rows of a chunk.
   integer, parameter :: head = len(signature) + 2*word
   character, parameter :: open_mark = '.', done_mark = 'x'
   !> Bytes of a block that map and rows never share: on a network file system a machine may write back, with a mark,
   !> the whole page as it once read it, while another one writes the last rows.
   integer(long), parameter :: page = 65536

   !> File with rows at fixed positions.
   type :: sweep_file_t
      !> Rows of the file, and of a chunk; the last chunk may have fewer.
      integer(long) :: rows = 0, chunk = 1
      !> True for chunks that are finished; shape (chunks).
      logical, allocatable :: done(:)
      !> Bytes before the rows, and of a row.
      integer(long), private :: offset = 0, row_bytes = 0
      type(output_file_t), private :: file
   contains
      !> Starts a file, or continues one.
      procedure :: open => open_sweep
      !> Writes to a file that another process has started.
      procedure :: join
      !> Writes the rows of a chunk.
      procedure :: put_chunk
      !> Marks a chunk whose rows are on the disk.
      procedure :: mark
      !> Gives the file its name.
      procedure :: finish
      !> Leaves the file as it is.
      procedure :: abandon
   end type sweep_file_t

contains

   !> Starts a file, or continues one. Errors: `NUTATE_IO`; `NUTATE_BAD_ARGUMENT` for a file to continue that belongs to
   !> another scene.
   subroutine open_sweep(self, name, header, width, rows, chunk, identity, resume, status)
      class(sweep_file_t), intent(inout) :: self
      !> Path of the complete file.
      character(len=*), intent(in) :: name
      !> First bytes of the file.
      character(len=*), intent(in) :: header
      !> Fields of a row.
      integer, intent(in) :: width
      !> Rows of the file, and of a chunk; a continued file keeps its chunks.
      integer(long), intent(in) :: rows, chunk
      !> Identity of the sweep that the rows belong to.
      integer(long), intent(in) :: identity
      !> True to continue what an earlier sweep has left, if it has left anything.
      logical, intent(in) :: resume
      type(status_t), intent(out) :: status
      logical :: found

      call set_places(self, len(header), width, rows, chunk)
      found = .false.
      if (resume) call resume_file(self, name, header, identity, found, status)
      if (found .or. .not. status%ok()) return
      call self%file%open(name, status)
      if (status%ok()) call self%file%resize(map_at(self) + head + size(self%done), status)
      if (status%ok()) call self%file%put_at(map_at(self), signature//bytes_of(identity)//bytes_of(chunk)// &
                                             repeat(open_mark, size(self%done)), status)
      if (status%ok()) call self%file%put_at(0_long, header, status)
      if (status%ok()) call self%file%sync(status)
   end subroutine open_sweep

   !> Writes rows to a file that another process has started or continued, and that it marks and finishes. Errors:
   !> `NUTATE_IO`.
   subroutine join(self, name, header, width, rows, chunk, status)
      class(sweep_file_t), intent(inout) :: self
      !> Arguments as for `open`; the chunks are those of the file.
      character(len=*), intent(in) :: name, header
      integer, intent(in) :: width
      integer(long), intent(in) :: rows, chunk
      type(status_t), intent(out) :: status
      call set_places(self, len(header), width, rows, chunk)
      call self%file%open_beside(name, map_at(self) + head + size(self%done), status)
   end subroutine join

   !> Sets the positions of the rows, and marks no chunk as done.
   pure subroutine set_places(self, offset, width, rows, chunk)
      class(sweep_file_t), intent(inout) :: self
      !> Bytes before the rows; fields of a row.
      integer, intent(in) :: offset, width
      integer(long), intent(in) :: rows, chunk
      self%rows = rows
      self%chunk = chunk
      self%offset = offset
      self%row_bytes = int(width, long)*word
      if (allocated(self%done)) deallocate (self%done)
      allocate (self%done((rows + chunk - 1)/chunk), source=.false.)
   end subroutine set_places

   !> Returns the bytes of header and rows.
   pure integer(long) function whole_bytes(self)
      class(sweep_file_t), intent(in) :: self
      whole_bytes = self%offset + self%rows*self%row_bytes
   end function whole_bytes

   !> Returns the bytes before the map.
   pure integer(long) function map_at(self)
      class(sweep_file_t), intent(in) :: self
      map_at = (whole_bytes(self) + page - 1)/page*page
   end function map_at

   !> Continues the file of an earlier sweep.
   subroutine resume_file(self, name, header, identity, found, status)
      class(sweep_file_t), intent(inout) :: self
      character(len=*), intent(in) :: name, header
      integer(long), intent(in) :: identity
      !> True if there is such a file.
      logical, intent(out) :: found
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: partial, bytes, begin, marks
      integer(long) :: n, i

      partial = partial_name(name)
      found = .false.
      if (partial == '') return
      call read_bytes(partial, map_at(self), head, bytes)
      call read_bytes(partial, 0_long, len(header), begin)
      if (len(bytes) < head .or. begin /= header) then
         if (len(bytes) == 0 .and. len(begin) == 0) return
      else if (index(bytes, signature//bytes_of(identity)) == 1) then
         self%chunk = transfer(bytes(head - word + 1:), self%chunk)
         found = self%chunk > 0
      end if
      if (.not. found) then
         status = fail(NUTATE_BAD_ARGUMENT, printable_path(partial)//' belongs to another sweep')
         return
      end if
      n = (self%rows + self%chunk - 1)/self%chunk
      call self%file%reopen_whole(name, map_at(self) + head + n, status)
      if (.not. status%ok()) return
      call read_bytes(partial, map_at(self) + head, int(n), marks)
      deallocate (self%done)
      allocate (self%done(n), source=.false.)
      do i = 1, len(marks, long)
         self%done(i) = marks(i:i) == done_mark
      end do
   end subroutine resume_file

   !> Writes the rows of a chunk, and returns when they are on the disk. For several threads at once.
   subroutine put_chunk(self, chunk, fields, error)
      class(sweep_file_t), intent(in) :: self
      integer(long), intent(in) :: chunk
      !> Shape (fields, rows of the chunk).
      integer(long), intent(in) :: fields(:, :)
      !> Error code of the operating system, for `error_text`; 0: none.
      integer, intent(out) :: error
      call self%file%put_safely(self%offset + (chunk - 1)*self%chunk*self%row_bytes, fields, error)
   end subroutine put_chunk

   !> Marks a chunk whose rows are on the disk. Errors: `NUTATE_IO`.
   subroutine mark(self, chunk, status)
      class(sweep_file_t), intent(inout) :: self
      integer(long), intent(in) :: chunk
      type(status_t), intent(out) :: status
      call self%file%put_at(map_at(self) + head + chunk - 1, done_mark, status)
      self%done(chunk) = status%ok()
   end subroutine mark

   !> Cuts the map off and gives the file its name. Errors: `NUTATE_IO`.
   subroutine finish(self, status)
      class(sweep_file_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      call self%file%resize(whole_bytes(self), status)
      if (status%ok()) call self%file%sync(status)
      if (status%ok()) call self%file%finish(status)
   end subroutine finish

   !> Leaves the file as it is, to be continued. Errors: `NUTATE_IO`.
   subroutine abandon(self, status)
      class(sweep_file_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      call self%file%abandon(status)
   end subroutine abandon

   !> Reads some bytes of a file; fewer, or none, if it has no more or cannot be read.
   subroutine read_bytes(path, offset, count, bytes)
      character(len=*), intent(in) :: path
      !> Number of bytes before the first one that is read.
      integer(long), intent(in) :: offset
      integer, intent(in) :: count
      character(len=:), allocatable, intent(out) :: bytes
      integer :: unit, iostat
      integer(long) :: there
      bytes = ''
      if (file_readable(path//c_null_char) /= 0) return
      open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', iostat=iostat)
      if (iostat /= 0) return
      inquire (unit=unit, size=there)
      there = max(min(int(count, long), there - offset), 0_long)
      deallocate (bytes)
      allocate (character(len=there) :: bytes)
      iostat = 0
      if (there > 0) read (unit, pos=offset + 1, iostat=iostat) bytes
      if (iostat /= 0) bytes = ''
      close (unit)
   end subroutine read_bytes

end module nutate_sweep_file
