!> An internal rotor (gyrostat) of constant momentum along body axes: L = JΩ + h.
module nutate_rotor
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, rotor_t
   use nutate_keys, only: group_t, key_t
   use nutate_kinds, only: wp
   use nutate_status, only: status_t
   implicit none
   private

   public :: rotor_keys, build_rotor

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

end module nutate_rotor
