!> Notation of scenes: lines, blanks, comments, numbers; and malformed text that the reader must survive.
submodule(suites_of_runs) test_scene_notation
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_kinds, only: wp
   use nutate_number_text, only: read_real
   use nutate_scene, only: scene_t, parse_scene
   use nutate_spelling, only: edit_distance, nearest_name
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_SCENE
   use test_support, only: check, check_close, error_type, new_unittest, one_in, random_unit, test_failed
   implicit none

   character, parameter :: tab = achar(9), lf = achar(10), cr = achar(13)

contains

   module procedure collect_scene_notation
      testsuite = [ &
         new_unittest("lines may end as on Windows, without a last end", line_ends), &
         new_unittest("blanks, tabs, comments and commas may stand between values", separators), &
         new_unittest("a comment sign in a text is text", comment_sign_in_text), &
         new_unittest("a byte order mark is passed over", byte_order_mark), &
         new_unittest("a value may be repeated", repeats), &
         new_unittest("numbers are read as Fortran writes them", numbers), &
         new_unittest("numbers are the nearest to what is written", nearest_numbers), &
         new_unittest("misspelt names are recognised", spelling), &
         new_unittest("long messages are cut between words", long_messages), &
         new_unittest("lines of megabytes are read in a moment", long_lines), &
         new_unittest("any damage gives a scene or one line", mutations)]
   end procedure collect_scene_notation

   subroutine check_reads(text, error)
      character(len=*), intent(in) :: text
      type(error_type), allocatable, intent(inout) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse_scene(text, 'x.nml', scene, status, message)
      if (.not. status%ok()) then
         call test_failed(error, message)
      else
         call check_close(error, [scene%system%body%moments, scene%initial%p(2:4)/2, scene%plan%time_step], &
                          [5.0_wp, 20.0_wp, 17.0_wp, 0.5_wp, 0.0_wp, 170.0_wp, 0.1_wp], 0.0_wp)
      end if
   end subroutine check_reads

   !> Puts an end of line, or what else stands between items, into a scene.
   pure function box(gap, comma) result(text)
      character(len=*), intent(in) :: gap, comma
      character(len=:), allocatable :: text
      text = '&body'//gap//'inertia='//gap//'5.0'//comma//'20.0'//comma//'17.0'//gap//'/'//gap// &
             '&initial'//gap//'angular_velocity'//gap//'='//gap//'0.1'//comma//'0.0'//comma//'10.0/'//gap// &
             '&integrator'//gap//'time_step='//gap//'0.1'//comma//'end_time=2.0'//gap//'/'
   end function box

   subroutine line_ends(error)
      type(error_type), allocatable, intent(out) :: error
      call check_reads(box(lf, ', '), error)
      call check_reads(box(cr//lf, cr//lf), error)
      call check_reads(box(cr//lf//cr//lf, ',')//cr//lf, error)
   end subroutine line_ends

   subroutine separators(error)
      type(error_type), allocatable, intent(out) :: error
      call check_reads(box(' ', ' '), error)
      call check_reads(box(tab, tab//','//tab), error)
      call check_reads(box(' ! a comment, with & and / and ''quotes'//lf, '! another'//lf//' , '), error)
      call check_reads('! '//char(195)//char(164)//lf//box(lf, ',')//'! the end', error)
   end subroutine separators

   subroutine comment_sign_in_text(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse_scene(box(' ', ',')//"&scene title = 'a ! b / c & d = e' / ! comment", 'x.nml', scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      call check(error, scene%title == 'a ! b / c & d = e', scene%title)
   end subroutine comment_sign_in_text

   subroutine byte_order_mark(error)
      type(error_type), allocatable, intent(out) :: error
      call check_reads(char(239)//char(187)//char(191)//box(lf, ','), error)
   end subroutine byte_order_mark

   subroutine repeats(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      call parse_scene("&body inertia = 2*3, 1*4 / &initial angular_velocity = 1, 2*.5 quaternion = 1 3*0 / "// &
                       "&integrator time_step = 1*0.1, end_time = 2 / &output columns = 1*'energy', 1*""solver"" /", &
                       'x.nml', scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      call check_close(error, [scene%system%body%moments, scene%initial%p], &
                       [3.0_wp, 3.0_wp, 4.0_wp, 0.0_wp, 6.0_wp, 3.0_wp, 4.0_wp], 0.0_wp)
   end subroutine repeats

   subroutine numbers(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=12), parameter :: words(14) = [character(len=12) :: '1', '+1.', '.5', '-0.25', '1e2', '1E+2', &
                                                   '1d-2', '1.5D3', '1q1', '0.5+1', '1.-1', '0e999999', '-0', '00012']
      real(wp), parameter :: values(14) = [1.0_wp, 1.0_wp, 0.5_wp, -0.25_wp, 100.0_wp, 100.0_wp, 0.01_wp, 1500.0_wp, &
                                           10.0_wp, 5.0_wp, 0.1_wp, 0.0_wp, 0.0_wp, 12.0_wp]
      character(len=10), parameter :: wrong(14) = [character(len=10) :: '.', '+', '1e', 'e1', '1e+', '1+3', '1.e.', &
                                                   '1 2', '0x1', '1_8', 'nan', 'infinite', '1,', '--1']
      real(wp) :: value
      character(len=:), allocatable :: problem
      integer :: i
      do i = 1, size(words)
         call read_real(trim(words(i)), value, problem)
         call check(error, problem == '', problem)
         call check_close(error, value, values(i), 0.0_wp, words(i))
      end do
      do i = 1, size(wrong)
         call read_real(trim(wrong(i)), value, problem)
         call check(error, problem == "'"//trim(wrong(i))//"' is not a number", trim(wrong(i))//' is refused')
      end do
   end subroutine numbers

   subroutine nearest_numbers(error)
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: value
      character(len=:), allocatable :: problem
      call read_real('0.1000000000000000055511151231257827021181583404541015625', value, problem)
      call check_close(error, value, 0.1_wp, 0.0_wp, 'all digits of 0.1')
      ! Halfway between 1 and the next number, then a trace more, 1000 digits behind the point.
      call read_real('1.00000000000000011102230246251565404236316680908203125'//repeat('0', 1000)//'1', value, problem)
      call check_close(error, value, 1.0_wp + epsilon(1.0_wp), 0.0_wp, 'a trace above a tie')
      call read_real('1'//repeat('0', 100), value, problem)
      call check(error, problem == '' .and. abs(value/1e100_wp - 1) <= 0.0_wp, 'the largest number')
      call read_real('1.0000000000000000000000000000000000001e100', value, problem)
      call check(error, index(problem, 'too large') > 0, 'a larger one')
      call read_real('1e-300', value, problem)
      call check(error, problem == '' .and. value > 0, 'the smallest number')
      call read_real('0.'//repeat('0', 300)//'9', value, problem)
      call check(error, index(problem, 'too close to zero') > 0, 'a smaller one')
   end subroutine nearest_numbers

   subroutine spelling(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=16), parameter :: known(4) = [character(len=16) :: 'mass', 'density', 'center_of_mass', 'inertia']
      call check(error, edit_distance('inertia', 'intertia') == 1 .and. edit_distance('ab', 'ba') == 1 .and. &
                 edit_distance('', 'abc') == 3 .and. edit_distance('kitten', 'sitting') == 3, 'distances')
      call check(error, nearest_name('CENTRE_OF_MASS', known) == 'center_of_mass' .and. &
                 nearest_name('masss', known) == 'mass' .and. nearest_name('spring', known) == '', 'nearest names')
      call check(error, nearest_name('dens', known) == 'density' .and. nearest_name('d', known) == '' .and. &
                 nearest_name('--out', ['--set   ', '--output']) == '--output' .and. &
                 nearest_name('--re', [character(len=8) :: '--resume', '--resume']) == '--resume' .and. &
                 nearest_name('--', ['--set   ', '--output']) /= '--output', 'names that are cut short')
   end subroutine spelling

   subroutine long_messages(error)
      type(error_type), allocatable, intent(out) :: error
      type(status_t) :: status
      character(len=*), parameter :: words = repeat('abc, wheel, ', 40)
      integer :: gap
      status = fail(NUTATE_BAD_ARGUMENT, words//'the end')
      gap = index(status%message, ' ... ')
      call check(error, gap > 100 .and. len_trim(status%message) > 190, 'most of it is there')
      call check(error, status%message(gap - 1:gap - 1) == ',' .and. &
                 index(words//'the end', ' '//trim(status%message(gap + 5:))) > 0, 'within a word: '//status%message)
      status = fail(NUTATE_BAD_ARGUMENT, repeat('x', 1000))
      call check(error, len_trim(status%message), len(status%message))
   end subroutine long_messages

   subroutine long_lines(error)
      type(error_type), allocatable, intent(out) :: error
      call check_long(box(' ', ',')//' !', 'x', .true., error)
      call check_long(box(' ', ','), ' ', .true., error)
      call check_long('', 'x', .false., error)
      call check_long('&body inertia = ', '1', .false., error)
      call check_long('&body inertia = ', '1,', .false., error)
      call check_long("&scene title = '", "''", .false., error)
      call check_long('&body inertia = 5 ', '!'//lf, .false., error)
      call check_long('&', 'x', .false., error)
      call check_long('&body ', 'x', .false., error)
      call check_long('&body shape', 'e', .false., error)
      call check_long("&body shape = '", 'x', .false., error)
      call check_long('&body check_triangle = ', 't', .false., error)
   end subroutine long_lines

   !> Parses a start followed by 10 MB of one piece, which is right or wrong, or by 3 MB in `make test`. A parser whose
   !> time grows with the square takes hours for it.
   subroutine check_long(start_text, piece, right, error)
      character(len=*), intent(in) :: start_text, piece
      logical, intent(in) :: right
      type(error_type), allocatable, intent(inout) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message, text
      integer :: i
      allocate (scene)
      allocate (character(len=len(start_text) + merge(3000000, 10000000, one_in() > 3)) :: text)
      text(1:len(start_text)) = start_text
      do i = len(start_text) + 1, len(text), len(piece)
         text(i:min(len(text), i + len(piece) - 1)) = piece
      end do
      call parse_scene(text, 'x.nml', scene, status, message)
      call check(error, status%ok() .eqv. right, 'outcome: '//message)
      call check(error, len(message) < 400, 'length of the message')
   end subroutine check_long

   subroutine mutations(error)
      type(error_type), allocatable, intent(out) :: error
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message, text
      integer(int64) :: seed
      integer :: i
      allocate (scene)
      seed = 20120101_int64
      do i = 1, 2000
         text = damaged(seed)
         call parse_scene(text, 'x.nml', scene, status, message)
         if (status%ok()) then
            call check(error, message == '', 'no message without an error')
         else
            call check(error, status%code == NUTATE_BAD_SCENE .and. is_one_line(message), message)
         end if
      end do
   end subroutine mutations

   !> `FILE:LINE: text`, printable ASCII.
   pure logical function is_one_line(message)
      character(len=*), intent(in) :: message
      integer :: i
      is_one_line = index(message, 'x.nml:') == 1 .and. len(message) < 900 .and. index(message, ': ') > 7
      do i = 1, len(message)
         is_one_line = is_one_line .and. iachar(message(i:i)) >= 32 .and. iachar(message(i:i)) < 127
      end do
   end function is_one_line

   !> A scene with one to four pieces replaced, cut out or doubled.
   function damaged(seed) result(text)
      integer(int64), intent(inout) :: seed
      character(len=:), allocatable :: text
      character(len=12), parameter :: pieces(24) = [character(len=12) :: '1e999', 'NaN', '-Infinity', '/', '&body', &
                                                    '=', ',', '''', '"', '!', '3*', '0*1', '99999*1', '(2)', '&end', &
                                                    '1d-400', lf, cr//lf, tab, char(0), &
                                                    char(255)//char(254), '-1e100', '1e-300', '1e100']
      integer :: i, first, last
      text = "&body shape = 'box', size = 4, 1, 2, mass = 12, center_of_mass = 0.1, 0, 0 /"//lf// &
             "&initial euler = 10, 20, 30, euler_rates = 0.1, 0, 10, degrees = .true. /"//lf// &
             "&integrator time_step = 0.01, end_time = 20, auxiliary_inertia = Infinity, max_iterations = 20 /"//lf// &
             "&output file = 'box.csv', interval = 0.1, columns = 'quaternion', 'energy' /"//lf//"&gravity /"//lf
      do i = 1, 1 + int(4*random_unit(seed))
         first = 1 + int(len(text)*random_unit(seed))
         last = min(len(text), first + int(12*random_unit(seed)))
         select case (int(4*random_unit(seed)))
         case (0)
            text = text(1:first - 1)//trim(pieces(1 + int(size(pieces)*random_unit(seed))))//text(last + 1:)
         case (1)
            text = text(1:first - 1)//text(last + 1:)
         case (2)
            text = text(1:last)//text(first:)
         case default
            text = text(1:first - 1)//char(int(256*random_unit(seed)))//text(first + 1:)
         end select
      end do
   end function damaged

end submodule test_scene_notation
