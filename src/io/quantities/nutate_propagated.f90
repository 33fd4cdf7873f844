!> Description of the quantities that a run propagates beside its state.
module nutate_propagated
   use nutate_kinds, only: wp
   implicit none
   private

   public :: propagated_t

   !> Quantities that a run propagates: sensitivities with respect to parameters, and indicators of chaos.
   type :: propagated_t
      !> Names of the parameters, `GROUP[.N].KEY[.I]`; shape (parameters).
      character(len=80), allocatable :: names(:)
      !> Standard deviation of each parameter, in its unit; 0: the parameter is known. Shape (parameters).
      real(wp), allocatable :: sigma(:)
      !> Number of Lyapunov exponents; 0: no indicators of chaos.
      integer :: exponents = 0
   end type propagated_t

end module nutate_propagated
