!> A frame of reference that rotates at a constant rate ω: the scene's space axes are fixed in it.
!>
!> Attitudes rotate body axes to those of the frame, and momenta are those of the absolute motion in these axes. Fields,
!> anchors and directions that are fixed in the frame are constant. Without forces `H - ω·l` (the Jacobi integral) is
!> conserved, not H. Torques are evaluated with the body's rate relative to the frame, Ω - Rᵀω, and do work with it.
module nutate_rotating_frame
   use nutate_effect, only: effect_t, LINEAR_SERIES
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   implicit none
   private

   public :: rotating_frame_t, earth_rate, frame_at_latitude

   !> Angular velocity of the Earth relative to the stars, rad/s.
   real(wp), parameter :: earth_rate = 7.292115e-5_wp

   !> Rotation of the space axes. Several add up.
   type, extends(effect_t) :: rotating_frame_t
      !> ω, in the frame's own axes, rad/s; shape (3).
      real(wp) :: rate(3) = 0.0_wp
   contains
      procedure :: series_kind => constant_series
      procedure :: is_valid => frame_is_valid
   end type rotating_frame_t

contains

   !> Makes the frame with axes east, north and up at a place on the Earth, which rotates with the Earth.
   pure function frame_at_latitude(latitude) result(frame)
      !> Latitude, rad, north positive.
      real(wp), intent(in) :: latitude
      type(rotating_frame_t) :: frame
      frame%name = 'rotating_frame'
      frame%rate = earth_rate*[0.0_wp, cos(latitude), sin(latitude)]
   end function frame_at_latitude

   !> Returns `LINEAR_SERIES`: a constant rate adds no terms of its own.
   pure integer function constant_series(self)
      class(rotating_frame_t), intent(in) :: self
      constant_series = LINEAR_SERIES
   end function constant_series

   !> Returns true if the rate is of a size that can be computed with.
   pure logical function frame_is_valid(self)
      class(rotating_frame_t), intent(in) :: self
      frame_is_valid = all(is_moderate(self%rate))
   end function frame_is_valid

end module nutate_rotating_frame
