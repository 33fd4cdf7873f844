!> Limits and samples, which a run watches besides events: controllers take their samples at the ends of steps; the
!> speed of wheels and the output of controllers have limits.
module nutate_control
   use nutate_effect_list, only: effect_list_t, command_of_wheel
   use nutate_event_list, only: event_list_t
   use nutate_hamiltonian, only: angular_velocity, system_t
   use nutate_kinds, only: wp
   use nutate_motion, only: find_velocities
   use nutate_quaternion, only: quat_normalized
   use nutate_saturation_count, only: side_of_limit, note_saturation
   use nutate_saturation, only: add_saturations, can_jump, can_saturate, free_senses, note_saturations
   use nutate_speed_limits, only: add_speed_limits, has_speed_limits, find_speed_limits
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_OFF_BRANCH
   implicit none
   private

   public :: beyond_accuracy, check_sampling, free_senses, is_watched, limit_events, &
      needs_control, next_sample, find_limits, take_samples

   !> Rotation between two samples, rad, beyond which no controller follows the motion: 16 000 revolutions.
   real(wp), parameter :: longest_rotation = 1e5_wp

contains

   !> Returns true if only a run can determine what acts: wheels with limits of their speed, controllers that take
   !> samples or have limits.
   pure logical function needs_control(effects)
      type(effect_list_t), intent(in) :: effects
      needs_control = has_speed_limits(effects) .or. can_saturate(effects) .or. has_samples(effects)
   end function needs_control

   !> Returns true if runs watch limits, samples, or zeros of e₀, at which control laws that act at all times jump.
   pure logical function is_watched(effects)
      type(effect_list_t), intent(in) :: effects
      is_watched = needs_control(effects) .or. can_jump(effects)
   end function is_watched

   !> Returns the reason why no accuracy can be promised, in words; empty if it can.
   pure function beyond_accuracy(effects, switches) result(words)
      type(effect_list_t), intent(in) :: effects
      !> Events switch something.
      logical, intent(in) :: switches
      character(len=:), allocatable :: words
      words = ''
      if (switches) words = 'accuracy is not available where events switch effects'
      if (needs_control(effects)) words = 'accuracy is not available where a wheel has a speed_limit or a '// &
                                          'controller has a sample or limits'
   end function beyond_accuracy

   !> Returns the events of all limits.
   function limit_events(effects) result(events)
      type(effect_list_t), intent(in) :: effects
      type(event_list_t) :: events
      call add_speed_limits(effects, events)
      call add_saturations(effects, events)
   end function limit_events

   !> Finds out which wheels and controllers are at, or beyond, their limits.
   pure subroutine find_limits(system, state)
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      call find_speed_limits(system, state)
      call note_saturations(system, state)
   end subroutine find_limits

   pure logical function has_samples(effects)
      type(effect_list_t), intent(in) :: effects
      integer :: i
      has_samples = .false.
      do i = 1, effects%n_torques
         has_samples = has_samples .or. effects%torques(i)%item%sample > 0.0_wp
      end do
   end function has_samples

   !> Returns the next time at which a controller takes a sample, starts or stops, s; huge if none does.
   pure real(wp) function next_sample(effects, t, sense) result(next)
      type(effect_list_t), intent(in) :: effects
      !> Present time, s, and direction of time: 1 or -1.
      real(wp), intent(in) :: t, sense
      real(wp) :: one
      integer :: i
      next = sense*huge(next)
      do i = 1, effects%n_torques
         if (.not. effects%torques(i)%item%sample > 0.0_wp) cycle
         one = effects%torques(i)%item%next_break(t, sense)
         if (sense*one < sense*next) next = one
      end do
   end function next_sample

   !> Takes the samples that are due: those of their time, and of controllers that have been switched.
   subroutine take_samples(system, state, sense, margin, changed)
      type(system_t), intent(inout) :: system
      type(state_t), intent(in) :: state
      !> 1: forward in time; -1: backward.
      real(wp), intent(in) :: sense
      !> Times nearer to each other than this are one, s.
      real(wp), intent(in) :: margin
      !> A controller has taken a sample.
      logical, intent(out) :: changed
      real(wp) :: omega(3), momentum(3), relative(3)
      integer :: i
      changed = .false.
      do i = 1, system%effects%n_torques
         associate (controller => system%effects%torques(i)%item)
            if (.not. controller%sample > 0.0_wp) cycle
            if (sense*(controller%next_break(state%t - 2*sense*margin, sense) - state%t) > margin .and. &
                (controller%on .eqv. controller%was_on)) cycle
            if (.not. changed) call find_velocities(system, state, omega, momentum, relative)
            changed = .true.
            call controller%hold(state%t, quat_normalized(state%q), relative, state%t + 2*sense*margin)
         end associate
      end do
      if (changed) call command_wheels(system%effects, state%t)
   end subroutine take_samples

   !> Errors: `NUTATE_OFF_BRANCH` for a body that a sampled controller has accelerated so much that steps would have no
   !> end.
   pure subroutine check_sampling(system, state, status)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(status_t), intent(inout) :: status
      integer :: i
      do i = 1, system%effects%n_torques
         associate (controller => system%effects%torques(i)%item)
            if (.not. (controller%on .and. controller%sample > 0.0_wp)) cycle
            if (norm2(angular_velocity(system, state)) <= longest_rotation/controller%sample) cycle
            status = fail(NUTATE_OFF_BRANCH, 'a sampled controller is unstable: the body turns by over 1e5 rad '// &
                          'from sample to sample (expected a shorter sample or smaller gains)')
         end associate
      end do
   end subroutine check_sampling

   !> Passes the commands that all controllers hold to the motors, cut off at their limits.
   pure subroutine command_wheels(effects, t)
      type(effect_list_t), intent(inout) :: effects
      !> Time, s.
      real(wp), intent(in) :: t
      real(wp) :: command
      integer :: k
      do k = 1, effects%n_reaction_wheels
         command = command_of_wheel(effects, k)
         associate (wheel => effects%wheels(k))
            wheel%command = max(-wheel%torque_limit, min(wheel%torque_limit, command))
            if (.not. allocated(wheel%motor)) &
               call note_saturation(wheel%saturations, t, [side_of_limit(command, wheel%torque_limit), 0, 0], &
                                    .true., t, t)
         end associate
      end do
   end subroutine command_wheels

end module nutate_control
