!> Tables: how they are read, the polynomials between their lines, and what makes no torque.
submodule(suites_of_effects) test_tables
   use, intrinsic :: iso_fortran_env, only: int64
   use nutate_keys, only: table_t
   use nutate_kinds, only: wp, eps
   use nutate_number_text, only: read_real
   use nutate_piecewise, only: interval_at, new_linear, new_spline, piecewise_t, taylor_term, value_at
   use nutate_quick_number, only: read_quickly
   use nutate_scene_error, only: scene_error_t, error_line
   use nutate_scene_table, only: parse_table, torque_units
   use nutate_status, only: status_t
   use nutate_tabulated_torque, only: make_tabulated_torque, tabulated_torque_t
   use test_support, only: check, check_close, error_type, new_unittest, random_unit, test_failed
   implicit none

   real(wp), parameter :: odd_times(9) = [0.0137_wp, 0.0731_wp, 0.1973_wp, 0.3119_wp, 0.3307_wp, 0.5501_wp, 0.7333_wp, &
                                          0.8717_wp, 1.1031_wp]

contains

   module procedure collect_tables
      testsuite = [ &
                  new_unittest("the interval of any time is found", intervals_are_found), &
                  new_unittest("a natural spline is the known one", natural_spline_is_known), &
                  new_unittest("a spline is smooth at its points", splines_are_smooth), &
                  new_unittest("quick numbers are those of the careful reader", quick_numbers_are_careful), &
                  new_unittest("a table is read whatever its line ends and quotes", tables_are_read), &
                  new_unittest("what is no table is refused with its line", bad_tables_are_refused), &
                  new_unittest("tables that make no torque are refused", bad_torques_are_refused)]
   end procedure collect_tables

   !> Even points, and points that crowd together.
   subroutine intervals_are_found(error)
      type(error_type), allocatable, intent(out) :: error
      type(piecewise_t) :: curve
      real(wp) :: times(200), values(3, 200), t
      integer(int64) :: seed
      integer :: case, i, k
      seed = 4711
      values = 0.0_wp
      do case = 1, 4
         times(1) = -3.0_wp
         do i = 2, size(times)
            times(i) = times(i - 1) + merge(0.1_wp, 10.0_wp**(-4*random_unit(seed)*(case - 1)), case == 1)
         end do
         curve = new_linear(times, values)
         do i = 1, 2000
            t = times(1) + (times(200) - times(1))*random_unit(seed)
            if (i <= 200) t = times(i)
            k = max(1, min(199, count(times <= t)))
            call check(error, interval_at(curve, t), k)
         end do
         call check(error, interval_at(curve, -1e9_wp) == 1 .and. interval_at(curve, 1e300_wp) == 199, 'outside')
      end do
   end subroutine intervals_are_found

   !> Through (0,0), (1,1), (2,0): s = ½(3x - x³) up to 1. Through two points it is the straight line.
   subroutine natural_spline_is_known(error)
      type(error_type), allocatable, intent(out) :: error
      type(piecewise_t) :: curve
      real(wp) :: values(3, 3), x
      integer :: i
      values = 0.0_wp
      values(2, 2) = 1.0_wp
      curve = new_spline([0.0_wp, 1.0_wp, 2.0_wp], values, .false.)
      do i = 0, 4
         x = 0.25_wp*i
         call check_close(error, value_at(curve, 1, x), [0.0_wp, 0.5_wp*(3*x - x**3), 0.0_wp], 4*eps)
         call check_close(error, value_at(curve, 2, 2 - x), [0.0_wp, 0.5_wp*(3*x - x**3), 0.0_wp], 4*eps)
      end do
      curve = new_spline([0.0_wp, 1.0_wp], values(:, 1:2), .false.)
      call check_close(error, value_at(curve, 1, 0.3_wp), [0.0_wp, 0.3_wp, 0.0_wp], 4*eps)
   end subroutine natural_spline_is_known

   !> Values, slopes and curvatures are the same from both sides of a point; a natural spline has no curvature at its
   !> ends, a periodic one goes on from its last point as from its first.
   subroutine splines_are_smooth(error)
      type(error_type), allocatable, intent(out) :: error
      type(piecewise_t) :: curve
      real(wp) :: values(3, 9)
      integer(int64) :: seed
      integer :: i, j, k
      logical :: periodic
      seed = 99
      do i = 1, 9
         values(:, i) = [random_unit(seed), random_unit(seed), random_unit(seed)]
      end do
      values(:, 9) = values(:, 1)
      do i = 1, 2
         periodic = i == 2
         curve = new_spline(odd_times, values, periodic)
         do k = 1, 8
            call check_close(error, value_at(curve, k, odd_times(k + 1)), values(:, k + 1), 64*eps, 'value')
            if (k == 8 .and. .not. periodic) exit
            do j = 1, 2
               call check_close(error, taylor_term(curve, k, j, odd_times(k + 1), 0.05_wp), &
                                taylor_term(curve, modulo(k, 8) + 1, j, odd_times(modulo(k, 8) + 1), 0.05_wp), 512*eps)
            end do
         end do
         if (periodic) cycle
         call check_close(error, [taylor_term(curve, 1, 2, odd_times(1), 0.05_wp), &
                                  taylor_term(curve, 8, 2, odd_times(9), 0.05_wp)], spread(0.0_wp, 1, 6), 512*eps, &
                          'ends')
      end do
   end subroutine splines_are_smooth

   !> Checks numbers as programs write them: with 6, 15, 17 and 19 digits, with and without exponent.
   subroutine quick_numbers_are_careful(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=12), parameter :: formats(5) = [character(len=12) :: '(es13.5e2)', '(f24.17)', '(es24.16e3)', &
                                                    '(es27.18e2)', '(f12.3)']
      character(len=8), parameter :: others(9) = [character(len=8) :: '1d3', 'Infinity', '1.e', '.', '-', '1e', '1e+', &
                                                  '0x1', '1 2']
      character(len=40) :: word
      character(len=:), allocatable :: problem
      real(wp) :: number, quick, careful
      integer(int64) :: seed
      integer :: i, n_done
      logical :: done
      seed = 2024
      n_done = 0
      do i = 1, 20000
         number = (2*random_unit(seed) - 1)*10.0_wp**(24*random_unit(seed) - 12)
         write (word, formats(1 + mod(i, size(formats)))) number
         if (word(1:1) == '*') cycle
         word = adjustl(word)
         call read_quickly(trim(word), quick, done)
         if (.not. done) cycle
         n_done = n_done + 1
         call read_real(trim(word), careful, problem)
         call check_close(error, quick, careful, 0.0_wp, trim(word))
      end do
      call check(error, n_done > 17000, 'most are quick')
      do i = 1, size(others)
         call read_quickly(trim(others(i)), quick, done)
         call check(error, .not. done, trim(others(i)))
      end do
   end subroutine quick_numbers_are_careful

   subroutine tables_are_read(error)
      type(error_type), allocatable, intent(out) :: error
      character, parameter :: lf = achar(10), cr = achar(13), tab = achar(9)
      real(wp), parameter :: expected(8) = [0.0_wp, 1.0_wp, -2.0_wp, 3e-5_wp, 0.5_wp, 0.1_wp, 0.0_wp, 1e10_wp]
      call try('t (s),a (N m),b (N m),c (N m)'//lf//'0,1,-2,3e-5'//lf//'0.5,.1,0,1e10'//lf)
      call try('t (s),a (N m),b (N m),c (N m)'//cr//lf//'0,1,-2,3E-5'//cr//lf//'5e-1,0.1,-0,1d10')
      call try(char(239)//char(187)//char(191)//'"t (s)","a (N m)","b (N m)", "c (N m)"'//lf// &
               '"0",  1.0 ,'//tab//'-2.,"3.0e-05"'//lf//'00.50,0.1000000000000000000000001,0e9,10000000000'//lf)
      call try('"time, of day (s)","a, about x (N m)" , "the ""best"", b (N m)","(N m)"'//cr//lf// &
               '0,"1",-2,3e-5'//cr//lf//'0.5,.1,0,"1e10"')
   contains
      subroutine try(text)
         character(len=*), intent(in) :: text
         type(table_t) :: table
         type(scene_error_t) :: wrong
         if (allocated(error)) return
         call parse_table(text, 'table.csv', torque_units, table, wrong)
         if (wrong%raised) then
            call test_failed(error, wrong%text)
         else
            call check_close(error, reshape(table%numbers, [size(table%numbers)]), expected, 0.0_wp)
         end if
      end subroutine try
   end subroutine tables_are_read

   subroutine bad_tables_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      character, parameter :: lf = achar(10)
      character(len=*), parameter :: header = 't (s),a (N m),b (N m),c (N m)'//lf
      call try('', 't.csv:1: the header has the wrong number of columns')
      call try('t (ms),a (N m),b (N m),c (N m)'//lf, "t.csv:1: 't (ms)' lacks the unit (s)")
      call try('t (s),a,b (N m),c (N m)'//lf, "t.csv:1: 'a' lacks the unit (N m)")
      call try('t (s),a (N m),b (N m)'//lf, 't.csv:1: the header has the wrong number of columns')
      call try('t (s),a (N m),b (N m),c (N m),d (N m)'//lf, 't.csv:1: the header has the wrong number of columns')
      call try('0,1,2,3'//lf, "t.csv:1: '0' lacks the unit")
      call try(header//'0,1,2,3'//lf//'1,1,x,3'//lf, "t.csv:3: 'x' is not a number")
      call try(header//'0,1,2,3'//lf//'1,1,,3'//lf, "t.csv:3: '' is not a number")
      call try(header//'0,1,2'//lf, 't.csv:2: wrong number of values in this line')
      call try(header//'0,1,2,3,4'//lf, 't.csv:2: wrong number of values in this line')
      call try(header//'0,1,2,3'//lf//lf//'1,1,2,3'//lf, 't.csv:3: wrong number of values in this line')
      call try(header//'0,1,2,1e200'//lf, "t.csv:2: '1e200' is too large")
      call try(header//'0,"1,2,3'//lf, "t.csv:2: '""1' has a quote that is not closed")
      call try(header//'0,"1,5",2,3'//lf, "t.csv:2: '1,5' is not a number")
      call try(header//'0,"1"",2,3'//lf//'1,1",2,3'//lf, "t.csv:2: '""1""""' has a quote that is not closed")
      call try(header//'0,"1"0"",2,3'//lf, "t.csv:2: '""1""0""""' has a quote that is not closed")
      call try('"time, of day,a (N m),b (N m),c (N m)'//lf, "t.csv:1: '""time' has a quote that is not closed")
      call try(header//'0,'//achar(7)//',2,3'//lf, "t.csv:2: '\x07' is not a number")
   contains
      subroutine try(text, says)
         character(len=*), intent(in) :: text, says
         type(table_t) :: table
         type(scene_error_t) :: wrong
         if (allocated(error)) return
         call parse_table(text, 't.csv', torque_units, table, wrong)
         if (.not. wrong%raised) then
            call test_failed(error, 'not refused: '//says)
         else if (index(error_line('scene.nml', wrong), says) /= 1) then
            call test_failed(error, error_line('scene.nml', wrong)//' is not '//says)
         end if
      end subroutine try
   end subroutine bad_tables_are_refused

   subroutine bad_torques_are_refused(error)
      type(error_type), allocatable, intent(out) :: error
      call try([0.0_wp, 1.0_wp, 0.5_wp], .false., .false., 3, 'decreases')
      call try([0.0_wp, 1.0_wp, 1.0_wp], .true., .false., 3, 'jumps need')
      call try([0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp], .false., .false., 4, 'three lines')
      call try([0.0_wp, 1e-60_wp], .false., .false., 2, 'too close')
      call try([0.0_wp], .false., .false., 1, 'too short')
      call try([1.0_wp, 1.0_wp], .false., .false., 2, 'one time')
      call try([0.0_wp, 1.0_wp, 2.0_wp], .true., .true., 3, 'too short')
      call try([0.0_wp, 1.0_wp, 2.0_wp, 3.0_wp], .true., .true., 4, 'differs from the first')
      call try([0.0_wp, 1e101_wp], .false., .false., 2, 'too large')
      call try([0.0_wp, 1.0_wp], .false., .false., 0, 'acts at no time of its table', start=1.0_wp)
   contains
      subroutine try(times, spline, periodic, at, says, start)
         real(wp), intent(in) :: times(:)
         logical, intent(in) :: spline, periodic
         integer, intent(in) :: at
         character(len=*), intent(in) :: says
         real(wp), intent(in), optional :: start
         type(tabulated_torque_t) :: torque
         type(status_t) :: status
         integer :: line, i
         if (allocated(error)) return
         call make_tabulated_torque(times, reshape([(real(i, wp), i=1, 3*size(times))], [3, size(times)]), torque, &
                                    status, line, spline=spline, periodic=periodic, start=start)
         call check(error, line == at .and. index(status%message, says) > 0, says//': '//trim(status%message))
      end subroutine try
   end subroutine bad_torques_are_refused

end submodule test_tables
