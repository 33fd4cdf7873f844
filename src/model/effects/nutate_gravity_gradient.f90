!> The gradient of a central gravity field over an orbiting body: V = ½·3(μ/r³) γᵀJγ, γ = Rᵀn.
module nutate_gravity_gradient
   use nutate_admissible, only: ANY_DIRECTION
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, GENERAL_SERIES, parameter_t, potential_t
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t, projection_curvature, projection_part, &
      projection_slope
   use nutate_kepler_orbit, only: kepler_orbit_t, n_elements, mean_motion_change
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_limits, only: is_direction, is_moderate
   use nutate_orbit, only: orbit_t
   use nutate_quaternion, only: cross
   use nutate_small_products, only: is_symmetric_about, skew, times_vector, vector_length
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: gravity_gradient_t, gravity_gradient_keys, build_gravity_gradient

   !> Keys of the scene group `&gravity_gradient`.
   type(key_t), parameter :: gravity_gradient_keys(3) = [ &
      key_t(name='direction', least=3, most=3, range=ANY_DIRECTION, default='that of &orbit'), &
      key_t(name='strength', default='that of &orbit'), &
      key_t(name='orbit', kind=KEY_TEXT)]

   !> U(γ) = ½ γᵀAγ + U₀, A = 3(μ/r³)(J - J_m I), U₀ = ½ 3(μ/r³)J_m, J_m the intermediate principal moment: the effect's
   !> V wherever |γ| = 1. U is quadratic, so the gradient at the mean of two γ is a discrete gradient: ∇̄U = Aγ̄.
   !>
   !> The isotropic part of J exerts no torque, but would act at finite steps. Without it a body with three equal
   !> moments feels no torque at all.
   type, extends(potential_t) :: gravity_gradient_t
      !> A, body axes, J; shape (3,3).
      real(wp) :: stiffness(3, 3) = 0.0_wp
      !> U₀, J.
      real(wp) :: offset = 0.0_wp
      !> Factors of A and U₀, for their derivatives: μ/r³, s⁻², the length of the direction as given, J - J_m I and J_m,
      !> kg m², and the principal axis of J_m.
      real(wp) :: strength = 0.0_wp, reach = 1.0_wp, deviation(3, 3) = 0.0_wp, middle = 0.0_wp, middle_axis(3) = 0.0_wp
      !> True if the gradient belongs to an orbit, and that orbit.
      logical :: on_orbit = .false.
      type(kepler_orbit_t) :: path = kepler_orbit_t()
   contains
      procedure :: energy => quadratic_energy
      procedure :: is_valid => gradient_is_valid
      procedure :: gradient => quadratic_gradient
      procedure :: hessian => quadratic_hessian
      procedure :: discrete_gradient => midpoint_gradient
      procedure :: discrete_hessian => half_hessian
      procedure :: linearize => linearize_quadratic
      procedure :: bound => quadratic_bound
      procedure :: series_kind => quadratic_series
      procedure :: series_torque => quadratic_torque
      procedure :: series_derivative => quadratic_series_derivative
      procedure :: series_change => quadratic_series_change
      procedure :: has_axis => quadratic_has_axis
      procedure :: parameters => quadratic_parameters
      procedure :: direction_change => quadratic_direction_change
      procedure :: gradient_change => quadratic_gradient_change
      procedure :: energy_change => quadratic_energy_change
      procedure :: factor_change => quadratic_factor_change
      procedure :: follows => gradient_follows
      procedure :: thin_table => thin_path
   end type gravity_gradient_t

   !> Makes a gravity gradient on a body, along a direction or of a circular orbit.
   interface gravity_gradient_t
      module procedure new_gravity_gradient, gradient_on_orbit
   end interface gravity_gradient_t

contains

   !> Makes the potential of the gravity gradient of a distant centre of attraction in a fixed direction.
   pure function new_gravity_gradient(body, direction, strength) result(gradient)
      !> Body, of which the inertia about the reference point is used.
      type(body_t), intent(in) :: body
      !> Direction to the centre of attraction, space axes, of any length but zero; shape (3).
      real(wp), intent(in) :: direction(3)
      !> μ/r³, s⁻².
      real(wp), intent(in) :: strength
      type(gravity_gradient_t) :: gradient
      real(wp) :: scaled(3), middle
      integer :: i, k
      gradient%name = 'gravity_gradient'
      if (.not. (is_direction(direction) .and. is_moderate(strength))) then
         gradient%offset = huge(1.0_wp)
         return
      end if
      ! The vector is scaled first: the squares of a long or short vector would leave the range of numbers.
      scaled = direction/maxval(abs(direction))
      gradient%direction = scaled/norm2(scaled)
      gradient%reach = maxval(abs(direction))*norm2(scaled)
      middle = max(min(body%moments(1), body%moments(2)), min(max(body%moments(1), body%moments(2)), body%moments(3)))
      gradient%stiffness = body%inertia
      do i = 1, 3
         gradient%stiffness(i, i) = gradient%stiffness(i, i) - middle
      end do
      gradient%strength = strength
      gradient%by_inertia = 3*strength
      gradient%deviation = gradient%stiffness
      gradient%middle = middle
      k = minloc(abs(body%moments - middle), dim=1)
      gradient%middle_axis = body%axes(:, k)
      gradient%stiffness = 3*strength*gradient%stiffness
      gradient%offset = 1.5_wp*strength*middle
   end function new_gravity_gradient

   !> Makes the gravity gradient in the LVLH axes of a circular orbit: along z, of strength n². In inertial axes the
   !> gradient is an `orbital_gradient_t`; here, an orbit with inertial axes gives a potential that every stepper
   !> rejects.
   pure function gradient_on_orbit(body, orbit) result(gradient)
      !> Body, of which the inertia about the reference point is used.
      type(body_t), intent(in) :: body
      !> Orbit whose LVLH frame gives the space axes.
      type(orbit_t), intent(in) :: orbit
      type(gravity_gradient_t) :: gradient
      gradient = new_gravity_gradient(body, [0.0_wp, 0.0_wp, 1.0_wp], orbit%path%mean_motion()**2)
      if (.not. orbit%is_frame) gradient%offset = huge(1.0_wp)
      gradient%on_orbit = .true.
      gradient%path = orbit%path
   end function gradient_on_orbit

   !> Builds a gravity gradient from its scene group. Errors: `NUTATE_BAD_ARGUMENT` if the group lacks direction or
   !> strength.
   subroutine build_gravity_gradient(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      if (.not. (group%has('direction') .and. group%has('strength'))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a gravity gradient needs direction and strength (expected both, or '// &
                       '&orbit and neither of them)', merge('direction', 'strength ', group%has('direction')))
      else if (group%has('orbit')) then
         status = fail(NUTATE_BAD_ARGUMENT, 'orbit with direction and strength (expected orbit without them)', 'orbit')
      end if
      if (.not. status%ok()) return
      allocate (effect, source=gravity_gradient_t(body, group%vector('direction', [0.0_wp, 0.0_wp, 1.0_wp]), &
                                                  group%number('strength', 0.0_wp)))
   end subroutine build_gravity_gradient

   !> Returns U(γ) = ½γᵀAγ + U₀, J.
   pure real(wp) function quadratic_energy(self, gamma)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      quadratic_energy = 0.5_wp*dot_product(gamma, self%gradient(gamma)) + self%offset
   end function quadratic_energy

   !> Returns ∇U = Aγ, body axes; shape (3).
   pure function quadratic_gradient(self, gamma) result(gradient)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = self%stiffness(:, 1)*gamma(1) + self%stiffness(:, 2)*gamma(2) + self%stiffness(:, 3)*gamma(3)
   end function quadratic_gradient

   !> Returns the Hessian A; shape (3,3).
   pure function quadratic_hessian(self, gamma) result(hessian)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: hessian(3, 3)
      hessian = self%stiffness
   end function quadratic_hessian

   !> Returns the discrete gradient ∇̄U = Aγ̄, γ̄ the mean of γ at the ends of the step.
   pure function midpoint_gradient(self, gamma0, gamma1) result(gradient)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      gradient = self%gradient(0.5_wp*(gamma0 + gamma1))
   end function midpoint_gradient

   !> Returns ∂∇̄U/∂γ1 = ½A.
   pure function half_hessian(self, gamma0, gamma1) result(hessian)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: hessian(3, 3)
      hessian = 0.5_wp*self%stiffness
   end function half_hessian

   !> Computes ∇̄U and its derivatives with respect to the ends, which are equal.
   pure subroutine linearize_quadratic(self, gamma0, gamma1, gradient, by_start, by_end)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp), intent(out) :: gradient(3), by_start(3, 3), by_end(3, 3)
      by_end = 0.5_wp*self%stiffness
      by_start = by_end
      gradient = times_vector(by_end, gamma0 + gamma1)
   end subroutine linearize_quadratic

   !> Bounds the torque in a step: γ½×Aγ̄, γ̄ the mean of γ at the ends, has in principal axes components (A_k -
   !> A_l)γ_kγ_l, and none exceeds the larger of |A_k|, |A_l|. So the components lie in a box, whose image under the map
   !> is farthest away at a corner. A change of b rotates γ½ and γ̄ by 2|δb| at most, in second order by 4 and 8 |δb|².
   pure subroutine quadratic_bound(self, map, radius, gamma, slack, bounds)
      class(gravity_gradient_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      real(wp) :: sides(3, 3), strength(3), square, direct, whole, part, change
      integer :: i
      bounds%known = .not. self%moves
      if (.not. bounds%known) return
      do i = 1, 3
         strength(i) = abs(dot_product(map%axes(:, i), times_vector(self%stiffness, map%axes(:, i))))
      end do
      do i = 1, 3
         sides(:, i) = max(strength(1 + modulo(i, 3)), strength(1 + modulo(i + 1, 3))) &
                       *times_vector(map%matrix, map%axes(:, i))
      end do
      square = dot_product(self%direction, self%direction)
      direct = 0.0_wp
      do i = 0, 3
         direct = max(direct, vector_length(sides(:, 1) + sign(1.0_wp, 0.5_wp - mod(i, 2))*sides(:, 2) &
                                    + sign(1.0_wp, 1.5_wp - i)*sides(:, 3)))
      end do
      direct = square*direct
      whole = square*map%norm*maxval(strength)
      part = projection_part(radius)
      change = projection_slope(radius)
      bounds%force = direct + part*whole
      bounds%slope = 4*direct + (change + 4*part)*whole
      bounds%curvature = 20*direct + (projection_curvature + 8*change + 20*part)*whole
   end subroutine quadratic_bound

   !> Returns `GENERAL_SERIES`.
   pure integer function quadratic_series(self)
      class(gravity_gradient_t), intent(in) :: self
      quadratic_series = GENERAL_SERIES
   end function quadratic_series

   !> Computes coefficient k of γ×Aγ, body axes, N m, from the products γ₁γ₂, ..., each of which two components need.
   pure subroutine quadratic_torque(self, k, gamma, auxiliary, tau)
      class(gravity_gradient_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k)
      !> Not used.
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      real(wp) :: xy, xz, yz, squares(3)
      integer :: j
      xy = 0.0_wp
      xz = 0.0_wp
      yz = 0.0_wp
      do j = 0, k
         xy = xy + gamma(1, j)*gamma(2, k - j)
         xz = xz + gamma(1, j)*gamma(3, k - j)
         yz = yz + gamma(2, j)*gamma(3, k - j)
      end do
      associate (a => self%stiffness)
         tau = [(a(3, 3) - a(2, 2))*yz, (a(1, 1) - a(3, 3))*xz, (a(2, 2) - a(1, 1))*xy]
         if (.not. (abs(a(2, 1)) > 0.0_wp .or. abs(a(3, 1)) > 0.0_wp .or. abs(a(3, 2)) > 0.0_wp)) return
         squares = 0.0_wp
         do j = 0, (k + 1)/2 - 1
            squares = squares + gamma(:, j)*gamma(:, k - j)
         end do
         squares = 2*squares
         if (iand(k, 1) == 0) squares = squares + gamma(:, k/2)*gamma(:, k/2)
         tau(1) = tau(1) + a(3, 2)*(squares(2) - squares(3)) + (a(3, 1)*xy - a(2, 1)*xz)
         tau(2) = tau(2) + a(3, 1)*(squares(3) - squares(1)) + (a(2, 1)*yz - a(3, 2)*xy)
         tau(3) = tau(3) + a(2, 1)*(squares(1) - squares(2)) + (a(3, 2)*xz - a(3, 1)*yz)
      end associate
   end subroutine quadratic_torque

   !> Computes coefficient k of ∂(γ×Aγ)/∂γ = [γ]×A - [Aγ]×.
   pure subroutine quadratic_series_derivative(self, k, gamma, auxiliary, derivative, known)
      class(gravity_gradient_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k)
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: derivative(3, 3)
      logical, intent(out) :: known
      integer :: i
      known = .true.
      derivative = -skew(self%gradient(gamma(:, k)))
      do i = 1, 3
         derivative(:, i) = derivative(:, i) + cross(gamma(:, k), self%stiffness(:, i))
      end do
   end subroutine quadratic_series_derivative

   !> Computes coefficient k of γ×δAγ.
   pure subroutine quadratic_series_change(self, change, k, gamma, auxiliary, tau, known)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k), auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      real(wp) :: matrix(3, 3), unit(3)
      integer :: j
      known = .true.
      do j = 1, 3
         unit = 0.0_wp
         unit(j) = 1.0_wp
         matrix(:, j) = self%gradient_change(change, unit, unit)
      end do
      tau = 0.0_wp
      do j = 0, k
         tau = tau + cross(gamma(:, j), times_vector(matrix, gamma(:, k - j)))
      end do
   end subroutine quadratic_series_change

   !> Returns true if A is diagonal with equal elements across the axis.
   pure logical function quadratic_has_axis(self, axis)
      class(gravity_gradient_t), intent(in) :: self
      integer, intent(in) :: axis
      quadratic_has_axis = is_symmetric_about(self%stiffness, axis) .and. .not. self%moves
   end function quadratic_has_axis

   !> Returns true if the parameters, and the sums of |A| by rows and U₀, the largest torque and energy, can be computed
   !> with.
   pure logical function gradient_is_valid(self)
      class(gravity_gradient_t), intent(in) :: self
      gradient_is_valid = all(is_moderate(self%direction)) .and. all(is_moderate(self%stiffness)) .and. &
                             is_moderate(self%offset)
      if (gradient_is_valid) &
         gradient_is_valid = is_moderate(maxval(sum(abs(self%stiffness), dim=1)) + abs(self%offset))
   end function gradient_is_valid

   !> Returns the parameters: n, μ/r³, J, and the orbit if there is one.
   pure function quadratic_parameters(self) result(list)
      class(gravity_gradient_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('direction', 3), parameter_t('strength'), parameter_t('inertia', 9)]
      if (.not. self%on_orbit) return
      list(1)%name = ''
      list = [list, parameter_t('orbit', n_elements)]
   end function quadratic_parameters

   pure logical function gradient_follows(self, path)
      class(gravity_gradient_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      gradient_follows = self%on_orbit .and. self%path%equals(path)
   end function gradient_follows

   !> Returns δs, with the change of n² if the direction is fixed on an orbit.
   pure real(wp) function strength_change(self, change)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      strength_change = change(4)
      if (self%on_orbit .and. .not. self%moves) &
         strength_change = change(4) + 2*self%path%mean_motion()*mean_motion_change(self%path, change(14:))
   end function strength_change

   !> Returns the change of the unit vector along the direction, which is given in any length.
   pure function quadratic_direction_change(self, change, t) result(n)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t
      real(wp) :: n(3)
      n = (change(1:3) - dot_product(self%direction, change(1:3))*self%direction)/self%reach
   end function quadratic_direction_change

   !> Returns δA γ̄, δA = 3δs(J - J_m I) + 3s(δJ - δJ_m I).
   pure function quadratic_gradient_change(self, change, gamma0, gamma1) result(gradient)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      real(wp) :: gamma(3), inertia(3, 3)
      gamma = 0.5_wp*(gamma0 + gamma1)
      inertia = reshape(change(5:13), [3, 3])
      gradient = (3*strength_change(self, change))*times_vector(self%deviation, gamma) &
                 + (3*self%strength)*(times_vector(inertia, gamma) - middle_change(self, inertia)*gamma)
   end function quadratic_gradient_change

   !> Returns δJ_m = vᵀδJv, v the axis of J_m, kg m². If two moments are equal, J_m has a kink, and δJ_m holds on one
   !> side of it.
   pure real(wp) function middle_change(self, inertia)
      class(gravity_gradient_t), intent(in) :: self
      !> δJ; shape (3,3).
      real(wp), intent(in) :: inertia(3, 3)
      middle_change = dot_product(self%middle_axis, times_vector(inertia, self%middle_axis))
   end function middle_change

   pure real(wp) function quadratic_energy_change(self, change, gamma)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma(3)
      quadratic_energy_change = 0.5_wp*dot_product(gamma, self%gradient_change(change, gamma, gamma)) + 1.5_wp* &
         (strength_change(self, change)*self%middle + self%strength*middle_change(self, reshape(change(5:13), [3, 3])))
   end function quadratic_energy_change

   !> Returns the change of 3μ/r³.
   pure function quadratic_factor_change(self, change) result(factors)
      class(gravity_gradient_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      real(wp) :: factors(2)
      factors = [3*strength_change(self, change), 0.0_wp]
   end function quadratic_factor_change

   !> Leaves out every second line of the table of the orbit.
   subroutine thin_path(self)
      class(gravity_gradient_t), intent(inout) :: self
      call self%path%thin_table()
   end subroutine thin_path

end module nutate_gravity_gradient
