!> Suites of ensembles, of what C and FORTRAN 77 call, and of exchange with other programs.
module suites_of_interfaces
   use test_c_bodies, only: collect_c_bodies
   use test_c_events, only: collect_c_events
   use test_c_exchange, only: collect_c_exchange
   use test_c_interface, only: collect_c_interface
   use test_c_runs, only: collect_c_runs
   use test_c_satellites, only: collect_c_satellites
   use test_c_sweep, only: collect_c_sweep
   use test_ensemble, only: collect_ensemble
   use test_exchange, only: collect_exchange
   use test_f77, only: collect_f77
   use test_f77_arguments, only: collect_f77_arguments
   use test_f77_bodies, only: collect_f77_bodies
   use test_f77_helpers, only: collect_f77_helpers
   use test_f77_prepared, only: collect_f77_prepared
   use test_random, only: collect_random
   use test_sweep, only: collect_sweep
   use testdrive, only: new_testsuite, testsuite_type
   implicit none
   private

   public :: interface_suites

contains

   !> The suites, by name.
   function interface_suites() result(suites)
      type(testsuite_type), allocatable :: suites(:)
      suites = [ &
         new_testsuite("ensemble", collect_ensemble), &
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
