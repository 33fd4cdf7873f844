!> Archives of bytes: values stored bit by bit, for checkpoints. Every value is stored with its type and size: an
!> archive that holds another value than is requested has failed.
module nutate_byte_archive
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: byte_archive_t

   !> Type of a value.
   character, parameter :: A_REAL = 'r', A_INTEGER = 'i', A_LONG = 'l', A_LOGICAL = 'b', A_TEXT = 't'
   !> Bytes of a size, and of the head of a value: its type and its size.
   integer, parameter :: size_bytes = storage_size(1_long)/8, head_bytes = 1 + size_bytes
   integer, parameter :: real_bytes = storage_size(1.0_wp)/8, integer_bytes = storage_size(1)/8

   !> Values as bytes.
   type, extends(archive_t) :: byte_archive_t
      private
      character(len=:), allocatable :: bytes
      !> Bytes in use, or already read.
      integer :: used = 0
   contains
      !> Empties the archive for writing.
      procedure, non_overridable :: begin_writing
      !> Makes the archive read values from given bytes.
      procedure, non_overridable :: begin_reading
      !> Returns the bytes written so far.
      procedure, non_overridable :: content
      procedure :: transfer_reals
      procedure :: transfer_integer
      procedure :: transfer_long
      procedure :: transfer_logical
      procedure :: transfer_text
   end type byte_archive_t

contains

   !> Empties the archive for writing.
   pure subroutine begin_writing(self)
      class(byte_archive_t), intent(inout) :: self
      integer, parameter :: first_size = 4096
      if (allocated(self%bytes)) deallocate (self%bytes)
      allocate (character(len=first_size) :: self%bytes)
      self%used = 0
      call self%set_direction(reading=.false.)
   end subroutine begin_writing

   !> Makes the archive read values from given bytes.
   pure subroutine begin_reading(self, bytes)
      class(byte_archive_t), intent(inout) :: self
      !> Bytes that `content` returned.
      character(len=*), intent(in) :: bytes
      self%bytes = bytes
      self%used = 0
      call self%set_direction(reading=.true.)
   end subroutine begin_reading

   !> Returns the bytes written so far.
   pure function content(self) result(bytes)
      class(byte_archive_t), intent(in) :: self
      character(len=:), allocatable :: bytes
      bytes = self%bytes(1:self%used)
   end function content

   subroutine transfer_reals(self, values)
      class(byte_archive_t), intent(inout) :: self
      real(wp), intent(inout) :: values(:)
      character(len=real_bytes*size(values)) :: bytes
      bytes = transfer(values, bytes)
      call pass(self, A_REAL, bytes)
      if (self%is_reading() .and. self%is_whole()) values = transfer(bytes, values)
   end subroutine transfer_reals

   subroutine transfer_integer(self, value)
      class(byte_archive_t), intent(inout) :: self
      integer, intent(inout) :: value
      character(len=integer_bytes) :: bytes
      bytes = transfer(value, bytes)
      call pass(self, A_INTEGER, bytes)
      value = transfer(bytes, value)
   end subroutine transfer_integer

   subroutine transfer_long(self, value)
      class(byte_archive_t), intent(inout) :: self
      integer(long), intent(inout) :: value
      character(len=size_bytes) :: bytes
      bytes = transfer(value, bytes)
      call pass(self, A_LONG, bytes)
      value = transfer(bytes, value)
   end subroutine transfer_long

   subroutine transfer_logical(self, value)
      class(byte_archive_t), intent(inout) :: self
      logical, intent(inout) :: value
      character(len=1) :: byte
      byte = merge('T', 'F', value)
      call pass(self, A_LOGICAL, byte)
      value = byte == 'T'
   end subroutine transfer_logical

   !> Writes or reads text of any length; reading restores the length.
   subroutine transfer_text(self, value)
      class(byte_archive_t), intent(inout) :: self
      !> Must be allocated when the archive is writing.
      character(len=:), allocatable, intent(inout) :: value
      integer(long) :: length
      if (self%is_reading()) then
         length = next_size(self)
         if (length < 0) then
            call self%spoil()
            return
         end if
         if (allocated(value)) deallocate (value)
         allocate (character(len=length) :: value)
      end if
      call pass(self, A_TEXT, value)
   end subroutine transfer_text

   !> Returns the size of the next value, bytes; -1 if the archive does not hold it.
   pure integer(long) function next_size(self)
      class(byte_archive_t), intent(in) :: self
      integer(long) :: left
      next_size = -1
      left = len(self%bytes) - self%used
      if (left < head_bytes) return
      next_size = transfer(self%bytes(self%used + 2:self%used + head_bytes), next_size)
      if (next_size < 0 .or. next_size > left - head_bytes) next_size = -1
   end function next_size

   !> Writes or reads the bytes of a value; a failed archive leaves them as they are.
   subroutine pass(self, kind, bytes)
      class(byte_archive_t), intent(inout) :: self
      character, intent(in) :: kind
      character(len=*), intent(inout) :: bytes
      if (.not. self%is_reading()) then
         call append(self, kind//transfer(len(bytes, long), repeat(' ', size_bytes)))
         call append(self, bytes)
         return
      end if
      if (self%is_whole()) then
         if (next_size(self) /= len(bytes, long)) call self%spoil()
      end if
      if (self%is_whole()) then
         if (self%bytes(self%used + 1:self%used + 1) /= kind) call self%spoil()
      end if
      if (.not. self%is_whole()) return
      bytes = self%bytes(self%used + head_bytes + 1:self%used + head_bytes + len(bytes))
      self%used = self%used + head_bytes + len(bytes)
   end subroutine pass

   !> Adds bytes; the room for them doubles when it is used up.
   pure subroutine append(self, bytes)
      class(byte_archive_t), intent(inout) :: self
      character(len=*), intent(in) :: bytes
      character(len=:), allocatable :: larger
      if (self%used + len(bytes) > len(self%bytes)) then
         allocate (character(len=2*(self%used + len(bytes))) :: larger)
         larger(1:self%used) = self%bytes(1:self%used)
         call move_alloc(larger, self%bytes)
      end if
      self%bytes(self%used + 1:self%used + len(bytes)) = bytes
      self%used = self%used + len(bytes)
   end subroutine append

end module nutate_byte_archive
