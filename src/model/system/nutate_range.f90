!> Checks of systems, attitudes, motions and steps against the limits of `nutate_limits`. Scene files, C and FORTRAN 77
!> call them before a run, and every method before its first step.
module nutate_range
   use nutate_effect, only: effect_t
   use nutate_hamiltonian, only: angular_velocity, system_t
   use nutate_kinds, only: wp
   use nutate_limits, only: attitude_tolerance, greatest_norm, greatest_turn, is_moderate, is_step, is_unit, &
      least_momentum, least_norm, in_words, greatest_number, least_step, greatest_step
   use nutate_quaternion, only: quat_norm, quat_normalized
   use nutate_small_products, only: times_vector
   use nutate_state, only: state_t
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_BAD_BODY
   use nutate_wheel_mounting, only: are_mounted
   implicit none
   private

   public :: check_system, check_strength, check_attitude, check_motion, check_step, check_start

contains

   !> Checks a system. Errors: `NUTATE_BAD_BODY` for a body that was not made; `NUTATE_BAD_ARGUMENT` for an effect whose
   !> numbers, energy or torque are too large, or that stops before it starts.
   pure subroutine check_system(system, status)
      type(system_t), intent(in) :: system
      type(status_t), intent(out) :: status
      integer :: i
      if (.not. all(system%body%moments > 0.0_wp)) then
         status = fail(NUTATE_BAD_BODY, 'the system has no body (expected one from make_body)', 'inertia')
         return
      end if
      associate (effects => system%effects)
         do i = 1, effects%n_potentials + effects%n_off
            if (status%ok()) call check_strength(effects%potentials(i)%item, status)
         end do
         do i = 1, effects%n_torques
            if (status%ok()) call check_strength(effects%torques(i)%item, status)
         end do
         if (status%ok() .and. .not. all(is_moderate(effects%rotor_momentum))) status = too_strong('rotor')
         if (status%ok() .and. .not. all(is_moderate(effects%frame_rate))) status = too_strong('rotating_frame')
         do i = 1, effects%n_wheels
            if (status%ok()) call check_strength(effects%wheels(i), status)
         end do
         if (status%ok() .and. .not. are_mounted(system)) &
            status = fail(NUTATE_BAD_BODY, 'the wheels are not mounted (expected them from add_wheel)', 'wheel')
      end associate
   end subroutine check_system

   !> Checks an effect. Errors: `NUTATE_BAD_ARGUMENT` for an effect whose numbers, energy or torque are too large, or
   !> that stops before it starts.
   pure subroutine check_strength(effect, status)
      class(effect_t), intent(in) :: effect
      type(status_t), intent(out) :: status
      real(wp) :: times(2)
      if (.not. effect%is_valid()) then
         status = too_strong(effect%name)
         return
      end if
      call effect%own_window(times(1), times(2))
      if (.not. times(2) > times(1)) status = fail(NUTATE_BAD_ARGUMENT, 'the effect '//known_as(effect%name)// &
                                                   ' stops before it starts (expected stop > start)', 'stop')
   end subroutine check_strength

   pure type(status_t) function too_strong(name)
      character(len=*), intent(in) :: name
      too_strong = fail(NUTATE_BAD_ARGUMENT, 'the effect '//known_as(name)//' is too strong (expected finite '// &
                        'numbers, energy and torque up to '//in_words(greatest_number)//' in SI units)')
   end function too_strong

   !> Returns how a message calls an effect.
   pure function known_as(name) result(known)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: known
      known = trim(name)
      if (name == '') known = 'unnamed'
   end function known_as

   !> Checks an attitude. Errors: `NUTATE_BAD_ARGUMENT` for one that is not a unit quaternion to the digits it is given
   !> with.
   pure subroutine check_attitude(q, status)
      !> Body→space; shape (4).
      real(wp), intent(in) :: q(4)
      type(status_t), intent(out) :: status
      character(len=24) :: norm
      character(len=80) :: unit
      if (is_unit(q, attitude_tolerance)) return
      if (.not. all(is_moderate(q))) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the quaternion is not finite (expected a norm of 1 to within '// &
                       in_words(attitude_tolerance)//')', 'quaternion')
      else if (any(abs(q) > 0.0_wp)) then
         write (norm, '(g0.8)') quat_norm(q)
         write (unit, '(3(f13.10,","),f13.10)') quat_normalized(q)
         status = fail(NUTATE_BAD_ARGUMENT, 'the norm of quaternion is '//trim(norm)//' (expected 1 to within '// &
                       in_words(attitude_tolerance)//': '//trim(adjustl(unit))//')', 'quaternion')
      else
         status = fail(NUTATE_BAD_ARGUMENT, 'the norm of quaternion is 0 (expected 1 to within '// &
                       in_words(attitude_tolerance)//')', 'quaternion')
      end if
   end subroutine check_attitude

   !> Checks a state. Errors: `NUTATE_BAD_ARGUMENT` for a state whose time, momentum or energy, or whose damping, is not
   !> finite or too large.
   pure subroutine check_motion(system, state, status)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      type(status_t), intent(out) :: status
      real(wp) :: omega(3), drag(3, 3)
      integer :: i
      if (.not. is_moderate(state%t)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the time is too large (expected up to '//in_words(greatest_number)// &
                       ' s)', 't')
      else if (.not. all(is_moderate(state%p))) then
         status = too_fast()
      else
         omega = angular_velocity(system, state)
         ! |p||Ω| bounds the kinetic energy, whatever the rotors.
         if (.not. is_moderate(maxval(abs(state%p))*max(maxval(abs(omega)), maxval(abs(system%effects%frame_rate))))) &
            status = too_fast()
         if (.not. all(is_moderate(state%wheel_momentum))) then
            status = too_fast()
         else if (.not. is_moderate(system%effects%wheel_energy(state%wheel_momentum))) then
            status = too_fast()
         end if
         do i = 1, system%effects%n_torques
            associate (torque => system%effects%torques(i)%item)
               drag = torque%series_drag()
               if (.not. all(is_moderate(times_vector(drag, omega)))) status = too_strong(torque%name)
            end associate
         end do
      end if
   end subroutine check_motion

   pure type(status_t) function too_fast()
      too_fast = fail(NUTATE_BAD_ARGUMENT, 'the rotation is too fast, or not finite (expected momentum p and '// &
                      '|p||omega| up to '//in_words(greatest_number)//' in SI units)', 'angular_velocity')
   end function too_fast

   !> Checks a step. Errors: `NUTATE_BAD_ARGUMENT` for a step that is zero, not finite, too short or too long, for any
   !> body or for this motion.
   pure subroutine check_step(system, state, dt, status)
      type(system_t), intent(in) :: system
      !> State that passes `check_motion`.
      type(state_t), intent(in) :: state
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      type(status_t), intent(out) :: status
      if (.not. is_step(dt)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the step is out of range (expected '// &
                       in_words(least_step, greatest_step)//' s in size)', 'time_step')
      else if (abs(dt)*maxval(abs(angular_velocity(system, state))) > greatest_turn) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the body turns by more than '//in_words(greatest_turn)//' rad in one '// &
                       'time_step (expected a shorter step)', 'time_step')
      else if (abs(dt)*maxval(abs(system%effects%frame_rate)) > greatest_turn) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the frame turns by more than '//in_words(greatest_turn)//' rad in one '// &
                       'time_step (expected a shorter step)', 'time_step')
      end if
   end subroutine check_step

   !> Checks the initial state of a run, within the limits of `check_attitude`. Errors: those of `check_motion` and
   !> `check_step`; `NUTATE_BAD_ARGUMENT` for a state without an attitude.
   pure subroutine check_start(system, state, dt, status)
      type(system_t), intent(in) :: system
      type(state_t), intent(in) :: state
      !> Length of the step, s.
      real(wp), intent(in) :: dt
      type(status_t), intent(out) :: status
      real(wp) :: momentum
      if (.not. is_attitude(state%q)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the attitude is not a unit quaternion')
         return
      end if
      call check_motion(system, state, status)
      if (.not. status%ok()) return
      momentum = maxval(abs(state%p))
      if (momentum > 0.0_wp .and. momentum < least_momentum) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the momentum has lost digits (expected 0, or above 2e-308 in SI units)')
      else
         call check_step(system, state, dt, status)
      end if
   end subroutine check_start

   !> Returns true if |q| is within a factor of two of 1.
   pure logical function is_attitude(q)
      real(wp), intent(in) :: q(4)
      is_attitude = all(is_moderate(q))
      if (is_attitude) is_attitude = norm2(q) >= least_norm .and. norm2(q) <= greatest_norm
   end function is_attitude

end module nutate_range
