!> `nutate check SCENE`: reports what would be simulated and writes nothing.
module nutate_check_command
   use nutate_attitude, only: axis_angle_from_quat
   use nutate_scene_loading, only: add_space_axes, add_free_numbers, propagate_free_parameters, load_scene
   use nutate_body, only: diagonal, whole_body
   use nutate_cli, only: command_t
   use nutate_column_event, only: column_event_t, most_columns
   use nutate_columns, only: columns_t
   use nutate_console, only: count_text, page_t, plural, rate_text, say_error, show_page, vector_text, EXIT_INPUT, &
      EXIT_SUCCESS
   use nutate_decimal, only: rounded_text
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_effect_list, only: effect_list_t
   use nutate_sweep_report, only: add_ensemble
   use nutate_epoch, only: epoch_t
   use nutate_event, only: CROSSING, event_t, MAXIMUM, MINIMUM, SWITCH_OFF, SWITCH_ON
   use nutate_notes, only: history_bytes, known_steps, most_rows, rows_of, size_text, too_many_rows, note_t
   use nutate_files, only: STANDARD_OUTPUT
   use nutate_free_variations, only: usual_sets
   use nutate_hamiltonian, only: angular_velocity, body_momentum, kinetic_energy, potential_energy, space_momentum, &
      system_t
   use nutate_invariants, only: invariants_t
   use nutate_keys, only: group_t, key_t, KEY_LOGICAL, KEY_TEXT
   use nutate_kinds, only: wp, long, pi
   use nutate_lvlh_view, only: lvlh_view_t
   use nutate_methods, only: equations_of
   use nutate_linearize_command, only: add_periodic
   use nutate_printable, only: printable_path
   use nutate_run, only: observer_t, run_t
   use nutate_run_plan, only: count_steps, run_plan_t
   use nutate_run_summary, only: kept_momentum
   use nutate_scene, only: scene_t
   use nutate_scene_warnings, only: collect_notes
   use nutate_spelling, only: split_list
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_STOPPED
   use nutate_integrator_settings, only: integrator_settings_t
   use nutate_tumbling, only: tumbling_elements, tumbling_start, tumbling_start_t, tumbling_t
   implicit none
   private

   public :: check_command

   !> Time allowed for finding the number of steps, s.
   real(wp), parameter :: patience = 0.5_wp

   !> Observer that ends runs after a deadline and ignores output points.
   type, extends(observer_t) :: timekeeper_t
      integer(long) :: deadline = 0
   contains
      procedure :: poll => poll_clock
   end type timekeeper_t

contains

   !> Reads a scene as `run` would and shows its contents.
   subroutine check_command(command, exit_code)
      type(command_t), intent(in) :: command
      integer, intent(out) :: exit_code
      type(scene_t) :: scene
      type(run_t) :: run
      type(status_t) :: status
      type(page_t) :: page
      character(len=:), allocatable :: refusal
      call load_scene(command, scene, exit_code)
      if (exit_code /= EXIT_SUCCESS) return
      scene%output%columns = usual_sets(scene)
      call run%begin(scene%system, scene%integrator, scene%initial, scene%plan, status)
      if (status%ok()) call propagate_free_parameters(scene, run, exit_code)
      if (status%ok() .and. exit_code == EXIT_SUCCESS) call run%follow_chaos(scene%chaos, scene%system, status)
      if (.not. status%ok()) then
         call say_error(printable_path(scene%file)//': '//trim(status%message), exit_code, EXIT_INPUT)
      end if
      if (exit_code /= EXIT_SUCCESS) return
      scene%integrator = run%summary%settings
      call page%line(printable_path(scene%file)//': '//scene%title)
      call add_body()
      call add_start()
      call add_effects()
      if (scene%events%count() > 0) call add_events()
      if (allocated(scene%fit%free)) call add_free_numbers(page, scene)
      call add_method(trim(run%summary%choice))
      call add_invariants()
      call add_output()
      if (scene%ensemble%active()) call add_ensemble(page, scene%ensemble)
      call add_notes()
      call show_page(page, STANDARD_OUTPUT, exit_code)
      if (refusal == '' .or. exit_code /= EXIT_SUCCESS) return
      call say_error('nutate: '//printable_path(scene%file)//': '//refusal, exit_code, EXIT_INPUT)

   contains

      subroutine add_body()
         integer :: i
         call page%line('body')
         associate (body => whole_body(scene%system%body))
            if (scene%shape /= '') call page%item('shape', scene%shape)
            call page%item('principal moments', vector_text(body%moments)//' kg m^2, about the reference point')
            if (any(abs(body%axes - diagonal([1.0_wp, 1.0_wp, 1.0_wp])) > 0.0_wp)) then
               do i = 1, 3
                  call page%item('  axis '//count_text(i), vector_text(body%axes(:, i)))
               end do
            end if
            if (body%has_mass) call page%item('mass', rounded_text(body%mass)//' kg')
            call page%item('centre of mass', vector_text(body%center_of_mass)//' m'// &
                           trim(merge(', at t = 0: it moves by a table', repeat(' ', 31), &
                                      scene%system%effects%moves_center)))
            if (scene%system%effects%varies) call page%item('inertia', 'varies with time'// &
               departure_text(scene%system%effects)//': the moments are those of t = 0, the centre of mass '// &
               trim(merge('moves', 'stays', scene%system%effects%moves_center)))
         end associate
      end subroutine add_body

      subroutine add_start()
         real(wp) :: axis(3), angle, omega(3), kinetic, potential
         call page%line('start')
         call add_labels()
         associate (system => scene%system, state => scene%initial)
            call axis_angle_from_quat(state%q, axis, angle)
            call page%item('attitude', 'q = '//vector_text(state%q))
            if (angle > 0.0_wp) call page%item('', 'rotated by '//rounded_text(angle)//' rad about '//vector_text(axis))
            omega = angular_velocity(system, state)
            call page%item('angular velocity', vector_text(omega)//' rad/s in body axes, '// &
                           rate_text(norm2(omega))//' in all')
            if (gives_rate_in_degrees()) call page%item('', 'given in deg/s, by degrees = .true.')
            call page%item('angular momentum', vector_text(space_momentum(state))//' N m s in space axes')
            call add_tumbling(system, state)
            call add_periodic(page, scene%periodic)
            kinetic = kinetic_energy(system, state, scene%integrator%inverse_auxiliary_inertia)
            potential = potential_energy(system%effects, state%q, state%t)
            call page%item('energy', rounded_text(kinetic + potential)//' J: kinetic '//rounded_text(kinetic)// &
                           ', potential '//rounded_text(potential))
         end associate
      end subroutine add_start

      !> Returns true if the scene gives its angular velocity in degrees per second.
      pure logical function gives_rate_in_degrees() result(gives)
         integer :: i
         i = findloc(scene%groups%name, 'initial', dim=1)
         gives = scene%groups(i)%flag('degrees', .false.) .and. &
                 (scene%groups(i)%has('angular_velocity') .or. scene%groups(i)%has('euler_rates'))
      end function gives_rate_in_degrees

      !> Adds the epoch, the object, the names of space and body axes, and the frames.
      subroutine add_labels()
         type(epoch_t) :: last
         integer :: i
         associate (labels => scene%labels)
            if (labels%epoch%is_set()) then
               last = labels%epoch%after(scene%plan%end_time)
               call page%item('epoch', 't = 0 at '//labels%epoch%text()//' '//trim(labels%epoch%system)// &
                              ', end at '//last%text())
            end if
            if (labels%object//labels%object_id /= '') call page%item('object', labels%object// &
               merge(', ', '  ', min(len(labels%object), len(labels%object_id)) > 0)//labels%object_id)
            call add_space_axes(page, scene)
            if (labels%body_frame /= '') call page%item('body axes', labels%body_frame)
            do i = 1, scene%system%effects%n_frames
               call page%item('frame '//count_text(i), frame_text(i))
            end do
         end associate
      end subroutine add_labels

      !> Returns the attitude of a frame in words: its file, number of records and time range.
      pure function frame_text(number) result(text)
         integer, intent(in) :: number
         character(len=:), allocatable :: text
         integer :: i, n
         n = 0
         text = ''
         do i = 1, size(scene%groups)
            if (scene%groups(i)%name /= 'frame') cycle
            n = n + 1
            if (n == number) text = trim(scene%groups(i)%text('attitude', ''))
         end do
         associate (frame => scene%system%effects%frames(number))
            text = 'attitude of '//printable_path(text)//', '//plural(size(frame%t, kind=long), 'record')//' from '// &
                   rounded_text(frame%t(1))//' to '//rounded_text(frame%t(size(frame%t)))//' s'// &
                   trim(merge(', with rates', '            ', allocated(frame%omega)))
         end associate
      end function frame_text

      !> Adds the tumbling elements of a free triaxial body.
      subroutine add_tumbling(system, state)
         type(system_t), intent(in) :: system
         type(state_t), intent(in) :: state
         type(tumbling_t) :: elements
         type(tumbling_start_t) :: start
         character(len=:), allocatable :: axis
         real(wp) :: l(3)
         associate (effects => system%effects, moments => system%body%moments)
            if (effects%n_potentials + effects%n_off + effects%n_torques + effects%n_rotors > 0 .or. &
               effects%frame_turns) &
               return
            l = space_momentum(state)
            if (.not. (norm2(l) > 0.0_wp .and. abs(moments(1) - moments(2)) > 0.0_wp .and. &
                       abs(moments(2) - moments(3)) > 0.0_wp .and. abs(moments(3) - moments(1)) > 0.0_wp)) return
            elements = tumbling_elements(moments, matmul(body_momentum(state), system%body%axes))
            start = tumbling_start(moments, system%body%axes, state%q, angular_velocity(system, state))
         end associate
         axis = trim(merge('short axis', 'long axis ', elements%is_short_axis))
         call page%item('tumbling', trim(merge('short-axis mode', 'long-axis mode ', elements%is_short_axis))// &
                        ', E/E0 = '//ten_digits(elements%energy_ratio))
         call page%item('  sense', trim(merge('negative', 'positive', elements%is_negative))//' about the '//axis)
         call page%item('  rotation', 'period '//ten_digits(elements%rotation)//' s, phase '//ten_digits(start%phase))
         call page%item('  precession', 'period '//ten_digits(elements%precession_short)//' s of the short axis, '// &
                        ten_digits(elements%precession_long)//' s of the long axis')
         call page%item('  angle', ten_digits(start%angle)//' rad of the '//axis)
         call page%item('  pole', 'longitude '//ten_digits(start%pole(1))// &
                        ' rad, latitude '//ten_digits(start%pole(2))// &
                        ' rad in space axes')
      end subroutine add_tumbling

      !> Adds every event.
      subroutine add_events()
         integer :: i
         call page%line('events')
         do i = 1, scene%events%count()
            associate (event => scene%events%slots(i)%item)
               call page%item("'"//trim(event%name)//"'", event_text(event))
            end associate
         end do
      end subroutine add_events

      !> Adds every effect, as the scene gives it; nothing else is simulated.
      subroutine add_effects()
         type(effect_kind_t), allocatable :: kinds(:)
         logical :: is_free
         integer :: i, k

         call page%line('effects')
         allocate (kinds, source=effect_kinds())
         is_free = .true.
         do i = 1, size(scene%groups)
            do k = 1, size(kinds)
               if (kinds(k)%group%name /= scene%groups(i)%name) cycle
               call page%item(trim(scene%groups(i)%name), settings_text(scene%groups(i), kinds(k)%group%keys)// &
                              controller_text(scene, scene%groups(i))//switch_text(scene%groups(i)))
               if (scene%groups(i)%name == 'orbit') call add_orbit(scene%groups(i))
               is_free = .false.
            end do
         end do
         if (is_free .and. .not. scene%system%effects%varies) call page%item('none', 'torque-free rigid body')
         if (is_free .and. scene%system%effects%varies) call page%item('none', 'but the change of the inertia')
      end subroutine add_effects

      !> Adds period, distance and speed of an orbit.
      subroutine add_orbit(group)
         type(group_t), intent(in) :: group
         character(len=:), allocatable :: text
         integer :: i
         if (.not. scene%system%effects%on_orbit) return
         associate (orbits => scene%system%effects%orbits)
            i = findloc(orbits%label == group%text('name', ''), .true., dim=1)
            if (i == 0) return
            associate (path => orbits(i)%path)
               text = 'at t = 0: distance '//rounded_text(path%radius(0.0_wp)/1e3_wp, 6)//' km, speed '// &
                      rounded_text(norm2(path%velocity(0.0_wp))/1e3_wp, 6)//' km/s'
               if (.not. allocated(path%track) .and. path%eccentricity < 1) &
                  text = text//'; period '//rounded_text(2*pi/path%mean_motion(), 6)//' s'
            end associate
         end associate
         call page%item('', text)
      end subroutine add_orbit

      subroutine add_method(choice)
         !> Reason for the choice of the method; blank if the scene names the method.
         character(len=*), intent(in) :: choice
         type(lvlh_view_t) :: view
         real(wp) :: turn
         call page%line('integration')
         associate (settings => scene%integrator, plan => scene%plan)
            call page%item('method', method_text(settings))
            if (choice /= '') call page%item('  chosen by auto', choice)
            call page%item('in each step', equations_of(settings))
            call view%prepare(scene%system)
            if (view%exists .and. settings%attitude .and. .not. settings%in_space_axes) &
               call page%item('axes of steps', 'LVLH frame, where all effects are constant')
            if (settings%inverse_auxiliary_inertia > 0.0_wp) then
               call page%item('auxiliary inertia', rounded_text(1/settings%inverse_auxiliary_inertia)//' kg m^2')
            else
               call page%item('auxiliary inertia', 'infinite')
            end if
            if (.not. settings%projection) call page%item('projection', 'switched off')
            if (plan%goal%active()) then
               call page%item('steps', steps_text(plan, settings%order, scene%events%count() > 0))
               if (settings%max_step < huge(1.0_wp)) &
                  call page%item('', 'of at most '//rounded_text(settings%max_step)//' s each')
               return
            end if
            call page%item('steps', count_text(count_steps(scene%initial%t, plan))//' of '// &
                           rounded_text(plan%time_step)//' s, to t = '//rounded_text(plan%end_time)//' s')
            turn = abs(plan%time_step)*norm2(angular_velocity(scene%system, scene%initial))
            call page%item('turn in a step', rounded_text(turn, 3)//' rad at the start')
         end associate
      end subroutine add_method

      !> Adds the invariants that the run should conserve.
      subroutine add_invariants()
         type(invariants_t) :: invariants
         character(len=:), allocatable :: kept
         kept = 'energy'
         if (scene%system%effects%frame_turns) kept = 'T + V - omega.l'
         call invariants%start(scene%system, scene%initial, scene%integrator%inverse_auxiliary_inertia, &
                               scene%integrator%attitude)
         call page%line('invariants')
         if (scene%system%effects%n_works() > 0) then
            call page%item(kept, 'changes by the work of '//workers(scene%system%effects)//' alone')
         else
            call page%item(kept, 'conserved')
         end if
         call page%item('space momentum', kept_momentum(invariants, scene%system%effects))
         if (.not. scene%integrator%attitude) then
            call page%item('constraints', 'none: the attitude is not integrated')
         else if (scene%integrator%projection) then
            call page%item('constraints', 'unit norm of q, and q.p = 0')
         else
            call page%item('constraints', 'not enforced without projection')
         end if
      end subroutine add_invariants

      subroutine add_output()
         type(columns_t) :: columns
         type(status_t) :: status
         character(len=:), allocatable :: header
         integer(long) :: n, rows
         call page%line('output')
         call columns%choose(scene%output%columns, status, scene%output%degrees, scene%system%effects, &
                             scene%propagated())
         header = columns%header()
         if (scene%output%epoch%is_set()) header = 't,date'//header(2:)
         if (status%ok()) call page%item('columns', header)
         if (scene%chaos%exponents > 0) call page%item('summary', trim(merge( &
            'largest Lyapunov exponent', 'all Lyapunov exponents   ', scene%chaos%exponents == 1))//', MEGNO, FLI')
         refusal = ''
         if (scene%plan%goal%active()) then
            call add_expected_rows()
            return
         end if
         n = count_steps(scene%initial%t, scene%plan)
         rows = rows_of(scene, n)
         call page%item('file', printable_path(scene%output%file)//', about '//size_text(history_bytes(scene, rows)))
         if (allocated(scene%plan%times)) then
            call page%item('rows', count_text(rows)//', at the times given')
         else if (scene%plan%every == 1) then
            call page%item('rows', count_text(rows)//', one for each step')
         else
            call page%item('rows', count_text(rows)//', one for every '//plural(scene%plan%every, 'step'))
         end if
         if (rows > most_rows(scene)) refusal = too_many_rows(scene, rows)
      end subroutine add_output

      !> Adds steps, rows and size of a run with adaptive steps, found as `run` would find them.
      subroutine add_expected_rows()
         type(run_t) :: run
         type(run_plan_t) :: plan
         type(status_t) :: status
         type(timekeeper_t) :: timekeeper
         integer(long) :: steps, rows, rate
         call system_clock(timekeeper%deadline, rate)
         timekeeper%deadline = timekeeper%deadline + int(patience*real(rate, wp), long)
         plan = scene%plan
         plan%interval = 0.0_wp
         if (allocated(plan%times)) deallocate (plan%times)
         plan%every = huge(plan%every)
         call run%begin(scene%system, scene%integrator, scene%initial, plan, status)
         if (status%ok()) call run%find_steps(scene%system, status, timekeeper)
         steps = known_steps(scene, run)
         rows = rows_of(scene, steps)
         if (steps < 0 .and. status%ok()) then
            call run%run_to_end(scene%system, status, timekeeper)
            if (status%ok()) steps = run%summary%steps
         end if
         rows = rows_of(scene, steps)
         if (rows >= 0) then
            call page%item('file', printable_path(scene%output%file)//', about '//size_text(history_bytes(scene, rows)))
         else
            call page%item('file', printable_path(scene%output%file))
         end if
         if (status%code == NUTATE_STOPPED) then
            call page%item('steps', 'too many to determine here')
         else if (.not. status%ok()) then
            call page%item('steps', 'none: '//trim(status%message))
         else if (steps >= 0 .and. run%summary%settings%order < 1) then
            call page%item('steps', count_text(steps)//' of the closed solution')
         else if (steps >= 0) then
            call page%item('steps', 'about '//count_text(steps))
         end if
         if (allocated(scene%plan%times)) then
            call page%item('rows', count_text(rows)//', at the times given')
         else if (scene%plan%interval > 0.0_wp) then
            call page%item('rows', count_text(rows)//', one every '//rounded_text(scene%plan%interval)//' s')
         else if (rows >= 0 .and. status%ok()) then
            call page%item('rows', 'about '//count_text(rows))
         end if
         if (run%summary%estimate > scene%plan%goal%accuracy .and. scene%plan%goal%accuracy > 0.0_wp) &
            call page%item('accuracy', 'not attainable; best: '//rounded_text(run%summary%estimate, 3)//' rad')
      end subroutine add_expected_rows

      subroutine add_notes()
         type(note_t), allocatable :: notes(:)
         integer :: i
         call collect_notes(scene, notes)
         if (size(notes) > 0) call page%line('notes')
         do i = 1, size(notes)
            call page%line('  '//notes(i)%text)
         end do
      end subroutine add_notes

   end subroutine check_command

   !> Returns a number with so many digits that the printed elements give the motion to 1e-8.
   function ten_digits(x) result(text)
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text
      text = rounded_text(x, 10)
   end function ten_digits

   !> Returns ` as mass leaves` if mass leaves the body; else an empty string.
   pure function departure_text(effects) result(text)
      type(effect_list_t), intent(in) :: effects
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, effects%n_torques
         associate (torque => effects%torques(i)%item)
            if (torque%changes_inertia .and. .not. torque%is_internal) text = ' as mass leaves'
         end associate
      end do
   end function departure_text

   !> Returns the settings of a group, then the defaults of missing keys: `key = values; key = values (default)`.
   pure function settings_text(group, keys) result(text)
      type(group_t), intent(in) :: group
      !> Keys that the group may have.
      type(key_t), intent(in) :: keys(:)
      character(len=:), allocatable :: text
      integer :: k
      text = ''
      do k = 1, size(keys)
         ! The name of the effect, and whether it is on, are reported by `switch_text`.
         if (any(keys(k)%name == [character(len=4) :: 'name', 'on'])) cycle
         if (group%has(trim(keys(k)%name))) text = text//'; '//trim(keys(k)%name)//' = '//values_text(group, keys(k))
      end do
      do k = 1, size(keys)
         if (takes_default(group, keys(k))) &
            text = text//'; '//trim(keys(k)%name)//' = '//trim(keys(k)%default)//' (default)'
      end do
      text = text(min(3, len(text) + 1):)
   end function settings_text

   !> Returns the settings that a controller derives from other groups: the field of its magnetorquers, the inertia that
   !> its gains are multiplied by.
   pure function controller_text(scene, group) result(text)
      type(scene_t), intent(in) :: scene
      type(group_t), intent(in) :: group
      character(len=:), allocatable :: text
      text = ''
      if (group%name /= 'controller') return
      if (.not. group%has('field') .and. (group%text('law', '') == 'bdot' .or. group%text('by', '') == &
                                          'magnetorquers')) &
         text = '; field = &earth_field (default)'
      if (group%text('gains', 'inertia') == 'scalar') return
      if (.not. (group%has('attitude_gain') .or. group%has('rate_gain'))) return
      if (group%has('inertia')) then
         text = text//'; gains times the inertia given'
         return
      end if
      associate (j => scene%nominal%inertia)
         text = text//'; gains times the inertia of the body, '//vector_text([j(1, 1), j(2, 2), j(3, 3)])
         if (any(abs([j(1, 2), j(1, 3), j(2, 3)]) > 0.0_wp)) text = text//', '//vector_text([j(1, 2), j(1, 3), j(2, 3)])
         text = text//' kg m^2'
      end associate
      if (scene%ensemble%active()) text = text//', before variation'
   end function controller_text

   !> Returns in words the name of an effect, and whether it is off at the start.
   pure function switch_text(group) result(text)
      type(group_t), intent(in) :: group
      character(len=:), allocatable :: text
      text = ''
      if (group%has('name')) text = "; called '"//group%text('name', '')//"'"
      if (.not. group%flag('on', .true.)) text = text//'; off at the start'
   end function switch_text

   !> Returns the values of a key in a group as a string.
   pure function values_text(group, key) result(text)
      type(group_t), intent(in) :: group
      type(key_t), intent(in) :: key
      character(len=:), allocatable :: text
      if (key%kind == KEY_TEXT) then
         text = printable_path(trim(group%text(trim(key%name), '')))
      else if (key%kind == KEY_LOGICAL) then
         text = trim(merge('.true. ', '.false.', group%flag(trim(key%name), .false.)))
      else
         text = vector_text(group%vector(trim(key%name), spread(0.0_wp, 1, group%count_of(trim(key%name)))))
      end if
   end function values_text

   !> Returns true if the default of the key applies and is to be reported.
   pure logical function takes_default(group, key) result(takes)
      type(group_t), intent(in) :: group
      type(key_t), intent(in) :: key
      integer :: i
      takes = .false.
      if (key%default == '' .or. group%has(trim(key%name))) return
      takes = key%beside == ''
      associate (names => split_list(key%beside))
         takes = takes .or. any([(group%has(trim(names(i))), i=1, size(names))])
      end associate
   end function takes_default

   !> Returns the method, with its order if it has one.
   function method_text(settings) result(text)
      type(integrator_settings_t), intent(in) :: settings
      character(len=:), allocatable :: text
      text = trim(settings%method)
      if (settings%order > 0) text = text//' of order '//count_text(settings%order)
   end function method_text

   !> Returns in words how the steps are chosen.
   function steps_text(plan, order, has_events) result(text)
      type(run_plan_t), intent(in) :: plan
      !> Order of the method; 0 for the closed solution.
      integer, intent(in) :: order
      logical, intent(in) :: has_events
      character(len=:), allocatable :: text
      if (order < 1 .and. (has_events .or. .not. (plan%interval > 0.0_wp .or. allocated(plan%times)))) then
         text = 'up to a radian of rotation each, to t = '
      else if (order < 1) then
         text = 'none between output times, to t = '
      else if (plan%goal%accuracy > 0.0_wp) then
         text = 'chosen by trial runs for an attitude error of '//rounded_text(plan%goal%accuracy, 3)//' rad at t = '
      else
         text = 'chosen for an error of '//rounded_text(plan%goal%local_tolerance, 3)//' rad each, to t = '
      end if
      text = text//rounded_text(plan%end_time)//' s'
   end function steps_text

   !> Returns in words the kinds of effects that do work.
   function workers(effects) result(text)
      type(effect_list_t), intent(in) :: effects
      character(len=:), allocatable :: text
      text = 'the torques'
      if (effects%n_wheels > 0) text = 'torques, motors and friction'
      if (effects%varies) text = text//' and the change of the inertia'
      if (.not. effects%moves) return
      text = 'time-dependent potentials'
      if (effects%n_torques > 0) text = 'torques and time-dependent potentials'
      if (effects%n_wheels > 0) text = 'torques, motors, friction and time-dependent potentials'
      if (effects%varies) text = 'torques, time-dependent potentials and the change of the inertia'
   end function workers

   !> Ends the run after the deadline.
   subroutine poll_clock(self, fraction, status)
      class(timekeeper_t), intent(inout) :: self
      real(wp), intent(in) :: fraction
      type(status_t), intent(out) :: status
      integer(long) :: now
      call system_clock(now)
      if (now > self%deadline) status = fail(NUTATE_STOPPED, 'it would take too long')
   end subroutine poll_clock

   !> Returns an event in words, such as `omega3 crosses 0, falling; ends the run`.
   function event_text(event) result(text)
      class(event_t), intent(in) :: event
      character(len=:), allocatable :: text
      text = ''
      select type (event)
      class is (column_event_t)
         text = columns_text(event)
      end select
      select case (event%kind)
      case (CROSSING)
         text = text//' crosses '//rounded_text(event%level)
         if (event%period > 0.0_wp) text = text//' modulo '//rounded_text(event%period)
         if (event%direction > 0) text = text//', growing'
         if (event%direction < 0) text = text//', falling'
      case (MAXIMUM)
         text = text//' has a maximum'
      case (MINIMUM)
         text = text//' has a minimum'
      case default
         text = text//' has an extremum'
      end select
      if (event%action == SWITCH_ON) text = text//"; switches '"//trim(event%effect)//"' on"
      if (event%action == SWITCH_OFF) text = text//"; switches '"//trim(event%effect)//"' off"
      if (event%action > max(SWITCH_ON, SWITCH_OFF)) text = text//"; toggles '"//trim(event%effect)//"'"
      if (event%count > 0) then
         text = text//'; ends the run at number '//count_text(event%count)
      else if (event%stop) then
         text = text//'; ends the run'
      end if
   end function event_text

   !> Returns the weighted sum of columns of an event, such as `psi + 2 omega3`.
   function columns_text(event) result(text)
      type(column_event_t), intent(in) :: event
      character(len=:), allocatable :: text
      integer :: i
      text = ''
      do i = 1, most_columns
         if (event%columns(i) == '') exit
         if (i > 1) text = text//' + '
         if (abs(event%weights(i) - 1) > 0.0_wp) text = text//rounded_text(event%weights(i))//' '
         text = text//trim(event%columns(i))
      end do
   end function columns_text

end module nutate_check_command
