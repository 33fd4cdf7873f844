!> The files that a command reads and writes. Each output has its own name, is none of the inputs, and replaces only a
!> file of the same kind, which is recognised by its first bytes.
module nutate_outputs
   use nutate_console, only: report_file, say_error, EXIT_INPUT
   use nutate_files, only: goes_to_file, output_file_t, partial_name, same_file
   use nutate_kinds, only: long
   use nutate_printable, only: printable_path
   use nutate_scene, only: scene_t
   use nutate_scene_output, only: format_fault
   use nutate_scene_table, only: names_a_file, path_beside
   use nutate_spelling, only: lower_case
   use nutate_status, only: status_t
   use nutate_sweep_file, only: read_bytes
   implicit none
   private

   public :: check_writable, close_file, discard_file, write_whole
   public :: outputs_t, EVENTS, HISTORY, ROWS, ROWS_AS_CSV, MEANS, COSTS, PAGE, CHECKPOINT, LISTING, &
             AEM, GLTF, RESIDUALS, FITTED, LINEARIZATION, picture_kind

   !> Kinds of output files: positions in `kinds`.
   integer, parameter :: EVENTS = 1, HISTORY = 2, ROWS = 3, ROWS_AS_CSV = 4, MEANS = 5, COSTS = 6, PAGE = 7, SVG = 8, &
                         PNG = 10, CHECKPOINT = 11, LISTING = 13, PDF = 14, AEM = 15, GLTF = 16, &
                         RESIDUALS = 17, FITTED = 18, LINEARIZATION = 19
   !> Number of bytes by which a file is recognised.
   integer, parameter :: longest_start = 24

   !> One kind of file.
   type :: kind_t
      !> Name of the kind, and phrase by which a message names the content.
      character(len=24) :: words, content
      !> First bytes of the file, in lower case.
      character(len=longest_start) :: start
      !> True if the file is CSV and must not have the name of another format.
      logical :: is_csv = .false.
   end type kind_t

   !> All kinds of files. If two begin alike, the longer beginning comes first. Entries with the same words are one
   !> kind, such as the means of a sweep and its sums while it runs.
   type(kind_t), parameter :: kinds(19) = [ &
      kind_t('a file of events', 'events go', 't,event,', .true.), &
      kind_t('a history', 'rows go', 't,', .true.), &
      kind_t('a NumPy file of rows', 'rows go', char(147)//'numpy'), &
      kind_t('a CSV file of members', 'rows go as CSV', 'member,status,', .true.), &
      kind_t('a CSV file of means', 'means go', 'field,members,', .true.), &
      kind_t('a CSV file of run times', 'run times go', 'method,order,', .true.), &
      kind_t('a web page', 'page goes', '<!doctype html'), &
      kind_t('an SVG picture', 'picture goes', '<?xml'), &
      kind_t('an SVG picture', 'picture goes', '<svg'), &
      kind_t('a PNG picture', 'picture goes', char(137)//'png'), &
      kind_t('a checkpoint', 'checkpoint goes', 'nutate checkpoint'), &
      kind_t('a CSV file of means', 'means go', 'nutate sweep sums'), &
      kind_t('a listing of fields', 'listing of fields goes', 'nutate'), &
      kind_t('a PDF picture', 'picture goes', '%pdf-'), &
      kind_t('an AEM', 'attitudes go as AEM', 'ccsds_aem_vers'), &
      kind_t('a glTF file', 'attitudes go as glTF', '{"asset":'), &
      kind_t('a CSV file of residuals', 'residuals go', 'measurement,t,', .true.), &
      kind_t('a fitted scene', 'fitted scene goes', '! nutate fit of '), &
      kind_t('a linearisation as JSON', 'linearisation goes', '{"nutate":')]

   !> File of a command.
   type :: item_t
      character(len=:), allocatable :: name
      !> Position in `kinds`; 0 for a file that is read.
      integer :: kind = 0
      !> Description of a file that is read.
      character(len=:), allocatable :: words
   end type item_t

   !> The files of a command.
   type :: outputs_t
      !> First problem with the files, in a line; empty if there is none.
      character(len=:), allocatable :: problem
      type(item_t), allocatable, private :: items(:)
   contains
      !> Adds an input, a file or a scene with its tables, before any output.
      procedure :: read_file
      procedure :: read_scene
      !> Adds a file to be written.
      procedure :: add
      !> Reports the problem, if there is one.
      procedure :: report
   end type outputs_t

contains

   !> Closes an output file and removes its partial file.
   subroutine discard_file(file)
      type(output_file_t), intent(inout) :: file
      type(status_t) :: status
      integer :: unit, iostat
      call file%abandon(status)
      if (.not. allocated(file%partial)) return
      open (newunit=unit, file=file%partial, status='old', iostat=iostat)
      if (iostat /= 0) return
      close (unit, status='delete', iostat=iostat)
      if (iostat /= 0) file%partial = ''
   end subroutine discard_file

   !> Completes a file if the status is a success, else removes what was written. Errors: `NUTATE_IO`.
   subroutine close_file(file, status)
      type(output_file_t), intent(inout) :: file
      type(status_t), intent(inout) :: status
      if (status%ok()) then
         call file%finish(status)
      else
         call discard_file(file)
      end if
   end subroutine close_file

   !> Reports a file that cannot be written, before the work is done whose result it gets.
   subroutine check_writable(name, exit_code)
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      !> Exit code, changed if there is a problem.
      integer, intent(inout) :: exit_code
      type(output_file_t) :: file
      type(status_t) :: status
      if (.not. goes_to_file(name)) return
      call file%open(name, status)
      call report_file(name, status, exit_code)
      if (status%ok()) call discard_file(file)
   end subroutine check_writable

   !> Writes a file that consists of one text, and reports it if that fails.
   subroutine write_whole(text, name, exit_code)
      character(len=*), intent(in) :: text
      !> Path, or `-` for standard output.
      character(len=*), intent(in) :: name
      integer, intent(inout) :: exit_code
      type(output_file_t) :: file
      type(status_t) :: status
      call file%open(name, status)
      if (status%ok()) call file%put_line(text, status)
      call close_file(file, status)
      call report_file(name, status, exit_code)
   end subroutine write_whole

   !> Adds a file that is read.
   subroutine read_file(self, name, words)
      class(outputs_t), intent(inout) :: self
      !> Path and description of the file.
      character(len=*), intent(in) :: name, words
      if (.not. allocated(self%items)) then
         allocate (self%items(0))
         self%problem = ''
      end if
      call append(self%items, name, 0, words)
   end subroutine read_file

   !> Adds an item. An array constructor of items would lose memory with gfortran 12.
   subroutine append(items, name, kind, words)
      type(item_t), allocatable, intent(inout) :: items(:)
      character(len=*), intent(in) :: name, words
      integer, intent(in) :: kind
      type(item_t), allocatable :: longer(:)
      integer :: n
      n = size(items)
      allocate (longer(n + 1))
      longer(:n) = items
      longer(n + 1)%name = name
      longer(n + 1)%kind = kind
      longer(n + 1)%words = words
      call move_alloc(longer, items)
   end subroutine append

   !> Adds a scene and the tables that it names, all of which are read.
   subroutine read_scene(self, scene)
      class(outputs_t), intent(inout) :: self
      type(scene_t), intent(in) :: scene
      character(len=:), allocatable :: name, words
      integer :: i, k
      call self%read_file(scene%file, 'the scene itself')
      do i = 1, size(scene%groups)
         associate (group => scene%groups(i))
            words = 'a table of the scene'
            if (group%name == 'measurement') words = 'a file of measurements'
            if (group%name == 'frame') words = 'the attitude of a frame'
            do k = 1, size(group%settings)
               name = trim(group%settings(k)%name)
               if (names_a_file(trim(group%name), name)) &
                  call self%read_file(path_beside(scene%file, group%text(name, '')), words)
            end do
         end associate
      end do
   end subroutine read_scene

   !> Adds a file to be written, unless it has no name.
   subroutine add(self, name, kind)
      !> Files of the command, with its inputs.
      class(outputs_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      !> Kind of the file: `HISTORY`, ...
      integer, intent(in) :: kind
      integer :: i
      if (name == '' .or. self%problem /= '') return
      self%problem = format_problem(name, kind)
      do i = 1, size(self%items)
         if (self%problem == '') self%problem = clash(self%items(i), name)
      end do
      if (self%problem == '' .and. goes_to_file(name)) then
         self%problem = objection(name, kind, .true.)
         if (self%problem == '') self%problem = objection(partial_name(name), kind, .false.)
      end if
      call append(self%items, name, kind, '')
   end subroutine add

   !> Reports the problem with the files, if there is one.
   subroutine report(self, exit_code)
      class(outputs_t), intent(in) :: self
      !> Exit code, changed if there is a problem.
      integer, intent(inout) :: exit_code
      if (self%problem == '') return
      call say_error('nutate: '//self%problem, exit_code, EXIT_INPUT)
   end subroutine report

   !> Returns the kind of a picture with this name.
   pure integer function picture_kind(name) result(kind)
      !> Name of a picture, as `is_picture` requires.
      character(len=*), intent(in) :: name
      kind = merge(SVG, merge(PDF, PNG, name(len(name) - 3:) == '.pdf'), name(len(name) - 3:) == '.svg')
   end function picture_kind

   !> Returns the problem with the ending of a name; empty if there is none.
   function format_problem(name, kind) result(problem)
      character(len=*), intent(in) :: name
      integer, intent(in) :: kind
      character(len=:), allocatable :: problem
      problem = ''
      if (.not. kinds(kind)%is_csv) return
      problem = format_fault(name)
      if (problem /= '') problem = printable_path(name)//' '//problem//' (expected a name such as NAME.csv)'
   end function format_problem

   !> Returns why a file cannot have this name beside another file; empty if it can.
   function clash(other, name) result(problem)
      type(item_t), intent(in) :: other
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: problem
      logical :: same
      problem = ''
      ! Two outputs may go to the same device, but not both to standard output.
      same = other%name == name .and. name == '-'
      if (goes_to_file(name)) same = same_file(other%name, name)
      if (.not. same) return
      if (other%kind == 0) then
         problem = printable_path(name)//' is '//other%words//' and would be overwritten'
      else
         problem = printable_path(name)//' is where the '//trim(kinds(other%kind)%content)
      end if
      problem = problem//' (expected another name)'
   end function clash

   !> Returns why a file cannot replace an existing one; empty if it can.
   function objection(path, kind, is_whole) result(problem)
      !> Path of the existing file; empty for none.
      character(len=*), intent(in) :: path
      !> Kind of the new file.
      integer, intent(in) :: kind
      !> True for a finished file; remains of a crash that show no kind can be replaced.
      logical, intent(in) :: is_whole
      character(len=:), allocatable :: problem, start
      integer :: there
      problem = ''
      if (path == '') return
      call read_bytes(path, 0_long, longest_start, start)
      if (len(start) == 0) return
      do there = 1, size(kinds)
         if (index(lower_case(start), trim(kinds(there)%start)) == 1) exit
      end do
      if (there > size(kinds)) then
         if (is_whole) problem = ' exists and is not '//trim(kinds(kind)%words)// &
                                 ' (expected another name, or remove it)'
      else if (kinds(there)%words /= kinds(kind)%words) then
         problem = ' is '//trim(kinds(there)%words)//', not '//trim(kinds(kind)%words)//' (expected another name)'
      end if
      if (problem /= '') problem = printable_path(path)//problem
   end function objection

end module nutate_outputs
