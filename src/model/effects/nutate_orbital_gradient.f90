!> The gradient of a central gravity field over a body on a Kepler orbit, in inertial axes: the direction to the centre
!> moves. V = ½·3 γᵀJγ, γ = R(q)ᵀn(t), n = √μ r/|r|^(5/2).
module nutate_orbital_gradient
   use nutate_body, only: body_t
   use nutate_effect, only: potential_t
   use nutate_gravity_gradient, only: gravity_gradient_t
   use nutate_kepler_orbit, only: find_place, kepler_orbit_t, position_change
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_orbit_change_series, only: pull_change_series
   use nutate_quaternion, only: rotate_to_body
   implicit none
   private

   public :: orbital_gradient_t

   !> U(γ) = ½ γᵀAγ + ½·3J_m|γ|², A = 3(J - J_m I): the effect's V, whose isotropic part exerts no torque but changes
   !> with the distance.
   type, extends(gravity_gradient_t) :: orbital_gradient_t
      !> 3J_m, kg m².
      real(wp) :: isotropic = 0.0_wp
   contains
      procedure :: energy => moving_energy
      procedure :: direction_at => direction_of_orbit
      procedure :: power => power_of_motion
      procedure :: direction_series => series_along_orbit
      procedure :: see_from_lvlh => gradient_from_lvlh
      procedure :: is_valid => moving_is_valid
      procedure :: direction_change => change_by_orbit
      procedure :: direction_change_series => change_series_by_orbit
      procedure :: energy_change => moving_energy_change
   end type orbital_gradient_t

   !> Makes the gradient on a body along an orbit.
   interface orbital_gradient_t
      module procedure new_orbital_gradient
   end interface orbital_gradient_t

contains

   !> Makes the gravity gradient on a body along an orbit.
   pure function new_orbital_gradient(body, path) result(gradient)
      !> Body, of which the inertia about the reference point is used.
      type(body_t), intent(in) :: body
      type(kepler_orbit_t), intent(in) :: path
      type(orbital_gradient_t) :: gradient
      gradient%gravity_gradient_t = gravity_gradient_t(body, [0.0_wp, 0.0_wp, 1.0_wp], 1.0_wp)
      gradient%isotropic = 2*gradient%offset
      gradient%offset = 0.0_wp
      gradient%on_orbit = .true.
      gradient%path = path
      gradient%moves = .true.
      gradient%pace = path%fastest_turn()
      gradient%direction = gradient%direction_at(0.0_wp)
   end function new_orbital_gradient

   !> Makes the gravity gradient as seen from the LVLH frame of a circular orbit: along z, of the strength n².
   subroutine gradient_from_lvlh(self, seen)
      class(orbital_gradient_t), intent(in) :: self
      class(potential_t), allocatable, intent(out) :: seen
      type(gravity_gradient_t) :: constant
      constant = self%gravity_gradient_t
      constant%moves = .false.
      constant%pace = 0.0_wp
      constant%direction = [0.0_wp, 0.0_wp, 1.0_wp]
      constant%strength = self%path%mean_motion()**2
      constant%stiffness = 3*constant%strength*constant%deviation
      constant%offset = 1.5_wp*constant%strength*constant%middle
      allocate (seen, source=constant)
   end subroutine gradient_from_lvlh

   !> Returns U(γ), J.
   pure real(wp) function moving_energy(self, gamma)
      class(orbital_gradient_t), intent(in) :: self
      real(wp), intent(in) :: gamma(3)
      moving_energy = 0.5_wp*(dot_product(gamma, self%gradient(gamma)) + self%isotropic*dot_product(gamma, gamma))
   end function moving_energy

   !> Returns n at a time, space axes, 1/s; shape (3).
   pure function direction_of_orbit(self, t) result(n)
      class(orbital_gradient_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: n(3), r(3)
      r = self%path%position(t)
      n = strength_at(self, r)*r
   end function direction_of_orbit

   !> Returns √μ/|r|^(5/2), 1/(m s).
   pure real(wp) function strength_at(self, r) result(strength)
      class(orbital_gradient_t), intent(in) :: self
      !> m; shape (3).
      real(wp), intent(in) :: r(3)
      real(wp) :: distance
      distance = sqrt(dot_product(r, r))
      strength = sqrt(self%path%mu)/(distance*distance*sqrt(distance))
   end function strength_at

   !> Returns ∂V/∂t = (Aγ + 3J_mγ)·R(q)ᵀṅ, W, with ṅ = √μ (v - (5/2) r (r·v)/|r|²)/|r|^(5/2).
   pure real(wp) function power_of_motion(self, q, t) result(power)
      class(orbital_gradient_t), intent(in) :: self
      real(wp), intent(in) :: q(4), t
      real(wp) :: gamma(3), rate(3), r(3), v(3), distance, strength
      call find_place(self%path, t, r, distance, v)
      strength = strength_at(self, r)
      rate = strength*(v - (2.5_wp*dot_product(r, v)/dot_product(r, r))*r)
      gamma = rotate_to_body(q, strength*r)
      power = dot_product(self%gradient(gamma) + self%isotropic*gamma, rotate_to_body(q, rate))
   end function power_of_motion

   !> Computes the coefficients of the power series of n = √(μ/r₀³) x (x·x)^(-5/4), with x = r/r₀, r₀ = |r| at the
   !> start.
   pure subroutine series_along_orbit(self, t, time_unit, n)
      class(orbital_gradient_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      real(wp) :: distance
      call self%path%pull_series(-1.25_wp, t, time_unit, n, distance)
      n = sqrt(self%path%mu/distance/distance/distance)*n
   end subroutine series_along_orbit

   !> Returns true if the parameters, and the energy at periapsis, can be computed with.
   pure logical function moving_is_valid(self)
      class(orbital_gradient_t), intent(in) :: self
      real(wp) :: nearest, strength
      associate (path => self%path)
         nearest = path%nearest()
         moving_is_valid = all(is_moderate([self%stiffness, self%isotropic])) .and. is_moderate(nearest) .and. &
                              nearest > 0.0_wp
         if (.not. moving_is_valid) return
         strength = sqrt(path%mu/nearest)/nearest
         moving_is_valid = is_moderate(strength)
         if (moving_is_valid) moving_is_valid = is_moderate(strength**2) .and. is_moderate(strength**2* &
            (maxval(sum(abs(self%stiffness), dim=1)) + abs(self%isotropic)))
      end associate
   end function moving_is_valid

   !> Returns δn = ½(δμ/μ)n + √μ (δr - (5/2) r (r·δr)/|r|²)/|r|^(5/2).
   pure function change_by_orbit(self, change, t) result(n)
      class(orbital_gradient_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t
      real(wp) :: n(3), r(3), moved(3), distance
      r = self%path%position(t)
      distance = norm2(r)
      r = r/distance
      moved = position_change(self%path, change(14:), t)/distance
      n = (sqrt(self%path%mu/distance)/distance)*(moved - (2.5_wp*dot_product(r, moved) - &
                                                           0.5_wp*change(20)/self%path%mu)*r)
   end function change_by_orbit

   !> Computes the coefficients of δn: with x = r/r₀, δx = δr/r₀ and strength √(μ/r₀³) those of
   !> (½(δμ/μ)x + δx)(x·x)^(-5/4) - (5/2)x (x·δx)(x·x)^(-9/4).
   pure subroutine change_series_by_orbit(self, change, t, time_unit, n, known)
      class(orbital_gradient_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      logical, intent(out) :: known
      known = .true.
      n = 0.0_wp
      if (.not. any(abs(change(14:)) > 0.0_wp)) return
      call pull_change_series(self%path, change(14:), 0.5_wp, -1.25_wp, t, time_unit, n)
      n = sqrt(self%path%mu/self%path%radius(t)/self%path%radius(t)/self%path%radius(t))*n
   end subroutine change_series_by_orbit

   !> Returns the change of U, J: the strength is a factor of the effect, and the isotropic part is proportional to
   !> |γ|².
   pure real(wp) function moving_energy_change(self, change, gamma) result(energy)
      class(orbital_gradient_t), intent(in) :: self
      real(wp), intent(in) :: change(:), gamma(3)
      real(wp) :: whole
      whole = self%gravity_gradient_t%energy_change(change, gamma) - self%gravity_gradient_t%energy_change( &
              change, [0.0_wp, 0.0_wp, 0.0_wp])
      energy = whole + dot_product(gamma, gamma)*self%gravity_gradient_t%energy_change(change, [0.0_wp, 0.0_wp, 0.0_wp])
   end function moving_energy_change

end module nutate_orbital_gradient
