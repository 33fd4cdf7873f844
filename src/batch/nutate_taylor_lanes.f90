!> Steps by Taylor series, of one length, of several bodies at once, with the projection onto the invariants: one body a
!> lane.
!>
!> Free bodies of diagonal inertia without an axis of symmetry. A lane does the arithmetic of the scalar stepper
!> (`nutate_taylor_stepper` with `nutate_motion_series` and `nutate_spaced_projection`), operation by operation: its
!> bits are the same. A step is the unit of time of its series, so that all powers of it are 1. A body that turns by
!> tens of radians in a step, or that the projection would move far, is given up, to be moved by the scalar stepper from
!> its start.
module nutate_taylor_lanes
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use nutate_axial_frame, only: axial_frame_t
   use nutate_kinds, only: wp
   use nutate_lane_bodies, only: lane_bodies_t
   use nutate_lane_free_body, only: begin_free_lanes, find_scale, find_sines, scale_moments, turn_free_lanes
   use nutate_lane_projection, only: lane_projection_t
   use nutate_lane_series, only: expand_free_lanes, sum_lanes
   use nutate_lane_tail, only: add_part, clear_parts, tail_products_t, tail_weights
   use nutate_lane_width, only: lanes
   use nutate_limits, only: manifold_tolerance
   use nutate_power_series, only: highest_order
   use nutate_spaced_projection, only: small
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   use nutate_taylor_stepper, only: fixed_step_order, usual_interval
   implicit none
   private

   public :: taylor_lanes_t, can_be_series_lanes

   !> Numbers of a body that a lane takes: products of several stay in the range of numbers.
   real(wp), parameter :: least = 1e-40_wp, greatest = 1e40_wp

   !> The bodies, each a lane.
   type, extends(lane_bodies_t) :: taylor_lanes_t
      private
      !> Highest coefficient; s.
      integer :: order = fixed_step_order
      real(wp) :: dt = 0.0_wp
      !> 1: the lane has no body.
      real(wp) :: idle(lanes) = 1.0_wp
      !> Shape (lanes, 4).
      real(wp) :: q(lanes, 4) = 0.0_wp, p(lanes, 4) = 0.0_wp
      !> Moments over Δt, Δt over the moments, and (J₂ - J₃)/J₁, ...; shape (lanes, 3).
      real(wp), dimension(lanes, 3) :: inertia = 0.0_wp, to_angle = 0.0_wp, c = 0.0_wp
      type(lane_projection_t) :: projection
      !> Steps since the last projection, and from there to the next.
      integer :: count(lanes) = 0, interval(lanes) = 1
      !> The last states have been made fit to be seen; these; shape (lanes, 4).
      logical :: looked = .false.
      real(wp) :: seen_q(lanes, 4) = 0.0_wp, seen_p(lanes, 4) = 0.0_wp
   contains
      !> Empties all lanes, for steps of a length.
      procedure :: set_up
      procedure :: put
      procedure :: step
      procedure :: look
      procedure :: get
   end type taylor_lanes_t

contains

   !> True if lanes may be able to move a system: nothing acts on it.
   pure logical function can_be_series_lanes(system)
      type(system_t), intent(in) :: system
      associate (effects => system%effects)
         can_be_series_lanes = effects%n_torques + effects%n_off + effects%n_wheels + effects%n_potentials == 0 .and. &
                               .not. effects%frame_turns .and. .not. any(abs(effects%rotor_momentum) > 0.0_wp)
      end associate
   end function can_be_series_lanes

   !> Empties all lanes, for steps of a length.
   pure subroutine set_up(self, order, dt)
      class(taylor_lanes_t), intent(inout) :: self
      !> Of the series; 0: the usual one.
      integer, intent(in) :: order
      !> s.
      real(wp), intent(in) :: dt
      integer :: k
      self%order = merge(order, fixed_step_order, order > 0)
      self%dt = dt
      self%looked = .false.
      do k = 1, lanes
         call rest(self, k)
      end do
   end subroutine set_up

   !> A lane without a body: a sphere of which no series turns, whose numbers disturb nobody.
   pure subroutine rest(self, lane)
      class(taylor_lanes_t), intent(inout) :: self
      integer, intent(in) :: lane
      self%taken(lane) = .false.
      self%idle(lane) = 1.0_wp
      self%q(lane, :) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      self%p(lane, :) = [0.0_wp, 0.0_wp, 0.0_wp, 2.0_wp]
      self%inertia(lane, :) = 1.0_wp
      self%to_angle(lane, :) = 0.0_wp
      self%c(lane, :) = 0.0_wp
      self%count(lane) = 0
      self%interval(lane) = 1
      call self%projection%rest(lane)
   end subroutine rest

   !> Puts a body into a lane, before the first step; it is not `taken` where its series are not those of a lane, or its
   !> numbers out of a lane's range.
   subroutine put(self, lane, system, state)
      class(taylor_lanes_t), intent(inout) :: self
      integer, intent(in) :: lane
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      integer :: i, j, k
      call rest(self, lane)
      if (.not. is_in_range(self, system, state)) return
      if (.not. has_free_series(system)) return
      self%taken(lane) = .true.
      self%idle(lane) = 0.0_wp
      self%q(lane, :) = state%q
      self%p(lane, :) = state%p
      do i = 1, 3
         j = 1 + modulo(i, 3)
         k = 1 + modulo(i + 1, 3)
         associate (inertia => system%body%inertia, inverse => system%body%inverse_inertia)
            self%inertia(lane, i) = inertia(i, i)/self%dt
            self%to_angle(lane, i) = self%dt*inverse(i, i)
            self%c(lane, i) = inverse(i, i)*(inertia(j, j) - inertia(k, k))
         end associate
      end do
      call self%projection%put(lane, system, state)
   end subroutine put

   !> True for a body whose series are those of `expand_free`.
   pure logical function has_free_series(system)
      type(system_t), intent(in) :: system
      type(axial_frame_t) :: axial
      call axial%recognise(system)
      associate (j => system%body%inverse_inertia)
         has_free_series = axial%axis == 0 .and. .not. any(abs([j(2, 1), j(3, 1), j(3, 2)]) > 0.0_wp)
      end associate
   end function has_free_series

   !> True if the numbers of a body are those of a step that lanes can take.
   pure logical function is_in_range(self, system, state)
      type(taylor_lanes_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      real(wp) :: square, momentum
      is_in_range = all(ieee_is_finite([state%q, state%p]))
      if (.not. is_in_range) return
      momentum = maxval(abs(state%p))
      is_in_range = all(abs(state%q) <= 2.0_wp) .and. momentum <= greatest .and. momentum >= least .and. &
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
      call step_free(self, given_up)
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

   !> Attitude and momentum of free bodies at the end of a step, by their series.
   pure subroutine step_free(self, given_up)
      type(taylor_lanes_t), intent(inout) :: self
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: w(lanes, 3, 0:highest_order), angle(lanes, 0:highest_order), turned(lanes, 1), change(lanes, 3)
      real(wp), dimension(lanes, 3) :: momentum, axis, weights, scaled
      real(wp), dimension(lanes) :: last, before, scale, cosine, sine
      type(tail_products_t) :: products
      integer :: i
      call begin_free_lanes(self%q, self%p, self%inertia, self%to_angle, momentum, axis, weights, w(:, :, 0), given_up)
      call expand_free_lanes(self%order, self%c, weights, axis, w, angle)
      call find_scale(self%inertia, w(:, :, 0), w(:, :, 1), w(:, :, 2), scale)
      call scale_moments(scale, self%inertia, scaled)
      scale = 1.0_wp
      call clear_parts(products)
      associate (n => self%order)
         do i = 1, 3
            call add_part(scaled(:, i), w(:, i, n), w(:, i, n - 1), w(:, i, n - 2), w(:, i, n - 3), &
                          products%squares, products%next, products%second)
         end do
         call add_part(scale, angle(:, n), angle(:, n - 1), angle(:, n - 2), angle(:, n - 3), &
                       products%squares, products%next, products%second)
      end associate
      call tail_weights(products, last, before)
      call sum_lanes(3, self%order, w, last, before, change)
      call sum_lanes(1, self%order, angle, last, before, turned)
      call find_sines(turned(:, 1), cosine, sine)
      call turn_free_lanes(cosine, sine, axis, self%inertia, change, momentum, self%q, self%p, given_up)
   end subroutine step_free

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
      call self%projection%project(due, self%q, self%p, given_up)
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
      call aside%project(due, self%seen_q, self%seen_p, given_up)
      do lane = 1, lanes
         if (self%taken(lane) .and. given_up(lane) > 0.5_wp) call rest(self, lane)
      end do
   end subroutine look

   !> Where a body is: as it is to be seen, where `look` was called after the last step. Its time is not touched.
   pure subroutine get(self, lane, state)
      class(taylor_lanes_t), intent(in) :: self
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
