!> The scene group `&wheel`.
module nutate_wheel_group
   use nutate_admissible, only: ANY_DIRECTION, NON_NEGATIVE, POSITIVE
   use nutate_body, only: body_t
   use nutate_effect, only: effect_t
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_wheel, only: wheel_t
   use nutate_wheel_motor, only: build_motor
   implicit none
   private

   public :: wheel_keys, build_wheel

   !> Keys of the scene group `&wheel`.
   type(key_t), parameter :: wheel_keys(14) = [ &
      key_t(name='axis', least=3, most=3, range=ANY_DIRECTION, required=.true.), &
      key_t(name='inertia', range=POSITIVE, required=.true.), &
      key_t(name='speed', default='0'), &
      key_t(name='torque'), &
      key_t(name='frequency', default='0', beside='torque'), &
      key_t(name='phase', default='0', beside='torque'), &
      key_t(name='friction', range=NON_NEGATIVE, default='0'), &
      key_t(name='start'), &
      key_t(name='stop'), &
      key_t(name='table', kind=KEY_TEXT), &
      key_t(name='interpolation', kind=KEY_TEXT, choices='linear,cubic', default='linear', beside='table'), &
      key_t(name='outside', kind=KEY_TEXT, choices='zero,periodic', default='zero', beside='table'), &
      key_t(name='torque_limit', range=POSITIVE), &
      key_t(name='speed_limit', range=POSITIVE)]

contains

   !> Builds a wheel from its scene group. Errors: those of `build_motor`; `NUTATE_BAD_ARGUMENT` for a speed above
   !> its limit.
   subroutine build_wheel(group, body, effect, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(wheel_t) :: wheel
      real(wp) :: axis(3)
      wheel%name = 'wheel'
      axis = group%vector('axis', wheel%axis)
      ! The axis is scaled first: the squares of a long or short vector would leave the range of numbers.
      wheel%reach = maxval(abs(axis))
      axis = axis/wheel%reach
      wheel%reach = wheel%reach*norm2(axis)
      wheel%axis = axis/norm2(axis)
      wheel%inertia = group%number('inertia', wheel%inertia)
      wheel%speed = group%number('speed', wheel%speed)
      wheel%friction = group%number('friction', wheel%friction)
      wheel%torque_limit = group%number('torque_limit', wheel%torque_limit)
      wheel%speed_limit = group%number('speed_limit', wheel%speed_limit)
      if (abs(wheel%speed) > wheel%speed_limit) then
         status = fail(NUTATE_BAD_ARGUMENT, 'speed is above speed_limit (expected one up to it)', 'speed')
         return
      end if
      call build_motor(group, wheel%motor, status)
      if (status%ok()) allocate (effect, source=wheel)
   end subroutine build_wheel

end module nutate_wheel_group
