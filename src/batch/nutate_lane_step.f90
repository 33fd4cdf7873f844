!> The parts of a step in reduced form (`nutate_reduced_equations`), several bodies at once: where it starts, what is
!> predicted, and where its root leads. Structure of arrays, one body a lane.
!>
!> Every lane does the arithmetic of the scalar stepper, operation by operation, so that its bits are the same. A loop
!> does as much as it can with what it has loaded, and has no branches: gfortran makes vector instructions of it, two
!> lanes at once by SSE2. It leaves loops scalar where a number that is computed is taken under a condition; so masks
!> are 0 and 1 made by `sign`, or merges of what is in memory. Whether a mask is set in some lane is told by its bits,
!> since sums of real numbers keep their order. Lanes that are done, or given up, hold finite values and are only not
!> taken.
module nutate_lane_step
   use nutate_kinds, only: wp, long
   use nutate_lane_width, only: lanes
   use nutate_predictor, only: most_steps
   implicit none
   private

   public :: start_lanes, explicit_lanes, predict_lanes, measure_turns, turn_lanes

   !> Momenta in the units of the step above belong to no step that a lane takes, and |q|² farther from 1 neither.
   real(wp), parameter, public :: greatest_momentum = 10.0_wp
   real(wp), parameter :: near_manifold = 1e-9_wp

contains

   !> The momentum of the start, over that of the step; a lane that is in no state to be stepped gets none, and is given
   !> up.
   pure subroutine start_lanes(q, p, scale, frame, half, momentum, given_up)
      !> Attitude and conjugate momentum; shape (lanes, 4).
      real(wp), intent(in) :: q(lanes, 4), p(lanes, 4)
      !> Δt/4s
      real(wp), intent(in) :: scale(lanes)
      !> u = q/|q|; shape (lanes, 4).
      real(wp), intent(out) :: frame(lanes, 4)
      !> L0, kg m²/s, and in the units of the step; shape (lanes, 3).
      real(wp), intent(out) :: half(lanes, 3), momentum(lanes, 3)
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: off(lanes), largest(lanes), square, f, u1, u2, u3, u4, h1, h2, h3
      logical :: any_lost
      integer :: i
      do i = 1, lanes
         square = q(i, 1)*q(i, 1) + q(i, 2)*q(i, 2) + q(i, 3)*q(i, 3) + q(i, 4)*q(i, 4)
         f = 0.5_wp*(3 - square)
         u1 = f*q(i, 1)
         u2 = f*q(i, 2)
         u3 = f*q(i, 3)
         u4 = f*q(i, 4)
         frame(i, 1) = u1
         frame(i, 2) = u2
         frame(i, 3) = u3
         frame(i, 4) = u4
         h1 = 0.5_wp*(u1*p(i, 2) - u2*p(i, 1) - u3*p(i, 4) + u4*p(i, 3))
         h2 = 0.5_wp*(u1*p(i, 3) + u2*p(i, 4) - u3*p(i, 1) - u4*p(i, 2))
         h3 = 0.5_wp*(u1*p(i, 4) - u2*p(i, 3) + u3*p(i, 2) - u4*p(i, 1))
         half(i, 1) = h1
         half(i, 2) = h2
         half(i, 3) = h3
         h1 = scale(i)*h1
         h2 = scale(i)*h2
         h3 = scale(i)*h3
         momentum(i, 1) = h1
         momentum(i, 2) = h2
         momentum(i, 3) = h3
         off(i) = abs(square - 1)
         ! A sum, which shows what is no number.
         largest(i) = abs(h1) + abs(h2) + abs(h3)
      end do
      call give_up_above(off, near_manifold, largest, greatest_momentum, given_up, any_lost)
      if (any_lost) call clear_lanes(given_up, momentum)
   end subroutine start_lanes

   !> Gives up the lanes where one of two numbers is not below its bound.
   pure subroutine give_up_above(a, bound_a, b, bound_b, given_up, any_lost)
      real(wp), intent(in) :: a(lanes), bound_a, b(lanes), bound_b
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      !> Some lane has been.
      logical, intent(out) :: any_lost
      real(wp) :: was, now
      integer(long) :: lost
      integer :: i
      lost = 0
      do i = 1, lanes
         was = given_up(i)
         now = max(was, 1 - merge(1.0_wp, 0.0_wp, a(i) <= bound_a)*merge(1.0_wp, 0.0_wp, b(i) <= bound_b))
         given_up(i) = now
         lost = ior(lost, transfer(now - was, lost))
      end do
      any_lost = lost /= 0
   end subroutine give_up_above

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

   !> b of a step whose momentum stays; 0 in lanes that are given up.
   pure subroutine explicit_lanes(quarter, inverse, half, rotor, z, given_up)
      !> ¼Δt, s.
      real(wp), intent(in) :: quarter
      !> J⁻¹; shape (lanes, 3, 3). L0 and the momentum of rotors; shape (lanes, 3).
      real(wp), intent(in) :: inverse(lanes, 3, 3), half(lanes, 3), rotor(lanes, 3)
      !> Shape (lanes, 3).
      real(wp), intent(out) :: z(lanes, 3)
      !> 1: yes; also where b is longer than any that a lane takes.
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: own(lanes, 3)
      integer :: i, k
      do k = 1, 3
         do i = 1, lanes
            own(i, k) = half(i, k) - rotor(i, k)
         end do
      end do
      do k = 1, 3
         do i = 1, lanes
            z(i, k) = quarter*(inverse(i, k, 1)*own(i, 1) + inverse(i, k, 2)*own(i, 2) + inverse(i, k, 3)*own(i, 3))
            given_up(i) = merge(given_up(i), 1.0_wp, abs(z(i, k)) <= 1.0_wp)
         end do
      end do
      call clear_lanes(given_up, z)
   end subroutine explicit_lanes

   !> The polynomial through the last steps, continued.
   pure subroutine predict_lanes(known, is_even, weights, x1, x2, x3, x4, x5, x6, z)
      !> Steps that each lane knows, 1 or more.
      integer, intent(in) :: known(lanes)
      !> All as many.
      logical, intent(in) :: is_even
      !> Column m: of the last m steps, the latest first.
      real(wp), intent(in) :: weights(most_steps, most_steps)
      !> Unknowns of the steps, the latest first; shape (lanes, 3).
      real(wp), dimension(lanes, 3), intent(in) :: x1, x2, x3, x4, x5, x6
      !> Shape (lanes, 3).
      real(wp), intent(out) :: z(lanes, 3)
      real(wp) :: w(most_steps)
      integer :: i, k, lane
      w = weights(:, known(1))
      do k = 1, 3
         do i = 1, lanes
            z(i, k) = (w(1)*x1(i, k) + w(3)*x3(i, k) + w(5)*x5(i, k)) + (w(2)*x2(i, k) + w(4)*x4(i, k) + w(6)*x6(i, k))
         end do
      end do
      if (is_even) return
      do lane = 2, lanes
         w = weights(:, known(lane))
         z(lane, :) = (w(1)*x1(lane, :) + w(3)*x3(lane, :) + w(5)*x5(lane, :)) &
                      + (w(2)*x2(lane, :) + w(4)*x4(lane, :) + w(6)*x6(lane, :))
      end do
   end subroutine predict_lanes

   !> β, 2/(1+β) and the excess of the Cayley maps of the roots (`nutate_cayley`). Gives lanes up whose root is not
   !> surely that of the true motion.
   pure subroutine measure_turns(z, determinant, near, beta, factor, excess, given_up)
      !> Roots b; shape (lanes, 3).
      real(wp), intent(in) :: z(lanes, 3), determinant(lanes)
      !> β below which a root with a positive determinant is the true one.
      real(wp), intent(in) :: near(lanes)
      real(wp), intent(out) :: beta(lanes), factor(lanes), excess(lanes)
      real(wp), intent(inout) :: given_up(lanes)
      logical :: any_lost
      !> Sums with it are whole multiples of 2⁻²⁵ (`nutate_cayley`).
      real(wp), parameter :: grid = 1.5_wp*2.0_wp**27
      real(wp) :: h1, h2, h3, high, low, rest, factor_half, beta_half, missing, square(lanes), negative(lanes)
      integer :: i
      do i = 1, lanes
         h1 = (z(i, 1) + grid) - grid
         h2 = (z(i, 2) + grid) - grid
         h3 = (z(i, 3) + grid) - grid
         high = h1*h1 + h2*h2 + h3*h3
         low = (z(i, 1) - h1)*(z(i, 1) + h1) + (z(i, 2) - h2)*(z(i, 2) + h2) + (z(i, 3) - h3)*(z(i, 3) + h3)
         beta(i) = high + low
         square(i) = (z(i, 1)*z(i, 1) + z(i, 2)*z(i, 2) + z(i, 3)*z(i, 3)) - near(i)
         negative(i) = -determinant(i)
         rest = (high - beta(i)) + low
         factor(i) = 2/(1 + beta(i))
         factor_half = (factor(i) + grid) - grid
         beta_half = (beta(i) + grid) - grid
         missing = ((2 - factor(i)) - factor_half*beta_half) &
                   - (factor_half*(beta(i) - beta_half) + (factor(i) - factor_half)*beta(i))
         excess(i) = (0.5_wp*factor(i))*(factor(i)*rest - beta(i)*missing)
      end do
      call give_up_above(square, -tiny(1.0_wp), negative, -tiny(1.0_wp), given_up, any_lost)
   end subroutine measure_turns

   !> Moves what turns by the roots: adds x∘c - x, with c - 1 = factor [-β, b], and an impulse, with their compensation
   !> (`nutate_state`).
   pure subroutine turn_lanes(b, beta, factor, excess, impulse, x, lost)
      !> Shapes (lanes, 3) and (lanes).
      real(wp), intent(in) :: b(lanes, 3), beta(lanes), factor(lanes), excess(lanes)
      !> Shape (lanes, 4).
      real(wp), intent(in) :: impulse(lanes, 4)
      real(wp), intent(inout) :: x(lanes, 4), lost(lanes, 4)
      real(wp) :: d(4), increment, compensation, addend, missed, total, part
      integer :: i, k
      do i = 1, lanes
         d(1) = -x(i, 1)*beta(i) - x(i, 2)*b(i, 1) - x(i, 3)*b(i, 2) - x(i, 4)*b(i, 3)
         d(2) = x(i, 1)*b(i, 1) - x(i, 2)*beta(i) + x(i, 3)*b(i, 3) - x(i, 4)*b(i, 2)
         d(3) = x(i, 1)*b(i, 2) - x(i, 2)*b(i, 3) - x(i, 3)*beta(i) + x(i, 4)*b(i, 1)
         d(4) = x(i, 1)*b(i, 3) + x(i, 2)*b(i, 2) - x(i, 3)*b(i, 1) - x(i, 4)*beta(i)
         do k = 1, 4
            increment = factor(i)*d(k) + impulse(i, k)
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
