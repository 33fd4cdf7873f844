!> The C interface: frames, orbits, wheels and controllers (`test_c_satellites.c`).
submodule(suites_of_interfaces) test_c_satellites
   use test_c_support, only: c_test, check_line
   use test_support, only: error_type, new_unittest
   implicit none

   !> On failure 10 000 times the number of scene and method, 11 for the first of both, is added to the line.
   procedure(c_test), bind(C, name='test_c_satellites_batches') :: test_c_satellites_batches
   procedure(c_test), bind(C, name='test_c_satellites_by_functions') :: test_c_satellites_by_functions
   procedure(c_test), bind(C, name='test_c_satellites_motor') :: test_c_satellites_motor
   procedure(c_test), bind(C, name='test_c_satellites_reading') :: test_c_satellites_reading
   procedure(c_test), bind(C, name='test_c_satellites_rates') :: test_c_satellites_rates
   procedure(c_test), bind(C, name='test_c_satellites_refused') :: test_c_satellites_refused

contains

   module procedure collect_c_satellites
      testsuite = [ &
                  new_unittest("in batches, saved between them, runs have the bits of the whole", batches), &
                  new_unittest("what functions add is what groups add", by_functions), &
                  new_unittest("a program drives a wheel as a table does", motor), &
                  new_unittest("wheels, orbit, Jacobi integral and the work of time-dependent potentials", reading), &
                  new_unittest("torques, events and steppers have the absolute rate", rates), &
                  new_unittest("what cannot be is refused", refused)]
   end procedure collect_c_satellites

   subroutine batches(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_satellites_batches(), 'test_c_satellites.c')
   end subroutine batches

   subroutine by_functions(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_satellites_by_functions(), 'test_c_satellites.c')
   end subroutine by_functions

   subroutine motor(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_satellites_motor(), 'test_c_satellites.c')
   end subroutine motor

   subroutine reading(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_satellites_reading(), 'test_c_satellites.c')
   end subroutine reading

   subroutine rates(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_satellites_rates(), 'test_c_satellites.c')
   end subroutine rates

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_satellites_refused(), 'test_c_satellites.c')
   end subroutine refused

end submodule test_c_satellites
