!> Bodies of the procedures whose interfaces are in `nutate_finite`.
submodule(nutate_finite) nutate_finite_procedures
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
   implicit none

contains

   module procedure is_finite
      is_finite = ieee_is_finite(x)
   end procedure is_finite

   module procedure is_nan
      is_nan = ieee_is_nan(x)
   end procedure is_nan

end submodule nutate_finite_procedures
