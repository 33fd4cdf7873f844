!> The drift of a batch of bodies with the vector instructions that every x86-64 processor has (SSE2); on other machines
!> with those that the compiler uses by default.
module nutate_drift_sse2
   use nutate_bodies_drift, only: drift_lanes_t, curvature, largest_correction, most_chords, share
   use nutate_kinds, only: wp, eps
   use nutate_lane_width, only: lanes
   implicit none
   private

   public :: enter_lanes, drift_lanes, leave_lanes

contains

   include 'nutate_drift_kernel.inc'

end module nutate_drift_sse2
