!> The C interface: many bodies (`test_c_bodies.c`).
module test_c_bodies
   use, intrinsic :: iso_c_binding, only: c_int
   use test_support, only: check, error_type, new_unittest, unittest_type
   implicit none
   private

   public :: collect_c_bodies

   abstract interface
      !> A test in C: 0, or the line of the first check that fails.
      integer(c_int) function c_test() bind(C)
         import :: c_int
      end function c_test
   end interface

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
      call judge(error, test_c_bodies_steps())
   end subroutine steps

   subroutine failures(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_bodies_failures())
   end subroutine failures

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      call judge(error, test_c_bodies_refused())
   end subroutine refused

   subroutine judge(error, line)
      type(error_type), allocatable, intent(inout) :: error
      integer(c_int), intent(in) :: line
      character(len=24) :: place
      write (place, '(i0)') line
      call check(error, line == 0, 'test/test_c_bodies.c, line '//trim(place))
   end subroutine judge

end module test_c_bodies
