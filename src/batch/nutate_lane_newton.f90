!> The modified Newton iteration of a step in reduced form (`nutate_reduced`), several bodies at once: one body a lane,
!> as in `nutate_lane_step`.
module nutate_lane_newton
   use nutate_implicit_step, only: attitude_noise, most_stalls, too_slow
   use nutate_kinds, only: wp, eps, long
   use nutate_lane_choice, only: choose_lanes
   use nutate_lane_width, only: lanes
   use nutate_newton_increment, only: round_off, usual_cancellation
   use nutate_reduced, only: coarse, curvature
   implicit none
   private

   public :: iteration_t, take_residuals, correct_first, correct_again, begin_iteration

   !> Determinants below are not divided by.
   real(wp), parameter :: least_determinant = 1e-12_wp

   !> Where the iteration of each lane is. No component has a first value: they would be set at every step.
   type :: iteration_t
      !> Unknowns b, and F of them; shape (lanes, 3).
      real(wp) :: z(lanes, 3), f(lanes, 3)
      !> L̄, L̄ - L0; shape (lanes, 3). 1-β.
      real(wp) :: mean(lanes, 3), change(lanes, 3), rest(lanes)
      !> Rows of the inverse of ∂F/∂b, shape (lanes, 3, row), and its determinant.
      real(wp) :: rows(lanes, 3, 3), determinant(lanes)
      !> The last increment, the one before, the way since the Jacobian was taken, and the largest unknown.
      real(wp) :: size(lanes), before(lanes), moved(lanes), length(lanes)
      !> Increments of noise that failed to fall; 1: the lane has its root.
      real(wp) :: stalls(lanes), done(lanes)
      !> Some lane: is done; is not done; had a coarse increment.
      logical :: has_done, goes_on, is_coarse
      !> Some lane needs more iterations than one that is predicted well.
      logical :: is_late
   end type iteration_t

contains

   !> Before the first increment, which counts as coarse.
   pure subroutine begin_iteration(at)
      type(iteration_t), intent(inout) :: at
      at%size = huge(1.0_wp)
      at%stalls = 0.0_wp
      at%done = 0.0_wp
      at%has_done = .false.
      at%is_late = .false.
      at%goes_on = .true.
      at%is_coarse = .true.
   end subroutine begin_iteration

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

   !> Rows of the inverse of ∂F/∂b and its determinant, in the lanes whose last increment was coarse, or in all; lanes
   !> without an inverse are given up.
   pure subroutine invert_lanes(inertia, by_forces, all_of_them, at, given_up)
      !> J/s, and what potentials add to ∂F/∂b; shape (lanes, 3, 3).
      real(wp), intent(in) :: inertia(lanes, 3, 3), by_forces(lanes, 3, 3)
      logical, intent(in) :: all_of_them
      type(iteration_t), intent(inout) :: at
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: rows(lanes, 3, 3), determinant(lanes), renewed(lanes)
      integer :: i, j, k
      if (all_of_them) then
         call find_inverse(inertia, by_forces, at%z, at%mean, at%change, at%rest, at%rows, at%determinant, given_up)
         at%moved = 0.0_wp
      else
         call find_inverse(inertia, by_forces, at%z, at%mean, at%change, at%rest, rows, determinant, given_up)
         do i = 1, lanes
            renewed(i) = merge(1.0_wp, 0.0_wp, at%size(i) > coarse)
         end do
         call choose_lanes(renewed, determinant, at%determinant)
         determinant = 0.0_wp
         call choose_lanes(renewed, determinant, at%moved)
         do k = 1, 3
            do j = 1, 3
               call choose_lanes(renewed, rows(:, j, k), at%rows(:, j, k))
            end do
         end do
      end if
   end subroutine invert_lanes

   !> The inverse of ∂F/∂b, from its adjugate.
   pure subroutine find_inverse(inertia, by_forces, z, mean, change, rest, rows, determinant, given_up)
      !> As `invert_lanes` has them.
      real(wp), intent(in) :: inertia(lanes, 3, 3), by_forces(lanes, 3, 3), z(lanes, 3)
      real(wp), intent(in) :: mean(lanes, 3), change(lanes, 3), rest(lanes)
      !> Rows of the inverse; shape (lanes, 3, row).
      real(wp), intent(out) :: rows(lanes, 3, 3), determinant(lanes)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: m(3, 3), r1, r2, r3, det, divisor
      integer :: i
      do i = 1, lanes
         m(1, 1) = by_forces(i, 1, 1) + (rest(i)*inertia(i, 1, 1) + 2*((z(i, 2)*inertia(i, 3, 1) &
                   - z(i, 3)*inertia(i, 2, 1)) - z(i, 1)*change(i, 1)))
         m(2, 1) = by_forces(i, 2, 1) + (rest(i)*inertia(i, 2, 1) + 2*((z(i, 3)*inertia(i, 1, 1) &
                   - z(i, 1)*inertia(i, 3, 1)) - z(i, 1)*change(i, 2))) - 2*mean(i, 3)
         m(3, 1) = by_forces(i, 3, 1) + (rest(i)*inertia(i, 3, 1) + 2*((z(i, 1)*inertia(i, 2, 1) &
                   - z(i, 2)*inertia(i, 1, 1)) - z(i, 1)*change(i, 3))) + 2*mean(i, 2)
         m(1, 2) = by_forces(i, 1, 2) + (rest(i)*inertia(i, 1, 2) + 2*((z(i, 2)*inertia(i, 3, 2) &
                   - z(i, 3)*inertia(i, 2, 2)) - z(i, 2)*change(i, 1))) + 2*mean(i, 3)
         m(2, 2) = by_forces(i, 2, 2) + (rest(i)*inertia(i, 2, 2) + 2*((z(i, 3)*inertia(i, 1, 2) &
                   - z(i, 1)*inertia(i, 3, 2)) - z(i, 2)*change(i, 2)))
         m(3, 2) = by_forces(i, 3, 2) + (rest(i)*inertia(i, 3, 2) + 2*((z(i, 1)*inertia(i, 2, 2) &
                   - z(i, 2)*inertia(i, 1, 2)) - z(i, 2)*change(i, 3))) - 2*mean(i, 1)
         m(1, 3) = by_forces(i, 1, 3) + (rest(i)*inertia(i, 1, 3) + 2*((z(i, 2)*inertia(i, 3, 3) &
                   - z(i, 3)*inertia(i, 2, 3)) - z(i, 3)*change(i, 1))) - 2*mean(i, 2)
         m(2, 3) = by_forces(i, 2, 3) + (rest(i)*inertia(i, 2, 3) + 2*((z(i, 3)*inertia(i, 1, 3) &
                   - z(i, 1)*inertia(i, 3, 3)) - z(i, 3)*change(i, 2))) + 2*mean(i, 1)
         m(3, 3) = by_forces(i, 3, 3) + (rest(i)*inertia(i, 3, 3) + 2*((z(i, 1)*inertia(i, 2, 3) &
                   - z(i, 2)*inertia(i, 1, 3)) - z(i, 3)*change(i, 3)))
         r1 = m(2, 2)*m(3, 3) - m(3, 2)*m(2, 3)
         r2 = m(3, 2)*m(1, 3) - m(1, 2)*m(3, 3)
         r3 = m(1, 2)*m(2, 3) - m(2, 2)*m(1, 3)
         det = r1*m(1, 1) + r2*m(2, 1) + r3*m(3, 1)
         divisor = 1/max(det, least_determinant)
         given_up(i) = merge(given_up(i), 1.0_wp, det > least_determinant)
         determinant(i) = det
         rows(i, 1, 1) = divisor*r1
         rows(i, 2, 1) = divisor*r2
         rows(i, 3, 1) = divisor*r3
         rows(i, 1, 2) = divisor*(m(2, 3)*m(3, 1) - m(3, 3)*m(2, 1))
         rows(i, 2, 2) = divisor*(m(3, 3)*m(1, 1) - m(1, 3)*m(3, 1))
         rows(i, 3, 2) = divisor*(m(1, 3)*m(2, 1) - m(2, 3)*m(1, 1))
         rows(i, 1, 3) = divisor*(m(2, 1)*m(3, 2) - m(3, 1)*m(2, 2))
         rows(i, 2, 3) = divisor*(m(3, 1)*m(1, 2) - m(1, 1)*m(3, 2))
         rows(i, 3, 3) = divisor*(m(1, 1)*m(2, 2) - m(2, 1)*m(1, 2))
      end do
   end subroutine find_inverse

   !> The first increment of all lanes.
   pure subroutine correct_first(is_cubic, inertia, by_forces, at, given_up)
      !> F is a cubic polynomial, of which the next increment is known beforehand.
      logical, intent(in) :: is_cubic
      !> J/s, and what potentials add to ∂F/∂b; shape (lanes, 3, 3).
      real(wp), intent(in) :: inertia(lanes, 3, 3), by_forces(lanes, 3, 3)
      type(iteration_t), intent(inout) :: at
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      integer(long) :: open, ended, wide, far
      call invert_lanes(inertia, by_forces, .true., at, given_up)
      call take_first(merge(0.0_wp, 1.0_wp, is_cubic), at%rows, at%f, at%determinant, at%z, at%size, at%length, &
                      at%moved, at%done, open, ended, wide, far)
      at%goes_on = open /= 0
      at%has_done = ended /= 0
      at%is_coarse = wide /= 0
      if (far /= 0) call give_up_far(at, given_up)
   end subroutine correct_first

   pure subroutine take_first(unbounded, rows, f, determinant, z, size, length, moved, done, open, ended, wide, far)
      !> 0: a bound of the next increment can end the iteration.
      real(wp), intent(in) :: unbounded
      !> Shapes (lanes, 3, 3), (lanes, 3) and (lanes).
      real(wp), intent(in) :: rows(lanes, 3, 3), f(lanes, 3), determinant(lanes)
      real(wp), intent(inout) :: z(lanes, 3)
      real(wp), intent(out) :: size(lanes), length(lanes), moved(lanes), done(lanes)
      !> Lanes that are not done; that are; with a coarse increment; beyond the bounds of a step: 0, none.
      integer(long), intent(out) :: open, ended, wide, far
      real(wp) :: d1, d2, d3, last, longest, going, next, least, tiny_of
      integer :: i
      open = 0
      ended = 0
      wide = 0
      far = 0
      do i = 1, lanes
         d1 = rows(i, 1, 1)*f(i, 1) + rows(i, 2, 1)*f(i, 2) + rows(i, 3, 1)*f(i, 3)
         d2 = rows(i, 1, 2)*f(i, 1) + rows(i, 2, 2)*f(i, 2) + rows(i, 3, 2)*f(i, 3)
         d3 = rows(i, 1, 3)*f(i, 1) + rows(i, 2, 3)*f(i, 2) + rows(i, 3, 3)*f(i, 3)
         z(i, 1) = z(i, 1) - d1
         z(i, 2) = z(i, 2) - d2
         z(i, 3) = z(i, 3) - d3
         last = max(abs(d1), abs(d2), abs(d3))
         longest = max(abs(z(i, 1)), abs(z(i, 2)), abs(z(i, 3)))
         next = curvature*last*last
         least = (0.5_wp*eps)*longest*determinant(i)
         tiny_of = round_off*longest
         going = (0.5_wp - sign(0.5_wp, tiny_of - last))*max(0.5_wp - sign(0.5_wp, least - next), unbounded)
         size(i) = last
         moved(i) = last
         length(i) = longest
         done(i) = 1 - going
         open = ior(open, transfer(going, open))
         ended = ior(ended, transfer(done(i), ended))
         wide = ior(wide, transfer(0.5_wp - sign(0.5_wp, coarse - last), wide))
         far = ior(far, transfer(0.5_wp - sign(0.5_wp, 1 - longest), far))
      end do
   end subroutine take_first

   !> A further increment in the lanes that are not done, and which are then. A lane that leaves the bounds of a step is
   !> given up.
   pure subroutine correct_again(is_cubic, inertia, by_forces, at, kept, given_up)
      !> As `correct_first` has them.
      logical, intent(in) :: is_cubic
      real(wp), intent(in) :: inertia(lanes, 3, 3), by_forces(lanes, 3, 3)
      type(iteration_t), intent(inout) :: at
      !> 1: what potentials add to the Jacobian is worth keeping; 1: the lane is given up.
      real(wp), intent(inout) :: kept(lanes), given_up(lanes)
      real(wp) :: slow(lanes)
      integer(long) :: open, ended, wide, far, any_slow
      if (at%is_coarse) call invert_lanes(inertia, by_forces, .false., at, given_up)
      call take_next(merge(0.0_wp, 1.0_wp, is_cubic), at%rows, at%f, at%determinant, at%z, at%size, at%before, &
                     at%length, at%moved, at%done, slow, open, ended, wide, far, any_slow)
      at%goes_on = open /= 0
      at%has_done = ended /= 0
      at%is_coarse = wide /= 0
      if (any_slow /= 0) call judge_slow(slow, at, kept)
      if (far /= 0) call give_up_far(at, given_up)
   end subroutine correct_again

   pure subroutine take_next(unbounded, rows, f, determinant, z, size, before, length, moved, done, slow, open, &
                             ended, wide, far, any_slow)
      !> As `take_first` has them.
      real(wp), intent(in) :: unbounded, rows(lanes, 3, 3), f(lanes, 3), determinant(lanes)
      real(wp), intent(inout) :: z(lanes, 3), size(lanes), moved(lanes), done(lanes)
      real(wp), intent(out) :: before(lanes), length(lanes)
      !> 1: increments fall slowly.
      real(wp), intent(out) :: slow(lanes)
      integer(long), intent(out) :: open, ended, wide, far, any_slow
      real(wp) :: d1, d2, d3, z1, z2, z3, last, longest, going, way, old, next, least, tiny_of, awake, nothing
      integer :: i
      open = 0
      ended = 0
      wide = 0
      far = 0
      any_slow = 0
      do i = 1, lanes
         d1 = rows(i, 1, 1)*f(i, 1) + rows(i, 2, 1)*f(i, 2) + rows(i, 3, 1)*f(i, 3)
         d2 = rows(i, 1, 2)*f(i, 1) + rows(i, 2, 2)*f(i, 2) + rows(i, 3, 2)*f(i, 3)
         d3 = rows(i, 1, 3)*f(i, 1) + rows(i, 2, 3)*f(i, 2) + rows(i, 3, 3)*f(i, 3)
         awake = 1 - done(i)
         ! -0 leaves any number as it is; +0 makes +0 of the ±0 of a lane that is done.
         nothing = sign(0.0_wp, done(i) - 0.5_wp)
         z1 = z(i, 1) - (awake*d1 + nothing)
         z2 = z(i, 2) - (awake*d2 + nothing)
         z3 = z(i, 3) - (awake*d3 + nothing)
         z(i, 1) = z1
         z(i, 2) = z2
         z(i, 3) = z3
         last = max(abs(d1), abs(d2), abs(d3))
         longest = max(abs(z1), abs(z2), abs(z3))
         way = moved(i) + last
         next = curvature*way*last
         least = (0.5_wp*eps)*longest*determinant(i)
         tiny_of = round_off*longest
         going = (0.5_wp - sign(0.5_wp, tiny_of - last))*max(0.5_wp - sign(0.5_wp, least - next), unbounded)
         going = awake*going
         old = size(i)
         slow(i) = going*(0.5_wp - sign(0.5_wp, too_slow*old - last))
         before(i) = old
         last = awake*last + done(i)*old
         size(i) = last
         moved(i) = way
         length(i) = longest
         done(i) = 1 - going
         open = ior(open, transfer(going, open))
         ended = ior(ended, transfer(done(i), ended))
         wide = ior(wide, transfer(0.5_wp - sign(0.5_wp, coarse - last), wide))
         far = ior(far, transfer(0.5_wp - sign(0.5_wp, 1 - longest), far))
         any_slow = ior(any_slow, transfer(slow(i), any_slow))
      end do
   end subroutine take_next

   !> Lanes whose increments fall slowly: those at round-off are done, as are those with many that are noise; else the
   !> forces' part of the Jacobian is to be taken anew.
   pure subroutine judge_slow(slow, at, kept)
      real(wp), intent(in) :: slow(lanes)
      type(iteration_t), intent(inout) :: at
      real(wp), intent(inout) :: kept(lanes)
      integer :: k
      do k = 1, lanes
         if (slow(k) < 0.5_wp) cycle
         associate (last => at%size(k))
            if (last > 0.5_wp*at%before(k)) then
               if (last <= usual_cancellation*eps*at%length(k)) at%done(k) = 1.0_wp
               if (at%done(k) < 0.5_wp .and. last <= attitude_noise) at%stalls(k) = at%stalls(k) + 1
            end if
         end associate
         if (at%stalls(k) >= real(most_stalls, wp)) at%done(k) = 1.0_wp
         if (at%done(k) < 0.5_wp) kept(k) = 0.0_wp
      end do
      at%goes_on = any(at%done < 0.5_wp)
      at%has_done = any(at%done > 0.5_wp)
   end subroutine judge_slow

   !> Gives up the lanes whose unknowns belong to no step.
   pure subroutine give_up_far(at, given_up)
      type(iteration_t), intent(inout) :: at
      real(wp), intent(inout) :: given_up(lanes)
      integer :: k
      do k = 1, lanes
         if (at%length(k) <= 1.0_wp) cycle
         given_up(k) = 1.0_wp
         at%z(k, :) = 0.0_wp
         at%size(k) = 0.0_wp
         at%done(k) = 1.0_wp
      end do
      at%goes_on = any(at%done < 0.5_wp)
      at%has_done = any(at%done > 0.5_wp)
      at%is_coarse = any(at%size > coarse)
   end subroutine give_up_far

end module nutate_lane_newton
