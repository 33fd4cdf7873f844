!> Stand-in for test-drive 0.5.0, for machines that cannot fetch it: the same names and argument lists, and only
!> the part of them that the tests of nutate use.
!>
!> A test is a subroutine with one allocatable `error`; it fails when `error` is allocated on return.
module testdrive
   use, intrinsic :: iso_fortran_env, only: real64
   implicit none
   private

   public :: unittest_type, testsuite_type, error_type
   public :: new_unittest, new_testsuite, select_suite, run_testsuite, run_selected
   public :: check, test_failed, skip_test, get_argument
   public :: test_interface, collect_interface

   !> Values of `error_type%stat`.
   integer, parameter :: failure = 1, skipped = 77

   !> Why a test did not pass.
   type :: error_type
      integer :: stat = 0
      character(len=:), allocatable :: message
   end type error_type

   abstract interface
      !> A test.
      subroutine test_interface(error)
         import :: error_type
         type(error_type), allocatable, intent(out) :: error
      end subroutine test_interface
   end interface

   !> A test and its name; `should_fail` turns the verdict round.
   type :: unittest_type
      character(len=:), allocatable :: name
      procedure(test_interface), pointer, nopass :: test => null()
      logical :: should_fail = .false.
   end type unittest_type

   abstract interface
      !> Hands out the tests of a suite.
      subroutine collect_interface(testsuite)
         import :: unittest_type
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_interface
   end interface

   !> A suite and its name.
   type :: testsuite_type
      character(len=:), allocatable :: name
      procedure(collect_interface), pointer, nopass :: collect => null()
   end type testsuite_type

   !> Fails the test when a condition is false or a value is not the expected one.
   interface check
      module procedure check_true
      module procedure check_logical
      module procedure check_integer
      module procedure check_real
      module procedure check_character
   end interface check

contains

   function new_unittest(name, test, should_fail) result(unittest)
      character(len=*), intent(in) :: name
      procedure(test_interface) :: test
      logical, intent(in), optional :: should_fail
      type(unittest_type) :: unittest
      unittest%name = name
      unittest%test => test
      if (present(should_fail)) unittest%should_fail = should_fail
   end function new_unittest

   function new_testsuite(name, collect) result(suite)
      character(len=*), intent(in) :: name
      procedure(collect_interface) :: collect
      type(testsuite_type) :: suite
      suite%name = name
      suite%collect => collect
   end function new_testsuite

   !> Position of the suite of that name, 0 if there is none.
   integer function select_suite(suites, name) result(position)
      type(testsuite_type), intent(in) :: suites(:)
      character(len=*), intent(in) :: name
      do position = size(suites), 1, -1
         if (suites(position)%name == name) return
      end do
      position = 0
   end function select_suite

   !> Runs all tests of a suite, reports to `unit` and adds the number of failures to `stat`. The tests run one
   !> after the other whatever `parallel` says.
   subroutine run_testsuite(collect, unit, stat, parallel)
      procedure(collect_interface) :: collect
      integer, intent(in) :: unit
      integer, intent(inout) :: stat
      logical, intent(in), optional :: parallel
      type(unittest_type), allocatable :: tests(:)
      integer :: i
      if (present(parallel)) continue
      call collect(tests)
      do i = 1, size(tests)
         write (unit, '("  Starting ",a," ... (",i0,"/",i0,")")') tests(i)%name, i, size(tests)
         call run_test(tests(i), unit, stat)
      end do
   end subroutine run_testsuite

   !> Runs the test of that name. Without one, lists the names and makes `stat` negative.
   subroutine run_selected(collect, name, unit, stat)
      procedure(collect_interface) :: collect
      character(len=*), intent(in) :: name
      integer, intent(in) :: unit
      integer, intent(inout) :: stat
      type(unittest_type), allocatable :: tests(:)
      integer :: i
      call collect(tests)
      do i = 1, size(tests)
         if (tests(i)%name == name) then
            call run_test(tests(i), unit, stat)
            return
         end if
      end do
      write (unit, '(a)') "  Available tests:"
      do i = 1, size(tests)
         write (unit, '("  - ",a)') tests(i)%name
      end do
      stat = -huge(stat)
   end subroutine run_selected

   subroutine run_test(unittest, unit, stat)
      type(unittest_type), intent(in) :: unittest
      integer, intent(in) :: unit
      integer, intent(inout) :: stat
      type(error_type), allocatable :: error
      character(len=:), allocatable :: verdict
      call unittest%test(error)
      if (allocated(error) .neqv. unittest%should_fail) then
         verdict = merge("UNEXPECTED PASS", "FAILED         ", unittest%should_fail)
      else
         verdict = merge("EXPECTED FAIL", "PASSED       ", unittest%should_fail)
      end if
      if (is_skip(error)) verdict = "SKIPPED"
      if (verdict == "FAILED" .or. verdict == "UNEXPECTED PASS") stat = stat + 1
      write (unit, '("       ... ",a," [",a,"]")') unittest%name, trim(verdict)
      if (allocated(error)) write (unit, '("  Message: ",a)') error%message
   end subroutine run_test

   logical function is_skip(error)
      type(error_type), intent(in), optional :: error
      is_skip = .false.
      if (present(error)) is_skip = error%stat == skipped
   end function is_skip

   subroutine check_true(error, expression, message, more)
      type(error_type), allocatable, intent(out) :: error
      logical, intent(in) :: expression
      character(len=*), intent(in), optional :: message, more
      if (.not. expression) call fail_with(error, "the condition is false", message, more)
   end subroutine check_true

   subroutine check_logical(error, actual, expected, message, more)
      type(error_type), allocatable, intent(out) :: error
      logical, intent(in) :: actual, expected
      character(len=*), intent(in), optional :: message, more
      if (actual .eqv. expected) return
      call fail_with(error, "expected "//merge("true ", "false", expected), message, more)
   end subroutine check_logical

   subroutine check_integer(error, actual, expected, message, more)
      type(error_type), allocatable, intent(out) :: error
      integer, intent(in) :: actual, expected
      character(len=*), intent(in), optional :: message, more
      character(len=64) :: text
      if (actual == expected) return
      write (text, '("expected ",i0,", got ",i0)') expected, actual
      call fail_with(error, trim(text), message, more)
   end subroutine check_integer

   !> `thr` is the allowed difference, of the expected value's size if `rel`; by default round-off. A NaN fails.
   subroutine check_real(error, actual, expected, message, more, thr, rel)
      type(error_type), allocatable, intent(out) :: error
      real(real64), intent(in) :: actual, expected
      character(len=*), intent(in), optional :: message, more
      real(real64), intent(in), optional :: thr
      logical, intent(in), optional :: rel
      character(len=80) :: text
      real(real64) :: bound
      bound = epsilon(bound)
      if (present(thr)) bound = thr
      if (present(rel)) then
         if (rel) bound = bound*abs(expected)
      end if
      if (abs(actual - expected) <= bound) return
      write (text, '("expected ",es24.16,", got ",es24.16)') expected, actual
      call fail_with(error, trim(text), message, more)
   end subroutine check_real

   subroutine check_character(error, actual, expected, message, more)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), intent(in) :: actual, expected
      character(len=*), intent(in), optional :: message, more
      if (actual == expected) return
      call fail_with(error, "expected '"//expected//"', got '"//actual//"'", message, more)
   end subroutine check_character

   !> The caller's message, where there is one, stands in the place of the general one.
   subroutine fail_with(error, general, message, more)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), intent(in) :: general
      character(len=*), intent(in), optional :: message, more
      if (present(message)) then
         call test_failed(error, message, more)
      else
         call test_failed(error, general, more)
      end if
   end subroutine fail_with

   !> Marks the test as failed; `more` and `and_more` are further lines of the message.
   subroutine test_failed(error, message, more, and_more)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), intent(in) :: message
      character(len=*), intent(in), optional :: more, and_more
      character(len=*), parameter :: next = new_line("a")//"           "
      allocate (error)
      error%stat = failure
      error%message = message
      if (present(more)) error%message = error%message//next//more
      if (present(and_more)) error%message = error%message//next//and_more
   end subroutine test_failed

   !> Marks the test as not run here.
   subroutine skip_test(error, message, more, and_more)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), intent(in) :: message
      character(len=*), intent(in), optional :: more, and_more
      call test_failed(error, message, more, and_more)
      error%stat = skipped
   end subroutine skip_test

   !> Command line argument number `idx`; not allocated when there is none.
   subroutine get_argument(idx, arg)
      integer, intent(in) :: idx
      character(len=:), allocatable, intent(out) :: arg
      integer :: length, stat
      call get_command_argument(idx, length=length, status=stat)
      if (stat /= 0) return
      allocate (character(len=length) :: arg)
      if (length > 0) call get_command_argument(idx, arg)
   end subroutine get_argument

end module testdrive
