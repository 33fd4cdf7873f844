!> The C interface: events and tables of programs (`test_c_events.c`).
submodule(suites_of_interfaces) test_c_events
   use test_c_support, only: c_test, check_line
   use test_support, only: error_type, new_unittest
   implicit none

   procedure(c_test), bind(C, name='test_c_events_found') :: test_c_events_found
   procedure(c_test), bind(C, name='test_c_events_stop') :: test_c_events_stop
   procedure(c_test), bind(C, name='test_c_events_switch') :: test_c_events_switch
   procedure(c_test), bind(C, name='test_c_events_restart') :: test_c_events_restart
   procedure(c_test), bind(C, name='test_c_events_refused') :: test_c_events_refused
   procedure(c_test), bind(C, name='test_c_table') :: test_c_table

contains

   module procedure collect_c_events
      testsuite = [ &
                  new_unittest("events by columns and by functions of a program are found", events_found), &
                  new_unittest("a run ends at an event, and the next one goes on behind it", events_stop), &
                  new_unittest("what an event switches stays switched", events_switch), &
                  new_unittest("put into another stepper, runs with events go on to the same bits", events_restart), &
                  new_unittest("events that are none, and functions that fail, are refused", events_refused), &
                  new_unittest("a table in memory", table)]
   end procedure collect_c_events

   subroutine events_found(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_events_found(), 'test_c_events.c')
   end subroutine events_found

   subroutine events_stop(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_events_stop(), 'test_c_events.c')
   end subroutine events_stop

   subroutine events_switch(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_events_switch(), 'test_c_events.c')
   end subroutine events_switch

   subroutine events_restart(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_events_restart(), 'test_c_events.c')
   end subroutine events_restart

   subroutine events_refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_events_refused(), 'test_c_events.c')
   end subroutine events_refused

   subroutine table(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_table(), 'test_c_events.c')
   end subroutine table

end submodule test_c_events
