!> Tests that are written in C, called from Fortran.
module test_c_support
   use, intrinsic :: iso_c_binding, only: c_funptr, c_int, c_ptr
   use test_support, only: check, error_type
   implicit none
   private

   public :: c_test, check_line, run_threads

   abstract interface
      !> A test in C: 0, or the line of the first check that fails.
      integer(c_int) function c_test() bind(C)
         import :: c_int
      end function c_test
   end interface

   interface
      !> Calls `work` from several threads simultaneously; the number of threads that could not be started.
      integer(c_int) function run_threads(work, context, threads) bind(C, name='test_run_threads')
         import :: c_funptr, c_int, c_ptr
         type(c_funptr), intent(in), value :: work
         type(c_ptr), intent(in), value :: context
         integer(c_int), intent(in), value :: threads
      end function run_threads
   end interface

contains

   !> Checks what a test in C returned.
   subroutine check_line(error, line, file)
      type(error_type), allocatable, intent(inout) :: error
      integer(c_int), intent(in) :: line
      !> The source of the test, in test/.
      character(len=*), intent(in) :: file
      character(len=24) :: place
      write (place, '(i0)') line
      call check(error, line == 0, 'test/'//file//', line '//trim(place))
   end subroutine check_line

end module test_c_support
