!> Messages of the program: pages of labelled lines, one-line errors, exit codes.
module nutate_console
   use nutate_decimal, only: rounded_text
   use nutate_files, only: write_text, STANDARD_ERROR, STANDARD_OUTPUT
   use nutate_kinds, only: wp, long, pi
   use nutate_printable, only: printable_path
   use nutate_spelling, only: count_text
   use nutate_status, only: status_t
   use nutate_table, only: table_t
   implicit none
   private

   public :: page_t, report_file, say_error, show_page, count_text, rate_text, vector_text, plural, EXIT_SUCCESS, &
             EXIT_INPUT, EXIT_RUN, EXIT_OUTPUT, EXIT_SIGNAL

   !> Exit codes: success; error in the command line or the scene; run that failed half-way; output that cannot be
   !> written.
   integer, parameter :: EXIT_SUCCESS = 0, EXIT_INPUT = 2, EXIT_RUN = 3, EXIT_OUTPUT = 4
   !> Exit code after a stop by a signal, before the number of the signal is added.
   integer, parameter :: EXIT_SIGNAL = 128
   !> Least width of the column of labels.
   integer, parameter :: label_width = 18

   !> Text put together line by line, then shown at once.
   type :: page_t
      type(table_t), private :: lines
      logical, private :: has_items = .false.
   contains
      !> Adds a line.
      procedure :: line
      !> Adds a line with a label at its left; all labels of a page have one width.
      procedure :: item
   end type page_t

contains

   !> Adds a line.
   subroutine line(self, text)
      class(page_t), intent(inout) :: self
      !> Line; may contain line feeds.
      character(len=*), intent(in) :: text
      call self%lines%add_line(text)
   end subroutine line

   !> Adds a line with a label at its left; all labels of a page have one width.
   subroutine item(self, label, text)
      class(page_t), intent(inout) :: self
      !> Label and text; a blank label continues the line above.
      character(len=*), intent(in) :: label, text
      if (.not. self%has_items) then
         self%lines%indent = 2
         call self%lines%add_column(least=label_width)
         call self%lines%add_column()
         self%has_items = .true.
      end if
      call self%lines%add_row()
      call self%lines%put(label)
      call self%lines%put(text)
   end subroutine item

   !> Shows a page. A page that cannot be written is an error on standard output; on standard error, the failure is
   !> ignored.
   subroutine show_page(page, descriptor, exit_code)
      type(page_t), intent(in) :: page
      !> Descriptor: `STANDARD_OUTPUT` or `STANDARD_ERROR`.
      integer, intent(in) :: descriptor
      integer, intent(out) :: exit_code
      type(status_t) :: status
      exit_code = EXIT_SUCCESS
      call write_text(descriptor, page%lines%text()//new_line('a'), status)
      if (status%ok() .or. descriptor /= STANDARD_OUTPUT) return
      call say_error('nutate: cannot write to standard output: '//trim(status%message), exit_code, EXIT_OUTPUT)
   end subroutine show_page

   !> Writes one line to standard error, and sets the exit code if there is one.
   subroutine say_error(text, exit_code, new_code)
      character(len=*), intent(in) :: text
      !> Exit code, and its new value; both are present, or none.
      integer, intent(inout), optional :: exit_code
      integer, intent(in), optional :: new_code
      type(status_t) :: status
      call write_text(STANDARD_ERROR, text//new_line('a'), status)
      if (present(exit_code)) exit_code = new_code
   end subroutine say_error

   !> Reports a file that could not be written, if it could not.
   subroutine report_file(name, status, exit_code)
      character(len=*), intent(in) :: name
      type(status_t), intent(in) :: status
      integer, intent(inout) :: exit_code
      if (.not. status%ok()) call say_error( &
         'nutate: cannot write '//printable_path(name)//': '//trim(status%message), exit_code, EXIT_OUTPUT)
   end subroutine report_file

   !> Returns a count with its noun: `1 row`, `2 rows`.
   pure function plural(n, noun) result(text)
      integer(long), intent(in) :: n
      character(len=*), intent(in) :: noun
      character(len=:), allocatable :: text
      text = count_text(n)//' '//noun
      if (n /= 1) text = text//'s'
   end function plural

   !> Returns a rate in both units: `2 rad/s (19.0986 rpm)`.
   pure function rate_text(rate) result(text)
      !> Rate, rad/s.
      real(wp), intent(in) :: rate
      character(len=:), allocatable :: text
      text = rounded_text(rate)//' rad/s'
      if (rate < huge(rate)/10) text = text//' ('//rounded_text(rate*30/pi)//' rpm)'
   end function rate_text

   !> Returns numbers rounded for people, comma separated.
   pure function vector_text(values, digits) result(text)
      real(wp), intent(in) :: values(:)
      !> Significant digits; default 6.
      integer, intent(in), optional :: digits
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, size(values)
         if (i > 1) text = text//', '
         text = text//rounded_text(values(i), digits)
      end do
   end function vector_text

end module nutate_console
