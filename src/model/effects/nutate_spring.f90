!> A spring between a point of the body and an anchor fixed in space: V = ½k(|Rx - a| - l₀)².
module nutate_spring
   use nutate_admissible, only: NON_NEGATIVE
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, GENERAL_SERIES, LINEAR_SERIES, parameter_t, potential_t
   use nutate_effect_bounds, only: bounds_of_linear, effect_bounds_t, linear_map_t
   use nutate_keys, only: group_t, key_t
   use nutate_kinds, only: wp
   use nutate_limits, only: least_size, is_moderate
   use nutate_power_series, only: inverses, power_term
   use nutate_quaternion, only: cross
   use nutate_small_products, only: lies_along, skew, vector_length
   use nutate_status, only: status_t
   implicit none
   private

   public :: spring_t, spring_keys, build_spring

   !> Keys of the scene group `&spring`.
   type(key_t), parameter :: spring_keys(4) = [ &
      key_t(name='body_point', least=3, most=3, required=.true.), &
      key_t(name='anchor', least=3, most=3, required=.true.), &
      key_t(name='stiffness', required=.true.), &
      key_t(name='rest_length', range=NON_NEGATIVE, default='0')]

   !> The ends of the spring can come near each other if |x| and |a| differ by less than this fraction of |a|. Farther
   !> apart, |x|² + |a|² - 2x·γ loses four digits of ℓ² at most.
   real(wp), parameter :: nearly = 1e-2_wp
   !> Lengths below this fraction of l₀ have no direction: products with l₀/ℓ would leave the range of numbers.
   real(wp), parameter :: negligible = least_size

   !> Least length with known bounds, over |x| + |a|: below it, the bound by the inverse length is too large to certify
   !> a step.
   real(wp), parameter :: least_bounded = 1e-4_wp

   !> U(γ) = ½k(ℓ - l₀)², γ = Rᵀa, with ℓ² = |x|² + |a|² - 2x·γ, the square of |x - γ| wherever |γ| = |a|.
   !>
   !> In this form the gradient has no part along γ, which exerts no torque but would act at finite steps: a spring held
   !> at the reference point exerts no torque at all, one without rest length is a uniform field. If the ends can meet,
   !> ℓ would lose its digits; then ℓ² = |x - γ|².
   type, extends(potential_t) :: spring_t
      !> x, body axes, m; shape (3).
      real(wp) :: body_point(3) = 0.0_wp
      !> k, N/m.
      real(wp) :: stiffness = 0.0_wp
      !> l₀, m.
      real(wp) :: rest_length = 0.0_wp
      !> c: ℓ² = |x|² + |a|² - 2x·γ + c(|γ|² - |a|²); 1 if the ends can meet, else 0.
      real(wp), private :: closeness = 1.0_wp
   contains
      procedure :: energy => spring_energy
      procedure :: is_valid => spring_is_valid
      procedure :: gradient => spring_gradient
      procedure :: hessian => spring_hessian
      procedure :: discrete_gradient => spring_discrete_gradient
      procedure :: discrete_hessian => spring_discrete_hessian
      procedure :: linearize => linearize_spring
      procedure :: bound => spring_bound
      procedure :: series_kind => spring_series
      procedure :: auxiliary_series => spring_auxiliary
      procedure :: series_moment => spring_moment
      procedure :: series_torque => spring_torque
      procedure :: series_derivative => spring_series_derivative
      procedure :: series_change => spring_series_change
      procedure :: has_axis => spring_has_axis
      procedure :: parameters => spring_parameters
      procedure :: direction_change => spring_direction_change
      procedure :: gradient_change => spring_gradient_change
      procedure :: energy_change => spring_energy_change
   end type spring_t

   !> Makes a spring.
   interface spring_t
      module procedure new_spring
   end interface spring_t

contains

   !> Makes the potential ½k(ℓ - l₀)² of a spring between a point of the body and an anchor fixed in space.
   pure function new_spring(body_point, anchor, stiffness, rest_length) result(spring)
      !> x, body axes, m; shape (3).
      real(wp), intent(in) :: body_point(3)
      !> a, space axes, m; shape (3).
      real(wp), intent(in) :: anchor(3)
      !> k, N/m.
      real(wp), intent(in) :: stiffness
      !> l₀, m; default 0.
      real(wp), intent(in), optional :: rest_length
      type(spring_t) :: spring
      spring%name = 'spring'
      spring%direction = anchor
      spring%body_point = body_point
      spring%stiffness = stiffness
      if (present(rest_length)) spring%rest_length = rest_length
      spring%closeness = 0.0_wp
      if (.not. all(is_moderate([body_point, anchor]))) return
      if (abs(norm2(body_point) - norm2(anchor)) <= nearly*norm2(anchor)) spring%closeness = 1.0_wp
   end function new_spring

   !> Builds a spring from its scene group. Returns no errors.
   subroutine build_spring(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      real(wp), parameter :: origin(3) = 0.0_wp
      allocate (effect, source=spring_t(group%vector('body_point', origin), group%vector('anchor', origin), &
                                        group%number('stiffness', 0.0_wp), group%number('rest_length', 0.0_wp)))
   end subroutine build_spring

   !> Returns U(γ) = ½k(ℓ - l₀)², J.
   pure real(wp) function spring_energy(self, gamma)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      if (self%rest_length == 0.0_wp) then
         spring_energy = 0.5_wp*self%stiffness*square(self, gamma)
      else
         spring_energy = 0.5_wp*self%stiffness*(length(self, gamma) - self%rest_length)**2
      end if
   end function spring_energy

   !> Returns ∇U = -k(1 - l₀/ℓ) (x - cγ), body axes, N; without the term in l₀ if the ends coincide and the direction is
   !> undefined.
   pure function spring_gradient(self, gamma) result(gradient)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = -self%stiffness*slackness(self%rest_length, length(self, gamma)) &
                 *(self%body_point - self%closeness*gamma)
   end function spring_gradient

   !> Returns the Hessian ck(1 - l₀/ℓ) I + k l₀/ℓ³ (x - cγ)(x - cγ)ᵀ, N/m.
   pure function spring_hessian(self, gamma) result(hessian)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: hessian(3, 3)
      hessian = 2*self%discrete_hessian(gamma, gamma)
   end function spring_hessian

   !> Returns the discrete gradient -k(1 - 2l₀/(ℓ0 + ℓ1)) (x - cγ̄): ℓ² falls by 2(x - cγ̄)·Δγ between the ends, and ℓ
   !> by that over ℓ0 + ℓ1.
   pure function spring_discrete_gradient(self, gamma0, gamma1) result(gradient)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      gradient = -self%stiffness*slackness(self%rest_length, 0.5_wp*(length(self, gamma0) + length(self, gamma1))) &
                 *(self%body_point - (0.5_wp*self%closeness)*(gamma0 + gamma1))
   end function spring_discrete_gradient

   !> Returns the derivative of the discrete gradient by γ1.
   pure function spring_discrete_hessian(self, gamma0, gamma1) result(hessian)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: hessian(3, 3), gradient(3), by_start(3, 3)
      call linearize_spring(self, gamma0, gamma1, gradient, by_start, hessian)
   end function spring_discrete_hessian

   !> Computes the discrete gradient and its derivatives by the ends; the one by γ1 is ½ck(1 - 2l₀/s) I + 2k l₀/s² (x -
   !> cγ̄) (x - cγ1)ᵀ/ℓ1, s = ℓ0 + ℓ1.
   pure subroutine linearize_spring(self, gamma0, gamma1, gradient, by_start, by_end)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp), intent(out) :: gradient(3), by_start(3, 3), by_end(3, 3)
      real(wp) :: mean(3), slope(3), l0, l1, s, stiffness, inverse
      l0 = length(self, gamma0)
      l1 = length(self, gamma1)
      s = l0 + l1
      stiffness = self%stiffness*slackness(self%rest_length, 0.5_wp*s)
      mean = self%body_point - (0.5_wp*self%closeness)*(gamma0 + gamma1)
      gradient = -stiffness*mean
      slope = 0.0_wp
      if (s > negligible*abs(self%rest_length)) then
         inverse = 1/s
         slope = (2*self%stiffness*(self%rest_length*inverse))*(inverse*mean)
      end if
      stiffness = 0.5_wp*self%closeness*stiffness
      call set_derivative(self, gamma0, l0, slope, stiffness, by_start)
      call set_derivative(self, gamma1, l1, slope, stiffness, by_end)
   end subroutine linearize_spring

   !> Sets the derivative with respect to one end, without the term of the change of ℓ if ℓ vanishes.
   pure subroutine set_derivative(self, gamma, length, slope, stiffness, derivative)
      type(spring_t), intent(in) :: self
      !> γ at the end, ℓ there, 2k l₀/s² (x - cγ̄) and ½ck(1 - 2l₀/s).
      real(wp), intent(in) :: gamma(3), length, slope(3), stiffness
      real(wp), intent(out) :: derivative(3, 3)
      real(wp) :: end(3)
      integer :: j
      end = 0.0_wp
      if (length > negligible*abs(self%rest_length)) end = (1/length)*(self%body_point - self%closeness*gamma)
      do j = 1, 3
         derivative(:, j) = end(j)*slope
         derivative(j, j) = derivative(j, j) + stiffness
      end do
   end subroutine set_derivative

   !> Returns ℓ², m²; may be negative by round-off if c = 0.
   !>
   !> The length is the root of this square: `norm2` rounds differently above and below 1, so that results would depend
   !> on the unit.
   pure real(wp) function square(self, gamma)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      if (self%closeness > 0.0_wp) then
         square = sum((self%body_point - gamma)**2)
      else
         square = dot_product(self%body_point, self%body_point) + dot_product(self%direction, self%direction) &
                  - 2*dot_product(self%body_point, gamma)
      end if
   end function square

   !> Returns ℓ, m.
   pure real(wp) function length(self, gamma)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      length = sqrt(max(square(self, gamma), 0.0_wp))
   end function length

   !> Returns 1 - l₀/ℓ, without the second term if ℓ vanishes.
   pure real(wp) function slackness(rest_length, length)
      real(wp), intent(in) :: rest_length, length
      slackness = 1.0_wp
      if (length > negligible*abs(rest_length)) slackness = 1.0_wp - rest_length/length
   end function slackness

   !> Returns `LINEAR_SERIES` for a spring without rest length, which is a uniform field; else `GENERAL_SERIES`.
   pure integer function spring_series(self)
      class(spring_t), intent(in) :: self
      spring_series = GENERAL_SERIES
      if (self%rest_length == 0.0_wp) spring_series = LINEAR_SERIES
   end function spring_series

   !> Returns 7: ℓ², 1/ℓ, and index times coefficient of ℓ²; for derivatives 1/ℓ³ and x×γ/ℓ³.
   pure integer function spring_auxiliary(self)
      class(spring_t), intent(in) :: self
      spring_auxiliary = 7
   end function spring_auxiliary

   !> Returns kx, since γ×∇U = kx×γ for a spring without rest length, N; shape (3).
   pure function spring_moment(self) result(moment)
      class(spring_t), intent(in) :: self
      real(wp) :: moment(3)
      moment = self%stiffness*self%body_point
   end function spring_moment

   !> Computes coefficient k of γ×∇U = k x×γ (1 - l₀/ℓ), body axes, N m. |γ| is constant, so that ℓ² is linear in γ
   !> after its first coefficient. If the ends coincide the spring has no direction: then it acts without its rest
   !> length.
   pure subroutine spring_torque(self, k, gamma, auxiliary, tau)
      class(spring_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k)
      !> Shape (0:highest_order, 7).
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      real(wp) :: older(3), shortened(3), first, slope, inverse
      integer :: j
      if (k == 0) then
         first = length(self, gamma(:, 0))
         auxiliary(0, 1:2) = 0.0_wp
         if (first > negligible*abs(self%rest_length)) auxiliary(0, 1:2) = [first*first, 1/first]
         shortened = auxiliary(0, 2)*gamma(:, 0)
      else
         auxiliary(k, 1) = -2*dot_product(self%body_point, gamma(:, k))
         auxiliary(k, 3) = k*auxiliary(k, 1)
         ! u = ℓ² and v = 1/ℓ have uv' = -u'v/2, and uⱼ = -2x·γⱼ for j > 0: Σ uⱼvₖ₋ⱼ need not be summed.
         older = 0.0_wp
         slope = 0.0_wp
         !GCC$ novector
         do j = 1, k
            inverse = auxiliary(k - j, 2)
            older = older + inverse*gamma(:, j)
            slope = slope + inverse*auxiliary(j, 3)
         end do
         auxiliary(k, 2) = 0.0_wp
         if (auxiliary(0, 2) > 0.0_wp) auxiliary(k, 2) = (0.5_wp*inverses(k)*slope &
                                                          + 2*dot_product(self%body_point, older))/auxiliary(0, 1)
         shortened = older + auxiliary(k, 2)*gamma(:, 0)
      end if
      shortened = self%stiffness*(gamma(:, k) - self%rest_length*shortened)
      associate (x => self%body_point)
         tau = [x(2)*shortened(3) - x(3)*shortened(2), x(3)*shortened(1) - x(1)*shortened(3), &
                x(1)*shortened(2) - x(2)*shortened(1)]
      end associate
   end subroutine spring_torque

   !> Computes coefficient k of ∂τ/∂γ = k(1 - l₀/ℓ)[x]× - kl₀(x×γ)(x - cγ)ᵀ/ℓ³.
   pure subroutine spring_series_derivative(self, k, gamma, auxiliary, derivative, known)
      class(spring_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k)
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: derivative(3, 3)
      logical, intent(out) :: known
      real(wp) :: factor
      integer :: i, j
      known = .true.
      auxiliary(k, 4) = auxiliary(0, 2)**3
      if (k > 0 .and. auxiliary(0, 2) > 0.0_wp) &
         auxiliary(k, 4) = power_term(k, -1.5_wp, auxiliary(:, 1), auxiliary(:, 4))
      auxiliary(k, 5:7) = 0.0_wp
      do j = 0, k
         auxiliary(k, 5:7) = auxiliary(k, 5:7) + auxiliary(k - j, 4)*cross(self%body_point, gamma(:, j))
      end do
      derivative = (-self%stiffness*self%rest_length*auxiliary(k, 2))*skew(self%body_point)
      if (k == 0) derivative = derivative + self%stiffness*skew(self%body_point)
      factor = self%stiffness*self%rest_length
      do i = 1, 3
         derivative(:, i) = derivative(:, i) - (factor*self%body_point(i))*auxiliary(k, 5:7)
      end do
      if (.not. self%closeness > 0.0_wp) return
      do j = 0, k
         do i = 1, 3
            derivative(:, i) = derivative(:, i) + (factor*gamma(i, k - j))*auxiliary(j, 5:7)
         end do
      end do
   end subroutine spring_series_derivative

   !> Computes coefficient k of δ(k(1 - l₀/ℓ)x)×γ, δ(1/ℓ) = -δℓ²/2ℓ³. Without rest length there is no series of ℓ, so
   !> that its change is not known.
   pure subroutine spring_series_change(self, change, k, gamma, auxiliary, tau, known)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k), auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      real(wp) :: moment(3), shortening(3), square
      integer :: j
      moment = change(7)*self%body_point + self%stiffness*change(1:3)
      tau = cross(moment, gamma(:, k))
      known = .not. abs(change(8)) > 0.0_wp
      if (self%rest_length == 0.0_wp) return
      known = .true.
      shortening = self%rest_length*moment + (self%stiffness*change(8))*self%body_point
      do j = 0, k
         tau = tau - auxiliary(k - j, 2)*cross(shortening, gamma(:, j))
         square = -2*dot_product(change(1:3), gamma(:, k - j))
         if (j == k) square = square + 2*(dot_product(change(1:3), self%body_point) &
                                          + (1 - self%closeness)*dot_product(change(4:6), self%direction))
         tau = tau + (0.5_wp*self%stiffness*self%rest_length*square)*auxiliary(j, 5:7)
      end do
   end subroutine spring_series_change

   !> Bounds the torque in a step as that of a uniform field of moment kx along a, times φ = 1 - 2l₀/(ℓ0 + ℓ1). A change
   !> of b moves the end of length min(|x|, |a|) by 4 times that at most. No bounds are known if the ends can meet.
   pure subroutine spring_bound(self, map, radius, gamma, slack, bounds)
      class(spring_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      type(effect_bounds_t) :: field
      real(wp) :: x, a, reach, first, least, greatest, stretch, stretch_slope, stretch_curvature, by_b, by_b_twice
      x = vector_length(self%body_point)
      a = vector_length(self%direction)
      field = bounds_of_linear(map, radius, self%stiffness*self%body_point, a)
      if (self%closeness > 0.0_wp) call add_closeness(abs(self%stiffness)*map%norm*a*a, radius, field)
      bounds = field
      if (self%rest_length == 0.0_wp) return
      reach = min(x, a)
      first = max(abs(x - a), length(self, gamma) - slack*reach)
      least = first + max(abs(x - a), first - 4*radius*reach)
      greatest = min(x + a, length(self, gamma) + slack*reach)
      greatest = greatest + min(x + a, greatest + 4*radius*reach)
      bounds%known = least - first > least_bounded*(x + a)
      if (.not. bounds%known) return
      by_b = 4*reach/least
      by_b_twice = (16*x*a + (4*reach)**2)/((least - first)*least)
      stretch = max(abs(1 - 2*self%rest_length/least), abs(1 - 2*self%rest_length/greatest))
      stretch_slope = 2*abs(self%rest_length)/least*by_b
      stretch_curvature = 2*abs(self%rest_length)/least*(by_b_twice + 2*by_b*by_b)
      bounds%force = stretch*field%force
      bounds%slope = stretch*field%slope + stretch_slope*field%force
      bounds%curvature = stretch*field%curvature + 2*stretch_slope*field%slope + stretch_curvature*field%force
   end subroutine spring_bound

   !> Adds the bounds for ends that can meet: x - γ̄ replaces x. γ̄ = ((1-β)γ½ + 2b(b·γ½))/(1+β), so that the torque has
   !> k(2b·γ½/(1+β)) γ½×b beside that of the field.
   pure subroutine add_closeness(strength, radius, field)
      !> k|a|²‖A‖ and ρ.
      real(wp), intent(in) :: strength, radius
      type(effect_bounds_t), intent(inout) :: field
      field%force = field%force + strength*radius**2
      field%slope = field%slope + strength*radius*(4 + radius*(4 + 2*radius))
      field%curvature = field%curvature + strength*(4 + radius*(16 + radius*(26 + 16*radius)))
   end subroutine add_closeness

   !> Returns true if the parameters, and the energy at the greatest length, can be computed with.
   pure logical function spring_is_valid(self)
      class(spring_t), intent(in) :: self
      spring_is_valid = all(is_moderate([self%direction, self%body_point, self%stiffness, self%rest_length]))
      if (spring_is_valid) spring_is_valid = is_moderate(self%stiffness*( &
         sum(abs(self%direction)) + sum(abs(self%body_point)) + abs(self%rest_length))**2)
   end function spring_is_valid

   !> Returns true if x lies along the axis.
   pure logical function spring_has_axis(self, axis)
      class(spring_t), intent(in) :: self
      integer, intent(in) :: axis
      spring_has_axis = lies_along(self%body_point, axis)
   end function spring_has_axis

   !> Returns the parameters x, a, k and l₀.
   pure function spring_parameters(self) result(list)
      class(spring_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('body_point', 3), parameter_t('anchor', 3), parameter_t('stiffness'), &
              parameter_t('rest_length')]
   end function spring_parameters

   pure function spring_direction_change(self, change, t) result(n)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t
      real(wp) :: n(3)
      n = change(4:6)
   end function spring_direction_change

   !> Returns -(δkφ + kδφ)(x - cγ̄) - kφδx, φ = 1 - 2l₀/s, δφ = -2δl₀/s + 2l₀(δℓ0 + δℓ1)/s², s = ℓ0 + ℓ1.
   pure function spring_gradient_change(self, change, gamma0, gamma1) result(gradient)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      real(wp) :: l0, l1, s, slack, slack_change
      l0 = length(self, gamma0)
      l1 = length(self, gamma1)
      s = l0 + l1
      slack = slackness(self%rest_length, 0.5_wp*s)
      slack_change = 0.0_wp
      if (min(l0, l1) > negligible*abs(self%rest_length)) slack_change = (-2*change(8) + 2*(self%rest_length/s)*( &
         square_change(self, change, gamma0)/(2*l0) + square_change(self, change, gamma1)/(2*l1)))/s
      gradient = -(change(7)*slack + self%stiffness*slack_change)*(self%body_point &
                 - (0.5_wp*self%closeness)*(gamma0 + gamma1)) - (self%stiffness*slack)*change(1:3)
   end function spring_gradient_change

   !> Returns the change of ℓ² at fixed γ, m².
   pure real(wp) function square_change(self, change, gamma)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma(3)
      square_change = 2*(dot_product(change(1:3), self%body_point - gamma) &
                         + (1 - self%closeness)*dot_product(change(4:6), self%direction))
   end function square_change

   pure real(wp) function spring_energy_change(self, change, gamma)
      class(spring_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma(3)
      real(wp) :: l
      l = length(self, gamma)
      spring_energy_change = 0.5_wp*change(7)*(l - self%rest_length)**2 + 0.5_wp*self%stiffness*( &
         slackness(self%rest_length, l)*square_change(self, change, gamma) - 2*(l - self%rest_length)*change(8))
   end function spring_energy_change

end module nutate_spring
