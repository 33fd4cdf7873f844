!> Archives of numbers: values in an array of reals that a program keeps, as FORTRAN 77 does. The array holds plain
!> numbers and no addresses, so a copy of it is as good as the original. Integers beyond 2**53 would lose digits; counts
!> of steps do not come that far.
module nutate_number_archive
   use nutate_archive, only: archive_t
   use nutate_kinds, only: wp, long
   implicit none
   private

   public :: number_archive_t

   !> Values as numbers in an array of the caller, or only counted.
   type, extends(archive_t) :: number_archive_t
      private
      !> Array of the caller; not associated if values are only counted.
      real(wp), pointer, contiguous :: numbers(:) => null()
      !> Numbers in use, or already read.
      integer :: used = 0
   contains
      !> Makes the archive count the numbers that it would store.
      procedure :: begin_counting
      !> Makes the archive fill an array.
      procedure :: begin_writing
      !> Makes the archive return the values of an array.
      procedure :: begin_reading
      !> Returns the number of values transferred so far.
      procedure :: count => count_numbers
      procedure :: transfer_reals
      procedure :: transfer_integer
      procedure :: transfer_long
      procedure :: transfer_logical
      procedure :: transfer_text
   end type number_archive_t

contains

   !> Makes the archive count the numbers that it would store.
   subroutine begin_counting(self)
      class(number_archive_t), intent(inout) :: self
      self%numbers => null()
      self%used = 0
      call self%set_direction(reading=.false.)
   end subroutine begin_counting

   !> Makes the archive fill an array from its first number on.
   subroutine begin_writing(self, numbers)
      class(number_archive_t), intent(inout) :: self
      !> Array at least as long as `count` returned; must stay while the archive is in use.
      real(wp), intent(in), target, contiguous :: numbers(:)
      self%numbers => numbers
      self%used = 0
      call self%set_direction(reading=.false.)
   end subroutine begin_writing

   !> Makes the archive return the values of an array.
   subroutine begin_reading(self, numbers)
      class(number_archive_t), intent(inout) :: self
      !> Array filled by an archive; must stay while the archive is in use.
      real(wp), intent(in), target, contiguous :: numbers(:)
      self%numbers => numbers
      self%used = 0
      call self%set_direction(reading=.true.)
   end subroutine begin_reading

   !> Returns the number of values transferred so far.
   pure integer function count_numbers(self) result(n)
      class(number_archive_t), intent(in) :: self
      n = self%used
   end function count_numbers

   !> Writes or reads reals; an array that is too short leaves the values unchanged.
   subroutine transfer_reals(self, values)
      class(number_archive_t), intent(inout) :: self
      real(wp), intent(inout) :: values(:)
      integer :: i, first
      first = self%used
      self%used = self%used + size(values)
      if (.not. associated(self%numbers)) return
      if (self%used > size(self%numbers)) then
         call self%spoil()
      else if (self%is_reading()) then
         do i = 1, size(values)
            values(i) = self%numbers(first + i)
         end do
      else
         do i = 1, size(values)
            self%numbers(first + i) = values(i)
         end do
      end if
   end subroutine transfer_reals

   subroutine transfer_integer(self, value)
      class(number_archive_t), intent(inout) :: self
      integer, intent(inout) :: value
      real(wp) :: number(1)
      number(1) = real(value, wp)
      call self%transfer_reals(number)
      value = nint(number(1))
   end subroutine transfer_integer

   subroutine transfer_long(self, value)
      class(number_archive_t), intent(inout) :: self
      integer(long), intent(inout) :: value
      real(wp) :: number(1)
      number(1) = real(value, wp)
      call self%transfer_reals(number)
      value = nint(number(1), long)
   end subroutine transfer_long

   subroutine transfer_logical(self, value)
      class(number_archive_t), intent(inout) :: self
      logical, intent(inout) :: value
      real(wp) :: number(1)
      number(1) = merge(1.0_wp, 0.0_wp, value)
      call self%transfer_reals(number)
      value = number(1) > 0.5_wp
   end subroutine transfer_logical

   !> Rejects text, which cannot be stored as a number.
   subroutine transfer_text(self, value)
      class(number_archive_t), intent(inout) :: self
      character(len=:), allocatable, intent(inout) :: value
      call self%refuse('a text cannot be kept as a number')
   end subroutine transfer_text

end module nutate_number_archive
