!> Steps by Taylor series, of one length, of several bodies together, with the projection onto the invariants: one
!> body a lane.
!>
!> Gyrostats, and bodies with and without rotors under potentials linear in fixed directions, or in a gradient of
!> gravity. All have the same equations (`nutate_lane_expansion`). A lane does the arithmetic of the scalar stepper
!> (`nutate_taylor_stepper` with `nutate_motion_series` and `nutate_spaced_projection`), operation by operation: its
!> bits are the same. A body that turns by tens of radians in a step, or that the projection would move far, is given
!> up, to be moved by the scalar stepper from its start.
module nutate_taylor_lanes
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_kinds, only: wp
   use nutate_lane_expansion, only: lane_expansion_t, move_lanes, put_motion, rest_motion, set_up_motion
   use nutate_lane_potentials, only: are_lane_potentials
   use nutate_lane_projection, only: lane_projection_t, project_lanes, put_target, rest_target, set_up_targets
   use nutate_lane_width, only: lanes
   use nutate_limits, only: manifold_tolerance
   use nutate_spaced_projection, only: small
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_taylor_stepper, only: fixed_step_order, usual_interval
   implicit none
   private

   public :: taylor_lanes_t, can_be_lanes, lanes

   !> Numbers of a body that a lane takes: products of several stay in the range of numbers.
   real(wp), parameter :: least = 1e-40_wp, greatest = 1e40_wp

   !> The bodies, each a lane.
   type :: taylor_lanes_t
      !> The lane has a body, which has not been given up.
      logical :: taken(lanes) = .false.
      !> s.
      real(wp), private :: dt = 0.0_wp
      !> 1: the lane has no body.
      real(wp), private :: idle(lanes) = 1.0_wp
      !> Shape (lanes, 4).
      real(wp), private :: q(lanes, 4) = 0.0_wp, p(lanes, 4) = 0.0_wp
      type(lane_expansion_t), private :: expansion
      type(lane_projection_t), private :: projection
      !> Steps since the last projection, and from there to the next.
      integer, private :: count(lanes) = 0, interval(lanes) = 1
      !> The last states have been made fit to be seen; these; shape (lanes, 4).
      logical, private :: looked = .false.
      real(wp), private :: seen_q(lanes, 4) = 0.0_wp, seen_p(lanes, 4) = 0.0_wp
   contains
      !> Empties all lanes, for steps of a length.
      procedure :: set_up
      !> Puts a body into a lane.
      procedure :: put
      !> One step of all bodies.
      procedure :: step
      !> Makes the bodies fit to be seen; one that cannot be is given up. The steps that follow do not notice.
      procedure :: look
      !> Where a body is.
      procedure :: get
   end type taylor_lanes_t

contains

   !> True if lanes may be able to move a system: nothing acts on it but rotors and potentials that lanes know, and
   !> one of both does.
   pure logical function can_be_lanes(system) result(can_be)
      type(system_t), intent(in) :: system
      associate (effects => system%effects)
         can_be = effects%n_torques + effects%n_off + effects%n_wheels == 0 .and. .not. effects%frame_turns
         if (can_be) can_be = effects%n_potentials > 0 .or. any(abs(effects%rotor_momentum) > 0.0_wp)
         if (can_be) can_be = are_lane_potentials(effects)
      end associate
   end function can_be_lanes

   !> Empties all lanes, for steps of a length.
   pure subroutine set_up(self, order, dt)
      class(taylor_lanes_t), intent(inout) :: self
      !> Of the series; 0: the usual one.
      integer, intent(in) :: order
      !> s.
      real(wp), intent(in) :: dt
      integer :: k
      self%dt = dt
      self%looked = .false.
      call set_up_motion(self%expansion, merge(order, fixed_step_order, order > 0), dt)
      call set_up_targets(self%projection)
      do k = 1, lanes
         call rest(self, k)
      end do
   end subroutine set_up

   !> Fills a SIMD lane without a body with a dummy sphere at rest.
   pure subroutine rest(self, lane)
      class(taylor_lanes_t), intent(inout) :: self
      integer, intent(in) :: lane
      self%taken(lane) = .false.
      self%idle(lane) = 1.0_wp
      self%q(lane, :) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      self%p(lane, :) = [0.0_wp, 0.0_wp, 0.0_wp, 2.0_wp]
      self%count(lane) = 0
      self%interval(lane) = 1
      call rest_motion(self%expansion, lane)
      call rest_target(self%projection, lane)
   end subroutine rest

   !> Puts a body into a lane, before the first step; it is not `taken` where its equations are not those of the others,
   !> or of any lane, or its numbers out of a lane's range.
   subroutine put(self, lane, system, state)
      class(taylor_lanes_t), intent(inout) :: self
      !> 1 to `lanes`.
      integer, intent(in) :: lane
      !> One that lanes can move.
      type(system_t), intent(in) :: system
      !> |q| = 1 and q·p = 0.
      type(state_t), intent(in) :: state
      call rest(self, lane)
      if (.not. is_in_range(self, system, state)) return
      call put_target(self%projection, lane, system, state, self%taken(lane))
      if (self%taken(lane)) call put_motion(self%expansion, lane, system, self%taken(lane))
      if (.not. self%taken(lane)) then
         call rest(self, lane)
         return
      end if
      self%idle(lane) = 0.0_wp
      self%q(lane, :) = state%q
      self%p(lane, :) = state%p
   end subroutine put

   !> True if the numbers of a body are those of a step that lanes can take.
   pure logical function is_in_range(self, system, state)
      type(taylor_lanes_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: square, momentum
      is_in_range = all(ieee_is_finite([state%q, state%p]))
      if (.not. is_in_range) return
      momentum = maxval(abs(state%p))
      is_in_range = all(abs(state%q) <= 2.0_wp) .and. momentum <= greatest .and. &
                    all(abs(system%effects%rotor_momentum) <= greatest) .and. &
                    (momentum >= least .or. .not. momentum > 0.0_wp) .and. &
                    minval(system%body%moments) >= least .and. maxval(system%body%moments) <= greatest .and. &
                    .not. system%body%breaks_triangle .and. abs(self%dt) >= least .and. abs(self%dt) <= greatest
      if (.not. is_in_range) return
      square = dot_product(state%q, state%q)
      is_in_range = abs(square - 1) <= 0.5_wp*manifold_tolerance .and. &
                    abs(dot_product(state%q, state%p)) <= 0.5_wp*manifold_tolerance*momentum
   end function is_in_range

   !> One step of all bodies.
   pure subroutine step(self)
      class(taylor_lanes_t), intent(inout) :: self
      real(wp) :: given_up(lanes), due(lanes)
      integer :: lane
      given_up = self%idle
      self%looked = .false.
      call move_lanes(self%expansion, self%q, self%p, given_up)
      do lane = 1, lanes
         due(lane) = merge(1.0_wp, 0.0_wp, self%count(lane) + 1 >= self%interval(lane))
      end do
      self%count = self%count + 1
      if (maxval(due) > 0.5_wp) call project(self, due, given_up)
      if (.not. any(given_up > self%idle)) return
      do lane = 1, lanes
         if (self%taken(lane) .and. given_up(lane) > 0.5_wp) call rest(self, lane)
      end do
   end subroutine step

   !> Projects the bodies of which that is due, and finds out when the next projection is.
   pure subroutine project(self, due, given_up)
      type(taylor_lanes_t), intent(inout) :: self
      !> 1: yes.
      real(wp), intent(in) :: due(lanes)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: q(lanes, 4), p(lanes, 4)
      integer :: lane
      q = self%q
      p = self%p
      call project_lanes(self%projection, due, self%q, self%p, given_up)
      do lane = 1, lanes
         if (due(lane) < 0.5_wp) cycle
         self%count(lane) = 0
         self%interval(lane) = 1
         if (maxval(abs(self%q(lane, :) - q(lane, :))) <= small .and. &
             maxval(abs(self%p(lane, :) - p(lane, :))) <= small*maxval(abs(p(lane, :)))) &
            self%interval(lane) = usual_interval
      end do
   end subroutine project

   !> Projects copies of the states.
   pure subroutine look(self)
      class(taylor_lanes_t), intent(inout) :: self
      type(lane_projection_t) :: aside
      real(wp) :: given_up(lanes), due(lanes)
      integer :: lane
      self%looked = .true.
      self%seen_q = self%q
      self%seen_p = self%p
      due = merge(1.0_wp, 0.0_wp, self%count > 0)
      if (.not. maxval(due) > 0.5_wp) return
      given_up = self%idle
      aside = self%projection
      call project_lanes(aside, due, self%seen_q, self%seen_p, given_up)
      do lane = 1, lanes
         if (self%taken(lane) .and. given_up(lane) > 0.5_wp) call rest(self, lane)
      end do
   end subroutine look

   !> Where a body is: as it is to be seen, where `look` was called after the last step. Its time is not touched.
   pure subroutine get(self, lane, state)
      class(taylor_lanes_t), intent(in) :: self
      !> 1 to `lanes`, taken.
      integer, intent(in) :: lane
      type(state_t), intent(inout) :: state
      if (self%looked) then
         state%q = self%seen_q(lane, :)
         state%p = self%seen_p(lane, :)
      else
         state%q = self%q(lane, :)
         state%p = self%p(lane, :)
      end if
      state%q_compensation = 0.0_wp
      state%p_compensation = 0.0_wp
   end subroutine get

end module nutate_taylor_lanes
