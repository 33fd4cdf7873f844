!> Sensitivities against central differences of the program's own steps: every effect of the samples, every parameter
!> that it can be differentiated by, named as the scene's key, and every start.
submodule(suites_of_effects) test_tangent_differences
   use nutate_body, only: body_t, make_body
   use nutate_variation, only: attitude_variation, variation_t, inertia_variation, rate_variation
   use nutate_effect, only: effect_t
   use nutate_effect_catalogue, only: effect_kind_t, effect_kinds
   use nutate_orbital_effects, only: build_on_orbit, goes_by_orbit
   use nutate_controller, only: controller_t
   use nutate_controller_group, only: gain_changes
   use nutate_controller_mounting, only: add_controller
   use nutate_keys, only: group_t, KEY_REAL
   use nutate_kinds, only: wp
   use nutate_methods, only: integrator_settings_t, make_stepper, stepper_t
   use nutate_quaternion, only: cross, quat_conjugate, quat_exp, quat_product
   use nutate_scene, only: parse_scene, read_scene, scene_t
   use nutate_state, only: state_t
   use nutate_status, only: status_t
   use nutate_tangent, only: tangent_t
   use nutate_wheel, only: wheel_t
   use nutate_wheel_mounting, only: add_wheel
   use test_problems, only: body_momentum, make_state, new_system, system_t
   use test_support, only: check, check_below, error_type, in_turn, new_unittest, test_failed
   implicit none

   !> Start: attitude and rate; body; step, number of steps and first time, s.
   real(wp), parameter :: first_attitude(4) = [0.7_wp, -0.5_wp, 0.1_wp, 0.5_wp]
   real(wp), parameter :: first_rate(3) = [0.7_wp, -1.1_wp, 0.9_wp]
   real(wp), parameter :: inertia(3, 3) = reshape([4.0_wp, 0.5_wp, -0.25_wp, 0.5_wp, 5.0_wp, 0.75_wp, -0.25_wp, &
                                                   0.75_wp, 6.0_wp], [3, 3])
   character, parameter :: nl = new_line('a')
   !> Keys by which effects are not differentiated here.
   character(len=*), parameter :: without_derivative(5) = [character(len=13) :: 'start', 'stop', 'sun', &
      'shadow_radius', 'target']
   real(wp), parameter :: mass = 2.0_wp, center(3) = [0.3_wp, -0.2_wp, 0.5_wp]
   real(wp), parameter :: time_step = 0.1_wp, first_time = 0.8_wp
   integer, parameter :: steps = 4

   !> A scene's groups of effects on a body, from a start: what is varied.
   type :: variant_t
      type(group_t), allocatable :: groups(:)
      real(wp) :: inertia(3, 3) = inertia, center(3) = center
      real(wp) :: turn(3) = 0.0_wp, rate(3) = first_rate
   contains
      procedure :: build
   end type variant_t

   type(integrator_settings_t), parameter :: settings(7) = [ &
      integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=2), &
      integrator_settings_t(method='nielsen_krenk', formulation='full', order=2), &
      integrator_settings_t(method='nielsen_krenk', formulation='reduced', order=4), &
      integrator_settings_t(method='nielsen_krenk', formulation='full', order=8), &
      integrator_settings_t(method='rk4'), &
      integrator_settings_t(method='rk8'), &
      integrator_settings_t(method='taylor', series_order=24)]

contains

   module procedure collect_tangent_differences
      testsuite = [ &
                  new_unittest("every effect by itself", differ_alone), &
                  new_unittest("all effects together", differ_together), &
                  new_unittest("all effects on an orbit", differ_on_orbit), &
                  new_unittest("orbits of all shapes", differ_along_orbits), &
                  new_unittest("a controller by wheels", differ_by_wheels), &
                  new_unittest("effects that cannot be differentiated are refused", refuse_effects)]
   end procedure collect_tangent_differences

   !> The system and its first state.
   subroutine build(self, system, state, status)
      class(variant_t), intent(in) :: self
      type(system_t), intent(out) :: system
      type(state_t), intent(out) :: state
      type(status_t), intent(out) :: status
      type(effect_kind_t), allocatable :: kinds(:)
      class(effect_t), allocatable :: effect
      type(body_t) :: nominal
      real(wp) :: q(4)
      integer :: i, k
      call make_body(inertia, nominal, status)
      call make_body(self%inertia, system%body, status, mass=mass, center_of_mass=self%center)
      allocate (kinds, source=effect_kinds(with_keys=.false.))
      do i = 1, size(self%groups)
         do k = 1, size(kinds)
            if (kinds(k)%group%name /= self%groups(i)%name) cycle
            if (system%effects%on_orbit .and. goes_by_orbit(self%groups(i))) then
               call build_on_orbit(self%groups(i), system%effects%orbit, system%body, effect, status)
            else if (self%groups(i)%name == 'controller') then
               ! Controllers are designed for a body, not varied with it.
               call kinds(k)%build(self%groups(i), nominal, effect, status)
            else
               call kinds(k)%build(self%groups(i), system%body, effect, status)
            end if
            if (.not. status%ok()) return
            select type (effect)
            type is (wheel_t)
               call add_wheel(system, effect, status)
            type is (controller_t)
               call add_controller(system, effect, status)
            class default
               call system%effects%add(effect)
            end select
            deallocate (effect)
         end do
      end do
      q = quat_product(first_attitude, quat_exp(0.5_wp*self%turn))
      state = make_state(system, q, self%rate, first_time)
   end subroutine build

   !> Checks each group of the samples by itself.
   subroutine differ_alone(error)
      type(error_type), allocatable, intent(out) :: error
      type(variant_t) :: variant
      class(scene_t), allocatable :: scene
      integer :: i
      allocate (scene)
      call read_samples('test/effect_samples.nml', scene, error)
      if (allocated(error)) return
      do i = 1, size(scene%groups)
         if (.not. is_effect(scene%groups(i))) cycle
         variant%groups = [scene%groups(i)]
         call compare(error, variant, trim(scene%groups(i)%name))
         if (allocated(error)) return
      end do
   end subroutine differ_alone

   subroutine differ_together(error)
      type(error_type), allocatable, intent(out) :: error
      type(variant_t) :: variant
      class(scene_t), allocatable :: scene
      allocate (scene)
      call read_samples('test/effect_samples.nml', scene, error)
      if (allocated(error)) return
      variant%groups = pack_effects(scene)
      call compare(error, variant, 'all effects')
   end subroutine differ_together

   subroutine differ_on_orbit(error)
      type(error_type), allocatable, intent(out) :: error
      type(variant_t) :: variant
      class(scene_t), allocatable :: scene
      allocate (scene)
      call read_samples('test/orbit_samples.nml', scene, error)
      if (allocated(error)) return
      variant%groups = pack_effects(scene)
      call compare(error, variant, 'orbit')
   end subroutine differ_on_orbit

   !> Checks effects that use an orbit in inertial axes: an ellipse, a flyby by its periapsis, and several fast
   !> revolutions.
   subroutine differ_along_orbits(error)
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: angles = 'inclination = 0.5, raan = 0.3, argument_of_periapsis = -0.7, '
      character(len=*), parameter :: controllers = &
         "&controller law = 'quaternion', by = 'magnetorquers', target = 0.8, 0.0, 0.6, 0.0, target_from = 'lvlh', "// &
         "attitude_gain = 0.3, rate_gain_matrix = 0.9, 1.1, 1.3, 0.1, 0.2, -0.1 /"//nl// &
         "&controller law = 'bdot', gain = 0.5 /"//nl
      character(len=*), parameter :: effects = '&gravity_gradient /'//nl// &
         '&third_degree third_moments = 0.5, -0.2, 0.35, 0.1, -0.15, 0.05, 0.25, -0.1, -0.3, 0.15 /'//nl// &
         '&earth_field moment = 0.4, -0.3, 0.5, epoch_angle = 0.7, coefficients = 3e-20, -1e-20, 5e-20 /'//nl
      character(len=*), parameter :: force = &
         "&force axes = 'lvlh', body_point = -0.2, 0.5, 0.3, force = 0.5, -0.4, 0.7 /"//nl
      character(len=*), parameter :: timed = &
         "&force axes = 'lvlh', start = 0.5, stop = 1.5, body_point = 0.5, 0.2, -0.4, force = -0.3, 0.8, 0.6 /"//nl
      call compare_text(error, '&orbit semi_major_axis = 2.0, eccentricity = 0.3, mean_anomaly = 0.4, mu = 3.0, '// &
                        angles//"/"//nl//effects//timed//controllers, 'ellipse')
      call compare_text(error, '&orbit semi_major_axis = 2.0, mean_anomaly = 0.4, mu = 3.0, '//angles// &
                        "frame = 'lvlh' /"//nl//effects//controllers, 'circle')
      call compare_text(error, '&orbit periapsis_distance = 1.5, eccentricity = 1.3, periapsis_time = 0.7, '// &
                        'mu = 3.0, '//angles//'/'//nl//effects//force//controllers, 'flyby')
      call compare_text(error, '&orbit periapsis_distance = 1.0, eccentricity = 0.3, periapsis_time = 0.1, '// &
                        'mu = 400.0, '//angles//'/'//nl//force//timed// &
                        "&controller law = 'quaternion', target = 0.8, 0.0, 0.6, 0.0, target_from = 'lvlh', "// &
                        "attitude_gain_matrix = 0.3, 0.1, -0.2, 0.05, 0.4, 0.15, 0.25, -0.1, 0.5, "// &
                        'rate_gain = 0.02, inertia = 3.0, 4.0, 5.0 /'//nl, 'revolutions', last=6)
   end subroutine differ_along_orbits

   !> The motors of wheels, which the conserving scheme does not have.
   subroutine differ_by_wheels(error)
      type(error_type), allocatable, intent(out) :: error
      call compare_text(error, &
         '&orbit semi_major_axis = 2.0, eccentricity = 0.3, mean_anomaly = 0.4, mu = 3.0, inclination = 0.5 /'//nl// &
         '&wheel axis = 1.0, -2.0, 2.0, inertia = 0.4, speed = 3.0, friction = 0.05 /'//nl// &
         '&wheel axis = 2.0, 1.0, 1.0, inertia = 0.3, speed = -1.0 /'//nl// &
         "&controller law = 'quaternion', by = 'wheels', target = 0.8, 0.0, 0.6, 0.0, target_from = 'lvlh', "// &
         "attitude_gain = 0.3, rate_gain = 0.5 /"//nl, 'wheels', first=5, last=6)
   end subroutine differ_by_wheels

   !> All columns of a scene's effects.
   subroutine compare_text(error, text, label, first, last)
      type(error_type), allocatable, intent(inout) :: error
      character(len=*), intent(in) :: text, label
      !> The first and the last of the settings; default: all of them.
      integer, intent(in), optional :: first, last
      type(variant_t) :: variant
      class(scene_t), allocatable :: scene
      type(status_t) :: status
      character(len=:), allocatable :: message
      allocate (scene)
      if (allocated(error)) return
      call parse_scene('&body inertia = 4.0, 5.0, 6.0, mass = 2.0 /'//nl//text//nl// &
                       '&initial euler = 0.4, 1.1, -0.7, angular_velocity = 0.7, -1.1, 0.9 /'//nl// &
                       "&integrator method = 'rk4', time_step = 0.05, end_time = 5.0 /"//nl, 's.nml', &
                       scene, status, message)
      call check(error, status%ok(), message)
      if (allocated(error)) return
      variant%groups = pack_effects(scene)
      call compare(error, variant, label, first, last)
   end subroutine compare_text

   !> The groups of a scene that are effects.
   function pack_effects(scene) result(groups)
      type(scene_t), intent(in) :: scene
      type(group_t), allocatable :: groups(:)
      integer :: i
      allocate (groups(0))
      do i = 1, size(scene%groups)
         if (is_effect(scene%groups(i))) groups = [groups, scene%groups(i)]
      end do
   end function pack_effects

   logical function is_effect(group)
      type(group_t), intent(in) :: group
      is_effect = all(group%name /= [character(len=12) :: 'scene', 'body', 'initial', 'integrator', 'output'])
   end function is_effect

   subroutine read_samples(file, scene, error)
      character(len=*), intent(in) :: file
      type(scene_t), intent(inout) :: scene
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      character(len=:), allocatable :: message
      call read_scene(file, scene, status, message)
      call check(error, status%ok(), message)
   end subroutine read_samples

   !> All columns of a variant by all settings.
   subroutine compare(error, variant, label, first, last)
      type(error_type), allocatable, intent(inout) :: error
      type(variant_t), intent(in) :: variant
      character(len=*), intent(in) :: label
      type(variant_t) :: varied
      !> The first and the last of the settings; default: all of them.
      integer, intent(in), optional :: first, last
      type(variation_t), allocatable :: columns(:)
      type(variant_t), allocatable :: shifted(:, :)
      real(wp), allocatable :: shifts(:)
      type(system_t), pointer :: system
      type(state_t) :: state, before
      type(status_t) :: status
      type(tangent_t) :: tangent
      class(stepper_t), allocatable :: stepper
      integer :: i, k, m, from, to
      system => new_system()
      varied = variant
      from = 1
      if (present(first)) from = first
      to = size(settings)
      if (present(last)) to = last
      call varied%build(system, state, status)
      call check(error, status%ok(), label//': '//status%message)
      if (allocated(error)) return
      do m = from, to
         if (.not. in_turn(m + len(label))) cycle
         if (settings(m)%method == 'taylor') varied%groups = without_controllers(variant)
         call varied%build(system, state, status)
         if (settings(m)%method == 'taylor' .or. .not. allocated(columns)) &
            call list_variations(varied, system, columns, shifted, shifts, error)
         if (allocated(error)) return
         call tangent%begin(system, state, columns, status)
         if (status%ok()) call make_stepper(system, settings(m), stepper, status)
         do i = 1, steps
            if (.not. status%ok()) exit
            before = state
            call stepper%step(system, state, time_step, status)
            if (status%ok()) &
               call stepper%propagate(system, before, state, time_step, before%t + 0.5_wp*time_step, tangent, status)
         end do
         call check(error, status%ok(), label//': '//status%message)
         if (allocated(error)) return
         do k = 1, size(columns)
            ! Of many effects together, other columns by each method.
            if (size(variant%groups) > 4 .and. .not. in_turn(k + m/3)) cycle
            call compare_sensitivity(error, tangent, k, shifted(:, k), shifts(k), settings(m), &
                                label//' '//trim(settings(m)%method)//' '//trim(settings(m)%formulation))
         end do
      end do
   end subroutine compare

   !> The groups of a variant that have a series.
   function without_controllers(variant) result(groups)
      type(variant_t), intent(in) :: variant
      type(group_t), allocatable :: groups(:)
      integer :: i
      allocate (groups(0))
      do i = 1, size(variant%groups)
         if (variant%groups(i)%name /= 'controller') groups = [groups, variant%groups(i)]
      end do
   end function without_controllers

   !> A column against differences of 1 and ½ of a shift, extrapolated.
   subroutine compare_sensitivity(error, tangent, k, shifted, shift, how, label)
      type(error_type), allocatable, intent(inout) :: error
      type(tangent_t), intent(in) :: tangent
      integer, intent(in) :: k
      !> Variants shifted by +1, -1, +½, -½.
      type(variant_t), intent(in) :: shifted(4)
      real(wp), intent(in) :: shift
      type(integrator_settings_t), intent(in) :: how
      character(len=*), intent(in) :: label
      type(state_t) :: ends(4)
      type(system_t), pointer :: system
      class(stepper_t), allocatable :: stepper
      type(status_t) :: status
      real(wp) :: difference(14, 2), column(14), work(4), size_of
      integer :: i, j, n
      system => new_system()
      do i = 1, 4
         call shifted(i)%build(system, ends(i), status)
         if (status%ok()) call make_stepper(system, how, stepper, status)
         work(i) = 0.0_wp
         do j = 1, steps
            if (.not. status%ok()) exit
            call stepper%step(system, ends(i), time_step, status)
            n = size(stepper%work)
            if (system%effects%moves) n = n - 1
            work(i) = work(i) + sum(stepper%work(:n))
         end do
         call check(error, status%ok(), label//': '//status%message)
         if (allocated(error)) return
      end do
      difference(:, 1) = difference_of(ends(1), ends(2), work(1) - work(2), shift)
      difference(:, 2) = difference_of(ends(3), ends(4), work(3) - work(4), 0.5_wp*shift)
      difference(:, 2) = (4*difference(:, 2) - difference(:, 1))/3
      column = 0.0_wp
      column(1:6) = [tangent%theta(k, :), tangent%momentum(k, :)]
      column(7) = tangent%work(k)
      ! Series leave the work where potentials move.
      if (how%method == 'taylor' .and. system%effects%moves) column(7) = difference(7, 2)
      column(8:7 + size(tangent%wheels, 2)) = tangent%wheels(k, :)
      size_of = max(maxval(abs(column)), 1e-3_wp/shift)
      call check_below(error, maxval(abs(column - difference(:, 2)))/size_of, 1e-8_wp, &
                       label//' '//trim(tangent%variations(k)%name))
   end subroutine compare_sensitivity

   !> (q1, L1, work, h1) against (q2, L2, work, h2) over twice a shift; shape (14).
   pure function difference_of(one, other, work, shift) result(difference)
      type(state_t), intent(in) :: one, other
      real(wp), intent(in) :: work, shift
      real(wp) :: difference(14), turn(4)
      turn = quat_product(quat_conjugate(other%q), one%q)
      difference = 0.0_wp
      difference(1:3) = turn(2:4)/shift
      difference(4:6) = (body_momentum(one) - body_momentum(other))/(2*shift)
      difference(7) = work/(2*shift)
      difference(8:14) = (one%wheel_momentum(1:7) - other%wheel_momentum(1:7))/(2*shift)
   end function difference_of

   !> Columns of the start, of the body, and of each parameter of each group; their variants by four shifts.
   subroutine list_variations(variant, system, columns, shifted, shifts, error)
      type(variant_t), intent(in) :: variant
      type(system_t), intent(in) :: system
      type(variation_t), allocatable, intent(out) :: columns(:)
      type(variant_t), allocatable, intent(out) :: shifted(:, :)
      real(wp), allocatable, intent(out) :: shifts(:)
      type(error_type), allocatable, intent(inout) :: error
      real(wp), parameter :: parts(4) = [1.0_wp, -1.0_wp, 0.5_wp, -0.5_wp]
      integer :: i, j, k, m, n, number
      allocate (columns(100), shifts(100), shifted(4, 100))
      shifts = 2e-3_wp
      n = 0
      do k = 1, 3
         columns(n + 1) = attitude_variation(k)
         columns(n + 2) = rate_variation(k)
         columns(n + 3)%name = 'mass_moment'
         columns(n + 3)%mass_moment(k) = mass
         do i = 1, 4
            shifted(i, n + 1:n + 3) = [variant, variant, variant]
            shifted(i, n + 1)%turn(k) = parts(i)*shifts(1)
            shifted(i, n + 2)%rate(k) = first_rate(k) + parts(i)*shifts(1)
            shifted(i, n + 3)%center(k) = center(k) + parts(i)*shifts(1)
         end do
         n = n + 3
         do m = 1, k
            n = n + 1
            columns(n) = inertia_variation(m, k)
            do i = 1, 4
               shifted(i, n) = variant
               shifted(i, n)%inertia = inertia + parts(i)*shifts(n)*columns(n)%inertia
            end do
         end do
      end do
      do j = 1, size(variant%groups)
         number = 1
         do i = 1, j - 1
            if (variant%groups(i)%name == variant%groups(j)%name) number = number + 1
         end do
         ! Potentials come before torques: of three forces the last one.
         if (count(variant%groups%name == 'force') == 3 .and. variant%groups(j)%name == 'force') &
            number = 1 + modulo(number, 3)
         call list_keys(variant, system, j, number, columns, shifted, shifts, n, error)
      end do
      columns = columns(:n)
      shifts = shifts(:n)
      shifted = shifted(:, :n)
   end subroutine list_variations

   !> Adds the variations of the numbers of one group.
   subroutine list_keys(variant, system, j, number, columns, shifted, shifts, n, error)
      type(variant_t), intent(in) :: variant
      type(system_t), intent(in) :: system
      !> The group, and its number among those of its name.
      integer, intent(in) :: j, number
      type(variation_t), intent(inout) :: columns(:)
      type(variant_t), intent(inout) :: shifted(:, :)
      real(wp), intent(inout) :: shifts(:)
      integer, intent(inout) :: n
      type(error_type), allocatable, intent(inout) :: error
      type(status_t) :: status
      real(wp), allocatable :: change(:)
      real(wp), parameter :: parts(4) = [1.0_wp, -1.0_wp, 0.5_wp, -0.5_wp]
      integer :: i, k, m
      associate (group => variant%groups(j))
         do k = 1, size(group%settings)
            associate (setting => group%settings(k))
               if (.not. allocated(setting%values)) cycle
               if (any(setting%name == without_derivative) .or. setting%kind /= KEY_REAL) cycle
               ! The distribution of a controller's torque among wheels depends on their axes.
               if (setting%name == 'axis' .and. variant%groups(size(variant%groups))%text('by', '') == 'wheels') cycle
               do m = 1, size(setting%values)
                  allocate (change(size(setting%values)), source=0.0_wp)
                  change(m) = 1.0_wp
                  n = n + 1
                  columns(n) = variation_t()
                  select case (group%name)
                  case ('rotor')
                     columns(n)%rotor = change
                  case ('rotating_frame')
                     columns(n)%frame = change
                  case ('force')
                     call add_force(group, setting%name, change, system, number, columns(n), status)
                  case ('controller')
                     call add_to_controller(group, setting%name, change, system, number, columns(n), status)
                  case default
                     call columns(n)%add(system%effects, trim(group%name), number, trim(setting%name), &
                                         change, status)
                  end select
                  deallocate (change)
                  if (.not. status%ok()) then
                     call test_failed(error, trim(status%message))
                     return
                  end if
                  columns(n)%name = trim(group%name)//'.'//trim(setting%name)
                  shifts(n) = 2e-3_wp*max(maxval(abs(setting%values%number)), 1e-300_wp)
                  if (.not. maxval(abs(setting%values%number)) > 0.0_wp) shifts(n) = 2e-3_wp
                  if (group%name == 'orbit') shifts(n) = 0.25_wp*shifts(n)
                  do i = 1, 4
                     shifted(i, n) = variant
                     associate (value => shifted(i, n)%groups(j)%settings(k)%values(m))
                        value%number = value%number + parts(i)*shifts(n)
                     end associate
                  end do
               end do
            end associate
         end do
      end associate
   end subroutine list_keys

   !> The force of body axes is a torque, x×F.
   subroutine add_force(group, key, change, system, number, column, status)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: change(3)
      type(system_t), intent(in) :: system
      integer, intent(in) :: number
      type(variation_t), intent(inout) :: column
      type(status_t), intent(inout) :: status
      real(wp), parameter :: none(3) = 0.0_wp
      if (group%text('axes', '') /= 'body') then
         call column%add(system%effects, 'force', number, key, change, status)
      else if (key == 'force') then
         call column%add(system%effects, 'force', number, 'torque', cross(group%vector('body_point', none), change), &
                         status)
      else
         call column%add(system%effects, 'force', number, 'torque', cross(change, group%vector('force', none)), status)
      end if
   end subroutine add_force

   !> Gains are what a key and the inertia make of them.
   subroutine add_to_controller(group, key, change, system, number, column, status)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      real(wp), intent(in) :: change(:)
      type(system_t), intent(in) :: system
      integer, intent(in) :: number
      type(variation_t), intent(inout) :: column
      type(status_t), intent(inout) :: status
      real(wp) :: of_attitude(9), of_rate(9)
      if (any(key == ['gain ', 'field'])) then
         call column%add(system%effects, 'controller', number, key, change, status)
         return
      end if
      call gain_changes(group, inertia, key, change, of_attitude, of_rate)
      call column%add(system%effects, 'controller', number, 'attitude_gain_matrix', of_attitude, status)
      call column%add(system%effects, 'controller', number, 'rate_gain_matrix', of_rate, status)
   end subroutine add_to_controller

   !> A controller that samples, unknown parameters: rejected by name.
   subroutine refuse_effects(error)
      type(error_type), allocatable, intent(out) :: error
      type(variant_t) :: variant
      class(scene_t), allocatable :: scene
      type(system_t), pointer :: system
      type(state_t) :: state
      type(variation_t) :: column
      type(status_t) :: status
      system => new_system()
      allocate (scene)
      call read_samples('test/effect_samples.nml', scene, error)
      if (allocated(error)) return
      variant%groups = pack_effects(scene)
      call variant%build(system, state, status)
      call column%add(system%effects, 'dipole', 1, 'frequency', [1.0_wp], status)
      call check(error, index(status%message, 'to frequency (expected moment(3), field(3))') > 0, &
                 trim(status%message))
      call column%add(system%effects, 'dipole', 1, 'moment', [1.0_wp], status)
      call check(error, index(status%message, 'dipole has no derivative with respect to moment '// &
                              '(expected moment(3)') > 0, trim(status%message))
      call column%add(system%effects, 'dipole', 0, 'moment', [1.0_wp, 0.0_wp, 0.0_wp], status)
      call check(error, index(status%message, 'no effect dipole') > 0, 'number 0: '//trim(status%message))
      call column%add(system%effects, 'dipole', 2, 'moment', [1.0_wp, 0.0_wp, 0.0_wp], status)
      call check(error, index(status%message, 'no effect dipole') > 0, trim(status%message))
      call column%add(system%effects, 'torque', 3, 'table', [1.0_wp], status)
      call check(error, index(status%message, 'torque has no derivative with respect to table') > 0, &
                 trim(status%message))
   end subroutine refuse_effects

end submodule test_tangent_differences
