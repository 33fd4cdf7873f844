!> An internal rotor (gyrostat) of constant momentum along body axes: L = JΩ + h.
module nutate_rotor
   use nutate_body, only: body_t
   use nutate_effect_base, only: effect_t, LINEAR_SERIES
   use nutate_keys, only: group_t, key_t
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_status, only: status_t
   implicit none
   private

   public :: rotor_t, rotor_keys, build_rotor

   !> A rotor of constant momentum along body axes: L = JΩ + h, T = ½(L-h)ᵀJ⁻¹(L-h).
   type, extends(effect_t) :: rotor_t
      !> h, body axes, N m s.
      real(wp) :: momentum(3) = 0.0_wp
   contains
      procedure :: series_kind => constant_series
      procedure :: is_valid => rotor_is_valid
   end type rotor_t

   !> Keys of the scene group `&rotor`.
   type(key_t), parameter :: rotor_keys(1) = [key_t(name='momentum', least=3, most=3, required=.true.)]

contains

   !> Builds a rotor from its scene group. Returns no errors.
   subroutine build_rotor(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      allocate (effect, source=rotor_t(name='rotor', momentum=group%vector('momentum', [0.0_wp, 0.0_wp, 0.0_wp])))
   end subroutine build_rotor

   !> Returns true if the momentum is finite and of a size that can be computed with.
   pure logical function rotor_is_valid(self)
      class(rotor_t), intent(in) :: self
      rotor_is_valid = all(is_moderate(self%momentum))
   end function rotor_is_valid

   !> Returns `LINEAR_SERIES`: a constant momentum adds no terms of its own.
   pure integer function constant_series(self)
      class(rotor_t), intent(in) :: self
      constant_series = LINEAR_SERIES
   end function constant_series

end module nutate_rotor
