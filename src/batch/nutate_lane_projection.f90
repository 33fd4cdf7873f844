!> The projection onto the invariants of several bodies at once: one body a lane, each with its own numbers.
!>
!> The arithmetic is that of `nutate_invariant_projection`. A lane whose move would be too long, or where there is too
!> little to remove for the way to be known, is given up.
module nutate_lane_projection
   use nutate_invariant_projection, only: doubtful, longest, longest_doubtful, most_moves, negligible, round_off
   use nutate_invariants, only: ALONG_AXIS
   use nutate_kinds, only: wp
   use nutate_lane_choice, only: choose_lanes, replace_lanes
   use nutate_lane_energies, only: add_gradient, add_rotor, add_weight, find_energies, find_full_sizes, find_pushes, &
      push_momenta, restore_component, compute_momenta, turn_momenta, turn_momenta_little, turn_rates
   use nutate_lane_potentials, only: lane_potentials_t, make_room, put_potentials, rest_potentials
   use nutate_lane_vectors, only: find_full_rates, turn_back, write_momenta
   use nutate_lane_width, only: lanes
   use nutate_momentum_target, only: momentum_target_t
   use nutate_projection_point, only: nearly_unit, projection_plan_t, projection_point_t, read_point
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: lane_projection_t, set_up_targets, put_target, rest_target, project_lanes

   !> What each body is projected to.
   type :: lane_projection_t
      private
      !> Some body has been taken: all others are like it. J is diagonal; there are rotors.
      logical :: begun = .false., diagonal = .true., has_rotor = .false.
      !> Of l not all is conserved, but the component along a direction n, or none; there are potentials linear in n.
      logical :: pushes = .false., along = .false., has_weight = .false.
      !> All other potentials.
      type(lane_potentials_t) :: others
      !> J⁻¹, kg⁻¹ m⁻², shape (lanes, 3, 3); l, space axes, N m s, or n; shape (lanes, 3).
      real(wp) :: inverse(lanes, 3, 3) = 0.0_wp, target(lanes, 3) = 0.0_wp
      !> Momentum of rotors, body axes, N m s, and its length; shape (lanes, 3).
      real(wp) :: rotor(lanes, 3) = 0.0_wp, rotor_length(lanes) = 0.0_wp
      !> l·n, N m s, and ∇U, J; shape (lanes, 3).
      real(wp) :: component(lanes) = 0.0_wp, slope(lanes, 3) = 0.0_wp
      !> H, J.
      real(wp) :: energy(lanes) = 0.0_wp
      !> Largest T + Σ|U| so far, J; the largest of it and |L̇|, and the power of two that brings that to order one.
      real(wp) :: size(lanes) = 0.0_wp, largest(lanes) = 0.0_wp, to_order_one(lanes) = 1.0_wp
   end type lane_projection_t

   !> Bodies under way to their energy. No component has a first value: they would be set at every projection.
   type :: lane_points_t
      !> q, L, body axes, N m s; shapes (lanes, 4) and (lanes, 3).
      real(wp) :: q(lanes, 4), momentum(lanes, 3)
      !> H and T + Σ|U|, J, and L̇, N m; shape (lanes, 3).
      real(wp) :: energy(lanes), size(lanes), rate(lanes, 3)
      !> γ; Ω and, behind the slope, its part across γ, rad/s; what that is multiplied by, kg m²; shape (lanes, 3).
      real(wp) :: gamma(lanes, 3), omega(lanes, 3), inertia(lanes)
      !> 2T, J.
      real(wp) :: twice_kinetic(lanes)
      !> 1: to be moved by c down the slope, and that is the last move.
      real(wp) :: moving(lanes), little(lanes), c(lanes)
   end type lane_points_t

contains

   !> For bodies that are to come, the first of which says what is conserved.
   pure subroutine set_up_targets(self)
      type(lane_projection_t), intent(inout) :: self
      self%begun = .false.
      self%pushes = .false.
      self%along = .false.
      call make_room(self%others, 0)
   end subroutine set_up_targets

   !> Computes the invariants of a body from its first state.
   pure subroutine put_target(self, lane, system, state, fits)
      type(lane_projection_t), intent(inout) :: self
      integer, intent(in) :: lane
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> False: other things are conserved.
      logical, intent(out) :: fits
      type(projection_plan_t) :: plan
      type(projection_point_t) :: point
      type(momentum_target_t) :: target
      call plan%prepare(system, .true.)
      if (.not. self%begun) call begin_targets(self, plan)
      fits = (plan%pushes .eqv. self%pushes) .and. ((plan%components == ALONG_AXIS) .eqv. self%along) .and. &
             (plan%diagonal .eqv. self%diagonal) .and. (plan%has_rotor .eqv. self%has_rotor) .and. &
             (plan%has_weight .eqv. self%has_weight)
      if (fits) call put_potentials(self%others, lane, system%effects, plan%others, fits)
      if (.not. fits) return
      call read_point(plan, system%effects, state, point)
      call target%set(plan%components, point)
      self%target(lane, :) = merge(plan%axis, target%momentum, self%along)
      self%component(lane) = target%component
      self%slope(lane, :) = -plan%weight
      self%inverse(lane, :, :) = plan%inverse_inertia
      self%rotor(lane, :) = plan%rotor
      self%rotor_length(lane) = plan%rotor_length
      self%energy(lane) = point%energy
      self%size(lane) = point%size
      self%largest(lane) = max(point%size, abs(point%rate(1)), abs(point%rate(2)), abs(point%rate(3)))
      self%to_order_one(lane) = unit_of(self%largest(lane))
   end subroutine put_target

   !> All bodies are like the first one.
   pure subroutine begin_targets(self, plan)
      type(lane_projection_t), intent(inout) :: self
      type(projection_plan_t), intent(in) :: plan
      self%begun = .true.
      self%diagonal = plan%diagonal
      self%has_rotor = plan%has_rotor
      self%pushes = plan%pushes
      self%along = plan%components == ALONG_AXIS
      self%has_weight = plan%has_weight
      call make_room(self%others, size(plan%others))
   end subroutine begin_targets

   !> A power of two that brings a number to order one.
   pure real(wp) function unit_of(largest)
      real(wp), intent(in) :: largest
      unit_of = scale(1.0_wp, -max(exponent(largest), -1000))
   end function unit_of

   !> A sphere that turns about axis 3.
   pure subroutine rest_target(self, lane)
      type(lane_projection_t), intent(inout) :: self
      integer, intent(in) :: lane
      integer :: i
      self%inverse(lane, :, :) = 0.0_wp
      do i = 1, 3
         self%inverse(lane, i, i) = 1.0_wp
      end do
      self%rotor(lane, :) = 0.0_wp
      self%rotor_length(lane) = 0.0_wp
      self%target(lane, :) = [0.0_wp, 0.0_wp, 1.0_wp]
      self%component(lane) = 1.0_wp
      self%slope(lane, :) = 0.0_wp
      call rest_potentials(self%others, lane)
      self%energy(lane) = 0.5_wp
      self%size(lane) = 0.5_wp
      self%largest(lane) = 0.5_wp
      self%to_order_one(lane) = 1.0_wp
   end subroutine rest_target

   !> Projects states, of which other lanes keep theirs.
   pure subroutine project_lanes(self, due, q, p, given_up)
      type(lane_projection_t), intent(inout) :: self
      !> 1: to be projected.
      real(wp), intent(in) :: due(lanes)
      !> Shape (lanes, 4).
      real(wp), intent(inout) :: q(lanes, 4), p(lanes, 4)
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      type(lane_points_t) :: points
      real(wp) :: pending(lanes), lost(lanes), new_p(lanes, 4)
      integer :: move
      pending = due
      call normalise_attitudes(q, points%q, lost)
      if (self%pushes) then
         call compute_momenta(q, p, points%momentum)
      else
         call turn_back(points%q, self%target, points%momentum)
      end if
      if (self%along) then
         call turn_back(points%q, self%target, points%gamma)
         call restore_component(self%component, points%gamma, points%momentum)
      end if
      do move = 1, most_moves
         call evaluate_lanes(self, points)
         call note_sizes(self, pending, points)
         call measure(self, pending, points, lost)
         call find_pending(points, pending)
         if (.not. maxval(points%moving) > 0.5_wp) exit
         call move_points(self, points)
      end do
      call give_up_lanes(due, lost, pending, given_up)
      call write_momenta(points%q, points%momentum, new_p)
      do move = 1, 4
         call choose_lanes(due, points%q(:, move), q(:, move))
         call choose_lanes(due, new_p(:, move), p(:, move))
      end do
   end subroutine project_lanes

   !> q normalised, as a step leaves it: all but a unit one; others are lost.
   pure subroutine normalise_attitudes(q, unit, lost)
      real(wp), intent(in) :: q(lanes, 4)
      real(wp), intent(out) :: unit(lanes, 4)
      !> 1: yes.
      real(wp), intent(out) :: lost(lanes)
      real(wp) :: square, factor
      integer :: i
      do i = 1, lanes
         square = (q(i, 1)*q(i, 1) + q(i, 2)*q(i, 2)) + (q(i, 3)*q(i, 3) + q(i, 4)*q(i, 4))
         factor = 1.5_wp - 0.5_wp*square
         unit(i, 1) = factor*q(i, 1)
         unit(i, 2) = factor*q(i, 2)
         unit(i, 3) = factor*q(i, 3)
         unit(i, 4) = factor*q(i, 4)
         lost(i) = merge(0.0_wp, 1.0_wp, abs(square - 1) <= nearly_unit)
      end do
   end subroutine normalise_attitudes

   !> Ω, H, the size of its terms and L̇.
   pure subroutine evaluate_lanes(self, points)
      type(lane_projection_t), intent(in) :: self
      type(lane_points_t), intent(inout) :: points
      real(wp) :: x(lanes, 3), gamma(lanes, 3)
      integer :: k
      x = points%momentum
      if (self%has_rotor) x = x - self%rotor
      if (self%diagonal) then
         call turn_rates(self%inverse, x, points%omega)
         call find_energies(x, points%momentum, points%omega, points%twice_kinetic, points%energy, points%rate)
         points%size = points%energy
      else
         call find_full_rates(self%inverse, x, points%omega)
         call find_energies(x, points%momentum, points%omega, points%twice_kinetic, points%energy, points%rate)
         call find_full_sizes(self%inverse, x, points%size)
      end if
      if (self%has_rotor) call add_rotor(self%rotor_length, points%omega, points%size)
      if (self%has_weight) call add_weight(self%slope, points%gamma, points%energy, points%size, points%rate)
      do k = 1, self%others%n
         call turn_back(points%q, self%others%normal(:, :, k), gamma)
         if (self%others%is_quadratic(k)) then
            call add_gradient(self%others%stiffness(:, :, :, k), self%others%offset(:, k), gamma, points%energy, &
                              points%size, points%rate)
         else
            call add_weight(self%others%slope(:, :, k), gamma, points%energy, points%size, points%rate)
         end if
      end do
   end subroutine evaluate_lanes

   !> Keeps the largest energies of the lanes that are pending.
   pure subroutine note_sizes(self, pending, points)
      type(lane_projection_t), intent(inout) :: self
      real(wp), intent(in) :: pending(lanes)
      type(lane_points_t), intent(in) :: points
      real(wp) :: largest(lanes), above(lanes)
      integer :: lane
      call find_largest(pending, points%size, points%rate, self%largest, self%size, largest, above)
      if (.not. maxval(above) > 0.5_wp) return
      do lane = 1, lanes
         if (above(lane) < 0.5_wp) cycle
         self%largest(lane) = largest(lane)
         self%to_order_one(lane) = unit_of(largest(lane))
      end do
   end subroutine note_sizes

   !> The largest of energies and rates, and where it is above the one so far.
   pure subroutine find_largest(pending, energy, rate, before, size, largest, above)
      real(wp), intent(in) :: pending(lanes), energy(lanes), rate(lanes, 3), before(lanes)
      !> Largest energy so far.
      real(wp), intent(inout) :: size(lanes)
      real(wp), intent(out) :: largest(lanes)
      !> 1: yes.
      real(wp), intent(out) :: above(lanes)
      real(wp) :: new(lanes)
      integer :: i
      do i = 1, lanes
         new(i) = max(size(i), energy(i))
         largest(i) = max(max(energy(i), abs(rate(i, 1))), max(abs(rate(i, 2)), abs(rate(i, 3))))
         above(i) = merge(1.0_wp, 0.0_wp, largest(i) > before(i))
      end do
      call choose_lanes(pending, new, size)
      do i = 1, lanes
         above(i) = pending(i)*above(i)
      end do
   end subroutine find_largest

   !> How far each body is to be moved.
   pure subroutine measure(self, pending, points, lost)
      type(lane_projection_t), intent(in) :: self
      real(wp), intent(in) :: pending(lanes)
      type(lane_points_t), intent(inout) :: points
      !> 1: too far.
      real(wp), intent(inout) :: lost(lanes)
      real(wp), dimension(lanes) :: steepness, excess, differs, settled, far
      call find_slopes(self%to_order_one, self%energy, self%size, points%energy, points%rate, steepness, excess, &
                       differs)
      if (self%pushes) call find_pushes(self%along, self%to_order_one, points%twice_kinetic, points%gamma, &
                                        points%omega, points%inertia, steepness)
      call judge_lanes(self%to_order_one, self%size, steepness, excess, differs, settled, far, points%little)
      call sort_lanes(pending, settled, far, lost, points%moving)
      points%c = excess
      call replace_lanes(points%moving, 1.0_wp, steepness)
      call replace_lanes(points%moving, 0.0_wp, points%c)
      call divide_lanes(steepness, points%c)
   end subroutine measure

   !> The excess of energy and the slope of the rotation, both brought to order one, and where there is an excess.
   pure subroutine find_slopes(to_order_one, target, size, energy, rate, steepness, excess, differs)
      real(wp), dimension(lanes), intent(in) :: to_order_one, target, size, energy
      real(wp), intent(in) :: rate(lanes, 3)
      !> |L̇|²
      real(wp), dimension(lanes), intent(out) :: steepness, excess
      !> 1: yes.
      real(wp), dimension(lanes), intent(out) :: differs
      real(wp) :: r1, r2, r3, e
      integer :: i
      do i = 1, lanes
         e = energy(i) - target(i)
         differs(i) = 1 - merge(1.0_wp, 0.0_wp, abs(e) <= round_off*size(i))
         r1 = to_order_one(i)*rate(i, 1)
         r2 = to_order_one(i)*rate(i, 2)
         r3 = to_order_one(i)*rate(i, 3)
         steepness(i) = r1*r1 + r2*r2 + r3*r3
         excess(i) = to_order_one(i)*e
      end do
   end subroutine find_slopes

   !> Where nothing is to be done, where that is too far, and where the move is so short that its square is round-off.
   pure subroutine judge_lanes(to_order_one, size, steepness, excess, differs, settled, far, little)
      real(wp), dimension(lanes), intent(in) :: to_order_one, size, steepness, excess, differs
      !> 1: yes.
      real(wp), dimension(lanes), intent(out) :: settled, far, little
      real(wp) :: square, long(lanes)
      integer :: i
      do i = 1, lanes
         square = excess(i)*excess(i)
         long(i) = 1 - merge(1.0_wp, 0.0_wp, square < longest_doubtful*steepness(i))
         settled(i) = merge(1.0_wp, 0.0_wp, abs(excess(i)) <= doubtful*(to_order_one(i)*size(i)))
         far(i) = 1 - merge(1.0_wp, 0.0_wp, square < longest*steepness(i))
         little(i) = merge(1.0_wp, 0.0_wp, square <= negligible*steepness(i))
      end do
      do i = 1, lanes
         settled(i) = 1 - differs(i)*(1 - long(i)*settled(i))
         far(i) = long(i)*far(i)
      end do
   end subroutine judge_lanes

   !> Which of the bodies that are pending are to be moved.
   pure subroutine sort_lanes(pending, settled, far, lost, moving)
      real(wp), dimension(lanes), intent(in) :: pending, settled, far
      real(wp), intent(inout) :: lost(lanes)
      real(wp), intent(out) :: moving(lanes)
      real(wp) :: open
      integer :: i
      do i = 1, lanes
         open = pending(i)*(1 - settled(i))
         lost(i) = max(lost(i), open*far(i))
         moving(i) = open*(1 - far(i))
      end do
   end subroutine sort_lanes

   pure subroutine divide_lanes(divisor, x)
      real(wp), intent(in) :: divisor(lanes)
      real(wp), intent(inout) :: x(lanes)
      integer :: i
      do i = 1, lanes
         x(i) = x(i)/divisor(i)
      end do
   end subroutine divide_lanes

   !> Moves bodies down their slopes, by δ = cL̇ at fixed l and by ΔL: those whose move is little with its first term,
   !> others by the Cayley map.
   pure subroutine move_points(self, points)
      type(lane_projection_t), intent(in) :: self
      type(lane_points_t), intent(inout) :: points
      real(wp) :: q(lanes, 4), momentum(lanes, 3), pushed(lanes, 3), half(lanes)
      integer :: k
      half = 0.0_wp
      if (maxval(points%moving - points%little) > 0.5_wp) half = 1 - points%little
      call turn_little(self%to_order_one, points%c, points%rate, points%q, q)
      if (maxval(half) > 0.5_wp) call normalise_turns(half, self%to_order_one, points%c, points%rate, q)
      if (self%pushes) then
         pushed = points%momentum
         call push_momenta(points%c, points%inertia, points%omega, pushed)
         call turn_momenta_little(points%c, self%to_order_one, points%rate, pushed, momentum)
         if (maxval(half) > 0.5_wp) call turn_momenta(half, points%c, self%to_order_one, points%rate, pushed, momentum)
         if (self%along) call turn_back(q, self%target, points%gamma)
      else
         call turn_back(q, self%target, momentum)
      end if
      do k = 1, 4
         call choose_lanes(points%moving, q(:, k), points%q(:, k))
      end do
      do k = 1, 3
         call choose_lanes(points%moving, momentum(:, k), points%momentum(:, k))
      end do
   end subroutine move_points

   !> q + q∘b, b = ½cL̇.
   pure subroutine turn_little(to_order_one, c, rate, q, turned)
      real(wp), intent(in) :: to_order_one(lanes), c(lanes), rate(lanes, 3), q(lanes, 4)
      real(wp), intent(out) :: turned(lanes, 4)
      real(wp) :: h, b1, b2, b3
      integer :: i
      do i = 1, lanes
         h = 0.5_wp*c(i)
         b1 = h*(to_order_one(i)*rate(i, 1))
         b2 = h*(to_order_one(i)*rate(i, 2))
         b3 = h*(to_order_one(i)*rate(i, 3))
         turned(i, 1) = q(i, 1) + (-(q(i, 2)*b1 + q(i, 3)*b2 + q(i, 4)*b3))
         turned(i, 2) = q(i, 2) + (q(i, 1)*b1 + q(i, 3)*b3 - q(i, 4)*b2)
         turned(i, 3) = q(i, 3) + (q(i, 1)*b2 + q(i, 4)*b1 - q(i, 2)*b3)
         turned(i, 4) = q(i, 4) + (q(i, 1)*b3 + q(i, 2)*b2 - q(i, 3)*b1)
      end do
   end subroutine turn_little

   !> Divides by √(1 + |b|²) in some lanes.
   pure subroutine normalise_turns(chosen, to_order_one, c, rate, q)
      !> 1: yes.
      real(wp), intent(in) :: chosen(lanes), to_order_one(lanes), c(lanes), rate(lanes, 3)
      real(wp), intent(inout) :: q(lanes, 4)
      real(wp) :: h, b1, b2, b3, factor(lanes)
      integer :: i, k
      do i = 1, lanes
         h = 0.5_wp*c(i)
         b1 = h*(to_order_one(i)*rate(i, 1))
         b2 = h*(to_order_one(i)*rate(i, 2))
         b3 = h*(to_order_one(i)*rate(i, 3))
         factor(i) = 1/sqrt(1 + (b1*b1 + b2*b2 + b3*b3))
      end do
      call replace_lanes(chosen, 1.0_wp, factor)
      do k = 1, 4
         do i = 1, lanes
            q(i, k) = factor(i)*q(i, k)
         end do
      end do
   end subroutine normalise_turns

   !> Bodies whose move was not the last one are to be looked at again.
   pure subroutine find_pending(points, pending)
      type(lane_points_t), intent(in) :: points
      real(wp), intent(inout) :: pending(lanes)
      integer :: i
      do i = 1, lanes
         pending(i) = points%moving(i)*(1 - points%little(i))
      end do
   end subroutine find_pending

   !> Gives up what is lost, or still pending after the last move.
   pure subroutine give_up_lanes(due, lost, pending, given_up)
      real(wp), dimension(lanes), intent(in) :: due, lost, pending
      real(wp), intent(inout) :: given_up(lanes)
      integer :: i
      do i = 1, lanes
         given_up(i) = max(given_up(i), due(i)*max(lost(i), pending(i)))
      end do
   end subroutine give_up_lanes

end module nutate_lane_projection
