!> The C interface: calendar time, and attitudes for other programs (`test_c_exchange.c`).
submodule(suites_of_interfaces) test_c_exchange
   use test_c_support, only: c_test, check_line
   use test_support, only: error_type, new_unittest
   implicit none

   procedure(c_test), bind(C, name='test_c_exchange_calendar') :: test_c_exchange_calendar
   procedure(c_test), bind(C, name='test_c_exchange_axes') :: test_c_exchange_axes
   procedure(c_test), bind(C, name='test_c_exchange_files') :: test_c_exchange_files
   procedure(c_test), bind(C, name='test_c_exchange_refused') :: test_c_exchange_refused

contains

   module procedure collect_c_exchange
      testsuite = [ &
                  new_unittest("dates, TDB and the names of a scene", calendar), &
                  new_unittest("space axes have an attitude in inertial axes", axes), &
                  new_unittest("what is written as AEM is read back", files), &
                  new_unittest("what cannot be is refused", refused)]
   end procedure collect_c_exchange

   subroutine calendar(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_exchange_calendar(), 'test_c_exchange.c')
   end subroutine calendar

   subroutine axes(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_exchange_axes(), 'test_c_exchange.c')
   end subroutine axes

   subroutine files(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_exchange_files(), 'test_c_exchange.c')
   end subroutine files

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_exchange_refused(), 'test_c_exchange.c')
   end subroutine refused

end submodule test_c_exchange
