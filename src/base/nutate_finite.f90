!> Tests for NaN and infinities. The procedures of a submodule keep `ieee_arithmetic` out of the modules that use them:
!> gfortran writes its types into the module file of every module that reads it, however indirectly.
module nutate_finite
   use nutate_kinds, only: wp
   implicit none
   private

   public :: is_finite, is_nan

   interface

      !> Returns true if a number is neither infinite nor a NaN; raises no exception.
      elemental logical module function is_finite(x)
         real(wp), intent(in) :: x
      end function is_finite

      !> Returns true if a number is a NaN; raises no exception.
      elemental logical module function is_nan(x)
         real(wp), intent(in) :: x
      end function is_nan

   end interface

end module nutate_finite
