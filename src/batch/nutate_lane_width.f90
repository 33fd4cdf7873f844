!> Number of bodies in a SIMD batch. Results are bitwise identical for any number.
module nutate_lane_width
   implicit none
   private

   !> Two registers of AVX-512, four of AVX2: enough that one is worked at while another waits.
   integer, parameter, public :: lanes = 16

end module nutate_lane_width
