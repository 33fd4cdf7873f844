!> Quantities of events that a C program supplies. The callbacks are called from pure procedures: the program
!> guarantees that their results depend on their arguments only.
module nutate_c_quantity
   use, intrinsic :: iso_c_binding, only: c_double, c_funptr, c_null_funptr, c_null_ptr, c_ptr
   use nutate_event, only: event_t
   use nutate_kinds, only: wp
   use nutate_motion, only: motion_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: c_event_t

   !> Event of a quantity g(t, q, Ω), from a callback `nutate_quantity`.
   type, extends(event_t) :: c_event_t
      type(c_funptr) :: function = c_null_funptr
      !> User data, passed to the callback.
      type(c_ptr) :: user = c_null_ptr
      !> Address of two `int` for failures.
      type(c_ptr) :: failure = c_null_ptr
   contains
      procedure :: value => called_value
   end type c_event_t

   interface
      pure subroutine call_quantity(function, t, q, omega, user, failure, g) bind(C, name='nutate_c_call_quantity')
         import :: c_double, c_funptr, c_ptr
         type(c_funptr), intent(in), value :: function
         real(c_double), intent(in), value :: t
         real(c_double), intent(in) :: q(4), omega(3)
         type(c_ptr), intent(in), value :: user, failure
         real(c_double), intent(out) :: g
      end subroutine call_quantity
   end interface

contains

   pure real(wp) function called_value(self, system, motion) result(g)
      class(c_event_t), intent(in) :: self
      type(system_t), intent(in) :: system
      type(motion_t), intent(in) :: motion
      call call_quantity(self%function, motion%state%t, motion%state%q, motion%omega, self%user, self%failure, g)
   end function called_value

end module nutate_c_quantity
