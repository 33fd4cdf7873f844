!> Several bodies moved together by the reduced form of the conserving step, of order 2 or composed to 4, 6 or 8: free
!> bodies, with rotors, linear potentials (weight, dipoles, constant fields), gradients of gravity, or without.
!>
!>     call bodies%set_up(order, dt, potentials)
!>     call bodies%put(lane, system, state)
!>     call bodies%step()
!>     call bodies%get(lane, state)
!>
!> A body that is `taken` has the bits that the scalar stepper gives it, whoever stands in the other lanes. A step is
!> taken where the root is proved to be that of the true motion by its |b| and a positive determinant, as in most steps
!> of the scalar stepper (`nutate_root_proof`); a body of which that does not hold is given up, is no longer `taken`,
!> and has to be run by the scalar stepper from its start.
module nutate_reduced_lanes
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_composition, only: compositions
   use nutate_implicit_step, only: kept_after_surprise
   use nutate_kinds, only: wp
   use nutate_lane_bodies, only: lane_bodies_t
   use nutate_lane_loads, only: lane_loads_t
   use nutate_lane_newton, only: begin_iteration, correct_again, correct_first, iteration_t, take_residuals
   use nutate_lane_potentials, only: are_lane_potentials
   use nutate_lane_step, only: explicit_lanes, greatest_momentum, measure_turns, predict_lanes, start_lanes, turn_lanes
   use nutate_lane_width, only: lanes
   use nutate_predictor, only: most_steps, weights
   use nutate_reduced, only: slow
   use nutate_root_proof, only: root_proof_t
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: reduced_lanes_t, can_be_lanes, lanes

   !> Iterations after which a lane that is not done is given up.
   integer, parameter :: most_iterations = 8
   !> Numbers of a body that a lane takes: products of several stay in the range of numbers.
   real(wp), parameter :: least = 1e-40_wp, greatest = 1e40_wp
   !> Torques in the units of the step above belong to no step that a lane takes.
   real(wp), parameter :: greatest_torque = 1e3_wp
   !> |b| of a free body's root above this is left to the scalar stepper: below 0.41 one with a positive determinant is
   !> that of the true motion.
   real(wp), parameter :: longest = 0.4_wp

   !> What belongs to one stage of a step.
   type :: stage_t
      !> s.
      real(wp) :: dt = 0.0_wp
      !> Δt/4s, ½Δt²/4s, and the momentum of rotors in the units of the step; shape (lanes, 3).
      real(wp) :: scale(lanes) = 0.0_wp, weight(lanes) = 0.0_wp, rotor(lanes, 3) = 0.0_wp
      !> |b|² below which a root with a positive determinant is the true one.
      real(wp) :: near(lanes) = 0.0_wp
      !> Steps known, their roots, each in the place of the one that is forgotten, and the place of the latest; shape
      !> (lanes, 3, steps).
      integer :: known(lanes) = 0
      !> All lanes know as many as there is room for.
      logical :: knows_all = .false.
      real(wp) :: past(lanes, 3, 0:most_steps - 1) = 0.0_wp
      integer :: latest = 0
      !> The potentials' part of the Jacobian, shape (lanes, 3, 3), and 1: it is worth keeping.
      real(wp) :: by_forces(lanes, 3, 3) = 0.0_wp, kept(lanes) = 0.0_wp
      !> The largest of its numbers, at least 1.
      real(wp) :: stiffness(lanes) = 1.0_wp
   end type stage_t

   !> The bodies, each a lane.
   type, extends(lane_bodies_t) :: reduced_lanes_t
      private
      !> 1: the lane has no body.
      real(wp) :: idle(lanes) = 1.0_wp
      type(stage_t), allocatable :: stages(:)
      !> Shapes (lanes, 4).
      real(wp) :: q(lanes, 4) = 0.0_wp, p(lanes, 4) = 0.0_wp, q_lost(lanes, 4) = 0.0_wp, p_lost(lanes, 4) = 0.0_wp
      !> J over its largest diagonal entry; J⁻¹, kg⁻¹ m⁻²; shapes (lanes, 3, 3).
      real(wp) :: inertia(lanes, 3, 3) = 0.0_wp, inverse(lanes, 3, 3) = 0.0_wp
      !> Momentum of rotors, body axes, N m s; shape (lanes, 3).
      real(wp) :: rotor(lanes, 3) = 0.0_wp
      type(lane_loads_t) :: loads
      type(root_proof_t) :: proof
   contains
      !> Empties all lanes, for steps of a length.
      procedure :: set_up
      procedure :: put
      procedure :: step
      procedure :: get
   end type reduced_lanes_t

contains

   !> True if lanes can move a system: nothing acts on it but rotors, linear potentials and gradients of gravity.
   pure logical function can_be_lanes(system)
      type(system_t), intent(in) :: system
      associate (effects => system%effects)
         can_be_lanes = effects%n_torques + effects%n_off + effects%n_wheels == 0 .and. .not. effects%frame_turns
         if (can_be_lanes) can_be_lanes = are_lane_potentials(effects)
      end associate
   end function can_be_lanes

   !> Empties all lanes, for steps of a length.
   pure subroutine set_up(self, order, dt, potentials)
      class(reduced_lanes_t), intent(inout) :: self
      !> 2, 4, 6 or 8.
      integer, intent(in) :: order
      !> s.
      real(wp), intent(in) :: dt
      !> Of each body.
      integer, intent(in) :: potentials
      integer :: i, k, n
      if (allocated(self%stages)) deallocate (self%stages)
      if (order == 2) then
         allocate (self%stages(1))
         self%stages(1)%dt = dt
      else
         k = findloc(compositions%order, order, dim=1)
         n = compositions(k)%stages
         allocate (self%stages(n))
         do i = 1, n
            self%stages(i)%dt = compositions(k)%weights(min(i, n + 1 - i))*dt
         end do
      end if
      call self%loads%set_up(potentials)
      do k = 1, lanes
         call rest(self, k)
      end do
   end subroutine set_up

   !> A lane without a body: a sphere at rest, whose numbers disturb nobody.
   pure subroutine rest(self, lane)
      class(reduced_lanes_t), intent(inout) :: self
      integer, intent(in) :: lane
      integer :: k
      self%taken(lane) = .false.
      self%idle(lane) = 1.0_wp
      self%q(lane, :) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      self%p(lane, :) = 0.0_wp
      self%q_lost(lane, :) = 0.0_wp
      self%p_lost(lane, :) = 0.0_wp
      self%inertia(lane, :, :) = 0.0_wp
      self%inverse(lane, :, :) = 0.0_wp
      self%rotor(lane, :) = 0.0_wp
      do k = 1, 3
         self%inertia(lane, k, k) = 1.0_wp
         self%inverse(lane, k, k) = 1.0_wp
      end do
      do k = 1, size(self%stages)
         self%stages(k)%scale(lane) = 0.0_wp
         self%stages(k)%weight(lane) = 0.0_wp
         self%stages(k)%rotor(lane, :) = 0.0_wp
         self%stages(k)%near(lane) = longest**2
         self%stages(k)%past(lane, :, :) = 0.0_wp
         self%stages(k)%by_forces(lane, :, :) = 0.0_wp
         self%stages(k)%kept(lane) = 0.0_wp
         self%stages(k)%stiffness(lane) = 1.0_wp
      end do
      call self%loads%rest(lane)
   end subroutine rest

   !> Puts a body into a lane, before the first step; it is not `taken` where its numbers are out of a lane's range.
   subroutine put(self, lane, system, state)
      !> Set up.
      class(reduced_lanes_t), intent(inout) :: self
      !> 1 to `lanes`.
      integer, intent(in) :: lane
      !> One that lanes can move.
      type(system_t), intent(in) :: system
      !> |q| = 1 and q·p = 0.
      type(state_t), intent(in) :: state
      real(wp) :: largest, torque
      call rest(self, lane)
      if (.not. is_in_range(self, system, state)) return
      associate (j => system%body%inertia)
         largest = max(j(1, 1), j(2, 2), j(3, 3))
         self%inertia(lane, :, :) = j/largest
      end associate
      self%q(lane, :) = state%q
      self%p(lane, :) = state%p
      self%q_lost(lane, :) = state%q_compensation
      self%p_lost(lane, :) = state%p_compensation
      self%inverse(lane, :, :) = system%body%inverse_inertia
      self%rotor(lane, :) = system%effects%rotor_momentum
      call self%loads%put(lane, system%effects, torque, self%taken(lane))
      call put_stages(self, lane, system, largest, torque)
      if (.not. self%taken(lane)) call rest(self, lane)
      if (self%taken(lane)) self%idle(lane) = 0.0_wp
   end subroutine put

   !> True if the numbers of a body are those of a step that lanes can take.
   pure logical function is_in_range(self, system, state)
      type(reduced_lanes_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: momentum
      is_in_range = all(ieee_is_finite([state%q, state%p]))
      if (.not. is_in_range) return
      momentum = maxval(abs(state%p))
      is_in_range = all(abs(state%q) <= 2.0_wp) .and. momentum <= greatest .and. &
                    .not. (momentum > 0.0_wp .and. momentum < least) .and. &
                    minval(system%body%moments) >= least .and. maxval(system%body%moments) <= greatest .and. &
                    .not. system%body%breaks_triangle .and. &
                    all(abs(self%stages%dt) >= least .and. abs(self%stages%dt) <= greatest)
   end function is_in_range

   !> What of a body belongs to the stages. The lane is not taken where rotors or potentials are out of scale.
   subroutine put_stages(self, lane, system, largest, torque)
      type(reduced_lanes_t), intent(inout) :: self
      integer, intent(in) :: lane
      type(system_t), intent(in) :: system
      !> Of the diagonal of J, kg m², and a bound of the torque, N m.
      real(wp), intent(in) :: largest, torque
      real(wp), parameter :: at_rest(3) = 0.0_wp
      logical :: is_free, holds
      integer :: i
      is_free = system%effects%n_potentials + system%effects%n_rotors == 0
      if (.not. is_free) call self%proof%set_up(system)
      do i = 1, size(self%stages)
         associate (stage => self%stages(i), dt => self%stages(i)%dt)
            stage%scale(lane) = 0.25_wp*dt/largest
            stage%weight(lane) = 0.5_wp*dt*stage%scale(lane)
            stage%rotor(lane, :) = stage%scale(lane)*self%rotor(lane, :)
            if (is_free) cycle
            ! The same for all states: what the scalar stepper asks for before anything else.
            holds = self%proof%holds(system, dt, 0.0_wp, at_rest, at_rest, 1.0_wp)
            stage%near(lane) = merge(self%proof%near, 0.0_wp, holds)
            if (.not. (maxval(abs(stage%rotor(lane, :))) <= greatest_momentum .and. &
                       stage%weight(lane)*torque <= greatest_torque)) self%taken(lane) = .false.
         end associate
      end do
   end subroutine put_stages

   !> One step of all bodies.
   pure subroutine step(self)
      class(reduced_lanes_t), intent(inout) :: self
      real(wp) :: given_up(lanes)
      logical :: any_lost
      integer :: lane, stage
      do stage = 1, size(self%stages)
         given_up = self%idle
         call take_stage(self, self%stages(stage), given_up, any_lost)
         if (.not. any_lost) cycle
         do lane = 1, lanes
            if (self%taken(lane) .and. given_up(lane) > 0.5_wp) call rest(self, lane)
         end do
      end do
   end subroutine step

   !> One stage of a step.
   pure subroutine take_stage(self, stage, given_up, any_lost)
      type(reduced_lanes_t), intent(inout) :: self
      type(stage_t), intent(inout) :: stage
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      !> Some lane has been given up.
      logical, intent(out) :: any_lost
      type(iteration_t) :: at
      real(wp) :: frame(lanes, 4), half(lanes, 3), momentum(lanes, 3)
      logical :: late(lanes)
      call start_lanes(self%q, self%p, stage%scale, frame, half, momentum, given_up)
      if (self%loads%n > 0) call self%loads%start(frame)
      if (stage%knows_all .or. maxval(stage%known) > 0) then
         associate (x => stage%past, k => stage%latest, n => most_steps)
            call predict_lanes(stage%known, stage%knows_all, weights, x(:, :, k), x(:, :, modulo(k - 1, n)), &
                               x(:, :, modulo(k - 2, n)), x(:, :, modulo(k - 3, n)), x(:, :, modulo(k - 4, n)), &
                               x(:, :, modulo(k - 5, n)), at%z)
         end associate
      else
         call explicit_lanes(0.25_wp*stage%dt, self%inverse, half, self%rotor, at%z, given_up)
      end if
      call solve(self, stage, momentum, at, given_up, late)
      call finish(self, stage, frame, at, given_up)
      stage%latest = modulo(stage%latest + 1, most_steps)
      stage%past(:, :, stage%latest) = at%z
      if (.not. stage%knows_all) then
         stage%known = min(stage%known + 1, most_steps)
         stage%knows_all = minval(stage%known) == most_steps
      end if
      any_lost = any(given_up > self%idle)
      if (.not. at%is_late) return
      where (late)
         stage%known = min(stage%known, kept_after_surprise)
         stage%kept = 0.0_wp
      end where
      stage%knows_all = .false.
   end subroutine take_stage

   !> The modified Newton iteration, until every lane is done or given up.
   pure subroutine solve(self, stage, momentum, at, given_up, late)
      type(reduced_lanes_t), intent(inout) :: self
      type(stage_t), intent(inout) :: stage
      !> L0 in the units of the step; shape (lanes, 3).
      real(wp), intent(in) :: momentum(lanes, 3)
      !> With the prediction.
      type(iteration_t), intent(inout) :: at
      real(wp), intent(inout) :: given_up(lanes)
      !> Lanes of which the prediction was bad; where there are any.
      logical, intent(out) :: late(lanes)
      logical :: is_cubic
      integer :: k
      is_cubic = self%loads%n == 0
      call begin_iteration(at)
      do k = 1, most_iterations
         if (k == slow + 1) then
            at%is_late = .true.
            late = at%done < 0.5_wp
         end if
         call take_residuals(self%inertia, momentum, stage%rotor, at%z, at%mean, at%change, at%rest, at%f)
         if (.not. is_cubic) then
            call self%loads%add_to_residuals(stage%weight, at)
            if (at%is_coarse) call self%loads%linearize(stage%weight, at, stage%kept, stage%by_forces, stage%stiffness)
         end if
         if (k == 1) then
            call correct_first(is_cubic, self%inertia, stage%by_forces, at, given_up)
         else
            call correct_again(is_cubic, self%inertia, stage%by_forces, at, stage%kept, given_up)
         end if
         if (.not. at%goes_on) return
      end do
      where (at%done < 0.5_wp) given_up = 1.0_wp
   end subroutine solve

   !> Moves the states, as `finish` of the scalar equations does.
   pure subroutine finish(self, stage, frame, at, given_up)
      type(reduced_lanes_t), intent(inout) :: self
      type(stage_t), intent(in) :: stage
      !> u; shape (lanes, 4).
      real(wp), intent(in) :: frame(lanes, 4)
      !> With the roots.
      type(iteration_t), intent(in) :: at
      real(wp), intent(inout) :: given_up(lanes)
      !> As an addend the first changes nothing, the second takes the sign of a zero away.
      real(wp), parameter :: none(lanes, 4) = -0.0_wp, zero(lanes, 4) = 0.0_wp
      real(wp) :: beta(lanes), factor(lanes), excess(lanes), impulse(lanes, 4)
      call measure_turns(at%z, at%determinant, stage%near, beta, factor, excess, given_up)
      call turn_lanes(at%z, beta, factor, excess, none, self%q, self%q_lost)
      if (self%loads%n > 0) then
         call self%loads%follow(at, stage%stiffness)
         call self%loads%find_impulse(stage%dt, frame, at%z, factor, impulse)
         call turn_lanes(at%z, beta, factor, excess, impulse, self%p, self%p_lost)
      else
         call turn_lanes(at%z, beta, factor, excess, zero, self%p, self%p_lost)
      end if
   end subroutine finish

   !> Where a body is. Its time is not touched.
   pure subroutine get(self, lane, state)
      class(reduced_lanes_t), intent(in) :: self
      !> 1 to `lanes`, taken.
      integer, intent(in) :: lane
      type(state_t), intent(inout) :: state
      state%q = self%q(lane, :)
      state%p = self%p(lane, :)
      state%q_compensation = self%q_lost(lane, :)
      state%p_compensation = self%p_lost(lane, :)
   end subroutine get

end module nutate_reduced_lanes
