!> System to be simulated: a body and the effects that act on it.
module nutate_system
   use nutate_body, only: body_t
   use nutate_effect_list, only: effect_list_t
   implicit none
   private

   public :: system_t

   !> A body with its effects. Constant during a run; any number of states may be integrated with it concurrently.
   type :: system_t
      type(body_t) :: body
      type(effect_list_t) :: effects
   end type system_t

end module nutate_system
