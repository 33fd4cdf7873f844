!> The series of a step with AVX2: CMakeLists.txt compiles this file with AVX2 instructions. Results are bitwise
!> identical to those of `nutate_rows_sse2`.
module nutate_rows_avx2
   use nutate_effect_list, only: effect_list_t
   use nutate_kinds, only: wp
   use nutate_power_series, only: highest_order, inverses
   use nutate_row_series, only: row_series_t, steepest_growth
   use nutate_series_tail, only: largest_part
   use nutate_wheel_series, only: add_speeds
   implicit none
   private

   public :: expand_axial_top, expand_free, expand_rows, multiply_last, sum_four, sum_rows

contains

   include 'nutate_rows_kernel.inc'

   include 'nutate_free_kernel.inc'

end module nutate_rows_avx2
