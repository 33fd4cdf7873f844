!> How many bodies a batch moves at once. No bit of a body depends on it: `tools/check-lanes.sh` builds with others.
module nutate_lane_width
   implicit none
   private

   !> One or two registers of AVX-512, four of SSE2.
   integer, parameter, public :: lanes = 8

end module nutate_lane_width
