!> Sensitivities that a run of a scene propagates: one for each number that `&free` names.
module nutate_free_variations
   use nutate_variation, only: variation_t
   use nutate_fit_model, only: fit_model_t
   use nutate_keys, only: group_t, name_length
   use nutate_kinds, only: wp
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_scene, only: scene_t
   use nutate_scene_error, only: scene_error_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tangent, only: tangent_t
   use nutate_propagated_columns, only: is_by_free
   use nutate_quantities, only: quantities, set_of
   implicit none
   private

   public :: free_variations, shows_propagated, shows_derivatives, shows_indicators, usual_sets

   !> Step that shows whether a method propagates sensitivities, as a part of the run.
   real(wp), parameter :: short = 1e-9_wp

contains

   !> Returns the sets of columns of a scene. Derivatives are added to its default sets if it has free parameters but no
   !> measurements, since a fit has another purpose.
   pure function usual_sets(scene) result(sets)
      type(scene_t), intent(in) :: scene
      character(len=name_length), allocatable :: sets(:)
      integer :: i
      sets = scene%output%columns
      if (.not. any(scene%groups%name == 'free') .or. any(scene%groups%name == 'measurement')) return
      i = findloc(scene%groups%name == 'output', .true., dim=1)
      if (i > 0) then
         if (scene%groups(i)%has('columns')) return
      end if
      sets = [character(len=name_length) :: sets, 'sensitivities']
      if (any(scene%fit%free%sigma > 0.0_wp)) sets = [character(len=name_length) :: sets, 'standard_deviations']
   end function usual_sets

   !> Returns true if sets of columns are derivatives with respect to free parameters.
   pure logical function shows_derivatives(sets)
      !> Names of the sets.
      character(len=*), intent(in) :: sets(:)
      integer :: i
      shows_derivatives = .false.
      do i = 1, size(quantities)
         if (is_by_free(quantities(i)%propagated)) shows_derivatives = shows_derivatives .or. &
            any(sets == set_of(quantities(i)))
      end do
   end function shows_derivatives

   !> Returns true if runs propagate sets of columns: derivatives with respect to free parameters, or chaos indicators.
   pure logical function shows_propagated(sets)
      !> Names of the sets.
      character(len=*), intent(in) :: sets(:)
      shows_propagated = shows_derivatives(sets) .or. shows_indicators(sets)
   end function shows_propagated

   !> Returns true if sets of columns are chaos indicators.
   pure logical function shows_indicators(sets)
      !> Names of the sets.
      character(len=*), intent(in) :: sets(:)
      integer :: i
      shows_indicators = any([(any(sets == set_of(quantities(i))) .and. quantities(i)%propagated > 0 .and. &
                               .not. is_by_free(quantities(i)%propagated), i=1, size(quantities))])
   end function shows_indicators

   !> Makes the sensitivities of the free parameters of a scene. Raises an error, with its line, for what has no
   !> derivative: a number, a controller with samples, a method.
   subroutine free_variations(scene, variations, error, settings)
      !> Scene with free parameters.
      type(scene_t), intent(in) :: scene
      !> Shape (free parameters).
      type(variation_t), allocatable, intent(out) :: variations(:)
      type(scene_error_t), intent(inout) :: error
      !> Settings of the run, complete; without them the run reports what its method does not propagate.
      type(integrator_settings_t), intent(in), optional :: settings
      type(fit_model_t) :: model
      type(status_t) :: status
      integer :: i
      call check_groups(scene%groups, error)
      if (error%raised) return
      call model%begin(scene)
      allocate (variations(size(scene%fit%free)))
      do i = 1, size(variations)
         call model%variation_of(i, variations(i), status)
         if (.not. status%ok()) call error%raise_status(scene%fit%free(i)%line, status)
         if (error%raised) return
      end do
      if (present(settings)) call try_method(scene, settings, variations, error)
   end subroutine free_variations

   !> Raises an error for a controller that samples: the values that it holds have no derivative.
   subroutine check_groups(groups, error)
      type(group_t), intent(in) :: groups(:)
      type(scene_error_t), intent(inout) :: error
      integer :: i
      do i = 1, size(groups)
         if (groups(i)%name == 'controller' .and. groups(i)%has('sample')) &
            call error%raise(groups(i)%line_of('sample'), 'a controller that samples has no derivative', &
                             expected='no sample, or columns without derivatives')
      end do
   end subroutine check_groups

   !> Raises an error if the method does not propagate the sensitivities, which a first short step shows.
   subroutine try_method(scene, settings, variations, error)
      type(scene_t), intent(in) :: scene
      type(integrator_settings_t), intent(in) :: settings
      type(variation_t), intent(in) :: variations(:)
      type(scene_error_t), intent(inout) :: error
      class(stepper_t), allocatable :: stepper
      type(integrator_settings_t) :: with_sensitivities
      type(tangent_t) :: tangent
      type(state_t) :: state
      type(status_t) :: status
      real(wp) :: dt, middle
      integer :: i
      dt = short*(scene%plan%end_time - scene%initial%t)
      middle = scene%initial%t + 0.5_wp*dt
      state = scene%initial
      call tangent%begin(scene%system, state, variations, status)
      if (status%ok()) then
         with_sensitivities = settings
         with_sensitivities%in_space_axes = any([(variations(i)%changes_orbit(), i=1, size(variations))])
         call make_stepper(scene%system, with_sensitivities, stepper, status)
         if (status%ok()) call stepper%advance(scene%system, state, dt, middle, status)
         ! The run itself reports a step that fails.
         if (.not. status%ok()) return
         call stepper%propagate(scene%system, scene%initial, state, dt, middle, tangent, status)
      end if
      i = findloc(scene%groups%name == 'integrator', .true., dim=1)
      if (.not. status%ok()) call error%raise_status(scene%groups(i)%line_of('method'), status)
   end subroutine try_method

end module nutate_free_variations
