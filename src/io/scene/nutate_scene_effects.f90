!> The effects of a scene: every group that is not one of its fixed parts.
module nutate_scene_effects
   use nutate_effect, only: effect_t
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: potential_energy, potential_torque
   use nutate_keys, only: group_t, group_kind_t
   use nutate_kinds, only: wp
   use nutate_scene_error, only: scene_error_t
   use nutate_status, only: status_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: add_effect_kinds, build_effects

   !> Bound of an effect's energy (J) and torque (N m) at the start: their squares stay finite.
   real(wp), parameter :: greatest = 1e100_wp

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

   !> Adds the effects that the groups name, in their order, to a system.
   subroutine build_effects(groups, q, omega, system, error)
      type(group_t), intent(in) :: groups(:)
      !> Attitude at the start, body→space; shape (4).
      real(wp), intent(in) :: q(4)
      !> Ω at the start, body axes, rad/s; shape (3).
      real(wp), intent(in) :: omega(3)
      !> Its body is used, its effects are added.
      type(system_t), intent(inout) :: system
      type(scene_error_t), intent(inout) :: error
      type(effect_kind_t), allocatable :: kinds(:)
      class(effect_t), allocatable :: effect
      type(status_t) :: status
      integer :: i, k

      kinds = effect_kinds()
      do i = 1, size(groups)
         do k = 1, size(kinds)
            if (kinds(k)%group%name /= groups(i)%name) cycle
            call kinds(k)%build(groups(i), system%body, effect, status)
            if (.not. status%ok()) then
               call error%raise(groups(i)%line_of(trim(status%subject)), trim(status%message))
            else
               call check_strength(groups(i), effect, q, omega, error)
            end if
            if (error%raised) return
            call system%effects%add(effect)
         end do
      end do
   end subroutine build_effects

   !> Raises an error for an effect whose energy or torque is beyond all scales.
   subroutine check_strength(group, effect, q, omega, error)
      type(group_t), intent(in) :: group
      class(effect_t), intent(in) :: effect
      real(wp), intent(in) :: q(4), omega(3)
      type(scene_error_t), intent(inout) :: error
      type(effect_list_t) :: alone
      real(wp) :: torque(3)
      integer :: i

      if (.not. effect%in_range()) then
         call error%raise(group%line, '&'//trim(group%name)//' is beyond all scales', &
                          expected='energy and torque below 1e100 in SI units')
         return
      end if
      call alone%add(effect)
      torque = potential_torque(alone, q)
      do i = 1, alone%n_torques
         torque = torque + alone%torques(i)%item%torque(0.0_wp, q, omega)
      end do
      if (abs(potential_energy(alone, q)) > greatest .or. any(abs(torque) > greatest)) &
         call error%raise(group%line, '&'//trim(group%name)//' is beyond all scales', &
                          expected='energy and torque below 1e100 in SI units')
   end subroutine check_strength

end module nutate_scene_effects
