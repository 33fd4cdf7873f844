!> Potentials linear in a direction that moves: a magnetic moment in the Earth's field along an orbit, a force that
!> rotates with the LVLH frame. V(q, t) = -m·R(q)ᵀn(t).
module nutate_moving_linear
   use nutate_effect, only: GENERAL_SERIES, parameter_t
   use nutate_kepler_orbit, only: kepler_orbit_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_linear_potential, only: linear_potential_t
   use nutate_moving_direction, only: moving_direction_t
   use nutate_quaternion, only: cross, rotate_to_body
   implicit none
   private

   public :: moving_linear_t

   !> U(γ) = -m·γ, γ = R(q)ᵀn(t).
   type, extends(linear_potential_t) :: moving_linear_t
      !> n, in the space axes of the scene.
      class(moving_direction_t), allocatable :: vector
   contains
      !> Sets the name, m and n.
      procedure :: set_up
      procedure :: direction_at => vector_at
      procedure :: direction_series => series_of_vector
      procedure :: power => power_of_motion
      procedure :: series_kind => general_kind
      procedure :: series_torque => torque_of_moment
      procedure :: is_valid => moving_is_valid
      procedure :: parameters => moving_parameters
      procedure :: direction_change => change_of_vector
      procedure :: direction_change_series => series_of_change
      procedure :: follows => vector_follows
      procedure :: thin_table => thin_path
   end type moving_linear_t

contains

   !> Sets the name of the effect, m and n.
   pure subroutine set_up(self, name, moment, vector)
      class(moving_linear_t), intent(inout) :: self
      character(len=*), intent(in) :: name
      !> m, body axes; shape (3).
      real(wp), intent(in) :: moment(3)
      !> n, in the space axes of the scene.
      class(moving_direction_t), intent(in) :: vector
      self%name = name
      self%moment = moment
      allocate (self%vector, source=vector)
      self%moves = .true.
      self%direction = 0.0_wp
      if (.not. self%is_valid()) return
      self%pace = vector%pace()
      self%direction = vector%at(0.0_wp)
   end subroutine set_up

   !> Returns n at a time, space axes; shape (3).
   pure function vector_at(self, t) result(n)
      class(moving_linear_t), intent(in) :: self
      real(wp), intent(in) :: t
      real(wp) :: n(3)
      n = self%vector%at(t)
   end function vector_at

   !> Computes the coefficients of the power series of n about a time, space axes.
   pure subroutine series_of_vector(self, t, time_unit, n)
      class(moving_linear_t), intent(in) :: self
      real(wp), intent(in) :: t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      call self%vector%series(t, time_unit, n)
   end subroutine series_of_vector

   !> Returns true if |m||n|, the largest energy and torque, and this times the largest rate of the direction of n, the
   !> largest power, can be computed with.
   pure logical function moving_is_valid(self) result(valid)
      class(moving_linear_t), intent(in) :: self
      valid = all(is_moderate(self%moment)) .and. allocated(self%vector)
      if (valid) valid = self%vector%is_valid()
      if (valid) valid = is_moderate(norm2(self%moment))
      if (valid) valid = is_moderate(norm2(self%moment)*self%vector%greatest())
      if (valid) valid = is_moderate(norm2(self%moment)*self%vector%greatest()*self%vector%pace())
   end function moving_is_valid

   !> Returns m and the parameters of n.
   pure function moving_parameters(self) result(list)
      class(moving_linear_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = self%linear_potential_t%parameters()
      list = [list(1), self%vector%parameters()]
   end function moving_parameters

   pure function change_of_vector(self, change, t) result(n)
      class(moving_linear_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t
      real(wp) :: n(3)
      n = self%vector%change_at(change(4:), t)
   end function change_of_vector

   pure subroutine series_of_change(self, change, t, time_unit, n, known)
      class(moving_linear_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, time_unit
      real(wp), intent(out) :: n(:, 0:)
      logical, intent(out) :: known
      known = .true.
      call self%vector%change_series(change(4:), t, time_unit, n)
   end subroutine series_of_change

   pure logical function vector_follows(self, path)
      class(moving_linear_t), intent(in) :: self
      type(kepler_orbit_t), intent(in) :: path
      vector_follows = self%vector%path%equals(path)
   end function vector_follows

   !> Leaves out every second line of the table of the orbit.
   subroutine thin_path(self)
      class(moving_linear_t), intent(inout) :: self
      call self%vector%path%thin_table()
   end subroutine thin_path

   !> Returns ∂V/∂t = -m·R(q)ᵀṅ at fixed attitude, W.
   pure real(wp) function power_of_motion(self, q, t) result(power)
      class(moving_linear_t), intent(in) :: self
      real(wp), intent(in) :: q(4), t
      power = -dot_product(self%moment, rotate_to_body(q, self%vector%rate_at(t)))
   end function power_of_motion

   !> Returns `GENERAL_SERIES`: n is not fixed in space.
   pure integer function general_kind(self)
      class(moving_linear_t), intent(in) :: self
      general_kind = GENERAL_SERIES
   end function general_kind

   !> Computes coefficient k of γ×∇U = m×γ, body axes, N m.
   pure subroutine torque_of_moment(self, k, gamma, auxiliary, tau)
      class(moving_linear_t), intent(in) :: self
      integer, intent(in) :: k
      real(wp), intent(in) :: gamma(3, 0:k)
      real(wp), intent(inout) :: auxiliary(0:, :)
      real(wp), intent(out) :: tau(3)
      tau = cross(self%moment, gamma(:, k))
   end subroutine torque_of_moment

end module nutate_moving_linear
