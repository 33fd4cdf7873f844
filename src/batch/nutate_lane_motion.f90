!> The start and the end of a step by Taylor series of several bodies at once: one body a lane. The arithmetic is that
!> of `begin_step` and `end_step` in `nutate_rigid_rates`, of `expand` and of `evaluate` in `nutate_motion_series`.
module nutate_lane_motion
   use nutate_kinds, only: wp
   use nutate_lane_choice, only: choose_lanes, replace_lanes
   use nutate_lane_vectors, only: multiply_lanes, write_momenta
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: begin_lanes, find_rates, test_rates, find_axes, find_frames, find_scale, scale_moments, add_changes
   public :: find_sines, see_lanes, straighten_rows, turn_rows, turn_in_axial_frame, turn_evenly, end_lanes

   !> Sum of the components of a turn in a step that a lane takes, rad: coefficients of the series grow by this from one
   !> to the next at most, since the moments of a body obey the triangle inequality; none leaves the range of numbers.
   real(wp), parameter :: most_turn = 64.0_wp

contains

   !> L of p = 2 q∘[0, L].
   pure subroutine begin_lanes(q, p, momentum)
      !> Attitude and conjugate momentum; shape (lanes, 4).
      real(wp), intent(in) :: q(lanes, 4), p(lanes, 4)
      !> N m s; shape (lanes, 3).
      real(wp), intent(out) :: momentum(lanes, 3)
      real(wp) :: half
      integer :: i
      do i = 1, lanes
         half = 0.5_wp/(q(i, 1)*q(i, 1) + q(i, 2)*q(i, 2) + q(i, 3)*q(i, 3) + q(i, 4)*q(i, 4))
         momentum(i, 1) = half*(q(i, 1)*p(i, 2) - q(i, 2)*p(i, 1) - q(i, 3)*p(i, 4) + q(i, 4)*p(i, 3))
         momentum(i, 2) = half*(q(i, 1)*p(i, 3) - q(i, 3)*p(i, 1) - q(i, 4)*p(i, 2) + q(i, 2)*p(i, 4))
         momentum(i, 3) = half*(q(i, 1)*p(i, 4) - q(i, 4)*p(i, 1) - q(i, 2)*p(i, 3) + q(i, 3)*p(i, 2))
      end do
   end subroutine begin_lanes

   !> ΔtΩ of bodies of diagonal inertia without rotors, or ΔtL/J₁.
   pure subroutine find_rates(to_angle, momentum, w)
      !> Δt over the moments; shape (lanes, 3).
      real(wp), intent(in) :: to_angle(lanes, 3), momentum(lanes, 3)
      real(wp), intent(out) :: w(lanes, 3)
      integer :: i
      do i = 1, lanes
         w(i, 1) = to_angle(i, 1)*momentum(i, 1)
         w(i, 2) = to_angle(i, 2)*momentum(i, 2)
         w(i, 3) = to_angle(i, 3)*momentum(i, 3)
      end do
   end subroutine find_rates

   !> Gives up bodies that turn too fast; they get no rate.
   pure subroutine test_rates(w, given_up)
      !> ΔtΩ, or ΔtL/J₁; shape (lanes, 3).
      real(wp), intent(inout) :: w(lanes, 3)
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: kept(lanes), turn
      integer :: i, k
      do i = 1, lanes
         ! A sum, which shows what is no number.
         turn = abs(w(i, 1)) + abs(w(i, 2)) + abs(w(i, 3))
         kept(i) = merge(1.0_wp, 0.0_wp, turn <= most_turn)
      end do
      call give_up_others(kept, given_up)
      do k = 1, 3
         call replace_lanes(kept, 0.0_wp, w(:, k))
      end do
   end subroutine test_rates

   !> Gives up the lanes that are not kept.
   pure subroutine give_up_others(kept, given_up)
      !> 1: yes.
      real(wp), intent(in) :: kept(lanes)
      real(wp), intent(inout) :: given_up(lanes)
      integer :: i
      do i = 1, lanes
         given_up(i) = max(given_up(i), 1 - kept(i))
      end do
   end subroutine give_up_others

   !> Of gyrostats the direction of L; gives up those that have none, which get another.
   pure subroutine find_axes(floor, momentum, axis, length, given_up)
      !> Lengths up to this have no direction; shape (lanes).
      real(wp), intent(in) :: floor(lanes)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: momentum(lanes, 3)
      !> L/|L|, and |L|; shapes (lanes, 3) and (lanes).
      real(wp), intent(out) :: axis(lanes, 3), length(lanes)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: kept(lanes)
      integer :: i
      call find_lengths(floor, momentum, length, kept, given_up)
      do i = 1, lanes
         axis(i, 1) = momentum(i, 1)/length(i)
         axis(i, 2) = momentum(i, 2)/length(i)
         axis(i, 3) = momentum(i, 3)/length(i)
      end do
      call replace_lanes(kept, 1.0_wp, axis(:, 1))
      call replace_lanes(kept, 0.0_wp, axis(:, 2))
      call replace_lanes(kept, 0.0_wp, axis(:, 3))
   end subroutine find_axes

   !> |L|, or 1 in lanes that have none and are given up.
   pure subroutine find_lengths(floor, l, length, kept, given_up)
      real(wp), intent(in) :: floor(lanes), l(lanes, 3)
      !> The latter 1 in lanes that have one.
      real(wp), intent(out) :: length(lanes), kept(lanes)
      real(wp), intent(inout) :: given_up(lanes)
      integer :: i
      do i = 1, lanes
         length(i) = sqrt(l(i, 1)*l(i, 1) + l(i, 2)*l(i, 2) + l(i, 3)*l(i, 3))
         kept(i) = merge(1.0_wp, 0.0_wp, length(i) > floor(i))
      end do
      call give_up_others(kept, given_up)
      call replace_lanes(kept, 1.0_wp, length)
   end subroutine find_lengths

   !> 1 over the size of L, from the first three coefficients.
   pure subroutine find_scale(inertia, w0, w1, w2, scale)
      !> Shape (lanes, 3).
      real(wp), dimension(lanes, 3), intent(in) :: inertia, w0, w1, w2
      real(wp), intent(out) :: scale(lanes)
      real(wp) :: a, b, c, root(lanes), moves(lanes)
      integer :: i
      do i = 1, lanes
         a = inertia(i, 1)*w0(i, 1)
         b = inertia(i, 2)*w0(i, 2)
         c = inertia(i, 3)*w0(i, 3)
         scale(i) = a*a + b*b + c*c
         a = inertia(i, 1)*w1(i, 1)
         b = inertia(i, 2)*w1(i, 2)
         c = inertia(i, 3)*w1(i, 3)
         scale(i) = max(scale(i), a*a + b*b + c*c)
         a = inertia(i, 1)*w2(i, 1)
         b = inertia(i, 2)*w2(i, 2)
         c = inertia(i, 3)*w2(i, 3)
         scale(i) = max(scale(i), a*a + b*b + c*c)
         moves(i) = merge(1.0_wp, 0.0_wp, scale(i) > tiny(1.0_wp))
      end do
      root = scale
      call replace_lanes(moves, 1.0_wp, root)
      do i = 1, lanes
         root(i) = 1/sqrt(root(i))
      end do
      call choose_lanes(moves, root, scale)
   end subroutine find_scale

   !> Moments over Δt and the size of L.
   pure subroutine scale_moments(scale, inertia, scaled)
      real(wp), intent(in) :: scale(lanes), inertia(lanes, 3)
      real(wp), intent(out) :: scaled(lanes, 3)
      integer :: i, k
      do k = 1, 3
         do i = 1, lanes
            scaled(i, k) = scale(i)*inertia(i, k)
         end do
      end do
   end subroutine scale_moments

   !> L at the end, from the change of ΔtΩ.
   pure subroutine add_changes(inertia, change, momentum)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: inertia(lanes, 3), change(lanes, 3)
      real(wp), intent(inout) :: momentum(lanes, 3)
      integer :: i
      do i = 1, lanes
         momentum(i, 1) = momentum(i, 1) + inertia(i, 1)*change(i, 1)
         momentum(i, 2) = momentum(i, 2) + inertia(i, 2)*change(i, 2)
         momentum(i, 3) = momentum(i, 3) + inertia(i, 3)*change(i, 3)
      end do
   end subroutine add_changes

   !> Cosine and sine, one by one: those of the scalar stepper.
   pure subroutine find_sines(angle, cosine, sine)
      !> rad; shape (lanes).
      real(wp), intent(in) :: angle(lanes)
      real(wp), intent(out) :: cosine(lanes), sine(lanes)
      integer :: lane
      do lane = 1, lanes
         cosine(lane) = cos(angle(lane))
         sine(lane) = sin(angle(lane))
      end do
   end subroutine find_sines

   !> A direction fixed in space as the bodies see it, Rᵀe.
   pure subroutine see_lanes(q, e, seen)
      !> Shapes (lanes, 4) and (lanes, 3).
      real(wp), intent(in) :: q(lanes, 4), e(lanes, 3)
      real(wp), intent(out) :: seen(lanes, 3)
      real(wp) :: d, w1, w2, w3
      integer :: i
      do i = 1, lanes
         d = q(i, 2)*e(i, 1) + q(i, 3)*e(i, 2) + q(i, 4)*e(i, 3)
         w1 = q(i, 1)*e(i, 1) - q(i, 3)*e(i, 3) + q(i, 4)*e(i, 2)
         w2 = q(i, 1)*e(i, 2) - q(i, 4)*e(i, 1) + q(i, 2)*e(i, 3)
         w3 = q(i, 1)*e(i, 3) - q(i, 2)*e(i, 2) + q(i, 3)*e(i, 1)
         seen(i, 1) = q(i, 1)*w1 + d*q(i, 2) - q(i, 3)*w3 + q(i, 4)*w2
         seen(i, 2) = q(i, 1)*w2 + d*q(i, 3) - q(i, 4)*w1 + q(i, 2)*w3
         seen(i, 3) = q(i, 1)*w3 + d*q(i, 4) - q(i, 2)*w2 + q(i, 3)*w1
      end do
   end subroutine see_lanes

   !> Directions across u, and across both: frames of gyrostats, of which u is the second row.
   pure subroutine find_frames(u, f1, f3)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: u(lanes, 3)
      real(wp), intent(out) :: f1(lanes, 3), f3(lanes, 3)
      real(wp) :: e(lanes, 3), length, first, second
      integer :: i
      do i = 1, lanes
         ! The axis that u is farthest from.
         first = merge(1.0_wp, 0.0_wp, abs(u(i, 1)) <= abs(u(i, 2)))*merge(1.0_wp, 0.0_wp, abs(u(i, 1)) <= abs(u(i, 3)))
         second = merge(1.0_wp, 0.0_wp, abs(u(i, 2)) <= abs(u(i, 3)))
         e(i, 1) = first
         e(i, 2) = (1 - first)*second
         e(i, 3) = (1 - first)*(1 - second)
      end do
      do i = 1, lanes
         f1(i, 1) = e(i, 2)*u(i, 3) - e(i, 3)*u(i, 2)
         f1(i, 2) = e(i, 3)*u(i, 1) - e(i, 1)*u(i, 3)
         f1(i, 3) = e(i, 1)*u(i, 2) - e(i, 2)*u(i, 1)
         length = sqrt(f1(i, 1)*f1(i, 1) + f1(i, 2)*f1(i, 2) + f1(i, 3)*f1(i, 3))
         f1(i, 1) = f1(i, 1)/length
         f1(i, 2) = f1(i, 2)/length
         f1(i, 3) = f1(i, 3)/length
         f3(i, 1) = f1(i, 2)*u(i, 3) - f1(i, 3)*u(i, 2)
         f3(i, 2) = f1(i, 3)*u(i, 1) - f1(i, 1)*u(i, 3)
         f3(i, 3) = f1(i, 1)*u(i, 2) - f1(i, 2)*u(i, 1)
      end do
   end subroutine find_frames

   !> The rows of gyrostats at the end: the second along L, the first across it.
   pure subroutine straighten_rows(floor, momentum, g1, g2, given_up)
      !> Lengths of L up to this have no direction; shape (lanes).
      real(wp), intent(in) :: floor(lanes)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: momentum(lanes, 3)
      real(wp), intent(inout) :: g1(lanes, 3)
      real(wp), intent(out) :: g2(lanes, 3)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: along(lanes), length(lanes), kept(lanes)
      integer :: i
      call find_lengths(floor, momentum, length, kept, given_up)
      do i = 1, lanes
         g2(i, 1) = momentum(i, 1)/length(i)
         g2(i, 2) = momentum(i, 2)/length(i)
         g2(i, 3) = momentum(i, 3)/length(i)
         along(i) = g1(i, 1)*g2(i, 1) + g1(i, 2)*g2(i, 2) + g1(i, 3)*g2(i, 3)
         g1(i, 1) = g1(i, 1) - along(i)*g2(i, 1)
         g1(i, 2) = g1(i, 2) - along(i)*g2(i, 2)
         g1(i, 3) = g1(i, 3) - along(i)*g2(i, 3)
         length(i) = sqrt(g1(i, 1)*g1(i, 1) + g1(i, 2)*g1(i, 2) + g1(i, 3)*g1(i, 3))
         kept(i) = merge(1.0_wp, 0.0_wp, length(i) > tiny(1.0_wp))
      end do
      call give_up_others(kept, given_up)
      call replace_lanes(kept, 1.0_wp, length)
      do i = 1, lanes
         g1(i, 1) = g1(i, 1)/length(i)
         g1(i, 2) = g1(i, 2)/length(i)
         g1(i, 3) = g1(i, 3)/length(i)
      end do
   end subroutine straighten_rows

   !> The rotation, from the rows at start and end; one by more than 2π/3 is given up.
   pure subroutine turn_rows(f1, f2, f3, g1, g2, g3, rotation, given_up)
      !> Rows at the start and at the end; shape (lanes, 3).
      real(wp), dimension(lanes, 3), intent(in) :: f1, f2, f3, g1, g2, g3
      !> Shape (lanes, 4).
      real(wp), intent(out) :: rotation(lanes, 4)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: kept(lanes), a1, a2, a3, b1, b2, b3, c1, c2, c3
      integer :: i
      do i = 1, lanes
         a1 = g1(i, 1)
         a2 = g1(i, 2)
         a3 = g1(i, 3)
         b1 = g2(i, 1)
         b2 = g2(i, 2)
         b3 = g2(i, 3)
         c1 = g3(i, 1)
         c2 = g3(i, 2)
         c3 = g3(i, 3)
         rotation(i, 1) = 1 + ((f1(i, 1)*a1 + f2(i, 1)*b1 + f3(i, 1)*c1) + (f1(i, 2)*a2 + f2(i, 2)*b2 + f3(i, 2)*c2) &
                               + (f1(i, 3)*a3 + f2(i, 3)*b3 + f3(i, 3)*c3))
         rotation(i, 2) = (f1(i, 3)*a2 + f2(i, 3)*b2 + f3(i, 3)*c2) - (f1(i, 2)*a3 + f2(i, 2)*b3 + f3(i, 2)*c3)
         rotation(i, 3) = (f1(i, 1)*a3 + f2(i, 1)*b3 + f3(i, 1)*c3) - (f1(i, 3)*a1 + f2(i, 3)*b1 + f3(i, 3)*c1)
         rotation(i, 4) = (f1(i, 2)*a1 + f2(i, 2)*b1 + f3(i, 2)*c1) - (f1(i, 1)*a2 + f2(i, 1)*b2 + f3(i, 1)*c2)
         kept(i) = merge(1.0_wp, 0.0_wp, rotation(i, 1) > 1.0_wp)
      end do
      call give_up_others(kept, given_up)
   end subroutine turn_rows

   !> The rotation of symmetric gyrostats in the axial frame, about their momentum; one at rest does not turn.
   pure subroutine turn_evenly(w, rotation)
      !> ΔtL/J₁; shape (lanes, 3).
      real(wp), intent(in) :: w(lanes, 3)
      !> Shape (lanes, 4).
      real(wp), intent(out) :: rotation(lanes, 4)
      real(wp), dimension(lanes) :: angle, half, cosine, sine, turns
      integer :: i, k
      do i = 1, lanes
         angle(i) = sqrt(w(i, 1)*w(i, 1) + w(i, 2)*w(i, 2) + w(i, 3)*w(i, 3))
         half(i) = 0.5_wp*angle(i)
         turns(i) = merge(1.0_wp, 0.0_wp, angle(i) > tiny(1.0_wp))
      end do
      call find_sines(half, cosine, sine)
      call replace_lanes(turns, 1.0_wp, angle)
      do i = 1, lanes
         sine(i) = sine(i)/angle(i)
         rotation(i, 1) = cosine(i)
         rotation(i, 2) = sine(i)*w(i, 1)
         rotation(i, 3) = sine(i)*w(i, 2)
         rotation(i, 4) = sine(i)*w(i, 3)
      end do
      call replace_lanes(turns, 1.0_wp, rotation(:, 1))
      do k = 2, 4
         call replace_lanes(turns, 0.0_wp, rotation(:, k))
      end do
   end subroutine turn_evenly

   !> Body components of a vector from those in the axial frame, the axis last.
   pure subroutine turn_in_axial_frame(cosine, sine, v1, v2)
      !> Of the angle by which the body turns in the frame; shape (lanes).
      real(wp), intent(in) :: cosine(lanes), sine(lanes)
      real(wp), intent(inout) :: v1(lanes), v2(lanes)
      real(wp) :: a, b
      integer :: i
      do i = 1, lanes
         a = v1(i)
         b = v2(i)
         v1(i) = cosine(i)*a + sine(i)*b
         v2(i) = cosine(i)*b - sine(i)*a
      end do
   end subroutine turn_in_axial_frame

   !> Moves bodies by rotations and to momenta: q∘c normalised, p = 2 q∘[0, L].
   pure subroutine end_lanes(rotation, momentum, q, p, given_up)
      !> Not normalised; shape (lanes, 4).
      real(wp), intent(in) :: rotation(lanes, 4)
      !> Shape (lanes, 3).
      real(wp), intent(in) :: momentum(lanes, 3)
      real(wp), intent(inout) :: q(lanes, 4), p(lanes, 4)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: y(lanes, 4), square(lanes), has_length(lanes), factor
      integer :: i
      call multiply_lanes(q, rotation, y)
      do i = 1, lanes
         square(i) = y(i, 1)*y(i, 1) + y(i, 2)*y(i, 2) + y(i, 3)*y(i, 3) + y(i, 4)*y(i, 4)
         has_length(i) = merge(1.0_wp, 0.0_wp, square(i) > tiny(1.0_wp))
      end do
      call give_up_others(has_length, given_up)
      call replace_lanes(has_length, 1.0_wp, square)
      do i = 1, lanes
         factor = 1/sqrt(square(i))
         q(i, 1) = factor*y(i, 1)
         q(i, 2) = factor*y(i, 2)
         q(i, 3) = factor*y(i, 3)
         q(i, 4) = factor*y(i, 4)
      end do
      call write_momenta(q, momentum, p)
   end subroutine end_lanes

end module nutate_lane_motion
