!> The C interface: events and tables of programs (`test_c_events.c`).
module test_c_events
   use, intrinsic :: iso_c_binding, only: c_int
   use test_support, only: check, error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_c_events

   abstract interface
      !> A test in C: 0, or the line of the first check that fails.
      integer(c_int) function c_test() bind(C)
         import :: c_int
      end function c_test
   end interface

   procedure(c_test), bind(C, name='test_c_events_found') :: test_c_events_found
   procedure(c_test), bind(C, name='test_c_events_stop') :: test_c_events_stop
   procedure(c_test), bind(C, name='test_c_events_switch') :: test_c_events_switch
   procedure(c_test), bind(C, name='test_c_events_restart') :: test_c_events_restart
   procedure(c_test), bind(C, name='test_c_events_refused') :: test_c_events_refused
   procedure(c_test), bind(C, name='test_c_table') :: test_c_table

contains

   subroutine collect_c_events(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("events by columns and by functions of a program are found", events_found), &
                  new_unittest("a run ends at an event, and the next one goes on behind it", events_stop), &
                  new_unittest("what an event switches stays switched", events_switch), &
                  new_unittest("put into another stepper, runs with events go on to the same bits", events_restart), &
                  new_unittest("events that are none, and functions that fail, are refused", events_refused), &
                  new_unittest("a table in memory", table)]
   end subroutine collect_c_events

   subroutine events_found(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_events_found())
   end subroutine events_found

   subroutine events_stop(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_events_stop())
   end subroutine events_stop

   subroutine events_switch(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_events_switch())
   end subroutine events_switch

   subroutine events_restart(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_events_restart())
   end subroutine events_restart

   subroutine events_refused(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_events_refused())
   end subroutine events_refused

   subroutine table(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_table())
   end subroutine table

   subroutine judge(error, line)
      type(error_type), allocatable, intent(inout) :: error
      integer(c_int), intent(in) :: line
      character(len=24) :: place
      write (place, '(i0)') line
      call check(error, line == 0, 'test/test_c_events.c, line '//trim(place))
   end subroutine judge

end module test_c_events
