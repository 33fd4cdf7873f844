!> Potentials: functions of a direction fixed in space, or of one that moves, in body axes.
module nutate_potential
   use nutate_effect_base, only: effect_t
   use nutate_effect_bounds, only: bounds_of_potential, effect_bounds_t, linear_map_t
   use nutate_kinds, only: wp, eps
   use nutate_small_products, only: vector_length
   implicit none
   private

   public :: potential_t

   !> V(q) = U(γ), γ = R(q)ᵀ n, the V of equation (8) of Nielsen & Krenk (2012).
   type, abstract, extends(effect_t) :: potential_t
      !> n: a vector fixed in space, of whatever length and unit the potential is written in.
      real(wp) :: direction(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      !> True if n is time-dependent (`direction` is its value at t = 0), and a bound of its rate relative to |n|, 1/s.
      logical :: moves = .false.
      real(wp) :: pace = 0.0_wp
      !> Changes ΔJ of the inertia and Δc of the centre of mass add ½γᵀEγ - e·γ to U, E = `by_inertia` ΔJ and e =
      !> `by_center` Δc; units of U over kg m² and m.
      real(wp) :: by_inertia = 0.0_wp, by_center = 0.0_wp
      !> True if U depends on time by such changes; set by the list of effects.
      logical :: varies = .false.
   contains
      !> Return n at a time, ∂V/∂t at fixed attitude, and the power series of n; constant unless overridden.
      procedure :: direction_at => fixed_direction
      procedure :: power => no_power
      procedure :: direction_series => fixed_series
      !> Makes the same potential as seen from the LVLH frame of the circular orbit that it follows, in which it is
      !> constant; not allocated unless overridden.
      procedure :: see_from_lvlh => not_seen_from_lvlh
      !> Returns U(γ), J.
      procedure(potential_energy), deferred :: energy
      !> Returns ∇U(γ): the derivative with respect to the body components γ.
      procedure(potential_gradient), deferred :: gradient
      !> Returns the matrix of second derivatives of U; by differences of the gradient unless overridden.
      procedure :: hessian => difference_hessian
      !> Returns the discrete gradient ∇̄U(γ0, γ1) with ∇̄U·(γ1 - γ0) = U(γ1) - U(γ0); Gonzalez's (1996) unless
      !> overridden.
      procedure :: discrete_gradient => gonzalez_gradient
      !> Returns ∂∇̄U/∂γ1; that of Gonzalez's unless overridden.
      procedure :: discrete_hessian => gonzalez_hessian
      !> Computes ∇̄U and its derivatives by both ends; from `discrete_gradient` and `discrete_hessian` unless
      !> overridden.
      procedure :: linearize => linearize_gradient
      procedure :: bound => bound_potential
      !> Returns true for U = -m·γ, which has no curvature; `.false.` unless overridden.
      procedure :: is_linear => not_linear
      !> Returns m of a linear series: the torque γ×∇U is m×γ; body axes.
      procedure :: series_moment => no_moment
      !> Computes a coefficient of a general series of γ×∇U.
      procedure :: series_torque => no_potential_torque
      !> Compute a coefficient of the derivative of the general series by γ, and of its change by a change of
      !> `parameters` at fixed γ; not known unless overridden.
      procedure :: series_derivative => no_series_derivative
      procedure :: series_change => no_series_change
      !> Computes the power series of `direction_change`; constant unless overridden.
      procedure :: direction_change_series => fixed_change
      !> Return the change by a change of `parameters` of n, of ∇̄U at fixed ends (of ∇U if they are equal), and of U at
      !> fixed γ; zero unless overridden.
      procedure :: direction_change => no_direction_change
      procedure :: gradient_change => no_gradient_change
      procedure :: energy_change => no_energy_change
      !> Returns the change by a change of `parameters` of `by_inertia` and `by_center`; zero unless overridden.
      procedure :: factor_change => no_factor_change
   end type potential_t

   abstract interface
      !> Returns U(γ), J.
      pure real(wp) function potential_energy(self, gamma)
         import :: potential_t, wp
         class(potential_t), intent(in) :: self
         !> γ, body axes; shape (3).
         real(wp), intent(in) :: gamma(3)
      end function potential_energy

      !> Returns ∇U(γ), body axes, J per unit of γ; shape (3).
      pure function potential_gradient(self, gamma) result(gradient)
         import :: potential_t, wp
         class(potential_t), intent(in) :: self
         !> γ, body axes; shape (3).
         real(wp), intent(in) :: gamma(3)
         real(wp) :: gradient(3)
      end function potential_gradient
   end interface

contains

   !> Returns n at a time, s, in space axes; shape (3). Here: the constant `direction`.
   pure function fixed_direction(self, t) result(n)
      class(potential_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: n(3)
      n = self%direction
   end function fixed_direction

   !> Returns ∂V/∂t at fixed attitude, W. Here: zero.
   pure real(wp) function no_power(self, q, t)
      class(potential_t), intent(in) :: self
      !> Attitude, unit quaternion, body→space, shape (4); time, s.
      real(wp), intent(in) :: q(4), t
      no_power = 0.0_wp
   end function no_power

   !> Computes the coefficients of the power series of n about a time. Here: a constant.
   pure subroutine fixed_series(self, t, time_unit, n)
      class(potential_t), intent(in) :: self
      !> Time t₀ and time unit of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> Space axes; shape (3, 0:order).
      real(wp), intent(out) :: n(:, 0:)
      n = 0.0_wp
      n(:, 0) = self%direction
   end subroutine fixed_series

   !> Makes no potential: this one is not known to be constant in the LVLH frame.
   subroutine not_seen_from_lvlh(self, seen)
      class(potential_t), intent(in) :: self
      !> Potential in LVLH space axes.
      class(potential_t), allocatable, intent(out) :: seen
   end subroutine not_seen_from_lvlh

   !> Bounds the torque of a potential with Gonzalez's discrete gradient, from the bounds that the user gave.
   pure subroutine bound_potential(self, map, radius, gamma, slack, bounds)
      class(potential_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      bounds%known = self%given(1) >= 0.0_wp
      if (bounds%known) bounds = bounds_of_potential(map, radius, vector_length(self%direction), self%given(1), &
                                                     self%given(2), self%given(3))
   end subroutine bound_potential

   !> Computes the Hessian by central differences of ∇U with steps of ε^(1/3) of |γ|, where truncation error and
   !> round-off are of equal size; exact to round-off for quadratic U.
   pure function difference_hessian(self, gamma) result(hessian)
      class(potential_t), intent(in) :: self
      !> γ, body axes; shape (3).
      real(wp), intent(in) :: gamma(3)
      real(wp) :: hessian(3, 3)
      real(wp) :: h, shift(3)
      integer :: i
      h = eps**(1.0_wp/3)*norm2(gamma)
      if (h == 0.0_wp) h = eps**(1.0_wp/3)
      do i = 1, 3
         shift = 0.0_wp
         shift(i) = h
         hessian(:, i) = (self%gradient(gamma + shift) - self%gradient(gamma - shift))/(2*h)
      end do
   end function difference_hessian

   !> Computes the discrete gradient of any U: ∇U(γ̄) + ((ΔU - ∇U(γ̄)·Δγ)/|Δγ|²) Δγ, γ̄ the mean of the ends. If Δγ is
   !> so short that the second term would be noise, ∇U(γ̄) alone is exact to round-off. Source: Gonzalez (1996), eq.
   !> 3.2.
   pure function gonzalez_gradient(self, gamma0, gamma1) result(gradient)
      class(potential_t), intent(in) :: self
      !> γ at the ends of the step, body axes; shape (3).
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      real(wp) :: delta(3)
      delta = gamma1 - gamma0
      gradient = self%gradient(0.5_wp*(gamma0 + gamma1))
      if (is_short(delta, gamma0)) return
      gradient = gradient + ((self%energy(gamma1) - self%energy(gamma0) - dot_product(gradient, delta)) &
                             /dot_product(delta, delta))*delta
   end function gonzalez_gradient

   !> Computes the derivative of `gonzalez_gradient` by γ1; shape (3,3).
   pure function gonzalez_hessian(self, gamma0, gamma1) result(hessian)
      class(potential_t), intent(in) :: self
      !> γ at the ends of the step, body axes; shape (3).
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      !> ∂∇̄Uᵢ/∂γ1ⱼ
      real(wp) :: hessian(3, 3)
      real(wp) :: delta(3), middle(3), slope(3), square, defect
      integer :: i, j
      delta = gamma1 - gamma0
      hessian = 0.5_wp*self%hessian(0.5_wp*(gamma0 + gamma1))
      if (is_short(delta, gamma0)) return
      middle = self%gradient(0.5_wp*(gamma0 + gamma1))
      square = dot_product(delta, delta)
      defect = (self%energy(gamma1) - self%energy(gamma0) - dot_product(middle, delta))/square
      slope = (self%gradient(gamma1) - middle - matmul(delta, hessian))/square - (2*defect/square)*delta
      do j = 1, 3
         do i = 1, 3
            hessian(i, j) = hessian(i, j) + delta(i)*slope(j)
         end do
         hessian(j, j) = hessian(j, j) + defect
      end do
   end function gonzalez_hessian

   !> Computes ∇̄U, ∂∇̄U/∂γ0 and ∂∇̄U/∂γ1; discrete gradients are symmetric in their ends.
   pure subroutine linearize_gradient(self, gamma0, gamma1, gradient, by_start, by_end)
      class(potential_t), intent(in) :: self
      !> γ at the ends of the step, body axes; shape (3).
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      !> ∇̄U, body axes, J per unit of γ, shape (3); its derivatives, per unit of γ again, shape (3,3).
      real(wp), intent(out) :: gradient(3), by_start(3, 3), by_end(3, 3)
      gradient = self%discrete_gradient(gamma0, gamma1)
      by_start = self%discrete_hessian(gamma1, gamma0)
      by_end = self%discrete_hessian(gamma0, gamma1)
   end subroutine linearize_gradient

   !> Returns true if |Δγ| < ε^(1/3) |γ|: ΔU - ∇U(γ̄)·Δγ, of third order in Δγ, is round-off of U.
   pure logical function is_short(delta, gamma)
      real(wp), intent(in) :: delta(3), gamma(3)
      is_short = dot_product(delta, delta) <= eps**(2.0_wp/3)*dot_product(gamma, gamma)
   end function is_short

   !> Returns false: U may be curved.
   pure logical function not_linear(self)
      class(potential_t), intent(in) :: self
      not_linear = .false.
   end function not_linear

   !> Returns m of a linear series, body axes, N m over the unit of n; shape (3). Here: zero.
   pure function no_moment(self) result(moment)
      class(potential_t), intent(in) :: self
      real(wp) :: moment(3)
      moment = 0.0_wp
   end function no_moment

   !> Computes coefficient k of the power series of γ×∇U, body axes, N m. Here: zero.
   pure subroutine no_potential_torque(self, k, gamma, auxiliary, tau)
      class(potential_t), intent(in) :: self
      integer, intent(in) :: k
      !> Coefficients 0..k of γ, body axes; shape (3, 0:k).
      real(wp), intent(in) :: gamma(3, 0:k)
      !> Coefficients 0..k-1 of the auxiliary series on entry, 0..k on exit; shape (0:highest_order,
      !> auxiliary_series()).
      real(wp), intent(inout) :: auxiliary(0:, :)
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      tau = 0.0_wp
   end subroutine no_potential_torque

   !> Computes coefficient k of ∂τ/∂γ, τ = γ×∇U, |γ| constant; called after `series_torque`. Here: it is not known.
   pure subroutine no_series_derivative(self, k, gamma, auxiliary, derivative, known)
      class(potential_t), intent(in) :: self
      integer, intent(in) :: k
      !> Coefficients 0..k of γ, body axes; shape (3, 0:k).
      real(wp), intent(in) :: gamma(3, 0:k)
      !> Auxiliary series as `series_torque` left them; shape (0:highest_order, auxiliary_series()).
      real(wp), intent(inout) :: auxiliary(0:, :)
      !> Body axes, N m over the unit of γ; shape (3,3).
      real(wp), intent(out) :: derivative(3, 3)
      logical, intent(out) :: known
      derivative = 0.0_wp
      known = .false.
   end subroutine no_series_derivative

   !> Computes coefficient k of the change of τ at fixed γ; called after `series_derivative`. Here: it is not known.
   pure subroutine no_series_change(self, change, k, gamma, auxiliary, tau, known)
      class(potential_t), intent(in) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: k
      !> Coefficients 0..k of γ, body axes; shape (3, 0:k).
      real(wp), intent(in) :: gamma(3, 0:k)
      !> Auxiliary series, none if the series is linear; shape (0:highest_order, auxiliary_series()).
      real(wp), intent(in) :: auxiliary(0:, :)
      !> Body axes, N m; shape (3).
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      tau = 0.0_wp
      known = .false.
   end subroutine no_series_change

   !> Computes the coefficients of the change of n about a time. Here: a constant, which is known for a moving n only if
   !> it is zero.
   pure subroutine fixed_change(self, change, t, time_unit, n, known)
      class(potential_t), intent(in) :: self
      !> Change of `parameters`; time t₀ and time unit of the series, s.
      real(wp), intent(in) :: change(:), t, time_unit
      !> Space axes; shape (3, 0:order).
      real(wp), intent(out) :: n(:, 0:)
      logical, intent(out) :: known
      n = 0.0_wp
      n(:, 0) = self%direction_change(change, t)
      known = .not. (self%moves .and. any(abs(n(:, 0)) > 0.0_wp))
   end subroutine fixed_change

   !> Returns the change of n at a time, space axes; shape (3).
   pure function no_direction_change(self, change, t) result(n)
      class(potential_t), intent(in) :: self
      !> Change of `parameters`; time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: n(3)
      n = 0.0_wp
   end function no_direction_change

   !> Returns the change of ∇̄U; shape (3).
   pure function no_gradient_change(self, change, gamma0, gamma1) result(gradient)
      class(potential_t), intent(in) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      !> γ at the ends of the step, body axes; shape (3).
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      gradient = 0.0_wp
   end function no_gradient_change

   !> Returns the change of U, J.
   pure real(wp) function no_energy_change(self, change, gamma)
      class(potential_t), intent(in) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      !> γ, body axes; shape (3).
      real(wp), intent(in) :: gamma(3)
      no_energy_change = 0.0_wp
   end function no_energy_change

   !> Returns the change of `by_inertia` and `by_center`; shape (2).
   pure function no_factor_change(self, change) result(factors)
      class(potential_t), intent(in) :: self
      !> Change of `parameters`.
      real(wp), intent(in) :: change(:)
      real(wp) :: factors(2)
      factors = 0.0_wp
   end function no_factor_change

end module nutate_potential
