!> The modified Newton iteration of a step in reduced form (`nutate_reduced`), several bodies at once: one body a lane,
!> as in `nutate_lane_step`.
module nutate_lane_newton
   use nutate_implicit_step, only: attitude_noise, most_stalls, too_slow
   use nutate_kinds, only: wp, eps
   use nutate_lane_step, only: find_largest
   use nutate_lane_width, only: lanes
   use nutate_newton_increment, only: round_off, usual_cancellation
   use nutate_reduced, only: coarse, curvature
   implicit none
   private

   public :: iteration_t, take_residuals, invert_lanes, correct_lanes

   !> Determinants below are not divided by.
   real(wp), parameter :: least_determinant = 1e-12_wp

   !> Where the iteration of each lane is.
   type :: iteration_t
      !> Unknowns b, and F of them; shape (lanes, 3).
      real(wp) :: z(lanes, 3), f(lanes, 3)
      !> L̄, L̄ - L0; shape (lanes, 3). 1-β.
      real(wp) :: mean(lanes, 3), change(lanes, 3), rest(lanes)
      !> Rows of the inverse of ∂F/∂b, shape (lanes, 3, row), and its determinant.
      real(wp) :: rows(lanes, 3, 3), determinant(lanes)
      !> The last increment, and the way since the Jacobian was taken.
      real(wp) :: size(lanes) = huge(1.0_wp), moved(lanes) = 0.0_wp
      !> Increments of noise that failed to fall; 1: the lane has its root.
      real(wp) :: stalls(lanes) = 0.0_wp, done(lanes) = 0.0_wp
      integer :: count(lanes) = 0
   end type iteration_t

contains

   !> F(z) = (1-β)(L̄ - L0) + 2b×L̄, and what the Jacobian is made of.
   pure subroutine take_residuals(inertia, momentum, rotor, z, mean, change, rest, f)
      !> J/s; shape (lanes, 3, 3). L0 and the momentum of rotors, in the units of the step; shape (lanes, 3).
      real(wp), intent(in) :: inertia(lanes, 3, 3), momentum(lanes, 3), rotor(lanes, 3), z(lanes, 3)
      !> L̄, L̄ - L0; shape (lanes, 3). 1-β.
      real(wp), intent(out) :: mean(lanes, 3), change(lanes, 3), rest(lanes), f(lanes, 3)
      real(wp) :: m1, m2, m3, b1, b2, b3
      integer :: i
      do i = 1, lanes
         b1 = z(i, 1)
         b2 = z(i, 2)
         b3 = z(i, 3)
         m1 = inertia(i, 1, 1)*b1 + inertia(i, 1, 2)*b2 + inertia(i, 1, 3)*b3 + rotor(i, 1)
         m2 = inertia(i, 2, 1)*b1 + inertia(i, 2, 2)*b2 + inertia(i, 2, 3)*b3 + rotor(i, 2)
         m3 = inertia(i, 3, 1)*b1 + inertia(i, 3, 2)*b2 + inertia(i, 3, 3)*b3 + rotor(i, 3)
         mean(i, 1) = m1
         mean(i, 2) = m2
         mean(i, 3) = m3
         change(i, 1) = m1 - momentum(i, 1)
         change(i, 2) = m2 - momentum(i, 2)
         change(i, 3) = m3 - momentum(i, 3)
         rest(i) = 1 - (b1*b1 + b2*b2 + b3*b3)
         f(i, 1) = rest(i)*change(i, 1) + 2*(b2*m3 - b3*m2)
         f(i, 2) = rest(i)*change(i, 2) + 2*(b3*m1 - b1*m3)
         f(i, 3) = rest(i)*change(i, 3) + 2*(b1*m2 - b2*m1)
      end do
   end subroutine take_residuals

   !> Rows of the inverse of ∂F/∂b and its determinant, in the lanes whose last increment was coarse; lanes without an
   !> inverse are given up.
   pure subroutine invert_lanes(inertia, by_forces, z, mean, change, rest, size, rows, determinant, moved, given_up)
      real(wp), intent(in) :: inertia(lanes, 3, 3), z(lanes, 3), mean(lanes, 3), change(lanes, 3), rest(lanes)
      !> What potentials add to ∂F/∂b; shape (lanes, 3, 3).
      real(wp), intent(in) :: by_forces(lanes, 3, 3)
      !> Of the last increment.
      real(wp), intent(in) :: size(lanes)
      !> Shape (lanes, 3, row).
      real(wp), intent(inout) :: rows(lanes, 3, 3)
      !> Determinant, and the way since it was taken.
      real(wp), intent(inout) :: determinant(lanes), moved(lanes), given_up(lanes)
      real(wp) :: m(lanes, 3, 3), r(lanes, 3, 3), det(lanes), divisor(lanes)
      integer :: i, j, k
      call find_jacobian(inertia, by_forces, z, mean, change, rest, m)
      call cross_columns(m, 2, 3, r(:, :, 1))
      call cross_columns(m, 3, 1, r(:, :, 2))
      call cross_columns(m, 1, 2, r(:, :, 3))
      do i = 1, lanes
         det(i) = r(i, 1, 1)*m(i, 1, 1) + r(i, 2, 1)*m(i, 2, 1) + r(i, 3, 1)*m(i, 3, 1)
      end do
      do i = 1, lanes
         divisor(i) = merge(det(i), 1.0_wp, det(i) > least_determinant)
      end do
      do i = 1, lanes
         divisor(i) = 1/divisor(i)
      end do
      if (minval(size) > coarse) then
         determinant = det
         moved = 0.0_wp
         do k = 1, 3
            call scale_lanes(divisor, r(:, :, k), rows(:, :, k))
         end do
      else
         call choose_lanes(size, det, determinant)
         det = 0.0_wp
         call choose_lanes(size, det, moved)
         do k = 1, 3
            call scale_lanes(divisor, r(:, :, k), m(:, :, k))
            do j = 1, 3
               call choose_lanes(size, m(:, j, k), rows(:, j, k))
            end do
         end do
      end if
      do i = 1, lanes
         given_up(i) = merge(given_up(i), 1.0_wp, determinant(i) > least_determinant)
      end do
   end subroutine invert_lanes

   !> ∂F/∂b.
   pure subroutine find_jacobian(inertia, by_forces, z, mean, change, rest, m)
      !> As `invert_lanes` has them.
      real(wp), intent(in) :: inertia(lanes, 3, 3), by_forces(lanes, 3, 3), z(lanes, 3)
      real(wp), intent(in) :: mean(lanes, 3), change(lanes, 3), rest(lanes)
      !> Shape (lanes, 3, 3).
      real(wp), intent(out) :: m(lanes, 3, 3)
      real(wp) :: across1, across2, across3
      integer :: i, j
      do j = 1, 3
         do i = 1, lanes
            across1 = z(i, 2)*inertia(i, 3, j) - z(i, 3)*inertia(i, 2, j)
            across2 = z(i, 3)*inertia(i, 1, j) - z(i, 1)*inertia(i, 3, j)
            across3 = z(i, 1)*inertia(i, 2, j) - z(i, 2)*inertia(i, 1, j)
            m(i, 1, j) = by_forces(i, 1, j) + (rest(i)*inertia(i, 1, j) + 2*(across1 - z(i, j)*change(i, 1)))
            m(i, 2, j) = by_forces(i, 2, j) + (rest(i)*inertia(i, 2, j) + 2*(across2 - z(i, j)*change(i, 2)))
            m(i, 3, j) = by_forces(i, 3, j) + (rest(i)*inertia(i, 3, j) + 2*(across3 - z(i, j)*change(i, 3)))
         end do
      end do
      do i = 1, lanes
         m(i, 2, 1) = m(i, 2, 1) - 2*mean(i, 3)
         m(i, 3, 1) = m(i, 3, 1) + 2*mean(i, 2)
         m(i, 1, 2) = m(i, 1, 2) + 2*mean(i, 3)
         m(i, 3, 2) = m(i, 3, 2) - 2*mean(i, 1)
         m(i, 1, 3) = m(i, 1, 3) - 2*mean(i, 2)
         m(i, 2, 3) = m(i, 2, 3) + 2*mean(i, 1)
      end do
   end subroutine find_jacobian

   !> Takes new numbers in the lanes whose last increment was coarse.
   pure subroutine choose_lanes(size, new, x)
      real(wp), intent(in) :: size(lanes), new(lanes)
      real(wp), intent(inout) :: x(lanes)
      real(wp) :: a, b
      integer :: i
      do i = 1, lanes
         a = new(i)
         b = x(i)
         x(i) = merge(a, b, size(i) > coarse)
      end do
   end subroutine choose_lanes

   pure subroutine scale_lanes(factor, x, scaled)
      !> Shapes (lanes) and (lanes, 3).
      real(wp), intent(in) :: factor(lanes), x(lanes, 3)
      real(wp), intent(out) :: scaled(lanes, 3)
      integer :: i, k
      do k = 1, 3
         do i = 1, lanes
            scaled(i, k) = factor(i)*x(i, k)
         end do
      end do
   end subroutine scale_lanes

   !> Cross products of two columns of each lane's matrix.
   pure subroutine cross_columns(m, a, b, c)
      real(wp), intent(in) :: m(lanes, 3, 3)
      integer, intent(in) :: a, b
      real(wp), intent(out) :: c(lanes, 3)
      integer :: i
      do i = 1, lanes
         c(i, 1) = m(i, 2, a)*m(i, 3, b) - m(i, 3, a)*m(i, 2, b)
         c(i, 2) = m(i, 3, a)*m(i, 1, b) - m(i, 1, a)*m(i, 3, b)
         c(i, 3) = m(i, 1, a)*m(i, 2, b) - m(i, 2, a)*m(i, 1, b)
      end do
   end subroutine cross_columns

   !> One increment in the lanes that are not done, and which are then. A lane that leaves the bounds of a step is given
   !> up.
   pure subroutine correct_lanes(is_cubic, at, kept, given_up)
      !> F is a cubic polynomial, of which the next increment is known beforehand.
      logical, intent(in) :: is_cubic
      type(iteration_t), intent(inout) :: at
      !> 1: what potentials add to the Jacobian is worth keeping; 1: the lane is given up.
      real(wp), intent(inout) :: kept(lanes), given_up(lanes)
      real(wp) :: d(lanes, 3), last(lanes), length(lanes), going(lanes), slow(lanes)
      integer :: k
      do k = 1, 3
         call correct_component(at%rows(:, :, k), at%f, at%done, d(:, k), at%z(:, k))
      end do
      call find_largest(d, last)
      call find_largest(at%z, length)
      call find_unconverged(last, length, at%size, at%done, going, slow)
      if (is_cubic) call stop_by_bound(last, length, at%determinant, at%moved, going, slow)
      if (maxval(slow) > 0.5_wp) call judge_slow(last, length, at%size, slow, going, at%stalls, kept)
      call note_increments(last, going, at%size, at%done)
      if (maxval(length) > 1.0_wp) call give_up_far(length, at, given_up)
   end subroutine correct_lanes

   !> 1: the increment of a lane is not yet at round-off, and: it falls slowly.
   pure subroutine find_unconverged(last, length, size, done, going, slow)
      !> Largest entry of the increment, of the unknowns, and of the increment before.
      real(wp), intent(in) :: last(lanes), length(lanes), size(lanes), done(lanes)
      real(wp), intent(out) :: going(lanes), slow(lanes)
      real(wp) :: tiny_of(lanes), tenth(lanes)
      integer :: i
      do i = 1, lanes
         tiny_of(i) = round_off*length(i)
         tenth(i) = too_slow*size(i)
      end do
      do i = 1, lanes
         going(i) = merge(1.0_wp, 0.0_wp, last(i) > tiny_of(i))
         slow(i) = merge(1.0_wp, 0.0_wp, last(i) > tenth(i))
      end do
      do i = 1, lanes
         slow(i) = (1 - done(i))*going(i)*slow(i)
      end do
   end subroutine find_unconverged

   !> A bound of the next increment, by the way since the Jacobian was taken, can end the iteration.
   pure subroutine stop_by_bound(last, length, determinant, moved, going, slow)
      real(wp), intent(in) :: last(lanes), length(lanes), determinant(lanes)
      real(wp), intent(inout) :: moved(lanes), going(lanes), slow(lanes)
      real(wp) :: next(lanes), least_of(lanes), more(lanes)
      integer :: i
      do i = 1, lanes
         moved(i) = moved(i) + last(i)
         next(i) = curvature*moved(i)*last(i)
         least_of(i) = (0.5_wp*eps)*length(i)*determinant(i)
      end do
      do i = 1, lanes
         more(i) = merge(1.0_wp, 0.0_wp, next(i) > least_of(i))
      end do
      do i = 1, lanes
         going(i) = going(i)*more(i)
         slow(i) = slow(i)*more(i)
      end do
   end subroutine stop_by_bound

   !> Lanes whose increments fall slowly: those at round-off are done, as are those with many that are noise; else the
   !> forces' part of the Jacobian is to be taken anew.
   pure subroutine judge_slow(last, length, size, slow, going, stalls, kept)
      real(wp), intent(in) :: last(lanes), length(lanes), size(lanes), slow(lanes)
      real(wp), intent(inout) :: going(lanes), stalls(lanes), kept(lanes)
      integer :: k
      do k = 1, lanes
         if (slow(k) < 0.5_wp) cycle
         if (last(k) > 0.5_wp*size(k)) then
            if (last(k) <= usual_cancellation*eps*length(k)) going(k) = 0.0_wp
            if (going(k) > 0.5_wp .and. last(k) <= attitude_noise) stalls(k) = stalls(k) + 1
         end if
         if (stalls(k) >= real(most_stalls, wp)) going(k) = 0.0_wp
         if (going(k) > 0.5_wp) kept(k) = 0.0_wp
      end do
   end subroutine judge_slow

   !> Which lanes are done.
   pure subroutine note_increments(last, going, size, done)
      real(wp), intent(in) :: last(lanes), going(lanes)
      real(wp), intent(inout) :: size(lanes), done(lanes)
      integer :: i
      do i = 1, lanes
         size(i) = (1 - done(i))*last(i) + done(i)*size(i)
         done(i) = 1 - (1 - done(i))*going(i)
      end do
   end subroutine note_increments

   !> Gives up the lanes whose unknowns belong to no step.
   pure subroutine give_up_far(length, at, given_up)
      real(wp), intent(in) :: length(lanes)
      type(iteration_t), intent(inout) :: at
      real(wp), intent(inout) :: given_up(lanes)
      integer :: k
      do k = 1, lanes
         if (length(k) <= 1.0_wp) cycle
         given_up(k) = 1.0_wp
         at%z(k, :) = 0.0_wp
         at%size(k) = 0.0_wp
         at%done(k) = 1.0_wp
      end do
   end subroutine give_up_far

   !> One component of the increment, taken in the lanes that are not done.
   pure subroutine correct_component(row, f, done, d, z)
      !> A row of the inverse, and F; shape (lanes, 3).
      real(wp), intent(in) :: row(lanes, 3), f(lanes, 3), done(lanes)
      real(wp), intent(out) :: d(lanes)
      real(wp), intent(inout) :: z(lanes)
      real(wp) :: moved(lanes), a, b
      integer :: i
      do i = 1, lanes
         d(i) = row(i, 1)*f(i, 1) + row(i, 2)*f(i, 2) + row(i, 3)*f(i, 3)
         moved(i) = z(i) - d(i)
      end do
      do i = 1, lanes
         a = moved(i)
         b = z(i)
         z(i) = merge(a, b, done(i) < 0.5_wp)
      end do
   end subroutine correct_component

end module nutate_lane_newton
