!> The torque of all effects as a power series in time: what is linear in the directions merged into three vectors, the
!> rest coefficient by coefficient from the effects themselves.
!>
!> The directions `n` of the effects are written in an orthonormal basis `e₁, e₂, e₃` of space, so that every
!> `γ = R(q)ᵀn` is a sum of the three rows `R(q)ᵀeᵢ`. The first basis vectors span the directions, in the order linear
!> potentials, others: a top needs e₁ only.
module nutate_torque_series
   use nutate_effect, only: effect_t, GENERAL_SERIES, LINEAR_SERIES, NO_SERIES, SPACE_SERIES, TIME_SERIES
   use nutate_effect_list, only: effect_list_t
   use nutate_direction_basis, only: choose_basis
   use nutate_kinds, only: wp
   use nutate_quaternion, only: cross
   use nutate_power_series, only: highest_order, inverses, series_group_t
   use nutate_reshaped_series, only: inertia_push, reshaped_series_t, transported_power
   use nutate_series_tail, only: series_tail_t
   use nutate_small_products, only: skew, times_vector
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: torque_series_t

   !> Torques whose works are computed together.
   integer, parameter :: lanes = 4

   !> The torque of the effects of a system.
   type :: torque_series_t
      !> Basis vectors as columns, space axes, shape (3,3); number of those that span the directions.
      real(wp) :: basis(3, 3) = 0.0_wp
      integer :: rank = 0
      !> Linear potentials: τ = Σ mᵢ×R(q)ᵀeᵢ; columns mᵢ, body axes, N m, shape (3,3); number of those that are not
      !> zero.
      real(wp) :: moments(3, 3) = 0.0_wp
      integer :: n_moments = 0
      !> True if there are other effects than linear potentials; true if all of these are torques that are linear in Ω
      !> or depend on time alone.
      logical :: has_more = .false., is_simple = .false.
      !> Start of the series for torques, s, set by the caller: inside the piece of each torque that is in pieces;
      !> highest coefficient that is required.
      real(wp) :: start = 0.0_wp
      integer :: order = highest_order
      !> The inertia varies; coefficients of its power series, kg m²; shape (3,3,degree).
      logical :: varies = .false.
      real(wp) :: inertia(3, 3, 3) = 0.0_wp
      !> A time inside the step, s, set by the caller: inside the piece of the inertia.
      real(wp) :: moment = 0.0_wp
      !> Series of the part of potentials that varies with the body; not allocated if none does.
      type(reshaped_series_t), allocatable :: changes
      !> Potentials with a general series or one that varies; the slot of their auxiliary series; true for linear ones,
      !> whose torque is that of a moment.
      integer :: n_general = 0
      integer, allocatable :: general(:), slot(:)
      logical, allocatable, private :: by_moment(:)
      !> Slots of the torques that have a general series, negative in space axes; 0 for a linear one.
      integer, allocatable :: torque_slot(:)
      !> True for torques that depend on time alone; shape (number of torques).
      logical, allocatable, private :: is_timed(:)
      !> D of each linear torque that acts, N m s, before zeros; shape (4,3, number of torques).
      real(wp), allocatable :: drags(:, :, :)
      !> True for slots whose n is fixed and not zero.
      logical, allocatable, private :: is_directed(:)
      !> Directions in the basis, potentials first; shape (3, slots).
      real(wp), allocatable :: components(:, :)
      !> γ, body axes; shape (3, 0:highest_order, slots).
      real(wp), allocatable :: gamma(:, :, :)
      !> Auxiliary series of each slot; shape (slots).
      type(series_group_t), allocatable :: auxiliary(:)
      !> Series along the basis vectors of torques in space axes, after a zero; the rows R(q)ᵀeᵢ; shapes
      !> (4, 0:highest_order, number of torques) and (4,3, 0:highest_order), not allocated if there is no such torque.
      real(wp), allocatable, private :: along(:, :, :), rows(:, :, :)
      !> Index of each slot among the directions that move, 0 for one that does not; series of their n in the basis,
      !> after a zero, shape (4, 0:highest_order, any); the fastest pace of them, 1/s; there are some.
      integer, allocatable :: mover(:)
      real(wp), allocatable :: moving(:, :, :)
      real(wp) :: pace = 0.0_wp
      logical :: moves = .false.
      !> D of linear torques; shape (3,3, number of torques).
      real(wp), allocatable, private :: drag(:, :, :)
      !> Number of torques whose works are computed, last those of the dependence on time if there is one: Ω, rad/s,
      !> shape (3, 0:highest_order), and before a zero, shape (4, 0:highest_order); torques before a zero, body axes,
      !> N m, shape (4, 0:highest_order, number); series of their works ∫ Ω·τ dt in units of time, W, in lanes, shape
      !> (lane, 0:highest_order, groups).
      integer :: n_lanes = 0
      real(wp), allocatable :: omega(:, :), rates(:, :), torque(:, :, :), works(:, :, :)
      !> Absolute Ω, rad/s, allocated if the inertia varies; shape (3, 0:highest_order).
      real(wp), allocatable, private :: absolute(:, :)
      !> ∂τ/∂γ of all slots, for derivatives; shape (3,3, 0:highest_order, slots).
      real(wp), allocatable :: derivative(:, :, :, :)
   contains
      !> Determines the terms that the effects need.
      procedure :: prepare
      !> Computes the coefficients of the inertia.
      procedure :: expand_inertia
      !> Returns what the inertia's higher coefficients add to a coefficient of JΩ.
      procedure :: older_momentum
      !> Adds the work that a change of the inertia does by the rate of the space axes.
      procedure :: add_transported_work
      !> Computes the series that depend on time alone: before the first coefficient.
      procedure :: begin
      !> Computes a coefficient of the directions that move, in body axes.
      procedure :: move_directions
      !> Adds a coefficient of all that is not linear in the directions, after those of the directions that move.
      procedure :: add_terms
      !> Adds a coefficient of the derivative with respect to a small rotation of the body.
      procedure :: add_derivatives
      !> Returns the sum of D of all torques.
      procedure :: total_drag
      !> Computes the works of the torques, and of potentials that move, up to a time.
      procedure :: get_works
   end type torque_series_t

contains

   !> Determines the terms that the effects need. Errors: `NUTATE_BAD_ARGUMENT` for an effect without series.
   subroutine prepare(self, effects, status)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      type(status_t), intent(out) :: status
      integer :: i
      do i = 1, effects%n_potentials
         call demand_series(effects%potentials(i)%item, status)
         if (.not. status%ok()) return
      end do
      do i = 1, effects%n_torques
         call demand_series(effects%torques(i)%item, status)
         if (.not. status%ok()) return
      end do
      call sort_potentials(self, effects)
      call choose_basis(effects, self%basis, self%rank)
      call add_moments(self, effects)
      call make_slots(self, effects)
      call make_axes(self, effects)
      if (allocated(self%changes)) deallocate (self%changes)
      if (.not. effects%reshapes) return
      allocate (self%changes)
      call self%changes%prepare(effects)
   end subroutine prepare

   subroutine demand_series(effect, status)
      class(effect_t), intent(in) :: effect
      type(status_t), intent(inout) :: status
      character(len=len(effect%name)) :: name
      if (effect%series_kind() == NO_SERIES .and. effect%name == 'controller') then
         status = fail(NUTATE_BAD_ARGUMENT, 'a continuous controller has no series (expected sample in '// &
                       "it, or method = 'dop853' with conserve = .true.)", 'method')
      else if (effect%series_kind() == NO_SERIES) then
         name = effect%name
         if (name == '') name = 'unnamed'
         status = fail(NUTATE_BAD_ARGUMENT, "effect '"//trim(name)// &
                       "' has no series (expected method = 'dop853' with conserve = .true.)", 'method')
      end if
   end subroutine demand_series

   !> Lists the potentials that have a general series.
   subroutine sort_potentials(self, effects)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer :: i
      if (allocated(self%general)) deallocate (self%general)
      allocate (self%general(effects%n_potentials))
      self%n_general = 0
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            if (potential%series_kind() /= GENERAL_SERIES .and. .not. potential%varies) cycle
         end associate
         self%n_general = self%n_general + 1
         self%general(self%n_general) = i
      end do
      self%has_more = self%n_general + effects%n_torques > 0
   end subroutine sort_potentials

   !> Merges the linear potentials.
   subroutine add_moments(self, effects)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer :: i, k
      self%moments = 0.0_wp
      self%n_moments = 0
      do i = 1, effects%n_potentials
         associate (potential => effects%potentials(i)%item)
            if (potential%series_kind() /= LINEAR_SERIES .or. potential%varies) cycle
            do k = 1, 3
               self%moments(:, k) = self%moments(:, k) &
                                    + dot_product(potential%direction, self%basis(:, k))*potential%series_moment()
            end do
         end associate
      end do
      do k = 1, self%rank
         if (any(abs(self%moments(:, k)) > 0.0_wp)) self%n_moments = k
      end do
   end subroutine add_moments

   !> Gives each general series its direction, and allocates its auxiliary series.
   subroutine make_slots(self, effects)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer :: i, n
      if (allocated(self%slot)) deallocate (self%slot, self%by_moment, self%torque_slot, self%is_timed, &
                                            self%components, self%gamma, self%auxiliary, self%drag, self%omega, &
                                            self%rates, self%torque, self%works, self%mover, self%moving)
      if (allocated(self%derivative)) deallocate (self%derivative)
      if (allocated(self%drags)) deallocate (self%drags)
      if (allocated(self%absolute)) deallocate (self%absolute)
      n = self%n_general + effects%n_torques
      allocate (self%slot(self%n_general), self%torque_slot(effects%n_torques), source=0)
      allocate (self%components(3, n), self%drag(3, 3, effects%n_torques), source=0.0_wp)
      allocate (self%mover(n), source=0)
      allocate (self%auxiliary(n), self%by_moment(self%n_general))
      allocate (self%is_timed(effects%n_torques), source=.false.)
      self%pace = 0.0_wp
      n = 0
      do i = 1, self%n_general
         associate (potential => effects%potentials(self%general(i))%item)
            call open_slot(self, potential, potential%direction, n)
            self%by_moment(i) = potential%is_linear()
            if (potential%moves) self%mover(n) = 1 + maxval(self%mover)
            self%pace = max(self%pace, potential%pace)
         end associate
         self%slot(i) = n
      end do
      do i = 1, effects%n_torques
         associate (torque => effects%torques(i)%item)
            if (torque%series_kind() == LINEAR_SERIES) then
               self%drag(:, :, i) = torque%series_drag()
            else
               call open_slot(self, torque, torque%series_direction(), n)
               self%torque_slot(i) = n
               self%is_timed(i) = torque%series_kind() == TIME_SERIES
               if (torque%moves) self%mover(n) = 1 + maxval(self%mover)
               self%pace = max(self%pace, torque%pace)
            end if
         end associate
      end do
      self%is_simple = self%has_more .and. self%n_general == 0 .and. &
                       count(self%torque_slot /= 0) == count(self%is_timed)
      self%is_directed = [(any(abs(self%components(:, i)) > 0.0_wp) .and. self%mover(i) == 0, i=1, n)]
      allocate (self%moving(4, 0:highest_order, maxval([0, self%mover])), source=0.0_wp)
      self%moves = size(self%moving, 3) > 0
      allocate (self%gamma(3, 0:highest_order, n), source=0.0_wp)
      self%n_lanes = effects%n_torques
      if (effects%depends_on_time) self%n_lanes = self%n_lanes + 1
      self%varies = effects%varies
      n = -1
      if (self%has_more .or. self%n_lanes > 0) n = highest_order
      allocate (self%omega(3, 0:n), self%rates(4, 0:n), source=0.0_wp)
      if (self%varies) allocate (self%absolute(3, 0:n), source=0.0_wp)
      allocate (self%torque(4, 0:highest_order, self%n_lanes), source=0.0_wp)
      allocate (self%works(lanes, 0:highest_order, (self%n_lanes + lanes - 1)/lanes), source=0.0_wp)
      if (self%is_simple) allocate (self%drags(4, 3, self%n_lanes), source=0.0_wp)
   end subroutine make_slots

   !> Marks the torques in space axes, and allocates their series.
   subroutine make_axes(self, effects)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer :: i, last
      if (allocated(self%along)) deallocate (self%along, self%rows)
      last = -1
      if (size(self%moving, 3) > 0) last = highest_order
      do i = 1, effects%n_torques
         if (effects%torques(i)%item%series_kind() /= SPACE_SERIES) cycle
         self%torque_slot(i) = -self%torque_slot(i)
         last = highest_order
      end do
      if (last < 0) return
      allocate (self%along(4, 0:last, effects%n_torques), self%rows(4, 3, 0:last), source=0.0_wp)
   end subroutine make_axes

   subroutine open_slot(self, effect, direction, n)
      class(torque_series_t), intent(inout) :: self
      class(effect_t), intent(in) :: effect
      !> Direction, space axes; shape (3).
      real(wp), intent(in) :: direction(3)
      !> Number of slots so far.
      integer, intent(inout) :: n
      n = n + 1
      self%components(:, n) = matmul(direction, self%basis)
      allocate (self%auxiliary(n)%values(0:highest_order, effect%auxiliary_series()), source=0.0_wp)
   end subroutine open_slot

   !> Computes the series of directions that move and of torques that depend on time alone.
   pure subroutine begin(self, effects, time_unit, acts)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> s.
      real(wp), intent(in) :: time_unit
      !> The torque acts; shape (number of torques).
      logical, intent(in) :: acts(:)
      if (self%is_simple) call begin_drags(self, acts)
      if (self%moves) call expand_directions(self, effects, self%start, time_unit)
      if (size(acts) > 0) call expand_timed(self, effects, self%start, time_unit, acts)
   end subroutine begin

   !> Sets the drags of the linear torques that act.
   pure subroutine begin_drags(self, acts)
      class(torque_series_t), intent(inout) :: self
      logical, intent(in) :: acts(:)
      integer :: i
      do i = 1, size(acts)
         if (.not. self%is_timed(i)) self%drags(1:3, :, i) = merge(self%drag(:, :, i), 0.0_wp, acts(i))
      end do
   end subroutine begin_drags

   !> Adds coefficient k of the torque of all effects that are not linear potentials.
   pure subroutine add_terms(self, effects, k, t, time_unit, acts, omega, rows, tau)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: k
      !> Start and unit of time of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> The torque acts; shape (number of torques).
      logical, intent(in) :: acts(:)
      !> Coefficient k of Ω, rad/s, and of the rows R(q)ᵀeᵢ as columns; body axes; shapes (3), (3,3).
      real(wp), intent(in) :: omega(3), rows(3, 3)
      !> Body axes, N m; shape (3).
      real(wp), intent(inout) :: tau(3)
      real(wp) :: one(3), moved(3)
      integer :: i, n
      self%omega(:, k) = omega
      self%rates(1:3, k) = omega
      if (self%varies) self%absolute(:, k) = omega
      if (self%varies .and. effects%frame_turns) then
         do i = 1, 3
            self%absolute(:, k) = self%absolute(:, k) + dot_product(effects%frame_rate, self%basis(:, i))*rows(:, i)
         end do
      end if
      do n = 1, size(self%is_directed)
         if (.not. self%is_directed(n)) cycle
         self%gamma(:, k, n) = rows(:, 1)*self%components(1, n) + rows(:, 2)*self%components(2, n) &
                               + rows(:, 3)*self%components(3, n)
      end do
      moved = 0.0_wp
      call add_potentials(self, effects, k, t, time_unit, tau, moved)
      if (self%varies) moved = moved + inertia_push(k, time_unit, self%inertia, self%absolute)
      if (self%n_lanes > size(acts)) self%torque(1:3, k, self%n_lanes) = moved
      do i = 1, size(acts)
         n = abs(self%torque_slot(i))
         if (self%is_timed(i)) then
            one = self%torque(1:3, k, i)
         else if (.not. acts(i)) then
            one = 0.0_wp
         else if (n == 0) then
            one = self%drag(:, 1, i)*omega(1) + self%drag(:, 2, i)*omega(2) + self%drag(:, 3, i)*omega(3)
         else if (effects%torques(i)%item%changes_inertia) then
            call effects%torques(i)%item%series_torque( &
               k, t, time_unit, self%absolute(:, 0:k), self%gamma(:, 0:k, n), &
               self%auxiliary(n)%values, one)
         else
            call effects%torques(i)%item%series_torque( &
               k, t, time_unit, self%omega(:, 0:k), self%gamma(:, 0:k, n), &
               self%auxiliary(n)%values, one)
            if (self%torque_slot(i) < 0) call turn_to_body(self, i, k, rows, one)
         end if
         self%torque(1:3, k, i) = one
         tau = tau + one
      end do
   end subroutine add_terms

   !> Adds coefficient k of the torque of potentials with slots, and of those of them that depend on time.
   pure subroutine add_potentials(self, effects, k, t, time_unit, tau, moved)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: k
      !> Start and unit of time of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> Body axes, N m; shape (3).
      real(wp), intent(inout) :: tau(3), moved(3)
      real(wp) :: one(3)
      integer :: i, n
      do i = 1, self%n_general
         n = self%slot(i)
         associate (potential => effects%potentials(self%general(i))%item)
            if (potential%varies) then
               if (k == 0) call self%changes%expand(effects, self%general(i), t, self%moment, time_unit)
               call self%changes%get_torque(self%general(i), k, self%gamma(:, 0:k, n), one)
               moved = moved + one
               tau = tau + one
            end if
            if (self%by_moment(i)) then
               one = cross(potential%series_moment(), self%gamma(:, k, n))
            else
               call potential%series_torque(k, self%gamma(:, 0:k, n), self%auxiliary(n)%values, one)
            end if
            tau = tau + one
            if (self%mover(n) > 0 .or. potential%varies) moved = moved + one
         end associate
      end do
   end subroutine add_potentials

   !> Computes the coefficients of the inertia about the start of the series, but for the first.
   pure subroutine expand_inertia(self, effects, time_unit)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> s.
      real(wp), intent(in) :: time_unit
      integer :: j
      do j = 1, size(self%inertia, 3)
         self%inertia(:, :, j) = effects%inertia_term(j, self%start, self%moment, time_unit)
      end do
   end subroutine expand_inertia

   !> Returns Σ JⱼΩₖ₋ⱼ over j > 0, N m s; shape (3): the series of JΩ = L - h is solved for the newest coefficient of Ω.
   pure function older_momentum(self, k, time_unit, omega) result(momentum)
      class(torque_series_t), intent(in) :: self
      integer, intent(in) :: k
      !> s, and Ω times it.
      real(wp), intent(in) :: time_unit, omega(3, 0:highest_order)
      real(wp) :: momentum(3)
      integer :: j
      momentum = 0.0_wp
      do j = 1, min(size(self%inertia, 3), k)
         momentum = momentum + times_vector(self%inertia(:, :, j), omega(:, k - j))
      end do
      momentum = momentum/time_unit
   end function older_momentum

   !> Adds the work of the change of the inertia that belongs to the rate of the space axes.
   pure subroutine add_transported_work(self, time_unit)
      class(torque_series_t), intent(inout) :: self
      !> s.
      real(wp), intent(in) :: time_unit
      integer :: k
      associate (works => self%works(1 + iand(self%n_lanes - 1, lanes - 1), :, (self%n_lanes + lanes - 1)/lanes))
         do k = 1, self%order
            works(k + 1) = works(k + 1) + inverses(k)*transported_power( &
                           k - 1, time_unit, self%inertia, self%absolute, self%omega)
         end do
      end associate
   end subroutine add_transported_work

   !> Adds coefficient k of ∂τ/∂θ of all effects, θ a small rotation of the body; called after `add_terms`.
   pure subroutine add_derivatives(self, effects, k, time_unit, acts, rows, by_turn, unknown)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      integer, intent(in) :: k
      !> s.
      real(wp), intent(in) :: time_unit
      !> The torque acts; shape (number of torques).
      logical, intent(in) :: acts(:)
      !> Coefficient k of the rows R(q)ᵀeᵢ as columns.
      real(wp), intent(in) :: rows(3, 3)
      !> N m; shape (3,3).
      real(wp), intent(inout) :: by_turn(3, 3)
      !> Name of an effect without a derivative; unchanged if there is none.
      character(len=*), intent(inout) :: unknown
      integer :: i, n
      logical :: known
      do i = 1, self%n_moments
         call add_rotated(skew(self%moments(:, i)), rows(:, i), by_turn)
      end do
      if (.not. allocated(self%derivative)) allocate (self%derivative(3, 3, 0:highest_order, size(self%gamma, 3)))
      do i = 1, self%n_general
         n = self%slot(i)
         associate (potential => effects%potentials(self%general(i))%item)
            call potential%series_derivative(k, self%gamma(:, 0:k, n), self%auxiliary(n)%values, &
                                             self%derivative(:, :, k, n), known)
            if (.not. known) unknown = potential%name
            if (potential%varies) self%derivative(:, :, k, n) = self%derivative(:, :, k, n) + &
                                  self%changes%derivative(self%general(i), k, self%gamma(:, 0:k, n))
         end associate
         call add_slot(self, k, n, by_turn)
      end do
      do i = 1, size(acts)
         n = self%torque_slot(i)
         if (n == 0 .or. .not. acts(i)) cycle
         if (n < 0) then
            by_turn = by_turn + skew(self%torque(1:3, k, i))
            cycle
         end if
         associate (torque => effects%torques(i)%item)
            call torque%series_derivative(k, self%start, time_unit, self%auxiliary(n)%values, &
                                          self%derivative(:, :, k, n), known)
            if (.not. known) unknown = torque%name
         end associate
         call add_slot(self, k, n, by_turn)
      end do
   end subroutine add_derivatives

   !> Adds coefficient k of (∂τ/∂γ)[γ]× of one slot.
   pure subroutine add_slot(self, k, n, by_turn)
      class(torque_series_t), intent(in) :: self
      integer, intent(in) :: k, n
      real(wp), intent(inout) :: by_turn(3, 3)
      integer :: j
      do j = 0, k
         call add_rotated(self%derivative(:, :, j, n), self%gamma(:, k - j, n), by_turn)
      end do
   end subroutine add_slot

   !> Adds A[v]×.
   pure subroutine add_rotated(a, v, sum)
      real(wp), intent(in) :: a(3, 3), v(3)
      real(wp), intent(inout) :: sum(3, 3)
      sum(:, 1) = sum(:, 1) + (v(3)*a(:, 2) - v(2)*a(:, 3))
      sum(:, 2) = sum(:, 2) + (v(1)*a(:, 3) - v(3)*a(:, 1))
      sum(:, 3) = sum(:, 3) + (v(2)*a(:, 1) - v(1)*a(:, 2))
   end subroutine add_rotated

   !> Returns the sum of D of the linear torques that act, N m s; shape (3,3).
   pure function total_drag(self, acts) result(drag)
      class(torque_series_t), intent(in) :: self
      logical, intent(in) :: acts(:)
      real(wp) :: drag(3, 3)
      integer :: i
      drag = 0.0_wp
      do i = 1, size(acts)
         if (acts(i)) drag = drag + self%drag(:, :, i)
      end do
   end function total_drag

   !> Computes coefficient k of γ of all directions that move.
   pure subroutine move_directions(self, k, rows)
      class(torque_series_t), intent(inout) :: self
      integer, intent(in) :: k
      !> Coefficient k of the rows R(q)ᵀeᵢ as columns.
      real(wp), intent(in) :: rows(3, 3)
      integer :: n
      if (.not. self%moves) return
      self%rows(1:3, :, k) = rows
      do n = 1, size(self%mover)
         if (self%mover(n) > 0) self%gamma(:, k, n) = turned_term(k, self%rows, self%moving(:, :, self%mover(n)))
      end do
   end subroutine move_directions

   !> Returns coefficient k of a vector in body axes from its components in the basis.
   pure function turned_term(k, rows, components) result(term)
      integer, intent(in) :: k
      !> Rows R(q)ᵀeᵢ as columns, with a fourth component that fills vector registers; components after a zero; shapes
      !> (4,3, 0:highest_order), (4, 0:highest_order).
      real(wp), intent(in) :: rows(4, 3, 0:highest_order), components(4, 0:highest_order)
      real(wp) :: term(3)
      real(wp) :: sum(4), x, y, z
      integer :: i, j
      sum = 0.0_wp
      do j = 0, k
         x = components(2, j)
         y = components(3, j)
         z = components(4, j)
         do i = 1, 4
            sum(i) = sum(i) + ((rows(i, 1, k - j)*x + rows(i, 2, k - j)*y) + rows(i, 3, k - j)*z)
         end do
      end do
      term = sum(1:3)
   end function turned_term

   !> Computes the series of torques that depend on time alone.
   pure subroutine expand_timed(self, effects, t, time_unit, acts)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Start and unit of time of the series, s.
      real(wp), intent(in) :: t, time_unit
      logical, intent(in) :: acts(:)
      integer :: i
      call clear(4, size(self%torque, 3), self%order, self%torque)
      do i = 1, size(acts)
         if (.not. (self%is_timed(i) .and. acts(i))) cycle
         call effects%torques(i)%item%time_series( &
            t, time_unit, self%auxiliary(self%torque_slot(i))%values, self%torque(1:3, :self%order, i))
      end do
   end subroutine expand_timed

   !> Sets coefficients up to the order to zero. Arrays of explicit shape have constant strides.
   pure subroutine clear(n, groups, order, x)
      integer, intent(in) :: n, groups, order
      real(wp), intent(inout) :: x(n, 0:highest_order, groups)
      integer :: g
      do g = 1, groups
         x(:, :order, g) = 0.0_wp
      end do
   end subroutine clear

   !> Computes the series of each n that moves.
   pure subroutine expand_directions(self, effects, t, time_unit)
      class(torque_series_t), intent(inout) :: self
      type(effect_list_t), intent(in) :: effects
      !> Start and unit of time of the series, s.
      real(wp), intent(in) :: t, time_unit
      real(wp) :: n(3, 0:highest_order)
      integer :: i, slot
      do i = 1, self%n_general
         slot = self%slot(i)
         if (self%mover(slot) == 0) cycle
         call effects%potentials(self%general(i))%item%direction_series(t, time_unit, n(:, :self%order))
         call keep_direction(self, slot, n)
      end do
      do i = 1, effects%n_torques
         slot = abs(self%torque_slot(i))
         if (slot == 0) cycle
         if (self%mover(slot) == 0) cycle
         call effects%torques(i)%item%direction_series(t, time_unit, n(:, :self%order))
         call keep_direction(self, slot, n)
      end do
   end subroutine expand_directions

   !> Stores the series of an n that moves by its components in the basis.
   pure subroutine keep_direction(self, slot, n)
      class(torque_series_t), intent(inout) :: self
      integer, intent(in) :: slot
      !> Space axes.
      real(wp), intent(in) :: n(3, 0:highest_order)
      integer :: i, k
      do k = 0, self%order
         do i = 1, 3
            self%moving(1 + i, k, self%mover(slot)) = dot_product(self%basis(:, i), n(:, k))
         end do
      end do
   end subroutine keep_direction

   !> Computes coefficient k of R(q)ᵀν from that of ν and those before.
   pure subroutine turn_to_body(self, i, k, rows, tau)
      class(torque_series_t), intent(inout) :: self
      !> Index of the torque; coefficient.
      integer, intent(in) :: i, k
      !> Coefficient k of the rows R(q)ᵀeᵢ as columns.
      real(wp), intent(in) :: rows(3, 3)
      !> ν on entry, space axes; R(q)ᵀν on exit, body axes, N m; shape (3).
      real(wp), intent(inout) :: tau(3)
      self%rows(1:3, :, k) = rows
      self%along(2:4, k, i) = [dot_product(tau, self%basis(:, 1)), dot_product(tau, self%basis(:, 2)), &
                               dot_product(tau, self%basis(:, 3))]
      tau = turned_term(k, self%rows, self%along(:, :, i))
   end subroutine turn_to_body

   !> Computes the works of all torques, and those of the dependence on time, from the start of the series to `s`: term
   !> by term, and the tail.
   pure subroutine get_works(self, time_unit, s, tail, work, of_time, error)
      class(torque_series_t), intent(in) :: self
      !> Unit of time, s, and time in it.
      real(wp), intent(in) :: time_unit, s
      !> Tail of the series of the motion.
      type(series_tail_t), intent(in) :: tail
      !> Works of the torques, shape (number of torques), and of the dependence on time, J.
      real(wp), intent(inout) :: work(:), of_time
      !> Possible truncation error of all works together, J.
      real(wp), intent(out) :: error
      real(wp) :: sums(lanes), off(lanes)
      integer :: i, group
      error = 0.0_wp
      do group = 1, size(self%works, 3)
         call tail%sum_energies(self%order, s, self%works(:, :, group), sums, off)
         do i = 1 + lanes*(group - 1), min(lanes*group, self%n_lanes)
            if (i <= size(work)) then
               work(i) = time_unit*sums(1 + iand(i - 1, lanes - 1))
            else
               of_time = time_unit*sums(1 + iand(i - 1, lanes - 1))
            end if
            error = error + abs(time_unit)*off(1 + iand(i - 1, lanes - 1))
         end do
      end do
   end subroutine get_works

end module nutate_torque_series
