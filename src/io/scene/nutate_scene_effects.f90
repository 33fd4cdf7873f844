!> The effects of a scene: every group that is not one of its fixed parts.
module nutate_scene_effects
   use nutate_body, only: body_t, whole_body
   use nutate_effect, only: effect_t, rotor_t
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_keys, only: group_t, group_kind_t
   use nutate_range, only: check_strength
   use nutate_scene_error, only: scene_error_t
   use nutate_regulator, only: regulator_t
   use nutate_regulator_mounting, only: add_regulator
   use nutate_rotating_frame, only: rotating_frame_t
   use nutate_scene_table, only: read_torque_table
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   implicit none
   private

   public :: add_effect_kinds, build_effects

contains

   !> The kinds of group that are effects, behind room for the fixed parts.
   subroutine add_effect_kinds(parts, kinds)
      !> Number of fixed parts.
      integer, intent(in) :: parts
      !> Shape (parts + number of effects); the first `parts` are left to the caller.
      type(group_kind_t), allocatable, intent(out) :: kinds(:)
      type(effect_kind_t), allocatable :: effects(:)
      integer :: i

      effects = effect_kinds()
      allocate (kinds(parts + size(effects)))
      do i = 1, size(effects)
         kinds(parts + i) = effects(i)%group
      end do
   end subroutine add_effect_kinds

   !> Adds the effects that the groups name, in their order but regulators last, to a system. What is made from
   !> a body is made from the whole one, its wheels locked.
   subroutine build_effects(groups, system, error, folder)
      !> The tables that they name are read.
      type(group_t), intent(inout) :: groups(:)
      !> Its body is used, its effects are added.
      type(system_t), intent(inout) :: system
      type(scene_error_t), intent(inout) :: error
      !> Where names of tables begin, `/` at its end; default: the working directory.
      character(len=*), intent(in), optional :: folder
      type(effect_kind_t), allocatable :: kinds(:)
      class(effect_t), allocatable :: effect
      type(body_t) :: body
      type(status_t) :: status
      integer :: i, k, n

      kinds = effect_kinds()
      body = whole_body(system%body)
      do n = 1, 2*size(groups)
         i = 1 + mod(n - 1, size(groups))
         ! Regulators act by wheels, wherever these stand in the scene.
         if ((groups(i)%name == 'regulator') .neqv. n > size(groups)) cycle
         do k = 1, size(kinds)
            if (kinds(k)%group%name /= groups(i)%name) cycle
            if (present(folder)) then
               call read_torque_table(groups(i), folder, error)
            else
               call read_torque_table(groups(i), '', error)
            end if
            if (error%raised) return
            call kinds(k)%build(groups(i), body, effect, status)
            if (status%ok()) call check_strength(effect, status)
            if (.not. status%ok()) then
               call error%take(groups(i)%line_of(trim(status%subject)), status)
               return
            end if
            call take_switch(groups(i), effect, error)
            if (error%raised) return
            call take_effect(system, effect, status)
            if (.not. status%ok()) call error%take(groups(i)%line_of(trim(status%subject)), status)
            if (error%raised) return
         end do
      end do
   end subroutine build_effects

   !> The name by which switches call an effect, and whether it is on at the start.
   subroutine take_switch(group, effect, error)
      type(group_t), intent(in) :: group
      class(effect_t), intent(inout) :: effect
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: name
      name = trim(group%text('name', ''))
      if (len(name) > len(effect%label)) call error%raise(group%line_of('name'), 'name is too long', &
                                                          expected='at most 24 characters')
      if (group%has('name') .and. name == '') call error%raise(group%line_of('name'), 'name is blank', &
                                                               expected='a name for the effect')
      effect%label = name
      effect%on = group%flag('on', .true.)
   end subroutine take_switch

   !> Adds an effect. A rotor or a rotating frame that is off, which cannot be switched, is not there then. Errors:
   !> those of `add_wheel` and `add_regulator`.
   subroutine take_effect(system, effect, status)
      type(system_t), intent(inout) :: system
      class(effect_t), intent(in) :: effect
      type(status_t), intent(out) :: status
      select type (effect)
      class is (rotor_t)
         if (effect%on) call system%effects%add(effect)
      class is (rotating_frame_t)
         if (effect%on) call system%effects%add(effect)
      type is (wheel_t)
         call add_wheel(system, effect, status)
      type is (regulator_t)
         call add_regulator(system, effect, status)
      class default
         call system%effects%add(effect)
      end select
   end subroutine take_effect

end module nutate_scene_effects
