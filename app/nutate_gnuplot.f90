!> Pictures drawn by gnuplot: the file, the script that draws it, and quoted strings.
module nutate_gnuplot
   use nutate_console, only: count_text
   use nutate_outputs, only: close_file, discard_file
   use nutate_files, only: output_file_t
   use nutate_spelling, only: escaped
   use nutate_status, only: status_t, fail, NUTATE_IO
   implicit none
   private

   public :: picture_t, gnuplot_is_here, is_picture, gnuplot_quoted, shell_quoted, colours

   !> Colours that differ for every kind of colour vision.
   character(len=7), parameter :: colours(12) = ['#d55e00', '#e69f00', '#009e73', '#0b3c5d', '#56b4e9', '#cc79a7', &
                                                '#666666', '#000000', '#8c510a', '#66a61e', '#7b3294', '#bdb76b']
   !> Lines that every script begins with.
   character(len=*), parameter :: head(*) = [character(len=96) :: &
      'set encoding utf8', &
      'set output ARG1', &
      'set border 3 linecolor rgb ''#444444''', &
      'set tics nomirror out scale 0.6', &
      'set grid linecolor rgb ''#dddddd'' linewidth 1 linetype 1']

   !> Picture that is being drawn: its file and the script that draws it, both under partial names.
   type :: picture_t
      type(output_file_t), private :: picture, script
      !> Ending of the name: svg, png or pdf.
      character(len=3), private :: format = 'svg'
      !> Status of the first line that could not be written.
      type(status_t), private :: status
   contains
      !> Claims the files.
      procedure :: open
      !> Begins the script with the size of the picture.
      procedure :: begin
      !> Adds a line to the script.
      procedure :: put
      !> Draws the picture.
      procedure :: draw
      !> Discards the files.
      procedure :: discard
   end type picture_t

contains

   !> Returns true if gnuplot can be started.
   logical function gnuplot_is_here()
      integer :: exit_status, command_status
      call execute_command_line('command -v gnuplot >/dev/null 2>&1', exitstat=exit_status, cmdstat=command_status)
      gnuplot_is_here = exit_status == 0 .and. command_status == 0
   end function gnuplot_is_here

   !> Returns true for the name of a file that gnuplot is to draw.
   pure logical function is_picture(name)
      character(len=*), intent(in) :: name
      is_picture = .false.
      if (len(name) > 4) is_picture = any(name(len(name) - 3:) == ['.svg', '.png', '.pdf'])
   end function is_picture

   !> Claims the files. Errors: `NUTATE_IO`.
   subroutine open(self, name, status)
      class(picture_t), intent(inout) :: self
      !> Name of a picture, as `is_picture` requires.
      character(len=*), intent(in) :: name
      type(status_t), intent(out) :: status
      self%format = name(len(name) - 2:)
      call self%picture%open(name, status)
      if (.not. status%ok()) return
      ! The name of the script is as long as that of the picture, which may have the greatest possible length.
      call self%script%open(name(1:len(name) - 4)//'.gp'//name(len(name) - 2:len(name) - 2), status)
      if (.not. status%ok()) call discard_file(self%picture)
   end subroutine open

   !> Begins the script with the size of the picture.
   subroutine begin(self, width, height)
      class(picture_t), intent(inout) :: self
      !> Size of an SVG, pixels; a PNG has 1.5 times as many pixels, a PDF an inch for 100 of them.
      integer, intent(in) :: width, height
      integer :: i
      if (self%format == 'svg') then
         call self%put('set terminal svg size '//size_text(width, height)//' fixed name ''nutate'' font '// &
                       '''Helvetica,Arial,sans-serif,15'' background ''#ffffff''')
      else if (self%format == 'pdf') then
         call self%put('set terminal pdfcairo size '//count_text(width)//'/100., '// &
                       count_text(height)//'/100. font ''Helvetica,11''')
      else
         call self%put('if (strstrt(GPVAL_TERMINALS, ''pngcairo'') > 0) { set terminal pngcairo size '// &
                       size_text(3*width/2, 3*height/2)//' fontscale 1.4 } else { set terminal png size '// &
                       size_text(3*width/2, 3*height/2)//' large }')
      end if
      do i = 1, size(head)
         call self%put(trim(head(i)))
      end do
   end subroutine begin

   pure function size_text(width, height) result(text)
      integer, intent(in) :: width, height
      character(len=:), allocatable :: text
      text = count_text(width)//','//count_text(height)
   end function size_text

   !> Adds a line to the script. A line that could not be written is reported by `draw`.
   subroutine put(self, line)
      class(picture_t), intent(inout) :: self
      character(len=*), intent(in) :: line
      if (self%status%ok()) call self%script%put_line(line, self%status)
   end subroutine put

   !> Draws the picture with the script. Errors: `NUTATE_IO`; no file is left then.
   subroutine draw(self, status)
      class(picture_t), intent(inout) :: self
      type(status_t), intent(out) :: status
      character(len=:), allocatable :: target
      integer :: exit_status, command_status

      status = self%status
      if (status%ok()) call self%script%flush(status)
      if (status%ok()) then
         target = self%picture%name
         if (allocated(self%picture%partial)) target = self%picture%partial
         call execute_command_line('gnuplot -c '//shell_quoted(self%script%partial)//' '//shell_quoted(target)// &
                                   ' >/dev/null 2>&1', exitstat=exit_status, cmdstat=command_status)
         if (exit_status /= 0 .or. command_status /= 0) status = fail(NUTATE_IO, 'gnuplot failed to draw it')
      end if
      call discard_file(self%script)
      call close_file(self%picture, status)
   end subroutine draw

   !> Discards the files.
   subroutine discard(self)
      class(picture_t), intent(inout) :: self
      call discard_file(self%script)
      call discard_file(self%picture)
   end subroutine discard

   !> Returns a string in single quotes for gnuplot.
   pure function gnuplot_quoted(text) result(quoted)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: quoted
      quoted = "'"//escaped(text, "'", "'")//"'"
   end function gnuplot_quoted

   !> Returns a string in single quotes for the shell.
   pure function shell_quoted(text) result(quoted)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: quoted
      quoted = "'"//escaped(text, "'", "'\'")//"'"
   end function shell_quoted

end module nutate_gnuplot
