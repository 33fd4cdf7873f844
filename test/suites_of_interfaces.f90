!> Suites of ensembles, of what C and FORTRAN 77 call, and of exchange with other programs.
module suites_of_interfaces
   use testdrive, only: new_testsuite, testsuite_type, unittest_type
   implicit none
   private

   public :: interface_suites

   interface
      module subroutine collect_c_bodies(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_c_bodies
      module subroutine collect_c_events(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_c_events
      module subroutine collect_c_exchange(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_c_exchange
      module subroutine collect_c_interface(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_c_interface
      module subroutine collect_c_runs(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_c_runs
      module subroutine collect_c_satellites(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_c_satellites
      module subroutine collect_c_sweep(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_c_sweep
      module subroutine collect_ensemble(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_ensemble
      module subroutine collect_tops(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_tops
      module subroutine collect_exchange(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_exchange
      module subroutine collect_f77(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_f77
      module subroutine collect_f77_arguments(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_f77_arguments
      module subroutine collect_f77_bodies(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_f77_bodies
      module subroutine collect_f77_helpers(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_f77_helpers
      module subroutine collect_f77_prepared(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_f77_prepared
      module subroutine collect_random(testsuite)
         type(unittest_type), allocatable, intent(out) :: testsuite(:)
      end subroutine collect_random
   end interface

contains

   !> The suites, by name.
   function interface_suites() result(suites)
      use test_sweep, only: collect_sweep
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("ensemble", collect_ensemble), &
         new_testsuite("tops", collect_tops), &
         new_testsuite("random", collect_random), &
         new_testsuite("sweep", collect_sweep), &
         new_testsuite("c_bodies", collect_c_bodies), &
         new_testsuite("c_events", collect_c_events), &
         new_testsuite("c_interface", collect_c_interface), &
         new_testsuite("c_runs", collect_c_runs), &
         new_testsuite("exchange", collect_exchange), &
         new_testsuite("c_exchange", collect_c_exchange), &
         new_testsuite("c_satellites", collect_c_satellites), &
         new_testsuite("c_sweep", collect_c_sweep), &
         new_testsuite("f77", collect_f77), &
         new_testsuite("f77_arguments", collect_f77_arguments), &
         new_testsuite("f77_bodies", collect_f77_bodies), &
         new_testsuite("f77_prepared", collect_f77_prepared), &
         new_testsuite("f77_helpers", collect_f77_helpers)]
   end function interface_suites

end module suites_of_interfaces
