!> Torques in body axes, which do work.
module nutate_torque
   use nutate_archive, only: archive_t
   use nutate_effect_base, only: effect_t, parameter_t, SPACE_SERIES, TIME_SERIES
   use nutate_effect_bounds, only: bounds_of_torque, effect_bounds_t, linear_map_t
   use nutate_effect_traits, only: IS_CONTROLLER, IS_LAW
   use nutate_kinds, only: wp, eps
   use nutate_power_series, only: highest_order
   use nutate_quaternion, only: quat_product, rotate_to_body
   use nutate_saturation_count, only: saturation_count_t, transfer_integers, number_at, note_saturation, transfer_count
   implicit none
   private

   public :: torque_t, transfer_torque
   public :: count_saturations, n_saturations

   !> A torque in body axes that is not the gradient of a potential; its work enters the energy balance.
   type, abstract, extends(effect_t) :: torque_t
      !> True if the n of `series_direction` is time-dependent, and a bound of its rate relative to |n|, 1/s.
      logical :: moves = .false.
      real(wp) :: pace = 0.0_wp
      !> Rate ω of the space axes, in these axes, rad/s; set by the list of effects; shape (3).
      real(wp) :: frame_rate(3) = 0.0_wp
      !> Sampling period of a control law, s; 0: it acts at all times, as does everything that is no controller.
      real(wp) :: sample = 0.0_wp
      !> True if the law was on at the last sample.
      logical :: was_on = .false.
      !> Limit of each component of the command of a control law, N m or A m².
      real(wp) :: limit = huge(1.0_wp)
      !> 1: a component of a command that acts at all times is above the limit; -1: below the negative limit; 0:
      !> neither. Set by runs at events; shape (3).
      integer :: saturated(3) = 0
      !> sgn(e₀) as runs hold it between the zeros of e₀; 0: it follows e₀.
      integer :: sense = 0
      !> Count of how often a component has reached the limit.
      type(saturation_count_t) :: saturations = saturation_count_t()
      !> Side of a motor, 1: the wheel has reached the limit of its speed; -1: the negative limit; 0: neither. If the
      !> law commands to push the wheel further, the motor is blocked and gives no torque. Set by runs.
      integer :: at_limit = 0
      logical :: blocked = .false.
      !> True if the effect changes the inertia of the body with time, and true if it exerts no torque from outside.
      logical :: changes_inertia = .false., is_internal = .false.
      !> True if the effect moves the centre of mass in the body with time.
      logical :: moves_center = .false.
   contains
      !> Returns the command of a control law before its limit, N m or A m², body axes; component 1 for a motor; zero
      !> unless overridden; shape (3).
      procedure :: command => no_command
      !> Returns how many components of a command that acts at all times the limit applies to; 0 unless overridden.
      procedure :: n_limited => no_components
      !> Return e₀ with its sign, and the angle between attitude and target, rad; zero unless overridden.
      procedure :: error_scalar => no_error
      procedure :: error_angle => no_error
      !> Sets `sense`.
      procedure :: hold_sense
      !> Samples a control law and holds its command; nothing unless overridden.
      procedure :: hold => no_sample
      !> Returns the torque that a sampled law commands from the motor of a wheel, N m; zero unless overridden.
      procedure :: wheel_command => no_wheel_command
      !> Returns the command, and the part of it that is applied, without that of wheels; zero unless overridden; shape
      !> (6).
      procedure :: commands_at => no_commands
      !> Adds a change of `parameters` to the effect itself; false unless overridden.
      procedure :: shift => not_shifted
      !> Return the parameters that the torque has as the motor of a wheel, and the change of `parameters` by a change
      !> of them.
      procedure :: drive_parameters
      procedure :: drive_change
      procedure :: own_window => window_of_torque
      procedure :: transfer => transfer_torque
      !> Returns τ(t, q, Ω), body axes, N m; Ω relative to the space axes.
      procedure(body_torque), deferred :: torque
      !> Computes ∂τ/∂θ (θ a small body rotation) and ∂τ/∂Ω; by differences unless overridden.
      procedure :: derivatives => difference_derivatives
      !> Returns the times between which the torque acts, s; steps end on them. Outside of them `torque` is not called.
      procedure :: window => always
      !> Returns which ends of the window are the torque's own parameters, `start` and `stop`: both unless overridden.
      procedure :: own_ends => both_ends
      !> Returns true if the torque acts at a time.
      procedure :: acts_at
      !> Returns the interval around a time in which the torque, at fixed attitude and rate, is a smooth function of
      !> time; all times unless overridden. A step inside of it calls `torque` at no other times.
      procedure :: piece => one_piece
      !> Returns the next time at which the torque starts, stops or goes from one smooth piece to another; steps end on
      !> it. The ends of the window unless overridden.
      procedure :: next_break => next_end
      procedure :: bound => bound_torque
      !> Returns ∂τ/∂t at fixed attitude and rate; by differences unless overridden. Called only for a torque whose
      !> `bound` reports that it changes.
      procedure :: time_derivative => difference_in_time
      !> Returns true if the torque depends on the attitude; `.true.` unless overridden.
      procedure :: needs_attitude => attitude_needed
      !> Returns D of a linear series: τ = DΩ; body axes, N m s.
      procedure :: series_drag => no_drag
      !> Returns n, space axes, of a torque that depends on γ = R(q)ᵀn; else zero.
      procedure :: series_direction => no_direction
      !> Computes the power series of a time-dependent n; constant unless overridden.
      procedure :: direction_series => fixed_series
      !> Computes a coefficient of a general series of τ, body axes; space axes for `SPACE_SERIES`.
      procedure :: series_torque => no_torque
      !> Computes all coefficients of a `TIME_SERIES`, by `series_torque` unless overridden.
      procedure :: time_series => series_by_terms
      !> Compute a coefficient of the derivative by γ of a general series that does not depend on Ω, and of the change
      !> of τ by a change of `parameters` at fixed γ; not known unless overridden.
      procedure :: series_derivative => no_series_derivative
      procedure :: series_change => no_series_change
      !> Computes the power series of the change of n by a change of `parameters`; zero unless overridden.
      procedure :: direction_change_series => no_direction_change
      !> Returns the change of τ by a change of `parameters` at fixed time, attitude and rate; zero unless overridden.
      procedure :: torque_change => no_torque_change
      !> Returns the change of τ by a change of the rate of the space axes, at fixed Ω relative to them; zero unless
      !> overridden.
      procedure :: frame_change => no_frame_change
      !> Return a coefficient of the power series of what the effect adds to the inertia of the body, and its change by
      !> a change of `parameters`; zero unless overridden.
      procedure :: inertia_term => no_inertia_term
      procedure :: inertia_derivative => no_inertia_derivative
      !> Returns the absolute angular velocity, relative to the stars.
      procedure, non_overridable :: absolute_rate
   end type torque_t

   abstract interface
      !> Returns τ, body axes, N m; shape (3).
      pure function body_torque(self, t, q, omega) result(tau)
         import :: torque_t, wp
         class(torque_t), intent(in) :: self
         !> Time, s.
         real(wp), intent(in) :: t
         !> Attitude, unit quaternion, body→space; shape (4).
         real(wp), intent(in) :: q(4)
         !> Ω relative to the space axes, body axes, rad/s; shape (3). `absolute_rate` adds the rate of these axes.
         real(wp), intent(in) :: omega(3)
         real(wp) :: tau(3)
      end function body_torque
   end interface

contains

   !> Returns zero: the torque follows from no control law.
   pure function no_command(self, t, q, omega) result(command)
      class(torque_t), intent(in) :: self
      !> Time, s; attitude, unit quaternion, body→space, shape (4); Ω relative to the space axes, body axes, rad/s,
      !> shape (3).
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: command(3)
      command = 0.0_wp
   end function no_command

   !> Returns 0: there is no limit.
   pure integer function no_components(self)
      class(torque_t), intent(in) :: self
      no_components = 0
   end function no_components

   !> Returns zero: there is no target.
   pure real(wp) function no_error(self, t, q)
      class(torque_t), intent(in) :: self
      !> Time, s; attitude, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: t, q(4)
      no_error = 0.0_wp
   end function no_error

   !> Sets the sign of e₀.
   pure subroutine hold_sense(self, sense)
      class(torque_t), intent(inout) :: self
      !> Sign, 1 or -1; 0: it follows e₀.
      integer, intent(in) :: sense
      self%sense = sense
   end subroutine hold_sense

   !> Does nothing: there is no law to sample.
   pure subroutine no_sample(self, t, q, omega, moment)
      class(torque_t), intent(inout) :: self
      !> Time of the sample, s; attitude and rate as in `command`.
      real(wp), intent(in) :: t, q(4), omega(3)
      !> A time inside the interval that follows, s: it decides whether the window is open.
      real(wp), intent(in) :: moment
   end subroutine no_sample

   !> Returns zero.
   pure real(wp) function no_wheel_command(self, wheel)
      class(torque_t), intent(in) :: self
      integer, intent(in) :: wheel
      no_wheel_command = 0.0_wp
   end function no_wheel_command

   !> Returns zeros.
   pure function no_commands(self, t, q, omega) result(commands)
      class(torque_t), intent(in) :: self
      !> Time, attitude and Ω as in `command`.
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: commands(6)
      commands = 0.0_wp
   end function no_commands

   !> Counts components that have reached the limit: to be called before and after changes of limits and switches.
   pure subroutine count_saturations(self, t)
      class(torque_t), intent(inout) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: start, stop
      if (.not. (self%n_limited() > 0 .and. self%limit < huge(self%limit))) return
      call self%window(start, stop)
      call note_saturation(self%saturations, t, self%saturated, self%on, start, stop)
   end subroutine count_saturations

   !> Returns how often a component has reached its limit, the present time included.
   pure integer function n_saturations(self, t)
      class(torque_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: start, stop
      n_saturations = self%saturations%number
      if (self%n_limited() == 0) return
      call self%window(start, stop)
      n_saturations = number_at(self%saturations, t, self%saturated, self%on, start, stop)
   end function n_saturations

   !> Returns false: no change is added to the parameters of the torque itself.
   logical function not_shifted(self, change)
      class(torque_t), intent(inout) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      not_shifted = .false.
   end function not_shifted

   !> Returns the parameters as the motor of a wheel. Here: those of the torque.
   pure function drive_parameters(self) result(list)
      class(torque_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = self%parameters()
   end function drive_parameters

   !> Returns the change of `parameters` by a change of `drive_parameters`. Here: that change.
   pure function drive_change(self, change) result(of_torque)
      class(torque_t), intent(in) :: self
      !> Change of `drive_parameters`.
      real(wp), intent(in) :: change(:)
      real(wp), allocatable :: of_torque(:)
      of_torque = change
   end function drive_change

   !> Returns the times between which the torque acts, s.
   pure subroutine window_of_torque(self, start, stop)
      class(torque_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      call self%window(start, stop)
   end subroutine window_of_torque

   !> Writes or reads whether the torque is on, and what runs have set for a law at its limits.
   subroutine transfer_torque(self, archive)
      class(torque_t), intent(inout) :: self
      class(archive_t), intent(inout) :: archive
      call archive%transfer(self%on)
      if (.not. (self%has(IS_CONTROLLER) .or. self%has(IS_LAW))) return
      call transfer_integers(self%saturated, archive)
      call archive%transfer(self%sense)
      call archive%transfer(self%at_limit)
      call archive%transfer(self%blocked)
      call transfer_count(self%saturations, archive)
      if (archive%is_reading()) call self%hold_sense(self%sense)
   end subroutine transfer_torque

   !> Bounds a torque in a step from the bounds that the user gave.
   pure subroutine bound_torque(self, map, radius, gamma, slack, bounds)
      class(torque_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      bounds%known = self%given(1) >= 0.0_wp
      if (bounds%known) &
         bounds = bounds_of_torque(map, radius, self%given(1), self%given(2), self%given(3), self%given(4))
   end subroutine bound_torque

   !> Computes the derivatives by central differences of τ. The steps suit a torque that varies over angles of order 1
   !> and rates of order |Ω|.
   pure subroutine difference_derivatives(self, t, q, omega, by_rotation, by_rate)
      class(torque_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Ω, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> ∂τ/∂θ, θ a rotation vector in body axes: q → q∘exp(θ/2).
      real(wp), intent(out) :: by_rotation(3, 3)
      !> ∂τ/∂Ω, body axes.
      real(wp), intent(out) :: by_rate(3, 3)
      real(wp) :: h, shift(3)
      integer :: i
      by_rotation = 0.0_wp
      h = eps**(1.0_wp/3)
      if (self%needs_attitude()) then
         do i = 1, 3
            shift = 0.0_wp
            shift(i) = 0.5_wp*h
            by_rotation(:, i) = (self%torque(t, rotated(q, shift), omega) &
                                 - self%torque(t, rotated(q, -shift), omega))/(2*h)
         end do
      end if
      h = h*max(norm2(omega), 1.0_wp)
      do i = 1, 3
         shift = 0.0_wp
         shift(i) = h
         by_rate(:, i) = (self%torque(t, q, omega + shift) - self%torque(t, q, omega - shift))/(2*h)
      end do
   end subroutine difference_derivatives

   !> Computes ∂τ/∂t by a central difference over ε^(1/3) times `span`.
   pure function difference_in_time(self, t, q, omega, span) result(derivative)
      class(torque_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> Attitude, unit quaternion, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Ω, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> Time in which τ may change much, s; not 0.
      real(wp), intent(in) :: span
      !> Body axes, N m/s; shape (3).
      real(wp) :: derivative(3)
      real(wp) :: h
      h = eps**(1.0_wp/3)*span
      derivative = (self%torque(t + h, q, omega) - self%torque(t - h, q, omega))/(2*h)
   end function difference_in_time

   !> Returns q∘(1, half) normalised: q rotated by about the small body rotation 2 half.
   pure function rotated(q, half) result(r)
      real(wp), intent(in) :: q(4), half(3)
      real(wp) :: r(4)
      r = quat_product(q, [1.0_wp, half])
      r = r/norm2(r)
   end function rotated

   !> Returns the times between which the torque acts. Here: all times.
   pure subroutine always(self, start, stop)
      class(torque_t), intent(in) :: self
      !> Start and stop, s.
      real(wp), intent(out) :: start, stop
      start = -huge(1.0_wp)
      stop = huge(1.0_wp)
   end subroutine always

   !> Returns which ends of the window move with `start` and `stop`; shape (2). Here: both.
   pure function both_ends(self) result(own)
      class(torque_t), intent(in) :: self
      logical :: own(2)
      own = .true.
   end function both_ends

   !> Returns true inside the window and at its ends, for a torque that is on.
   pure logical function acts_at(self, t)
      class(torque_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: start, stop
      call self%window(start, stop)
      acts_at = t >= start .and. t <= stop .and. self%on
   end function acts_at

   !> Returns the interval around a time in which the torque is smooth. Here: all times.
   pure subroutine one_piece(self, moment, start, stop)
      class(torque_t), intent(in) :: self
      !> A time inside of a step, s.
      real(wp), intent(in) :: moment
      !> Start and stop, s.
      real(wp), intent(out) :: start, stop
      start = -huge(1.0_wp)
      stop = huge(1.0_wp)
   end subroutine one_piece

   !> Returns the first end of the window after a time, s; beyond all times if there is none.
   pure real(wp) function next_end(self, t, sense) result(next)
      class(torque_t), intent(in) :: self
      !> Time, s, and direction of time: 1 or -1.
      real(wp), intent(in) :: t, sense
      real(wp) :: ends(2)
      integer :: i
      call self%window(ends(1), ends(2))
      next = sense*huge(next)
      do i = 1, 2
         ! Times are compared without differences, which could overflow.
         if (sense*ends(i) > sense*t .and. sense*ends(i) < sense*next) next = ends(i)
      end do
   end function next_end

   !> Returns true: the torque may depend on the attitude.
   pure logical function attitude_needed(self)
      class(torque_t), intent(in) :: self
      attitude_needed = .true.
   end function attitude_needed

   !> Returns D of τ = DΩ, N m s; shape (3,3). Here: zero.
   pure function no_drag(self) result(drag)
      class(torque_t), intent(in) :: self
      real(wp) :: drag(3, 3)
      drag = 0.0_wp
   end function no_drag

   !> Returns n of γ = R(q)ᵀn, space axes; shape (3). Here: zero, the torque depends on no direction.
   pure function no_direction(self) result(direction)
      class(torque_t), intent(in) :: self
      real(wp) :: direction(3)
      direction = 0.0_wp
   end function no_direction

   !> Computes the coefficients of the power series of n about a time. Here: a constant.
   pure subroutine fixed_series(self, t, time_unit, n)
      class(torque_t), intent(in) :: self
      !> Time t₀ and time unit of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> Space axes; shape (3, 0:order).
      real(wp), intent(out) :: n(:, 0:)
      n = 0.0_wp
      n(:, 0) = self%series_direction()
   end subroutine fixed_series

   !> Computes coefficient k of the power series of τ. Here: zero.
   pure subroutine no_torque(self, k, t, time_unit, omega, gamma, auxiliary, tau)
      class(torque_t), intent(in) :: self
      integer, intent(in) :: k
      !> t₀ and the unit of time of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> Coefficients 0..k of Ω and of γ, body axes; shape (3, 0:k). γ is zero if there is no `series_direction`.
      real(wp), intent(in) :: omega(3, 0:k), gamma(3, 0:k)
      !> Coefficients 0..k-1 of the auxiliary series on entry, 0..k on exit; shape (0:highest_order,
      !> auxiliary_series()).
      real(wp), intent(inout) :: auxiliary(0:, :)
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      tau = 0.0_wp
   end subroutine no_torque

   !> Computes the coefficients of a torque that depends on time alone, body axes, N m.
   pure subroutine series_by_terms(self, t, time_unit, auxiliary, tau)
      class(torque_t), intent(in) :: self
      !> t₀ and the unit of time of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> Auxiliary series; shape (0:highest_order, auxiliary_series()).
      real(wp), intent(inout) :: auxiliary(0:, :)
      !> Shape (3, 0:order).
      real(wp), intent(out) :: tau(:, 0:)
      real(wp), parameter :: none(3, 0:highest_order) = 0.0_wp
      integer :: k
      do k = 0, ubound(tau, 2)
         call self%series_torque(k, t, time_unit, none(:, 0:k), none(:, 0:k), auxiliary, tau(:, k))
      end do
   end subroutine series_by_terms

   !> Computes coefficient k of ∂τ/∂γ; called after `series_torque`. Here: zero for a series of the
   !> time alone; others are not known.
   pure subroutine no_series_derivative(self, k, t, time_unit, auxiliary, derivative, known)
      class(torque_t), intent(in) :: self
      integer, intent(in) :: k
      !> t₀ and the unit of time of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> Auxiliary series as `series_torque` left them; shape (0:highest_order, auxiliary_series()).
      real(wp), intent(inout) :: auxiliary(0:, :)
      !> Body axes, N m over the unit of γ; shape (3,3).
      real(wp), intent(out) :: derivative(3, 3)
      logical, intent(out) :: known
      derivative = 0.0_wp
      known = any(self%series_kind() == [SPACE_SERIES, TIME_SERIES])
   end subroutine no_series_derivative

   !> Computes coefficient k of the change of τ at fixed γ; called after `series_derivative`. Here: it is not known.
   pure subroutine no_series_change(self, change, k, t, time_unit, gamma, auxiliary, tau, known)
      class(torque_t), intent(in) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: k
      !> t₀ and the unit of time of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> Coefficients 0..k of γ, body axes; shape (3, 0:k).
      real(wp), intent(in) :: gamma(3, 0:k)
      real(wp), intent(in) :: auxiliary(0:, :)
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      tau = 0.0_wp
      known = .false.
   end subroutine no_series_change

   !> Computes the coefficients of the change of n about a time. Here: zero.
   pure subroutine no_direction_change(self, change, t, time_unit, n)
      class(torque_t), intent(in) :: self
      !> Change of `parameters`; time t₀ and time unit of the series, s.
      real(wp), intent(in) :: change(:), t, time_unit
      !> Space axes; shape (3, 0:order).
      real(wp), intent(out) :: n(:, 0:)
      n = 0.0_wp
   end subroutine no_direction_change

   !> Returns the change of τ, body axes, N m; shape (3).
   pure function no_torque_change(self, change, t, q, omega) result(tau)
      class(torque_t), intent(in) :: self
      !> Change of `parameters`; time, s.
      real(wp), intent(in) :: change(:), t
      !> Attitude, unit quaternion, body→space, shape (4); Ω, body axes, rad/s, shape (3).
      real(wp), intent(in) :: q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
   end function no_torque_change

   !> Returns the change of τ, body axes, N m; shape (3). Here: zero.
   pure function no_frame_change(self, change, t, q, omega) result(tau)
      class(torque_t), intent(in) :: self
      !> Change of the rate of the space axes, in these axes, rad/s, shape (3); other arguments are those of
      !> `torque`.
      real(wp), intent(in) :: change(3), t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = 0.0_wp
   end function no_frame_change

   !> Returns coefficient j of the power series about a time of what the effect adds to the inertia: the j-th derivative
   !> times unitʲ/j!, body axes, kg m²; shape (3,3). Here: zero.
   pure function no_inertia_term(self, j, t, moment, unit) result(term)
      class(torque_t), intent(in) :: self
      integer, intent(in) :: j
      !> Time, a time inside of the smooth piece whose series is meant, and unit of time, s.
      real(wp), intent(in) :: t, moment, unit
      real(wp) :: term(3, 3)
      term = 0.0_wp
   end function no_inertia_term

   !> Returns the change of `inertia_term` by a change of `parameters`, body axes, kg m²; shape (3,3): for coefficient
   !> 0 that of the whole inertia, also at t = 0. Here: zero.
   pure function no_inertia_derivative(self, change, j, t, moment, unit) result(derivative)
      class(torque_t), intent(in) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      !> As in `inertia_term`.
      integer, intent(in) :: j
      real(wp), intent(in) :: t, moment, unit
      real(wp) :: derivative(3, 3)
      derivative = 0.0_wp
   end function no_inertia_derivative

   !> Returns the angular velocity relative to the stars, body axes, rad/s; shape (3): Ω + R(q)ᵀω.
   pure function absolute_rate(self, q, omega) result(rate)
      class(torque_t), intent(in) :: self
      !> Attitude, unit quaternion, body→space, shape (4); Ω relative to the space axes, body axes, rad/s, shape (3).
      real(wp), intent(in) :: q(4), omega(3)
      real(wp) :: rate(3)
      rate = omega
      if (any(abs(self%frame_rate) > 0.0_wp)) rate = rate + rotate_to_body(q, self%frame_rate)
   end function absolute_rate

end module nutate_torque
