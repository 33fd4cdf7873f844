!> Working precision and the mathematical constants that every layer uses.
module nutate_kinds
   use, intrinsic :: iso_fortran_env, only: int64, real64
   implicit none
   private

   public :: wp, long, pi, eps

   !> The one working precision of the library; in C and FORTRAN 77 it is `double`.
   integer, parameter :: wp = real64
   !> Counts of steps: 1e9 of them and more must not overflow.
   integer, parameter :: long = int64
   real(wp), parameter :: pi = 3.14159265358979323846264338327950288_wp
   !> ε: distance from 1 to the next number of `wp`. Round-off is quoted in it.
   real(wp), parameter :: eps = epsilon(1.0_wp)

end module nutate_kinds
