!> A torque applied along axes of the body or of space, harmonic in time, within a window of time:
!> τ = τ₀ cos(2πft + phase) from start to stop.
module nutate_applied_torque
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, GENERAL_SERIES, parameter_t, TIME_SERIES, torque_t
   use nutate_effect_bounds, only: effect_bounds_t, let_change, linear_map_t
   use nutate_finite, only: is_nan
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp, pi
   use nutate_limits, only: is_moderate
   use nutate_quaternion, only: rotate_to_body
   use nutate_power_series, only: cosine_term, highest_order, inverses
   use nutate_small_products, only: lies_along, skew, times_vector, vector_length
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: applied_torque_t, applied_torque_keys, build_applied_torque

   !> Keys of the scene group `&torque`; the last four belong to a tabulated torque (`nutate_tabulated_torque`).
   type(key_t), parameter :: applied_torque_keys(10) = [ &
      key_t(name='body', least=3, most=3), &
      key_t(name='space', least=3, most=3), &
      key_t(name='frequency', default='0', beside='body,space'), &
      key_t(name='phase', default='0', beside='body,space'), &
      key_t(name='start'), &
      key_t(name='stop'), &
      key_t(name='table', kind=KEY_TEXT), &
      key_t(name='interpolation', kind=KEY_TEXT, choices='linear,cubic', default='linear', beside='table'), &
      key_t(name='outside', kind=KEY_TEXT, choices='zero,periodic', default='zero', beside='table'), &
      key_t(name='axes', kind=KEY_TEXT, choices='body,space', default='body', beside='table')]

   !> τ₀ cos(2πft + phase) from start to stop.
   type, extends(torque_t) :: applied_torque_t
      !> τ₀, N m; shape (3).
      real(wp) :: amplitude(3) = 0.0_wp
      !> True if τ₀ is given in space axes; else in body axes.
      logical :: in_space = .false.
      !> f, Hz.
      real(wp) :: frequency = 0.0_wp
      !> Phase, rad.
      real(wp) :: phase = 0.0_wp
      !> Start and stop of the torque, s.
      real(wp) :: start = -huge(1.0_wp), stop = huge(1.0_wp)
   contains
      procedure :: torque => applied_torque
      procedure :: is_valid => torque_is_valid
      procedure :: derivatives => applied_derivatives
      procedure :: window => applied_window
      procedure :: needs_attitude => attitude_in_space
      procedure :: bound => applied_bound
      procedure :: time_derivative => applied_time_derivative
      procedure :: series_kind => harmonic_series
      procedure :: auxiliary_series => harmonic_auxiliary
      procedure :: series_direction => amplitude_in_space
      procedure :: series_torque => harmonic_torque
      procedure :: time_series => harmonic_time_series
      procedure :: series_derivative => harmonic_series_derivative
      procedure :: series_change => harmonic_series_change
      procedure :: direction_change_series => amplitude_change
      procedure :: has_axis => torque_has_axis
      procedure :: parameters => applied_parameters
      procedure :: torque_change => applied_change
      procedure :: drive_parameters => parameters_of_motor
      procedure :: drive_change => change_of_motor
   end type applied_torque_t

contains

   !> Builds a torque from its scene group.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` if not exactly one of body and space is given, the window is empty, or a key needs a
   !> table.
   subroutine build_applied_torque(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(applied_torque_t) :: torque
      real(wp), parameter :: none(3) = 0.0_wp
      character(len=13), parameter :: of_table(3) = [character(len=13) :: 'interpolation', 'outside', 'axes']
      integer :: i
      torque%name = 'torque'
      if (group%has('body') .and. group%has('space')) then
         status = fail(NUTATE_BAD_ARGUMENT, 'body and space exclude each other (expected one of the two)', 'space')
         return
      else if (.not. (group%has('body') .or. group%has('space'))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the torque is missing (expected body, space or table)')
         return
      end if
      do i = 1, size(of_table)
         if (.not. group%has(trim(of_table(i)))) cycle
         status = fail(NUTATE_BAD_ARGUMENT, trim(of_table(i))//' without table (expected table)', of_table(i))
         return
      end do
      torque%in_space = group%has('space')
      torque%amplitude = group%vector('body', group%vector('space', none))
      torque%frequency = group%number('frequency', torque%frequency)
      torque%phase = group%number('phase', torque%phase)
      torque%start = group%number('start', torque%start)
      torque%stop = group%number('stop', torque%stop)
      if (torque%stop <= torque%start) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the torque stops before it starts (expected stop > start)', 'stop')
         return
      end if
      allocate (effect, source=torque)
   end subroutine build_applied_torque

   !> Returns τ₀ cos(2πft + phase), N m, in body axes: the amplitude in body axes, or rotated from space to body axes.
   pure function applied_torque(self, t, q, omega) result(tau)
      class(applied_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = self%amplitude
      if (self%in_space) tau = rotate_to_body(q, tau)
      if (abs(self%frequency) > 0.0_wp .or. abs(self%phase) > 0.0_wp) tau = cos(phase_at(self, t))*tau
   end function applied_torque

   !> Returns 2πft + phase, rad, without the whole revolutions of the first term, which would cost digits of the cosine.
   pure real(wp) function phase_at(self, t)
      class(applied_torque_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: turns
      turns = self%frequency*t
      phase_at = 2*pi*(turns - aint(turns)) + self%phase
   end function phase_at

   !> Computes ∂τ/∂θ (θ a small body rotation: τ×θ for a torque in space axes, else 0) and ∂τ/∂Ω = 0.
   pure subroutine applied_derivatives(self, t, q, omega, by_rotation, by_rate)
      class(applied_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: by_rotation(3, 3), by_rate(3, 3)
      by_rotation = 0.0_wp
      by_rate = 0.0_wp
      if (self%in_space) by_rotation = skew(self%torque(t, q, omega))
   end subroutine applied_derivatives

   !> Returns `start` and `stop`, s.
   pure subroutine applied_window(self, start, stop)
      class(applied_torque_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = self%start
      stop = self%stop
   end subroutine applied_window

   !> Returns true for a torque in space axes.
   pure logical function attitude_in_space(self)
      class(applied_torque_t), intent(in) :: self
      attitude_in_space = self%in_space
   end function attitude_in_space

   !> Bounds the torque in a step. In body axes: T = (1+β)τ - 2b(b·τ). In space axes, ν at the start of the step: T =
   !> (1-β)ν - 2b×ν.
   pure subroutine applied_bound(self, map, radius, gamma, slack, bounds)
      class(applied_torque_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      real(wp) :: whole, square
      whole = map%norm*vector_length(self%amplitude)
      square = radius*radius
      if (self%in_space) then
         bounds%force = (1 + square)*whole
         bounds%slope = 2*sqrt(1 + square)*whole
      else
         bounds%force = vector_length(times_vector(map%matrix, self%amplitude)) + square*whole
         bounds%slope = 2*radius*whole
      end if
      bounds%curvature = 2*whole
      call let_change(bounds, 2*pi*abs(self%frequency))
   end subroutine applied_bound

   !> Returns ∂τ/∂t = -2πf τ₀ sin(2πft + phase), body axes, N m/s.
   pure function applied_time_derivative(self, t, q, omega, span) result(derivative)
      class(applied_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3), span
      real(wp) :: derivative(3)
      derivative = self%amplitude
      if (self%in_space) derivative = rotate_to_body(q, derivative)
      derivative = (-2*pi*self%frequency*sin(phase_at(self, t)))*derivative
   end function applied_time_derivative

   !> Returns `TIME_SERIES` for a torque in body axes, else `GENERAL_SERIES`.
   pure integer function harmonic_series(self)
      class(applied_torque_t), intent(in) :: self
      harmonic_series = merge(GENERAL_SERIES, TIME_SERIES, self%in_space)
   end function harmonic_series

   !> Returns 2: the cosine, and, for derivatives, minus the sine.
   pure integer function harmonic_auxiliary(self)
      class(applied_torque_t), intent(in) :: self
      harmonic_auxiliary = 2
   end function harmonic_auxiliary

   !> Returns τ₀ of a torque in space axes, N m; else zero.
   pure function amplitude_in_space(self) result(direction)
      class(applied_torque_t), intent(in) :: self
      real(wp) :: direction(3)
      direction = 0.0_wp
      if (self%in_space) direction = self%amplitude
   end function amplitude_in_space

   !> Computes coefficient k of cos(2πft + phase) times τ₀ or R(q)ᵀτ₀, body axes, N m.
   pure subroutine harmonic_torque(self, k, t, time_unit, omega, gamma, auxiliary, tau)
      class(applied_torque_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit, omega(3, 0:k), gamma(3, 0:k)
      !> The first is the cosine; shape (0:highest_order, 2).
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      real(wp) :: phase
      integer :: j
      phase = 0.0_wp
      if (k < 2) phase = phase_at(self, t)
      auxiliary(k, 1) = cosine_term(k, phase, 2*pi*self%frequency*time_unit, auxiliary(:, 1))
      tau = auxiliary(k, 1)*self%amplitude
      if (.not. self%in_space) return
      tau = 0.0_wp
      do j = 0, k
         tau = tau + auxiliary(k - j, 1)*gamma(:, j)
      end do
   end subroutine harmonic_torque

   !> Computes the coefficients of cos(2πft + phase) τ₀, body axes, N m.
   pure subroutine harmonic_time_series(self, t, time_unit, auxiliary, tau)
      class(applied_torque_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      !> The first is the cosine; shape (0:highest_order, 2).
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(:, 0:)
      real(wp) :: cosine(0:highest_order), phase, rate
      integer :: k
      phase = phase_at(self, t)
      rate = 2*pi*self%frequency*time_unit
      cosine(0:1) = [cos(phase), -rate*sin(phase)]
      do k = 2, ubound(tau, 2)
         cosine(k) = (-rate*rate*(inverses(k)*inverses(k - 1)))*cosine(k - 2)
      end do
      do k = 0, ubound(tau, 2)
         auxiliary(k, 1) = cosine(k)
         tau(:, k) = cosine(k)*self%amplitude
      end do
   end subroutine harmonic_time_series

   !> Computes coefficient k of the derivative by γ: the cosine times the unit matrix in space axes, else zero.
   pure subroutine harmonic_series_derivative(self, k, t, time_unit, auxiliary, derivative, known)
      class(applied_torque_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: derivative(3, 3)
      logical, intent(out) :: known
      real(wp) :: phase
      integer :: i
      known = .true.
      phase = 0.0_wp
      if (k < 2) phase = phase_at(self, t) + 0.5_wp*pi
      auxiliary(k, 2) = cosine_term(k, phase, 2*pi*self%frequency*time_unit, auxiliary(:, 2))
      derivative = 0.0_wp
      if (.not. self%in_space) return
      do i = 1, 3
         derivative(i, i) = auxiliary(k, 1)
      end do
   end subroutine harmonic_series_derivative

   !> Computes coefficient k of δτ₀ cos(2πft + phase), which in space axes is the change of n, and of
   !> -(2πtδf + δphase) sin(2πft + phase) times τ₀ or R(q)ᵀτ₀.
   pure subroutine harmonic_series_change(self, change, k, t, time_unit, gamma, auxiliary, tau, known)
      class(applied_torque_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit, gamma(3, 0:k), auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      real(wp) :: wave(0:k)
      integer :: j
      known = .true.
      wave = (2*pi*t*change(4) + change(5))*auxiliary(0:k, 2)
      if (k > 0) wave(1:) = wave(1:) + (2*pi*time_unit*change(4))*auxiliary(0:k - 1, 2)
      if (.not. self%in_space) then
         tau = auxiliary(k, 1)*change(1:3) + wave(k)*self%amplitude
         return
      end if
      tau = 0.0_wp
      do j = 0, k
         tau = tau + wave(k - j)*gamma(:, j)
      end do
   end subroutine harmonic_series_change

   !> Computes δτ₀ of a torque in space axes, N m; else zero.
   pure subroutine amplitude_change(self, change, t, time_unit, n)
      class(applied_torque_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      n = 0.0_wp
      if (self%in_space) n(:, 0) = change(1:3)
   end subroutine amplitude_change

   !> Returns true for a torque in space axes, and for a τ₀ that lies along the axis.
   pure logical function torque_has_axis(self, axis)
      class(applied_torque_t), intent(in) :: self
      integer, intent(in) :: axis
      torque_has_axis = self%in_space .or. lies_along(self%amplitude, axis)
   end function torque_has_axis

   !> Returns true if amplitude, frequency and phase can be computed with; `start` and `stop` need only be comparable.
   pure logical function torque_is_valid(self)
      class(applied_torque_t), intent(in) :: self
      torque_is_valid = all(is_moderate([self%amplitude, self%frequency, self%phase])) .and. &
                           .not. (is_nan(self%start) .or. is_nan(self%stop))
      if (torque_is_valid) torque_is_valid = is_moderate(norm2(self%amplitude))
   end function torque_is_valid

   !> Returns the parameters of a motor: τ₀, f and phase.
   pure function parameters_of_motor(self) result(list)
      class(applied_torque_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('torque'), parameter_t('frequency'), parameter_t('phase')]
   end function parameters_of_motor

   !> Returns the change of `parameters`: the torque of a motor is component 1.
   pure function change_of_motor(self, change) result(of_torque)
      class(applied_torque_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      real(wp), allocatable :: of_torque(:)
      of_torque = [change(1), 0.0_wp, 0.0_wp, change(2:)]
   end function change_of_motor

   pure function applied_parameters(self) result(list)
      class(applied_torque_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('body', 3), parameter_t('frequency'), parameter_t('phase')]
      if (self%in_space) list(1)%name = 'space'
      if (self%name == 'force') list(1)%name = 'torque'
   end function applied_parameters

   pure function applied_change(self, change, t, q, omega) result(tau)
      class(applied_torque_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = cos(phase_at(self, t))*change(1:3) &
            - (sin(phase_at(self, t))*(2*pi*t*change(4) + change(5)))*self%amplitude
      if (self%in_space) tau = rotate_to_body(q, tau)
   end function applied_change

end module nutate_applied_torque
