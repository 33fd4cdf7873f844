!> Inertia that varies with time: masses that move inside of the body, or that leave it.
!>
!> The inertia of the body is J(t) = J + ΔJ(t), J that of t = 0. An effect adds a ΔJ(t) that is a polynomial between two
!> times: a rate within a window, or the polynomials of a table. Masses that stay keep the angular momentum, and their
!> motors do the work ½ΔLᵀJ⁻¹L of the dependence on time, of power -½ Ωᵀ(dJ/dt)Ω. Masses that leave the body at the
!> velocity of their position carry momentum away: the torque (dJ/dt)Ω.
module nutate_inertia_change
   use nutate_body, only: body_t, diagonal, symmetric
   use nutate_effect, only: effect_t, parameter_t, torque_t, GENERAL_SERIES
   use nutate_effect_bounds, only: bounds_of_drag, effect_bounds_t, linear_map_t
   use nutate_finite, only: is_nan
   use nutate_keys, only: group_t, key_t, KEY_LOGICAL
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_piecewise, only: clamped_term, find_bounds, interval_around, next_point, piecewise_t
   use nutate_quaternion, only: rotate_to_body
   use nutate_small_products, only: skew, times_columns, times_vector
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_tabulated_torque, only: make_body_curve
   implicit none
   private

   public :: inertia_change_t, inertia_rate_keys, build_inertia_rate, make_tabulated_inertia

   !> Keys of the scene group `&inertia_rate`.
   type(key_t), parameter :: inertia_rate_keys(4) = [ &
      key_t(name='tensor', least=3, most=6, required=.true.), &
      key_t(name='start'), &
      key_t(name='stop'), &
      key_t(name='mass_leaves', kind=KEY_LOGICAL, default='.false.')]

   !> Degree of the polynomials, and index of the last coefficient of their power series.
   integer, parameter :: most_terms = 3

   !> ΔJ(t) of a constant rate within a window, or of a table.
   type, extends(torque_t) :: inertia_change_t
      !> dJ/dt within the window, body axes, kg m²/s; shape (3,3).
      real(wp) :: rate(3, 3) = 0.0_wp
      !> Start and stop of the change, s.
      real(wp) :: start = -huge(1.0_wp), stop = huge(1.0_wp)
      !> The mass leaves the body; else it stays, and the angular momentum is conserved.
      logical :: mass_leaves = .false.
      !> Number of components that the parameter of the rate has: 3 or 6.
      integer :: components = 6
      !> The change is that of a table.
      logical :: is_table = .false.
      !> Inertia of the table over its scale, kg m²: components 11, 22, 33, and, if the table has them, 12, 13, 23.
      type(piecewise_t) :: squares, products
      logical, private :: has_products = .false.
      !> Factor of the table (dimensionless).
      real(wp) :: scale = 1.0_wp
      !> Inertia of the table at t = 0, over the scale, kg m²; shape (3,3).
      real(wp), private :: first(3, 3) = 0.0_wp
      !> Bound of the norm of dJ/dt of the table, over the scale, kg m²/s.
      real(wp), private :: steepest = 0.0_wp
   contains
      !> Returns the inertia of the table at a time.
      procedure :: tabulated_at
      procedure :: torque => momentum_loss
      procedure :: derivatives => loss_derivatives
      procedure :: is_valid => change_is_valid
      procedure :: needs_attitude => never_needed
      procedure :: window => change_window
      procedure :: own_ends => ends_of_rate
      procedure :: piece => change_piece
      procedure :: next_break => change_break
      procedure :: inertia_term => term_at
      procedure :: inertia_derivative => derivative_at
      procedure :: parameters => change_parameters
      procedure :: torque_change => loss_change
      procedure :: frame_change => loss_by_frame
      procedure :: shift => change_shift
      procedure :: series_kind => loss_kind
      procedure :: series_torque => loss_series
      procedure :: series_derivative => no_derivative
      procedure :: bound => loss_bound
   end type inertia_change_t

   !> Makes a rate of the inertia.
   interface inertia_change_t
      module procedure new_inertia_rate
   end interface inertia_change_t

contains

   !> Makes a constant rate of the inertia within a window of time.
   pure function new_inertia_rate(tensor, start, stop, mass_leaves) result(change)
      !> dJ/dt, body axes, kg m²/s: 11, 22, 33, 12, 13, 23, or the first three; shape (3) or (6).
      real(wp), intent(in) :: tensor(:)
      !> Start and stop, s; default: all times. The inertia of the body is that of t = 0.
      real(wp), intent(in), optional :: start, stop
      !> The mass leaves the body; default `.false.`.
      logical, intent(in), optional :: mass_leaves
      type(inertia_change_t) :: change
      real(wp) :: six(6)
      change%name = 'inertia_rate'
      change%changes_inertia = .true.
      six = 0.0_wp
      change%components = min(6, size(tensor))
      six(:change%components) = tensor(:change%components)
      change%rate = symmetric(six)
      if (present(start)) change%start = start
      if (present(stop)) change%stop = stop
      if (present(mass_leaves)) change%mass_leaves = mass_leaves
      change%is_internal = .not. change%mass_leaves
   end function new_inertia_rate

   !> Builds a rate of the inertia from its scene group. Errors: `NUTATE_BAD_ARGUMENT` for a number of components that
   !> is not 3 or 6, and for an empty window.
   subroutine build_inertia_rate(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(inertia_change_t) :: change
      real(wp) :: tensor(group%count_of('tensor'))
      tensor = 0.0_wp
      tensor = group%vector('tensor', tensor)
      if (size(tensor) /= 3 .and. size(tensor) /= 6) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the tensor has neither three nor six numbers (expected 11, 22, 33, or '// &
                       '11, 22, 33, 12, 13, 23)', 'tensor')
         return
      end if
      change = new_inertia_rate(tensor, group%number('start', -huge(1.0_wp)), group%number('stop', huge(1.0_wp)), &
                                group%flag('mass_leaves', .false.))
      if (change%stop <= change%start) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the change stops before it starts (expected stop > start)', 'stop')
         return
      end if
      allocate (effect, source=change)
   end subroutine build_inertia_rate

   !> Makes the change of the inertia that a table describes: straight lines or a natural spline between its times, the
   !> nearest end outside of them. Errors: `NUTATE_BAD_ARGUMENT` for numbers that are not finite or above 1e100, for
   !> times that do not increase, for fewer than two, for more or fewer lines than times, for lines without three or six
   !> numbers, and for a table that does not contain t = 0.
   subroutine make_tabulated_inertia(times, tensors, change, status, at, spline, mass_leaves, scale)
      !> Times, s; shape (n).
      real(wp), intent(in) :: times(:)
      !> Inertia, body axes, kg m²: 11, 22, 33, 12, 13, 23, or the first three; shape (6, n) or (3, n).
      real(wp), intent(in) :: tensors(:, :)
      type(inertia_change_t), intent(inout) :: change
      type(status_t), intent(out) :: status
      !> The line with the error, 1 to n; 0 for none.
      integer, intent(out) :: at
      !> `spline`: a cubic spline, not linear interpolation; `mass_leaves`: the mass leaves the body. Defaults
      !> `.false.`.
      logical, intent(in), optional :: spline, mass_leaves
      !> Factor of the tensors; default 1.
      real(wp), intent(in), optional :: scale
      type(piecewise_t) :: squares, products
      logical :: smooth
      real(wp) :: bounds(0:2)
      smooth = .false.
      if (present(spline)) smooth = spline
      if (all(size(tensors, 1) /= [3, 6])) then
         at = 0
         status = fail(NUTATE_BAD_ARGUMENT, 'a line of the table has a wrong length (expected three numbers or six)', &
                       'inertia_table')
         return
      end if
      call make_body_curve(times, tensors(1:3, :), smooth, 'the inertia', 'inertia_table', squares, status, at)
      if (size(tensors, 1) > 3 .and. status%ok()) &
         call make_body_curve(times, tensors(4:6, :), smooth, 'the inertia', 'inertia_table', products, status, at)
      if (.not. status%ok()) return
      change = new_inertia_rate([0.0_wp, 0.0_wp, 0.0_wp], times(1), times(size(times)), mass_leaves)
      change%name = 'inertia_table'
      change%is_table = .true.
      change%has_products = size(tensors, 1) > 3
      change%squares = squares
      if (change%has_products) change%products = products
      change%first = change%tabulated_at(0.0_wp)
      call find_bounds(change%squares, bounds)
      change%steepest = bounds(1)
      if (change%has_products) call find_bounds(change%products, bounds)
      if (change%has_products) change%steepest = change%steepest + sqrt(2.0_wp)*bounds(1)
      if (present(scale)) change%scale = scale
   end subroutine make_tabulated_inertia

   !> Returns the inertia of the table at a time, over the scale, kg m²; shape (3,3).
   pure function tabulated_at(self, t) result(inertia)
      class(inertia_change_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: inertia(3, 3)
      inertia = table_term(self, 0, t, t, 1.0_wp)
   end function tabulated_at

   !> Returns coefficient j of the power series of ΔJ(t), body axes, kg m²; shape (3,3): ΔJ is zero at t = 0.
   pure function term_at(self, j, t, moment, unit) result(term)
      class(inertia_change_t), intent(in) :: self
      integer, intent(in) :: j
      real(wp), intent(in) :: t, moment, unit
      real(wp) :: term(3, 3)
      if (self%is_table) then
         term = table_term(self, j, t, moment, unit)
         if (j == 0) term = term - self%first
         term = self%scale*term
      else
         term = rate_term(self, j, t, moment, unit)*self%rate
      end if
   end function term_at

   !> Returns coefficient j of the time for which a constant rate has acted since t = 0, s.
   pure real(wp) function rate_term(self, j, t, moment, unit) result(time)
      type(inertia_change_t), intent(in) :: self
      integer, intent(in) :: j
      real(wp), intent(in) :: t, moment, unit
      time = 0.0_wp
      if (j == 0) then
         time = min(max(t, self%start), self%stop) - min(max(0.0_wp, self%start), self%stop)
      else if (j == 1 .and. moment >= self%start .and. moment <= self%stop) then
         time = unit
      end if
   end function rate_term

   !> Returns coefficient j of the inertia of a table, over the scale, kg m²; shape (3,3).
   pure function table_term(self, j, t, moment, unit) result(term)
      type(inertia_change_t), intent(in) :: self
      integer, intent(in) :: j
      real(wp), intent(in) :: t, moment, unit
      real(wp) :: term(3, 3)
      real(wp) :: six(6)
      six = 0.0_wp
      six(1:3) = clamped_term(self%squares, j, t, moment, unit)
      if (self%has_products) six(4:6) = clamped_term(self%products, j, t, moment, unit)
      term = symmetric(six)
   end function table_term

   !> Returns dJ/dt, body axes, kg m²/s; shape (3,3).
   pure function rate_at(self, t) result(rate)
      type(inertia_change_t), intent(in) :: self
      !> Time inside of the piece, s.
      real(wp), intent(in) :: t
      real(wp) :: rate(3, 3)
      rate = self%inertia_term(1, t, t, 1.0_wp)
   end function rate_at

   !> Computes coefficient k of the series of (dJ/dt)Ω of masses that leave.
   pure subroutine loss_series(self, k, t, time_unit, omega, gamma, auxiliary, tau)
      class(inertia_change_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit, omega(3, 0:k), gamma(3, 0:k)
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      integer :: j
      tau = 0.0_wp
      if (.not. self%mass_leaves) return
      do j = 1, min(most_terms, k + 1)
         tau = tau + times_vector((j/time_unit)*self%inertia_term(j, t, t, time_unit), omega(:, k + 1 - j))
      end do
   end subroutine loss_series

   !> Returns `GENERAL_SERIES`.
   pure integer function loss_kind(self)
      class(inertia_change_t), intent(in) :: self
      loss_kind = GENERAL_SERIES
   end function loss_kind

   !> Returns the change of coefficient j of ΔJ(t), or, for a table, of the whole J(t), by a change of `parameters`,
   !> kg m²; shape (3,3).
   pure function derivative_at(self, change, j, t, moment, unit) result(derivative)
      class(inertia_change_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: j
      real(wp), intent(in) :: t, moment, unit
      real(wp) :: derivative(3, 3)
      if (self%is_table) then
         derivative = change(1)*table_term(self, j, t, moment, unit)
      else
         derivative = rate_term(self, j, t, moment, unit)*tensor_of(change)
      end if
   end function derivative_at

   !> Computes the derivative of the series of the torque by the attitude: zero.
   pure subroutine no_derivative(self, k, t, time_unit, auxiliary, derivative, known)
      class(inertia_change_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: derivative(3, 3)
      logical, intent(out) :: known
      derivative = 0.0_wp
      known = .true.
   end subroutine no_derivative

   !> Returns the tensor of three or six components.
   pure function tensor_of(numbers) result(tensor)
      real(wp), intent(in) :: numbers(:)
      real(wp) :: tensor(3, 3)
      if (size(numbers) > 3) then
         tensor = symmetric(numbers(1:6))
      else
         tensor = diagonal(numbers(1:3))
      end if
   end function tensor_of

   !> Returns (dJ/dt)Ω of masses that leave, body axes, N m; zero for masses that stay.
   pure function momentum_loss(self, t, q, omega) result(tau)
      class(inertia_change_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
      if (self%mass_leaves) tau = times_vector(rate_at(self, t), self%absolute_rate(q, omega))
   end function momentum_loss

   !> Computes ∂τ/∂θ, which rotating space axes alone cause, and ∂τ/∂Ω = dJ/dt.
   pure subroutine loss_derivatives(self, t, q, omega, by_rotation, by_rate)
      class(inertia_change_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: by_rotation(3, 3), by_rate(3, 3)
      by_rotation = 0.0_wp
      by_rate = 0.0_wp
      if (.not. self%mass_leaves) return
      by_rate = rate_at(self, t)
      if (any(abs(self%frame_rate) > 0.0_wp)) &
         by_rotation = times_columns(by_rate, skew(rotate_to_body(q, self%frame_rate)))
   end subroutine loss_derivatives

   !> Bounds the torque and its derivatives in a step: it is linear in Ω, and zero for masses that stay. There are no
   !> bounds in rotating space axes.
   pure subroutine loss_bound(self, map, radius, gamma, slack, bounds)
      class(inertia_change_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      real(wp) :: steepest
      if (.not. self%mass_leaves) return
      steepest = norm2(self%rate)
      if (self%is_table) steepest = abs(self%scale)*self%steepest
      bounds%known = is_moderate(steepest) .and. .not. any(abs(self%frame_rate) > 0.0_wp)
      if (.not. bounds%known) return
      bounds = bounds_of_drag(map, radius, diagonal([steepest, steepest, steepest]))
   end subroutine loss_bound

   !> Returns the change of the torque by a change of the rate of the space axes, body axes, N m; shape (3).
   pure function loss_by_frame(self, change, t, q, omega) result(tau)
      class(inertia_change_t), intent(in) :: self
      real(wp), intent(in) :: change(3), t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
      if (self%mass_leaves) tau = times_vector(rate_at(self, t), rotate_to_body(q, change))
   end function loss_by_frame

   !> Returns the change of the torque by a change of `parameters`, body axes, N m; shape (3).
   pure function loss_change(self, change, t, q, omega) result(tau)
      class(inertia_change_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
      if (self%mass_leaves) &
         tau = times_vector(self%inertia_derivative(change, 1, t, t, 1.0_wp), self%absolute_rate(q, omega))
   end function loss_change

   !> Adds a change of `parameters`.
   logical function change_shift(self, change)
      class(inertia_change_t), intent(inout) :: self
      real(wp), intent(in) :: change(:)
      if (self%is_table) then
         self%scale = self%scale + change(1)
      else
         self%rate = self%rate + tensor_of(change)
      end if
      change_shift = .true.
   end function change_shift

   !> Returns the parameters: the components of a rate, or the factor of a table.
   pure function change_parameters(self) result(list)
      class(inertia_change_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      if (self%is_table) then
         list = [parameter_t('inertia_scale', 1)]
      else
         list = [parameter_t('tensor', self%components)]
      end if
   end function change_parameters

   !> Returns true if the numbers can be computed with; `start` and `stop` need only be comparable.
   pure logical function change_is_valid(self)
      class(inertia_change_t), intent(in) :: self
      change_is_valid = all(is_moderate(self%rate)) .and. all(is_moderate(self%first)) .and. &
                        .not. (is_nan(self%start) .or. is_nan(self%stop)) .and. &
                        (self%squares%n > 0 .or. .not. self%is_table)
   end function change_is_valid

   !> Returns false: the torque depends on the rate alone.
   pure logical function never_needed(self)
      class(inertia_change_t), intent(in) :: self
      never_needed = .false.
   end function never_needed

   !> Returns the times between which the inertia changes, s.
   pure subroutine change_window(self, start, stop)
      class(inertia_change_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = self%start
      stop = self%stop
   end subroutine change_window

   !> Returns true for the ends of the window of a rate; those of a table are no parameters.
   pure function ends_of_rate(self) result(own)
      class(inertia_change_t), intent(in) :: self
      logical :: own(2)
      own = .not. self%is_table
   end function ends_of_rate

   !> Returns the interval around a time in which the inertia is one polynomial, s.
   pure subroutine change_piece(self, moment, start, stop)
      class(inertia_change_t), intent(in) :: self
      real(wp), intent(in) :: moment
      real(wp), intent(out) :: start, stop
      start = -huge(1.0_wp)
      stop = huge(1.0_wp)
      if (self%is_table) call interval_around(self%squares, moment, start, stop)
   end subroutine change_piece

   !> Returns the next time at which the inertia changes to another polynomial, s.
   pure real(wp) function change_break(self, t, sense) result(next)
      class(inertia_change_t), intent(in) :: self
      real(wp), intent(in) :: t, sense
      next = sense*huge(next)
      if (self%is_table) then
         next = next_point(self%squares, t, sense)
         return
      end if
      if (sense*self%start > sense*t) next = self%start
      if (sense*self%stop > sense*t .and. sense*self%stop < sense*next) next = self%stop
   end function change_break

end module nutate_inertia_change
