!> A frame of reference that rotates at a constant rate ω: the scene's space axes are fixed in it.
!>
!> Attitudes rotate body axes to those of the frame, and momenta are those of the absolute motion in these axes. Fields,
!> anchors and directions that are fixed in the frame are constant. Without forces `H - ω·l` (the Jacobi integral) is
!> conserved, not H. Torques are evaluated with the body's rate relative to the frame, Ω - Rᵀω, and do work with it.
module nutate_rotating_frame
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t, LINEAR_SERIES
   use nutate_keys, only: group_t, key_t, KEY_LOGICAL
   use nutate_kinds, only: wp, pi
   use nutate_limits, only: is_moderate
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: rotating_frame_t, rotating_frame_keys, build_rotating_frame, earth_rate, frame_at_latitude

   !> Angular velocity of the Earth relative to the stars, rad/s.
   real(wp), parameter :: earth_rate = 7.292115e-5_wp

   !> Keys of the scene group `&rotating_frame`.
   type(key_t), parameter :: rotating_frame_keys(3) = [ &
                             key_t(name='rate', least=3, most=3, instead_of='latitude'), &
                             key_t(name='latitude', instead_of='rate'), &
                             key_t(name='degrees', kind=KEY_LOGICAL)]

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

   !> Builds a frame from its scene group. Errors: `NUTATE_BAD_ARGUMENT` unless it gives a rate or a latitude, or
   !> for a latitude that is none.
   subroutine build_rotating_frame(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      real(wp) :: latitude
      if (group%has('rate') .eqv. group%has('latitude')) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a rotating frame has a rate or a latitude (expected one of them)', &
                       merge('latitude', '        ', group%has('latitude')))
      else if (group%has('rate')) then
         allocate (effect, source=rotating_frame_t(name='rotating_frame', &
                                                   rate=group%vector('rate', [0.0_wp, 0.0_wp, 0.0_wp])))
      else
         latitude = group%number('latitude', 0.0_wp)
         if (group%flag('degrees', .false.)) latitude = latitude*(pi/180)
         if (abs(latitude) > 0.5_wp*pi) then
            status = fail(NUTATE_BAD_ARGUMENT, &
                          'latitude is out of range (expected -pi/2 to pi/2, or -90 to 90 with '// &
                          'degrees)', 'latitude')
            return
         end if
         allocate (effect, source=frame_at_latitude(latitude))
      end if
   end subroutine build_rotating_frame

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
