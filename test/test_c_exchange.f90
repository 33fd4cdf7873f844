!> The C interface: calendar time, and attitudes for other programs (`test_c_exchange.c`).
module test_c_exchange
   use, intrinsic :: iso_c_binding, only: c_int
   use test_support, only: check, error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_c_exchange

   abstract interface
      !> A test in C: 0, or the line of the first check that fails.
      integer(c_int) function c_test() bind(C)
         import :: c_int
      end function c_test
   end interface

   procedure(c_test), bind(C, name='test_c_exchange_calendar') :: test_c_exchange_calendar
   procedure(c_test), bind(C, name='test_c_exchange_files') :: test_c_exchange_files
   procedure(c_test), bind(C, name='test_c_exchange_refused') :: test_c_exchange_refused

contains

   subroutine collect_c_exchange(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("dates, TDB and the names of a scene", calendar), &
                  new_unittest("what is written as AEM is read back", files), &
                  new_unittest("what cannot be is refused", refused)]
   end subroutine collect_c_exchange

   subroutine calendar(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_exchange_calendar())
   end subroutine calendar

   subroutine files(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_exchange_files())
   end subroutine files

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_exchange_refused())
   end subroutine refused

   subroutine judge(error, line)
      type(error_type), allocatable, intent(inout) :: error
      integer(c_int), intent(in) :: line
      character(len=24) :: place
      write (place, '(i0)') line
      call check(error, line == 0, 'test/test_c_exchange.c, line '//trim(place))
   end subroutine judge

end module test_c_exchange
