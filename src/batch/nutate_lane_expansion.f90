!> The motion of several bodies in one step by power series: one body a lane, each with its own numbers, all with the
!> same equations.
!>
!> The equations are those of `nutate_motion_series`: two pairs, L and three rows, for tops of any inertia, with rotors,
!> several directions and gradients of gravity; one pair, L and a row, for gyrostats; tops of diagonal inertia; and all
!> but one pair with an axis of symmetry in the axial frame. Bodies without rotor on which nothing acts have a closed
!> solution (`nutate_exact_stepper`) and no lane. A step is the unit of time of its series, so that all powers of it
!> are 1.
module nutate_lane_expansion
   use nutate_axial_frame, only: axial_frame_t
   use nutate_kinds, only: wp
   use nutate_lane_choice, only: replace_lanes
   use nutate_lane_motion, only: add_changes, begin_lanes, end_lanes, find_axes, find_frames, find_rates, &
      find_sines, see_lanes, straighten_rows, test_rates, turn_evenly, turn_in_axial_frame, turn_rows
   use nutate_lane_row_series, only: expand_axial_lanes, expand_pair_lanes, expand_top_lanes
   use nutate_lane_torque_series, only: lane_torques_t, put_torques, rest_torques, set_up_torques
   use nutate_lane_tail, only: add_angle, add_row, begin_tail, sum_angles, sum_lanes, tail_products_t, tail_weights
   use nutate_lane_vectors, only: cross_lanes, find_full_rates, multiply_lanes
   use nutate_lane_width, only: lanes
   use nutate_motion_series, only: least_share
   use nutate_power_series, only: highest_order
   use nutate_series_sum, only: length_of
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_torque_series, only: torque_series_t
   implicit none
   private

   public :: lane_expansion_t, set_up_motion, put_motion, rest_motion, move_lanes

   !> The equations: none yet, L and three rows, L and one, a top, a top and a gyrostat in the axial frame.
   integer, parameter :: NONE = 0, TWO_PAIRS = 1, ONE_PAIR = 2, TOP = 3, AXIAL_TOP = 4, AXIAL_FREE = 5
   !> Momentum of a free body, N m s.
   real(wp), parameter :: least = 1e-40_wp
   !> Change of ΔtΩ that a potential may make in a step, rad: what is beyond belongs to no step that a lane takes.
   real(wp), parameter :: greatest_push = 1e3_wp

   !> What the series of each body need.
   type :: lane_expansion_t
      private
      !> `NONE`, ..., and the axis of symmetry, of all bodies.
      integer :: equations = NONE, axis = 0
      !> Highest coefficient, and Δt, s.
      integer :: order = 0
      real(wp) :: dt = 0.0_wp
      !> Moments over Δt (in the axial frame J₁), Δt over the moments, and (J₂ - J₃)/J₁, ...; shape (lanes, 3).
      real(wp), dimension(lanes, 3) :: inertia = 1.0_wp, to_angle = 0.0_wp, c = 0.0_wp
      !> ΔtJ⁻¹; shape (lanes, 3, 3). Momentum of rotors, body axes, N m s; shape (lanes, 3).
      real(wp) :: full(lanes, 3, 3) = 0.0_wp, rotor(lanes, 3) = 0.0_wp
      !> Lengths of L up to this have no direction, N m s.
      real(wp) :: floor(lanes) = least
      !> 1/J along the axis and across it, kg⁻¹ m⁻².
      real(wp) :: inverse_along(lanes) = 0.0_wp, inverse_across(lanes) = 0.0_wp
      !> The potential's moment times Δt²/Jᵢ in column i; Δt² times that along the axis, over J₁; basis vectors as
      !> columns, space axes; shape (lanes, 3, 3).
      real(wp) :: moments(lanes, 3, 3) = 0.0_wp, g(lanes) = 0.0_wp, basis(lanes, 3, 3) = 0.0_wp
      !> What acts on bodies of two pairs.
      type(lane_torques_t) :: torques
   end type lane_expansion_t

   !> The series of a step. No component has a first value: they would be set at every step.
   type :: lane_series_t
      !> ΔtΩ, or ΔtL/J₁; the angle about the axis of symmetry, rad; rows.
      real(wp) :: w(lanes, 3, 0:highest_order), angle(lanes, 0:highest_order), rows(lanes, 3, 0:highest_order, 4)
      !> Weights of the last coefficient and of the one before in the tail.
      real(wp) :: last(lanes), before(lanes)
   end type lane_series_t

contains

   !> For bodies that are to come, the first of which says what the equations are.
   pure subroutine set_up_motion(self, order, dt)
      type(lane_expansion_t), intent(inout) :: self
      !> Highest coefficient.
      integer, intent(in) :: order
      !> s.
      real(wp), intent(in) :: dt
      self%equations = NONE
      self%axis = 0
      self%order = order
      self%dt = dt
      call set_up_torques(self%torques, dt)
   end subroutine set_up_motion

   !> A sphere of which no series turns.
   pure subroutine rest_motion(self, lane)
      type(lane_expansion_t), intent(inout) :: self
      integer, intent(in) :: lane
      integer :: i
      self%inertia(lane, :) = 1.0_wp
      self%to_angle(lane, :) = 0.0_wp
      self%c(lane, :) = 0.0_wp
      self%full(lane, :, :) = 0.0_wp
      self%rotor(lane, :) = 0.0_wp
      self%floor(lane) = least
      self%inverse_along(lane) = 0.0_wp
      self%inverse_across(lane) = 0.0_wp
      self%moments(lane, :, :) = 0.0_wp
      self%g(lane) = 0.0_wp
      call rest_torques(self%torques, lane)
      self%basis(lane, :, :) = 0.0_wp
      do i = 1, 3
         self%basis(lane, i, i) = 1.0_wp
      end do
   end subroutine rest_motion

   !> Puts in a body on which nothing acts but rotors and potentials that lanes know.
   subroutine put_motion(self, lane, system, fits)
      type(lane_expansion_t), intent(inout) :: self
      integer, intent(in) :: lane
      type(system_t), intent(in) :: system
      !> False: its equations are others than those of the lanes, or of any lane, and it is not taken.
      logical, intent(out) :: fits
      type(axial_frame_t) :: axial
      type(torque_series_t) :: torques
      type(status_t) :: status
      integer :: equations
      logical :: is_first
      call axial%recognise(system)
      call torques%prepare(system%effects, status)
      fits = status%ok()
      if (.not. fits) return
      equations = equations_of(system, axial%axis, torques)
      is_first = self%equations == NONE
      if (is_first) then
         self%equations = equations
         self%axis = axial%axis
      end if
      fits = equations /= NONE .and. self%equations == equations .and. self%axis == axial%axis
      if (.not. fits) return
      call put_body(self, lane, system, axial)
      if (equations == TOP .or. equations == AXIAL_TOP) call put_moment(self, lane, system, axial, torques, fits)
      if (equations == TWO_PAIRS) call put_pairs(self, lane, is_first, system, torques, fits)
   end subroutine put_motion

   !> Which equations do, as `nutate_motion_series` finds it; none for a body without rotor on which nothing acts.
   pure integer function equations_of(system, axis, torques) result(equations)
      type(system_t), intent(in) :: system
      !> Of symmetry; 0: none.
      integer, intent(in) :: axis
      type(torque_series_t), intent(in) :: torques
      logical :: has_rotor, diagonal
      has_rotor = any(abs(system%effects%rotor_momentum) > 0.0_wp)
      associate (j => system%body%inverse_inertia)
         diagonal = .not. (has_rotor .or. any(abs([j(2, 1), j(3, 1), j(3, 2)]) > 0.0_wp))
      end associate
      equations = NONE
      if (torques%rank == 0) then
         if (has_rotor) equations = merge(AXIAL_FREE, ONE_PAIR, axis > 0)
      else if (.not. torques%has_more .and. torques%n_moments == 1 .and. (diagonal .or. axis > 0)) then
         equations = merge(AXIAL_TOP, TOP, axis > 0)
      else
         equations = TWO_PAIRS
      end if
   end function equations_of

   !> What of a body belongs to the rotation.
   pure subroutine put_body(self, lane, system, axial)
      type(lane_expansion_t), intent(inout) :: self
      integer, intent(in) :: lane
      type(system_t), intent(in) :: system
      type(axial_frame_t), intent(in) :: axial
      integer :: i, j, k
      self%rotor(lane, :) = system%effects%rotor_momentum
      self%floor(lane) = max(least, least_share*length_of(system%effects%rotor_momentum))
      self%full(lane, :, :) = self%dt*system%body%inverse_inertia
      if (axial%axis > 0) then
         self%to_angle(lane, :) = self%dt*axial%inverse_across
         self%inertia(lane, :) = 1/self%to_angle(lane, :)
         self%inverse_along(lane) = axial%inverse_along
         self%inverse_across(lane) = axial%inverse_across
         return
      end if
      do i = 1, 3
         j = 1 + modulo(i, 3)
         k = 1 + modulo(i + 1, 3)
         associate (inertia => system%body%inertia, inverse => system%body%inverse_inertia)
            self%inertia(lane, i) = inertia(i, i)/self%dt
            self%to_angle(lane, i) = self%dt*inverse(i, i)
            self%c(lane, i) = inverse(i, i)*(inertia(j, j) - inertia(k, k))
         end associate
      end do
   end subroutine put_body

   !> What belongs to the potential of a top.
   pure subroutine put_moment(self, lane, system, axial, torques, fits)
      type(lane_expansion_t), intent(inout) :: self
      integer, intent(in) :: lane
      type(system_t), intent(in) :: system
      type(axial_frame_t), intent(in) :: axial
      type(torque_series_t), intent(in) :: torques
      !> False: it is too strong for a lane.
      logical, intent(out) :: fits
      real(wp) :: moments(3, 3)
      integer :: i
      moments = 0.0_wp
      if (axial%axis > 0) then
         self%g(lane) = self%to_angle(lane, 1)*(self%dt*torques%moments(axial%axis, 1))
         moments(1, 1) = self%g(lane)
      else
         do i = 1, 3
            moments(:, i) = (self%dt*system%body%inverse_inertia(i, i))*(self%dt*torques%moments(:, 1))
         end do
         self%moments(lane, :, :) = moments
      end if
      self%basis(lane, :, :) = torques%basis
      fits = all(abs(moments) <= greatest_push)
   end subroutine put_moment

   !> What belongs to all potentials of a body of two pairs.
   pure subroutine put_pairs(self, lane, is_first, system, torques, fits)
      type(lane_expansion_t), intent(inout) :: self
      integer, intent(in) :: lane
      !> The other bodies are like this one.
      logical, intent(in) :: is_first
      type(system_t), intent(in) :: system
      type(torque_series_t), intent(in) :: torques
      !> False: they are others than those of the other bodies, or too strong for a lane.
      logical, intent(out) :: fits
      real(wp) :: bound
      call put_torques(self%torques, lane, is_first, system, torques, bound, fits)
      self%basis(lane, :, :) = torques%basis
      if (fits) fits = sum(abs(self%full(lane, :, :)))*bound <= greatest_push
   end subroutine put_pairs

   !> Moves all bodies by one step: q normalised, p = 2 q∘[0, L].
   pure subroutine move_lanes(self, q, p, given_up)
      type(lane_expansion_t), intent(in) :: self
      !> Shape (lanes, 4).
      real(wp), intent(inout) :: q(lanes, 4), p(lanes, 4)
      !> 1: yes.
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: momentum(lanes, 3), rotation(lanes, 4)
      type(lane_series_t) :: series
      call begin_lanes(q, p, momentum)
      if (self%equations == ONE_PAIR .or. self%equations == TWO_PAIRS) then
         call find_full_rates(self%full, momentum - self%rotor, series%w(:, :, 0))
      else
         call find_rates(self%to_angle, momentum, series%w(:, :, 0))
      end if
      call test_rates(series%w(:, :, 0), given_up)
      select case (self%equations)
      case (ONE_PAIR)
         call move_pair(self, series, momentum, rotation, given_up)
      case (TWO_PAIRS)
         call move_pairs(self, q, series, momentum, rotation, given_up)
      case (TOP)
         call move_top(self, q, [1, 2, 3], series, momentum, rotation, given_up)
      case (AXIAL_FREE, AXIAL_TOP)
         call move_axial(self, q, series, momentum, rotation, given_up)
      case default
         return
      end select
      call end_lanes(rotation, momentum, q, p, given_up)
   end subroutine move_lanes

   !> Gyrostats.
   pure subroutine move_pair(self, series, momentum, rotation, given_up)
      type(lane_expansion_t), intent(in) :: self
      type(lane_series_t), intent(inout) :: series
      !> L at the start on entry, at the end on exit; shape (lanes, 3).
      real(wp), intent(inout) :: momentum(lanes, 3)
      !> Since the start; shape (lanes, 4).
      real(wp), intent(out) :: rotation(lanes, 4)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp), parameter :: ones(lanes, 3) = 1.0_wp
      real(wp) :: frame(lanes, 3, 3), ends(lanes, 3, 3), length(lanes), change(lanes, 3)
      type(tail_products_t) :: products
      call find_axes(self%floor, momentum, frame(:, :, 2), length, given_up)
      call find_frames(frame(:, :, 2), frame(:, :, 1), frame(:, :, 3))
      series%rows(:, :, 0, 1) = momentum
      series%rows(:, :, 0, 2) = frame(:, :, 1)
      call expand_pair_lanes(self%order, 2, self%full, 0, self%to_angle(:, 1), self%torques, series%w, series%rows, &
                             series%angle)
      call begin_tail(self%order, ones, series%rows(:, :, :, 1), products)
      call add_row(self%order, series%rows(:, :, :, 2), products)
      call tail_weights(products, series%last, series%before)
      call sum_lanes(self%order, series%rows(:, :, :, 1), series%last, series%before, change)
      call add_changes(ones, change, momentum)
      call sum_lanes(self%order, series%rows(:, :, :, 2), series%last, series%before, change)
      ends(:, :, 1) = frame(:, :, 1)
      call add_changes(ones, change, ends(:, :, 1))
      call straighten_rows(self%floor, momentum, ends(:, :, 1), ends(:, :, 2), given_up)
      call cross_lanes(ends(:, :, 1), ends(:, :, 2), ends(:, :, 3))
      call turn_rows(frame(:, :, 1), frame(:, :, 2), frame(:, :, 3), ends(:, :, 1), ends(:, :, 2), ends(:, :, 3), &
                     rotation, given_up)
   end subroutine move_pair

   !> Bodies of any inertia, with rotors, under any potentials that lanes know.
   pure subroutine move_pairs(self, q, series, momentum, rotation, given_up)
      type(lane_expansion_t), intent(in) :: self
      real(wp), intent(in) :: q(lanes, 4)
      type(lane_series_t), intent(inout) :: series
      !> As in `move_pair`.
      real(wp), intent(inout) :: momentum(lanes, 3)
      real(wp), intent(out) :: rotation(lanes, 4)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp), parameter :: ones(lanes, 3) = 1.0_wp
      real(wp) :: frame(lanes, 3, 3), ends(lanes, 3, 3), change(lanes, 3), turned(lanes, 4), spin(lanes)
      type(tail_products_t) :: products
      integer :: row
      if (self%axis > 0) then
         call find_rates(self%to_angle, momentum, change)
         call test_rates(change, given_up)
      end if
      series%rows(:, :, 0, 1) = momentum
      do row = 1, 3
         ! What turns too fast for a lane makes no numbers out of range.
         call replace_lanes(1 - given_up, 0.0_wp, series%rows(:, row, 0, 1))
         call see_lanes(q, self%basis(:, :, row), frame(:, :, row))
         series%rows(:, :, 0, row + 1) = frame(:, :, row)
      end do
      call expand_pair_lanes(self%order, 4, self%full, self%axis, self%to_angle(:, 1), self%torques, series%w, &
                             series%rows, series%angle)
      call begin_tail(self%order, ones, series%rows(:, :, :, 1), products)
      do row = 1, 3
         call add_row(self%order, series%rows(:, :, :, row + 1), products)
      end do
      if (self%axis > 0) call add_angle(self%order, series%angle, products)
      call tail_weights(products, series%last, series%before)
      call sum_lanes(self%order, series%rows(:, :, :, 1), series%last, series%before, change)
      call add_changes(ones, change, momentum)
      ends = frame
      do row = 1, 3
         call sum_lanes(self%order, series%rows(:, :, :, row + 1), series%last, series%before, change)
         call add_changes(ones, change, ends(:, :, row))
      end do
      call turn_rows(frame(:, :, 1), frame(:, :, 2), frame(:, :, 3), ends(:, :, 1), ends(:, :, 2), ends(:, :, 3), &
                     rotation, given_up)
      if (self%axis == 0) return
      call sum_angles(self%order, series%angle, series%last, series%before, spin)
      turned = rotation
      call turn_about_axis(self%axis, spin, turned, momentum, rotation)
   end subroutine move_pairs

   !> Tops, in body axes or in the axial frame.
   pure subroutine move_top(self, q, places, series, momentum, rotation, given_up)
      type(lane_expansion_t), intent(in) :: self
      real(wp), intent(in) :: q(lanes, 4)
      !> Of the components in the body.
      integer, intent(in) :: places(3)
      type(lane_series_t), intent(inout) :: series
      !> As in `move_pair`; components in their places here.
      real(wp), intent(inout) :: momentum(lanes, 3)
      real(wp), intent(out) :: rotation(lanes, 4)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp), parameter :: ones(lanes, 3) = 1.0_wp
      real(wp) :: frame(lanes, 3, 3), ends(lanes, 3, 3), seen(lanes, 3), change(lanes, 3)
      type(tail_products_t) :: products
      integer :: row
      do row = 1, 3
         call see_lanes(q, self%basis(:, :, row), seen)
         frame(:, :, row) = seen(:, places)
         if (row < 3) series%rows(:, :, 0, row) = frame(:, :, row)
      end do
      if (self%equations == TOP) then
         call expand_top_lanes(self%order, self%c, self%moments, series%w, series%rows)
      else
         call expand_axial_lanes(self%order, self%g, series%w, series%rows)
      end if
      call begin_tail(self%order, self%inertia, series%w, products)
      do row = 1, 2
         call add_row(self%order, series%rows(:, :, :, row), products)
      end do
      call tail_weights(products, series%last, series%before)
      call sum_lanes(self%order, series%w, series%last, series%before, change)
      call add_changes(self%inertia, change, momentum)
      do row = 1, 2
         call sum_lanes(self%order, series%rows(:, :, :, row), series%last, series%before, change)
         ends(:, :, row) = frame(:, :, row)
         call add_changes(ones, change, ends(:, :, row))
      end do
      call cross_lanes(ends(:, :, 1), ends(:, :, 2), ends(:, :, 3))
      call turn_rows(frame(:, :, 1), frame(:, :, 2), frame(:, :, 3), ends(:, :, 1), ends(:, :, 2), ends(:, :, 3), &
                     rotation, given_up)
   end subroutine move_top

   !> Bodies with an axis of symmetry: in the axial frame, in which they then turn evenly.
   pure subroutine move_axial(self, q, series, momentum, rotation, given_up)
      type(lane_expansion_t), intent(in) :: self
      real(wp), intent(in) :: q(lanes, 4)
      type(lane_series_t), intent(inout) :: series
      !> As in `move_pair`.
      real(wp), intent(inout) :: momentum(lanes, 3)
      real(wp), intent(out) :: rotation(lanes, 4)
      real(wp), intent(inout) :: given_up(lanes)
      real(wp) :: own(lanes, 3), turned(lanes, 4), spin(lanes)
      integer :: places(3)
      places = 1 + modulo(self%axis + [0, 1, 2], 3)
      call find_spins(self%dt, self%inverse_along, self%inverse_across, self%rotor(:, self%axis), &
                      momentum(:, self%axis), spin)
      own = momentum(:, places)
      series%w(:, :, 0) = series%w(:, places, 0)
      if (self%equations == AXIAL_TOP) then
         call move_top(self, q, places, series, own, turned, given_up)
      else
         call turn_evenly(series%w(:, :, 0), turned)
      end if
      momentum(:, places) = own
      own = turned(:, 2:4)
      turned(:, 1 + places) = own
      call turn_about_axis(self%axis, spin, turned, momentum, rotation)
   end subroutine move_axial

   !> Leaves the axial frame, in which bodies have turned by angles about their axis.
   pure subroutine turn_about_axis(axis, spin, turned, momentum, rotation)
      integer, intent(in) :: axis
      !> rad; shape (lanes).
      real(wp), intent(in) :: spin(lanes)
      !> The rotation of the frame; shape (lanes, 4).
      real(wp), intent(in) :: turned(lanes, 4)
      !> L, in the frame on entry, in the body on exit; shape (lanes, 3).
      real(wp), intent(inout) :: momentum(lanes, 3)
      !> Of the body; shape (lanes, 4).
      real(wp), intent(out) :: rotation(lanes, 4)
      real(wp) :: about(lanes, 4), cosine(lanes), sine(lanes)
      call find_sines(spin, cosine, sine)
      call turn_in_axial_frame(cosine, sine, momentum(:, 1 + modulo(axis, 3)), momentum(:, 1 + modulo(axis + 1, 3)))
      call find_sines(0.5_wp*spin, cosine, sine)
      about = 0.0_wp
      about(:, 1) = cosine
      about(:, 1 + axis) = sine
      call multiply_lanes(turned, about, rotation)
   end subroutine turn_about_axis

   !> Angles by which bodies turn in the axial frame in a step, rad.
   pure subroutine find_spins(dt, along, across, rotor, momentum, spin)
      !> s; 1/J along the axis and across it, and momentum of rotors and L along it; shape (lanes).
      real(wp), intent(in) :: dt, along(lanes), across(lanes), rotor(lanes), momentum(lanes)
      real(wp), intent(out) :: spin(lanes)
      integer :: i
      do i = 1, lanes
         spin(i) = dt*((momentum(i) - rotor(i))*along(i) - momentum(i)*across(i))
      end do
   end subroutine find_spins

end module nutate_lane_expansion
