!> Power series in time of what a change of the elements of an orbit changes: position, pull, and LVLH frame.
module nutate_orbit_change_series
   use nutate_kepler_orbit, only: kepler_orbit_t, normal_of, plane_change, position_change, velocity_change
   use nutate_kinds, only: wp
   use nutate_power_series, only: inverses, power_term, product_term
   use nutate_quaternion, only: cross, rotate_to_body
   implicit none
   private

   public :: axes_change_series, position_change_series, pull_change_series

contains

   !> Computes the coefficients of the power series of x = r/r₀, as `position_series` does, and of δx, δr over the same
   !> r₀, from ẍ = -(μ/r₀³) x w differentiated: δẍ = -(μ/r₀³)(δx w + x δw + (δμ/μ) x w), δw = -3 (x·δx)(x·x)^(-5/2).
   pure subroutine position_change_series(self, change, t, time_unit, x, moved, square, along)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time and its unit, s.
      real(wp), intent(in) :: change(:), t, time_unit
      !> Inertial axes; shape (0:order, 3).
      real(wp), intent(out) :: x(0:, :), moved(0:, :)
      !> x·x and x·δx; shape (0:order).
      real(wp), intent(out) :: square(0:), along(0:)
      real(wp), dimension(0:ubound(x, 1)) :: w, steep, moved_w
      real(wp) :: start, pull
      integer :: i, k
      call self%position_series(t, time_unit, x, square, w)
      start = self%radius(t)
      pull = self%mu/start/start/start
      moved(0, :) = position_change(self, change, t)/start
      if (ubound(x, 1) > 0) moved(1, :) = (time_unit/start)*velocity_change(self, change, t)
      do k = 0, ubound(x, 1)
         along(k) = product_term(k, x(0:k, 1), moved(0:k, 1)) + product_term(k, x(0:k, 2), moved(0:k, 2)) &
                    + product_term(k, x(0:k, 3), moved(0:k, 3))
         if (k == 0) then
            steep(0) = w(0)/square(0)
         else
            steep(k) = power_term(k, -2.5_wp, square(0:k), steep(0:k - 1))
         end if
         moved_w(k) = (change(7)/self%mu)*w(k) - 3*product_term(k, along(0:k), steep(0:k))
         if (k + 2 > ubound(x, 1)) cycle
         do i = 1, 3
            moved(k + 2, i) = -(pull*time_unit*time_unit)*inverses(k + 1)*inverses(k + 2)* &
                              (product_term(k, moved(0:k, i), w(0:k)) + product_term(k, x(0:k, i), moved_w(0:k)))
         end do
      end do
   end subroutine position_change_series

   !> Computes the coefficients of the power series of the change of μ^a x (x·x)^b over μ^a:
   !> (a(δμ/μ)x + δx)(x·x)^b + 2b x (x·δx)(x·x)^(b-1).
   pure subroutine pull_change_series(self, change, of_mu, exponent, t, time_unit, n)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); exponents a and b; time and its unit, s.
      real(wp), intent(in) :: change(:), of_mu, exponent, t, time_unit
      !> Inertial axes; shape (3, 0:order).
      real(wp), intent(out) :: n(:, 0:)
      real(wp), dimension(0:ubound(n, 2), 3) :: x, moved
      real(wp), dimension(0:ubound(n, 2)) :: square, along, u, steep, moved_u
      integer :: i, k
      call position_change_series(self, change, t, time_unit, x, moved, square, along)
      do k = 0, ubound(n, 2)
         if (k == 0) then
            u(0) = square(0)**exponent
            steep(0) = u(0)/square(0)
         else
            u(k) = power_term(k, exponent, square(0:k), u(0:k - 1))
            steep(k) = power_term(k, exponent - 1, square(0:k), steep(0:k - 1))
         end if
         moved_u(k) = (of_mu*change(7)/self%mu)*u(k) + 2*exponent*product_term(k, along(0:k), steep(0:k))
         do i = 1, 3
            n(i, k) = product_term(k, moved(0:k, i), u(0:k)) + product_term(k, x(0:k, i), moved_u(0:k))
         end do
      end do
   end subroutine pull_change_series

   !> Computes the coefficients of the power series of the rotation of the LVLH frame, a vector, rad: the rotation P of
   !> the plane, and about the normal n the rotation in the plane, n·(x×δx)/(x·x) - P·n.
   pure subroutine axes_change_series(self, change, t, time_unit, in_orbit, turn)
      type(kepler_orbit_t), intent(in) :: self
      !> Change of the elements, shape (n_elements); time and its unit, s.
      real(wp), intent(in) :: change(:), t, time_unit
      !> The rotation is seen from the LVLH frame of a circular orbit; else from inertial axes.
      logical, intent(in) :: in_orbit
      !> Shape (3, 0:order).
      real(wp), intent(out) :: turn(:, 0:)
      real(wp), dimension(0:ubound(turn, 2), 3) :: x, moved
      real(wp), dimension(0:ubound(turn, 2)) :: square, along, inverse, across
      real(wp) :: normal(3), axis(3), tilt(3)
      integer :: j, k
      call position_change_series(self, change, t, time_unit, x, moved, square, along)
      normal = normal_of(self)
      do k = 0, ubound(turn, 2)
         if (k == 0) then
            inverse(0) = 1/square(0)
         else
            inverse(k) = power_term(k, -1.0_wp, square(0:k), inverse(0:k - 1))
         end if
         across(k) = 0.0_wp
         do j = 0, k
            across(k) = across(k) + dot_product(normal, cross(x(j, :), moved(k - j, :)))
         end do
      end do
      tilt = plane_change(self, change)
      tilt = tilt - dot_product(tilt, normal)*normal
      axis = normal
      if (in_orbit) then
         axis = [0.0_wp, -1.0_wp, 0.0_wp]
         tilt = rotate_to_body(self%axes(t), tilt)
      end if
      do k = 0, ubound(turn, 2)
         turn(:, k) = product_term(k, across(0:k), inverse(0:k))*axis
         if (k == 0 .or. in_orbit) turn(:, k) = turn(:, k) + tilt
         ! A constant inertial vector rotates backwards in the frame.
         tilt = (time_unit*self%mean_motion()*inverses(k + 1))*cross(tilt, axis)
      end do
   end subroutine axes_change_series

end module nutate_orbit_change_series
