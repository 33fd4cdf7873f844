!> Potentials linear in a direction, U = -m·γ, such as those of weight and of a magnetic dipole.
module nutate_linear_potential
   use nutate_effect, only: LINEAR_SERIES, parameter_t, potential_t
   use nutate_effect_bounds, only: bounds_of_linear, effect_bounds_t, linear_map_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_quaternion, only: cross
   use nutate_small_products, only: lies_along, skew, vector_length
   implicit none
   private

   public :: linear_potential_t

   !> U(γ) = -m·γ, γ = Rᵀn. The gradient is constant and thus its own discrete gradient: ∇̄U = -m. An extension gives m
   !> and n in another way (n may move), and does not override energy and gradients: steppers read m once.
   type, extends(potential_t) :: linear_potential_t
      !> m, body axes; its unit times that of n is J; shape (3).
      real(wp) :: moment(3) = 0.0_wp
   contains
      procedure :: energy => linear_energy
      procedure :: is_valid => linear_is_valid
      procedure :: gradient => constant_gradient
      procedure :: hessian => no_hessian
      procedure :: discrete_gradient => constant_discrete_gradient
      procedure :: discrete_hessian => no_discrete_hessian
      procedure :: bound => linear_bound
      procedure :: series_kind => linear_kind
      procedure :: series_derivative => linear_series_derivative
      procedure :: series_change => linear_series_change
      procedure :: is_linear => always_linear
      procedure :: series_moment => constant_moment
      procedure :: has_axis => linear_has_axis
      procedure :: parameters => linear_parameters
      procedure :: direction_change => linear_direction_change
      procedure :: gradient_change => linear_gradient_change
      procedure :: energy_change => linear_energy_change
   end type linear_potential_t

contains

   !> Returns U(γ) = -m·γ, J.
   pure real(wp) function linear_energy(self, gamma)
      class(linear_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      linear_energy = -dot_product(self%moment, gamma)
   end function linear_energy

   !> Returns ∇U = -m, body axes.
   pure function constant_gradient(self, gamma) result(gradient)
      class(linear_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = -self%moment
   end function constant_gradient

   !> Returns the Hessian, zero.
   pure function no_hessian(self, gamma) result(hessian)
      class(linear_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: hessian(3, 3)
      hessian = 0.0_wp
   end function no_hessian

   !> Returns the discrete gradient, -m.
   pure function constant_discrete_gradient(self, gamma0, gamma1) result(gradient)
      class(linear_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      gradient = -self%moment
   end function constant_discrete_gradient

   !> Returns the derivative of the discrete gradient, zero.
   pure function no_discrete_hessian(self, gamma0, gamma1) result(hessian)
      class(linear_potential_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: hessian(3, 3)
      hessian = 0.0_wp
   end function no_discrete_hessian

   pure subroutine linear_bound(self, map, radius, gamma, slack, bounds)
      class(linear_potential_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      bounds%known = .not. self%moves
      if (bounds%known) bounds = bounds_of_linear(map, radius, self%moment, vector_length(self%direction))
   end subroutine linear_bound

   !> Returns true: U = -m·γ.
   pure logical function always_linear(self)
      class(linear_potential_t), intent(in) :: self
      always_linear = .true.
   end function always_linear

   !> Returns `LINEAR_SERIES`: the torque is a constant times the series of γ.
   pure integer function linear_kind(self)
      class(linear_potential_t), intent(in) :: self
      linear_kind = LINEAR_SERIES
   end function linear_kind

   !> Returns m, since γ×∇U = -γ×m.
   pure function constant_moment(self) result(moment)
      class(linear_potential_t), intent(in) :: self
      real(wp) :: moment(3)
      moment = self%moment
   end function constant_moment

   !> Computes coefficient k of ∂(m×γ)/∂γ.
   pure subroutine linear_series_derivative(self, k, gamma, auxiliary, derivative, known)
      class(linear_potential_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k)
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: derivative(3, 3)
      logical, intent(out) :: known
      known = .true.
      derivative = 0.0_wp
      if (k == 0) derivative = skew(self%moment)
   end subroutine linear_series_derivative

   !> Computes coefficient k of δm×γ.
   pure subroutine linear_series_change(self, change, k, gamma, auxiliary, tau, known)
      class(linear_potential_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k), auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      known = .true.
      tau = cross(change(1:3), gamma(:, k))
   end subroutine linear_series_change

   !> Returns true if m lies along the axis.
   pure logical function linear_has_axis(self, axis)
      class(linear_potential_t), intent(in) :: self
      integer, intent(in) :: axis
      linear_has_axis = lies_along(self%moment, axis) .and. .not. self%moves
   end function linear_has_axis

   !> Returns true if all parameters, and |m||n|, the largest energy and torque, can be computed with.
   pure logical function linear_is_valid(self)
      class(linear_potential_t), intent(in) :: self
      linear_is_valid = all(is_moderate([self%moment, self%direction]))
      if (linear_is_valid) linear_is_valid = is_moderate(norm2(self%moment)*norm2(self%direction))
   end function linear_is_valid

   !> Returns the parameters m and n, by the names of the scene's keys.
   pure function linear_parameters(self) result(list)
      class(linear_potential_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('moment', 3), parameter_t('field', 3)]
      if (self%name == 'force') list = [parameter_t('body_point', 3), parameter_t('force', 3)]
   end function linear_parameters

   pure function linear_direction_change(self, change, t) result(n)
      class(linear_potential_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t
      real(wp) :: n(3)
      n = change(4:6)
   end function linear_direction_change

   pure function linear_gradient_change(self, change, gamma0, gamma1) result(gradient)
      class(linear_potential_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      gradient = -change(1:3)
   end function linear_gradient_change

   pure real(wp) function linear_energy_change(self, change, gamma)
      class(linear_potential_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma(3)
      linear_energy_change = -dot_product(change(1:3), gamma)
   end function linear_energy_change

end module nutate_linear_potential
