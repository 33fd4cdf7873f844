!> The scene group `&rotating_frame`.
module nutate_rotating_frame_group
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t
   use nutate_keys, only: group_t, key_t, KEY_LOGICAL
   use nutate_kinds, only: wp, pi
   use nutate_rotating_frame, only: frame_at_latitude, rotating_frame_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: rotating_frame_keys, build_rotating_frame

   !> Keys of the scene group `&rotating_frame`.
   type(key_t), parameter :: rotating_frame_keys(3) = [ &
      key_t(name='rate', least=3, most=3, instead_of='latitude'), &
      key_t(name='latitude', instead_of='rate'), &
      key_t(name='degrees', kind=KEY_LOGICAL)]

contains

   !> Builds a frame from its scene group. Errors: `NUTATE_BAD_ARGUMENT` unless it gives either a rate or a latitude,
   !> and for a latitude out of range.
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

end module nutate_rotating_frame_group
