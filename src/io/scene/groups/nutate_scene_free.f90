!> `&free`: which numbers of a scene are fitted to measurements.
module nutate_scene_free
   use nutate_admissible, only: POSITIVE
   use nutate_fit_plan, only: fit_plan_t, free_number_t
   use nutate_keys, only: group_t, group_kind_t, key_t, setting_t, KEY_INTEGER, KEY_REAL, KEY_TEXT
   use nutate_kinds, only: wp, pi
   use nutate_printable, only: quoted
   use nutate_quaternion, only: quat_conjugate, quat_product
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_target, only: add_targets
   use nutate_spelling, only: count_text, lower_case
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: free_keys, prepare_attitude, add_free

   !> Maximum numbers of keys of a group, and of numbers.
   integer, parameter :: most_keys = 8, most_numbers = 24
   !> Name of the attitude as a rotation vector, which is not a key.
   character(len=*), parameter :: attitude_key = 'initial.attitude'
   !> Groups whose numbers are steps or times, with respect to which the motion has no derivative, or no meaningful one.
   character(len=*), parameter :: without_derivative(2) = [character(len=10) :: 'integrator', 'event']
   !> Keys by which an attitude can be given.
   character(len=*), parameter :: attitude_forms(5) = [character(len=14) :: &
      'quaternion', 'axis', 'angle', 'euler', 'roll_pitch_yaw']

contains

   !> Keys of the scene group `&free`.
   pure function free_keys() result(keys)
      type(key_t) :: keys(4)
      keys = [key_t(name='key', kind=KEY_TEXT, most=most_keys, required=.true.), &
              key_t(name='sigma', most=most_numbers, range=POSITIVE), &
              key_t(name='low', most=most_numbers), &
              key_t(name='high', most=most_numbers)]
   end function free_keys

   !> Converts a free attitude into a quaternion, from any form that the scene has.
   subroutine prepare_attitude(groups, system, initial, plan, error)
      type(group_t), intent(in) :: groups(:)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: initial
      type(fit_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      type(setting_t) :: quaternion
      integer :: i, k, line
      line = 0
      do i = 1, size(groups)
         if (groups(i)%name /= 'free') cycle
         do k = 1, groups(i)%count_of('key')
            if (.not. is_attitude(groups(i)%text_at('key', k))) cycle
            plan%has_attitude = .true.
            line = groups(i)%line_of('key')
         end do
      end do
      i = findloc(groups%name == 'initial', .true., dim=1)
      plan%angle_unit = merge(pi/180, 1.0_wp, groups(i)%flag('degrees', .false.))
      if (.not. plan%has_attitude) return
      if (groups(i)%has('euler_rates')) then
         call error%raise(line, 'the rates of Euler angles depend on the attitude, which is free', &
                          expected='angular_velocity in &initial')
         return
      end if
      plan%attitude = initial%q
      if (groups(i)%text('attitude_from', 'space') == 'lvlh') &
         plan%attitude = quat_product(quat_conjugate(system%effects%orbit%axes(0.0_wp)), initial%q)
      quaternion%name = 'quaternion'
      quaternion%kind = KEY_REAL
      quaternion%line = line
      allocate (quaternion%values(4))
      quaternion%values%number = plan%attitude
      associate (group => plan%numbers%groups(i))
         do k = 1, size(attitude_forms)
            call group%drop(trim(attitude_forms(k)))
         end do
         call group%put(quaternion)
      end associate
   end subroutine prepare_attitude

   pure logical function is_attitude(name)
      character(len=*), intent(in) :: name
      is_attitude = lower_case(trim(adjustl(name))) == attitude_key
   end function is_attitude

   !> Adds the numbers of a group `&free`.
   subroutine add_free(group, groups, kinds, plan, error)
      type(group_t), intent(in) :: group
      !> Groups of the scene.
      type(group_t), intent(in) :: groups(:)
      type(group_kind_t), intent(in) :: kinds(:)
      type(fit_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      type(free_number_t), allocatable :: free(:)
      integer :: i, k, n, before
      before = size(plan%free)
      do i = 1, group%count_of('key')
         if (is_attitude(group%text_at('key', i))) then
            if (any(plan%free%component > 0)) then
               call error%raise(group%line_of('key'), attitude_key//' is free twice', expected='each number once')
               return
            end if
            free = [(free_number_t(name=attitude_key//'.'//achar(iachar('0') + k), component=k), k=1, 3)]
         else
            call add_targets(group%text_at('key', i), group%line_of('key'), 'free', kinds, plan%numbers, n, &
                             error)
            if (.not. error%raised) call check_key(group%text_at('key', i), group%line_of('key'), n, groups, plan, &
               error)
            if (error%raised) return
            associate (targets => plan%numbers%targets)
               free = [(free_number_t(name=targets(k)%name, target=k), k=size(targets) - n + 1, size(targets))]
            end associate
         end if
         free%line = group%line_of('key')
         plan%free = [plan%free, free]
      end do
      call read_limits(group, plan%free(before + 1:), error)
   end subroutine add_free

   !> Raises an error for a key without a value in the scene, or with respect to which the motion has no derivative.
   subroutine check_key(name, line, n, groups, plan, error)
      character(len=*), intent(in) :: name
      integer, intent(in) :: line
      !> Number of numbers of the key.
      integer, intent(in) :: n
      type(group_t), intent(in) :: groups(:)
      type(fit_plan_t), intent(in) :: plan
      type(scene_error_t), intent(inout) :: error
      associate (target => plan%numbers%targets(size(plan%numbers%targets) - n + 1))
         if (any(without_derivative == groups(target%group)%name) .or. target%key%kind == KEY_INTEGER) then
            call error%raise(line, 'the motion has no derivative with respect to '//quoted(name), &
                             expected='a key of &initial, &body or an effect')
         else if (target%key%name == 'quaternion') then
            call error%raise(line, 'four numbers of a quaternion are not independent', expected="'"//attitude_key//"'")
         else if (.not. groups(target%group)%has(trim(target%key%name))) then
            call error%raise(line, 'the scene has no '//quoted(name)//' to start from', expected='the key in its group')
         end if
      end associate
   end subroutine check_key

   !> Reads standard deviations and bounds.
   subroutine read_limits(group, free, error)
      type(group_t), intent(in) :: group
      type(free_number_t), intent(inout) :: free(:)
      type(scene_error_t), intent(inout) :: error
      character(len=5), parameter :: names(3) = ['sigma', 'low  ', 'high ']
      integer :: i
      do i = 1, 3
         if (group%has(trim(names(i))) .and. group%count_of(trim(names(i))) /= size(free)) &
            call error%raise(group%line_of(trim(names(i))), trim(names(i))//' has the wrong number of values', &
                             expected=count_text(size(free)))
      end do
      if (error%raised) return
      free%sigma = group%vector('sigma', free%sigma)
      free%low = group%vector('low', free%low)
      free%high = group%vector('high', free%high)
      if (any(free%low >= free%high)) call error%raise(group%line_of('high'), 'high is not above low', &
                                                       expected='bounds in their order')
      if (any(free%component > 0) .and. (group%has('low') .or. group%has('high'))) &
         call error%raise(group%line_of(trim(merge('low ', 'high', group%has('low')))), &
                          'an attitude has no bounds', expected='sigma')
   end subroutine read_limits

end module nutate_scene_free
