!> Writes the rows of a finished sweep as CSV, and adds them up.
module nutate_sweep_csv
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_decimal, only: decimal_length, decimal_t
   use nutate_files, only: output_file_t
   use nutate_kinds, only: wp, long
   use nutate_npy, only: npy_header
   use nutate_row_layout, only: real_of, row_layout_t
   use nutate_spelling, only: joined
   use nutate_status, only: status_t, fail, NUTATE_IO
   use nutate_sweep_file, only: read_bytes
   use nutate_sweep_sums, only: sweep_sums_t
   implicit none
   private

   public :: npy_rows_t, write_csv, add_up, csv_line, header_line

   !> Bytes of a field; rows read at a time.
   integer, parameter :: word = 8
   integer(long), parameter :: portion = 1024

   !> A finished file, read from its first row to its last.
   type :: npy_rows_t
      type(row_layout_t) :: layout
      integer(long) :: rows = 0
      integer(long), private :: offset = 0, at = 0
      integer, private :: unit = -1
   contains
      !> Opens a file.
      procedure :: open => open_rows
      !> Returns the next rows.
      procedure :: next
      procedure :: close => close_rows
   end type npy_rows_t

contains

   !> Opens a file. Errors: `NUTATE_IO` if it cannot be read, or does not have this number of rows of this layout.
   subroutine open_rows(self, name, layout, rows, status)
      class(npy_rows_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: rows
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: header, found
      integer(long) :: bytes
      integer :: iostat
      self%layout = layout
      self%rows = rows
      self%at = 0
      header = npy_header(layout, rows)
      self%offset = len(header)
      call read_bytes(name, 0_long, len(header), found)
      if (found /= header .or. len(found) /= len(header)) then
         status = fail(NUTATE_IO, 'it does not hold the rows of this scene')
         return
      end if
      open (newunit=self%unit, file=name, access='stream', form='unformatted', status='old', action='read', &
            iostat=iostat)
      if (iostat /= 0) then
         status = fail(NUTATE_IO, 'it cannot be read')
         return
      end if
      inquire (unit=self%unit, size=bytes)
      if (bytes == self%offset + rows*layout%width()*word) return
      status = fail(NUTATE_IO, 'it has been cut short')
      call self%close()
   end subroutine open_rows

   !> Returns the next rows; none at the end. Errors: `NUTATE_IO`.
   subroutine next(self, fields, status)
      class(npy_rows_t), intent(inout) :: self
      !> Shape (fields, rows).
      integer(long), allocatable, intent(out) :: fields(:, :)
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: bytes
      integer :: iostat
      allocate (fields(self%layout%width(), min(portion, self%rows - self%at)))
      if (size(fields) == 0) return
      ! Characters keep their order; numbers would be converted by GFORTRAN_CONVERT_UNIT=big_endian.
      allocate (character(len=word*size(fields)) :: bytes)
      read (self%unit, pos=self%offset + self%at*self%layout%width()*word + 1, iostat=iostat) bytes
      if (iostat /= 0) status = fail(NUTATE_IO, 'it cannot be read to its end')
      if (iostat == 0) fields = reshape(transfer(bytes, fields), shape(fields))
      self%at = self%at + size(fields, 2)
   end subroutine next

   subroutine close_rows(self)
      class(npy_rows_t), intent(inout) :: self
      if (self%unit /= -1) close (self%unit)
      self%unit = -1
   end subroutine close_rows

   !> Writes the rows of a finished file as CSV; a number that is not finite is an empty field. Errors: `NUTATE_IO`.
   subroutine write_csv(npy, layout, rows, name, status)
      !> Path of the finished file.
      character(len=*), intent(in) :: npy
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: rows
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      type(npy_rows_t) :: reader
      type(output_file_t) :: file
      type(decimal_t) :: decimal
      integer(long), allocatable :: fields(:, :)
      integer :: i
      call reader%open(npy, layout, rows, status)
      if (status%ok()) call file%open(name, status)
      if (status%ok()) call file%put_line(header_line(layout), status)
      call decimal%prepare()
      do while (status%ok())
         call reader%next(fields, status)
         if (.not. status%ok() .or. size(fields) == 0) exit
         do i = 1, size(fields, 2)
            if (status%ok()) call file%put_line(csv_line(layout, decimal, fields(:, i)), status)
         end do
      end do
      call reader%close()
      call file%close(status)
   end subroutine write_csv

   !> Returns the names of the fields, separated by commas.
   pure function header_line(layout) result(line)
      type(row_layout_t), intent(in) :: layout
      character(len=:), allocatable :: line
      line = joined(layout%names)
   end function header_line

   !> Returns one row as CSV.
   pure function csv_line(layout, decimal, fields) result(text)
      type(row_layout_t), intent(in) :: layout
      !> Prepared converter.
      type(decimal_t), intent(in) :: decimal
      integer(long), intent(in) :: fields(:)
      character(len=:), allocatable :: text
      character(len=(decimal_length + 1)*size(fields)) :: line
      character(len=20) :: digits
      real(wp) :: x
      integer :: i, used
      used = 0
      do i = 1, size(fields)
         if (i > 1) then
            used = used + 1
            line(used:used) = ','
         end if
         if (layout%is_whole(i)) then
            write (digits, '(i0)') fields(i)
            line(used + 1:used + len_trim(digits)) = digits
            used = used + len_trim(digits)
         else
            x = real_of(fields(i))
            if (ieee_is_finite(x)) call decimal%append(line, used, x)
         end if
      end do
      text = line(1:used)
   end function csv_line

   !> Adds up the rows of a finished file. Errors: `NUTATE_IO`.
   subroutine add_up(npy, layout, rows, sums, first_failed, status)
      character(len=*), intent(in) :: npy
      type(row_layout_t), intent(in) :: layout
      integer(long), intent(in) :: rows
      !> Sums, not yet prepared.
      type(sweep_sums_t), intent(inout) :: sums
      !> First member that did not reach its end; 0 if all did.
      integer(long), intent(out) :: first_failed
      type(status_t), intent(out) :: status
      type(npy_rows_t) :: reader
      integer(long), allocatable :: fields(:, :)
      integer :: at
      first_failed = 0
      call sums%prepare(layout)
      call reader%open(npy, layout, rows, status)
      do while (status%ok())
         call reader%next(fields, status)
         if (size(fields) == 0 .or. .not. status%ok()) exit
         call sums%add(layout, fields)
         at = findloc(fields(2, :) /= 0, .true., dim=1)
         if (at > 0 .and. first_failed == 0) first_failed = fields(1, at)
      end do
      call reader%close()
   end subroutine add_up

end module nutate_sweep_csv
