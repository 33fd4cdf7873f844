!> The C interface: members of ensembles (`test_c_sweep.c`).
submodule(suites_of_interfaces) test_c_sweep
   use test_c_support, only: c_test, check_line
   use test_support, only: error_type, new_unittest
   implicit none

   procedure(c_test), bind(C, name='test_c_sweep_rows') :: test_c_sweep_rows
   procedure(c_test), bind(C, name='test_c_sweep_table') :: test_c_sweep_table
   procedure(c_test), bind(C, name='test_c_sweep_refused') :: test_c_sweep_refused
   procedure(c_test), bind(C, name='test_c_sweep_callbacks') :: test_c_sweep_callbacks
   procedure(c_test), bind(C, name='test_c_sweep_stopped') :: test_c_sweep_stopped

contains

   module procedure collect_c_sweep
      testsuite = [ &
                  new_unittest("rows are those of scenes by hand, whoever runs them", rows), &
                  new_unittest("a table makes an ensemble of a scene", table), &
                  new_unittest("members, threads and tables that are none are refused", refused), &
                  new_unittest("callbacks act on every member, and fail in their rows", callbacks), &
                  new_unittest("the poll of a scene ends a sweep", stopped)]
   end procedure collect_c_sweep

   subroutine rows(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_sweep_rows(), 'test_c_sweep.c')
   end subroutine rows

   subroutine table(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_sweep_table(), 'test_c_sweep.c')
   end subroutine table

   subroutine refused(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_sweep_refused(), 'test_c_sweep.c')
   end subroutine refused

   subroutine callbacks(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_sweep_callbacks(), 'test_c_sweep.c')
   end subroutine callbacks

   subroutine stopped(error)
      type(error_type), allocatable, intent(out) :: error
      call check_line(error, test_c_sweep_stopped(), 'test_c_sweep.c')
   end subroutine stopped

end submodule test_c_sweep
