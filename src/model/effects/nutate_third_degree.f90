!> The third degree of the gravity of an attracting body over a body on an orbit, from third moments of its mass:
!>
!>     V = -(5μ/2d⁴) S_ijk γ_iγ_jγ_k,   S = T - ⅕(δ_ij s_k + δ_ik s_j + δ_jk s_i),
!>     T_ijk = ∫ρ_iρ_jρ_k dm,   s_i = T_ikk,
!>
!> γ = R(q)ᵀn(t) with n from the body to the attracting one, of the length (μ/d⁴)^⅓, which replaces the factor. The
!> traces of T exert no torque, but would act at finite steps.
module nutate_third_degree
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, GENERAL_SERIES, parameter_t, potential_t
   use nutate_effect_bounds, only: bounds_of_potential, effect_bounds_t, linear_map_t
   use nutate_kepler_orbit, only: find_place, kepler_orbit_t, n_elements, position_change
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_limits, only: in_words, is_moderate
   use nutate_orbit, only: orbit_t
   use nutate_orbit_change_series, only: pull_change_series
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_small_products, only: skew, vector_length
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: third_degree_t, third_degree_keys, build_third_degree, third_degree_on_orbit, third_moments_of, &
      change_of_third_moments, check_points

   !> Largest number of points in a scene, each as mass, x, y, z; a file may have any number.
   integer, parameter :: most_points = 64
   !> Components of the ten third moments, in the order of the key.
   integer, parameter :: components(3, 10) = reshape([1, 1, 1, 2, 2, 2, 3, 3, 3, 1, 1, 2, 1, 1, 3, 1, 2, 2, 2, 2, 3, &
                                                      1, 3, 3, 2, 3, 3, 1, 2, 3], [3, 10])

   !> Keys of the scene group `&third_degree`.
   type(key_t), parameter :: third_degree_keys(4) = [ &
      key_t(name='third_moments', least=10, most=10, instead_of='points,table'), &
      key_t(name='points', least=4, most=4*most_points, instead_of='third_moments,table'), &
      key_t(name='table', kind=KEY_TEXT, instead_of='third_moments,points'), &
      key_t(name='orbit', kind=KEY_TEXT)]

   !> U(γ) = -(5/2) S_ijk γ_iγ_jγ_k. ∇̄U = -(15/2) S_ijk (γ̄_jγ̄_k + Δγ_jΔγ_k/12): the mean of ∇U on the way from one
   !> γ to the other.
   type, extends(potential_t) :: third_degree_t
      !> S, body axes, kg m³; symmetric and without traces; shape (3,3,3).
      real(wp) :: moments(3, 3, 3) = 0.0_wp
      !> Orbit along which n moves.
      type(kepler_orbit_t) :: path = kepler_orbit_t()
   contains
      procedure :: energy => cubic_energy
      procedure :: gradient => cubic_gradient
      procedure :: hessian => cubic_hessian
      procedure :: discrete_gradient => mean_gradient
      procedure :: discrete_hessian => mean_hessian
      procedure :: direction_at => direction_to_body
      procedure :: power => power_of_motion
      procedure :: direction_series => series_to_body
      procedure :: see_from_lvlh => third_degree_from_lvlh
      procedure :: bound => cubic_bound
      procedure :: series_kind => cubic_series
      procedure :: auxiliary_series => cubic_auxiliary
      procedure :: series_torque => cubic_torque
      procedure :: series_derivative => cubic_series_derivative
      procedure :: is_valid => cubic_is_valid
      procedure :: parameters => cubic_parameters
      procedure :: direction_change => change_by_orbit
      procedure :: direction_change_series => change_series_by_orbit
      procedure :: gradient_change => cubic_gradient_change
      procedure :: energy_change => cubic_energy_change
      procedure :: series_change => cubic_series_change
      procedure :: follows => cubic_follows
      procedure :: thin_table => thin_path
   end type third_degree_t

   !> Makes the third degree from third moments.
   interface third_degree_t
      module procedure new_third_degree
   end interface third_degree_t

contains

   !> Returns the third degree on a body on an orbit.
   pure function new_third_degree(moments, orbit) result(effect)
      !> T: xxx, yyy, zzz, xxy, xxz, xyy, yyz, xzz, yzz, xyz, body axes, about the centre of mass, kg m³; shape (10).
      real(wp), intent(in) :: moments(10)
      type(orbit_t), intent(in) :: orbit
      type(third_degree_t) :: effect
      effect%name = 'third_degree'
      effect%moments = without_traces(moments)
      effect%path = orbit%path
      effect%moves = .not. orbit%is_frame
      effect%direction = 0.0_wp
      if (.not. effect%is_valid()) return
      if (effect%moves) then
         effect%pace = orbit%path%fastest_turn()
         effect%direction = effect%direction_at(0.0_wp)
      else
         effect%direction = direction_in_lvlh(orbit%path)
      end if
   end function new_third_degree

   !> Returns n in the LVLH frame of a circular orbit, where the attracting body is along z; shape (3).
   pure function direction_in_lvlh(path) result(n)
      type(kepler_orbit_t), intent(in) :: path
      real(wp) :: n(3)
      n = [0.0_wp, 0.0_wp, strength_of(path%mu, path%radius(0.0_wp))]
   end function direction_in_lvlh

   !> Makes the third degree as seen from the LVLH frame of a circular orbit.
   subroutine third_degree_from_lvlh(self, seen)
      class(third_degree_t), intent(in) :: self
      class(potential_t), allocatable, intent(out) :: seen
      type(third_degree_t) :: constant
      constant = self
      constant%moves = .false.
      constant%pace = 0.0_wp
      constant%direction = direction_in_lvlh(self%path)
      allocate (seen, source=constant)
   end subroutine third_degree_from_lvlh

   !> Returns (μ/d⁴)^⅓.
   pure real(wp) function strength_of(mu, distance) result(strength)
      real(wp), intent(in) :: mu, distance
      strength = (mu/distance)**(1.0_wp/3)/distance
   end function strength_of

   !> Returns S from T; shape (3,3,3).
   pure function without_traces(moments) result(s)
      real(wp), intent(in) :: moments(10)
      real(wp) :: s(3, 3, 3), trace(3)
      integer :: i, j, k, n
      do n = 1, 10
         i = components(1, n)
         j = components(2, n)
         k = components(3, n)
         s(i, j, k) = moments(n)
         s(i, k, j) = moments(n)
         s(j, i, k) = moments(n)
         s(j, k, i) = moments(n)
         s(k, i, j) = moments(n)
         s(k, j, i) = moments(n)
      end do
      do i = 1, 3
         trace(i) = s(i, 1, 1)/5 + s(i, 2, 2)/5 + s(i, 3, 3)/5
      end do
      do i = 1, 3
         do j = 1, 3
            s(i, j, j) = s(i, j, j) - trace(i)
            s(j, i, j) = s(j, i, j) - trace(i)
            s(j, j, i) = s(j, j, i) - trace(i)
         end do
      end do
   end function without_traces

   !> Returns the third moments of point masses about their centre, in the order of the key, kg m³; shape (10).
   pure function third_moments_of(points) result(moments)
      !> Mass, kg, and position, body axes, m, of each; shape (4, n).
      real(wp), intent(in) :: points(:, :)
      real(wp) :: moments(10), centre(3), mass, rho(3)
      integer :: a, n
      mass = sum(points(1, :))
      centre = 0.0_wp
      do a = 1, size(points, 2)
         centre = centre + (points(1, a)/mass)*points(2:4, a)
      end do
      moments = 0.0_wp
      do a = 1, size(points, 2)
         rho = points(2:4, a) - centre
         do n = 1, 10
            moments(n) = moments(n) + points(1, a)*rho(components(1, n))*rho(components(2, n))*rho(components(3, n))
         end do
      end do
   end function third_moments_of

   !> Returns the change of third moments by a change of point masses, in the order of the key; shape (10). With c the
   !> centre, M the mass of all and ρ = x - c: δc = (Σδm ρ + m δx)/M, δρ = δx - δc.
   pure function change_of_third_moments(points, change) result(moments)
      !> Mass, kg, and position, body axes, m, of each, and the change of these; shape (4, n).
      real(wp), intent(in) :: points(:, :), change(:, :)
      real(wp) :: moments(10), centre(3), moved(3), mass, rho(3), shift(3), products(3)
      integer :: a, n
      mass = sum(points(1, :))
      centre = 0.0_wp
      do a = 1, size(points, 2)
         centre = centre + (points(1, a)/mass)*points(2:4, a)
      end do
      moved = 0.0_wp
      do a = 1, size(points, 2)
         moved = moved + (change(1, a)/mass)*(points(2:4, a) - centre) + (points(1, a)/mass)*change(2:4, a)
      end do
      moments = 0.0_wp
      do a = 1, size(points, 2)
         rho = points(2:4, a) - centre
         shift = change(2:4, a) - moved
         do n = 1, 10
            associate (i => components(1, n), j => components(2, n), k => components(3, n))
               products = [shift(i)*rho(j)*rho(k), rho(i)*shift(j)*rho(k), rho(i)*rho(j)*shift(k)]
               moments(n) = moments(n) + change(1, a)*rho(i)*rho(j)*rho(k) + points(1, a)*sum(products)
            end associate
         end do
      end do
   end function change_of_third_moments

   !> Rejects a group in a scene without an orbit. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine build_third_degree(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      status = fail(NUTATE_BAD_ARGUMENT, 'gravity of third degree needs an orbit (expected &orbit)')
   end subroutine build_third_degree

   !> Builds the effect on an orbit from its scene group. Errors: `NUTATE_BAD_ARGUMENT` unless it gives one of third
   !> moments, points and table, and for invalid points.
   subroutine third_degree_on_orbit(group, orbit, effect, status)
      type(group_t), intent(in) :: group
      type(orbit_t), intent(in) :: orbit
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      real(wp), parameter :: none(10) = 0.0_wp
      real(wp), allocatable :: points(:, :)
      integer :: n
      n = group%count_of('points')
      if (count([group%has('third_moments'), group%has('points'), group%has('table')]) /= 1) then
         status = fail(NUTATE_BAD_ARGUMENT, &
              'gravity of third degree needs third_moments, points or a table (expected '// &
                       'one of them)', merge('points', 'table ', group%has('points')))
      else if (group%has('third_moments')) then
         allocate (effect, source=third_degree_t(group%vector('third_moments', none), orbit))
      else if (group%has('points')) then
         if (mod(n, 4) /= 0) then
            status = fail(NUTATE_BAD_ARGUMENT, &
                 'the number of values of points is no multiple of 4 (expected mass, x, '// &
                          'y, z of each)', 'points')
            return
         end if
         points = reshape(group%vector('points', spread(0.0_wp, 1, n)), [4, n/4])
         call build_from(points)
      else if (allocated(group%table)) then
         points = group%table%numbers
         call build_from(points)
      else
         status = fail(NUTATE_BAD_ARGUMENT, 'the table has not been read', 'table')
      end if

   contains

      subroutine build_from(points)
         real(wp), intent(in) :: points(:, :)
         integer :: at
         call check_points(points, at, status)
         if (status%ok()) allocate (effect, source=third_degree_t(third_moments_of(points), orbit))
      end subroutine build_from

   end subroutine third_degree_on_orbit

   !> Checks point masses.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` with the first point that has an error: a mass that is not positive, or a length
   !> whose third power times the mass is too large.
   subroutine check_points(points, at, status)
      !> Mass, kg, and position, m, of each; shape (4, n).
      real(wp), intent(in) :: points(:, :)
      !> Index of that point, 1 to n; 0 for none.
      integer, intent(out) :: at
      type(status_t), intent(out) :: status
      real(wp), parameter :: longest = 1e20_wp, least = 1e-40_wp, heaviest = 1e40_wp
      do at = 1, size(points, 2)
         if (.not. (points(1, at) >= least .and. points(1, at) <= heaviest)) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the mass of a point is out of range (expected '// &
                          in_words(least, heaviest)//' kg)', 'points')
         else if (.not. all(abs(points(2:4, at)) <= longest)) then
            status = fail(NUTATE_BAD_ARGUMENT, 'the position of a point is out of range (expected up to '// &
                          in_words(longest)//' m)', 'points')
         end if
         if (.not. status%ok()) return
      end do
      at = 0
      if (size(points, 2) == 0) status = fail(NUTATE_BAD_ARGUMENT, 'there is no point (expected one line for each)', &
                                              'points')
   end subroutine check_points

   !> Returns S_ijk γ_k; shape (3,3).
   pure function contracted(s, gamma) result(matrix)
      real(wp), intent(in) :: s(3, 3, 3), gamma(3)
      real(wp) :: matrix(3, 3)
      matrix = gamma(1)*s(:, :, 1) + gamma(2)*s(:, :, 2) + gamma(3)*s(:, :, 3)
   end function contracted

   !> Returns S_ijk γ_jγ_k; shape (3).
   pure function contracted_twice(s, gamma) result(vector)
      real(wp), intent(in) :: s(3, 3, 3), gamma(3)
      real(wp) :: vector(3)
      vector = matmul(contracted(s, gamma), gamma)
   end function contracted_twice

   !> Returns U(γ), J.
   pure real(wp) function cubic_energy(self, gamma)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      cubic_energy = -2.5_wp*dot_product(contracted_twice(self%moments, gamma), gamma)
   end function cubic_energy

   !> Returns ∇U(γ).
   pure function cubic_gradient(self, gamma) result(gradient)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: gradient(3)
      gradient = -7.5_wp*contracted_twice(self%moments, gamma)
   end function cubic_gradient

   !> Returns the second derivatives -15 S_ijk γ_k.
   pure function cubic_hessian(self, gamma) result(hessian)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      real(wp) :: hessian(3, 3)
      hessian = -15*contracted(self%moments, gamma)
   end function cubic_hessian

   !> Returns ∇̄U, with ∇̄U·Δγ = ΔU exactly.
   pure function mean_gradient(self, gamma0, gamma1) result(gradient)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      gradient = mean_slope(self%moments, gamma0, gamma1)
   end function mean_gradient

   !> Returns -(15/2) S_ijk (γ̄_jγ̄_k + Δγ_jΔγ_k/12); shape (3).
   pure function mean_slope(s, gamma0, gamma1) result(gradient)
      real(wp), intent(in) :: s(3, 3, 3), gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      gradient = -7.5_wp*(contracted_twice(s, 0.5_wp*(gamma0 + gamma1)) + contracted_twice(s, gamma1 - gamma0)/12)
   end function mean_slope

   !> Returns ∂∇̄U/∂γ1 = -(15/2) S_ijk (γ̄_k + Δγ_k/6).
   pure function mean_hessian(self, gamma0, gamma1) result(hessian)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: gamma0(3), gamma1(3)
      real(wp) :: hessian(3, 3)
      hessian = -7.5_wp*contracted(self%moments, 0.5_wp*(gamma0 + gamma1) + (gamma1 - gamma0)/6)
   end function mean_hessian

   !> Returns n at a time, (kg m³)^(-1/3) J^(1/3); shape (3).
   pure function direction_to_body(self, t) result(n)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: n(3), r(3), distance
      n = self%direction
      if (.not. self%moves) return
      r = self%path%position(t)
      distance = norm2(r)
      n = -strength_of(self%path%mu, distance)*(r/distance)
   end function direction_to_body

   !> Returns ∂V/∂t = ∇U·R(q)ᵀṅ, ṅ = -(μ/d⁴)^⅓ (v - (7/3) r (r·v)/d²)/d, W.
   pure real(wp) function power_of_motion(self, q, t) result(power)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: q(4), t
      real(wp) :: r(3), v(3), distance, strength
      power = 0.0_wp
      if (.not. self%moves) return
      call find_place(self%path, t, r, distance, v)
      strength = -strength_of(self%path%mu, distance)
      r = r/distance
      v = v/distance
      power = dot_product(self%gradient(rotate_to_body(q, strength*r)), &
                          rotate_to_body(q, strength*(v - (7*dot_product(r, v)/3)*r)))
   end function power_of_motion

   !> Computes the coefficients of n about a time: with x = r/r₀, r₀ = |r| at the start, n = -(μ/r₀⁴)^⅓ x (x·x)^(-7/6).
   pure subroutine series_to_body(self, t, time_unit, n)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      real(wp) :: distance
      if (self%moves) then
         call self%path%pull_series(-7.0_wp/6, t, time_unit, n, distance)
         n = -strength_of(self%path%mu, distance)*n
      else
         n = 0.0_wp
         n(:, 0) = self%direction
      end if
   end subroutine series_to_body

   !> Bounds torque and derivatives in a step with fixed n, by Frobenius' norm of S; a moving n is not bounded.
   pure subroutine cubic_bound(self, map, radius, gamma, slack, bounds)
      class(third_degree_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      real(wp) :: size, length
      bounds%known = .false.
      if (self%moves) return
      size = sqrt(sum(self%moments**2))
      length = vector_length(self%direction)
      bounds = bounds_of_potential(map, radius, length, 7.5_wp*size*length**2, 15*size*length, 15*size)
   end subroutine cubic_bound

   !> Returns `GENERAL_SERIES`.
   pure integer function cubic_series(self)
      class(third_degree_t), intent(in) :: self
      cubic_series = GENERAL_SERIES
   end function cubic_series

   !> Returns 3: the components of ∇U.
   pure integer function cubic_auxiliary(self)
      class(third_degree_t), intent(in) :: self
      cubic_auxiliary = 3
   end function cubic_auxiliary

   !> Computes coefficient k of γ×∇U.
   pure subroutine cubic_torque(self, k, gamma, auxiliary, tau)
      class(third_degree_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k)
      !> ∇U; shape (0:highest_order, 3).
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      real(wp) :: gradient(3)
      integer :: j
      gradient = 0.0_wp
      do j = 0, k
         gradient = gradient + matmul(contracted(self%moments, gamma(:, j)), gamma(:, k - j))
      end do
      auxiliary(k, :) = -7.5_wp*gradient
      tau = 0.0_wp
      do j = 0, k
         tau(1) = tau(1) + (gamma(2, j)*auxiliary(k - j, 3) - gamma(3, j)*auxiliary(k - j, 2))
         tau(2) = tau(2) + (gamma(3, j)*auxiliary(k - j, 1) - gamma(1, j)*auxiliary(k - j, 3))
         tau(3) = tau(3) + (gamma(1, j)*auxiliary(k - j, 2) - gamma(2, j)*auxiliary(k - j, 1))
      end do
   end subroutine cubic_torque

   !> Computes coefficient k of ∂(γ×∇U)/∂γ = [γ]×∇²U - [∇U]×.
   pure subroutine cubic_series_derivative(self, k, gamma, auxiliary, derivative, known)
      class(third_degree_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k)
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: derivative(3, 3)
      logical, intent(out) :: known
      real(wp) :: hessian(3, 3)
      integer :: i, j
      known = .true.
      derivative = -skew(auxiliary(k, 1:3))
      do j = 0, k
         hessian = self%hessian(gamma(:, k - j))
         do i = 1, 3
            derivative(:, i) = derivative(:, i) + cross(gamma(:, j), hessian(:, i))
         end do
      end do
   end subroutine cubic_series_derivative

   !> Returns true if the moments, and energy and power next to the attracting body, can be computed with.
   pure logical function cubic_is_valid(self) result(moderate)
      class(third_degree_t), intent(in) :: self
      real(wp) :: nearest, strength, size
      moderate = all(is_moderate(self%moments))
      if (.not. moderate) return
      nearest = self%path%nearest()
      size = maxval(sum(sum(abs(self%moments), dim=1), dim=1))
      moderate = is_moderate(size) .and. is_moderate(nearest) .and. is_moderate(self%path%mu) .and. nearest > 0.0_wp
      if (.not. moderate) return
      strength = strength_of(self%path%mu, nearest)
      moderate = is_moderate(strength) .and. strength > 0.0_wp
      if (moderate) moderate = is_moderate(strength**2)
      if (moderate) moderate = is_moderate(strength**2*strength)
      if (moderate) moderate = is_moderate(7.5_wp*size*strength**2*strength) .and. is_moderate(self%path%fastest_turn())
      if (moderate) moderate = is_moderate(7.5_wp*size*strength**2*strength*self%path%fastest_turn())
   end function cubic_is_valid

   !> Returns the parameters: T, in the order of the key, and the orbit.
   pure function cubic_parameters(self) result(list)
      class(third_degree_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('third_moments', 10), parameter_t('orbit', n_elements)]
   end function cubic_parameters

   pure logical function cubic_follows(self, path)
      class(third_degree_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      cubic_follows = self%path%equals(path)
   end function cubic_follows

   !> Returns δn = ⅓(δμ/μ)n - (μ/d⁴)^⅓ (δr - (7/3) r (r·δr)/d²)/d; in the LVLH frame of a circular orbit n stays along
   !> z.
   pure function change_by_orbit(self, change, t) result(n)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t
      real(wp) :: n(3), r(3), moved(3), distance
      r = self%path%position(t)
      distance = norm2(r)
      r = r/distance
      moved = position_change(self%path, change(11:), t)/distance
      if (self%moves) then
         n = -strength_of(self%path%mu, distance)*(moved - (7*dot_product(r, moved)/3 - &
                                                            change(17)/(3*self%path%mu))*r)
      else
         n = (change(17)/(3*self%path%mu) - 4*dot_product(r, moved)/3)*self%direction
      end if
   end function change_by_orbit

   !> Computes the coefficients of δn: with x = r/r₀, δx = δr/r₀ and strength -(μ/r₀⁴)^⅓ those of
   !> (⅓(δμ/μ)x + δx)(x·x)^(-7/6) - (7/3)x (x·δx)(x·x)^(-13/6).
   pure subroutine change_series_by_orbit(self, change, t, time_unit, n, known)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      logical, intent(out) :: known
      known = .true.
      n = 0.0_wp
      if (.not. any(abs(change(11:)) > 0.0_wp)) return
      if (self%moves) then
         call pull_change_series(self%path, change(11:), 1.0_wp/3, -7.0_wp/6, t, time_unit, n)
         n = -strength_of(self%path%mu, self%path%radius(t))*n
      else
         n(:, 0) = self%direction_change(change, t)
      end if
   end subroutine change_series_by_orbit

   !> Returns the change of ∇̄U, which is linear in S.
   pure function cubic_gradient_change(self, change, gamma0, gamma1) result(gradient)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma0(3), gamma1(3)
      real(wp) :: gradient(3)
      gradient = mean_slope(without_traces(change(:10)), gamma0, gamma1)
   end function cubic_gradient_change

   pure real(wp) function cubic_energy_change(self, change, gamma)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma(3)
      cubic_energy_change = -2.5_wp*dot_product(contracted_twice(without_traces(change(:10)), gamma), gamma)
   end function cubic_energy_change

   !> Computes coefficient k of γ×δ∇U.
   pure subroutine cubic_series_change(self, change, k, gamma, auxiliary, tau, known)
      class(third_degree_t), intent(in) :: self
      real(wp), intent(in) :: change(:)
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k), auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      logical, intent(out) :: known
      real(wp) :: s(3, 3, 3), gradient(3, 0:k)
      integer :: i, j
      known = .true.
      s = without_traces(change(:10))
      tau = 0.0_wp
      do i = 0, k
         gradient(:, i) = 0.0_wp
         do j = 0, i
            gradient(:, i) = gradient(:, i) - 7.5_wp*matmul(contracted(s, gamma(:, j)), gamma(:, i - j))
         end do
         tau = tau + cross(gamma(:, k - i), gradient(:, i))
      end do
   end subroutine cubic_series_change

   !> Leaves out every second line of the table of the orbit.
   subroutine thin_path(self)
      class(third_degree_t), intent(inout) :: self
      call self%path%thin_table()
   end subroutine thin_path

end module nutate_third_degree
