!> The parts of a step of free bodies in reduced form (`nutate_reduced_equations`), several bodies at once: structure of
!> arrays, one body a lane.
!>
!> Every lane does the arithmetic of the scalar stepper, operation by operation, so that its bits are the same. Loops
!> have no branches, masks are nested merges: gfortran makes vector instructions of them, two lanes at once by SSE2.
!> Lanes that are done, or given up, hold finite values and are only not taken.
module nutate_lane_step
   use nutate_implicit_step, only: attitude_noise
   use nutate_kinds, only: wp, eps
   use nutate_newton_increment, only: round_off, usual_cancellation
   use nutate_predictor, only: most_steps
   use nutate_reduced, only: coarse, curvature
   implicit none
   private

   public :: start_lanes, explicit_lanes, predict_lanes, take_residuals, invert_lanes, correct_lanes, finish_lanes

   !> Bodies at once: two registers of AVX-512, eight of SSE2.
   integer, parameter, public :: lanes = 8
   !> Momenta in the units of the step above belong to no step that a lane takes, and |q|² farther from 1 neither.
   real(wp), parameter :: greatest_momentum = 10.0_wp, near_manifold = 1e-9_wp
   !> Determinants below are not divided by.
   real(wp), parameter :: least_determinant = 1e-12_wp
   !> |b| of a root above this is left to the scalar stepper: below 0.41 one of a free body with a positive determinant
   !> is that of the true motion.
   real(wp), parameter :: longest = 0.4_wp

contains

   !> The momentum of the start, over that of the step; a lane that is in no state to be stepped gets none, and is given
   !> up.
   pure subroutine start_lanes(q, p, scale, half, momentum, given_up)
      !> Attitude and conjugate momentum; shape (lanes, 4).
      real(wp), intent(in) :: q(lanes, 4), p(lanes, 4)
      !> Δt/4s
      real(wp), intent(in) :: scale(lanes)
      !> L0, kg m²/s, and in the units of the step; shape (lanes, 3).
      real(wp), intent(out) :: half(lanes, 3), momentum(lanes, 3)
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: square(lanes), f, u1, u2, u3, u4, kept(lanes), largest(lanes)
      integer :: i
      do i = 1, lanes
         square(i) = q(i, 1)*q(i, 1) + q(i, 2)*q(i, 2) + q(i, 3)*q(i, 3) + q(i, 4)*q(i, 4)
         f = 0.5_wp*(3 - square(i))
         u1 = f*q(i, 1)
         u2 = f*q(i, 2)
         u3 = f*q(i, 3)
         u4 = f*q(i, 4)
         half(i, 1) = 0.5_wp*(u1*p(i, 2) - u2*p(i, 1) - u3*p(i, 4) + u4*p(i, 3))
         half(i, 2) = 0.5_wp*(u1*p(i, 3) + u2*p(i, 4) - u3*p(i, 1) - u4*p(i, 2))
         half(i, 3) = 0.5_wp*(u1*p(i, 4) - u2*p(i, 3) + u3*p(i, 2) - u4*p(i, 1))
         momentum(i, 1) = scale(i)*half(i, 1)
         momentum(i, 2) = scale(i)*half(i, 2)
         momentum(i, 3) = scale(i)*half(i, 3)
         square(i) = abs(square(i) - 1)
      end do
      do i = 1, lanes
         kept(i) = merge(1.0_wp, 0.0_wp, square(i) <= near_manifold)
      end do
      call find_largest(momentum, largest)
      do i = 1, lanes
         kept(i) = merge(kept(i), 0.0_wp, largest(i) <= greatest_momentum)
      end do
      do i = 1, lanes
         given_up(i) = merge(given_up(i), 1.0_wp, kept(i) > 0.5_wp)
      end do
      call clear_lanes(given_up, momentum)
   end subroutine start_lanes

   !> Zeros in the lanes that are given up.
   pure subroutine clear_lanes(given_up, x)
      real(wp), intent(in) :: given_up(lanes)
      !> Shape (lanes, 3).
      real(wp), intent(inout) :: x(lanes, 3)
      integer :: i, k
      do k = 1, 3
         do i = 1, lanes
            x(i, k) = merge(x(i, k), 0.0_wp, given_up(i) < 0.5_wp)
         end do
      end do
   end subroutine clear_lanes

   !> The largest of three numbers of each lane, in size.
   pure subroutine find_largest(x, largest)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: x(lanes, 3)
      real(wp), intent(out) :: largest(lanes)
      real(wp) :: sizes(lanes, 3)
      integer :: i, k
      do k = 1, 3
         do i = 1, lanes
            sizes(i, k) = abs(x(i, k))
         end do
      end do
      do i = 1, lanes
         largest(i) = merge(sizes(i, 1), sizes(i, 2), sizes(i, 1) > sizes(i, 2))
      end do
      do i = 1, lanes
         largest(i) = merge(largest(i), sizes(i, 3), largest(i) > sizes(i, 3))
      end do
   end subroutine find_largest

   !> b of a step whose momentum stays; 0 in lanes that are given up.
   pure subroutine explicit_lanes(quarter, inverse, half, z, given_up)
      !> ¼Δt, s.
      real(wp), intent(in) :: quarter
      !> J⁻¹; shape (lanes, 3, 3). L0; shape (lanes, 3).
      real(wp), intent(in) :: inverse(lanes, 3, 3), half(lanes, 3)
      !> Shape (lanes, 3).
      real(wp), intent(out) :: z(lanes, 3)
      !> 1: yes; also where b is longer than any that a lane takes.
      real(wp), intent(inout) :: given_up(lanes)
      integer :: i, k
      do k = 1, 3
         do i = 1, lanes
            z(i, k) = quarter*(inverse(i, k, 1)*half(i, 1) + inverse(i, k, 2)*half(i, 2) + inverse(i, k, 3)*half(i, 3))
            given_up(i) = merge(given_up(i), 1.0_wp, abs(z(i, k)) <= 1.0_wp)
         end do
      end do
      call clear_lanes(given_up, z)
   end subroutine explicit_lanes

   !> The polynomial through the last steps, continued.
   pure subroutine predict_lanes(w, past, given_up, z)
      !> Weights of the last steps, the latest first.
      real(wp), intent(in) :: w(most_steps)
      !> Shape (lanes, 3, steps).
      real(wp), intent(in) :: past(lanes, 3, most_steps), given_up(lanes)
      !> Shape (lanes, 3).
      real(wp), intent(out) :: z(lanes, 3)
      integer :: i, k
      do k = 1, 3
         do i = 1, lanes
            z(i, k) = (w(1)*past(i, k, 1) + w(3)*past(i, k, 3) + w(5)*past(i, k, 5)) &
                + (w(2)*past(i, k, 2) + w(4)*past(i, k, 4) + w(6)*past(i, k, 6))
         end do
      end do
      call clear_lanes(given_up, z)
   end subroutine predict_lanes

   !> F(z) = (1-β)(L̄ - L0) + 2b×L̄, and what the Jacobian is made of.
   pure subroutine take_residuals(inertia, momentum, z, mean, change, rest, f)
      !> J/s; shape (lanes, 3, 3). In the units of the step; shape (lanes, 3).
      real(wp), intent(in) :: inertia(lanes, 3, 3), momentum(lanes, 3), z(lanes, 3)
      !> L̄, L̄ - L0; shape (lanes, 3). 1-β.
      real(wp), intent(out) :: mean(lanes, 3), change(lanes, 3), rest(lanes), f(lanes, 3)
      real(wp) :: m1, m2, m3, b1, b2, b3
      integer :: i
      do i = 1, lanes
         b1 = z(i, 1)
         b2 = z(i, 2)
         b3 = z(i, 3)
         m1 = inertia(i, 1, 1)*b1 + inertia(i, 1, 2)*b2 + inertia(i, 1, 3)*b3 + 0.0_wp
         m2 = inertia(i, 2, 1)*b1 + inertia(i, 2, 2)*b2 + inertia(i, 2, 3)*b3 + 0.0_wp
         m3 = inertia(i, 3, 1)*b1 + inertia(i, 3, 2)*b2 + inertia(i, 3, 3)*b3 + 0.0_wp
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
   pure subroutine invert_lanes(inertia, z, mean, change, rest, size, rows, determinant, moved, given_up)
      real(wp), intent(in) :: inertia(lanes, 3, 3), z(lanes, 3), mean(lanes, 3), change(lanes, 3), rest(lanes)
      !> Of the last increment.
      real(wp), intent(in) :: size(lanes)
      !> Shape (lanes, 3, row).
      real(wp), intent(inout) :: rows(lanes, 3, 3)
      !> Determinant, and the way since it was taken.
      real(wp), intent(inout) :: determinant(lanes), moved(lanes), given_up(lanes)
      real(wp) :: m(lanes, 3, 3), r(lanes, 3, 3), det(lanes), divisor(lanes)
      integer :: i, j, k
      do j = 1, 3
         do i = 1, lanes
            m(i, 1, j) = 0.0_wp + (rest(i)*inertia(i, 1, j) + 2*((z(i, 2)*inertia(i, 3, j) - z(i, 3)*inertia(i, 2, j)) &
                                                                 - z(i, j)*change(i, 1)))
            m(i, 2, j) = 0.0_wp + (rest(i)*inertia(i, 2, j) + 2*((z(i, 3)*inertia(i, 1, j) - z(i, 1)*inertia(i, 3, j)) &
                                                                 - z(i, j)*change(i, 2)))
            m(i, 3, j) = 0.0_wp + (rest(i)*inertia(i, 3, j) + 2*((z(i, 1)*inertia(i, 2, j) - z(i, 2)*inertia(i, 1, j)) &
                                                                 - z(i, j)*change(i, 3)))
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
      call cross_columns(m, 2, 3, r(:, :, 1))
      call cross_columns(m, 3, 1, r(:, :, 2))
      call cross_columns(m, 1, 2, r(:, :, 3))
      do i = 1, lanes
         det(i) = r(i, 1, 1)*m(i, 1, 1) + r(i, 2, 1)*m(i, 2, 1) + r(i, 3, 1)*m(i, 3, 1)
      end do
      call choose_lanes(size, det, determinant)
      do i = 1, lanes
         given_up(i) = merge(given_up(i), 1.0_wp, determinant(i) > least_determinant)
      end do
      do i = 1, lanes
         divisor(i) = merge(det(i), 1.0_wp, det(i) > least_determinant)
      end do
      do i = 1, lanes
         divisor(i) = 1/divisor(i)
         det(i) = 0.0_wp
      end do
      call choose_lanes(size, det, moved)
      do k = 1, 3
         do j = 1, 3
            call scale_lanes(divisor, r(:, j, k))
            call choose_lanes(size, r(:, j, k), rows(:, j, k))
         end do
      end do
   end subroutine invert_lanes

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

   pure subroutine scale_lanes(factor, x)
      real(wp), intent(in) :: factor(lanes)
      real(wp), intent(inout) :: x(lanes)
      integer :: i
      do i = 1, lanes
         x(i) = factor(i)*x(i)
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

   !> One increment in the lanes that are not done, and which are then. A lane that leaves the bounds of a step, or
   !> whose increments are at their noise without having converged, is given up.
   pure subroutine correct_lanes(rows, determinant, f, z, size, moved, done, given_up)
      real(wp), intent(in) :: rows(lanes, 3, 3), determinant(lanes), f(lanes, 3)
      real(wp), intent(inout) :: z(lanes, 3), size(lanes), moved(lanes)
      !> 1: yes.
      real(wp), intent(inout) :: done(lanes), given_up(lanes)
      real(wp) :: d(lanes, 3), last(lanes), length(lanes), half_of(lanes), noise(lanes), tiny_of(lanes)
      real(wp) :: next(lanes), least_of(lanes), ends(lanes), slow(lanes), going(lanes), kept(lanes), ended(lanes)
      integer :: i, k
      do k = 1, 3
         call correct_component(rows(:, :, k), f, done, d(:, k), z(:, k))
      end do
      call find_largest(d, last)
      call find_largest(z, length)
      do i = 1, lanes
         moved(i) = moved(i) + last(i)
         half_of(i) = 0.5_wp*size(i)
         noise(i) = usual_cancellation*eps*length(i)
         tiny_of(i) = round_off*length(i)
         next(i) = curvature*moved(i)*last(i)
         least_of(i) = (0.5_wp*eps)*length(i)*determinant(i)
      end do
      do i = 1, lanes
         slow(i) = merge(1.0_wp, 0.0_wp, last(i) > half_of(i))
         ends(i) = slow(i)*merge(1.0_wp, 0.0_wp, last(i) <= noise(i))
         slow(i) = slow(i)*merge(1.0_wp, 0.0_wp, last(i) <= attitude_noise)
      end do
      do i = 1, lanes
         going(i) = merge(0.0_wp, 1.0_wp, last(i) <= tiny_of(i))
         ended(i) = merge(1.0_wp, 0.0_wp, next(i) <= least_of(i))
         kept(i) = merge(1.0_wp, 0.0_wp, length(i) <= 1.0_wp)
      end do
      do i = 1, lanes
         going(i) = going(i)*(1 - ends(i))*(1 - ended(i))
         kept(i) = (1 - given_up(i))*kept(i)*(1 - slow(i)*going(i)*(1 - done(i)))
         given_up(i) = 1 - kept(i)
         size(i) = kept(i)*((1 - done(i))*last(i) + done(i)*size(i))
         done(i) = 1 - (1 - done(i))*going(i)*kept(i)
      end do
      call clear_lanes(given_up, z)
   end subroutine correct_lanes

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

   !> Moves the states by the Cayley maps of the roots, as `finish` of the scalar equations does. Gives lanes up whose
   !> root is not surely that of the true motion.
   pure subroutine finish_lanes(z, determinant, q, p, q_lost, p_lost, given_up)
      !> Roots b; shape (lanes, 3).
      real(wp), intent(in) :: z(lanes, 3), determinant(lanes)
      !> Shape (lanes, 4).
      real(wp), intent(inout) :: q(lanes, 4), p(lanes, 4), q_lost(lanes, 4), p_lost(lanes, 4)
      real(wp), intent(inout) :: given_up(lanes)
      !> Sums with it are whole multiples of 2⁻²⁵ (`nutate_cayley`).
      real(wp), parameter :: grid = 1.5_wp*2.0_wp**27
      real(wp) :: h1, h2, h3, high, low, rest, factor_half, beta_half, missing
      real(wp) :: beta(lanes), factor(lanes), excess(lanes)
      integer :: i
      do i = 1, lanes
         h1 = (z(i, 1) + grid) - grid
         h2 = (z(i, 2) + grid) - grid
         h3 = (z(i, 3) + grid) - grid
         high = h1*h1 + h2*h2 + h3*h3
         low = (z(i, 1) - h1)*(z(i, 1) + h1) + (z(i, 2) - h2)*(z(i, 2) + h2) + (z(i, 3) - h3)*(z(i, 3) + h3)
         beta(i) = high + low
         rest = (high - beta(i)) + low
         factor(i) = 2/(1 + beta(i))
         factor_half = (factor(i) + grid) - grid
         beta_half = (beta(i) + grid) - grid
         missing = ((2 - factor(i)) - factor_half*beta_half) &
                   - (factor_half*(beta(i) - beta_half) + (factor(i) - factor_half)*beta(i))
         excess(i) = (0.5_wp*factor(i))*(factor(i)*rest - beta(i)*missing)
      end do
      do i = 1, lanes
         given_up(i) = merge(given_up(i), 1.0_wp, beta(i) < longest**2)
         given_up(i) = merge(given_up(i), 1.0_wp, determinant(i) > 0.0_wp)
      end do
      call turn_lanes(z, beta, factor, excess, .false., q, q_lost)
      call turn_lanes(z, beta, factor, excess, .true., p, p_lost)
   end subroutine finish_lanes

   !> x∘c as an increment of x, added with its compensation; c - 1 = factor [-β, b].
   pure subroutine turn_lanes(b, beta, factor, excess, adds_impulse, x, lost)
      real(wp), intent(in) :: b(lanes, 3), beta(lanes), factor(lanes), excess(lanes)
      !> An impulse of zero is added, which takes the sign of a zero away.
      logical, intent(in) :: adds_impulse
      !> Shape (lanes, 4).
      real(wp), intent(inout) :: x(lanes, 4), lost(lanes, 4)
      real(wp) :: c(lanes, 4), increment, compensation, addend, missed, total, part
      integer :: i, k
      do i = 1, lanes
         c(i, 1) = -x(i, 1)*beta(i) - x(i, 2)*b(i, 1) - x(i, 3)*b(i, 2) - x(i, 4)*b(i, 3)
         c(i, 2) = x(i, 1)*b(i, 1) - x(i, 2)*beta(i) + x(i, 3)*b(i, 3) - x(i, 4)*b(i, 2)
         c(i, 3) = x(i, 1)*b(i, 2) - x(i, 2)*b(i, 3) - x(i, 3)*beta(i) + x(i, 4)*b(i, 1)
         c(i, 4) = x(i, 1)*b(i, 3) + x(i, 2)*b(i, 2) - x(i, 3)*b(i, 1) - x(i, 4)*beta(i)
      end do
      do k = 1, 4
         do i = 1, lanes
            c(i, k) = factor(i)*c(i, k)
         end do
      end do
      if (adds_impulse) c = c + 0.0_wp
      do k = 1, 4
         do i = 1, lanes
            increment = c(i, k)
            compensation = lost(i, k) - excess(i)*(x(i, k) + increment)
            addend = increment + compensation
            missed = compensation - (addend - increment)
            total = x(i, k) + addend
            part = total - x(i, k)
            lost(i, k) = ((x(i, k) - (total - part)) + (addend - part)) + missed
            x(i, k) = total
         end do
      end do
   end subroutine turn_lanes

end module nutate_lane_step
