!> `&fit`: initial guesses of a fit; builds the fit of a scene from its free parameters and its measurements.
module nutate_scene_fit
   use nutate_admissible, only: NON_NEGATIVE
   use nutate_fit_plan, only: fit_plan_t, is_drawn
   use nutate_keys, only: group_t, group_kind_t, key_t, KEY_INTEGER, KEY_TEXT
   use nutate_kinds, only: wp
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_free, only: add_free, prepare_attitude
   use nutate_scene_labels, only: labels_t
   use nutate_scene_measurement, only: build_measurement
   use nutate_state, only: state_t
   use nutate_system, only: system_t
   implicit none
   private

   public :: fit_keys, build_fit

contains

   !> Keys of the scene group `&fit`.
   pure function fit_keys() result(keys)
      type(key_t) :: keys(4)
      keys = [key_t(name='starts', kind=KEY_INTEGER, range=NON_NEGATIVE), &
              key_t(name='seed', kind=KEY_INTEGER, range=NON_NEGATIVE), &
              key_t(name='arcs', kind=KEY_TEXT, choices='growing,whole'), &
              key_t(name='start', kind=KEY_TEXT, choices='data,scene')]
   end function fit_keys

   !> Builds the fit of a scene; none if it has no groups `&free` or `&measurement`.
   subroutine build_fit(groups, kinds, path, labels, system, initial, end_time, plan, error)
      !> Groups that have been checked and built as a scene.
      type(group_t), intent(in) :: groups(:)
      type(group_kind_t), intent(in) :: kinds(:)
      !> Path of the scene.
      character(len=*), intent(in) :: path
      type(labels_t), intent(in) :: labels
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: initial
      !> End time, s.
      real(wp), intent(in) :: end_time
      type(fit_plan_t), intent(inout) :: plan
      type(scene_error_t), intent(inout) :: error
      integer :: i, n

      if (.not. any(groups%name == 'free' .or. groups%name == 'measurement')) return
      allocate (plan%free(0), plan%measurements(count(groups%name == 'measurement')))
      n = 0
      plan%numbers%groups = groups
      allocate (plan%numbers%targets(0))
      call prepare_attitude(groups, system, initial, plan, error)
      do i = 1, size(groups)
         if (error%raised) return
         select case (groups(i)%name)
         case ('free')
            call add_free(groups(i), groups, kinds, plan, error)
         case ('measurement')
            n = n + 1
            call build_measurement(groups(i), system%effects, end_time, path, labels, &
                                   plan%measurements(n), error)
         case ('fit')
            plan%starts = groups(i)%whole('starts', 0)
            plan%seed = groups(i)%whole('seed', 0)
            plan%grows = groups(i)%text('arcs', 'growing') == 'growing'
            plan%starts_from_data = groups(i)%text('start', 'data') == 'data'
         case default
            continue
         end select
      end do
      if (.not. error%raised) call check_sigmas(groups, plan, error)
      if (.not. error%raised) call check_starts(groups, plan, error)
   end subroutine build_fit

   !> Raises an error for random initial guesses that would all be equal.
   subroutine check_starts(groups, plan, error)
      type(group_t), intent(in) :: groups(:)
      type(fit_plan_t), intent(in) :: plan
      type(scene_error_t), intent(inout) :: error
      integer :: i
      if (plan%starts == 0 .or. any(is_drawn(plan%free))) return
      i = findloc(groups%name == 'fit', .true., dim=1)
      call error%raise(groups(i)%line_of('starts'), 'random starts have nothing to draw', &
                       expected='free moments body.inertia, or &free with low and high, or with sigma')
   end subroutine check_starts

   !> Raises an error if some standard deviations are known and others are not.
   subroutine check_sigmas(groups, plan, error)
      type(group_t), intent(in) :: groups(:)
      type(fit_plan_t), intent(in) :: plan
      type(scene_error_t), intent(inout) :: error
      integer :: i
      if (size(plan%measurements) == 0) return
      associate (known => plan%measurements%sigma_is_known)
         if (all(known) .or. .not. any(known)) return
         i = findloc(groups%name == 'measurement' .and. .not. [(groups(i)%has('sigma'), i=1, size(groups))], &
            .true., dim=1)
         call error%raise(groups(i)%line, 'sigma is missing here and given in another &measurement', &
                          expected='it in all of them, or in none')
      end associate
   end subroutine check_sigmas

end module nutate_scene_fit
