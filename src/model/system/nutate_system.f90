!> System to be simulated: a body and the effects that act on it.
module nutate_system
   use nutate_body, only: body_t
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_small_products, only: symmetric_inverse
   implicit none
   private

   public :: system_t, inertia_at, inverse_inertia_at

   !> A body with its effects. Constant during a run; any number of states may be integrated with it concurrently.
   type :: system_t
      !> Body; if effects change its inertia, with that of t = 0.
      type(body_t) :: body
      type(effect_list_t) :: effects
   end type system_t

contains

   !> Returns J at a time, without the inertia of wheels about their axes, body axes, kg m²; shape (3,3).
   pure function inertia_at(system, t) result(inertia)
      type(system_t), intent(in) :: system
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: inertia(3, 3)
      inertia = system%body%inertia
      if (system%effects%varies) inertia = inertia + system%effects%inertia_term(0, t, t, 1.0_wp)
   end function inertia_at

   !> Returns J⁻¹ at a time, body axes, kg⁻¹ m⁻²; shape (3,3).
   pure function inverse_inertia_at(system, t) result(inverse)
      type(system_t), intent(in) :: system
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: inverse(3, 3)
      inverse = system%body%inverse_inertia
      if (system%effects%varies) inverse = symmetric_inverse(inertia_at(system, t))
   end function inverse_inertia_at

end module nutate_system
