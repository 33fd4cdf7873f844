!> What the Newton iterations of the steppers share: when to stop, when the Jacobian is too old, and the first guess.
module nutate_newton
   use nutate_kinds, only: wp, eps
   implicit none
   private

   public :: degree, too_slow, attitude_noise, patience, has_converged, remember, continue_steps

   !> The first guess continues the increments of earlier steps by a polynomial of this degree.
   integer, parameter :: degree = 3
   !> Increments that fall by less than this per iteration call for a new Jacobian.
   real(wp), parameter :: too_slow = 0.1_wp
   !> Relative increment that is round-off of the residual.
   real(wp), parameter :: round_off = 2*eps
   !> Relative increment below which an iteration that no longer falls has reached round-off.
   real(wp), parameter :: floor_level = 1e4_wp*eps
   !> A force that varies steeply with the attitude is as uncertain as the attitude's own round-off makes it, however
   !> short the step: increments of the attitude (rad) at this level that failed to fall so many times are that noise.
   real(wp), parameter :: attitude_noise = 16*eps
   integer, parameter :: patience = 3

contains

   !> True if a further increment would change nothing: the present one is below the tolerance, or, by default, so far
   !> down at round-off that even at the slowest rate the next is below it, or the increments stopped falling at that
   !> level. How fast they fell so far says nothing of those in directions not yet seen: trusting it makes energy drift.
   pure logical function has_converged(change, previous, length, tolerance)
      !> Largest entry of the present and of the previous increment, and of the unknowns.
      real(wp), intent(in) :: change, previous, length
      !> 0: until the increment stops falling.
      real(wp), intent(in) :: tolerance
      if (tolerance > 0.0_wp) then
         has_converged = change <= tolerance*length
      else
         has_converged = change <= round_off*length .or. (change > 0.5_wp*previous .and. change <= floor_level*length)
      end if
   end function has_converged

   !> Puts the unknowns of a step and their backward differences in place of the last step's.
   pure subroutine remember(n, z, differences, known)
      !> Number of unknowns.
      integer, intent(in) :: n
      !> Unknowns of the step just done; shape (n).
      real(wp), intent(in) :: z(n)
      !> z and its backward differences of order 1 to `degree`; shape (n, 0:degree).
      real(wp), intent(inout) :: differences(n, 0:degree)
      !> How many of the columns are known.
      integer, intent(inout) :: known
      real(wp) :: new, old
      integer :: i, k
      known = min(known + 1, degree + 1)
      do i = 1, n
         new = z(i)
         do k = 0, known - 1
            old = differences(i, k)
            differences(i, k) = new
            new = new - old
         end do
      end do
   end subroutine remember

   !> The guess for the next step: the polynomial through the last ones, which is the sum of the differences.
   pure subroutine continue_steps(n, differences, known, z)
      !> Number of unknowns.
      integer, intent(in) :: n
      !> From `remember`; shape (n, 0:degree).
      real(wp), intent(in) :: differences(n, 0:degree)
      !> How many of the columns are known, at least 1.
      integer, intent(in) :: known
      !> Shape (n).
      real(wp), intent(out) :: z(n)
      integer :: k
      z = differences(:, 0)
      do k = 1, known - 1
         z = z + differences(:, k)
      end do
   end subroutine continue_steps

end module nutate_newton
