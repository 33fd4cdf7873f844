!> Mean, deviation and range of every field over the members that reached their end, and counts of the others. Members
!> are added in their order, so that the sums do not depend on the threads that ran them.
module nutate_sweep_sums
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_archive, only: archive_t
   use nutate_decimal, only: exact_text
   use nutate_files, only: output_file_t
   use nutate_kinds, only: wp, long
   use nutate_row_layout, only: real_of, row_layout_t
   use nutate_spelling, only: count_text
   use nutate_state, only: add_increment
   use nutate_status, only: status_t
   use nutate_text_file, only: read_text_file
   implicit none
   private

   public :: sweep_sums_t, any_succeeded, most_codes

   !> Upper bound of the status codes; all lie below it.
   integer, parameter :: most_codes = 32

   !> Sums so far. Each field is taken less its first value, so that a small spread keeps its digits.
   type :: sweep_sums_t
      !> Members added, by the code of their status; from 0 on.
      integer(long) :: codes(0:most_codes - 1) = 0
      !> Count, first value, sums of the differences from it and of their squares with the digits that these sums lose,
      !> least and greatest value of each field. Shape (fields).
      integer(long), allocatable :: count(:)
      real(wp), allocatable :: shift(:), sums(:), lost(:), squares(:), lost_squares(:), least(:), greatest(:)
   contains
      !> Sets the sums to zero.
      procedure :: prepare
      !> Adds members in their order.
      procedure :: add
      !> Return mean and standard deviation of a field.
      procedure :: mean
      procedure :: deviation
      !> Writes all as CSV.
      procedure :: write => write_sums
      !> Writes the sums to an archive, or reads them.
      procedure :: transfer => transfer_sums
   end type sweep_sums_t

contains

   !> Sets the sums to zero.
   subroutine prepare(self, layout)
      class(sweep_sums_t), intent(inout) :: self
      type(row_layout_t), intent(in) :: layout
      integer :: n
      n = layout%width()
      allocate (self%count(n), source=0_long)
      allocate (self%shift(n), self%sums(n), self%lost(n), self%squares(n), self%lost_squares(n), self%least(n), &
                self%greatest(n), source=0.0_wp)
   end subroutine prepare

   !> Adds members in their order.
   subroutine add(self, layout, fields)
      class(sweep_sums_t), intent(inout) :: self
      type(row_layout_t), intent(in) :: layout
      !> Shape (fields, members).
      integer(long), intent(in) :: fields(:, :)
      real(wp) :: x
      integer :: i, k
      do k = 1, size(fields, 2)
         i = int(max(0_long, min(fields(2, k), int(most_codes - 1, long))))
         self%codes(i) = self%codes(i) + 1
         if (i /= 0) cycle
         do i = 3, size(fields, 1)
            if (layout%is_whole(i)) then
               x = real(fields(i, k), wp)
            else
               x = real_of(fields(i, k))
            end if
            if (ieee_is_finite(x)) call add_value(self, i, x)
         end do
      end do
   end subroutine add

   subroutine add_value(self, i, x)
      type(sweep_sums_t), intent(inout) :: self
      integer, intent(in) :: i
      real(wp), intent(in) :: x
      real(wp) :: difference
      if (self%count(i) == 0) then
         self%shift(i) = x
         self%least(i) = x
         self%greatest(i) = x
      end if
      self%count(i) = self%count(i) + 1
      difference = x - self%shift(i)
      call add_increment(self%sums(i), self%lost(i), difference)
      call add_increment(self%squares(i), self%lost_squares(i), difference**2)
      self%least(i) = min(self%least(i), x)
      self%greatest(i) = max(self%greatest(i), x)
   end subroutine add_value

   !> Returns the mean of a field that has values.
   pure real(wp) function mean(self, i)
      class(sweep_sums_t), intent(in) :: self
      integer, intent(in) :: i
      mean = self%shift(i) + self%sums(i)/self%count(i)
   end function mean

   !> Returns the standard deviation of a field that has values, with one degree of freedom less; 0 for one value.
   pure real(wp) function deviation(self, i)
      class(sweep_sums_t), intent(in) :: self
      integer, intent(in) :: i
      deviation = 0.0_wp
      if (self%count(i) < 2) return
      deviation = (self%squares(i) - self%sums(i)**2/self%count(i))/(self%count(i) - 1)
      deviation = sqrt(max(deviation, 0.0_wp))
   end function deviation

   !> Writes all as CSV: a line for each field, then one for each status. Errors: `NUTATE_IO`.
   subroutine write_sums(self, layout, name, status)
      class(sweep_sums_t), intent(in) :: self
      type(row_layout_t), intent(in) :: layout
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      type(output_file_t) :: file
      integer :: i
      call file%open(name, status)
      if (status%ok()) call file%put_line('field,members,mean,deviation,least,greatest', status)
      do i = 3, layout%width()
         if (.not. status%ok()) exit
         if (self%count(i) == 0) then
            call file%put_line(trim(layout%names(i))//',0,,,,', status)
         else
            call file%put_line(trim(layout%names(i))//','//count_text(self%count(i))//','// &
                               exact_text(self%mean(i))//','//exact_text(self%deviation(i))//','// &
                               exact_text(self%least(i))//','//exact_text(self%greatest(i)), status)
         end if
      end do
      do i = 0, most_codes - 1
         if (.not. status%ok()) exit
         if (self%codes(i) == 0) cycle
         call file%put_line('status_'//count_text(i)//','//count_text(self%codes(i))//',,,,', status)
      end do
      call file%close(status)
   end subroutine write_sums

   !> Returns true if, by a file of sums, members reached their end.
   logical function any_succeeded(name)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: text, problem
      call read_text_file(name, text, problem)
      any_succeeded = index(text, new_line('a')//'status_0,') > 0
   end function any_succeeded

   !> Writes the sums to an archive, or reads them.
   subroutine transfer_sums(self, archive)
      class(sweep_sums_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      integer :: i
      do i = 0, most_codes - 1
         call archive%transfer(self%codes(i))
      end do
      do i = 1, size(self%count)
         call archive%transfer(self%count(i))
      end do
      call archive%transfer(self%shift)
      call archive%transfer(self%sums)
      call archive%transfer(self%lost)
      call archive%transfer(self%squares)
      call archive%transfer(self%lost_squares)
      call archive%transfer(self%least)
      call archive%transfer(self%greatest)
   end subroutine transfer_sums

end module nutate_sweep_sums
