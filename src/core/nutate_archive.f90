!> Archives: values put aside bit by bit, to be taken up again by the same procedure that put them there.
!>
!> Whatever must survive an interruption has one procedure that shows its values to an archive, `transfer`. An archive
!> that is being filled takes each value; one that is being read puts what it holds in its place. So both always agree.
!> Every value has its type and size with it: an archive that holds something else than is asked for has failed.
module nutate_archive
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: archive_t

   !> What a value is.
   character, parameter :: A_REAL = 'r', A_INTEGER = 'i', A_LONG = 'l', A_LOGICAL = 'b', A_TEXT = 't'
   !> Bytes of a size, and of what stands before a value: what it is, and its size.
   integer, parameter :: size_bytes = storage_size(1_long)/8, head_bytes = 1 + size_bytes
   integer, parameter :: real_bytes = storage_size(1.0_wp)/8, integer_bytes = storage_size(1)/8

   !> Values in the order in which they were transferred.
   type :: archive_t
      private
      character(len=:), allocatable :: bytes
      !> Bytes in use, or already read.
      integer :: used = 0
      logical :: writing = .true.
      logical :: spoiled = .false.
      !> Why a value cannot be kept; not allocated where it can.
      character(len=:), allocatable :: obstacle
   contains
      !> Empties the archive and makes it take values.
      procedure :: begin_writing
      !> Makes the archive give back what these bytes hold.
      procedure :: begin_reading
      !> The bytes written so far.
      procedure :: content
      !> True where the archive gives values back.
      procedure :: is_reading
      !> Notes that something cannot be archived.
      procedure :: refuse
      !> Why the archive is not what it should be; empty for a good one.
      procedure :: problem
      !> Takes a value, or gives it back: scalars; arrays of reals, whose shape both sides know; allocatable text.
      generic :: transfer => transfer_real, transfer_reals, transfer_matrix, transfer_integer, transfer_long, &
         transfer_logical, transfer_text
      procedure, private :: transfer_real
      procedure, private :: transfer_reals
      procedure, private :: transfer_matrix
      procedure, private :: transfer_integer
      procedure, private :: transfer_long
      procedure, private :: transfer_logical
      procedure, private :: transfer_text
   end type archive_t

contains

   !> Empties the archive and makes it take values.
   pure subroutine begin_writing(self)
      class(archive_t), intent(inout) :: self
      integer, parameter :: first_size = 4096
      if (allocated(self%bytes)) deallocate (self%bytes)
      if (allocated(self%obstacle)) deallocate (self%obstacle)
      allocate (character(len=first_size) :: self%bytes)
      self%used = 0
      self%writing = .true.
      self%spoiled = .false.
   end subroutine begin_writing

   !> Makes the archive give back what these bytes hold.
   pure subroutine begin_reading(self, bytes)
      class(archive_t), intent(inout) :: self
      !> From `content`.
      character(len=*), intent(in) :: bytes
      if (allocated(self%obstacle)) deallocate (self%obstacle)
      self%bytes = bytes
      self%used = 0
      self%writing = .false.
      self%spoiled = .false.
   end subroutine begin_reading

   !> The bytes written so far.
   pure function content(self) result(bytes)
      class(archive_t), intent(in) :: self
      character(len=:), allocatable :: bytes
      bytes = self%bytes(1:self%used)
   end function content

   !> True where the archive gives values back.
   pure logical function is_reading(self)
      class(archive_t), intent(in) :: self
      is_reading = .not. self%writing
   end function is_reading

   !> Notes that something cannot be archived.
   pure subroutine refuse(self, reason)
      class(archive_t), intent(inout) :: self
      !> One line for a person.
      character(len=*), intent(in) :: reason
      self%obstacle = reason
   end subroutine refuse

   !> Why the archive is not what it should be; empty for a good one.
   pure function problem(self) result(reason)
      class(archive_t), intent(in) :: self
      character(len=:), allocatable :: reason
      reason = ''
      if (self%spoiled) reason = 'it holds something else than this run'
      if (allocated(self%obstacle)) reason = self%obstacle
   end function problem

   subroutine transfer_real(self, value)
      class(archive_t), intent(inout) :: self
      real(wp), intent(inout) :: value
      real(wp) :: values(1)
      values(1) = value
      call self%transfer_reals(values)
      value = values(1)
   end subroutine transfer_real

   subroutine transfer_reals(self, values)
      class(archive_t), intent(inout) :: self
      real(wp), intent(inout) :: values(:)
      character(len=real_bytes*size(values)) :: bytes
      if (self%writing) bytes = transfer(values, bytes)
      call pass(self, A_REAL, bytes)
      if (.not. self%writing .and. .not. self%spoiled) values = transfer(bytes, values)
   end subroutine transfer_reals

   subroutine transfer_matrix(self, values)
      class(archive_t), intent(inout) :: self
      real(wp), intent(inout) :: values(:, :)
      integer :: j
      do j = 1, size(values, 2)
         call self%transfer_reals(values(:, j))
      end do
   end subroutine transfer_matrix

   subroutine transfer_integer(self, value)
      class(archive_t), intent(inout) :: self
      integer, intent(inout) :: value
      character(len=integer_bytes) :: bytes
      bytes = transfer(value, bytes)
      call pass(self, A_INTEGER, bytes)
      value = transfer(bytes, value)
   end subroutine transfer_integer

   subroutine transfer_long(self, value)
      class(archive_t), intent(inout) :: self
      integer(long), intent(inout) :: value
      character(len=size_bytes) :: bytes
      bytes = transfer(value, bytes)
      call pass(self, A_LONG, bytes)
      value = transfer(bytes, value)
   end subroutine transfer_long

   subroutine transfer_logical(self, value)
      class(archive_t), intent(inout) :: self
      logical, intent(inout) :: value
      character(len=1) :: byte
      byte = merge('T', 'F', value)
      call pass(self, A_LOGICAL, byte)
      value = byte == 'T'
   end subroutine transfer_logical

   !> Text of any length: given back in the length that it had.
   subroutine transfer_text(self, value)
      class(archive_t), intent(inout) :: self
      !> Must be allocated where the archive takes it.
      character(len=:), allocatable, intent(inout) :: value
      integer(long) :: length
      if (.not. self%writing) then
         length = next_size(self)
         if (length < 0) then
            self%spoiled = .true.
            return
         end if
         if (allocated(value)) deallocate (value)
         allocate (character(len=length) :: value)
      end if
      call pass(self, A_TEXT, value)
   end subroutine transfer_text

   !> Size of the next value, bytes; -1 where the archive does not hold it.
   pure integer(long) function next_size(self)
      class(archive_t), intent(in) :: self
      integer(long) :: left
      next_size = -1
      left = len(self%bytes) - self%used
      if (left < head_bytes) return
      next_size = transfer(self%bytes(self%used + 2:self%used + head_bytes), next_size)
      if (next_size < 0 .or. next_size > left - head_bytes) next_size = -1
   end function next_size

   !> Takes the bytes of a value, or gives them back; what has failed leaves them as they are.
   subroutine pass(self, kind, bytes)
      class(archive_t), intent(inout) :: self
      character, intent(in) :: kind
      character(len=*), intent(inout) :: bytes
      if (self%writing) then
         call append(self, kind//transfer(len(bytes, long), repeat(' ', size_bytes)))
         call append(self, bytes)
         return
      end if
      if (.not. self%spoiled) self%spoiled = next_size(self) /= len(bytes, long)
      if (.not. self%spoiled) self%spoiled = self%bytes(self%used + 1:self%used + 1) /= kind
      if (self%spoiled) return
      bytes = self%bytes(self%used + head_bytes + 1:self%used + head_bytes + len(bytes))
      self%used = self%used + head_bytes + len(bytes)
   end subroutine pass

   !> Adds bytes; the room for them doubles when it is used up.
   pure subroutine append(self, bytes)
      class(archive_t), intent(inout) :: self
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

end module nutate_archive
