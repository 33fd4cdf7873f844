!> Steps of tops in SIMD lanes with the vector instructions that every processor of the target has.
module nutate_top_sse2
   use nutate_kinds, only: wp, eps
   use nutate_power_series, only: highest_order, inverses
   use nutate_top_lanes, only: lane_count, top_lanes_t
   implicit none
   private

   public :: expand_tops, move_tops

contains

   include 'nutate_top_kernel.inc'

end module nutate_top_sse2
