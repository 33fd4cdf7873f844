!> The start and the end of a step by Taylor series of several free bodies at once: one body a lane. The arithmetic is
!> that of `begin_step` and `end_step` in `nutate_rigid_rates`, of `expand` and of `evaluate` in
!> `nutate_motion_series`.
module nutate_lane_free_body
   use nutate_kinds, only: wp
   use nutate_lane_choice, only: replace_lanes
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: begin_free_lanes, find_scale, find_sines, scale_moments, turn_free_lanes

   !> Sum of the components of a turn in a step that a lane takes, rad: coefficients of the series grow by this from one
   !> to the next at most, since the moments of a body obey the triangle inequality; none leaves the range of numbers.
   real(wp), parameter :: most_turn = 64.0_wp
   !> Momentum of a body that turns, N m s.
   real(wp), parameter :: least = 1e-40_wp

contains

   !> L, its direction, and what the series starts from; a lane that is in no state to be stepped gets no rate, and is
   !> given up.
   pure subroutine begin_free_lanes(q, p, inertia, to_angle, momentum, axis, weights, w, given_up)
      !> Attitude and conjugate momentum; shape (lanes, 4).
      real(wp), intent(in) :: q(lanes, 4), p(lanes, 4)
      !> Moments over Δt, and Δt over the moments; shape (lanes, 3).
      real(wp), intent(in) :: inertia(lanes, 3), to_angle(lanes, 3)
      !> L, N m s, L/|L|, that times the moments over Δt and |L|, and ΔtΩ; shape (lanes, 3).
      real(wp), dimension(lanes, 3), intent(out) :: momentum, axis, weights, w
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: length(lanes), kept(lanes), half, turn
      integer :: i, k
      do i = 1, lanes
         half = 0.5_wp/(q(i, 1)*q(i, 1) + q(i, 2)*q(i, 2) + q(i, 3)*q(i, 3) + q(i, 4)*q(i, 4))
         momentum(i, 1) = half*(q(i, 1)*p(i, 2) - q(i, 2)*p(i, 1) - q(i, 3)*p(i, 4) + q(i, 4)*p(i, 3))
         momentum(i, 2) = half*(q(i, 1)*p(i, 3) - q(i, 3)*p(i, 1) - q(i, 4)*p(i, 2) + q(i, 2)*p(i, 4))
         momentum(i, 3) = half*(q(i, 1)*p(i, 4) - q(i, 4)*p(i, 1) - q(i, 2)*p(i, 3) + q(i, 3)*p(i, 2))
         length(i) = sqrt(momentum(i, 1)*momentum(i, 1) + momentum(i, 2)*momentum(i, 2) &
                          + momentum(i, 3)*momentum(i, 3))
         w(i, 1) = to_angle(i, 1)*momentum(i, 1)
         w(i, 2) = to_angle(i, 2)*momentum(i, 2)
         w(i, 3) = to_angle(i, 3)*momentum(i, 3)
         ! A sum, which shows what is no number.
         turn = abs(w(i, 1)) + abs(w(i, 2)) + abs(w(i, 3))
         kept(i) = merge(1.0_wp, 0.0_wp, turn <= most_turn)*merge(1.0_wp, 0.0_wp, length(i) >= least)
      end do
      call replace_lanes(kept, 1.0_wp, length)
      do i = 1, lanes
         given_up(i) = max(given_up(i), 1 - kept(i))
      end do
      do k = 1, 3
         call replace_lanes(kept, 0.0_wp, w(:, k))
         call find_axis(momentum(:, k), inertia(:, k), length, axis(:, k), weights(:, k))
      end do
   end subroutine begin_free_lanes

   !> One component of u₀, and what it is multiplied by in u·u₀.
   pure subroutine find_axis(momentum, inertia, length, axis, weight)
      real(wp), dimension(lanes), intent(in) :: momentum, inertia, length
      real(wp), dimension(lanes), intent(out) :: axis, weight
      integer :: i
      do i = 1, lanes
         axis(i) = momentum(i)/length(i)
         weight(i) = axis(i)*(inertia(i)/length(i))
      end do
   end subroutine find_axis

   !> 1 over the size of L, from the first three coefficients; at rest, of no meaning.
   pure subroutine find_scale(inertia, w0, w1, w2, scale)
      !> Shape (lanes, 3).
      real(wp), dimension(lanes, 3), intent(in) :: inertia, w0, w1, w2
      real(wp), intent(out) :: scale(lanes)
      real(wp) :: a, b, c, largest
      integer :: i
      do i = 1, lanes
         a = inertia(i, 1)*w0(i, 1)
         b = inertia(i, 2)*w0(i, 2)
         c = inertia(i, 3)*w0(i, 3)
         largest = max(a*a + b*b + c*c, tiny(1.0_wp))
         a = inertia(i, 1)*w1(i, 1)
         b = inertia(i, 2)*w1(i, 2)
         c = inertia(i, 3)*w1(i, 3)
         largest = max(largest, a*a + b*b + c*c)
         a = inertia(i, 1)*w2(i, 1)
         b = inertia(i, 2)*w2(i, 2)
         c = inertia(i, 3)*w2(i, 3)
         largest = max(largest, a*a + b*b + c*c)
         scale(i) = 1/sqrt(largest)
      end do
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

   !> Cosine and sine of half an angle, one by one: those of the scalar stepper.
   pure subroutine find_sines(angle, cosine, sine)
      !> rad; shape (lanes).
      real(wp), intent(in) :: angle(lanes)
      real(wp), intent(out) :: cosine(lanes), sine(lanes)
      integer :: lane
      do lane = 1, lanes
         cosine(lane) = cos(0.5_wp*angle(lane))
         sine(lane) = sin(0.5_wp*angle(lane))
      end do
   end subroutine find_sines

   !> Moves free bodies: by the angle about u₀ first, then by the shortest rotation from u to u₀, u the direction of L.
   pure subroutine turn_free_lanes(cosine, sine, axis, inertia, change, momentum, q, p, given_up)
      !> Of half the angle; shape (lanes).
      real(wp), intent(in) :: cosine(lanes), sine(lanes)
      !> u₀, moments over Δt, change of ΔtΩ, and L at the start; shape (lanes, 3).
      real(wp), dimension(lanes, 3), intent(in) :: axis, inertia, change, momentum
      !> Shape (lanes, 4).
      real(wp), intent(inout) :: q(lanes, 4), p(lanes, 4)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: l(lanes, 3), y(lanes, 4), length(lanes), kept(lanes)
      integer :: i
      do i = 1, lanes
         l(i, 1) = momentum(i, 1) + inertia(i, 1)*change(i, 1)
         l(i, 2) = momentum(i, 2) + inertia(i, 2)*change(i, 2)
         l(i, 3) = momentum(i, 3) + inertia(i, 3)*change(i, 3)
         length(i) = sqrt(l(i, 1)*l(i, 1) + l(i, 2)*l(i, 2) + l(i, 3)*l(i, 3))
         kept(i) = merge(1.0_wp, 0.0_wp, length(i) >= least)
      end do
      call replace_lanes(kept, 1.0_wp, length)
      call turn_attitudes(cosine, sine, axis, l, length, q, y)
      call keep_attitudes(y, l, kept, q, p)
      do i = 1, lanes
         given_up(i) = max(given_up(i), 1 - kept(i))
      end do
   end subroutine turn_free_lanes

   !> q∘about∘shortest.
   pure subroutine turn_attitudes(cosine, sine, axis, l, length, q, y)
      real(wp), intent(in) :: cosine(lanes), sine(lanes), axis(lanes, 3), l(lanes, 3), length(lanes), q(lanes, 4)
      real(wp), intent(out) :: y(lanes, 4)
      real(wp) :: u1, u2, u3, s1, s2, s3, s4, a1, a2, a3, a4, c1, c2, c3, c4
      integer :: i
      do i = 1, lanes
         u1 = l(i, 1)/length(i)
         u2 = l(i, 2)/length(i)
         u3 = l(i, 3)/length(i)
         s1 = 1 + (u1*axis(i, 1) + u2*axis(i, 2) + u3*axis(i, 3))
         s2 = u2*axis(i, 3) - u3*axis(i, 2)
         s3 = u3*axis(i, 1) - u1*axis(i, 3)
         s4 = u1*axis(i, 2) - u2*axis(i, 1)
         a1 = cosine(i)
         a2 = sine(i)*axis(i, 1)
         a3 = sine(i)*axis(i, 2)
         a4 = sine(i)*axis(i, 3)
         c1 = a1*s1 - a2*s2 - a3*s3 - a4*s4
         c2 = a1*s2 + a2*s1 + a3*s4 - a4*s3
         c3 = a1*s3 - a2*s4 + a3*s1 + a4*s2
         c4 = a1*s4 + a2*s3 - a3*s2 + a4*s1
         y(i, 1) = q(i, 1)*c1 - q(i, 2)*c2 - q(i, 3)*c3 - q(i, 4)*c4
         y(i, 2) = q(i, 1)*c2 + q(i, 2)*c1 + q(i, 3)*c4 - q(i, 4)*c3
         y(i, 3) = q(i, 1)*c3 - q(i, 2)*c4 + q(i, 3)*c1 + q(i, 4)*c2
         y(i, 4) = q(i, 1)*c4 + q(i, 2)*c3 - q(i, 3)*c2 + q(i, 4)*c1
      end do
   end subroutine turn_attitudes

   !> q = y/|y|, p = 2 q∘[0, L]; lanes without a direction keep what they have.
   pure subroutine keep_attitudes(y, l, kept, q, p)
      real(wp), intent(in) :: y(lanes, 4), l(lanes, 3)
      !> 1: yes.
      real(wp), intent(inout) :: kept(lanes)
      real(wp), intent(inout) :: q(lanes, 4), p(lanes, 4)
      real(wp) :: square(lanes), has_length(lanes), factor, l1, l2, l3
      integer :: i
      do i = 1, lanes
         square(i) = y(i, 1)*y(i, 1) + y(i, 2)*y(i, 2) + y(i, 3)*y(i, 3) + y(i, 4)*y(i, 4)
         has_length(i) = merge(1.0_wp, 0.0_wp, square(i) > tiny(1.0_wp))
      end do
      call replace_lanes(has_length, 1.0_wp, square)
      do i = 1, lanes
         kept(i) = kept(i)*has_length(i)
         factor = 1/sqrt(square(i))
         q(i, 1) = factor*y(i, 1)
         q(i, 2) = factor*y(i, 2)
         q(i, 3) = factor*y(i, 3)
         q(i, 4) = factor*y(i, 4)
         l1 = 2*l(i, 1)
         l2 = 2*l(i, 2)
         l3 = 2*l(i, 3)
         p(i, 1) = -(q(i, 2)*l1 + q(i, 3)*l2 + q(i, 4)*l3)
         p(i, 2) = q(i, 1)*l1 + q(i, 3)*l3 - q(i, 4)*l2
         p(i, 3) = q(i, 1)*l2 + q(i, 4)*l1 - q(i, 2)*l3
         p(i, 4) = q(i, 1)*l3 + q(i, 2)*l2 - q(i, 3)*l1
      end do
   end subroutine keep_attitudes

end module nutate_lane_free_body
