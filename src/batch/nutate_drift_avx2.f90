!> The drift of a batch of bodies with AVX2: CMakeLists.txt compiles this file for processors that have it. Results are
!> bitwise identical to those of `nutate_drift_sse2`.
module nutate_drift_avx2
   use nutate_bodies_drift, only: drift_lanes_t, curvature, largest_correction, most_chords, share
   use nutate_kinds, only: wp, eps
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: enter_lanes, drift_lanes, leave_lanes

contains

   include 'nutate_drift_kernel.inc'

end module nutate_drift_avx2
