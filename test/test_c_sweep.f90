!> The C interface: members of ensembles (`test_c_sweep.c`).
module test_c_sweep
   use, intrinsic :: iso_c_binding, only: c_int
   use test_support, only: check, error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_c_sweep

   abstract interface
      !> A test in C: 0, or the line of the first check that fails.
      integer(c_int) function c_test() bind(C)
         import :: c_int
      end function c_test
   end interface

   procedure(c_test), bind(C, name='test_c_sweep_rows') :: test_c_sweep_rows
   procedure(c_test), bind(C, name='test_c_sweep_table') :: test_c_sweep_table
   procedure(c_test), bind(C, name='test_c_sweep_refused') :: test_c_sweep_refused
   procedure(c_test), bind(C, name='test_c_sweep_callbacks') :: test_c_sweep_callbacks
   procedure(c_test), bind(C, name='test_c_sweep_stopped') :: test_c_sweep_stopped

contains

   subroutine collect_c_sweep(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("rows are those of scenes by hand, whoever runs them", rows), &
                  new_unittest("a table makes an ensemble of a scene", table), &
                  new_unittest("members, threads and tables that are none are refused", refused), &
                  new_unittest("callbacks act on every member, and fail in their rows", callbacks), &
                  new_unittest("the poll of a scene ends a sweep", stopped)]
   end subroutine collect_c_sweep

   subroutine rows(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_sweep_rows())
   end subroutine rows

   subroutine table(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_sweep_table())
   end subroutine table

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_sweep_refused())
   end subroutine refused

   subroutine callbacks(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_sweep_callbacks())
   end subroutine callbacks

   subroutine stopped(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_sweep_stopped())
   end subroutine stopped

   subroutine judge(error, line)
      type(error_type), allocatable, intent(inout) :: error
      integer(c_int), intent(in) :: line
      character(len=24) :: place
      write (place, '(i0)') line
      call check(error, line == 0, 'test/test_c_sweep.c, line '//trim(place))
   end subroutine judge

end module test_c_sweep
