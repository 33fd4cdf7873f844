!> The C interface: many bodies (`test_c_bodies.c`).
submodule(suites_of_interfaces) test_c_bodies
   use test_c_support, only: c_test, check_line
   use test_support, only: error_type, new_unittest
   implicit none

   procedure(c_test), bind(C, name='test_c_bodies_steps') :: test_c_bodies_steps
   procedure(c_test), bind(C, name='test_c_bodies_failures') :: test_c_bodies_failures
   procedure(c_test), bind(C, name='test_c_bodies_refused') :: test_c_bodies_refused

contains

   module procedure collect_c_bodies
      testsuite = [ &
                  new_unittest("a step is a kick and a drift", steps), &
                  new_unittest("bodies that fail are listed", failures), &
                  new_unittest("wrong arguments are refused", refused)]
   end procedure collect_c_bodies

   subroutine steps(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_bodies_steps(), 'test_c_bodies.c')
   end subroutine steps

   subroutine failures(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_bodies_failures(), 'test_c_bodies.c')
   end subroutine failures

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_bodies_refused(), 'test_c_bodies.c')
   end subroutine refused

end submodule test_c_bodies
