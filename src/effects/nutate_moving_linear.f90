!> Potentials linear in a direction that moves: a magnetic moment in the Earth's field along an orbit, a force that
!> turns with the LVLH frame. V(q, t) = -m·R(q)ᵀn(t).
module nutate_moving_linear
   use nutate_effect, only: GENERAL_SERIES
   use nutate_effect_bounds, only: effect_bounds_t, linear_map_t
   use nutate_kinds, only: wp
   use nutate_linear_potential, only: linear_potential_t
   use nutate_quaternion, only: cross, rotate_to_body
   implicit none
   private

   public :: moving_linear_t

   !> U(γ) = -m·γ, γ = R(q)ᵀn(t). Extensions define n by `direction_at`, `direction_rate` and `direction_series`.
   type, abstract, extends(linear_potential_t) :: moving_linear_t
   contains
      !> Returns ṅ at a time.
      procedure(rate_of_direction), deferred :: direction_rate
      procedure :: power => power_of_motion
      procedure :: series_kind => general_kind
      procedure :: series_torque => torque_of_moment
      procedure :: bound => not_bounded
      procedure :: has_axis => no_axis
   end type moving_linear_t

   abstract interface
      !> Returns ṅ at a time, space axes, unit of n per s; shape (3).
      pure function rate_of_direction(self, t) result(rate)
         import :: moving_linear_t, wp
         class(moving_linear_t), intent(in) :: self
         !> s.
         real(wp), intent(in) :: t
         real(wp) :: rate(3)
      end function rate_of_direction
   end interface

contains

   !> Returns ∂V/∂t = -m·R(q)ᵀṅ at fixed attitude, W.
   pure real(wp) function power_of_motion(self, q, t) result(power)
      class(moving_linear_t), intent(in) :: self
      real(wp), intent(in) :: q(4), t
      power = -dot_product(self%moment, rotate_to_body(q, self%direction_rate(t)))
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

   !> Returns no bounds: no step with a time-dependent potential counts as certified.
   pure subroutine not_bounded(self, map, radius, gamma, slack, bounds)
      class(moving_linear_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      bounds%known = .false.
   end subroutine not_bounded

   !> Returns false: the rotated steppers require directions that are fixed in space.
   pure logical function no_axis(self, axis)
      class(moving_linear_t), intent(in) :: self
      integer, intent(in) :: axis
      no_axis = .false.
   end function no_axis

end module nutate_moving_linear
