!> The scene group `&regulator`.
module nutate_regulator_group
   use nutate_admissible, only: ANY_DIRECTION, NON_NEGATIVE, POSITIVE
   use nutate_body, only: body_t, diagonal
   use nutate_effect, only: effect_t
   use nutate_keys, only: group_t, key_t, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, is_unit
   use nutate_quaternion, only: quat_normalized
   use nutate_regulator, only: regulator_t, BY_MAGNETS, BY_TORQUE, BY_WHEELS, DETUMBLING
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: regulator_keys, build_regulator

   !> Keys of the scene group `&regulator`.
   type(key_t), parameter :: regulator_keys(13) = [ &
      key_t(name='law', kind=KEY_TEXT, choices='quaternion,bdot', required=.true.), &
      key_t(name='by', kind=KEY_TEXT, choices='torque,wheels,magnets'), &
      key_t(name='target', least=4, most=4), &
      key_t(name='target_from', kind=KEY_TEXT, choices='space,orbit'), &
      key_t(name='attitude_gain', range=NON_NEGATIVE), &
      key_t(name='rate_gain', range=NON_NEGATIVE), &
      key_t(name='gains', kind=KEY_TEXT, choices='inertia,scalar'), &
      key_t(name='gain', range=NON_NEGATIVE), &
      key_t(name='field', least=3, most=3, range=ANY_DIRECTION, default='&earth_field'), &
      key_t(name='sample', range=POSITIVE), &
      key_t(name='limit', range=POSITIVE), &
      key_t(name='start'), &
      key_t(name='stop')]

contains

   !> A regulator as a scene's group asks for it. Magnets without a field follow that of the Earth, which
   !> `add_regulator` gives them.
   !>
   !> Errors: `NUTATE_BAD_ARGUMENT` for a key that the law does not have, or misses; a target that is no unit
   !> quaternion; an empty window.
   subroutine build_regulator(group, body, effect, status)
      type(group_t), intent(in) :: group
      !> Its wheels locked.
      type(body_t), intent(in) :: body
      class(effect_t), allocatable, intent(out) :: effect
      type(status_t), intent(out) :: status
      type(regulator_t) :: regulator
      call check_keys(group, status)
      if (.not. status%ok()) return
      regulator%name = 'regulator'
      regulator%field = group%vector('field', regulator%field)
      regulator%follows_earth = .not. group%has('field') .and. &
                                (group%text('law', '') == 'bdot' .or. group%text('by', '') == 'magnets')
      regulator%sample = group%number('sample', regulator%sample)
      regulator%limit = group%number('limit', regulator%limit)
      regulator%start = group%number('start', regulator%start)
      regulator%stop = group%number('stop', regulator%stop)
      if (.not. regulator%stop > regulator%start) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the regulator stops before it starts (expected stop > start)', 'stop')
      else if (group%text('law', '') == 'bdot') then
         regulator%law = DETUMBLING
         regulator%by = BY_MAGNETS
         regulator%gain = group%number('gain', 0.0_wp)
      else
         call take_pointing(group, body, regulator, status)
      end if
      if (status%ok()) allocate (effect, source=regulator)
   end subroutine build_regulator

   !> Target, gains and what acts. Errors: `NUTATE_BAD_ARGUMENT` for a target that is no unit quaternion.
   subroutine take_pointing(group, body, regulator, status)
      type(group_t), intent(in) :: group
      type(body_t), intent(in) :: body
      type(regulator_t), intent(inout) :: regulator
      type(status_t), intent(inout) :: status
      real(wp) :: unit(3, 3)
      select case (group%text('by', 'torque'))
      case ('wheels')
         regulator%by = BY_WHEELS
      case ('magnets')
         regulator%by = BY_MAGNETS
      case default
         regulator%by = BY_TORQUE
      end select
      regulator%target = group%vector('target', regulator%target)
      if (.not. is_unit(regulator%target, attitude_tolerance)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the target is no unit quaternion (expected a norm of 1 to within 1e-6)', &
                       'target')
         return
      end if
      regulator%target = quat_normalized(regulator%target)
      regulator%follows_orbit = group%text('target_from', 'space') == 'orbit'
      unit = body%inertia
      if (group%text('gains', 'inertia') == 'scalar') unit = diagonal([1.0_wp, 1.0_wp, 1.0_wp])
      regulator%attitude_gain = group%number('attitude_gain', 0.0_wp)*unit
      regulator%rate_gain = group%number('rate_gain', 0.0_wp)*unit
   end subroutine take_pointing

   !> Errors: `NUTATE_BAD_ARGUMENT` for a key that the law does not have, or misses.
   subroutine check_keys(group, status)
      type(group_t), intent(in) :: group
      type(status_t), intent(out) :: status
      character(len=13), parameter :: of_pointing(6) = [character(len=13) :: &
                                                        'by', 'target', 'target_from', 'attitude_gain', 'rate_gain', &
                                                        'gains']
      integer :: i
      if (group%text('law', '') == 'bdot') then
         do i = 1, size(of_pointing)
            if (group%has(trim(of_pointing(i)))) &
               call refuse(of_pointing(i), " with the law 'bdot' (expected gain and field; it acts by magnets)")
         end do
         call demand('gain')
      else
         if (group%has('gain')) call refuse('gain', " with the law 'quaternion' (expected attitude_gain and rate_gain)")
         call demand('attitude_gain')
         call demand('rate_gain')
         if (group%text('by', 'torque') /= 'magnets' .and. group%has('field')) &
            call refuse('field', " without magnets (expected by = 'magnets' with it)")
      end if
      if (group%has('limit') .and. group%text('by', '') == 'wheels') &
         call refuse('limit', ' with wheels (expected torque_limit in &wheel)')

   contains

      subroutine demand(key)
         character(len=*), intent(in) :: key
         if (status%ok() .and. .not. group%has(key)) &
            status = fail(NUTATE_BAD_ARGUMENT, 'the regulator has no '//key//' (expected it)')
      end subroutine demand

      subroutine refuse(key, words)
         character(len=*), intent(in) :: key, words
         if (status%ok()) status = fail(NUTATE_BAD_ARGUMENT, trim(key)//words, key)
      end subroutine refuse

   end subroutine check_keys

end module nutate_regulator_group
