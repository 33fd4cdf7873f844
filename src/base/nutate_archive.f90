!> Archives: values that one procedure writes, and that the same procedure reads again.
!>
!> Every type that must survive an interruption has one procedure, `transfer`, that passes its values to an archive. An
!> archive in writing mode stores each value; one in reading mode replaces it by the stored value. So both always agree,
!> and an archive that only counts tells how much room the values need.
module nutate_archive
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: archive_t

   !> Checkpoint data: values in the order in which they are transferred, as bytes (`nutate_byte_archive`) or as numbers
   !> in an array of a program (`nutate_number_archive`). One `transfer` procedure of a type both writes and reads.
   type, abstract :: archive_t
      !> Values are read, not written.
      logical, private :: reading = .false.
      !> The data do not hold the values that were read.
      logical, private :: spoiled = .false.
      !> Reason why a value cannot be stored; not allocated if it can.
      character(len=:), allocatable, private :: obstacle
   contains
      !> Restarts at the first value, for writing or for reading.
      procedure, non_overridable :: set_direction
      !> Returns true if values are read.
      procedure, non_overridable :: is_reading
      !> Marks the data as impossible to store, with a reason.
      procedure, non_overridable :: refuse
      !> Marks the data as not matching what is read.
      procedure, non_overridable :: spoil
      !> Returns why the data cannot be used; empty if they can.
      procedure, non_overridable :: problem
      !> Returns true if all values so far matched.
      procedure, non_overridable :: is_whole
      !> Writes or reads a value: scalars; arrays of reals, whose shape is the same on both sides; allocatable text.
      generic :: transfer => transfer_real, transfer_reals, transfer_matrix, transfer_integer, transfer_long, &
         transfer_logical, transfer_text
      !> Transfers a name and checks it when reading.
      procedure, non_overridable :: expect
      procedure, private, non_overridable :: transfer_real
      procedure, private, non_overridable :: transfer_matrix
      procedure(pass_reals), deferred :: transfer_reals
      procedure(pass_integer), deferred :: transfer_integer
      procedure(pass_long), deferred :: transfer_long
      procedure(pass_logical), deferred :: transfer_logical
      procedure(pass_text), deferred :: transfer_text
   end type archive_t

   abstract interface
      !> Writes or reads reals.
      subroutine pass_reals(self, values)
         import :: archive_t, wp
         class(archive_t), intent(inout) :: self
         !> Shape (any), the same on both sides.
         real(wp), intent(inout) :: values(:)
      end subroutine pass_reals

      !> Writes or reads an integer.
      subroutine pass_integer(self, value)
         import :: archive_t
         class(archive_t), intent(inout) :: self
         integer, intent(inout) :: value
      end subroutine pass_integer

      !> Writes or reads a 64-bit integer.
      subroutine pass_long(self, value)
         import :: archive_t, long
         class(archive_t), intent(inout) :: self
         integer(long), intent(inout) :: value
      end subroutine pass_long

      !> Writes or reads a logical.
      subroutine pass_logical(self, value)
         import :: archive_t
         class(archive_t), intent(inout) :: self
         logical, intent(inout) :: value
      end subroutine pass_logical

      !> Writes or reads text of any length; reading restores its length.
      subroutine pass_text(self, value)
         import :: archive_t
         class(archive_t), intent(inout) :: self
         !> Must be allocated for writing.
         character(len=:), allocatable, intent(inout) :: value
      end subroutine pass_text
   end interface

contains

   !> Restarts at the first value, for writing or for reading.
   pure subroutine set_direction(self, reading)
      class(archive_t), intent(inout) :: self
      logical, intent(in) :: reading
      if (allocated(self%obstacle)) deallocate (self%obstacle)
      self%reading = reading
      self%spoiled = .false.
   end subroutine set_direction

   !> Returns true if values are read.
   pure logical function is_reading(self)
      class(archive_t), intent(in) :: self
      is_reading = self%reading
   end function is_reading

   !> Marks the data as impossible to store, with a reason; the first reason stays.
   pure subroutine refuse(self, reason)
      class(archive_t), intent(inout) :: self
      !> One line for the user.
      character(len=*), intent(in) :: reason
      self%obstacle = reason
   end subroutine refuse

   !> Marks the data as not matching what is read.
   pure subroutine spoil(self)
      class(archive_t), intent(inout) :: self
      self%spoiled = .true.
   end subroutine spoil

   !> Returns true if all values so far matched.
   pure logical function is_whole(self)
      class(archive_t), intent(in) :: self
      is_whole = .not. self%spoiled
   end function is_whole

   !> Returns why the data cannot be used; empty if they can.
   pure function problem(self) result(reason)
      class(archive_t), intent(in) :: self
      character(len=:), allocatable :: reason
      reason = ''
      if (self%spoiled) reason = 'it belongs to another run'
      if (allocated(self%obstacle)) reason = self%obstacle
   end function problem

   !> Transfers a name; when reading, marks the data as not matching if it is another one.
   subroutine expect(self, name)
      class(archive_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: found
      found = name
      call self%transfer_text(found)
      if (self%spoiled) return
      if (found /= name) call self%spoil()
   end subroutine expect

   subroutine transfer_real(self, value)
      class(archive_t), intent(inout) :: self
      real(wp), intent(inout) :: value
      real(wp) :: values(1)
      values(1) = value
      call self%transfer_reals(values)
      value = values(1)
   end subroutine transfer_real

   subroutine transfer_matrix(self, values)
      class(archive_t), intent(inout) :: self
      real(wp), intent(inout) :: values(:, :)
      integer :: j
      do j = 1, size(values, 2)
         call self%transfer_reals(values(:, j))
      end do
   end subroutine transfer_matrix

end module nutate_archive
