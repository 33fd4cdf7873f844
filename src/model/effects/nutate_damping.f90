!> Viscous damping in body axes: τ = -diag(c) Ω.
module nutate_damping
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, LINEAR_SERIES, parameter_t, torque_t
   use nutate_effect_bounds, only: bounds_of_drag, effect_bounds_t, linear_map_t
   use nutate_keys, only: group_t, key_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_small_products, only: is_symmetric_about
   use nutate_status, only: status_t
   implicit none
   private

   public :: damping_t, damping_keys, build_damping

   !> Keys of the scene group `&damping`.
   type(key_t), parameter :: damping_keys(1) = [key_t(name='coefficient', least=3, most=3, required=.true.)]

   !> τ = -diag(c) Ω; negative coefficients drive.
   type, extends(torque_t) :: damping_t
      !> c, body axes, N m s; shape (3).
      real(wp) :: coefficient(3) = 0.0_wp
   contains
      procedure :: torque => damping_torque
      procedure :: is_valid => damping_is_valid
      procedure :: derivatives => damping_derivatives
      procedure :: needs_attitude => no_attitude
      procedure :: bound => damping_bound
      procedure :: series_kind => linear_kind
      procedure :: series_drag => damping_drag
      procedure :: has_axis => damping_has_axis
      procedure :: parameters => damping_parameters
      procedure :: torque_change => damping_change
   end type damping_t

   !> Makes a damping torque.
   interface damping_t
      module procedure new_damping
   end interface damping_t

contains

   !> Makes a linear damping torque -diag(c)Ω along the body axes.
   pure function new_damping(coefficient) result(damping)
      !> c, body axes, N m s; shape (3).
      real(wp), intent(in) :: coefficient(3)
      type(damping_t) :: damping
      damping%name = 'damping'
      damping%coefficient = coefficient
   end function new_damping

   !> Builds damping from its scene group. Returns no errors.
   subroutine build_damping(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      allocate (effect, source=damping_t(group%vector('coefficient', [0.0_wp, 0.0_wp, 0.0_wp])))
   end subroutine build_damping

   !> Returns -diag(c)Ω, body axes, N m.
   pure function damping_torque(self, t, q, omega) result(tau)
      class(damping_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = -self%coefficient*omega
   end function damping_torque

   !> Computes ∂τ/∂θ = 0 and ∂τ/∂Ω = -diag(c).
   pure subroutine damping_derivatives(self, t, q, omega, by_rotation, by_rate)
      class(damping_t), intent(in) :: self
      real(wp), intent(in) :: t, q(4), omega(3)
      real(wp), intent(out) :: by_rotation(3, 3), by_rate(3, 3)
      integer :: i
      by_rotation = 0.0_wp
      by_rate = 0.0_wp
      do i = 1, 3
         by_rate(i, i) = -self%coefficient(i)
      end do
   end subroutine damping_derivatives

   !> Returns false: the torque does not depend on the attitude.
   pure logical function no_attitude(self)
      class(damping_t), intent(in) :: self
      no_attitude = .false.
   end function no_attitude

   !> Bounds the torque and its derivatives in a step: it is linear in Ω.
   pure subroutine damping_bound(self, map, radius, gamma, slack, bounds)
      class(damping_t), intent(in) :: self
      type(linear_map_t), intent(in) :: map
      real(wp), intent(in) :: radius, gamma(3), slack
      type(effect_bounds_t), intent(out) :: bounds
      bounds = bounds_of_drag(map, radius, self%series_drag())
   end subroutine damping_bound

   !> Returns `LINEAR_SERIES`.
   pure integer function linear_kind(self)
      class(damping_t), intent(in) :: self
      linear_kind = LINEAR_SERIES
   end function linear_kind

   !> Returns D = -diag(c) of τ = DΩ, N m s; shape (3,3).
   pure function damping_drag(self) result(drag)
      class(damping_t), intent(in) :: self
      real(wp) :: drag(3, 3)
      integer :: i
      drag = 0.0_wp
      do i = 1, 3
         drag(i, i) = -self%coefficient(i)
      end do
   end function damping_drag

   !> Returns true if the two coefficients across the axis are equal.
   pure logical function damping_has_axis(self, axis)
      class(damping_t), intent(in) :: self
      integer, intent(in) :: axis
      damping_has_axis = is_symmetric_about(self%series_drag(), axis)
   end function damping_has_axis

   !> Returns true if the coefficients are of a size that can be computed with.
   pure logical function damping_is_valid(self)
      class(damping_t), intent(in) :: self
      damping_is_valid = all(is_moderate(self%coefficient))
   end function damping_is_valid

   pure function damping_parameters(self) result(list)
      class(damping_t), intent(in) :: self
      type(parameter_t), allocatable :: list(:)
      list = [parameter_t('coefficient', 3)]
   end function damping_parameters

   pure function damping_change(self, change, t, q, omega) result(tau)
      class(damping_t), intent(in) :: self
      real(wp), intent(in) :: change(:), t, q(4), omega(3)
      real(wp) :: tau(3)
      tau = -change*omega
   end function damping_change

end module nutate_damping
