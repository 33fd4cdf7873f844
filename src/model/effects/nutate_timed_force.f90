!> A constant force at a point of the body within a window of time: τ = x×RᵀF, whose work is treated as that of a
!> torque.
module nutate_timed_force
   use nutate_finite, only: is_nan
   use nutate_lvlh_vector, only: lvlh_vector_t
   use nutate_effect, only: GENERAL_SERIES, parameter_t, torque_t
   use nutate_effect_bounds, only: bounds_of_torque, effect_bounds_t, linear_map_t
   use nutate_kepler_orbit, only: kepler_orbit_t, n_elements
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_small_products, only: lies_along, skew, vector_length
   implicit none
   private

   public :: timed_force_t

   !> x×RᵀF from start to stop.
   type, extends(torque_t) :: timed_force_t
      !> x, body axes, m; shape (3).
      real(wp) :: body_point(3) = 0.0_wp
      !> F, N: constant in space axes, or, if `moves`, moving in these axes.
      type(lvlh_vector_t) :: force = lvlh_vector_t()
      !> Start and stop of the force, s.
      real(wp) :: start = -huge(1.0_wp), stop = huge(1.0_wp)
   contains
      procedure :: torque => torque_of_force
      procedure :: derivatives => derivatives_of_force
      procedure :: time_derivative => change_of_force
      procedure :: window => window_of_force
      procedure :: bound => bound_of_force
      procedure :: series_kind => kind_of_force
      procedure :: series_direction => direction_of_force
      procedure :: direction_series => series_of_force
      procedure :: series_torque => terms_of_force
      procedure :: series_derivative => derivative_of_terms
      procedure :: series_change => change_of_terms
      procedure :: direction_change_series => change_of_series
      procedure :: has_axis => force_has_axis
      procedure :: is_valid => force_is_valid
      procedure :: parameters => parameters_of_force
      procedure :: torque_change => change_by_parameters
      procedure :: follows => force_follows
      procedure :: thin_table => thin_path
   end type timed_force_t

contains

   !> Returns F at a time, space axes, N; shape (3).
   pure function force_at(self, t) result(force)
      class(timed_force_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: force(3)
      force = self%force%vector
      if (self%moves) force = self%force%at(t)
   end function force_at

   !> Returns x×R(q)ᵀF, body axes, N m; shape (3).
   pure function torque_of_force(self, t, q, omega) result(tau)
      class(timed_force_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = cross(self%body_point, rotate_to_body(q, force_at(self, t)))
   end function torque_of_force

   !> Computes ∂τ/∂θ and ∂τ/∂Ω = 0: a small rotation θ of the body changes RᵀF by RᵀF×θ.
   pure subroutine derivatives_of_force(self, t, q, omega, by_rotation, by_rate)
      class(timed_force_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: by_rotation(3, 3), by_rate(3, 3)
      real(wp) :: force(3), theta(3)
      integer :: i
      by_rate = 0.0_wp
      force = rotate_to_body(q, force_at(self, t))
      do i = 1, 3
         theta = 0.0_wp
         theta(i) = 1.0_wp
         by_rotation(:, i) = cross(self%body_point, cross(force, theta))
      end do
   end subroutine derivatives_of_force

   !> Returns ∂τ/∂t = x×R(q)ᵀḞ, body axes, N m/s.
   pure function change_of_force(self, t, q, omega, span) result(derivative)
      class(timed_force_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3), span
      real(wp) :: derivative(3)
      derivative = 0.0_wp
      if (self%moves) derivative = cross(self%body_point, rotate_to_body(q, self%force%rate_at(t)))
   end function change_of_force

   !> Returns `start` and `stop`, s.
   pure subroutine window_of_force(self, start, stop)
      class(timed_force_t), intent(in) :: self
      real(wp), intent(out) :: start, stop
      start = self%start
      stop = self%stop
   end subroutine window_of_force

   !> Bounds the torque and its derivatives in a step by |x||F|.
   pure subroutine bound_of_force(self, map, radius, gamma, slack, bounds)
      class(timed_force_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      real(wp) :: most, rate
      most = vector_length(self%body_point)*vector_length(self%force%vector)
      rate = 0.0_wp
      if (self%moves) rate = self%force%path%fastest_turn()
      bounds = bounds_of_torque(map, radius, most, most, most, rate)
   end subroutine bound_of_force

   !> Returns `GENERAL_SERIES`.
   pure integer function kind_of_force(self)
      class(timed_force_t), intent(in) :: self
      kind_of_force = GENERAL_SERIES
   end function kind_of_force

   !> Returns F, space axes, N; at t = 0 if it moves.
   pure function direction_of_force(self) result(direction)
      class(timed_force_t), intent(in) :: self
      real(wp) :: direction(3)
      direction = force_at(self, 0.0_wp)
   end function direction_of_force

   !> Computes the coefficients of the power series of F about a time, space axes, N.
   pure subroutine series_of_force(self, t, time_unit, n)
      class(timed_force_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      call self%force%series(t, time_unit, n)
   end subroutine series_of_force

   !> Computes coefficient k of x×γ, γ = R(q)ᵀF, body axes, N m.
   pure subroutine terms_of_force(self, k, t, time_unit, omega, gamma, auxiliary, tau)
      class(timed_force_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit, omega(3, 0:k), gamma(3, 0:k)
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      tau = cross(self%body_point, gamma(:, k))
   end subroutine terms_of_force

   !> Computes coefficient k of ∂(x×γ)/∂γ.
   pure subroutine derivative_of_terms(self, k, t, time_unit, auxiliary, derivative, known)
      class(timed_force_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: derivative(3, 3)
      logical, intent(out) :: known
      known = .true.
      derivative = 0.0_wp
      if (k == 0) derivative = skew(self%body_point)
   end subroutine derivative_of_terms

   !> Computes coefficient k of δx×γ.
   pure subroutine change_of_terms(self, change, k, t, time_unit, gamma, auxiliary, tau, known)
      class(timed_force_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: k
      real(wp), intent(in) :: t, time_unit, gamma(3, 0:k), auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      known = .true.
      tau = cross(change(1:3), gamma(:, k))
   end subroutine change_of_terms

   !> Computes the coefficients of δF, N.
   pure subroutine change_of_series(self, change, t, time_unit, n)
      class(timed_force_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      if (self%moves) then
         call self%force%change_series(change(4:), t, time_unit, n)
      else
         n = 0.0_wp
         n(:, 0) = change(4:6)
      end if
   end subroutine change_of_series

   !> Returns true if x lies along the axis and F is fixed in space.
   pure logical function force_has_axis(self, axis)
      class(timed_force_t), intent(in) :: self
      integer, intent(in) :: axis
      force_has_axis = lies_along(self%body_point, axis) .and. .not. self%moves
   end function force_has_axis

   !> Returns true if |x||F| can be computed with; `start` and `stop` need only be comparable.
   pure logical function force_is_valid(self) result(valid)
      class(timed_force_t), intent(in) :: self
      valid = all(is_moderate([self%body_point, self%force%vector])) .and. &
                 .not. (is_nan(self%start) .or. is_nan(self%stop))
      if (valid .and. self%moves) valid = self%force%is_valid()
      if (valid) valid = is_moderate(norm2(self%body_point)*norm2(self%force%vector))
   end function force_is_valid

   pure function parameters_of_force(self) result(list)
      class(timed_force_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('body_point', 3), parameter_t('force', 3)]
      if (self%moves) list = [list, parameter_t('orbit', n_elements)]
   end function parameters_of_force

   pure logical function force_follows(self, path)
      class(timed_force_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      force_follows = self%moves .and. self%force%path%equals(path)
   end function force_follows

   !> Returns δx×RᵀF + x×RᵀδF.
   pure function change_by_parameters(self, change, t, q, omega) result(tau)
      class(timed_force_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: tau(3)
      real(wp) :: force(3)
      force = change(4:6)
      if (self%moves) force = self%force%change_at(change(4:), t)
      tau = cross(change(1:3), rotate_to_body(q, force_at(self, t))) + cross(self%body_point, rotate_to_body(q, force))
   end function change_by_parameters

   !> Leaves out every second line of the table of the orbit.
   subroutine thin_path(self)
      class(timed_force_t), intent(inout) :: self
      call self%force%path%thin_table()
   end subroutine thin_path

end module nutate_timed_force
