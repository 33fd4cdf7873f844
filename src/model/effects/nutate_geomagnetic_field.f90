!> The magnetic field of the Earth along an orbit, to first order: a dipole in the centre of the Earth, tilted against
!> the axis about which it rotates with the Earth.
!>
!>     B = (a/r)³ (3 (G·r̂) r̂ - G),   a = 6371.2 km,   G = (g₁₁, h₁₁, g₁₀) rotated by θ = θ₀ + ω_E t about the north.
!>
!> Inertial axes: x to the equinox, z north. In the axes of a circular orbit, r̂ is fixed and G rotates.
module nutate_geomagnetic_field
   use nutate_effect_base, only: parameter_t
   use nutate_kepler_orbit, only: n_elements, axes_change, position_change, find_place
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_moving_direction, only: moving_direction_t
   use nutate_orbit_change_series, only: axes_change_series, position_change_series
   use nutate_power_series, only: inverses, power_term, product_term
   use nutate_quaternion, only: cross, rotate_to_body
   use nutate_rotating_frame, only: earth_rate
   implicit none
   private

   public :: geomagnetic_field_t, reference_coefficients
   public :: change_by_axis, change_by_orbit, rate_change_by_orbit, with_axis

   !> g₁₁, h₁₁, g₁₀ of the International Geomagnetic Reference Field, 14th generation, for 2025, T.
   real(wp), parameter :: reference_coefficients(3) = [-1410.3e-9_wp, 4545.5e-9_wp, -29350.0e-9_wp]

   !> a, m.
   real(wp), parameter :: reference_radius = 6371.2e3_wp

   !> Unit vector of the angular velocity of the Earth, inertial axes and axes of the Earth.
   real(wp), parameter :: north(3) = [0.0_wp, 0.0_wp, 1.0_wp]

   !> Magnetic field of the Earth along an orbit: a dipole that rotates with the Earth.
   type, extends(moving_direction_t) :: geomagnetic_field_t
      !> G in axes of the Earth: x to the meridian of Greenwich, z north, T; shape (3).
      real(wp) :: coefficients(3) = reference_coefficients
      !> θ₀: angle of Greenwich from the equinox at t = 0, rad.
      real(wp) :: epoch_angle = 0.0_wp
      !> True if the field is given in the LVLH frame of a circular orbit; else in inertial axes.
      logical :: in_orbit = .false.
   contains
      procedure :: at => field_at
      procedure :: rate_at
      !> Computes B and Ḃ together.
      procedure :: find
      procedure :: parameters => parameters_of_field
      procedure :: change_at => change_of_field
      procedure :: series
      procedure :: change_series
      procedure :: pace
      procedure :: greatest
      procedure :: is_valid => field_is_valid
   end type geomagnetic_field_t

contains

   !> Returns G at a time, inertial axes, T; shape (3).
   pure function axis_at(self, t) result(g)
      class(geomagnetic_field_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: g(3), angle
      angle = self%epoch_angle + earth_rate*t
      associate (c => self%coefficients)
         g = [c(1)*cos(angle) - c(2)*sin(angle), c(1)*sin(angle) + c(2)*cos(angle), c(3)]
      end associate
   end function axis_at

   !> Returns B at a time, in the space axes of the scene, T; shape (3).
   pure function field_at(self, t) result(b)
      class(geomagnetic_field_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: b(3)
      call self%find(t, b)
   end function field_at

   !> Returns Ḃ at a time, in the space axes of the scene, T/s; shape (3).
   pure function rate_at(self, t) result(rate)
      class(geomagnetic_field_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: rate(3), b(3)
      call self%find(t, b, rate)
   end function rate_at

   !> Computes B, and Ḃ if present, at a time, in the space axes of the scene.
   pure subroutine find(self, t, b, rate)
      class(geomagnetic_field_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      !> B, T; shape (3).
      real(wp), intent(out) :: b(3)
      !> Ḃ, T/s; shape (3).
      real(wp), intent(out), optional :: rate(3)
      real(wp) :: g(3), g_rate(3), r(3), r_rate(3), q(4), distance, climb, strength
      g = axis_at(self, t)
      g_rate = earth_rate*cross(north, g)
      if (self%in_orbit) then
         distance = self%path%radius(t)
         q = self%path%axes(t)
         g = rotate_to_body(q, g)
         b = below(g)
         if (present(rate)) rate = below(rotate_to_body(q, g_rate) - cross(turn_of(self), g))
      else
         if (present(rate)) then
            call find_place(self%path, t, r, distance, r_rate)
         else
            call find_place(self%path, t, r, distance)
         end if
         r = r/distance
         b = 3*dot_product(g, r)*r - g
         if (present(rate)) then
            r_rate = r_rate/distance
            climb = dot_product(r, r_rate)
            r_rate = r_rate - climb*r
            rate = 3*(dot_product(g_rate, r) + dot_product(g, r_rate))*r + 3*dot_product(g, r)*r_rate - g_rate &
                   - 3*climb*b
         end if
      end if
      strength = (reference_radius/distance)**3
      b = strength*b
      if (present(rate)) rate = strength*rate
   end subroutine find

   !> Returns 3 (G·r̂) r̂ - G with r̂ = (0, 0, -1), as in the LVLH frame; shape (3).
   pure function below(g) result(b)
      real(wp), intent(in) :: g(3)
      real(wp) :: b(3)
      b = [-g(1), -g(2), 2*g(3)]
   end function below

   !> Returns δB at a time, in the space axes of the scene, T; shape (3). B is linear in G, and θ₀ rotates G about the
   !> north.
   pure function change_by_axis(self, coefficients, angle, t) result(b)
      type(geomagnetic_field_t), intent(in) :: self
      !> δG, T, shape (3); δθ₀, rad; time, s.
      real(wp), intent(in) :: coefficients(3), angle, t
      real(wp) :: b(3)
      type(geomagnetic_field_t) :: other
      other = with_axis(self, coefficients, angle)
      b = other%at(t)
   end function change_by_axis

   !> Returns a field whose B is δB by a change of G and θ₀.
   pure type(geomagnetic_field_t) function with_axis(self, coefficients, angle) result(other)
      type(geomagnetic_field_t), intent(in) :: self
      !> δG, T, shape (3); δθ₀, rad.
      real(wp), intent(in) :: coefficients(3), angle
      other = self
      other%coefficients = coefficients + angle*[-self%coefficients(2), self%coefficients(1), 0.0_wp]
   end function with_axis

   !> Returns δB at a time, in the space axes of the scene, T; shape (3).
   pure function change_by_orbit(self, change, t) result(b)
      type(geomagnetic_field_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: b(3)
      real(wp) :: g(3), r(3), moved(3), distance, climb
      g = axis_at(self, t)
      distance = self%path%radius(t)
      r = self%path%position(t)/distance
      moved = position_change(self%path, change, t)/distance
      climb = dot_product(r, moved)
      if (self%in_orbit) then
         b = below(rotate_to_body(self%path%axes(t), cross(g, axes_change(self%path, change, t))))
      else
         moved = moved - climb*r
         b = 3*(dot_product(g, moved)*r + dot_product(g, r)*moved)
      end if
      b = (reference_radius/distance)**3*b - (3*climb)*self%at(t)
   end function change_by_orbit

   !> Returns δḂ at a time, in the space axes of the scene, T/s; shape (3). Zero for a table.
   pure function rate_change_by_orbit(self, change, t) result(rate)
      type(geomagnetic_field_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: rate(3), series(3, 0:1)
      rate = 0.0_wp
      if (allocated(self%path%track)) return
      call expand_change(self, change, t, 1/self%pace(), series)
      rate = self%pace()*series(:, 1)
   end function rate_change_by_orbit

   !> Returns the rate of the axes of a circular orbit, in these axes, rad/s; shape (3).
   pure function turn_of(self) result(rate)
      class(geomagnetic_field_t), intent(in) :: self
      real(wp) :: rate(3)
      rate = [0.0_wp, -self%path%mean_motion(), 0.0_wp]
   end function turn_of

   !> Computes the coefficients of the power series of B about a time, space axes.
   pure subroutine series(self, t, time_unit, v)
      class(geomagnetic_field_t), intent(in) :: self
      !> Time t₀ and time unit of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> T; shape (3, 0:order).
      real(wp), intent(out) :: v(:, 0:)
      if (self%in_orbit) then
         call expand_in_orbit(self, t, time_unit, v)
      else
         call expand_in_space(self, t, time_unit, v)
      end if
   end subroutine series

   !> Computes the series of G in inertial axes, where it rotates with the Earth.
   pure subroutine expand_axis(self, t, time_unit, g)
      class(geomagnetic_field_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      !> T; shape (0:order, 3).
      real(wp), intent(out) :: g(0:, :)
      integer :: k
      g(0, :) = axis_at(self, t)
      do k = 1, ubound(g, 1)
         g(k, :) = (time_unit*earth_rate*inverses(k))*cross(north, g(k - 1, :))
      end do
   end subroutine expand_axis

   !> Computes the series of B in inertial axes: with x = r/r₀, B = (a/r₀)³ (3 (G·x) x (x·x)^(-5/2) - G (x·x)^(-3/2)),
   !> Ġ = ω_E×G.
   pure subroutine expand_in_space(self, t, time_unit, b)
      class(geomagnetic_field_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(out) :: b(:, 0:)
      real(wp), dimension(0:ubound(b, 2)) :: square, w, u, along
      real(wp), dimension(0:ubound(b, 2), 3) :: x, g
      real(wp) :: scale
      integer :: i, k
      call self%path%position_series(t, time_unit, x, square, w)
      call expand_axis(self, t, time_unit, g)
      scale = (reference_radius/self%path%radius(t))**3
      do k = 0, ubound(b, 2)
         if (k == 0) u(0) = w(0)/square(0)
         if (k > 0) u(k) = power_term(k, -2.5_wp, square(0:k), u(0:k - 1))
         along(k) = product_term(k, g(0:k, 1), x(0:k, 1)) + product_term(k, g(0:k, 2), x(0:k, 2)) &
                    + product_term(k, g(0:k, 3), x(0:k, 3))
      end do
      do k = 0, ubound(b, 2)
         square(k) = 3*product_term(k, along(0:k), u(0:k))
      end do
      do k = 0, ubound(b, 2)
         do i = 1, 3
            b(i, k) = scale*(product_term(k, square(0:k), x(0:k, i)) - product_term(k, g(0:k, i), w(0:k)))
         end do
      end do
   end subroutine expand_in_space

   !> Computes the series of B in the LVLH frame: r̂ = (0, 0, -1), B = (a/r)³ (-G₁, -G₂, 2G₃).
   pure subroutine expand_in_orbit(self, t, time_unit, b)
      class(geomagnetic_field_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(out) :: b(:, 0:)
      real(wp) :: g(3, 0:ubound(b, 2)), scale
      integer :: k
      call expand_axis_in_orbit(self, t, time_unit, g)
      scale = (reference_radius/self%path%radius(t))**3
      do k = 0, ubound(b, 2)
         b(:, k) = scale*below(g(:, k))
      end do
   end subroutine expand_in_orbit

   !> Computes the series of G in the LVLH frame: the north e rotates with ė = e×ν, G with Ġ = (ω_E e - ν)×G, ν the rate
   !> of the axes.
   pure subroutine expand_axis_in_orbit(self, t, time_unit, g)
      class(geomagnetic_field_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      !> T; shape (3, 0:order).
      real(wp), intent(out) :: g(:, 0:)
      real(wp) :: pole(3, 0:ubound(g, 2)), turn(3), rate(3)
      integer :: j, k
      turn = time_unit*turn_of(self)
      pole(:, 0) = rotate_to_body(self%path%axes(t), north)
      g(:, 0) = rotate_to_body(self%path%axes(t), axis_at(self, t))
      do k = 0, ubound(g, 2) - 1
         pole(:, k + 1) = inverses(k + 1)*cross(pole(:, k), turn)
         rate = -cross(turn, g(:, k))
         do j = 0, k
            rate = rate + (time_unit*earth_rate)*cross(pole(:, j), g(:, k - j))
         end do
         g(:, k + 1) = inverses(k + 1)*rate
      end do
   end subroutine expand_axis_in_orbit

   !> Returns the parameters: G, θ₀ and the elements of the orbit.
   pure function parameters_of_field(self) result(list)
      class(geomagnetic_field_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('coefficients', 3), parameter_t('epoch_angle'), parameter_t('orbit', n_elements)]
   end function parameters_of_field

   pure function change_of_field(self, change, t) result(v)
      class(geomagnetic_field_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t
      real(wp) :: v(3)
      v = change_by_axis(self, change(1:3), change(4), t) + change_by_orbit(self, change(5:), t)
   end function change_of_field

   !> Computes the coefficients of the power series of δB about a time.
   pure subroutine change_series(self, change, t, time_unit, v)
      class(geomagnetic_field_t), intent(in) :: self
      !> Change of G, θ₀ and the elements, shape (4 + n_elements); time, s.
      real(wp), intent(in) :: change(:), t, time_unit
      !> T; shape (3, 0:order).
      real(wp), intent(out) :: v(:, 0:)
      type(geomagnetic_field_t) :: other
      real(wp) :: by_orbit(3, 0:ubound(v, 2))
      other = with_axis(self, change(1:3), change(4))
      call other%series(t, time_unit, v)
      if (.not. any(abs(change(5:)) > 0.0_wp)) return
      call expand_change(self, change(5:), t, time_unit, by_orbit)
      v = v + by_orbit
   end subroutine change_series

   !> Computes the coefficients of δB by a change of the elements of the orbit, T; shape (3, 0:order).
   pure subroutine expand_change(self, change, t, time_unit, b)
      class(geomagnetic_field_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: b(:, 0:)
      if (self%in_orbit) then
         call change_in_orbit(self, change, t, time_unit, b)
      else
         call change_in_space(self, change, t, time_unit, b)
      end if
   end subroutine expand_change

   !> Computes the series of δB in inertial axes: with δx = δr/r₀, c = (x·x)^(-5/2), the change of 3 ((G·x) c) x - G
   !> (x·x)^(-3/2), in which c changes by -5 (x·δx)(x·x)^(-7/2) and the last power by -3 (x·δx) c.
   pure subroutine change_in_space(self, change, t, time_unit, b)
      class(geomagnetic_field_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: b(:, 0:)
      real(wp), dimension(0:ubound(b, 2)) :: square, along, u, steep, factor, moved_factor, moved_w, gx, gm, moved_u
      real(wp), dimension(0:ubound(b, 2), 3) :: x, moved, g
      real(wp) :: scale
      integer :: i, k
      call position_change_series(self%path, change, t, time_unit, x, moved, square, along)
      call expand_axis(self, t, time_unit, g)
      scale = (reference_radius/self%path%radius(t))**3
      do k = 0, ubound(b, 2)
         if (k == 0) then
            u(0) = 1/(square(0)**2*sqrt(square(0)))
            steep(0) = u(0)/square(0)
         else
            u(k) = power_term(k, -2.5_wp, square(0:k), u(0:k - 1))
            steep(k) = power_term(k, -3.5_wp, square(0:k), steep(0:k - 1))
         end if
         moved_u(k) = -5*product_term(k, along(0:k), steep(0:k))
         moved_w(k) = -3*product_term(k, along(0:k), u(0:k))
         gx(k) = 0.0_wp
         gm(k) = 0.0_wp
         do i = 1, 3
            gx(k) = gx(k) + product_term(k, g(0:k, i), x(0:k, i))
            gm(k) = gm(k) + product_term(k, g(0:k, i), moved(0:k, i))
         end do
         factor(k) = 3*product_term(k, gx(0:k), u(0:k))
         moved_factor(k) = 3*(product_term(k, gm(0:k), u(0:k)) + product_term(k, gx(0:k), moved_u(0:k)))
         do i = 1, 3
            b(i, k) = scale*(product_term(k, moved_factor(0:k), x(0:k, i)) &
                             + product_term(k, factor(0:k), moved(0:k, i)) - product_term(k, g(0:k, i), moved_w(0:k)))
         end do
      end do
   end subroutine change_in_space

   !> Computes the series of δB in the LVLH frame: G changes by G×δθ, δθ the rotation of the frame, and B by the
   !> distance, which is constant.
   pure subroutine change_in_orbit(self, change, t, time_unit, b)
      class(geomagnetic_field_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: b(:, 0:)
      real(wp), dimension(3, 0:ubound(b, 2)) :: g, turn
      real(wp) :: moved(3), scale, climb
      integer :: j, k
      call expand_axis_in_orbit(self, t, time_unit, g)
      call axes_change_series(self%path, change, t, time_unit, .true., turn)
      scale = (reference_radius/self%path%radius(t))**3
      climb = dot_product(self%path%position(t)/self%path%radius(t), position_change(self%path, change, t))/ &
              self%path%radius(t)
      do k = 0, ubound(b, 2)
         moved = -3*climb*g(:, k)
         do j = 0, k
            moved = moved + cross(g(:, j), turn(:, k - j))
         end do
         b(:, k) = scale*below(moved)
      end do
   end subroutine change_in_orbit

   !> Returns a bound of the rate at which the direction of B changes, 1/s.
   pure real(wp) function pace(self)
      class(geomagnetic_field_t), intent(in) :: self
      pace = self%path%fastest_turn() + earth_rate
   end function pace

   !> Returns a bound of |B|, T: its value above the pole of the dipole at periapsis.
   pure real(wp) function greatest(self)
      class(geomagnetic_field_t), intent(in) :: self
      greatest = 2*norm2(self%coefficients)*(reference_radius/self%path%nearest())**3
   end function greatest

   !> Returns true if the field, and its rate at periapsis, are of a size that can be computed with.
   pure logical function field_is_valid(self) result(valid)
      class(geomagnetic_field_t), intent(in) :: self
      valid = all(is_moderate(self%coefficients)) .and. is_moderate(self%epoch_angle) .and. &
                 is_moderate(self%path%nearest())
      if (valid) valid = self%path%nearest() >= 1e-30_wp*reference_radius .and. is_moderate(norm2(self%coefficients))
      if (valid) valid = is_moderate(self%greatest()) .and. is_moderate(self%pace())
      if (valid) valid = is_moderate(self%greatest()*self%pace())
   end function field_is_valid

end module nutate_geomagnetic_field
