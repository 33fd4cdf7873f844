!> The C interface: many bodies (`test_c_bodies.c`).
module test_c_bodies
   use test_c_support, only: c_test, check_line
   use test_support, only: error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_c_bodies

   procedure(c_test), bind(C, name='test_c_bodies_steps') :: test_c_bodies_steps
   procedure(c_test), bind(C, name='test_c_bodies_failures') :: test_c_bodies_failures
   procedure(c_test), bind(C, name='test_c_bodies_refused') :: test_c_bodies_refused

contains

   subroutine collect_c_bodies(testsuite)
      type(unittest_type), allocatable, intent(out) :: testsuite(:)
      testsuite = [ &
                  new_unittest("a step is a kick and a drift", steps), &
                  new_unittest("bodies that fail are listed", failures), &
                  new_unittest("wrong arguments are refused", refused)]
   end subroutine collect_c_bodies

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

end module test_c_bodies
