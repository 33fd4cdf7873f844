!> Reads scenes and builds their parts, using the modules of the parts.
submodule(nutate_scene) nutate_scene_building
   use nutate_columns, only: columns_t, need_attitude
   use nutate_control, only: beyond_accuracy, needs_control
   use nutate_decimal, only: rounded_text
   use nutate_hamiltonian, only: make_state
   use nutate_keys, only: first_group, name_length
   use nutate_kinds, only: wp
   use nutate_moving_frame, only: moving_frame_t
   use nutate_printable, only: printable_path
   use nutate_scene_body, only: body_keys, build_body, rebuild_body
   use nutate_scene_check, only: check_complete, read_groups
   use nutate_scene_effects, only: add_effect_kinds, build_effects
   use nutate_scene_ensemble, only: build_ensemble, ensemble_keys
   use nutate_scene_error, only: error_line
   use nutate_scene_events, only: build_events, event_keys, events_need_attitude
   use nutate_scene_fit, only: build_fit, fit_keys
   use nutate_scene_frame, only: build_frames, check_frames, frame_keys
   use nutate_scene_free, only: free_keys
   use nutate_scene_initial, only: initial_keys, build_initial, rebuild_initial, check_initial
   use nutate_scene_integrator, only: integrator_keys, build_integrator
   use nutate_scene_labels, only: build_labels, check_calendar, label_keys
   use nutate_scene_measurement, only: measurement_keys
   use nutate_scene_output, only: output_keys, build_output
   use nutate_scene_override, only: apply_override
   use nutate_scene_table, only: read_effect_table, read_table, time_units
   use nutate_scene_chaos, only: build_chaos, check_chaos, chaos_keys
   use nutate_scene_vary, only: vary_keys
   use nutate_spelling, only: lower_case
   use nutate_status, only: fail, NUTATE_BAD_SCENE, NUTATE_IO
   use nutate_text_file, only: read_text_file
   use nutate_track, only: track_contains
   use nutate_varying_inertia, only: check_change
   implicit none

   !> Groups that are not effects.
   character(len=name_length), parameter :: fixed_parts(13) = [character(len=name_length) :: &
      'scene', 'body', 'initial', 'integrator', 'output', 'event', 'ensemble', 'vary', 'free', 'measurement', 'fit', &
      'chaos', 'frame']
   !> Parts of a scene, each including those before it: initial state, body without effects, body and effects,
   !> everything.
   integer, parameter :: ITS_START = 1, ITS_BODY = 2, ITS_MOTION = 3, ALL_OF_IT = 4

contains

   module procedure read_scene
      character(len=:), allocatable :: text, reason

      call read_text_file(path, text, reason)
      if (reason /= '') then
         message = printable_path(path)//': cannot be read ('//reason//')'
         status = fail(NUTATE_IO, message)
         return
      end if
      ! An absent argument is not passed on: gfortran 12 would compute with its missing bounds.
      if (present(overrides)) then
         call parse_scene(text, path, scene, status, message, overrides)
      else
         call parse_scene(text, path, scene, status, message)
      end if
   end procedure read_scene

   module procedure parse_scene
      type(group_kind_t), allocatable :: kinds(:)
      type(scene_error_t) :: error
      integer :: i, last_line

      kinds = scene_kinds()
      call read_groups(text, kinds, scene%groups, last_line, error)
      if (present(overrides)) then
         do i = 1, size(overrides)
            call apply_override(trim(overrides(i)), kinds, scene%groups, error)
         end do
      end if
      call check_complete(kinds, scene%groups, last_line, error)
      if (.not. error%raised) call build_scene(path, scene, error)
      if (.not. error%raised) &
         call build_ensemble(scene%groups, kinds, scene%name, path, scene%ensemble, error)
      if (.not. error%raised) &
         call build_fit(scene%groups, kinds, path, scene%labels, scene%system, scene%initial, scene%plan%end_time, &
                        scene%fit, error)
      if (.not. error%raised .and. scene%chaos%exponents > 0) &
         call check_chaos(first_group(scene%groups, 'chaos'), scene%system, scene%initial, scene%plan, &
                            scene%integrator, error)
      message = ''
      if (.not. error%raised) return
      message = error_line(path, error)
      status = fail(NUTATE_BAD_SCENE, message)
   end procedure parse_scene

   module procedure scene_kinds
      integer, parameter :: parts = size(fixed_parts)

      call add_effect_kinds(parts, kinds)
      kinds(1:parts)%name = fixed_parts
      kinds(1)%keys = label_keys
      kinds(2)%keys = body_keys()
      kinds(3)%keys = initial_keys
      kinds(4)%keys = integrator_keys()
      kinds(5)%keys = output_keys()
      kinds(6)%keys = event_keys()
      kinds(7)%keys = ensemble_keys()
      kinds(8)%keys = vary_keys()
      kinds(9)%keys = free_keys()
      kinds(10)%keys = measurement_keys()
      kinds(11)%keys = fit_keys()
      kinds(12)%keys = chaos_keys()
      kinds(13)%keys = frame_keys
      kinds([6, 8, 9, 10, 13])%repeatable = .true.
      kinds(2:4)%required = .true.
   end procedure scene_kinds

   !> Raises an error if the closed solution of a free body is requested and the body is not free.
   subroutine check_free(effects, integrator, error)
      type(effect_list_t), intent(in) :: effects
      !> The group `&integrator`.
      type(group_t), intent(in) :: integrator
      type(scene_error_t), intent(inout) :: error
      if (effects%varies) then
         call error%raise(integrator%line_of('method'), "method 'exact' has no solution for an inertia that varies", &
                          expected='another method')
      else if (effects%n_potentials + effects%n_off + effects%n_torques + effects%n_rotors > 0 .or. &
               effects%frame_turns) then
         call error%raise( &
            integrator%line_of('method'), "method 'exact' solves free bodies only", expected='no effects with it')
      end if
   end subroutine check_free

   !> Builds the parts from groups that have been checked one by one.
   subroutine build_scene(path, scene, error)
      character(len=*), intent(in) :: path
      type(scene_t), intent(inout) :: scene
      type(scene_error_t), intent(inout) :: error
      type(group_t) :: group

      scene%file = path
      scene%name = scene_name(path)
      group = first_group(scene%groups, 'scene')
      scene%title = group%text('title', scene%name)
      call build_labels(group, scene%labels, error)
      if (error%raised) return
      call build_motion(scene, error)
      if (error%raised) return
      call build_integrator(first_group(scene%groups, 'integrator'), scene%integrator, scene%plan, error)
      if (.not. error%raised) call check_calendar(scene%labels, group, scene%plan%end_time, error)
      if (error%raised) return
      call check_motion_with_steps(scene, error)
      if (error%raised) return
      call read_times(scene%groups, path, error)
      call build_output(first_group(scene%groups, 'output'), scene%name, path, scene%plan, scene%output, error)
      if (error%raised) return
      if (.not. error%raised) call give_calendar(first_group(scene%groups, 'output'), scene, error)
      if (error%raised) return
      call check_columns(first_group(scene%groups, 'output'), scene, error)
      call build_events(scene%groups, scene%system%effects, scene%plan%goal%accuracy, scene%events, error)
      if (error%raised) return
      call find_need_of_attitude(scene)
      if (place_of(scene%groups, 'chaos') > 0) &
         call build_chaos(first_group(scene%groups, 'chaos'), scene%plan, scene%chaos, scene%integrator, error)
   end subroutine build_scene

   !> Gives the output its epoch if it has dates. Raises an error if there is no epoch.
   subroutine give_calendar(group, scene, error)
      !> The group `&output`.
      type(group_t), intent(in) :: group
      type(scene_t), intent(inout) :: scene
      type(scene_error_t), intent(inout) :: error
      if (.not. group%flag('calendar', .false.)) return
      scene%output%epoch = scene%labels%epoch
      if (.not. scene%labels%epoch%is_set()) &
         call error%raise(group%line_of('calendar'), 'calendar needs the date of t = 0', expected='epoch in &scene')
   end subroutine give_calendar

   !> Builds body, effects, frames and the initial state.
   subroutine build_motion(scene, error)
      type(scene_t), intent(inout) :: scene
      type(scene_error_t), intent(inout) :: error
      real(wp) :: q(4), omega(3)
      character(len=:), allocatable :: folder
      folder = scene%file(1:index(scene%file, '/', back=.true.))
      call read_effect_table(scene%groups(place_of(scene%groups, 'body')), folder, error)
      if (error%raised) return
      call build_body(first_group(scene%groups, 'body'), scene%system%body, scene%shape, error)
      if (error%raised) return
      if (.not. allocated(scene%nominal)) scene%nominal = scene%system%body
      call build_effects(scene%groups, scene%system, error, folder, scene%nominal)
      if (error%raised) return
      associate (effects => scene%system%effects)
         scene%named_potentials = effects%n_potentials + effects%n_off
         scene%named_torques = effects%n_torques
         call effects%append(scene%added)
         call build_frames(scene%groups, scene%labels, scene%file, effects, error)
      end associate
      if (error%raised) return
      call build_initial(first_group(scene%groups, 'initial'), scene%system, q, omega, scene%periodic, error)
      if (.not. error%raised) scene%initial = make_state(scene%system, q, omega)
   end subroutine build_motion

   !> Raises an error for a motion or initial state that the method, the steps or the goal do not admit.
   subroutine check_motion_with_steps(scene, error)
      type(scene_t), intent(in) :: scene
      type(scene_error_t), intent(inout) :: error
      associate (groups => scene%groups, effects => scene%system%effects)
         associate (integrator => groups(place_of(groups, 'integrator')))
            if (scene%plan%goal%accuracy > 0.0_wp .and. needs_control(effects)) &
               call error%raise(integrator%line_of('accuracy'), beyond_accuracy(effects, .false.), &
                                expected='time_step or local_tolerance')
            if (error%raised) return
            call check_tables(groups, effects, scene%plan, integrator, error)
            call check_varying(groups, scene%system, scene%plan, integrator, error)
            call check_frames(groups, effects, scene%plan, error)
            if (scene%integrator%method == 'exact') call check_free(effects, integrator, error)
            call check_initial(scene%system, scene%initial, scene%plan, groups(place_of(groups, 'initial')), &
                               integrator, error)
         end associate
      end associate
   end subroutine check_motion_with_steps

   !> Raises an error for an inertia that no body has at a time of the run, for a run that goes beyond a table of the
   !> body, and for a centre of mass that moves without an effect.
   subroutine check_varying(groups, system, plan, integrator, error)
      type(group_t), intent(in) :: groups(:)
      type(system_t), intent(in) :: system
      type(run_plan_t), intent(in) :: plan
      !> The group `&integrator`.
      type(group_t), intent(in) :: integrator
      type(scene_error_t), intent(inout) :: error
      type(status_t) :: status
      integer :: i
      if (error%raised) return
      associate (body => groups(place_of(groups, 'body')))
         if (system%effects%moves_center .and. .not. weighs(system%effects)) call error%raise( &
            body%line_of('center_of_mass_table'), 'nothing in the scene depends on the centre of mass', &
            expected='&gravity with center_of_mass_table')
         if (error%raised) return
         call check_change(system, 0.0_wp, plan%end_time, status)
         if (status%ok()) return
         i = place_of(groups, 'inertia_rate')
         if (status%subject == 'end_time') then
            call error%raise_status(integrator%line_of('end_time'), status)
         else if (i > 0) then
            call error%raise_status(groups(i)%line_of('tensor'), status)
         else
            call error%raise_status(body%line_of('inertia_table'), status)
         end if
      end associate
   end subroutine check_varying

   !> Returns true if a potential, on or off, depends on the centre of mass.
   pure logical function weighs(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      weighs = any([(abs(effects%potentials(i)%item%by_center) > 0.0_wp, i=1, effects%n_potentials + effects%n_off)])
   end function weighs

   !> Raises an error for a run that goes beyond the table of an orbit.
   subroutine check_tables(groups, effects, plan, integrator, error)
      type(group_t), intent(in) :: groups(:)
      type(effect_list_t), intent(in) :: effects
      type(run_plan_t), intent(in) :: plan
      !> The group `&integrator`.
      type(group_t), intent(in) :: integrator
      type(scene_error_t), intent(inout) :: error
      character(len=:), allocatable :: range
      integer :: i
      if (.not. effects%on_orbit) return
      do i = 1, size(effects%orbits)
         if (.not. allocated(effects%orbits(i)%path%track)) cycle
         associate (track => effects%orbits(i)%path%track)
            range = rounded_text(track%curve%x(0))//' to '//rounded_text(track%curve%x(track%curve%n))//' s'
            if (.not. track_contains(track, 0.0_wp)) call error%raise( &
               line_of_table(effects%orbits(i)%label), 'the table of &orbit goes from '//range, &
               expected='one that contains t = 0')
            if (.not. track_contains(track, plan%end_time)) call error%raise(integrator%line_of('end_time'), &
               'end_time is outside of the table of &orbit', expected=range)
         end associate
      end do

   contains

      !> Returns the line of the key `table` of an orbit.
      pure integer function line_of_table(label) result(line)
         character(len=*), intent(in) :: label
         integer :: k
         line = 0
         do k = 1, size(groups)
            if (groups(k)%name == 'orbit' .and. groups(k)%has('table') .and. groups(k)%text('name', '') == label) &
               line = groups(k)%line_of('table')
         end do
      end function line_of_table

   end subroutine check_tables

   !> Determines if the attitude must be integrated. An accuracy is one of the attitude.
   subroutine find_need_of_attitude(scene)
      type(scene_t), intent(inout) :: scene
      scene%integrator%attitude = scene%system%effects%needs_attitude() .or. scene%plan%goal%accuracy > 0.0_wp .or. &
                                  scene%added%n_torques > 0 .or. need_attitude(scene%output%columns) .or. &
                                  events_need_attitude(scene%groups) .or. scene%chaos%exponents > 0
   end subroutine find_need_of_attitude

   module procedure changed_part
      character(len=name_length), parameter :: steps_and_rows(3) = [character(len=name_length) :: &
                                                                    'integrator', 'output', 'event']
      integer :: i
      logical :: is_free
      is_free = .true.
      part = ITS_START
      do i = 1, size(groups)
         if (all(groups(i)%name /= fixed_parts) .or. groups(i)%has('inertia_table')) is_free = .false.
         if (.not. changed(i) .or. groups(i)%name == 'initial') cycle
         part = max(part, ITS_BODY)
         if (groups(i)%name /= 'body') part = max(part, ITS_MOTION)
         if (any(groups(i)%name == steps_and_rows)) part = ALL_OF_IT
      end do
      if (part == ITS_BODY .and. .not. is_free) part = ITS_MOTION
   end procedure changed_part

   module procedure keep_added
      integer :: place, i
      associate (effects => scene%system%effects)
         do place = scene%named_potentials + 1, effects%n_potentials + effects%n_off
            do i = 1, effects%n_potentials + effects%n_off
               if (effects%potentials(i)%place == place) call scene%added%add(effects%potentials(i)%item)
            end do
         end do
         do i = scene%named_torques + 1, effects%n_torques
            call scene%added%add(effects%torques(i)%item)
         end do
      end associate
   end procedure keep_added

   module procedure rebuild_scene
      character(len=:), allocatable :: path
      select case (part)
      case (ALL_OF_IT)
         path = scene%file
         call forget_system(scene%system)
         call forget_run(scene%events, scene%plan, scene%output)
         call build_scene(path, scene, error)
      case (ITS_MOTION)
         call forget_system(scene%system)
         call build_motion(scene, error)
         if (.not. error%raised) call check_motion_with_steps(scene, error)
         if (.not. error%raised) call find_need_of_attitude(scene)
      case default
         call rebuild_free_motion(scene, part, error)
      end select
   end procedure rebuild_scene

   !> Rebuilds the initial state and, for `ITS_BODY`, a body without effects.
   subroutine rebuild_free_motion(scene, part, error)
      type(scene_t), intent(inout) :: scene
      !> `ITS_START` or `ITS_BODY`.
      integer, intent(in) :: part
      type(scene_error_t), intent(inout) :: error
      real(wp) :: q(4), omega(3)
      associate (groups => scene%groups)
         if (part == ITS_BODY) &
            call rebuild_body(groups(place_of(groups, 'body')), scene%shape, scene%system%body, error)
         if (error%raised) return
         associate (initial => groups(place_of(groups, 'initial')))
            call rebuild_initial(initial, scene%system, q, omega, scene%periodic, error)
            if (error%raised) return
            scene%initial = make_state(scene%system, q, omega)
            call check_initial(scene%system, scene%initial, scene%plan, initial, &
                               groups(place_of(groups, 'integrator')), error)
         end associate
      end associate
   end subroutine rebuild_free_motion

   !> Clears the system except for the frames, which no number of a scene changes.
   subroutine forget_system(system)
      type(system_t), intent(inout) :: system
      type(moving_frame_t), allocatable :: frames(:)
      integer :: n
      n = system%effects%n_frames
      call move_alloc(system%effects%frames, frames)
      call forget_all(system)
      call move_alloc(frames, system%effects%frames)
      system%effects%n_frames = n
   end subroutine forget_system

   subroutine forget_all(system)
      type(system_t), intent(out) :: system
   end subroutine forget_all

   !> Clears what is built of steps and rows; the limit of steps, which no number of a scene changes, stays.
   subroutine forget_run(events, plan, output)
      type(event_list_t), intent(out) :: events
      type(run_plan_t), intent(inout) :: plan
      type(output_settings_t), intent(out) :: output
      plan = run_plan_t(max_steps=plan%max_steps)
   end subroutine forget_run

   !> Raises an error for columns of a wheel, an orbit, a free parameter or an indicator of chaos that does not exist.
   subroutine check_columns(group, scene, error)
      !> The group `&output`.
      type(group_t), intent(in) :: group
      type(scene_t), intent(in) :: scene
      type(scene_error_t), intent(inout) :: error
      type(columns_t) :: columns
      type(propagated_t) :: propagated
      type(status_t) :: status
      integer :: i
      ! The names of the free parameters are read later.
      propagated%names = pack(scene%groups%name, scene%groups%name == 'free')
      propagated%sigma = pack([(merge(1.0_wp, 0.0_wp, scene%groups(i)%has('sigma')), i=1, size(scene%groups))], &
                           scene%groups%name == 'free')
      propagated%exponents = merge(1, 0, any(scene%groups%name == 'chaos'))
      call columns%choose(scene%output%columns, status, effects=scene%system%effects, propagated=propagated)
      if (.not. status%ok()) call error%raise_status(group%line_of('columns'), status)
   end subroutine check_columns

   !> Reads the times of the output points if they are in a file.
   subroutine read_times(groups, path, error)
      type(group_t), intent(inout) :: groups(:)
      character(len=*), intent(in) :: path
      type(scene_error_t), intent(inout) :: error
      integer :: i
      do i = 1, size(groups)
         if (groups(i)%name == 'output' .and. groups(i)%has('times_file') .and. .not. allocated(groups(i)%table)) &
            call read_table(groups(i), 'times_file', time_units, path(1:index(path, '/', back=.true.)), error)
      end do
   end subroutine read_times

   !> Returns the index of the first group of a name; 0 if there is none.
   pure integer function place_of(groups, name) result(i)
      type(group_t), intent(in) :: groups(:)
      character(len=*), intent(in) :: name
      i = findloc(groups%name, name, dim=1)
   end function place_of

   !> Returns the file name of a path without folder and `.nml`.
   pure function scene_name(path) result(name)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: name
      name = trim(path(index(path, '/', back=.true.) + 1:))
      if (len(name) <= 4) return
      if (lower_case(name(len(name) - 3:)) == '.nml') name = name(1:len(name) - 4)
   end function scene_name

end submodule nutate_scene_building
