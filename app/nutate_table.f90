!> Tables for people. Each column is as wide as its content; its numbers share one notation and are aligned at the
!> decimal point.
module nutate_table
   use nutate_decimal, only: rounded_text
   use nutate_kinds, only: wp
   implicit none
   private

   public :: table_t, number_text

   !> A column whose numbers all have sizes from the first to below the second is written without exponents.
   real(wp), parameter :: plain_sizes(2) = [1e-3_wp, 1e6_wp]
   !> Blanks between columns.
   character(len=*), parameter :: gap = '  '

   type :: cell_t
      !> Text before the number, or alone.
      character(len=:), allocatable :: text
      logical :: has_number = .false.
      real(wp) :: number = 0.0_wp
   end type cell_t

   type :: row_t
      !> A line without columns; not allocated for a row of cells.
      character(len=:), allocatable :: line
      type(cell_t), allocatable :: cells(:)
   end type row_t

   type :: table_column_t
      !> First and second line of the head.
      type(cell_t) :: head(2)
      !> Significant digits of numbers; 0 for a column of text, which begins at the left.
      integer :: digits = 0
      !> Least width of the column.
      integer :: least = 0
      !> Digits before the exponents; 0 if there are no exponents.
      integer :: mantissa = 0
      !> Characters of the widest cell before the decimal point, and from it on; `after` holds all characters of text.
      integer :: before = 0, after = 0
   end type table_column_t

   type :: table_t
      private
      type(table_column_t), allocatable :: columns(:)
      type(row_t), allocatable :: rows(:)
      !> Rows in use; cells in use in the last row.
      integer :: n_rows = 0, n_cells = 0
      !> Blanks before the first column.
      integer, public :: indent = 0
   contains
      !> Adds a column at the right.
      procedure :: add_column
      !> Adds a line without columns.
      procedure :: add_line
      !> Begins a row of empty cells.
      procedure :: add_row
      !> Fills the next cell of the row.
      generic :: put => put_text, put_number
      procedure, private :: put_text, put_number
      !> Returns the table as lines.
      procedure :: text => text_of
   end type table_t

contains

   !> Adds a column at the right. Columns come before rows.
   subroutine add_column(self, head, unit, digits, least)
      class(table_t), intent(inout) :: self
      !> Head of the column, and the line below.
      character(len=*), intent(in), optional :: head, unit
      !> Significant digits of the numbers; absent for a column of text.
      integer, intent(in), optional :: digits
      !> Least width of the column.
      integer, intent(in), optional :: least
      type(table_column_t) :: column
      type(table_column_t), allocatable :: more(:)
      integer :: n
      n = 0
      if (allocated(self%columns)) n = size(self%columns)
      allocate (more(n + 1))
      if (n > 0) more(:n) = self%columns
      column%head(1)%text = ''
      column%head(2)%text = ''
      if (present(head)) column%head(1)%text = head
      if (present(unit)) column%head(2)%text = unit
      if (present(digits)) column%digits = digits
      if (present(least)) column%least = least
      more(n + 1) = column
      call move_alloc(more, self%columns)
   end subroutine add_column

   !> Adds a line without columns.
   subroutine add_line(self, text)
      class(table_t), intent(inout) :: self
      !> Line; may contain line feeds.
      character(len=*), intent(in) :: text
      call lengthen(self)
      self%rows(self%n_rows)%line = text
   end subroutine add_line

   !> Begins a row of empty cells.
   subroutine add_row(self)
      class(table_t), intent(inout) :: self
      integer :: i
      call lengthen(self)
      associate (row => self%rows(self%n_rows))
         allocate (row%cells(size(self%columns)))
         do i = 1, size(row%cells)
            row%cells(i)%text = ''
         end do
      end associate
      self%n_cells = 0
   end subroutine add_row

   !> Makes room for one more row.
   subroutine lengthen(self)
      class(table_t), intent(inout) :: self
      type(row_t), allocatable :: more(:)
      if (.not. allocated(self%rows)) allocate (self%rows(16))
      if (self%n_rows == size(self%rows)) then
         allocate (more(2*self%n_rows))
         more(:self%n_rows) = self%rows
         call move_alloc(more, self%rows)
      end if
      self%n_rows = self%n_rows + 1
   end subroutine lengthen

   !> Fills the next cell of the row with a string.
   subroutine put_text(self, text)
      class(table_t), intent(inout) :: self
      character(len=*), intent(in) :: text
      self%n_cells = self%n_cells + 1
      self%rows(self%n_rows)%cells(self%n_cells)%text = trim(text)
   end subroutine put_text

   !> Fills the next cell of the row with a number, rounded to the digits of its column.
   subroutine put_number(self, number, before)
      class(table_t), intent(inout) :: self
      real(wp), intent(in) :: number
      !> Text before the number, such as `<`.
      character(len=*), intent(in), optional :: before
      call self%put_text('')
      associate (cell => self%rows(self%n_rows)%cells(self%n_cells))
         if (present(before)) cell%text = before
         cell%has_number = .true.
         cell%number = number
      end associate
   end subroutine put_number

   !> Returns the table as lines, the last one without a line feed.
   function text_of(self) result(text)
      class(table_t), intent(in) :: self
      character(len=:), allocatable :: text
      type(table_column_t), allocatable :: columns(:)
      integer :: i, k, used
      text = ''
      allocate (columns(0))
      if (allocated(self%columns)) columns = self%columns
      do k = 1, size(columns)
         call measure(columns(k), k, self%rows(:self%n_rows))
      end do
      do i = 1, 2
         if (has_head(columns, i)) text = text//head_line(columns, i, self%indent)//new_line('a')
      end do
      used = len(text)
      do i = 1, self%n_rows
         if (allocated(self%rows(i)%line)) then
            call extend(text, used, self%rows(i)%line//new_line('a'))
         else
            call extend(text, used, row_line(columns, self%rows(i)%cells, self%indent)//new_line('a'))
         end if
      end do
      text = text(:used - 1)
   end function text_of

   !> Appends a line to a buffer, which doubles when it is full.
   pure subroutine extend(buffer, used, line)
      character(len=:), allocatable, intent(inout) :: buffer
      !> Number of characters in use.
      integer, intent(inout) :: used
      character(len=*), intent(in) :: line
      if (used + len(line) > len(buffer)) buffer = buffer//repeat(' ', used + len(line))
      buffer(used + 1:used + len(line)) = line
      used = used + len(line)
   end subroutine extend

   !> Finds the notation and the width of a column.
   subroutine measure(column, k, rows)
      type(table_column_t), intent(inout) :: column
      !> Position of the column.
      integer, intent(in) :: k
      type(row_t), intent(in) :: rows(:)
      character(len=:), allocatable :: text
      integer :: i
      column%mantissa = 0
      do i = 1, size(rows)
         if (allocated(rows(i)%cells)) then
            if (needs_exponent(rows(i)%cells(k))) column%mantissa = 1
         end if
      end do
      if (column%mantissa > 0) then
         do i = 1, size(rows)
            if (allocated(rows(i)%cells)) &
               column%mantissa = max(column%mantissa, mantissa_of(rows(i)%cells(k), column%digits))
         end do
      end if
      do i = 1, size(rows)
         if (.not. allocated(rows(i)%cells)) cycle
         text = cell_text(column, rows(i)%cells(k))
         column%before = max(column%before, length(text(:point_of(column, text))))
         column%after = max(column%after, length(text) - length(text(:point_of(column, text))))
      end do
      do i = 1, 2
         column%before = max(column%before, length(column%head(i)%text) - column%after, column%least - column%after)
      end do
   end subroutine measure

   !> Returns a number outside of tables: with an exponent if it would be too long, or too small to be read, without.
   pure function number_text(number, digits) result(text)
      real(wp), intent(in) :: number
      !> Significant digits.
      integer, intent(in) :: digits
      character(len=:), allocatable :: text
      type(table_column_t) :: column
      type(cell_t) :: cell
      cell = cell_t('', .true., number)
      column%digits = digits
      if (needs_exponent(cell)) column%mantissa = mantissa_of(cell, digits)
      text = cell_text(column, cell)
   end function number_text

   !> Returns true for a number that would be too long, or too small to be read, without an exponent.
   pure logical function needs_exponent(cell)
      type(cell_t), intent(in) :: cell
      needs_exponent = .false.
      if (.not. cell%has_number .or. .not. abs(cell%number) > 0.0_wp) return
      needs_exponent = abs(cell%number) < plain_sizes(1) .or. abs(cell%number) >= plain_sizes(2)
   end function needs_exponent

   !> Returns the digits that a number needs before its exponent, at most those of its column.
   pure integer function mantissa_of(cell, digits) result(needed)
      type(cell_t), intent(in) :: cell
      integer, intent(in) :: digits
      character(len=:), allocatable :: text
      needed = 1
      if (.not. takes_exponent(cell)) return
      text = scientific(cell%number, digits)
      text = text(verify(text, '-'):scan(text, 'E') - 1)
      needed = max(verify(text, '0', back=.true.) - index(text(1:min(2, len(text))), '.')/2, 1)
   end function mantissa_of

   !> Returns true for a number that can have an exponent: finite and not zero.
   pure logical function takes_exponent(cell)
      type(cell_t), intent(in) :: cell
      takes_exponent = .false.
      if (cell%has_number) takes_exponent = abs(cell%number) > 0.0_wp .and. abs(cell%number) <= huge(1.0_wp)
   end function takes_exponent

   !> Returns a number in the notation `2.4E-5`.
   pure function scientific(number, digits) result(text)
      !> Number, finite and not zero.
      real(wp), intent(in) :: number
      !> Digits before the exponent, 1 to 17.
      integer, intent(in) :: digits
      character(len=:), allocatable :: text
      character(len=24) :: line
      character(len=12) :: form
      integer :: power, mark
      write (form, '("(es24.",i0,"e3)")') digits - 1
      write (line, form) number
      line = adjustl(line)
      mark = index(line, 'E')
      read (line(mark + 1:), '(i4)') power
      write (form, '(sp,i0)') power
      text = line(:mark - 1)
      if (digits == 1) text = text(:len(text) - 1)
      text = text//'E'//trim(form)
   end function scientific

   !> Returns the content of a cell as a string.
   pure function cell_text(column, cell) result(text)
      !> Column with known notation.
      type(table_column_t), intent(in) :: column
      type(cell_t), intent(in) :: cell
      character(len=:), allocatable :: text
      text = cell%text
      if (.not. cell%has_number) return
      if (column%mantissa > 0 .and. takes_exponent(cell)) then
         text = text//scientific(cell%number, column%mantissa)
      else
         text = text//rounded_text(cell%number, column%digits)
      end if
   end function cell_text

   !> Returns the number of characters of a cell before its decimal point; 0 in a column of text.
   pure integer function point_of(column, text)
      type(table_column_t), intent(in) :: column
      character(len=*), intent(in) :: text
      point_of = 0
      if (column%digits > 0) point_of = scan(text//'.', '.E') - 1
   end function point_of

   !> Returns the number of characters of a string: its bytes without the continuation bytes of UTF-8.
   pure integer function length(text)
      character(len=*), intent(in) :: text
      integer :: i
      length = count([(iand(iachar(text(i:i)), 192) /= 128, i=1, len(text))])
   end function length

   !> Returns true if a line of the head is not empty.
   pure logical function has_head(columns, i)
      type(table_column_t), intent(in) :: columns(:)
      !> Line of the head, 1 or 2.
      integer, intent(in) :: i
      integer :: k
      has_head = any([(columns(k)%head(i)%text /= '', k=1, size(columns))])
   end function has_head

   !> Returns a line of the head, aligned with the right end of numbers and the left end of text.
   pure function head_line(columns, i, indent) result(line)
      !> Columns, measured.
      type(table_column_t), intent(in) :: columns(:)
      !> Line of the head, 1 or 2; blanks before the first column.
      integer, intent(in) :: i, indent
      character(len=:), allocatable :: line
      integer :: k, left
      line = repeat(' ', indent)
      do k = 1, size(columns)
         associate (column => columns(k), text => columns(k)%head(i)%text)
            left = 0
            if (column%digits > 0) left = column%before + column%after - length(text)
            call append(line, column, text, left, indent)
         end associate
      end do
      line = trim(line)
   end function head_line

   !> Returns a row of cells as a line.
   pure function row_line(columns, cells, indent) result(line)
      !> Columns, measured.
      type(table_column_t), intent(in) :: columns(:)
      type(cell_t), intent(in) :: cells(:)
      integer, intent(in) :: indent
      character(len=:), allocatable :: line, text
      integer :: k, left
      line = repeat(' ', indent)
      do k = 1, size(columns)
         text = cell_text(columns(k), cells(k))
         left = 0
         if (columns(k)%digits > 0) left = columns(k)%before - length(text(:point_of(columns(k), text)))
         call append(line, columns(k), text, left, indent)
      end do
      line = trim(line)
   end function row_line

   !> Appends a cell to a line.
   pure subroutine append(line, column, text, left, indent)
      character(len=:), allocatable, intent(inout) :: line
      !> Column, measured, not narrower than text and blanks.
      type(table_column_t), intent(in) :: column
      character(len=*), intent(in) :: text
      !> Blanks before the text.
      integer, intent(in) :: left
      integer, intent(in) :: indent
      if (len(line) > indent) line = line//gap
      line = line//repeat(' ', left)//text//repeat(' ', column%before + column%after - left - length(text))
   end subroutine append

end module nutate_table
