!> Sensitivities with respect to the free parameters of a scene: by the chain rule each is the change of initial state,
!> body and effects per unit of the parameter.
!>
!> Initial quantities that the scene computes (the inertia of a shape, the attitude of Euler angles) are differentiated
!> by five-point differences, the motion never: its derivative is the exact one of the method.
module nutate_fit_variations
   use nutate_attitude, only: rotation_vector_from_quat
   use nutate_body, only: whole_body
   use nutate_kepler_orbit, only: axes_change
   use nutate_orbit, only: frame_rate_change, axes_rate_change
   use nutate_variation, only: variation_t, OF_ORBIT
   use nutate_controller_group, only: gain_changes
   use nutate_hamiltonian, only: angular_velocity
   use nutate_keys, only: group_t
   use nutate_kinds, only: wp, pi
   use nutate_quaternion, only: cross, quat_conjugate, quat_product, rotate_to_body
   use nutate_scene, only: scene_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT
   use nutate_third_degree, only: change_of_third_moments
   implicit none
   private

   public :: add_scene, add_key, one_sided_places, one_sided_weights, places, weights

   !> Five-point differences, which are exact for polynomials of degree 4: points in steps, and weights times the step.
   integer, parameter :: places(4) = [-2, -1, 1, 2]
   real(wp), parameter :: weights(4) = [1.0_wp, -8.0_wp, 8.0_wp, -1.0_wp]/12
   !> One-sided differences at the limit of a key, which are exact for polynomials of degree 3.
   integer, parameter :: one_sided_places(4) = [0, 1, 2, 3]
   real(wp), parameter :: one_sided_weights(4) = [-11.0_wp, 18.0_wp, -9.0_wp, 2.0_wp]/6

contains

   !> Adds the contribution of a scene at a point of the stencil to the differences of initial state and body.
   subroutine add_scene(group, present_scene, scene, weight, variation)
      !> Name of the group of the parameter; blank for the attitude.
      character(len=*), intent(in) :: group
      type(scene_t), intent(in) :: present_scene, scene
      real(wp), intent(in) :: weight
      type(variation_t), intent(inout) :: variation
      select case (group)
      case ('body')
         associate (body => whole_body(scene%system%body))
            variation%inertia = variation%inertia + weight*body%inertia
            variation%mass = variation%mass + weight*body%mass
            variation%mass_moment = variation%mass_moment + weight*body%mass*body%center_of_mass
         end associate
      case ('rotor')
         variation%rotor = variation%rotor + weight*scene%system%effects%rotor_momentum
      case default
         if (group == 'rotating_frame') variation%frame = variation%frame + weight*scene%system%effects%frame_rate
         variation%attitude = variation%attitude + weight*rotation_vector_from_quat( &
                           quat_product(quat_conjugate(present_scene%initial%q), scene%initial%q))
         variation%angular_velocity = variation%angular_velocity + weight*angular_velocity(scene%system, scene%initial)
      end select
   end subroutine add_scene

   !> Adds the change of an effect by one of its numbers. Errors: `NUTATE_BAD_ARGUMENT` if the effect has no derivative
   !> by it.
   subroutine add_key(scene, group, key, value, numbers, name, variation, status)
      type(scene_t), intent(in) :: scene
      !> Index of the group among those of the scene.
      integer, intent(in) :: group
      character(len=*), intent(in) :: key
      !> Index of the number in its key, and how many numbers the key has.
      integer, intent(in) :: value, numbers
      !> Name of the free parameter, for messages.
      character(len=*), intent(in) :: name
      type(variation_t), intent(inout) :: variation
      type(status_t), intent(out) :: status
      real(wp) :: change(numbers), of_attitude(9), of_rate(9)
      real(wp), allocatable :: of_parameter(:)
      character(len=24) :: parameter
      change = 0.0_wp
      change(value) = 1.0_wp
      associate (given => scene%groups(group), effects => scene%system%effects)
         if (given%name == 'controller' .and. (index(key, '_gain') > 0 .or. key == 'inertia')) then
            call gain_changes(given, scene%nominal%inertia, key, change, of_attitude, of_rate)
            call variation%add_of_group(effects, group, 'attitude_gain_matrix', of_attitude, status)
            if (status%ok()) call variation%add_of_group(effects, group, 'rate_gain_matrix', of_rate, status)
         else if (key == 'inertia_scale') then
            ! The group of the body has other tables, too.
            call variation%add(effects, 'inertia_table', 1, key, change, status)
         else
            call find_parameter(given, key, change, parameter, of_parameter)
            call variation%add_of_group(effects, group, trim(parameter), of_parameter, status)
         end if
      end associate
      if (status%ok()) call follow_start(scene, variation, status)
      if (.not. status%ok()) status = fail(NUTATE_BAD_ARGUMENT, 'the motion has no derivative with respect to '// &
                                           trim(name)//': '//trim(status%message))
   end subroutine add_key

   !> Adds the change of the initial state by an effect's numbers: of attitude and rate that are given relative to an
   !> orbit. Errors: `NUTATE_BAD_ARGUMENT` for the initial state of a resonance, which the effects define.
   subroutine follow_start(scene, variation, status)
      type(scene_t), intent(in) :: scene
      type(variation_t), intent(inout) :: variation
      type(status_t), intent(inout) :: status
      real(wp) :: turn(3), rate(3), transport(3)
      integer :: i, m
      if (.not. allocated(variation%effects)) return
      associate (initial => scene%groups(findloc(scene%groups%name, 'initial', dim=1)), &
                 effects => scene%system%effects, q => scene%initial%q)
         if (initial%has('resonance')) status = fail(NUTATE_BAD_ARGUMENT, 'it changes the start of the resonance '// &
            '(expected a start without resonance)')
         do m = 1, size(variation%effects)
            if (variation%effects(m)%kind /= OF_ORBIT) cycle
            i = variation%effects(m)%place
            associate (orbit => effects%orbits(i), change => variation%effects(m)%change)
               turn = 0.0_wp
               rate = 0.0_wp
               transport = 0.0_wp
               if (orbit%label /= effects%orbit%label) cycle
               if (initial%text('attitude_from', 'space') == 'lvlh' .and. .not. orbit%is_frame) &
                  turn = rotate_to_body(q, axes_change(orbit%path, change, 0.0_wp))
               if (initial%text('frame', 'body') == 'space') transport = angular_velocity(scene%system, scene%initial)
               if (initial%text('rate_from', 'inertial') == 'lvlh') then
                  rate = axes_rate_change(orbit, change, 0.0_wp)
                  if (initial%text('frame', 'body') == 'body') transport = rotate_to_body(q, orbit%axes_rate(0.0_wp))
               else if (initial%text('rate_from', 'inertial') == 'frame') then
                  rate = frame_rate_change(orbit, change)
               end if
               variation%attitude = variation%attitude + turn
               ! A vector fixed in space rotates in body axes when the attitude changes.
               variation%angular_velocity = variation%angular_velocity + rotate_to_body(q, rate) + cross(transport, &
                  turn)
            end associate
         end do
      end associate
   end subroutine follow_start

   !> Finds the parameter of an effect that a key changes: that of its name, unless the effect is made from other
   !> numbers.
   pure subroutine find_parameter(group, key, change, parameter, of_parameter)
      type(group_t), intent(in) :: group
      character(len=*), intent(in) :: key
      !> Change of the numbers of the key.
      real(wp), intent(in) :: change(:)
      character(len=*), intent(out) :: parameter
      real(wp), allocatable, intent(out) :: of_parameter(:)
      real(wp), parameter :: none(3) = 0.0_wp
      character(len=*), parameter :: angles(4) = [character(len=21) :: 'inclination', 'raan', &
                                                  'argument_of_periapsis', 'mean_anomaly']
      character(len=*), parameter :: edges(2) = [character(len=5) :: 'start', 'stop']
      integer :: n
      parameter = key
      of_parameter = change
      select case (group%name)
      case ('earth_field')
         if (key == 'epoch_angle' .and. group%flag('degrees', .false.)) of_parameter = (pi/180)*change
      case ('third_degree')
         if (key /= 'points') return
         parameter = 'third_moments'
         n = size(change)
         of_parameter = change_of_third_moments(reshape(group%vector('points', spread(0.0_wp, 1, n)), [4, n/4]), &
                                                reshape(change, [4, n/4]))
      case ('orbit')
         if (key == 'altitude') parameter = 'semi_major_axis'
         if (any(key == angles) .and. group%flag('degrees', .false.)) of_parameter = (pi/180)*change
      case ('force')
         if (group%text('axes', 'space') /= 'body' .or. any(key == edges)) return
         parameter = 'torque'
         if (key == 'force') of_parameter = cross(group%vector('body_point', none), change)
         if (key == 'body_point') of_parameter = cross(change, group%vector('force', none))
      case default
         continue
      end select
   end subroutine find_parameter

end module nutate_fit_variations
