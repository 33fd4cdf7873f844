!> Settings of a C program's stepper: the keys of `&integrator`, one by one, and the method for them.
module nutate_c_settings
   use nutate_c_effects, only: add_failure
   use nutate_c_stepper_handle, only: lacks_attitude, left_out, stepper_handle_t, unprepare
   use nutate_c_text, only: lock_texts, unlock_texts
   use nutate_method_choice, only: choose_settings
   use nutate_columns, only: need_attitude
   use nutate_hamiltonian, only: conserved_energy
   use nutate_keys, only: group_t, group_kind_t
   use nutate_kinds, only: wp
   use nutate_methods, only: make_stepper
   use nutate_scene_error, only: scene_error_t
   use nutate_scene_integrator, only: build_integrator, integrator_keys
   use nutate_scene_override, only: apply_override
   use nutate_scene_values, only: check_values
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   implicit none
   private

   public :: set_key, set_number, get_key, prepare, prepare_if_needed

contains

   !> Sets a setting of `&integrator`. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine set_key(handle, key, value, status)
      type(stepper_handle_t), intent(inout) :: handle
      character(len=*), intent(in) :: key
      !> Value as in a scene; a string without its quotes.
      character(len=*), intent(in) :: value
      type(status_t), intent(out) :: status
      type(group_kind_t) :: kinds(1)
      type(group_t), allocatable :: groups(:)
      type(scene_error_t) :: error
      if (key == 'end_time') then
         status = fail(NUTATE_BAD_ARGUMENT, 'end_time is an argument of nutate_stepper_run_to', 'end_time')
         return
      end if
      kinds(1)%name = 'integrator'
      kinds(1)%keys = integrator_keys()
      allocate (groups(1))
      groups(1) = handle%group
      call drop_others(groups(1), key)
      call lock_texts()
      call apply_override('integrator.'//key//'='//value, kinds, groups, error)
      call unlock_texts()
      call keep_group(handle, groups(1), key, error, status)
   end subroutine set_key

   !> Sets a setting of `&integrator` that is one real number. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine set_number(handle, key, number, status)
      type(stepper_handle_t), intent(inout) :: handle
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: number
      type(status_t), intent(out) :: status
      type(group_t) :: group
      type(scene_error_t) :: error
      group = handle%group
      call drop_others(group, key)
      call group%put(key, [number])
      call check_values(group, integrator_keys(), error)
      call keep_group(handle, group, key, error, status)
   end subroutine set_number

   !> Removes the keys that a key replaces: each way to set the length of steps replaces the others.
   subroutine drop_others(group, key)
      type(group_t), intent(inout) :: group
      character(len=*), intent(in) :: key
      character(len=*), parameter :: ways(3) = [character(len=15) :: 'time_step', 'accuracy', 'local_tolerance']
      integer :: i
      do i = 1, size(ways)
         if (any(ways == key)) call group%drop(trim(ways(i)))
      end do
   end subroutine drop_others

   !> Keeps a group in which a key was set, unless its value was rejected.
   subroutine keep_group(handle, group, key, error, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      type(scene_error_t), intent(in) :: error
      type(status_t), intent(out) :: status
      if (error%raised) then
         status = fail(NUTATE_BAD_ARGUMENT, error%text, key)
         handle%text = error%text
         return
      end if
      if (key == 'accuracy' .and. lacks_attitude(handle)) then
         status = fail(NUTATE_BAD_ARGUMENT, left_out//' (expected accuracy before the first step, or a new state)', key)
         return
      end if
      handle%group = group
      handle%stale = .true.
      handle%is_valid = .false.
      call unprepare(handle)
   end subroutine keep_group

   !> Returns the value in force for a key of `&integrator`: the one that was set, or else the one that was chosen.
   !> Errors: those of `prepare`; `NUTATE_BAD_ARGUMENT` for a key that is not known here.
   subroutine get_key(handle, key, value, status)
      type(stepper_handle_t), intent(inout) :: handle
      character(len=*), intent(in) :: key
      !> Value as in a scene; a string without its quotes.
      character(len=*), intent(out) :: value
      type(status_t), intent(out) :: status
      value = ''
      call prepare_if_needed(handle, status)
      if (.not. status%ok()) return
      associate (settings => handle%run%summary%settings, plan => handle%plan)
         select case (key)
         case ('method')
            value = settings%method
         case ('choice')
            value = handle%run%summary%choice
         case ('formulation')
            value = settings%formulation
         case ('order')
            write (value, '(i0)') settings%order
         case ('series_order')
            write (value, '(i0)') settings%series_order
         case ('conserve')
            value = merge('.true. ', '.false.', settings%conserve)
         case ('time_step')
            write (value, '(es24.16e3)') merge(0.0_wp, plan%time_step, plan%goal%active())
         case ('accuracy')
            write (value, '(es24.16e3)') plan%goal%accuracy
         case ('local_tolerance')
            write (value, '(es24.16e3)') merge(handle%run%plan%goal%local_tolerance, plan%goal%local_tolerance, &
                                               plan%goal%accuracy > 0.0_wp)
         case default
            status = fail(NUTATE_BAD_ARGUMENT, 'key is none of method, choice, formulation, order, series_order, '// &
                          'conserve, time_step, accuracy, local_tolerance', 'key')
         end select
      end associate
      value = adjustl(value)
   end subroutine get_key

   !> Prepares the method of the settings, or the one that is chosen for them. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine prepare(handle, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(status_t), intent(out) :: status
      character(len=len(handle%run%summary%choice)) :: choice
      !> The stepper is there, and has only to begin anew.
      logical :: again
      call unprepare(handle)
      ! Runs with adaptive steps choose a method by their start.
      again = handle%is_valid .and. .not. (handle%stale .or. handle%plan%goal%active()) .and. &
              allocated(handle%run%spare)
      if (again) again = handle%run%spare%keeps_system .and. &
                         (handle%run%spare%prepared_with%attitude .eqv. handle%run%requested%attitude)
      if (handle%stale) call read_settings(handle, status)
      if (.not. status%ok()) return
      associate (run => handle%run, goal => handle%plan%goal)
         if (.not. handle%is_valid) run%requested%attitude = run%requested%attitude .or. goal%accuracy > 0.0_wp .or. &
            handle%system%effects%needs_attitude() .or. need_attitude(handle%sets)
         run%summary%settings%attitude = run%requested%attitude
         if (allocated(run%spare)) call move_alloc(run%spare, run%stepper)
         if (again) then
            call run%stepper%prepare(handle%system, run%summary%settings, status)
            if (.not. status%ok()) deallocate (run%stepper)
         else
            ! The choice of a run stays. Otherwise the duration of runs is not known yet.
            call choose_settings(handle%system, run%state, 0.0_wp, goal%accuracy, goal%local_tolerance, &
                                 run%summary%settings, choice, status)
            if (choice /= '') run%summary%choice = choice
            if (status%ok()) call make_stepper(handle%system, run%summary%settings, run%stepper, status)
         end if
         if (status%ok() .and. run%keeps_dense_output) call run%stepper%keep_steps()
      end associate
      if (.not. status%ok()) return
      handle%stale = .false.
      handle%is_valid = .true.
      handle%tested_dt = 0.0_wp
   end subroutine prepare

   !> Prepares the method, unless that has been done. Errors: those of `prepare`.
   subroutine prepare_if_needed(handle, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(status_t), intent(out) :: status
      if (.not. allocated(handle%run%stepper)) call prepare(handle, status)
   end subroutine prepare_if_needed

   !> Reads settings, nominal step and goal from the group. Errors: `NUTATE_BAD_ARGUMENT`.
   subroutine read_settings(handle, status)
      type(stepper_handle_t), intent(inout) :: handle
      type(status_t), intent(inout) :: status
      type(group_t) :: group
      type(scene_error_t) :: error
      logical :: has_length, attitude

      group = handle%group
      has_length = group%has('time_step') .or. group%has('accuracy') .or. group%has('local_tolerance')
      call group%drop('end_time')
      ! `build_integrator` requires a complete group.
      if (.not. has_length) call group%put('time_step', [1.0_wp])
      call group%put('end_time', [group%number('time_step', 1.0_wp)])
      attitude = handle%run%requested%attitude
      call lock_texts()
      call build_integrator(group, handle%run%requested, handle%plan, error)
      call unlock_texts()
      if (error%raised) then
         status = fail(NUTATE_BAD_ARGUMENT, error%text)
         return
      end if
      if (.not. has_length) handle%plan%time_step = 0.0_wp
      handle%run%requested%attitude = attitude
      handle%run%summary%settings = handle%run%requested
      handle%run%summary%choice = ''
      ! The energy depends on the auxiliary inertia.
      handle%failure = 0
      associate (inverse_j0 => handle%run%requested%inverse_auxiliary_inertia)
         handle%first_energy = conserved_energy(handle%system, handle%first%state(), inverse_j0)
         call handle%columns%start(handle%system, handle%first%state(), inverse_j0, handle%plan%time_step < 0.0_wp)
      end associate
      if (handle%columns%follows_steps) call handle%columns%follow(handle%run%state)
      call add_failure(handle%failure, status)
   end subroutine read_settings

end module nutate_c_settings
