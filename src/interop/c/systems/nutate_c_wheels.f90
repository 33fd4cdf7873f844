!> C interface: wheels, inner spheres, orbit and Jacobi integral of a stepper. The functions are documented in
!> `include/nutate_satellites.h`.
module nutate_c_wheels
   use, intrinsic :: iso_c_binding, only: c_double, c_int, c_ptr, c_size_t
   use nutate_attitude, only: roll_pitch_yaw_from_quat
   use nutate_c_effects, only: add_failure
   use nutate_c_stepper_handle, only: conclude, found, stepper_handle_t
   use nutate_c_reading, only: find_readable
   use nutate_c_settings, only: prepare_if_needed
   use nutate_effect_list, only: effect_list_t
   use nutate_hamiltonian, only: angular_velocity, conserved_energy
   use nutate_kinds, only: wp
   use nutate_limits, only: is_moderate
   use nutate_quaternion, only: quat_conjugate, quat_normalized, quat_product, rotate_to_space
   use nutate_status, only: status_t, fail, NUTATE_BAD_ARGUMENT, NUTATE_OK
   implicit none
   private

   public :: nutate_stepper_wheel_count, nutate_stepper_wheel, nutate_stepper_set_motor, nutate_stepper_sphere_count, &
      nutate_stepper_sphere, nutate_stepper_jacobi, nutate_stepper_time_dependent_work, nutate_stepper_orbit, &
      nutate_stepper_lvlh_attitude

contains

   integer(c_int) function nutate_stepper_wheel_count(stepper, n) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_size_t), intent(inout), optional :: n
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(n), .false., handle, code)
      if (code == NUTATE_OK) n = handle%system%effects%n_reaction_wheels
   end function nutate_stepper_wheel_count

   integer(c_int) function nutate_stepper_wheel(stepper, wheel, speed, momentum, work) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_size_t), intent(in), value :: wheel
      real(c_double), intent(inout), optional :: speed, momentum, work(2)
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, .true., .false., handle, code)
      if (code /= NUTATE_OK) return
      code = NUTATE_BAD_ARGUMENT
      if (wheel < 1 .or. wheel > handle%system%effects%n_reaction_wheels) return
      code = NUTATE_OK
      associate (state => handle%run%state, h => handle%run%state%wheel_momentum(wheel))
         if (present(speed)) &
            speed = handle%system%effects%wheels(wheel)%speed_of(h, angular_velocity(handle%system, state))
         if (present(momentum)) momentum = h
         if (present(work)) work = state%wheel_work(:, wheel)
      end associate
   end function nutate_stepper_wheel

   integer(c_int) function nutate_stepper_sphere_count(stepper, n) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_size_t), intent(inout), optional :: n
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(n), .false., handle, code)
      if (code == NUTATE_OK) n = handle%system%effects%n_spheres
   end function nutate_stepper_sphere_count

   integer(c_int) function nutate_stepper_sphere(stepper, sphere, rate, momentum, energy, work) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_size_t), intent(in), value :: sphere
      real(c_double), intent(inout), optional :: rate(3), momentum(3), energy, work
      type(stepper_handle_t), pointer :: handle
      integer :: last
      call find_readable(stepper, .true., .false., handle, code)
      if (code /= NUTATE_OK) return
      code = NUTATE_BAD_ARGUMENT
      if (sphere < 1 .or. sphere > handle%system%effects%n_spheres) return
      code = NUTATE_OK
      last = handle%system%effects%n_reaction_wheels + 3*int(sphere)
      associate (state => handle%run%state, inertia => handle%system%effects%wheels(last)%inertia)
         associate (h => state%wheel_momentum(last - 2:last))
            if (present(rate)) rate = h/inertia - angular_velocity(handle%system, state)
            if (present(momentum)) momentum = rotate_to_space(quat_normalized(state%q), h)
            if (present(energy)) energy = 0.5_wp*dot_product(h/inertia, h)
         end associate
         if (present(work)) work = sum(state%wheel_work(2, last - 2:last))
      end associate
   end function nutate_stepper_sphere

   integer(c_int) function nutate_stepper_set_motor(stepper, wheel, torque) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      integer(c_size_t), intent(in), value :: wheel
      real(c_double), intent(in), value :: torque
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      if (.not. found(stepper, handle, code)) return
      call check_motor(handle%system%effects, wheel, torque, status)
      if (status%ok()) call prepare_if_needed(handle, status)
      if (status%ok()) call hold_torque(handle, int(wheel), torque)
      code = conclude(handle, status)
   end function nutate_stepper_set_motor

   !> Tests a motor torque. Errors: `NUTATE_BAD_ARGUMENT` for a wheel that does not exist, or that something else
   !> drives, and for a torque that is not finite, too large, or above its limit.
   subroutine check_motor(effects, wheel, torque, status)
      type(effect_list_t), intent(in) :: effects
      integer(c_size_t), intent(in) :: wheel
      !> Motor torque, N m.
      real(wp), intent(in) :: torque
      type(status_t), intent(out) :: status
      if (wheel < 1 .or. wheel > effects%n_reaction_wheels) then
         status = fail(NUTATE_BAD_ARGUMENT, 'wheel is out of range (expected 1 to the number of wheels)', 'wheel')
      else if (effects%controls_wheels()) then
         status = fail(NUTATE_BAD_ARGUMENT, 'a controller drives the wheels (expected none by wheels)', 'wheel')
      else if (allocated(effects%wheels(wheel)%motor)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the wheel already has a motor (expected a wheel without one)', 'wheel')
      else if (.not. is_moderate(torque)) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the torque is not finite or too large', 'torque')
      else if (abs(torque) > effects%wheels(wheel)%torque_limit) then
         status = fail(NUTATE_BAD_ARGUMENT, 'the torque is above the limit of the wheel', 'torque')
      end if
   end subroutine check_motor

   !> Makes a motor hold a torque from now on; states inside the last step are no longer available.
   subroutine hold_torque(handle, wheel, torque)
      !> Prepared stepper.
      type(stepper_handle_t), intent(inout) :: handle
      integer, intent(in) :: wheel
      !> Motor torque, N m.
      real(wp), intent(in) :: torque
      if (.not. allocated(handle%given)) allocate (handle%given, source=handle%system%effects)
      handle%system%effects%wheels(wheel)%command = torque
      call handle%run%release()
      call handle%run%stepper%update_commands()
      handle%run%stepper%last_length = 0.0_wp
      handle%plain = .false.
      if (allocated(handle%run%events)) call handle%run%events%set_system(handle%system)
   end subroutine hold_torque

   integer(c_int) function nutate_stepper_jacobi(stepper, jacobi) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: jacobi
      type(stepper_handle_t), pointer :: handle
      type(status_t) :: status
      real(wp) :: energy
      call find_readable(stepper, present(jacobi), .true., handle, code)
      if (code /= NUTATE_OK) return
      handle%failure = 0
      energy = conserved_energy(handle%system, handle%run%state, handle%run%requested%inverse_auxiliary_inertia)
      call add_failure(handle%failure, status)
      if (status%ok()) jacobi = energy
      code = conclude(handle, status)
   end function nutate_stepper_jacobi

   integer(c_int) function nutate_stepper_time_dependent_work(stepper, work) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: work
      type(stepper_handle_t), pointer :: handle
      call find_readable(stepper, present(work), .false., handle, code)
      if (code == NUTATE_OK) work = handle%run%state%time_dependent_work
   end function nutate_stepper_time_dependent_work

   integer(c_int) function nutate_stepper_orbit(stepper, position, true_anomaly) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: position(3), true_anomaly
      type(stepper_handle_t), pointer :: handle
      call find_on_orbit(stepper, .false., handle, code)
      if (code /= NUTATE_OK) return
      associate (path => handle%system%effects%orbit%path, t => handle%run%state%t)
         if (present(position)) position = path%position(t)
         if (present(true_anomaly)) true_anomaly = path%true_anomaly(t)
      end associate
   end function nutate_stepper_orbit

   integer(c_int) function nutate_stepper_lvlh_attitude(stepper, q, angles) result(code) bind(C)
      type(c_ptr), intent(in), value :: stepper
      real(c_double), intent(inout), optional :: q(4), angles(3)
      type(stepper_handle_t), pointer :: handle
      real(wp) :: relative(4)
      call find_on_orbit(stepper, .true., handle, code)
      if (code /= NUTATE_OK) return
      associate (state => handle%run%state)
         relative = quat_product(quat_conjugate(handle%system%effects%orbit%axes(state%t)), state%q)
      end associate
      if (present(q)) q = relative
      if (present(angles)) angles = roll_pitch_yaw_from_quat(relative)
   end function nutate_stepper_lvlh_attitude

   !> Finds a stepper whose body is on an orbit.
   subroutine find_on_orbit(stepper, needs_attitude, handle, code)
      type(c_ptr), intent(in) :: stepper
      logical, intent(in) :: needs_attitude
      type(stepper_handle_t), pointer, intent(out) :: handle
      !> Status code of `find_readable`; `NUTATE_BAD_ARGUMENT` without an orbit.
      integer(c_int), intent(out) :: code
      call find_readable(stepper, .true., needs_attitude, handle, code)
      if (code /= NUTATE_OK) return
      if (.not. handle%system%effects%on_orbit) code = NUTATE_BAD_ARGUMENT
   end subroutine find_on_orbit

end module nutate_c_wheels
