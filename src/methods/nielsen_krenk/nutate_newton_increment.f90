!> Tests if an iteration has reached its root, or all of it that round-off leaves.
module nutate_newton_increment
   use nutate_kinds, only: wp, eps
   implicit none
   private

   public :: increment_t, has_converged, most_cancellation, usual_cancellation

   !> Relative increment that is round-off of the residual: of a sum and a product.
   real(wp), parameter :: round_off = 2*eps
   !> Relative increment below which an iteration that no longer falls has reached round-off, of sums whose terms may be
   !> so many times the result.
   real(wp), parameter :: usual_cancellation = 1e4_wp
   !> Factor between terms and result above which the root of a needle has lost so many digits of the rotation about it
   !> that its energy is no longer kept to round-off.
   real(wp), parameter :: most_cancellation = 1e6_wp

   !> Size of a Newton increment, and reasons to end the iteration.
   type :: increment_t
      !> Largest entry of the increment, and of the unknowns.
      real(wp) :: size = huge(1.0_wp), length = 0.0_wp
      !> Largest entry of the part of the increment that is the attitude's, rad of half the turn.
      real(wp) :: attitude = 0.0_wp
      !> The unknowns left all bounds.
      logical :: diverged = .false.
      !> A bound says that no further increment would change anything.
      logical :: is_last = .false.
   end type increment_t

contains

   !> True if a further increment would change nothing: the present one is below the tolerance, or, by default, so far
   !> down at round-off that even at the slowest rate the next is below it, or the increments stopped falling at that
   !> level. How fast they fell so far says nothing of those in directions not yet seen: trusting it makes energy drift.
   pure logical function has_converged(increment, previous, tolerance, cancellation)
      type(increment_t), intent(in) :: increment
      !> Largest entry of the previous increment.
      real(wp), intent(in) :: previous
      !> 0: until the increment stops falling.
      real(wp), intent(in) :: tolerance
      !> How many times the result terms of the equations can be.
      real(wp), intent(in) :: cancellation
      associate (size => increment%size, length => increment%length)
         if (tolerance > 0.0_wp) then
            has_converged = size <= tolerance*length
         else
            has_converged = size <= round_off*length .or. (size > 0.5_wp*previous .and. size <= cancellation*eps*length)
         end if
      end associate
   end function has_converged

end module nutate_newton_increment
