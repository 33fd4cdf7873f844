!> Warnings about legal scenes that probably do not describe the intended motion. They are simulated as they are.
module nutate_scene_warnings
   use nutate_control_law, only: BY_WHEELS, POINTING
   use nutate_controller, only: controller_t
   use nutate_decimal, only: rounded_text
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_epoch, only: epoch_t
   use nutate_hamiltonian, only: angular_velocity
   use nutate_keys, only: group_t, setting_t
   use nutate_kinds, only: long, pi, wp
   use nutate_notes, only: add_note, note_t, scene_notes
   use nutate_orbital_effects, only: goes_by_orbit
   use nutate_quantities, only: component_of, depends_on_orbit, quantities, set_of
   use nutate_scene, only: scene_t
   use nutate_spelling, only: count_text
   implicit none
   private

   public :: collect_notes

   !> Largest rotation of the direction to the centre of attraction on a circular orbit in a run without a warning, rad.
   real(wp), parameter :: visible_turn = 0.1_wp
   !> Keys that are angles, of `&initial`, `&orbit` and `&earth_field`.
   character(len=21), parameter :: angles(10) = [character(len=21) :: 'angle', 'euler', 'roll_pitch_yaw', 'pole', &
      'precession_angle', 'inclination', 'raan', 'argument_of_periapsis', 'mean_anomaly', 'epoch_angle']
   !> Altitude, m, below which a value is likely given in km.
   real(wp), parameter :: least_altitude = 1e4_wp
   !> Limit of stability of a sampled controller: gain times sample period over inertia.
   real(wp), parameter :: unstable = 2.0_wp

contains

   !> Collects all notes on a scene, which `check` and the summary of a run show.
   subroutine collect_notes(scene, notes)
      type(scene_t), intent(in) :: scene
      type(note_t), allocatable, intent(out) :: notes(:)
      call scene_notes(scene, notes)
      call add_warnings(scene, notes)
   end subroutine collect_notes

   !> Adds warnings to other notes.
   subroutine add_warnings(scene, notes)
      type(scene_t), intent(in) :: scene
      type(note_t), allocatable, intent(inout) :: notes(:)
      type(epoch_t) :: last
      integer :: i
      do i = 1, size(scene%groups)
         associate (group => scene%groups(i))
            select case (group%name)
            case ('initial', 'earth_field')
               call note_angles(group, notes)
            case ('orbit')
               call note_angles(group, notes)
               if (group%number('altitude', least_altitude) < least_altitude) call add_note(notes, &
                  'the altitude of the orbit is '//rounded_text(group%number('altitude', 0.0_wp))//' m (km need 1e3)')
            case ('gravity')
               if (.not. (any(abs(scene%system%body%center_of_mass) > 0.0_wp) .or. &
                          scene%system%effects%moves_center)) call add_note(notes, &
                  '&gravity has no effect: '// &
                  'centre of mass and reference point coincide (set center_of_mass)')
            case ('integrator')
               call note_idle_keys(group, notes)
            case ('ensemble')
               call note_histories(group, notes)
            case ('gravity_gradient')
               if (.not. scene%system%effects%frame_turns) call note_orbit(group, scene%plan%end_time, notes)
            case default
               ! Other groups are tested only for duplicates.
            end select
         end associate
      end do
      call note_twins(scene%groups, notes)
      call note_centre(scene, notes)
      call note_unused_orbit(scene, notes)
      call note_controllers(scene, notes)
      call note_rows(scene, notes)
      last = scene%labels%epoch%after(scene%plan%end_time)
      if (scene%labels%epoch%is_uncertain() .or. last%is_uncertain()) call add_note(notes, &
         'dates in UTC after 2026-06-28 assume that no leap second is added (TDB, TT and TAI have none)')
   end subroutine add_warnings

   !> Notes angles of more than 2π that are not declared to be in degrees.
   subroutine note_angles(group, notes)
      type(group_t), intent(in) :: group
      type(note_t), allocatable, intent(inout) :: notes(:)
      real(wp) :: values(3), largest
      integer :: i
      if (group%flag('degrees', .false.)) return
      do i = 1, size(angles)
         if (.not. group%has(trim(angles(i)))) cycle
         values = 0.0_wp
         values(:group%count_of(trim(angles(i)))) = &
            group%vector(trim(angles(i)), values(:group%count_of(trim(angles(i)))))
         largest = maxval(abs(values))
         if (largest > 2*pi) call add_note(notes, 'an angle of '//rounded_text(largest, 3)//' rad in '// &
                                           trim(angles(i))//' is more than a turn: degrees = .true. makes it degrees')
      end do
   end subroutine note_angles

   !> Notes keys that only `nielsen_krenk` uses, if the scene names another method.
   subroutine note_idle_keys(group, notes)
      type(group_t), intent(in) :: group
      type(note_t), allocatable, intent(inout) :: notes(:)
      character(len=17), parameter :: keys(4) = [character(len=17) :: 'auxiliary_inertia', 'projection', 'tolerance', &
                                                 'max_iterations']
      integer :: i
      if (any(group%text('method', 'auto') == [character(len=13) :: 'auto', 'nielsen_krenk'])) return
      do i = 1, size(keys)
         if (group%has(trim(keys(i)))) call add_note(notes, trim(keys(i))//' has no effect with method '// &
                                                     trim(group%text('method', '')))
      end do
   end subroutine note_idle_keys

   !> Notes a single number in `histories`, which may be meant as a count of members.
   subroutine note_histories(group, notes)
      type(group_t), intent(in) :: group
      type(note_t), allocatable, intent(inout) :: notes(:)
      character(len=:), allocatable :: number
      if (group%count_of('histories') /= 1) return
      if (modulo(nint(group%number('histories', 1.0_wp)), 10) /= 0) return
      number = rounded_text(group%number('histories', 1.0_wp), 9)
      call add_note(notes, 'histories = '//number//' gives a history to member '//number// &
                    ' alone: the key lists members')
   end subroutine note_histories

   !> Notes a centre of mass beside the reference point of a body that nothing holds there.
   subroutine note_centre(scene, notes)
      type(scene_t), intent(in) :: scene
      type(note_t), allocatable, intent(inout) :: notes(:)
      if (.not. any(abs(scene%system%body%center_of_mass) > 0.0_wp) .or. any(scene%groups%name == 'gravity')) return
      associate (effects => scene%system%effects)
         if (effects%on_orbit .or. effects%n_potentials + effects%n_off + effects%n_torques == 0) call add_note(notes, &
            'nothing holds the body at its reference point: a free body rotates about its centre of mass '// &
            '(expected center_of_mass = 0, 0, 0)')
      end associate
   end subroutine note_centre

   !> Notes an orbit to which nothing refers.
   subroutine note_unused_orbit(scene, notes)
      type(scene_t), intent(in) :: scene
      type(note_t), allocatable, intent(inout) :: notes(:)
      if (.not. scene%system%effects%on_orbit) return
      if (groups_use_orbit(scene) .or. columns_use_orbit(scene)) return
      call add_note(notes, 'no effect, column, event, start or controller refers to &orbit (&gravity_gradient adds '// &
                    'its gravity)')
   end subroutine note_unused_orbit

   !> Returns true if an effect, a controller, an initial state, events or measurements may refer to the orbit.
   pure logical function groups_use_orbit(scene) result(uses)
      type(scene_t), intent(in) :: scene
      integer :: i, j, k
      uses = .false.
      do i = 1, size(scene%groups)
         associate (group => scene%groups(i))
            select case (group%name)
            case ('initial')
               uses = uses .or. group%text('attitude_from', '') == 'lvlh' .or. group%has('resonance') .or. &
                      any(group%text('rate_from', '') == ['lvlh ', 'frame'])
            case ('event')
               do k = 1, group%count_of('when')
                  uses = uses .or. any([(depends_on_orbit(quantities(j)) .and. &
                                         component_of(quantities(j), group%text_at('when', k)) > 0, &
                                         j=1, size(quantities))])
               end do
            case ('controller', 'measurement', 'frame')
               uses = .true.
            case default
               uses = uses .or. goes_by_orbit(group)
            end select
         end associate
      end do
   end function groups_use_orbit

   !> Returns true if columns of the history show the orbit.
   pure logical function columns_use_orbit(scene) result(uses)
      type(scene_t), intent(in) :: scene
      integer :: i
      uses = any([(depends_on_orbit(quantities(i)) .and. any(scene%output%columns == set_of(quantities(i))), &
                   i=1, size(quantities))])
   end function columns_use_orbit

   !> Notes sampled controllers whose rate gain, held over a sample, does more than reverse the rate, and wheels that
   !> cannot give the torque of a pointing controller.
   subroutine note_controllers(scene, notes)
      type(scene_t), intent(in) :: scene
      type(note_t), allocatable, intent(inout) :: notes(:)
      real(wp) :: loop(3, 3), gain
      integer :: i, k, spanned
      associate (effects => scene%system%effects)
         do i = 1, effects%n_torques
            select type (controller => effects%torques(i)%item)
            type is (controller_t)
               loop = controller%sample*matmul(scene%system%body%inverse_inertia, controller%rate_gain)
               gain = maxval([(loop(k, k), k=1, 3)])
               if (gain > unstable) &
                  call add_note(notes, 'a sampled controller is unstable: D*sample/J, D its matrix of rate gains, '// &
                                'is '//rounded_text(gain, 3)//' (expected less than 2)')
               if (controller%by /= BY_WHEELS .or. controller%law /= POINTING) cycle
               ! The shares are the negative pseudo-inverse of the axes: their product has the rank as its trace.
               spanned = nint(sum([(-dot_product(controller%share(:, k), effects%wheels(k)%axis), &
                                    k=1, effects%n_reaction_wheels)]))
               if (spanned < 3) call add_note(notes, 'the wheels of a controller do not span three axes: it cannot '// &
                                              'give a torque across them (expected three wheels or more)')
            class default
               ! Other torques are not sampled.
            end select
         end do
      end associate
   end subroutine note_controllers

   !> Notes rows between which the body rotates so far that curves and animations of them show another motion.
   subroutine note_rows(scene, notes)
      type(scene_t), intent(in) :: scene
      type(note_t), allocatable, intent(inout) :: notes(:)
      real(wp) :: interval, rate
      if (allocated(scene%plan%times)) return
      interval = scene%plan%interval
      if (.not. interval > 0.0_wp .and. .not. scene%plan%goal%active()) &
         interval = real(scene%plan%every, wp)*abs(scene%plan%time_step)
      rate = norm2(angular_velocity(scene%system, scene%initial))
      if (interval*rate < pi .or. interval >= abs(scene%plan%end_time)) return
      call add_note(notes, 'the body turns by half a turn or more between rows, which are '// &
                    rounded_text(interval, 3)//' s apart: pictures of them show other oscillations (expected less '// &
                    'than '//rounded_text(pi/rate, 3)//' s)')
   end subroutine note_rows

   !> Notes a fixed direction of a gravity gradient, which on an orbit would rotate with the orbit.
   subroutine note_orbit(group, duration, notes)
      type(group_t), intent(in) :: group
      !> Duration of the run, s.
      real(wp), intent(in) :: duration
      type(note_t), allocatable, intent(inout) :: notes(:)
      real(wp) :: rate
      rate = sqrt(abs(group%number('strength', 0.0_wp)))
      if (rate*abs(duration) > visible_turn) call add_note(notes, 'the direction of &gravity_gradient is fixed in '// &
         'space: on a circular orbit it would turn once in '//rounded_text(2*pi/rate, 3)//' s (&orbit turns it)')
   end subroutine note_orbit

   !> Notes effects that appear twice with the same numbers.
   subroutine note_twins(groups, notes)
      type(group_t), intent(in) :: groups(:)
      type(note_t), allocatable, intent(inout) :: notes(:)
      type(effect_kind_t), allocatable :: kinds(:)
      character(len=:), allocatable :: often
      integer(long) :: marks(size(groups))
      logical :: told(size(groups))
      integer :: i, k, times
      allocate (kinds, source=effect_kinds())
      marks = [(mark_of(groups(i)), i=1, size(groups))]
      told = .false.
      do i = 1, size(groups)
         if (told(i)) cycle
         if (.not. any(kinds%group%name == groups(i)%name)) cycle
         times = 1
         do k = i + 1, size(groups)
            if (marks(k) /= marks(i) .or. told(k)) cycle
            if (.not. are_alike(groups(i), groups(k))) cycle
            told(k) = .true.
            times = times + 1
         end do
         if (times == 1) cycle
         often = count_text(times)//' times'
         if (times == 2) often = 'twice'
         call add_note(notes, 'a group &'//trim(groups(i)%name)//' appears '//often//': its effect counts '//often)
      end do
   end subroutine note_twins

   !> Returns a number that is the same for groups with the same numbers, in any order.
   pure integer(long) function mark_of(group) result(mark)
      type(group_t), intent(in) :: group
      integer :: i, k
      mark = 0
      do i = 1, size(group%settings)
         do k = 1, size(group%settings(i)%values)
            ! The sum makes -0 the same as 0.
            mark = ieor(mark, transfer(group%settings(i)%values(k)%number + 0.0_wp, mark))
         end do
      end do
   end function mark_of

   !> Returns true if two groups of a name give the same keys the same values, in any order.
   pure logical function are_alike(a, b)
      type(group_t), intent(in) :: a, b
      integer :: i, k
      are_alike = .false.
      if (a%name /= b%name .or. size(a%settings) /= size(b%settings)) return
      do i = 1, size(a%settings)
         do k = 1, size(b%settings)
            if (are_same(a%settings(i), b%settings(k))) exit
         end do
         if (k > size(b%settings)) return
      end do
      are_alike = .true.
   end function are_alike

   !> Returns true if two settings have the same key and the same values.
   pure logical function are_same(a, b)
      type(setting_t), intent(in) :: a, b
      integer :: i
      are_same = a%name == b%name .and. size(a%values) == size(b%values)
      if (.not. are_same) return
      do i = 1, size(a%values)
         if (abs(a%values(i)%number - b%values(i)%number) > 0.0_wp) are_same = .false.
         if (a%values(i)%flag .neqv. b%values(i)%flag) are_same = .false.
         if (allocated(a%values(i)%text)) are_same = are_same .and. a%values(i)%text == b%values(i)%text
      end do
   end function are_same

end module nutate_scene_warnings
