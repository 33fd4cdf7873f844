!> A vector that is fixed in the LVLH frame of an orbit, in inertial axes, or vice versa.
module nutate_lvlh_vector
   use nutate_effect_base, only: parameter_t
   use nutate_kepler_orbit, only: n_elements, axes_change
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_moving_direction, only: moving_direction_t
   use nutate_orbit_change_series, only: axes_change_series
   use nutate_power_series, only: inverses, power_term
   use nutate_quaternion, only: cross, rotate_to_body, rotate_to_space
   implicit none
   private

   public :: lvlh_vector_t

   !> The normal of the orbit in the LVLH frame.
   real(wp), parameter :: normal(3) = [0.0_wp, -1.0_wp, 0.0_wp]

   !> A vector v, and the orbit.
   type, extends(moving_direction_t) :: lvlh_vector_t
      !> v in the axes in which it is fixed; shape (3).
      real(wp) :: vector(3) = 0.0_wp
      !> True if the vector is fixed in inertial axes and given in the LVLH frame of a circular orbit; else vice versa.
      logical :: from_orbit = .false.
   contains
      procedure :: at => vector_at
      procedure :: rate_at
      procedure :: series
      procedure :: parameters => parameters_of_vector
      procedure :: change_at
      procedure :: change_series
      procedure :: greatest => length
      procedure :: pace => rate_of_turn
      procedure :: is_valid => vector_is_valid
   end type lvlh_vector_t

contains

   !> Returns the parameters: the vector in the axes in which it is fixed, and the elements of the orbit.
   pure function parameters_of_vector(self) result(list)
      class(lvlh_vector_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('force', 3), parameter_t('orbit', n_elements)]
   end function parameters_of_vector

   pure real(wp) function length(self)
      class(lvlh_vector_t), intent(in) :: self
      length = norm2(self%vector)
   end function length

   pure real(wp) function rate_of_turn(self)
      class(lvlh_vector_t), intent(in) :: self
      rate_of_turn = self%path%fastest_turn()
   end function rate_of_turn

   !> Returns v at a time, in the space axes of the scene; shape (3).
   pure function vector_at(self, t) result(v)
      class(lvlh_vector_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: v(3)
      if (self%from_orbit) then
         v = rotate_to_body(self%path%axes(t), self%vector)
      else
         v = rotate_to_space(self%path%axes(t), self%vector)
      end if
   end function vector_at

   !> Returns δv at a time, in the space axes of the scene; shape (3).
   pure function change_at(self, change, t) result(v)
      class(lvlh_vector_t), intent(in) :: self
      !> Change of the vector in the axes in which it is fixed, and of the elements, shape (3 + n_elements); time, s.
      real(wp), intent(in) :: change(:), t
      real(wp) :: v(3)
      type(lvlh_vector_t) :: other
      other = self
      other%vector = change(1:3)
      v = other%at(t)
      if (.not. size(change) > 3) return
      associate (turn => axes_change(self%path, change(4:), t))
         if (self%from_orbit) then
            v = v + rotate_to_body(self%path%axes(t), cross(self%vector, turn))
         else
            v = v + cross(turn, self%at(t))
         end if
      end associate
   end function change_at

   !> Returns v̇ at a time, in the space axes of the scene, unit of v per s; shape (3).
   pure function rate_at(self, t) result(rate)
      class(lvlh_vector_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: rate(3)
      rate = self%path%turn_rate(t)*cross(turn_axis(self, t), self%at(t))
   end function rate_at

   !> Returns the axis about which v rotates at the rate of the true anomaly: a unit vector; shape (3).
   pure function turn_axis(self, t) result(axis)
      class(lvlh_vector_t), intent(in) :: self
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: axis(3)
      if (self%from_orbit) then
         axis = -normal
      else
         axis = rotate_to_space(self%path%axes(t), normal)
      end if
   end function turn_axis

   !> Computes the coefficients of the power series of v about a time: v̇ = ν̇ a×v, the axis a at rest, ν̇ as 1/(x·x), x
   !> = r/r₀.
   pure subroutine series(self, t, time_unit, v)
      class(lvlh_vector_t), intent(in) :: self
      !> Time t₀ and time unit of the series, s.
      real(wp), intent(in) :: t, time_unit
      !> Shape (3, 0:order).
      real(wp), intent(out) :: v(:, 0:)
      real(wp), dimension(0:ubound(v, 2)) :: square, w, rate
      real(wp) :: x(0:ubound(v, 2), 3), axis(3), rotated(3)
      integer :: j, k
      call self%path%position_series(t, time_unit, x, square, w)
      axis = turn_axis(self, t)
      v(:, 0) = self%at(t)
      rate(0) = time_unit*self%path%turn_rate(t)
      do k = 0, ubound(v, 2) - 1
         if (k > 0) rate(k) = power_term(k, -1.0_wp, square(0:k), rate(0:k - 1))
         rotated = 0.0_wp
         do j = 0, k
            rotated = rotated + rate(j)*v(:, k - j)
         end do
         v(:, k + 1) = inverses(k + 1)*cross(axis, rotated)
      end do
   end subroutine series

   !> Computes the coefficients of the power series of δv about a time: the series of the changed vector, and of δθ×v,
   !> δθ the rotation of the LVLH frame, or of v×δθ in that frame.
   pure subroutine change_series(self, change, t, time_unit, v)
      class(lvlh_vector_t), intent(in) :: self
      !> Change as in `change_at`; time t₀ and time unit of the series, s.
      real(wp), intent(in) :: change(:), t, time_unit
      !> Shape (3, 0:order).
      real(wp), intent(out) :: v(:, 0:)
      type(lvlh_vector_t) :: other
      real(wp), dimension(3, 0:ubound(v, 2)) :: own, turn
      integer :: j, k
      other = self
      other%vector = change(1:3)
      call other%series(t, time_unit, v)
      if (.not. any(abs(change(4:)) > 0.0_wp)) return
      call self%series(t, time_unit, own)
      call axes_change_series(self%path, change(4:), t, time_unit, self%from_orbit, turn)
      if (self%from_orbit) own = -own
      do k = 0, ubound(v, 2)
         do j = 0, k
            v(:, k) = v(:, k) + cross(turn(:, j), own(:, k - j))
         end do
      end do
   end subroutine change_series

   !> Returns true if the vector, and its rate at the periapsis, are of a size that can be computed with.
   pure logical function vector_is_valid(self) result(valid)
      class(lvlh_vector_t), intent(in) :: self
      valid = all(is_moderate(self%vector)) .and. is_moderate(self%path%fastest_turn())
      if (valid) valid = is_moderate(norm2(self%vector))
      if (valid) valid = is_moderate(norm2(self%vector)*self%path%fastest_turn())
   end function vector_is_valid

end module nutate_lvlh_vector
